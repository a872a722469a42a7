"""Curves of one quantity of a dataset, or of all, with matplotlib.

The same quantity has the same axes whoever draws it: labels and scales depend on its name and on
the times alone, and `particles` draws its own by the same rules. So that several can be drawn on
the same axes, a legend says "equation", and what differs from the system in the title.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics.errors import InputError
from kinetics.results.frame import COMPONENTS, MODEL_ERROR, free_dimensions, split_components
from kinetics.results.labels import axis_label, typeset

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D

#: Columns of axes in a figure of all quantities at most. The origin is not recorded.
MAX_COLUMNS = 3
#: Width of each of the axes in inches. The origin of the number is not recorded.
AXES_WIDTH = 4.6
#: Height of each of the axes in inches. The origin of the number is not recorded.
AXES_HEIGHT = 3.4
#: So many times (or angles), at most, have a curve of their own: more cannot be told apart.
MAX_CURVES = 8
#: Top of the axis of densities over their maximum. Chosen: room above the curve.
DENSITY_TOP = 3.0
#: Bottom of the axis of densities over their maximum. Chosen: low enough to show their tails.
DENSITY_BOTTOM = 1e-7
#: Opacity of the band of the model error: the curve stays visible.
BAND_ALPHA = 0.25
#: An axis is logarithmic if the largest number on it is more than so many times the smallest.
LOGARITHMIC_ABOVE = 30.0
#: What changes over time as a power of it: where the axis of times is logarithmic, so is theirs.
POWERS_OF_TIME = ("thermal_speed", "temperature", "msd", "diffusion_coefficient")
#: Smallest ratio of the ends of a logarithmic ordinate: a constant then is a straight line, and
#: there is a labelled tick.
LEAST_RATIO_OF_ORDINATE = 10.0
#: What the curves of this package are called in a legend.
SOURCE = "equation"
#: Columns of a legend below the axes, if none of its entries has more than so many characters.
LEGEND_COLUMNS = 2
#: Characters of an entry that fit in one of these columns.
MAX_CHARACTERS_IN_COLUMN = 32
#: The legend is so many points below the axes: ticks and label of the abscissa have room.
LEGEND_BELOW = 34.0
#: Colours after which those of matplotlib begin again.
N_COLOURS = 10


def draw(
    name: str,
    components: list[xarray.DataArray],
    ax: Axes | None,
    system: Sequence[str] = (),
    bottom: float = DENSITY_BOTTOM,
    model_error: xarray.DataArray | None = None,
) -> Axes:
    """Draw a quantity, given by its real and imaginary part; wide ranges on logarithmic axes.

    A band of the model error is drawn about a quantity of the same shape.

    Raises InputError for a quantity that depends on no or on more than two coordinates.

    Parameters
    ----------
    name : of the quantity
    components : its values, or the real and the imaginary ones
    ax : to draw on; None for new ones
    system : what the title says of the system, in several items
    bottom : the least density that is shown, over the largest
    model_error : the error of the equation itself, of the shape of the quantity; None for none
    """
    real = components[0]
    dimensions = free_dimensions(real)
    if not 1 <= len(dimensions) <= 2:
        what = f"plot draws what depends on one or two of {dimensions}"
        raise InputError(f"name: got {name!r}; {what}")
    ax = ax if ax is not None else new_axes()
    source = source_on(ax, SOURCE, system)
    abscissa = real[dimensions[-1]]
    first_colour = n_curves_of(ax, SOURCE)
    lines: list[Line2D] = []
    for component, style in zip(components, ("-", "--"), strict=False):
        words = [source]
        if len(components) > 1:
            words.append("real part" if style == "-" else "imaginary part")
        for index, (label, curve) in enumerate(_curves(component).items()):
            colour = f"C{(first_colour + index) % N_COLOURS}"
            full_label = ", ".join([*words, label] if label else words)
            lines += ax.plot(abscissa, curve, style, color=colour, label=full_label)
    if model_error is not None and model_error.dims == real.dims:
        _draw_band(lines, real, model_error, ax)
    symbol = abscissa.attrs.get("symbol", str(abscissa.name))
    ax.set_xlabel(axis_label(symbol, abscissa.attrs["units"]))
    ax.set_ylabel(axis_label(_symbol(real), real.attrs["units"]))
    _scale_axes(ax, name, abscissa, components, bottom)
    add_legend(ax)
    return ax


def _draw_band(
    lines: Sequence[Line2D], quantity: xarray.DataArray, model_error: xarray.DataArray, ax: Axes
) -> None:
    """Draw the model error as a band about the line of each component of a quantity."""
    errors = split_components(model_error).values()
    curves = split_components(quantity).values()
    for line, curve, error in zip(lines, curves, errors, strict=False):
        lower = curve.values - error.values
        upper = curve.values + error.values
        ax.fill_between(
            line.get_xdata(), lower, upper, color=line.get_color(), alpha=BAND_ALPHA, linewidth=0.0
        )


def new_axes() -> Axes:
    """Return axes of a new figure of pyplot, in which nothing is cut off."""
    from matplotlib import pyplot

    _, ax = pyplot.subplots(layout="constrained")
    return ax


def draw_all(
    quantities: Iterable[xarray.DataArray],
    system: Sequence[str] = (),
    bottom: float = DENSITY_BOTTOM,
) -> NDArray[Any]:
    """Draw each quantity in axes of its own in one new figure; return the array of axes.

    Quantities that are zero, or depend on no or more than two coordinates, are left out.
    """
    errors: dict[str, xarray.DataArray] = {}
    values: list[xarray.DataArray] = []
    for array in quantities:
        name = str(array.name)
        if name.endswith(MODEL_ERROR):
            errors[name] = array
        else:
            values.append(array)
    groups = _group_complex(values)
    axes = axes_of_figure(len(groups), system)
    for ax, (name, components) in zip(axes, groups.items(), strict=True):
        draw(name, components, ax, (), bottom, errors.get(name + MODEL_ERROR))
    return np.array(axes)


def axes_of_figure(n: int, system: Sequence[str]) -> list[Axes]:
    """Return so many axes in one new figure, whose title is the system."""
    from matplotlib import pyplot

    columns = max(1, min(MAX_COLUMNS, n))
    rows = math.ceil(n / columns)
    size = (AXES_WIDTH * columns, AXES_HEIGHT * max(1, rows))
    figure = pyplot.figure(figsize=size, layout="constrained")
    figure.suptitle(", ".join(system), fontsize="medium")
    return [figure.add_subplot(rows, columns, index + 1) for index in range(n)]


def source_on(ax: Axes, source: str, system: Sequence[str]) -> str:
    """Return what curves are called in the legend of these axes, whose title is a system.

    The first to be drawn set the title; others are called by what of their system is not in it.
    """
    title = ax.get_title()
    if not title:
        ax.set_title(", ".join(system), fontsize="medium")
        return source
    in_title = title.split(", ")
    return ", ".join([source, *(item for item in system if item not in in_title)])


def n_curves_of(ax: Axes, source: str) -> int:
    """Return how many curves on these axes are of a source: the next has the colour after them."""
    count = 0
    for line in ax.lines:
        label = str(line.get_label())
        if label.startswith(source) and "imaginary" not in label:
            count += 1
    return count


def add_legend(ax: Axes) -> None:
    """Add the legend: below the axes, so that it covers no data.

    A figure without a layout would cut it off there: then, and if it is one short word, it is where
    it covers least.
    """
    from matplotlib.transforms import ScaledTranslation

    _, labels = ax.get_legend_handles_labels()
    figure = ax.get_figure(root=True)
    has_layout = figure is not None and figure.get_layout_engine() is not None
    if not has_layout or labels == [SOURCE]:
        ax.legend(loc="best", fontsize="small", frameon=False)
        return
    assert figure is not None
    is_short = max(map(len, labels)) <= MAX_CHARACTERS_IN_COLUMN
    downwards = ScaledTranslation(0.0, -LEGEND_BELOW / 72.0, figure.dpi_scale_trans)
    ax.legend(
        loc="upper center",
        bbox_to_anchor=(0.5, 0.0),
        bbox_transform=ax.transAxes + downwards,
        ncols=min(LEGEND_COLUMNS, len(labels)) if is_short else 1,
        fontsize="small",
        frameon=False,
    )


def _group_complex(quantities: Iterable[xarray.DataArray]) -> dict[str, list[xarray.DataArray]]:
    """Return what can be drawn: the parts of each quantity, real and imaginary, by its name."""
    groups: dict[str, list[xarray.DataArray]] = {}
    for quantity in quantities:
        can_be_drawn = 1 <= len(free_dimensions(quantity)) <= 2
        if can_be_drawn and quantity.values.any():
            name = str(quantity.name).removesuffix("_real").removesuffix("_imag")
            groups.setdefault(name, []).append(quantity)
    return groups


def _symbol(quantity: xarray.DataArray) -> str:
    """Return the symbol of a quantity; of a complex one without the words for its part."""
    symbol = str(quantity.attrs.get("symbol", quantity.name))
    return symbol.removeprefix("Re ").removeprefix("Im ")


def _scale_axes(
    ax: Axes,
    name: str,
    abscissa: xarray.DataArray,
    components: list[xarray.DataArray],
    bottom: float,
) -> None:
    """Make the axes of wide ranges logarithmic, and show the tails of densities."""
    x = abscissa.values
    is_over_time = abscissa.name == "time"
    if is_over_time:
        x = x[x > 0.0]  # a logarithmic axis leaves out time 0
    if _is_wide(x):
        ax.set_xscale("log")
    y = components[0].values
    maximum = y.max(where=np.isfinite(y), initial=0.0)
    if name.endswith(("density", "vdf")) and maximum > 0.0:
        show_tails(ax, float(maximum), bottom)
    elif is_over_time:
        if name in POWERS_OF_TIME and ax.get_xscale() == "log":
            ax.set_yscale("log")
            _widen_ordinate(ax)
    elif len(components) == 1 and _is_wide(y):
        ax.set_yscale("log")


def show_tails(ax: Axes, maximum: float, bottom: float = DENSITY_BOTTOM) -> None:
    """Make the ordinate of a density logarithmic, down to this fraction of its maximum."""
    ax.set(yscale="log", ylim=(bottom * maximum, DENSITY_TOP * maximum))


def _widen_ordinate(ax: Axes) -> None:
    """Let a logarithmic ordinate span a decade at least."""
    low, high = ax.get_ylim()
    if 0.0 < low < high < LEAST_RATIO_OF_ORDINATE * low:
        middle = math.sqrt(low * high)
        half = math.sqrt(LEAST_RATIO_OF_ORDINATE)
        ax.set_ylim(middle / half, middle * half)


def _curves(quantity: xarray.DataArray) -> dict[str, ArrayLike]:
    """Return the curves by their labels: components, or a function at some of the times.

    The label of a quantity that is one curve is empty.
    """
    dimensions = free_dimensions(quantity)
    if len(dimensions) == 1:
        if set(quantity.dims).isdisjoint(COMPONENTS):
            return {"": quantity}
        of_components: dict[str, ArrayLike] = {}
        for name, curve in split_components(quantity).items():
            letters = name.removeprefix(f"{quantity.name}_")
            of_components[letters] = curve
        return of_components
    parameter = quantity[dimensions[0]]
    if parameter.size == 1 and dimensions[0] == "angle":  # isotropic
        return {"": quantity.values[0]}
    symbol = str(parameter.attrs.get("symbol", dimensions[0]))
    unit = parameter.attrs["units"]
    curves: dict[str, ArrayLike] = {}
    for index in shown_curves(parameter.size):
        label = f"{typeset(symbol)} = {parameter.values[index]:.4g}"
        curves[label if unit == "1" else f"{label} {typeset(unit)}"] = quantity.values[index]
    return curves


def shown_curves(n: int) -> NDArray[np.int64]:
    """Return which of so many curves are drawn: `MAX_CURVES` at most, the first and the last."""
    return np.unique(np.linspace(0, n - 1, min(n, MAX_CURVES)).round().astype(int))


def _is_wide(values: NDArray[Any]) -> bool:
    """Return whether numbers are positive and span so much that their axis is logarithmic."""
    finite = values[np.isfinite(values)]
    if finite.size < 2:
        return False
    smallest = finite.min()
    return bool(smallest > 0.0 and finite.max() > LOGARITHMIC_ABOVE * smallest)
