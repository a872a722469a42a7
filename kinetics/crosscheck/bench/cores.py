"""One core and two: the same work in a process of one thread, and in one of two.

The number of threads of the linear algebra is fixed when it is loaded; the worker process is
started with it (see :mod:`kinetics.crosscheck.bench.run`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from kinetics.crosscheck.bench import references, straightforward
from kinetics.crosscheck.bench.methods import CONSERVATIVE, SPECTRAL, STRAIGHTFORWARD
from kinetics.crosscheck.bench.record import Record, failed, timed
from kinetics.crosscheck.bench.timing import Effort, measure_together

SECTION = "cores"


def cores(effort: Effort, threads: int = 1) -> list[Record]:
    """Rows of one number of threads; wall-clock time, which is what a second core can save."""
    rows = []
    for key, timing in measure_together(_works(threads, effort), effort).items():
        if isinstance(timing, Exception):
            rows.append(failed(SECTION, *key, str(timing), threads=threads))
            continue
        row = timed(SECTION, *key, timing, threads=2)
        rows.append(replace(row, threads=threads))
    return rows


def _works(threads: int, effort: Effort) -> dict[tuple[str, str], Callable[[], Any]]:
    from kinetics import Scene, solve, solve_scaled
    from particles import BoltzmannGrad, HardDisks, simulate

    times = references.times("short")
    nodes = 201 if effort.quick else 801
    tracers = 500 if effort.quick else 5000

    def run(medium: Any) -> Callable[[], Any]:
        return lambda: simulate(
            medium, 0.9, max_collisions=300, media=8, tracers=tracers, workers=threads
        )

    def of(*outputs: str, **options: Any) -> Callable[[], Any]:
        scene = Scene(0.7, times=times, outputs=outputs)
        return lambda: solve(scene, 1e-8, **options)

    return {
        ("scaled h and a2", SPECTRAL): lambda: solve_scaled(0.7).a2,
        ("v0(t), a2(t)", SPECTRAL): of("thermal_speed", "a2"),
        ("speed density, 25 times", SPECTRAL): of("speed_density"),
        ("speed density, 25 times, 2048 nodes", CONSERVATIVE): of(
            "speed_density", method="conservative", nodes=2048
        ),
        (f"v0(t), a2(t), {nodes} nodes", STRAIGHTFORWARD): lambda: straightforward.solve_cooling(
            0.7, references.MEAN_FREE_PATH, "gaussian", times, nodes, 1e-5
        ),
        ("hard disks, 8 media", "particles"): run(HardDisks(0.04, count=10_000)),
        ("Boltzmann-Grad, 8 blocks", "particles"): run(BoltzmannGrad(0.04)),
    }
