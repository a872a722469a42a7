"""One least-squares fit: for what was told, for what was not, and for every cause of a difference.

Parameters are fitted to the logarithms of second moments (v0 and <r^2>) alone: a few fast tracers
raise a fourth moment and its variance, so that weights from the same tracers favour low values
(Altonji and Segal, J. Bus. Econ. Stat. 14, 353 (1996)). All averages enter the chi-square that is
left. An error of the theory adds its covariance to that of the data.

Errors are correlated, and known only from the spread of groups. Of a vector d of differences the
covariance C is the jackknife spread of `replicates`, the same with each of G groups left out in
turn. T^2 = d C^-1 d is then no chi-square, but T^2 (G - p)/(p (G - 1)) has the F-distribution with
p and G - p degrees of freedom (Hotelling), for groups that are not Gaussian with `effective_groups`
as G. What is reported is the chi-square that has its p-value.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import betainc, gammainccinv

from kinetics.collision.medium import HIGHEST_DENSITY, LEAST_RESTITUTION
from kinetics.crosscheck.compare.theory import Expectation, Point, spread_of_ratio
from kinetics.crosscheck.data.sample import Sample, effective_groups, errors
from kinetics.crosscheck.words import Verdict, gaussian_sigmas, judge_sigmas

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

SECOND_MOMENTS = ("thermal_speed", "msd")  # that are fitted to
# of parameters that are fitted as they are; others are positive, and their logarithms fitted
LIMITS = {
    "restitution": (0.0, 1.0), "at_rest": (-0.5, 0.9), "time_offset": (-1e3, 1e3),
    "velocity_noise": (0.0, 1e3), "position_noise": (0.0, 1e6),
}  # fmt: skip
#: Standard error over value up to which the scatter of an exactly known average (|v| of elastic
#: tracers) is rounding, of data in single precision or in seven digits. Above what these have.
ROUNDING_OF_EXACT = 1e-6
_AT_ZERO = ("drift", "thermal_speed", "a2")  # the averages that say something at time 0


class ChiSquare(NamedTuple):
    """A chi-square; groups that the covariance is from, None if it is exact; statistic: T^2."""

    value: float
    freedom: int
    p_value: float
    groups: int | None
    statistic: float

    @property
    def verdict(self) -> Verdict:
        """On what is left, without a correction for the number of looks."""
        return judge_sigmas(gaussian_sigmas(self.p_value))


@dataclass(eq=False)
class Fit:
    """A sample beside its theory at a point, with some fitted parameters (`free`, perhaps none).

    Given: theory (n_names, n_times); known: the covariance of its own error, None for 0; at (k,):
    the parameters, or their logarithms, with their covariance; slope: d(theory)/d(at); influence
    (k, p) on `at` of the averages `fitted` (p,).

    Of these, (n_names, n_times) each: difference of data and theory; error (with the theory's own),
    and bars, that of rows; shaped: the difference as `Expectation.stabilised`, with its replicates
    (G, ...), and sigmas; effective groups; compared: where there is something to compare; usable:
    and where it has spread. chi_square of those tested; criterion: Akaike's, -2 ln likelihood + 2
    len(free) + const.
    """

    expectation: Expectation
    point: Point
    theory: Array
    known: Array | None
    free: tuple[str, ...]
    at: Array
    covariance: Array
    slope: Array
    influence: Array
    fitted: Indices
    chi_square: ChiSquare | None = None
    criterion: float = np.inf

    def __post_init__(self) -> None:
        measured, sample, theory = self.expectation, self.expectation.sample, self.theory
        least = np.where(measured.exact(self.point), ROUNDING_OF_EXACT, 1e-9)
        early = np.isin(measured.names, () if self.point.own_start else _AT_ZERO)[:, None]
        with np.errstate(divide="ignore", invalid="ignore"):
            self.difference = measured.values - theory
            self.shaped = measured.stabilised(theory, self.difference)
            self.steady = steadied(measured, theory, measured.spread_of_a2(self.point))
            self.replicates = self._moved(self.steady)
            plain = measured.replicates - theory
            error = errors(self._moved(plain))
            own = 0.0 if self.known is None else np.diagonal(self.known).reshape(error.shape)
            self.sigmas = self.shaped / np.sqrt(errors(self.replicates) ** 2 + own)
            self.error = np.sqrt(error**2 + own)
            # as the verdicts have it, whose replicates are steadied
            scatter = errors(measured.stabilised(theory, plain))
            wider = errors(self.steady) / scatter
            # of rounding noise there is no ratio
            is_scatter = spread_in(scatter, measured.values, theory, least=least)
            wider = np.where(is_scatter & np.isfinite(wider), wider, 1)
            self.bars = np.sqrt((error * wider) ** 2 + own)
        self.compared = np.isfinite(self.difference) & (early | (sample.times > 0))
        self.usable = self.compared & spread_in(error, measured.values, theory, least=least)
        self.effective = effective_groups(self.replicates)

    def _moved(self, replicates: Array) -> Array:
        """Replicates of the difference (G, ...) with the shift of the fitted theory taken off."""
        flat = replicates.reshape(len(replicates), -1)[:, self.fitted]
        shift = (flat - flat.mean(axis=0)) @ self.influence.T
        return np.asarray(replicates - (shift @ self.slope.T).reshape(replicates.shape))

    def flat(self, chosen: Indices) -> tuple[Array, Array, Array | None]:
        """Some of the differences (p,), by their flat indices: the arguments of a chi-square."""
        known = None if self.known is None else self.known[np.ix_(chosen, chosen)]
        replicates = self.replicates.reshape(len(self.replicates), -1)[:, chosen]
        return self.shaped.ravel()[chosen], replicates, known

    def value(self, name: str) -> tuple[float, float]:
        """A fitted parameter and its standard error."""
        k, value = self.free.index(name), float(getattr(self.point, name))
        error = float(np.sqrt(self.covariance[k, k]))
        return value, error if name in LIMITS else value * error


def choose(usable: NDArray[np.bool_], groups: int, parameters: int = 1) -> Indices:
    """Which components (n_names, n_times) can be tested together, evenly over time: flat."""
    most = max(most_freedom(groups), min(2 * parameters, groups - 2))
    rows = [(k, np.flatnonzero(row)) for k, row in enumerate(usable) if np.any(row)]
    share = max(1, most // max(len(rows), 1))
    at = [k * usable.shape[1] + row[spread_out(row.size, share)] for k, row in rows]
    return np.concatenate([np.empty(0, np.int64), *at])[:most]


def fit(
    expectation: Expectation, told: Point, free: Sequence[str], usable: NDArray[np.bool_],
    starts: Sequence[Any] = (), parameters: int = 1,
) -> Fit | None:  # fmt: skip
    """Least squares from the best starts; None where nothing converges, or only at a limit.

    told: the point whose parameters `free` are fitted, none or more, from `starts` (see `Fit.at`).
    usable: the averages (n_names, n_times) that can be tested, as many as for so many `parameters`.
    """
    groups, theory_of = expectation.sample.groups, expectation.theory
    second = usable & np.isin(expectation.names, SECOND_MOMENTS)[:, None]
    chosen, tested = (choose(one, groups, parameters) for one in (second, usable))
    replicates = expectation.replicates.reshape(groups, -1)[:, chosen]
    values, low_high = expectation.values.ravel()[chosen], [_ends(name, told) for name in free]
    low, high = np.array(low_high).reshape(-1, 2).T

    def point(at: Array) -> Point:
        both = zip(free, at.tolist(), strict=True)
        changed: Any = {n: x if n in LIMITS else float(np.exp(x)) for n, x in both}
        return told._replace(**changed)

    def difference(at: Array) -> Array:
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(np.log(values) - np.log(theory_of(point(at)).ravel()[chosen]))

    def weights(at: Array) -> Array:
        theory = theory_of(point(at))
        known, size = expectation.own_covariance(point(at), theory), theory.ravel()[chosen]
        extra = 0.0 if known is None else known[np.ix_(chosen, chosen)] / np.outer(size, size)
        return whitening(covariance(np.log(replicates)) + extra)

    best, white = np.empty(0), np.empty((0, 0))
    if free:
        if chosen.size < len(free) or not np.all(replicates > 0):
            return None
        from scipy.optimize import least_squares

        tried, reached = [], []
        for start in starts:
            at = np.clip(np.asarray(start, float), low, high)
            if np.all(np.isfinite(left := difference(at))):
                found = weights(at)
                tried.append((float(np.sum((found @ left) ** 2)), at, found))
        for _, at, found in sorted(tried, key=lambda one: one[0])[:2]:
            with suppress(ValueError, np.linalg.LinAlgError):  # the theory is not finite there
                reached.append(least_squares(
                    lambda at, white: white @ difference(at), at,
                    lambda at, white: white @ _slopes(difference, at, low, high),
                    (low, high), "dogbox", ftol=1e-5, xtol=1e-6, max_nfev=50, args=(found,),
                ))  # fmt: skip
        if not reached:
            return None
        best = min(reached, key=lambda one: one.cost).x
        margin = np.where([n in LIMITS for n in free], -1.0, 0.01 * (high - low))
        if np.any((best <= low + margin) | (best >= high - margin)):
            return None
        white = weights(best)
    at, theory = point(best), theory_of(point(best))
    known = expectation.own_covariance(at, theory)
    slope, influence = np.zeros((theory.size, 0)), np.zeros((0, chosen.size))
    spread: Array = np.zeros((0, 0))
    if free:
        slope = _slopes(lambda p: theory_of(point(p)).ravel(), best, low, high)
        size = theory.ravel()[chosen]
        steep: Any = white @ (slope[chosen] / size[:, None])
        # A parameter that is held at a limit does not follow the data.
        inside = (best > low) & (best < high)
        influence = np.linalg.pinv(steep * inside) @ white / size
        # weights from a covariance that is estimated make errors larger
        rest = min(len(white) - best.size, groups - 3)
        spread = np.linalg.pinv(steep.T @ steep)
        spread *= (groups - 1) * (groups - 2) / (groups - 1 - rest) / (groups - 2 - rest)
    made = Fit(expectation, at, theory, known, tuple(free), best, spread, slope, influence, chosen)
    # What a fit follows exactly has only rounding left: no covariance to test it by.
    tested = tested[made.usable.ravel()[tested]]
    shaped, left_of, own = made.flat(tested)
    widening = 0.0  # ln(det(C + M)/det C) of the chi-square, M the theory's own covariance
    if known is not None and own is not None:
        # of the data themselves: the same for all that is fitted in a medium
        axes = whitening(covariance(made.steady.reshape(groups, -1)[:, tested]))
        widening = float(np.linalg.slogdet(np.eye(len(axes)) + axes @ own @ axes.T)[1])
        passed = np.eye(theory.size)[tested]  # what an error of the theory leaves of itself
        passed[:, chosen] -= slope[tested] @ influence
        own = passed @ known @ passed.T
    made.chi_square = hotelling(shaped, left_of, own)
    if made.chi_square is not None:
        made.criterion = made.chi_square.value + widening + 2 * len(free)
    return made


def media_of(sample: Sample, asked: str, point: Point | None = None) -> list[str]:
    """The media that the scatterers may be; of dense ones there is a theory for smooth disks.

    "every" has overlapping disks too, which differ from hard ones by a twentieth of the density.
    """
    if asked not in ("auto", "every"):
        return [asked]
    dense = sample.law.smooth_disks and not sample.free
    if point is not None and dense:
        dense &= sample.law.free_path(point.path) <= HIGHEST_DENSITY
        dense &= point.restitution >= LEAST_RESTITUTION
    return ["dilute", "hard disks", "overlapping"][: 1 + dense + (dense and asked == "every")]


def _ends(name: str, told: Point, widest: float = 12.0) -> tuple[float, float]:
    """Between what a parameter is looked for, or its logarithm, `widest` from what was told."""
    low, high = LIMITS.get(name, (-np.inf, np.inf))
    if name not in LIMITS:
        middle = float(np.log(getattr(told, name)))
        low, high = middle - widest, middle + widest
    least = {"restitution": LEAST_RESTITUTION, "path": -np.log(2 * HIGHEST_DENSITY)}
    return low if told.scatterers == "dilute" else max(low, least.get(name, low)), high


def _slopes(
    function: Callable[[Array], Array], at: Array, low: Array, high: Array, step: float = 1e-4
) -> Array:
    """Derivatives (p, k), centred where there is room; the solver's 1e-7 is 1e-3 of a slope."""
    steps = step * np.eye(at.size)
    ends = [(np.minimum(at + one, high), np.maximum(at - one, low)) for one in steps]
    made = [(function(up) - function(down)) / np.sum(up - down) for up, down in ends]
    return np.stack(made, axis=1)


def steadied(measured: Expectation, theory: Array, spread_of_a2: Array | None = None) -> Array:
    """The replicates of differences, as `stabilised`, where the error of a2 and of the kurtosis is
    a mean of theirs and of that of independent tracers: of 500 tracers few make <v^8> and <r^8>.

    That of a2 is the kinetic equation's; that of the kurtosis is of a Gaussian of random width
    (gamma-distributed, so that it has the theory's kurtosis) in each component, good to 20 %. The
    mean is by (effective) groups (Smyth, Stat. Appl. Genet. Mol. Biol. 3, 3 (2004)): 10 of the
    kurtosis, 20 of a2, whose error never becomes less, as tracers may share scatterers.
    """
    found = measured.stabilised(theory, measured.replicates - theory)
    known = [] if spread_of_a2 is None else [("a2", spread_of_a2, 20.0, 1.0)]
    if "kurtosis" in measured.names:
        x, d = theory[measured.names.index("kurtosis")], measured.sample.law.dimension
        wider = x / measured.sample.law.gaussian - 1
        sixth = (d + 2) * (d + 4) / d**2 * (1 + wider) * (1 + 2 * wider)
        variance = spread_of_ratio(x, sixth, sixth * (d + 6) / d * (1 + 3 * wider))
        known.append(("kurtosis", np.where(wider >= 0, variance, np.nan), 10.0, 0.0))
    for name, variance, groups, least in known:
        k = measured.names.index(name)
        own, mine = errors(found[:, k]), effective_groups(found[:, k])
        ratio = np.maximum(np.sqrt(variance / measured.sample.samples) / own, least)
        factor = np.sqrt((mine + groups * ratio**2) / (mine + groups))
        factor, middle = np.where(np.isfinite(factor), factor, 1.0), found[:, k].mean(axis=0)
        found[:, k] = middle + factor * (found[:, k] - middle)
    return found


# -- chi-squares -----------------------------------------------------------------------------------
def covariance(replicates: Array) -> Array:
    """Covariance from delete-one replicates (G, p): (p, p)."""
    n, deviation = len(replicates), replicates - replicates.mean(axis=0)
    return np.asarray((n - 1) / n * (deviation.T @ deviation))


def most_freedom(groups: int) -> int:
    """Components that a chi-square from so many groups may have."""
    return max(1, (groups - 1) // 4)  # or the covariance is too uncertain


def spread_out(count: int, most: int) -> list[int]:
    """At most so many of the indices 0 .. count - 1, evenly, with the last."""
    if count <= most:
        return list(range(count))
    return sorted({round(count - 1 - k * (count - 1) / max(most - 1, 1)) for k in range(most)})


def spread_in(error: Array, *values: Array, least: float | Array = 1e-9) -> NDArray[np.bool_]:
    """Where standard errors are more than rounding: over the value at least `least`."""
    with np.errstate(invalid="ignore"):
        size = np.max(np.abs(values), axis=0)
        return np.asarray((error > least * size) & np.isfinite(error))


def whitening(matrix: Array, least: float = 1e-9) -> Array:
    """W with W C W^T = 1 on the components that C has: (rank, p).

    least: eigenvalue of correlations, to the largest, below which two components are the same.
    """
    scale = np.sqrt(np.diagonal(matrix))
    scale = np.where(scale > 0, scale, np.inf)
    values, vectors = np.linalg.eigh(matrix / np.outer(scale, scale))
    kept = values > least * values.max(initial=1e-300)
    return np.asarray((vectors[:, kept] / np.sqrt(values[kept])).T / scale)


def hotelling(difference: Array, replicates: Array, known: Array | None = None) -> ChiSquare | None:
    """Test of a difference (p,) with its replicates (G, p); None without freedom.

    known (p, p): the covariance of an error of the theory, which is added.
    """
    groups = len(replicates)
    if difference.size == 0:
        return None
    axes = whitening(covariance(replicates) + (0.0 if known is None else known))
    white = axes @ difference
    freedom, statistic = white.size, float(white @ white)
    if freedom == 0 or groups <= freedom:
        return None
    effective = max(float(effective_groups(replicates @ axes.T).mean()), freedom + 1.0)
    # the upper tail of the F-distribution; a p-value below doubles is 0
    share = 1 / (1 + statistic / (effective - 1))
    p_value = float(betainc((effective - freedom) / 2, freedom / 2, share))
    value = 2 * float(gammainccinv(freedom / 2, p_value)) if p_value > 1e-300 else statistic
    return ChiSquare(value, freedom, p_value, groups, statistic)
