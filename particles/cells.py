"""The index of the scatterers: square cells that list every scatterer a tracer can touch in them.

A cell lists the scatterers whose circle of radius 1 (in d) overlaps it, so that a tracer in a cell
looks at no other. Positions are kept relative to the centre of the cell, so nothing is lost far
from the origin. A cell has SLOTS places in one block; the few that need more go on in a chain.

A periodic box stores all its cells. The unbounded plane stores a window of those last visited and
makes a cell anew when a tracer enters it: its scatterers are drawn from the stream of
(seed, configuration, cell), so it always holds the same ones.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np
from numba import njit

from particles.lanes import SLOTS
from particles.plane import (
    Law,
    candidate,
    candidates,
    is_clear,
    is_kept,
    make_law,
    open_region,
)
from particles.streams import uniform

EMPTY = 1e150  # far away, and its square is still finite
# The unbounded plane keeps 2**WINDOW by 2**WINDOW cells, each with room for CHAIN beyond SLOTS.
WINDOW = 7
CHAIN = 64
_NOWHERE = -(2**62)


class Cells(NamedTuple):
    """Scatterers of a periodic box of n by n cells, or of the unbounded plane (n = 0).

    side: of a cell. slots (n_cells, 2 * SLOTS): x of each slot, then y; EMPTY where free.
    fill (n_cells,): scatterers in each cell. head (n_cells,), links, nodes (, 2): chains of those
    beyond SLOTS, -1 ends one. Of the plane only: keys (n_cells, 2): which cell is stored there;
    law: what it is drawn from.
    """

    side: float
    n: int
    slots: np.ndarray
    fill: np.ndarray
    head: np.ndarray
    links: np.ndarray
    nodes: np.ndarray
    keys: np.ndarray
    law: Law


def cell_side(number_density: float) -> float:
    """Return the side of a cell that lists 5 scatterers on average, measured to be fastest.

    Not below 1.5: a scatterer reaches into no cell but its own and its neighbours.
    """
    return max(sqrt(5.0 / number_density) - 2.0, 1.5)


def empty_box(box: float, number_density: float, count: int) -> Cells:
    """Return cells for a box of this side (in d) that is to hold `count` scatterers.

    Their number along a side is odd, so that the centre of the box is the centre of a cell.
    """
    n = max(int(box / cell_side(number_density)), 1)
    n -= n % 2 == 0
    # A scatterer is listed at most 4 times where cells are wider than 2, 9 times otherwise.
    law = make_law(box / n, 0.0, False, np.uint64(0), 0)
    return _allocate(law, n, n * n, 9 * count)


def plane(number_density: float, hard: bool, seed: np.uint64, configuration: int) -> Cells:
    """Return the unbounded plane, nothing of it made yet."""
    side = max(cell_side(number_density), 3.0)
    n_cells = 4**WINDOW
    law = make_law(side, number_density, hard, seed, configuration)
    return _allocate(law, 0, n_cells, n_cells * CHAIN)


def _allocate(law: Law, n: int, n_cells: int, room: int) -> Cells:
    window = 0 if n else n_cells
    return Cells(
        side=law.side,
        n=n,
        slots=np.full((n_cells, 2 * SLOTS), EMPTY),
        fill=np.zeros(n_cells, np.int32),
        head=np.full(n_cells, -1, np.int32),
        links=np.empty(room, np.int32),
        nodes=np.empty((room, 2)),
        keys=np.full((window, 2), _NOWHERE),
        law=law,
    )


@njit(error_model="numpy", forceinline=True)
def _list(
    slots: np.ndarray, fill: np.ndarray, head: np.ndarray, links: np.ndarray, nodes: np.ndarray,
    cell: int, x: float, y: float, spare: int,
) -> int:  # fmt: skip
    """Enter a scatterer in a cell, in node `spare` if its slots are full; return the next spare."""
    k = fill[cell]
    fill[cell] = k + 1
    if k < SLOTS:
        slots[cell, k] = x
        slots[cell, SLOTS + k] = y
        return spare
    nodes[spare, 0] = x
    nodes[spare, 1] = y
    links[spare] = head[cell]
    head[cell] = spare
    return spare + 1


@njit(error_model="numpy", inline="always")
def _reaches(x: float, y: float, half: float) -> bool:
    """Tell whether a circle of radius 1 around (x, y) overlaps the square |x|, |y| <= half."""
    gap_x = max(abs(x) - half, 0.0)
    gap_y = max(abs(y) - half, 0.0)
    # A hair more than the circle, against rounding at the cell's edge.
    return gap_x * gap_x + gap_y * gap_y <= 1.0 + 1e-9


@njit(error_model="numpy")
def insert(
    slots: np.ndarray, fill: np.ndarray, head: np.ndarray, links: np.ndarray, nodes: np.ndarray,
    n: int, side: float, i: int, j: int, x: float, y: float, spare: int,
) -> int:  # fmt: skip
    """List a scatterer at (x, y) from the centre of cell (i, j) of a box wherever it reaches."""
    half = 0.5 * side
    for di in range(-1, 2):
        if di * x < abs(di) * (half - 1.0 - 1e-9):
            continue
        for dj in range(-1, 2):
            if dj * y < abs(dj) * (half - 1.0 - 1e-9):
                continue
            rx, ry = x - di * side, y - dj * side
            if _reaches(rx, ry, half):
                cell = (i + di) % n * n + (j + dj) % n
                spare = _list(slots, fill, head, links, nodes, cell, rx, ry, spare)
    return spare


@njit(error_model="numpy")
def is_free(
    slots: np.ndarray, fill: np.ndarray, head: np.ndarray, links: np.ndarray, nodes: np.ndarray,
    cell: int, x: float, y: float,
) -> bool:  # fmt: skip
    """Tell whether no listed scatterer is nearer than 1 to (x, y) of this cell."""
    for k in range(min(fill[cell], SLOTS)):
        dx, dy = slots[cell, k] - x, slots[cell, SLOTS + k] - y
        if dx * dx + dy * dy < 1.0:
            return False
    node = head[cell]
    while node >= 0:
        dx, dy = nodes[node, 0] - x, nodes[node, 1] - y
        if dx * dx + dy * dy < 1.0:
            return False
        node = links[node]
    return True


@njit(error_model="numpy")
def make(
    slots: np.ndarray, fill: np.ndarray, head: np.ndarray, links: np.ndarray, nodes: np.ndarray,
    keys: np.ndarray, law: Law, cell: int, i: int, j: int,
) -> None:  # fmt: skip
    """Make cell (i, j) of the plane in this place of the window."""
    half = 0.5 * law.side
    keys[cell, 0], keys[cell, 1] = i, j
    slots[cell] = EMPTY
    fill[cell] = 0
    head[cell] = -1
    spare = cell * CHAIN
    # 1 is the farthest that the origin's clearing reaches: only cells around it need look.
    near = abs(i) + abs(j) < 3
    for dp in range(-1, 2):
        for dq in range(-1, 2):
            p, q = 2 * i + dp, 2 * j + dq
            state, gamma = open_region(law, p, q)
            for k in range(candidates(law, p, q, state)):
                x, y = candidate(law, p, q, state, gamma, k)
                if near and not is_clear(law, p, q, x, y):
                    continue
                if law.hard and not is_kept(law, p, q, x, y, uniform(state, gamma, 3 * k + 3)):
                    continue
                spare = _list(
                    slots, fill, head, links, nodes, cell, x + dp * half, y + dq * half, spare
                )


@njit(error_model="numpy", inline="always")
def place(i: int, j: int) -> int:
    """Return where the window stores cell (i, j); cells less than its width apart never collide."""
    inside = 2**WINDOW - 1
    return ((i & inside) << WINDOW) | (j & inside)
