"""Scatterers that a collision sets in motion: runs against the kinetic equation.

4 sigma for each number, 3 for the drift; chi-squares of independent tracers, of 24 none below .001.
"""

from typing import Any

import numpy as np
import pytest
from marking import slow_but
from sigmas import check_averages, check_counts

from kinetics import Scene, solve, solve_field
from particles import BoltzmannGrad, simulate

CASES = [(1.0, 0.01, 3), (1.0, 0.2, 2), (1.0, 0.5, 3), (1.0, 1.0, 2), (0.6, 3.0, 3)]
SOME = [CASES[1], CASES[4]]
NAMES = ("thermal_speed", "a2", "msd", "kurtosis", "collisions")
TIMES = np.array([0.7, 4.0, 40.0])  # l/U
TRACERS = 400_000
MEDIA = {2: BoltzmannGrad(0.5), 3: BoltzmannGrad(1.0 / np.pi, dimension=3)}  # l = 1


@pytest.mark.parametrize(("alpha", "mass", "dimension"), slow_but(SOME, CASES))
def test_runs_meet_the_kinetic_equation(alpha: float, mass: float, dimension: int) -> None:
    run = simulate(
        MEDIA[dimension], alpha, times=TIMES, media=200, tracers=TRACERS // 200, seed=6,
        observables=["positions", "velocities"], mass_ratio=mass,
    )  # fmt: skip
    usual: dict[str, Any] = dict(
        number_density=MEDIA[dimension].number_density, times=TIMES, dimension=dimension,
        mass_ratio=mass,
    )  # fmt: skip
    outputs = (*NAMES, "speed_density", "intermediate_scattering")
    solution = solve(Scene(alpha, **usual, outputs=outputs), rtol=1e-6)
    check_averages(run, solution, NAMES)
    for estimate in (run.thermal_speed, run.msd, run.kurtosis, run.collisions):
        assert np.all(estimate.error < 0.0031 * estimate.value)
    displaced = solve(Scene(alpha, **usual, outputs=("msd", "position_density")), rtol=1e-3)
    speed, distance = (np.linalg.norm(x, axis=2) for x in (run.velocities, run.positions))
    x, w = np.polynomial.legendre.leggauss(8)
    for i, thermal in enumerate(solution.thermal_speed):
        edges = np.linspace(0.0, 2.6, 41) * thermal
        v = edges[:-1, None] + np.diff(edges)[:, None] * 0.5 * (x + 1.0)
        f = solution.speed_density(v.ravel())[i].reshape(v.shape)
        check_counts(TRACERS, np.histogram(speed[i], edges)[0], 0.5 * np.diff(edges) * (f @ w))
        edges = np.linspace(0.0, 3.0, 31) * np.sqrt(solution.msd[i])
        check_counts(
            TRACERS, np.histogram(distance[i], edges)[0], displaced.position_fraction(edges)[i]
        )
        for k in np.array([0.5, 1.5]) / np.sqrt(solution.msd[i]):
            wave = np.cos(k * run.positions[i, :, 0])
            off = wave.mean() - solution.intermediate_scattering([k])[i, 0]
            assert abs(off) < 4.0 * wave.std() / np.sqrt(TRACERS), (i, k)


@pytest.mark.parametrize(
    ("alpha", "mass", "dimension"), slow_but([(1.0, 1.0, 3)], [(0.0, 0.5, 2), (1.0, 1.0, 3)])
)
def test_the_drift_in_a_field(alpha: float, mass: float, dimension: int) -> None:
    run = simulate(
        MEDIA[dimension], alpha, "rest", [30.0], media=100, tracers=600, seed=2, field=1.0,
        mass_ratio=mass,
    )  # fmt: skip
    drift = run.drift
    assert drift.error[0] < 0.003 * drift.value[0]
    state = solve_field(alpha, dimension, mass_ratio=mass)
    assert abs(drift.value[0] - state.drift) < 3.0 * drift.error[0]
