"""Cases of single tracers: grazing and corner starts, disks at corners of the index's cells."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from kinetics.crosscheck.stress.case import Case, Outcome, named
from kinetics.crosscheck.stress.limits import label_of

_BOX = 20.0  # d, of the media made here


def flight_cases(quick: bool) -> Iterator[Case]:
    """All of them, in groups; the quick sweep has them too."""
    for e in (0.0, 1e-10, 0.5, 1.0 - 1e-10, 1.0):
        for gap in (-1e-3, -1e-8, -1e-12, -1e-15, 0.0, 1e-15, 1e-12, 1e-8, 1e-3):
            name = f"{label_of(e)}, passing the circle at {gap:+.0e} d"
            yield named("grazing", name, _grazing, e, gap)
        for gap in (1e-15, 1e-9, 1e-3, 0.3):
            name = f"{label_of(e)}, into a corner, circles {gap:.0e} d inside one another"
            yield named("corners", name, _corner, e, gap)
        yield named("corners", f"{label_of(e)}, between circles that touch", _corner, e, 0.0)
    for cells in (3, 5, 7, 9):
        name = f"disks on corners, walls and centres of {cells} by {cells} cells"
        yield named("disks at cell corners", name, _lattice, cells)


def unaccounted(run: Any) -> float:
    """How many tracers the statuses lose or gain."""
    s = run.statuses
    ended = s.finished + s.collision_cap + s.trapped + s.escaped
    return float(abs(ended - run.media * run.tracers))


def speed_growth(finals: np.ndarray, first: np.ndarray) -> float:
    """Largest relative growth of a tracer's speed from its start to its end."""
    return max(0.0, float(np.max(finals[:, 0] - np.log(first))))


def _grazing(e: float, gap: float) -> Outcome:
    """A tracer flies past one disk, its centre 1 + gap from the path: it hits if gap < 0."""
    from particles import Positions, simulate

    medium = Positions(
        np.array([[15.0, 11.0 + gap]]), box_side=_BOX, start=(10.0, 10.0)
    )  # at 5 d in front, 1 + gap aside
    run = simulate(
        medium, e, initial=np.array([[1.0, 0.0]]), times=[4.0, 8.0, 1e3], media=1, tracers=1,
        max_collisions=10_000, workers=1, observables=("finals",),
    )  # fmt: skip
    collisions = float(run.collisions.value[1])
    clear = abs(gap) > 1e-14 * 15.0  # below, rounding of the position decides
    expected = 1.0 if gap < 0.0 else 0.0
    invariants = {
        "tracers are accounted for": (unaccounted(run), 0.0),
        "no speed grows": (speed_growth(run.finals, np.ones(1)), 1e-12),
        "it hits if it must": (abs(collisions - expected) if clear else 0.0, 0.0),
        "not twice": (max(0.0, collisions - 1.0), 0.0),
    }
    if gap < 0.0 and clear:
        # impact parameter 1 + gap: s^2 = e^2 + (1 - e^2) y^2
        s = math.sqrt(e * e + (1.0 - e * e) * (1.0 + gap) ** 2)
        # y is known to 1e-15 only
        allowed = 1e-12
        found = float(run.thermal_speed.value[1])
        invariants["speed after it"] = (abs(found - s), allowed)
    finite = bool(np.all(np.isfinite(run.finals)))
    return Outcome(
        reached=math.nan if finite else math.inf,
        invariants=invariants,
        note=f"{collisions:g} collisions",
    )


def _corner(e: float, gap: float) -> Outcome:
    """A tracer flies along the middle into the corner of two circles that cross (or touch)."""
    from particles import Positions, simulate

    half = 1.0 - 0.5 * gap
    medium = Positions(
        np.array([[15.0, 10.0 + half], [15.0, 10.0 - half]]), box_side=_BOX, start=(10.0, 10.0)
    )
    velocity = np.array([[1.0, 0.0], [1.0, 1e-9], [1.0, 0.01]])  # two beside the middle
    run = simulate(
        medium,
        e,
        initial=velocity,
        times=[1.0, 100.0, 1e5],
        media=1,
        tracers=3,
        max_collisions=100_000,
        workers=1,
        observables=("finals",),
    )
    first = np.hypot(velocity[:, 0], velocity[:, 1])
    invariants = {
        "tracers are accounted for": (unaccounted(run), 0.0),
        "no speed grows": (speed_growth(run.finals, first), 1e-12),
    }
    if e == 1.0:
        kept = float(np.max(np.abs(run.finals[:, 0] - np.log(first))))
        invariants["speed is kept"] = (kept, 1e-9)
        invariants["none is trapped"] = (float(run.statuses.trapped), 0.0)
    finite = not np.any(np.isnan(run.finals))
    return Outcome(
        reached=math.nan if finite else math.inf,
        invariants=invariants,
        note=f"{run.collision_total} collisions, {run.statuses.trapped} trapped",
    )


def _lattice(cells: int) -> Outcome:
    """Disks on the corners of the index's cells, on their walls and at their centres.

    Against flights that know of no index. The tracers start where one disk is left out.
    """
    from particles import Positions, simulate
    from particles.grid.cells import empty_box

    spacing = 7.2  # d; at this density a cell is twice as wide
    side = 2 * cells * spacing
    x, y = np.meshgrid(*(spacing * np.arange(-cells, cells),) * 2)
    disks = np.stack([x.ravel(), y.ravel()], axis=1)
    disks = disks[np.any(disks != 0.0, axis=1)]  # from the centre of the cell in the middle
    angles = np.linspace(0.1, 6.0, 40)
    velocity = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    times = np.array([15.0, 30.0])
    middle = 0.5 * side
    run = simulate(
        Positions(disks + middle, box_side=side, start=(middle, middle)), 1.0, initial=velocity,
        times=times, media=1, tracers=40, workers=1, observables=("positions",),
    )  # fmt: skip
    expected = np.stack([_flight(disks, side, v, times) for v in velocity], axis=1)
    found = run.positions
    there = empty_box(side, len(disks) / side**2, len(disks)).n
    return Outcome(
        asked=1e-7,  # each collision makes an error of rounding some ten times larger
        reached=float(np.max(np.abs(found - expected))) if np.all(np.isfinite(found)) else math.inf,
        invariants={
            "the index has these cells": (float(abs(there - cells)), 0.0),
            "tracers are accounted for": (unaccounted(run), 0.0),
        },
        note=f"{run.collision_total} collisions",
    )


def _flight(disks: Any, side: float, velocity: Any, times: Any) -> Any:
    """Elastic flight from the origin among disks and their images: places at the times."""
    place, v, clock = np.zeros(2), np.array(velocity), 0.0
    out = []
    for t in times:
        while True:
            apart = disks - place
            # those near enough for the time that is left, as images around the tracer
            shifts = side * np.stack(np.meshgrid([-2, -1, 0, 1, 2], [-2, -1, 0, 1, 2]), -1)
            apart = (apart - side * np.round(apart / side))[:, None] + shifts.reshape(1, -1, 2)
            apart = apart.reshape(-1, 2)
            along = apart @ v
            impact = apart[:, 0] * v[1] - apart[:, 1] * v[0]
            square = (1.0 - impact) * (1.0 + impact)
            hit = (along > 1e-9) & (square > 0.0)
            paths = np.where(hit, along - np.sqrt(np.where(hit, square, 0.0)), np.inf)
            k = int(np.argmin(paths))
            if clock + paths[k] > t:
                place, clock = place + v * (t - clock), t
                break
            place, clock = place + v * paths[k], clock + paths[k]
            normal = apart[k] - v * paths[k]
            v = v - 2.0 * (v @ normal) * normal
        out.append(place)
    return np.array(out)
