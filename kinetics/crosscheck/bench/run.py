"""run_bench(): every case in a process of its own, whose linear algebra has one thread."""

from __future__ import annotations

import importlib.metadata
import json
import os
import platform
import subprocess
import sys
import time
from collections.abc import Callable, Iterable
from dataclasses import asdict
from importlib import import_module
from pathlib import Path
from typing import Any

from kinetics.crosscheck.bench.measuring import FULL, QUICK
from kinetics.crosscheck.bench.record import Record, failed
from kinetics.crosscheck.bench.report import BenchReport
from kinetics.errors import InputError

# name of a case: module and function
CASES = {
    "scaled": "precision.scaled",
    "cooling": "precision.cooling",
    "position": "position.position",
    "field": "field.field",
    "accuracy": "accuracy.accuracy",
    "skipping": "skipping.skipping",
    "cost": "cost.cost",
    "particles": "throughput.throughput",
}
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
_LONGEST = {True: 120.0, False: 900.0}  # s for one case of a quick and of a full run


def run_bench(
    quick: bool = False,
    cases: Iterable[str] | None = None,
    progress: Callable[[str, int], None] | None = None,
) -> BenchReport:
    """Measure everything, or the named cases (see `CASES`), one after another.

    progress(name of the case, number of cases) is called as each of them starts. A case that dies
    is a failed row. Raises InputError for a case that does not exist.
    """
    names = tuple(CASES) if cases is None else tuple(dict.fromkeys(cases))
    for wrong in [repr(name) for name in names if name not in CASES] or ([] if names else ["none"]):
        raise InputError(f"cases: got {wrong}; known are {', '.join(CASES)}")
    about = machine()
    begin = time.perf_counter()
    records: list[Record] = []
    for name in names:
        if progress is not None:
            progress(name, len(names))
        records += _in_process(name, quick)
    return BenchReport(tuple(records), quick, names, about, time.perf_counter() - begin)


def _in_process(name: str, quick: bool) -> list[Record]:
    command = [sys.executable, "-m", "kinetics.crosscheck.bench.run", name]
    try:
        result = subprocess.run(
            [*command, "quick" if quick else "full"],
            env={**os.environ, **dict.fromkeys(_THREADS, "1")},
            capture_output=True,
            text=True,
            check=False,
            timeout=_LONGEST[quick],
        )
    except subprocess.TimeoutExpired:
        return [failed(name, "the whole case", "all", f"not done after {_LONGEST[quick]:g} s")]
    if result.returncode:
        lines = result.stderr.strip().splitlines() or [f"exit status {result.returncode}"]
        return [failed(name, "the whole case", "all", lines[-1])]
    return [Record(**row) for row in json.loads(result.stdout)]


def run_case(name: str, quick: bool) -> list[Record]:
    """The rows of one case, measured in this process."""
    module, function = CASES[name].split(".")
    work = getattr(import_module(f"kinetics.crosscheck.bench.{module}"), function)
    rows: list[Record] = work(QUICK if quick else FULL)
    return rows


def machine() -> dict[str, Any]:
    """What a time depends on: the processor and the versions. Nothing that names the machine."""
    known = hasattr(os, "sched_getaffinity")
    about: dict[str, Any] = {
        "processor": _processor(),
        "cores": len(os.sched_getaffinity(0)) if known else os.cpu_count(),
        "system": platform.system(),
        "python": platform.python_version(),
    }
    for package in ("inelastic-lorentz", "numpy", "scipy", "numba"):
        try:
            about[package] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            about[package] = "not installed"
    if hasattr(os, "getloadavg"):
        about["load_before"] = round(os.getloadavg()[0], 2)
    return about


def _processor() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


if __name__ == "__main__":
    from kinetics.crosscheck.strict_json import dumps

    rows = run_case(sys.argv[1], sys.argv[2] == "quick")
    sys.stdout.write(dumps([asdict(row) for row in rows]))
