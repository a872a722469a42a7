"""Units that files state beside their numbers: mm, m/s and s do not belong together, and d/U is
then not the diameter over U in numbers: it must be told.
"""

import re
from collections.abc import Mapping
from typing import Any

from kinetics.errors import InputError, short

OWN = {"length": ("d",), "speed": ("u",), "time": ("d/u", "d u-1", "u-1 d")}
"""The units of this package, in lower case."""
KINDS = {
    "time": "time", **dict.fromkeys(("x", "y", "z"), "length"),
    **dict.fromkeys(("vx", "vy", "vz"), "speed"),
}  # fmt: skip
"""What each column is a number of."""
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
        if kind and unit and found.setdefault(kind, unit) != unit:
            raise InputError(f"{where}: has {kind}s in {found[kind]} and in {short(unit)}")
    return found


def are_own(units: Mapping[str, str]) -> bool:
    """Whether those that are stated are those of this package."""
    return all(unit.strip().lower() in OWN[kind] for kind, unit in units.items())


def are_mixed(units: Mapping[str, str]) -> bool:
    """Whether a speed is stated in other units than those of length and time: mm, m/s and s."""
    kinds = ("length", "speed", "time")
    length, speed, time = (units.get(kind, "").strip().lower() for kind in kinds)
    found = _SPEED.fullmatch(speed)
    own = found is None or (found[1], found[2] or found[3]) == (length, time)
    return bool(length and time) and not (own or are_own(units))
