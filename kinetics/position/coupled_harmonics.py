r"""The equations of one panel: harmonics, each coupled to the two beside it by free flights.

    blocks_m a_m = right_m + K turn (a_(m-1) - a_(m+1)),    a_(-1) = -a_1,

for each wave number K; in space in the units of :mod:`kinetics.position.directions`, each row over
its coupling, so that it looks the same. Shapes: blocks (m, nodes, nodes), turn (nodes,), right and
the solution (m, nodes, n_k), wave_numbers (n_k,). The number of harmonics is odd.
"""

from __future__ import annotations

import numpy as np

from kinetics.numerics import FloatArray

_ROUNDS = 24  # of the iteration, at most: a few more than it takes where it is quicker


def _closure(wave_numbers: FloatArray) -> FloatArray:
    """Steady free flights beyond the last harmonic: a_(m+1) = closure a_m, shape (n_k,)."""
    return wave_numbers / (1.0 + np.sqrt(1.0 + wave_numbers**2))


def iterate(
    blocks: FloatArray, turn: FloatArray, right: FloatArray, wave_numbers: FloatArray, least: float
) -> FloatArray | None:
    """Odd harmonics from even ones and these from those, until less than ``least`` changes.

    With free flights of K (T_1 - T_0) = x on the panel, j rounds leave about x^(2 j)/(2 j)!.
    The matrices are those of a harmonic, whatever K. None where it takes too many rounds.
    """
    inverse = np.linalg.inv(blocks)
    alone = inverse @ right
    spread = inverse * turn
    even, odd = alone[::2].copy(), alone[1::2].copy()
    closure = _closure(wave_numbers)
    between = np.empty_like(even)
    for _ in range(_ROUNDS):
        odd = alone[1::2] + spread[1::2] @ ((even[:-1] - even[1:]) * wave_numbers)
        between[0] = -2.0 * odd[0]  # a_1 stands for a_(-1) too
        np.subtract(odd[:-1], odd[1:], out=between[1:-1])
        between[-1] = odd[-1] - closure * even[-1]
        between *= wave_numbers
        new = alone[::2] + spread[::2] @ between
        change = float(np.abs(new - even).max())
        even = new
        if change < max(least, 1e-15):
            out = np.empty_like(alone)
            out[::2], out[1::2] = even, odd
            return out
    return None


def eliminate(
    blocks: FloatArray, turn: FloatArray, right: FloatArray, wave_numbers: FloatArray
) -> FloatArray:
    """Block elimination from both ends to the middle."""
    count, n, size = right.shape
    pairs, closure = (count - 1) // 2, _closure(wave_numbers)
    turn = (turn * wave_numbers[:, None])[None, :, :, None]  # (1, n_k, nodes, 1)
    turn = np.concatenate([turn, -turn])
    right = np.ascontiguousarray(np.moveaxis(right, 2, 1))  # (m, n_k, nodes)
    blocks = blocks[:, None]
    # from above a_m = part[0] (a_(m-1), 1), from below a_m = part[1] (a_(m+1), 1)
    diagonal = np.arange(n)
    both = np.zeros((2, size, n, n + 1))
    both[:, :, diagonal, diagonal] = turn[..., 0]
    both[1, :, diagonal, diagonal] *= 2.0
    parts = np.zeros((pairs + 1, 2, size, n, n + 1))
    parts[0, 0, :, diagonal, diagonal] = closure
    for i in range(pairs):
        ends = [-1 - i, i]
        added = turn * parts[i]
        both[..., n] = right[ends] - added[..., n]
        parts[i + 1] = np.linalg.solve(blocks[ends] + added[..., :n], both)
        if i == 0:  # a_1 stands for a_(-1) too
            both[1, :, diagonal, diagonal] *= 0.5
    added = (turn * parts[pairs]).sum(axis=0)
    middle = (right[pairs] - added[..., n])[..., None]
    a = np.linalg.solve(blocks[pairs] + added[..., :n], middle)
    found = np.empty((count, size, n))
    found[pairs] = a[..., 0]
    for i in range(pairs - 1, -1, -1):
        a = parts[i + 1, ..., :n] @ a + parts[i + 1, ..., n:]
        found[[-1 - i, i]] = a[..., 0]
    return np.moveaxis(found, 1, 2)
