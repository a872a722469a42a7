"""The figures of a report: one function each, in plain matplotlib, with its title and its caption.

The same restitution has the same colour and marker in every figure; a stroke is who says so. An SVG
in a page takes its colours from the page's CSS variables, so that one picture serves light and dark.
"""

import io
import math
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from html import escape
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kinetics import ScalingSolution, sonine
from kinetics.collision.medium import SETTLED
from kinetics.crosscheck.report.reduce import (
    POSITION_EDGES,
    SPEED_EDGES,
    Array,
    Measured,
    band_middles,
    contact_value,
    gaussian_vdf,
    last_vdf,
    middles,
)
from kinetics.crosscheck.report.rows import PAPER_KURTOSIS, sure_density
from kinetics.crosscheck.report.runs import (
    APPROACH_TIMES,
    EXACT,
    EXTRAPOLATED,
    FIT,
    FREE,
    KINETIC,
    LATEST,
    SOLVER,
    SONINE,
    TRAP_RESTITUTIONS,
    Case,
    Results,
    near_elastic,
)
from kinetics.crosscheck.report.systems import SCATTERERS

INK, FAINT = "#16191d", "#dde1e6"
COLOURS = ("#0072b2", "#c04f00", "#007a58", "#b3478f", "#876600", "#3c4bb0")
"""Of the restitutions of a report, in their order (after Okabe and Ito, dark enough for text)."""
GROUPS = ("#8a1538", "#00707a", "#6b4a2b", "#5a6572")
"""Of what is no restitution: disks and spheres, observables, densities."""
VARIABLES = {
    INK: "var(--ink)", FAINT: "var(--faint)",
    **{colour: f"var(--series-{i})" for i, colour in enumerate(COLOURS)},
    **{colour: f"var(--group-{i})" for i, colour in enumerate(GROUPS)},
}  # fmt: skip
MARKERS = "os^DvP"
STYLE: dict[Any, Any] = {
    "svg.fonttype": "none", "svg.hashsalt": "inelastic-lorentz", "font.family": "sans-serif",
    "font.size": 10.5, "mathtext.default": "it", "axes.grid": True, "grid.color": FAINT,
    "grid.linewidth": 0.5, "legend.fontsize": 9.5, "lines.linewidth": 1.5,
    **dict.fromkeys(("axes.edgecolor", "axes.labelcolor", "text.color"), INK),
    **dict.fromkeys(("xtick.color", "ytick.color"), INK),
    **dict.fromkeys(("axes.spines.top", "axes.spines.right", "legend.frameon"), False),
    **dict.fromkeys(("figure.facecolor", "axes.facecolor", "savefig.facecolor"), "none"),
}  # fmt: skip
"""The style sheet of every figure."""
_DASHES = {"dashed": (0, (4, 2)), "dotted": (0, (1, 1.5)), "dash-dotted": (0, (6, 1.5, 1, 1.5))}
_STROKES = {
    **dict.fromkeys((SONINE, "paper, tail", "first order"), "dashed"),
    **dict.fromkeys(("Sonine, 2nd root", "paper's integral", "limiting law"), "dotted"),
    **dict.fromkeys(("exact tail", "exact limit", "exponential", "leading order"), "dotted"),
    **dict.fromkeys((FIT, "paper, peak", "Gaussian", "path alone"), "dash-dotted"),
}
_OPEN = ("hard disks", "hard spheres")
_WIDTH, _LEFT, _RIGHT, _BELOW, _GAP = 5.0, 0.78, 0.12, 0.52, 0.2  # inches, as are all lengths
_LEGEND_LINE, _LEGEND_COLUMNS = 0.2, 3
TIME, RESTITUTION = "time $t$  [d/U]", "restitution $e$"


@dataclass(frozen=True)
class Drawn:
    """A figure with its words."""

    name: str
    title: str
    caption: str
    figure: Any

    def file(self, kind: str) -> bytes:
        """As a file of its own, in the page's light colours: kind "svg", "pdf" or "png"."""
        import matplotlib as mpl

        buffer = io.BytesIO()
        dates = {"svg": {"Date": None}, "pdf": {"CreationDate": None}, "png": {"Software": None}}
        with mpl.rc_context(STYLE):
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
        return (
            f'{head} role="img" aria-labelledby="{prefix}title {prefix}desc">'
            f'<title id="{prefix}title">{escape(self.title)}</title>'
            f'<desc id="{prefix}desc">{escape(self.caption)}</desc>{body.strip()}'
        )


class _Sheet:
    """Axes in a grid, or one above a lower one for ratios, and a legend of all that is drawn."""

    def __init__(
        self, order: Sequence[float], shape: tuple[int, int] = (1, 1), tall: float = 2.9,
        ratio: bool = False, share: bool = True,
    ) -> None:  # fmt: skip
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        self.figure, self.order = Figure(figsize=(_WIDTH, 4)), list(order)
        FigureCanvasAgg(self.figure)  # knows the other formats as well
        rows, columns = shape
        gap = _GAP if share else _LEFT - 0.1
        width = (_WIDTH - _LEFT - _RIGHT - (columns - 1) * gap) / columns
        above = 0.24 if rows * columns > 1 else 0.0  # a title over each panel
        self._places, self.axes, bottom = [], [], _BELOW
        if ratio:
            self._places.append((_LEFT, bottom, width, 1.15))
            bottom, tall = bottom + 1.15 + _GAP, tall - 0.5
        step = tall + above + (_GAP if share else _BELOW)
        for row in range(rows):
            self._places += [
                (_LEFT + column * (width + gap), bottom + (rows - 1 - row) * step, width, tall)
                for column in range(columns)
            ]
        self._height = bottom + (rows - 1) * step + tall + above
        every = [self.figure.add_axes((0, 0, 1, 1)) for _ in self._places]
        self.below, self.axes = (every[0], every[1:]) if ratio else (None, every)
        self._share, self._columns = share and not ratio, columns
        self._legend: dict[str, dict[str, Any]] = {}

    def style(self, key: Any) -> tuple[str, str]:
        """Colour and marker of a restitution, of a group (text that ends in its number), or ink."""
        if isinstance(key, tuple):
            return GROUPS[key[1] % len(GROUPS)], MARKERS[key[1] % len(MARKERS)]
        if key is None:
            return INK, "o"
        k = self.order.index(key)
        return COLOURS[k % len(COLOURS)], MARKERS[k % len(MARKERS)]

    def _enter(self, source: str, stroke: dict[str, Any], key: Any, named: bool) -> None:
        if source:
            self._legend.setdefault(source, {"color": INK, **stroke})
        if key is not None and named:
            colour, marker = self.style(key)
            label = key[0] if isinstance(key, tuple) else f"e = {key:g}"
            self._legend.setdefault(label, {"color": colour, "marker": marker, "linestyle": "-"})

    def line(
        self, ax: Any, source: str, x: ArrayLike, y: ArrayLike, key: Any = None, named: bool = True
    ) -> None:
        """A line; None of a legend for source "", no restitution in it unless `named`."""
        stroke = {"linestyle": _DASHES.get(_STROKES.get(source, ""), "-")}
        x, y = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
        ax.plot(x, y, color=self.style(key)[0], **stroke, linewidth=1.5 if source else 0.8)
        self._enter(source, stroke, key, named)

    def points(
        self, ax: Any, source: str, x: ArrayLike, measured: Measured, key: Any = None,
        named: bool = True, largest: float = math.inf,
    ) -> None:  # fmt: skip
        """Points with bars of one standard error; without those of a larger error."""
        x, value, error = np.broadcast_arrays(x, measured.value, measured.error)
        seen = np.isfinite(value) & (error > 0) & (error < largest)
        if ax.get_yscale() == "log":
            seen &= (value > 0) & (error < 0.5 * value)
        colour, marker = self.style(key)
        fill = {"markerfacecolor": "none"} if source in _OPEN else {}
        stroke = {"markersize": 4.6 if fill else 3.8, **fill}
        ax.errorbar(
            x[seen], value[seen], error[seen], color=colour, marker=marker, linestyle="none",
            elinewidth=1.0, **stroke,
        )  # fmt: skip
        self._enter(source, {"marker": "o", "linestyle": "none", **stroke}, key, named)

    def marks(self, ax: Any, source: str, x: ArrayLike, y: ArrayLike, marker: str) -> None:
        """Marks without errors, in ink."""
        stroke = {"marker": marker, "linestyle": "none", "markersize": 6.0}
        ax.plot(x, y, color=INK, **stroke)
        self._enter(source, stroke, None, False)

    def done(self, name: str, title: str, caption: str, x: str, y: str, ratio: str = "") -> Drawn:
        """Labels, ticks and the legend; the figure."""
        from matplotlib.lines import Line2D
        from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter, NullLocator

        lines = math.ceil(len(self._legend) / _LEGEND_COLUMNS)
        high = self._height + 0.12 + _LEGEND_LINE * lines
        self.figure.set_size_inches(_WIDTH, high)
        every = [*([self.below] if self.below else []), *self.axes]
        for ax, (left, bottom, width, tall) in zip(every, self._places, strict=True):
            ax.set_position((left / _WIDTH, bottom / high, width / _WIDTH, tall / high))
            ax.set_axisbelow(True)
        if self._share:
            for side in ("x", "y"):
                limits = np.array([getattr(ax, f"get_{side}lim")() for ax in self.axes])
                for ax in self.axes:
                    ax.set(**{f"{side}lim": (limits[:, 0].min(), limits[:, 1].max())})
        for k, ax in enumerate(self.axes):
            last = k >= len(self.axes) - self._columns
            ax.set_xlabel(x if last and not self.below else ax.get_xlabel())
            ax.set_ylabel(y if k % self._columns == 0 or not self._share else ax.get_ylabel())
            if self.below or (self._share and not last):
                ax.tick_params(labelbottom=False)
            if self._share and k % self._columns:
                ax.tick_params(labelleft=False)
        if self.below:
            self.below.set(xlabel=x, ylabel=ratio, xlim=self.axes[0].get_xlim())
            self.below.set_xscale(self.axes[0].get_xscale())
            self.below.set_xlim(self.axes[0].get_xlim())
        for ax in every:
            small = ax is self.below or len(self.axes) > 1
            for side in (ax.xaxis, ax.yaxis):
                if side.get_scale() == "log":
                    side.set_major_locator(LogLocator(numticks=5 if small else 7))
                    side.set_minor_locator(NullLocator())
                    side.set_minor_formatter(NullFormatter())
                    side.set_major_formatter(_power_of_ten)
                else:
                    prune = "both" if small and self.below is None else None
                    steps, most = [1, 2, 2.5, 5, 10], 4 if small else 6
                    side.set_major_locator(MaxNLocator(most, prune=prune, steps=steps))
        if self._legend:
            self.figure.legend(
                handles=[Line2D([], [], **stroke) for stroke in self._legend.values()],
                labels=list(self._legend), loc="upper left", ncols=_LEGEND_COLUMNS,
                handlelength=2.2, columnspacing=1.2, borderaxespad=0.2,
            )  # fmt: skip
        return Drawn(name, title, caption, self.figure)


def _power_of_ten(value: float, position: int | None = None) -> str:
    """The label of a logarithmic axis, without the typesetting that matplotlib would do for it."""
    exponent = math.log10(value)
    if abs(exponent - round(exponent)) > 1e-6:
        return f"{value:g}"
    return "10" + str(round(exponent)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def figures(results: Results) -> list[Drawn]:
    """Every figure that the results allow; the first three are those of the head of the page."""
    import matplotlib as mpl

    with mpl.rc_context(STYLE):
        if results.system.in_field:
            chosen = [drift, *([dispersion]), *([from_rest] if results.more["approach"] else [])]
            chosen += [drift_over_density, trapped, captures] if results.more["dense"] else []
        else:
            chosen = [cooling_rate, msd, vdf] if results.cooling else [msd]
            chosen += [inverse_speed, vdf_tail, a2, approach, msd_slope] if results.cooling else []
            chosen += [position, tail_exponent, kurtosis]
            chosen += [density, traps] if results.system.is_papers_law else []
        made = [make(results) for make in chosen]
        return made + [picture(results)] if 2 in _dimensions(results) else made


def _dimensions(results: Results) -> Sequence[int]:
    system: Any = results.system
    return system.dimensions if system.in_field else (system.dimension,)


def _panels(results: Results, cases: Sequence[Case], tall: float = 1.75) -> tuple[_Sheet, list]:
    """A sheet with a panel for each restitution."""
    across = min(2, len(cases))
    shape = (math.ceil(len(cases) / across), across)
    sheet = _Sheet(results.system.restitutions, shape, tall)
    for spare in sheet.axes[len(cases) :]:
        spare.set_axis_off()
    for case, ax in zip(cases, sheet.axes, strict=False):
        colour = sheet.style(case.restitution)[0]
        ax.set_title(f"e = {case.restitution:g}", loc="left", color=colour, fontsize=10.5, pad=3)
    return sheet, list(zip(cases, sheet.axes, strict=False))


def _runs(case: Case) -> Iterable[tuple[str, dict[str, Measured]]]:
    return case.measured.items()


# -- a gas that cools: the head of the page --------------------------------------------------------


@cache
def exact_states(tangential: float, dimension: int) -> tuple[Array, tuple[ScalingSolution, ...]]:
    """Restitutions from 0 to 1, with the one from which on the printed a2 is real; exact states."""
    threshold = sonine.THRESHOLD_RESTITUTION + 1e-12
    e = np.sort([*np.linspace(0.0, 0.99, 67), 0.999, threshold])
    return e, tuple(ScalingSolution(float(x), tangential, dimension) for x in e)


def _over_restitution(
    results: Results, sheet: _Sheet, name: str, scale: Callable[[Any], Any]
) -> tuple[Array, Array]:
    """h or a2 over e: exact, solver, the equation at the particles' times, and particles."""
    system: Any = results.system
    e, states = exact_states(system.tangential_restitution, system.dimension)
    exact = np.array([getattr(state, name) for state in states])
    for ax in [sheet.axes[0], *([sheet.below] if sheet.below else [])]:
        unit = 1.0 if ax is sheet.axes[0] else exact / scale(e)
        sheet.line(ax, "exact", e, exact / scale(e) / unit)
        for case in results.cooling:
            x = case.restitution
            one = 1.0 if ax is sheet.axes[0] else case.theory[EXACT][name] / scale(x)
            sheet.marks(ax, "solver", x, case.theory[SOLVER][name] / scale(x) / one, "x")
            last = float(np.ravel(case.theory[KINETIC][name])[-1])
            sheet.marks(ax, "equation, same times", x, last / scale(x) / one, "_")
            for source, found in _runs(case):
                value = Measured(*(np.ravel(v)[-1:] for v in vars(found[name]).values()))
                sheet.points(ax, source, x, value / (scale(x) * one), x, named=False)
    return e, exact


def cooling_rate(results: Results) -> Drawn:
    """h(e)/(1-e): every method and both printed formulas; of rough scatterers h itself."""
    system: Any = results.system
    sheet = _Sheet(system.restitutions, ratio=True)
    smooth = system.is_smooth

    def scale(e: Any) -> Any:
        return 1 - e if smooth else 1.0 + 0 * e

    e, exact = _over_restitution(results, sheet, "cooling_rate", scale)
    said = ""
    if system.is_papers_law:
        for source, of in ((FIT, sonine.cooling_rate_fitted), (SONINE, sonine.cooling_rate)):
            sheet.line(sheet.axes[0], source, e, of(e) / scale(e))
            sheet.line(sheet.below, source, e, of(e) / exact)
        said = " Exactly it is √2 at e = 0 and 4/3 as e → 1; Sonine exists above e = 0.58."
    caption = (
        f"{'h/(1 − e)' if smooth else 'h'} over e; below, all over the exact rate of late times."
        f"{said} Particles: the slope of 1/v₀ over their last decade of time, read with the l of "
        "the dilute limit. Bars: one standard error."
    )
    y = "$h(e)/(1-e)$" if smooth else "$h(e)$"
    title = "Cooling rate" + (" over inelasticity" if smooth else "")
    return sheet.done("cooling-rate", title, caption, RESTITUTION, y, "over exact")


def msd(results: Results) -> Drawn:
    """<r^2> of everybody, and over the dilute equation with the equation of hard disks."""
    system: Any = results.system
    sheet = _Sheet(system.restitutions, ratio=True)
    top, below = sheet.axes[0], sheet.below
    corrected = ""
    for case in results.cases:
        e, t, kinetic = case.restitution, case.times, case.theory[KINETIC]["msd"]
        sheet.line(top, KINETIC, t, kinetic, e)
        for source, found in _runs(case):
            sheet.points(top, source, t, found["msd"], e)
        hard = case.measured[f"hard {system.scatterers}"]["msd"]
        sheet.points(below, f"hard {system.scatterers}", t, hard / kinetic, e, largest=0.1)
        if case.solved.dense is not None:
            sheet.line(below, "corrected equation", t, case.solved.dense.msd / kinetic, e)
            corrected = (
                " Lines below: the equation of hard disks at this density, to which nothing here "
                f"is fitted, trusted from {SETTLED / (2 * system.half_rate):.2g} d/U on."
            )
        if system.is_papers_law:
            sheet.line(top, FIT, t, case.theory[FIT]["msd"], e)
    for ax in (top, below):
        ax.set_xscale("log")
    below.axhline(1, color=INK, linewidth=0.8)
    caption = (
        "⟨r²⟩ over time; below, hard scatterers over the dilute equation, which forgets every "
        f"scatterer.{corrected} Bars: one standard error."
    )
    y, ratio = r"$\langle r^2\rangle$  [d²]", "over dilute"
    return sheet.done("msd", "Mean square displacement", caption, TIME, y, ratio)


def _vdf_lines(results: Results, sheet: _Sheet, panels: list, c: Array) -> None:
    for case, ax in panels:
        e, at = case.restitution, middles(SPEED_EDGES)
        inside = at < c[-1]
        sheet.line(ax, KINETIC, c, last_vdf(case.solved.kinetic)(c), e, named=False)
        for source, found in _runs(case):
            sheet.points(ax, source, at[inside], found["scaled_vdf"][inside], e, False, 0.15)
        sheet.line(ax, "Gaussian", c, gaussian_vdf(c, case.dimension))


def vdf(results: Results) -> Drawn:
    """F(c) at the last time (the paper's Fig. 6), and the Gaussian that the paper fits."""
    sheet, panels = _panels(results, results.cooling)
    _vdf_lines(results, sheet, panels, np.linspace(0.01, 2.5, 120))
    hard = f"hard {results.system.scatterers}"
    near = [(case.measured[hard]["scaled_vdf"][0], case) for case in results.cooling]
    most, case = max(near, key=lambda found: float(found[0].value))
    equation = float(case.theory[KINETIC]["scaled_vdf"][0])
    reason = ""
    if float(most.value) > 3 * equation:
        reason = (
            f" Near c = 0 {hard} have more (e = {case.restitution:g}: {float(most.value):.2f} ± "
            f"{float(most.error):.2f}, equation {equation:.2g}): tracers that bounce to and fro "
            "between two near scatterers, or in a corner of them, come to rest. The dilute "
            "equation has no such pairs."
        )
    caption = (
        "F(c), c = v/v₀, at the last time: not the Gaussian that the paper reads; for e > 0 it "
        f"vanishes at c = 0.{reason} Bars: one standard error."
    )
    title = "Scaled velocity distribution"
    return sheet.done("vdf", title, caption, "scaled speed $c = v/v_0$", "$F(c)$")


# -- a gas that cools: velocities ------------------------------------------------------------------


def inverse_speed(results: Results) -> Drawn:
    """The paper's J (Fig. 2) over its abscissa d rho0 t, which shows what logarithms hide."""
    system: Any = results.system
    sheet, panels = _panels(results, results.cooling)
    for case, ax in panels:
        e, t = case.restitution, case.times
        scale = (1 - e if system.is_smooth else 1.0) * system.half_rate * t
        ax.set_xscale("log")

        def slowing(speed: Array, scale: Array = scale, case: Case = case) -> Array:
            return (1 / speed - 1 / math.sqrt(case.dimension)) / scale

        sheet.line(ax, KINETIC, t, slowing(case.theory[KINETIC]["thermal_speed"]), e, False)
        limit = case.theory[EXACT]["cooling_rate"] * system.half_rate * t / scale
        sheet.line(ax, "exact limit", t, limit, e, named=False)
        for source, found in _runs(case):
            v = found["thermal_speed"]
            points = Measured(slowing(v.value), v.error / v.value**2 / scale)
            sheet.points(ax, source, t, points, e, named=False, largest=0.2)
        if system.is_papers_law:
            sheet.line(ax, FIT, t, sonine.FITTED_COOLING_FACTOR + 0 * t)
    over = "/(1 − e)" if system.is_smooth else ""
    caption = (
        f"2l (1/v₀(t) − 1/v₀(0))/t{over} with the l of the dilute limit, the paper's J of its "
        "Figure 2 over the abscissa; the paper reads a constant. Points with an error above 0.2 "
        "are left out."
    )
    y = r"$J/(d\rho_0 t)$"
    return sheet.done("inverse-speed", "Inverse thermal speed", caption, TIME, y)


def vdf_tail(results: Results) -> Drawn:
    """F(c) on a logarithmic scale with its exact tail."""
    sheet, panels = _panels(results, results.cooling)
    c = np.linspace(0.05, 6.0, 120)
    for _, ax in panels:
        ax.set_yscale("log")
        ax.set_ylim(1e-6, 3.0)
    _vdf_lines(results, sheet, panels, c)
    for case, ax in panels:
        exact, far = case.solved.exact, c[c > 3]
        if np.isfinite(exact.tail_power):  # else no power times an exponential
            tail = np.exp(exact.log_tail_amplitude - exact.tail_rate * far) * far**exact.tail_power
            sheet.line(ax, "exact tail", far, tail, case.restitution, named=False)
    caption = (
        "F(c) on a logarithmic scale at the last time. The exact tail of late times is a power of "
        "c times exp(−2c/h), amplitude included; it is reached late for e near 1."
    )
    x, title = "scaled speed $c = v/v_0$", "Tail of the velocity distribution"
    return sheet.done("vdf-tail", title, caption, x, "$F(c)$")


def a2(results: Results) -> Drawn:
    """Second Sonine coefficient: exact, solver, both printed roots, particles at the end."""
    sheet = _Sheet(results.system.restitutions)
    ax = sheet.axes[0]
    e, _ = _over_restitution(results, sheet, "a2", lambda e: 1.0 + 0 * e)
    if results.system.is_papers_law:
        sheet.line(ax, SONINE, e, sonine.a2(e))
        sheet.line(ax, "Sonine, 2nd root", e, sonine.a2(e, "unstable"))
    ax.axhline(0, color=INK, linewidth=0.8)
    fourth = "3⟨c⁴⟩/5" if _dimensions(results)[0] == 3 else "⟨c⁴⟩/2"
    caption = (
        f"a₂ = {fourth} − 1 over e; a Gaussian has 0. The printed roots exist above e = 0.58. "
        "Particles: at the last time, when the Gaussian start is not quite forgotten."
    )
    return sheet.done("a2", "Second Sonine coefficient", caption, RESTITUTION, "$a_2$")


def approach(results: Results) -> Drawn:
    """a2(t) on its way from the Gaussian's 0 to the scaling state's."""
    sheet = _Sheet(results.system.restitutions)
    ax = sheet.axes[0]
    ax.set_xscale("log")
    for case in results.cooling:
        e, late = case.restitution, case.solved.late
        shown = late.times <= 1e5
        sheet.line(ax, KINETIC, late.times[shown], late.a2[shown], e)
        sheet.line(ax, "exact limit", [case.times[0], 1e5], case.theory[EXACT]["a2"], e)
        for source, found in _runs(case):
            sheet.points(ax, source, case.times, found["a2"], e)
    caption = "a₂(t) from a Gaussian start, where it is 0. Bars: one standard error."
    return sheet.done("approach", "Approach to the scaling state", caption, TIME, "$a_2(t)$")


# -- a gas that cools: displacements ---------------------------------------------------------------


def position(results: Results) -> Drawn:
    """G(R) at the last time (Fig. 5), with the paper's forms, or a Gaussian."""
    sheet, panels = _panels(results, results.cases)
    r = np.linspace(0.04, 6.0, 120)
    for case, ax in panels:
        e = case.restitution
        ax.set_yscale("log")
        ax.set_ylim(1e-5, 3.0)
        g = case.solved.position.scaled_position_density(r)[-1]
        sheet.line(ax, KINETIC, r, np.where(g > 0, g, np.nan), e, named=False)
        for source, found in _runs(case):
            sheet.points(ax, source, middles(POSITION_EDGES), found["position"], e, named=False)
        if results.system.is_papers_law:
            sheet.line(ax, "paper, peak", r, sonine.position_peak(r))
            sheet.line(ax, "paper, tail", r[r > 1], sonine.position_tail(r[r > 1]))
            sheet.line(ax, "paper's integral", r, sonine.position_integral(r))
        else:
            sheet.line(ax, "Gaussian", r, _gaussian_position(r, case.dimension))
    caption = "G(R), R = r/√⟨r²⟩, a density over R, at the last time."
    if results.system.is_papers_law:
        caption += " The paper's peak (η = 0.75) and tail (η = 0.25, γ = 7.39) are fitted forms."
    title = "Scaled displacement distribution"
    return sheet.done("position", title, caption, "scaled distance $R$", "$G(R)$")


def _gaussian_position(r: Array, dimension: int) -> Array:
    """G(R) of a Gaussian displacement: a density over R with <R^2> = 1."""
    if dimension == 2:
        return np.asarray(2 * r * np.exp(-(r**2)))
    return np.asarray(4 * math.pi * r**2 * (1.5 / math.pi) ** 1.5 * np.exp(-1.5 * r**2))


def tail_exponent(results: Results) -> Drawn:
    """Local exponent n(R) of G(R)/R: 2 is a Gaussian, 1 an exponential."""
    sheet, panels = _panels(results, results.cases)
    for case, ax in panels:
        e, at = case.restitution, band_middles(case.dimension)
        ax.set(ylim=(0.5, 2.6), xlim=(0.0, 6.0))
        known, _ = sure_density(case, np.linspace(0.3, 6.0, 60))
        n = case.solved.position.position_tail(known)[0][-1]
        sheet.line(ax, KINETIC, known, n, e, named=False)
        sheet.marks(ax, "same bands", at, case.theory[KINETIC]["tail_exponent"], "x")
        for source, found in _runs(case):
            sheet.points(ax, source, at, found["tail_exponent"], e, named=False, largest=0.5)
        for value in (1.0, 2.0):
            ax.axhline(value, color=INK, linewidth=0.8)
    over = "4πR²" if _dimensions(results)[0] == 3 else "2πR"
    caption = (
        f"Local exponent n of p = G(R)/({over}) ~ exp(−(R/b)ⁿ) at the last time: 1 is an "
        "exponential, 2 a Gaussian. Crosses: the equation over the bands of the particles."
    )
    title = "How the tail of G(R) falls"
    return sheet.done("tail-exponent", title, caption, "scaled distance $R$", "$n(R)$")


def msd_slope(results: Results) -> Drawn:
    """d<r^2>/d ln t over ln t, in units of its exact limit, with the printed late slopes."""
    sheet = _Sheet(results.system.restitutions)
    ax = sheet.axes[0]
    ax.set_xscale("log")
    for case in results.cooling:
        e, late, limit = case.restitution, case.solved.late, case.theory[EXACT]["msd_slope"]
        sheet.line(ax, KINETIC, late.times, late.msd_slope / limit, e)
        middle = math.sqrt(case.times[case.solved.early] * case.times[-1])
        for source, found in _runs(case):
            sheet.points(ax, source, middle, found["msd_slope"] / limit, e)
        if results.system.is_papers_law:
            for source in (FIT, SONINE):
                value = case.theory[source]["msd_slope"] / limit
                sheet.line(ax, source, [1e4, LATEST], value, e)
    ax.axhline(1, color=INK, linewidth=0.8)
    caption = (
        "d⟨r²⟩/d ln t over its exact limit 2l²/(κ(1 − ⟨cos χ⟩)): where it is 1, ⟨r²⟩ grows as ln "
        "t. Particles: the mean slope over their last decade, at its middle."
    )
    y = r"$\mathrm{d}\langle r^2\rangle/\mathrm{d}\ln t$ over limit"
    title = "Slope of the mean square displacement"
    return sheet.done("msd-slope", title, caption, TIME, y)


def kurtosis(results: Results) -> Drawn:
    """<r^4>/<r^2>^2 over ln t: whether G(R) is the same at all times, and Gaussian in the end."""
    sheet = _Sheet(results.system.restitutions)
    ax = sheet.axes[0]
    ax.set_xscale("log")
    ends = np.array([results.cases[0].times[0], LATEST])
    for case in results.cases:
        e, late = case.restitution, case.solved.late
        sheet.line(ax, KINETIC, late.times, late.kurtosis, e)
        for source, found in _runs(case):
            sheet.points(ax, source, case.times, found["kurtosis"], e)
    sheet.line(ax, "Gaussian", ends, 1 + 2 / _dimensions(results)[0])
    if results.system.is_papers_law:
        sheet.line(ax, "paper's integral", ends, PAPER_KURTOSIS)
    caption = "⟨r⁴⟩/⟨r²⟩²: were G(R) the same at all times, it would be constant."
    y = r"$\langle r^4\rangle/\langle r^2\rangle^2$"
    return sheet.done("kurtosis", "Kurtosis of the displacement", caption, TIME, y)


# -- hard disks at other densities and restitutions ------------------------------------------------

_RATIOS = {"free_path": "free path", "thermal_speed": "$v_0$", "msd": r"$\langle r^2\rangle$"}


def density(results: Results) -> Drawn:
    """Hard disks over the dilute equation at several densities, their limit, and the theory."""
    scan = results.more["density"]
    sheet = _Sheet(results.system.restitutions)
    ax, x = sheet.axes[0], np.linspace(0.0, float(scan["densities"][-1]), 40)
    for k, (name, ratio) in enumerate(scan["ratios"].items()):
        group = (_RATIOS[name], k)
        sheet.points(ax, "hard disks", scan["densities"], ratio, group)
        if np.isfinite(scan["limits"][name].value):
            sheet.line(ax, "", x, np.polynomial.Polynomial(scan["fits"][name])(x), group)
            sheet.points(ax, "limit", 0.0, scan["limits"][name], group)
    for name, (at, ratio) in scan["levels"].items():
        sheet.line(ax, {"path of the medium": "path alone"}.get(name, name), at, ratio)
    caption = (
        f"Hard disks over the dilute equation at the same dρ₀t, e = {scan['restitution']:g}. Thin: "
        "fits whose values at 0 are 1 if the equation is the dilute limit. Ink: ⟨r²⟩ in the theory "
        "of a finite density, level by level."
    )
    y = "hard disks / dilute"
    return sheet.done("density", "Density of the disks", caption, r"density $\rho_0 d^2$", y)


def traps(results: Results) -> Drawn:
    """Share of tracers caught in corners over e."""
    scan = results.more["traps"]
    sheet = _Sheet(results.system.restitutions)
    ax = sheet.axes[0]
    ax.set_yscale("log")
    for k, (n, share) in enumerate(scan["shares"].items()):
        sheet.points(ax, "hard disks", TRAP_RESTITUTIONS, share, (f"ρ₀d² = {n:g}", k))
    caption = (
        "Share of hard-disk tracers that have come to rest in a corner between disks, by "
        f"{scan['time']:.4g} d/U (at the higher density sooner, as the free path). The dilute "
        "equation has no corners."
    )
    return sheet.done("traps", "Where traps begin", caption, RESTITUTION, "share caught")


def picture(results: Results) -> Drawn:
    """A few tracers among the disks, coloured by their speed."""
    from matplotlib.colors import LinearSegmentedColormap, to_hex
    from particles import HardDisks, simulate

    import matplotlib as mpl

    system: Any = results.system
    many: dict[str, Any] = {"media": 2, "seed": system.seed, "workers": 1}
    if system.in_field:
        e, density, until, tracers, which = 0.5, 0.06, 150.0, 4, {}
        run = simulate(
            HardDisks(density, 2000), e, times=[until], tracers=tracers, field=2 * density, **many
        )
        said = ", to the right the field, g l = U²"
    else:
        # near the middle: tracers stay near at e = 0, and fly far at 1
        e = min(system.restitutions, key=lambda each: abs(each - 0.7))
        until, tracers = system.final_times[system.restitutions.index(e)], 3
        run = simulate(
            HardDisks(system.number_density, min(system.count, 2000)), e, times=[until],
            tracers=tracers, observables=("finals",),
            tangential_restitution=system.tangential_restitution, **many,
        )  # fmt: skip
        said, which = " or 20 bounces", {"collisions": 20}
    from matplotlib.figure import Figure

    figure = Figure(figsize=(_WIDTH, 0.85 * _WIDTH), layout="constrained")
    ax = figure.add_subplot()
    run.plot_trajectories(tracers, ax=ax, **which)
    # the middle of the scale of colours: seen on white and on black
    middle = mpl.colormaps["plasma"](np.linspace(0.3, 0.85, 32))
    for drawn in ax.collections:
        if drawn.get_array() is not None:
            drawn.set_cmap(LinearSegmentedColormap.from_list("speeds", [*map(to_hex, middle)]))
    caption = (
        f"{tracers} tracers among hard disks at e = {e:g}, until {until:g} d/U{said}, coloured by "
        "their speed, from the open circle to the dots. Shaded: where no centre of a tracer can be."
    )
    return Drawn("picture", "The system", caption, figure)


# -- tracers in a field ----------------------------------------------------------------------------

_FINE = np.sqrt(1.0 - np.geomspace(1.0, 1e-6, 120))  # e, ever closer to 1


def _group(dimension: int) -> tuple[str, int]:
    return SCATTERERS[dimension], dimension - 2


def _steady(results: Results, dimension: int, name: str) -> tuple[Array, Measured, Array]:
    """Restitutions, what particles say, and what the solver says."""
    cases = [
        case for case in results.cases
        if case.dimension == dimension and name in case.measured.get(FREE, ())
    ]  # fmt: skip
    measured = Measured.joined(case.measured[FREE][name] for case in cases)
    e = np.array([case.restitution for case in cases])
    return e, measured, np.array([case.theory[SOLVER][name] for case in cases])


def drift(results: Results) -> Drawn:
    """The drift over the restitution with its limit, and particles over the equation below."""
    sheet = _Sheet((), ratio=True)
    for d, line in results.more["lines"].items():
        sheet.line(sheet.axes[0], SOLVER, line["restitution"], line["drift"], _group(d))
        sheet.line(sheet.axes[0], "limiting law", _FINE, near_elastic(_FINE, d)["drift"], _group(d))
        e, measured, solved = _steady(results, d, "drift")
        sheet.points(sheet.axes[0], FREE, e, measured, _group(d))
        beside = 0.004 * (2 * d - 5)  # so that disks and spheres are both seen
        sheet.points(sheet.below, FREE, e + beside, measured / solved, _group(d))
    sheet.below.axhline(1, color=INK, linewidth=0.8)
    sheet.axes[0].set(ylim=(0, None), xlim=(-0.02, 1.0))
    caption = (
        "The mean velocity u along the field in the steady state. Dotted: the law of nearly "
        "elastic collisions, u = constant · (1 − e²)^¼. Below, particles of the dilute limit over "
        "the solver. Bars: one standard error."
    )
    y, ratio = "drift $u$  [√(gl)]", "over the solver"
    return sheet.done("drift", "Drift over the restitution", caption, RESTITUTION, y, ratio)


def dispersion(results: Results) -> Drawn:
    """Both diffusion coefficients over the restitution, a panel for each dimension."""
    lines = results.more["lines"]
    sheet = _Sheet((), (1, len(lines)), 2.7)
    for ax, (d, line) in zip(sheet.axes, lines.items(), strict=True):
        laws = near_elastic(_FINE, d)
        for k, name in enumerate(("parallel", "perpendicular")):
            group = (("$D_∥$, along", "$D_⊥$, across")[k], k)
            sheet.line(ax, SOLVER, line["restitution"], line[f"diffusion_{name}"], group)
            sheet.line(ax, "limiting law", _FINE, laws[f"diffusion_{name}"], group)
            e, measured, _ = _steady(results, d, f"diffusion_{name}")
            sheet.points(ax, FREE, e, measured, group)
        ax.set(ylim=(0.0, 1.05), xlim=(-0.02, 1.0))
        ax.set_title(SCATTERERS[d], loc="left", fontsize=10.5, pad=3)
    caption = (
        "Half the growth rate of the variance of the displacement along the field and in one "
        "direction across it. Dotted: constant · (1 − e²)^−¼."
    )
    title = "Dispersion about the drift"
    return sheet.done("dispersion", title, caption, RESTITUTION, "$D$  [√(gl³)]")


def from_rest(results: Results) -> Drawn:
    """Mean velocity and mean square speed over time, from rest."""
    sheet, cases = _Sheet((), (1, 2), 2.7, share=False), results.more["approach"]
    labels = ("$⟨v_z⟩$  [√(gl)]", "$⟨v^2⟩$  [gl]")
    for ax, name, label in zip(
        sheet.axes, ("drift_from_rest", "square_from_rest"), labels, strict=True
    ):
        ax.set_xscale("log")
        for k, case in enumerate(cases):
            group = (f"{SCATTERERS[case.dimension]}, e = {case.restitution:g}", k)
            sheet.line(ax, SOLVER, APPROACH_TIMES, case.theory[SOLVER][name], group)
            points = case.measured[FREE][name]
            sheet.points(ax, FREE, APPROACH_TIMES[::2], points[::2], group)
        ax.set_title(label, loc="left", fontsize=10.5, pad=3)
    caption = (
        "Tracers start at rest and first fall freely; they exceed the drift before they collide. "
        "Bars: one standard error."
    )
    x = "time $t$  [√(l/g)]"
    return sheet.done("from-rest", "From rest to the steady state", caption, x, "in √(gl), gl")


def drift_over_density(results: Results) -> Drawn:
    """The drift of tracers while they move, over that of the dilute equation."""
    cases = results.more["dense"]
    sheet = _Sheet([case.restitution for case in cases])
    ax, n = sheet.axes[0], cases[0].places["captures"][1]
    fine = np.linspace(0.0, float(n[-1]), 40)
    sheet.line(ax, "path alone", fine, [contact_value(float(x)) ** -0.5 for x in fine])
    for case in cases:
        found = case.measured[EXTRAPOLATED]["drift_over_density"]
        sheet.points(ax, "particles", n, found, case.restitution)
    ax.axhline(1, color=INK, linewidth=0.8)
    caption = (
        "How fast tracers fall among hard disks while they are not trapped, over the drift of the "
        "equation. Dash-dotted: the shorter free path alone; the rest is disks met again."
    )
    x, y = r"density $\rho_0 d^2$", "$u$ / $u$ of the equation"
    return sheet.done("density-drift", "Hard disks: drift", caption, x, y)


def trapped(results: Results) -> Drawn:
    """The share of trapped tracers over time, at the middle one of the restitutions."""
    cases = results.more["dense"]
    case = cases[len(cases) // 2]
    sheet, share = _Sheet(()), case.measured[EXTRAPOLATED]["trapped"]
    sheet.axes[0].set_xscale("log")
    for k, n in enumerate(case.places["captures"][1]):
        sheet.points(sheet.axes[0], "particles", case.times, share[k], (f"ρ₀d² = {n:g}", k))
    caption = f"Tracers at rest in a corner of two disks, e = {case.restitution:g}, over time."
    x, title = "time $t$  [√(l/g)]", "Hard disks: trapped tracers"
    return sheet.done("density-trapped", title, caption, x, "share trapped")


def captures(results: Results) -> Drawn:
    """How often tracers are trapped, over the density, on logarithmic axes."""
    cases = results.more["dense"]
    sheet = _Sheet([case.restitution for case in cases])
    sheet.axes[0].set(xscale="log", yscale="log")
    for case in cases:
        found, n = case.measured[EXTRAPOLATED]["captures"], case.places["captures"][1]
        sheet.points(sheet.axes[0], "particles", n, found, case.restitution)
    caption = "Tracers trapped on a way of one mean free path, about one collision."
    x, y = r"density $\rho_0 d^2$", "captures per free path"
    return sheet.done("density-captures", "Hard disks: captures", caption, x, y)
