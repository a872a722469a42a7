r"""Averages at a finite density: a tracer comes back to a scatterer after a flight there and back.

The operator of returns (:mod:`kinetics.collision.medium`) acts at once; a real return is a loop of
some path y, half of it before the bounce straight back and half at e times the speed. In the clock
T = u t/l it takes y c, c = (1 + 1/e)/2, at the speed that the loop begins with, and of the time
left the tracer keeps e (T - y c). With K one collision, for an observable of degree 0,

    dY/dT = (K - 1) U + sources,    U = Y + V,
    V(T) = (-1)^m int dy k(y) W(e (T - y c)),    W = (K - 1) U.

Loops between near pairs of scatterers have k = (2 e/(1 + e)) n exp(-0.6 y)/y from y = 2 n on (one
neighbour and back), 0.6 being the mean corridor that is known to be empty; what is flown of them is
y - 2 n. The rest of eps, of loops of the size of l, is spread as exp(-0.9 y/b) - exp(-1.1 y/b),
nearly y exp(-y/b). The integral of k is eps: the late <r^2> grows as with returns at once. b is
fitted to <r^2> of simulations.

Of powers of the speed nothing is fitted (:meth:`Medium.of_speed`): loops of the size of l leave a
share of the speed of their own, nearly e^2, and what else comes back does so at once. Other
observables of the harmonic m = 0, as <r^2> itself, keep all returns at once.

All of k is a sum of exponentials w exp(-s y), so that V is one of modes Z, V = (-1)^m sum w Z, with
c dZ/dT = W(e T) - s Z. On panels in X = ln T collocation makes small matrices of that.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.collision.law import CollisionLaw
from kinetics.collision.medium import CORRIDOR, Medium
from kinetics.moments.backward import START, BackwardEquation, Observable, power_series
from kinetics.numerics import ROUNDING, FloatArray
from kinetics.numerics.chebyshev import Chebyshev, PanelShifts
from kinetics.numerics.gauss import equal_panels

_LOOPS = 1.8  # b = 1.8 e l, which loops of the size of l are spread over
_APART = 0.1  # of two rates about 1/b: exp(-0.9 y/b) - exp(-1.1 y/b) is nearly 0.2 (y/b) exp(-y/b)
_MODES = 20  # of near loops: the sum is 1e-3 of k off for y < 20 l
_SLOWEST, _FASTEST = 0.02, 12.0  # rates per l, and per 2 n, between which they are
_TERMS = 20  # of power series, up to where the fastest loops have fallen to 1/e
_SHORTEST = 1e-3  # in l: near loops that are shorter are taken to be so long


def met_again(law: CollisionLaw) -> Medium | None:
    """The scatterers that a tracer comes back to; None where there are none, as at e = 0."""
    return law.medium if law.medium is not None and law.medium.restitution else None


def _pace(ratio: Any) -> Any:
    """Time that a loop takes over its path: c, of the speed ratio of the bounce half on the way."""
    return 0.5 * (1.0 + 1.0 / ratio)


def series_end(medium: Medium) -> float:
    """X = ln T up to which power series in T hold the fastest loops."""
    return math.log(_pace(medium.restitution) / float(loops(medium)[0].max()))


@lru_cache(maxsize=16)
def loops(medium: Medium, of_speed: bool = False) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Rates s in 1/l, (n_modes,), weights w of near loops and of the others, (2, n_modes), and the
    speed ratios of both, (2,).

    The sum of w exp(-s y) is k of near loops; of the others its integral is 1. of_speed: as powers
    of the speed have them, whose other loops have k too.
    """
    from scipy.special import exp1

    e, a = medium.restitution, max(2.0 * medium.density, _SHORTEST)
    u, step = equal_panels(math.log(_FASTEST / a / _SLOWEST), _MODES, math.inf)
    grown = np.append(0.5 * _SLOWEST, _SLOWEST * np.exp(u))
    weight = np.append(_SLOWEST, step * grown[1:]) * np.exp(-(CORRIDOR + grown) * a)
    rate = CORRIDOR + grown
    weight[-1] += rate[-1] * (exp1(2.0 * CORRIDOR * medium.density) - (weight / rate).sum())
    ratio, spread, share = medium.far_loops if of_speed else (e, _LOOPS * e, 1.0)
    far = (1.0 + _APART * np.array([-1.0, 1.0])) / spread
    apart = share * far.prod() / (far[1] - far[0])
    weights = np.zeros((2, rate.size + 2))
    weights[0, :-2] = 2.0 * e / (1.0 + e) * medium.density * weight
    weights[1, -2:] = apart, -apart
    return np.append(rate, far), weights, np.array([e, ratio])


@lru_cache(maxsize=16)
def _slopes(nodes: int, width: float) -> tuple[NDArray[Any], ...]:
    """exp(-x) d/dx on a panel but for its first node, and lambda, P, P^-1 of it without that.

    Then, what rounding of the eigenvectors leaves of a function of it.
    """
    rule = Chebyshev(nodes, width)
    slopes = np.exp(-width * rule.local)[1:, None] * rule.derivative[1:]
    value, vector = np.linalg.eig(slopes[:, 1:])
    return slopes, value, vector, np.linalg.inv(vector), ROUNDING * np.linalg.cond(vector)


def _responses(
    rule: Chebyshev, pull: FloatArray, weights: FloatArray, rtol: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Of R = (exp(-x) d/dx + pull)^-1 on a panel, 0 at its first node; pull (n_panels, n_modes).

    The weighted sums of R over modes, (n_panels, n_kinds, nodes - 1, nodes - 1), what is left of 1
    at the first node, and the last rows of R, (n_panels, n_modes, nodes - 1) each.
    """
    slopes, value, vector, back, lost = _slopes(rule.nodes, rule.width)
    if lost > 0.2 * rtol:
        one = np.eye(rule.nodes - 1)
        every: Any = np.linalg.inv(slopes[:, 1:] + pull[:, :, None, None] * one)
        summed = np.moveaxis(np.tensordot(weights, every, axes=(1, 1)), 0, 1)
        return summed, np.asarray(-every @ slopes[:, 0]), every[:, :, -1]
    inverse = 1.0 / (value + pull[:, :, None])
    decay = -((inverse * (back @ slopes[:, 0])) @ vector.T).real
    summed = ((vector * (weights @ inverse)[:, :, None]) @ back).real
    return summed, decay, ((inverse * vector[-1]) @ back).real


class Loops:
    """What loops bring to panels in X = ln T, as powers T^degree of the time that is left.

    With f = W(e T) at the nodes of a panel and the modes z where it begins, V there is ``come`` @
    (f, z), and the modes where it ends are ``kept`` z + ``gained`` @ f; f itself is ``below`` @ W
    on the ``reach`` panels below + ``inside`` @ W on the panel.

    medium : the scatterers, e > 0
    rule : the collocation of a panel
    start : X where the panels begin, not above `series_end`
    count : how many panels there are, at most
    harmonics : the m that are asked for
    of_speed : those of powers of the speed, whose kinds differ in the speed ratio, e in f
    rtol : relative accuracy of all this, at least; by default well below that of a panel

    shares, weights : of the kinds of loops, (m, n_kinds), and of modes in them, (n_kinds, n_modes)
    come, kept, gained : of each panel, (n_panels, n_kinds, nodes, nodes + n_modes), (n_panels,
        n_modes), (n_panels, n_ratios, n_modes, nodes)
    below, inside : of each speed ratio, (n_ratios, nodes, reach * nodes) and (.., nodes, nodes)
    """

    def __init__(
        self, medium: Medium, rule: Chebyshev, start: float, count: int, harmonics: range,
        degree: float = 0.0, of_speed: bool = False, rtol: float = 1.5e-11,
    ) -> None:  # fmt: skip
        self.rule, self.start, self.count, self.degree = rule, start, count, degree
        rate, weights, ratios = loops(medium, of_speed)
        self.weights, self.shares, of_ratio = weights, np.ones((1, 2)), weights != 0.0
        if not of_speed:  # near and far loops together are eps
            near = float((weights[0] / rate).sum())
            shares = [((-1.0) ** m, medium.returns(m)[0] - (-1.0) ** m * near) for m in harmonics]
            self.shares, ratios, of_ratio = np.array(shares), ratios[:1], np.ones((1, rate.size))
        pace, self._ratio = _pace(ratios) @ of_ratio, ratios @ of_ratio
        self._rate, self._pace = rate / pace, pace
        n, width = rule.nodes, rule.width
        unit = np.exp(start + width * np.arange(count))  # T where a panel begins
        power = np.exp(degree * width * rule.local)
        come = self.weights / pace
        here, decay, gained = _responses(rule, unit[:, None] * self._rate, come, rtol)
        self.come = np.zeros((count, len(self.weights), n, n + self._rate.size))
        self.come[:, :, 1:, 1:n] = unit[:, None, None, None] * here * (power[1:, None] / power[1:])
        self.come[:, :, 0, n:] = self.weights
        self.come[:, :, 1:, n:] = self.weights[:, None] * np.swapaxes(decay, 1, 2)[:, None]
        self.come[:, :, :, n:] *= power[:, None]
        self.kept = power[-1] * decay[:, :, -1]
        self.gained = np.zeros((count, len(ratios), self._rate.size, n))
        gained = (unit[:, None] / pace)[:, :, None] * gained * (power[-1] / power[1:])
        self.gained[..., 1:] = gained[:, None] * of_ratio[:, :, None]
        shift = PanelShifts(rule, -np.log(ratios))
        self.reach = int(shift.below.max())
        rows = np.zeros((len(ratios), n, self.reach + 1, n))
        for i in range(len(ratios)):
            rows[i, np.arange(n), self.reach - shift.below[:, i]] = shift.rows[:, i]
        self.below, self.inside = rows[:, :, :-1].reshape(len(ratios), n, -1), rows[:, :, -1]

    def term(self, k: int, modes: FloatArray, lost: Any) -> FloatArray:
        """Term k of the power series of modes (n_modes, ...), from terms k - 1 and of W (...)."""
        come = np.multiply.outer(self._ratio ** (self.degree + k - 1) / self._pace, lost)
        return np.asarray((come - (self._rate * modes.T).T) / k)


class Returns:
    """Returns that take time: V, of which collisions act on U = Y + V, made of W = (K - 1) U.

    loops : what they bring to the panels
    lost, modes : power series of W and of the modes below all panels, both over T^degree, of the
        harmonics that are not zero there: shapes (n_terms, m, n_k) and (n_terms, n_modes, m, n_k)
    """

    def __init__(self, loops: Loops, lost: FloatArray, modes: FloatArray) -> None:
        self._loops, n = loops, loops.rule.nodes
        x = loops.rule.width * (np.arange(-loops.reach, 0)[:, None] + loops.rule.local)
        x = np.append(loops.start + x.ravel(), loops.start)
        with np.errstate(under="ignore"):
            power = np.exp(x)[:, None] ** np.arange(lost.shape[0])
            power *= np.exp(loops.degree * x)[:, None]
        (_, few, size), harmonics = lost.shape, len(loops.shares)
        self._modes = np.zeros((modes.shape[1], harmonics, size))
        self._modes[:, :few] = np.tensordot(power[-1], modes, axes=1)
        self._lost = np.zeros(((loops.reach + loops.count) * n, harmonics, size))  # W
        self._lost[: x.size - 1, :few] = np.tensordot(power[:-1], lost, axes=1)

    def begin(self, j: int, loss: FloatArray, drive: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Loss matrices (m, n, n) and gain (m, n, n_k) of panel j with what loops bring to it."""
        used, n, size = drive.shape
        loops, shares = self._loops, self._loops.shares[:used]
        below = self._lost[j * n : (j + loops.reach) * n, :used]
        self._come = np.tensordot(loops.below, below, axes=1)
        brought = loops.come[j, :, :, :n] @ self._come.reshape(-1, n, used * size)
        brought += loops.come[j, :, :, n:] @ self._modes[:, :used].reshape(-1, used * size)
        brought = np.einsum("mk,kimq->miq", shares, brought.reshape(-1, n, used, size))
        here = np.tensordot(shares, loops.come[j, :, :, :n] @ loops.inside, axes=1)
        self._inverse = np.linalg.inv(np.eye(n) + here @ loss)
        self._added = self._inverse @ (here @ drive + brought)
        self._loss, self._drive = loss, drive
        return loss @ self._inverse, drive - loss @ self._added

    def end(self, j: int, found: FloatArray) -> FloatArray:
        """U on panel j, where Y was found, both (m, n, n_k)."""
        total = self._inverse @ found + self._added
        used, n, _ = found.shape
        lost = np.moveaxis(self._drive - self._loss @ total, 0, 1)
        loops, begin = self._loops, (self._loops.reach + j) * n
        self._lost[begin : begin + n, :used] = lost
        come = self._come + np.tensordot(loops.inside, lost, axes=1)
        self._modes *= loops.kept[j][:, None, None]
        self._modes[:, :used] += np.tensordot(loops.gained[j], come, axes=([0, 2], [0, 1]))
        self._modes[:, used:] = 0.0
        return np.asarray(total)


@dataclass
class DelayedReturns(BackwardEquation):
    """The backward equation with returns that take time; its law must have a medium, e > 0."""

    def _at_once(self, y: Observable) -> tuple[float, float]:
        """Nothing of harmonics, and of powers of the speed what no loop brings."""
        assert self.law.medium is not None
        if y.harmonic:
            return 0.0, 0.0
        return self.law.medium.of_speed if self._takes_time(y) else super()._at_once(y)

    def _takes_time(self, y: Observable) -> bool:
        """Not <r^2> and collisions, nor negative powers, of slow tracers; see the module."""
        assert self.law.medium is not None
        grows = y.is_power and y.degree > 0.0 and self.law.medium.of_speed[0] > 0.0
        return y.harmonic > 0 or grows

    def __post_init__(self) -> None:
        assert self.law.medium is not None
        self.start = min(START, series_end(self.law.medium))
        super().__post_init__()

    def _loops(self, y: Observable) -> Loops:
        m = y.harmonic
        key = Loops, m, y.degree, self.count, self.rtol
        if key not in self._kept:
            assert self.law.medium is not None
            asked = self.rule, self.start, self.count, range(m, m + 1), y.degree, m == 0, self.rtol
            self._kept[key] = Loops(self.law.medium, *asked)
        return self._kept[key]

    def _early(self, y: Observable) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Power series of Y, U, W, (n_terms,), and of the modes, (n_terms, n_modes), over T^p."""
        if y not in self._kept:
            drive, rates = self._series_of_sources(y)
            loops = self._loops(y)
            weights = loops.shares[0] @ loops.weights
            modes, value = [np.zeros(weights.size)], [float(y.is_power)]
            total, lost = [], []
            known = zip(drive[:_TERMS].tolist(), rates[:_TERMS].tolist(), strict=True)
            for k, (source, rate) in enumerate(known, 1):
                total.append(value[-1] + float(weights @ modes[-1]))
                lost.append(-rate * total[-1])
                value.append((source + lost[-1]) / k)
                modes.append(loops.term(k, modes[-1], lost[-1]))
            found = value[:-1], total, lost, modes[:-1]
            self._kept[y] = tuple(np.array(each) for each in found)
        return self._kept[y]

    def series(self, y: Observable) -> FloatArray:
        """Coefficients a_k of y = T^p sum_k a_k T^k."""
        return self._early(y)[0] if self._takes_time(y) else super().series(y)

    def _solve(self, y: Observable) -> FloatArray:
        if not self._takes_time(y):
            return super()._solve(y)
        (loss, gain), (matrix, rate), n = self._kernel(y), self._rows(y.degree), self.nodes
        value, total, lost, modes = self._early(y)
        returns = Returns(self._loops(y), lost[:, None, None], modes[..., None, None])
        reach = gain.shape[1] // n
        table = np.empty((reach + self.count, n))  # of U
        table[:reach] = power_series(y.degree, self._nodes_from(-reach)[:reach], total)
        first = power_series(y.degree, np.array(self.start), value)
        source, found = self._driven(y), np.empty((self.count, n))
        for j in range(self.count):
            below = (gain @ table[j : j + reach].ravel())[None, :, None]
            (inside,), (come,) = returns.begin(j, loss[None], below)
            matrix[j] += rate[j, :, None] * inside
            matrix[j, 0] = np.eye(n)[0]
            right = rate[j] * (come[:, 0] + source[j])
            right[0] = first
            found[j] = np.linalg.solve(matrix[j], right)
            table[reach + j] = returns.end(j, found[None, j, :, None])[0, :, 0]
            first = found[j, -1]
        return found
