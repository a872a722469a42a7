"""Cost against work: nodes, times, harmonics, wave numbers, scatterers, tracers; exponents."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from kinetics.crosscheck.bench import methods, references, straightforward
from kinetics.crosscheck.bench.methods import CONSERVATIVE, SPECTRAL, STRAIGHTFORWARD
from kinetics.crosscheck.bench.record import Record
from kinetics.crosscheck.bench.sweeps import Sweep, run_sweeps
from kinetics.crosscheck.bench.timing import Effort

SECTION = "cost"
PARTICLES = "particles"
EXPONENT = ", exponent"
_of = partial(Sweep, SECTION)  # a row per amount of work


def fitted_exponent(work: Sequence[float], seconds: Sequence[float]) -> float:
    """q of seconds ~ work^q, least squares in the logarithms over the upper half of the work.

    Below, what does not grow with the work hides it. At least three points; NaN with fewer.
    """
    if len(work) < 3:
        return float("nan")
    keep = max(3, (len(work) + 1) // 2)
    order = np.argsort(work)[-keep:]
    x = np.log(np.asarray(work, dtype=float)[order])
    y = np.log(np.asarray(seconds, dtype=float)[order])
    return float(np.polyfit(x, y, 1)[0])


def exponents(rows: Sequence[Record]) -> list[Record]:
    """A row for each curve, with the exponent in `extra`."""
    found = []
    for key in dict.fromkeys((r.problem, r.method, r.setting) for r in rows):
        done = [
            (r.value, r.seconds)
            for r in rows
            if (r.problem, r.method, r.setting) == key and r.seconds and r.value
        ]
        problem, method, setting = key
        exponent = fitted_exponent([x for x, _ in done], [y for _, y in done])
        note = f"run time ~ {setting}^{exponent:.2f} over the upper half"
        found.append(
            Record(SECTION, problem, method, f"{setting}{EXPONENT}", note=note,
                   extra={"exponent": exponent})
        )  # fmt: skip
    return found


def cost(effort: Effort) -> list[Record]:
    """All sweeps, at e = 0.7."""
    sweeps = [*_solvers(effort), *_position(effort), *_particles(effort)]
    rows = run_sweeps(sweeps, effort)
    return rows + exponents(rows)


def _solvers(effort: Effort) -> list[Sweep]:
    from kinetics import Gaussian, Scene, solve, solve_scaled

    e, l = 0.7, references.MEAN_FREE_PATH  # noqa: E741
    big = not effort.quick

    def averages(count: int) -> Any:
        times = np.geomspace(1.0, 1e6, count)
        return solve(Scene(e, times=times, outputs=("thermal_speed", "a2")), 1e-10)

    def density(count: int) -> Any:
        times = np.geomspace(1.0, 1e3, count)
        return solve(Scene(e, times=times, outputs=("speed_density",)), 1e-8)

    def density_nodes(nodes: int) -> Any:
        scene = Scene(e, times=[10.0, 100.0], outputs=("speed_density",))
        return solve(scene, 1e-8, nodes=nodes)

    def harmonics(count: int) -> Any:
        scene = Scene(
            e, initial=Gaussian(2.0, 1.0), times=[10.0, 100.0], outputs=("velocity_density",),
            harmonics=2 * count,  # the odd ones are zero
        )  # fmt: skip
        return solve(scene, 1e-8)

    def masses(nodes: int) -> Any:
        return methods.conservative(e, "gaussian", np.array([100.0]), nodes)

    def dense(nodes: int) -> Any:
        times = references.times("short")
        return straightforward.solve_cooling(e, l, "gaussian", times, nodes, 1e-4)

    return [
        _of("scaled h, a2", SPECTRAL, "nodes", (64, 128, 256, 512, *((1024,) if big else ())),
              lambda n: solve_scaled(e, 1e-12, nodes=n).a2),
        _of("speed density", SPECTRAL, "nodes", (128, 256, 512, *((1024, 2048) if big else ())),
              density_nodes),
        _of("speed density", CONSERVATIVE, "nodes",
              (256, 512, 1024, 2048, *((4096, 8192) if big else ())), masses),
        _of("v0(t), a2(t)", STRAIGHTFORWARD, "nodes", (101, 201, 401, *((801,) if big else ())),
              dense),
        _of("v0(t), a2(t)", SPECTRAL, "times", (10, 100, 1000, *((10_000,) if big else ())),
              averages),
        _of("speed density", SPECTRAL, "times", (4, 16, 64, *((256,) if big else ())),
              density),
        _of("velocity density", SPECTRAL, "harmonics", (1, 2, 4, *((8, 16) if big else ())),
              harmonics),
    ]  # fmt: skip


def _position(effort: Effort) -> list[Sweep]:
    from kinetics import Scene, solve

    e = 0.7
    big = not effort.quick

    def moments(count: int) -> Any:
        times = np.geomspace(1.0, 1e6, count)
        return solve(Scene(e, times=times, outputs=("msd", "kurtosis")), 1e-10)

    def density(count: int) -> Any:
        times = np.geomspace(100.0, 1e3, count)
        scene = Scene(e, times=times, outputs=("position_density",))
        return solve(scene, 1e-3).scaled_position_density(np.linspace(0.0, 6.0, 200))

    def scattering(count: int) -> Any:
        # wave lengths from a thousand mean free paths to half of one
        wave_numbers = np.geomspace(5e-4, 1.0, count)
        scene = Scene(e, times=[300.0], outputs=("intermediate_scattering",))
        return solve(scene, 1e-4).intermediate_scattering(wave_numbers)

    return [
        _of("<r^2>(t), kurtosis(t)", SPECTRAL, "times",
              (10, 100, 1000, *((10_000,) if big else ())), moments),
        _of("G(R)", SPECTRAL, "times", (1, 3, 9, *((27, 81) if big else ())), density),
        _of("F(k)", SPECTRAL, "wave numbers", (4, 16, 64, *((256,) if big else ())),
              scattering),
    ]  # fmt: skip


def _particles(effort: Effort) -> list[Sweep]:
    from particles import HardDisks, simulate

    big = not effort.quick

    def scatterers(count: int) -> Any:
        return simulate(HardDisks(0.04, count=count), 0.9, max_collisions=1, media=1, tracers=1,
                        workers=1)  # fmt: skip

    def crossed(count: int) -> Any:
        return simulate(HardDisks(0.04, count=count), 0.9, max_collisions=300, media=1,
                        tracers=1000, workers=1)  # fmt: skip

    def tracers(count: int) -> Any:
        return simulate(HardDisks(0.04, count=10_000), 0.9, max_collisions=300, media=1,
                        tracers=count, workers=1)  # fmt: skip

    sizes = (1000, 10_000, 100_000, *((1_000_000,) if big else ()))
    return [
        _of("placing hard disks, 0.04 per d^2", PARTICLES, "scatterers", sizes, scatterers),
        _of("300 collisions of 1000 tracers", PARTICLES, "scatterers", sizes, crossed),
        _of("300 collisions of each tracer", PARTICLES, "tracers",
              (100, 1000, 10_000, *((100_000,) if big else ())), tracers),
    ]  # fmt: skip
