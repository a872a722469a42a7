"""LAMMPS text dumps: frames with id, vx, vy and xu, yu (or x, y with image flags ix, iy).

In three dimensions with z beside them. Positions x, y without image flags are unwrapped where steps
are short enough, see `unwrapping`.
"""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from kinetics.crosscheck.comparison.data.columns import Asked, Rows, shown
from kinetics.crosscheck.comparison.data.frames import Box, read_lines, real, rows_of, whole
from kinetics.errors import InputError

_KINDS = ("length", "speed", "time")
UNITS = {
    "lj": dict.fromkeys(_KINDS, ""),
    "real": {"length": "angstrom", "speed": "angstrom/fs", "time": "fs"},
    "metal": {"length": "angstrom", "speed": "angstrom/ps", "time": "ps"},
    "si": {"length": "m", "speed": "m/s", "time": "s"},
    "cgs": {"length": "cm", "speed": "cm/s", "time": "s"},
    "micro": {"length": "um", "speed": "um/us", "time": "us"},
    "nano": {"length": "nm", "speed": "nm/ns", "time": "ns"},
}
"""What the styles of LAMMPS's command `units` mean (docs.lammps.org/units.html)."""


def read(path: Path, asked: Asked) -> Iterator[Rows]:
    """The rows of a dump; the time of a frame is ITEM: TIME, or its step times --timestep."""
    with open(path, encoding="utf-8", errors="replace") as file:
        lines = iter(file)
        seen = False
        while (head := _next_item(path, lines)) is not None:
            yield from _frame(path, lines, head, asked)
            seen = True
        if not seen:
            raise InputError(f"{shown(path)}: is empty, or not a LAMMPS text dump")


def _next_item(path: Path, lines: Iterator[str]) -> str | None:
    for line in lines:
        if line.startswith("ITEM: "):
            return line[6:].strip()
        if line.strip():
            raise InputError(f"{shown(path)}: is not a LAMMPS text dump: {line.strip()[:40]!r}")
    return None


def _frame(path: Path, lines: Iterator[str], head: str | None, asked: Asked) -> Iterator[Rows]:
    """One frame, of which the first ITEM is `head`."""
    step = count = time = box = units = None
    periodic: list[bool] = []
    while head is not None and not head.startswith("ATOMS"):
        if head == "TIMESTEP":
            step = whole(path, "a step", next(lines, ""))
        elif head == "TIME":
            time = real(path, "a time", next(lines, ""))
        elif head.startswith("NUMBER OF ATOMS"):
            count = whole(path, "the number of atoms", next(lines, ""))
        elif head.startswith("BOX BOUNDS"):
            # Of another box than a periodic one nothing is known of what is behind its edges.
            periodic = [one == "pp" for one in head.split()[2:]]
            box = _box(path, [next(lines, "") for _ in range(3)])
        elif head == "UNITS":
            units = UNITS.get(unit := next(lines, "").strip(), dict.fromkeys(_KINDS, unit))
        head = _next_item(path, lines)
    if head is None or count is None or step is None:
        raise InputError(f"{shown(path)}: is cut off in its last frame")
    if time is None:
        if asked.timestep is None:
            raise InputError(f"{shown(path)}: gives steps and no times; say --timestep")
        time = step * asked.timestep
    names = head.split()[1:]
    places = _places(path, names, 3 if asked.dimension == 3 else 2)
    for piece in read_lines(path, lines, count, places, len(names)):
        yield _rows(path, time, piece, box, periodic, units)


def _box(path: Path, bounds: list[str]) -> Box:
    edges = [[real(path, "a bound of the box", part) for part in line.split()] for line in bounds]
    if any(len(edge) != 2 for edge in edges):
        raise InputError(f"{shown(path)}: the box must be rectangular, with two bounds a line")
    return Box(tuple(low for low, _ in edges), tuple(high - low for low, high in edges))


def _places(path: Path, names: list[str], dimension: int) -> dict[str, int]:
    """The place of each column that is used."""
    places = {name: k for k, name in enumerate(names)}
    axes = "xyz"[:dimension]
    kinds = (("{}u",), ("{}su",), ("{}", "i{}"), ("{}s", "i{}"), ("{}",), ("{}s",))
    sets = [tuple(name.format(axis) for name in kind for axis in axes) for kind in kinds]
    found = next((one for one in sets if set(one) <= set(places)), None)
    lost = [name for name in ("id", *(f"v{axis}" for axis in axes)) if name not in places]
    if found is None or lost:
        raise InputError(
            f"{shown(path)}: column {lost[0] if lost else 'xu'!r} is missing; a dump needs id, vx, "
            "vy and xu, yu (or x, y, ix, iy)"
        )
    chosen = ["id", *found, "vx", "vy", "vz"]
    return {name: places[name] for name in chosen if name in places}


def _rows(
    path: Path, time: float, piece: dict[str, Any], box: Box | None, periodic: list[bool],
    units: dict[str, str] | None,
) -> Rows:  # fmt: skip
    position, wrapped = [], False
    for k, axis in enumerate("xyz"):
        names = (f"{axis}u", f"{axis}su", axis, f"{axis}s")
        name = next((one for one in names if one in piece), None)
        if name is None:
            continue
        values = piece[name]
        if "s" in name or f"i{axis}" in piece:
            if box is None:
                raise InputError(f"{shown(path)}: a frame has no box; write xu, yu")
            if "s" in name:  # in units of the box
                values = values * box.length[k] + box.low[k]
            values = values + piece.get(f"i{axis}", 0.0) * box.length[k]
        wrapped = wrapped or ("u" not in name and f"i{axis}" not in piece)
        position.append(values)
    velocity = [piece[name] for name in ("vx", "vy", "vz") if name in piece]
    places = np.stack(position, 1)
    rows = rows_of(shown(path), time, places, np.stack(velocity, 1), piece["id"])
    if box is None or not wrapped or not periodic or not all(periodic[: len(position)]):
        return replace(rows, units=units)
    return replace(rows, units=units, box=box.length[: len(position)])
