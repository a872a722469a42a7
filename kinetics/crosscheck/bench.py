"""The benchmark: run time against error, on the same problems for every method.

A piece of `Work` is one method on one problem at one setting; `CASES` list the works of a part of
the benchmark; `measure` makes a row of each, a dictionary; `BenchReport` makes tables and a figure
of the rows. Speed from version to version: see ``tests/benchmarks``.

Errors are relative to references of 1e-12 or better, but G(R) and <r^2> among hard disks, of which
nothing else is known, to a tighter solution. Of F(c) and G(R) the error is the largest difference
over the largest value, of averages the largest relative error (of a2 that of 1 + a2).
"""

from __future__ import annotations

import io
import math
import os
import platform
import re
import time
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from importlib import metadata
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck import references
from kinetics.crosscheck.files import dumps, markdown_table, plain
from kinetics.crosscheck.references import MEAN_FREE_PATH
from kinetics.errors import InputError, ToleranceWarning

FloatArray = NDArray[np.float64]
Row = dict[str, Any]

FORMAT = "inelastic-lorentz bench 3"
MEASURED, FAILED = "measured", "failed"
SPECTRAL, CONSERVATIVE, STRAIGHTFORWARD = "spectral", "conservative", "straightforward"
MONTE_CARLO = "Monte Carlo"
METHODS = (SPECTRAL, CONSERVATIVE, STRAIGHTFORWARD, MONTE_CARLO)

DENSITY = 0.04  # scatterers per d^2, of the paper: l = MEAN_FREE_PATH
E = 0.7
TOLERANCES = tuple(10.0**-k for k in range(2, 13))
SPEEDS = np.linspace(0.1, 4.0, 79)  # c at which F(c) is compared
RADII = np.linspace(0.0, 6.0, 200)  # R at which G(R) is compared
LATE = 1e7  # d/U, where the scaling state is reached

# -- measuring ------------------------------------------------------------------------------------

LONG, TOO_LONG = 1.0, 60.0  # s; longer work is repeated a fifth as often, or not at all


class Effort(NamedTuple):
    """How much is measured: in s how long work is repeated for, between the least and the most."""

    quick: bool = True
    least: int = 5
    most: int = 11
    seconds: float = 0.04
    restitutions: tuple[float, ...] = (E,)
    samples: tuple[int, ...] = (1000, 5000, 25_000)
    nodes: tuple[int, ...] = (65, 129, 257, 513)


QUICK = Effort()
FULL = Effort(False, 10, 25, 0.12, (E, 0.95), (1000, 10_000, 100_000), (*QUICK.nodes, 1025, 2049))


@dataclass
class Work:
    """One row that is to be measured, and what its calls have given so far."""

    section: str
    problem: str
    method: str
    call: Callable[..., Any]  # takes a seed where the method is `MONTE_CARLO`
    setting: str = ""
    value: float | None = None
    error: Callable[[Any], float] | None = None  # of the result; None where only the time counts
    threads: int = 1  # the time of one is the processor's, of more that of the clock
    times: list[tuple[float, float]] = field(default_factory=list, init=False)
    errors: list[float] = field(default_factory=list, init=False)
    failure: str = field(default="", init=False)

    def run(self, clock: Callable[[], tuple[float, float]]) -> None:
        """Call it once. Whatever it raises is kept, and the end of it: the others go on."""
        if self.failure:
            return
        seeded = self.method == MONTE_CARLO
        try:
            begin = clock()
            result = self.call(len(self.times) + 1) if seeded else self.call()
            end = clock()
            self.times.append((end[0] - begin[0], end[1] - begin[1]))
            if self.error is not None and (seeded or not self.errors):
                self.errors.append(self.error(result))
                if not math.isfinite(self.errors[-1]):
                    raise ArithmeticError("the answer is not finite")
            if len(self.times) == 1 and min(self.times[0]) > TOO_LONG:
                raise TimeoutError(f"its first call took {min(self.times[0]):.0f} s: not repeated")
        except Exception as met:  # whatever it is, it is a row
            self.failure = " ".join(f"{type(met).__name__}: {met}".split())[:200]

    def row(self) -> Row:
        """The row: median and quartiles of the repeats; the first call is not among them."""
        row: Row = {n: getattr(self, n) for n in ("section", "problem", "method", "setting")}
        row |= {"value": self.value, **dict.fromkeys(("seconds", "low", "high", "wall", "warm_up"))}
        row |= {
            "repeats": 0, "error": None, "asked": self.value if self.setting == "rtol" else None,
            "status": FAILED if self.failure else MEASURED, "note": self.failure,
            "threads": self.threads, "extra": {},
        }  # fmt: skip
        if self.failure or len(self.times) < 2:
            return row
        wall, cpu = np.percentile(self.times[1:], [25, 50, 75], axis=0).T.tolist()
        low, median, high = cpu if self.threads == 1 else wall
        row |= {"seconds": median, "low": low, "high": high, "wall": wall[1]}
        row |= {"warm_up": self.times[0][0], "repeats": len(self.times) - 1}
        if self.errors:  # of random work the root mean square over seeds
            row["error"] = float(np.sqrt(np.mean(np.square(self.errors))))
        return row


def measure(
    works: Sequence[Work], effort: Effort,
    clock: Callable[[], tuple[float, float]] = lambda: (time.perf_counter(), time.process_time()),
) -> list[Row]:  # fmt: skip
    """A row for each piece of work, in their order; what fails is a row too.

    Each is called once, which may compile and is never a time; then once more, which says how often
    it is repeated; then the repeats of all are spread evenly over the whole, so that a slow stretch
    of the machine is in the spread of every row, and decides none.
    """
    for work in (*works, *works):
        work.run(clock)
    turns: list[tuple[float, int]] = []
    for k, work in enumerate(works):
        if not work.failure:
            # the least of all four times: others on the machine make none of them shorter
            seconds = max(min(min(pair) for pair in work.times), 1e-6)
            more = max(effort.least, min(effort.most, math.ceil(effort.seconds / seconds))) - 1
            more = more if seconds < LONG else max(1, effort.least // 5) - 1
            turns += [((j + 0.5) / more, k) for j in range(more)]
    for _, k in sorted(turns):
        works[k].run(clock)
    return [work.row() for work in works]


def sweep(problem: str, error: Any, *ways: tuple[Any, ...]) -> list[Work]:
    """Works on one problem; ways : method, setting, its values, a function of one (and of a seed),
    and its own error, if that is another.
    """
    return [
        Work("precision", problem, method, partial(solve, x), setting, x, (*own, error)[0])
        for method, setting, values, solve, *own in ways
        for x in values
    ]


def relative(value: Any, exact: Any) -> float:
    """The largest relative error."""
    with np.errstate(all="ignore"):
        return float(np.max(np.abs(np.asarray(value) / np.asarray(exact) - 1.0)))


def over_largest(value: Any, exact: FloatArray) -> float:
    """The largest difference over the largest value."""
    return float(np.max(np.abs(value - exact)) / exact.max())


# -- the methods ----------------------------------------------------------------------------------


def conservative_cooling(e: float, start: str, times: FloatArray, nodes: int) -> Any:
    """v0 (U) and a2, (2, n_times), of the conservative scheme.

    At 1e-13 the scheme serves every time itself. By the trapezoid rule in ln v.
    """
    from kinetics import Scene, solve

    scene = Scene(e, DENSITY, initial=start, times=times, outputs=("speed_density",))
    found = solve(scene, 1e-13, method=CONSERVATIVE, nodes=nodes)
    slowest = 1e-5 * min(1.0, MEAN_FREE_PATH / times[-1])  # far below the last thermal speed
    v = np.geomspace(slowest, 16.0, 4 * nodes)  # next to no tracer of either start is faster
    weight = found.speed_density(v) * v * math.log(v[1] / v[0])
    second, fourth = (weight @ v**p + found.uncollided for p in (2, 4))
    return np.array([np.sqrt(second), 0.5 * fourth / second**2 - 1.0])


def gain_matrix(e: float, nodes: int) -> FloatArray:
    """G of the solver that one would write first, shape (nodes, nodes), on uniform speeds.

    For masses p_j at v_j = j dv the isotropic equation (paper, label ``inelaslorentz2``) is dp/dt =
    (G - 1) diag(v) p/l, G_ij the share of bounces at v_j that arrive at v_i. G is projected on hat
    functions exactly: second differences of ramps, whose mean over the impact parameter is
    E[(s - S)_+] = (s sqrt(s^2 - e^2) - e^2 ln((s + sqrt(s^2 - e^2))/e)) / (2 sqrt(1 - e^2)).
    It is of second order in dv, and shares nothing with the solvers of the package; e < 1.
    """
    j, i = np.arange(1.0, nodes), np.arange(-1.0, nodes + 1.0)
    s = np.clip(i[:, None] / j, e, 1.0)
    root = np.sqrt((s - e) * (s + e))
    ramp = s * root
    if e > 0.0:
        ramp -= e * e * np.log((s + root) / e)
    ramp /= 2.0 * math.sqrt((1.0 - e) * (1.0 + e))
    ramp += np.maximum(i[:, None] / j - 1.0, 0.0)  # every bounce ends below s = 1
    gain = np.zeros((nodes, nodes))
    gain[:, 1:] = np.triu(j * (ramp[2:] - 2.0 * ramp[1:-1] + ramp[:-2]), k=-1)[:nodes]
    gain[0, 0] = 1.0
    return gain


def straightforward_state(e: float, nodes: int) -> SimpleNamespace:
    """h, a2, F(c): one dense solve of 0 = -d(y g)/dy - y g + gain, the steady y = v t/l."""
    from scipy.interpolate import CubicSpline

    from kinetics import CollisionLaw

    # to a tail e^-y beyond the mean 1/kappa
    y = np.linspace(0.0, 30.0 + 2.0 / CollisionLaw(e).mean_log_loss, nodes)
    inner = np.arange(nodes - 1)
    matrix = (gain_matrix(e, nodes) - np.eye(nodes)) * y
    # the flux is y (g + g)/2 at the middles between nodes; nothing passes the ends, and the
    # equation of node 0, which stands for half a cell, is that of its mass
    half = 0.5 * (inner + 0.5)
    for row, sign in ((inner, -1.0), (inner + 1, 1.0)):
        matrix[row, inner] += sign * half
        matrix[row, inner + 1] += sign * half
    matrix[-1], matrix[-1, [0, -1]] = y[1], 0.5 * y[1]  # they sum to zero: the norm instead of one
    g = np.linalg.solve(matrix, np.eye(nodes)[-1])
    second, fourth = (float(y**p @ g) * y[1] for p in (2, 4))
    unit, spline = math.sqrt(second), CubicSpline(y, g)

    def vdf(c: FloatArray) -> FloatArray:
        inside = np.where(c * unit <= y[-1], spline(c * unit), 0.0)
        return np.asarray(inside * unit / (2.0 * math.pi * c))

    a2 = 0.5 * fourth / second**2 - 1.0
    return SimpleNamespace(cooling_rate=2.0 / unit, a2=a2, vdf=vdf)


def monte_carlo(
    e: float, start: Any, times: Any, samples: int, seed: int, observable: str = ""
) -> Any:
    """A Boltzmann-Grad run in 50 blocks, of one thread, with the free path MEAN_FREE_PATH."""
    from particles import BoltzmannGrad, simulate

    return simulate(
        BoltzmannGrad(DENSITY), e, initial=start, times=times, media=50, tracers=samples // 50,
        seed=seed, observables=[observable] if observable else None, workers=1,
    )  # fmt: skip


def histogram_error(
    histogram: Any, unit: float, x: FloatArray, f: FloatArray, plane: bool = False
) -> float:
    """The largest difference of densities, averaged over each bin, over the largest value of f.

    histogram : of one time; unit : by which its edges are divided; x, f : the exact density, at
    places between which bins are compared; plane : whether it is one of the plane, or radial
    """
    from scipy.interpolate import CubicSpline

    from kinetics.numerics.gauss import panels_between

    edges = histogram.edges / unit
    used = np.flatnonzero((edges[:-1] >= x[0]) & (edges[1:] <= x[-1]))
    place, weight = panels_between(edges[used[0] : used[-1] + 2], 6)
    weight = weight.reshape(-1, 6) * (2.0 * math.pi * place.reshape(-1, 6) if plane else 1.0)
    exact = (CubicSpline(x, f)(place).reshape(-1, 6) * weight).sum(axis=1)
    found = histogram.probability.value[0][used]
    return float(np.max(np.abs(found - exact) / weight.sum(axis=1)) / f.max())


# -- problems: run time against error -------------------------------------------------------------


def scaled(effort: Effort) -> Iterator[Work]:
    """F(c), and h and a2, of the scaling state against `ScalingSolution`."""
    from kinetics import ScalingSolution, solve_scaled

    def both(state: Any) -> Any:
        return np.array([state.cooling_rate, 1.0 + state.a2])

    def late(e: float, observable: str, samples: int, seed: int) -> Any:
        return monte_carlo(e, "gaussian", [LATE], samples, seed, observable)

    def both_of(run: Any) -> Any:
        v0, a2 = run.thermal_speed.value[0], run.a2.value[0]
        return np.array([2.0 * MEAN_FREE_PATH / (v0 * LATE), 1.0 + a2])

    for e in effort.restitutions:
        states: list[Any] = [
            (SPECTRAL, "rtol", TOLERANCES, partial(solve_scaled, e)),
            (STRAIGHTFORWARD, "nodes", effort.nodes, partial(straightforward_state, e)),
        ]
        exact = ScalingSolution(e)
        F = exact.vdf(SPEEDS)
        sampled = (MONTE_CARLO, "samples", effort.samples)
        yield from sweep(
            f"scaled F(c): e = {e:g}", partial(over_largest, exact=F),
            *((*way, lambda x, f=f: f(x).vdf(SPEEDS)) for *way, f in states),
            (*sampled, partial(late, e, "speed_histogram"), lambda run, F=F: histogram_error(
                run.speed_histogram, run.thermal_speed.value[0], SPEEDS, F, plane=True)),
        )  # fmt: skip
        yield from sweep(
            f"scaled h and a2: e = {e:g}", partial(relative, exact=both(exact)),
            *((*way, lambda x, f=f: both(f(x))) for *way, f in states),
            (*sampled, lambda n, seed, e=e: both_of(late(e, "", n, seed))),
        )  # fmt: skip


def averages(effort: Effort, name: str, outputs: tuple[str, ...], horizon: str) -> Iterator[Work]:
    """Averages over time from both starts of the paper, against kept references."""
    from kinetics import Scene, solve

    def values(found: Any) -> list[Any]:
        averages = [getattr(found, n) for n in outputs]  # arrays, or Estimates of particles
        found = [getattr(x, "value", x) for x in averages]
        return [x + (n == "a2") for n, x in zip(outputs, found, strict=True)]

    times, shift = references.times(horizon), [[0.0], [1.0]]
    for e, start in ((e, start) for e in effort.restitutions for start in references.STARTS):
        exact = [references.kept(n, e, start, horizon) + (n == "a2") for n in outputs]
        scene = Scene(e, DENSITY, initial=start, times=times, outputs=outputs)
        ways: list[tuple[Any, ...]] = [
            (SPECTRAL, "rtol", TOLERANCES, lambda rtol, s=scene: values(solve(s, rtol))),
            (MONTE_CARLO, "samples", effort.samples,
             lambda n, seed, e=e, start=start: values(monte_carlo(e, start, times, n, seed))),
        ]  # fmt: skip
        if "a2" in outputs:
            others = partial(conservative_cooling, e, start, times)
            ways += [(CONSERVATIVE, "nodes", effort.nodes, lambda n, f=others: f(n) + shift)]
        problem = f"{name}, t <= {times[-1]:.0e}: {start}, e = {e:g}"
        yield from sweep(problem, partial(relative, exact=exact), *ways)


def cooling(effort: Effort) -> Iterator[Work]:
    """v0(t) and a2(t) over a short and a long time."""
    for horizon in references.HORIZONS:
        yield from averages(effort, "v0(t), a2(t)", ("thermal_speed", "a2"), horizon)


def position(effort: Effort) -> Iterator[Work]:
    """<r^2>(t) and kurtosis(t), <r^2>(t) among hard disks, and G(R) at e = 0.6, t = 300."""
    from kinetics import Scene, solve

    yield from averages(effort, "<r^2>(t)", ("msd",), "short")
    yield from averages(effort, "kurtosis(t)", ("kurtosis",), "short")
    disks = Scene(E, DENSITY, times=np.geomspace(1.0, 1e8, 100), outputs=("msd",),
                  scatterers="hard disks")  # fmt: skip
    yield from sweep(
        f"<r^2>(t) among hard disks, t <= 1e+08: e = {E:g}",
        partial(relative, exact=solve(disks, 1e-13).msd),
        (SPECTRAL, "rtol", TOLERANCES[:-2], lambda rtol: solve(disks, rtol).msd),
    )
    scene = Scene(0.6, DENSITY, times=[300.0], outputs=("position_density",))

    def curve(rtol: float) -> FloatArray:
        return np.asarray(solve(scene, rtol).scaled_position_density(RADII)[0])

    exact = curve(1e-7 if effort.quick else 1e-8)
    kind, full = "displacement_histogram", slice(8, 134)  # R from 0.25 to 4 has enough tracers

    def of_run(run: Any) -> float:
        unit = math.sqrt(run.msd.value[0])
        return histogram_error(getattr(run, kind), unit, RADII[full], exact[full])

    yield from sweep(
        "G(R): gaussian, t = 300, e = 0.6", partial(over_largest, exact=exact),
        (SPECTRAL, "rtol", (1e-2, 1e-4, 1e-5) if effort.quick else TOLERANCES[:6], curve),
        (MONTE_CARLO, "samples", effort.samples,
         partial(monte_carlo, 0.6, "gaussian", [300.0], observable=kind), of_run),
    )  # fmt: skip


def in_field(effort: Effort) -> Iterator[Work]:
    """The steady state in a uniform field against digits of a program of its own, l = g = 1."""
    from kinetics import solve_field

    steady = {"drift": 0.501926119920, "mean_square_speed": 1.702146383757,
              "mean_square_along": 1.061388235142, "mean_speed": 1.160252548014}  # fmt: skip

    def state(rtol: float) -> list[float]:
        found = solve_field(E, rtol=rtol)
        return [getattr(found, name) for name in steady]

    error = partial(relative, exact=[*steady.values()])
    way = (SPECTRAL, "rtol", TOLERANCES[:9], state)
    yield from sweep(f"steady state in a field: e = {E:g}", error, way)


# -- what skipping saves, and particles -----------------------------------------------------------


def skipping(effort: Effort) -> Iterator[Work]:
    """Each output of a scene alone; "everything" comes first."""
    from kinetics import Scene, solve
    from particles import BoltzmannGrad, simulate

    times = np.geomspace(1.0, 1e4, 20)
    groups: tuple[tuple[str, str, float, Row], ...] = (
        ("isotropic scene", "thermal_speed a2 collisions msd kurtosis speed_density", 1e-8,
         {"times": times, "harmonics": 4}),
        ("displacement, e = 0.6, t = 300", "msd kurtosis diffusion_coefficient position_density",
         1e-4, {"restitution": 0.6, "times": [300.0]}),
        ("elastic scene", "a2 speed_density", 1e-8, {"restitution": 1.0, "times": times}),
    )  # fmt: skip
    for group, names, rtol, more in groups:
        for part in ("everything", *names.split()):
            outputs = names.split() if part == "everything" else [part]
            scene = Scene(**{"restitution": E, "outputs": tuple(outputs), **more})
            yield Work("skipping", group, part, partial(solve, scene, rtol))
    histograms = [f"{kind}_histogram" for kind in ("speed", "displacement", "free_path")]
    for part, some in (("everything", histograms), ("averages alone", None)):
        yield Work("skipping", "Boltzmann-Grad run, 4000 tracers", part, partial(
            simulate, BoltzmannGrad(DENSITY), E, times=times, media=4, tracers=1000, workers=1,
            observables=some))  # fmt: skip


MEDIA = 4  # configurations of a run


def throughput(effort: Effort) -> Iterator[Work]:
    """Runs of one and of two threads at e = 0.9: of one collision, to place scatterers; long."""
    import particles as p

    count, space = 10_000, 0.1 / math.pi  # per d^3: l = 10 d
    media: dict[str, Any] = {
        **{f"hard disks, {n:g} per d^2": p.HardDisks(n, count) for n in (0.005, DENSITY, 0.5)},
        "overlapping disks, 0.04 per d^2": p.Poisson(DENSITY, count),
        "Boltzmann-Grad, 0.04 per d^2": p.BoltzmannGrad(DENSITY),
        "hard spheres, 0.032 per d^3": p.HardSpheres(space, count=count),
        "overlapping spheres, 0.032 per d^3": p.PoissonSpheres(space, count=count),
        "Boltzmann-Grad, 0.032 per d^3": p.BoltzmannGrad(space, dimension=3),
    }
    runs = (("placing", 1, 1), ("run", 300 if effort.quick else 2000, 500))
    for (name, medium), threads in ((m, threads) for m in media.items() for threads in (1, 2)):
        for part, tracers, most in runs:
            call = partial(p.simulate, medium, 0.9, max_collisions=most, media=MEDIA,
                           tracers=tracers, workers=threads)  # fmt: skip
            collisions = float(most * tracers * MEDIA)
            yield Work("particles", name, part, call, "collisions", collisions, threads=threads)


CASES: dict[str, Callable[[Effort], Iterator[Work]]] = {
    "scaled": scaled, "cooling": cooling, "position": position, "field": in_field,
    "skipping": skipping, "particles": throughput,
}  # fmt: skip

# -- run ------------------------------------------------------------------------------------------


def run_bench(
    quick: bool = False, cases: Iterable[str] | None = None,
    progress: Callable[[str, int], None] = lambda case, total: None,
) -> BenchReport:  # fmt: skip
    """Measure everything, or the named cases (see `CASES`), one after another.

    The linear algebra has one thread. progress(name of the case, number of cases) is called as each
    of them starts. Raises InputError for a case that does not exist.
    """
    from threadpoolctl import threadpool_limits

    names = tuple(CASES) if cases is None else tuple(dict.fromkeys(cases))
    for wrong in [repr(name) for name in names if name not in CASES] or ([] if names else ["none"]):
        raise InputError(f"cases: got {wrong}; known are {', '.join(CASES)}")
    about, begin, records = machine(), time.perf_counter(), []
    effort = QUICK if quick else FULL
    with threadpool_limits(1), warnings.catch_warnings():
        warnings.simplefilter("ignore", ToleranceWarning)  # the error is measured
        for name in names:
            progress(name, len(names))
            records += measure(list(CASES[name](effort)), effort)
    return BenchReport(records, quick, names, about, time.perf_counter() - begin)


def machine() -> Row:
    """What a time depends on: the processor and the versions. Nothing that names the machine."""
    info, processor = Path("/proc/cpuinfo"), platform.processor() or platform.machine()
    if found := re.search(r"model name\s*: (.*)", info.read_text() if info.exists() else ""):
        processor = found[1]
    return {
        "processor": processor, "cores": os.cpu_count(), "system": platform.system(),
        "python": platform.python_version(),
        **{n: metadata.version(n) for n in ("inelastic-lorentz", "numpy", "scipy", "numba")},
    }  # fmt: skip


# -- tables and figure ----------------------------------------------------------------------------

# Time ~ error^-q at best, of the methods whose error falls without end: the order of the scheme,
# and the least work that it can do. Of the straightforward solver: second order, and filling the
# matrix; of the conservative one: second order, and one sweep; of Monte Carlo: 1/sqrt(samples).
_AT_BEST = {STRAIGHTFORWARD: 1.0, CONSERVATIVE: 0.5, MONTE_CARLO: 2.0}
_UNITS = (("years", 365.25 * 86400.0), ("days", 86400.0), ("h", 3600.0), ("s", 1.0), ("ms", 1e-3))


def seconds_for(rows: Any, method: str, target: float) -> tuple[float, bool]:
    """Least time in which a method reached the error, of the rows (DataFrame) of one problem.

    Where it was not reached but can be: the least that it would take, from its most accurate run,
    and True. NaN where it does not get there.
    """
    rows = rows[rows["error"].notna() & (rows["seconds"] > 0.0)]
    there = rows[rows["error"] <= target]
    if len(there):
        return float(there["seconds"].min()), False
    best = rows.sort_values(["error", "seconds"]).iloc[:1]
    # a larger error than 1/2 is no point of a curve that converges
    if method not in _AT_BEST or not len(best) or best["error"].item() > 0.5:
        return math.nan, False
    return best["seconds"].item() * (best["error"].item() / target) ** _AT_BEST[method], True


def seconds_text(seconds: float, at_least: bool = False) -> str:
    """A time of two digits with its unit, years where it is long; "≥" before a lower bound."""
    if math.isnan(seconds):
        return "-"
    unit, size = next(((u, s) for u, s in _UNITS if seconds >= s), ("us", 1e-6))
    return f"{'≥ ' * at_least}{_digits(seconds / size)} {unit}"


def _digits(value: float) -> str:
    return f"{value:.1e}" if value >= 1e4 else f"{value:.0f}" if value >= 10 else f"{value:.2g}"


@dataclass(frozen=True)
class BenchReport:
    """A whole benchmark: rows, names of the cases that were run, processor and versions, s in all.

    A row has the keys section, problem ("question: variant"), method, setting, value, seconds
    (median; low and high: quartiles; wall, warm_up: of the clock), repeats, error, asked, status
    ("measured", "failed"), note, threads, extra.
    """

    records: list[Row]
    quick: bool
    cases: tuple[str, ...]
    machine: Row
    seconds: float

    def to_dataframe(self) -> Any:
        """The rows as a DataFrame, and the question, which is the problem without its variant."""
        from pandas import DataFrame

        frame = DataFrame(plain(self.records), columns=list(Work("", "", "", print).row()))
        numbers = dict.fromkeys(("value", "seconds", "error", "asked"), float)
        return frame.astype(numbers).assign(question=frame["problem"].str.split(": ").str[0])

    def _of(self, section: str) -> Any:
        """The rows of one section that were measured."""
        frame = self.to_dataframe()
        return frame[(frame["section"] == section) & (frame["status"] == MEASURED)].copy()

    def to_json(self) -> str:
        """One strict JSON document; what is not finite is null."""
        return dumps({"format": FORMAT, **vars(self)})

    def files(self) -> dict[str, str]:
        """What ``lorentz bench -o`` writes, by name; a figure if it has data."""
        files = {"bench.json": self.to_json(), "bench.md": self.markdown()}
        figure = self.work_precision()
        return files | ({"work-precision.svg": figure} if figure else {})

    def markdown(self) -> str:
        """A heading, and all tables that have rows."""
        about = ", ".join(f"{k} {v}" for k, v in self.machine.items())
        text = (
            f"# Benchmark{' (quick)' * self.quick}\n\n{about}. {self.seconds:.0f} s in all. "
            "Times are medians over repeats in turns: processor time, where nothing else is said.\n"
        )
        failed = [
            {"problem": row["problem"], "method": row["method"],
             "setting": f"{row['setting']} {row['value'] or ''}", "why": row["note"]}
            for row in self.records if row["status"] == FAILED
        ]  # fmt: skip
        for title, rows in (
            ("Run time for an error (≥: at least; -: it does not get there)", self._run_times()),
            ("What skipping saves", self._skipping()),
            ("Particles, e = 0.9 (two threads: by the clock)", self._particles()),
            ("Failed", failed),
        ):  # fmt: skip
            if rows:
                text += "\n".join(["", f"## {title}", "", *markdown_table(rows)])
        return text

    def _run_times(self) -> list[dict[str, str]]:
        """Medians over restitutions and starts; the largest error over the one asked for."""
        rows = []
        by = ["question", "method"]
        for (question, method), runs in self._of("precision").groupby(by, sort=False):
            row = {"problem": question, "method": method}
            problems, most = runs.groupby("problem"), (runs["error"] / runs["asked"]).max()
            for target in (1e-3, 1e-8):  # the upper one of two in the middle; never: the most
                costs = [seconds_for(p, method, target) for _, p in problems]
                costs.sort(key=lambda cost: math.inf if math.isnan(cost[0]) else cost[0])
                row[f"{target:.0e}"] = seconds_text(*costs[len(costs) // 2])
            row["least error"] = f"{problems['error'].min().median():.1e}"
            rows.append(row | {"over asked": "" if math.isnan(most) else f"{most:.2g}"})
        return rows

    def _skipping(self) -> list[dict[str, str]]:
        frame = self._of("skipping")
        frame["ratio"] = frame.groupby("problem")["seconds"].transform("first") / frame["seconds"]
        return [
            {"scene": row.problem, "asked for": row.method, "time": seconds_text(row.seconds),
             "time of everything over it": _digits(row.ratio)} for row in frame.itertuples()
        ]  # fmt: skip

    def _particles(self) -> list[dict[str, str]]:
        rows = []
        frame = self._of("particles")
        for (name, threads), two in frame.groupby(["problem", "threads"], sort=False):
            if len(two) == 2:
                rate = two["value"].diff().iloc[1] / two["seconds"].diff().iloc[1] / 1e6
                placing = seconds_text(two["seconds"].iloc[0] / MEDIA)
                rows.append({"medium": name, "threads": str(threads), "placing one": placing,
                             "million collisions per second": f"{rate:.1f}"})  # fmt: skip
        return rows

    def work_precision(self) -> str | None:
        """Run time against error, a panel for each question, as text of an SVG file, or None."""
        frame = self._of("precision")
        if not len(frame):
            return None
        import matplotlib as mpl
        from matplotlib.figure import Figure

        frame["error"] = frame["error"].clip(1e-16, 10.0)
        file, panels = io.StringIO(), frame.groupby("question", sort=False)
        rows = math.ceil(len(panels) / 3)
        with mpl.rc_context({"svg.fonttype": "none", "svg.hashsalt": "inelastic-lorentz",
                             "axes.grid": True, "axes.titlesize": 8.0}):  # fmt: skip
            figure = Figure(figsize=(9.375, 1.1 + 2.4 * rows), layout="constrained")
            axes = figure.subplots(rows, 3, squeeze=False, sharex=True, sharey=True).ravel()
            axes[0].set(xscale="log", yscale="log", ylim=(1e-16, 30.0))
            legend = {}
            for axis, (question, panel) in zip(axes, panels, strict=False):
                axis.set_title(question)
                for (method, _), runs in panel.groupby(["method", "problem"], sort=False):
                    k = METHODS.index(method)
                    look = {"color": f"C{k}", "marker": "os^x"[k]}
                    (legend[method],) = axis.plot(runs["seconds"], runs["error"], ms=4.0, **look)
            for axis in axes[len(panels) :]:
                axis.set_visible(False)
            figure.legend(legend.values(), legend, loc="outside upper center", ncols=len(legend))
            figure.supxlabel("run time, one thread [s]")
            figure.supylabel("error")
            figure.savefig(file, format="svg", metadata={"Date": None})
        return file.getvalue()
