"""Figures of the displacement, as the plain lists that the JSON file holds and `figures` draws."""

import math
from collections.abc import Callable, Sequence

import numpy as np

from kinetics import sonine
from kinetics.crosscheck.report.case import Array, Case, Measured
from kinetics.crosscheck.report.case_rows import PAPER_KURTOSIS
from kinetics.crosscheck.report.figure_lines import (
    BEYOND_LAST,
    TIME,
    Results,
    ends_of,
    level,
    over_equation,
    particles,
    readable,
    small_error,
    solved,
)
from kinetics.crosscheck.report.figures import Data, axis, figure, series
from kinetics.crosscheck.report.observables import (
    LARGEST_EXPONENT_ERROR,
    band_middles,
    band_ranges,
    bands_of,
    middles,
    printed_msd_slopes,
    sure_density,
)

_RATIO_LIMITS = (0.5, 1.5)


def msdtheory(results: Results) -> Data:
    """K = <r^2> ln(1 + l beta) over (1-e) t (Fig. 4), and the random walk (label msd)."""
    path, density = sonine.FITTED_FREE_PATH, results.number_density

    def scales(e: float) -> tuple[float, float]:
        return 1 - e, math.log1p(path * float(sonine.beta(e, density)))

    walk = ("paper's fit", sonine.msd_random_walk, density)
    drawn = _collapsed(results.cooling, scales, *walk)
    x, y = axis(r"$(1-e)\,t$", "d/U", "log"), axis("$K(t, e)$", "d²")
    beta = float(sonine.beta(0.0, density))
    return figure("msdtheory", x, y, drawn.pop("series"), path=path, beta=beta) | drawn


def soninediffuse(results: Results) -> Data:
    """W = <r^2> (1+e)^2 (1-e^2) (1 + 3 a2/8)^2 (Fig. 9), and the Sonine result (label ad8)."""

    def scales(e: float) -> tuple[float, float]:
        correction = 1 + 3 / 8 * float(sonine.a2(e))
        stretch = (1 - e**2) * correction
        return stretch, (1 + e) ** 2 * stretch * correction

    printed = ("Sonine", sonine.msd_sonine, results.number_density)
    drawn = _collapsed(results.printed, scales, *printed)
    x = axis(r"$(1-e^2)(1+3a_2/8)\,t$", "d/U", "log")
    return figure("soninediffuse", x, axis("$W(t, e)$", "d²"), drawn.pop("series")) | drawn


def _collapsed(
    cases: Sequence[Case],
    scales: Callable[[float], tuple[float, float]],
    source: str,
    printed: Callable[[Array, float, float], Array],
    number_density: float,
) -> Data:
    """<r^2> times a factor over t times a stretch, with which the paper's <r^2> is one curve.

    `scales` gives stretch and factor of a restitution. Equation, its exact late slope, particles;
    and, as the panel of ratios, particles and the printed formula over the equation.
    """
    lines, below, reach = [], [], []
    for case in cases:
        e, late, shown = case.restitution, case.late, solved(case)
        stretch, factor = scales(e)
        t, msd = late.times[shown], late.msd[shown]
        asymptote = late.msd[-1] + case.late_msd_slope * np.log(t / late.times[-1])
        above = asymptote > 0
        points = [run.msd for run in case.runs]
        lines.append(series("kinetic equation", stretch * t, factor * msd, None, e))
        lines.append(series("exact slope", stretch * t[above], factor * asymptote[above], None, e))
        lines += particles(case, stretch * case.times, [point * factor for point in points])
        ratio = printed(t, e, number_density) / msd
        seen = (ratio > _RATIO_LIMITS[0]) & (ratio < _RATIO_LIMITS[1])
        below.append(series(source, stretch * t[seen], ratio[seen], None, e))
        below += over_equation(case, stretch * case.times, points, case.kinetic.msd)
        reach += [case.times[0] * stretch, case.times[-1] * stretch * BEYOND_LAST]
    x = np.geomspace(min(reach), max(reach), 80)
    e = cases[0].restitution
    stretch, factor = scales(e)
    lines.append(series(source, x, factor * printed(x / stretch, e, number_density)))
    below.insert(0, level("zero", x, 1.0))
    y = axis("over the equation", limits=_RATIO_LIMITS)
    return {"series": lines, "ratio": {"y": y, "series": below}}


def msd_ratio(results: Results) -> Data:
    """<r^2> of hard disks over the dilute equation, and over the equation at their density."""
    lines, below = [], []
    for case in results.dense_cases:
        e, times = case.restitution, case.times
        assert case.dense is not None
        lines.append(
            series("corrected equation", times, case.dense.msd / case.kinetic.msd, None, e)
        )
        points = particles(
            case, times, [run.msd / case.kinetic.msd for run in case.runs], small_error
        )
        lines.append(points[1])
        below.append(
            particles(case, times, [run.msd / case.dense.msd for run in case.runs], small_error)[1]
        )
    ends = ends_of([case.times for case in results.dense_cases])
    lines.insert(0, level("dilute equation", ends, 1.0))
    below.insert(0, level("zero", ends, 1.0))
    y = axis(r"$\langle r^2\rangle$ / dilute equation")
    made = figure("msd-ratio", TIME, y, lines, settled=results.settled, n=results.number_density)
    return made | {"ratio": {"y": axis("/ corrected"), "series": below}}


def inelasticposi(results: Results) -> Data:
    """G(R) at the last time (Fig. 5), with the paper's forms and their constants."""
    lines = []
    r = np.linspace(0.02, results.cases[0].position_edges[-1], 150)
    for case in results.cases:
        g = case.position.scaled_position_density(r)[-1]
        known = np.where(g > 0, g, np.nan)
        lines.append(series("kinetic equation", r, known, None, case.restitution))
        points = [run.position for run in case.runs]
        lines += particles(case, middles(case.position_edges), points, readable)
    if results.is_papers_law:
        lines += [
            series("paper, peak", r, sonine.position_peak(r)),
            series("paper, tail", r[r > 1], sonine.position_tail(r[r > 1])),
            series("paper's integral", r, sonine.position_integral(r)),
        ]
    else:
        lines.append(series("Gaussian", r, _gaussian_position(r, results.dimension)))
    x, y = axis("scaled distance $R$"), axis("$G(R)$", "", "log", (1e-5, 2.0))
    return figure("inelasticposi", x, y, lines, **results.words) | {"panels": True}


def _gaussian_position(r: Array, dimension: int) -> Array:
    """G(R) of a Gaussian displacement: a density over R with <R^2> = 1."""
    if dimension == 2:
        return np.asarray(2 * r * np.exp(-(r**2)))
    return np.asarray(4 * math.pi * r**2 * (1.5 / math.pi) ** 1.5 * np.exp(-1.5 * r**2))


def msd_slope(results: Results) -> Data:
    """d<r^2>/d ln t over ln t, in units of its exact limit."""
    lines = []
    for case in results.cooling:
        e, late, limit = case.restitution, case.late, case.late_msd_slope
        lines.append(series("kinetic equation", late.times, late.msd_slope / limit, None, e))
        decade = case.times[[case.early, -1]]
        points = [
            Measured(*np.atleast_1d(m.value, m.error)) / limit
            for m in (run.msd_slope for run in case.runs)
        ]
        middle = np.array([math.sqrt(decade[0] * decade[1])])
        lines += particles(case, middle, points, ranges=decade[None])
        if not results.is_papers_law:
            continue
        walk, printed = printed_msd_slopes(e, results.number_density)
        lines.append(level("paper's fit", late.times, walk / limit, e))
        if np.isfinite(printed):
            lines.append(level("Sonine", late.times, printed / limit, e))
    lines.append(level("exact limit", ends_of([c.late.times for c in results.cooling]), 1.0))
    y = axis(r"$\mathrm{d}\langle r^2\rangle/\mathrm{d}\ln t$ over its limit")
    return figure("msd-slope", TIME, y, lines, **results.words)


def kurtosis(results: Results) -> Data:
    """<r^4>/<r^2>^2 over ln t: whether G(R) is the same at all times, and Gaussian in the end."""
    lines = []
    for case in results.cases:
        late = case.late
        lines.append(series("kinetic equation", late.times, late.kurtosis, None, case.restitution))
        points = [run.kurtosis for run in case.runs]
        lines += particles(case, case.times, points, lambda m: m.error > 0)
    ends = ends_of([case.late.times for case in results.cases])
    lines.append(level("Gaussian", ends, results.gaussian_kurtosis))
    if results.is_papers_law:
        lines.append(level("paper's integral", ends, PAPER_KURTOSIS))
    y = axis(r"$\langle r^4\rangle/\langle r^2\rangle^2$")
    return figure("kurtosis", TIME, y, lines, **results.words)


def tail_exponent(results: Results) -> Data:
    """Local exponent n(R) of G(R)/R: 2 is a Gaussian, 1 an exponential."""
    lines, at, smallest = [], band_middles(results.dimension), math.inf
    for case in results.cases:
        # Far out the density falls below what the solver was asked for, and its slope is noise.
        known, _ = sure_density(case, np.linspace(0.3, 6.0, 80))
        n = case.position.position_tail(known)[0][-1]
        smallest = min([smallest, *n[np.isfinite(n)]])
        lines.append(series("kinetic equation", known, n, None, case.restitution))
        lines.append(series("same bands", at, bands_of(case), None, case.restitution))
        points = [run.tail_exponent for run in case.runs]
        ranges = band_ranges(results.dimension)
        lines += particles(case, at, points, lambda n: n.error < LARGEST_EXPONENT_ERROR, ranges)
    ends = [0.0, 6.0]
    lines += [level("Gaussian", ends, 2.0), level("exponential", ends, 1.0)]
    x, y = axis("scaled distance $R$", limits=(0.0, 6.0)), axis("$n(R)$", limits=(0.5, 2.5))
    made = figure(
        "tail-exponent", x, y, lines, largest=LARGEST_EXPONENT_ERROR, smallest=smallest,
        **results.words,
    )  # fmt: skip
    return made | {"panels": True}
