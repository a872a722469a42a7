"""Files as simulators write them: the same trajectories give the same answer in every format."""

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet

from kinetics import compare
from kinetics.cli import main
from kinetics.crosscheck.comparison.data import frames
from kinetics.crosscheck.comparison.data.read import read_sample
from kinetics.errors import InputError
from particles import BoltzmannGrad, simulate

TIMES = np.array([0.0, 2.0, 20.0, 60.0])
TRACERS, SIDE = 300, 25.0
STEP = 0.25
"""Time of a step."""

Run = tuple[np.ndarray, np.ndarray]
"""Positions and velocities, (n_times, n, 2) each."""


@pytest.fixture(scope="module")
def run() -> Run:
    """Absolute positions in a box of side SIDE at time 0, which the tracers leave."""
    return run_in(2)


@cache
def run_in(dimension: int) -> Run:
    found = simulate(
        BoltzmannGrad(0.04, dimension=dimension), restitution=0.7, times=TIMES, media=3,
        tracers=TRACERS // 3, seed=4, workers=1, observables=("positions", "velocities"),
    )  # fmt: skip
    start = np.random.default_rng(1).uniform(0, SIDE, (TRACERS, dimension))
    return found.positions + start, found.velocities


def wrapped(run: Run) -> tuple[np.ndarray, np.ndarray]:
    """Positions in the box and image flags."""
    image = np.floor(run[0] / SIDE).astype(int)
    return run[0] - image * SIDE, image


def columns_of(run: Run) -> dict[str, np.ndarray]:
    """One row for each tracer at each time."""
    data = {"t": np.repeat(TIMES, TRACERS), "id": np.tile(np.arange(TRACERS), TIMES.size)}
    for names, part in (("xyz", run[0]), (("vx", "vy", "vz"), run[1])):
        data |= dict(zip(names, part.reshape(-1, part.shape[2]).T, strict=False))
    return data


def write_csv(path: Path, run: Run) -> None:
    data = columns_of(run)
    rows = zip(*(values.tolist() for values in data.values()), strict=True)
    path.write_text("\n".join([",".join(data), *(",".join(map(repr, row)) for row in rows)]))


def write_parquet(path: Path, run: Run) -> None:
    parquet.write_table(pa.table(columns_of(run)), path)


def write_dump(path: Path, run: Run, columns: str = "", units: str = "") -> None:
    box, image = wrapped(run)
    axes = "xyz"[: run[0].shape[2]]
    columns = columns or " ".join([f"{axis}u" for axis in axes] + ["vx", "vy", "vz"])
    data = {"vz": np.zeros(run[0].shape[:2])}
    for k, axis in enumerate(axes):
        data |= {f"{axis}u": run[0][..., k], f"v{axis}": run[1][..., k], axis: box[..., k]}
        data |= {f"i{axis}": image[..., k], f"{axis}s": box[..., k] / SIDE}
    bounds = [f"0.0 {SIDE}"] * len(axes) + ["-0.5 0.5"] * (3 - len(axes))
    lines = ["ITEM: UNITS", units] if units else []
    for k, time in enumerate(TIMES):
        lines += ["ITEM: TIMESTEP", str(round(time / STEP)), "ITEM: NUMBER OF ATOMS"]
        lines += [str(TRACERS), "ITEM: BOX BOUNDS pp pp pp", *bounds]
        lines += [f"ITEM: ATOMS id type element {columns} "]
        for n in range(TRACERS):
            row = [repr(data[name][k, n].item()) for name in columns.split()]
            lines.append(" ".join([str(n), "1", "Ar", *row]) + " ")
    path.write_text("\n".join(lines) + "\n")


def write_xyz(path: Path, run: Run) -> None:
    lines, flat = [], [0.0] * (3 - run[0].shape[2])
    for time, r, v in zip(TIMES.tolist(), *run, strict=True):
        named = "Properties=species:S:1:pos:R:3:id:I:1:vel:R:3"
        lines += [str(TRACERS), f'Lattice="25 0 0 0 25 0 0 0 1" {named} Time={time!r} pbc="T T F"']
        for k, (a, b) in enumerate(zip(r.tolist(), v.tolist(), strict=True)):
            lines.append(" ".join(["X", *map(repr, a + flat), str(k), *map(repr, b + flat)]))
    path.write_text("\n".join(lines) + "\n")


def write_h5md(
    path: Path, run: Run, image: bool = False, fixed: bool = False, box: bool = False
) -> None:
    """image: wrapped, with image flags; box: wrapped, without them."""
    with h5py.File(path, "w") as file:
        file.create_group("h5md").attrs["version"] = [1, 1]
        group = file.create_group("particles/tracers")
        inside, images = wrapped(run)
        elements = {"position": inside if image or box else run[0], "velocity": run[1]}
        if image:
            elements["image"] = images
        if image or box:
            group["box/edges"] = [SIDE] * run[0].shape[2]
            group["box"].attrs["boundary"] = [b"periodic"] * run[0].shape[2]
        for name, values in elements.items():
            element = group.create_group(name)
            element["value"] = values
            element["step"] = np.round(TIMES / STEP).astype(int)
            if not fixed:
                element["time"] = TIMES
            element["value"].attrs["unit"] = "d"


def write_gsd(path: Path, run: Run, image: bool = True) -> None:
    """As HOOMD-blue: single precision, the box about the origin."""
    hoomd = pytest.importorskip("gsd.hoomd")
    dimension = run[0].shape[2]
    images = np.zeros((TIMES.size, TRACERS, 3), int)
    images[..., :dimension] = np.floor(run[0] / SIDE + 0.5)
    with hoomd.open(str(path), "w") as file:
        for k, time in enumerate(TIMES):
            frame = hoomd.Frame()
            frame.configuration.step, frame.configuration.dimensions = round(time / STEP), dimension
            frame.configuration.box = [SIDE, SIDE, SIDE if dimension == 3 else 0, 0, 0, 0]
            place, speed = np.zeros((2, TRACERS, 3))
            place[:, :dimension], speed[:, :dimension] = run[0][k], run[1][k]
            frame.particles.N = TRACERS
            frame.particles.position, frame.particles.velocity = place - images[k] * SIDE, speed
            if image:
                frame.particles.image = images[k]
            file.append(frame)


def write_arrays(path: Path, run: Run) -> None:
    np.savez(path, times=TIMES, positions=run[0], velocities=run[1])


def write_columns(path: Path, run: Run) -> None:
    np.savez(path, **columns_of(run))


WRITERS: dict[str, Callable[[Path, Run], None]] = {
    "run.h5md": write_h5md,
    "run.h5": lambda path, run: write_h5md(path, run, image=True),
    "run.dump": write_dump,
    "run.lammpstrj": lambda path, run: write_dump(path, run, "x y ix iy vx vy"),
    "run.xyz": write_xyz,
    "run.npz": write_arrays,
}
IN_SPACE = WRITERS | {
    "run.lammpstrj": lambda path, run: write_dump(path, run, "xs ys zs ix iy iz vx vy vz"),
    "run.parquet": write_parquet,
    "columns.npz": write_columns,
    "run.gsd": write_gsd,
}


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("name", list(IN_SPACE))
def test_the_same_trajectories_give_the_same_sums(
    tmp_path: Path, name: str, dimension: int, moments: Any
) -> None:
    """In every format; what is in space is refused in the plane."""
    run, path = run_in(dimension), tmp_path / name
    write_csv(tmp_path / "run.csv", run)
    (IN_SPACE if dimension == 3 else IN_SPACE | WRITERS)[name](path, run)
    plain = read_sample([tmp_path / "run.csv"], dimension=dimension)
    found = read_sample([path], dimension=dimension, timestep=STEP)
    exact = 1e-5 if name == "run.gsd" else 1e-9
    np.testing.assert_allclose(moments(found), moments(plain), rtol=exact, atol=1e-12)
    r = np.linalg.norm(run[0] - run[0][0], axis=2)
    np.testing.assert_allclose(moments(plain)[..., 2].sum(axis=0), (r**2).sum(axis=1))
    assert found.law.dimension == dimension
    assert found.grouping == plain.grouping == "tracer"
    if dimension == 3:
        with pytest.raises(InputError, match="velocities have a z component; say dimension 3"):
            read_sample([path], timestep=STEP)


def test_the_command_compares_spheres(tmp_path: Path, capsys: Any) -> None:
    path = tmp_path / "run.csv"
    write_csv(path, run_in(3))
    told = ["compare", str(path), "-e", "0.7", "--number-density", "0.04"]
    assert main([*told, "--dimension", "3", "--fail-on", "differs"]) == 0
    assert "ρ₀ = 0.04 d⁻³" in capsys.readouterr().out
    law: dict[str, Any] = {"dimension": 3, "tangential_restitution": 0.3, "explain": False}
    assert compare(path, 0.7, 0.04, **law).verdict == "differs"
    assert main(told) == 2
    assert "say dimension 3" in capsys.readouterr().err
    with pytest.raises(InputError, match="has no z components; dimension 3 needs them"):
        read_sample([_plane(tmp_path)], dimension=3)


def _plane(folder: Path) -> Path:
    write_arrays(folder / "plane.npz", run_in(2))
    return folder / "plane.npz"


@pytest.mark.parametrize(
    "name", ["run.csv", "run.dump", "run.xyz", "run.h5md", "box.h5md", "run.gsd", "run.npz"]
)
def test_wrapped_positions_are_refused(tmp_path: Path, name: str, run: Run) -> None:
    inside = (wrapped(run)[0], run[1])
    writers = WRITERS | {
        "run.csv": write_csv,
        "box.h5md": lambda path, run: write_h5md(path, run, box=True),
        "run.gsd": lambda path, run: write_gsd(path, run, image=False),
    }
    writers[name](tmp_path / name, inside)
    with pytest.raises(InputError, match="positions look wrapped at the edges of a box") as caught:
        read_sample([tmp_path / name], timestep=STEP)
    assert "\n" not in str(caught.value)


def test_tracers_that_are_missing_late_are_warned_of(tmp_path: Path, run: Run) -> None:
    some = tuple(part.copy() for part in run)
    some[0][3, 50:80] = some[1][3, 50:80] = np.nan
    write_arrays(tmp_path / "run.npz", some)  # type: ignore[arg-type]
    sample = read_sample([tmp_path / "run.npz"])
    np.testing.assert_array_equal(sample.samples, [300, 300, 300, 270])
    assert any("30 of 300 tracers are missing" in warning for warning in sample.warnings)


def test_frames_are_read_in_pieces(
    tmp_path: Path, run: Run, monkeypatch: pytest.MonkeyPatch, moments: Any
) -> None:
    """Pieces of any size give the same sums."""
    from kinetics.crosscheck.comparison.data import arrays, hdf5_files
    from kinetics.crosscheck.comparison.data.columns import Asked, read_rows

    for name in WRITERS:
        WRITERS[name](tmp_path / name, run)
    whole = {name: read_sample([tmp_path / name], timestep=STEP) for name in WRITERS}
    for module in (frames, arrays, hdf5_files):
        monkeypatch.setattr(module, "PIECE", 70)
    for name in WRITERS:
        pieces = list(read_rows(tmp_path / name, Asked(timestep=STEP)))
        assert max(rows.time.size for rows in pieces) <= 70
        assert sum(rows.time.size for rows in pieces) == TRACERS * TIMES.size
        again = read_sample([tmp_path / name], timestep=STEP)
        np.testing.assert_array_equal(again.samples, whole[name].samples)
        np.testing.assert_allclose(moments(again), moments(whole[name]), rtol=1e-9, atol=1e-12)


def edited(kind: str, old: str, new: str) -> tuple[str, Callable[[Path], None]]:
    def change(path: Path) -> None:
        text = path.read_text()
        assert old in text
        path.write_text(text.replace(old, new, 1))

    return kind, change


def cut(kind: str, share: float) -> tuple[str, Callable[[Path], None]]:
    return kind, lambda path: path.write_bytes(path.read_bytes()[: int(share * 1e-2 * _size(path))])


def _size(path: Path) -> int:
    return path.stat().st_size


def h5(change: Callable[[Any], Any]) -> tuple[str, Callable[[Path], None]]:
    def edit(path: Path) -> None:
        with h5py.File(path, "r+") as file:
            change(file["particles/tracers"])

    return "run.h5md", edit


def replaced(name: str, values: Any) -> tuple[str, Callable[[Path], None]]:
    def change(group: Any) -> None:
        del group[name]
        if values is not None:
            group[name] = values

    return h5(change)


BROKEN = {
    "the atoms have no id": (edited("run.dump", "ATOMS id", "ATOMS di"), "column 'id' is missing"),
    "no positions": (edited("run.dump", "xu yu", "qx qy"), "column 'xu' is missing"),
    "no velocities": (edited("run.dump", "vx vy", "wx wy"), "column 'vx' is missing"),
    "a name too many": (edited("run.dump", "yu vx", "yu q vx"), "are named"),
    "motion along z": (edited("run.dump", " 0.0 \n", " 1.0 \n"), "have a z component"),
    "text for a number": (edited("run.dump", " Ar ", " Ar x"), "not 8 columns of numbers"),
    "a step that is no number": (edited("run.dump", "TIMESTEP\n0", "TIMESTEP\n-1"), "a step is"),
    "a count that is no number": (
        edited("run.dump", "ATOMS\n300", "ATOMS\n3e2"), "the number of atoms is not"
    ),
    "more atoms than lines": (edited("run.dump", "ATOMS\n300", "ATOMS\n301"), "not 8 columns"),
    "fewer atoms than lines": (edited("run.dump", "ATOMS\n300", "ATOMS\n299"), "is not a LAMMPS"),
    "a triclinic box": (edited("run.dump", "0.0 25.0", "0.0 25.0 1.0"), "must be rectangular"),
    "a box of words": (edited("run.dump", "0.0 25.0", "0.0 wide"), "a bound of the box"),
    "a dump cut off": (cut("run.dump", 60), "data|cut off|columns"),
    "a dump cut in its head": (cut("run.dump", 0.1), "column|cut off"),
    "no dump": (edited("run.dump", "ITEM: TIMESTEP", "hello"), "is not a LAMMPS text dump"),
    "an xyz with no time": (edited("run.xyz", "Time=", "Tide="), "has no Time="),
    "an xyz time of words": (edited("run.xyz", "Time=0.0", "Time=now"), "a time is not a finite"),
    "an xyz with no pos": (edited("run.xyz", "pos:R", "sop:R"), "has no pos:R:3"),
    "an xyz with no vel": (edited("run.xyz", "vel:R", "lev:R"), "has no vel:R:3"),
    "an xyz with odd Properties": (edited("run.xyz", "vel:R:3", "vel:R"), "must be name:type"),
    "an xyz with one coordinate": (edited("run.xyz", "pos:R:3", "pos:R:1"), "must be 2 or 3"),
    "an xyz with a count of words": (edited("run.xyz", "300", "many"), "the number of atoms is"),
    "an xyz that is cut off": (cut("run.xyz", 60), "cut off|columns"),
    "an xyz with NaN": (edited("run.xyz", "X ", "X nan "), "columns; 8 are named"),
    "h5md with no velocity": (replaced("velocity", None), "needs one group of particles"),
    "h5md of another shape": (
        replaced("position/value", np.zeros((4, 300))), "must be \\(T, n, 2\\)"
    ),
    "h5md shapes that differ": (
        replaced("position/value", np.zeros((4, 299, 2))), "position and velocity differ in shape"
    ),
    "h5md of texts": (
        replaced("position/value", np.array([b"x"])), "must be numbers in this file"
    ),
    "h5md times that differ": (replaced("velocity/time", TIMES + 1), "at different times"),
    "h5md too few times": (replaced("position/time", TIMES[:2]), "must be 4 finite numbers"),
    "h5md with infinity": (
        replaced("velocity/value", np.full((4, 300, 2), np.inf)), "must be a finite number"
    ),
    "h5md with a link": (
        h5(lambda g: (g.pop("position"), g.__setitem__("position", h5py.ExternalLink("a", "/b")))),
        "needs one group of particles",
    ),
    "h5md with few labels": (
        h5(lambda g: g.__setitem__("id", np.arange(5))), "one label tracer for each of 300"
    ),
    "h5md cut off": (cut("run.h5md", 50), "is damaged, or not"),
    "arrays of another shape": (
        ("run.npz", lambda p: np.savez(p, times=TIMES, positions=np.zeros((4, 5)),
                                       velocities=np.zeros((4, 5, 2)))),
        "twice \\(n_times, n_tracers, 2\\)",
    ),
    "arrays with too few times": (
        ("run.npz", lambda p: np.savez(p, times=TIMES[:3], positions=np.zeros((4, 5, 2)),
                                       velocities=np.zeros((4, 5, 2)))),
        "twice \\(n_times, n_tracers, 2\\)",
    ),
}  # fmt: skip


@pytest.mark.parametrize("what", list(BROKEN))
def test_a_broken_file_is_one_line(tmp_path: Path, what: str, run: Run) -> None:
    (name, change), message = BROKEN[what]
    path = tmp_path / name
    WRITERS[name](path, run)
    change(path)
    with pytest.raises(InputError, match=message) as caught:
        read_sample([path], timestep=STEP)
    assert "\n" not in str(caught.value)
    assert name in str(caught.value)


@pytest.mark.parametrize("name", ["run.dump", "fixed.h5md"])
def test_steps_need_their_time(tmp_path: Path, name: str, run: Run) -> None:
    path = tmp_path / name
    if name == "run.dump":
        write_dump(path, run)
    else:
        write_h5md(path, run, fixed=True)
    with pytest.raises(InputError, match="say --timestep"):
        read_sample([path])
    np.testing.assert_allclose(read_sample([path], timestep=STEP).times, TIMES)
    np.testing.assert_allclose(read_sample([path], timestep=1.0).times, TIMES / STEP)
    asked = ["compare", str(path), "-e", "0.7", "--number-density", "0.04", "--timestep", str(STEP)]
    assert main(asked) == 0
    assert main([*asked[:-1], "-1"]) == 2
