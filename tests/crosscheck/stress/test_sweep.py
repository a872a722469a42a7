"""The stability sweep: its verdicts, its references, its report, and a reduced sweep that holds."""

import json
import math
import warnings
from collections.abc import Callable
from typing import Any

import pytest
from click.testing import CliRunner

from kinetics import CollisionLaw, InputError, ScalingSolution
from kinetics.crosscheck.stress import limits, run
from kinetics.crosscheck.stress.case import (
    BROKEN,
    CAREFUL,
    HOLDS,
    LONGEST,
    MISSED,
    SAYS_SO,
    SLOW,
    Case,
    Outcome,
    attempt,
    judge,
)
from kinetics.crosscheck.stress.command import stress
from kinetics.crosscheck.stress.report import StressReport
from kinetics.crosscheck.stress.run import all_cases, run_stress

# -- verdicts --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("outcome", "seconds", "expected"),
    [
        (Outcome(1e-8, 1e-9), 0.0, HOLDS),
        (Outcome(1e-8, 2e-8), 0.0, MISSED),
        (Outcome(1e-8, 2e-8, converged=False), 0.0, SAYS_SO),
        (Outcome(1e-8, 1e-9, converged=False), 0.0, CAREFUL),
        (Outcome(1e-8, 1e-9, converged=False, in_part=True), 0.0, SAYS_SO),
        (Outcome(1e-8, 1e-9, converged=False, known_to=1e-8), 0.0, SAYS_SO),
        (Outcome(1e-8, 1e-9, converged=False, known_to=1e-9), 0.0, CAREFUL),
        (Outcome(1e-8, 2e-8, in_part=True, known_to=1.0), 0.0, MISSED),
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
def test_judge(outcome: Outcome, seconds: float, expected: str) -> None:
    assert judge(outcome, seconds) == expected


def test_whatever_a_case_raises_is_its_verdict() -> None:
    def refuses() -> Outcome:
        raise InputError("nodes: got 3; it must be more")

    def warns() -> Outcome:
        warnings.warn("careful", RuntimeWarning, stacklevel=1)
        return Outcome()

    def dies() -> Outcome:
        raise AssertionError("no\nway")

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a user's own filters must not hide one
        found = [attempt(Case("g", "n", work)) for work in (refuses, warns, dies)]
    assert [c.verdict for c in found] == [BROKEN] * 3
    assert not any(c.accepted for c in found)
    assert [c.note for c in found] == [
        "InputError: nodes: got 3; it must be more",
        "RuntimeWarning: careful",
        "AssertionError: no way",
    ]


def test_the_worst_invariant_is_shown() -> None:
    outcome = Outcome(invariants={"a": (1e-3, 1.0), "b": (1e-14, 1e-13), "c": (0.0, 0.0)})
    case = attempt(Case("g", "n", lambda: outcome))
    assert (case.invariant, case.violation, case.allowed) == ("b", 1e-14, 1e-13)
    for violation in (1.0, math.nan):
        broken = Outcome(invariants={"a": (violation, 0.0), "b": (9.0, 1.0)})
        case = attempt(Case("g", "n", lambda broken=broken: broken))
        assert (case.verdict, case.invariant) == (BROKEN, "a")


# -- references ------------------------------------------------------------------------------------


@pytest.mark.parametrize("e", [0.0, 1e-8, 0.3, 0.9, 0.999])
def test_closed_forms_in_high_precision(e: float) -> None:
    h, one_a2, kappa, slope = limits.scaling(e)
    known = ScalingSolution(e)
    assert h == pytest.approx(known.cooling_rate, rel=1e-13)
    assert one_a2 == pytest.approx(1 + known.a2, rel=1e-12)
    assert kappa == pytest.approx(known.law.mean_log_loss, rel=1e-13)
    assert slope == pytest.approx(known.diffusion_slope, rel=1e-12)


def test_closed_forms_at_the_elastic_limit() -> None:
    # kappa -> 2 (1-e)/3, h -> 4 (1-e)/3, a2 -> -1/2, kappa slope -> 2/(4/3)
    h, one_a2, kappa, slope = limits.scaling(1 - 1e-10)
    gap = 1.0 - (1 - 1e-10)
    found = (h / gap, one_a2, kappa / gap, kappa * slope)
    assert found == pytest.approx((4 / 3, 0.5, 2 / 3, 1.5), rel=1e-9)


@pytest.mark.parametrize(
    "law",
    [
        CollisionLaw(0.7), CollisionLaw(1e-10, dimension=3), CollisionLaw(0.7, 0.8, 3),
        CollisionLaw(1.0, 0.8), CollisionLaw(0.5, 0.0), limits.other_laws(True)[-1],
    ],
    ids=limits.label_of,
)  # fmt: skip
def test_integrals_over_the_impact_parameter_give_the_closed_forms(law: CollisionLaw) -> None:
    known = ScalingSolution(**law.arguments)
    expected = (known.cooling_rate, 1 + known.a2, law.mean_log_loss, known.diffusion_slope)
    assert limits.scaling(law) == pytest.approx(expected, rel=1e-12)


def test_no_late_limit_where_all_bounces_take_the_same_share() -> None:
    assert limits.early_and_late(CollisionLaw(0.5, 0.5, 3), 1e15, 1e-8) == (False, False)
    assert limits.early_and_late(CollisionLaw(0.5, 0.6, 3), 1e15, 1e-8) == (False, True)
    assert not limits.takes_single_shares(CollisionLaw(1.0))
    assert limits.takes_single_shares(CollisionLaw(0.5, 0.5))


def test_laws_have_names_of_their_own() -> None:
    for quick in (True, False):
        names = [(case.group, case.name) for case in all_cases(quick)]
        assert len(set(names)) == len(names)
        laws = limits.other_laws(quick)
        assert {law.dimension for law in laws} == {2, 3}
        assert None in {law.restitution for law in laws}


def test_limits_are_used_where_they_hold_only() -> None:
    assert limits.early_and_late(0.7, 1e-12, 1e-8) == (True, False)
    assert limits.early_and_late(0.7, 1.0, 1e-8) == (False, False)
    assert limits.early_and_late(0.7, 1e15, 1e-8) == (False, True)
    assert limits.early_and_late(1.0, 1e15, 1e-8) == (False, False)


# -- the sweep -------------------------------------------------------------------------------------


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


@pytest.mark.slow
def test_a_part_of_the_quick_cases() -> None:
    """All of them take a minute or two; the continuous integration runs them."""
    groups = ("scaled equation", "scaled equation, nodes given", "cooling", "starts")
    report = sweep((*groups, "moments of position"), step=17)
    assert share_that_holds(report) > 0.8


@pytest.mark.slow
def test_particles_at_their_limits() -> None:
    sweep(("grazing", "corners", "no tracer inside a disk", "thin media"), step=2)


@pytest.mark.slow
def test_averages_at_their_limits() -> None:
    report = sweep(("scaled equation", "cooling", "starts", "moments of position"), step=2)
    assert share_that_holds(report) > 0.8


@pytest.mark.slow
def test_densities_at_their_limits() -> None:
    sweep(("spectral density", "late density", "conservative density"), step=4, skip="tail")


@pytest.mark.slow
def test_position_at_its_limits() -> None:
    report = sweep(("position density", "scattering function"), step=5, skip="t = 1000")
    assert share_that_holds(report) > 0.8


def scaled_by(factor: float) -> Callable[..., Any]:
    """A solver whose averages and densities are all too large."""
    from kinetics import solve

    class Wrong:
        def __init__(self, found: Any) -> None:
            self.found = found

        def __getattr__(self, name: str) -> Any:
            value = getattr(self.found, name)
            if name in ("speed_density", "intermediate_scattering", "scaled_position_density"):
                return lambda *a, **o: value(*a, **o) * factor
            kept = ("scene", "times", "status", "uncollided", "moment", "error_estimate")
            return value if name in kept or not hasattr(value, "shape") else value * factor

    return lambda *arguments, **options: Wrong(solve(*arguments, **options))


@pytest.mark.parametrize(
    ("group", "name"),
    [
        ("cooling", "e = 0.7, gaussian, scale 1,"),
        ("cooling", "e = 0.7, kept references, rtol 1e-06"),
        ("starts", "e = 0.2, two delta"),
        ("late density", "e = 0.7, gaussian"),
        ("conservative density", "e = 0.7, gaussian, 512"),
        ("moments of position", "e = 0.7, gaussian"),
        ("position density", "e = 0.7, gaussian, t = 1e-300"),
        ("scattering function", "e = 0.7, gaussian, t = 1"),
        ("cooling", "spheres, e = 0.7, et = 0.8, gaussian"),
        ("starts", "disks, e = 0.7, et = 0.8, two delta"),
        ("late density", "spheres, e = 0.7, gaussian"),
        ("conservative density", "spheres, e = 0.7, et = 0.8, gaussian"),
        ("moments of position", "spheres, e = 0.7, gaussian"),
        ("scattering function", "spheres, e = 0.7, gaussian, t = 1"),
    ],
)
def test_a_wrong_solver_is_found(monkeypatch: Any, group: str, name: str) -> None:
    """The sweep sees an error of a tenth in what a solver says."""
    import kinetics

    (case,) = [c for c in all_cases(quick=True) if c.group == group and c.name.startswith(name)][:1]
    assert attempt(case).accepted
    monkeypatch.setattr(kinetics, "solve", scaled_by(1.1))
    # a factor of all answers cancels where one is the other's reference
    if group == "starts":
        calls = iter([1.0, 1.1])
        monkeypatch.setattr(kinetics, "solve", lambda *a, **o: scaled_by(next(calls))(*a, **o))
    assert attempt(case).verdict in (MISSED, BROKEN)


# -- the report ------------------------------------------------------------------------------------


def made_up(monkeypatch: Any) -> None:
    cases = [
        Case("limits", "fine", lambda: Outcome(1e-8, 1e-9, invariants={"|F|": (0.0, 1e-13)})),
        Case("limits", "wrong", lambda: Outcome(1e-8, 1e-6)),
        Case("others", "not finite", lambda: Outcome(1e-8, math.inf)),
    ]
    monkeypatch.setattr(run, "all_cases", lambda quick: cases)
    monkeypatch.setattr(run, "_compile", lambda: None)


def test_the_report_counts_verdicts_and_lists_what_must_not_be(monkeypatch: Any) -> None:
    made_up(monkeypatch)
    seen: list[tuple[str, int]] = []
    report = run_stress(progress=lambda group, total: seen.append((group, total)))
    assert seen == [("limits", 3), ("limits", 3), ("others", 3)]
    assert [c.name for c in report.rejected] == ["wrong", "not finite"]
    text = report.markdown()
    assert "3 cases in 0 s, 0 s of processor time; 2 did not end as they must." in text
    assert (
        "| limits | 2 | 1 |  |  | 1 |  |  | 1.0e+02 of the error asked for: wrong | 0.00 s: fine |"
    ) in text
    assert "| all | 3 | 1 |  |  | 1 | 1 |  |" in text
    assert "| missed | limits | wrong | 1.0e-08 | 1.0e-06 |" in text
    assert "| holds | limits | fine |" not in text
    assert "| holds | limits | fine | 1.0e-08 | 1.0e-09 | \\|F\\| | 0.0e+00 | 1.0e-13 |" in (
        report.markdown(every_case=True)
    )
    document = json.loads(report.to_json(), parse_constant=pytest.fail)
    assert [c["verdict"] for c in document["cases"]] == [HOLDS, MISSED, BROKEN]


def test_groups_are_checked(monkeypatch: Any) -> None:
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
def test_wrong_arguments_end_in_one_line_and_status_two(
    lorentz: Any, tmp_path: Any, arguments: list[str], name: str
) -> None:
    (tmp_path / "file").write_text("")
    given = [a.format(file=tmp_path / "file") for a in arguments]
    assert name in lorentz.refused("stress", "--quick", *given)


def test_the_command_ends_with_status_one_if_a_case_must_not_be(
    monkeypatch: Any, tmp_path: Any
) -> None:
    made_up(monkeypatch)
    runner = CliRunner()
    done = runner.invoke(stress, ["--json", "-o", str(tmp_path / "out")])
    assert done.exit_code == 1
    assert json.loads(done.stdout)["format"] == "inelastic-lorentz stress 2"
    assert {p.name for p in (tmp_path / "out").iterdir()} == {"stress.json", "stress.md"}
    fine = [Case("limits", "fine", lambda: Outcome(1e-8, 1e-9))]
    monkeypatch.setattr(run, "all_cases", lambda quick: fine)
    assert runner.invoke(stress, []).exit_code == 0


def interrupted_by(status: BaseException) -> list[Case]:
    def stop() -> Outcome:
        raise status

    fine = Case("limits", "fine", lambda: Outcome(1e-8, 1e-9))
    return [fine, Case("limits", "stopped", stop), fine]


@pytest.mark.parametrize("signal", [KeyboardInterrupt(), SystemExit(143)])
def test_an_interruption_reports_what_has_been_run(
    monkeypatch: Any, tmp_path: Any, signal: BaseException
) -> None:
    monkeypatch.setattr(run, "all_cases", lambda quick: interrupted_by(signal))
    monkeypatch.setattr(run, "_compile", lambda: None)
    done = CliRunner().invoke(stress, ["-o", str(tmp_path / "out")])
    assert done.exit_code != 0
    assert "Interrupted: 2 more were not run." in done.stdout
    assert done.stderr.startswith("lorentz: interrupted: 2 cases were not run")
    kept = json.loads((tmp_path / "out" / "stress.json").read_text())
    assert [c["name"] for c in kept["cases"]] == ["fine"]
    assert kept["not_run"] == 2
    with pytest.raises(type(signal)):
        run_stress()
