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
    Asked,
    Averages,
    Rows,
    find_columns,
    first_not_finite,
    piece_of,
    shown,
    split_unit,
    stated_units,
)
from kinetics.errors import InputError, short

BLOCK = 8 << 20
"""Bytes that are parsed at once: some 1e5 rows, so that memory stays small."""
_LONGEST_LINE = 1 << 20
_SEPARATORS = ",;\t"
_REMARK = re.compile(rb"^[ \t\r]*(#.*)?$", re.MULTILINE)
_WHOLE = re.compile(r"[+-]?[0-9]{1,19}")
_WHOLE_AS_FLOAT = re.compile(r"[+-]?[0-9]+\.[0-9]*([eE][+-]?0?[0-9])?")  # numpy.savetxt's 1.0e+01
_COMMA = re.compile(r"[+-]?[0-9]+,[0-9]+([eE][+-]?[0-9]+)?")
_FIRST_TEXT = 2**62
"""Texts are numbered from here on; whole numbers below are labels as they stand."""


def read(path: Path, asked: Asked) -> Iterator[Rows | Averages]:
    """The rows of a file whose first line names its columns.

    Separated by commas, semicolons or tabs, whichever the first line has; blank lines and lines
    that begin with # are passed over.
    """
    with open(path, "rb") as file:
        header, line = "", 1
        while not header:
            raw = file.readline(_LONGEST_LINE)
            if not raw:
                raise InputError(f"{shown(path)}: is empty; its first line must name the columns")
            header = _header(path, raw)
            line += 1
        table = _Table(path, header, asked)
        while text := file.read(BLOCK):
            end = file.readline(_LONGEST_LINE)  # only whole lines are parsed
            if len(end) == _LONGEST_LINE:
                raise InputError(f"{shown(path)}: has a line that is longer than a megabyte")
            yield table.rows(text + end, line)
            line += (text + end).count(b"\n")


def _header(path: Path, raw: bytes) -> str:
    try:
        text = raw.decode("utf-8-sig").strip()
    except UnicodeDecodeError:
        raise InputError(f"{shown(path)}: is not text in UTF-8") from None
    # numpy.savetxt writes the names behind a #.
    bare = text.lstrip("#").strip()
    return "" if text.startswith("#") and not _names_columns(bare) else bare


def _names_columns(text: str) -> bool:
    """Whether a line behind a # names the columns: it has a name of the time, and several words."""
    words = re.split(r"[\s,;\"']+", text.lower())
    return "time" in words or ("t" in words and len(words) > 4)


class _Table:
    """Turns the lines of one file into rows; remembers the labels that are texts."""

    def __init__(self, path: Path, header: str, asked: Asked) -> None:
        self._path = path
        self._separator = max(_SEPARATORS, key=header.count)
        names = header.split(self._separator)
        if all(_number_fault(name.strip()) == "" for name in names):
            raise InputError(
                f"{shown(path)}: has no header; its first line must name the columns, like "
                "time,tracer,x,y,vx,vy"
            )
        self._found = find_columns(path, names, asked)
        units = {name: split_unit(names[k])[1] for name, k in self._found.items()}
        self._units = stated_units(path, units)
        known = {place: name for name, place in self._found.items()}
        self._columns = [known.get(k, str(k)) for k in range(len(names))]
        self._numbered = True  # every label so far is a whole number
        self._texts: dict[str, int] = {}

    def rows(self, text: bytes, line: int) -> Rows | Averages:
        """The rows of whole lines, of which the first is this line of the file."""
        values = None if b"#" in text else self._parsed(text)
        if values is None:
            values = self._parsed(_REMARK.sub(b"", text))
        if values is None and self._numbered:
            self._numbered = False
            values = self._parsed(_REMARK.sub(b"", text))
        if values is None or first_not_finite(values) is not None:
            raise self._fault(text, line)
        return piece_of(values, self._units)

    def _parsed(self, text: bytes) -> dict[str, Any] | None:
        """The columns; None where a line or a number cannot be read, or a label not as a number."""
        label = pa.int64() if self._numbered else pa.dictionary(pa.int32(), pa.string())
        kinds = {name: label if name in LABELS else pa.float64() for name in self._found}
        if not text or text.isspace():
            return dict.fromkeys(kinds, np.empty(0, np.int64))
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
        values: dict[str, Any] = {}
        for name in kinds:
            chunks, is_text = table.column(name).chunks, name in LABELS and not self._numbered
            # pyarrow's own to_numpy imports pandas.
            read = self._label_numbers if is_text else np.from_dlpack
            values[name] = np.concatenate([read(chunk) for chunk in chunks])
            if name in LABELS and self._numbered and np.any(np.abs(values[name]) >= _FIRST_TEXT):
                return None
        return values

    def _label_numbers(self, chunk: Any) -> Any:
        """Labels that are texts, with a dictionary, as whole numbers, (n,)."""
        numbers = [self._number(text) for text in chunk.dictionary.to_pylist()]
        return np.array(numbers, np.int64)[np.from_dlpack(chunk.indices)]

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
            if len(cells) != len(self._columns):
                return InputError(
                    f"{where}: line {number} has {len(cells)} columns; "
                    f"{len(self._columns)} are named in the first line"
                )
            for name in (name for name in self._found if name not in LABELS):
                fault = _number_fault(cells[self._found[name]].strip())
                if fault:
                    return InputError(f"{where}: line {number}, column {name!r}{fault}")
        return InputError(f"{where}: is not readable from line {line} on (quotes, or not UTF-8)")


def _number_fault(cell: str) -> str:
    """What is wrong with the text of a number; empty if nothing is."""
    if not cell:
        return " is empty"
    try:
        value = float("" if "_" in cell else cell)
    except ValueError:
        comma = "; numbers must have a decimal point, not a comma" if _COMMA.fullmatch(cell) else ""
        return f": {short(cell)} is not a number{comma}"
    return "" if np.isfinite(value) else f": {short(cell)} is not a finite number"
