"""Measures again the theory of a finite density against simulations: kinetics/collision/medium.py.

For each medium, restitution and density the deviation of <r^2> and v0 (simulation over theory less
1, in per cent) at times in l/U, for the dilute equation and the orders of the theory, and the
standard errors of the simulation. The second order is fitted so that its rows vanish at late times.

Then the error that the theory has of its own, for `lorentz compare`: root mean squares, for each
medium and density over restitutions and times, of the relative deviation of simulations from the
theory (<v(0).v>: over v0(0) v0(t)), less the simulations' own variance, divided by the density n;
before 30 l/U, and from then on. kinetics/crosscheck/compare/theory.py has them, rounded up.

    python -m tests.kinetics.measurements.density [tracers]     40 minutes with 400,000
"""

from __future__ import annotations

import itertools
import sys

import numpy as np

from kinetics import Scene, solve
from kinetics.collision.medium import ORDERS
from kinetics.numerics import FloatArray
from particles import Ensemble, HardDisks, Poisson, simulate

SETTLED = 30.0  # in l/U
MEDIA = 1000  # a tracer or two of each: those of one medium start near each other
TIMES = np.array([5.0, 30.0, 100.0, 300.0, 1000.0])  # in l/U, l = 1/(2 n)
ELASTIC_TIMES = np.array([10.0, 30.0, 60.0, 100.0])
ALL_TIMES = np.array([0.5, 1.0, 2.0, 4.0, 8.0, 15.0, 30.0, 60.0, 100.0, 200.0, 500.0, 1000.0])
AVERAGES = ("thermal_speed", "a2", "msd", "kurtosis", "velocity_autocorrelation")


def simulated(name: str, e: float, n: float, times: FloatArray, tracers: int) -> Ensemble:
    """Averages of so many tracers at times in d/U."""
    return simulate(
        HardDisks(n, count=5000) if name == "hard disks" else Poisson(n),
        restitution=e, initial="gaussian", times=times, media=MEDIA,
        tracers=max(2, tracers // MEDIA), max_collisions=None, seed=7, workers=1,
    )  # fmt: skip


def deviations(name: str, e: float, n: float, tracers: int) -> dict[str, tuple[FloatArray, ...]]:
    """Row -> deviations of <r^2> and of v0 in per cent, (n_times,) each; the errors as a row."""
    times = (TIMES if e < 1.0 else ELASTIC_TIMES) / (2.0 * n)
    run, found = simulated(name, e, n, times, tracers), {}
    for order in ("dilute", *ORDERS):
        more = {} if order == "dilute" else {"scatterers": name, "density_order": order}
        exact = solve(Scene(e, n, times=times, outputs=("msd", "thermal_speed"), **more))
        ratios = run.msd.value / exact.msd, run.thermal_speed.value / exact.thermal_speed
        found[order] = tuple(100.0 * (ratio - 1.0) for ratio in ratios)
    both = run.msd, run.thermal_speed
    found["error"] = tuple(100.0 * estimate.error / estimate.value for estimate in both)
    return found


def squares(name: str, e: float, n: float, tracers: int) -> dict[str, FloatArray]:
    """Squared deviation of each average over n^2, without its statistical part, (n_times,)."""
    times = (ALL_TIMES if e < 1.0 else ALL_TIMES[ALL_TIMES <= 100.0]) / (2.0 * n)
    run, found = simulated(name, e, n, times, tracers), {}
    exact = solve(Scene(e, n, times=times, outputs=AVERAGES, scatterers=name))
    for average in AVERAGES:
        data, theory = getattr(run, average), getattr(exact, average)
        size = {"a2": 1.0 + theory, AVERAGES[-1]: 2**0.5 * exact.thermal_speed}.get(average, theory)
        found[average] = ((data.value - theory) ** 2 - data.error**2) / (n * size) ** 2
    return found


if __name__ == "__main__":
    tracers = int(sys.argv[1]) if len(sys.argv) > 1 else 400_000
    for name, n, e in itertools.product(
        ("hard disks", "overlapping"), (0.02, 0.04, 0.1), (0.3, 0.5, 0.7, 0.9, 1.0)
    ):
        print(f"{name}, n = {n:g}, e = {e:g}: <r^2> and v0")
        for row, (msd, speed) in deviations(name, e, n, tracers).items():
            print(f"{row:>8}", *(f"{x:6.2f}" for x in msd), "  ", *(f"{x:6.2f}" for x in speed))
    for name, n in itertools.product(("hard disks", "overlapping"), (0.02, 0.04, 0.06, 0.1)):
        every: dict[tuple[str, str], list[float]] = {}
        for e in (0.4, 0.55, 0.7, 0.9, 1.0):
            for average, values in squares(name, e, n, tracers).items():
                early = ALL_TIMES[: values.size] < SETTLED
                every.setdefault((average, "before"), []).append(float(values[early].mean()))
                every.setdefault((average, "after"), []).append(float(values[~early].mean()))
        for (average, when), means in every.items():
            size = np.sqrt(max(np.mean(means), 0))
            print(f"{name}, n = {n:g}: {average} {when} {SETTLED:g} l/U: {size:.2f} n")
