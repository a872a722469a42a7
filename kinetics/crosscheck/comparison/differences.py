"""Data and theory side by side, with the replicates from which every error follows."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.comparison.fit import Fit
from kinetics.crosscheck.comparison.histograms import HistogramResult, compare_histogram
from kinetics.crosscheck.comparison.reduction import SAME_TIME
from kinetics.crosscheck.comparison.sample import Sample
from kinetics.crosscheck.comparison.statistics import errors, spread_out
from kinetics.crosscheck.comparison.theory import (
    DISPLACEMENT,
    MOMENTS,
    SPEED,
    Expectation,
    SampledStart,
)
from kinetics.errors import InputError, short

if TYPE_CHECKING:
    from kinetics import Solution

Array = NDArray[np.float64]

HISTOGRAM_TIMES = 6
"""Times at which densities are compared, at most."""
_NO_SPREAD = 1e-9
"""Standard error over value below which the data have no spread: a start with one speed."""
_STEP = 1e-4


@dataclass(frozen=True, eq=False)
class Judged:
    """The numbers behind a comparison: rows and tests, what figures draw, what is refitted.

    theory, difference, error (n_names, n_times); replicates (G, n_names, n_times) of the
    difference; compared: where there is something to compare; usable: and where it has spread.
    densities: the solution of each density. histograms: name, index of the time, result.
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
    histograms: list[tuple[str, int, HistogramResult]]

    @property
    def flat_replicates(self) -> Array:
        """(G, n_names * n_times)."""
        return self.replicates.reshape(self.sample.groups, -1)


def judge(
    solution: "Solution",
    sample: Sample,
    found: Fit | None = None,
    densities: "Mapping[str, Solution] | None" = None,
) -> Judged:
    """A sample and a solution at the times and in the observables that both have.

    InputError if they have none in common, or the sample fewer than two groups.
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
    index = np.array([m for m in matches if m is not None], np.int64)
    sample = sample.at(keep)
    names, owners = _in_common(solution, sample, densities or {})
    expectation = Expectation(sample, names)
    theory, moved = _theory(solution, expectation, index)
    difference = expectation.values - theory
    replicates = expectation.replicates - moved
    if found is not None:
        shift = found.moved(replicates.reshape(sample.groups, -1))
        slopes = _slopes(solution, expectation, found)
        replicates = replicates - np.tensordot(shift, slopes, axes=(1, 0))
    error = errors(replicates.reshape(sample.groups, -1)).reshape(difference.shape)
    compared = np.isfinite(difference) & _meaningful(names, sample, solution)
    with np.errstate(invalid="ignore"):
        size = np.maximum(np.abs(expectation.values), np.abs(theory))
        usable = compared & (error > _NO_SPREAD * size) & np.isfinite(error)
    histograms = [
        (name, k, result)
        for name, density in owners.items()
        for k in histogram_times(sample)
        if (at := _match(sample.times[k], density.times)) is not None
        and (result := compare_histogram(sample, density, name, k, at)) is not None
    ]
    return Judged(
        sample, solution, expectation, theory, difference, replicates, error, compared, usable,
        owners, histograms,
    )  # fmt: skip


def _match(time: float, times: Array) -> int | None:
    k = int(np.argmin(np.abs(times - time)))
    return k if abs(times[k] - time) <= SAME_TIME * max(time, 1e-300) else None


def _in_common(
    solution: "Solution", sample: Sample, densities: "Mapping[str, Solution]"
) -> tuple[list[str], dict[str, "Solution"]]:
    """Averages, and densities with their solution, that were asked for and the sample has."""
    outputs = solution.scene.outputs
    names = [name for name in MOMENTS if name in outputs]
    owners = {}
    for name, counts in ((SPEED, sample.speeds), (DISPLACEMENT, sample.displacements)):
        owner = densities.get(name, solution)
        if name in owner.scene.outputs and counts is not None and hasattr(type(owner), name):
            owners[name] = owner
    if not names and not owners:
        raise InputError(
            f"solution: was asked for {', '.join(outputs)}; needed is at least one of "
            f"{', '.join((*MOMENTS, SPEED))}"
        )
    return names, owners


def _theory(solution: "Solution", expectation: Expectation, index: Any) -> tuple[Array, Array]:
    scene = solution.scene
    if not expectation.names:
        nothing = np.empty((0, index.size))
        return nothing, nothing
    if isinstance(scene.state, SampledStart) and expectation.sample.start is not None:
        return expectation.theory(scene.restitution, scene.mean_free_path, scene.state)
    values = np.stack([np.asarray(getattr(solution, name))[index] for name in expectation.names])
    return values, values


def _meaningful(names: Sequence[str], sample: Sample, solution: "Solution") -> NDArray[np.bool_]:
    """Not the displacement at time 0, nor speeds there if the theory starts from them."""
    out = np.ones((len(names), sample.times.size), dtype=bool)
    own_start = isinstance(solution.scene.state, SampledStart)
    for k, name in enumerate(names):
        if own_start or name in ("msd", "kurtosis"):
            out[k] = sample.times > 0
    return out


def _slopes(solution: "Solution", expectation: Expectation, found: Fit) -> Array:
    """d(theory)/d(parameters) of every component, (k, n_names, n_times)."""
    from kinetics.crosscheck.comparison.question import theory_of

    scene = solution.scene
    e, path, start = scene.restitution, scene.mean_free_path, scene.initial
    out = []
    for k, name in enumerate(found.names):
        up, down = found.values.copy(), found.values.copy()
        up[k], down[k] = up[k] + _STEP, down[k] - _STEP
        if name == "restitution":
            up[k], down[k] = min(up[k], 1.0), max(down[k], 0.0)
        above, below = (
            theory_of(expectation, found.names, at, e, path, start)[0] for at in (up, down)
        )
        out.append((above - below) / (up[k] - down[k]))
    return np.stack(out)


def histogram_times(sample: Sample) -> list[int]:
    """The indices of the times at which densities are compared."""
    later = np.flatnonzero(sample.times > 0)
    return [int(later[k]) for k in spread_out(later.size, HISTOGRAM_TIMES)]
