"""Whether positions, speeds and times of the data are in units that belong together.

A tracer that has not collided is at r = v t: in units that belong together |r|/(|v| t) is 1 for
each of them, whatever the scatterers and the restitution. For those that have collided it is spread
over many values. So the value that many tracers share tells the unit, without any theory.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.comparison.result import Explanation, said
from kinetics.crosscheck.comparison.sample import R2, V2, Flights, N, Sample
from kinetics.crosscheck.comparison.statistics import errors
from kinetics.crosscheck.verdicts import DIFFERS_ABOVE

Array = NDArray[np.float64]

_SAME = 2e-3
"""Width in ln(|r|/(|v| t)) within which tracers fly alike: numbers may have few digits."""
_LEAST_SHARE, _FEWEST = 0.05, 20
"""Tracers that must fly alike. Those that have collided put some 0.5 % into such a width."""
_FAR, _MOST = 2.0, 0.5
"""Factor by which speeds are in another unit, and the share of tracers that have not collided."""
_EARLY, _APART = 0.1, 1.2
"""Relative change of averages between the first two times, and the ratio of these, for which they
tell of the time before collisions: later <r^2>/t^2 changes more between times that far apart."""
_WRONG_ABOVE = 0.005
"""|ln(|r|/(|v| t))| from which on units do not belong together."""


def straight_flights(time: Array | float, distance: Array, speed: Array) -> Flights | None:
    """The ratio |r|/(|v| t) that most tracers share at one time; None where too few share one.

    time, distance, speed (n,): of tracers at times that are nearly the same, in units of the data.
    """
    time = np.broadcast_to(np.asarray(time, float), distance.shape)
    moving = (distance > 0) & (speed > 0) & (time > 0)
    if np.count_nonzero(moving) < _FEWEST:
        return None
    with np.errstate(over="ignore", under="ignore", divide="ignore"):
        ratio = np.log(distance[moving]) - np.log(speed[moving]) - np.log(time[moving])
    ratio = np.sort(ratio)
    alike = np.searchsorted(ratio, ratio + _SAME) - np.arange(ratio.size)
    first = int(np.argmax(alike))
    count = int(alike[first])
    if count < max(_FEWEST, _LEAST_SHARE * distance.size):
        return None
    middle = float(np.exp(np.median(ratio[first : first + count])))
    return Flights(float(time[moving].mean()), middle, count / distance.size)


def wrong_unit(sample: Sample) -> Explanation | None:
    """What is said where units do not belong together; None where they do, or cannot be known."""
    if sample.law.field:
        return None
    if sample.tabulated:
        return _wrong_unit_of_averages(sample)
    flights = sample.flights
    if flights is None or abs(np.log(flights.ratio)) < _WRONG_ABOVE:
        return None
    return Explanation(
        "time unit", "found", said("wrong_unit", flights=flights), True, 1 / flights.ratio,
        headline=said("wrong_unit_headline", flights=flights),
    )  # fmt: skip


def _wrong_unit_of_averages(sample: Sample) -> Explanation | None:
    """From <r^2>/(<v^2> t^2), which tends to 1 as t tends to 0: from the first two times.

    Only where both change by less than _EARLY between them: tracers have hardly collided then.
    """
    first = np.flatnonzero(sample.times > 0)[:2]
    if first.size < 2 or sample.times[first[1]] < _APART * sample.times[first[0]]:
        return None
    times, total = sample.times[first], sample.sums.sum(axis=0)
    scales = (sample.length_scale, sample.speed_scale)

    def averages(sums: Array) -> tuple[Array, Array]:
        length, speed = (scale[first] for scale in scales)
        v2 = speed**2 * sums[..., first, V2]
        return length**2 * sums[..., first, R2] / (v2 * times**2), v2

    def at_zero(ratio: Array) -> Array:
        slope = (ratio[..., 1] - ratio[..., 0]) / (times[1] - times[0])
        return np.asarray(ratio[..., 0] - slope * times[0])

    ratio, v2 = averages(total)
    # Written so that averages that are not known are left out.
    if not (abs(ratio[1] / ratio[0] - 1) < _EARLY and abs(v2[1] / v2[0] - 1) < _EARLY):
        return None
    start, error = at_zero(ratio), errors(at_zero(averages(total - sample.sums)[0]))
    found = float(np.sqrt(max(float(start), 0.0)))
    if not abs(start - 1) > max(DIFFERS_ABOVE * float(error), 2 * _WRONG_ABOVE) or found == 0:
        return None
    words = {"time": times[0], "ratio": found}
    return Explanation(
        "time unit", "found", said("wrong_unit_of_averages", **words), True, 1 / found,
        headline=said("wrong_unit_of_averages_headline", **words),
    )  # fmt: skip


def wrong_speeds(sample: Sample, start: Any) -> Explanation | None:
    """What is said where the first speeds are far from those of a named start; or None.

    Speeds never rise, so that larger ones than at the start cannot be. Smaller ones cannot be while
    most tracers have not collided. A factor of two is asked for: less may be another start.
    """
    if not isinstance(start, str) or sample.law.field:
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
