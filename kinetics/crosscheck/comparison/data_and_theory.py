"""Data and theory side by side: averages with the replicates from which every error follows, and
histograms in bins wide enough to be judged.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.comparison.fit import Fit
from kinetics.crosscheck.comparison.reduction import SAME_TIME
from kinetics.crosscheck.comparison.sample import Binned, Sample
from kinetics.crosscheck.comparison.statistics import (
    ChiSquare,
    errors,
    hotelling,
    most_freedom,
    pearson,
    spread_out,
)
from kinetics.crosscheck.comparison.theory import (
    AVERAGES,
    DISPLACEMENT,
    IN_FIELD,
    SPEED,
    Expectation,
    SampledStart,
    average_of,
    bin_shares,
)
from kinetics.errors import InputError, short
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
KNOWN_AT_ZERO = (
    "msd", "kurtosis", "mean_displacement", "dispersion_parallel", "dispersion_perpendicular",
)  # fmt: skip
"""Averages of the displacement, which say nothing at time 0."""


@dataclass(frozen=True)
class Histogram:
    """One histogram at one time against the theory, in bins of LEAST_EXPECTED samples or more.

    name : "speed_density" or "position_density"; time in d/U, and its index in the sample
    edges (n + 1,), in U or d: the first is 0, the last infinite; share of the samples, its standard
    error (from `groups` groups) and the theory, (n,) each.
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
class DataAndTheory:
    """The numbers behind a comparison: rows and tests, what figures draw, what is fitted again.

    theory, difference, error (n_names, n_times); replicates (G, n_names, n_times) of the
    difference; compared: where there is something to compare; usable: and where it has spread.
    densities: the solution of each density. histograms: one for each density and time.
    density_told: the number density of the scatterers is given, not fitted to these averages.
    """

    sample: Sample
    solution: "Solution"
    expectation: Expectation
    theory: Array
    difference: Array
    replicates: Array
    error: Array
    compared: NDArray[np.bool_]
    usable: NDArray[np.bool_]
    densities: "Mapping[str, Solution]"
    histograms: list[Histogram]
    density_told: bool

    @property
    def names(self) -> tuple[str, ...]:
        """The averages, in the order of the first axis of the arrays."""
        return self.expectation.names

    @property
    def flat_replicates(self) -> Array:
        """The replicates of the difference as (G, n_names * n_times)."""
        return self.replicates.reshape(self.sample.groups, -1)

    @property
    def own_start(self) -> bool:
        """Whether the theory starts from the speeds of the sample at time 0."""
        return isinstance(self.solution.scene.state, SampledStart)


def side_by_side(
    solution: "Solution",
    sample: Sample,
    found: Fit | None = None,
    densities: "Mapping[str, Solution] | None" = None,
) -> DataAndTheory:
    """A sample and a solution at the times and in the observables that both have.

    found: the fit to the same averages that the solution's numbers come from. InputError if they
    have nothing in common, or the sample fewer than two groups.
    """
    if sample.groups < 2:
        raise InputError("ensemble: has fewer than two groups; there are no standard errors")
    matches = [_match(t, np.asarray(solution.times)) for t in sample.times]
    keep = np.array([k for k, m in enumerate(matches) if m is not None], np.int64)
    if keep.size == 0:
        raise InputError(
            f"solution: its times {short(solution.times.tolist())} have none in common with the "
            f"data's {short(sample.times.tolist())}"
        )
    sample = sample.at(keep)
    names, owners = _in_common(solution, sample, densities or {})
    expectation = Expectation(sample, names)
    theory, moved = _theory(solution, expectation, [m for m in matches if m is not None])
    difference = expectation.values - theory
    replicates = expectation.replicates - moved
    if found is not None:
        # Data that were fitted move the theory with them.
        shift = found.moved(replicates) @ found.slope.T
        replicates = replicates - shift.reshape(replicates.shape)
    error = errors(replicates)
    compared = np.isfinite(difference)
    own_start = isinstance(solution.scene.state, SampledStart)
    for k, name in enumerate(names):
        if own_start or name in KNOWN_AT_ZERO:
            compared[k] &= sample.times > 0
    with np.errstate(invalid="ignore"):
        size = np.maximum(np.abs(expectation.values), np.abs(theory))
        usable = compared & (error > NO_SPREAD * size) & np.isfinite(error)
    histograms = [
        result
        for name, density in owners.items()
        for k in histogram_times(sample)
        if (at := _match(sample.times[k], density.times)) is not None
        and (result := compare_histogram(sample, density, name, k, at)) is not None
    ]
    return DataAndTheory(
        sample, solution, expectation, theory, difference, replicates, error, compared, usable,
        owners, histograms, found is None or "log_path" not in found.names,
    )  # fmt: skip


def histogram_times(sample: Sample) -> list[int]:
    """The indices of the times at which densities are compared."""
    later = np.flatnonzero(sample.times > 0)
    return [int(later[k]) for k in spread_out(later.size, HISTOGRAM_TIMES)]


def _match(time: float, times: Array) -> int | None:
    k = int(np.argmin(np.abs(times - time)))
    return k if abs(times[k] - time) <= SAME_TIME * max(time, 1e-300) else None


def _in_common(
    solution: "Solution", sample: Sample, densities: "Mapping[str, Solution]"
) -> tuple[list[str], dict[str, "Solution"]]:
    """Averages, and densities with their solution, that were asked for and the sample has."""
    outputs = solution.scene.outputs
    names = [name for name in AVERAGES if name in outputs]
    if solution.scene.field:
        names = [name for name, (output, _) in IN_FIELD.items() if output in outputs]
    owners = {}
    for name, counts in ((SPEED, sample.speeds), (DISPLACEMENT, sample.displacements)):
        owner = densities.get(name, solution)
        if name in owner.scene.outputs and counts is not None:
            owners[name] = owner
    if not names and not owners:
        raise InputError(
            f"solution: was asked for {', '.join(outputs)}; needed is at least one of "
            f"{', '.join((*AVERAGES, SPEED))}"
        )
    return names, owners


def _theory(
    solution: "Solution", expectation: Expectation, index: list[int]
) -> tuple[Array, Array]:
    scene, names = solution.scene, expectation.names
    if names and isinstance(scene.state, SampledStart) and expectation.sample.start is not None:
        return expectation.theory(scene.restitution, scene.mean_free_path, scene.state)
    values = [average_of(solution, name)[index] for name in names]
    found = np.array(values).reshape(len(names), len(index))
    return found, found


def compare_histogram(
    sample: Sample, solution: "Solution", name: str, index: int, at: int
) -> Histogram | None:
    """A sample's histogram at its time `index` against a solution's density at its time `at`.

    None where too few samples are expected for two bins.
    """
    binned = sample.speeds if name == SPEED else sample.displacements
    assert binned is not None
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
    else:
        # Left out in turn: the shares of all but one group.
        rest = counts - groups
        replicates = rest / rest.sum(axis=1, keepdims=True) - theory
        chi_square = hotelling((share - theory)[:-1], replicates[:, :-1])
    behind = sample.groups if binned.by_group is None else len(binned.by_group)
    time = float(sample.times[index])
    return Histogram(name, time, index, edges, share, error, theory, samples, behind, chi_square)


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
    """The first fine bin of each bin, from the counts expected in the fine bins.

    Bins start at LEAST_EXPECTED in the tails and double towards the middle, where the body is: a
    small excess at rest or far out is seen beside few others. Of a delta peak that stands on an
    edge, rounding may have put samples on either side: no bin ends there.
    """
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
