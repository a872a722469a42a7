"""Times, figures and tables as text."""

from __future__ import annotations

import math

from kinetics.crosscheck.bench.analysis import AT_LEAST, Cost
from kinetics.crosscheck.bench.throughput import YEAR

_UNITS = (("years", YEAR), ("days", 86400.0), ("h", 3600.0), ("s", 1.0), ("ms", 1e-3))


def seconds_text(seconds: float | None) -> str:
    """A time of two digits with its unit, years where it is long."""
    if seconds is None or math.isnan(seconds):
        return "-"
    unit, size = next(((u, s) for u, s in _UNITS if seconds >= s), ("us", 1e-6))
    return f"{digits(seconds / size)} {unit}"


def digits(value: float) -> str:
    """Two significant digits; whole numbers up to 9999."""
    if value >= 1e4:
        return f"{value:.1e}"
    return f"{value:.0f}" if value >= 10.0 else f"{value:.2g}"


def table(heads: list[str], rows: list[list[str]]) -> list[str]:
    """Lines of a table, and an empty one."""
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    return [*lines, *("| " + " | ".join(row) + " |" for row in rows), ""]


def cost_text(found: Cost) -> str:
    """A time at an error; what is not measured is at least so much."""
    text = seconds_text(found.seconds)
    return f"≥ {text}" if found.how == AT_LEAST else text
