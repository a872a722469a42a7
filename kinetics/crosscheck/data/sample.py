"""A sample of tracers, reduced to sums over groups of them: all that a comparison looks at.

Tracers among the same scatterers are not independent, configurations are. So a group is a
configuration (or several), or, where configurations are unknown, a number of tracers; and
every standard error and every covariance is the spread over groups.
"""

import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.data.formats import read
from kinetics.crosscheck.data.tracks import (
    Asked,
    Averages,
    Table,
    Tracks,
    joined,
    name_of,
    unwrapped,
)
from kinetics.crosscheck.data.units import Flights, are_own, conversion, straight_flights
from kinetics.crosscheck.words import numeral
from kinetics.errors import InputError

Array = NDArray[np.float64]
Counts = NDArray[np.int64]

N, V2, V4, R2, R4, VX, X, X2 = range(8)
"""Columns of the sums: samples, and powers of speed and displacement. In a field also the velocity
and the displacement along it, along +x, and the square of this."""
MOST_GROUPS, HISTOGRAM_GROUPS = 251, 83
"""Groups that tracers or configurations are gathered in, at most: primes, so that labels with a
regular pattern spread over all of them. The relative error of a standard error from G groups is
1/sqrt(2 G): 4.5 %, and 8 % for the counts in bins, which take most of the memory."""
_LOWEST, _PER_OCTAVE, _BINS = -10, 12, 192
"""Bins of speeds and displacements: log2 of the lowest edge over the root mean square, bins per
octave, their number: edges 6 % apart, from a thousandth of the root mean square to 64 times it."""
_START_LOWEST, _START_PER_OCTAVE, _START_BINS = -30, 64, 64 * 40
_ROUNDING = 1e-9
_LARGEST = 1e70
"""Speeds and displacements in U and d, and 1/speeds at the start: fourth powers are doubles."""
_WIDELY = 20.0
"""Tracers that must have left the region of time 0, were positions not wrapped: then that none
has is no chance."""


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
    by_group: Any = None
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
    flights : tracers that have flown straight, of the time at which most of them have
    capped : collisions after which tracers were stopped, None without a cap
    free : known to meet no scatterer twice (Boltzmann-Grad particles)
    tabulated : from a table of averages; the groups are made up (summaries), and how errors at
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
    warnings: tuple[str, ...] = ()
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
        start, told, seen = self.start, dict(self.told), self.flights
        if "number_density" in told:
            told["number_density"] *= length**self.law.dimension
        if seen is not None:
            seen = Flights(seen.time * factor, seen.ratio * speed / length / factor, seen.share)
        speeds, displacements = (
            one and replace(one, edges=one.edges / unit)
            for one, unit in ((self.speeds, speed), (self.displacements, length))
        )
        return replace(
            self, speeds=speeds, displacements=displacements, told=told,
            law=replace(self.law, field=self.law.field * length / speed**2), flights=seen,
            times=self.times * factor, speed_scale=self.speed_scale / speed,
            length_scale=self.length_scale / length,
            start=start and replace(start, squares=start.squares / speed**2),
        )  # fmt: skip

    def at(self, keep: Any) -> "Sample":
        """The sample at the times with these indices."""
        return replace(
            self,
            sums=self.sums[:, keep],
            speeds=self.speeds and self.speeds.at(keep),
            displacements=self.displacements and self.displacements.at(keep),
            **{
                name: getattr(self, name)[keep]
                for name in ("times", "speed_scale", "length_scale", "at_rest")
            },
        )


def _bins(values: Any, lowest: float, per_octave: float, bins: int) -> Any:
    """The bin of each value: 0 below the bins (or zero), bins + 1 above them."""
    with np.errstate(divide="ignore"):
        place = np.floor((np.log2(values) - lowest) * per_octave)
    return np.clip(place, -1, bins).astype(np.int64) + 1


def _size(vectors: Any) -> Any:
    """The length of vectors (n, d), also of 1e200."""
    plane = np.hypot(vectors[:, 0], vectors[:, 1])
    return plane if vectors.shape[1] == 2 else np.hypot(plane, vectors[:, 2])


def _scale(size: Any) -> float:
    """Root mean square as a power of 2, so that it hardly depends on single tracers."""
    largest = float(size.max(initial=0.0))
    if largest == 0.0:
        return 1.0
    with np.errstate(under="ignore"):
        found = np.log2(np.mean((size / largest) ** 2)) / 2 + np.log2(largest)
    return float(2.0 ** np.clip(np.round(found), -1000, 1000))


def reduced(
    tracks: Tracks, label: Any, names: tuple[str, ...], grouping: str, with_field: bool = False
) -> Sample:
    """The sums over groups of tracers; label (n,): whole numbers that say what belongs together."""
    # Another file's labels begin elsewhere, so that small runs do not fall on each other.
    group = (label % MOST_GROUPS + 97 * tracks.file) % MOST_GROUPS
    count = tracks.times.size
    sums = np.zeros((MOST_GROUPS, count, 8 if with_field else 5))
    scales = np.ones((2, count))
    counts = np.zeros((2, HISTOGRAM_GROUPS, count, _BINS + 2), np.int32)
    at_rest, flights, start = np.zeros(count, np.int64), [], None
    for k, (place, velocity) in enumerate(zip(tracks.place, tracks.velocity, strict=True)):
        there = np.isfinite(velocity[:, 0])
        mine, own = group, None if tracks.own is None else tracks.own[k]
        if not np.all(there):
            place, velocity, mine = place[there], velocity[there], group[there]
            own = None if own is None else own[there]
        speed, distance = _size(velocity), _size(place)
        scales[:, k] = _scale(speed), _scale(distance)
        time = tracks.times[k] if own is None else own
        flights.append(straight_flights(time, distance, speed))
        v, r = speed / scales[0, k], distance / scales[1, k]
        powers = [None, v * v, (v * v) ** 2, r * r, (r * r) ** 2]
        if with_field:
            x = place[:, 0] / scales[1, k]
            powers += [velocity[:, 0] / scales[0, k], x, x * x]
        for column, power in enumerate(powers):
            sums[:, k, column] = np.bincount(mine, power, MOST_GROUPS)
        row = mine % HISTOGRAM_GROUPS * (_BINS + 2)
        for out, values in zip(counts, (v, r), strict=True):
            cell = row + _bins(values, _LOWEST, _PER_OCTAVE, _BINS)
            every = np.bincount(cell, minlength=HISTOGRAM_GROUPS * (_BINS + 2))
            out[:, k] = every.reshape(HISTOGRAM_GROUPS, -1)
        at_rest[k] = np.count_nonzero(v == 0)
        if tracks.times[k] == 0:
            start = _start_bins(v, mine, scales[0, k])
    used = sums[..., N].sum(axis=1) > 0

    def binned(found: Any, scale: Any) -> Binned:
        by_group = found[found.any(axis=(1, 2))]
        edges = scale[:, None] * 2.0 ** (_LOWEST + np.arange(_BINS + 1) / _PER_OCTAVE)
        return Binned(edges, by_group.sum(axis=0, dtype=np.int64), by_group)

    start = start and replace(start, by_group=start.by_group[used])
    seen = max(filter(None, flights), key=lambda one: one.share, default=None)
    return Sample(
        names, tracks.times, sums[used], scales[0], scales[1], binned(counts[0], scales[0]),
        binned(counts[1], scales[1]), start, at_rest, grouping, flights=seen,
    )  # fmt: skip


def _start_bins(v: Any, group: Any, unit: float) -> StartBins:
    bins = _START_BINS + 2
    place = _bins(v, _START_LOWEST, _START_PER_OCTAVE, _START_BINS)
    counts = np.bincount(group * bins + place, minlength=MOST_GROUPS * bins).reshape(-1, bins)
    powers = np.stack([np.bincount(place, v**power, bins) for power in (2, 4)])
    moving = powers[0] > 0
    counts = counts[:, moving]
    squares, quartics = powers[:, moving] / counts.sum(axis=0)
    with np.errstate(over="ignore", under="ignore"):  # refused later, in `_in_range`
        return StartBins(squares * np.square(unit), quartics / squares**2, counts)


# -- from files to a sample ------------------------------------------------------------------------


def read_sample(
    sources: Sequence[Path | Table], show_progress: bool = False, **told: Any
) -> Sample:
    """One sample from files or columns in memory (see `formats`), or from one file of an Ensemble.

    told : what the user says about the data, the arguments of `tracks.Asked`
    show_progress : count the files that have been read, on a terminal

    Of an Ensemble file all is known, and what is told is not looked at. Several files are
    independent runs: a label in one is not the same label in another. With one configuration, or
    without the column `medium`, standard errors are by tracer, and the sample's warnings say so.
    The files are only read. InputError for what cannot be used.
    """
    from kinetics.crosscheck.data import summaries

    if not sources:
        raise InputError("data: got no file; at least one is needed")
    asked, names = Asked(**told), tuple(name_of(source) for source in sources)
    runs = [source for source in sources if summaries.is_ensemble(source)]
    if runs and len(sources) > 1:
        raise InputError(f"{name_of(runs[0])}: an Ensemble file must be the only file")
    if runs:
        return summaries.read_ensemble(Path(name_of(runs[0])))
    paths = [source for source in sources if isinstance(source, Path)]
    for name in (name_of(path) for k, path in enumerate(paths) if path in paths[:k]):
        raise InputError(f"{name}: stands twice; its tracers would be taken for independent ones")
    parts = []
    for k, source in enumerate(sources, 1):
        if show_progress and len(sources) > 1 and sys.stderr.isatty():
            print(f"file {k} of {len(sources)}", end="\r", file=sys.stderr)
        parts.append(read(source, asked))
    names = tuple(name.rsplit("/", 1)[-1] for name in names)
    law = Law(dimension=asked.dimension or 2)
    tables = [part for part in parts if isinstance(part, Averages)]
    if tables and (len(parts) > 1 or asked.with_field):
        why = "must be the only file, and not of data in a field"
        raise InputError(f"{', '.join(names)}: a table of averages {why}")
    if tables:
        return _scaled(summaries.of_averages(tables[0], names, law), asked, tables[0].units)
    tracks, warnings = _displacements([p for p in parts if isinstance(p, Tracks)], names, asked)
    sample, more = _grouped(tracks, names, asked)
    sample = replace(sample, law=law, warnings=(*warnings, *more))
    return _scaled(sample, asked, tracks.units)


def _displacements(
    parts: Sequence[Tracks], names: Sequence[str], asked: Asked
) -> tuple[Tracks, list[str]]:
    """The tracers of all files relative to their places at time 0, and what is to be said of it."""
    where, warnings = ", ".join(names), list[str]()
    found = [(part, False) if asked.with_field else unwrapped(part) for part in parts]
    tracks = joined([part for part, _ in found], names, asked.bin_times or 0.0)
    if tracks.own is not None:
        tracks = _at_their_means(tracks, asked, warnings)
    place, zero = tracks.place, tracks.times[0] == 0
    with np.errstate(over="ignore", under="ignore"):
        size = [float(np.sqrt(np.nanmean(_size(at) ** 2))) for at in place]
    moved = zero and size[0] > _ROUNDING * max(size)
    if asked.positions == "absolute" or (asked.positions == "auto" and moved):
        if tracks.tracer is None or not zero:
            lost = "rows at time 0" if tracks.tracer is not None else "a column tracer"
            raise InputError(
                f"{where}: absolute positions need {lost}; displacements relative to the place at "
                "time 0 need nothing"
            )
        gone = np.isnan(place[0, :, 0])
        if np.any(gone):
            raise InputError(f"{where}: tracer {tracks.tracer[gone][0]} has no row at time 0")
        tracks = replace(tracks, place=place - place[0])
        _require_not_wrapped(where, place, tracks.place)
        if asked.positions == "auto":
            warnings.append(
                "Positions at time 0 are not the origin: each tracer's own place at time 0 was "
                "subtracted from its positions."
            )
    if any(crossed for _, crossed in found):
        warnings.append(
            "Positions were wrapped at the edges of the box and have been unwrapped: between "
            "frames every tracer moves by less than half the box."
        )
    return tracks, warnings


def _at_their_means(tracks: Tracks, asked: Asked, warnings: list[str]) -> Tracks:
    """Binned times at the mean of their rows, and the sentence on the widest of them."""
    times, low, high = (f(tracks.own, axis=1) for f in (np.nanmean, np.nanmin, np.nanmax))
    k = int(np.argmax((high - low) / np.where(times > 0, times, 1.0)))
    warnings.append(
        f"Times within {numeral(asked.bin_times or 0.0, '.3g')} of each other are one time, at "
        f"their mean: {times.size} times. The widest is from {numeral(low[k], '.6g')} to "
        f"{numeral(high[k], '.6g')} in the data's unit, with mean {numeral(times[k], '.6g')}."
    )
    return replace(tracks, times=times)


def _require_not_wrapped(where: str, place: Any, moved: Any) -> None:
    """InputError where tracers move far, and yet none leaves the region of time 0."""
    low, high = place[0].min(axis=0), place[0].max(axis=0)
    n, size = place.shape[1], float((high - low).min())
    # The farthest tracer is not quite at the edge of the region that they come from.
    away = np.nanmax(np.abs(place - (low + high) / 2), axis=(0, 1))
    far = max(float(np.sqrt(np.nanmean(_size(at) ** 2))) for at in moved)
    if np.any(away > (high - low) * (0.5 + 5 / n)) or size <= 0 or n * far < _WIDELY * size:
        return
    raise InputError(
        f"{where}: positions look wrapped at the edges of a box: they stay within {low} to {high} "
        f"though tracers move by {far:.4g}; write unwrapped positions or displacements, or (in a "
        "file that has the box) frames so often that no tracer moves by half of it in between"
    )


def _grouped(tracks: Tracks, names: tuple[str, ...], asked: Asked) -> tuple[Sample, list[str]]:
    """The sums over configurations where there are several, else over tracers."""
    by_tracer = "row" if tracks.tracer is None else "tracer"
    n = tracks.place.shape[1]
    if n < 2:
        raise InputError(f"{', '.join(names)}: has {n or 'no'} tracer; at least two are needed")
    sample, warnings = None, list[str]()
    if tracks.medium is not None:
        sample = reduced(tracks, tracks.medium, names, "medium", asked.with_field)
    if sample is None or sample.groups < 2:  # one configuration shows no spread between several
        warnings.append(
            "Configurations are unknown (no column medium): errors are by tracer. Tracers that "
            "share scatterers are not independent, and their errors are larger than these."
            if sample is None
            else "There is one configuration: errors are by tracer, and do not hold what another "
            "configuration of scatterers would change."
        )
        label = np.arange(n) if tracks.tracer is None else tracks.tracer
        sample = reduced(tracks, label, names, by_tracer, asked.with_field)
        if sample.groups < 2:
            raise InputError(f"{', '.join(names)}: has one tracer; at least two are needed")
    if sample.grouping == "row":
        warnings.append(
            "Tracers are unknown (no column tracer): the k-th row of each time is taken for the "
            "same tracer. If it is not, p-values over several times are wrong."
        )
    most, last = int(sample.samples.max()), int(np.argmin(sample.samples))
    if sample.samples[last] < most:
        warnings.append(
            f"At t = {numeral(sample.times[last], '.4g')} (in the data's unit), "
            f"{most - sample.samples[last]} of {most} tracers are missing. If the reason depends "
            "on their speed (a cap on collisions, a box that fast ones leave), those that survive "
            "are not a fair sample."
        )
    return sample, warnings


def _scaled(sample: Sample, asked: Asked, units: Mapping[str, str]) -> Sample:
    """The sample in d, U and d/U. Units that the file states are used, or at least said."""
    warnings, start, unit = sample.warnings, sample.start, asked.speed_unit
    if isinstance(unit, str):
        if start is None or not start.squares.size:
            lost = "there are none" if start is None else "all are zero"
            raise InputError(f"speed_unit: 'data' needs velocities at time 0, and {lost}")
        mean = start.squares @ start.counts / start.counts.sum()
        unit = float(np.sqrt(mean / sample.law.dimension))
        warnings += (f"U is {unit:.6g} of the data's unit, from <v²> at time 0.",)
    factor, time_unit = conversion(units), asked.time_unit
    if time_unit is None and factor not in (None, 1.0):
        time_unit = asked.diameter / unit * factor
    if units and not (are_own(units) and asked.diameter == unit == 1.0):
        known = "" if factor else " Not all of these are known here, and nothing was converted."
        taken = (asked.diameter, unit, time_unit or asked.diameter / unit)
        d, u, t = (numeral(value, ".6g") for value in taken)
        warnings += (
            f"The file states {', '.join(f'{kind}s in {one}' for kind, one in units.items())}."
            f"{known} Taken were d = {d}, U = {u} and d/U = {t} in the data's units; other values "
            "are given by --length-unit, --speed-unit and --time-unit.",
        )
    found = replace(sample.rescaled(unit, asked.diameter, time_unit), warnings=warnings)
    slowest = 1.0 if start is None else float(found.speed_scale[0])
    largest = max(float(found.speed_scale.max()), float(found.length_scale.max()), 1 / slowest)
    if largest > _LARGEST:
        raise InputError(
            f"{', '.join(sample.names)}: speeds of {found.speed_scale[0]:.3g} U and displacements "
            f"of up to {found.length_scale.max():.3g} d; give --speed-unit and --diameter"
        )
    return found
