"""Every argument of the public functions with every broken value: taken, or refused in one line."""

import contextlib
import tempfile
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from fuzzing import BROKEN, result_or_refusal

import kinetics
from derivations import printed_equation, verify
from kinetics import (
    AngularHarmonics,
    Beam,
    CollisionLaw,
    Gaussian,
    Monoenergetic,
    PolarGrid,
    ScalingSolution,
    Scene,
    SpeedDensity,
    SpeedSamples,
    SpeedTable,
    VelocitySamples,
    solve,
    solve_scaled,
)
from kinetics.crosscheck.compare import compare_data
from particles import BoltzmannGrad, HardDisks, Poisson, Positions, simulate

Call = Callable[[Any], Any]
LAW, EXACT = CollisionLaw(0.7), ScalingSolution(0.7)
SPEEDS = np.linspace(0.0, 1.0, 5)


def each(function: Callable[..., Any], names: str, **usual: Any) -> dict[str, Call]:
    """Name -> the function of one argument, the others being as usual."""
    return {
        f"{function.__name__} {name}": lambda value, name=name: function(**usual | {name: value})
        for name in names.split()
    }


def methods(owner: Any, names: str) -> dict[str, Call]:
    """Name -> a method of one argument."""
    return {f"{type(owner).__name__}.{name}": getattr(owner, name) for name in names.split()}


OF_KINETICS: dict[str, Call] = {
    **each(
        Scene,
        "restitution number_density diameter initial times outputs harmonics",
        restitution=0.7,
        times=[1.0],
    ),
    **each(solve, "scene rtol method nodes", scene=Scene(0.7, times=[1.0])),
    **each(solve_scaled, "restitution rtol nodes", restitution=0.7, rtol=1e-3),
    **each(CollisionLaw, "restitution"),
    **each(ScalingSolution, "restitution"),
    **each(Gaussian, "deviation_x deviation_y"),
    **each(Monoenergetic, "speed"),
    **each(SpeedSamples, "speed"),
    **each(SpeedTable, "speed density", speed=SPEEDS, density=np.ones(5)),
    **each(Beam, "direction speeds"),
    **each(VelocitySamples, "velocity"),
    **each(AngularHarmonics, "terms"),
    **each(PolarGrid, "speed values", speed=SPEEDS, values=np.full((5, 4), 1.0 / np.pi)),
    **methods(LAW, "mean_speed_ratio_power decay_rate"),
    **each(LAW.harmonic_decay_rate, "p m", p=1.0, m=1),
    **methods(EXACT, "moment scaled_speed_moment vdf"),
    **methods(solve_scaled(0.7, 1e-3), "moment vdf"),
    "SpeedDensity, solved": lambda f: solve(Scene(0.7, times=[1.0], initial=SpeedDensity(f))),
    **each(
        compare_data,
        "data restitution number_density initial positions speed_unit diameter",
        data=["no.csv"],
        explain=False,
    ),
    # None is all of them, which tests/derivations derives
    "verify labels": lambda value: verify([] if value is None else value),
    **each(printed_equation, "label"),
}
_SMALL = HardDisks(0.04, 80)
OF_PARTICLES: dict[str, Call] = {
    **each(HardDisks, "number_density count diameter box equilibrate", number_density=0.04),
    **each(Poisson, "number_density count diameter box", number_density=0.04),
    **each(BoltzmannGrad, "number_density diameter", number_density=0.04),
    **each(Positions, "positions box_side diameter start", positions=[[3.0, 3.0]], box_side=10.0),
    **each(
        simulate,
        "medium restitution initial times media tracers max_collisions seed workers executor "
        "observables progress output resume",
        medium=_SMALL,
        restitution=0.5,
        times=[1.0],
        media=1,
        tracers=1,
        max_collisions=9,
        workers=1,
    ),
}
_scene = Scene(0.7, times=[9.0], outputs=("speed_density", "position_density"))
_OF_SOLUTIONS = (
    "moment speed_density velocity_component_density position_density scaled_position_density "
    "position_fraction position_tail"
)


@pytest.mark.parametrize("name", OF_KINETICS)
def test_arguments_of_the_solver(name: str) -> None:
    _try_all(OF_KINETICS[name])


@pytest.mark.parametrize("name", OF_PARTICLES)
def test_arguments_of_particles(name: str) -> None:
    _try_all(OF_PARTICLES[name])


@pytest.mark.parametrize("name", _OF_SOLUTIONS.split())
def test_arguments_of_a_solution(name: str, solution: kinetics.Solution) -> None:
    _try_all(getattr(solution, name))


@pytest.fixture(scope="module")
def solution() -> kinetics.Solution:
    return solve(_scene, rtol=1e-2)


def _try_all(call: Call) -> None:
    """Call with every broken value, in a folder that stays empty where it is refused."""
    for value in BROKEN:
        with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
            result_or_refusal(call, value)
