"""The collision law as averages: the only thing that the solvers ask of a collision.

The kinetic equation needs of one collision the averages E[s^p cos(m chi)] in the plane, and
E[s^p P_m(cos chi)] in space, with s the speed ratio and chi the deflection. Whatever scales with
the speed is such a law: a weighted sum of bounces. Among scatterers at a finite density the same
averages decide, see `kinetics.collision.medium`. Begin with :class:`CollisionLaw`.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kinetics.collision.bounce import Bounce, DiskBounce, SampledBounce
from kinetics.collision.medium import Medium
from kinetics.collision.quadrature import NumberArray, Numbers
from kinetics.collision.weighted_bounces import WeightedBounces
from kinetics.errors import InputError, short
from kinetics.numerics import FloatArray
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

#: Smallest value that the larger of e and et may have. Chosen: below, every bounce stops a tracer.
MIN_LARGER_RESTITUTION = 1e-8
#: Largest |m| of a harmonic. Chosen: far beyond what any density needs.
MAX_HARMONIC = 1_000_000
#: The defaults of arguments of a law, which its text leaves out.
DEFAULTS: dict[str, object] = {
    "tangential_restitution": 1.0,
    "dimension": 2,
    "mass_ratio": math.inf,
}


@stored_class
@dataclass(frozen=True)
class CollisionLaw(WeightedBounces):
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

    Raises
    ------
    InputError
        An argument is out of range.

    Notes
    -----
    Other laws are made by :meth:`from_samples` and :meth:`mixture`; their ``restitution`` and
    ``tangential_restitution`` are None. That of a scene at a finite density has a ``medium``: rates
    of decay are then those of the medium, and all else is of one collision.

    All results are dimensionless, with a relative accuracy of 1e-13 or better for every e and et;
    for complex p that of E[s^p] is relative to E[s^(Re p)], and rounding of e leaves
    1e-16 (A + 1/A).

    Examples
    --------
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
        self._set(
            dimension=whole_number("dimension", self.dimension, 2, 3),
            mass_ratio=check_mass_ratio(self.mass_ratio),
        )
        if self._mixed is not None:
            self._set(bounces=self._mixed)
            return
        e = check_restitution(self.restitution)
        et = _check_tangential_restitution(self.tangential_restitution, e)
        if et != 1.0 and self.mass_ratio < math.inf:
            allowed = f"at tangential_restitution {short(et)} it must be inf: fixed scatterers"
            refuse("mass_ratio", self.mass_ratio, allowed)
        effective = _of_fixed_scatterer(e, self.mass_ratio)
        bounce = DiskBounce(effective, et, self.dimension)
        self._set(restitution=e, tangential_restitution=et, bounces=((1.0, bounce),))

    def _set(self, **values: object) -> None:
        """Set fields while the object is made, past the lock of a frozen dataclass."""
        for name, value in values.items():
            object.__setattr__(self, name, value)

    @classmethod
    def from_samples(
        cls, weight: ArrayLike, ratio: ArrayLike, cosine: ArrayLike, dimension: int = 2
    ) -> CollisionLaw:
        """Return a law of one's own: a random restitution, or measured bounces.

        Parameters
        ----------
        weight : of each sample, not negative, sum 1, shape (n_samples,), up to 20,000 of them
        ratio : speed after the bounce over the speed before, above 0. The solvers refuse ratios
            above 1: they need a tracer that never gains energy
        cosine : cosine of the deflection, from -1 to 1. A law must not prefer left or right: in the
            plane the deflection takes both signs with equal chance, in space every azimuth
        dimension : 2 or 3

        Raises
        ------
        InputError
            The samples are no law.

        Examples
        --------
        >>> half = CollisionLaw.from_samples([0.5, 0.5], [0.9, 0.4], [0.0, 0.0])
        >>> round(float(half.mean_speed_ratio_power(2.0)), 12)
        0.485
        """
        dimension = whole_number("dimension", dimension, 2, 3)
        samples = SampledBounce.checked(weight, ratio, cosine, dimension)
        return cls(None, None, dimension, ((1.0, samples),))

    @classmethod
    def mixture(cls, weights: ArrayLike, laws: Sequence[CollisionLaw]) -> CollisionLaw:
        """Return the law of collisions that each follow one of several laws, drawn anew.

        Such are a random restitution, or scatterers of several kinds.

        Parameters
        ----------
        weights : the chance of each law at a collision, above 0, up to a common factor, (n_laws,).
            For kinds of scatterers it is in proportion to number density times cross section
        laws : of one dimension, each of any form, without a medium

        Raises
        ------
        InputError
            The weights or the laws are not such.

        Examples
        --------
        >>> mixed = CollisionLaw.mixture([1, 3], [CollisionLaw(0.5), CollisionLaw(0.9)])
        >>> bool(abs(mixed.decay_rate(2) - 2 / 3 * (1 - (0.5**2 + 3 * 0.9**2) / 4)) < 1e-15)
        True
        """
        mixed = list(laws) if isinstance(laws, Sequence) else []
        are_usable = [isinstance(law, CollisionLaw) and law.medium is None for law in mixed]
        if not mixed or not all(are_usable) or len({law.dimension for law in mixed}) > 1:
            refuse("laws", laws, "give a list of CollisionLaw of one dimension, without a medium")
        w = finite_line("weights", weights)
        if w.size != len(mixed) or np.any(w <= 0.0):
            refuse("weights", weights, f"it must be {len(mixed)} numbers above 0, one for each law")
        chances = (w / w.sum()).tolist()
        bounces = []
        for chance, law in zip(chances, mixed, strict=True):
            for share, bounce in law.bounces:
                bounces.append((chance * share, bounce))
        # those that may stop a tracer come first
        bounces.sort(key=lambda weighted: -weighted[1].lowest_power)
        return cls(None, None, mixed[0].dimension, tuple(bounces))

    # -- what is shown ----------------------------------------------------------------------------

    def __repr__(self) -> str:
        if self._mixed is None:
            return f"CollisionLaw({self.described})"
        (_, first), *others = self._mixed
        if others or isinstance(first, DiskBounce):
            return f"CollisionLaw.mixture({1 + len(others)} laws, dimension={self.dimension})"
        n_samples = len(first.weight)
        return f"CollisionLaw.from_samples({n_samples} samples, dimension={self.dimension})"

    @property
    def described(self) -> str:
        """The arguments, for texts; those that have their defaults are left out."""
        if self._mixed is not None:
            return f"restitution={self!r}"
        shown = []
        for name, value in self.arguments.items():
            if value != DEFAULTS.get(name):
                shown.append(f"{name}={value!r}")
        if self.medium is not None:
            shown.append(f"scatterers={self.medium.scatterers!r}")
        return ", ".join(shown)

    @property
    def arguments(self) -> dict[str, Any]:
        """What :func:`law_of` makes this law of; ``restitution`` is the law itself without one."""
        restitution = self.restitution
        return {
            "restitution": self if restitution is None else restitution,
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
        if self.restitution is None:
            return None
        return _of_fixed_scatterer(self.restitution, self.mass_ratio)

    @cached_property
    def lowest_power(self) -> float:
        """E[s^p] exists for Re p above it: -inf, but where s comes as near to 0 as one likes.

        There it is -1 for smooth disks, -2 for spheres and for et = 0; in a medium perhaps higher.
        """
        lowest = max(bounce.lowest_power for _, bounce in self.bounces)
        if self.medium is None:
            return lowest
        return max(lowest, self.medium.lowest_power(self.quadrature))

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
        """Return l = 1/(2 d rho) among disks, 1/(pi d^2 rho) among spheres, or that of the medium.

        It is 0 or infinite where it is beyond the range of doubles.
        """
        cross_section = 2.0 * diameter
        if self.dimension == 3:
            cross_section = math.pi * diameter * diameter
        rate = cross_section * number_density
        ratio = 1.0
        if self.medium is not None:
            ratio = self.medium.path_ratio
        if ratio < rate * sys.float_info.max:
            return ratio / rate
        return math.inf

    # -- averages ---------------------------------------------------------------------------------

    def mean_speed_ratio_power(self, p: ArrayLike) -> Any:
        """Return E[s^p], of the shape of p, a float for a real number.

        Parameters
        ----------
        p : real or complex powers, above :attr:`lowest_power`

        Raises
        ------
        InputError
            p is not finite or too low, or E[s^p] overflows.
        """
        powers = self._checked_powers(p)
        q = self.quadrature_for(powers)
        with np.errstate(over="ignore", invalid="ignore"):
            mean = np.exp(-np.multiply.outer(powers, q.log_loss)) @ q.weight
            mean = mean + self._ratio_power_beyond(powers)
        if not np.all(np.isfinite(mean)):
            refuse("p", p, "E[s^p] overflows double precision there")
        return mean[()]

    def decay_rate(self, p: ArrayLike) -> Any:
        """Return lambda(p) = 1 - E[s^p], of the shape of p: d<v^p>/dt = -lambda(p) <v^(p+1)>/l.

        That is of the isotropic part. Errors are as of :meth:`mean_speed_ratio_power`.
        """
        return self.harmonic_decay_rate(p, 0)

    def harmonic_decay_rate(self, p: ArrayLike, m: int) -> Any:
        """Return 1 - E[s^p cos(m chi)]: how fast the moment of v^p exp(i m phi) is lost, in v/l.

        In space cos(m chi) is P_m(cos chi). Errors are as of :meth:`mean_speed_ratio_power`.
        """
        m = whole_number("m", m, -MAX_HARMONIC, MAX_HARMONIC)
        powers = self._checked_powers(p)
        with np.errstate(over="ignore", invalid="ignore"):
            rate = self.decay_symbol(powers, m)
        if not np.all(np.isfinite(rate)):
            refuse("p", p, "E[s^p] overflows double precision there")
        return rate[()]

    def decay_symbol(self, z: Numbers, m: int = 0) -> Numbers:
        """Return lambda_m(z), shape of z; without checks of the range, for inner loops."""
        return self.met_again(z, self.lost(z, m), m)

    def decay_rates(
        self, z: Numbers, offsets: NumberArray, orders: int
    ) -> tuple[NumberArray, list[NumberArray]]:
        """Return lambda(z + d) for many offsets d at once, and its Taylor series at the last d.

        Parameters
        ----------
        z : real or complex, shape (n_z,)
        offsets : real or complex, shape (n_d,)
        orders : how many orders of the Taylor series, from 0 on

        Returns
        -------
        lambda(z + d), shape (n_z, n_d), accurate relative to 1 + |lambda|; and its Taylor
        coefficients at z + the last d, each (n_z,)
        """
        points = z[:, None] + offsets
        q = self.quadrature_for(points)
        # 1 - s^(z + d) = (1 - s^z) s^d + 1 - s^d: a product of matrices in place of exponentials
        exponent = np.multiply.outer(q.log_loss, offsets)
        kept = q.weight[:, None] * np.exp(-exponent)
        slopes = kept[:, -1:] * np.cumprod(-q.log_loss[:, None] / np.arange(1.0, orders), axis=1)
        products = q.losses(z) @ np.hstack([kept, slopes])
        of_kept = products[:, : offsets.size]
        of_slopes = products[:, offsets.size :]
        rate = of_kept - q.weight @ np.expm1(-exponent) + self._loss_beyond(points)
        higher = of_slopes - slopes.sum(axis=0)
        taylor = [rate[:, -1]]
        taylor.extend(higher.T)
        return self.met_again(points, rate, 0), self.taylor_met_again(points[:, -1], taylor, 0)

    def decay_taylor(self, z: Numbers, orders: int) -> list[Numbers]:
        """Return Taylor coefficients of lambda at z (n,), of the orders 0 to orders - 1, (n,)."""
        _, taylor = self.decay_rates(z, np.zeros(1), orders)
        return taylor

    def _checked_powers(self, p: ArrayLike) -> FloatArray:
        """Return the powers, which may be complex; InputError where E[s^p] does not exist."""
        powers = number_array("p", p, "iufc", "it must be a number or an array of numbers")
        if not np.all(np.isfinite(powers)):
            refuse("p", p, "it must be finite")
        if np.any(powers.real < 0.0) and np.any(powers.real <= self.lowest_power):
            refuse("p", p, f"it must be above {self.lowest_power:g} for this law")
        return powers

    # -- returns to the scatterer before, in a medium ----------------------------------------------

    def returns(self, m: int) -> tuple[float, float]:
        """Return eps (-1)^m and x = -ln e of the bounces straight back; 0 where none comes."""
        if self.medium is None:
            return 0.0, 0.0
        return self.medium.returns(m)

    def met_again(self, z: Numbers, rate: Numbers, m: int) -> Numbers:
        """Return lambda_m at z with returns to the scatterer before, from that without."""
        with_returns = self.taylor_met_again(z, [rate], m)
        return with_returns[0]

    def taylor_met_again(self, z: Numbers, rate: list[Numbers], m: int) -> list[Numbers]:
        """Return Taylor coefficients of lambda_m with returns from those without, at z."""
        if self.medium is None:
            return rate
        return self.medium.met_again(z, rate, m)


def _check_tangential_restitution(value: object, e: float) -> float:
    """Return et; InputError if it is out of range, or every bounce would stop the tracer."""
    allowed = "it must be a number from 0 (all tangential velocity lost) to 1 (smooth)"
    et = real_number("tangential_restitution", value, 0.0, 1.0, allowed)
    if max(e, et) < MIN_LARGER_RESTITUTION:
        allowed = f"at restitution {short(e)} it must be {MIN_LARGER_RESTITUTION:g} or more"
        refuse("tangential_restitution", value, allowed)
    return et


def _of_fixed_scatterer(restitution: float, mass_ratio: float) -> float:
    """Return e of the fixed scatterer that leaves the tracer the same velocity."""
    if mass_ratio == math.inf:
        return restitution
    return (restitution * mass_ratio - 1.0) / (mass_ratio + 1.0)


def law_of(
    restitution: float | CollisionLaw,
    tangential_restitution: float | None = 1.0,
    dimension: int = 2,
    mass_ratio: float = math.inf,
) -> CollisionLaw:
    """Return the law of these arguments, as the solvers take them.

    Parameters
    ----------
    restitution : e, or a CollisionLaw itself; the others, its own then, need not be given
    tangential_restitution, dimension, mass_ratio : as of :class:`CollisionLaw`

    Raises
    ------
    InputError
        An argument is out of range or contradicts the law, or the law gains energy.
    """
    if not isinstance(restitution, CollisionLaw):
        return CollisionLaw(restitution, tangential_restitution, dimension, mass_ratio=mass_ratio)
    law = restitution
    _check_agrees(law, "tangential_restitution", tangential_restitution)
    _check_agrees(law, "dimension", dimension)
    _check_agrees(law, "mass_ratio", mass_ratio)
    if law.least_loss < 0.0:
        largest = math.exp(-law.least_loss)
        reason = "the solvers need a tracer that never gains energy (ratios up to 1)"
        raise InputError(f"restitution: got a law with speed ratios up to {largest:.6g}; {reason}")
    return law


def _check_agrees(law: CollisionLaw, name: str, value: object) -> None:
    """Raise InputError for an argument beside a law that is neither by default nor as its own."""
    of_law = law.arguments[name]
    if value is not None and value not in (DEFAULTS[name], of_law):
        refuse(name, value, f"restitution is a law, in which it is {of_law}")


def law_in_medium(
    law: CollisionLaw,
    scatterers: str,
    number_density: float | None,
    diameter: float,
    order: str = "second",
) -> CollisionLaw:
    """Return the law among these scatterers, itself where they are dilute.

    Parameters and errors are those of :meth:`kinetics.collision.medium.Medium.checked`.
    """
    medium = Medium.checked(law, scatterers, number_density, diameter, order)
    return law if medium is None else replace(law, medium=medium)
