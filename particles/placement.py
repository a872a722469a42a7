"""The scatterers of one configuration: placed at random, or where the user says.

Begin reading with `placed` and `_place_at_random`.
"""

from math import floor

import numpy as np

from particles.cells import Cells, cell_at, empty_box, insert, insert_all, is_free
from particles.compiled import inlined, kernel
from particles.media import BoltzmannGrad, Medium, Positions
from particles.streams import PLACEMENT, PLACES, open_stream, uniform
from particles.values import refuse

#: Attempts to place one scatterer after which random sequential addition ends. Chosen: if 1/1000 of
#: the box were still free, the chance that all of them fail would be exp(-20).
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
    d = medium.diameter
    box = medium.box_side / d
    cells = empty_box(box, medium.count, medium.dimension)
    if isinstance(medium, Positions):
        positions = medium.positions if medium.sets is None else medium.positions[configuration]
        places = np.insert((positions - np.array(medium.start)) / d, 2, 0.0, axis=1)
        insert_all(cells, places)
        return cells, places
    places = np.empty((medium.count, 3))
    key = seed, configuration
    if medium.spacing in (0.0, d):
        overlapping = medium.spacing == 0.0
        count = _place_at_random(cells, places, box, 1.0, overlapping, key)
    else:
        # Placed in cells of their own, in units of the exclusion.
        unit = medium.spacing / d
        own_cells = empty_box(box / unit, medium.count, medium.dimension)
        count = _place_at_random(own_cells, places, box / unit, 1.0 / unit, False, key)
        places *= unit
        insert_all(cells, places)
    if count < medium.count:
        bodies = "disks" if medium.dimension == 2 else "spheres"
        reached = medium.number_density * count / medium.count
        allowed = f"only {count} of {medium.count} {bodies} could be placed"
        refuse("number_density", medium.number_density, f"{allowed}, a density of {reached:.3g}")
    return cells, places


@inlined
def _spot(u: float, cells: Cells, box: float) -> tuple[int, float, float]:
    """Return (cell, place from its centre, place from the middle of the box) of u in (0, 1)."""
    n = cells.shape[0]
    side = cells.side
    middle = n // 2
    if len(cells.shape) == 2:
        # The product of n and a number close to 1 may be rounded to n.
        i = min(floor(u * n), n - 1)
        from_centre = (u * n - i - 0.5) * side
        return i, from_centre, (i - middle) * side + from_centre
    x = (u - 0.5) * box
    i = floor(x / side + 0.5)
    return i + middle, x - i * side, x


@kernel
def _place_at_random(
    cells: Cells, positions: np.ndarray, box: float, clearance: float, overlapping: bool,
    key: tuple[np.uint64, int],
) -> int:  # fmt: skip
    """Fill an empty box at random; return how many scatterers were placed.

    Each is uniform in the box and rejected where it is nearer than `clearance` to the box's centre,
    where tracers start, or, unless overlapping, nearer than 1 to one before.

    Parameters
    ----------
    cells : empty, of a box of side `box`
    positions : receives the places from the box's centre, shape (count, 3)
    clearance : in the unit of length of the cells
    overlapping : whether scatterers may be near to each other
    key : seed and configuration
    """
    state, gamma = open_stream(key[0], PLACEMENT, key[1], 0)
    draws = 0
    spare = 0
    for number in range(positions.shape[0]):
        attempts = 0
        while True:
            if attempts == ATTEMPTS:
                return number
            attempts += 1
            i, x, px = _spot(uniform(state, gamma, draws), cells, box)
            j, y, py = _spot(uniform(state, gamma, draws + 1), cells, box)
            k = 0
            z = 0.0
            pz = 0.0
            if len(cells.shape) == 3:
                k, z, pz = _spot(uniform(state, gamma, draws + 2), cells, box)
            draws += len(cells.shape)
            if px * px + py * py + pz * pz < clearance * clearance:
                continue
            if overlapping or is_free(cells, cell_at(cells.shape, i, j, k), x, y, z):
                break
        positions[number, 0] = px
        positions[number, 1] = py
        positions[number, 2] = pz
        spare = insert(cells, i, j, k, x, y, z, spare)
    return positions.shape[0]


@kernel
def free_places(
    cells: Cells, seed: np.uint64, configuration: int, first_number: int, n: int
) -> np.ndarray:
    """Return where n tracers from a number on begin at rest: i, j, x, y of each, (n, 4).

    i, j: the cell, from the middle one; x, y: the place from its centre, in d. At one place they
    would all have one path: tracer 0 begins at the centre, every other one at a random place in the
    box that no disk covers, or at the centre where there is hardly any.
    """
    n_cells = cells.shape[0]
    side = cells.side
    middle = n_cells // 2
    places = np.zeros((n, 4))
    for m in range(n):
        number = first_number + m
        state, gamma = open_stream(seed, PLACES, configuration, number)
        attempts = 0 if number else ATTEMPTS
        while attempts < ATTEMPTS:
            along = uniform(state, gamma, 2 * attempts) * n_cells
            across = uniform(state, gamma, 2 * attempts + 1) * n_cells
            attempts += 1
            i = min(floor(along), n_cells - 1)
            j = min(floor(across), n_cells - 1)
            x = (along - i - 0.5) * side
            y = (across - j - 0.5) * side
            if is_free(cells, i * n_cells + j, x, y, 0.0):
                places[m, 0] = i - middle
                places[m, 1] = j - middle
                places[m, 2] = x
                places[m, 3] = y
                break
    return places
