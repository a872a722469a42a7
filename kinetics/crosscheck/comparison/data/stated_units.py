"""Units that files state beside their numbers: which are known, and what follows for d/U.

Lengths, speeds and times may stand in units that do not belong together, as mm, m/s and s. Then
d/U is not the diameter over U in numbers, and is converted.
"""

import re
from collections.abc import Mapping

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
_SPEED = re.compile(r"([^\W\d]+)\s*(?:/\s*([^\W\d]+)|[\s*·.]\s*([^\W\d]+)\s*\^?-1)")


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
    """Whether all are stated, and are those of this package."""
    return all(units.get(kind, "").strip().lower() in known for kind, known in REDUCED.items())


def conversion(units: Mapping[str, str]) -> float | None:
    """The unit of length over that of speed, in units of time: 1 where they belong together.

    None where one of them is not stated or not known.
    """
    if are_own(units):
        return 1.0
    sizes = [size_of(kind, units.get(kind, "")) for kind in ("length", "speed", "time")]
    length, speed, time = sizes
    return None if length is None or speed is None or time is None else length / speed / time
