"""The picture of a benchmark, as an SVG file that stands alone. Colours after Okabe and Ito."""

from __future__ import annotations

import io
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from kinetics.crosscheck.bench import methods
from kinetics.crosscheck.bench.analysis import front, of_problems
from kinetics.crosscheck.bench.record import PRECISION, Record
from kinetics.crosscheck.bench.tables import typeset

if TYPE_CHECKING:
    from matplotlib.axes import Axes

STYLES: dict[str, dict[str, Any]] = {
    methods.SPECTRAL: {"color": "#0072b2", "marker": "o", "linestyle": "-"},
    methods.CONSERVATIVE: {"color": "#009e73", "marker": "s", "linestyle": "--"},
    methods.STRAIGHTFORWARD: {"color": "#d55e00", "marker": "^", "linestyle": "-."},
    methods.SONINE: {"color": "#cc79a7", "marker": "v", "linestyle": ":"},
    methods.MONTE_CARLO: {"color": "#222222", "marker": "x", "linestyle": (0, (1, 1))},
}
STYLE: dict[Any, Any] = {
    "svg.fonttype": "none",  # text stays text
    "svg.hashsalt": "inelastic-lorentz",  # the same rows give the same file
    "font.family": "sans-serif",
    "axes.grid": True,
    "grid.color": "#d8d8d8",
    "grid.linewidth": 0.5,
    "axes.titlesize": 10.0,
    "axes.axisbelow": True,
    "lines.linewidth": 1.4,
    "lines.markersize": 4.5,
    **dict.fromkeys(("axes.spines.top", "axes.spines.right", "legend.frameon"), False),
}
HOW_TO_READ = (
    "A line joins the runs of a method that none of its others beats in time and error; pale: "
    "the others."
)


def work_precision(records: Iterable[Record]) -> str | None:
    """Run time against error on the scaled equation and in a field, as text of an SVG file.

    A column for each restitution; a row for F(c), for h and a2, and for each problem in a field.
    The same rows give the same text; None without rows.
    """
    drawn = [r for r in records if r.seconds and r.error is not None]
    panels: dict[str, dict[float, list[Record]]] = {}  # of each quantity, by restitution
    for name, rows in of_problems(drawn, PRECISION).items():
        quantity, _, restitution = name.rpartition(", e = ")
        if name.startswith(("scaled", "field")):
            panels.setdefault(quantity, {})[float(restitution)] = rows
    if not panels:
        return None

    import matplotlib as mpl
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    restitutions = sorted({e for column in panels.values() for e in column})
    buffer = io.StringIO()
    with mpl.rc_context(STYLE):
        # as wide as a page of 900 px
        figure = Figure(
            figsize=(9.375, 1.1 + 2.5 * len(panels)), layout="constrained", facecolor="white"
        )
        FigureCanvasSVG(figure)
        axes = figure.subplots(
            len(panels), len(restitutions), squeeze=False, sharex=True, sharey=True
        )
        legend: dict[str, Any] = {}
        for line, (quantity, column) in zip(axes, panels.items(), strict=True):
            line[0].set_ylabel("largest relative error")
            for axis, e in zip(line, restitutions, strict=True):
                if e not in column:
                    axis.set_axis_off()
                    continue
                legend |= _panel(axis, column[e])
                axis.set_title(typeset(f"{quantity}, e = {e:g}"))
        figure.legend(legend.values(), legend, loc="outside upper center", ncols=len(legend))
        figure.supxlabel(f"run time, one thread [s]\n{HOW_TO_READ}", fontsize=10.0)
        figure.savefig(buffer, format="svg", metadata={"Date": None})
    return buffer.getvalue()


def _panel(axis: Axes, rows: list[Record]) -> dict[str, Any]:
    """Every run as a dot; the line joins those that no other run of the method beats."""
    lines = {}
    for method, style in STYLES.items():
        here = [r for r in rows if r.method == method]
        if here:
            axis.plot(*_points(here), **{**style, "linestyle": "none", "alpha": 0.3})
            (lines[method],) = axis.plot(*_points(front(here)), **style)
    axis.set(xscale="log", yscale="log", ylim=(1e-16, 30.0), yticks=[1e-16, 1e-12, 1e-8, 1e-4, 1.0])
    for one in (axis.xaxis, axis.yaxis):
        # as text of full size; superscripts of the default are small
        one.set_major_formatter(lambda x, _: typeset(f"{x:.0e}"))
    axis.minorticks_off()
    return lines


def _points(rows: Iterable[Record]) -> tuple[list[float], list[float]]:
    """Times and errors; an error of 0 is drawn as 1e-16, one above 10 as 10."""
    pairs = [(r.seconds or 0.0, min(max(r.error or 0.0, 1e-16), 10.0)) for r in rows]
    return [x for x, _ in pairs], [y for _, y in pairs]
