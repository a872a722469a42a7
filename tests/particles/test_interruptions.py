"""An exception raised at any moment, as by Ctrl-C, ends a run and leaves nothing waiting."""

import signal
import subprocess
import sys
import time

import pytest

from particles import Poisson

RUN = dict(medium=Poisson(0.1, 50), restitution=0.9, times=[1.0], tracers=1, seed=4)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such timer")
@pytest.mark.parametrize("times", [50, pytest.param(10_000, marks=pytest.mark.slow)])
def test_interrupted_at_random_moments(times: int) -> None:
    code = f"""
import faulthandler, random, signal
from particles import Poisson, simulate

def interrupt(*_):
    raise KeyboardInterrupt

run = dict(medium=Poisson(0.1, 50), restitution=0.9, times=[1.0], tracers=1, seed=4, workers=2)
simulate(**run, media=50)
signal.signal(signal.SIGALRM, interrupt)
chance = random.Random(3)
for _ in range({times}):
    faulthandler.dump_traceback_later(30, exit=True)
    try:
        signal.setitimer(signal.ITIMER_REAL, chance.uniform(0.002, 0.03))
        simulate(**run, media=1_000_000)
    except KeyboardInterrupt:
        print("interrupted")
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == "interrupted\n" * times


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such timer")
def test_a_configuration_that_never_ends_is_not_waited_for() -> None:
    code = """
from particles import Poisson, simulate
simulate(Poisson(0.1, 100), 1.0, times=[1.0], media=1, tracers=1, workers=1)
print("begun", flush=True)
simulate(Poisson(0.1, 100), 1.0, times=[1e12], media=1, tracers=50, workers=1)
"""
    process = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )  # fmt: skip
    assert process.stdout is not None
    process.stdout.readline()
    time.sleep(1)  # the kernels are there
    assert process.poll() is None
    began = time.monotonic()
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    assert time.monotonic() - began < 2.0
    assert err.rstrip().endswith("KeyboardInterrupt")
    assert process.returncode == -signal.SIGINT
