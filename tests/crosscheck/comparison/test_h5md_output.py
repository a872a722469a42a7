"""Runs as H5MD files: the layout of the specification, and what reads them."""

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from kinetics import compare
from kinetics.crosscheck.comparison.data.read import read_sample
from particles import BoltzmannGrad, simulate

TIMES = [0.0, 2.0, 20.0]


def run_of(medium: Any, **more: Any) -> Any:
    observables = ("positions", "velocities", "thermal_speed")
    return simulate(
        medium, restitution=0.7, media=4, tracers=30, seed=2, workers=1,
        **({"observables": observables, "times": TIMES} | more),
    )  # fmt: skip


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_layout_is_that_of_h5md(tmp_path: Path, dimension: int) -> None:
    """H5MD 1.1: version, author, creator, box, and elements with value, step and time."""
    path = tmp_path / "run.h5md"
    run = run_of(BoltzmannGrad(0.04, dimension=dimension))
    run.write_h5md(path)
    with h5py.File(path) as file:
        assert file["h5md"].attrs["version"].tolist() == [1, 1]
        assert file["h5md/author"].attrs["name"]
        assert file["h5md/creator"].attrs["name"] == "inelastic-lorentz"
        assert file["h5md/creator"].attrs["version"]
        assert file["h5md/modules/units"].attrs["version"].tolist() == [1, 0]
        group = file["particles/tracers"]
        assert group["box"].attrs["dimension"] == dimension
        assert group["box"].attrs["boundary"].tolist() == [b"none"] * dimension
        for name, unit in (("position", "d"), ("velocity", "U")):
            assert group[name]["value"].attrs["unit"] == unit
            assert group[name]["value"].shape == (3, 120, dimension)
            np.testing.assert_array_equal(group[name]["time"], TIMES)
            assert group[name]["time"].attrs["unit"] == "d U-1"
            assert group[name]["step"].dtype.kind == "i"
        np.testing.assert_array_equal(group["position/value"], run.positions)
        np.testing.assert_array_equal(group["medium"], np.repeat(np.arange(4), 30))
        assert file["parameters/restitution"][()] == 0.7


def test_lengths_are_in_diameters(tmp_path: Path, moments: Any) -> None:
    """Whatever unit the medium is in."""
    for name, medium, factor in (
        ("a", BoltzmannGrad(0.04), 1), ("b", BoltzmannGrad(0.01, diameter=2.0), 2)
    ):  # fmt: skip
        run_of(medium, times=[factor * t for t in TIMES]).write_h5md(tmp_path / f"{name}.h5md")
    one, other = (read_sample([tmp_path / f"{name}.h5md"]) for name in "ab")
    np.testing.assert_array_equal(one.times, other.times)
    np.testing.assert_allclose(moments(one), moments(other), rtol=1e-9)
    with h5py.File(tmp_path / "b.h5md") as file:
        assert file["parameters/number_density"][()] == 0.04


@pytest.mark.parametrize("dimension", [2, 3])
def test_what_is_written_is_read(tmp_path: Path, dimension: int) -> None:
    run = run_of(BoltzmannGrad(0.04, dimension=dimension))
    run.write_h5md(tmp_path / "run.h5md")
    told: dict[str, Any] = {"number_density": 0.04, "dimension": dimension, "explain": False}
    found = compare(tmp_path / "run.h5md", restitution=0.7, **told)
    arrays = {"times": run.times, "positions": run.positions, "velocities": run.velocities}
    assert found.verdict == compare(arrays, restitution=0.7, **told).verdict == "agrees"
    assert (found.grouping, found.groups) == ("medium", 4)
    assert found.warnings == ()


def test_the_command_writes_it(tmp_path: Path, lorentz: Any) -> None:
    path = tmp_path / "run.h5md"
    told = ["simulate", "--medium", "boltzmann-grad", "--media", "3", "--tracers", "20"]
    told += ["--times", "0,1,10", "--max-collisions", "4", "--output", str(path)]
    lorentz(*told)
    with h5py.File(path) as file:  # a tracer that has ended is NaN
        value = file["particles/tracers/position/value"][()]
        assert value.shape == (3, 60, 2)
    assert read_sample([path]).samples[0] == 60
    for more, message in (([], "exists"), (["--resume"], "written at the end")):
        assert message in lorentz.refused(*told, *more)
    told[-1] = str(tmp_path / "none" / "run.h5md")
    assert "folder does not exist" in lorentz.refused(*told)


def test_a_run_without_positions_is_refused(tmp_path: Path) -> None:
    run = run_of(BoltzmannGrad(0.04), observables=("velocities",))
    with pytest.raises(ValueError, match="positions were not asked for"):
        run.write_h5md(tmp_path / "run.h5md")
    assert not (tmp_path / "run.h5md").exists()
