"""Files of particle data as one sample: how positions are meant, and what makes a group."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from kinetics.crosscheck.comparison.data import averages
from kinetics.crosscheck.comparison.data.columns import (
    LABELS,
    Asked,
    Averages,
    Rows,
    Table,
    named,
    read_rows,
    shown,
)
from kinetics.crosscheck.comparison.data.ensemble_files import is_ensemble, read_ensemble
from kinetics.crosscheck.comparison.data.labels import MOST_ORIGINS, Origins
from kinetics.crosscheck.comparison.data.stated_units import are_own, conversion
from kinetics.crosscheck.comparison.data.unwrapping import TooLong, Unwrapping
from kinetics.crosscheck.comparison.reduction import SAME_TIME, Reduction
from kinetics.crosscheck.comparison.result import said
from kinetics.crosscheck.comparison.sample import Law, Sample
from kinetics.errors import InputError

_LARGEST = 1e70
"""Speeds and displacements in U and d, at most, and 1/speeds at the start: their fourth powers are
within the range of doubles."""


def read_sample(paths: Sequence[Path | Table], show_progress: bool = False, **told: Any) -> Sample:
    """One sample from files of columns (see `columns.FORMATS`), or from one file of an Ensemble.

    told : what the user says about the data, the arguments of `columns.Asked`
    show_progress : count the rows that have been read, on a terminal

    Lengths, speeds and times of an Ensemble file are known, and what is told is not looked at.
    Several files are independent runs: a label in one is not the same label in another. With one
    configuration, or without the column `medium`, standard errors are by tracer, and the
    sample's warnings say so. The files are only read. InputError for what cannot be used.
    """
    if not paths:
        raise InputError("data: got no file; at least one is needed")
    asked = Asked(**told)
    if ensembles := [path for path in paths if isinstance(path, Path) and is_ensemble(path)]:
        if len(paths) > 1:
            raise InputError(f"{shown(ensembles[0])}: an Ensemble file must be the only file")
        return read_ensemble(ensembles[0])
    files = _Files(paths, asked, show_progress)
    return _in_range(_scaled(files.sample(), asked, files.units))


class _Files:
    """Files of columns, read as often as it takes to know what their positions and groups are."""

    def __init__(self, paths: Sequence[Path | Table], asked: Asked, show_progress: bool) -> None:
        self._paths, self._asked, self._show_progress = paths, asked, show_progress
        self._names = tuple(shown(path.name) for path in paths)
        self._labels: frozenset[str] = frozenset()
        self._unwraps = True
        self.units: Mapping[str, str] = {}

    def _pieces(self) -> Iterator[tuple[int, Rows | Averages]]:
        """The pieces of all files, with the number of the file, which all have the same labels."""
        from tqdm import tqdm

        hidden = None if self._show_progress else True  # None: shown on a terminal
        bar = tqdm(disable=hidden, leave=False, unit=" rows", unit_scale=True)
        for number, path in enumerate(self._paths):
            count = 0
            for rows in read_rows(path, self._asked):
                found = frozenset(name for name in LABELS if getattr(rows, name, None) is not None)
                units = rows.units or {}
                if number == count == 0:
                    self._labels, self.units = found, units
                elif found != self._labels:
                    odd = ", ".join(sorted(found ^ self._labels))
                    raise InputError(f"{named(path)}: column {odd} must be in all files or in none")
                elif units != self.units:
                    raise InputError(f"{named(path)}: states other units than what was read before")
                count += rows.time.size
                bar.update(rows.time.size)
                yield number, rows
            if not count:
                raise InputError(f"{named(path)}: has no rows; at least two tracers are needed")
        bar.close()

    def _rows(self) -> Iterator[tuple[int, Rows]]:
        for number, rows in self._pieces():
            if not isinstance(rows, Rows):
                raise InputError(f"{named(self._paths[number])}: is a table of averages, not rows")
            yield number, rows

    def sample(self) -> Sample:
        """The sample, in the units of the data."""
        first = next(self._pieces(), None)
        if first is not None and isinstance(first[1], Averages):
            return self._table()
        self._check_once()
        by_tracer = "tracer" if "tracer" in self._labels else "row"
        grouping = "medium" if "medium" in self._labels else by_tracer
        positions = self._asked.positions
        origins = self._origins() if positions == "absolute" else None
        warnings: list[str] = []
        while True:
            reduction, crossed = self._reduced(grouping, origins)
            if positions == "auto" and origins is None and reduction.moved_at_zero:
                origins = self._origins()
                warnings.append(said("origins"))
                continue
            sample = reduction.sample(self._names)
            if sample.groups >= 2 or grouping == by_tracer:
                break
            grouping = by_tracer  # one configuration shows no spread between configurations
        if crossed:
            warnings.append(said("unwrapped"))
        if sample.groups < 2:
            raise InputError(f"{', '.join(self._names)}: has one tracer; at least two are needed")
        if grouping == by_tracer:
            known = "medium" in self._labels
            warnings.append(said("one_configuration" if known else "unknown_configurations"))
        if grouping == "row":
            warnings.append(said("unknown_tracers"))
        most, last = int(sample.samples.max()), int(np.argmin(sample.samples))
        if sample.samples[last] < most:
            count = most - int(sample.samples[last])
            warnings.append(said("survivors", count=count, most=most, time=sample.times[last]))
        law = Law(dimension=self._asked.dimension or 2)
        return replace(sample, law=law, warnings=sample.warnings + tuple(warnings))

    def _check_once(self) -> None:
        for k, path in enumerate(self._paths):
            if isinstance(path, Path) and path in self._paths[:k]:
                why = "its tracers would be taken for independent ones"
                raise InputError(f"{shown(path)}: stands twice; {why}")

    def _table(self) -> Sample:
        """The sample of a table of averages."""
        if len(self._paths) > 1:
            raise InputError(f"{', '.join(self._names)}: a table of averages must be the only file")
        if self._asked.with_field:
            raise InputError(f"{self._names[0]}: averages in a field are compared from rows alone")
        pieces = [piece for _, piece in self._pieces() if isinstance(piece, Averages)]
        return averages.sample_of(pieces, self._names, Law(dimension=self._asked.dimension or 2))

    def _reduced(self, grouping: str, origins: Origins | None) -> tuple[Reduction, bool]:
        """All rows, and whether positions had to be unwrapped."""
        asked = self._asked
        same_time = max(SAME_TIME, asked.bin_times or 0.0)
        reduction, unwrapping = Reduction(grouping, same_time, asked.with_field), Unwrapping()
        if origins is not None:
            origins.begin()
        for number, rows in self._rows():
            try:
                if self._unwraps and not asked.with_field:
                    rows = unwrapping.of(rows, number)
                if origins is not None:
                    rows = rows.at(np.stack(rows.position) - origins.of(rows, number))
                reduction.add(rows, number)
            except TooLong:
                self._unwraps = False
                return self._reduced(grouping, origins)
            except InputError as error:
                raise InputError(f"{named(self._paths[number])}: {error}") from None
        if origins is not None:
            try:
                origins.check_not_wrapped()
            except InputError as error:
                raise InputError(f"{', '.join(self._names)}: {error}") from None
        return reduction, unwrapping.crossed

    def _origins(self) -> Origins:
        where = ", ".join(self._names)
        allowed = "displacements relative to the place at time 0 need nothing"
        if "tracer" not in self._labels:
            raise InputError(
                f"{where}: positions at time 0 are not the origin, and without a column tracer "
                f"they cannot be subtracted; {allowed}"
            )
        pieces = []
        for number, rows in self._rows():
            zero = rows.time == 0
            if np.any(zero):
                pieces.append((rows.part(zero), number))
            if sum(rows.time.size for rows, _ in pieces) > MOST_ORIGINS:
                raise InputError(
                    f"{where}: more than {MOST_ORIGINS} tracers with absolute positions; "
                    "give displacements"
                )
        if not pieces:
            raise InputError(f"{where}: absolute positions need rows at time 0; {allowed}")
        return Origins(pieces)


def _in_range(sample: Sample) -> Sample:
    """The sample; InputError where fourth powers would overflow, or a start vanish."""
    start = 1.0 if sample.start is None else float(sample.speed_scale[0])
    largest = max(float(sample.speed_scale.max()), float(sample.length_scale.max()), 1 / start)
    if largest > _LARGEST:
        raise InputError(
            f"{', '.join(sample.names)}: speeds of {sample.speed_scale[0]:.3g} U and displacements "
            f"of up to {sample.length_scale.max():.3g} d; give --speed-unit and --diameter"
        )
    return sample


def _scaled(sample: Sample, asked: Asked, units: Mapping[str, str]) -> Sample:
    """The sample in d, U and d/U. Units that the file states are used, or at least said."""
    warnings, start, speed_unit = sample.warnings, sample.start, asked.speed_unit
    if isinstance(speed_unit, str):
        if start is None:
            raise InputError("speed_unit: 'data' needs velocities at time 0; give U as a number")
        if not start.squares.size:
            raise InputError(
                "speed_unit: all speeds at time 0 are zero; there is nothing to scale by"
            )
        mean = start.squares @ start.counts / start.counts.sum()
        speed_unit = float(np.sqrt(mean / sample.law.dimension))
        warnings += (f"U is {speed_unit:.6g} of the data's unit, from <v²> at time 0.",)
    factor, time_unit = conversion(units), asked.time_unit
    if time_unit is None and factor not in (None, 1.0):
        time_unit = asked.diameter / speed_unit * factor
    plain = are_own(units) and asked.diameter == speed_unit == 1.0
    if units and not plain:
        warnings += (
            said("stated_units", units=units, known=factor is not None, diameter=asked.diameter,
                 speed=speed_unit, time=time_unit or asked.diameter / speed_unit),
        )  # fmt: skip
    return replace(sample.rescaled(speed_unit, asked.diameter, time_unit), warnings=warnings)
