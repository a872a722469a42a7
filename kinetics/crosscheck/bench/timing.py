"""Run times: medians over repeats with their spread, the warm-up apart."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np


@dataclass(frozen=True)
class Spread:
    """Median, quartiles and least, in s."""

    median: float
    low: float
    high: float
    least: float


@dataclass(frozen=True)
class Timing:
    """Seconds of one piece of work.

    Attributes
    ----------
    cpu : processor time of all threads over the repeats: what others on the machine take is not in
        it; for work of one thread it is the run time on an idle machine
    wall : wall-clock time over the repeats
    warm_up : the first call, which is not among the repeats, wall-clock, in s
    repeats : how many
    """

    cpu: Spread
    wall: Spread
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


QUICK = Effort(quick=True, least=3, most=15, seconds=0.05)
FULL = Effort(quick=False, least=5, most=25, seconds=0.12)


LONG = 1.0  # s; longer work is timed once

Clock = Callable[[], float]
K = TypeVar("K")


def spread(seconds: list[float]) -> Spread:
    """Median, quartiles and least of measured times."""
    least, low, median, high = (float(q) for q in np.percentile(seconds, [0, 25, 50, 75]))
    return Spread(median, low, high, least)


def summary(wall: list[float], cpu: list[float], warm_up: float) -> Timing:
    """The timing that the repeats come to."""
    return Timing(spread(cpu), spread(wall), warm_up, len(wall))


def measure(
    work: Callable[[], Any],
    effort: Effort,
    clock: Clock = time.perf_counter,
    cpu_clock: Clock = time.process_time,
) -> tuple[Any, Timing]:
    """The first result of one piece of work, and how long it takes; its exception is raised."""
    results: list[Any] = []

    def keep(_: None, result: Any) -> None:
        results[:] = results or [result]

    found = measure_together({None: work}, effort, keep, None, clock, cpu_clock)[None]
    if isinstance(found, Exception):
        raise found
    return results[0], found


def measure_together(
    works: Mapping[K, Callable[[], Any]],
    effort: Effort,
    keep: Callable[[K, Any], None] | None = None,
    least: Mapping[K, int] | None = None,
    clock: Clock = time.perf_counter,
    cpu_clock: Clock = time.process_time,
) -> dict[K, Timing | Exception]:
    """Times of several pieces of work, or what one of them raised.

    Each is called once, which may compile and is never a time; then once more, which says how
    often it has to be repeated; then the repeats of all are spread evenly over the whole, so that
    a slow stretch of the machine is in the spread of every row, and decides none. Work that takes
    more than a second is timed once.

    keep(name, result) gets the result of every call, outside the time. least: repeats of some of
    the works, where not those of the effort.
    """
    found: dict[K, _Repeats] = {}
    failures: dict[K, Exception] = {}

    def call(name: K) -> tuple[float, float] | None:
        try:
            begin, cpu_begin = clock(), cpu_clock()
            result = works[name]()
            seconds, cpu = clock() - begin, cpu_clock() - cpu_begin
            if keep is not None:
                keep(name, result)
        except Exception as met:  # of one work: the others go on
            failures[name] = met
            return None
        return seconds, cpu

    def repeat(names: Iterable[K]) -> None:
        for name in names:
            if name not in failures and (took := call(name)) is not None:
                found[name].add(*took)

    for name in works:
        if (took := call(name)) is not None:
            found[name] = _Repeats(took[0])
    repeat(list(found))
    some = least or {}
    counts = {k: r.wanted(effort, some.get(k, effort.least)) for k, r in found.items()}
    plan = [(j / n, name) for name, n in counts.items() for j in range(1, n)]
    repeat(name for _, name in sorted(plan, key=lambda turn: turn[0]))
    return {name: failures.get(name) or found[name].timing() for name in works}


class _Repeats:
    """Times of one piece of work."""

    def __init__(self, warm_up: float) -> None:
        self.warm_up = warm_up
        self.wall: list[float] = []
        self.cpu: list[float] = []

    def add(self, wall: float, cpu: float) -> None:
        self.wall.append(wall)
        self.cpu.append(cpu)

    def wanted(self, effort: Effort, least: int) -> int:
        """Repeats in all, from the first one; the warm-up may have compiled."""
        if not self.wall:  # it failed
            return 0
        first = self.wall[0]
        if min(first, self.warm_up) >= LONG:
            return max(1, least // 5)
        # not divided by a time that may be zero
        enough = (n for n in range(1, effort.most) if n * first >= effort.seconds)
        return max(least, next(enough, effort.most))

    def timing(self) -> Timing:
        return summary(self.wall, self.cpu, self.warm_up)
