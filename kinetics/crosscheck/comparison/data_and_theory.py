"""Data and theory side by side, with the replicates from which every error follows."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.comparison.fit import Fit
from kinetics.crosscheck.comparison.histograms import Histogram, compare_histogram
from kinetics.crosscheck.comparison.reduction import SAME_TIME
from kinetics.crosscheck.comparison.sample import Sample
from kinetics.crosscheck.comparison.statistics import errors, spread_out
from kinetics.crosscheck.comparison.theory import (
    AVERAGES,
    DISPLACEMENT,
    SPEED,
    Expectation,
    SampledStart,
)
from kinetics.errors import InputError, short

if TYPE_CHECKING:
    from kinetics import Solution

Array = NDArray[np.float64]

HISTOGRAM_TIMES = 6
"""Times at which densities are compared, at most: each takes the solver some 0.1 s."""
NO_SPREAD = 1e-9
"""Standard error over value below which the data have no spread: a start with one speed."""


@dataclass(frozen=True, eq=False)
class DataAndTheory:
    """The numbers behind a comparison: rows and tests, what figures draw, what is fitted again.

    theory, difference, error (n_names, n_times); replicates (G, n_names, n_times) of the
    difference; compared: where there is something to compare; usable: and where it has spread.
    densities: the solution of each density. histograms: one for each density and time.
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
        shift = found.moved(replicates.reshape(sample.groups, -1))
        replicates = replicates - (shift @ found.slope.T).reshape(replicates.shape)
    error = errors(replicates.reshape(sample.groups, -1)).reshape(difference.shape)
    compared = np.isfinite(difference) & _meaningful(names, sample, solution)
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
        owners, histograms,
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
    scene = solution.scene
    if not expectation.names:
        nothing = np.empty((0, len(index)))
        return nothing, nothing
    if isinstance(scene.state, SampledStart) and expectation.sample.start is not None:
        return expectation.theory(scene.restitution, scene.mean_free_path, scene.state)
    values = np.stack([np.asarray(getattr(solution, name))[index] for name in expectation.names])
    return values, values


def _meaningful(names: Sequence[str], sample: Sample, solution: "Solution") -> Any:
    """Not the displacement at time 0, nor speeds there if the theory starts from them."""
    out = np.ones((len(names), sample.times.size), dtype=bool)
    own_start = isinstance(solution.scene.state, SampledStart)
    for k, name in enumerate(names):
        if own_start or name in ("msd", "kurtosis"):
            out[k] = sample.times > 0
    return out
