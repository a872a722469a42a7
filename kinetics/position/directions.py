r"""Directions in the plane and in space: what depends on the dimension in `kinetics.position`.

psi, the average of exp(i k.r) for a tracer that starts at angle theta to k, has harmonics: in the
plane psi = sum over all m of i^|m| a_|m| exp(i m theta), in space psi = sum_m (2m + 1) i^m a_m
P_m(cos(theta)). Free flights over T have a_m = J_m(K T), in space j_m(K T), and obey

    da_m/dT = (K/2) (a_(m-1) - a_(m+1)),    da_m/dT = K (m a_(m-1) - (m+1) a_(m+1))/(2m + 1),

with a_(-1) = a_1 in the first. The second looks like the first in other units, b_m = g_m a_m:

    db_m/dT = (K/2) c_m (b_(m-1) - b_(m+1)),    b_(-1) = -b_1,    c_0 = 2/pi,
    g_m = sqrt(pi) Gamma(m/2 + 1)/Gamma((m + 1)/2),    c_m = (2m/(2m + 1)) g_m/g_(m-1).

In the plane g_m = c_m = 1.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.numerics import FloatArray


def _units(top: int) -> FloatArray:
    """g_m in space for m up to ``top``, shape (top + 1,)."""
    g = np.ones(top + 2)
    g[1] = 0.5 * math.pi
    for m in range(1, top + 1):
        g[m + 1] = g[m - 1] * (m + 1) / m
    return g[: top + 1]


def coupling(top: int, dimension: int) -> FloatArray:
    """c_m for m up to ``top``, shape (top + 1,)."""
    if dimension == 2:
        return np.ones(top + 1)
    g, m = _units(top), np.arange(1, top + 1)
    return np.append(2.0 / math.pi, 2.0 * m / (2.0 * m + 1.0) * g[1:] / g[:-1])


def share_of_harmonic(m: int, mean: NDArray[Any], angle: float, dimension: int) -> NDArray[Any]:
    """What harmonic m adds to F(k, t), in the plane together with -m; shape of ``mean``.

    mean : average of b_m with the weights of harmonic m of the initial state (in space that of
        P_m(cos theta), theta the angle to the x axis)
    angle : of k to the x axis
    """
    if m == 0:
        return np.asarray(mean.real)
    if dimension == 2:
        return np.asarray(2.0 * 1j**m * (np.exp(1j * m * angle) * mean).real)
    from scipy.special import eval_legendre

    factor = (2 * m + 1) / _units(m)[m] * float(eval_legendre(m, math.cos(angle)))
    return np.asarray(1j**m * factor * mean.real)


def mean_phase(x: FloatArray, dimension: int) -> FloatArray:
    """The mean of exp(i k.r) over the directions, x = k r: J_0(x), in space sin(x)/x."""
    if dimension == 2:
        from scipy.special import j0

        return np.asarray(j0(x))
    near = np.where(x == 0.0, 1.0, x)
    return np.asarray(np.where(x == 0.0, 1.0, np.sin(x) / near))


def element(r: FloatArray, dimension: int) -> FloatArray:
    """r^(d-1): the circle or sphere of radius r, over the unit one."""
    return r if dimension == 2 else r * r


def surface(dimension: int) -> float:
    """Of the unit circle or sphere."""
    return 2.0 * math.pi * (dimension - 1.0)


# The equations of one panel, for each wave number K; in space each row is over its coupling:
#     blocks_m a_m = right_m + K turn (a_(m-1) - a_(m+1)),    a_(-1) = -a_1.
# Shapes: blocks (m, nodes, nodes), turn (nodes,), right and the solution (m, nodes, n_k),
# wave_numbers (n_k,). The number of harmonics is odd; beyond the last a_(m+1) = closure a_m, as in
# steady free flights.


def iterate(
    blocks: FloatArray, turn: FloatArray, right: FloatArray, wave_numbers: FloatArray, least: float,
    rounds: int = 24,
) -> FloatArray | None:  # fmt: skip
    """Odd harmonics from even ones and these from those, until less than ``least`` changes.

    With free flights of K (T_1 - T_0) = x on the panel, j rounds leave about x^(2 j)/(2 j)!.
    The matrices are those of a harmonic, whatever K. None where it takes too many rounds.
    """
    inverse = np.linalg.inv(blocks)
    alone = inverse @ right
    spread = inverse * turn
    even, odd = alone[::2].copy(), alone[1::2].copy()
    closure = wave_numbers / (1.0 + np.sqrt(1.0 + wave_numbers**2))
    between = np.empty_like(even)
    for _ in range(rounds):
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
    pairs = (count - 1) // 2
    closure = wave_numbers / (1.0 + np.sqrt(1.0 + wave_numbers**2))
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
