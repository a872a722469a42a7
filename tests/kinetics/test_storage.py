"""save and load: every result comes back equal, a file is whole or absent, a bad one is refused."""

import dataclasses
import enum
import hashlib
import os
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from example_values import STATES, VALUES, solved, with_densities
from marking import slow_but

from kinetics import InputError, ScalingSolution, Scene, SpeedDensity, load, solve_scaled, storage
from kinetics.outputs import OUTPUTS

STORED = [name for name in STATES if name not in ("density", "harmonics")]  # not functions


@pytest.mark.parametrize("state", STORED)
def test_scenes_come_back(state: str, tmp_path: Path) -> None:
    scene = Scene(0.7, initial=STATES[state](), times=[0.0, 1.0], outputs=("msd", "a2"))
    scene.save(tmp_path / "a.h5")
    found = load(tmp_path / "a.h5")
    assert type(found) is Scene
    assert found == scene
    assert found.initial == scene.initial
    assert found.state.harmonic(0, 1e-8).weight.tolist() == (
        scene.state.harmonic(0, 1e-8).weight.tolist()
    )
    with pytest.raises(ValueError, match="read-only"):
        found.times[0] = 1.0


@pytest.mark.parametrize("e", slow_but([0.7], [0.0, 0.7, 1.0]))
@pytest.mark.parametrize("state", STORED)
def test_solutions_come_back(state: str, e: float, tmp_path: Path) -> None:
    density = not (e == 1.0 and state in ("samples", "velocities"))
    averages = [name for name, row in OUTPUTS.items() if row.values is not None]
    outputs = (*averages, "intermediate_scattering", *(["velocity_density"] if density else []))
    solution = solved(state, e, outputs)
    solution.save(tmp_path / "a.h5")
    found = load(tmp_path / "a.h5")
    assert found == solution
    assert hash(found) == hash(solution)
    assert repr(found) == repr(solution)
    assert list(found.values) == list(solution.values)
    v = [0.1, 1.0]
    assert np.array_equal(found.harmonic(1.5, 2), solution.harmonic(1.5, 2))
    assert np.array_equal(
        found.intermediate_scattering([0.1], 0.2), solution.intermediate_scattering([0.1], 0.2)
    )
    if density:
        assert np.array_equal(found.velocity_density(v, v), solution.velocity_density(v, v))
        assert np.array_equal(found.uncollided, solution.uncollided)
    with pytest.raises(ValueError, match="read-only"):
        found.msd[0] = 1.0
    with pytest.raises(TypeError):
        found.values["msd"] = 1


def test_the_density_of_the_displacement_comes_back(tmp_path: Path) -> None:
    solution = with_densities()
    solution.save(tmp_path / "a.h5")
    found = load(tmp_path / "a.h5")
    assert found == solution
    r = [0.0, 0.5, 1.0]
    for ask in (
        lambda s: s.position_density(r),
        lambda s: s.scaled_position_density(r),
        lambda s: s.position_fraction(r),
        lambda s: s.position_tail([0.5, 1.0])[0],
        lambda s: s.ballistic_front[1],
    ):
        assert np.array_equal(ask(found), ask(solution), equal_nan=True)
    assert found.plan == solution.plan
    assert found.stats == solution.stats


def test_scaled_distributions_come_back(tmp_path: Path) -> None:
    vdf, exact = solve_scaled(0.7, 1e-8, nodes=64), ScalingSolution(0.7)
    for value in (vdf, exact):
        value.save(tmp_path / "a.h5")
        found = load(tmp_path / "a.h5")
        assert type(found) is type(value)
        assert found == value
        assert (found.cooling_rate, found.a2) == (value.cooling_rate, value.a2)
        assert found.vdf(1.0) == value.vdf(1.0)


def test_a_loaded_h_is_the_one_that_was_saved(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Read from the file, not solved again by whatever version reads it."""
    vdf = solve_scaled(0.7, 1e-8)
    vdf.save(tmp_path / "a.h5")
    monkeypatch.setattr("kinetics.scaling.scaled_vdf.SpeedAxis", None)
    assert load(tmp_path / "a.h5").cooling_rate == vdf.cooling_rate
    assert load(tmp_path / "a.h5").a2 == vdf.a2


def test_files_say_their_units(tmp_path: Path) -> None:
    solved("gaussian").save(tmp_path / "a.h5")
    with h5py.File(tmp_path / "a.h5") as file:
        solution = file["value"]
        assert solution.attrs["class"] == "Solution"
        assert solution["values/msd"].attrs["unit"] == "d^2"
        assert solution["values/thermal_speed"].attrs["unit"] == "U"
        assert solution["scene/times"].attrs["unit"] == "d/U"
        assert solution["scene/restitution"][()] == 0.7


# -- what files cannot hold -----------------------------------------------------------------------


@pytest.mark.parametrize("initial", [lambda v: v * np.exp(-v * v / 2), STATES["harmonics"]()])
def test_a_function_cannot_be_saved(initial: Any, tmp_path: Path) -> None:
    for scene in (
        Scene(0.7, initial=initial, times=[1.0]),
        Scene(0.7, initial=SpeedDensity(np.abs), times=[1.0]),
    ):
        with pytest.raises(InputError, match=r"^Scene\.initial.*function.*SpeedTable") as caught:
            scene.save(tmp_path / "a.h5")
        assert "\n" not in str(caught.value)
        assert os.listdir(tmp_path) == []


class Colour(enum.Enum):
    RED = 1


@dataclasses.dataclass(frozen=True)
class Anything:
    value: Any
    unused: dict[str, int] = dataclasses.field(default_factory=dict, init=False)


@pytest.fixture
def registered(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(storage, "_registered", dict(storage._registered))
    storage.register(Anything)
    storage.register(Colour, "TestColour")


@pytest.mark.usefixtures("registered")
@pytest.mark.parametrize(
    "value",
    [
        None, True, 3, -(2**63), 2.5, float("inf"), 1.5 - 2j, "", "h\u00e9\n\u2028", (), (1, "a"),
        [1, [2.5]], {"b": 1, "a": {1: None, 0: (2,)}}, {}, Colour.RED, np.zeros((0, 3)),
        np.arange(3), np.array(2.5), np.array([True]), np.array([1j]), Anything(np.ones(2)),
    ],
)  # fmt: skip
def test_kinds_of_contents(value: Any, tmp_path: Path) -> None:
    storage.save(Anything(value), tmp_path / "a.h5")
    found = load(tmp_path / "a.h5").value
    assert type(found) is type(value)
    if isinstance(value, dict):
        assert list(found) == list(value)
    if isinstance(value, Anything):
        found, value = found.value, value.value
    if isinstance(value, np.ndarray):
        assert found.dtype == value.dtype
        assert found.shape == value.shape
        assert not found.flags.writeable
        assert np.array_equal(found, value)
    else:
        assert found == value


@pytest.mark.usefixtures("registered")
@pytest.mark.parametrize(
    ("value", "say"),
    [
        (2**63, "64 bits"),
        (object(), "cannot be stored"),
        ({1: 2, "b": 3}, "keys"),
        ({"a/b": 3}, "keys"),
        (np.array(["a"]), "cannot be stored"),
        ([max], "function"),
    ],
)
def test_contents_that_are_refused(value: Any, say: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=rf"^Anything\.value.*{say}"):
        storage.save(Anything(value), tmp_path / "a.h5")
    assert os.listdir(tmp_path) == []


def test_only_known_classes(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"^Anything: got .*cannot be stored"):
        storage.save(Anything(1), tmp_path / "a.h5")
    with pytest.raises(InputError, match=r"^dict: got .*cannot be stored"):
        storage.save({}, tmp_path / "a.h5")


def test_every_class_of_the_table_is_there() -> None:
    for name in storage.HOMES:
        assert storage._class_of(name, "").__name__ == name


# -- files ----------------------------------------------------------------------------------------


def test_a_file_is_whole_or_as_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.h5"
    Scene(0.7, times=[1.0]).save(path)
    before = path.read_bytes()
    for module, name in ((os, "replace"), (os, "fsync"), (storage, "_write_object")):
        with monkeypatch.context() as patched:

            def stop(*arguments: Any) -> None:
                raise KeyboardInterrupt

            patched.setattr(module, name, stop)
            with pytest.raises(KeyboardInterrupt):
                Scene(0.5, times=[2.0]).save(path)
        assert path.read_bytes() == before
        assert os.listdir(tmp_path) == ["a.h5"]
    Scene(0.5, times=[2.0]).save(path)
    assert load(path) == Scene(0.5, times=[2.0])
    assert os.listdir(tmp_path) == ["a.h5"]


def test_a_path_that_cannot_be_written(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"^path: got .*cannot be written .No such file"):
        Scene(0.7, times=[1.0]).save(tmp_path / "none" / "a.h5")
    with pytest.raises(InputError, match=r"^path: got .*cannot be written"):
        Scene(0.7, times=[1.0]).save(tmp_path)
    assert os.listdir(tmp_path) == []


def refused(path: Path, say: str) -> None:
    with pytest.raises(InputError, match=rf"^path: got '.*; .*{say}") as caught:
        load(path)
    assert "\n" not in str(caught.value)


def test_damage_is_noticed(tmp_path: Path) -> None:
    """Every flipped bit, and every missing end: HDF5 itself does not notice, or does not end."""
    path, broken = tmp_path / "a.h5", tmp_path / "b.h5"
    VALUES["solution"]().save(path)
    whole = path.read_bytes()
    random = np.random.default_rng(1)
    for place in random.integers(0, 8 * len(whole), 60):
        damaged = bytearray(whole)
        damaged[place // 8] ^= 1 << (place % 8)
        broken.write_bytes(damaged)
        refused(broken, "damaged|no file that kinetics saved|version")
    for length in (0, 10, 512, len(whole) - 1):
        broken.write_bytes(whole[:length])
        refused(broken, "damaged|no file that kinetics saved")


def test_other_files(tmp_path: Path) -> None:
    refused(tmp_path / "none.h5", "No such file")
    refused(tmp_path, "cannot be read")
    (tmp_path / "a.csv").write_text("time,x\n0,1\n")
    refused(tmp_path / "a.csv", "no file that kinetics saved")
    with h5py.File(tmp_path / "b.h5", "w") as file:
        file["x"] = 1.0
    refused(tmp_path / "b.h5", "no file that kinetics saved")


def sealed(path: Path, header: str = "inelastic-lorentz kinetics version 1 sha256") -> None:
    """Give a changed file a header that fits."""
    data = path.read_bytes()[512:]
    text = f"{header} {hashlib.sha256(data).hexdigest()}\n"
    path.write_bytes(text.encode().ljust(512, b"\0") + data)


def test_another_version_and_another_class(tmp_path: Path) -> None:
    path = tmp_path / "a.h5"
    Scene(0.7, times=[1.0]).save(path)
    sealed(path)
    assert load(path) == Scene(0.7, times=[1.0])
    sealed(path, "inelastic-lorentz kinetics version 2 sha256")
    refused(path, "version 2 of the format, this program reads version 1")
    sealed(path, "something else version 1 sha256")
    refused(path, "no file that kinetics saved")
    with h5py.File(path, "r+") as file:
        file["value"].attrs["class"] = "Unknown"
    sealed(path)
    refused(path, "'Unknown', which is not known here")


def test_missing_and_surplus_parts(tmp_path: Path) -> None:
    path = tmp_path / "a.h5"
    for change in ("delete", "add", "kind", "value"):
        VALUES["solution"]().save(path)
        with h5py.File(path, "r+") as file:
            if change == "delete":
                del file["value/rtol"]
            elif change == "add":
                file["value/more"] = 1.0
                file["value/more"].attrs["kind"] = "float"
            elif change == "kind":
                file["value/rtol"].attrs["kind"] = "other"
            else:
                del file["value"]
        sealed(path)
        refused(path, "damaged")


def test_data_that_are_not_in_the_file_are_not_read(tmp_path: Path) -> None:
    """Of another file, or promised only: a dataset of 1e12 numbers of which none is stored."""
    path, other = tmp_path / "a.h5", tmp_path / "other.h5"
    with h5py.File(other, "w") as file:
        file["times"] = np.array([1.0])
        file["times"].attrs["kind"] = "array"
    layout = h5py.VirtualLayout((1,), np.float64)
    layout[0] = h5py.VirtualSource(str(other), "times", (1,))[0]
    place = "value/times"
    for change in (
        lambda file: file.create_dataset(place, shape=(10**12,), dtype=np.float64),
        lambda file: file.create_dataset(place, shape=(10**12,), dtype=np.float64, chunks=(10**6,)),
        lambda file: file.create_dataset(place, (1,), np.float64, external=[(str(other), 0, 8)]),
        lambda file: file.create_virtual_dataset(place, layout),
        lambda file: file.__setitem__(place, h5py.ExternalLink(str(other), "times")),
        lambda file: file.__setitem__(place, h5py.SoftLink("/value/number_density")),
    ):
        Scene(0.7, times=[1.0]).save(path)
        with h5py.File(path, "r+") as file:
            del file[place]
            change(file)
            if isinstance(file.get(place, getlink=True), h5py.HardLink):
                file[place].attrs["kind"] = "array"
        sealed(path)
        refused(path, "damaged")


def test_a_path_that_is_none(tmp_path: Path) -> None:
    for path in (3, "", "a\0b"):
        with pytest.raises(InputError, match=r"^path: got .*; it must be the path of a file"):
            load(path)
        with pytest.raises(InputError, match=r"^path: got .*; it must be the path of a file"):
            Scene(0.7, times=[1.0]).save(path)


def test_nothing_in_a_file_is_executed(tmp_path: Path) -> None:
    VALUES["solution with densities"]().save(tmp_path / "a.h5")

    def look(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset):
            assert item.dtype.kind in "biufcO"
            assert item.dtype.kind != "O" or h5py.check_string_dtype(item.dtype)

    with h5py.File(tmp_path / "a.h5") as file:
        file.visititems(look)
