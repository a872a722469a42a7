"""Every figure of a report, as the plain lists that the JSON file holds and `figures` draws."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from kinetics import sonine
from kinetics.crosscheck.report import scan_figures
from kinetics.crosscheck.report.case import (
    Array,
    Case,
    Mask,
    Measured,
    ParticleRun,
    Scans,
)
from kinetics.crosscheck.report.case_rows import PAPER_KURTOSIS
from kinetics.crosscheck.report.figure_lines import (
    LARGEST_RELATIVE_ERROR,
    figure,
    level,
    over_restitution,
    particles,
    readable,
    restitutions,
)
from kinetics.crosscheck.report.figures import Data, axis, series
from kinetics.crosscheck.report.observables import (
    LARGEST_EXPONENT_ERROR,
    band_middles,
    bands_of,
    last_vdf,
    middles,
    printed_msd_slopes,
    sure_density,
)
from kinetics.crosscheck.report.settings import ReportSettings

if TYPE_CHECKING:
    pass

LARGEST_SLOPE_ERROR = 0.2
"""Standard error of (1/v0 - 1/v0(0))/((1-e) d rho0 t) above which a point is left out."""
BEYOND_LAST = 10.0
"""Lines of the equation go on to so many times the last time of the particles."""
APPROACH_ENDS = 1e5
"""Last time, in d/U, of the figure of the approach to the scaling state."""
TIME = axis("time $t$", "d/U", "log")
RESTITUTION = axis("restitution $e$", limits=(0.0, 1.0))


@dataclass(frozen=True)
class Results:
    """What the figures of one report draw."""

    cases: Sequence[Case]
    number_density: float

    @property
    def cooling(self) -> list[Case]:
        """The cases that cool, e < 1."""
        return [case for case in self.cases if case.exact is not None]

    @property
    def printed(self) -> list[Case]:
        """The cooling cases at which the printed a2 is real."""
        return [case for case in self.cooling if np.isfinite(sonine.a2(case.restitution))]


def all_figures(
    cases: Sequence[Case], scans: Scans | None, settings: ReportSettings
) -> dict[str, Data]:
    """The data of every figure that these cases allow, by figure name; the paper's come first.

    If no case cools, only those that the elastic gas has; Fig. 9 only where the printed a2 is real.
    """
    results = Results(cases, settings.number_density)
    figures = {
        make.__name__.replace("_", "-"): make(results)
        for make in _PAPER + _OTHERS
        if make in (inelasticposi, kurtosis, tail_exponent)
        or (results.printed if make is soninediffuse else results.cooling)
    }
    if scans is not None:
        figures["density"] = scan_figures.density(scans.density)
        figures["traps"] = scan_figures.traps(scans.traps)
    return figures


def _ends(times: Sequence[Array]) -> Array:
    """The first and the last of several ranges of times."""
    return np.array([min(t[0] for t in times), max(t[-1] for t in times)])


def _solved(case: Case) -> Mask:
    """The late times that a figure shows."""
    return np.asarray(case.late.times <= BEYOND_LAST * case.times[-1])


# -- figures of the velocity ----------------------------------------------------------------------


def _slowing(speed: Array, scale: Array | float) -> Array:
    """(1/v0 - 1/v0(0)) over a scale: the paper's J for 1 - e."""
    return (1 / speed - 1 / sonine.THERMAL_SPEED_START) / scale


def _slowing_of(run: ParticleRun, scale: Array | float) -> Measured:
    v, dv = run.thermal_speed.value, run.thermal_speed.error
    return Measured(_slowing(v, scale), dv / v**2 / scale)


def v0re(results: Results) -> Data:
    """J = (1/v0(t) - 1/v0(0))/(1-e) over t (Fig. 2), and its straight line."""
    lines = []
    for case in results.cooling:
        e, shown = case.restitution, _solved(case)
        j = _slowing(case.late.thermal_speed[shown], 1 - e)
        lines.append(series("kinetic equation", case.late.times[shown], j, None, e))
        lines += particles(
            case, case.times, [_slowing_of(run, 1 - e) for run in case.runs], readable
        )
    ends = _ends([case.times for case in results.cooling]) * [1.0, BEYOND_LAST]
    slope = float(sonine.beta(0.0, results.number_density))
    lines.append(series("paper's fit", ends, slope * ends))
    y = axis("$J(t, e)$", "1/U", "log")
    return figure("v0re", TIME, y, lines, slope=slope, largest=LARGEST_RELATIVE_ERROR)


def inverse_speed(results: Results) -> Data:
    """The paper's J over its abscissa d rho0 t, which shows what the logarithms of v0re hide."""
    lines = []
    for case in results.cooling:
        e, times = case.restitution, case.times
        scale = (1 - e) * results.number_density * times
        j = _slowing(case.kinetic.thermal_speed, scale)
        lines.append(series("kinetic equation", times, j, None, e))
        limit = case.scaling_state[0].cooling_rate / (1 - e)
        lines.append(level("exact limit", times, limit, e))
        points = [_slowing_of(run, scale) for run in case.runs]
        lines += particles(case, times, points, lambda j: j.error < LARGEST_SLOPE_ERROR)
    ends = _ends([case.times for case in results.cooling])
    lines.append(level("paper's fit", ends, sonine.FITTED_COOLING_FACTOR))
    y = axis(r"$J / (d\rho_0 t)$")
    return figure("inverse-speed", TIME, y, lines, largest=LARGEST_SLOPE_ERROR)


def hetomu2(results: Results) -> Data:
    """h(e) and M2/2 over e (Fig. 3)."""
    return _cooling_rates(results, "hetomu2", "$h(e)$", np.ones_like)


def cooling_rate(results: Results) -> Data:
    """h(e)/(1-e) from e = 0 to 1: every method, and both printed formulas (hetomu2, hsimu)."""
    return _cooling_rates(results, "cooling-rate", "$h(e)/(1-e)$", lambda e: 1 - e)


def _cooling_rates(results: Results, name: str, label: str, scale: Callable[[Any], Any]) -> Data:
    e = restitutions()
    printed = {"Sonine": sonine.cooling_rate, "paper's fit": sonine.cooling_rate_fitted}
    lines = over_restitution(
        results.cooling,
        lambda e, source: source.cooling_rate / scale(e),
        {source: h(e) / scale(e) for source, h in printed.items()},
    )
    return figure(name, RESTITUTION, axis(label), lines)


def sign(results: Results) -> Data:
    """H(e) (Fig. 8): both printed roots, and the true a2 put in."""

    def growth(e: Any, a2: Any) -> Any:
        return sonine.stability(e, coefficient=a2)

    return _sonine_roots(results, "sign", "$H(e)$", growth, 3.0)


def a2(results: Results) -> Data:
    """Second Sonine coefficient: exact, solver, printed roots (sonine11), particles at the end."""
    return _sonine_roots(results, "a2", "$a_2$", lambda _, a2: a2, 1.0)


def _sonine_roots(
    results: Results, name: str, label: str, of: Callable[[Any, Any], Any], slope: float
) -> Data:
    """A quantity linear in a2 (`slope`), for every a2: exact, solved, measured, printed."""

    def from_a2(e: float, source: Any) -> Any:
        if isinstance(source, ParticleRun):
            return Measured(of(e, source.a2.value[-1]), slope * source.a2.error[-1])
        return float(of(e, source.a2))

    e = restitutions()
    printed = {
        "Sonine": of(e, sonine.a2(e)),
        "Sonine, unstable root": of(e, sonine.a2(e, "unstable")),
    }
    lines = over_restitution(results.cooling, from_a2, printed)
    zero = level("zero", [0.0, 1.0], 0.0)
    return figure(name, RESTITUTION, axis(label), [zero, *lines])


def approach(results: Results) -> Data:
    """a2(t) on its way from the Gaussian's 0 to the scaling state's."""
    lines = []
    for case in results.cooling:
        e, shown = case.restitution, case.late.times <= APPROACH_ENDS
        t = case.late.times[shown]
        lines.append(series("kinetic equation", t, case.late.a2[shown], None, e))
        lines.append(level("exact limit", t, case.scaling_state[0].a2, e))
        lines += particles(case, case.times, [run.a2 for run in case.runs])
        printed = float(sonine.a2(e))
        if np.isfinite(printed):
            lines.append(level("Sonine", t, printed, e))
    return figure("approach", TIME, axis("$a_2(t)$"), lines)


def scalev(results: Results) -> Data:
    """F(c) at the last time (Fig. 6), and the Gaussian that the paper fits."""
    c = np.linspace(0.01, 2.5, 150)
    lines = [*_vdf_lines(results, c), series("Gaussian", c, sonine.vdf(c, 0.0))]
    x = axis("scaled speed $c = v/v_0$", limits=(0.0, 2.5))
    return figure("scalev", x, axis("$F(c)$"), lines)


def vdf_tail(results: Results) -> Data:
    """F(c) on a logarithmic scale with its exact tail."""
    last = results.cases[0].speed_edges[-1]
    c = np.linspace(0.02, last, 150)
    lines = _vdf_lines(results, c)
    far = c[c > last * 0.5]
    for case in results.cooling:
        exact, _ = case.scaling_state
        tail = np.exp(exact.log_tail_amplitude - exact.tail_rate * far) * far**exact.tail_power
        lines.append(series("exact tail", far, tail, None, case.restitution))
    lines.append(series("Gaussian", c, sonine.vdf(c, 0.0)))
    smallest = min(v for s in lines if s["error"] for v in s["y"] if v)
    x, y = axis("scaled speed $c = v/v_0$"), axis("$F(c)$", "", "log", (smallest / 3, 2.0))
    return figure("vdf-tail", x, y, lines)


def _vdf_lines(results: Results, c: Array) -> list[Data]:
    """F(c) of every method: solution and scaling state at c, particles in bins up to the last c."""
    lines = []
    for case in results.cooling:
        e, at = case.restitution, middles(case.speed_edges)
        lines.append(series("kinetic equation", c, last_vdf(case.kinetic)(c), None, e))
        lines.append(series("scaling state", c, case.scaling_state[1].vdf(c), None, e))
        inside = slice(int(np.searchsorted(at, c[-1], side="right")))
        lines += particles(case, at[inside], [run.vdf[inside] for run in case.runs], readable)
    return lines


# -- figures of the displacement ------------------------------------------------------------------


def msdtheory(results: Results) -> Data:
    """K = <r^2> ln(1 + l beta) over (1-e) t (Fig. 4), and the random walk (label msd)."""
    path, density = sonine.FITTED_FREE_PATH, results.number_density

    def scales(e: float) -> tuple[float, float]:
        return 1 - e, math.log1p(path * float(sonine.beta(e, density)))

    walk = ("paper's fit", sonine.msd_random_walk, density)
    lines = _collapsed(results.cooling, scales, *walk)
    x, y = axis(r"$(1-e)\,t$", "d/U", "log"), axis("$K(t, e)$", "d²")
    return figure("msdtheory", x, y, lines, path=path, beta=float(sonine.beta(0.0, density)))


def soninediffuse(results: Results) -> Data:
    """W = <r^2> (1+e)^2 (1-e^2) (1 + 3 a2/8)^2 (Fig. 9), and the Sonine result (label ad8)."""

    def scales(e: float) -> tuple[float, float]:
        correction = 1 + 3 / 8 * float(sonine.a2(e))
        stretch = (1 - e**2) * correction
        return stretch, (1 + e) ** 2 * stretch * correction

    printed = ("Sonine", sonine.msd_sonine, results.number_density)
    lines = _collapsed(results.printed, scales, *printed)
    x = axis(r"$(1-e^2)(1+3a_2/8)\,t$", "d/U", "log")
    return figure("soninediffuse", x, axis("$W(t, e)$", "d²"), lines)


def _collapsed(
    cases: Sequence[Case],
    scales: Callable[[float], tuple[float, float]],
    source: str,
    printed: Callable[[Array, float, float], Array],
    number_density: float,
) -> list[Data]:
    """<r^2> times a factor over t times a stretch, with which the paper's <r^2> is one curve.

    `scales` gives stretch and factor of a restitution. Equation, its exact late slope, particles.
    """
    lines, reach = [], []
    for case in cases:
        e, late, shown = case.restitution, case.late, _solved(case)
        stretch, factor = scales(e)
        t = late.times[shown]
        asymptote = late.msd[-1] + case.late_msd_slope * np.log(t / late.times[-1])
        above = asymptote > 0
        lines.append(series("kinetic equation", stretch * t, factor * late.msd[shown], None, e))
        lines.append(series("exact slope", stretch * t[above], factor * asymptote[above], None, e))
        lines += particles(case, stretch * case.times, [run.msd * factor for run in case.runs])
        reach += [case.times[0] * stretch, case.times[-1] * stretch * BEYOND_LAST]
    x = np.geomspace(min(reach), max(reach), 80)
    e = cases[0].restitution
    stretch, factor = scales(e)
    return [*lines, series(source, x, factor * printed(x / stretch, e, number_density))]


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
    lines += [
        series("paper, peak", r, sonine.position_peak(r)),
        series("paper, tail", r[r > 1], sonine.position_tail(r[r > 1])),
        series("paper's integral", r, sonine.position_integral(r)),
    ]
    x, y = axis("scaled distance $R$"), axis("$G(R)$", "", "log", (1e-5, 2.0))
    return figure("inelasticposi", x, y, lines)


def msd_slope(results: Results) -> Data:
    """d<r^2>/d ln t over ln t, in units of its exact limit."""
    lines = []
    for case in results.cooling:
        e, late, limit = case.restitution, case.late, case.late_msd_slope
        lines.append(series("kinetic equation", late.times, late.msd_slope / limit, None, e))
        middle = np.array(math.sqrt(case.times[case.early] * case.times[-1]))
        lines += particles(case, middle, [run.msd_slope / limit for run in case.runs])
        walk, printed = printed_msd_slopes(e, results.number_density)
        lines.append(level("paper's fit", late.times, walk / limit, e))
        if np.isfinite(printed):
            lines.append(level("Sonine", late.times, printed / limit, e))
    lines.append(level("exact limit", _ends([c.late.times for c in results.cooling]), 1.0))
    y = axis(r"$\mathrm{d}\langle r^2\rangle/\mathrm{d}\ln t$ over its limit")
    return figure("msd-slope", TIME, y, lines)


def kurtosis(results: Results) -> Data:
    """<r^4>/<r^2>^2 over ln t: whether G(R) is the same at all times, and Gaussian in the end."""
    lines = []
    for case in results.cases:
        late = case.late
        lines.append(series("kinetic equation", late.times, late.kurtosis, None, case.restitution))
        points = [run.kurtosis for run in case.runs]
        lines += particles(case, case.times, points, lambda m: m.error > 0)
    ends = _ends([case.late.times for case in results.cases])
    lines += [level("Gaussian", ends, 2.0), level("paper's integral", ends, PAPER_KURTOSIS)]
    return figure("kurtosis", TIME, axis(r"$\langle r^4\rangle/\langle r^2\rangle^2$"), lines)


def tail_exponent(results: Results) -> Data:
    """Local exponent n(R) of G(R)/R: 2 is a Gaussian, 1 an exponential."""
    lines, at, smallest = [], band_middles(), math.inf
    for case in results.cases:
        # Far out the density falls below what the solver was asked for, and its slope is noise.
        known, _ = sure_density(case, np.linspace(0.3, 6.0, 80))
        n = case.position.position_tail(known)[0][-1]
        smallest = min([smallest, *n[np.isfinite(n)]])
        lines.append(series("kinetic equation", known, n, None, case.restitution))
        lines.append(series("same bands", at, bands_of(case), None, case.restitution))
        points = [run.tail_exponent for run in case.runs]
        lines += particles(case, at, points, lambda n: n.error < LARGEST_EXPONENT_ERROR)
    ends = [0.0, 6.0]
    lines += [level("Gaussian", ends, 2.0), level("exponential", ends, 1.0)]
    x, y = axis("scaled distance $R$", limits=(0.0, 6.0)), axis("$n(R)$", limits=(0.5, 2.5))
    return figure("tail-exponent", x, y, lines, largest=LARGEST_EXPONENT_ERROR, smallest=smallest)


_PAPER: tuple[Callable[[Results], Data], ...] = (
    v0re, hetomu2, msdtheory, inelasticposi, scalev, sign, soninediffuse
)  # fmt: skip
_OTHERS: tuple[Callable[[Results], Data], ...] = (
    cooling_rate, inverse_speed, a2, approach, vdf_tail, msd_slope, kurtosis, tail_exponent
)  # fmt: skip
PAPER_FIGURES = tuple(make.__name__ for make in _PAPER)
"""Names of the figures that are the paper's, by its labels."""
