"""Cost against work: nodes, times, harmonics, wave numbers, scatterers, tracers; exponents."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from kinetics import Gaussian, Scene, solve, solve_scaled
from kinetics.crosscheck import references
from kinetics.crosscheck.bench import methods, straightforward
from kinetics.crosscheck.bench.measuring import Effort, Work, measure, sweep
from kinetics.crosscheck.bench.methods import CONSERVATIVE, PARTICLES, SPECTRAL, STRAIGHTFORWARD
from kinetics.crosscheck.bench.record import COST, Record
from particles import HardDisks, simulate

EXPONENT = ", exponent"
E = 0.7
# problem, method, setting, its values, those of the full benchmark beside them, what is timed
Sweep = tuple[str, str, str, tuple[int, ...], tuple[int, ...], Callable[[int], Any]]


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
    curves: dict[tuple[str, str, str], dict[float, float]] = {}
    for r in rows:
        done = curves.setdefault((r.problem, r.method, r.setting), {})
        if r.seconds and r.value:
            done[r.value] = r.seconds
    found = []
    for (problem, method, setting), done in curves.items():
        exponent = fitted_exponent(list(done), list(done.values()))
        note = f"run time ~ {setting}^{exponent:.2f} over the upper half"
        found.append(
            Record(COST, problem, method, f"{setting}{EXPONENT}", note=note,
                   extra={"exponent": exponent})
        )  # fmt: skip
    return found


def cost(effort: Effort) -> list[Record]:
    """All sweeps, at e = 0.7."""
    rows = measure(works([*solvers(), *displacements(), *_particles()], effort), effort)
    return rows + exponents(rows)


def works(sweeps: Sequence[Sweep], effort: Effort) -> list[Work]:
    """What is measured: the full benchmark goes on to more work."""
    return [
        work
        for problem, method, setting, values, more, solve in sweeps
        for work in sweep(
            COST, problem, method, setting, values if effort.quick else (*values, *more), solve
        )
    ]


def _solve(rtol: float, *outputs: str, times: Any, nodes: int | None = None, **scene: Any) -> Any:
    return solve(Scene(E, times=times, outputs=outputs, **scene), rtol, nodes=nodes)


def solvers() -> list[Sweep]:
    """Of the velocity: the two solvers and the straightforward one."""
    two = [10.0, 100.0]
    short = references.times("short")
    return [
        ("scaled h, a2", SPECTRAL, "nodes", (64, 128, 256, 512), (1024,),
         lambda n: solve_scaled(E, 1e-12, nodes=n).a2),
        ("speed density", SPECTRAL, "nodes", (128, 256, 512), (1024, 2048),
         lambda n: _solve(1e-8, "speed_density", times=two, nodes=n)),
        ("speed density", CONSERVATIVE, "nodes", (256, 512, 1024, 2048), (4096, 8192),
         lambda n: methods.conservative(E, "gaussian", np.array([100.0]), n)),
        ("v0(t), a2(t)", STRAIGHTFORWARD, "nodes", (101, 201, 401), (801,),
         lambda n: straightforward.solve_cooling(
             E, references.MEAN_FREE_PATH, "gaussian", short, n, 1e-4)),
        ("v0(t), a2(t)", SPECTRAL, "times", (10, 100, 1000), (10_000,),
         lambda n: _solve(1e-10, "thermal_speed", "a2", times=np.geomspace(1.0, 1e6, n))),
        ("v0(t), a2(t), spheres", SPECTRAL, "times", (10, 100, 1000), (10_000,),
         lambda n: _solve(1e-10, "thermal_speed", "a2", times=np.geomspace(1.0, 1e6, n),
                          dimension=3)),
        ("speed density", SPECTRAL, "times", (4, 16, 64), (256,),
         lambda n: _solve(1e-8, "speed_density", times=np.geomspace(1.0, 1e3, n))),
        # the odd harmonics are zero
        ("velocity density", SPECTRAL, "harmonics", (1, 2, 4), (8, 16),
         lambda n: _solve(1e-8, "velocity_density", times=two, initial=Gaussian(2.0, 1.0),
                          harmonics=2 * n)),
    ]  # fmt: skip


def displacements() -> list[Sweep]:
    """Of the displacement: its moments, G(R) and F(k)."""

    def moments(count: int) -> Any:
        return _solve(1e-10, "msd", "kurtosis", times=np.geomspace(1.0, 1e6, count))

    def density(count: int, **law: Any) -> Any:
        found = _solve(1e-3, "position_density", times=np.geomspace(100.0, 1e3, count), **law)
        return found.scaled_position_density(np.linspace(0.0, 6.0, 200))

    def scattering(count: int) -> Any:
        # wave lengths from a thousand mean free paths to half of one
        found = _solve(1e-4, "intermediate_scattering", times=[300.0])
        return found.intermediate_scattering(np.geomspace(5e-4, 1.0, count))

    return [
        ("<r^2>(t), kurtosis(t)", SPECTRAL, "times", (10, 100, 1000), (10_000,), moments),
        ("G(R)", SPECTRAL, "times", (1, 3, 9), (27, 81), density),
        ("G(R), spheres", SPECTRAL, "times", (1, 3, 9), (27, 81),
         lambda n: density(n, dimension=3)),
        ("F(k)", SPECTRAL, "wave numbers", (4, 16, 64), (256,), scattering),
    ]  # fmt: skip


def _particles() -> list[Sweep]:
    def run(scatterers: int, tracers: int, collisions: int) -> Any:
        return simulate(HardDisks(0.04, count=scatterers), 0.9, max_collisions=collisions, media=1,
                        tracers=tracers, workers=1)  # fmt: skip

    sizes = (1000, 10_000, 100_000)
    return [
        ("placing hard disks, 0.04 per d^2", PARTICLES, "scatterers", sizes, (1_000_000,),
         lambda n: run(n, 1, 1)),
        ("300 collisions of 1000 tracers", PARTICLES, "scatterers", sizes, (1_000_000,),
         lambda n: run(n, 1000, 300)),
        ("300 collisions of each tracer", PARTICLES, "tracers", (100, 1000, 10_000), (100_000,),
         lambda n: run(10_000, n, 300)),
    ]  # fmt: skip
