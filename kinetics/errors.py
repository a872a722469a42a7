"""The one error of bad input, the one warning, and the checks that several modules share."""

from __future__ import annotations

import math
import warnings
from typing import Any


class InputError(ValueError):
    """An argument that cannot be used: its name, its value and what is allowed, in one line."""


class ToleranceWarning(UserWarning):
    """A figure that carries no status of its own misses the relative tolerance asked for."""


def warn_missed(what: str, error: float, rtol: float) -> None:
    """Say once that a figure misses its tolerance: :class:`ToleranceWarning`."""
    text = f"{what}: the error estimate {error:.1e} exceeds rtol = {rtol:.1e}"
    warnings.warn(text, ToleranceWarning, stacklevel=5)


def short(value: Any, limit: int = 60) -> str:
    """The repr of a bad value, cut so that a message stays on one line."""
    text = " ".join(repr(value).split())
    return text if len(text) <= limit else text[: limit - 3] + "..."


def _real(name: str, value: Any, allowed: str) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise InputError(f"{name}: got {short(value)}; {allowed}") from None
    if not math.isfinite(number):
        raise InputError(f"{name}: got {short(value)}; {allowed}")
    return number


def check_restitution(value: Any) -> float:
    """The coefficient of restitution as a float in [0, 1]; :class:`InputError` otherwise."""
    allowed = "it must be a number from 0 (all normal velocity lost) to 1 (elastic)"
    number = _real("restitution", value, allowed)
    if not 0.0 <= number <= 1.0:
        raise InputError(f"restitution: got {short(value)}; {allowed}")
    return number


def check_positive(name: str, value: Any) -> float:
    """A finite float above zero; :class:`InputError` otherwise."""
    allowed = "it must be a finite number above 0"
    number = _real(name, value, allowed)
    if number <= 0.0:
        raise InputError(f"{name}: got {short(value)}; {allowed}")
    return number


def check_rtol(value: Any) -> float:
    """A relative tolerance in [1e-14, 0.1]; :class:`InputError` otherwise."""
    allowed = "it must be a number from 1e-14 to 0.1"
    number = _real("rtol", value, allowed)
    if not 1e-14 <= number <= 0.1:
        raise InputError(f"rtol: got {short(value)}; {allowed}")
    return number
