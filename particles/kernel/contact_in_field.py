"""When a tracer on a parabola first touches a disk: the first root of a quartic.

In a uniform field g along x, and from the centre of the disk, the tracer is at
(x + vx t + g t^2/2, y + vy t), and touches the disk where P = |r|^2 - 1 falls through 0. Half the
second derivative of P is

    q(t) = 3/2 (vx + g t)^2 + v^2 + g x - 3/2 vx^2,

whose least value m over the time that is left is known at once. So P is nowhere below the parabola
P_k + 2 h_k s + m s^2 that touches it at the present time t_k, and the first root of P is not before
the first root of that parabola. Going from one such root to the next, the tracer comes near the
first contact from before, quadratically, and cannot pass it; where the parabola has no root, there
is no contact.
"""

from math import sqrt

from numba import njit

from particles.compiled.decorators import called
from particles.events import NEVER

# A step of the time that is this small in proportion is rounding.
SMALLEST_STEP = 4e-16
MOST_STEPS = 10_000  # two in the mean; up to some hundreds for contacts that graze
# How a tracer and a disk are to each other when its flight begins: not in contact as far as is
# known, on it and leaving, or on it and leaving without normal velocity.
APART, STRUCK, TANGENT = range(3)


@called
def _next_of_tangent(opening: float, growth: float, field: float, limit: float) -> float:
    """Return the first contact after 0 where P = t^2 (opening + growth t + (field t)^2/4)."""
    inside = growth * growth - field * field * opening
    if growth >= 0.0 or inside < 0.0:
        return NEVER
    t = 2.0 * max(opening, 0.0) / (sqrt(inside) - growth)
    return t if t <= limit else NEVER


@njit(error_model="numpy")
def contact_in_field(
    place: tuple[float, float], velocity: tuple[float, float], field: float, limit: float,
    before: int,
) -> float:  # fmt: skip
    """Return the time of the first contact with a disk, NEVER if it is not before `limit`.

    place: from the centre of the disk, whose radius is 1; velocity; field: along x, of either sign.
    before: APART, STRUCK or TANGENT; in the last two cases the contact sought is the next one. A
    tracer that is APART and by rounding not outside collides at once if it moves inwards.
    """
    x, y = place
    vx, vy = velocity
    if before == TANGENT:
        return _next_of_tangent(vx * vx + vy * vy + field * x, field * vx, field, limit)
    t, p, h = 0.0, x * x + y * y - 1.0, x * vx + y * vy
    on_disk = before == STRUCK or p <= 0.0
    if on_disk:
        if before == APART and h < 0.0:
            return 0.0
        p, h = 0.0, max(h, 0.0)
    square = vx * vx + vy * vy + field * x
    base, rise = square - 1.5 * vx * vx, h
    end = vx + field * limit
    for _ in range(MOST_STEPS):
        now = vx + field * t
        least = 0.0 if now * end <= 0.0 else min(abs(now), abs(end))
        m = 1.5 * least * least + base
        inside = h * h - m * p
        if inside < 0.0 or (h >= 0.0 and m >= 0.0):
            return NEVER
        root = sqrt(inside)
        step = p / (root - h) if h < 0.0 else (h + root) / -m
        t += step
        if not t <= limit:
            return NEVER
        if on_disk:
            # P without its root at 0, which is known: exact for bounces of any height.
            a, b = 0.25 * field * field, field * vx
            p = t * (((a * t + b) * t + square) * t + 2.0 * rise)
            h = ((2.0 * a * t + 1.5 * b) * t + square) * t + rise
        else:
            ahead, across = x + (vx + 0.5 * field * t) * t, y + vy * t
            p = ahead * ahead + across * across - 1.0
            h = ahead * (vx + field * t) + across * vy
        if p <= 0.0 or step <= SMALLEST_STEP * t:
            return t
    return t
