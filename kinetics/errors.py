"""The one exception for bad input and the one warning; checks are in `kinetics.validation`."""

from __future__ import annotations

import warnings
from typing import Any


class InputError(ValueError):
    """An argument that cannot be used: its name, its value and what is allowed, in one line."""


class ToleranceWarning(UserWarning):
    """A figure that carries no status of its own misses the relative tolerance asked for."""


def warn_missed(what: str, error: float, rtol: float) -> None:
    """Warn that a figure misses its tolerance, at the line that called a method of a Solution."""
    text = f"{what}: the error estimate {error:.1e} exceeds rtol = {rtol:.1e}; raise rtol"
    warnings.warn(text, ToleranceWarning, stacklevel=4)


def short(value: Any, limit: int = 60) -> str:
    """The repr of a bad value, cut so that a message stays on one line."""
    if isinstance(value, str | bytes | list | tuple) and len(value) > limit:
        value = value[:limit]  # each part takes a character at least: what follows is cut anyway
    try:
        text = " ".join(repr(value).split())
    except Exception:  # whole numbers of more than 4300 digits, and anything whose own repr fails
        return f"a {type(value).__name__} that has no short text"
    return text if len(text) <= limit else text[: limit - 3] + "..."
