"""The benchmark: how it measures, that its other methods are right, and what its tables say."""

import json
import math
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from kinetics import ScalingSolution, cli
from kinetics.crosscheck import bench, references
from kinetics.crosscheck.bench import (
    FAILED,
    MEASURED,
    BenchReport,
    Effort,
    Work,
    blank,
    histogram_error,
    measure,
    relative,
    run_bench,
    seconds_for,
    seconds_text,
    sweep,
)

# -- measuring, on a made-up machine --------------------------------------------------------------


class Machine:
    """Work of given seconds on a machine that is slow now and then; all of it is made up."""

    def __init__(self, seconds: dict[str, float], slow: Callable[[float], float] = lambda _: 1.0):
        self.now, self.calls, self.slow = 0.0, "", slow
        self.works = {name: self.work(name, s) for name, s in seconds.items()}

    def work(self, name: str, seconds: float) -> Callable[..., int]:
        def run(seed: int = 0) -> int:
            self.calls += name
            self.now += seconds * self.slow(self.now)
            return len(self.calls)

        return run

    def measure(self, effort: Effort, seeded: bool = False) -> dict[str, Any]:
        works = [Work("s", "p", name, call, seeded=seeded) for name, call in self.works.items()]
        clocks = (lambda: self.now, lambda: self.now)
        return {row["method"]: row for row in measure(works, effort, clocks)}


def test_the_first_call_is_no_time_and_repeats_are_spread_over_the_whole() -> None:
    machine = Machine({"a": 0.001, "b": 0.02, "c": 2.0}, lambda now: 3.0 if now == 0.0 else 1.0)
    effort = Effort(True, 3, 12, 0.05, 10)
    found = machine.measure(effort)
    assert {name: row["repeats"] for name, row in found.items()} == {"a": 12, "b": 3, "c": 1}
    assert [found["a"][n] for n in ("low", "seconds", "high")] == pytest.approx([0.001] * 3)
    assert machine.calls == "abcabc" + "aaabaaaaabaaa"
    more = Machine({"a": 0.02, "c": 2.0}).measure(effort, seeded=True)
    assert {name: row["repeats"] for name, row in more.items()} == {"a": 10, "c": 2}


def test_a_slow_stretch_is_in_the_spread_of_all_rows_and_decides_none() -> None:
    # a third of the time everything takes twice as long
    machine = Machine({str(k): 0.01 for k in range(9)}, lambda now: 1 + (0.5 < now < 1.1))
    for row in machine.measure(Effort(True, 9, 9, 0.0, 1)).values():
        assert (row["seconds"], row["high"]) == pytest.approx((0.01, 0.02))


def test_a_failure_is_a_row_and_ends_no_other_work() -> None:
    machine = Machine({"a": 0.1, "b": 70.0})

    def fails_later() -> None:
        machine.calls += "c"
        if machine.calls.count("c") == 3:
            raise ArithmeticError("lost\nit")

    machine.works |= {"c": fails_later, "d": lambda: 1 // 0}  # type: ignore[dict-item]
    found = machine.measure(Effort(True, 4, 4, 0.0, 1))
    assert (found["a"]["repeats"], found["a"]["status"]) == (4, MEASURED)
    assert machine.calls.count("b") == 1  # longer than a minute
    assert found["c"]["note"] == "ArithmeticError: lost it"
    assert [found[name]["status"] for name in "bcd"] == [FAILED] * 3


def test_errors_are_root_mean_squares_over_seeds_and_say_what_is_not_finite() -> None:
    seeds: list[int] = []

    def work(value: float, seed: int) -> float:
        seeds.append(seed)
        return float(seed)

    once = Effort(True, 1, 5, 0.0, 5)
    (row,) = measure(sweep("s", "p", "m", "samples", (10.0,), work, error=float, seeded=True), once)
    assert (sorted(seeds), row["extra"]) == (list(range(1, 7)), {"seeds": 6})
    assert row["error"] == pytest.approx(math.sqrt(91 / 6))
    works = sweep("s", "p", "m", "nodes", [0.0, np.nan], lambda x: np.array([x, 1.0]), error=max)
    rows = measure(works, once)
    assert [row["status"] for row in rows] == [MEASURED, FAILED]
    assert "1 of 2" in rows[1]["note"]


# -- methods that are only here -------------------------------------------------------------------


def fitted_order(nodes: list[int], errors: list[float]) -> float:
    return -float(np.polyfit(np.log(nodes), np.log(errors), 1)[0])


@pytest.mark.parametrize("e", [0.0, 0.7])
def test_the_straightforward_state_is_of_second_order(e: float) -> None:
    nodes, exact, c = [101, 151, 201, 301, 401], ScalingSolution(e), bench.SPEEDS
    found = [bench.straightforward_state(e, n) for n in nodes]
    errors = [relative(s.cooling_rate, exact.cooling_rate) for s in found]
    assert fitted_order(nodes, errors) == pytest.approx(2.0, abs=0.3)
    assert np.max(np.abs(found[-1].vdf(c) - exact.vdf(c))) < 0.08 * exact.vdf(c).max()


@pytest.mark.parametrize("start", references.STARTS)
def test_cooling_by_other_methods_converges_to_the_references(start: str) -> None:
    times = references.times("short")
    exact = references.kept("thermal_speed", 0.7, start, "short")

    def errors(method: Any, settings: list[int]) -> list[float]:
        return [relative(method(0.7, start, times, n)[0], exact) for n in settings]

    dense = errors(bench.straightforward_cooling, [33, 65, 129])
    # second order for the smooth start
    assert fitted_order([33, 65, 129], dense) > (1.6 if start == "gaussian" else 0.8)
    assert dense[-1] < 2e-2
    assert errors(bench.conservative_cooling, [129, 513])[-1] < 5e-3
    assert errors(bench.sonine_cooling, [1, 8])[-1] < 1e-2
    sampled = bench.monte_carlo(0.7, start, times, "", 2000, 1).thermal_speed.value
    assert relative(sampled, exact) < 0.2


def test_the_error_of_a_histogram_is_what_was_put_in() -> None:
    exact, edges, v0 = ScalingSolution(0.7), np.geomspace(0.05, 6.0, 90), 0.3

    def shares(edges: Any) -> Any:
        fine = np.linspace(edges[:-1], edges[1:], 41, axis=1)
        return np.trapezoid(2 * np.pi * fine * exact.vdf(fine.ravel()).reshape(fine.shape), fine)

    def areas(c: Any) -> Any:
        return math.pi * np.diff(c**2)

    put_in = 0.1 * areas(edges) * (np.arange(89) == 60)
    for probability, error in ((shares(edges), 0.0), (shares(edges) + put_in, 0.1)):
        found = SimpleNamespace(value=probability[None])
        histogram = SimpleNamespace(edges=edges * v0, probability=found)
        found = histogram_error(histogram, v0, (0.1, 4.0), shares, areas)
        assert found == pytest.approx(error, abs=1e-9)


# -- a case, and the tables -----------------------------------------------------------------------


@pytest.fixture(scope="module")
def report() -> BenchReport:
    return run_bench(quick=True, cases=["field"])


def test_the_smallest_case(report: BenchReport) -> None:
    rows = [row for row in report.records if row["method"] == bench.SPECTRAL]
    assert len({row["problem"] for row in rows}) == 2
    assert {row["status"] for row in rows} == {MEASURED}
    assert all(row["low"] <= row["seconds"] <= row["high"] for row in rows)
    assert all(row["error"] <= row["asked"] for row in rows)
    assert set(report.files()) == {"bench.json", "bench.md", "work-precision.svg"}
    assert report.files()["work-precision.svg"].count("<svg") == 1
    assert "field, steady state" in report.markdown()


def test_the_command_runs_nothing_from_the_current_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("numpy", "json", "kinetics"):
        Path(f"{name}.py").write_text("open('ran', 'w').close()\n")
    assert cli.main(["bench", "--quick", "--case", "field", "--json", "-o", "out"]) == 0
    document = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
    assert {"format", "records", "quick", "cases", "machine", "seconds"} == set(document)
    keys = "section problem method setting value error seconds low high status note asked threads"
    assert all(set(keys.split()) <= set(row) for row in document["records"])
    assert {row["status"] for row in document["records"]} == {MEASURED}
    assert not Path("ran").exists()
    assert json.loads(Path("out/bench.json").read_text()) == document


def test_a_case_that_dies_is_a_row(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bench.sys, "executable", "false")
    (row,) = run_bench(quick=True, cases=["field"]).records
    assert row["status"] == FAILED


def row_of(problem: str, method: str, seconds: float, error: float, **more: Any) -> Any:
    return blank("precision", problem, method, seconds=seconds, error=error) | more


def test_run_times_are_measured_or_bounds_or_absent() -> None:
    rows = [
        row_of("p", bench.MONTE_CARLO, s, e) for s, e in ((0.1, 0.1), (10.0, 0.01), (11.0, 0.02))
    ]
    frame = BenchReport(rows, True, (), {}, 0.0).to_dataframe("precision")
    assert seconds_for(frame, bench.MONTE_CARLO, 0.02) == (10.0, False)
    seconds, at_least = seconds_for(frame, bench.MONTE_CARLO, 1e-3)  # 1/sqrt(samples)
    assert (seconds, at_least) == (pytest.approx(1000.0), True)
    assert math.isnan(seconds_for(frame, bench.SONINE, 1e-3)[0])
    assert (seconds_text(1000.0, True), seconds_text(2.3e-4)) == ("≥ 1000 s", "230 us")
    assert (seconds_text(math.nan), seconds_text(1e8)) == ("-", "3.2 years")


def test_every_section_has_its_table_and_failures_are_listed() -> None:
    accuracy = {"asked": 1e-3, "note": bench.MISSED, "extra": {"ratio": 2.0, "converged": True}}
    rate = {"collisions_per_second": 4.2e7, "placing_seconds_per_medium": 1e-3}
    records = [
        row_of("scaled F(c), e = 0.7", bench.SPECTRAL, 1e-3, 1e-9),
        row_of("v0(t), gaussian, e = 0.7", bench.SONINE, 1e-3, 1e-9),
        blank("accuracy", "q", bench.SPECTRAL, error=2e-3, **accuracy),
        blank("skipping", "scene", "a2 alone", seconds=1e-3, extra={"ratio": 5.0}),
        blank("particles", "disks", "particles", seconds=1.0, extra=rate),
        blank("precision", "r", bench.SONINE, status=FAILED, note="lost", setting="order", value=3),
    ]
    text = BenchReport(records, True, (), {"processor": "x"}, 1.0).markdown()
    assert text.count("\n## ") == 5
    assert "| v0(t) | Sonine |" in text
    assert "42.0" in text
    assert "| failed | r | Sonine | order 3 | lost |" in text
