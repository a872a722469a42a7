"""What measured rows say: run time at a given error, ratios of methods, summaries. No measuring."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from kinetics.crosscheck.bench.accuracy import BETTER, MISSED, MISSED_AND_SAID
from kinetics.crosscheck.bench.methods import CONSERVATIVE, MONTE_CARLO, STRAIGHTFORWARD
from kinetics.crosscheck.bench.record import ACCURACY, FAILED, MEASURED, NOT_AVAILABLE, Record

TARGETS = (1e-3, 1e-6, 1e-8, 1e-10)
YEAR = 365.25 * 86400.0
# Time ~ error^-q at best, of the methods whose error falls without end: the order of the scheme,
# and the least work that it can do. Of the straightforward solver: second order, and filling the
# matrix; of the conservative one: second order, and one sweep; of Monte Carlo: 1/sqrt(samples).
_AT_BEST = {STRAIGHTFORWARD: 1.0, CONSERVATIVE: 0.5, MONTE_CARLO: 2.0}
_NO_ANSWER = 0.5  # a larger error than this is no point of a curve that converges
MEASURED_THERE, AT_LEAST, NOT_REACHED = "measured", "at least", "not reached"
_START = re.compile(r",? ?(gaussian|monoenergetic),")
_RESTITUTION = re.compile(r",? e = [0-9.e-]+$")


def family(problem: str) -> str:
    """The name of a problem without its start and its restitution."""
    return _RESTITUTION.sub("", _START.sub(",", problem))


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


def middle_cost(members: list[list[Record]], method: str, target: float) -> Cost:
    """The median over several problems, the upper one of two; not reached is the most."""
    costs = [cost_at(here, method, target) for here in members]
    costs.sort(key=lambda c: math.inf if c.how == NOT_REACHED else c.seconds)
    return costs[len(costs) // 2]


def of_problems(rows: Iterable[Record], section: str) -> dict[str, list[Record]]:
    """The rows of each problem of a section, in their order."""
    found: dict[str, list[Record]] = {}
    for row in rows:
        if row.section == section:
            found.setdefault(row.problem, []).append(row)
    return found


def asked_and_reached(rows: Iterable[Record]) -> list[dict[str, float]]:
    """Per rtol: how many problems, the range of reached/asked, and how many missed."""
    table = []
    rows = [r for r in rows if r.section == ACCURACY and r.status == MEASURED]
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


def quicker_than(rows: Iterable[Record], section: str, leader: str, target: float) -> list[str]:
    """Where another method reached an error below the target in less time than the leader: one
    line for each problem and method.
    """
    found = []
    for problem, here in of_problems(rows, section).items():
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


def monte_carlo_need(rows: list[Record], target: float = 1e-10) -> dict[str, float]:
    """Samples and years of one processor for a relative error, from measured Monte Carlo rows.

    The value of a row is its samples; error = a/sqrt(samples), a the geometric mean over the rows,
    and the time per sample is that of the row with most samples. "slope" is the fitted exponent of
    the error. NaN without rows.
    """
    good = [(r.value, r.error, r.seconds) for r in rows if r.value and r.error and r.seconds]
    if not good:
        return {"samples": math.nan, "years": math.nan, "slope": math.nan}
    samples, errors, seconds = np.array(sorted(good)).T
    a = float(np.exp(np.mean(np.log(errors * np.sqrt(samples)))))
    need = (a / target) ** 2
    slope = math.nan
    if samples.size > 1:
        slope = float(np.polyfit(np.log(samples), np.log(errors), 1)[0])
    return {"samples": need, "years": need * seconds[-1] / samples[-1] / YEAR, "slope": slope}


def not_done(rows: Iterable[Record]) -> list[Record]:
    """What failed, and what is not available."""
    return [r for r in rows if r.status in (FAILED, NOT_AVAILABLE)]
