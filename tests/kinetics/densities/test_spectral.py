"""The speed density in time: mass, positivity, moments, late times, and exact short answers."""

from typing import Any

import numpy as np
import pytest

from kinetics import Scene, Solution, SolverStatus, solve

OUTPUTS = ("speed_density", "thermal_speed", "a2")


def density(e: float, times: Any, initial: Any = "gaussian", **options: Any) -> Solution:
    return solve(Scene(e, times=times, initial=initial, outputs=OUTPUTS), **options)


@pytest.mark.parametrize(
    ("e", "rtol", "count"), [(0.4, 1e-4, 1024), (0.5, 1e-6, 1024), (0.9, 1e-9, None)]
)
def test_far_below_the_thermal_speed_the_density_goes_to_zero(
    e: float, rtol: float, count: int | None
) -> None:
    """The lower end of the nodes left g = v f of the size that is resolved there; f was -17."""
    solution = density(e, [0.5, 30.0], rtol=rtol, nodes=count)
    assert solution.status is SolverStatus.CONVERGED
    for k, thermal in enumerate(solution.thermal_speed):
        v = thermal * np.geomspace(1e-10, 1e-3, 200)
        f = thermal * solution.speed_density(v)[k]
        assert f.min() > 0.0
        assert np.all(f < 3.0 * v / thermal)  # the start is 2 v/v0^2 there, and tracers leave it


@pytest.mark.parametrize("e", [1e-6, 1e-3, 0.02, 0.045, 0.06])
def test_small_restitutions_keep_what_is_promised_and_claim_it(e: float) -> None:
    # of speeds above 1e-2 v0 relative to the maximum; below, of the density of ln v
    times = [0.5, 30.0, 3e3]
    scene = Scene(e, times=times, outputs=("thermal_speed", "speed_density"))
    for rtol in (1e-3, 1e-6):
        found, best = solve(scene, rtol, method="spectral"), solve(scene, 1e-9, method="spectral")
        assert found.status is SolverStatus.CONVERGED
        for i, v0 in enumerate(found.thermal_speed):
            v = v0 * np.geomspace(1e-6, 6.0, 400)
            f, exact = found.speed_density(v)[i], best.speed_density(v)[i]
            promised = v >= 1e-2 * v0
            assert np.max(np.abs(f - exact)[promised]) <= rtol * exact.max()
            assert np.max(np.abs(f - exact) * v) <= rtol * np.max(exact * v)
