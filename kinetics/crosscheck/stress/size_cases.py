"""Cases of scale: mean free path, diameter and speeds from 1e-150 to 1e150, of every average.

Lengths in l and speeds in that of the start, the answers are those of l = v = 1.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from kinetics.crosscheck.stress.case import Case, Outcome, named
from kinetics.crosscheck.stress.limits import FEWER, RESTITUTIONS, label_of

# powers of the length and of the speed that an average scales with
_DIMENSIONS = {
    "thermal_speed": (0, 1),
    "temperature": (0, 2),
    "a2": (0, 0),
    "collisions": (0, 0),
    "msd": (2, 0),
    "kurtosis": (0, 0),
    "velocity_autocorrelation": (0, 2),
    "diffusion_coefficient": (1, 1),
    "msd_slope": (2, 0),
    "mean_displacement": (1, 0),
    "mean_velocity": (0, 1),
    "velocity_tensor": (0, 2),
}
_RANGE = 290.0  # decades that a double keeps all its digits in
# Averages are sums over ln v, which is known to 1e-16 of its size; powers multiply it.
_LOGARITHM = 5e-13


def size_cases(quick: bool) -> Iterator[Case]:
    """All of them."""
    sizes = [(a, b) for a in (-150, 0, 150) for b in (-150, 0, 150) if a or b]
    for e in FEWER if quick else RESTITUTIONS:
        for length, speed in sizes[1::3] if quick else sizes:
            for what in ("number_density", "diameter"):
                name = f"{label_of(e)}, beam, l times 1e{length} by {what}, v times 1e{speed}"
                yield named("sizes", name, _scaled, e, length, speed, what)


def _scaled(e: float, length: int, speed: int, what: str) -> Outcome:
    """Every average, in units of the case's own."""
    from kinetics import Beam, Monoenergetic, Scene, solve

    rtol = 1e-9
    outputs = tuple(name for name in _DIMENSIONS if name != "msd_slope")
    # in units of l/v; far below the mean free path as well, where nothing collides
    reduced = 10.0 ** np.array([-250.0, -170.0, -100.0, -20.0, -3.0, 0.0, 3.0, 20.0])
    logarithm = np.log10(reduced) + length - speed
    seen = (logarithm > -300.0) & (logarithm < 300.0)
    times = 10.0 ** logarithm[seen]
    medium: dict[str, Any] = {"number_density": 0.5, "diameter": 1.0}
    one = solve(Scene(e, **medium, initial=Beam(0.3), times=reduced[seen], outputs=outputs), rtol)
    medium[what] *= 10.0**-length
    start = Beam(0.3, Monoenergetic(10.0**speed))
    # an average that leaves the range of doubles is not asked for
    kept = [name for name in outputs if _largest(one, name, length, speed) < 305.0]
    other = solve(Scene(e, **medium, initial=start, times=times, outputs=tuple(kept)), rtol)
    reached = 0.0
    for name in other.values:
        a, b = (np.abs(np.asarray(s.values[name], dtype=float)) for s in (other, one))
        with np.errstate(divide="ignore"):
            decades = _shift(name, length, speed) + np.log10(b)
        good = (np.abs(decades) < _RANGE) & (np.abs(np.log10(np.maximum(b, 1e-320))) < _RANGE)
        with np.errstate(divide="ignore"):
            apart = np.abs(np.log10(a[good]) - decades[good]) * math.log(10.0)
        if name == "a2":  # 1 + a2 is what it is accurate to
            apart = np.abs(a - b)
        reached = max(reached, float(np.max(apart, initial=0.0)))
    return Outcome(
        asked=rtol + _LOGARITHM,
        reached=reached if math.isfinite(reached) else math.inf,
        converged=one.status.name == other.status.name == "CONVERGED",
        note=f"{len(other.values)} averages at {times.size} times",
    )


def _shift(name: str, length: int, speed: int) -> float:
    a, b = _DIMENSIONS[name]
    return a * length + b * speed


def _largest(one: object, name: str, length: int, speed: int) -> float:
    """Decades of the largest value that the average has in the other units."""
    parts = ("diffusion_coefficient", "msd_slope") if name == "diffusion_coefficient" else (name,)
    sizes = [np.max(np.abs(getattr(one, part))) for part in parts]
    return max(
        math.log10(max(float(size), 1e-320)) + _shift(part, length, speed)
        for part, size in zip(parts, sizes, strict=True)
    )
