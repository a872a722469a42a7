"""Measures the constants of kinetics/moments and prints them beside the values used.

Run as a script: python tests/kinetics/measurements/moments.py (half a minute).
"""

from __future__ import annotations

import itertools
import time
from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np

from kinetics import CollisionLaw, Gaussian
from kinetics.moments import backward, velocity
from kinetics.moments.backward import BackwardEquation, Observable, speed_power

OBSERVABLES = {
    "v^-1/4": speed_power(-0.25),
    "v": speed_power(1.0),
    "v^2": speed_power(2.0),
    "v^4": speed_power(4.0),
    "v^6": speed_power(6.0),
    "v cos(phi)": speed_power(1.0, 1),
    "v cos(4 phi)": speed_power(1.0, 4),
    "v^2 cos(2 phi)": speed_power(2.0, 2),
    "collisions": backward.MEAN_COLLISIONS,
    "x of a beam": backward.DISPLACEMENT_ALONG_START,
    "r^2": backward.SQUARED_DISPLACEMENT,
    "r^4": backward.quartic_displacement(2),
    "slope of r^2": backward.MSD_SLOPE,
}
RESTITUTIONS = (
    0.0,
    0.05,
    0.15,
    0.25,
    0.35,
    0.45,
    0.55,
    0.7,
    0.8,
    0.86,
    0.92,
    0.98,
    0.999,
    1 - 1e-6,
)
NODES = range(6, 18)
HIGHEST = 22.0  # X up to which is solved
TOLERANCES = (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12)


def panel_sums(equation: BackwardEquation, y: Observable) -> Any:
    """max(last, before/10) of the Chebyshev coefficients over the smaller end, by panel."""
    last, before = equation.rule.last_coefficients(equation.solve(y))
    scale = equation.solve(backward.scale_of(y))
    return np.maximum(last, 0.1 * before) / backward.smaller_ends(scale)


def evaluate(equation: BackwardEquation, y: Observable, x: Any) -> Any:
    """y(X) at X = x, on the panels."""
    return equation.reduced(y, equation.locate(x))[1]


def true_error(equation: BackwardEquation, exact: BackwardEquation, y: Observable) -> float:
    """Largest error relative to the scale of y, against 30 nodes a panel."""
    x = np.linspace(backward.START + 0.01, HIGHEST - 2.0, 1600)
    truth, scale = evaluate(exact, y, x), evaluate(exact, backward.scale_of(y), x)
    with np.errstate(invalid="ignore"):
        return float(np.nanmax(np.abs((evaluate(equation, y, x) - truth) / scale)))


def best_of(run: Callable[[], Any], repeats: int = 7) -> float:
    """Least time of a call, in milliseconds."""
    taken = []
    for _ in range(repeats):
        start = time.perf_counter()
        run()
        taken.append(time.perf_counter() - start)
    return 1e3 * min(taken)


def measure_estimates() -> None:
    """Errors over coefficients, and nodes guessed less nodes needed."""
    ratios, off = [], Counter[int]()
    for e in RESTITUTIONS:
        law = CollisionLaw(e)
        exact = BackwardEquation(law, HIGHEST, 30)
        needed: dict[tuple[str, float], int] = {}
        for nodes in range(NODES.start - 1, 23):
            equation = BackwardEquation(law, HIGHEST, nodes)
            for (name, y), rtol in itertools.product(OBSERVABLES.items(), TOLERANCES):
                if equation.error_estimate(y) <= rtol:
                    needed.setdefault((name, rtol), nodes)
            if nodes not in NODES:
                continue
            for y in OBSERVABLES.values():
                error = true_error(equation, exact, y)
                if 1e-12 < error < 1e-2:
                    ratios.append(error / panel_sums(equation, y).sum())
        for (name, rtol), nodes in needed.items():
            times, p = np.array([1e9]), OBSERVABLES[name].degree
            guess = velocity.Averages(law, 1.0, Gaussian(), times, rtol, max(p, 2.0))
            off[guess.equation.nodes - nodes] += 1
    print("backward._LAST, ten times backward._BEFORE: error over the larger of the last")
    print("Chebyshev coefficient and a tenth of the one before, and a quarter more:")
    print(f"  used {backward._LAST}, measured {1.25 * max(ratios):.2f} in {len(ratios)} solves")
    print("velocity._NODES, _PER_POWER, _PER_DIGIT: nodes guessed less nodes needed: how often")
    print(f"  {dict(sorted(off.items()))}")


def measure_many_times() -> None:
    """From how many times on, and from how many points on, interpolation in ln t is quicker."""
    print("velocity._MANY times a node of the panels in ln t, velocity._FEW_POINTS points:")
    print(f"  used {velocity._MANY} and {velocity._FEW_POINTS}; ms one by one / interpolated")
    kept = velocity._MANY, velocity._FEW_POINTS, velocity._PIECE
    panels, nodes = 10, 15
    for points, share in itertools.product((2, 4, 16, 120), (1, 2, 4)):
        times = np.geomspace(1e-1, 1e-1 * np.exp(panels), share * panels * nodes)
        taken = []
        for many in (10**9, 0):
            velocity._MANY, velocity._FEW_POINTS = many, 0
            averages = velocity.Averages(CollisionLaw(0.7), 1.0, Gaussian(), times, 1e-8)
            averages.average(speed_power(2.0))
            speeds = averages.speeds
            kept_points = np.linspace(0, speeds.x.size - 1, points).astype(int)
            few = velocity.LogMeasure(speeds.x[kept_points], speeds.weight[kept_points])
            run = lambda a=averages, f=few: (a._known.clear(), a._at_times(f, speed_power(2.0), 0))  # noqa: E731
            taken.append(best_of(run))
        print(f"  {points:4} points, {share} times a node: {taken[0]:.2f} / {taken[1]:.2f}")
    velocity._MANY, velocity._FEW_POINTS, velocity._PIECE = kept
    print(f"velocity._PIECE points at once: used {velocity._PIECE}; ms for 4000 times")
    times = np.geomspace(1e-1, 1e5, 4000)
    for piece in (500, 5000, 50_000, 500_000):
        velocity._MANY, velocity._PIECE = 10**9, piece
        averages = velocity.Averages(CollisionLaw(0.7), 1.0, Gaussian(), times, 1e-8)
        averages.average(speed_power(2.0))
        run = lambda a=averages: (a._known.clear(), a.average(speed_power(2.0)))  # noqa: E731
        print(f"  {piece}: {best_of(run, 3):.1f}")
    velocity._MANY, velocity._FEW_POINTS, velocity._PIECE = kept


if __name__ == "__main__":
    measure_estimates()
    measure_many_times()
