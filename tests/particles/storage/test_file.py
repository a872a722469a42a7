"""Long runs: saved whole or not at all, resumed to the same bits, refused when not understood."""

import os
import re
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import h5py
import numpy as np
import pytest

import particles
from particles import BoltzmannGrad, Ensemble, HardDisks, Poisson, Positions, simulate

ARGUMENTS = dict(
    restitution=0.5, times=[0.0, 2.0, 50.0], media=12, tracers=20, seed=3, workers=1,
    observables=particles.OBSERVABLES,
)  # fmt: skip
MEDIUM = Poisson(0.1, 1000)


def same(a: Ensemble, b: Ensemble) -> bool:
    return a.arrays.keys() == b.arrays.keys() and all(
        array.shape == b.arrays[name].shape and array.tobytes() == b.arrays[name].tobytes()
        for name, array in a.arrays.items()
    )


class Stopped(Exception):
    pass


def stop_after(configurations: int) -> object:
    def progress(done: int, total: int) -> None:
        if done == configurations:
            raise Stopped

    return progress


@pytest.mark.parametrize(
    "medium",
    [
        HardDisks(0.05, 500),
        HardDisks(0.1, 300, equilibrate=3),
        Poisson(0.2, box=None),
        BoltzmannGrad(0.04, diameter=2.0),
        Positions(np.random.default_rng(1).uniform(0, 12, (12, 9, 2)) % 5, 12.0, start=(9.0, 9.0)),
    ],
)
def test_a_saved_ensemble_is_read_back_whole(medium: particles.Medium, tmp_path: Path) -> None:
    velocities = np.random.default_rng(2).normal(size=(20, 2))
    ensemble = simulate(medium, initial=velocities, **ARGUMENTS)
    path = tmp_path / "run.h5"
    ensemble.save(path)
    again = Ensemble.load(path)
    assert same(ensemble, again)
    np.testing.assert_array_equal(again.msd.error, ensemble.msd.error)
    np.testing.assert_array_equal(again.positions, ensemble.positions)
    assert again.statuses.finished == ensemble.statuses.finished
    assert again.restitution == 0.5
    assert again.medium.number_density == medium.number_density
    assert os.listdir(tmp_path) == ["run.h5"]


def test_a_stopped_run_goes_on_to_the_same_bits(tmp_path: Path) -> None:
    whole = simulate(MEDIUM, **ARGUMENTS)
    path = tmp_path / "run.h5"
    for stop in (5, 8):
        with pytest.raises(Stopped):
            simulate(MEDIUM, **ARGUMENTS, output=path, resume=True, progress=stop_after(stop))
        with h5py.File(path) as file:
            assert file.attrs["done"] == stop
        with pytest.raises(ValueError, match=f"holds {stop} of 12 configurations"):
            Ensemble.load(path)
    assert same(whole, simulate(MEDIUM, **ARGUMENTS, output=path, resume=True))
    assert same(whole, Ensemble.load(path))
    # A finished run is not run again.
    seen = []
    again = simulate(
        MEDIUM, **ARGUMENTS, output=path, resume=True, progress=lambda *p: seen.append(p)
    )
    assert same(whole, again)
    assert seen == [(12, 12)]


LONG = """
    import sys
    from particles import Poisson, simulate
    simulate(
        Poisson(0.1, 200), 0.9, times=[1.0, 1e4], media=10_000, tracers=1, seed=4, workers=2,
        observables=["displacement_histogram"], output=sys.argv[1], resume=True,
    )
"""


def done(path: Path) -> int:
    if not path.exists():
        return 0
    with h5py.File(path) as file:
        return int(file.attrs["done"])


@pytest.mark.slow
def test_a_run_killed_at_any_moment_goes_on_to_the_same_bits(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    command = [sys.executable, "-c", textwrap.dedent(LONG), str(path)]
    seen = [0]
    for k in range(3):
        process = subprocess.Popen(command)
        # Once it has come further than the last one, kill it without warning.
        while process.poll() is None and done(path) <= seen[-1]:
            time.sleep(0.005)
        time.sleep(0.007 * k)
        process.send_signal(signal.SIGKILL)
        assert process.wait() == -signal.SIGKILL, "it had finished: make the run longer"
        seen.append(done(path))
    assert seen == sorted(seen)
    assert 0 < seen[-1] < 10_000
    subprocess.run(command, check=True)
    whole = simulate(
        Poisson(0.1, 200), 0.9, times=[1.0, 1e4], media=10_000, tracers=1, seed=4,
        observables=["displacement_histogram"],
    )  # fmt: skip
    assert same(whole, Ensemble.load(path))


@pytest.fixture
def half_a_run(tmp_path: Path) -> Path:
    path = tmp_path / "run.h5"
    with pytest.raises(Stopped):
        simulate(MEDIUM, **ARGUMENTS, output=path, progress=stop_after(6))
    return path


def refused(path: Path, message: str, **changes: object) -> None:
    before = path.read_bytes()
    arguments = dict(medium=MEDIUM, **ARGUMENTS, output=path, resume=True) | changes
    with pytest.raises(ValueError, match=message) as caught:
        simulate(**arguments)
    assert "\n" not in str(caught.value)
    assert path.read_bytes() == before
    assert os.listdir(path.parent) == [path.name]


def test_an_existing_file_is_not_overwritten(half_a_run: Path) -> None:
    refused(half_a_run, r"exists; resume=True \(--resume\) would go on", resume=False)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (dict(seed=4), "holds another run, with seed = 3, not 4"),
        (dict(medium=Poisson(0.1, 1001)), "holds another run, with medium = "),
        (dict(times=[0.0, 2.0, 51.0]), "holds another run, with other times"),
        (dict(observables=None), "holds another run, with observables = "),
        (dict(initial=np.ones((20, 2))), "holds another run, with other velocities"),
    ],
)
def test_another_run_is_refused(half_a_run: Path, changes: dict, message: str) -> None:
    refused(half_a_run, re.escape(message), **changes)


def test_foreign_and_damaged_files_are_refused(half_a_run: Path) -> None:
    good = half_a_run.read_bytes()
    half_a_run.write_text("x,y\n1,2\n")
    refused(half_a_run, "is damaged, or not a saved simulation")
    half_a_run.write_bytes(b"")
    refused(half_a_run, "is damaged, or not a saved simulation")
    with h5py.File(half_a_run, "w") as file:
        file["moments"] = np.zeros(3)
    refused(half_a_run, "is not a saved simulation")
    for cut in (len(good) // 3, len(good) - 1):
        half_a_run.write_bytes(good[:cut])
        refused(half_a_run, "is damaged")
    # One flipped bit in the middle of the sums.
    half_a_run.write_bytes(good)
    with h5py.File(half_a_run) as file:
        place = file["moments"].id.get_offset()
    half_a_run.write_bytes(
        good[: place + 100] + bytes([good[place + 100] ^ 1]) + good[place + 101 :]
    )
    refused(half_a_run, "contents do not match their digest")


def test_where_a_file_cannot_be_written_nothing_is_left(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"output = .*nowhere.* cannot be written"):
        simulate(MEDIUM, **ARGUMENTS, output=tmp_path / "nowhere" / "run.h5")
    (tmp_path / "folder").mkdir()
    with pytest.raises(ValueError, match=r"folder: is a folder, not a file"):
        simulate(MEDIUM, **ARGUMENTS, output=tmp_path / "folder")
    with pytest.raises(ValueError, match=r"folder: is a folder, not a file"):
        simulate(BoltzmannGrad(0.1), 0.5, times=[1.0], media=2).save(tmp_path / "folder")
    assert os.listdir(tmp_path) == ["folder"]
    with pytest.raises(ValueError, match="resume = True: needs output"):
        simulate(MEDIUM, **ARGUMENTS, resume=True)
    with pytest.raises(ValueError, match="no such file"):
        Ensemble.load(tmp_path / "none.h5")


def test_the_layout_is_documented_and_has_units(half_a_run: Path) -> None:
    import particles.storage.file

    names = []
    with h5py.File(half_a_run) as file:
        assert set(file.attrs) == {"format", "version", "done", "plan", "digest"}
        file.visititems(lambda name, item: names.append(name))
        datasets = [n for n in names if isinstance(file[n], h5py.Dataset)]
        assert all("unit" in file[n].attrs for n in datasets)
        assert file["moments"].attrs["unit"] == "1, U^2, U^4, d^2, d^4, 1, U^2, 1"
    for name in datasets:
        parts = name.split("/")
        known = {
            "histograms": f"histograms/<name>/{parts[-1]}",
            "raw": "raw/<name>",
        }.get(parts[0], name)
        assert known in particles.storage.file.__doc__, name
