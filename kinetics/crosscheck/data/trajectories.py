"""Trajectories as simulation programs write them, frame by frame: LAMMPS, extended XYZ and GSD."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import suppress
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.data.arrays import Column, floats_of
from kinetics.crosscheck.data.columns import AXES, SPEEDS, present
from kinetics.crosscheck.data.frames import Box, Frame, common_box
from kinetics.crosscheck.data.memory import MemoryBudget, bytes_of_numbers, require_memory
from kinetics.crosscheck.data.options import DataOptions, refuse_data
from kinetics.crosscheck.data.table import Table, table_of_frames
from kinetics.errors import short

if TYPE_CHECKING:
    import gsd.fl
    import gsd.hoomd

#: Characters of a line at most.
MAX_LINE = 1 << 20
#: Columns of one property of extended XYZ at most.
MAX_WIDTH = 1000
#: Lines that are parsed at once, so that memory can be checked meanwhile. The origin of the number
#: is not recorded.
LINES_AT_ONCE = 100_000
#: Characters of the parser's reason that a message shows. The origin is not recorded.
MAX_REASON = 150
#: NumPy's name of the type of a column of numbers: doubles.
TYPE_OF_NUMBER = "f8"
#: NumPy's name of the type of a column of texts: of 64 characters. The origin is not recorded.
TYPE_OF_TEXT = "U64"
#: Columns of a frame of GSD: a label, places and velocities.
COLUMNS_OF_GSD = 7


class _Lines:
    """The lines of a text file, one after another; `where` names the file and the last line."""

    def __init__(self, path: Path, where: str) -> None:
        require_memory(where, 0.5 * path.stat().st_size)
        self._budget = MemoryBudget(where)
        self._file = open(path, errors="replace")  # noqa: SIM115
        self._name = where
        self._number = 0

    @property
    def where(self) -> str:
        """The file and the number of the last line."""
        return f"{self._name}: line {self._number}"

    def next(self) -> str:
        """Return the next line; empty at the end of the file."""
        self._number += 1
        return self._file.readline(MAX_LINE)

    def __iter__(self) -> Iterator[str]:
        """Return the lines from here on that are not blank, to the end of the file."""
        with self._file:
            while line := self.next():
                if line.strip():
                    yield line.strip()

    def refuse(self, found: object, allowed: str) -> NoReturn:
        """Raise InputError for the last line."""
        refuse_data(self.where, found, allowed)

    def whole_number(self, text: str) -> int:
        """Return the whole number, not negative, that a text is; or InputError."""
        if not text.strip().isdecimal():
            self.refuse(short(text.strip()), "a whole number")
        return int(text)

    def number(self, text: str) -> float:
        """Return the finite number that a text is; or InputError."""
        with suppress(ValueError):
            value = float(text)
            if np.isfinite(value):
                return value
        self.refuse(short(text.strip()), "a finite number")

    def columns(self, count: int, names: Sequence[str], wanted: Sequence[str]) -> dict[str, Column]:
        """Return columns of the next lines, shape (count,) each; numbers except the type.

        Parameters
        ----------
        count : of the lines
        names : of all columns of a line
        wanted : the names of those that are returned, each there once
        """
        fields: list[tuple[str, str]] = []
        places: list[int] = []
        for name in wanted:
            occurrences = list(names).count(name)
            if occurrences != 1:
                self.refuse(f"column {name!r} {occurrences} times", "once")
            places.append(list(names).index(name))
            type_of_column = TYPE_OF_NUMBER
            if name == "type":
                type_of_column = TYPE_OF_TEXT
            fields.append((name, type_of_column))
        row_type = np.dtype(fields)
        where = f"{self._name}: from line {self._number + 1} on"
        allowed = f"{count} rows of numbers"
        blocks = [np.empty(0, row_type)]
        n_lines = 0
        remaining = count
        while remaining > 0:
            n_requested = min(remaining, LINES_AT_ONCE)
            lines = list(islice(self._file, n_requested))
            self._number += len(lines)
            n_lines += len(lines)
            self._budget.take(float(row_type.itemsize * len(lines)))
            try:
                block = _rows_of(lines, row_type, places)
            except ValueError as error:
                refuse_data(where, short(str(error), MAX_REASON), allowed)
            if block.size < n_requested:
                refuse_data(where, f"{n_lines} lines, some blank", allowed)
            blocks.append(block)
            remaining -= block.size
        values = np.concatenate(blocks)
        return {name: values[name] for name in wanted}


def _rows_of(lines: list[str], row_type: np.dtype[np.void], places: list[int]) -> NDArray[np.void]:
    """Return the rows that lines hold, of the cells at some places; ValueError for other cells."""
    if not lines:
        return np.empty(0, row_type)
    return np.loadtxt(lines, row_type, None, usecols=places, ndmin=1)


def _type_column(options: DataOptions) -> list[str]:
    """Return the name of the column of types if it is needed."""
    if options.type is None:
        return []
    return ["type"]


# -- LAMMPS ----------------------------------------------------------------------------------------


def read_lammps(path: Path, where: str, options: DataOptions) -> Table:
    """Read a LAMMPS text dump: unwrapped places xu, yu, or x, y, with image flags or not."""
    reader = _LammpsReader(_Lines(path, where), where, options)
    frames, box = reader.read()
    return table_of_frames(where, frames, options, box)


class _LammpsReader:
    """Reads the items of a dump: each frame has a time or step, a number of atoms, a box, atoms."""

    def __init__(self, lines: _Lines, where: str, options: DataOptions) -> None:
        self.lines = lines
        self.where = where
        self.options = options
        self.step: int | None = None
        self.time: float | None = None
        self.count: int | None = None
        self.box: Box | None = None
        self.wrapped_boxes: list[Box | None] = []

    def read(self) -> tuple[list[Frame], Box | None]:
        """Return the frames, and the box of positions that may be wrapped."""
        frames = []
        is_between_frames = True
        for line in self.lines:
            if not line.startswith("ITEM: "):
                self.lines.refuse(short(line), "a line `ITEM: ...` of a LAMMPS text dump")
            item, *words = line.removeprefix("ITEM: ").split()
            is_between_frames = item == "ATOMS"
            if item == "TIMESTEP":
                self.step = self.lines.whole_number(self.lines.next())
            elif item == "TIME":
                self.time = self.lines.number(self.lines.next())
            elif item == "NUMBER":
                self.count = self.lines.whole_number(self.lines.next())
            elif item == "UNITS":
                self.lines.next()
            elif item == "BOX":
                self.box = self._read_box(words)
            elif item == "ATOMS":
                frames.append(self._read_atoms(words))
        if not is_between_frames:
            refuse_data(self.where, "a last frame without atoms", "whole frames")
        are_wrapped = {box is not None for box in self.wrapped_boxes}
        if len(are_wrapped) > 1:
            refuse_data(self.where, "image flags in some frames alone", "in all frames, or in none")
        return frames, common_box(self.where, self.wrapped_boxes)

    def _read_box(self, words: list[str]) -> Box:
        """Read the bounds of a box, two on a line."""
        sides = {}
        for axis in AXES:
            bounds = self.lines.next().split()
            if len(bounds) != 2:
                self.lines.refuse("a slanted box", "rectangular, with two bounds a line")
            sides[axis] = self.lines.number(bounds[1]) - self.lines.number(bounds[0])
        boundaries = dict(zip(AXES, words[1:], strict=False))
        periodic = frozenset(axis for axis, word in boundaries.items() if word == "pp")
        return Box(sides, periodic)

    def _read_atoms(self, names: list[str]) -> Frame:
        """Read the atoms of one frame."""
        if self.count is None:
            self.lines.refuse("atoms", "the number of atoms before")
        axes = self.options.axes
        place_names: dict[str, str] = {}
        image_names: dict[str, str] = {}
        wrapped_axes: set[str] = set()
        for axis in axes:
            place_names[axis] = axis
            if f"{axis}u" in names:
                place_names[axis] = f"{axis}u"
            elif f"i{axis}" in names:
                image_names[axis] = f"i{axis}"
            else:
                wrapped_axes.add(axis)
        stated = [*present(SPEEDS, names), *_type_column(self.options)]
        wanted = ["id", *stated, *place_names.values(), *image_names.values()]
        atoms = self.lines.columns(self.count, names, wanted)
        columns = {name: atoms[name] for name in stated}
        columns["tracer"] = atoms["id"]
        for axis, name in place_names.items():
            columns[axis] = atoms[name]
            if axis in image_names and self.box is not None:
                crossed = self.box.sides[axis] * floats_of(atoms, image_names[axis])
                columns[axis] = floats_of(atoms, name) + crossed
        wrapped_box = None
        if self.box is not None and wrapped_axes:
            wrapped_box = Box(self.box.sides, self.box.periodic & wrapped_axes)
        self.wrapped_boxes.append(wrapped_box)
        return Frame(self._time_of_frame(), columns)

    def _time_of_frame(self) -> float:
        """Return the time of a frame, and forget it."""
        time = self.time
        step = self.step
        self.time = None
        self.step = None
        if time is not None:
            return time
        if step is None:
            refuse_data(self.where, "no times", "a TIME or a TIMESTEP for each frame")
        return float(self.options.times_of_steps(self.where, step))


# -- extended XYZ ----------------------------------------------------------------------------------

#: A pair `key=value` of the second line of a frame; values with blanks are in quotes.
_PAIR = re.compile(r'([A-Za-z_][\w-]*)\s*=\s*("[^"]*"|\S+)')
#: Properties that are read, and our names of their columns.
_PROPERTIES: dict[str, tuple[str, ...]] = {
    **dict.fromkeys(("pos", "positions", "position"), AXES),
    **dict.fromkeys(("vel", "velo", "velocity", "velocities", "v"), SPEEDS),
    **dict.fromkeys(("id", "ids", "particle", "tracer"), ("tracer",)),
    **dict.fromkeys(("species", "type"), ("type",)),
}


def read_xyz(path: Path, where: str, options: DataOptions) -> Table:
    """Read extended XYZ, whose second lines say Properties=...:pos:R:3:vel:R:3 and Time=..."""
    frames = []
    boxes = []
    lines = _Lines(path, where)
    for line in lines:
        count = lines.whole_number(line)
        stated: dict[str, str] = {}
        for key, value in _PAIR.findall(lines.next()):
            stated[key.lower()] = value.strip('"')
        names = _property_columns(lines, stated)
        time = _time_of_xyz(lines, where, stated, options)
        boxes.append(_box_of_xyz(lines, stated))
        wanted = [*options.axes, *present((*SPEEDS, "tracer"), names), *_type_column(options)]
        columns: dict[str, Column] = {"tracer": np.arange(count)}
        columns |= lines.columns(count, names, wanted)
        frames.append(Frame(time, columns))
    box = common_box(where, boxes)
    return table_of_frames(where, frames, options, box)


def _property_columns(lines: _Lines, stated: dict[str, str]) -> list[str]:
    """Return our names of the columns of a frame, "" for those that are not read."""
    words = stated.get("properties", "").split(":")
    names: list[str] = []
    for name, width_text in zip(words[::3], words[2::3], strict=False):
        width = lines.whole_number(width_text)
        columns = _PROPERTIES.get(name.lower(), ())
        is_too_narrow = bool(columns) and width < min(2, len(columns))
        is_too_wide = width > (len(columns) or MAX_WIDTH)
        if is_too_narrow or is_too_wide:
            lines.refuse(f"{name} has {width} columns", "pos:R:3:vel:R:3 in Properties=")
        names += columns[:width] or [""] * width
    return names


def _time_of_xyz(lines: _Lines, where: str, stated: dict[str, str], options: DataOptions) -> float:
    """Return the time of a frame, from its time or its step."""
    time = stated.get("time", stated.get("t"))
    if time is not None:
        return lines.number(time)
    step = stated.get("step", stated.get("timestep", stated.get("frame")))
    if step is None:
        refuse_data(where, "no times", "Time= or Step= in the second line of each frame")
    return float(options.times_of_steps(where, lines.whole_number(step)))


def _box_of_xyz(lines: _Lines, stated: dict[str, str]) -> Box | None:
    """Return the box of a frame, if it says its lattice.

    It is periodic along all axes if nothing else is said, as extended XYZ has it.
    """
    lattice = stated.get("lattice", "").split()
    flags = stated.get("pbc", "T T T").split()
    if len(lattice) != 9 or len(flags) != 3:
        return None
    cell = np.array([lines.number(text) for text in lattice]).reshape(3, 3)
    periodic = set()
    for axis, flag in zip(AXES, flags, strict=True):
        if flag.upper()[:1] in "T1":
            periodic.add(axis)
    if periodic and np.any(cell != np.diag(np.diagonal(cell))):
        lines.refuse("a slanted box", "rectangular")
    sides = dict(zip(AXES, np.diagonal(cell).tolist(), strict=True))
    return Box(sides, frozenset(periodic))


# -- GSD -------------------------------------------------------------------------------------------


def read_gsd(path: Path, where: str, options: DataOptions) -> Table:
    """Read frames as HOOMD-blue writes them.

    A frame states only what is not as in the first one, and by default HOOMD leaves out velocities
    and images whatever they are; a reader then returns those of the first frame. So what a frame
    does not state is missing. Images are as in the first frame only if some later frame states its
    own; else they are unknown, and positions are unwrapped by the box.
    """
    try:
        import gsd.hoomd
    except ImportError:
        refuse_data(where, "a file of another package", "installed: pip install gsd")
    with gsd.hoomd.open(str(path), "r") as file:
        n_frames = len(file)
        stated = [_stated_in_gsd(file.file, index) for index in range(n_frames)]
        has_images = any("image" in names for names in stated[1:])
        budget = MemoryBudget(where)
        frames = []
        boxes = []
        for index in range(n_frames):
            if "position" not in stated[index]:
                continue
            snapshot = file[index]
            budget.take(bytes_of_numbers(int(snapshot.particles.N) * COLUMNS_OF_GSD, 8.0))
            frames.append(_frame_of_gsd(where, snapshot, stated[index], has_images, options))
            boxes.append(_box_of_gsd(where, snapshot))
    if has_images:
        return table_of_frames(where, frames, options)
    return table_of_frames(where, frames, options, common_box(where, boxes))


def _stated_in_gsd(file: gsd.fl.GSDFile, index: int) -> set[str]:
    """Return the quantities of particles that a frame states; in the first, positions are."""
    stated = set()
    for name in ("position", "velocity", "image"):
        if file.chunk_exists(frame=index, name=f"particles/{name}"):
            stated.add(name)
    if index == 0:
        stated.add("position")  # those that are not written are zero
    return stated


def _box_of_gsd(where: str, snapshot: gsd.hoomd.Frame) -> Box:
    """Return the box of a frame; it is periodic, and as in the first frame if none is stated."""
    box = np.asarray(snapshot.configuration.box, float)
    if np.any(box[3:] != 0):
        refuse_data(where, "a slanted box", "rectangular")
    sides = dict(zip(AXES, box[:3].tolist(), strict=True))
    return Box(sides, frozenset(AXES))


def _frame_of_gsd(
    where: str, snapshot: gsd.hoomd.Frame, stated: set[str], has_images: bool, options: DataOptions
) -> Frame:
    """Return one frame by our names, of what it states."""
    n_axes = 2
    if snapshot.configuration.dimensions == 3:
        n_axes = 3
    particles = snapshot.particles
    positions = np.asarray(particles.position, float)
    if has_images:
        sides = np.asarray(snapshot.configuration.box, float)[:3]
        positions = positions + np.asarray(particles.image) * sides
    columns: dict[str, Column] = {"tracer": np.arange(int(particles.N))}
    columns |= dict(zip(AXES[:n_axes], positions.T, strict=False))
    if "velocity" in stated:
        velocities = np.asarray(particles.velocity, float)
        columns |= dict(zip(SPEEDS[:n_axes], velocities.T, strict=False))
    if options.type is not None:
        columns["type"] = np.asarray(particles.types or ["A"])[particles.typeid]
    step = snapshot.configuration.step
    return Frame(float(options.times_of_steps(where, step)), columns)
