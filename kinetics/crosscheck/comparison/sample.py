"""A sample of tracers, reduced to sums over groups of them: all that a comparison looks at.

Tracers among the same scatterers are not independent, configurations are. So a group is a
configuration (or several), or, where configurations are unknown, a number of tracers; and
every standard error and every covariance is the spread over groups.
"""

import math
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Counts = NDArray[np.int64]

N, V2, V4, R2, R4, VX, X, X2 = range(8)
"""Columns of the sums: samples, and powers of speed and displacement. In a field also the velocity
and the displacement along it, along +x, and the square of this."""


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

    def at(self, keep: Any) -> "Binned":
        """The counts at the times with these indices."""
        groups = None if self.by_group is None else self.by_group[:, keep]
        effect = None if self.design_effect is None else self.design_effect[keep]
        return Binned(self.edges[keep], self.totals[keep], groups, effect)


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


@dataclass(frozen=True)
class Law:
    """What the system has beside the restitution: smooth disks in the plane, if not told.

    field : uniform acceleration along +x in U^2/d
    """

    tangential_restitution: float = 1.0
    dimension: int = 2
    field: float = 0.0

    @property
    def smooth_disks(self) -> bool:
        """Whether densities can be solved, which the solver does for this law alone."""
        return self == Law()

    @property
    def gaussian(self) -> float:
        """<v^4>/<v^2>^2 of a Gaussian: 2 in the plane, 5/3 in space."""
        return (self.dimension + 2) / self.dimension

    def free_path(self, density: float) -> float:
        """Mean free path in d at a number density in d^-2 (d^-3 in space); and the other way."""
        return 1 / ((2.0 if self.dimension == 2 else math.pi) * density)


@dataclass(frozen=True)
class Flights:
    """Tracers that have flown straight by a time: the ratio |r|/(|v| t) that they share.

    share: of all tracers at that time. The ratio is 1 where units belong together.
    """

    time: float
    ratio: float
    share: float


@dataclass(frozen=True, eq=False)
class Sample:
    """Sums over groups of tracers; lengths in d, speeds in U, times in d/U, time rising.

    Attributes
    ----------
    names : where the data came from
    times : (n_times,)
    sums : (n_groups, n_times, 5), of 1, v^2, v^4, r^2, r^4 in units of the scales; (.., 8) in a
        field, with v_x, x, x^2
    speed_scale, length_scale : (n_times,), in U and in d
    speeds, displacements : counts in bins, None where unknown
    start : the speeds at time 0, None without one
    at_rest : how many have speed zero, (n_times,)
    grouping : what a group is made of: "medium", "tracer", "row", or "table"
    law : tangential restitution and dimension
    flights : tracers that have flown straight, None if there are too few or it is unknown
    capped : collisions after which tracers were stopped, None if unknown or never
    free : known to be without recollisions (Boltzmann-Grad particles)
    tabulated : from a table of averages; the groups are made up (data.averages), and how errors at
        different times are correlated is not known
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
    law: Law = Law()
    flights: Flights | None = None
    capped: int | None = None
    free: bool = False
    tabulated: bool = False
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

    def rescaled(self, speed: float, length: float, time: float | None = None) -> "Sample":
        """The sample with U = `speed`, d = `length` and d/U = `time` in the units that it had.

        time: None is length/speed.
        """
        factor = speed / length if time is None else 1 / time

        def binned(found: Binned | None, unit: float) -> Binned | None:
            return None if found is None else replace(found, edges=found.edges / unit)

        start, told, flights = self.start, dict(self.told), self.flights
        if flights is not None:
            ratio = flights.ratio * speed / length / factor
            flights = replace(flights, time=flights.time * factor, ratio=ratio)
        if start is not None:
            start = replace(start, squares=start.squares / speed**2)
        if "number_density" in told:
            told["number_density"] *= length**self.law.dimension
        return replace(
            self,
            told=told,
            law=replace(self.law, field=self.law.field * length / speed**2),
            flights=flights,
            times=self.times * factor,
            speed_scale=self.speed_scale / speed,
            length_scale=self.length_scale / length,
            speeds=binned(self.speeds, speed),
            displacements=binned(self.displacements, length),
            start=start,
        )

    def at(self, keep: Any) -> "Sample":
        """The sample at the times with these indices."""
        by_time = ("times", "speed_scale", "length_scale", "at_rest")
        return replace(
            self,
            sums=self.sums[:, keep],
            speeds=None if self.speeds is None else self.speeds.at(keep),
            displacements=None if self.displacements is None else self.displacements.at(keep),
            **{name: getattr(self, name)[keep] for name in by_time},
        )
