"""Measures again the theory of a finite density against simulations: kinetics/collision/medium.py.

For each medium, restitution and density the deviation of <r^2> and v0 (simulation over theory less
1, in per cent) at times in l/U, for the dilute equation and the orders of the theory, and the
standard errors of the simulation. The second order is fitted so that its rows vanish at late times.

Then the error that the theory has of its own: root mean squares, for each
medium and density over restitutions and times, of the relative deviation of simulations from the
theory, less the simulations' own variance, divided by the density n; before 30 l/U, and from then
on. The largest ones, point by point, which `lorentz compare` has, are from `model_error`.

    python -m tests.kinetics.measurements.density [tracers]     40 minutes with 400,000
"""

from __future__ import annotations

import itertools
import sys

import numpy as np

from kinetics import Scene, solve
from kinetics.collision.medium import ORDERS
from kinetics.numerics import FloatArray
from particles import HardDisks, Poisson, simulate

SETTLED = 30.0  # in l/U
MEDIA = 1000  # few tracers of each: those of one medium start near each other
TIMES = np.array([0.5, 1.0, 2.0, 4.0, 8.0, 15.0, 30.0, 60.0, 100.0, 200.0, 500.0, 1000.0])  # l/U
AVERAGES = ("msd", "thermal_speed", "a2", "kurtosis", "velocity_autocorrelation")


def deviations(name: str, e: float, n: float, tracers: int) -> dict[str, FloatArray]:
    """Order -> relative deviations of the averages (of 1 + a2; of <v(0).v> over v0(0) v0(t)), shape
    (n_averages, n_times); and "error", those of the simulation.
    """
    times = (TIMES if e < 1.0 else TIMES[TIMES <= 100.0]) / (2.0 * n)
    run = simulate(
        HardDisks(n, count=5000) if name == "hard disks" else Poisson(n),
        restitution=e, initial="gaussian", times=times, media=MEDIA,
        tracers=max(2, tracers // MEDIA), max_collisions=None, seed=7, workers=1,
    )  # fmt: skip
    data, found = [getattr(run, average) for average in AVERAGES], {}
    for order in ("dilute", *ORDERS):
        more = {} if order == "dilute" else {"scatterers": name, "density_order": order}
        exact = solve(Scene(e, n, times=times, outputs=AVERAGES, **more))
        theory = np.array([getattr(exact, average) for average in AVERAGES])
        size = theory + np.array([[0.0], [0.0], [1.0], [0.0], [0.0]])
        size[-1] = 2**0.5 * exact.thermal_speed
        found[order] = (np.array([x.value for x in data]) - theory) / size
    return found | {"error": np.array([x.error for x in data]) / size}


if __name__ == "__main__":
    tracers = int(sys.argv[1]) if len(sys.argv) > 1 else 400_000
    for name, n in itertools.product(("hard disks", "overlapping"), (0.02, 0.04, 0.1)):
        every = []
        for e in (0.3, 0.4, 0.55, 0.7, 0.9, 1.0):
            print(f"{name}, n = {n:g}, e = {e:g}: <r^2> and v0")
            found = deviations(name, e, n, tracers)
            for row, values in found.items():
                print(f"{row:>8}", *(" ".join(f"{100 * x:6.2f}" for x in v) for v in values[:2]))
            square = (found["second"] ** 2 - found["error"] ** 2) / n**2
            early = TIMES[: square.shape[1]] < SETTLED
            every.append([square[:, early].mean(axis=1), square[:, ~early].mean(axis=1)])
        sizes = np.sqrt(np.maximum(np.mean(every, axis=0), 0.0))
        for average, before, after in zip(AVERAGES, *sizes, strict=True):
            print(f"{name}, n = {n:g}: {average} {before:.2f} n, from {SETTLED:g} l/U {after:.2f}")
