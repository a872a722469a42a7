"""What a user reads from a benchmark: tables, figures, JSON, the command, and its failures."""

import json
import math
import re
import xml.etree.ElementTree as ElementTree
from typing import Any

import pytest
from click.testing import CliRunner

from kinetics import InputError
from kinetics.crosscheck.bench import accuracy, analysis, cost, run, tables
from kinetics.crosscheck.bench.command import CASES, bench
from kinetics.crosscheck.bench.record import FAILED, MEASURED, NOT_AVAILABLE, Record
from kinetics.crosscheck.bench.report import BenchReport
from kinetics.crosscheck.bench.run import run_bench

PROBLEM = "scaled F(c), e = 0.7"


def row(method: str = "spectral", seconds: float = 1.0, error: float = 1e-9, **others: Any) -> Any:
    given = {"section": "precision", "problem": "p", "setting": "rtol", "value": 1e-8} | others
    return Record(method=method, seconds=seconds, error=error, **given)


def report(*rows: Record) -> BenchReport:
    return BenchReport(rows, True, ("scaled",), {"processor": "x", "load_before": 0.1}, 1.0)


def full_report() -> BenchReport:
    rows = [row(problem=PROBLEM, seconds=1e-3, error=1e-12)]
    rows += [row("straightforward", problem=PROBLEM, seconds=s, error=e, value=s)
             for s, e in ((0.01, 1e-2), (0.1, 1e-3))]  # fmt: skip
    rows += [row("Monte Carlo", problem=PROBLEM, seconds=1.0, error=1e-2, value=1e4,
                 extra={"seeds": 6})]  # fmt: skip
    rows += [Record("precision", "G(R)", "spectral", status=NOT_AVAILABLE, note="not there yet")]
    rows += [
        Record("precision", "scaled h, e = 0.4", "Sonine", status=FAILED, note="order = 1: no root")
    ]
    rows += [row(section="accuracy", problem="1 + a2(t)", asked=1e-8, note=accuracy.MISSED,
                 seconds=None, error=3e-8, extra={"ratio": 3.0, "converged": True})]  # fmt: skip
    rows += [row(m, section="skipping", extra={"ratio": r}) for m, r in (("a", 1), ("b", 5))]
    rows += [row(section="cost", setting="nodes", value=v, seconds=v) for v in (10.0, 20.0)]
    rows += [Record("cost", "p", "spectral", "nodes, exponent", extra={"exponent": 1.0})]
    rows += [row("particles", section="particles", setting="", value=None, threads=n, extra={
                 "collisions_per_second": 2e7 * n, "placing_seconds_per_medium": 1e-3})
             for n in (1, 2)]  # fmt: skip
    return report(*rows)


def test_the_tables_list_everything_and_what_failed() -> None:
    text = full_report().markdown()
    for expected in (
        "processor x, load before 0.1. 1 s in all.",
        "| scaled F(c) | spectral | 1 ms | 1 ms | 1.0e-12 |",
        "| scaled F(c), e = 0.7 | straightforward | 100 ms | ≥ 100 s |",
        "| scaled F(c), e = 0.7 | Monte Carlo | ≥ 100 s | ≥ 3.2 years | ≥ 3.2e+04 years |",
        "| 1e-08 | 1 | 3.0e+00 | 3.0e+00 | 3.0e+00 | 1 | 0 | 0 |",
        "- 1 + a2(t): asked 1e-08, reached 3.0e-08",
        "| p | b | 1 s | 5 |",
        "| p | spectral | nodes 10 to 20 | 10 s to 20 s | 1.00 |",
        "| p | 1 | 20.0 | 1 ms |",
        "| p | 2 | 40.0 | 1 ms |",
        "| not available | G(R) | spectral |  | not there yet |",
        "| failed | scaled h, e = 0.4 | Sonine |  | order = 1: no root |",
    ):
        assert expected in text
    assert "##" not in report().markdown()


def test_the_summary_has_medians_for_each_family_and_method() -> None:
    rows = []
    for e, seconds in ((0.2, 3.0), (0.7, 1.0), (0.95, 2.0)):
        name = f"v0(t), a2(t), gaussian, t <= 1e+02, e = {e:g}"
        rows += [row(problem=name, seconds=seconds, error=1e-9 * seconds)]
        rows += [row("Sonine", problem=name, seconds=1e-4, error=1e-4 if e == 0.95 else 0.1)]
    text = report(*rows).markdown()
    # in two of the three problems the order never gets there
    assert "| v₀(t), a₂(t), t ≤ 10² | spectral | 2 s | 2 s | 2.0e-09 |" in text
    assert "| v₀(t), a₂(t), t ≤ 10² | Sonine | - | - | 1.0e-01 |" in text


@pytest.mark.parametrize(
    ("plain", "family", "set_out"),
    [
        ("scaled h and a2, e = 0.95", "scaled h and a2", "scaled h and a₂, e = 0.95"),
        ("<r^2>(t), monoenergetic, t <= 1e+08, e = 1e-10", "<r^2>(t), t <= 1e+08",
         "⟨r²⟩(t), monoenergetic, t ≤ 10⁸, e = 10⁻¹⁰"),
        ("hard disks, 0.04 per d^2, 10000",) * 2 + ("hard disks, 0.04 per d², 10000",),
    ],
)  # fmt: skip
def test_names_have_families_and_are_set_out(plain: str, family: str, set_out: str) -> None:
    assert analysis.family(plain) == family
    assert tables.typeset(plain) == set_out


def test_the_json_is_strict_and_holds_every_row() -> None:
    made = full_report()
    document = json.loads(made.to_json(), parse_constant=pytest.fail)
    assert {**document, "records": []} == {
        "format": "inelastic-lorentz bench 2", "quick": True, "cases": ["scaled"],
        "machine": made.machine, "seconds": 1.0, "records": [],
    }  # fmt: skip
    assert [Record(**r) for r in document["records"]] == list(made.records)
    assert {r["status"] for r in document["records"]} == {MEASURED, FAILED, NOT_AVAILABLE}


def test_the_figure_is_svg_with_labels_and_units() -> None:
    other = [row(problem="scaled h and a2, e = 0.7"), row(problem="v0(t), a2(t), e = 0.7")]
    text = report(*full_report().records, *other).files()["work-precision.svg"]
    assert ElementTree.fromstring(text).tag.endswith("svg")
    for expected in (
        "run time, one thread [s]", "largest relative error", "scaled F(c), e = 0.7",
        "scaled h and a₂, e = 0.7",
    ):  # fmt: skip
        assert expected in text
    assert "v₀" not in text
    assert len(text) < 150_000
    # real text of 10 px and more where it is 900 px wide
    assert ElementTree.fromstring(text).get("width") == "675pt"
    assert min(float(size) for size in re.findall(r"font-size: ([0-9.]+)px", text)) >= 7.5
    assert (
        full_report().files()["work-precision.svg"] == full_report().files()["work-precision.svg"]
    )
    assert set(report().files()) == {"bench.json", "bench.md"}


# -- what the rows say -----------------------------------------------------------------------------


def test_the_front_holds_what_nothing_beats() -> None:
    rows = [row(seconds=s, error=e) for s, e in [(3, 1e-3), (1, 1e-2), (2, 1e-1), (4, 1e-3)]]
    assert [(r.seconds, r.error) for r in analysis.front(rows)] == [(1, 1e-2), (3, 1e-3)]


def test_the_time_for_an_error_is_measured_or_bounded_from_below_or_not_reached() -> None:
    rows = [row(seconds=1.0, error=1e-3), row(seconds=2.0, error=1e-9)]
    rows += [row("straightforward", seconds=4.0, error=1e-4), row("Sonine", error=0.1)]
    rows += [row("Monte Carlo", seconds=1.0, error=1e-2)]
    assert analysis.cost_at(rows, "spectral", 1e-6) == analysis.Cost(2.0, analysis.MEASURED_THERE)
    dense = analysis.cost_at(rows, "straightforward", 1e-8)
    assert dense.how == analysis.AT_LEAST
    assert dense.seconds == pytest.approx(4e4)
    assert analysis.cost_at(rows, "Monte Carlo", 1e-4).seconds == pytest.approx(1e4)
    assert analysis.cost_at(rows, "Sonine", 1e-3).how == analysis.NOT_REACHED
    assert analysis.cost_at(rows, "spectral", 1e-12).how == analysis.NOT_REACHED


def test_exponents_are_fitted_over_the_upper_half() -> None:
    work = [1, 2, 4, 8, 16, 32]
    assert cost.fitted_exponent(work, [5, 5, 5, 8**1.5, 16**1.5, 32**1.5]) == pytest.approx(1.5)
    assert math.isnan(cost.fitted_exponent([1, 2], [1.0, 2.0]))


@pytest.mark.parametrize(
    ("reached", "converged", "expected"),
    [
        (1e-9, True, accuracy.WITHIN),
        (0.99e-8, True, accuracy.WITHIN),
        (1.01e-8, True, accuracy.MISSED),
        (1.01e-8, False, accuracy.MISSED_AND_SAID),
        (math.nan, True, accuracy.MISSED),
        (0.9e-10, True, accuracy.BETTER),
    ],
)
def test_verdict_on_asked_and_reached(reached: float, converged: bool, expected: str) -> None:
    assert accuracy.verdict(1e-8, reached, converged) == expected


# -- running it ------------------------------------------------------------------------------------


def test_unknown_cases_are_refused() -> None:
    assert list(run.CASES) == list(CASES)
    with pytest.raises(InputError, match="'scale'; known are scaled"):
        run_bench(cases=["scale"])
    with pytest.raises(InputError, match="got none"):
        run_bench(cases=[])


def test_a_case_that_dies_is_a_failed_row(monkeypatch: Any) -> None:
    # the child process does not know this case
    monkeypatch.setitem(run.CASES, "dies", "nowhere.nothing")
    found = run_bench(quick=True, cases=["dies"])
    assert [(r.status, r.section) for r in found.records] == [(FAILED, "dies")]
    assert "dies" in found.records[0].note


@pytest.mark.slow
def test_the_solver_reaches_what_is_asked_in_a_process_of_its_own() -> None:
    stages: list[tuple[str, int]] = []
    found = run_bench(quick=True, cases=["accuracy"], progress=lambda *told: stages.append(told))
    assert stages == [("accuracy", 1)]
    assert len(found.records) == 600
    assert {(r.section, r.status) for r in found.records} == {("accuracy", MEASURED)}
    missed = [(r.problem, r.asked, r.error) for r in found.records if r.note == accuracy.MISSED]
    assert missed == []
    assert found.machine["cores"] >= 1


def test_the_command_prints_and_writes(monkeypatch: Any, tmp_path: Any) -> None:
    made = full_report()
    monkeypatch.setattr(run, "run_bench", lambda quick, cases, tell: made)
    runner = CliRunner()
    done = runner.invoke(bench, ["--quick", "-o", str(tmp_path / "out")])
    assert done.exit_code == 0, done.output
    assert done.output.startswith(made.markdown())
    assert {p.name for p in (tmp_path / "out").iterdir()} == {
        "bench.json", "bench.md", "work-precision.svg",
    }  # fmt: skip
    done = runner.invoke(bench, ["--json", "--case", "scaled"])
    assert done.stdout == made.to_json()
    assert runner.invoke(bench, ["--compare", "old.json"]).exit_code == 2
