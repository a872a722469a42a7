"""Spheres without recollisions: where tracers begin, what is recorded, the late decay."""

import numpy as np
import pytest

from particles import OBSERVABLES, BoltzmannGrad, simulate

MEDIUM = BoltzmannGrad(0.04, dimension=3)


def check(values: np.ndarray, expected: float, sigmas: float = 4) -> None:
    """The mean of independent values is the expected one within so many standard errors."""
    error = values.std(ddof=1) / np.sqrt(values.size)
    assert abs(values.mean() - expected) < sigmas * error, (values.mean(), expected, error)


def test_gaussian_starts() -> None:
    run = simulate(MEDIUM, 0.5, times=[0.0], media=20, tracers=5000, observables=["velocities"])
    v = run.velocities[0]
    for k in range(3):
        check(v[:, k], 0.0)
        check(v[:, k] ** 2, 1.0)
        check(v[:, k] ** 4, 3.0)
        check(v[:, k] * v[:, k - 1], 0.0)
        check(v[:, k] ** 2 * v[:, k - 1] ** 2, 1.0)
    assert abs(run.thermal_speed.value[0] - np.sqrt(3)) < 4 * run.thermal_speed.error[0]
    assert abs(run.a2.value[0]) < 4 * run.a2.error[0]


def test_monoenergetic_starts_are_uniform_on_the_sphere() -> None:
    run = simulate(
        MEDIUM, 0.5, "monoenergetic", [0.0], media=20, tracers=5000, observables=["velocities"]
    )
    v = run.velocities[0]
    np.testing.assert_allclose(np.linalg.norm(v, axis=1), 1.0, rtol=1e-14)
    for k in range(3):  # each component is uniform on [-1, 1]
        check(v[:, k], 0.0)
        for p in (2, 4, 8):
            check(v[:, k] ** p, 1 / (p + 1))
        check(v[:, k] ** 2 * v[:, k - 1] ** 2, 1 / 15)


def test_records_are_those_of_the_raw_data() -> None:
    given = np.random.default_rng(4).normal(size=(3, 50, 3))
    times = [0.0, 2.0, 60.0]
    medium = BoltzmannGrad(0.01, diameter=2.0, dimension=3)
    run = simulate(medium, 0.6, given, times, media=3, tracers=50, observables=OBSERVABLES)
    r, v = run.positions, run.velocities
    assert r.shape == v.shape == (3, 150, 3)
    np.testing.assert_allclose(v[0], given.reshape(150, 3), rtol=1e-14)
    r2, v2 = (r**2).sum(axis=2), (v**2).sum(axis=2)
    close = dict(rtol=1e-12)
    np.testing.assert_allclose(run.msd.value, r2.mean(axis=1), **close)
    np.testing.assert_allclose(run.thermal_speed.value**2, v2.mean(axis=1), **close)
    kurtosis = (r2**2).mean(axis=1)[1:] / r2.mean(axis=1)[1:] ** 2
    np.testing.assert_allclose(run.kurtosis.value[1:], kurtosis, **close)
    a2 = 0.6 * (v2**2).mean(axis=1) / v2.mean(axis=1) ** 2 - 1
    np.testing.assert_allclose(run.a2.value, a2, rtol=1e-11)
    correlation = (v * v[0]).sum(axis=2).mean(axis=1)
    np.testing.assert_allclose(run.velocity_autocorrelation.value, correlation, **close)
    for histogram, values in (
        (run.speed_histogram, np.sqrt(v2)),
        (run.velocity_component_histogram, abs(v[:, :, 0])),
        (run.displacement_histogram, np.sqrt(r2)),
    ):
        for k in (1, 2):
            counts = np.histogram(values[k], histogram.edges)[0]
            np.testing.assert_allclose(histogram.probability.value[k], counts / 150, atol=1e-14)
    # The last flight ends at the last time.
    ln_v, ln_t, x, y, _, z = run.finals.T
    np.testing.assert_allclose(np.stack((x, y, z), axis=1), r[-1], rtol=1e-10, atol=1e-10)
    np.testing.assert_allclose(np.exp(2 * ln_v), v2[-1], rtol=1e-12)
    np.testing.assert_allclose(np.exp(ln_t), 60.0, rtol=1e-12)


@pytest.mark.parametrize(
    ("restitution", "h"), [(0.0, 0.81650), (0.4, 0.57859), (0.7, 0.29805), (0.9, 0.09994)]
)
def test_the_late_speed_is_that_of_the_scaling_state(restitution: float, h: float) -> None:
    # v0 = 2 l/(h t), h = 2 sqrt(kappa lambda(1)), to the five digits of h. In 50 l the start is
    # forgotten to 1e-6 or so; the standard error is about 0.3 %.
    times = np.array([1e6, 1e9])
    run = simulate(MEDIUM, restitution, times=times, media=100, tracers=500, seed=6)
    exact = 2 / (np.pi * 0.04 * h * times)
    assert np.all(run.thermal_speed.error < 0.01 * exact)
    assert np.all(abs(run.thermal_speed.value - exact) < 4 * run.thermal_speed.error)
