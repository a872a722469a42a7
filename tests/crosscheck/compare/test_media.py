"""Data of few tracks do not tell one medium from another: what `fit` says then."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from kinetics import compare, fit
from kinetics.crosscheck import Comparison
from particles import Ensemble, HardDisks, simulate


@cache
def few_tracks() -> dict[str, Any]:
    """150 tracers among hard disks, each in a medium of its own, at 13 times."""
    times = np.linspace(0.0, 60.0, 13)
    run = simulate(
        HardDisks(0.02, 1000),
        0.7,
        times=times,
        media=150,
        tracers=1,
        seed=1003,
        workers=1,
        observables=("positions", "velocities"),
    )
    return {
        "times": times,
        "positions": np.asarray(run.positions),
        "velocities": np.asarray(run.velocities),
        "tracer": np.arange(150),
    }


@cache
def few_tracks_fitted(scatterers: str) -> Comparison:
    return fit(few_tracks(), scatterers=scatterers)


@pytest.mark.parametrize("name", ["restitution", "mean_free_path"])
def test_undecided_media_have_one_value_between_theirs_with_an_error_that_reaches_both(
    name: str,
) -> None:
    both = few_tracks_fitted("auto")
    of_medium = {
        medium: few_tracks_fitted(medium).parameters[name] for medium in ("dilute", "hard disks")
    }
    assert {both.medium, *both.undecided} == set(of_medium)
    value = both.parameters[name].value
    error = both.parameters[name].error
    values = [parameter.value for parameter in of_medium.values()]
    chi_squares = np.array([both.media[medium][0] for medium in of_medium])
    likelihoods = np.exp(-0.5 * (chi_squares - chi_squares.min()))
    assert value == pytest.approx(np.average(values, weights=likelihoods), rel=1e-2)
    assert error > abs(values[1] - values[0])
    for parameter in of_medium.values():
        assert abs(value - parameter.value) < error
        assert error > 0.95 * parameter.error


@cache
def run_among_hard_disks() -> Ensemble:
    """20 tracers in each of 20 media, which says that its scatterers are hard disks."""
    times = [0.0, 2.0, 5.0, 10.0, 20.0, 40.0]
    return simulate(
        HardDisks(0.04, 2000), 0.7, times=times, media=20, tracers=20, seed=3, workers=1
    )


@pytest.mark.parametrize(
    "specified",
    [{"number_density": 0.5}, {"restitution": 0.05}],
    ids=["too dense", "too inelastic"],
)
def test_hard_disks_beyond_their_theory_are_taken_for_dilute(specified: dict[str, float]) -> None:
    comparison = compare(run_among_hard_disks(), fitted=True, explain=False, **specified)
    assert comparison.medium == "dilute"
