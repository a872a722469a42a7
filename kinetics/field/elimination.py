r"""The chain of angular harmonics about the field, and its elimination.

With F_m(v) the sums of f (`harmonics`), those of the derivative along the field are

    up_m (F_{m+1}' + (m+d-1) F_{m+1}/v) + down_m (F_{m-1}' - (m-1) F_{m-1}/v).

Harmonics are eliminated in pairs, from the highest pair down: at low speeds the field outweighs the
collisions, so that a single harmonic is no good pivot.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.field.grid import SpeedPanels
from kinetics.field.harmonics import down, up
from kinetics.numerics import FloatArray
from kinetics.numerics.blocks import BlockElimination


@dataclass(frozen=True)
class Chain:
    """The coupling of harmonics of one family: v times what each adds to a row, (size, size)."""

    panels: SpeedPanels
    dimension: int
    family: int = 0

    @cached_property
    def _slopes(self) -> list[FloatArray]:
        return [self.panels.slopes(even, self.dimension) for even in (True, False)]

    def _part(self, share: float, slopes: FloatArray, turn: float) -> FloatArray:
        out = share * slopes
        out.ravel()[:: out.shape[0] + 1] += share * turn
        return out

    def from_above(self, m: int) -> FloatArray:
        """Of harmonic m + 1 to row m."""
        share = up(m, self.family, self.dimension)
        return self._part(share, self._slopes[(m + 1) % 2], m + self.dimension - 1.0)

    def from_below(self, m: int) -> FloatArray:
        """Of harmonic m - 1 to row m."""
        share = down(m, self.family, self.dimension)
        return self._part(share, self._slopes[(m - 1) % 2], 1.0 - m)

    def beyond(self, m: int) -> FloatArray:
        """Of harmonic m + 1 to the last row m; acts on harmonic m.

        On the ray along the field f is not smooth: tracers on it have come by rest, and f_m falls
        as m^-3. So f_(m+1) = (m/(m+1))^3 f_m; what is as rough as that travels towards high
        harmonics, and leaves here. With the slope of an odd harmonic this term only takes away from
        the integral of the square: steps are stable for any number of harmonics.
        """
        share = (m / (m + 1.0)) ** 3 * down(m + 1, self.family, self.dimension)
        return self._part(share, self._slopes[1], m + self.dimension - 1.0)


class Elimination(BlockElimination):
    """Solves (shift + field + collisions) F = source for all harmonics of a chain.

    collisions : v^2 (1 - K_m), for m = 0 ... M; the highest harmonic is M, or M - 1 if only then
        harmonics come in pairs
    shift : a rate that is added to the loss; it may be complex
    border : for shift 0: a row that is the mass of harmonic 0 and a column that is a source;
        without it the steady state makes the system singular

    Every equation is multiplied by v.
    """

    def __init__(
        self,
        chain: Chain,
        collisions: FloatArray,
        shift: complex = 0.0,
        border: tuple[FloatArray, FloatArray] | None = None,
    ) -> None:
        most, self._speeds = len(collisions) - 1, chain.panels.speeds
        last = most - (most - chain.family + 1) % 2
        on_diagonal = np.diag(shift * self._speeds)

        def own(m: int) -> NDArray[Any]:
            block = collisions[m] + on_diagonal
            return np.asarray(block + chain.beyond(m) if m == last else block)

        super().__init__(chain.family, last, own, chain.from_below, chain.from_above, border=border)

    def solve(self, source: NDArray[Any], last_row: float = 0.0) -> NDArray[Any]:
        """F (n_blocks, size)."""
        return super().solve(source * self._speeds, last_row)
