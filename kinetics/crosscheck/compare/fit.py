"""One least-squares fit, for what was not told and for every cause of a difference.

What is reported of a fit, its values, errors and chi-square, is all at the same point.

Parameters are fitted to the logarithms of second moments (v0 and <r^2>) alone. A covariance that
is estimated from the same tracers depends on their averages: where a few fast tracers raise an
average they raise its variance too, so that weights from this covariance favour low values. The
fitted parameters are then biased (Altonji and Segal, J. Bus. Econ. Stat. 14, 353 (1996)), the more
the longer the tails: with fourth moments by half a standard error. The standard deviation of <v^2>
is proportional to <v^2>, so that its logarithm has nearly the same variance whatever its value.
Fourth moments would hardly make the errors smaller; all averages enter the chi-square that is left.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.compare.statistics import (
    ChiSquare,
    covariance,
    errors,
    hotelling,
    log_widening,
    most_freedom,
    spread_out,
    whitening,
)
from kinetics.crosscheck.compare.theory import Expectation, Point, own_covariance
from kinetics.crosscheck.data.sample import Sample

Array = NDArray[np.float64]

SECOND_MOMENTS = ("thermal_speed", "msd")
"""The averages that parameters are fitted to, in the order of all averages."""
LIMITS = {"restitution": (0.0, 1.0), "at_rest": (-0.5, 0.9)}
"""Of parameters that are fitted as they are; others are positive, and their logarithms fitted."""
WIDEST = 12.0
"""|ln| of the factor by which such a parameter may differ from what was told."""
_STEP = 1e-4
"""Of a parameter, for derivatives: the solver's relative error of 1e-7 is 1e-3 of a slope of
order 1, the step's own error far less."""
_TRIED = 2
"""Starts from which the least squares are looked for: those with the smallest sums of squares."""


class Components(NamedTuple):
    """Which averages, as flat indices, parameters are fitted to, and which enter the chi-square.

    fitted: of second moments, whose logarithms are fitted where `logarithms` says so.
    tested: of all averages. one_by_one: how their errors are correlated is not known: then errors
    of parameters are those for the worst correlation, and p-values hold for any (`hotelling`).
    """

    fitted: NDArray[np.int64]
    tested: NDArray[np.int64]
    logarithms: bool
    one_by_one: bool = False


@dataclass(frozen=True, eq=False)
class Fit:
    """A point with some fitted parameters, and all that is known there.

    free: their names; errors (k,), relative for those whose logarithms are fitted. chi_square of
    the tested averages at this point, whose replicates move with the parameters; widening as of
    `log_widening`. theory (n_names, n_times). components (p,): indices of the averages that were
    fitted, of p_all; influence (k, p): d(parameters)/d(data); slope (p_all, k).
    """

    point: Point
    free: tuple[str, ...]
    errors: Array
    chi_square: ChiSquare | None
    widening: float
    theory: Array
    influence: Array
    slope: Array
    components: NDArray[np.int64]

    def value(self, name: str) -> tuple[float, float]:
        """A fitted parameter and its standard error."""
        value, error = getattr(self.point, name), float(self.errors[self.free.index(name)])
        return value, error if name in LIMITS else value * error

    def moved(self, replicates: Array) -> Array:
        """Replicates of the difference (G, ...) with the shift of the fitted theory taken off."""
        flat = replicates.reshape(len(replicates), -1)[:, self.components]
        shift = (flat - flat.mean(axis=0)) @ self.influence.T
        return np.asarray(replicates - (shift @ self.slope.T).reshape(replicates.shape))


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
    tested = choose_components(usable, sample.groups, parameters)
    second = usable & np.isin(names, SECOND_MOMENTS)[:, None]
    fitted = choose_components(second, sample.groups, parameters)
    if fitted.size < 2 * parameters:
        return Components(tested, tested, False, sample.tabulated)
    return Components(fitted, tested, True, sample.tabulated)


def fit(
    expectation: Expectation,
    told: Point,
    free: Sequence[str],
    components: Components,
    starts: Sequence[Sequence[float]] = ((),),
) -> Fit | None:
    """Least squares from the best starts; None where nothing converges, or only at a limit.

    told: the point whose parameters `free` are fitted, none or more. starts: of them, or of the
    logarithms of those that are positive.
    """
    replicates, chosen = expectation.replicates, components.fitted
    groups, values = len(replicates), expectation.values.ravel()[chosen]
    logs = [name not in LIMITS for name in free]
    ends = [LIMITS.get(n) or (np.log(getattr(told, n)) - WIDEST, np.log(getattr(told, n)) + WIDEST)
            for n in free]  # fmt: skip
    low, high = np.array(ends).reshape(-1, 2).T
    scale = np.log if components.logarithms else np.asarray

    def point(at: Array) -> Point:
        each = zip(free, at.tolist(), logs, strict=True)
        changed: Any = {n: float(np.exp(x)) if log else x for n, x, log in each}
        return told._replace(**changed)

    def difference(at: Array) -> Array:
        with np.errstate(divide="ignore", invalid="ignore"):
            theory = expectation.theory(point(at))[0]
            return np.asarray(scale(values) - scale(theory.ravel()[chosen]))

    def weights(at: Array) -> Array | None:
        moved = np.broadcast_to(expectation.theory(point(at))[1], replicates.shape)
        both = (a.reshape(groups, -1)[:, chosen] for a in (replicates, moved))
        with np.errstate(divide="ignore", invalid="ignore"):
            left = np.subtract(*(scale(a) for a in both))
        return whitening(covariance(left)) if np.all(np.isfinite(left)) else None

    best = np.empty(0)
    if free:
        tried = []
        for start in starts:
            at = np.clip(np.asarray(start, float), low, high)
            if np.all(np.isfinite(left := difference(at))) and (white := weights(at)) is not None:
                tried.append((float(np.sum((white @ left) ** 2)), at, white))
        found = [
            _descended(lambda p, white=white: white @ difference(p), at, low, high)  # type: ignore[misc]
            for _, at, white in sorted(tried, key=lambda one: one[0])[:_TRIED]
        ]
        known = [one for one in found if one is not None]
        if not known:
            return None
        best = min(known, key=lambda one: one[0])[1]
        if any(
            log and not a < x < b
            for x, a, b, log in zip(
                best, 0.99 * low + 0.01 * high, 0.01 * low + 0.99 * high, logs, strict=True
            )
        ):
            return None
    return _at(expectation, point, best, free, components, (low, high), weights)


def _at(
    expectation: Expectation, point: Callable[[Array], Point], best: Array, free: Sequence[str],
    components: Components, limits: tuple[Array, Array], weights: Callable[[Array], Array | None],
) -> Fit:  # fmt: skip
    """Errors, and the chi-square that is left, at the best parameters."""
    chosen, tested, groups = components.fitted, components.tested, expectation.sample.groups
    theory, moved = expectation.theory(point(best))
    slope, influence = np.zeros((theory.size, 0)), np.zeros((0, chosen.size))
    error, white = np.empty(0), weights(best) if free else None
    if white is not None:
        slope = _slopes(lambda p: expectation.theory(point(p))[0].ravel(), best, *limits)
        size = theory.ravel()[chosen] if components.logarithms else np.ones(chosen.size)
        steep = white @ (slope[chosen] / size[:, None])
        influence = np.linalg.pinv(steep) @ white / size
        spread = np.linalg.pinv(steep.T @ steep) * _inflation(groups, len(white) - best.size)
        error = np.sqrt(np.diagonal(spread))
        if components.one_by_one:
            flat = expectation.replicates.reshape(groups, -1)
            error = np.abs(influence) @ errors(flat[:, chosen])
    found = Fit(point(best), tuple(free), error, None, 0.0, theory, influence, slope, chosen)
    left = (expectation.values - theory).ravel()[tested]
    rest = expectation.replicates - moved
    rest = (rest if components.one_by_one else found.moved(rest)).reshape(groups, -1)[:, tested]
    known, widening = own_covariance(expectation, found.point, theory), 0.0
    if known is not None:
        known = known[np.ix_(tested, tested)]
        widening = log_widening(rest, known)
    after = hotelling(left, rest, known, components.one_by_one)
    return Fit(**vars(found) | {"chi_square": after, "widening": widening})


def _inflation(groups: int, freedom: int) -> float:
    """Factor on the variance of a parameter, for weights from a covariance that is estimated."""
    first = (groups - 1) / max(groups - 1 - freedom, 1)
    second = (groups - 2) / max(groups - 2 - freedom, 1)
    return first * second


def _descended(
    residual: Callable[[Array], Array], start: Array, low: Array, high: Array
) -> tuple[float, Array] | None:
    """The least sum of squares near a start, and where it is; None where theory is not finite."""
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
