"""The benchmark: how it measures, that its other methods are right, and what its tables say."""

import json
import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from kinetics import ScalingSolution
from kinetics.crosscheck import bench, references
from kinetics.crosscheck.bench import (
    CONSERVATIVE,
    FAILED,
    MEASURED,
    MONTE_CARLO,
    QUICK,
    SPECTRAL,
    STRAIGHTFORWARD,
    BenchReport,
    Work,
    histogram_error,
    measure,
    relative,
    seconds_for,
    seconds_text,
    sweep,
)


class Machine:
    """Work of given seconds on a machine that is slow now and then; all of it is made up."""

    def __init__(self, slow: Callable[[float], float] = lambda _: 1.0):
        self.now, self.calls, self.slow = 0.0, "", slow

    def work(self, name: str, seconds: float, fails_at: int = 0) -> Work:
        def run(seed: int = 0) -> int:
            self.calls += name
            self.now += seconds * self.slow(self.now)
            if self.calls.count(name) == fails_at:
                raise ArithmeticError("lost\nit")
            return len(self.calls)

        return Work("s", "p", name, run)

    def measure(self, *works: Work, **effort: Any) -> dict[str, Any]:
        rows = measure(works, QUICK._replace(**effort), lambda: (self.now, self.now))
        return {row["method"]: row for row in rows}


def test_the_first_call_is_no_time_and_repeats_are_spread_over_the_whole() -> None:
    machine = Machine(lambda now: 3.0 if now == 0.0 else 1.0)
    works = [machine.work(*one) for one in (("a", 0.001), ("b", 0.02), ("c", 2.0))]
    found = machine.measure(*works, least=3, most=12, seconds=0.05)
    assert {name: row["repeats"] for name, row in found.items()} == {"a": 12, "b": 3, "c": 1}
    assert [found["a"][n] for n in ("low", "seconds", "high")] == pytest.approx([0.001] * 3)
    assert machine.calls == "abcabc" + "aaabaaaaabaaa"


def test_a_slow_stretch_is_in_the_spread_of_all_rows_and_decides_none() -> None:
    # a third of the time everything takes twice as long
    machine = Machine(lambda now: 1 + (0.5 < now < 1.1))
    found = machine.measure(*(machine.work(str(k), 0.01) for k in range(9)), least=9, most=9)
    for row in found.values():
        assert (row["seconds"], row["high"]) == pytest.approx((0.01, 0.02))


def test_a_failure_is_a_row_and_ends_no_other_work() -> None:
    machine = Machine()
    slow, lost = machine.work("b", 70.0), machine.work("c", 0.1, fails_at=3)
    found = machine.measure(machine.work("a", 0.1), slow, lost, least=4, most=4)
    assert (found["a"]["repeats"], found["a"]["status"]) == (4, MEASURED)
    assert machine.calls.count("b") == 1  # longer than a minute
    assert found["c"]["note"] == "ArithmeticError: lost it"
    assert [found[name]["status"] for name in "bc"] == [FAILED] * 2


def test_errors_are_root_mean_squares_over_seeds_and_finite() -> None:
    once = QUICK._replace(least=6, most=6)
    way = (MONTE_CARLO, "samples", (10.0,), lambda value, seed: float(seed))
    (row,) = measure(sweep("p", float, way), once)
    assert row["error"] == pytest.approx(math.sqrt(np.mean(np.arange(1.0, 8.0) ** 2)))
    way = (SPECTRAL, "rtol", [0.0, np.nan], lambda x: np.array([x, 1.0]))
    assert [row["status"] for row in measure(sweep("p", max, way), once)] == [MEASURED, FAILED]


# -- methods that are only here -------------------------------------------------------------------


@pytest.mark.parametrize("e", [0.0, 0.7])
def test_the_straightforward_state_is_of_second_order(e: float) -> None:
    nodes, exact, c = [101, 151, 201, 301, 401], ScalingSolution(e), bench.SPEEDS
    found = [bench.straightforward_state(e, n) for n in nodes]
    errors = [relative(s.cooling_rate, exact.cooling_rate) for s in found]
    assert -np.polyfit(np.log(nodes), np.log(errors), 1)[0] == pytest.approx(2.0, abs=0.3)
    assert np.max(np.abs(found[-1].vdf(c) - exact.vdf(c))) < 0.08 * exact.vdf(c).max()


@pytest.mark.filterwarnings("ignore::kinetics.ToleranceWarning")
@pytest.mark.parametrize("start", references.STARTS)
def test_cooling_by_other_methods_converges_to_the_references(start: str) -> None:
    works = [w for w in bench.averages(QUICK, "p", ("thermal_speed", "a2"), "short")
             if start in w.problem]  # fmt: skip
    last = {w.method: w for w in works}
    assert set(last) == {SPECTRAL, MONTE_CARLO, CONSERVATIVE}
    for method, most in ((SPECTRAL, 1e-12), (CONSERVATIVE, 1e-2)):
        assert last[method].error(last[method].call()) < most  # type: ignore[misc]
    assert last[MONTE_CARLO].error(last[MONTE_CARLO].call(1)) < 0.1  # type: ignore[misc]


def test_the_error_of_a_histogram_is_what_was_put_in() -> None:
    exact, edges, v0 = ScalingSolution(0.7), np.geomspace(0.05, 6.0, 90), 0.3
    fine = np.linspace(edges[:-1], edges[1:], 41, axis=1)
    shares = np.trapezoid(
        2 * np.pi * fine * exact.vdf(fine.ravel()).reshape(fine.shape), fine, axis=1
    )
    put_in = 0.1 * math.pi * np.diff(edges**2) * (np.arange(89) == 60)
    x = np.linspace(0.1, 4.0, 200)
    for probability, error in ((shares, 0.0), (shares + put_in, 0.1 / exact.vdf(x).max())):
        found = SimpleNamespace(value=probability[None])
        histogram = SimpleNamespace(edges=edges * v0, probability=found)
        found = histogram_error(histogram, v0, x, exact.vdf(x), plane=True)
        assert found == pytest.approx(error, abs=1e-4)


# -- a case, and the tables -----------------------------------------------------------------------


def test_every_method_and_question_is_among_the_cases() -> None:
    works = [w for name in ("scaled", "cooling", "position", "field")
             for w in bench.CASES[name](QUICK)]  # fmt: skip
    assert {w.method for w in works} == set(bench.METHODS)
    assert len({w.problem.split(": ")[0] for w in works}) == 9
    assert {references.STARTS[1] in w.problem for w in works} == {True, False}


def test_the_command(lorentz: Any, tmp_path: Any) -> None:
    document = lorentz.json("bench", "--quick", "--case", "field", "-o", str(tmp_path / "out"))
    assert {"format", "records", "quick", "cases", "machine", "seconds"} == set(document)
    keys = "section problem method setting value error seconds low high status note asked threads"
    assert all(set(keys.split()) <= set(row) for row in document["records"])
    assert {row["status"] for row in document["records"]} == {MEASURED}
    assert all(row["low"] <= row["seconds"] <= row["high"] for row in document["records"])
    assert all(row["error"] <= row["asked"] for row in document["records"])
    assert json.loads((tmp_path / "out" / "bench.json").read_text()) == document
    assert "steady state in a field" in (tmp_path / "out" / "bench.md").read_text()
    assert (tmp_path / "out" / "work-precision.svg").read_text().count("<svg") == 1


def row_of(section: str, problem: str, method: str, seconds: float, **more: Any) -> Any:
    return Work(section, problem, method, print).row() | {"seconds": seconds} | more


def report_of(*rows: Any) -> BenchReport:
    return BenchReport(list(rows), True, (), {"processor": "x"}, 1.0)


def test_run_times_are_measured_or_bounds_or_absent() -> None:
    runs = ((0.1, 0.1), (10.0, 0.01), (11.0, 0.02))
    frame = report_of(*(row_of("precision", "p", MONTE_CARLO, s, error=e) for s, e in runs))
    frame = frame.to_dataframe()
    assert seconds_for(frame, MONTE_CARLO, 0.02) == (10.0, False)
    seconds, at_least = seconds_for(frame, MONTE_CARLO, 1e-3)  # 1/sqrt(samples)
    assert (seconds, at_least) == (pytest.approx(1000.0), True)
    assert math.isnan(seconds_for(frame, SPECTRAL, 1e-3)[0])
    assert (seconds_text(1000.0, True), seconds_text(2.3e-4)) == ("≥ 1000 s", "230 us")
    assert (seconds_text(math.nan), seconds_text(1e8)) == ("-", "3.2 years")


def test_every_section_has_its_table_and_failures_are_listed() -> None:
    text = report_of(
        row_of("precision", "v0(t): gaussian", STRAIGHTFORWARD, 1e-3, error=1e-9),
        row_of("skipping", "scene", "everything", 5e-3),
        row_of("skipping", "scene", "a2", 1e-3),
        row_of("particles", "disks", "placing", 1.0, value=1e6),
        row_of("particles", "disks", "run", 2.0, value=43e6),
        row_of(
            "precision",
            "r",
            STRAIGHTFORWARD,
            1.0,
            status=FAILED,
            note="lost",
            setting="nodes",
            value=3,
        ),
    ).markdown()
    assert text.count("\n## ") == 4
    for line in ("| v0(t) | straightforward | 1 ms |", "| a2 | 1 ms | 5 |", "| 42.0 |",
                 "| r | straightforward | nodes 3 | lost |"):  # fmt: skip
        assert line in text
