"""The steps of a tracer among disks in the plane, which `particles.kernel.follow` puts together."""

from math import copysign
from typing import Any

import numpy as np

from particles.compiled.decorators import inlined
from particles.compiled.search import SLOTS, strike
from particles.events import contact, is_collapsing, scatter, touch
from particles.grid.blocks import is_missing, is_unbounded, place, supply
from particles.grid.cells import Cells
from particles.kernel import columns

# Flights shorter than this, in d, occur in corners between two scatterers only, whose walls are
# straight on this scale; whether a tracer ever leaves is then decided by `is_collapsing`.
SHORT = 1e-9


@inlined
def begin(lane: Any, cells: Cells) -> None:
    """Put a tracer at the centre of the middle cell, where its path starts."""
    middle = cells.n // 2
    lane.stored_i = lane.stored_j = middle
    lane.cell = place(0, 0) if is_unbounded(cells.keys) else middle * cells.n + middle
    aim(lane, cells.side)


@inlined
def lacks_cell(lane: Any, keys: np.ndarray) -> bool:
    """Tell whether the cell of a lane is not made yet, or lost since to another lane."""
    return is_missing(keys, lane.cell, lane.i, lane.j)


@inlined
def make_cell(lane: Any, keys: np.ndarray, cells: Cells) -> None:
    """Make the cell of a lane. To be called only where it is missing (see `supply`)."""
    supply(keys, cells, lane.cell, lane.i, lane.j)


@inlined
def aim(lane: Any, side: float) -> None:
    """Find the cell walls ahead of a lane that begins a flight."""
    half = 0.5 * side
    sign_x, sign_y = copysign(1.0, lane.ux), copysign(1.0, lane.uy)
    pace_x, pace_y = 1.0 / max(abs(lane.ux), 1e-300), 1.0 / max(abs(lane.uy), 1e-300)
    lane.wall_x = max((half - sign_x * lane.x) * pace_x, 0.0)
    lane.wall_y = max((half - sign_y * lane.y) * pace_y, 0.0)
    lane.between_x, lane.between_y = side * pace_x, side * pace_y
    lane.move_x, lane.move_y = sign_x * side, sign_y * side
    lane.step_i, lane.step_j = int(sign_x), int(sign_y)


@inlined
def next_wall(lane: Any) -> float:
    """Return the path to the wall of its cell that a lane reaches first."""
    return min(lane.wall_x, lane.wall_y)


@inlined
def next_contact(
    lane: Any, slots: np.ndarray, head: np.ndarray, links: np.ndarray, nodes: np.ndarray
) -> None:
    """Find the first scatterer that a lane meets in its cell, if there is one."""
    x, y, ux, uy, cell = lane.x, lane.y, lane.ux, lane.uy, lane.cell
    path, slot = strike(slots, cell, x, y, ux, uy)
    cx, cy = slots[cell, slot], slots[cell, SLOTS + slot]
    node = head[cell]
    while node >= 0:
        s, _ = contact(nodes[node, 0] - x, nodes[node, 1] - y, ux, uy)
        if s < path:
            path, cx, cy = s, nodes[node, 0], nodes[node, 1]
        node = links[node]
    lane.contact, lane.struck_x, lane.struck_y = path, cx, cy


@inlined
def cross_cell(lane: Any, keys: np.ndarray, n: int) -> None:
    """Move a lane into the next cell, through the wall that it reaches first."""
    # Factors 0 and 1 instead of a branch: the processor cannot predict which wall comes first.
    across = int(lane.wall_x <= lane.wall_y)
    along = 1 - across
    lane.x -= across * lane.move_x
    lane.y -= along * lane.move_y
    lane.wall_x += across * lane.between_x
    lane.wall_y += along * lane.between_y
    enter(lane, keys, n, across * lane.step_i, along * lane.step_j)


@inlined
def enter(lane: Any, keys: np.ndarray, n: int, di: int, dj: int) -> None:
    """Note that a lane is in the next cell: di, dj are -1, 0 or 1."""
    lane.i += di
    lane.j += dj
    if is_unbounded(keys):
        lane.cell = place(lane.i, lane.j)
    else:
        i, j = lane.stored_i + di, lane.stored_j + dj
        i = n - 1 if i < 0 else 0 if i == n else i
        j = n - 1 if j < 0 else 0 if j == n else j
        lane.stored_i, lane.stored_j = i, j
        lane.cell = i * n + j


@inlined
def collide(lane: Any, path: float, side: float, law: tuple[float, float]) -> tuple[float, bool]:
    """Bounce off the scatterer met after this path; the next flight begins there.

    law: restitution and tangential restitution. Return the ratio of the speeds after and before,
    and whether the tracer is trapped from now on.
    """
    restitution, tangential = law
    ux, uy, cx, cy = lane.ux, lane.uy, lane.struck_x, lane.struck_y
    impact = (cx - lane.x) * uy - (cy - lane.y) * ux
    x, y = touch(cx, cy, ux, uy, impact)
    ux, uy, ratio = scatter(ux, uy, impact, restitution, tangential)
    nx, ny = x - cx, y - cy
    trapped = ratio == 0.0
    if path < SHORT and not trapped:
        before = lane.normal_x, lane.normal_y
        trapped = is_collapsing(before, (nx, ny), (ux, uy), restitution, tangential)
    lane.x, lane.y, lane.ux, lane.uy, lane.normal_x, lane.normal_y = x, y, ux, uy, nx, ny
    lane.flight_x, lane.flight_y = lane.i * side + x, lane.j * side + y
    lane.collisions += 1
    aim(lane, side)
    return ratio, trapped


@inlined
def end_bounces(
    lane: Any, path: float, cells: Cells, law: tuple[float, float]
) -> tuple[float, bool]:
    """In the plane `collide` has seen to the bounces that never end already."""
    return 1.0, False


@inlined
def note_place(lane: Any, trap: np.ndarray) -> None:
    """Record where a tracer was caught."""
    trap[columns.TRAP_X] = lane.flight_x
    trap[columns.TRAP_Y] = lane.flight_y
