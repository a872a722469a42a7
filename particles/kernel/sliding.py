"""How a tracer in a field slides along a disk, and where that ends.

A tracer that a field presses on a disk with the acceleration a_n, and that leaves it with the
normal velocity v_n, comes back after 2 v_n/a_n; for e < 1 infinitely many such bounces end. Where
v_n^2/(2 a_n) < SMALL d, v_n becomes 0 (`corner.is_sliding`). For et = 1 the tracer slides without
friction (`slide_motion`): it leaves where a_n = -g cos(phi) - phi'^2 is no longer positive, that is
with theta from the top of the disk where cos(theta) = 2k/3, k = cos(theta_0) + v_0^2/(2 g d). For
et < 1 the bounces take the tangential velocity too: the tracer is trapped where it is.

Begin reading with `slide`.
"""

from math import acos, asin, atan2, copysign, cos, pi, sin, sqrt

import numpy as np

from particles import outputs
from particles.cells import SLOTS, Cells, next_listed
from particles.compiled import called
from particles.kernel.cell_walk import SHORT, enter_cell_in_plane
from particles.kernel.corner import FALLS, RESTS, settle_in_corner
from particles.kernel.disk_contact import TANGENT
from particles.kernel.falling import FallingTracer, place_from_start, x_from_start
from particles.kernel.records import Records, queue_in_field
from particles.kernel.slide_motion import (
    ANGLE,
    COSINE,
    DERIVATIVE,
    ORDER,
    STEP,
    expand,
    motion_at,
    time_at,
)

#: An angle that is farther than any angle ahead.
NO_ANGLE = 4.0 * pi

# How a slide over an angle ends.
GOES_ON = 0  # it has not ended
REACHED = 1  # the tracer has passed the angle
TURNED = 2  # it turns before
ENDED = 3  # the run ends before


@called
def _angle_ahead(angle: float, present: float, sense: float) -> float:
    """Return how far an angle is ahead of the present one, the sense (+1 or -1) of its motion.

    One that has been passed by less than SHORT, by rounding, is reached at once.
    """
    ahead = sense * (angle - present) % (2.0 * pi)
    return 0.0 if ahead > 2.0 * pi - SHORT else ahead


@called
def _wall_ahead(
    tracer: FallingTracer, side: float, present: float, sense: float
) -> tuple[float, int, int]:
    """Return (angle to the first cell wall, step to the next cell there) along the disk struck.

    The angle is NO_ANGLE where there is no wall ahead.

    Parameters
    ----------
    side : of a cell
    present : angle of the normal
    sense : +1 or -1
    """
    nearest = NO_ANGLE
    di = 0
    dj = 0
    for sign in (1, -1):
        # Only where the tracer goes outwards through the wall.
        cosine = sign * 0.5 * side - tracer.struck_x
        if abs(cosine) < 1.0:
            ahead = _angle_ahead(-sense * sign * acos(cosine), present, sense)
            if ahead < nearest:
                nearest = ahead
                di = sign
                dj = 0
        sine = sign * 0.5 * side - tracer.struck_y
        if abs(sine) < 1.0:
            angle = asin(sine)
            ahead = _angle_ahead(angle if sense * sign > 0.0 else pi - angle, present, sense)
            if ahead < nearest:
                nearest = ahead
                di = 0
                dj = sign
    return nearest, di, dj


@called
def _disk_ahead(
    tracer: FallingTracer, cells: Cells, present: float, sense: float
) -> tuple[float, float, float]:
    """Return (angle to the first disk ahead along the disk struck, or NO_ANGLE; its centre).

    present: angle of the normal. sense: +1 or -1.
    """
    nearest = NO_ANGLE
    disk_x = 0.0
    disk_y = 0.0
    slot = 0
    node = cells.head[tracer.cell]
    while slot < SLOTS or node >= 0:
        cx, cy, _cz, slot, node = next_listed(cells, tracer.cell, slot, node)
        dx = cx - tracer.struck_x
        dy = cy - tracer.struck_y
        distance2 = dx * dx + dy * dy
        if SHORT * SHORT < distance2 < 4.0:
            angle = atan2(dy, dx) - sense * acos(0.5 * sqrt(distance2))
            ahead = _angle_ahead(angle, present, sense)
            if ahead < nearest:
                nearest = ahead
                disk_x = cx
                disk_y = cy
    return nearest, disk_x, disk_y


@called
def _leaving_ahead(present: float, along: float, sense: float, field: float) -> float:
    """Return the angle to where the disk curves away from under a tracer.

    along: velocity, as d(angle)/dt. If the tracer turns before, it does not come to this place.
    """
    height = (2.0 * field * cos(present) - along * along) / (3.0 * field)
    angle = acos(min(max(height, -1.0), 1.0))
    return _angle_ahead(-sense * copysign(1.0, field) * angle, present, sense)


@called
def _record_passage_on_disk(
    tracer: FallingTracer, series: np.ndarray, duration: float, field: float, side: float,
    records: Records,
) -> None:  # fmt: skip
    """Record when x first has the value depth in a step of a slide; duration: in sqrt(d/g)."""
    if records.passages[tracer.number] != np.inf:
        return
    towards = copysign(1.0, field)
    cosine = records.depth - x_from_start(tracer, tracer.struck_x, side)
    if towards * (cos(motion_at(series, duration)[0]) - cosine) >= 0.0:
        reaches = 0.0
        if towards * (cos(series[0, 0]) - cosine) < 0.0:
            reaches = time_at(series, duration, cosine, COSINE)
        records.passages[tracer.number] = tracer.time + reaches / sqrt(abs(field))


@called
def _slide_over(
    tracer: FallingTracer, distance: float, field: float, side: float, records: Records
) -> int:
    """Let a tracer slide over an angle, or to where it turns or the run ends.

    Return REACHED, TURNED or ENDED.
    """
    series = np.empty((3, ORDER + 1))
    angle = atan2(tracer.normal_y, tracer.normal_x)
    # From here on in sqrt(g d) and sqrt(d/g).
    pace = sqrt(abs(field))
    towards = copysign(1.0, field)
    along = (tracer.normal_x * tracer.vy - tracer.normal_y * tracer.vx) / pace
    sense = copysign(1.0, along if along != 0.0 else -towards * tracer.normal_y)
    end = angle + sense * distance
    n_times = records.times.size
    while True:
        if tracer.output == n_times and n_times > 0:
            return ENDED
        expand(angle, along, towards, series)
        duration = STEP
        outcome = GOES_ON
        next_angle, next_along = motion_at(series, STEP)
        if sense * next_along < 0.0:
            outcome = TURNED
            duration = time_at(series, duration, 0.0, DERIVATIVE)
            next_angle = motion_at(series, duration)[0]
            next_along = 0.0
        if sense * (next_angle - end) >= 0.0:
            outcome = REACHED
            duration = time_at(series, duration, end, ANGLE) if distance > 0.0 else 0.0
            next_angle = end
            next_along = motion_at(series, duration)[1]
        is_due = tracer.output < n_times and tracer.time + duration / pace >= tracer.next_output
        if is_due:
            outcome = GOES_ON
            duration = max(tracer.next_output - tracer.time, 0.0) * pace
            next_angle, next_along = motion_at(series, duration)
        if records.passages.size:
            _record_passage_on_disk(tracer, series, duration, field, side, records)
        tracer.travelled += abs(next_angle - angle)
        tracer.time += duration / pace
        angle = next_angle
        along = next_along
        _put_on_disk(tracer, angle, along * pace)
        if is_due:
            place_from_start(tracer, side)
            queue_in_field(tracer, records, field)
        if outcome != GOES_ON:
            return outcome


@called
def _put_on_disk(tracer: FallingTracer, angle: float, along: float) -> None:
    """Put a tracer at an angle on the disk struck, with a velocity along it."""
    nx = cos(angle)
    ny = sin(angle)
    tracer.normal_x = nx
    tracer.normal_y = ny
    tracer.x = tracer.struck_x + nx
    tracer.y = tracer.struck_y + ny
    tracer.vx = -along * ny
    tracer.vy = along * nx


@called
def slide(
    tracer: FallingTracer, cells: Cells, law: tuple[float, float], field: float, records: Records
) -> int:
    """Let a tracer slide from the disk struck on until it flies again; return its status then."""
    side = cells.side
    while True:
        if law[1] < 1.0:
            return outputs.TRAPPED
        angle = atan2(tracer.normal_y, tracer.normal_x)
        along = tracer.normal_x * tracer.vy - tracer.normal_y * tracer.vx
        pull = -field * tracer.normal_y
        if along == 0.0 and pull == 0.0:
            return outputs.TRAPPED  # balanced on the top
        sense = copysign(1.0, along if along != 0.0 else pull)
        to_leaving = _leaving_ahead(angle, along, sense, field)
        to_wall, di, dj = _wall_ahead(tracer, side, angle, sense)
        to_disk, disk_x, disk_y = _disk_ahead(tracer, cells, angle, sense)
        distance = min(to_leaving, to_wall, to_disk)
        outcome = _slide_over(tracer, distance, field, side, records)
        if outcome == ENDED:
            return outputs.FINISHED
        if outcome == TURNED:
            continue
        if to_disk <= min(to_leaving, to_wall):
            motion = settle_in_corner(tracer, disk_x, disk_y, law, field)
            if motion == RESTS:
                return outputs.TRAPPED
            if motion == FALLS:
                return outputs.RUNNING
        elif to_wall <= to_leaving:
            tracer.x -= di * side
            tracer.y -= dj * side
            tracer.struck_x -= di * side
            tracer.struck_y -= dj * side
            tracer.cell = enter_cell_in_plane(tracer, cells.shape[0], di, dj)
        else:
            tracer.touches = TANGENT
            return outputs.RUNNING
