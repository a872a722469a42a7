"""Files of particle data: what is read, to the last bit and in pieces, and what is refused."""

import pickle
import zipfile
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from kinetics.crosscheck.comparison.data import arrays, csv_files
from kinetics.crosscheck.comparison.data.columns import read_rows
from kinetics.crosscheck.comparison.data.read import read_sample
from kinetics.errors import InputError

NAMES = ("time", "x", "y", "vx", "vy", "tracer", "medium")
GOOD = "time,x,y,vx,vy\n1,2,3,4,5\n"


@pytest.mark.parametrize("separator", [",", ";", "\t", " , "])
def test_dialects_of_csv(
    tmp_path: Path, separator: str, made_up: Any, moments: Any, text_of: Any, write: Any
) -> None:
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


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is empty"),
        ("# nothing\n\n", "is empty"),
        ("time,x,y,vx\n", "column 'vy' is missing"),
        ("time,x,y,vx,v-y\n", "is 'v-y' meant? Say so by --columns"),
        ("time,x,y,vx,vy,x\n", "column 'x' stands 2 times"),
        ("time,x,y,vx,vy\n", "has no rows"),
        (GOOD + "1,2,3,4\n", "line 3 has 4 columns; 5 are named"),
        (GOOD + "1,2,3,4,5,6\n", "line 3 has 6 columns; 5 are named"),
        (GOOD + '1,2,3,"4,5\n', "line 3 has 4 columns; 5 are named"),
        (GOOD + "1,2,3,4,1_0\n", "line 3, column 'vy': '1_0' is not a number"),
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
    tmp_path: Path, kind: str, change: Any, message: str, made_up: Any, write: Any
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
def test_pickles_are_never_loaded(tmp_path: Path, name: str, made_up: Any) -> None:
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
    header = b"{'descr': " + b"[" * 9000
    with zipfile.ZipFile(path, "w") as archive:
        for name in NAMES:
            text = b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header
            archive.writestr(f"{name}.npy", text)
    with pytest.raises(InputError, match="array 'time' is damaged"):
        read_sample([path])


@pytest.mark.parametrize("kind", ["npz", "zip.npz", "h5", "csv"])
@pytest.mark.parametrize("part", [0.1, 0.5, 0.97])
def test_a_file_that_is_cut_off_is_refused_or_read(
    tmp_path: Path, kind: str, part: float, made_up: Any, write: Any
) -> None:
    path = write(tmp_path, kind, made_up())
    whole = path.read_bytes()
    path.write_bytes(whole[: int(part * len(whole))])
    with pytest.raises(InputError) as caught:
        read_sample([path])
    assert "\n" not in str(caught.value)
    assert "data" in str(caught.value)


def test_damaged_bytes_of_an_npz_are_noticed(tmp_path: Path, made_up: Any, write: Any) -> None:
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
    with pytest.raises(InputError, match=r"damaged, or not an \.h5 file"):
        read_sample([foreign])


def test_a_file_is_read_in_pieces(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, made_up: Any, moments: Any, write: Any
) -> None:
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


@pytest.mark.slow
def test_memory_does_not_grow_with_the_file(tmp_path: Path, made_up: Any, write: Any) -> None:
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


def test_data_in_other_files_are_not_followed(tmp_path: Path, made_up: Any, write: Any) -> None:
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
