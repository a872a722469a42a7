"""Whether positions, speeds and times of the data are in units that belong together.

A tracer that has not collided is at r = v t: in units that belong together |r|/(|v| t) is 1 for
each of them, whatever the scatterers and the restitution. For those that have collided it is spread
over many values. So the value that many tracers share tells the unit, without any theory.
"""

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.comparison.result import Explanation, said
from kinetics.crosscheck.comparison.sample import Flights, Sample

Array = NDArray[np.float64]

_SAME = 2e-3
"""Width in ln(|r|/(|v| t)) within which tracers fly alike: numbers may have few digits."""
_LEAST_SHARE, _FEWEST = 0.05, 20
"""Tracers that must fly alike. Those that have collided put some 0.5 % into such a width."""
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
