"""Figures of the velocity, as the plain lists that the JSON file holds and `figures` draws."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from kinetics import sonine
from kinetics.crosscheck.report.case import Array, Case, Measured, ParticleRun
from kinetics.crosscheck.report.figure_lines import (
    BEYOND_LAST,
    LARGEST_RELATIVE_ERROR,
    RATIO,
    RESTITUTION,
    TIME,
    Results,
    ends_of,
    exact_states,
    level,
    over_equation,
    over_restitution,
    particles,
    readable,
    restitutions,
    solved,
)
from kinetics.crosscheck.report.figures import Data, axis, figure, series
from kinetics.crosscheck.report.observables import (
    cooling_rate_between,
    gaussian_vdf,
    last_vdf,
    middles,
)

LARGEST_SLOPE_ERROR = 0.2
"""Standard error of (1/v0 - 1/v0(0))/((1-e) d rho0 t) above which a point is left out."""
APPROACH_ENDS = 1e5
"""Last time, in d/U, of the figure of the approach to the scaling state."""


def _slowing(case: Case, speed: Array, scale: Array | float) -> Array:
    """(1/v0 - 1/v0(0)) over a scale: the paper's J for 1 - e. The start is Gaussian."""
    return (1 / speed - 1 / math.sqrt(case.dimension)) / scale


def _slowing_of(case: Case, scale: Array | float) -> list[Measured]:
    """The same of each run."""
    points = []
    for run in case.runs:
        v, dv = run.thermal_speed.value, run.thermal_speed.error
        points.append(Measured(_slowing(case, v, scale), dv / v**2 / scale))
    return points


def v0re(results: Results) -> Data:
    """J = (1/v0(t) - 1/v0(0))/(1-e) over t (Fig. 2) and its line; both over the equation."""
    lines, below = [], []
    slope = float(sonine.beta(0.0, results.number_density))
    for case in results.cooling:
        e, shown = case.restitution, solved(case)
        times, j = case.late.times[shown], _slowing(case, case.late.thermal_speed[shown], 1 - e)
        points = _slowing_of(case, 1 - e)
        lines.append(series("kinetic equation", times, j, None, e))
        lines += particles(case, case.times, points, readable)
        below.append(series("paper's fit", times, slope * times / j, None, e))
        expected = _slowing(case, case.kinetic.thermal_speed, 1 - e)
        below += over_equation(case, case.times, points, expected)
    ends = ends_of([case.times for case in results.cooling]) * [1.0, BEYOND_LAST]
    lines.append(series("paper's fit", ends, slope * ends))
    below.insert(0, level("zero", ends, 1.0))
    y = axis("$J(t, e)$", "1/U", "log")
    made = figure("v0re", TIME, y, lines, slope=slope, largest=LARGEST_RELATIVE_ERROR)
    return made | {"ratio": {"y": RATIO, "series": below}}


def inverse_speed(results: Results) -> Data:
    """The paper's J over its abscissa d rho0 t, which shows what the logarithms of v0re hide.

    Rough scatterers cool at e = 1 too: of them 1/v0 is not divided by 1 - e.
    """
    lines = []
    for case in results.cooling:
        e, times = case.restitution, case.times
        inelasticity = float(_inelasticity(results, e))
        scale = inelasticity * results.settings.half_rate * times
        j = _slowing(case, case.kinetic.thermal_speed, scale)
        lines.append(series("kinetic equation", times, j, None, e))
        limit = case.scaling_state[0].cooling_rate / inelasticity
        lines.append(level("exact limit", times, limit, e))
        lines += particles(
            case, times, _slowing_of(case, scale), lambda j: j.error < LARGEST_SLOPE_ERROR
        )
    y = axis(r"$J / (d\rho_0 t)$")
    if results.is_papers_law:
        ends = ends_of([case.times for case in results.cooling])
        lines.append(level("paper's fit", ends, sonine.FITTED_COOLING_FACTOR))
    else:
        y = axis(r"$2l\,(1/v_0(t) - 1/v_0(0))/t$" + _over(results))
    made = figure("inverse-speed", TIME, y, lines, largest=LARGEST_SLOPE_ERROR, **results.words)
    return made | {"panels": True, "spans": results.spans}


def _inelasticity(results: Results, e: Any) -> Any:
    """1 - e of smooth scatterers, which cool in proportion to it, and 1 of rough ones."""
    return 1 - e if results.is_smooth else np.ones_like(e)


def _over(results: Results) -> str:
    """What the label of an axis says of `_inelasticity`."""
    return "$/(1-e)$" if results.is_smooth else ""


def hetomu2(results: Results) -> Data:
    """h(e) and M2/2 over e (Fig. 3), and all of it over the exact h."""
    made = _cooling_rates(results, "hetomu2", "$h(e)$", np.ones_like)
    law = results.settings.tangential_restitution, results.dimension
    exact = np.array([state.cooling_rate for state in exact_states(*law)])
    below = [_over_exact(line, exact) for line in made["series"]]
    return made | {"ratio": {"y": axis("over exact"), "series": below}}


def _over_exact(line: Data, exact: Array) -> Data:
    """A line over e divided by the exact values at `restitutions()`."""
    x, y = (np.array(line[name], dtype=float) for name in "xy")
    # h/(1 - e) is smooth up to e = 1, h itself vanishes there.
    scale = np.interp(x, restitutions(), exact / (1 - restitutions())) * (1 - x)
    error = None if line["error"] is None else np.array(line["error"], dtype=float) / scale
    return series(line["source"], x, y / scale, error, line["restitution"])


def cooling_rate(results: Results) -> Data:
    """h(e)/(1-e) from e = 0 to 1: every method, and both printed formulas (hetomu2, hsimu).

    Of rough scatterers h(e) itself.
    """
    label = "$h(e)$" + _over(results) if not results.is_papers_law else "$h(e)/(1-e)$"

    def scale(e: Any) -> Any:
        return _inelasticity(results, e)

    return _cooling_rates(results, "cooling-rate", label, scale)


def _cooling_rates(results: Results, name: str, label: str, scale: Callable[[Any], Any]) -> Data:
    e = restitutions()
    printed: dict[str, Callable[[Any], Any]] = {}
    if results.is_papers_law:
        printed = {"Sonine": sonine.cooling_rate, "paper's fit": sonine.cooling_rate_fitted}

    def same_times(case: Case) -> float:
        speed, half_rate = case.kinetic.thermal_speed, results.settings.half_rate
        rate = cooling_rate_between(case.times, speed, case.early, half_rate)
        return rate / float(scale(case.restitution))

    lines = over_restitution(
        results,
        lambda e, source: source.cooling_rate / scale(e),
        same_times,
        {source: h(e) / scale(e) for source, h in printed.items()},
    )
    return figure(name, RESTITUTION, axis(label), lines, **results.words)


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
    printed = {}
    if results.is_papers_law:
        printed = {
            "Sonine": of(e, sonine.a2(e)),
            "Sonine, unstable root": of(e, sonine.a2(e, "unstable")),
        }

    def same_times(case: Case) -> float:
        return float(of(case.restitution, float(case.kinetic.a2[-1])))

    lines = over_restitution(results, from_a2, same_times, printed)
    zero = level("zero", [0.0, 1.0], 0.0)
    return figure(name, RESTITUTION, axis(label), [zero, *lines], **results.words)


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
        if results.is_papers_law and np.isfinite(printed):
            lines.append(level("Sonine", t, printed, e))
    return figure("approach", TIME, axis("$a_2(t)$"), lines, **results.words)


def scalev(results: Results) -> Data:
    """F(c) at the last time (Fig. 6), and the Gaussian that the paper fits."""
    c = np.linspace(0.01, 2.5, 150)
    lines = [*_vdf_lines(results, c), series("Gaussian", c, gaussian_vdf(c, results.dimension))]
    x = axis("scaled speed $c = v/v_0$", limits=(0.0, 2.5))
    return figure("scalev", x, axis("$F(c)$"), lines, **results.words) | {"panels": True}


def vdf_tail(results: Results) -> Data:
    """F(c) on a logarithmic scale with its exact tail."""
    last = results.cases[0].speed_edges[-1]
    c = np.linspace(0.02, last, 150)
    lines = _vdf_lines(results, c)
    far = c[c > last * 0.5]
    for case in results.cooling:
        exact, _ = case.scaling_state
        if not np.isfinite(exact.tail_power):  # no power times an exponential
            continue
        tail = np.exp(exact.log_tail_amplitude - exact.tail_rate * far) * far**exact.tail_power
        lines.append(series("exact tail", far, tail, None, case.restitution))
    lines.append(series("Gaussian", c, gaussian_vdf(c, results.dimension)))
    smallest = min(v for s in lines if s["error"] for v in s["y"] if v)
    x, y = axis("scaled speed $c = v/v_0$"), axis("$F(c)$", "", "log", (smallest / 3, 2.0))
    return figure("vdf-tail", x, y, lines, **results.words) | {"panels": True}


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
