"""Sizes, times and starts at the ends of the doubles: right where the answer is in range.

`lorentz stress` tries many more of them: restitutions, times to 1e300, speeds from 1e-150 to 1e150,
rough starts, few nodes (kinetics/crosscheck/stress.py and tests/crosscheck/test_stress.py).
"""

import math
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from kinetics import (
    Beam,
    Gaussian,
    InputError,
    Scene,
    SolverStatus,
    SpeedTable,
    solve,
    solve_scaled,
)

pytestmark = pytest.mark.usefixtures("no_hang")
DENSITY = ("speed_density", "thermal_speed")


def tail(v: Any) -> Any:
    """A speed density that falls as v^-6."""
    return 5 * v * (1 + v**2) ** -3.5


def cooling_rate(e: float) -> float:
    """h, from averages over the impact parameter in many digits."""
    if e == 0.0:
        return math.sqrt(2.0)
    # 1 - e^2 must differ from 1
    with mp.workdps(50 + int(-2.0 * math.log10(e))):
        b = mp.sqrt(1 - mp.mpf(e) ** 2)
        kappa = 1 - e * mp.acos(e) / b
        first = (1 - mp.mpf(e) ** 2 * mp.atanh(b) / b) / 2
        return float(2 * mp.sqrt(kappa * first))


def one_line(error: InputError) -> None:
    message = str(error)
    assert "\n" not in message
    assert message.split(":")[0].isidentifier(), message


@pytest.mark.parametrize(
    "sizes",
    [
        {"number_density": 1e-310},
        {"diameter": 1e-310},
        {"number_density": 1e200, "diameter": 1e200},
        {"number_density": 1e-200, "diameter": 1e-200},
    ],
)
def test_a_mean_free_path_that_is_no_number_is_refused(sizes: Any) -> None:
    with pytest.raises(InputError, match=r"^number_density: .*mean free path") as caught:
        Scene(restitution=0.5, times=[1.0], **sizes)
    one_line(caught.value)


@pytest.mark.parametrize("e", [0.0, 0.7, 1.0])
@pytest.mark.parametrize("number_density", [1e-150, 1e-160, 1e-250])
def test_flight_far_below_the_mean_free_path(number_density: float, e: float) -> None:
    """Nothing collides: <r^2> = <v^2> t^2, though (v t/l)^2 is below the smallest number."""
    times = np.array([0.0, 1e-100, 1e-20, 1e-6, 1.0])
    outputs = ("msd", "kurtosis", "diffusion_coefficient", "mean_displacement")
    scene = Scene(
        restitution=e,
        number_density=number_density,
        initial=Beam(0.0),
        times=times,
        outputs=outputs,
    )
    found = solve(scene, rtol=1e-11)
    assert np.allclose(found.msd, times**2, rtol=1e-11, atol=0.0)
    assert np.allclose(found.kurtosis, 1.0, rtol=1e-10)
    assert np.allclose(found.diffusion_coefficient, 0.5 * times, rtol=1e-11, atol=0.0)
    assert np.allclose(found.msd_slope, 2.0 * times**2, rtol=1e-11, atol=0.0)
    assert np.allclose(found.mean_displacement[:, 0], times, rtol=1e-11, atol=0.0)


@pytest.mark.parametrize("rtol", [1e-3, 1e-8, 1e-12])
@pytest.mark.parametrize(
    "state",
    [
        Gaussian(1e-3, 1.0),
        Gaussian(1.0, 1e-150),
        SpeedTable([0.0, 1.0], [2.0, 0.0]),
        SpeedTable([0.0, 1.0], [0.0, 2.0]),
    ],
    ids=str,
)
def test_no_tracers_are_left_out_of_a_start(state: Any, rtol: float) -> None:
    """Late, the slowest tracers of the start count as much as the others."""
    scene = Scene(restitution=0.7, initial=state, times=[0.0, 1e300])
    solution = solve(scene, rtol=rtol)
    assert np.allclose(solution.moment(0.0), 1.0, rtol=rtol)
    late = 25.0 / cooling_rate(0.7) / 1e300
    assert abs(solution.thermal_speed[1] / late - 1.0) < rtol + 1e-13


def test_moments_of_slow_tracers_that_do_not_exist() -> None:
    """<v^p> of a table that begins at speed 0 is infinite for p <= -1, or -2 if it rises from 0."""
    for density, lowest in (([2.0, 0.0], -1.0), ([0.0, 2.0], -2.0)):
        solution = solve(Scene(0.7, initial=SpeedTable([0.0, 1.0], density), times=[0.0]))
        with pytest.raises(InputError, match=r"^p:"):
            solution.moment(lowest)
        p = lowest + 0.5
        a, b = density
        expected = a / (p + 1.0) + (b - a) / (p + 2.0)
        assert solution.moment(p)[0] == pytest.approx(expected, rel=1e-8)


ANY_RESTITUTION = st.one_of(
    st.floats(0.0, 1.0),
    st.floats(-16, 0).map(lambda x: 10.0**x),
    st.floats(-16, 0).map(lambda x: 1.0 - 10.0**x),
)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(e=ANY_RESTITUTION, rtol=st.sampled_from([1e-2, 1e-6, 1e-10]))
@example(e=1.0 - 2.0**-53, rtol=1e-2)
@example(e=0.9999999999999963, rtol=1e-6)
@example(e=4e-65, rtol=1e-6)
def test_random_scaled(e: float, rtol: float) -> None:
    if e == 1.0:
        with pytest.raises(InputError, match=r"^restitution:"):
            solve_scaled(e, rtol)
        return
    try:
        solution = solve_scaled(e, rtol)
    except InputError as error:
        one_line(error)
        return
    assert np.isfinite(solution.a2)
    if solution.status is SolverStatus.CONVERGED:
        assert abs(solution.cooling_rate / cooling_rate(e) - 1.0) < 10 * rtol


@pytest.mark.parametrize("scatterers", ["dilute", "hard disks"])
def test_speed_densities_at_the_smallest_speeds(scatterers: str) -> None:
    """f(v) is near the largest number there, and 1/v alone above it."""
    asked = {"number_density": 0.04, "scatterers": scatterers, "outputs": ("speed_density",)}
    late, later = (solve(Scene(1e-3, times=[t], **asked), 0.01) for t in (1e250, 1e308))
    found = later.speed_density([1e-309, 3e-309])[0] / 1e308
    np.testing.assert_allclose(found, late.speed_density([1e-251, 3e-251])[0] / 1e250, rtol=1e-5)
