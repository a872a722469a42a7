"""The numbers of a `Point` that can be fitted, and their limits."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from kinetics.collision.medium import HIGHEST_DENSITY, LEAST_RESTITUTION
from kinetics.crosscheck.compare.measured import Measured
from kinetics.crosscheck.compare.observables import BETWEEN_FRAMES, Array
from kinetics.crosscheck.compare.point import Point

#: Limits of the numbers that are fitted as they are; others are positive, and their logarithms are
#: fitted.
LIMITS = {
    "restitution": (0.0, 1.0),
    "at_rest": (-0.5, 0.9),
    "time_offset": (-1e3, 1e3),
    "velocity_noise": (0.0, 1e3),
    "position_noise": (0.0, 1e6),
}
#: Folds of e by which a positive number may differ from the one that it begins from.
MAX_FOLDS = 12.0
#: Restitutions from which a fit begins. Chosen: closer where 1 - e, the rate of cooling, is small.
FIRST_RESTITUTIONS = (0.3, 0.6, 0.85, 0.97)
#: Step of a coordinate for derivatives: of a logarithm, or of a number over its scale. An error of
#: 1e-7 of the solver is then one of 1e-4 of a derivative.
STEP = 1e-3
#: Share of the smallest mean square that noise may be at most: it is below what is measured.
MAX_NOISE_SHARE = 0.98


@dataclass(frozen=True)
class FreeParameter:
    """A number of a point that is fitted, by a coordinate of order 1.

    Parameters
    ----------
    name : of the number, as in `Point`
    low, high : limits of the coordinate: the logarithm of a positive number, others over `scale`
    scale : unit of the coordinate of numbers that are fitted as they are
    """

    name: str
    low: float
    high: float
    scale: float = 1.0

    @property
    def is_logarithm(self) -> bool:
        """Whether the coordinate is the logarithm of the number."""
        return self.name not in LIMITS

    def value(self, coordinate: float) -> float:
        """Return the number at a coordinate."""
        if self.is_logarithm:
            return math.exp(coordinate)
        return coordinate * self.scale

    def coordinate(self, value: float) -> float:
        """Return the coordinate of a number."""
        if self.is_logarithm:
            return math.log(value)
        return value / self.scale

    def is_at_limit(self, coordinate: float) -> bool:
        """Whether a fit has run into a limit that is none of the number itself."""
        if not self.is_logarithm:
            return False
        margin = 0.01 * (self.high - self.low)
        return coordinate <= self.low + margin or coordinate >= self.high - margin


def free_parameter(name: str, point: Point, measured: Measured | None = None) -> FreeParameter:
    """Return a number of a point as one that is fitted to data.

    measured : the data, whose size is the unit of noise and of a time; the restitution and positive
        numbers need none
    """
    if name in LIMITS:
        low, high = LIMITS[name]
        scale = 1.0
        if measured is not None:
            scale = _scale(name, measured)
        if name == "restitution" and point.scatterers != "dilute":
            low = LEAST_RESTITUTION
        if name.endswith("noise"):
            high = min(high, MAX_NOISE_SHARE * scale)
        return FreeParameter(name, low / scale, high / scale, scale)
    middle = math.log(getattr(point, name))
    low = middle - MAX_FOLDS
    high = middle + MAX_FOLDS
    if name == "path" and point.scatterers != "dilute":
        low = max(low, -math.log(2.0 * HIGHEST_DENSITY))
    return FreeParameter(name, low, high)


def _scale(name: str, measured: Measured) -> float:
    """Return the unit of a coordinate: of noise, the smallest mean square of a component."""
    layout = measured.layout
    is_later = layout.time > 0.0
    if name == "time_offset":
        return float(layout.times[layout.times > 0.0].min(initial=math.inf))
    if name == "velocity_noise":
        squares = measured.values[layout.is_of("thermal_speed") & is_later] ** 2
        noises = layout.law.dimension
    elif name == "position_noise":
        squares = measured.values[layout.is_of("msd", BETWEEN_FRAMES) & is_later]
        noises = layout.law.dimension * (1 if measured.has_velocities else 2)
    else:
        return 1.0
    positive = squares[squares > 0.0]
    return float(positive.min(initial=1e9)) / noises


# -- several of them -------------------------------------------------------------------------------
def limits_of(free: Sequence[FreeParameter]) -> tuple[Array, Array]:
    """Return the lowest and the highest coordinates, shape (n_free,) each."""
    limits = np.array([(parameter.low, parameter.high) for parameter in free]).reshape(-1, 2)
    return limits[:, 0], limits[:, 1]


def point_at(point: Point, free: Sequence[FreeParameter], coordinates: Array) -> Point:
    """Return a point with the values of free numbers at coordinates, shape (n_free,)."""
    values = {}
    for parameter, coordinate in zip(free, coordinates.tolist(), strict=True):
        values[parameter.name] = parameter.value(coordinate)
    return point.with_values(**values)


def coordinates_of(point: Point, free: Sequence[FreeParameter]) -> Array:
    """Return the coordinates of the free numbers at a point, shape (n_free,)."""
    numbers = [parameter.coordinate(float(getattr(point, parameter.name))) for parameter in free]
    return np.array(numbers)


def is_at_foreign_limit(free: Sequence[FreeParameter], coordinates: Array) -> bool:
    """Return whether a fit has run into a limit that is none of the number itself."""
    for parameter, coordinate in zip(free, coordinates.tolist(), strict=True):
        if parameter.is_at_limit(coordinate):
            return True
    return False


def combinations_of(
    free: Sequence[FreeParameter], values: Mapping[str, Sequence[float]]
) -> list[list[float]]:
    """Return all combinations of values of the free numbers, as coordinates."""
    combinations: list[list[float]] = [[]]
    for parameter in free:
        coordinates = [parameter.coordinate(value) for value in values[parameter.name]]
        combinations = [[*before, x] for before in combinations for x in coordinates]
    return combinations


def derivatives(
    function: Callable[[Array], Array], coordinates: Array, free: Sequence[FreeParameter]
) -> Array:
    """Return the derivatives (p, n_free) of a function of coordinates, centred if they can be."""
    low, high = limits_of(free)
    columns = []
    for index in range(coordinates.size):
        above = coordinates.copy()
        below = coordinates.copy()
        above[index] = min(coordinates[index] + STEP, high[index])
        below[index] = max(coordinates[index] - STEP, low[index])
        difference = function(above) - function(below)
        columns.append(difference / (above[index] - below[index]))
    return np.stack(columns, axis=1)
