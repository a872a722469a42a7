"""Densities of the velocity among scatterers that are met again, by other routes."""

import numpy as np
import pytest
from example_values import gaussian_speeds

from kinetics import AngularHarmonics, Scene, SolverStatus, solve

DIRECTED = AngularHarmonics({
    0: gaussian_speeds,
    1: lambda v: 0.3 * gaussian_speeds(v),
    2: lambda v: 0.2 * gaussian_speeds(v),
})  # fmt: skip


@pytest.mark.parametrize(
    ("e", "n", "scatterers"),
    [
        (0.7, 0.04, "hard disks"),
        pytest.param(0.3, 0.02, "overlapping", marks=pytest.mark.slow),
        (0.95, 0.1, "hard disks"),
    ],
)
def test_its_moments_are_the_averages(e: float, n: float, scatterers: str) -> None:
    """Those come from the backward equation, which has a discretisation of its own."""
    scene = Scene(
        e, n, initial=DIRECTED, times=np.array([0.5, 3.0, 30.0, 1e4]) / n, harmonics=2,
        scatterers=scatterers, outputs=("thermal_speed", "velocity_density"),
    )  # fmt: skip
    solution = solve(scene)
    assert solution.status is SolverStatus.CONVERGED
    x = np.linspace(-25.0, 3.5, 600)
    v = np.exp(x)
    for m, powers in ((0, (0.0, 1.0, 2.0)), (1, (1.0,)), (2, (2.0,))):
        for p in powers:
            expected, size = solution.harmonic(p, m), solution.moment(p)
            for i, v0 in enumerate(solution.thermal_speed):
                f = solution._answer.profiles[m].at(i, v0 * v) * (v0 * v) ** (p + 1.0)
                found = np.sum(f) * (x[1] - x[0])
                # averages know that returns take time, densities do not
                assert abs(found - expected[i]) < (0.15 * n if m or p else 2e-10) * size[i]


def test_what_is_not_known_is_said() -> None:
    scene = Scene(0.3, 0.1, times=[100.0], scatterers="hard disks", outputs="speed_density")
    solution = solve(scene)
    assert "of which the density may be negative" in solution.message
    assert solution.speed_density([0.02 * 2**0.5])[0, 0] != 0.0
    fine = solve(Scene(0.7, 0.04, times=[5e3], scatterers="hard disks", outputs="speed_density"))
    share = fine.model_error["speed_density"].max()
    assert f"slower than v is off by up to {share:.2g}" in fine.message
