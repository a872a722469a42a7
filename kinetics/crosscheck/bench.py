"""The benchmark: run time of the solver against its error, and of the particles.

`bench_problems.problems` is the table of what is solved; a piece of `Work` is one problem at one
setting, of which `measure` makes a row, a dictionary; `BenchReport` makes tables of the rows.
"""

import math
import os
import platform
import re
import time
import warnings
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

import numpy as np
from pandas import DataFrame
from threadpoolctl import threadpool_limits

from kinetics.crosscheck.bench_problems import (
    CASES,
    FULL,
    MEDIA,
    PARTICLES,
    PLACING,
    PRECISION,
    QUICK,
    RUN,
    SPECTRAL,
    Effort,
    FloatArray,
    Work,
    works,
)
from kinetics.crosscheck.files import dumps, markdown_table
from kinetics.errors import InputError, ToleranceWarning, suggestion

#: A row of the benchmark, as the JSON document holds it.
Row = dict[str, object]
#: Returns seconds since some moment: of the processor, or of the wall clock.
Clock = Callable[[], float]

#: Name of the JSON document and number of its format, which rises when its fields change.
FORMAT = "inelastic-lorentz bench 3"
#: Status of a row that has a time.
MEASURED = "measured"
#: Status of a row whose work raised an error.
FAILED = "failed"
#: Relative error, as of a figure or a comparison with data, whose run time is tabulated. The origin
#: of the number is not recorded.
COARSE_TARGET = 1e-3
#: Relative error, as of a reference for other methods, whose run time is tabulated. The origin of
#: the number is not recorded.
FINE_TARGET = 1e-8
#: Seconds of the first call from which on work is repeated once. The origin is not recorded.
LONG_WORK = 1.0
#: Characters of a note that are kept. Chosen: a note is a cell of a table.
MAX_NOTE = 200


# -- measuring -------------------------------------------------------------------------------------
class Stopwatch:
    """Times of repeated calls: of the processor, and of the clock."""

    def __init__(self, processor: Clock, wall: Clock) -> None:
        self.processor = processor
        self.wall = wall
        self.times: list[tuple[float, float]] = []

    def call(self, work: Callable[[], object]) -> object:
        """Call the work and add its times."""
        processor_begin = self.processor()
        wall_begin = self.wall()
        result = work()
        processor_time = self.processor() - processor_begin
        self.times.append((processor_time, self.wall() - wall_begin))
        return result

    @property
    def repeats(self) -> FloatArray:
        """Times of all calls but the first, which may compile, (n, 2)."""
        return np.array(self.times[1:]).reshape(-1, 2)

    def needs_more(self, effort: Effort) -> bool:
        """Return whether work is to be called once more."""
        repeats = self.repeats
        if len(repeats) and repeats[-1, 1] > LONG_WORK:
            return False
        if len(self.times) <= effort.min_repeats:
            return True
        is_short = repeats[:, 1].sum() < effort.seconds
        return bool(is_short and len(self.times) <= effort.max_repeats)


def measure(
    work: Work,
    effort: Effort,
    clocks: tuple[Clock, Clock] = (time.process_time, time.perf_counter),
) -> Row:
    """Return the row of a piece of work, also if it fails.

    clocks : of the processor, and on the wall
    """
    stopwatch = Stopwatch(*clocks)
    error: float | None = None
    note = ""
    try:
        while stopwatch.needs_more(effort):
            result = stopwatch.call(work.call)
            if work.error is not None and error is None:
                error = work.error(result)
                if not math.isfinite(error):
                    raise ArithmeticError("the answer is not finite")
    except Exception as failure:  # whatever it is, it is a row
        note = " ".join(f"{type(failure).__name__}: {failure}".split())[:MAX_NOTE]
    row: Row = {
        "section": work.section,
        "problem": work.problem,
        "method": work.method,
        "setting": work.setting,
        "value": work.value,
    }
    has_failed = bool(note)
    row |= _times_of(stopwatch, work.threads, has_failed)
    row |= {
        "error": None if has_failed else error,
        "asked": work.value if work.setting == "rtol" else None,
        "status": FAILED if has_failed else MEASURED,
        "note": note,
        "threads": work.threads,
        "extra": {},
    }
    return row


def _times_of(stopwatch: Stopwatch, threads: int, has_failed: bool) -> Row:
    """Return the columns of a row that are times: quartiles of the repeats."""
    repeats = stopwatch.repeats
    columns: Row = dict.fromkeys(("seconds", "low", "high", "wall", "warm_up"))
    if not has_failed:
        processor, wall = np.percentile(repeats, [25, 50, 75], axis=0).T
        low, median, high = processor if threads == 1 else wall
        columns["seconds"] = float(median)
        columns["low"] = float(low)
        columns["high"] = float(high)
        columns["wall"] = float(wall[1])
        columns["warm_up"] = stopwatch.times[0][1]
    columns["repeats"] = len(repeats)
    return columns


def ignore_progress(case: str, total: int) -> None:
    """Take the name of a case and their number, and do nothing."""


def run_bench(
    quick: bool = False,
    cases: Iterable[str] | None = None,
    progress: Callable[[str, int], None] = ignore_progress,
) -> "BenchReport":
    """Measure everything, or the named cases.

    progress : called with the name of each case and their number
    """
    names = tuple(CASES if cases is None else cases)
    for name in names:
        if name not in CASES:
            near = suggestion(name, CASES)
            raise InputError(f"cases: got {name!r}; known are {', '.join(CASES)}{near}")
    effort = QUICK if quick else FULL
    about = describe_machine()
    begin = time.perf_counter()
    records: list[Row] = []
    with threadpool_limits(1), warnings.catch_warnings():
        warnings.simplefilter("ignore", ToleranceWarning)  # the error is measured
        for name in names:
            progress(name, len(names))
            for work in works(name, effort):
                records.append(measure(work, effort))
    return BenchReport(records, quick, names, about, time.perf_counter() - begin)


def describe_machine() -> Row:
    """Return what a time depends on, the processor and versions; nothing that names the machine."""
    info = Path("/proc/cpuinfo")
    processor = platform.machine()
    if info.exists():
        model = re.search(r"model name\s*: (.*)", info.read_text())
        if model is not None:
            processor = model[1]
    machine: Row = {
        "processor": processor,
        "cores": os.cpu_count(),
        "system": platform.system(),
        "python": platform.python_version(),
    }
    for package in ("inelastic-lorentz", "numpy", "scipy", "numba"):
        machine[package] = metadata.version(package)
    return machine


# -- tables ----------------------------------------------------------------------------------------
#: Columns of the table of all rows that hold text.
TEXTS = ["section", "problem", "method", "setting", "status", "note", "threads"]
#: Columns of the table of all rows that hold numbers: times in s, errors relative.
NUMBERS = ["value", "seconds", "error", "asked"]


@dataclass(frozen=True)
class BenchReport:
    """A whole benchmark: rows (see `measure`), the cases that were run, the machine, s in all."""

    records: list[Row]
    quick: bool
    cases: tuple[str, ...]
    machine: Row
    seconds: float

    def rows(self, section: str, status: str = MEASURED) -> DataFrame:
        """Return the rows of a section; the question is the problem without its variant."""
        frame = DataFrame(self.records, columns=[*TEXTS, *NUMBERS])
        frame = frame.astype(dict.fromkeys(NUMBERS, float))
        is_chosen = (frame["status"] == status) & frame["section"].str.startswith(section)
        frame = frame[is_chosen]
        return frame.assign(question=frame["problem"].str.split(": ").str[0])

    def to_json(self) -> str:
        """Return one strict JSON document; what is not finite is null."""
        return dumps({"format": FORMAT, **vars(self)})

    def markdown(self) -> str:
        """Return a heading, and all tables that have rows."""
        about = ", ".join(f"{name} {value}" for name, value in self.machine.items())
        heading = "# Benchmark (quick)" if self.quick else "# Benchmark"
        text = (
            f"{heading}\n\n{about}. {self.seconds:.0f} s in all. Times "
            "are medians over repeats, in s: of the processor, of two threads by the clock.\n"
        )
        failed = self.rows("", FAILED)[["problem", "method", "setting", "value", "note"]]
        tables = {
            "Run time for an error (inf: not reached)": self._run_times(),
            "Particles, e = 0.9": self._particles(),
            "Failed": failed,
        }
        for title, table in tables.items():
            if len(table):
                text += f"\n## {title}\n\n{markdown_table(table)}"
        return text

    def _run_times(self) -> DataFrame:
        """Return medians over variants; of the error over the one asked for the largest."""
        question = ["question", "method"]
        variant = [*question, "problem"]
        frame = self.rows(PRECISION)
        least_error = frame.groupby(variant, sort=False)["error"].idxmin()
        table = frame.loc[least_error].set_index(variant)[["error", "seconds"]]
        table = table.set_axis(["least error", "time to it"], axis=1)
        for target in (COARSE_TARGET, FINE_TARGET):
            reached = frame[frame["error"] <= target].groupby(variant)["seconds"].min()
            table[f"time to {target:.0e}"] = reached.reindex(table.index, fill_value=math.inf)
        table = table.groupby(question, sort=False).median()
        frame["error over asked"] = frame["error"] / frame["asked"]
        largest = frame.groupby(question)["error over asked"].max()
        return table.join(largest).reset_index()

    def _particles(self) -> DataFrame:
        """Return rates from the difference of the long run and that of one collision."""
        frame = self.rows(PARTICLES).set_index(["problem", "threads"])
        placing = frame[frame["method"] == PLACING]
        run = frame[frame["method"] == RUN]
        collisions = run["value"] - placing["value"]
        rate = collisions / (run["seconds"] - placing["seconds"])
        columns = {"placing one": placing["seconds"] / MEDIA, "collisions per second": rate}
        return DataFrame(columns).reset_index()


__all__ = ["QUICK", "SPECTRAL", "BenchReport", "Work", "measure", "run_bench"]
