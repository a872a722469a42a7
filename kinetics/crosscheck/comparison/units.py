"""Whether positions, speeds and times of the data are in units that belong together.

A tracer that has not collided is at r = v t: in units that belong together |r|/(|v| t) is 1 for
each of them, whatever the scatterers and the restitution. For those that have collided it is spread
over many values. So the value that many tracers share tells the unit, without any theory.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.comparison.result import Explanation, said
from kinetics.crosscheck.comparison.sample import V2, Flights, N, Sample

Array = NDArray[np.float64]

_SAME = 2e-3
"""Width in ln(|r|/(|v| t)) within which tracers fly alike: numbers may have few digits."""
_LEAST_SHARE, _FEWEST = 0.05, 20
"""Tracers that must fly alike. Those that have collided put some 0.5 % into such a width."""
_FAR, _MOST = 2.0, 0.5
"""Factor by which speeds are in another unit, and the share of tracers that have not collided."""
_WRONG_ABOVE = 0.005
"""|ln(|r|/(|v| t))| from which on units do not belong together."""


def straight_flights(time: float, distance: Array, speed: Array) -> Flights | None:
    """The ratio |r|/(|v| t) that most tracers share at one time; None where too few share one.

    distance, speed (n,): of tracers at this time, in units of the data.
    """
    moving = (distance > 0) & (speed > 0)
    if time <= 0 or np.count_nonzero(moving) < _FEWEST:
        return None
    with np.errstate(over="ignore", under="ignore", divide="ignore"):
        ratio = np.log(distance[moving]) - np.log(speed[moving]) - np.log(time)
    ratio = np.sort(ratio)
    alike = np.searchsorted(ratio, ratio + _SAME) - np.arange(ratio.size)
    first = int(np.argmax(alike))
    count = int(alike[first])
    if count < max(_FEWEST, _LEAST_SHARE * distance.size):
        return None
    middle = float(np.exp(np.median(ratio[first : first + count])))
    return Flights(time, middle, count / distance.size)


def wrong_unit(sample: Sample) -> Explanation | None:
    """What is said where units do not belong together; None where they do, or cannot be known."""
    flights = sample.flights
    if flights is None or abs(np.log(flights.ratio)) < _WRONG_ABOVE:
        return None
    return Explanation(
        "time unit", "found", said("wrong_unit", flights=flights), True, 1 / flights.ratio,
        headline=said("wrong_unit_headline", flights=flights),
    )  # fmt: skip


def wrong_speeds(sample: Sample, start: Any) -> Explanation | None:
    """What is said where the first speeds are far from those of a named start; or None.

    Speeds never rise, so that larger ones than at the start cannot be. Smaller ones cannot be while
    most tracers have not collided. A factor of two is asked for: less may be another start.
    """
    if not isinstance(start, str):
        return None
    most = np.sqrt(sample.law.dimension) if start == "gaussian" else 1.0
    total = sample.sums[:, 0].sum(axis=0)
    ratio = float(sample.speed_scale[0] * np.sqrt(total[V2] / total[N]) / most)
    flights = sample.flights
    early = flights is not None and flights.share > _MOST and flights.time <= sample.times[:2].max()
    if not (ratio > _FAR or (ratio < 1 / _FAR and early)):
        return None
    text = said("wrong_speeds", ratio=ratio, time=sample.times[0], most=most)
    headline = f"speeds at the first time are {ratio:.4g} times those of the start"
    return Explanation("speed unit", "found", text, True, ratio, headline=headline)
