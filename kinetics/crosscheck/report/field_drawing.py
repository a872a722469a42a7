"""Draws the figures of the report in a uniform field: panels above each other, labels at the lines.

The data of a figure are plain lists and strings, as those of `figures`, but in panels:

    {"title", "description", "panels": [{"x", "y", "height", "series": [...], "labels": [...]}]}

A label is {"text", "x", "y", "group", "align"}, in the coordinates of its panel. The group decides
colour and marker; the source decides the stroke. A panel may have "circles", the centres of circles
of radius 1; lengths on its two axes are then equal.
"""

import io
import math
from typing import TYPE_CHECKING, Any

from kinetics.crosscheck.report.figures import (
    COLOURS,
    FAINT,
    INK,
    STYLE,
    Data,
    FigureData,
    embeddable,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ACROSS = ", across the field"
"""Ends the name of a source of what goes across the field; the legend does not repeat those."""
FIRST_GROUPS = ("disks", "spheres")
"""Groups that have the same colour and marker in every figure; others follow as they appear."""
MARKERS = "os^Dv<"
_POINTS: dict[str, Any] = {"linestyle": "none", "elinewidth": 1.0, "capsize": 0.0}
STROKES: dict[str, dict[str, Any]] = {
    "solver": {"linestyle": "-", "linewidth": 1.5},
    f"solver{ACROSS}": {"linestyle": (0, (5, 2)), "linewidth": 1.5},
    "limit": {"linestyle": (0, (1, 1.5)), "linewidth": 1.3},
    "particles": {"markersize": 4.4, **_POINTS},
    f"particles{ACROSS}": {"markersize": 4.4, "markerfacecolor": "none", **_POINTS},
    "path": {"linestyle": "-", "linewidth": 1.0},
    "trapped": {"linestyle": "none", "marker": "x", "markersize": 8, "markeredgewidth": 2.0},
    "zero": {"linestyle": "-", "linewidth": 0.8},  # a guide to the eye, not in the legend
}
"""How the lines and points of each source are drawn."""

_WIDTH, _UNIT, _BELOW, _BETWEEN, _LEGEND = 5.0, 3.2, 0.5, 0.12, 0.34  # inches


def panel(x: Data, y: Data, series: list[Data], labels: list[Data], height: float = 1.0) -> Data:
    """One panel; its height is relative to that of a panel of the usual height."""
    return {"x": x, "y": y, "height": height, "series": series, "labels": labels}


def label(text: str, x: float, y: float, group: str, align: str = "left") -> Data:
    """A text that begins at the point (x, y) of its panel, or (align "right") ends there."""
    return {"text": text, "x": float(x), "y": float(y), "group": group, "align": align}


def svg(name: str, data: FigureData) -> str:
    """One figure as an `<svg>` element with a text alternative, in the colours of the page."""
    return embeddable(drawn(data, "svg").decode(), name, data["title"], data["description"])


def drawn(data: FigureData, kind: str) -> bytes:
    """The figure as a file: kind "svg", "pdf" or "png"."""
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    buffer, panels, order = io.BytesIO(), data["panels"], _groups(data)
    height = _LEGEND + _BELOW + sum(_UNIT * p["height"] + _BETWEEN for p in panels)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(_WIDTH, height))
        FigureCanvasAgg(figure)
        top = height - _LEGEND
        for k, each in enumerate(panels):
            tall = _UNIT * each["height"]
            box = (0.145, (top - tall) / height, 0.83, tall / height)
            axis = figure.add_axes(box)
            _draw_panel(axis, each, order)
            if k < len(panels) - 1:  # only the last has the numbers of the x axis
                axis.set_xlabel("")
                axis.tick_params(labelbottom=False)
            top -= tall + _BETWEEN
        figure.legend(
            handles=_legend(data), loc="upper left", ncols=4, handlelength=2.2,
            columnspacing=1.2, borderaxespad=0.0, bbox_to_anchor=(0.0, 1.0),
        )  # fmt: skip
        dates = {"svg": {"Date": None}, "pdf": {"CreationDate": None}, "png": {"Software": None}}
        figure.savefig(buffer, format=kind, metadata=dates[kind], dpi=200)
    return buffer.getvalue()


def _groups(data: FigureData) -> list[str]:
    """The groups in the order of their colours."""
    found = [line["group"] for each in data["panels"] for line in each["series"] if line["group"]]
    return list(dict.fromkeys((*FIRST_GROUPS, *found)))


def _draw_panel(axis: "Axes", data: FigureData, order: list[str]) -> None:
    """The circles, lines, points and labels of one panel."""
    from matplotlib.collections import EllipseCollection
    from matplotlib.ticker import FuncFormatter, NullFormatter

    colour = {name: COLOURS[k % len(COLOURS)] for k, name in enumerate(order)}
    if "circles" in data:
        size = [2.0] * len(data["circles"])
        circles = EllipseCollection(
            size, size, [0.0] * len(size), units="xy", offsets=data["circles"],
            offset_transform=axis.transData, facecolor=FAINT, edgecolor="none",
        )  # fmt: skip
        axis.add_collection(circles)
        axis.set_aspect("equal")
        axis.grid(False)
    for line in data["series"]:
        stroke = {"color": colour.get(line["group"], INK), **STROKES[line["source"]]}
        x, y = ([float("nan") if v is None else v for v in line[name]] for name in ("x", "y"))
        if line["source"].startswith("particles"):
            marker = MARKERS[order.index(line["group"]) % len(MARKERS)]
            axis.errorbar(x, y, yerr=line["error"], marker=marker, **stroke)
        else:
            axis.plot(x, y, **stroke)
    for name in ("x", "y"):
        spec, side = data[name], getattr(axis, f"{name}axis")
        axis.set(**{f"{name}label": spec["label"], f"{name}scale": spec["scale"]})
        if spec["scale"] == "log":
            side.set_major_formatter(FuncFormatter(_power))
            side.set_minor_formatter(NullFormatter())
        if spec["limits"] is not None:
            axis.set(**{f"{name}lim": tuple(spec["limits"])})
    for text in data["labels"]:
        axis.text(
            text["x"], text["y"], text["text"], color=colour.get(text["group"], INK),
            ha=text["align"], va="center",
        )  # fmt: skip
    axis.yaxis.set_label_coords(-0.122, 0.5)  # within the figure, whatever the numbers beside it


def _power(value: float, position: int | None = None) -> str:
    """The label of a power of ten on a logarithmic axis."""
    if 0.05 < value < 2000.0:
        return f"{value:g}"
    exponent = round(math.log10(value))
    return "10" + str(exponent).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def _legend(data: FigureData) -> list[Any]:
    """Every source that is drawn once, in ink."""
    from matplotlib.lines import Line2D

    drawn = {line["source"] for each in data["panels"] for line in each["series"]}
    drawn -= {"zero", "path"}
    entries = []
    for source, stroke in STROKES.items():
        if source in drawn and not source.endswith(ACROSS):
            shown = {k: v for k, v in stroke.items() if k not in ("elinewidth", "capsize")}
            marker = "o" if source.startswith("particles") else ""
            shown = {"color": INK, "marker": marker, "label": source, **shown}
            entries.append(Line2D([], [], **shown))
    return entries
