"""Units: those that files state beside their numbers, and what tracers in straight flight tell.

Lengths, speeds and times may stand in units that do not belong together, as mm, m/s and s. Then
d/U is not the diameter over U in numbers, and is converted.
"""

import re
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from kinetics.errors import InputError, short

LENGTHS = {
    "km": 1e3, "m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "nm": 1e-9,
    "pm": 1e-12, "angstrom": 1e-10, "å": 1e-10,
}  # fmt: skip
"""In metres."""
TIMES = {
    "h": 3600.0, "min": 60.0, "s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "μs": 1e-6, "ns": 1e-9,
    "ps": 1e-12, "fs": 1e-15,
}  # fmt: skip
"""In seconds."""
REDUCED = {"length": ("d",), "speed": ("u",), "time": ("d/u", "d u-1", "u-1 d")}
"""The units of this package, in lower case."""
KINDS = {
    "time": "time", **dict.fromkeys(("x", "y", "z", "msd"), "length"),
    **dict.fromkeys(("vx", "vy", "vz", "thermal_speed", "mean_square_speed"), "speed"),
}  # fmt: skip
"""What each column is a number of, or (`SQUARES`) the square of one."""
SQUARES = ("msd", "mean_square_speed")
_SPEED = re.compile(r"([^\W\d]+)\s*(?:/\s*([^\W\d]+)|[\s*·.]\s*([^\W\d]+)\s*\^?-1)")
_BEHIND = re.compile(r"(.*\S)(?:\s*\[\s*([^]]*?)\s*\]|\s+\(\s*([^)]*?)\s*\))")


def split_unit(name: Any) -> tuple[str, str]:
    """The name of a column in lower case without its unit, and the unit: "t [s]", "t (s)"."""
    text = str(name).strip().strip("\"'").strip()
    found = _BEHIND.fullmatch(text)
    bare, unit = (found[1], found[2] or found[3] or "") if found else (text, "")
    return bare.strip().lower(), unit


def stated(where: str, units: Mapping[str, str]) -> dict[str, str]:
    """Units by "length", "speed" and "time" from those of columns; InputError if x and y differ."""
    found: dict[str, str] = {}
    for name, unit in units.items():
        kind = KINDS.get(name)
        if name in SQUARES:
            unit = re.sub(r"(\^?2|²)$", "", unit).strip("()")
        if kind and unit and found.setdefault(kind, unit) != unit:
            raise InputError(f"{where}: has {kind}s in {found[kind]} and in {short(unit)}")
    return found


def size_of(kind: str, unit: str) -> float | None:
    """The size of a unit in metres, seconds or metres per second; None if it is not known."""
    plain = unit.strip().lower()
    if kind == "length":
        return LENGTHS.get(plain)
    if kind == "time":
        return TIMES.get(plain)
    found = _SPEED.fullmatch(plain)
    if not found:
        return None
    length, time = LENGTHS.get(found[1]), TIMES.get(found[2] or found[3])
    return None if length is None or time is None else length / time


def are_own(units: Mapping[str, str]) -> bool:
    """Whether those that are stated are those of this package."""
    return all(unit.strip().lower() in REDUCED[kind] for kind, unit in units.items())


def conversion(units: Mapping[str, str]) -> float | None:
    """The unit of length over that of speed, in units of time: 1 where they belong together.

    None where one of them is not stated or not known.
    """
    if are_own(units):
        return 1.0
    length, speed, time = (size_of(k, units.get(k, "")) for k in ("length", "speed", "time"))
    return None if length is None or speed is None or time is None else length / speed / time


class Flights(NamedTuple):
    """Tracers that have flown straight by a time: the ratio |r|/(|v| t) that they share.

    share: of all tracers at that time. The ratio is 1 where units belong together: a tracer that
    has not collided is at r = v t, whatever the scatterers; for others it has many values.
    """

    time: float
    ratio: float
    share: float


_SAME = 2e-3
"""Width in ln(|r|/(|v| t)) within which tracers fly alike: numbers may have few digits."""
_LEAST_SHARE, _FEWEST = 0.05, 20
"""Tracers that must fly alike. Those that have collided put some 0.5 % into such a width."""


def straight_flights(time: Any, distance: Any, speed: Any) -> Flights | None:
    """The ratio |r|/(|v| t) that most tracers share at one time; None where too few share one.

    time, distance, speed (n,): of tracers at times that are nearly the same, in units of the data.
    """
    time = np.broadcast_to(np.asarray(time, float), distance.shape)
    moving = (distance > 0) & (speed > 0) & (time > 0)
    if np.count_nonzero(moving) < _FEWEST:
        return None
    ratio = np.sort(np.log(distance[moving]) - np.log(speed[moving]) - np.log(time[moving]))
    alike = np.searchsorted(ratio, ratio + _SAME) - np.arange(ratio.size)
    first = int(np.argmax(alike))
    count = int(alike[first])
    if count < max(_FEWEST, _LEAST_SHARE * distance.size):
        return None
    middle = float(np.exp(np.median(ratio[first : first + count])))
    return Flights(float(time[moving].mean()), middle, count / distance.size)
