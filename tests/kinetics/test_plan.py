"""solution.plan, and the work behind it: what no output needs is not solved."""

from typing import Any

import numpy as np
import pytest

from kinetics import (
    AngularHarmonics,
    Beam,
    Gaussian,
    Scene,
    Solution,
    solve,
)
from kinetics.densities import conservative, harmonic
from kinetics.densities import spectral as forward
from kinetics.moments.backward import BackwardEquation, Observable
from kinetics.scene import OUTPUTS

TIMES = [0.0, 1.0, 100.0]


class Count:
    """What was solved, in order."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.observables: list[Observable] = []
        self.densities: list[tuple[str, int]] = []
        original = BackwardEquation._solve

        def counted(equation: BackwardEquation, y: Observable) -> Any:
            if y not in equation._solved:
                self.observables.append(y)
            return original(equation, y)

        monkeypatch.setattr(BackwardEquation, "_solve", counted)
        for module, name in (
            (forward, "solve_spectral"),
            (conservative, "solve_conservative"),
            (harmonic, "elastic_profile"),
        ):
            self._watch(monkeypatch, module, name)

    def _watch(self, monkeypatch: pytest.MonkeyPatch, module: Any, name: str) -> None:
        original = getattr(module, name)

        def counted(asked: Any) -> Any:
            self.densities.append((name, asked.m))
            return original(asked)

        monkeypatch.setattr(module, name, counted)

    @property
    def powers(self) -> set[tuple[float, int]]:
        """(power, harmonic) of what was solved without sources."""
        return {
            (y.degree, y.harmonic) for y in self.observables if not y.sources and not y.constant
        }


@pytest.fixture
def count(monkeypatch: pytest.MonkeyPatch) -> Count:
    return Count(monkeypatch)


def run(outputs: Any, initial: Any = "gaussian", e: float = 0.6, **more: Any) -> Solution:
    return solve(
        Scene(restitution=e, initial=initial, times=TIMES, outputs=outputs, **more), rtol=1e-4
    )


def solved(solution: Solution) -> dict[str, bool]:
    return {step.part: step.solved for step in solution.plan}


@pytest.mark.parametrize(
    ("outputs", "powers", "others"),
    [
        (("thermal_speed",), {(2.0, 0)}, 0),
        (("temperature",), {(2.0, 0)}, 0),
        (("thermal_speed", "temperature"), {(2.0, 0)}, 0),
        (("a2",), {(2.0, 0), (4.0, 0)}, 0),
        (("collisions",), set(), 1),
        (("msd",), set(), 2),  # <r^2> and the displacement along the start that drives it
        (("mean_velocity",), set(), 0),  # isotropic: zero without solving
        (("velocity_tensor",), {(2.0, 0)}, 0),
    ],
)
def test_an_isotropic_scene(count: Count, outputs: Any, powers: Any, others: int) -> None:
    solution = run(outputs)
    assert count.powers == powers
    assert len(count.observables) == len(powers) + others
    assert count.densities == []
    plan = solved(solution)
    assert plan["collision number"] == ("collisions" in outputs)
    assert plan["displacement"] == ("msd" in outputs)


def test_a_directed_scene(count: Count) -> None:
    run(("mean_velocity", "velocity_tensor"), Beam())
    # errors of harmonics are stated relative to m = 0 of the same power
    assert count.powers <= {(1.0, 0), (1.0, 1), (2.0, 0), (2.0, 2)}
    assert {(1.0, 1), (2.0, 2)} <= count.powers
    assert count.densities == []


@pytest.mark.parametrize(
    ("initial", "harmonics", "expected"),
    [
        ("gaussian", 8, [0]),
        (Gaussian(1.0, 1.5), 6, [0, 2, 4, 6]),
        (Beam(speeds="gaussian"), 3, [0, 1, 2, 3]),
        (
            AngularHarmonics(
                {0: lambda v: v * np.exp(-v * v / 2), 3: lambda v: 0.1 * v * np.exp(-v * v / 2)}
            ),
            8,
            [0, 3],
        ),
        (Beam(speeds="gaussian"), 0, [0]),
    ],
)
def test_the_harmonics_that_a_scene_has(
    count: Count, initial: Any, harmonics: int, expected: list[int]
) -> None:
    solution = run(("velocity_density",), initial, harmonics=harmonics)
    assert [m for _, m in count.densities] == expected
    assert solved(solution)["densities"]
    (step,) = [s for s in solution.plan if s.part == "angular harmonics"]
    assert str(expected) in step.reason


def test_everything(count: Count) -> None:
    solution = run(tuple(OUTPUTS), Beam(speeds="gaussian"), harmonics=2)
    assert all(solved(solution).values())
    assert {m for _, m in count.densities} == {0, 1, 2}
    assert {(2.0, 0), (4.0, 0), (1.0, 1), (2.0, 2)} <= count.powers
    # nothing is solved twice
    assert len(count.observables) == len(set(count.observables))
    assert len(count.densities) == 3


def test_an_elastic_scene_solves_nothing(count: Count) -> None:
    of_speed = [name for name, row in OUTPUTS.items() if row.step == "moments of the velocity"]
    outputs = (*of_speed, "speed_density", "velocity_density")
    solution = run(outputs, Beam(speeds="gaussian"), e=1.0, harmonics=2)
    assert count.powers == set()
    assert {name for name, _ in count.densities} == {"elastic_profile"}
    assert not solved(solution)["moments of the velocity"]


def test_moments_are_solved_when_they_are_asked_for(count: Count) -> None:
    solution = run("thermal_speed")
    before = len(count.observables)
    solution.moment(3.0)
    assert [(y.degree, y.harmonic) for y in count.observables[before:]] == [(3.0, 0)]
