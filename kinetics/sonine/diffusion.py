"""Diffusion as the paper prints it: Chapman-Enskog (Appendix C) and at one speed (Appendix D).

Lengths in d, speeds in U, times in d/U, number densities in d^-2, diffusion coefficients in d U.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from kinetics.sonine.first_order import THERMAL_SPEED_START, a2, collisions_per_length
from kinetics.sonine.random_walk import FITTED_FREE_PATH, alpha
from kinetics.validation import Array, not_negative, positive, real_array, refuse, restitutions


def diffusion_from_rates(
    temperature_over_mass: ArrayLike, diffusion_rate: ArrayLike, energy_loss_rate: ArrayLike
) -> Array:
    """D_e = (T/m)/(nu_D - xi/2) (eq. diffuse21), in d U.

    T/m = v0^2/2 in U^2, nu_D in U/d (see :func:`diffusion_rate`), and xi = 2 d v0 rho0 h(e), the
    rate at which the temperature falls, in U/d. NaN where nu_D <= xi/2.
    """
    rate = (
        real_array("diffusion_rate", diffusion_rate)
        - real_array("energy_loss_rate", energy_loss_rate) / 2
    )
    square = not_negative("temperature_over_mass", temperature_over_mass)
    return square / np.where(rate > 0, rate, np.nan)


def diffusion_rate(
    thermal_speed: ArrayLike,
    restitution: ArrayLike,
    a2: ArrayLike,
    number_density: float = 0.04,
    diameter: float = 1.0,
) -> Array:
    """nu_D of the first Sonine approximation (eq. ad6), with 2 T/m = v0^2, in U/d."""
    factor = collisions_per_length(number_density, diameter) * (1 + restitutions(restitution)) / 2
    speed = math.sqrt(math.pi) * not_negative("thermal_speed", thermal_speed)
    return factor * speed * (2 + 3 / 4 * real_array("a2", a2))


def diffusion_coefficient(
    thermal_speed: ArrayLike,
    restitution: ArrayLike,
    a2: ArrayLike,
    number_density: float = 0.04,
    diameter: float = 1.0,
) -> Array:
    """D_e(t) of the first Sonine approximation (eq. ad7), with 2 T/m = v0^2, in d U."""
    e = restitutions(restitution)
    speed = not_negative("thermal_speed", thermal_speed) / math.sqrt(math.pi)
    correction = 1 + 3 / 8 * real_array("a2", a2)
    return speed / collisions_per_length(number_density, diameter) / ((e + 1) ** 2 * correction)


def msd_of_diffusion(
    time: ArrayLike, coefficient: Callable[[float], float], as_printed: bool = True
) -> Array:
    """<r^2> = 4 times the integral of D_e from 0 to t (eq. ad8, the first of that label), in d^2.

    ``coefficient(t)`` gives D_e in d U at a time in d/U. The printed integrand is D_e(t), not
    D_e(t'), which makes <r^2> = 4 t D_e(t). ``as_printed=False`` integrates D_e(t').
    """
    from scipy.integrate import quad

    if not callable(coefficient):
        refuse("coefficient", coefficient, "it must be a function of the time")
    times = not_negative("time", time)
    if as_printed:
        values = [float(coefficient(float(t))) for t in times.flat]
        return 4 * times * np.reshape(values, times.shape)
    out = np.empty(times.size)
    order = np.argsort(times, axis=None)
    start = total = 0.0
    for k in order:
        stop = float(times.flat[k])
        if stop > start:
            # in logarithmic time, so that D ~ 1/t costs no more late than early
            span = math.log1p(stop) - math.log1p(start)

            def integrand(u: float, start: float = start) -> float:
                t = math.expm1(u + math.log1p(start))
                return float(coefficient(t)) * (1 + t)

            total += quad(integrand, 0, span, epsabs=0, epsrel=1e-12, limit=200)[0]
            start = stop
        out[k] = 4 * total
    return out.reshape(times.shape)


def msd_sonine(
    time: ArrayLike,
    restitution: ArrayLike,
    number_density: float = 0.04,
    diameter: float = 1.0,
) -> Array:
    """Mean square displacement of the first Sonine approximation (eq. ad8), in d^2.

    The label ad8 stands twice in the paper; this is the second one, with the stable a2. NaN below
    `THRESHOLD_RESTITUTION`.
    """
    e = restitutions(restitution)
    correction = 1 + 3 / 8 * a2(e)
    rho = collisions_per_length(number_density, diameter)
    slow = math.sqrt(math.pi / 2) * rho * not_negative("time", time)
    argument = slow * (1 - e**2) * correction
    # ln(1 + x)/x, so that the elastic limit, linear in time, is there too.
    growth = np.where(argument == 0, 1.0, np.log1p(argument) / np.where(argument == 0, 1, argument))
    return 8 / (math.pi * rho**2) * slow * growth / ((1 + e) ** 2 * correction)


def diffusion_at_hopping_speed(
    hopping_speed: ArrayLike,
    time: ArrayLike,
    beta: ArrayLike,
    free_path: ArrayLike = FITTED_FREE_PATH,
    start: ArrayLike = THERMAL_SPEED_START,
    prefactor: ArrayLike = 1.0,
) -> Array:
    """D_e(V, t) = kappa V^2 l/(alpha + beta t) (eqs. ddif and ap21.5), in d U.

    V is the scaled hopping speed (eq. L); kappa, which the paper leaves open, is ``prefactor``.
    """
    square = np.square(not_negative("hopping_speed", hopping_speed))
    slowness = alpha(start) + not_negative("beta", beta) * not_negative("time", time)
    return positive("prefactor", prefactor) * square * positive("free_path", free_path) / slowness


def diffusion_at_speed(
    speed: ArrayLike,
    thermal_speed: ArrayLike,
    cooling_rate: ArrayLike,
    free_path: ArrayLike = FITTED_FREE_PATH,
    diffusion_rate: ArrayLike | None = None,
) -> Array:
    """D_e(v, t) = (v^2/2)/(h v0/(2 l) + nu_D) (eq. ap21, first form), in d U.

    Without ``diffusion_rate`` (in U/d) nu_D is v0/l, which the paper assumes for its last form.
    """
    v0, path = positive("thermal_speed", thermal_speed), positive("free_path", free_path)
    nu = v0 / path if diffusion_rate is None else positive("diffusion_rate", diffusion_rate)
    loss = not_negative("cooling_rate", cooling_rate) * v0 / (2 * path)
    return np.square(not_negative("speed", speed)) / 2 / (loss + nu)


def diffusion_at_speed_scaling(
    speed: ArrayLike, thermal_speed: ArrayLike, free_path: ArrayLike = FITTED_FREE_PATH
) -> Array:
    """v^2 l/v0(t) (eq. ap21, last form, printed with ~: without its number), in d U."""
    square = np.square(not_negative("speed", speed))
    return square * positive("free_path", free_path) / positive("thermal_speed", thermal_speed)
