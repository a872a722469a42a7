"""The scatterers of one configuration: placed at random or given, in equilibrium if asked for."""

from math import floor

import numpy as np

from particles.cells import Cells, cell_at, empty_box, insert, insert_all, is_free
from particles.checks import refuse
from particles.compiled import inlined, kernel
from particles.media import BoltzmannGrad, Medium, Positions, Random
from particles.streams import EQUILIBRATION, PLACEMENT, PLACES, open_stream, uniform

# Random sequential addition ends when so many attempts to place one scatterer have failed. If
# 1/1000 of the box were still free, the chance that all of them fail would be exp(-20).
ATTEMPTS = 20_000


def build(medium: Medium, seed: np.uint64, configuration: int) -> Cells | None:
    """Return the scatterers of one configuration, or None where the medium has none.

    Tracers start at the centre of the middle cell. Raises ValueError if not all scatterers can be
    placed.
    """
    if isinstance(medium, BoltzmannGrad):
        return None
    cells, positions = _placed(medium, (seed, configuration))
    if isinstance(medium, Positions) or medium.equilibrate:
        cells = empty_box(medium.box_side / medium.diameter, medium.count, medium.dimension)
        insert_all(cells, positions)
    return cells


def scatterers(medium: Medium, seed: np.uint64, configuration: int) -> np.ndarray | None:
    """Return the places of what `build` returns, (count, 3), in d from where tracers start."""
    if isinstance(medium, BoltzmannGrad):
        return None
    return _placed(medium, (seed, configuration))[1]


def _placed(
    medium: Random | Positions, key: tuple[np.uint64, int]
) -> tuple[Cells | None, np.ndarray]:
    """Return the places of the scatterers, and the cells that list them unless they have moved."""
    d, dimension, count = medium.diameter, medium.dimension, medium.count
    if isinstance(medium, Positions):
        own = medium.positions if medium.positions.ndim == 2 else medium.positions[key[1]]
        return None, np.insert((own - np.array(medium.start)) / d, 2, 0.0, axis=1)
    box = medium.box_side / d
    cells, positions = empty_box(box, count, dimension), np.empty((count, 3))
    placed = _place_at_random(cells, positions, box, medium.overlapping, key)
    if placed < count:
        what = "disks" if dimension == 2 else "spheres"
        reached = medium.number_density * placed / count
        allowed = f"only {placed} of {count} {what} could be placed, a density of {reached:.3g}"
        refuse("number_density", medium.number_density, allowed)
    if medium.equilibrate:
        _equilibrate(positions, box, dimension, medium.equilibrate, key)
    return cells, positions


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
    """Fill an empty box at random; return how many scatterers were placed. key: of the stream.

    Each is uniform in the box and rejected within 1 of the box's centre, where tracers start, and,
    unless overlapping, of one placed before (random sequential addition). positions (count, 3):
    receives their places from the middle.
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


def _equilibrate(
    positions: np.ndarray, box: float, dimension: int, sweeps: int, key: tuple[np.uint64, int]
) -> None:
    """Move hard scatterers until they are in equilibrium, `sweeps` attempts each.

    Metropolis moves in the canonical ensemble, around a clearing of radius 1 at the middle that
    stays free. Any symmetric step is right; one of about twice the mean gap is accepted often
    enough to move them soon.
    """
    count = len(positions)
    # Bins at least 1 wide, about one scatterer in each: neighbours are in the bins around.
    n = max(3, min(int(box), int(np.ceil(count ** (1 / dimension)))))
    heads, links = np.full(n**dimension, -1, np.int32), np.full(count, -1, np.int32)
    gap = (box**dimension / count) ** (1 / dimension) - 1.0
    _sweep(positions, heads, links, (n,) * dimension, box, max(2.0 * gap, 0.1), sweeps, key)


@inlined
def _bin(x: float, box: float, n: int) -> int:
    return min(int((x / box + 0.5) * n), n - 1)


@inlined
def _bin_of(place: tuple[float, float, float], box: float, shape: tuple[int, ...]) -> int:
    n = shape[0]
    x, y, z = place
    return cell_at(shape, _bin(x, box, n), _bin(y, box, n), _bin(z, box, n))


@kernel
def _sweep(
    positions: np.ndarray, heads: np.ndarray, links: np.ndarray, shape: tuple[int, ...], box: float,
    step: float, sweeps: int, key: tuple[np.uint64, int],
) -> None:  # fmt: skip
    """Make the moves; the largest change of a coordinate is step/2.

    heads (bins,), links (count,): receive the scatterers of each bin, as chains that -1 ends.
    """
    count, dimension = positions.shape[0], len(shape)
    for m in range(count):
        home = _bin_of((positions[m, 0], positions[m, 1], positions[m, 2]), box, shape)
        links[m] = heads[home]
        heads[home] = m
    state, gamma = open_stream(key[0], EQUILIBRATION, key[1], 0)
    for attempt in range(sweeps * count):
        draw = (dimension + 1) * attempt
        m = min(int(uniform(state, gamma, draw) * count), count - 1)
        old = positions[m, 0], positions[m, 1], positions[m, 2]
        x = old[0] + (uniform(state, gamma, draw + 1) - 0.5) * step
        y = old[1] + (uniform(state, gamma, draw + 2) - 0.5) * step
        z = 0.0
        if dimension == 3:
            z = old[2] + (uniform(state, gamma, draw + 3) - 0.5) * step
        x -= box * floor(x / box + 0.5)
        y -= box * floor(y / box + 0.5)
        z -= box * floor(z / box + 0.5)
        if x * x + y * y + z * z < 1.0:
            continue
        if not _has_room(positions, heads, links, shape, box, (x, y, z), m):
            continue
        home = _bin_of(old, box, shape)
        if heads[home] == m:
            heads[home] = links[m]
        else:
            before = heads[home]
            while links[before] != m:
                before = links[before]
            links[before] = links[m]
        positions[m, 0], positions[m, 1], positions[m, 2] = x, y, z
        home = _bin_of((x, y, z), box, shape)
        links[m] = heads[home]
        heads[home] = m


@inlined
def _has_room(
    positions: np.ndarray, heads: np.ndarray, links: np.ndarray, shape: tuple[int, ...], box: float,
    place: tuple[float, float, float], own: int,
) -> bool:  # fmt: skip
    """Tell whether no scatterer but number `own` is nearer than 1 to a place."""
    n, layers = shape[0], 1 if len(shape) == 3 else 0
    x, y, z = place
    i, j, k = _bin(x, box, n), _bin(y, box, n), _bin(z, box, n)
    for di in range(-1, 2):
        for dj in range(-1, 2):
            for dk in range(-layers, layers + 1):
                other = heads[cell_at(shape, i + di, j + dj, k + dk)]
                while other >= 0:
                    dx, dy = positions[other, 0] - x, positions[other, 1] - y
                    dz = positions[other, 2] - z
                    dx -= box * floor(dx / box + 0.5)
                    dy -= box * floor(dy / box + 0.5)
                    dz -= box * floor(dz / box + 0.5)
                    if other != own and dx * dx + dy * dy + dz * dz < 1.0:
                        return False
                    other = links[other]
    return True


@kernel
def free_places(
    cells: Cells, seed: np.uint64, configuration: int, first: int, n: int
) -> np.ndarray:
    """Return where n tracers from number `first` on begin at rest: i, j, x, y of each, (n, 4).

    Tracers that move all begin at one place, the centre: their velocities tell them apart. At rest
    there, they would all have one path. i, j: the cell, from the middle one; x, y: the place from
    its centre, in d. Tracer 0 begins at the centre of the middle cell, every other one at a random
    place in the box that no disk covers; at the centre, too, where there is hardly any.
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
