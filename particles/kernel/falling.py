"""The steps of a tracer on parabolas among disks, which `particles.kernel.follow` joins.

A lane holds place and velocity at its last node: a contact, a cell wall, or the end of a slide.

When it first touches a disk is the first root of a quartic. In a field g along x, and from the
centre of the disk, the tracer is at (x + vx t + g t^2/2, y + vy t), and touches the disk where
P = |r|^2 - 1 falls through 0. Half the second derivative of P is

    q(t) = 3/2 (vx + g t)^2 + v^2 + g x - 3/2 vx^2,

whose least value m over the time that is left is known at once. So P is nowhere below the parabola
P_k + 2 h_k s + m s^2 that touches it at the present time t_k, nor its first root before that of the
parabola. Going from one such root to the next, the tracer comes near the first contact from before,
quadratically, and cannot pass it; where the parabola has no root, there is no contact.
"""

from math import copysign, sqrt
from typing import Any

import numpy as np
from numba import njit

from particles.cells import SLOTS, Cells, cell_at, near_chord
from particles.compiled import inlined
from particles.events import MOST_STEPS, NEVER, bounce
from particles.kernel.lane import AT_REST, Start
from particles.kernel.parabola import SMALLEST_STEP, length_flown, time_to_reach
from particles.kernel.steps import enter

# How a tracer and a disk are to each other when its flight begins: not in contact as far as is
# known, on it and leaving, or on it and leaving without normal velocity.
APART, STRUCK, TANGENT = range(3)


@njit(error_model="numpy")
def contact_in_field(
    place: tuple[float, float], velocity: tuple[float, float], field: float, limit: float,
    before: int,
) -> float:  # fmt: skip
    """Return the time of the first contact with a disk, NEVER if it is not before `limit`.

    place: from the centre of the disk, whose radius is 1. before: APART, STRUCK or TANGENT; in the
    last two cases it is the next contact. A tracer that is APART and by rounding not outside
    collides at once if it moves inwards.
    """
    x, y = place
    vx, vy = velocity
    if before == TANGENT:
        # P = t^2 (opening + growth t + (field t)^2/4)
        opening, growth = vx * vx + vy * vy + field * x, field * vx
        inside = growth * growth - field * field * opening
        if growth >= 0.0 or inside < 0.0:
            return NEVER
        t = 2.0 * max(opening, 0.0) / (sqrt(inside) - growth)
        return t if t <= limit else NEVER
    t, p, h = 0.0, x * x + y * y - 1.0, x * vx + y * vy
    on_disk = before == STRUCK or p <= 0.0
    if on_disk:
        if before == APART and h < 0.0:
            return 0.0
        p, h = 0.0, max(h, 0.0)
    square = vx * vx + vy * vy + field * x
    base, rise = square - 1.5 * vx * vx, h
    end = vx + field * limit
    for _ in range(MOST_STEPS):  # two in the mean; some hundreds for contacts that graze
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


@inlined
def begin(lane: Any, cells: Cells, start: Start) -> None:
    """Put a tracer that has been launched where it starts."""
    lane.from_i = lane.from_j = 0
    lane.from_x = lane.from_y = 0.0
    if start.places.shape[0]:
        place = start.places[lane.tracer]
        lane.from_i, lane.from_j = int(place[0]), int(place[1])
        lane.from_x, lane.from_y = place[2], place[3]
    lane.i, lane.j, lane.x, lane.y = lane.from_i, lane.from_j, lane.from_x, lane.from_y
    middle = cells.shape[0] // 2
    lane.stored_i, lane.stored_j = middle + lane.i, middle + lane.j
    lane.cell = cell_at(cells.shape, lane.stored_i, lane.stored_j, 0)
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

    Only disks near the chord are looked at: the parabola is no farther than g t^2/8 from it.
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
def cross_cell(lane: Any, shape: tuple[int, ...], side: float, field: float) -> None:
    """Move a lane along its parabola into the next cell."""
    across = lane.wall_x <= lane.wall_y
    move(lane, lane.wall_x if across else lane.wall_y, field)
    if across:
        lane.x = -0.5 * side * lane.step_i
        enter(lane, shape, lane.step_i, 0, 0)
    else:
        lane.y = -0.5 * side * lane.step_j
        enter(lane, shape, 0, lane.step_j, 0)
    lane.before = APART
    lane.crossed += 1


@inlined
def flown(lane: Any, field: float) -> float:
    """Return the length of the flight of a lane so far."""
    return length_flown(lane.first_vx, lane.vy, 0.0, lane.lasted, field)


@inlined
def collide(lane: Any, law: tuple[float, float]) -> float:
    """Bounce off the disk that has been met; return the normal velocity after that."""
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
