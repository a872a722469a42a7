"""Figures: the data of one, as it stands in the JSON file, and the function that draws it.

A figure's data are plain lists and strings:

    {"title", "description", "x": {"label", "unit", "scale", "limits"}, "y": {...},
     "series": [{"source", "restitution", "group", "x", "y", "error"}]}

`source` is who says so and decides the stroke; `restitution` decides the colour, None is ink. A
series may have a "group" (a text, or None) instead, which then decides the colour.
"""

import io
import math
import re
from collections.abc import Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from kinetics.crosscheck.strict_json import plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Data = dict[str, Any]
FigureData = Mapping[str, Any]

# The colours of a file that stands alone, the page's light ones (after Okabe and Ito). A page maps
# them to CSS variables, so that one SVG serves light, dark and paper.
INK, FAINT = "#16191d", "#dde1e6"
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#b3478f", "#9a7500", "#3c4bb0")
CSS_VARIABLE = {INK: "var(--ink)", FAINT: "var(--faint)"} | {
    colour: f"var(--series-{i})" for i, colour in enumerate(COLOURS)
}

_SOLID = {"linestyle": "-", "linewidth": 1.5}
_DASHED = {"linestyle": (0, (4, 2)), "linewidth": 1.5}
_DOTTED = {"linestyle": (0, (1, 1.5)), "linewidth": 1.5}
_DASH_DOTTED = {"linestyle": (0, (6, 1.5, 1, 1.5)), "linewidth": 1.5}
_THIN = {"linestyle": "--", "linewidth": 0.9}
_CROSS = {"linestyle": "none", "marker": "x", "markersize": 5.5}
_BARS = {"linestyle": "none", "elinewidth": 1.0, "capsize": 0.0}
_DOT = {"marker": "o", "markersize": 3.6, **_BARS}
_SQUARE = {"marker": "s", "markersize": 4.8, "markerfacecolor": "none", **_BARS}
STROKES: dict[str, dict[str, Any]] = {
    **dict.fromkeys(("kinetic equation", "exact"), _SOLID),
    **dict.fromkeys(("Sonine", "paper, tail", "best explanation"), _DASHED),
    **dict.fromkeys(("Sonine, unstable root", "paper's integral"), _DOTTED),
    **dict.fromkeys(("exact tail", "exact slope", "exponential"), _DOTTED),
    **dict.fromkeys(("paper's fit", "paper, peak", "Gaussian"), _DASH_DOTTED),
    **dict.fromkeys(("scaling state", "extrapolation"), _THIN),
    **dict.fromkeys(("solver", "same bands"), _CROSS),
    **dict.fromkeys(("Boltzmann-Grad", "data"), _DOT),
    **dict.fromkeys(("hard disks", "hard spheres"), _SQUARE),
    **dict.fromkeys(("dilute equation", "path of the medium"), _THIN),
    "leading order": _DASHED,
    "first order": _DOTTED,
    "fitted second order": _SOLID,
    "particles": _DOT,
    "all remembered": _SQUARE,
    "limit": {"marker": "D", "markersize": 4.2, **_BARS},
    "exact limit": {**_DOTTED, "linewidth": 1.1},
    "zero": {"linestyle": "-", "linewidth": 0.8},  # a guide to the eye, not in the legend
}
"""How the lines and points of each source are drawn."""

# In inches: the page scales a figure to its column, a phone's is about this wide.
_WIDTH, _AXIS_HEIGHT, _BELOW_AXIS = 5.0, 3.4, 0.5
_LEGEND_COLUMNS = 3
# Over more decades minor ticks overlap, and take half the time of drawing.
_MOST_WITH_MINOR_TICKS = 1e3

STYLE: dict[Any, Any] = {
    "svg.fonttype": "none",
    "svg.hashsalt": "inelastic-lorentz",
    "font.family": "sans-serif",
    "font.size": 10.5,
    "mathtext.default": "it",
    "axes.grid": True,
    "grid.color": FAINT,
    "grid.linewidth": 0.5,
    "legend.fontsize": 9.5,
    **dict.fromkeys(("axes.edgecolor", "axes.labelcolor", "text.color"), INK),
    **dict.fromkeys(("xtick.color", "ytick.color"), INK),
    **dict.fromkeys(("axes.spines.top", "axes.spines.right", "legend.frameon"), False),
    **dict.fromkeys(("figure.facecolor", "axes.facecolor", "savefig.facecolor"), "none"),
}


def axis(
    label: str, unit: str = "", scale: str = "linear", limits: tuple[float, float] | None = None
) -> Data:
    """One axis; limits None leaves them to what is drawn."""
    ends = None if limits is None else list(limits)
    return {"label": label, "unit": unit, "scale": scale, "limits": ends}


def series(
    source: str,
    x: ArrayLike,
    y: ArrayLike,
    error: ArrayLike | None = None,
    restitution: float | None = None,
    group: str | None = None,
) -> Data:
    """One line, or points with their standard errors; x, y and error of one length."""
    return {
        "source": source,
        "restitution": restitution,
        "group": group,
        "x": _floats(x),
        "y": _floats(y),
        "error": None if error is None else _floats(error),
    }


def _floats(values: ArrayLike) -> list[float | None]:
    """Floats, and None for what has no finite value: JSON has no NaN."""
    floats: list[float | None] = plain(np.atleast_1d(np.asarray(values, dtype=float)))
    return floats


def draw(data: FigureData, axis: "Axes") -> None:
    """Draw every series of one figure on the axis, and label the axis with its units."""
    from matplotlib.ticker import NullFormatter, NullLocator

    for series, colour in zip(data["series"], _colours(data), strict=True):
        stroke = STROKES[series["source"]]
        x, y = _with_gaps(series["x"]), _with_gaps(series["y"])
        if "elinewidth" in stroke:
            error = None if series["error"] is None else _with_gaps(series["error"])
            axis.errorbar(x, y, yerr=error, color=colour, **stroke)
        else:
            axis.plot(x, y, color=colour, **stroke)
    for name in ("x", "y"):
        spec = data[name]
        unit = f"  [{spec['unit']}]" if spec["unit"] else ""
        axis.set(**{f"{name}label": spec["label"] + unit, f"{name}scale": spec["scale"]})
        if spec["scale"] == "log":
            side = getattr(axis, f"{name}axis")
            side.set_major_formatter(_power_of_ten)
            side.set_minor_formatter(NullFormatter())
        if spec["limits"] is not None:
            axis.set(**{f"{name}lim": tuple(spec["limits"])})
        if spec["scale"] == "log":
            low, high = getattr(axis, f"get_{name}lim")()
            if high > _MOST_WITH_MINOR_TICKS * low:
                side.set_minor_locator(NullLocator())


def legend_entries(data: FigureData) -> list[tuple[str, dict[str, Any]]]:
    """Label and stroke of each entry: every source once in ink, then every restitution once."""
    entries: dict[str, dict[str, Any]] = {}
    for series in data["series"]:
        if series["source"] == "zero":
            continue
        stroke = {k: v for k, v in STROKES[series["source"]].items() if k in _LEGEND_KEYS}
        entries.setdefault(series["source"], {"color": INK, **stroke})
    for series, colour in zip(data["series"], _colours(data), strict=True):
        label = _group(series)
        if label is not None and label not in STROKES:
            entries.setdefault(label, {"color": colour, "linewidth": 5})
    return list(entries.items())


_LEGEND_KEYS = {"linestyle", "linewidth", "marker", "markersize", "markerfacecolor"}


def _group(series: Mapping[str, Any]) -> str | None:
    """What a series shares its colour with, as the legend says it; None for ink."""
    e = series["restitution"]
    group: str | None = series.get("group") or (None if e is None else f"e = {e:g}")
    return group


def _colours(data: FigureData) -> list[str]:
    """The colour of each series: groups take theirs in the order in which they appear."""
    groups = [_group(s) for s in data["series"]]
    order = list(dict.fromkeys(g for g in groups if g is not None))
    return [INK if g is None else COLOURS[order.index(g) % len(COLOURS)] for g in groups]


def _with_gaps(values: Sequence[float | None]) -> list[float]:
    """NaN for None, which marks where a formula has no value: the line is interrupted there."""
    return [float("nan") if v is None else float(v) for v in values]


def svg(name: str, data: FigureData) -> str:
    """One figure as an `<svg>` element that can stand in a page beside others.

    Its ids carry the figure's name, its colours are the page's CSS variables, its text alternative
    is the title and description of the data, and the same data give the same text.
    """
    return embeddable(_drawn(data, "svg").decode(), name, data["title"], data["description"])


def figure_file(name: str, data: FigureData, kind: str) -> bytes:
    """One figure as a file of its own, in the page's light colours: kind "svg", "pdf" or "png"."""
    drawn = _drawn(data, kind)
    if kind != "svg":
        return drawn
    head, body = drawn.decode().split("<svg", 1)
    attributes, rest = body.split(">", 1)
    alternative = _alternative(data["title"], data["description"])
    return f'{head}<svg{attributes} role="img">{alternative}{rest}'.encode()


def _alternative(title: str, description: str, prefix: str | None = None) -> str:
    """What a reader hears who cannot see the figure, with ids if there is a prefix for them."""
    ids = ("", "") if prefix is None else (f' id="{prefix}title"', f' id="{prefix}desc"')
    return f"<title{ids[0]}>{escape(title)}</title><desc{ids[1]}>{escape(description)}</desc>"


def _drawn(data: FigureData, kind: str) -> bytes:
    """The figure as matplotlib's file."""
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

    buffer = io.BytesIO()
    with mpl.rc_context(STYLE):
        entries = legend_entries(data)
        legend_height = 0.12 + 0.19 * math.ceil(len(entries) / _LEGEND_COLUMNS)
        height = _AXIS_HEIGHT + _BELOW_AXIS + legend_height
        figure = Figure(figsize=(_WIDTH, height))
        FigureCanvasAgg(figure)  # knows the other formats as well
        # Margins set by hand: a layout engine would draw everything a second time to find them.
        bottom, top = _BELOW_AXIS / height, _AXIS_HEIGHT / height
        draw(data, figure.add_axes((0.145, bottom, 0.83, top)))
        figure.legend(
            handles=[Line2D([], [], **stroke) for _, stroke in entries],
            labels=[label for label, _ in entries],
            loc="upper left", ncols=_LEGEND_COLUMNS, handlelength=2.4, columnspacing=1.2,
            borderaxespad=0.0,
        )  # fmt: skip
        dates = {"svg": {"Date": None}, "pdf": {"CreationDate": None}, "png": {"Software": None}}
        figure.savefig(buffer, format=kind, metadata=dates[kind], dpi=200)
    return buffer.getvalue()


def _power_of_ten(value: float, position: int | None = None) -> str:
    """The label of a logarithmic axis, without the typesetting that matplotlib would do for it."""
    exponent = round(math.log10(value))
    return "10" + str(exponent).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def embeddable(text: str, name: str, title: str, description: str) -> str:
    """Matplotlib's file as an element: own ids, own colours, no metadata, a text alternative."""
    prefix = f"fig-{name}-"
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = re.sub(r'\s+xmlns(:\w+)?="[^"]*"', "", text).replace("xlink:href=", "href=")
    text = re.sub(r'\b(id="|href="#)(?=[^"])', rf"\1{prefix}", text)
    text = text.replace("url(#", f"url(#{prefix}")
    for colour, variable in CSS_VARIABLE.items():
        text = text.replace(colour, variable)
    head, body = text.split(">", 1)
    # The page gives the size; the view box keeps the proportions.
    head = re.sub(r'\s(width|height)="[^"]*"', "", head)
    return (
        f'{head} role="img" aria-labelledby="{prefix}title {prefix}desc">'
        f"{_alternative(title, description, prefix)}{body.strip()}"
    )
