"""Cost against work: nodes, times, harmonics, wave numbers, scatterers, tracers; exponents."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from kinetics.crosscheck import references
from kinetics.crosscheck.bench import methods, straightforward
from kinetics.crosscheck.bench.methods import CONSERVATIVE, PARTICLES, SPECTRAL, STRAIGHTFORWARD
from kinetics.crosscheck.bench.record import COST, Record
from kinetics.crosscheck.bench.sweeps import Sweep, run_sweeps
from kinetics.crosscheck.bench.timing import Effort

EXPONENT = ", exponent"
E = 0.7


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
        here = [r for r in rows if (r.problem, r.method, r.setting) == key]
        done = [(r.value, r.seconds) for r in here if r.seconds and r.value]
        problem, method, setting = key
        exponent = fitted_exponent([x for x, _ in done], [y for _, y in done])
        note = f"run time ~ {setting}^{exponent:.2f} over the upper half"
        found.append(
            Record(COST, problem, method, f"{setting}{EXPONENT}", note=note,
                   extra={"exponent": exponent})
        )  # fmt: skip
    return found


def cost(effort: Effort) -> list[Record]:
    """All sweeps, at e = 0.7."""
    rows = run_sweeps([*solvers(effort), *displacements(effort), *_particles(effort)], effort)
    return rows + exponents(rows)


def _amounts(effort: Effort, *amounts: int, full: Sequence[int] = ()) -> tuple[int, ...]:
    """Amounts of work; the full benchmark has some more."""
    return amounts if effort.quick else (*amounts, *full)


def _solve(rtol: float, *outputs: str, times: Any, nodes: int | None = None, **scene: Any) -> Any:
    from kinetics import Scene, solve

    return solve(Scene(E, times=times, outputs=outputs, **scene), rtol, nodes=nodes)


def solvers(effort: Effort) -> list[Sweep]:
    """Of the velocity: the two solvers and the straightforward one."""
    from kinetics import Gaussian, solve_scaled

    two = [10.0, 100.0]
    short = references.times("short")

    def of(problem: str, method: str, setting: str, amounts: Any, work: Callable[..., Any]) -> Any:
        return Sweep(COST, problem, method, setting, amounts, work)

    return [
        of("scaled h, a2", SPECTRAL, "nodes", _amounts(effort, 64, 128, 256, 512, full=(1024,)),
           lambda n: solve_scaled(E, 1e-12, nodes=n).a2),
        of("speed density", SPECTRAL, "nodes", _amounts(effort, 128, 256, 512, full=(1024, 2048)),
           lambda n: _solve(1e-8, "speed_density", times=two, nodes=n)),
        of("speed density", CONSERVATIVE, "nodes",
           _amounts(effort, 256, 512, 1024, 2048, full=(4096, 8192)),
           lambda n: methods.conservative(E, "gaussian", np.array([100.0]), n)),
        of("v0(t), a2(t)", STRAIGHTFORWARD, "nodes", _amounts(effort, 101, 201, 401, full=(801,)),
           lambda n: straightforward.solve_cooling(
               E, references.MEAN_FREE_PATH, "gaussian", short, n, 1e-4)),
        of("v0(t), a2(t)", SPECTRAL, "times", _amounts(effort, 10, 100, 1000, full=(10_000,)),
           lambda n: _solve(1e-10, "thermal_speed", "a2", times=np.geomspace(1.0, 1e6, n))),
        of("speed density", SPECTRAL, "times", _amounts(effort, 4, 16, 64, full=(256,)),
           lambda n: _solve(1e-8, "speed_density", times=np.geomspace(1.0, 1e3, n))),
        # the odd harmonics are zero
        of("velocity density", SPECTRAL, "harmonics", _amounts(effort, 1, 2, 4, full=(8, 16)),
           lambda n: _solve(1e-8, "velocity_density", times=two, initial=Gaussian(2.0, 1.0),
                            harmonics=2 * n)),
    ]  # fmt: skip


def displacements(effort: Effort) -> list[Sweep]:
    """Of the displacement: its moments, G(R) and F(k)."""

    def moments(count: int) -> Any:
        return _solve(1e-10, "msd", "kurtosis", times=np.geomspace(1.0, 1e6, count))

    def density(count: int) -> Any:
        found = _solve(1e-3, "position_density", times=np.geomspace(100.0, 1e3, count))
        return found.scaled_position_density(np.linspace(0.0, 6.0, 200))

    def scattering(count: int) -> Any:
        # wave lengths from a thousand mean free paths to half of one
        found = _solve(1e-4, "intermediate_scattering", times=[300.0])
        return found.intermediate_scattering(np.geomspace(5e-4, 1.0, count))

    return [
        Sweep(COST, "<r^2>(t), kurtosis(t)", SPECTRAL, "times",
              _amounts(effort, 10, 100, 1000, full=(10_000,)), moments),
        Sweep(COST, "G(R)", SPECTRAL, "times", _amounts(effort, 1, 3, 9, full=(27, 81)), density),
        Sweep(COST, "F(k)", SPECTRAL, "wave numbers", _amounts(effort, 4, 16, 64, full=(256,)),
              scattering),
    ]  # fmt: skip


def _particles(effort: Effort) -> list[Sweep]:
    from particles import HardDisks, simulate

    def run(scatterers: int, tracers: int, collisions: int) -> Any:
        return simulate(HardDisks(0.04, count=scatterers), 0.9, max_collisions=collisions, media=1,
                        tracers=tracers, workers=1)  # fmt: skip

    sizes = _amounts(effort, 1000, 10_000, 100_000, full=(1_000_000,))
    return [
        Sweep(COST, "placing hard disks, 0.04 per d^2", PARTICLES, "scatterers", sizes,
              lambda n: run(n, 1, 1)),
        Sweep(COST, "300 collisions of 1000 tracers", PARTICLES, "scatterers", sizes,
              lambda n: run(n, 1000, 300)),
        Sweep(COST, "300 collisions of each tracer", PARTICLES, "tracers",
              _amounts(effort, 100, 1000, 10_000, full=(100_000,)),
              lambda n: run(10_000, n, 300)),
    ]  # fmt: skip
