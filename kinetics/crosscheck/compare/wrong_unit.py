"""Units that do not belong together: before a collision r = v t, whatever the scatterers.

It is looked for before all causes; where it is found no cause is looked for. A drift of the whole
gas would look like a wrong clock.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from kinetics.crosscheck.compare.causes import NEAR_BEST
from kinetics.crosscheck.compare.fit import Fit, compare_with_point, fit
from kinetics.crosscheck.compare.parameters import coordinates_of, free_parameter
from kinetics.crosscheck.compare.point import Point
from kinetics.crosscheck.compare.pool import N_FOR_CAUSE
from kinetics.crosscheck.compare.result import Explanation
from kinetics.crosscheck.words import Verdict, numeral

#: |ln(r/(v t))| above which a unit, or the clock, is wrong: straight flights are counted within
#: 0.002 of each other.
WRONG_ABOVE = 0.005


@dataclass(frozen=True)
class _Reading:
    """What the ratio may come from: the number that it gives, and how that is said."""

    name: str
    value: float
    clause: str
    changes: dict[str, Any] = field(default_factory=dict)


def wrong_unit(fits: Sequence[Fit]) -> Explanation | None:
    """Return what is said where units do not belong together; None where they do.

    Which unit it is, the averages say that are left with the value that the ratio gives: all that
    are near the best are named.
    """
    first = fits[0]
    sample = first.measured.sample
    time, ratio = sample.flights
    if not sample.has_velocities or sample.law.field or sample.law.is_driven:
        return None
    if abs(math.log(ratio)) <= WRONG_ABOVE:
        return None
    readings = _readings(first, time, ratio)
    costs: dict[str, float] = {}
    for fitted in fits:
        for reading in readings:
            changed = _fit_with(fitted, fitted.point.with_values(**reading.changes))
            if changed is None or changed.chi_square is None:
                continue
            if changed.chi_square.verdict is not Verdict.DIFFERS:
                costs[reading.name] = min(changed.criterion, costs.get(reading.name, math.inf))
    if "speed unit" in costs and first.point.has_own_start:  # no start but a Gaussian is needed
        costs.pop("time unit", None)
    possible = _near_best(readings, costs)
    unit_of_time = sample.units.get("time", 1.0)
    headline = (
        f"tracers that fly straight have r = {numeral(ratio, '.5g')} v t at t = "
        f"{numeral(time * unit_of_time, '.4g')}, as if "
        f"{' or '.join(reading.clause for reading in possible)}"
    )
    text = (
        f"{headline}; shift the times, or say --time-unit, --length-unit or --speed-unit. No other "
        "cause is looked for."
    )
    value = possible[0].value
    return Explanation(possible[0].name, "found", text, True, value, headline=headline)


def _readings(fitted: Fit, time: float, ratio: float) -> list[_Reading]:
    """Return what may be wrong: the clock, or one of the units."""
    unit_of_time = fitted.measured.sample.units.get("time", 1.0)
    ahead = time * (1.0 - ratio) * unit_of_time
    too_large = numeral(1.0 / ratio, ".5g")
    of_speed: dict[str, Any] = {"speed_unit": 1.0 / ratio, "time_unit": 1.0 / ratio}
    if fitted.point.has_own_start:  # the times are right, and a Gaussian may be the start
        of_speed["start"] = "gaussian"
    return [
        _Reading(
            "time offset",
            ahead,
            f"the clock were {numeral(ahead, '.4g')} ahead",
            {"time_offset": time * (ratio - 1.0)},
        ),
        _Reading(
            "time unit",
            1.0 / ratio,
            f"times were {too_large} times too long",
            {"time_unit": 1.0 / ratio},
        ),
        _Reading("speed unit", 1.0 / ratio, f"speeds were {too_large} times too high", of_speed),
        _Reading(
            "length unit",
            ratio,
            f"lengths were {numeral(ratio, '.5g')} times too long",
            {"length_unit": ratio},
        ),
    ]


def _fit_with(fitted: Fit, point: Point) -> Fit | None:
    """Return the fit with some numbers of its point changed."""
    if not fitted.free:
        return compare_with_point(fitted.measured, point, N_FOR_CAUSE)
    free = [free_parameter(name, point, fitted.measured) for name in fitted.names]
    start = coordinates_of(point, free).tolist()
    return fit(fitted.measured, point, free, [start], n_pool=N_FOR_CAUSE)


def _near_best(readings: Sequence[_Reading], costs: dict[str, float]) -> list[_Reading]:
    """Return the readings that explain best, the best one first; all if none does."""
    limit = min(costs.values(), default=0.0) + NEAR_BEST
    near = [reading for reading in readings if costs.get(reading.name, math.inf) < limit]
    near.sort(key=lambda reading: costs[reading.name])
    return near or list(readings)
