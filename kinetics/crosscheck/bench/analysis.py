"""What measured rows say: the run time for a given error, and error asked against reached."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass

from kinetics.crosscheck.bench.methods import CONSERVATIVE, MONTE_CARLO, STRAIGHTFORWARD
from kinetics.crosscheck.bench.record import MEASURED, Record

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


def of_problems(rows: Iterable[Record], section: str) -> dict[str, list[Record]]:
    """The rows of each problem of a section, in their order."""
    found: dict[str, list[Record]] = {}
    for row in rows:
        if row.section == section:
            found.setdefault(row.problem, []).append(row)
    return found


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


def middle_cost(problems: Iterable[list[Record]], method: str, target: float) -> Cost:
    """The median over several problems, the upper one of two; not reached is the most."""
    costs = [cost_at(rows, method, target) for rows in problems]
    costs.sort(key=lambda c: math.inf if c.how == NOT_REACHED else c.seconds)
    return costs[len(costs) // 2]


def middle_least_error(problems: Iterable[list[Record]], method: str) -> float | None:
    """The median over several problems of the least error that the method reached; None if none."""
    least = []
    for rows in problems:
        errors = [r.error for r in rows if r.method == method and r.error is not None]
        least += [min(errors)] if errors else []
    return sorted(least)[len(least) // 2] if least else None
