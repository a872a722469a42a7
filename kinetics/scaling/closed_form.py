r"""The scaling solution in closed form: the moments, the cooling rate and the scaled VDF.

v is the speed, t the time, l the mean free path, s the speed ratio of a collision; c is the speed
over the thermal speed, F(c) the scaled density of the velocity, lambda(z) = 1 - E[s^z] and kappa =
E[-ln s]. Multiply the paper's scaled equation (label ``ifmu2``) by c^p and integrate: with Y = v
t/l, for all complex z,

    lambda(z) E[Y^(z+1)] = z E[Y^z],     E[Y] = 1/kappa.

E[Y^n] is a finite product. The other moments are in :mod:`kinetics.scaling.log_moments`, F(c), by
Mellin inversion, is in :mod:`kinetics.scaling.mellin`, and the numbers of collisions are in
:mod:`kinetics.scaling.late_times`. Begin with :class:`ScalingSolution`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kinetics.numerics import LARGEST_LOG, FloatArray
from kinetics.numerics.recurrence import MOST_ORDERS
from kinetics.results.record import stored_class
from kinetics.scaling import late_times
from kinetics.scaling.log_moments import log_moment, log_second_moment
from kinetics.scaling.mellin import MellinInversion
from kinetics.scaling.scaled_state import ScaledState
from kinetics.validation import check_positive, not_negative, refuse, whole_number


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class ScalingSolution(ScaledState):
    """The self-similar cooling state of the inelastic Lorentz gas, exactly.

    Parameters
    ----------
    restitution : e in [0, 1], or a :class:`kinetics.CollisionLaw`
    tangential_restitution, dimension, scatterers, number_density, diameter, density_order,
        mass_ratio : as in a Scene; the density counts as number_density * diameter^2

    Raises
    ------
    InputError
        (A ValueError.) An argument is out of range or not a number.

    Notes
    -----
    Lengths are in l, the mean path between collisions, which is ``law.mean_free_path``. If bounces
    are elastic, nothing cools: ``cooling_rate`` is 0, ``a2`` and ``moment`` are the limits e -> 1
    (all speeds are one), ``diffusion_slope`` is infinite, and :meth:`vdf` raises.

    Examples
    --------
    >>> exact = ScalingSolution(0.0)
    >>> bool(abs(exact.cooling_rate - 2**0.5) < 1e-14), bool(abs(exact.a2 - 2) < 1e-14)
    (True, True)
    """

    _attributes = MappingProxyType({"status": "exact", "message": "closed form"})

    # -- averages ---------------------------------------------------------------------------------

    @cached_property
    def cooling_rate(self) -> float:
        """h(e) = M2/2 = 2 sqrt(kappa lambda(1)), dimensionless (paper, label ``compare2``)."""
        return 2.0 * math.sqrt(self.law.mean_log_loss * float(self.law.decay_rate(1.0)))

    @cached_property
    def a2(self) -> float:
        """<c^4> d/(d+2) - 1 of the exact F (paper, label ``sonine5``); it exists for every e."""
        d = self.dimension
        if self.law.is_elastic:
            return d / (d + 2.0) - 1.0
        # <c^4> = 6 kappa lambda(1)/[lambda(2) lambda(3)]
        rates = self.law.decay_rate(np.array([1.0, 2.0, 3.0]))
        factor = 6.0 * d / (d + 2.0)
        return float(factor * self.law.mean_log_loss * rates[0] / (rates[1] * rates[2]) - 1.0)

    @cached_property
    def diffusion_slope(self) -> float:
        """Limit of d<r^2>/d ln t in units of l^2: 2/[kappa (1 - <cos chi>)]."""
        if self.law.is_elastic:
            return math.inf
        return 2.0 / (self.law.mean_log_loss * self.law.harmonic_decay_rate(0.0, 1))

    def moment(self, p: float) -> float:
        """Return <c^p> for real p, |p| <= 300, with <c^0> = <c^2> = 1.

        Raises
        ------
        InputError
            p is not above ``law.lowest_power``, or the moment overflows.
        """
        p = self._checked_power(p)
        if self.law.is_elastic:
            return 1.0
        # <c^p> = E[Y^p]/E[Y^2]^(p/2) and E[Y^p] = kappa^-p A(p): the powers of kappa cancel
        log_a = float(log_moment(self.law, np.array([p]))[0])
        return self._moment_from_log(p, log_a - 0.5 * p * log_second_moment(self.law))

    def scaled_speed_moment(self, p: float) -> float:
        """Return E[Y^p], the limit of <(v t/l)^p> at late times.

        Raises
        ------
        InputError
            As of :meth:`moment`; or bounces are elastic.
        """
        p = self._checked_power(p)
        if self.law.is_elastic:
            refuse("restitution", 1.0, "v t has no limit law in the elastic gas")
        log_a = float(log_moment(self.law, np.array([p]))[0])
        return math.exp(log_a - p * math.log(self.law.mean_log_loss))

    # -- the distribution -------------------------------------------------------------------------

    @property
    def tail_rate(self) -> float:
        """2/h: F(c) ~ c^tail_power exp(-tail_rate c) at high c; infinite if elastic."""
        if self.law.is_elastic:
            return math.inf
        return 2.0 / self.cooling_rate

    @property
    def tail_power(self) -> float:
        """The power of c before the exponential tail, b - d; infinite if elastic.

        b is 1/(1-e^2) for smooth disks, 2/(1-e^2) for smooth spheres, 0 where every bounce loses
        energy; NaN where the tail is no power times an exponential: rough disks with e = 1.
        """
        return self.law.tail_exponent - self.dimension

    def vdf(self, c: ArrayLike) -> Any:
        """Return F(c), the scaled velocity distribution, in the shape of c.

        Its integral over all velocities is 1, and <c^2> = 1. The relative error is below 5e-12
        wherever F is not below 1e-280; near e = 1, where F is a ring of width sqrt(1 - e), it is
        what the rounding of c makes, some 1e-16/sqrt(1 - e).

        Raises
        ------
        InputError
            A speed is negative or not finite, or bounces are elastic.

        Notes
        -----
        F(0) is 0 (a hole) unless bounces come as near to rest as one likes. For smooth scatterers
        with e = 0 it is infinite: F is exp(-sqrt(2) c)/(sqrt(2) pi c) for disks and
        3 exp(-sqrt(6) c)/(2 pi c) for spheres.
        """
        speeds = not_negative("c", c)
        if self.law.is_elastic:
            refuse("restitution", self.restitution, "elastic bounces leave no scaled VDF")
        return self._tabulated_vdf(speeds)[()]

    def _tabulated_vdf(self, c: FloatArray) -> FloatArray:
        """Return F(c) at speeds that are known to be good, shape of c."""
        uniform_power = self.law.uniform_power
        if uniform_power is not None:
            return self._vdf_of_uniform_ratio(c, uniform_power)
        speeds, density = self._speeds_from_rest(c.ravel())
        is_moving = speeds > 0.0
        # x = ln(kappa y), y = c sqrt(E[Y^2]); the density of x is that whose exponents are A(z)
        log_c = np.log(speeds[is_moving])
        x = log_c + 0.5 * log_second_moment(self.law)
        with np.errstate(under="ignore"):
            log_density = self._inversion.log_density(x) - self.dimension * log_c
            density[is_moving] = np.exp(log_density) / self.law.unit_surface
        return density.reshape(c.shape)

    def _vdf_of_uniform_ratio(self, c: FloatArray, q: float) -> FloatArray:
        """Return F(c) where s^q is uniform on [0, 1]: an exponential over c, shape of c."""
        rate = math.sqrt(q * (q + 1.0))
        norm = q**q * ((q + 1.0) / q) ** (0.5 * q)
        with np.errstate(divide="ignore"):
            return np.asarray(np.exp(-rate * c) / (self.law.unit_surface / norm * c))

    @cached_property
    def _inversion(self) -> MellinInversion:
        """The Mellin inversion, which keeps the lines that F(c) has taken so far."""
        return MellinInversion(self.law)

    # -- collisions and path ----------------------------------------------------------------------

    def collision_cumulants(self, n: int = 3) -> FloatArray:
        """Return limits of the first n <= 12 cumulants of the number of collisions over ln t.

        They are 1/kappa, Var(ln s)/kappa^3, ..., shape (n,).

        Raises
        ------
        InputError
            n is out of range; bounces are elastic, so that collisions grow as t; or the density is
            finite.
        """
        self._check_collisions_are_countable()
        return late_times.collision_cumulants(self.law, whole_number("n", n, 1, MOST_ORDERS))

    def path_cumulants(self, n: int = 3) -> FloatArray:
        """Return limits of the first n <= 12 cumulants of the path X over ln t, shape (n,).

        The k-th is in l^k: 1/kappa, E[(ln s)^2]/kappa^3, ... Errors are as of
        :meth:`collision_cumulants`.
        """
        self._check_collisions_are_countable()
        return late_times.path_cumulants(self.law, whole_number("n", n, 1, MOST_ORDERS))

    def collision_power(self, z: float) -> tuple[float, float]:
        """Return theta and C in E[z^N(t)] ~ C (v0 t/l)^theta at late times, from one speed v0.

        N is the number of collisions, z > 0, and 1/z = E[s^theta]. From other speeds C is
        multiplied by <v^theta>/v0^theta. z = 1/(1 + q) gives E[exp(-q X)], X the length of the path
        in l. Where all losses -ln s are multiples of one number, C is the mean of an oscillation in
        ln t.

        Raises
        ------
        InputError
            Bounces are elastic; the density is finite; theta is beyond +-1000 or, where some
            bounces lose nothing, does not exist; or C overflows.
        """
        self._check_collisions_are_countable()
        z = check_positive("z", z)
        if z == 1.0:
            return 0.0, 1.0
        theta = late_times.power_of_time(self.law, z)
        if theta is None:
            refuse("z", z, "E[z^N] is no power of t from -1000 to 1000 there")
        log_amplitude = late_times.log_amplitude(self.law, z, theta)
        if log_amplitude > LARGEST_LOG:
            refuse("z", z, "C overflows double precision there")
        return theta, math.exp(log_amplitude)

    def _check_collisions_are_countable(self) -> None:
        """Raise InputError if bounces are elastic, or the density is finite."""
        if self.law.is_elastic:
            refuse("restitution", self.restitution, "the collisions of elastic bounces grow as t")
        if self.law.medium is not None:
            refuse("scatterers", self.scatterers, "collisions are counted in the dilute gas only")

    def _figures(self) -> dict[str, str]:
        """Return the numbers that a repr and a notebook show, as text."""
        return super()._figures() | {"d<r^2>/dln(t)": f"{self.diffusion_slope:.12g}"}
