"""Kills runs at random moments and resumes them, until so many were killed:

    python tests/particles/storage/kill_runs.py FOLDER KILLS SEED

prints as JSON how many were killed, how many of them before their file was there, how many runs
came to their end, and what went wrong. Half of the kills come within a second of the start, and
a quarter within 30 ms.
"""

import json
import os
import random
import signal
import sys
import time
from pathlib import Path

from particles import Ensemble, Poisson, simulate

RUN = dict(
    medium=Poisson(0.1, 200), restitution=0.9, times=[1.0, 1e4], media=6000, tracers=1, seed=4,
    workers=2, observables=["displacement_histogram", "finals"],
)  # fmt: skip


def start(path: Path) -> int:
    """Start a run in a process of its own, or go on with it; return its number."""
    process = os.fork()
    if process:
        return process
    try:
        try:
            simulate(**RUN, output=path)
        except ValueError as error:
            if "exists" not in str(error):
                raise
            simulate(**RUN, output=path, resume=True)
        os._exit(0)
    except BaseException as error:
        print(repr(error), file=sys.stderr, flush=True)
    os._exit(9)


def moment(chance: random.Random) -> float:
    """Return how long a run is left alone, in seconds."""
    longest = chance.choice((0.005, 0.03, 0.3, 1.0, 3.0, 3.0, 3.0, 3.0))
    return chance.uniform(0.0, longest)


def contents(run: Ensemble) -> dict[str, bytes]:
    return {name: array.tobytes() for name, array in run.arrays.items()}


def main(folder: Path, kills: int, seed: int) -> None:
    expected = contents(simulate(**RUN))
    chance = random.Random(seed)
    killed = without_file = finished = 0
    wrong: list[str] = []
    while killed < kills or any(folder.iterdir()):
        path = folder / f"{finished}.h5"
        process = start(path)
        if killed < kills:
            time.sleep(moment(chance))
            os.kill(process, signal.SIGKILL)
        status = os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])
        if status == -signal.SIGKILL:
            killed += 1
            without_file += not path.exists()
            continue
        finished += 1
        left = sorted(p.name for p in folder.iterdir())
        if status or left != [path.name]:
            wrong.append(f"status {status}, left {left}")
        elif contents(Ensemble.load(path)) != expected:
            wrong.append(f"other bits in {path.name}")
        for file in folder.iterdir():
            file.unlink()
    done = dict(killed=killed, without_file=without_file, finished=finished, wrong=wrong)
    print(json.dumps(done))


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))
