"""Files and tables as one sample: how positions are meant, what makes a group, which units."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from kinetics.crosscheck.data.formats import read
from kinetics.crosscheck.data.sample import Law, Sample, reduced, size_of
from kinetics.crosscheck.data.tracks import Asked, Rows, Tracks, bad, dense, name_of
from kinetics.crosscheck.words import numeral

OWN = {"length": ("d",), "speed": ("u",), "time": ("d/u", "d u-1", "u-1 d")}  # of this package
_SPEED = re.compile(r"([^\W\d]+)\s*(?:/\s*([^\W\d]+)|[\s*·.]\s*([^\W\d]+)\s*\^?-1)")


def read_sample(sources: Sequence[Path | Mapping[str, Any]], **told: Any) -> Sample:
    """One sample from files or columns in memory (see `formats`), or from one file of an Ensemble.

    told : arguments of `tracks.Asked`. Several files are independent runs: a label in one is not
    the same label in another. With one configuration, or without the column `medium`, standard
    errors are by tracer, and the sample's warnings say so. InputError for what cannot be used.
    """
    asked, names = Asked(**told), [name_of(source) for source in sources]
    if not names:
        bad("data", "no file", "one at least")
    paths = [source for source in sources if isinstance(source, Path)]
    if len({*paths}) < len(paths):
        bad("data", f"a file twice in {', '.join(names)}", "files of independent tracers")
    parts: list[Rows] = []
    for source, name in zip(sources, names, strict=True):
        part = read(source, asked)
        if isinstance(part, Sample):
            if len(sources) > 1:
                bad(name, "an Ensemble of several", "the only file")
            return part
        parts.append(part)
    names = [name.rsplit("/", 1)[-1] for name in names]
    tracks, warnings = _displacements(dense(parts, names, asked), ", ".join(names), asked)
    sample, more = _grouped(tracks, tuple(names), asked)
    if asked.bin_times:
        warnings.insert(
            0,
            f"Times within {asked.bin_times:.3g} of each other are one time, at their mean: "
            f"{tracks.times.size} times. Whether units belong together is not tested.",
        )
    # tracers of one flight share |r|/(|v| t) only at their own times
    flights = () if asked.bin_times else sample.flights
    law = Law(dimension=asked.dimension or 2)
    sample = replace(sample, law=law, flights=flights, warnings=(*warnings, *more))
    return _scaled(sample, asked, tracks.units)


def _displacements(tracks: Tracks, where: str, asked: Asked) -> tuple[Tracks, list[str]]:
    """The tracers relative to their places at time 0, and what is to be said of it."""
    place, first = tracks.place, tracks.times[0]

    def spread(places: Any) -> list[float]:  # root mean squares, at each time
        with np.errstate(over="ignore", under="ignore"):
            return [float(np.sqrt(np.nanmean(size_of(at) ** 2))) for at in places]

    size = spread(place)
    moved = first == 0 and size[0] > 1e-9 * max(size)
    if asked.positions == "displacement" or (asked.positions == "auto" and not moved):
        return tracks, []
    if tracks.tracer is None or first != 0:
        bad(f"{where}: positions", "absolute", "with a column tracer and rows at time 0")
    for tracer in tracks.tracer[np.isnan(place[0, :, 0])]:
        bad(f"{where}: tracer {tracer}", "no row at time 0", "there, for absolute positions")
    tracks = replace(tracks, place=place - place[0])
    # wrapped where none leaves the region of time 0, and twenty would, if not wrapped
    low, high = place[0].min(axis=0), place[0].max(axis=0)
    n, far, least = place.shape[1], max(spread(tracks.place)), float((high - low).min())
    # the farthest tracer is not quite at the edge of the region that they come from
    away = np.nanmax(np.abs(place - (low + high) / 2), axis=(0, 1))
    if np.all(away <= (high - low) * (0.5 + 5 / n)) and n * far >= 20 * least > 0:
        got = f"some that look wrapped in a box, within {low} to {high}, for moves of {far:.4g}"
        bad(f"{where}: positions", got, "unwrapped")
    said = (
        "Positions at time 0 are not the origin: each tracer's own place at time 0 was "
        "subtracted from its positions."
    )
    return tracks, [said] if asked.positions == "auto" else []


def _grouped(tracks: Tracks, names: tuple[str, ...], asked: Asked) -> tuple[Sample, list[str]]:
    """The sums over configurations where there are several, else over tracers."""
    n, warnings = tracks.place.shape[1], list[str]()
    labels: Any = [] if tracks.medium is None else pd.factorize(tracks.medium, sort=True)[0]
    by = "medium"
    if np.unique(labels).size < 2:  # one configuration shows no spread between several
        warnings.append(
            "Configurations are unknown (no column medium): errors are by tracer. Tracers that "
            "share scatterers are not independent, and their errors are larger than these."
            if tracks.medium is None
            else "There is one configuration: errors are by tracer, and do not hold what another "
            "configuration of scatterers would change."
        )
        labels, by = np.arange(n), "row"
        if tracks.tracer is not None:
            labels, by = pd.factorize(tracks.tracer, sort=True)[0], "tracer"
    sample = reduced(tracks, labels, names, by, asked.with_field)
    if sample.groups < 2:
        bad(", ".join(names), "one tracer" if n else "no tracer", "two tracers at least")
    if by == "row":
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
    where, said = ", ".join(sample.names), ", ".join(f"{k}s in {one}" for k, one in units.items())
    if isinstance(unit, str):
        if start is None or not start.squares.size:
            bad("speed_unit", "'data'", "a number where no tracer moves at time 0")
        with np.errstate(over="ignore"):
            mean = start.squares @ start.counts / start.counts.sum()
        unit = float(np.sqrt(mean / sample.law.dimension))
        if not 0.0 < unit < np.inf:
            bad("speed_unit", "'data'", "a number where <v²> at time 0 is beyond double precision")
        warnings += (f"U is {unit:.6g} of the data's unit, from <v²> at time 0.",)
    plain = {kind: one.strip().lower() for kind, one in units.items()}
    own = all(one in OWN[kind] for kind, one in plain.items())
    if asked.time_unit is None and not own and len(plain) == 3:  # mm, m/s and s?
        one = _SPEED.fullmatch(plain["speed"])
        if one and (one[1], one[2] or one[3]) != (plain["length"], plain["time"]):
            bad(where, said, "units that belong together, or say --time-unit")
    time = asked.diameter / unit if asked.time_unit is None else asked.time_unit
    sizes = {"speed": unit, "length": asked.diameter, "time": time}
    if units and not (own and asked.diameter == unit == 1.0):
        u, d, t = (numeral(value, ".6g") for value in sizes.values())
        warnings += (
            f"The file states {said}. Taken were d = {d}, U = {u} and d/U = {t} in the data's "
            "units; other values are given by --length-unit, --speed-unit and --time-unit.",
        )
    told = units or any(size != 1.0 for size in sizes.values())
    scales = {k: (size, units.get(k, "")) for k, size in sizes.items()} if told else {}
    found = sample.rescaled(unit, asked.diameter, time)
    speed, length = float(found.speed_scale.max()), float(found.length_scale.max())
    largest = 1e70  # of speeds and displacements, and 1/speeds: fourth powers are doubles
    if max(speed, length, 0 if start is None else 1 / float(found.speed_scale[0])) > largest:
        got = f"speeds of {speed:.3g} U and displacements of {length:.3g} d"
        bad(where, got, f"below {largest:g}; give --speed-unit and --diameter")
    return replace(found, warnings=warnings, units=scales)
