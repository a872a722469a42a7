"""The scaled position distribution G(R) of Section 3.3, as printed and as corrected.

R = r/sqrt(<r^2>) is dimensionless and G a radial density: the integrals of the exact G and R^2 G
over R >= 0 are both 1. eta and gamma are the paper's fit parameters. At large R every form is 0 in
double precision, and none overflows.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from kinetics.validation import Array, not_negative, positive

TAIL_ETA = 0.25
"""eta of the paper's fit to the tail of G(R) (eq. gammatailg)."""

TAIL_GAMMA = 7.39
"""gamma of the same fit; the integral itself gives 2 (see :func:`position_steepest_descent`)."""

PEAK_ETA = 0.75
"""eta of the paper's fit to the peak of G(R) (eq. peakg)."""

PEAK_SPEED = 1 / math.sqrt(2)
"""Most probable scaled speed of the Gaussian, the V of eq. peakg."""


def displacement_density(
    distance: ArrayLike, diffusion_integral: ArrayLike, as_printed: bool = True
) -> Array:
    """g(r, t) of one hopping speed (eq. normg), in 1/d; normalised over r.

    ``diffusion_integral`` is the integral of D_e from 0 to t, in d^2. The printed Gaussian has
    <r^2> = 8 times that; with ``as_printed=False`` it has the 4 times of the diffusion equation.
    """
    r = not_negative("distance", distance)
    width = (4 if as_printed else 2) * positive("diffusion_integral", diffusion_integral)
    return _rayleigh(r, width)


def _rayleigh(x: Array, width: Array) -> Array:
    """x/width exp(-x^2/(2 width))."""
    z = _scaled(x, width)
    with np.errstate(under="ignore"):
        return z / np.sqrt(width) * np.exp(-np.square(z) / 2)


_FAR = 1e100  # every curve is 0 in double precision long before


def _scaled(x: Array, eta: Array) -> Array:
    """z = R/sqrt(eta), no further than _FAR: its square does not overflow."""
    with np.errstate(over="ignore", under="ignore"):
        return np.minimum(x / np.sqrt(eta), _FAR)


def position_given_speed(r: ArrayLike, eta: ArrayLike, speed: ArrayLike) -> Array:
    """G(R, V) of one hopping speed V (eqs. posivel, peakg), normalised over R."""
    width = positive("eta", eta) * positive("speed", speed) ** 2
    return _rayleigh(not_negative("r", r), width)


def position_peak(r: ArrayLike, eta: ArrayLike = PEAK_ETA, speed: ArrayLike = PEAK_SPEED) -> Array:
    """G(R) near its peak (eq. peakg), by default with the paper's eta and V = 1/sqrt(2)."""
    return position_given_speed(r, eta, speed)


def position_integral(r: ArrayLike, eta: ArrayLike = 0.5) -> Array:
    """G(R) of eq. gdefi, the integral over V done: (2R/eta) K0(R sqrt(2/eta)).

    Normalised over R for every eta; <R^2> = 2 eta, so that eta = 1/2 leaves nothing to fit.
    """
    from scipy.special import k0

    width = positive("eta", eta)
    z = _scaled(not_negative("r", r), width)
    inside = z > np.finfo(float).tiny
    with np.errstate(under="ignore"):
        bessel = z * k0(math.sqrt(2) * np.where(inside, z, 1.0))
        return np.where(inside, 2 / np.sqrt(width) * bessel, 0.0)


def position_exponent(r: ArrayLike, speed: ArrayLike, eta: ArrayLike = TAIL_ETA) -> Array:
    """p(V, R) = ln V/R^2 + V^2/R^2 + 1/(2 eta V^2) (eq. pdefi), for R > 0 and V > 0."""
    square, v = positive("r", r) ** 2, positive("speed", speed)
    return np.log(v) / square + v**2 / square + 1 / (2 * positive("eta", eta) * v**2)


def position_saddle(r: ArrayLike, eta: ArrayLike = TAIL_ETA) -> Array:
    """V*(R), the minimum of p(V, R) over V (eq. csolu)."""
    return np.sqrt(_saddle_squared(not_negative("r", r) / np.sqrt(positive("eta", eta))))


def _saddle_squared(z: Array) -> Array:
    """w = V*^2 = (sqrt(1 + 8 z^2) - 1)/4, z = R/sqrt(eta), without cancellation or overflow."""
    wide = math.sqrt(8) * z
    with np.errstate(under="ignore"):
        return wide / 4 * (wide / (1 + np.hypot(1, wide)))


def position_tail(r: ArrayLike, eta: ArrayLike = TAIL_ETA, gamma: ArrayLike = TAIL_GAMMA) -> Array:
    """G(R) by steepest descent (eqs. pdefi, csolu, tailg) times the fitted gamma (eq. gammatailg).

    gamma = 1 gives eq. tailg. The defaults are the paper's fit.
    """
    width = positive("eta", eta)
    z = _scaled(not_negative("r", r), width)
    factor = 2 * positive("gamma", gamma) / np.sqrt(width)
    # On the saddle R^2 = eta (w + 2 w^2), so that R^2 p = ln(w)/2 + 2 w + 1/2 and
    # R^2 p'' = 8 + 2/w: the square root of w goes with that of p''.
    w = _saddle_squared(z)
    with np.errstate(under="ignore"):
        return factor * z * np.sqrt(math.pi / (4 + 16 * w)) * np.exp(-2 * w - 0.5)


def position_steepest_descent(r: ArrayLike, eta: ArrayLike = 0.5) -> Array:
    """G(R) by steepest descent with the Gaussian integral corrected: twice what eq. tailg prints.

    That is eq. gammatailg with gamma = 2, for every eta. At large R it tends to
    :func:`position_integral`, in which <R^2> = 1 for eta = 1/2.
    """
    return position_tail(r, eta, 2.0)


def position_far_tail(r: ArrayLike, eta: ArrayLike = TAIL_ETA) -> Array:
    """G(R) in the limit of large R (eq. semig), as printed."""
    width = positive("eta", eta)
    z = _scaled(not_negative("r", r), width)
    with np.errstate(under="ignore"):
        prefactor = np.sqrt(math.pi * z / (2 * math.sqrt(2))) / np.sqrt(width)
        return prefactor * np.exp(-math.sqrt(2) * z)


def position_far_tail_corrected(r: ArrayLike, eta: ArrayLike = 0.5) -> Array:
    """G(R) in the limit of large R with the Gaussian integral corrected: twice eq. semig."""
    return 2 * position_far_tail(r, eta)
