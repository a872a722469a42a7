"""Files and tables as one sample: how positions are meant, what makes a group, which units."""

import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from kinetics.crosscheck.data.formats import read
from kinetics.crosscheck.data.sample import Law, Sample, reduced, size_of_vectors
from kinetics.crosscheck.data.tracks import Asked, Table, Tracks, bad, joined, name_of
from kinetics.crosscheck.data.units import are_mixed, are_own
from kinetics.crosscheck.words import numeral


def read_sample(
    sources: Sequence[Path | Table], show_progress: bool = False, **told: Any
) -> Sample:
    """One sample from files or columns in memory (see `formats`), or from one file of an Ensemble.

    told : arguments of `tracks.Asked`. Several files are independent runs: a label in one is not
    the same label in another. With one configuration, or without the column `medium`, standard
    errors are by tracer, and the sample's warnings say so. InputError for what cannot be used.
    """
    asked, names = Asked(**told), tuple(name_of(source) for source in sources)
    if not sources:
        bad("data", "no file", "one at least")
    if any(isinstance(one, Path) and one in sources[:k] for k, one in enumerate(sources)):
        bad("data", f"a file twice in {', '.join(names)}", "files of independent tracers")
    where = ", ".join(name.rsplit("/", 1)[-1] for name in names)
    parts: list[Any] = []
    for k, source in enumerate(sources, 1):
        if show_progress and len(sources) > 1 and sys.stderr.isatty():
            print(f"file {k} of {len(sources)}", end="\r", file=sys.stderr)
        parts.append(read(source, asked))
        if len(sources) > 1 and not isinstance(parts[-1], Tracks):
            bad(names[k - 1], "an Ensemble of several", "the only file")
    names, law = tuple(where.split(", ")), Law(dimension=asked.dimension or 2)
    if isinstance(parts[0], Sample):
        return parts[0]
    tracks, warnings = _displacements(parts, names, asked)
    sample, more = _grouped(tracks, names, asked)
    # tracers of one flight share |r|/(|v| t) only at their own times
    flights = () if asked.bin_times else sample.flights
    sample = replace(sample, law=law, flights=flights, warnings=(*warnings, *more))
    return _scaled(sample, asked, tracks.units)


def _displacements(
    parts: Sequence[Tracks], names: Sequence[str], asked: Asked
) -> tuple[Tracks, list[str]]:
    """The tracers of all files relative to their places at time 0, and what is to be said of it."""
    where, warnings = ", ".join(names), list[str]()
    tracks = joined(parts, names, asked)
    if asked.bin_times:
        warnings.append(
            f"Times within {asked.bin_times:.3g} of each other are one time, at their mean: "
            f"{tracks.times.size} times. Whether units belong together is not tested."
        )
    place, size = tracks.place, _sizes(tracks.place)
    moved = tracks.times[0] == 0 and size[0] > 1e-9 * max(size)
    if asked.positions == "absolute" or (asked.positions == "auto" and moved):
        if tracks.tracer is None or tracks.times[0] != 0:
            bad(f"{where}: positions", "absolute", "with a column tracer and rows at time 0")
        for tracer in tracks.tracer[np.isnan(place[0, :, 0])]:
            bad(f"{where}: tracer {tracer}", "no row at time 0", "there, for absolute positions")
        tracks = replace(tracks, place=place - place[0])
        _require_not_wrapped(where, place, max(_sizes(tracks.place)))
        if asked.positions == "auto":
            warnings.append(
                "Positions at time 0 are not the origin: each tracer's own place at time 0 was "
                "subtracted from its positions."
            )
    return tracks, warnings


def _sizes(place: Any) -> list[float]:
    """Root mean squares of the length of vectors, at each time."""
    with np.errstate(over="ignore", under="ignore"):
        return [float(np.sqrt(np.nanmean(size_of_vectors(at) ** 2))) for at in place]


def _require_not_wrapped(where: str, place: Any, far: float) -> None:
    """InputError where none leaves the region of time 0, and twenty would, if not wrapped."""
    low, high = place[0].min(axis=0), place[0].max(axis=0)
    n, size = place.shape[1], float((high - low).min())
    # The farthest tracer is not quite at the edge of the region that they come from.
    away = np.nanmax(np.abs(place - (low + high) / 2), axis=(0, 1))
    if np.all(away <= (high - low) * (0.5 + 5 / n)) and n * far >= 20 * size > 0:
        got = f"some that look wrapped in a box, within {low} to {high}, for moves of {far:.4g}"
        bad(f"{where}: positions", got, "unwrapped")


def _grouped(tracks: Tracks, names: tuple[str, ...], asked: Asked) -> tuple[Sample, list[str]]:
    """The sums over configurations where there are several, else over tracers."""
    n, sample, warnings = tracks.place.shape[1], None, list[str]()
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
        label, by = (np.arange(n), "row") if tracks.tracer is None else (tracks.tracer, "tracer")
        sample = reduced(tracks, label, names, by, asked.with_field)
    if sample.groups < 2:
        bad(", ".join(names), "one tracer" if n else "no tracer", "two tracers at least")
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
            bad("speed_unit", "'data'", "a number where no tracer moves at time 0")
        with np.errstate(over="ignore"):
            mean = start.squares @ start.counts / start.counts.sum()
        unit = float(np.sqrt(mean / sample.law.dimension))
        if not 0.0 < unit < np.inf:
            bad("speed_unit", "'data'", "a number where <v²> at time 0 is beyond double precision")
        warnings += (f"U is {unit:.6g} of the data's unit, from <v²> at time 0.",)
    time_unit = asked.time_unit
    if time_unit is None:
        said = ", ".join(f"{kind}s in {one}" for kind, one in units.items())
        if are_mixed(units):
            bad(", ".join(sample.names), said, "units that belong together, or say --time-unit")
        time_unit = asked.diameter / unit
    sizes = {"speed": unit, "length": asked.diameter, "time": time_unit}
    if units and not (are_own(units) and asked.diameter == unit == 1.0):
        u, d, t = (numeral(value, ".6g") for value in sizes.values())
        warnings += (
            f"The file states {', '.join(f'{kind}s in {one}' for kind, one in units.items())}."
            f" Taken were d = {d}, U = {u} and d/U = {t} in the data's units; other values "
            "are given by --length-unit, --speed-unit and --time-unit.",
        )
    own = {k: (size, units.get(k, "")) for k, size in sizes.items()}
    if not units and all(size == 1.0 for size in sizes.values()):
        own = {}
    found = sample.rescaled(unit, asked.diameter, time_unit)
    found = replace(found, warnings=warnings, units=own)
    speed, length = float(found.speed_scale.max()), float(found.length_scale.max())
    largest = 1e70  # of speeds and displacements, and 1/speeds: fourth powers are doubles
    if max(speed, length, 0 if start is None else 1 / float(found.speed_scale[0])) > largest:
        got = f"speeds of {speed:.3g} U and displacements of {length:.3g} d"
        bad(", ".join(sample.names), got, f"below {largest:g}; give --speed-unit and --diameter")
    return found
