"""F(k, t) of the collided on an interval of wave numbers: a polynomial through Chebyshev points."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from kinetics.numerics import FloatArray
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
