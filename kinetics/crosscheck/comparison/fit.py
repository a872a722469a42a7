"""Least squares with the covariance of the data: restitution and free path from a sample.

The same function finds what was not given and tests what may explain a difference: a hypothesis
is a theory with one parameter, and what it explains is by how much it lowers the chi-square.

Parameters are fitted to the logarithms of second moments (v0 and <r^2>) alone. A covariance that
is estimated from the same tracers depends on their averages: where a few fast tracers raise an
average they raise its variance too, so that weights from this covariance favour low values. The
fitted parameters are then biased (Altonji and Segal, J. Bus. Econ. Stat. 14, 353 (1996)), the more
the longer the tails: with fourth moments by half a standard error. The standard deviation of <v^2>
is proportional to <v^2>, so that its logarithm has nearly the same variance whatever its value.
Fourth moments would hardly make the errors smaller; all averages enter the chi-square that is left.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.comparison.sample import Sample
from kinetics.crosscheck.comparison.statistics import (
    ChiSquare,
    covariance,
    errors,
    hotelling,
    most_freedom,
    spread_out,
    whitening,
)

Array = NDArray[np.float64]

Model = Callable[[Array], tuple[Array, Array]]
"""Parameters (k,) to theory, and its replicates: of that shape or (G, ...)."""
SECOND_MOMENTS = ("thermal_speed", "msd")
"""The averages that parameters are fitted to, in the order of all averages."""
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
class Components:
    """Which averages, as flat indices, parameters are fitted to, and which enter the chi-square.

    fitted: of second moments, whose logarithms are fitted where `logarithms` says so.
    tested: of all averages. one_by_one: how their errors are correlated is not known: then errors
    of parameters are those for the worst correlation, and p-values hold for any (`hotelling`).
    """

    fitted: NDArray[np.int64]
    tested: NDArray[np.int64]
    logarithms: bool
    one_by_one: bool = False


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
    """Which components (n_names, n_times) can be tested together: flat indices.

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


def components_of(
    names: Sequence[str], usable: NDArray[np.bool_], sample: Sample, parameters: int
) -> Components:
    """What is fitted and tested of the averages `names`, of which `usable` (n_names, n_times) are.

    Without two second moments for each parameter all averages are fitted, as they are.
    """
    groups, one_by_one = sample.groups, sample.tabulated
    tested = choose_components(usable, groups, parameters)
    second = usable & np.isin(names, SECOND_MOMENTS)[:, None]
    fitted = choose_components(second, groups, parameters)
    if fitted.size < 2 * parameters:
        return Components(tested, tested, False, one_by_one)
    return Components(fitted, tested, True, one_by_one)


def fit(
    unknowns: Sequence[Unknown],
    model: Model,
    data: tuple[Array, Array],
    components: Components,
    starts: Sequence[Sequence[float]],
) -> Fit | None:
    """Least squares from the best starts; None where nothing converges.

    data: values of any shape, p_all in all, and replicates (G, ...), of which `components` are
    fitted and tested; model gives the same shape.
    """
    values, replicates = data
    groups, chosen = len(replicates), components.fitted
    low, high = np.array([(one.low, one.high) for one in unknowns]).T
    scale = np.log if components.logarithms else np.asarray

    def left(at: Array) -> tuple[Array, Array]:
        theory, moved = model(at)
        moved = np.broadcast_to(moved, replicates.shape).reshape(groups, -1)[:, chosen]
        return (
            scale(values.ravel()[chosen]) - scale(theory.ravel()[chosen]),
            scale(replicates.reshape(groups, -1)[:, chosen]) - scale(moved),
        )

    tried = []
    for start in starts:
        at = np.clip(np.asarray(start, float), low, high)
        with np.errstate(divide="ignore", invalid="ignore"):
            difference, moved = left(at)
        if np.all(np.isfinite(difference)) and np.all(np.isfinite(moved)):
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
    white = whitening(covariance(left(at)[1]))
    slope = _slopes(lambda p: model(p)[0].ravel(), at, low, high)
    size = model(at)[0].ravel()[chosen] if components.logarithms else np.ones(chosen.size)
    steep = white @ (slope[chosen] / size[:, None])
    influence = np.linalg.pinv(steep) @ white / size
    spread = np.linalg.pinv(steep.T @ steep) * _inflation(groups, len(white) - at.size)
    names, error = tuple(one.name for one in unknowns), np.sqrt(np.diagonal(spread))
    if components.one_by_one:
        error = np.abs(influence) @ errors(data[1].reshape(groups, -1)[:, chosen])
    found_fit = Fit(names, at, error, None, influence, slope, chosen)
    return replace(found_fit, chi_square=_left_over(found_fit, model, data, components))


def _left_over(
    found: Fit, model: Model, data: tuple[Array, Array], components: Components
) -> ChiSquare | None:
    """The least chi-square near a fit: as many degrees of freedom less as there are parameters."""
    theory, moved = model(found.values)
    tested, (values, replicates) = components.tested, data
    difference = (values - theory).ravel()[tested]
    rest = (replicates - moved).reshape(len(replicates), -1)[:, tested]
    if components.one_by_one:
        return hotelling(difference, rest, None, True)
    # What the parameters could take up, by the best weights for these components, is taken away.
    white, slope = whitening(covariance(rest)), found.slope[tested]
    taken = slope @ np.linalg.pinv(white @ slope) @ white
    return hotelling(difference - taken @ difference, rest - (rest - rest.mean(axis=0)) @ taken.T)


def _inflation(groups: int, freedom: int) -> float:
    """Factor on the variance of a parameter, for weights from a covariance that is estimated.

    Gaussian groups: the covariance's inverse is too large by the first factor (Hartlap, Simon and
    Schneider, A&A 464, 399 (2007)), weights that are not the best ones cost the second (Percival et
    al., MNRAS 439, 2531 (2014)). freedom: components less parameters.
    """
    first = (groups - 1) / max(groups - 1 - freedom, 1)
    second = (groups - 2) / max(groups - 2 - freedom, 1)
    return first * second


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
