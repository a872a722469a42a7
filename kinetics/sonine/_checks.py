"""Checks of array arguments, shared by the printed formulas: one clear line each."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics.errors import InputError, short

Array = NDArray[np.float64]


def _numbers(name: str, value: ArrayLike, allowed: str) -> Array:
    try:
        array = np.asarray(value)
        if array.dtype.kind not in "iuf":
            raise TypeError
    except (TypeError, ValueError):
        raise InputError(f"{name}: got {short(value)}; {allowed}") from None
    return array.astype(float)


def restitutions(value: ArrayLike) -> Array:
    """e in [0, 1], any shape."""
    allowed = "it must be numbers from 0 to 1 (elastic)"
    array = _numbers("restitution", value, allowed)
    if not np.all((array >= 0.0) & (array <= 1.0)):
        raise InputError(f"restitution: got {short(value)}; {allowed}")
    return array


def not_negative(name: str, value: ArrayLike) -> Array:
    """Finite numbers, none below zero, any shape."""
    allowed = "it must be finite numbers, not negative"
    array = _numbers(name, value, allowed)
    if not np.all((array >= 0.0) & (array < np.inf)):
        raise InputError(f"{name}: got {short(value)}; {allowed}")
    return array


def positive(name: str, value: ArrayLike) -> Array:
    """Finite numbers above zero, any shape."""
    allowed = "it must be finite numbers above 0"
    array = _numbers(name, value, allowed)
    if not np.all((array > 0.0) & (array < np.inf)):
        raise InputError(f"{name}: got {short(value)}; {allowed}")
    return array


def real(name: str, value: ArrayLike) -> Array:
    """Real numbers of any size and shape; NaN stands for what an approximation does not have."""
    return _numbers(name, value, "it must be real numbers")


def whole(name: str, value: Any, low: int, high: int) -> int:
    """An int from low to high."""
    if (
        isinstance(value, bool)
        or not isinstance(value, int | np.integer)
        or not low <= value <= high
    ):
        raise InputError(
            f"{name}: got {short(value)}; it must be a whole number from {low} to {high}"
        )
    return int(value)
