"""Faults of data that a fit would take for something else: winds, copies, rounded times."""

from typing import Any

import numpy as np
import pytest
from made_data import Run, columns_of

from kinetics import compare
from kinetics.crosscheck.data.reading import read_sample


@pytest.mark.parametrize("wind", [0.1, -0.3])
def test_a_wind_is_named_and_not_a_restitution(run: Run, wind: float) -> None:
    data = columns_of(run)
    data["vx"] = data["vx"] + wind
    result = compare(data, 0.75, 0.04)
    assert result.verdict == "differs"
    assert result.explanations[0].name == "wind"
    assert result.explanations[0].outcome == "found"
    assert result.explanations[0].value == pytest.approx(abs(wind), abs=0.02)
    assert not [cause for cause in result.explanations if cause.outcome == "explains"]


def test_data_without_a_wind_have_none(run: Run) -> None:
    result = compare(columns_of(run), 0.6, 0.04, scatterers="dilute")
    assert result.verdict == "differs"
    assert "wind" not in {cause.name for cause in result.explanations}


def test_copies_of_tracers_under_new_labels_are_named(run: Run) -> None:
    data = columns_of(run)
    is_copied = data["id"] % 10 == 0
    copied: dict[str, Any] = {name: values[is_copied] for name, values in data.items()}
    copied["id"] = copied["id"] + 1_000_000
    joined = {name: np.concatenate([data[name], copied[name]]) for name in data}
    (said,) = [text for text in read_sample([joined]).warnings if "copies" in text]
    assert f"{np.unique(copied['id']).size} of " in said
    assert not [text for text in read_sample([data]).warnings if "copies" in text]


def test_coarse_numbers_are_no_copies(run: Run) -> None:
    data = columns_of(run)
    for name in ("x", "y", "vx", "vy"):
        data[name] = data[name].round(0)
    assert not [text for text in read_sample([data]).warnings if "copies" in text]


@pytest.mark.parametrize("begin", [0.0, 1e4])
def test_times_in_single_and_double_precision_are_the_same(begin: float) -> None:
    times = begin + 0.01 * np.arange(20)
    generator = np.random.default_rng(6)
    columns = []
    for kind in (np.float64, np.float32):
        velocity = generator.normal(size=(50, 2))
        place = velocity * (times[:, None, None] - begin)
        columns.append({
            "time": np.repeat(times.astype(kind).astype(float), 50),
            "tracer": np.tile(np.arange(50), 20),
            "x": place[..., 0].ravel(), "y": place[..., 1].ravel(),
            "vx": np.tile(velocity[:, 0], 20), "vy": np.tile(velocity[:, 1], 20),
        })  # fmt: skip
    sample = read_sample(columns)
    assert np.diff(sample.times) == pytest.approx(np.full(19, 0.01), abs=1e-3)
    assert np.all(sample.samples == 100)
