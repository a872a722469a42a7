"""Files of particle data as one sample: which rule reads the positions, and what makes a group."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from kinetics.crosscheck.comparison.data.columns import Rows, plain_name, read_rows, shown
from kinetics.crosscheck.comparison.data.labels import tracer_keys
from kinetics.crosscheck.comparison.reduction import Reduction
from kinetics.crosscheck.comparison.sample import Sample, from_ensemble
from kinetics.errors import InputError, check_positive

POSITIONS = ("auto", "displacement", "absolute")
MOST_ORIGINS = 4_000_000
"""Tracers whose place at time 0 is remembered, at most: bounds the memory."""

_LARGEST = 1e70
Tell = Callable[[str, float], None]
"""Called with a file's name and the share of it that has been read."""


def read_sample(
    paths: Sequence[Path],
    positions: str = "auto",
    speed_unit: float | str = 1.0,
    diameter: float = 1.0,
    tell: Tell | None = None,
) -> Sample:
    """One sample from files .csv, .npz or .h5 of columns, or from one file of an Ensemble.

    positions : "displacement": x, y are relative to the tracer's place at time 0. "absolute":
        they are places, from which the tracer's own place at time 0 is taken; needs a column
        `tracer` and rows at time 0. "auto": absolute if a position at time 0 is not the origin.
    speed_unit : U in the data's unit of speed; "data": from <v^2> = 2 U^2 at time 0
    diameter : d in the data's unit of length; times are then divided by d/U

    Lengths, speeds and times of an Ensemble file are known, and these three are not looked at.
    Several files are runs of their own: a label in one is not the same label in another. With one
    configuration, or without the column `medium`, standard errors are by tracer, and the
    sample's warnings say so. The files are only read. InputError for what cannot be used.
    """
    if not paths:
        raise InputError("data: got no file; at least one is needed")
    if positions not in POSITIONS:
        raise InputError(f"positions: got {positions!r}; it must be one of {', '.join(POSITIONS)}")
    diameter = check_positive("diameter", diameter)
    if speed_unit != "data":
        speed_unit = check_positive("speed_unit", speed_unit)
    ensembles = [path for path in paths if _is_ensemble(path)]
    if ensembles:
        if len(paths) > 1:
            raise InputError(f"{shown(ensembles[0])}: an Ensemble file must be the only file")
        run = load_ensemble(ensembles[0])
        return from_ensemble(run, plain_name(paths[0])).rescaled(1.0, run.medium.diameter)
    return _in_range(_scaled(_read(_Files(paths, tell), positions), speed_unit, diameter))


def load_ensemble(path: Path) -> Any:
    """The finished run in a file; InputError for one that is damaged or unfinished."""
    from particles import Ensemble

    try:
        return Ensemble.load(path)
    except ValueError as error:
        raise InputError(" ".join(str(error).split())) from None


def _is_ensemble(path: Path) -> bool:
    if path.suffix.lower() not in (".h5", ".hdf5") or not path.is_file():
        return False
    import h5py

    try:
        with h5py.File(path, "r") as file:
            return "plan" in file.attrs and "digest" in file.attrs
    except OSError:
        return False  # the reader of columns says what is wrong


class _Files:
    """The rows of several files, as often as they are needed."""

    def __init__(self, paths: Sequence[Path], tell: Tell | None) -> None:
        self.paths, self._tell = paths, tell

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(plain_name(path) for path in self.paths)

    def __iter__(self) -> Iterator[tuple[int, Rows]]:
        for number, path in enumerate(self.paths):
            progress = None
            if self._tell is not None:
                tell, name = self._tell, path.name

                def progress(share: float, tell: Tell = tell, name: str = name) -> None:
                    tell(name, share)

            for rows in read_rows(path, progress):
                yield number, rows


def _read(files: _Files, positions: str) -> Sample:
    found = _known_labels(files)
    grouping = "medium" if "medium" in found else "tracer" if "tracer" in found else "row"
    origins = None
    if positions == "absolute":
        origins = _Origins(files, found)
    warnings: list[str] = []
    while True:
        reduction = Reduction(grouping)
        media = _Distinct()
        for number, rows in files:
            try:
                reduction.add(rows if origins is None else origins.subtracted(rows, number), number)
            except InputError as error:
                raise InputError(f"{shown(files.paths[number])}: {error}") from None
            if rows.medium is not None:
                media.add(rows.medium, number)
        if positions == "auto" and origins is None and reduction.moved_at_zero:
            origins = _Origins(files, found)
            warnings.append(
                "Positions at time 0 are not the origin: each tracer's own was taken from its "
                "positions."
            )
            continue
        sample = reduction.sample(files.names)
        if sample.groups >= 2 or grouping == "row":
            break
        # One configuration shows no spread between configurations.
        grouping = "tracer" if grouping == "medium" and "tracer" in found else "row"
    if sample.groups < 2:
        raise InputError(f"{', '.join(files.names)}: has one tracer; at least two are needed")
    return replace(
        sample,
        media=media.count if "medium" in found else None,
        warnings=(*warnings, *_about_groups(sample.grouping, found)),
    )


def _about_groups(grouping: str, found: frozenset[str]) -> list[str]:
    if grouping == "medium":
        return []
    out = []
    if "medium" in found:
        out.append(
            "There is one configuration: errors are by tracer, and do not hold what another "
            "configuration of scatterers would change."
        )
    else:
        out.append(
            "Configurations are unknown (no column medium): errors are by tracer. Tracers that "
            "share scatterers are not independent, and their errors are larger than these."
        )
    if grouping == "row":
        out.append(
            "Tracers are unknown (no column tracer): the k-th row of each time is taken for the "
            "same tracer. If it is not, p-values over several times are wrong."
        )
    return out


def _known_labels(files: _Files) -> frozenset[str]:
    """The labels that every file has; InputError where only some have one."""
    has: list[frozenset[str]] = []
    for path in files.paths:
        with closing(read_rows(path)) as pieces:
            rows = next(pieces, None)
        if rows is None or rows.time.size == 0:
            raise InputError(f"{shown(path)}: has no rows; at least two tracers are needed")
        labels = {"tracer": rows.tracer, "medium": rows.medium}
        has.append(frozenset(name for name, ids in labels.items() if ids is not None))
    for path, names in zip(files.paths, has, strict=True):
        if names != has[0]:
            odd = ", ".join(sorted(names ^ has[0]))
            raise InputError(f"{shown(path)}: column {odd} must be in all files or in none")
    return has[0]


class _Distinct:
    """Counts different labels, up to a hundred thousand."""

    def __init__(self) -> None:
        self._seen: set[tuple[int, int]] = set()
        self._full = False

    def add(self, labels: Any, file: int) -> None:
        if self._full:
            return
        self._seen.update((file, int(label)) for label in np.unique(labels))
        self._full = len(self._seen) > 100_000

    @property
    def count(self) -> int:
        return len(self._seen)


class _Origins:
    """Where each tracer was at time 0."""

    def __init__(self, files: _Files, found: frozenset[str]) -> None:
        where = ", ".join(files.names)
        allowed = "displacements relative to the place at time 0 need nothing"
        if "tracer" not in found:
            raise InputError(
                f"{where}: positions at time 0 are not the origin, and without a column tracer "
                f"they cannot be subtracted; {allowed}"
            )
        pieces = [(np.empty(0, np.uint64), np.empty(0), np.empty(0))]
        count = 0
        for number, rows in files:
            zero = rows.time == 0
            if np.any(zero):
                pieces.append((_keys(rows, number)[zero], rows.x[zero], rows.y[zero]))
                count += int(zero.sum())
                if count > MOST_ORIGINS:
                    raise InputError(
                        f"{where}: more than {MOST_ORIGINS} tracers with absolute positions; "
                        "give displacements"
                    )
        keys, x, y = (np.concatenate(parts) for parts in zip(*pieces, strict=True))
        if keys.size == 0:
            raise InputError(f"{where}: absolute positions need rows at time 0; {allowed}")
        order = np.argsort(keys)
        self._keys, self._x, self._y = keys[order], x[order], y[order]

    def subtracted(self, rows: Rows, file: int) -> Rows:
        """The rows with displacements in place of positions."""
        keys = _keys(rows, file)
        k = np.minimum(np.searchsorted(self._keys, keys), self._keys.size - 1)
        lost = np.flatnonzero(self._keys[k] != keys)
        if lost.size:
            assert rows.tracer is not None
            raise InputError(
                f"tracer {rows.tracer[lost[0]]} has no row at time 0; absolute positions need one"
            )
        return replace(rows, x=rows.x - self._x[k], y=rows.y - self._y[k])


def _keys(rows: Rows, file: int) -> Any:
    assert rows.tracer is not None
    medium = np.empty(0, np.int64) if rows.medium is None else rows.medium
    return tracer_keys(rows.tracer, medium, file)


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


def _scaled(sample: Sample, speed_unit: float | str, diameter: float) -> Sample:
    if speed_unit != "data":
        return sample.rescaled(float(speed_unit), diameter)
    if sample.start is None:
        raise InputError("speed_unit: 'data' needs velocities at time 0; give U as a number")
    count = sample.start.counts
    size = float(np.sqrt(sample.start.squares @ count / max(count.sum(), 1) / 2))
    if not size > 0:
        raise InputError("speed_unit: all speeds at time 0 are zero; there is nothing to scale by")
    return replace(
        sample.rescaled(size, diameter),
        warnings=(*sample.warnings, f"U is {size:.6g} of the data's unit, from <v²> at time 0."),
    )
