"""Datasets of xarray and data frames of pandas, from named arrays with units."""

from __future__ import annotations

import json
from collections.abc import Hashable, Mapping
from itertools import product
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics.errors import SolverStatus
from kinetics.results.record import describe
from kinetics.version import package_version

if TYPE_CHECKING:
    import pandas
    import xarray

#: Dimensions of vectors and tensors, which come last; their coordinates are x, y and z.
COMPONENTS = ("component", "component2")
#: What follows the name of a quantity in the name of the variable of its model error.
MODEL_ERROR = "_model_error"


class Variable(NamedTuple):
    """One variable of a dataset, as `xarray.Dataset` takes it."""

    dimensions: tuple[str, ...]
    values: NDArray[Any]
    attributes: dict[str, str]


def variable(
    dimensions: tuple[str, ...], values: ArrayLike, units: str, long_name: str, symbol: str = ""
) -> Variable:
    """Return one variable of a dataset: a copy of its values, and what they are."""
    attributes = {"units": units, "long_name": long_name}
    if symbol:
        attributes["symbol"] = symbol
    return Variable(dimensions, np.array(values), attributes)


@runtime_checkable
class Solved(Protocol):
    """A result of a solver, with a status and an error estimate."""

    status: SolverStatus
    message: str
    rtol: float
    error_estimate: float


def dataset(
    result: object,
    title: str,
    question: object,
    variables: Mapping[str, Variable],
    coordinates: Mapping[str, Variable],
    **attributes: object,
) -> xarray.Dataset:
    """Return the dataset of a result; coordinates that no variable has are left out.

    Parameters
    ----------
    result : its status, message and accuracy are attributes of the dataset, if it has them
    title : of the dataset
    question : what was asked; it is the attribute `scene`, as JSON
    variables, coordinates : by name, as :func:`variable` makes them
    attributes : more of them
    """
    import xarray

    if isinstance(result, Solved):
        attributes["status"] = result.status.name.lower()
        attributes["message"] = result.message
        attributes["tolerance_asked"] = result.rtol
        attributes["tolerance_reached"] = result.error_estimate
    dimensions: set[str] = set()
    for array in variables.values():
        dimensions.update(array.dimensions)
    axes = {name: axis for name, axis in coordinates.items() if name in dimensions}
    all_attributes = {"title": title, **attributes}
    all_attributes["scene"] = json.dumps(describe(question))
    all_attributes["version"] = package_version()
    return xarray.Dataset(dict(variables), axes, all_attributes)


def free_dimensions(quantity: xarray.DataArray) -> list[str]:
    """Return the names of the dimensions that are not components."""
    return [str(name) for name in quantity.dims if name not in COMPONENTS]


def split_components(quantity: xarray.DataArray) -> dict[str, xarray.DataArray]:
    """Return a scalar, or each component of a vector or tensor, by name."""
    inner = [name for name in quantity.dims if name in COMPONENTS]
    if not inner:
        return {str(quantity.name): quantity}
    labels = []
    for name in inner:
        labels.append(quantity[name].values)
    components = {}
    for indices in product(*labels):
        place = dict(zip(inner, indices, strict=True))
        components[f"{quantity.name}_{''.join(indices)}"] = quantity.sel(place, drop=True)
    return components


def averages_frame(averages: xarray.Dataset) -> pandas.DataFrame:
    """Return a row for each point of the first coordinate, with all that depends on it alone.

    If nothing does, there is one row of numbers.
    """
    first_coordinate = next(map(str, averages.coords), None)
    arrays = []
    numbers = []
    for array in averages.data_vars.values():
        if not array.dims:
            numbers.append(array.expand_dims("row"))
        elif free_dimensions(array) == [first_coordinate]:
            arrays.append(array)
    return _as_frame(arrays or numbers, averages.attrs)


def quantity_frame(components: list[xarray.DataArray]) -> pandas.DataFrame:
    """Return a row for each point of one quantity, given by its real and imaginary part."""
    return _as_frame(components, {})


def _as_frame(
    arrays: list[xarray.DataArray], attributes: Mapping[Hashable, object]
) -> pandas.DataFrame:
    """Return arrays with the same coordinates as columns; units are in ``frame.attrs``."""
    import xarray

    columns: dict[str, xarray.DataArray] = {}
    for array in arrays:
        columns |= split_components(array)
    frame = xarray.Dataset(columns).to_dataframe().reset_index()
    frame = frame.drop(columns="row", errors="ignore")
    units = {}
    for name in frame.columns:
        source = columns[name] if name in columns else arrays[0][name]
        units[name] = source.attrs["units"]
    frame.attrs = {**attributes, "units": units}
    return frame
