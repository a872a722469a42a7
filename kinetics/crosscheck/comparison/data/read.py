"""Files of particle data as one sample: how positions are meant, and what makes a group."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from kinetics.crosscheck.comparison.data.columns import (
    LABELS,
    Asked,
    Rows,
    Table,
    checked_columns,
    read_rows,
    shown,
)
from kinetics.crosscheck.comparison.data.ensemble_files import is_ensemble, read_ensemble
from kinetics.crosscheck.comparison.data.labels import MOST_ORIGINS, Origins
from kinetics.crosscheck.comparison.reduction import Reduction
from kinetics.crosscheck.comparison.result import said
from kinetics.crosscheck.comparison.sample import Sample
from kinetics.errors import InputError
from kinetics.validation import check_positive, one_of

POSITIONS = ("auto", "displacement", "absolute")
_LARGEST = 1e70
"""Speeds and displacements in U and d, at most, and 1/speeds at the start: their fourth powers are
within the range of doubles."""


def read_sample(
    paths: Sequence[Path | Table],
    positions: str = "auto",
    speed_unit: float | str = 1.0,
    diameter: float = 1.0,
    show_progress: bool = False,
    time_unit: float | None = None,
    columns: Mapping[str, str] | None = None,
    timestep: float | None = None,
) -> Sample:
    """One sample from files of columns (see `columns.FORMATS`), or from one file of an Ensemble.

    positions : "displacement": x, y are relative to the tracer's place at time 0. "absolute":
        they are places, from which the tracer's own place at time 0 is subtracted; needs a column
        `tracer` and rows at time 0. "auto": absolute if a position at time 0 is not the origin.
    speed_unit : U in the data's unit of speed; "data": from <v^2> = 2 U^2 at time 0
    diameter : d in the data's unit of length
    time_unit : d/U in the data's unit of time; None: diameter/speed_unit
    columns : names of columns in the files by ours, {"time": "t_sim"}; see columns.ALIASES
    timestep : the time of one step, for formats whose frames give steps
    show_progress : count the rows that have been read, on a terminal

    Lengths, speeds and times of an Ensemble file are known, and these three are not looked at.
    Several files are independent runs: a label in one is not the same label in another. With one
    configuration, or without the column `medium`, standard errors are by tracer, and the
    sample's warnings say so. The files are only read. InputError for what cannot be used.
    """
    if not paths:
        raise InputError("data: got no file; at least one is needed")
    one_of("positions", positions, POSITIONS)
    diameter = check_positive("diameter", diameter)
    if not (isinstance(speed_unit, str) and speed_unit == "data"):
        speed_unit = check_positive("speed_unit", speed_unit)
    if time_unit is not None:
        time_unit = check_positive("time_unit", time_unit)
    if timestep is not None:
        timestep = check_positive("timestep", timestep)
    asked = Asked(checked_columns(columns or {}), timestep)
    if ensembles := [path for path in paths if isinstance(path, Path) and is_ensemble(path)]:
        if len(paths) > 1:
            raise InputError(f"{shown(ensembles[0])}: an Ensemble file must be the only file")
        return read_ensemble(ensembles[0])
    sample = _Files(paths, asked, show_progress).sample(positions)
    return _in_range(_scaled(sample, speed_unit, diameter, time_unit))


class _Files:
    """Files of columns, read as often as it takes to know what their positions and groups are."""

    def __init__(self, paths: Sequence[Path | Table], asked: Asked, show_progress: bool) -> None:
        self._paths, self._asked, self._show_progress = paths, asked, show_progress
        self._names = tuple(shown(path.name) for path in paths)
        self._labels: frozenset[str] = frozenset()

    def _rows(self) -> Iterator[tuple[int, Rows]]:
        """The rows of all files, with the number of the file; every file has the same labels."""
        from tqdm import tqdm

        hidden = None if self._show_progress else True  # None: shown on a terminal
        bar = tqdm(disable=hidden, leave=False, unit=" rows", unit_scale=True)
        for number, path in enumerate(self._paths):
            count = 0
            for rows in read_rows(path, self._asked):
                found = frozenset(name for name in LABELS if getattr(rows, name) is not None)
                if number == count == 0:
                    self._labels = found
                elif found != self._labels:
                    odd = ", ".join(sorted(found ^ self._labels))
                    raise InputError(
                        f"{_where(path)}: column {odd} must be in all files or in none"
                    )
                count += rows.time.size
                bar.update(rows.time.size)
                yield number, rows
            if not count:
                raise InputError(f"{_where(path)}: has no rows; at least two tracers are needed")
        bar.close()

    def sample(self, positions: str) -> Sample:
        """The sample; positions as in read_sample."""
        next(self._rows(), None)
        by_tracer = "tracer" if "tracer" in self._labels else "row"
        grouping = "medium" if "medium" in self._labels else by_tracer
        origins = self._origins() if positions == "absolute" else None
        warnings: list[str] = []
        while True:
            reduction = self._reduced(grouping, origins)
            if positions == "auto" and origins is None and reduction.moved_at_zero:
                origins = self._origins()
                warnings.append(said("origins"))
                continue
            sample = reduction.sample(self._names)
            if sample.groups >= 2 or grouping == by_tracer:
                break
            grouping = by_tracer  # one configuration shows no spread between configurations
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
        return replace(sample, warnings=tuple(warnings))

    def _reduced(self, grouping: str, origins: Origins | None) -> Reduction:
        reduction = Reduction(grouping)
        for number, rows in self._rows():
            try:
                if origins is not None:
                    x, y = origins.of(rows, number)
                    rows = replace(rows, x=rows.x - x, y=rows.y - y)
                reduction.add(rows, number)
            except InputError as error:
                raise InputError(f"{_where(self._paths[number])}: {error}") from None
        if origins is not None:
            try:
                origins.check_not_wrapped()
            except InputError as error:
                raise InputError(f"{', '.join(self._names)}: {error}") from None
        return reduction

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
                parts = {k: v[zero] for k, v in vars(rows).items() if v is not None}
                pieces.append((Rows(**parts), number))
            if sum(rows.time.size for rows, _ in pieces) > MOST_ORIGINS:
                raise InputError(
                    f"{where}: more than {MOST_ORIGINS} tracers with absolute positions; "
                    "give displacements"
                )
        if not pieces:
            raise InputError(f"{where}: absolute positions need rows at time 0; {allowed}")
        return Origins(pieces)


def _where(path: Path | Table) -> str:
    return path.name if isinstance(path, Table) else shown(path)


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


def _scaled(
    sample: Sample, speed_unit: float | str, diameter: float, time_unit: float | None
) -> Sample:
    warnings, start = sample.warnings, sample.start
    if speed_unit == "data":
        if start is None:
            raise InputError("speed_unit: 'data' needs velocities at time 0; give U as a number")
        if not start.squares.size:
            raise InputError(
                "speed_unit: all speeds at time 0 are zero; there is nothing to scale by"
            )
        speed_unit = float(np.sqrt(start.squares @ start.counts / start.counts.sum() / 2))
        warnings += (f"U is {speed_unit:.6g} of the data's unit, from <v²> at time 0.",)
    return replace(sample.rescaled(float(speed_unit), diameter, time_unit), warnings=warnings)
