"""The answer of a comparison in some ten lines: begin with `statements`, or `answer_text`.

A page and the terminal show the same statements. Every number behind them is in `tables`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from kinetics.crosscheck.compare.observables import OBSERVABLES
from kinetics.crosscheck.compare.quantities import quantities, range_of_times
from kinetics.crosscheck.compare.result import Comparison, ComparisonTest, Explanation, Row
from kinetics.crosscheck.compare.writing import theory_text, wrapped
from kinetics.crosscheck.words import Verdict, number, numeral

#: Warnings that the answer has; a page, and `tables`, have all of them. Chosen.
MAX_WARNINGS = 3
#: Limits of differences above this, of the value, are left out: they say nothing.
MAX_EXCLUDED = 1.0


class Statement(NamedTuple):
    """A line of the answer: what it is about, and what there is to say."""

    subject: str
    text: str


def answer_text(comparison: Comparison) -> str:
    """Return the answer as lines of text for a terminal."""
    lines = [wrapped(verdict_sentence(comparison))]
    lines += [wrapped(f"{subject}: {text}") for subject, text in statements(comparison)]
    n_hidden = len(comparison.warnings) - MAX_WARNINGS
    lines += [wrapped(f"note: {warning}") for warning in comparison.warnings[:MAX_WARNINGS]]
    if n_hidden > 0:
        notes = "note" if n_hidden == 1 else "notes"
        lines.append(f"({n_hidden} more {notes}: --rows)")
    if comparison.next_step:
        lines.append(wrapped(f"next: {comparison.next_step}"))
    return "\n".join(lines)


def verdict_sentence(comparison: Comparison) -> str:
    """Return the verdict in one sentence."""
    if comparison.verdict is Verdict.AGREES:
        return f"Data and theory agree{_excluded_differences(comparison.tests)}."
    if comparison.verdict is Verdict.UNCLEAR:
        return "Data and theory may differ; more tracers would decide."
    if comparison.verdict is Verdict.DIFFERS:
        return "Data and theory differ."
    if comparison.verdict is Verdict.NOT_TESTED and not comparison.groups:
        return "Not tested: no standard errors are stated."
    if comparison.verdict is Verdict.NOT_TESTED:
        few = f"{comparison.groups} independent groups are too few for errors this large"
        return f"Not tested: {few}."
    return "Nothing could be tested."


def _excluded_differences(tests: Sequence[ComparisonTest]) -> str:
    """Return how large a difference of each average is excluded, as the end of a sentence."""
    limits = []
    for test in tests:
        if test.within is None or test.verdict is not Verdict.AGREES:
            continue
        if test.within > MAX_EXCLUDED:
            continue
        percent = numeral(100.0 * test.within, ".2g")
        limits.append(f"{percent} % of {OBSERVABLES[test.observable].text}")
    if not limits:
        return ""
    return f": differences above {', '.join(limits)} are excluded (95 %)"


def statements(comparison: Comparison) -> list[Statement]:
    """Return what there is to say beside the verdict, the warnings and the next step."""
    lines = _statements_of_quantities(comparison)
    lines += [Statement("cannot tell", sentence) for sentence in comparison.cannot_tell]
    lines.append(Statement("theory", _theory_text(comparison)))
    lines.append(Statement("data", _data_text(comparison)))
    if comparison.overall_p_value is not None:
        lines.append(Statement("p-value", _p_value_text(comparison)))
    deviation = _largest_deviation(comparison)
    if deviation:
        lines.append(Statement("largest deviation", deviation))
    return lines + _statements_of_causes(comparison)


def _statements_of_quantities(comparison: Comparison) -> list[Statement]:
    """Return the numbers of the theory; what is said of the source of several is said once."""
    lines = []
    stated: set[str] = set()
    for quantity in quantities(comparison):
        clauses = [clause for clause in quantity.source.split("; ") if clause not in stated]
        stated.update(clauses)
        source = "; ".join(clauses)
        text = quantity.text
        if source:
            text = source
            if quantity.has_value:
                text = f"{quantity.text} ({source})"
        lines.append(Statement(quantity.name, text))
    return lines


def _theory_text(comparison: Comparison) -> str:
    """Return the medium that was taken, how well it and others fit, and the start."""
    text = comparison.medium
    if len(comparison.media) > 1:
        fits = []
        for medium, (chi_square, dof) in comparison.media.items():
            fits.append(f"{medium} {numeral(chi_square, '.3g')}/{dof}")
        text += f" (chi-square/degrees of freedom: {', '.join(fits)})"
    if comparison.undecided:
        text += f"; the data do not exclude {' nor '.join(comparison.undecided)}"
        if any(parameter.error is not None for parameter in comparison.parameters.values()):
            text += ": fitted values are means over these media, their errors reach all"
    return f"{text}; from {comparison.initial}"


def _data_text(comparison: Comparison) -> str:
    """Return how many tracers and times there are, and what the errors are from."""
    if not comparison.groups:
        return f"averages at {comparison.n_times} times {range_of_times(comparison)}"
    text = f"{comparison.samples} tracers"
    if comparison.n_times:
        text += f" at {comparison.n_times} times {range_of_times(comparison)}"
    return f"{text}; errors from {comparison.groups} groups, by {comparison.grouping}"


def _p_value_text(comparison: Comparison) -> str:
    """Return the p-value, and the chi-square of all averages together."""
    assert comparison.overall_p_value is not None
    text = f"{numeral(comparison.overall_p_value, '.2g')}, of everything that was tested"
    if comparison.chi_square is None:
        return text
    chi_square = numeral(comparison.chi_square, ".4g")
    freedom = f"{comparison.dof} degrees of freedom"
    return f"{text}; all averages together have chi-square {chi_square} with {freedom}"


def _largest_deviation(comparison: Comparison) -> str:
    """Return the row, or the test, that differs most, in words; empty where there is none."""
    for exact_row in comparison.numbers:
        if exact_row.sigmas is None and exact_row.verdict is Verdict.DIFFERS:
            return _row_text(exact_row)
    row = max(comparison.numbers, key=_size_of_deviation, default=None)
    test = max(comparison.tests, key=lambda test: test.sigmas, default=None)
    row_size = 0.0 if row is None else _size_of_deviation(row)[0]
    if test is not None and test.sigmas > row_size:
        return _test_text(test)
    if row is None or row.sigmas is None:
        return ""
    return _row_text(row)


def _size_of_deviation(row: Row) -> tuple[float, float]:
    """Return the deviation of a row allowing for the number of rows, and by itself."""
    if row.sigmas is None or row.corrected_sigmas is None:
        return 0.0, 0.0
    return abs(row.corrected_sigmas), abs(row.sigmas)


def _row_text(row: Row) -> str:
    """Return the deviation of a row in words."""
    observable = OBSERVABLES[row.observable]
    times = f"at t = {numeral(row.time, '.4g')} d/U"
    if row.since is not None:
        times = f"from {numeral(row.since, '.4g')} to {numeral(row.time, '.4g')} d/U"
    place = ""
    if row.low is not None:
        end = "∞" if row.high is None else numeral(row.high, ".3g")
        place = f" from {numeral(row.low, '.3g')} to {end} {observable.unit}"
    theory = theory_text(row.theory, row.error, max(abs(row.value), row.error))
    values = f"{number(row.value, row.error)}, theory {theory}"
    text = f"{observable.title} {times}{place}: {values}"
    if row.sigmas is None or row.corrected_sigmas is None:
        return text
    sigmas = numeral(row.sigmas, "+.1f")
    corrected = numeral(row.corrected_sigmas, ".1f")
    return f"{text}; {sigmas} standard errors, {corrected} allowing for the number of rows"


def _test_text(test: ComparisonTest) -> str:
    """Return the chi-square of an observable in words."""
    times = "over all times"
    if test.time is not None:
        times = f"at t = {numeral(test.time, '.4g')} d/U"
    chi_square = f"chi-square {numeral(test.chi_square, '.4g')} with {test.dof} degrees of freedom"
    sigmas = f"{numeral(test.sigmas, '.1f')} standard errors allowing for the number of tests"
    return f"{OBSERVABLES[test.observable].title} {times}: {chi_square}, {sigmas}"


def _statements_of_causes(comparison: Comparison) -> list[Statement]:
    """Return what explains a difference, and what is found in the data themselves."""
    by_outcome: dict[str, list[str]] = {outcome: [] for outcome in ("found", "explains", "in part")}
    for item in comparison.explanations:
        if item.outcome in by_outcome:
            by_outcome[item.outcome].append(_headline(item))
    lines = [Statement("in the data", headline) for headline in by_outcome["found"]]
    if by_outcome["explains"]:
        lines.append(Statement("explained by", " or ".join(by_outcome["explains"])))
    elif by_outcome["in part"]:
        lines.append(Statement("explained in part by", " or ".join(by_outcome["in part"])))
    elif not by_outcome["found"]:
        lines += _statements_of_failed_causes(comparison)
    return lines


def _statements_of_failed_causes(comparison: Comparison) -> list[Statement]:
    """Return the causes that were tried in vain, where there are some."""
    names = [item.name for item in comparison.explanations if item.outcome == "does not"]
    if not names or comparison.verdict is Verdict.AGREES:
        return []
    return [Statement("explained by", f"none of what was tried: {', '.join(names)}")]


def _headline(item: Explanation) -> str:
    """Return an explanation in few words."""
    return item.headline or f"{item.name}: {item.text}"


def explanation_text(item: Explanation) -> str:
    """Return an explanation with the chi-squares of all averages without it and with it."""
    if item.chi_square_before is None or item.chi_square_after is None or item.p_value is None:
        return item.text
    original = numeral(item.chi_square_before, ".4g")
    remaining = numeral(item.chi_square_after, ".4g")
    medium = f", {item.medium}" if item.medium else ""
    p_value = numeral(item.p_value, ".2g")
    chi_squares = f"chi-square {original} → {remaining}/{item.dof}"
    return f"{_headline(item)}{medium}; {chi_squares}, p = {p_value}"
