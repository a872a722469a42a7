"""The numbers of the theory as a reader sees them: with errors, in d, U and in the data's units."""

from __future__ import annotations

from dataclasses import dataclass

from kinetics.crosscheck.compare.result import Comparison, Parameter
from kinetics.crosscheck.words import number, numeral

#: Written in place of the name of a unit that the data do not say.
UNNAMED_UNIT = "in the data's units"
#: Written in place of a value that is not there.
NO_VALUE = number(None)
#: Digits of a value that has no error.
DIGITS = 5
#: Powers of a unit of length.
EXPONENTS = {1: "", -2: "⁻²", -3: "⁻³"}


@dataclass(frozen=True)
class Quantity:
    """A number of the theory, written.

    Parameters
    ----------
    name : in words, with the symbol
    value : with its error, in d and U; in the data's unit where it has no other
    value_in_data_units : the same in the data's units; empty where these are d and U
    source : where the number comes from
    """

    name: str
    value: str
    value_in_data_units: str
    source: str

    @property
    def has_value(self) -> bool:
        """Whether there is a value: not where no model fits."""
        return self.value != NO_VALUE

    @property
    def text(self) -> str:
        """The value in all units."""
        if not self.value_in_data_units:
            return self.value
        return f"{self.value} = {self.value_in_data_units}"


def quantities(comparison: Comparison) -> list[Quantity]:
    """Return the numbers of the theory of a comparison, in the order in which they are shown."""
    writers = {
        "restitution": _restitution,
        "number_density": _number_density,
        "mean_free_path": _mean_free_path,
        "speed_unit": _speed_unit,
        "position_error": _position_error,
    }
    parameters = comparison.parameters
    written = []
    for name, write in writers.items():
        if name in parameters:
            written.append(write(comparison, parameters[name]))
    return written


def range_of_times(comparison: Comparison) -> str:
    """Return the first and the last time of the data, in d/U and in the data's unit."""
    text = f"from {_times_in_unit(comparison, 1.0)} d/U"
    unit = comparison.units.get("time", 1.0)
    name = comparison.unit_names.get("time", "")
    if unit == 1.0 and not name:
        return text
    return f"{text} ({_times_in_unit(comparison, unit)} {name or UNNAMED_UNIT})"


def _times_in_unit(comparison: Comparison, unit: float) -> str:
    """Write the first and the last time in units of d/U over a unit."""
    first = numeral(comparison.first_time * unit, ".4g")
    last = numeral(comparison.last_time * unit, ".4g")
    return f"{first} to {last}"


def speed_unit_name(comparison: Comparison) -> str:
    """Return the name of the data's unit of speed."""
    names = comparison.unit_names
    if "speed" in names:
        return names["speed"]
    if "length" in names and "time" in names:
        return f"{names['length']}/{names['time']}"
    return UNNAMED_UNIT


def _restitution(comparison: Comparison, parameter: Parameter) -> Quantity:
    """Write e, which has no unit."""
    value = _written(parameter.value, parameter.error)
    return Quantity("restitution e", value, "", parameter.source)


def _number_density(comparison: Comparison, parameter: Parameter) -> Quantity:
    """Write the number of scatterers per area or volume."""
    power = -comparison.dimension
    return _power_of_length(comparison, "density ρ₀", parameter, power)


def _mean_free_path(comparison: Comparison, parameter: Parameter) -> Quantity:
    """Write l."""
    return _power_of_length(comparison, "mean free path l", parameter, 1)


def _power_of_length(
    comparison: Comparison, name: str, parameter: Parameter, power: int
) -> Quantity:
    """Write what has the unit of a power of a length, in d and in the data's unit."""
    exponent = EXPONENTS[power]
    value = _with_unit(_written(parameter.value, parameter.error), f"d{exponent}")
    factor = comparison.units.get("length", 1.0) ** power
    length = comparison.unit_names.get("length", "")
    in_data_units = ""
    if parameter.value is not None and (length or factor != 1.0):
        scaled = parameter.in_unit(factor)
        unit = UNNAMED_UNIT
        if length:
            unit = f"{length}{exponent}"
        in_data_units = f"{_written(scaled.value, scaled.error)} {unit}"
    return Quantity(name, value, in_data_units, parameter.source)


def _speed_unit(comparison: Comparison, parameter: Parameter) -> Quantity:
    """Write U, which is 1 in itself, in the data's unit."""
    value = _written(parameter.value, parameter.error)
    unit = speed_unit_name(comparison)
    return Quantity("typical speed U", _with_unit(value, unit), "", parameter.source)


def _position_error(comparison: Comparison, parameter: Parameter) -> Quantity:
    """Write the error of a component of a position, which a parameter has in the data's unit."""
    length = comparison.units.get("length", 1.0)
    return _power_of_length(comparison, "position error σ", parameter.in_unit(1.0 / length), 1)


def _written(value: float | None, error: float | None) -> str:
    """Return a value to the second digit of its error."""
    return number(value, error, digits=DIGITS)


def _with_unit(value: str, unit: str) -> str:
    """Return a written value with its unit, or the dash of a value that is not there."""
    if value == NO_VALUE:
        return value
    return f"{value} {unit}"
