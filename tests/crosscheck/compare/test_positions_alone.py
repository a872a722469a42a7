"""Tracks of positions alone: e, l, U and the error of a position are found, or said unknown."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from kinetics import Scene, compare, fit, solve
from kinetics.crosscheck.data.reading import read_sample
from particles import BoltzmannGrad, HardDisks, simulate

RESTITUTION = 0.7
DENSITY = 0.04
PATH = 12.5
NOISE = 0.05
#: 24 frames, the first two closer than the mean free time, in d/U.
FRAMES = np.concatenate([[0.0], np.geomspace(0.5, 400.0, 23)])


@cache
def tracks(
    kind: str,
    n_tracers: int = 600,
    seed: int = 1,
    restitution: float = RESTITUTION,
    noise: float = NOISE,
) -> dict[str, Any]:
    """Positions of tracers, each among scatterers of its own, with an error of each position."""
    medium = HardDisks(DENSITY, 1000) if kind == "hard disks" else BoltzmannGrad(DENSITY)
    run = simulate(
        medium,
        restitution,
        times=FRAMES,
        media=n_tracers,
        tracers=1,
        seed=seed,
        workers=1,
        observables=("positions",),
    )
    random = np.random.default_rng(seed)
    place = np.asarray(run.positions) + random.uniform(0.0, 50.0, (1, n_tracers, 2))
    place = place + noise * random.normal(size=place.shape)
    return {"times": FRAMES, "positions": place, "tracer": np.arange(n_tracers)}


def every_second_frame(data: dict[str, Any]) -> dict[str, Any]:
    """The same tracks at half of the times: a fit of fewer pairs of frames is quicker."""
    return data | {"times": data["times"][::2], "positions": data["positions"][::2]}


def within_errors(parameter: Any, truth: float, most: float = 4.0) -> bool:
    return abs(parameter.value - truth) < most * parameter.error


def test_all_four_numbers_are_found() -> None:
    """Each within four of its errors, and as well known as 600 tracks can."""
    result = fit(tracks("dilute"), scatterers="dilute")
    assert result.verdict == "agrees"
    parameters = result.parameters
    for name, truth, error in (
        ("restitution", RESTITUTION, 0.03),
        ("mean_free_path", PATH, 0.06 * PATH),
        ("speed_unit", 1.0, 0.05),
        ("position_error", NOISE, 0.1 * NOISE),
    ):
        assert within_errors(parameters[name], truth)
        assert parameters[name].error < error
    assert result.cannot_tell == ()


@pytest.mark.slow
def test_a_wrong_restitution_is_seen_and_named() -> None:
    result = compare(tracks("dilute"), 0.9, DENSITY, scatterers="dilute")
    assert result.verdict == "differs"
    item = next(item for item in result.explanations if item.name == "restitution")
    assert item.outcome == "explains"
    assert within_errors(item, RESTITUTION)


def test_what_is_specified_is_held() -> None:
    """U and the error of a position, in the data's unit of length."""
    data = every_second_frame(tracks("dilute"))
    millimetres = data | {"positions": 3.0 * data["positions"]}
    result = fit(
        millimetres,
        scatterers="dilute",
        diameter=3.0,
        speed_unit=3.0,
        localisation_error=3.0 * NOISE,
    )
    assert "speed_unit" not in result.parameters
    assert "position_error" not in result.parameters
    assert within_errors(result.parameters["restitution"], RESTITUTION)
    assert within_errors(result.parameters["mean_free_path"], PATH)


def test_units_of_the_data_are_those_of_the_answer() -> None:
    """Lengths in mm and times in ms: U is in mm/ms, the error of a position in mm."""
    data = every_second_frame(tracks("dilute"))
    other = {
        "times": 0.1 * data["times"],
        "positions": 3.0 * data["positions"],
        "tracer": data["tracer"],
    }
    result = fit(other, scatterers="dilute", diameter=3.0)
    assert within_errors(result.parameters["mean_free_path"], PATH)
    assert within_errors(result.parameters["speed_unit"], 30.0)
    assert within_errors(result.parameters["position_error"], 3.0 * NOISE)


@pytest.mark.slow
def test_speeds_are_lengths_over_times_also_where_the_unit_of_time_is_told() -> None:
    """Lengths in mm and times in ms, d = 3 mm and d/U = 0.1 ms: U is 30 mm/ms."""
    data = tracks("dilute")
    other = {
        "times": 0.1 * data["times"],
        "positions": 3.0 * data["positions"],
        "tracer": data["tracer"],
    }
    result = fit(other, scatterers="dilute", diameter=3.0, time_unit=0.1)
    assert within_errors(result.parameters["speed_unit"], 30.0)
    units = result.units
    assert units["speed"] == pytest.approx(units["length"] / units["time"])
    assert units["speed"] == pytest.approx(result.parameters["speed_unit"].value)


def test_a_sample_is_in_diameters_already() -> None:
    sample = read_sample([tracks("dilute")])
    arguments = {"scatterers": "dilute", "localisation_error": NOISE, "explain": False}
    result = compare(sample, RESTITUTION, DENSITY, **arguments)
    other = compare(sample, RESTITUTION, DENSITY, diameter=3.0, **arguments)
    assert other.chi_square == result.chi_square


@pytest.mark.slow
def test_a_restitution_that_is_specified_is_held_while_the_rest_is_fitted() -> None:
    result = compare(
        tracks("dilute", 150),
        RESTITUTION,
        scatterers="dilute",
        fitted=True,
        explain=False,
        localisation_error=NOISE,
    )
    assert result.parameters["restitution"].value == RESTITUTION
    assert result.parameters["restitution"].error is None


@pytest.mark.slow
def test_the_time_of_the_clearest_deviation_is_in_the_fitted_unit() -> None:
    """Times in ms, U = 10 d/ms, and displacements at the end that are multiples of half their
    size: averages are nearly as before, and the last density differs."""
    data = tracks("dilute", noise=0.0)
    place = data["positions"].copy()
    displacement = place[-1] - place[0]
    distance = np.linalg.norm(displacement, axis=-1, keepdims=True)
    width = 0.5 * np.sqrt(np.mean(distance**2))
    place[-1] = place[0] + displacement / distance * width * (np.floor(distance / width) + 0.5)
    other = {"times": 0.1 * data["times"], "positions": place, "tracer": data["tracer"]}
    result = fit(other, scatterers="dilute", localisation_error=0.0)
    clearest = min(result.tests, key=lambda test: test.p_value)
    assert clearest.time == pytest.approx(400.0, rel=0.2)
    assert f"at t = {clearest.time:.4g}" in result.summary


def test_the_time_of_missing_tracers_is_in_the_fitted_unit() -> None:
    data = tracks("dilute", 300)
    place = data["positions"].copy()
    place[-1, 200:] = np.nan
    other = {"times": 0.1 * data["times"], "positions": place, "tracer": data["tracer"]}
    result = compare(other, RESTITUTION, DENSITY, scatterers="dilute", localisation_error=NOISE)
    missing = next(item for item in result.explanations if item.name == "missing tracers")
    assert f"at t = {result.last_time:.4g}" in missing.text


def test_too_few_frames_are_refused() -> None:
    data = tracks("dilute")
    late = np.concatenate([[0], np.flatnonzero(FRAMES > 300.0)])
    chosen = {"times": FRAMES[late], "positions": data["positions"][late], "tracer": data["tracer"]}
    with pytest.raises(ValueError, match="too few pairs of frames"):
        fit(chosen, scatterers="dilute")


def test_coarse_frames_of_elastic_tracers_know_a_product_alone() -> None:
    """Tracers that do not cool diffuse, and l and U are known by l U; it is said so."""
    data = tracks("dilute", 150, restitution=1.0)
    late = np.concatenate([[0], np.flatnonzero(FRAMES > 100.0)])
    chosen = {"times": FRAMES[late], "positions": data["positions"][late], "tracer": data["tracer"]}
    result = compare(chosen, 1.0, scatterers="dilute", localisation_error=NOISE, explain=False)
    assert any("mean free path" in sentence and "U" in sentence for sentence in result.cannot_tell)


def test_gaps_are_no_displacements() -> None:
    """A fifth of all places is missing at random: fewer data, the same numbers."""
    data = every_second_frame(tracks("dilute"))
    place = data["positions"].copy()
    place[np.random.default_rng(3).random(place.shape[:2]) < 0.2] = np.nan
    result = fit(data | {"positions": place}, scatterers="dilute")
    assert result.verdict == "agrees"
    assert within_errors(result.parameters["restitution"], RESTITUTION)
    assert within_errors(result.parameters["mean_free_path"], PATH)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["dilute", "hard disks"])
def test_errors_of_positions_alone_are_honest(kind: str) -> None:
    """Over 16 sets of 1,000 tracks: pulls with means within 0.75 (three standard errors), none
    beyond 4, and at least one value in each."""
    truths = (
        ("restitution", RESTITUTION),
        ("mean_free_path", PATH),
        ("speed_unit", 1.0),
        ("position_error", NOISE),
    )
    pulls = []
    for seed in range(16):
        parameters = fit(tracks(kind, 1000, 100 + seed)).parameters
        pulls.append([(parameters[n].value - x) / parameters[n].error for n, x in truths])
    assert np.all(np.abs(np.mean(pulls, axis=0)) < 0.75)
    assert np.max(np.abs(pulls)) < 4.0


@pytest.mark.parametrize("seed", [602, 605, 616, 635])
@pytest.mark.slow
def test_a_medium_is_not_taken_for_sure_where_another_is_likelier_by_chance(seed: int) -> None:
    """T^2 of dilute scatterers is 9 to 13 below that of hard disks, which these tracks are among.

    With dilute scatterers alone e and l are 1.3 to 5.5 of their errors off.
    """
    result = fit(tracks("hard disks", 600, seed))
    assert {result.medium, *result.undecided} == {"dilute", "hard disks"}
    assert within_errors(result.parameters["restitution"], RESTITUTION, 2.0)
    assert within_errors(result.parameters["mean_free_path"], 0.5 / DENSITY, 2.0)


@cache
def many_tracks_among_hard_disks() -> dict[str, Any]:
    """20,000 tracks without an error of the position, 20 in each medium."""
    run = simulate(
        HardDisks(DENSITY, 2000),
        RESTITUTION,
        times=FRAMES,
        media=1000,
        tracers=20,
        seed=5,
        workers=1,
        observables=("positions",),
    )
    tracer = np.arange(20_000)
    return {
        "times": FRAMES,
        "positions": np.asarray(run.positions),
        "tracer": tracer,
        "medium": tracer // 20,
    }


@pytest.mark.slow
def test_many_tracks_know_no_more_than_the_theory() -> None:
    """The theory of two pairs of frames with one later frame is off by different amounts: that of e
    is then off by 0.003, and its error is no smaller however many tracks there are."""
    result = fit(many_tracks_among_hard_disks(), scatterers="hard disks", localisation_error=0.0)
    restitution = result.parameters["restitution"]
    assert restitution.error > 0.0035
    assert within_errors(restitution, RESTITUTION, 2.0)
    assert within_errors(result.parameters["mean_free_path"], PATH, 2.0)


@pytest.mark.slow
def test_errors_of_hard_disks_do_not_hang_on_the_unit_of_time() -> None:
    """The theory's own error grows with the first collisions, in l/U of the fitted U."""
    data = tracks("hard disks")
    parameters = fit(data, scatterers="hard disks").parameters
    other = fit(data | {"times": 0.1 * data["times"]}, scatterers="hard disks").parameters
    for name in ("restitution", "position_error"):
        assert other[name].error == pytest.approx(parameters[name].error, rel=0.03)


@pytest.mark.slow
def test_speeds_among_hard_disks_are_theirs() -> None:
    """M(s, t) is within 0.5 % of the mean over simulated speeds at s of <r^2> of tracers of one
    speed among hard disks (standard error 0.3 %); with the speeds of dilute tracers it is 1 % above
    it at late times."""
    frames = np.array([0.0, 100.0, 150.0, 200.0, 300.0, 400.0])
    run = simulate(
        HardDisks(DENSITY, 1000),
        RESTITUTION,
        times=frames,
        media=40_000,
        tracers=1,
        seed=3,
        workers=1,
        observables=("positions", "velocities"),
    )
    speed = np.linalg.norm(run.velocities, axis=-1)
    few = {"times": frames, "positions": run.positions[:, :500], "tracer": np.arange(500)}
    result = compare(
        few,
        RESTITUTION,
        DENSITY,
        scatterers="hard disks",
        speed_unit=1.0,
        localisation_error=0.0,
        explain=False,
    )
    flown = np.geomspace(1e-3, 4000.0, 200)  # in d, at the speed U
    scene = Scene(
        RESTITUTION,
        DENSITY,
        times=flown,
        initial="monoenergetic",
        scatterers="hard disks",
        outputs="msd",
    )
    squares = CubicSpline(np.log(flown), np.log(solve(scene).msd))
    rows = result.to_dataframe("displacement_between_frames")
    rows = rows[rows["since"] >= 100.0]
    assert len(rows) >= 6
    for since, time, theory in rows[["since", "time", "theory"]].to_numpy():
        at = np.searchsorted(frames, since - 1e-6)
        of_speeds = np.exp(squares(np.log(speed[at] * (time - since))))
        assert of_speeds.mean() == pytest.approx(theory, rel=0.005)
