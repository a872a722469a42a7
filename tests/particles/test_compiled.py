"""Compiled code on disk is not used after a change to any file that it is made of."""

import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numba
import pytest

import particles

PROGRAM = """
import numpy as np
from particles import BoltzmannGrad, simulate
from particles.kernel.random_flights import follow_random_flights as kernel
e = simulate(BoltzmannGrad(0.04), 0.5, times=[50.0], media=2, tracers=9, workers=1)
print(e.thermal_speed.value[0], sum(kernel.stats.cache_hits.values()))
"""


def copied(folder: Path) -> Path:
    source, copy = Path(particles.__file__).parent, folder / "particles"
    shutil.copytree(source, copy, ignore=shutil.ignore_patterns("__pycache__"))
    return copy


def run(folder: Path, program: str, **environment: str) -> "subprocess.CompletedProcess[str]":
    """What a new process says that imports the copy in this folder."""
    kept = {k: v for k, v in os.environ.items() if k not in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME")}
    kept |= {"PYTHONPATH": str(folder)} | environment
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=folder, env=kept, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return done


@pytest.mark.slow
def test_a_change_in_another_file_than_the_kernels_is_compiled(tmp_path: Path) -> None:
    events = copied(tmp_path) / "events.py"
    before, hits = map(float, run(tmp_path, PROGRAM).stdout.split())
    assert hits == 0
    assert [*map(float, run(tmp_path, PROGRAM).stdout.split())] == [before, 1]
    text, line = events.read_text(encoding="utf-8"), "    return along, ratio"
    assert text.count(line) == 1
    events.write_text(text.replace(line, "    return along, 0.5 * ratio"), encoding="utf-8")
    after, hits = map(float, run(tmp_path, PROGRAM).stdout.split())
    assert hits == 0
    assert after < before


def test_where_compiled_code_cannot_be_kept_it_is_compiled_in_every_process(
    tmp_path: Path,
) -> None:
    """As for a user without a home, in a read-only installation; a file keeps root out as well."""
    for file in copied(tmp_path).rglob("__init__.py"):
        (file.parent / "__pycache__").write_text("")
    (tmp_path / "home").write_text("")
    program = "import particles.placement, particles.kernel.random_flights"
    said = run(tmp_path, program, HOME=str(tmp_path / "home")).stderr
    assert said.count("Warning") == 1
    assert "compiled code cannot be kept (no folder for it can be written)" in said


def three(monkeypatch: pytest.MonkeyPatch, folder: Path) -> int:
    """What a small compiled function returns, compiled and kept as by a new process."""
    file = folder / "small.py"
    if not file.exists():  # some versions of numba compile again what is written again
        file.write_text("from particles.compiled import kernel\n@kernel\ndef three(): return 3\n")
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(folder / "kept"))
    loader = importlib.util.spec_from_file_location("small", file)
    module = importlib.util.module_from_spec(loader)
    loader.loader.exec_module(module)
    assert module.three() == 3
    return sum(module.three.stats.cache_hits.values())


def test_damaged_files_of_compiled_code_are_made_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for kind in ("nbi", "nbc"):
        assert three(monkeypatch, tmp_path) == (kind == "nbc")
        assert three(monkeypatch, tmp_path) == 1
        for file in tmp_path.rglob(f"*.{kind}"):
            file.write_bytes(b"")
        assert three(monkeypatch, tmp_path) == 0
        assert three(monkeypatch, tmp_path) == 1
