"""The index of the scatterers: square cells that list every scatterer a tracer can touch in them.

A cell lists the scatterers whose circle of radius 1 (in d) overlaps it, so that a tracer in a cell
looks at no other. Positions are kept relative to the centre of the cell, so nothing is lost far
from the origin. A cell has SLOTS places in one block; the few that need more go on in a chain.

A periodic box stores all its cells. The unbounded plane stores a window of those last visited and
makes a cell anew when a tracer enters it: its scatterers are drawn from the stream of
(seed, configuration, cell), so it always holds the same ones.
"""

from math import sqrt
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from particles.lanes import SLOTS
from particles.plane import disks_of_cell

EMPTY = 1e150  # far away, and its square is still finite
# The unbounded plane keeps 2**WINDOW by 2**WINDOW cells, each with room for CHAIN beyond SLOTS.
WINDOW = 7
CHAIN = 64
_NOWHERE = -(2**62)


class Cells(NamedTuple):
    """Scatterers of a periodic box of n by n cells, or of the unbounded plane (n = 0).

    side: of a cell. slots (n_cells, 2 * SLOTS): x of each slot, then y; EMPTY where free.
    fill (n_cells,): scatterers in each cell. head (n_cells,), links, nodes (, 2): chains of those
    beyond SLOTS, -1 ends one. keys (n_cells, 2): which cell of the plane is stored there.
    seed, configuration, intensity, hard: what the plane is drawn from.
    """

    side: float
    n: int
    slots: np.ndarray
    fill: np.ndarray
    head: np.ndarray
    links: np.ndarray
    nodes: np.ndarray
    keys: np.ndarray
    seed: Any
    configuration: int
    intensity: float
    hard: bool


def cell_side(number_density: float) -> float:
    """Return the side of a cell that lists 4 scatterers on average, measured to be fastest.

    Not below 1.5: a scatterer reaches into no cell but its own and its neighbours.
    """
    return max(sqrt(4.0 / number_density) - 2.0, 1.5)


def empty_box(box: float, number_density: float, count: int) -> Cells:
    """Return cells for a box of this side (in d) that is to hold `count` scatterers.

    Their number along a side is odd, so that the centre of the box is the centre of a cell.
    """
    n = max(int(box / cell_side(number_density)), 1)
    n -= n % 2 == 0
    # A scatterer is listed at most 4 times where cells are wider than 2, 9 times otherwise.
    return _allocate(box / n, n, n * n, 9 * count, np.uint64(0), 0, 0.0, False)


def plane(
    number_density: float, intensity: float, hard: bool, seed: np.uint64, configuration: int
) -> Cells:
    """Return the unbounded plane, nothing of it made yet.

    intensity: candidates per unit area, of which `hard` disks keep those that find room.
    """
    n_cells = 4**WINDOW
    side = cell_side(number_density)
    return _allocate(
        side, 0, n_cells, n_cells * CHAIN, seed, configuration, intensity * side * side, hard
    )


def _allocate(
    side: float, n: int, n_cells: int, room: int, seed: Any, configuration: int,
    intensity: float, hard: bool,
) -> Cells:  # fmt: skip
    return Cells(
        side=side,
        n=n,
        slots=np.full((n_cells, 2 * SLOTS), EMPTY),
        fill=np.zeros(n_cells, np.int32),
        head=np.full(n_cells, -1, np.int32),
        links=np.empty(room, np.int32),
        nodes=np.empty((room, 2)),
        keys=np.full((0 if n else n_cells, 2), _NOWHERE),
        seed=seed,
        configuration=configuration,
        intensity=intensity,
        hard=hard,
    )


@njit(error_model="numpy", inline="always")
def _list(cells: Cells, cell: int, x: float, y: float, spare: int) -> int:
    """Enter a scatterer in a cell, in node `spare` if its slots are full; return the next spare."""
    k = cells.fill[cell]
    cells.fill[cell] = k + 1
    if k < SLOTS:
        cells.slots[cell, k] = x
        cells.slots[cell, SLOTS + k] = y
        return spare
    cells.nodes[spare, 0] = x
    cells.nodes[spare, 1] = y
    cells.links[spare] = cells.head[cell]
    cells.head[cell] = spare
    return spare + 1


@njit(error_model="numpy", inline="always")
def _reaches(x: float, y: float, half: float) -> bool:
    """Tell whether a circle of radius 1 around (x, y) overlaps the square |x|, |y| <= half."""
    gap_x = max(abs(x) - half, 0.0)
    gap_y = max(abs(y) - half, 0.0)
    # A hair more than the circle, against rounding at the cell's edge.
    return gap_x * gap_x + gap_y * gap_y <= 1.0 + 1e-9


@njit(error_model="numpy")
def insert(cells: Cells, i: int, j: int, x: float, y: float, spare: int) -> int:
    """List a scatterer at (x, y) from the centre of cell (i, j) of a box wherever it reaches."""
    n, side = cells.n, cells.side
    for di in range(-1, 2):
        for dj in range(-1, 2):
            rx, ry = x - di * side, y - dj * side
            if _reaches(rx, ry, 0.5 * side):
                cell = (i + di) % n * n + (j + dj) % n
                spare = _list(cells, cell, rx, ry, spare)
    return spare


@njit(error_model="numpy")
def is_free(cells: Cells, cell: int, x: float, y: float) -> bool:
    """Tell whether no listed scatterer is nearer than 1 to (x, y) of this cell."""
    for k in range(min(cells.fill[cell], SLOTS)):
        dx = cells.slots[cell, k] - x
        dy = cells.slots[cell, SLOTS + k] - y
        if dx * dx + dy * dy < 1.0:
            return False
    node = cells.head[cell]
    while node >= 0:
        dx = cells.nodes[node, 0] - x
        dy = cells.nodes[node, 1] - y
        if dx * dx + dy * dy < 1.0:
            return False
        node = cells.links[node]
    return True


@njit(error_model="numpy")
def _make(cells: Cells, cell: int, i: int, j: int) -> None:
    """Make cell (i, j) of the plane in this place of the window."""
    side = cells.side
    cells.keys[cell, 0], cells.keys[cell, 1] = i, j
    cells.slots[cell] = EMPTY
    cells.fill[cell] = 0
    cells.head[cell] = -1
    spare = cell * CHAIN
    disks = np.empty((256, 2))
    for di in range(-1, 2):
        for dj in range(-1, 2):
            n = disks_of_cell(
                disks, i + di, j + dj, side, cells.intensity, cells.hard, cells.seed,
                cells.configuration,
            )  # fmt: skip
            for k in range(n):
                rx, ry = disks[k, 0] + di * side, disks[k, 1] + dj * side
                if _reaches(rx, ry, 0.5 * side):
                    spare = _list(cells, cell, rx, ry, spare)


@njit(error_model="numpy", inline="always")
def find(cells: Cells, i: int, j: int) -> int:
    """Return where cell (i, j) of the plane is stored, made if need be."""
    inside = 2**WINDOW - 1
    cell = ((i & inside) << WINDOW) | (j & inside)
    if cells.keys[cell, 0] != i or cells.keys[cell, 1] != j:
        _make(cells, cell, i, j)
    return cell
