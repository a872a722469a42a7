"""The collision law as averages: the only thing that the solvers ask of a collision.

The kinetic equation needs of one collision the averages E[s^p cos(m chi)] in the plane, and
E[s^p P_m(cos chi)] in space, with s the speed ratio and chi the deflection. Whatever scales with
the speed is such a law. Among scatterers at a finite density the same averages decide, see
`kinetics.collision.medium`.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics.collision.averages import ImpactQuadrature
from kinetics.collision.bounce import RESOLVED, Bounce, DiskBounce, MixedBounce, SampledBounce
from kinetics.collision.medium import SCATTERERS, Medium, checked_medium
from kinetics.errors import InputError, short
from kinetics.validation import (
    check_mass_ratio,
    check_restitution,
    finite_line,
    number_array,
    real_number,
    refuse,
    whole_number,
)

_LEAST_RATE = 1.0 / sys.float_info.max
_HIGHEST_HARMONIC = 1_000_000
_LEAST_RATIO = 1e-8  # of speeds: if none is larger, every bounce stops the tracer
_LARGEST_TURN = 1e7  # that many turns of s^z take 7e6 points, about a gigabyte of exponentials
_LEVELS_KEPT = 6  # quadratures of up to 60,000 points are kept for the next question


@dataclass(frozen=True)
class CollisionLaw:
    """The bounce off a fixed disk or sphere, averaged over a uniform impact parameter.

    Parameters
    ----------
    restitution : e in [0, 1], by which the normal velocity is multiplied (and turned round)
    tangential_restitution : et in [0, 1], by which the tangential velocity is multiplied; 1 for
        smooth scatterers. Not both may be below 1e-8: the tracer would stop at its first bounce
    dimension : 2 (disks in the plane) or 3 (spheres)
    mass_ratio : A, the mass of a scatterer over that of the tracer, 1e-6 or more; inf: fixed.
        A finite one, for smooth scatterers, is of scatterers at rest that are met once each

    Raises
    ------
    InputError (a ValueError) : an argument out of range or not a number

    A law that is not of this form is made by :meth:`from_samples` or :meth:`mixture`; its
    ``restitution`` and ``tangential_restitution`` are None. That of a scene at a finite density has
    a ``medium``: what belongs to one collision is as without it, rates of decay are those of the
    medium.

    With a finite mass ratio ``restitution`` is that of the relative velocity, and the bounce is
    that off a fixed scatterer of ``effective_restitution``, which e stands for everywhere else.

    All results are dimensionless. Relative accuracy 1e-13 or better for every e and et, those near
    0 and 1 included: for real p each is a sum of terms of one sign. For complex p the error of
    E[s^p] is relative to E[s^(Re p)]. Rounding of e leaves 1e-16 (A + 1/A) at a mass ratio A.

    >>> law = CollisionLaw(restitution=0.7)
    >>> bool(abs(law.decay_rate(2) - 2 / 3 * (1 - 0.7**2)) < 1e-15)
    True
    >>> CollisionLaw(0.0, dimension=3).mean_log_loss
    0.5
    """

    restitution: float | None
    tangential_restitution: float | None = 1.0
    dimension: int = 2
    _samples: SampledBounce | MixedBounce | None = field(default=None, repr=False)
    medium: Medium | None = field(default=None, repr=False)
    mass_ratio: float = math.inf

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        set_(self, "dimension", whole_number("dimension", self.dimension, 2, 3))
        set_(self, "mass_ratio", check_mass_ratio(self.mass_ratio))
        if self._samples is not None:
            return
        e = check_restitution(self.restitution)
        allowed = "it must be a number from 0 (all tangential velocity lost) to 1 (smooth)"
        value = self.tangential_restitution
        et = real_number("tangential_restitution", value, 0.0, 1.0, allowed)
        if max(e, et) < _LEAST_RATIO:
            allowed = f"at restitution {short(e)} it must be {_LEAST_RATIO:g} or more"
            refuse("tangential_restitution", value, allowed)
        if et != 1.0 and self.mass_ratio < math.inf:
            allowed = f"at tangential_restitution {short(et)} it must be inf: fixed scatterers"
            refuse("mass_ratio", self.mass_ratio, allowed)
        set_(self, "restitution", e)
        set_(self, "tangential_restitution", et)

    @classmethod
    def from_samples(
        cls, weight: ArrayLike, ratio: ArrayLike, cosine: ArrayLike, dimension: int = 2
    ) -> CollisionLaw:
        """A law of one's own: a mixture of scatterers, a random restitution, measured bounces.

        Parameters
        ----------
        weight : of each sample, not negative, sum 1, shape (n_samples,), up to 20,000 of them
        ratio : speed after the bounce over the speed before, above 0, same shape
        cosine : cosine of the deflection, from -1 to 1, same shape. A law must not prefer left
            or right: in the plane the deflection takes both signs with equal chance, in space
            every azimuth
        dimension : 2 or 3

        Averages are the sums over the samples; :meth:`mixture` mixes laws. Ratios above 1 have
        averages, but the solvers refuse them: they need a tracer that never gains energy.

        Raises
        ------
        InputError (a ValueError) : arrays of other shapes or out of range

        >>> half = CollisionLaw.from_samples([0.5, 0.5], [0.9, 0.4], [0.0, 0.0])
        >>> float(half.mean_speed_ratio_power(2.0))
        0.485
        """
        dimension = whole_number("dimension", dimension, 2, 3)
        samples = SampledBounce.checked(weight, ratio, cosine, dimension)
        return cls(None, None, dimension, samples)

    @classmethod
    def mixture(cls, weights: ArrayLike, laws: Sequence[CollisionLaw]) -> CollisionLaw:
        """Each collision follows one of the laws, drawn anew: a random restitution, or scatterers
        of several kinds.

        Parameters
        ----------
        weights : the chance of each law at a collision, above 0, up to a common factor, (n_laws,).
            For kinds of scatterers it is in proportion to number density times cross section, and
            l is the mean free path among all of them
        laws : of one dimension, each of any form, without a medium

        E[s^p cos(m chi)] is the weighted sum of those of the laws, to the same accuracy: what is
        smooth stays smooth. It is for dilute scatterers: a finite density is refused.

        Raises
        ------
        InputError (a ValueError) : weights or laws out of range

        >>> mixed = CollisionLaw.mixture([1, 3], [CollisionLaw(0.5), CollisionLaw(0.9)])
        >>> bool(abs(mixed.decay_rate(2) - 2 / 3 * (1 - (0.5**2 + 3 * 0.9**2) / 4)) < 1e-15)
        True
        """
        given = list(laws) if isinstance(laws, Sequence) else laws
        allowed = "give a list of CollisionLaw"
        if not (isinstance(given, list) and given):
            refuse("laws", laws, allowed)
        for law in given:
            if not isinstance(law, CollisionLaw):
                refuse("laws", law, allowed)
            if law.dimension != given[0].dimension:
                refuse(
                    "laws", law, f"all must have one dimension, the first has {given[0].dimension}"
                )
            if law.medium is not None:
                refuse("laws", law, "a mixture is derived for dilute scatterers only, no medium")
        w = finite_line("weights", weights)
        if w.size != len(given):
            refuse("weights", weights, f"it must have as many numbers as laws, {len(given)}")
        if np.any(w <= 0.0) or not math.isfinite(w.sum()):
            refuse("weights", float(w.min()), "each weight must be above 0, and their sum finite")
        bounce = MixedBounce.of(w, [law._bounce for law in given])
        return cls(None, None, bounce.dimension, bounce)

    def __repr__(self) -> str:
        if isinstance(self._samples, MixedBounce):
            count = len(self._samples.weight)
            return f"CollisionLaw.mixture({count} laws, dimension={self.dimension})"
        if self._samples is not None:
            count = len(self._samples.weight)
            return f"CollisionLaw.from_samples({count} samples, dimension={self.dimension})"
        return f"CollisionLaw({self.described})"

    @property
    def described(self) -> str:
        """The arguments, for texts; those that have their defaults are left out."""
        if self._samples is not None:
            return f"restitution={self!r}"
        rest = ""
        if self.tangential_restitution != 1.0:
            rest += f", tangential_restitution={self.tangential_restitution!r}"
        if self.dimension != 2:
            rest += f", dimension={self.dimension}"
        if self.mass_ratio != math.inf:
            rest += f", mass_ratio={self.mass_ratio!r}"
        if self.medium is not None:
            rest += f", scatterers={self.medium.scatterers!r}"
        return f"restitution={self.restitution!r}{rest}"

    @property
    def arguments(self) -> dict[str, Any]:
        """What :func:`law_of` makes this law of; ``restitution`` is the law itself without one."""
        return {
            "restitution": self if self._samples is not None else self.restitution,
            "tangential_restitution": self.tangential_restitution,
            "dimension": self.dimension,
            "mass_ratio": self.mass_ratio,
        }

    # -- what kind of law it is -------------------------------------------------------------------

    @cached_property
    def _bounce(self) -> Bounce:
        if self._samples is not None:
            return self._samples
        assert self.effective_restitution is not None
        assert self.tangential_restitution is not None
        return DiskBounce(self.effective_restitution, self.tangential_restitution, self.dimension)

    @cached_property
    def effective_restitution(self) -> float | None:
        """e of the fixed scatterer that leaves the tracer the same velocity, -1 < e <= 1.

        With A the mass ratio 1 + e = (1 + restitution) A/(1 + A). Below 0 the tracer goes on behind
        the scatterer that it has hit. None for samples and mixtures.
        """
        if self.restitution is None or self.mass_ratio == math.inf:
            return self.restitution
        return (self.restitution * self.mass_ratio - 1.0) / (self.mass_ratio + 1.0)

    @cached_property
    def is_elastic(self) -> bool:
        """Whether every bounce keeps the speed."""
        return self.least_loss == self.largest_loss == 0.0

    @cached_property
    def least_loss(self) -> float:
        """The smallest -ln s that occurs: 0 for smooth scatterers, below 0 if energy is gained."""
        return self._bounce.least_loss

    @cached_property
    def largest_loss(self) -> float:
        """The largest -ln s that occurs: -ln |e| for smooth scatterers, infinite at e = 0."""
        return self._bounce.largest_loss

    @property
    def least_ratio(self) -> float:
        """The smallest speed ratio s: |e| for smooth scatterers; 0 where s comes close to 0."""
        return math.exp(-self.largest_loss)

    @property
    def has_atoms(self) -> bool:
        """Whether s takes single values, each with a chance of its own: samples, or et = e."""
        return self._bounce.has_atoms

    @cached_property
    def disk_restitutions(self) -> tuple[float, ...]:
        """The effective restitutions of the disks or spheres of which the law is made."""
        return tuple(p.restitution for p in self._bounce.parts if isinstance(p, DiskBounce))

    @cached_property
    def throws_back(self) -> bool:
        """Whether samples throw some of the tracers straight back."""
        samples = (p.quadrature(0) for p in self._bounce.parts if isinstance(p, SampledBounce))
        return any(bool(np.any(q.weight[q.cosine < -1.0 + 1e-9] > 0.0)) for q in samples)

    @cached_property
    def loss_ends(self) -> tuple[float, ...]:
        """The least and the largest -ln s of each part of the law: its density steps there."""
        return tuple(x for p in self._bounce.parts for x in (p.least_loss, p.largest_loss))

    @cached_property
    def lowest_power(self) -> float:
        """E[s^p] exists for Re p above it: -inf, but where s comes as near to 0 as one likes.

        There it is -1 for smooth disks (e = 0), -2 for spheres and for et = 0. In a medium it may
        be higher: below it returns of returns do not add up to anything finite.
        """
        lowest = self._bounce.lowest_power
        if self.medium is None:
            return lowest
        return max(lowest, self.medium.lowest_power(self.quadrature))

    @property
    def reaches_rest(self) -> bool:
        """Whether bounces leave as little of the speed as one likes."""
        return math.isfinite(self._bounce.lowest_power)

    @property
    def uniform_power(self) -> float | None:
        """q where s^q is uniform on [0, 1]: smooth scatterers at e = 0, q = 1 (disks), 2 (spheres).

        Then lambda(z) = z/(z + q), kappa = 1/q, and the scaling state is known in closed form. None
        for all other laws.
        """
        if self.effective_restitution == 0.0 and self.tangential_restitution == 1.0:
            return self.dimension - 1.0
        return None

    @cached_property
    def energy_loss(self) -> float:
        """lambda(2) = 1 - E[s^2], the share of its energy that a tracer loses at a bounce."""
        return float(self.decay_rate(2.0))

    @property
    def unit_surface(self) -> float:
        """The circumference of the unit circle, 2 pi, or the surface of the unit sphere, 4 pi."""
        return 2.0 * math.pi * (self.dimension - 1.0)

    def mean_free_path(self, number_density: float, diameter: float) -> float:
        """l = 1/(2 d rho) among disks, 1/(pi d^2 rho) among spheres; d the diameter.

        0 or infinite where it is beyond the range of doubles; that of the medium if there is one.
        """
        across = 2.0 * diameter if self.dimension == 2 else math.pi * diameter * diameter
        rate = across * number_density
        ratio = 1.0 if self.medium is None else self.medium.path_ratio
        return ratio / rate if rate >= _LEAST_RATE else math.inf

    @property
    def tail_exponent(self) -> float:
        """b where E[s^p] tends to b/p at large p: 1/(1-e^2) for smooth disks, twice it for spheres.

        0 where E[s^p] falls faster than any power, infinite or NaN where it falls more slowly.
        """
        return self._bounce.tail_exponent

    # -- averages ---------------------------------------------------------------------------------

    @cached_property
    def quadrature(self) -> ImpactQuadrature:
        """The average over the impact parameter as a weighted sum, for slow functions of ln s."""
        return self.quadrature_for(0.0)

    def quadrature_for(self, rate: float, m: int = 0) -> ImpactQuadrature:
        """The same for functions that vary as fast as s^z cos(m chi) with |z| up to ``rate``.

        Raises InputError where that takes more than some million points.
        """
        level = self._level(rate, m)
        if level > _LEVELS_KEPT:
            return self._bounce.quadrature(level)
        return _kept_quadrature(self._bounce, level)

    def _level(self, rate: float, m: int) -> int:
        """How often panels are halved for functions that vary so fast."""
        turn = self._bounce.turns(rate, m)
        if not turn <= _LARGEST_TURN:
            raise InputError(f"p: got a size of {rate:.3g}; E[s^p] needs too many points there")
        return max(0, math.ceil(math.log2(max(turn, 1.0) / RESOLVED)))

    def survival_for(self, rate: float) -> tuple[NDArray[Any], NDArray[Any]]:
        """u and w, (n,) each: int_0^inf P(-ln s > u) f(u) du = sum w f, f as fast as e^(rate u)."""
        return self._bounce.survival(self._level(rate, 0), rate)

    def cells(self, spacing: float, points: int = 6) -> tuple[ImpactQuadrature, NDArray[np.int64]]:
        """The average cell by cell of width ``spacing`` in -ln s, with so many points in each.

        Returns the quadrature and the cell of each of its nodes, shape (n_nodes,). Where s reaches
        0 cells end at -ln s = 40; the last one holds all bounces below.
        """
        return self._bounce.cells(spacing, points)

    def mean_speed_ratio_power(self, p: ArrayLike) -> Any:
        """E[s^p]: a float for a real p, an array of the shape of p for an array; p may be complex.

        Closed forms: e^p 2F1(-p/2, 1/2; 3/2; -(1-e^2)/e^2) for smooth disks,
        2 (et^(p+2) - e^(p+2))/((p+2)(et^2 - e^2)) for spheres.
        """
        p_ = self._exponents(p)
        if self.effective_restitution == 0.0:
            above = self.dimension - 1.0
            return (above / (above + p_) * np.exp(p_ * self._log_tangential))[()]
        q = self.quadrature_for(_size(p_))
        with np.errstate(over="ignore", invalid="ignore"):
            mean = np.exp(-np.multiply.outer(p_, q.log_loss)) @ q.weight + self._bounce.beyond(p_)
        return self._finite(p, mean)[()]

    def decay_rate(self, p: ArrayLike) -> Any:
        """lambda(p) = 1 - E[s^p], so that d<v^p>/dt = -lambda(p) <v^(p+1)>/l (isotropic part).

        Same shapes as :meth:`mean_speed_ratio_power`; accurate relative to itself also where
        it vanishes (p -> 0, elastic bounces). Negative for p < 0.
        """
        p_ = self._exponents(p)
        with np.errstate(over="ignore", invalid="ignore"):
            rate = self.decay_symbol(p_)
        return self._finite(p, rate)[()]

    def decay_symbol(self, z: NDArray[Any]) -> NDArray[Any]:
        """lambda(z), shape of z; without checks of the range, for inner loops."""
        return self.met_again(z, self._lost(z), 0)

    def _lost(self, z: NDArray[Any]) -> NDArray[Any]:
        """1 - E[s^z] of one collision, shape of z."""
        if self.effective_restitution == 0.0:
            above = self.dimension - 1.0
            return np.asarray((z - above * np.expm1(z * self._log_tangential)) / (above + z))
        q = self.quadrature_for(_size(z))
        rate = -np.expm1(-np.multiply.outer(z, q.log_loss)) @ q.weight
        return np.asarray(rate - self._bounce.beyond(z))

    def decay_rates(self, z: NDArray[Any], offsets: NDArray[Any], m: int = 0) -> NDArray[Any]:
        """lambda_m(z + d) for z (n_z,) and d (n_d,), shape (n_z, n_d), relative to itself."""
        at = z[:, None] + offsets
        if self.effective_restitution == 0.0 and m == 0:
            return self.decay_symbol(at)
        # 1 - s^(z + d) c = (1 - s^z) s^d c + 1 - s^d + s^d (1 - c), c = cos(m chi): a product of
        # matrices in place of exponentials
        q = self.quadrature_for(_size(at), m)
        gone = q.harmonic_loss(m)
        lost = _lost_powers(z, q.log_loss)
        rest = np.multiply.outer(q.log_loss, offsets)
        power = q.weight[:, None] * np.exp(-rest)
        rate = lost @ ((1.0 - gone)[:, None] * power) - q.weight @ np.expm1(-rest) + gone @ power
        if m % 2 == 0:  # as in harmonic_decay_rate
            rate = rate - self._bounce.beyond(at) * (1.0 - gone[0])
        return self.met_again(at, rate, m)

    def decay_taylor(self, z: NDArray[Any], orders: int, m: int = 0) -> list[NDArray[Any]]:
        """Taylor coefficients of lambda_m at z (n,), of the orders 0 to orders - 1, each (n,)."""
        q = self.quadrature_for(_size(z), m)
        power = np.exp(-np.multiply.outer(z, q.log_loss))
        order, weight = np.arange(1.0, orders), q.weight * q.harmonic(m)
        factors = weight[:, None] * np.cumprod(-q.log_loss[:, None] / order, axis=1)
        # a complex matrix times a real one would be taken apart for each column
        slopes = power.real @ factors + (1j * (power.imag @ factors) if np.iscomplexobj(z) else 0.0)
        first = 1.0 - power @ weight if m else self._lost(z)
        return self.taylor_met_again(z, [first, *(-slopes.T)], m)

    @cached_property
    def mean_log_loss(self) -> float:
        """kappa = E[-ln s]: 1 - e arccos(e)/sqrt(1-e^2) for smooth disks; 0 if elastic."""
        if self.effective_restitution == 0.0:
            return 1.0 / (self.dimension - 1.0) - self._log_tangential
        return float(self.quadrature.weight @ self.quadrature.log_loss)

    @cached_property
    def mean_cosine(self) -> float:
        """<cos chi>: for smooth disks 1/2 at e = 0, -1/3 at e = 1 (backwards on average)."""
        if self.effective_restitution == 0.0:
            return (self.dimension - 1.0) / self.dimension
        return float(self.quadrature.weight @ self.quadrature.cosine)

    def harmonic_decay_rate(self, p: ArrayLike, m: int) -> Any:
        """1 - E[s^p cos(m chi)]: how fast the moment of v^p exp(i m phi) is lost, in v/l.

        In space cos(m chi) is P_m(cos chi), and exp(i m phi) any spherical harmonic of degree m.
        A float for a real p, an array of the shape of p for an array.
        """
        m = whole_number("m", m, -_HIGHEST_HARMONIC, _HIGHEST_HARMONIC)
        if m == 0:
            return self.decay_rate(p)
        p_ = self._exponents(p)
        q = self.quadrature_for(_size(p_), abs(m))
        gone = q.harmonic_loss(m)
        # 1 - s^p cos = (1 - s^p) + s^p (1 - cos): no cancellation
        with np.errstate(over="ignore", invalid="ignore"):
            lost = -np.expm1(-np.multiply.outer(p_, q.log_loss))
            rate = (lost + (1.0 - lost) * gone) @ q.weight
            if m % 2 == 0:  # bounces beyond the nodes deflect by pi/2, as the first one of them
                rate = rate - self._bounce.beyond(p_) * (1.0 - gone[0])
            rate = self.met_again(p_, rate, m)
        return self._finite(p, rate)[()]

    # -- returns to the scatterer before, in a medium ----------------------------------------------

    @cached_property
    def without_medium(self) -> CollisionLaw:
        """The same bounce among scatterers that are never met again."""
        return replace(self, medium=None)

    def returns(self, m: int) -> tuple[float, float]:
        """eps (-1)^m, and x = -ln e, of the bounces straight back; both are 0 where none comes.

        K - 1 on harmonic m is replaced by (K - 1)/(1 - eps S (K - 1)), S f(ln v) = f(ln v - x).
        """
        if self.medium is None or not self.restitution:
            return 0.0, 0.0
        return self.medium.returns(m) * (-1.0) ** m, self.largest_loss

    def met_again(self, z: NDArray[Any], rate: NDArray[Any], m: int) -> NDArray[Any]:
        """lambda_m at z with returns to the scatterer before, from that without; shape of z."""
        eps, loss = self.returns(m)
        return np.asarray(rate / (1.0 + eps * np.exp(-loss * z) * rate)) if eps else rate

    def taylor_met_again(self, z: Any, rate: list[NDArray[Any]], m: int) -> list[NDArray[Any]]:
        """The same for Taylor coefficients of lambda_m at z, each of the shape of z."""
        eps, loss = self.returns(m)
        if not eps:
            return rate
        orders = range(len(rate))
        back = [eps * np.exp(-loss * z) * (-loss) ** n / math.factorial(n) for n in orders]
        below = [sum(back[i] * rate[n - i] for i in range(n + 1)) for n in orders]
        out: list[NDArray[Any]] = []
        for n in orders:
            known = sum((below[i] * out[n - i] for i in range(1, n + 1)), np.zeros_like(z))
            out.append(np.asarray((rate[n] - known) / (1.0 + below[0])))
        return out

    @property
    def _log_tangential(self) -> float:
        """ln et, at e = 0, where s = et y."""
        assert self.tangential_restitution is not None
        return math.log(self.tangential_restitution)

    def _exponents(self, p: ArrayLike) -> NDArray[Any]:
        p_ = number_array("p", p, "iufc", "it must be a number or an array of numbers")
        if not np.all(np.isfinite(p_)):
            refuse("p", p, "it must be finite")
        if np.any(p_.real <= self.lowest_power):
            where = "at tangential_restitution 0"
            if self.effective_restitution == 0.0:
                where = "at restitution 0"
            elif self.medium is not None:
                where = "among these scatterers"
            refuse("p", p, f"{where} it must be above {self.lowest_power:g}")
        return p_

    @staticmethod
    def _finite(p: ArrayLike, value: NDArray[Any]) -> NDArray[Any]:
        if not np.all(np.isfinite(value)):
            refuse("p", p, "E[s^p] overflows double precision there")
        return value


def _lost_powers(z: NDArray[Any], log_loss: NDArray[Any]) -> NDArray[Any]:
    """1 - s^z for z (n_z,), shape (n_z, n_points): half angles are quicker than complex expm1."""
    fall, half = (np.multiply.outer(part, log_loss) for part in (z.real, 0.5 * z.imag))
    sine, left = np.sin(half), 2.0 * np.exp(-fall)
    left *= sine
    return np.asarray(left * sine - np.expm1(-fall) + 1j * (left * np.cos(half)))


def _size(z: NDArray[Any]) -> float:
    return float(np.max(np.abs(z))) if z.size else 0.0


@lru_cache(maxsize=64)
def _kept_quadrature(bounce: Bounce, level: int) -> ImpactQuadrature:
    """The same quadrature again: it is not made twice."""
    return bounce.quadrature(level)


def law_of(
    restitution: Any, tangential_restitution: Any = 1.0, dimension: Any = 2,
    mass_ratio: Any = math.inf,
) -> CollisionLaw:  # fmt: skip
    """The law of these arguments, as the solvers take them.

    ``restitution`` may be a CollisionLaw itself; the other three are its own then, and need not be
    given. Raises InputError for arguments out of range, and for a law that gains energy.
    """
    if not isinstance(restitution, CollisionLaw):
        et = tangential_restitution
        return CollisionLaw(restitution, et, dimension, mass_ratio=mass_ratio)
    law = restitution
    for name, value, default in (
        ("tangential_restitution", tangential_restitution, 1.0),
        ("dimension", dimension, 2),
        ("mass_ratio", mass_ratio, math.inf),
    ):
        if value is not None and value not in (default, getattr(law, name)):
            refuse(name, value, f"restitution is a law, in which it is {getattr(law, name)}")
    if law.least_loss < 0.0:
        largest = math.exp(-law.least_loss)
        raise InputError(
            f"restitution: got a law with speed ratios up to {largest:.6g}; the solvers need "
            "a tracer that never gains energy (ratios up to 1)"
        )
    return law


def law_in_medium(
    law: CollisionLaw, scatterers: Any, number_density: Any, diameter: Any, order: Any = "second"
) -> CollisionLaw:
    """The law among these scatterers; the law itself where they are dilute.

    Raises InputError for unknown names, for a density above 0.3 d^-2, and for laws for which the
    theory is not derived: rough scatterers, spheres, samples, mixtures, a finite mass ratio.
    """
    if law.mass_ratio < math.inf and scatterers in SCATTERERS[1:]:
        refuse(
            "mass_ratio", law.mass_ratio, f"with scatterers={scatterers!r} it must be inf: fixed"
        )
    smooth_disks = law.dimension == 2 and law.tangential_restitution == 1.0
    e = law.restitution if smooth_disks else None
    medium = checked_medium(e, scatterers, number_density, diameter, order)
    return law if medium is None else CollisionLaw(law.restitution, 1.0, 2, None, medium)
