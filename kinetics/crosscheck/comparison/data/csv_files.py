"""Comma-separated values, parsed by pyarrow in blocks of whole lines.

pyarrow rounds every number correctly, so that a double that was written with 17 digits comes back
to its last bit. It knows neither remarks nor line numbers; both are added here.
"""

import csv
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from pyarrow import csv as arrow_csv

from kinetics.crosscheck.comparison.data.columns import (
    LABELS,
    NUMBERS,
    Progress,
    Rows,
    find_columns,
    first_not_finite,
    shown,
)
from kinetics.errors import InputError, short

BLOCK = 8 << 20
"""Bytes that are parsed at once: some 1e5 rows, so that memory stays small."""
_LONGEST_LINE = 1 << 20
_SEPARATORS = ",;\t"
_REMARK = re.compile(rb"^[ \t\r]*(#.*)?$", re.MULTILINE)
_WHOLE = re.compile(r"[+-]?[0-9]{1,19}")
_WHOLE_AS_FLOAT = re.compile(r"[+-]?[0-9]+\.[0-9]*([eE][+-]?0?[0-9])?")  # numpy.savetxt's 1.0e+01
_FIRST_TEXT = 2**62
"""Texts are numbered from here on; whole numbers below are labels as they stand."""


def read(path: Path, progress: Progress) -> Iterator[Rows]:
    """The rows of a file whose first line names its columns.

    Separated by commas, semicolons or tabs, whichever the first line has; blank lines and lines
    that begin with # are passed over.
    """
    size = max(path.stat().st_size, 1)
    with open(path, "rb") as file:
        header, line = "", 1
        while not header:
            raw = file.readline(_LONGEST_LINE)
            if not raw:
                raise InputError(f"{shown(path)}: is empty; its first line must name the columns")
            header = _header(path, raw)
            line += 1
        table = _Table(path, header)
        rest = b""
        while block := file.read(BLOCK):
            # Only whole lines are parsed; what is behind the last of them waits for its end.
            cut = block.rfind(b"\n") + 1
            if cut == 0:
                rest += block
                if len(rest) > BLOCK + _LONGEST_LINE:
                    raise InputError(f"{shown(path)}: line {line} is longer than a megabyte")
                continue
            text = rest + block[:cut]
            rest = block[cut:]
            yield table.rows(text, line)
            line += text.count(b"\n")
            progress(file.tell() / size)
        if rest.strip():
            yield table.rows(rest, line)


def _header(path: Path, raw: bytes) -> str:
    try:
        text = raw.decode("utf-8-sig").strip()
    except UnicodeDecodeError:
        raise InputError(f"{shown(path)}: is not text in UTF-8") from None
    # numpy.savetxt writes the names behind a #.
    bare = text.lstrip("#").strip()
    return "" if text.startswith("#") and "time" not in bare.lower() else bare


class _Table:
    """Turns the lines of one file into rows; remembers the labels that are texts."""

    def __init__(self, path: Path, header: str) -> None:
        self._path = path
        self._separator = max(_SEPARATORS, key=header.count)
        names = header.split(self._separator)
        self._width = len(names)
        self._found = find_columns(path, names)
        self._labels = [name for name in LABELS if name in self._found]
        self._columns = [str(k) for k in range(len(names))]
        for name, place in self._found.items():
            self._columns[place] = name
        self._numbered = True  # every label so far is a whole number
        self._texts: dict[str, int] = {}

    def rows(self, text: bytes, line: int) -> Rows:
        """The rows of whole lines, of which the first is this line of the file."""
        rows = None if b"#" in text else self._parsed(text)
        if rows is None:
            rows = self._parsed(_REMARK.sub(b"", text))
        if rows is None and self._numbered:
            self._numbered = False
            rows = self._parsed(_REMARK.sub(b"", text))
        if rows is None or first_not_finite(rows) is not None:
            raise self._fault(text, line)
        return rows

    def _parsed(self, text: bytes) -> Rows | None:
        """The rows; None where a line or a number cannot be read, or a label not as a number."""
        if not text or text.isspace():
            none, labels = np.empty(0), dict.fromkeys(self._labels, np.empty(0, np.int64))
            return Rows(none, none, none, none, none, labels.get("tracer"), labels.get("medium"))
        label = pa.int64() if self._numbered else pa.dictionary(pa.int32(), pa.string())
        kinds = dict.fromkeys(NUMBERS, pa.float64()) | dict.fromkeys(self._labels, label)
        try:
            table = arrow_csv.read_csv(
                pa.BufferReader(text),
                arrow_csv.ReadOptions(column_names=self._columns),
                arrow_csv.ParseOptions(delimiter=self._separator),
                arrow_csv.ConvertOptions(
                    column_types=kinds, include_columns=list(kinds), null_values=[]
                ),
            )
        except pa.ArrowInvalid:
            return None
        labels = {name: self._label_numbers(table.column(name)) for name in self._labels}
        if self._numbered and any(np.any(np.abs(v) >= _FIRST_TEXT) for v in labels.values()):
            return None
        time, x, y, vx, vy = (_values(table.column(name)) for name in NUMBERS)
        return Rows(time, x, y, vx, vy, labels.get("tracer"), labels.get("medium"))

    def _label_numbers(self, column: Any) -> Any:
        """A column of labels as whole numbers, (n,)."""
        if self._numbered:
            return _values(column)
        parts = [
            np.array([self._number(text) for text in chunk.dictionary.to_pylist()], np.int64)[
                np.from_dlpack(chunk.indices)
            ]
            for chunk in column.chunks
        ]
        return np.concatenate(parts)

    def _number(self, text: str) -> int:
        """A whole number, however it is written, as itself; other texts are counted."""
        text = text.strip().strip('"').strip()
        if _WHOLE.fullmatch(text) and abs(int(text)) < _FIRST_TEXT:
            return int(text)
        if _WHOLE_AS_FLOAT.fullmatch(text) and float(text).is_integer():
            return int(float(text))
        return self._texts.setdefault(text, _FIRST_TEXT + len(self._texts))

    def _fault(self, text: bytes, line: int) -> InputError:
        """What is wrong with these lines: the first line, and the column, that cannot be read."""
        where = shown(self._path)
        for number, content in enumerate(text.decode("utf-8", "replace").split("\n"), line):
            if not content.strip() or content.lstrip().startswith("#"):
                continue
            try:
                cells = next(csv.reader([content], delimiter=self._separator))
            except csv.Error:
                break
            if len(cells) != self._width:
                return InputError(
                    f"{where}: line {number} has {len(cells)} columns; "
                    f"{self._width} are named in the first line"
                )
            for name in NUMBERS:
                fault = _number_fault(cells[self._found[name]].strip())
                if fault:
                    return InputError(f"{where}: line {number}, column {name!r}{fault}")
        return InputError(f"{where}: is not readable from line {line} on (quotes, or not UTF-8)")


def _values(column: Any) -> Any:
    """A column of numbers as an array, (n,); pyarrow's own to_numpy imports pandas."""
    return np.concatenate([np.from_dlpack(chunk) for chunk in column.chunks])


def _number_fault(cell: str) -> str:
    """What is wrong with the text of a number; empty if nothing is."""
    if not cell:
        return " is empty"
    try:
        value = float("" if "_" in cell else cell)
    except ValueError:
        return f": {short(cell)} is not a number"
    return "" if np.isfinite(value) else f": {short(cell)} is not a finite number"
