"""The tables of a benchmark, in Markdown: each is a function of the rows."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence

import numpy as np

from kinetics.crosscheck.bench import cost, throughput
from kinetics.crosscheck.bench.accuracy import BETTER, MISSED, MISSED_AND_SAID
from kinetics.crosscheck.bench.analysis import (
    AT_LEAST,
    Cost,
    family,
    middle_cost,
    middle_least_error,
    of_problems,
)
from kinetics.crosscheck.bench.methods import METHODS, PRINTED
from kinetics.crosscheck.bench.position import REFERENCE
from kinetics.crosscheck.bench.record import (
    ACCURACY,
    COST,
    MEASURED,
    PARTICLES,
    PRECISION,
    SKIPPING,
    Record,
)
from kinetics.crosscheck.text_tables import markdown

_UNITS = (("years", 365.25 * 86400.0), ("days", 86400.0), ("h", 3600.0), ("s", 1.0), ("ms", 1e-3))
_RAISED = str.maketrans("0123456789+-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻")
_POWER_OF_TEN = re.compile(r"\b1e([+-]?)0*(\d+)\b")
_EXPONENT = re.compile(r"\^(-?\d+)")
_SIGNS = {"<r": "⟨r", "²>": "²⟩", "<=": "≤", "v0": "v₀", "a2": "a₂"}
_NOT_REACHED = (
    "≥: not reached; the least that it would take from its most accurate run, by the order of "
    "the method. -: the method does not get there."
)


def typeset(text: str) -> str:
    """Powers raised, indices lowered, averages in brackets."""
    text = _POWER_OF_TEN.sub(lambda m: "10" + (m[1].strip("+") + m[2]).translate(_RAISED), text)
    text = _EXPONENT.sub(lambda m: m[1].translate(_RAISED), text)
    for plain, sign in _SIGNS.items():
        text = text.replace(plain, sign)
    return text


def digits(value: float) -> str:
    """Two significant digits; whole numbers up to 9999."""
    if value >= 1e4:
        return f"{value:.1e}"
    return f"{value:.0f}" if value >= 10.0 else f"{value:.2g}"


def seconds_text(seconds: float | None) -> str:
    """A time of two digits with its unit, years where it is long."""
    if seconds is None or math.isnan(seconds):
        return "-"
    unit, size = next(((u, s) for u, s in _UNITS if seconds >= s), ("us", 1e-6))
    return f"{digits(seconds / size)} {unit}"


def cost_text(found: Cost) -> str:
    """A time at an error; what is not measured is at least so much."""
    text = seconds_text(found.seconds)
    return f"≥ {text}" if found.how == AT_LEAST else text


def tables(records: Sequence[Record]) -> list[str]:
    """The lines of all tables that have rows, from the shortest on."""
    problems = of_problems(records, PRECISION)
    families: dict[str, list[list[Record]]] = {}
    for problem, rows in problems.items():
        families.setdefault(typeset(family(problem)), []).append(rows)
    summary = "Run time of one thread, medians over the restitutions and starts. " + _NOT_REACHED
    single = {problem: [rows] for problem, rows in problems.items()}
    return [
        *_table("Summary", *_run_times(families, (1e-3, 1e-8)), summary),
        *_table("Run time for an error", *_run_times(single, (1e-3, 1e-6, 1e-8, 1e-10)),
                _NOT_REACHED, _notes(problems)),
        *_table("Error reached over error asked", *_accuracy(records), below=_missed(records)),
        *_table("What skipping saves", *_skipping(records)),
        *_table("Cost against work", *_cost(records)),
        *_table(f"Particles, e = {throughput.RESTITUTION:g}", *_particles(records),
                "Of two threads by wall-clock time."),
        *_table("Failed and not available", *_not_measured(records)),
    ]  # fmt: skip


Cells = tuple[Sequence[str], Iterable[Sequence[str]]]
"""The heads of a table, and its rows."""


def _table(
    title: str,
    heads: Sequence[str],
    rows: Iterable[Sequence[str]],
    words: str = "",
    below: Sequence[str] = (),
) -> list[str]:
    """A table with its heading, the words before it, and lines below it; nothing without rows."""
    lines = markdown(heads, rows)
    if not lines:
        return []
    before = [f"## {title}", "", *([words, ""] if words else [])]
    return [*before, *lines, *below, *([""] if below else [])]


def _run_times(groups: dict[str, list[list[Record]]], targets: Sequence[float]) -> Cells:
    """A row for each group of problems and method: run time at the targets, and least error."""
    rows = []
    for name, problems in groups.items():
        for method in METHODS:
            least = middle_least_error(problems, method)
            if least is not None:
                costs = [cost_text(middle_cost(problems, method, target)) for target in targets]
                rows.append([name, method, *costs, f"{least:.1e}"])
    return ["problem", "method", *(typeset(f"{t:.0e}") for t in targets), "least error"], rows


def _notes(problems: dict[str, list[Record]]) -> list[str]:
    """What the table of run times has no place for."""
    lines = []
    for row in (row for rows in problems.values() for row in rows):
        if row.method == REFERENCE:
            lines.append(f"- Reference of {row.problem}, rtol = {row.value:.0e}: {row.note}.")
        elif row.method == PRINTED and row.error is not None:
            lines.append(f"- {row.problem}, {row.setting}: error {row.error:.2g}.")
    return lines


def _accuracy(records: Sequence[Record]) -> Cells:
    """A row for each rtol: the range of reached/asked, and how many problems missed it."""
    done = [r for r in records if r.section == ACCURACY and r.status == MEASURED]
    rows = []
    for rtol in sorted({r.asked for r in done if r.asked}, reverse=True):
        here = [r for r in done if r.asked == rtol]
        ratios = np.array([r.extra["ratio"] for r in here])
        rows.append([
            f"{rtol:.0e}", str(len(here)),
            *(f"{x:.1e}" for x in (ratios.min(), np.median(ratios), ratios.max())),
            *(str(sum(r.note == note for r in here)) for note in (MISSED, MISSED_AND_SAID, BETTER)),
        ])  # fmt: skip
    heads = ["rtol", "problems", "least", "median", "most", "missed, status claims it",
             "missed, status says so", "100 times better"]  # fmt: skip
    return heads, rows


def _missed(records: Sequence[Record]) -> list[str]:
    """The five problems that missed an error by most, of those whose status claims it."""
    missed = [r for r in records if r.section == ACCURACY and r.note == MISSED and r.error]
    worst = sorted(missed, key=lambda r: -r.extra["ratio"])[:5]
    return [f"- {r.problem}: asked {r.asked:.0e}, reached {r.error:.1e}" for r in worst]


def _skipping(records: Sequence[Record]) -> Cells:
    return ["scene", "asked for", "time", "whole scene's time over it"], [
        [r.problem, r.method, seconds_text(r.seconds), digits(r.extra["ratio"])]
        for r in records
        if r.section == SKIPPING and r.status == MEASURED
    ]


def _cost(records: Sequence[Record]) -> Cells:
    here = [r for r in records if r.section == COST and r.status == MEASURED]
    rows = []
    for row in (r for r in here if "exponent" in r.extra):
        setting = row.setting.removesuffix(cost.EXPONENT)
        key = (row.problem, row.method, setting)
        points = [r for r in here if (r.problem, r.method, r.setting) == key]
        if points:
            first, last, exponent = points[0], points[-1], row.extra["exponent"]
            rows.append([
                row.problem, row.method, f"{setting} {first.value:g} to {last.value:g}",
                f"{seconds_text(first.seconds)} to {seconds_text(last.seconds)}",
                "-" if exponent is None else f"{exponent:.2f}",
            ])  # fmt: skip
    return ["problem", "method", "work", "run time", "exponent"], rows


def _particles(records: Sequence[Record]) -> Cells:
    heads = ["medium", "threads", "million collisions per second", "placing one medium"]
    return heads, [
        [r.problem, str(r.threads),
         f"{r.extra['collisions_per_second'] / 1e6:.1f}",
         seconds_text(r.extra["placing_seconds_per_medium"])]
        for r in records
        if r.section == PARTICLES and r.status == MEASURED
    ]  # fmt: skip


def _not_measured(records: Sequence[Record]) -> Cells:
    return ["status", "problem", "method", "setting", "why"], [
        [r.status, r.problem, r.method,
         r.setting if r.value is None else f"{r.setting} {r.value:g}", r.note]
        for r in records
        if r.status != MEASURED
    ]  # fmt: skip
