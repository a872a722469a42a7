"""Cases of the averages of the speed: restitutions, times to 1e300, sizes, rough starts, nodes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache
from typing import Any

import numpy as np

from kinetics.crosscheck import references
from kinetics.crosscheck.stress.case import Case, Outcome
from kinetics.crosscheck.stress.limits import (
    FEWER,
    GROWTH,
    RESTITUTIONS,
    ROUNDING,
    TIMES,
    FloatArray,
    Law,
    as_law,
    below,
    difference,
    finite,
    forgets,
    growth,
    label_of,
    limit_errors,
    other_laws,
    scaling,
)
from kinetics.crosscheck.stress.starts import first_averages, quadrature, solve_start, starts

AVERAGES = ("thermal_speed", "a2")
_SCALED_SPEEDS = np.geomspace(1e-3, 30.0, 400)
_CLOSED_FORM = 1e-12  # what ScalingSolution.vdf promises


def scaled_cases(quick: bool) -> Iterator[Case]:
    """The scaled equation, with a tolerance or with the nodes given."""
    for e in FEWER if quick else RESTITUTIONS:
        if e == 1.0:  # refused: there is no scaling state
            continue
        for rtol in (1e-4, 1e-12) if quick else (1e-1, 1e-3, 1e-6, 1e-9, 1e-12, 1e-13):
            yield Case("scaled equation", f"{label_of(e)}, rtol {rtol:.0e}", _scaled, (e, rtol))
    for law in other_laws(quick):
        for rtol in () if law.is_elastic else (1e-4, 1e-12):
            yield Case("scaled equation", f"{label_of(law)}, rtol {rtol:.0e}", _scaled, (law, rtol))
    few = (0.0, 0.2, 0.7, 0.99)
    for e in few if quick else (0.0, 1e-10, 0.2, 0.7, 0.99, 1.0 - 1e-10):
        for nodes in (8, 16, 64, 256) if quick else (8, 12, 16, 32, 64, 256, 1024, 4096):
            name = f"{label_of(e)}, {nodes} nodes"
            yield Case("scaled equation, nodes given", name, _scaled, (e, 1e-12, nodes))


def cooling_cases(quick: bool) -> Iterator[Case]:
    """v0(t) and a2(t), in groups."""
    some = FEWER if quick else RESTITUTIONS
    sizes = [(start, "scale", v) for start in references.STARTS for v in (1e-150, 1.0, 1e150)]
    sizes += [("gaussian", n, x) for n in ("number_density", "diameter") for x in (1e-150, 1e150)]
    for e in some:
        for start, what, value in sizes:
            # refused: elastic tracers do not slow down, v t/l overflows
            if e < 1.0 or value <= 1.0:
                name = f"{label_of(e)}, {start}, {what} {value:g}, t to 1e300"
                yield Case("cooling", name, _cooling, (e, start, {what: value}, 1e-9))
    for e in (0.0, 0.2, 0.7, 0.99):
        for rtol in (0.1, 1e-3, 1e-6, 1e-12, 1e-13):
            name = f"{label_of(e)}, kept references, rtol {rtol:.0e}"
            yield Case("cooling", name, _kept, (e, rtol))
    for e in (0.0, 0.2, 1.0 - 1e-6) if quick else some:
        for label in starts():
            yield Case("starts", f"{label_of(e)}, {label}", _rough, (e, label, 1e-8))
    for law in other_laws(quick):
        for start in references.STARTS:
            name = f"{label_of(law)}, {start}, t to 1e300"
            yield Case("cooling", name, _cooling, (law, start, {"scale": 1.0}, 1e-9))
        name = f"{label_of(law)}, two delta peaks"
        yield Case("starts", name, _rough, (law, "two delta peaks", 1e-8))


@lru_cache(maxsize=2)
def _scaled_vdf(e: Law) -> FloatArray:
    """F at the scaled speeds, in closed form."""
    from kinetics import ScalingSolution

    return np.asarray(ScalingSolution(**as_law(e).arguments).vdf(_SCALED_SPEEDS))


def _scaled(e: Law, rtol: float, nodes: int | None = None) -> Outcome:
    """h, a2 and F, relative to itself, against closed forms; norm, <c^2> = 1 and positivity of F.

    The status is that of all three: F at large c is what misses a tolerance first.
    """
    from kinetics import solve_scaled

    state = solve_scaled(as_law(e), rtol, nodes)
    h, one_a2, *_ = scaling(e)
    F, exact = state.vdf(_SCALED_SPEEDS), _scaled_vdf(e)
    reached = max(abs(state.cooling_rate / h - 1.0), abs((1.0 + state.a2) / one_a2 - 1.0))
    seen = exact > 1e-290  # rounded numbers below
    reached = max(reached, float(np.abs(F[seen] / exact[seen] - 1.0).max(initial=0.0)))
    estimate, converged = state.error_estimate, state.status.name == "CONVERGED"
    claimed = max(rtol, 1e-12) if converged else math.inf
    return Outcome(
        asked=rtol,
        reached=reached if finite(reached, F) else math.inf,
        converged=converged,
        known_to=_CLOSED_FORM,
        invariants={
            "F not negative": (below(F), 0.0),
            "<c^2> = 1": (abs(state.moment(2.0) - 1.0), claimed),
            "<c^0> = 1": (abs(state.moment(0.0) - 1.0), claimed),
        },
        note=f"estimate {estimate:.1e}",
    )


def _outcome(
    solution: Any, rtol: float, reached: float, grown: float, **more: tuple[float, float]
) -> Outcome:
    """What v0 and a2 keep at all times; grown: relative growth that is allowed."""
    d = solution.scene.dimension
    return Outcome(
        asked=rtol + ROUNDING,
        reached=reached,
        converged=solution.status.name == "CONVERGED",
        in_part=not forgets(solution.scene.law),  # no limits of late times
        invariants={
            "v0 does not grow": (growth(solution.thermal_speed), grown),
            # there is no distribution below: <v^4> >= <v^2>^2
            "a2 >= -2/(d + 2)": (below(solution.a2, -2.0 / (d + 2.0)), rtol),
            "<v^0> = 1": (float(np.max(np.abs(solution.moment(0.0) - 1.0))), rtol),
            **more,
        },
    )


def _cooling(e: Law, start: str, sizes: dict[str, float], rtol: float) -> Outcome:
    """v0 and a2 against their limits at early and at late times."""
    from kinetics import Gaussian, Monoenergetic, Scene, solve

    scale = sizes.get("scale", 1.0)
    medium: dict[str, Any] = {name: size for name, size in sizes.items() if name != "scale"}
    state = Gaussian(scale, scale) if start == "gaussian" else Monoenergetic(scale)
    outputs: tuple[str, ...] = (*AVERAGES, "temperature", "collisions")
    law = as_law(e)
    if not law.is_elastic and sizes == {"scale": 1.0}:  # else <r^2> leaves the range of doubles
        outputs = (*outputs, "msd")
    solution = solve(Scene(law, initial=state, times=TIMES, outputs=outputs, **medium), rtol)
    d = law.dimension
    first = (math.sqrt(d) * scale, 0.0) if start == "gaussian" else (scale, d / (d + 2.0) - 1.0)
    seen = solution.thermal_speed > 1e-150  # its square is no rounded number
    with np.errstate(under="ignore"):
        square = solution.thermal_speed[seen] ** 2
        energy = np.abs(d * solution.temperature[seen] / square - 1.0)
    known = finite(*(getattr(solution, name) for name in outputs))
    collisions = solution.collisions[np.isfinite(solution.collisions)]
    fall = float(np.max(-np.diff(collisions), initial=0.0)) / max(collisions.max(), 1e-300)
    return _outcome(
        solution,
        rtol,
        limit_errors(solution, first, rtol) if known else math.inf,
        GROWTH,
        **{
            "collisions do not fall": (fall, 10.0 * rtol),
            "T = v0^2/d": (float(np.max(energy, initial=0.0)), 1e-13),
        },
    )


def _kept(e: float, rtol: float) -> Outcome:
    """v0 and a2 against the kept references, both starts, both horizons."""
    outcomes = []
    for start in references.STARTS:
        for horizon in references.HORIZONS:
            solution = solve_start(e, start, references.times(horizon), AVERAGES, rtol)
            exact = (references.kept(name, e, start, horizon) for name in AVERAGES)
            reached = difference(solution.thermal_speed, solution.a2, *exact)
            outcomes.append(_outcome(solution, rtol, reached, max(GROWTH, rtol)))
    worst = max(outcomes, key=lambda outcome: outcome.reached)
    grown = max(outcome.invariants["v0 does not grow"] for outcome in outcomes)
    converged = all(outcome.converged for outcome in outcomes)
    return Outcome(worst.asked, worst.reached, converged, invariants={"v0 does not grow": grown})


def mixture(e: Law, label: str, times: FloatArray) -> tuple[FloatArray, FloatArray]:
    """v0 and a2 of a start as the mean over its speeds, of a monoenergetic one at scaled times.

    The equation is linear, and speeds times s are times divided by s. Shape (n_times,) each.
    """
    v, w = quadrature(label)
    gaussian = 1.0 + 2.0 / as_law(e).dimension
    paths = np.outer(times, v)
    known, where = np.unique(paths, return_inverse=True)
    one = solve_start(e, "monoenergetic", known, AVERAGES, 1e-13)
    with np.errstate(under="ignore"):
        square = (one.thermal_speed**2)[where].reshape(paths.shape)
        fourth = gaussian * square**2 * (1.0 + one.a2[where].reshape(paths.shape))
        second, fourth = square @ (w * v**2), fourth @ (w * v**4)
    return np.sqrt(second), fourth / gaussian / second**2 - 1.0


def _rough(e: Law, label: str, rtol: float) -> Outcome:
    """v0 and a2 of a rough start: first value, mixture at all times, and late limit."""
    solution = solve_start(e, label, TIMES, AVERAGES, rtol)
    speed, a2 = solution.thermal_speed, solution.a2
    # fourth powers of late speeds of 1e-30 and less underflow in the mixture
    middle = (TIMES > 0.0) & (TIMES <= 1e30)
    reached = difference(speed[middle], a2[middle], *mixture(e, label, TIMES[middle]))
    # the first time and the last: by then, speeds of 1e-150 have met 1e140 scatterers
    ends = slice(None, None, TIMES.size - 1)
    first = first_averages(label, as_law(e).dimension)
    reached = max(reached, limit_errors(solution, first, rtol, ends))
    known = reached if finite(speed, a2) else math.inf
    return _outcome(solution, rtol, known, max(GROWTH, 0.1 * rtol))
