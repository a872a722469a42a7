"""The index of the scatterers: square cells that list every scatterer a tracer can touch in them.

A cell lists the scatterers whose circle of radius 1 (in d) overlaps it, so that a tracer in a cell
looks at no other. Positions are kept relative to the centre of the cell, so nothing is lost far
from the origin. A cell has SLOTS places in one block; the few that need more go on in a chain.
"""

from math import floor, sqrt
from typing import NamedTuple

import numpy as np
from numba import njit

from particles.streams import PLACEMENT, open_stream, uniform

SLOTS = 8
EMPTY = 1e150  # far away, and its square is still finite
# Attempts per disk after which random sequential addition is given up.
ATTEMPTS = 20_000


class Cells(NamedTuple):
    """Scatterers of one periodic box of n by n cells.

    slots (n * n, 2 * SLOTS): x of each slot, then y; EMPTY where free. fill (n * n,): scatterers
    in each cell. head (n * n,), links, nodes (, 2): chains of those beyond SLOTS, -1 ends one.
    """

    side: float
    slots: np.ndarray
    fill: np.ndarray
    head: np.ndarray
    links: np.ndarray
    nodes: np.ndarray


def cells_per_side(box: float, number_density: float) -> int:
    """Return the number of cells along a box: odd, so that the box's centre is a cell's centre.

    Cells hold 4 scatterers on average, where few have more than SLOTS; measured to be fastest.
    """
    wanted = max(sqrt(4.0 / number_density) - 2.0, 1.5)
    n = max(int(box / wanted), 1)
    return n if n % 2 else n - 1 if n > 1 else 1


def empty_cells(box: float, number_density: float, count: int) -> Cells:
    """Return cells for a box of this side (in d) that is to hold `count` scatterers."""
    n = cells_per_side(box, number_density)
    # A scatterer is listed at most 4 times where cells are wider than 2, 9 times otherwise.
    room = 9 * count
    return Cells(
        side=box / n,
        slots=np.full((n * n, 2 * SLOTS), EMPTY),
        fill=np.zeros(n * n, np.int32),
        head=np.full(n * n, -1, np.int32),
        links=np.empty(room, np.int32),
        nodes=np.empty((room, 2)),
    )


@njit(inline="always", error_model="numpy")
def _insert(i, j, x, y, n, side, slots, fill, head, links, nodes, used):  # type: ignore[no-untyped-def]
    """List a scatterer at (x, y) from the centre of cell (i, j) wherever its circle reaches."""
    half = 0.5 * side
    for di in range(-1, 2):
        rx = x - di * side
        gap_x = max(abs(rx) - half, 0.0)
        for dj in range(-1, 2):
            ry = y - dj * side
            gap_y = max(abs(ry) - half, 0.0)
            # A hair more than the circle, against rounding at the cell's edge.
            if gap_x * gap_x + gap_y * gap_y > 1.0 + 1e-9:
                continue
            cell = (i + di) % n * n + (j + dj) % n
            k = fill[cell]
            fill[cell] = k + 1
            if k < SLOTS:
                slots[cell, k] = rx
                slots[cell, SLOTS + k] = ry
            else:
                nodes[used, 0] = rx
                nodes[used, 1] = ry
                links[used] = head[cell]
                head[cell] = used
                used += 1
    return used


@njit(inline="always", error_model="numpy")
def _is_free(cell, x, y, slots, fill, head, links, nodes):  # type: ignore[no-untyped-def]
    """Tell whether no listed scatterer is nearer than 1 to (x, y) of this cell."""
    for k in range(min(fill[cell], SLOTS)):
        dx = slots[cell, k] - x
        dy = slots[cell, SLOTS + k] - y
        if dx * dx + dy * dy < 1.0:
            return False
    node = head[cell]
    while node >= 0:
        dx = nodes[node, 0] - x
        dy = nodes[node, 1] - y
        if dx * dx + dy * dy < 1.0:
            return False
        node = links[node]
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def place_at_random(
    count: int,
    overlapping: bool,
    seed: np.uint64,
    configuration: int,
    side: float,
    slots: np.ndarray,
    fill: np.ndarray,
    head: np.ndarray,
    links: np.ndarray,
    nodes: np.ndarray,
) -> int:
    """Fill empty cells with `count` scatterers at random; return how many were placed.

    Each is uniform in the box and rejected within 1 of the box's centre, where tracers start, and,
    unless overlapping, of one placed before (random sequential addition).
    """
    n = round(sqrt(fill.size))
    middle = n // 2
    state, gamma = open_stream(seed, PLACEMENT, configuration, 0)
    draws = 0
    used = 0
    for placed in range(count):
        attempts = 0
        while True:
            if attempts == ATTEMPTS:
                return placed
            attempts += 1
            x = uniform(state, gamma, draws) * n
            y = uniform(state, gamma, draws + 1) * n
            draws += 2
            # A draw next to 1 times n may round up to n.
            i = min(floor(x), n - 1)
            j = min(floor(y), n - 1)
            x = (x - i - 0.5) * side
            y = (y - j - 0.5) * side
            dx = (i - middle) * side + x
            dy = (j - middle) * side + y
            if dx * dx + dy * dy < 1.0:
                continue
            if overlapping or _is_free(i * n + j, x, y, slots, fill, head, links, nodes):
                break
        used = _insert(i, j, x, y, n, side, slots, fill, head, links, nodes, used)
    return count
