"""How lines of text and values of the theory are written."""

from __future__ import annotations

import math
import textwrap

from kinetics.crosscheck.words import numeral

#: Columns of a line of text.
LINE_WIDTH = 100
#: A value of the theory below this fraction of the size of its observable is written as 0: the
#: solver has a relative tolerance of 1e-7, so that digits of it are errors.
NEGLIGIBLE_THEORY = 1e-6
#: Digits of a value of the theory at most. Chosen: fewer than the solver has right.
MAX_DIGITS_OF_THEORY = 6
#: Digits of a standard error that are written.
DIGITS_OF_ERROR = 2


def wrapped(text: str) -> str:
    """Return a text in lines of `LINE_WIDTH`, those but the first indented."""
    return textwrap.fill(text, LINE_WIDTH, subsequent_indent="  ", break_on_hyphens=False)


def theory_text(theory: float, error: float, size: float) -> str:
    """Return a value of the theory with the decimals that the value of the data has.

    Parameters
    ----------
    theory : the value
    error : standard error of the difference; 0 where there is none
    size : of the observable, such as its largest value over time
    """
    magnitude = abs(theory)
    if not math.isfinite(theory):
        return "–"
    if magnitude == 0.0 or magnitude < NEGLIGIBLE_THEORY * size:
        return "0"
    digits = MAX_DIGITS_OF_THEORY
    if error > 0.0:
        digits = decimal_place(magnitude) - decimal_place(error) + DIGITS_OF_ERROR
    if digits < 1:
        return "0"
    digits = min(digits, MAX_DIGITS_OF_THEORY)
    if digits == 1 or error <= 0.0:
        return numeral(theory, f".{digits}g")
    return numeral(theory, f"#.{digits}g").rstrip(".")


def decimal_place(value: float) -> int:
    """Return the power of ten of the first digit of a positive value."""
    return math.floor(math.log10(value))
