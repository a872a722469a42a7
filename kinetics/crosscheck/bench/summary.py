"""The first table of a benchmark, short enough for a README."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from kinetics.crosscheck.bench import precision
from kinetics.crosscheck.bench.analysis import NOT_REACHED, Cost, cost_at, of_problem, problems
from kinetics.crosscheck.bench.markdown import cost_text, table
from kinetics.crosscheck.bench.methods import METHODS
from kinetics.crosscheck.bench.names import family, typeset
from kinetics.crosscheck.bench.record import Record

if TYPE_CHECKING:
    from kinetics.crosscheck.bench.report import BenchReport


def summary(report: BenchReport) -> Iterator[str]:
    """A line for each family of problems and method: short enough for a README."""
    families: dict[str, list[list[Record]]] = {}
    for problem in problems(report.records, precision.SECTION):
        here = of_problem(report.records, precision.SECTION, problem)
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
            cells = [cost_text(_middle(members, method, target)) for target in (1e-3, 1e-8)]
            rows.append([typeset(name), method, *cells, f"{sorted(least)[len(least) // 2]:.0e}"])
    if not rows:
        return
    yield "## Summary"
    yield ""
    yield (
        "Run time of one thread for an error of 10⁻³ and of 10⁻⁸, and the least error reached: "
        "medians over the restitutions and starts. ≥: not reached; what its order would take at "
        "least. -: it does not get there."
    )
    yield ""
    yield from table(["problem", "method", "10⁻³", "10⁻⁸", "least error"], rows)


def _middle(members: list[list[Record]], method: str, target: float) -> Cost:
    """The median over the problems of a family, the upper one of two; not reached is the most."""
    costs = [cost_at(here, method, target) for here in members]
    costs.sort(key=lambda c: math.inf if c.how == NOT_REACHED else c.seconds)
    return costs[len(costs) // 2]
