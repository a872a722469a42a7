"""Cases of the particles: dense and thin media, many collisions, grazing and corner starts."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.crosscheck.stress.case import Case, Outcome
from kinetics.crosscheck.stress.limits import label_of, scaling

PERCOLATION = 0.359
"""Poisson scatterers per d^2 at which the plane falls apart into cages (tracer and scatterers of
diameter d: circles of radius d, whose voids stop percolating at rho pi d^2 = 1.128)."""
_BOX = 20.0  # d, of the media made for a single flight


def medium_cases(quick: bool) -> Iterator[Case]:
    """Many tracers in a random medium, in groups."""
    media = [("Poisson", rho) for rho in (0.01, 0.2, 0.3, 0.35, PERCOLATION)]
    media += [("HardDisks", rho) for rho in (0.01, 0.2, 0.5, 0.65)]
    for e in (0.0, 0.5, 1.0) if quick else (0.0, 0.2, 0.5, 0.9, 0.99, 1.0):
        for kind, rho in (*media, ("BoltzmannGrad", 0.04)):
            yield Case("density", f"e = {e:g}, {kind}, {rho:g} per d^2", _dense, (kind, rho, e))
    # l = 10 d among spheres
    spheres = [("HardSpheres", 0.1 / math.pi), ("PoissonSpheres", 0.1 / math.pi)]
    spheres += [("HardSpheres", 0.3), ("BoltzmannGrad in space", 0.04)]
    for e, et in ((0.0, 1.0), (0.5, 1.0), (0.5, 0.8), (1.0, 1.0)):
        for kind, rho in spheres:
            name = f"e = {e:g}, et = {et:g}, {kind}, {rho:.2g} per d^3"
            yield Case("density", name, _dense, (kind, rho, e, et))
    for e, et in ((0.5, 0.0), (0.5, 0.8), (1.0, 0.8)):
        for kind, rho in (("HardDisks", 0.2), ("BoltzmannGrad", 0.04)):
            name = f"e = {e:g}, et = {et:g}, {kind}, {rho:g} per d^2"
            yield Case("density", name, _dense, (kind, rho, e, et))
    many = 100_000 if quick else 1_000_000
    for e in (0.9, 1.0 - 1e-10, 1.0):
        for kind in ("HardDisks", "BoltzmannGrad"):
            name = f"{label_of(e)}, {kind}, {many:.0e} collisions of each of 4 tracers"
            yield Case("many collisions", name, _many, (kind, CollisionLaw(e), many))
    for law in (
        CollisionLaw(0.9, 0.8),
        CollisionLaw(1.0, 0.8),
        CollisionLaw(0.9, 1.0, 3),
        CollisionLaw(0.9, 0.8, 3),
        CollisionLaw(0.5, 0.0, 3),
        CollisionLaw(1.0, 1.0, 3),
    ):
        name = f"{label_of(law)}, {many:.0e} collisions of each of 4 tracers"
        kind = "BoltzmannGrad" + (" in space" if law.dimension == 3 else "")
        yield Case("many collisions", name, _many, (kind, law, many))
    for rho in (1e-4, 1e-6, 1e-8):
        for t in (1e-3, 1.0, 10.0):
            yield Case("thin media", f"HardDisks, {rho:g} per d^2, t = {t:g}", _thin, (rho, t))
    for e in (0.0, 0.5, 0.9, 1.0):
        yield Case("no tracer inside a disk", f"e = {e:g}, 400 random disks", _outside, (e,))


def flight_cases(quick: bool) -> Iterator[Case]:
    """Single tracers, in groups; the quick sweep has them too."""
    for e in (0.0, 1e-10, 0.5, 1.0 - 1e-10, 1.0):
        for gap in (-1e-3, -1e-8, -1e-12, -1e-15, 0.0, 1e-15, 1e-12, 1e-8, 1e-3):
            name = f"{label_of(e)}, passing the circle at {gap:+.0e} d"
            yield Case("grazing", name, _grazing, (e, gap))
        for gap in (1e-15, 1e-9, 1e-3, 0.3):
            name = f"{label_of(e)}, into a corner, circles {gap:.0e} d inside one another"
            yield Case("corners", name, _corner, (e, gap))
        yield Case("corners", f"{label_of(e)}, between circles that touch", _corner, (e, 0.0))


def _medium(kind: str, density: float) -> Any:
    import particles

    if kind.startswith("BoltzmannGrad"):
        return particles.BoltzmannGrad(density, dimension=3 if "space" in kind else 2)
    return getattr(particles, kind)(density, count=2_000)


def _run(medium: Any, e: float, **options: Any) -> Any:
    """A run of one thread with final states, of tracers of speed 1 where nothing else is said."""
    from particles import simulate

    usual: dict[str, Any] = {
        "initial": "monoenergetic",
        "media": 1,
        "workers": 1,
        "observables": ("finals",),
    }
    return simulate(medium, e, **(usual | options))


def _outcome(
    run: Any, finite: bool, invariants: dict[str, tuple[float, float]], first: Any = 1.0
) -> Outcome:
    """What holds in every run besides: no tracer is lost, and none gets faster than at first."""
    s = run.statuses
    ended = s.finished + s.collision_cap + s.trapped + s.escaped
    grown = max(0.0, float(np.max(run.finals[:, 0] - np.log(first))))
    return Outcome(
        reached=math.nan if finite else math.inf,
        invariants={
            "tracers are accounted for": (float(abs(ended - run.media * run.tracers)), 0.0),
            "no speed grows": (grown, 1e-12),
            **invariants,
        },
        note=f"{run.collision_total} collisions, {s.trapped} trapped",
    )


def _dense(kind: str, density: float, e: float, et: float = 1.0) -> Outcome:
    """One and two threads give the same bits."""
    one, two = (
        _run(_medium(kind, density), e, times=[1.0, 100.0, 1e4], media=3, tracers=30,
             max_collisions=2_000, seed=5, workers=workers, tangential_restitution=et)
        for workers in (1, 2)
    )  # fmt: skip
    same = np.array_equal(one.finals, two.finals)
    known = one.thermal_speed.value[one.samples > 0]
    return _outcome(
        one,
        bool(np.all(np.isfinite(known)) and not np.any(np.isnan(one.finals))),
        {
            "no tracer escapes": (float(one.statuses.escaped), 0.0),
            "threads do not matter": (0.0 if same else 1.0, 0.0),
        },
    )


def _many(kind: str, law: CollisionLaw, collisions: int) -> Outcome:
    """As many collisions: speeds as the losses make them."""
    run = _run(
        _medium(kind, 0.04), law.restitution or 0.0, max_collisions=collisions, media=2, tracers=2,
        seed=9, tangential_restitution=law.tangential_restitution,
    )  # fmt: skip
    logarithm, done = run.finals[:, 0], run.finals[:, 4]
    invariants = {
        # rounding of as many steps
        "no speed grows": (max(0.0, float(np.max(logarithm))), 1e-9),
        "collisions are counted": (float(abs(done.sum() - run.collision_total)), 0.0),
    }
    if law.is_elastic:
        invariants["speed is kept"] = (float(np.max(np.abs(logarithm))), 1e-9)
    elif kind.startswith("BoltzmannGrad"):
        # the mean of -ln s over as many independent collisions; 6 standard errors. Its
        # standard deviation is below the largest loss, or of the order of kappa if that is infinite
        spread = law.largest_loss if math.isfinite(law.largest_loss) else 2.0 * scaling(law)[2]
        allowed = 6.0 * spread / math.sqrt(float(done.min()))
        apart = float(np.max(np.abs(-logarithm / done - scaling(law)[2])))
        invariants["mean loss is kappa"] = (apart, allowed)
    return _outcome(run, bool(np.all(np.isfinite(run.finals))), invariants)


def _thin(rho: float, t: float) -> Outcome:
    """Before they meet anything, tracers are at v t, however far the next disk is."""
    from particles import HardDisks

    run = _run(HardDisks(rho, count=100), 0.5, times=[t], media=2, tracers=20, seed=3,
               observables=None)  # fmt: skip
    return Outcome(
        asked=1e-9,
        reached=abs(float(run.msd.value[0]) / t**2 - 1.0),
        invariants={"none has collided": (float(run.collisions.value[0]), 0.0)},
    )


def _outside(e: float) -> Outcome:
    """No tracer ends inside a disk."""
    from particles import Positions

    side = 60.0
    disks = np.random.default_rng(3).uniform(0.0, side, (400, 2))
    centre = np.array([0.5 * side, 0.5 * side])
    disks = disks[np.hypot(*(disks - centre).T) > 1.0]
    medium = Positions(disks, box_side=side)
    run = _run(medium, e, times=[1e4], tracers=300, max_collisions=3_000)
    place = run.finals[:, 2:4] + centre
    apart = place[:, None, :] - disks[None, :, :]
    apart -= side * np.round(apart / side)
    nearest = float(np.hypot(apart[..., 0], apart[..., 1]).min())
    # a place is known to the rounding of the distance from the start
    allowed = 1e-12 * max(np.abs(run.finals[:, 2:4]).max(), 100.0)
    invariants = {"depth inside a disk": (max(0.0, 1.0 - nearest), allowed)}
    return _outcome(run, bool(np.all(np.isfinite(place))), invariants)


def _grazing(e: float, gap: float) -> Outcome:
    """A tracer flies past one disk, its centre 1 + gap from the path: it hits if gap < 0."""
    from particles import Positions

    # the disk is 5 d in front of the start, 1 + gap aside
    medium = Positions(np.array([[15.0, 11.0 + gap]]), box_side=_BOX, start=(10.0, 10.0))
    run = _run(medium, e, initial=np.array([[1.0, 0.0]]), times=[4.0, 8.0, 1e3], tracers=1,
               max_collisions=10_000)  # fmt: skip
    collisions = float(run.collisions.value[1])
    clear = abs(gap) > 1e-14 * 15.0  # below, rounding of the position decides
    expected = 1.0 if gap < 0.0 else 0.0
    invariants = {
        "it hits if it must": (abs(collisions - expected) if clear else 0.0, 0.0),
        "not twice": (max(0.0, collisions - 1.0), 0.0),
    }
    if gap < 0.0 and clear:
        # impact parameter 1 + gap: s^2 = e^2 + (1 - e^2) y^2, y is known to 1e-15 only
        s = math.sqrt(e * e + (1.0 - e * e) * (1.0 + gap) ** 2)
        invariants["speed after it"] = (abs(float(run.thermal_speed.value[1]) - s), 1e-12)
    return _outcome(run, bool(np.all(np.isfinite(run.finals))), invariants)


def _corner(e: float, gap: float) -> Outcome:
    """A tracer flies along the middle into the corner of two circles that cross (or touch)."""
    from particles import Positions

    half = 1.0 - 0.5 * gap
    disks = np.array([[15.0, 10.0 + half], [15.0, 10.0 - half]])
    velocity = np.array([[1.0, 0.0], [1.0, 1e-9], [1.0, 0.01]])  # two beside the middle
    run = _run(
        Positions(disks, box_side=_BOX, start=(10.0, 10.0)), e, initial=velocity,
        times=[1.0, 100.0, 1e5], tracers=3, max_collisions=100_000,
    )  # fmt: skip
    first = np.hypot(velocity[:, 0], velocity[:, 1])
    invariants = {}
    if e == 1.0:
        kept = float(np.max(np.abs(run.finals[:, 0] - np.log(first))))
        invariants["speed is kept"] = (kept, 1e-9)
        invariants["none is trapped"] = (float(run.statuses.trapped), 0.0)
    return _outcome(run, not np.any(np.isnan(run.finals)), invariants, first)
