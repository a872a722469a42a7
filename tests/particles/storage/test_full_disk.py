"""On a full disk: one line, nothing half-written, and the run goes on when there is room."""

import errno
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from kinetics import Scene
from kinetics.crosscheck import files
from particles import Ensemble, Poisson, simulate

RUN: dict[str, Any] = dict(
    medium=Poisson(0.1, 500), restitution=0.5, times=[2.0, 50.0], media=6, tracers=8, seed=3,
    workers=1, observables=["velocities"],
)  # fmt: skip
FULL = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


@pytest.fixture(scope="module")
def whole() -> Ensemble:
    return simulate(**RUN)


def same(a: Ensemble, b: Ensemble) -> bool:
    return {k: v.tobytes() for k, v in a.arrays.items()} == {
        k: v.tobytes() for k, v in b.arrays.items()
    }


def write_until_full(calls: int) -> Callable[[int, Any], int]:
    """os.write of a disk that takes so many writes, half of the next one, and no more."""
    real, left = os.write, [calls]

    def write(descriptor: int, data: Any) -> int:
        left[0] -= 1
        if left[0] >= 0:
            return real(descriptor, data)
        if left[0] == -1 and len(data) > 1:
            return real(descriptor, memoryview(data)[: len(data) // 2])
        raise FULL

    return write


def attempt(path: Path) -> str:
    """What is said where a run fails, nothing where it comes to its end."""
    try:
        simulate(**RUN, output=path)
    except ValueError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("share", [1e-9, 1e9], ids=["file at the end", "file every time"])
def test_a_run_goes_on_after_every_write_that_failed(
    share: float, whole: Ensemble, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("particles.storage.saving.SHARE", share)
    failed = 0
    for calls in range(100):
        path = tmp_path / f"{calls}" / "run.h5"
        path.parent.mkdir()
        with monkeypatch.context() as patch:
            patch.setattr(os, "write", write_until_full(calls))
            words = attempt(path)
        if not words:
            break
        failed += 1
        assert "cannot be written (No space left on device)" in words
        assert "\n" not in words
        assert set(os.listdir(path.parent)) <= {"run.h5", "run.h5.journal"}
        again = simulate(**RUN, output=path, resume=True)
        assert same(again, whole)
        assert same(Ensemble.load(path), whole)
        assert os.listdir(path.parent) == ["run.h5"]
    assert failed >= 8  # the head of the journal, six configurations, the file


def test_a_full_disk_leaves_what_was_saved_before(
    whole: Ensemble, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "run.h5"
    whole.save(path)
    before = path.read_bytes()
    monkeypatch.setattr(os, "write", write_until_full(0))
    with pytest.raises(ValueError, match=r"run\.h5': cannot be written \(No space"):
        whole.save(path)
    assert path.read_bytes() == before
    assert os.listdir(tmp_path) == ["run.h5"]


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no limit of a file's size")
def test_a_limit_of_the_size_of_files(tmp_path: Path) -> None:
    """HDF5 ended the process with a segmentation fault where it could not close its file."""
    code = """
import resource, sys
from kinetics import Scene, SpeedTable
from particles import Poisson, load, simulate
import numpy as np
run = dict(medium=Poisson(0.1, 100), restitution=0.5, times=[2.0], media=40, tracers=40,
           workers=1, observables=["velocities"])
whole = simulate(**run)
v = np.linspace(0.0, 9.0, 4000)
scene = Scene(0.5, initial=SpeedTable(v, v * np.exp(-v * v / 2)), times=[1.0])
limit, most = resource.getrlimit(resource.RLIMIT_FSIZE)
resource.setrlimit(resource.RLIMIT_FSIZE, (16_000, most))
for work in (lambda: simulate(**run, output="run.h5"), lambda: whole.save("other.h5"),
             lambda: scene.save("scene.h5")):
    try:
        work()
    except ValueError as error:
        print(error)
resource.setrlimit(resource.RLIMIT_FSIZE, (limit, most))
assert simulate(**run, output="run.h5", resume=True) == whole
"""
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.count("(File too large)") == done.stdout.count("\n") == 3
    assert os.listdir(tmp_path) == ["run.h5"]


@pytest.mark.parametrize("name", ["fsync", "replace"])
def test_results_and_pages_are_whole_or_as_they_were(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = Scene(0.7, times=[1.0])
    scene.save(tmp_path / "a.h5")
    files.write_together(tmp_path, {"a.txt": "old"})
    before = {p.name: p.read_bytes() for p in tmp_path.iterdir()}

    def full(*arguments: Any) -> None:
        raise FULL

    monkeypatch.setattr(os, name, full)
    with pytest.raises(ValueError, match=r"cannot be written \(No space"):
        Scene(0.5, times=[1.0]).save(tmp_path / "a.h5")
    with pytest.raises(ValueError, match="cannot be written: No space left on device"):
        files.write_together(tmp_path, {"a.txt": "new"})
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == before
