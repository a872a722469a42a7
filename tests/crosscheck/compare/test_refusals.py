"""What cannot be used is refused in one line that names the argument, the column or the line."""

import gzip
import os
import subprocess
import sys
import zipfile
from fractions import Fraction
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pyarrow
import pytest
from made_data import TIMES, Run, columns_of, inside, text_of, write_h5md
from pyarrow import parquet

from kinetics import compare
from kinetics.errors import InputError

HEAD = "time,x,y,vx,vy,tracer\n"
ROWS = "0,0,0,1,0,1\n0,0,0,0,1,2\n2,2,0,1,0,1\n2,0,2,0,1,2\n"
DUMP = (
    "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp pp\n0 9\n0 9\n0 1\n"
    "ITEM: ATOMS id xu yu vx vy\n1 0 0 1 0\n2 0 0 0 1\n"
)
XYZ = "2\nProperties=id:I:1:pos:R:2:vel:R:2 Time=0\n1 0 0 1 0\n2 0 0 0 1\n"

TEXTS = {
    "no file": ("a.csv", None, "no such file"),
    "empty": ("a.csv", "", "empty"),
    "no header": ("a.csv", ROWS, "names them: time"),
    "no rows": ("a.csv", HEAD, "got no rows"),
    "column missing": ("a.csv", HEAD.replace("vy", "w") + ROWS, "'vy'"),
    "column twice": ("a.csv", HEAD.replace("tracer", "vy") + ROWS, "'vy' 2 times"),
    "not a number": ("a.csv", HEAD + ROWS.replace("2,2,0", "2,b,0"), "row 3: got x = 'b'"),
    "not finite": ("a.csv", HEAD + ROWS.replace("2,2,0", "2,inf,0"), "row 2: got x = inf"),
    "decimal comma": ("a.csv", (HEAD + ROWS).replace(",", ";").replace("2;2;", "2;2,5;"), "2,5"),
    "too few cells": ("a.csv", HEAD + ROWS.replace("2,2,0,1,0,1", "2,2,0"), "tracer = nan"),
    "two rows": ("a.csv", HEAD + ROWS + "2,2,0,1,0,1\n", "more than one row of tracer 1"),
    "negative time": ("a.csv", HEAD + ROWS.replace("2,2,0", "-2,2,0"), "time: got -2"),
    "one tracer": ("a.csv", HEAD + "0,0,0,1,0,1\n2,2,0,1,0,1\n", "one tracer|1 tracer"),
    "other format": ("a.doc", HEAD + ROWS, "must be a file"),
    "another label in every row": (
        "a.csv", HEAD + "0,0,0,1,0,1\n0,0,0,0,1,2\n2,2,0,1,0,3\n2,0,2,0,1,4\n", "in every row"
    ),
    "not npz": ("a.npz", HEAD, "damaged"),
    "not HDF5": ("a.h5", HEAD, "damaged"),
    "not a dump": ("a.dump", HEAD, "line 1"),
    "dump: blank line": ("a.dump", DUMP.replace("\n2 0", "\n\n2 0"), "some blank"),
    "dump: cut": ("a.dump", DUMP[:-10], "line 10"),
    "dump: no number": ("a.dump", DUMP.replace("1 0 0 1 0", "1 a 0 1 0"), "line 10 .*'a'"),
    "dump: huge": ("a.dump", DUMP.replace("ATOMS\n2", "ATOMS\n1000000000000"), "line 10"),
    "dump: periodic": (
        "a.dump",
        (DUMP + DUMP.replace("STEP\n0", "STEP\n1000")).replace("xu yu", "x y"),
        "image flags",
    ),
    "dump: no timestep": ("a.dump", DUMP, "timestep"),
    "xyz: twice": ("a.xyz", XYZ.replace("id:I:1", "pos:R:1"), "pos has 1 columns"),
    "xyz: no time": ("a.xyz", XYZ.replace(" Time=0", ""), "times"),
}  # fmt: skip


@pytest.mark.parametrize("name", list(TEXTS))
def test_a_text_that_cannot_be_used(tmp_path: Path, name: str) -> None:
    file, text, words = TEXTS[name]
    if text is not None:
        (tmp_path / file).write_text(text)
    step = None if "timestep" in name else 0.5
    with pytest.raises(InputError, match=words) as caught:
        compare(tmp_path / file, 0.7, 0.04, timestep=step)
    assert "\n" not in str(caught.value)


REFUSED: dict[str, tuple[dict[str, Any], dict[str, Any], str]] = {
    "density": ({}, {"number_density": -1.0}, "number_density: got -1"),
    "speed unit": ({}, {"speed_unit": "U"}, "speed_unit: got 'U'"),
    "field": ({}, {"field": -1.0}, "field: got -1"),
    "heating alone": ({}, {"heating": 1.0, "restitution": None}, "must be given"),
    "columns": ({}, {"columns": "x"}, "columns: got 'x'"),
    "columns, one for two": ({}, {"columns": "x=t"}, "'t' for two"),
    "type": ({}, {"type": 3}, "'type'"),
    "length": ({"x": np.ones(3)}, {}, "differ in length"),
    "shape": ({"x": np.ones((8000, 1))}, {}, "shape"),
    "texts": ({"x": np.array(["a"] * 8000)}, {}, "'x': got type"),
    "infinite": ({"vx": np.full(8000, np.inf)}, {}, "vx = inf"),
    "fast": ({"vx": np.full(8000, 1e200)}, {}, "speeds of"),
    "late": ({"t": np.repeat([0.0, 1.0, 2.0, 1e80], 2000)}, {}, "times: got 1e"),
    "at rest": ({"vx": np.zeros(8000), "vy": np.zeros(8000)}, {}, "every speed at time 0 is zero"),
    "no labels": ({"medium": None, "id": None}, {}, "a column tracer"),
    "explain as text": ({}, {"explain": "no"}, "explain: got 'no'"),
    "fitted as number": ({}, {"fitted": 1}, "fitted: got 1"),
    "start without a name": ({}, {"initial": np.ones(2)}, "initial: got array"),
    "dimension as array": ({}, {"dimension": np.array([2, 3])}, "dimension: got array"),
} | {
    f"{name} as array": ({}, {name: np.array([1.0, 2.0])}, f"^{name}: got array")
    for name in (
        "bath_speed", "capture_speed", "diameter", "drag", "field", "heating", "mass_ratio",
        "number_density", "tangential_restitution",
    )
}  # fmt: skip


@pytest.mark.parametrize("name", list(REFUSED))
def test_what_cannot_be_used(run: Run, name: str) -> None:
    change, told, words = REFUSED[name]
    data = {k: v for k, v in (columns_of(run) | change).items() if v is not None}
    with pytest.raises(InputError, match=words):
        compare(data, **{"restitution": 0.75, "number_density": 0.04} | told)


def test_a_fraction_is_a_number(run: Run) -> None:
    answers = []
    for tangential in (0.9, Fraction(9, 10)):
        answers.append(
            compare(
                columns_of(run), 0.75, 0.04, tangential_restitution=tangential, explain=False
            ).to_json()
        )
    assert answers[0] == answers[1]


def test_positions_that_look_wrapped_are_refused(run: Run) -> None:
    box = inside(run)[0]
    with pytest.raises(InputError, match="look wrapped"):
        compare(columns_of((box - box.mean(axis=(0, 1)), run[1])), 0.75, 0.04)


# an element of the group of tracers, or of the box, and what takes its place
CHANGED: dict[str, tuple[str, Any, str]] = {
    "one image": ("image/value", np.zeros((1, 2000, 2)), "image"),
    "no edges": ("box/edges", np.empty(0), "image"), "no box": ("box", None, "image"),
    "no flags": ("image", None, "periodic box"), "two groups": ("", None, "groups"),
    "other times": ("velocity/time", TIMES + 1.0, "times"),
    "few labels": ("id", np.arange(3), "label"), "text": ("velocity/value", "text", "value"),
    "link": ("velocity/value", h5py.ExternalLink("other.h5", "/velocity"), "value"),
    "huge": ("velocity/value", None, "declare"),
}  # fmt: skip


@pytest.mark.parametrize("change", list(CHANGED))
def test_h5md_that_cannot_be_used(tmp_path: Path, run: Run, change: str) -> None:
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["velocity"] = run[1]
    write_h5md(tmp_path / "a.h5md", run, image=True)
    name, value, words = CHANGED[change]
    with h5py.File(tmp_path / "a.h5md", "a") as file:
        group = file["particles/tracers"]
        if name in group:
            del group[name]
        if value is not None:
            group[name] = value
        if change == "two groups":
            group.copy(group, file["particles"], "copy")
        elif change == "huge":
            group.create_dataset(name, (4, 10**12, 2), chunks=(1, 1000, 2), dtype="f8")
    with pytest.raises(InputError, match=words):
        compare(tmp_path / "a.h5md", 0.75, 0.04)


def test_python_objects_are_never_loaded(tmp_path: Path, run: Run) -> None:
    class Evil:
        def __reduce__(self) -> Any:
            return os.mkdir, (str(tmp_path / "executed"),)

    data = columns_of(run)
    np.savez(tmp_path / "a.npz", **data | {"x": np.array([Evil()] * 8000, object)})
    with pytest.raises(InputError):
        compare(tmp_path / "a.npz", 0.75, 0.04)
    assert not (tmp_path / "executed").exists()


def bomb(path: Path, name: str, shape: tuple[int, ...], written: int) -> None:
    """An .npz whose array `name` declares this shape, and holds so many bytes of zeros."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for one in ("times", "positions", "velocities"):
            with archive.open(f"{one}.npy", "w", force_zip64=True) as file:
                header = {"descr": "<f8", "fortran_order": False, "shape": shape}
                if one != name:
                    header["shape"] = (2,) if one == "times" else (2, 3, 2)
                np.lib.format.write_array_header_1_0(file, header)
                size = written if one == name else 8 * int(np.prod(header["shape"]))
                for _ in range(size // 2**20 + 1):
                    file.write(b"\0" * min(size, 2**20))


def small_files(folder: Path) -> None:
    """Small files that would take much memory or time, were they believed."""
    bomb(folder / "times.npz", "times", (2**27,), 2**28)
    bomb(folder / "declared.npz", "positions", (2, 10**12, 2), 100)
    with h5py.File(folder / "declared.h5", "w") as file:
        for name in ("time", "x", "y", "vx", "vy"):
            file.create_dataset(name, (10**12,), "f8", chunks=(1000,), compression="gzip")
    os.symlink("/dev/zero", folder / "zero.csv")
    os.mkfifo(folder / "pipe.csv")
    (folder / "line.csv").write_bytes(b"time,x,y,vx,vy\n" + b"1" * (3 << 20))
    (folder / "bomb.csv.gz").write_bytes(gzip.compress(HEAD.encode() + b"0" * (1 << 28), 1))


def test_small_files_cost_little(tmp_path: Path) -> None:
    """A line within a second of the processor and 200 MB beside what the imports take."""
    small_files(tmp_path)
    code = (
        "import sys, time, resource, h5py, scipy.optimize, pyarrow.csv\n"
        "from kinetics.crosscheck import compare_data\n"
        "for path in sys.argv[1:]:\n"
        "    start, before = time.process_time(), resource.getrusage(0).ru_maxrss\n"
        "    try: compare_data(path, 0.7, 0.04)\n"
        "    except ValueError: more = resource.getrusage(0).ru_maxrss - before\n"
        "    print(path, time.process_time() - start, more)"
    )
    paths = [str(path) for path in sorted(tmp_path.iterdir())]
    done = subprocess.run(
        [sys.executable, "-c", code, *paths], capture_output=True, text=True, check=True
    )
    for name, seconds, kilobytes in map(str.split, done.stdout.splitlines()):
        assert float(seconds) < 1.0, name
        assert int(kilobytes) < 200_000, name


#: Memory in bytes that a machine has in the next test: a sixth of it may be read.
MEMORY = 1.2e9


def large_files(folder: Path) -> None:
    """Files that are small and take more than a quarter of this memory, were they read whole."""
    numbers = np.zeros(10_000_000, np.int8)
    columns = {"time": numbers, "x": numbers, "y": numbers, "vx": numbers, "vy": numbers}
    np.savez_compressed(folder / "narrow.npz", **columns)
    with h5py.File(folder / "narrow.h5", "w") as file:
        for name in columns:
            file.create_dataset(name, data=numbers, compression="gzip")
    rows = pyarrow.array(np.zeros(6_000_000))
    table = pyarrow.table({"t": rows, "x": rows, "y": rows, "vx": rows, "vy": rows, "id": rows})
    parquet.write_table(table, folder / "numbers.parquet")
    texts = pyarrow.array([str(k) + "a" * 4000 for k in range(80_000)])
    columns_of_texts = {name: rows[: len(texts)] for name in ("t", "x", "y", "vx", "vy")}
    text_table = pyarrow.table({**columns_of_texts, "id": texts})
    parquet.write_table(text_table, folder / "texts.parquet", compression="zstd")
    short_rows = b"0,0,0,1,0,1\n" * 1_000_000
    long_rows = b"0,0,0,1,0," + b"a" * 9000 + b"\n"
    with gzip.open(folder / "rows.csv.gz", "wb", 1) as packed:
        packed.write(HEAD.encode())
        for _ in range(9):
            packed.write(short_rows)
    with gzip.open(folder / "texts.csv.gz", "wb", 1) as packed:
        packed.write(HEAD.encode() + short_rows[: 12 * 6000])
        for _ in range(35):
            packed.write(long_rows * 1000)


@pytest.mark.slow
def test_what_does_not_fit_is_refused_while_it_is_read(tmp_path: Path) -> None:
    """A quarter of the memory is never taken, beside what the imports and the libraries take."""
    large_files(tmp_path)
    code = (
        "import sys, resource, h5py, scipy.optimize, pyarrow.parquet\n"
        "from kinetics.crosscheck import compare_data\n"
        "from kinetics.crosscheck.data import memory\n"
        f"memory.available_memory = lambda: {MEMORY}\n"
        "before = resource.getrusage(0).ru_maxrss\n"
        "try: compare_data(sys.argv[1], 0.7, 0.04); said = 'nothing'\n"
        "except ValueError as error: said = str(error)\n"
        "print(resource.getrusage(0).ru_maxrss - before, said)"
    )
    for path in sorted(tmp_path.iterdir()):
        done = subprocess.run(
            [sys.executable, "-c", code, str(path)], capture_output=True, text=True, check=True
        )
        kilobytes, said = done.stdout.split(" ", 1)
        assert "sixth of the memory" in said, path.name
        assert 1024 * int(kilobytes) < MEMORY / 4, path.name


def test_what_is_given_twice_or_mixed_is_refused(tmp_path: Path, csv: Path, run: Run) -> None:
    unlabelled = tmp_path / "u.csv"
    unlabelled.write_text(text_of(columns_of(run, tracers=False)))
    for data, words in (
        ([csv, csv], "twice"), ([], "no file"), ([csv, unlabelled], "all files or in none"),
        (3, "data: got 3"), ([csv, 3], "data: got"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=words):
            compare(data, 0.75, 0.04)
