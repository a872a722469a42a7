"""Arranges a figure: one panel, one for each restitution, or a panel of ratios below; its legend.

Every length is in inches. Margins are set by hand: a layout engine would draw everything a second
time to find them.
"""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from kinetics.crosscheck.report.drawing import draw
from kinetics.crosscheck.report.strokes import (
    colours_of,
    group_of,
    legend_entries,
    restitutions_of,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.ticker import Locator

FigureData = Mapping[str, Any]

# A page scales a figure to its column; a phone's is about as wide as the figure.
WIDTH = 5.0
_LEFT, _RIGHT, _BELOW = 0.74, 0.12, 0.5
_HEIGHT, _RATIO_HEIGHT, _GAP = 3.3, 1.25, 0.16
_PANEL_HEIGHT, _PANEL_GAP, _PANEL_TITLE = 1.75, 0.14, 0.24
_MOST_TICKS = 5
_LEGEND_COLUMNS, _LEGEND_LINE = 3, 0.19
_LABEL_GAP = 0.19
"""Least distance between two labels beside the lines' ends."""
_TIE = 0.18
"""Length of the stroke from a line's end to its label."""
_LETTER = 0.077
"""Width of a letter of a label, on average."""


def arranged(data: FigureData) -> "Figure":
    """The figure, drawn."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    if data.get("panels"):
        figure = _small_multiples(data)
    else:
        figure = _one_above_the_other(data)
    FigureCanvasAgg(figure)  # knows the other formats as well
    return figure


def _new_figure(data: FigureData, height: float, labelled: frozenset[str]) -> "tuple[Figure, Any]":
    """An empty figure with its legend above axes of this height, and a function that adds one.

    The function takes left, bottom, width and height in inches from the lower left corner.
    """
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

    entries = legend_entries(data, labelled)
    lines = math.ceil(len(entries) / _LEGEND_COLUMNS)
    height += _BELOW + (0.1 + _LEGEND_LINE * lines if lines else 0.1)
    figure = Figure(figsize=(WIDTH, height))
    if entries:
        figure.legend(
            handles=[Line2D([], [], **stroke) for _, stroke in entries],
            labels=[label for label, _ in entries],
            loc="upper left", ncols=_LEGEND_COLUMNS, handlelength=2.4, columnspacing=1.2,
            borderaxespad=0.0,
        )  # fmt: skip

    def add(left: float, bottom: float, width: float, tall: float) -> "Axes":
        return figure.add_axes((left / WIDTH, bottom / height, width / WIDTH, tall / height))

    return figure, add


def _one_above_the_other(data: FigureData) -> "Figure":
    """One panel, and below it a panel of ratios if the data have one."""
    ratio = data.get("ratio")
    labelled = frozenset(_line_ends(data["series"]))
    lowest = _BELOW + (_RATIO_HEIGHT + _GAP if ratio else 0.0)
    tall = _HEIGHT - (0.5 if ratio else 0.0)
    figure, add = _new_figure(data, lowest - _BELOW + tall, labelled)
    longest = max((len(_SHORTER.get(label, label)) for label in labelled), default=0)
    width = WIDTH - _LEFT - (_TIE + _LETTER * longest if labelled else _RIGHT)
    upper = add(_LEFT, lowest, width, tall)
    draw(data, upper)
    _label_lines(upper, data, data["series"], tall)
    if ratio:
        lower = add(_LEFT, _BELOW, width, _RATIO_HEIGHT)
        below = {**data, "y": ratio["y"], "series": ratio["series"], "order": restitutions_of(data)}
        draw(below, lower)
        lower.set_xlim(upper.get_xlim())
        _label_lines(lower, below, ratio["series"], _RATIO_HEIGHT, only_ink=True)
        upper.set_xlabel("")
        upper.tick_params(labelbottom=False)
    return figure


def _small_multiples(data: FigureData) -> "Figure":
    """One panel for each restitution, with the lines of all of them in each; common axes."""
    order = restitutions_of(data)
    shown = [e for e in order if any(s["restitution"] == e for s in data["series"])]
    across = min(2, len(shown))
    down = math.ceil(len(shown) / across)
    step = _PANEL_HEIGHT + _PANEL_TITLE + _PANEL_GAP
    figure, add = _new_figure(data, down * step - _PANEL_GAP, frozenset())
    width = (WIDTH - _LEFT - _RIGHT - (across - 1) * _PANEL_GAP) / across
    panels = []
    for k, e in enumerate(shown):
        row, column = divmod(k, across)
        bottom = _BELOW + (down - 1 - row) * step
        panel = add(_LEFT + column * (width + _PANEL_GAP), bottom, width, _PANEL_HEIGHT)
        lines = [s for s in data["series"] if s["restitution"] in (e, None)]
        part = {**data, "series": lines, "order": order}
        draw(part, panel)
        mark_spans(part, panel, [s for s in data.get("spans", ()) if s["restitution"] == e])
        (colour,) = colours_of(data, [next(s for s in lines if s["restitution"] == e)])
        panel.set_title(f"e = {e:g}", loc="left", color=colour, fontsize=10.5, pad=3)
        panels.append(panel)
    _share_axes(panels, across)
    return figure


def _share_axes(panels: "Sequence[Axes]", across: int) -> None:
    """The same limits everywhere; ticks and names at the outer panels only."""
    for name in ("x", "y"):
        limits = [getattr(panel, f"get_{name}lim")() for panel in panels]
        ends = min(low for low, _ in limits), max(high for _, high in limits)
        for panel in panels:
            getattr(panel, f"set_{name}lim")(ends)
            getattr(panel, f"{name}axis").set_major_locator(_few_ticks(panel, name, ends))
    for k, panel in enumerate(panels):
        if k % across:
            panel.set_ylabel("")
            panel.tick_params(labelleft=False)
        if k + across < len(panels):
            panel.set_xlabel("")
            panel.tick_params(labelbottom=False)


def _few_ticks(panel: "Axes", name: str, ends: tuple[float, float]) -> "Locator":
    """Ticks for a small panel, at the same places in every panel."""
    from matplotlib.ticker import FixedLocator, MaxNLocator

    if getattr(panel, f"get_{name}scale")() != "log":
        return MaxNLocator(4, prune="upper" if name == "x" else None)
    low, high = (math.floor(math.log10(end)) for end in ends)
    step = math.ceil((high - low) / _MOST_TICKS)
    return FixedLocator([10.0**k for k in range(high, low, -step)])


def mark_spans(data: FigureData, axis: "Axes", spans: Sequence[Mapping[str, Any]]) -> None:
    """A thick bar above the axis of x from `low` to `high` of each span: an averaging range."""
    for span in spans:
        (colour,) = colours_of(data, [{"restitution": span["restitution"]}])
        axis.plot(
            [span["low"], span["high"]], [0.03, 0.03], transform=axis.get_xaxis_transform(),
            color=colour, linewidth=4, alpha=0.5, solid_capstyle="butt",
        )  # fmt: skip


def _line_ends(series: Sequence[Mapping[str, Any]]) -> dict[str, tuple[int, float, float]]:
    """Index and last point of the line that bears each label: one for each e, one for each source.

    A restitution's label stands at its first line, that of another group at its last; a line
    without either has the name of its source.
    """
    ends: dict[str, tuple[int, float, float]] = {}
    for k, one in enumerate(series):
        if one["error"] is not None or one["source"] in _UNLABELLED:
            continue
        known = [(x, y) for x, y in zip(one["x"], one["y"], strict=True) if y is not None]
        if len(known) < 2:
            continue
        if one.get("group"):
            ends[one["group"]] = (k, *known[-1])
        else:
            ends.setdefault(group_of(one) or one["source"], (k, *known[-1]))
    return ends


_UNLABELLED = ("zero", "solver", "same bands", "equation, same times")
_SHORTER = {"Sonine, unstable root": "Sonine, 2nd root"}
"""What stands beside a line whose name is too long for the margin."""


def _label_lines(
    axis: "Axes",
    data: FigureData,
    series: Sequence[Mapping[str, Any]],
    tall: float,
    only_ink: bool = False,
) -> None:
    """Write beside the right end of each line whose it is, labels apart from each other.

    only_ink: not the restitutions, which another panel names.
    """
    ends = _line_ends(series)
    colours = colours_of(data, series)
    (low, high), (left, right) = axis.get_ylim(), axis.get_xlim()
    labels = []
    for label, (k, x, y) in ends.items():
        if only_ink and series[k]["restitution"] is not None:
            continue
        if x > right or x < left:
            known = [(a, b) for a, b in zip(series[k]["x"], series[k]["y"], strict=True)
                     if b is not None and left <= a <= right]  # fmt: skip
            if not known:
                continue
            x, y = known[-1]
        at = axis.transData.transform((x, min(max(y, low), high)))
        across, up = axis.transAxes.inverted().transform(at)
        labels.append((float(up), float(across), label, colours[k]))
    labels.sort()
    heights = _apart([up for up, *_ in labels], _LABEL_GAP / tall)
    tie = _TIE / (axis.get_position().width * WIDTH)
    for (up, across, label, colour), height in zip(labels, heights, strict=True):
        axis.annotate(
            _SHORTER.get(label, label), xy=(across, up), xytext=(1 + tie, height),
            xycoords="axes fraction",
            color=colour, fontsize=9.5, va="center", ha="left", annotation_clip=False,
            arrowprops={"arrowstyle": "-", "color": colour, "linewidth": 0.6, "shrinkA": 1,
                        "shrinkB": 0, "relpos": (0.0, 0.5)},
        )  # fmt: skip


def _apart(wanted: Sequence[float], gap: float) -> list[float]:
    """Positions in the same order, as near to those wanted as `gap` and the ends 0 and 1 allow."""
    if not wanted:
        return []
    placed = np.array(wanted, dtype=float)
    offsets = gap * np.arange(placed.size)
    # Least squares under the constraint of order: pool neighbours that would come too near.
    blocks: list[list[float]] = []
    for target in (placed - offsets).tolist():
        blocks.append([target, 1.0])
        while len(blocks) > 1 and blocks[-2][0] > blocks[-1][0]:
            (a, n), (b, m) = blocks[-2], blocks[-1]
            blocks[-2:] = [[(a * n + b * m) / (n + m), n + m]]
    level = np.concatenate([np.full(int(n), value) for value, n in blocks])
    room = 1.0 - offsets[-1]
    return (np.clip(level, 0.0, max(room, 0.0)) + offsets).tolist()
