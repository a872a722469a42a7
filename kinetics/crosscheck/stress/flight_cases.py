"""Cases of single tracers: grazing and corner starts."""

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


def conserved(run: Any, first: np.ndarray) -> dict[str, tuple[float, float]]:
    """Invariants of every run with final states: no tracer is lost, and none gets quicker.

    first : initial speeds
    """
    s = run.statuses
    ended = s.finished + s.collision_cap + s.trapped + s.escaped
    grown = max(0.0, float(np.max(run.finals[:, 0] - np.log(first))))
    return {
        "tracers are accounted for": (float(abs(ended - run.media * run.tracers)), 0.0),
        "no speed grows": (grown, 1e-12),
    }


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
        **conserved(run, np.ones(1)),
        "it hits if it must": (abs(collisions - expected) if clear else 0.0, 0.0),
        "not twice": (max(0.0, collisions - 1.0), 0.0),
    }
    if gap < 0.0 and clear:
        # impact parameter 1 + gap: s^2 = e^2 + (1 - e^2) y^2, y is known to 1e-15 only
        s = math.sqrt(e * e + (1.0 - e * e) * (1.0 + gap) ** 2)
        invariants["speed after it"] = (abs(float(run.thermal_speed.value[1]) - s), 1e-12)
    return Outcome(
        reached=math.nan if np.all(np.isfinite(run.finals)) else math.inf,
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
        medium, e, initial=velocity, times=[1.0, 100.0, 1e5], media=1, tracers=3,
        max_collisions=100_000, workers=1, observables=("finals",),
    )  # fmt: skip
    first = np.hypot(velocity[:, 0], velocity[:, 1])
    invariants = conserved(run, first)
    if e == 1.0:
        kept = float(np.max(np.abs(run.finals[:, 0] - np.log(first))))
        invariants["speed is kept"] = (kept, 1e-9)
        invariants["none is trapped"] = (float(run.statuses.trapped), 0.0)
    return Outcome(
        reached=math.inf if np.any(np.isnan(run.finals)) else math.nan,
        invariants=invariants,
        note=f"{run.collision_total} collisions, {run.statuses.trapped} trapped",
    )
