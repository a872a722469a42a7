"""Curves of one quantity of a dataset, or of all, with matplotlib."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics.errors import InputError
from kinetics.results.frame import MODEL_ERROR, free_dimensions, split_components

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes

#: Columns of axes in a figure of all quantities, and the size of each of the axes in inches.
MAX_COLUMNS = 3
AXES_WIDTH = 4.2
AXES_HEIGHT = 3.2
#: So many times (or angles), at most, have a curve of their own: more cannot be told apart.
MAX_CURVES = 8
#: Densities are drawn over this many times their maximum, down to this fraction of it: their tails
#: are of interest.
DENSITY_TOP = 3.0
DENSITY_BOTTOM = 1e-7
#: Opacity of the band of the model error: the curve stays visible.
BAND_ALPHA = 0.25
#: An axis is logarithmic if the largest number on it is more than so many times the smallest.
LOGARITHMIC_ABOVE = 30.0


def draw(
    name: str,
    components: list[xarray.DataArray],
    ax: Axes | None,
    model_error: xarray.DataArray | None = None,
) -> Axes:
    """Draw a quantity, given by its real and imaginary part; wide ranges on logarithmic axes.

    A band of the model error is drawn about a quantity of the same shape.

    Raises InputError for a quantity that depends on no or on more than two coordinates.
    """
    real = components[0]
    dimensions = free_dimensions(real)
    if not 1 <= len(dimensions) <= 2:
        what = f"plot draws what depends on one or two of {dimensions}"
        raise InputError(f"name: got {name!r}; {what}")
    if ax is None:
        from matplotlib import pyplot

        _, ax = pyplot.subplots(layout="constrained")
    abscissa = real[dimensions[-1]]
    for component, style in zip(components, ("-", "--"), strict=False):
        ax.set_prop_cycle(None)  # imaginary parts are broken lines of the same colours
        for label, curve in _curves(component).items():
            ax.plot(abscissa, curve, style, label=label)
    if model_error is not None and model_error.dims == real.dims:
        _draw_band(ax, real, model_error)
    has_several_curves = len(ax.lines) > 1
    is_function_over_time = len(dimensions) == 2 and dimensions[0] != "angle"
    if has_several_curves or is_function_over_time:
        ax.legend()
    ax.set(xlabel=_label(abscissa), ylabel=_label(real))
    _scale_axes(ax, name, abscissa, components)
    return ax


def _draw_band(ax: Axes, quantity: xarray.DataArray, model_error: xarray.DataArray) -> None:
    """Draw the model error as a band about each component of a quantity."""
    errors = split_components(model_error).values()
    curves = split_components(quantity).values()
    for line, curve, error in zip(list(ax.lines), curves, errors, strict=False):
        lower = curve.values - error.values
        upper = curve.values + error.values
        ax.fill_between(
            line.get_xdata(), lower, upper, color=line.get_color(), alpha=BAND_ALPHA, linewidth=0.0
        )


def draw_all(quantities: Mapping[Any, xarray.DataArray]) -> NDArray[Any]:
    """Draw each quantity in axes of its own in one new figure; return the array of axes.

    Quantities that are zero, or depend on no or more than two coordinates, are left out.
    """
    from matplotlib import pyplot

    errors = {name: array for name, array in quantities.items() if name.endswith(MODEL_ERROR)}
    drawn = [array for name, array in quantities.items() if name not in errors]
    groups = _group_complex(drawn)
    columns = min(MAX_COLUMNS, len(groups))
    rows = math.ceil(len(groups) / columns)
    size = (AXES_WIDTH * columns, AXES_HEIGHT * rows)
    figure = pyplot.figure(figsize=size, layout="constrained")
    for index, (name, components) in enumerate(groups.items()):
        ax = figure.add_subplot(rows, columns, index + 1)
        draw(name, components, ax, errors.get(name + MODEL_ERROR))
    return np.array(figure.axes)


def _group_complex(quantities: Iterable[xarray.DataArray]) -> dict[str, list[xarray.DataArray]]:
    """Return what can be drawn: the parts of each quantity, real and imaginary, by its name."""
    groups: dict[str, list[xarray.DataArray]] = {}
    for quantity in quantities:
        can_be_drawn = 1 <= len(free_dimensions(quantity)) <= 2
        if can_be_drawn and quantity.values.any():
            name = str(quantity.name).removesuffix("_real").removesuffix("_imag")
            groups.setdefault(name, []).append(quantity)
    return groups


def _scale_axes(
    ax: Axes, name: str, abscissa: xarray.DataArray, components: list[xarray.DataArray]
) -> None:
    """Make the axes of wide ranges logarithmic, and show the tails of densities."""
    x = abscissa.values
    if abscissa.name == "time":
        x = x[x > 0.0]  # a logarithmic axis leaves out time 0
    if _is_wide(x):
        ax.set_xscale("log")
    y = components[0].values
    maximum = y.max(where=np.isfinite(y), initial=0.0)
    if name.endswith(("density", "vdf")) and maximum > 0.0:
        ax.set(yscale="log", ylim=(DENSITY_BOTTOM * maximum, DENSITY_TOP * maximum))
    elif len(components) == 1 and _is_wide(y):
        ax.set_yscale("log")


def _curves(quantity: xarray.DataArray) -> dict[str, ArrayLike]:
    """Return the curves by their labels: components, or a function at some of the times."""
    dimensions = free_dimensions(quantity)
    if len(dimensions) == 1:
        of_components: dict[str, ArrayLike] = {}
        for name, curve in split_components(quantity).items():
            of_components[name.replace("_", " ")] = curve
        return of_components
    parameter = quantity[dimensions[0]]
    symbol = parameter.attrs.get("symbol", dimensions[0])
    unit = parameter.attrs["units"].replace("1", "")
    shown = np.linspace(0, parameter.size - 1, MAX_CURVES).round().astype(int)
    curves: dict[str, ArrayLike] = {}
    for index in shown:
        label = f"{symbol} = {parameter.values[index]:.4g} {unit}".strip()
        curves[label] = quantity.values[index]
    return curves


def _label(quantity: xarray.DataArray) -> str:
    """Return symbol and unit as the label of an axis, with typographic brackets and powers."""
    symbol = quantity.attrs.get("symbol", str(quantity.name)).replace("_", " ")
    units = quantity.attrs["units"]
    text = symbol if units == "1" else f"{symbol} [{units}]"
    for plain, printed in {"<": "⟨", ">": "⟩", "^2": "²", "^3": "³"}.items():
        text = text.replace(plain, printed)
    return text


def _is_wide(values: NDArray[Any]) -> bool:
    """Return whether numbers are positive and span so much that their axis is logarithmic."""
    finite = values[np.isfinite(values)]
    if finite.size < 2:
        return False
    smallest = finite.min()
    return bool(smallest > 0.0 and finite.max() > LOGARITHMIC_ABOVE * smallest)
