"""Delimited text: CSV and its relatives, as programs and people write them.

The first row of numbers is looked for; the names of the columns are the line above it with as many
cells that has most names known to us, so that remarks, rows of units and the four heads of
TrackMate are passed over. pandas reads the rest.
"""

from __future__ import annotations

import codecs
import csv
import gzip
import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from kinetics.crosscheck.data.arrays import Column
from kinetics.crosscheck.data.averages import (
    AVERAGE_NAMES,
    AveragesTable,
    are_averages,
    table_of_averages,
)
from kinetics.crosscheck.data.columns import KNOWN_NAMES, LABELS, ColumnName, find_columns
from kinetics.crosscheck.data.memory import MemoryBudget, require_memory
from kinetics.crosscheck.data.options import DataOptions, refuse_data
from kinetics.crosscheck.data.table import Table, needed_columns, table_of_columns
from kinetics.errors import short

#: Bytes of a line at most: a file without line ends is no table.
MAX_LINE_BYTES = 1 << 20
#: Bytes from which the encoding is told, and that are read at once.
SAMPLE_BYTES = 1 << 16
#: Lines among which the first row of numbers must be.
MAX_HEAD_LINES = 200
#: Rows that are parsed at once at most, so that memory can be checked meanwhile.
MAX_ROWS_AT_ONCE = 200_000
#: The same at least, however long the first lines are.
MIN_ROWS_AT_ONCE = 100
#: Bytes of such rows, if later lines are as long as the first ones. Chosen: a few percent of the
#: memory of a small machine, as the parser needs several times as much.
BYTES_AT_ONCE = 32e6
#: Bytes of memory that the parser takes for a byte of text at most. Measured: 9 for columns of one
#: digit, all of which are read.
MEMORY_OF_TEXT = 9.0
#: Separators in the order in which they are tried; blanks (of any number) last.
SEPARATORS = ("\t", ";", ",")
BLANKS = r"\s+"
#: Beginnings of files that tell the encoding.
BYTE_ORDER_MARKS = {
    codecs.BOM_UTF8: "utf-8-sig",
    codecs.BOM_UTF16_LE: "utf-16",
    codecs.BOM_UTF16_BE: "utf-16",
}
#: The encoding of a file that is not UTF-8: that of Windows in Western Europe and America.
OTHER_ENCODING = "cp1252"
#: Bytes of memory for a character of text: 17 digits, a sign, a point and a comma are 8 bytes. A
#: lower bound, for a first check.
BYTES_OF_CHARACTER = 0.3
#: Characters of a line of the file that a message shows. Chosen: a message is one line.
MAX_SHOWN = 60
#: Characters of the parser's reason that a message shows. The origin is not recorded.
MAX_REASON = 150
#: Texts that say that a number is missing.
MISSING_NUMBERS = frozenset({"na", "nan", "n/a", "null", "none"})
#: A number with a decimal comma.
_DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+(e[+-]?\d+)?", re.IGNORECASE)


def read_text_table(path: Path, where: str, options: DataOptions) -> Table | AveragesTable:
    """Read a delimited text file, which may be packed by gzip."""
    require_memory(where, BYTES_OF_CHARACTER * path.stat().st_size)
    file = _TextFile.of(path, where)
    layout = _find_layout(file, options)
    if are_averages(layout.names, options):
        named = [ColumnName.of(name) for name in layout.names if name]
        columns = _read_columns(file, layout, named, options)
        return table_of_averages(where, columns, options)
    ours = find_columns(where, layout.names, options.columns, needed_columns(options))
    wanted = list(ours.values())
    columns = _read_columns(file, layout, wanted, options)
    return table_of_columns(where, columns, options)


# -- bytes and lines -------------------------------------------------------------------------------


class _LineGuard(io.RawIOBase):
    """The bytes of a file; InputError where a line is so long that it is no line of a table.

    So it is where the rows that are parsed at once are so long that they do not fit.
    """

    def __init__(self, file: io.BufferedIOBase, where: str) -> None:
        self._file = file
        self._where = where
        self._line_bytes = 0
        self._bytes_at_once = 0

    def begin_rows(self) -> None:
        """Begin to count the bytes of the rows that are parsed at once."""
        self._bytes_at_once = 0

    def close(self) -> None:
        """Close the file."""
        self._file.close()
        super().close()

    def readable(self) -> bool:
        """Return that it can be read."""
        return True

    def readinto(self, buffer: Any) -> int:
        """Read the next bytes, and count those since the last end of a line."""
        data = self._file.read(len(buffer))
        end = data.rfind(b"\n")
        if end >= 0:
            self._line_bytes = 0
        self._line_bytes += len(data) - end - 1
        if self._line_bytes > MAX_LINE_BYTES:
            refuse_data(self._where, "a line of over a million bytes", "rows of a table")
        self._bytes_at_once += len(data)
        require_memory(self._where, MEMORY_OF_TEXT * self._bytes_at_once)
        buffer[: len(data)] = data
        return len(data)


def _guarded(path: Path, where: str) -> _LineGuard:
    """Open a file, packed or not, and watch its lines."""
    if path.suffix.lower() == ".gz":
        return _LineGuard(gzip.open(path), where)
    return _LineGuard(open(path, "rb"), where)


def _first_bytes(path: Path, where: str) -> bytes:
    """Return the first bytes of a file, unpacked."""
    with io.BufferedReader(_guarded(path, where), SAMPLE_BYTES) as file:
        return file.read(SAMPLE_BYTES)


def _encoding_of(sample: bytes) -> str:
    """Return the encoding of a text file, from its first bytes."""
    for mark, encoding in BYTE_ORDER_MARKS.items():
        if sample.startswith(mark):
            return encoding
    try:
        # the last character of the sample may be cut
        codecs.getincrementaldecoder("utf-8")().decode(sample)
    except UnicodeDecodeError:
        return OTHER_ENCODING
    return "utf-8"


@dataclass(frozen=True)
class _TextFile:
    """A text file: its path, its name in messages, its first bytes, and its encoding."""

    path: Path
    where: str
    sample: bytes
    encoding: str

    @classmethod
    def of(cls, path: Path, where: str) -> _TextFile:
        """Look at the first bytes of a file, which may be packed."""
        sample = _first_bytes(path, where)
        return cls(path, where, sample, _encoding_of(sample))

    def first_lines(self) -> list[str]:
        """Return the first lines, without their ends."""
        file = io.BufferedReader(_guarded(self.path, self.where), SAMPLE_BYTES)
        with io.TextIOWrapper(file, self.encoding, errors="replace") as text:
            return [line.rstrip("\r\n") for line in islice(text, MAX_HEAD_LINES)]

    def rows_at_once(self) -> int:
        """Return how many rows are parsed at once: fewer where the first lines are long."""
        line_bytes = len(self.sample) / (self.sample.count(b"\n") + 1)
        return int(np.clip(BYTES_AT_ONCE / line_bytes, MIN_ROWS_AT_ONCE, MAX_ROWS_AT_ONCE))


# -- the layout ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Layout:
    """How a table is laid out.

    Parameters
    ----------
    separator : of cells, a regular expression for blanks
    names : of the columns, with units from a row of units
    head_lines : lines before the first row of numbers
    has_comments : whether # begins a comment, and is not part of a label
    """

    separator: str
    names: tuple[str, ...]
    head_lines: int
    has_comments: bool


def _find_layout(file: _TextFile, options: DataOptions) -> _Layout:
    """Find the first row of numbers, and the names of the columns above it."""
    head: list[str] = []
    for line in file.first_lines():
        separator = _separator_of(line, options.decimal)
        cells = _split(line, separator)
        is_comment = line.lstrip().startswith("#")
        is_row = _is_row_of_numbers(cells, options.decimal)
        is_row = is_row or _is_row_of_average(cells, head, options)
        if is_row and not is_comment:
            names = _names_above(file.where, head, separator, cells, options)
            return _Layout(separator, names, len(head), has_comments="#" not in line)
        head.append(line)
    _refuse_head(file.where, head, options)


def _refuse_head(where: str, head: Sequence[str], options: DataOptions) -> NoReturn:
    """Raise InputError for a text without any row of numbers: no rows, or unknown columns."""
    lines = [line for line in head if line.strip()]
    if not lines:
        refuse_data(where, "an empty file", "a first line that names the columns, and rows")
    for line in lines:
        cells = _split(line, _separator_of(line, ","))
        if options.decimal == "." and _is_row_of_numbers(cells, ","):
            refuse_data(where, "numbers with a decimal comma", "with a point, or say --decimal ,")
    for line in lines:
        names = _split(line.lstrip("#"), _separator_of(line, options.decimal))
        if _count_known(names, options) >= len(options.axes):
            find_columns(where, names, options.columns, ("time", *needed_columns(options)))
            refuse_data(where, "no rows of numbers", "two at least")
    first_line = short(lines[0], MAX_SHOWN)
    refuse_data(where, f"no row of numbers below {first_line}", "columns time, x, y, ... and rows")


def _separator_of(line: str, decimal: str) -> str:
    """Return what separates the cells of a line."""
    for separator in SEPARATORS:
        if separator in line and separator != decimal:
            return separator
    return BLANKS


def _split(line: str, separator: str) -> list[str]:
    """Return the cells of a line, without quotes and blanks around them."""
    if separator == BLANKS:
        cells = line.split()
    else:
        cells = next(csv.reader([line], delimiter=separator), [])
    return [cell.strip().strip("\"'").strip() for cell in cells]


def _is_missing(text: str) -> bool:
    """Return whether a cell says that a number is missing."""
    return text.lower() in MISSING_NUMBERS


def _is_number(text: str, decimal: str) -> bool:
    """Return whether a cell is a number, or says that one is missing."""
    if _is_missing(text):
        return True
    try:
        float(text.replace(decimal, "."))
    except ValueError:
        return False
    return True


def _is_row_of_numbers(cells: Sequence[str], decimal: str) -> bool:
    """Return whether three cells of a line at least are numbers; one of them is not missing."""
    n_numbers = 0
    n_missing = 0
    for cell in cells:
        n_numbers += _is_number(cell, decimal)
        n_missing += _is_missing(cell)
    return n_numbers >= 3 and n_numbers > n_missing


def _is_row_of_average(cells: Sequence[str], head: Sequence[str], options: DataOptions) -> bool:
    """Return whether two cells are numbers below the names of a time and of an average."""
    if len(cells) != 2 or not head or not all(_is_number(cell, options.decimal) for cell in cells):
        return False
    names = _split(head[-1].lstrip("#"), _separator_of(head[-1], options.decimal))
    return len(names) == 2 and are_averages(names, options)


def _names_above(
    where: str, head: Sequence[str], separator: str, row: Sequence[str], options: DataOptions
) -> tuple[str, ...]:
    """Return the names of the columns, with their units if a row of these stands beside them.

    Of the lines with as many cells as the first row of numbers, or one less, that with most known
    names is taken.
    """
    n_cells = len(row)
    names: list[str] = []
    units: list[str] = []
    for line in head:
        cells = _split(line.lstrip("#"), separator)
        if len(cells) == n_cells - 1:
            # an empty cell ends each row; or the head of an index is left out, as pandas and R do
            cells = ["", *cells] if row[-1] else [*cells, ""]
        if len(cells) != n_cells:
            continue
        if _count_known(cells, options) > _count_known(names, options):
            names = cells
        elif _are_units(cells):
            units = cells
    if not names:
        line_above = "nothing"
        if head:
            line_above = short(head[-1], MAX_SHOWN)
        allowed = "a line above that names them: time, x, y, ..."
        refuse_data(where, f"{n_cells} columns of numbers below {line_above}", allowed)
    if not units:
        return tuple(names)
    return tuple(f"{name} {unit}".strip() for name, unit in zip(names, units, strict=True))


def _are_units(cells: Sequence[str]) -> bool:
    """Return whether the cells of a line are units in brackets, or empty."""
    filled = [cell for cell in cells if cell]
    return bool(filled) and all(cell.startswith(("(", "[")) for cell in filled)


def _count_known(names: Sequence[str], options: DataOptions) -> int:
    """Return how many cells are names of columns that we know, or that the user gave."""
    known = {*KNOWN_NAMES, *options.columns.values()}
    for other_names in (*KNOWN_NAMES.values(), *AVERAGE_NAMES.values()):
        known.update(other_names)
    count = 0
    for name in names:
        column = ColumnName.of(name)
        count += column.plain in known or column.bare in known
    return count


# -- numbers ---------------------------------------------------------------------------------------


def _read_columns(
    file: _TextFile, layout: _Layout, wanted: Sequence[ColumnName], options: DataOptions
) -> dict[str, ArrayLike]:
    """Return the wanted columns by the names of the file: numbers, and labels as they are."""
    frame = _parsed(file, layout, wanted, options)
    columns: dict[str, ArrayLike] = {}
    for column in wanted:
        columns[column.original] = frame[column.original]
        if not _is_label(column, options):
            columns[column.original] = _as_numbers(file.where, column, frame, options)
    return columns


def _is_label(column: ColumnName, options: DataOptions) -> bool:
    """Return whether a column is one of labels, which may be texts."""
    for name in LABELS:
        names = (name, *KNOWN_NAMES[name])
        if name in options.columns:
            names = (options.columns[name],)
        if column.plain in names or column.bare in names:
            return True
    return False


def _parsed(
    file: _TextFile, layout: _Layout, wanted: Sequence[ColumnName], options: DataOptions
) -> pd.DataFrame:
    """Return the wanted columns; texts where not all cells of one are numbers."""
    name_of_place: dict[int, str] = {}
    for column in wanted:
        name_of_place[layout.names.index(column.original)] = column.original
    comment = None
    if layout.has_comments:
        comment = "#"
    chunks = []
    budget = MemoryBudget(file.where)
    guard = _guarded(file.path, file.where)
    with io.BufferedReader(guard, SAMPLE_BYTES) as opened:
        try:
            reader = pd.read_csv(
                opened,
                sep=layout.separator,
                names=list(range(len(layout.names))),
                usecols=sorted(name_of_place),
                header=None,
                skiprows=layout.head_lines,
                skipinitialspace=True,
                decimal=options.decimal,
                comment=comment,
                encoding=file.encoding,
                encoding_errors="replace",
                index_col=False,
                chunksize=file.rows_at_once(),
                low_memory=False,
            )
            for chunk in reader:
                budget.take(float(chunk.memory_usage(index=False, deep=True).sum()))
                chunks.append(chunk)
                guard.begin_rows()
        except pd.errors.ParserError as error:
            allowed = "rows with one cell for each column"
            refuse_data(file.where, short(str(error), MAX_REASON), allowed)
    frame = pd.concat(chunks, ignore_index=True)
    return frame.rename(columns=name_of_place)


def _as_numbers(
    where: str, column: ColumnName, frame: pd.DataFrame, options: DataOptions
) -> Column:
    """Return a column of numbers; InputError names the row and the text that is none."""
    values = frame[column.original]
    if values.dtype.kind in "iuf":
        return np.asarray(values)
    if options.decimal == ",":
        values = values.astype(str).str.replace(",", ".").where(values.notna())
    numbers = pd.to_numeric(values, errors="coerce")
    is_text = np.asarray(numbers.isna() & values.notna())
    if np.any(is_text):
        row = int(np.argmax(is_text))
        text = str(values.iloc[row]).strip()
        allowed = "a number"
        if _DECIMAL_COMMA.fullmatch(text) and options.decimal == ".":
            allowed = "a number with a decimal point, or say --decimal ,"
        place = f"{where}: row {row + 1}"
        refuse_data(place, f"{column.plain} = {short(text)}", allowed)
    return np.asarray(numbers, dtype=float)
