"""Run times: medians over repeats with their spread, the warm-up apart."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
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
    yardstick : median of the processor time of `yardstick` among the same repeats, in s; None where
        it was not measured
    """

    cpu: Spread
    wall: Spread
    warm_up: float
    repeats: int
    yardstick: float | None = None


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


QUICK = Effort(quick=True, least=3, most=11, seconds=0.04)
FULL = Effort(quick=False, least=5, most=25, seconds=0.12)


LONG = 1.0  # s; longer work is timed once
TOO_LONG = 60.0  # s; longer work is not timed at all, for the sake of the others

Clock = Callable[[], float]
_GOLDEN = 0.5 * (5.0**0.5 - 1.0)
_GAUGE = object()  # its name among the works
_GAUGE_REPEATS = 51  # its median enters every ratio
K = TypeVar("K")


def spread(seconds: list[float]) -> Spread:
    """Median, quartiles and least of measured times."""
    least, low, median, high = (float(q) for q in np.percentile(seconds, [0, 25, 50, 75]))
    return Spread(median, low, high, least)


def summary(wall: list[float], cpu: list[float], warm_up: float) -> Timing:
    """The timing that the repeats come to."""
    return Timing(spread(cpu), spread(wall), warm_up, len(wall))


def yardstick() -> None:
    """Work that no change of the package changes, of about a ms: what the machine is worth now.

    Half of it is arithmetic of the interpreter, half is that of arrays; of one thread always.
    """
    total = 0
    for k in range(16_000):
        total += k * k % 7
    a = np.linspace(0.0, 1.0, 8000)
    for _ in range(16):
        a = np.exp(-a) * a + 0.1


def measure(
    work: Callable[[], Any],
    effort: Effort,
    clock: Clock = time.perf_counter,
    cpu_clock: Clock = time.process_time,
    gauge: Callable[[], Any] | None = yardstick,
) -> tuple[Any, Timing]:
    """The first result of one piece of work, and how long it takes; its exception is raised."""
    results: list[Any] = []

    def keep(_: None, result: Any) -> None:
        results[:] = results or [result]

    found = measure_together({None: work}, effort, keep, None, clock, cpu_clock, gauge)[None]
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
    gauge: Callable[[], Any] | None = yardstick,
) -> dict[K, Timing | Exception]:
    """Times of several pieces of work, or what one of them raised.

    Each is called once, which may compile and is never a time; then once more, which says how
    often it has to be repeated; then the repeats of all are spread evenly over the whole, so that
    a slow stretch of the machine is in the spread of every row, and decides none. Work that takes
    more than a second is timed once; more than a minute, it is a failure.

    keep(name, result) gets the result of every call, outside the time. least: repeats of some of
    the works, where not those of the effort. gauge: repeated like the works; `Timing.yardstick`.
    """
    found: dict[Any, _Repeats] = {}
    failures: dict[Any, Exception] = {}
    all_works: dict[Any, Callable[[], Any]] = {**works, **({_GAUGE: gauge} if gauge else {})}

    def call(name: Any) -> tuple[float, float] | None:
        try:
            begin, cpu_begin = clock(), cpu_clock()
            result = all_works[name]()
            seconds, cpu = clock() - begin, cpu_clock() - cpu_begin
            if keep is not None and name is not _GAUGE:
                keep(name, result)
        except Exception as met:  # of one work: the others go on
            failures[name] = met
            return None
        return seconds, cpu

    def repeat(names: Iterable[Any]) -> None:
        for name in names:
            if name not in failures and (took := call(name)) is not None:
                found[name].add(*took)

    for name in all_works:
        if (took := call(name)) is None:
            continue
        if min(took) > TOO_LONG:
            failures[name] = TimeoutError(f"its first call took {took[1]:.0f} s: not repeated")
            continue
        found[name] = _Repeats(took[0])
    repeat(list(found))
    some: Mapping[Any, int] = {_GAUGE: _GAUGE_REPEATS, **(least or {})}
    counts = {k: r.wanted(effort, some.get(k, effort.least)) for k, r in found.items()}
    plan = [
        # evenly, and no two works in step: their first turns are at multiples of the golden section
        ((j + _GOLDEN * k % 1.0) / (n - 1), name)
        for k, (name, n) in enumerate(counts.items())
        for j in range(n - 1)
    ]
    repeat(name for _, name in sorted(plan, key=lambda turn: turn[0]))
    unit = found[_GAUGE].timing().cpu.median if gauge else None
    return {
        name: failures.get(name) or replace(found[name].timing(), yardstick=unit) for name in works
    }


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
        first = min(self.wall[0], self.cpu[0])  # others on the machine make it no longer
        if min(first, self.warm_up) >= LONG:
            return max(1, least // 5)
        # not divided by a time that may be zero
        enough = (n for n in range(1, effort.most) if n * first >= effort.seconds)
        return max(least, next(enough, effort.most))

    def timing(self) -> Timing:
        return summary(self.wall, self.cpu, self.warm_up)
