"""At which wave numbers F is solved for on an interval, and the panel through them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kinetics.numerics import FloatArray
from kinetics.numerics.chebyshev import FirstKind
from kinetics.position.wave_panel import Indices, WavePanel, points_between


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
