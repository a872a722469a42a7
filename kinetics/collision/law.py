"""The collision law as averages: the only thing that the solvers ask of a collision.

The kinetic equation needs of one collision the averages E[s^p cos(m chi)] in the plane, and
E[s^p P_m(cos chi)] in space, with s the speed ratio and chi the deflection. Whatever scales with
the speed is such a law: a weighted sum of bounces. Among scatterers at a finite density the same
averages decide, see `kinetics.collision.medium`.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics.collision.bounce import Bounce, Collision, DiskBounce, SampledBounce
from kinetics.collision.medium import Medium
from kinetics.errors import InputError, short
from kinetics.results.record import stored_class
from kinetics.validation import (
    check_mass_ratio,
    check_restitution,
    finite_line,
    number_array,
    real_number,
    refuse,
    whole_number,
)

_LEAST_RATIO = 1e-8  # of speeds: if none is larger, every bounce stops the tracer


@stored_class
@dataclass(frozen=True)
class CollisionLaw(Collision):
    """The bounce off a fixed disk or sphere, averaged over a uniform impact parameter.

    Parameters
    ----------
    restitution : e in [0, 1], by which the normal velocity is multiplied (and turned round)
    tangential_restitution : et in [0, 1], by which the tangential velocity is multiplied; 1 for
        smooth scatterers. Not both may be below 1e-8: the tracer would stop at its first bounce
    dimension : 2 (disks in the plane) or 3 (spheres)
    mass_ratio : A, the mass of a scatterer over that of the tracer, 1e-6 or more; inf: fixed. A
        finite one is of smooth scatterers at rest that are met once each, ``restitution`` that of
        the relative velocity; elsewhere e then stands for ``effective_restitution``

    Other laws are made by :meth:`from_samples` and :meth:`mixture`; their ``restitution`` and
    ``tangential_restitution`` are None. That of a scene at a finite density has a ``medium``: rates
    of decay are then those of the medium, and all else is of one collision.

    All results are dimensionless, with a relative accuracy of 1e-13 or better for every e and et;
    for complex p that of E[s^p] is relative to E[s^(Re p)], and rounding of e leaves
    1e-16 (A + 1/A). Raises InputError for arguments out of range.

    >>> law = CollisionLaw(restitution=0.7)
    >>> bool(abs(law.decay_rate(2) - 2 / 3 * (1 - 0.7**2)) < 1e-15)
    True
    """

    restitution: float | None
    tangential_restitution: float | None = 1.0
    dimension: int = 2
    # the chance of each bounce, if they are not that of the arguments; and anyway
    _mixed: tuple[tuple[float, Bounce], ...] | None = field(default=None, repr=False)
    medium: Medium | None = field(default=None, repr=False)
    mass_ratio: float = math.inf
    bounces: tuple[tuple[float, Bounce], ...] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        made = vars(self)  # past the lock of a frozen dataclass
        made["dimension"] = whole_number("dimension", self.dimension, 2, 3)
        made["mass_ratio"] = check_mass_ratio(self.mass_ratio)
        if self._mixed is not None:
            made["bounces"] = self._mixed
            return
        e = made["restitution"] = check_restitution(self.restitution)
        allowed = "it must be a number from 0 (all tangential velocity lost) to 1 (smooth)"
        value = self.tangential_restitution
        et = real_number("tangential_restitution", value, 0.0, 1.0, allowed)
        made["tangential_restitution"] = et
        if max(e, et) < _LEAST_RATIO:
            allowed = f"at restitution {short(e)} it must be {_LEAST_RATIO:g} or more"
            refuse("tangential_restitution", value, allowed)
        if et != 1.0 and self.mass_ratio < math.inf:
            allowed = f"at tangential_restitution {short(et)} it must be inf: fixed scatterers"
            refuse("mass_ratio", self.mass_ratio, allowed)
        effective = self.effective_restitution
        assert effective is not None
        made["bounces"] = ((1.0, DiskBounce(effective, et, self.dimension)),)

    @classmethod
    def from_samples(
        cls, weight: ArrayLike, ratio: ArrayLike, cosine: ArrayLike, dimension: int = 2
    ) -> CollisionLaw:
        """A law of one's own: a random restitution, or measured bounces.

        weight : of each sample, not negative, sum 1, shape (n_samples,), up to 20,000 of them
        ratio : speed after the bounce over the speed before, above 0. The solvers refuse ratios
            above 1: they need a tracer that never gains energy
        cosine : cosine of the deflection, from -1 to 1. A law must not prefer left or right: in the
            plane the deflection takes both signs with equal chance, in space every azimuth

        >>> half = CollisionLaw.from_samples([0.5, 0.5], [0.9, 0.4], [0.0, 0.0])
        >>> float(half.mean_speed_ratio_power(2.0))
        0.485
        """
        dimension = whole_number("dimension", dimension, 2, 3)
        samples = SampledBounce.checked(weight, ratio, cosine, dimension)
        return cls(None, None, dimension, ((1.0, samples),))

    @classmethod
    def mixture(cls, weights: ArrayLike, laws: Sequence[CollisionLaw]) -> CollisionLaw:
        """Each collision follows one of the laws, drawn anew: a random restitution, or scatterers
        of several kinds.

        weights : the chance of each law at a collision, above 0, up to a common factor, (n_laws,).
            For kinds of scatterers it is in proportion to number density times cross section
        laws : of one dimension, each of any form, without a medium

        >>> mixed = CollisionLaw.mixture([1, 3], [CollisionLaw(0.5), CollisionLaw(0.9)])
        >>> bool(abs(mixed.decay_rate(2) - 2 / 3 * (1 - (0.5**2 + 3 * 0.9**2) / 4)) < 1e-15)
        True
        """
        given = list(laws) if isinstance(laws, Sequence) else []
        good = [isinstance(law, CollisionLaw) and law.medium is None for law in given]
        if not (good and all(good)) or len({law.dimension for law in given}) > 1:
            refuse("laws", laws, "give a list of CollisionLaw of one dimension, without a medium")
        w = finite_line("weights", weights)
        if w.size != len(given) or np.any(w <= 0.0):
            refuse("weights", weights, f"it must be {len(given)} numbers above 0, one for each law")
        shares = zip((w / w.sum()).tolist(), given, strict=True)
        found = [(share * part, bounce) for share, law in shares for part, bounce in law.bounces]
        found.sort(key=lambda one: -one[1].lowest_power)  # those that may stop a tracer come first
        return cls(None, None, given[0].dimension, tuple(found))

    def __repr__(self) -> str:
        if self._mixed is None:
            return f"CollisionLaw({self.described})"
        (_, first), *others = self._mixed
        if others or isinstance(first, DiskBounce):
            return f"CollisionLaw.mixture({1 + len(others)} laws, dimension={self.dimension})"
        count = len(first.weight)
        return f"CollisionLaw.from_samples({count} samples, dimension={self.dimension})"

    @property
    def described(self) -> str:
        """The arguments, for texts; those that have their defaults are left out."""
        if self._mixed is not None:
            return f"restitution={self!r}"
        default = {"tangential_restitution": 1.0, "dimension": 2, "mass_ratio": math.inf}
        shown = {n: x for n, x in self.arguments.items() if x != default.get(n)}
        if self.medium is not None:
            shown["scatterers"] = self.medium.scatterers
        return ", ".join(f"{name}={value!r}" for name, value in shown.items())

    @property
    def arguments(self) -> dict[str, Any]:
        """What :func:`law_of` makes this law of; ``restitution`` is the law itself without one."""
        return {
            "restitution": self if self._mixed is not None else self.restitution,
            "tangential_restitution": self.tangential_restitution,
            "dimension": self.dimension,
            "mass_ratio": self.mass_ratio,
        }

    # -- what kind of law it is -------------------------------------------------------------------

    @property
    def effective_restitution(self) -> float | None:
        """e of the fixed scatterer that leaves the tracer the same velocity, -1 < e <= 1.

        1 + e = (1 + restitution) A/(1 + A), A the mass ratio. Below 0 the tracer goes on behind the
        scatterer that it has hit. None for samples and mixtures.
        """
        if self.restitution is None or self.mass_ratio == math.inf:
            return self.restitution
        return (self.restitution * self.mass_ratio - 1.0) / (self.mass_ratio + 1.0)

    @cached_property
    def lowest_power(self) -> float:
        """E[s^p] exists for Re p above it: -inf, but where s comes as near to 0 as one likes.

        There it is -1 for smooth disks, -2 for spheres and for et = 0; in a medium perhaps higher.
        """
        lowest = max(part.lowest_power for _, part in self.bounces)
        if self.medium is not None:
            lowest = max(lowest, self.medium.lowest_power(self.quadrature))
        return lowest

    @property
    def uniform_power(self) -> float | None:
        """q = d - 1 where s^q is uniform on [0, 1], at smooth scatterers with e = 0; else None."""
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
        """l = 1/(2 d rho) among disks, 1/(pi d^2 rho) among spheres, or that of the medium.

        0 or infinite where it is beyond the range of doubles.
        """
        across = 2.0 * diameter if self.dimension == 2 else math.pi * diameter * diameter
        rate = across * number_density
        ratio = 1.0 if self.medium is None else self.medium.path_ratio
        return ratio / rate if ratio < rate * sys.float_info.max else math.inf

    # -- averages ---------------------------------------------------------------------------------

    def mean_speed_ratio_power(self, p: ArrayLike) -> Any:
        """E[s^p], of the shape of p, a float for a real number; p may be complex."""
        p_ = self._exponents(p)
        q = self.quadrature_for(p_)
        with np.errstate(over="ignore", invalid="ignore"):
            mean = np.exp(-np.multiply.outer(p_, q.log_loss)) @ q.weight + self._beyond(p_)
        if not np.all(np.isfinite(mean)):
            refuse("p", p, "E[s^p] overflows double precision there")
        return mean[()]

    def decay_rate(self, p: ArrayLike) -> Any:
        """lambda(p) = 1 - E[s^p], so that d<v^p>/dt = -lambda(p) <v^(p+1)>/l (isotropic part)."""
        return self.harmonic_decay_rate(p, 0)

    def harmonic_decay_rate(self, p: ArrayLike, m: int) -> Any:
        """1 - E[s^p cos(m chi)]: how fast the moment of v^p exp(i m phi) is lost, in v/l.

        In space cos(m chi) is P_m(cos chi).
        """
        m = whole_number("m", m, -1_000_000, 1_000_000)
        p_ = self._exponents(p)
        with np.errstate(over="ignore", invalid="ignore"):
            rate = self.decay_symbol(p_, m)
        if not np.all(np.isfinite(rate)):
            refuse("p", p, "E[s^p] overflows double precision there")
        return rate[()]

    def decay_symbol(self, z: NDArray[Any], m: int = 0) -> NDArray[Any]:
        """lambda_m(z), shape of z; without checks of the range, for inner loops."""
        return self.met_again(z, self.lost(z, m), m)

    def decay_rates(
        self, z: NDArray[Any], offsets: NDArray[Any], orders: int
    ) -> tuple[NDArray[Any], list[NDArray[Any]]]:
        """lambda(z + d) for z (n_z,) and d (n_d,), shape (n_z, n_d), relative to 1 + |lambda|; and
        at the last d its Taylor coefficients, of the orders 0 to orders - 1, each (n_z,).
        """
        at = z[:, None] + offsets
        q = self.quadrature_for(at)
        # 1 - s^(z + d) = (1 - s^z) s^d + 1 - s^d: a product of matrices in place of exponentials
        rest = np.multiply.outer(q.log_loss, offsets)
        kept = q.weight[:, None] * np.exp(-rest)
        slopes = kept[:, -1:] * np.cumprod(-q.log_loss[:, None] / np.arange(1.0, orders), axis=1)
        both = q.losses(z) @ np.hstack([kept, slopes])
        rate = both[:, : offsets.size] - q.weight @ np.expm1(-rest) + self._beyond(at, lost=True)
        taylor = [rate[:, -1], *(both[:, offsets.size :] - slopes.sum(axis=0)).T]
        return self.met_again(at, rate, 0), self.taylor_met_again(at[:, -1], taylor, 0)

    def decay_taylor(self, z: NDArray[Any], orders: int) -> list[NDArray[Any]]:
        """Taylor coefficients of lambda at z (n,), of the orders 0 to orders - 1, each (n,)."""
        return self.decay_rates(z, np.zeros(1), orders)[1]

    # -- returns to the scatterer before, in a medium ----------------------------------------------

    def returns(self, m: int) -> tuple[float, float]:
        """eps (-1)^m, and x = -ln e, of the bounces straight back; both are 0 where none comes."""
        return (0.0, 0.0) if self.medium is None else self.medium.returns(m)

    def met_again(self, z: NDArray[Any], rate: NDArray[Any], m: int) -> NDArray[Any]:
        """lambda_m at z with returns to the scatterer before, from that without; shape of z."""
        return self.taylor_met_again(z, [rate], m)[0]

    def taylor_met_again(self, z: Any, rate: list[NDArray[Any]], m: int) -> list[NDArray[Any]]:
        """The same for Taylor coefficients of lambda_m at z, each of the shape of z."""
        return rate if self.medium is None else self.medium.met_again(z, rate, m)

    def _exponents(self, p: ArrayLike) -> NDArray[Any]:
        p_ = number_array("p", p, "iufc", "it must be a number or an array of numbers")
        if not np.all(np.isfinite(p_)):
            refuse("p", p, "it must be finite")
        if np.any(p_.real < 0.0) and np.any(p_.real <= self.lowest_power):
            refuse("p", p, f"it must be above {self.lowest_power:g} for this law")
        return p_


def law_of(
    restitution: Any, tangential_restitution: Any = 1.0, dimension: Any = 2,
    mass_ratio: Any = math.inf,
) -> CollisionLaw:  # fmt: skip
    """The law of these arguments, as the solvers take them.

    ``restitution`` may be a CollisionLaw itself; the others, its own then, need not be given.
    Raises InputError for arguments out of range, and for a law that gains energy.
    """
    if not isinstance(restitution, CollisionLaw):
        return CollisionLaw(restitution, tangential_restitution, dimension, mass_ratio=mass_ratio)
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
        what = "the solvers need a tracer that never gains energy (ratios up to 1)"
        raise InputError(f"restitution: got a law with speed ratios up to {largest:.6g}; {what}")
    return law


def law_in_medium(
    law: CollisionLaw, scatterers: Any, number_density: Any, diameter: Any, order: Any = "second"
) -> CollisionLaw:
    """The law among these scatterers, itself where they are dilute; see :meth:`Medium.checked`."""
    medium = Medium.checked(law, scatterers, number_density, diameter, order)
    return law if medium is None else replace(law, medium=medium)
