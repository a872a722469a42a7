"""Run `lorentz.c` and keep its tracks: python tests/outside/outside_tracks.py

Needs a C compiler. 1,000 tracers in 50 configurations among 2,000 hard disks of density 0.04, at
e = 0.7; lengths in d, speeds in U, times in d/U.
"""

import subprocess
import tempfile
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
RESTITUTION = 0.7
DENSITY = 0.04
DISKS = 2000
MEDIA = 50
TRACERS = 20
TIMES = (0.0, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0)
FILE = HERE / "hard-disks-e0.7-n0.04.npz"


def run_program(restitution: float, density: float, seed: int) -> np.ndarray:
    """Compile and run the program; rows of medium, tracer, time, x, y, vx, vy."""
    with tempfile.TemporaryDirectory() as folder:
        program = str(Path(folder) / "lorentz")
        subprocess.run(["cc", "-O2", "-o", program, str(HERE / "lorentz.c"), "-lm"], check=True)
        numbers = [restitution, density, DISKS, MEDIA, TRACERS, seed, *TIMES]
        command = [program, *(f"{number:g}" for number in numbers)]
        text = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return np.array([line.split() for line in text.splitlines()], dtype=float)


def columns_of(rows: np.ndarray) -> dict[str, np.ndarray]:
    """Columns as `kinetics.compare` takes them."""
    names = ("medium", "tracer", "time", "x", "y", "vx", "vy")
    return dict(zip(names, rows.T, strict=True))


def write_tracks(rows: np.ndarray, file: Path) -> None:
    """Keep rows of `run_program` as compressed columns."""
    columns = columns_of(rows)
    small = {name: values.astype(np.float32) for name, values in columns.items()}
    for name in ("medium", "tracer"):
        small[name] = small[name].astype(np.int16)
    np.savez_compressed(file, **small)
    print(f"wrote {file}, {file.stat().st_size} bytes")


if __name__ == "__main__":
    write_tracks(run_program(RESTITUTION, DENSITY, seed=1), FILE)
