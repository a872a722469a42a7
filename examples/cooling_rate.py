"""The cooling rate h(e): the closed form, the solver, particles, and what the paper printed.

python examples/cooling_rate.py
"""

import numpy as np

from kinetics import ScalingSolution, solve_scaled, sonine
from particles import BoltzmannGrad, simulate

RESTITUTIONS = (0.4, 0.6, 0.7, 0.9)
NUMBER_DENSITY = 0.04  # scatterers per d^2
TIMES = np.array([1e3, 1e5])  # d/U, long after the Gaussian start is forgotten


def particle_rate(restitution: float) -> float:
    """h from the slope of 1/v0(t) of tracers with random free paths (paper, eq. veq)."""
    run = simulate(BoltzmannGrad(NUMBER_DENSITY), restitution=restitution, times=TIMES, tracers=500)
    slope = np.diff(1 / run.thermal_speed.value) / np.diff(TIMES)
    return float(slope[0] / NUMBER_DENSITY)


TABLE = [
    (
        e,
        ScalingSolution(e).cooling_rate,
        solve_scaled(restitution=e).cooling_rate,
        particle_rate(e),
        float(sonine.cooling_rate(e)),
        float(sonine.cooling_rate_fitted(e)),
    )
    for e in RESTITUTIONS
]

if __name__ == "__main__":
    print("  e   exact     solver    particles  Sonine    1.45 (1-e)")
    for e, *rates in TABLE:
        print(f"{e:4.1f}", "  ".join(f"{rate:8.5f}" for rate in rates))
