"""The benchmark: how it measures, that its other methods are right, and what its tables say."""

import json
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest

from kinetics.crosscheck import bench_problems, references
from kinetics.crosscheck.bench import FAILED, MEASURED, QUICK, SPECTRAL, BenchReport, Work, measure
from kinetics.crosscheck.cli.bench import CASES


class Clock:
    """Work of given seconds on a machine with a clock of its own; the first call compiles."""

    def __init__(self) -> None:
        self.now, self.calls = 0.0, 0

    def measure(self, each: float, fails_at: int = 0, **effort: Any) -> dict[str, Any]:
        def run() -> None:
            self.calls += 1
            self.now += each if self.calls > 1 else 7.0
            if self.calls == fails_at:
                raise ArithmeticError("lost\nit")

        clock = lambda: self.now  # noqa: E731
        return measure(Work("s", "p", "m", run), replace(QUICK, **effort), (clock, clock))


def test_the_command_offers_every_case() -> None:
    assert CASES == bench_problems.CASES


@pytest.mark.parametrize(("seconds", "repeats"), [(0.001, 12), (0.011, 5), (0.02, 3), (2.0, 1)])
def test_the_first_call_is_no_time_and_quick_work_is_repeated(seconds: float, repeats: int) -> None:
    row = Clock().measure(seconds, min_repeats=3, max_repeats=12, seconds=0.05)
    assert (row["repeats"], row["warm_up"]) == (repeats, pytest.approx(7.0))
    assert [row[n] for n in ("low", "seconds", "high", "wall")] == pytest.approx([seconds] * 4)


def test_a_failure_is_a_row() -> None:
    row = Clock().measure(0.1, fails_at=3, min_repeats=4, max_repeats=4)
    expected = (FAILED, "ArithmeticError: lost it", None)
    assert (row["status"], row["note"], row["seconds"]) == expected


def test_an_answer_that_is_no_number_is_a_failure() -> None:
    for value, status in ((0.0, MEASURED), (np.nan, FAILED)):
        work = Work("s", "p", "m", partial(float, value), error=float)
        assert measure(work, QUICK)["status"] == status


@pytest.mark.filterwarnings("ignore::kinetics.ToleranceWarning")
@pytest.mark.parametrize("start", references.STARTS)
def test_cooling_meets_the_references(start: str) -> None:
    last = [work for work in bench_problems.works("cooling", QUICK) if start in work.problem][-1]
    assert last.error is not None
    assert last.error(last.call()) < 1e-12


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


def row_of(section: str, problem: str, method: str, seconds: float, **more: Any) -> Any:
    row = measure(Work(section, problem, method, lambda: None), QUICK)
    return row | {"seconds": seconds} | more


def report_of(*rows: Any) -> BenchReport:
    return BenchReport(list(rows), True, (), {"processor": "x"}, 1.0)


def test_run_times_are_medians_over_the_variants_and_only_of_errors_that_were_reached() -> None:
    runs = ((0.1, 0.1), (0.3, 2e-4), (9.0, 1e-4))
    rows = [
        row_of("precision", f"p: {k}", SPECTRAL, (1 + k) * seconds, error=error, asked=2 * error)
        for seconds, error in runs
        for k in (0, 1, 2)
    ]
    for rows_of_p, line in (
        (rows, "| p | spectral | 0.0001 | 18 | 0.6 | inf | 0.5 |"),
        (rows[:-4] + rows[-3:-1], "| p | spectral | 0.0001 | 9 | 0.6 | inf | 0.5 |"),
    ):
        assert line in report_of(*rows_of_p).markdown()


def test_every_section_has_its_table_and_failures_are_listed() -> None:
    text = report_of(
        row_of("precision", "v0(t): gaussian", SPECTRAL, 1e-3, error=1e-9),
        row_of("particles", "disks", "placing", 1.0, value=1e6),
        row_of("particles", "disks", "run", 2.0, value=43e6),
        row_of("precision", "r", SPECTRAL, 1.0, value=3) | {"status": FAILED, "note": "lost"},
    ).markdown()
    assert text.count("\n## ") == 3
    assert "| disks | 1 | 0.25 | 4.2e+07 |" in text
    assert "| lost |" in text
