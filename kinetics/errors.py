"""How things end: bad input, a missed tolerance, and the plan and status of a solve. No NumPy."""

from __future__ import annotations

import enum
import warnings
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

#: Largest rtol that can be requested.
MAX_RTOL = 0.1
#: The rtol that is advised is so many times the error estimate.
ADVISED_RTOL_OVER_ERROR = 1.1
#: How similar a name must be to a known one to be suggested: 0 is any, 1 the same. Chosen: one or
#: two wrong letters of a word.
SIMILAR = 0.7
#: Characters of a bad value that a message shows.
MAX_CHARACTERS = 60
#: What a function that a user gives may raise if it cannot be used; memory may be lacking anywhere.
ERRORS_OF_FUNCTIONS = (
    ArithmeticError,
    AttributeError,
    LookupError,
    NameError,
    TypeError,
    ValueError,
)


class InputError(ValueError):
    """An argument that cannot be used: its name, its value and what is allowed, in one line."""


class ToleranceWarning(UserWarning):
    """A figure misses the relative tolerance asked for."""


class ModelWarning(UserWarning):
    """The equation itself is used where it is known to be far off, whatever the solver's error."""


def warn_missed(what: str, error: float, rtol: float) -> None:
    """Warn that a figure misses its tolerance, at the line that called a method of a Solution."""
    text = f"{what}: the error estimate {error:.1e} exceeds rtol = {rtol:.1e}; raise rtol"
    warnings.warn(text, ToleranceWarning, stacklevel=4)


def short(value: Any, limit: int = MAX_CHARACTERS) -> str:
    """The repr of a bad value, cut so that a message stays on one line."""
    if isinstance(value, str | bytes | list | tuple) and len(value) > limit:
        value = value[:limit]  # each part takes a character at least: what follows is cut anyway
    try:
        text = " ".join(repr(value).split())
    except Exception:  # whole numbers of more than 4300 digits, and anything whose own repr fails
        return f"a {type(value).__name__} that has no short text"
    return text if len(text) <= limit else text[: limit - 3] + "..."


def printable(text: object) -> str:
    """Return a text, such as a file's name, without signs that command a terminal."""
    return "".join(sign if sign.isprintable() else "?" for sign in str(text))


def suggestion(name: object, known: Iterable[str], aliases: Mapping[str, str] = {}) -> str:
    """Return "; did you mean 'msd'?" for a name that is nearly a known one; else an empty text.

    Parameters
    ----------
    name : that is not known
    known : names that are
    aliases : other names that people use, in lower case, and the known ones
    """
    import difflib

    text = str(name).strip().lower().replace("-", "_").replace(" ", "_")
    if text in aliases:
        return f"; did you mean {aliases[text]!r}?"
    by_text = {each.lower().replace(" ", "_"): each for each in known}
    matches = difflib.get_close_matches(text, by_text, n=1, cutoff=SIMILAR)
    return f"; did you mean {by_text[matches[0]]!r}?" if matches else ""


@dataclass(frozen=True)
class PlanStep:
    """One part of the work: what, whether it was done, and why."""

    part: str
    solved: bool
    reason: str


class SolverStatus(enum.Enum):
    """How a solve ended; the text of each says which argument to change, and in which direction."""

    CONVERGED = "the error estimate meets rtol"
    TOLERANCE_NOT_REACHED = (
        "the error estimate exceeds rtol: raise rtol; where nodes was given, "
        "give more nodes or leave it out"
    )


def judge_errors(
    errors: Mapping[str, float], tolerance: Mapping[str, float], nodes: int | None = None
) -> tuple[SolverStatus, str]:
    """Return the status, and a sentence: which parts miss their tolerance, and what to change.

    Parameters
    ----------
    errors : error estimates, by part of the result; one that is not a number has not converged
    tolerance : the largest error estimate that counts as converged, by part
    nodes : the number of nodes that the user gave; None where the solver chose it
    """
    missed = [name for name, error in errors.items() if not error <= tolerance[name]]
    if not missed:
        return SolverStatus.CONVERGED, SolverStatus.CONVERGED.value
    figures = ", ".join(
        f"{name}: {errors[name]:.1e} against {tolerance[name]:.1e}" for name in missed
    )
    advice = []
    advised_rtol = ADVISED_RTOL_OVER_ERROR * max(errors[name] for name in missed)
    if advised_rtol <= MAX_RTOL:
        advice.append(f"raise rtol to {advised_rtol:.1e}")
    if nodes is not None:
        advice.append(f"give more nodes than {nodes}, or leave nodes out")
    what_to_do = ", or ".join(advice) or "ask for other times or outputs"
    message = f"the error estimate exceeds what was asked for ({figures}): {what_to_do}"
    return SolverStatus.TOLERANCE_NOT_REACHED, message
