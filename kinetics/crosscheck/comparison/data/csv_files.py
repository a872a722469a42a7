"""Comma-separated values, in pieces.

The parser is compiled: 1e7 rows of seven columns are some 500 MB of text, for which NumPy's reader
takes most of a minute. A number of up to 15 digits comes out correctly rounded (Clinger, "How to
read floating point numbers accurately", 1990), a longer one within two units in the last place.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numba import njit

from kinetics.crosscheck.comparison.data.columns import (
    LABELS,
    NUMBERS,
    Progress,
    Rows,
    find_columns,
    shown,
)
from kinetics.errors import InputError, short

_BLOCK = 8 << 20
_LONGEST_LINE = 1 << 20
_SEPARATORS = ",;\t"
_TEN = np.array([float(f"1e{k}") for k in range(309)])
_GOOD, _SHORT_ROW, _NOT_A_NUMBER, _NOT_FINITE, _EMPTY = range(5)
_COMPLAINTS = {
    _NOT_A_NUMBER: "is not a number",
    _NOT_FINITE: "is not a finite number",
    _EMPTY: "is empty",
}


@njit(cache=True, nogil=True, error_model="numpy")
def _parse_number(text: Any, start: int, end: int, ten: Any) -> Any:
    """(value, status) of the characters from start to end."""
    while start < end and text[start] == 32:
        start += 1
    while end > start and (text[end - 1] == 32 or text[end - 1] == 13):
        end -= 1
    if start == end:
        return 0.0, _EMPTY
    i = start
    negative = text[i] == 45
    if negative or text[i] == 43:
        i += 1
    mantissa = np.uint64(0)
    digits, kept, exponent = 0, 0, 0
    point = False
    while i < end:
        c = text[i]
        if 48 <= c <= 57:
            digits += 1
            if kept < 18:
                mantissa = mantissa * np.uint64(10) + np.uint64(c - 48)
                if mantissa:
                    kept += 1
                exponent -= point
            else:
                exponent += not point
        elif c == 46 and not point:
            point = True
        else:
            break
        i += 1
    if digits == 0:
        # nan, inf, infinity in any case are numbers, but not finite ones
        first = text[i] | 32 if i < end else 0
        length = end - i
        word = (first == 110 and length == 3) or (first == 105 and (length == 3 or length == 8))
        return 0.0, _NOT_FINITE if word else _NOT_A_NUMBER
    if i < end and (text[i] == 101 or text[i] == 69):
        i += 1
        less = i < end and text[i] == 45
        if i < end and (less or text[i] == 43):
            i += 1
        if i == end:
            return 0.0, _NOT_A_NUMBER
        power = 0
        while i < end and 48 <= text[i] <= 57:
            power = min(power * 10 + (text[i] - 48), 100_000)
            i += 1
        exponent += -power if less else power
    if i < end:
        return 0.0, _NOT_A_NUMBER
    value = float(mantissa)
    if mantissa:
        if exponent > 308:
            return 0.0, _NOT_FINITE
        if exponent >= 0:
            value *= ten[exponent]
        elif exponent >= -308:
            value /= ten[-exponent]
        else:
            value = value / ten[308] / ten[min(-exponent - 308, 308)]
    if value > 1.7976931348623157e308:
        return 0.0, _NOT_FINITE
    return (-value if negative else value), _GOOD


@njit(cache=True, nogil=True)
def _parse_label(text: Any, start: int, end: int) -> Any:
    """A whole number as itself, any other text by its FNV-1a hash."""
    while start < end and (text[start] == 32 or text[start] == 34):
        start += 1
    while end > start and (text[end - 1] == 32 or text[end - 1] == 13 or text[end - 1] == 34):
        end -= 1
    i = start
    negative = i < end and text[i] == 45
    if negative:
        i += 1
    value = np.int64(0)
    whole = 0 < end - i <= 18
    for k in range(i, end):
        if not 48 <= text[k] <= 57:
            whole = False
            break
        value = value * 10 + np.int64(text[k] - 48)
    if whole:
        return -value if negative else value
    found = np.uint64(14695981039346656037)
    for k in range(start, end):
        found = (found ^ np.uint64(text[k])) * np.uint64(1099511628211)
    return np.int64(found)


@njit(cache=True, nogil=True)
def _parse(
    text: Any, size: int, separator: int, places: Any, ten: Any, numbers: Any, labels: Any
) -> Any:
    """Parse whole lines into numbers (n, 5) and labels (n, 2).

    places[c] says where column c goes: 0 to 4 a number, 5 and 6 a label, -1 nowhere. Returns the
    rows and lines read, and at a fault its status, column and the place of its text.
    """
    columns = places.size
    i, row, line = 0, 0, 0
    while i < size:
        first = i
        while first < size and (text[first] == 32 or text[first] == 13):
            first += 1
        if first >= size or text[first] == 10 or text[first] == 35:  # a blank line or a remark
            while i < size and text[i] != 10:
                i += 1
            i += 1
            line += 1
            continue
        column = 0
        last = False
        while not last:
            start = i
            if i < size and text[i] == 34:
                i += 1
                while i < size and text[i] != 34 and text[i] != 10:
                    i += 1
            while i < size and text[i] != separator and text[i] != 10:
                i += 1
            last = i >= size or text[i] == 10
            place = places[column] if column < columns else -1
            if 0 <= place < 5:
                value, status = _parse_number(text, start, i, ten)
                if status:
                    return row, line, status, column, start, i
                numbers[place, row] = value
            elif place >= 5:
                labels[place - 5, row] = _parse_label(text, start, i)
            column += 1
            i += 1
        if column < columns:
            return row, line, _SHORT_ROW, column, start, min(i, size)
        row += 1
        line += 1
    return row, line, _GOOD, 0, 0, 0


def read(path: Path, progress: Progress) -> Iterator[Rows]:
    """The rows of a file whose first line names its columns.

    Separated by commas, semicolons or tabs, whichever the first line has; blank lines and lines
    that begin with # are passed over.
    """
    size = max(path.stat().st_size, 1)
    with open(path, "rb") as file:
        header, lines = "", 0
        while not header:
            raw = file.readline(_LONGEST_LINE)
            if not raw:
                raise InputError(f"{shown(path)}: is empty; its first line must name the columns")
            lines += 1
            header = _header(path, raw)
        separator = max(_SEPARATORS, key=header.count)
        names = header.split(separator)
        found = find_columns(path, names)
        places = np.full(max(found.values()) + 1, -1, np.int64)
        for place, name in enumerate((*NUMBERS, *LABELS)):
            if name in found:
                places[found[name]] = place
        rest = b""
        while block := file.read(_BLOCK):
            # Only whole lines are parsed; what is behind the last of them waits for its end.
            cut = block.rfind(b"\n") + 1
            if cut == 0:
                rest += block
                if len(rest) > _BLOCK + _LONGEST_LINE:
                    raise InputError(f"{shown(path)}: line {lines + 1} is longer than a megabyte")
                continue
            text = rest + block[:cut]
            rest = block[cut:]
            rows, lines = _rows(path, text, ord(separator), places, found, names, lines)
            yield rows
            progress(file.tell() / size)
        if rest.strip():
            yield _rows(path, rest, ord(separator), places, found, names, lines)[0]


def _header(path: Path, raw: bytes) -> str:
    try:
        text = raw.decode("utf-8-sig").strip()
    except UnicodeDecodeError:
        raise InputError(f"{shown(path)}: is not text in UTF-8") from None
    # NumPy writes the names behind a #.
    bare = text.lstrip("#").strip()
    return "" if text.startswith("#") and "time" not in bare.lower() else bare


def _rows(
    path: Path, text: bytes, separator: int, places: Any, found: Any, names: Any, lines: int
) -> tuple[Rows, int]:
    """The rows of whole lines, and the number of lines of the file until their end."""
    data = np.frombuffer(text, np.uint8)
    most = text.count(b"\n") + 1
    numbers, labels = np.empty((5, most)), np.empty((2, most), np.int64)
    n, done, status, column, start, end = _parse(
        data, data.size, separator, places, _TEN, numbers, labels
    )
    if status == _SHORT_ROW:
        raise InputError(
            f"{shown(path)}: line {lines + done + 1} has {column} columns; "
            f"{len(names)} are named in the first line"
        )
    if status:
        name = names[column].strip()
        value = short(text[start:end].decode("utf-8", "replace").strip())
        what = f"{name!r} is empty" if status == _EMPTY else f"{name!r}: {value} "
        what += "" if status == _EMPTY else _COMPLAINTS[status]
        raise InputError(f"{shown(path)}: line {lines + done + 1}, column {what}")
    parts = {name: labels[k, :n] for k, name in enumerate(LABELS) if name in found}
    time, x, y, vx, vy = numbers[:, :n]
    return Rows(time, x, y, vx, vy, parts.get("tracer"), parts.get("medium")), lines + done
