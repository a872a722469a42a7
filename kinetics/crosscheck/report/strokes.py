"""How figures look: a colour and a marker for each restitution, a stroke for each source.

The same restitution has the same colour and marker in every figure of a report; groups that are no
restitutions (an observable, a density, a time) have colours of their own.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

# The colours of a file that stands alone, the page's light ones (after Okabe and Ito, dark enough
# for text). A page maps them to CSS variables, so that one SVG serves light, dark and paper.
INK, FAINT = "#16191d", "#dde1e6"
COLOURS = ("#0072b2", "#c04f00", "#007a58", "#b3478f", "#876600", "#3c4bb0")
"""Of the restitutions of a report, in their order."""
GROUP_COLOURS = ("#8a1538", "#00707a", "#6b4a2b", "#5a6572")
"""Of other groups, in the order in which they appear."""
CSS_VARIABLE = (
    {INK: "var(--ink)", FAINT: "var(--faint)"}
    | {colour: f"var(--series-{i})" for i, colour in enumerate(COLOURS)}
    | {colour: f"var(--group-{i})" for i, colour in enumerate(GROUP_COLOURS)}
)
MARKERS = ("o", "s", "^", "D", "v", "P")
"""Of the restitutions of a report, in their order."""

_SOLID = {"linestyle": "-", "linewidth": 1.5}
_DASHED = {"linestyle": (0, (4, 2)), "linewidth": 1.5}
_DOTTED = {"linestyle": (0, (1, 1.5)), "linewidth": 1.5}
_DASH_DOTTED = {"linestyle": (0, (6, 1.5, 1, 1.5)), "linewidth": 1.5}
_THIN = {"linestyle": "--", "linewidth": 0.9}
_CROSS = {"linestyle": "none", "marker": "x", "markersize": 5.5}
_TICK = {"linestyle": "none", "marker": "_", "markersize": 11.0, "markeredgewidth": 1.8}
_BARS = {"linestyle": "none", "elinewidth": 1.0, "capsize": 0.0}
_FILLED = {"marker": "o", "markersize": 3.8, **_BARS}
_OPEN = {"marker": "o", "markersize": 5.0, "markerfacecolor": "none", **_BARS}
STROKES: dict[str, dict[str, Any]] = {
    **dict.fromkeys(("kinetic equation", "exact", "corrected equation"), _SOLID),
    **dict.fromkeys(("Sonine", "paper, tail", "best explanation"), _DASHED),
    **dict.fromkeys(("Sonine, unstable root", "paper's integral"), _DOTTED),
    **dict.fromkeys(("exact tail", "exact slope", "exponential", "limiting law"), _DOTTED),
    **dict.fromkeys(("paper's fit", "paper, peak", "Gaussian"), _DASH_DOTTED),
    **dict.fromkeys(("scaling state", "extrapolation"), _THIN),
    **dict.fromkeys(("solver", "same bands"), _CROSS),
    "equation, same times": _TICK,
    **dict.fromkeys(("Boltzmann-Grad", "data"), _FILLED),
    **dict.fromkeys(("hard disks", "hard spheres"), _OPEN),
    **dict.fromkeys(("path of the medium", "free path alone"), _THIN),
    "leading order": _DASHED,
    "first order": _DOTTED,
    "fitted second order": _SOLID,
    "particles": _FILLED,
    "all remembered": _OPEN,
    "limit": {"marker": "D", "markersize": 4.2, **_BARS},
    "dilute equation": {"linestyle": "-", "linewidth": 1.1},
    "exact limit": {**_DOTTED, "linewidth": 1.1},
    "zero": {"linestyle": "-", "linewidth": 0.8},  # a guide to the eye, not in the legend
}
"""How the lines and points of each source are drawn; those with bars have the marker of their e."""
AVERAGED = "averaged over"
"""The legend's name for a bar along the time axis, over which a rate is averaged."""

_LEGEND_KEYS = {
    "linestyle", "linewidth", "marker", "markersize", "markerfacecolor", "markeredgewidth",
}  # fmt: skip

STYLE: dict[Any, Any] = {
    "svg.fonttype": "none",
    "svg.hashsalt": "inelastic-lorentz",
    "font.family": "sans-serif",
    "font.size": 10.5,
    "mathtext.default": "it",
    "axes.unicode_minus": True,
    "axes.grid": True,
    "grid.color": FAINT,
    "grid.linewidth": 0.5,
    "legend.fontsize": 9.5,
    **dict.fromkeys(("axes.edgecolor", "axes.labelcolor", "text.color"), INK),
    **dict.fromkeys(("xtick.color", "ytick.color"), INK),
    **dict.fromkeys(("axes.spines.top", "axes.spines.right", "legend.frameon"), False),
    **dict.fromkeys(("figure.facecolor", "axes.facecolor", "savefig.facecolor"), "none"),
}
"""Matplotlib's settings for every figure."""


def restitutions_of(data: Mapping[str, Any]) -> list[float]:
    """The restitutions in the order of their colours: the report's own, then others that appear."""
    lines = [*data["series"], *(data.get("ratio") or {}).get("series", ())]
    found = [s["restitution"] for s in lines if s["restitution"] is not None]
    return list(dict.fromkeys([*data.get("order", ()), *found]))


def group_of(series: Mapping[str, Any]) -> str | None:
    """What a series shares its colour with, in words; None for ink."""
    e = series["restitution"]
    group: str | None = series.get("group") or (None if e is None else f"e = {e:g}")
    return group


def colours_of(data: Mapping[str, Any], series: Sequence[Mapping[str, Any]]) -> list[str]:
    """The colour of each of some series of a figure."""
    order = restitutions_of(data)
    groups = list(dict.fromkeys(s.get("group") for s in data["series"] if s.get("group")))
    colours = []
    for one in series:
        if one.get("group"):
            colours.append(GROUP_COLOURS[groups.index(one["group"]) % len(GROUP_COLOURS)])
        elif one["restitution"] is not None:
            colours.append(COLOURS[order.index(one["restitution"]) % len(COLOURS)])
        else:
            colours.append(INK)
    return colours


def stroke_of(data: Mapping[str, Any], series: Mapping[str, Any]) -> dict[str, Any]:
    """Line or marker of a series; points with error bars have the marker of their restitution."""
    stroke = dict(STROKES[series["source"]])
    e = series["restitution"]
    if "elinewidth" in stroke and e is not None and not series.get("group"):
        stroke["marker"] = MARKERS[restitutions_of(data).index(e) % len(MARKERS)]
    return stroke


def legend_entries(
    data: Mapping[str, Any], labelled: frozenset[str] = frozenset()
) -> list[tuple[str, dict[str, Any]]]:
    """Label and stroke of each entry: every source in ink, then every group in its colour.

    Without those that are `labelled` beside their lines, and without the restitutions where they
    stand over their panels, or on the axis of x.
    """
    lines = [*data["series"], *(data.get("ratio") or {}).get("series", ())]
    entries: dict[str, dict[str, Any]] = {}
    for series in lines:
        source = series["source"]
        if source == "zero" or (source in labelled and group_of(series) is None):
            continue
        stroke = {k: v for k, v in STROKES[source].items() if k in _LEGEND_KEYS}
        entries.setdefault(source, {"color": INK, **stroke})
    if data.get("spans"):
        entries[AVERAGED] = {"color": INK, "linewidth": 4, "alpha": 0.5}
    for series, colour in zip(lines, colours_of(data, lines), strict=True):
        label = group_of(series)
        if label is None or label in STROKES or label in labelled:
            continue
        over_e = data["x"]["label"].startswith("restitution")
        if (data.get("panels") or over_e) and not series.get("group"):
            continue
        entry: dict[str, Any] = {"color": colour, "linewidth": 5}
        if series["restitution"] is not None and not series.get("group"):
            at = restitutions_of(data).index(series["restitution"])
            entry = {"color": colour, "linewidth": 1.5, "marker": MARKERS[at % len(MARKERS)]}
        entries.setdefault(label, entry)
    return list(entries.items())


def power_of_ten(value: float, position: int | None = None) -> str:
    """The label of a logarithmic axis, without the typesetting that matplotlib would do for it."""
    exponent = round(math.log10(value))
    return "10" + str(exponent).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
