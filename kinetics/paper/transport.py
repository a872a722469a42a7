"""The random walk (Section 3.2) and the diffusion (Appendices C and D) of the paper, as printed.

Lengths in d, speeds in U, times in d/U, number densities in d^-2, diffusion coefficients in d U.
In the random walk h(e) is the paper's fit 1.45 (1 - e) unless ``cooling_rate`` says otherwise, l
its 13.5 d, v0(0) its sqrt(2) U. At e = 1, where beta = 0, every function is its own limit (printed
after eq. N): collisions at equal times.
"""

from __future__ import annotations

import math

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


def msd_random_walk(
    time: ArrayLike,
    restitution: ArrayLike,
    number_density: float = 0.04,
    diameter: float = 1.0,
    free_path: float = FITTED_FREE_PATH,
    start: float = THERMAL_SPEED_START,
    cooling_rate: ArrayLike | None = None,
) -> FloatArray:
    """Mean square displacement l^2 N of the random walk (eq. msd), in d^2.

    N = ln(1 + beta t/alpha)/ln(1 + l beta) (eq. N); t/(alpha l) for beta = 0.
    """
    rate = beta(restitution, number_density, diameter, cooling_rate)
    scaled = numbers(time) / alpha(start)
    with np.errstate(divide="ignore", invalid="ignore"):
        number = np.log1p(rate * scaled) / np.log1p(free_path * rate)
    return free_path**2 * np.where(rate > 0, number, scaled / free_path)


# -- Chapman-Enskog, first Sonine approximation ----------------------------------------------------


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
