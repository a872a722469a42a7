"""The scatterers of one configuration: placed at random, or given."""

from math import floor

import numpy as np

from particles.cells import Cells, cell_at, empty_box, insert, insert_all, is_free
from particles.compiled import inlined, kernel
from particles.media import BoltzmannGrad, Medium, Positions
from particles.streams import PLACEMENT, PLACES, open_stream, uniform
from particles.values import refuse

# Random sequential addition ends when so many attempts to place one scatterer have failed. If
# 1/1000 of the box were still free, the chance that all of them fail would be exp(-20).
ATTEMPTS = 20_000


def build(medium: Medium, seed: np.uint64, configuration: int) -> Cells | None:
    """Return the scatterers of one configuration, or None where the medium has none.

    Tracers start at the centre of the middle cell. Raises ValueError if not all can be placed.
    """
    return placed(medium, seed, configuration)[0]


def placed(
    medium: Medium, seed: np.uint64, configuration: int
) -> tuple[Cells | None, np.ndarray]:  # fmt: skip
    """Return what `build` does, and the places (count, 3) in d from where tracers start."""
    if isinstance(medium, BoltzmannGrad):
        return None, np.empty((0, 3))
    d, dimension, count = medium.diameter, medium.dimension, medium.count
    box = medium.box_side / d
    cells, places = empty_box(box, count, dimension), np.empty((count, 3))
    if isinstance(medium, Positions):
        own = medium.positions if medium.sets is None else medium.positions[configuration]
        places = np.insert((own - np.array(medium.start)) / d, 2, 0.0, axis=1)
        insert_all(cells, places)
        return cells, places
    key = seed, configuration
    found = _place_at_random(cells, places, box, medium.overlapping, key)
    if found < count:
        what = "disks" if dimension == 2 else "spheres"
        reached = medium.number_density * found / count
        allowed = f"only {found} of {count} {what} could be placed, a density of {reached:.3g}"
        refuse("number_density", medium.number_density, allowed)
    return cells, places


@inlined
def _spot(u: float, cells: Cells, box: float) -> tuple[int, float, float]:
    """Return (cell, place from its centre, place from the middle of the box) of u in (0, 1)."""
    n, side = cells.shape[0], cells.side
    middle = n // 2
    if len(cells.shape) == 2:
        # The product of n and a number close to 1 may be rounded to n.
        i = min(floor(u * n), n - 1)
        own = (u * n - i - 0.5) * side
        return i, own, (i - middle) * side + own
    x = (u - 0.5) * box
    i = floor(x / side + 0.5)
    return i + middle, x - i * side, x


@kernel
def _place_at_random(
    cells: Cells, positions: np.ndarray, box: float, overlapping: bool, key: tuple[np.uint64, int]
) -> int:
    """Fill an empty box at random; return how many scatterers were placed.

    Each is uniform in the box and rejected within 1 of the box's centre, where tracers start, and,
    unless overlapping, of one before. positions (count, 3): their places from there. key: of the
    stream.
    """
    state, gamma = open_stream(key[0], PLACEMENT, key[1], 0)
    draws = 0
    spare = 0
    for placed in range(positions.shape[0]):
        attempts = 0
        while True:
            if attempts == ATTEMPTS:
                return placed
            attempts += 1
            i, x, px = _spot(uniform(state, gamma, draws), cells, box)
            j, y, py = _spot(uniform(state, gamma, draws + 1), cells, box)
            k, z, pz = 0, 0.0, 0.0
            if len(cells.shape) == 3:
                k, z, pz = _spot(uniform(state, gamma, draws + 2), cells, box)
            draws += len(cells.shape)
            if px * px + py * py + pz * pz < 1.0:
                continue
            if overlapping or is_free(cells, cell_at(cells.shape, i, j, k), x, y, z):
                break
        positions[placed, 0], positions[placed, 1], positions[placed, 2] = px, py, pz
        spare = insert(cells, i, j, k, x, y, z, spare)
    return positions.shape[0]


@kernel
def free_places(
    cells: Cells, seed: np.uint64, configuration: int, first: int, n: int
) -> np.ndarray:
    """Return where n tracers from number `first` on begin at rest: i, j, x, y of each, (n, 4).

    i, j: the cell, from the middle one; x, y: the place from its centre, in d. At one place they
    would all have one path: tracer 0 begins at the centre, every other one at a random place in the
    box that no disk covers, or at the centre where there is hardly any.
    """
    across, side = cells.shape[0], cells.side
    found = np.zeros((n, 4))
    for m in range(n):
        state, gamma = open_stream(seed, PLACES, configuration, first + m)
        attempts = 0 if first + m else ATTEMPTS
        while attempts < ATTEMPTS:
            x = uniform(state, gamma, 2 * attempts) * across
            y = uniform(state, gamma, 2 * attempts + 1) * across
            attempts += 1
            i, j = min(floor(x), across - 1), min(floor(y), across - 1)
            x, y = (x - i - 0.5) * side, (y - j - 0.5) * side
            if is_free(cells, i * across + j, x, y, 0.0):
                found[m, 0], found[m, 1] = i - across // 2, j - across // 2
                found[m, 2], found[m, 3] = x, y
                break
    return found
