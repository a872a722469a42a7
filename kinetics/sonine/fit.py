"""The eta and gamma that the printed forms of G(R) need to fit a given curve."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from kinetics.errors import InputError
from kinetics.sonine.position import position_far_tail, position_integral, position_peak
from kinetics.sonine.position import position_tail as _tail
from kinetics.validation import Array, not_negative, one_of, refuse

_FORMS: dict[str, tuple[Callable[[Array, float], Array], bool]] = {
    "tail": (lambda r, eta: _tail(r, eta, 1.0), True),
    "far_tail": (position_far_tail, True),
    "peak": (position_peak, False),
    "integral": (position_integral, False),
}
_LOWEST, _HIGHEST = 1e-4, 1e4


@dataclass(frozen=True)
class PositionFit:
    """A printed form fitted to a curve G(R).

    Attributes
    ----------
    form : "tail" (eq. gammatailg), "far_tail" (eq. semig times gamma), "peak" (eq. peakg with
        V = 1/sqrt(2)) or "integral" (eq. gdefi)
    eta, gamma : the fitted constants; gamma is 1 where the form has none
    residual : root mean square of ln(form/G) over the points
    largest_residual : largest |ln(form/G)|
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

    Parameters
    ----------
    r, density : R (not negative) and G(R), of one shape, at least 3 of them inside the region and
        with R > 0 and G > 0 there
    form : see :class:`PositionFit`
    region : lowest and highest R to use

    Raises
    ------
    InputError : r negative or not finite, G not above 0 where R > 0, too few points, unknown form
    """
    from scipy.optimize import minimize_scalar

    one_of("form", form, _FORMS)
    x, g = _points(r, density, region)
    shape, scalable = _FORMS[form]

    def logarithm(log_eta: float) -> tuple[Array, float]:
        """ln(form/G) at its best gamma, and ln gamma."""
        with np.errstate(divide="ignore"):
            raw = np.log(shape(x, math.exp(log_eta))) - np.log(g)
        if not np.all(np.isfinite(raw)):  # the form underflows: a bad fit
            return np.full(x.shape, 1e3), 0.0
        shift = float(np.mean(raw)) if scalable else 0.0
        return raw - shift, -shift

    def cost(log_eta: float) -> float:
        return float(np.mean(np.square(logarithm(log_eta)[0])))

    grid = np.linspace(math.log(_LOWEST), math.log(_HIGHEST), 93)
    best = int(np.argmin([cost(float(u)) for u in grid]))
    bounded = 0 < best < grid.size - 1
    bracket = float(grid[max(best - 1, 0)]), float(grid[min(best + 1, grid.size - 1)])
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
        bounded,
    )


def _points(r: ArrayLike, density: ArrayLike, region: tuple[float, float]) -> tuple[Array, Array]:
    """R > 0 inside the region and G there, shape (n_points,) each; InputError if too few."""
    radii, values = np.ravel(not_negative("r", r)), np.ravel(not_negative("density", density))
    if radii.shape != values.shape:
        raise InputError(f"density: got {values.size} values; r has {radii.size}")
    low, high = region
    used = (radii > 0) & (radii >= low) & (radii <= high)
    x, g = radii[used], values[used]
    if x.size < 3:
        refuse("region", region, f"it holds {x.size} points, 3 are needed")
    if not np.all(g > 0):
        raise InputError("density: got values that are 0; it must be above 0 within the region")
    return x, g
