"""What follows infinitely many bounces in a field: sliding along a disk, leaving it, rest.

A tracer that a field presses on a disk with the acceleration a_n, and that leaves it with the
normal velocity v_n, comes back after 2 v_n/a_n; for e < 1 infinitely many such bounces end after
2 v_n/(a_n (1 - e)). What is declared:

Sliding. Where v_n^2/(2 a_n) < SMALL d, v_n becomes 0 and the tracer slides. For et = 1 it slides
without friction: with phi the angle of the normal from the direction of x, phi'' = -g sin(phi), and
it leaves where a_n = -g cos(phi) - phi'^2 is no longer positive, that is with theta from the top of
the disk where cos(theta) = 2k/3, k = cos(theta_0) + v_0^2/(2 g d). For et < 1 the bounces take the
tangential velocity too: the tracer is trapped where it is.

Corners of two disks that overlap. The bounces between the two are followed one by one; they take no
time. Where the velocity falls to SMALL of what it was, which is where infinitely many bounces would
follow, the tracer comes to rest. If -g is between the two normals, it is trapped as soon as
v^2/2 < SMALL |g| d; else it slides along the disk that the field lets it slide along, or falls.
"""

from math import acos, asin, atan2, copysign, cos, pi, sqrt
from typing import Any

from particles.cells import Cells, next_listed
from particles.compiled import called
from particles.events import bounce
from particles.kernel.falling import STRUCK, TANGENT
from particles.search import SLOTS

SMALL = 1e-12
SAME = 1e-9  # in d: centres nearer to each other than this are those of one disk
NEAR = 1e-8
BACK = 1e-9  # an angle that has been passed by less than this, by rounding, is reached at once
MOST_BOUNCES = 10_000
FALLS, SLIDES, RESTS = range(3)
# What ends a piece of a slide: the disk curves away, a cell wall, another disk.
LEAVES, WALL, CORNER = range(3)


@called
def is_sliding(
    normal: tuple[float, float], velocity: tuple[float, float], leaving: float, field: float
) -> bool:
    """Tell whether a tracer slides along a disk from now on.

    normal: unit, towards the tracer. leaving: the normal component of the velocity, not negative.
    """
    (nx, ny), (vx, vy) = normal, velocity
    along = nx * vy - ny * vx
    pressing = -field * nx - along * along
    if leaving * leaving < 2.0 * SMALL * pressing:
        return True
    # Against the field it will be pressed at the next moment.
    return leaving == 0.0 and field * vx < 0.0 and pressing > -SMALL * abs(field)


@called
def is_trap(one: tuple[float, float], other: tuple[float, float], field: float) -> bool:
    """Tell whether -g is between the two normals of a corner."""
    (ax, ay), (bx, by) = one, other
    turn = ax * by - ay * bx
    # -g = alpha a + beta b, by Cramer's rule.
    return -field * by * turn > 0.0 and field * ay * turn > 0.0


@called
def end_in_corner(
    lane: Any, one: tuple[float, float], other: tuple[float, float], law: tuple[float, float],
    field: float,
) -> tuple[int, bool]:  # fmt: skip
    """Bounce in the corner of two disks until that ends. Return what follows, and on which disk.

    one, other: the normals; the second result is True where what follows is on the other disk.
    """
    (ax, ay), (bx, by) = one, other
    begun = lane.vx * lane.vx + lane.vy * lane.vy
    on_other = True
    for _ in range(MOST_BOUNCES):
        square = lane.vx * lane.vx + lane.vy * lane.vy
        if square <= SMALL * SMALL * begun:
            lane.vx = lane.vy = 0.0
            break
        least = -1e-15 * sqrt(square)
        if lane.vx * bx + lane.vy * by < least:
            lane.vx, lane.vy, _n = bounce(lane.vx, lane.vy, bx, by, law)
            on_other = True
        elif lane.vx * ax + lane.vy * ay < least:
            lane.vx, lane.vy, _n = bounce(lane.vx, lane.vy, ax, ay, law)
            on_other = False
        else:
            break
        lane.collisions += 1
    square = lane.vx * lane.vx + lane.vy * lane.vy
    if square <= 2.0 * SMALL * abs(field) and is_trap(one, other, field):
        return RESTS, on_other
    for _ in range(2):
        on, off = (other, one) if on_other else (one, other)
        leaving = max(lane.vx * on[0] + lane.vy * on[1], 0.0)
        along = on[0] * lane.vy - on[1] * lane.vx
        if square == 0.0:
            along = -field * on[1]
        free = along * (on[0] * off[1] - on[1] * off[0]) >= 0.0
        if free and is_sliding(on, (lane.vx, lane.vy), leaving, field):
            return SLIDES, on_other
        on_other = not on_other
    return FALLS, on_other


@called
def touched(lane: Any, cells: Cells) -> tuple[bool, float, float]:
    """Return (whether there is one, centre) of a disk near a lane, besides that struck last."""
    found, at_x, at_y, least = False, 0.0, 0.0, 1.0 + NEAR
    cell = lane.cell
    node = cells.head[cell]
    slot = 0
    while slot < SLOTS or node >= 0:
        cx, cy, _, slot, node = next_listed(cells, cell, slot, node)
        dx, dy = lane.x - cx, lane.y - cy
        apart = max(abs(cx - lane.struck_x), abs(cy - lane.struck_y))
        if apart > SAME and dx * dx + dy * dy < least * least:
            found, at_x, at_y, least = True, cx, cy, sqrt(dx * dx + dy * dy)
    return found, at_x, at_y


@called
def settle(
    lane: Any, cx: float, cy: float, law: tuple[float, float], field: float
) -> int:  # fmt: skip
    """Let a lane that is on disk `struck` meet the disk at (cx, cy) in their corner.

    Return FALLS, SLIDES or RESTS; the lane is then on the disk that this is about.
    """
    one = lane.x - lane.struck_x, lane.y - lane.struck_y
    dx, dy = lane.x - cx, lane.y - cy
    per = 1.0 / sqrt(dx * dx + dy * dy)
    other = dx * per, dy * per
    outcome, on_other = end_in_corner(lane, one, other, law, field)
    if on_other:
        lane.struck_x, lane.struck_y = cx, cy
        lane.x, lane.y = cx + other[0], cy + other[1]
        lane.normal_x, lane.normal_y = other
    else:
        lane.normal_x, lane.normal_y = one
    leaving = lane.vx * lane.normal_x + lane.vy * lane.normal_y
    lane.before = STRUCK if leaving > 0.0 else TANGENT
    return outcome


@called
def _ahead(angle: float, now: float, way: float) -> float:
    """Return how far an angle is ahead, the way (+1 or -1) that a tracer slides."""
    left = way * (angle - now) % (2.0 * pi)
    return 0.0 if left > 2.0 * pi - BACK else left


@called
def wall_ahead(
    lane: Any, side: float, now: float, way: float
) -> tuple[float, int, int]:  # fmt: skip
    """Return (angle to the first cell wall, step to the next cell there) along disk `struck`.

    now: angle of the normal. way: +1 or -1. The angle is 4 pi where there is no wall ahead.
    """
    left, di, dj = 4.0 * pi, 0, 0
    for sign in (1, -1):
        # Only where the tracer goes outwards through the wall.
        height = sign * 0.5 * side - lane.struck_x
        if abs(height) < 1.0:
            there = _ahead(-way * sign * acos(height), now, way)
            if there < left:
                left, di, dj = there, sign, 0
        height = sign * 0.5 * side - lane.struck_y
        if abs(height) < 1.0:
            angle = asin(height)
            there = _ahead(angle if way * sign > 0.0 else pi - angle, now, way)
            if there < left:
                left, di, dj = there, 0, sign
    return left, di, dj


@called
def disk_ahead(
    lane: Any, cells: Cells, now: float, way: float
) -> tuple[float, float, float]:  # fmt: skip
    """Return (angle to the first disk in the way along disk `struck`, its centre).

    The angle is 4 pi where there is none.
    """
    left, at_x, at_y = 4.0 * pi, 0.0, 0.0
    cell = lane.cell
    node = cells.head[cell]
    slot = 0
    while slot < SLOTS or node >= 0:
        cx, cy, _, slot, node = next_listed(cells, cell, slot, node)
        dx, dy = cx - lane.struck_x, cy - lane.struck_y
        square = dx * dx + dy * dy
        if SAME * SAME < square < 4.0:
            there = _ahead(atan2(dy, dx) - way * acos(0.5 * sqrt(square)), now, way)
            if there < left:
                left, at_x, at_y = there, cx, cy
    return left, at_x, at_y


@called
def leaving_ahead(now: float, along: float, way: float, field: float) -> float:
    """Return the angle to where the disk curves away from under a tracer.

    along: velocity, as d(angle)/dt. If the tracer turns before, it does not come to this place.
    """
    height = (2.0 * field * cos(now) - along * along) / (3.0 * field)
    there = acos(min(max(height, -1.0), 1.0))
    return _ahead(-way * copysign(1.0, field) * there, now, way)
