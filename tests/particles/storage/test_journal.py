"""Every configuration is saved when it is done, and no journal that is not understood is used."""

import os
import re
import shutil
import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

from particles import Ensemble, Poisson, simulate

ARGUMENTS = dict(
    medium=Poisson(0.1, 500), restitution=0.5, times=[2.0, 50.0], media=9, tracers=8, seed=3,
    workers=1, observables=["displacement_histogram", "velocities"],
)  # fmt: skip


@pytest.fixture(scope="module")
def whole() -> Ensemble:
    return simulate(**ARGUMENTS)


@pytest.fixture
def killed(tmp_path: Path) -> Path:
    """The file of a run killed after 5 configurations; its journal holds all of them."""
    path, copy = tmp_path / "run.h5", tmp_path / "copy"
    copy.mkdir()

    def progress(done: int, total: int) -> None:
        if done == 0:
            shutil.copy(path, copy)
        if done == 5:
            shutil.copy(f"{path}.journal", copy)

    simulate(**ARGUMENTS, output=path, progress=progress)
    assert sorted(os.listdir(copy)) == ["run.h5", "run.h5.journal"]
    return copy / "run.h5"


@pytest.fixture(autouse=True)
def _write_the_file_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("particles.storage.saving.SHARE", 1e-9)


def resume(path: Path) -> tuple[Ensemble, int]:
    """Return the result, and how many configurations had been done."""
    seen: list[int] = []
    ensemble = simulate(
        **ARGUMENTS, output=path, resume=True, progress=lambda done, total: seen.append(done)
    )
    assert os.listdir(path.parent) == [path.name]
    return ensemble, seen[0]


def same(a: Ensemble, b: Ensemble) -> bool:
    return a.arrays.keys() == b.arrays.keys() and all(
        array.tobytes() == b.arrays[name].tobytes() for name, array in a.arrays.items()
    )


def records(journal: bytes) -> list[int]:
    """Return where each record begins, and the end."""
    at = [journal.index(b"\n") + 1 + 32]
    while at[-1] < len(journal):
        at.append(at[-1] + 44 + int.from_bytes(journal[at[-1] : at[-1] + 8], "little"))
    return at


def test_a_journal_is_gone_on_from(killed: Path, whole: Ensemble) -> None:
    ensemble, done = resume(killed)
    assert done == 5
    assert same(ensemble, whole)
    assert same(Ensemble.load(killed), whole)


def test_a_journal_cut_anywhere_keeps_its_whole_records(killed: Path, whole: Ensemble) -> None:
    journal = Path(f"{killed}.journal")
    good, file = journal.read_bytes(), killed.read_bytes()
    at = records(good)
    assert len(at) == 6
    cuts = [(0, 0), (10, 0), (at[0] - 1, 0), (at[0], 0), (at[0] + 5, 0), (at[3], 3)]
    cuts += [(at[4] + more, 4) for more in (1, 11, 12, 43, 44, 60)] + [(at[5] - 1, 4)]
    for cut, expected in cuts:
        killed.write_bytes(file)
        journal.write_bytes(good[:cut])
        ensemble, done = resume(killed)
        assert (cut, done) == (cut, expected)
        assert same(ensemble, whole)


def test_what_follows_a_torn_record_is_read_again(killed: Path, whole: Ensemble) -> None:
    # Killed in the middle of a record, resumed, and killed again two configurations later.
    journal = Path(f"{killed}.journal")
    file, good = killed.read_bytes(), journal.read_bytes()
    journal.write_bytes(good[:-9])
    later = []

    def progress(done: int, total: int) -> None:
        if done == 6:
            later.append(journal.read_bytes())

    # The file is written at the end only, as the first run's was.
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("particles.storage.saving.time.monotonic", lambda: -1.0)
        simulate(**ARGUMENTS, output=killed, resume=True, progress=progress)
    killed.write_bytes(file)
    journal.write_bytes(later[0])
    ensemble, done = resume(killed)
    assert done == 6
    assert same(ensemble, whole)


def test_killed_between_writing_the_file_and_emptying_the_journal(
    killed: Path, whole: Ensemble
) -> None:
    journal = Path(f"{killed}.journal")
    old = journal.read_bytes()

    class Stopped(Exception):
        pass

    def stop(done: int, total: int) -> None:
        if done == 5:
            raise Stopped

    with pytest.raises(Stopped):
        simulate(**ARGUMENTS, output=killed, resume=True, progress=stop)
    assert not journal.exists()
    journal.write_bytes(old)
    ensemble, done = resume(killed)
    assert done == 5
    assert same(ensemble, whole)


def refused(path: Path, message: str) -> None:
    before = {name: (path.parent / name).read_bytes() for name in os.listdir(path.parent)}
    with pytest.raises(ValueError, match=message) as caught:
        simulate(**ARGUMENTS, output=path, resume=True)
    assert "\n" not in str(caught.value)
    assert before == {name: (path.parent / name).read_bytes() for name in os.listdir(path.parent)}


def test_a_damaged_or_foreign_journal_is_refused(killed: Path) -> None:
    journal = Path(f"{killed}.journal")
    good = journal.read_bytes()
    at = records(good)
    # The length, its check, the digest, the line that describes, and the numbers of one record.
    for place in (at[2], at[2] + 9, at[2] + 20, at[2] + 60, at[3] - 10):
        journal.write_bytes(good[:place] + bytes([good[place] ^ 1]) + good[place + 1 :])
        refused(killed, "run.h5.journal: is damaged")
    journal.write_bytes(good[: at[1]] + good[at[2] :])
    refused(killed, "configuration 1 is not in it")
    journal.write_bytes(good[: at[0] - 32] + bytes(32) + good[at[0] :])
    refused(killed, "belongs to another run")
    journal.write_text("x,y\n1,2\n")
    refused(killed, "is not a journal")
    # The file of the run is gone, and the journal does not begin where a run begins.
    journal.write_bytes(good[: at[0]] + good[at[1] :])
    killed.unlink()
    refused(killed, "configuration 0 is not in it")


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such locks")
def test_two_processes_do_not_save_to_one_file(killed: Path) -> None:
    import fcntl

    with open(f"{killed}.journal", "rb") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        refused(killed, "in use by another process")


LONG = """
    import sys
    from particles import Poisson, simulate
    simulate(
        Poisson(0.1, 200), 0.9, times=[1.0, 1e4], media=3000, tracers=1, seed=4, workers=2,
        output=sys.argv[1], resume=True, progress=lambda done, total: print(done, flush=True),
    )
"""


def test_what_was_reported_done_survives_a_kill(tmp_path: Path) -> None:
    command = [sys.executable, "-c", textwrap.dedent(LONG), str(tmp_path / "run.h5")]
    done = 0
    for stop in (137, 700):
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        begun = int(process.stdout.readline())
        assert begun >= done
        for line in process.stdout:
            done = int(line)
            if done >= stop:
                break
        process.send_signal(signal.SIGKILL)
        # What it had still said before it died.
        last = re.findall(r"(\d+)\n", process.stdout.read())
        done = int(last[-1]) if last else done
        assert process.wait() == -signal.SIGKILL
        process.stdout.close()
    resumed = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True)
    assert int(resumed.stdout.split()[0]) >= done
    assert os.listdir(tmp_path) == ["run.h5"]
    expected = simulate(Poisson(0.1, 200), 0.9, times=[1.0, 1e4], media=3000, tracers=1, seed=4)
    assert same(expected, Ensemble.load(tmp_path / "run.h5"))
