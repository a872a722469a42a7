"""Sizes, times and starts at the ends of the doubles: right where the answer is in range.

`lorentz stress` tries many more of them: restitutions, times to 1e300, speeds from 1e-150 to 1e150,
rough starts, few nodes (kinetics/crosscheck/stress.py and tests/crosscheck/test_stress.py).
"""

from typing import Any

import numpy as np
import pytest

from kinetics import (
    Beam,
    Gaussian,
    InputError,
    Monoenergetic,
    ScalingSolution,
    Scene,
    SolverStatus,
    SpeedTable,
    solve,
)


@pytest.mark.parametrize("e", [0.0, 0.7, 1.0])
@pytest.mark.parametrize("number_density", [1e-150, 1e-160, 1e-250])
def test_flight_far_below_the_mean_free_path(number_density: float, e: float) -> None:
    """Nothing collides: <r^2> = <v^2> t^2, though (v t/l)^2 is below the smallest number."""
    times = np.array([0.0, 1e-100, 1e-20, 1e-6, 1.0])
    outputs = ("msd", "kurtosis", "diffusion_coefficient", "mean_displacement")
    scene = Scene(e, number_density, initial=Beam(0.0), times=times, outputs=outputs)
    found = solve(scene, rtol=1e-11)
    assert np.allclose(found.msd, times**2, rtol=1e-11, atol=0.0)
    assert np.allclose(found.kurtosis, 1.0, rtol=1e-10)
    assert np.allclose(found.diffusion_coefficient, 0.5 * times, rtol=1e-11, atol=0.0)
    assert np.allclose(found.msd_slope, 2.0 * times**2, rtol=1e-11, atol=0.0)
    assert np.allclose(found.mean_displacement[:, 0], times, rtol=1e-11, atol=0.0)


@pytest.mark.parametrize("rtol", [1e-3, 1e-8, 1e-12])
@pytest.mark.parametrize("state", [
    Gaussian(1e-3, 1.0), Gaussian(1.0, 1e-4), SpeedTable([0.0, 1.0], [2.0, 0.0]),
    SpeedTable([0.0, 1.0], [0.0, 2.0]),
], ids=str)  # fmt: skip
def test_no_tracers_are_left_out_of_a_start(state: Any, rtol: float) -> None:
    """Late, the slowest tracers of the start count as much as the others."""
    scene = Scene(restitution=0.7, initial=state, times=[0.0, 1e300])
    solution = solve(scene, rtol=rtol)
    assert np.allclose(solution.moment(0.0), 1.0, rtol=rtol)
    late = 25.0 / ScalingSolution(0.7).cooling_rate / 1e300
    assert abs(solution.thermal_speed[1] / late - 1.0) < rtol + 1e-13


@pytest.mark.parametrize("scatterers", ["dilute", "hard disks"])
def test_speed_densities_at_the_smallest_speeds(scatterers: str) -> None:
    """f(v) is near the largest number there, and 1/v alone above it."""
    asked = {"number_density": 0.04, "scatterers": scatterers, "outputs": ("speed_density",)}
    late, later = (solve(Scene(1e-3, times=[t], **asked), 0.01) for t in (1e250, 1e308))
    found = later.speed_density([1e-309, 3e-309])[0] / 1e308
    np.testing.assert_allclose(found, late.speed_density([1e-251, 3e-251])[0] / 1e250, rtol=1e-5)


@pytest.mark.parametrize("length", [-150, -40, 0, 150])
@pytest.mark.parametrize("speed", [-120, 0, 120])
@pytest.mark.parametrize("e", [0.0, 0.7, 1.0 - 1e-9])
def test_averages_do_not_depend_on_the_units(e: float, length: int, speed: int) -> None:
    """Mean free path and speeds times 1e-150 to 1e150: the answers are those of l = v = 1."""
    powers = {"thermal_speed": (0, 1), "a2": (0, 0), "collisions": (0, 0), "msd": (2, 0),
              "kurtosis": (0, 0), "mean_displacement": (1, 0), "mean_velocity": (0, 1)}  # fmt: skip
    names = tuple(n for n, (a, b) in powers.items() if abs(a * length + b * speed) < 290)
    times = 10.0 ** np.array([-8.0, -3.0, 0.0, 3.0])
    one = solve(Scene(e, 0.5, 1.0, initial=Beam(0.3), times=times, outputs=names), 1e-9)
    start = Beam(0.3, Monoenergetic(10.0**speed))
    times = times * 10.0 ** (length - speed)
    scene = Scene(e, 0.5 * 10.0**-length, 1.0, initial=start, times=times, outputs=names)
    other = solve(scene, 1e-9)
    for name in names:
        a, b = powers[name]
        scaled = other.values[name] / 10.0 ** (a * length) / 10.0 ** (b * speed)
        size = 1.0 if name == "a2" else np.max(np.abs(one.values[name]))
        np.testing.assert_allclose(scaled, one.values[name], rtol=1e-8, atol=1e-8 * size)


def test_a_diameter_whose_square_is_no_number() -> None:
    scene = Scene(0.2, number_density=0.04, diameter=1e190, times=[1e3])
    assert solve(scene).status is SolverStatus.CONVERGED
    assert "dilute" in scene.system


@pytest.mark.parametrize("tangential_restitution", [1e-320, 1e-300])
def test_negative_powers_of_bounces_that_all_but_stop_are_refused(
    tangential_restitution: float,
) -> None:
    scene = Scene(
        0.2, times=[1.0, 1e3], tangential_restitution=tangential_restitution, outputs="temperature"
    )
    solution = solve(scene, rtol=1e-12)
    with pytest.raises(InputError, match="overflows"):
        solution.moment(-1.1)
