"""The tables of a benchmark, in Markdown."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from kinetics.crosscheck.bench import analysis, cost, throughput
from kinetics.crosscheck.bench.accuracy import MISSED
from kinetics.crosscheck.bench.analysis import (
    AT_LEAST,
    TARGETS,
    YEAR,
    Cost,
    cost_at,
    family,
    of_problems,
)
from kinetics.crosscheck.bench.methods import (
    METHODS,
    MONTE_CARLO,
    PRINTED,
    SPECTRAL,
)
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

_UNITS = (("years", YEAR), ("days", 86400.0), ("h", 3600.0), ("s", 1.0), ("ms", 1e-3))
_RAISED = str.maketrans("0123456789+-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻")
_POWER_OF_TEN = re.compile(r"\b1e([+-]?)0*(\d+)\b")
_EXPONENT = re.compile(r"\^(-?\d+)")
_SIGNS = {"<r": "⟨r", "²>": "²⟩", "<=": "≤", "v0": "v₀", "a2": "a₂"}


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


@dataclass(frozen=True)
class Table:
    """A table with its heading, the words before it, and lines below it."""

    title: str
    words: str
    heads: Sequence[str]
    rows: Sequence[Sequence[str]]
    below: Sequence[str] = ()

    def lines(self) -> Iterator[str]:
        """As Markdown; nothing where there is no row."""
        if not self.rows:
            return
        if self.title:
            yield from (f"## {self.title}", "")
        if self.words:
            yield from (self.words, "")
        yield "| " + " | ".join(self.heads) + " |"
        yield "|" + "---|" * len(self.heads)
        yield from ("| " + " | ".join(row) + " |" for row in self.rows)
        yield ""
        if self.below:
            yield from (*self.below, "")


def tables(records: list[Record]) -> list[Table]:
    """All of them, from the shortest on."""
    makers = (summary, _precision, _monte_carlo, _accuracy, _skipping, _cost, _particles, _cells,
              _failures)  # fmt: skip
    return [make(records) for make in makers]


def summary(records: list[Record]) -> Table:
    """A line for each family of problems and method: short enough for a README."""
    families: dict[str, list[list[Record]]] = {}
    for problem, here in of_problems(records, PRECISION).items():
        families.setdefault(family(problem), []).append(here)
    rows = []
    for name, members in families.items():
        for method in METHODS:
            least = [
                min(r.error for r in done if r.error is not None)
                for here in members
                if (done := [r for r in here if r.method == method and r.error is not None])
            ]
            if not least:
                continue
            costs = [analysis.middle_cost(members, method, target) for target in (1e-3, 1e-8)]
            middle = sorted(least)[len(least) // 2]
            rows.append([typeset(name), method, *map(cost_text, costs), f"{middle:.0e}"])
    words = (
        "Run time of one thread for an error of 10⁻³ and of 10⁻⁸, and the least error reached: "
        "medians over the restitutions and starts. ≥: not reached; what the order of the method "
        "would take at least. -: the method does not get there."
    )
    return Table("Summary", words, ["problem", "method", "10⁻³", "10⁻⁸", "least error"], rows)


def _precision(records: list[Record]) -> Table:
    rows = []
    for problem, here in of_problems(records, PRECISION).items():
        for method in METHODS:
            errors = [
                r.error
                for r in here
                if r.method == method and r.status == MEASURED and r.error is not None
            ]
            if errors:
                cells = [cost_text(cost_at(here, method, target)) for target in TARGETS]
                rows.append([problem, method, *cells, f"{min(errors):.1e}"])
    words = (
        "≥: not reached; the least that it would take from its most accurate run, by the order of "
        "the method. -: the method does not get there."
    )
    notes = [text for row in records if row.section == PRECISION and (text := _note(row))]
    beaten = analysis.quicker_than(records, PRECISION, SPECTRAL, 1e-3)
    if beaten:
        below = ["Below an error of 1e-3 the spectral solver is not the quickest here:", ""]
        below += [f"- {line}" for line in beaten]
    else:
        below = ["Below an error of 1e-3 no other method is quicker than the spectral solver."]
    heads = ["problem", "method", *(f"{t:.0e}" for t in TARGETS), "least error measured"]
    between = [""] if notes else []
    return Table("Run time for an error", words, heads, rows, [*notes, *between, *below])


def _note(row: Record) -> str:
    """What the table of run times has no place for."""
    if row.method == REFERENCE:
        return f"- Reference of {row.problem}, rtol = {row.value:.0e}: {row.note}."
    if row.method == PRINTED and row.error is not None:
        return f"- {row.problem}, {row.setting}: error {row.error:.2g}."
    return ""


def _monte_carlo(records: list[Record]) -> Table:
    rows = []
    for problem, here in of_problems(records, PRECISION).items():
        need = analysis.monte_carlo_need([r for r in here if r.method == MONTE_CARLO])
        if math.isfinite(need["samples"]):
            rows.append(
                [problem, f"{need['slope']:.2f}", f"{need['samples']:.0e}", digits(need["years"])]
            )
    seeds = [r.extra["seeds"] for r in records if "seeds" in r.extra] or [0]
    words = f"Errors are root mean squares over seeds, {min(seeds)} to {max(seeds)} a row."
    heads = ["problem", "error ~ samples^", "samples", "years of one processor"]
    return Table("What Monte Carlo would need for 1e-10", words, heads, rows)


def _accuracy(records: list[Record]) -> Table:
    rows = [
        [f"{row['asked']:.0e}", str(row["problems"])]
        + [f"{row[name]:.1e}" for name in ("best", "median", "worst")]
        + [str(row[name]) for name in ("missed", "missed_and_said", "beyond_100")]
        for row in analysis.asked_and_reached(records)
    ]
    heads = ["rtol", "problems", "least", "median", "most", "missed, status claims it",
             "missed, status says so", "100 times better"]  # fmt: skip
    missed = [r for r in records if r.section == ACCURACY and r.note == MISSED and r.error]
    worst = sorted(missed, key=lambda r: -r.extra["ratio"])[:5]
    below = [f"- {r.problem}: asked {r.asked:.0e}, reached {r.error:.1e}" for r in worst]
    return Table("Error reached over error asked", "", heads, rows, below)


def _skipping(records: list[Record]) -> Table:
    rows = [
        [r.problem, r.method, seconds_text(r.seconds), digits(r.extra["ratio"])]
        for r in records
        if r.section == SKIPPING and r.status == MEASURED
    ]
    heads = ["scene", "asked for", "time", "whole scene's time over it"]
    return Table("What skipping saves", "", heads, rows)


def _cost(records: list[Record]) -> Table:
    here = [r for r in records if r.section == COST and r.status == MEASURED]
    rows = []
    for row in (r for r in here if "exponent" in r.extra):
        key = (row.problem, row.method, row.setting.removesuffix(cost.EXPONENT))
        points = [r for r in here if (r.problem, r.method, r.setting) == key]
        if points:
            first, last, exponent = points[0], points[-1], row.extra["exponent"]
            rows.append(
                [
                    row.problem,
                    row.method,
                    f"{key[2]} {first.value:g} to {last.value:g}",
                    f"{seconds_text(first.seconds)} to {seconds_text(last.seconds)}",
                    "-" if exponent is None else f"{exponent:.2f}",
                ]
            )
    return Table(
        "Cost against work", "", ["problem", "method", "work", "run time", "exponent"], rows
    )


def _particles(records: list[Record]) -> Table:
    rows = []
    for name, here in of_problems(records, PARTICLES).items():
        rates = {
            r.threads: r.extra["collisions_per_second"]
            for r in here
            if r.status == MEASURED and r.setting != throughput.LISTED
        }
        if rates:
            placing = here[0].extra["placing_seconds_per_medium"]
            shown = [f"{rates[n] / 1e6:.1f}" if n in rates else "-" for n in (1, 2)]
            rows.append([name, *shown, seconds_text(placing)])
    title = f"Particles, e = {throughput.RESTITUTION:g}: million collisions per second"
    heads = ["medium", "1 thread", "2 threads", "placing one medium"]
    return Table(title, "Of two threads by wall-clock time.", heads, rows)


def _cells(records: list[Record]) -> Table:
    rows = []
    for name, here in of_problems(records, PARTICLES).items():
        some = [r for r in here if r.setting == throughput.LISTED and r.seconds]
        rates = [r.extra["collisions_per_second"] for r in some]
        for row, rate in zip(some, rates, strict=True):
            default = ", the default" if row.extra["is_default"] else ""
            listed = f"{row.value:g}{default}"
            rows.append([name, listed, f"{rate / 1e6:.1f}", f"{rate / max(rates):.2f}"])
    words = "Size of the cells that index the scatterers, as the mean number that one lists:"
    heads = ["medium", "listed", "million collisions per second", "over the most"]
    return Table("", words, heads, rows)


def _failures(records: list[Record]) -> Table:
    rows = [
        [
            r.status,
            r.problem,
            r.method,
            r.setting if r.value is None else f"{r.setting} {r.value:g}",
            r.note,
        ]
        for r in analysis.not_done(records)
    ]
    heads = ["status", "problem", "method", "setting", "why"]
    return Table("Failed and not available", "", heads, rows)
