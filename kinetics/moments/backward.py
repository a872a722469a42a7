r"""The time-dependent equation, solved backwards: one smooth function of v t per observable.

The mean of an observable at time t, seen as a function of the speed u at time 0, obeys the adjoint
of the inelastic Lorentz equation (paper, label ``inelaslorentz2``), which has no scale: for an
observable of degree p in the speed it is u^p times a function of T = u t/l alone. With y(X) = T^p
(that function), X = ln T,

    dy/dX = p y + e^X ( E[cos(m chi) y(X - xi)] - y + sources ),     xi = -ln s >= 0,

l the mean free path, m the angular harmonic, chi the deflection and s the speed ratio of a
collision, E the average over one collision. y at X needs y below X only, and the kernel does not
depend on X: on equal panels the collision term is the same few small matrices everywhere, and one
sweep upwards gives every later time for every initial state. Below the panels a power series in T
is summed; above them y is on its late asymptote.

Begin with `BackwardEquation.integrate`. The observables are in `observables`; returns to a
scatterer that take time are in `delayed`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.moments.observables import Observable, speed_power
from kinetics.numerics import FOLDS, LARGEST_LOG, BoolArray, FloatArray
from kinetics.numerics.cache import Cache
from kinetics.numerics.chebyshev import Chebyshev, chebyshev_panels
from kinetics.numerics.panel_shifts import PanelShifts, with_returns

#: X where the panels begin. Chosen: errors are the same from -1 to -4 (e = 0.3 and 0.9, 12 nodes);
#: the power series needs 16 terms at -1, 13 at -2 and 9 at -4.
START = -2.0
#: Terms of the power series. Derived: at T = e^-2 the term T^40 is e^-80, and adds nothing.
SERIES_TERMS = 40
#: Terms of the power series below this fraction of its largest one are dropped: they are rounding.
#: Chosen: at half and at twice no average moves (e = 0 to 1, rtol 1e-8).
NEGLIGIBLE_TERM = 1e-19
#: The power series keeps at least terms up to this power of T, as the first 4 may vanish. Origin
#: not recorded; with 4 and with 14 no average moves (e = 0 to 1, rtol 1e-8).
LEAST_LAST_TERM = 7
#: ln of how far T^p, or an average, may change across a panel: rounding in its lower end grows so,
#: and nodes miss more. Chosen: <v^p> late, p = 8 to 40, is right to 6e-12 with 1 to 8, but only to
#: 2e-8 with 16; narrower panels cost time, 1 twice as much.
MAX_LOG_CHANGE_ON_PANEL = 4.0
#: e-folds by which panels end before e^X overflows. Chosen: for factors beside it; at half and at
#: twice nothing moves.
MARGIN_TO_OVERFLOW = 9.0

#: Error of a panel over its last Chebyshev coefficient. Measured: at most 1.2, and 1.75 leaves a
#: share for the initial state.
LAST_COEFFICIENT_SAFETY = 1.75
#: The same over the coefficient before the last one: a tenth, as the last may vanish by chance.
#: Chosen.
SECOND_LAST_COEFFICIENT_SAFETY = 0.175
#: Errors of a panel are relative to its smaller end, or to this fraction of its maximum where y
#: changes sign. Chosen; half and twice of it change no largest ratio of estimate to error (four e).
LEAST_END_OVER_MAXIMUM = 1e-3

#: At e = 1, a harmonic that decays more slowly than this does not decay: without deflection
#: rounding leaves 1 - cos(2 pi) = 3e-32.
LEAST_DECAY = 1e-30
#: Largest zero z of 1 - E[s^z cos(m chi)] that is allowed for: -0.736 is the largest one of smooth
#: scatterers (disks with e = 0.03, m = 1), and what -1 leaves there is 2e-13. Chosen.
LARGEST_ZERO = -1.0

#: Number of laws, with a number of nodes and a width of panels, whose solutions are kept. Chosen:
#: it changes no result.
LAWS_KEPT = 8
#: Number of observables that are kept for each. Chosen: all outputs of a scene need about 20.
OBSERVABLES_KEPT = 64


@lru_cache(maxsize=48)
def asymptotic_from(law: CollisionLaw) -> float:
    """Return X = ln T from which averages are asymptotic; inf at rough scatterers.

    Corrections fall as T^(Re z), over the zeros z of 1 - E[s^z cos(m chi)]. Where e < 0 tracers
    keep their direction for long, and the largest z, of m = 1, is real. At e = 1 corrections to the
    late power are 1/(nu T), nu the slowest decay of the harmonics 1 and 2.
    """
    if law.is_elastic:
        rates = [law.harmonic_decay_rate(0.0, m) for m in (1, 2)]
        decaying = [rate for rate in rates if rate > LEAST_DECAY]
        return FOLDS - math.log(min(decaying, default=1.0))
    if law.tangential_restitution != 1.0:
        return math.inf
    e = law.effective_restitution
    largest_zero = LARGEST_ZERO
    if e is not None and e < 0.0 and law.harmonic_decay_rate(largest_zero, 1) < 0.0:
        from scipy.optimize import brentq

        largest_zero = brentq(lambda z: law.harmonic_decay_rate(z, 1), largest_zero, 0.0, rtol=1e-9)
    return FOLDS / -largest_zero - math.log(law.mean_log_loss)


def power_series(degree: float, x: FloatArray, coefficients: FloatArray) -> FloatArray:
    """Return T^degree sum_k a_k T^k at T = e^x, of the shape of x; coefficients a_k (n_terms,)."""
    return np.exp(degree * x) * np.polynomial.polynomial.polyval(np.exp(x), coefficients)


@dataclass(frozen=True)
class PanelKernel:
    """The collision term on a panel: what values there lose, and what they gain from below.

    Parameters
    ----------
    loss : of the panel on itself, shape (nodes, nodes)
    gain : from the panels below it, farthest first, shape (nodes, reach * nodes)
    """

    loss: FloatArray
    gain: FloatArray

    @property
    def reach(self) -> int:
        """How many panels below matter."""
        return self.gain.shape[1] // self.gain.shape[0]


class SolvedObservables:
    """What is solved for one law on panels of one kind, for every initial state and every time.

    kernels : by the harmonic m, and the share of the returns that are at once
    shifts : where collisions shift the nodes of a panel, by the number of points of a quadrature
    series : coefficients of the power series, by observable
    values : at the nodes, by observable, number of panels and rtol
    errors : the error estimates, by the same
    """

    def __init__(self) -> None:
        self.kernels: Cache[tuple[int, float], PanelKernel] = Cache(OBSERVABLES_KEPT)
        self.shifts: Cache[int, PanelShifts] = Cache(OBSERVABLES_KEPT)
        self.series: Cache[Observable, FloatArray] = Cache(OBSERVABLES_KEPT)
        self.values: Cache[tuple[Observable, int, float], FloatArray] = Cache(OBSERVABLES_KEPT)
        self.errors: Cache[tuple[Observable, int, float], float] = Cache(OBSERVABLES_KEPT)


#: Shared by all equations of one class with the same law, nodes and width.
_SOLVED: Cache[tuple[type, CollisionLaw, int, float], SolvedObservables] = Cache(LAWS_KEPT)


@dataclass(frozen=True)
class BackwardEquation:
    """Solves for observables on panels in X = ln(u t/l); what is solved is kept with the law.

    Parameters
    ----------
    law : the collision law
    highest : the largest X that is needed
    nodes : Chebyshev nodes of a panel
    width : of a panel in X; powers of the speed up to MAX_LOG_CHANGE_ON_PANEL/width are accurate
    highest_harmonic : the largest angular harmonic that is needed
    rtol : relative accuracy that is needed
    """

    law: CollisionLaw
    highest: float
    nodes: int
    width: float = 1.0
    highest_harmonic: int = 2
    rtol: float = 1e-11

    @property
    def start(self) -> float:
        """X where the panels begin."""
        return START

    @cached_property
    def rule(self) -> Chebyshev:
        """The collocation of a panel."""
        return chebyshev_panels(self.nodes, self.width)

    @cached_property
    def n_panels(self) -> int:
        """The number of panels: up to the largest X, or to where averages are asymptotic."""
        end = min(self.highest, LARGEST_LOG - MARGIN_TO_OVERFLOW)
        if self.highest_harmonic <= 2:  # for others no such X is known
            end = min(end, asymptotic_from(self.law))
        return max(1, math.ceil((end - self.start) / self.width))

    @cached_property
    def _solved(self) -> SolvedObservables:
        """What is kept with the law."""
        key = (type(self), self.law, self.nodes, self.width)
        return _SOLVED.get(key, SolvedObservables)

    # -- values on the panels ---------------------------------------------------------------------

    def solve(self, y: Observable) -> FloatArray:
        """Return y at the nodes of all panels, shape (n_panels, nodes)."""
        key = (y, self.n_panels, self.rtol)
        return self._solved.values.get(key, lambda: self.integrate(y))

    def integrate(self, y: Observable) -> FloatArray:
        """Solve the equation of y by a sweep over the panels, shape (n_panels, nodes).

        On each panel the equation is collocated at all nodes but the first, where y is continuous.
        """
        kernel = self.panel_kernel(y)
        reach = kernel.reach
        source = self.sources_at_nodes(y)
        x = self.nodes_from(-reach)
        coefficients = self.series(y).copy()
        # Where bounces can stop a tracer, E[s^p] of T^p itself, p < 0, needs more points than the
        # kernel has: this term is taken out, as its average is known; the rest begins with T^(p+1).
        takes_power_out = y.degree < 0.0 and math.isfinite(self.law.lowest_power)
        if takes_power_out:
            power = np.exp(y.degree * x[reach:])
            source -= self.law.harmonic_decay_rate(y.degree, y.harmonic) * power
            coefficients[0] = 0.0
        early = power_series(y.degree, np.append(x[:reach], self.start), coefficients)
        initial = early[-1]
        values = np.empty((reach + self.n_panels, self.nodes))
        values[:reach] = early[:-1].reshape(reach, self.nodes)
        matrices, rate = self.collocation(y.degree)
        matrices += rate[:, :, None] * kernel.loss
        matrices[:, 0] = np.eye(self.nodes)[0]
        inverses = np.linalg.inv(matrices)
        for panel in range(self.n_panels):
            below = values[panel : panel + reach].ravel()
            right = rate[panel] * (kernel.gain @ below + source[panel])
            right[0] = initial
            values[reach + panel] = inverses[panel] @ right
            initial = values[reach + panel, -1]
        if takes_power_out:
            return values[reach:] + power
        return values[reach:]

    def nodes_from(self, first: int) -> FloatArray:
        """Return X at the nodes from panel `first` on, shape (n_panels, nodes)."""
        panels = np.arange(first, self.n_panels)[:, None]
        return self.start + self.width * (panels + self.rule.local)

    def collocation(self, degree: float) -> tuple[FloatArray, FloatArray]:
        """Return matrices of d/dX - degree, and e^X, on all panels.

        Shapes (n_panels, nodes, nodes) and (n_panels, nodes). Each row is divided by the collision
        rate e^X where that is above 1.
        """
        rate = np.exp(self.nodes_from(0))
        scale = 1.0 / np.maximum(1.0, rate)
        slopes = self.rule.derivative - degree * np.eye(self.nodes)
        return scale[:, :, None] * slopes, rate * scale

    def sources_at_nodes(self, y: Observable) -> FloatArray:
        """Return the sources of y at the nodes of all panels, shape (n_panels, nodes)."""
        total = np.full((self.n_panels, self.nodes), y.constant)
        for factor, source in y.sources:
            total += factor * self.solve(source)
        return total

    # -- collisions -------------------------------------------------------------------------------

    def returns_at_once(self, y: Observable) -> tuple[float, float]:
        """Return the share, with its sign, and -ln(speed ratio), of returns that take no time.

        They bring a tracer back to the scatterer before, in a medium; both are 0 where none does.
        """
        return self.law.returns(y.harmonic)

    def panel_kernel(self, y: Observable) -> PanelKernel:
        """Return the collision term of y."""
        share, _ = self.returns_at_once(y)
        return self._solved.kernels.get((y.harmonic, share), lambda: self._make_kernel(y))

    def _make_kernel(self, y: Observable) -> PanelKernel:
        """Average over collisions, and over returns that take no time."""
        largest_power = max(float(self.nodes), MAX_LOG_CHANGE_ON_PANEL / self.width)
        bounces = self.law.quadrature_for(largest_power, y.harmonic)
        # most harmonics share one quadrature
        shifts = self._solved.shifts.get(
            bounces.weight.size, lambda: PanelShifts(self.rule, bounces.log_loss)
        )
        lost = bounces.harmonic_loss(y.harmonic)[None]
        loss, gain = shifts.kernel(bounces.weight, 1.0 - lost, lost)
        share, log_loss = self.returns_at_once(y)
        if share:
            loss, gain = with_returns(self.rule, loss, gain, np.array([share]), log_loss)
        return PanelKernel(loss[0], gain[0])

    # -- the power series below the panels --------------------------------------------------------

    def series(self, y: Observable) -> FloatArray:
        """Return a_k of y = T^p sum_k a_k T^k as far as they count below the panels, (n_terms,)."""
        return self._solved.series.get(y, lambda: self._make_series(y))

    def _make_series(self, y: Observable) -> FloatArray:
        """Solve (k + 1) a_(k+1) = source_k - rate_k a_k."""
        source, rate = self.series_of_sources(y)
        a = [float(y.is_power)]
        for k in range(SERIES_TERMS):
            a.append((float(source[k]) - float(rate[k]) * a[k]) / (k + 1.0))
        size = np.abs(a) * np.exp(self.start * np.arange(len(a)))
        terms_that_count = np.nonzero(size > NEGLIGIBLE_TERM * size.max())[0]
        # all sizes may be zero, where T underflows
        last_term = int(terms_that_count.max(initial=LEAST_LAST_TERM))
        return np.array(a[: last_term + 1])

    def series_of_sources(self, y: Observable) -> tuple[FloatArray, FloatArray]:
        """Return coefficients of the sources over T^p, and the rates at which terms decay.

        The rate of term k is 1 - E[s^(p+k) cos(m chi)], with returns at once; (SERIES_TERMS,) each.
        """
        total = np.zeros(SERIES_TERMS)
        total[0] = y.constant
        for factor, source in y.sources:
            coefficients = self.series(source)[:SERIES_TERMS]
            total[: coefficients.size] += factor * coefficients
        power = y.degree + np.arange(SERIES_TERMS)
        rate = self.law.lost(power, y.harmonic)
        share, log_loss = self.returns_at_once(y)
        return total, rate / (1.0 + share * np.exp(-log_loss * power) * rate)

    # -- errors and interpolation -----------------------------------------------------------------

    def error_estimate(self, y: Observable) -> float:
        """Return the relative error of y, from the last Chebyshev coefficients of all panels.

        Errors of panels add up while y grows. That of a power of the speed with m > 0, which decays
        by itself, is relative to the same power with m = 0.
        """
        key = (y, self.n_panels, self.rtol)
        return self._solved.errors.get(key, lambda: self._estimate_error(y))

    def _estimate_error(self, y: Observable) -> float:
        """Add up the errors of all panels."""
        last, second_last = self.rule.last_coefficients(self.solve(y))
        truncation = np.maximum(
            LAST_COEFFICIENT_SAFETY * last, SECOND_LAST_COEFFICIENT_SAFETY * second_last
        )
        is_decaying_power = y.harmonic > 0 and y.is_power
        size = np.abs(self.solve(speed_power(y.degree) if is_decaying_power else y))
        smaller_end = np.minimum(size[:, 0], size[:, -1])
        scale = np.maximum(smaller_end, LEAST_END_OVER_MAXIMUM * size.max(axis=1))
        return float(np.sum(truncation / np.maximum(scale, 1e-300)))

    def at(self, y: Observable, x: FloatArray, leading: int = 0) -> tuple[FloatArray, BoolArray]:
        """Evaluate y at any X.

        Parameters
        ----------
        y : the observable
        x : X, of any shape; -inf is allowed
        leading : the number of first terms of the power series that vanish

        Returns
        -------
        y, but below the panels y T^-(p + leading), as T^p alone may overflow; and whether X is
        below the panels. Each has the shape of x.
        """
        values = self.solve(y)
        is_early = x < self.start
        panel_coordinate = (x[~is_early] - self.start) / self.width
        panel = np.minimum(panel_coordinate.astype(int), self.n_panels - 1)
        shares = self.rule.shares(np.minimum(panel_coordinate - panel, 1.0))
        late = np.einsum("ij,ij->i", shares, values[panel]) / shares.sum(axis=1)
        is_beyond = panel_coordinate > self.n_panels
        if is_beyond.any():
            late[is_beyond] = self._beyond_panels(y, panel_coordinate[is_beyond] - self.n_panels)
        result = np.empty(x.shape)
        series = self.series(y)[leading:]
        result[is_early] = np.polynomial.polynomial.polyval(np.exp(x[is_early]), series)
        result[~is_early] = late
        return result, is_early

    def _beyond_panels(self, y: Observable, panels_beyond: FloatArray) -> FloatArray:
        """Continue y by its asymptote, so many panels beyond the last one; shape of these.

        At e = 1 it is a power of T, or has decayed; else a polynomial in X of degree `y.growth`
        through the ends of the last panels.
        """
        values = self.solve(y)
        if self.law.is_elastic and y.harmonic and y.is_power:
            return np.zeros(panels_beyond.shape)
        growth = y.growth
        if self.n_panels > 3:
            end, previous_end, end_before = values[-1:-4:-1, -1]
        else:  # a line through both ends of the last panel
            end = values[-1, -1]
            previous_end = values[-1, 0]
            end_before = previous_end
            growth = min(growth, 1)
        if self.law.is_elastic:
            power = round(math.log(end / previous_end) / self.width)
            return np.asarray(end * np.exp(power * self.width * panels_beyond))
        result = np.full(panels_beyond.shape, end)
        if growth >= 1:
            slope = end - previous_end
            result += slope * panels_beyond
        if growth >= 2:
            curvature = end - 2.0 * previous_end + end_before
            result += 0.5 * curvature * panels_beyond * (panels_beyond + 1.0)
        return result
