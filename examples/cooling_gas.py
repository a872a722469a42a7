"""Thermal speed and mean square displacement of a cooling tracer, by two methods.

python examples/cooling_gas.py
"""

import numpy as np

from kinetics import Scene, solve
from particles import BoltzmannGrad, simulate

TIMES = np.geomspace(1, 1000, 7)  # d/U

scene = Scene(restitution=0.7, number_density=0.04, times=TIMES, outputs=("thermal_speed", "msd"))
solution = solve(scene, rtol=1e-10)
ensemble = simulate(BoltzmannGrad(0.04), restitution=0.7, times=TIMES, tracers=200)

# How many standard errors the particles are from the equation.
speed_sigmas = (
    ensemble.thermal_speed.value - solution.thermal_speed
) / ensemble.thermal_speed.error
msd_sigmas = (ensemble.msd.value - solution.msd) / ensemble.msd.error

if __name__ == "__main__":
    print("  t [d/U]   v0 [U]   sigmas   <r^2> [d^2]   sigmas")
    rows = zip(TIMES, solution.thermal_speed, speed_sigmas, solution.msd, msd_sigmas, strict=True)
    for t, v0, z0, msd, z in rows:
        print(f"{t:9.1f}  {v0:7.4f}  {z0:+7.1f}  {msd:12.2f}  {z:+7.1f}")
