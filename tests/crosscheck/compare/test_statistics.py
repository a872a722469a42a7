"""Chi-squares, their p-values against scipy and mpmath, errors, and the fit on small cases."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy import stats

from kinetics.crosscheck.compare.fit import covariance, fit, hotelling, steadied, whitening
from kinetics.crosscheck.compare.theory import Expectation, Point, averages_of, spread_of_ratio
from kinetics.crosscheck.data.sample import Law, Sample, effective_groups, errors


def left_out(data: Any) -> Any:
    """Means of the groups (G, p) with each left out in turn."""
    return (data.sum(axis=0) - data) / (len(data) - 1)


def expectation(sums: Any) -> Expectation:
    """Of sums at one time, (n_groups, 1, 5)."""
    ones = np.ones(1)
    sample = Sample(("made",), ones, sums, np.zeros(1, int), "medium")
    return Expectation(sample, averages_of(Law()))


@pytest.fixture(scope="module")
def groups() -> Any:
    """Gaussian groups of three correlated numbers."""
    mixing = np.array([[1.0, 0.0, 0.0], [0.9, 0.3, 0.0], [0.1, 0.2, 2.0]])
    return np.random.default_rng(3).normal(size=(60, 3)) @ mixing.T


def test_errors_are_those_of_the_mean(groups: Any) -> None:
    replicates = left_out(groups)
    np.testing.assert_allclose(errors(replicates), stats.sem(groups, axis=0))
    np.testing.assert_allclose(covariance(replicates), np.cov(groups.T) / len(groups))


@pytest.mark.parametrize("shift", [0.0, 0.3, 1.0])
def test_hotelling_is_the_f_distribution(groups: Any, shift: float) -> None:
    """Gaussian groups, whose kurtosis is taken to be that of Gaussians where it is below."""
    n, p = groups.shape
    flat = np.clip(groups, -1.7, 1.7)  # no excess kurtosis
    difference = flat.mean(axis=0) + shift
    found = hotelling(difference, left_out(flat))
    assert found is not None
    t2 = difference @ np.linalg.solve(np.cov(flat.T) / n, difference)
    axes = whitening(covariance(left_out(flat)))
    effective = effective_groups(left_out(flat) @ axes.T).mean()
    wanted = stats.f.sf(t2 * (effective - p) / (p * (effective - 1)), p, effective - p)
    assert (found.freedom, found.groups) == (p, n)
    assert found.statistic == pytest.approx(t2)
    assert found.p_value == pytest.approx(wanted, rel=1e-9)
    assert stats.chi2.sf(found.value, p) == pytest.approx(wanted, rel=1e-9)


def test_a_component_that_is_the_same_as_another_costs_no_freedom(groups: Any) -> None:
    twice = np.concatenate([groups, groups[:, :1] + groups[:, 1:2]], axis=1)
    one, two = (hotelling(g.mean(axis=0), left_out(g)) for g in (groups, twice))
    assert one and two  # noqa: PT018
    assert (two.freedom, two.statistic) == (3, pytest.approx(one.statistic))


def test_long_tails_count_as_fewer_groups() -> None:
    rng = np.random.default_rng(1)
    normal, long = rng.normal(size=4000), rng.standard_t(5, size=4000)
    assert effective_groups(normal[:, None])[0] == pytest.approx(4000, rel=0.1)
    excess = stats.kurtosis(long)
    assert effective_groups(long[:, None])[0] == pytest.approx(1 + 2 * 3999 / (2 + excess))


def test_an_error_of_the_theory_is_added_and_counted() -> None:
    data = np.random.default_rng(2).normal(size=(400, 3))
    known, difference = np.diag([0.5, 0.0, 0.0]), np.array([1.0, 0.0, 0.0])
    plain, wide = (hotelling(difference, left_out(data), c) for c in (None, known))
    assert plain and wide  # noqa: PT018
    assert plain.statistic == pytest.approx(400, rel=0.2)
    assert wide.statistic == pytest.approx(1 / (0.5 + 1 / 400), rel=0.01)


class AllAre:
    """Six averages whose theory is the mean free path, measured by 12 groups."""

    names = ("thermal_speed", "msd")

    def __init__(self, seed: int, own: Any = None) -> None:
        data = 1.0 + 0.05 * np.random.default_rng(seed).normal(size=(12, 2, 3))
        self.sample = SimpleNamespace(groups=12, times=np.arange(1.0, 4.0))
        self.values, self.replicates = data.mean(0), left_out(data)
        self.own_covariance = lambda *_: own
        self.stabilised = lambda theory, difference: difference
        self.spread_of_a2 = lambda point: None
        self.exact = lambda point: np.zeros((2, 3), bool)

    def theory(self, point: Point) -> Any:
        return np.full((2, 3), point.path)

    def fitted(self, *free: str) -> Any:
        told, every = Point(0.7, 1.0, "gaussian"), np.ones((2, 3), bool)
        made: Any = self
        return fit(made, told, free, every, [[0.0]], parameters=3)


def test_errors_of_fitted_parameters_allow_for_weights_that_are_estimated() -> None:
    found = [AllAre(seed).fitted("path").value("path") for seed in range(400)]
    square = np.mean([((value - 1.0) ** 2, error**2) for value, error in found], axis=0)
    assert square[0] == pytest.approx(square[1], rel=0.25)


def test_an_error_of_the_theory_costs_likelihood_and_is_left_only_where_not_fitted() -> None:
    huge = [AllAre(1, size * np.eye(6)).fitted().criterion for size in (1.0, 100.0)]
    assert huge[1] - huge[0] == pytest.approx(6 * np.log(100.0), rel=0.01)
    plain, shared = (
        AllAre(1, own).fitted("path").chi_square for own in (None, np.full((6, 6), 0.01))
    )
    assert shared.statistic == pytest.approx(plain.statistic, rel=1e-3)


def test_differences_are_those_of_functions_whose_errors_stay() -> None:
    theory, data = np.array([[1.0], [0.5], [2.0], [3.0]]), np.array([[2.0], [1.0], [4.0], [6.0]])
    found = expectation(np.ones((3, 1, 5))).stabilised(theory, data - theory)[:, 0]
    cubes = [1.5 / 3 * (1 - (1.5 / 2.0) ** 3), 3.0 / 3 * (1 - 0.5**3)]
    np.testing.assert_allclose(found, [np.log(2), cubes[0], 2 * np.log(2), cubes[1]])


def test_a_long_tail_that_few_tracers_miss_is_no_difference() -> None:
    """Of 800 sets of 500 tracers at most 8.1 % below p = 5 %, four sigma, and the kurtosis' median
    error is right; each component is a Gaussian of random width, with the kurtosis 2 (1 + 1/5)."""
    rng, rejected, ratio, sixth = np.random.default_rng(5), np.zeros(2), [], 6 * 1.2 * 1.4
    theory = np.array([[np.sqrt(2.0)], [0.2], [2.0], [2.4]])
    of_a2 = np.array([spread_of_ratio(2.4, sixth, sixth * 4 * 1.6) / 4])
    for _ in range(800):
        v, r = 2 * rng.exponential(size=(2, 50, 10)) * rng.gamma(5.0, 0.2, size=(2, 50, 10))
        sums = np.stack([0 * v + 1, v, v**2, r, r**2], axis=-1).sum(axis=1)[:, None]
        expected = expectation(sums)
        rows = steadied(expected, theory, of_a2)
        shaped = expected.stabilised(theory, expected.values - theory)
        p = [getattr(hotelling(shaped[k], rows[:, k]), "p_value", 1.0) for k in (1, 3)]
        rejected += np.less(p, 0.05)
        ratio.append(errors(rows)[3, 0])
    assert np.all(rejected < 800 * 0.081)
    assert np.median(ratio) == pytest.approx(np.sqrt(np.mean(np.square(ratio))), rel=0.05)
