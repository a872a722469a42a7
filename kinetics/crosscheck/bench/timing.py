"""Run times: medians over repeats with their spread, the warm-up apart."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Spread:
    """Median and quartiles, in s."""

    median: float
    low: float
    high: float


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
    seconds : after the least repeats a piece of work is repeated until it has had so many s
    """

    quick: bool
    least: int
    most: int
    seconds: float


QUICK = Effort(quick=True, least=3, most=15, seconds=0.05)
FULL = Effort(quick=False, least=5, most=25, seconds=0.12)


Clock = Callable[[], float]


def spread(seconds: list[float]) -> Spread:
    """Median and quartiles of measured times."""
    low, median, high = (float(q) for q in np.percentile(seconds, [25, 50, 75]))
    return Spread(median, low, high)


def summary(wall: list[float], cpu: list[float], warm_up: float) -> Timing:
    """The timing that the repeats come to."""
    return Timing(spread(cpu), spread(wall), warm_up, len(wall))


def measure(
    work: Callable[[], Any],
    effort: Effort,
    clock: Clock = time.perf_counter,
    cpu_clock: Clock = time.process_time,
) -> tuple[Any, Timing]:
    """The result of the work, and how long it takes. What takes more than a second is timed once.

    The first call may compile, and is never the time.
    """
    result, warm_up, _ = _once(work, clock, cpu_clock)
    least = effort.least if warm_up < 1.0 else 1
    seconds: list[float] = []
    processor: list[float] = []
    while len(seconds) < least or (sum(seconds) < effort.seconds and len(seconds) < effort.most):
        _, wall, cpu = _once(work, clock, cpu_clock)
        seconds.append(wall)
        processor.append(cpu)
    return result, summary(seconds, processor, warm_up)


def measure_together(
    works: dict[str, Callable[[], Any]],
    effort: Effort,
    clock: Clock = time.perf_counter,
    cpu_clock: Clock = time.process_time,
) -> dict[str, Timing]:
    """Times of several pieces of work, in turns: a disturbance hits all alike. For ratios."""
    warm_up = {name: _once(work, clock, cpu_clock)[1] for name, work in works.items()}
    seconds: dict[str, list[float]] = {name: [] for name in works}
    processor: dict[str, list[float]] = {name: [] for name in works}
    spent, rounds = 0.0, 0
    while rounds < effort.least or (spent < effort.seconds * len(works) and rounds < effort.most):
        for name, work in works.items():
            _, wall, cpu = _once(work, clock, cpu_clock)
            seconds[name].append(wall)
            processor[name].append(cpu)
            spent += wall
        rounds += 1
    return {name: summary(seconds[name], processor[name], warm_up[name]) for name in works}


def _once(work: Callable[[], Any], clock: Clock, cpu_clock: Clock) -> tuple[Any, float, float]:
    begin, cpu_begin = clock(), cpu_clock()
    result = work()
    return result, clock() - begin, cpu_clock() - cpu_begin
