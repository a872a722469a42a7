"""How the benchmark measures: repeats in turns, errors of random work, failures as rows."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from kinetics.crosscheck.bench.measuring import Effort, Work, measure, sweep
from kinetics.crosscheck.bench.record import FAILED, MEASURED

ONCE = Effort(quick=True, least=1, most=1, seconds=0.0)


class Machine:
    """Work of given seconds on a machine that is slow now and then; all of it is made up."""

    def __init__(self, seconds: dict[str, float], slow: Callable[[float], float] = lambda _: 1.0):
        self.now = 0.0
        self.calls: list[str] = []
        self.slow = slow
        self.works = {name: self.work(name, s) for name, s in seconds.items()}

    def work(self, name: str, seconds: float) -> Callable[..., int]:
        def run(seed: int = 0) -> int:
            self.calls.append(name)
            self.now += seconds * self.slow(self.now)
            return len(self.calls)

        return run

    def measure(self, effort: Effort, seeded: bool = False, **others: Any) -> dict[str, Any]:
        works = [Work("s", "p", name, call, seeded=seeded) for name, call in self.works.items()]
        clocks = (lambda: self.now, lambda: self.now)
        return {row.method: row for row in measure(works, effort, clocks, **others)}


def test_the_first_call_is_no_time_and_repeats_are_spread_over_the_whole() -> None:
    machine = Machine({"a": 0.001, "b": 0.02, "c": 2.0}, lambda now: 3.0 if now == 0.0 else 1.0)
    effort = Effort(quick=True, least=3, most=12, seconds=0.05, least_seeded=10)
    found = machine.measure(effort)
    assert {name: row.repeats for name, row in found.items()} == {"a": 12, "b": 3, "c": 1}
    assert found["a"].warm_up == pytest.approx(0.003)
    assert (found["a"].low, found["a"].seconds, found["a"].high) == pytest.approx((0.001,) * 3)
    assert "".join(machine.calls) == "abcabc" + "aaabaaaaabaaa"
    more = Machine({"a": 0.02, "c": 2.0}).measure(effort, seeded=True)
    assert {name: row.repeats for name, row in more.items()} == {"a": 10, "c": 2}


def test_a_slow_stretch_is_in_the_spread_of_all_rows_and_decides_none() -> None:
    # a third of the time everything takes twice as long
    machine = Machine({str(k): 0.01 for k in range(9)}, lambda now: 1 + (0.5 < now < 1.1))
    effort = Effort(quick=True, least=9, most=9, seconds=0.0)
    for found in machine.measure(effort).values():
        assert found.seconds == pytest.approx(0.01)
        assert found.high == pytest.approx(0.02)


def test_a_failure_ends_one_work_and_not_the_others() -> None:
    machine = Machine({"a": 0.1, "b": 70.0})

    def fails_later() -> None:
        machine.calls.append("c")
        if machine.calls.count("c") == 3:
            raise ArithmeticError("lost")

    machine.works |= {"c": fails_later, "d": lambda: 1 // 0}
    found = machine.measure(Effort(quick=True, least=4, most=4, seconds=0.0))
    assert found["a"].repeats == 4
    assert found["b"].note == "TimeoutError: its first call took 70 s: not repeated"
    assert machine.calls.count("b") == 1
    assert found["c"].note == "ArithmeticError: lost"
    assert found["d"].note.startswith("ZeroDivisionError")
    assert [found[name].status for name in "bcd"] == [FAILED] * 3


def test_the_error_of_random_work_is_the_rms_over_seeds() -> None:
    seeds: dict[float, list[int]] = {10.0: [], 20.0: []}

    def work(value: float, seed: int) -> float:
        seeds[value].append(seed)
        return float(seed)

    effort = Effort(quick=True, least=1, most=5, seconds=0.0, least_seeded=5)
    works = sweep("s", "p", "m", "samples", (10.0, 20.0), work, error=float, seeded=True)
    for r in measure(works, effort):
        assert seeds[r.value] == list(range(1, 7))
        assert r.extra == {"seeds": 6}
        assert r.error == pytest.approx(math.sqrt(91 / 6))


def test_failures_are_rows() -> None:
    def work(value: int) -> Any:
        if value == 1:
            raise ValueError("too few\nnodes")
        return np.array([np.nan, 1.0]) if value == 2 else np.array([1.0, 1.0])

    works = sweep("precision", "p", "m", "nodes", [1, 2, 3], work,
                  error=lambda x: float(abs(x - 1).max()))  # fmt: skip
    rows = measure(works, ONCE)
    assert [r.status for r in rows] == [FAILED, FAILED, MEASURED]
    assert rows[0].note == "ValueError: too few nodes"
    assert rows[1].note == "1 of 2 values are no finite number"
    assert rows[2].error == 0.0
