"""The exact theory as numbers: quadrature over the impact parameter in mpmath, no closed form.

These are the numbers that stand beside the paper's, and the independent route by which the tests
hold the closed forms of :mod:`derivations.closed_forms`. The mean free path is the unit of length.
"""

from __future__ import annotations

from functools import cache
from typing import TypeAlias

import mpmath as mp

DIGITS = 30
Restitution: TypeAlias = "float | str | mp.mpf"


def _average(weight: str | None, power: mp.mpf, restitution: Restitution) -> mp.mpf:
    """E[w s^power] with w = 1, or ln s, or v'.v/v^2; nodes split where s leaves e."""
    e = mp.mpf(restitution)

    def integrand(y: mp.mpf) -> mp.mpf:
        square = e**2 + (1 - e**2) * y * y
        value = square ** (power / 2)
        if weight == "log":
            value *= mp.log(square) / 2
        elif weight == "parallel":
            value *= -e + (1 + e) * y * y
        return value

    points = [0, *(x for x in (e / 4, e, 4 * e) if 0 < x < mp.mpf(1) / 2), 1]
    return mp.quad(integrand, points)


def loss_value(order: float | mp.mpf, restitution: Restitution) -> mp.mpf:
    """lambda(p) = 1 - E[s^p] at the working precision of mpmath."""
    return 1 - _average(None, mp.mpf(order), restitution)


def log_loss_value(restitution: Restitution) -> mp.mpf:
    """The mean log loss kappa = E[-ln s] at the working precision of mpmath."""
    return -_average("log", mp.mpf(0), restitution)


def flux_loss_value(order: float | mp.mpf, restitution: Restitution) -> mp.mpf:
    """1 - E[s^p cos chi]: the loss of a moment of v^p times the direction of v."""
    return 1 - _average("parallel", mp.mpf(order) - 1, restitution)


def mean_cosine_value(restitution: Restitution) -> mp.mpf:
    """The mean cosine of the deflection angle at the working precision of mpmath."""
    return 1 - flux_loss_value(0, restitution)


@cache
def cooling_rate_value(restitution: float | str) -> mp.mpf:
    """h(e) = 2 sqrt(kappa lambda(1)) to 30 digits."""
    with mp.workdps(DIGITS):
        return 2 * mp.sqrt(log_loss_value(restitution) * loss_value(1, restitution))


@cache
def a2_value(restitution: float | str) -> mp.mpf:
    """The exact a_2 = <c^4>/2 - 1 to 30 digits, from E[Y^(n+1)] = n E[Y^n]/lambda(n)."""
    with mp.workdps(DIGITS):
        kappa = log_loss_value(restitution)
        first, second, third = (loss_value(k, restitution) for k in (1, 2, 3))
        fourth = 6 / (kappa * first * second * third)
        return fourth * (kappa * first) ** 2 / 2 - 1


@cache
def diffusion_slope_value(restitution: float | str) -> mp.mpf:
    """d<r^2>/d ln t in units of l^2, to 30 digits: 2/(kappa (1 - <cos chi>))."""
    with mp.workdps(DIGITS):
        return 2 / (log_loss_value(restitution) * (1 - mean_cosine_value(restitution)))


def mean_scaled_speed_value(restitution: float | str) -> mp.mpf:
    """<c> of the scaling solution, to 30 digits: E[Y]/sqrt(E[Y^2]) = sqrt(lambda(1)/kappa)."""
    with mp.workdps(DIGITS):
        return mp.sqrt(loss_value(1, restitution) / log_loss_value(restitution))
