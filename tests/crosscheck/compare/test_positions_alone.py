"""Tracks of positions alone: e, l, U and the error of a position are found, or said unknown."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from kinetics import compare, fit
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
    beyond 4, and at least one value in each.

    Among hard disks a bias is known whose cause is not: over 40 sets e is high by 0.56(20) and l
    low by 0.78(22) of their errors, which scatter 1.3 times as much as they should.
    """
    largest_mean = {"dilute": 0.75, "hard disks": 1.9}[kind]
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
    assert np.all(np.abs(np.mean(pulls, axis=0)) < largest_mean)
    assert np.max(np.abs(pulls)) < 4.0
