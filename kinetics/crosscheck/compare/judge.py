"""Data and theory side by side, in numbers: rows, histograms, and tests with their verdicts."""

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaincc

from kinetics import Solution, SolverStatus
from kinetics.crosscheck.compare.fit import ChiSquare, Fit, hotelling, most_freedom, spread_out
from kinetics.crosscheck.compare.result import ComparisonTest, Row
from kinetics.crosscheck.compare.theory import BEAM, DISPLACEMENT, SPEED
from kinetics.crosscheck.data.sample import EDGES, effective_groups
from kinetics.crosscheck.words import (
    Verdict,
    can_differ,
    corrected_sigmas,
    gaussian_sigmas,
    judge_sigmas,
    limit_factor,
)
from kinetics.numerics.gauss import panels_between

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


class Histogram(NamedTuple):
    """A density at a time: edges (n + 1,), 0 to infinity; share of samples, error, theory (n,)."""

    name: str
    time: float
    edges: Array
    share: Array
    error: Array
    theory: Array
    samples: int
    groups: int
    chi_square: ChiSquare | None


def histograms_of(found: Fit) -> Iterator[Histogram]:
    """Of the speeds, and of displacements at late times from a named start."""
    expectation, point = found.expectation, found.point
    sample = expectation.sample
    later = sample.times[sample.times > 0]
    if not sample.law.smooth_disks or point.scatterers != "dilute" or not later.size:
        return
    times = later[spread_out(later.size, 6)]  # each takes the solver some 0.1 s
    solved = [(SPEED, sample.speeds, expectation.solved(point, times, (SPEED,), 1e-6))]
    # before three l/U sharp fronts take the solver long, and few tracers have collided; from
    # hundreds of single speeds it would take long
    late = times[times > 3 * point.path][-3:]
    if late.size and isinstance(point.start, str):
        known = expectation.solved(point, late, (DISPLACEMENT,), 1e-4)
        if known.status is SolverStatus.CONVERGED:  # or it would be judged wrongly
            solved.append((DISPLACEMENT, sample.displacements, known))
    every = ((*one, at) for one in solved if one[1] for at in range(one[2].times.size))
    for name, counted, solution, at in every:
        made = _histogram(found, name, counted, solution, at)
        if made is not None:
            yield made


def _histogram(
    found: Fit, name: str, counted: Any, solution: Solution, at: int, most_bins: int = 40
) -> Histogram | None:
    """The sample's histogram against a solution's density at its time of the index `at`."""
    sample, time = found.expectation.sample, float(solution.times[at])
    index = int(np.argmin(np.abs(sample.times - time)))
    fine, by_group = counted[0][index] * EDGES, counted[1][:, index].astype(float)
    samples, shares = int(by_group.sum()), bin_shares(solution, name, at, fine)
    shares, behind = shares / shares.sum(), len(by_group)
    independent = sample.grouping != "medium" or sample.free
    most = most_bins if independent else min(most_bins, most_freedom(behind) + 1)
    peak = None
    if found.point.start in ("monoenergetic", BEAM):
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
        expected, freedom = theory * samples, counts.size - 1
        value = float(np.sum((counts - expected) ** 2 / expected))  # Pearson's
        p_value = float(gammaincc(freedom / 2, value / 2))
        chi_square: ChiSquare | None = ChiSquare(value, freedom, p_value, None, value)
    else:
        rest = counts - groups  # left out in turn: the counts of all but one group
        replicates = rest / rest.sum(axis=1, keepdims=True) - theory
        chi_square = hotelling((share - theory)[:-1], replicates[:, :-1])
    edges = np.concatenate([[0.0], fine[starts[1:] - 1], [np.inf]])
    return Histogram(name, time, edges, share, error, theory, samples, behind, chi_square)


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


def _merged(
    expected: Array, samples: int, most: int, edges: Array, peak: float | None, least: float = 50.0
) -> Indices:
    """The first fine bin of each bin, which is expected to hold `least`, to be nearly Gaussian."""
    widest = max(samples / 12, samples / most * 2, least)  # no bin is made wider
    starts, held, before = [0], 0.0, 0.0
    for k, count in enumerate(expected[:-1].tolist()):
        held += count
        target = min(max(min(before, (samples - before) / 2), least), widest)
        on_peak = peak is not None and abs(edges[min(k, edges.size - 1)] - peak) < 1e-6 * peak
        if held >= target and samples - before - held >= least and not on_peak:
            starts.append(k + 1)
            before += held
            held = 0.0
    while len(starts) > most:  # where the tails alone are too many, every second edge goes
        starts = starts[::2]
    return np.array(starts)


def rows_of(found: Fit, histograms: Sequence[Histogram]) -> Iterator[Row]:
    """One row per observable and time, and per bin of a density; see `Comparison.rows`."""
    measured, sample = found.expectation, found.expectation.sample
    exact = measured.exact(found.point)
    for i, name in enumerate(measured.names):
        looks = int(found.usable[i].sum())
        sizes = _sizes(found, i)
        for k in np.flatnonzero(found.compared[i]).tolist():
            parts = (sample.times, measured.values[i], found.bars[i], found.theory[i])
            time, value, error, theory = (float(part[k]) for part in parts)
            sigmas, corrected, count = None, None, int(sample.samples[k])
            if found.usable[i, k]:
                sigmas = float(found.difference[i, k] / error)
                shaped, groups = float(found.sigmas[i, k]), float(found.effective[i, k])
                corrected = corrected_sigmas(shaped, groups, looks)
                verdict = judge_sigmas(corrected)
                relative = error / float(sizes[k])
                if verdict is Verdict.AGREES and not can_differ(relative, groups):
                    verdict = Verdict.NOT_TESTED
            else:
                error = 0.0
                verdict = _without_scatter(found, value, theory, float(sizes[k]), exact[i, k], k)
            yield Row(name, time, value, error, theory, sigmas, verdict, corrected, count)
    for h in histograms:
        looks = sum(other.share.size for other in histograms if other.name == h.name)
        wide = np.where(np.isfinite(h.edges[1:]), np.diff(h.edges), 1.0)
        sigma, testable = (h.share - h.theory) / h.error, _has_testable_bin(h)
        columns = h.share / wide, h.error / wide, h.theory / wide, sigma, h.edges[:-1], h.edges[1:]
        for value, error, theory, z, low, high in np.transpose(columns).tolist():
            corrected = corrected_sigmas(z, h.groups, looks)
            end, verdict = high if np.isfinite(high) else None, judge_sigmas(corrected)
            if verdict is Verdict.AGREES and not testable:
                verdict = Verdict.NOT_TESTED
            yield Row(h.name, h.time, value, error, theory, z, verdict, corrected, h.samples, low,
                      end)  # fmt: skip


def _sizes(found: Fit, i: int) -> Array:
    """What differences of an average are relative to, (n_times,): |theory|, and 1 + a2 for a2."""
    name = found.expectation.names[i]
    size = np.abs(found.theory[i] + (name == "a2"))
    if "drift" in found.expectation.names:  # signed, or from rest
        usable = found.usable[i]
        size = np.full_like(size, size[usable].max() if np.any(usable) else size.max())
    return np.asarray(np.where(size > 0, size, np.inf))


def _without_scatter(
    found: Fit, value: float, theory: float, size: float, exact: bool, k: int
) -> Verdict:
    """Verdict on an average that is the same in every group, at the time of the index ``k``.

    The solver is given a tolerance, and data are rounded: ten of these are no difference. What is
    exact in theory must be as near. Else the theory has some tracers that have collided where the
    data have none: a share p of N tracers is missed with the probability exp(-N p), and one
    collision changes an average at most to its double.
    """
    sample = found.expectation.sample
    if math.isclose(value, theory, rel_tol=10 * sample.law.rtol, abs_tol=1e-15):
        verdict = Verdict.AGREES
    elif exact or sample.times[k] == 0:
        return Verdict.DIFFERS
    else:
        missed_share = abs(value - theory) / size / 2
        verdict = judge_sigmas(gaussian_sigmas(math.exp(-sample.samples[k] * missed_share)))
    if exact:
        return verdict
    if sample.groups < 3:  # one tracer is always like itself
        return Verdict.NOT_TESTED
    if (sample.law.field or sample.law.is_driven) and sample.times[k] > 0:
        return Verdict.UNDEFINED  # a tracer falls before its first collision as others do
    return verdict


def _has_testable_bin(h: Histogram) -> bool:
    """Whether in some bin a density that is wrong by its own value would be seen."""
    errors = h.error / np.maximum(h.theory, 1e-300)
    return can_differ(float(errors.min()), h.groups)


def _has_testable_time(found: Fit, i: int) -> bool:
    """Whether at some time an average that is wrong by its own value would be seen."""
    at = found.usable[i]
    relative = (found.error[i] / _sizes(found, i))[at].tolist()
    pairs = zip(relative, found.effective[i, at].tolist(), strict=True)
    return any(can_differ(error, groups) for error, groups in pairs)


def tests_of(found: Fit, histograms: Sequence[Histogram]) -> Iterator[ComparisonTest]:
    """One chi-square per average, over all its times, and per density and time."""
    names = found.expectation.names
    averages = [(name, None, _over_times(found, i)) for i, name in enumerate(names)]
    every = [*averages, *((h.name, h.time, h.chi_square) for h in histograms)]
    known = [(name, time, c) for name, time, c in every if c is not None]
    for name, time, c in known:
        sigmas, within = gaussian_sigmas(min(1.0, c.p_value * len(known))), None
        verdicts = [judge_sigmas(sigmas)]
        if time is None:  # the time that differs most, of all times of all averages, counts too
            i, looks = names.index(name), 2 * int(found.usable.sum())
            at = found.usable[i]
            each = zip(found.sigmas[i, at].tolist(), found.effective[i, at].tolist(), strict=True)
            verdicts += [judge_sigmas(corrected_sigmas(z, groups, looks)) for z, groups in each]
            # what the data exclude at every time, at 95 %
            factors = np.array([limit_factor(groups) for groups in found.effective[i, at]])
            seen = np.abs(found.difference[i, at]) + factors * found.error[i, at]
            within = float(np.max(seen / _sizes(found, i)[at]))
            testable = _has_testable_time(found, i)
        else:
            density = next(h for h in histograms if (h.name, h.time) == (name, time))
            testable = c.groups is None or _has_testable_bin(density)
        verdict = worst_of(verdicts)
        if verdict is Verdict.AGREES and not testable:
            verdict = Verdict.NOT_TESTED
        yield ComparisonTest(
            name, time, c.value, c.freedom, c.p_value, c.groups, sigmas, verdict, within
        )


def _over_times(found: Fit, i: int) -> ChiSquare | None:
    """The chi-square of one average; neighbouring times together, where the groups are few."""
    times = np.flatnonzero(found.usable[i])
    if not times.size:
        return None
    difference, replicates, known = found.flat(times + i * found.usable.shape[1])
    effective = float(effective_groups(replicates).mean())
    count = min(times.size, most_freedom(int(effective)))
    together = np.zeros((count, times.size))
    at = np.arange(times.size)
    together[at * count // times.size, at] = 1 / found.error[i, times]
    known = None if known is None else together @ known @ together.T
    return hotelling(together @ difference, replicates @ together.T, known)


def worst_of(verdicts: Iterable[Verdict]) -> Verdict:
    """The worst of some verdicts; not tested only where nothing was, undefined without any."""
    order = (Verdict.DIFFERS, Verdict.UNCLEAR, Verdict.AGREES, Verdict.NOT_TESTED)
    found = {*verdicts}
    return next((verdict for verdict in order if verdict in found), Verdict.UNDEFINED)
