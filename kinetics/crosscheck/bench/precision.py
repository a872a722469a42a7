"""Error against run time: all methods on the same problems, against references.

Error measures, all relative:

- scaled F(c): the largest |F - F_exact| over 0.1 <= c <= 4, over the largest F_exact there;
- scaled h and a2: the larger error of h and of 1 + a2;
- v0(t), a2(t): the largest error of v0 and of 1 + a2 over 25 log-spaced times.

Those of the displacement are in :mod:`kinetics.crosscheck.bench.position`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.bench import methods, references, sonine_orders, straightforward
from kinetics.crosscheck.bench.methods import (
    CONSERVATIVE,
    MONTE_CARLO,
    NUMBER_DENSITY,
    SONINE,
    SPECTRAL,
    STRAIGHTFORWARD,
    TIGHTEST,
)
from kinetics.crosscheck.bench.record import Record
from kinetics.crosscheck.bench.sweeps import Sweep, run_sweeps
from kinetics.crosscheck.bench.timing import Effort

FloatArray = NDArray[np.float64]

SECTION = "precision"
SCALED_SPEEDS = np.linspace(0.1, 4.0, 79)
_LATE = {CONSERVATIVE: 1e10, MONTE_CARLO: 1e7}  # d/U, where the scaling state is reached
TOLERANCES = tuple(10.0**-k for k in range(2, 13))


def restitutions(effort: Effort) -> tuple[float, ...]:
    """Those that are measured."""
    return (0.7,) if effort.quick else (0.7, 0.95, 0.2)


def relative(value: Any, exact: Any) -> float:
    """The largest relative error."""
    with np.errstate(all="ignore"):
        return float(np.max(np.abs(np.asarray(value) / np.asarray(exact) - 1.0)))


# -- the scaled equation ------------------------------------------------------------------------


def scaled(effort: Effort) -> list[Record]:
    """F(c), and h and a2, of the scaling state; the reference is `kinetics.ScalingSolution`."""
    sweeps: list[Sweep] = []
    for e in restitutions(effort):
        sweeps += _scaled_density(e, effort) + _scaled_moments(e, effort)
    return run_sweeps(sweeps, effort)


def _orders(effort: Effort) -> list[int]:
    return [1, 2, 3, 5, 10, 20] if effort.quick else list(range(1, 21))


def sample_numbers(effort: Effort) -> list[int]:
    """Of Monte Carlo runs."""
    return [1_000, 5_000, 25_000] if effort.quick else [1_000, 10_000, 100_000, 400_000]


def _grids(effort: Effort, largest: int) -> list[int]:
    """Numbers of nodes, doubling."""
    least = 65
    grids = [least]
    while 2 * grids[-1] - 1 <= largest // (4 if effort.quick else 1):
        grids.append(2 * grids[-1] - 1)
    return grids


def _fastest(e: float) -> float:
    """Upper end of v t/l for the straightforward solver: the mean 1/kappa, and a tail e^-y."""
    from kinetics import CollisionLaw

    return 30.0 + 2.0 / CollisionLaw(e).mean_log_loss


def _scaled_density(e: float, effort: Effort) -> list[Sweep]:
    from kinetics import ScalingSolution, solve_scaled

    problem = f"scaled F(c), e = {e:g}"
    c = SCALED_SPEEDS
    exact = ScalingSolution(e)
    F, between = exact.vdf(c), interpolated(exact)

    def error(found: FloatArray) -> float:
        return float(np.max(np.abs(found - F)) / F.max())

    def spectral(rtol: float) -> Any:
        return solve_scaled(e, rtol).vdf(c)

    def spectral_nodes(nodes: float) -> Any:
        return solve_scaled(e, TIGHTEST, nodes=int(nodes)).vdf(c)

    def sonine(order: float) -> FloatArray:
        return sonine_orders.solve_scaled(e, int(order)).vdf(c)

    def dense(nodes: float) -> FloatArray:
        return straightforward.solve_scaled(e, int(nodes), _fastest(e)).vdf(c)

    def conservative(nodes: float) -> FloatArray:
        return methods.conservative_vdf(e, int(nodes), _LATE[CONSERVATIVE], c)

    def monte_carlo(samples: float, seed: int) -> Any:
        late = np.array([_LATE[MONTE_CARLO]])
        return methods.particles(e, "gaussian", late, int(samples), seed, ("speed_histogram",))

    of = partial(Sweep, SECTION, problem, error=error)
    return [
        of(SPECTRAL, "rtol", TOLERANCES, spectral),
        of(SPECTRAL, "nodes", (16, 32, 64, 128, 256), spectral_nodes),
        of(CONSERVATIVE, "nodes", _grids(effort, 4097), conservative),
        of(STRAIGHTFORWARD, "nodes", _grids(effort, 2049), dense),
        of(SONINE, "order", _orders(effort), sonine),
        of(
            MONTE_CARLO,
            "samples",
            sample_numbers(effort),
            monte_carlo,
            error=lambda run: histogram_error(run, between),
            seeded=True,
        ),
    ]


def _scaled_moments(e: float, effort: Effort) -> list[Sweep]:
    from kinetics import ScalingSolution, solve_scaled

    problem = f"scaled h and a2, e = {e:g}"
    exact = ScalingSolution(e)
    target = np.array([exact.cooling_rate, 1.0 + exact.a2])

    def error(found: Any) -> float:
        return relative(found, target)

    def both(state: Any) -> tuple[float, float]:
        return state.cooling_rate, 1.0 + state.a2

    def conservative(nodes: float) -> tuple[float, float]:
        late = _LATE[CONSERVATIVE]
        speed, a2 = methods.conservative_cooling(e, "gaussian", np.array([late]), int(nodes))
        return 2.0 * references.MEAN_FREE_PATH / (speed[0] * late), 1.0 + a2[0]

    def monte_carlo(samples: float, seed: int) -> tuple[float, float]:
        late = _LATE[MONTE_CARLO]
        run = methods.particles(e, "gaussian", np.array([late]), int(samples), seed)
        rate = 2.0 * references.MEAN_FREE_PATH / (run.thermal_speed.value[0] * late)
        return rate, 1.0 + run.a2.value[0]

    def dense(nodes: float) -> tuple[float, float]:
        return both(straightforward.solve_scaled(e, int(nodes), _fastest(e)))

    def sonine(order: float) -> tuple[float, float]:
        return both(sonine_orders.solve_scaled(e, int(order)))

    of = partial(Sweep, SECTION, problem, error=error)
    return [
        of(SPECTRAL, "rtol", TOLERANCES, lambda rtol: both(solve_scaled(e, rtol))),
        of(CONSERVATIVE, "nodes", _grids(effort, 4097), conservative),
        of(STRAIGHTFORWARD, "nodes", _grids(effort, 2049), dense),
        of(SONINE, "order", _orders(effort), sonine),
        of(MONTE_CARLO, "samples", sample_numbers(effort), monte_carlo, seeded=True),
    ]


# -- the time-dependent equation ------------------------------------------------------------------


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
    problem = f"v0(t), a2(t), {start}, t <= {times[-1]:.0e}, e = {e:g}"
    speed = references.reference("thermal_speed", e, start, horizon)
    a2 = references.reference("a2", e, start, horizon)
    scene = Scene(e, NUMBER_DENSITY, initial=start, times=times, outputs=("thermal_speed", "a2"))

    def error(found: tuple[FloatArray, FloatArray]) -> float:
        return max(relative(found[0], speed), relative(1.0 + found[1], 1.0 + a2))

    def spectral(rtol: float) -> tuple[FloatArray, FloatArray]:
        solution = solve(scene, rtol)
        return solution.thermal_speed, solution.a2

    def spectral_nodes(nodes: float) -> tuple[FloatArray, FloatArray]:
        return methods.panels(e, start, times, int(nodes))

    def conservative(nodes: float) -> tuple[FloatArray, FloatArray]:
        return methods.conservative_cooling(e, start, times, int(nodes))

    def dense(nodes: float) -> tuple[FloatArray, FloatArray]:
        found = straightforward.solve_cooling(
            e,
            references.MEAN_FREE_PATH,
            start,
            times,
            int(nodes),
            # tuned: tighter gains nothing at this spacing, looser loses digits
            min(1e-3, 2.0 / nodes**2),
        )
        return found.thermal_speed, found.a2

    def sonine(order: float) -> tuple[FloatArray, FloatArray]:
        return sonine_orders.solve_cooling(
            e, references.MEAN_FREE_PATH, start, times, int(order), 1e-8
        )

    def monte_carlo(samples: float, seed: int) -> tuple[FloatArray, FloatArray]:
        run = methods.particles(e, start, times, int(samples), seed)
        return run.thermal_speed.value, run.a2.value

    of = partial(Sweep, SECTION, problem, error=error)
    largest = 1025 if horizon == "short" else 513
    samples = [n for n in sample_numbers(effort) if n < 400_000 or horizon == "short"]
    return [
        of(SPECTRAL, "rtol", TOLERANCES, spectral),
        of(SPECTRAL, "nodes", (6, 8, 10, 12, 16, 20), spectral_nodes),
        of(CONSERVATIVE, "nodes", _grids(effort, 4097), conservative),
        of(STRAIGHTFORWARD, "nodes", _grids(effort, largest), dense),
        of(SONINE, "order", _orders(effort), sonine),
        of(MONTE_CARLO, "samples", samples, monte_carlo, seeded=True),
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
