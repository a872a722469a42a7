"""The speed axis of driven tracers: polynomials in one smooth variable, from rest to the top.

v = S sinh(Z x^p), x in [0, 1]: uniform below the scale S, logarithmic above it. p = 10 where
nothing drives: one polynomial then holds ten decades of speeds, and powers v^(1/10) too. p = 2
where a field alone drives: averages have terms v^n ln v, which are smoother in x. Moving
scatterers make every average a smooth function of the velocity: harmonic m is then an even or an
odd polynomial, as m is. No point lies at either end, and nothing is imposed there: at rest
polynomials alone are regular, and at the top all that leads beyond it is faded out.

`ChebyshevSpeedAxis` implements `kinetics.driven.axis.VelocityAxis`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.polynomial.chebyshev import chebvander
from numpy.typing import NDArray

from kinetics.numerics import FloatArray
from kinetics.numerics.chebyshev import derivative_matrix, interpolation_rows
from kinetics.numerics.gauss import gauss_legendre, panels_between

#: The power of v/top with which what leads beyond the top is faded out. Measured at rtol 1e-6: with
#: 20 densities move by 1e-6 of their maximum; with 80 solutions over time take several times as
#: long.
FADING_POWER = 40.0
#: Speeds over the top are cut here, so that their power does not overflow: 8^40 = 1e36.
MAX_OVER_TOP = 8.0
#: In a bath harmonic m of a density vanishes at rest as v^m; up to this power it is imposed.
#: Measured on four baths with a field: without it f is up to 0.6 of its maximum off at rest, with
#: powers up to 2, 4, 6 and 8 it is 0.1, 1e-2, 1e-3 and 5e-4 at most.
MAX_POWER_AT_REST = 8
#: Singular values, over the largest, that do not count where that is imposed.
ROUNDING_OF_GRAM = 1e-13
#: Points of a piece, on which polynomials of a node turn twice, at most. Measured: with 6 densities
#: move by 4e-11, with 24 by 6e-14.
POINTS_PER_PIECE = 12


@dataclass(frozen=True)
class ChebyshevSpeedAxis:
    """Chebyshev points of the first kind in x; or half of those from -1 to 1.

    Parameters
    ----------
    highest : the highest speed
    scale : S, below which points are uniform in x^p
    size : the number of points
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
        """Z, so that x = 1 at the top."""
        return math.asinh(self.highest / self.scale)

    @cached_property
    def _points(self) -> tuple[FloatArray, FloatArray]:
        """All points on [0, 1], rising, and their barycentric weights."""
        count = 2 * self.size if self.smooth else self.size
        angle = (np.arange(count) + 0.5) * math.pi / count
        weights = (-1.0) ** np.arange(count) * np.sin(angle)
        return np.asarray(0.5 * (1.0 - np.cos(angle))), np.asarray(weights)

    @cached_property
    def _x(self) -> FloatArray:
        """x at the points, rising, (size,)."""
        points, _ = self._points
        if self.smooth:
            return 2.0 * points[self.size :] - 1.0
        return points

    def _speed(self, x: FloatArray) -> FloatArray:
        """Return v(x)."""
        return np.asarray(self.scale * np.sinh(self._span * x**self.power))

    def _stretch(self, x: FloatArray) -> FloatArray:
        """Return dv/dx."""
        slope_of_argument = self._span * self.power * x ** (self.power - 1.0)
        return np.asarray(self.scale * np.cosh(self._span * x**self.power) * slope_of_argument)

    def _x_of(self, v: FloatArray) -> FloatArray:
        """Return x of any speeds; those near the top and beyond it are folded under it, smoothly.

        Where p > 1 no collision makes a tracer faster, and none is folded.
        """
        y = np.minimum(v / self.highest, MAX_OVER_TOP)
        if self.power == 1.0:
            y = y * (1.0 + y**FADING_POWER) ** (-1.0 / FADING_POWER)
        x = np.arcsinh(y * (self.highest / self.scale)) / self._span
        if self.power != 1.0:
            x = x ** (1.0 / self.power)
        return np.clip(x, 0.0, 1.0)

    def _folded(self, rows: FloatArray, parity: int) -> FloatArray:
        """Return rows that act on values at all points, so that they act on those at x > 0."""
        if not self.smooth:
            return rows
        return rows[:, self.size :] + (1 - 2 * parity) * rows[:, self.size - 1 :: -1]

    @cached_property
    def speeds(self) -> FloatArray:
        """The nodes v, rising, (size,)."""
        return self._speed(self._x)

    @cached_property
    def faded(self) -> FloatArray:
        """1, and 0 at the top, smoothly, if ``fading``, (size,)."""
        return 1.0 - (self.speeds / self.highest) ** FADING_POWER * self.fading

    def derivative(self, parity: int) -> FloatArray:
        """Return d/dv, at the points, of an even (parity 0) or odd polynomial, (size, size)."""
        slopes = self._folded(derivative_matrix(*self._points)[-self.size :], parity)
        points_per_x = 0.5 if self.smooth else 1.0
        return slopes * (points_per_x / self._stretch(self._x))[:, None]

    def interpolation(self, v: FloatArray, parity: int = 0) -> FloatArray:
        """Return the rows that take values at the nodes to those at speeds v (n,), (n, size)."""
        x = self._x_of(v)
        if self.smooth:
            x = 0.5 * (1.0 + x)
        points, weights = self._points
        return self._folded(interpolation_rows(x[:, None] - points, weights), parity)

    # -- Chebyshev polynomials ---------------------------------------------------------------------

    def polynomials(self, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return Chebyshev polynomials at speeds v (n,), for even and odd harmonics, (n, size)."""
        return self._polynomials(self._x_of(v))

    def _polynomials(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the same at x (n,)."""
        if self.smooth:
            all_polynomials: FloatArray = chebvander(x, 2 * self.size - 1).astype(float, copy=False)
            return all_polynomials[:, 0::2], all_polynomials[:, 1::2]
        all_polynomials = chebvander(2.0 * x - 1.0, self.size - 1).astype(float, copy=False)
        return all_polynomials, all_polynomials

    def to_coefficients(self, parity: int) -> FloatArray:
        """Return the matrix from values at the points to coefficients of these, (size, size)."""
        matrix = self._polynomials(self._x)[parity].T * (2.0 / self.size)
        has_constant = not (self.smooth and parity)
        if has_constant:
            matrix[0] *= 0.5
        return np.asarray(matrix)

    def changes(self, log_loss: FloatArray) -> Iterator[FloatArray]:
        """Yield what each polynomial changes at the points as v falls to v s, (size, n) each.

        To all digits where s is near 1; not for even and odd polynomials. With y = 2 x - 1 and its
        change c, the change of T_(n+1) = 2 y T_n - T_(n-1) obeys the same recursion.

        log_loss : -ln s, (n,)
        """
        v = (self.speeds / self.scale)[:, None]
        v_after = v * np.exp(-log_loss)
        v_lost = v * -np.expm1(-log_loss)
        # arcsinh(v) - arcsinh(v_after), without cancellation
        addition = v * np.hypot(1.0, v_after) + v_after * np.hypot(1.0, v)
        argument_lost = np.arcsinh(v_lost * (v + v_after) / addition)
        x = self._x[:, None]
        share_lost = argument_lost / (self._span * x**self.power)
        with np.errstate(divide="ignore"):
            log_ratio = np.log1p(-np.minimum(share_lost, 1.0)) / self.power
        change_of_y = 2.0 * x * np.expm1(log_ratio)
        y = 2.0 * x - 1.0
        previous = np.ones_like(x)
        polynomial = y
        previous_change = np.zeros_like(change_of_y)
        change = change_of_y
        yield previous_change
        for _ in range(1, self.size):
            yield change
            next_change = 2.0 * ((y + change_of_y) * change + change_of_y * polynomial)
            next_change = next_change - previous_change
            next_polynomial = 2.0 * y * polynomial - previous
            previous_change = change
            change = next_change
            previous = polynomial
            polynomial = next_polynomial

    # -- densities, from the averages of the polynomials that are 1 at one point, 0 at the others --

    def averaged(
        self, density: Callable[[FloatArray], NDArray[Any]], parity: int, kinks: FloatArray
    ) -> NDArray[Any]:
        """Return averages of the polynomial of each node over a density of the speed, (size,)."""
        x_of_kinks = (np.arcsinh(kinks / self.scale) / self._span) ** (1.0 / self.power)
        # polynomials turn twice, at most, from one end to the next
        ends = 0.5 - 0.5 * np.cos(np.linspace(0.0, math.pi, self.size // 2 + 2))
        edges = np.union1d(ends, np.minimum(x_of_kinks, 1.0))
        x, weight = panels_between(edges, POINTS_PER_PIECE)
        v = self._speed(x)
        measure = weight * self._stretch(x) * density(v)
        return np.asarray(measure @ self.interpolation(v, parity))

    def power_average(
        self, sums: FloatArray, p: float, parity: int, dimension: int, width: float
    ) -> float:
        """Return the average of v^p of a harmonic of these sums, also where v^p bends at rest.

        Even or odd polynomials converge slowly to a power of the other parity. Here v^p is
        projected on those of half the degree, with the weight W = v^(d-1) exp(-v^2/(4 width^2)).
        What the projection leaves out is orthogonal to them: of a density f it takes only what f/W
        has beyond half the degree, which is small where f is smooth.

        Parameters
        ----------
        sums : averages of the polynomials that are 1 at one point, (size,)
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
        at_points = self._polynomials(self._x)[parity][:, :half_degree]
        projection = np.linalg.lstsq(root[:, None] * at_nodes, root * v**p, rcond=None)[0]
        return float(sums @ (at_points @ projection))

    def density(self, sums: FloatArray, v: FloatArray, dimension: int) -> FloatArray:
        """Return the harmonics of f at speeds v (n,), from averages over them; 0 above the top.

        As a polynomial of half the degree: averages of higher ones are less accurate. In a bath it
        is multiplied by a factor that vanishes at rest as harmonic m does, or directions would
        differ there.

        Parameters
        ----------
        sums : averages over f_m v^(d-1), (M + 1, size)
        v : speeds, (n,)
        dimension : d

        Returns
        -------
        Shape (M + 1, n)
        """
        half_degree = self.size // 2
        x, weight = gauss_legendre(2 * self.size)
        nodes = self._speed(x)
        volume = (weight * nodes ** (dimension - 1.0) * self._stretch(x))[:, None]
        power = 2.0 if self.power == 2.0 else 1.0  # near rest x^2 is the better variable
        at_points = self._polynomials(self._x**power)
        at_nodes = self._polynomials(x**power)
        at_speeds = self._polynomials(self._x_of(v) ** power)
        density = np.empty((len(sums), v.size))
        thermal_speed = math.sqrt(abs(self.speeds**2 @ sums[0] / sums[0].sum()))
        for m, averages in enumerate(sums):
            polynomials = at_nodes[m % 2][:, :half_degree]
            of_points = at_points[m % 2][:, :half_degree]
            of_speeds = at_speeds[m % 2][:, :half_degree]
            power_at_rest = min(m, MAX_POWER_AT_REST) - m % 2  # odd polynomials vanish as v
            if not self.smooth or power_at_rest == 0:
                gram = polynomials.T @ (volume * polynomials)
                coefficients = np.linalg.solve(gram, of_points.T @ averages)
                density[m] = of_speeds @ coefficients
                continue
            factor = partial(_vanishing_at_rest, power=power_at_rest, scale=thermal_speed)
            polynomials = factor(nodes)[:, None] * polynomials
            gram = polynomials.T @ (volume * polynomials)
            projected = (factor(self.speeds)[:, None] * of_points).T @ averages
            coefficients = np.linalg.lstsq(gram, projected, rcond=ROUNDING_OF_GRAM)[0]
            density[m] = factor(v) * (of_speeds @ coefficients)
        return np.where(v < self.highest, density, 0.0)


def _vanishing_at_rest(v: FloatArray, power: int, scale: float) -> FloatArray:
    """Return (v^2/(v^2 + scale^2))^(power/2), shape of v."""
    return np.asarray((v * v / (v * v + scale * scale)) ** (0.5 * power))
