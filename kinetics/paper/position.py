"""The scaled position distribution G(R) of Section 3.3, as printed and as corrected, and fits.

R = r/sqrt(<r^2>) is dimensionless and G a radial density: the integrals of the exact G and R^2 G
over R >= 0 are both 1. eta and gamma are the paper's fit parameters. At large R every form is 0 in
double precision, and none overflows.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from kinetics.errors import InputError
from kinetics.numerics import FloatArray
from kinetics.paper.first_order import numbers

TAIL_ETA = 0.25
"""eta of the paper's fit to the tail of G(R) (eq. gammatailg)."""

TAIL_GAMMA = 7.39
"""gamma of the same fit; the integral itself gives 2  ."""

PEAK_ETA = 0.75
"""eta of the paper's fit to the peak of G(R) (eq. peakg)."""

PEAK_SPEED = 1 / math.sqrt(2)
"""Most probable scaled speed of the Gaussian, the V of eq. peakg."""

_FAR = 1e100  # every curve is 0 in double precision long before


def _scaled(r: ArrayLike, eta: ArrayLike) -> FloatArray:
    """z = R/sqrt(eta), no further than _FAR: its square does not overflow."""
    with np.errstate(over="ignore", under="ignore"):
        return np.minimum(numbers(r) / np.sqrt(numbers(eta)), _FAR)


def position_given_speed(r: ArrayLike, eta: ArrayLike, speed: ArrayLike) -> FloatArray:
    """G(R, V) of one hopping speed V (eqs. posivel, peakg), normalised over R."""
    width = numbers(eta) * numbers(speed) ** 2
    z = _scaled(r, width)
    with np.errstate(under="ignore"):
        return z / np.sqrt(width) * np.exp(-np.square(z) / 2)


def position_peak(
    r: ArrayLike, eta: ArrayLike = PEAK_ETA, speed: ArrayLike = PEAK_SPEED
) -> FloatArray:
    """G(R) near its peak (eq. peakg), by default with the paper's eta and V = 1/sqrt(2)."""
    return position_given_speed(r, eta, speed)


def position_integral(r: ArrayLike, eta: ArrayLike = 0.5) -> FloatArray:
    """G(R) of eq. gdefi, the integral over V done: (2R/eta) K0(R sqrt(2/eta)).

    Normalised over R for every eta; <R^2> = 2 eta, so that eta = 1/2 leaves nothing to fit.
    """
    from scipy.special import k0

    z = _scaled(r, eta)
    inside = z > np.finfo(float).tiny
    with np.errstate(under="ignore"):
        bessel = z * k0(math.sqrt(2) * np.where(inside, z, 1.0))
        return np.where(inside, 2 / np.sqrt(numbers(eta)) * bessel, 0.0)


def _saddle_squared(z: FloatArray) -> FloatArray:
    """w = V*^2 = (sqrt(1 + 8 z^2) - 1)/4, z = R/sqrt(eta), without cancellation or overflow."""
    wide = math.sqrt(8) * z
    with np.errstate(under="ignore"):
        return wide / 4 * (wide / (1 + np.hypot(1, wide)))


def position_tail(
    r: ArrayLike, eta: ArrayLike = TAIL_ETA, gamma: ArrayLike = TAIL_GAMMA
) -> FloatArray:
    """G(R) by steepest descent (eqs. pdefi, csolu, tailg) times the fitted gamma (eq. gammatailg).

    gamma = 1 gives eq. tailg. The defaults are the paper's fit.
    """
    z = _scaled(r, eta)
    factor = 2 * numbers(gamma) / np.sqrt(numbers(eta))
    # On the saddle R^2 = eta (w + 2 w^2), so that R^2 p = ln(w)/2 + 2 w + 1/2 and
    # R^2 p'' = 8 + 2/w: the square root of w goes with that of p''.
    w = _saddle_squared(z)
    with np.errstate(under="ignore"):
        return factor * z * np.sqrt(math.pi / (4 + 16 * w)) * np.exp(-2 * w - 0.5)


def position_far_tail(r: ArrayLike, eta: ArrayLike = TAIL_ETA) -> FloatArray:
    """G(R) in the limit of large R (eq. semig), as printed; half of what the integral tends to."""
    z = _scaled(r, eta)
    with np.errstate(under="ignore"):
        prefactor = np.sqrt(math.pi * z / (2 * math.sqrt(2))) / np.sqrt(numbers(eta))
        return prefactor * np.exp(-math.sqrt(2) * z)


# -- the eta and gamma that the printed forms need to fit a given curve ----------------------------

_FORMS: dict[str, tuple[Callable[[FloatArray, float], FloatArray], bool]] = {
    "tail": (lambda r, eta: position_tail(r, eta, 1.0), True),
    "far_tail": (position_far_tail, True),
    "peak": (position_peak, False),
    "integral": (position_integral, False),
}
_RANGE = np.log([1e-4, 1e4])  # of eta


@dataclass(frozen=True)
class PositionFit:
    """A printed form fitted to a curve G(R).

    Attributes
    ----------
    form : "tail" (eq. gammatailg), "far_tail" (eq. semig times gamma), "peak" (eq. peakg with
        V = 1/sqrt(2)) or "integral" (eq. gdefi)
    eta, gamma : the fitted constants; gamma is 1 where the form has none
    residual, largest_residual : root mean square and largest of |ln(form/G)| over the points
    region : smallest and largest R used
    points : how many
    bounded : whether eta lies inside the range that was searched, 1e-4 to 1e4
    """

    form: str
    eta: float
    gamma: float
    residual: float
    largest_residual: float
    region: tuple[float, float]
    points: int
    bounded: bool


def fit_position(
    r: ArrayLike,
    density: ArrayLike,
    form: str = "tail",
    region: tuple[float, float] = (0.0, math.inf),
) -> PositionFit:
    """Least squares of ln(form/G) over the R of the region, each point of the same weight.

    r, density: R and G(R), of one shape, at least 3 of them inside the region and with R > 0 and
    G > 0 there, else InputError; form: see :class:`PositionFit`; region: lowest and highest R.
    """
    from scipy.optimize import minimize_scalar

    if form not in _FORMS:
        raise InputError(f"form: got {form!r}; it must be one of {', '.join(_FORMS)}")
    x, g = np.broadcast_arrays(np.ravel(numbers(r)), np.ravel(numbers(density)))
    used = (x > 0) & (x >= region[0]) & (x <= region[1])
    x, g = x[used], g[used]
    if x.size < 3 or not np.all(g > 0):
        raise InputError(f"region: got {region}; it must hold 3 points or more, all with G > 0")
    shape, scalable = _FORMS[form]

    def logarithm(log_eta: float) -> tuple[FloatArray, float]:
        """ln(form/G) at its best gamma, and ln gamma."""
        with np.errstate(divide="ignore"):
            raw = np.log(shape(x, math.exp(log_eta))) - np.log(g)
        if not np.all(np.isfinite(raw)):  # the form underflows: a bad fit
            return np.full(x.shape, 1e3), 0.0
        shift = float(np.mean(raw)) if scalable else 0.0
        return raw - shift, -shift

    def cost(log_eta: float) -> float:
        return float(np.mean(np.square(logarithm(log_eta)[0])))

    grid = np.linspace(_RANGE[0], _RANGE[1], 93)
    best = int(np.argmin([cost(float(u)) for u in grid]))
    bracket = grid[max(best - 1, 0)], grid[min(best + 1, grid.size - 1)]
    found = minimize_scalar(cost, bounds=bracket, method="bounded", options={"xatol": 1e-12})
    rest, log_gamma = logarithm(float(found.x))
    return PositionFit(
        form,
        math.exp(float(found.x)),
        math.exp(log_gamma),
        float(np.sqrt(np.mean(np.square(rest)))),
        float(np.max(np.abs(rest))),
        (float(x.min()), float(x.max())),
        int(x.size),
        0 < best < grid.size - 1,
    )
