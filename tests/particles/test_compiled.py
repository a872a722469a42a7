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
from particles.kernel.follow import follow as kernel
e = simulate(BoltzmannGrad(0.04), 0.5, times=[50.0], media=2, tracers=9, workers=1)
print(e.thermal_speed.value[0], sum(kernel.stats.cache_hits.values()))
"""


def run(folder: Path) -> list[float]:
    environment = os.environ | {"PYTHONPATH": str(folder)}
    environment.pop("NUMBA_CACHE_DIR", None)
    output = subprocess.run(
        [sys.executable, "-c", PROGRAM], cwd=folder, env=environment, capture_output=True,
        text=True, check=True,
    ).stdout  # fmt: skip
    return [float(word) for word in output.split()]


@pytest.mark.slow
def test_a_change_in_another_file_than_the_kernels_is_compiled(tmp_path: Path) -> None:
    shutil.copytree(
        Path(particles.__file__).parent, tmp_path / "particles",
        ignore=shutil.ignore_patterns("__pycache__"),
    )  # fmt: skip
    before, hits = run(tmp_path)
    assert hits == 0
    assert run(tmp_path) == [before, 1]
    events = tmp_path / "particles" / "events.py"
    text = events.read_text(encoding="utf-8")
    line = "    return along, ratio"
    assert text.count(line) == 1
    events.write_text(text.replace(line, "    return along, 0.5 * ratio"), encoding="utf-8")
    after, hits = run(tmp_path)
    assert hits == 0
    assert after < before


def test_where_compiled_code_cannot_be_kept_it_is_compiled_in_every_process(tmp_path: Path) -> None:
    """As for a user without a home, in a read-only installation; a file keeps root out as well."""
    source = Path(particles.__file__).parent
    copy = tmp_path / "particles"
    shutil.copytree(source, copy, ignore=shutil.ignore_patterns("__pycache__"))
    for file in copy.rglob("__init__.py"):
        (file.parent / "__pycache__").write_text("")
    (tmp_path / "home").write_text("")
    environment = os.environ | {"PYTHONPATH": str(tmp_path), "HOME": str(tmp_path / "home")}
    for name in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME"):
        environment.pop(name, None)
    done = subprocess.run(
        [sys.executable, "-c", "import particles.placement, particles.kernel.follow"],
        cwd=tmp_path, env=environment, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert done.stderr.count("Warning") == 1
    assert "compiled code cannot be kept (no folder for it can be written)" in done.stderr


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
