"""Placing scatterers in a periodic box: at random, or where the user says."""

from math import floor

import numpy as np

from particles.compiled.decorators import kernel
from particles.compiled.search import crowd
from particles.grid.cells import Cells, insert, is_free
from particles.streams import PLACEMENT, open_stream, uniform

# Random sequential addition ends when so many attempts to place one disk have failed. If 1/1000 of
# the box were still free, the chance that all of them fail would be exp(-20).
ATTEMPTS = 20_000


@kernel
def place_at_random(
    cells: Cells, count: int, overlapping: bool, seed: np.uint64, configuration: int
) -> int:
    """Fill an empty box with `count` scatterers at random; return how many were placed.

    Each is uniform in the box and rejected within 1 of the box's centre, where tracers start, and,
    unless overlapping, of one placed before (random sequential addition).
    """
    n, side = cells.n, cells.side
    slots, head, links, nodes = cells.slots, cells.head, cells.links, cells.nodes
    middle = n // 2
    state, gamma = open_stream(seed, PLACEMENT, configuration, 0)
    draws = 0
    spare = 0
    for placed in range(count):
        attempts = 0
        while True:
            if attempts == ATTEMPTS:
                return placed
            attempts += 1
            x = uniform(state, gamma, draws) * n
            y = uniform(state, gamma, draws + 1) * n
            draws += 2
            # The product of n and a number close to 1 may be rounded to n.
            i = min(floor(x), n - 1)
            j = min(floor(y), n - 1)
            x = (x - i - 0.5) * side
            y = (y - j - 0.5) * side
            dx = (i - middle) * side + x
            dy = (j - middle) * side + y
            if dx * dx + dy * dy < 1.0:
                continue
            cell = i * n + j
            if overlapping or is_free(head[cell], links, nodes, crowd(slots, cell, x, y), x, y):
                break
        spare = insert(cells, i, j, x, y, spare)
    return count


@kernel
def place_given(cells: Cells, positions: np.ndarray, start: np.ndarray) -> None:
    """Fill an empty box with scatterers at given positions (count, 2), in d.

    `start` (2,) becomes the centre of the middle cell.
    """
    n, side = cells.n, cells.side
    spare = 0
    for k in range(positions.shape[0]):
        x, y = positions[k, 0] - start[0], positions[k, 1] - start[1]
        i, j = floor(x / side + 0.5), floor(y / side + 0.5)
        own_i, own_j = (i + n // 2) % n, (j + n // 2) % n
        spare = insert(cells, own_i, own_j, x - i * side, y - j * side, spare)
