"""The benchmark: run time of the solver against its error, and of the particles.

`problems` is the table of what is solved; a piece of `Work` is one problem at one setting, of which
`measure` makes a row, a dictionary; `BenchReport` makes tables of the rows.

Errors are relative to references of 1e-12 or better; of G(R), <r^2> among hard disks and driven
tracers, of which nothing else is known, to a tighter solution.
"""

import math
import os
import platform
import re
import time
import warnings
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from importlib import metadata
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pandas import DataFrame
from threadpoolctl import threadpool_limits

import particles as p
from kinetics import ScalingSolution, Scene, solve, solve_field, solve_scaled, solve_steady
from kinetics.crosscheck import references
from kinetics.crosscheck.files import dumps, markdown_table, plain
from kinetics.errors import InputError, ToleranceWarning

FloatArray = NDArray[np.float64]
Row = dict[str, Any]

FORMAT = "inelastic-lorentz bench 3"
MEASURED, FAILED = "measured", "failed"
SPECTRAL = "spectral"

DENSITY = 0.04  # scatterers per d^2, of the paper: l = MEAN_FREE_PATH
E = 0.7
CASES = ("scaled", "cooling", "position", "field", "driven", "particles")
TOLERANCES = tuple(10.0**-k for k in range(2, 13))
SPEEDS = np.linspace(0.1, 4.0, 391)  # c at which F(c) is compared
RADII = np.linspace(0.0, 6.0, 200)  # R at which G(R) is compared

# -- measuring ------------------------------------------------------------------------------------


class Effort(NamedTuple):
    """How much is measured: in s how long work is repeated for, between the least and the most."""

    quick: bool = True
    least: int = 5
    most: int = 11
    seconds: float = 0.04
    restitutions: tuple[float, ...] = (E,)


QUICK = Effort()
FULL = Effort(False, 10, 25, 0.12, (E, 0.95))


@dataclass
class Work:
    """One row that is to be measured."""

    section: str
    problem: str
    method: str
    call: Callable[[], Any]
    setting: str = ""
    value: float | None = None
    error: Callable[[Any], float] | None = None  # of the result; None where only the time counts
    threads: int = 1  # the time of one is the processor's, of more that of the clock


def measure(
    work: Work, effort: Effort,
    clocks: tuple[Callable[[], float], ...] = (time.process_time, time.perf_counter),
) -> Row:  # fmt: skip
    """The row of a piece of work, also if it fails; the first call may compile, and is no time."""
    errors: list[float] = []
    times, note = np.empty((0, 2)), ""
    try:
        while len(times) <= effort.least or (
            len(times) <= effort.most and times[1:, 1].sum() < effort.seconds
        ):
            begin = [clock() for clock in clocks]
            result = work.call()
            times = np.vstack([times, np.subtract([clock() for clock in clocks], begin)])
            if work.error and not errors:
                errors.append(work.error(result))
            if not np.all(np.isfinite(errors)):
                raise ArithmeticError("the answer is not finite")
            if len(times) > 1 and times[-1, 1] > 1.0:  # s: such long work is repeated once
                break
    except Exception as met:  # whatever it is, it is a row
        note = " ".join(f"{type(met).__name__}: {met}".split())[:200]
    done = len(times) > 1 and not note
    measured = times[1:] if done else np.full((1, 2), np.nan)
    cpu, wall = np.percentile(measured, [25, 50, 75], axis=0).T
    low, median, high = cpu if work.threads == 1 else wall
    error = errors[0] if done and errors else None
    return plain({
        "section": work.section, "problem": work.problem, "method": work.method,
        "setting": work.setting, "value": work.value, "seconds": median, "low": low, "high": high,
        "wall": wall[1], "warm_up": times[0, 1] if done else None, "repeats": len(times[1:]),
        "error": error, "asked": work.value if work.setting == "rtol" else None,
        "status": FAILED if note else MEASURED, "note": note, "threads": work.threads, "extra": {},
    })  # fmt: skip


# -- problems: run time against error -------------------------------------------------------------
def relative(value: Any, exact: Any) -> float:
    """The largest relative error."""
    with np.errstate(all="ignore"):
        return float(np.max(np.abs(np.asarray(value) / np.asarray(exact) - 1.0)))


def over_largest(value: Any, exact: Any) -> float:
    """The largest difference over the largest value."""
    return float(np.max(np.abs(value - exact)) / np.max(exact))


class Problem(NamedTuple):
    """What is solved for each of the tolerances, and compared with the exact values."""

    case: str
    name: str  # the question, and after ": " its variant
    solve_to: Callable[[float], FloatArray]
    exact: Any  # a number: the rtol of a solution that is taken for exact
    error: Callable[..., float] = relative
    tolerances: tuple[float, ...] = TOLERANCES


def averages(names: Iterable[str], solver: Callable[..., Any], *asked: Any, **more: Any) -> Any:
    """A function of rtol that gives averages of what solver(*asked, **more, rtol=rtol) gives."""

    def found(rtol: float) -> FloatArray:
        result = solver(*asked, **more, rtol=rtol)
        return np.array([getattr(result, n) + (n == "a2") for n in names])  # 1 + a2 is never 0

    return found


def problems(effort: Effort) -> Iterator[Problem]:
    """Every problem; nothing is solved yet."""
    for e in effort.restitutions:
        vdf = lambda rtol, e=e: solve_scaled(e, rtol).vdf(SPEEDS)  # noqa: E731
        known = ScalingSolution(e).vdf(SPEEDS)
        yield Problem("scaled", f"scaled F(c): e = {e:g}", vdf, known, over_largest)
    kept = (
        ("cooling", "v0(t), a2(t)", ("thermal_speed", "a2"), "short"),
        ("cooling", "v0(t), a2(t)", ("thermal_speed", "a2"), "long"),
        ("position", "<r^2>(t)", ("msd",), "short"),
        ("position", "kurtosis(t)", ("kurtosis",), "short"),
    )
    variants = product(kept, effort.restitutions, references.STARTS)
    for (case, name, outputs, to), e, start in variants:
        times = references.times(to)
        scene = Scene(e, DENSITY, initial=start, times=times, outputs=outputs)
        exact = [references.kept(n, e, start, to) + (n == "a2") for n in outputs]
        name = f"{name}, t <= {times[-1]:.0e}: {start}, e = {e:g}"
        yield Problem(case, name, averages(outputs, solve, scene), exact)
    disks = Scene(E, DENSITY, times=np.geomspace(1.0, 1e8, 100), outputs=("msd",),
                  scatterers="hard disks")  # fmt: skip
    solver = averages(("msd",), solve, disks)
    name = "<r^2>(t) among hard disks, t <= 1e+08: e = 0.7"
    yield Problem("position", name, solver, 1e-13, tolerances=TOLERANCES[:-2])
    place = Scene(0.6, DENSITY, times=[300.0], outputs=("position_density",))
    curve = lambda rtol: solve(place, rtol).scaled_position_density(RADII)[0]  # noqa: E731
    best, some = (1e-7, (1e-2, 1e-4, 1e-5)) if effort.quick else (1e-8, TOLERANCES[:6])
    yield Problem("position", "G(R): gaussian, t = 300, e = 0.6", curve, best, over_largest, some)
    # digits of a program of its own, l = g = 1
    steady = {"drift": 0.501926119920, "mean_square_speed": 1.702146383757,
              "mean_square_along": 1.061388235142, "mean_speed": 1.160252548014}  # fmt: skip
    solver, name = averages(steady, solve_field, E), f"steady state in a field: e = {E:g}"
    yield Problem("field", name, solver, [*steady.values()], tolerances=TOLERANCES[:9])
    bath: Row = {"bath_speed": 1.0, "mass_ratio": 4.0}
    drives: dict[str, Row] = {"a bath": bath, "noise": {"heating": 1.0}}
    for drive, system in drives.items():
        solver = averages(("thermal_speed", "diffusion_coefficient"), solve_steady, E, **system)
        name = f"steady state, {drive}: e = {E:g}"
        yield Problem("driven", name, solver, 1e-12, tolerances=TOLERANCES[:9])


def works(case: str, effort: Effort) -> Iterator[Work]:
    """The works of a case."""
    if case == "particles":
        yield from throughput(effort)
    for one in problems(effort):
        if one.case == case:
            exact = one.solve_to(one.exact) if isinstance(one.exact, float) else one.exact
            error = partial(one.error, exact=exact)
            for x in one.tolerances:
                call = partial(one.solve_to, x)
                yield Work("precision", one.name, SPECTRAL, call, "rtol", x, error)


# -- particles ------------------------------------------------------------------------------------
MEDIA = 4  # configurations of a run


def throughput(effort: Effort) -> Iterator[Work]:
    """Runs of one and of two threads at e = 0.9: of one collision, to place scatterers; long."""
    count, space = 10_000, 0.1 / math.pi  # per d^3: l = 10 d
    media: dict[str, Any] = {
        **{f"hard disks, {n:g} per d^2": p.HardDisks(n, count) for n in (0.005, DENSITY, 0.5)},
        "overlapping disks, 0.04 per d^2": p.Poisson(DENSITY, count),
        "Boltzmann-Grad, 0.04 per d^2": p.BoltzmannGrad(DENSITY),
        "hard spheres, 0.032 per d^3": p.HardSpheres(space, count=count),
        "overlapping spheres, 0.032 per d^3": p.PoissonSpheres(space, count=count),
        "Boltzmann-Grad, 0.032 per d^3": p.BoltzmannGrad(space, dimension=3),
    }
    bath = "Boltzmann-Grad, 0.04 per d^2, bath"
    ways = [*product(media.items(), (1, 2)), ((bath, p.BoltzmannGrad(DENSITY)), 1)]
    runs = (("placing", 1, 1), ("run", 300 if effort.quick else 2000, 500))
    for ((name, medium), threads), (part, tracers, most) in product(ways, runs):
        more: Row = {"bath_speed": 1.0} if name == bath else {}
        call = partial(p.simulate, medium, 0.9, max_collisions=most, media=MEDIA, tracers=tracers,
                       workers=threads, **more)  # fmt: skip
        collisions = float(most * tracers * MEDIA)
        yield Work("particles", name, part, call, "collisions", collisions, threads=threads)


# -- run ------------------------------------------------------------------------------------------
def run_bench(
    quick: bool = False, cases: Iterable[str] | None = None,
    progress: Callable[[str, int], None] = lambda case, total: None,
) -> "BenchReport":  # fmt: skip
    """Measure everything, or the named cases; progress(name of a case, number of cases)."""
    names = tuple(CASES if cases is None else cases)
    for wrong in set(names) - set(CASES):
        raise InputError(f"cases: got {wrong!r}; known are {', '.join(CASES)}")
    about, begin, records = machine(), time.perf_counter(), []
    effort = QUICK if quick else FULL
    with threadpool_limits(1), warnings.catch_warnings():
        warnings.simplefilter("ignore", ToleranceWarning)  # the error is measured
        for name in names:
            progress(name, len(names))
            records += [measure(work, effort) for work in works(name, effort)]
    return BenchReport(records, quick, names, about, time.perf_counter() - begin)


def machine() -> Row:
    """What a time depends on: the processor and the versions. Nothing that names the machine."""
    info = Path("/proc/cpuinfo")
    model = re.search(r"model name\s*: (.*)", info.read_text() if info.exists() else "")
    return {
        "processor": model[1] if model else platform.machine(), "cores": os.cpu_count(),
        "system": platform.system(), "python": platform.python_version(),
        **{n: metadata.version(n) for n in ("inelastic-lorentz", "numpy", "scipy", "numba")},
    }  # fmt: skip


# -- tables ----------------------------------------------------------------------------------------
# columns of the table of all rows, beside those that no table shows
TEXTS = ["section", "problem", "method", "setting", "status", "note", "threads"]
NUMBERS = ["value", "seconds", "error", "asked"]


@dataclass(frozen=True)
class BenchReport:
    """A whole benchmark: rows (see `measure`), the cases that were run, the machine, s in all."""

    records: list[Row]
    quick: bool
    cases: tuple[str, ...]
    machine: Row
    seconds: float

    def rows(self, section: str, status: str = MEASURED) -> Any:
        """The rows of a section, a DataFrame; the question is the problem without its variant."""
        frame = DataFrame(self.records, columns=[*TEXTS, *NUMBERS])
        frame = frame.astype(dict.fromkeys(NUMBERS, float))
        frame = frame[(frame["status"] == status) & frame["section"].str.startswith(section)]
        return frame.assign(question=frame["problem"].str.split(": ").str[0])

    def to_json(self) -> str:
        """One strict JSON document; what is not finite is null."""
        return dumps({"format": FORMAT, **vars(self)})

    def markdown(self) -> str:
        """A heading, and all tables that have rows."""
        about = ", ".join(f"{k} {v}" for k, v in self.machine.items())
        text = (
            f"# Benchmark{' (quick)' * self.quick}\n\n{about}. {self.seconds:.0f} s in all. Times "
            "are medians over repeats, in s: of the processor, of two threads by the clock.\n"
        )
        failed = self.rows("", FAILED)[["problem", "method", "setting", "value", "note"]]
        for title, frame in (
            ("Run time for an error (inf: not reached)", self._run_times()),
            ("Particles, e = 0.9", self._particles()),
            ("Failed", failed),
        ):
            text += f"\n## {title}\n\n{markdown_table(frame)}" if len(frame) else ""
        return text

    def _run_times(self) -> Any:
        """Medians over restitutions and starts; of the error over the one asked for the largest."""
        by, frame = ["question", "method", "problem"], self.rows("precision")
        best = frame.loc[frame.groupby(by, sort=False)["error"].idxmin()].set_index(by)
        table = best[["error", "seconds"]].set_axis(["least error", "time to it"], axis=1)
        for target in (1e-3, 1e-8):
            reached = frame[frame["error"] <= target].groupby(by)["seconds"].min()
            table[f"time to {target:.0e}"] = reached.reindex(table.index, fill_value=math.inf)
        table = table.groupby(by[:2], sort=False).median()
        frame["error over asked"] = frame["error"] / frame["asked"]
        return table.join(frame.groupby(by[:2])["error over asked"].max()).reset_index()

    def _particles(self) -> Any:
        """Rates from the difference of the long run and that of one collision."""
        frame = self.rows("particles").set_index(["problem", "threads"])
        placing, long = (frame[frame["method"] == part] for part in ("placing", "run"))
        rate = (long["value"] - placing["value"]) / (long["seconds"] - placing["seconds"])
        columns = {"placing one": placing["seconds"] / MEDIA, "collisions per second": rate}
        return DataFrame(columns).reset_index()
