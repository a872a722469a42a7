"""Pictures of the estimates and histograms of an Ensemble, with matplotlib.

It is imported when it is asked for. Begin reading with `draw_output`.
"""

from typing import TYPE_CHECKING

import numpy as np

from particles.datasets import (
    RunResult,
    component_columns,
    dataset_names,
    density_unit,
    make_dataset,
)
from particles.outputs import ESTIMATES, OF_FLIGHTS, VARIABLES
from particles.results import Estimate, Histogram
from particles.values import refuse

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Last over first time from which on the axis of times is logarithmic. The origin of the number is
#: not recorded.
LOGARITHMIC_TIMES_FROM = 30.0
#: Axes in one row of a figure. The origin of the number is not recorded.
AXES_IN_ROW = 3
#: Width in inches of one of several axes. The origin of the number is not recorded.
WIDTH_OF_AXES = 4.2
#: Their height in inches. The origin of the number is not recorded.
HEIGHT_OF_AXES = 3.2
#: Size of a marker in points. The origin of the number is not recorded.
MARKER_SIZE = 3.5
#: Width of a line between markers in points. The origin of the number is not recorded.
LINE_WIDTH = 0.8


def draw_all_outputs(result: RunResult) -> list["Axes"]:
    """Draw in one figure all that depends on time, and all histograms; return the axes."""
    names = [name for name in dataset_names(result) if _has_axis(result, name)]
    all_axes = _new_axes(len(names))
    for name, axes in zip(names, all_axes, strict=True):
        draw_output(result, name, axes)
    return all_axes


def _has_axis(result: RunResult, name: str) -> bool:
    """Tell whether an estimate or a histogram can be drawn; without times only those of flights."""
    if result.plan.times.size == 0:
        return name in OF_FLIGHTS
    return name in VARIABLES or getattr(result, name).value.ndim > 0


def draw_output(result: RunResult, name: str, axes: "Axes | None" = None) -> "Axes":
    """Draw an estimate over time, or the density of a histogram, on axes, new ones if None."""
    output: Estimate | Histogram = getattr(result, name)
    if isinstance(output, Estimate) and output.value.ndim == 0:
        refuse("name", name, "it is one number; plot draws what depends on the time")
    if axes is None:
        (axes,) = _new_axes(1)
    if isinstance(output, Histogram):
        _draw_histogram(output, name, result.plan.times, axes)
    else:
        _draw_over_time(result, name, axes)
    axes.legend()
    return axes


def _draw_histogram(histogram: Histogram, name: str, times: np.ndarray, axes: "Axes") -> None:
    """Draw the density at each time, or of all flights of a run, on logarithmic axes."""
    variable = VARIABLES[name]
    for k, density in enumerate(histogram.density.value):
        label = variable.words if name in OF_FLIGHTS else f"t = {times[k]:.4g} d/U"
        positive = np.where(density > 0.0, density, np.nan)
        axes.stairs(positive, histogram.edges, baseline=None, label=label)
    axes.set_xlabel(f"{variable.words} [{variable.unit}]")
    axes.set_ylabel(f"density [{density_unit(variable.unit)}]")
    axes.set(xscale="log", yscale="log")


def _draw_over_time(result: RunResult, name: str, axes: "Axes") -> None:
    """Draw an estimate, each component of a vector or a tensor, with standard errors."""
    times = result.plan.times
    dataset = make_dataset(result, [name])
    values = component_columns(dataset[name])
    errors = component_columns(dataset[f"{name}_error"])
    for (label, line), error in zip(values.items(), errors.values(), strict=True):
        bars = np.where(np.isfinite(error), error, 0.0)
        axes.errorbar(times, line, bars, marker="o", ms=MARKER_SIZE, lw=LINE_WIDTH, label=label)
    axes.set(xlabel="t [d/U]", ylabel=f"{name} [{ESTIMATES[name].unit}]")
    is_wide = times.size > 1 and 0.0 < times[0] * LOGARITHMIC_TIMES_FROM < times[-1]
    axes.set_xscale("log" if is_wide else "linear")


def _new_axes(n: int) -> list["Axes"]:
    """Return so many axes in a new figure, AXES_IN_ROW in a row."""
    from matplotlib import pyplot

    columns = min(n, AXES_IN_ROW)
    rows = -(-n // AXES_IN_ROW)
    size = None if n == 1 else (WIDTH_OF_AXES * columns, HEIGHT_OF_AXES * rows)
    figure = pyplot.figure(figsize=size, layout="constrained")
    return [figure.add_subplot(rows, columns, k + 1) for k in range(n)]
