"""LAMMPS text dumps: frames with id, vx, vy and xu, yu (or x, y with image flags ix, iy)."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from kinetics.crosscheck.comparison.data.columns import Asked, Rows, shown
from kinetics.crosscheck.comparison.data.frames import Box, read_lines, real, rows_of, whole
from kinetics.errors import InputError


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
    step = count = time = box = None
    while head is not None and not head.startswith("ATOMS"):
        if head == "TIMESTEP":
            step = whole(path, "a step", next(lines, ""))
        elif head == "TIME":
            time = real(path, "a time", next(lines, ""))
        elif head.startswith("NUMBER OF ATOMS"):
            count = whole(path, "the number of atoms", next(lines, ""))
        elif head.startswith("BOX BOUNDS"):
            box = _box(path, [next(lines, "") for _ in range(3)])
        elif head == "UNITS":
            next(lines, "")
        head = _next_item(path, lines)
    if head is None or count is None or step is None:
        raise InputError(f"{shown(path)}: is cut off in its last frame")
    if time is None:
        if asked.timestep is None:
            raise InputError(f"{shown(path)}: gives steps and no times; say --timestep")
        time = step * asked.timestep
    names = head.split()[1:]
    places = _places(path, names)
    for piece in read_lines(path, lines, count, places, len(names)):
        yield _rows(path, time, piece, box)


def _box(path: Path, bounds: list[str]) -> Box:
    edges = [[real(path, "a bound of the box", part) for part in line.split()] for line in bounds]
    if any(len(edge) != 2 for edge in edges):
        raise InputError(f"{shown(path)}: the box must be rectangular, with two bounds a line")
    (x0, x1), (y0, y1) = edges[:2]
    return Box((x0, y0), (x1 - x0, y1 - y0))


def _places(path: Path, names: list[str]) -> dict[str, int]:
    """The place of each column that is used."""
    places = {name: k for k, name in enumerate(names)}
    sets = (("xu", "yu"), ("xsu", "ysu"), ("x", "y", "ix", "iy"), ("xs", "ys", "ix", "iy"))
    found = next((one for one in sets if set(one) <= set(places)), None)
    if found is None and {"x", "y"} <= set(places):
        found = ("x", "y")  # wrapped ones are found out by where they stay
    lost = [name for name in ("id", "vx", "vy") if name not in places]
    if found is None or lost:
        raise InputError(
            f"{shown(path)}: column {lost[0] if lost else 'xu'!r} is missing; a dump needs id, vx, "
            "vy and xu, yu (or x, y, ix, iy)"
        )
    chosen = ["id", *found, "vx", "vy", *(["vz"] if "vz" in places else [])]
    return {name: places[name] for name in chosen}


def _rows(path: Path, time: float, piece: dict[str, Any], box: Box | None) -> Rows:
    position = []
    for k, axis in enumerate("xy"):
        name = next(one for one in (f"{axis}u", f"{axis}su", axis, f"{axis}s") if one in piece)
        values = piece[name]
        if "s" in name or f"i{axis}" in piece:
            if box is None:
                raise InputError(f"{shown(path)}: a frame has no box; write xu, yu")
            if "s" in name:  # in units of the box
                values = values * box.length[k] + box.low[k]
            values = values + piece.get(f"i{axis}", 0.0) * box.length[k]
        position.append(values)
    velocity = [piece[name] for name in ("vx", "vy", "vz") if name in piece]
    return rows_of(shown(path), time, np.stack(position, 1), np.stack(velocity, 1), piece["id"])
