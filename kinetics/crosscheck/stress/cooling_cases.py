"""Cases of cooling: restitutions, times to 1e300, scales, rough starts, and random scenes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from kinetics.crosscheck.stress.case import Case, Outcome, named
from kinetics.crosscheck.stress.limits import (
    FEWER,
    GROWTH,
    RESTITUTIONS,
    ROUNDING,
    TIMES,
    FloatArray,
    below_half,
    compare_limits,
    difference,
    fall,
    growth,
    label_of,
)
from kinetics.crosscheck.stress.starts import first_moments, quadrature, starts

_FEW = (0.0, 0.2, 0.7, 0.99)


def cooling_cases(quick: bool) -> Iterator[Case]:
    """All of them, in groups."""
    some = FEWER if quick else RESTITUTIONS
    for e in some:
        for start in ("gaussian", "monoenergetic"):
            for scale in (1e-150, 1.0, 1e150):
                name = f"{label_of(e)}, {start}, speeds times {scale:g}, t to 1e300"
                # elastic tracers do not slow down: v t/l overflows
                refusal = "times" if e == 1.0 and scale > 1.0 else ""
                sizes = {"scale": scale}
                yield named("cooling", name, _cooling, e, start, sizes, 1e-9, refusal=refusal)
        for size in (1e-150, 1e150):
            for what in ("number_density", "diameter"):
                name = f"{label_of(e)}, gaussian, {what} {size:g}"
                refusal = "times" if e == 1.0 and size > 1.0 else ""
                sizes = {what: size}
                yield named("cooling", name, _cooling, e, "gaussian", sizes, 1e-9, refusal=refusal)
    for e in _FEW:
        for rtol in (0.1, 1e-3, 1e-6, 1e-12, 1e-13):
            name = f"{label_of(e)}, kept references, rtol {rtol:.0e}"
            yield named("cooling", name, _kept, e, rtol)
    for e in (0.0, 0.2, 1.0 - 1e-6) if quick else some:
        for label in starts():
            yield named("starts", f"{label_of(e)}, {label}", _rough, e, label, 1e-8)
    random = np.random.default_rng(2026)
    for k in range(20 if quick else 200):
        arguments = draw(random)
        yield named("random", f"{k}: {describe(arguments)}", random_case, arguments)


def _cooling(e: float, start: str, sizes: dict[str, float], rtol: float) -> Outcome:
    """v0 and a2 against their limits at early and at late times."""
    from kinetics import Gaussian, Monoenergetic, Scene, solve

    scale = sizes.get("scale", 1.0)
    medium: dict[str, Any] = {name: size for name, size in sizes.items() if name != "scale"}
    state = Gaussian(scale, scale) if start == "gaussian" else Monoenergetic(scale)
    outputs: tuple[str, ...] = ("thermal_speed", "a2", "temperature", "collisions")
    if e < 1.0 and sizes == {"scale": 1.0}:  # else <r^2> leaves the range of doubles
        outputs = (*outputs, "msd")
    scene = Scene(e, initial=state, times=TIMES, outputs=outputs, **medium)
    solution = solve(scene, rtol)
    speed, a2 = solution.thermal_speed, solution.a2
    first = (math.sqrt(2.0) * scale, 0.0) if start == "gaussian" else (scale, -0.5)
    reached = compare_limits(e, speed, a2, TIMES, scene.mean_free_path, first, rtol)
    if not np.all(np.isfinite([getattr(solution, name) for name in outputs])):
        reached = math.inf
    seen = speed > 1e-150  # its square is no rounded number
    with np.errstate(under="ignore"):
        energy = np.abs(2.0 * solution.temperature[seen] / speed[seen] ** 2 - 1.0)
    return Outcome(
        asked=rtol + ROUNDING,
        reached=reached,
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
    """v0 and a2 against the kept references of the benchmark, both starts, both horizons."""
    from kinetics import Scene, solve
    from kinetics.crosscheck.bench import references

    reached, converged, grown = 0.0, True, 0.0
    for start in references.STARTS:
        for horizon in references.HORIZONS:
            scene = Scene(e, initial=start, times=references.times(horizon),
                          outputs=("thermal_speed", "a2"))  # fmt: skip
            solution = solve(scene, rtol)
            v0 = references.reference("thermal_speed", e, start, horizon)
            a2 = references.reference("a2", e, start, horizon)
            reached = max(reached, difference(solution.thermal_speed, solution.a2, v0, a2))
            converged &= solution.status.name == "CONVERGED"
            grown = max(grown, growth(solution.thermal_speed))
    return Outcome(
        asked=rtol + ROUNDING,
        reached=reached,
        converged=converged,
        invariants={"v0 does not grow": (grown, max(GROWTH, rtol))},
    )


# -- starts ---------------------------------------------------------------------------------------


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
    known = first_moments(label)
    first = (float(speed[0]), float(a2[0])) if known is None else (known[0], known[1] - 1.0)
    ends = [0, -1]  # by the last one, speeds of 1e-150 have met 1e140 scatterers
    limits = compare_limits(e, speed[ends], a2[ends], TIMES[ends], 12.5, first, rtol)
    if not (np.all(np.isfinite(speed)) and np.all(np.isfinite(a2))):
        reached = math.inf
    return Outcome(
        asked=rtol + ROUNDING,
        reached=max(reached, limits),
        converged=solution.status.name == "CONVERGED",
        invariants={
            "v0 does not grow": (growth(speed), max(GROWTH, 0.1 * rtol)),
            "a2 >= -1/2": (below_half(a2), rtol),
            "<v^0> = 1": (float(np.max(np.abs(solution.moment(0.0) - 1.0))), rtol),
        },
    )


# -- random cases ---------------------------------------------------------------------------------


def draw(random: np.random.Generator) -> dict[str, Any]:
    """Arguments of a random case: every size from the smallest to the largest is as likely."""
    kind = random.integers(4)
    gap = 10.0 ** random.uniform(-12.0, 0.0)
    e = (gap, 1.0 - gap, float(random.uniform()), float(random.uniform()))[kind]
    return {
        "restitution": float(min(max(e, 0.0), 1.0)),
        "number_density": float(10.0 ** random.uniform(-100.0, 100.0)),
        "scale": float(10.0 ** random.uniform(-100.0, 100.0)),
        "start": str(random.choice(["gaussian", "monoenergetic", "samples"])),
        "times": sorted(float(10.0**x) for x in random.uniform(-200.0, 200.0, 6)),
        "rtol": float(10.0 ** random.uniform(-12.0, -1.0)),
    }


def describe(arguments: dict[str, Any]) -> str:
    """One line that tells cases apart."""
    first = label_of(arguments["restitution"])
    return (
        f"{first}, {arguments['start']} times {arguments['scale']:.0e}, "
        f"{arguments['number_density']:.0e} per d^2, rtol {arguments['rtol']:.0e}"
    )


def random_case(arguments: dict[str, Any]) -> Outcome:
    """Finite, cooling, and within rtol of the limits where one holds."""
    from kinetics import Gaussian, Monoenergetic, Scene, SpeedSamples, solve

    scale, rtol, e = arguments["scale"], arguments["rtol"], arguments["restitution"]
    v = np.array([1.0, 2.0, 4.0, 4.5826])
    state, first = {
        "gaussian": (Gaussian(scale, scale), (math.sqrt(2.0), 0.0)),
        "monoenergetic": (Monoenergetic(scale), (1.0, -0.5)),
        "samples": (
            SpeedSamples(scale * v),
            (math.sqrt(np.mean(v**2)), float(np.mean(v**4) / (2 * np.mean(v**2) ** 2)) - 1.0),
        ),
    }[arguments["start"]]
    times = np.array([0.0, *arguments["times"]])
    scene = Scene(
        e, arguments["number_density"], initial=state, times=times, outputs=("thermal_speed", "a2")
    )
    solution = solve(scene, rtol)
    speed, a2 = solution.thermal_speed, solution.a2
    path = scene.mean_free_path
    reached = compare_limits(e, speed, a2, times, path, (first[0] * scale, first[1]), rtol)
    if not (np.all(np.isfinite(speed)) and np.all(np.isfinite(a2)) and np.all(speed > 0.0)):
        reached = math.inf
    return Outcome(
        asked=rtol + ROUNDING,
        reached=reached,
        converged=solution.status.name == "CONVERGED",
        invariants={
            "v0 does not grow": (growth(speed), max(GROWTH, rtol)),
            "a2 >= -1/2": (below_half(a2), rtol),
        },
    )
