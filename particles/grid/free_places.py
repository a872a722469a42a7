"""Places among the disks of one configuration that tracers at rest begin at.

Tracers that move all begin at one place, the centre: their velocities tell them apart. At rest
there, they would all have one path.
"""

from math import floor

import numpy as np

from particles.compiled.decorators import kernel
from particles.compiled.search import crowd
from particles.grid.blocks import is_missing, is_unbounded, place, supply
from particles.grid.cells import Cells, is_free
from particles.streams import PLACES, open_stream, uniform

# Tracers begin in a square of so many cells of the unbounded plane: it holds about 80 000 disks, or
# at densities above 0.2 d^-2 those of 384 d by 384 d.
ACROSS = 128
# Where no free place is found in so many attempts, less than about 1/1000 of the box is free.
ATTEMPTS = 20_000


@kernel
def free_places(
    cells: Cells, seed: np.uint64, configuration: int, first: int, n: int
) -> np.ndarray:
    """Return where n tracers from number `first` on begin at rest: i, j, x, y of each, (n, 4).

    i, j: the cell, from the middle one; x, y: the place from its centre, in d. Tracer 0 begins at
    the centre of the middle cell, every other one at a random place in the box, or in a square of
    the plane, that no disk covers; at the centre, too, where there is hardly any.
    """
    keys, slots, head, links, nodes = cells.keys, cells.slots, cells.head, cells.links, cells.nodes
    unbounded = is_unbounded(keys)
    across = ACROSS if unbounded else cells.n
    found = np.zeros((n, 4))
    for k in range(n):
        state, gamma = open_stream(seed, PLACES, configuration, first + k)
        attempts = 0 if first + k else ATTEMPTS
        while attempts < ATTEMPTS:
            x = uniform(state, gamma, 2 * attempts) * across
            y = uniform(state, gamma, 2 * attempts + 1) * across
            attempts += 1
            # The product of a whole number and one close to 1 may be rounded to the former.
            i, j = min(floor(x), across - 1), min(floor(y), across - 1)
            x, y = (x - i - 0.5) * cells.side, (y - j - 0.5) * cells.side
            cell = i * across + j
            i, j = i - across // 2, j - across // 2
            if unbounded:
                cell = place(i, j)
                if is_missing(keys, cell, i, j):
                    supply(keys, cells, cell, i, j)
            if is_free(head[cell], links, nodes, crowd(slots, cell, x, y), x, y):
                found[k, 0], found[k, 1], found[k, 2], found[k, 3] = i, j, x, y
                break
    return found
