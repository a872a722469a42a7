"""How long typical questions take, for comparing one version of this package with another.

Not among the default tests. pytest-benchmark keeps the runs and compares them:

    pytest tests/benchmarks --benchmark-autosave                          # before the change
    pytest tests/benchmarks --benchmark-compare                           # after it
    pytest tests/benchmarks --benchmark-compare --benchmark-compare-fail=median:25%

Times of two machines, or of a busy one, cannot be compared. How run time and error of different
methods compare on one version is another question: `lorentz bench`.
"""

import subprocess
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from kinetics import Beam, Gaussian, Scene, solve, solve_scaled
from particles import BoltzmannGrad, HardDisks, simulate

TIMES = np.geomspace(1.0, 1e8, 100)
SPEEDS = np.linspace(0.1, 4.0, 100)
RADII = np.linspace(0.0, 6.0, 200)


def scene(*outputs: str, e: float = 0.7, times: Any = TIMES, **others: Any) -> Scene:
    return Scene(e, times=times, outputs=outputs, **others)


QUESTIONS: dict[str, Callable[[], Any]] = {
    "scaled F(c), rtol 1e-12": lambda: solve_scaled(0.7, 1e-12).vdf(SPEEDS),
    "scaled h and a2, rtol 1e-12": lambda: solve_scaled(0.7, 1e-12).a2,
    "v0 and a2, Gaussian": lambda: solve(scene("thermal_speed", "a2"), 1e-10),
    "v0 and a2, Gaussian, e = 0": lambda: solve(scene("thermal_speed", "a2", e=0.0), 1e-10),
    "v0 and a2, monoenergetic": lambda: solve(
        scene("thermal_speed", "a2", initial="monoenergetic"), 1e-10
    ),
    "harmonic of a beam": lambda: solve(scene("thermal_speed", initial=Beam()), 1e-10).harmonic(
        1.0, 1
    ),
    "<r^2>": lambda: solve(scene("msd"), 1e-10),
    "<r^2> and kurtosis": lambda: solve(scene("msd", "kurtosis"), 1e-10),
    "<r^2> and kurtosis, 10000 times": lambda: solve(
        scene("msd", "kurtosis", times=np.geomspace(0.1, 1e8, 10_000)), 1e-10
    ),
    "speed density": lambda: solve(scene("speed_density"), 1e-8),
    "speed density, e = 0.99, 256 times": lambda: solve(
        scene("speed_density", e=0.99, times=np.geomspace(1.0, 1e4, 256)), 1e-8
    ),
    "speed density, conservative, 2048 nodes": lambda: solve(
        scene("speed_density", times=np.geomspace(0.1, 100.0, 25)), 1e-8, "conservative", 2048
    ),
    "velocity density, 17 harmonics": lambda: solve(
        scene("velocity_density", times=[10.0, 100.0], initial=Gaussian(2.0, 1.0), harmonics=32),
        1e-8,
    ),
    "G(R), t = 300": lambda: solve(
        scene("position_density", e=0.6, times=[300.0]), 1e-5
    ).scaled_position_density(RADII),
}
FLIGHTS: dict[str, tuple[Any, Any]] = {
    "hard disks, 0.04 per d^2": (HardDisks(0.04, count=10_000), {"max_collisions": 500}),
    "hard disks, 0.5 per d^2": (HardDisks(0.5, count=10_000), {"max_collisions": 500}),
    "Boltzmann-Grad": (BoltzmannGrad(0.04), {"max_collisions": 500}),
    "Boltzmann-Grad, 20 times": (BoltzmannGrad(0.04), {"times": np.geomspace(1.0, 1e4, 20)}),
}


@pytest.mark.parametrize("name", QUESTIONS)
def test_solver(benchmark: Any, name: str) -> None:
    benchmark(QUESTIONS[name])


@pytest.mark.parametrize("name", FLIGHTS)
def test_particles(benchmark: Any, name: str) -> None:
    medium, until = FLIGHTS[name]
    run = benchmark(simulate, medium, 0.9, media=4, tracers=300, workers=1, **until)
    assert run.collision_total > 0


@pytest.mark.parametrize("module", ["kinetics", "particles"])
def test_import(benchmark: Any, module: str) -> None:
    """A whole process: the interpreter, and the import."""
    command = [sys.executable, "-c", f"import {module}"]
    benchmark.pedantic(subprocess.run, (command,), {"check": True}, rounds=7, warmup_rounds=1)
