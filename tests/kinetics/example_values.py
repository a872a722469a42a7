"""One value of every kind that the package makes, for the tests of values and of files."""

from collections.abc import Callable
from typing import Any

import numpy as np

from kinetics import (
    AngularHarmonics,
    Beam,
    Gaussian,
    Monoenergetic,
    PolarGrid,
    ScalingSolution,
    Scene,
    Solution,
    SpeedDensity,
    SpeedSamples,
    SpeedTable,
    VelocitySamples,
    solve,
    solve_field,
    solve_scaled,
)
from kinetics.outputs import OUTPUTS

TIMES = [0.0, 1.0, 100.0]


def rayleigh(v: Any) -> Any:
    return v * np.exp(-v * v / 2)


def quadrupole(v: Any) -> Any:
    return 0.1 * v * np.exp(-v * v / 2)


STATES: dict[str, Callable[[], Any]] = {
    "gaussian": lambda: "gaussian",
    "monoenergetic": lambda: "monoenergetic",
    "two temperatures": lambda: Gaussian(1.0, 1.5),
    "one speed": lambda: Monoenergetic(2.0),
    "table": lambda: SpeedTable([0.5, 1.0, 1.5], [0.0, 2.0, 0.0]),
    "samples": lambda: SpeedSamples([0.5, 1.0, 2.0]),
    "beam": lambda: Beam(0.3, "gaussian"),
    "velocities": lambda: VelocitySamples([[1.0, 0.0], [0.0, 2.0]]),
    "grid": lambda: PolarGrid([0.5, 1.0, 1.5], np.outer([0.0, 1.0, 0.0], np.ones(5)) / np.pi),
    "density": lambda: SpeedDensity(rayleigh),
    "harmonics": lambda: AngularHarmonics({0: rayleigh, 2: quadrupole}),
}


def solved(state: str, e: float = 0.7, outputs: Any = ("thermal_speed", "msd")) -> Solution:
    scene = Scene(e, initial=STATES[state](), times=TIMES, outputs=outputs, harmonics=2)
    return solve(scene, rtol=1e-3)


def with_densities() -> Solution:
    return solved("beam", outputs=(*OUTPUTS,))


VALUES: dict[str, Callable[[], Any]] = {
    **{f"scene, {name}": lambda s=state: Scene(0.7, initial=s(), times=TIMES)  # type: ignore[misc]
       for name, state in STATES.items()},
    "solution": lambda: solved("table"),
    "solution with densities": with_densities,
    "elastic solution": lambda: solved("gaussian", 1.0, ("speed_density", "msd")),
    "rough solution": lambda: solved("samples", 0.7, ("speed_density",)),
    "scaled": lambda: solve_scaled(0.7, 1e-8),
    "exact": lambda: ScalingSolution(0.7),
    "field": lambda: solve_field(0.7, rtol=1e-4),
}  # fmt: skip
