"""What the first use costs: imports, and compiling the kernels. Each in a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile

from kinetics.crosscheck.bench.record import Record, failed, not_available, timed
from kinetics.crosscheck.bench.timing import Effort, summary

SECTION = METHOD = "first use"
_CLOCK = "import time; begin = time.perf_counter(), time.process_time()\n"
_TELL = "\nprint(time.perf_counter() - begin[0], time.process_time() - begin[1])\n"
_SIMULATE = (
    "from particles import simulate, {medium}\n"
    "simulate({medium}(0.04), 0.9, max_collisions=5, media=1, tracers=1, workers=1)\n"
)
_DISKS, _FREE = (_SIMULATE.format(medium=medium) for medium in ("HardDisks", "BoltzmannGrad"))
_COMPILE = "compile time"
CASES: dict[str, tuple[str, str]] = {
    # what is timed, after what has been run before it
    "import kinetics": ("", "import kinetics"),
    "first solve after the import": (
        "from kinetics import Scene, solve\n",
        "solve(Scene(0.7, times=[1.0, 1e6], outputs=('thermal_speed', 'a2')))",
    ),
    "first solve_scaled after the import": (
        "from kinetics import solve_scaled\n",
        "solve_scaled(0.7).cooling_rate",
    ),
    "import particles": ("", "import particles"),
    "first simulate, hard disks, compiled before": ("import particles\n", _DISKS),
    "first simulate, Boltzmann-Grad, compiled before": ("import particles\n", _FREE),
    f"{_COMPILE}: first simulate, Boltzmann-Grad": ("import particles\n", _FREE),
    f"{_COMPILE}: first simulate, hard disks": ("import particles\n", _DISKS),
}


def startup(effort: Effort) -> list[Record]:
    """A row per case."""
    rows = []
    for name, (before, code) in CASES.items():
        compiles = name.startswith(_COMPILE)
        if effort.quick and compiles and code == _DISKS:
            why = "left to the full run: it takes half a minute on a busy machine"
            rows.append(not_available(SECTION, name, METHOD, why))
            continue
        # what was run before by this benchmark has read the files: the quick one has no warm-up
        repeats = 1 if compiles or effort.quick else 5
        rows.append(_case(name, before, code, repeats, compiles, not (compiles or effort.quick)))
    return rows


def _case(name: str, before: str, code: str, repeats: int, compiles: bool, warm_up: bool) -> Record:
    """Each repeat in a new process."""
    runs = []
    for _ in range(repeats + warm_up):
        with tempfile.TemporaryDirectory() as empty:
            environment = {**os.environ, "NUMBA_CACHE_DIR": empty} if compiles else None
            result = subprocess.run(
                [sys.executable, "-c", before + _CLOCK + code + _TELL],
                env=environment,
                capture_output=True,
                text=True,
                check=False,
            )
        if result.returncode:
            lines = result.stderr.strip().splitlines() or ["no message"]
            return failed(SECTION, name, METHOD, lines[-1])
        wall, cpu = map(float, result.stdout.split())
        runs.append((wall, cpu))
    kept = runs[-repeats:]
    timing = summary([wall for wall, _ in kept], [cpu for _, cpu in kept], runs[0][0])
    return timed(SECTION, name, METHOD, timing)
