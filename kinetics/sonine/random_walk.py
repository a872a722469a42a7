"""The random walk of Section 3.2 as printed: collision times, their number, <r^2>.

Lengths in d, speeds in U, times in d/U, number densities in d^-2. h(e) is the paper's fit
1.45 (1 - e) unless ``cooling_rate`` says otherwise, l its 13.5 d, v0(0) its sqrt(2) U. At e = 1,
where beta = 0, every function is its own limit (printed after eq. N): collisions at equal times.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from kinetics.sonine.first_order import (
    THERMAL_SPEED_START,
    collisions_per_length,
    cooling_rate_fitted,
)
from kinetics.validation import Array, not_negative, positive

FITTED_FREE_PATH = 13.5
"""Mean free path in d that the paper puts into eq. msd in place of 1/(2 d rho0) = 12.5 d."""


def alpha(start: ArrayLike = THERMAL_SPEED_START) -> Array:
    """The slowness alpha = 1/v0(0) (eq. ab), in 1/U."""
    return 1 / positive("start", start)


def beta(
    restitution: ArrayLike,
    number_density: float = 0.04,
    diameter: float = 1.0,
    cooling_rate: ArrayLike | None = None,
) -> Array:
    """The rate beta = d rho0 h(e) (eq. ab), in 1/d; h(e) by eq. hsimu unless it is given."""
    rho = collisions_per_length(number_density, diameter)
    fitted = cooling_rate_fitted(restitution)
    return rho * (fitted if cooling_rate is None else not_negative("cooling_rate", cooling_rate))


def collision_interval(
    time: ArrayLike,
    beta: ArrayLike,
    free_path: ArrayLike = FITTED_FREE_PATH,
    start: ArrayLike = THERMAL_SPEED_START,
) -> Array:
    """tau_N = l (alpha + beta t_(N-1)) after a collision at t_(N-1) (eq. taun, the first)."""
    slowness = alpha(start) + not_negative("beta", beta) * not_negative("time", time)
    return positive("free_path", free_path) * slowness


def collision_interval_number(
    collisions: ArrayLike,
    beta: ArrayLike,
    free_path: ArrayLike = FITTED_FREE_PATH,
    start: ArrayLike = THERMAL_SPEED_START,
) -> Array:
    """tau_N = l alpha (1 + l beta)^(N-1), N >= 0 (eq. taun, the second of that label)."""
    path = positive("free_path", free_path)
    growth = np.log1p(path * not_negative("beta", beta))
    number = not_negative("collisions", collisions)
    with np.errstate(over="ignore"):
        return path * alpha(start) * np.exp((number - 1) * growth)


def collision_time(
    collisions: ArrayLike,
    beta: ArrayLike,
    free_path: ArrayLike = FITTED_FREE_PATH,
    start: ArrayLike = THERMAL_SPEED_START,
) -> Array:
    """t_N = (alpha/beta) ((1 + l beta)^N - 1) (eq. tn); l alpha N for beta = 0."""
    path, rate = positive("free_path", free_path), not_negative("beta", beta)
    number = not_negative("collisions", collisions)
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        grown = np.expm1(number * np.log1p(path * rate)) / rate
    return alpha(start) * np.where(rate > 0, grown, path * number)


def collision_count(
    time: ArrayLike,
    beta: ArrayLike,
    free_path: ArrayLike = FITTED_FREE_PATH,
    start: ArrayLike = THERMAL_SPEED_START,
) -> Array:
    """N = ln(1 + beta t/alpha)/ln(1 + l beta) (eq. N); t/(alpha l) for beta = 0."""
    path, rate = positive("free_path", free_path), not_negative("beta", beta)
    scaled = not_negative("time", time) / alpha(start)
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
) -> Array:
    """Mean square displacement l^2 N of the random walk (eq. msd), in d^2."""
    rate = beta(restitution, number_density, diameter, cooling_rate)
    return positive("free_path", free_path) ** 2 * collision_count(time, rate, free_path, start)


def eta_random_walk(
    beta: ArrayLike, free_path: ArrayLike = FITTED_FREE_PATH, prefactor: ArrayLike = 1.0
) -> Array:
    """eta = 4 kappa ln(1 + l beta)/(l beta) (eq. etadif); kappa, undetermined, is ``prefactor``."""
    x = positive("free_path", free_path) * not_negative("beta", beta)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(x > 0, np.log1p(x) / x, 1.0)
    return 4 * positive("prefactor", prefactor) * ratio
