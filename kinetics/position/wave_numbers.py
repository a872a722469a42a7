"""F(k, t) as a function of the wave number: on intervals of it, and how it ends.

On an interval F of the collided is a polynomial through Chebyshev points. Beyond the last one it
goes on with the powers of 1/k that the slowest tracers leave: initial speeds near 0, of density
~ v^(d-1) in dimension d, leave k^-(d+1); where e = 0, collisions leave a density ~ v^(d-2), and
k^-d. Tracers that are thrown straight back stay on a straight line through the origin: F falls as
1/k. The end of F is fitted by terms whose transforms are known.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from kinetics.numerics import LARGEST_LOG, FloatArray
from kinetics.numerics.chebyshev import Chebyshev
from kinetics.numerics.gauss import gauss_legendre
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

_TERMS = range(6, 14)  # of the sum, the number among these that leaves least
_BEYOND = np.geomspace(1.2, 30.0, 20)  # of the largest K, where two sums are compared


@dataclass(frozen=True)
class PowerTail(Value):
    """sum_j c_j (q^2 + 1)^(-nu - d/2), nu = (j + j_0)/2, q = K/scale, K = k l, d the dimension.

        integral of q J_0(q x) (q^2 + 1)^(-nu - 1) dq = (x/2)^nu K_nu(x)/Gamma(nu + 1)

    (DLMF 10.22.46), and in space

        (2/pi) integral of q sin(q x)/x (q^2 + 1)^(-nu - 3/2) dq
            = (x/2)^nu K_nu(x)/(sqrt(pi) Gamma(nu + 3/2)).

    scale : K where the powers begin
    first : j_0: 1; 0 where collisions may stop tracers; 1 - d where many are thrown straight back
    """

    coefficients: FloatArray
    scale: float
    dimension: int = 2
    first: int = 1

    def at(self, k: FloatArray) -> FloatArray:
        """The tail at K = k, shape (n_k,)."""
        terms = origin_terms(k / self.scale, self.coefficients.size, self.dimension, self.first)
        return np.asarray(terms @ self.coefficients)

    def transform(self, rho: FloatArray) -> FloatArray:
        """The radial density over r^(d-1) at r = rho l, l = 1, shape (n_r,)."""
        from scipy.special import gamma, kv

        x = np.clip(self.scale * rho, 1e-12, LARGEST_LOG)  # beyond it is negligible
        nu = 0.5 * (self.first + np.arange(self.coefficients.size))
        norm = gamma(nu + 1.0) if self.dimension == 2 else math.sqrt(math.pi) * gamma(nu + 1.5)
        with np.errstate(under="ignore"):
            terms = x ** nu[:, None] * kv(nu[:, None], x)
        return np.asarray(
            (self.coefficients / (2.0**nu * norm)) @ terms * self.scale**self.dimension
        )


def origin_terms(q: FloatArray, count: int, dimension: int, first: int) -> FloatArray:
    """(q^2 + 1)^(-nu - d/2), nu = (first + j)/2, for j < count: q (n,) gives (n, count)."""
    return np.asarray((1.0 + q[:, None] ** 2) ** (-0.5 * (dimension + first + np.arange(count))))


def fit_tail(
    k: FloatArray, f: FloatArray, scale: float, dimension: int, first: int = 1
) -> tuple[PowerTail, float]:
    """The tail of F through f at K = k, shape (n_k,) each, and its error, absolute.

    Two sums are fitted, to the lower part of the range and to all of it. The error is the largest
    that the first one misses there, or that they differ by beyond, times K over the largest K: so
    much more it changes G(R). As many terms are taken as leave least. scale, first : as above
    """
    highest = float(k.max())
    below = k < k.min() + 0.7 * (highest - k.min())  # what the first one is fitted to
    most = min(_TERMS[-1], int(np.count_nonzero(below)) - 2)
    if most < _TERMS[0]:
        return PowerTail(np.zeros(0), scale, dimension, first), np.inf
    weight = k ** (dimension + first)  # errors relative to the first power count
    everywhere = np.append(k, highest * _BEYOND)
    terms = origin_terms(everywhere / scale, most + 1, dimension, first)
    share = np.maximum(1.0, everywhere / highest)

    def fit(used: FloatArray, count: int) -> FloatArray:
        columns = terms[: k.size, :count] * used[:, None]
        return np.asarray(np.linalg.lstsq(columns, f * used, rcond=1e-13)[0])

    def left(count: int) -> tuple[FloatArray, float]:
        found = fit(weight, count)
        known = np.append(f, terms[k.size :, :count] @ found)
        lower = terms[:, :count] @ fit(weight * below, count)
        return found, float(np.abs(share * (lower - known)).max())

    fits = [left(count) for count in range(_TERMS[0] - 1, most + 2)]
    # the error of one number of terms may vanish by accident: the largest of three neighbours
    errors = np.array([error for _, error in fits])
    errors = np.maximum(np.maximum(errors[:-2], errors[1:-1]), errors[2:])
    best = int(np.argmin(errors))
    return PowerTail(fits[best + 1][0], scale, dimension, first), float(errors[best])
