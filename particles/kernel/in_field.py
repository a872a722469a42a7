"""The steps of a tracer on parabolas among disks, which `particles.kernel.follow_in_field` joins.

A lane holds the place in its cell and the velocity at its last node: a contact, a cell wall, or the
end of a slide. From there the parabola is followed to the next node.
"""

from math import copysign, sqrt
from typing import Any

import numpy as np

from particles.compiled.decorators import inlined
from particles.compiled.search import SLOTS, near_chord
from particles.events import NEVER, bounce
from particles.grid.blocks import is_unbounded, place
from particles.grid.cells import EMPTY
from particles.kernel.contact_in_field import APART, STRUCK, TANGENT, contact_in_field
from particles.kernel.in_plane import enter
from particles.kernel.lane import AT_REST
from particles.kernel.parabola import length_of, time_to_reach


@inlined
def begin(lane: Any, keys: np.ndarray, n: int, places: np.ndarray) -> None:
    """Put a tracer where it starts, with its initial velocity; places: of `Start`."""
    middle = n // 2
    lane.from_i = lane.from_j = 0
    lane.from_x = lane.from_y = 0.0
    if places.shape[0]:
        lane.from_i, lane.from_j = int(places[lane.tracer, 0]), int(places[lane.tracer, 1])
        lane.from_x, lane.from_y = places[lane.tracer, 2], places[lane.tracer, 3]
    lane.i, lane.j, lane.x, lane.y = lane.from_i, lane.from_j, lane.from_x, lane.from_y
    lane.stored_i, lane.stored_j = middle + lane.i, middle + lane.j
    lane.cell = lane.stored_i * n + lane.stored_j
    if is_unbounded(keys):
        lane.cell = place(lane.i, lane.j)
    lane.vx, lane.vy = lane.start_vx, lane.start_vy
    lane.before = APART
    begin_flight(lane)


@inlined
def begin_flight(lane: Any) -> None:
    """Note where on its parabola the flight of a lane begins."""
    lane.first_vx, lane.lasted = lane.vx, 0.0
    lane.crossed = 0


@inlined
def note_place(lane: Any, side: float) -> None:
    """Write down the place of a lane as seen from the start of its path."""
    lane.flight_x = come_along(lane, lane.x, side)
    lane.flight_y = (lane.j - lane.from_j) * side + (lane.y - lane.from_y)


@inlined
def come_along(lane: Any, x: float, side: float) -> float:
    """Return how far along the field a place of this x in the cell of a lane is from its start."""
    return (lane.i - lane.from_i) * side + (x - lane.from_x)


@inlined
def aim(lane: Any, half: float, field: float) -> None:
    """Find when a lane leaves its cell, of side 2 half, and through which wall."""
    towards = copysign(1.0, field)
    strength = abs(field)
    ahead, along = towards * lane.x, towards * lane.vx
    behind = ahead + half
    behind = behind if behind > 0.0 else 0.0
    inside = along * along - 2.0 * strength * behind
    if along < 0.0 and inside >= 0.0:
        # It runs out against the field before it turns.
        lane.wall_x, lane.step_i = 2.0 * behind / (sqrt(inside) - along), int(-towards)
    else:
        left = half - ahead
        left = left if left > 0.0 else 0.0
        reach = time_to_reach(left, along, strength) if left > 0.0 or along < 0.0 else 0.0
        lane.wall_x, lane.step_i = reach, int(towards)
    sign = copysign(1.0, lane.vy)
    left = half - sign * lane.y
    lane.wall_y = (left if left > 0.0 else 0.0) / max(abs(lane.vy), AT_REST)
    lane.step_j = int(sign)


@inlined
def _meet(lane: Any, cx: float, cy: float, field: float, limit: float) -> float:
    before = APART
    if lane.before != APART and cx == lane.struck_x and cy == lane.struck_y:
        before = lane.before
    return contact_in_field((lane.x - cx, lane.y - cy), (lane.vx, lane.vy), field, limit, before)


@inlined
def next_contact(
    lane: Any, slots: np.ndarray, head: np.ndarray, links: np.ndarray, nodes: np.ndarray,
    field: float,
) -> None:  # fmt: skip
    """Find the first disk that a lane meets in its cell; the time is NEVER if there is none.

    The parabola to the wall is no farther than g t^2/8 from its chord. Only disks that come so near
    to the chord are looked at closely.
    """
    x, y, cell = lane.x, lane.y, lane.cell
    first = min(lane.wall_x, lane.wall_y)
    found, meets_x, meets_y = NEVER, 0.0, 0.0
    ex, ey = (lane.vx + 0.5 * field * first) * first, lane.vy * first
    reach = 1.0 + 1e-9 + 0.125 * abs(field) * first * first
    mask = near_chord(slots, cell, (x, y), (ex, ey), reach * reach)
    slot = 0
    while mask:
        if mask & 1:
            cx, cy = slots[cell, slot], slots[cell, SLOTS + slot]
            t = _meet(lane, cx, cy, field, first)
            if t < NEVER:
                found, first, meets_x, meets_y = t, t, cx, cy
        mask >>= 1
        slot += 1
    node = head[cell]
    while node >= 0:
        cx, cy = nodes[node, 0], nodes[node, 1]
        if cx != EMPTY:  # a disk that the plane has removed; its quartic would overflow
            t = _meet(lane, cx, cy, field, first)
            if t < NEVER:
                found, first, meets_x, meets_y = t, t, cx, cy
        node = links[node]
    lane.contact, lane.meets_x, lane.meets_y = found, meets_x, meets_y


@inlined
def move(lane: Any, lasts: float, field: float) -> None:
    """Move a lane along its parabola for so long, within its cell."""
    lane.x += (lane.vx + 0.5 * field * lasts) * lasts
    lane.y += lane.vy * lasts
    lane.vx += field * lasts
    lane.time += lasts
    lane.lasted += lasts


@inlined
def cross_cell(lane: Any, keys: np.ndarray, n: int, side: float, field: float) -> None:
    """Move a lane along its parabola into the next cell."""
    across = lane.wall_x <= lane.wall_y
    move(lane, lane.wall_x if across else lane.wall_y, field)
    if across:
        lane.x = -0.5 * side * lane.step_i
        enter(lane, keys, n, lane.step_i, 0)
    else:
        lane.y = -0.5 * side * lane.step_j
        enter(lane, keys, n, 0, lane.step_j)
    lane.before = APART
    lane.crossed += 1


@inlined
def flown(lane: Any, field: float) -> float:
    """Return the length of the flight of a lane so far."""
    along, across2 = copysign(1.0, field) * lane.first_vx, lane.vy * lane.vy
    if lane.lasted == 0.0:
        return 0.0
    return length_of(lane.lasted, sqrt(along * along + across2), along, across2, abs(field))[0]


@inlined
def collide(lane: Any, law: tuple[float, float]) -> float:
    """Bounce off the disk that has been met; return the normal velocity after that, not negative.

    law: restitution and tangential restitution.
    """
    lane.struck_x, lane.struck_y = lane.meets_x, lane.meets_y
    nx, ny = lane.x - lane.struck_x, lane.y - lane.struck_y
    per = 1.0 / sqrt(nx * nx + ny * ny)
    nx, ny = nx * per, ny * per
    lane.x, lane.y = lane.struck_x + nx, lane.struck_y + ny
    lane.normal_x, lane.normal_y = nx, ny
    lane.vx, lane.vy, normal = bounce(lane.vx, lane.vy, nx, ny, law)
    lane.before = STRUCK if normal > 0.0 else TANGENT
    lane.collisions += 1
    return normal
