r"""The steady state of a tracer that only white noise drives, in closed form.

Its moments M(z) = <v^z> obey D_v z (z + d - 2) M(z - 2) = lambda(z) M(z + 1): in units of
(D_v l)^(1/3) they go in steps of three,

    M(z) = 9^(z/3) Gamma((z+2)/3) Gamma((z+d)/3)/[Gamma(2/3) Gamma(d/3)]
           product over k >= 0 of lambda(z+2+3k)/lambda(2+3k),        Re z > -d,

and the density is the inverse Mellin transform, along lines through saddle points: its error is
relative to itself. It shares the collision law with the discretised solver, and nothing else.

Begin with `log_moment` and `HeatedDensity`.
"""

from __future__ import annotations

import math
import threading
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import loggamma

from kinetics.collision import CollisionLaw
from kinetics.numerics import ComplexArray, FloatArray
from kinetics.numerics.gauss import gauss_legendre
from kinetics.numerics.recurrence import MOST_ORDERS, log_growth, taylor_of_log

#: Factors of the product that are taken as they are; an asymptotic series is the rest.
FACTORS = 12
#: The argument of lambda where the series begins.
SERIES_BEGIN = 2.0 + 3.0 * FACTORS
#: Points of integrals of ln lambda, and samples of a line that are made at once.
PATH_POINTS = 64
#: Samples of M below exp(-39) = 1e-17 of the largest are negligible.
NEGLIGIBLE_FOLDS = 39.0
#: Deviations beyond which the tilted density is negligible on the side of high speeds.
NEGLIGIBLE_DEVIATIONS = 12.0
#: Distance of lines in deviations: each serves somewhat more than half of it on either side.
LINE_DISTANCE = 2.0
#: The part of the distance that the last line serves.
LAST_LINE_SHARE = 0.6
#: The lowest line above -d: the density there is that at rest.
LOWEST_LINE = 0.4
#: A speed at which the density is what it is at rest.
SPEED_AT_REST = 1e-9
#: Step of the differences that give centre and deviation of a line; they need few digits.
DIFFERENCE_STEP = 0.02


def log_moment(
    law: CollisionLaw, z: NDArray[Any], path: ComplexArray | None = None
) -> ComplexArray:
    """Return ln M(z), shape (n,), with D_v = l = 1.

    Parameters
    ----------
    law : of the collisions
    z : powers of the speed, Re z > -d, (n,)
    path : the integral of ln lambda from `SERIES_BEGIN` to that plus z, if it is known, (n,)
    """
    u = np.asarray(z, dtype=complex) / 3.0
    if path is None:
        node, weight = gauss_legendre(PATH_POINTS)
        path = 3.0 * u * (_log_rate(law, SERIES_BEGIN + 3.0 * u[:, None] * node) @ weight)
    factors = 2.0 + 3.0 * np.arange(FACTORS)
    of_factors = _log_rate(law, 3.0 * u[:, None] + factors).sum(axis=1)
    of_factors = of_factors - _log_rate(law, factors).sum()
    series_at_0 = _taylor(law, np.array([SERIES_BEGIN]))
    series_at_z = _taylor(law, SERIES_BEGIN + 3.0 * u)
    of_series = log_growth(path / 3.0, series_at_0, series_at_z)
    gammas = loggamma(u + 2.0 / 3.0) + loggamma(u + law.dimension / 3.0)
    gammas_at_0 = math.lgamma(2.0 / 3.0) + math.lgamma(law.dimension / 3.0)
    return np.asarray(u * math.log(9.0) + gammas - gammas_at_0 + of_factors - of_series)


def _log_rate(law: CollisionLaw, p: NDArray[Any]) -> ComplexArray:
    """Return ln lambda(p), of the shape of p."""
    return np.log(law.decay_symbol(p.ravel().astype(complex)).reshape(p.shape))


def _taylor(law: CollisionLaw, p: NDArray[Any]) -> list[NDArray[Any]]:
    """Return Taylor coefficients of ln lambda(p + 3 u) in u, each of the shape of p."""
    coefficients = taylor_of_log(law.decay_taylor(p.astype(complex), MOST_ORDERS))
    return [coefficient * 3.0**order for order, coefficient in enumerate(coefficients)]


class HeatedDensity:
    """The density of the velocity, with D_v = l = 1.

    It keeps the lines that were needed so far; safe on threads. Their number grows with
    ln v as far as speeds go.
    """

    def __init__(self, law: CollisionLaw) -> None:
        self._law = law
        self._lines = [MellinLine(law, 0.0)]
        self._lock = threading.Lock()

    def at(self, v: FloatArray) -> FloatArray:
        """Return the density at speeds v (n,); its integral is 1."""
        x = np.log(np.maximum(v, SPEED_AT_REST))
        lines = self._lines_up_to(x.max(initial=0.0))
        edges = [
            (low.centre * high.deviation + high.centre * low.deviation)
            / (low.deviation + high.deviation)
            for low, high in pairwise(lines)
        ]
        line_of_speed = np.searchsorted(edges, x)
        density = np.empty(x.shape)
        for i, line in enumerate(lines):
            served = line_of_speed == i
            density[served] = line.density(x[served])
        d = self._law.dimension
        return np.asarray(density * np.exp(-d * x) / self._law.unit_surface)

    def _lines_up_to(self, highest: float) -> list[MellinLine]:
        """Return lines, by their exponents, for all ln v up to a highest one."""
        lowest_exponent = LOWEST_LINE - self._law.dimension
        with self._lock:
            lines = self._lines
            while not lines[-1].serves(highest):
                exponent = lines[-1].exponent + LINE_DISTANCE / lines[-1].deviation
                lines.append(MellinLine(self._law, exponent))
            while lines[0].exponent > lowest_exponent:
                exponent = lines[0].exponent - LINE_DISTANCE / lines[0].deviation
                lines.insert(0, MellinLine(self._law, max(exponent, lowest_exponent)))
            return list(lines)


class MellinLine:
    """M on the line Re z = exponent: the tilted density e^(exponent x) g(x) of x = ln v.

    Attributes
    ----------
    exponent : of the line
    centre, deviation : of the tilted density
    """

    def __init__(self, law: CollisionLaw, exponent: float) -> None:
        h = DIFFERENCE_STEP
        below, here, above = log_moment(law, exponent + h * np.arange(-1.0, 2.0)).real.tolist()
        self.exponent = exponent
        self.centre = (above - below) / (2.0 * h)
        self.deviation = math.sqrt(above - 2.0 * here + below) / h
        self._log_moment = here
        # Low down the tilted density falls as e^((exponent + d) x), high up faster than a Gaussian.
        width_below = NEGLIGIBLE_FOLDS / (exponent + law.dimension)
        width = width_below + NEGLIGIBLE_DEVIATIONS * self.deviation
        self._step = 2.0 * math.pi / width
        self._samples = self._make_samples(law)

    def _make_samples(self, law: CollisionLaw) -> ComplexArray:
        """Return M(exponent + i k step)/M(exponent), k = 0, 1, ..., until it is negligible."""
        samples = [np.ones(1, dtype=complex)]
        node, weight = gauss_legendre(PATH_POINTS)
        to_line = _log_rate(law, SERIES_BEGIN + self.exponent * node) @ weight
        path = self.exponent * complex(to_line)
        node, weight = gauss_legendre(3)
        step = 1j * self._step
        count = 0
        while np.abs(samples[-1][-4:]).max() > math.exp(-NEGLIGIBLE_FOLDS):
            z = self.exponent + step * np.arange(count, count + PATH_POINTS)
            log_rates = _log_rate(law, SERIES_BEGIN + z[:, None] + step * node)
            paths = path + np.cumsum(step * (log_rates @ weight))
            samples.append(np.exp(log_moment(law, z + step, paths) - self._log_moment))
            path = complex(paths[-1])
            count += PATH_POINTS
        return np.concatenate(samples)

    def serves(self, x: float) -> bool:
        """Return whether the line, as the last one, is close enough for ln v = x."""
        return x <= self.centre + LAST_LINE_SHARE * LINE_DISTANCE * self.deviation

    def density(self, x: FloatArray) -> FloatArray:
        """Return g at x, shape (n,)."""
        wave_number = self._step * np.arange(self._samples.size)
        series = 2.0 * (np.exp(-1j * np.outer(x, wave_number)) @ self._samples).real - 1.0
        scale = np.exp(self._log_moment - self.exponent * x) * self._step / (2.0 * math.pi)
        return np.asarray(scale * series)
