"""A sample of tracers, reduced to sums over groups of them: all that a comparison looks at.

Tracers among the same scatterers are not independent, configurations are. So a group is a
configuration (or several), or, where configurations are unknown, a number of tracers; and
every standard error and every covariance is the spread over groups.
"""

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kinetics.errors import InputError

if TYPE_CHECKING:
    from particles.ensemble import Ensemble

Array = NDArray[np.float64]
Counts = NDArray[np.int64]

N, V2, V4, R2, R4 = range(5)
"""Columns of the sums: samples, and powers of speed and displacement."""
LOWEST, PER_OCTAVE, BINS = -10, 12, 192
"""Bins of a reduction: log2 of the lowest edge over the scale, bins per octave, their number."""


@dataclass(frozen=True, eq=False)
class Binned:
    """Counts in bins of speed or displacement, in U or d.

    edges (n_times, n_bins + 1); totals (n_times, n_bins + 2), the first and last of what lies
    outside; by_group (n, n_times, n_bins + 2) of independent groups, not those of the sums, None
    where only totals are known. Then design_effect (n_times,) is the variance of a count over that
    of independent samples.
    """

    edges: Array
    totals: Counts
    by_group: Counts | None = None
    design_effect: Array | None = None


@dataclass(frozen=True, eq=False)
class StartBins:
    """Speeds at time 0 in fine bins, of the tracers that move.

    squares (n_bins,): mean v^2 in each bin, in U^2; flatness (n_bins,): <v^4>/<v^2>^2 in it, a
    little above 1; by_group (n_groups, n_bins): counts.
    """

    squares: Array
    flatness: Array
    by_group: Counts

    @property
    def counts(self) -> Counts:
        """Tracers in each bin, (n_bins,)."""
        return np.asarray(self.by_group.sum(axis=0))

    def rescaled(self, speed: float) -> "StartBins":
        """The same with U = `speed` in the unit that it had."""
        return StartBins(self.squares / speed**2, self.flatness, self.by_group)


@dataclass(frozen=True, eq=False)
class Sample:
    """Sums over groups of tracers; lengths in d, speeds in U, times in d/U, time rising.

    Attributes
    ----------
    names : where the data came from
    times : (n_times,)
    sums : (n_groups, n_times, 5), of 1, v^2, v^4, r^2, r^4 in units of the scales
    speed_scale, length_scale : (n_times,), in U and in d
    speeds, displacements : counts in bins, None where unknown
    start : the speeds at time 0, None without one
    at_rest : how many have speed zero, (n_times,)
    grouping : what a group is made of: "medium", "tracer" or "row"
    capped : collisions after which tracers were stopped, None if unknown or never
    media : how many configurations there are, None if unknown
    free : known to be without recollisions (Boltzmann-Grad particles)
    warnings : what the reader should know, a sentence each
    told : "restitution", "number_density" (in d^-2) and "initial", as far as the data say
    """

    names: tuple[str, ...]
    times: Array
    sums: Array
    speed_scale: Array
    length_scale: Array
    speeds: Binned | None
    displacements: Binned | None
    start: StartBins | None
    at_rest: Counts
    grouping: str
    capped: int | None = None
    media: int | None = None
    free: bool = False
    warnings: tuple[str, ...] = field(default=())
    told: dict[str, Any] = field(default_factory=dict)

    @property
    def groups(self) -> int:
        """Number of independent groups."""
        return len(self.sums)

    @property
    def samples(self) -> Counts:
        """Tracers at each time, (n_times,)."""
        return np.rint(self.sums[:, :, N].sum(axis=0)).astype(np.int64)

    def rescaled(self, speed: float, length: float) -> "Sample":
        """The sample with U = `speed` and d = `length` in the units that it had."""

        def binned(found: Binned | None, unit: float) -> Binned | None:
            return None if found is None else replace(found, edges=found.edges / unit)

        start = None if self.start is None else self.start.rescaled(speed)
        told = dict(self.told)
        if "number_density" in told:
            told["number_density"] *= length**2
        return replace(
            self,
            told=told,
            times=self.times * speed / length,
            speed_scale=self.speed_scale / speed,
            length_scale=self.length_scale / length,
            speeds=binned(self.speeds, speed),
            displacements=binned(self.displacements, length),
            start=start,
        )

    def at(self, keep: Any) -> "Sample":
        """The sample at the times with these indices."""

        def binned(found: Binned | None) -> Binned | None:
            if found is None:
                return None
            groups, effect = found.by_group, found.design_effect
            return Binned(
                found.edges[keep],
                found.totals[keep],
                None if groups is None else groups[:, keep],
                None if effect is None else effect[keep],
            )

        return replace(
            self,
            times=self.times[keep],
            sums=self.sums[:, keep],
            speed_scale=self.speed_scale[keep],
            length_scale=self.length_scale[keep],
            speeds=binned(self.speeds),
            displacements=binned(self.displacements),
            at_rest=self.at_rest[keep],
        )


def bin_edges(scale: Array) -> Array:
    """Edges of a reduction's bins, (n_times, BINS + 1)."""
    return scale[:, None] * 2.0 ** (LOWEST + np.arange(BINS + 1) / PER_OCTAVE)


def from_ensemble(ensemble: "Ensemble", name: str = "ensemble") -> Sample:
    """The sums of a particle run, in its own unit of length.

    With raw velocities and positions, histograms are by configuration. InputError for a run
    without output times or with fewer than two groups.
    """
    from particles import BoltzmannGrad
    from particles.configuration import time_scales

    times = np.asarray(ensemble.times)
    if times.size == 0 or ensemble.moments.size == 0:
        raise InputError(f"{name}: this run has no output times; simulate(..., times=...)")
    free = isinstance(ensemble.medium, BoltzmannGrad)
    raw = ensemble.arrays
    if "raw/velocities" in raw and "raw/positions" in raw:
        found = _from_raw(ensemble, name, free)
    else:
        unit = ensemble.medium.diameter
        scales = time_scales(times / unit)
        found = Sample(
            names=(name,),
            times=times,
            sums=np.asarray(ensemble.moments[:, :, : R4 + 1]),
            speed_scale=1.0 / scales,
            length_scale=np.full(times.size, unit),
            speeds=_histogram(ensemble, "speed_histogram", free),
            displacements=_histogram(ensemble, "displacement_histogram", free),
            start=None,
            at_rest=np.asarray(ensemble.trapped),
            grouping="medium",
            free=free,
        )
    if found.groups < 2:
        raise InputError(f"{name}: has one configuration; standard errors need at least two")
    plan = ensemble.plan
    start = "monoenergetic" if plan.monoenergetic else "gaussian"
    return replace(
        found,
        capped=plan.max_collisions,
        media=None if free else ensemble.media,
        told={"restitution": ensemble.restitution, "number_density": ensemble.number_density}
        | ({"initial": start} if plan.velocities is None else {}),
    )


def _from_raw(ensemble: "Ensemble", name: str, free: bool) -> Sample:
    from kinetics.crosscheck.comparison.data.columns import Rows
    from kinetics.crosscheck.comparison.reduction import Reduction

    media, tracers = ensemble.media, ensemble.tracers
    label = np.arange(media * tracers)
    # Tracers of a Boltzmann-Grad run share nothing: each of them is on its own.
    reduction = Reduction(grouping="tracer" if free else "medium")
    positions, velocities = ensemble.positions, ensemble.velocities
    for k, time in enumerate(ensemble.times):
        there = np.isfinite(velocities[k, :, 0])
        (x, y), (vx, vy) = positions[k, there].T, velocities[k, there].T
        at = np.full(int(there.sum()), float(time))
        reduction.add(Rows(at, x, y, vx, vy, label[there], label[there] // tracers))
    return replace(reduction.sample((name,)), free=free)


def _histogram(ensemble: "Ensemble", name: str, free: bool) -> Binned | None:
    key = f"histograms/{name}/sums"
    if key not in ensemble.arrays:
        return None
    found = getattr(ensemble, name)
    totals = ensemble.arrays[key][0]
    n = totals.sum(axis=1)
    effect = np.ones(len(totals))
    if not free:
        p, error = found.probability.value, found.probability.error
        used = totals[:, 1:-1] >= 20
        with np.errstate(invalid="ignore", divide="ignore"):
            binomial = np.where(used, p * (1 - p) / n[:, None], 0.0).sum(axis=1)
            effect = np.where(used, error**2, 0.0).sum(axis=1) / binomial
        effect = np.where(np.isfinite(effect), np.maximum(effect, 1.0), 1.0)
    edges = np.broadcast_to(found.edges, (len(totals), found.edges.size))
    return Binned(np.asarray(edges), totals, None, effect)
