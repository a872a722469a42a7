"""Read data: begin with `read_data`.

source -> `formats` -> table -> `gather` -> tracks -> displacements -> `sample`. A table of averages
is handed on as it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from kinetics.crosscheck.data.arrays import Source
from kinetics.crosscheck.data.averages import AveragesTable
from kinetics.crosscheck.data.copies import warnings_of_copies
from kinetics.crosscheck.data.ends import without_biased_ends
from kinetics.crosscheck.data.ensembles import sample_of_ensemble
from kinetics.crosscheck.data.formats import name_of, read_source
from kinetics.crosscheck.data.gather import gather_tracks
from kinetics.crosscheck.data.identity import MIN_SHARE_IN_ORDER, share_in_order
from kinetics.crosscheck.data.memory import MemoryBudget
from kinetics.crosscheck.data.motion import impossible_motion
from kinetics.crosscheck.data.options import DataOptions, refuse_data
from kinetics.crosscheck.data.sample import Law, Sample, reduce_tracks
from kinetics.crosscheck.data.table import Table
from kinetics.crosscheck.data.tracks import Tracks, displacements
from kinetics.crosscheck.words import numeral


def read_sample(sources: Sequence[Source], check_motion: bool = True, **arguments: Any) -> Sample:
    """Read one sample of tracks, as `read_data`; InputError for a table of averages."""
    data = read_data(sources, check_motion, **arguments)
    if isinstance(data, AveragesTable):
        refuse_data(name_of(sources[0]), "averages at times", "tracks of particles")
    return data


def read_data(
    sources: Sequence[Source], check_motion: bool = True, **arguments: Any
) -> Sample | AveragesTable:
    """Read one sample of tracks, or the table of averages that the only source is.

    Parameters
    ----------
    sources : files, or columns or arrays in memory; several are independent runs
    check_motion : whether nothing drives the tracers, so that none gets faster
    arguments : of :meth:`DataOptions.checked`

    Returns
    -------
    Sample or AveragesTable
        The warnings of a sample say what was left out, and what errors are from: with one
        configuration, or without the column `medium`, they are by tracer.
    """
    options = DataOptions.checked(**arguments)
    _check_sources(sources)
    tables: list[Table] = []
    budget = MemoryBudget("data")
    for source in sources:
        table = read_source(source, options)
        if isinstance(table, AveragesTable):
            if len(sources) > 1:
                refuse_data(name_of(source), "averages at times", "the only file")
            return table
        if not isinstance(table, Table):
            if len(sources) > 1:
                refuse_data(name_of(source), "an Ensemble of several", "the only file")
            return sample_of_ensemble(table, _file_name(source))
        tables.append(table)
        budget.take(float(sum(values.nbytes for values in table.columns.values())))
    names = tuple(_file_name(source) for source in sources)
    where = ", ".join(names)
    gathered = gather_tracks(tables, options)
    tracks = displacements(without_biased_ends(gathered), where, options)
    faults: list[str] = []  # what real tracks cannot do
    if _are_tracers_known(tracks, where) and check_motion:
        faults += impossible_motion(gathered, where, options.units)
    sample = _group(tracks, names, options)
    if _are_tracers_known(tracks, where):
        faults += warnings_of_copies(tracks)
    return replace(
        sample,
        law=Law(dimension=options.dimension or 2),
        units=options.units.by_name(),
        unit_names=_common_unit_names(tables),
        warnings=(*tracks.remarks, *sample.warnings, *faults),
    )


def _file_name(source: Source) -> str:
    """Return the name of a file without its folders; "data" for data in memory."""
    return name_of(source).rsplit("/", 1)[-1]


def _check_sources(sources: Sequence[Source]) -> None:
    """Raise InputError without any source, and for a file that is named twice."""
    paths = [source for source in sources if isinstance(source, Path)]
    allowed = "one file at least, of independent tracers"
    if not sources:
        refuse_data("data", "no file", allowed)
    if len(set(paths)) < len(paths):
        names = ", ".join(name_of(path) for path in paths)
        refuse_data("data", f"a file twice in {names}", allowed)


def _common_unit_names(tables: Sequence[Table]) -> dict[str, str]:
    """Return the names of the units on which all tables agree."""
    common = set(tables[0].unit_names.items())
    for table in tables[1:]:
        common &= set(table.unit_names.items())
    return dict(common)


def _are_tracers_known(tracks: Tracks, where: str) -> bool:
    """Return whether rows belong to tracers, by their labels or by their order.

    Without either, errors need several configurations, each with its averages at all times:
    InputError where there are none.
    """
    if tracks.tracer is not None or tracks.times.size < 2:
        return True
    share = share_in_order(tracks)
    if share is None or share >= MIN_SHARE_IN_ORDER:
        return True
    if tracks.medium is None or np.unique(tracks.medium).size < 2:
        rows = "no column tracer, and rows in another order at each time"
        refuse_data(where, rows, "with a label for each tracer (--columns tracer=...)")
    return False


def _group(tracks: Tracks, names: tuple[str, ...], options: DataOptions) -> Sample:
    """Return the sums over configurations where there are several, else over tracers."""
    warnings: list[str] = []
    label = np.arange(tracks.n_tracers)
    grouping = "row"
    if tracks.tracer is not None:
        label = pd.factorize(tracks.tracer, sort=True)[0]
        grouping = "tracer"
    if tracks.medium is not None:
        codes, different = pd.factorize(tracks.medium, sort=True)
        # one configuration alone shows no spread between them, and its tracers are the groups; with
        # several files those of one label are different ones
        if len(different) > 1 or np.max(tracks.file) > 0:
            label = codes
            grouping = "medium"
    if grouping != "medium":
        reason = "There is one configuration"
        if tracks.medium is None:
            reason = "No column medium"
        warnings.append(
            f"{reason}: errors are by tracer. Tracers that share scatterers are not independent: "
            "their errors are larger than these."
        )
    sample = reduce_tracks(tracks, label, names, grouping, options.with_axes)
    if sample.groups < 2:
        found = "one tracer" if tracks.n_tracers else "no tracer"
        refuse_data(", ".join(names), found, "two tracers at least")
    if grouping == "row":
        warnings.append(
            "No column tracer: the k-th row of each time is taken for the same tracer. If it is "
            "not, p-values over several times are wrong."
        )
    warnings += _missing_tracers(sample)
    return replace(sample, warnings=tuple(warnings))


def _missing_tracers(sample: Sample) -> list[str]:
    """Return what is to be said if tracers are missing at some times."""
    n_tracers = int(sample.samples.max())
    time_of_fewest = int(np.argmin(sample.samples))
    n_missing = n_tracers - int(sample.samples[time_of_fewest])
    if n_missing == 0:
        return []
    time = numeral(sample.times[time_of_fewest], ".4g")
    return [
        f"At t = {time} d/U, {n_missing} of {n_tracers} tracers are missing. If the reason depends "
        "on their speed (a cap on collisions, a box that fast ones leave), those that survive are "
        "not a fair sample."
    ]
