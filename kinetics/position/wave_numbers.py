"""F(k, t) as a function of the wave number: on intervals of it, and how it ends.

On an interval F of the collided is a polynomial through Chebyshev points. Beyond the last one it
goes on with the powers of 1/k that the slowest tracers leave: initial speeds near 0, of density
~ v^a, leave k^-(a+2), a = d - 1 as a rule in dimension d; where e = 0, collisions leave a density
~ v^(d-2), and k^-d. Tracers that are thrown straight back stay on a straight line through the
origin: F falls as 1/k. The end of F is fitted by such powers.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.polynomial.chebyshev import chebvander
from numpy.typing import NDArray

from kinetics.numerics import FloatArray
from kinetics.numerics.chebyshev import Chebyshev
from kinetics.numerics.gauss import gauss_legendre, panels_of
from kinetics.position.directions import mean_phase
from kinetics.results import Value

Indices = NDArray[np.intp]


@dataclass(frozen=True)
class WavePanel(Value):
    """F on an interval of K = k l from low to high, at Chebyshev points of a variable.

    From K = 0 on F is an even polynomial, of which half of the points are solved for. Elsewhere F
    of a density falls: K^power F is a polynomial in 1/K; that of sharp speeds one in K (power = 0).

    which : indices of the times at which F is not negligible, rising, shape (n_which,)
    values : shape (n_which, nodes), at `wave_numbers`
    """

    low: float
    high: float
    power: int
    which: Indices
    values: FloatArray

    @property
    def wave_numbers(self) -> FloatArray:
        """K, shape (nodes,), rising."""
        return wave_numbers_between(self.low, self.high, self.power, self.values.shape[1])

    def of(self, time: int) -> FloatArray | None:
        """F at the wave numbers at one of the times; None where it is negligible."""
        place = np.nonzero(self.which == time)[0]
        return None if place.size == 0 else np.asarray(self.values[place[0]])

    def without(self, time: int) -> WavePanel:
        """The same for the other times."""
        others = self.which != time
        return replace(self, which=self.which[others], values=self.values[others])

    def gauss(self, f: FloatArray, points: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Gauss nodes and weights in K, shape (points,) each, and the polynomial f there."""
        node, weight = gauss_legendre(points)
        width = self.high - self.low
        rows = _rows(self.low, self.high, self.power, f.size, points)
        return self.low + width * node, width * weight, rows @ f

    @property
    def missed(self) -> float:
        """What the polynomials leave out of F, by their last coefficients, at the worst time."""
        smooth = self.values * (self.wave_numbers / self.high) ** self.power
        if self.low == 0.0:
            smooth = np.concatenate([smooth[:, ::-1], smooth], axis=1)
        last = np.max(Chebyshev(smooth.shape[1]).last_coefficients(smooth))
        return float(last) * (self.high / max(self.low, 1e-300)) ** (0.5 * self.power)


def wave_numbers_between(low: float, high: float, power: int, nodes: int) -> FloatArray:
    """Where F is solved for on an interval, see :class:`WavePanel`: shape (nodes,), rising."""
    if low == 0.0:
        return high * (2.0 * Chebyshev(2 * nodes).local[nodes:] - 1.0)
    local = Chebyshev(nodes).local
    if power == 0:
        return np.asarray(low + (high - low) * local)
    return np.asarray(1.0 / (1.0 / low + (1.0 / high - 1.0 / low) * local))


@lru_cache(maxsize=64)  # the same panels are asked for at many times and radii
def _rows(low: float, high: float, power: int, nodes: int, points: int) -> FloatArray:
    """Interpolation from the wave numbers to so many Gauss points, (points, nodes)."""
    k = low + (high - low) * gauss_legendre(points)[0]
    if low == 0.0:
        rows = Chebyshev(2 * nodes).rows(0.5 + 0.5 * k / high)
        return np.asarray(rows[:, nodes:] + rows[:, nodes - 1 :: -1])
    if power == 0:
        return Chebyshev(nodes).rows((k - low) / (high - low))
    rows = Chebyshev(nodes).rows((1.0 / low - 1.0 / k) / (1.0 / low - 1.0 / high))
    at = wave_numbers_between(low, high, power, nodes)
    return np.asarray((high / k[:, None]) ** power * rows * (at / high) ** power)


def points_beyond(panels: list[WavePanel], time: int, low: float) -> tuple[FloatArray, FloatArray]:
    """K > low and F there, (n,) each, twice as many points as on the panels of a time."""
    parts = [
        panel.gauss(f, 2 * f.size)
        for panel in panels
        if (f := panel.of(time)) is not None and panel.high > low
    ]
    k = np.concatenate([k for k, _, _ in parts])
    return k[k > low], np.concatenate([f for _, _, f in parts])[k > low]


# -- how F ends ----------------------------------------------------------------------------------

_TERMS = range(5, 15)  # of the sum, the number among these, but the ends, that leaves least
_BEYOND = np.geomspace(1.2, 30.0, 20)  # of the largest K, where two sums are compared
_FITTED, _LOWER = 0.3, 0.75  # share of K to which they are fitted, and where the second one ends
_TURN, _ROTATED, _REAL = 12.0, 16, 30  # K r where the path of the integral turns; points on it


@dataclass(frozen=True)
class PowerTail(Value):
    """F beyond K = high: s^(first + d) sum_j c_j T_j(2 s/s_0 - 1), in d dimensions.

    s = ((K/scale)^2 + 1)^(-1/2), s_0 at the least K it was fitted to: powers of 1/K that begin at
    K = scale. first : 1; less where tracers are slow or thrown straight back
    """

    coefficients: FloatArray
    high: float
    scale: float
    dimension: int = 2
    first: int = 1

    def at(self, k: NDArray[Any]) -> NDArray[Any]:
        """The tail at K = k, also complex: shape of k."""
        s = _falling(k, self.scale)
        x = 2.0 * s / _falling(_FITTED * self.high, self.scale) - 1.0
        total = np.polynomial.chebyshev.chebval(x, self.coefficients)
        return np.asarray(s ** (self.first + self.dimension) * total)

    def transform(self, rho: FloatArray) -> FloatArray:
        """Radial density of F beyond K = high, over r^(d-1), at r = rho l, l = 1: shape (n_r,).

        Up to x = K rho = _TURN along real K; beyond along x + i y, where waves fall as exp(-y).
        """
        from scipy.special import hankel1e

        rho, d = np.maximum(rho, 1e-12 / self.high)[:, None], self.dimension
        turn = np.maximum(self.high * rho, _TURN)
        y, weight = np.polynomial.laguerre.laggauss(_ROTATED)
        x = turn + 1j * y
        wave = 1j * hankel1e(0, x) if d == 2 else np.ones(1)
        wave = (np.exp(1j * turn) * wave * x * self.at(x / rho)).real @ weight
        ends = np.log(np.concatenate([self.high * rho, turn], axis=1))
        log_x, weight = panels_of(ends, _REAL + int(3.0 * np.ptp(ends, axis=1).max()))
        x = np.exp(log_x)
        wave += (weight * x**d * mean_phase(x, d) * self.at(x / rho)).sum(axis=1)
        return np.asarray(wave * (1.0 if d == 2 else 2.0 / math.pi) / rho[:, 0] ** d)


def _falling(k: Any, scale: float) -> Any:
    return ((k / scale) ** 2 + 1.0) ** -0.5


def fit_tail(
    panels: list[WavePanel], time: int, high: float, scale: float, dimension: int, first: int
) -> tuple[PowerTail, float]:
    """The tail of F beyond the last of the panels, which end at K = high, and its error, absolute.

    Two sums are fitted, to the panels below high and to those below _LOWER high. The error is the
    most that they differ by above that (there the first one is F itself), times K over high: so
    much more it changes G(R). As many terms are taken as leave least. scale, first : as above
    """
    k, f = points_beyond(panels, time, _FITTED * _LOWER * high)
    every = np.append(k, high * _BEYOND)
    s = _falling(every, scale)
    lead = s ** (dimension + first)  # errors relative to the first power count

    def sums(end: float) -> list[tuple[FloatArray, FloatArray]]:
        """Coefficients, and the sum everywhere, of each number of terms, fitted below end."""
        used = np.flatnonzero((k > _FITTED * end) & (k < end))
        basis = chebvander(2.0 * s / _falling(_FITTED * end, scale) - 1.0, _TERMS[-1])
        right = f[used] / lead[used]
        fits = [np.linalg.lstsq(basis[used, :n], right, rcond=None)[0] for n in _TERMS]
        return [(c, lead * (basis[:, : c.size] @ c)) for c in fits]

    whole, lower = sums(high), sums(_LOWER * high)
    share = (every > _LOWER * high) * np.maximum(1.0, every / high)
    apart = [np.append(f, a[k.size :]) - b for (_, a), (_, b) in zip(whole, lower, strict=True)]
    errors = (share * np.abs(apart)).max(axis=1)
    # the error of one number of terms may vanish by accident: the largest of three neighbours
    errors = np.maximum(np.maximum(errors[:-2], errors[1:-1]), errors[2:])
    best = int(np.argmin(errors))
    return PowerTail(whole[best + 1][0], high, scale, dimension, first), float(errors[best])
