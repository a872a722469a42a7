"""How the benchmark measures: repeats in turns, errors of random work, failures as rows."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from kinetics.crosscheck.bench import sweeps, timing
from kinetics.crosscheck.bench.record import FAILED, MEASURED

ONCE = timing.Effort(quick=True, least=1, most=1, seconds=0.0)


class Machine:
    """Work of given seconds on a machine that is slow now and then; all of it is made up."""

    def __init__(self, seconds: dict[str, float], slow: Callable[[float], float] = lambda _: 1.0):
        self.now = 0.0
        self.calls: list[str] = []
        self.slow = slow
        self.works = {name: self.work(name, s) for name, s in seconds.items()}

    def work(self, name: str, seconds: float) -> Callable[[], int]:
        def run() -> int:
            self.calls.append(name)
            self.now += seconds * self.slow(self.now)
            return len(self.calls)

        return run

    def measure(self, effort: timing.Effort, **others: Any) -> dict[str, Any]:
        clocks = (lambda: self.now, lambda: self.now)
        return timing.measure_together(self.works, effort, clocks=clocks, **others)


def test_the_first_call_is_no_time_and_repeats_are_spread_over_the_whole() -> None:
    machine = Machine({"a": 0.001, "b": 0.02, "c": 2.0}, lambda now: 3.0 if now == 0.0 else 1.0)
    effort = timing.Effort(quick=True, least=3, most=12, seconds=0.05)
    kept: list[tuple[str, int]] = []
    found = machine.measure(effort, keep=lambda name, result: kept.append((name, result)))
    assert {name: t.repeats for name, t in found.items()} == {"a": 12, "b": 3, "c": 1}
    assert found["a"].warm_up == pytest.approx(0.003)
    assert found["a"].cpu == pytest.approx((0.001,) * 3)
    assert "".join(machine.calls) == "abcabc" + "aaabaaaaabaaa"
    assert kept == list(zip(machine.calls, range(1, len(kept) + 1), strict=True))
    more = Machine({"a": 0.02, "c": 2.0}).measure(effort, least={"a": 10, "c": 10})
    assert {name: t.repeats for name, t in more.items()} == {"a": 10, "c": 2}


def test_a_slow_stretch_is_in_the_spread_of_all_rows_and_decides_none() -> None:
    # a third of the time everything takes twice as long
    machine = Machine({str(k): 0.01 for k in range(9)}, lambda now: 1 + (0.5 < now < 1.1))
    effort = timing.Effort(quick=True, least=9, most=9, seconds=0.0)
    for found in machine.measure(effort).values():
        assert found.cpu[1] == pytest.approx(0.01)
        assert found.cpu[2] == pytest.approx(0.02)


def test_a_failure_ends_one_work_and_not_the_others() -> None:
    machine = Machine({"a": 0.1, "b": 70.0})

    def fails_later() -> None:
        machine.calls.append("c")
        if machine.calls.count("c") == 3:
            raise ArithmeticError("lost")

    machine.works |= {"c": fails_later, "d": lambda: 1 // 0}
    found = machine.measure(timing.Effort(quick=True, least=4, most=4, seconds=0.0))
    assert found["a"].repeats == 4
    assert str(found["b"]) == "its first call took 70 s: not repeated"
    assert machine.calls.count("b") == 1
    assert isinstance(found["c"], ArithmeticError)
    assert isinstance(found["d"], ZeroDivisionError)


def test_the_error_of_random_work_is_the_rms_over_seeds() -> None:
    seeds: dict[float, list[int]] = {10.0: [], 20.0: []}

    def work(value: float, seed: int) -> float:
        seeds[value].append(seed)
        return float(seed)

    effort = timing.Effort(quick=True, least=1, most=5, seconds=0.0)
    sweep = sweeps.Sweep("s", "p", "m", "samples", (10.0, 20.0), work, float, seeded=True)
    for r in sweeps.run_sweeps([sweep], effort):
        assert seeds[r.value] == list(range(1, 7))
        assert r.extra == {"seeds": 6}
        assert r.error == pytest.approx(math.sqrt(91 / 6))


def test_failures_are_rows() -> None:
    def work(value: int) -> Any:
        if value == 1:
            raise ValueError("too few\nnodes")
        return np.array([np.nan, 1.0]) if value == 2 else np.array([1.0, 1.0])

    sweep = sweeps.Sweep(
        "precision", "p", "m", "nodes", [1, 2, 3], work, lambda x: float(abs(x - 1).max())
    )
    rows = sweeps.run_sweeps([sweep], ONCE)
    assert [r.status for r in rows] == [FAILED, FAILED, MEASURED]
    assert rows[0].note == "ValueError: too few nodes"
    assert rows[1].note == "1 of 2 values are no finite number"
    assert rows[2].error == 0.0
