"""Equilibrium configurations of hard disks by Metropolis Monte Carlo."""

from math import floor, sqrt

import numpy as np

from particles.compiled.decorators import kernel
from particles.compiled.slots import SLOTS
from particles.grid.cells import Cells
from particles.streams import EQUILIBRATION, open_stream, uniform


@kernel
def centres(cells: Cells, positions: np.ndarray) -> None:
    """Write the centre of every scatterer once, from the middle of the box."""
    n, side = cells.n, cells.side
    half = 0.5 * side
    k = 0
    for cell in range(n * n):
        ox = (cell // n - n // 2) * side
        oy = (cell % n - n // 2) * side
        for slot in range(min(cells.fill[cell], SLOTS)):
            x, y = cells.slots[cell, slot], cells.slots[cell, SLOTS + slot]
            # Taken from the cell that its centre lies in; edges belong to one of two cells.
            if -half <= x < half and -half <= y < half:
                positions[k, 0], positions[k, 1] = ox + x, oy + y
                k += 1
        node = cells.head[cell]
        while node >= 0:
            x, y = cells.nodes[node, 0], cells.nodes[node, 1]
            if -half <= x < half and -half <= y < half:
                positions[k, 0], positions[k, 1] = ox + x, oy + y
                k += 1
            node = cells.links[node]
    assert k == positions.shape[0]


@kernel
def _sweep(
    positions: np.ndarray, grid: np.ndarray, box: float, step: float, sweeps: int,
    key: tuple[np.uint64, int],
) -> float:  # fmt: skip
    """Move disks at random, `sweeps` attempts per disk; return the share accepted.

    positions (count, 2) in a box of this side, in d. grid (n, n): the disk in each bin, -1 if none;
    bins are narrower than 1/sqrt(2), so a bin holds one disk at most and the neighbours of a disk
    lie within two bins of it. step: the largest change of a coordinate is half of it. key: seed and
    configuration.
    """
    count, n = positions.shape[0], grid.shape[0]
    bin_side = box / n
    state, gamma = open_stream(key[0], EQUILIBRATION, key[1], 0)
    accepted = 0
    for attempt in range(sweeps * count):
        k = min(int(uniform(state, gamma, 3 * attempt) * count), count - 1)
        x = positions[k, 0] + (uniform(state, gamma, 3 * attempt + 1) - 0.5) * step
        y = positions[k, 1] + (uniform(state, gamma, 3 * attempt + 2) - 0.5) * step
        x -= box * floor(x / box + 0.5)
        y -= box * floor(y / box + 0.5)
        if x * x + y * y < 1.0:
            continue
        i = min(int((x + 0.5 * box) / bin_side), n - 1)
        j = min(int((y + 0.5 * box) / bin_side), n - 1)
        free = True
        for di in range(-2, 3):
            for dj in range(-2, 3):
                other = grid[(i + di) % n, (j + dj) % n]
                if other >= 0 and other != k:
                    dx, dy = positions[other, 0] - x, positions[other, 1] - y
                    dx -= box * floor(dx / box + 0.5)
                    dy -= box * floor(dy / box + 0.5)
                    if dx * dx + dy * dy < 1.0:
                        free = False
        if free:
            oi = min(int((positions[k, 0] + 0.5 * box) / bin_side), n - 1)
            oj = min(int((positions[k, 1] + 0.5 * box) / bin_side), n - 1)
            grid[oi, oj] = -1
            grid[i, j] = k
            positions[k, 0], positions[k, 1] = x, y
            accepted += 1
    return accepted / (sweeps * count)


def equilibrate(
    cells: Cells, count: int, sweeps: int, seed: np.uint64, configuration: int
) -> np.ndarray:
    """Return positions (count, 2) from the box's middle after `sweeps` attempts to move each disk.

    Metropolis moves in the canonical ensemble of hard disks, around a clearing of radius 1 at the
    middle that stays free. Any symmetric step is right; one of about twice the mean gap between
    disks is accepted often enough to move them soon.
    """
    positions = np.empty((count, 2))
    centres(cells, positions)
    box = cells.side * cells.n
    n = int(np.ceil(box * sqrt(2.0) * 1.0001))
    grid = np.full((n, n), -1, np.int32)
    bins = np.minimum(((positions + 0.5 * box) / (box / n)).astype(np.int64), n - 1)
    grid[bins[:, 0], bins[:, 1]] = np.arange(count)
    gap = sqrt(box * box / count) - 1.0
    _sweep(positions, grid, box, max(2.0 * gap, 0.1), sweeps, (seed, configuration))
    return positions
