"""A comparison is a value: it cannot be changed, it can be compared, pickled, saved and shown."""

import io
import pickle
from dataclasses import FrozenInstanceError, replace
from pathlib import Path
from typing import Any

import pytest
from matplotlib.figure import Figure

from kinetics import load
from kinetics.crosscheck import Comparison, compare_data
from kinetics.errors import InputError
from particles import BoltzmannGrad, simulate


def run_of(seed: int = 4) -> Any:
    return simulate(
        BoltzmannGrad(0.04), restitution=0.75, times=[0.0, 2.0, 20.0, 200.0], media=40, tracers=50,
        seed=seed, workers=1, observables=("positions", "velocities"),
    )  # fmt: skip


@pytest.fixture(scope="module")
def result() -> Comparison:
    """With a wrong density, so that there is something to explain."""
    return compare_data(run_of(), number_density=0.06)


@pytest.mark.slow
def test_equal_data_give_equal_values(result: Comparison) -> None:
    again = compare_data(run_of(), number_density=0.06)
    assert again == result
    assert hash(again) == hash(result)
    assert len({again, result}) == 1
    assert result != compare_data(run_of(5), number_density=0.06, explain=False)
    assert result != replace(result, samples=result.samples + 1)
    assert result != "differs"


def test_a_comparison_cannot_be_changed(result: Comparison) -> None:
    before = result.to_json()
    with pytest.raises(FrozenInstanceError):
        result.verdict = "agrees"  # type: ignore[misc,assignment]
    with pytest.raises(TypeError):
        result.parameters["restitution"] = None  # type: ignore[index]
    with pytest.raises(TypeError):
        result.figures["msd"]["series"][0]["y"][0] = 99.0
    with pytest.raises(FrozenInstanceError):
        result.rows[0].value = 0.0  # type: ignore[misc]
    assert result.to_json() == before


def test_it_survives_a_pickle_and_a_file(result: Comparison, tmp_path: Path) -> None:
    path = tmp_path / "comparison.h5"
    result.save(path)
    for other in (pickle.loads(pickle.dumps(result)), load(path)):
        assert type(other) is Comparison
        assert other == result
        assert hash(other) == hash(result)
        assert other.to_json() == result.to_json()
        assert other.observable("msd") == result.observable("msd")
    damaged = bytearray(path.read_bytes())
    damaged[-100] ^= 0xFF
    path.write_bytes(bytes(damaged))
    with pytest.raises(InputError, match="damaged"):
        load(path)


def test_it_is_shown_with_the_answer_first(result: Comparison) -> None:
    lines = repr(result).splitlines()
    assert 3 < len(lines) <= 10
    assert lines[0].startswith("Comparison: differs. They differ; l = 12.5")
    assert max(map(len, lines)) <= 100
    assert any(line.startswith("  thermal_speed: chi-square ") for line in lines)
    many = replace(result, tests=result.tests * 9, summary="a long summary " * 90)
    assert len(repr(many).splitlines()) <= 10
    html = replace(result, summary="<script>")._repr_html_()
    assert "<strong>differs</strong>. &lt;script&gt;" in html
    assert html.count("<tr>") == 1 + len(result.tests)
    assert {"verdict", "rows", "tests", "explanations", "parameters", "save"} <= set(dir(result))


def test_a_run_and_its_file_are_the_same_data(tmp_path: Path) -> None:
    run = run_of()
    run.save(tmp_path / "run.h5")
    of_run = compare_data(run)
    assert of_run.verdict == "agrees"
    assert of_run.parameters["restitution"].source == "told"
    assert replace(compare_data(tmp_path / "run.h5"), names=of_run.names) == of_run


def test_it_is_drawn_and_made_a_dataset(result: Comparison) -> None:
    axes = Figure().subplots()
    assert result.plot("msd", ax=axes) is axes
    assert axes.get_title()
    assert "d" in axes.get_xlabel()
    with pytest.raises(InputError, match=r"'speed'.*thermal_speed"):
        result.plot("speed")
    xarray = pytest.importorskip("xarray")
    found = result.to_xarray()
    assert found.value.values.tolist() == [row.value for row in result.rows]
    assert found.attrs["status"] == "differs"
    written = io.BytesIO(bytes(found.to_netcdf(engine="scipy")))
    assert xarray.open_dataset(written, engine="scipy").identical(found)
