"""One least-squares fit: for what was told, for what was not, and for every cause of a difference.

Parameters are fitted to the logarithms of second moments (v0 and <r^2>) alone: a few fast tracers
raise a fourth moment and its variance, so that weights from the same tracers favour low values
(Altonji and Segal, J. Bus. Econ. Stat. 14, 353 (1996)). All averages enter the chi-square that is
left. An error of the theory adds its covariance to that of the data.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.compare import statistics
from kinetics.crosscheck.compare.statistics import ChiSquare, covariance, whitening
from kinetics.crosscheck.compare.theory import Expectation, Point
from kinetics.crosscheck.data.sample import Sample

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

SECOND_MOMENTS = ("thermal_speed", "msd", "drift", "mean_displacement")  # that are fitted to
# of parameters that are fitted as they are; others are positive, and their logarithms fitted
LIMITS = {
    "restitution": (0.0, 1.0), "at_rest": (-0.5, 0.9), "time_offset": (-1e3, 1e3),
    "velocity_noise": (0.0, 1e3), "position_noise": (0.0, 1e6),
}  # fmt: skip
# restitution from which on, and number density up to which, there is a theory of dense media
LEAST_RESTITUTION, DENSEST = 0.2, 0.3
WIDEST = 12.0  # |ln| of the factor by which a positive parameter may differ from what was told
_STEP = 1e-4  # for derivatives: the solver's error of 1e-7 is 1e-3 of a slope of order 1


@dataclass(frozen=True, eq=False)
class Fit:
    """A point with some fitted parameters (`free`, perhaps none), and all that is known there.

    theory (n_names, n_times); known: the covariance of its own error, None for 0; at (k,): the
    parameters, or their logarithms, with their covariance; slope: d(theory)/d(at); influence (k, p)
    on `at` of the averages `fitted` (p,); shaped, replicates (G, ...): the difference of data and
    theory as `Expectation.stabilised`; widening: ln(det(C + M)/det C) of the chi-square.
    """

    point: Point
    free: tuple[str, ...]
    theory: Array
    known: Array | None
    at: Array
    covariance: Array
    slope: Array
    influence: Array
    fitted: Indices
    shaped: Array
    replicates: Array
    chi_square: ChiSquare | None = None
    widening: float = 0.0

    def value(self, name: str) -> tuple[float, float]:
        """A fitted parameter and its standard error."""
        k, value = self.free.index(name), float(getattr(self.point, name))
        error = float(np.sqrt(self.covariance[k, k]))
        return value, error if name in LIMITS else value * error

    @property
    def criterion(self) -> float:
        """-2 ln likelihood, to a constant, plus 2 for each parameter (Akaike's criterion)."""
        left = np.inf if self.chi_square is None else self.chi_square.value
        return float(left + self.widening + 2 * len(self.free))

    def moved(self, replicates: Array) -> Array:
        """Replicates of the difference (G, ...) with the shift of the fitted theory taken off."""
        flat = replicates.reshape(len(replicates), -1)[:, self.fitted]
        shift = (flat - flat.mean(axis=0)) @ self.influence.T
        return np.asarray(replicates - (shift @ self.slope.T).reshape(replicates.shape))


def coordinates(point: Point, free: Sequence[str]) -> Array:
    """Parameters of a point as they are fitted, (k,)."""
    values = {name: getattr(point, name) for name in free}
    return np.array([x if n in LIMITS else np.log(x) for n, x in values.items()])


def choose(usable: NDArray[np.bool_], groups: int, parameters: int) -> Indices:
    """Which components (n_names, n_times) can be tested together, evenly over time: flat."""
    most = max(statistics.most_freedom(groups), min(2 * parameters, groups - 2))
    rows = [(k, np.flatnonzero(row)) for k, row in enumerate(usable) if np.any(row)]
    share = max(1, most // max(len(rows), 1))
    at = [k * usable.shape[1] + row[statistics.spread_out(row.size, share)] for k, row in rows]
    return np.concatenate([np.empty(0, np.int64), *at])[:most]


def components_of(
    names: Sequence[str], usable: NDArray[np.bool_], groups: int, parameters: int
) -> tuple[Indices, Indices]:
    """The averages that are fitted, and those that enter the chi-square, as `choose`."""
    second = usable & np.isin(names, SECOND_MOMENTS)[:, None]
    return choose(second, groups, parameters), choose(usable, groups, parameters)


def fit(
    expectation: Expectation, told: Point, free: Sequence[str], components: tuple[Indices, Indices],
    starts: Sequence[Sequence[float]] = ((),),
) -> Fit | None:  # fmt: skip
    """Least squares from the best starts; None where nothing converges, or only at a limit.

    told: the point whose parameters `free` are fitted, none or more, from `starts` (see `Fit.at`).
    """
    groups, (chosen, tested) = expectation.sample.groups, components
    replicates = expectation.replicates.reshape(groups, -1)[:, chosen]
    values, low_high = expectation.values.ravel()[chosen], [_ends(name, told) for name in free]
    low, high = np.array(low_high).reshape(-1, 2).T

    def point(at: Array) -> Point:
        both = zip(free, at.tolist(), strict=True)
        changed: Any = {n: x if n in LIMITS else float(np.exp(x)) for n, x in both}
        return told._replace(**changed)

    def difference(at: Array) -> Array:
        with np.errstate(divide="ignore", invalid="ignore"):
            theory = expectation.theory(point(at)).ravel()[chosen]
            return np.asarray(np.log(values) - np.log(theory))

    def weights(at: Array) -> Array | None:
        theory = expectation.theory(point(at))
        known, size = expectation.own_covariance(point(at), theory), theory.ravel()[chosen]
        with np.errstate(divide="ignore", invalid="ignore"):
            left = np.log(replicates) - np.log(size)
        if not np.all(np.isfinite(left)):
            return None
        extra = 0.0 if known is None else known[np.ix_(chosen, chosen)] / np.outer(size, size)
        return whitening(covariance(left) + extra)

    best, white = np.empty(0), None
    if free:
        tried = []
        for start in starts:
            at = np.clip(np.asarray(start, float), low, high)
            if np.all(np.isfinite(left := difference(at))) and (found := weights(at)) is not None:
                tried.append((float(np.sum((found @ left) ** 2)), at, found))
        tried = sorted(tried, key=lambda one: one[0])[:2]
        ended = (_descended(difference, found, at, low, high) for _, at, found in tried)
        if not (reached := [one for one in ended if one is not None]):
            return None
        best = min(reached, key=lambda one: one[0])[1]
        margin = np.where([n in LIMITS for n in free], -1.0, 0.01 * (high - low))
        if np.any((best <= low + margin) | (best >= high - margin)):
            return None
        if (white := weights(best)) is None:
            return None
    at, theory = point(best), expectation.theory(point(best))
    known = expectation.own_covariance(at, theory)
    slope, influence = np.zeros((theory.size, 0)), np.zeros((0, chosen.size))
    spread: Array = np.zeros((0, 0))
    if white is not None:
        slope = _slopes(lambda p: expectation.theory(point(p)).ravel(), best, low, high)
        size = theory.ravel()[chosen]
        steep: Any = white @ (slope[chosen] / size[:, None])
        influence = np.linalg.pinv(steep) @ white / size
        # weights from a covariance that is estimated make errors larger
        rest = min(len(white) - best.size, groups - 3)
        spread = np.linalg.pinv(steep.T @ steep)
        spread *= (groups - 1) * (groups - 2) / (groups - 1 - rest) / (groups - 2 - rest)
    rows, widening = expectation.steadied(theory), 0.0
    shaped = expectation.stabilised(theory, expectation.values - theory)
    made = Fit(at, tuple(free), theory, known, best, spread, slope, influence, chosen, shaped, rows)
    left_of = made.moved(rows)
    if known is not None:
        # of the data themselves: the same for all that is fitted in a medium
        spread_of, own = rows.reshape(groups, -1)[:, tested], known[np.ix_(tested, tested)]
        widening = statistics.log_widening(spread_of, own)
        passed = np.eye(theory.size)[tested]  # what an error of the theory leaves of itself
        passed[:, chosen] -= slope[tested] @ influence
        usable = np.any(passed != 0, axis=0)
        known = passed[:, usable] @ known[np.ix_(usable, usable)] @ passed[:, usable].T
    of_tested = left_of.reshape(groups, -1)[:, tested]
    after = statistics.hotelling(shaped.ravel()[tested], of_tested, known)
    return replace(made, replicates=left_of, chi_square=after, widening=widening)


def media_of(sample: Sample, asked: str, point: Point | None = None) -> list[str]:
    """The media that the scatterers may be; of dense ones there is a theory for smooth disks.

    "every" has overlapping disks too, which differ from hard ones by a twentieth of the density.
    """
    if asked not in ("auto", "every"):
        return [asked]
    dense = sample.law.smooth_disks and not sample.free
    if point is not None and dense:
        dense &= sample.law.free_path(point.path) <= DENSEST
        dense &= point.restitution >= LEAST_RESTITUTION
    return ["dilute", "hard disks", "overlapping"][: 1 + dense + (dense and asked == "every")]


def _ends(name: str, told: Point) -> tuple[float, float]:
    """Between what a parameter, or its logarithm, is looked for."""
    dense, low, high = told.scatterers != "dilute", *LIMITS.get(name, (-np.inf, np.inf))
    if name not in LIMITS:
        middle = float(np.log(getattr(told, name)))
        low, high = middle - WIDEST, middle + WIDEST
    least = {"restitution": LEAST_RESTITUTION, "path": -np.log(2 * DENSEST)} if dense else {}
    return max(low, least.get(name, low)), high


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
