"""Averages that have no scatter, and data of few independent groups."""

from functools import cache
from typing import Any

import numpy as np
import pytest
from made_data import simulated
from marking import slow_but
from scipy import stats

from kinetics import compare, fit

DENSITY = 0.04
TIMES = (0.0, *np.geomspace(1.0, 500.0, 4))
#: Arguments of a comparison whose medium and causes do not matter, which is quicker.
IN_ONE_MEDIUM: dict[str, Any] = {"scatterers": "dilute", "explain": False}


def arrays_of(run: Any, media: int) -> dict[str, Any]:
    tracers = run.positions.shape[1]
    medium = np.arange(tracers) * media // tracers
    return {
        "times": run.times,
        "positions": run.positions,
        "velocities": run.velocities,
        "medium": medium,
    }


def turned_to_x(data: dict[str, Any]) -> dict[str, Any]:
    """The same tracers, each turned so that its first velocity is along x: a beam."""
    first = data["velocities"][0]
    cosine, sine = first[:, 0], first[:, 1]
    turned = dict(data)
    for name in ("positions", "velocities"):
        x, y = data[name][..., 0], data[name][..., 1]
        turned[name] = np.stack([cosine * x + sine * y, cosine * y - sine * x], axis=-1)
    return turned


@cache
def sharp(start: str, e: float, media: int, seed: int = 5, times: Any = TIMES) -> dict[str, Any]:
    """Tracers that all have the speed U at time 0."""
    run = simulated(restitution=e, initial="monoenergetic", times=times, seed=seed)
    data = arrays_of(run, media)
    return turned_to_x(data) if start == "beam" else data


# -- no scatter ------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("start", "media"),
    slow_but(
        [("monoenergetic", 12), ("monoenergetic", 2000), ("beam", 12), ("beam", 40)],
        [(start, media) for start in ("monoenergetic", "beam") for media in (12, 40, 2000)],
    ),
)
def test_a_fit_to_elastic_tracers_of_one_speed_does_not_differ(start: str, media: int) -> None:
    times = (0.0, *np.geomspace(1.0, 500.0, 6))
    result = fit(sharp(start, 1.0, media, times=times), scatterers="dilute")
    assert result.verdict == "agrees"
    assert max(test.chi_square for test in result.tests) < 40.0
    restitution = result.parameters["restitution"]
    assert restitution.value is not None
    assert restitution.error is not None
    assert 1.0 - restitution.value < 3 * restitution.error


@pytest.mark.parametrize("times", [(0.0, 20.0, 200.0), (0.0, 5.0, 50.0, 500.0)])
@pytest.mark.parametrize("media", [10, 20])
def test_a_restitution_that_is_fitted_to_elastic_tracers_agrees(media: int, times: Any) -> None:
    data = sharp("monoenergetic", 1.0, media, seed=7, times=times)
    result = compare(data, number_density=DENSITY, **IN_ONE_MEDIUM)
    assert result.verdict == "agrees"
    assert max(test.chi_square for test in result.tests) < 30.0
    assert result.parameters["restitution"].value == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("start", ["monoenergetic", "beam"])
def test_conserved_speed_is_exact_within_rounding(start: str) -> None:
    data = sharp(start, 1.0, 40)
    single = data | {"velocities": data["velocities"].astype(np.float32)}
    for velocities in (data, single):
        result = compare(velocities, 1.0, DENSITY, **IN_ONE_MEDIUM)
        assert result.verdict == "agrees"
        assert not [test for test in result.tests if test.observable in ("thermal_speed", "a2")]
        speed = result.rows[result.rows["observable"] == "thermal_speed"]
        assert set(speed["verdict"]) == {"agrees"}
        assert set(speed["error"]) == {0.0}


def test_a_common_rounding_of_speeds_is_no_difference() -> None:
    """Speeds that are all 2e-7 too high, with noise of 1e-8: many times the error of the mean."""
    data = dict(sharp("monoenergetic", 1.0, 40))
    noise = 1e-7 * np.random.default_rng(1).normal(size=data["velocities"].shape)
    data["velocities"] = data["velocities"] * (1 + 2e-7 + noise)
    result = compare(data, 1.0, DENSITY, **IN_ONE_MEDIUM)
    assert result.verdict == "agrees"


@pytest.mark.parametrize("start", ["monoenergetic", "beam"])
def test_a_speed_that_changes_alike_for_all_differs_from_conserved_speed(start: str) -> None:
    data = dict(sharp(start, 1.0, 40))
    data["velocities"] = data["velocities"].copy()
    data["velocities"][3:] *= 1 - 1e-4
    result = compare(data, 1.0, DENSITY, explain=False)
    assert result.verdict == "differs"


@pytest.mark.parametrize(
    ("e", "start"),
    slow_but(
        [(0.99, "monoenergetic"), (0.5, "beam")],
        [(e, start) for e in (0.99, 0.5) for start in ("monoenergetic", "beam")],
    ),
)
def test_inelastic_tracers_differ_from_conserved_speed(start: str, e: float) -> None:
    result = compare(sharp(start, e, 40), 1.0, DENSITY, explain=False)
    assert result.verdict == "differs"


@pytest.mark.parametrize("media", [12, 2000])
def test_tracers_of_which_none_has_collided_yet_are_no_difference(media: int) -> None:
    """2000 tracers have 0.16, 0.32 and 1.6 collisions by these times: some see none."""
    times = (0.0, 0.001, 0.002, 0.01, 10.0, 100.0)
    data = sharp("monoenergetic", 1.0, media, times=times)
    result = compare(data, 1.0, DENSITY, **IN_ONE_MEDIUM)
    assert result.verdict == "agrees"


def test_straight_flights_at_a_time_when_many_should_have_collided_differ() -> None:
    times = (0.0, 0.5, 1.0, 2.0, 4.0)
    data = dict(sharp("monoenergetic", 1.0, 40, times=times))
    data["velocities"] = np.repeat(data["velocities"][:1], len(times), axis=0)
    data["positions"] = data["velocities"] * np.array(times)[:, None, None]
    result = compare(data, 1.0, DENSITY, explain=False)
    assert result.verdict == "differs"


# -- few groups ------------------------------------------------------------------------------------
@cache
def of_media(restitutions: tuple[float, ...], seed: int) -> dict[str, Any]:
    """One configuration of 500 tracers for each restitution."""
    runs = [
        simulated(restitution=e, times=TIMES, media=1, tracers=500, seed=seed + k)
        for k, e in enumerate(restitutions)
    ]
    joined = {
        name: np.concatenate([getattr(run, name) for run in runs], axis=1)
        for name in ("positions", "velocities")
    }
    medium = np.repeat(np.arange(len(runs)), 500)
    return {"times": np.array(TIMES), **joined, "medium": medium}


@pytest.mark.parametrize(
    ("seed", "assumed"),
    slow_but([(1, 0.7), (3, 0.6), (5, 0.7)], [(seed, e) for seed in (1, 3, 5) for e in (0.7, 0.6)]),
)
def test_two_configurations_of_two_restitutions_are_not_tested(seed: int, assumed: float) -> None:
    result = compare(of_media((0.5, 0.7), seed), assumed, DENSITY, **IN_ONE_MEDIUM)
    assert result.verdict == "not tested"
    assert "agrees" not in {test.verdict for test in result.tests}
    scattered = result.rows[result.rows["error"] > 0]
    assert "agrees" not in set(scattered["verdict"])


@pytest.mark.parametrize("groups", [2, 5, 40])
def test_limits_are_students(groups: int) -> None:
    """|difference| + t (error), t of groups - 1 degrees of freedom; in the plane, at one time."""
    data = of_media((0.7,) * groups, 20)
    late = [-1]
    data = data | {name: data[name][late] for name in ("times", "positions", "velocities")}
    result = compare(data, 0.7, DENSITY, "gaussian", "displacement", explain=False)
    (row,) = result.rows[result.rows["observable"] == "thermal_speed"].itertuples()
    (test,) = [test for test in result.tests if test.observable == "thermal_speed"]
    factor = (test.within * row.theory - abs(row.value - row.theory)) / row.error
    least = stats.t.ppf(0.975, groups - 1)
    # long tails count as fewer groups
    assert least * 0.999 < factor < 1.15 * least


def test_many_groups_are_tested() -> None:
    result = compare(of_media((0.7,) * 10, 40), 0.7, DENSITY, **IN_ONE_MEDIUM)
    assert result.verdict == "agrees"
    result = compare(of_media((0.5,) * 10, 60), 0.7, DENSITY, explain=False)
    assert result.verdict == "differs"
