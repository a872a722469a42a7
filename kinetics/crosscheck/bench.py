"""The benchmark: run time against error, on the same problems for every method.

A piece of `Work` is one method on one problem at one setting; `measure` makes a row of each, a
dictionary; `CASES` are the functions that make the works of a part of the benchmark; `run_bench`
runs each case in a process of its own, whose linear algebra has one thread; `BenchReport` makes
tables and the figure of the rows. Speed from version to version: see ``tests/benchmarks``.

Errors are relative to references of 1e-13 or better: of F(c) and G(R) the largest difference over
the largest value; of h and a2, v0(t) and a2(t), <r^2>(t), kurtosis(t) and averages in a field the
largest relative error (of a2 that of 1 + a2).
"""

from __future__ import annotations

import io
import json
import math
import os
import platform
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import partial
from importlib import metadata
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck import references
from kinetics.crosscheck.files import dumps, markdown_table, plain
from kinetics.crosscheck.references import MEAN_FREE_PATH
from kinetics.errors import InputError

FloatArray = NDArray[np.float64]
Row = dict[str, Any]

FORMAT = "inelastic-lorentz bench 2"
MEASURED, FAILED, NOT_AVAILABLE = "measured", "failed", "not available"
SPECTRAL, CONSERVATIVE, STRAIGHTFORWARD = "spectral", "conservative", "straightforward"
SONINE, MONTE_CARLO, PRINTED = "Sonine", "Monte Carlo", "as printed"
METHODS = (SPECTRAL, CONSERVATIVE, STRAIGHTFORWARD, SONINE, MONTE_CARLO, PRINTED)

DENSITY = 0.04  # scatterers per d^2, of the paper: l = MEAN_FREE_PATH
E = 0.7
TOLERANCES = tuple(10.0**-k for k in range(2, 13))
SPEEDS = np.linspace(0.1, 4.0, 79)  # c at which F(c) is compared
RADII = np.linspace(0.0, 6.0, 200)  # R at which G(R) is compared
LATE = {CONSERVATIVE: 1e10, MONTE_CARLO: 1e7}  # d/U, where the scaling state is reached
OTHER_LAWS: dict[str, dict[str, Any]] = {
    "spheres": {"dimension": 3},
    "et = 0.8": {"tangential_restitution": 0.8},
    "spheres, et = 0.8": {"tangential_restitution": 0.8, "dimension": 3},
}
QUANTITIES = {
    "msd": "<r^2>(t)", "kurtosis": "kurtosis(t)", "thermal_speed": "v0(t)", "a2": "1 + a2(t)",
}  # fmt: skip

# -- measuring ------------------------------------------------------------------------------------

LONG, TOO_LONG = 1.0, 60.0  # s; longer work is timed once, or not repeated at all


class Effort(NamedTuple):
    """How often work is repeated, and what is measured, of a quick and of a full benchmark."""

    quick: bool
    least: int
    most: int
    seconds: float  # that work is repeated for, between the least and the most
    seeded: int  # the least of random work, whose error is a root mean square over seeds
    restitutions: tuple[float, ...] = (E,)
    samples: tuple[int, ...] = (1000, 5000, 25_000)
    orders: tuple[int, ...] = (1, 2, 3, 5, 10, 20)
    nodes: int = 1025  # the most of a grid

    def repeats(self, seconds: float, seeded: bool) -> int:
        """How many repeats a piece of work gets that takes so many s."""
        least = max(self.least, self.seeded) if seeded else self.least
        if seconds >= LONG:
            return max(1, least // 5)
        return max(least, min(self.most, math.ceil(self.seconds / max(seconds, 1e-6))))

    def grids(self, largest: int) -> list[int]:
        """Numbers of nodes, doubling from 65 to the largest that a method is tried with."""
        most = min(self.nodes, largest // 4 if self.quick else largest)
        return [n for n in (64 * 2**k + 1 for k in range(7)) if n <= most]


QUICK = Effort(True, 3, 11, 0.04, 5)
FULL = Effort(
    False, 5, 25, 0.12, 10, (E, 0.95, 0.2), (1000, 10_000, 100_000, 400_000),
    orders=tuple(range(1, 21)), nodes=4097,
)  # fmt: skip


@dataclass
class Work:
    """One row that is to be measured, and what its calls have given so far.

    section, problem, method, setting, value : as of the row
    call : solves the problem; takes a seed where the work is ``seeded``, which is random
    error : of what the call gives; None where only the time counts
    figures : further figures of what the call gives
    threads : that it may use: the time of one is the processor's, of more that of the clock
    """

    section: str
    problem: str
    method: str
    call: Callable[..., Any]
    setting: str = ""
    value: float | None = None
    error: Callable[[Any], float] | None = None
    seeded: bool = False
    threads: int = 1
    figures: Callable[[Any], Row] = lambda _: {}
    times: list[tuple[float, float]] = field(default_factory=list, init=False)
    errors: list[float] = field(default_factory=list, init=False)
    extra: Row = field(default_factory=dict, init=False)
    failure: str = field(default="", init=False)
    over: bool = field(default=False, init=False)

    def run(self, clocks: Sequence[Callable[[], float]]) -> None:
        """Call it once, unless it is over. Whatever it raises is kept: the others go on."""
        if self.over:
            return
        try:
            begin = [clock() for clock in clocks]
            result = self.call(len(self.times) + 1) if self.seeded else self.call()
            self.times.append((clocks[0]() - begin[0], clocks[1]() - begin[1]))
            self.extra = self.figures(result)
            if self.error is not None and (self.seeded or not self.errors):
                self.errors.append(self.error(result))
                if not math.isfinite(self.errors[-1]):
                    found = np.concatenate([np.ravel(x) for x in np.atleast_1d(result)])
                    count = int(np.sum(~np.isfinite(found)))
                    self.failure = f"{count} of {found.size} values are no finite number"
            if len(self.times) == 1 and min(self.times[0]) > TOO_LONG:
                raise TimeoutError(f"its first call took {min(self.times[0]):.0f} s: not repeated")
        except Exception as met:  # whatever it is, it is a row
            self.failure, self.over = f"{type(met).__name__}: {met}", True

    def row(self) -> Row:
        """The row: median and quartiles of the repeats; the first call is not among them."""
        asked = self.value if self.setting == "rtol" else None
        row: Row = {
            "section": self.section, "problem": self.problem, "method": self.method,
            "setting": self.setting, "value": self.value, "seconds": None, "low": None,
            "high": None, "wall": None, "warm_up": None, "repeats": 0, "error": None,
            "asked": asked, "status": MEASURED, "note": "", "threads": self.threads, "extra": {},
        }  # fmt: skip
        if self.failure:
            row |= {"status": FAILED, "note": " ".join(self.failure.split())[:200]}
        if self.over or len(self.times) < 2:
            return row
        wall, cpu = np.percentile(self.times[1:], [25, 50, 75], axis=0).T.tolist()
        low, median, high = cpu if self.threads == 1 else wall
        row |= {"seconds": median}
        if not self.failure:
            row |= {"low": low, "high": high, "wall": wall[1], "warm_up": self.times[0][0]}
            row |= {"repeats": len(self.times) - 1, "extra": self.extra}
            if self.errors:
                row["error"] = float(np.sqrt(np.mean(np.square(self.errors))))
                row["extra"] = self.extra | ({"seeds": len(self.errors)} if self.seeded else {})
        return row


def blank(section: str, problem: str, method: str, **others: Any) -> Row:
    """A row that was not measured in turns with others."""
    return Work(section, problem, method, lambda: None).row() | others


def sweep(
    section: str, problem: str, method: str, setting: str, values: Iterable[Any],
    solve: Callable[..., Any], **others: Any,
) -> list[Work]:  # fmt: skip
    """One method on one problem for many values of a setting, which `solve` takes; see `Work`."""
    return [Work(section, problem, method, partial(solve, v), setting, v, **others) for v in values]


def measure(
    works: Sequence[Work], effort: Effort,
    clocks: Sequence[Callable[[], float]] = (time.perf_counter, time.process_time),
) -> list[Row]:  # fmt: skip
    """A row for each piece of work, in their order; what fails is a row too.

    Each is called once, which may compile and is never a time; then once more, which says how often
    it is repeated; then the repeats of all are spread evenly over the whole, so that a slow stretch
    of the machine is in the spread of every row, and decides none.
    """
    for work in (*works, *works):
        work.run(clocks)
    turns = []
    for work in works:
        if not work.over:
            # the least of all four times: others on the machine make none of them shorter
            more = effort.repeats(min(min(pair) for pair in work.times), work.seeded) - 1
            turns += [((j + 0.5) / more, work) for j in range(more)]
    for _, work in sorted(turns, key=lambda turn: turn[0]):
        work.run(clocks)
    return [work.row() for work in works]


def relative(value: Any, exact: Any) -> float:
    """The largest relative error."""
    with np.errstate(all="ignore"):
        return float(np.max(np.abs(np.asarray(value) / np.asarray(exact) - 1.0)))


# -- the methods ----------------------------------------------------------------------------------


class State(NamedTuple):
    """A scaling state: h, a2 and F(c), named as of `kinetics.ScalingSolution`."""

    cooling_rate: float
    a2: float
    vdf: Callable[[FloatArray], FloatArray]


FASTEST = {"gaussian": 8.0, "monoenergetic": 1.0}
"""Largest speed of a grid in U: e^-32 of the Gaussian lies above it, and speeds never grow."""


def conservative_cooling(e: float, start: str, times: FloatArray, nodes: int) -> Any:
    """v0 (U) and a2, (n_times,) each, of the conservative scheme, and its Solution.

    At 1e-13 the scheme serves every time itself. By the trapezoid rule in ln v.
    """
    from kinetics import Scene, solve

    scene = Scene(e, DENSITY, initial=start, times=times, outputs=("speed_density",))
    found = solve(scene, 1e-13, method=CONSERVATIVE, nodes=nodes)
    slowest = 1e-5 * min(1.0, MEAN_FREE_PATH / times[-1])  # far below the last thermal speed
    v = np.geomspace(slowest, 2.0 * FASTEST[start], 4 * nodes)
    weight = found.speed_density(v) * v * math.log(v[1] / v[0])
    second, fourth = (weight @ v**p + found.uncollided for p in (2, 4))
    return np.sqrt(second), 0.5 * fourth / second**2 - 1.0, found


def conservative_state(e: float, nodes: int) -> State:
    """Late, from a Gaussian start."""
    late = np.array([LATE[CONSERVATIVE]])
    (v0,), (a2,), found = conservative_cooling(e, "gaussian", late, nodes)
    rate = 2.0 * MEAN_FREE_PATH / (v0 * late[0])
    return State(rate, a2, lambda c: found.speed_density(c * v0)[0] * v0 / (2.0 * math.pi * c))


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


def straightforward_cooling(
    e: float, start: str, times: FloatArray, nodes: int, rtol: float | None = None
) -> tuple[FloatArray, FloatArray]:
    """v0 (U) and a2 by BDF, (n_times,) each; NaN at the times that it did not reach."""
    from scipy.integrate import solve_ivp

    # a tighter rtol gains nothing at this spacing, a looser one loses digits
    rtol = min(1e-3, 2.0 / nodes**2) if rtol is None else rtol
    v = np.linspace(0.0, FASTEST[start], nodes)
    p = v * np.exp(-0.5 * v * v) if start == "gaussian" else np.eye(nodes)[-1]
    p /= p.sum()
    matrix = (gain_matrix(e, nodes) - np.eye(nodes)) * (v / MEAN_FREE_PATH)
    found = solve_ivp(
        lambda t, y: matrix @ y, (0.0, times[-1]), p, method="BDF", t_eval=times, jac=matrix,
        rtol=rtol, atol=rtol * p.max(),
    )  # fmt: skip
    out = np.full((2, times.size), np.nan)
    with np.errstate(divide="ignore", invalid="ignore"):
        second, fourth = v**2 @ found.y, v**4 @ found.y
        out[:, : second.size] = np.sqrt(second), 0.5 * fourth / second**2 - 1.0
    return out[0], out[1]


def straightforward_state(e: float, nodes: int) -> State:
    """The stationary state of y = v t/l by one dense solve of 0 = -d(y g)/dy - y g + gain."""
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

    return State(2.0 / unit, 0.5 * fourth / second**2 - 1.0, vdf)


def sonine_state(e: float, order: int) -> Any:
    """The Sonine expansion of this order; ValueError where it has no real solution."""
    from kinetics.paper.series import SeriesStatus, scaled_state

    state = scaled_state(e, order)
    if state.status is not SeriesStatus.REAL:
        raise ValueError(f"order = {order}: no real solution at restitution {e:g}")
    return state


def sonine_cooling(e: float, start: str, times: FloatArray, order: int) -> Any:
    """v0 (U) and a2, (n_times,) each, of this order; ValueError where it has no real solution."""
    from kinetics.paper.series import SeriesStatus, cooling

    found = cooling(e, times, order, MEAN_FREE_PATH, start, 1e-8)
    if found.status is not SeriesStatus.REAL:
        raise ValueError(f"order = {order}: {found.status.value}")
    return found.thermal_speed, found.a2


def monte_carlo(
    e: float, start: Any, times: Any, observable: str, samples: float, seed: int,
    dimension: int = 2, **law: Any,
) -> Any:  # fmt: skip
    """A Boltzmann-Grad run in 50 blocks, of one thread, with the free path MEAN_FREE_PATH."""
    from particles import BoltzmannGrad, simulate

    medium = BoltzmannGrad(DENSITY)
    if dimension == 3:
        medium = BoltzmannGrad(1.0 / (math.pi * MEAN_FREE_PATH), dimension=3)
    return simulate(
        medium, e, initial=start, times=times, media=50, tracers=max(1, int(samples) // 50),
        seed=seed, observables=[observable] if observable else None, workers=1, **law,
    )  # fmt: skip


def histogram_error(
    histogram: Any, unit: float, ends: tuple[float, float], shares: Callable[[FloatArray], Any],
    sizes: Callable[[FloatArray], Any],
) -> float:  # fmt: skip
    """The largest difference of densities, averaged over each bin between the two ends.

    histogram : of one time; unit : by which its edges are divided; shares, sizes : the exact share
    of each bin and its size, from its edges
    """
    edges = histogram.edges / unit
    used = np.nonzero((edges[:-1] >= ends[0]) & (edges[1:] <= ends[1]))[0]
    edges = edges[used[0] : used[-1] + 2]
    found = histogram.probability.value[0][used]
    return float(np.max(np.abs(found - shares(edges)) / sizes(edges)))


# -- problems: run time against error -------------------------------------------------------------


def scaled(effort: Effort) -> list[Row]:
    """F(c), and h and a2, of the scaling state against `ScalingSolution`; other laws at e = 0.7."""
    from kinetics import ScalingSolution, solve_scaled

    works: list[Work] = []
    for e in effort.restitutions:
        states: list[Any] = [
            (SPECTRAL, "rtol", TOLERANCES, partial(solve_scaled, e)),
            (SPECTRAL, "nodes", (16, 32, 64, 128, 256), partial(solve_scaled, e, 1e-13)),
            (CONSERVATIVE, "nodes", effort.grids(4097), partial(conservative_state, e)),
            (STRAIGHTFORWARD, "nodes", effort.grids(2049), partial(straightforward_state, e)),
            (SONINE, "order", effort.orders, partial(sonine_state, e)),
        ]
        F, apart = ScalingSolution(e).vdf(SPEEDS), _speed_error(e)
        of: Any = partial(sweep, "precision", f"scaled F(c), e = {e:g}")
        for *what, state in states:
            error = lambda found, F=F: float(np.max(np.abs(found - F)) / F.max())  # noqa: E731
            works += of(*what, lambda x, s=state: s(x).vdf(SPEEDS), error=error)
        sampled = partial(monte_carlo, e, "gaussian", [LATE[MONTE_CARLO]], "speed_histogram")
        works += of(MONTE_CARLO, "samples", effort.samples, sampled, error=apart, seeded=True)
        works += _moments(f"scaled h and a2, e = {e:g}", e, {}, states, effort)
    for name, law in OTHER_LAWS.items():
        states = [(SPECTRAL, "rtol", TOLERANCES, partial(solve_scaled, E, **law))]
        works += _moments(f"scaled h and a2, {name}, e = {E:g}", E, law, states, effort)
    return measure(works, effort)


def _speed_error(e: float) -> Callable[[Any], float]:
    """Error of F(c) from the speed histogram of a run."""
    from scipy.interpolate import CubicSpline

    from kinetics import ScalingSolution
    from kinetics.numerics.gauss import panels_between

    c = np.linspace(SPEEDS[0], SPEEDS[-1], 391)
    vdf = CubicSpline(c, ScalingSolution(e).vdf(c))  # to 1e-8: the exact one takes longer

    def shares(edges: FloatArray) -> Any:
        c, weight = panels_between(edges, 6)
        return (2.0 * math.pi * c * vdf(c) * weight).reshape(-1, 6).sum(axis=1)

    def error(run: Any) -> float:
        unit, ends = run.thermal_speed.value[0], (SPEEDS[0], SPEEDS[-1])
        areas = lambda c: math.pi * np.diff(c**2)  # noqa: E731
        return histogram_error(run.speed_histogram, unit, ends, shares, areas) / vdf(c).max()

    return error


def _moments(problem: str, e: float, law: Row, states: list[Any], effort: Effort) -> list[Work]:
    """h and 1 + a2 of a law, by several methods."""
    from kinetics import ScalingSolution

    def both(state: Any) -> Any:
        return np.array([state.cooling_rate, 1.0 + state.a2])

    def sampled(n: float, seed: int) -> Any:
        late = LATE[MONTE_CARLO]
        run = monte_carlo(e, "gaussian", [late], "", n, seed, **law)
        rate = 2.0 * MEAN_FREE_PATH / (float(run.thermal_speed.value[0]) * late)
        return both(State(rate, float(run.a2.value[0]), np.asarray))

    exact = both(ScalingSolution(e, **law))
    of: Any = partial(sweep, "precision", problem, error=lambda found: relative(found, exact))
    works: list[Work] = of(MONTE_CARLO, "samples", effort.samples, sampled, seeded=True)
    for *what, state in states:
        works += of(*what, lambda x, s=state: both(s(x)))
    return works


def cooling(effort: Effort) -> list[Row]:
    """v0(t) and a2(t) from both starts of the paper, over a short and a long time."""
    works = []
    for e in effort.restitutions[:2]:
        for start in references.STARTS:
            for horizon in references.HORIZONS:
                works += _cooling(e, start, horizon, effort)
    return measure(works, effort)


def _cooling(e: float, start: str, horizon: str, effort: Effort) -> list[Work]:
    from kinetics import Scene, solve

    times, names, short = references.times(horizon), ("thermal_speed", "a2"), horizon == "short"
    v0, a2 = (references.kept(name, e, start, horizon) for name in names)
    scene = Scene(e, DENSITY, initial=start, times=times, outputs=names)

    def averages(found: Any, value: Any = np.asarray) -> Any:
        return [value(getattr(found, name)) for name in names]

    def error(found: Any) -> float:
        return max(relative(found[0], v0), relative(1.0 + found[1], 1.0 + a2))

    def sampled(n: float, seed: int) -> Any:
        return averages(monte_carlo(e, start, times, "", n, seed), lambda x: x.value)

    def by(method: Any) -> Any:
        return lambda setting: method(e, start, times, setting)[:2]

    problem = f"v0(t), a2(t), {start}, t <= {times[-1]:.0e}, e = {e:g}"
    of = partial(sweep, "precision", problem, error=error)
    few = [n for n in effort.samples if short or n < 400_000]
    dense = effort.grids(1025 if short else 513)
    return [
        *of(SPECTRAL, "rtol", TOLERANCES, lambda rtol: averages(solve(scene, rtol))),
        *of(CONSERVATIVE, "nodes", effort.grids(4097), by(conservative_cooling)),
        *of(STRAIGHTFORWARD, "nodes", dense, by(straightforward_cooling)),
        *of(SONINE, "order", effort.orders, by(sonine_cooling)),
        *of(MONTE_CARLO, "samples", few, sampled, seeded=True),
    ]


def position(effort: Effort) -> list[Row]:
    """<r^2>(t) and kurtosis(t) of both starts, and G(R) at e = 0.6, t = 300, as in the paper."""
    starts = references.STARTS[: 1 if effort.quick else None]
    works = [
        w
        for e in effort.restitutions
        for s in references.STARTS
        for w in _displacement("msd", e, s, effort)
    ]
    works += [w for start in starts for w in _displacement("kurtosis", E, start, effort)]
    reference, more = position_density("G(R), gaussian, t = 300, e = 0.6", effort)
    rows = [reference, *measure([*works, *more], effort)]
    cannot = {
        CONSERVATIVE: "it makes densities of the speed alone",
        STRAIGHTFORWARD: "not written: it would need further matrices, of m = 1 and on",
        SONINE: "a moment expansion: it has no displacement",
    }
    return rows + [
        blank("precision", problem, method, status=NOT_AVAILABLE, note=why)
        for problem in dict.fromkeys(row["problem"] for row in rows)
        for method, why in cannot.items()
    ]


def _displacement(name: str, e: float, start: str, effort: Effort) -> list[Work]:
    from kinetics import Scene, solve

    times = references.times("short")
    exact = references.kept(name, e, start, "short")
    scene = Scene(e, DENSITY, initial=start, times=times, outputs=(name,))
    problem = f"{QUANTITIES[name]}, {start}, t <= {times[-1]:.0e}, e = {e:g}"
    of = partial(sweep, "precision", problem, error=lambda found: relative(found, exact))

    def sampled(n: float, seed: int) -> Any:
        return getattr(monte_carlo(e, start, times, "", n, seed), name).value

    works = of(SPECTRAL, "rtol", TOLERANCES, lambda rtol: getattr(solve(scene, rtol), name))
    return works + of(MONTE_CARLO, "samples", effort.samples, sampled, seeded=True)


def position_density(problem: str, effort: Effort) -> tuple[Row, list[Work]]:
    """The row of the reference, and the works, of G(R).

    No closed form is known: the reference is a tight solution, whose integrals are compared with
    <r^2> and <r^4>, which come from scalar equations without wave numbers.
    """
    from kinetics import Scene, solve, sonine
    from kinetics.numerics.gauss import panels_between

    def at(rtol: float, *outputs: str) -> Any:
        return solve(Scene(0.6, DENSITY, times=[300.0], outputs=outputs), rtol)

    rtol = 1e-7 if effort.quick else 1e-8
    kurtosis, tight = float(at(1e-12, "kurtosis").kurtosis[0]), at(rtol, "msd", "position_density")
    r, weight = panels_between(np.linspace(0.0, 24.0, 49), 24)
    g, exact = tight.scaled_position_density(r)[0] * weight, tight.scaled_position_density(RADII)[0]
    known = (("norm", 0, 1.0), ("second", 2, 1.0), ("fourth", 4, kurtosis))
    missed = {name: abs(float(g @ r**p) / value - 1.0) for name, p, value in known}
    note = "integrals of 1, R^2 and R^4 miss 1, <r^2> and <r^4> by {:.0e}, {:.0e} and {:.0e}"
    about: Row = {"setting": "rtol", "value": rtol, "asked": rtol, "extra": missed}
    about |= {"error": max(missed.values()), "note": note.format(*missed.values())}
    root = math.sqrt(tight.msd[0])

    def of_histogram(run: Any) -> float:
        shares = lambda edges: tight.position_fraction(edges * root)[0]  # noqa: E731
        unit = math.sqrt(run.msd.value[0])
        found = histogram_error(run.displacement_histogram, unit, (0.25, 4.0), shares, np.diff)
        return found / float(exact.max())

    error = lambda found: float(np.max(np.abs(found - exact)) / exact.max())  # noqa: E731
    of: Any = partial(sweep, "precision", problem, error=error)
    tolerances = (1e-2, 1e-4, 1e-5) if effort.quick else TOLERANCES[:6]
    curve = lambda rtol: at(rtol, "position_density").scaled_position_density(RADII)[0]  # noqa: E731
    works: list[Work] = of(SPECTRAL, "rtol", tolerances, curve)
    many = (*effort.samples, *(() if effort.quick else (4_000_000,)))
    sampled = partial(monte_carlo, 0.6, "gaussian", [300.0], "displacement_histogram")
    works += of(MONTE_CARLO, "samples", many, sampled, error=of_histogram, seeded=True)
    for name, form in (
        ("eq. gdefi, eta = 1/2", sonine.position_integral),
        ("eq. peakg, eta = 0.75", sonine.position_peak),
        ("eq. gammatailg, eta = 0.25, gamma = 7.39", sonine.position_tail),
    ):
        works += of(PRINTED, name, (None,), lambda _, form=form: np.asarray(form(RADII)))
    return blank("precision", problem, "reference", **about), works


def in_field(effort: Effort) -> list[Row]:
    """The steady state in a uniform field, and averages over time from rest.

    References at e = 0.7 are digits of programs of their own, else `solve_field` at 1e-12.
    """
    from kinetics import Scene, solve, solve_field

    steady = {E: (0.501926119920, 1.702146383757, 1.061388235142, 1.160252548014)}
    figures = ("drift", "mean_square_speed", "mean_square_along", "mean_speed")

    def state(e: float, rtol: float) -> tuple[float, ...]:
        found = solve_field(e, rtol=rtol)
        return tuple(getattr(found, name) for name in figures)

    works: list[Work] = []
    for e in effort.restitutions:
        exact = np.array(steady.get(e) or state(e, 1e-12))
        works += sweep("precision", f"field, steady state, e = {e:g}", SPECTRAL, "rtol",
                       TOLERANCES[:9], partial(state, e),
                       error=lambda f, exact=exact: relative(f, exact))  # fmt: skip
    # in sqrt(l/g), sqrt(g l) and l
    times, g = np.array([0.1, 0.5, 2.0, 5.0]), 0.01
    velocity = (0.09962311, 0.45545144, 0.62108221, 0.50135393)
    way = (0.004990570, 0.119322259, 1.11237376, 2.66810824)
    scene = Scene(E, DENSITY, initial="rest", times=times * math.sqrt(MEAN_FREE_PATH / g), field=g,
                  outputs=("mean_velocity", "mean_displacement"))  # fmt: skip

    def averages(rtol: float) -> Any:
        found = solve(scene, rtol)
        speed = found.mean_velocity[:, 0] / math.sqrt(g * MEAN_FREE_PATH)
        return np.array([speed, found.mean_displacement[:, 0] / MEAN_FREE_PATH])

    works += sweep("precision", f"field, from rest to t = 5 sqrt(l/g), e = {E:g}", SPECTRAL, "rtol",
                   TOLERANCES[: 4 if effort.quick else 6], averages,
                   error=lambda found: relative(found, np.array([velocity, way])))  # fmt: skip
    return measure(works, effort)


# -- error asked and reached ----------------------------------------------------------------------

FACTOR = 100.0  # asked and reached may differ by this factor
WITHIN, BETTER = "within a factor 100", "more than 100 times better than asked"
MISSED = "missed, and the status claims that it was reached"
MISSED_AND_SAID = "missed, and the status says so"


def accuracy(effort: Effort) -> list[Row]:
    """A row per problem and rtol, over every kept reference and closed form; note: the verdict."""
    problems: dict[str, Callable[[float], tuple[Any, float]]] = {}
    for e in (0.0, E, 0.99) if effort.quick else references.RESTITUTIONS:
        problems |= _states(e, f"e = {e:g}") | _in_time(e)
    for e in (0.0, E) if effort.quick else (0.0, 0.2, E, 0.95):
        for name, law in OTHER_LAWS.items():
            problems |= _states(e, f"{name}, e = {e:g}", late=True, **law)
    rows = []
    for problem, run in problems.items():
        for rtol in (10.0**-k for k in range(3, 13)):
            row = blank("accuracy", problem, SPECTRAL, setting="rtol", value=rtol, asked=rtol)
            try:
                found, error = run(rtol)
                done = found.status.name == "CONVERGED"
                note = WITHIN if error * FACTOR >= rtol else BETTER
                if not error <= rtol:
                    note = MISSED if done else MISSED_AND_SAID
                extra = {"converged": done, "ratio": error / rtol}
                row |= {"error": error, "note": note, "extra": extra}
            except Exception as met:  # whatever it is, it is a row
                row |= {"status": FAILED, "note": f"{type(met).__name__}: {met}"[:200]}
            rows.append(row)
    return rows


def _states(e: float, which: str, late: bool = False, **law: Any) -> dict[str, Any]:
    """The scaled equation, and a time so late that v0, a2 and the slope of <r^2> are limits."""
    from kinetics import ScalingSolution, Scene, solve, solve_scaled

    exact, last = ScalingSolution(e, **law), 1e30
    F, powers = exact.vdf(SPEEDS), (-0.5, 1.0, 3.0, 4.0, 6.0, 8.0)
    there = F / F.max() > 1e-25  # where F is promised relative to itself
    known = [exact.cooling_rate, *(exact.moment(p) for p in powers)]
    outputs = ("thermal_speed", "a2", "diffusion_coefficient")
    scene = Scene(e, times=[1.0, last], outputs=outputs, **law)
    path = scene.mean_free_path
    limits = 2.0 * path / (known[0] * last), 1.0 + exact.a2, exact.diffusion_slope * path**2

    def of_moments(rtol: float) -> tuple[Any, float]:
        state = solve_scaled(e, rtol, **law)
        return state, relative([state.cooling_rate, *(state.moment(p) for p in powers)], known)

    def of_density(rtol: float) -> tuple[Any, float]:
        state = solve_scaled(e, rtol, **law)
        return state, relative(state.vdf(SPEEDS[there]), F[there])

    def of_limits(rtol: float) -> tuple[Any, float]:
        found = solve(scene, rtol)
        return found, relative(
            [found.thermal_speed[1], 1.0 + found.a2[1], found.msd_slope[1]], limits
        )

    states = {f"scaled h and moments, {which}": of_moments, f"scaled F(c), {which}": of_density}
    return states | ({f"late v0, a2 and slope of <r^2>, {which}": of_limits} if late else {})


def _in_time(e: float) -> dict[str, Any]:
    """Averages at the kept times; the error of a2 is relative to 1 + a2."""
    from kinetics import Scene, solve

    def run(start: str, horizon: str, name: str, rtol: float) -> tuple[Any, float]:
        times, shift = references.times(horizon), 1.0 if name == "a2" else 0.0
        scene = Scene(e, DENSITY, initial=start, times=times, outputs=(name,))
        found = solve(scene, rtol)
        exact = shift + references.kept(name, e, start, horizon)
        return found, relative(shift + np.asarray(getattr(found, name)), exact)

    return {
        f"{shown}, {start}, t <= {references.times(horizon)[-1]:.0e}, e = {e:g}": partial(
            run, start, horizon, name
        )
        for start in references.STARTS
        for horizon in references.HORIZONS
        for name, shown in QUANTITIES.items()
        if horizon == "short" or name in ("thermal_speed", "a2")
    }


# -- what skipping saves, particles --------------------------------------------


def skipping(effort: Effort) -> list[Row]:
    """Each output of a scene alone; ``extra["ratio"]``: the whole scene's time over its own."""
    from kinetics import Gaussian, Scene, solve
    from particles import BoltzmannGrad, simulate

    times = np.geomspace(1.0, 1e4, 20)
    works: list[Work] = []

    def add(group: str, part: str, call: Callable[[], Any]) -> None:
        works.append(Work("skipping", group, part, call))

    def of(*outputs: str, rtol: float = 1e-8, **scene: Any) -> Callable[[], Any]:
        return partial(solve, Scene(**{"restitution": E, "outputs": outputs, **scene}), rtol)

    isotropic = ("thermal_speed", "a2", "collisions", "msd", "kurtosis", "speed_density")
    directed = ("thermal_speed", "mean_velocity", "velocity_tensor", "msd", "speed_density",
                "velocity_density")  # fmt: skip
    place = ("msd", "kurtosis", "diffusion_coefficient", "position_density")
    two: Row = {"times": times[::4], "initial": Gaussian(2.0, 1.0), "harmonics": 4}
    at_once: Row = {"restitution": 0.6, "times": [300.0], "rtol": 1e-4}
    for group, outputs, scene in (
        ("isotropic scene", isotropic, {"times": times, "harmonics": 4}),
        ("two-temperature scene", directed, two),
        ("displacement, e = 0.6, t = 300", place, at_once),
    ):
        add(group, "everything", of(*outputs, **scene))
        for name in outputs:
            add(group, f"{name} alone", of(name, **scene))
    for e in (0.99, 1.0):  # the elastic scene solves nothing
        call = of("thermal_speed", "a2", "speed_density", restitution=e, times=times)
        add("elastic scene, v0, a2 and density", f"e = {e:g}", call)
    for last in (1e300, 1e20, 1e12, 1e4):  # once the scaling state is reached, times cost nothing
        call = of("thermal_speed", "a2", times=np.geomspace(1.0, last, 20))
        add("last time in d/U, v0 and a2", f"t <= {last:.0e}", call)
    kinds = ("speed", "velocity_component", "displacement", "free_path")
    histograms = tuple(f"{kind}_histogram" for kind in kinds)
    for part, names in (("every histogram", histograms), ("scalars alone", ()),
                        *((f"{name} alone", (name,)) for name in histograms)):  # fmt: skip
        add("Boltzmann-Grad run, 4000 tracers", part, partial(
            simulate, BoltzmannGrad(DENSITY), E, times=times, media=4, tracers=1000, workers=1,
            observables=names or None))  # fmt: skip
    rows = measure(works, effort)
    whole = {row["problem"]: row["seconds"] for row in reversed(rows)}
    for row in rows:
        if row["seconds"] and whole[row["problem"]]:
            row["extra"] = {"ratio": whole[row["problem"]] / row["seconds"]}
    return rows


def throughput(effort: Effort) -> list[Row]:
    """Collisions per second of one and of two threads, at e = 0.9."""
    from particles import BoltzmannGrad, HardDisks, HardSpheres, Poisson, PoissonSpheres, simulate

    quick, spheres = effort.quick, 0.1 / math.pi  # per d^3: l = 10 d
    dense = (0.005, DENSITY, 0.2, 0.5) if quick else (0.001, 0.005, 0.02, DENSITY, 0.1, 0.3, 0.6)
    media: dict[str, Any] = {
        f"hard disks, {rho:g} per d^2, {n}": HardDisks(rho, count=n)
        for rho, n in (*((rho, 10_000) for rho in dense), (DENSITY, 1000), (DENSITY, 40_000))
    }
    media["overlapping disks, 0.04 per d^2, 10000"] = Poisson(DENSITY, count=10_000)
    media["Boltzmann-Grad, 0.04 per d^2"] = BoltzmannGrad(DENSITY)
    media["hard spheres, 0.032 per d^3, 10000"] = HardSpheres(spheres, count=10_000)
    media["overlapping spheres, 0.032 per d^3, 10000"] = PoissonSpheres(spheres, count=10_000)
    media["Boltzmann-Grad, 0.032 per d^3"] = BoltzmannGrad(spheres, dimension=3)
    # a run of one collision, whose time is that of placing the scatterers, and a long one
    works = [
        Work("particles", name, "particles", partial(
            simulate, medium, 0.9, max_collisions=most, media=4, tracers=tracers, workers=threads),
            threads=threads, figures=lambda run: {"collisions": run.collision_total})
        for name, medium in media.items()
        for threads in (1, 2)
        for tracers, most in ((1, 1), (300 if quick else 2000, 500))
    ]  # fmt: skip
    rows = measure(works, effort)
    for placing, whole in zip(rows[::2], rows[1::2], strict=True):
        if placing["seconds"] is None or whole["seconds"] is None:
            whole |= {"status": FAILED, "note": placing["note"] or whole["note"]}
            continue
        moving = max(whole["seconds"] - placing["seconds"], 1e-9)
        rate = whole["extra"]["collisions"] / moving
        per_medium = placing["seconds"] / 4
        whole["extra"] |= {"collisions_per_second": rate, "placing_seconds_per_medium": per_medium}
    return rows[1::2]


CASES: dict[str, Callable[[Effort], list[Row]]] = {
    "scaled": scaled, "cooling": cooling, "position": position, "field": in_field,
    "accuracy": accuracy, "skipping": skipping, "particles": throughput,
}  # fmt: skip

# -- run ------------------------------------------------------------------------------------------

_ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS"), "1"
)
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
    about, begin, records = machine(), time.perf_counter(), []
    for name in names:
        if progress is not None:
            progress(name, len(names))
        records += _in_process(name, quick)
    return BenchReport(records, quick, names, about, time.perf_counter() - begin)


def _in_process(name: str, quick: bool) -> list[Row]:
    # -P: nothing is imported from the folder that the command runs in
    command = [sys.executable, "-P", "-m", __spec__.name, name, "quick" if quick else "full"]
    try:
        done = subprocess.run(
            command, env={**os.environ, **_ONE_THREAD}, stdin=subprocess.DEVNULL,
            capture_output=True, text=True, check=False, timeout=_LONGEST[quick],
        )  # fmt: skip
        if not done.returncode:
            return json.loads(done.stdout)
        note = (done.stderr.strip().splitlines() or [f"exit status {done.returncode}"])[-1]
    except subprocess.TimeoutExpired:
        note = f"not done after {_LONGEST[quick]:g} s"
    return [blank(name, "the whole case", "all", status=FAILED, note=note[:200])]


def machine() -> Row:
    """What a time depends on: the processor and the versions. Nothing that names the machine."""
    processor = platform.processor() or platform.machine()
    if (info := Path("/proc/cpuinfo")).exists():
        lines = info.read_text(encoding="utf-8").splitlines()
        named = (line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
        processor = next(named, processor)
    packages = ("inelastic-lorentz", "numpy", "scipy", "numba")
    found = {d.metadata["Name"].lower(): d.version for d in metadata.distributions()}
    load = {"load_before": round(os.getloadavg()[0], 2)} if hasattr(os, "getloadavg") else {}
    return {
        "processor": processor, "cores": os.cpu_count(), "system": platform.system(),
        "python": platform.python_version(),
        **{name: found.get(name, "not installed") for name in packages}, **load,
    }  # fmt: skip


# -- tables and figure ----------------------------------------------------------------------------

# Time ~ error^-q at best, of the methods whose error falls without end: the order of the scheme,
# and the least work that it can do. Of the straightforward solver: second order, and filling the
# matrix; of the conservative one: second order, and one sweep; of Monte Carlo: 1/sqrt(samples).
_AT_BEST = {STRAIGHTFORWARD: 1.0, CONSERVATIVE: 0.5, MONTE_CARLO: 2.0}
_NO_ANSWER = 0.5  # a larger error than this is no point of a curve that converges
_UNITS = (("years", 365.25 * 86400.0), ("days", 86400.0), ("h", 3600.0), ("s", 1.0), ("ms", 1e-3))
_TARGETS = (1e-3, 1e-6, 1e-8)


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
    if method not in _AT_BEST or not len(best) or best["error"].item() > _NO_ANSWER:
        return math.nan, False
    return best["seconds"].item() * (best["error"].item() / target) ** _AT_BEST[method], True


def seconds_text(seconds: float, at_least: bool = False) -> str:
    """A time of two digits with its unit, years where it is long; "≥" before a lower bound."""
    if math.isnan(seconds):
        return "-"
    unit, size = next(((u, s) for u, s in _UNITS if seconds >= s), ("us", 1e-6))
    value = seconds / size
    return f"{'≥ ' * at_least}{_digits(value)} {unit}"


def _digits(value: float) -> str:
    return f"{value:.1e}" if value >= 1e4 else f"{value:.0f}" if value >= 10 else f"{value:.2g}"


def family(problem: str) -> str:
    """The name of a problem without its start and its restitution."""
    parts = (
        p for p in problem.split(", ") if p not in references.STARTS and not p.startswith("e = ")
    )
    return ", ".join(parts)


@dataclass(frozen=True)
class BenchReport:
    """A whole benchmark.

    Attributes
    ----------
    records : rows, dictionaries with the keys section, problem, method, setting, value, seconds
        (median; low and high: quartiles; wall, warm_up: of the clock), repeats, error, asked,
        status ("measured", "failed", "not available"), note, threads, extra
    quick : whether it was the quick one
    cases : names of the cases that were run
    machine : processor and versions
    seconds : that the whole of it took
    """

    records: list[Row]
    quick: bool
    cases: tuple[str, ...]
    machine: Row
    seconds: float

    def to_dataframe(self, section: str | None = None) -> Any:
        """The rows as a DataFrame; those of one section that were measured, if it is named."""
        from pandas import DataFrame

        frame = DataFrame(plain(self.records), columns=list(blank("", "", "")))
        for name in ("value", "seconds", "error", "asked"):
            frame[name] = frame[name].astype(float)
        if section is None:
            return frame
        return frame[(frame["section"] == section) & (frame["status"] == MEASURED)]

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
        about = ", ".join(f"{k.replace('_', ' ')} {v}" for k, v in self.machine.items())
        lines = [
            f"# Benchmark{' (quick)' * self.quick}", "",
            f"{about}. {self.seconds:.0f} s in all. Times are medians over repeats, which are made "
            "in turns: processor time of one thread where nothing else is said.", "",
        ]  # fmt: skip
        for title, rows, words in (
            ("Run time for an error", self._run_times(),
             "Medians over restitutions and starts. ≥: not reached; the least that it would take "
             "from its most accurate run, by the order of the method. -: it does not get there."),
            ("Error reached over error asked", self._accuracy(), ""),
            ("What skipping saves", self._skipping(), ""),
            ("Particles, e = 0.9", self._particles(), "Of two threads by the clock."),
            ("Failed and not available", self._not_measured(), ""),
        ):  # fmt: skip
            if rows:
                lines += [f"## {title}", "", *([words, ""] if words else []), *markdown_table(rows)]
        return "\n".join(lines) + "\n"

    def _run_times(self) -> list[dict[str, str]]:
        rows = []
        frame = self.to_dataframe("precision")
        for name, group in frame.groupby(frame["problem"].map(family), sort=False):
            for method in METHODS:
                problems = [p for _, p in group[group["method"] == method].groupby("problem")]
                if not problems:
                    continue
                row = {"problem": name, "method": method}
                for target in _TARGETS:  # the upper one of two in the middle; never: the most
                    costs = sorted((seconds_for(p, method, target) for p in problems),
                                   key=lambda c: math.inf if c[0] != c[0] else c[0])  # fmt: skip
                    row[f"{target:.0e}"] = seconds_text(*costs[len(costs) // 2])
                least = sorted(p["error"].min() for p in problems)
                rows.append(row | {"least error": f"{least[len(least) // 2]:.1e}"})
        return rows

    def _accuracy(self) -> list[dict[str, str]]:
        rows = []
        for rtol, here in self.to_dataframe("accuracy").groupby("asked", sort=False):
            ratios = here["error"] / rtol
            found = (ratios.min(), ratios.median(), ratios.max())
            row = {"rtol": f"{rtol:.0e}", "problems": str(len(here))}
            row |= dict(zip(("least", "median", "most"), (f"{x:.1e}" for x in found), strict=True))
            rows.append(
                row | {n: str((here["note"] == n).sum()) for n in (MISSED, MISSED_AND_SAID, BETTER)}
            )
        return rows

    def _skipping(self) -> list[dict[str, str]]:
        return [
            {"scene": row.problem, "asked for": row.method, "time": seconds_text(row.seconds),
             "whole scene's time over it": _digits(row.extra["ratio"])}
            for row in self.to_dataframe("skipping").itertuples()
        ]  # fmt: skip

    def _particles(self) -> list[dict[str, str]]:
        return [
            {"medium": row.problem, "threads": str(row.threads),
             "million collisions per second": f"{row.extra['collisions_per_second'] / 1e6:.1f}",
             "placing one medium": seconds_text(row.extra["placing_seconds_per_medium"])}
            for row in self.to_dataframe("particles").itertuples()
        ]  # fmt: skip

    def _not_measured(self) -> list[dict[str, str]]:
        return [
            {"status": row["status"], "problem": row["problem"], "method": row["method"],
             "setting": f"{row['setting']} {'' if row['value'] is None else row['value']}".strip(),
             "why": row["note"]}
            for row in self.records
            if row["status"] != MEASURED
        ]  # fmt: skip

    def work_precision(self) -> str | None:
        """Run time against error on the scaled equation and in a field, as text of an SVG file.

        A column for each restitution; every run is a dot, and a line joins those of a method that
        none of its others beats in time and error. Colours after Okabe and Ito. None without rows.
        """
        frame = self.to_dataframe("precision")
        frame = frame[(frame["seconds"] > 0.0) & frame["error"].notna()]
        frame = frame[frame["problem"].str.startswith(("scaled", "field"))]
        if not len(frame):
            return None
        import matplotlib as mpl
        from matplotlib.backends.backend_svg import FigureCanvasSVG
        from matplotlib.figure import Figure

        frame[["quantity", "e"]] = frame["problem"].str.rsplit(", e = ", n=1, expand=True)
        frame["error"] = frame["error"].clip(1e-16, 10.0)
        quantities, columns = (
            list(dict.fromkeys(frame["quantity"])),
            sorted(set(frame["e"]), key=float),
        )
        colours = ("#0072b2", "#009e73", "#d55e00", "#cc79a7", "#222222")
        file = io.StringIO()
        style: Any = {
            "svg.fonttype": "none",
            "svg.hashsalt": "inelastic-lorentz",
            "axes.grid": True,
        }
        with mpl.rc_context(style | {"grid.color": "#d8d8d8", "axes.titlesize": 10.0}):
            size = (9.375, 1.1 + 2.5 * len(quantities))  # as wide as a page of 900 px
            figure = Figure(figsize=size, layout="constrained", facecolor="white")
            FigureCanvasSVG(figure)
            axes = figure.subplots(
                len(quantities), len(columns), squeeze=False, sharex=True, sharey=True
            )
            legend = {}
            for (quantity, e), panel in frame.groupby(["quantity", "e"], sort=False):
                axis = axes[quantities.index(quantity), columns.index(e)]
                axis.set_title(f"{quantity}, e = {e}")
                for method, colour, marker in zip(METHODS, colours, "os^vx", strict=False):
                    runs = panel[panel["method"] == method].sort_values("seconds")
                    front = runs[runs["error"] < runs["error"].shift().cummin().fillna(np.inf)]
                    look = {"color": colour, "marker": marker, "markersize": 4.5}
                    if len(runs):
                        axis.plot(runs["seconds"], runs["error"], ls="none", alpha=0.3, **look)
                        (legend[method],) = axis.plot(front["seconds"], front["error"], **look)
            axes[0, 0].set(xscale="log", yscale="log", ylim=(1e-16, 30.0))
            for axis in axes.flat:
                axis.set_visible(bool(axis.lines))
            figure.legend(legend.values(), legend, loc="outside upper center", ncols=len(legend))
            figure.supxlabel("run time, one thread [s]")
            figure.supylabel("largest relative error")
            figure.savefig(file, format="svg", metadata={"Date": None})
        return file.getvalue()


if __name__ == "__main__":
    _rows = CASES[sys.argv[1]](QUICK if sys.argv[2] == "quick" else FULL)
    sys.stdout.write(dumps(_rows))
