"""Least squares with the covariance of the data: restitution and free path from a sample.

The same function finds what was not given and tests what may explain a difference: a hypothesis
is a theory with one parameter, and what it explains is by how much it lowers the chi-square.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.comparison.statistics import (
    ChiSquare,
    covariance,
    hotelling,
    most_freedom,
    spread_out,
    whitening,
)

Array = NDArray[np.float64]

Model = Callable[[Array], tuple[Array, Array]]
"""Parameters (k,) to theory, and its replicates: of that shape or (G, ...)."""
_STEP = 1e-4
"""Of a parameter, for derivatives: the solver's relative error of 1e-7 is 1e-3 of a slope of
order 1, the step's own error far less."""
_TRIED = 2
"""Starts from which the least squares are looked for: those with the smallest sums of squares."""


@dataclass(frozen=True)
class Unknown:
    """A parameter that is fitted, between two limits."""

    name: str
    low: float
    high: float


@dataclass(frozen=True)
class Fit:
    """Parameters with standard errors, the chi-square that is left, and how data move them.

    components (p,): indices of the averages that were fitted, of p_all; influence (k, p):
    d(parameters)/d(data); slope (p_all, k): d(theory)/d(parameters).
    """

    names: tuple[str, ...]
    values: Array
    errors: Array
    chi_square: ChiSquare | None
    influence: Array
    slope: Array
    components: NDArray[np.int64]

    def moved(self, replicates: Array) -> Array:
        """The parameters' shift in each replicate of the data (G, ...): (G, k)."""
        chosen = replicates.reshape(len(replicates), -1)[:, self.components]
        return np.asarray((chosen - chosen.mean(axis=0)) @ self.influence.T)


def choose_components(usable: NDArray[np.bool_], groups: int, parameters: int) -> NDArray[np.int64]:
    """Which components (n_names, n_times) can be fitted together: flat indices.

    No more than the groups allow, evenly over time for each average, but not fewer than twice the
    parameters if the groups allow that.
    """
    most = max(most_freedom(groups), min(2 * parameters, groups - 2))
    rows = [(k, np.flatnonzero(row)) for k, row in enumerate(usable) if np.any(row)]
    if not rows:
        return np.empty(0, np.int64)
    share = max(1, most // len(rows))
    at = [k * usable.shape[1] + row[spread_out(row.size, share)] for k, row in rows]
    return np.concatenate(at)[:most]


def fit(
    unknowns: Sequence[Unknown],
    model: Model,
    data: tuple[Array, Array],
    components: NDArray[np.int64],
    starts: Sequence[Sequence[float]],
) -> Fit | None:
    """Least squares from the best starts; None where nothing converges.

    data: values of any shape, p_all in all, and replicates (G, ...), of which `components` are
    fitted; model gives the same shape.
    """
    values, replicates = data
    low, high = np.array([(one.low, one.high) for one in unknowns]).T

    def left(at: Array) -> tuple[Array, Array]:
        theory, moved = model(at)
        rest = (replicates - moved).reshape(len(replicates), -1)
        return (values - theory).ravel()[components], rest[:, components]

    tried = []
    for start in starts:
        at = np.clip(np.asarray(start, float), low, high)
        difference, moved = left(at)
        white = whitening(covariance(moved))
        tried.append((float(np.sum((white @ difference) ** 2)), at, white))
    found = []
    for _, at, white in sorted(tried, key=lambda one: one[0])[:_TRIED]:

        def residual(p: Array, white: Array = white) -> Array:
            return np.asarray(white @ left(p)[0])

        found.append(_descended(residual, at, low, high))
    best = min((one for one in found if one is not None), key=lambda one: one[0], default=None)
    if best is None:
        return None
    at = best[1]
    difference, moved = left(at)
    white = whitening(covariance(moved))
    every = _slopes(lambda p: model(p)[0].ravel(), at, low, high)
    slope = every[components]
    influence = np.linalg.pinv(white @ slope) @ white
    spread = np.linalg.pinv((white @ slope).T @ (white @ slope))
    shift = (moved - moved.mean(axis=0)) @ influence.T
    # What the fit leaves has as many degrees of freedom less as there are parameters.
    chi_square = hotelling(difference, moved - shift @ slope.T)
    names, errors = tuple(one.name for one in unknowns), np.sqrt(np.diagonal(spread))
    return Fit(names, at, errors, chi_square, influence, every, components)


def _descended(
    residual: Callable[[Array], Array], start: Array, low: Array, high: Array
) -> tuple[float, Array] | None:
    """The least sum of squares near a start, and where it is; None where the theory is not finite.

    A gain of 1e-5 in a chi-square, or a step of 1e-6, is far below any standard error.
    """
    from scipy.optimize import least_squares

    try:
        found = least_squares(
            residual, start, lambda at: _slopes(residual, at, low, high), (low, high), "dogbox",
            ftol=1e-5, xtol=1e-6, max_nfev=50,
        )  # fmt: skip
    except (ValueError, np.linalg.LinAlgError):
        return None
    return 2 * float(found.cost), found.x


def _slopes(function: Callable[[Array], Array], at: Array, low: Array, high: Array) -> Array:
    """Derivatives (p, k), centred where the limits leave room."""
    out = []
    for k in range(at.size):
        up, down = at.copy(), at.copy()
        up[k] = min(at[k] + _STEP, high[k])
        down[k] = max(at[k] - _STEP, low[k])
        out.append((function(up) - function(down)) / (up[k] - down[k]))
    return np.stack(out, axis=1)
