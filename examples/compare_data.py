"""Particle data from any code, as rows of numbers, compared with the kinetic equation.

python examples/compare_data.py
"""

import tempfile
from pathlib import Path

import numpy as np

from kinetics import compare
from particles import BoltzmannGrad, simulate

TIMES = np.geomspace(1, 300, 6)  # d/U

# Stands for anybody's simulation: 5000 tracers with e = 0.75 at number density 0.04.
run = simulate(
    BoltzmannGrad(0.04), restitution=0.75, times=TIMES, media=50, tracers=100, seed=2,
    observables=("positions", "velocities"),
)  # fmt: skip
n = 5000
columns = {
    "time": np.repeat(TIMES, n),
    "x": run.positions[:, :, 0].ravel(),
    "y": run.positions[:, :, 1].ravel(),
    "vx": run.velocities[:, :, 0].ravel(),
    "vy": run.velocities[:, :, 1].ravel(),
    "tracer": np.tile(np.arange(n), TIMES.size),
}

with tempfile.TemporaryDirectory() as folder:
    path = Path(folder) / "data.npz"
    np.savez(path, **columns)
    RIGHT = compare(path, restitution=0.75, number_density=0.04)
    WRONG = compare(path, restitution=0.70, number_density=0.04)
    FOUND = compare(path)  # restitution and density from the data themselves

if __name__ == "__main__":
    for told, result in (("e = 0.75", RIGHT), ("e = 0.70", WRONG), ("nothing told", FOUND)):
        print(f"{told}: {result.verdict}, thermal speed p = {result.p_value('thermal_speed'):.2g}")
    for item in WRONG.explanations:
        if item.outcome == "explains":
            print(f"  {item.name} = {item.value:.4f} +- {item.error:.4f} explains the difference")
    for name, parameter in FOUND.parameters.items():
        print(f"  {name} = {parameter.value:.5g} +- {parameter.error:.2g}")
