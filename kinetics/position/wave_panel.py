"""F(k, t) on an interval of wave numbers, as a polynomial, and where it is solved for."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from kinetics.numerics import FloatArray
from kinetics.numerics.chebyshev import FirstKind
from kinetics.numerics.gauss import gauss_legendre
from kinetics.results import Value

Indices = NDArray[np.intp]


@dataclass(frozen=True)
class WavePanel(Value):
    """F of the collided on an interval of K = k l, at Chebyshev points of the first kind.

    Attributes
    ----------
    low, high : its ends
    which : indices of the times at which it is not negligible, rising, shape (n_which,)
    values : shape (n_which, nodes)
    """

    low: float
    high: float
    which: Indices
    values: FloatArray

    @property
    def nodes(self) -> FloatArray:
        """K at the points, shape (nodes,)."""
        return points_between(self.low, self.high, self.values.shape[1])

    def of(self, time: int) -> FloatArray | None:
        """F at the nodes at one of the times; None where it is negligible."""
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
        return self.low + width * node, width * weight, _rows_to_gauss(f.size, points) @ f

    def at_zero(self, f: FloatArray) -> float:
        """The polynomial f at K = 0, for a panel that begins there."""
        return float((FirstKind(f.size).rows(np.zeros(1)) @ f)[0])


def nodes_between(
    panels: list[WavePanel], time: int, low: float, high: float = math.inf
) -> tuple[FloatArray, FloatArray]:
    """K > low and F there, (n,) each, on those panels of a time that begin below ``high``."""
    k, f = [np.empty(0)], [np.empty(0)]
    for panel in panels:
        values = panel.of(time)
        if values is not None and panel.high > low and panel.low < high:
            k.append(panel.nodes)
            f.append(values)
    all_k, all_f = np.concatenate(k), np.concatenate(f)
    return all_k[all_k > low], all_f[all_k > low]


def points_between(low: float, high: float, nodes: int) -> FloatArray:
    """The Chebyshev points of the first kind in an interval, shape (nodes,)."""
    return low + (high - low) * FirstKind(nodes).local


@dataclass(frozen=True)
class Sampling:
    """Chebyshev points for F on an interval of K = k l, fewer than a panel has.

    From K = 0 on, F is an even polynomial: the points are those of the interval from -high to high,
    of which half are solved for. Elsewhere F of a density of speeds falls as a power of 1/K, and
    K^power F is a polynomial in 1/K; F of sharp speeds turns with K, and is a polynomial in K.

    Attributes
    ----------
    low, high : the ends of the interval
    nodes : how many wave numbers are solved for
    power : with which F falls; 0 for a polynomial in K
    """

    low: float
    high: float
    nodes: int
    power: int = 0

    @property
    def _even(self) -> bool:
        return self.low == 0.0

    @cached_property
    def _rule(self) -> FirstKind:
        return FirstKind(2 * self.nodes if self._even else self.nodes)

    @cached_property
    def places(self) -> FloatArray:
        """K, shape (nodes,), rising."""
        if self._even:
            return points_between(-self.high, self.high, 2 * self.nodes)[self.nodes :]
        if self.power == 0:
            return points_between(self.low, self.high, self.nodes)
        return np.asarray(1.0 / points_between(1.0 / self.low, 1.0 / self.high, self.nodes))

    def _smooth(self, values: FloatArray) -> FloatArray:
        """What the polynomial goes through, (..., nodes of the rule), from F at the places."""
        if self._even:
            return np.concatenate([values[..., ::-1], values], axis=-1)
        return np.asarray(values * (self.places / self.high) ** self.power)

    def missed(self, values: FloatArray) -> float:
        """What the polynomials leave out of F, (..., nodes), by their last two coefficients.

        In the middle of the interval where F falls as a power.
        """
        ratio = 1.0 if self._even else self.high / self.low
        middle = ratio ** (0.5 * self.power)
        return middle * float(np.max(self._rule.last_coefficients(self._smooth(values))))

    def panel(self, which: Indices, values: FloatArray, nodes: int) -> WavePanel:
        """F at the times ``which``, (n_which, nodes), as a panel with so many nodes."""
        k = points_between(self.low, self.high, nodes)
        if self._even:
            local = 0.5 + 0.5 * k / self.high
        elif self.power == 0:
            local = (k - self.low) / (self.high - self.low)
        else:
            local = (1.0 / self.low - 1.0 / k) / (1.0 / self.low - 1.0 / self.high)
        found = self._smooth(values) @ self._rule.rows(local).T
        if not self._even:
            found = found * (self.high / k) ** self.power
        return WavePanel(self.low, self.high, which, found)


@lru_cache(maxsize=64)  # panels and times have few different sizes
def _rows_to_gauss(nodes: int, points: int) -> FloatArray:
    """Interpolation from the Chebyshev to the Gauss points, shape (points, nodes)."""
    return FirstKind(nodes).rows(gauss_legendre(points)[0])
