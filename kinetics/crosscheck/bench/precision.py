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

from kinetics.crosscheck import references
from kinetics.crosscheck.bench import methods, straightforward
from kinetics.crosscheck.bench.methods import (
    CONSERVATIVE,
    LATE,
    MONTE_CARLO,
    NUMBER_DENSITY,
    SONINE,
    SPECTRAL,
    STRAIGHTFORWARD,
    TIGHTEST,
)
from kinetics.crosscheck.bench.record import PRECISION, Record
from kinetics.crosscheck.bench.sweeps import Sweep, run_sweeps
from kinetics.crosscheck.bench.timing import Effort

FloatArray = NDArray[np.float64]

SCALED_SPEEDS = np.linspace(0.1, 4.0, 79)
TOLERANCES = tuple(10.0**-k for k in range(2, 13))


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
    """F(c), and h and a2, of the scaling state; the reference is `kinetics.ScalingSolution`."""
    return run_sweeps([s for e in restitutions(effort) for s in _scaled(e, effort)], effort)


def _scaled(e: float, effort: Effort) -> list[Sweep]:
    """Both problems: every method has a state with the same names, and the particles a run."""
    from kinetics import CollisionLaw, ScalingSolution, solve_scaled

    exact = ScalingSolution(e)
    F, between = exact.vdf(SCALED_SPEEDS), interpolated(exact)
    target = np.array([exact.cooling_rate, 1.0 + exact.a2])
    # upper end of v t/l for the straightforward solver: the mean 1/kappa, and a tail e^-y
    fastest = 30.0 + 2.0 / CollisionLaw(e).mean_log_loss

    def vdf_error(found: FloatArray) -> float:
        return float(np.max(np.abs(found - F)) / F.max())

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
    vdf = partial(Sweep, PRECISION, f"scaled F(c), e = {e:g}", error=vdf_error)
    both = partial(Sweep, PRECISION, f"scaled h and a2, e = {e:g}",
                   error=lambda found: relative(found, target))  # fmt: skip
    sweeps = [
        vdf(method, setting, values, lambda x, solve=solve: solve(x).vdf(SCALED_SPEEDS))
        for method, setting, values, solve in states
    ]
    sweeps += [
        both(method, setting, values, lambda x, solve=solve: moments(solve(x)))
        for method, setting, values, solve in states
    ]
    samples = (MONTE_CARLO, "samples", sample_numbers(effort))
    return [
        *sweeps,
        vdf(*samples, histogram, error=lambda run: histogram_error(run, between), seeded=True),
        both(*samples, lambda n, seed: moments(methods.monte_carlo_state(e, n, seed)), seeded=True),
    ]


def interpolated(exact: Any) -> Callable[[FloatArray], FloatArray]:
    """F(c) over SCALED_SPEEDS, to 1e-8: the exact one takes longer than a run of the particles."""
    from scipy.interpolate import CubicSpline

    c = np.linspace(SCALED_SPEEDS[0], SCALED_SPEEDS[-1], 391)
    spline: Callable[[FloatArray], FloatArray] = CubicSpline(c, exact.vdf(c))
    return spline


def histogram_error(run: Any, vdf: Callable[[FloatArray], FloatArray]) -> float:
    """Error of F(c) from a speed histogram at its only time, against the exact mean of each bin."""
    c = run.speed_histogram.edges / run.thermal_speed.value[0]
    low, high = c[:-1], c[1:]
    used = (low >= SCALED_SPEEDS[0]) & (high <= SCALED_SPEEDS[-1])
    low, high = low[used], high[used]
    share = run.speed_histogram.probability.value[0][used]
    x, w = np.polynomial.legendre.leggauss(6)
    points = 0.5 * (low + high)[:, None] + 0.5 * (high - low)[:, None] * x
    inside = 0.5 * (high - low) * ((2.0 * math.pi * points * vdf(points)) @ w)
    area = math.pi * (high**2 - low**2)
    largest = float(vdf(SCALED_SPEEDS).max())
    return float(np.max(np.abs(share - inside) / area) / largest)


# -- the time-dependent equation -------------------------------------------------------------------


def cooling(effort: Effort) -> list[Record]:
    """v0(t) and a2(t) from both starts of the paper, over a short and a long time."""
    sweeps: list[Sweep] = []
    for e in restitutions(effort)[:2]:
        for start in references.STARTS:
            for horizon in references.HORIZONS:
                sweeps += _cooling(e, start, horizon, effort)
    return run_sweeps(sweeps, effort)


def _cooling(e: float, start: str, horizon: str, effort: Effort) -> list[Sweep]:
    from kinetics import Scene, solve

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
        return straightforward.solve_cooling(
            e, references.MEAN_FREE_PATH, start, times, nodes, rtol
        )

    def monte_carlo(samples: float, seed: int) -> tuple[FloatArray, FloatArray]:
        run = methods.particles(e, start, times, samples, seed)
        return run.thermal_speed.value, run.a2.value

    name = f"v0(t), a2(t), {start}, t <= {times[-1]:.0e}, e = {e:g}"
    of = partial(Sweep, PRECISION, name, error=error)
    largest = 1025 if horizon == "short" else 513
    samples = [n for n in sample_numbers(effort) if n < 400_000 or horizon == "short"]
    return [
        of(SPECTRAL, "rtol", TOLERANCES, spectral),
        of(CONSERVATIVE, "nodes", _grids(effort, 4097),
           lambda nodes: methods.conservative_cooling(e, start, times, nodes)),
        of(STRAIGHTFORWARD, "nodes", _grids(effort, largest), dense),
        of(SONINE, "order", _orders(effort),
           lambda order: methods.sonine_cooling(e, start, times, order)),
        of(MONTE_CARLO, "samples", samples, monte_carlo, seeded=True),
    ]  # fmt: skip
