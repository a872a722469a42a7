"""The paper's Figures 2, 3, 4, 5, 6, 8 and 9, named by their labels, beside the exact theory."""

import math
from collections.abc import Callable, Sequence

import numpy as np

from kinetics import sonine
from kinetics.crosscheck.report.case import Array, Case
from kinetics.crosscheck.report.figure_lines import (
    LARGEST_RELATIVE_ERROR,
    Data,
    all_restitutions,
    axis,
    both_runs,
    figure,
    middles,
    over_restitution,
    points,
    series,
)
from kinetics.crosscheck.report.row import last_vdf
from kinetics.crosscheck.report.settings import ReportSettings

BEYOND_LAST = 10.0
"""Lines of the equation go on to so many times the last time of the particles."""


def has_sonine(case: Case) -> bool:
    """Whether the printed a2 is real at this restitution."""
    return bool(np.isfinite(sonine.a2(case.restitution)))


def v0re(cases: Sequence[Case], settings: ReportSettings) -> Data:
    """J = (1/v0(t) - 1/v0(0))/(1-e) over t (Fig. 2), and its straight line."""
    lines = []
    for case in cases:
        e = case.restitution
        shown = case.late.times <= BEYOND_LAST * case.times[-1]
        t, start = case.late.times[shown], 1 / sonine.THERMAL_SPEED_START
        j = (1 / case.late.thermal_speed[shown] - start) / (1 - e)
        lines.append(series("kinetic equation", t, j, None, e))
        for run in both_runs(case):
            v, dv = run.thermal_speed.value, run.thermal_speed.error
            lines.append(
                points(run.name, case.times, (1 / v - start) / (1 - e), dv / v**2 / (1 - e), e)
            )
    ends = np.array(
        [min(case.times[0] for case in cases), max(case.times[-1] for case in cases) * BEYOND_LAST]
    )
    slope = sonine.FITTED_COOLING_FACTOR * settings.number_density
    lines.append(series("paper's fit", ends, slope * ends))
    return figure(
        "Figure 2 (v0re): inverse thermal speed",
        "J(t, e) = (1/v₀(t) − 1/v₀(0))/(1 − e). The paper's straight line is "
        f"J = {slope:.3g} t. The equation's late slopes, dρ₀ h(e)/(1 − e), differ by up to "
        "7 %, which these axes hide: see the figure of J/t. Points whose standard error "
        f"is above {LARGEST_RELATIVE_ERROR:.0%} of them are left out.",
        axis("time $t$", "d/U", "log"),
        axis("$J(t, e)$", "1/U", "log"),
        lines,
    )


def hetomu2(cases: Sequence[Case]) -> Data:
    """h(e) and M2/2 over e (Fig. 3)."""
    from kinetics.scaling.closed_form import ScalingSolution

    e = all_restitutions()
    lines = over_restitution(
        cases,
        lambda e: [ScalingSolution(float(x)).cooling_rate for x in e],
        lambda _, run: (float(run.cooling_rate.value), float(run.cooling_rate.error)),
        lambda case: case.scaled.cooling_rate if case.scaled else math.nan,
    )
    lines += [
        series("Sonine", e, sonine.cooling_rate(e)),
        series("paper's fit", e, sonine.cooling_rate_fitted(e)),
    ]
    return figure(
        "Figure 3 (hetomu2): cooling rate",
        "h(e) over the restitution e. The paper's fit is 1.45 (1 − e); its M₂/2 with the Sonine "
        "a₂ exists only above e = 0.58. Particle values are the slope of 1/v₀ over the last "
        "decade of time, with l = 1/(2dρ₀); the bars are one standard error.",
        axis("restitution $e$", limits=(0.0, 1.0)),
        axis("$h(e)$"),
        lines,
    )


def msdtheory(cases: Sequence[Case], settings: ReportSettings) -> Data:
    """K = <r^2> ln(1 + l beta) over (1-e) t (Fig. 4), and the random walk (label msd)."""
    lines, path = [], sonine.FITTED_FREE_PATH
    reach = []
    for case in cases:
        e = case.restitution
        factor = math.log1p(path * float(sonine.beta(e, settings.number_density)))
        lines += _scaled_msd(case, 1 - e, factor)
        reach += [case.times[0] * (1 - e), case.times[-1] * (1 - e) * BEYOND_LAST]
    # K of the random walk depends on (1-e) t alone: any e gives its curve.
    x = np.geomspace(min(reach), max(reach), 80)
    e = cases[0].restitution
    factor = math.log1p(path * float(sonine.beta(e, settings.number_density)))
    walk = sonine.msd_random_walk(x / (1 - e), e, settings.number_density)
    lines.append(series("paper's fit", x, walk * factor))
    return figure(
        "Figure 4 (msdtheory): mean square displacement",
        "K(t, e) = ⟨r²⟩ ln(1 + lβ) over (1 − e)t, with the paper's l = 13.5 d and "
        f"β = {sonine.FITTED_COOLING_FACTOR * settings.number_density:.3g} (1 − e)/d. "
        "The paper's random walk is one curve for every e; the "
        "equation's solutions do not collapse. The dotted lines have the exact slope of late "
        "times, 2l²/(κ(1 − ⟨cos χ⟩)) for ⟨r²⟩. The bars are one standard error.",
        axis(r"$(1-e)\,t$", "d/U", "log"),
        axis("$K(t, e)$", "d²"),
        lines,
    )


def _scaled_msd(case: Case, stretch: float, factor: float) -> list[Data]:
    """<r^2> times a factor over t times a stretch: equation, its exact late slope, particles."""
    assert case.exact is not None
    e, late = case.restitution, case.late
    shown = late.times <= BEYOND_LAST * case.times[-1]
    t = late.times[shown]
    slope = case.exact.diffusion_slope * case.late.scene.mean_free_path**2
    asymptote = late.msd[-1] + slope * np.log(t / late.times[-1])
    above = asymptote > 0
    return [
        series("kinetic equation", stretch * t, factor * late.msd[shown], None, e),
        series("exact slope", stretch * t[above], factor * asymptote[above], None, e),
        *(
            series(
                run.name, stretch * case.times, factor * run.msd.value, factor * run.msd.error, e
            )
            for run in both_runs(case)
        ),
    ]


def soninediffuse(cases: Sequence[Case], settings: ReportSettings) -> Data:
    """W = <r^2> (1+e)^2 (1-e^2) (1 + 3 a2/8)^2 (Fig. 9), and the Sonine result (label ad8)."""
    lines, reach = [], []
    for case in cases:
        stretch, factor = _sonine_scales(case.restitution)
        lines += _scaled_msd(case, stretch, factor)
        reach += [case.times[0] * stretch, case.times[-1] * stretch * BEYOND_LAST]
    x = np.geomspace(min(reach), max(reach), 80)
    e = cases[0].restitution
    stretch, factor = _sonine_scales(e)
    w = factor * sonine.msd_sonine(x / stretch, e, settings.number_density)
    lines.append(series("Sonine", x, w))
    return figure(
        "Figure 9 (soninediffuse): diffusion by the Sonine expansion",
        "W(t, e) = ⟨r²⟩ (1 + e)² (1 − e²) (1 + 3a₂/8)² over (1 − e²)(1 + 3a₂/8)t with the printed "
        "a₂, which exists only above e = 0.58. The paper's result is one curve; neither particles "
        "nor the equation's solutions lie on it. The dotted lines have the exact slope of late "
        "times. The bars are one standard error.",
        axis(r"$(1-e^2)(1+3a_2/8)\,t$", "d/U", "log"),
        axis("$W(t, e)$", "d²"),
        lines,
    )


def _sonine_scales(e: float) -> tuple[float, float]:
    """What multiplies t and <r^2> in the paper's Figure 9."""
    correction = 1 + 3 / 8 * float(sonine.a2(e))
    stretch = (1 - e**2) * correction
    return stretch, (1 + e) ** 2 * stretch * correction


def inelasticposi(cases: Sequence[Case]) -> Data:
    """G(R) at the last time (Fig. 5), with the paper's forms and their constants."""
    lines = []
    r = np.linspace(0.02, cases[0].position_edges[-1], 150)
    for case in cases:
        e, g = case.restitution, case.position.scaled_position_density(r)[-1]
        lines.append(series("kinetic equation", r, np.where(g > 0, g, np.nan), None, e))
        for run in both_runs(case):
            at, seen = middles(case.position_edges), run.position
            lines.append(points(run.name, at, seen.value, seen.error, e))
    lines += [
        series("paper, peak", r, sonine.position_peak(r)),
        series("paper, tail", r[r > 1], sonine.position_tail(r[r > 1])),
        series("paper's integral", r, sonine.position_integral(r)),
    ]
    return figure(
        "Figure 5 (inelasticposi): scaled position distribution",
        "G(R) over the scaled distance R = r/√⟨r²⟩ at the last time, a density over R. The "
        "paper's peak form has η = 0.75, its tail form η = 0.25 and γ = 7.39, both fitted; its "
        "integral, not fitted, is drawn with the η = 1/2 that ⟨R²⟩ = 1 demands. The bars are one "
        "standard error; bins whose error is above half their value are left out.",
        axis("scaled distance $R$"),
        axis("$G(R)$", "", "log", (1e-5, 2.0)),
        lines,
    )


def scalev(cases: Sequence[Case]) -> Data:
    """F(c) at the last time (Fig. 6), and the Gaussian that the paper fits."""
    c = np.linspace(0.01, 2.5, 150)
    lines = vdf_lines(cases, c, (0.0, 2.5))
    lines.append(series("Gaussian", c, sonine.vdf(c, 0.0)))
    return figure(
        "Figure 6 (scalev): scaled velocity distribution",
        "F(c) over c = v/v₀, a density in the plane and isotropic, at the last time. The paper "
        "reads its data as the Gaussian exp(−c²)/π. The exact scaling state is not: for e above 0 "
        "it vanishes at c = 0, and as e approaches 1 it becomes a ring at c = 1. The bars are one "
        "standard error.",
        axis("scaled speed $c = v/v_0$", limits=(0.0, 2.5)),
        axis("$F(c)$"),
        lines,
    )


def vdf_lines(cases: Sequence[Case], c: Array, shown: tuple[float, float]) -> list[Data]:
    """F(c) of every witness: solution and scaling state at c, particles in bins within `shown`."""
    lines = []
    for case in cases:
        assert case.scaled is not None
        e = case.restitution
        lines.append(series("kinetic equation", c, last_vdf(case.kinetic)(c), None, e))
        state: Callable[[Array], Array] = case.scaled.vdf
        lines.append(series("scaling state", c, state(c), None, e))
        at = middles(case.speed_edges)
        inside = (at >= shown[0]) & (at <= shown[1])
        for run in both_runs(case):
            value, error = run.vdf.value[inside], run.vdf.error[inside]
            lines.append(points(run.name, at[inside], value, error, e))
    return lines


def sign(cases: Sequence[Case]) -> Data:
    """H(e) = 3 a2 - (15 e^2/4 + 1/8) (Fig. 8): both printed roots, and the true a2 put in."""
    from kinetics.scaling.closed_form import ScalingSolution

    e = all_restitutions()

    def growth(restitution: float, a2: float) -> float:
        return 3 * a2 - (15 / 4 * restitution**2 + 1 / 8)

    lines = [series("zero", [0.0, 1.0], [0.0, 0.0])]
    lines += over_restitution(
        cases,
        lambda e: [growth(float(x), ScalingSolution(float(x)).a2) for x in e],
        lambda case, run: (
            growth(case.restitution, float(run.a2.value[-1])),
            3 * float(run.a2.error[-1]),
        ),
        lambda case: growth(case.restitution, case.scaled.a2 if case.scaled else math.nan),
    )
    lines += [
        series("Sonine", e, sonine.stability(e)),
        series("Sonine, unstable root", e, sonine.stability(e, "unstable")),
    ]
    return figure(
        "Figure 8 (sign): stability of the Sonine roots",
        "H(e) = 3a₂ − (15e²/4 + 1/8), the rate at which a disturbance of a₂ grows in the paper's "
        "first approximation, for both printed roots; they exist only above e = 0.58. Beside "
        "them H with the exact a₂ put in, and with that of the particles at the last time (one "
        "standard error).",
        axis("restitution $e$", limits=(0.0, 1.0)),
        axis("$H(e)$"),
        lines,
    )
