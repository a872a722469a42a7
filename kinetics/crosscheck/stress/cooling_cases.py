"""Cases of cooling: restitutions, times to 1e300, extreme sizes, and rough starts."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from kinetics.crosscheck import references
from kinetics.crosscheck.stress.case import Case, Outcome, named
from kinetics.crosscheck.stress.limits import (
    FEWER,
    GROWTH,
    RESTITUTIONS,
    ROUNDING,
    TIMES,
    FloatArray,
    below_half,
    difference,
    fall,
    growth,
    label_of,
    limit_errors,
)
from kinetics.crosscheck.stress.starts import first_averages, quadrature, starts


def cooling_cases(quick: bool) -> Iterator[Case]:
    """All of them, in groups."""
    some = FEWER if quick else RESTITUTIONS
    sizes = [(start, {"scale": v}) for start in references.STARTS for v in (1e-150, 1.0, 1e150)]
    sizes += [("gaussian", {n: x}) for n in ("number_density", "diameter") for x in (1e-150, 1e150)]
    for e in some:
        for start, size in sizes:
            ((what, value),) = size.items()
            if (
                e == 1.0 and value > 1.0
            ):  # refused: elastic tracers do not slow down, v t/l overflows
                continue
            name = f"{label_of(e)}, {start}, {what} {value:g}, t to 1e300"
            yield named("cooling", name, _cooling, e, start, size, 1e-9)
    for e in (0.0, 0.2, 0.7, 0.99):
        for rtol in (0.1, 1e-3, 1e-6, 1e-12, 1e-13):
            name = f"{label_of(e)}, kept references, rtol {rtol:.0e}"
            yield named("cooling", name, _kept, e, rtol)
    for e in (0.0, 0.2, 1.0 - 1e-6) if quick else some:
        for label in starts():
            yield named("starts", f"{label_of(e)}, {label}", _rough, e, label, 1e-8)


def _cooling(e: float, start: str, sizes: dict[str, float], rtol: float) -> Outcome:
    """v0 and a2 against their limits at early and at late times."""
    from kinetics import Gaussian, Monoenergetic, Scene, solve

    scale = sizes.get("scale", 1.0)
    medium: dict[str, Any] = {name: size for name, size in sizes.items() if name != "scale"}
    state = Gaussian(scale, scale) if start == "gaussian" else Monoenergetic(scale)
    outputs: tuple[str, ...] = ("thermal_speed", "a2", "temperature", "collisions")
    if e < 1.0 and sizes == {"scale": 1.0}:  # else <r^2> leaves the range of doubles
        outputs = (*outputs, "msd")
    solution = solve(Scene(e, initial=state, times=TIMES, outputs=outputs, **medium), rtol)
    speed, a2 = solution.thermal_speed, solution.a2
    first = (math.sqrt(2.0) * scale, 0.0) if start == "gaussian" else (scale, -0.5)
    finite = np.all(np.isfinite([getattr(solution, name) for name in outputs]))
    seen = speed > 1e-150  # its square is no rounded number
    with np.errstate(under="ignore"):
        energy = np.abs(2.0 * solution.temperature[seen] / speed[seen] ** 2 - 1.0)
    return Outcome(
        asked=rtol + ROUNDING,
        reached=limit_errors(solution, first, rtol) if finite else math.inf,
        converged=solution.status.name == "CONVERGED",
        invariants={
            "v0 does not grow": (growth(speed), GROWTH),
            "collisions do not fall": (fall(solution.collisions), 10.0 * rtol),
            "a2 >= -1/2": (below_half(a2), rtol),
            "T = v0^2/2": (float(np.max(energy, initial=0.0)), 1e-13),
            "<v^0> = 1": (float(np.max(np.abs(solution.moment(0.0) - 1.0))), rtol),
        },
    )


def _kept(e: float, rtol: float) -> Outcome:
    """v0 and a2 against the kept references, both starts, both horizons."""
    from kinetics import Scene, solve

    reached, converged, grown = 0.0, True, 0.0
    for start in references.STARTS:
        for horizon in references.HORIZONS:
            scene = Scene(e, initial=start, times=references.times(horizon),
                          outputs=("thermal_speed", "a2"))  # fmt: skip
            solution = solve(scene, rtol)
            v0, a2 = (references.kept(q, e, start, horizon) for q in ("thermal_speed", "a2"))
            reached = max(reached, difference(solution.thermal_speed, solution.a2, v0, a2))
            converged &= solution.status.name == "CONVERGED"
            grown = max(grown, growth(solution.thermal_speed))
    return Outcome(
        asked=rtol + ROUNDING,
        reached=reached,
        converged=converged,
        invariants={"v0 does not grow": (grown, max(GROWTH, rtol))},
    )


def mixture(e: float, label: str, times: FloatArray) -> tuple[FloatArray, FloatArray]:
    """v0 and a2 of a start as the mean over its speeds, of a monoenergetic one at scaled times.

    The equation is linear, and speeds times s are times divided by s. Shape (n_times,) each.
    """
    from kinetics import Scene, solve

    v, w = quadrature(label)
    paths = np.outer(times, v)
    known, where = np.unique(paths, return_inverse=True)
    one = solve(
        Scene(e, initial="monoenergetic", times=known, outputs=("thermal_speed", "a2")), 1e-13
    )
    with np.errstate(under="ignore"):
        square = (one.thermal_speed**2)[where].reshape(paths.shape)
        fourth = 2.0 * square**2 * (1.0 + one.a2[where].reshape(paths.shape))
        second, fourth = square @ (w * v**2), fourth @ (w * v**4)
    return np.sqrt(second), 0.5 * fourth / second**2 - 1.0


def _rough(e: float, label: str, rtol: float) -> Outcome:
    """v0 and a2 of a rough start: first value, mixture at all times, and late limit."""
    from kinetics import Scene, solve

    scene = Scene(e, initial=starts()[label], times=TIMES, outputs=("thermal_speed", "a2"))
    solution = solve(scene, rtol)
    speed, a2 = solution.thermal_speed, solution.a2
    # fourth powers of late speeds of 1e-30 and less underflow in the mixture
    middle = (TIMES > 0.0) & (TIMES <= 1e30)
    reached = difference(speed[middle], a2[middle], *mixture(e, label, TIMES[middle]))
    # the first time and the last: by then, speeds of 1e-150 have met 1e140 scatterers
    ends = slice(None, None, TIMES.size - 1)
    finite = np.all(np.isfinite(speed)) and np.all(np.isfinite(a2))
    reached = max(reached, limit_errors(solution, first_averages(label), rtol, ends))
    return Outcome(
        asked=rtol + ROUNDING,
        reached=reached if finite else math.inf,
        converged=solution.status.name == "CONVERGED",
        invariants={
            "v0 does not grow": (growth(speed), max(GROWTH, 0.1 * rtol)),
            "a2 >= -1/2": (below_half(a2), rtol),
            "<v^0> = 1": (float(np.max(np.abs(solution.moment(0.0) - 1.0))), rtol),
        },
    )
