"""solution.plan, and the work behind it: what no output needs is not solved."""

from typing import Any

import numpy as np
import pytest

from kinetics import AngularHarmonics, Beam, Gaussian, Scene, Solution, solve
from kinetics.densities import conservative, harmonic
from kinetics.densities import spectral as forward
from kinetics.moments.backward import BackwardEquation
from kinetics.outputs import OUTPUTS


def rayleigh(v: Any) -> Any:
    return v * np.exp(-v * v / 2)


def run(outputs: Any, initial: Any = "gaussian", e: float = 0.6, **more: Any) -> Solution:
    scene = Scene(e, initial=initial, times=[0.0, 1.0, 100.0], outputs=outputs, **more)
    return solve(scene, rtol=1e-4)


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> tuple[list[Any], list[Any]]:
    """Averages that are solved, and densities as (method, harmonic), in order."""
    averages: list[Any] = []
    densities: list[Any] = []
    original = BackwardEquation._solve

    def solved(equation: BackwardEquation, y: Any) -> Any:
        if y not in equation._solved:
            averages.append(y)
        return original(equation, y)

    def watched(name: str, work: Any, asked: Any) -> Any:
        densities.append((name, asked.m))
        return work(asked)

    monkeypatch.setattr(BackwardEquation, "_solve", solved)
    for module, name in ((forward, "solve_spectral"), (conservative, "solve_conservative"),
                         (harmonic, "elastic_profile")):  # fmt: skip
        work = getattr(module, name)
        monkeypatch.setattr(module, name, lambda a, n=name, w=work: watched(n, w, a))
    return averages, densities


@pytest.mark.parametrize(
    ("outputs", "powers", "others"),
    [
        (("thermal_speed", "temperature"), {(2.0, 0)}, 0),
        ("a2", {(2.0, 0), (4.0, 0)}, 0),
        ("collisions", set(), 1),
        ("msd", set(), 2),  # <r^2> and the displacement along the start that drives it
        ("mean_velocity", set(), 0),  # isotropic: zero without solving
        ("velocity_tensor", {(2.0, 0)}, 0),
    ],
)
def test_an_isotropic_scene(counted: Any, outputs: Any, powers: Any, others: int) -> None:
    plan = {step.part: step.solved for step in run(outputs).plan}
    averages, densities = counted
    found = {(y.degree, y.harmonic) for y in averages if not y.sources and not y.constant}
    assert (found, densities) == (powers, [])
    assert len(averages) == len(powers) + others
    assert plan["collision number"] == (outputs == "collisions")
    assert plan["displacement"] == (outputs == "msd")


@pytest.mark.parametrize(
    ("initial", "harmonics", "expected"),
    [
        ("gaussian", 8, [0]),
        (Gaussian(1.0, 1.5), 6, [0, 2, 4, 6]),
        (Beam(speeds="gaussian"), 3, [0, 1, 2, 3]),
        (AngularHarmonics({0: rayleigh, 3: lambda v: 0.1 * rayleigh(v)}), 8, [0, 3]),
        (Beam(speeds="gaussian"), 0, [0]),
    ],
)
def test_the_harmonics_that_a_scene_has(
    counted: Any, initial: Any, harmonics: int, expected: list[int]
) -> None:
    run(("velocity_density",), initial, harmonics=harmonics)
    assert [m for _, m in counted[1]] == expected


def test_everything_is_solved_once_and_later_what_is_asked_for_later(counted: Any) -> None:
    averages, densities = counted
    solution = run(tuple(OUTPUTS), Beam(speeds="gaussian"), harmonics=2)
    assert all(step.solved for step in solution.plan)
    assert sorted(m for _, m in densities) == [0, 1, 2]
    before = len(averages)
    assert before == len(set(averages))
    solution.moment(3.0)
    assert [(y.degree, y.harmonic) for y in averages[before:]] == [(3.0, 0)]


def test_an_elastic_scene_solves_nothing(counted: Any) -> None:
    of_speed = [name for name, row in OUTPUTS.items() if row.step == "moments of the velocity"]
    outputs = (*of_speed, "speed_density", "velocity_density")
    run(outputs, Beam(speeds="gaussian"), e=1.0, harmonics=2)
    assert not [y for y in counted[0] if not y.sources and not y.constant]
    assert {name for name, _ in counted[1]} == {"elastic_profile"}
