"""Measures pieces of work in turns: run time as quartiles over repeats, error, failures.

Every measured row of a benchmark is a `Work`, and `measure` makes the rows of many of them.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from kinetics.crosscheck.bench.record import Record, failed

LONG = 1.0  # s; longer work is timed once
TOO_LONG = 60.0  # s; longer work is not repeated at all, for the sake of the others

Clock = Callable[[], float]


@dataclass(frozen=True)
class Effort:
    """How long a measurement may take.

    Attributes
    ----------
    quick : fewer cases
    least, most : repeats
    seconds : beyond the least repeats a piece of work is repeated until it has had so many s
    least_seeded : repeats of random work, for a root mean square that shows how the error falls
    """

    quick: bool
    least: int
    most: int
    seconds: float
    least_seeded: int = 1

    def repeats(self, seconds: float, seeded: bool) -> int:
        """How many repeats a piece of work gets that takes so many s."""
        least = max(self.least, self.least_seeded) if seeded else self.least
        if seconds >= LONG:
            return max(1, least // 5)
        return max(least, min(self.most, math.ceil(self.seconds / max(seconds, 1e-6))))


QUICK = Effort(quick=True, least=3, most=11, seconds=0.04, least_seeded=5)
FULL = Effort(quick=False, least=5, most=25, seconds=0.12, least_seeded=10)


@dataclass
class Work:
    """One row that is to be measured, and what its calls have given so far.

    Attributes
    ----------
    section, problem, method, setting, value, threads : as of the row, see `Record`
    call : solves the problem
    error : of what the call gives; None where only the time counts
    seeded : the work is random and takes a seed. Every call gets its own, and the error of the row
        is the root mean square over all of them
    figures : further figures of what the call gives, by name
    """

    section: str
    problem: str
    method: str
    call: Callable[..., Any]
    setting: str = ""
    value: float | None = None
    error: Callable[[Any], float] | None = None
    seeded: bool = False
    threads: int = 1
    figures: Callable[[Any], dict[str, Any]] = lambda _: {}
    times: list[tuple[float, float]] = field(default_factory=list, init=False)
    errors: list[float] = field(default_factory=list, init=False)
    extra: dict[str, Any] = field(default_factory=dict, init=False)
    failure: Exception | str = field(default="", init=False)

    def run(self, clocks: tuple[Clock, Clock]) -> None:
        """Call it once, unless it has failed. Whatever it raises is kept: the others go on."""
        if isinstance(self.failure, Exception):
            return
        try:
            begin = [clock() for clock in clocks]
            result = self.call(len(self.times) + 1) if self.seeded else self.call()
            wall, cpu = (clock() - b for clock, b in zip(clocks, begin, strict=True))
            self._look_at(result)
        except Exception as met:
            self.failure = met
            return
        self.times.append((wall, cpu))
        if len(self.times) == 1 and min(wall, cpu) > TOO_LONG:
            self.failure = TimeoutError(f"its first call took {cpu:.0f} s: not repeated")

    def _look_at(self, result: Any) -> None:
        """The error of a result; work that is not random has the same one in every call."""
        self.extra = self.figures(result)
        if self.error is None or (self.errors and not self.seeded):
            return
        self.errors.append(self.error(result))
        if not math.isfinite(self.errors[-1]) and not self.failure:
            found = np.concatenate([np.ravel(x) for x in np.atleast_1d(result)])
            count = int(np.sum(~np.isfinite(found)))
            self.failure = f"{count} of {found.size} values are no finite number"

    def record(self) -> Record:
        """The row. Times of one thread are of the processor, of more threads of the wall clock."""
        row = (self.section, self.problem, self.method)
        where: dict[str, Any] = {
            "setting": self.setting,
            "value": None if self.value is None else float(self.value),
            "asked": self.value if self.setting == "rtol" else None,
            "threads": self.threads,
        }
        if isinstance(self.failure, Exception):
            return failed(*row, self.failure, **where)
        # the first call is not among the repeats
        wall, cpu = np.percentile(self.times[1:], [25, 50, 75], axis=0).T.tolist()
        low, median, high = cpu if self.threads == 1 else wall
        if self.failure:
            return failed(*row, self.failure, seconds=median, **where)
        seeds = {"seeds": len(self.errors)} if self.seeded else {}
        return Record(
            *row,
            **where,
            seconds=median,
            low=low,
            high=high,
            wall=wall[1],
            warm_up=self.times[0][0],
            repeats=len(self.times) - 1,
            error=float(np.sqrt(np.mean(np.square(self.errors)))) if self.errors else None,
            extra=self.extra | seeds,
        )


def sweep(
    section: str,
    problem: str,
    method: str,
    setting: str,
    values: Sequence[float | None],
    solve: Callable[..., Any],
    **others: Any,
) -> list[Work]:
    """One method on one problem for many values of a setting.

    solve takes the value, and the seed after it where the work is seeded. others: see `Work`.
    """
    return [
        Work(section, problem, method, partial(solve, value), setting, value, **others)
        for value in values
    ]


def measure(
    works: Sequence[Work],
    effort: Effort,
    clocks: tuple[Clock, Clock] = (time.perf_counter, time.process_time),
) -> list[Record]:
    """A row for each piece of work, in their order; what fails is a row too.

    Each is called once, which may compile and is never a time; then once more, which says how often
    it is repeated; then the repeats of all are spread evenly over the whole, so that a slow stretch
    of the machine is in the spread of every row, and decides none. Work that takes more than a
    second is timed once; more than a minute, it is a failure.

    clocks: of the wall and of the processor, in s.
    """
    for work in (*works, *works):
        work.run(clocks)
    turns = []
    for work in works:
        if not isinstance(work.failure, Exception):
            # the least of all four times: others on the machine make none of them shorter
            seconds = min(t for pair in work.times for t in pair)
            more = effort.repeats(seconds, work.seeded) - 1
            turns += [((j + 0.5) / more, work) for j in range(more)]
    for _, work in sorted(turns, key=lambda turn: turn[0]):
        work.run(clocks)
    return [work.record() for work in works]
