"""Pictures of the estimates and histograms of an Ensemble, with matplotlib.

It is imported when it is asked for. The same quantity has the same axes, symbol and scale, as in
figures of the kinetic equation, so that both can be drawn on the same axes: lines are the equation,
points with standard errors are particles. Begin reading with `draw_output`.
"""

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from particles.datasets import (
    RunResult,
    component_columns,
    dataset_names,
    density_unit,
    make_dataset,
)
from particles.outputs import DRIVES, ESTIMATES, OF_FLIGHTS, VARIABLES
from particles.plan import Plan
from particles.results import Estimate, Histogram
from particles.values import refuse

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Last over first time from which on the axis of times is logarithmic. The origin of the number is
#: not recorded; figures of the kinetic equation have the same.
LOGARITHMIC_TIMES_FROM = 30.0
#: Axes in one row of a figure. The origin of the number is not recorded.
AXES_IN_ROW = 3
#: Width in inches of one of several axes. Chosen: labels and a legend beside them have room.
WIDTH_OF_AXES = 4.6
#: Their height in inches. Chosen with the width.
HEIGHT_OF_AXES = 3.4
#: Width of error bars in points. The origin of the number is not recorded.
LINE_WIDTH = 0.8
#: Most times of a histogram that are drawn. Chosen: more cannot be told apart.
MOST_TIMES = 8
#: The legend is so many points below the axes: ticks and label of the abscissa have room.
LEGEND_BELOW = 34.0
#: Colours after which those of matplotlib begin again.
NUMBER_OF_COLOURS = 10
#: What is drawn here is called so in a legend, with `WHAT_IS_SHOWN` behind what tells it apart.
SOURCE = "particles"
WHAT_IS_SHOWN = "mean and standard error"
#: What is shown of one configuration, whose errors are unknown.
WITHOUT_ERRORS = "mean, error unknown"
#: What changes over time as a power of it: where the axis of times is logarithmic, so is theirs.
POWERS_OF_TIME = ("thermal_speed", "msd")


class Style(NamedTuple):
    """How points are drawn: the size of a marker in points, and the opacity of error bars."""

    size: float
    opacity: float


#: Points over time. The origin of their size is not recorded.
OVER_TIME = Style(3.5, 1.0)
#: Points of a histogram. Chosen: its bins of 4 % are 2 points wide on a usual figure, and many of
#: its error bars reach the bottom of a logarithmic axis.
OF_BINS = Style(2.0, 0.4)

#: Symbols of estimates, in matplotlib's mathtext.
SYMBOLS = {
    "thermal_speed": r"$v_0$",
    "a2": r"$a_2$",
    "msd": r"$\langle r^2\rangle$",
    "kurtosis": r"$\langle r^4\rangle/\langle r^2\rangle^2$",
    "collisions": "collisions",
    "velocity_autocorrelation": r"$\langle v(0)\cdot v\rangle$",
    "mean_free_path": "path per collision",
    "drift": r"$\langle v_x\rangle$",
    "drift_of_moving": r"$\langle v_x\rangle$ of those that move",
    "trapped_fraction": "share that is trapped",
    "mean_velocity": r"$\langle v\rangle$",
    "velocity_tensor": r"$\langle v\,v\rangle$",
    "mean_displacement": r"$\langle r\rangle$",
    "dispersion": r"$\mathrm{cov}(r)$",
    "dispersion_parallel": r"$\mathrm{var}\,x$",
    "dispersion_perpendicular": r"$\mathrm{var}\,y$",
    "passed": "share that has passed",
    "mean_passage_time": "mean passage time",
}
#: Symbols of what a histogram counts, and of its density.
SYMBOLS_OF_HISTOGRAMS = {
    "speed_histogram": ("$v$", "$f$"),
    "velocity_component_histogram": ("$|v_x|$", "density"),
    "displacement_histogram": ("$r$", "$g$"),
    "free_path_histogram": ("length of a free flight", "density"),
    "free_time_histogram": ("duration of a free flight", "density"),
}
#: Units of a number density, by the dimension.
UNITS_OF_DENSITY = {2: "d⁻²", 3: "d⁻³"}


def draw_all_outputs(result: RunResult) -> list["Axes"]:
    """Draw in one figure all that depends on time, and all histograms; return the axes."""
    names = [name for name in dataset_names(result) if _has_axis(result, name)]
    all_axes = _new_axes(len(names), ", ".join(describe_system(result.plan)))
    for name, axes in zip(names, all_axes, strict=True):
        _draw(result, name, axes, [])
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
    _draw(result, name, axes, describe_system(result.plan))
    return axes


def _draw(result: RunResult, name: str, axes: "Axes", system: list[str]) -> None:
    """Draw one output of a system that the title names; others are told apart in the legend."""
    output: Estimate | Histogram = getattr(result, name)
    source = _name_of_source(axes, system)
    if isinstance(output, Histogram):
        _draw_histogram(output, name, result.plan.times, axes, source)
    else:
        _draw_over_time(result, name, axes, source)
    _add_legend(axes)


def describe_system(plan: Plan) -> list[str]:
    """Return what a title says of a run: "e = 0.7", "n = 0.04 d⁻²", "hard disks"."""
    drive = plan.drive
    law = drive.restitution
    items = [f"e = {law:.4g}" if isinstance(law, float) else f"e = {law!r}"]
    if drive.tangential_restitution != 1.0:
        items.append(f"e_t = {drive.tangential_restitution:.4g}")
    if drive.mass_ratio < math.inf:
        items.append(f"M/m = {drive.mass_ratio:.4g}")
    dimension = plan.medium.dimension
    density = plan.medium.number_density * plan.medium.diameter**dimension
    items.append(f"n = {density:.4g} {UNITS_OF_DENSITY[dimension]}")
    for argument in ("field", *DRIVES):
        strength = getattr(drive, argument)
        if strength:
            items.append(f"{argument.replace('_', ' ')} = {strength:.4g}")
    items.append(plan.medium.scatterers)
    if dimension == 3:
        items.append("in space")
    return items


def _name_of_source(axes: "Axes", system: list[str]) -> str:
    """Return what points are called in the legend of these axes, whose title is a system.

    The first to be drawn set the title; others are called by what of their system is not in it.
    """
    title = axes.get_title()
    if not title:
        axes.set_title(", ".join(system), fontsize="medium")
        return SOURCE
    in_title = title.split(", ")
    return ", ".join([SOURCE, *(item for item in system if item not in in_title)])


def _first_colour(axes: "Axes") -> int:
    """Return the number of the next colour: what is drawn here and on these axes has had others."""
    labels = [str(container.get_label()) for container in axes.containers]
    return sum(label.startswith(SOURCE) for label in labels)


def _draw_points(
    axes: "Axes",
    x: np.ndarray,
    estimate: Estimate,
    colour: int,
    label: str,
    style: Style,
) -> None:
    """Draw points with standard errors; without a bar where the error is unknown."""
    from matplotlib.colors import to_rgba

    what = WHAT_IS_SHOWN if np.isfinite(estimate.error).any() else WITHOUT_ERRORS
    bars = np.where(np.isfinite(estimate.error), estimate.error, 0.0)
    name_of_colour = f"C{colour % NUMBER_OF_COLOURS}"
    axes.errorbar(
        x,
        estimate.value,
        bars,
        fmt="o",
        ms=style.size,
        elinewidth=LINE_WIDTH,
        color=name_of_colour,
        ecolor=to_rgba(name_of_colour, style.opacity),
        label=f"{label} ({what})",
    )


def _draw_histogram(
    histogram: Histogram, name: str, times: np.ndarray, axes: "Axes", source: str
) -> None:
    """Draw the density at some of the times, or of all flights of a run, on logarithmic axes."""
    edges = histogram.edges
    middles = np.sqrt(edges[1:] * edges[:-1])
    density = histogram.density
    n = len(density.value)
    drawn = np.unique(np.linspace(0, n - 1, min(n, MOST_TIMES)).round().astype(int))
    first = _first_colour(axes)
    for place, k in enumerate(drawn):
        has_samples = density.value[k] > 0.0
        points = Estimate(density.value[k][has_samples], density.error[k][has_samples])
        label = source if name in OF_FLIGHTS else f"{source}, $t$ = {times[k]:.4g} $d/U$"
        _draw_points(axes, middles[has_samples], points, first + place, label, OF_BINS)
    symbol, symbol_of_density = SYMBOLS_OF_HISTOGRAMS[name]
    unit = VARIABLES[name].unit
    axes.set_xlabel(_label(symbol, unit))
    axes.set_ylabel(_label(symbol_of_density, density_unit(unit)))
    axes.set(xscale="log", yscale="log")


def _draw_over_time(result: RunResult, name: str, axes: "Axes", source: str) -> None:
    """Draw an estimate, each component of a vector or a tensor, with standard errors."""
    times = result.plan.times
    dataset = make_dataset(result, [name])
    values = component_columns(dataset[name])
    errors = component_columns(dataset[f"{name}_error"])
    first = _first_colour(axes)
    for k, (column, value) in enumerate(values.items()):
        component = column.removeprefix(name).removeprefix("_")
        label = f"{source}, {component}" if component else source
        estimate = Estimate(value, list(errors.values())[k])
        _draw_points(axes, times, estimate, first + k, label, OVER_TIME)
    axes.set(xlabel=_label("$t$", "d/U"), ylabel=_label(SYMBOLS[name], ESTIMATES[name].unit))
    later = times[times > 0.0]
    if later.size > 1 and later[-1] > LOGARITHMIC_TIMES_FROM * later[0]:
        axes.set_xscale("log")
        if name in POWERS_OF_TIME:
            axes.set_yscale("log")


def _label(symbol: str, unit: str) -> str:
    """Return the label of an axis: a symbol, with its unit in brackets unless that is 1."""
    return symbol if unit == "1" else f"{symbol} [${unit}$]"


def _add_legend(axes: "Axes") -> None:
    """Add the legend: below the axes, so that it covers no data.

    A figure without a layout would cut it off there: then it is where it covers least.
    """
    from matplotlib.transforms import ScaledTranslation

    figure = axes.get_figure(root=True)
    if figure is None or figure.get_layout_engine() is None:
        axes.legend(loc="best", fontsize="small", frameon=False)
        return
    downwards = ScaledTranslation(0.0, -LEGEND_BELOW / 72.0, figure.dpi_scale_trans)
    axes.legend(
        loc="upper center",
        bbox_to_anchor=(0.5, 0.0),
        bbox_transform=axes.transAxes + downwards,
        fontsize="small",
        frameon=False,
    )


def _new_axes(n: int, title: str = "") -> list["Axes"]:
    """Return so many axes in a new figure, AXES_IN_ROW in a row."""
    from matplotlib import pyplot

    columns = min(n, AXES_IN_ROW)
    rows = -(-n // AXES_IN_ROW)
    size = None if n == 1 else (WIDTH_OF_AXES * columns, HEIGHT_OF_AXES * rows)
    figure = pyplot.figure(figsize=size, layout="constrained")
    if title:
        figure.suptitle(title, fontsize="medium")
    return [figure.add_subplot(rows, columns, k + 1) for k in range(n)]
