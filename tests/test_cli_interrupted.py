"""lorentz after Ctrl-C and SIGTERM: it ends within two seconds, whatever it is doing."""

import os
import random
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGINT to send")

SIGNALS = [(signal.SIGINT, 130), (signal.SIGTERM, 143)]
SAVED = (
    "simulate", "--count", "400", "--media", "1000000", "--tracers", "5", "-e", "0.9",
    "--times", "1,1000", "--observables", "free_path_histogram", "-o", "a.h5",
)  # fmt: skip
# one configuration takes longer than anybody waits
ENDLESS = (
    "simulate", "--count", "400", "-e", "1", "--media", "3", "--tracers", "100",
    "--times", "1,1e12", "-o", "a.h5",
)  # fmt: skip


class Running:
    """A command in a process of its own, which is told what to do by a signal."""

    def __init__(self, folder: Path, *arguments: str, code: str = "", **environment: str) -> None:
        program = ["-c", code] if code else ["-m", "kinetics.cli"]
        self.process = subprocess.Popen(
            [sys.executable, *program, *arguments], cwd=folder, stdout=subprocess.PIPE,
            stderr=subprocess.PIPE, text=True, env=os.environ | environment,
            # a shell that runs the tests in the background makes them, and children, ignore it
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
        )  # fmt: skip

    def end(self, number: signal.Signals) -> tuple[int, str, float]:
        """Send the signal; return the status, what is on standard error, and how long it took."""
        assert self.process.poll() is None, self.process.communicate()
        began = time.monotonic()
        self.process.send_signal(number)
        _, err = self.process.communicate(timeout=60)
        # click ends the line that a terminal shows ^C on
        return self.process.returncode, err.strip(), time.monotonic() - began

    def wait_for(self, path: Path) -> None:
        while self.process.poll() is None and not (path.exists() and path.stat().st_size > 60):
            time.sleep(0.01)


# Both signals have one handler; by default SIGTERM is sent in tests/test_cli_simulate.py only.
@pytest.fixture(
    params=[SIGNALS[0], pytest.param(SIGNALS[1], marks=pytest.mark.slow)], ids=["SIGINT", "SIGTERM"]
)
def how(request: pytest.FixtureRequest) -> Iterator[tuple[signal.Signals, int]]:
    return request.param


def check_end(run: Running, how: tuple[signal.Signals, int], saved: str = "") -> None:
    """It ends within two seconds, with the right status, and says only what is saved."""
    status, err, seconds = run.end(how[0])
    assert status == how[1]
    assert re.fullmatch(saved, err), err
    assert seconds < 2.0


def saved(count: str, media: int) -> str:
    """What is said of a run whose file is there."""
    return (
        rf"lorentz: {count} of {media} configurations are saved in a\.h5; "
        r"the same command with --resume goes on"
    )


def wait_for_line(run: Running) -> None:
    assert run.process.stdout is not None
    run.process.stdout.readline()
    time.sleep(0.2)


@pytest.mark.parametrize("workers", ["2", pytest.param("1", marks=pytest.mark.slow)])
def test_while_tracers_are_followed_for_hours(
    workers: str, how: tuple[signal.Signals, int], tmp_path: Path
) -> None:
    run = Running(tmp_path, *ENDLESS, "--workers", workers)
    run.wait_for(tmp_path / "a.h5.parts")
    time.sleep(0.5)
    check_end(run, how, saved("0", 3))
    assert os.listdir(tmp_path) == ["a.h5"]


def test_while_a_report_is_made(how: tuple[signal.Signals, int], tmp_path: Path) -> None:
    """It has a child process, and leaves no file."""
    # more configurations than could be finished before the signal comes
    run = Running(tmp_path, "report", "--media", "1000000")
    time.sleep(3)
    check_end(run, how)
    assert os.listdir(tmp_path) == []


def test_while_kernels_are_compiled(how: tuple[signal.Signals, int], tmp_path: Path) -> None:
    (tmp_path / "run").mkdir()
    cache = tmp_path / "cache"
    run = Running(tmp_path / "run", *SAVED, NUMBA_CACHE_DIR=str(cache))
    while not cache.exists():  # made when the first kernel is defined
        time.sleep(0.01)
    time.sleep(1.5)
    check_end(run, how, f"({saved('0', 1000000)})?")  # the file may be there or not


SWALLOWED = """
import signal, sys, time
import particles
from kinetics import cli

class Deaf:
    def __del__(self):
        print("deaf", flush=True)
        time.sleep(60)  # what is raised here, Python drops

def simulate(*_, **__):
    deaf = Deaf()
    del deaf
    time.sleep(60)

particles.simulate = simulate
sys.exit(cli.main())
"""


def test_an_exception_that_python_drops_ends_it_all_the_same(
    how: tuple[signal.Signals, int], tmp_path: Path
) -> None:
    run = Running(tmp_path, "simulate", code=SWALLOWED)
    wait_for_line(run)
    check_end(run, how)


def test_while_compiled_code_runs_in_the_main_thread(
    how: tuple[signal.Signals, int], tmp_path: Path
) -> None:
    """Python sees no signal before that code comes back."""
    code = """
import hashlib, sys
import particles
from kinetics import cli

def simulate(*_, **__):
    print("begun", flush=True)
    hashlib.pbkdf2_hmac("sha256", b"a", b"b", 2_000_000_000)

particles.simulate = simulate
sys.exit(cli.main())
"""
    run = Running(tmp_path, "simulate", code=code)
    wait_for_line(run)
    check_end(run, how)


def test_an_import_is_not_broken_off(tmp_path: Path) -> None:
    """Half a compiled module once ended a command with a segmentation fault."""
    (tmp_path / "slow.py").write_text(
        "import time\nprint('begun', flush=True)\ntime.sleep(0.5)\nopen('whole', 'w').close()\n"
    )
    code = """
import sys
sys.path.insert(0, "")
import particles
from kinetics import cli

def simulate(*_, **__):
    import slow, time
    time.sleep(60)

particles.simulate = simulate
sys.exit(cli.main())
"""
    run = Running(tmp_path, "simulate", code=code)
    assert run.process.stdout is not None
    run.process.stdout.readline()
    assert run.end(signal.SIGINT)[:2] == (130, "")
    assert "whole" in os.listdir(tmp_path)


def test_a_second_signal_does_not_disturb_the_first(tmp_path: Path) -> None:
    code = """
import os, signal, sys, time
import particles
from kinetics import cli

def simulate(*_, **__):
    try:
        print("begun", flush=True)
        time.sleep(60)
    finally:
        os.kill(os.getpid(), signal.SIGINT)
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(0.3)
        open("cleaned", "w").close()

particles.simulate = simulate
sys.exit(cli.main())
"""
    run = Running(tmp_path, "simulate", code=code)
    assert run.process.stdout is not None
    run.process.stdout.readline()
    assert run.end(signal.SIGINT)[:2] == (130, "")
    assert os.listdir(tmp_path) == ["cleaned"]


@pytest.mark.slow
@pytest.mark.parametrize("times", [3, pytest.param(100, marks=pytest.mark.slow)])
def test_at_random_moments(times: int, tmp_path: Path) -> None:
    chance = random.Random(5)
    for k in range(times):
        folder = tmp_path / str(k)
        folder.mkdir()
        run = Running(folder, *SAVED, "--workers", chance.choice("12"))
        run.wait_for(folder / "a.h5.parts")
        time.sleep(chance.uniform(0.0, 0.5))
        number, expected = chance.choice(SIGNALS)
        status, err, seconds = run.end(number)
        assert status == expected, k
        # it may have been ended before it had saved everything: then the parts are there
        assert re.fullmatch(f"({saved('[0-9]+', 1000000)})?", err), err
        assert seconds < 2.0
        assert set(os.listdir(folder)) <= {"a.h5", "a.h5.parts"}
        assert "a.h5" in os.listdir(folder)
