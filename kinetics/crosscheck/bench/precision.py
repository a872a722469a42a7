"""Error against run time: all methods on the same problems, against references.

Error measures, all relative:

- scaled F(c): the largest |F - F_exact| over 0.1 <= c <= 4, over the largest F_exact there;
- scaled h and a2: the larger error of h and of 1 + a2;
- v0(t), a2(t): the largest error of v0 and of 1 + a2 over 25 log-spaced times;
- <r^2>(t): the largest error over 25 log-spaced times.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.bench import references, sonine_orders, straightforward
from kinetics.crosscheck.bench.record import Record, failed, not_available, timed
from kinetics.crosscheck.bench.timing import Effort, measure

FloatArray = NDArray[np.float64]

SECTION = "precision"
SPECTRAL, CONSERVATIVE = "spectral", "conservative"
STRAIGHTFORWARD, SONINE, MONTE_CARLO = "straightforward", "Sonine", "Monte Carlo"
METHODS = (SPECTRAL, CONSERVATIVE, STRAIGHTFORWARD, SONINE, MONTE_CARLO)

NUMBER_DENSITY = 0.04  # of the paper: l = references.MEAN_FREE_PATH
SCALED_SPEEDS = np.linspace(0.1, 4.0, 79)
_LATE = {CONSERVATIVE: 1e10, MONTE_CARLO: 1e7}  # d/U, where the scaling state is reached
_TIGHTEST = 1e-13  # rtol of the runs whose nodes are given
_MEDIA = 50  # blocks of a Monte Carlo run
_TOLERANCES = tuple(10.0**-k for k in range(2, 13))
_NO_DENSITY = "a moment expansion: it has no displacement"


def restitutions(effort: Effort) -> tuple[float, ...]:
    """Those that are measured."""
    return (0.7,) if effort.quick else (0.7, 0.95, 0.2)


def sweep(
    problem: str,
    method: str,
    setting: str,
    values: Sequence[float],
    work: Callable[[Any], Any],
    error: Callable[[Any], float],
    effort: Effort,
    section: str = SECTION,
) -> list[Record]:
    """A row per value of the setting; what fails is a row too."""
    rows = []
    for value in values:
        where: dict[str, Any] = {"setting": setting, "value": float(value)}
        if setting == "rtol":
            where["asked"] = float(value)
        try:
            result, timing = measure(partial(work, value), effort)
            reached = error(result)
        except Exception as met:  # whatever it is, it is a row and not the end of the run
            why = f"{type(met).__name__}: {met}"
            rows.append(failed(section, problem, method, why, **where))
            continue
        if math.isfinite(reached):
            rows.append(timed(section, problem, method, timing, error=reached, **where))
        else:
            values_found = np.concatenate([np.ravel(x) for x in np.atleast_1d(result)])
            bad = int(np.sum(~np.isfinite(values_found)))
            why = f"{bad} of {values_found.size} values are no finite number"
            rows.append(failed(section, problem, method, why, seconds=timing.cpu.median, **where))
    return rows


def relative(value: Any, exact: Any) -> float:
    """The largest relative error."""
    with np.errstate(all="ignore"):
        return float(np.max(np.abs(np.asarray(value) / np.asarray(exact) - 1.0)))


# -- the scaled equation ------------------------------------------------------------------------


def scaled(effort: Effort) -> list[Record]:
    """F(c), and h and a2, of the scaling state; the reference is `kinetics.ScalingSolution`."""
    rows: list[Record] = []
    for e in restitutions(effort):
        rows += _scaled_density(e, effort) + _scaled_moments(e, effort)
    return rows


def _orders(effort: Effort) -> list[int]:
    return [1, 2, 3, 5, 10, 20] if effort.quick else list(range(1, 21))


def _samples(effort: Effort) -> list[int]:
    return [1_000, 7_000, 49_000] if effort.quick else [1_000, 10_000, 100_000, 400_000]


def _grids(effort: Effort, largest: int) -> list[int]:
    """Numbers of nodes, doubling."""
    least = 65
    grids = [least]
    while 2 * grids[-1] - 1 <= largest // (2 if effort.quick else 1):
        grids.append(2 * grids[-1] - 1)
    return grids


def _fastest(e: float) -> float:
    """Upper end of v t/l for the straightforward solver: the mean 1/kappa, and a tail e^-y."""
    from kinetics import CollisionLaw

    return 30.0 + 2.0 / CollisionLaw(e).mean_log_loss


def _scaled_density(e: float, effort: Effort) -> list[Record]:
    from kinetics import ScalingSolution, solve_scaled

    problem = f"scaled F(c), e = {e:g}"
    c = SCALED_SPEEDS
    exact = ScalingSolution(e)
    F = exact.vdf(c)

    def error(found: FloatArray) -> float:
        return float(np.max(np.abs(found - F)) / F.max())

    def spectral(rtol: float) -> Any:
        return solve_scaled(e, rtol).vdf(c)

    def spectral_nodes(nodes: float) -> Any:
        return solve_scaled(e, _TIGHTEST, nodes=int(nodes)).vdf(c)

    def sonine(order: float) -> FloatArray:
        return sonine_orders.solve_scaled(e, int(order)).vdf(c)

    def dense(nodes: float) -> FloatArray:
        return straightforward.solve_scaled(e, int(nodes), _fastest(e)).vdf(c)

    def monte_carlo(samples: float) -> Any:
        return _particles(
            e, "gaussian", np.array([_LATE[MONTE_CARLO]]), int(samples), ("speed_histogram",)
        )

    return [
        *sweep(problem, SPECTRAL, "rtol", _TOLERANCES, spectral, error, effort),
        *sweep(problem, SPECTRAL, "nodes", (16, 32, 64, 128, 256), spectral_nodes, error, effort),
        *sweep(
            problem,
            CONSERVATIVE,
            "nodes",
            _grids(effort, 4097),
            lambda n: _conservative_vdf(e, int(n)),
            error,
            effort,
        ),
        *sweep(problem, STRAIGHTFORWARD, "nodes", _grids(effort, 2049), dense, error, effort),
        *sweep(problem, SONINE, "order", _orders(effort), sonine, error, effort),
        *sweep(
            problem,
            MONTE_CARLO,
            "samples",
            _samples(effort),
            monte_carlo,
            lambda run: histogram_error(run, exact),
            effort,
        ),
    ]


def _scaled_moments(e: float, effort: Effort) -> list[Record]:
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
        speed, a2 = _conservative_cooling(e, "gaussian", np.array([late]), int(nodes))
        return 2.0 * references.MEAN_FREE_PATH / (speed[0] * late), 1.0 + a2[0]

    def monte_carlo(samples: float) -> tuple[float, float]:
        late = _LATE[MONTE_CARLO]
        run = _particles(e, "gaussian", np.array([late]), int(samples))
        rate = 2.0 * references.MEAN_FREE_PATH / (run.thermal_speed.value[0] * late)
        return rate, 1.0 + run.a2.value[0]

    def dense(nodes: float) -> tuple[float, float]:
        return both(straightforward.solve_scaled(e, int(nodes), _fastest(e)))

    def sonine(order: float) -> tuple[float, float]:
        return both(sonine_orders.solve_scaled(e, int(order)))

    def of(
        method: str, setting: str, values: Sequence[float], work: Callable[[Any], Any]
    ) -> list[Record]:
        return sweep(problem, method, setting, values, work, error, effort)

    return [
        *of(SPECTRAL, "rtol", _TOLERANCES, lambda rtol: both(solve_scaled(e, rtol))),
        *of(CONSERVATIVE, "nodes", _grids(effort, 4097), conservative),
        *of(STRAIGHTFORWARD, "nodes", _grids(effort, 2049), dense),
        *of(SONINE, "order", _orders(effort), sonine),
        *of(MONTE_CARLO, "samples", _samples(effort), monte_carlo),
    ]


# -- the time-dependent equation ------------------------------------------------------------------


def cooling(effort: Effort) -> list[Record]:
    """v0(t) and a2(t) from both starts of the paper, over a short and a long time."""
    rows: list[Record] = []
    for e in restitutions(effort)[:2]:
        for start in references.STARTS:
            for horizon in references.HORIZONS:
                rows += _cooling(e, start, horizon, effort)
    return rows


def _cooling(e: float, start: str, horizon: str, effort: Effort) -> list[Record]:
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
        return _panels(e, start, times, int(nodes))

    def conservative(nodes: float) -> tuple[FloatArray, FloatArray]:
        return _conservative_cooling(e, start, times, int(nodes))

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

    def monte_carlo(samples: float) -> tuple[FloatArray, FloatArray]:
        run = _particles(e, start, times, int(samples))
        return run.thermal_speed.value, run.a2.value

    def of(
        method: str, setting: str, values: Sequence[float], work: Callable[[Any], Any]
    ) -> list[Record]:
        return sweep(problem, method, setting, values, work, error, effort)

    largest = 1025 if horizon == "short" else 513
    samples = [n for n in _samples(effort) if n < 400_000 or horizon == "short"]
    return [
        *of(SPECTRAL, "rtol", _TOLERANCES, spectral),
        *of(SPECTRAL, "nodes", (6, 8, 10, 12, 16, 20), spectral_nodes),
        *of(CONSERVATIVE, "nodes", _grids(effort, 4097), conservative),
        *of(STRAIGHTFORWARD, "nodes", _grids(effort, largest), dense),
        *of(SONINE, "order", _orders(effort), sonine),
        *of(MONTE_CARLO, "samples", samples, monte_carlo),
    ]


# -- position ---------------------------------------------------------------------------------


def position(effort: Effort) -> list[Record]:
    """<r^2>(t), and what is missing: G(R)."""
    from kinetics import Scene, solve

    rows: list[Record] = []
    times = references.times("short")
    for e in restitutions(effort):
        for start in references.STARTS:
            problem = f"<r^2>(t), {start}, t <= {times[-1]:.0e}, e = {e:g}"
            exact = references.reference("msd", e, start, "short")
            scene = Scene(e, NUMBER_DENSITY, initial=start, times=times, outputs=("msd",))

            def error(found: FloatArray, exact: FloatArray = exact) -> float:
                return relative(found, exact)

            def spectral(rtol: float, scene: Scene = scene) -> FloatArray:
                return solve(scene, rtol).msd

            def monte_carlo(samples: float, e: float = e, start: str = start) -> FloatArray:
                return np.asarray(_particles(e, start, times, int(samples)).msd.value)

            def of(
                method: str,
                setting: str,
                values: Sequence[float],
                work: Callable[[Any], Any],
                problem: str = problem,
                error: Callable[[Any], float] = error,
            ) -> list[Record]:
                return sweep(problem, method, setting, values, work, error, effort)

            rows += of(SPECTRAL, "rtol", _TOLERANCES, spectral)
            rows += of(MONTE_CARLO, "samples", _samples(effort), monte_carlo)
            rows += [
                not_available(SECTION, problem, method, why)
                for method, why in (
                    (CONSERVATIVE, "it makes densities of the speed alone"),
                    (STRAIGHTFORWARD, "not written: it would need a second matrix for m = 1"),
                    (SONINE, _NO_DENSITY),
                )
            ]
    rows += [
        not_available(SECTION, "G(R)", method, "no solver gives G(R) yet")
        for method in (SPECTRAL, STRAIGHTFORWARD)
    ]
    return rows


# -- the methods of this package, asked in the way that the comparison needs -------------------


def _panels(e: float, start: str, times: FloatArray, nodes: int) -> tuple[FloatArray, FloatArray]:
    """The spectral averages with so many nodes in a panel of the backward equation."""
    from kinetics import CollisionLaw
    from kinetics.evolve import Averages
    from kinetics.initial import NAMED

    averages = Averages(
        CollisionLaw(e), references.MEAN_FREE_PATH, NAMED[start], times, 1e-13, nodes=nodes
    )
    second, fourth = averages.power(2.0), averages.power(4.0)
    return (
        np.asarray(np.exp(averages.log_reference) * np.sqrt(second)),
        np.asarray(0.5 * fourth / second**2 - 1.0),
    )


def conservative(e: float, start: str, times: FloatArray, nodes: int) -> Any:
    """The conservative scheme's speed density, as a user asks for it.

    At the tightest tolerance the scheme itself serves every time; none is left to the scaling
    state, which is spectral.
    """
    from kinetics import Scene, solve

    scene = Scene(e, NUMBER_DENSITY, initial=start, times=times, outputs=("speed_density",))
    return solve(scene, _TIGHTEST, method=CONSERVATIVE, nodes=nodes)


def _conservative_cooling(
    e: float, start: str, times: FloatArray, nodes: int
) -> tuple[FloatArray, FloatArray]:
    """v0 and a2 from the conservative scheme."""
    return _density_moments(conservative(e, start, times, nodes), start, nodes)


def _density_moments(solution: Any, start: str, nodes: int) -> tuple[FloatArray, FloatArray]:
    """v0 and a2 from the density: the trapezoid rule in ln v, four points for each node."""
    # from far below the scaling state's thermal speed at the end up to the fastest of the start
    slowest = 1e-5 * min(1.0, references.MEAN_FREE_PATH / solution.times[-1])
    fastest = 2.0 * straightforward.FASTEST[start]
    v = np.geomspace(slowest, fastest, 4 * nodes)
    weight = solution.speed_density(v) * v * math.log(v[1] / v[0])
    second, fourth = (weight @ v**p + solution.uncollided for p in (2, 4))
    return np.sqrt(second), 0.5 * fourth / second**2 - 1.0


def _conservative_vdf(e: float, nodes: int) -> FloatArray:
    """F(c) from the conservative scheme at a late time."""
    late = np.array([_LATE[CONSERVATIVE]])
    solution = conservative(e, "gaussian", late, nodes)
    thermal = float(_density_moments(solution, "gaussian", nodes)[0][0])
    density = solution.speed_density(SCALED_SPEEDS * thermal)[0] * thermal
    return np.asarray(density / (2.0 * math.pi * SCALED_SPEEDS))


def _particles(
    e: float,
    start: Any,
    times: FloatArray,
    samples: int,
    observables: tuple[str, ...] = (),
) -> Any:
    from particles import BoltzmannGrad, simulate

    return simulate(
        BoltzmannGrad(NUMBER_DENSITY),
        restitution=e,
        initial=start,
        times=times,
        media=_MEDIA,
        tracers=max(1, samples // _MEDIA),
        observables=observables or None,
        workers=1,
    )


def histogram_error(run: Any, exact: Any) -> float:
    """Error of F(c) from a speed histogram at its only time, against the exact mean of each bin."""
    c = run.speed_histogram.edges / run.thermal_speed.value[0]
    low, high = c[:-1], c[1:]
    used = (low >= SCALED_SPEEDS[0]) & (high <= SCALED_SPEEDS[-1])
    low, high = low[used], high[used]
    share = run.speed_histogram.probability.value[0][used]
    x, w = np.polynomial.legendre.leggauss(6)
    points = 0.5 * (low + high)[:, None] + 0.5 * (high - low)[:, None] * x
    inside = 0.5 * (high - low) * ((2.0 * math.pi * points * exact.vdf(points)) @ w)
    area = math.pi * (high**2 - low**2)
    largest = float(exact.vdf(SCALED_SPEEDS).max())
    return float(np.max(np.abs(share - inside) / area) / largest)
