"""The pictures of a benchmark, as SVG files that stand alone. Colours after Okabe and Ito."""

from __future__ import annotations

import io
import itertools
import math
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

from kinetics.crosscheck.bench import accuracy, cost, methods, precision, skipping
from kinetics.crosscheck.bench.analysis import front, of_problem, problems
from kinetics.crosscheck.bench.names import typeset
from kinetics.crosscheck.bench.record import MEASURED, Record

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

STYLES: dict[str, dict[str, Any]] = {
    methods.SPECTRAL: {"color": "#0072b2", "marker": "o", "linestyle": "-"},
    methods.CONSERVATIVE: {"color": "#009e73", "marker": "s", "linestyle": "--"},
    methods.STRAIGHTFORWARD: {"color": "#d55e00", "marker": "^", "linestyle": "-."},
    methods.SONINE: {"color": "#cc79a7", "marker": "v", "linestyle": ":"},
    methods.MONTE_CARLO: {"color": "#222222", "marker": "x", "linestyle": (0, (1, 1))},
    methods.PRINTED: {"color": "#777777", "marker": "", "linestyle": (0, (4, 2))},
    cost.PARTICLES: {"color": "#222222", "marker": "x", "linestyle": (0, (1, 1))},
}
STYLE: dict[Any, Any] = {
    "svg.fonttype": "none",
    "svg.hashsalt": "inelastic-lorentz",
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans", "Verdana", "Arial", "sans-serif"],
    "font.size": 10.0,
    "axes.grid": True,
    "grid.color": "#d8d8d8",
    "grid.linewidth": 0.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": 10.0,
    "axes.axisbelow": True,
    "legend.frameon": False,
    "lines.linewidth": 1.4,
    "lines.markersize": 4.5,
}
TIME = "run time, one thread [s]"
ERROR = "largest relative error"
HOW_TO_READ = (
    "A line joins the runs of a method that none of its others beats in time and error; pale: "
    "the others."
)
_DECADES = [10.0**-k for k in range(0, 17, 4)]
README = "work-precision.svg"
_CURVES = (  # where one method has several
    ("#0072b2", "o"), ("#d55e00", "s"), ("#009e73", "^"), ("#cc79a7", "D"), ("#222222", "v"),
)  # fmt: skip


def svg(draw: Callable[[Figure], None], width: float, height: float) -> str:
    """One figure as a file: the same rows give the same text."""
    import matplotlib as mpl
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    buffer = io.StringIO()
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(width, height), layout="constrained", facecolor="white")
        FigureCanvasSVG(figure)
        draw(figure)
        figure.savefig(buffer, format="svg", metadata={"Date": None})
    return buffer.getvalue()


def draw_all(records: list[Record]) -> dict[str, str]:
    """Every figure that has rows, by file name."""
    found: dict[str, str] = {}
    names = problems(records, precision.SECTION)
    scaled = [n for n in names if n.startswith("scaled") and ", e = " in n]
    if scaled:
        # as wide as a page: 900 px
        columns = len({_restitution(n) for n in scaled})
        height = 6.1 if columns > 1 else 5.0
        found[README] = svg(lambda f: _first(f, records, scaled), 9.375, height)
    shown = {
        "precision-scaled.svg": scaled,
        "precision-cooling.svg": [n for n in names if n.startswith("v0(t)")],
        "precision-position.svg": [n for n in names if n.startswith(("<r^2>", "kurtosis", "G(R)"))],
    }
    for file, some in shown.items():
        if some:
            columns = next((n for n in (4, 3) if len(some) % n == 0), 2)
            lines = -(-len(some) // columns)
            found[file] = svg(
                lambda figure, some=some, columns=columns: _work_precision(  # type: ignore[misc]
                    figure, records, some, columns
                ),
                3.7 * columns,
                0.9 + 3.1 * lines,
            )
    if any(r.section == accuracy.SECTION and r.error for r in records):
        found["accuracy.svg"] = svg(lambda f: _accuracy(f.add_subplot(), records), 6.4, 5.2)
    if any(r.section == cost.SECTION and r.seconds for r in records):
        found["cost.svg"] = svg(lambda f: _cost(f, records), 10.0, 8.4)
    if any(r.section == skipping.SECTION and r.seconds for r in records):
        found["skipping.svg"] = svg(lambda f: _skipping(f, records), 10.5, 6.4)
    return found


def _restitution(problem: str) -> float:
    return float(problem.rsplit(" = ", 1)[1])


def _first(figure: Figure, records: list[Record], names: list[str]) -> None:
    """The scaled equation: F(c) above, h and a2 below, a column for each restitution."""
    columns = sorted({_restitution(n) for n in names})
    lines = list(dict.fromkeys(n.rsplit(",", 1)[0] for n in names))
    axes = figure.subplots(len(lines), len(columns), squeeze=False, sharex=True, sharey=True)
    used: dict[str, Any] = {}
    for row, line in zip(axes, lines, strict=True):
        for axis, e in zip(row, columns, strict=True):
            _panel(axis, of_problem(records, precision.SECTION, f"{line}, e = {e:g}"), used)
            if line == lines[0]:
                axis.set_title(f"scaled equation, e = {e:g}")
        row[0].set_ylabel(f"error of {typeset(line.removeprefix('scaled '))}")
    _explain(figure, used)


def _work_precision(figure: Figure, records: list[Record], names: list[str], columns: int) -> None:
    axes = figure.subplots(
        -(-len(names) // columns), columns, squeeze=False, sharex=True, sharey=True
    )
    flat = list(axes.ravel())
    used: dict[str, Any] = {}
    for axis, name in zip(flat, names, strict=False):
        _panel(axis, of_problem(records, precision.SECTION, name), used)
        axis.set_title(typeset(name).replace("t ≤", "\nt ≤"))
    for axis in flat[len(names) :]:
        axis.remove()
    for axis in flat[: len(names)][-columns:]:
        axis.tick_params(labelbottom=True)
    for row in axes:
        row[0].set_ylabel(ERROR)
    _explain(figure, used)


def _panel(axis: Axes, here: list[Record], used: dict[str, Any]) -> None:
    """Every run as a dot; the line joins those that no other run of the method beats."""
    for method in methods.METHODS:
        rows = [r for r in here if r.method == method and r.seconds and r.error is not None]
        if not rows:
            continue
        style = STYLES[method]
        if method == methods.PRINTED:  # at no cost to speak of
            for row in rows:
                used[method] = axis.axhline(row.error or 0.0, **style)
            continue
        axis.plot(*_points(rows), **{**style, "linestyle": "none", "alpha": 0.3})
        (line,) = axis.plot(*_points(front(rows)), **style)
        used.setdefault(method, line)
    axis.set(xscale="log", yscale="log", ylim=(1e-16, 30.0), yticks=_DECADES)
    for one in (axis.xaxis, axis.yaxis):
        # as text of full size; superscripts of the default are small
        one.set_major_formatter(lambda x, _: typeset(f"{x:.0e}"))
    axis.minorticks_off()


def _explain(figure: Figure, used: dict[str, Any]) -> None:
    figure.legend([used[m] for m in used], list(used), loc="outside upper center", ncols=len(used))
    figure.supxlabel(f"{TIME}\n{HOW_TO_READ}", fontsize=10.0)


def _points(rows: Iterable[Record]) -> tuple[list[float], list[float]]:
    """Times and errors; an error of 0 is drawn as 1e-16, one above 10 as 10."""
    pairs = [(r.seconds or 0.0, min(max(r.error or 0.0, 1e-16), 10.0)) for r in rows]
    return [x for x, _ in pairs], [y for _, y in pairs]


def _accuracy(axis: Axes, records: Iterable[Record]) -> None:
    rows = [r for r in records if r.section == accuracy.SECTION and r.asked and r.error]
    kinds = {
        "scaled": ("#0072b2", "o", "scaled equation"),
        "v0(t)": ("#009e73", "s", typeset("v0(t)")),
        "1 + a2": ("#d55e00", "^", typeset("1 + a2(t)")),
        "<r^2>": ("#222222", "x", typeset("<r^2>(t)")),
        "kurtosis": ("#cc79a7", "v", "kurtosis(t)"),
    }
    for k, (start, (colour, marker, label)) in enumerate(kinds.items()):
        some = [r for r in rows if r.problem.startswith(start)]
        shift = 10.0 ** (0.12 * (k - 2.0))  # side by side
        axis.plot(
            [(r.asked or 0.0) * shift for r in some],
            [max(r.error or 0.0, 1e-17) for r in some],
            linestyle="none", marker=marker, color=colour, label=label, markersize=3.5,
            markerfacecolor="none",
        )  # fmt: skip
    ends = [3e-13, 3e-3]
    axis.plot(ends, ends, color="#555555", linewidth=1.0)
    axis.fill_between(ends, [x / 100 for x in ends], ends, color="#e8e8e8", zorder=0)
    axis.text(
        1.2e-11, 2e-11, "asked", rotation=30, rotation_mode="anchor", color="#555555", fontsize=9
    )
    axis.set(
        xscale="log", yscale="log", xlabel="relative error asked (rtol)",
        ylabel="relative error reached", title="grey: within a factor 100 of what was asked",
    )  # fmt: skip
    axis.minorticks_off()
    axis.legend(loc="upper left")


def _cost(figure: Figure, records: list[Record]) -> None:
    """A colour and a marker for each curve; its name and exponent above the panel."""
    here = [r for r in records if r.section == cost.SECTION]
    exponents = {
        (r.problem, r.method, r.setting.removesuffix(cost.EXPONENT)): f", ~ n^{x:.1f}"
        for r in here
        if (x := r.extra.get("exponent")) is not None and math.isfinite(x)
    }
    groups = {"nodes": ["nodes"], "times": ["times"],
              "harmonics or wave numbers": ["harmonics", "wave numbers"],
              "scatterers or tracers": ["scatterers", "tracers"]}  # fmt: skip
    axes = figure.subplots(2, 2, sharey=True)
    for axis, (label, settings) in zip(axes.ravel(), groups.items(), strict=True):
        rows = [r for r in here if r.setting in settings and r.seconds and r.value]
        curves = dict.fromkeys((r.problem, r.method, r.setting) for r in rows)
        for key, (colour, marker) in zip(curves, itertools.cycle(_CURVES)):
            some = [r for r in rows if (r.problem, r.method, r.setting) == key]
            problem, method, setting = key
            text = typeset(problem) + ("" if len(settings) == 1 else f": {setting}")
            text += "" if method == cost.PARTICLES else f" ({method})"
            text += exponents.get(key, "")
            x, y = [r.value or 0.0 for r in some], [r.seconds or 0.0 for r in some]
            axis.plot(x, y, label=text, color=colour, marker=marker)
        axis.set(xscale="log", yscale="log", xlabel=f"number of {label}")
        axis.minorticks_off()
        if curves:
            axis.legend(fontsize=9.0, loc="lower left", bbox_to_anchor=(-0.05, 1.0))
    for axis in axes[:, 0]:
        axis.set_ylabel(TIME)


def _skipping(figure: Figure, records: list[Record]) -> None:
    rows = [
        r
        for r in records
        if r.section == skipping.SECTION and r.status == MEASURED and not r.method.startswith("all")
    ]
    groups = list(dict.fromkeys(r.problem for r in rows))
    sizes = [sum(r.problem == g for r in rows) for g in groups]
    axes = figure.subplots(len(groups), 1, sharex=True, height_ratios=sizes, squeeze=False)
    for axis, group in zip(axes[:, 0], groups, strict=True):
        some = [r for r in rows if r.problem == group][::-1]
        ratios = [r.extra["ratio"] for r in some]
        names = [typeset(r.method) if "<=" in r.method else r.method for r in some]
        bars = axis.barh(range(len(some)), ratios, color="#0072b2", height=0.7)
        axis.bar_label(
            bars, labels=[f" {x:.0f}" if x >= 10 else f" {x:.2g}" for x in ratios], fontsize=8
        )
        axis.set_yticks(range(len(some)), names, fontsize=8)
        axis.set_title(typeset(group), fontsize=9, loc="left")
        axis.set_xscale("log")
        axis.minorticks_off()
        axis.set_xlim(0.5, 2.0 * max(r.extra["ratio"] for r in rows))
        axis.grid(axis="y", visible=False)
    axes[-1, 0].set_xlabel("run time of the whole scene (first bar) over that of the part")
