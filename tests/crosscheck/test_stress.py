"""The stability sweep: its verdicts, its references, and a reduced sweep that must hold."""

import json
import math
import warnings
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from kinetics import InputError, ScalingSolution
from kinetics.crosscheck.stress import StressReport, exact, run, run_stress
from kinetics.crosscheck.stress.case import (
    BROKEN,
    HOLDS,
    LONGEST,
    MISSED,
    REFUSED,
    SAYS_SO,
    SLOW,
    Outcome,
    attempt,
    judge,
    named,
)  # fmt: skip
from kinetics.crosscheck.stress.command import stress
from kinetics.crosscheck.stress.position_cases import position_cases
from kinetics.crosscheck.stress.solver_cases import draw, random_case, solver_cases

# -- verdicts -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("outcome", "seconds", "expected"),
    [
        (Outcome(1e-8, 1e-9), 0.0, HOLDS),
        (Outcome(1e-8, 2e-8), 0.0, MISSED),
        (Outcome(1e-8, 2e-8, converged=False), 0.0, SAYS_SO),
        (Outcome(1e-8, 1e-9, converged=False), 0.0, SAYS_SO),
        (Outcome(1e-8, math.inf, converged=False), 0.0, BROKEN),
        (Outcome(1e-8, 1e-9, invariants={"mass": (1e-12, 1e-13)}), 0.0, BROKEN),
        (Outcome(1e-8, 1e-9, invariants={"mass": (math.nan, 1.0)}), 0.0, BROKEN),
        (Outcome(1e-8, 1e-9, invariants={"mass": (0.0, 0.0)}), 0.0, HOLDS),
        (Outcome(), 0.0, HOLDS),
        (Outcome(1e-8, 1e-9), 2 * LONGEST, SLOW),
        (Outcome(1e-8, 2e-8), 2 * LONGEST, MISSED),
    ],
)
def test_judge(outcome, seconds, expected):
    assert judge(outcome, seconds) == expected


def test_whatever_a_case_raises_is_its_verdict():
    def refuses():
        raise InputError("nodes: got 3;\nit must be more")

    def warns():
        warnings.warn("careful", RuntimeWarning, stacklevel=1)
        return Outcome()

    def dies():
        raise AssertionError("no way")

    def simulates():
        from particles import BoltzmannGrad

        BoltzmannGrad(-1.0)

    def stumbles():
        return np.zeros(2) + np.zeros(3)  # a ValueError too

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a user's own filters must not hide one
        found = [attempt("g", "n", work) for work in (refuses, warns, dies)]
        assert attempt("g", "n", simulates).verdict == REFUSED
        assert attempt("g", "n", stumbles).verdict == BROKEN
    assert [c.verdict for c in found] == [REFUSED, BROKEN, BROKEN]
    assert [c.accepted for c in found] == [True, False, False]
    assert found[0].note == "nodes: got 3; it must be more"
    assert found[1].note == "RuntimeWarning: careful"
    assert found[2].note == "AssertionError: no way"


def test_the_worst_invariant_is_shown():
    outcome = Outcome(invariants={"a": (1e-3, 1.0), "b": (1e-14, 1e-13), "c": (0.0, 0.0)})
    case = attempt("g", "n", lambda: outcome)
    assert (case.invariant, case.violation, case.allowed) == ("b", 1e-14, 1e-13)
    broken = attempt("g", "n", lambda: Outcome(invariants={"a": (1.0, 0.0), "b": (9.0, 1.0)}))
    assert (broken.verdict, broken.invariant) == (BROKEN, "a")


# -- references -----------------------------------------------------------------------------------


@pytest.mark.parametrize("e", [0.0, 1e-8, 0.3, 0.9, 0.999])
def test_closed_forms_in_high_precision(e):
    h, one_a2, kappa = exact.scaling(e)
    known = ScalingSolution(e)
    assert h == pytest.approx(known.cooling_rate, rel=1e-13)
    assert one_a2 == pytest.approx(1 + known.a2, rel=1e-12)
    assert kappa == pytest.approx(known.law.mean_log_loss, rel=1e-13)


def test_closed_forms_at_the_elastic_limit():
    # kappa -> 2 (1-e)/3, h -> 4 (1-e)/3, a2 -> -1/2
    h, one_a2, kappa = exact.scaling(1 - 1e-10)
    gap = 1.0 - (1 - 1e-10)
    assert (h / gap, one_a2, kappa / gap) == pytest.approx((4 / 3, 0.5, 2 / 3), rel=1e-9)


def test_limits_are_used_where_they_hold_only():
    assert exact.early_and_late(0.7, 1e-12, 1e-8) == (True, False)
    assert exact.early_and_late(0.7, 1.0, 1e-8) == (False, False)
    assert exact.early_and_late(0.7, 1e15, 1e-8) == (False, True)
    assert exact.early_and_late(1.0, 1e15, 1e-8) == (False, False)


# -- the sweep ------------------------------------------------------------------------------------

PARTICLES = ("grazing", "corners", "disks at cell corners", "no tracer inside a disk")


def rejected(report: StressReport) -> list[str]:
    return [f"{c.verdict}: {c.group}, {c.name}: {c.invariant} {c.note}" for c in report.rejected]


def test_particles_at_their_limits():
    report = run_stress(quick=True, groups=PARTICLES)
    assert {c.group for c in report.cases} == set(PARTICLES)
    assert not rejected(report)


def test_the_position_at_its_limits():
    report = StressReport(tuple(attempt(*case) for case in position_cases(quick=True)), True, 0.0)
    assert len(report.cases) == 44
    assert not rejected(report)


def test_reduced_sweep_of_the_solvers():
    cases = list(solver_cases(quick=True))
    reduced = [case for case in cases if "1024" not in case[1] and "512" not in case[1]][::3]
    found = [attempt(*case) for case in reduced]
    assert len(found) > 50
    report = StressReport(tuple(found), True, 0.0)
    assert not rejected(report)
    # the sweep looks: most cases have a reference, and it is met within what was asked
    assert sum(math.isfinite(c.reached) and c.reached <= c.asked for c in found) > 0.7 * len(found)


sizes = st.floats(-100.0, 100.0).map(lambda x: 10.0**x)


@settings(
    max_examples=40, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow]
)
@given(
    restitution=st.one_of(
        st.floats(0.0, 1.0),
        st.floats(-12.0, 0.0).map(lambda x: 10.0**x),
        st.floats(-12.0, 0.0).map(lambda x: 1.0 - 10.0**x),
    ),
    number_density=sizes,
    scale=sizes,
    start=st.sampled_from(["gaussian", "monoenergetic", "samples"]),
    times=st.lists(st.floats(-200.0, 200.0).map(lambda x: 10.0**x), min_size=1, max_size=6),
    rtol=st.floats(-12.0, -1.0).map(lambda x: 10.0**x),
)
def test_random_scenes_end_as_they_must(**arguments):
    case = attempt(
        "random", "", lambda: random_case(arguments | {"times": sorted(arguments["times"])})
    )
    assert case.accepted, case


def test_random_cases_are_the_same_in_every_run():
    first, second = (draw(np.random.default_rng(5)) for _ in range(2))
    assert first == second


# -- the report -----------------------------------------------------------------------------------


def made_up(monkeypatch) -> None:
    cases = [
        named("limits", "fine", lambda: Outcome(1e-8, 1e-9, invariants={"mass": (0.0, 1e-13)})),
        named("limits", "wrong", lambda: Outcome(1e-8, 1e-6)),
        named("others", "not finite", lambda: Outcome(1e-8, math.inf)),
    ]
    monkeypatch.setattr(run, "all_cases", lambda quick: cases)


def test_report_counts_verdicts_and_lists_what_must_not_be(monkeypatch):
    made_up(monkeypatch)
    seen = []
    report = run_stress(progress=lambda group, total: seen.append((group, total)))
    assert seen == [("limits", 3), ("limits", 3), ("others", 3)]
    assert [c.name for c in report.rejected] == ["wrong", "not finite"]
    text = report.markdown()
    assert "3 cases in 0 s, 2 not as they must end." in text
    assert "| limits | 2 | 1 |  |  | 1 |  |  | 1.0e+02: wrong |" in text
    assert "| missed | limits | wrong | 1.0e-08 | 1.0e-06 |" in text
    document = json.loads(report.to_json(), parse_constant=pytest.fail)
    assert [c["verdict"] for c in document["cases"]] == [HOLDS, MISSED, BROKEN]
    (figure,) = report.figures().values()
    assert ElementTree.fromstring(figure).tag.endswith("svg")
    assert "relative error asked" in figure


def test_groups_are_checked(monkeypatch):
    made_up(monkeypatch)
    assert len(run_stress(groups=["others"]).cases) == 1
    with pytest.raises(InputError, match="'other'; known are limits, others"):
        run_stress(groups=["other"])


def test_command_ends_with_status_one_if_a_case_must_not_be(monkeypatch, tmp_path):
    made_up(monkeypatch)
    runner = CliRunner()
    done = runner.invoke(stress, ["--json", "-o", str(tmp_path / "out")])
    assert done.exit_code == 1
    assert json.loads(done.stdout)["format"] == "inelastic-lorentz stress 1"
    assert {p.name for p in (tmp_path / "out").iterdir()} == {
        "stress.json", "stress.md", "stress.svg",
    }  # fmt: skip
    fine = [named("limits", "fine", lambda: Outcome(1e-8, 1e-9))]
    monkeypatch.setattr(run, "all_cases", lambda quick: fine)
    assert runner.invoke(stress, []).exit_code == 0
