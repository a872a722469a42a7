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
y exp(-y/b). Both begin as exp(-a/y). The integral of k is eps: the late <r^2> grows as with returns
at once. b is fitted to <r^2> of simulations. The harmonic m = 0 keeps returns at once: with a delay
a_2 is some 60 n per cent off, without it half of that at most.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from kinetics.collision.medium import Medium
from kinetics.moments.backward import START, BackwardEquation, Observable
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import equal_panels
from kinetics.numerics.panels import PanelRule

_CORRIDOR = 0.6  # per l: how fast near loops are cut off, exp(-R (1 + |delta|/4)) averaged
_LOOPS = 1.5  # b in l, which loops of the size of l are spread over
_LONGEST = 60.0  # loop in l: e^-36 of the near ones are longer
_LEAST = 36.0  # near loops that are so many times shorter than those that begin: e^-36
_POINTS, _WIDE = 2, 2.0  # of the sums over loops: points beside half of the nodes; panels in ln y
_SHARPEST = 2.0  # e-folds below n: how sharp what follows the first returns is

Operator = tuple[int, FloatArray, FloatArray, FloatArray]
"""Of a panel: the first panel that loops lead to; what they bring from there on, to itself, near
and far (2, nodes, n_panels * nodes); their weights (2, nodes, n_early) and times left (nodes,
n_early) where these are below all panels."""


def _begin(medium: Medium) -> float:
    """Length a in l: the integral of exp(-a/y)/y is that of 1/y from 2 n on."""
    return 2.0 * medium.density * math.exp(-np.euler_gamma)


def _shortest(medium: Medium) -> float:
    """Loop in l below which there are none to rounding."""
    return _begin(medium) / _LEAST


def _pace(medium: Medium) -> float:
    """Time that a loop takes over its path: c."""
    return 0.5 * (1.0 + 1.0 / medium.restitution)


def first_closed(medium: Medium) -> float:
    """X = ln T below which no loop is closed to rounding."""
    return math.log(_shortest(medium) * _pace(medium))


def loops(medium: Medium, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """k(y) of near loops, and the shape of those of the size of l, of y in l, in its shape.

    Near loops have exp(-a/y)/y in place of 1/y from 2 n on, and as many; all loops begin so.
    """
    e, a = medium.restitution, _begin(medium)
    begin = np.exp(-a / y)
    near = 2.0 * e / (1.0 + e) * medium.density * np.exp(-_CORRIDOR * y) / y
    return near * begin, y * np.exp(-y / _LOOPS) * begin


@dataclass(frozen=True)
class Loops:
    """What loops bring to the nodes of panels in X = ln T.

    medium : the scatterers, e > 0
    rule : the collocation of a panel
    start : X where the panels begin, not above `first_closed`
    harmonic : the largest m that is asked for
    turning : how many times narrower panels in the path of a loop are, for what turns with it
    """

    medium: Medium
    rule: PanelRule
    start: float
    harmonic: int
    turning: float = 1.0

    @cached_property
    def _all_loops(self) -> tuple[FloatArray, FloatArray]:
        """All loops y in l, (n,), and their weights, near and far, (2, n)."""
        u, w = equal_panels(math.log(_LONGEST / _shortest(self.medium)), 16)
        y = _shortest(self.medium) * np.exp(u)
        return y, w * y * np.stack(loops(self.medium, y))

    @cached_property
    def shares(self) -> FloatArray:
        """Factors of the near and of the far loops so that together they are eps, (m, 2)."""
        near, far = self._all_loops[1].sum(axis=1).tolist()
        rest = [(self.medium.returns(m) - near) / far for m in range(self.harmonic + 1)]
        return np.array([((-1.0) ** m, (-1.0) ** m * each) for m, each in enumerate(rest)])

    def _paths(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Loops y in l for each X, (n, n_loops), and weights, near and far, (2, n, n_loops)."""
        points = self.rule.nodes // 2 + _POINTS
        top = np.minimum(np.exp(x) / _pace(self.medium), _LONGEST)[:, None]
        log_half = np.maximum(np.log(0.5 * top / _shortest(self.medium)), 1e-300)
        u, w = equal_panels(float(log_half[-1, 0]), points, _WIDE / self.turning)
        span = log_half / log_half[-1]
        low = _shortest(self.medium) * np.exp(span * u)
        v, z = equal_panels(_SHARPEST - math.log(self.medium.density), points, _WIDE / self.turning)
        near, part = equal_panels(math.exp(-_SHARPEST) * self.medium.density, points)
        v, z = np.append(np.exp(-v), near[::-1]), np.append(np.exp(-v) * z, part[::-1])
        y = np.concatenate([low, top * (1.0 - 0.5 * v)], axis=1)
        step = np.concatenate([span * w * low, 0.5 * top * z], axis=1)
        return y, step * np.stack(loops(self.medium, y))

    def of_panel(self, j: int, p: float = 0.0) -> Operator:
        """What they bring to panel j, as powers T^p of the time that is left."""
        n, width = self.rule.nodes, self.rule.width
        x = self.start + width * (j + self.rule.local)
        y, weight = self._paths(x)
        left = np.maximum(-np.expm1(np.log(y * _pace(self.medium)) - x[:, None]), 1e-300)
        level = x[:, None] + np.log(self.medium.restitution * left) - self.start
        level /= width
        low = level < 0.0
        early = np.exp(self.start + width * np.where(low, level, -np.inf))
        if p:
            power = np.exp(p * (x + math.log(self.medium.restitution)))[:, None]
            weight = weight * np.where(low, power, np.where(low, 1.0, left) ** -p)
        index = np.clip(level.astype(int), 0, j)
        rows = self.rule.shares(np.clip(level - index, 0.0, 1.0).ravel())
        rows = (np.where(low, 0.0, weight).reshape(2, -1) / rows.sum(axis=1))[:, :, None] * rows
        # the time that is left falls along a row: loops to the same panel are neighbours
        place = (np.arange(n)[:, None] * (j + 1) + j - index).ravel()
        begin = np.flatnonzero(np.diff(place, prepend=-1))
        blocks = np.zeros((2, n * (j + 1), n))
        blocks[:, place[begin]] = np.add.reduceat(rows, begin, axis=1)
        first = int(np.where(low, j, index).min())
        blocks = blocks.reshape(2, n, j + 1, n)[:, :, j - first :: -1]
        used = low.any(axis=0)
        before = np.where(low, weight, 0.0)[:, :, used], early[:, used]
        return first, blocks.reshape(2, n, -1), *before


class Returns:
    """Returns that take time: V, of which collisions act on U = Y + V, made of W = (K - 1) U.

    operator : what loops bring to a panel, by its number
    shares : factors of near and of far loops, (m, 2); 0 where returns are at once
    early : the power series of W below all panels, shape (n_terms, m, n_k)
    count, nodes : how many panels there are, at most, and nodes of each
    """

    def __init__(
        self,
        operator: Callable[[int], Operator],
        shares: FloatArray,
        early: FloatArray,
        count: int,
        nodes: int,
    ) -> None:
        self._operator, self._shares, self._early = operator, shares, early
        self._lost = np.zeros((count, nodes, *early.shape[1:]))  # W

    def begin(self, j: int, loss: FloatArray, drive: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Loss matrices (m, n, n) and gain (m, n, n_k) of panel j with what loops bring to it."""
        first, blocks, weight, left = self._operator(j)
        used, n = drive.shape[:2]
        powers = left[:, :, None] ** np.arange(self._early.shape[0])
        come = np.tensordot(weight[:, :, None] @ powers, self._early[:, :used], axes=1)[:, :, 0]
        below = self._lost[first:j, :, :used].reshape(-1, used, drive.shape[2])
        come += np.tensordot(blocks[:, :, :-n], below, axes=1)
        shares = self._shares[:used]
        here = np.tensordot(shares, blocks[:, :, -n:], axes=1)
        self._inverse = np.linalg.inv(np.eye(n) + here @ loss)
        self._added = self._inverse @ (here @ drive + np.einsum("mk,kimq->miq", shares, come))
        self._loss, self._drive = loss, drive
        return loss @ self._inverse, drive - loss @ self._added

    def end(self, j: int, found: FloatArray) -> FloatArray:
        """U on panel j, where Y was found, both (m, n, n_k)."""
        total = self._inverse @ found + self._added
        self._lost[j, :, : found.shape[0]] = np.moveaxis(self._drive - self._loss @ total, 0, 1)
        return np.asarray(total)


@dataclass
class DelayedReturns(BackwardEquation):
    """The backward equation with returns that take time; its law must have a medium, e > 0."""

    _operators: dict[float, list[Operator]] = field(default_factory=dict, repr=False)

    def _at_once(self, m: int) -> bool:
        """The speed alone is nearer to simulations so."""
        return m == 0

    @property
    def start(self) -> float:
        """X where the panels begin."""
        assert self.law.medium is not None
        return min(START, first_closed(self.law.medium))

    @cached_property
    def _loops(self) -> Loops:
        assert self.law.medium is not None
        return Loops(self.law.medium, self.rule, self.start, self.harmonic)

    def _operator(self, p: float) -> list[Operator]:
        """What loops make of (K - 1) U on each panel, as powers T^p of the time that is left."""
        if p not in self._operators:
            self._operators[p] = [self._loops.of_panel(j, p) for j in range(self.count)]
        return self._operators[p]

    def _returns(self, y: Observable) -> Returns | None:
        if self._at_once(y.harmonic):
            return None
        # below the panels (K - 1) U is (K - 1) Y, by its power series
        series, law = self.series(y), self.law.without_medium
        rates = law.harmonic_decay_rate(y.degree + np.arange(series.size), y.harmonic)
        operators, shares = self._operator(y.degree), self._loops.shares[[y.harmonic]]
        early = (-rates * series)[:, None, None]
        return Returns(operators.__getitem__, shares, early, self.count, self.nodes)
