"""Draws the figures of the report in a uniform field: panels above each other, labels at the lines.

The data of a figure are plain lists and strings, as those of `figures`, but in panels:

    {"title", "description", "panels": [{"x", "y", "height", "series": [...], "labels": [...]}]}

A label is {"text", "x", "y", "group", "align"}, in the coordinates of its panel. The group, disks
or spheres, decides colour and marker; the source decides the stroke.
"""

import io
from typing import TYPE_CHECKING, Any

from kinetics.crosscheck.report.figures import (
    COLOURS,
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
COLOUR = {"disks": COLOURS[0], "spheres": COLOURS[1]}
MARKER = {"disks": "o", "spheres": "s"}
_POINTS: dict[str, Any] = {"linestyle": "none", "elinewidth": 1.0, "capsize": 0.0}
STROKES: dict[str, dict[str, Any]] = {
    "solver": {"linestyle": "-", "linewidth": 1.5},
    f"solver{ACROSS}": {"linestyle": (0, (5, 2)), "linewidth": 1.5},
    "limit": {"linestyle": (0, (1, 1.5)), "linewidth": 1.3},
    "particles": {"markersize": 4.4, **_POINTS},
    f"particles{ACROSS}": {"markersize": 4.4, "markerfacecolor": "none", **_POINTS},
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

    buffer, panels = io.BytesIO(), data["panels"]
    height = _LEGEND + _BELOW + sum(_UNIT * p["height"] + _BETWEEN for p in panels)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(_WIDTH, height))
        FigureCanvasAgg(figure)
        top = height - _LEGEND
        for k, each in enumerate(panels):
            tall = _UNIT * each["height"]
            box = (0.145, (top - tall) / height, 0.83, tall / height)
            _draw_panel(figure.add_axes(box), each, last=k == len(panels) - 1)
            top -= tall + _BETWEEN
        figure.legend(
            handles=_legend(data), loc="upper left", ncols=4, handlelength=2.2,
            columnspacing=1.2, borderaxespad=0.0, bbox_to_anchor=(0.0, 1.0),
        )  # fmt: skip
        dates = {"svg": {"Date": None}, "pdf": {"CreationDate": None}, "png": {"Software": None}}
        figure.savefig(buffer, format=kind, metadata=dates[kind], dpi=200)
    return buffer.getvalue()


def _draw_panel(axis: "Axes", data: FigureData, last: bool) -> None:
    """The lines, points and labels of one panel; only the last has the numbers of the x axis."""
    from matplotlib.ticker import FuncFormatter, NullFormatter

    for line in data["series"]:
        stroke = dict(STROKES[line["source"]])
        colour = COLOUR.get(line["group"], INK)
        x, y = ([float("nan") if v is None else v for v in line[name]] for name in ("x", "y"))
        if line["source"].startswith("particles"):
            marker = MARKER[line["group"]]
            axis.errorbar(x, y, yerr=line["error"], color=colour, marker=marker, **stroke)
        else:
            axis.plot(x, y, color=colour, **stroke)
    for name in ("x", "y"):
        spec, side = data[name], getattr(axis, f"{name}axis")
        axis.set(**{f"{name}label": spec["label"], f"{name}scale": spec["scale"]})
        if spec["scale"] == "log":
            side.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            side.set_minor_formatter(NullFormatter())
        if spec["limits"] is not None:
            axis.set(**{f"{name}lim": tuple(spec["limits"])})
    for text in data["labels"]:
        axis.text(
            text["x"], text["y"], text["text"], color=COLOUR.get(text["group"], INK),
            ha=text["align"], va="center",
        )  # fmt: skip
    axis.yaxis.set_label_coords(-0.148, 0.5)  # within the figure, whatever the numbers beside it
    if not last:
        axis.set_xlabel("")
        axis.tick_params(labelbottom=False)


def _legend(data: FigureData) -> list[Any]:
    """Every source that is drawn once, in ink."""
    from matplotlib.lines import Line2D

    drawn = {line["source"] for each in data["panels"] for line in each["series"]} - {"zero"}
    entries = []
    for source, stroke in STROKES.items():
        if source in drawn and not source.endswith(ACROSS):
            shown = {k: v for k, v in stroke.items() if k not in ("elinewidth", "capsize")}
            marker = "o" if source.startswith("particles") else ""
            entries.append(Line2D([], [], color=INK, marker=marker, label=source, **shown))
    return entries
