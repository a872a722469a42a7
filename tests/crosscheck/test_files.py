"""Files are whole or absent, whatever interrupts the writing; JSON and tables are strict."""

import json
import os
from pathlib import Path

import numpy as np
import pytest

from kinetics.crosscheck import files


def contents(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def test_files_are_written_together_into_new_and_old_folders(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "mine").write_text("mine")
    (tmp_path / "a" / "x").write_text("old")
    for folder in (tmp_path / "a", tmp_path / "b" / "c"):
        assert files.write_together(folder, {"x": "é", "y": b"\0"}) == [folder / "x", folder / "y"]
    assert contents(tmp_path / "b") == {"c/x": "é".encode(), "c/y": b"\0"}
    assert contents(tmp_path / "a") == {"x": "é".encode(), "y": b"\0", "mine": b"mine"}


@pytest.mark.parametrize("interruption", [KeyboardInterrupt, OSError])
@pytest.mark.parametrize("at", [0, 1])
@pytest.mark.parametrize("folder", [".", "a/b"])
def test_an_interrupted_write_leaves_what_was_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, interruption: type, at: int, folder: str
) -> None:
    (tmp_path / "x").write_text("old")
    calls: list[int] = []

    def fsync(handle: int) -> None:
        calls.append(handle)
        if len(calls) == at + 1:
            raise interruption

    monkeypatch.setattr(files.os, "fsync", fsync)
    with pytest.raises(ValueError if interruption is OSError else KeyboardInterrupt):
        files.write_together(tmp_path / folder, {"x": "new", "y": "new"})
    assert [p.name for p in tmp_path.iterdir()] == ["x"]
    assert (tmp_path / "x").read_text() == "old"


@pytest.mark.parametrize("name", ["", "x.txt", "folder.csv", "missing/x.csv", "file/x.csv"])
def test_what_cannot_be_made_is_refused_and_asking_leaves_nothing(
    tmp_path: Path, name: str
) -> None:
    (tmp_path / "folder.csv").mkdir()
    (tmp_path / "file").write_text("")
    with pytest.raises(ValueError, match="output"):
        files.require_file("output", tmp_path / name if name else Path(name), (".csv",))
    for folder in (tmp_path / "file", tmp_path / "file" / "deeper", tmp_path / "no" / "such"):
        with pytest.raises(ValueError, match=folder.name):
            files.require_writable_folder(folder)
    files.require_file("output", tmp_path / "a.csv", (".csv",))
    files.require_writable_folder(tmp_path / "new")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["file", "folder.csv"]


@pytest.mark.skipif(
    not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write everywhere"
)
def test_a_folder_without_permission_is_refused(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    with pytest.raises(ValueError, match=tmp_path.name):
        files.require_writable_folder(tmp_path / "new")
    tmp_path.chmod(0o700)


def test_json_has_no_numpy_and_no_nan() -> None:
    value = {"a": np.array([1.0, np.nan]), "b": (np.float64(2), np.int32(3)), 4: float("inf")}
    assert json.loads(files.dumps(value)) == {"a": [1.0, None], "b": [2.0, 3], "4": None}
