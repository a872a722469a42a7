"""A sample: tracks reduced to sums over independent groups, all that a comparison looks at.

Tracers among the same scatterers are not independent, configurations are. So a group is one (or
several), or, where they are unknown, a number of tracers; every error is the spread over groups.
Begin with `Sample`; `reduce_tracks` makes it of tracks.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import NamedTuple, TypedDict

import numpy as np
from numpy.typing import NDArray

from kinetics.collision.impact import ImpactRestitution
from kinetics.crosscheck.data.arrays import Flags, Integers, is_there_or_later
from kinetics.crosscheck.data.drift import Drift, find_drift
from kinetics.crosscheck.data.frame_pairs import FramePairs, sum_over_pairs
from kinetics.crosscheck.data.tracks import Tracks
from kinetics.drive import DRIVES

Array = NDArray[np.float64]
Counts = NDArray[np.int64]
#: A scale for each time, (n_times,), and counts in bins over it, (n_groups, n_times, n_bins + 2).
Binned = tuple[Array, NDArray[np.int32]]

#: Columns of the sums: samples, powers of speed and displacement; in a field, and from a beam, v_x,
#: x and x^2 too, and the same of the other axes.
N, V2, V4, R2, R4, VX, X, X2 = range(8)
#: Groups at most: a prime, so that labels with a regular pattern spread over all of them. An error
#: from G groups has the relative error 1/sqrt(2 G), 4.5 % here.
MOST_GROUPS = 251
#: The same for counts in bins, 8 %.
HISTOGRAM_GROUPS = 83
#: A file's labels are shifted by this times its number, so that small runs do not fall together.
FILE_SHIFT = 97
#: Bins of speeds and displacements in an octave.
BINS_PER_OCTAVE = 12
#: Octaves of the bins below their scale. Origin not recorded.
OCTAVES_BELOW = 10
#: Octaves of the bins above their scale. Origin not recorded.
OCTAVES_ABOVE = 6
#: Edges of the bins, over their scale.
EDGES = 2.0 ** (
    np.arange(-BINS_PER_OCTAVE * OCTAVES_BELOW, BINS_PER_OCTAVE * OCTAVES_ABOVE + 1)
    / BINS_PER_OCTAVE
)
#: Bins of the speeds at time 0 in an octave.
START_BINS_PER_OCTAVE = 64
#: Tracers of which it is kept when they are there. Chosen: a share of 1 % is known to 15 %.
MAX_PATTERNS = 4000
#: Velocities at time 0 that differ by less, in U, are one velocity: a beam.
SAME_VELOCITY = 1e-9
#: Flights whose r/(v t) differ by less than this fraction are taken for straight ones: those that
#: have collided put some 0.5 % into such a width.
STRAIGHT_WITHIN = 0.002
#: Straight flights that are needed. Origin not recorded.
MIN_STRAIGHT_FLIGHTS = 20
#: Straight flights that are needed, over all tracers. Origin not recorded.
MIN_STRAIGHT_SHARE = 0.05
#: Relative accuracy of averages of the solver: far below any standard error.
AVERAGES_RTOL = 1e-7
#: The same where something drives the tracers, whose solvers take longer.
DRIVEN_RTOL = 1e-5


class Stated(TypedDict, total=False):
    """What data say of the system themselves; a key is missing where they do not say it."""

    restitution: float | ImpactRestitution
    number_density: float  # in d^-2, in space d^-3
    scatterers: str  # a name, as a Scene takes it
    initial: str  # a name, as a Scene takes it


class StartBins(NamedTuple):
    """Speeds at time 0 in fine bins, of those that move: mean v^2 in U^2 and tracers, (n_bins,)."""

    squares: Array
    counts: Counts


@dataclass(frozen=True, kw_only=True)
class Law:
    """What the system has, as a Scene has it, in U and d.

    Parameters
    ----------
    restitution : only one that depends on the impact speed; None for a number, which is no part
    """

    restitution: ImpactRestitution | None = None
    dimension: int = 2
    bath_speed: float = 0.0
    mass_ratio: float = math.inf
    heating: float = 0.0
    drag: float = 0.0
    field: float = 0.0
    capture_speed: float = 0.0
    tangential_restitution: float = 1.0

    @property
    def is_driven(self) -> bool:
        """Whether there is more than a field: then no causes of a difference are looked for."""
        return self.restitution is not None or any(getattr(self, name) for name in DRIVES)

    @property
    def rtol(self) -> float:
        """The relative accuracy that is asked of the solver for averages."""
        return DRIVEN_RTOL if self.field or self.is_driven else AVERAGES_RTOL

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
        cross_section = 2.0 if self.dimension == 2 else math.pi
        return 1 / (cross_section * density)


@dataclass(frozen=True, eq=False)
class Sample:
    """Sums over groups of tracers; lengths in d, speeds in U, times (n_times,) in d/U, rising.

    Parameters
    ----------
    names : where the data came from
    times : see above
    sums : of 1, v^2, v^4, r^2, r^4, and in a field, or if all start with one velocity, of v_x, x,
        x^2, v_y, ... too, shape (n_groups, n_times, n_sums). Without velocities those of the
        tracers that are there at the first frame, and NaN for powers of v
    at_rest : how many have speed zero, shape (n_times,)
    grouping : what a group is made of: "medium", "tracer" or "row"
    speeds, displacements : None, or a scale (n_times,) and counts between EDGES in units of it, and
        outside, of groups that are not those of the sums, (n, n_times, n_bins + 2)
    start : speeds at time 0; None where there are none
    flights : (time, |r|/(|v| t)) of tracers that have flown straight, at the time when most have:
        1 where units belong together, whatever the scatterers, or where few have
    law : what the system has
    free : known to meet no scatterer twice (Boltzmann-Grad particles)
    warnings : what the reader should know
    told : what the data say of the system
    units : "speed", "length" and "time": U, d and d/U in the data's unit, where they were told
    ended : tracers that are not there at a time nor later, shape (n_times,); None for a run that
        keeps sums alone
    has_velocities : whether velocities were measured; else `times` begin at 0, the first frame
    pairs : displacements between frames of all tracers, also of those that come later; None for
        data that have velocities
    unit_names : "length", "speed" and "time": names of the data's units, where their columns say
        them ("mm", "mm/s", "s")
    presence : when tracers are there, of some thousand of them, shape (n, n_times); None where all
        are there at all times. Means over tracers with gaps are not of the same tracers at two
        times, and less correlated
    drift : the mean velocity in U that all times share; None if there is none
    """

    names: tuple[str, ...]
    times: Array
    sums: Array
    at_rest: Counts
    grouping: str
    speeds: Binned | None = None
    displacements: Binned | None = None
    start: StartBins | None = None
    flights: tuple[float, float] = (0.0, 1.0)
    law: Law = Law()
    free: bool = False
    warnings: tuple[str, ...] = ()
    told: Stated = field(default_factory=Stated)
    units: dict[str, float] = field(default_factory=dict)
    ended: Counts | None = None
    has_velocities: bool = True
    pairs: FramePairs | None = None
    unit_names: dict[str, str] = field(default_factory=dict)
    presence: Flags | None = None
    drift: Drift | None = None

    def at_times(self, indices: Integers) -> Sample:
        """Return the averages of some of the times, which hold all frames of its pairs."""
        sample = replace(
            self,
            times=self.times[indices],
            sums=self.sums[:, indices],
            at_rest=self.at_rest[indices],
            speeds=_bins_at(self.speeds, indices),
            displacements=_bins_at(self.displacements, indices),
        )
        if self.ended is not None:
            sample = replace(sample, ended=self.ended[indices])
        if self.presence is not None:
            sample = replace(sample, presence=self.presence[:, indices])
        if self.pairs is not None:
            earlier = np.searchsorted(indices, self.pairs.earlier)
            later = np.searchsorted(indices, self.pairs.later)
            sample = replace(sample, pairs=replace(self.pairs, earlier=earlier, later=later))
        return sample

    @property
    def is_complete(self) -> NDArray[np.bool_]:
        """Whether no tracer has ended at a time; those with a gap come back. Shape (n_times,)."""
        if self.ended is None:
            return self.samples == self.samples.max()
        return self.ended == 0

    @property
    def is_independent(self) -> bool:
        """Whether tracers, and not the media that some of them share, are independent."""
        return self.free or self.grouping != "medium"

    @property
    def groups(self) -> int:
        """Number of independent groups."""
        return len(self.sums)

    @property
    def samples(self) -> Counts:
        """Tracers at each time, (n_times,)."""
        return np.rint(self.sums[:, :, N].sum(axis=0)).astype(np.int64)


def _bins_at(counted: Binned | None, indices: Integers) -> Binned | None:
    """Return the scales and counts of some of the times."""
    if counted is None:
        return None
    scales, counts = counted
    return scales[indices], counts[:, indices]


def reduce_tracks(
    tracks: Tracks,
    label: Integers,
    names: tuple[str, ...],
    grouping: str,
    with_axes: bool = False,
) -> Sample:
    """Return the sums over groups of tracers.

    Parameters
    ----------
    tracks : displacements and velocities
    label : whole numbers that say what belongs together, shape (n,)
    names, grouping : see :class:`Sample`
    with_axes : whether sums along each axis are needed
    """
    group = (label % MOST_GROUPS + FILE_SHIFT * tracks.file) % MOST_GROUPS
    has_velocities = tracks.velocity is not None
    velocity = tracks.velocity
    if velocity is None:
        velocity = np.full_like(tracks.place, np.nan)
    is_there = _is_there(tracks)
    n_axes = 0
    if with_axes or (has_velocities and _is_beam(tracks.times, velocity)):
        n_axes = tracks.place.shape[2]
    n_times = tracks.times.size
    sums = np.zeros((MOST_GROUPS, n_times, VX + 3 * n_axes))
    at_rest = np.zeros(n_times, np.int64)
    speed_bins = _Bins.empty(n_times)
    displacement_bins = _Bins.empty(n_times)
    start = None
    straightest = StraightFlights(0.0, 1.0, 0.0)
    for index, time in enumerate(tracks.times.tolist()):
        r = tracks.place[index, is_there[index]]
        v = velocity[index, is_there[index]]
        groups_there = group[is_there[index]]
        speed = size_of(v)
        distance = size_of(r)
        sums[:, index] = _sums_by_group(groups_there, speed, distance, v, r, n_axes)
        displacement_bins.count(index, distance, groups_there)
        if not has_velocities:
            continue
        flights = StraightFlights.of(time, distance, speed)
        if flights.share > straightest.share:
            straightest = flights
        at_rest[index] = np.count_nonzero(speed == 0)
        speed_bins.count(index, speed, groups_there)
        if time == 0:
            start = _start_bins(speed)
    is_used = sums[..., N].sum(axis=1) > 0
    speeds = None
    drift = None
    pairs = None
    if has_velocities:
        speeds = speed_bins.of_used_groups()
        drift = find_drift(velocity, group)
    else:
        sums[..., [V2, V4]] = np.nan
        pairs = sum_over_pairs(tracks.times, tracks.place, group, MOST_GROUPS)
        is_used |= pairs.has_tracers
        pairs = pairs.of_groups(is_used)
    return Sample(
        names=names,
        times=tracks.times,
        sums=sums[is_used],
        at_rest=at_rest,
        grouping=grouping,
        speeds=speeds,
        displacements=displacement_bins.of_used_groups(),
        start=start,
        flights=(straightest.time, straightest.ratio),
        ended=_count_ended(is_there),
        has_velocities=has_velocities,
        pairs=pairs,
        presence=_presence(tracks),
        drift=drift,
    )


def _is_there(tracks: Tracks) -> NDArray[np.bool_]:
    """Return which tracers count at each time, shape (n_times, n).

    Displacements from the first frame, which is all that positions alone have beside pairs of
    frames, are those of the tracers that are there then.
    """
    if tracks.velocity is not None:
        return np.isfinite(tracks.velocity[:, :, 0])
    is_there = np.isfinite(tracks.place[:, :, 0])
    return is_there & is_there[0]


def _presence(tracks: Tracks) -> NDArray[np.bool_] | None:
    """Return when tracers are there, (n, n_times), of `MAX_PATTERNS` at most; None if always."""
    places = tracks.place if tracks.velocity is None else tracks.velocity
    is_there = np.isfinite(places[:, :, 0])
    if np.all(is_there):
        return None
    stride = is_there.shape[1] // MAX_PATTERNS + 1
    return np.ascontiguousarray(is_there[:, ::stride].T)


def _count_ended(is_there: NDArray[np.bool_]) -> Counts:
    """Return how many tracers are gone for good at each time; is_there : (n_times, n)."""
    has_begun = np.any(is_there, axis=0)
    return np.count_nonzero(has_begun & ~is_there_or_later(is_there), axis=1)


def _is_beam(times: Array, velocity: Array) -> bool:
    """Return whether all tracers start with one velocity."""
    deviation = velocity[0] - np.nanmean(velocity[0], axis=0)
    return bool(times[0] == 0 and np.nanmax(np.abs(deviation)) < SAME_VELOCITY)


def _sums_by_group(
    group: Integers, speed: Array, distance: Array, v: Array, r: Array, n_axes: int
) -> Array:
    """Return the sums of one time, shape (MOST_GROUPS, n_sums)."""
    powers: list[Array | None] = [None, speed**2, (speed**2) ** 2, distance**2, (distance**2) ** 2]
    for axis in range(n_axes):
        powers += [v[:, axis], r[:, axis], r[:, axis] ** 2]
    return np.transpose([np.bincount(group, power, MOST_GROUPS) for power in powers])


@dataclass
class _Bins:
    """Counts of speeds, or displacements, in bins over a scale that follows them.

    Attributes
    ----------
    scales : shape (n_times,)
    counts : below, in and above the bins, shape (HISTOGRAM_GROUPS, n_times, n_bins + 2)
    """

    scales: Array
    counts: NDArray[np.int32]

    @classmethod
    def empty(cls, n_times: int) -> _Bins:
        """Return bins without counts."""
        shape = (HISTOGRAM_GROUPS, n_times, EDGES.size + 1)
        return cls(np.ones(n_times), np.zeros(shape, np.int32))

    def count(self, index: int, size: Array, group: Integers) -> None:
        """Count the sizes of one time."""
        n_bins = EDGES.size + 1
        with np.errstate(divide="ignore"):
            logs = np.log2(size)
            log_mean_square = np.log2(np.sum(size**2) / max(size.size, 1))
        # the root mean square as a power of 2 hardly depends on single tracers
        octave = max(np.round(log_mean_square / 2), -1000.0)
        self.scales[index] = 2.0**octave
        level = np.floor(BINS_PER_OCTAVE * (logs - octave + OCTAVES_BELOW))
        bin_of = np.clip(level, -1, n_bins - 2).astype(np.int64) + 1
        cells = group % HISTOGRAM_GROUPS * n_bins + bin_of
        counted = np.bincount(cells, minlength=HISTOGRAM_GROUPS * n_bins)
        self.counts[:, index] = counted.reshape(-1, n_bins)

    def of_used_groups(self) -> tuple[Array, NDArray[np.int32]]:
        """Return the scales, and the counts of the groups that have some."""
        is_used = self.counts.any(axis=(1, 2))
        return self.scales, self.counts[is_used]


def _start_bins(speed: Array) -> StartBins:
    """Return the speeds at time 0 in fine bins."""
    moving = speed[speed > 0]
    level = np.floor(START_BINS_PER_OCTAVE * np.log2(moving))
    _, code, counts = np.unique(level, return_inverse=True, return_counts=True)
    return StartBins(np.bincount(code, moving * moving) / counts, counts)


class StraightFlights(NamedTuple):
    """Tracers that have the same r/(v t), as before a collision: their share, it, and the time."""

    share: float
    ratio: float
    time: float

    @classmethod
    def of(cls, time: float, distance: Array, speed: Array) -> StraightFlights:
        """Find those among tracers (n,) at a time; a share of 0 where there are too few."""
        is_moving = (distance > 0) & (speed > 0) & (time > 0)
        log_time = math.log(time or 1.0)
        log_ratio = np.sort(np.log(distance[is_moving]) - np.log(speed[is_moving]) - log_time)
        end = np.searchsorted(log_ratio, log_ratio + STRAIGHT_WITHIN)
        alike = end - np.arange(log_ratio.size)
        count = int(alike.max(initial=0))
        if count < max(MIN_STRAIGHT_FLIGHTS, MIN_STRAIGHT_SHARE * distance.size):
            return cls(0.0, 1.0, time)
        first = int(np.argmax(alike))
        ratio = float(np.exp(np.median(log_ratio[first : first + count])))
        return cls(count / distance.size, ratio, time)


def size_of(vectors: Array) -> Array:
    """Return the length of vectors (n, d), also of 1e200."""
    in_plane = np.hypot(vectors[:, 0], vectors[:, 1])  # `np.hypot.reduce` takes longer
    if vectors.shape[1] == 2:
        return in_plane
    return np.hypot(in_plane, vectors[:, 2])


def errors(replicates: Array) -> Array:
    """Return standard errors from delete-one replicates (G, ...)."""
    return np.asarray(replicates.std(axis=0) * np.sqrt(len(replicates) - 1))


def effective_groups(replicates: Array) -> Array:
    """Return the groups that a variance from delete-one replicates (G, ...) is as good as.

    The relative variance of a variance is (2 + kurtosis)/G (Satterthwaite's rule): G at most.
    """
    deviation = replicates - replicates.mean(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        excess = np.mean(deviation**4, axis=0) / np.mean(deviation**2, axis=0) ** 2 - 3
    excess = np.where(np.isfinite(excess), np.maximum(excess, 0.0), 0.0)
    return np.asarray(1 + 2 * (len(replicates) - 1) / (2 + excess))
