"""The exact scaling solution: moments, cooling rate, tails, limits. Beyond the paper."""

from __future__ import annotations

from functools import cache

import mpmath as mp

DIGITS = 30


def loss_value(order: float | mp.mpf, restitution: float | str | mp.mpf) -> mp.mpf:
    """lambda(p) = 1 - E[s^p] by quadrature over the impact parameter, at the working precision."""
    ratio = mp.mpf(restitution)
    power = mp.mpf(order) / 2
    return 1 - mp.quad(lambda y: (ratio**2 + (1 - ratio**2) * y * y) ** power, [0, 1])


def log_loss_value(restitution: float | str | mp.mpf) -> mp.mpf:
    """The mean log loss kappa = E[-ln s] by quadrature over the impact parameter."""
    ratio = mp.mpf(restitution)
    return -mp.quad(lambda y: mp.log(ratio**2 + (1 - ratio**2) * y * y) / 2, [0, 1])


@cache
def cooling_rate_value(restitution: float | str) -> mp.mpf:
    """h(e) = 2 sqrt(kappa lambda(1)), by quadrature."""
    with mp.workdps(DIGITS):
        return 2 * mp.sqrt(log_loss_value(restitution) * loss_value(1, restitution))


@cache
def a2_value(restitution: float | str) -> mp.mpf:
    """The exact a_2 = <c^4>/2 - 1, from E[Y^n] = (n-1)!/(kappa lambda(1) ... lambda(n-1))."""
    with mp.workdps(DIGITS):
        kappa = log_loss_value(restitution)
        first, second, third = (loss_value(k, restitution) for k in (1, 2, 3))
        fourth = 6 / (kappa * first * second * third)
        return fourth * (kappa * first) ** 2 / 2 - 1


@cache
def diffusion_slope_value(restitution: float | str) -> mp.mpf:
    """d<r^2>/d ln t in units of l^2: 2/(kappa (1 - <cos chi>)), by quadrature."""
    with mp.workdps(DIGITS):
        ratio = mp.mpf(restitution)

        def cosine(y: mp.mpf) -> mp.mpf:
            return (-ratio + (1 + ratio) * y * y) / mp.sqrt(ratio**2 + (1 - ratio**2) * y * y)

        return 2 / (log_loss_value(restitution) * (1 - mp.quad(cosine, [0, 1])))


def mean_scaled_speed_value(restitution: float | str) -> mp.mpf:
    """<c> of the scaling solution: E[Y]/sqrt(E[Y^2]) = sqrt(lambda(1)/kappa)."""
    with mp.workdps(DIGITS):
        return mp.sqrt(loss_value(1, restitution) / log_loss_value(restitution))
