"""The pictures of a benchmark, as SVG files that stand alone. Colours after Okabe and Ito."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

from kinetics.crosscheck.bench import methods
from kinetics.crosscheck.bench.analysis import front, of_problems
from kinetics.crosscheck.bench.record import PRECISION, Record
from kinetics.crosscheck.bench.tables import typeset

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
HOW_TO_READ = (
    "A line joins the runs of a method that none of its others beats in time and error; pale: "
    "the others."
)
_DECADES = [10.0**-k for k in range(0, 17, 4)]


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
    """Run time against error, a file for each kind of problem that has rows, by file name."""
    drawn = [r for r in records if r.seconds and r.error is not None]
    problems = of_problems(drawn, PRECISION)
    kinds: dict[str, str | tuple[str, ...]] = {
        "work-precision.svg": "scaled",  # the README's
        "precision-cooling.svg": "v0(t)",
        "precision-position.svg": ("<r^2>", "kurtosis", "G(R)"),
    }
    found: dict[str, str] = {}
    for file, start in kinds.items():
        some = {name: rows for name, rows in problems.items() if name.startswith(start)}
        if not some:
            continue
        # the README's is as wide as a page: 900 px
        columns = next((n for n in (4, 3) if len(some) % n == 0), 2)
        width, height = 9.375, 0.9 + 2.6 * -(-len(some) // columns)
        if start == "scaled":
            # a column for each restitution, F(c) above, h and a2 below
            some = dict(sorted(some.items(), key=lambda item: (_family(item[0]), _last(item[0]))))
            columns = max(1, len(some) // len({_family(name) for name in some}))
            height = 6.1 if columns > 1 else 5.0
        found[file] = svg(
            lambda figure, some=some, columns=columns: _panels(figure, some, columns),  # type: ignore[misc]
            width if columns < 4 else 3.7 * columns,
            height,
        )
    return found


def _family(problem: str) -> str:
    return problem.rpartition(", e = ")[0]


def _last(problem: str) -> float:
    return float(problem.rpartition(" = ")[2])


def _panels(figure: Figure, problems: dict[str, list[Record]], columns: int) -> None:
    lines = -(-len(problems) // columns)
    axes = figure.subplots(lines, columns, squeeze=False, sharex=True, sharey=True)
    flat = list(axes.ravel())
    used: dict[str, Any] = {}
    for axis, (name, rows) in zip(flat, problems.items(), strict=False):
        _panel(axis, rows, used)
        axis.set_title(typeset(name).replace("t ≤", "\nt ≤"))
    for axis in flat[len(problems) :]:
        axis.remove()
    for axis in flat[: len(problems)][-columns:]:
        axis.tick_params(labelbottom=True)
    for row in axes:
        row[0].set_ylabel("largest relative error")
    figure.legend([used[m] for m in used], list(used), loc="outside upper center", ncols=len(used))
    figure.supxlabel(f"run time, one thread [s]\n{HOW_TO_READ}", fontsize=10.0)


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


def _points(rows: Iterable[Record]) -> tuple[list[float], list[float]]:
    """Times and errors; an error of 0 is drawn as 1e-16, one above 10 as 10."""
    pairs = [(r.seconds or 0.0, min(max(r.error or 0.0, 1e-16), 10.0)) for r in rows]
    return [x for x, _ in pairs], [y for _, y in pairs]
