"""Collisions per second of the particles."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

from kinetics.crosscheck.bench.record import PARTICLES, Record, failed, timed
from kinetics.crosscheck.bench.timing import Effort, Timing, measure_together

RESTITUTION = 0.9
LISTED = "listed per cell"
CELL_DENSITIES = (0.04, 0.2)


def media(effort: Effort) -> list[tuple[str, Any]]:
    """Those that are measured, by name."""
    from particles import BoltzmannGrad, HardDisks, Poisson

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
    ]


def cells(effort: Effort) -> list[tuple[str, float, Any]]:
    """Hard disks in cells that list so many of them on average; see `particles.media.LISTED`."""
    from particles import HardDisks

    listed = (1.5, 5.0, 15.0) if effort.quick else (1.5, 2.5, 3.5, 5.0, 7.0, 10.0, 20.0)
    found = []
    for rho in CELL_DENSITIES[: 1 if effort.quick else None]:
        for number in (n for n in listed if n > 3.5**2 * rho):  # no cell is narrower than 1.5 d
            kind = type("HardDisks", (HardDisks,), {"listed": number})
            found.append((f"cells of hard disks, {rho:g} per d^2", number, kind(rho, count=10_000)))
    return found


def throughput(effort: Effort) -> list[Record]:
    """Rows with collisions/s in `extra`, of one and of two threads; cell sizes of one."""
    from particles.media import LISTED as default

    tracers = 300 if effort.quick else 2000
    cases = [_Case(name, medium, threads) for name, medium in media(effort) for threads in (1, 2)]
    cases += [_Case(name, medium, 1, value, default) for name, value, medium in cells(effort)]
    collisions = [0] * len(cases)

    def keep(key: tuple[int, bool], ensemble: Any) -> None:
        if key[1]:
            collisions[key[0]] = ensemble.collision_total

    works = {}
    for k, case in enumerate(cases):
        works[k, False] = partial(case.run, 1, 1)
        works[k, True] = partial(case.run, tracers, 500)
    timings = measure_together(works, effort, keep)
    return [
        case.row(timings[k, False], timings[k, True], collisions[k]) for k, case in enumerate(cases)
    ]


@dataclass(frozen=True)
class _Case:
    name: str
    medium: Any
    threads: int
    listed: float | None = None
    default: float | None = None

    def run(self, tracers: int, collisions: int) -> Any:
        from particles import simulate

        return simulate(
            self.medium, RESTITUTION, max_collisions=collisions, media=4, tracers=tracers,
            workers=self.threads,
        )  # fmt: skip

    def row(self, placing: Timing | Exception, whole: Timing | Exception, total: int) -> Record:
        """Collisions/s without the time to place the scatterers, which stands beside."""
        where: dict[str, Any] = {"threads": self.threads}
        if self.listed is not None:
            where |= {"setting": LISTED, "value": self.listed}
        for timing in (placing, whole):
            if isinstance(timing, Exception):
                return failed(PARTICLES, self.name, PARTICLES, timing, **where)
        assert isinstance(placing, Timing)
        assert isinstance(whole, Timing)
        clock = "cpu" if self.threads == 1 else "wall"
        moving = max(getattr(whole, clock)[1] - getattr(placing, clock)[1], 1e-9)
        extra = {
            "collisions": total,
            "collisions_per_second": total / moving,
            "placing_seconds_per_medium": placing.cpu[1] / 4,
            "is_default": self.listed == self.default,
        }
        return timed(PARTICLES, self.name, PARTICLES, whole, extra=extra, **where)
