"""Files are whole or absent, whatever interrupts the writing."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from kinetics.crosscheck import files
from kinetics.crosscheck.files import require_file, require_writable_folder, write_together


def test_files_are_written_into_a_new_folder(tmp_path: Path) -> None:
    folder = tmp_path / "a" / "b"
    paths = write_together(folder, {"x.txt": "é", "y.bin": b"\0"})
    assert paths == [folder / "x.txt", folder / "y.bin"]
    assert paths[0].read_bytes() == "é".encode()
    assert sorted(p.name for p in folder.iterdir()) == ["x.txt", "y.bin"]


def test_other_files_of_the_folder_stay(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    (tmp_path / "x.txt").write_text("old")
    write_together(tmp_path, {"x.txt": "new"})
    assert {p.name: p.read_text() for p in tmp_path.iterdir()} == {
        "mine.txt": "mine",
        "x.txt": "new",
    }


@pytest.mark.parametrize("interruption", [KeyboardInterrupt, OSError])
@pytest.mark.parametrize("at", [0, 1])
def test_an_interrupted_write_leaves_what_was_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, interruption: type, at: int
) -> None:
    (tmp_path / "x.txt").write_text("old")
    calls = []

    def fsync(handle: int) -> None:
        calls.append(handle)
        if len(calls) == at + 1:
            raise interruption

    monkeypatch.setattr(files.os, "fsync", fsync)
    expected = ValueError if interruption is OSError else KeyboardInterrupt
    with pytest.raises(expected):
        write_together(tmp_path, {"x.txt": "new", "y.txt": "new"})
    assert {p.name: p.read_text() for p in tmp_path.iterdir()} == {"x.txt": "old"}


def test_a_folder_made_for_nothing_is_removed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fsync(handle: int) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(files.os, "fsync", fsync)
    with pytest.raises(KeyboardInterrupt):
        write_together(tmp_path / "a" / "b", {"x.txt": "new"})
    assert list(tmp_path.iterdir()) == []


def test_a_process_ended_in_the_middle_leaves_nothing(tmp_path: Path) -> None:
    # SIGTERM while the second file is written, with the command's own handler in place.
    code = f"""
import os, signal
from pathlib import Path
from kinetics import cli
from kinetics.crosscheck import files
signal.signal(signal.SIGTERM, cli._terminate)
real, calls = os.fsync, []
def fsync(handle):
    calls.append(handle)
    if len(calls) == 2:
        os.kill(os.getpid(), signal.SIGTERM)
    real(handle)
files.os.fsync = fsync
files.write_together(Path({str(tmp_path / "out")!r}), {{"x": "1", "y": "2"}})
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (143, "")
    assert list(tmp_path.iterdir()) == []


def test_a_file_in_the_way_is_refused_by_name(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    for folder in (tmp_path / "file", tmp_path / "file" / "deeper"):
        with pytest.raises(ValueError, match=r"output folder .*file.* cannot be written"):
            require_writable_folder(folder)
        with pytest.raises(ValueError, match=r"output folder .*file.* cannot be written"):
            write_together(folder, {"x": "1"})
    assert (tmp_path / "file").read_text() == ""


@pytest.mark.skipif(
    not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write everywhere"
)
def test_a_folder_without_permission_is_refused(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    with pytest.raises(ValueError, match="cannot be written"):
        require_writable_folder(tmp_path / "new")
    tmp_path.chmod(0o700)


def test_asking_leaves_nothing(tmp_path: Path) -> None:
    require_writable_folder(tmp_path / "a")
    assert list(tmp_path.iterdir()) == []


def test_a_folder_in_one_that_is_not_there_is_refused_with_the_way_out(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"make it first: mkdir -p .*a$"):
        require_writable_folder(tmp_path / "a" / "b")
    with pytest.raises(ValueError, match=r"make it first: mkdir -p .*a$"):
        require_file("output", tmp_path / "a" / "b.csv")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["", "x.txt", "folder.csv", "missing/x.csv"])
def test_a_file_that_cannot_be_made_is_refused_by_its_option(tmp_path: Path, name: str) -> None:
    (tmp_path / "folder.csv").mkdir()
    file = tmp_path / name if name else Path(name)
    with pytest.raises(ValueError, match="output"):
        require_file("output", file, (".csv",))
    assert [path.name for path in tmp_path.iterdir()] == ["folder.csv"]
