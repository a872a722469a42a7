r"""The scaling solution in closed form: the moments, the cooling rate and the scaled VDF.

Multiply the paper's scaled equation (label ``ifmu2``) by c^p and integrate: with Y = v t/l the
scaling state obeys, for every complex z,

    lambda(z) E[Y^(z+1)] = z E[Y^z],        E[Y] = 1/kappa.

E[Y^n] is therefore a finite product, which gives the cooling rate and a2. The moments between the
integers and F(c), by Mellin inversion, are in :mod:`kinetics.scaling.mellin`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kinetics.collision import CollisionLaw
from kinetics.scaling import mellin
from kinetics.validation import check_restitution, exponent, not_negative, refuse
from kinetics.values import Value

_EXPONENT_LIMIT = 300.0  # of moments: near it they leave the range of doubles for small e
_LARGEST_LOG = 709.0  # of a double


@dataclass(frozen=True)
class ScalingSolution(Value):
    """The self-similar cooling state of the inelastic Lorentz gas, exactly.

    Parameters
    ----------
    restitution : e in [0, 1]

    Raises
    ------
    InputError (a ValueError) : restitution outside [0, 1] or not a number

    At e = 1 nothing cools and no scaling state is approached: ``cooling_rate`` is 0, ``a2`` and
    ``moment`` are the limits e -> 1 (a ring: -1/2 and 1), ``diffusion_slope`` is infinite, and
    :meth:`vdf` raises.

    >>> exact = ScalingSolution(0.0)
    >>> bool(abs(exact.cooling_rate - 2**0.5) < 1e-15), bool(abs(exact.a2 - 2) < 1e-14)
    (True, True)
    """

    restitution: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "restitution", check_restitution(self.restitution))

    @cached_property
    def law(self) -> CollisionLaw:
        """The collision law of this restitution."""
        return CollisionLaw(self.restitution)

    @cached_property
    def cooling_rate(self) -> float:
        """h(e) = M2/2 = 2 sqrt(kappa lambda(1)), dimensionless (paper, label ``compare2``)."""
        if self.restitution == 1.0:
            return 0.0
        return 2.0 * math.sqrt(self.law.mean_log_loss * float(self.law.decay_rate(1.0)))

    @cached_property
    def a2(self) -> float:
        """<c^4>/2 - 1 of the exact F (paper, label ``sonine5``); it exists for every e."""
        if self.restitution == 1.0:
            return -0.5
        law = self.law
        rates = law.decay_rate(np.array([1.0, 2.0, 3.0]))
        return float(3.0 * law.mean_log_loss * rates[0] / (rates[1] * rates[2]) - 1.0)

    @cached_property
    def diffusion_slope(self) -> float:
        """Limit of d<r^2>/d ln t in units of l^2: 2/[kappa (1 - <cos chi>)]."""
        if self.restitution == 1.0:
            return math.inf
        return 2.0 / (self.law.mean_log_loss * self.law.harmonic_decay_rate(0.0, 1))

    @property
    def tail_rate(self) -> float:
        """2/h: F(c) ~ c^tail_power exp(-tail_rate c) at high c; infinite at e = 1."""
        return math.inf if self.restitution == 1.0 else 2.0 / self.cooling_rate

    @property
    def tail_power(self) -> float:
        """1/(1-e^2) - 2, the power of c before the exponential tail; infinite at e = 1."""
        if self.restitution == 1.0:
            return math.inf
        return 1.0 / ((1.0 - self.restitution) * (1.0 + self.restitution)) - 2.0

    @cached_property
    def log_tail_amplitude(self) -> float:
        """ln A in F(c) ~ A c^tail_power exp(-tail_rate c), to 1e-10; InputError at e = 1.

        With b = 1/(1-e^2), E[Y^p]/Gamma(p+b) tends to 2 pi A (h/2)^b.
        """
        self._check_inelastic()
        log_y = mellin.log_growth_constant(self.law, self.tail_power + 2.0)
        b = self.tail_power + 2.0
        return log_y + b * math.log(self.tail_rate) - math.log(2.0 * math.pi)

    def moment(self, p: float) -> float:
        """<c^p> for real p, |p| <= 300 (p > -1 at e = 0), with <c^0> = <c^2> = 1.

        Raises InputError for other p, and where the moment overflows.
        """
        p = self._check_exponent(p)
        if self.restitution == 1.0:
            return 1.0
        # <c^p> = E[Y^p]/E[Y^2]^(p/2) and E[Y^p] = kappa^-p A(p): the powers of kappa cancel
        log_moment = self._log_a(p) - 0.5 * p * mellin.log_second_moment(self.law)
        if log_moment > _LARGEST_LOG:
            refuse("p", p, "<c^p> overflows double precision there")
        return math.exp(log_moment)

    def scaled_speed_moment(self, p: float) -> float:
        """E[Y^p], the limit of <(v t/l)^p>; p and errors as in :meth:`moment`. 0 < e < 1 or e = 0.

        Raises InputError at e = 1, where v t has no limit.
        """
        p = self._check_exponent(p)
        if self.restitution == 1.0:
            refuse("restitution", 1.0, "v t has no limit law in the elastic gas")
        return math.exp(self._log_a(p) - p * math.log(self.law.mean_log_loss))

    def vdf(self, c: ArrayLike) -> Any:
        """F(c), the scaled velocity distribution; same shape as c.

        Normalised in the plane: integral of 2 pi c F(c) dc = 1 and <c^2> = 1. Relative error
        below 1e-12 wherever F is not below 1e-280; near e = 1, where F is a ring of width
        sqrt(1 - e), what the rounding of c makes, some 1e-16/sqrt(1 - e). F(0) is 0
        for 0 < e < 1 (a hole) and infinite at e = 0, where F = exp(-sqrt(2) c)/(sqrt(2) pi c).

        Raises
        ------
        InputError : c negative or not finite; e = 1, where F is the ring delta(c - 1)/(2 pi)
        """
        c_ = not_negative("c", c)
        self._check_inelastic()
        if self.restitution == 0.0:
            with np.errstate(divide="ignore"):
                return (np.exp(-math.sqrt(2.0) * c_) / (math.sqrt(2.0) * math.pi * c_))[()]
        flat = c_.ravel()
        out = np.zeros_like(flat)
        inside = flat > 0.0
        # x = ln(kappa y), y = c sqrt(E[Y^2]); the density of x is that whose exponents are A(z)
        x = np.log(flat[inside]) + 0.5 * mellin.log_second_moment(self.law)
        with np.errstate(under="ignore"):
            log_f = mellin.log_density(self.law, x) - 2.0 * np.log(flat[inside])
            out[inside] = np.exp(log_f) / (2.0 * math.pi)
        return out.reshape(c_.shape)[()]

    def _log_a(self, p: float) -> float:
        """ln A(p), A(p) = kappa^p E[Y^p]."""
        return float(mellin.log_moment(self.law, np.array([p]))[0])

    def _check_inelastic(self) -> None:
        if self.restitution == 1.0:
            refuse("restitution", 1.0, "the scaled VDF exists for 0 <= e < 1 only")

    def _check_exponent(self, p: float) -> float:
        number = exponent("p", p, _EXPONENT_LIMIT)
        if self.restitution == 0.0 and number <= -1.0:
            refuse("p", p, "at restitution 0 moments exist for p > -1 only")
        return number
