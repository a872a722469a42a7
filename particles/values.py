"""Values: an argument is checked when it comes in, a result frozen when it is made.

What is refused is a ValueError in one line, `name: got VALUE; it must be ...`.
"""

import contextlib
import math
import os
import sys
from dataclasses import fields
from importlib.metadata import PackageNotFoundError, version
from numbers import Real
from types import MappingProxyType
from typing import Any, NoReturn

import numpy as np


def short(value: Any, limit: int = 60) -> str:
    """Return the repr of a value on one line, cut to `limit` characters."""
    try:
        text = " ".join(repr(value).split())
    except Exception:  # an int of more digits than Python writes out; a repr that fails
        text = f"<{type(value).__name__}>"
    return text if len(text) <= limit else text[: limit - 3] + "..."


def refuse(name: str, value: Any, allowed: str) -> NoReturn:
    """Raise ValueError for the argument of this name and value."""
    raise ValueError(f"{name}: got {short(value)}; {allowed}") from None


def is_real(value: Any) -> bool:
    """Tell whether this is a real number, of Python or NumPy, and no boolean."""
    return isinstance(value, Real) and not isinstance(value, bool)


def check_positive(name: str, value: Any) -> float:
    """Return a positive finite number as a float."""
    allowed = "it must be a finite number above 0"
    return check_number(name, value, 5e-324, sys.float_info.max, allowed)


def check_number(name: str, value: Any, low: float, high: float, allowed: str) -> float:
    """Return a number from low to high as a float."""
    number = math.nan
    if is_real(value):
        with contextlib.suppress(OverflowError):
            number = float(value)
    if not low <= number <= high:
        refuse(name, value, allowed)
    return number


def is_whole(value: Any) -> bool:
    """Tell whether this is a whole number, of Python or NumPy, and no boolean."""
    return isinstance(value, (int, np.integer)) and not isinstance(value, bool)


def check_whole(name: str, value: Any, low: int, high: int = 2**62) -> int:
    """Return a whole number from low to high as an int."""
    if not is_whole(value) or not low <= value <= high:
        refuse(name, value, f"it must be a whole number from {low} to {high}")
    return int(value)


def real_array(name: str, value: Any, allowed: str) -> np.ndarray:
    """Return real numbers as a new array of doubles; complex and masked ones are refused.

    Numbers that are too large for a double become infinite.
    """
    try:
        array = np.array(value)
        numbers = array.dtype.kind in "iuf" or all(map(is_real, array.flat))
        if not numbers or np.ma.is_masked(value):
            raise TypeError
        with np.errstate(over="ignore"):
            return array.astype(np.float64)
    except (TypeError, ValueError, OverflowError):
        refuse(name, value, allowed)


def check_path(name: str, value: Any) -> str:
    """Return the path of a file as text."""
    try:
        text = os.fsdecode(value)
    except TypeError:
        text = ""
    if not text or "\0" in text:
        refuse(name, value, "it must be the path of a file")
    return text


def package_version() -> str:
    """Return the version that is installed."""
    try:
        return version("inelastic-lorentz")
    except PackageNotFoundError:
        return "unknown: the package is not installed"


def frozen(value: Any) -> Any:
    """Return a read-only view of an array or of a dict of arrays; anything else as it is."""
    if isinstance(value, dict):
        return MappingProxyType({name: frozen(item) for name, item in value.items()})
    if isinstance(value, np.ndarray):
        value = value.view()
        value.setflags(write=False)
    return value


def _content(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tobytes()
    if isinstance(value, MappingProxyType):
        return tuple((name, _content(value[name])) for name in sorted(value))
    return value


class Value:
    """Base of frozen dataclasses (eq=False) that hold arrays.

    Two are equal if they are of one class and every field is, arrays bit by bit (so NaN equals
    NaN). Fields are made read-only. Pickling keeps the fields alone, not what was computed of them.
    """

    def __post_init__(self) -> None:
        self.__setstate__(vars(self))

    def __getstate__(self) -> dict[str, Any]:
        state = {f.name: getattr(self, f.name) for f in fields(self)}  # type: ignore[arg-type]
        return {k: dict(v) if isinstance(v, MappingProxyType) else v for k, v in state.items()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update({name: frozen(value) for name, value in state.items()})

    def _key(self) -> tuple[Any, ...]:
        return tuple(_content(getattr(self, f.name)) for f in fields(self))  # type: ignore[arg-type]

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and self._key() == other._key()

    def __hash__(self) -> int:
        return hash((type(self), self._key()))
