"""Compiled code on disk is not used after a change to any file that it is made of."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import particles

PROGRAM = """
import numpy as np
from particles import BoltzmannGrad, simulate
from particles.kernel.free_paths import follow_free_paths as kernel
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
    line = "    ratio = sqrt("
    assert text.count(line) == 1
    events.write_text(text.replace(line, "    ratio = 0.5 * sqrt("), encoding="utf-8")
    after, hits = run(tmp_path)
    assert hits == 0
    assert after < before
