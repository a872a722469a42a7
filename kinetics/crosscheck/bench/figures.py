"""The pictures of a benchmark, as SVG files that stand alone. Colours after Okabe and Ito."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

from kinetics.crosscheck.bench import accuracy, cost, methods, precision, skipping
from kinetics.crosscheck.bench.analysis import front, of_problem, problems
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
    "font.size": 10.0,
    "axes.grid": True,
    "grid.color": "#d8d8d8",
    "grid.linewidth": 0.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": 10.0,
    "legend.frameon": False,
    "lines.linewidth": 1.4,
    "lines.markersize": 4.5,
}
TIME = "run time, one thread [s]"


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
    shown = {
        "precision-scaled.svg": [n for n in names if n.startswith("scaled")],
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
                0.7 + 3.1 * lines,
            )
    if any(r.section == accuracy.SECTION and r.error for r in records):
        found["accuracy.svg"] = svg(lambda f: _accuracy(f.add_subplot(), records), 5.4, 4.6)
    if any(r.section == cost.SECTION and r.seconds for r in records):
        found["cost.svg"] = svg(lambda f: _cost(f, records), 13.0, 4.4)
    if any(r.section == skipping.SECTION and r.seconds for r in records):
        found["skipping.svg"] = svg(lambda f: _skipping(f, records), 10.5, 6.4)
    return found


def _work_precision(figure: Figure, records: list[Record], names: list[str], columns: int) -> None:
    """Every run as a dot; the line joins those that no other run of the method beats."""
    axes = figure.subplots(
        -(-len(names) // columns), columns, squeeze=False, sharex=True, sharey=True
    )
    flat = list(axes.ravel())
    used: dict[str, Any] = {}
    for axis, name in zip(flat, names, strict=False):
        here = of_problem(records, precision.SECTION, name)
        for method in methods.METHODS:
            rows = [r for r in here if r.method == method and r.seconds and r.error is not None]
            if not rows:
                continue
            style = STYLES[method]
            if method == methods.PRINTED:  # at no cost to speak of
                for row in rows:
                    used[method] = axis.axhline(row.error or 0.0, **style)
                continue
            axis.plot(*_points(rows), **{**style, "linestyle": "none", "alpha": 0.4})
            (line,) = axis.plot(*_points(front(rows)), **style)
            used.setdefault(method, line)
        title = name.replace("t <=", "\nt <=")
        axis.set(xscale="log", yscale="log", title=title, ylim=(1e-16, 30.0))
    for axis in flat[len(names) :]:
        axis.remove()
    for axis in flat[: len(names)][-columns:]:
        axis.set_xlabel(TIME)
        axis.tick_params(labelbottom=True)
    for row in axes:
        row[0].set_ylabel("largest relative error")
    figure.legend([used[m] for m in used], list(used), loc="outside upper center", ncols=len(used))


def _points(rows: Iterable[Record]) -> tuple[list[float], list[float]]:
    """Times and errors; an error of 0 is drawn as 1e-16, one above 10 as 10."""
    pairs = [(r.seconds or 0.0, min(max(r.error or 0.0, 1e-16), 10.0)) for r in rows]
    return [x for x, _ in pairs], [y for _, y in pairs]


def _accuracy(axis: Axes, records: Iterable[Record]) -> None:
    rows = [r for r in records if r.section == accuracy.SECTION and r.asked and r.error]
    kinds = {
        "scaled": ("#0072b2", "o", "scaled equation"),
        "v0(t)": ("#009e73", "s", "v0(t)"),
        "1 + a2": ("#d55e00", "^", "1 + a2(t)"),
        "<r^2>": ("#222222", "x", "<r²>(t)"),
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
    axis.text(1.2e-12, 4e-12, "asked", rotation=38, color="#555555", fontsize=9)
    axis.set(
        xscale="log", yscale="log", xlabel="relative error asked (rtol)",
        ylabel="relative error reached", title="grey: within a factor 100 of what was asked",
    )  # fmt: skip
    axis.legend(loc="upper left")


def _cost(figure: Figure, records: list[Record]) -> None:
    rows = [r for r in records if r.section == cost.SECTION and r.seconds and r.value]
    groups = {"nodes": ["nodes"], "times": ["times"],
              "harmonics, wave numbers": ["harmonics", "wave numbers"],
              "scatterers, tracers": ["scatterers", "tracers"]}  # fmt: skip
    axes = figure.subplots(1, len(groups), sharey=True)
    for axis, (label, settings) in zip(axes, groups.items(), strict=True):
        curves = dict.fromkeys(
            (r.problem, r.method, r.setting) for r in rows if r.setting in settings
        )
        for k, key in enumerate(curves):
            some = [r for r in rows if (r.problem, r.method, r.setting) == key]
            style = STYLES[key[1]] | {"linestyle": ("-", "--", ":", "-.")[k % 4]}
            text = key[0] if len(settings) == 1 else f"{key[0]}: {key[2]}"
            method = "" if key[1] == cost.PARTICLES else f" ({key[1]})"
            axis.plot(
                [r.value for r in some], [r.seconds for r in some], label=text + method, **style
            )
        axis.set(xscale="log", yscale="log", xlabel=f"{label} [number]")
        if curves:
            axis.legend(fontsize=7.5, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    axes[0].set_ylabel(TIME)


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
        bars = axis.barh(range(len(some)), ratios, color="#0072b2", height=0.7)
        axis.bar_label(
            bars, labels=[f" {x:.0f}" if x >= 10 else f" {x:.2g}" for x in ratios], fontsize=8
        )
        axis.set_yticks(range(len(some)), [r.method for r in some], fontsize=8)
        axis.set_title(group, fontsize=9, loc="left")
        axis.set_xscale("log")
        axis.set_xlim(0.5, 2.0 * max(r.extra["ratio"] for r in rows))
        axis.grid(axis="y", visible=False)
    axes[-1, 0].set_xlabel("run time of the whole scene (first bar) over that of the part")
