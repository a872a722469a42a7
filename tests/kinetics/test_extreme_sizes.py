"""Sizes, times and starts at the ends of the doubles: right where the answer is in range.

`lorentz stress` tries many more of them: restitutions, times to 1e300, speeds from 1e-150 to 1e150,
rough starts, few nodes (kinetics/crosscheck/stress and tests/crosscheck/stress).
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
    Monoenergetic,
    PolarGrid,
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


@pytest.mark.parametrize("e", [0.0, 0.7, 1.0])
@pytest.mark.parametrize("t", [1e-300, 1e-170, 1e-100, 1e-10])
def test_position_density_of_free_flight(t: float, e: float) -> None:
    """g(r, t) = f(r/t)/t, f the start; <r^2> itself may be below the smallest number."""
    found = solve(Scene(restitution=e, times=[t], outputs=("position_density",)), rtol=1e-3)
    R = np.array([0.0, 0.5, 1.0, 2.0])
    expected = 2.0 * R * np.exp(-R * R)
    assert np.allclose(found.scaled_position_density(R)[0], expected, atol=1e-3)
    assert found.scaled_position_density([1e200])[0, 0] == 0.0
    sharp = Scene(restitution=e, initial="monoenergetic", times=[t], outputs=("position_density",))
    radius, share = solve(sharp, rtol=1e-3).ballistic_front
    assert np.allclose(radius, t, rtol=1e-12, atol=0.0)
    assert share[0, 0] == pytest.approx(1.0, abs=1e-9)


@pytest.mark.slow
def test_far_arguments_of_densities() -> None:
    """Where there is nothing left there is 0, and no warning of an overflow."""
    far = np.array([0.0, 1.0, 1e200])
    outputs = ("speed_density", "position_density")
    for initial in ("gaussian", "monoenergetic", Gaussian(0.1, 1.0)):
        for e in (0.5, 1.0):
            scene = Scene(restitution=e, initial=initial, times=[1.0, 1e8], outputs=outputs)
            found = solve(scene, rtol=1e-3)
            for values in (
                found.speed_density(far),
                found.velocity_component_density(far),
                found.position_density(far),
                found.scaled_position_density(np.array([1.0, 1e308])),
            ):
                assert np.all(np.isfinite(values))
                assert np.allclose(values[:, -1], 0.0, atol=1e-300)


@pytest.mark.parametrize("e", [0.0, 0.7, 1.0 - 1e-10])
def test_table_with_spikes_far_apart(e: float) -> None:
    """All tracers reach the scaling state, the slow half of them too."""
    spike = np.array([1.0, 1.0 + 1e-7, 1.0 + 2e-7])
    for slow, fast in ((1e-75, 1e75), (1e-5, 1e5)):
        table = SpeedTable(
            np.concatenate([slow * spike, fast * spike]),
            [0.0, 0.5e7 / slow, 0.0, 0.0, 0.5e7 / fast, 0.0],
        )
        scene = Scene(restitution=e, initial=table, times=[0.0, 1e300], outputs=("thermal_speed",))
        solution = solve(scene, rtol=1e-6)
        expected = [math.sqrt(0.5) * fast, 25.0 / cooling_rate(e) / 1e300]
        assert np.allclose(solution.thermal_speed, expected, rtol=1e-6, atol=0.0)


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


@pytest.mark.parametrize("initial", ["gaussian", "tail"])
@pytest.mark.parametrize("e", [0.0, 1e-10, 1e-4, 0.01])
def test_densities_of_the_slowest_tracers(e: float, initial: str) -> None:
    """At e = 0 bounces leave a density at v = 0; for e > 0, down to speeds e times their own.

    Below 1e-2 of the thermal speed it is the density of ln v that keeps its accuracy for e > 0:
    this one's error, divided by v, may be larger there. At e = 0 it may not.
    """
    scene = Scene(
        restitution=e,
        initial=tail if initial == "tail" else initial,
        times=[0.5, 30.0, 1e3],
        outputs=DENSITY,
    )
    loose, tight = (solve(scene, rtol=rtol, method="spectral") for rtol in (1e-6, 1e-9))
    c = np.geomspace(1e-8, 10.0, 2000)
    share = np.ones(c.size) if e == 0.0 else np.minimum(1.0, c / 1e-2)
    for i, v0 in enumerate(tight.thermal_speed):
        expected = tight.speed_density(c * v0)[i]
        apart = np.abs(loose.speed_density(c * v0)[i] - expected) * share
        assert apart.max() <= 1e-6 * expected.max()
    assert loose.status is SolverStatus.CONVERGED


@pytest.mark.parametrize("size", [1e-150, 1e150])
def test_elastic_collisions_of_extreme_sizes(size: float) -> None:
    """v t/l, whatever the sizes of v, t and l apart."""
    scene = Scene(
        restitution=1.0,
        number_density=0.5 / size,
        initial=Monoenergetic(size),
        times=[0.0, 1e-250, 1e-3, 1e250],
        outputs=("collisions",),
    )
    found = solve(scene, rtol=1e-10).collisions
    assert np.allclose(found, scene.times, rtol=1e-12, atol=0.0)


@pytest.mark.parametrize("rtol", [1e-4, 1e-8])
@pytest.mark.parametrize("e", [0.0, 0.1, 0.5, 0.7, 0.9])
def test_smooth_densities_keep_their_sign(e: float, rtol: float) -> None:
    """Down to speeds of 1e-12: an error of the density of ln v would be divided by v there."""
    scene = Scene(restitution=e, times=[0.0, 1.0, 30.0, 1e3, 1e6], outputs=DENSITY)
    solution = solve(scene, rtol=rtol, method="spectral")
    v = np.geomspace(1e-12, 10.0, 400)
    for i, v0 in enumerate(solution.thermal_speed):
        f = solution.speed_density(v * v0)[i]
        assert f.min() >= -rtol * f.max(), i


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


@pytest.mark.parametrize("p", [2.0, 4.0, -1.5, 40.0])
def test_moments_that_leave_the_range(p: float) -> None:
    """<v^p> of speeds 1e150: a finite number, or a line that says it overflows."""
    solution = solve(Scene(restitution=0.5, initial=Monoenergetic(1e150), times=[0.0, 1e10]))
    try:
        found = solution.moment(p)
    except InputError as error:
        one_line(error)
        return
    assert np.all(np.isfinite(found))


@pytest.mark.parametrize("scatterers", ["dilute", "hard disks"])
def test_speed_densities_at_the_smallest_speeds(scatterers: str) -> None:
    """f(v) is near the largest number there, and 1/v alone above it."""
    asked = {"number_density": 0.04, "scatterers": scatterers, "outputs": ("speed_density",)}
    late, later = (solve(Scene(1e-3, times=[t], **asked), 0.01) for t in (1e250, 1e308))
    found = later.speed_density([1e-309, 3e-309])[0] / 1e308
    np.testing.assert_allclose(found, late.speed_density([1e-251, 3e-251])[0] / 1e250, rtol=1e-5)


@pytest.mark.slow
def test_a_density_of_masses_far_below_the_highest_node() -> None:
    """Their mean square, in the speed of the highest node, is below the smallest number."""
    speed = np.linspace(0.0, 2.0, 6)
    start = PolarGrid(speed, np.full((6, 1), 0.25 / math.pi))
    asked = {"number_density": 0.04, "scatterers": "hard disks", "outputs": ("speed_density",)}
    solution = solve(Scene(1e-8, initial=start, harmonics=3, times=[1e290], **asked), 0.01)
    assert solution.status is SolverStatus.CONVERGED
