"""The bounce off a fixed disk or sphere, averaged over a uniform impact parameter.

A tracer meets a disk (or a sphere) with impact parameter ``y d``: y is uniform on [0, 1] in the
plane, and y^2 is in space. The normal component of its velocity is multiplied by -e, the
tangential one by et. In units of its speed before the bounce (paper, label ``vchange``, where
et = 1) it leaves with

    speed                 s(y)     = sqrt(e^2 + (et^2 - e^2) y^2)
    parallel component    s cos(chi) = -e + (e + et) y^2

s(y) has branch points at y^2 = e^2/(e^2 - et^2), near the interval where e and et differ much.
In another variable u they leave:

    e < et :  y = sinh(u)/sinh(U),  s = e cosh(u),   cosh(U) = et/e
    et < e :  y = tanh(u)/tanh(U),  s = e/cosh(u),   cosh(U) = e/et
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinetics.collision.quadrature import ImpactQuadrature, Survival
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import equal_panels, gauss_legendre

# Gauss-Legendre points on each panel in the variable u. They are exact to rounding for
# s^z cos(m chi) while (|z| + m) times the length of a panel is below RESOLVED: measured again by
# tests/kinetics/measurements/collision.py.
_POINTS = 20
RESOLVED = 30.0
_DEEPEST = 40.0  # where s reaches 0: what lies beyond this in -ln s weighs e^-40 = 4e-18
_CLOSE = 0.5  # |z| below which 1 - E[s^z] is taken from the quadrature, which loses no digit
_BULK = 8.0  # and in ln v t, all that counts of the scaling state
_STEEP = 5.0  # U from which exponentials of U are taken apart: either form holds from 1 to 300


@dataclass(frozen=True)
class DiskBounce:
    """The bounce off a disk (dimension 2) or a sphere (3); e and et from 0 to 1, not both 0."""

    restitution: float
    tangential_restitution: float = 1.0
    dimension: int = 2

    @property
    def least_loss(self) -> float:
        """-ln of the largest speed ratio."""
        return 0.0 - math.log(max(self.restitution, self.tangential_restitution))

    @property
    def largest_loss(self) -> float:
        """-ln of the smallest speed ratio."""
        least = min(self.restitution, self.tangential_restitution)
        return 0.0 - math.log(least) if least > 0.0 else math.inf

    @property
    def lowest_power(self) -> float:
        """-(d - 1) at e = 0, where s = et y; -2 at et = 0, where s = e sqrt(1 - y^2)."""
        if self.restitution == 0.0:
            return 1.0 - self.dimension
        return -2.0 if self.tangential_restitution == 0.0 else -math.inf

    @property
    def tail_exponent(self) -> float:
        """From y near 1 where et = 1, and near 0 where e = 1."""
        e, et = self.restitution, self.tangential_restitution
        if et == 1.0:
            return (self.dimension - 1.0) / ((1.0 - e) * (1.0 + e)) if e < 1.0 else math.inf
        if e < 1.0:
            return 0.0
        return 2.0 / ((1.0 - et) * (1.0 + et)) if self.dimension == 3 else math.nan

    @property
    def _top(self) -> float:
        """U, for any e and et."""
        e, et = self.restitution, self.tangential_restitution
        least, most = min(e, et), max(e, et)
        if least == 0.0:
            return _DEEPEST
        if least < 1e-8 * most:  # the next term, (least/most)^2/4, is below rounding
            return math.log(2.0) - math.log(least) + math.log(most)
        return math.asinh(math.sqrt((most - least) * (most + least)) / least)

    def turns(self, rate: float, m: int) -> float:
        """|z| ln s changes by less than u, and m chi by less than pi m."""
        top = self._top
        return rate * min(1.0, top * math.tanh(top)) + 3.0 * m

    def quadrature(self, level: int = 0) -> ImpactQuadrature:
        """The average in u, with panels that are at most 2^-level long."""
        return self.average(self._longest(level))

    def average(self, longest: float) -> ImpactQuadrature:
        """The average with panels in u that are no longer than this."""
        at = _nodes(self.restitution, self.tangential_restitution, self._top, longest)
        weight = at.weight if self.dimension == 2 else 2.0 * at.y * at.weight
        xi = at.log_loss
        return ImpactQuadrature(weight, xi, np.exp(-xi), at.parallel, self.dimension)

    def _longest(self, level: int) -> float:
        top = self._top
        return (min(1.0, top) if top > 0.0 else 1.0) * 2.0**-level

    def survival(self, level: int) -> Survival:
        """P(xi > u) is y^(d-1) where e < et and 1 - y^(d-1) where et < e; du = |et^2-e^2| y dy/s^2.

        Up to the least loss it is 1.
        """
        e, et, d = self.restitution, self.tangential_restitution, self.dimension
        # where s reaches 0, low speeds see the bulk of the scaling state from e^-40 of it
        top = self._top + (_BULK if math.isfinite(self.lowest_power) else 0.0)
        at = _nodes(e, et, top, self._longest(level))
        s = np.exp(-at.log_loss)
        with np.errstate(divide="ignore"):
            if e < et:
                # y (et^2 - e^2) y = s^2 - e^2
                weight = at.weight * at.y ** (d - 2) * (s**2 - e**2)
                log_weight = np.log(np.maximum(weight, 0.0))
            else:
                chance = at.missed if d == 3 else at.missed / (1.0 + at.y)
                log_weight = np.log(at.weight * at.y * chance * (e - et) * (e + et))
        log_weight = log_weight - 3.0 * np.log(s)
        xi = at.log_loss
        if self.least_loss > 0.0:
            u, w = equal_panels(self.least_loss, _POINTS, self._longest(level))
            log_weight = np.concatenate([np.log(w) + u, log_weight])
            xi = np.concatenate([u, xi])
        return Survival(log_weight, xi)

    def cells(self, spacing: float, points: int) -> tuple[ImpactQuadrature, NDArray[np.int64]]:
        """Gauss-Legendre points in y: s is smooth in y, its density in -ln s is not.

        Where s reaches 0, cells end at s = e^-40 of its largest; the last one holds all below.
        """
        e, et = self.restitution, self.tangential_restitution
        least, most = min(e, et), max(e, et)
        first, last = self.least_loss, self.largest_loss
        count = max(1, math.ceil(min(_DEEPEST + first, last) / spacing))
        edge = np.clip(np.arange(count + 1) * spacing, first, last)
        # z = y where e < et, and 1 - y where et < e: it is 0 where s is least, and not rounded
        rise = np.exp(-2.0 * edge) * -np.expm1(2.0 * np.minimum(0.0, edge - last))
        square = (most - least) * (most + least)
        z_edge = self._from_deepest(rise / square if square > 0.0 else np.ones_like(edge))
        z_edge[-1] = 0.0
        node, weight = gauss_legendre(points)
        width = (z_edge[:-1] - z_edge[1:])[:, None]
        z = (z_edge[1:, None] + width * node).ravel()
        w = (width * weight).ravel()
        y = z if e < et else 1.0 - z
        above = z**2 if e < et else z * (2.0 - z)  # (s^2 - least^2)/(most^2 - least^2)
        fall = square * (1.0 - z) * (1.0 + z if e < et else 1.0 - z)  # most^2 - s^2
        direct = -0.5 * np.log(least * least + square * above)
        xi = _log_loss((1.0 - most) * (1.0 + most) + fall, direct)
        parallel = -e + (e + et) * y * y
        weight = w if self.dimension == 2 else 2.0 * y * w
        cell = np.repeat(np.arange(count), points)
        kept = weight > 0.0  # cells below the least loss are empty
        q = ImpactQuadrature(
            weight[kept], xi[kept], np.exp(-xi[kept]), parallel[kept], self.dimension
        )
        return q, cell[kept]

    def _from_deepest(self, share: FloatArray) -> FloatArray:
        """y (e < et) or 1 - y (et < e) where (s^2 - least^2)/(most^2 - least^2) is this."""
        if self.restitution < self.tangential_restitution:
            return np.sqrt(share)
        share = np.where(share > 1.0 - 1e-12, 1.0, share)  # y = 0, where 1 - y is not rounded
        return share / (1.0 + np.sqrt(1.0 - share))

    def chance_below(self, ratio: FloatArray) -> FloatArray:
        """y^(d-1) where s(y) is this ratio and e < et, and 1 - y^(d-1) where et < e."""
        e, et = self.restitution, self.tangential_restitution
        square = ratio**2 - e * e  # (et^2 - e^2) y^2
        if e == et:
            return np.where(square > 0.0, 1.0, 0.0)
        share = np.clip(square / (et * et - e * e), 0.0, 1.0)
        within = np.sqrt(share) if self.dimension == 2 else share
        return within if e < et else 1.0 - within

    def closed_decay(self, z: NDArray[Any]) -> NDArray[Any] | None:
        """1 - et^z (d-1)/(z+d-1) at e = 0; at et = 0 with Beta functions, not close to z = 0."""
        e, et, d = self.restitution, self.tangential_restitution, self.dimension
        above = d - 1.0
        if e == 0.0:
            gone = np.expm1(z * math.log(et)) if et < 1.0 else 0.0
            return np.asarray((z - above * gone) / (above + z))
        if et > 0.0 or z.size == 0 or float(np.abs(z).min()) < _CLOSE:
            return None
        from scipy.special import loggamma

        first, half = 1.0 + 0.5 * z, 0.5 * above
        log_power = loggamma(first) - loggamma(first + half) + math.lgamma(1.0 + half)
        return np.asarray(1.0 - np.exp(log_power + z * math.log(e)))

    def beyond(self, p: NDArray[Any]) -> NDArray[Any] | float:
        """What bounces beyond the nodes add to E[s^p]: 0 but where s reaches 0."""
        e, et, d = self.restitution, self.tangential_restitution, self.dimension
        if e == 0.0:  # s = et y, down to y = e^-top
            above = d - 1.0
            return above * np.exp(p * math.log(et) - self._top * (p + above)) / (p + above)
        if et == 0.0:  # s = 2 e e^-u and dy = 4 e^-2u du
            log_ratio = math.log(2.0) + math.log(e) - self._top
            least = 4.0 * math.exp(-2.0 * self._top)
            return (d - 1.0) * least * np.exp(p * log_ratio) / (p + 2.0)
        return 0.0


class _Nodes(NamedTuple):
    """Nodes of an average over a uniform y; arrays of shape (n_nodes,)."""

    y: FloatArray
    weight: FloatArray
    log_loss: FloatArray
    parallel: FloatArray
    missed: FloatArray  # 1 - y^2; relative to itself where et < e


def _nodes(e: float, et: float, top: float, longest: float) -> _Nodes:
    """The nodes in u up to ``top``, in panels no longer than ``longest``.

    ln s is taken from 1 - s^2, a sum of positive terms, where s is near 1, so that -ln s keeps
    its digits as e and et tend to 1.
    """
    if e == et:
        y, w = equal_panels(1.0, _POINTS, longest)
        xi = np.full_like(y, 0.0 - math.log(e))
        return _Nodes(y, w, xi, (e + et) * y * y - e, 1.0 - y * y)
    if e == 0.0:
        xi, w = equal_panels(top, _POINTS, longest)
        y = np.exp(-xi)
        return _Nodes(y, w * y, xi - math.log(et), et * y * y, 1.0 - y * y)
    u, w = equal_panels(top, _POINTS, longest)
    rest = u[::-1]  # U - u without cancellation: the nodes are symmetric
    return (_rising if e < et else _falling)(e, et, top, (u, w, rest))


def _rising(e: float, et: float, top: float, panels: tuple[FloatArray, ...]) -> _Nodes:
    """For e < et, where s rises with y from e to et."""
    u, w, rest = panels
    if top > _STEEP:
        # ratios of cosh and sinh of u to those of U, which would overflow for the smallest e
        decay, small, least = np.exp(-rest), np.exp(-2.0 * u), math.exp(-2.0 * top)
        xi = rest - np.log1p(small) + math.log1p(least) - math.log(et)
        y = decay * (1.0 - small) / (1.0 - least)
        weight = w * decay * (1.0 + small) / (1.0 - least)
        return _Nodes(y, weight, xi, -e + (e + et) * y * y, 1.0 - y * y)
    b = math.sqrt((et - e) * (et + e))
    fall = e * e * np.sinh(rest) * np.sinh(top + u)  # et^2 - s^2
    lost = fall + (1.0 - et) * (1.0 + et)  # 1 - s^2
    y = (e / b) * np.sinh(u)
    # near y = 1 this is et - (e + et)(1 - y^2), which loses nothing
    parallel = np.where(lost < 0.5, et - fall / (et - e), -e + (e + et) * y**2)
    xi = _log_loss(lost, -np.log(e * np.cosh(u)))
    return _Nodes(y, w * (e / b) * np.cosh(u), xi, parallel, 1.0 - y * y)


def _falling(e: float, et: float, top: float, panels: tuple[FloatArray, ...]) -> _Nodes:
    """For et < e, where s falls with y from e to et; at et = 0, top stands for infinity."""
    u, w, rest = panels
    small, end = np.exp(-2.0 * u), math.tanh(top)
    y = np.tanh(u) / end
    inverse_square = 4.0 * small / (1.0 + small) ** 2  # 1/cosh(u)^2
    missed = inverse_square
    if et > 0.0:
        missed = missed * np.expm1(-2.0 * rest) * np.expm1(-2.0 * (top + u))
        missed = missed / math.expm1(-2.0 * top) ** 2
    lost = (1.0 - e) * (1.0 + e) + e * e * np.tanh(u) ** 2  # 1 - s^2
    xi = _log_loss(lost, -math.log(e) + u + np.log1p(small) - math.log(2.0))
    parallel = np.where(y < 0.7, -e + (e + et) * y**2, et - (e + et) * missed)
    return _Nodes(y, w * inverse_square / end, xi, parallel, missed)


def _log_loss(lost: FloatArray, direct: FloatArray) -> FloatArray:
    """-ln s from 1 - s^2 where that is small, else as it is given."""
    near_one = lost < 0.5
    return np.where(near_one, -0.5 * np.log1p(-np.where(near_one, lost, 0.0)), direct)
