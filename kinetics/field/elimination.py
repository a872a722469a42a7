r"""The chain of angular harmonics about the field, and its elimination.

With f = sum_m f_m(v) cos(m phi) in the plane, sum_m f_m(v) P_m(cos theta) in space, row m of the
derivative along the field is

    up_m (f_{m+1}' + (m+d-1) f_{m+1}/v) + down_m (f_{m-1}' - (m-1) f_{m-1}/v).

Of a vector across the field (family 1) harmonics are sin(m phi), and P_m^1(cos theta) cos(azimuth)
in space, m = 1, 2, ... Harmonics are eliminated in pairs, from the highest pair down: at low speeds
the field outweighs the collisions, so that a single harmonic is no good pivot.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.field.grid import SpeedPanels
from kinetics.numerics import FloatArray
from kinetics.numerics.blocks import BlockElimination


@dataclass(frozen=True)
class Chain:
    """The coupling of harmonics of one family.

    panels : the speed axis
    dimension : 2 or 3
    family : 0 for averages along the field, 1 for those across it
    """

    panels: SpeedPanels
    dimension: int
    family: int = 0

    def up(self, m: int) -> float:
        """The factor with which harmonic m + 1 enters row m; also in the product with cos."""
        if self.dimension == 2:
            return 0.5
        return (m + 1.0 + self.family) / (2.0 * m + 3.0)

    def down(self, m: int) -> float:
        """The factor with which harmonic m - 1 enters row m; also in the product with cos."""
        if self.dimension == 2:
            return 1.0 if m == 1 and self.family == 0 else 0.5
        return (m - self.family) / (2.0 * m - 1.0)

    @cached_property
    def _slopes(self) -> tuple[FloatArray, FloatArray]:
        return tuple(self.panels.slopes(even, self.dimension) for even in (True, False))  # type: ignore[return-value]

    def from_above(self, m: int) -> FloatArray:
        """v times what harmonic m + 1 adds to row m, shape (size, size)."""
        return self._from_above(m, self._slopes[(m + 1) % 2])

    def _from_above(self, m: int, slopes: FloatArray) -> FloatArray:
        out = self.up(m) * slopes
        out.ravel()[:: out.shape[0] + 1] += self.up(m) * (m + self.dimension - 1.0)
        return out

    def beyond(self, m: int) -> FloatArray:
        """v times what harmonic m + 1 adds to the last row m; acts on harmonic m.

        On the ray along the field f is not smooth: tracers on it have come by rest, and f_m falls
        as m^-3. So f_(m+1) = (m/(m+1))^3 f_m; what is as rough as that travels towards high
        harmonics, and leaves here. With the slope of an odd harmonic this term only takes away from
        the integral of the square: steps are stable for any number of harmonics.
        """
        return (m / (m + 1.0)) ** 3 * self._from_above(m, self._slopes[1])

    def from_below(self, m: int) -> FloatArray:
        """v times what harmonic m - 1 adds to row m, shape (size, size)."""
        out = self.down(m) * self._slopes[(m - 1) % 2]
        out.ravel()[:: out.shape[0] + 1] -= self.down(m) * (m - 1.0)
        return out

    def highest(self, most: int) -> int:
        """The highest harmonic up to ``most`` with which they come in pairs."""
        return most - (most - self.family + 1) % 2

    def along(self, f: NDArray[Any]) -> NDArray[Any]:
        """Harmonics of v_z f, from those of f (M + 1, size), up to M."""
        m = range(len(f))
        up, down = np.array([self.up(k) for k in m]), np.array([self.down(k) for k in m])
        out = np.zeros_like(f)
        out[:-1] = up[:-1, None] * f[1:]
        out[1:] += down[1:, None] * f[:-1]
        return np.asarray(out * self.panels.speeds)

    def across(self, f: NDArray[Any]) -> NDArray[Any]:
        """Harmonics of v_x f in the other family, x across the field; from family 1 for disks."""
        out, m = np.zeros_like(f), np.arange(len(f))[:, None]
        if self.dimension == 2:
            sign = 1.0 if self.family else -1.0
            out[:-1] = 0.5 * sign * f[1:]
            out[1:] -= 0.5 * sign * f[:-1]
            out[1] -= 0.5 * sign * f[0]
            out[0] *= self.family
        else:
            out[1:] = f[:-1] / (2.0 * m[1:] - 1.0)
            out[1:-1] -= f[2:] / (2.0 * m[1:-1] + 3.0)
        return np.asarray(out * self.panels.speeds)


class Elimination(BlockElimination):
    """Solves (shift + field + collisions) f = source for all harmonics of a chain.

    chain : the coupling by the field
    collisions : v^2 (1 - K_m), from `collision_matrices`, for m = 0 ... M; the highest harmonic is
        M, or M - 1 if only then harmonics come in pairs
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
        self.chain = chain
        self.highest = highest = chain.highest(len(collisions) - 1)
        on_diagonal = np.diag(shift * chain.panels.speeds)

        def own(m: int) -> NDArray[Any]:
            block = collisions[m] + on_diagonal
            return np.asarray(block + chain.beyond(m) if m == highest else block)

        super().__init__(
            chain.family, highest, own, chain.from_below, chain.from_above, border=border
        )
