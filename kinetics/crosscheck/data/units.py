"""Units that files state beside their numbers: mm, m/s and s do not belong together, and d/U is
then not the diameter over U in numbers, and is converted.
"""

import re
from collections.abc import Mapping
from typing import Any

from kinetics.errors import InputError, short

_PREFIXES = {"k": 1e3, "": 1.0, "c": 1e-2, "m": 1e-3, **dict.fromkeys("uµμ", 1e-6), "n": 1e-9,
             "p": 1e-12, "f": 1e-15}  # fmt: skip
SIZES = {
    "length": {f"{k}m": x for k, x in _PREFIXES.items()} | {"angstrom": 1e-10, "å": 1e-10},
    "time": {f"{k}s": x for k, x in _PREFIXES.items()} | {"h": 3600.0, "min": 60.0},
}
"""In metres and in seconds."""
OWN = {"length": ("d",), "speed": ("u",), "time": ("d/u", "d u-1", "u-1 d")}
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
    if kind != "speed":
        return SIZES[kind].get(plain)
    if (found := _SPEED.fullmatch(plain)) is None:
        return None
    length, time = size_of("length", found[1]), size_of("time", found[2] or found[3])
    return None if length is None or time is None else length / time


def are_own(units: Mapping[str, str]) -> bool:
    """Whether those that are stated are those of this package."""
    return all(unit.strip().lower() in OWN[kind] for kind, unit in units.items())


def conversion(units: Mapping[str, str]) -> float | None:
    """The unit of length over that of speed, in units of time: 1 where they belong together.

    None where one of them is not stated or not known.
    """
    if are_own(units):
        return 1.0
    length, speed, time = (size_of(k, units.get(k, "")) for k in ("length", "speed", "time"))
    return None if length is None or speed is None or time is None else length / speed / time
