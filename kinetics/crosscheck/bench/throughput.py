"""Collisions per second of the particles, and how their error falls with time."""

from __future__ import annotations

from typing import Any

import numpy as np

from kinetics.crosscheck.bench.record import Record, failed, not_available, timed
from kinetics.crosscheck.bench.timing import Effort, measure

SECTION = "particles"
YEAR = 365.25 * 86400.0
RESTITUTION = 0.9


def _media(effort: Effort) -> list[tuple[str, Any]]:
    from particles import BoltzmannGrad, HardDisks, Poisson

    dense = (0.005, 0.04, 0.2, 0.5) if effort.quick else (0.001, 0.005, 0.02, 0.04, 0.1, 0.3, 0.6)
    counts = (1000, 40_000) if effort.quick else (1000, 10_000, 40_000, 160_000, 640_000)
    media: list[tuple[str, Any]] = [
        (f"hard disks, {rho:g} per d^2, 10000", HardDisks(rho, count=10_000)) for rho in dense
    ]
    media += [(f"hard disks, 0.04 per d^2, {n}", HardDisks(0.04, count=n)) for n in counts]
    media += [
        (f"overlapping disks, {rho:g} per d^2, 10000", Poisson(rho, count=10_000))
        for rho in ((0.04,) if effort.quick else (0.005, 0.04, 0.2))
    ]
    return [*media, ("Boltzmann-Grad, 0.04 per d^2", BoltzmannGrad(0.04))]


def throughput(effort: Effort) -> list[Record]:
    """Rows with collisions/s in `extra`, of one and of two threads."""
    rows = []
    tracers = 400 if effort.quick else 2000
    for name, medium in _media(effort):
        for threads in (1, 2):
            rows.append(_rate(name, medium, tracers, threads, effort))
    rows.append(
        not_available(SECTION, "side of the cells", "particles", "the side is not exposed: it is "
                      "chosen so that a cell lists 5 scatterers on average")
    )  # fmt: skip
    return rows


def _rate(name: str, medium: Any, tracers: int, threads: int, effort: Effort) -> Record:
    """Collisions/s without the time to place the scatterers, which stands beside."""
    from particles import simulate

    def run(count: int, collisions: int) -> Any:
        return simulate(
            medium, RESTITUTION, max_collisions=collisions, media=4, tracers=count, workers=threads
        )

    try:
        _, placing = measure(lambda: run(1, 1), effort)
        ensemble, timing = measure(lambda: run(tracers, 500), effort)
    except ValueError as met:
        return failed(SECTION, name, "particles", str(met), threads=threads)
    clock = "cpu" if threads == 1 else "wall"
    whole, before = getattr(timing, clock), getattr(placing, clock)
    moving = max(whole.median - before.median, 1e-9)
    return timed(
        SECTION, name, "particles", timing, threads=threads,
        extra={
            "collisions": ensemble.collision_total,
            "collisions_per_second": ensemble.collision_total / moving,
            "placing_seconds_per_medium": placing.cpu.median / 4,
        },
    )  # fmt: skip


def monte_carlo_need(rows: list[Record], target: float = 1e-10) -> dict[str, float]:
    """Samples and years of one processor for a relative error, from measured Monte Carlo rows.

    The value of a row is its samples; error = a/sqrt(samples), a the geometric mean over the rows,
    and the time per sample is that of the row with most samples. "slope" is the fitted exponent of
    the error. NaN without rows.
    """
    good = [(r.value, r.error, r.seconds) for r in rows if r.value and r.error and r.seconds]
    if not good:
        return {"samples": float("nan"), "years": float("nan"), "slope": float("nan")}
    samples, errors, seconds = np.array(sorted(good)).T
    a = float(np.exp(np.mean(np.log(errors * np.sqrt(samples)))))
    need = (a / target) ** 2
    slope = float("nan")
    if samples.size > 1:
        slope = float(np.polyfit(np.log(samples), np.log(errors), 1)[0])
    return {"samples": need, "years": need * seconds[-1] / samples[-1] / YEAR, "slope": slope}
