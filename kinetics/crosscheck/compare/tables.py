"""All tests and rows of a comparison as tables, for a terminal and for its page."""

from __future__ import annotations

from collections.abc import Sequence

from kinetics.crosscheck.compare.result import OUTCOMES, Comparison, ComparisonTest, Row
from kinetics.crosscheck.compare.text import MAX_WARNINGS, explanation_text
from kinetics.crosscheck.compare.writing import theory_text, wrapped
from kinetics.crosscheck.words import (
    AGREES_BELOW,
    DIFFERS_ABOVE,
    Verdict,
    number,
    numeral,
)

#: The cells of a table, a list for each line; the first has the heads.
Table = list[list[str]]

HEADS_OF_TESTS = ["chi-square", "t [d/U]", "value", "dof", "p", "σ", "excluded above", "verdict"]
HEADS_OF_ROWS = ["observable", "t [d/U]", "bin", "value ± s.e.", "theory", "s.e.", "σ", "verdict"]
#: Head of the column of earlier times, which only displacements between frames have.
HEAD_OF_SINCE = "since"
#: The column before which it stands.
COLUMN_OF_SINCE = 2
#: What the columns mean, in words.
MEANING_OF_COLUMNS = (
    "s.e.: the difference in standard errors. σ: the same allowing for the number of rows or "
    f"tests; the verdict is on σ: below {AGREES_BELOW:g} they agree, from {DIFFERS_ABOVE:g} they "
    "differ. Excluded above: larger relative differences are excluded (95 %)."
)
#: What the numbers of explanations mean, in words.
MEANING_OF_EXPLANATIONS = (
    "Explanations, with the chi-square of all averages without and with them, over the degrees of "
    "freedom:"
)


def tables(comparison: Comparison) -> str:
    """Return all tests, averages, bins that do not agree, and explanations as text."""
    shown = [row for row in comparison.numbers if _is_worth_a_line(row)]
    blocks = [wrapped(MEANING_OF_COLUMNS)]
    if comparison.tests:
        blocks.append(aligned(table_of_tests(comparison.tests)))
    blocks.append(aligned(table_of_rows(comparison.numbers, shown)))
    n_hidden = len(comparison.numbers) - len(shown)
    if n_hidden:
        blocks[-1] += f"\n({n_hidden} bins of densities that agree are left out; --json has them)"
    if comparison.explanations:
        lines = [wrapped(MEANING_OF_EXPLANATIONS)]
        for item in comparison.explanations:
            subject = f"{item.name} ({OUTCOMES[item.outcome]})"
            lines.append(wrapped(f"{subject}: {explanation_text(item)}"))
        blocks.append("\n".join(lines))
    blocks += [wrapped(f"note: {warning}") for warning in comparison.warnings[MAX_WARNINGS:]]
    return "\n\n".join(blocks)


def _is_worth_a_line(row: Row) -> bool:
    """Return whether a terminal shows a row: an average, or a bin that does not agree."""
    return row.low is None or row.verdict is not Verdict.AGREES


def aligned(table: Table) -> str:
    """Return a table as lines of text with columns of equal width."""
    widths = [max(len(cell) for cell in column) for column in zip(*table, strict=True)]
    lines = []
    for cells in table:
        padded = [cell.ljust(width) for cell, width in zip(cells, widths, strict=True)]
        lines.append("  ".join(padded).rstrip())
    return "\n".join(lines)


def table_of_tests(tests: Sequence[ComparisonTest]) -> Table:
    """Return the chi-squares, a line each below the heads."""
    return [HEADS_OF_TESTS] + [_cells_of_test(test) for test in tests]


def _cells_of_test(test: ComparisonTest) -> list[str]:
    """Return the cells of one chi-square."""
    time = "all" if test.time is None else numeral(test.time, ".4g")
    excluded = ""
    if test.within is not None and test.verdict is Verdict.AGREES:
        excluded = f"{numeral(100.0 * test.within, '.2g')} %"
    return [
        test.observable,
        time,
        numeral(test.chi_square, ".4g"),
        str(test.dof),
        numeral(test.p_value, ".2g"),
        numeral(test.sigmas, ".1f"),
        excluded,
        str(test.verdict),
    ]


def table_of_rows(all_rows: Sequence[Row], shown: Sequence[Row]) -> Table:
    """Return a line for each row that is shown, below the heads.

    Parameters
    ----------
    all_rows : of the comparison; they say how large each observable is
    shown : the rows of the table
    """
    sizes: dict[str, float] = {}
    for row in all_rows:
        size = max(abs(row.value), abs(row.theory))
        sizes[row.observable] = max(size, sizes.get(row.observable, 0.0))
    has_since = False
    lines = [list(HEADS_OF_ROWS)]
    for row in shown:
        has_since |= row.since is not None
        lines.append(_cells_of_row(row, sizes[row.observable]))
    if has_since:
        lines[0].insert(COLUMN_OF_SINCE, HEAD_OF_SINCE)
        for row, cells in zip(shown, lines[1:], strict=True):
            since = "" if row.since is None else numeral(row.since, ".4g")
            cells.insert(COLUMN_OF_SINCE, since)
    return lines


def _cells_of_row(row: Row, size: float) -> list[str]:
    """Return the cells of one row."""
    sigmas = ""
    if row.sigmas is not None:
        sigmas = numeral(row.sigmas, "+.1f")
    corrected = ""
    if row.corrected_sigmas is not None:
        corrected = numeral(row.corrected_sigmas, ".1f")
    return [
        row.observable,
        numeral(row.time, ".4g"),
        _bin_text(row),
        number(row.value, row.error),
        theory_text(row.theory, row.error, size),
        sigmas,
        corrected,
        str(row.verdict),
    ]


def _bin_text(row: Row) -> str:
    """Return the ends of a bin; the empty text for an average."""
    if row.low is None:
        return ""
    end = "∞" if row.high is None else numeral(row.high, ".4g")
    return f"{numeral(row.low, '.4g')} to {end}"
