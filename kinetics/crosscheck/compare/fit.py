"""One least-squares fit, for what was not told and for every cause of a difference.

Parameters are fitted to the logarithms of second moments (v0 and <r^2>) alone: where a few fast
tracers raise a fourth moment they raise its variance too, so that weights from the same tracers
would favour low values (Altonji and Segal, J. Bus. Econ. Stat. 14, 353 (1996)). All averages enter
the chi-square that is left, which is at the same point as the values and their errors.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.compare import statistics
from kinetics.crosscheck.compare.statistics import ChiSquare, covariance, errors, whitening
from kinetics.crosscheck.compare.theory import Expectation, Point, own_covariance

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

SECOND_MOMENTS = ("thermal_speed", "msd")
"""The averages that parameters are fitted to, in the order of all averages."""
LIMITS = {"restitution": (0.0, 1.0), "at_rest": (-0.5, 0.9)}
"""Of parameters that are fitted as they are; others are positive, and their logarithms fitted."""
WIDEST = 12.0
"""|ln| of the factor by which such a parameter may differ from what was told."""
_STEP = 1e-4
"""Of a parameter, for derivatives: the solver's error of 1e-7 is 1e-3 of a slope of order 1."""
_TRIED = 2
"""Starts from which the least squares are looked for: those with the smallest sums of squares."""


@dataclass(frozen=True, eq=False)
class Fit:
    """A point with some fitted parameters (`free`), and all that is known there.

    errors (k,): relative for parameters whose logarithms are fitted. theory (n_names, n_times).
    fitted (p,): indices of the averages that were fitted, of p_all; influence (k, p):
    d(parameters)/d(data); slope (p_all, k). widening: of `log_widening`.
    """

    expectation: Expectation
    point: Point
    free: tuple[str, ...]
    errors: Array
    theory: Array
    influence: Array
    slope: Array
    fitted: Indices
    chi_square: ChiSquare | None = None
    widening: float = 0.0

    def value(self, name: str) -> tuple[float, float]:
        """A fitted parameter and its standard error."""
        value, error = getattr(self.point, name), float(self.errors[self.free.index(name)])
        return value, error if name in LIMITS else value * error

    def moved(self, replicates: Array) -> Array:
        """Replicates of the difference (G, ...) with the shift of the fitted theory taken off."""
        flat = replicates.reshape(len(replicates), -1)[:, self.fitted]
        shift = (flat - flat.mean(axis=0)) @ self.influence.T
        return np.asarray(replicates - (shift @ self.slope.T).reshape(replicates.shape))


def choose_components(usable: NDArray[np.bool_], groups: int, parameters: int) -> Indices:
    """Which components (n_names, n_times) can be tested together: flat indices.

    No more than the groups allow, evenly over time for each average.
    """
    most = max(statistics.most_freedom(groups), min(2 * parameters, groups - 2))
    rows = [(k, np.flatnonzero(row)) for k, row in enumerate(usable) if np.any(row)]
    if not rows:
        return np.empty(0, np.int64)
    share = max(1, most // len(rows))
    at = [k * usable.shape[1] + row[statistics.spread_out(row.size, share)] for k, row in rows]
    return np.concatenate(at)[:most]


def components_of(
    names: Sequence[str], usable: NDArray[np.bool_], groups: int, parameters: int
) -> tuple[Indices, Indices]:
    """The averages that are fitted, and those that enter the chi-square, as `choose_components`."""
    second = usable & np.isin(names, SECOND_MOMENTS)[:, None]
    fitted, tested = (choose_components(u, groups, parameters) for u in (second, usable))
    return fitted, tested


def fit(
    expectation: Expectation, told: Point, free: Sequence[str], components: tuple[Indices, Indices],
    starts: Sequence[Sequence[float]] = ((),),
) -> Fit | None:  # fmt: skip
    """Least squares from the best starts; None where nothing converges, or only at a limit.

    told: the point whose parameters `free` are fitted, none or more. starts: of them, or of the
    logarithms of those that are positive.
    """
    groups, (chosen, tested) = expectation.sample.groups, components
    replicates = expectation.replicates.reshape(groups, -1)[:, chosen]
    values, logs = expectation.values.ravel()[chosen], np.array([n not in LIMITS for n in free])
    middle = [0.0 if name in LIMITS else np.log(getattr(told, name)) for name in free]
    ends = [LIMITS.get(n, (m - WIDEST, m + WIDEST)) for n, m in zip(free, middle, strict=True)]
    low, high = (np.array([end[k] for end in ends]) for k in (0, 1))

    def point(at: Array) -> Point:
        changed: Any = dict(zip(free, np.where(logs, np.exp(at), at).tolist(), strict=True))
        return told._replace(**changed)

    def difference(at: Array) -> Array:
        with np.errstate(divide="ignore", invalid="ignore"):
            theory = expectation.theory(point(at))[0].ravel()[chosen]
            return np.asarray(np.log(values) - np.log(theory))

    def weights(at: Array) -> Array | None:
        moved = np.broadcast_to(expectation.theory(point(at))[1], expectation.replicates.shape)
        with np.errstate(divide="ignore", invalid="ignore"):
            left = np.log(replicates) - np.log(moved.reshape(groups, -1)[:, chosen])
        return whitening(covariance(left)) if np.all(np.isfinite(left)) else None

    best = np.empty(0)
    if free:
        tried = []
        for start in starts:
            at = np.clip(np.asarray(start, float), low, high)
            if np.all(np.isfinite(left := difference(at))) and (white := weights(at)) is not None:
                tried.append((float(np.sum((white @ left) ** 2)), at, white))
        tried = sorted(tried, key=lambda one: one[0])[:_TRIED]
        found = [_descended(difference, white, at, low, high) for _, at, white in tried]
        known = [one for one in found if one is not None]
        if not known:
            return None
        best = min(known, key=lambda one: one[0])[1]
        margin = 0.01 * (high - low)
        if np.any(logs & ((best <= low + margin) | (best >= high - margin))):
            return None

    theory, moved = expectation.theory(point(best))
    slope, influence, error = np.zeros((theory.size, 0)), np.zeros((0, chosen.size)), np.empty(0)
    one_by_one = expectation.sample.tabulated
    if free:
        if (white := weights(best)) is None:
            return None
        slope = _slopes(lambda p: expectation.theory(point(p))[0].ravel(), best, low, high)
        size = theory.ravel()[chosen]
        steep = white @ (slope[chosen] / size[:, None])
        influence = np.linalg.pinv(steep) @ white / size
        spread = np.linalg.pinv(steep.T @ steep) * _inflation(groups, len(white) - best.size)
        error = np.sqrt(np.diagonal(spread))
        if one_by_one:  # errors for the worst correlation
            error = np.abs(influence) @ errors(replicates)
    at = point(best)
    fitted = Fit(expectation, at, tuple(free), error, theory, influence, slope, chosen)
    known_error = own_covariance(expectation, at, theory)
    rest = expectation.replicates - moved
    rest = (rest if one_by_one else fitted.moved(rest)).reshape(groups, -1)[:, tested]
    widening = 0.0
    if known_error is not None:
        known_error = known_error[np.ix_(tested, tested)]
        widening = statistics.log_widening(rest, known_error)
    left = (expectation.values - theory).ravel()[tested]
    after = statistics.hotelling(left, rest, known_error, one_by_one)
    return replace(fitted, chi_square=after, widening=widening)


def _inflation(groups: int, freedom: int) -> float:
    """Factor on the variance of a parameter, for weights from a covariance that is estimated."""
    first = (groups - 1) / max(groups - 1 - freedom, 1)
    return first * (groups - 2) / max(groups - 2 - freedom, 1)


def _descended(
    difference: Callable[[Array], Array], white: Array, start: Array, low: Array, high: Array
) -> tuple[float, Array] | None:
    """The least sum of squares near a start, and where it is; None where theory is not finite."""
    from scipy.optimize import least_squares

    def residual(at: Array) -> Array:
        return np.asarray(white @ difference(at))

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
    steps = _STEP * np.eye(at.size)
    ends = [(np.minimum(at + step, high), np.maximum(at - step, low)) for step in steps]
    made = [(function(up) - function(down)) / np.sum(up - down) for up, down in ends]
    return np.stack(made, axis=1)
