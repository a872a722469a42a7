r"""Averages at a finite density: a tracer comes back to a scatterer after a flight there and back.

The operator of returns (:mod:`kinetics.collision.medium`) acts at once; a real return is a loop of
some path y, half of it before the bounce straight back and half at e times the speed. In the clock
T = u t/l it takes y c, c = (1 + 1/e)/2, at the speed that the loop begins with, and of the time
left the tracer keeps e (T - y c). With K one collision, for an observable of degree 0,

    dY/dT = (K - 1) U + sources,    U = Y + V,
    V(T) = (-1)^m int dy k(y) [(K - 1) U](e (T - y c)),

where loops that are not yet closed bring nothing. Loops between near pairs of scatterers have
k = (2 e/(1 + e)) n exp(-0.6 y)/y from y = 2 n on (one neighbour and back), 0.6 being the mean
corridor that is known to be empty; the rest of eps, of loops of the size of l, is spread as
y exp(-y/b)/b^2. The integral of k is eps: the late <r^2> grows as with returns at once. b is
fitted to <r^2> of simulations. The harmonic m = 0, of the speed alone, keeps returns at once: with
a delay a_2 is some 60 n per cent off, without it half of that at most.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from kinetics.collision.medium import Medium
from kinetics.moments.backward import START, BackwardEquation, Observable
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import equal_panels

_CORRIDOR = 0.6  # per l: how fast near loops are cut off, exp(-R (1 + |delta|/4)) averaged
_LOOPS = 1.5  # b in l, which loops of the size of l are spread over
_LONGEST = 60.0  # loop in l: e^-36 of the near ones are longer
_SHARPEST = 3.0  # e-folds below n: how sharp what follows the first returns is
_AMPLE, _FEW = 100.0, 8  # T/c after which so many loops of each kind stand for all, to e^-35
_FIRST = 7.0  # e-folds below 2 n: e^-28 of the near loops are shorter

Operator = tuple[int, FloatArray, FloatArray, FloatArray]
"""Of a panel: the first panel that loops lead to; what they bring from there on, to itself, near
and far (2, nodes, n_panels * nodes); their weights (2, nodes, n_early) and times left (nodes,
n_early) where these are below all panels."""


def loops(medium: Medium, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """k(y) of near loops, and the shape of those of the size of l, of y in l, in its shape.

    Near loops have y^3/(y^4 + (2 n)^4) in place of 1/y from 2 n on; the shape has the integral 1.
    """
    e, n = medium.restitution, medium.density
    near = 2.0 * e / (1.0 + e) * n * np.exp(-_CORRIDOR * y) / (y * (1.0 + (2.0 * n / y) ** 4))
    return near, y * np.exp(-y / _LOOPS) / _LOOPS**2


def _gauss_of(x: FloatArray, weight: FloatArray, count: int) -> tuple[FloatArray, FloatArray]:
    """Gauss nodes and weights of a sum over many points x, (count,) each: Stieltjes' recurrence."""
    middle, norm = np.empty(count), np.empty(count)
    before, now = np.zeros(x.size), np.ones(x.size)
    for k in range(count):
        norm[k] = weight @ now**2
        middle[k] = weight @ (x * now**2) / norm[k]
        ratio = norm[k] / norm[k - 1] if k else 0.0
        before, now = now, (x - middle[k]) * now - ratio * before
    side = np.sqrt(norm[1:] / norm[:-1])
    nodes, vectors = np.linalg.eigh(np.diag(middle) + np.diag(side, 1) + np.diag(side, -1))
    return nodes, norm[0] * vectors[0] ** 2


@dataclass
class DelayedReturns(BackwardEquation):
    """The backward equation with returns that take time; its law must have a medium, e > 0."""

    _operators: dict[float, list[Operator]] = field(default_factory=dict, repr=False)

    @property
    def medium(self) -> Medium:
        """The scatterers."""
        assert self.law.medium is not None
        return self.law.medium

    def _at_once(self, m: int) -> bool:
        """The speed alone is nearer to simulations so."""
        return m == 0

    @property
    def start(self) -> float:
        """X below which no loop is closed to rounding."""
        return min(START, math.log(self._shortest * self._pace))

    @property
    def _shortest(self) -> float:
        """Loop in l below which there are none to rounding."""
        return 2.0 * self.medium.density * math.exp(-_FIRST)

    @property
    def _pace(self) -> float:
        """Time that a loop takes over its path: c."""
        return 0.5 * (1.0 + 1.0 / self.medium.restitution)

    @cached_property
    def _all_loops(self) -> tuple[FloatArray, FloatArray]:
        """All loops y in l, (n,), and their weights, near and far, (2, n)."""
        u, w = equal_panels(math.log(_LONGEST / self._shortest), 16)
        y = self._shortest * np.exp(u)
        return y, w * y * np.stack(loops(self.medium, y))

    @cached_property
    def _shares(self) -> FloatArray:
        """Factors of the near and of the far loops so that together they are eps, (m, 2)."""
        near, far = self._all_loops[1].sum(axis=1).tolist()
        rest = [(self.medium.returns(m) - near) / far for m in range(self.harmonic + 1)]
        return np.array([((-1.0) ** m, (-1.0) ** m * each) for m, each in enumerate(rest)])

    @cached_property
    def _late(self) -> tuple[FloatArray, FloatArray]:
        """A few loops that stand for all where much time is left: y (16,), weights (2, 16)."""
        y, each = self._all_loops
        near, far = (_gauss_of(y, weight, _FEW) for weight in each)
        none = np.zeros(_FEW)
        weight = np.stack([np.append(near[1], none), np.append(none, far[1])])
        return np.append(near[0], far[0]), weight

    def _paths(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Loops y in l for each X, (n, n_loops), and their weights, near and far, (2, n, n_loops).

        Up to half of the longest one in ln y; then in ln of what is left to the longest, because
        the first returns are a sharp event in the time that is left.
        """
        if x[0] > math.log(_AMPLE * self._pace):
            y, weight = self._late
            return np.tile(y, (x.size, 1)), np.repeat(weight[:, None], x.size, axis=1)
        points = max(6, (2 * self.nodes) // 3)
        top = np.minimum(np.exp(x) / self._pace, _LONGEST)[:, None]
        log_half = math.log(0.5 * _LONGEST / self._shortest)
        u, w = equal_panels(log_half, points)
        span = np.maximum(np.log(0.5 * top / self._shortest), 0.0) / log_half
        low = self._shortest * np.exp(span * u)
        v, z = equal_panels(_SHARPEST - math.log(self.medium.density), points)
        near, part = equal_panels(math.exp(-v[-1] - v[0]), points)
        v, z = np.append(np.exp(-v), near), np.append(np.exp(-v) * z, part)
        y = np.concatenate([low, top * (1.0 - 0.5 * v)], axis=1)
        step = np.concatenate([span * w * low, 0.5 * top * z], axis=1)
        return y, step * np.stack(loops(self.medium, y))

    def _operator(self, p: float) -> list[Operator]:
        """What loops make of (K - 1) U on each panel, as powers T^p of the time that is left."""
        if p not in self._operators:
            found = []
            for j in range(self.count):
                x = self.start + self.width * (j + self.rule.local)
                y, weight = self._paths(x)
                left = np.maximum(-np.expm1(np.log(y * self._pace) - x[:, None]), 1e-300)
                level = x[:, None] + np.log(self.medium.restitution * left) - self.start
                level /= self.width
                low = level < 0.0
                early = np.exp(self.start + self.width * np.where(low, level, -np.inf))
                power = np.exp(p * (x + math.log(self.medium.restitution)))[:, None]
                weight = weight * np.where(low, power, np.where(low, 1.0, left) ** -p)
                index = np.clip(level.astype(int), 0, j)
                first = int(index[~low].min(initial=j))
                rows = self.rule.shares(np.clip(level - index, 0.0, 1.0).ravel())
                rows = (rows / rows.sum(axis=1)[:, None]).reshape(*y.shape, -1)
                blocks = [
                    np.where(low | (index != k), 0.0, weight).swapaxes(0, 1) @ rows
                    for k in range(first, j + 1)
                ]
                used = low.any(axis=0)
                before = np.where(low, weight, 0.0)[:, :, used], early[:, used]
                found.append((first, np.concatenate(blocks, axis=2).swapaxes(0, 1), *before))
            self._operators[p] = found
        return self._operators[p]

    def _solve(self, y: Observable) -> FloatArray:
        m, p, n = y.harmonic, y.degree, self.nodes
        if self._at_once(m):
            return super()._solve(y)
        loss, gain = self._kernel(m)
        reach = gain.shape[1] // n
        x, known, drive = self._known(y, reach)
        rate = np.exp(x[reach:])
        # below the panels (K - 1) U is (K - 1) Y, by its power series
        series = self.series(y)
        series = (
            -self.law.without_medium.harmonic_decay_rate(p + np.arange(series.size), m) * series
        )
        total = np.empty((reach + self.count, n))  # U
        total[:reach] = known[:-1].reshape(reach, n)
        found, lost = np.empty((self.count, n)), np.empty((self.count, n))  # Y, (K - 1) U
        one, start = np.eye(n), known[-1]
        for j, (first, blocks, weight, early) in enumerate(self._operator(p)):
            back = np.tensordot(self._shares[m], blocks, axes=1)
            back, here = back[:, :-n], back[:, -n:]
            ended = np.sum(weight * np.polynomial.polynomial.polyval(early, series), axis=2)
            below = gain @ total[j : j + reach].ravel()
            # V = here (below - loss U) + what loops bring from panels below, U = Y + V
            inverse = np.linalg.inv(one + here @ loss)
            added = here @ below + back @ lost[first:j].ravel() + self._shares[m] @ ended
            added = inverse @ added
            scale = 1.0 / np.maximum(1.0, rate[j])
            matrix = scale[:, None] * (self.rule.derivative - p * one)
            matrix += (scale * rate[j])[:, None] * (loss @ inverse)
            right = scale * rate[j] * (below - loss @ added + drive[j])
            matrix[0], right[0] = one[0], start
            found[j] = np.linalg.solve(matrix, right)
            start = found[j, -1]
            total[reach + j] = inverse @ found[j] + added
            lost[j] = below - loss @ total[reach + j]
        return found
