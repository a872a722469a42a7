"""The figures of a report: one function each, in plain matplotlib, with its title and its caption.

The same restitution has the same colour and marker in every figure; a stroke is who says so. An SVG
in a page takes its colours from the page's CSS variables: one picture serves light and dark.
"""

import io
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from html import escape
from importlib.resources import files
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, MaxNLocator, NullLocator
from numpy.typing import ArrayLike

from kinetics import ScalingSolution, sonine
from kinetics.crosscheck.report import runs
from kinetics.crosscheck.report.rows import OBSERVABLES, PAPER_KURTOSIS, kept
from kinetics.crosscheck.report.systems import Driven
from kinetics.crosscheck.words import numeral

INK, FAINT = "#16191d", "#dde1e6"
# of the restitutions of a report, in their order (after Okabe and Ito, dark enough for text)
COLOURS = ("#0072b2", "#c04f00", "#007a58", "#b3478f", "#876600", "#3c4bb0")
# of what is no restitution: disks and spheres, observables, densities
GROUPS = ("#8a1538", "#00707a", "#6b4a2b", "#5a6572")
VARIABLES = {INK: "var(--ink)", FAINT: "var(--faint)"}
VARIABLES |= {colour: f"var(--series-{i})" for i, colour in enumerate(COLOURS)}
VARIABLES |= {colour: f"var(--group-{i})" for i, colour in enumerate(GROUPS)}
MARKERS = "os^DvP"
STYLE = str(files("kinetics.crosscheck") / "templates" / "report.mplstyle")
_DASHES: dict[str, Any] = {
    **dict.fromkeys((runs.SONINE, "paper, tail"), (0, (4, 2))),
    **dict.fromkeys(("paper's integral", "limiting law"), (0, (1, 1.5))),
    **dict.fromkeys((runs.FIT, "paper, peak", "Gaussian"), (0, (6, 1.5, 1, 1.5))),
}
_TIME, _RESTITUTION = "time $t$  [d/U]", "restitution $e$"
_FINE = np.sqrt(1.0 - np.geomspace(1.0, 1e-6, 120))  # e, ever closer to 1

Made = tuple[Any, dict[str, str]]  # a figure, and the words that its caption leaves open


@dataclass(frozen=True)
class Drawn:
    """A figure with its words."""

    name: str
    title: str
    caption: str
    figure: Any

    def file(self, kind: str) -> bytes:
        """As a file of its own, in the page's light colours: kind "svg", "pdf" or "png"."""
        buffer = io.BytesIO()
        dates = {"svg": {"Date": None}, "pdf": {"CreationDate": None}, "png": {"Software": None}}
        with mpl.rc_context(fname=STYLE):
            self.figure.savefig(buffer, format=kind, metadata=dates[kind], dpi=200)
        return buffer.getvalue()

    def svg(self) -> str:
        """As an element of a page: own ids, the page's colours, and what a screen reader says."""
        prefix, text = f"fig-{self.name}-", self.file("svg").decode()
        text = re.sub(r"<metadata>.*?</metadata>", "", text[text.index("<svg") :], flags=re.DOTALL)
        text = re.sub(r'\s+xmlns(:\w+)?="[^"]*"', "", text).replace("xlink:href=", "href=")
        text = re.sub(r'\b(id="|href="#)(?=[^"])', rf"\1{prefix}", text)
        text = text.replace("url(#", f"url(#{prefix}")
        for colour, variable in VARIABLES.items():
            text = text.replace(colour, variable)
        head, body = text.split(">", 1)
        head = re.sub(r'\s(width|height)="[^"]*"', "", head)  # the page gives the size
        words = "".join(
            f'<{tag} id="{prefix}{tag}">{escape(said)}</{tag}>'
            for tag, said in (("title", self.title), ("desc", self.caption))
        )
        named = f'role="img" aria-labelledby="{prefix}title {prefix}desc"'
        return f"{head} {named}>{words}{body.strip()}"


class _Sheet:
    """Axes in a grid of rows of these heights, in inches, and a legend of all that is on them."""

    def __init__(
        self, system: Any, heights: Sequence[float] = (2.9,), columns: int = 1, panels: bool = False
    ) -> None:
        self.figure, self.system, self.columns = Figure(layout="constrained"), system, columns
        FigureCanvasAgg(self.figure)  # knows the other formats as well
        self.tall = sum(heights) + len(heights) * (0.35 if panels else 0.15)  # panels have titles
        axes = self.figure.subplots(
            len(heights), columns, squeeze=False, sharex="all", sharey="all" if panels else "none",
            height_ratios=heights,
        )  # fmt: skip
        self.axes = list(axes.flat)
        self._legend: dict[str, dict[str, Any]] = {}

    def style(self, key: Any) -> tuple[str, str]:
        """Colour and marker of a restitution, of a group (its name and number), or ink."""
        if key is None:
            return INK, "o"
        k = key[1] if isinstance(key, tuple) else self.system.restitutions.index(key)
        colours = GROUPS if isinstance(key, tuple) else COLOURS
        return colours[k % len(colours)], MARKERS[k % len(MARKERS)]

    def _enter(self, source: str, stroke: dict[str, Any], key: Any, named: bool) -> None:
        self._legend.setdefault(source, {"color": INK, **stroke})
        if key is not None and named:
            colour, marker = self.style(key)
            label = key[0] if isinstance(key, tuple) else f"{self.system.parameter} = {key:g}"
            self._legend.setdefault(label, {"color": colour, "marker": marker, "linestyle": "-"})

    def line(
        self, ax: Any, source: str, x: ArrayLike, y: ArrayLike, key: Any = None, named: bool = True
    ) -> None:
        """A line; its key is in the legend only if `named`."""
        stroke = {"linestyle": _DASHES.get(source, "-")}
        x, y = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
        ax.plot(x, y, color=self.style(key)[0], **stroke)
        self._enter(source, stroke, key, named)

    def points(
        self, ax: Any, source: str, x: ArrayLike, measured: runs.Measured, key: Any = None,
        named: bool = True, largest: float = math.inf,
    ) -> None:  # fmt: skip
        """Points with bars of one standard error; without those of a larger error."""
        x, value, error = np.broadcast_arrays(x, measured.value, measured.error)
        seen = np.isfinite(value) & (error > 0) & (error < largest)
        if ax.get_yscale() == "log":
            seen &= (value > 0) & (error < 0.5 * value)
        colour, marker = self.style(key)
        stroke: dict[str, Any] = {"linestyle": "none", "markersize": 3.8}
        if source.startswith("hard"):
            stroke |= {"markerfacecolor": "none", "markersize": 4.6}
        bars = {"color": colour, "marker": marker, "elinewidth": 1.0}
        ax.errorbar(x[seen], value[seen], error[seen], **bars, **stroke)
        self._enter(source, {"marker": "o", **stroke}, key, named)

    def marks(self, ax: Any, source: str, x: ArrayLike, y: ArrayLike, marker: str) -> None:
        """Marks without errors, in ink."""
        stroke = {"marker": marker, "linestyle": "none", "markersize": 6.0}
        ax.plot(x, y, color=INK, **stroke)
        self._enter(source, stroke, None, False)

    def done(self, x: str, *y: str) -> Any:
        """Labels (one of y for each row, or for all), ticks and the legend; the figure."""
        lines, many = math.ceil(len(self._legend) / 3), len(self.axes) > 1
        self.figure.set_size_inches(5.0, self.tall + 0.5 + 0.2 * lines)
        for k, ax in enumerate(self.axes):
            row, column = divmod(k, self.columns)
            if k >= len(self.axes) - self.columns:
                ax.set_xlabel(ax.get_xlabel() or x)
            if column == 0:
                ax.set_ylabel(y[min(row, len(y) - 1)])
            for side in (ax.xaxis, ax.yaxis):
                if side.get_scale() != "log":
                    prune = "both" if self.columns > 1 else None
                    side.set_major_locator(
                        MaxNLocator(4 if many else 6, prune=prune, steps=[1, 2, 2.5, 5, 10])
                    )
                    continue
                low, top = side.get_view_interval()
                subs = (1.0,) if top > 30 * low else (1.0, 2.0, 5.0)
                side.set_major_locator(LogLocator(subs=subs, numticks=5 if many else 7))
                side.set_minor_locator(NullLocator())
                powers = subs == (1.0,)
                side.set_major_formatter((lambda x, _: numeral(x, ".0e")) if powers else "{x:g}")
        self.figure.legend(
            handles=[Line2D([], [], **stroke) for stroke in self._legend.values()],
            labels=list(self._legend), loc="outside upper left", ncols=3,
        )  # fmt: skip
        return self.figure


def figures(results: runs.Results) -> list[Drawn]:
    """Every figure that the results allow; the first three are those of the head of the page.

    The "figures" of `kept` have title and caption of each, in which "{words}" are filled.
    """
    cases, chosen = results.cases, {"msd": msd, "position": position, "kurtosis": kurtosis}
    if isinstance(results.system, Driven):
        decays = cases[0].solved is None
        chosen = {
            "thermal_speed": _driven("thermal_speed", "$v_0$  [U]", "log" if decays else "linear"),
            "spread": _driven("msd", r"$\langle r^2\rangle$  [l²]"),
        }
        if "field" in results.system.drive:
            falling = _driven("drift_from_rest", "$⟨v_z⟩$  [√(gl)]", time="[√(l/g)]")
            chosen = {"drift": drift, "dispersion": dispersion, "from_rest": falling}
    elif results.cooling:
        chosen = {"cooling_rate": cooling_rate, "msd": msd, "vdf": vdf, **chosen}
    drawn = []
    with mpl.rc_context(fname=STYLE):
        for name, make in chosen.items():
            figure, words = make(results)
            title, caption = kept()["figures"][name]
            caption = caption.format(**words).strip()
            drawn.append(Drawn(name.replace("_", "-"), title, caption, figure))
    return drawn


def _panels(results: runs.Results, cases: Sequence[runs.Case]) -> tuple[_Sheet, list[Any]]:
    """A sheet with a panel for each restitution, and pairs of a case and its panel."""
    across = min(2, len(cases))
    tall = (1.75,) * math.ceil(len(cases) / across)
    sheet = _Sheet(results.system, tall, across, panels=True)
    for spare in sheet.axes[len(cases) :]:
        spare.set_axis_off()
    for case, ax in zip(cases, sheet.axes, strict=False):
        colour = sheet.style(case.restitution)[0]
        ax.set_title(f"e = {case.restitution:g}", loc="left", color=colour, fontsize=10.5, pad=3)
    return sheet, list(zip(cases, sheet.axes, strict=False))


@cache
def exact_rates(tangential: float, dimension: int) -> tuple[runs.Array, runs.Array]:
    """Restitutions from 0 to 1, with that from which on the printed a2 is real, and exact h."""
    e = np.sort([*np.linspace(0.0, 0.99, 67), 0.999, sonine.THRESHOLD_RESTITUTION + 1e-12])
    states = (ScalingSolution(float(x), tangential, dimension) for x in e)
    return e, np.array([state.cooling_rate for state in states])


def gaussian_vdf(c: ArrayLike, dimension: int) -> runs.Array:
    """The Gaussian F(c) with <c^2> = 1: a density in the plane, or in space."""
    d = dimension
    return np.asarray((d / 2 / math.pi) ** (d / 2) * np.exp(-d / 2 * np.square(c)))


def limiting_drift(restitution: Any, dimension: int) -> Any:
    """The drift in sqrt(g l) as collisions become elastic.

    With eps = 1 - e^2 speeds are distributed as exp(-a v^4), which grows as eps, and
    u = lambda(2) <v^3>/2.
    """
    d, (fall, loss) = dimension, ((2 / 9, 2 / 3) if dimension == 2 else (3 / 16, 1 / 2))
    third = fall**-0.75 * math.gamma((3 + d) / 4) / math.gamma(d / 4)
    return loss * third / 2 * (1.0 - np.square(restitution)) ** 0.25


def cooling_rate(results: runs.Results) -> Made:
    """h over e, and over the exact rate of late times."""
    system: Any = results.system
    sheet, smooth, said = _Sheet(system, (2.4, 1.15)), system.is_smooth, ""
    e, exact = exact_rates(system.tangential_restitution, system.dimension)
    for ax, scale in zip(sheet.axes, (1 - e if smooth else e**0, exact), strict=True):
        sheet.line(ax, "exact", e, exact / scale)
        if system.is_papers_law:
            sheet.line(ax, runs.FIT, e, sonine.cooling_rate_fitted(e) / scale)
            sheet.line(ax, runs.SONINE, e, sonine.cooling_rate(e) / scale)
            said = " Exactly it is √2 at e = 0 and 4/3 as e → 1; Sonine exists above e = 0.58."
    for case in results.cooling:
        x, limit = case.restitution, case.theory[runs.EXACT]["cooling_rate"]
        for ax, scale in zip(sheet.axes, (1 - x if smooth else 1.0, limit), strict=True):
            sheet.marks(ax, "solver", x, case.theory[runs.SOLVER]["cooling_rate"] / scale, "x")
            same = case.theory[runs.KINETIC]["cooling_rate"] / scale
            sheet.marks(ax, "equation, same times", x, same, "_")
            for source, found in case.measured.items():
                sheet.points(ax, source, x, found["cooling_rate"] / scale, x, named=False)
    over, y = ("h/(1 − e)", "$h(e)/(1-e)$") if smooth else ("h", "$h(e)$")
    return sheet.done(_RESTITUTION, y, "over exact"), {"over": over, "said": said}


def _over_time(results: runs.Results, name: str, against: str, source: str, scale: str) -> _Sheet:
    """An average over time; below, what a source measured over the theory."""
    sheet = _Sheet(results.system, (2.4, 1.15))
    top, below = sheet.axes
    top.set(xscale="log", yscale=scale)
    for case in results.cases:
        e, t, theory = case.restitution, case.times, case.theory[against][name]
        sheet.line(top, against, t, theory, e)
        for who, found in case.measured.items():
            sheet.points(top, who, t, found[name], e)
        sheet.points(below, source, t, case.measured[source][name] / theory, e, largest=0.1)
    below.axhline(1, color=INK, linewidth=0.8)
    return sheet


def msd(results: runs.Results) -> Made:
    """<r^2> over time, and over the dilute equation."""
    system: Any = results.system
    sheet = _over_time(results, "msd", runs.KINETIC, f"hard {system.scatterers}", "linear")
    said, (top, below) = "", sheet.axes
    for case in results.cases:
        e, t, dense, theory = case.restitution, case.times, case.solved.dense, case.theory
        if dense is not None:
            over = dense.msd / theory[runs.KINETIC]["msd"]
            sheet.line(below, "corrected equation", t, over, e)
            said = "Lines there: the equation of hard disks at this density, with nothing fitted"
            said += " here."
        if system.is_papers_law:
            sheet.line(top, runs.FIT, t, theory[runs.FIT]["msd"], e)
    return sheet.done(_TIME, r"$\langle r^2\rangle$  [d²]", "over dilute"), {"said": said}


def vdf(results: runs.Results) -> Made:
    """F(c) at the last time."""
    sheet, panels = _panels(results, results.cooling)
    hard, near, reason = f"hard {results.system.scatterers}", [], ""
    c, at = np.linspace(0.01, 2.5, 120), runs.SPEEDS
    for case, ax in panels:
        e, inside = case.restitution, at < c[-1]
        sheet.line(ax, runs.KINETIC, c, runs.last_vdf(case.solved.kinetic)(c), e, named=False)
        for source, found in case.measured.items():
            sheet.points(ax, source, at[inside], found["scaled_vdf"][inside], e, False, 0.15)
        sheet.line(ax, "Gaussian", c, gaussian_vdf(c, case.dimension))
        first, equation = case.measured[hard]["scaled_vdf"], case.theory[runs.KINETIC]["scaled_vdf"]
        near.append((float(first.value[0]), float(first.error[0]), float(equation[0]), e))
    most, error, expected, e = max(near)
    if most > 3 * expected:
        reason = (
            f" Near c = 0 {hard} have more (e = {e:g}: {most:.2f} ± {error:.2f}, equation "
            f"{expected:.2g}): tracers that bounce to and fro between two near scatterers, or in a "
            "corner of them, come to rest. The dilute equation has no such pairs."
        )
    return sheet.done("scaled speed $c = v/v_0$", "$F(c)$"), {"reason": reason}


def position(results: runs.Results) -> Made:
    """G(R) at the last time."""
    sheet, panels = _panels(results, results.cases)
    r, at = np.linspace(0.04, 6.0, 120), runs.DISTANCES
    for case, ax in panels:
        e, d = case.restitution, case.dimension
        ax.set(yscale="log", ylim=(1e-5, 3.0))
        g = case.solved.position.scaled_position_density(r)[-1]
        sheet.line(ax, runs.KINETIC, r, np.where(g > 0, g, np.nan), e, named=False)
        for source, found in case.measured.items():
            sheet.points(ax, source, at, found["position"], e, named=False)
        if results.system.is_papers_law:
            sheet.line(ax, "paper, peak", r, sonine.position_peak(r))
            sheet.line(ax, "paper, tail", r[r > 1], sonine.position_tail(r[r > 1]))
            sheet.line(ax, "paper's integral", r, sonine.position_integral(r))
        else:  # as of c: a density in the plane or in space
            surface = d * runs.ball(d) * r ** (d - 1)
            sheet.line(ax, "Gaussian", r, surface * gaussian_vdf(r, d))
    return sheet.done("scaled distance $R$", "$G(R)$"), {}


def kurtosis(results: runs.Results) -> Made:
    """<r^4>/<r^2>^2 over time."""
    sheet = _Sheet(results.system)
    (ax,) = sheet.axes
    ax.set_xscale("log")
    for case in results.cases:
        late = case.solved.late
        sheet.line(ax, runs.KINETIC, late.times, late.kurtosis, case.restitution)
        for source, found in case.measured.items():
            sheet.points(ax, source, case.times, found["kurtosis"], case.restitution)
    ends = [results.cases[0].times[0], runs.LATEST]
    sheet.line(ax, "Gaussian", ends, 1 + 2 / results.cases[0].dimension)
    if results.system.is_papers_law:
        sheet.line(ax, "paper's integral", ends, PAPER_KURTOSIS)
    return sheet.done(_TIME, r"$\langle r^4\rangle/\langle r^2\rangle^2$"), {}


# -- driven tracers, and a restitution of the impact speed -----------------------------------------
def _over_e(results: runs.Results, *names: str) -> _Sheet:
    """Steady averages over e, and particles over the solver."""
    sheet = _Sheet(results.system, (2.4, 1.15))
    top, below = sheet.axes
    e = np.array([case.restitution for case in results.cases])
    for k, name in enumerate(names):
        found = [case.measured[runs.FREE][name] for case in results.cases]
        value, error = (np.array([getattr(x, n) for x in found]) for n in ("value", "error"))
        measured, group = runs.Measured(value, error), (OBSERVABLES[name][1], k)
        solved = np.array([case.theory[runs.SOLVER][name] for case in results.cases])
        sheet.line(top, runs.SOLVER, e, solved, group)
        sheet.points(top, runs.FREE, e, measured, group)
        sheet.points(below, runs.FREE, e + 0.004 * k, measured / solved, group)
    below.axhline(1, color=INK, linewidth=0.8)
    top.set(ylim=(0, None), xlim=(-0.02, 1.0))
    return sheet


def drift(results: runs.Results) -> Made:
    """Drift over e."""
    sheet, d = _over_e(results, "drift"), results.cases[0].dimension
    sheet.line(sheet.axes[0], "limiting law", _FINE, limiting_drift(_FINE, d))
    return sheet.done(_RESTITUTION, "drift $u$  [√(gl)]", "over the solver"), {}


def dispersion(results: runs.Results) -> Made:
    """Both coefficients over e."""
    sheet = _over_e(results, "diffusion_parallel", "diffusion_perpendicular")
    return sheet.done(_RESTITUTION, "$D$  [√(gl³)]", "over the solver"), {}


def _driven(name: str, y: str, scale: str = "log", time: str = "[l/U]") -> Callable[..., Made]:
    """The figure of an average over time, and of particles over the solver."""

    def made(results: runs.Results) -> Made:
        sheet = _over_time(results, name, runs.SOLVER, runs.FREE, scale)
        return sheet.done(f"time $t$  {time}", y, "over the solver"), {}

    return made
