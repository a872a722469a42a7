"""The bounce: how speed ratio and deflection are spread over the impact parameter, or samples.

A tracer meets a disk (or a sphere) with impact parameter ``y d``: y is uniform on [0, 1] in the
plane, and y^2 is in space. The normal component of its velocity, sqrt(1 - y^2) of it, is multiplied
by -e, the tangential one, y, by et. In units of its speed before the bounce (paper, label
``vchange``, where et = 1) it leaves with

    s^2 = e^2 (1 - y^2) + et^2 y^2,   s cos(chi) = et y^2 - e (1 - y^2)

A law is a weighted sum of such bounces, or of samples, which have the same methods.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.polynomial.legendre import legvander
from numpy.typing import ArrayLike, NDArray

from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import equal_panels, gauss_legendre
from kinetics.validation import finite_line, refuse

# Gauss-Legendre points on each panel. They are exact to 1e-14 for s^z cos(m chi) while this varies
# by less than RESOLVED radians on it: tests/kinetics/collision/test_law.py has the largest powers.
_POINTS = 20
RESOLVED = 30.0
_FOLDS = 20.0  # by so many e-folds an exponential may fall on one of them
DEEPEST = 40.0  # where s reaches 0, nodes end at -ln s of this: e^-40 of the bounces lose more
_MOST = 20_000  # samples: each costs some kilobytes on every panel


@dataclass(frozen=True)
class ImpactQuadrature:
    """Averages over one collision: E[f] = sum_k weight_k f_k; arrays of shape ``(n_nodes,)``.

    weight : positive, sums to 1
    log_loss : -ln s, s the speed ratio of the bounce; accurate relative to itself
    ratio, parallel : s, and s cos(chi), chi the deflection
    across : s sin(chi), where chi is small: cos(chi) alone would lose its digits; None elsewhere
    """

    weight: FloatArray
    log_loss: FloatArray
    ratio: FloatArray
    parallel: FloatArray
    dimension: int = 2
    across: FloatArray | None = None

    @cached_property
    def cosine(self) -> FloatArray:
        """cos(chi), shape (n_nodes,)."""
        return np.clip(self.parallel / self.ratio, -1.0, 1.0)

    @cached_property
    def deflection(self) -> FloatArray:
        """chi, from 0 to pi, shape (n_nodes,)."""
        if self.across is not None:
            return np.asarray(np.arctan2(self.across, self.parallel))
        return np.arccos(self.cosine)

    def harmonic(self, m: int) -> FloatArray:
        """What harmonic m keeps: cos(m chi) in the plane, P_m(cos chi) in space, (n_nodes,)."""
        return 1.0 - self.harmonic_loss(m)

    def harmonic_loss(self, m: int) -> FloatArray:
        """1 - harmonic(m), shape (n_nodes,), accurate where it is small."""
        if self.dimension == 2:  # 1 - cos(m chi) = 2 sin^2(m chi/2)
            return np.asarray(2.0 * np.sin(0.5 * m * self.deflection) ** 2)
        *_, last = self.harmonic_losses(abs(m))
        return last

    def harmonic_losses(self, top: int) -> Iterator[FloatArray]:
        """harmonic_loss(m) for m up to ``top``, one after another: there may be many nodes."""
        if self.dimension == 2:
            yield from (self.harmonic_loss(m) for m in range(top + 1))
            return
        # q_m = (1 - P_m(x))/(1 - x), from (n+1) P_(n+1) = (2n+1) x P_n - n P_(n-1)
        x = self.cosine
        turned = 1.0 - x if self.across is None else 2.0 * np.sin(0.5 * self.deflection) ** 2
        before, last = np.zeros_like(x), np.zeros_like(x)
        for n in range(top + 1):
            yield turned * last
            next_one = ((2 * n + 1) * (1.0 + x * last) - n * before) / (n + 1)
            before, last = last, next_one

    def part(self, used: NDArray[np.bool_]) -> ImpactQuadrature:
        """Some of the nodes, (n_nodes,) of booleans; their weights need not sum to 1."""
        weight, log_loss, ratio = self.weight[used], self.log_loss[used], self.ratio[used]
        across = None if self.across is None else self.across[used]
        parallel = self.parallel[used]
        return ImpactQuadrature(weight, log_loss, ratio, parallel, self.dimension, across)

    @classmethod
    def joined(cls, shares: Sequence[float], found: Sequence[ImpactQuadrature]) -> ImpactQuadrature:
        """The weighted sum of averages of one dimension; shares sum to 1."""
        if len(found) == 1:
            return found[0]
        weight = np.concatenate([w * q.weight for w, q in zip(shares, found, strict=True)])
        rows = ((q.log_loss, q.ratio, q.parallel) for q in found)
        loss, ratio, parallel = (np.concatenate(row) for row in zip(*rows, strict=True))
        across = None
        if any(q.across is not None for q in found):
            across = np.concatenate([q.ratio * np.sin(q.deflection) for q in found])
        return cls(weight, loss, ratio, parallel, found[0].dimension, across)


@dataclass(frozen=True)
class DiskBounce:
    """The bounce off a disk (dimension 2) or a sphere (3); e and et from 0 to 1, not both 0.

    Or e from -1 to 0, et = 1, off one that is pushed away: deflected by less than pi/2, and by
    nothing both where the tracer grazes and where it hits head-on.
    """

    restitution: float
    tangential_restitution: float = 1.0
    dimension: int = 2

    @cached_property
    def _ends(self) -> tuple[float, float, float]:
        """The least and the largest speed ratio, and the difference of their squares."""
        least, most = sorted((abs(self.restitution), self.tangential_restitution))
        return least, most, (most - least) * (most + least)

    @property
    def losses(self) -> tuple[float, float]:
        """The least and the largest -ln s."""
        least, most, _ = self._ends
        return 0.0 - math.log(most), -math.log(least) if least > 0.0 else math.inf

    @property
    def lowest_power(self) -> float:
        """-(d - 1) at e = 0, where s = et y; -2 at et = 0, where s = e sqrt(1 - y^2)."""
        if self.restitution == 0.0:
            return 1.0 - self.dimension
        return -2.0 if self.tangential_restitution == 0.0 else -math.inf

    @property
    def tail_exponent(self) -> float:
        """b where E[s^p] tends to b/p; NaN (not known) at rough scatterers with e = 1."""
        e, et = self.restitution, self.tangential_restitution
        if et == 1.0 and e < 1.0:
            return (self.dimension - 1.0) / ((1.0 - e) * (1.0 + e))
        return 0.0 if e < 1.0 else math.inf if et == 1.0 else math.nan

    @property
    def has_atoms(self) -> bool:
        """Whether s takes one value only."""
        return self.restitution == self.tangential_restitution

    @cached_property
    def _top(self) -> float:
        """U of :meth:`_nodes`: s has its branch points at the distance pi/2 of u = 0 then."""
        least, most, square = self._ends
        if least == 0.0:
            return 70.0  # more than the depth that is used
        # asinh(sqrt(square)/least), which does not overflow; any U > 0 will do for s = const
        return max(math.log(most + math.sqrt(square)) - math.log(least), 1e-3)

    def turns(self, rate: float, m: int) -> float:
        """By how much s^z and harmonic m turn on the longest panel, |z| up to ``rate``."""
        both_ends = 1.0 if self.restitution <= self.tangential_restitution else 2.0
        return both_ends * rate * min(1.0, self._top * math.tanh(self._top)) + 3.0 * m

    def _nodes(self, level: int, deepest: float = DEEPEST) -> tuple[FloatArray, ...]:
        """y, sqrt(1 - y^2) and the weights of an average over a uniform y, (n_nodes,) each."""
        top = self._top
        length = deepest if self._ends[0] == 0.0 else top
        u, w = equal_panels(length, _POINTS, min(1.0, top) * 2.0**-level)
        rest, u = u[::-1], top - length + u  # U - u without cancellation: nodes are symmetric
        scale, small = -math.expm1(-2.0 * top), np.exp(-2.0 * u)
        share = np.exp(-rest) * -np.expm1(-2.0 * u) / scale
        left = -np.expm1(-rest) * (1.0 + np.exp(-top - u)) / scale  # 1 - share
        w = w * np.exp(-rest) * (1.0 + small) / scale
        if self.restitution <= self.tangential_restitution:
            return share, np.sqrt(left * (1.0 + share)), w
        y, missed = np.sin(0.5 * math.pi * left), np.sin(0.5 * math.pi * share)
        return y, missed, 0.5 * math.pi * w * missed

    def _quadrature(self, y: FloatArray, missed: FloatArray, w: FloatArray) -> ImpactQuadrature:
        """From y, sqrt(1 - y^2) and weights of y: -ln s keeps its digits where s is near 1."""
        e, et = self.restitution, self.tangential_restitution
        least, most, square = self._ends
        low, high = (y, missed) if e <= et else (missed, y)
        lost = (1.0 - most) * (1.0 + most) + square * high**2  # 1 - s^2
        near = lost < 0.5
        xi = -np.log(np.hypot(least * high, most * low))
        xi = np.where(near, -0.5 * np.log1p(-np.where(near, lost, 0.0)), xi)
        weight = w if self.dimension == 2 else 2.0 * y * w
        parallel = et * y**2 - e * missed**2
        across = (et + e) * y * missed if e < 0.0 else None
        return ImpactQuadrature(weight, xi, np.exp(-xi), parallel, self.dimension, across)

    def quadrature(self, level: int) -> ImpactQuadrature:
        """The average, with panels 2^level times shorter than for slow functions."""
        return self._quadrature(*self._nodes(level))

    def beyond(self, p: NDArray[Any]) -> NDArray[Any] | float:
        """What bounces that lose more than any node add to E[s^p]: 0 but where s reaches 0."""
        if self._ends[0] > 0.0:
            return 0.0
        near, power = -DEEPEST, -self.lowest_power  # y = e^near where e = 0
        if self.restitution > 0.0:
            near += math.log(0.5 * math.pi)  # sqrt(1 - y^2), and y dy = -that times its change
        above = self.dimension - 1.0
        return above * np.exp(p * (math.log(self._ends[1]) + near) + power * near) / (p + power)

    def survival(self, level: int, rate: float) -> tuple[FloatArray, FloatArray]:
        """P(-ln s > u) is y^(d-1) where e < et, 1 - y^(d-1) where et < e, 1 up to the least loss.

        du = |et^2 - e^2| y dy/s^2.
        """
        # low speeds see the bulk of the scaling state, some e-folds wide, from the deepest loss
        y, missed, w = self._nodes(level, DEEPEST + 8.0)
        u = self._quadrature(y, missed, w).log_loss
        if self.restitution <= self.tangential_restitution:
            chance = y ** (self.dimension - 1)
        else:
            chance = missed**2 if self.dimension == 3 else missed**2 / (1.0 + y)
        w = w * y * chance * self._ends[2] * np.exp(2.0 * u)
        if self.losses[0] > 0.0:
            first, whole = equal_panels(self.losses[0], _POINTS, _FOLDS / max(rate, _FOLDS))
            u, w = np.concatenate([first, u]), np.concatenate([whole, w])
        return u, w


@dataclass(frozen=True)
class SampledBounce:
    """Weighted samples of (speed ratio, cos(chi)), in tuples of one length; weights sum to 1."""

    weight: tuple[float, ...]
    ratio: tuple[float, ...]
    cosine: tuple[float, ...]
    dimension: int = 2
    lowest_power = -math.inf  # every power has an average
    has_atoms = True

    @classmethod
    def checked(
        cls, weight: ArrayLike, ratio: ArrayLike, cosine: ArrayLike, dimension: int
    ) -> SampledBounce:
        """With weights that sum to 1 to rounding; InputError for anything that is no law."""
        w, s = finite_line("weight", weight), finite_line("ratio", ratio)
        c = finite_line("cosine", cosine)
        total = float(w.sum())
        if not 1 <= w.size <= _MOST or np.any(w < 0.0) or not abs(total - 1.0) <= 1e-9:
            refuse("weight", w, f"give 1 to {_MOST} numbers, none negative, whose sum is 1")
        if s.size != w.size or np.any(s <= 0.0):
            refuse("ratio", s, f"it must be {w.size} numbers above 0, one for each weight")
        if c.size != w.size or np.any(np.abs(c) > 1.0 + 1e-12):
            refuse("cosine", c, f"it must be {w.size} numbers from -1 to 1, one for each weight")
        kept = w > 0.0
        w, c = w[kept] / total, np.clip(c[kept], -1.0, 1.0)
        return cls(tuple(w.tolist()), tuple(s[kept].tolist()), tuple(c.tolist()), dimension)

    @property
    def losses(self) -> tuple[float, float]:
        """The least and the largest -ln s; the least is negative where energy may be gained."""
        return 0.0 - math.log(max(self.ratio)), 0.0 - math.log(min(self.ratio))

    @property
    def tail_exponent(self) -> float:
        """0 where every bounce loses energy; infinite where a share of them loses none."""
        return 0.0 if self.losses[0] > 0.0 else math.inf

    def turns(self, rate: float, m: int) -> float:
        """Samples are summed as they are."""
        return 0.0

    def quadrature(self, level: int) -> ImpactQuadrature:
        """The samples."""
        ratio = np.array(self.ratio)
        parallel = ratio * np.array(self.cosine)
        loss = 0.0 - np.log(ratio)
        return ImpactQuadrature(np.array(self.weight), loss, ratio, parallel, self.dimension)

    def beyond(self, p: NDArray[Any]) -> NDArray[Any] | float:
        """Nothing is left out."""
        return 0.0

    def survival(self, level: int, rate: float) -> tuple[FloatArray, FloatArray]:
        """Gauss points on equal cells, exact for polynomials: the chance falls in steps."""
        q = self.quadrature(0)
        # the weights are interpolatory, of half the order of Gauss weights
        largest = self.losses[1]
        count = math.ceil(4.0 * largest * max(rate, _FOLDS) / _FOLDS)
        width = largest / count
        cell = np.minimum((q.log_loss / width).astype(int), count - 1)
        node, weight = gauss_legendre(_POINTS)
        # integrals of Lagrange's polynomials up to each sample, by Legendre's
        legendre = legvander(2.0 * q.log_loss / width - 2.0 * cell - 1.0, _POINTS)
        legendre[:, 1:] -= np.insert(legendre[:, :-2], 0, -1.0, axis=1)
        share = 0.5 * legendre[:, 1:] @ legvander(2.0 * node - 1.0, _POINTS - 1).T * weight
        ends = np.zeros((count, _POINTS))
        np.add.at(ends, cell, q.weight[:, None] * share)
        chance = np.bincount(cell, q.weight, count)
        beyond = chance.sum() - np.cumsum(chance)
        u = (np.arange(count)[:, None] + node) * width
        return u.ravel(), (width * (ends + beyond[:, None] * weight)).ravel()


Bounce = DiskBounce | SampledBounce
