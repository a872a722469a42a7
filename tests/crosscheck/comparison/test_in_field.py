"""Data with a uniform field: drift, speed, mean displacement and variances."""

from typing import Any

import numpy as np
import pytest

from kinetics import compare
from kinetics.crosscheck.comparison.data.ensemble_files import from_ensemble
from kinetics.crosscheck.comparison.data.read import read_sample
from kinetics.crosscheck.comparison.sample import Law
from kinetics.crosscheck.comparison.theory import IN_FIELD, observed
from kinetics.errors import InputError
from particles import BoltzmannGrad, simulate

TIMES = np.array([0.0, 5.0, 30.0])
TOLD: dict[str, Any] = {"restitution": 0.7, "number_density": 0.04, "explain": False}


def run_of(dimension: int, initial: str = "rest", tracers: int = 100, **more: Any) -> Any:
    return simulate(
        BoltzmannGrad(0.04, dimension=dimension), restitution=0.7, times=TIMES, media=20,
        tracers=tracers, seed=4, workers=1, initial=initial, field=0.1, **more,
    )  # fmt: skip


def arrays_of(run: Any) -> dict[str, Any]:
    return {"times": run.times, "positions": run.positions, "velocities": run.velocities}


@pytest.mark.slow
@pytest.mark.parametrize("dimension", [2, 3])
def test_averages_are_those_of_the_run(dimension: int) -> None:
    """From the sums of a run, from its stored rows, and from arrays, those of the ensemble."""
    from kinetics.crosscheck.comparison.data.columns import Table

    rows = run_of(dimension, observables=("positions", "velocities"))
    table = Table(arrays_of(rows))
    samples = [
        from_ensemble(rows), from_ensemble(run_of(dimension)),
        read_sample([table], dimension=dimension, with_field=True),
    ]  # fmt: skip
    for sample in samples:
        law = Law(1.0, dimension, 0.1)
        scales = sample.speed_scale, sample.length_scale
        found = observed(sample.sums.sum(axis=0), *scales, tuple(IN_FIELD), law)
        for name, values in zip(IN_FIELD, found, strict=True):
            wanted = getattr(rows, name).value
            wanted = wanted[:, 0] if name == "mean_displacement" else wanted
            if name == "dispersion_perpendicular":  # where the mean is known to be 0
                across = rows.positions[..., 1:]
                wanted = np.mean(across**2, axis=(1, 2))
            np.testing.assert_allclose(values, wanted, rtol=1e-9, atol=1e-12, err_msg=name)


def test_a_field_is_compared() -> None:
    run = run_of(2, tracers=200, observables=("positions", "velocities"))
    for found in (compare(run, explain=False), compare(arrays_of(run), **TOLD, field=0.1)):
        assert found.verdict == "agrees"
        assert [test.observable for test in found.tests] == list(IN_FIELD)
        assert "in a field of 0.1 U²/d, from rest" in found.summary
    wrong = compare(arrays_of(run), **TOLD | {"explain": True}, field=0.11)
    assert wrong.verdict == "differs"
    assert [item.name for item in wrong.explanations] == ["field"]
    assert set(wrong.figures) == {"sigmas", *(name.replace("_", "-") for name in IN_FIELD)}


def test_a_time_before_all_collisions_says_nothing() -> None:
    """No tracer has collided: each falls alike, which few tracers may do by chance."""
    rng, n = np.random.default_rng(1), 30
    velocities, positions = np.zeros((3, n, 2)), np.zeros((3, n, 2))
    velocities[1], positions[1] = [0.5, 0.0], [1.25, 0.0]
    velocities[2] = rng.normal((0.6, 0.0), size=(n, 2))
    positions[2] = rng.normal((14.0, 0.0), 7.0, size=(n, 2))
    found = compare({"times": TIMES, "positions": positions, "velocities": velocities}, **TOLD,
                    field=0.1)  # fmt: skip
    (row,) = (row for row in found.observable("drift") if row.time == 5.0)
    assert (row.value, row.sigmas, row.verdict) == (0.5, None, "undefined")
    assert all(test.dof == 1 for test in found.tests if test.observable != "drift")


@pytest.mark.slow
def test_spheres_and_a_gaussian_start_in_a_field() -> None:
    run = run_of(3, "gaussian", 300, observables=("positions", "velocities"))
    found = compare(arrays_of(run), **TOLD, field=0.1, dimension=3)
    assert found.verdict == "agrees"
    assert "from a Gaussian start" in found.summary


def test_what_a_field_does_not_allow() -> None:
    run = run_of(2, observables=("positions", "velocities"))
    data = arrays_of(run)
    for told, message in (
        ({"restitution": 0.7, "field": 0.1}, "restitution and number_density must be given"),
        (TOLD | {"field": -1.0}, "field: got -1"),
        (TOLD | {"initial": "rest"}, "without a field nothing would move"),
        (TOLD | {"field": 0.1}, "it must be rest, gaussian or monoenergetic"),
    ):
        if told == TOLD | {"field": 0.1}:  # all of one other speed
            data["velocities"] = data["velocities"] * 0 + 1.0
        with pytest.raises(InputError, match=message):
            compare(data, **told)
    still = simulate(BoltzmannGrad(0.04), 0.7, times=[1.0], media=3, tracers=5, workers=1)
    with pytest.raises(InputError, match="the run is one without a field"):
        compare(still, field=0.1)
