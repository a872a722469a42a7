"""The paper's nine figures, made again from the three methods: begin with `draw_paper_figures`.

Each figure has the paper's axes. Points are particles: open symbols among hard disks, as in the
paper, filled ones in the dilute limit. Solid lines are the kinetic equation, or the exact result
where there is one; broken ones are the formulas that the paper draws. Beside each stands what the
paper shows, and a verdict in one sentence with numbers computed in the same call. Its words are
written for the paper's system and are not tested.

The paper is that of Kim and Hayakawa, "Statistical Properties of Inelastic Lorentz Gas". Lengths
are in d, the diameter of a disk; speeds in U, the standard deviation of one component of the
initial velocity; times in d/U; e is the restitution.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Circle

from kinetics import sonine
from kinetics.crosscheck.files import rendered, write_together
from kinetics.crosscheck.report import estimates
from kinetics.crosscheck.report.cases import (
    EXACT,
    FIT,
    FREE,
    KINETIC,
    SONINE,
    CoolingCase,
    FloatArray,
    Measured,
)
from kinetics.crosscheck.report.cooling import last_vdf, run_cooling
from kinetics.crosscheck.report.curves import exact_rates, gaussian_vdf
from kinetics.crosscheck.report.progress import Progress, say_nothing
from kinetics.crosscheck.report.sheet import (
    GAUSSIAN,
    INK,
    PEAK,
    STYLE,
    TAIL,
    Drawn,
    Sheet,
)
from kinetics.crosscheck.report.story import span, tail_exponent
from kinetics.crosscheck.report.systems import Cooling

#: Name of the page, and of its figures as files.
NAME = "figures-of-the-paper"
#: Slope of the straight line in the paper's figure 2, in 1/d: its density of scatterers, 0.04 d^-2,
#: times d and the 1.45 of its cooling rate h = 1.45 (1 - e).
SLOPE_OF_FIGURE_2 = 0.058
#: v0 of the Gaussian start in U: the root of the sum of the variances of both components.
INITIAL_V0 = math.sqrt(2.0)
#: Scaled radii R at which curves are drawn.
RADII = np.linspace(0.02, 6.0, 150)
#: Scaled speeds c at which curves are drawn.
SPEEDS = np.linspace(0.01, 3.0, 150)
#: Name of the broken line of figure 8.
OTHER_ROOT = "root of eq. (B17)"
#: Lowest G(R) that is shown. The origin of the number is not recorded.
LOWEST_POSITION_DENSITY = 1e-4
#: Highest G(R) that is shown. The origin of the number is not recorded.
HIGHEST_POSITION_DENSITY = 2.0
#: Lowest F(c) that is shown. The origin of the number is not recorded.
LOWEST_VDF = 1e-5
#: Highest F(c) that is shown. The origin of the number is not recorded.
HIGHEST_VDF = 1.0
#: Height in inches of a figure with one panel.
HEIGHT = 3.4
#: Impact parameter over d of the collision that figures 1 and 7 show.
SHOWN_IMPACT_PARAMETER = 0.5
#: Restitution of that collision.
SHOWN_RESTITUTION = 0.7
#: Its incoming speed, which sets the length of the arrows only.
SHOWN_SPEED = 2.0


@dataclass(frozen=True)
class PaperFigure:
    """A figure of the paper, made again.

    Parameters
    ----------
    number : in the paper, 1 to 9
    title : what it shows, in a few words
    in_the_paper : what the paper shows there
    verdict : one sentence on what came out
    figure : the picture
    """

    number: int
    title: str
    in_the_paper: str
    verdict: str
    figure: Figure

    @property
    def drawn(self) -> Drawn:
        """The figure as a part of a page, or as a file."""
        title = f"Figure {self.number}: {self.title}"
        return Drawn(f"figure-{self.number}", title, self.verdict, self.figure)


@dataclass(frozen=True)
class PaperFigures:
    """All nine figures, and the system that was run for them."""

    system: Cooling
    figures: Sequence[PaperFigure]

    @property
    def page(self) -> str:
        """The HTML page, with nothing beside it."""
        from markupsafe import Markup

        return rendered(
            "paper_figures.html.j2",
            figures=[(entry, Markup(entry.drawn.svg())) for entry in self.figures],
            system=self.system,
            today=date.today().isoformat(),
        )

    @property
    def text(self) -> str:
        """The verdicts, one line for each figure."""
        lines = [f"{entry.number}. {entry.title}: {entry.verdict}" for entry in self.figures]
        return "\n".join(lines)

    def write(self, folder: Path, formats: Sequence[str] = ()) -> list[Path]:
        """Write the page, and each figure in these formats, all or nothing; return the paths."""
        contents: dict[str, str | bytes] = {f"{NAME}.html": self.page}
        for kind in dict.fromkeys(formats):
            for entry in self.figures:
                contents[f"{NAME}-{entry.number}.{kind}"] = entry.drawn.file(kind)
        return write_together(folder, contents)


def draw_paper_figures(system: Cooling, progress: Progress | None = None) -> PaperFigures:
    """Run the three methods on the paper's system, and draw its nine figures.

    Parameters
    ----------
    system : smooth disks; the paper's restitutions, density and times unless they are others
    progress : called with the name of each stage
    """
    cases = run_cooling(system, progress or say_nothing)
    with mpl.rc_context(fname=STYLE):
        figures = [
            collision(),
            thermal_velocity(system, cases),
            cooling_rate(system, cases),
            mean_square_displacement(system, cases),
            position_distribution(system, cases),
            velocity_distribution(system, cases),
            impact(),
            stability(system),
            sonine_displacement(system, cases),
        ]
    return PaperFigures(system, figures)


def _draw_particles(
    sheet: Sheet, ax: Axes, case: CoolingCase, abscissa: FloatArray, points: Mapping[str, Measured]
) -> None:
    """Draw what each kind of particles has measured, over a common abscissa."""
    for source, measured in points.items():
        sheet.points(ax, source, abscissa, measured, case.value)


# -- figures 1 and 7: a collision ------------------------------------------------------------------
def collision() -> PaperFigure:
    """Draw figure 1: the unit vector, and the velocities before and after."""
    figure, ax = _collision_axes()
    _draw_collision(ax)
    return PaperFigure(
        1,
        "the collision",
        "The unit vector σ̂ from the scatterer's centre to the tracer's, the velocity v* before "
        "and v after the collision.",
        "The rule v = v* − (1 + e)(v*·σ̂)σ̂ is what all three methods use; the picture is a "
        f"collision computed with it at e = {SHOWN_RESTITUTION:g}.",
        figure,
    )


def impact() -> PaperFigure:
    """Draw figure 7: the impact parameter and the angle of a collision."""
    figure, ax = _collision_axes()
    contact = _draw_collision(ax)
    ax.plot([-2.4, 1.2], [0.0, 0.0], color=INK, linewidth=0.8, linestyle="--")
    ax.annotate(
        "",
        (-2.1, 0.0),
        (-2.1, SHOWN_IMPACT_PARAMETER),
        arrowprops={"arrowstyle": "<->", "color": INK},
    )
    ax.text(-2.0, 0.2, "$b$", color=INK)
    angle = math.degrees(math.asin(SHOWN_IMPACT_PARAMETER))
    ax.add_patch(Arc((0.0, 0.0), 0.7, 0.7, theta1=180.0 - angle, theta2=180.0, color=INK))
    ax.text(-0.4, -0.25, "$\\pi-\\psi$", color=INK)
    ax.plot([contact[0], 0.0], [contact[1], 0.0], color=INK, linewidth=0.8)
    return PaperFigure(
        7,
        "the impact parameter",
        "A collision with its impact parameter b = d sin(π − ψ).",
        "All b from −d to d are equally probable; the averages over b that Appendix A begins from "
        "are derived again by the algebra.",
        figure,
    )


def _collision_axes() -> tuple[Figure, Axes]:
    figure = Figure(figsize=(5.0, 2.9), layout="constrained")
    ax = figure.subplots()
    ax.set_aspect("equal")
    ax.set_xlim(-2.6, 1.4)
    ax.set_ylim(-0.8, 1.7)
    ax.set_axis_off()
    return figure, ax


def _draw_collision(ax: Axes) -> FloatArray:
    """Draw scatterer and tracer in contact, and the velocities; return the tracer's centre."""
    y = SHOWN_IMPACT_PARAMETER
    sigma = np.array([-math.sqrt(1.0 - y**2), y])
    before = np.array([SHOWN_SPEED, 0.0])
    after = before - (1.0 + SHOWN_RESTITUTION) * (before @ sigma) * sigma
    ax.add_patch(Circle((0.0, 0.0), 0.5, fill=False, edgecolor=INK))
    ax.add_patch(Circle((float(sigma[0]), float(sigma[1])), 0.5, fill=False, edgecolor=INK))
    ax.text(0.0, -0.72, "scatterer", ha="center", color=INK)
    ax.text(float(sigma[0]), -0.28, "tracer", ha="center", color=INK)
    arrows = [
        (sigma - before * 0.75, sigma, "$v^*$", (-1.4, 0.1)),
        (sigma, sigma + after * 0.6, "$v$", (-0.5, 0.75)),
        (np.zeros(2), 0.6 * sigma, "$\\hat\\sigma$", (0.66, -0.27)),
    ]
    for tail, tip, label, shift in arrows:
        arrow = {"arrowstyle": "-|>", "color": INK, "shrinkA": 0, "shrinkB": 0}
        tip_place = (float(tip[0]), float(tip[1]))
        tail_place = (float(tail[0]), float(tail[1]))
        ax.annotate("", tip_place, tail_place, arrowprops=arrow)
        place = sigma + np.array(shift)
        ax.text(float(place[0]), float(place[1]), label, color=INK)
    return sigma


# -- figures 2 and 3: the thermal speed and the cooling rate ---------------------------------------
def thermal_velocity(system: Cooling, cases: Sequence[CoolingCase]) -> PaperFigure:
    """Draw figure 2: J = (1/v0(t) - 1/v0(0))/(1 - e) over t."""
    sheet = Sheet(system, (HEIGHT,))
    (ax,) = sheet.axes
    ax.set_xscale("log")
    ax.set_yscale("log")
    slopes = []
    late_slopes = []
    for case in cases:
        loss = 1.0 - case.value
        points = {}
        for source, speed in case.measured_of("thermal_speed").items():
            slowness = 1.0 / speed.value
            points[source] = Measured(
                (slowness - 1.0 / INITIAL_V0) / loss, speed.error * slowness**2 / loss
            )
        of_equation = 1.0 / np.asarray(case.theory[KINETIC]["thermal_speed"])
        sheet.line(ax, KINETIC, case.times, (of_equation - 1.0 / INITIAL_V0) / loss, case.value)
        _draw_particles(sheet, ax, case, case.times, points)
        slopes.append(float(points[system.hard].last.value) / case.times[-1])
        exact_rate = float(case.theory[EXACT]["cooling_rate"])
        late_slopes.append(system.number_density * exact_rate / (1.0 - case.value))
    times = np.array([case.times for case in cases])
    ends = np.array([times.min(), times.max()])
    sheet.line(ax, "paper: 0.058 t", ends, SLOPE_OF_FIGURE_2 * ends)
    figure = sheet.finish("$t$  [d/U]", "$J = (1/v_0(t)-1/v_0(0))/(1-e)$  [1/U]")
    return PaperFigure(
        2,
        "the thermal speed",
        "J(t) of all four e on one straight line, 0.058 t U/d.",
        f"At its last times J/t is {span(slopes, '.3f')} among hard disks, close to one line; in "
        f"the end the dilute gas has {span(late_slopes, '.4f')}, which differs with e.",
        figure,
    )


def cooling_rate(system: Cooling, cases: Sequence[CoolingCase]) -> PaperFigure:
    """Draw figure 3: h(e) of the simulation and M2/2 of the Sonine expansion."""
    sheet = Sheet(system, (HEIGHT,))
    (ax,) = sheet.axes
    e, exact = exact_rates(1.0, 2)
    sheet.line(ax, EXACT, e, exact)
    sheet.line(ax, FIT, e, sonine.cooling_rate_fitted(e))
    of_sonine = sonine.cooling_rate(e)
    sheet.line(ax, SONINE, e, of_sonine)
    for case in cases:
        for source, measured in case.measured.items():
            rate = measured["cooling_rate"]
            sheet.points(ax, source, case.value, rate, case.value, in_legend=False)
    figure = sheet.finish("restitution $e$", "$h(e)$,  $M_2/2$")
    of_sonine_over_exact = 100.0 * (of_sonine / exact - 1.0)
    is_inelastic = e < 1.0
    fit_off = sonine.cooling_rate_fitted(e[is_inelastic]) / exact[is_inelastic] - 1.0
    return PaperFigure(
        3,
        "the cooling rate",
        "M₂/2 of the Sonine expansion lies on h = 1.45 (1 − e) of the simulation where it exists.",
        f"M₂/2 is {span(of_sonine_over_exact.tolist(), '.0f')} % above the exact h; the fit "
        f"is {span((100 * fit_off).tolist(), '.0f')} % above it.",
        figure,
    )


# -- figures 4 and 9: the mean square displacement -------------------------------------------------
def _draw_scaled_msd(
    sheet: Sheet, ax: Axes, case: CoolingCase, abscissa: FloatArray, factor: float
) -> None:
    """Draw <r^2> times a factor, of the equation and of the particles, over a common abscissa."""
    of_equation = np.asarray(case.theory[KINETIC]["msd"])
    sheet.line(ax, KINETIC, abscissa, factor * of_equation, case.value)
    points: dict[str, Measured] = {}
    for source, msd in case.measured_of("msd").items():
        points[source] = Measured(msd.value * factor, msd.error * factor)
    _draw_particles(sheet, ax, case, abscissa, points)


def mean_square_displacement(system: Cooling, cases: Sequence[CoolingCase]) -> PaperFigure:
    """Draw figure 4: K = <r^2> ln(1 + l beta) over (1 - e) t."""
    sheet = Sheet(system, (HEIGHT,))
    (ax,) = sheet.axes
    ax.set_xscale("log")
    over_walk = []
    slopes = []
    for case in cases:
        rate = sonine.beta(case.value, system.number_density)
        factor = float(np.log1p(sonine.FITTED_FREE_PATH * rate))
        abscissa = (1.0 - case.value) * case.times
        _draw_scaled_msd(sheet, ax, case, abscissa, factor)
        walk = np.asarray(case.theory[FIT]["msd"])
        sheet.line(ax, FIT, abscissa, factor * walk)
        at_the_end = float(case.measured[system.hard]["msd"].last.value)
        over_walk.append(100.0 * (at_the_end / walk[-1] - 1.0))
        exact_slope = float(case.theory[EXACT]["msd_slope"])
        slopes.append(float(case.theory[FIT]["msd_slope"]) / exact_slope)
    figure = sheet.finish("$(1-e)\\,t$  [d/U]", "$\\langle r^2\\rangle\\ln(1+l\\beta)$  [d²]")
    return PaperFigure(
        4,
        "the mean square displacement",
        "K(t) of all four e on one curve, which eq. (22) of the random walk meets as time goes on.",
        f"At the last times hard disks are {span(over_walk, '+.0f')} % from the walk; but the "
        f"late slope of the walk is {span(slopes, '.2f')} of the dilute one, and the "
        "growth never ends: the tracer is not localised.",
        figure,
    )


def sonine_displacement(system: Cooling, cases: Sequence[CoolingCase]) -> PaperFigure:
    """Draw figure 9: W = <r^2> (1 + e)^2 (1 - e^2) (1 + 3 a2/8)^2 over its own time."""
    sheet = Sheet(system, (HEIGHT,))
    (ax,) = sheet.axes
    ax.set_xscale("log")
    slopes = []
    for case in cases:
        e = case.value
        if e < sonine.THRESHOLD_RESTITUTION:
            continue  # as in the paper: there is no a2 at this restitution
        a2 = float(sonine.a2(e))
        correction = 1.0 + 3.0 / 8.0 * a2
        factor = (1.0 + e) ** 2 * (1.0 - e**2) * correction**2
        abscissa = (1.0 - e**2) * correction * case.times
        _draw_scaled_msd(sheet, ax, case, abscissa, factor)
        formula = sonine.msd_sonine(case.times, e, system.number_density)
        sheet.line(ax, SONINE, abscissa, factor * formula)
        # d<r^2>/d ln t of (C9) at late times, where its logarithm is ln t and a constant
        late_slope = 8.0 / (math.pi * system.number_density**2) / factor
        slopes.append(late_slope / float(case.theory[EXACT]["msd_slope"]))
    figure = sheet.finish("$(1-e^2)(1+3a_2/8)\\,t$  [d/U]", "$W(t,e)$  [d²]")
    return PaperFigure(
        9,
        "the mean square displacement of the Sonine expansion",
        "The simulation is on no single curve, and eq. (C9) deviates from it: the paper calls it "
        "no good approximation.",
        f"So it is: the late slope of (C9) is {span(slopes, '.2f')} of the exact dilute one.",
        figure,
    )


# -- figures 5 and 6: the distributions ------------------------------------------------------------
def position_distribution(system: Cooling, cases: Sequence[CoolingCase]) -> PaperFigure:
    """Draw figure 5: G(R) at the last time."""
    sheet = Sheet(system, (HEIGHT,))
    (ax,) = sheet.axes
    ax.set_yscale("log")
    ax.set_ylim(LOWEST_POSITION_DENSITY, HIGHEST_POSITION_DENSITY)
    for case in cases:
        density = case.solutions.position.scaled_position_density(RADII)[-1]
        sheet.line(ax, KINETIC, RADII, np.where(density > 0.0, density, np.nan), case.value)
        points = case.measured_of("position")
        _draw_particles(sheet, ax, case, estimates.DISTANCES, points)
    sheet.line(ax, PEAK, RADII, sonine.position_peak(RADII))
    far = RADII[RADII > 1.0]
    sheet.line(ax, TAIL, far, sonine.position_tail(far))
    ax.set_xlim(0.0, RADII[-1])
    exponents = map(tail_exponent, cases)
    figure = sheet.finish("$R = r/\\sqrt{\\langle r^2\\rangle}$", "$G(R)$")
    return PaperFigure(
        5,
        "the scaled position distribution",
        "G(R) of all four e nearly on one curve, Gaussian near its peak, with a tail that seems "
        "exponential; two fitted formulas describe peak and tail.",
        f"The curves are close, but differ with e and time: at R = 4 the tail falls as "
        f"exp(−a Rⁿ) with n = {span(exponents, '.2f')} (1 is exponential, 2 Gaussian).",
        figure,
    )


def velocity_distribution(system: Cooling, cases: Sequence[CoolingCase]) -> PaperFigure:
    """Draw figure 6: F(c) at the last time."""
    sheet = Sheet(system, (HEIGHT,))
    (ax,) = sheet.axes
    ax.set_yscale("log")
    ax.set_ylim(LOWEST_VDF, HIGHEST_VDF)
    for case in cases:
        sheet.line(ax, KINETIC, SPEEDS, last_vdf(case.solutions.kinetic, SPEEDS), case.value)
        points = case.measured_of("scaled_vdf")
        _draw_particles(sheet, ax, case, estimates.SPEEDS, points)
    sheet.line(ax, GAUSSIAN, SPEEDS, gaussian_vdf(SPEEDS, 2))
    a2 = [float(case.theory[EXACT]["a2"]) for case in cases]
    n_hard = cases[0].sizes[system.hard].total
    n_free = cases[0].sizes[FREE].total
    ax.set_xlim(0.0, SPEEDS[-1])
    figure = sheet.finish("$c = v/v_0$", "$F(c)$")
    return PaperFigure(
        6,
        "the scaled velocity distribution",
        "F(c) of the simulation over cₓ beside a Maxwellian, which fits it within its scatter.",
        f"With {n_free:,} dilute tracers the two differ clearly (exact a₂ = {span(a2, '.2f')}, "
        f"0 for a Maxwellian); the {n_hard:,} tracers among disks scatter too much to tell.",
        figure,
    )


# -- figure 8: the stability of a2 -----------------------------------------------------------------
def stability(system: Cooling) -> PaperFigure:
    """Draw figure 8: H(e) of both roots of a2."""
    sheet = Sheet(system, (HEIGHT,))
    (ax,) = sheet.axes
    # just above the threshold, where rounding leaves the root real
    e = np.linspace(sonine.THRESHOLD_RESTITUTION + 1e-9, 1.0, 200)
    stable = sonine.stability(e)
    unstable = sonine.stability(e, "unstable")
    sheet.line(ax, "root of eq. (B18)", e, stable)
    sheet.line(ax, OTHER_ROOT, e, unstable)
    ax.axhline(0.0, color=INK, linewidth=0.8)
    figure = sheet.finish("restitution $e$", "$H(e)$")
    is_right = bool(np.all(stable <= 0.0) and np.all(unstable >= 0.0))
    judgement = "It is as printed" if is_right else "It is not as printed"
    return PaperFigure(
        8,
        "the stability of a₂",
        "H(e) is negative for the root (B18) of a₂, which is stable, and positive for the root "
        "(B17).",
        f"{judgement}: the roots meet at e = {sonine.THRESHOLD_RESTITUTION:.3f}, below which the "
        "expansion has none, though the exact state exists for every e.",
        figure,
    )
