"""A uniform field without recollisions: exact relations, parabolas, files, bad input.

Units of the exact relations: l = g = 1, so the density is 1/2 in the plane and 1/pi in space.
"""

import numpy as np
import pytest
from marking import slow_but
from sigmas import check, mean

from kinetics import solve_field
from particles import BoltzmannGrad, simulate

DISKS, SPHERES = BoltzmannGrad(0.5), BoltzmannGrad(1 / np.pi, dimension=3)


@pytest.mark.parametrize(
    ("medium", "e", "et"),
    [(DISKS, 0.0, 1.0), (DISKS, 0.7, 1.0), (SPHERES, 0.5, 1.0), (DISKS, 0.4, 0.7),
     (SPHERES, 0.4, 0.7), pytest.param(SPHERES, 0.9, 1.0, marks=pytest.mark.slow)],
)  # fmt: skip
def test_the_steady_state_is_that_of_the_equation(
    medium: BoltzmannGrad, e: float, et: float
) -> None:
    run = simulate(
        medium, e, "rest", np.linspace(30.0, 60.0, 11), media=20, tracers=1000, seed=7, field=1.0,
        tangential_restitution=et, observables=["velocities"],
    )  # fmt: skip
    state = solve_field(e, medium.dimension, et, rtol=1e-6)
    vx, speed = run.velocities[:, :, 0], np.linalg.norm(run.velocities, axis=2)
    for values, exact in (
        (vx, state.drift), (speed**2, state.mean_square_speed), (vx**2, state.mean_square_along),
        (speed, state.mean_speed), (speed * vx, state.moment(2, 1)), (speed**3, state.moment(3)),
    ):  # fmt: skip
        check(*mean(values), exact, 0.02)


@pytest.mark.parametrize(("medium", "factor"), [(DISKS, 9 / 4), (SPHERES, 3.0)])
def test_elastic_tracers_from_rest_gain_speed_as_the_exact_relation_says(
    medium: BoltzmannGrad, factor: float
) -> None:
    times = np.array([0.3, 1.0, 3.0, 10.0, 30.0])
    run = simulate(
        medium, 1.0, "rest", times, media=20, tracers=1000, field=1.0, observables=["velocities"]
    )
    cubes = np.linalg.norm(run.velocities, axis=2) ** 3
    for k, time in enumerate(times):
        check(*mean(cubes[k] + factor * run.velocities[k, :, 0]), factor * time, 0.02)


@pytest.mark.parametrize(
    ("medium", "e"),
    slow_but([(DISKS, 0.7)], [(DISKS, 0.7), (DISKS, 0.0), (SPHERES, 0.5), (SPHERES, 0.9)]),
)
def test_dispersion_grows_as_the_diffusion_coefficients_say(
    medium: BoltzmannGrad, e: float
) -> None:
    # Between late times, so that the start is forgotten: 2 D (t2 - t1).
    run = simulate(medium, e, "rest", [20.0, 220.0], media=400, tracers=100, field=1.0)
    state = solve_field(e, medium.dimension, rtol=1e-6)
    for estimate, exact in (
        (run.dispersion_parallel, state.diffusion_parallel),
        (run.dispersion_perpendicular, state.diffusion_perpendicular),
    ):
        check(np.diff(estimate.value) / 400, np.hypot(*estimate.error) / 400, exact, 0.02)


@pytest.mark.parametrize("field", [1.0, -3.0, 1e-12, 1e12])
@pytest.mark.parametrize("dimension", [2, 3])
def test_without_collisions_the_path_is_a_parabola(dimension: int, field: float) -> None:
    given = np.random.default_rng(1).normal(size=(30, dimension))
    given[0] = 0.0
    times = np.array([0.0, 1e-3, 1.0, 2.0])
    run = simulate(
        BoltzmannGrad(1e-40, dimension=dimension), 0.5, given, times, media=1, tracers=30,
        field=field, observables=["positions", "velocities", "finals"],
    )  # fmt: skip
    assert run.collision_total == 0
    t = times[:, None, None]
    along = np.eye(dimension)[0] * field
    np.testing.assert_allclose(run.velocities, given + along * t, rtol=1e-15)
    np.testing.assert_allclose(run.positions, given * t + along * t**2 / 2, rtol=1e-14)
    np.testing.assert_allclose(run.finals[:, 1], np.log(2.0), rtol=1e-15)
