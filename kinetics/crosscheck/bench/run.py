"""run_bench(): every section in a process of its own, with its number of threads fixed."""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from kinetics.crosscheck.bench.record import Record, failed
from kinetics.crosscheck.bench.report import BenchReport
from kinetics.crosscheck.bench.timing import FULL, QUICK
from kinetics.errors import InputError

# name of a case: module, function, numbers of threads
CASES: dict[str, tuple[str, str, tuple[int, ...]]] = {
    "scaled": ("precision", "scaled", (1,)),
    "cooling": ("precision", "cooling", (1,)),
    "position": ("position", "position", (1,)),
    "accuracy": ("accuracy", "accuracy", (1,)),
    "skipping": ("skipping", "skipping", (1,)),
    "cost": ("cost", "cost", (1,)),
    "floors": ("floors", "floors", (1,)),
    "particles": ("throughput", "throughput", (1,)),
    "cores": ("cores", "cores", (1, 2)),
    "first-use": ("startup", "startup", (1,)),
}
_THREADS = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
)
_LONGEST = {True: 120.0, False: 900.0}  # s for one section of a quick and of a full run


def run_bench(
    quick: bool = False,
    cases: Iterable[str] | None = None,
    progress: Callable[[str], None] | None = None,
) -> BenchReport:
    """Measure everything, or the named cases (see `CASES`), one after another.

    progress is called with the name of each case as it starts. A case that dies is a failed row.
    Raises InputError for a case that does not exist.
    """
    names = tuple(CASES) if cases is None else tuple(dict.fromkeys(cases))
    for name in names:
        if name not in CASES:
            raise InputError(f"cases: got {name!r}; known are {', '.join(CASES)}")
    if not names:
        raise InputError(f"cases: got none; known are {', '.join(CASES)}")
    about = machine()
    begin = time.perf_counter()
    records: list[Record] = []
    for name in names:
        for threads in CASES[name][2]:
            if progress is not None:
                progress(name)
            records += _in_process(name, threads, quick)
    return BenchReport(
        records=tuple(records),
        quick=quick,
        cases=names,
        machine=about,
        seconds=time.perf_counter() - begin,
    )


def count_stages(cases: Iterable[str] | None = None) -> int:
    """How often run_bench calls its progress."""
    return sum(len(CASES[name][2]) for name in (CASES if cases is None else cases))


def _in_process(name: str, threads: int, quick: bool) -> list[Record]:
    environment = {**os.environ, **{variable: str(threads) for variable in _THREADS}}
    command = [sys.executable, "-m", "kinetics.crosscheck.bench.run", name, str(threads)]
    try:
        result = subprocess.run(
            [*command, "quick" if quick else "full"],
            env=environment,
            capture_output=True,
            text=True,
            check=False,
            timeout=_LONGEST[quick],
        )
    except subprocess.TimeoutExpired:
        why = f"not done after {_LONGEST[quick]:g} s"
        return [failed(name, "the whole case", "all", why, threads=threads)]
    if result.returncode:
        lines = result.stderr.strip().splitlines() or [f"exit status {result.returncode}"]
        return [failed(name, "the whole case", "all", lines[-1], threads=threads)]
    return [Record(**row) for row in json.loads(result.stdout)]


def run_case(name: str, threads: int, quick: bool) -> list[Record]:
    """The rows of one case, measured in this process."""
    from importlib import import_module

    module, function, choices = CASES[name]
    work = getattr(import_module(f"kinetics.crosscheck.bench.{module}"), function)
    effort = QUICK if quick else FULL
    rows: list[Record] = work(effort, threads) if len(choices) > 1 else work(effort)
    return rows


def machine() -> dict[str, Any]:
    """What a time depends on: the processor and the versions. Nothing that names the machine."""
    import importlib.metadata

    about: dict[str, Any] = {
        "processor": _processor(),
        "cores": len(os.sched_getaffinity(0))
        if hasattr(os, "sched_getaffinity")
        else os.cpu_count(),
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
    from kinetics.crosscheck.plain import dumps

    case, threads_text, effort_text = sys.argv[1:]
    rows = run_case(case, int(threads_text), effort_text == "quick")
    sys.stdout.write(dumps([row.as_dict() for row in rows]))
