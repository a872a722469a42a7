"""The scaled state in the paper's first Sonine approximation, and its law of cooling, as printed.

(Appendix B and Section 3.2.) Dimensionless but for :func:`thermal_speed`.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from kinetics.numerics import FloatArray

THERMAL_SPEED_START = math.sqrt(2.0)
"""v0(0) of the paper's Gaussian start, in U (eq. v0defi)."""

THRESHOLD_RESTITUTION = math.sqrt(-23 / 50 + 16 * math.sqrt(14) / 75)
"""Smallest restitution at which the printed a2 is real (eq. compare1)."""

FITTED_COOLING_FACTOR = 1.45
"""h(e) = 1.45 (1 - e), fitted by the paper to its particle data (eq. hsimu)."""


def numbers(value: ArrayLike) -> FloatArray:
    """The argument of a formula as an array of doubles."""
    return np.asarray(value, dtype=float)


def _discriminant_root(e2: FloatArray) -> FloatArray:
    """sqrt(-383 + 828 e^2 + 900 e^4), NaN where the radicand is negative."""
    radicand = -383 + 828 * e2 + 900 * e2**2
    return np.sqrt(np.where(radicand >= 0, radicand, np.nan))


def a2(restitution: ArrayLike, root: str = "stable") -> FloatArray:
    """Second Sonine coefficient (eq. sonine11); the minus sign is the stable root (eq. sonine12).

    NaN below `THRESHOLD_RESTITUTION`, where the printed formula is complex. root: "stable" or
    "unstable".
    """
    e2 = numbers(restitution) ** 2
    sign = {"stable": -1.0, "unstable": 1.0}[root]
    return (1 + 30 * e2 + sign * _discriminant_root(e2)) / 24


def m2(restitution: ArrayLike, a2: ArrayLike) -> FloatArray:
    """Second moment of the collision integral for given a2 (eq. sonine9)."""
    return math.sqrt(math.pi) * (1 - numbers(restitution) ** 2) * (1 + 3 / 8 * numbers(a2))


def m4(restitution: ArrayLike, a2: ArrayLike) -> FloatArray:
    """Fourth moment of the collision integral for given a2 (eq. sonine10)."""
    e2 = numbers(restitution) ** 2
    return math.sqrt(math.pi) * (1 - e2) * (3 + 2 * e2) * (1 + 15 / 8 * numbers(a2))


def cooling_rate(restitution: ArrayLike) -> FloatArray:
    """h(e) = M2/2 (eq. compare2) with M2 in closed form (eq. compare3); NaN below the threshold."""
    e2 = numbers(restitution) ** 2
    bracket = 65 / 64 + 15 / 32 * e2 - _discriminant_root(e2) / 64
    return math.sqrt(math.pi) * (1 - e2) * bracket / 2


def cooling_rate_fitted(
    restitution: ArrayLike, factor: ArrayLike = FITTED_COOLING_FACTOR
) -> FloatArray:
    """h(e) = 1.45 (1 - e) (eq. hsimu)."""
    return numbers(factor) * (1 - numbers(restitution))


def stability(
    restitution: ArrayLike, root: str = "stable", coefficient: ArrayLike | None = None
) -> FloatArray:
    """H(e) = 3 a2 - (15 e^2/4 + 1/8) (eq. ac7): negative where that root of a2 is stable.

    ``coefficient`` is another a2, used instead of the printed root.
    """
    e = numbers(restitution)
    used = a2(e, root) if coefficient is None else numbers(coefficient)
    return 3 * used - (15 / 4 * e**2 + 1 / 8)


def vdf(c: ArrayLike, a2: ArrayLike) -> FloatArray:
    """Scaled VDF phi(c) (1 + a2 S2(c^2)) (eqs. sonine1, sonine2), a density in the plane.

    With a2 = 0 it is the Maxwell-Boltzmann distribution of the paper's Fig. scalev.
    """
    x = numbers(c) ** 2
    with np.errstate(under="ignore"):
        return np.exp(-x) / math.pi * (1 + numbers(a2) * (x**2 / 2 - 2 * x + 1))


def thermal_speed(
    time: ArrayLike,
    cooling_rate: ArrayLike,
    number_density: float = 0.04,
    diameter: float = 1.0,
    start: float = THERMAL_SPEED_START,
) -> FloatArray:
    """v0(t) = 1/(1/v0(0) + d rho0 h t) (eq. veq), in U."""
    return 1 / (1 / start + diameter * number_density * numbers(cooling_rate) * numbers(time))
