"""The paper's approximations as numbers: first Sonine order, random walk and G(R).

Every function is a transcription of a printed formula, named in its docstring by the paper's
LaTeX label (Kim and Hayakawa, "Statistical Properties of Inelastic Lorentz Gas"). Nothing here is
corrected and nothing here feeds the solvers: these are the curves that the reports hold against
the kinetic equation. Lengths are in scatterer diameters d, speeds in U, times in d/U, number
densities in d^-2. Arguments broadcast as numpy arrays; restitutions outside [0, 1] are not checked.
"""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

THERMAL_SPEED_START = math.sqrt(2.0)
"""v0(0) of the paper's Gaussian start, in U (eq. v0defi)."""

THRESHOLD_RESTITUTION = math.sqrt(-23 / 50 + 16 * math.sqrt(14) / 75)
"""Smallest restitution at which the printed a2 is real (eq. compare1)."""

FITTED_COOLING_FACTOR = 1.45
"""h(e) = 1.45 (1 - e), fitted by the paper to its particle data (eq. hsimu)."""

FITTED_FREE_PATH = 13.5
"""Mean free path in d that the paper puts into eq. msd in place of 1/(2 d rho0) = 12.5 d."""


def a2(restitution: ArrayLike, root: str = "stable") -> Array:
    """Second Sonine coefficient (eq. sonine11); the minus sign is the stable root (eq. sonine12).

    NaN below `THRESHOLD_RESTITUTION`, where the printed formula is complex.
    """
    if root not in ("stable", "unstable"):
        raise ValueError(f"root must be 'stable' or 'unstable', got {root!r}")
    e2 = np.square(np.asarray(restitution, dtype=float))
    sign = -1.0 if root == "stable" else 1.0
    return (1 + 30 * e2 + sign * _discriminant_root(e2)) / 24


def _discriminant_root(e2: Array) -> Array:
    """sqrt(-383 + 828 e^2 + 900 e^4), NaN where the radicand is negative."""
    radicand = -383 + 828 * e2 + 900 * e2**2
    return np.sqrt(np.where(radicand >= 0, radicand, np.nan))


def m2(restitution: ArrayLike, a2: ArrayLike) -> Array:
    """Second moment of the collision integral for given a2 (eq. sonine9)."""
    e = np.asarray(restitution, dtype=float)
    return math.sqrt(math.pi) * (1 - e**2) * (1 + 3 / 8 * np.asarray(a2, dtype=float))


def m4(restitution: ArrayLike, a2: ArrayLike) -> Array:
    """Fourth moment of the collision integral for given a2 (eq. sonine10)."""
    e = np.asarray(restitution, dtype=float)
    factor = math.sqrt(math.pi) * (1 - e**2) * (3 + 2 * e**2)
    return factor * (1 + 15 / 8 * np.asarray(a2, dtype=float))


def cooling_rate(restitution: ArrayLike) -> Array:
    """h(e) = M2/2 (eq. compare2) with M2 in closed form (eq. compare3); NaN below the threshold."""
    e2 = np.square(np.asarray(restitution, dtype=float))
    bracket = 65 / 64 + 15 / 32 * e2 - _discriminant_root(e2) / 64
    return math.sqrt(math.pi) * (1 - e2) * bracket / 2


def cooling_rate_fitted(restitution: ArrayLike) -> Array:
    """h(e) = 1.45 (1 - e) (eq. hsimu)."""
    return FITTED_COOLING_FACTOR * (1 - np.asarray(restitution, dtype=float))


def stability(restitution: ArrayLike, root: str = "stable") -> Array:
    """H(e) = 3 a2 - (15 e^2/4 + 1/8) (eq. ac7): negative where that root of a2 is stable."""
    e = np.asarray(restitution, dtype=float)
    return 3 * a2(e, root) - (15 / 4 * e**2 + 1 / 8)


def vdf(c: ArrayLike, a2: ArrayLike) -> Array:
    """Scaled VDF phi(c) (1 + a2 S2(c^2)) (eqs. sonine1, sonine2), a density in the plane.

    With a2 = 0 it is the Maxwell-Boltzmann distribution of the paper's Fig. scalev.
    """
    x = np.square(np.asarray(c, dtype=float))
    return np.exp(-x) / math.pi * (1 + np.asarray(a2, dtype=float) * (x**2 / 2 - 2 * x + 1))


def beta(restitution: ArrayLike, number_density: float = 0.04, diameter: float = 1.0) -> Array:
    """The rate beta = d rho0 h(e) (eq. ab) with the fitted h(e) (eq. hsimu), in 1/d."""
    return diameter * number_density * cooling_rate_fitted(restitution)


def thermal_speed(
    time: ArrayLike,
    cooling_rate: ArrayLike,
    number_density: float = 0.04,
    diameter: float = 1.0,
    start: float = THERMAL_SPEED_START,
) -> Array:
    """v0(t) = 1/(1/v0(0) + d rho0 h t) (eq. veq), in U."""
    h = np.asarray(cooling_rate, dtype=float)
    return 1 / (1 / start + diameter * number_density * h * np.asarray(time, dtype=float))


def msd_random_walk(
    time: ArrayLike,
    restitution: ArrayLike,
    number_density: float = 0.04,
    diameter: float = 1.0,
    free_path: float = FITTED_FREE_PATH,
    start: float = THERMAL_SPEED_START,
) -> Array:
    """Mean square displacement of the random walk (eq. msd), in d^2; l^2 N with N of eq. N."""
    b = beta(restitution, number_density, diameter)
    grown = np.log1p(b * start * np.asarray(time, dtype=float))
    # The elastic limit printed after eq. N: N -> t v0(0) / l.
    with np.errstate(invalid="ignore", divide="ignore"):
        collisions = np.where(
            b > 0,
            grown / np.log1p(free_path * b),
            np.asarray(time, dtype=float) * start / free_path,
        )
    return free_path**2 * collisions


def diffusion_rate(
    thermal_speed: ArrayLike,
    restitution: ArrayLike,
    a2: ArrayLike,
    number_density: float = 0.04,
    diameter: float = 1.0,
) -> Array:
    """nu_D of the first Sonine approximation (eq. ad6), with 2 T/m = v0^2, in U/d."""
    factor = diameter * number_density * (1 + np.asarray(restitution, dtype=float)) / 2
    speed = math.sqrt(math.pi) * np.asarray(thermal_speed, dtype=float)
    return factor * speed * (2 + 3 / 4 * np.asarray(a2, dtype=float))


def diffusion_coefficient(
    thermal_speed: ArrayLike,
    restitution: ArrayLike,
    a2: ArrayLike,
    number_density: float = 0.04,
    diameter: float = 1.0,
) -> Array:
    """D_e(t) of the first Sonine approximation (eq. ad7), with 2 T/m = v0^2, in d U."""
    e = np.asarray(restitution, dtype=float)
    speed = np.asarray(thermal_speed, dtype=float) / math.sqrt(math.pi)
    correction = 1 + 3 / 8 * np.asarray(a2, dtype=float)
    return speed / (diameter * number_density) / ((e + 1) ** 2 * correction)


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
    e = np.asarray(restitution, dtype=float)
    correction = 1 + 3 / 8 * a2(e)
    rho = diameter * number_density
    slow = math.sqrt(math.pi / 2) * rho * np.asarray(time, dtype=float)
    argument = slow * (1 - e**2) * correction
    # ln(1 + x)/x, so that the elastic limit, linear in time, is there too.
    growth = np.where(argument == 0, 1.0, np.log1p(argument) / np.where(argument == 0, 1, argument))
    return 8 / (math.pi * rho**2) * slow * growth / ((1 + e) ** 2 * correction)


def position_given_speed(r: ArrayLike, eta: float, speed: float) -> Array:
    """G(R, V) of one hopping speed V (eqs. posivel, peakg), normalised over R."""
    x = np.asarray(r, dtype=float)
    width = eta * speed**2
    return x / width * np.exp(-(x**2) / (2 * width))


def position_peak(r: ArrayLike, eta: float = 0.75) -> Array:
    """G(R) near its peak (eq. peakg) with the paper's eta and V = 1/sqrt(2)."""
    return position_given_speed(r, eta, 1 / math.sqrt(2))


def position_integral(r: ArrayLike, eta: float) -> Array:
    """G(R) of eq. gdefi, whose integral over V is (2R/eta) K0(R sqrt(2/eta)); normalised over R."""
    from scipy.special import k0

    x = np.asarray(r, dtype=float)
    argument = np.where(x > 0, x * math.sqrt(2 / eta), 1.0)
    return np.where(x > 0, 2 * x / eta * k0(argument), 0.0)


def position_tail(r: ArrayLike, eta: float = 0.25, gamma: float = 7.39) -> Array:
    """G(R) by steepest descent (eqs. pdefi, csolu, tailg) times the fitted gamma (eq. gammatailg).

    gamma = 1 gives eq. tailg. The defaults are the paper's fit. Needs R > 0.
    """
    x = np.asarray(r, dtype=float)
    v2 = -1 / 4 + np.sqrt(eta + 8 * x**2) / (4 * math.sqrt(eta))
    exponent = np.log(v2) / 2 + v2 + x**2 / (2 * eta * v2)
    curvature = (-1 / v2 + 2) / x**2 + 3 / (eta * v2**2)
    return 2 * gamma / eta * np.sqrt(math.pi / (2 * curvature)) * np.exp(-exponent)


def position_far_tail(r: ArrayLike, eta: float) -> Array:
    """G(R) in the limit of large R (eq. semig)."""
    x = np.asarray(r, dtype=float)
    return np.sqrt(math.pi * x / (2 * math.sqrt(2) * eta**1.5)) * np.exp(-math.sqrt(2 / eta) * x)
