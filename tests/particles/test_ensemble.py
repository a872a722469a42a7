"""simulate(): reproducible, within known laws, clear about bad input."""

from typing import Any

import numpy as np
import pytest
from scipy import stats
from sigmas import check, mean

from particles import BoltzmannGrad, HardDisks, HardSpheres, Poisson, PoissonSpheres, simulate

TIMES = [0.0, 1.0, 30.0, 1000.0]


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_initial_state_is_the_one_asked_for(dimension: int) -> None:
    d = dimension
    for initial, second, fourth, mixed in (
        ("gaussian", 1.0, 3.0, 1.0),
        ("monoenergetic", 1 / d, 3 / (d * (d + 2)), 1 / (d * (d + 2))),
    ):
        run = simulate(
            BoltzmannGrad(0.04, dimension=d), 0.5, initial, times=[0.0], media=100, tracers=1000,
            seed=2, observables=["velocities", "speed_histogram", "velocity_component_histogram"],
        )  # fmt: skip
        v = run.velocities[0]
        assert v.shape == (100_000, d)
        for k in range(d):
            one, other = v[:, k], v[:, k - 1]
            for values, expected in (
                (one, 0.0), (one**2, second), (one**4, fourth), (one * other, 0.0),
                (one**2 * other**2, mixed),
            ):  # fmt: skip
                check(*mean(values), expected)
        if initial == "monoenergetic":
            np.testing.assert_allclose(np.linalg.norm(v, axis=1), 1.0, rtol=1e-14)
            continue
        check(run.thermal_speed.value, run.thermal_speed.error, np.sqrt(d))
        check(run.a2.value, run.a2.error, 0.0)
        # Bin by bin where 100 counts are expected.
        for histogram, law in (
            (run.speed_histogram, stats.chi(d)),
            (run.velocity_component_histogram, stats.halfnorm),
        ):
            p = np.diff(law.cdf(histogram.edges))
            seen = histogram.probability.value[0]
            busy = p * len(v) > 100
            sigma = np.sqrt(p * (1 - p) / len(v))
            assert busy.sum() > 50
            assert np.all(abs(seen - p)[busy] < 4.5 * sigma[busy])
            total = seen.sum() + histogram.below[0] + histogram.above[0]
            assert total == pytest.approx(1, abs=1e-12)


def test_errors_come_from_configurations() -> None:
    # The spread of the estimate over independent runs is what the stated error must predict.
    # 40 runs: the ratio of the two has a relative standard error of about 1/sqrt(80) = 0.11.
    runs = [
        simulate(
            Poisson(0.2, 2000), 0.7, times=[5.0, 50.0], media=30, tracers=30, seed=s, workers=1,
            observables=["displacement_histogram"],
        )
        for s in range(40)
    ]  # fmt: skip
    for name in ("thermal_speed", "a2", "msd", "kurtosis", "collisions"):
        values = np.array([getattr(r, name).value for r in runs])
        stated = np.array([getattr(r, name).error for r in runs])
        ratio = np.sqrt((stated**2).mean(axis=0)) / values.std(axis=0, ddof=1)
        assert np.all((ratio > 0.6) & (ratio < 1.6)), (name, ratio)
    histograms = [r.displacement_histogram.probability for r in runs]
    values = np.array([h.value for h in histograms])
    stated = np.array([h.error for h in histograms])
    busy = values.mean(axis=0) > 0.02
    ratio = np.sqrt((stated**2).mean(axis=0))[busy] / values.std(axis=0, ddof=1)[busy]
    assert 0.85 < np.median(ratio) < 1.15


def test_a_collision_cap_says_whom_it_leaves_out() -> None:
    ensemble = simulate(
        HardDisks(0.04, 4000), 0.9, times=TIMES, media=5, tracers=50, max_collisions=9
    )
    assert ensemble.samples[0] == 250
    assert ensemble.samples[-1] < 250
    assert np.array_equal(ensemble.samples + ensemble.missing, [250] * 4)
    statuses = ensemble.statuses
    assert statuses.finished == ensemble.samples[-1]
    assert statuses.collision_cap == ensemble.missing[-1]


@pytest.mark.parametrize("kind", [Poisson, HardSpheres, PoissonSpheres])
def test_diameter_only_sets_the_unit_of_length(kind: Any) -> None:
    one = kind(0.1, count=500)
    twice = kind(0.1 / 2**one.dimension, count=500, diameter=2.0)
    names = ["positions", "displacement_histogram", "finals"]
    a = simulate(one, 0.5, times=[1, 20], media=3, tracers=9, observables=names)
    b = simulate(twice, 0.5, times=[2, 40], media=3, tracers=9, observables=names)
    np.testing.assert_allclose(b.positions, 2 * a.positions, rtol=1e-12)
    np.testing.assert_allclose(b.msd.value, 4 * a.msd.value, rtol=1e-12)
    np.testing.assert_allclose(b.thermal_speed.value, a.thermal_speed.value, rtol=1e-12)
    np.testing.assert_allclose(b.mean_free_path.value, 2 * a.mean_free_path.value, rtol=1e-12)
