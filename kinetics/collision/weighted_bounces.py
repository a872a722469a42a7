"""A collision as a weighted sum of bounces, and its averages; the base of every collision law.

s is the ratio of the speeds after and before, chi the deflection, m an angular harmonic, e and et
the normal and the tangential restitution. Begin with :meth:`WeightedBounces.lost`, 1 - E[s^z cos(m
chi)] of one collision.
"""

from __future__ import annotations

import math
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import ArrayLike

from kinetics.collision.bounce import Bounce, DiskBounce, SampledBounce
from kinetics.collision.quadrature import ImpactQuadrature, Numbers
from kinetics.numerics import FloatArray

#: How often panels are halved in quadratures that are kept for the next question: they have up to
#: 60,000 points. Chosen.
MAX_LEVEL_KEPT = 6
#: How many quadratures are kept, of all laws. Chosen: it bounds memory and changes no result.
MAX_QUADRATURES_KEPT = 64
#: Largest 1 + cos(chi) of samples that are thrown straight back. Chosen: angles within 4e-5 of pi;
#: far more than rounding of a cosine.
STRAIGHT_BACK_WITHIN = 1e-9


class WeightedBounces:
    """A weighted sum of bounces, ``bounces`` with the chance of each, which sum to 1; no medium."""

    bounces: tuple[tuple[float, Bounce], ...]

    # -- what kind of collision it is -------------------------------------------------------------

    @cached_property
    def loss_ends(self) -> tuple[float, ...]:
        """The least and the largest -ln s of each bounce: the density of -ln s steps there."""
        ends: list[float] = []
        for _, bounce in self.bounces:
            ends.extend(bounce.losses)
        return tuple(ends)

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
        return any(bounce.has_atoms for _, bounce in self.bounces)

    @property
    def disk_restitutions(self) -> tuple[float, ...]:
        """The effective restitutions of the disks or spheres of which the law is made."""
        disks = [bounce for _, bounce in self.bounces if isinstance(bounce, DiskBounce)]
        return tuple(disk.restitution for disk in disks)

    @property
    def throws_back(self) -> bool:
        """Whether samples throw some of the tracers straight back."""
        for _, bounce in self.bounces:
            if (
                isinstance(bounce, SampledBounce)
                and min(bounce.cosine) < STRAIGHT_BACK_WITHIN - 1.0
            ):
                return True
        return False

    @property
    def reaches_rest(self) -> bool:
        """Whether bounces leave as little of the speed as one likes."""
        return math.isinf(self.largest_loss)

    @property
    def tail_exponent(self) -> float:
        """b where E[s^p] tends to b/p at large p: (d-1)/(1-e^2) for smooth disks and spheres.

        0 where E[s^p] falls faster than any power, infinite or NaN where it falls more slowly.
        """
        return sum(share * bounce.tail_exponent for share, bounce in self.bounces)

    # -- averages of one collision ----------------------------------------------------------------

    @cached_property
    def quadrature(self) -> ImpactQuadrature:
        """The average over the impact parameter as a weighted sum, for slow functions of ln s."""
        return self.quadrature_for(0.0)

    def quadrature_for(self, z: ArrayLike, m: int = 0) -> ImpactQuadrature:
        """Return the average for functions that vary as fast as s^z cos(m chi).

        Parameters
        ----------
        z : any numbers of the size of the powers, real or complex
        m : the harmonic, not negative

        Raises
        ------
        InputError
            A power is so large that it would need too many points.
        """
        level = self._level(float(np.abs(z).max(initial=0.0)), m)
        if level <= MAX_LEVEL_KEPT:
            return _kept_quadrature(self.bounces, level)
        return _sum_quadratures(self.bounces, level)

    def _level(self, rate: float, m: int) -> int:
        """Return how often panels are halved for s^z cos(m chi), |z| up to rate."""
        return max(bounce.level(rate, m) for _, bounce in self.bounces)

    def survival_for(self, rate: float) -> tuple[FloatArray, FloatArray]:
        """Return points u and weights w: int_0^inf P(-ln s > u) f(u) du = sum w f(u), (n,) each.

        Parameters
        ----------
        rate : f is as fast as e^(rate u)
        """
        level = self._level(rate, 0)
        points = []
        weights = []
        for share, bounce in self.bounces:
            u, weight = bounce.survival(level, rate)
            points.append(u)
            weights.append(share * weight)
        return np.concatenate(points), np.concatenate(weights)

    def lost(self, z: Numbers, m: int = 0) -> Numbers:
        """Return 1 - E[s^z cos(m chi)] of one collision, shape of z; in space of P_m(cos chi)."""
        q = self.quadrature_for(z, abs(m))
        speed_loss = q.losses(z)
        if m == 0:
            return np.asarray(speed_loss @ q.weight + self._loss_beyond(z))
        # 1 - s^z cos = (1 - s^z) + s^z (1 - cos): no cancellation
        turned = q.harmonic_loss(m)
        rate = (speed_loss + (1.0 - speed_loss) * turned) @ q.weight
        if m % 2:
            return np.asarray(rate)  # bounces beyond the nodes deflect by pi/2: their cosine is 0
        return np.asarray(rate - self._ratio_power_beyond(z) * (1.0 - turned[0]))

    def _loss_beyond(self, z: Numbers) -> Numbers | float:
        """Return what the nodes leave out of 1 - E[s^z], shape of z or a number."""
        if not self.reaches_rest:
            return 0.0
        total = np.zeros_like(z)
        for share, bounce in self.bounces:
            total = total + share * bounce.loss_beyond(z)
        return total

    def _ratio_power_beyond(self, z: Numbers) -> Numbers | float:
        """Return what the nodes leave out of E[s^z], shape of z or a number."""
        if not self.reaches_rest:
            return 0.0
        total = np.zeros_like(z)
        for share, bounce in self.bounces:
            total = total + share * bounce.ratio_power_beyond(z)
        return total

    @cached_property
    def mean_log_loss(self) -> float:
        """kappa = E[-ln s]: 1 - e arccos(e)/sqrt(1-e^2) for smooth disks; 0 if elastic."""
        return float(self.quadrature.weight @ self.quadrature.log_loss)

    @cached_property
    def mean_cosine(self) -> float:
        """<cos chi>: for smooth disks 1/2 at e = 0, -1/3 at e = 1 (backwards on average)."""
        return float(self.quadrature.weight @ self.quadrature.cosine)


def _sum_quadratures(bounces: tuple[tuple[float, Bounce], ...], level: int) -> ImpactQuadrature:
    """Return the weighted sum of the averages over these bounces."""
    weights = []
    losses = []
    deflections = []
    for share, bounce in bounces:
        q = bounce.quadrature(level)
        weights.append(share * q.weight)
        losses.append(q.log_loss)
        deflections.append(q.deflection)
    return ImpactQuadrature(
        np.concatenate(weights), np.concatenate(losses), np.concatenate(deflections), q.dimension
    )


_kept_quadrature = lru_cache(maxsize=MAX_QUADRATURES_KEPT)(_sum_quadratures)
"""The same, without computing those again that were used of late."""
