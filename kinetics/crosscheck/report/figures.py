"""The figures of a report: one function each, in plain matplotlib, with its title and its caption.

`draw_all` chooses the figures of a system; axes, colours and legends are those of `sheet.py`.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from kinetics import sonine
from kinetics.crosscheck.report import estimates
from kinetics.crosscheck.report.cases import (
    EXACT,
    FIT,
    FREE,
    KINETIC,
    SOLVER,
    SONINE,
    Case,
    CoolingCase,
    DrivenCase,
    FloatArray,
    Measured,
    Results,
)
from kinetics.crosscheck.report.cooling import LATEST_TIME, last_vdf
from kinetics.crosscheck.report.curves import exact_rates, gaussian_vdf, limiting_drift
from kinetics.crosscheck.report.rows import PAPER_KURTOSIS
from kinetics.crosscheck.report.sheet import (
    CORRECTED,
    GAUSSIAN,
    INK,
    INTEGRAL,
    LIMITING_LAW,
    PEAK,
    STYLE,
    TAIL,
    VARIABLES,
    Drawn,
    Group,
    Sheet,
)
from kinetics.crosscheck.report.systems import Cooling, Driven, System
from kinetics.crosscheck.report.words_of_report import report_words

TIME_LABEL = "time $t$  [d/U]"
RESTITUTION_LABEL = "restitution $e$"
RATIO_TO_SOLVER = "particles / solver"
#: Restitutions at which a curve is drawn that is steep at 1.
FINE_RESTITUTIONS = np.sqrt(1.0 - np.geomspace(1.0, 1e-6, 120))
#: Heights in inches of the rows of a figure of two.
TWO_ROWS = [2.4, 1.15]
#: Height in inches of a panel of one restitution.
PANEL_HEIGHT = 1.75
#: Panels side by side: more would be too narrow for their ticks.
MAX_PANELS_IN_A_ROW = 2
#: Largest error of points of a ratio that are shown: larger bars only hide others.
MAX_ERROR_OF_RATIO = 0.1
#: Largest error of points of F(c) that are shown.
MAX_ERROR_OF_VDF = 0.15
#: c at which F(c) is drawn.
SHOWN_SPEEDS = np.linspace(0.01, 2.5, 120)
#: R at which G(R) is drawn.
SHOWN_RADII = np.linspace(0.04, 6.0, 120)
#: Lowest G(R) that is shown. The origin of the number is not recorded.
LOWEST_POSITION_DENSITY = 1e-5
#: Highest G(R) that is shown. The origin of the number is not recorded.
HIGHEST_POSITION_DENSITY = 3.0
#: Radius from which on the paper's tail is drawn.
TAIL_FROM = 1.0
#: F near c = 0 over the equation's from which on the caption explains it.
EXPLAINED_FROM = 3
#: Shift in e of points of one observable beside those of the one before.
SHIFT = 0.004


@dataclass(frozen=True)
class Picture:
    """A figure, and the words that its caption leaves open."""

    figure: Figure
    words: Mapping[str, str] = field(default_factory=dict)


def draw_all(results: Results) -> list[Drawn]:
    """Return every figure that the results allow; the first three are those of the head.

    Titles and captions are in `templates/report.json`, with "{words}" to be filled.
    """
    drawn = []
    with mpl.rc_context(fname=STYLE):
        for name, draw in _choose(results).items():
            picture = draw()
            title, caption = report_words().figures[name]
            filled = caption.format(**picture.words).strip()
            drawn.append(Drawn(name.replace("_", "-"), title, filled, picture.figure))
    return drawn


def _choose(results: Results) -> dict[str, Callable[[], Picture]]:
    """Return the figures of a system, in their order: name -> function that draws it."""
    system = results.system
    if isinstance(system, Driven):
        return _choose_driven(system, results.driven)
    if not isinstance(system, Cooling):
        raise TypeError(f"no figures of a {type(system).__name__}")
    figures: dict[str, Callable[[], Picture]] = {}
    if results.inelastic:
        figures["cooling_rate"] = lambda: cooling_rate(system, results.inelastic)
    figures["msd"] = lambda: msd(system, results.cooling)
    if results.inelastic:
        figures["vdf"] = lambda: vdf(system, results.inelastic)
    figures["position"] = lambda: position(system, results.cooling)
    figures["kurtosis"] = lambda: kurtosis(system, results.cooling)
    return figures


def _choose_driven(system: Driven, cases: Sequence[DrivenCase]) -> dict[str, Callable[[], Picture]]:
    """Return the figures of driven tracers."""
    if "field" in system.drive:
        return {
            "drift": lambda: drift(system, cases),
            "dispersion": lambda: dispersion(system, cases),
            "from_rest": lambda: from_rest(system, cases),
        }
    return {
        "thermal_speed": lambda: thermal_speed(system, cases),
        "spread": lambda: spread(system, cases),
    }


# -- a gas that is left alone ----------------------------------------------------------------------
def cooling_rate(system: Cooling, cases: Sequence[CoolingCase]) -> Picture:
    """Draw h over e, and over the exact rate of late times."""
    sheet = Sheet(system, TWO_ROWS)
    e, exact = exact_rates(system.tangential_restitution, system.dimension)
    loss = 1 - e if system.is_smooth else np.ones_like(e)
    for ax, scale in zip(sheet.axes, (loss, exact), strict=True):
        sheet.line(ax, EXACT, e, exact / scale)
        if system.is_papers_law:
            sheet.line(ax, FIT, e, sonine.cooling_rate_fitted(e) / scale)
            sheet.line(ax, SONINE, e, sonine.cooling_rate(e) / scale)
    for case in cases:
        loss_of_case = 1 - case.value if system.is_smooth else 1.0
        scales = (loss_of_case, float(case.theory[EXACT]["cooling_rate"]))
        for ax, scale_of_case in zip(sheet.axes, scales, strict=True):
            _draw_rates(sheet, ax, case, scale_of_case)
    words = {"over": "h", "said": ""}
    label = "$h(e)$"
    if system.is_smooth:
        words["over"] = "h/(1 − e)"
        label = "$h(e)/(1-e)$"
    if system.is_papers_law:
        words["said"] = " Exactly it is √2 at e = 0 and 4/3 as e → 1; Sonine exists above e = 0.58."
    return Picture(sheet.finish(RESTITUTION_LABEL, label, "$h$ / exact $h$"), words)


def _draw_rates(sheet: Sheet, ax: Axes, case: CoolingCase, scale: float) -> None:
    """Draw the rates of one restitution: of the solver, of its averages, and of the particles."""
    e = case.value
    sheet.marks(ax, SOLVER, e, float(case.theory[SOLVER]["cooling_rate"]) / scale, "x")
    same_times = np.asarray(case.theory[KINETIC]["cooling_rate"]) / scale
    sheet.marks(ax, "equation, same times", e, same_times, "D")
    for source, measured in case.measured.items():
        rate = measured["cooling_rate"] / scale
        sheet.points(ax, source, e, rate, e, in_legend=False)


def _draw_over_time(
    cases: Sequence[Case], sheet: Sheet, observable: str, against: str, source: str
) -> None:
    """Draw an average over time; below, what a source measured over the theory."""
    top, below = sheet.axes
    top.set_xscale("log")
    for case in cases:
        theory = np.asarray(case.theory[against][observable])
        sheet.line(top, against, case.times, theory, case.value)
        for name, measured in case.measured.items():
            sheet.points(top, name, case.times, measured[observable], case.value)
        ratio = case.measured[source][observable] / theory
        sheet.points(below, source, case.times, ratio, case.value, max_error=MAX_ERROR_OF_RATIO)
    below.axhline(1, color=INK, linewidth=0.8)


def msd(system: Cooling, cases: Sequence[CoolingCase]) -> Picture:
    """Draw <r^2> over time, and over the dilute equation."""
    sheet = Sheet(system, TWO_ROWS)
    _draw_over_time(cases, sheet, "msd", KINETIC, system.hard)
    top, below = sheet.axes
    explanation = ""
    for case in cases:
        dense = case.solutions.dense
        if dense is not None:
            over_dilute = dense.msd / np.asarray(case.theory[KINETIC]["msd"])
            sheet.line(below, CORRECTED, case.times, over_dilute, case.value)
            explanation = (
                "Dashed there: the equation corrected for hard disks at this density, with "
                "nothing fitted here."
            )
        if system.is_papers_law:
            walk = np.asarray(case.theory[FIT]["msd"])
            sheet.line(top, FIT, case.times, walk, case.value)
    ratio = r"$\langle r^2\rangle$ / dilute"
    figure = sheet.finish(TIME_LABEL, r"$\langle r^2\rangle$  [d²]", ratio)
    return Picture(figure, {"said": explanation})


def _draw_panels(
    system: System, cases: Sequence[CoolingCase]
) -> tuple[Sheet, Iterator[tuple[CoolingCase, Axes]]]:
    """Return a sheet with a panel for each restitution, and pairs of a case and its panel."""
    columns = min(MAX_PANELS_IN_A_ROW, len(cases))
    rows = math.ceil(len(cases) / columns)
    sheet = Sheet(system, (PANEL_HEIGHT,) * rows, columns, has_panels=True)
    for spare in sheet.axes[len(cases) :]:
        spare.set_axis_off()
    for case, ax in zip(cases, sheet.axes, strict=False):
        title = f"e = {case.value:g}"
        ax.set_title(title, loc="left", color=sheet.colour(case.value), fontsize=10.5, pad=3)
    return sheet, zip(cases, sheet.axes, strict=False)


def vdf(system: Cooling, cases: Sequence[CoolingCase]) -> Picture:
    """Draw F(c) at the last time."""
    sheet, panels = _draw_panels(system, cases)
    is_shown = np.less(estimates.SPEEDS, SHOWN_SPEEDS[-1])
    for case, ax in panels:
        equation = last_vdf(case.solutions.kinetic, SHOWN_SPEEDS)
        sheet.line(ax, KINETIC, SHOWN_SPEEDS, equation, case.value, in_legend=False)
        for source, measured in case.measured.items():
            sheet.points(
                ax,
                source,
                estimates.SPEEDS[is_shown],
                measured["scaled_vdf"].select(is_shown),
                case.value,
                in_legend=False,
                max_error=MAX_ERROR_OF_VDF,
            )
        sheet.line(ax, GAUSSIAN, SHOWN_SPEEDS, gaussian_vdf(SHOWN_SPEEDS, case.dimension))
    figure = sheet.finish("scaled speed $c = v/v_0$", "$F(c)$")
    return Picture(figure, {"reason": _explain_slow_tracers(system, cases)})


def _explain_slow_tracers(system: Cooling, cases: Sequence[CoolingCase]) -> str:
    """Return why hard scatterers have more slow tracers; empty where they do not."""

    def density_at_rest(case: CoolingCase) -> float:
        return float(case.measured[system.hard]["scaled_vdf"].value[0])

    case = max(cases, key=density_at_rest)
    density = density_at_rest(case)
    error = float(case.measured[system.hard]["scaled_vdf"].error[0])
    equation = float(np.asarray(case.theory[KINETIC]["scaled_vdf"])[0])
    if density <= EXPLAINED_FROM * equation:
        return ""
    return (
        f" Near c = 0 {system.hard} have more (e = {case.value:g}: {density:.2f} ± {error:.2f}, "
        f"equation {equation:.2g}): tracers that bounce to and fro between two near scatterers, or "
        "in a corner of them, come to rest. The dilute equation has no such pairs."
    )


def position(system: Cooling, cases: Sequence[CoolingCase]) -> Picture:
    """Draw G(R) at the last time."""
    sheet, panels = _draw_panels(system, cases)
    radii = SHOWN_RADII
    for case, ax in panels:
        ax.set_yscale("log")
        ax.set_ylim(LOWEST_POSITION_DENSITY, HIGHEST_POSITION_DENSITY)
        density = case.solutions.position.scaled_position_density(radii)[-1]
        shown = np.where(density > 0, density, np.nan)
        sheet.line(ax, KINETIC, radii, shown, case.value, in_legend=False)
        for source, measured in case.measured.items():
            sheet.points(
                ax,
                source,
                estimates.DISTANCES,
                measured["position"],
                case.value,
                in_legend=False,
            )
        if system.is_papers_law:
            far = radii[radii > TAIL_FROM]
            sheet.line(ax, PEAK, radii, sonine.position_peak(radii))
            sheet.line(ax, TAIL, far, sonine.position_tail(far))
            sheet.line(ax, INTEGRAL, radii, sonine.position_integral(radii))
        else:  # as of c: a density in the plane or in space
            d = case.dimension
            surface = d * estimates.unit_ball(d) * radii ** (d - 1)
            sheet.line(ax, GAUSSIAN, radii, surface * gaussian_vdf(radii, d))
    return Picture(sheet.finish("scaled distance $R$", "$G(R)$"))


def kurtosis(system: Cooling, cases: Sequence[CoolingCase]) -> Picture:
    """Draw <r^4>/<r^2>^2 over time."""
    sheet = Sheet(system)
    (ax,) = sheet.axes
    ax.set_xscale("log")
    for case in cases:
        late = case.solutions.late
        sheet.line(ax, KINETIC, late.times, late.kurtosis, case.value)
        for source, measured in case.measured.items():
            sheet.points(ax, source, case.times, measured["kurtosis"], case.value)
    ends = [cases[0].times[0], LATEST_TIME]
    sheet.line(ax, GAUSSIAN, ends, 1 + 2 / cases[0].dimension)
    if system.is_papers_law:
        sheet.line(ax, INTEGRAL, ends, PAPER_KURTOSIS)
    return Picture(sheet.finish(TIME_LABEL, r"$\langle r^4\rangle/\langle r^2\rangle^2$"))


# -- driven tracers, and a restitution of the impact speed -----------------------------------------
def _draw_over_restitution(system: Driven, cases: Sequence[DrivenCase], *observables: str) -> Sheet:
    """Draw steady averages over e, and particles over the solver."""
    sheet = Sheet(system, TWO_ROWS)
    top, below = sheet.axes
    e: FloatArray = np.array([case.value for case in cases])
    for index, name in enumerate(observables):
        values = []
        errors = []
        solutions = []
        for case in cases:
            estimate = case.measured[FREE][name]
            values.append(estimate.value)
            errors.append(estimate.error)
            solutions.append(float(case.theory[SOLVER][name]))
        measured = Measured(np.array(values), np.array(errors))
        solved = np.array(solutions)
        group = Group(report_words().observables[name].short, index)
        sheet.line(top, SOLVER, e, solved, group)
        sheet.points(top, FREE, e, measured, group)
        sheet.points(below, FREE, e + SHIFT * index, measured / solved, group)
    below.axhline(1, color=INK, linewidth=0.8)
    top.set_xlim(-0.02, 1.0)
    top.set_ylim(bottom=0)
    return sheet


def drift(system: Driven, cases: Sequence[DrivenCase]) -> Picture:
    """Draw the drift over e."""
    sheet = _draw_over_restitution(system, cases, "drift")
    limit = limiting_drift(FINE_RESTITUTIONS, system.dimension)
    sheet.line(sheet.axes[0], LIMITING_LAW, FINE_RESTITUTIONS, limit)
    return Picture(sheet.finish(RESTITUTION_LABEL, "drift $u$  [√(gl)]", RATIO_TO_SOLVER))


def dispersion(system: Driven, cases: Sequence[DrivenCase]) -> Picture:
    """Draw both coefficients of dispersion over e."""
    names = ("diffusion_parallel", "diffusion_perpendicular")
    sheet = _draw_over_restitution(system, cases, *names)
    return Picture(sheet.finish(RESTITUTION_LABEL, "$D$  [√(gl³)]", RATIO_TO_SOLVER))


def from_rest(system: Driven, cases: Sequence[DrivenCase]) -> Picture:
    """Draw the mean velocity of tracers that start at rest in a field."""
    sheet = Sheet(system, TWO_ROWS)
    sheet.axes[0].set_yscale("log")
    _draw_over_time(cases, sheet, "drift_from_rest", SOLVER, FREE)
    return Picture(sheet.finish("time $t$  [√(l/g)]", "$⟨v_z⟩$  [√(gl)]", RATIO_TO_SOLVER))


def thermal_speed(system: Driven, cases: Sequence[DrivenCase]) -> Picture:
    """Draw v0(t)."""
    sheet = Sheet(system, TWO_ROWS)
    if system.is_viscoelastic:
        sheet.axes[0].set_yscale("log")
    _draw_over_time(cases, sheet, "thermal_speed", SOLVER, FREE)
    return Picture(sheet.finish("time $t$  [l/U]", "$v_0$  [U]", RATIO_TO_SOLVER))


def spread(system: Driven, cases: Sequence[DrivenCase]) -> Picture:
    """Draw <r^2>(t) of driven tracers."""
    sheet = Sheet(system, TWO_ROWS)
    sheet.axes[0].set_yscale("log")
    _draw_over_time(cases, sheet, "msd", SOLVER, FREE)
    return Picture(sheet.finish("time $t$  [l/U]", r"$\langle r^2\rangle$  [l²]", RATIO_TO_SOLVER))


__all__ = ["VARIABLES", "Drawn", "Picture", "draw_all"]
