"""Results: values, datasets, frames, plots, and files that are whole, checked and refused."""

import copy
import dataclasses
import errno
import json
import os
import pickle
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import h5py
import numpy as np
import pytest
import xarray
from example_values import TIMES, VALUES, solved, with_densities
from matplotlib.figure import Figure

from kinetics import (
    Beam,
    CollisionLaw,
    Gaussian,
    InputError,
    ScalingSolution,
    Scene,
    load,
    solve,
    solve_scaled,
    sweep,
)  # fmt: skip
from kinetics.moments.outputs import averaged_outputs
from kinetics.outputs import OUTPUTS, described
from kinetics.results.file import write_whole
from kinetics.results.value import Value

AVERAGES = tuple(name for name in OUTPUTS if name in averaged_outputs(2))
FUNCTIONS = [name for name in VALUES if name.endswith(("function", "harmonics"))]
SAVED = {name: make for name, make in VALUES.items() if name not in FUNCTIONS} | {
    "own law": lambda: Scene(
        CollisionLaw.from_samples([0.25, 0.75], [0.5, 0.9], [0.1, -0.3]), times=TIMES
    ),
    "mixture": lambda: Scene(
        CollisionLaw.mixture([1, 3], [CollisionLaw(0.5), CollisionLaw(0.9, 0.4)]), times=TIMES
    ),
    "in space": lambda: Scene(0.7, times=TIMES, initial=Beam(0.0), dimension=3),
    "by collision": lambda: solve(
        Scene(0.7, collision_numbers=[1, 2, 5])).by_collision,
    "over time in a field": lambda: solve(
        Scene(0.7, field=0.1, initial="rest", times=[1.0, 5.0], outputs="mean_velocity"), 1e-3
    ),
}  # fmt: skip


@pytest.fixture(scope="module")
def averages() -> Any:
    return solve(Scene(0.7, initial=Beam(), times=[1.0, 30.0, 1e3], outputs=AVERAGES))


@pytest.fixture(scope="module")
def densities() -> Any:
    outputs = ("speed_density", "position_density", "intermediate_scattering", "velocity_density")
    return solve(Scene(0.7, times=[30.0, 300.0], outputs=outputs, harmonics=0), 1e-4)


def refused(work: Any, *words: str) -> None:
    with pytest.raises(InputError) as caught:
        work()
    assert "\n" not in str(caught.value)
    assert all(word in str(caught.value) for word in words), str(caught.value)


@pytest.mark.parametrize("name", VALUES)
def test_equal_hashed_pickled_and_short(name: str) -> None:
    value, again = VALUES[name](), VALUES[name]()
    copies = (pickle.loads(pickle.dumps(value)), copy.copy(value))
    assert len({value, again, *copies}) == 1
    assert value == again == copies[0] == copies[1]
    assert value != object()
    lines = repr(value).splitlines()
    assert len(lines) <= 16
    assert max(map(len, lines)) <= 100


def arrays_in(thing: Any) -> list[np.ndarray]:
    """All arrays in the fields of a value, and in those of its parts."""
    if isinstance(thing, np.ndarray):
        return [thing]
    if isinstance(thing, tuple | list | Mapping):
        items = thing.values() if isinstance(thing, Mapping) else thing
        return [array for item in items for array in arrays_in(item)]
    if isinstance(thing, Value):
        return [array for part in thing.__getstate__().values() for array in arrays_in(part)]
    return []


def test_nothing_in_a_solution_can_be_changed() -> None:
    for made in (with_densities(), solved("one speed", outputs=("position_density", "msd"))):
        for solution in (made, pickle.loads(pickle.dumps(made))):
            found = [*arrays_in(solution), *solution.ballistic_front, solution.msd, solution.times]
            assert len(found) > 10
            assert not any(array.flags.writeable for array in found)
            for mapping in (solution.values, solution.stats, solution.stats["systems"]):
                with pytest.raises(TypeError):
                    mapping["msd"] = 1
            for thing in (solution, solution.scene, solution.scene.state, solution.plan[0]):
                with pytest.raises(dataclasses.FrozenInstanceError):
                    setattr(thing, dataclasses.fields(thing)[0].name, 1.0)
            assert "displacement" in vars(solution._answer)  # a copy need not solve it again


def test_different_questions_give_different_values() -> None:
    scene = Scene(0.7, times=TIMES)
    changes = (
        dict(restitution=0.6), dict(times=[0.0, 1.0, 100.5]), dict(outputs="msd"),
        dict(initial="monoenergetic"), dict(number_density=0.05), dict(harmonics=3),
    )  # fmt: skip
    others = [dataclasses.replace(scene, **change) for change in changes]
    assert len({scene, *others}) == 7
    assert scene == Scene(0.7, times=np.array(TIMES), initial=Gaussian())
    assert solve(scene) != solve(scene, rtol=1e-3)
    assert solve_scaled(0.7) != solve_scaled(0.7, 1e-8)
    assert ScalingSolution(0.7) != ScalingSolution(0.8)


# -- datasets, frames and plots -------------------------------------------------------------------


def test_a_dataset_says_what_was_asked_and_reached(averages: Any, tmp_path: Path) -> None:
    found = averages.to_xarray()
    for name, values in averages.values.items():
        np.testing.assert_array_equal(found[name], values)
        assert found[name].attrs["units"] and found[name].attrs["long_name"]  # noqa: PT018
    assert found.msd.attrs["units"] == "d^2"
    assert found.velocity_tensor.dims == ("time", "component", "component2")
    assert found.attrs["status"] == "converged"
    assert found.attrs["tolerance_asked"] == averages.rtol
    assert found.attrs["tolerance_reached"] == averages.error_estimate
    scene = json.loads(found.attrs["scene"])
    assert (scene["restitution"], scene["times"]) == (0.7, [1.0, 30.0, 1e3])
    assert scene["initial"]["class"] == "Beam"
    found["msd"][0] = 7.0  # a copy
    averages.save(tmp_path / "a.nc")
    with xarray.open_dataset(tmp_path / "a.nc", engine="h5netcdf") as saved:  # any program reads it
        assert saved.msd.values.tolist() == averages.msd.tolist()
        assert saved.msd.attrs["units"] == "d^2"
        assert saved.attrs["status"] == "converged"


def test_functions_are_at_the_points_that_are_asked_for(densities: Any, averages: Any) -> None:
    v, r, big, k = [0.1, 0.2], [1.0, 5.0, 9.0], [0.5, 1.0], [0.01]
    found = densities.to_xarray(speeds=v, radii=r, scaled_radii=big, wave_numbers=k, angles=[0.0])
    for name, points in {
        "speed_density": (v,), "position_density": (r,), "velocity_density": (v, [0.0]),
        "scaled_position_density": (big,), "intermediate_scattering": (k,),
    }.items():  # fmt: skip
        np.testing.assert_array_equal(found[name], getattr(densities, name)(*points))
    scene = dataclasses.replace(averages.scene, outputs="intermediate_scattering")
    found = (solution := solve(scene)).to_xarray(wave_numbers=k, direction=0.5)
    f = solution.intermediate_scattering(k, 0.5)
    np.testing.assert_array_equal(found.intermediate_scattering_real, f.real)
    np.testing.assert_array_equal(found.intermediate_scattering_imag, f.imag)
    axes = solution.plot("intermediate_scattering", ax=Figure().subplots(), direction=0.5)
    real, imaginary = axes.lines[:3], axes.lines[3:]
    assert [one.get_color() for one in real] == [one.get_color() for one in imaginary]


def test_data_frames(averages: Any, densities: Any) -> None:
    frame = averages.to_dataframe()
    assert frame.time.tolist() == [1.0, 30.0, 1e3]
    assert frame.msd.tolist() == averages.msd.tolist()
    assert frame.mean_velocity_x.tolist() == averages.mean_velocity[:, 0].tolist()
    assert frame.velocity_tensor_yy.tolist() == averages.velocity_tensor[:, 1, 1].tolist()
    assert frame.attrs["units"]["thermal_speed"] == "U"
    frame = densities.to_dataframe("speed_density", speeds=[0.1, 0.2])
    assert list(frame.columns) == ["time", "v", "speed_density"]
    assert frame.time.tolist() == [30.0, 30.0, 300.0, 300.0]
    assert frame.speed_density.tolist() == densities.speed_density([0.1, 0.2]).ravel().tolist()


def test_everything_is_drawn_at_once(averages: Any, densities: Any) -> None:
    from matplotlib import pyplot

    try:
        axes = averages.plot()
        for ax, (name, values) in zip(axes, averages.values.items(), strict=True):
            drawn = [list(line.get_ydata()) for line in ax.lines]
            assert drawn == values.reshape(3, -1).T.tolist()
            assert "d/U" in ax.get_xlabel()
            assert ("[" in ax.get_ylabel()) == (described(name, 2)[0] != "1")
        for ax in densities.plot(speeds=[0.1, 0.2]):
            assert ax.lines
            legend = [text.get_text() for text in ax.get_legend().get_texts()]
            assert ["= 30 " in text for text in legend] == [True, False]
            assert ["= 300 " in text for text in legend] == [False, True]
        refused(lambda: averages.plot(ax=axes[0]), "ax", "name")
    finally:
        pyplot.close("all")


@pytest.mark.parametrize("name", ["scaled", "exact", "field", "over time in a field"])
def test_every_result_has_them_all(name: str) -> None:
    result: Any = SAVED[name]()
    found = result.to_xarray()
    assert {"title", "status", "scene", "version"} <= set(found.attrs)
    drawn = "mean_velocity" if "over time" in name else "vdf"
    assert result.plot(drawn, ax=Figure().subplots()).lines
    assert len(result.to_dataframe())


# -- files ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", SAVED)
def test_what_is_saved_comes_back(name: str, tmp_path: Path) -> None:
    value: Any = SAVED[name]()
    value.save(tmp_path / "a.h5")
    found = load(tmp_path / "a.h5")
    assert type(found) is type(value)
    assert found == value
    assert hash(found) == hash(value)
    assert not any(array.flags.writeable for array in arrays_in(found))
    if name not in ("scaled", "field"):  # these say the status of what was solved since
        assert repr(found) == repr(value)
    ask = {
        "solution with densities": lambda s: (
            s.velocity_density([0.1, 1.0], [0.3]), s.position_density([0.5]), s.uncollided,
            s.intermediate_scattering([0.1], 0.2), s.harmonic(1.5, 2),
        ),
        "rough solution": lambda s: (s.speed_density([0.1, 1.0]),),
        "scaled": lambda s: (s.cooling_rate, s.a2, s.vdf(1.0)),
        "field": lambda s: (s.drift, s.moment(2.5, 1), s.vdf([1.0], [0.5])),
    }.get(name, lambda s: ())  # fmt: skip
    for one, other in zip(ask(found), ask(value), strict=True):
        np.testing.assert_array_equal(one, other)


def test_a_loaded_number_is_the_one_that_was_saved(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Read from the file, not solved again by whatever version reads it."""
    vdf, state = solve_scaled(0.7, 1e-8), VALUES["field"]()
    vdf.save(tmp_path / "a.h5")
    state.save(tmp_path / "b.h5")
    monkeypatch.setattr("kinetics.scaling.scaled_vdf.ScaledSpeedAxis", None)
    monkeypatch.setattr("kinetics.driven.steady_state.SteadySolution", None)
    found = load(tmp_path / "a.h5")
    assert (found.cooling_rate, found.a2) == (vdf.cooling_rate, vdf.a2)
    assert load(tmp_path / "b.h5").drift == state.drift


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_function_cannot_be_saved(name: str, tmp_path: Path) -> None:
    refused(lambda: VALUES[name]().save(tmp_path / "a.h5"), "function", "SpeedTable")
    assert os.listdir(tmp_path) == []


def test_damage_and_other_files_are_refused(tmp_path: Path) -> None:
    path, bad = tmp_path / "a.h5", tmp_path / "b.h5"
    (value := VALUES["solution"]()).save(path)
    whole = path.read_bytes()
    noticed = 0
    for place in np.random.default_rng(1).integers(0, 8 * len(whole), 100):
        damaged = bytearray(whole)
        damaged[place // 8] ^= 1 << (place % 8)
        bad.write_bytes(damaged)
        try:
            assert load(bad) == value  # a byte that nothing is read from
        except InputError:
            noticed += 1
    assert noticed > 10
    for contents in (b"", b"time,x\n0,1\n", whole[: len(whole) // 2]):
        bad.write_bytes(contents)
        refused(lambda: load(bad), "b.h5")
    for name in ("none.h5", "", "a\0b"):
        refused(lambda n=name: load(tmp_path / n), "path")
    refused(lambda: load(3), "path")


def rewritten(path: Path, change: Any) -> None:
    """Give a saved file another record."""
    with h5py.File(path, "r+") as file:
        record = json.loads(file["record"][()].tobytes())
        del file["record"]
        change(record, file)
        if "record" not in file:
            file["record"] = np.frombuffer(json.dumps(record).encode(), np.uint8)


HARM = {
    "a module": lambda r, f: r["value"].update({"class": "os"}),
    "a function": lambda r, f: r["value"].update({"class": "solve"}),
    "another format": lambda r, f: r.update(format="inelastic-lorentz kinetics 99"),
    "a missing part": lambda r, f: r["value"].pop("rtol"),
    "more parts": lambda r, f: r["value"].update(more=1),
    "a bad scene": lambda r, f: r["value"]["scene"].update(restitution=7),
    "no record": lambda r, f: f.update(record=np.zeros(0, np.uint8)),
    "another file": lambda r, f: f.create_dataset(
        "record", (24,), "u1", external=[("/etc/hostname", 0, 24)]
    ),
    "a link": lambda r, f: f.update({"record": h5py.ExternalLink("whole.h5", "record")}),
    "too much": lambda r, f: f.create_dataset("record", (10**13,), "u1", chunks=(9,)),
}


@pytest.mark.parametrize("name", HARM)
def test_files_that_were_made_to_do_harm(name: str, tmp_path: Path) -> None:
    for file in ("a.h5", "whole.h5"):
        VALUES["solution"]().save(tmp_path / file)
    rewritten(tmp_path / "a.h5", HARM[name])
    refused(lambda: load(tmp_path / "a.h5"), "a.h5")


def test_a_file_is_whole_or_as_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Other interruptions: tests/crosscheck/test_files.py."""
    write_whole({str(tmp_path / "a.h5"): b"before"})
    monkeypatch.setattr(os, "replace", Mock(side_effect=OSError(errno.ENOSPC, "No space left")))
    refused(lambda: Scene(0.5, times=[2.0]).save(tmp_path / "a.h5"), "No space left")
    assert (tmp_path / "a.h5").read_bytes() == b"before"
    assert os.listdir(tmp_path) == ["a.h5"]


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has none of these")
def test_links_are_followed_and_nothing_but_files_is_written(tmp_path: Path) -> None:
    scene = Scene(0.5, times=[2.0])
    (tmp_path / "link").symlink_to("target")
    scene.save(tmp_path / "link")
    assert (tmp_path / "link").is_symlink()
    assert load(tmp_path / "target") == load(tmp_path / "link") == scene
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "null").symlink_to("/dev/null")
    for name in ("pipe", "null", "", os.path.join("none", "a.h5")):
        refused(lambda n=name: scene.save(tmp_path / n), "path")
        refused(lambda n=name: load(tmp_path / n), "path")


def test_a_sweep_has_the_restitution_as_a_dimension() -> None:
    asked: Any = {"times": [1.0, 50.0], "outputs": ("msd", "mean_velocity"), "initial": Beam(0.3)}
    found = sweep([0.9, 0.2], 1e-8, **asked)
    assert dict(found.sizes) == {"restitution": 2, "time": 2, "component": 2}
    for e in (0.9, 0.2):
        alone = solve(Scene(e, **asked), 1e-8)
        np.testing.assert_array_equal(found.msd.sel(restitution=e), alone.msd)
        np.testing.assert_array_equal(found.mean_velocity.sel(restitution=e), alone.mean_velocity)
    assert found.msd.attrs["units"] == "d^2"
    assert found.status.values.tolist() == ["converged"] * 2
    for wrong in ([], [1.2], "a"):
        with pytest.raises(InputError, match="restitution"):
            sweep(wrong, **asked)
