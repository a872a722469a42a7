"""The same trajectories as formats of file, compared with the equation.

python examples/compare_formats.py
"""

import tempfile
from pathlib import Path

import h5py
import numpy as np

from kinetics import compare
from particles import BoltzmannGrad, simulate

TIMES = np.array([0.0, 1.0, 10.0, 100.0])  # d/U
N = 2000

# Stands for anybody's simulation: tracers with e = 0.75 at number density 0.04, absolute positions.
run = simulate(
    BoltzmannGrad(0.04), restitution=0.75, times=TIMES, media=20, tracers=N // 20, seed=2,
    observables=("positions", "velocities"),
)  # fmt: skip
R = run.positions + np.random.default_rng(1).uniform(0, 50, (N, 2))
V = run.velocities


def csv(path: Path) -> None:
    """One row for each tracer at each time, with other names of columns."""
    table = np.column_stack(
        [np.repeat(TIMES, N), np.tile(np.arange(N), TIMES.size), R.reshape(-1, 2), V.reshape(-1, 2)]
    )
    np.savetxt(path, table, delimiter=",", header="t,id,x,y,v_x,v_y", comments="", fmt="%.17g")


def npz(path: Path) -> None:
    """Arrays of frames."""
    np.savez(path, times=TIMES, positions=R, velocities=V)


def h5md(path: Path) -> None:
    """H5MD, as MD codes write it."""
    with h5py.File(path, "w") as file:
        file.create_group("h5md").attrs["version"] = [1, 1]
        for name, values in (("position", R), ("velocity", V)):
            element = file.create_group(f"particles/tracers/{name}")
            element["value"], element["time"], element["step"] = values, TIMES, np.arange(4)


def dump(path: Path) -> None:
    """A LAMMPS text dump with unwrapped positions; a step is 0.5 d/U."""
    with open(path, "w") as file:
        for time, r, v in zip(TIMES, R, V, strict=True):
            file.write(f"ITEM: TIMESTEP\n{round(time / 0.5)}\nITEM: NUMBER OF ATOMS\n{N}\n")
            file.write("ITEM: BOX BOUNDS pp pp pp\n0 50\n0 50\n-0.5 0.5\n")
            file.write("ITEM: ATOMS id xu yu vx vy\n")
            table = np.column_stack([np.arange(N), r, v])
            np.savetxt(file, table, fmt=["%d"] + ["%.17g"] * 4)


def xyz(path: Path) -> None:
    """Extended XYZ."""
    with open(path, "w") as file:
        for time, r, v in zip(TIMES.tolist(), R, V, strict=True):
            file.write(f"{N}\nProperties=id:I:1:pos:R:2:vel:R:2 Time={time!r}\n")
            np.savetxt(file, np.column_stack([np.arange(N), r, v]), fmt=["%d"] + ["%.17g"] * 4)


FILES = {
    "run.csv": csv, "run.npz": npz, "run.h5md": h5md, "run.dump": dump, "run.xyz": xyz,
    "ours.h5md": run.write_h5md,
}  # fmt: skip
RESULTS = {}
with tempfile.TemporaryDirectory() as folder:
    for name, write in FILES.items():
        path = Path(folder) / name
        write(path)
        RESULTS[name] = compare(
            path, restitution=0.75, number_density=0.04, timestep=0.5, explain=False
        )

if __name__ == "__main__":
    for name, result in RESULTS.items():
        print(f"{name}: {result.verdict}, <r^2> p = {result.p_value('msd'):.4g}")
