"""The exact theory as numbers: quadrature over the impact parameter in mpmath, no closed form.

These are the numbers that stand beside the paper's, and the independent route by which the tests
hold the closed forms of :mod:`derivations.derived.scaling_state`. The unit of length is the mean
free path.
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


@cache
def moment_value(order: int, restitution: Restitution, digits: int = DIGITS) -> mp.mpf:
    """<c^n> of the scaling solution, n >= 0, from E[Y^(n+1)] = n E[Y^n]/lambda(n)."""
    with mp.workdps(digits):
        speed = [mp.mpf(1), 1 / log_loss_value(restitution)]
        for n in range(1, max(order, 2)):
            speed.append(n * speed[n] / loss_value(n, restitution))
        return speed[order] / speed[2] ** (mp.mpf(order) / 2)


@cache
def cooling_rate_value(restitution: Restitution, digits: int = DIGITS) -> mp.mpf:
    """h(e) = 2 sqrt(kappa lambda(1))."""
    with mp.workdps(digits):
        return 2 * mp.sqrt(log_loss_value(restitution) * loss_value(1, restitution))


def a2_value(restitution: Restitution, digits: int = DIGITS) -> mp.mpf:
    """The exact a_2 = <c^4>/2 - 1."""
    with mp.workdps(digits):
        return moment_value(4, restitution, digits) / 2 - 1


@cache
def diffusion_slope_value(restitution: Restitution, digits: int = DIGITS) -> mp.mpf:
    """d<r^2>/d ln t in units of l^2: 2/(kappa (1 - <cos chi>))."""
    with mp.workdps(digits):
        return 2 / (log_loss_value(restitution) * flux_loss_value(0, restitution))
