"""The backward equation in a medium, where returns to the scatterer before take time.

A medium is scatterers at a finite density (`kinetics.collision.medium`); m is the angular harmonic,
r the displacement in mean free paths, and Y, U and W are as in `delayed`. Harmonics m > 0, and
positive powers of the speed, have returns that take time (`delayed`). Other observables of the
harmonic m = 0, as <r^2> itself and the number of collisions, and negative powers of the speed,
which slow tracers make, keep all returns at once. Begin with `DelayedBackwardEquation.integrate`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kinetics.collision.law import CollisionLaw
from kinetics.collision.medium import Medium
from kinetics.moments.backward import (
    OBSERVABLES_KEPT,
    START,
    BackwardEquation,
    power_series,
)
from kinetics.moments.delayed import Loops, Returns
from kinetics.moments.loops import displacement_spectrum, series_end, speed_spectrum
from kinetics.moments.observables import Observable
from kinetics.numerics import FloatArray
from kinetics.numerics.cache import Cache
from kinetics.numerics.chebyshev import Chebyshev

#: Terms of power series. Derived: they are used up to where the fastest loops have fallen to 1/e,
#: and 1/20! = 4e-19.
DELAYED_SERIES_TERMS = 20
#: Number of loops that are kept, about 400 kB each. Chosen: a scene needs 6.
LOOPS_KEPT = 32


@dataclass(frozen=True)
class EarlyDelayed:
    """Power series of one observable below all panels, over T^p.

    Parameters
    ----------
    average : of Y, the average itself, shape (n_terms,)
    colliding : of U, on which collisions act
    collided : of W, what collisions make of U
    modes : of the modes of loops, shape (n_terms, n_modes)
    """

    average: FloatArray
    colliding: FloatArray
    collided: FloatArray
    modes: FloatArray


#: By law, m, degree, rule of a panel, number of panels and rtol.
_LOOPS: Cache[tuple[CollisionLaw, int, float, Chebyshev, int, float], Loops] = Cache(LOOPS_KEPT)
_EARLY: Cache[tuple[CollisionLaw, Observable], EarlyDelayed] = Cache(OBSERVABLES_KEPT)


@dataclass(frozen=True)
class DelayedBackwardEquation(BackwardEquation):
    """The backward equation with returns that take time; its law must have a medium, e > 0."""

    @property
    def medium(self) -> Medium:
        """The scatterers."""
        assert self.law.medium is not None
        return self.law.medium

    @cached_property
    def start(self) -> float:
        """X where the panels begin: no loops are faster below it."""
        return min(START, series_end(self.medium))

    def takes_time(self, y: Observable) -> bool:
        """Return whether returns of an observable take time; see the module."""
        is_positive_power = y.is_power and y.degree > 0.0
        return y.harmonic > 0 or (is_positive_power and self.medium.of_speed[0] > 0.0)

    def returns_at_once(self, y: Observable) -> tuple[float, float]:
        """Return nothing for harmonics m > 0; for powers of the speed what no loop brings."""
        if y.harmonic > 0:
            return 0.0, 0.0
        if self.takes_time(y):
            return self.medium.of_speed
        return super().returns_at_once(y)

    def loops(self, y: Observable) -> Loops:
        """Return what loops bring to the panels of an observable."""
        key = (self.law, y.harmonic, y.degree, self.rule, self.n_panels, self.rtol)
        return _LOOPS.get(key, lambda: self._make_loops(y))

    def _make_loops(self, y: Observable) -> Loops:
        """Solve for the modes of loops on all panels."""
        m = y.harmonic
        if m > 0:
            spectrum = displacement_spectrum(self.medium, range(m, m + 1))
        else:
            spectrum = speed_spectrum(self.medium)
        return Loops(spectrum, self.rule, self.start, self.n_panels, y.degree, self.rtol)

    def series(self, y: Observable) -> FloatArray:
        """Return coefficients a_k of y = T^p sum_k a_k T^k, shape (n_terms,)."""
        if self.takes_time(y):
            return self.early(y).average
        return super().series(y)

    def early(self, y: Observable) -> EarlyDelayed:
        """Return the power series of an observable whose returns take time."""
        return _EARLY.get((self.law, y), lambda: self._make_early(y))

    def _make_early(self, y: Observable) -> EarlyDelayed:
        """Solve (k + 1) Y_(k+1) = source_k - rate_k U_k, with U = Y + the weighted modes."""
        source, rate = self.series_of_sources(y)
        loops = self.loops(y)
        weights = loops.shares[0] @ loops.weights
        average = [float(y.is_power)]
        modes = [np.zeros(weights.size)]
        colliding = []
        collided = []
        for k in range(DELAYED_SERIES_TERMS):
            colliding.append(average[k] + float(weights @ modes[k]))
            collided.append(-float(rate[k]) * colliding[k])
            average.append((float(source[k]) + collided[k]) / (k + 1))
            modes.append(loops.term(k + 1, modes[k], collided[k]))
        return EarlyDelayed(
            average=np.array(average[:-1]),
            colliding=np.array(colliding),
            collided=np.array(collided),
            modes=np.array(modes[:-1]),
        )

    def integrate(self, y: Observable) -> FloatArray:
        """Solve the equation of y by a sweep over the panels, shape (n_panels, nodes)."""
        if not self.takes_time(y):
            return super().integrate(y)
        kernel = self.panel_kernel(y)
        reach = kernel.reach
        early = self.early(y)
        returns = Returns(
            self.loops(y), early.collided[:, None, None], early.modes[:, :, None, None]
        )
        source = self.sources_at_nodes(y)
        matrices, rate = self.collocation(y.degree)
        colliding = np.empty((reach + self.n_panels, self.nodes))  # U
        x_below = self.nodes_from(-reach)[:reach]
        colliding[:reach] = power_series(y.degree, x_below, early.colliding)
        initial = power_series(y.degree, np.array(self.start), early.average)
        values = np.empty((self.n_panels, self.nodes))
        for panel in range(self.n_panels):
            below = colliding[panel : panel + reach].ravel()
            gain = (kernel.gain @ below)[None, :, None]
            loss_of_y, gain_of_y = returns.begin(panel, kernel.loss[None], gain)
            matrices[panel] += rate[panel, :, None] * loss_of_y[0]
            matrices[panel, 0] = np.eye(self.nodes)[0]
            right = rate[panel] * (gain_of_y[0, :, 0] + source[panel])
            right[0] = initial
            values[panel] = np.linalg.solve(matrices[panel], right)
            solved = values[panel][None, :, None]
            colliding[reach + panel] = returns.end(panel, solved)[0, :, 0]
            initial = values[panel, -1]
        return values
