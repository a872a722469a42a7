"""Paragraphs and tables of plain text for the terminal."""

import textwrap
from collections.abc import Iterable, Sequence
from typing import Any

WIDTH = 100  # columns of a terminal
_GAP = "  "


def written(number: float, digits: int = 6) -> str:
    """A number as a physicist writes it in plain text: 0.0123, 1e6, 4.5e-7."""
    mantissa, _, exponent = f"{number:.{digits}g}".partition("e")
    return f"{mantissa}e{int(exponent)}" if exponent else mantissa


def figure(value: Any) -> str:
    """A value with its digits if it is a number that is not whole, else as text."""
    return written(value, 13) if isinstance(value, float) else str(value)


def wrapped(text: str) -> str:
    """A paragraph in lines of WIDTH columns at most."""
    return textwrap.fill(text, WIDTH, subsequent_indent="  ", break_on_hyphens=False)


def columns(heads: Sequence[str], values: Iterable[Iterable[float]]) -> str:
    """A table of numbers, one column per head; what is too wide goes on in a table below.

    Each of these begins with the first column.
    """
    cells = [[head, *map(written, column)] for head, column in zip(heads, values, strict=True)]
    widths = [max(map(len, column)) + len(_GAP) for column in cells]
    blocks, width = [[0]], widths[0]
    for k in range(1, len(cells)):
        if width + widths[k] > WIDTH + len(_GAP) and len(blocks[-1]) > 1:
            blocks.append([0])
            width = widths[0]
        blocks[-1].append(k)
        width += widths[k]
    return "\n".join(
        aligned(list(zip(*(cells[k] for k in block), strict=True)), right=True) for block in blocks
    )


def aligned(lines: Sequence[Sequence[str]], right: bool = False) -> str:
    """Lines of cells as text whose columns stand below each other."""
    widths = [max(len(cell) for cell in column) for column in zip(*lines, strict=True)]
    align = str.rjust if right else str.ljust
    return "\n".join(
        _GAP.join(align(cell, width) for cell, width in zip(line, widths, strict=True)).rstrip()
        for line in lines
    )


def markdown(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """Lines of a Markdown table and an empty line; nothing where there is no row."""
    lines = ["| " + " | ".join(c.replace("|", "\\|") for c in row) + " |" for row in rows]
    head = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    return [*head, *lines, ""] if lines else []
