"""The speed axis of driven tracers: polynomials in one smooth variable, from rest to the top.

v = S sinh(Z x^p), x in [0, 1]: uniform below the scale S, logarithmic above it. p = 10 where
nothing drives: one polynomial then holds ten decades of speeds, and powers v^(1/10) too. p = 2
where a field alone drives: averages have terms v^n ln v, which are smoother in x. Moving
scatterers make every average a smooth function of the velocity: harmonic m is then an even or an
odd polynomial, as m is. No point lies at either end, and nothing is imposed there: at rest
polynomials alone are regular, and at the top all that leads beyond it is faded out.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from kinetics.numerics import FloatArray
from kinetics.numerics.chebyshev import derivative_matrix, interpolation_rows
from kinetics.numerics.gauss import gauss_legendre, panels_between

FADING = 40.0  # the power of v/top with which what leads beyond the top is faded out


@dataclass(frozen=True)
class SpeedAxis:
    """Chebyshev points of the first kind in x; or half of those from -1 to 1.

    highest : the highest speed
    scale : S, below which points are uniform in x^p
    size : their number
    power : p
    smooth : whether functions are even and odd polynomials in x; p is then 1
    fading : whether what drives fades out towards the top; steady states in a field need no end
    """

    highest: float
    scale: float
    size: int
    power: float = 1.0
    smooth: bool = False
    fading: bool = True

    @cached_property
    def _span(self) -> float:
        return math.asinh(self.highest / self.scale)

    @cached_property
    def _points(self) -> tuple[FloatArray, FloatArray]:
        """All points on [0, 1], rising, and their barycentric weights."""
        count = 2 * self.size if self.smooth else self.size
        angle = (np.arange(count) + 0.5) * math.pi / count
        weights = (-1.0) ** np.arange(count) * np.sin(angle)
        return np.asarray(0.5 * (1.0 - np.cos(angle))), np.asarray(weights)

    @cached_property
    def _place(self) -> FloatArray:
        """x at the points, rising, (size,)."""
        local = self._points[0]
        return 2.0 * local[self.size :] - 1.0 if self.smooth else local

    def _speed(self, x: FloatArray) -> FloatArray:
        return np.asarray(self.scale * np.sinh(self._span * x**self.power))

    def _stretch(self, x: FloatArray) -> FloatArray:
        """dv/dx."""
        rise = self._span * self.power * x ** (self.power - 1.0)
        return np.asarray(self.scale * np.cosh(self._span * x**self.power) * rise)

    def _folded(self, rows: FloatArray, parity: int) -> FloatArray:
        """Rows that act on values at all points, so that they act on those at x > 0."""
        if not self.smooth:
            return rows
        return rows[:, self.size :] + (1 - 2 * parity) * rows[:, self.size - 1 :: -1]

    @cached_property
    def speeds(self) -> FloatArray:
        """v at the points, rising, (size,)."""
        return self._speed(self._place)

    @lru_cache(maxsize=2)  # noqa: B019
    def derivative(self, parity: int) -> FloatArray:
        """d/dv, at the points, of an even (parity 0) or odd polynomial, (size, size)."""
        slopes = self._folded(derivative_matrix(*self._points)[-self.size :], parity)
        return slopes * ((0.5 if self.smooth else 1.0) / self._stretch(self._place))[:, None]

    @cached_property
    def faded(self) -> FloatArray:
        """1, and 0 at the top, smoothly, if ``fading``, (size,)."""
        return 1.0 - (self.speeds / self.highest) ** FADING * self.fading

    def local(self, v: FloatArray) -> FloatArray:
        """x of any speeds; those near the top and beyond it are folded under it, smoothly.

        Where p > 1 no collision makes a tracer faster, and none is folded.
        """
        y = np.minimum(v / self.highest, 8.0)
        if self.power == 1.0:
            y = y * (1.0 + y**FADING) ** (-1.0 / FADING)
        x = np.arcsinh(y * (self.highest / self.scale)) / self._span
        return np.clip(x if self.power == 1.0 else x ** (1.0 / self.power), 0.0, 1.0)

    def interpolation(self, v: FloatArray, parity: int = 0) -> FloatArray:
        """Interpolation to speeds v (n,), shape (n, size)."""
        x = self.local(v)
        nodes, weights = self._points
        difference = (0.5 * (1.0 + x) if self.smooth else x)[:, None] - nodes
        return self._folded(interpolation_rows(difference, weights), parity)

    def polynomials(self, v: FloatArray) -> tuple[NDArray[Any], NDArray[Any]]:
        """Chebyshev polynomials at speeds v (n,), even and odd ones, shape (n, size) each."""
        return self._polynomials(self.local(v))

    def _polynomials(self, x: FloatArray) -> tuple[NDArray[Any], NDArray[Any]]:
        if self.smooth:
            table = chebyshev.chebvander(x, 2 * self.size - 1)
            return table[:, 0::2], table[:, 1::2]
        table = chebyshev.chebvander(2.0 * x - 1.0, self.size - 1)
        return table, table

    def changes(self, log_loss: FloatArray) -> Iterator[FloatArray]:
        """What each polynomial changes at the points as v falls to v s, -ln s (n,): (size, n) each.

        To all digits where s is near 1; not for even and odd polynomials.
        """
        before, x = (self.speeds / self.scale)[:, None], self._place[:, None]
        after, fallen = before * np.exp(-log_loss), before * -np.expm1(-log_loss)
        both = before * np.hypot(1.0, after) + after * np.hypot(1.0, before)
        share = np.arcsinh(fallen * (before + after) / both) / (self._span * x**self.power)
        with np.errstate(divide="ignore"):
            moved = 2.0 * x * np.expm1(np.log1p(-np.minimum(share, 1.0)) / self.power)
        place = 2.0 * x - 1.0
        last, here = np.zeros_like(moved), moved  # the change, and the polynomial itself
        values = np.ones_like(x), place
        yield last
        for _ in range(1, self.size):
            yield here
            last, here = here, 2.0 * ((place + moved) * here + moved * values[1]) - last
            values = values[1], 2.0 * place * values[1] - values[0]

    def to_coefficients(self, parity: int) -> FloatArray:
        """From values at the points to coefficients of these polynomials, (size, size)."""
        table = self._polynomials(self._place)[parity].T * (2.0 / self.size)
        if not (self.smooth and parity):
            table[0] *= 0.5
        return np.asarray(table)

    # -- densities, from the averages of the polynomials that are 1 at one point, 0 at the others --

    def averaged(self, density: Callable[[FloatArray], Any], parity: int, kinks: Any) -> Any:
        """These averages over a density of the speed, (size,)."""
        place = (np.arcsinh(kinks / self.scale) / self._span) ** (1.0 / self.power)
        # polynomials turn twice, at most, from one end to the next
        ends = 0.5 - 0.5 * np.cos(np.linspace(0.0, math.pi, self.size // 2 + 2))
        x, w = panels_between(np.union1d(ends, np.minimum(place, 1.0)), 12)
        v = self._speed(x)
        return (w * self._stretch(x) * density(v)) @ self.interpolation(v, parity)

    def power_average(
        self, sums: FloatArray, p: float, parity: int, dimension: int, width: float
    ) -> float:
        """The average of v^p of a harmonic of these sums (size,), also where v^p bends at rest.

        Even or odd polynomials converge slowly to a power of the other parity. Here v^p is
        projected on those of half the degree, with the weight W = v^(d-1) exp(-v^2/(4 width^2)).
        What the projection leaves out is orthogonal to them: of a density f it takes only what f/W
        has beyond half the degree, which is small where f is smooth.

        Parameters
        ----------
        sums : averages of the polynomials that are 1 at one point
        p : above -d
        parity : of the harmonic
        dimension : d
        width : of the density, sqrt(<v^2>/d)
        """
        half_degree = self.size // 2
        # x^2 for x: nodes are dense near rest, where v^p bends
        node, node_weight = gauss_legendre(8 * self.size)
        x = node**2
        v = self._speed(x)
        volume = 2.0 * node * node_weight * self._stretch(x) * v ** (dimension - 1.0)
        root = np.sqrt(volume * np.exp(-0.25 * (v / width) ** 2))
        at_nodes = self._polynomials(x)[parity][:, :half_degree]
        at_points = self._polynomials(self._place)[parity][:, :half_degree]
        projection = np.linalg.lstsq(root[:, None] * at_nodes, root * v**p, rcond=None)[0]
        return float(sums @ (at_points @ projection))

    def density(self, sums: FloatArray, v: FloatArray, dimension: int) -> FloatArray:
        """f at speeds v (n,), where f_m v^(d-1) has these averages (M + 1, size): (M + 1, n).

        As a polynomial of half the degree: averages of higher ones are less accurate.
        """
        half, d = self.size // 2, dimension
        x, w = gauss_legendre(2 * self.size)
        nodes = self._speed(x)
        weight = (w * nodes ** (d - 1.0) * self._stretch(x))[:, None]
        out = np.empty((len(sums), v.size))
        power = 2.0 if self.power == 2.0 else 1.0  # near rest x^2 is the better variable
        tables = [self._polynomials(at**power) for at in (self._place, x, self.local(v))]
        for m, one in enumerate(sums):
            points, rows, asked = (table[m % 2][:, :half] for table in tables)
            out[m] = asked @ np.linalg.solve(rows.T @ (weight * rows), points.T @ one)
        return np.where(v < self.highest, out, 0.0)
