r"""The time-dependent equation, solved backwards: one smooth function of v t per observable.

The mean of an observable at time t, seen as a function of the speed u at time 0, obeys the adjoint
of the inelastic Lorentz equation (paper, label ``inelaslorentz2``), which has no scale: for an
observable of degree p in the speed it is u^p times a function of T = u t/l alone. With y(X) = T^p
(that function), X = ln T,

    dy/dX = p y + e^X ( E[cos(m chi) y(X - xi)] - y + sources ),     xi = -ln s >= 0,

m the angular harmonic. y at X needs y below X only, and the kernel does not depend on X: on equal
panels the collision term is the same few small matrices everywhere, and one sweep upwards gives
every later time for every initial state.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.numerics import FOLDS, LARGEST_LOG, FloatArray
from kinetics.numerics.chebyshev import PanelShifts, panel_rule, with_returns

START = -2.0  # X where the panels begin; below it the power series in T is summed
_TERMS = 40  # of that series: where T = e^-2 more add nothing
# Rounding in the lower end of a panel grows as T^p across it, or as the average falls in it: e^4
# is the most that it may.
STEEPEST = 4.0


@lru_cache(maxsize=48)
def asymptotic_from(law: CollisionLaw) -> float:
    """X = ln T from which averages are asymptotic; inf at rough scatterers.

    Corrections fall as T^(Re z), over the zeros z of 1 - E[s^z cos(m chi)]. Smooth scatterers have
    Re z <= -0.736 (disks with e = 0.03, m = 1): what is left is 2e-13 at worst. Where e < 0 tracers
    keep their direction for long, and the largest z, of m = 1, is real. At e = 1 corrections to the
    late power are 1/(nu T), nu the slowest decay of the harmonics 1 and 2.
    """
    if law.is_elastic:
        # of one that does not decay rounding leaves 1 - cos(2 pi) = 3e-32
        rates = [law.harmonic_decay_rate(0.0, m) for m in (1, 2)]
        return FOLDS - math.log(min([rate for rate in rates if rate > 1e-30], default=1.0))
    e, slowest = law.effective_restitution, -1.0
    if law.tangential_restitution != 1.0:
        return math.inf
    if e is not None and e < 0.0 and law.harmonic_decay_rate(slowest, 1) < 0.0:
        from scipy.optimize import brentq

        slowest = brentq(lambda z: law.harmonic_decay_rate(z, 1), slowest, 0.0, rtol=1e-9)
    return FOLDS / -slowest - math.log(law.mean_log_loss)


@dataclass(frozen=True)
class Observable:
    """One unknown of the backward equation.

    degree, harmonic : p, the power of the speed by which it scales, and m
    constant, sources : source that does not depend on X, and (factor, observable) pairs
    growth : late, it is a polynomial of this degree in ln T, 0 to 2; in T where speeds are kept
    """

    degree: float = 0.0
    harmonic: int = 0
    constant: float = 0.0
    sources: tuple[tuple[float, Observable], ...] = ()
    growth: int = 1

    @property
    def is_power(self) -> bool:
        """Whether it is a power of the speed, with no source."""
        return not (self.sources or self.constant)


# lengths in l: what a tracer has moved along its first direction drives r^2
MEAN_COLLISIONS: Observable = Observable(constant=1.0)
DISPLACEMENT_ALONG_START: Observable = Observable(harmonic=1, constant=1.0)
SQUARED_DISPLACEMENT: Observable = Observable(sources=((2.0, DISPLACEMENT_ALONG_START),))


def quartic_displacement(dimension: int) -> Observable:
    """r^4, in the plane or in space: <exp(i k.r)> to the fourth order in k, by harmonics."""
    factors = (0.25, -0.125, -0.5, -64.0) if dimension == 2 else (2.0 / 3.0, 1.0 / 6.0, 0.4, 40.0)
    second = Observable(harmonic=2, sources=((factors[0], DISPLACEMENT_ALONG_START),))
    third = Observable(
        harmonic=1, sources=((factors[1], SQUARED_DISPLACEMENT), (factors[2], second))
    )
    return Observable(sources=((factors[3], third),), growth=2)


def speed_power(p: float, harmonic: int = 0) -> Observable:
    """v^p cos(m (phi - phi_0))."""
    return Observable(degree=p, harmonic=harmonic, growth=0)


# d r^2/d ln t, driven by the velocity along the start
MSD_SLOPE: Observable = Observable(degree=1.0, sources=((2.0, speed_power(1.0, 1)),), growth=0)


def power_series(degree: float, x: FloatArray, coefficients: FloatArray) -> FloatArray:
    """T^degree times the power series at T = e^x, of the shape of x; the first axis is of terms."""
    return np.exp(degree * x) * np.polynomial.polynomial.polyval(np.exp(x), coefficients)


@lru_cache(maxsize=8)
def _kept(law: CollisionLaw, nodes: int, width: float) -> tuple[dict[Any, Any], ...]:
    """Kernels, shifts, series and all else, as the start changes nothing: filled as asked for."""
    return {}, {}, {}, {}


@dataclass
class BackwardEquation:
    """Solves for observables on panels in X = ln(u t/l); what is solved is kept with the law.

    highest, harmonic : the largest X, and the largest m, that will be asked for
    nodes, width : Chebyshev nodes of a panel, and its width in X, for powers of the speed up to
        STEEPEST/width
    rtol : relative accuracy that will be asked for
    start : X where the panels begin
    """

    law: CollisionLaw
    highest: float
    nodes: int
    width: float = 1.0
    harmonic: int = 2
    rtol: float = 1e-11
    start: float = START

    def __post_init__(self) -> None:
        self.rule = panel_rule(self.nodes, self.width)
        kept = _kept(self.law, self.nodes, self.width)
        self._kernels, self._shifts, self._series, self._kept = kept
        # for m > 2 as far as e^X is a number
        known = asymptotic_from(self.law) if self.harmonic <= 2 else math.inf
        end = min(self.highest, known, LARGEST_LOG - 9.0)
        self.count = max(1, math.ceil((end - self.start) / self.width))

    def _kernel(self, y: Observable) -> tuple[FloatArray, FloatArray]:
        """Loss matrix of a panel on itself, and gain from those below it, farthest first."""
        m, (eps, shift) = y.harmonic, self._at_once(y)
        if (m, eps) not in self._kernels:
            rate = max(float(self.nodes), STEEPEST / self.width)
            q = self.law.quadrature_for(rate, m)
            points = q.weight.size
            if points not in self._shifts:  # most harmonics share one quadrature
                self._shifts[points] = PanelShifts(self.rule, q.log_loss)
            lost = q.harmonic_loss(m)[None]
            loss, gain = self._shifts[points].kernel(q.weight, 1.0 - lost, lost)
            if eps:
                loss, gain = with_returns(self.rule, loss, gain, np.array([eps]), shift)
            self._kernels[m, eps] = loss[0], gain[0]
        return self._kernels[m, eps]

    def _at_once(self, y: Observable) -> tuple[float, float]:
        """Returns to a scatterer that take no time: their share, and -ln of their speed ratio."""
        return self.law.returns(y.harmonic)

    def solve(self, y: Observable) -> FloatArray:
        """Values at the nodes of all panels, shape (n_panels, nodes)."""
        key = y, self.count, self.rtol
        if key not in self._kept:
            self._kept[key] = self._solve(y)
        found: FloatArray = self._kept[key]
        return found

    def _solve(self, y: Observable) -> FloatArray:
        # where bounces can stop a tracer, E[s^p] of T^p itself needs more of them than the kernel
        # has: that term is taken out, its average is known, and the rest begins with T^(p+1)
        apart = y.degree < 0.0 and math.isfinite(self.law.lowest_power)
        loss, gain = self._kernel(y)
        n, reach = self.nodes, gain.shape[1] // self.nodes
        # the panels below, and the point where the first one begins; without T^p itself if apart
        x = self._nodes_from(-reach)
        below, rest = np.append(x[:reach], self.start), self.series(y).copy()
        rest[0] *= not apart
        known = power_series(y.degree, below, rest)
        table = np.empty((reach + self.count, n))
        table[:reach], first = known[:-1].reshape(reach, n), known[-1]
        drive, (matrix, rate) = self._driven(y), self._rows(y.degree)
        if apart:
            term = np.exp(y.degree * x[reach:])
            drive -= self.law.harmonic_decay_rate(y.degree, y.harmonic) * term
        matrix += rate[:, :, None] * loss
        matrix[:, 0] = np.eye(n)[0]
        matrix = np.linalg.inv(matrix)
        for j in range(self.count):
            right = rate[j] * (gain @ table[j : j + reach].ravel() + drive[j])
            right[0] = first
            table[reach + j] = matrix[j] @ right
            first = table[reach + j, -1]
        return table[reach:] + term if apart else table[reach:]

    def _nodes_from(self, first: int) -> FloatArray:
        """X at the nodes from this panel on, shape (n_panels, nodes)."""
        panels = np.arange(first, self.count)[:, None]
        return self.start + self.width * (panels + self.rule.local)

    def _driven(self, y: Observable) -> FloatArray:
        """What drives y at the nodes of all panels, shape (n_panels, nodes)."""
        drive = np.full((self.count, self.nodes), y.constant)
        for factor, other in y.sources:
            drive += factor * self.solve(other)
        return drive

    def _rows(self, degree: float) -> tuple[Any, FloatArray]:
        """d/dX - p and e^X, (n_panels, nodes, nodes) and (n_panels, nodes), each row divided by
        the collision rate where that is large.
        """
        rate = np.exp(self._nodes_from(0))
        scale = 1.0 / np.maximum(1.0, rate)
        slopes = self.rule.derivative - degree * np.eye(self.nodes)
        return scale[:, :, None] * slopes, rate * scale

    def series(self, y: Observable) -> FloatArray:
        """Coefficients a_k of y = T^p sum_k a_k T^k, as far as they count below the panels."""
        if y not in self._series:
            drive, rates = self._series_of_sources(y)
            a = [1.0 if y.is_power else 0.0]
            for k, (source, rate) in enumerate(zip(drive.tolist(), rates.tolist(), strict=True)):
                a.append((source - rate * a[k]) / (k + 1.0))
            size = np.abs(a) * np.exp(self.start * np.arange(len(a)))
            kept = np.nonzero(size > 1e-19 * size.max())[0]  # the rest is below rounding
            last = int(kept.max(initial=7))  # the first 4 may vanish; all, where T underflows
            self._series[y] = np.array(a[: last + 1])
        return self._series[y]

    def _series_of_sources(self, y: Observable) -> tuple[FloatArray, FloatArray]:
        """Coefficients of what drives y, over T^p, and rates at which terms decay: (n_terms,)."""
        drive = np.zeros(_TERMS)
        drive[0] = y.constant
        for factor, other in y.sources:
            known = self.series(other)[:_TERMS]
            drive[: known.size] += factor * known
        power, (eps, shift) = y.degree + np.arange(_TERMS), self._at_once(y)
        rate = self.law.lost(power, y.harmonic)
        return drive, rate / (1.0 + eps * np.exp(-shift * power) * rate)

    def error_estimate(self, observable: Observable) -> float:
        """What the Chebyshev coefficients of panels leave out, relative to their smaller ends."""
        key = "error", observable, self.count, self.rtol
        if key not in self._kept:
            last, before = self.rule.last_coefficients(self.solve(observable))
            # errors are at most 1.2 times the last coefficient, or a tenth of that times the one
            # before; the rest is for the initial state
            left_out = np.maximum(1.75 * last, 0.175 * before)
            # relative to the smaller end of a panel, or a thousandth of its maximum where y changes
            # sign; of a harmonic, which decays by itself, to m = 0; they add up while it grows
            of_speed = observable.harmonic and observable.is_power
            scale = speed_power(observable.degree) if of_speed else observable
            size = np.abs(self.solve(scale))
            ends = np.maximum(np.minimum(size[:, 0], size[:, -1]), 1e-3 * size.max(axis=1))
            self._kept[key] = float(np.sum(left_out / np.maximum(ends, 1e-300)))
        return float(self._kept[key])

    def at(self, y: Observable, x: FloatArray, leading: int = 0) -> tuple[FloatArray, NDArray[Any]]:
        """y at X = x, -inf allowed, and whether that is below the panels; each of its shape.

        Below them it is y T^-(p + leading), as T^p alone may overflow; the first ``leading`` terms
        of the power series must vanish. Above them y is on its asymptote.
        """
        values = self.solve(y)
        low = x < self.start
        level = (x[~low] - self.start) / self.width
        index = np.minimum(level.astype(int), self.count - 1)
        shares = self.rule.shares(np.minimum(level - index, 1.0))
        inside = np.einsum("ij,ij->i", shares, values[index]) / shares.sum(axis=1)
        beyond = level > self.count
        if beyond.any():
            if self.law.is_elastic and y.harmonic and y.is_power:
                inside[beyond] = 0.0  # it has decayed
            else:
                inside[beyond] = self._asymptote(values, y.growth, level[beyond])
        value = np.empty(x.shape)
        series = self.series(y)[leading:]
        value[low] = np.polynomial.polynomial.polyval(np.exp(x[low]), series)
        value[~low] = inside
        return value, low

    def _asymptote(self, values: FloatArray, growth: int, level: FloatArray) -> FloatArray:
        """The power, or polynomial in X, through the ends of the last panels, at X in panels."""
        ends = values[-1:-4:-1, -1] if values.shape[0] > 3 else values[-1, [-1, 0, 0]]
        u = level - self.count
        if self.law.is_elastic:
            power = round(math.log(ends[0] / ends[1]) / self.width)
            return np.asarray(ends[0] * np.exp(power * self.width * u))
        most = growth if values.shape[0] > 3 else min(growth, 1)
        slope, curve = ends[0] - ends[1], ends[0] - 2.0 * ends[1] + ends[2]
        terms = np.full(level.shape, ends[0]), slope * u, 0.5 * curve * u * (u + 1.0)
        return sum(terms[1 : most + 1], terms[0])
