"""Chi-squares from groups, fits with their covariance, and bins: against laws known by heart."""

import numpy as np
import pytest

from kinetics import Scene, solve
from kinetics.crosscheck import compare
from kinetics.crosscheck.comparison.data.columns import Rows
from kinetics.crosscheck.comparison.data.ensemble_files import from_ensemble
from kinetics.crosscheck.comparison.data_and_theory import (
    LEAST_EXPECTED,
    compare_histogram,
    side_by_side,
)
from kinetics.crosscheck.comparison.fit import Components, Unknown, choose_components, fit
from kinetics.crosscheck.comparison.judging import judge_p_value
from kinetics.crosscheck.comparison.reduction import Reduction
from kinetics.crosscheck.comparison.sample import Sample
from kinetics.crosscheck.comparison.statistics import (
    covariance,
    effective_groups,
    errors,
    hotelling,
    most_freedom,
    pearson,
    spread_out,
    whitening,
)
from kinetics.crosscheck.comparison.theory import (
    DISPLACEMENT,
    SPEED,
    Expectation,
    SampledStart,
    bin_shares,
)
from kinetics.errors import InputError
from particles import BoltzmannGrad, HardDisks, simulate


def replicates_of(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean over groups (p,), and with each left out (G, p)."""
    n = len(values)
    total = values.sum(axis=0)
    return total / n, (total - values) / (n - 1)


def correlated(rng: np.random.Generator, groups: int) -> np.ndarray:
    """Five times of the same tracers: a walk, so that neighbours are strongly correlated."""
    return np.cumsum(rng.normal(size=(groups, 5)), axis=1) + 3.0


def test_errors_are_those_of_a_mean() -> None:
    values = correlated(np.random.default_rng(1), 50)
    mean, left_out = replicates_of(values)
    expected = np.cov(values.T) / 50
    np.testing.assert_allclose(covariance(left_out), expected, rtol=1e-12)
    np.testing.assert_allclose(errors(left_out), np.sqrt(np.diagonal(expected)), rtol=1e-12)
    white = whitening(covariance(left_out))
    np.testing.assert_allclose(white @ expected @ white.T, np.eye(5), atol=1e-9)
    assert mean.shape == (5,)


@pytest.mark.parametrize("groups", [8, 30, 200])
def test_p_values_of_correlated_times_are_uniform(groups: int) -> None:
    """Also where the covariance is from few groups, for which chi-square's own law is far off."""
    from scipy.stats import chi2, kstest

    rng = np.random.default_rng(groups)
    found, naive = [], []
    for _ in range(1500):
        mean, left_out = replicates_of(correlated(rng, groups))
        result = hotelling(mean - 3.0, left_out - 3.0)
        assert result is not None
        assert (result.freedom, result.groups) == (5, groups)
        found.append(result.p_value)
        z = (mean - 3.0) / errors(left_out)
        naive.append(chi2.sf(z @ z, 5))
    # effective_groups costs some of the groups where there are few: careful, never bold
    assert np.mean(np.array(found) < 0.05) < 0.065
    if groups > 8:
        assert kstest(found, "uniform").pvalue > 1e-3
    # what ignores the correlations, and that the errors are estimates, is wrong
    assert kstest(naive, "uniform").pvalue < 1e-6


@pytest.mark.parametrize("groups", [8, 16, 32])
@pytest.mark.parametrize("freedom", [1, 3, 5])
def test_hotelling_has_the_f_distribution_of_its_groups(groups: int, freedom: int) -> None:
    """Exactly, against T^2 written out: columns of +-1 have no excess kurtosis, so that every group
    counts in full (effective_groups)."""
    from scipy.linalg import hadamard
    from scipy.stats import chi2, f

    values = hadamard(groups)[:, 1 : freedom + 1] * np.arange(1.0, freedom + 1) + 0.1
    mean, left_out = replicates_of(values)
    np.testing.assert_allclose(effective_groups(left_out), groups, rtol=1e-12)
    t2 = groups * mean @ np.linalg.solve(np.atleast_2d(np.cov(values.T)), mean)
    p = f.sf(t2 * (groups - freedom) / (freedom * (groups - 1)), freedom, groups - freedom)
    found = hotelling(mean, left_out)
    assert found is not None
    assert found.statistic == pytest.approx(t2, rel=1e-12)
    # the chi-square that is reported has this p-value at these degrees of freedom
    assert found.value == pytest.approx(chi2.isf(p, freedom), rel=1e-9)
    assert found.p_value == pytest.approx(p, rel=1e-10)


def test_components_that_say_the_same_are_counted_once() -> None:
    mean, left_out = replicates_of(correlated(np.random.default_rng(2), 60))
    twice = hotelling(np.tile(mean - 3, 2), np.tile(left_out - 3, (1, 2)))
    once = hotelling(mean - 3, left_out - 3)
    assert once is not None
    assert twice is not None
    assert twice.freedom == 5
    assert twice.value == pytest.approx(once.value, rel=1e-6)
    assert hotelling(np.zeros(1), np.zeros((10, 1))) is None


def test_few_far_out_groups_count_for_few() -> None:
    rng = np.random.default_rng(3)
    _, gaussian = replicates_of(rng.normal(size=(400, 1)))
    heavy = rng.normal(size=(400, 1))
    heavy[7] = 60.0
    assert effective_groups(gaussian)[0] > 300
    assert effective_groups(replicates_of(heavy)[1])[0] < 10
    np.testing.assert_array_equal(effective_groups(np.ones((10, 2))), [10, 10])


def test_freedom_and_times_are_chosen() -> None:
    assert [most_freedom(g) for g in (2, 5, 9, 100)] == [1, 1, 2, 24]
    assert spread_out(5, 9) == [0, 1, 2, 3, 4]
    assert spread_out(10, 4) == [0, 3, 6, 9]
    assert spread_out(10, 1) == [9]
    usable = np.ones((2, 10), bool)
    usable[0, :3] = False
    assert choose_components(usable, 30, 2).tolist() == [3, 6, 9, 10, 14, 19]  # 7 allowed, 3 each
    assert choose_components(usable & False, 30, 2).size == 0


def test_pearson_against_scipy() -> None:
    from scipy.stats import chisquare

    counts, expected = np.array([18.0, 55, 27]), np.array([20.0, 50, 30])
    found = pearson(counts, expected)
    assert found is not None
    reference = chisquare(counts, expected)
    assert found.value == pytest.approx(reference.statistic)
    assert found.p_value == pytest.approx(reference.pvalue)
    halved = pearson(counts, expected, design_effect=2.0)
    assert halved is not None
    assert halved.value == pytest.approx(found.value / 2)
    assert pearson(counts[:1], expected[:1]) is None


def test_a_p_value_becomes_a_verdict() -> None:
    assert judge_p_value(0.5, 1)[1] == "agrees"
    assert judge_p_value(1e-3, 1)[1] == "unclear"
    assert judge_p_value(1e-3, 20)[1] == "agrees"
    assert judge_p_value(1e-6, 1)[1] == "differs"
    assert judge_p_value(0.0, 10)[0] > 36
    assert judge_p_value(0.9, 10)[0] == 0.0


def test_a_fit_finds_a_line_and_its_errors() -> None:
    """Against generalised least squares written out; and chi-square loses two degrees."""
    rng = np.random.default_rng(5)
    x = np.arange(5.0)
    values = correlated(rng, 80) - 3.0 + 0.7 * x - 1.3
    data = replicates_of(values)

    def line(at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        theory = at[0] + at[1] * x
        return theory, theory

    unknowns = [Unknown("a", -9, 9), Unknown("b", -9, 9)]
    every = Components(np.arange(5), np.arange(5), logarithms=False)
    found = fit(unknowns, line, data, every, [[0, 0], [5, 5]])
    assert found is not None
    design = np.stack([np.ones(5), x], axis=1)
    weight = np.linalg.inv(np.cov(values.T) / 80)
    spread = np.linalg.inv(design.T @ weight @ design)
    np.testing.assert_allclose(found.values, spread @ design.T @ weight @ data[0], atol=1e-6)
    # 80 groups, 5 components, 2 parameters: what weights from an estimated covariance cost
    cost = 79 / 76 * 78 / 75
    np.testing.assert_allclose(found.errors, np.sqrt(np.diagonal(spread) * cost), rtol=1e-6)
    assert found.chi_square is not None
    assert found.chi_square.freedom == 3
    left = data[0] - design @ found.values
    assert found.chi_square.statistic == pytest.approx(left @ weight @ left, rel=1e-4)
    # a group left out moves the parameters as a fit to the others would
    moved = found.moved(data[1])
    again = fit(unknowns, line, (data[1][3], data[1]), every, [[0, 0]])
    assert again is not None
    np.testing.assert_allclose(moved[3], again.values - found.values, atol=2e-5)


def test_bins_hold_enough_and_shares_add_up() -> None:
    run = simulate(
        BoltzmannGrad(0.04), restitution=0.6, times=[5.0, 100.0], media=20, tracers=100,
        seed=1, workers=1, observables=("positions", "velocities", "speed_histogram"),
    )  # fmt: skip
    solution = solve(Scene(0.6, times=[5.0, 100.0], outputs=("speed_density",)), rtol=1e-6)
    sample = from_ensemble(run)
    for k in range(2):
        found = compare_histogram(sample, solution, SPEED, k, k)
        assert found is not None
        assert found.edges[0] == 0
        assert np.isinf(found.edges[-1])
        assert np.all(found.theory * 2000 >= LEAST_EXPECTED)
        assert found.share.sum() == pytest.approx(1.0)
        assert found.theory.sum() == pytest.approx(1.0)
        speeds = np.hypot(*run.velocities[k].T)
        counts, _ = np.histogram(speeds, found.edges)
        np.testing.assert_array_equal(counts, np.rint(found.share * 2000))
        # the tails are not swallowed by wide bins
        assert found.theory[0] < 0.06
        assert found.theory[-1] < 0.06
    # a run without raw velocities has the histogram's totals alone
    totals = from_ensemble(
        simulate(
            HardDisks(0.04, 400), restitution=0.6, times=[5.0, 100.0], media=20, tracers=100,
            seed=1, workers=1, observables=("speed_histogram",),
        )
    )  # fmt: skip
    assert totals.speeds is not None
    assert totals.speeds.by_group is None
    found = compare_histogram(totals, solution, SPEED, 1, 1)
    assert found is not None
    assert found.chi_square is not None
    assert found.chi_square.freedom == found.share.size - 1


@pytest.mark.parametrize("initial", ["gaussian", "monoenergetic"])
@pytest.mark.parametrize("restitution", [0.0, 0.7])
def test_shares_of_bins_are_integrals_of_the_density(initial: str, restitution: float) -> None:
    scene = Scene(restitution, initial=initial, times=[20.0], outputs=("speed_density",))
    solution = solve(scene, rtol=1e-6)
    edges = np.geomspace(0.05, 2.5, 200)
    shares = bin_shares(solution, SPEED, 0, edges)
    assert shares.sum() == pytest.approx(1.0, abs=1e-6)
    for low, high in ((0, 40), (90, 130)):
        v = np.linspace(edges[low], edges[high], 40_001)
        density = solution.speed_density(v)[0]
        integral = np.sum((density[1:] + density[:-1]) / 2) * (v[1] - v[0])
        # the monoenergetic density has edges of its own: trapezoid and Gauss differ by 1e-4 there
        assert shares[low + 1 : high + 1].sum() == pytest.approx(integral, rel=1e-3, abs=1e-5)
    if initial == "monoenergetic":
        k = int(np.searchsorted(edges, 1.0))
        assert shares[k] >= solution.uncollided[0]


def test_a_theory_from_the_data_s_own_start_is_exact_at_time_0() -> None:
    """And later it is what the solver gives for those samples."""
    from kinetics import SpeedSamples

    rng = np.random.default_rng(4)
    speeds = rng.gamma(4.0, 0.3, 200)
    reduction = Reduction("tracer")
    zeros = np.zeros(200)
    times = (0.0, 1e-9, 5.0, 50.0)
    for time in times:
        reduction.add(Rows(np.full(200, time), zeros + time, zeros, speeds, zeros, np.arange(200)))
    sample = reduction.sample(("x",))
    names = ("thermal_speed", "a2", "msd", "kurtosis")
    expectation = Expectation(sample, names)
    values, moved = expectation.theory(0.7, 12.5, SampledStart(sample.start))
    np.testing.assert_allclose(values[:2, 0], expectation.values[:2, 0], rtol=1e-12)
    scene = Scene(0.7, 0.04, initial=SpeedSamples(speeds), times=times, outputs=names)
    solution = solve(scene)
    for k, name in enumerate(names):
        np.testing.assert_allclose(values[k, 1:], getattr(solution, name)[1:], rtol=3e-4)
        # at t = 1e-9 no tracer has collided: what is left is the theory's own error
        assert values[k, 1] == pytest.approx(getattr(solution, name)[1], rel=1e-6)
    without = Scene(
        0.7, 0.04, initial=SpeedSamples(np.delete(speeds, 17)), times=times, outputs=names
    )
    left_out = solve(without)
    np.testing.assert_allclose(
        moved[17, 0, 1:] - values[0, 1:],
        left_out.thermal_speed[1:] - solution.thermal_speed[1:],
        rtol=0.03,
        atol=2e-5,  # a tracer is left out at the speed of its bin, 1 % wide
    )


def sample_at(*times: float) -> Sample:
    reduction = Reduction("row")
    rng = np.random.default_rng(0)
    for time in times:
        reduction.add(Rows(np.full(50, time), *rng.normal(size=(4, 50))))
    return reduction.sample(("x",))


def test_a_solution_that_has_nothing_in_common_is_refused() -> None:
    sample = sample_at(1.0, 2.0)
    with pytest.raises(InputError, match="none in common"):
        side_by_side(solve(Scene(0.7, times=[3.0])), sample)
    with pytest.raises(InputError, match="needed is at least one of"):
        side_by_side(solve(Scene(0.7, times=[1.0], outputs=("collisions",))), sample)
    # what is in common is compared, and no more
    part = side_by_side(solve(Scene(0.7, times=[2.0, 3.0], outputs=("msd", "collisions"))), sample)
    assert part.names == ("msd",)
    np.testing.assert_array_equal(part.sample.times, [2.0])


def test_one_group_has_no_error() -> None:
    run = simulate(
        HardDisks(0.04, 400), restitution=0.7, times=[1.0], media=1, tracers=20, seed=1, workers=1
    )
    with pytest.raises(InputError, match="standard errors need at least two"):
        from_ensemble(run)


class Flights:
    """Stands for a solution in a medium so dilute that no tracer collides: r = v t."""

    def __init__(self, scene: Scene, stretch: float = 1.0) -> None:
        self.scene, self.times, self._stretch = scene, np.asarray(scene.times), stretch

    def position_density(self, r: np.ndarray) -> np.ndarray:
        raise NotImplementedError  # only shares are asked for

    def position_fraction(self, edges: np.ndarray) -> np.ndarray:
        size = self._stretch * self.times[:, None]
        return np.diff(-np.exp(-((edges / size) ** 2) / 2))


def test_displacements_are_held_against_their_density() -> None:
    times = [2.0, 20.0]
    run = simulate(
        BoltzmannGrad(1e-9), restitution=0.6, times=times, media=20, tracers=200, seed=3,
        workers=1, observables=("positions", "velocities"),
    )  # fmt: skip
    scene = Scene(0.6, 1e-9, times=times, outputs=("position_density",))
    solution = solve(Scene(0.6, 1e-9, times=times, outputs=("msd",)))
    right, wrong = (
        compare(solution, run, densities={DISPLACEMENT: Flights(scene, stretch)})  # type: ignore[dict-item]
        for stretch in (1.0, 1.1)
    )
    for time in times:
        assert right.p_value(DISPLACEMENT, time) > 1e-3
        assert wrong.p_value(DISPLACEMENT, time) < 1e-6
    assert "position-density" in right.figures
    assert any(row.low is not None for row in right.observable(DISPLACEMENT))
