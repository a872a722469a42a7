"""Measure what the constants of the kernel rest on: run this file with a constant's name.

    python tests/particles/measurements/kernel_speed.py LANES     # of particles.kernel.lane
    python tests/particles/measurements/kernel_speed.py LISTED    # of particles.cells

Each value runs in a process of its own, compiled anew, in turns with the others; the figure is the
best of its turns, in collisions per second of one thread, of 40,000 hard disks at density 0.04.
NUMBA_CPU_NAME and NUMBA_CPU_FEATURES choose another processor for the compiler.
"""

import os
import subprocess
import sys
from tempfile import mkdtemp

CASES = {
    "LANES": [f"import particles.kernel.lane as m; m.LANES = {n}" for n in (4, 8, 16, 32, 64)],
    "LISTED": [f"import particles.cells as m; m.LISTED = {n}" for n in (2.5, 3.5, 5.0, 7.0, 10.0)],
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
for _ in sys.stdin:
    placing, (total, whole) = run(1, 1)[1], run(1000, 500)
    print(total / (whole - placing), flush=True)
"""

if __name__ == "__main__":
    processes = {}
    for change in CASES[sys.argv[1]]:
        # A value is not part of the cache's key: each has a folder of its own.
        environment = os.environ | {"NUMBA_CACHE_DIR": mkdtemp()}
        processes[change] = subprocess.Popen(
            [sys.executable, "-W", "ignore", "-c", PROGRAM.format(change=change)],
            env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )  # fmt: skip
    best = dict.fromkeys(processes, 0.0)
    for _ in range(12):
        for change, process in processes.items():
            process.stdin.write("\n")
            process.stdin.flush()
            best[change] = max(best[change], float(process.stdout.readline()))
    for change, process in processes.items():
        process.communicate()
        print(f"{change.split('m.')[-1]}: {best[change]:.3g} collisions/s")
