"""Tracks: tracers at common times, and their displacements from the start.

`gather` makes tracks of tables; `displacements` tells whether places are absolute, and when a
tracer starts.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from kinetics.crosscheck.data.arrays import Column, Flags, Floats, Integers, lengths_of
from kinetics.crosscheck.data.options import DataOptions, refuse_data

#: Largest time, speed and displacement, in d/U, U and d: fourth powers of these are doubles.
MAX_SIZE = 1e70
#: Mean squares of displacements at time 0, over the largest, that are rounding.
ROUNDING_OF_PLACE = 1e-18
#: Places at a first time t0 above 0 count as absolute if the median distance from the origin is
#: more than this times the largest speed at t0 times t0. The speed was higher before, but a tracer
#: that cools as 1/t has gone less than v t0 times the root of ln t0: a displacement is below.
FURTHER_THAN_SPEED = 2.0
#: A first time of more than so many times the duration is a time stamp: tracers start there.
TIME_STAMP_OVER_DURATION = 1e3
#: Wrapped positions are looked for where so many tracers would leave the region of the start.
MIN_LEAVING = 20
#: So many tracers, of all, may lie beyond half the region: it is drawn by the tracers themselves.
EDGE_TRACERS = 10


@dataclass(frozen=True)
class Tracks:
    """Tracers at common times, in d, U and d/U; NaN where a number is missing.

    Parameters
    ----------
    times : rising, shape (n_times,)
    place : shape (n_times, n, d)
    velocity : the same shape; None where there are no velocities
    tracer, medium : labels, shape (n,); None where they are unknown
    file : the number of the run of each tracer, shape (n,)
    remarks : what a reader should know of how they were made
    """

    times: Floats
    place: Floats
    velocity: Floats | None
    tracer: Column | None = None
    medium: Column | None = None
    file: Integers | int = 0
    remarks: tuple[str, ...] = ()

    @property
    def n_tracers(self) -> int:
        """The number of tracers."""
        return int(self.place.shape[1])

    def select_tracers(self, chosen: Flags) -> Tracks:
        """Return some of the tracers."""
        selected = replace(self, place=self.place[:, chosen])
        if self.velocity is not None:
            selected = replace(selected, velocity=self.velocity[:, chosen])
        if self.tracer is not None:
            selected = replace(selected, tracer=self.tracer[chosen])
        if self.medium is not None:
            selected = replace(selected, medium=self.medium[chosen])
        if not isinstance(self.file, int):
            selected = replace(selected, file=self.file[chosen])
        return selected


def displacements(tracks: Tracks, where: str, options: DataOptions) -> Tracks:
    """Return tracks whose places are displacements from time 0.

    Places that are so already are returned as they are; of others the first time is time 0.
    InputError for positions that are wrapped in a box.
    """
    if tracks.velocity is None:
        return _from_own_start(tracks, where, options)
    if not _are_absolute(tracks, options):
        return tracks
    if tracks.tracer is None:
        refuse_data(f"{where}: positions", "absolute", "with a column tracer")
    remarks = list(tracks.remarks)
    times = tracks.times
    if times[0] != 0:
        times = times - times[0]
        remarks.append(
            f"The first time is {tracks.times[0]:.4g} d/U: it is taken for the start, time 0."
        )
    has_start = np.isfinite(tracks.place[0, :, 0])
    n_late = int(np.count_nonzero(~has_start))
    if n_late == tracks.n_tracers:
        refuse_data(f"{where}: positions", "no tracer at the first time", "some")
    started = tracks.select_tracers(has_start)
    if n_late:
        remarks.append(f"{n_late} tracers that are not there at the first time are left out.")
    place = started.place - started.place[0]
    _check_not_wrapped(started, place, where)
    if options.positions == "auto":
        remarks.append("Each tracer's own place at time 0, not the origin, was subtracted.")
    has_tracers = np.any(np.isfinite(place[:, :, 0]), axis=1)
    assert started.velocity is not None
    return replace(
        started,
        times=times[has_tracers],
        place=place[has_tracers],
        velocity=started.velocity[has_tracers],
        remarks=tuple(remarks),
    )


def _from_own_start(tracks: Tracks, where: str, options: DataOptions) -> Tracks:
    """Return tracks without velocities: times from the first frame, places from each one's first.

    Displacements that are said to begin at time 0, where no frame is, get that frame.
    """
    if tracks.tracer is None:
        refuse_data(f"{where}: positions alone", "no column tracer", "with one")
    remarks = list(tracks.remarks)
    times = tracks.times
    place = tracks.place
    if options.positions == "displacement" and times[0] > 0:
        times = np.append(0.0, times)
        place = np.concatenate([np.zeros_like(place[:1]), place])
    if times.size < 2:
        refuse_data(f"{where}: positions alone", "one frame", "at two times at least")
    if times[0] != 0:
        remarks.append(f"The first frame is at {times[0]:.4g} d/U: it is taken for time 0.")
        times = times - times[0]
    is_there = np.isfinite(place[:, :, 0])
    n_late = int(np.count_nonzero(~is_there[0]))
    if n_late:
        remarks.append(
            f"{n_late} tracks begin after the first frame. One clock is taken for all: time 0 is "
            "the first frame."
        )
    first_frame = np.argmax(is_there, axis=0)
    first_place = place[first_frame, np.arange(tracks.n_tracers)]
    _check_not_wrapped(tracks, place - first_place, where)
    return replace(tracks, times=times, place=place - first_place, remarks=tuple(remarks))


def _are_absolute(tracks: Tracks, options: DataOptions) -> bool:
    """Return whether places are absolute, as is said, or as the first of them show."""
    if options.positions != "auto":
        return options.positions == "absolute"
    mean_square = np.nanmean(np.sum(tracks.place**2, axis=2), axis=1)
    if tracks.times[0] == 0 or tracks.velocity is None:
        return bool(mean_square[0] > ROUNDING_OF_PLACE * mean_square.max())
    if tracks.times[0] > TIME_STAMP_OVER_DURATION * (tracks.times[-1] - tracks.times[0]):
        return True
    top_speed = float(np.nanmax(lengths_of(tracks.velocity[0])))
    farthest = FURTHER_THAN_SPEED * top_speed * tracks.times[0]
    median_distance = float(np.nanmedian(lengths_of(tracks.place[0])))
    return median_distance > farthest


def _check_not_wrapped(tracks: Tracks, place: Floats, where: str) -> None:
    """Raise InputError where no tracer leaves the region of time 0, though many would.

    Of n tracers, about n times their root mean square displacement over the side would leave it.
    Where as many tracks end, the region is a picture, and those that leave it are not seen.
    """
    n = tracks.n_tracers
    n_ended = np.count_nonzero(np.isnan(tracks.place[-1, :, 0]))
    if n_ended >= MIN_LEAVING:
        return
    low = np.nanmin(tracks.place[0], axis=0)
    high = np.nanmax(tracks.place[0], axis=0)
    smallest_side = float((high - low).min())
    mean_square = np.nanmean(np.sum(place**2, axis=2), axis=1)
    distance = float(np.sqrt(np.nanmax(mean_square)))
    # the farthest tracer is not quite at the edge of the region that they come from
    from_middle = np.nanmax(np.abs(tracks.place - (low + high) / 2), axis=(0, 1))
    all_stay = np.all(from_middle <= (high - low) * (0.5 + EDGE_TRACERS / n))
    if all_stay and n * distance >= MIN_LEAVING * smallest_side > 0:
        region = f"within {low} to {high} d, moved by {distance:.4g} d"
        got = f"some that look wrapped in a box, {region}"
        refuse_data(f"{where}: positions", got, "unwrapped")
