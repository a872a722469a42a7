"""The scatterers of one cell of the unbounded plane, drawn from the cell's own stream."""

from math import exp
from typing import Any

import numpy as np
from numba import njit, uint64

from particles.streams import CELLS, mix, open_stream, uniform


@njit(error_model="numpy", inline="always")
def _stream(i: int, j: int, seed: Any, configuration: int) -> Any:
    # The cell's two numbers are hashed to one: a bijection of each, mixed in turn.
    place = mix(mix(uint64(i)) + uint64(j))
    return open_stream(seed, CELLS, configuration, place)


@njit(error_model="numpy")
def disks_of_cell(
    disks: np.ndarray, i: int, j: int, side: float, mean: float, hard: bool, seed: Any,
    configuration: int,
) -> int:  # fmt: skip
    """Write the centres of cell (i, j)'s scatterers from its own centre; return their number.

    Their number is Poisson with this mean. None lies within 1 of the origin, the centre of cell
    (0, 0), where tracers start.
    """
    state, gamma = _stream(i, j, seed, configuration)
    left = uniform(state, gamma, 0)
    probability = exp(-mean)
    candidates = 0
    while left > probability and candidates < disks.shape[0] - 1:
        left -= probability
        candidates += 1
        probability *= mean / candidates
    n = 0
    for k in range(candidates):
        x = (uniform(state, gamma, 2 * k + 1) - 0.5) * side
        y = (uniform(state, gamma, 2 * k + 2) - 0.5) * side
        ox, oy = x + i * side, y + j * side
        if ox * ox + oy * oy < 1.0:
            continue
        disks[n, 0] = x
        disks[n, 1] = y
        n += 1
    return n
