"""Collisions per second of the particles."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from typing import Any

from kinetics.crosscheck.bench.measuring import Effort, Work, measure
from kinetics.crosscheck.bench.record import FAILED, PARTICLES, Record
from particles import BoltzmannGrad, HardDisks, HardSpheres, Poisson, PoissonSpheres, simulate

RESTITUTION = 0.9
SPHERES = 0.1 / math.pi  # per d^3: l = 10 d
_MEDIA = 4  # of each run


def media(effort: Effort) -> list[tuple[str, Any]]:
    """Those that are measured, by name."""
    dense = (0.005, 0.04, 0.2, 0.5) if effort.quick else (0.001, 0.005, 0.02, 0.04, 0.1, 0.3, 0.6)
    counts = (1000, 40_000, *(() if effort.quick else (160_000, 640_000)))
    overlapping = (0.04,) if effort.quick else (0.005, 0.04, 0.2)
    return [
        *((f"hard disks, {rho:g} per d^2, 10000", HardDisks(rho, count=10_000)) for rho in dense),
        *((f"hard disks, 0.04 per d^2, {n}", HardDisks(0.04, count=n)) for n in counts),
        *(
            (f"overlapping disks, {rho:g} per d^2, 10000", Poisson(rho, count=10_000))
            for rho in overlapping
        ),
        ("Boltzmann-Grad, 0.04 per d^2", BoltzmannGrad(0.04)),
        *(
            (f"hard spheres, {rho:.2g} per d^3, 10000", HardSpheres(rho, count=10_000))
            for rho in (SPHERES, 0.2)[: 1 if effort.quick else None]
        ),
        (
            f"overlapping spheres, {SPHERES:.2g} per d^3, 10000",
            PoissonSpheres(SPHERES, count=10_000),
        ),
        (f"Boltzmann-Grad, {SPHERES:.2g} per d^3", BoltzmannGrad(SPHERES, dimension=3)),
    ]


def throughput(effort: Effort) -> list[Record]:
    """Rows with collisions/s in `extra`, of one and of two threads."""
    tracers = 300 if effort.quick else 2000
    works = []
    for name, medium in media(effort):
        for threads in (1, 2):
            works += _runs(name, medium, tracers, threads)
    rows = measure(works, effort)
    return [_rate(*pair) for pair in zip(rows[::2], rows[1::2], strict=True)]


def _runs(name: str, medium: Any, tracers: int, threads: int) -> list[Work]:
    """A run of one collision, whose time is that of placing the scatterers, and a long one."""

    def work(tracers: int, collisions: int) -> Work:
        run = partial(simulate, medium, RESTITUTION, max_collisions=collisions, media=_MEDIA,
                      tracers=tracers, workers=threads)  # fmt: skip
        return Work(PARTICLES, name, PARTICLES, run, threads=threads, figures=_collisions)

    return [work(1, 1), work(tracers, 500)]


def _collisions(ensemble: Any) -> dict[str, Any]:
    return {"collisions": ensemble.collision_total}


def _rate(placing: Record, whole: Record) -> Record:
    """The row of a long run: collisions/s without the time that placing the scatterers takes."""
    if placing.seconds is None or whole.seconds is None:
        return replace(whole, status=FAILED, note=placing.note or whole.note)
    moving = max(whole.seconds - placing.seconds, 1e-9)
    rate = {
        "collisions_per_second": whole.extra["collisions"] / moving,
        "placing_seconds_per_medium": placing.seconds / _MEDIA,
    }
    return replace(whole, extra=whole.extra | rate)
