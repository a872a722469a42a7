"""Units that do not belong together are named before anything else, and alone."""

from typing import Any

import numpy as np
import pytest

from kinetics.crosscheck.comparison.data.columns import Rows
from kinetics.crosscheck.comparison.question import compare_sample
from kinetics.crosscheck.comparison.reduction import Reduction
from kinetics.crosscheck.comparison.sample import Sample
from kinetics.crosscheck.comparison.units import straight_flights
from particles import BoltzmannGrad, simulate

TIMES = np.geomspace(1.0, 500.0, 8)


@pytest.fixture(scope="module")
def flights() -> Any:
    """Independent flights, which have no recollisions: positions and velocities."""
    run = simulate(
        BoltzmannGrad(0.04), restitution=0.7, times=TIMES, media=30, tracers=100, seed=17,
        workers=1, observables=("positions", "velocities"),
    )  # fmt: skip
    return run.positions, run.velocities


def sample_of(flights: Any, time: float, length: float, speed: float, first: int = 0) -> Sample:
    """The same tracers, with these units in place of d/U, d and U."""
    reduction = Reduction("tracer")
    for t, r, v in list(zip(TIMES, *flights, strict=True))[first:]:
        columns = (*(r.T * length), *(v.T * speed))
        reduction.add(Rows(np.full(len(r), t * time), *columns, tracer=np.arange(len(r))))
    return reduction.sample(("made",))


@pytest.mark.parametrize(
    ("units", "ratio"),
    [
        ((1.1, 1, 1), 1 / 1.1),
        ((1, 100, 1), 100),
        pytest.param((1000, 1, 1), 1e-3, marks=pytest.mark.slow),
        pytest.param((1, 1, 3.6), 1 / 3.6, marks=pytest.mark.slow),
    ],
)
def test_a_wrong_unit_is_named_and_nothing_else(flights: Any, units: Any, ratio: float) -> None:
    sample = sample_of(flights, *units)
    assert sample.flights is not None
    assert sample.flights.ratio == pytest.approx(ratio, rel=1e-6)
    result = compare_sample(sample, 0.7, 0.04)
    assert result.verdict == "differs"
    assert [item.name for item in result.explanations] == ["time unit"]
    assert result.explanations[0].outcome == "found"
    assert result.explanations[0].value == pytest.approx(1 / ratio, rel=1e-6)
    assert result.summary.startswith("A unit is wrong: tracers that fly straight have r = ")
    assert "recollisions" not in result.to_json()


def test_units_that_belong_together_are_not_complained_of(flights: Any) -> None:
    """Also SI, where U and d are not 1 but v t is r: 0.002 m, 0.5 m/s."""
    for units in ((1, 1, 1), (0.004, 0.002, 0.5)):
        sample = sample_of(flights, *units)
        assert sample.flights is not None
        assert sample.flights.ratio == pytest.approx(1, rel=1e-9)
        rescaled = sample.rescaled(units[2], units[1])
        assert rescaled.flights is not None
        assert rescaled.flights.ratio == pytest.approx(1, rel=1e-9)
        result = compare_sample(rescaled, 0.7, 0.04, explain=False)
        assert result.verdict == "agrees"
        assert result.summary.startswith("No difference seen, better than ")


@pytest.mark.parametrize("units", [(4e-6, 0.002, 500.0), (0.04, 0.002, 0.05)])
def test_si_units_are_hinted_at(flights: Any, units: Any) -> None:
    """v t is r, but U and d are not 1: 0.002 m and 500 or 0.05 m/s."""
    result = compare_sample(sample_of(flights, *units), 0.7, 0.04 / 0.002**2)
    assert [item.name for item in result.explanations] == ["speed unit"]
    assert result.explanations[0].value == pytest.approx(units[2], rel=0.05)
    assert "--length-unit" in result.explanations[0].text
    assert result.summary.startswith("A unit is wrong: speeds at the first time are ")


@pytest.mark.slow
def test_a_forgotten_diameter_is_hinted_at(flights: Any) -> None:
    sample = sample_of(flights, 0.002, 0.002, 1)
    result = compare_sample(sample, 0.7, 0.04 / 0.002**2)
    item = result.explanations[0]
    assert (item.name, item.outcome) == ("free path", "explains")
    assert "as if d were 0.00" in result.summary


def test_a_wrong_unit_gives_no_fitted_value(flights: Any) -> None:
    result = compare_sample(sample_of(flights, 1.1, 1, 1), 0.7, None, explain=False)
    assert result.parameters["mean_free_path"].value is None
    assert "a unit is wrong" in result.parameters["mean_free_path"].source


@pytest.mark.slow
@pytest.mark.parametrize(
    ("units", "name", "value"),
    [
        ((1.1, 1, 1), "time unit", 1.1),
        pytest.param((1, 1.1, 1), "length unit", 1.1, marks=pytest.mark.slow),
    ],
)
def test_units_are_hypotheses_where_no_tracer_flies_straight(
    flights: Any, units: Any, name: str, value: float
) -> None:
    sample = sample_of(flights, *units, first=5)
    assert sample.flights is None
    result = compare_sample(sample, 0.7, 0.04)
    item = result.explanations[0]  # the likeliest, though other causes help too
    assert item.name == name
    assert item.outcome in ("explains", "in part")
    assert item.value is not None
    assert item.error is not None
    assert abs(item.value - value) < 3.5 * item.error
    assert "found" not in {item.outcome for item in result.explanations}


def test_what_flies_straight() -> None:
    rng = np.random.default_rng(1)
    speed = rng.exponential(size=1000)
    distance = speed * 3.0
    found = straight_flights(2.0, distance, speed)
    assert found is not None
    assert (found.ratio, found.share) == (pytest.approx(1.5), 1.0)
    distance[:900] *= rng.uniform(0.3, 1, 900)
    found = straight_flights(2.0, distance, speed)
    assert found is not None
    assert found.ratio == pytest.approx(1.5, rel=1e-3)
    assert found.share == pytest.approx(0.1, abs=0.01)
    distance *= rng.uniform(0.3, 1, 1000)
    assert straight_flights(2.0, distance, speed) is None
    assert straight_flights(0.0, distance, speed) is None
    assert straight_flights(2.0, distance * 0, speed) is None
