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
    CAREFUL,
    HOLDS,
    LONGEST,
    MISSED,
    REFUSED,
    SAYS_SO,
    SLOW,
    Case,
    Outcome,
    attempt,
    judge,
    named,
)  # fmt: skip
from kinetics.crosscheck.stress.command import stress
from kinetics.crosscheck.stress.cooling_cases import draw, random_case
from kinetics.crosscheck.stress.run import all_cases

# -- verdicts -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("outcome", "seconds", "expected"),
    [
        (Outcome(1e-8, 1e-9), 0.0, HOLDS),
        (Outcome(1e-8, 2e-8), 0.0, MISSED),
        (Outcome(1e-8, 2e-8, converged=False), 0.0, SAYS_SO),
        (Outcome(1e-8, 1e-9, converged=False), 0.0, CAREFUL),
        (Outcome(1e-8, converged=False), 0.0, SAYS_SO),
        (Outcome(converged=False), 0.0, SAYS_SO),
        (Outcome(1e-8, math.inf, converged=False), 0.0, BROKEN),
        (Outcome(1e-8, 1e-9, invariants={"mass": (1e-12, 1e-13)}), 0.0, BROKEN),
        (Outcome(1e-8, 1e-9, invariants={"mass": (math.nan, 1.0)}), 0.0, BROKEN),
        (Outcome(1e-8, 1e-9, invariants={"mass": (0.0, 0.0)}), 0.0, HOLDS),
        (Outcome(), 0.0, HOLDS),
        (Outcome(1e-8, 1e-9), 2 * LONGEST, SLOW),
        (Outcome(1e-8, 2e-8, converged=False), 2 * LONGEST, SLOW),
        (Outcome(1e-8, 2e-8), 2 * LONGEST, MISSED),
    ],
)
def test_judge(outcome, seconds, expected):
    assert judge(outcome, seconds) == expected


def refuses():
    raise InputError("nodes: got 3; it must be more")


def test_whatever_a_case_raises_is_its_verdict():
    def warns():
        warnings.warn("careful", RuntimeWarning, stacklevel=1)
        return Outcome()

    def dies():
        raise AssertionError("no\nway")

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a user's own filters must not hide one
        found = [attempt(Case("g", "n", work)) for work in (refuses, warns, dies)]
    assert [c.verdict for c in found] == [BROKEN] * 3
    assert not any(c.accepted for c in found)
    assert found[0].note == "InputError: nodes: got 3; it must be more"
    assert found[1].note == "RuntimeWarning: careful"
    assert found[2].note == "AssertionError: no way"


def test_bad_input_is_refused_in_one_line_that_names_it():
    def simulates():
        from particles import BoltzmannGrad

        BoltzmannGrad(-1.0)

    def stumbles():
        return np.zeros(2) + np.zeros(3)  # a ValueError too: "operands could not be broadcast"

    def in_two_lines():
        raise InputError("nodes: got 3;\nit must be more")

    def verdict(work, argument):
        return attempt(Case("g", "n", work, argument)).verdict

    assert verdict(refuses, "nodes") == REFUSED
    assert verdict(simulates, "number_density") == REFUSED
    assert verdict(refuses, "rtol") == BROKEN
    assert verdict(in_two_lines, "nodes") == BROKEN
    assert verdict(stumbles, "operands") == BROKEN
    answered = attempt(Case("g", "n", lambda: Outcome(1e-8, 1e-9), "nodes"))
    assert (answered.verdict, answered.accepted) == (BROKEN, False)
    assert "must be refused" in answered.note


def test_the_worst_invariant_is_shown():
    outcome = Outcome(invariants={"a": (1e-3, 1.0), "b": (1e-14, 1e-13), "c": (0.0, 0.0)})
    case = attempt(Case("g", "n", lambda: outcome))
    assert (case.invariant, case.violation, case.allowed) == ("b", 1e-14, 1e-13)
    for violation in (1.0, math.nan):
        broken = Outcome(invariants={"a": (violation, 0.0), "b": (9.0, 1.0)})
        case = attempt(Case("g", "n", lambda: broken))  # noqa: B023
        assert (case.verdict, case.invariant) == (BROKEN, "a")


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


def sweep(groups: tuple[str, ...], step: int = 1, skip: str = "never") -> StressReport:
    """Every step-th case of some groups of the quick sweep, all of which must end as they must."""
    some = [c for c in all_cases(quick=True) if c.group in groups and skip not in c.name]
    found = tuple(attempt(case) for case in some[::step])
    assert {c.group for c in found} == set(groups)
    report = StressReport(found, True, 0.0, 0.0)
    wrong = [f"{c.verdict}: {c.group}, {c.name}: {c.invariant} {c.note}" for c in report.rejected]
    assert not wrong
    return report


def share_that_holds(report: StressReport) -> float:
    """Of the cases: the sweep looks where most have a reference, and meet it."""
    met = [c for c in report.cases if c.verdict in (HOLDS, CAREFUL) and c.reached <= c.asked]
    return len(met) / len(report.cases)


def test_single_tracers_at_their_limits():
    sweep(("grazing", "corners", "disks at cell corners", "no tracer inside a disk"))


def test_media_at_their_limits():
    sweep(("sizes of media", "thin media"), step=2)


def test_averages_at_their_limits():
    report = sweep(("scaled equation", "cooling", "starts", "sizes", "moments of position"))
    assert share_that_holds(report) > 0.8


def test_densities_at_their_limits():
    sweep(("spectral density", "late density", "conservative density"), step=3, skip="e = 0, tail")


def test_position_at_its_limits():
    report = sweep(("position density", "scattering function"), step=2, skip="t = 1000")
    assert share_that_holds(report) > 0.8


def test_bad_input_is_refused():
    assert all(c.verdict == REFUSED for c in sweep(("bad input",)).cases)


def scaled_by(factor):
    """A solver whose averages and densities are all too large."""
    from kinetics import solve

    def wrong(*arguments, **options):
        found = solve(*arguments, **options)
        for name, value in found.values.items():
            found.values[name] = value * factor
        density = found.speed_density
        object.__setattr__(found, "speed_density", lambda v: density(v) * factor)
        scattering = found.intermediate_scattering
        object.__setattr__(
            found, "intermediate_scattering", lambda *k, **o: scattering(*k, **o) * factor
        )
        position = found.scaled_position_density
        object.__setattr__(found, "scaled_position_density", lambda x: position(x) * factor)
        return found

    return wrong


@pytest.mark.parametrize(
    ("group", "name"),
    [
        ("cooling", "e = 0.7, gaussian, speeds times 1,"),
        ("cooling", "e = 0.7, kept references, rtol 1e-06"),
        ("starts", "e = 0.2, two spikes"),
        ("sizes", "e = 0.7, beam, l times 1e150 by number_density"),
        ("late density", "e = 0.7, gaussian"),
        ("conservative density", "e = 0.7, gaussian, 512"),
        ("moments of position", "e = 0.7, gaussian"),
        ("position density", "e = 0.7, gaussian, t = 1000"),
        ("scattering function", "e = 0.7, gaussian, t = 1"),
    ],
)
def test_a_wrong_solver_is_found(monkeypatch, group, name):
    """The sweep sees an error of a tenth in what a solver says."""
    import kinetics

    (case,) = [c for c in all_cases(quick=True) if c.group == group and c.name.startswith(name)][:1]
    assert attempt(case).accepted
    monkeypatch.setattr(kinetics, "solve", scaled_by(1.1))
    # a factor of all answers cancels where one is the other's reference
    if group in ("starts", "sizes"):
        calls = iter([1.0, 1.1])
        monkeypatch.setattr(kinetics, "solve", lambda *a, **o: scaled_by(next(calls))(*a, **o))
    assert attempt(case).verdict in (MISSED, BROKEN)


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
    arguments["times"].sort()
    case = attempt(named("random", "", random_case, arguments))
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
    monkeypatch.setattr(run, "_compile", lambda: None)


def test_report_counts_verdicts_and_lists_what_must_not_be(monkeypatch):
    made_up(monkeypatch)
    seen = []
    report = run_stress(progress=lambda group, total: seen.append((group, total)))
    assert seen == [("limits", 3), ("limits", 3), ("others", 3)]
    assert [c.name for c in report.rejected] == ["wrong", "not finite"]
    text = report.markdown()
    assert "3 cases in 0 s, 0 s of processor time; 2 not as they must end." in text
    assert "| limits | 2 | 1 |  |  |  | 1 |  |  |" in text
    assert "| all | 3 | 1 |  |  |  | 1 | 1 |  |" in text
    assert "| limits | 1.0e-06/1.0e-08: wrong | none violated | " in text
    assert "| missed | limits | wrong | 1.0e-08 | 1.0e-06 |" in text
    assert "| holds | limits | fine |" not in text
    assert "| holds | limits | fine | 1.0e-08 | 1.0e-09 | mass | 0.0e+00 | 1.0e-13 |" in (
        report.markdown(every_case=True)
    )
    document = json.loads(report.to_json(), parse_constant=pytest.fail)
    assert [c["verdict"] for c in document["cases"]] == [HOLDS, MISSED, BROKEN]
    (figure,) = report.figures().values()
    assert ElementTree.fromstring(figure).tag.endswith("svg")
    assert "relative error asked" in figure


def test_groups_are_checked(monkeypatch):
    made_up(monkeypatch)
    assert len(run_stress(groups=["others"]).cases) == 1
    with pytest.raises(InputError, match="'other'; known are 'limits', 'others'"):
        run_stress(groups=["other"])


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        (["--group", "nonsense"], "groups"),
        (["--output", "{file}"], "output"),
        (["--bogus"], "--bogus"),
        (["extra"], "extra"),
        (["--group"], "--group"),
    ],
)
def test_wrong_arguments_end_in_one_line_and_status_two(capsys, tmp_path, arguments, name):
    from kinetics import cli

    (tmp_path / "file").write_text("")
    given = [a.format(file=tmp_path / "file") for a in arguments]
    assert cli.main(["stress", "--quick", *given]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("lorentz: ")
    assert captured.err.count("\n") == 1
    assert name in captured.err


def test_command_ends_with_status_one_if_a_case_must_not_be(monkeypatch, tmp_path):
    made_up(monkeypatch)
    runner = CliRunner()
    done = runner.invoke(stress, ["--json", "-o", str(tmp_path / "out")])
    assert done.exit_code == 1
    assert json.loads(done.stdout)["format"] == "inelastic-lorentz stress 2"
    assert {p.name for p in (tmp_path / "out").iterdir()} == {
        "stress.json", "stress.md", "stress.svg",
    }  # fmt: skip
    fine = [named("limits", "fine", lambda: Outcome(1e-8, 1e-9))]
    monkeypatch.setattr(run, "all_cases", lambda quick: fine)
    assert runner.invoke(stress, []).exit_code == 0
