"""The figures that the paper lacks."""

import math
from collections.abc import Sequence

import numpy as np

from kinetics import sonine
from kinetics.crosscheck.report.case import Case, DensityScan, Measured, TrapScan
from kinetics.crosscheck.report.case_rows import PAPER_KURTOSIS, sonine_slopes
from kinetics.crosscheck.report.figure_lines import (
    Data,
    all_restitutions,
    axis,
    both_runs,
    figure,
    over_restitution,
    series,
)
from kinetics.crosscheck.report.histograms import band_middles
from kinetics.crosscheck.report.observables import bands_of, sure_density
from kinetics.crosscheck.report.settings import ReportSettings
from kinetics.crosscheck.report.velocity_figures import vdf_lines

LARGEST_SLOPE_ERROR = 0.2
"""Standard error of (1/v0 - 1/v0(0))/((1-e) d rho0 t) above which a point says nothing."""
APPROACH_ENDS = 1e5
"""Last time, in d/U, of the figure of the approach to the scaling state."""
LARGEST_EXPONENT_ERROR = 0.5
"""Standard error of n(R) above which a point says nothing."""
RATIO_NAMES = {"free_path": "free path", "thermal_speed": "thermal speed", "msd": "⟨r²⟩"}


def cooling_rate(cases: Sequence[Case]) -> Data:
    """h(e)/(1-e) from e = 0 to 1: every witness, and both printed formulas (hetomu2, hsimu)."""
    from kinetics.scaling.closed_form import ScalingSolution

    e = all_restitutions()
    lines = over_restitution(
        cases,
        lambda e: [ScalingSolution(float(x)).cooling_rate / (1 - x) for x in e],
        lambda case, run: (
            float(run.cooling_rate.value) / (1 - case.restitution),
            float(run.cooling_rate.error) / (1 - case.restitution),
        ),
        lambda case: case.scaled.cooling_rate / (1 - case.restitution) if case.scaled else math.nan,
    )
    lines += [
        series("Sonine", e, sonine.cooling_rate(e) / (1 - e)),
        series("paper's fit", e, sonine.cooling_rate_fitted(e) / (1 - e)),
    ]
    return figure(
        "Cooling rate over inelasticity",
        "h(e)/(1 − e) over the restitution e. Exactly, it is √2 at e = 0 and 4/3 as e approaches "
        "1; the paper's fit is the constant 1.45, and its Sonine expression exists only above "
        "e = 0.58. Particle values are the slope of 1/v₀ over a finite time, with l = 1/(2dρ₀); "
        "the bars are one standard error.",
        axis("restitution $e$", limits=(0.0, 1.0)),
        axis("$h(e)/(1-e)$"),
        lines,
    )


def a2(cases: Sequence[Case]) -> Data:
    """Second Sonine coefficient: exact, solver, printed roots (sonine11), particles at the end."""
    from kinetics.scaling.closed_form import ScalingSolution

    e = all_restitutions()
    lines = [series("zero", [0.0, 1.0], [0.0, 0.0])]
    lines += over_restitution(
        cases,
        lambda e: [ScalingSolution(float(x)).a2 for x in e],
        lambda _, run: (float(run.a2.value[-1]), float(run.a2.error[-1])),
        lambda case: case.scaled.a2 if case.scaled else math.nan,
    )
    lines += [
        series("Sonine", e, sonine.a2(e)),
        series("Sonine, unstable root", e, sonine.a2(e, "unstable")),
    ]
    return figure(
        "Second Sonine coefficient",
        "a₂(e) = ⟨c⁴⟩/2 − 1. Exactly, it falls from 2 at e = 0 to −1/2 as e approaches 1; the two "
        "printed roots exist only above e = 0.58. Particle values are those of the last time, when "
        "the Gaussian start is not quite forgotten; the bars are one standard error.",
        axis("restitution $e$", limits=(0.0, 1.0)),
        axis("$a_2$"),
        lines,
    )


def inverse_speed(cases: Sequence[Case], settings: ReportSettings) -> Data:
    """The paper's J over its abscissa d rho0 t, which shows what the logarithms of v0re hide."""
    lines = []
    start = 1 / sonine.THERMAL_SPEED_START
    for case in cases:
        assert case.exact is not None
        e = case.restitution
        scale = (1 - e) * settings.number_density * case.times
        v = case.kinetic.thermal_speed
        lines.append(series("kinetic equation", case.times, (1 / v - start) / scale, None, e))
        limit = case.exact.cooling_rate / (1 - e)
        lines.append(series("exact limit", case.times[[0, -1]], [limit, limit], None, e))
        for run in both_runs(case):
            v, dv = run.thermal_speed.value, run.thermal_speed.error
            error = dv / v**2 / scale
            shown = error < LARGEST_SLOPE_ERROR
            j = (1 / v - start) / scale
            lines.append(series(run.name, case.times[shown], j[shown], error[shown], e))
    ends = [min(case.times[0] for case in cases), max(case.times[-1] for case in cases)]
    lines.append(series("paper's fit", ends, [sonine.FITTED_COOLING_FACTOR] * 2))
    return figure(
        "Inverse thermal speed over time",
        "The paper's J divided by its abscissa: (1/v₀(t) − 1/v₀(0))/((1 − e) dρ₀t), "
        "which the paper reads as the constant 1.45. The kinetic equation starts at the Gaussian's "
        "rate and tends to the exact h(e)/(1 − e); hard disks lie above, their free path "
        "being shorter. The bars are one standard error, the spread of the start included; points "
        f"with a larger one than {LARGEST_SLOPE_ERROR:g} are left out.",
        axis("time $t$", "d/U", "log"),
        axis(r"$J / (d\rho_0 t)$"),
        lines,
    )


def approach(cases: Sequence[Case]) -> Data:
    """a2(t) on its way from the Gaussian's 0 to the scaling state's."""
    lines = []
    for case in cases:
        assert case.exact is not None
        e, shown = case.restitution, case.late.times <= APPROACH_ENDS
        t = case.late.times[shown]
        lines.append(series("kinetic equation", t, case.late.a2[shown], None, e))
        lines.append(series("exact limit", t[[0, -1]], [case.exact.a2] * 2, None, e))
        for run in both_runs(case):
            lines.append(series(run.name, case.times, run.a2.value, run.a2.error, e))
        printed = float(sonine.a2(e))
        if np.isfinite(printed):
            lines.append(series("Sonine", t[[0, -1]], [printed] * 2, None, e))
    return figure(
        "Approach to the scaling state",
        "a₂(t) from a Gaussian start, where it is 0: the kinetic equation, also where no particles "
        "were followed, its exact limit, and the printed a₂ where it exists. The bars are one "
        "standard error.",
        axis("time $t$", "d/U", "log"),
        axis("$a_2(t)$"),
        lines,
    )


def vdf_tail(cases: Sequence[Case]) -> Data:
    """F(c) on a logarithmic scale with its exact tail."""
    edges = cases[0].speed_edges
    c = np.linspace(0.02, edges[-1], 150)
    lines = vdf_lines(cases, c, (0.0, float(edges[-1])))
    far = c[c > edges[-1] * 0.5]
    for case in cases:
        exact = case.exact
        assert exact is not None
        tail = np.exp(exact.log_tail_amplitude - exact.tail_rate * far) * far**exact.tail_power
        lines.append(series("exact tail", far, tail, None, case.restitution))
    lines.append(series("Gaussian", c, sonine.vdf(c, 0.0)))
    smallest = min(v for s in lines if s["error"] for v in s["y"] if v)
    return figure(
        "Tail of the velocity distribution",
        "F(c) on a logarithmic scale at the last time: the kinetic equation, the scaling state "
        "that it tends to, and particles averaged over a bin of c with one standard error. The "
        "exact "
        "tail is A c^(1/(1 − e²) − 2) exp(−2c/h), its amplitude A included; it is reached "
        "late for e near 1. The paper's Gaussian falls faster.",
        axis("scaled speed $c = v/v_0$"),
        axis("$F(c)$", "", "log", (smallest / 3, 2.0)),
        lines,
    )


def msd_slope(cases: Sequence[Case], settings: ReportSettings) -> Data:
    """d<r^2>/d ln t over ln t, in units of its exact limit."""
    lines = []
    for case in cases:
        assert case.exact is not None
        e, late = case.restitution, case.late
        limit = case.exact.diffusion_slope * late.scene.mean_free_path**2
        lines.append(series("kinetic equation", late.times, late.msd_slope / limit, None, e))
        middle = math.sqrt(case.times[case.early] * case.times[-1])
        for run in both_runs(case):
            slope = run.msd_slope
            lines.append(series(run.name, middle, slope.value / limit, slope.error / limit, e))
        ends = late.times[[0, -1]]
        walk, printed = (s / limit for s in sonine_slopes(e, settings.number_density))
        lines.append(series("paper's fit", ends, [walk] * 2, None, e))
        if np.isfinite(printed):
            lines.append(series("Sonine", ends, [printed] * 2, None, e))
    first, last = (f(case.late.times[k] for case in cases) for f, k in ((min, 0), (max, -1)))
    lines.append(series("exact limit", [first, last], [1.0, 1.0]))
    return figure(
        "Slope of the mean square displacement",
        "d⟨r²⟩/d ln t over its exact limit 2l²/(κ(1 − ⟨cos χ⟩)): where it is constant, ⟨r²⟩ grows "
        "as ln t. Particles: the mean slope over their last decade, with one standard error. The "
        "paper's random walk (l = 13.5 d, h = 1.45 (1 − e)) and its Sonine result are shown by "
        "their late slopes.",
        axis("time $t$", "d/U", "log"),
        axis(r"$\mathrm{d}\langle r^2\rangle/\mathrm{d}\ln t$ over its limit"),
        lines,
    )


def kurtosis(cases: Sequence[Case]) -> Data:
    """<r^4>/<r^2>^2 over ln t: whether G(R) is the same at all times, and Gaussian in the end."""
    lines = []
    for case in cases:
        e = case.restitution
        lines.append(series("kinetic equation", case.late.times, case.late.kurtosis, None, e))
        for run in both_runs(case):
            moved = run.kurtosis.error > 0
            value, error = run.kurtosis.value[moved], run.kurtosis.error[moved]
            lines.append(series(run.name, case.times[moved], value, error, e))
    ends = [min(case.late.times[0] for case in cases), max(case.late.times[-1] for case in cases)]
    lines.append(series("Gaussian", ends, [2.0, 2.0]))
    lines.append(series("paper's integral", ends, [PAPER_KURTOSIS] * 2))
    return figure(
        "Kurtosis of the displacement",
        "⟨r⁴⟩/⟨r²⟩² over the logarithm of time. The paper takes G(R) as the same at all times: 2 "
        "for its peak form, a Gaussian, and 4 for its integral. The kinetic equation rises to a "
        "maximum and then falls towards 2 like 1/ln t. The bars are one standard error.",
        axis("time $t$", "d/U", "log"),
        axis(r"$\langle r^4\rangle/\langle r^2\rangle^2$"),
        lines,
    )


def tail_exponent(cases: Sequence[Case]) -> Data:
    """Local exponent n(R) of G(R)/R: 2 is a Gaussian, 1 an exponential."""
    lines, at, smallest = [], band_middles(), math.inf
    r = np.linspace(0.3, 6.0, 80)
    for case in cases:
        e = case.restitution
        # Far out the density falls below what the solver was asked for, and its slope is noise.
        known, _ = sure_density(case, r)
        n = case.position.position_tail(known)[0][-1]
        smallest = min([smallest, *n[np.isfinite(n)]])
        lines.append(series("kinetic equation", known, n, None, e))
        lines.append(series("same bands", at, bands_of(case), None, e))
        for run in both_runs(case):
            data = run.tail_exponent
            seen = data.error < LARGEST_EXPONENT_ERROR
            lines.append(series(run.name, at[seen], data.value[seen], data.error[seen], e))
    ends = [0.0, 6.0]
    lines += [series("Gaussian", ends, [2.0] * 2), series("exponential", ends, [1.0] * 2)]
    return figure(
        "How the tail of G(R) falls",
        "Local exponent n(R) of p = G(R)/(2πR) ~ exp(−(R/b)ⁿ) at the last time, "
        "d ln ln(p(0)/p)/d ln R. The crosses are the kinetic equation averaged over the same "
        "bands of R as the particles, whose bars are one standard error (shown where below "
        f"{LARGEST_EXPONENT_ERROR:g}). The smallest n of the equation here is {smallest:.2f}; the "
        "paper reads an exponential, n = 1, from its data.",
        axis("scaled distance $R$", limits=(0.0, 6.0)),
        axis("$n(R)$", limits=(0.5, 2.5)),
        lines,
    )


def density(scan: DensityScan) -> Data:
    """Hard disks over the dilute theory at several densities, and their limit rho0 d^2 -> 0."""
    lines = [series("kinetic equation", [0.0, float(scan.densities[-1])], [1.0, 1.0])]
    x = np.linspace(0.0, float(scan.densities[-1]), 40)
    for name, ratio in scan.ratios.items():
        group = RATIO_NAMES[name]
        lines.append(series("hard disks", scan.densities, ratio.value, ratio.error, group=group))
        limit: Measured = scan.limits[name]
        if np.isfinite(limit.value):
            fit = np.polynomial.Polynomial(scan.fits[name])(x)
            lines.append(series("extrapolation", x, fit, group=group))
            lines.append(series("limit", 0.0, limit.value, limit.error, group=group))
    return figure(
        "Density extrapolation",
        f"Hard disks at e = {scan.restitution:g} over the kinetic equation with l = 1/(2dρ₀), at "
        "the same dρ₀t, against the density: mean free path, thermal speed and ⟨r²⟩. The lines are "
        f"weighted fits of degree {scan.degree}, their values at ρ₀d² = 0 shown with their "
        "standard errors: 1 if the equation is the dilute limit.",
        axis(r"$\rho_0 d^2$"),
        axis("hard disks / kinetic equation"),
        lines,
    )


def traps(scan: TrapScan) -> Data:
    """Share of tracers caught in corners over e."""
    lines, none = [], []
    for density, value, error in zip(
        scan.densities, scan.share.value, scan.share.error, strict=True
    ):
        group, caught = f"ρ₀d² = {density:g}", value > 0
        at = scan.restitutions
        lines.append(series("hard disks", at[caught], value[caught], error[caught], group=group))
        if not np.all(caught):
            none.append(f"{group}: e = " + ", ".join(f"{e:g}" for e in at[~caught]))
    limit = 3 / scan.samples
    missing = f" None was caught at {'; '.join(none)} (95 % limit {limit:.1g})." if none else ""
    return figure(
        "Where traps begin",
        "Share of hard-disk tracers caught in a corner between scatterers, where infinitely many "
        f"bounces follow in a finite time, by {scan.time:.4g} d/U (shorter for the denser system, "
        f"in proportion to the free path), over the restitution e; {scan.samples} tracers each, "
        f"the bars are one standard error over configurations.{missing} The kinetic equation and "
        "Boltzmann-Grad particles have no corners.",
        axis("restitution $e$"),
        axis("share caught", "", "log"),
        lines,
    )
