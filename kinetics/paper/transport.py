"""The random walk (Section 3.2) and the diffusion (Appendices C and D) of the paper, as printed.

Lengths in d, speeds in U, times in d/U, number densities in d^-2, diffusion coefficients in d U.
In the random walk h(e) is the paper's fit 1.45 (1 - e) unless ``cooling_rate`` says otherwise, l
its 13.5 d, v0(0) its sqrt(2) U. At e = 1, where beta = 0, every function is its own limit (printed
after eq. N): collisions at equal times.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from kinetics.numerics import FloatArray
from kinetics.paper.first_order import THERMAL_SPEED_START, a2, cooling_rate_fitted, numbers

FITTED_FREE_PATH = 13.5
"""Mean free path in d that the paper puts into eq. msd in place of 1/(2 d rho0) = 12.5 d."""

# -- the random walk -------------------------------------------------------------------------------


def alpha(start: ArrayLike = THERMAL_SPEED_START) -> FloatArray:
    """The slowness alpha = 1/v0(0) (eq. ab), in 1/U."""
    return 1 / numbers(start)


def beta(
    restitution: ArrayLike,
    number_density: float = 0.04,
    diameter: float = 1.0,
    cooling_rate: ArrayLike | None = None,
) -> FloatArray:
    """The rate beta = d rho0 h(e) (eq. ab), in 1/d; h(e) by eq. hsimu unless it is given."""
    h = cooling_rate_fitted(restitution) if cooling_rate is None else numbers(cooling_rate)
    return diameter * number_density * h


def collision_interval(
    time: ArrayLike,
    beta: ArrayLike,
    free_path: ArrayLike = FITTED_FREE_PATH,
    start: ArrayLike = THERMAL_SPEED_START,
) -> FloatArray:
    """tau_N = l (alpha + beta t_(N-1)) after a collision at t_(N-1) (eq. taun, the first)."""
    return numbers(free_path) * (alpha(start) + numbers(beta) * numbers(time))


def collision_interval_number(
    collisions: ArrayLike,
    beta: ArrayLike,
    free_path: ArrayLike = FITTED_FREE_PATH,
    start: ArrayLike = THERMAL_SPEED_START,
) -> FloatArray:
    """tau_N = l alpha (1 + l beta)^(N-1), N >= 0 (eq. taun, the second of that label)."""
    path = numbers(free_path)
    with np.errstate(over="ignore"):
        grown = np.exp((numbers(collisions) - 1) * np.log1p(path * numbers(beta)))
        return path * alpha(start) * grown


def collision_time(
    collisions: ArrayLike,
    beta: ArrayLike,
    free_path: ArrayLike = FITTED_FREE_PATH,
    start: ArrayLike = THERMAL_SPEED_START,
) -> FloatArray:
    """t_N = (alpha/beta) ((1 + l beta)^N - 1) (eq. tn); l alpha N for beta = 0."""
    path, rate, number = numbers(free_path), numbers(beta), numbers(collisions)
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        grown = np.expm1(number * np.log1p(path * rate)) / rate
    return alpha(start) * np.where(rate > 0, grown, path * number)


def collision_count(
    time: ArrayLike,
    beta: ArrayLike,
    free_path: ArrayLike = FITTED_FREE_PATH,
    start: ArrayLike = THERMAL_SPEED_START,
) -> FloatArray:
    """N = ln(1 + beta t/alpha)/ln(1 + l beta) (eq. N); t/(alpha l) for beta = 0."""
    path, rate, scaled = numbers(free_path), numbers(beta), numbers(time) / alpha(start)
    with np.errstate(divide="ignore", invalid="ignore"):
        number = np.log1p(rate * scaled) / np.log1p(path * rate)
    return np.where(rate > 0, number, scaled / path)


def msd_random_walk(
    time: ArrayLike,
    restitution: ArrayLike,
    number_density: float = 0.04,
    diameter: float = 1.0,
    free_path: float = FITTED_FREE_PATH,
    start: float = THERMAL_SPEED_START,
    cooling_rate: ArrayLike | None = None,
) -> FloatArray:
    """Mean square displacement l^2 N of the random walk (eq. msd), in d^2."""
    rate = beta(restitution, number_density, diameter, cooling_rate)
    return free_path**2 * collision_count(time, rate, free_path, start)


def eta_random_walk(
    beta: ArrayLike, free_path: ArrayLike = FITTED_FREE_PATH, prefactor: ArrayLike = 1.0
) -> FloatArray:
    """eta = 4 kappa ln(1 + l beta)/(l beta) (eq. etadif); kappa, undetermined, is ``prefactor``."""
    x = numbers(free_path) * numbers(beta)
    with np.errstate(divide="ignore", invalid="ignore"):
        return 4 * numbers(prefactor) * np.where(x > 0, np.log1p(x) / x, 1.0)


# -- Chapman-Enskog, first Sonine approximation ----------------------------------------------------


def diffusion_from_rates(
    temperature_over_mass: ArrayLike, diffusion_rate: ArrayLike, energy_loss_rate: ArrayLike
) -> FloatArray:
    """D_e = (T/m)/(nu_D - xi/2) (eq. diffuse21), in d U; NaN where nu_D <= xi/2.

    T/m = v0^2/2 in U^2, nu_D in U/d (see :func:`diffusion_rate`), and xi = 2 d v0 rho0 h(e), the
    rate at which the temperature falls, in U/d.
    """
    rate = numbers(diffusion_rate) - numbers(energy_loss_rate) / 2
    return numbers(temperature_over_mass) / np.where(rate > 0, rate, np.nan)


def diffusion_rate(
    thermal_speed: ArrayLike,
    restitution: ArrayLike,
    a2: ArrayLike,
    number_density: float = 0.04,
    diameter: float = 1.0,
) -> FloatArray:
    """nu_D of the first Sonine approximation (eq. ad6), with 2 T/m = v0^2, in U/d."""
    factor = diameter * number_density * (1 + numbers(restitution)) / 2
    return factor * math.sqrt(math.pi) * numbers(thermal_speed) * (2 + 3 / 4 * numbers(a2))


def diffusion_coefficient(
    thermal_speed: ArrayLike,
    restitution: ArrayLike,
    a2: ArrayLike,
    number_density: float = 0.04,
    diameter: float = 1.0,
) -> FloatArray:
    """D_e(t) of the first Sonine approximation (eq. ad7), with 2 T/m = v0^2, in d U."""
    slowing = (numbers(restitution) + 1) ** 2 * (1 + 3 / 8 * numbers(a2))
    return numbers(thermal_speed) / math.sqrt(math.pi) / (diameter * number_density) / slowing


def msd_of_diffusion(
    time: ArrayLike, coefficient: Callable[[float], float], as_printed: bool = True
) -> FloatArray:
    """<r^2> = 4 times the integral of D_e from 0 to t (eq. ad8, the first of that label), in d^2.

    ``coefficient(t)`` gives D_e in d U at a time in d/U. The printed integrand is D_e(t), not
    D_e(t'), which makes <r^2> = 4 t D_e(t). ``as_printed=False`` integrates D_e(t').
    """
    from scipy.integrate import quad

    times = numbers(time)
    if as_printed:
        return 4 * times * np.vectorize(coefficient, otypes=[float])(times)

    def integral(t: float) -> float:
        # in logarithmic time, so that D ~ 1/t costs no more late than early
        return float(
            quad(
                lambda u: coefficient(math.expm1(u)) * math.exp(u),
                0,
                math.log1p(t),
                epsabs=0,
                epsrel=1e-12,
                limit=200,
            )[0]
        )

    return 4 * np.vectorize(integral, otypes=[float])(times)


def msd_sonine(
    time: ArrayLike, restitution: ArrayLike, number_density: float = 0.04, diameter: float = 1.0
) -> FloatArray:
    """Mean square displacement of the first Sonine approximation (eq. ad8), in d^2.

    The label ad8 stands twice in the paper; this is the second one, with the stable a2. NaN below
    `THRESHOLD_RESTITUTION`.
    """
    e, rho = numbers(restitution), diameter * number_density
    correction = 1 + 3 / 8 * a2(e)
    slow = math.sqrt(math.pi / 2) * rho * numbers(time)
    argument = slow * (1 - e**2) * correction
    # ln(1 + x)/x, so that the elastic limit, linear in time, is there too
    growth = np.where(argument == 0, 1.0, np.log1p(argument) / np.where(argument == 0, 1, argument))
    return 8 / (math.pi * rho**2) * slow * growth / ((1 + e) ** 2 * correction)


# -- the coefficient at one speed ------------------------------------------------------------------


def diffusion_at_hopping_speed(
    hopping_speed: ArrayLike,
    time: ArrayLike,
    beta: ArrayLike,
    free_path: ArrayLike = FITTED_FREE_PATH,
    start: ArrayLike = THERMAL_SPEED_START,
    prefactor: ArrayLike = 1.0,
) -> FloatArray:
    """D_e(V, t) = kappa V^2 l/(alpha + beta t) (eqs. ddif and ap21.5), in d U.

    V is the scaled hopping speed (eq. L); kappa, which the paper leaves open, is ``prefactor``.
    """
    slowness = alpha(start) + numbers(beta) * numbers(time)
    return numbers(prefactor) * numbers(hopping_speed) ** 2 * numbers(free_path) / slowness


def diffusion_at_speed(
    speed: ArrayLike,
    thermal_speed: ArrayLike,
    cooling_rate: ArrayLike,
    free_path: ArrayLike = FITTED_FREE_PATH,
    diffusion_rate: ArrayLike | None = None,
) -> FloatArray:
    """D_e(v, t) = (v^2/2)/(h v0/(2 l) + nu_D) (eq. ap21, first form), in d U.

    Without ``diffusion_rate`` (in U/d) nu_D is v0/l, which the paper assumes for its last form.
    """
    v0, path = numbers(thermal_speed), numbers(free_path)
    nu = v0 / path if diffusion_rate is None else numbers(diffusion_rate)
    return numbers(speed) ** 2 / 2 / (numbers(cooling_rate) * v0 / (2 * path) + nu)


def diffusion_at_speed_scaling(
    speed: ArrayLike, thermal_speed: ArrayLike, free_path: ArrayLike = FITTED_FREE_PATH
) -> FloatArray:
    """v^2 l/v0(t) (eq. ap21, last form, printed with ~: without its number), in d U."""
    return numbers(speed) ** 2 * numbers(free_path) / numbers(thermal_speed)
