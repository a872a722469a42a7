"""Spheres in a periodic box: placed at random, and moved until they are in equilibrium."""

from math import floor

import numpy as np

from particles.compiled.decorators import kernel
from particles.grid.placement import ATTEMPTS
from particles.streams import EQUILIBRATION, PLACEMENT, open_stream, uniform


def place_spheres(
    box: float, count: int, overlapping: bool, sweeps: int, seed: np.uint64, configuration: int
) -> tuple[np.ndarray, int]:
    """Return positions (count, 3) from the middle of a box, in d, and how many could be placed.

    Each sphere is uniform in the box and rejected within 1 of its middle, where tracers start, and,
    unless overlapping, of a sphere placed before (random sequential addition). Then come `sweeps`
    attempts to move each sphere: Metropolis moves in the canonical ensemble of hard spheres, around
    a clearing of radius 1 at the middle that stays free, as in `particles.grid.equilibrate`.
    """
    positions = np.empty((count, 3))
    # Bins at least 1 wide, about one sphere in each: neighbours are in the 27 bins around.
    n = max(3, min(int(box), int(np.ceil(count ** (1 / 3)))))
    heads, links = np.full((n, n, n), -1, np.int32), np.full(count, -1, np.int32)
    placed = _place(positions, heads, links, box, overlapping, (seed, configuration))
    if sweeps and placed == count:
        gap = (box**3 / count) ** (1 / 3) - 1.0
        _sweep(positions, heads, links, box, max(2.0 * gap, 0.1), sweeps, (seed, configuration))
    return positions, placed


@kernel
def _is_free(
    positions: np.ndarray, heads: np.ndarray, links: np.ndarray, box: float,
    new: tuple[float, float, float], own: int,
) -> bool:  # fmt: skip
    """Tell whether no sphere but number `own` is nearer than 1 to the place `new`."""
    n = heads.shape[0]
    x, y, z = new
    i, j, k = _bin(x, box, n), _bin(y, box, n), _bin(z, box, n)
    for di in range(-1, 2):
        for dj in range(-1, 2):
            for dk in range(-1, 2):
                other = heads[(i + di) % n, (j + dj) % n, (k + dk) % n]
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
def _bin(x: float, box: float, n: int) -> int:
    """Return the bin of a coordinate from -box/2 to box/2."""
    return min(int((x / box + 0.5) * n), n - 1)


@kernel
def _place(
    positions: np.ndarray, heads: np.ndarray, links: np.ndarray, box: float, overlapping: bool,
    key: tuple[np.uint64, int],
) -> int:  # fmt: skip
    """Fill an empty box; return how many spheres were placed. key: seed and configuration."""
    n = heads.shape[0]
    state, gamma = open_stream(key[0], PLACEMENT, key[1], 0)
    draws = 0
    for sphere in range(positions.shape[0]):
        attempts = 0
        while True:
            if attempts == ATTEMPTS:
                return sphere
            attempts += 1
            x = (uniform(state, gamma, draws) - 0.5) * box
            y = (uniform(state, gamma, draws + 1) - 0.5) * box
            z = (uniform(state, gamma, draws + 2) - 0.5) * box
            draws += 3
            if x * x + y * y + z * z < 1.0:
                continue
            if overlapping or _is_free(positions, heads, links, box, (x, y, z), -1):
                break
        positions[sphere, 0], positions[sphere, 1], positions[sphere, 2] = x, y, z
        i, j, k = _bin(x, box, n), _bin(y, box, n), _bin(z, box, n)
        links[sphere] = heads[i, j, k]
        heads[i, j, k] = sphere
    return positions.shape[0]


@kernel
def _sweep(
    positions: np.ndarray, heads: np.ndarray, links: np.ndarray, box: float, step: float,
    sweeps: int, key: tuple[np.uint64, int],
) -> None:  # fmt: skip
    """Move spheres at random, `sweeps` attempts each; the largest change of a coordinate is step/2.

    heads (n, n, n), links (count,): the spheres of each bin, as chains that -1 ends.
    """
    count, n = positions.shape[0], heads.shape[0]
    state, gamma = open_stream(key[0], EQUILIBRATION, key[1], 0)
    for attempt in range(sweeps * count):
        draw = 4 * attempt
        sphere = min(int(uniform(state, gamma, draw) * count), count - 1)
        x = positions[sphere, 0] + (uniform(state, gamma, draw + 1) - 0.5) * step
        y = positions[sphere, 1] + (uniform(state, gamma, draw + 2) - 0.5) * step
        z = positions[sphere, 2] + (uniform(state, gamma, draw + 3) - 0.5) * step
        x -= box * floor(x / box + 0.5)
        y -= box * floor(y / box + 0.5)
        z -= box * floor(z / box + 0.5)
        if x * x + y * y + z * z < 1.0:
            continue
        if not _is_free(positions, heads, links, box, (x, y, z), sphere):
            continue
        i, j = _bin(positions[sphere, 0], box, n), _bin(positions[sphere, 1], box, n)
        k = _bin(positions[sphere, 2], box, n)
        if heads[i, j, k] == sphere:
            heads[i, j, k] = links[sphere]
        else:
            before = heads[i, j, k]
            while links[before] != sphere:
                before = links[before]
            links[before] = links[sphere]
        positions[sphere, 0], positions[sphere, 1], positions[sphere, 2] = x, y, z
        i, j, k = _bin(x, box, n), _bin(y, box, n), _bin(z, box, n)
        links[sphere] = heads[i, j, k]
        heads[i, j, k] = sphere
