"""A result as a table of named quantities; data frames, datasets, plots and CSV files follow.

A class of results says what it holds, once, in `_table`: for each quantity its dimensions, values,
unit and meaning, and attributes of the whole. :class:`Tabular` makes everything else of that, the
same for all classes. pandas, xarray and matplotlib are imported when they are asked for.
"""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kinetics.errors import InputError, short
from kinetics.numerics import FloatArray
from kinetics.version import package_version

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COMPONENTS = ("component", "component2")
"""Dimensions of vectors and tensors, whose coordinates are x, y and z."""
ROWS = "rows"
"""Asked of `_table`: quantities that depend on the first coordinate alone."""
_DECADES = 30.0  # largest over smallest value from which on an axis is logarithmic
_LOWEST = 1e-7  # of the largest value, on a logarithmic axis of a density
_MOST_LINES = 8
_MOST_NUMBERS = 200  # of an array that an attribute writes out


@dataclass(frozen=True)
class Quantity:
    """One named array.

    Attributes
    ----------
    name : of the column or variable
    dims : names of its axes, each the name of a coordinate; empty for a single number
    values : of as many axes
    units : "1" for numbers without one
    long_name : what it is, in words
    symbol : for the axes of plots; the name by default
    is_density : whether its tails are of interest, so that plots are logarithmic
    """

    name: str
    dims: tuple[str, ...]
    values: NDArray[Any]
    units: str
    long_name: str
    symbol: str = ""
    is_density: bool = False

    @property
    def label(self) -> str:
        """Symbol and unit, as the label of an axis."""
        symbol = typeset(self.symbol or self.name.replace("_", " "))
        return symbol if self.units == "1" else f"{symbol} [{typeset(self.units)}]"

    def head(self, name: str) -> str:
        """Name and unit, as the head of a column."""
        return name if self.units == "1" else f"{name} [{self.units}]"

    def real(self) -> tuple[Quantity, ...]:
        """Itself; a complex one as its real and its imaginary part, which every format can hold."""
        if not np.iscomplexobj(self.values):
            return (self,)
        parts = (("real", self.values.real, "Re"), ("imag", self.values.imag, "Im"))
        return tuple(
            replace(
                self,
                name=f"{self.name}_{part}",
                values=values,
                long_name=f"{self.long_name}, {part} part",
                symbol=f"{sign} {self.symbol}",
            )
            for part, values, sign in parts
        )


@dataclass(frozen=True)
class Table:
    """What a result holds: coordinates, quantities that depend on them, and attributes.

    The first coordinate is that of the rows of a data frame.
    """

    coordinates: tuple[Quantity, ...]
    quantities: tuple[Quantity, ...]
    attributes: Mapping[str, Any]

    @property
    def title(self) -> str:
        """What it is the table of."""
        return str(self.attributes["title"])

    def coordinate(self, name: str) -> Quantity:
        """The coordinate of this name."""
        return next(one for one in self.coordinates if one.name == name)

    def quantity(self, name: str) -> Quantity:
        """The quantity of this name; InputError, with the names there are, for another one."""
        for one in self.quantities:
            if one.name == name:
                return one
        known = ", ".join(one.name for one in self.quantities)
        raise InputError(f"name: got {short(name)}; this result has {known}")

    def columns(self, name: str | None = None) -> dict[str, NDArray[Any]]:
        """Columns of one length: all that depends on the first coordinate alone, or one quantity.

        Of vectors and tensors each component is a column. A quantity that is named has one row for
        each point of its coordinates.
        """
        if name is not None:
            chosen = self.quantity(name)
            axes = [d for d in chosen.dims if d not in COMPONENTS]
        else:
            axes = [self.coordinates[0].name]
        arrays = [self.coordinate(d).values for d in axes]
        found = {
            d: grid.ravel()
            for d, grid in zip(axes, np.meshgrid(*arrays, indexing="ij"), strict=True)
        }
        n = len(found)
        for one in self.quantities if name is None else (chosen,):
            if [d for d in one.dims if d not in COMPONENTS] == axes:
                found |= dict(_components(one, self))
        if len(found) == n:  # nothing depends on the first coordinate alone: one row of numbers
            return {one.name: one.values.reshape(1) for one in self.quantities if not one.dims}
        return found

    def csv(self, wide: Collection[str] = ()) -> str:
        """A CSV file: one row for each value of the first coordinate, heads with units.

        wide : quantities that also depend on another coordinate, of which each point is a column
        """
        first = self.coordinates[0]
        found = {first.head(first.name): first.values}
        for one in self.quantities:
            axes = [d for d in one.dims if d not in COMPONENTS]
            if axes == [first.name]:
                found |= {one.head(name): column for name, column in _components(one, self)}
            elif one.name in wide and len(axes) == 2:
                along = self.coordinate(axes[1])
                for part in one.real():
                    for x, column in zip(along.values, part.values.T, strict=True):
                        found[part.head(f"{part.name}({along.name}={x:g})")] = column
        if len(found) == 1:  # nothing depends on it: one row of single numbers
            numbers = (one for one in self.quantities if not one.dims)
            found = {one.head(one.name): one.values.reshape(1) for one in numbers}
        file = io.StringIO()
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(found)
        writer.writerows(zip(*(column.tolist() for column in found.values()), strict=True))
        return file.getvalue()


def _components(one: Quantity, table: Table) -> Iterator[tuple[str, NDArray[Any]]]:
    """Columns of a quantity: itself, or one for each component of a vector or a tensor."""
    for part in one.real():
        inner = [d for d in part.dims if d in COMPONENTS]
        if not inner:
            yield part.name, part.values.ravel()
        for place in np.ndindex(*(table.coordinate(d).values.size for d in inner) if inner else ()):
            if inner:
                letters = "".join("xyz"[i] for i in place)
                yield f"{part.name}_{letters}", part.values[(..., *place)].ravel()


class Tabular:
    """Plots, data frames and datasets of a result, from the table that its class gives."""

    _points: tuple[str, ...] = ()

    def _table(self, only: str | None = None, **points: Any) -> Table:
        """Everything; or, where only one name or :data:`ROWS` is needed, this at least."""
        raise NotImplementedError

    def _table_at(self, only: str | None, points: Mapping[str, Any]) -> Table:
        for name in points:
            if name not in self._points:
                raise InputError(f"{name}: known are {', '.join(('name', 'ax', *self._points))}")
        return self._table(only, **points)

    def table(self, **points: Any) -> Table:
        """Everything that data frames, datasets and plots are made of; points as of them."""
        return self._table_at(None, points)

    def to_dataframe(self, name: str | None = None, **points: Any) -> Any:
        """A pandas DataFrame: one row for each time (or other first coordinate) with all averages.

        With the ``name`` of a quantity that depends on more, such as "speed_density": one row for
        each point. Units and the attributes of the result are in ``frame.attrs``. ``points``: as
        of :meth:`to_xarray`. Raises InputError without pandas, or for a name that is not there.
        """
        pandas = optional("pandas", "to_dataframe")
        table = self._table_at(name or ROWS, points)
        frame = pandas.DataFrame(table.columns(name))
        parts = [part for one in table.quantities for part in one.real()]
        units = {one.name: one.units for one in (*table.coordinates, *parts)}
        frame.attrs = {**table.attributes, "units": units}
        return frame

    def to_xarray(self, **points: Any) -> Any:
        """An xarray Dataset of everything, whose attributes say units, status and accuracy.

        ``points`` are where functions are evaluated: for a Solution speeds, angles, radii,
        scaled_radii and wave_numbers; for others see there. Complex quantities are split into
        ``_real`` and ``_imag``, so that ``to_netcdf`` takes them. Raises InputError without xarray.
        """
        xarray = optional("xarray", "to_xarray")
        table = self._table_at(None, points)
        used = {d for one in table.quantities for d in one.dims}
        variables = {
            part.name: (part.dims, np.array(part.values), _described(part))
            for one in table.quantities
            for part in one.real()
        }
        coordinates = {
            one.name: (one.dims, np.array(one.values), _described(one))
            for one in table.coordinates
            if one.name in used
        }
        return xarray.Dataset(variables, coordinates, dict(table.attributes))

    def plot(self, name: str, ax: Axes | None = None, **points: Any) -> Axes:
        """Draw one quantity by its name, on ``ax`` or on new axes; returns the matplotlib axes.

        Averages are drawn over time, densities at up to eight of the times. Axes are labelled with
        units. ``points``: as of :meth:`to_xarray`. Raises InputError for a name that is not there.
        """
        table = self._table_at(name, points)
        chosen = table.quantity(name)
        free = [d for d in chosen.dims if d not in COMPONENTS]
        if not 1 <= len(free) <= 2:
            how = "is one number" if not free else f"depends on {', '.join(free)}"
            raise InputError(f"name: got {name!r}, which {how}; plot draws lines over one of two")
        if ax is None:
            from matplotlib import pyplot

            _, ax = pyplot.subplots(layout="constrained")
        along = table.coordinate(free[-1])
        _draw(ax, chosen, table, along.values)
        ax.set(xlabel=along.label, ylabel=chosen.label)
        _set_scales(ax, along, chosen)
        return ax


def _draw(ax: Axes, chosen: Quantity, table: Table, along: FloatArray) -> None:
    """Draw the lines of a quantity; imaginary parts are broken lines of the same colours."""
    from matplotlib import colormaps

    first = table.coordinate(next(d for d in chosen.dims if d not in COMPONENTS))
    several = len(chosen.dims) > 1 or np.iscomplexobj(chosen.values)
    for part in chosen.real():
        imaginary = part.name == f"{chosen.name}_imag"
        style = "--" if imaginary else "-"
        if part.dims[-1] == first.name or part.dims[-1] in COMPONENTS:
            for name, line in _components(part, table):
                label = typeset(name.replace("_", " ")) if several else None
                ax.plot(along, line, style, label=label)
            continue
        n = first.values.size
        shown = np.unique(np.linspace(0, n - 1, min(n, _MOST_LINES)).round().astype(int))
        colours = colormaps["viridis"](np.linspace(0.0, 0.9, shown.size))
        for i, colour in zip(shown, colours, strict=True):
            label = _value_of(first, i) if not imaginary else None
            ax.plot(along, part.values[i], style, color=colour, label=label)
        if imaginary:
            ax.plot([], [], style, color="black", label="imaginary part")
    if several:
        ax.legend()


def _value_of(coordinate: Quantity, i: int) -> str:
    unit = "" if coordinate.units == "1" else f" {typeset(coordinate.units)}"
    symbol = typeset(coordinate.symbol or coordinate.name)
    return f"{symbol} = {printed(float(coordinate.values[i]), 4)}{unit}"


def _set_scales(ax: Axes, along: Quantity, chosen: Quantity) -> None:
    """Logarithmic axes where numbers are positive and span decades; of times 0 is then left out."""
    x = along.values
    later = x[x > 0.0] if along.name == "time" else x
    if later.size > 1 and later.min() > 0.0 and later.max() > _DECADES * later.min():
        ax.set_xscale("log")
    if np.iscomplexobj(chosen.values):
        return
    y = chosen.values[np.isfinite(chosen.values)]
    if chosen.is_density and y.size and y.max() > 0.0:
        largest = float(y.max())
        ax.set_yscale("log", nonpositive="mask")
        ax.set_ylim(_LOWEST * largest, 3.0 * largest)
    elif y.size and y.min() > 0.0 and y.max() > _DECADES * y.min():
        ax.set_yscale("log")


def _described(one: Quantity) -> dict[str, str]:
    return {"units": one.units, "long_name": one.long_name}


def optional(module: str, what: str) -> Any:
    """A package that an extra of its name brings; InputError says so where it is absent."""
    from importlib import import_module

    try:
        return import_module(module)
    except ImportError:
        how = f"python -m pip install 'inelastic-lorentz[{module}]'"
        raise InputError(f"{what}: needs {module}, which is not installed: {how}") from None


def attributes_of(
    title: str, question: Any, accuracy: tuple[float, float] | None, **more: str
) -> dict[str, Any]:
    """The attributes of a table: what was asked, how accurately, and what was reached.

    question : a dataclass, or a dictionary; it is written as JSON
    accuracy : relative tolerance asked and error estimate, where there are any
    """
    names = ("tolerance_asked", "tolerance_reached")
    reached = dict(zip(names, map(float, accuracy), strict=True)) if accuracy else {}
    return {
        "title": title,
        **more,
        **reached,
        "scene": json.dumps(plain(question), allow_nan=False),
        "version": package_version(),
    }


def plain(value: Any) -> Any:
    """The value as what JSON can hold; of long arrays only the shape, of functions the name."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if is_dataclass(value) and not isinstance(value, type):
        parts = {f.name: plain(getattr(value, f.name)) for f in fields(value) if f.init}
        return {"class": type(value).__name__, **parts}
    if isinstance(value, np.ndarray):
        return plain(value.tolist()) if value.size <= _MOST_NUMBERS else f"shape {value.shape}"
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, (bool, int, str, type(None))):
        return value
    if isinstance(value, (float, np.floating)):
        return float(value) if math.isfinite(value) else str(float(value))
    return str(getattr(value, "__qualname__", type(value).__name__))


_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def printed(number: float, digits: int = 6) -> str:
    """A number of so many digits as it is printed: 0.0123, 4.5×10⁶."""
    mantissa, _, exponent = f"{number:.{digits}g}".replace("-", "−").partition("e")
    if not exponent:
        return mantissa
    power = "10" + str(int(exponent.replace("−", "-"))).translate(_RAISED)
    return power if mantissa == "1" else f"{mantissa}×{power}"


_SIGNS = {
    "<": "⟨", ">": "⟩", "^2": "²", "^3": "³", "^4": "⁴", "^-1": "⁻¹", "v0": "v₀", "a2": "a₂",
    "sqrt": "√",
}  # fmt: skip


def typeset(text: str) -> str:
    """A symbol or unit such as <r^2> with brackets, powers and indices as they are printed."""
    for plainly, sign in _SIGNS.items():
        text = text.replace(plainly, sign)
    return text
