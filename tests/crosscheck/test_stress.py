"""The stability sweep: verdicts, references, and a planted wrong answer that it must see."""

import json
import math
import signal
import warnings
from collections.abc import Callable
from typing import Any

import pytest

import kinetics
from kinetics import InputError, Scene, solve
from kinetics.crosscheck import stress, stress_invariants, stress_work
from kinetics.crosscheck.stress import ACCEPTED, BROKEN, HOLDS, MISSED, SAYS_SO, Case
from kinetics.crosscheck.stress_invariants import Outcome, Violation


@pytest.mark.parametrize(
    ("outcome", "seconds", "expected"),
    [
        (Outcome(1e-8, 1e-9), 0.0, HOLDS), (Outcome(1e-8, 2e-8), 0.0, MISSED),
        (Outcome(1e-8, 2e-8, converged=False), 0.0, SAYS_SO),
        (Outcome(converged=False), 0.0, SAYS_SO),
        (Outcome(1e-8, math.inf, converged=False), 0.0, BROKEN),
        (Outcome(1e-8, 1e-9, invariants={"mass": Violation(1e-12, 1e-13)}), 0.0, BROKEN),
        (Outcome(1e-8, 1e-9, invariants={"mass": Violation(math.nan, 1.0)}), 0.0, BROKEN),
        (Outcome(), 0.0, HOLDS), (Outcome(1e-8, 1e-9), 120.0, BROKEN),
    ],
)  # fmt: skip
def test_judge(outcome: Outcome, seconds: float, expected: str) -> None:
    assert stress.judge(outcome, seconds) == expected


def test_whatever_a_case_raises_is_its_verdict() -> None:
    def refuses() -> Outcome:
        raise InputError("nodes: got 3")

    def warns() -> Outcome:
        warnings.warn("careful", RuntimeWarning, stacklevel=1)
        return Outcome()

    def violates() -> Outcome:
        return Outcome(invariants={"a": Violation(1e-3, 1.0), "b": Violation(math.nan, 0.0)})

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a user's own filters must not hide one
        found = [stress.attempt(Case("g", "n", work)) for work in (refuses, warns, violates)]
    assert [c["verdict"] for c in found] == [BROKEN] * 3
    assert [c["note"].split(":")[0] for c in found] == ["InputError", "RuntimeWarning", ""]
    assert [c["invariant"] for c in found] == ["", "", "b"]


def named(group: str, *parts: str) -> Case:
    """The first case of the group whose name has all of these parts."""
    cases = (c for c in stress.all_cases(False) if c.group == group)
    return next(c for c in cases if all(part in c.name for part in parts))


# 1e-3 is asked, or more
LOOSE = ("position density", "over time in a field")
DISKS, ROUGH = "=0.7),", "(restitution=0.7, tangential_restitution=0.8, dimension=3)"
BEGIN = "start = gaussian"


def wrong(factor: float, only: int) -> Callable[..., Any]:
    """A solver whose averages and densities are all too large, in some of its calls."""
    calls = iter(range(1000))

    class Wrong:
        def __init__(self, found: Any) -> None:
            self.found = found

        def __getattr__(self, name: str) -> Any:
            value = getattr(self.found, name)
            if name in ("speed_density", "intermediate_scattering", "scaled_position_density"):
                return lambda *a, **o: value(*a, **o) * factor
            if name == "values":
                return {key: array * factor for key, array in value.items()}
            kept = ("scene", "times", "status", "uncollided", "moment", "error_estimate")
            return value if name in kept or not hasattr(value, "shape") else value * factor

    def solver(*arguments: Any, **options: Any) -> Any:
        found = solve(*arguments, **options)
        return Wrong(found) if next(calls) == only else found

    return solver


@pytest.mark.parametrize(
    ("group", "parts"),
    [
        ("cooling", (DISKS, BEGIN, "times = 100")), ("cooling", (DISKS, "start = speed 1e150")),
        ("averages", (ROUGH, BEGIN)), ("averages", ("CollisionLaw(restitution=1.0)", BEGIN)),
        ("spectral density", (DISKS, "nodes = 512")),
        ("position density", (DISKS, "times = 1e-300")),
        ("scattering function", (DISKS, BEGIN, "times = 1.0")), ("over time in a field", (DISKS,)),
    ],
)  # fmt: skip
def test_a_wrong_answer_is_found(
    monkeypatch: pytest.MonkeyPatch, group: str, parts: tuple[str, ...]
) -> None:
    """An error of a tenth or a thousandth in what a solver says, which claims to have converged."""
    case = named(group, *parts)
    assert stress.attempt(case)["verdict"] in ACCEPTED
    factors = [1.1] if group in LOOSE else [1.1, 1.001]
    for factor in factors:
        monkeypatch.setattr(kinetics, "solve", wrong(factor, only=0))
        assert stress.attempt(case)["verdict"] in (MISSED, BROKEN)


@pytest.mark.parametrize(
    ("group", "parts"),
    [("scaled equation", (DISKS, "rtol = 0.0001")), ("steady state", ("=0.0)",)),
     ("density", ("=0.8, dimension=3)", "HardSpheres"))],
)  # fmt: skip
def test_a_case_of_each_other_group(group: str, parts: tuple[str, ...]) -> None:
    assert stress.attempt(named(group, *parts))["verdict"] in ACCEPTED


@pytest.mark.slow
def test_the_quick_sweep() -> None:
    assert stress.run_stress(quick=True).rejected == []


def test_the_invariants_see_what_is_violated() -> None:
    found = solve(Scene(0.5, times=[0.0, 1.0, 9.0], outputs=("thermal_speed", "msd", "kurtosis")))
    assert all(v.is_allowed for v in stress_invariants.invariants(found).values())
    values = {name: array[::-1].copy() for name, array in found.values.items()}
    values["kurtosis"] = 0.1 * values["kurtosis"]
    bad = type("Bad", (), {**{n: getattr(found, n) for n in (
        "scene", "times", "rtol", "error_estimate", "moment")}, "values": values})  # fmt: skip
    kept = stress_invariants.invariants(bad)
    violated = {name for name, violation in kept.items() if not violation.is_allowed}
    assert {"thermal_speed does not grow", "msd does not fall", "kurtosis >= 1"} <= violated


def test_what_is_no_number_violates_an_invariant() -> None:
    assert stress_invariants.excess([-1.0, math.nan]) == math.inf


def test_late_autocorrelations_are_compared_by_the_speed_at_the_start() -> None:
    scene = Scene(0.5, times=[1e200], outputs="velocity_autocorrelation")
    assert stress_work.error_to_tighter(solve(scene, 1e-6)) < 1e-6


@pytest.fixture
def made_up(monkeypatch: pytest.MonkeyPatch) -> list[Case]:
    cases = [
        Case(
            "limits", "fine", lambda: Outcome(1e-8, 1e-9, invariants={"|F|": Violation(0.0, 1e-13)})
        ),
        Case("limits", "wrong", lambda: Outcome(1e-8, 1e-6)),
        Case("others", "not finite", lambda: Outcome(1e-8, math.inf)),
    ]
    monkeypatch.setattr(stress, "all_cases", lambda quick: cases)
    return cases


def test_the_command(made_up: list[Case], tmp_path: Any, capsys: Any) -> None:
    assert kinetics.cli.main(["stress", "--json", "-o", str(tmp_path / "out")]) == 1
    document = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
    assert set(document) >= {"format", "verdicts", "cases", "quick", "seconds", "not_run"}
    assert [c["verdict"] for c in document["cases"]] == [HOLDS, MISSED, BROKEN]
    assert json.loads((tmp_path / "out" / "stress.json").read_text()) == document
    page = (tmp_path / "out" / "stress.md").read_text()
    assert all(word in page for word in ("wrong", "not finite"))
    assert kinetics.cli.main(["stress"]) == 1
    assert "wrong" in capsys.readouterr().out
    made_up[1:] = []
    assert kinetics.cli.main(["stress"]) == 0
    assert kinetics.cli.main(["stress", "--group", "other"]) == 2


@pytest.mark.parametrize("interruption", [KeyboardInterrupt(), SystemExit(143)])
def test_an_interruption_reports_what_has_been_run(
    made_up: list[Case], tmp_path: Any, interruption: BaseException, capsys: Any
) -> None:
    def stop() -> Outcome:
        raise interruption

    made_up[1:] = [Case("limits", "stopped", stop), made_up[0]]
    handler = signal.getsignal(signal.SIGINT)
    status = kinetics.cli.main(["stress", "-o", str(tmp_path)])
    assert status == (143 if isinstance(interruption, SystemExit) else 130)
    assert "2 cases were not run" in capsys.readouterr().err
    kept = json.loads((tmp_path / "stress.json").read_text())
    assert ([c["name"] for c in kept["cases"]], kept["not_run"]) == (["fine"], 2)
    assert signal.getsignal(signal.SIGINT) is handler


@pytest.mark.parametrize(
    "drive", [{"bath_speed": 0.5}, {"heating": 0.1, "drag": 0.1}, {"field": 0.2, "drag": 0.1}]
)
def test_the_balances_of_driven_tracers_see_a_wrong_answer(
    monkeypatch: pytest.MonkeyPatch, drive: dict[str, float]
) -> None:
    system = {"restitution": 0.6, "mass_ratio": 3.0, "dimension": 3} | drive
    assert stress.judge(stress_work.driven(1e-6, **system), 0.0) in ACCEPTED
    right = kinetics.solve_steady

    def wrong(restitution: float, **system: Any) -> Any:  # converged, of other collisions
        state = right(restitution=0.5 * restitution, **system)
        object.__setattr__(state, "restitution", restitution)
        return state

    monkeypatch.setattr(kinetics, "solve_steady", wrong)
    assert stress.judge(stress_work.driven(1e-6, **system), 0.0) == BROKEN
