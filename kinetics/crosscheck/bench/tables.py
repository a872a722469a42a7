"""The tables of a benchmark, in Markdown."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from kinetics.crosscheck.bench import (
    accuracy,
    cores,
    cost,
    floors,
    position,
    precision,
    skipping,
    startup,
    throughput,
)
from kinetics.crosscheck.bench.analysis import (
    AT_LEAST,
    NOT_REACHED,
    TARGETS,
    asked_and_reached,
    cost_at,
    left_and_below,
    not_done,
    of_problem,
    problems,
    too_accurate,
)
from kinetics.crosscheck.bench.markdown import cost_text, digits, seconds_text, table
from kinetics.crosscheck.bench.methods import (
    METHODS,
    MONTE_CARLO,
    PRINTED,
    SPECTRAL,
    STRAIGHTFORWARD,
)
from kinetics.crosscheck.bench.names import typeset
from kinetics.crosscheck.bench.record import MEASURED, Record
from kinetics.crosscheck.bench.summary import summary

if TYPE_CHECKING:
    from kinetics.crosscheck.bench.report import BenchReport


def lines(report: BenchReport) -> Iterator[str]:
    """All tables, from the shortest on."""
    about = ", ".join(f"{k.replace('_', ' ')} {v}" for k, v in report.machine.items())
    yield f"# Benchmark{' (quick)' if report.quick else ''}"
    yield ""
    yield (
        f"{about}. {report.seconds:.0f} s in all. Times are medians over repeats, which are "
        "made in turns: processor time of one thread where nothing else is said, so that others on "
        "the machine do not count."
    )
    yield ""
    for part in (summary, _precision, _ratios, _monte_carlo, _accuracy, _skipping, _cost, _floors,
                 _particles, _cells, _cores, _first_use, _failures):  # fmt: skip
        yield from part(report)


def _precision(report: BenchReport) -> Iterator[str]:
    names = problems(report.records, precision.SECTION)
    if not names:
        return
    yield "## Run time for an error"
    yield ""
    yield (
        "≥: not reached; the least that it would take from its most accurate run, by the order of "
        "the scheme. -: the method does not get there."
    )
    yield ""
    rows = []
    for problem in names:
        here = of_problem(report.records, precision.SECTION, problem)
        for method in METHODS:
            mine = [r for r in here if r.method == method]
            done = [r for r in mine if r.status == MEASURED and r.error is not None]
            if not done:
                continue
            best = min(r.error for r in done if r.error is not None)
            cells = [cost_text(cost_at(here, method, target)) for target in TARGETS]
            rows.append([problem, method, *cells, f"{best:.1e}"])
    heads = ["problem", "method", *(f"{t:.0e}" for t in TARGETS), "least error measured"]
    yield from table(heads, rows)
    notes = [text for row in report.records if (text := _note(row))]
    if notes:
        yield from (*notes, "")
    beaten = left_and_below(list(report.records), precision.SECTION, SPECTRAL, 1e-3)
    if beaten:
        yield "Below an error of 1e-3 the spectral solver is not the quickest here:"
        yield ""
        yield from (f"- {line}" for line in beaten)
    else:
        yield "Below an error of 1e-3 no other method is quicker than the spectral solver anywhere."
    yield ""


def _note(row: Record) -> str:
    """What the table of run times has no place for."""
    if row.section == precision.SECTION and row.method == position.REFERENCE:
        return f"- Reference of {row.problem}, rtol = {row.value:.0e}: {row.note}."
    if row.section == precision.SECTION and row.method == PRINTED and row.error is not None:
        return f"- {row.problem}, {row.setting}: error {row.error:.2g}."
    return ""


def _ratios(report: BenchReport) -> Iterator[str]:
    rows = []
    for problem in problems(report.records, precision.SECTION):
        here = of_problem(report.records, precision.SECTION, problem)
        cells = []
        for target in (1e-3, 1e-8):
            mine = cost_at(here, SPECTRAL, target)
            other = cost_at(here, STRAIGHTFORWARD, target)
            if NOT_REACHED in (mine.how, other.how):
                cells.append("-")
                continue
            text = digits(other.seconds / mine.seconds)
            cells.append(f"≥ {text}" if other.how == AT_LEAST else text)
        if any(cell != "-" for cell in cells):
            rows.append([problem, *cells])
    if rows:
        yield "## Straightforward over spectral solver, ratio of run times at an error"
        yield ""
        yield from table(["problem", "1e-3", "1e-8"], rows)


def _monte_carlo(report: BenchReport) -> Iterator[str]:
    rows = []
    for problem in problems(report.records, precision.SECTION):
        here = of_problem(report.records, precision.SECTION, problem)
        need = throughput.monte_carlo_need([r for r in here if r.method == MONTE_CARLO])
        if math.isfinite(need["samples"]):
            rows.append(
                [problem, f"{need['slope']:.2f}", f"{need['samples']:.0e}", digits(need["years"])]
            )
    if rows:
        yield "## What Monte Carlo would need for 1e-10"
        yield ""
        seeds = [r.extra["seeds"] for r in report.records if "seeds" in r.extra]
        if seeds:
            yield f"Errors are root mean squares over seeds, {min(seeds)} to {max(seeds)} a row."
            yield ""
        yield from table(["problem", "error ~ samples^", "samples", "years of one processor"], rows)


def _accuracy(report: BenchReport) -> Iterator[str]:
    rows = [
        [
            f"{row['asked']:.0e}",
            str(row["problems"]),
            f"{row['best']:.1e}",
            f"{row['median']:.1e}",
            f"{row['worst']:.1e}",
            str(row["missed"]),
            str(row["missed_and_said"]),
            str(row["beyond_100"]),
        ]
        for row in asked_and_reached(report.records)
    ]
    if not rows:
        return
    yield "## Error reached over error asked"
    yield ""
    heads = ["rtol", "problems", "least", "median", "most", "missed without a word",
             "missed, status says so", "100 times better"]  # fmt: skip
    yield from table(heads, rows)
    missed = [
        r
        for r in report.records
        if r.section == accuracy.SECTION and r.note == accuracy.MISSED and r.error
    ]
    worst = sorted(missed, key=lambda r: -r.extra["ratio"])[:5]
    if worst:
        yield from (f"- {r.problem}: asked {r.asked:.0e}, reached {r.error:.1e}" for r in worst)
        yield ""
    beyond = too_accurate(report.records)
    if beyond:
        yield "More than 100 times better than asked:"
        yield ""
        heads = ["problems", "pairs of errors", "least reached/asked", "at", "rtol"]
        yield from table(heads, [
            [typeset(name), f"{count} of {total}", f"{least.extra['ratio']:.0e}",
             typeset(least.problem), f"{least.asked:.0e}"]
            for name, count, total, least in beyond
        ])  # fmt: skip


def _skipping(report: BenchReport) -> Iterator[str]:
    rows = [
        [r.problem, r.method, seconds_text(r.seconds), digits(r.extra["ratio"])]
        for r in report.records
        if r.section == skipping.SECTION and r.status == MEASURED
    ]
    if rows:
        yield "## What skipping saves"
        yield ""
        yield from table(["scene", "asked for", "time", "whole scene's time over it"], rows)


def _cost(report: BenchReport) -> Iterator[str]:
    here = [r for r in report.records if r.section == cost.SECTION and r.status == MEASURED]
    rows = []
    for row in (r for r in here if "exponent" in r.extra):
        setting = row.setting.split(",")[0]
        points = [
            r
            for r in here
            if (r.problem, r.method, r.setting) == (row.problem, row.method, setting)
        ]
        if points:
            first, last = points[0], points[-1]
            exponent = row.extra["exponent"]
            rows.append(
                [
                    row.problem,
                    row.method,
                    f"{setting} {first.value:g} to {last.value:g}",
                    f"{seconds_text(first.seconds)} to {seconds_text(last.seconds)}",
                    "-" if exponent is None else f"{exponent:.2f}",
                ]
            )
    if rows:
        yield "## Cost against work"
        yield ""
        yield from table(["problem", "method", "work", "run time", "exponent"], rows)


def _floors(report: BenchReport) -> Iterator[str]:
    yield from floors.lines(report.records)


def _particles(report: BenchReport) -> Iterator[str]:
    here = [r for r in report.records if r.section == throughput.SECTION and r.status == MEASURED]
    rows = []
    for name in dict.fromkeys(r.problem for r in here if r.setting != throughput.LISTED):
        rates = {r.threads: r.extra["collisions_per_second"] for r in here if r.problem == name}
        placing = next(r.extra["placing_seconds_per_medium"] for r in here if r.problem == name)
        rows.append(
            [name, *(f"{rates[n] / 1e6:.1f}" if n in rates else "-" for n in (1, 2)),
             seconds_text(placing)]
        )  # fmt: skip
    if rows:
        yield "## Particles, e = 0.9: million collisions per second"
        yield ""
        yield "Of two threads by wall-clock time."
        yield ""
        yield from table(["medium", "1 thread", "2 threads", "placing one medium"], rows)


def _cells(report: BenchReport) -> Iterator[str]:
    here = [
        r
        for r in report.records
        if r.section == throughput.SECTION and r.setting == throughput.LISTED and r.seconds
    ]
    rows = []
    for name in dict.fromkeys(r.problem for r in here):
        rates = {r.value: r.extra["collisions_per_second"] for r in here if r.problem == name}
        for listed, rate in rates.items():
            default = ", the default" if listed == throughput.default_listed() else ""
            ratio = rate / max(rates.values())
            rows.append([name, f"{listed:g}{default}", f"{rate / 1e6:.1f}", f"{ratio:.2f}"])
    if rows:
        yield "Size of the cells that index the scatterers, as the mean number that one lists:"
        yield ""
        heads = ["medium", "listed", "million collisions per second", "over the most"]
        yield from table(heads, rows)


def _cores(report: BenchReport) -> Iterator[str]:
    here = [r for r in report.records if r.section == cores.SECTION and r.seconds]
    rows = []
    for key in dict.fromkeys((r.problem, r.method) for r in here):
        times = {r.threads: r.seconds for r in here if (r.problem, r.method) == key}
        if {1, 2} <= set(times) and times[1] and times[2]:
            rows.append(
                [*key, seconds_text(times[1]), seconds_text(times[2]), f"{times[1] / times[2]:.2f}"]
            )
    if rows:
        yield "## One core and two, wall-clock time"
        yield ""
        yield (
            "BDF of the straightforward solver takes turns between products (numpy) and solves "
            "(scipy) of less than 0.1 ms each. The two have linear algebra of their own, and with "
            "two threads each has a thread that waits where the other would work: it loses time."
        )
        yield ""
        yield from table(["problem", "method", "1 thread", "2 threads", "ratio"], rows)


def _first_use(report: BenchReport) -> Iterator[str]:
    rows = [
        [r.problem, seconds_text(r.seconds), seconds_text(r.wall)]
        for r in report.records
        if r.section == startup.SECTION and r.status == MEASURED
    ]
    if rows:
        yield "## First use"
        yield ""
        yield from table(["what", "processor time", "wall-clock time"], rows)


def _failures(report: BenchReport) -> Iterator[str]:
    rows = [
        [
            r.status,
            r.problem,
            r.method,
            r.setting if r.value is None else f"{r.setting} {r.value:g}",
            r.note,
        ]
        for r in not_done(report.records)
    ]
    if rows:
        yield "## Failed and not available"
        yield ""
        yield from table(["status", "problem", "method", "setting", "why"], rows)
