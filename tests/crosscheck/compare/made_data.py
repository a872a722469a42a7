"""One small run whose truth is known, and the files that hold it."""

import gzip
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from particles import BoltzmannGrad, simulate

TIMES = np.array([0.0, 2.0, 20.0, 200.0])
TRACERS, SIDE, STEP = 2000, 25.0, 0.25
"""Tracers, 50 to a configuration; the side of the box that they start in; the time of a step."""

Run = tuple[np.ndarray, np.ndarray]
"""Absolute positions and velocities, (n_times, n, d) each."""


def simulated(**changed: Any) -> Any:
    """A run of the equation itself, e = .75 and l = 12.5."""
    told: dict[str, Any] = {"restitution": 0.75, "times": TIMES, "media": 40, "tracers": 50}
    told |= {"seed": 4, "workers": 1, "observables": ("positions", "velocities")}
    medium = changed.pop("medium", BoltzmannGrad(0.04))
    return simulate(medium, **told | changed)


def columns_of(run: Run, tracers: bool = True, times: Any = TIMES) -> dict[str, np.ndarray]:
    """One row for each tracer at each time."""
    n = run[0].shape[1]
    data = {"t": np.repeat(times, n)}
    for names, part in (("xyz", run[0]), (("vx", "vy", "vz"), run[1])):
        data |= dict(zip(names, part.reshape(-1, part.shape[2]).T, strict=False))
    if tracers:
        data |= {"id": np.tile(np.arange(n), len(times))}
        data |= {"medium": data["id"] // 50}
    return data


def text_of(data: dict[str, Any], separator: str = ",") -> str:
    rows = zip(*(np.asarray(values).tolist() for values in data.values()), strict=True)
    lines = [separator.join(data), *(separator.join(map(str, row)) for row in rows)]
    return "\n".join(lines) + "\n"


def inside(run: Run) -> tuple[np.ndarray, np.ndarray]:
    """Positions in the box, and image flags."""
    image = np.floor(run[0] / SIDE).astype(int)
    return run[0] - image * SIDE, image


def write_csv(path: Path, run: Run) -> None:
    path.write_text(text_of(columns_of(run)))


def write_gz(path: Path, run: Run) -> None:
    path.write_bytes(gzip.compress(text_of(columns_of(run)).encode()))


def write_labels(path: Path, run: Run) -> None:
    """Semicolons, remarks, labels that are texts, and other names of columns."""
    data = columns_of(run)
    data["id"] = np.array([f"p{k}" for k in data["id"]])
    path.write_text("# a remark\n" + text_of(data, ";").replace("\n", "\n# another\n\n", 3))


def write_parquet(path: Path, run: Run) -> None:
    import pyarrow as pa
    from pyarrow import parquet

    parquet.write_table(pa.table(columns_of(run)), path)


def write_hdf5(path: Path, run: Run) -> None:
    with h5py.File(path, "w") as file:
        for name, values in columns_of(run).items():
            file[name] = values


def write_h5md(path: Path, run: Run, image: bool = False) -> None:
    place, flags = inside(run) if image else (run[0], run[0])
    with h5py.File(path, "w") as file:
        file.create_group("h5md").attrs["version"] = [1, 1]
        group = file.create_group("particles/tracers")
        elements = {"position": place, "velocity": run[1]} | ({"image": flags} if image else {})
        group["box/edges"] = [SIDE] * run[0].shape[2]
        if image:
            group["box"].attrs["boundary"] = [b"periodic"] * run[0].shape[2]
        group["medium"] = np.arange(run[0].shape[1]) // 50
        for name, values in elements.items():
            group[f"{name}/value"] = values
            group[f"{name}/step"] = np.round(TIMES / STEP).astype(int)
            if image:
                group[f"{name}/time"] = TIMES


def write_dump(path: Path, run: Run, place: str = "{}u", kind: Any = None) -> None:
    """As LAMMPS; place: the columns of a coordinate."""
    box, image = inside(run)
    axes = "xyz"[: run[0].shape[2]]
    columns = " ".join([place.format(axis) for axis in axes] + ["vx vy vz"])
    data = {"vz": np.zeros(run[0].shape[:2])}
    for k, axis in enumerate(axes):
        data |= {f"{axis}u": run[0][..., k], f"v{axis}": run[1][..., k], axis: box[..., k]}
        data |= {f"i{axis}": image[..., k]}
    bounds = [f"0.0 {SIDE}"] * len(axes) + ["-0.5 0.5"] * (3 - len(axes))
    lines, n = [], run[0].shape[1]
    for k, time in enumerate(TIMES):
        lines += ["ITEM: TIMESTEP", str(round(time / STEP)), "ITEM: NUMBER OF ATOMS", str(n)]
        lines += ["ITEM: BOX BOUNDS pp pp pp", *bounds, f"ITEM: ATOMS id type {columns} "]
        for i in range(n):
            row = [repr(data[name][k, i].item()) for name in columns.split()]
            lines.append(" ".join([str(i), "1" if kind is None else str(kind[i]), *row]) + " ")
    path.write_text("\n".join(lines) + "\n")


def write_xyz(path: Path, run: Run, kind: Any = None) -> None:
    lines, flat = [], [0.0] * (3 - run[0].shape[2])
    for time, r, v in zip(TIMES.tolist(), *run, strict=True):
        named = "Properties=species:S:1:pos:R:3:id:I:1:vel:R:3"
        lines += [str(len(r)), f'Lattice="25 0 0 0 25 0 0 0 1" {named} Time={time!r} pbc="T T F"']
        for k, (a, b) in enumerate(zip(r.tolist(), v.tolist(), strict=True)):
            what = "X" if kind is None else str(kind[k])
            lines.append(" ".join([what, *map(repr, a + flat), str(k), *map(repr, b + flat)]))
    path.write_text("\n".join(lines) + "\n")


def write_gsd(path: Path, run: Run) -> None:
    """As HOOMD-blue: single precision, the box about the origin."""
    hoomd = pytest.importorskip("gsd.hoomd")
    n, d = run[0].shape[1:]
    with hoomd.open(str(path), "w") as file:
        for k, time in enumerate(TIMES):
            frame = hoomd.Frame()
            frame.configuration.step, frame.configuration.dimensions = round(time / STEP), d
            frame.configuration.box = [SIDE, SIDE, SIDE if d == 3 else 0, 0, 0, 0]
            place, speed, image = np.zeros((3, n, 3))
            image[:, :d] = np.floor(run[0][k] / SIDE + 0.5)
            place[:, :d], speed[:, :d] = run[0][k], run[1][k]
            frame.particles.N = n
            frame.particles.position, frame.particles.velocity = place - image * SIDE, speed
            frame.particles.image = image.astype(int)
            file.append(frame)


FORMATS: dict[str, Callable[[Path, Run], None]] = {
    "run.csv": write_csv,
    "run.csv.gz": write_gz,
    "labels.tsv": write_labels,
    "run.parquet": write_parquet,
    "columns.npz": lambda path, run: np.savez_compressed(path, **columns_of(run)),
    "frames.npz": lambda path, run: np.savez(
        path, times=TIMES, positions=run[0], velocities=run[1]
    ),
    "run.h5": write_hdf5,
    "run.h5md": write_h5md,
    "image.h5": lambda path, run: write_h5md(path, run, image=True),
    "run.dump": write_dump,
    "image.dump": lambda path, run: write_dump(path, run, "{0} i{0}"),
    "run.xyz": write_xyz,
    "run.gsd": write_gsd,
}
NO_MEDIUM = ("frames.npz", "run.dump", "image.dump", "run.xyz", "run.gsd")
"""Formats that do not say the configuration."""


def place_in(dimension: int) -> Run:
    found = simulated(medium=BoltzmannGrad(0.04, dimension=dimension))
    start = np.random.default_rng(1).uniform(0, SIDE, (TRACERS, dimension))
    return found.positions + start, found.velocities
