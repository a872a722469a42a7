"""Data and theory side by side, in numbers: rows, histograms, and tests with their verdicts."""

import math
from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinetics import Solution, SolverStatus
from kinetics.crosscheck.compare import statistics
from kinetics.crosscheck.compare.fit import Fit
from kinetics.crosscheck.compare.result import ComparisonTest, Row
from kinetics.crosscheck.compare.statistics import ChiSquare
from kinetics.crosscheck.compare.theory import DISPLACEMENT, OBSERVABLES, SPEED, Expectation
from kinetics.crosscheck.data.sample import EDGES
from kinetics.crosscheck.words import Verdict, corrected_sigmas, gaussian_sigmas, judge_sigmas
from kinetics.numerics.gauss import panels_between

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

NO_SPREAD = 1e-9  # error over value below which data have no spread: a start with one speed
LEAST_EXPECTED = 50  # samples that a bin must be expected to hold, to be nearly Gaussian
MOST_IN_A_BIN = 1 / 12  # of the samples: from there on a bin is not made wider
_MOST_BINS = 40
_AT_ZERO = ("drift", "thermal_speed", "a2")  # the averages that say something at time 0


class Histogram(NamedTuple):
    """One density at one time: edges (n + 1,) from 0 to infinity; shares of the samples, errors and
    theory (n,).
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

    theory, difference, error (with the theory's own), sigmas (of the difference as `stabilised`),
    effective groups; compared: where there is something to compare; usable: and where it has
    spread, (n_names, n_times) each; histograms.
    """

    def __init__(self, expectation: Expectation, found: Fit) -> None:
        self.expectation, self.found, self.point = expectation, found, found.point
        self.sample, self.names, self.theory = expectation.sample, expectation.names, found.theory
        self.difference = expectation.values - self.theory
        error = statistics.errors(found.moved(expectation.replicates - self.theory))
        early = np.isin(self.names, () if self.point.own_start else _AT_ZERO)[:, None]
        self.compared = np.isfinite(self.difference) & (early | (self.sample.times > 0))
        self.usable = self.compared & with_spread(error, expectation.values, self.theory)
        own = 0.0 if found.known is None else np.diagonal(found.known).reshape(error.shape)
        spread = statistics.errors(found.replicates)
        with np.errstate(divide="ignore", invalid="ignore"):
            self.sigmas = found.shaped / np.sqrt(spread**2 + own)
        self.error = np.sqrt(error**2 + own)
        self.effective = statistics.effective_groups(found.replicates)
        self.histograms = [*self._histograms()]

    def flat(self, chosen: Indices) -> tuple[Array, Array, Array | None]:
        """Some of the differences (p,), by their flat indices: the arguments of a chi-square."""
        found = self.found
        known = None if found.known is None else found.known[np.ix_(chosen, chosen)]
        replicates = found.replicates.reshape(self.sample.groups, -1)[:, chosen]
        return found.shaped.ravel()[chosen], replicates, known

    def _histograms(self) -> Iterator[Histogram]:
        """Of the speeds, and of displacements at late times from a named start."""
        sample, point = self.sample, self.point
        later = sample.times[sample.times > 0]
        if not sample.law.smooth_disks or point.scatterers != "dilute" or not later.size:
            return
        times = later[statistics.spread_out(later.size, 6)]  # each takes the solver some 0.1 s
        found = {SPEED: self.expectation.solved(point, times, (SPEED,), 1e-6)}
        # before three l/U sharp fronts take the solver long, and few tracers have collided; from
        # hundreds of single speeds it would take long
        late = times[times > 3 * point.path][-3:]
        if late.size and not point.own_start:
            known = self.expectation.solved(point, late, (DISPLACEMENT,), 1e-4)
            if known.status is SolverStatus.CONVERGED:  # or it would be judged wrongly
                found[DISPLACEMENT] = known
        for name, solution in found.items():
            for at in range(solution.times.size):
                if (made := self._histogram(solution, name, at)) is not None:
                    yield made

    def _histogram(self, solution: Solution, name: str, at: int) -> Histogram | None:
        """The sample's histogram against a solution's density at its time of the index `at`."""
        sample, speed = self.sample, name == SPEED
        counted = sample.speeds if speed else sample.displacements
        if counted is None:
            return None
        time = float(solution.times[at])
        index = int(np.argmin(np.abs(sample.times - time)))
        fine, by_group = counted[0][index] * EDGES, counted[1][:, index].astype(float)
        samples, shares = int(by_group.sum()), bin_shares(solution, name, at, fine)
        shares, behind = shares / shares.sum(), len(by_group)
        independent = sample.grouping != "medium" or sample.free
        most = _MOST_BINS if independent else min(_MOST_BINS, statistics.most_freedom(behind) + 1)
        peak = None
        if self.point.start == "monoenergetic":
            peak = 1.0 if speed else time
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
            chi_square: ChiSquare | None = statistics.pearson(counts, theory * samples)
        else:
            rest = counts - groups  # left out in turn: the counts of all but one group
            replicates = rest / rest.sum(axis=1, keepdims=True) - theory
            chi_square = statistics.hotelling((share - theory)[:-1], replicates[:, :-1])
        edges = np.concatenate([[0.0], fine[starts[1:] - 1], [np.inf]])
        return Histogram(name, time, edges, share, error, theory, samples, behind, chi_square)


def with_spread(error: Array, *values: Array) -> NDArray[np.bool_]:
    """Where standard errors are more than rounding."""
    with np.errstate(invalid="ignore"):
        size = np.max(np.abs(values), axis=0)
        return np.asarray((error > NO_SPREAD * size) & np.isfinite(error))


def bin_shares(solution: Solution, name: str, index: int, edges: Array) -> Array:
    """Share of the tracers below the first edge, in each bin, and above: (n_edges + 1,)."""
    every = np.concatenate([[0.0], edges])
    if name == DISPLACEMENT:
        shares = solution.position_fraction(every)[index]
        return np.append(shares, max(1 - shares.sum(), 0.0))
    pieces = 1 if solution.scene.state.smooth else 120  # of the finest nodes in ln v
    fine = np.interp(np.arange(pieces * (every.size - 1) + 1) / pieces, range(every.size), every)
    x, weight = panels_between(fine, 3)
    each = (solution.speed_density(x)[index] * weight).reshape(-1, 3).sum(axis=1)
    shares = np.maximum(each, 0.0).reshape(-1, pieces).sum(axis=1)
    peak = float(solution.uncollided[index])
    if peak > 0:  # tracers of a start with one speed that have not collided
        speed = float(getattr(solution.scene.state, "speed", 1.0))
        shares[min(np.searchsorted(every, speed, side="right"), shares.size) - 1] += peak
    return np.append(shares, max(1 - shares.sum(), 0.0))


def _merged(expected: Array, samples: int, most: int, edges: Array, peak: float | None) -> Indices:
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
    sample, law = both.sample, both.sample.law
    for i, name in enumerate(both.names):
        looks = int(both.usable[i].sum())
        for k in np.flatnonzero(both.compared[i]).tolist():
            parts = (sample.times, both.expectation.values[i], both.error[i], both.theory[i])
            time, value, error, theory = (float(part[k]) for part in parts)
            sigmas, corrected, count = None, None, int(sample.samples[k])
            if both.usable[i, k]:
                sigmas = float(both.difference[i, k] / error)
                shaped, groups = float(both.sigmas[i, k]), float(both.effective[i, k])
                corrected = corrected_sigmas(shaped, groups, looks)
                verdict = judge_sigmas(corrected)
            elif sample.groups < 3 or ((law.field or law.is_driven) and time > 0):
                # One tracer is always like itself, and falls before its first collision as others.
                verdict, error = Verdict.UNDEFINED, 0.0
            else:  # within ten times the tolerance that the solver is given
                same = math.isclose(value, theory, rel_tol=10 * law.rtol)
                verdict, error = Verdict.AGREES if same else Verdict.DIFFERS, 0.0
            yield Row(name, time, value, error, theory, sigmas, verdict, corrected, count)
    looks_in = {n: sum(h.share.size for h in both.histograms if h.name == n) for n in OBSERVABLES}
    for h in both.histograms:
        wide = np.where(np.isfinite(h.edges[1:]), np.diff(h.edges), 1.0)
        sigma = (h.share - h.theory) / h.error
        columns = h.share / wide, h.error / wide, h.theory / wide, sigma, h.edges[:-1], h.edges[1:]
        for value, error, theory, z, low, high in np.transpose(columns).tolist():
            corrected = corrected_sigmas(z, h.groups, looks_in[h.name])
            end, verdict = high if np.isfinite(high) else None, judge_sigmas(corrected)
            yield Row(h.name, h.time, value, error, theory, z, verdict, corrected, h.samples, low,
                      end)  # fmt: skip


def tests_of(both: Both) -> Iterator[ComparisonTest]:
    """One chi-square per average, over all its times, and per density and time."""
    averages = [(name, None, _over_times(both, i)) for i, name in enumerate(both.names)]
    every = [*averages, *((h.name, h.time, h.chi_square) for h in both.histograms)]
    known = [(name, time, c) for name, time, c in every if c is not None]
    for name, time, c in known:
        sigmas = gaussian_sigmas(min(1.0, c.p_value * len(known)))
        verdict, within = judge_sigmas(sigmas), None
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
    effective = float(statistics.effective_groups(replicates).mean())
    count = min(times.size, statistics.most_freedom(int(effective)))
    together = np.zeros((count, times.size))
    at = np.arange(times.size)
    together[at * count // times.size, at] = 1 / both.error[i, times]
    known = None if known is None else together @ known @ together.T
    return statistics.hotelling(together @ difference, replicates @ together.T, known)


def _of_single_times(both: Both, i: int) -> tuple[Verdict, float]:
    """The verdict on the time of an average that differs most, of all times of all averages; and
    the relative difference that the data exclude at every time, at 95 %: |d| + 2 sigma.
    """
    usable, looks = both.usable[i], 2 * int(both.usable.sum())
    each = zip(both.sigmas[i, usable].tolist(), both.effective[i, usable].tolist(), strict=True)
    verdict = worst_of(judge_sigmas(corrected_sigmas(z, groups, looks)) for z, groups in each)
    size = np.abs(both.theory[i, usable] + (1.0 if both.names[i] == "a2" else 0.0))
    size = np.full(size.size, size.max()) if both.sample.law.field else size
    seen = np.abs(both.difference[i, usable]) + 2 * both.error[i, usable]
    return verdict, float(np.max(seen / size))


def worst_of(verdicts: Iterable[Verdict]) -> Verdict:
    """The worst of some verdicts; undefined without any."""
    order, found = (Verdict.DIFFERS, Verdict.UNCLEAR, Verdict.AGREES), {*verdicts}
    return next((verdict for verdict in order if verdict in found), Verdict.UNDEFINED)
