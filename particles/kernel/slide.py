"""A tracer that slides along a disk in a field, from where it begins to slide to where it ends.

The angle phi of the normal from the direction of x obeys phi'' = -g sin(phi), the equation of a
pendulum. It is followed by its Taylor series, in steps so short that the series is exact to
rounding. The rules of what begins and ends a slide are in `particles.kernel.sliding`.
"""

from math import atan2, copysign, cos, sin, sqrt
from typing import Any

import numpy as np

from particles.cells import Cells
from particles.compiled import called
from particles.kernel import columns
from particles.kernel.falling import TANGENT, come_along, note_place
from particles.kernel.lane import RUNNING
from particles.kernel.records import QUEUE, Records, enter_queue, queue_falling
from particles.kernel.sliding import (
    FALLS,
    RESTS,
    disk_ahead,
    leaving_ahead,
    settle,
    wall_ahead,
)
from particles.kernel.steps import enter

# The terms fall as (STEP / 1.5)^k or faster, times in sqrt(d/g): a slide is slower than sqrt(g d).
ORDER = 18
STEP = 0.25
BISECTIONS = 200
REACHED, TURNED, ENDED = range(3)


@called
def expand(angle: float, along: float, field: float, work: np.ndarray) -> None:
    """Expand the angle in powers of the time. work (3, ORDER + 1): row 0 receives the terms.

    field: 1 or -1. Times are in sqrt(d/g), in which no power of a strong field overflows.
    """
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
def at(work: np.ndarray, t: float) -> tuple[float, float]:
    """Return the angle and its derivative after a time t."""
    angle, along = work[0, ORDER], 0.0
    for k in range(ORDER - 1, -1, -1):
        along = along * t + angle
        angle = angle * t + work[0, k]
    return angle, along


@called
def when(work: np.ndarray, longest: float, value: float, kind: int) -> float:
    """Return when the angle (kind 0), its derivative (1) or its cosine (2) has a value.

    It passes the value once before `longest`. Regula falsi between bounds, or bisection.
    """
    low, high = 0.0, longest
    below = _excess(work, low, value, kind)
    above = _excess(work, high, value, kind)
    for k in range(BISECTIONS):
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
    angle, along = at(work, t)
    if kind == 2:
        angle = cos(angle)
    return (along if kind == 1 else angle) - value


@called
def _put(lane: Any, angle: float, along: float) -> None:
    """Give a lane its place and velocity on disk `struck`."""
    nx, ny = cos(angle), sin(angle)
    lane.normal_x, lane.normal_y = nx, ny
    lane.x, lane.y = lane.struck_x + nx, lane.struck_y + ny
    lane.vx, lane.vy = -along * ny, along * nx


@called
def _note_passage(
    lane: Any, work: np.ndarray, lasts: float, records: Records, field: float, side: float
) -> None:
    """Note when x first has the value depth, if it comes to it in this step."""
    if not records.passages.size or records.passages[lane.tracer] < np.inf:
        return
    height = records.depth - come_along(lane, lane.struck_x, side)
    towards = copysign(1.0, field)
    if towards * (cos(at(work, lasts)[0]) - height) >= 0.0:
        begun = towards * (cos(work[0, 0]) - height) >= 0.0
        after = 0.0 if begun else when(work, lasts, height, 2)
        records.passages[lane.tracer] = lane.time + after / sqrt(abs(field))


@called
def roll(lane: Any, left: float, field: float, side: float, records: Records) -> int:
    """Let a lane slide along disk `struck` over an angle, or to where it turns or the run ends."""
    times, queue, queued = records.times, records.queue, records.queued
    work = np.empty((3, ORDER + 1))
    angle = atan2(lane.normal_y, lane.normal_x)
    # From here on in sqrt(g d) and sqrt(d/g).
    pace, towards = sqrt(abs(field)), copysign(1.0, field)
    along = (lane.normal_x * lane.vy - lane.normal_y * lane.vx) / pace
    way = copysign(1.0, along if along != 0.0 else -towards * lane.normal_y)
    last = angle + way * left
    while True:
        if lane.output == times.size and times.size > 0:
            return ENDED
        expand(angle, along, towards, work)
        lasts, outcome, after = STEP, -1, at(work, STEP)
        if way * after[1] < 0.0:
            lasts, outcome = when(work, lasts, 0.0, 1), TURNED
            after = at(work, lasts)[0], 0.0
        if way * (after[0] - last) >= 0.0:
            lasts, outcome = when(work, lasts, last, 0) if left > 0.0 else 0.0, REACHED
            after = last, at(work, lasts)[1]
        due = lane.output < times.size and lane.time + lasts / pace >= lane.next_output
        if due:
            lasts, outcome = max(lane.next_output - lane.time, 0.0) * pace, -1
            after = at(work, lasts)
        _note_passage(lane, work, lasts, records, field, side)
        lane.travelled += abs(after[0] - angle)
        lane.time += lasts / pace
        angle, along = after
        _put(lane, angle, along * pace)
        if due:
            note_place(lane, side)
            if queued[0] == QUEUE:
                enter_queue(records)
            queue_falling(lane, queue[queued[0]], times, field)
            queued[0] += 1
        if outcome >= 0:
            return outcome


@called
def slide(lane: Any, cells: Cells, law: tuple[float, float], field: float, records: Records) -> int:
    """Let a lane slide from disk `struck` on until it flies again. Return its status then."""
    side = cells.side
    while True:
        if law[1] < 1.0:
            return columns.TRAPPED
        now = atan2(lane.normal_y, lane.normal_x)
        along = lane.normal_x * lane.vy - lane.normal_y * lane.vx
        pull = -field * lane.normal_y
        if along == 0.0 and pull == 0.0:
            return columns.TRAPPED  # balanced on the top
        way = copysign(1.0, along if along != 0.0 else pull)
        leaves = leaving_ahead(now, along, way, field)
        wall, di, dj = wall_ahead(lane, side, now, way)
        disk, cx, cy = disk_ahead(lane, cells, now, way)
        outcome = roll(lane, min(leaves, wall, disk), field, side, records)
        if outcome == ENDED:
            return columns.FINISHED
        if outcome == TURNED:
            continue
        if disk <= min(leaves, wall):
            outcome = settle(lane, cx, cy, law, field)
            if outcome == RESTS:
                return columns.TRAPPED
            if outcome == FALLS:
                return RUNNING
        elif wall <= leaves:
            lane.x -= di * side
            lane.y -= dj * side
            lane.struck_x -= di * side
            lane.struck_y -= dj * side
            enter(lane, cells.shape, di, dj, 0)
        else:
            lane.before = TANGENT
            return RUNNING
