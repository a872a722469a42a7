"""Error asked against error reached, over rtol from 1e-3 to 1e-12 and every kept reference."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from kinetics import ScalingSolution, Scene, solve, solve_scaled
from kinetics.crosscheck import references
from kinetics.crosscheck.bench.measuring import Effort
from kinetics.crosscheck.bench.methods import NUMBER_DENSITY, OTHER_LAWS, SPECTRAL
from kinetics.crosscheck.bench.precision import QUANTITIES, SCALED_SPEEDS, relative
from kinetics.crosscheck.bench.record import ACCURACY, Record, failed

TOLERANCES = tuple(10.0**-k for k in range(3, 13))
FACTOR = 100.0  # asked and reached may differ by this factor

WITHIN = "within a factor 100"
MISSED = "missed, and the status claims that it was reached"
MISSED_AND_SAID = "missed, and the status says so"
BETTER = "more than 100 times better than asked"


def verdict(asked: float, reached: float, converged: bool) -> str:
    """How the error reached compares with the one asked; `converged` is what the status claims."""
    if not reached <= asked:
        return MISSED if converged else MISSED_AND_SAID
    return WITHIN if reached * FACTOR >= asked else BETTER


Run = Callable[[float], tuple[Any, float]]
"""What a problem is: a function of rtol that gives the solution and the error that it reached."""


def _scaled(e: float, name: str = "", **law: Any) -> dict[str, Run]:
    exact = ScalingSolution(e, **law)
    F = exact.vdf(SCALED_SPEEDS)
    there = F / F.max() > 1e-25  # where F is promised relative to itself
    powers = (-0.5, 1.0, 3.0, 4.0, 6.0, 8.0)

    def moments(rtol: float) -> tuple[Any, float]:
        state = solve_scaled(e, rtol, **law)
        errors = [relative(state.cooling_rate, exact.cooling_rate)]
        return state, max(errors + [relative(state.moment(p), exact.moment(p)) for p in powers])

    def density(rtol: float) -> tuple[Any, float]:
        state = solve_scaled(e, rtol, **law)
        return state, relative(state.vdf(SCALED_SPEEDS[there]), F[there])

    which = f"{name}, e = {e:g}" if name else f"e = {e:g}"
    return {f"scaled h and moments, {which}": moments, f"scaled F(c), {which}": density}


def _late(e: float, name: str, **law: Any) -> dict[str, Run]:
    """v0, a2 and the slope of <r^2> so late that they are the limits of the closed forms."""
    exact, last = ScalingSolution(e, **law), 1e30
    outputs = ("thermal_speed", "a2", "diffusion_coefficient")
    scene = Scene(e, times=[1.0, last], outputs=outputs, **law)
    path = scene.mean_free_path
    speed, slope = 2.0 * path / (exact.cooling_rate * last), exact.diffusion_slope * path**2

    def averages(rtol: float) -> tuple[Any, float]:
        found = solve(scene, rtol)
        pairs = [(found.thermal_speed[1], speed), (1.0 + found.a2[1], 1.0 + exact.a2)]
        pairs.append((found.msd_slope[1], slope))
        return found, max(relative(value, limit) for value, limit in pairs)

    return {f"late v0, a2 and slope of <r^2>, {name}, e = {e:g}": averages}


def _in_time(e: float) -> dict[str, Run]:
    return {
        f"{shown}, {start}, t <= {references.times(horizon)[-1]:.0e}, e = {e:g}": partial(
            _error_in_time, e, start, horizon, quantity
        )
        for start in references.STARTS
        for horizon in references.HORIZONS
        for quantity, shown in QUANTITIES.items()
        if horizon == "short" or quantity in ("thermal_speed", "a2")
    }


def _error_in_time(
    e: float, start: str, horizon: str, quantity: str, rtol: float
) -> tuple[Any, float]:
    """The solution, and its error at the kept times, that of a2 relative to 1 + a2."""
    times = references.times(horizon)
    scene = Scene(e, NUMBER_DENSITY, initial=start, times=times, outputs=(quantity,))
    solution = solve(scene, rtol)
    shift = 1.0 if quantity == "a2" else 0.0
    exact = shift + references.kept(quantity, e, start, horizon)
    return solution, relative(shift + np.asarray(getattr(solution, quantity)), exact)


def accuracy(effort: Effort) -> list[Record]:
    """A row per problem and rtol; its note is the verdict."""
    restitutions = (0.0, 0.7, 0.99) if effort.quick else references.RESTITUTIONS
    problems = [item for e in restitutions for item in (_scaled(e) | _in_time(e)).items()]
    for e in (0.0, 0.7) if effort.quick else (0.0, 0.2, 0.7, 0.95):
        for name, law in OTHER_LAWS.items():
            problems += (_scaled(e, name, **law) | _late(e, name, **law)).items()
    return [_row(name, run, rtol) for name, run in problems for rtol in TOLERANCES]


def _row(name: str, run: Run, rtol: float) -> Record:
    where: dict[str, Any] = {"setting": "rtol", "value": rtol, "asked": rtol}
    try:
        solution, error = run(rtol)
    except Exception as met:  # whatever it is, it is a row
        return failed(ACCURACY, name, SPECTRAL, met, **where)
    converged = solution.status.name == "CONVERGED"
    extra = {"converged": converged, "ratio": error / rtol}
    note = verdict(rtol, error, converged)
    return Record(ACCURACY, name, SPECTRAL, error=error, note=note, extra=extra, **where)
