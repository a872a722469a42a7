"""Tables of plain text for the terminal."""

from collections.abc import Iterable, Sequence


def columns(heads: Sequence[str], values: Iterable[Iterable[float]]) -> str:
    """A table of numbers, one column per head."""
    rows = zip(*values, strict=True)
    return aligned([list(heads), *([f"{v:.6g}" for v in row] for row in rows)], right=True)


def aligned(lines: Sequence[Sequence[str]], right: bool = False) -> str:
    """Lines of cells as text whose columns stand below each other."""
    widths = [max(len(cell) for cell in column) for column in zip(*lines, strict=True)]
    align = str.rjust if right else str.ljust
    return "\n".join(
        "  ".join(align(cell, width) for cell, width in zip(line, widths, strict=True)).rstrip()
        for line in lines
    )


def markdown(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """Lines of a Markdown table and an empty line; nothing where there is no row."""
    lines = ["| " + " | ".join(c.replace("|", "\\|") for c in row) + " |" for row in rows]
    head = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    return [*head, *lines, ""] if lines else []
