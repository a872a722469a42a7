"""Small tables for notebooks, and numbers with the digits that their error has.

A result says what its table has with :class:`Table`; :func:`html_of` writes it, all text escaped.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

#: Columns of a line of text: with an indent of 2 it has 100.
MAX_COLUMNS = 98
#: Stands for a space at which no line is broken; it is in no text.
UNBROKEN_SPACE = "\0"
#: Significant digits of a number at most: no error estimate is below 1e-12 or so.
MAX_DIGITS = 12
#: Significant digits of a number whose error is not known.
DIGITS_WITHOUT_ERROR = 6
#: From this power of ten of the first digit on, and below its negative, numbers have an exponent.
MAX_DECIMAL_EXPONENT = 6
#: Power of ten of the first digit below which numbers have an exponent.
MIN_DECIMAL_EXPONENT = -5


@dataclass(frozen=True)
class Table:
    """A table: a title, heads of columns, and rows of as many cells; lines of text below it."""

    title: str
    heads: tuple[str, ...]
    rows: Sequence[Sequence[str]]
    lines: Sequence[str] = ()


def html_of(table: Table) -> str:
    """Return a table as HTML, with all of its text escaped."""
    heads = _elements("th", table.heads)
    rows = ""
    for row in table.rows:
        head, *cells = row
        head_cell = f'<th style="text-align:left">{escape(head)}</th>'
        rows += f"<tr>{head_cell}{_elements('td', cells)}</tr>"
    body = f"<table><thead><tr>{heads}</tr></thead><tbody>{rows}</tbody></table>"
    return f"<div><b>{escape(table.title)}</b>{body}{_elements('div', table.lines)}</div>"


def _elements(tag: str, texts: Sequence[str]) -> str:
    """Return an element of HTML for each text, which is escaped."""
    return "".join(f"<{tag}>{escape(text)}</{tag}>" for text in texts)


def number_text(value: float, error: float | None = None) -> str:
    """Return a number with the digits that its error has: 0 where it is smaller than that.

    Parameters
    ----------
    value : the number; one that is not finite is written as Python does
    error : its absolute error; None where it is not known
    """
    if not math.isfinite(value) or value == 0.0:
        return f"{value:g}" if value else "0"
    exponent = math.floor(math.log10(abs(value)))
    digits = DIGITS_WITHOUT_ERROR
    if error is not None and math.isfinite(error):
        if abs(value) < error:
            return "0"
        digits = MAX_DIGITS
        if error > 0.0:
            digits = min(MAX_DIGITS, max(1, exponent - math.floor(math.log10(error)) + 2))
    text = f"{value:.{digits - 1}e}"
    if MIN_DECIMAL_EXPONENT < exponent < MAX_DECIMAL_EXPONENT:
        text = f"{value:.{max(0, digits - 1 - exponent)}f}"
    if error is None and "e" not in text and "." in text:
        text = text.rstrip("0").rstrip(".")
    return text


def wrapped(text: str, indent: str = "  ") -> str:
    """Return text in lines of at most `MAX_COLUMNS`, those after the first with an indent.

    Lines do not end beside a sign of equality.
    """
    unbroken = " ".join(text.split()).replace(" = ", f"{UNBROKEN_SPACE}={UNBROKEN_SPACE}")
    lines = textwrap.fill(unbroken, MAX_COLUMNS, subsequent_indent=indent, break_on_hyphens=False)
    return lines.replace(UNBROKEN_SPACE, " ")
