"""The bounce: how speed ratio and deflection are spread over the impact parameter, or samples.

A tracer meets a disk (or a sphere) with impact parameter ``y d``: y is uniform on [0, 1] in the
plane, and y^2 is in space. The normal component of its velocity, sqrt(1 - y^2) of it, is multiplied
by -e, the tangential one, y, by et. In units of its speed before the bounce (paper, label
``vchange``, where et = 1) it leaves with

    speed                 s^2 = e^2 (1 - y^2) + et^2 y^2
    parallel component    s cos(chi) = et y^2 - e (1 - y^2)

Any other law is made of samples, or a mixture of these. All kinds have the same methods, and the
law asks for no more.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.polynomial.legendre import legvander
from numpy.typing import ArrayLike, NDArray

from kinetics.collision.averages import ImpactQuadrature
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
class DiskBounce:
    """The bounce off a disk (dimension 2) or a sphere (3); e and et from 0 to 1, not both 0.

    Or e from -1 to 0, et = 1, off one that is pushed away: the tracer is deflected by less than
    pi/2, and by nothing both where it grazes and where it hits head-on.
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
    def least_loss(self) -> float:
        """-ln of the largest speed ratio."""
        return 0.0 - math.log(self._ends[1])

    @property
    def largest_loss(self) -> float:
        """-ln of the smallest speed ratio."""
        return 0.0 - math.log(self._ends[0]) if self._ends[0] > 0.0 else math.inf

    @property
    def lowest_power(self) -> float:
        """-(d - 1) at e = 0, where s = et y; -2 at et = 0, where s = e sqrt(1 - y^2)."""
        if self.restitution == 0.0:
            return 1.0 - self.dimension
        return -2.0 if self.tangential_restitution == 0.0 else -math.inf

    @property
    def tail_exponent(self) -> float:
        """b where E[s^p] tends to b/p: from y near 1 where et = 1, and near 0 where e = 1."""
        e, et = self.restitution, self.tangential_restitution
        if et == 1.0:
            return (self.dimension - 1.0) / ((1.0 - e) * (1.0 + e)) if e < 1.0 else math.inf
        if e < 1.0:
            return 0.0
        return 2.0 / ((1.0 - et) * (1.0 + et)) if self.dimension == 3 else math.nan

    @property
    def has_atoms(self) -> bool:
        """Whether s takes one value only."""
        return self.restitution == self.tangential_restitution

    @property
    def parts(self) -> tuple[DiskBounce | SampledBounce, ...]:
        """The bounces that a mixture is made of: this one."""
        return (self,)

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

    def _nodes(
        self, level: int, deepest: float = DEEPEST
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
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
        """P(xi > u) is y^(d-1) where e < et and 1 - y^(d-1) where et < e; 1 up to the least loss.

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
        if self.least_loss > 0.0:
            first, whole = equal_panels(self.least_loss, _POINTS, _FOLDS / max(rate, _FOLDS))
            u, w = np.concatenate([first, u]), np.concatenate([whole, w])
        return u, w

    def cells(self, spacing: float, points: int) -> tuple[ImpactQuadrature, NDArray[np.int64]]:
        """The average cell by cell of width ``spacing`` in -ln s, and the cell of each node.

        Gauss points in y, in which s is smooth; its density in -ln s is not. Where s
        reaches 0, cells end at e^-40 of its largest; the last one holds all below.
        """
        first, last = self.least_loss, self.largest_loss
        count = max(1, math.ceil(min(40.0 + first, last) / spacing))
        edge = np.clip(np.arange(count + 1) * spacing, first, last)
        if first == last:
            q = self.quadrature(0)
            return q, np.full(q.weight.size, count - 1)
        rise = -np.expm1(2.0 * np.minimum(0.0, edge - last)) * np.exp(-2.0 * edge)
        fall = -np.expm1(2.0 * np.minimum(0.0, first - edge)) * math.exp(-2.0 * first)
        angle = np.arctan2(np.sqrt(rise), np.sqrt(fall))  # 0 where s is least
        angle[-1] = 0.0
        rising = self.restitution < self.tangential_restitution
        z = np.sin(angle) if rising else 2.0 * np.sin(0.5 * angle) ** 2  # y, or 1 - y
        node, weight = gauss_legendre(points)
        width = (z[:-1] - z[1:])[:, None]
        at = (z[1:, None] + width * node).ravel()
        y, missed = (at, (1.0 - at) * (1.0 + at)) if rising else (1.0 - at, at * (2.0 - at))
        q = self._quadrature(y, np.sqrt(missed), (width * weight).ravel())
        kept = q.weight > 0.0  # cells below the least loss are empty
        return q.part(kept), np.repeat(np.arange(count), points)[kept]


@dataclass(frozen=True)
class SampledBounce:
    """Weighted samples of (speed ratio, cos(chi)); see :meth:`CollisionLaw.from_samples`.

    The three arguments are tuples of one length, so that laws compare and hash by their values.
    """

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
        if not 1 <= w.size <= _MOST:
            refuse("weight", w, f"give 1 to {_MOST} samples")
        for name, array in (("ratio", s), ("cosine", c)):
            if array.size != w.size:
                refuse(name, array, f"it must have as many numbers as weight, {w.size}")
        if np.any(w < 0.0):
            refuse("weight", float(w.min()), "weights must not be negative")
        if not abs(w.sum() - 1.0) <= 1e-9:  # they are rescaled to it
            refuse("weight", w, f"the weights must sum to 1, their sum is {w.sum():.10g}")
        if np.any(s <= 0.0):
            refuse("ratio", float(s.min()), "speed ratios must be above 0")
        if np.any(np.abs(c) > 1.0 + 1e-12):
            refuse("cosine", float(c[np.abs(c).argmax()]), "it must be from -1 to 1")
        kept = w > 0.0
        w, c = w[kept] / w.sum(), np.clip(c[kept], -1.0, 1.0)
        return cls(tuple(w.tolist()), tuple(s[kept].tolist()), tuple(c.tolist()), dimension)

    @property
    def least_loss(self) -> float:
        """-ln of the largest speed ratio; negative where a bounce may gain energy."""
        return 0.0 - math.log(max(self.ratio))

    @property
    def largest_loss(self) -> float:
        """-ln of the smallest speed ratio."""
        return 0.0 - math.log(min(self.ratio))

    @property
    def tail_exponent(self) -> float:
        """0 where every bounce loses energy; infinite where a share of them loses none."""
        return 0.0 if self.least_loss > 0.0 else math.inf

    @property
    def parts(self) -> tuple[DiskBounce | SampledBounce, ...]:
        """The bounces that a mixture is made of: this one."""
        return (self,)

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
        count = math.ceil(4.0 * self.largest_loss * max(rate, _FOLDS) / _FOLDS)
        width = self.largest_loss / count
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

    def cells(self, spacing: float, points: int) -> tuple[ImpactQuadrature, NDArray[np.int64]]:
        """The samples and the cell of each."""
        q = self.quadrature(0)
        return q, np.floor(q.log_loss / spacing).astype(np.int64)


@dataclass(frozen=True)
class MixedBounce:
    """Each bounce is one of the parts, by chance; see :meth:`CollisionLaw.mixture`.

    weight : of each part, positive, sum 1
    parts : bounces of one dimension; those that may stop a tracer come first
    """

    weight: tuple[float, ...]
    parts: tuple[DiskBounce | SampledBounce, ...]

    @classmethod
    def of(cls, weight: FloatArray, bounces: list[Bounce]) -> MixedBounce:
        """Mixtures among the bounces are taken apart; weights are positive, shape (n_bounces,)."""
        shares = weight / weight.sum()
        found: list[tuple[float, DiskBounce | SampledBounce]] = []
        for share, bounce in zip(shares.tolist(), bounces, strict=True):
            own = bounce.weight if isinstance(bounce, MixedBounce) else (1.0,)
            found += [(share * w, part) for w, part in zip(own, bounce.parts, strict=True)]
        found.sort(key=lambda one: -one[1].lowest_power)
        return cls(tuple(w for w, _ in found), tuple(part for _, part in found))

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return self.parts[0].dimension

    @property
    def least_loss(self) -> float:
        """-ln of the largest speed ratio."""
        return min(part.least_loss for part in self.parts)

    @property
    def largest_loss(self) -> float:
        """-ln of the smallest speed ratio."""
        return max(part.largest_loss for part in self.parts)

    @property
    def lowest_power(self) -> float:
        """E[s^p] exists above it."""
        return max(part.lowest_power for part in self.parts)

    @property
    def tail_exponent(self) -> float:
        """b where E[s^p] tends to b/p: the sum of those of the parts."""
        return self._sum([part.tail_exponent for part in self.parts])

    @property
    def has_atoms(self) -> bool:
        """Whether s takes single values at some of the bounces."""
        return any(part.has_atoms for part in self.parts)

    def _sum(self, values: list[Any]) -> Any:
        """The weighted sum of a value of each part."""
        return sum(w * value for w, value in zip(self.weight, values, strict=True))

    def turns(self, rate: float, m: int) -> float:
        """The most of any part."""
        return max(part.turns(rate, m) for part in self.parts)

    def quadrature(self, level: int) -> ImpactQuadrature:
        """The parts' points, joined."""
        return self._joined([part.quadrature(level) for part in self.parts])

    def _joined(self, found: list[ImpactQuadrature]) -> ImpactQuadrature:
        weight = np.concatenate([w * q.weight for w, q in zip(self.weight, found, strict=True)])
        rows = ((q.log_loss, q.ratio, q.parallel) for q in found)
        loss, ratio, parallel = (np.concatenate(row) for row in zip(*rows, strict=True))
        across = None
        if any(q.across is not None for q in found):
            across = np.concatenate([q.ratio * np.sin(q.deflection) for q in found])
        return ImpactQuadrature(weight, loss, ratio, parallel, self.dimension, across)

    def beyond(self, p: NDArray[Any]) -> NDArray[Any] | float:
        """The weighted sum of what the parts leave out."""
        found: NDArray[Any] | float = self._sum([part.beyond(p) for part in self.parts])
        return found

    def survival(self, level: int, rate: float) -> tuple[FloatArray, FloatArray]:
        """The parts' points, joined."""
        found = [part.survival(level, rate) for part in self.parts]
        weight = [w * each for w, (_, each) in zip(self.weight, found, strict=True)]
        return np.concatenate([u for u, _ in found]), np.concatenate(weight)

    def cells(self, spacing: float, points: int) -> tuple[ImpactQuadrature, NDArray[np.int64]]:
        """The parts' points, joined, and the cell of each."""
        found, cells = zip(*(part.cells(spacing, points) for part in self.parts), strict=True)
        return self._joined(list(found)), np.concatenate(cells)


Bounce = DiskBounce | SampledBounce | MixedBounce
