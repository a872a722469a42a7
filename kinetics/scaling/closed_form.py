r"""The scaling solution in closed form: the moments, the cooling rate and the scaled VDF.

Multiply the paper's scaled equation (label ``ifmu2``) by c^p and integrate: with Y = v t/l, for all
complex z, lambda(z) E[Y^(z+1)] = z E[Y^z] and E[Y] = 1/kappa. E[Y^n] is a finite product. The other
moments and F(c), by Mellin inversion, are in :mod:`kinetics.scaling.mellin`.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics.collision import CollisionLaw, law_in_medium, law_of
from kinetics.numerics import LARGEST_LOG, ROUNDING
from kinetics.numerics.recurrence import MOST_ORDERS
from kinetics.results.frame import dataset, variable
from kinetics.results.record import stored_class
from kinetics.results.result import Result
from kinetics.scaling import mellin
from kinetics.validation import check_positive, not_negative, real_number, refuse, whole_number

_EXPONENT_LIMIT = 300.0  # of moments: near it they leave the range of doubles for small e


@dataclass(frozen=True, eq=False, repr=False)
class ScaledState(Result):
    """What the closed form and the solver share: the law that was asked for."""

    restitution: Any
    tangential_restitution: float | None = 1.0
    dimension: int = 2
    scatterers: str = "dilute"
    number_density: float | None = None
    diameter: float = 1.0
    density_order: str = "second"
    mass_ratio: float = math.inf
    _points, _on_demand = ("c",), ("moment", "vdf")
    _about: ClassVar[Mapping[str, str]] = MappingProxyType({})  # attributes of a dataset

    def __post_init__(self) -> None:
        for name, value in self.law.arguments.items():
            object.__setattr__(self, name, value)

    @cached_property
    def law(self) -> CollisionLaw:
        """The collision law of these restitutions, in this dimension."""
        restitutions = self.restitution, self.tangential_restitution
        law = law_of(*restitutions, self.dimension, self.mass_ratio)
        medium = self.scatterers, self.number_density, self.diameter, self.density_order
        return law_in_medium(law, *medium)

    def _power(self, p: Any) -> float:
        """p of a moment, checked."""
        number = real_number("p", p, -_EXPONENT_LIMIT, _EXPONENT_LIMIT)
        if number <= self.law.lowest_power:
            refuse("p", p, f"moments of this law exist for p > {self.law.lowest_power:g} only")
        return number

    def _exp(self, p: Any, log_moment: float) -> float:
        """A moment from its logarithm."""
        if log_moment > LARGEST_LOG:
            refuse("p", p, "<c^p> overflows double precision there")
        return math.exp(log_moment)

    def _dataset(self: Any, only: Collection[str] | None = None, **points: Any) -> Any:
        """h, a2, moments, and, where something cools, F(c), c up to 4."""
        powers, d = np.arange(1.0, 7.0), self.dimension
        found = {
            "cooling_rate": variable((), self.cooling_rate, "1", "h(e), from v0 = 2 l/(h t)", "h"),
            "a2": variable((), self.a2, "1", "<c^4> d/(d+2) - 1", "a2"),
        }
        if only is None or "moment" in only:
            words = "<c^p>, c the speed over the thermal speed"
            moments = [self.moment(p) for p in powers]
            found["moment"] = variable(("p",), moments, "1", words, "<c^p>")
        c = points.get("c")
        c = np.linspace(0.0, 4.0, 201)[1:] if c is None else np.atleast_1d(np.asarray(c, float))
        if self.cooling_rate > 0.0 and (not only or "vdf" in only):
            words = f"scaled velocity distribution F(c), of integral 1 in {d} dimensions"
            vdf = getattr(self, "reached_vdf", self.vdf)  # the solver: 0 where it does not reach
            found["vdf"] = variable(("c",), vdf(c), "1", words, "F")
        axes = {
            "c": variable(("c",), c, "1", "speed over the thermal speed"),
            "p": variable(("p",), powers, "1", "power of the speed"),
        }
        title = f"Scaled velocity distribution: {self.law.described}"
        return dataset(self, title, self, found, axes, **self._about)

    def _figures(self: Any) -> dict[str, str]:
        """What a notebook shows."""
        numbers = {"cooling rate h": f"{self.cooling_rate:.12g}", "a2": f"{self.a2:.12g}"}
        return {"law": self.law.described} | numbers


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class ScalingSolution(ScaledState):
    """The self-similar cooling state of the inelastic Lorentz gas, exactly.

    restitution : e in [0, 1], or a :class:`kinetics.CollisionLaw`
    tangential_restitution, dimension, scatterers, number_density, diameter, density_order,
        mass_ratio : as in a Scene; the density counts as number_density * diameter^2

    Lengths are in l, the mean path between collisions, which is ``law.mean_free_path``. Raises
    InputError (a ValueError) for an argument out of range or not a number.

    If bounces are elastic, nothing cools: ``cooling_rate`` is 0, ``a2`` and ``moment`` are the
    limits e -> 1 (all speeds are one), ``diffusion_slope`` is infinite, and :meth:`vdf` raises.

    >>> exact = ScalingSolution(0.0)
    >>> bool(abs(exact.cooling_rate - 2**0.5) < 1e-15), bool(abs(exact.a2 - 2) < 1e-14)
    (True, True)
    """

    _about = MappingProxyType({"status": "exact", "message": "closed form"})

    @cached_property
    def cooling_rate(self) -> float:
        """h(e) = M2/2 = 2 sqrt(kappa lambda(1)), dimensionless (paper, label ``compare2``)."""
        return 2.0 * math.sqrt(self.law.mean_log_loss * float(self.law.decay_rate(1.0)))

    @cached_property
    def a2(self) -> float:
        """<c^4> d/(d+2) - 1 of the exact F (paper, label ``sonine5``); it exists for every e."""
        law, d = self.law, self.dimension
        if law.is_elastic:
            return d / (d + 2.0) - 1.0
        rates = law.decay_rate(np.array([1.0, 2.0, 3.0]))
        gaussian = 6.0 * d / (d + 2.0)
        return float(gaussian * law.mean_log_loss * rates[0] / (rates[1] * rates[2]) - 1.0)

    @cached_property
    def diffusion_slope(self) -> float:
        """Limit of d<r^2>/d ln t in units of l^2: 2/[kappa (1 - <cos chi>)]."""
        if self.law.is_elastic:
            return math.inf
        return 2.0 / (self.law.mean_log_loss * self.law.harmonic_decay_rate(0.0, 1))

    def collision_cumulants(self, n: int = 3) -> NDArray[Any]:
        """Limits of the first n <= 12 cumulants of the number of collisions over ln t, shape (n,).

        1/kappa, Var(ln s)/kappa^3, ... Raises InputError for elastic bounces, where they grow as
        t, and at a finite density.
        """
        self._check_counted()
        return mellin.cumulants(self.law, whole_number("n", n, 1, MOST_ORDERS), False)

    def path_cumulants(self, n: int = 3) -> NDArray[Any]:
        """The same of the length X of the path: its k-th cumulant per ln t, in l^k, shape (n,).

        1/kappa, E[(ln s)^2]/kappa^3, ...; errors as :meth:`collision_cumulants`.
        """
        self._check_counted()
        return mellin.cumulants(self.law, whole_number("n", n, 1, MOST_ORDERS), True)

    def collision_power(self, z: float) -> tuple[float, float]:
        """(theta, C) in E[z^N(t)] ~ C (v0 t/l)^theta at late times, from one speed v0, z > 0.

        N is the number of collisions, 1/z = E[s^theta]; from other speeds C is multiplied by
        <v^theta>/v0^theta. z = 1/(1 + q) gives E[exp(-q X)], X the length of the path in l. Where
        all losses -ln s are multiples of one number, C is the mean of an oscillation in ln t.

        Raises InputError for elastic bounces, at a finite density, and for a z where theta is
        beyond +-1000 or, where some bounces lose nothing, there is none.
        """
        self._check_counted()
        z = check_positive("z", z)
        if z == 1.0:
            return 0.0, 1.0
        theta = mellin.power_of(self.law, z)
        if theta is None:
            refuse("z", z, "E[z^N] is no power of t from -1000 to 1000 there")
        log_c = mellin.log_amplitude(self.law, z, theta)
        if log_c > LARGEST_LOG:
            refuse("z", z, "C overflows double precision there")
        return theta, math.exp(log_c)

    @property
    def tail_rate(self) -> float:
        """2/h: F(c) ~ c^tail_power exp(-tail_rate c) at high c; infinite if elastic."""
        return math.inf if self.law.is_elastic else 2.0 / self.cooling_rate

    @property
    def tail_power(self) -> float:
        """The power of c before the exponential tail, b - d; infinite if elastic.

        b is 1/(1-e^2) for smooth disks, 2/(1-e^2) for smooth spheres, 0 where every bounce loses
        energy; NaN where the tail is no power times an exponential: rough disks with e = 1.
        """
        return self.law.tail_exponent - self.dimension

    def moment(self, p: float) -> float:
        """<c^p> for real p, |p| <= 300, with <c^0> = <c^2> = 1.

        Raises InputError for p not above ``law.lowest_power``, and where the moment overflows.
        """
        p = self._power(p)
        if self.law.is_elastic:
            return 1.0
        # <c^p> = E[Y^p]/E[Y^2]^(p/2) and E[Y^p] = kappa^-p A(p): the powers of kappa cancel
        log_moment = float(mellin.log_moment(self.law, np.array([p]))[0])
        return self._exp(p, log_moment - 0.5 * p * mellin.log_second_moment(self.law))

    def scaled_speed_moment(self, p: float) -> float:
        """E[Y^p], the limit of <(v t/l)^p>; p and errors as in :meth:`moment`; not elastic."""
        p = self._power(p)
        if self.law.is_elastic:
            refuse("restitution", 1.0, "v t has no limit law in the elastic gas")
        log_a = float(mellin.log_moment(self.law, np.array([p]))[0])
        return math.exp(log_a - p * math.log(self.law.mean_log_loss))

    def vdf(self, c: ArrayLike) -> Any:
        """F(c), the scaled velocity distribution; same shape as c.

        Its integral over all velocities is 1, and <c^2> = 1. Relative error below 5e-12 wherever F
        is not below 1e-280; near e = 1, where F is a ring of width sqrt(1 - e), what the rounding
        of c makes, some 1e-16/sqrt(1 - e). F(0) is 0 (a hole) unless bounces come as near to rest
        as one likes. For smooth scatterers with e = 0, F is infinite there: exp(-sqrt(2) c)/
        (sqrt(2) pi c) for disks, 3 exp(-sqrt(6) c)/(2 pi c) for spheres.

        Raises InputError for c negative or not finite, and for elastic bounces.
        """
        c_ = not_negative("c", c)
        if self.law.is_elastic:
            refuse("restitution", self.restitution, "elastic bounces leave no scaled VDF")
        law, d = self.law, self.dimension
        q = law.uniform_power
        if q:
            rate, norm = math.sqrt(q * (q + 1.0)), q**q * ((q + 1.0) / q) ** (0.5 * q)
            with np.errstate(divide="ignore"):
                return (np.exp(-rate * c_) / (law.unit_surface / norm * c_))[()]
        flat, out = from_rest(law, c_.ravel())
        inside = flat > 0.0
        # x = ln(kappa y), y = c sqrt(E[Y^2]); the density of x is that whose exponents are A(z)
        log_c = np.log(flat[inside])
        x = log_c + 0.5 * mellin.log_second_moment(law)
        with np.errstate(under="ignore"):
            log_f = mellin.log_density(law, x, self._lines) - d * log_c
            out[inside] = np.exp(log_f) / law.unit_surface
        return out.reshape(c_.shape)[()]

    @cached_property
    def _lines(self) -> list[mellin.Line]:
        """The Mellin lines that F(c) has taken so far."""
        return []

    def _figures(self) -> dict[str, str]:
        return super()._figures() | {"d<r^2>/d ln t / l^2": f"{self.diffusion_slope:.12g}"}

    def _check_counted(self) -> None:
        if self.law.is_elastic:
            refuse("restitution", self.restitution, "the collisions of elastic bounces grow as t")
        if self.law.medium is not None:
            refuse("scatterers", self.scatterers, "collisions are counted in the dilute gas only")


def from_rest(law: CollisionLaw, c: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """The speeds at which F is asked for, shape (n,), and F(0) at all of them, as a beginning.

    Where bounces come as near to rest as one likes F ~ c^(q - d), with -q the lowest power of the
    law, is infinite at rest, or (q = d) finite and asked for at a speed close by; else it is 0.
    """
    if not law.reaches_rest:
        return c, np.zeros(c.shape)
    power = -law.lowest_power - law.dimension
    if power == 0.0:
        c = np.where(c == 0.0, ROUNDING, c)  # corrections are of that order
    return c, np.full(c.shape, math.inf if power < 0.0 else 0.0)
