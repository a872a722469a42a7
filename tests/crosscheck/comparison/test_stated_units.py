"""Units that stand in the file are used, or at least said."""

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from kinetics.crosscheck.comparison.data.columns import Table, split_unit
from kinetics.crosscheck.comparison.data.read import read_sample
from kinetics.crosscheck.comparison.data.stated_units import conversion, size_of
from kinetics.errors import InputError


def with_units(data: dict[str, Any], units: dict[str, str]) -> dict[str, Any]:
    return {f"{k} [{units[k]}]" if k in units else k: v for k, v in data.items()}


LAB = {"time": "ms", "x": "mm", "y": "mm", "vx": "m/s", "vy": "m/s"}


@pytest.mark.parametrize("kind", ["csv", "npz"])
def test_units_behind_names_are_converted(
    tmp_path: Path, kind: str, made_up: Any, moments: Any, write: Any
) -> None:
    """d = 2 mm, U = 0.5 m/s: d/U = 4 ms."""
    data = made_up()
    plain = read_sample([Table(data)])
    scaled = data | {k: data[k] * 2 for k in "xy"} | {k: data[k] / 2 for k in ("vx", "vy")}
    scaled["time"] = data["time"] * 4
    path = write(tmp_path, kind, with_units(scaled, LAB)) if kind == "csv" else tmp_path / "a.npz"
    if kind == "npz":
        names = {k: v.replace("/", " ") + ("-1" if "/" in v else "") for k, v in LAB.items()}
        np.savez(path, **with_units(scaled, names))
    sample = read_sample([path], diameter=2.0, speed_unit=0.5)
    np.testing.assert_allclose(sample.times, plain.times)
    np.testing.assert_allclose(moments(sample), moments(plain), rtol=1e-9)
    assert "lengths in mm, speeds in m" in sample.warnings[0]
    assert "d/U = 4 in the data's units" in sample.warnings[0]
    told = read_sample([path], diameter=2.0, speed_unit=0.5, time_unit=8.0)
    np.testing.assert_allclose(told.times, plain.times / 2)


def test_unknown_units_are_said_and_not_converted(made_up: Any) -> None:
    data = with_units(made_up(), LAB | {"time": "sweeps"})
    sample = read_sample([Table(data)])
    np.testing.assert_array_equal(sample.times, [0.0, 1.0, 10.0])
    assert "times in sweeps" in sample.warnings[0]
    assert "nothing was converted" in sample.warnings[0]


def test_the_units_of_this_package_need_no_words(made_up: Any) -> None:
    own = {"time": "d/U", "x": "d", "y": "d", "vx": "U", "vy": "U"}
    plain = read_sample([Table(made_up())]).warnings
    assert read_sample([Table(with_units(made_up(), own))]).warnings == plain
    said = read_sample([Table(with_units(made_up(), own))], diameter=2.0).warnings
    assert "lengths in d" in said[0]


def test_units_that_differ_are_refused(tmp_path: Path, made_up: Any, write: Any) -> None:
    with pytest.raises(InputError, match="has lengths in mm and in 'm'"):
        read_sample([Table(with_units(made_up(), LAB | {"y": "m"}))])
    one = write(tmp_path, "csv", with_units(made_up(), LAB))
    other = Table(with_units(made_up(), LAB | {"time": "s"}))
    with pytest.raises(InputError, match="states other units than what was read before"):
        read_sample([one, other])


def test_units_of_hdf5_and_of_dumps(tmp_path: Path, made_up: Any) -> None:
    path = tmp_path / "data.h5"
    with h5py.File(path, "w") as file:
        for name, values in made_up().items():
            file[name] = values
            file[name].attrs["unit"] = LAB.get(name, "")
    assert "times in ms" in read_sample([path]).warnings[0]
    head = "ITEM: UNITS\nmetal\nITEM: TIMESTEP\n1\nITEM: NUMBER OF ATOMS\n2\n"
    box = "ITEM: BOX BOUNDS pp pp pp\n0 1\n0 1\n0 1\nITEM: ATOMS id xu yu vx vy\n"
    dump = tmp_path / "run.dump"
    dump.write_text(head + box + "1 1 0 1 0\n2 2 0 2 0\n")
    sample = read_sample([dump], timestep=1.0, diameter=3.0, speed_unit=2.0)
    assert "lengths in angstrom, speeds in angstrom/ps, times in ps" in sample.warnings[-1]
    np.testing.assert_allclose(sample.times, 1 / 1.5)


def test_names_and_units() -> None:
    assert split_unit("t [s]") == ("t", "s")
    assert split_unit("Vx (m/s)") == ("vx", "m/s")
    assert split_unit("<r^2>") == ("<r^2>", "")
    assert split_unit("v0(t)") == ("v0(t)", "")
    assert size_of("speed", "cm/s") == size_of("speed", "cm s^-1") == pytest.approx(0.01)
    assert size_of("speed", "knots") is size_of("time", "ages") is None
    assert conversion({"length": "mm", "speed": "mm/s", "time": "s"}) == pytest.approx(1)
    assert conversion({"length": "d", "speed": "U", "time": "d U-1"}) == 1.0
    assert conversion({"length": "d"}) == 1.0
    assert conversion({"length": "d", "time": "s"}) is None
