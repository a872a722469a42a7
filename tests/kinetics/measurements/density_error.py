"""Measures the error that the theory of a finite density has of its own, for `lorentz compare`.

Root mean squares, at each density over restitutions, media and times, of the relative deviation of
simulations from the theory, less the simulations' own variance, divided by the density n; before
30 l/U, and from then on. kinetics/crosscheck/compare/theory.py has them, rounded up.

    python -m tests.kinetics.measurements.density_error [tracers]     eight minutes with 400,000
"""

from __future__ import annotations

import itertools
import sys

import numpy as np

from kinetics import Scene, solve
from kinetics.numerics import FloatArray
from tests.kinetics.measurements.density import simulated

TIMES = np.array([0.5, 1.0, 2.0, 4.0, 8.0, 15.0, 30.0, 60.0, 100.0, 200.0, 500.0, 1000.0])  # l/U
LAST_ELASTIC = 100.0
SETTLED = 30.0  # in l/U
AVERAGES = ("thermal_speed", "a2", "msd", "kurtosis")


def squares(name: str, e: float, n: float, tracers: int) -> dict[str, FloatArray]:
    """Squared deviation of each average over n^2, without its statistical part, (n_times,)."""
    times = (TIMES if e < 1.0 else TIMES[TIMES <= LAST_ELASTIC]) / (2.0 * n)
    run = simulated(name, e, n, times, tracers)
    exact = solve(Scene(e, n, times=times, outputs=AVERAGES, scatterers=name))
    found = {}
    for average in AVERAGES:
        data, theory = getattr(run, average), getattr(exact, average)
        size = 1.0 + theory if average == "a2" else theory
        found[average] = ((data.value - theory) ** 2 - data.error**2) / (n * size) ** 2
    return found


if __name__ == "__main__":
    tracers = int(sys.argv[1]) if len(sys.argv) > 1 else 100_000
    for n in (0.02, 0.04, 0.06, 0.1):
        every: dict[tuple[str, str], list[float]] = {}
        for e, name in itertools.product((0.4, 0.55, 0.7, 0.9, 1.0), ("hard disks", "overlapping")):
            for average, values in squares(name, e, n, tracers).items():
                early = TIMES[: values.size] < SETTLED
                every.setdefault((average, "before"), []).append(float(values[early].mean()))
                every.setdefault((average, "after"), []).append(float(values[~early].mean()))
        for (average, when), means in every.items():
            size = np.sqrt(max(np.mean(means), 0))
            print(f"n = {n:g}: {average:>13} {when:>6} {SETTLED:g} l/U: {size:.2f} n")
