"""What follows infinitely many bounces in a field: sliding along a disk, leaving it, rest.

A tracer that a field presses on a disk with the acceleration a_n, and that leaves it with the
normal velocity v_n, comes back after 2 v_n/a_n; for e < 1 infinitely many such bounces end.

Sliding. Where v_n^2/(2 a_n) < SMALL d, v_n becomes 0. For et = 1 the tracer slides without
friction: with phi the angle of the normal from the direction of x, phi'' = -g sin(phi), and it
leaves where a_n = -g cos(phi) - phi'^2 is no longer positive, that is with theta from the top of
the disk where cos(theta) = 2k/3, k = cos(theta_0) + v_0^2/(2 g d). For et < 1 the bounces take the
tangential velocity too: the tracer is trapped where it is.

Corners of two disks that overlap. The bounces between the two are followed one by one; they take no
time. Where the velocity falls to SMALL of what it was the tracer comes to rest. If -g is between
the two normals, it is trapped as soon as v^2/2 < SMALL |g| d; else it slides along the disk that
the field lets it slide along, or falls.
"""

from math import acos, asin, atan2, copysign, cos, pi, sin, sqrt
from typing import Any

import numpy as np

from particles import outputs
from particles.cells import NEAR, SLOTS, Cells, next_listed
from particles.compiled import called
from particles.events import MOST_STEPS, bounce, is_collapsing
from particles.kernel.falling import STRUCK, TANGENT, come_along, note_place
from particles.kernel.records import Records, queue_falling
from particles.kernel.steps import SHORT, enter

SMALL = 1e-12
FALLS, SLIDES, RESTS = range(3)
# The motion along a disk is a Taylor series, exact to rounding in steps that are short enough: the
# terms fall as (STEP / 1.5)^k or faster, times in sqrt(d/g): a slide is slower than sqrt(g d).
ORDER = 18
STEP = 0.25
GOES_ON, REACHED, TURNED, ENDED = range(4)
ANGLE, DERIVATIVE, COSINE = range(3)  # of the normal: what may be asked for


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
def _bounce_in_corner(
    lane: Any, one: tuple[float, float], other: tuple[float, float], law: tuple[float, float]
) -> bool:
    """Bounce between disks of these normals until that ends; tell whether the last is the other."""
    (ax, ay), (bx, by) = one, other
    begun = lane.vx * lane.vx + lane.vy * lane.vy
    on_other = True
    for _ in range(MOST_STEPS):
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
    return on_other


@called
def _settle(lane: Any, cx: float, cy: float, law: tuple[float, float], field: float) -> int:
    """Let a lane that is on disk `struck` meet the disk at (cx, cy) in their corner.

    Return FALLS, SLIDES or RESTS; the lane is then on the disk that this is about.
    """
    one = lane.x - lane.struck_x, lane.y - lane.struck_y
    dx, dy = lane.x - cx, lane.y - cy
    per = 1.0 / sqrt(dx * dx + dy * dy)
    other = dx * per, dy * per
    on_other, outcome = _bounce_in_corner(lane, one, other, law), FALLS
    square = lane.vx * lane.vx + lane.vy * lane.vy
    # -g is between the normals if it is alpha one + beta other, both positive: by Cramer's rule.
    turn = field * (one[0] * other[1] - one[1] * other[0])
    between = one[1] * turn > 0.0 > other[1] * turn
    if square <= 2.0 * SMALL * abs(field) and between:
        outcome = RESTS
    else:
        for there in (on_other, not on_other):
            on, off = (other, one) if there else (one, other)
            along = on[0] * lane.vy - on[1] * lane.vx
            if square == 0.0:
                along = -field * on[1]
            free = along * (on[0] * off[1] - on[1] * off[0]) >= 0.0
            leaving = max(lane.vx * on[0] + lane.vy * on[1], 0.0)
            if free and is_sliding(on, (lane.vx, lane.vy), leaving, field):
                on_other, outcome = there, SLIDES
                break
    lane.normal_x, lane.normal_y = one
    if on_other:
        lane.struck_x, lane.struck_y = cx, cy
        lane.x, lane.y = cx + other[0], cy + other[1]
        lane.normal_x, lane.normal_y = other
    leaving = lane.vx * lane.normal_x + lane.vy * lane.normal_y
    lane.before = STRUCK if leaving > 0.0 else TANGENT
    return outcome


@called
def after_short_flight(
    lane: Any, before: tuple[float, float], cells: Cells, law: tuple[float, float], field: float
) -> int:
    """End bounces in a corner that without the field would never end: FALLS, SLIDES or RESTS."""
    square = lane.vx * lane.vx + lane.vy * lane.vy
    if square <= abs(field) * 1e3 * SHORT:
        return FALLS  # where the field bends flights that are so short, they are followed
    per = 1.0 / sqrt(square)
    direction = lane.vx * per, lane.vy * per
    if not is_collapsing(before, (lane.normal_x, lane.normal_y), direction, law[0], law[1]):
        return FALLS
    at_x, at_y, least = 0.0, 0.0, 1.0 + NEAR  # of the other disk of the corner
    slot, node = 0, cells.head[lane.cell]
    while slot < SLOTS or node >= 0:
        cx, cy, _, slot, node = next_listed(cells, lane.cell, slot, node)
        dx, dy = lane.x - cx, lane.y - cy
        apart = max(abs(cx - lane.struck_x), abs(cy - lane.struck_y))
        if apart > SHORT and dx * dx + dy * dy < least * least:
            at_x, at_y, least = cx, cy, sqrt(dx * dx + dy * dy)
    if least == 1.0 + NEAR:
        return FALLS
    lane.vx = lane.vy = 0.0
    return _settle(lane, at_x, at_y, law, field)


@called
def _ahead(angle: float, now: float, way: float) -> float:
    """Return how far an angle is ahead, the way (+1 or -1) that a tracer slides.

    One that has been passed by less than SHORT, by rounding, is reached at once.
    """
    left = way * (angle - now) % (2.0 * pi)
    return 0.0 if left > 2.0 * pi - SHORT else left


@called
def _wall_ahead(lane: Any, side: float, now: float, way: float) -> tuple[float, int, int]:
    """Return (angle to the first cell wall, step to the next cell there) along disk `struck`.

    now: angle of the normal. way: +1 or -1. The angle is 4 pi where there is no wall ahead.
    """
    left, di, dj = 4.0 * pi, 0, 0
    for sign in (1, -1):
        # Only where the tracer goes outwards through the wall.
        along, across = sign * 0.5 * side - lane.struck_x, sign * 0.5 * side - lane.struck_y
        if abs(along) < 1.0:
            there = _ahead(-way * sign * acos(along), now, way)
            if there < left:
                left, di, dj = there, sign, 0
        if abs(across) < 1.0:
            angle = asin(across)
            there = _ahead(angle if way * sign > 0.0 else pi - angle, now, way)
            if there < left:
                left, di, dj = there, 0, sign
    return left, di, dj


@called
def _disk_ahead(lane: Any, cells: Cells, now: float, way: float) -> tuple[float, float, float]:
    """Return (angle to the first disk in the way along disk `struck`, or 4 pi, its centre)."""
    left, at_x, at_y = 4.0 * pi, 0.0, 0.0
    slot, node = 0, cells.head[lane.cell]
    while slot < SLOTS or node >= 0:
        cx, cy, _, slot, node = next_listed(cells, lane.cell, slot, node)
        dx, dy = cx - lane.struck_x, cy - lane.struck_y
        square = dx * dx + dy * dy
        if SHORT * SHORT < square < 4.0:
            there = _ahead(atan2(dy, dx) - way * acos(0.5 * sqrt(square)), now, way)
            if there < left:
                left, at_x, at_y = there, cx, cy
    return left, at_x, at_y


@called
def _leaving_ahead(now: float, along: float, way: float, field: float) -> float:
    """Return the angle to where the disk curves away from under a tracer.

    along: velocity, as d(angle)/dt. If the tracer turns before, it does not come to this place.
    """
    height = (2.0 * field * cos(now) - along * along) / (3.0 * field)
    there = acos(min(max(height, -1.0), 1.0))
    return _ahead(-way * copysign(1.0, field) * there, now, way)


@called
def _expand(angle: float, along: float, field: float, work: np.ndarray) -> None:
    """Expand the angle in powers of the time in sqrt(d/g): row 0 of work; field: 1 or -1."""
    phi, sine, cosine = work[0], work[1], work[2]
    phi[0], phi[1] = angle, along
    sine[0], cosine[0] = sin(angle), cos(angle)
    for k in range(ORDER - 1):
        phi[k + 2] = -field * sine[k] / ((k + 1) * (k + 2))
        s = c = 0.0
        for j in range(k + 1):
            s += cosine[k - j] * (j + 1) * phi[j + 1]
            c -= sine[k - j] * (j + 1) * phi[j + 1]
        sine[k + 1], cosine[k + 1] = s / (k + 1), c / (k + 1)


@called
def _at(work: np.ndarray, t: float) -> tuple[float, float]:
    """Return the angle and its derivative after a time t."""
    angle, along = work[0, ORDER], 0.0
    for k in range(ORDER - 1, -1, -1):
        along = along * t + angle
        angle = angle * t + work[0, k]
    return angle, along


@called
def _when(work: np.ndarray, longest: float, value: float, kind: int) -> float:
    """Return when the ANGLE, its DERIVATIVE or its COSINE has a value, once before `longest`.

    Regula falsi between bounds, or bisection.
    """
    low, high = 0.0, longest
    below = _excess(work, low, value, kind)
    above = _excess(work, high, value, kind)
    for k in range(MOST_STEPS):
        t = low - below * (high - low) / (above - below)
        if k % 3 == 2 or not low < t < high:
            t = 0.5 * (low + high)
        if t in (low, high):
            break
        middle = _excess(work, t, value, kind)
        if middle == 0.0:
            return t
        if (middle < 0.0) == (below < 0.0):
            low, below = t, middle
        else:
            high, above = t, middle
    return high


@called
def _excess(work: np.ndarray, t: float, value: float, kind: int) -> float:
    angle, along = _at(work, t)
    if kind == COSINE:
        angle = cos(angle)
    return (along if kind == DERIVATIVE else angle) - value


@called
def _roll(lane: Any, left: float, field: float, side: float, records: Records) -> int:
    """Let a lane slide along disk `struck` over an angle, or to where it turns or the run ends."""
    work = np.empty((3, ORDER + 1))
    angle = atan2(lane.normal_y, lane.normal_x)
    # From here on in sqrt(g d) and sqrt(d/g).
    pace, towards = sqrt(abs(field)), copysign(1.0, field)
    along = (lane.normal_x * lane.vy - lane.normal_y * lane.vx) / pace
    way = copysign(1.0, along if along != 0.0 else -towards * lane.normal_y)
    last = angle + way * left
    while True:
        if lane.output == records.times.size and records.times.size > 0:
            return ENDED
        _expand(angle, along, towards, work)
        lasts, outcome, after = STEP, GOES_ON, _at(work, STEP)
        if way * after[1] < 0.0:
            lasts, outcome = _when(work, lasts, 0.0, DERIVATIVE), TURNED
            after = _at(work, lasts)[0], 0.0
        if way * (after[0] - last) >= 0.0:
            lasts, outcome = _when(work, lasts, last, ANGLE) if left > 0.0 else 0.0, REACHED
            after = last, _at(work, lasts)[1]
        due = lane.output < records.times.size and lane.time + lasts / pace >= lane.next_output
        if due:
            lasts, outcome = max(lane.next_output - lane.time, 0.0) * pace, GOES_ON
            after = _at(work, lasts)
        if records.passages.size and records.passages[lane.tracer] == np.inf:
            height = records.depth - come_along(lane, lane.struck_x, side)
            if towards * (cos(_at(work, lasts)[0]) - height) >= 0.0:
                begun = towards * (cos(work[0, 0]) - height) >= 0.0
                reaches = 0.0 if begun else _when(work, lasts, height, COSINE)
                records.passages[lane.tracer] = lane.time + reaches / pace
        lane.travelled += abs(after[0] - angle)
        lane.time += lasts / pace
        angle, along = after
        nx, ny = cos(angle), sin(angle)
        lane.normal_x, lane.normal_y = nx, ny
        lane.x, lane.y = lane.struck_x + nx, lane.struck_y + ny
        lane.vx, lane.vy = -along * pace * ny, along * pace * nx
        if due:
            note_place(lane, side)
            queue_falling(lane, records, field)
        if outcome != GOES_ON:
            return outcome


@called
def slide(lane: Any, cells: Cells, law: tuple[float, float], field: float, records: Records) -> int:
    """Let a lane slide from disk `struck` on until it flies again. Return its status then."""
    side = cells.side
    while True:
        if law[1] < 1.0:
            return outputs.TRAPPED
        now = atan2(lane.normal_y, lane.normal_x)
        along = lane.normal_x * lane.vy - lane.normal_y * lane.vx
        pull = -field * lane.normal_y
        if along == 0.0 and pull == 0.0:
            return outputs.TRAPPED  # balanced on the top
        way = copysign(1.0, along if along != 0.0 else pull)
        leaves = _leaving_ahead(now, along, way, field)
        wall, di, dj = _wall_ahead(lane, side, now, way)
        disk, cx, cy = _disk_ahead(lane, cells, now, way)
        outcome = _roll(lane, min(leaves, wall, disk), field, side, records)
        if outcome == ENDED:
            return outputs.FINISHED
        if outcome == TURNED:
            continue
        if disk <= min(leaves, wall):
            outcome = _settle(lane, cx, cy, law, field)
            if outcome == RESTS:
                return outputs.TRAPPED
            if outcome == FALLS:
                return outputs.RUNNING
        elif wall <= leaves:
            lane.x -= di * side
            lane.y -= dj * side
            lane.struck_x -= di * side
            lane.struck_y -= dj * side
            enter(lane, cells.shape, di, dj, 0)
        else:
            lane.before = TANGENT
            return outputs.RUNNING
