"""Values: an argument is checked when it comes in, a result frozen when it is made.

What is refused is a ValueError in one line, `name: got VALUE; it must be ...` (`refuse`). Frozen
dataclasses that hold arrays derive from `Value`.
"""

import contextlib
import difflib
import math
import os
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields
from html import escape
from importlib.metadata import PackageNotFoundError, version
from numbers import Real
from pathlib import Path
from types import MappingProxyType
from typing import NoReturn, TypeGuard

import numpy as np

#: How similar a name must be to a known one to be suggested: 0 is any, 1 the same. Chosen: one or
#: two wrong letters of a word.
SIMILAR = 0.7
#: Smallest positive double.
SMALLEST_FLOAT = 5e-324
#: Largest whole number that is accepted where there is no other limit, one that an integer of 64
#: bits holds. The origin of the number is not recorded.
LARGEST_WHOLE = 2**62
#: Characters of a value that a message shows. The origin of the number is not recorded.
SHOWN_CHARACTERS = 60
#: Characters of a path that a message shows, its last ones. The origin of the number is not
#: recorded.
SHOWN_PATH = 200


# -- refusing --------------------------------------------------------------------------------------


def short(value: object, limit: int = SHOWN_CHARACTERS) -> str:
    """Return the repr of a value on one line, cut to `limit` characters."""
    try:
        text = " ".join(repr(value).split())
    except Exception:  # an int of more digits than Python writes out; a repr that fails
        text = f"<{type(value).__name__}>"
    if len(text) <= limit:
        return text
    return text[: limit - 3] + "..."


def shown_path(path: object) -> str:
    """Return a path for a message: on one line, and without what would command a terminal."""
    text = os.fsdecode(path) if isinstance(path, bytes) else str(path)
    printable = "".join(sign if sign.isprintable() else "?" for sign in text)
    return printable[-SHOWN_PATH:]


def refuse(name: str, value: object, allowed: str) -> NoReturn:
    """Raise ValueError for the argument of this name and value; `allowed`: what it must be."""
    raise ValueError(f"{name}: got {short(value)}; {allowed}") from None


def suggest(name: object, known: Iterable[str], aliases: Mapping[str, str] = {}) -> str:
    """Return "; did you mean 'msd'?" for a name that is nearly a known one, or another word for it.

    Empty where there is none. aliases: other words, in lower case, and the known names.
    """
    text = str(name).strip().lower().replace("-", "_").replace(" ", "_")
    if text in aliases:
        return f"; did you mean {aliases[text]!r}?"
    names = {each.lower(): each for each in known}
    near = difflib.get_close_matches(text, names, n=1, cutoff=SIMILAR)
    return f"; did you mean {names[near[0]]!r}?" if near else ""


# -- showing ---------------------------------------------------------------------------------------


def html_table(title: str, heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table for notebooks; all of its text is escaped."""
    lines = [f"<div><b>{escape(title)}</b><table>"]
    if heads:
        lines.append("<tr>" + "".join(f"<th>{escape(head)}</th>" for head in heads) + "</tr>")
    for row in rows:
        first, *others = (escape(cell) for cell in row)
        cells = "".join(f"<td>{cell}</td>" for cell in others)
        lines.append(f'<tr><th style="text-align:left">{first}</th>{cells}</tr>')
    lines.append("</table></div>")
    return "".join(lines)


# -- checking --------------------------------------------------------------------------------------


def is_real(value: object) -> TypeGuard[Real]:
    """Tell whether this is a real number, of Python or NumPy, and no boolean."""
    return isinstance(value, Real) and not isinstance(value, bool)


def is_whole(value: object) -> TypeGuard[int]:
    """Tell whether this is a whole number, of Python or NumPy, and no boolean."""
    return isinstance(value, (int, np.integer)) and not isinstance(value, bool)


def check_number(name: str, value: object, low: float, high: float, allowed: str) -> float:
    """Return a number from low to high as a float."""
    number = math.nan
    if is_real(value):
        with contextlib.suppress(OverflowError):
            number = float(value)
    if not low <= number <= high:
        refuse(name, value, allowed)
    return number


def check_positive(name: str, value: object) -> float:
    """Return a positive finite number as a float."""
    allowed = "it must be a finite number above 0"
    return check_number(name, value, SMALLEST_FLOAT, sys.float_info.max, allowed)


def check_whole(name: str, value: object, low: int, high: int = LARGEST_WHOLE) -> int:
    """Return a whole number from low to high as an int."""
    if not is_whole(value) or not low <= value <= high:
        refuse(name, value, f"it must be a whole number from {low} to {high}")
    return int(value)


def real_array(name: str, value: object, allowed: str) -> np.ndarray:
    """Return real numbers as a new array of doubles; complex and masked ones are refused.

    Numbers that are too large for a double become infinite.
    """
    try:
        array = np.array(value)
        has_numbers = array.dtype.kind in "iuf" or all(map(is_real, array.flat))
        if not has_numbers or np.ma.is_masked(value):
            raise TypeError
        with np.errstate(over="ignore"):
            return array.astype(np.float64)
    except (TypeError, ValueError, OverflowError):
        refuse(name, value, allowed)


def check_path(name: str, value: object) -> str:
    """Return the path of a file as text."""
    text = ""
    if isinstance(value, (str, bytes, os.PathLike)):
        with contextlib.suppress(TypeError):
            text = os.fsdecode(value)
    if not text or "\0" in text:
        refuse(name, value, "it must be the path of a file")
    return text


def machine_memory() -> float:
    """Return the bytes of memory that this process may have, infinite where that is not known."""
    limits = [math.inf]
    with contextlib.suppress(AttributeError, OSError, ValueError):
        limits.append(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    with contextlib.suppress(OSError, ValueError):  # of a container
        limits.append(int(Path("/sys/fs/cgroup/memory.max").read_text()))
    with contextlib.suppress(ImportError):
        import resource

        limits.append(resource.getrlimit(resource.RLIMIT_AS)[0])  # -1 stands for no limit
    return min(limit for limit in limits if limit > 0)


def package_version() -> str:
    """Return the version that is installed."""
    try:
        return version("inelastic-lorentz")
    except PackageNotFoundError:
        return "unknown: the package is not installed"


# -- frozen values ---------------------------------------------------------------------------------


def read_only(array: np.ndarray) -> np.ndarray:
    """Return a view of an array that cannot be written to."""
    view = array.view()
    view.setflags(write=False)
    return view


def set_fields(instance: object, **values: object) -> None:
    """Set fields of a frozen dataclass while it is being made."""
    for name, value in values.items():
        object.__setattr__(instance, name, value)


def _freeze(value: object) -> object:
    """Return an array, or a dictionary of arrays, that cannot be changed; others as they are."""
    if isinstance(value, dict):
        return MappingProxyType({name: _freeze(item) for name, item in value.items()})
    if isinstance(value, np.ndarray):
        return read_only(value)
    return value


def _content(value: object) -> object:
    """Return what tells whether two values are equal, as something that has a hash."""
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
        self.__setstate__(self._fields())

    def _fields(self) -> dict[str, object]:
        """Return the value of each field, by its name."""
        return {field.name: getattr(self, field.name) for field in fields(self)}  # type: ignore[arg-type]

    def __getstate__(self) -> dict[str, object]:
        state = self._fields()
        for name, value in state.items():
            if isinstance(value, MappingProxyType):  # which cannot be pickled
                state[name] = dict(value)
        return state

    def __setstate__(self, state: Mapping[str, object]) -> None:
        for name, value in state.items():
            object.__setattr__(self, name, _freeze(value))

    def _key(self) -> tuple[object, ...]:
        return tuple(map(_content, self._fields().values()))

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and self._key() == other._key()

    def __hash__(self) -> int:
        return hash((type(self), self._key()))
