"""The index of the scatterers: square cells that list every scatterer a tracer can touch in them.

A cell lists the scatterers whose circle of radius 1 (in d) overlaps it, so a tracer in a cell needs
to look at no other scatterer. Positions are kept relative to the centre of the cell, so they have
all their digits far from the origin too. A cell has SLOTS places in one array; if it lists more
scatterers, the others are in a linked list, called its chain.

A periodic box stores all its cells. The unbounded plane stores a window of those last visited, in
square blocks, and makes a block anew when a tracer enters it (grid.blocks): its scatterers
are drawn from streams of (seed, configuration, place), so it always holds the same ones.
"""

from math import ceil, sqrt
from typing import NamedTuple

import numpy as np
from numba import njit

from particles.compiled.decorators import called, inlined
from particles.compiled.slots import SLOTS
from particles.grid.plane import (
    Counts,
    Law,
    candidate_density,
    cells_key,
    make_counts,
    make_law,
)
from particles.media import LISTED

EMPTY = 1e150  # far away, and its square is still finite
# The unbounded plane keeps 2**WINDOW by 2**WINDOW blocks of 2**BLOCK by 2**BLOCK cells.
BLOCK = 2
WINDOW = 7
_NOWHERE = -(2**62)
# A scatterer is listed at most 4 times where cells are wider than 2, 9 times otherwise. Listings
# are counted in 32 bits.
LISTINGS = 9


class Cells(NamedTuple):
    """Scatterers of a periodic box of n cells along each axis, or of an unbounded medium (n = 0).

    dimension: 2, or 3 (particles.grid.space). side: of a cell. slots (n_cells, dimension * SLOTS):
    x of each slot, then y, then z; EMPTY where free. fill (n_cells,): scatterers in each cell.
    head (n_cells,), links, nodes (, dimension): the chains; -1 ends one. keys
    (n_blocks, dimension): which block of the plane, or cell of space, is stored there; for a box,
    an empty array of bytes. Without a box: law, counts: the distribution of the scatterers. In the
    plane without a box: draft (, 6), pairs (, 2), who (, SLOTS): working memory for drawing a
    block.
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
    counts: Counts
    draft: np.ndarray
    pairs: np.ndarray
    who: np.ndarray


def cell_side(number_density: float, listed: float = LISTED) -> float:
    """Return the side of a cell that lists so many scatterers on average.

    Not below 1.5: a scatterer reaches into no cell but its own and its neighbours.
    """
    return max(sqrt(listed / number_density) - 2.0, 1.5)


def empty_box(box: float, number_density: float, count: int, listed: float = LISTED) -> Cells:
    """Return cells for a box of this side (in d) that is to hold `count` scatterers.

    A cell lists about `listed` of them (see cell_side): speed depends on it, the physics does not.
    Their number along a side is odd, so that the centre of the box is the centre of a cell.
    """
    n = _cells_along(box, number_density, listed)
    side = box / n
    room = LISTINGS * count
    if room >= 2**31:
        raise ValueError(f"count = {count}: must be at most {(2**31 - 1) // LISTINGS} in a box")
    return Cells(
        side=side,
        n=n,
        slots=rows(n * n, 2, EMPTY),
        fill=np.zeros(n * n, np.int32),
        head=np.full(n * n, -1, np.int32),
        links=np.empty(room, np.int32),
        nodes=np.empty((room, 2)),
        keys=np.empty((0, 2), np.int8),
        law=make_law(side, 0.0, False, np.uint64(0)),
        counts=Counts(np.empty((0, 0)), np.empty((0, 0), np.int64)),
        draft=np.empty((0, 6)),
        pairs=np.empty((0, 2), np.int64),
        who=np.empty((0, SLOTS), np.int64),
    )


def _cells_along(box: float, number_density: float, listed: float) -> int:
    n = max(int(box / cell_side(number_density, listed)), 1)
    return n - (n % 2 == 0)


def box_bytes(box: float, number_density: float, count: int, listed: float = LISTED) -> int:
    """Return the bytes that `empty_box` asks for."""
    of_a_cell = 2 * SLOTS * 8 + 4 + 4  # slots, fill, head
    of_a_listing = 4 + 2 * 8  # links, nodes
    n = _cells_along(box, number_density, listed)
    return n * n * of_a_cell + LISTINGS * count * of_a_listing


def plane(
    number_density: float, hard: bool, seed: np.uint64, configuration: int,
    old: Cells | None = None,
) -> Cells:  # fmt: skip
    """Return the unbounded plane; its blocks are drawn later, when tracers enter them.

    Getting new memory from the system takes longer than drawing a cell, so the memory of `old`, a
    plane that is no longer needed, is used again if its scatterers have the same distribution.
    """
    side = max(cell_side(number_density), 3.0)
    density = candidate_density(number_density) if hard else number_density
    law = make_law(side * 2**BLOCK, -0.5 * side, hard, cells_key(seed, configuration))
    counts = make_counts(law.side, law.band, density)
    if old is not None and old.counts is counts:
        old.keys[:] = _NOWHERE
        return old._replace(law=law)
    # A block looks at nine regions; none holds more candidates than a core.
    candidates = 9 * counts.cumulative.shape[1]
    n_blocks, n_cells = 4**WINDOW, 4 ** (WINDOW + BLOCK)
    room = n_blocks * block_room(density, side)
    return Cells(
        side=side,
        n=0,
        slots=rows(n_cells, 2),
        fill=np.empty(n_cells, np.int32),
        head=np.empty(n_cells, np.int32),
        links=np.empty(room, np.int32),
        nodes=np.empty((room, 2)),
        keys=np.full((n_blocks, 2), _NOWHERE),
        law=law,
        counts=counts,
        draft=np.empty((candidates, 6)),
        pairs=np.empty((8 * candidates, 2), np.int64),
        who=np.empty((4**BLOCK, SLOTS), np.int64),
    )


def rows(n_cells: int, dimension: int, value: float | None = None) -> np.ndarray:
    """Return slots whose rows are aligned with the lines of the processor's cache, 64 bytes."""
    line = 64 // 8
    columns = dimension * SLOTS
    whole = np.empty(n_cells * columns + line)
    begin = -(whole.ctypes.data // 8) % line
    slots = whole[begin : begin + n_cells * columns].reshape(n_cells, columns)
    if value is not None:
        slots[:] = value
    return slots


def block_room(density: float, side: float) -> int:
    """Return the number of nodes kept for a block: its mean and twelve standard deviations."""
    mean = density * (side + 2.0) ** 2 * 4**BLOCK
    # A scatterer is listed up to four times, so the deviation is up to twice Poisson's.
    return ceil(mean + 24.0 * sqrt(mean) + 64.0)


@inlined
def enlist(cells: Cells, cell: int, x: float, y: float, spare: int) -> int:
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
    # A little more than the circle, against rounding at the cell's edge.
    return gap_x * gap_x + gap_y * gap_y <= 1.0 + 1e-9


@called
def insert(cells: Cells, i: int, j: int, x: float, y: float, spare: int) -> int:
    """List a scatterer at (x, y) from the centre of cell (i, j) of a box wherever it reaches.

    Return the next spare node.
    """
    n, side = cells.n, cells.side
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
                spare = enlist(cells, cell, rx, ry, spare)
    return spare


@inlined
def is_free(head: int, links: np.ndarray, nodes: np.ndarray, near: int, x: float, y: float) -> bool:
    """Tell whether a cell lists no scatterer nearer than 1 to (x, y).

    near: what `crowd` says of its slots. head: where the chain of the others begins.
    """
    free = near == 0
    while free and head >= 0:
        dx, dy = nodes[head, 0] - x, nodes[head, 1] - y
        free = dx * dx + dy * dy >= 1.0
        head = links[head]
    return free
