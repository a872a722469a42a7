"""Files and tables as one sample: how positions are meant, what makes a group, which units."""

import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from kinetics.crosscheck.data import summaries
from kinetics.crosscheck.data.formats import read
from kinetics.crosscheck.data.sample import Law, Sample, reduced, size_of_vectors
from kinetics.crosscheck.data.tracks import (
    Asked,
    Averages,
    Table,
    Tracks,
    joined,
    name_of,
    unwrapped,
)
from kinetics.crosscheck.data.units import are_own, conversion
from kinetics.crosscheck.words import numeral
from kinetics.errors import InputError

_ROUNDING = 1e-9
_LARGEST = 1e70
"""Speeds and displacements in U and d, and 1/speeds at the start: fourth powers are doubles."""
_WIDELY = 20.0
"""Tracers that must have left the region of time 0, were positions not wrapped: then that none
has is no chance."""


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
        size = [float(np.sqrt(np.nanmean(size_of_vectors(at) ** 2))) for at in place]
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
    far = max(float(np.sqrt(np.nanmean(size_of_vectors(at) ** 2))) for at in moved)
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
