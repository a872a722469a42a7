"""What a user says about data: units, columns, which particles, how positions are meant."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NoReturn, Self

import numpy as np
from numpy.typing import ArrayLike

from kinetics.crosscheck.data.arrays import Floats
from kinetics.crosscheck.data.columns import columns_by_our_names
from kinetics.errors import InputError
from kinetics.validation import one_of, real_number, refuse, whole_number

#: Smallest and largest unit: its square and its cube must be finite.
MIN_UNIT = 1e-100
#: Largest unit, likewise.
MAX_UNIT = 1e100
#: How positions may be meant.
POSITIONS = ("auto", "displacement", "absolute")
#: Decimal signs of numbers in text.
DECIMAL_SIGNS = (".", ",")


def refuse_data(where: str, found: object, allowed: str) -> NoReturn:
    """Raise InputError in one line: where, what was found there, and what must be there."""
    raise InputError(f"{where}: got {found}; must be {allowed}")


@dataclass(frozen=True)
class Units:
    """d, U and d/U in the units of the data."""

    length: float = 1.0
    speed: float = 1.0
    time: float = 1.0

    def by_name(self) -> dict[str, float]:
        """Return the units by name; none if the data have d, U and d/U themselves."""
        if self == Units():
            return {}
        return {"speed": self.speed, "length": self.length, "time": self.time}


@dataclass(frozen=True, kw_only=True)
class DataOptions:
    """What a user says about data; made by :meth:`checked`.

    Parameters
    ----------
    positions : "displacement" (from the place at time 0), "absolute", or "auto"
    units : of the data
    has_time_unit : whether the unit of time was given, and not only follows from the others
    columns : names of columns of the data, by our names
    step_time : time of a step or between frames, where the data count these; None if unknown
    dimension : 2 or 3; None for what the data are
    type : the type (species) of the tracers; None for all particles
    with_axes : whether means along each axis matter, as in a field
    decimal : the decimal sign of numbers in text
    """

    positions: str
    units: Units
    has_time_unit: bool
    columns: Mapping[str, str]
    step_time: float | None
    dimension: int | None
    type: str | None
    with_axes: bool
    decimal: str

    @classmethod
    def checked(
        cls,
        *,
        positions: object = "auto",
        speed_unit: object = 1.0,
        diameter: object = 1.0,
        time_unit: object = None,
        columns: object = None,
        timestep: object = None,
        frame_interval: object = None,
        dimension: object = None,
        type: object = None,
        with_axes: bool = False,
        decimal: object = ".",
    ) -> Self:
        """Return the options of a user's arguments, as `compare` takes them; or InputError."""
        speed = real_number("speed_unit", speed_unit, MIN_UNIT, MAX_UNIT)
        length = real_number("diameter", diameter, MIN_UNIT, MAX_UNIT)
        time = length / speed
        if time_unit is not None:
            time = real_number("time_unit", time_unit, MIN_UNIT, MAX_UNIT)
        if timestep is not None and frame_interval is not None:
            refuse("frame_interval", frame_interval, "timestep says the same: give one of them")
        step_time = None
        if timestep is not None:
            step_time = real_number("timestep", timestep, MIN_UNIT, MAX_UNIT)
        if frame_interval is not None:
            step_time = real_number("frame_interval", frame_interval, MIN_UNIT, MAX_UNIT)
        checked_dimension = None
        if dimension is not None:
            checked_dimension = whole_number("dimension", dimension, 2, 3)
        tracer_type = None
        if type is not None:
            tracer_type = str(type)
        return cls(
            positions=one_of("positions", positions, POSITIONS),
            units=Units(length, speed, time),
            has_time_unit=time_unit is not None,
            columns=columns_by_our_names(columns),
            step_time=step_time,
            dimension=checked_dimension,
            type=tracer_type,
            with_axes=with_axes,
            decimal=one_of("decimal", decimal, DECIMAL_SIGNS),
        )

    @property
    def axes(self) -> tuple[str, ...]:
        """The axes that are read: x and y, in space z too."""
        return ("x", "y", "z")[: self.dimension or 2]

    def times_of_steps(self, where: str, steps: ArrayLike) -> Floats:
        """Return the times of steps or frames; InputError where the time of one is unknown."""
        if self.step_time is None:
            allowed = "times, or specify timestep, frame_interval or fps (--timestep ...)"
            refuse_data(where, "numbers of steps or frames alone", allowed)
        return np.asarray(steps) * self.step_time
