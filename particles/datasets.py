"""An Ensemble as a dataset of xarray or a data frame of pandas.

Both are imported when they are asked for. Begin reading with `make_dataset`.
"""

import json
from collections.abc import Iterable
from typing import TYPE_CHECKING, Protocol

import numpy as np

from particles.outputs import ESTIMATES, OF_FLIGHTS, VARIABLES
from particles.plan import Plan
from particles.results import Estimate, Histogram, Statuses
from particles.values import package_version

if TYPE_CHECKING:
    import pandas
    import xarray

#: Names of coordinates, as they are in the names of columns and as values of the axis `component`.
COORDINATES = "xyz"

#: What xarray makes a variable or an axis of: names of its dimensions, values, attributes.
DatasetEntry = tuple[tuple[str, ...], np.ndarray | list[str], dict[str, str]]
DatasetEntries = dict[str, DatasetEntry]


class RunResult(Protocol):
    """What datasets and pictures are made of: an Ensemble, with its estimates as attributes."""

    @property
    def plan(self) -> Plan:
        """What was run."""

    @property
    def statuses(self) -> Statuses:
        """How the tracers ended."""

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the estimates, histograms and raw data."""


def dataset_names(result: RunResult) -> list[str]:
    """Return the names of the estimates and histograms of a run."""
    return [name for name in result.outputs if name in ESTIMATES or name in VARIABLES]


def make_dataset(result: RunResult, names: Iterable[str]) -> "xarray.Dataset":
    """Return estimates and histograms, each with `<name>_error`, and what was run."""
    import xarray

    variables: DatasetEntries = {}
    axes: DatasetEntries = {"time": (("time",), result.plan.times, {"units": "d/U"})}
    for name in names:
        if name in ESTIMATES:
            _add_estimate(result, name, variables, axes)
        else:
            _add_histogram(result, name, variables, axes)
    return xarray.Dataset(variables, axes, _describe_run(result)).copy(deep=True)


def _add_estimate(
    result: RunResult, name: str, variables: DatasetEntries, axes: DatasetEntries
) -> None:
    """Add an estimate over time, of vectors and tensors with their components as more axes."""
    estimate: Estimate = getattr(result, name)
    dimensions = ("time", "component", "component2")[: estimate.value.ndim]
    for axis in dimensions[1:]:
        axes[axis] = (axis,), list(COORDINATES[: result.plan.medium.dimension]), {}
    average = ESTIMATES[name]
    attributes = {"units": average.unit, "long_name": average.words}
    _add_with_error(name, estimate, dimensions, attributes, variables)


def _add_histogram(
    result: RunResult, name: str, variables: DatasetEntries, axes: DatasetEntries
) -> None:
    """Add the density of a histogram over the middles of its bins, and their edges."""
    histogram: Histogram = getattr(result, name)
    variable = VARIABLES[name]
    edges = histogram.edges
    axis = f"{variable.symbol}_bin"
    along_axis = {"units": variable.unit, "long_name": variable.words}
    middles = np.sqrt(edges[1:] * edges[:-1])
    axes[axis] = (axis,), middles, along_axis
    variables[f"{variable.symbol}_low"] = (axis,), edges[:-1], along_axis
    variables[f"{variable.symbol}_high"] = (axis,), edges[1:], along_axis
    first_dimension = "run" if name in OF_FLIGHTS else "time"
    attributes = {
        "units": density_unit(variable.unit),
        "long_name": f"density of {variable.words}",
    }
    _add_with_error(name, histogram.density, (first_dimension, axis), attributes, variables)


def _add_with_error(
    name: str,
    estimate: Estimate,
    dimensions: tuple[str, ...],
    attributes: dict[str, str],
    variables: DatasetEntries,
) -> None:
    """Add an estimate and its error, which is in the same unit."""
    of_error = {"units": attributes["units"], "long_name": f"standard error of {name}"}
    variables[name] = dimensions, estimate.value, attributes
    variables[f"{name}_error"] = dimensions, estimate.error, of_error


def _describe_run(result: RunResult) -> dict[str, str]:
    """Return the attributes of a dataset: how tracers ended, what was run, and with which version.

    Whether tracers stuck is told of runs in which they may.
    """
    endings = ["finished", "collision_cap", "trapped", "escaped"]
    if result.plan.capture_speed:
        endings.append("captured")
    counts = [f"{getattr(result.statuses, ending)} {ending}" for ending in endings]
    return {
        "status": ", ".join(counts),
        "scene": json.dumps(result.plan.reported(), default=repr),
        "version": package_version(),
    }


def density_unit(unit: str) -> str:
    """Return the unit of a density of what has this unit."""
    return "U/d" if unit == "d/U" else f"1/{unit}"


def make_dataframe(result: RunResult) -> "pandas.DataFrame":
    """Return a table with a row for each time: each estimate, or component, and its error."""
    import pandas

    names = [name for name in result.outputs if name in ESTIMATES]
    dataset = make_dataset(result, names)
    columns = {"time": result.plan.times}
    units = {"time": "d/U"}
    for variable in dataset.values():
        for column, values in component_columns(variable).items():
            columns[column] = values
            units[column] = variable.attrs["units"]
    frame = pandas.DataFrame(columns)
    frame.attrs = {**dataset.attrs, "units": units}
    return frame


def component_columns(variable: "xarray.DataArray") -> dict[str, np.ndarray]:
    """Return a variable over time by its name, a vector or a tensor as one column a component.

    The column of a component is `<name>_xy` for x and y, and of its error `<name>_xy_error`. What
    does not depend on the time has no columns.
    """
    if variable.ndim == 0:
        return {}
    name = str(variable.name)
    base = name.removesuffix("_error")
    suffix = name.removeprefix(base)
    columns = {}
    for component in np.ndindex(*variable.shape[1:]):
        letters = "".join(COORDINATES[index] for index in component)
        column = f"{base}_{letters}{suffix}" if letters else name
        columns[column] = variable.values[(slice(None), *component)]
    return columns
