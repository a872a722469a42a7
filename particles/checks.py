"""Checks of single arguments: ValueError in one line, `name: got VALUE; it must be ...`."""

import contextlib
import math
import os
import sys
from numbers import Real
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


def check_whole(name: str, value: Any, low: int, high: int) -> int:
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
