"""compare() where the truth is known: Boltzmann-Grad particles sample the equation itself."""

from functools import cache
from typing import Any

import numpy as np
import pytest

from kinetics import Scene, solve
from kinetics.crosscheck import Comparison, compare
from kinetics.crosscheck.comparison.data.columns import Rows
from kinetics.crosscheck.comparison.question import compare_sample
from kinetics.crosscheck.comparison.reduction import Reduction
from kinetics.crosscheck.comparison.result import Explanation
from kinetics.crosscheck.comparison.sample import Sample
from particles import BoltzmannGrad, HardDisks, simulate

TIMES = np.geomspace(1.0, 500.0, 8)
PAPER = 10_000
"""Tracers of each of the paper's runs."""
DENSITY = 0.04
OUTPUTS = ("thermal_speed", "a2", "msd", "kurtosis", "speed_density")


@cache
def drawn(restitution: float, initial: str = "gaussian", start: bool = False) -> Any:
    """Positions and velocities (n_times, n, 2) of the paper's number of tracers, and the times."""
    times = np.concatenate([[0.0], TIMES]) if start else TIMES
    run = simulate(
        BoltzmannGrad(DENSITY),
        restitution=restitution,
        initial=initial,  # type: ignore[arg-type]
        times=times,
        media=100,
        tracers=PAPER // 100,
        seed=17,
        workers=1,
        observables=("positions", "velocities"),
    )
    return times, run.positions, run.velocities


def sample_of(times: Any, positions: Any, velocities: Any, grouping: str = "tracer") -> Sample:
    reduction = Reduction(grouping)
    label = np.arange(positions.shape[1])
    for time, r, v in zip(times, positions, velocities, strict=True):
        reduction.add(
            Rows(np.full(label.size, time), *r.T, *v.T, tracer=label, medium=label // 100)
        )
    return reduction.sample(("made up",))


def explained(result: Comparison, name: str) -> Explanation:
    found = [item for item in result.explanations if item.name == name]
    assert found, [item.name for item in result.explanations]
    return found[0]


@pytest.mark.parametrize("restitution", [0.4, 0.7, 0.9])
def test_the_right_theory_agrees(restitution: float) -> None:
    result = compare_sample(sample_of(*drawn(restitution)), restitution, DENSITY)
    assert result.verdict == "agrees"
    assert {test.verdict for test in result.tests} == {"agrees"}
    # nothing is offered as an explanation where nothing needs one
    assert {item.outcome for item in result.explanations} <= {"noted"}
    assert result.samples == PAPER


@pytest.mark.slow
@pytest.mark.parametrize("told", [0.38, pytest.param(0.42, marks=pytest.mark.slow)])
def test_a_restitution_off_by_two_hundredths_is_seen_at_low_e(told: float) -> None:
    result = compare_sample(sample_of(*drawn(0.4)), told, DENSITY)
    assert result.verdict == "differs"


@pytest.mark.parametrize(
    ("truth", "told"),
    [
        (0.7, 0.72),
        pytest.param(0.9, 0.88, marks=pytest.mark.slow),
        pytest.param(0.7, 0.68, marks=pytest.mark.slow),
        pytest.param(0.9, 0.92, marks=pytest.mark.slow),
    ],
)
def test_a_restitution_off_by_two_hundredths_is_seen_and_named(truth: float, told: float) -> None:
    result = compare_sample(sample_of(*drawn(truth)), told, DENSITY)
    assert result.verdict == "differs"
    item = explained(result, "restitution")
    assert item.outcome == "explains"
    assert item.value is not None
    assert item.error is not None
    # 3.5 sigma: one in 2000 for each of the four
    assert abs(item.value - truth) < 3.5 * item.error
    assert item.error < 0.005
    assert "traps" not in {item.name for item in result.explanations}


@pytest.mark.parametrize("factor", [0.9, pytest.param(1.1, marks=pytest.mark.slow)])
def test_a_density_off_by_a_tenth_is_seen_and_named(factor: float) -> None:
    result = compare_sample(sample_of(*drawn(0.7)), 0.7, DENSITY * factor)
    assert result.verdict == "differs"
    item = explained(result, "free path")
    assert item.outcome == "explains"
    assert item.value is not None
    assert item.error is not None
    assert abs(item.value - 12.5) < 3.5 * item.error


def trapped(share: float, speed: float) -> Sample:
    """A share of the tracers stops, at a time of its own, where it is."""
    times, positions, velocities = (np.array(part) for part in drawn(0.7))
    rng = np.random.default_rng(5)
    who = rng.permutation(positions.shape[1])[: round(share * positions.shape[1])]
    for tracer in who:
        since = rng.integers(1, times.size)
        positions[since:, tracer] = positions[since, tracer]
        velocities[since:, tracer] *= speed
    return sample_of(times, positions, velocities)


@pytest.mark.parametrize("speed", [pytest.param(0.0, marks=pytest.mark.slow), 1e-6])
def test_one_per_cent_of_trapped_tracers_is_seen_and_counted(speed: float) -> None:
    result = compare_sample(trapped(0.01, speed), 0.7, DENSITY)
    assert result.verdict == "differs"
    item = explained(result, "traps")
    assert item.outcome == "found"
    assert item.value is not None
    assert item.value == pytest.approx(0.01, abs=2e-4)  # the 100 that were stopped


@pytest.mark.slow
@pytest.mark.parametrize(
    ("truth", "told"),
    [
        ("gaussian", "monoenergetic"),
        pytest.param("monoenergetic", "gaussian", marks=pytest.mark.slow),
    ],
)
def test_a_wrong_start_is_seen_and_named(truth: str, told: str) -> None:
    result = compare_sample(sample_of(*drawn(0.7, truth)), 0.7, DENSITY, told)
    assert result.verdict == "differs"
    assert explained(result, "initial speeds").outcome == "explains"
    assert "traps" not in {item.name for item in result.explanations}


@pytest.mark.slow
def test_the_start_is_read_where_the_data_have_it() -> None:
    times, positions, velocities = drawn(0.7, "monoenergetic", start=True)
    found = compare_sample(sample_of(times, positions, velocities), 0.7, DENSITY)
    assert found.initial == "a start with all speeds U"
    assert found.verdict == "agrees"
    wrong = compare_sample(sample_of(times, positions, velocities), 0.7, DENSITY, "gaussian")
    assert wrong.verdict == "differs"
    # the start has no spread: no chi-square holds it, but its rows do
    first = wrong.observable("thermal_speed")[0]
    assert (first.time, first.sigmas, first.verdict) == (0.0, None, "differs")
    assert explained(wrong, "initial speeds").outcome == "explains"


@pytest.mark.slow
def test_a_start_of_no_name_is_taken_from_the_data() -> None:
    """Speeds evenly spread from 0.5 to 1.5 U: the theory moves with the sample that it is from."""
    rng = np.random.default_rng(3)
    speed, angle = rng.uniform(0.5, 1.5, (100, 100)), rng.uniform(0, 2 * np.pi, (100, 100))
    start = np.stack([speed * np.cos(angle), speed * np.sin(angle)], axis=-1)
    run = simulate(
        BoltzmannGrad(DENSITY), restitution=0.6, initial=start, times=[0.0, *TIMES],
        media=100, tracers=100, seed=9, workers=1, observables=("positions", "velocities"),
    )  # fmt: skip
    sample = sample_of(run.times, run.positions, run.velocities)
    result = compare_sample(sample, 0.6, DENSITY)
    assert result.initial == "the data's own speeds at time 0"
    assert result.verdict == "agrees"
    assert {row.time for row in result.rows} == set(TIMES)  # at 0 theory and data are the same
    assert "own start" in {item.name for item in result.explanations}
    # Where few have collided the difference is known far better than the value.
    early = result.observable("thermal_speed")[0]
    told = compare(
        solve(Scene(0.6, DENSITY, times=TIMES, outputs=("thermal_speed",))), sample, explain=False
    ).observable("thermal_speed")[0]
    assert early.error < 0.6 * told.error
    assert compare_sample(sample, 0.63, DENSITY).verdict == "differs"


def test_a_collision_cap_is_named() -> None:
    run = simulate(
        BoltzmannGrad(DENSITY), restitution=0.7, times=TIMES, media=100, tracers=100,
        max_collisions=6, seed=2, workers=1,
    )  # fmt: skip
    solution = solve(Scene(0.7, DENSITY, times=TIMES, outputs=("thermal_speed", "a2", "msd")))
    result = compare(solution, run)
    assert result.verdict == "differs"
    item = explained(result, "missing tracers")
    assert item.outcome == "explains"
    assert "stopped after 6 collisions" in item.text
    complete = compare(
        solve(Scene(0.7, DENSITY, times=TIMES[:1], outputs=("thermal_speed", "a2", "msd"))), run
    )
    assert complete.verdict == "agrees"


def test_hard_disks_show_their_density() -> None:
    """A free path that is 5 % shorter is not enough: recollisions keep <r^2> below even that.

    Both follow from the density without a fitted number (test_finite_density.py).
    """
    run = simulate(
        HardDisks(DENSITY, 10_000), restitution=0.75, times=TIMES, media=100, tracers=100,
        seed=5, workers=1,
    )  # fmt: skip
    outputs = ("thermal_speed", "a2", "msd", "kurtosis")
    result = compare(solve(Scene(0.75, DENSITY, times=TIMES, outputs=outputs)), run)
    assert result.verdict == "differs"
    path = explained(result, "free path")
    assert path.outcome == "in part"  # recollisions remain
    assert path.value is not None
    assert 11.4 < path.value < 12.3
    assert "finite density" in path.text
    again = explained(result, "recollisions")
    assert again.outcome == "in part"  # the density, which is known, is the likelier cause
    assert again.value is not None
    assert -0.25 < again.value < -0.05
    assert result.groups == 100
    assert result.grouping == "medium"


@pytest.mark.slow
def test_what_is_not_told_is_found() -> None:
    sample = sample_of(*drawn(0.7))
    for told in ({}, {"restitution": 0.7}, {"number_density": DENSITY}):
        result = compare_sample(sample, **told)
        assert result.verdict == "agrees"
        for name, truth in (("restitution", 0.7), ("number_density", DENSITY)):
            parameter = result.parameters[name]
            if name in told:
                assert (parameter.value, parameter.error, parameter.source) == (truth, None, "told")
            else:
                assert parameter.error is not None
                assert abs(parameter.value - truth) < 3.5 * parameter.error
                assert parameter.error < 0.01 * truth
                assert "fitted" in parameter.source


def test_fitted_parameters_cost_degrees_of_freedom() -> None:
    """The errors of what a fit leaves are smaller than those of the data."""
    sample = sample_of(*drawn(0.7))
    told, fitted = (compare_sample(sample, 0.7, d, explain=False) for d in (DENSITY, None))
    for a, b in zip(told.observable("msd"), fitted.observable("msd"), strict=True):
        assert b.error < a.error
    assert fitted.verdict == "agrees"


def p_values(
    seeds: int, tracers: int, grouping: str, restitution: float = 0.7
) -> dict[tuple[str, float | None], list[float]]:
    times = np.array([3.0, 30.0, 300.0])
    solution = solve(Scene(restitution, DENSITY, times=times, outputs=OUTPUTS), rtol=1e-6)
    found: dict[tuple[str, float | None], list[float]] = {}
    for seed in range(seeds):
        run = simulate(
            BoltzmannGrad(DENSITY), restitution=restitution, times=times, media=50,
            tracers=tracers // 50, seed=1000 + seed, workers=1,
            observables=("positions", "velocities"),
        )  # fmt: skip
        data: Any = run
        if grouping == "medium":
            data = sample_of(times, run.positions, run.velocities, "medium")
        for test in compare(solution, data, explain=False).tests:
            found.setdefault((test.observable, test.time), []).append(test.p_value)
    return found


def check_uniform(found: dict[tuple[str, float | None], list[float]], seeds: int) -> None:
    from scipy.stats import kstest

    assert len(found) == 4 + 3
    for key, values in found.items():
        assert len(values) == seeds
        # seven tests: the least of their p-values is below 1e-4 once in 1400 runs
        assert kstest(values, "uniform").pvalue > 1e-4, key


@pytest.mark.slow
def test_p_values_are_uniform() -> None:
    """Kolmogorov-Smirnov over 200 seeds; times follow the same tracers, and are correlated."""
    check_uniform(p_values(200, 1000, "tracer"), 200)


@pytest.mark.slow
@pytest.mark.parametrize("grouping", ["tracer", "medium"])
@pytest.mark.parametrize("restitution", [0.4, 0.9])
def test_p_values_are_uniform_at_the_paper_s_sample_size(grouping: str, restitution: float) -> None:
    check_uniform(p_values(200, PAPER, grouping, restitution), 200)
