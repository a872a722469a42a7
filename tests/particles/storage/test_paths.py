"""Where a run is saved: no link is followed, no pipe is waited for, no other run is disturbed."""

import os
import signal
import subprocess
import sys
import textwrap
from pathlib import Path
from typing import Any

import pytest
from marking import slow_but

import particles.storage.journal as journals
from kinetics import Scene, load
from particles import Ensemble, Poisson, simulate

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has none of these")

RUN: dict[str, Any] = dict(
    medium=Poisson(0.1, 500), restitution=0.5, times=[2.0], media=3, tracers=2, workers=1
)


def refused(path: Path, words: str, **changes: Any) -> None:
    with pytest.raises(ValueError, match=words) as caught:
        simulate(**RUN | dict(output=path) | changes)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("resume", [False, True])
@pytest.mark.parametrize("length", [0, 10, 38, 50, 69])
def test_a_journal_without_a_configuration_begins_anew(
    length: int, resume: bool, tmp_path: Path
) -> None:
    """So a process killed in its first moment leaves it."""
    path = tmp_path / "run.h5"
    head = journals.HEAD + bytes(32)  # of any plan
    Path(f"{path}.journal").write_bytes(head[:length])
    run = simulate(**RUN, output=path, resume=resume)
    assert run == simulate(**RUN)
    assert os.listdir(tmp_path) == ["run.h5"]


def test_a_journal_whose_file_is_gone_is_gone_on_from(tmp_path: Path) -> None:
    path, kept = tmp_path / "run.h5", tmp_path / "kept"

    def keep(done: int, total: int) -> None:
        if done == 2:
            kept.write_bytes(Path(f"{path}.journal").read_bytes())

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("particles.storage.saving.SHARE", 1e-9)
        whole = simulate(**RUN, output=path, progress=keep)
    path.unlink()
    kept.rename(f"{path}.journal")
    refused(path, r"run\.h5\.journal': exists; resume=True")
    seen: list[int] = []
    again = simulate(**RUN, output=path, resume=True, progress=lambda done, _: seen.append(done))
    assert (again, seen[0]) == (whole, 2)


LIVE = """
    import sys
    from particles import Poisson, simulate
    simulate(
        Poisson(0.1, 200), 0.9, times=[1.0, 1e4], media=1_000_000, tracers=1, workers=1,
        output=sys.argv[1], progress=lambda done, total: print(done, flush=True),
    )
"""


@pytest.mark.parametrize("resume", slow_but([False], [False, True]))
def test_a_run_in_another_process_is_in_use(resume: bool, tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    command = [sys.executable, "-c", textwrap.dedent(LIVE), str(path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        process.stdout.readline()
        refused(path, r"run\.h5\.journal: in use by another process$", resume=resume)
        process.send_signal(signal.SIGKILL)
    assert Path(f"{path}.journal").exists()
    refused(path, "exists; resume=True")  # and no longer in use


def test_a_child_process_does_not_keep_the_lock(tmp_path: Path) -> None:
    journal = journals.Journal(str(tmp_path / "a.journal"), bytes(32))
    ready, told = os.pipe()
    child = os.fork()
    if not child:
        os.write(told, b".")
        signal.pause()
    try:
        os.read(ready, 1)
        journal.close()
        journals.Journal(str(tmp_path / "a.journal"), bytes(32)).close()
    finally:
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        os.close(ready)
        os.close(told)


def test_a_journal_removed_before_it_was_locked_is_made_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The process that had it locked came to its end in between."""
    path, real, calls = tmp_path / "a.journal", journals._lock, []

    def lock(file: Any, name: str) -> None:
        if not calls:
            path.unlink()
        calls.append(name)
        real(file, name)

    monkeypatch.setattr(journals, "_lock", lock)
    journals.Journal(str(path), bytes(32)).close()
    assert len(calls) == 2
    assert path.exists()


@pytest.mark.parametrize("content", ["", "mine\n"])
def test_links_are_not_followed(content: str, tmp_path: Path) -> None:
    victim, path = tmp_path / "victim", tmp_path / "run.h5"
    victim.write_text(content)
    Path(f"{path}.journal").symlink_to(victim)
    refused(path, r"run\.h5\.journal: is a symbolic link, not a file")
    Path(f"{path}.journal").unlink()
    Path(f"{path}.part").symlink_to(victim)
    path.symlink_to(victim)
    run = simulate(**RUN)
    run.save(path)  # takes the place of the link
    assert not path.is_symlink()
    assert Ensemble.load(path) == run
    assert victim.read_text() == content


def test_pipes_are_not_waited_for(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    for resume in (False, True):
        refused(pipe, "pipe: is a pipe, not a file", resume=resume)
    for read in (Ensemble.load, simulate(**RUN).save, load, Scene(0.5, times=[1.0]).save):
        with pytest.raises(ValueError, match=r"is a (device or a )?pipe, not a file"):
            read(pipe)
    os.mkfifo(tmp_path / "run.h5.journal")
    refused(tmp_path / "run.h5", r"journal: is a pipe, not a file")
    assert sorted(os.listdir(tmp_path)) == ["pipe", "run.h5.journal"]


def test_a_device_is_not_replaced(tmp_path: Path) -> None:
    """A link to one: if this fails, the machine keeps its device."""
    device = tmp_path / "null"
    device.symlink_to("/dev/null")
    for save in (simulate(**RUN).save, Scene(0.5, times=[1.0]).save):
        with pytest.raises(ValueError, match=r"null.* is a device"):
            save(device)
    refused(device, "null: is a device, not a file")
    assert device.is_symlink()
    assert os.listdir(tmp_path) == ["null"]


def test_what_a_killed_process_left_half_written_is_removed(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    simulate(**RUN, output=path)
    left = tmp_path / ".run.h5.0123456789abcdef.part"
    others = [tmp_path / name for name in (".run.h5.part", ".other.h5.0123456789abcdef.part")]
    for file in (left, *others):
        file.write_text("half")
    simulate(**RUN, output=path, resume=True)
    assert not left.exists()
    assert all(file.exists() for file in others)
