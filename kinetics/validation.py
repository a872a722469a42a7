"""Checks of arguments. All raise InputError with one line, `name: got VALUE; what is allowed`.

Each returns the argument as the type that the callers work with. Arrays are read-only copies.
"""

from __future__ import annotations

import contextlib
import math
import sys
from collections.abc import Iterable
from numbers import Real
from typing import Any, NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics.errors import InputError, short, suggestion

Array = NDArray[np.float64]

#: Most angular harmonics that can be requested. Chosen: each takes about 10 MB and 0.1 s.
MAX_HARMONICS = 256
#: Least mass of a scatterer over that of the tracer: lighter ones hardly change its velocity.
MIN_MASS_RATIO = 1e-6
#: Relative error of the integral of a density over the velocities; it must be 1.
NORM_TOLERANCE = 1e-6
_LARGEST = sys.float_info.max
_LINE = "it must be a finite, 1-dimensional array of numbers"


def refuse(name: str, value: Any, allowed: str) -> NoReturn:
    """Raise InputError for the argument of this name and value."""
    raise InputError(f"{name}: got {short(value)}; {allowed}")


def real_number(
    name: str, value: Any, low: float = -math.inf, high: float = math.inf, allowed: str = ""
) -> float:
    """A finite number from low to high, as a float: any real number but a boolean, no text."""
    if type(value) is np.ndarray and value.ndim == 0:
        value = value[()]
    if isinstance(value, Real) and not isinstance(value, bool | np.bool_):
        with contextlib.suppress(OverflowError):
            number = float(value)
            if math.isfinite(number) and low <= number <= high:
                return number
    refuse(name, value, allowed or f"it must be a number from {low:g} to {high:g}")


def check_restitution(value: Any) -> float:
    """The coefficient of restitution, a number from 0 to 1."""
    allowed = "it must be a number from 0 (all normal velocity lost) to 1 (elastic)"
    if isinstance(value, list | np.ndarray) and np.ndim(value) == 1:
        allowed += "; for several of them call kinetics.sweep"
    return real_number("restitution", value, 0.0, 1.0, allowed)


def check_mass_ratio(value: Any) -> float:
    """The mass of a scatterer over that of the tracer: a number, or inf."""
    if isinstance(value, float | np.floating) and value == math.inf:
        return math.inf
    allowed = f"it must be a number, {MIN_MASS_RATIO:g} or more, or inf (fixed scatterers)"
    return real_number("mass_ratio", value, MIN_MASS_RATIO, math.inf, allowed)


def check_positive(name: str, value: Any) -> float:
    """A finite number above zero."""
    return real_number(name, value, math.ulp(0.0), math.inf, "it must be a finite number above 0")


def check_rtol(value: Any) -> float:
    """A relative tolerance, a number from 1e-14 to 0.1."""
    return real_number("rtol", value, 1e-14, 0.1)


def whole_number(name: str, value: Any, low: int, high: int) -> int:
    """An int from low to high; True and 2.0 are refused."""
    whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
    if not whole or not low <= value <= high:
        refuse(name, value, f"it must be a whole number from {low} to {high}")
    return int(value)


def check_flag(name: str, value: Any) -> bool:
    """True or False, of Python or NumPy; no number and no text, as "no" would count as true."""
    if not isinstance(value, bool | np.bool_):
        refuse(name, value, "it must be True or False")
    return bool(value)


def one_of(name: str, value: Any, names: Iterable[str]) -> str:
    """One of these names."""
    allowed = list(names)
    if not isinstance(value, str) or value not in allowed:
        refuse(name, value, f"it must be one of {', '.join(allowed)}{suggestion(value, allowed)}")
    return value


def number_array(name: str, value: ArrayLike, kinds: str, allowed: str) -> NDArray[Any]:
    """Numbers of any shape, float or complex, of these kinds of dtypes; NaN is let in."""
    with contextlib.suppress(OverflowError, TypeError, ValueError):
        array = np.asarray(value)
        if array.dtype.kind in kinds and not np.ma.is_masked(value):
            with np.errstate(over="ignore"):  # a longer float may be out of range: infinite
                array = array.astype(complex if array.dtype.kind == "c" else float)
            array.flags.writeable = False
            return array
    refuse(name, value, allowed)


def finite_array(
    name: str,
    value: ArrayLike,
    allowed: str = _LINE,
    low: float = -_LARGEST,
    dimensions: tuple[int, ...] | None = (1,),
) -> Array:
    """Finite real numbers, none below ``low``, in an array of so many dimensions; None for any."""
    array = number_array(name, value, "biufO", allowed)
    fits = dimensions is None or array.ndim in dimensions
    if not fits or not np.all((array >= low) & (array <= _LARGEST)):
        refuse(name, value, allowed)
    return array


def finite_line(name: str, value: ArrayLike, allowed: str = _LINE, low: float = -_LARGEST) -> Array:
    """Finite real numbers, none below ``low``, of shape (n,); a single number gives n = 1."""
    return np.atleast_1d(finite_array(name, value, allowed, low, (0, 1)))


def not_negative(name: str, value: ArrayLike) -> Array:
    """Finite numbers, none below zero, in an array of any shape."""
    return finite_array(name, value, "it must be finite numbers, not negative", 0.0, None)


def not_negative_line(name: str, value: ArrayLike) -> Array:
    """At least one number, none below zero, shape (n,)."""
    allowed = "give at least one number, none negative"
    array = finite_line(name, value, allowed, 0.0)
    if array.size == 0:
        refuse(name, value, allowed)
    return array


def speeds(value: ArrayLike, *, zero_allowed: bool = True) -> Array:
    """Speeds v in U, none negative, shape (n,)."""
    if zero_allowed:
        return finite_line("v", value, "speeds must be finite, and not negative", 0.0)
    return finite_line("v", value, "speeds must be finite, and above 0 here", math.ulp(0.0))


def rising_from_zero(name: str, value: ArrayLike) -> Array:
    """At least two numbers that rise, the first of them 0 or more, shape (n,)."""
    allowed = "it must be a line of numbers that rise, from 0 or more, 2 at least"
    array = finite_array(name, value, allowed, 0.0)
    if array.size < 2 or np.any(np.diff(array) <= 0.0):
        refuse(name, value, allowed)
    return array


def normalised(density: NDArray[Any], total: float, name: str = "density") -> float:
    """The integral of a density over the velocities, if it is 1 to 1e-6 and none is negative."""
    if density.size and float(density.min()) < 0.0:
        raise InputError(f"{name}: got a value of {density.min():.3g}; it must not be negative")
    if not abs(total - 1.0) < NORM_TOLERANCE:
        what = f"its integral over the velocities is {total:.6g}; it must be 1"
        if total < 1.0:
            what += "; a peak narrower than 0.001 % needs a SpeedTable"
        raise InputError(f"{name}: {what}")
    return total
