"""Cases of the solvers: restitutions, nodes, times, scales, rough and extreme starts."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.stress import exact
from kinetics.crosscheck.stress.case import Case, Outcome, named

FloatArray = NDArray[np.float64]

RESTITUTIONS = (
    0.0, 1e-10, 1e-8, 1e-4, 0.01, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.99, 0.999,
    1.0 - 1e-6, 1.0 - 1e-10, 1.0,
)  # fmt: skip
FEWER = (0.0, 1e-10, 1e-4, 0.2, 0.7, 0.99, 1.0 - 1e-6, 1.0 - 1e-10, 1.0)
_FEW = (0.0, 0.2, 0.7, 0.99)
TIMES = np.array([0.0, 1e-300, 1e-3, 1.0, 1e3, 1e8, 1e30, 1e300])
_ROUNDING = 1e-14  # that a reference in doubles, and the average over a start, may add
_GROWTH = 1e-13  # of a thermal speed that must not grow, relative


def label_of(e: float) -> str:
    """A restitution as the name of a case has it."""
    return f"e = {e:g}" if e < 0.9995 or e == 1.0 else f"e = 1 - {1.0 - e:.0e}"


def solver_cases(quick: bool) -> Iterator[Case]:
    """All of them, in groups."""
    some = FEWER if quick else RESTITUTIONS
    for e in some:
        for rtol in (1e-4, 1e-12) if quick else (1e-3, 1e-6, 1e-9, 1e-12):
            name = f"{label_of(e)}, rtol {rtol:.0e}"
            yield named("scaled equation", name, _scaled, e, rtol, None)
    for e in _FEW:
        for nodes in (8, 16, 64, 256, 1024) if quick else (8, 12, 16, 32, 64, 256, 1024, 4096):
            name = f"{label_of(e)}, {nodes} nodes"
            yield named("scaled equation, nodes given", name, _scaled, e, 1e-12, nodes)
    for e in some:
        for start in ("gaussian", "monoenergetic"):
            for scale in (1e-150, 1.0, 1e150):
                name = f"{label_of(e)}, {start}, speeds times {scale:g}, t to 1e300"
                yield named("cooling", name, _cooling, e, start, scale, 0.04, 1e-9)
    for e in _FEW:
        for density in (1e-150, 1e150):
            name = f"{label_of(e)}, gaussian, {density:g} scatterers per d^2"
            yield named("cooling", name, _cooling, e, "gaussian", 1.0, density, 1e-9)
        for rtol in (0.1, 1e-3, 1e-6, 1e-12, 1e-13):
            name = f"{label_of(e)}, kept references, rtol {rtol:.0e}"
            yield named("cooling", name, _kept, e, rtol)
    for e in (0.0, 0.2, 0.7, 1.0 - 1e-6) if quick else some:
        for label in starts():
            yield named("starts", f"{label_of(e)}, {label}", _rough, e, label, 1e-8)
    for e in (0.0, 0.7, 0.99) if quick else (0.0, 1e-4, 0.2, 0.5, 0.7, 0.9, 0.99, 0.999):
        for count in (8, 64, 512, None) if quick else (8, 16, 64, 256, 1024, 4096, None):
            name = f"{label_of(e)}, gaussian, {count or 'its own'} nodes"
            yield named("spectral density", name, _density, e, "gaussian", "spectral", count)
        yield named(
            "spectral density", f"{label_of(e)}, tail v^-6", _density, e, "tail v^-6", None, None
        )
        for count in (8, 64, 512) if quick else (8, 16, 64, 256, 1024, 4096):
            for label in ("gaussian", "monoenergetic", "step", "two delta peaks", "tail v^-6"):
                name = f"{label_of(e)}, {label}, {count} nodes"
                yield named("conservative density", name, _conservative, e, label, count)
    random = np.random.default_rng(2026)
    for k in range(20 if quick else 200):
        arguments = draw(random)
        yield named("random", f"{k}: {describe(arguments)}", random_case, arguments)


# -- starts -----------------------------------------------------------------------------------


def starts() -> dict[str, Any]:
    """Rough and extreme initial states by name."""
    from kinetics import Beam, Gaussian, SpeedSamples, SpeedTable

    def tail(v: Any) -> Any:
        """Falls as v^-6."""
        with np.errstate(under="ignore"):
            return 5.0 * np.asarray(v) * np.hypot(1.0, v) ** -7.0

    return {
        "monoenergetic": "monoenergetic",
        "gaussian": "gaussian",
        "step": SpeedTable([1.0, 1.0 + 1e-9, 2.0, 2.0 + 1e-9], [0.0, 1.0, 1.0, 0.0]),
        "narrow triangle": SpeedTable([1.0 - 1e-6, 1.0, 1.0 + 1e-6], [0.0, 1e6, 0.0]),
        "two delta peaks": SpeedSamples([0.01, 1.0]),
        "speeds 1e-100 and 1": SpeedSamples([1e-100, 1.0]),
        "tail v^-6": tail,
        "beam": Beam(0.3),
        "two temperatures, 1e-3 and 1": Gaussian(1e-3, 1.0),
    }


# -- works --------------------------------------------------------------------------------------


def _scaled(e: float, rtol: float, nodes: int | None) -> Outcome:
    """h and a2 against closed forms; norm, <c^2> = 1 and positivity of F."""
    from kinetics import solve_scaled

    state = solve_scaled(e, rtol, nodes)
    h, one_a2, _ = exact.scaling(e)
    c = np.geomspace(1e-3, 30.0, 400)
    F = state.vdf(c)
    reached = max(abs(state.cooling_rate / h - 1.0), abs((1.0 + state.a2) / one_a2 - 1.0))
    estimate, converged = state.error_estimate, state.status.name == "CONVERGED"
    claimed = max(rtol, 1e-12) if converged else math.inf
    # with the nodes given, it is the estimate that must hold
    asked = rtol if nodes is None else max(rtol, estimate)
    if not (math.isfinite(reached) and np.all(np.isfinite(F))):
        reached = math.inf
    return Outcome(
        asked=asked,
        reached=reached,
        converged=converged,
        invariants={
            "F not negative": (max(0.0, -float(F.min())), 0.0),
            "<c^2> = 1": (abs(state.moment(2.0) - 1.0), claimed),
            "<c^0> = 1": (abs(state.moment(0.0) - 1.0), claimed),
        },
        note=f"estimate {estimate:.1e}",
    )


def _growth(speed: FloatArray) -> float:
    """Largest relative growth from one time to the next."""
    with np.errstate(invalid="ignore", divide="ignore"):
        change = speed[1:] / speed[:-1] - 1.0
    return max(0.0, float(np.max(change, initial=0.0)))


def _compare_limits(
    e: float,
    speed: FloatArray,
    a2: FloatArray,
    times: FloatArray,
    path: float,
    first: tuple[float, float],
    rtol: float,
) -> float:
    """Error at the times that are early or late enough for the limits; NaN if none is."""
    errors = []
    for t, v0, a in zip(times, speed, a2, strict=True):
        # in logarithms: v t may overflow
        logarithm = -math.inf if t == 0.0 else math.log(first[0]) + math.log(t) - math.log(path)
        reduced = math.exp(max(min(logarithm, 700.0), -700.0))
        early, late = exact.early_and_late(e, reduced, rtol)
        if early or e == 1.0:
            errors += [abs(v0 / first[0] - 1.0), abs((1.0 + a) / (1.0 + first[1]) - 1.0)]
        elif late:
            expected = exact.late_thermal_speed(e, path, float(t))
            if expected < 1e-290:  # at the end of the doubles
                continue
            errors += [abs(v0 / expected - 1.0), abs((1.0 + a) / exact.scaling(e)[1] - 1.0)]
    return max(errors, default=math.nan)


def _cooling(e: float, start: str, scale: float, density: float, rtol: float) -> Outcome:
    """v0 and a2 against their limits at early and at late times."""
    from kinetics import Gaussian, Monoenergetic, Scene, solve

    state = Gaussian(scale, scale) if start == "gaussian" else Monoenergetic(scale)
    outputs: tuple[str, ...] = ("thermal_speed", "a2", "collisions", "msd")
    if scale != 1.0 or density != 0.04:
        outputs = ("thermal_speed", "a2", "collisions")  # <r^2> leaves the range of doubles
    scene = Scene(e, density, initial=state, times=TIMES, outputs=outputs)
    solution = solve(scene, rtol)
    speed, a2 = solution.thermal_speed, solution.a2
    first = (math.sqrt(2.0) * scale, 0.0) if start == "gaussian" else (scale, -0.5)
    reached = _compare_limits(e, speed, a2, TIMES, scene.mean_free_path, first, rtol)
    values = [getattr(solution, name) for name in outputs]
    if e == 1.0:
        values = values[:2]  # v t/l overflows at t = 1e300
    if not np.all(np.isfinite(values)):
        reached = math.inf
    return Outcome(
        asked=rtol + _ROUNDING,
        reached=reached,
        converged=solution.status.name == "CONVERGED",
        invariants={
            "v0 does not grow": (_growth(speed), _GROWTH),
            "collisions do not fall": (_fall(solution.collisions), 10.0 * rtol),
        },
    )


def _fall(values: FloatArray) -> float:
    """Largest fall from one time to the next, relative to the largest finite value."""
    finite = values[np.isfinite(values)]
    if finite.size < 2 or not finite.max() > 0.0:
        return 0.0
    return max(0.0, float(-np.min(np.diff(finite / finite.max()))))


def _kept(e: float, rtol: float) -> Outcome:
    """v0 and a2 against the kept references of the benchmark, both starts, both horizons."""
    from kinetics import Scene, solve
    from kinetics.crosscheck.bench import references

    reached, converged, growth = 0.0, True, 0.0
    for start in references.STARTS:
        for horizon in references.HORIZONS:
            scene = Scene(e, initial=start, times=references.times(horizon),
                          outputs=("thermal_speed", "a2"))  # fmt: skip
            solution = solve(scene, rtol)
            v0 = references.reference("thermal_speed", e, start, horizon)
            a2 = references.reference("a2", e, start, horizon)
            with np.errstate(all="ignore"):
                errors = [solution.thermal_speed / v0 - 1.0, (1.0 + solution.a2) / (1.0 + a2) - 1.0]
            found = float(np.max(np.abs(errors)))
            reached = max(reached, found if math.isfinite(found) else math.inf)
            converged &= solution.status.name == "CONVERGED"
            growth = max(growth, _growth(solution.thermal_speed))
    return Outcome(
        asked=rtol + _ROUNDING,
        reached=reached,
        converged=converged,
        invariants={"v0 does not grow": (growth, max(_GROWTH, rtol))},
    )


def _rough(e: float, label: str, rtol: float) -> Outcome:
    """v0 and a2 of a rough start: first value and late limit."""
    from kinetics import Scene, solve

    scene = Scene(e, initial=starts()[label], times=TIMES, outputs=("thermal_speed", "a2"))
    solution = solve(scene, rtol)
    speed, a2 = solution.thermal_speed, solution.a2
    first = (float(speed[0]), float(a2[0]))
    slowest = first[0]
    if label == "speeds 1e-100 and 1":
        slowest = 1e-100
    elif label in ("two temperatures, 1e-3 and 1", "tail v^-6", "gaussian", "two delta peaks"):
        slowest = 1e-8 * first[0]  # what is slower weighs less than rtol
    late = TIMES[-1:] if slowest * TIMES[-1] > 1e20 * scene.mean_free_path else TIMES[:1]
    where = np.isin(TIMES, [0.0, *late])
    reached = _compare_limits(
        e, speed[where], a2[where], TIMES[where], scene.mean_free_path, first, rtol
    )
    known = _first_moments(label)
    if known is not None:
        reached = max(reached, abs(first[0] / known[0] - 1.0), abs((1 + first[1]) / known[1] - 1.0))
    if not (np.all(np.isfinite(speed)) and np.all(np.isfinite(a2))):
        reached = math.inf
    return Outcome(
        asked=rtol + _ROUNDING,
        reached=reached,
        converged=solution.status.name == "CONVERGED",
        invariants={"v0 does not grow": (_growth(speed), max(_GROWTH, 0.1 * rtol))},
    )


def _first_moments(label: str) -> tuple[float, float] | None:
    """sqrt(<v^2>) and <v^4>/(2 <v^2>^2) of a start, by hand."""
    second, fourth = {
        "monoenergetic": (1.0, 1.0),
        "beam": (1.0, 1.0),
        "gaussian": (2.0, 8.0),
        "two delta peaks": ((1.0 + 1e-4) / 2.0, (1.0 + 1e-8) / 2.0),
        "speeds 1e-100 and 1": (0.5, 0.5),
        "two temperatures, 1e-3 and 1": (1.0 + 1e-6, 3.0 + 2e-6 + 3e-12),
        "tail v^-6": (2.0 / 3.0, 8.0 / 3.0),
        "narrow triangle": (1.0 + 1e-12 / 6.0, 1.0 + 1e-12),
    }.get(label, (0.0, 0.0))
    if not second:
        return None
    return math.sqrt(second), fourth / (2.0 * second**2)


_DENSITY_TIMES = np.array([0.5, 30.0, 1e3])


def _density(e: float, label: str, method: str | None, nodes: int | None) -> Outcome:
    """Mass and positivity of the speed density, and <v^2> of it against the averages."""
    from kinetics import Scene, solve

    rtol = 1e-6
    scene = Scene(
        e, initial=starts()[label], times=_DENSITY_TIMES, outputs=("speed_density", "thermal_speed")
    )
    solution = solve(scene, rtol, method=method, nodes=nodes)
    mass: list[float] = []
    low: list[float] = []
    energy: list[float] = []
    for i, v0 in enumerate(solution.thermal_speed):
        v = v0 * np.geomspace(1e-8, 1e3, 10_001)
        f = solution.speed_density(v)[i]
        step = math.log(v[1] / v[0])
        mass.append(float((f * v).sum()) * step)
        energy.append(float((f * v**3).sum()) * step / v0**2)
        low.append(max(0.0, -float(f.min()) / float(f.max())))
    if label == "tail v^-6":  # its energy reaches to where the density is 1e-9 of the maximum
        energy = [1.0] * len(mass)
    finite = np.all(np.isfinite([*mass, *energy]))
    converged = solution.status.name == "CONVERGED"
    reached = float(np.max(np.abs(np.array([mass, energy]) - 1.0))) if finite else math.inf
    return Outcome(
        # rtol is of the maximum of the density; integrals up to c = 3 with c^2 gather more of it
        asked=30.0 * rtol,
        reached=reached,
        converged=converged,
        invariants={"density not negative": (max(low), rtol if converged else math.inf)},
        note=f"estimate {solution.error_estimate:.0e}",
    )


def _conservative(e: float, label: str, nodes: int) -> Outcome:
    """The conservative scheme: density not negative, its mass, and <v^2> as averaged.

    At the tightest tolerance the scheme itself serves all of the times. The density is linear in
    ln v between nodes: its integrals by the trapezoid rule with many points for each node.
    """
    from kinetics import Scene, solve

    scene = Scene(
        e, initial=starts()[label], times=_DENSITY_TIMES, outputs=("thermal_speed", "speed_density")
    )
    solution = solve(scene, 1e-13, method="conservative", nodes=nodes)
    v0 = solution.thermal_speed
    v = np.geomspace(1e-8 * v0[-1], 1e6 * v0[0], 200_001)
    f = solution.speed_density(v)
    weight = f * v * math.log(v[1] / v[0])
    mass = weight.sum(axis=1) + solution.uncollided
    energy = weight @ v**2 + solution.uncollided
    finite = np.all(np.isfinite(f))
    found = np.abs([energy / v0**2 - 1.0, mass - 1.0])
    estimate = solution.error_estimate
    return Outcome(
        # the interpolation between nodes adds to the scheme's own error
        asked=max(3.0 * estimate, 1e-5) if estimate < 1.0 else math.inf,
        reached=float(np.max(found)) if finite else math.inf,
        invariants={
            "density not negative": (max(0.0, -float(f.min())), 0.0),
            # no number of nodes reaches 1e-13
            "status says so": (float(solution.status.name == "CONVERGED"), 0.0),
        },
        note=f"estimate {estimate:.0e}",
    )


# -- random cases -------------------------------------------------------------------------------


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
    state, first = {
        "gaussian": (Gaussian(scale, scale), (math.sqrt(2.0), 0.0)),
        "monoenergetic": (Monoenergetic(scale), (1.0, -0.5)),
        # <v^2> = 10.5, <v^4> = 176.625
        "samples": (SpeedSamples(scale * np.array([1.0, 2.0, 4.0, 4.5826])), (0.0, 0.0)),
    }[arguments["start"]]
    if arguments["start"] == "samples":
        v = np.array([1.0, 2.0, 4.0, 4.5826])
        first = (math.sqrt(np.mean(v**2)), float(np.mean(v**4) / (2 * np.mean(v**2) ** 2)) - 1.0)
    times = np.array([0.0, *arguments["times"]])
    scene = Scene(
        e, arguments["number_density"], initial=state, times=times, outputs=("thermal_speed", "a2")
    )
    solution = solve(scene, rtol)
    speed, a2 = solution.thermal_speed, solution.a2
    path = scene.mean_free_path
    reached = _compare_limits(e, speed, a2, times, path, (first[0] * scale, first[1]), rtol)
    if not (np.all(np.isfinite(speed)) and np.all(np.isfinite(a2)) and np.all(speed > 0.0)):
        reached = math.inf
    return Outcome(
        asked=rtol + _ROUNDING,
        reached=reached,
        converged=solution.status.name == "CONVERGED",
        invariants={"v0 does not grow": (_growth(speed), max(_GROWTH, rtol))},
    )
