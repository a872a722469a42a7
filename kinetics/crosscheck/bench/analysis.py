"""What measured rows say: run time at a given error, ratios of methods, summaries. No measuring."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from kinetics.crosscheck.bench.accuracy import BETTER, MISSED, MISSED_AND_SAID
from kinetics.crosscheck.bench.methods import CONSERVATIVE, MONTE_CARLO, STRAIGHTFORWARD
from kinetics.crosscheck.bench.names import family
from kinetics.crosscheck.bench.record import FAILED, MEASURED, NOT_AVAILABLE, Record

TARGETS = (1e-3, 1e-6, 1e-8, 1e-10)
# Time ~ error^-q at best, of the methods whose error falls without end: the order of the scheme,
# and the least work that it can do. Of the straightforward solver: second order, and filling the
# matrix; of the conservative one: second order, and one sweep; of Monte Carlo: 1/sqrt(samples).
_AT_BEST = {STRAIGHTFORWARD: 1.0, CONSERVATIVE: 0.5, MONTE_CARLO: 2.0}
_NO_ANSWER = 0.5  # a larger error than this is no point of a curve that converges
MEASURED_THERE, AT_LEAST, NOT_REACHED = "measured", "at least", "not reached"


@dataclass(frozen=True)
class Cost:
    """Seconds for an error, and how they are known: measured, at least, or not reached (NaN)."""

    seconds: float
    how: str


def front(rows: Iterable[Record]) -> list[Record]:
    """Rows that no other one beats in both time and error, from the quickest on."""
    best: list[Record] = []
    usable = [r for r in rows if r.status == MEASURED and r.error is not None and r.seconds]
    for row in sorted(usable, key=lambda r: (r.seconds or 0.0, r.error or 0.0)):
        if not best or (row.error or 0.0) < (best[-1].error or 0.0):
            best.append(row)
    return best


def cost_at(rows: Iterable[Record], method: str, target: float) -> Cost:
    """The least time in which a method reached the error.

    Where it was not reached but can be, the least that it would take, from its most accurate point.
    """
    points = front(r for r in rows if r.method == method)
    for row in points:
        if row.error is not None and row.seconds is not None and row.error <= target:
            return Cost(row.seconds, MEASURED_THERE)
    if method not in _AT_BEST or not points:
        return Cost(math.nan, NOT_REACHED)
    error, seconds = points[-1].error or 0.0, points[-1].seconds or 0.0
    if error > _NO_ANSWER:
        return Cost(math.nan, NOT_REACHED)
    return Cost(seconds * (error / target) ** _AT_BEST[method], AT_LEAST)


def problems(rows: Iterable[Record], section: str) -> list[str]:
    """Names of the problems of a section, in their order."""
    return list(dict.fromkeys(r.problem for r in rows if r.section == section))


def of_problem(rows: Iterable[Record], section: str, problem: str) -> list[Record]:
    """The rows of one problem."""
    return [r for r in rows if r.section == section and r.problem == problem]


def asked_and_reached(rows: Iterable[Record]) -> list[dict[str, float]]:
    """Per rtol: how many problems, the range of reached/asked, and how many missed."""
    table = []
    rows = [r for r in rows if r.section == "accuracy" and r.status == MEASURED]
    for rtol in sorted({r.asked for r in rows if r.asked}, reverse=True):
        here = [r for r in rows if r.asked == rtol]
        ratios = np.array([r.extra["ratio"] for r in here])
        table.append(
            {
                "asked": rtol,
                "problems": len(here),
                "best": float(ratios.min()),
                "median": float(np.median(ratios)),
                "worst": float(ratios.max()),
                "missed": sum(r.note == MISSED for r in here),
                "missed_and_said": sum(r.note == MISSED_AND_SAID for r in here),
                "beyond_100": sum(r.note == BETTER for r in here),
            }
        )
    return table


def too_accurate(rows: Iterable[Record]) -> list[tuple[str, int, int, Record]]:
    """By family of problems: how many pairs of errors are better than asked by more than is asked
    for, of how many, and the pair that is so most. Families with none are left out.
    """
    families: dict[str, list[Record]] = {}
    for row in rows:
        if row.section == "accuracy" and row.status == MEASURED and row.asked:
            families.setdefault(family(row.problem), []).append(row)
    found = []
    for name, some in families.items():
        count = sum(r.note == BETTER for r in some)
        if count:
            found.append((name, count, len(some), min(some, key=lambda r: r.extra["ratio"])))
    return found


def left_and_below(rows: list[Record], section: str, leader: str, target: float) -> list[str]:
    """Where another method reached an error below the target in less time: one line for each
    problem and method.
    """
    found = []
    for problem in problems(rows, section):
        here = of_problem(rows, section, problem)
        for other in dict.fromkeys(r.method for r in here if r.method != leader):
            quicker = []
            for point in front(r for r in here if r.method == other):
                error, seconds = point.error or 0.0, point.seconds or 0.0
                mine = cost_at(here, leader, error).seconds
                if error < target and not mine < seconds:
                    quicker.append((error, seconds, mine))
            if quicker:
                error, seconds, mine = quicker[0]
                more = f"; {len(quicker) - 1} more, to {quicker[-1][0]:.1e}" if quicker[1:] else ""
                found.append(
                    f"{problem}: {other} reaches {error:.1e} in {seconds:.2g} s, "
                    f"{leader} in {mine:.2g} s{more}"
                )
    return found


def not_done(rows: Iterable[Record]) -> list[Record]:
    """What failed, and what is not available."""
    return [r for r in rows if r.status in (FAILED, NOT_AVAILABLE)]
