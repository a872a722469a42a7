"""One value of every kind that the package makes, for the tests of values and of files."""

import math
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
from kinetics.states.state import State

TIMES = [0.0, 1.0, 100.0]
SPEEDS = np.array([0.0, 0.2, 0.7, 1.0, 1.9, 3.0])
HEIGHTS = np.array([0.0, 0.3, 0.8, 0.5, 0.4, 0.0])
HEIGHTS = HEIGHTS / np.trapezoid(HEIGHTS, SPEEDS)
ANGLES = 2.0 * np.pi * np.arange(16) / 16
VELOCITIES = np.array([[0.3, 0.1], [-1.0, 0.7], [0.0, -2.0]])


DENSITY = {2: 0.5, 3: 1.0 / np.pi}  # of scatterers, so that l = 1


def gaussian_speeds(v: Any, dimension: int = 2) -> Any:
    """The speed density of a Gaussian."""
    return (math.sqrt(2.0 / math.pi) * v if dimension == 3 else 1.0) * v * np.exp(-0.5 * v * v)


def stairs(v: Any) -> Any:
    """Two steps: 0.8 on [0.5, 1), 1.2 on [1.5, 2)."""
    return 0.8 * ((v >= 0.5) & (v < 1.0)) + 1.2 * ((v >= 1.5) & (v < 2.0))


def gamma_speeds(v: Any) -> Any:
    """v^2 exp(-v)/2, of which <v^p> = Gamma(3 + p)/2."""
    return 0.5 * v**2 * np.exp(-v)


def half_of_it(v: Any) -> Any:
    return 0.5 * gamma_speeds(v)


def polar_values(angles: Any) -> Any:
    """A density in the velocity plane that is linear in v times v between the speeds."""
    radial = np.divide(HEIGHTS, SPEEDS, out=np.zeros(6), where=SPEEDS > 0.0)
    return radial[:, None] * (1.0 + 0.5 * np.cos(angles)) / (2.0 * np.pi)


STATES: dict[str, Callable[[], State]] = {
    "gaussian": Gaussian,
    "two temperatures": lambda: Gaussian(1.5, 0.75),
    "one speed": lambda: Monoenergetic(1.3),
    "table": lambda: SpeedTable(SPEEDS, HEIGHTS),
    "speeds": lambda: SpeedSamples(np.hypot(*VELOCITIES.T)),
    "function": lambda: SpeedDensity(gamma_speeds),
    "beam": lambda: Beam(0.4, "gaussian"),
    "velocities": lambda: VelocitySamples(VELOCITIES),
    "harmonics": lambda: AngularHarmonics({0: gamma_speeds, 1: half_of_it}),
    "polar grid": lambda: PolarGrid(SPEEDS, polar_values(ANGLES)),
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
    "rough solution": lambda: solved("speeds", 0.7, ("speed_density",)),
    "scaled": lambda: solve_scaled(0.7, 1e-8),
    "exact": lambda: ScalingSolution(0.7),
    "field": lambda: solve_field(0.7, rtol=1e-4),
}  # fmt: skip
