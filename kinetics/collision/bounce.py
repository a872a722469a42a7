"""The bounce: how speed ratio and deflection are spread over the impact parameter, or samples.

A tracer meets a disk (or a sphere) with impact parameter ``y d``: y is uniform on [0, 1] in the
plane, and y^2 is in space. The normal component of its velocity, sqrt(1 - y^2) of it, is multiplied
by -e, the tangential one, y, by et. In units of its speed before the bounce (paper, label
``vchange``, where et = 1) it leaves with

    s^2 = e^2 (1 - y^2) + et^2 y^2,   s cos(chi) = et y^2 - e (1 - y^2)

A collision is a weighted sum of such bounces, or of samples, which have the same methods.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.polynomial.legendre import legvander
from numpy.typing import ArrayLike, NDArray

from kinetics.errors import InputError
from kinetics.numerics import FOLDS, FloatArray
from kinetics.numerics.gauss import equal_panels, gauss_legendre
from kinetics.results.record import stored_class
from kinetics.validation import finite_line, refuse

# Gauss-Legendre points on each panel. They are exact to 1e-14 for s^z cos(m chi) while this varies
# by less than 1.5 radians a point on it, and for exponentials that fall by one e-fold a point:
# tests/kinetics/collision/test_law.py has the largest powers.
_POINTS = 20
_LEVELS_KEPT = 6  # quadratures of up to 60,000 points are kept for the next question
_MOST_POINTS = 7e6  # about a gigabyte of exponentials
_MOST_SAMPLES = 20_000  # samples: each costs some kilobytes on every panel


@dataclass(frozen=True)
class ImpactQuadrature:
    """Averages over one collision: E[f] = sum_k weight_k f_k; arrays of shape ``(n_nodes,)``.

    weight : positive, sums to 1
    log_loss : -ln s, s the speed ratio of the bounce; accurate relative to itself
    deflection : chi, from 0 to pi, in which small deflections keep their digits
    """

    weight: FloatArray
    log_loss: FloatArray
    deflection: FloatArray
    dimension: int = 2

    @property
    def ratio(self) -> FloatArray:
        """s, shape (n_nodes,)."""
        return np.exp(-self.log_loss)

    @property
    def cosine(self) -> FloatArray:
        """cos(chi), shape (n_nodes,)."""
        return np.cos(self.deflection)

    def losses(self, z: NDArray[Any]) -> NDArray[Any]:
        """1 - s^z, of the shape of z and (n_nodes,), accurate where it is small."""
        if not np.iscomplexobj(z):
            return np.asarray(-np.expm1(-np.multiply.outer(z, self.log_loss)))
        fall, half = (np.multiply.outer(x, self.log_loss) for x in (z.real, 0.5 * z.imag))
        sine, left = np.sin(half), 2.0 * np.exp(-fall)  # quicker than a complex expm1
        left *= sine
        return np.asarray(left * sine - np.expm1(-fall) + 1j * (left * np.cos(half)))

    def harmonic_loss(self, m: int) -> FloatArray:
        """1 - cos(m chi) in the plane, 1 - P_m(cos chi) in space, accurate where it is small."""
        if self.dimension == 2:
            return np.asarray(2.0 * np.sin(0.5 * m * self.deflection) ** 2)
        *_, last = self.harmonic_losses(abs(m))
        return last

    def harmonic_losses(self, top: int) -> Iterator[FloatArray]:
        """harmonic_loss(m) for m up to ``top``, one after another: there may be many nodes."""
        if self.dimension == 2:
            yield from (self.harmonic_loss(m) for m in range(top + 1))
            return
        # q_m = (1 - P_m(x))/(1 - x), from (n+1) P_(n+1) = (2n+1) x P_n - n P_(n-1)
        x, turned = self.cosine, 2.0 * np.sin(0.5 * self.deflection) ** 2
        before, last = np.zeros_like(x), np.zeros_like(x)
        for n in range(top + 1):
            yield turned * last
            next_one = ((2 * n + 1) * (1.0 + x * last) - n * before) / (n + 1)
            before, last = last, next_one


@stored_class
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

    def level(self, rate: float, m: int) -> int:
        """How often panels are halved for functions as fast as s^z cos(m chi), |z| up to rate."""
        both_ends = 1.0 if self.restitution <= self.tangential_restitution else 2.0
        turn = both_ends * rate * min(1.0, self._top * math.tanh(self._top)) + 3.0 * m
        finer = max(1.0, turn / (1.5 * _POINTS))
        length = FOLDS if self._ends[0] == 0.0 else self._top
        if not finer * _POINTS * max(1.0, length) <= _MOST_POINTS:
            raise InputError(f"p: got a size of {rate:.3g}; E[s^p] needs too many points there")
        return math.ceil(math.log2(finer))

    def _nodes(self, level: int, deepest: float = FOLDS) -> tuple[FloatArray, ...]:
        """y, sqrt(1 - y^2), weights of a uniform y, -ln s, (n_nodes,); panels are 2^-level long."""
        e, et, top = self.restitution, self.tangential_restitution, self._top
        least, most, square = self._ends
        length = deepest if least == 0.0 else top
        u, w = equal_panels(length, _POINTS, min(1.0, top) * 2.0**-level)
        rest, u = u[::-1], top - length + u  # U - u without cancellation: nodes are symmetric
        scale, small = -math.expm1(-2.0 * top), np.exp(-2.0 * u)
        low = np.exp(-rest) * -np.expm1(-2.0 * u) / scale
        left = -np.expm1(-rest) * (1.0 + np.exp(-top - u)) / scale  # 1 - low
        w = w * np.exp(-rest) * (1.0 + small) / scale
        high = np.sqrt(left * (1.0 + low))
        if e > et:
            high, low = np.sin(0.5 * math.pi * left), np.sin(0.5 * math.pi * low)
            w = 0.5 * math.pi * w * low
        lost = (1.0 - most) * (1.0 + most) + square * high**2  # 1 - s^2: keeps digits near s = 1
        near = lost < 0.5
        xi = -np.log(np.hypot(least * high, most * low))
        xi = np.where(near, -0.5 * np.log1p(-np.where(near, lost, 0.0)), xi)
        return (low, high, w, xi) if e <= et else (high, low, w, xi)

    def quadrature(self, level: int) -> ImpactQuadrature:
        """The average, with panels 2^level times shorter than for slow functions."""
        e, et = self.restitution, self.tangential_restitution
        y, missed, w, xi = self._nodes(level)
        chi = np.arctan2((et + e) * y * missed, et * y**2 - e * missed**2)
        return ImpactQuadrature(w if self.dimension == 2 else 2.0 * y * w, xi, chi, self.dimension)

    def beyond(self, p: NDArray[Any], lost: bool = False) -> NDArray[Any] | float:
        """What bounces that lose more than any node add to E[s^p], or to 1 - E[s^p] (``lost``).

        0 but where s reaches 0; what is lost is accurate relative to itself, at small p too.
        """
        if self._ends[0] > 0.0:
            return 0.0
        near, power = -FOLDS, -self.lowest_power  # y = e^near where e = 0
        if self.restitution > 0.0:
            near += math.log(0.5 * math.pi)  # sqrt(1 - y^2), and y dy = -that times its change
        above, fall = self.dimension - 1.0, p * (math.log(self._ends[1]) + near)
        if lost:
            gone = (p - power * np.expm1(fall)) / (p + power)
            return above / power * math.exp(power * near) * gone
        return above * np.exp(fall + power * near) / (p + power)

    def survival(self, level: int, rate: float) -> tuple[FloatArray, FloatArray]:
        """P(-ln s > u) is y^(d-1) where e < et, 1 - y^(d-1) where et < e, 1 up to the least loss.

        du = |et^2 - e^2| y dy/s^2.
        """
        # low speeds see the bulk of the scaling state, some e-folds wide, from the deepest loss
        y, missed, w, u = self._nodes(level, FOLDS + 8.0)
        if self.restitution <= self.tangential_restitution:
            chance = y ** (self.dimension - 1)
        else:
            chance = missed**2 if self.dimension == 3 else missed**2 / (1.0 + y)
        w = w * y * chance * self._ends[2] * np.exp(2.0 * u)
        if self.losses[0] > 0.0:
            first, whole = equal_panels(self.losses[0], _POINTS, _POINTS / max(rate, _POINTS))
            u, w = np.concatenate([first, u]), np.concatenate([whole, w])
        return u, w


@stored_class
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
        if not 1 <= w.size <= _MOST_SAMPLES or np.any(w < 0.0) or not abs(total - 1.0) <= 1e-9:
            refuse("weight", w, f"give 1 to {_MOST_SAMPLES} numbers, none negative, whose sum is 1")
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

    def level(self, rate: float, m: int) -> int:
        """Samples are summed as they are."""
        return 0

    def quadrature(self, level: int) -> ImpactQuadrature:
        """The samples."""
        loss, chi = 0.0 - np.log(self.ratio), np.arccos(self.cosine)
        return ImpactQuadrature(np.array(self.weight), loss, chi, self.dimension)

    def beyond(self, p: NDArray[Any], lost: bool = False) -> NDArray[Any] | float:
        """Nothing is left out."""
        return 0.0

    def survival(self, level: int, rate: float) -> tuple[FloatArray, FloatArray]:
        """Gauss points on equal cells, exact for polynomials: the chance falls in steps."""
        q = self.quadrature(0)
        # the weights are interpolatory, of half the order of Gauss weights
        largest = self.losses[1]
        count = math.ceil(4.0 * largest * max(rate / _POINTS, 1.0))
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


class Collision:
    """A weighted sum of bounces, ``bounces`` with the chance of each, which sum to 1; no medium."""

    bounces: tuple[tuple[float, Bounce], ...]

    @cached_property
    def loss_ends(self) -> tuple[float, ...]:
        """The least and the largest -ln s of each part of the law: its density steps there."""
        return tuple(loss for _, part in self.bounces for loss in part.losses)

    @cached_property
    def is_elastic(self) -> bool:
        """Whether every bounce keeps the speed."""
        return not any(self.loss_ends)

    @property
    def least_loss(self) -> float:
        """The smallest -ln s that occurs: 0 for smooth scatterers, below 0 if energy is gained."""
        return min(self.loss_ends)

    @property
    def largest_loss(self) -> float:
        """The largest -ln s that occurs: -ln |e| for smooth scatterers, infinite at e = 0."""
        return max(self.loss_ends)

    @property
    def least_ratio(self) -> float:
        """The smallest speed ratio s: |e| for smooth scatterers; 0 where s comes close to 0."""
        return math.exp(-self.largest_loss)

    @property
    def has_atoms(self) -> bool:
        """Whether s takes single values, each with a chance of its own: samples, or et = e."""
        return any(part.has_atoms for _, part in self.bounces)

    @property
    def disk_restitutions(self) -> tuple[float, ...]:
        """The effective restitutions of the disks or spheres of which the law is made."""
        return tuple(p.restitution for _, p in self.bounces if isinstance(p, DiskBounce))

    @property
    def throws_back(self) -> bool:
        """Whether samples throw some of the tracers straight back."""
        samples = [part for _, part in self.bounces if isinstance(part, SampledBounce)]
        return any(min(part.cosine) < -1.0 + 1e-9 for part in samples)

    @property
    def reaches_rest(self) -> bool:
        """Whether bounces leave as little of the speed as one likes."""
        return math.isinf(self.largest_loss)

    @property
    def tail_exponent(self) -> float:
        """b where E[s^p] tends to b/p at large p: (d-1)/(1-e^2) for smooth disks and spheres.

        0 where E[s^p] falls faster than any power, infinite or NaN where it falls more slowly.
        """
        return sum(share * part.tail_exponent for share, part in self.bounces)

    # -- averages of one collision ----------------------------------------------------------------

    @cached_property
    def quadrature(self) -> ImpactQuadrature:
        """The average over the impact parameter as a weighted sum, for slow functions of ln s."""
        return self.quadrature_for(0.0)

    def quadrature_for(self, z: ArrayLike, m: int = 0) -> ImpactQuadrature:
        """The same for functions that vary as fast as s^z cos(m chi), for any z of such a size."""
        rate = float(np.abs(z).max(initial=0.0))
        level = max(part.level(rate, m) for _, part in self.bounces)
        make = _quadrature if level <= _LEVELS_KEPT else _quadrature.__wrapped__
        return make(self.bounces, level)

    def _beyond(self, p: NDArray[Any], lost: bool = False) -> NDArray[Any]:
        """What the nodes leave out of E[s^p], or of 1 - E[s^p]."""
        return np.asarray(sum(share * part.beyond(p, lost) for share, part in self.bounces))

    def survival_for(self, rate: float) -> tuple[FloatArray, FloatArray]:
        """u and w, (n,) each: int_0^inf P(-ln s > u) f(u) du = sum w f, f as fast as e^(rate u)."""
        level = max(part.level(rate, 0) for _, part in self.bounces)
        found = [(share, *part.survival(level, rate)) for share, part in self.bounces]
        weight = [share * each for share, _, each in found]
        return np.concatenate([u for _, u, _ in found]), np.concatenate(weight)

    def lost(self, z: NDArray[Any], m: int = 0) -> NDArray[Any]:
        """1 - E[s^z cos(m chi)] of one collision, shape of z."""
        q = self.quadrature_for(z, abs(m))
        lost = q.losses(z)
        if m == 0:
            return np.asarray(lost @ q.weight + self._beyond(z, lost=True))
        # 1 - s^z cos = (1 - s^z) + s^z (1 - cos): no cancellation
        gone = q.harmonic_loss(m)
        rate = (lost + (1.0 - lost) * gone) @ q.weight
        # bounces beyond the nodes deflect by pi/2, as the first node does
        return np.asarray(rate if m % 2 else rate - self._beyond(z) * (1.0 - gone[0]))

    @cached_property
    def mean_log_loss(self) -> float:
        """kappa = E[-ln s]: 1 - e arccos(e)/sqrt(1-e^2) for smooth disks; 0 if elastic."""
        return float(self.quadrature.weight @ self.quadrature.log_loss)

    @cached_property
    def mean_cosine(self) -> float:
        """<cos chi>: for smooth disks 1/2 at e = 0, -1/3 at e = 1 (backwards on average)."""
        return float(self.quadrature.weight @ self.quadrature.cosine)


@lru_cache(maxsize=64)
def _quadrature(bounces: tuple[tuple[float, Bounce], ...], level: int) -> ImpactQuadrature:
    """The weighted sum of the averages over these bounces."""
    found = [(share, bounce.quadrature(level)) for share, bounce in bounces]
    rows = [(share * q.weight, q.log_loss, q.deflection) for share, q in found]
    weight, loss, chi = (np.concatenate(row) for row in zip(*rows, strict=True))
    return ImpactQuadrature(weight, loss, chi, found[0][1].dimension)
