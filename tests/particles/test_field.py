"""A uniform field without recollisions: exact relations, parabolas, files, bad input.

Units of the exact relations: l = g = 1, so the density is 1/2 in the plane and 1/pi in space.
"""

import numpy as np
import pytest
from marking import slow_but

from particles import BoltzmannGrad, simulate

DISKS, SPHERES = BoltzmannGrad(0.5), BoltzmannGrad(1 / np.pi, dimension=3)
# The steady state by a spectral solution, to its digits: medium, e -> <v_x>, <v^2>, <v_x^2>, <v>.
TABLE = [
    (DISKS, 0.0, (0.985849365, 1.66747853, 1.39179697, 1.12644819)),
    (DISKS, 0.5, (0.617488571, 1.461042878, 1.009250122, 1.050469279)),
    (DISKS, 0.7, (0.501926120, 1.702146384, 1.061388235, 1.160252548)),
    (DISKS, 0.9, (0.360142487, 2.749139291, 1.498433309, 1.509687291)),
    (SPHERES, 0.5, (0.739513156, 2.117863779, 1.190681425, 1.320254784)),
    (SPHERES, 0.9, (0.433647013, 3.934205475, 1.514376724, 1.864407124)),
]


def late_velocities(
    medium: BoltzmannGrad, restitution: float, tangential: float = 1.0
) -> np.ndarray:
    """Velocities in the steady state, one axis for the tracers, which are independent."""
    times = np.linspace(30.0, 60.0, 11)
    run = simulate(
        medium, restitution, "rest", times, media=20, tracers=1000, seed=7, field=1.0,
        tangential_restitution=tangential, observables=["velocities"],
    )  # fmt: skip
    return run.velocities


def check(per_tracer: np.ndarray, expected: float, sigmas: float = 4.0) -> None:
    """The mean over times and tracers is the one expected, within so many standard errors.

    The error is that of independent tracers, whose values at different times are not independent.
    """
    values = per_tracer.mean(axis=0)
    error = values.std(ddof=1) / np.sqrt(values.size)
    assert error < 0.02 * abs(expected)
    assert abs(values.mean() - expected) < sigmas * error, (values.mean(), expected, error)


@pytest.mark.parametrize(
    ("medium", "restitution", "figures"), slow_but([TABLE[0], TABLE[2], TABLE[4]], TABLE)
)
def test_the_steady_state_is_that_of_the_table_and_of_the_exact_relations(
    medium: BoltzmannGrad, restitution: float, figures: tuple[float, ...]
) -> None:
    v = late_velocities(medium, restitution)
    vx, speed = v[:, :, 0], np.linalg.norm(v, axis=2)
    for values, expected in zip((vx, speed**2, vx**2, speed), figures, strict=True):
        check(values, expected)
    # <v v_x> = 1/lambda_1(1), <cos> = (1 - E[s]) <v^2>, <v^3> = 2 <v_x>/lambda(2).
    plane = medium.dimension == 2
    check(speed * vx, (1.5 if plane else 2.0) / (1 + restitution))
    y = np.polynomial.legendre.leggauss(200)[0] * 0.5 + 0.5
    weight = np.polynomial.legendre.leggauss(200)[1] * (0.5 if plane else y)
    mean_ratio = weight @ np.sqrt(restitution**2 + (1 - restitution**2) * y * y)
    check(vx / speed - (1 - mean_ratio) * speed**2 + 1.0, 1.0)
    loss = (1 - restitution**2) * (2 / 3 if plane else 1 / 2)
    check(speed**3 * loss - 2 * vx + 1.0, 1.0)


@pytest.mark.parametrize(("medium", "square"), [(DISKS, 1 / 3), (SPHERES, 1 / 2)])
def test_rough_scatterers_take_the_momentum_that_their_law_says(
    medium: BoltzmannGrad, square: float
) -> None:
    # lambda_1(1) = 1 - E[s cos(chi)] = 1 + e - (e + et) E[y^2].
    v = late_velocities(medium, 0.4, 0.7)
    rate = 1 + 0.4 - (0.4 + 0.7) * square
    check(np.linalg.norm(v, axis=2) * v[:, :, 0], 1 / rate)


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
        check((cubes[k] + factor * run.velocities[k, :, 0])[None] / time, factor)


@pytest.mark.parametrize(
    ("medium", "restitution", "parallel", "perpendicular"),
    slow_but(
        [(DISKS, 0.7, 0.190614669672, 0.329659424454)],
        [
            (DISKS, 0.7, 0.190614669672, 0.329659424454),
            (DISKS, 0.0, 0.168078916, 0.253544834),
            (SPHERES, 0.5, 0.207270834292, 0.332689794549),
            (SPHERES, 0.9, 0.305814928981, 0.568114933278),
        ],
    ),
)
def test_dispersion_grows_as_the_diffusion_coefficients_say(
    medium: BoltzmannGrad, restitution: float, parallel: float, perpendicular: float
) -> None:
    # Between late times, so that the start is forgotten: 2 D (t2 - t1).
    times = np.array([20.0, 220.0])
    run = simulate(medium, restitution, "rest", times, media=400, tracers=100, field=1.0)
    for estimate, exact in (
        (run.dispersion_parallel, parallel),
        (run.dispersion_perpendicular, perpendicular),
    ):
        found, error = np.diff(estimate.value)[0] / 400, np.hypot(*estimate.error) / 400
        assert error < 0.02 * exact
        assert abs(found - exact) < 4 * error, (found, error)


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


def test_a_field_the_other_way_turns_everything_round() -> None:
    given = np.random.default_rng(5).normal(size=(40, 2))
    one, other = (
        simulate(
            DISKS, 0.6, sign * given, [0.5, 9.0], media=1, tracers=40, field=sign * 0.7,
            observables=["positions", "velocities"],
        )
        for sign in (1.0, -1.0)
    )  # fmt: skip
    assert np.array_equal(one.positions, -other.positions)
    assert np.array_equal(one.velocities, -other.velocities)
    assert np.array_equal(one.drift.value, -other.drift.value)
