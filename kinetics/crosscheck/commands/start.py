"""The initial state of `lorentz solve`: a name, or a file with a table of the speed density."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from kinetics.errors import InputError

NAMES = ("gaussian", "monoenergetic", "beam", "rest")


def initial_state(text: str, speed: float, direction: float) -> Any:
    """What a Scene takes as `initial`.

    text : one of :data:`NAMES`, or the path of a .csv file: speed in U, density in 1/U
    speed : of "monoenergetic" and "beam", in U
    direction : of "beam", its angle to the x axis in radians

    Raises InputError for another text, and for a file that is no such table.
    """
    from kinetics import Beam, Monoenergetic, SpeedTable

    if text not in NAMES and not text.endswith(".csv"):
        names = ", ".join(NAMES)
        raise InputError(f"initial: got {text!r}; it must be {names}, or a .csv file of speeds")
    if text not in ("monoenergetic", "beam") and speed != 1.0:
        raise InputError(f"speed: got {speed:g}; it is of --initial monoenergetic and beam")
    if text != "beam" and direction != 0.0:
        raise InputError(f"direction: got {direction:g}; it is of --initial beam")
    if text == "beam":
        return Beam(direction, Monoenergetic(speed))
    if text == "monoenergetic" and speed != 1.0:
        return Monoenergetic(speed)
    return text if text in NAMES else SpeedTable(*_columns(Path(text)))


def _columns(path: Path) -> tuple[list[float], list[float]]:
    """Two columns of numbers, below one line of names if there is one."""
    import csv

    try:
        with open(path, newline="", encoding="utf-8") as file:
            rows = [row for row in csv.reader(file) if row]
    except (UnicodeDecodeError, csv.Error):
        raise InputError(f"initial: {path} must be a CSV file, text in UTF-8") from None
    except OSError as error:
        raise InputError(f"initial: {path} cannot be read ({error.strerror})") from None
    found: list[tuple[float, float]] = []
    for number, row in enumerate(rows, 1):
        try:
            speed, density = (float(cell) for cell in row)
        except ValueError:
            if number > 1:
                what = f"row {number} of {path} must be two numbers, a speed and its density"
                raise InputError(f"initial: {what}") from None
            continue
        found.append((speed, density))
    if len(found) < 2:
        raise InputError(f"initial: {path} has {len(found)} rows of two numbers; it must have two")
    return [v for v, _ in found], [f for _, f in found]
