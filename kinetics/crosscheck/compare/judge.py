"""Data and theory side by side, and the verdicts on them: rows, tests and the summary."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.compare.fit import Fit
from kinetics.crosscheck.compare.result import COLUMNS, OBSERVABLES, ComparisonTest, Explanation
from kinetics.crosscheck.compare.statistics import (
    ChiSquare,
    effective_groups,
    errors,
    hotelling,
    most_freedom,
    of_the_worst,
    pearson,
    spread_out,
)
from kinetics.crosscheck.compare.theory import (
    DISPLACEMENT,
    SPEED,
    Expectation,
    Point,
    SampledStart,
    average_of,
    bin_shares,
)
from kinetics.crosscheck.data.sample import Binned, Sample
from kinetics.crosscheck.words import (
    Verdict,
    corrected_sigmas,
    gaussian_sigmas,
    judge_sigmas,
    numeral,
)
from kinetics.errors import InputError
from kinetics.states.isotropic import Monoenergetic

if TYPE_CHECKING:
    from kinetics import Solution

Array = NDArray[np.float64]

HISTOGRAM_TIMES = 6
"""Times at which densities are compared, at most: each takes the solver some 0.1 s."""
NO_SPREAD = 1e-9
"""Standard error over value below which the data have no spread: a start with one speed."""
LEAST_EXPECTED = 50
"""Samples that a bin must be expected to hold: their distribution is then nearly Gaussian."""
MOST_IN_A_BIN = 1 / 12
"""Share of the samples from which on a bin is not made wider, so that the body has a shape."""
_MOST_BINS = 40
_SAME = 1e-6
"""Relative difference up to which data without spread agree with the theory: ten times the
tolerance that the solver is given."""
_KNOWN_AT_ZERO = (
    "msd", "kurtosis", "mean_displacement", "dispersion_parallel", "dispersion_perpendicular",
)  # fmt: skip
"""Averages of the displacement, which say nothing at time 0."""


@dataclass(frozen=True, eq=False)
class Histogram:
    """One histogram at one time against the theory, in bins of LEAST_EXPECTED samples or more.

    time in d/U, and its index in the sample; edges (n + 1,), in U or d: the first is 0, the last
    infinite; share of the samples, its standard error (from `groups` groups) and the theory, (n,).
    """

    name: str
    time: float
    index: int
    edges: Array
    share: Array
    error: Array
    theory: Array
    samples: int
    groups: int
    chi_square: ChiSquare | None


@dataclass(frozen=True, eq=False)
class Both:
    """A sample and a solution side by side: what rows, tests, figures and causes are made of.

    theory, difference, error (n_names, n_times); replicates (G, n_names, n_times) of the
    difference; compared: where there is something to compare; usable: and where it has spread.
    densities: the solution of each density. histograms: one for each density and time. found: the
    fit to these averages that the theory's numbers come from.
    """

    sample: Sample
    solution: "Solution"
    point: Point
    expectation: Expectation
    theory: Array
    difference: Array
    replicates: Array
    error: Array
    compared: NDArray[np.bool_]
    usable: NDArray[np.bool_]
    densities: "Mapping[str, Solution]"
    histograms: list[Histogram]
    found: Fit | None

    @property
    def names(self) -> tuple[str, ...]:
        """The averages, in the order of the first axis of the arrays."""
        return self.expectation.names

    @property
    def own_start(self) -> bool:
        """Whether the theory starts from the speeds of the sample at time 0."""
        return isinstance(self.point.start, SampledStart)

    def flat(self, chosen: NDArray[np.int64]) -> tuple[Array, Array]:
        """Some of the differences (p,), by their flat indices, and replicates of them (G, p)."""
        replicates = self.replicates.reshape(self.sample.groups, -1)
        return self.difference.ravel()[chosen], replicates[:, chosen]


def side_by_side(
    solution: "Solution", sample: Sample, names: Sequence[str], found: Fit | None,
    densities: "Mapping[str, Solution]",
) -> Both:  # fmt: skip
    """A sample and the solution of its averages, at its times; and of densities, at some of them.

    found: the fit to the same averages that the solution's numbers come from. InputError where the
    sample has fewer than two groups.
    """
    if sample.groups < 2:
        raise InputError("data: has fewer than two groups; there are no standard errors")
    expectation, point = Expectation(sample, names), Point.of(solution.scene)
    own_start = isinstance(point.start, SampledStart)
    if own_start:
        theory, moved = expectation.theory(point)
    else:
        theory = moved = np.stack([average_of(solution, name) for name in names])
    difference, replicates = expectation.values - theory, expectation.replicates - moved
    if found is not None:  # data that were fitted move the theory with them
        replicates = found.moved(replicates)
    error, compared = errors(replicates), np.isfinite(difference)
    for k, name in enumerate(names):
        if own_start or name in _KNOWN_AT_ZERO:
            compared[k] &= sample.times > 0
    with np.errstate(invalid="ignore"):
        size = np.maximum(np.abs(expectation.values), np.abs(theory))
        usable = compared & (error > NO_SPREAD * size) & np.isfinite(error)
    histograms = [
        result
        for name, density in densities.items()
        if getattr(sample, _COUNTS[name]) is not None
        for at, time in enumerate(density.times)
        if (result := _histogram(sample, density, name, at, time)) is not None
    ]
    return Both(
        sample, solution, point, expectation, theory, difference, replicates, error, compared,
        usable, densities, histograms, found,
    )  # fmt: skip


def histogram_times(sample: Sample) -> list[int]:
    """The indices of the times at which densities are compared."""
    later = np.flatnonzero(sample.times > 0)
    return [int(later[k]) for k in spread_out(later.size, HISTOGRAM_TIMES)]


# -- histograms ------------------------------------------------------------------------------------


_COUNTS = {SPEED: "speeds", DISPLACEMENT: "displacements"}


def _histogram(
    sample: Sample, solution: "Solution", name: str, at: int, time: float
) -> Histogram | None:
    """A sample's histogram against a solution's density at its time of the index `at`."""
    index = int(np.argmin(np.abs(sample.times - time)))
    binned = getattr(sample, _COUNTS[name])
    samples = int(binned.totals[index].sum())
    shares = bin_shares(solution, name, at, binned.edges[index])
    shares = shares / shares.sum()
    independent = sample.grouping != "medium" or sample.free
    most = _MOST_BINS
    if not independent and binned.by_group is not None:
        most = min(most, most_freedom(len(binned.by_group)) + 1)
    peak = None
    if isinstance(solution.scene.state, Monoenergetic):
        peak = solution.scene.state.speed * (1.0 if name == SPEED else sample.times[index])
    starts = _merged(shares * samples, samples, most, binned.edges[index], peak)
    if starts.size < 2:
        return None
    theory = np.add.reduceat(shares, starts)
    counts = np.add.reduceat(binned.totals[index], starts).astype(float)
    share = counts / samples
    edges = np.concatenate([[0.0], binned.edges[index][starts[1:] - 1], [np.inf]])
    error, groups = _errors(binned, index, starts, share, samples)
    # The spread of a bin that is emptier than expected is too small: at least binomial.
    error = np.maximum(error, np.sqrt(theory * (1 - theory) / samples))
    if independent or groups is None:
        effect = 1.0 if binned.design_effect is None else float(binned.design_effect[index])
        chi_square = pearson(counts, theory * samples, effect)
    else:  # left out in turn: the shares of all but one group
        rest = counts - groups
        replicates = rest / rest.sum(axis=1, keepdims=True) - theory
        chi_square = hotelling((share - theory)[:-1], replicates[:, :-1])
    behind = sample.groups if binned.by_group is None else len(binned.by_group)
    return Histogram(
        name, float(time), index, edges, share, error, theory, samples, behind, chi_square
    )


def _errors(
    binned: Binned, index: int, starts: NDArray[np.int64], share: Array, samples: int
) -> tuple[Array, Array | None]:
    """Standard errors of the shares, and the counts of each group if they are known."""
    if binned.by_group is None:
        assert binned.design_effect is not None
        return np.sqrt(share * (1 - share) / samples * binned.design_effect[index]), None
    groups = np.add.reduceat(binned.by_group[:, index].astype(float), starts, axis=1)
    spread = groups - share * groups.sum(axis=1, keepdims=True)
    n = len(groups)
    return np.sqrt(n / (n - 1) * np.sum(spread**2, axis=0)) / samples, groups


def _merged(
    expected: Array, samples: int, most: int, edges: Array, peak: float | None
) -> NDArray[np.int64]:
    """The first fine bin of each bin, from the counts expected in the fine bins."""
    widest = max(samples * MOST_IN_A_BIN, samples / most * 2, LEAST_EXPECTED)
    starts, held, before = [0], 0.0, 0.0
    for k, count in enumerate(expected[:-1].tolist()):
        held += count
        target = min(max(min(before, (samples - before) / 2), LEAST_EXPECTED), widest)
        on_peak = peak is not None and abs(edges[min(k, edges.size - 1)] - peak) < 1e-6 * peak
        if held >= target and samples - before - held >= LEAST_EXPECTED and not on_peak:
            starts.append(k + 1)
            before += held
            held = 0.0
    while len(starts) > most:  # where the tails alone are too many, every second edge goes
        starts = starts[::2]
    return np.array(starts)


# -- rows and tests --------------------------------------------------------------------------------


def rows_of(both: Both) -> list[dict[str, Any]]:
    """One row per observable and time, and per bin of a density; see `Comparison.rows`."""
    rows = [*_rows_over_time(both)]
    for name in both.densities:
        mine = [histogram for histogram in both.histograms if histogram.name == name]
        looks = sum(histogram.share.size for histogram in mine)
        for h in mine:
            width = np.where(np.isfinite(h.edges[1:]), np.diff(h.edges), 1.0)
            for k, wide in enumerate(width.tolist()):
                value, error, theory = (float(a[k] / wide) for a in (h.share, h.error, h.theory))
                sigmas = float((h.share[k] - h.theory[k]) / h.error[k])
                corrected = corrected_sigmas(sigmas, h.groups, looks)
                low, high = h.edges[k : k + 2].tolist()
                rows.append(
                    _row(name, h.time, value, error, theory, sigmas, judge_sigmas(corrected),
                         corrected, h.samples, low, high if np.isfinite(high) else None)
                )  # fmt: skip
    return rows


def _rows_over_time(both: Both) -> Iterator[dict[str, Any]]:
    sample, effective = both.sample, effective_groups(both.replicates)
    for i, name in enumerate(both.names):
        looks = int(both.usable[i].sum())
        for k in np.flatnonzero(both.compared[i]).tolist():
            value, theory = float(both.expectation.values[i, k]), float(both.theory[i, k])
            sigmas, corrected, error = None, None, 0.0
            if both.usable[i, k]:
                error = float(both.error[i, k])
                sigmas = float(both.difference[i, k] / error)
                corrected = corrected_sigmas(sigmas, float(effective[i, k]), looks)
                verdict = judge_sigmas(corrected)
            elif sample.groups < 3 or (sample.law.field and sample.times[k] > 0):
                # One tracer is always like itself, and falls before its first collision as others.
                verdict = Verdict.UNDEFINED
            else:
                same = abs(value - theory) <= _SAME * max(abs(value), abs(theory), 1e-300)
                verdict = Verdict.AGREES if same else Verdict.DIFFERS
            count = 0 if sample.tabulated else int(sample.samples[k])
            time = float(sample.times[k])
            yield _row(name, time, value, error, theory, sigmas, verdict, corrected, count)


def _row(*values: Any) -> dict[str, Any]:
    return dict(zip(COLUMNS, (*values, None, None)[:11], strict=True))


def tests_of(both: Both) -> list[ComparisonTest]:
    """One chi-square per average, over all its times, and per density and time."""
    found = [(name, None, _over_times(both, i)) for i, name in enumerate(both.names)]
    every = [*found, *((h.name, h.time, h.chi_square) for h in both.histograms)]
    known = [(name, time, c) for name, time, c in every if c is not None]
    tests = []
    for name, time, c in known:
        sigmas = gaussian_sigmas(min(1.0, c.p_value * len(known)))
        verdict, within = judge_sigmas(sigmas), None
        if time is None:
            i = both.names.index(name)
            within, verdict = _within(both, i), worst_of([verdict, _verdict_of_times(both, i)])
        tests.append(
            ComparisonTest(
                name, time, c.value, c.freedom, c.p_value, c.groups, sigmas, verdict, within
            )
        )
    return tests


def _over_times(both: Both, i: int) -> ChiSquare | None:
    """The chi-square of one average."""
    times = np.flatnonzero(both.usable[i])
    if not times.size:
        return None
    difference = both.difference[i, times] / both.error[i, times]
    if both.sample.tabulated:
        return of_the_worst(difference)
    most = most_freedom(both.sample.groups)
    replicates = both.replicates[:, i, times] / both.error[i, times]
    if times.size > most:
        starts = np.arange(most) * times.size // most
        difference = np.add.reduceat(difference, starts)
        replicates = np.add.reduceat(replicates, starts, axis=1)
    return hotelling(difference, replicates)


def _verdict_of_times(both: Both, i: int) -> Verdict:
    """The verdict on the time of an average that differs most, out of all times of all averages."""
    looks = 2 * int(both.usable.sum())
    effective = effective_groups(both.replicates[:, i])
    z = both.difference[i] / np.where(both.usable[i], both.error[i], 1.0)
    return worst_of(
        judge_sigmas(corrected_sigmas(float(z[k]), float(effective[k]), looks))
        for k in np.flatnonzero(both.usable[i])
    )


def _within(both: Both, i: int) -> float:
    """The relative difference that the data exclude at every time, at 95 %: |d| + 2 sigma."""
    usable = both.usable[i]
    size = np.abs(both.theory[i] + (1.0 if both.names[i] == "a2" else 0.0))[usable]
    if both.sample.law.field:
        size = np.full(size.size, size.max())
    return float(np.max((np.abs(both.difference[i]) + 2 * both.error[i])[usable] / size))


def worst_of(verdicts: Any) -> Verdict:
    """The worst of some verdicts; undefined without any."""
    order, words = (Verdict.DIFFERS, Verdict.UNCLEAR, Verdict.AGREES), {*verdicts}
    return next((verdict for verdict in order if verdict in words), Verdict.UNDEFINED)


def overall(rows: Sequence[Mapping[str, Any]], tests: Sequence[ComparisonTest]) -> Verdict:
    """The worst verdict of the tests, and of rows without spread, which no test can hold."""
    words = [test.verdict for test in tests]
    return worst_of(words + [row["verdict"] for row in rows if row["sigmas"] is None])


def summary(
    both: Both,
    tests: Sequence[ComparisonTest],
    verdict: Verdict,
    best: Explanation | None,
    start: str,
) -> str:
    """The verdict in a sentence, what was compared, and the clearest difference."""
    cause = best.headline if best is not None else ""
    within = [
        f"{numeral(min(t.within, 10.0), '.2g' if t.within < 0.001 else '.2%')} for "
        f"{OBSERVABLES[t.observable].short}" for t in tests if t.within is not None
    ]  # fmt: skip
    answers = {
        Verdict.AGREES: f"No difference seen, better than {', '.join(within) or 'no average'}.",
        Verdict.UNCLEAR: "A difference is possible, but more samples would have to show it"
        f"{f'; {cause} would explain it' if cause else ''}.",
        Verdict.DIFFERS: f"They differ{f'; {cause} explains it' if cause else ''}.",
    }
    answer = answers.get(verdict, "Nothing could be tested.")
    if best is not None and best.outcome == "found":
        answer = f"A unit is wrong: {cause}. Nothing else can be said before that is put right."
    scene, sample, form = both.solution.scene, both.sample, "{} = {}".format
    told = [form("e", numeral(scene.restitution, ".6g"))]
    if scene.tangential_restitution != 1:
        told.append(form("e_t", numeral(scene.tangential_restitution or 0.0, ".6g")))
    unit = "d⁻²" if scene.dimension == 2 else "d⁻³"
    told.append(form("ρ₀", f"{numeral(scene.number_density, '.6g')} {unit}"))
    if scene.field:
        told.append(f"a field of {numeral(scene.field, '.6g')} U²/d")
    data = "A table of averages" if sample.tabulated else f"{int(sample.samples.max())} tracers"
    answer += (
        f" {data} at {sample.times.size} times from {numeral(sample.times[0], '.4g')} to "
        f"{numeral(sample.times[-1], '.4g')} d/U, compared with the kinetic equation with "
        f"{' and '.join(told)}, from {start}."
    )
    odd = [test for test in tests if test.verdict is not Verdict.AGREES]
    if odd:
        least = min(odd, key=lambda test: test.p_value)
        at = "" if least.time is None else f" at t = {numeral(least.time, '.4g')}"
        answer += (
            f" Of {len(tests)} tests {len(odd)} do not agree; the clearest is "
            f"{least.observable.replace('_', ' ')}{at}: chi-square "
            f"{numeral(least.chi_square, '.4g')} with {least.dof} degrees of freedom, "
            f"p = {numeral(least.p_value, '.2g')}."
        )
    return answer
