"""Error asked against error reached, over rtol from 1e-3 to 1e-12 and every kept reference."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from kinetics.crosscheck.bench import references
from kinetics.crosscheck.bench.methods import NUMBER_DENSITY, SPECTRAL
from kinetics.crosscheck.bench.precision import SCALED_SPEEDS, relative
from kinetics.crosscheck.bench.record import Record, failed
from kinetics.crosscheck.bench.timing import Effort

SECTION = "accuracy"
TOLERANCES = tuple(10.0**-k for k in range(3, 13))
_QUANTITIES = {
    "thermal_speed": "v0(t)",
    "a2": "1 + a2(t)",
    "msd": "<r^2>(t)",
    "kurtosis": "kurtosis(t)",
}
AGREE = 100.0  # asked and reached may differ by this factor

WITHIN = "within a factor 100"
MISSED, MISSED_AND_SAID = "missed without a word", "missed, and the status says so"
BETTER = "more than 100 times better than asked"


def verdict(asked: float, reached: float, converged: bool) -> str:
    """What a pair of errors comes to; `converged` is what the solver's status claims."""
    if not reached <= asked:
        return MISSED if converged else MISSED_AND_SAID
    return WITHIN if reached * AGREE >= asked else BETTER


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
    from kinetics import Scene, solve

    for start in references.STARTS:
        for horizon in references.HORIZONS:
            times = references.times(horizon)
            for quantity, shown in _QUANTITIES.items():
                if quantity in ("msd", "kurtosis") and horizon == "long":
                    continue
                exact = references.reference(quantity, e, start, horizon)
                shift = 1.0 if quantity == "a2" else 0.0
                scene = Scene(e, NUMBER_DENSITY, initial=start, times=times, outputs=(quantity,))

                def run(
                    rtol: float,
                    scene: Scene = scene,
                    quantity: str = quantity,
                    target: np.ndarray = shift + exact,
                    shift: float = shift,
                ) -> tuple[float, bool]:
                    solution = solve(scene, rtol)
                    error = relative(shift + getattr(solution, quantity), target)
                    return error, solution.status.name == "CONVERGED"

                yield f"{shown}, {start}, t <= {times[-1]:.0e}, e = {e:g}", run


def problems(effort: Effort) -> Iterator[Problem]:
    """All that have a reference."""
    for e in (0.0, 0.7, 0.99) if effort.quick else references.RESTITUTIONS:
        yield from _scaled(e)
        yield from _in_time(e)


def accuracy(effort: Effort) -> list[Record]:
    """A row per problem and rtol; `extra` holds the verdict."""
    rows = []
    for name, run in problems(effort):
        for rtol in TOLERANCES:
            where: dict[str, Any] = {"setting": "rtol", "value": rtol, "asked": rtol}
            try:
                error, converged = run(rtol)
            except Exception as met:  # whatever it is, it is a row
                why = f"{type(met).__name__}: {met}"
                rows.append(failed(SECTION, name, SPECTRAL, why, **where))
                continue
            said = verdict(rtol, error, converged)
            more = {"converged": converged, "ratio": error / rtol}
            rows.append(
                Record(SECTION, name, SPECTRAL, error=error, note=said, extra=more, **where)
            )
    return rows
