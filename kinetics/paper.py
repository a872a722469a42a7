"""The paper's approximations as numbers: Sonine, Chapman-Enskog, random walk and G(R).

Kim and Hayakawa, "Statistical Properties of Inelastic Lorentz Gas". Each printed formula is a
function whose docstring gives its LaTeX label. The solvers use nothing of this: reports compare
these curves with the kinetic equation. Also known as `kinetics.sonine`.

Lengths in d, speeds in U, times in d/U, number densities in d^-2, diffusion coefficients in d U.
Arguments are numbers or arrays that broadcast. They are not checked: outside its range a formula is
NaN. In the random walk h(e) is the paper's fit 1.45 (1 - e) unless ``cooling_rate`` says otherwise,
l its 13.5 d, v0(0) its sqrt(2) U. At e = 1 every function is its own limit. Begin with :func:`a2`.
"""

from __future__ import annotations

import math
import warnings

import numpy as np
from numpy.typing import ArrayLike

from kinetics.numerics import LARGEST_LOG, FloatArray

# -- the scaled state in the first Sonine approximation, and its cooling (Appendix B) --------------

#: v0(0) of the paper's Gaussian start, in U (eq. v0defi).
THERMAL_SPEED_START = math.sqrt(2.0)

#: Smallest restitution at which the printed a2 is real (eq. compare1).
THRESHOLD_RESTITUTION = math.sqrt(-23 / 50 + 16 * math.sqrt(14) / 75)

#: h(e) = 1.45 (1 - e), fitted by the paper to its particle data (eq. hsimu).
FITTED_COOLING_FACTOR = 1.45

#: Sign of the square root in a2 (eqs. sonine11, sonine12).
SIGN_OF_ROOT = {"stable": -1.0, "unstable": 1.0}


def numbers(value: ArrayLike) -> FloatArray:
    """Return the argument of a formula as an array of doubles."""
    return np.asarray(value, dtype=float)


def _discriminant_root(e2: FloatArray) -> FloatArray:
    """Return sqrt(-383 + 828 e^2 + 900 e^4), NaN where the radicand is negative.

    A curve may begin where the branch does, but no value at all is said to be none.
    """
    radicand = -383 + 828 * e2 + 900 * e2**2
    if radicand.size and np.all(radicand < 0):
        warnings.warn(
            f"restitution: the Sonine branch has no real root below {THRESHOLD_RESTITUTION:.4f}, "
            "so the printed formula gives NaN; ScalingSolution has the exact value",
            stacklevel=3,
        )
    return np.sqrt(np.where(radicand >= 0, radicand, np.nan))


def a2(restitution: ArrayLike, root: str = "stable") -> FloatArray:
    """Return the second Sonine coefficient (eq. sonine11).

    Parameters
    ----------
    restitution : e
    root : "stable" (the minus sign, eq. sonine12) or "unstable"

    Returns
    -------
    NaN below `THRESHOLD_RESTITUTION`, where the printed formula is complex
    """
    e2 = numbers(restitution) ** 2
    sign = SIGN_OF_ROOT[root]
    return (1 + 30 * e2 + sign * _discriminant_root(e2)) / 24


def m2(restitution: ArrayLike, a2: ArrayLike) -> FloatArray:
    """Return the second moment of the collision integral for given a2 (eq. sonine9)."""
    return math.sqrt(math.pi) * (1 - numbers(restitution) ** 2) * (1 + 3 / 8 * numbers(a2))


def m4(restitution: ArrayLike, a2: ArrayLike) -> FloatArray:
    """Return the fourth moment of the collision integral for given a2 (eq. sonine10)."""
    e2 = numbers(restitution) ** 2
    return math.sqrt(math.pi) * (1 - e2) * (3 + 2 * e2) * (1 + 15 / 8 * numbers(a2))


def cooling_rate(restitution: ArrayLike) -> FloatArray:
    """Return h(e) = M2/2 (eq. compare2) with M2 in closed form (eq. compare3).

    NaN below `THRESHOLD_RESTITUTION`.
    """
    e2 = numbers(restitution) ** 2
    bracket = 65 / 64 + 15 / 32 * e2 - _discriminant_root(e2) / 64
    return math.sqrt(math.pi) * (1 - e2) * bracket / 2


def cooling_rate_fitted(restitution: ArrayLike) -> FloatArray:
    """Return h(e) = 1.45 (1 - e) (eq. hsimu)."""
    return FITTED_COOLING_FACTOR * (1 - numbers(restitution))


def stability(restitution: ArrayLike, root: str = "stable") -> FloatArray:
    """Return H(e) = 3 a2 - (15 e^2/4 + 1/8) (eq. ac7): negative where that root of a2 is stable."""
    return 3 * a2(restitution, root) - (15 / 4 * numbers(restitution) ** 2 + 1 / 8)


def vdf(c: ArrayLike, a2: ArrayLike) -> FloatArray:
    """Return the scaled VDF phi(c) (1 + a2 S2(c^2)) (eqs. sonine1, sonine2).

    It is a density in the plane: its integral over d^2c is 1, and c is in units of v0.

    With a2 = 0 it is the Maxwell-Boltzmann distribution of the paper's Fig. scalev.
    """
    x = numbers(c) ** 2
    second_sonine_polynomial = x**2 / 2 - 2 * x + 1
    with np.errstate(under="ignore"):
        gaussian = np.exp(-x) / math.pi
        return gaussian * (1 + numbers(a2) * second_sonine_polynomial)


def thermal_speed(
    time: ArrayLike,
    cooling_rate: ArrayLike,
    number_density: float = 0.04,
    diameter: float = 1.0,
    start: float = THERMAL_SPEED_START,
) -> FloatArray:
    """Return v0(t) = 1/(1/v0(0) + d rho0 h t) (eq. veq), in U."""
    slowing = diameter * number_density * numbers(cooling_rate) * numbers(time)
    return 1 / (1 / start + slowing)


# -- the random walk (Section 3.2) -----------------------------------------------------------------

#: Mean free path in d that the paper puts into eq. msd in place of 1/(2 d rho0) = 12.5 d.
FITTED_FREE_PATH = 13.5


def alpha(start: ArrayLike = THERMAL_SPEED_START) -> FloatArray:
    """Return the slowness alpha = 1/v0(0) (eq. ab), in 1/U."""
    return 1 / numbers(start)


def beta(
    restitution: ArrayLike,
    number_density: float = 0.04,
    diameter: float = 1.0,
    cooling_rate: ArrayLike | None = None,
) -> FloatArray:
    """Return the rate beta = d rho0 h(e) (eq. ab), in 1/d; h(e) by eq. hsimu unless specified."""
    if cooling_rate is None:
        return diameter * number_density * cooling_rate_fitted(restitution)
    return diameter * number_density * numbers(cooling_rate)


def msd_random_walk(
    time: ArrayLike,
    restitution: ArrayLike,
    number_density: float = 0.04,
    diameter: float = 1.0,
    free_path: float = FITTED_FREE_PATH,
    start: float = THERMAL_SPEED_START,
    cooling_rate: ArrayLike | None = None,
) -> FloatArray:
    """Return the mean square displacement l^2 N of the random walk (eq. msd), in d^2.

    N = ln(1 + beta t/alpha)/ln(1 + l beta) (eq. N); t/(alpha l) for beta = 0.
    """
    rate = beta(restitution, number_density, diameter, cooling_rate)
    scaled = numbers(time) / alpha(start)
    with np.errstate(divide="ignore", invalid="ignore"):
        steps = np.log1p(rate * scaled) / np.log1p(free_path * rate)
    steps_at_constant_speed = scaled / free_path
    return free_path**2 * np.where(rate > 0, steps, steps_at_constant_speed)


# -- Chapman-Enskog, first Sonine approximation ----------------------------------------------------


def diffusion_rate(
    thermal_speed: ArrayLike,
    restitution: ArrayLike,
    a2: ArrayLike,
    number_density: float = 0.04,
    diameter: float = 1.0,
) -> FloatArray:
    """Return nu_D of the first Sonine approximation (eq. ad6), with 2 T/m = v0^2, in U/d."""
    factor = diameter * number_density * (1 + numbers(restitution)) / 2
    return factor * math.sqrt(math.pi) * numbers(thermal_speed) * (2 + 3 / 4 * numbers(a2))


def diffusion_coefficient(
    thermal_speed: ArrayLike,
    restitution: ArrayLike,
    a2: ArrayLike,
    number_density: float = 0.04,
    diameter: float = 1.0,
) -> FloatArray:
    """Return D_e(t) of the first Sonine approximation (eq. ad7), with 2 T/m = v0^2, in d U."""
    slowing = (numbers(restitution) + 1) ** 2 * (1 + 3 / 8 * numbers(a2))
    return numbers(thermal_speed) / math.sqrt(math.pi) / (diameter * number_density) / slowing


def msd_sonine(
    time: ArrayLike, restitution: ArrayLike, number_density: float = 0.04, diameter: float = 1.0
) -> FloatArray:
    """Return the mean square displacement of the first Sonine approximation (eq. ad8), in d^2.

    The label ad8 stands twice in the paper; this is the second one, with the stable a2. NaN below
    `THRESHOLD_RESTITUTION`.
    """
    e = numbers(restitution)
    rho = diameter * number_density
    correction = 1 + 3 / 8 * a2(e)
    scaled_time = math.sqrt(math.pi / 2) * rho * numbers(time)
    x = scaled_time * (1 - e**2) * correction
    # ln(1 + x)/x, so that the elastic limit, linear in time, is there too
    is_linear = x == 0
    growth = np.where(is_linear, 1.0, np.log1p(x) / np.where(is_linear, 1, x))
    return 8 / (math.pi * rho**2) * scaled_time * growth / ((1 + e) ** 2 * correction)


# -- the position distribution (Section 3.3) -------------------------------------------------------
# R = r/sqrt(<r^2>); the integrals of the exact G and R^2 G over R >= 0 are both 1. eta and gamma
# are the paper's fit parameters. At large R every form is 0, and none overflows.

#: eta of the paper's fit to the tail of G(R) (eq. gammatailg).
TAIL_ETA = 0.25

#: gamma of the same fit; the integral itself gives 2.
TAIL_GAMMA = 7.39

#: eta of the paper's fit to the peak of G(R) (eq. peakg).
PEAK_ETA = 0.75

#: Most probable scaled speed of the Gaussian, the V of eq. peakg.
PEAK_SPEED = 1 / math.sqrt(2)

#: Largest z = R/sqrt(eta) that is computed with: every curve is 0 in double precision long before.
#: Derived: its square does not overflow.
MAX_SCALED_RADIUS = math.exp(0.25 * LARGEST_LOG)


def _scaled(r: ArrayLike, eta: ArrayLike) -> FloatArray:
    """Return z = R/sqrt(eta), no further than `MAX_SCALED_RADIUS`."""
    with np.errstate(over="ignore", under="ignore"):
        return np.minimum(numbers(r) / np.sqrt(numbers(eta)), MAX_SCALED_RADIUS)


def position_given_speed(r: ArrayLike, eta: ArrayLike, speed: ArrayLike) -> FloatArray:
    """Return G(R, V) of one hopping speed V (eqs. posivel, peakg), normalised over R."""
    width = numbers(eta) * numbers(speed) ** 2
    z = _scaled(r, width)
    with np.errstate(under="ignore"):
        return z / np.sqrt(width) * np.exp(-np.square(z) / 2)


def position_peak(
    r: ArrayLike, eta: ArrayLike = PEAK_ETA, speed: ArrayLike = PEAK_SPEED
) -> FloatArray:
    """Return G(R) near its peak (eq. peakg), by default with the paper's eta and V = 1/sqrt(2)."""
    return position_given_speed(r, eta, speed)


def position_integral(r: ArrayLike, eta: ArrayLike = 0.5) -> FloatArray:
    """Return G(R) of eq. gdefi, the integral over V done: (2R/eta) K0(R sqrt(2/eta)).

    Normalised over R for every eta; <R^2> = 2 eta, so that eta = 1/2 leaves nothing to fit.
    """
    from scipy.special import k0

    z = _scaled(r, eta)
    inside = z > np.finfo(float).tiny
    with np.errstate(under="ignore"):
        bessel = z * k0(math.sqrt(2) * np.where(inside, z, 1.0))
        return np.where(inside, 2 / np.sqrt(numbers(eta)) * bessel, 0.0)


def position_tail(
    r: ArrayLike, eta: ArrayLike = TAIL_ETA, gamma: ArrayLike = TAIL_GAMMA
) -> FloatArray:
    """Return G(R) by steepest descent (eqs. pdefi, csolu, tailg) times gamma (eq. gammatailg).

    gamma = 1 gives eq. tailg. The defaults are the paper's fit.
    """
    z = _scaled(r, eta)
    factor = 2 * numbers(gamma) / np.sqrt(numbers(eta))
    # On the saddle R^2 = eta (w + 2 w^2), so that R^2 p = ln(w)/2 + 2 w + 1/2 and
    # R^2 p'' = 8 + 2/w: the square root of w goes with that of p''. w = (sqrt(1 + 8 z^2) - 1)/4
    root_8_z = math.sqrt(8) * z
    with np.errstate(under="ignore"):
        w = root_8_z / 4 * (root_8_z / (1 + np.hypot(1, root_8_z)))
        gaussian_width = np.sqrt(math.pi / (4 + 16 * w))
        return factor * z * gaussian_width * np.exp(-2 * w - 0.5)


def position_far_tail(r: ArrayLike, eta: ArrayLike = TAIL_ETA) -> FloatArray:
    """Return G(R) at large R (eq. semig), as printed; half of what the integral tends to."""
    z = _scaled(r, eta)
    with np.errstate(under="ignore"):
        prefactor = np.sqrt(math.pi * z / (2 * math.sqrt(2))) / np.sqrt(numbers(eta))
        return prefactor * np.exp(-math.sqrt(2) * z)
