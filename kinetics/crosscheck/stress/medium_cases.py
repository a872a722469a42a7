"""Cases of the particles: density, e = 0, many collisions, thin media, crowds of disks."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from kinetics.crosscheck.stress.case import Case, Outcome, named
from kinetics.crosscheck.stress.flight_cases import conserved
from kinetics.crosscheck.stress.limits import label_of, scaling

PERCOLATION = 0.359
"""Poisson scatterers per d^2 at which the plane falls apart into cages (tracer and scatterers of
diameter d: circles of radius d, whose voids stop percolating at rho pi d^2 = 1.128)."""


def medium_cases(quick: bool) -> Iterator[Case]:
    """All of them, in groups."""
    media = [("Poisson", rho) for rho in (0.01, 0.2, 0.3, 0.35, PERCOLATION)]
    media += [("HardDisks", rho) for rho in (0.01, 0.2, 0.5, 0.65)]
    for e in (0.0, 0.5, 1.0) if quick else (0.0, 0.2, 0.5, 0.9, 0.99, 1.0):
        for kind, rho in (*media, ("BoltzmannGrad", 0.04)):
            yield named("density", f"e = {e:g}, {kind}, {rho:g} per d^2", _dense, kind, rho, e)
    many = 100_000 if quick else 1_000_000
    for e in (0.9, 1.0 - 1e-10, 1.0):
        for kind in ("HardDisks", "BoltzmannGrad"):
            name = f"{label_of(e)}, {kind}, {many:.0e} collisions of each of 4 tracers"
            yield named("many collisions", name, _many, kind, e, many)
    for rho in (1e-4, 1e-6, 1e-8):
        for t in (1e-3, 1.0, 10.0):
            yield named("thin media", f"HardDisks, {rho:g} per d^2, t = {t:g}", _thin, rho, t)
    for e in (0.0, 0.5, 0.9, 1.0):
        yield named("no tracer inside a disk", f"e = {e:g}, 400 random disks", _outside, e)


def _medium(kind: str, density: float) -> Any:
    import particles

    if kind == "BoltzmannGrad":
        return particles.BoltzmannGrad(density)
    return getattr(particles, kind)(density, count=2_000)


def _dense(kind: str, density: float, e: float) -> Outcome:
    """Statuses add up, speeds do not grow, one and two threads give the same bits."""
    from particles import simulate

    def run(workers: int) -> Any:
        return simulate(
            _medium(kind, density), e, initial="monoenergetic", times=[1.0, 100.0, 1e4], media=3,
            tracers=30, max_collisions=2_000, seed=5, workers=workers, observables=("finals",),
        )  # fmt: skip

    one, two = run(1), run(2)
    known = one.thermal_speed.value[one.samples > 0]
    same = np.array_equal(one.finals, two.finals)
    finite = bool(np.all(np.isfinite(known)) and not np.any(np.isnan(one.finals)))
    return Outcome(
        reached=math.nan if finite else math.inf,
        invariants={
            **conserved(one, np.ones(1)),
            "no tracer escapes": (float(one.statuses.escaped), 0.0),
            "threads do not matter": (0.0 if same else 1.0, 0.0),
        },
        note=f"{one.collision_total} collisions, {one.statuses.trapped} trapped",
    )


def _many(kind: str, e: float, collisions: int) -> Outcome:
    """As many collisions: speeds as the losses make them, and none lost."""
    from particles import simulate

    run = simulate(
        _medium(kind, 0.04), e, initial="monoenergetic", max_collisions=collisions, media=2,
        tracers=2, seed=9, workers=1, observables=("finals",),
    )  # fmt: skip
    done = run.finals[:, 4]
    invariants = conserved(run, np.ones(1))
    # rounding of as many steps
    invariants["no speed grows"] = (invariants["no speed grows"][0], 1e-9)
    invariants["collisions are counted"] = (float(abs(done.sum() - run.collision_total)), 0.0)
    loss = -run.finals[:, 0] / done
    if e == 1.0:
        invariants["speed is kept"] = (float(np.max(np.abs(run.finals[:, 0]))), 1e-9)
    elif kind == "BoltzmannGrad":
        # the mean of -ln s over as many independent collisions; 6 standard errors, ln s < |ln e|
        allowed = 6.0 * abs(math.log(e)) / math.sqrt(float(done.min()))
        apart = float(np.max(np.abs(loss - scaling(e)[2])))
        invariants["mean loss is kappa"] = (apart, allowed)
    finite = bool(np.all(np.isfinite(run.finals)))
    return Outcome(reached=math.nan if finite else math.inf, invariants=invariants)


def _thin(rho: float, t: float) -> Outcome:
    """Before they meet anything, tracers are at v t, however far the next disk is."""
    from particles import HardDisks, simulate

    run = simulate(
        HardDisks(rho, count=100), 0.5, initial="monoenergetic", times=[t], media=2, tracers=20,
        seed=3, workers=1,
    )  # fmt: skip
    return Outcome(
        asked=1e-9,
        reached=abs(float(run.msd.value[0]) / t**2 - 1.0),
        invariants={"none has collided": (float(run.collisions.value[0]), 0.0)},
    )


def _outside(e: float) -> Outcome:
    """No tracer ends inside a disk."""
    from particles import Positions, simulate

    random = np.random.default_rng(3)
    side = 60.0
    disks = random.uniform(0.0, side, (400, 2))
    centre = np.array([0.5 * side, 0.5 * side])
    disks = disks[np.hypot(*(disks - centre).T) > 1.0]
    run = simulate(
        Positions(disks, box_side=side), e, initial="monoenergetic", times=[1e4], media=1,
        tracers=300, max_collisions=3_000, workers=1, observables=("finals",),
    )  # fmt: skip
    place = run.finals[:, 2:4] + centre
    apart = place[:, None, :] - disks[None, :, :]
    apart -= side * np.round(apart / side)
    nearest = float(np.hypot(apart[..., 0], apart[..., 1]).min())
    far = np.abs(run.finals[:, 2:4]).max()
    return Outcome(
        reached=math.nan if np.all(np.isfinite(place)) else math.inf,
        invariants={
            **conserved(run, np.ones(1)),
            # a place is known to the rounding of the distance from the start
            "depth inside a disk": (max(0.0, 1.0 - nearest), 1e-12 * max(far, 100.0)),
        },
        note=f"{run.collision_total} collisions, {run.statuses.trapped} trapped",
    )
