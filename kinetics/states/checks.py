"""Checks of the arguments of initial states. All raise InputError with one line."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics.errors import InputError, short

FloatArray = NDArray[np.float64]

_NORM = 1e-6  # how far the integral of a given density may be from 1; it is rescaled to 1


def finite_array(
    name: str, values: ArrayLike, shape: str = "1-dimensional", dimensions: int = 1
) -> FloatArray:
    """A read-only copy of the values as finite real numbers in an array of so many dimensions.

    ``shape`` says in the message what is allowed. Complex and masked values are refused.
    """
    try:
        array = np.asarray(values)
        if array.dtype.kind == "c" or np.ma.is_masked(values):
            raise TypeError
        array = array.astype(float)
    except (TypeError, ValueError):
        raise InputError(f"{name}: got {short(values)}; it must be an array of numbers") from None
    if array.ndim != dimensions or not np.all(np.isfinite(array)):
        raise InputError(f"{name}: got {short(values)}; it must be finite, {shape}")
    array.flags.writeable = False
    return array


def rising_speeds(speed: ArrayLike) -> FloatArray:
    """At least two speeds that rise, the first of them 0 or more, shape (n,)."""
    v = finite_array("speed", speed)
    if v.size < 2 or np.any(np.diff(v) <= 0.0) or v[0] < 0.0:
        raise InputError(f"speed: got {short(speed)}; it must rise, from 0 or more, 2 at least")
    return v


def not_negative(f: NDArray[Any], name: str = "density") -> None:
    """Refuse a density that is negative anywhere."""
    if f.size and float(f.min()) < 0.0:
        raise InputError(f"{name}: got a value of {f.min():.3g}; it must not be negative")


def check_norm(total: float, name: str = "density") -> float:
    """The integral of a density, if it is 1 within 1e-6."""
    if not abs(total - 1.0) < _NORM:
        narrow = "; a peak narrower than a percent needs a SpeedTable" if total < 0.5 else ""
        raise InputError(
            f"{name}: its integral over the velocities is {total:.6g}; it must be 1{narrow}"
        )
    return total
