"""The bounce: how speed ratio and deflection are spread over the impact parameter, or samples.

A tracer meets a disk (or a sphere) with impact parameter ``y d``: y is uniform on [0, 1] in the
plane, and y^2 is in space; d is the contact distance, e and et the normal and the tangential
restitution, s the speed after over that before, and chi the deflection. The normal component of its
velocity, sqrt(1 - y^2) of it, is multiplied by -e, the tangential one, y, by et. In units of its
speed before the bounce (paper, label ``vchange``, where et = 1) it leaves with

    s^2 = e^2 (1 - y^2) + et^2 y^2,   s cos(chi) = et y^2 - e (1 - y^2)

Begin with :class:`DiskBounce`; :class:`SampledBounce` has the same methods.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial.legendre import legvander
from numpy.typing import ArrayLike

from kinetics.collision.quadrature import ImpactQuadrature, Numbers
from kinetics.errors import InputError
from kinetics.numerics import FOLDS, FloatArray
from kinetics.numerics.gauss import equal_panels, gauss_legendre
from kinetics.results.record import stored_class
from kinetics.validation import finite_line, refuse

#: Gauss-Legendre points on each panel. Measured (tests/kinetics/collision/test_law.py has the
#: largest powers): they are exact to 1e-14 for s^z cos(m chi) while this varies by less than
#: `RADIANS_PER_POINT` on it, and for exponentials that fall by one e-fold a point.
POINTS_ON_PANEL = 20
#: Change of the phase of s^z cos(m chi), in radians from point to point, that a panel resolves.
#: Measured with `POINTS_ON_PANEL`; at half and at twice averages of s^p move by 1e-14 (p up to 30).
RADIANS_PER_POINT = 1.5
#: Most points of a quadrature. Chosen: about a gigabyte of exponentials.
MAX_POINTS = 7e6
#: Depth in -ln y to which panels reach where s = et y may be 0; more than is used. Chosen.
DEPTH_OF_FULL_STOP = 70.0
#: Smallest length of the panels, where s is constant: any will do. Chosen.
MIN_PANEL_LENGTH = 1e-3
#: How much deeper than `FOLDS` the survival of low speeds is known, in -ln s. Chosen: low speeds
#: see the bulk of the scaling state, some e-folds wide, from the deepest loss.
SURVIVAL_BEYOND_FOLDS = 8.0
#: Most samples of a law. Chosen: each costs some kilobytes on every panel.
MAX_SAMPLES = 20_000
#: Largest difference from 1 of the sum of weights that a user gives. Chosen: more than the rounding
#: of a sum of many.
MAX_ERROR_OF_WEIGHTS = 1e-9
#: Largest excess over 1 of a cosine that counts as rounding. Chosen: some thousand roundings.
ROUNDING_OF_COSINE = 1e-12


@dataclass(frozen=True, eq=False)
class ImpactNodes:
    """Nodes of a quadrature over y uniform on [0, 1]; arrays of shape (n_nodes,).

    Parameters
    ----------
    y : the impact parameter, the tangential share of the velocity
    normal : the normal one, sqrt(1 - y^2), which keeps its digits
    weight : sums to 1
    log_loss : -ln s, which keeps its digits
    """

    y: FloatArray
    normal: FloatArray
    weight: FloatArray
    log_loss: FloatArray


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

    # -- what kind of bounce it is ----------------------------------------------------------------

    @cached_property
    def least_ratio(self) -> float:
        """The smallest speed ratio s."""
        return min(abs(self.restitution), self.tangential_restitution)

    @cached_property
    def largest_ratio(self) -> float:
        """The largest speed ratio s."""
        return max(abs(self.restitution), self.tangential_restitution)

    @cached_property
    def _spread(self) -> float:
        """The difference of the squares of the largest and the least speed ratio."""
        least = self.least_ratio
        largest = self.largest_ratio
        return (largest - least) * (largest + least)

    @property
    def is_faster_at_grazing(self) -> bool:
        """Whether s rises with y, from e head-on to et, or is constant."""
        return self.restitution <= self.tangential_restitution

    @property
    def losses(self) -> tuple[float, float]:
        """The least and the largest -ln s."""
        least_loss = 0.0 - math.log(self.largest_ratio)
        if self.least_ratio == 0.0:
            return least_loss, math.inf
        return least_loss, -math.log(self.least_ratio)

    @property
    def lowest_power(self) -> float:
        """-(d - 1) at e = 0, where s = et y; -2 at et = 0, where s = e sqrt(1 - y^2)."""
        if self.restitution == 0.0:
            return 1.0 - self.dimension
        return -2.0 if self.tangential_restitution == 0.0 else -math.inf

    @property
    def tail_exponent(self) -> float:
        """b where E[s^p] tends to b/p; NaN (not known) at rough scatterers with e = 1."""
        e = self.restitution
        is_smooth = self.tangential_restitution == 1.0
        if e == 1.0:
            return math.inf if is_smooth else math.nan
        if is_smooth:
            return (self.dimension - 1.0) / ((1.0 - e) * (1.0 + e))
        return 0.0

    @property
    def has_atoms(self) -> bool:
        """Whether s takes one value only."""
        return self.restitution == self.tangential_restitution

    # -- averages ---------------------------------------------------------------------------------

    @cached_property
    def _map_length(self) -> float:
        """U of :meth:`_nodes`: s has its branch points at the distance pi/2 of u = 0 then."""
        if self.least_ratio == 0.0:
            return DEPTH_OF_FULL_STOP
        # asinh(sqrt(spread)/least), which does not overflow
        length = math.log(self.largest_ratio + math.sqrt(self._spread)) - math.log(self.least_ratio)
        return max(length, MIN_PANEL_LENGTH)

    def level(self, rate: float, m: int) -> int:
        """Return how often panels are halved for functions as fast as s^z cos(m chi).

        Parameters
        ----------
        rate : |z| at most
        m : the harmonic, not negative

        Raises
        ------
        InputError
            The quadrature would need too many points.
        """
        length = self._map_length
        steepness = rate * min(1.0, length * math.tanh(length))
        if not self.is_faster_at_grazing:
            steepness *= 2.0  # in the sine of the map, both ends of s are steep
        radians = steepness + 3.0 * m
        finer = max(1.0, radians / (RADIANS_PER_POINT * POINTS_ON_PANEL))
        used_length = FOLDS if self.least_ratio == 0.0 else length
        if not finer * POINTS_ON_PANEL * max(1.0, used_length) <= MAX_POINTS:
            raise InputError(f"p: got a size of {rate:.3g}; E[s^p] needs too many points there")
        return math.ceil(math.log2(finer))

    def _nodes(self, level: int, deepest: float = FOLDS) -> ImpactNodes:
        """Return Gauss points on panels in u, 2^-level long, with t = sinh(u)/sinh(U).

        Where s rises with y, y is t; elsewhere sqrt(1 - y^2) is sin(pi t/2).

        Parameters
        ----------
        level : how often panels are halved
        deepest : U - u to which they reach where s may be 0
        """
        top = self._map_length
        length = deepest if self.least_ratio == 0.0 else top
        points, step = equal_panels(length, POINTS_ON_PANEL, min(1.0, top) * 2.0**-level)
        below_top = points[::-1]  # U - u without cancellation: nodes are symmetric
        u = top - length + points
        scale = -math.expm1(-2.0 * top)
        small = np.exp(-2.0 * u)
        t = np.exp(-below_top) * -np.expm1(-2.0 * u) / scale
        one_minus_t = -np.expm1(-below_top) * (1.0 + np.exp(-top - u)) / scale
        weight = step * np.exp(-below_top) * (1.0 + small) / scale  # cosh(u)/sinh(U) du
        if self.is_faster_at_grazing:
            y = t
            normal = np.sqrt(one_minus_t * (1.0 + t))
            log_loss = self._log_loss(faster=y, slower=normal)
        else:
            y = np.sin(0.5 * math.pi * one_minus_t)
            normal = np.sin(0.5 * math.pi * t)
            weight = 0.5 * math.pi * weight * normal
            log_loss = self._log_loss(faster=normal, slower=y)
        return ImpactNodes(y, normal, weight, log_loss)

    def _log_loss(self, faster: FloatArray, slower: FloatArray) -> FloatArray:
        """Return -ln s from the components with the larger and the smaller restitution."""
        largest = self.largest_ratio
        log_loss = -np.log(np.hypot(self.least_ratio * slower, largest * faster))
        # 1 - s^2: keeps digits near s = 1
        energy_loss = (1.0 - largest) * (1.0 + largest) + self._spread * slower**2
        is_small = energy_loss < 0.5
        small_loss = -0.5 * np.log1p(-np.where(is_small, energy_loss, 0.0))
        return np.where(is_small, small_loss, log_loss)

    def quadrature(self, level: int) -> ImpactQuadrature:
        """Return the average, with panels 2^level times shorter than for slow functions."""
        e = self.restitution
        et = self.tangential_restitution
        nodes = self._nodes(level)
        sine = (et + e) * nodes.y * nodes.normal
        cosine = et * nodes.y**2 - e * nodes.normal**2
        weight = nodes.weight
        if self.dimension == 3:
            weight = 2.0 * nodes.y * weight
        chi = np.arctan2(sine, cosine)  # of s sin(chi) and s cos(chi)
        return ImpactQuadrature(weight, nodes.log_loss, chi, self.dimension)

    def ratio_power_beyond(self, p: Numbers) -> Numbers:
        """Return what bounces that lose more than any node add to E[s^p]; 0 if s is never 0."""
        if self.least_ratio > 0.0:
            return np.zeros_like(p)
        power = -self.lowest_power
        exponent = p * self._log_ratio_at_end + power * self._log_end
        return (self.dimension - 1.0) * np.exp(exponent) / (p + power)

    def loss_beyond(self, p: Numbers) -> Numbers:
        """Return what they add to 1 - E[s^p], accurate relative to itself, at small p too."""
        if self.least_ratio > 0.0:
            return np.zeros_like(p)
        power = -self.lowest_power
        share = (self.dimension - 1.0) / power * math.exp(power * self._log_end)
        return share * ((p - power * np.expm1(p * self._log_ratio_at_end)) / (p + power))

    @property
    def _log_end(self) -> float:
        """ln y at the end of all nodes where e = 0; where et = 0, ln sqrt(1 - y^2)."""
        if self.restitution == 0.0:
            return -FOLDS
        return -FOLDS + math.log(0.5 * math.pi)

    @property
    def _log_ratio_at_end(self) -> float:
        """ln s there."""
        return math.log(self.largest_ratio) + self._log_end

    def survival(self, level: int, rate: float) -> tuple[FloatArray, FloatArray]:
        """Return points u, and weights w, of int_0^inf P(-ln s > u) f(u) du = sum w f(u).

        Parameters
        ----------
        level : how often panels are halved, by :meth:`level`
        rate : f is as fast as e^(rate u)

        Notes
        -----
        P(-ln s > u) is y^(d-1) where e < et, 1 - y^(d-1) where et < e, 1 up to the least loss; and
        du = |et^2 - e^2| y dy/s^2.
        """
        nodes = self._nodes(level, FOLDS + SURVIVAL_BEYOND_FOLDS)
        if self.is_faster_at_grazing:
            probability = nodes.y ** (self.dimension - 1)
        elif self.dimension == 3:
            probability = nodes.normal**2
        else:
            probability = nodes.normal**2 / (1.0 + nodes.y)
        u = nodes.log_loss
        weight = nodes.weight * nodes.y * probability * self._spread * np.exp(2.0 * u)
        least_loss, _ = self.losses
        if least_loss > 0.0:
            longest = POINTS_ON_PANEL / max(rate, POINTS_ON_PANEL)
            u_of_all, weight_of_all = equal_panels(least_loss, POINTS_ON_PANEL, longest)
            u = np.concatenate([u_of_all, u])
            weight = np.concatenate([weight_of_all, weight])
        return u, weight


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
        """Return the samples of non-zero weight, with weights that sum to 1 to rounding.

        Raises
        ------
        InputError
            They are no law.
        """
        w = finite_line("weight", weight)
        s = finite_line("ratio", ratio)
        c = finite_line("cosine", cosine)
        total = float(w.sum())
        is_normalised = abs(total - 1.0) <= MAX_ERROR_OF_WEIGHTS
        if not 1 <= w.size <= MAX_SAMPLES or np.any(w < 0.0) or not is_normalised:
            refuse("weight", w, f"give 1 to {MAX_SAMPLES} numbers, none negative, whose sum is 1")
        if s.size != w.size or np.any(s <= 0.0):
            refuse("ratio", s, f"it must be {w.size} numbers above 0, one for each weight")
        if c.size != w.size or np.any(np.abs(c) > 1.0 + ROUNDING_OF_COSINE):
            refuse("cosine", c, f"it must be {w.size} numbers from -1 to 1, one for each weight")
        is_counted = w > 0.0
        w = w[is_counted] / total
        s = s[is_counted]
        c = np.clip(c[is_counted], -1.0, 1.0)
        return cls(tuple(w.tolist()), tuple(s.tolist()), tuple(c.tolist()), dimension)

    @property
    def losses(self) -> tuple[float, float]:
        """The least and the largest -ln s; the least is negative where energy may be gained."""
        return 0.0 - math.log(max(self.ratio)), 0.0 - math.log(min(self.ratio))

    @property
    def tail_exponent(self) -> float:
        """0 where every bounce loses energy; infinite where a share of them loses none."""
        least_loss, _ = self.losses
        return 0.0 if least_loss > 0.0 else math.inf

    def level(self, rate: float, m: int) -> int:
        """Return 0: samples are summed as they are."""
        return 0

    def quadrature(self, level: int) -> ImpactQuadrature:
        """Return the samples."""
        log_loss = 0.0 - np.log(self.ratio)
        chi = np.arccos(self.cosine)
        return ImpactQuadrature(np.array(self.weight), log_loss, chi, self.dimension)

    def ratio_power_beyond(self, p: Numbers) -> Numbers:
        """Return 0: nothing is left out of E[s^p]."""
        return np.zeros_like(p)

    def loss_beyond(self, p: Numbers) -> Numbers:
        """Return 0: nothing is left out of 1 - E[s^p]."""
        return np.zeros_like(p)

    def survival(self, level: int, rate: float) -> tuple[FloatArray, FloatArray]:
        """Return Gauss points on equal cells, exact for polynomials: P(-ln s > u) falls in steps.

        Parameters and results are as of :meth:`DiskBounce.survival`.
        """
        q = self.quadrature(0)
        _, largest_loss = self.losses
        # the weights are interpolatory, of half the order of Gauss weights
        n_cells = math.ceil(4.0 * largest_loss * max(rate / POINTS_ON_PANEL, 1.0))
        width = largest_loss / n_cells
        cell = np.minimum((q.log_loss / width).astype(int), n_cells - 1)
        node, weight = gauss_legendre(POINTS_ON_PANEL)
        # a sample survives in its own cell up to its place there, from -1 to 1
        place = 2.0 * q.log_loss / width - 2.0 * cell - 1.0
        share = _integrals_of_lagrange(place, node, weight)
        in_own_cell = np.zeros((n_cells, POINTS_ON_PANEL))
        np.add.at(in_own_cell, cell, q.weight[:, None] * share)
        probability = np.bincount(cell, q.weight, n_cells)
        in_later_cells = probability.sum() - np.cumsum(probability)
        u = (np.arange(n_cells)[:, None] + node) * width
        survival = width * (in_own_cell + in_later_cells[:, None] * weight)
        return u.ravel(), survival.ravel()


def _integrals_of_lagrange(place: FloatArray, node: FloatArray, weight: FloatArray) -> FloatArray:
    """Return integrals of Lagrange's polynomials, over [0, 1], up to each place.

    Parameters
    ----------
    place : the upper ends, mapped to [-1, 1], shape (n,)
    node, weight : of the Gauss points on [0, 1], to which the polynomials belong

    Returns
    -------
    Shape (n, n_nodes); they are sums of integrals of Legendre's polynomials.
    """
    legendre = legvander(place, POINTS_ON_PANEL)
    legendre[:, 1:] -= np.insert(legendre[:, :-2], 0, -1.0, axis=1)
    at_nodes = legvander(2.0 * node - 1.0, POINTS_ON_PANEL - 1)
    return np.asarray(0.5 * legendre[:, 1:] @ at_nodes.T * weight)


Bounce = DiskBounce | SampledBounce
