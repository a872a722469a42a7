"""Positions of scatterers in a CSV file."""

import csv
from collections.abc import Iterator
from os import PathLike

import numpy as np

from particles.checks import check_path, short


def read_positions(path: str | PathLike[str]) -> np.ndarray:
    """Return x and y, (count, 2), from a file of two columns; one header line may precede.

    Raises ValueError, naming the line, for one that does not hold two numbers, and for a file that
    cannot be read, is not text or holds no positions.
    """
    name = check_path("path", path)
    try:
        with open(name, newline="", encoding="utf-8") as file:
            rows = list(_pairs(name, csv.reader(file)))
    except (UnicodeDecodeError, csv.Error):
        raise ValueError(f"{name}: must be a CSV file, text in UTF-8") from None
    except OSError as error:
        raise ValueError(f"{name}: cannot be read ({error.strerror})") from None
    if not rows:
        raise ValueError(f"{name}: holds no positions")
    return np.array(rows)


def _pairs(path: str, table: Iterator[list[str]]) -> Iterator[tuple[float, float]]:
    """Yield the two numbers of each line; the first may be a header, and lines may be empty."""
    for number, row in enumerate(table, 1):
        try:
            x, y = (float(cell) for cell in row)
        except ValueError:
            if row and number > 1:
                words = f"{short(row)} must be two numbers"
                raise ValueError(f"{path}, line {number}: {words}") from None
            continue
        yield x, y
