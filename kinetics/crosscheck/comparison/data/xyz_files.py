"""Extended XYZ: frames whose second line says Properties=...:pos:R:3:vel:R:3 and Time=..."""

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from kinetics.crosscheck.comparison.data.columns import Asked, Rows, shown
from kinetics.crosscheck.comparison.data.frames import read_lines, real, rows_of, whole
from kinetics.errors import InputError

_PAIR = re.compile(r'([A-Za-z_][\w-]*)\s*=\s*("[^"]*"|\S+)')
_POSITIONS, _LABELS = ("pos", "positions", "position"), ("id", "ids", "particle", "tracer")
_VELOCITIES = ("vel", "velo", "velocity", "velocities", "v")


def read(path: Path, asked: Asked) -> Iterator[Rows]:
    """The rows of a file; the time of a frame is Time=, or Step= times --timestep.

    Without a property id the k-th line of each frame is the same tracer. Positions are taken as
    they stand: they must not be wrapped.
    """
    with open(path, encoding="utf-8", errors="replace") as file:
        lines = iter(file)
        seen = False
        for line in lines:
            if not line.strip():
                continue
            count = whole(path, "the number of atoms", line)
            yield from _frame(path, lines, count, asked)
            seen = True
        if not seen:
            raise InputError(f"{shown(path)}: is empty, or not an extended XYZ file")


def _frame(path: Path, lines: Iterator[str], count: int, asked: Asked) -> Iterator[Rows]:
    said = {k.lower(): v.strip('"') for k, v in _PAIR.findall(next(lines, ""))}
    time = _time(path, said, asked)
    places, width = _places(path, said.get("properties", ""))
    done = 0
    for piece in read_lines(path, lines, count, places, width):
        n = len(piece["x"])
        label = piece.get("id", np.arange(done, done + n))
        position, velocity = (
            np.stack([piece[name] for name in names if name in piece], axis=1)
            for names in (("x", "y", "z"), ("vx", "vy", "vz"))
        )
        yield rows_of(shown(path), time, position, velocity, label)
        done += n


def _time(path: Path, said: dict[str, str], asked: Asked) -> float:
    name = next((one for one in ("time", "t") if one in said), None)
    if name is not None:
        return real(path, "a time", said[name])
    step = next((one for one in ("step", "timestep") if one in said), None)
    if step is None or asked.timestep is None:
        raise InputError(
            f"{shown(path)}: a frame has no Time= in its second line"
            + ("" if step is None else "; it gives steps: say --timestep")
        )
    return whole(path, "a step", said[step]) * asked.timestep


def _places(path: Path, properties: str) -> tuple[dict[str, int], int]:
    """The place of each column that is used, and how many there are."""
    parts, place = properties.split(":"), 0
    found: dict[str, int] = {}
    if len(parts) % 3:
        raise InputError(f"{shown(path)}: Properties= must be name:type:columns, repeated")
    for name, _, columns in zip(parts[::3], parts[1::3], parts[2::3], strict=True):
        width = whole(path, f"the columns of {name!r}", columns)
        for kind, names, axes in (
            ("position", _POSITIONS, ("x", "y", "z")),
            ("velocity", _VELOCITIES, ("vx", "vy", "vz")),
            ("id", _LABELS, ("id",)),
        ):
            if name.lower() not in names:
                continue
            if kind != "id" and width not in (2, 3):
                raise InputError(f"{shown(path)}: {name} has {width} columns; it must be 2 or 3")
            found |= {axis: place + k for k, axis in enumerate(axes[:width])}
        place += width
    for axis, wanted in (("x", "pos:R:3"), ("vx", "vel:R:3")):
        if axis not in found:
            raise InputError(f"{shown(path)}: Properties= has no {wanted}; it is needed")
    return found, place
