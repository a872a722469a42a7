"""An exception raised at any moment, as by Ctrl-C, ends a run and leaves nothing waiting."""

import subprocess
import sys

import pytest


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such timer")
@pytest.mark.parametrize("times", [20, pytest.param(10_000, marks=pytest.mark.slow)])
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
