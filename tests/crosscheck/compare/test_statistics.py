"""Tests of vectors, the scatter of simulated tracers, and the fit, where the truth is known."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy import stats

from kinetics.crosscheck.compare.fit import fit
from kinetics.crosscheck.compare.measured import Layout, Measured
from kinetics.crosscheck.compare.observables import Shape, averages_of, shaped_difference
from kinetics.crosscheck.compare.parameters import free_parameter
from kinetics.crosscheck.compare.point import Point
from kinetics.crosscheck.compare.pool import Pool
from kinetics.crosscheck.compare.residuals import Influence, Residuals
from kinetics.crosscheck.compare.starts import gaussian_p_value
from kinetics.crosscheck.compare.statistics import (
    jackknife_covariance,
    whitening,
)
from kinetics.crosscheck.compare.statistics import (
    test_by_groups as by_groups,
)
from kinetics.crosscheck.compare.statistics import (
    test_by_simulation as by_simulation,
)
from kinetics.crosscheck.compare.theory import Theory
from kinetics.crosscheck.data.sample import Law, Sample, effective_groups, errors

TIMES = np.array([0.0, 3.0, 10.0, 30.0, 100.0])
POINT = Point(restitution=0.7, path=12.5, start="gaussian")


def left_out(groups: Any) -> Any:
    """Means of the groups (n, p) with each left out in turn."""
    return (groups.sum(axis=0) - groups) / (len(groups) - 1)


@pytest.fixture(scope="module")
def groups() -> Any:
    """Gaussian groups of three correlated numbers."""
    mixing = np.array([[1.0, 0.0, 0.0], [0.9, 0.3, 0.0], [0.1, 0.2, 2.0]])
    return np.random.default_rng(3).normal(size=(60, 3)) @ mixing.T


@pytest.fixture(scope="module")
def pool() -> Pool:
    return Pool(Layout(averages_of(Law()), TIMES, Law()), POINT)


def test_errors_are_those_of_the_mean(groups: Any) -> None:
    replicates = left_out(groups)
    np.testing.assert_allclose(errors(replicates), stats.sem(groups, axis=0))
    np.testing.assert_allclose(jackknife_covariance(replicates), np.cov(groups.T) / len(groups))


def test_whitened_numbers_have_unit_covariance(groups: Any) -> None:
    covariance = np.cov(groups.T)
    axes = whitening(covariance)
    np.testing.assert_allclose(axes @ covariance @ axes.T, np.eye(3), atol=1e-9)


def test_a_component_that_is_the_same_as_others_costs_no_freedom(groups: Any) -> None:
    twice = np.concatenate([groups, groups[:, :1] + groups[:, 1:2]], axis=1)
    assert len(whitening(np.cov(twice.T))) == 3


@pytest.mark.parametrize("shift", [0.0, 1.0, 2.5, 3.5])
def test_simulated_gaussian_scatter_gives_the_chi_square_distribution(shift: float) -> None:
    """100,000 draws know a p-value of 0.05 to 1.4 %; beyond, an exponential tail is near."""
    draws = np.random.default_rng(5).normal(size=(100_000, 4))
    white = np.array([shift, 0.3, -0.2, 0.5])
    test = by_simulation(white, draws)
    expected = stats.chi2.sf(white @ white, 4)
    assert test.freedom == 4
    assert test.statistic == pytest.approx(white @ white)
    assert test.p_value == pytest.approx(expected, rel=0.05 if expected > 0.05 else 0.25)
    assert stats.chi2.sf(test.value, 4) == pytest.approx(test.p_value, rel=1e-6)


def test_a_tail_beyond_all_simulated_sets_is_not_underestimated() -> None:
    draws = np.random.default_rng(5).normal(size=(1000, 4))
    p_value = by_simulation(np.array([8.0, 0.0, 0.0, 0.0]), draws).p_value
    assert 0.1 * stats.chi2.sf(64.0, 4) < p_value < 1e-8


def test_a_test_by_groups_has_its_level_and_sees_what_differs() -> None:
    """Of 1,000 sets of 20 groups 5 % are below 0.05, within 4 sigma (2.8 %)."""
    random = np.random.default_rng(6)
    no_error = np.zeros((4, 4))
    p_values = []
    for _ in range(1000):
        sample = random.normal(size=(20, 4)) @ np.diag([1.0, 1.0, 2.0, 0.5])
        p_values.append(by_groups(sample.mean(axis=0), left_out(sample), no_error).p_value)
    assert np.mean(np.array(p_values) < 0.05) == pytest.approx(0.05, abs=0.028)
    shifted = random.normal(size=(20, 4)) + 1.5
    assert by_groups(shifted.mean(axis=0), left_out(shifted), no_error).p_value < 1e-4


def test_an_error_of_the_theory_is_added_to_that_of_groups() -> None:
    sample = np.random.default_rng(2).normal(size=(400, 3))
    difference = np.array([1.0, 0.0, 0.0])
    own = np.diag([0.5, 0.0, 0.0])
    without = by_groups(difference, left_out(sample), np.zeros((3, 3)))
    with_error = by_groups(difference, left_out(sample), own)
    assert without.p_value < 1e-10
    assert with_error.p_value > 0.05


def test_long_tails_count_as_fewer_groups() -> None:
    random = np.random.default_rng(1)
    normal = random.normal(size=4000)
    long = random.standard_t(5, size=4000)
    assert effective_groups(normal[:, None])[0] == pytest.approx(4000, rel=0.1)
    excess = stats.kurtosis(long)
    assert effective_groups(long[:, None])[0] == pytest.approx(1 + 2 * 3999 / (2 + excess))


def test_differences_are_those_of_functions_whose_errors_stay() -> None:
    theory = np.array([0.5])
    difference = np.array([0.5])
    plain = shaped_difference(Shape.PLAIN, theory, difference)
    logarithm = shaped_difference(Shape.LOGARITHM, theory, difference)
    cube = shaped_difference(Shape.INVERSE_CUBE, theory, difference, offset=1.0)
    assert plain[0] == 0.5
    assert logarithm[0] == pytest.approx(0.5 * np.log(2.0))
    assert cube[0] == pytest.approx(1.5 / 3 * (1 - (1.5 / 2.0) ** 3))


@pytest.mark.parametrize("dimension", [2, 3])
def test_gaussian_velocities_have_uniform_p_values(dimension: int) -> None:
    """Kolmogorov-Smirnov over 300 sets of 5,000 tracers; speeds of one half have none."""
    random = np.random.default_rng(4)
    law = Law(dimension=dimension)
    p_values = []
    for _ in range(300):
        square = np.sum(random.normal(size=(5000, dimension)) ** 2, axis=1)
        sums = np.array([5000.0, square.sum(), (square**2).sum()])
        p_values.append(gaussian_p_value(sums, law))
    assert stats.kstest(p_values, "uniform").pvalue > 1e-3
    assert gaussian_p_value(sums * [1.0, 0.5, 0.25], law) < 1e-10


def test_simulated_tracers_scatter_as_the_start_says(pool: Pool) -> None:
    """At time 0 the relative variance of v^2 is 1 and that of v^4 is 5 in the plane; 5 sigma."""
    first = [pool.layout.indices_of(name)[0] for name in ("thermal_speed", "a2")]
    variances = np.diagonal(pool.covariance)[first]
    assert variances[0] == pytest.approx(2.0 / 4.0, rel=5 * np.sqrt(8 / pool.n_tracers))
    assert variances[1] == pytest.approx(1.0, rel=0.4)


def test_simulated_tracers_have_the_means_of_the_theory(pool: Pool) -> None:
    """v0 and <r^2> within five standard errors."""
    theory = Theory(pool.layout).values(POINT)
    chosen = pool.layout.is_of("thermal_speed", "msd") & (pool.layout.time > 0.0)
    error = np.sqrt(np.diagonal(pool.covariance) / pool.n_tracers)
    sigmas = (pool.values - theory)[chosen] / error[chosen]
    assert np.all(np.abs(sigmas) < 5.0)


def test_drawn_means_scatter_as_the_covariance_says(pool: Pool) -> None:
    """1,000 draws know a standard deviation to 2.2 %; five of these."""
    n = 2000
    chosen = pool.layout.is_of("thermal_speed", "msd") & (pool.layout.time > 0.0)
    expected = np.sqrt(np.diagonal(pool.covariance) / n)[chosen]
    np.testing.assert_allclose(pool.draws(n).std(axis=0)[chosen], expected, rtol=0.12)


def exact_sample(point: Point) -> Sample:
    """Groups whose mean is the theory of a point, to rounding."""
    layout = Layout(("thermal_speed", "msd"), TIMES, Law())
    values = Theory(layout).values(point).reshape(2, -1)
    scale = 1.0 + 0.1 * np.random.default_rng(7).normal(size=(40, 2))
    scale = scale - scale.mean(axis=0) + 1.0
    sums = np.zeros((40, TIMES.size, 5))
    sums[..., 0] = 100.0
    sums[..., 1] = 100.0 * values[0] ** 2 * scale[:, :1]
    sums[..., 2] = 2.0 * sums[..., 1] ** 2 / 100.0
    sums[..., 3] = 100.0 * values[1] * scale[:, 1:]
    sums[..., 4] = 2.0 * sums[..., 3] ** 2 / 100.0
    return Sample(("made",), TIMES, sums, np.zeros(TIMES.size, int), "tracer")


@pytest.mark.parametrize("medium", ["dilute", "hard disks"])
def test_a_fit_to_the_theory_itself_finds_its_numbers(medium: str) -> None:
    truth = Point(restitution=0.62, path=9.0, start="gaussian", scatterers=medium)
    measured = Measured.of(exact_sample(truth), ("thermal_speed", "msd"))
    told = POINT.with_values(scatterers=medium)
    free = [free_parameter(name, told, measured) for name in ("restitution", "path")]
    fitted = fit(measured, told, free, [[0.8, np.log(20.0)]])
    assert fitted is not None
    assert fitted.point.restitution == pytest.approx(0.62, abs=1e-5)
    assert fitted.point.path == pytest.approx(9.0, rel=1e-5)


def test_an_error_of_the_theory_widens_what_is_fitted() -> None:
    """Among hard disks the errors are those of the data and of the theory together."""
    truth = Point(restitution=0.62, path=9.0, start="gaussian", scatterers="hard disks")
    measured = Measured.of(exact_sample(truth), ("thermal_speed", "msd"))
    errors_of = {}
    for medium in ("dilute", "hard disks"):
        told = truth.with_values(scatterers=medium)
        free = [free_parameter("path", told, measured)]
        fitted = fit(measured, told, free, [[np.log(9.0)]])
        assert fitted is not None
        errors_of[medium] = fitted.value("path")[1] / fitted.point.path
    assert errors_of["hard disks"] > errors_of["dilute"]


def test_a_fit_to_all_averages_leaves_no_error_of_the_theory() -> None:
    """Where the theory follows the data, so does its error."""
    point = POINT.with_values(scatterers="hard disks")
    measured = Measured.of(exact_sample(point), ("thermal_speed", "msd"))
    theory = Theory(measured.layout)
    size = measured.layout.size
    follows = Influence(np.arange(size), np.eye(size))
    held = Residuals.at(measured, theory, point, None)
    fitted = Residuals.at(measured, theory, point, None, follows)
    assert np.any(held.error > 0.0)
    np.testing.assert_allclose(fitted.error, 0.0, atol=1e-12)


def test_means_with_gaps_scatter_more_and_together_less() -> None:
    """Of tracers that are there half of the time, at random: x/n has 2 V, and x_s x_t has C."""
    times = TIMES[TIMES > 0.0]
    presence = np.random.default_rng(3).random((2000, times.size)) < 0.5
    whole = Pool(Layout(("msd",), times, Law()), POINT).covariance
    gaps = Pool(Layout(("msd",), times, Law(), presence=presence), POINT).covariance
    deviations = np.sqrt(np.diag(whole))
    expected = whole + np.diag(np.diag(whole))
    difference = (gaps - expected) / np.outer(deviations, deviations)
    np.testing.assert_allclose(difference, 0.0, atol=0.3)
