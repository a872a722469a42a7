"""Runs as values, tables and files: read-only, compared, drawn; whole on disk, and resumed."""

import copy
import errno
import io
import json
import os
import pickle
import random
import subprocess
import sys
import textwrap
import time
from functools import partial
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import xarray

import particles
from particles import OBSERVABLES, BoltzmannGrad, Ensemble, HardDisks, Poisson, Positions, simulate

POSIX = pytest.mark.skipif(sys.platform == "win32", reason="Windows has none of these")
TIMES = [0.0, 1.0, 30.0, 1000.0]
HISTOGRAMS = [name for name in OBSERVABLES if name.endswith("histogram")]
SMALL: dict[str, Any] = dict(
    medium=Poisson(0.1, 500), restitution=0.5, times=[2.0, 50.0], media=6, tracers=4, seed=3,
    workers=1, observables=["velocities", "finals", "speed_histogram"],
)  # fmt: skip
OTHER = np.arange(12.0).reshape(2, 3, 2) + 1.0
ALL: dict[str, Any] = dict(bath_speed=0.5, heating=0.3, drag=0.2, field=0.1)
ALL |= dict(medium=BoltzmannGrad(0.3, dimension=3), observables=["positions", "velocities"])
STICKY: dict[str, Any] = dict(medium=BoltzmannGrad(0.3), heating=1.0, capture_speed=0.2)
DRIVES = ("bath_speed", "heating", "drag", "field", "capture_speed", "mass_ratio")
RUNS: dict[str, dict[str, Any]] = {
    "disks": dict(medium=HardDisks(0.04, 400), observables=OBSERVABLES, initial=OTHER[0]),
    "rough": dict(medium=BoltzmannGrad(0.1, 2.0), initial=OTHER, tangential_restitution=0.8),
    "spheres": dict(medium=BoltzmannGrad(0.1, dimension=3), initial="monoenergetic"),
    "field": dict(medium=BoltzmannGrad(0.1), initial="rest", field=0.1, depth=2.0),
    "positions": dict(medium=Positions([[1.0, 1.0], [4.0, 8.0]], 10.0), times=None,
                      max_collisions=9),
    "mass ratio": dict(medium=BoltzmannGrad(0.1), mass_ratio=0.5),
    "viscoelastic": dict(restitution=particles.Viscoelastic(0.3), **ALL),
    "table": dict(restitution=([0, 1], [1, 0.5]), **STICKY),
    "function": dict(restitution=lambda v: 0.5 + 0 * v, **STICKY),
    "driven": dict(**ALL),
}  # fmt: skip


@pytest.fixture(scope="module")
def ensemble() -> Ensemble:
    return simulate(
        HardDisks(0.04, 400), 0.7, times=TIMES, media=4, tracers=20, workers=1,
        observables=[*HISTOGRAMS, "positions", "velocities", "finals"],
    )  # fmt: skip


@pytest.fixture(scope="module")
def falling() -> Ensemble:
    return simulate(
        BoltzmannGrad(0.04), 0.7, "rest", times=[1.0, 9.0], media=4, tracers=20, field=0.1,
        depth=2.0, workers=1,
    )  # fmt: skip


@pytest.fixture(scope="module")
def whole() -> Ensemble:
    return simulate(**SMALL)


# -- values ---------------------------------------------------------------------------------------


def test_no_array_can_be_written(ensemble: Ensemble) -> None:
    for found in (ensemble, copy.deepcopy(ensemble), pickle.loads(pickle.dumps(ensemble))):
        assert found == ensemble
        estimates = [getattr(found, name) for name in (*OBSERVABLES[:7], *HISTOGRAMS)]
        arrays = [*found.arrays.values(), found.times, found.samples, found.positions]
        arrays += [one.value if hasattr(one, "value") else one.edges for one in estimates]
        assert not any(array.flags.writeable for array in [*arrays, found.statuses.trap_places])
        with pytest.raises(TypeError):
            found.arrays["moments"] = np.zeros(3)  # type: ignore[index]


def test_equal_runs_are_equal_and_others_are_not(whole: Ensemble) -> None:
    again = simulate(**SMALL)
    for name in ("plan", "msd", "statuses", "speed_histogram", "mean_free_path"):
        one, other = getattr(whole, name), getattr(again, name)
        assert one is not other
        assert one == other == pickle.loads(pickle.dumps(one))
        assert hash(one) == hash(other)
    assert whole != simulate(**SMALL | {"seed": 2})
    assert whole.msd != whole.a2
    disks = np.array([[1.0, 1.0], [2.0, 8.0]])
    medium = Positions(disks, 10.0)
    disks[0] = 3.0
    assert medium == Positions([[1, 1], [2, 8]], 10.0)  # type: ignore[arg-type]
    assert hash(medium) == hash(pickle.loads(pickle.dumps(medium)))
    assert medium != Positions(disks, 10.0)


# -- tables ---------------------------------------------------------------------------------------


def test_a_dataset_says_everything(ensemble: Ensemble, falling: Ensemble) -> None:
    for run in (ensemble, falling):
        found = run.to_xarray()
        written = io.BytesIO(bytes(found.to_netcdf(engine="scipy")))
        assert xarray.open_dataset(written, engine="scipy").identical(found)
        assert found.thermal_speed.attrs["units"] == "U"
        assert json.loads(found.attrs["scene"])["restitution"] == 0.7
        assert "finished" in found.attrs["status"]
        for name in {*run.outputs} - {"passage_times", "positions", "velocities", "finals"}:
            assert f"{name}_error" in found
    density, widths = found.msd, ensemble.speed_histogram.edges
    assert density.dims == ("time",)
    made = ensemble.to_xarray().speed_histogram.values * np.diff(widths)
    histogram = ensemble.speed_histogram
    total = made.sum(axis=1) + histogram.below + histogram.above
    np.testing.assert_allclose(total, 1.0, rtol=1e-12)


def test_a_data_frame_has_every_estimate_with_its_error(
    ensemble: Ensemble, falling: Ensemble
) -> None:
    frame = ensemble.to_dataframe()
    assert frame.time.tolist() == TIMES
    assert frame.msd.tolist() == ensemble.msd.value.tolist()
    assert frame.msd_error.tolist() == ensemble.msd.error.tolist()
    assert frame.attrs["units"]["msd"] == "d^2"
    frame = falling.to_dataframe()
    assert frame.dispersion_xy_error.tolist() == falling.dispersion.error[:, 0, 1].tolist()
    assert frame.passed.tolist() == falling.passed.value.tolist()
    frame = ensemble.to_dataframe("speed_histogram").sort_values(["time", "v_bin"])
    expected = ensemble.speed_histogram.density.value.ravel().tolist()
    assert frame.speed_histogram.tolist() == expected


def test_everything_is_drawn_at_once(ensemble: Ensemble, falling: Ensemble) -> None:
    from matplotlib import pyplot

    for run in (ensemble, falling):
        axes = run.plot()
        names = {*run.outputs} - {"mean_free_path", "positions", "velocities", "finals"}
        assert len(axes) == len(names - {"passage_times", "mean_passage_time"})
        assert all(ax.lines or ax.patches for ax in axes)
        refused(lambda run=run, ax=axes[0]: run.plot(ax=ax), "ax")
    pyplot.close("all")


# -- files ----------------------------------------------------------------------------------------


def refused(work: Any, *words: str) -> None:
    with pytest.raises(ValueError, match=r"\w") as caught:
        work()
    assert "\n" not in str(caught.value)
    assert all(word in str(caught.value) for word in words), str(caught.value)


@pytest.mark.parametrize("name", RUNS)
def test_every_plan_comes_back(name: str, tmp_path: Path) -> None:
    arguments = dict(restitution=0.5, times=[1.0, 9.0], media=2, tracers=3, workers=1) | RUNS[name]
    run = simulate(**arguments)
    run.save(tmp_path / "run.h5")
    again = particles.load(tmp_path / "run.h5")
    assert again == run
    assert again.plan == run.plan
    assert not any(array.flags.writeable for array in again.arrays.values())
    assert simulate(**arguments, output=tmp_path / "run.h5", resume=True) == run
    scene = json.loads(run.to_xarray().attrs["scene"])
    for drive in RUNS[name].keys() & {*DRIVES}:
        assert scene[drive] == getattr(run, drive) == RUNS[name][drive]
        assert f"{drive}={RUNS[name][drive]}" in repr(run)
    assert all(np.isfinite(path.places).all() for path in run.trajectories(3))
    if name == "driven":
        run.write_h5md(tmp_path / "run.h5md")
        with h5py.File(tmp_path / "run.h5md") as file:
            assert file["parameters/heating"][()] == 0.3
    assert "mass_ratio" not in scene or name == "mass ratio"  # JSON has no infinity


class Stopped(Exception):
    """Where a test ends a run."""


def stopped(path: Path, after: int, **changes: Any) -> None:
    def stop(done: int, total: int) -> None:
        if done == after:
            raise Stopped

    with pytest.raises(Stopped):
        simulate(**SMALL | changes, output=path, progress=stop)


@pytest.mark.parametrize("after", [0, 1, 4])
def test_an_interrupted_run_keeps_what_is_done(after: int, whole: Ensemble, tmp_path: Path) -> None:
    path, seen = tmp_path / "run.h5", []
    stopped(path, after)
    assert os.listdir(tmp_path) == ["run.h5"]
    with h5py.File(path) as file:
        assert file.attrs["done"] == after
    refused(lambda: Ensemble.load(path), f"{after} of 6")
    refused(lambda: simulate(**SMALL, output=path), "exists", "resume")
    again = simulate(**SMALL, output=path, resume=True, progress=lambda n, _: seen.append(n))
    assert seen == list(range(after, 7))
    assert again == whole == Ensemble.load(path)
    whole.save(tmp_path / "whole.h5")
    assert path.read_bytes() == (tmp_path / "whole.h5").read_bytes()


def test_a_file_is_written_while_the_run_goes_on(
    whole: Ensemble, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And what is there then is whole configurations, which a killed run goes on from."""
    path, seen = tmp_path / "run.h5", set()
    monkeypatch.setattr("particles.files.WRITING_SHARE", 1.0)

    def look(done: int, total: int) -> None:
        time.sleep(0.2)
        with h5py.File(path) as file:
            kept = int(file.attrs["done"])
            seen.add(kept)
            assert kept <= done
            assert np.array_equal(file["moments"], whole.moments[:kept])

    simulate(**SMALL, output=path, progress=look)
    assert len(seen) > 3


def test_what_a_killed_process_left_half_written_is_removed_by_resuming(tmp_path: Path) -> None:
    for name in (".run.h5.0123456789abcdef.part", ".other.h5.0123456789abcdef.part"):
        (tmp_path / name).write_bytes(b"half")
    simulate(**SMALL, output=tmp_path / "run.h5", resume=True)
    assert sorted(os.listdir(tmp_path)) == [".other.h5.0123456789abcdef.part", "run.h5"]


KILLED = """
    import sys
    from particles import Poisson, simulate
    print(flush=True)
    simulate(Poisson(0.1, 200), 0.9, times=[1.0, 1e3], media=300, tracers=1, seed=4, workers=2,
             output=sys.argv[1], resume=True, observables=["displacement_histogram", "finals"])
"""


@POSIX
@pytest.mark.parametrize("kills", [1, pytest.param(100, marks=pytest.mark.slow)])
def test_killed_at_random_moments_it_ends_with_the_same_bits(kills: int, tmp_path: Path) -> None:
    path, chance = tmp_path / "run.h5", random.Random(2)
    expected = simulate(
        Poisson(0.1, 200), 0.9, times=[1.0, 1e3], media=300, tracers=1, seed=4,
        observables=["displacement_histogram", "finals"],
    )  # fmt: skip
    for left in reversed(range(kills + 1)):
        command = [sys.executable, "-c", textwrap.dedent(KILLED), str(path)]
        with subprocess.Popen(command, stdout=subprocess.PIPE) as process:
            assert process.stdout is not None
            process.stdout.readline()
            if left:
                time.sleep(chance.uniform(0.3, 1.0))
                process.kill()
    assert process.returncode == 0
    assert os.listdir(tmp_path) == ["run.h5"]
    assert Ensemble.load(path) == expected


def test_another_run_is_not_gone_on_from(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    stopped(path, 2)
    before = path.read_bytes()
    for name, value, words in (
        ("seed", 4, ("seed = 3", "4")), ("times", [2.0, 51.0], ("times",)),
        ("medium", Poisson(0.1, 501), ("medium", "501")),
    ):  # fmt: skip
        other: Any = SMALL | {name: value}
        refused(partial(simulate, **other, output=path, resume=True), "another run", *words)
        assert path.read_bytes() == before


def test_damage_and_other_files_are_refused(whole: Ensemble, tmp_path: Path) -> None:
    path, bad = tmp_path / "run.h5", tmp_path / "bad.h5"
    whole.save(path)
    good = path.read_bytes()
    chance = np.random.default_rng(1)
    noticed = 0
    for place in chance.integers(0, 8 * len(good), 100):
        damaged = bytearray(good)
        damaged[place // 8] ^= 1 << (place % 8)
        bad.write_bytes(damaged)
        try:
            assert Ensemble.load(bad) == whole  # a byte that nothing is read from
        except ValueError:
            noticed += 1
    assert noticed > 10
    for contents in (b"", b"x,y\n1,2\n", good[: len(good) // 2]):
        bad.write_bytes(contents)
        refused(lambda: Ensemble.load(bad), "bad.h5")
        refused(lambda: simulate(**SMALL, output=bad, resume=True), "bad.h5")
    refused(lambda: Ensemble.load(tmp_path / "none.h5"), "none.h5")
    refused(lambda: Ensemble.load(3), "path")  # type: ignore[arg-type]
    bad.write_bytes(good)
    with h5py.File(bad, "r+") as file:
        file.attrs["format"] = np.bytes_("inelastic-lorentz particles 99")
    refused(lambda: Ensemble.load(bad), "bad.h5", "99", "this version reads")


@pytest.mark.parametrize("call", ["fsync", "replace"])
def test_a_full_disk_leaves_what_was_there(
    call: str, whole: Ensemble, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: Any, **__: Any) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    path = tmp_path / "run.h5"
    stopped(path, 3)
    before = path.read_bytes()
    with monkeypatch.context() as patch:
        patch.setattr(os, call, full)
        refused(lambda: whole.save(path), "cannot be written", "No space")
        refused(lambda: simulate(**SMALL, output=path, resume=True), "No space")
    assert path.read_bytes() == before
    assert simulate(**SMALL, output=path, resume=True) == whole
    assert os.listdir(tmp_path) == ["run.h5"]


@POSIX
def test_links_pipes_and_folders(whole: Ensemble, tmp_path: Path) -> None:
    (tmp_path / "link.h5").symlink_to("target.h5")
    simulate(**SMALL, output=tmp_path / "link.h5")
    whole.save(tmp_path / "link.h5")
    assert (tmp_path / "link.h5").is_symlink()
    assert Ensemble.load(tmp_path / "target.h5") == whole
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "null").symlink_to("/dev/null")
    for name in ("pipe", "null", "", os.path.join("none", "run.h5")):
        path = tmp_path / name
        for work in (
            lambda p=path: Ensemble.load(p),
            lambda p=path: whole.save(p),
            lambda p=path: simulate(**SMALL, output=p),
        ):
            refused(work)
    assert sorted(os.listdir(tmp_path)) == ["link.h5", "null", "pipe", "target.h5"]


def test_h5md(ensemble: Ensemble, whole: Ensemble, tmp_path: Path) -> None:
    ensemble.write_h5md(tmp_path / "run.h5md")
    with h5py.File(tmp_path / "run.h5md") as file:
        assert file["h5md"].attrs["version"].tolist() == [1, 1]
        group = file["particles/tracers"]
        assert np.array_equal(group["position/value"], ensemble.positions)
        assert np.array_equal(group["velocity/value"], ensemble.velocities)
        assert group["velocity/time"][()].tolist() == TIMES
        assert group["medium"][()].tolist() == [n // 20 for n in range(80)]
        assert file["parameters/restitution"][()] == 0.7
    refused(lambda: whole.write_h5md(tmp_path / "no.h5md"), "positions")


# -- files that were made to harm ------------------------------------------------------------------


def test_an_unknown_array_is_refused_unread(whole: Ensemble, tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    whole.save(path)
    with h5py.File(path, "r+") as file:
        file.create_dataset("surprise", (10**8,), "f8", chunks=(10**6,), compression="gzip")
    refused(lambda: Ensemble.load(path), "run.h5")


@pytest.mark.parametrize("name", ["plan", "moments", "raw/finals", "statuses"])
def test_arrays_are_read_from_the_file_alone(name: str, whole: Ensemble, tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    other = tmp_path / "other.h5"
    whole.save(path)
    whole.save(other)
    raw = tmp_path / "raw"
    with h5py.File(path, "r+") as file:
        numbers = file[name][()]
        del file[name]
        file[name] = h5py.ExternalLink(str(other), f"/{name}")
    refused(lambda: Ensemble.load(path), "run.h5")
    raw.write_bytes(numbers.tobytes())
    with h5py.File(path, "r+") as file:
        del file[name]
        external = [(str(raw), 0, numbers.nbytes)]
        file.create_dataset(name, numbers.shape, numbers.dtype, external=external)
    refused(lambda: Ensemble.load(path), "run.h5")
    with h5py.File(path, "r+") as file:
        del file[name]
        layout = h5py.VirtualLayout(numbers.shape, numbers.dtype)
        layout[...] = h5py.VirtualSource(str(other), name, numbers.shape)
        file.create_virtual_dataset(name, layout)
    refused(lambda: Ensemble.load(path), "run.h5")


@pytest.mark.parametrize("change", ["declared", "shape", "type", "done"])
def test_arrays_of_other_sizes_than_the_plan_are_refused(
    change: str, whole: Ensemble, tmp_path: Path
) -> None:
    path = tmp_path / "run.h5"
    whole.save(path)
    with h5py.File(path, "r+") as file:
        moments = file["moments"][()]
        if change == "done":
            file.attrs["done"] = 10**9
        else:
            del file["moments"]
        if change == "declared":
            file.create_dataset("moments", (10**6, *moments.shape[1:]), "f8", chunks=True)
        elif change == "shape":
            file["moments"] = moments[:-1]
        elif change == "type":
            file["moments"] = moments.astype(np.complex128)
    refused(lambda: Ensemble.load(path), "run.h5")


def test_a_run_that_is_larger_than_the_memory_is_refused_before_it_is_read(
    whole: Ensemble, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "run.h5"
    whole.save(path)
    monkeypatch.setattr("particles.files.machine_memory", lambda: 1e4)
    refused(lambda: Ensemble.load(path), "run.h5", "memory")


def test_a_file_that_another_program_has_packed_is_read(whole: Ensemble, tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    whole.save(path)
    with h5py.File(path, "r+") as file:
        for name in ("moments", "raw/velocities"):
            numbers = file[name][()]
            del file[name]
            file.create_dataset(name, data=numbers, compression="gzip")
    assert Ensemble.load(path) == whole
