r"""The chain of angular harmonics about the field, and its elimination.

With f = sum_m f_m(v) cos(m phi) in the plane, sum_m f_m(v) P_m(cos theta) in space, row m of the
derivative along the field is

    up_m (f_{m+1}' + (m+d-1) f_{m+1}/v) + down_m (f_{m-1}' - (m-1) f_{m-1}/v).

Of a vector across the field (family 1) harmonics are sin(m phi), and P_m^1(cos theta) cos(azimuth)
in space, m = 1, 2, ...

On a ray along the field the solution is not smooth, because tracers on it have come by rest: f_m
falls as a power of m, and the last harmonics are continued by two powers. Over time a continuation
must also be stable, see `Chain.beyond`. Harmonics are eliminated
in pairs, from the highest pair down: at low speeds the field outweighs the collisions, so that a
single harmonic is no good pivot.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import lu_factor, lu_solve

from kinetics.field.panels import SpeedPanels
from kinetics.numerics import FloatArray


@dataclass(frozen=True)
class Chain:
    """The coupling of harmonics of one family.

    Parameters
    ----------
    panels : the speed axis
    dimension : 2 or 3
    family : 0 for averages along the field, 1 for those across it
    vanishing : whether even harmonics are 0 at the highest speed, see `SpeedPanels.slopes`
    """

    panels: SpeedPanels
    dimension: int
    family: int = 0
    vanishing: bool = True

    def up(self, m: int) -> float:
        """The factor with which harmonic m + 1 enters row m."""
        if self.dimension == 2:
            return 0.5
        return (m + 1.0 + self.family) / (2.0 * m + 3.0)

    def down(self, m: int) -> float:
        """The factor with which harmonic m - 1 enters row m."""
        if self.dimension == 2:
            return 1.0 if m == 1 and self.family == 0 else 0.5
        return (m - self.family) / (2.0 * m - 1.0)

    @cached_property
    def _slopes(self) -> tuple[FloatArray, FloatArray]:
        even = self.panels.slopes(True, self.vanishing, self.dimension)
        return even, self.panels.slopes(False, self.vanishing, self.dimension)

    def from_above(self, m: int) -> FloatArray:
        """v times what harmonic m + 1 adds to row m, shape (size, size)."""
        return self._from_above(m, self._slopes[(m + 1) % 2])

    def _from_above(self, m: int, slopes: FloatArray) -> FloatArray:
        out = self.up(m) * slopes
        out.ravel()[:: out.shape[0] + 1] += self.up(m) * (m + self.dimension - 1.0)
        return out

    def beyond(self, m: int) -> FloatArray:
        """v times what harmonic m + 1 adds to the last row m, backwards; acts on harmonic m.

        Averages as functions of the first velocity are not smooth against the field, where they
        fall as (-1)^m m^-3. So y_(m+1) = -(m/(m+1))^3 y_m; what is as smooth as (-1)^m travels
        towards high harmonics, and leaves here. With the slope of an odd harmonic this term only
        takes away from the integral of the square: steps are stable for any number of harmonics.
        """
        return -((m / (m + 1.0)) ** 3) * self._from_above(m, self._slopes[1])

    def from_below(self, m: int) -> FloatArray:
        """v times what harmonic m - 1 adds to row m, shape (size, size)."""
        out = self.down(m) * self._slopes[(m - 1) % 2]
        out.ravel()[:: out.shape[0] + 1] -= self.down(m) * (m - 1.0)
        return out

    def highest(self, most: int) -> int:
        """The highest harmonic up to ``most`` with which they come in pairs."""
        return most - (most - self.family + 1) % 2


def continuation(m: ArrayLike, highest: int, powers: tuple[float, float]) -> FloatArray:
    """Factors of harmonics M and M - 1, (2, ...), that continue them by two powers to m > M."""
    inverse = -np.array(powers)[:, None]
    table = np.array([highest, highest - 1.0]) ** inverse
    return np.asarray(np.linalg.solve(table, np.ravel(m) ** inverse)).reshape(2, *np.shape(m))


class Elimination:
    """Solves (shift + field + collisions) f = source for all harmonics of a chain.

    Parameters
    ----------
    chain : the coupling by the field
    collisions : v^2 (1 - K_m), from `collision_matrices`, for m = 0 ... M; the highest harmonic is
        M, or M - 1 if only then harmonics come in pairs
    powers : of 1/m, by which harmonic M + 1 continues the last two; None for `Chain.beyond`
    sign : 1 forwards, for the density; -1 backwards
    shift : a rate that is added to the loss; it may be complex
    border : for shift 0, forwards: a row that is the mass of harmonic 0 and a column that is a
        source; without it the steady state makes the system singular

    Every equation is multiplied by v.
    """

    def __init__(
        self,
        chain: Chain,
        collisions: FloatArray,
        powers: tuple[float, float] | None,
        sign: float = 1.0,
        shift: complex = 0.0,
        border: tuple[FloatArray, FloatArray] | None = None,
    ) -> None:
        self.chain, self.sign = chain, sign
        self.highest = highest = chain.highest(len(collisions) - 1)
        self._continued = np.zeros(2)  # factors of harmonics M and M - 1 in harmonic M + 1
        if powers is not None:
            self._continued = continuation(highest + 1.0, highest, powers)
        n = self._n = chain.panels.size
        self._border = border
        first = chain.family
        on_diagonal = np.diag(shift * chain.panels.speeds)
        self._above = {}
        self._factors: dict[int, tuple[Any, NDArray[Any]]] = {}
        schur: Any = 0.0
        for m in range(highest - 1, first - 1, -2):
            block = np.zeros((2 * n, 2 * n), dtype=on_diagonal.dtype)
            block[:n, :n] = collisions[m] + on_diagonal
            block[n:, n:] = collisions[m + 1] + on_diagonal - schur
            block[:n, n:] = sign * chain.from_above(m)
            block[n:, :n] = sign * chain.from_below(m + 1)
            if m + 1 == highest and powers is None:
                block[n:, n:] += sign * chain.beyond(highest)
            elif m + 1 == highest:
                beyond = sign * chain.from_above(highest)
                last, before = self._continued
                block[n:, n:] += last * beyond
                block[n:, :n] += before * beyond
            if m == first:
                break
            factors = lu_factor(block, overwrite_a=True, check_finite=False)
            below = np.zeros((2 * n, n), dtype=block.dtype)
            below[:n] = sign * chain.from_below(m)
            response = lu_solve(factors, below, overwrite_b=True, check_finite=False)
            self._factors[m] = factors, response
            self._above[m] = sign * chain.from_above(m - 1)
            schur = self._above[m] @ response[:n]
        if border is not None:
            row, column = border
            block = np.pad(block, ((0, 1), (0, 1)))
            block[-1, :n], block[:n, -1] = row, column
        self._last = lu_factor(block, overwrite_a=True, check_finite=False)

    def solve(self, source: NDArray[Any], mass: float = 0.0) -> tuple[NDArray[Any], Any]:
        """Harmonics from ``family`` to ``highest``, and the factor of the column of the border.

        source : times v, of shape (n_harmonics, size) or (n_harmonics, size, n); the results have
            its shape, and (), or (n,)
        """
        first, n = self.chain.family, self._n
        right = np.array(source, dtype=np.result_type(source, self._last[0]))
        part = {}
        for m in range(self.highest - 1, first, -2):
            pair = np.concatenate([right[m - first], right[m + 1 - first]])
            part[m] = lu_solve(self._factors[m][0], pair, check_finite=False)
            right[m - 1 - first] -= self._above[m] @ part[m][:n]
        pair = np.concatenate([right[0], right[1]])
        if self._border is not None:
            pair = np.concatenate([pair, np.full((1, *pair.shape[1:]), mass)])
        found = lu_solve(self._last, pair, check_finite=False)
        out = np.empty_like(right)
        out[0], out[1] = found[:n], found[n : 2 * n]
        for m in range(first + 2, self.highest, 2):
            both = part[m] - self._factors[m][1] @ out[m - 1 - first]
            out[m - first], out[m + 1 - first] = both[:n], both[n:]
        return out, found[2 * n] if self._border is not None else 0.0

    def other_continuation(self, found: NDArray[Any], powers: tuple[float, float]) -> NDArray[Any]:
        """By how much a solution changes, to first order, if other powers continue it."""
        difference = continuation(self.highest + 1.0, self.highest, powers) - self._continued
        source = np.zeros_like(found)
        beyond = self.sign * self.chain.from_above(self.highest)
        source[-1] = -beyond @ (difference[0] * found[-1] + difference[1] * found[-2])
        return self.solve(source)[0]
