"""Files and tables as one sample: which units, how positions are meant, what makes a group."""

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

LARGEST = 1e70  # of speeds and displacements: their fourth powers are doubles


def read_sample(sources: Sequence[Path | Mapping[str, Any]], **told: Any) -> Sample:
    """One sample from files or columns in memory (see `formats`), or from one file of an Ensemble.

    told : arguments of `tracks.Asked`. Several files are independent runs. With one configuration,
    or without the column `medium`, errors are by tracer, and the sample's warnings say so.
    """
    asked, names = Asked(**told), [name_of(source) for source in sources]
    paths = [source for source in sources if isinstance(source, Path)]
    if not names or len({*paths}) < len(paths):
        got = f"a file twice in {', '.join(names)}" if names else "no file"
        bad("data", got, "one file at least, of independent tracers")
    parts: list[Rows] = []
    for source, name in zip(sources, names, strict=True):
        part = read(source, asked)
        if isinstance(part, Sample):
            if len(sources) > 1:
                bad(name, "an Ensemble of several", "the only file")
            return part
        parts.append(part)
    names = [name.rsplit("/", 1)[-1] for name in names]
    where = ", ".join(names)
    tracks = _in_own_units(dense(parts, names, asked), where, asked)
    tracks, place = _displacements(tracks, where, asked)
    sample, groups = _grouped(tracks, tuple(names), asked)
    law, told = Law(dimension=asked.dimension or 2), asked.units
    units = {} if {*told.values()} == {1.0} else told
    return replace(sample, law=law, units=units, warnings=(*place, *groups))


def _in_own_units(tracks: Tracks, where: str, asked: Asked) -> Tracks:
    """Tracks in d, U and d/U."""
    units = asked.units
    if {*units.values()} != {1.0}:
        place, velocity = tracks.place / units["length"], tracks.velocity / units["speed"]
        times = tracks.times / units["time"]
        tracks = replace(tracks, place=place, velocity=velocity, times=times)
    far, fast = (np.nanmax(np.abs(one), initial=0.0) for one in (tracks.place, tracks.velocity))
    if max(far, fast) > LARGEST:
        got = f"speeds of {fast:.3g} U and displacements of {far:.3g} d"
        bad(where, got, f"below {LARGEST:g}; give --speed-unit and --diameter")
    return tracks


def _displacements(tracks: Tracks, where: str, asked: Asked) -> tuple[Tracks, list[str]]:
    """The tracers relative to their places at time 0, and what is to be said of it."""
    place, first = tracks.place, tracks.times[0]

    def spread(places: Any) -> list[float]:  # root mean squares, at each time
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
        got = f"some that look wrapped in a box, within {low} to {high} d, for moves of {far:.4g} d"
        bad(f"{where}: positions", got, "unwrapped")
    said = "Each tracer's own place at time 0, not the origin, was subtracted from its positions."
    return tracks, [said] if asked.positions == "auto" else []


def _grouped(tracks: Tracks, names: tuple[str, ...], asked: Asked) -> tuple[Sample, list[str]]:
    """The sums over configurations where there are several, else over tracers."""
    n, warnings = tracks.place.shape[1], list[str]()
    labels, by = np.arange(n), "row"
    if tracks.tracer is not None:
        labels, by = pd.factorize(tracks.tracer, sort=True)[0], "tracer"
    if tracks.medium is not None:
        codes, different = pd.factorize(tracks.medium, sort=True)
        if different.size > 1 or np.max(tracks.file) > 0:  # one alone shows no spread between them
            labels, by = codes, "medium"
    if by != "medium":
        known = "There is one configuration" if tracks.medium is not None else "No column medium"
        warnings.append(
            f"{known}: errors are by tracer. Tracers that share scatterers are not independent: "
            "their errors are larger than these."
        )
    sample = reduced(tracks, labels, names, by, asked.with_field)
    if sample.groups < 2:
        bad(", ".join(names), "one tracer" if n else "no tracer", "two tracers at least")
    if by == "row":
        warnings.append(
            "No column tracer: the k-th row of each time is taken for the same tracer. If it is "
            "not, p-values over several times are wrong."
        )
    most, last = int(sample.samples.max()), int(np.argmin(sample.samples))
    if sample.samples[last] < most:
        warnings.append(
            f"At t = {numeral(sample.times[last], '.4g')} d/U, {most - sample.samples[last]} of "
            f"{most} tracers are missing. If the reason depends on their speed (a cap on "
            "collisions, a box that fast ones leave), those that survive are not a fair sample."
        )
    return sample, warnings
