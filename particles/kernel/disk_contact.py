"""When a tracer in a field first touches a disk: the first root of a quartic.

In a field g along x, and from the centre of the disk, the tracer is at (x + vx t + g t^2/2, y +
vy t), and touches the disk where P = |r|^2 - 1 falls through 0. Half the second derivative of P is

    q(t) = 3/2 (vx + g t)^2 + v^2 + g x - 3/2 vx^2,

whose least value m over the time that is left is known at once. So P is nowhere below the parabola
P_k + 2 h_k s + m s^2 that touches it at the present time t_k, nor its first root before that of the
parabola. Going from one such root to the next, the tracer comes near the first contact from before,
quadratically, and cannot pass it; where the parabola has no root, there is no contact.
"""

from math import sqrt

from numba import njit

from particles.events import MOST_STEPS, NEVER
from particles.kernel.parabola import SMALLEST_STEP

# How a tracer and a disk are to each other when its flight begins.
APART = 0  # not in contact as far as is known
STRUCK = 1  # on the disk and leaving
TANGENT = 2  # on the disk and leaving without normal velocity


@njit(error_model="numpy")
def contact_in_field(
    place: tuple[float, float],
    velocity: tuple[float, float],
    field: float,
    limit: float,
    contact: int,
) -> float:
    """Return the time of the first contact with a disk, NEVER if it is not before `limit`.

    Parameters
    ----------
    place : from the centre of the disk, whose radius is 1
    velocity : at this place
    field : acceleration along x
    limit : time after which contacts do not count
    contact : APART, STRUCK or TANGENT; in the last two cases it is the next contact that is sought.
        A tracer that is APART and by rounding not outside collides at once if it moves inwards
    """
    x, y = place
    vx, vy = velocity
    if contact == TANGENT:
        return _contact_after_tangent(x, velocity, field, limit)
    t = 0.0
    p = x * x + y * y - 1.0
    h = x * vx + y * vy  # half the derivative of P
    is_on_disk = contact == STRUCK or p <= 0.0
    if is_on_disk:
        if contact == APART and h < 0.0:
            return 0.0
        p = 0.0
        h = max(h, 0.0)
    curvature = vx * vx + vy * vy + field * x
    initial_h = h
    final_vx = vx + field * limit
    for _ in range(MOST_STEPS):  # two in the mean; some hundreds for contacts that graze
        present_vx = vx + field * t
        turns = present_vx * final_vx <= 0.0
        least_vx = 0.0 if turns else min(abs(present_vx), abs(final_vx))
        m = 1.5 * least_vx * least_vx + (curvature - 1.5 * vx * vx)
        discriminant = h * h - m * p
        if discriminant < 0.0 or (h >= 0.0 and m >= 0.0):
            return NEVER
        root = sqrt(discriminant)
        step = p / (root - h) if h < 0.0 else (h + root) / -m
        t += step
        if not t <= limit:
            return NEVER
        if is_on_disk:
            # P without its root at 0, which is known: exact for bounces of any height.
            a = 0.25 * field * field
            b = field * vx
            p = t * (((a * t + b) * t + curvature) * t + 2.0 * initial_h)
            h = ((2.0 * a * t + 1.5 * b) * t + curvature) * t + initial_h
        else:
            rx = x + (vx + 0.5 * field * t) * t
            ry = y + vy * t
            p = rx * rx + ry * ry - 1.0
            h = rx * (vx + field * t) + ry * vy
        if p <= 0.0 or step <= SMALLEST_STEP * t:
            return t
    return t


@njit(error_model="numpy")
def _contact_after_tangent(
    x: float, velocity: tuple[float, float], field: float, limit: float
) -> float:
    """Return the time of the next contact with a disk that is left without normal velocity."""
    vx, vy = velocity
    # P = t^2 (opening + growth t + (field t)^2/4)
    opening = vx * vx + vy * vy + field * x
    growth = field * vx
    discriminant = growth * growth - field * field * opening
    if growth >= 0.0 or discriminant < 0.0:
        return NEVER
    t = 2.0 * max(opening, 0.0) / (sqrt(discriminant) - growth)
    return t if t <= limit else NEVER
