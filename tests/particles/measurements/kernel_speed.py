"""Measure what the constants of the kernel rest on: run this file with a constant's name.

    python tests/particles/measurements/kernel_speed.py vectors   # the search: vectors and loop
    python tests/particles/measurements/kernel_speed.py lanes     # LANES of particles.kernel.lane
    python tests/particles/measurements/kernel_speed.py listed    # LISTED of particles.media

Each value runs in a process of its own, compiled anew, in turns with the others; the figure is the
best of its turns, in collisions per second of one thread, of 40,000 hard disks at density 0.04.
NUMBA_CPU_NAME and NUMBA_CPU_FEATURES choose another processor for the compiler.
"""

import os
import subprocess
import sys
from tempfile import mkdtemp

CASES = {
    "vectors": {
        "vectors": "",
        "loop": "sys.modules['particles.compiled.vectors'] = None",
    },
    "lanes": {
        str(n): f"import particles.kernel.lane as m; m.LANES = {n}" for n in (4, 8, 16, 32, 64)
    },
    "listed": {
        str(n): f"import particles.media as m; m._Random.listed = {n}"
        for n in (2.5, 3.5, 5.0, 7.0, 10.0)
    },
}
PROGRAM = """
import sys, time
{change}
from particles import HardDisks, simulate
def run(tracers, collisions):
    begun = time.process_time()
    ensemble = simulate(
        HardDisks(0.04, 40_000), 0.9, media=1, tracers=tracers, max_collisions=collisions, workers=1
    )
    return ensemble.collision_total, time.process_time() - begun
run(1, 1)
print("ready", flush=True)
for _ in sys.stdin:
    placing, (total, whole) = run(1, 1)[1], run(1000, 500)
    print(total / (whole - placing), flush=True)
"""


def measure(name: str, turns: int = 12) -> dict[str, float]:
    """Return the best rate of each value of a constant."""
    processes = {}
    for value, change in CASES[name].items():
        # A value is not part of the cache's key: each has a folder of its own.
        environment = os.environ | {"NUMBA_CACHE_DIR": mkdtemp()}
        processes[value] = subprocess.Popen(
            [sys.executable, "-W", "ignore", "-c", PROGRAM.format(change=change)],
            env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )  # fmt: skip
    best = dict.fromkeys(processes, 0.0)
    for turn in range(turns + 1):
        for value, process in processes.items():
            assert process.stdin is not None
            assert process.stdout is not None
            if turn:
                process.stdin.write("\n")
                process.stdin.flush()
                best[value] = max(best[value], float(process.stdout.readline()))
            else:
                process.stdout.readline()
    for process in processes.values():
        process.communicate()
    return best


if __name__ == "__main__":
    for value, rate in measure(sys.argv[1]).items():
        print(f"{sys.argv[1]} {value}: {rate:.3g} collisions/s")
