"""Run time against error in a uniform field: the steady state, and averages over time from rest.

Error measures, relative: the largest of drift, <v^2>, <v_x^2> and <v> of the steady state; the
largest of <v_x> and <x> over the times. References: at e = 0.7 digits of programs of their own, at
other restitutions `solve_field` at its smallest tolerance.
"""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np

from kinetics import Scene, solve, solve_field
from kinetics.crosscheck.bench.measuring import Effort, Work, measure, sweep
from kinetics.crosscheck.bench.methods import NUMBER_DENSITY, SPECTRAL
from kinetics.crosscheck.bench.precision import relative, restitutions
from kinetics.crosscheck.bench.record import PRECISION, Record
from kinetics.crosscheck.references import MEAN_FREE_PATH

_TIGHTEST = 1e-12
_STEADY = {0.7: (0.501926119920, 1.702146383757, 1.061388235142, 1.160252548014)}
_E, _TIMES = 0.7, (0.1, 0.5, 2.0, 5.0)  # sqrt(l/g)
_VELOCITY = (0.09962311, 0.45545144, 0.62108221, 0.50135393)  # sqrt(g l)
_WAY = (0.004990570, 0.119322259, 1.11237376, 2.66810824)  # l


def field(effort: Effort) -> list[Record]:
    """All rows."""
    works = [work for e in restitutions(effort) for work in _steady(e)]
    return measure([*works, *_from_rest(effort)], effort)


def _steady(e: float) -> list[Work]:
    def figures(rtol: float) -> tuple[float, ...]:
        found = solve_field(e, rtol=rtol)
        return found.drift, found.mean_square_speed, found.mean_square_along, found.mean_speed

    exact = np.array(_STEADY[e] if e in _STEADY else figures(_TIGHTEST))
    return sweep(
        PRECISION,
        f"field, steady state, e = {e:g}",
        SPECTRAL,
        "rtol",
        tuple(10.0**-k for k in range(2, 11)),
        figures,
        error=lambda found: relative(found, exact),
    )


def _from_rest(effort: Effort) -> list[Work]:
    g = 0.01
    speed, time = math.sqrt(g * MEAN_FREE_PATH), math.sqrt(MEAN_FREE_PATH / g)
    outputs = ("mean_velocity", "mean_displacement")
    scene = partial(Scene, _E, NUMBER_DENSITY, initial="rest", outputs=outputs, field=g)

    def averages(rtol: float) -> Any:
        found = solve(scene(times=np.array(_TIMES) * time), rtol)
        way = found.mean_displacement[:, 0] / MEAN_FREE_PATH
        return np.array([found.mean_velocity[:, 0] / speed, way])

    exact = np.array([_VELOCITY, _WAY])
    return sweep(
        PRECISION,
        f"field, from rest to t = 5 sqrt(l/g), e = {_E:g}",
        SPECTRAL,
        "rtol",
        tuple(10.0**-k for k in range(2, 6 if effort.quick else 8)),
        averages,
        error=lambda found: relative(found, exact),
    )
