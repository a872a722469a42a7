"""Cases of the particles: density, e = 0, many collisions, extreme sizes, crowds of disks."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from kinetics.crosscheck.stress.case import Case, Outcome, named
from kinetics.crosscheck.stress.flight_cases import speed_growth, unaccounted
from kinetics.crosscheck.stress.limits import label_of

PERCOLATION = 0.359
"""Poisson scatterers per d^2 at which the plane falls apart into cages (tracer and scatterers of
diameter d: circles of radius d, whose voids stop percolating at rho pi d^2 = 1.128)."""


def medium_cases(quick: bool) -> Iterator[Case]:
    """All of them, in groups."""
    overlapping = (0.01, 0.2, 0.3, 0.35, PERCOLATION)
    hard = (0.01, 0.2, 0.5, 0.65)
    for e in (0.0, 0.5, 1.0) if quick else (0.0, 0.2, 0.5, 0.9, 0.99, 1.0):
        for rho in overlapping:
            name = f"e = {e:g}, overlapping, {rho:g} per d^2"
            yield named("density", name, _dense, "Poisson", rho, e)
        for rho in hard:
            name = f"e = {e:g}, hard disks, {rho:g} per d^2"
            yield named("density", name, _dense, "HardDisks", rho, e)
        yield named("density", f"e = {e:g}, Boltzmann-Grad", _dense, "BoltzmannGrad", 0.04, e)
    many = 100_000 if quick else 1_000_000
    for e in (0.9, 1.0 - 1e-10, 1.0):
        for kind in ("HardDisks", "BoltzmannGrad"):
            name = f"{label_of(e)}, {kind}, {many:.0e} collisions of each of 4 tracers"
            yield named("many collisions", name, _many, kind, e, many)
    for kind in ("BoltzmannGrad", "HardDisks", "Poisson"):
        for e in (0.0, 0.5, 1.0):
            for length in (-498, 0, 498):
                for speed in (-498, 0, 498):
                    if length - speed > 900:  # times above 1e300
                        continue
                    name = f"e = {e:g}, {kind}, d times 2^{length}, v times 2^{speed}"
                    yield named("sizes of media", name, _sizes, kind, e, length, speed)
    for rho in (1e-4, 1e-6, 1e-8):
        for t in (1e-3, 1.0, 10.0):
            name = f"HardDisks, {rho:g} per d^2, t = {t:g}"
            yield named("thin media", name, _thin, rho, t)
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
    speed = one.thermal_speed.value
    known = speed[one.samples > 0]
    same = np.array_equal(one.finals, two.finals)
    note = f"{one.collision_total} collisions, {one.statuses.trapped} trapped"
    finite = bool(np.all(np.isfinite(known)) and not np.any(np.isnan(one.finals)))
    return Outcome(
        reached=math.nan if finite else math.inf,
        invariants={
            "tracers are accounted for": (unaccounted(one), 0.0),
            "no tracer escapes": (float(one.statuses.escaped), 0.0),
            "no speed grows": (speed_growth(one.finals, np.ones(1)), 1e-12),
            "threads do not matter": (0.0 if same else 1.0, 0.0),
        },
        note=note,
    )


def _many(kind: str, e: float, collisions: int) -> Outcome:
    """As many collisions: speeds as the losses make them, and none lost."""
    from kinetics.crosscheck.stress import exact
    from particles import simulate

    run = simulate(
        _medium(kind, 0.04), e, initial="monoenergetic", max_collisions=collisions, media=2,
        tracers=2, seed=9, workers=1, observables=("finals",),
    )  # fmt: skip
    done = run.finals[:, 4]
    invariants = {
        "tracers are accounted for": (unaccounted(run), 0.0),
        "no speed grows": (speed_growth(run.finals, np.ones(1)), 1e-9),
        "collisions are counted": (float(abs(done.sum() - run.collision_total)), 0.0),
    }
    loss = -run.finals[:, 0] / done
    if e == 1.0:
        invariants["speed is kept"] = (float(np.max(np.abs(run.finals[:, 0]))), 1e-9)
    elif kind == "BoltzmannGrad":
        # the mean of -ln s over as many independent collisions; 6 standard errors, ln s < |ln e|
        kappa = exact.scaling(e)[2]
        allowed = 6.0 * abs(math.log(e)) / math.sqrt(float(done.min()))
        invariants["mean loss is kappa"] = (float(np.max(np.abs(loss - kappa))), allowed)
    finite = bool(np.all(np.isfinite(run.finals)))
    return Outcome(reached=math.nan if finite else math.inf, invariants=invariants)


def _sizes(kind: str, e: float, length: int, speed: int) -> Outcome:
    """The same flights in other units, 2^498 = 8e149: every length and speed scales with them."""
    import particles

    def run(d: float, v: float) -> Any:
        count = {} if kind == "BoltzmannGrad" else {"count": 400}
        medium = getattr(particles, kind)(0.04 / d / d, diameter=d, **count)
        angle = np.linspace(0.0, 6.0, 7)
        return particles.simulate(
            medium, e, initial=v * np.stack([np.cos(angle), np.sin(angle)], axis=1),
            times=np.array([1.0, 30.0, 1e3]) * (d / v), media=2, tracers=7, seed=3, workers=1,
        )  # fmt: skip

    d, v = 2.0**length, 2.0**speed
    one, other = run(1.0, 1.0), run(d, v)
    pairs = (
        (one.thermal_speed.value, other.thermal_speed.value / v),
        (one.collisions.value, other.collisions.value),
        (one.msd.value, other.msd.value / d / d),
    )
    with np.errstate(invalid="ignore"):
        apart = [float(np.max(np.abs(b - a) / np.maximum(a, 1e-300))) for a, b in pairs]
    return Outcome(
        asked=1e-9,
        reached=max(apart) if all(math.isfinite(x) for x in apart) else math.inf,
        invariants={"tracers are accounted for": (unaccounted(other), 0.0)},
    )


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
    nearest = np.hypot(apart[..., 0], apart[..., 1]).min(axis=1)
    far = np.abs(run.finals[:, 2:4]).max()
    return Outcome(
        reached=math.nan if np.all(np.isfinite(place)) else math.inf,
        invariants={
            # a place is known to the rounding of the distance from the start
            "depth inside a disk": (max(0.0, 1.0 - float(nearest.min())), 1e-12 * max(far, 100.0)),
            "tracers are accounted for": (unaccounted(run), 0.0),
            "no speed grows": (speed_growth(run.finals, np.ones(1)), 1e-12),
        },
        note=f"{run.collision_total} collisions, {run.statuses.trapped} trapped",
    )
