"""Data and theory side by side, and the verdicts on them: rows, tests and the summary."""

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinetics import Solution
from kinetics.crosscheck import words
from kinetics.crosscheck.compare import statistics
from kinetics.crosscheck.compare.fit import Fit
from kinetics.crosscheck.compare.result import ComparisonTest, Explanation, Row
from kinetics.crosscheck.compare.statistics import ChiSquare
from kinetics.crosscheck.compare.theory import (
    OBSERVABLES,
    SPEED,
    Expectation,
    bin_shares,
    rtol_of,
    stabilised,
    steadied,
)
from kinetics.crosscheck.data.sample import Sample
from kinetics.crosscheck.words import Verdict, numeral
from kinetics.errors import InputError

Array = NDArray[np.float64]

# standard error over value below which the data have no spread: a start with one speed
NO_SPREAD = 1e-9
# samples that a bin must be expected to hold: their distribution is then nearly Gaussian
LEAST_EXPECTED = 50
# share of the samples from which on a bin is not made wider, so that the body has a shape
MOST_IN_A_BIN = 1 / 12
_MOST_BINS = 40
_AT_ZERO = ("drift", "thermal_speed", "a2")  # the averages that say something at time 0


class Histogram(NamedTuple):
    """One density at one time against the theory.

    edges (n + 1,), of densities the first is 0 and the last infinite; shares of the samples with
    errors, theory (n,).
    """

    name: str
    time: float
    edges: Array
    share: Array
    error: Array
    theory: Array
    samples: int
    groups: int
    chi_square: ChiSquare | None


class Both:
    """A sample and its theory side by side: what rows, tests and causes are made of.

    theory, difference, error (n_names, n_times); replicates (G, n_names, n_times) of the difference
    shaped, shaped_replicates, sigmas, effective : differences as `stabilised`, these in standard
        errors, and the groups that the errors are as good as
    known (p_all, p_all) : covariance of the theory's own error, None where it has none
    compared : where there is something to compare; usable : and where it has spread
    """

    def __init__(
        self, expectation: Expectation, found: Fit, densities: dict[str, Solution]
    ) -> None:
        self.expectation, self.point, self.found = expectation, found.point, found
        self.sample, self.names, self.densities = expectation.sample, expectation.names, densities
        if self.sample.groups < 2:
            raise InputError("data: fewer than two groups; there are no standard errors")
        self.theory = expectation.theory(self.point)
        self.difference = expectation.values - self.theory
        replicates = expectation.replicates - self.theory
        self.replicates = found.moved(replicates)
        self.known = found.known
        self.error = statistics.errors(self.replicates)
        self.shaped = stabilised(self.names, self.theory, self.difference)
        self.shaped_replicates = found.moved(steadied(expectation, self.theory, replicates))
        early = np.isin(self.names, () if self.point.own_start else _AT_ZERO)[:, None]
        self.compared = np.isfinite(self.difference) & (early | (self.sample.times > 0))
        self.usable = self.compared & with_spread(self.error, expectation.values, self.theory)
        own = 0.0 if self.known is None else np.diagonal(self.known).reshape(self.error.shape)
        spread = statistics.errors(self.shaped_replicates)
        with np.errstate(divide="ignore", invalid="ignore"):
            self.sigmas = self.shaped / np.sqrt(spread**2 + own)
        self.error = np.sqrt(self.error**2 + own)
        self.effective = statistics.effective_groups(self.shaped_replicates)
        every = [(name, at) for name, one in densities.items() for at in range(one.times.size)]
        binned = (_histogram(self.sample, densities[name], name, at) for name, at in every)
        self.histograms = list(filter(None, binned))

    def flat(self, chosen: NDArray[np.int64]) -> tuple[Array, Array, Array | None]:
        """Some of the differences (p,), by their flat indices: the arguments of a chi-square."""
        replicates = self.shaped_replicates.reshape(self.sample.groups, -1)
        known = None if self.known is None else self.known[np.ix_(chosen, chosen)]
        return self.shaped.ravel()[chosen], replicates[:, chosen], known


def with_spread(error: Array, *values: Array) -> NDArray[np.bool_]:
    """Where standard errors are more than rounding."""
    with np.errstate(invalid="ignore"):
        size = np.max(np.abs(values), axis=0)
        return np.asarray((error > NO_SPREAD * size) & np.isfinite(error))


def _histogram(sample: Sample, solution: Solution, name: str, at: int) -> Histogram | None:
    """A sample's histogram against a solution's density at its time of the index `at`."""
    binned = sample.speeds if name == SPEED else sample.displacements
    if binned is None:
        return None
    time = float(solution.times[at])
    index = int(np.argmin(np.abs(sample.times - time)))
    fine, by_group = binned.edges[index], binned.by_group[:, index].astype(float)
    samples, shares = int(by_group.sum()), bin_shares(solution, name, at, fine)
    shares, behind = shares / shares.sum(), len(by_group)
    independent = sample.grouping != "medium" or sample.free
    most = _MOST_BINS if independent else min(_MOST_BINS, statistics.most_freedom(behind) + 1)
    peak = None
    if solution.scene.initial == "monoenergetic":
        peak = 1.0 if name == SPEED else time
    starts = _merged(shares * samples, samples, most, fine, peak)
    if starts.size < 2:
        return None
    theory, groups = np.add.reduceat(shares, starts), np.add.reduceat(by_group, starts, axis=1)
    counts = groups.sum(axis=0)
    share = counts / samples
    spread = groups - share * groups.sum(axis=1, keepdims=True)
    error = np.sqrt(behind / (behind - 1) * np.sum(spread**2, axis=0)) / samples
    # The spread of a bin that is emptier than expected is too small: at least binomial.
    error = np.maximum(error, np.sqrt(theory * (1 - theory) / samples))
    if independent:
        chi_square = statistics.pearson(counts, theory * samples)
    else:
        rest = counts - groups  # left out in turn: the counts of all but one group
        replicates = rest / rest.sum(axis=1, keepdims=True) - theory
        chi_square = statistics.hotelling((share - theory)[:-1], replicates[:, :-1])
    edges = np.concatenate([[0.0], fine[starts[1:] - 1], [np.inf]])
    return Histogram(name, time, edges, share, error, theory, samples, behind, chi_square)


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


def rows_of(both: Both) -> Iterator[Row]:
    """One row per observable and time, and per bin of a density; see `Comparison.rows`."""
    sample = both.sample
    for i, name in enumerate(both.names):
        looks = int(both.usable[i].sum())
        for k in np.flatnonzero(both.compared[i]).tolist():
            parts = (sample.times, both.expectation.values[i], both.error[i], both.theory[i])
            time, value, error, theory = (float(part[k]) for part in parts)
            sigmas, corrected, count = None, None, int(sample.samples[k])
            if both.usable[i, k]:
                sigmas = float(both.difference[i, k] / error)
                shaped, groups = float(both.sigmas[i, k]), float(both.effective[i, k])
                corrected = words.corrected_sigmas(shaped, groups, looks)
                verdict = words.judge_sigmas(corrected)
            elif sample.groups < 3 or ((sample.law.field or sample.law.is_driven) and time > 0):
                # One tracer is always like itself, and falls before its first collision as others.
                verdict, error = Verdict.UNDEFINED, 0.0
            else:
                # within ten times the tolerance that the solver is given
                same = abs(value - theory) <= 10 * rtol_of(sample.law) * max(
                    abs(value), abs(theory), 1e-300
                )
                verdict, error = Verdict.AGREES if same else Verdict.DIFFERS, 0.0
            yield Row(name, time, value, error, theory, sigmas, verdict, corrected, count)
    looks_in = {n: sum(h.share.size for h in both.histograms if h.name == n) for n in OBSERVABLES}
    for h in both.histograms:
        wide = np.where(np.isfinite(h.edges[1:]), np.diff(h.edges), 1.0)
        each = zip(h.share / wide, h.error / wide, h.theory / wide, (h.share - h.theory) / h.error,
                   h.edges, h.edges[1:], strict=False)  # fmt: skip
        for numbers in each:
            value, error, theory, z, low, high = map(float, numbers)
            corrected = words.corrected_sigmas(z, h.groups, looks_in[h.name])
            end = high if np.isfinite(high) else None
            verdict = words.judge_sigmas(corrected)
            yield Row(h.name, h.time, value, error, theory, z, verdict, corrected, h.samples, low,
                      end)  # fmt: skip


def tests_of(both: Both) -> Iterator[ComparisonTest]:
    """One chi-square per average, over all its times, and per density and time."""
    averages = [(name, None, _over_times(both, i)) for i, name in enumerate(both.names)]
    every = [*averages, *((h.name, h.time, h.chi_square) for h in both.histograms)]
    known = [(name, time, c) for name, time, c in every if c is not None]
    for name, time, c in known:
        sigmas = words.gaussian_sigmas(min(1.0, c.p_value * len(known)))
        verdict, within = words.judge_sigmas(sigmas), None
        if time is None:
            single, within = _of_single_times(both, both.names.index(name))
            verdict = worst_of([verdict, single])
        yield ComparisonTest(
            name, time, c.value, c.freedom, c.p_value, c.groups, sigmas, verdict, within
        )


def _over_times(both: Both, i: int) -> ChiSquare | None:
    """The chi-square of one average; neighbouring times together, where the groups are few."""
    times = np.flatnonzero(both.usable[i])
    if not times.size:
        return None
    difference, replicates, known = both.flat(times + i * both.sample.times.size)
    error = both.error[i, times]
    effective = float(statistics.effective_groups(replicates).mean())
    count = min(times.size, statistics.most_freedom(int(effective)))
    together = np.zeros((count, times.size))
    together[np.arange(times.size) * count // times.size, range(times.size)] = 1 / error
    known = None if known is None else together @ known @ together.T
    return statistics.hotelling(together @ difference, replicates @ together.T, known)


def _of_single_times(both: Both, i: int) -> tuple[Verdict, float]:
    """The verdict on the time of an average that differs most, of all times of all averages; and
    the relative difference that the data exclude at every time, at 95 %: |d| + 2 sigma.
    """
    usable, looks = both.usable[i], 2 * int(both.usable.sum())
    difference, error = both.difference[i, usable], both.error[i, usable]
    each = zip(both.sigmas[i, usable].tolist(), both.effective[i, usable].tolist(), strict=True)
    verdict = worst_of(
        words.judge_sigmas(words.corrected_sigmas(z, groups, looks)) for z, groups in each
    )
    size = np.abs(both.theory[i, usable] + (1.0 if both.names[i] == "a2" else 0.0))
    size = np.full(size.size, size.max()) if both.sample.law.field else size
    return verdict, float(np.max((np.abs(difference) + 2 * error) / size))


def worst_of(verdicts: Iterable[Verdict]) -> Verdict:
    """The worst of some verdicts; undefined without any."""
    order, found = (Verdict.DIFFERS, Verdict.UNCLEAR, Verdict.AGREES), {*verdicts}
    return next((verdict for verdict in order if verdict in found), Verdict.UNDEFINED)


def summary(
    both: Both, tests: Sequence[ComparisonTest], verdict: Verdict, best: Explanation | None,
    start: str, fitted: str, medium: str,
) -> str:  # fmt: skip
    """What was fitted, the verdict in a sentence, what was compared, the clearest difference."""
    within = [
        f"{numeral(min(t.within, 10.0), '.2g' if t.within < 0.001 else '.2%')} for "
        f"{OBSERVABLES[t.observable].short}" for t in tests if t.within is not None
    ]  # fmt: skip
    cause = f"; {best.headline} explains it" if best else ""
    answer = {
        Verdict.AGREES: f"No difference seen, better than {', '.join(within) or 'no average'}.",
        Verdict.UNCLEAR: f"A difference is possible, more samples would show it{cause}.",
        Verdict.DIFFERS: f"They differ{cause}.",
    }.get(verdict, "Nothing could be tested.")
    if best is not None and best.outcome == "found":
        answer = f"They differ. Look at the data first: {best.headline}."
    elif fitted:
        answer = f"{fitted}. {answer}"
    sample, law, point = both.sample, both.sample.law, both.point
    numbers = {"e": point.restitution, "ρ₀": law.free_path(point.path)}
    numbers |= {"e_t": law.tangential_restitution, "field": law.field}
    numbers |= {"M/m": law.mass_ratio, "w": law.bath_speed, "D_v": law.heating, "γ": law.drag}
    numbers |= {"v_c": law.capture_speed}
    plain = dict.fromkeys(numbers, 0.0) | {"e": None, "e_t": 1.0, "M/m": math.inf}
    shown = {n: v if callable(v) else numeral(v, ".6g") for n, v in numbers.items()}
    told = [f"{n} = {shown[n]}" for n, v in numbers.items() if v != plain[n]]
    first, last = (numeral(sample.times[k], ".4g") for k in (0, -1))
    answer += f" {int(sample.samples.max())} tracers at {sample.times.size} times from {first} to "
    answer += f"{last} d/U, compared with the kinetic equation with "
    answer += f"{', '.join(told)}, from {start}. {medium}"
    odd = [test for test in tests if test.verdict is not Verdict.AGREES]
    if odd:
        t = min(odd, key=lambda test: test.p_value)
        at = "" if t.time is None else f" at t = {numeral(t.time, '.4g')}"
        answer += f" Of {len(tests)} tests {len(odd)} do not agree; the clearest is {t.observable}"
        answer += f"{at}: chi-square {numeral(t.chi_square, '.4g')} with {t.dof} degrees of freedom"
        answer += f", p = {numeral(t.p_value, '.2g')}."
    return answer.replace("  ", " ")
