"""Histograms of speeds and displacements beside the densities of the theory."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaincc

from kinetics.crosscheck.compare.observables import DISPLACEMENT_DENSITY, SPEED_DENSITY, Array
from kinetics.crosscheck.compare.point import Point
from kinetics.crosscheck.compare.statistics import (
    ChiSquare,
    jackknife_covariance,
    test_by_groups,
    whitening,
)
from kinetics.crosscheck.compare.theory import solve_at
from kinetics.crosscheck.data.sample import EDGES, Binned, Sample
from kinetics.errors import InputError, SolverStatus
from kinetics.numerics.gauss import panels_between
from kinetics.solution import Solution

Indices = NDArray[np.int64]

#: Times at which densities are compared at most: the solver takes some 0.1 s for each.
MAX_TIMES = 6
#: Late times at which the density of the displacement is compared at most.
MAX_LATE_TIMES = 3
#: Mean free paths after which it is: before, sharp fronts take the solver long, and few tracers
#: have collided.
LATE_AFTER_PATHS = 3.0
#: Relative accuracy of the density of the speed: below any error of counts.
SPEED_RTOL = 1e-6
#: The same of the displacement, which takes the solver longer.
DISPLACEMENT_RTOL = 1e-4
#: Bins at most.
MAX_BINS = 40
#: Tracers that a bin is expected to hold at least, so that its count is nearly Gaussian.
MIN_EXPECTED = 50.0
#: A bin is made wide enough for MIN_EXPECTED, but never wider than this share of the tracers.
WIDEST_SHARE = 1.0 / 12.0
#: Pieces of a bin for the quadrature of a density that is not smooth: finer than the finest nodes.
PIECES_OF_ROUGH = 120
#: Points of the Gauss rule of a piece.
POINTS_PER_PIECE = 3
#: An edge this close to a sharp peak, relative to it, would share it between two bins.
ON_PEAK = 1e-6
#: Groups for each bin of a covariance that is estimated from them.
GROUPS_PER_BIN = 4


@dataclass(frozen=True, eq=False)
class Histogram:
    """A density at a time, in bins.

    Parameters
    ----------
    name : `observables.SPEED_DENSITY` or `observables.DISPLACEMENT_DENSITY`
    time : in d/U
    edges : from 0 to infinity, shape (n_bins + 1,)
    share : of the tracers in each bin, shape (n_bins,)
    error : standard error of the share
    theory : the expected share
    samples, groups : tracers, and groups that the errors are from
    chi_square : of all bins together
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


@dataclass(frozen=True, eq=False)
class Densities:
    """The densities that are compared.

    Parameters
    ----------
    histograms : of speeds and displacements, at some times each
    remarks : which density is not compared although the data have it, and why
    """

    histograms: tuple[Histogram, ...] = ()
    remarks: tuple[str, ...] = ()


def densities_of(sample: Sample, point: Point) -> Densities:
    """Return those of the speeds, and of displacements at late times from a named start."""
    later = sample.times[sample.times > 0.0]
    if not sample.law.smooth_disks or point.scatterers != "dilute" or not later.size:
        return Densities()
    if point.position_noise or point.velocity_noise:
        return Densities()
    times = later[evenly_spread(later.size, MAX_TIMES)]
    histograms: list[Histogram] = []
    remarks = []
    if sample.speeds is not None:
        try:
            histograms += _solved(sample, point, SPEED_DENSITY, sample.speeds, times, SPEED_RTOL)
        except InputError as error:
            remarks.append(f"The speed density is not compared: {error}")
    late = times[times > LATE_AFTER_PATHS * point.path / point.clock][-MAX_LATE_TIMES:]
    # from hundreds of single speeds it would take the solver long
    if sample.displacements is not None and late.size and isinstance(point.start, str):
        counted = sample.displacements
        try:
            histograms += _solved(
                sample, point, DISPLACEMENT_DENSITY, counted, late, DISPLACEMENT_RTOL
            )
        except InputError as error:
            remarks.append(f"The displacement density is not compared: {error}")
    return Densities(tuple(histograms), tuple(remarks))


def _solved(
    sample: Sample,
    point: Point,
    name: str,
    counted: Binned,
    times: Array,
    rtol: float,
) -> list[Histogram]:
    """Return the histograms of one density at times of the data.

    InputError where the solver has no such density, or it has not converged, so that it would be
    judged wrongly. Elastic tracers that start with the data's own speeds keep these, and near e = 1
    late densities would take the solver too long: averages are compared then.
    """
    solution = solve_at(point, sample.law, point.true_times(times), (name,), rtol)
    if name == DISPLACEMENT_DENSITY and solution.status is not SolverStatus.CONVERGED:
        raise InputError("the solver does not reach its tolerance")
    histograms = []
    for index, time in enumerate(times.tolist()):
        histogram = _histogram(sample, point, name, counted, solution, index, time)
        if histogram is not None:
            histograms.append(histogram)
    return histograms


def _histogram(
    sample: Sample,
    point: Point,
    name: str,
    counted: Binned,
    solution: Solution,
    index: int,
    time: float,
) -> Histogram | None:
    """Return the histogram at one time of a solution; None with fewer than two bins.

    time : that of the data, the true one is `solution.times[index]`
    """
    scales, counts = counted
    at_time = int(np.argmin(np.abs(sample.times - time)))
    fine_edges = scales[at_time] * EDGES
    by_group = counts[:, at_time].astype(float)
    n_samples = int(by_group.sum())
    n_groups = len(by_group)
    expected = bin_shares(solution, name, index, fine_edges)
    expected = expected / expected.sum()
    max_bins = MAX_BINS
    if not sample.is_independent:
        max_bins = min(MAX_BINS, 1 + max(1, (n_groups - 1) // GROUPS_PER_BIN))
    peak = None
    if point.has_one_speed:
        peak = 1.0 if name == SPEED_DENSITY else float(solution.times[index])
    first_bins = _merged_bins(expected * n_samples, n_samples, max_bins, fine_edges, peak)
    if first_bins.size < 2:
        return None
    theory = np.add.reduceat(expected, first_bins)
    merged = np.add.reduceat(by_group, first_bins, axis=1)
    share = merged.sum(axis=0) / n_samples
    return Histogram(
        name=name,
        time=time,
        edges=np.concatenate([[0.0], fine_edges[first_bins[1:] - 1], [np.inf]]),
        share=share,
        error=_errors_of_shares(merged, share, theory, n_samples),
        theory=theory,
        samples=n_samples,
        groups=n_groups,
        chi_square=_test_of_bins(merged, share, theory, n_samples, sample.is_independent),
    )


def _errors_of_shares(by_group: Array, share: Array, theory: Array, n_samples: int) -> Array:
    """Return the standard errors of shares, from the spread of groups, at least binomial.

    The spread of a bin that is emptier than expected is too small.
    """
    n_groups = len(by_group)
    deviation = by_group - share * by_group.sum(axis=1, keepdims=True)
    of_groups = np.sqrt(n_groups / (n_groups - 1) * np.sum(deviation**2, axis=0)) / n_samples
    binomial = np.sqrt(theory * (1.0 - theory) / n_samples)
    return np.asarray(np.maximum(of_groups, binomial))


def _test_of_bins(
    by_group: Array, share: Array, theory: Array, n_samples: int, is_independent: bool
) -> ChiSquare | None:
    """Return Pearson's chi-square of independent tracers, or a test by the groups of others."""
    if is_independent:
        freedom = share.size - 1
        statistic = float(n_samples * np.sum((share - theory) ** 2 / theory))
        p_value = float(gammaincc(freedom / 2, statistic / 2))
        return ChiSquare(statistic, freedom, p_value, None, statistic)
    without_each = share * n_samples - by_group
    replicates = without_each / without_each.sum(axis=1, keepdims=True) - theory
    difference = (share - theory)[:-1]
    multinomial = (np.diag(theory) - np.outer(theory, theory))[:-1, :-1] / n_samples
    axes = whitening(multinomial)
    no_error = np.zeros((len(axes), len(axes)))
    if not np.any(jackknife_covariance(replicates)):
        return None
    return test_by_groups(axes @ difference, replicates[:, :-1] @ axes.T, no_error)


def bin_shares(solution: Solution, name: str, index: int, edges: Array) -> Array:
    """Return the share of the tracers below the first edge, in each bin, and above.

    Parameters
    ----------
    solution : has the density `name`
    index : of the time of the solution
    edges : rising, shape (n_edges,)

    Returns
    -------
    array of shape (n_edges + 1,)
    """
    edges = np.concatenate([[0.0], edges])
    if name == DISPLACEMENT_DENSITY:
        shares = solution.position_fraction(edges)[index]
        return np.append(shares, max(1.0 - shares.sum(), 0.0))
    n_pieces = 1 if solution.scene.state.smooth else PIECES_OF_ROUGH
    place = np.arange(n_pieces * (edges.size - 1) + 1) / n_pieces
    pieces = np.interp(place, np.arange(edges.size), edges)
    speeds, weights = panels_between(pieces, POINTS_PER_PIECE)
    density = solution.speed_density(speeds)[index]
    of_pieces = (density * weights).reshape(-1, POINTS_PER_PIECE).sum(axis=1)
    shares = np.maximum(of_pieces, 0.0).reshape(-1, n_pieces).sum(axis=1)
    uncollided = float(solution.uncollided[index])
    if uncollided > 0.0:  # a peak of tracers of a start with one speed
        speed = float(getattr(solution.scene.state, "speed", 1.0))
        bin_of_peak = int(np.searchsorted(edges, speed, side="right")) - 1
        shares[min(bin_of_peak, shares.size - 1)] += uncollided
    return np.append(shares, max(1.0 - shares.sum(), 0.0))


def _merged_bins(
    expected: Array, n_samples: int, max_bins: int, edges: Array, peak: float | None
) -> Indices:
    """Return the index of the first fine bin of each bin.

    Parameters
    ----------
    expected : tracers that are expected in each fine bin
    peak : where the density has a sharp peak, which no edge may share; None if it has none
    """
    widest = max(n_samples * WIDEST_SHARE, 2.0 * n_samples / max_bins, MIN_EXPECTED)
    first_bins = [0]
    n_before = 0.0
    n_held = 0.0
    for fine_bin, count in enumerate(expected[:-1].tolist()):
        n_held += count
        from_either_end = min(n_before, (n_samples - n_before) / 2.0)
        wanted = min(max(from_either_end, MIN_EXPECTED), widest)
        n_left = n_samples - n_before - n_held
        edge = edges[min(fine_bin, edges.size - 1)]
        is_on_peak = peak is not None and abs(edge - peak) < ON_PEAK * peak
        if n_held >= wanted and n_left >= MIN_EXPECTED and not is_on_peak:
            first_bins.append(fine_bin + 1)
            n_before += n_held
            n_held = 0.0
    while len(first_bins) > max_bins:  # where the tails alone are too many, every second edge goes
        first_bins = first_bins[::2]
    return np.array(first_bins)


def evenly_spread(count: int, most: int) -> Indices:
    """Return at most so many of the indices 0 .. count - 1, evenly, with the last."""
    if count <= most:
        return np.arange(count)
    return np.unique(np.round(np.linspace(0, count - 1, most)).astype(np.int64))
