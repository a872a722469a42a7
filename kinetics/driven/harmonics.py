"""Angular harmonics about the field, and products of distributions with components of the velocity.

Family 0: Y_m = cos(m phi) in the plane, P_m(cos theta) in space. Family 1, of a vector across the
field: sin(m phi), and P_m^1(cos theta) cos(azimuth), m = 1, 2, ... The sums of a distribution f are
its integrals with Y_m over the directions, so f = sum over m of sums_m Y_m/norm_m. With F_m(v) the
sums of f, those of its derivative along the field are

    up_m (F_{m+1}' + (m+d-1) F_{m+1}/v) + down_m (F_{m-1}' - (m-1) F_{m-1}/v).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.numerics import FloatArray
from kinetics.numerics.blocks import BlockElimination

_ABSORBED, _FALL = 2.0, 8.0  # how strongly, and with which power of m/M, harmonics are damped


def angular(
    cosine: FloatArray, sine: FloatArray, count: int, dimension: int, families: int = 2
) -> tuple[FloatArray, ...]:
    """Harmonics m = 0 ... count - 1 at angles (n,), without the azimuth: (count, n) per family."""
    zero, one = np.zeros(cosine.size), np.ones(cosine.size)
    found = []
    for odd, (first, second) in enumerate(((one, cosine), (zero, sine))[:families]):
        table = np.empty((count, cosine.size))
        table[0], table[1] = first, second
        for m in range(2, count):
            np.multiply(cosine, table[m - 1], out=table[m])
            if dimension == 2:
                table[m] *= 2.0
                table[m] -= table[m - 2]
            else:
                table[m] *= (2 * m - 1) / (m - odd)
                table[m] -= (m - 1 + odd) / (m - odd) * table[m - 2]
        found.append(table)
    return tuple(found)


def norms(count: int, dimension: int) -> FloatArray:
    """Integrals of Y_m^2 over the directions, (2, count, 1) for both families."""
    m = np.arange(count)[:, None]
    if dimension == 2:
        return math.pi * np.stack([np.where(m == 0, 2.0, 1.0), np.ones(m.shape)])
    odd = np.where(m == 0, 1.0, 0.5 * m * (m + 1.0))  # there is no m = 0 in family 1
    return 4.0 * math.pi / (2.0 * m + 1.0) * np.stack([np.ones(m.shape), odd])


def up(m: int, family: int, dimension: int) -> float:
    """The share of harmonic m + 1 in cos times harmonic m."""
    if dimension == 2:
        return 1.0 if m == 0 else 0.5
    return (m - family + 1.0) / (2.0 * m + 1.0)


def down(m: int, family: int, dimension: int) -> float:
    """The share of harmonic m - 1 in cos times harmonic m."""
    if m == family:
        return 0.0
    return 0.5 if dimension == 2 else (m + family) / (2.0 * m + 1.0)


def along(sums: NDArray[Any], family: int, dimension: int) -> NDArray[Any]:
    """The sums (M + 1, n) of cos f, from those of f, in the same family."""
    out = np.zeros_like(sums)
    for m in range(family, len(sums)):
        if m + 1 < len(sums):
            out[m] = up(m, family, dimension) * sums[m + 1]
        if m > family:
            out[m] += down(m, family, dimension) * sums[m - 1]
    return out


def across(sums: NDArray[Any], family: int, dimension: int) -> NDArray[Any]:
    """The sums of f times the component of the direction across the field, in the other family.

    family : that of f; 1 in the plane only
    """
    out, m = np.zeros_like(sums), np.arange(1.0, len(sums))[:, None]
    if family:
        out[:-1] = 0.5 * sums[1:]
        out[1:] -= 0.5 * sums[:-1]
        out[0] *= 2.0
    else:
        share = 0.5 * (np.ones_like(m) if dimension == 2 else m * (m + 1.0) / (2.0 * m + 1.0))
        out[1:] = share * sums[:-1]
        out[1:-1] -= share[:-1] * sums[2:]
    return out


@dataclass(frozen=True)
class Chain:
    """The sums of a distribution lose lost[m] F_m, and the field takes them to other harmonics.

    dimension : d
    lost : of harmonics 0 ... M, per unit time, (M + 1, size, size)
    slopes : d/dv of even and of odd harmonics, (size, size) each
    inverse : 1/v, (size,)
    field : its strength; at 0 no harmonic knows another
    absorbs : whether the highest harmonics are damped: where a field alone bends slow tracers, on
        the ray along it f is not smooth, as tracers on it have come by rest; what is as rough as
        that travels to ever higher harmonics, and leaves there
    """

    dimension: int
    lost: FloatArray
    slopes: tuple[FloatArray, FloatArray]
    inverse: FloatArray
    field: float = 1.0
    absorbs: bool = True

    def _pull(self, share: float, parity: int, turn: float) -> FloatArray:
        return share * (self.slopes[parity % 2] + np.diag(turn * self.inverse))

    def from_above(self, m: int, family: int = 0) -> FloatArray:
        """What harmonic m + 1 takes from row m per unit time, in a unit field."""
        return self._pull(up(m, family, self.dimension), m + 1, m + self.dimension - 1.0)

    def from_below(self, m: int, family: int = 0) -> FloatArray:
        """What harmonic m - 1 takes from row m per unit time, in a unit field."""
        return self._pull(down(m, family, self.dimension), m - 1, 1.0 - m)

    def pulled(self, sums: FloatArray) -> FloatArray:
        """What a unit field adds to sums of family 0 per unit time."""
        out = np.zeros_like(sums)
        for m in range(len(sums) - 1):
            out[m] -= self.from_above(m) @ sums[m + 1]
            out[m + 1] -= self.from_below(m + 1) @ sums[m]
        return out

    def elimination(
        self,
        family: int = 0,
        shift: complex = 0.0,
        border: tuple[FloatArray, FloatArray] | None = None,
    ) -> BlockElimination:
        """Solves (shift + field + collisions) F = source for all harmonics of a family.

        They are eliminated in pairs, from the highest pair down: at low speeds the field outweighs
        the collisions, so that a single harmonic is no good pivot.
        border : for shift 0 the mass of harmonic 0, and a source: the system alone is singular
        """
        last = len(self.lost) - 1
        diagonal = np.diag(np.full(self.inverse.size, shift if shift.imag else shift.real))

        def own(m: int) -> NDArray[Any]:
            leaves = _ABSORBED * m * (m / max(last, 1)) ** _FALL * self.field * self.absorbs
            return self.lost[m] + diagonal + np.diag(leaves * self.inverse)

        return BlockElimination(
            family, last, own, lambda m: self.field * self.from_below(m, family),
            lambda m: self.field * self.from_above(m, family), self.field > 0.0, border,
        )  # fmt: skip
