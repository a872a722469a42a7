"""Angular harmonics about the field, and products of distributions with components of the velocity.

Family 0: Y_m = cos(m phi) in the plane, P_m(cos theta) in space. Family 1, of a vector across the
field: sin(m phi), and P_m^1(cos theta) cos(azimuth), m = 1, 2, ... The sums of a distribution f are
its integrals with Y_m over the directions, so f = sum over m of sums_m Y_m/norm_m. With F_m(v) the
sums of f, those of its derivative along the field are

    up_m (F_{m+1}' + (m+d-1) F_{m+1}/v) + down_m (F_{m-1}' - (m-1) F_{m-1}/v).

Begin with `Chain`, the equation of all harmonics.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.numerics import FloatArray
from kinetics.numerics.blocks import BlockElimination

#: Harmonic m is damped at the rate ABSORPTION m (m/M)^ABSORPTION_POWER field/v, where harmonics are
#: absorbed. Measured: at half and at twice averages over time move by 5e-6 at rtol 1e-4, densities
#: of the steady state by 7e-4 of the maximum at e = 0, and by 2e-10 at e = 0.7.
ABSORPTION = 2.0
#: So that low harmonics are hardly damped. Measured: at half steady averages lose four digits, and
#: a solution over time takes several times as long; at twice it takes twice as long.
ABSORPTION_POWER = 8.0


def angular(
    cosine: FloatArray, sine: FloatArray, count: int, dimension: int
) -> tuple[FloatArray, FloatArray]:
    """Return harmonics m = 0 ... count - 1 at angles (n,) for each family, (count, n) each.

    Those of family 1 in space are without cos(azimuth). ``count`` is at least 2.
    """
    zero = np.zeros(cosine.size)
    one = np.ones(cosine.size)
    along_field = _recurrence((one, cosine), cosine, count, dimension, family=0)
    across_field = _recurrence((zero, sine), cosine, count, dimension, family=1)
    return along_field, across_field


def angular_along(cosine: FloatArray, count: int, dimension: int) -> FloatArray:
    """Return the harmonics of family 0 alone, (count, n)."""
    return _recurrence((np.ones(cosine.size), cosine), cosine, count, dimension, family=0)


def _recurrence(
    first_two: tuple[FloatArray, FloatArray],
    cosine: FloatArray,
    count: int,
    dimension: int,
    family: int,
) -> FloatArray:
    """Return the harmonics of a family from the first two of them, (count, n)."""
    table = np.empty((count, cosine.size))
    table[0] = first_two[0]
    table[1] = first_two[1]
    for m in range(2, count):
        np.multiply(cosine, table[m - 1], out=table[m])
        if dimension == 2:
            table[m] *= 2.0
            table[m] -= table[m - 2]
        else:
            table[m] *= (2 * m - 1) / (m - family)
            table[m] -= (m - 1 + family) / (m - family) * table[m - 2]
    return table


def norms(count: int, dimension: int) -> FloatArray:
    """Return the integrals of Y_m^2 over the directions, shape (count, 1).

    In the plane they are the same for both families, but that family 1 has no m = 0. In space they
    are those of family 0, the only one there: all starts are symmetric about the field.
    """
    m = np.arange(count)[:, None]
    if dimension == 2:
        return math.pi * np.where(m == 0, 2.0, 1.0)
    return np.asarray(4.0 * math.pi / (2.0 * m + 1.0))


def sum_over_harmonics(f: FloatArray, angle: FloatArray, dimension: int) -> FloatArray:
    """Return the density at angles to the field from its harmonics.

    Parameters
    ----------
    f : integrals of the density with Y_m over the directions, (M + 1, n_v)
    angle : in radians, (n_angle,)
    dimension : d

    Returns
    -------
    Shape (n_v, n_angle)
    """
    count = len(f)
    harmonics = angular_along(np.cos(angle), max(count, 2), dimension)[:count]
    return np.asarray(f.T @ (harmonics / norms(count, dimension)))


def up(m: int, family: int, dimension: int) -> float:
    """Return the share of harmonic m + 1 in cos times harmonic m."""
    if dimension == 2:
        return 1.0 if m == 0 else 0.5
    return (m - family + 1.0) / (2.0 * m + 1.0)


def down(m: int, family: int, dimension: int) -> float:
    """Return the share of harmonic m - 1 in cos times harmonic m."""
    if m == family:
        return 0.0
    if dimension == 2:
        return 0.5
    return (m + family) / (2.0 * m + 1.0)


def along(sums: NDArray[Any], family: int, dimension: int) -> NDArray[Any]:
    """Return the sums (M + 1, n) of cos f, from those of f, in the same family."""
    product = np.zeros_like(sums)
    for m in range(family, len(sums)):
        if m + 1 < len(sums):
            product[m] = up(m, family, dimension) * sums[m + 1]
        if m > family:
            product[m] += down(m, family, dimension) * sums[m - 1]
    return product


def across(sums: NDArray[Any], family: int, dimension: int) -> NDArray[Any]:
    """Return the sums of f times the component of the direction across the field.

    They are of the other family.

    family : that of f; 1 in the plane only
    """
    product = np.zeros_like(sums)
    m = np.arange(1.0, len(sums))[:, None]
    if family:
        product[:-1] = 0.5 * sums[1:]
        product[1:] -= 0.5 * sums[:-1]
        product[0] *= 2.0
        return product
    share = 0.5 * np.ones_like(m)
    if dimension == 3:
        share = 0.5 * (m * (m + 1.0) / (2.0 * m + 1.0))
    product[1:] = share * sums[:-1]
    product[1:-1] -= share[:-1] * sums[2:]
    return product


@dataclass(frozen=True)
class Border:
    """A row and a column that are added to an equation which is singular alone.

    Parameters
    ----------
    mass : the row: sums of harmonic 0 that give the number of tracers, (size,)
    source : the column: a source anywhere in harmonic 0, (size,); its factor comes out as 0
    """

    mass: FloatArray
    source: FloatArray


@dataclass(frozen=True)
class Chain:
    """Collisions act on each harmonic F_m, and a field takes it to the ones beside it.

    Parameters
    ----------
    dimension : d
    lost : what harmonics 0 ... M lose per unit time is lost[m] F_m, (M + 1, size, size)
    slopes : d/dv of even and of odd harmonics, (size, size) each
    inverse : 1/v, (size,)
    field : its strength; at 0 harmonics are not coupled
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

    @property
    def last(self) -> int:
        """M, the highest harmonic."""
        return len(self.lost) - 1

    def from_above(self, m: int, family: int = 0) -> FloatArray:
        """Return what harmonic m + 1 takes from row m per unit time, in a unit field."""
        share = up(m, family, self.dimension)
        return self._pull(share, m + 1, m + self.dimension - 1.0)

    def from_below(self, m: int, family: int = 0) -> FloatArray:
        """Return what harmonic m - 1 takes from row m per unit time, in a unit field."""
        return self._pull(down(m, family, self.dimension), m - 1, 1.0 - m)

    def _pull(self, share: float, source: int, turn: float) -> FloatArray:
        """Return share (d/dv + turn/v) acting on a source harmonic."""
        return share * (self.slopes[source % 2] + np.diag(turn * self.inverse))

    def pulled(self, sums: FloatArray) -> FloatArray:
        """Return what a unit field adds to sums of family 0 per unit time."""
        gained = np.zeros_like(sums)
        for m in range(len(sums) - 1):
            gained[m] -= self.from_above(m) @ sums[m + 1]
            gained[m + 1] -= self.from_below(m + 1) @ sums[m]
        return gained

    def _absorption(self, m: int) -> FloatArray:
        """Return the rate at which harmonic m is damped, (size,)."""
        if not self.absorbs:
            return 0.0 * self.inverse
        rate = ABSORPTION * m * (m / max(self.last, 1)) ** ABSORPTION_POWER * self.field
        return rate * self.inverse

    def elimination(
        self, family: int = 0, shift: complex = 0.0, border: Border | None = None
    ) -> BlockElimination:
        """Return what solves (shift + field + collisions) F = source for a family of harmonics.

        They are eliminated in pairs, from the highest pair down: at low speeds the field outweighs
        the collisions, so that a single harmonic is no good pivot.

        border : for shift 0, where the system alone is singular
        """
        real_or_complex_shift = shift if shift.imag else shift.real
        diagonal = np.diag(np.full(self.inverse.size, real_or_complex_shift))

        def own(m: int) -> NDArray[Any]:
            return self.lost[m] + diagonal + np.diag(self._absorption(m))

        return BlockElimination(
            family,
            self.last,
            own,
            below=lambda m: self.field * self.from_below(m, family),
            above=lambda m: self.field * self.from_above(m, family),
            coupled=self.field > 0.0,
            border=None if border is None else (border.mass, border.source),
        )
