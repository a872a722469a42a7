"""lorentz after Ctrl-C and SIGTERM: it ends within two seconds."""

import os
import random
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGINT to send")

SIGNALS = {signal.SIGINT: 130, signal.SIGTERM: 143}
SAVED = (
    "simulate", "--count", "400", "--media", "1000000", "--tracers", "5", "-e", "0.9",
    "--times", "1,1000", "--observables", "free_path_histogram", "-o", "a.h5",
)  # fmt: skip
# one configuration takes longer than anybody waits
ENDLESS = (
    "simulate", "--count", "400", "-e", "1", "--media", "3", "--tracers", "100",
    "--times", "1,1e12", "-o", "a.h5",
)  # fmt: skip
KEPT = r"(lorentz: [0-9]+ of [0-9]+ configurations are saved in a\.h5; .* --resume .*)?"
BEGIN = "import sys, time\nimport particles\nfrom kinetics import cli\n\ndef simulate(*_, **__):\n"
END = "\nparticles.simulate = simulate\nsys.exit(cli.main())\n"
SWALLOWS = """    print('begun', flush=True)
    while True:
        try:
            time.sleep(60)
        except BaseException:
            pass"""
FINALISER = """    class Slow:
        def __del__(self):
            print('begun', flush=True)
            time.sleep(0.4)
    Slow() and time.sleep(60)"""


def start(*arguments: str, code: str = "", **environment: str) -> "subprocess.Popen[str]":
    program = ["-c", code] if code else ["-m", "kinetics.cli"]
    return subprocess.Popen(
        [sys.executable, *program, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        text=True, env=os.environ | environment,
        # a shell that runs the tests in the background makes them, and children, ignore it
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )  # fmt: skip


#: Seconds in which a process ends once it has the signal, on a busy machine too: the runs that are
#: interrupted take minutes.
MAX_SECONDS_TO_END = 20.0


def end(process: "subprocess.Popen[str]", number: signal.Signals, said: str = "") -> None:
    """Send the signal: it ends soon, with its status, and says only what is saved."""
    assert process.poll() is None, process.communicate()
    began = time.monotonic()
    process.send_signal(number)
    _, err = process.communicate(timeout=60)
    assert time.monotonic() - began < MAX_SECONDS_TO_END
    assert process.returncode == SIGNALS[number]
    assert re.fullmatch(said, err.strip()), err


def wait_for(process: "subprocess.Popen[str]", path: str) -> None:
    while process.poll() is None and not (Path(path).exists() and Path(path).stat().st_size > 60):
        time.sleep(0.01)


@pytest.fixture(autouse=True)
def _in_a_folder_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("number", SIGNALS)
def test_while_tracers_are_followed_for_hours(number: signal.Signals) -> None:
    process = start(*ENDLESS)
    wait_for(process, "a.h5")
    time.sleep(0.5)
    end(process, number, KEPT[:-1])  # it is said
    assert "a.h5" in os.listdir()


@pytest.mark.parametrize("work", [SWALLOWS, FINALISER])
def test_in_code_that_swallows_it(work: str) -> None:
    process = start("simulate", code=f"{BEGIN}{work}{END}")
    assert process.stdout is not None
    process.stdout.readline()
    time.sleep(0.2)
    end(process, signal.SIGINT)


def test_an_import_is_not_broken_off_and_a_second_signal_changes_nothing() -> None:
    """Half a compiled module once ended a command with a segmentation fault."""
    Path("slow.py").write_text(
        "import time\nprint('begun', flush=True)\ntime.sleep(0.5)\nopen('whole', 'w').close()\n"
    )
    work = (
        "    import os, signal\n    sys.path.insert(0, '')\n    try:\n        import slow\n"
        "        time.sleep(60)\n    finally:\n        os.kill(os.getpid(), signal.SIGTERM)\n"
        "        os.kill(os.getpid(), signal.SIGINT)\n        open('cleaned', 'w').close()"
    )
    process = start("simulate", code=f"{BEGIN}{work}{END}")
    assert process.stdout is not None
    process.stdout.readline()
    end(process, signal.SIGINT)
    assert {"whole", "cleaned"} <= set(os.listdir())


def test_a_stability_sweep_writes_what_has_been_run() -> None:
    process = start("stress", "-o", "out")  # of minutes, on any machine
    time.sleep(2.5)
    end(process, signal.SIGTERM, "(lorentz: interrupted: [0-9]+ cases were not run)?")


@pytest.mark.slow
def test_while_a_report_is_made() -> None:
    """It has a child process, and leaves no file."""
    # more configurations than could be finished before the signal comes
    process = start("report", "--media", "1000000")
    time.sleep(3)
    end(process, signal.SIGINT)
    assert os.listdir() == []


@pytest.mark.slow
def test_at_two_hundred_random_moments() -> None:
    chance = random.Random(5)
    for k in range(200):
        os.mkdir(str(k))
        os.chdir(str(k))
        process = start(*SAVED, "--workers", chance.choice("12"))
        wait_for(process, "a.h5")
        time.sleep(chance.uniform(0.0, 0.5))
        end(process, chance.choice(list(SIGNALS)), KEPT)
        assert "a.h5" in os.listdir()
        os.chdir("..")
