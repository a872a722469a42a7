"""Run time against error: all methods on the same problems, against references.

Error measures, all relative:

- scaled F(c): the largest |F - F_exact| over 0.1 <= c <= 4, over the largest F_exact there;
- scaled h and a2: the larger error of h and of 1 + a2;
- v0(t), a2(t): the largest error of v0 and of 1 + a2 over 25 log-spaced times.

Those of the displacement are in `position`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from kinetics import CollisionLaw, ScalingSolution, Scene, solve, solve_scaled
from kinetics.crosscheck import references
from kinetics.crosscheck.bench import methods, straightforward
from kinetics.crosscheck.bench.measuring import Effort, Work, measure, sweep
from kinetics.crosscheck.bench.methods import (
    CONSERVATIVE,
    LATE,
    MONTE_CARLO,
    NUMBER_DENSITY,
    OTHER_LAWS,
    SONINE,
    SPECTRAL,
    STRAIGHTFORWARD,
    TIGHTEST,
)
from kinetics.crosscheck.bench.record import PRECISION, Record
from kinetics.numerics.gauss import panels_between

FloatArray = NDArray[np.float64]

SCALED_SPEEDS = np.linspace(0.1, 4.0, 79)
TOLERANCES = tuple(10.0**-k for k in range(2, 13))
QUANTITIES = {
    "thermal_speed": "v0(t)", "a2": "1 + a2(t)", "msd": "<r^2>(t)", "kurtosis": "kurtosis(t)",
}  # fmt: skip
"""Outputs as the names of problems have them."""


def restitutions(effort: Effort) -> tuple[float, ...]:
    """Those that are measured."""
    return (0.7,) if effort.quick else (0.7, 0.95, 0.2)


def sample_numbers(effort: Effort) -> list[int]:
    """Of Monte Carlo runs."""
    return [1_000, 5_000, 25_000] if effort.quick else [1_000, 10_000, 100_000, 400_000]


def relative(value: Any, exact: Any) -> float:
    """The largest relative error."""
    with np.errstate(all="ignore"):
        return float(np.max(np.abs(np.asarray(value) / np.asarray(exact) - 1.0)))


def _orders(effort: Effort) -> list[int]:
    return [1, 2, 3, 5, 10, 20] if effort.quick else list(range(1, 21))


def _grids(effort: Effort, largest: int) -> list[int]:
    """Numbers of nodes, doubling from 65."""
    most = largest // 4 if effort.quick else largest
    return [n for n in (64 * 2**k + 1 for k in range(7)) if n <= most]


# -- the scaled equation ---------------------------------------------------------------------------


def scaled(effort: Effort) -> list[Record]:
    """F(c), and h and a2, of the scaling state; the reference is `kinetics.ScalingSolution`.

    Laws that are not smooth disks are at e = 0.7, and by the two methods that have them.
    """
    works = [work for e in restitutions(effort) for work in scaled_works(e, effort)]
    works += [work for name in OTHER_LAWS for work in scaled_works_of(name, effort)]
    return measure(works, effort)


def scaled_works_of(name: str, effort: Effort, e: float = 0.7) -> list[Work]:
    """h and a2 of one of the `OTHER_LAWS`."""
    law = OTHER_LAWS[name]
    exact = ScalingSolution(e, **law)
    target = np.array([exact.cooling_rate, 1.0 + exact.a2])

    def moments(state: Any) -> tuple[float, float]:
        return state.cooling_rate, 1.0 + state.a2

    def sampled(samples: float, seed: int) -> tuple[float, float]:
        return moments(methods.monte_carlo_state(e, samples, seed, **law))

    of = partial(sweep, PRECISION, f"scaled h and a2, {name}, e = {e:g}",
                 error=lambda found: relative(found, target))  # fmt: skip
    return [
        *of(SPECTRAL, "rtol", TOLERANCES, lambda rtol: moments(solve_scaled(e, rtol, **law))),
        *of(MONTE_CARLO, "samples", sample_numbers(effort), sampled, seeded=True),
    ]


def scaled_works(e: float, effort: Effort) -> list[Work]:
    """Both problems: every method has a state with the same names, and the particles a run."""
    exact = ScalingSolution(e)
    F, between = exact.vdf(SCALED_SPEEDS), interpolated(exact)
    target = np.array([exact.cooling_rate, 1.0 + exact.a2])
    # upper end of v t/l for the straightforward solver: the mean 1/kappa, and a tail e^-y
    fastest = 30.0 + 2.0 / CollisionLaw(e).mean_log_loss

    def moments(state: Any) -> tuple[float, float]:
        return state.cooling_rate, 1.0 + state.a2

    def histogram(samples: float, seed: int) -> Any:
        late = np.array([LATE[MONTE_CARLO]])
        return methods.particles(e, "gaussian", late, samples, seed, ("speed_histogram",))

    states: list[tuple[str, str, Any, Callable[[Any], Any]]] = [
        (SPECTRAL, "rtol", TOLERANCES, lambda rtol: solve_scaled(e, rtol)),
        (SPECTRAL, "nodes", (16, 32, 64, 128, 256), lambda n: solve_scaled(e, TIGHTEST, nodes=n)),
        (CONSERVATIVE, "nodes", _grids(effort, 4097), partial(methods.conservative_state, e)),
        (STRAIGHTFORWARD, "nodes", _grids(effort, 2049),
         lambda n: straightforward.solve_scaled(e, n, fastest)),
        (SONINE, "order", _orders(effort), partial(methods.sonine_state, e)),
    ]  # fmt: skip
    vdf = partial(sweep, PRECISION, f"scaled F(c), e = {e:g}",
                  error=lambda found: float(np.max(np.abs(found - F)) / F.max()))  # fmt: skip
    both = partial(sweep, PRECISION, f"scaled h and a2, e = {e:g}",
                   error=lambda found: relative(found, target))  # fmt: skip
    works = []
    for method, setting, values, state in states:
        row = (method, setting, values)
        works += vdf(*row, lambda x, state=state: state(x).vdf(SCALED_SPEEDS))
        works += both(*row, lambda x, state=state: moments(state(x)))
    samples = (MONTE_CARLO, "samples", sample_numbers(effort))
    works += vdf(*samples, histogram, error=lambda run: vdf_error(run, between), seeded=True)
    works += both(
        *samples, lambda n, seed: moments(methods.monte_carlo_state(e, n, seed)), seeded=True
    )
    return sorted(works, key=lambda work: work.problem)  # F(c) first


def interpolated(exact: Any) -> Callable[[FloatArray], FloatArray]:
    """F(c) over SCALED_SPEEDS, to 1e-8: the exact one takes longer than a run of the particles."""
    c = np.linspace(SCALED_SPEEDS[0], SCALED_SPEEDS[-1], 391)
    spline: Callable[[FloatArray], FloatArray] = CubicSpline(c, exact.vdf(c))
    return spline


def vdf_error(run: Any, vdf: Callable[[FloatArray], FloatArray]) -> float:
    """Error of F(c) from the speed histogram of a run at its only time."""

    def shares(edges: FloatArray) -> FloatArray:
        c, weight = panels_between(edges, 6)
        return np.asarray((2.0 * math.pi * c * vdf(c) * weight).reshape(-1, 6).sum(axis=1))

    speeds = (SCALED_SPEEDS[0], SCALED_SPEEDS[-1])
    unit = run.thermal_speed.value[0]
    found = binned(run.speed_histogram, unit, speeds, shares, lambda c: math.pi * np.diff(c**2))
    return found / float(vdf(SCALED_SPEEDS).max())


def binned(
    histogram: Any,
    unit: float,
    ends: tuple[float, float],
    shares: Callable[[FloatArray], FloatArray],
    sizes: Callable[[FloatArray], FloatArray],
) -> float:
    """The largest difference of densities, averaged over each bin between the two ends.

    histogram : measured at one time; unit : which its edges are divided by; shares, sizes : the
    exact share of each bin and its size, (n,) each, from n + 1 edges
    """
    edges = histogram.edges / unit
    used = np.nonzero((edges[:-1] >= ends[0]) & (edges[1:] <= ends[1]))[0]
    edges = edges[used[0] : used[-1] + 2]
    found = histogram.probability.value[0][used]
    return float(np.max(np.abs(found - shares(edges)) / sizes(edges)))


# -- the time-dependent equation -------------------------------------------------------------------


def cooling(effort: Effort) -> list[Record]:
    """v0(t) and a2(t) from both starts of the paper, over a short and a long time."""
    works: list[Work] = []
    for e in restitutions(effort)[:2]:
        for start in references.STARTS:
            for horizon in references.HORIZONS:
                works += _cooling(e, start, horizon, effort)
    return measure(works, effort)


def _cooling(e: float, start: str, horizon: str, effort: Effort) -> list[Work]:
    times = references.times(horizon)
    speed = references.kept("thermal_speed", e, start, horizon)
    a2 = references.kept("a2", e, start, horizon)
    scene = Scene(e, NUMBER_DENSITY, initial=start, times=times, outputs=("thermal_speed", "a2"))

    def error(found: tuple[FloatArray, FloatArray]) -> float:
        return max(relative(found[0], speed), relative(1.0 + found[1], 1.0 + a2))

    def spectral(rtol: float) -> tuple[FloatArray, FloatArray]:
        solution = solve(scene, rtol)
        return solution.thermal_speed, solution.a2

    def dense(nodes: int) -> tuple[FloatArray, FloatArray]:
        # a tighter rtol gains nothing at this spacing, a looser one loses digits
        rtol = min(1e-3, 2.0 / nodes**2)
        path = references.MEAN_FREE_PATH
        return straightforward.solve_cooling(e, path, start, times, nodes, rtol)

    def monte_carlo(samples: float, seed: int) -> tuple[FloatArray, FloatArray]:
        run = methods.particles(e, start, times, samples, seed)
        return run.thermal_speed.value, run.a2.value

    name = f"v0(t), a2(t), {start}, t <= {times[-1]:.0e}, e = {e:g}"
    of = partial(sweep, PRECISION, name, error=error)
    largest = 1025 if horizon == "short" else 513
    samples = [n for n in sample_numbers(effort) if n < 400_000 or horizon == "short"]
    conservative = partial(methods.conservative_cooling, e, start, times)
    return [
        *of(SPECTRAL, "rtol", TOLERANCES, spectral),
        *of(CONSERVATIVE, "nodes", _grids(effort, 4097), conservative),
        *of(STRAIGHTFORWARD, "nodes", _grids(effort, largest), dense),
        *of(SONINE, "order", _orders(effort), partial(methods.sonine_cooling, e, start, times)),
        *of(MONTE_CARLO, "samples", samples, monte_carlo, seeded=True),
    ]
