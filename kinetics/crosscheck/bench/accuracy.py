"""Error asked against error reached, over rtol from 1e-3 to 1e-12 and every kept reference."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from kinetics.crosscheck import references
from kinetics.crosscheck.bench.measuring import Effort
from kinetics.crosscheck.bench.methods import NUMBER_DENSITY, SPECTRAL
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


# a problem: its name, and a function of rtol that gives the error and whether it is claimed
Problem = tuple[str, Callable[[float], tuple[float, bool]]]


def _scaled(e: float) -> Iterator[Problem]:
    from kinetics import ScalingSolution, solve_scaled

    exact = ScalingSolution(e)
    F = exact.vdf(SCALED_SPEEDS)
    powers = (-0.5, 1.0, 3.0, 4.0, 6.0, 8.0)

    def moments(rtol: float) -> tuple[float, bool]:
        state = solve_scaled(e, rtol)
        errors = [relative(state.cooling_rate, exact.cooling_rate)]
        errors += [relative(state.moment(p), exact.moment(p)) for p in powers]
        return max(errors), state.status.name == "CONVERGED"

    def density(rtol: float) -> tuple[float, bool]:
        # F is promised relative to itself, wherever it is not below 1e-25 of its maximum
        state = solve_scaled(e, rtol)
        there = F / F.max() > 1e-25
        error = relative(state.vdf(SCALED_SPEEDS[there]), F[there])
        return error, state.status.name == "CONVERGED"

    yield f"scaled h and moments, e = {e:g}", moments
    yield f"scaled F(c), e = {e:g}", density


def _in_time(e: float) -> Iterator[Problem]:
    for start in references.STARTS:
        for horizon in references.HORIZONS:
            for quantity, shown in QUANTITIES.items():
                if quantity in ("msd", "kurtosis") and horizon == "long":
                    continue
                last = references.times(horizon)[-1]
                name = f"{shown}, {start}, t <= {last:.0e}, e = {e:g}"
                yield name, partial(_error_in_time, e, start, horizon, quantity)


def _error_in_time(
    e: float, start: str, horizon: str, quantity: str, rtol: float
) -> tuple[float, bool]:
    """Error at the kept times, of a2 relative to 1 + a2, and whether the status claims rtol."""
    from kinetics import Scene, solve

    times = references.times(horizon)
    scene = Scene(e, NUMBER_DENSITY, initial=start, times=times, outputs=(quantity,))
    solution = solve(scene, rtol)
    shift = 1.0 if quantity == "a2" else 0.0
    exact = shift + references.kept(quantity, e, start, horizon)
    error = relative(shift + np.asarray(getattr(solution, quantity)), exact)
    return error, solution.status.name == "CONVERGED"


def accuracy(effort: Effort) -> list[Record]:
    """A row per problem and rtol; its note is the verdict."""
    rows = []
    for e in (0.0, 0.7, 0.99) if effort.quick else references.RESTITUTIONS:
        for name, run in (*_scaled(e), *_in_time(e)):
            for rtol in TOLERANCES:
                where: dict[str, Any] = {"setting": "rtol", "value": rtol, "asked": rtol}
                try:
                    error, converged = run(rtol)
                except Exception as met:  # whatever it is, it is a row
                    rows.append(failed(ACCURACY, name, SPECTRAL, met, **where))
                    continue
                note = verdict(rtol, error, converged)
                extra = {"converged": converged, "ratio": error / rtol}
                rows.append(
                    Record(ACCURACY, name, SPECTRAL, error=error, note=note, extra=extra, **where)
                )
    return rows
