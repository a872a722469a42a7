"""Draws the series of a figure on one pair of axes."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from kinetics.crosscheck.report.strokes import colours_of, power_of_ten, stroke_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Over more decades minor ticks overlap, and take half the time of drawing.
_MOST_WITH_MINOR_TICKS = 1e3


def draw(data: Mapping[str, Any], axis: "Axes") -> None:
    """Draw every series of one figure on the axis, and label the axis with its units."""
    colours = colours_of(data, data["series"])
    for series, colour in zip(data["series"], colours, strict=True):
        stroke = stroke_of(data, series)
        x, y = _with_gaps(series["x"]), _with_gaps(series["y"])
        if "elinewidth" in stroke:
            error = None if series["error"] is None else _with_gaps(series["error"])
            axis.errorbar(x, y, yerr=error, color=colour, **stroke)
        else:
            axis.plot(x, y, color=colour, **stroke)
    for name in ("x", "y"):
        _set_axis(axis, name, data[name])
    for series, colour in zip(data["series"], colours, strict=True):
        for (low, high), y in zip(series.get("x_range", ()), series["y"], strict=False):
            if y is not None:
                axis.hlines(y, low, high, color=colour, linewidth=1.0)


def _set_axis(axis: "Axes", name: str, spec: Mapping[str, Any]) -> None:
    """Label, scale, limits and ticks of the axis of x or of y."""
    from matplotlib.ticker import NullFormatter, NullLocator

    unit = f"  [{spec['unit']}]" if spec["unit"] else ""
    axis.set(**{f"{name}label": spec["label"] + unit, f"{name}scale": spec["scale"]})
    side = getattr(axis, f"{name}axis")
    if spec["scale"] == "log":
        side.set_major_formatter(power_of_ten)
        side.set_minor_formatter(NullFormatter())
    if spec["limits"] is not None:
        axis.set(**{f"{name}lim": tuple(spec["limits"])})
    if spec["scale"] == "log":
        low, high = getattr(axis, f"get_{name}lim")()
        if high > _MOST_WITH_MINOR_TICKS * low:
            side.set_minor_locator(NullLocator())


def _with_gaps(values: Sequence[float | None]) -> list[float]:
    """NaN for None, which marks where a formula has no value: the line is interrupted there."""
    return [float("nan") if v is None else float(v) for v in values]
