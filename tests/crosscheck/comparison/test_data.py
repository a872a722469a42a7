"""Particle data in files: what is read, what is refused, and that it is read in pieces."""

import os
import pickle
import zipfile
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from kinetics.crosscheck.comparison import reduction
from kinetics.crosscheck.comparison.data import arrays, csv_files, labels
from kinetics.crosscheck.comparison.data.columns import Rows, read_rows
from kinetics.crosscheck.comparison.data.read import read_sample
from kinetics.crosscheck.comparison.reduction import MOST_GROUPS, Reduction
from kinetics.crosscheck.comparison.sample import R2, R4, V2, V4, N, Sample
from kinetics.errors import InputError

NAMES = ("time", "x", "y", "vx", "vy", "tracer", "medium")


def made_up(tracers: int = 40, times: Any = (0.0, 1.0, 10.0)) -> dict[str, Any]:
    """Columns of `tracers` tracers, four to a configuration; at time 0 at the origin."""
    rng = np.random.default_rng(8)
    time = np.repeat(np.asarray(times, float), tracers)
    x, y = rng.normal(size=(2, time.size)) * time
    vx, vy = rng.normal(size=(2, time.size)) / (1 + time)
    tracer = np.tile(np.arange(tracers), len(times))
    return dict(zip(NAMES, (time, x, y, vx, vy, tracer, tracer // 4), strict=True))


def text_of(data: dict[str, Any], separator: str = ",") -> str:
    lines = [separator.join(data)]
    lines += [separator.join(repr(v.item()) for v in row) for row in zip(*data.values())]  # noqa: B905
    return "\n".join(lines) + "\n"


def moments(sample: Sample) -> Any:
    """Sums of v^2, v^4, r^2, r^4 in the sample's units: (n_groups, n_times, 4)."""
    v, r = sample.speed_scale**2, sample.length_scale**2
    return sample.sums[:, :, [V2, V4, R2, R4]] * np.stack([v, v**2, r, r**2], axis=-1)


def write(folder: Path, kind: str, data: dict[str, Any]) -> Path:
    path = folder / f"data.{kind}"
    if kind == "csv":
        path.write_text(text_of(data))
    elif kind == "npz":
        np.savez(path, **data)
    elif kind == "zip.npz":
        np.savez_compressed(path, **data)
    else:
        with h5py.File(path, "w") as file:
            for name, values in data.items():
                file[name] = values
    return path


@pytest.mark.parametrize("kind", ["csv", "npz", "zip.npz", "h5"])
def test_sums_are_those_of_the_rows(tmp_path: Path, kind: str) -> None:
    data = made_up()
    path = write(tmp_path, kind, data)
    before = path.read_bytes()
    sample = read_sample([path])
    assert path.read_bytes() == before
    assert sample.grouping == "medium"
    assert sample.groups == 10
    np.testing.assert_array_equal(sample.times, [0.0, 1.0, 10.0])
    np.testing.assert_array_equal(sample.samples, [40, 40, 40])
    speed2 = data["vx"] ** 2 + data["vy"] ** 2
    r2 = data["x"] ** 2 + data["y"] ** 2
    for k, time in enumerate(sample.times):
        for g in range(10):
            mine = (data["time"] == time) & (data["medium"] == g)
            v, r = sample.speed_scale[k] ** 2, sample.length_scale[k] ** 2
            sums = sample.sums[g, k]
            assert sums[N] == 4
            expected = {V2: speed2[mine], V4: speed2[mine] ** 2, R2: r2[mine], R4: r2[mine] ** 2}
            unit = {V2: v, V4: v**2, R2: r, R4: r**2}
            for column, values in expected.items():
                np.testing.assert_allclose(sums[column] * unit[column], values.sum(), rtol=1e-12)
    assert sample.speeds is not None
    assert sample.displacements is not None
    for binned, values in ((sample.speeds, np.sqrt(speed2)), (sample.displacements, np.sqrt(r2))):
        counts, _ = np.histogram(values[80:], binned.edges[2])
        np.testing.assert_array_equal(binned.totals[2, 1:-1], counts)
        assert binned.totals[2].sum() == 40
        assert binned.by_group is not None
        third, _ = np.histogram(values[80:][data["medium"][80:] == 2], binned.edges[2])
        np.testing.assert_array_equal(binned.by_group[2, 2, 1:-1], third)
    start = sample.start
    assert start is not None
    np.testing.assert_allclose(start.squares @ start.counts, speed2[:40].sum())
    np.testing.assert_allclose(
        start.flatness * start.squares**2 @ start.counts, (speed2[:40] ** 2).sum()
    )


def test_the_order_of_rows_and_columns_does_not_matter(tmp_path: Path) -> None:
    data = made_up()
    order = np.random.default_rng(1).permutation(data["time"].size)
    mixed = {name: data[name][order] for name in reversed(NAMES)} | {"note": order}
    a, b = (read_sample([write(tmp_path, "npz", d)]) for d in (data, mixed))
    np.testing.assert_array_equal(a.times, b.times)
    np.testing.assert_allclose(moments(a), moments(b), rtol=1e-12)


@pytest.mark.parametrize("separator", [",", ";", "\t", " , "])
def test_dialects_of_csv(tmp_path: Path, separator: str) -> None:
    data = made_up()
    plain = read_sample([write(tmp_path, "csv", data)])
    lines = text_of(data, separator).splitlines()
    lines[0] = '# "' + lines[0].replace(separator, f'"{separator}"').upper() + '"'
    lines.insert(3, "# a remark, with a comma")
    lines.insert(5, "   ")
    path = tmp_path / "other.csv"
    path.write_bytes("\ufeff".encode() + "\r\n".join(lines).encode())  # no newline at the end
    np.testing.assert_allclose(moments(read_sample([path])), moments(plain), rtol=1e-12)


def test_labels_and_other_columns_may_be_text(tmp_path: Path) -> None:
    path = tmp_path / "data.csv"
    lines = ["who,tracer,time,x,y,vx,vy,medium"]
    for medium in ("left", "right"):
        for tracer in ("a", '"b, c"', "é"):
            lines += [f'"someone, else",{tracer},{t},1,2,3,4,{medium}' for t in (1, 2)]
    path.write_text("\n".join(lines), encoding="utf-8")
    sample = read_sample([path])
    np.testing.assert_array_equal(sample.samples, [6, 6])
    assert (sample.groups, sample.grouping) == (2, "medium")


@pytest.mark.parametrize(
    "text",
    [
        "0", "-0", "1", "-1.5", "+2.25", "1e3", "1E-3", ".5", "5.", "3.141592653589793", "1e22",
        "123456789012345678901234567890", "0.000000000000000000000012345678901234567",
        "2.2250738585072014e-308", "5e-324", "1e-400", "0e999",
        "9007199254740993", "1.00000000000000011102230246251565", "0.1", "0.30000000000000004",
    ],
)  # fmt: skip
def test_numbers_are_those_of_python(tmp_path: Path, text: str) -> None:
    path = tmp_path / "data.csv"
    path.write_text(f"time,x,y,vx,vy\n1,{text}, {text} ,1,1\n")
    (rows,) = read_rows(path)
    assert rows.x[0] == rows.y[0] == float(text)


def test_every_double_comes_back_to_its_last_bit(tmp_path: Path) -> None:
    """Of numbers written with 17 digits a parser of one's own gets some 15 % wrong by a bit."""
    rng = np.random.default_rng(6)
    bits = np.frombuffer(rng.bytes(8 * 20_000), float)
    values = np.concatenate([rng.normal(size=20_000), bits[np.isfinite(bits)]])
    path = tmp_path / "data.csv"
    lines = [f"1,{value!r},0,1,1" for value in values.tolist()]
    path.write_text("\n".join(["time,x,y,vx,vy", *lines]))
    found = np.concatenate([rows.x for rows in read_rows(path)])
    np.testing.assert_array_equal(found, values)


GOOD = "time,x,y,vx,vy\n1,2,3,4,5\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is empty"),
        ("# nothing\n\n", "is empty"),
        ("time,x,y,vx\n", "column 'vy' is missing"),
        ("time,x,y,vx,v_y\n", "is 'v_y' meant?"),
        ("time,x,y,vx,vy,x\n", "column 'x' stands 2 times"),
        ("time,x,y,vx,vy\n", "has no rows"),
        (GOOD + "1,2,3,4\n", "line 3 has 4 columns; 5 are named"),
        (GOOD + "1,2,3,4,five\n", "line 3, column 'vy': 'five' is not a number"),
        (GOOD + "1,2,3,4,1.2.3\n", "line 3, column 'vy': '1.2.3' is not a number"),
        (GOOD + "1,2,3,4,1e\n", "line 3, column 'vy': '1e' is not a number"),
        (GOOD + "1,2,3,4,0x10\n", "line 3, column 'vy': '0x10' is not a number"),
        (GOOD + "# remark\n\n1,2,,4,5\n", "line 5, column 'y' is empty"),
        (GOOD + "1,nan,3,4,5\n", "line 3, column 'x': 'nan' is not a finite number"),
        (GOOD + "1,2,3,-Inf,5\n", "line 3, column 'vx': '-Inf' is not a finite number"),
        (GOOD + "1,2,3,1e999,5\n", "line 3, column 'vx': '1e999' is not a finite number"),
        (GOOD + "-1,2,3,4,5\n", "time: got -1; times must not be negative"),
        (GOOD, "has one tracer; at least two"),
        ("\ud800", "is not text in UTF-8"),
    ],
)
def test_bad_text_is_one_clear_line(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "data.csv"
    path.write_bytes(text.encode("utf-8", "surrogatepass"))
    with pytest.raises(InputError) as caught:
        read_sample([path])
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)
    assert "data.csv" in str(caught.value)


@pytest.mark.parametrize("kind", ["npz", "h5"])
@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d.pop("vy"), "column 'vy' is missing"),
        (lambda d: d.update(x=d["x"][:-1]), "columns differ in length"),
        (lambda d: d.update(x=d["x"].reshape(2, -1)), "has shape (2, 60); it must be (n,)"),
        (lambda d: d.update(x=d["x"].astype(complex)), "'x' is of type complex128"),
        (lambda d: d.update(x=np.array(["a"] * 120, dtype="S1")), "'x' is of type |S1"),
        (lambda d: d["y"].__setitem__(7, np.nan), "row 7 has y = nan"),
        (lambda d: d["y"].__setitem__(119, np.inf), "row 119 has y = inf"),
        (lambda d: d.update(tracer=d["tracer"] + 0.5), "'tracer' must be whole numbers"),
        (lambda d: d.update({k: v[:0] for k, v in d.items()}), "has no rows"),
        (lambda d: d["tracer"].__setitem__(1, 0), "tracer 0 of medium 0 has more than one row"),
    ],
)
def test_bad_arrays_are_one_clear_line(
    tmp_path: Path, kind: str, change: Any, message: str
) -> None:
    data = made_up()
    change(data)
    path = write(tmp_path, kind, data)
    before = path.read_bytes()
    with pytest.raises(InputError) as caught:
        read_sample([path])
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)
    assert path.read_bytes() == before


class Bomb:
    def __reduce__(self) -> Any:
        return (exec, ("raise SystemExit('a pickle was loaded')",))


@pytest.mark.parametrize("name", ["x", "tracer"])
def test_pickles_are_never_loaded(tmp_path: Path, name: str) -> None:
    data = made_up()
    data[name] = np.array([Bomb()] * 120, dtype=object)
    path = tmp_path / "data.npz"
    np.savez(path, **data)
    with pytest.raises(InputError, match="holds Python objects, which are never loaded"):
        read_sample([path])


def test_a_pickle_that_calls_itself_npz_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "data.npz"
    path.write_bytes(pickle.dumps(Bomb()))
    with pytest.raises(InputError, match=r"is damaged, or not an \.npz file"):
        read_sample([path])
    with zipfile.ZipFile(path, "w") as archive:
        for name in NAMES:
            archive.writestr(f"{name}.npy", pickle.dumps(Bomb()))
    with pytest.raises(InputError, match="array 'time' is damaged"):
        read_sample([path])


@pytest.mark.parametrize("kind", ["npz", "zip.npz", "h5", "csv"])
@pytest.mark.parametrize("part", [0.1, 0.5, 0.97])
def test_a_file_that_is_cut_off_is_refused_or_read(tmp_path: Path, kind: str, part: float) -> None:
    path = write(tmp_path, kind, made_up())
    whole = path.read_bytes()
    path.write_bytes(whole[: int(part * len(whole))])
    with pytest.raises(InputError) as caught:
        read_sample([path])
    assert "\n" not in str(caught.value)
    assert "data" in str(caught.value)


def test_damaged_bytes_of_an_npz_are_noticed(tmp_path: Path) -> None:
    path = write(tmp_path, "npz", made_up())
    data = bytearray(path.read_bytes())
    data[len(data) // 3] ^= 0xFF
    path.write_bytes(bytes(data))
    with pytest.raises(InputError, match="damaged"):
        read_sample([path])


def test_other_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read_sample([tmp_path / "none.csv"])
    with pytest.raises(InputError, match="at least one is needed"):
        read_sample([])
    (tmp_path / "folder.csv").mkdir()
    with pytest.raises(InputError, match="not a file"):
        read_sample([tmp_path / "folder.csv"])
    (tmp_path / "data.txt").write_text(GOOD)
    with pytest.raises(InputError, match=r"must be a file \.csv, \.npz or \.h5"):
        read_sample([tmp_path / "data.txt"])
    foreign = tmp_path / "foreign.h5"
    with h5py.File(foreign, "w") as file:
        file["a/b"] = np.arange(3)
        file["time"] = h5py.Empty("f")
    with pytest.raises(InputError, match="column 'x' is missing"):
        read_sample([foreign])
    foreign.write_bytes(b"\x89HDF\r\n\x1a\n nothing else")
    with pytest.raises(InputError, match="damaged, or not an HDF5 file"):
        read_sample([foreign])


def test_times_within_rounding_are_one_time(tmp_path: Path) -> None:
    data = made_up(times=(0.1 + 0.2, 1.0))
    data["time"][:20] = 0.3
    sample = read_sample([write(tmp_path, "npz", data)])
    np.testing.assert_array_equal(sample.samples, [40, 40])


def test_too_many_times_are_refused(tmp_path: Path) -> None:
    data = made_up()
    data["time"] = np.arange(data["time"].size) * 1.0
    path = write(tmp_path, "npz", {k: np.tile(v, 5) for k, v in data.items() if k != "time"} | {
        "time": np.arange(600.0)
    })  # fmt: skip
    with pytest.raises(InputError, match="more than 400 different times"):
        read_sample([path])


def test_absolute_positions_become_displacements(tmp_path: Path) -> None:
    data = made_up()
    plain = read_sample([write(tmp_path, "npz", data)])
    origin = np.random.default_rng(2).uniform(-50, 50, (2, 40))
    moved = data | {"x": data["x"] + np.tile(origin[0], 3), "y": data["y"] + np.tile(origin[1], 3)}
    order = np.random.default_rng(1).permutation(120)
    path = write(tmp_path, "csv", {name: moved[name][order] for name in NAMES})
    for rule in ("auto", "absolute"):
        sample = read_sample([path], positions=rule)
        np.testing.assert_allclose(moments(sample), moments(plain), rtol=1e-9, atol=1e-9)
    assert "Positions at time 0 are not the origin" in read_sample([path]).warnings[0]
    told = read_sample([path], positions="displacement")
    assert (told.sums[:, 0, R2] > 0).all()


def test_absolute_positions_need_a_tracer_and_a_time_0(tmp_path: Path) -> None:
    data = made_up()
    data["x"] = data["x"] + 5
    without = {k: v for k, v in data.items() if k != "tracer"}
    with pytest.raises(InputError, match="without a column tracer"):
        read_sample([write(tmp_path, "npz", without)])
    later = {k: v[40:] for k, v in data.items()}
    with pytest.raises(InputError, match="need rows at time 0"):
        read_sample([write(tmp_path, "npz", later)], positions="absolute")
    some = {k: np.delete(v, 3) for k, v in data.items()}
    with pytest.raises(InputError, match="tracer 3 has no row at time 0"):
        read_sample([write(tmp_path, "npz", some)])
    with pytest.raises(InputError, match="positions: got 'relative'"):
        read_sample([write(tmp_path, "npz", data)], positions="relative")


def test_units_of_the_data(tmp_path: Path) -> None:
    """The same data in other units: U = 3, d = 2, so that times are in units of 2/3 d/U."""
    data = made_up(tracers=400)
    plain = read_sample([write(tmp_path, "npz", data)])
    other = {
        name: values * {"time": 2 / 3, "x": 2, "y": 2, "vx": 3, "vy": 3}.get(name, 1)
        for name, values in data.items()
    }
    path = write(tmp_path, "npz", other)
    sample = read_sample([path], speed_unit=3.0, diameter=2.0)
    np.testing.assert_allclose(sample.times, plain.times)
    np.testing.assert_allclose(moments(sample), moments(plain), rtol=1e-12)
    found = read_sample([path], speed_unit="data", diameter=2.0)
    size = np.sqrt(np.mean(data["vx"][:400] ** 2 + data["vy"][:400] ** 2) / 2)
    np.testing.assert_allclose(found.times, plain.times * size)
    assert "U is" in found.warnings[-1]
    with pytest.raises(InputError, match="speed_unit"):
        read_sample([path], speed_unit=-1.0)
    later = write(tmp_path, "npz", {k: v[400:] for k, v in data.items()})
    with pytest.raises(InputError, match="needs velocities at time 0"):
        read_sample([later], speed_unit="data")


def test_without_configurations_errors_are_by_tracer_and_said_so(tmp_path: Path) -> None:
    data = made_up()
    no_medium = {k: v for k, v in data.items() if k != "medium"}
    sample = read_sample([write(tmp_path, "npz", no_medium)])
    assert (sample.grouping, sample.groups) == ("tracer", 40)
    assert "share scatterers are not independent" in sample.warnings[0]
    rows = {k: v for k, v in no_medium.items() if k != "tracer"}
    sample = read_sample([write(tmp_path, "npz", rows)])
    assert (sample.grouping, sample.groups) == ("row", 40)
    assert "k-th row" in sample.warnings[1]
    one = data | {"medium": np.zeros(120, int)}
    sample = read_sample([write(tmp_path, "npz", one)])
    assert (sample.grouping, sample.groups) == ("tracer", 40)
    assert "one configuration" in sample.warnings[0]


def test_several_files_are_runs_of_their_own(tmp_path: Path) -> None:
    data = made_up()
    a = write(tmp_path, "npz", data)
    b = write(tmp_path, "csv", data)
    sample = read_sample([a, b])
    np.testing.assert_array_equal(sample.samples, [80, 80, 80])
    assert sample.groups == 20
    assert sample.names == ("data.npz", "data.csv")
    write(tmp_path, "h5", {k: v for k, v in data.items() if k != "medium"})
    with pytest.raises(InputError, match=r"data\.h5: column medium must be in all files"):
        read_sample([a, tmp_path / "data.h5"])


def test_many_configurations_share_groups(tmp_path: Path) -> None:
    data = made_up(tracers=4000)
    sample = read_sample([write(tmp_path, "npz", data)])
    assert sample.groups == MOST_GROUPS
    np.testing.assert_array_equal(sample.samples, [4000] * 3)


def test_a_file_is_read_in_pieces(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Pieces of any size give the same sums, and no piece is larger than it may be."""
    data = made_up(tracers=400)
    paths = [write(tmp_path, kind, data) for kind in ("csv", "npz", "h5")]
    whole = [read_sample([path]) for path in paths]
    monkeypatch.setattr(arrays, "PIECE", 70)
    monkeypatch.setattr(csv_files, "BLOCK", 5000)
    for path, expected in zip(paths, whole, strict=True):
        pieces = list(read_rows(path))
        assert len(pieces) > 15
        assert max(rows.time.size for rows in pieces) <= 100
        assert sum(rows.time.size for rows in pieces) == 1200
        sample = read_sample([path])
        np.testing.assert_allclose(moments(sample), moments(expected), rtol=1e-10)


def test_memory_does_not_grow_with_the_file(tmp_path: Path) -> None:
    """Ten times the rows, the same memory: a few pieces."""
    import tracemalloc

    peaks = []
    for factor in (1, 10):
        data = made_up(tracers=100_000 * factor, times=(1.0, 2.0))
        path = write(tmp_path, "npz", {k: v for k, v in data.items() if k != "medium"})
        del data
        tracemalloc.start()
        read_sample([path])
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    # a million rows of six columns are 96 MB; what is kept is a piece or two and the set of tracers
    assert peaks[1] < 150e6
    assert arrays.PIECE * 6 * 8 < 30e6
    assert peaks[1] - peaks[0] < 130e6


def test_labels_that_are_used_again_in_each_configuration(tmp_path: Path) -> None:
    """Tracers 0 .. n - 1 in each of the configurations 0 .. m - 1: labels are two columns, not a
    sum of the two, in which (1, 0) and (0, 1) would be one."""
    data = made_up(tracers=40)
    data["medium"] = data["tracer"] // 8
    data["tracer"] = data["tracer"] % 8
    for kind in ("csv", "npz", "h5"):
        sample = read_sample([write(tmp_path, kind, data)])
        assert (sample.groups, sample.grouping) == (5, "medium")
        np.testing.assert_array_equal(sample.samples, [40, 40, 40])
    moved = data | {"x": data["x"] + np.tile(np.arange(40.0), 3)}
    absolute = read_sample([write(tmp_path, "npz", moved)])
    np.testing.assert_allclose(moments(absolute), moments(sample), rtol=1e-9, atol=1e-9)
    data["tracer"][41] = 0  # tracer 1 of configuration 0 at time 1
    with pytest.raises(InputError, match="tracer 0 of medium 0 has more than one row at time 1;"):
        read_sample([write(tmp_path, "npz", data)])


@pytest.mark.parametrize("wide", [1, 2**55, -(2**55)])
def test_labels_of_any_size_are_told_apart(wide: int) -> None:
    n = 300
    zeros = np.zeros(n)
    tracer = np.arange(n) % 30 * wide
    medium = np.arange(n) // 30 * wide
    run = Reduction("medium")
    for time in (1.0, 2.0):
        run.add(Rows(np.full(n, time), zeros, zeros, zeros + 1, zeros, tracer, medium))
    assert run.sample(("x",)).samples.tolist() == [n, n]
    run.add(Rows(*(v[:1] for v in (zeros + 2, zeros, zeros, zeros + 1, zeros, tracer, medium))))
    with pytest.raises(InputError, match="tracer 0 of medium 0 has more than one row at time 2"):
        run.sample(("x",))


def test_repeated_rows_are_found_in_a_part_of_the_tracers(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Where there are more rows than are remembered, a part of the tracers is, at all times."""
    monkeypatch.setattr(labels, "MOST_REMEMBERED", 600)
    n = 5000
    zeros, label = np.zeros(n), 2 * np.arange(n)
    run = Reduction("tracer")
    for time in (1.0, 2.0):
        run.add(Rows(np.full(n, time), zeros, zeros, zeros + 1, zeros, label))
    assert run.sample(("x",)).samples.tolist() == [n, n]
    run.add(Rows(np.full(n, 2.0), zeros, zeros, zeros + 1, zeros, label))
    with pytest.raises(InputError, match="has more than one row at time 2"):
        run.sample(("x",))


def test_data_in_other_files_are_not_followed(tmp_path: Path) -> None:
    """Links and external storage of an HDF5 file could name any file of the system."""
    data = made_up()
    target = write(tmp_path, "h5", data)
    path = tmp_path / "links.h5"
    raw = tmp_path / "raw.bin"
    raw.write_bytes(data["x"].tobytes())
    for kind in ("link", "storage", "virtual"):
        with h5py.File(path, "w") as file:
            for name in NAMES[2:] + NAMES[:1]:
                file[name] = data[name]
            if kind == "link":
                file["x"] = h5py.ExternalLink(str(target), "/x")
            elif kind == "storage":
                file.create_dataset("x", (120,), float, external=[(str(raw), 0, 960)])
            else:
                layout = h5py.VirtualLayout((120,), float)
                layout[:] = h5py.VirtualSource(str(target), "x", (120,))
                file.create_virtual_dataset("x", layout)
        with pytest.raises(InputError, match="column 'x' is missing"):
            read_sample([path])


def test_bins_count_what_lies_outside() -> None:
    """Zero and tiny values below, huge ones above."""
    speeds = np.array([1.0] * 98 + [0.0, 1e-30])
    zeros = np.zeros(100)
    run = Reduction("row")
    run.add(Rows(np.ones(100), zeros, zeros, speeds, zeros))
    run.add(Rows(np.ones(2), zeros[:2], zeros[:2], np.array([1e9, 1.0]), zeros[:2]))
    sample = run.sample(("x",))
    assert sample.speeds is not None
    assert sample.speeds.totals[0, 0] == 2
    assert sample.speeds.totals[0, -1] == 1
    assert sample.at_rest.tolist() == [1]
    assert reduction.SAME_TIME < 1e-8


def tracers_at(times: Any, count: int, speed: Any = None, scale: float = 1.0) -> dict[str, Any]:
    """Tracers that spread as they fly; `speed`: all of them the same."""
    data = made_up(count, times)
    data = {k: v for k, v in data.items() if k != "medium"}
    for name in ("x", "y", "vx", "vy"):
        data[name] = data[name] * scale
    if speed is not None:
        data["vx"], data["vy"] = np.full(data["time"].size, speed), np.zeros(data["time"].size)
    return data


@pytest.mark.parametrize(
    ("data", "told"),
    [
        (tracers_at([1.0], 2), {"restitution": 0.7}),
        (tracers_at([1.0, 2, 3], 3), {"restitution": 0.7}),
        (tracers_at([0.0], 50), {"restitution": 0.7}),
        (tracers_at([1.0, 10.0], 50, speed=1.0), {"restitution": 0.7}),
        (tracers_at([1.0, 10.0], 50, speed=0.0), {"restitution": 0.7}),
        (tracers_at([0.0, 1.0, 10.0], 80, speed=1.0), {"restitution": 0.0}),
        (tracers_at([0.0, 1.0, 10.0], 80, speed=1.0), {"restitution": 1.0}),
        (tracers_at([1e-200, 1e-3], 80), {"restitution": 0.5}),
        (tracers_at([1e10, 1e12], 80), {"restitution": 0.5}),
        (tracers_at([1.0, 10.0], 50, scale=1e-170), {"restitution": 0.5}),
    ],
)
def test_odd_data_have_an_answer(
    data: dict[str, Any], told: dict[str, float], tmp_path: Path
) -> None:
    from kinetics.crosscheck.comparison.page import files_of
    from kinetics.crosscheck.comparison.question import compare_sample

    result = compare_sample(
        read_sample([write(tmp_path, "npz", data)]), number_density=0.04, **told
    )
    assert result.verdict in ("agrees", "unclear", "differs", "undefined")
    assert set(files_of(result, tmp_path / "page.html")) == {"page.html", "page.json"}
    if told["restitution"] == 0.7 and len(data["time"]) < 10:
        assert result.verdict != "differs"  # two or three tracers cannot


@pytest.mark.parametrize(
    ("data", "told", "message"),
    [
        (tracers_at([1.0, 2.0], 3), {}, "cannot be found in so few times and groups"),
        (tracers_at([0.0], 50), {}, "cannot be found in so few times and groups"),
        (tracers_at([0.0, 1.0], 50, speed=0.0), {"restitution": 0.7}, "every speed at time 0"),
        (tracers_at([1.0], 50), {"restitution": 0.7, "initial": "data"}, "needs velocities at"),
        (tracers_at([1.0], 50), {"restitution": 0.7, "initial": "ring"}, "must be one of auto"),
        (tracers_at([1.0], 50, scale=1e160), {"restitution": 0.7}, "give --speed-unit"),
        (tracers_at([0.0, 1.0], 50, scale=1e-100), {"restitution": 0.7}, "give --speed-unit"),
    ],
)
def test_what_cannot_be_compared_is_said(
    data: dict[str, Any], told: dict[str, Any], message: str, tmp_path: Path
) -> None:
    from kinetics.crosscheck.comparison.question import compare_sample

    density = None if told == {} else 0.04
    path = write(tmp_path, "npz", data)
    with pytest.raises(InputError, match=message):
        compare_sample(read_sample([path]), number_density=density, **told)


def test_a_file_may_have_any_name(tmp_path: Path) -> None:
    """Also bytes that are no text."""
    from kinetics.crosscheck.comparison.page import files_of
    from kinetics.crosscheck.comparison.question import compare_sample

    path = write(tmp_path, "csv", made_up()).rename(tmp_path / os.fsdecode(b"a\xff<b>.csv"))
    result = compare_sample(read_sample([path]), 0.7, 0.04)
    assert result.names == ("a?<b>.csv",)
    page = files_of(result, tmp_path / "page.html")["page.html"]
    assert isinstance(page, str)
    assert "a?&lt;b&gt;.csv" in page
    page.encode()
    path.write_text("time\n")
    with pytest.raises(InputError, match=r"a\?<b>\.csv: column 'x' is missing"):
        read_sample([path])
