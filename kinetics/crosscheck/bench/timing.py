"""Run times: quartiles over repeats, the first call apart."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

LONG = 1.0  # s; longer work is timed once
TOO_LONG = 60.0  # s; longer work is not repeated at all, for the sake of the others

Clock = Callable[[], float]
K = TypeVar("K")


@dataclass(frozen=True)
class Timing:
    """Seconds of one piece of work.

    Attributes
    ----------
    cpu : lower quartile, median and upper quartile of the processor time of all threads: for work
        of one thread it is the run time on an idle machine
    wall : the same of the wall-clock time
    warm_up : the first call, which is not among the repeats, wall-clock
    repeats : how many
    """

    cpu: tuple[float, float, float]
    wall: tuple[float, float, float]
    warm_up: float
    repeats: int


@dataclass(frozen=True)
class Effort:
    """How long a measurement may take.

    Attributes
    ----------
    quick : fewer cases
    least, most : repeats
    seconds : beyond the least repeats a piece of work is repeated until it has had so many s
    """

    quick: bool
    least: int
    most: int
    seconds: float

    def repeats(self, seconds: float, least: int) -> int:
        """How many repeats a piece of work gets that takes so many s."""
        if seconds >= LONG:
            return max(1, least // 5)
        return max(least, min(self.most, math.ceil(self.seconds / max(seconds, 1e-6))))


QUICK = Effort(quick=True, least=3, most=11, seconds=0.04)
FULL = Effort(quick=False, least=5, most=25, seconds=0.12)


def measure_together(
    works: Mapping[K, Callable[[], Any]],
    effort: Effort,
    keep: Callable[[K, Any], None] | None = None,
    least: Mapping[K, int] | None = None,
    clocks: tuple[Clock, Clock] = (time.perf_counter, time.process_time),
) -> dict[K, Timing | Exception]:
    """Times of several pieces of work, or what one of them raised.

    Each is called once, which may compile and is never a time; then once more, which says how often
    it is repeated; then the repeats of all are spread evenly over the whole, so that a slow stretch
    of the machine is in the spread of every row, and decides none. Work that takes more than a
    second is timed once; more than a minute, it is a failure.

    keep(name, result) gets the result of every call, outside the time. least: repeats of some of
    the works, where not those of the effort. clocks: of the wall and of the processor.
    """
    found: dict[K, list[tuple[float, float]]] = {name: [] for name in works}
    failures: dict[K, Exception] = {}

    def call(names: Iterable[K]) -> None:
        for name in names:
            if name in failures:
                continue
            try:
                begin = [clock() for clock in clocks]
                result = works[name]()
                wall, cpu = (clock() - b for clock, b in zip(clocks, begin, strict=True))
                if keep is not None:
                    keep(name, result)
            except Exception as met:  # of one work: the others go on
                failures[name] = met
                continue
            found[name].append((wall, cpu))
            if len(found[name]) == 1 and min(wall, cpu) > TOO_LONG:
                why = f"its first call took {cpu:.0f} s: not repeated"
                failures[name] = TimeoutError(why)

    call(works)
    call(works)
    turns = []
    for name in works:
        if name not in failures:
            # the least of all four times: others on the machine make none of them shorter
            seconds = min(t for pair in found[name] for t in pair)
            more = effort.repeats(seconds, (least or {}).get(name, effort.least)) - 1
            turns += [((j + 0.5) / more, name) for j in range(more)]
    call(name for _, name in sorted(turns, key=lambda turn: turn[0]))
    return {name: failures.get(name) or _summary(found[name]) for name in works}


def _summary(pairs: list[tuple[float, float]]) -> Timing:
    """The timing that pairs of wall-clock and processor time come to, the first of them apart."""
    wall, cpu = (
        (float(low), float(median), float(high))
        for low, median, high in np.percentile(pairs[1:], [25, 50, 75], axis=0).T
    )
    return Timing(cpu, wall, pairs[0][0], len(pairs) - 1)
