"""Figures of the velocity: thermal speed, cooling rate, a2 and F(c), beside the exact theory."""

from collections.abc import Callable
from typing import Any

import numpy as np

from kinetics import sonine
from kinetics.crosscheck.report.case import Array, Measured, ParticleRun
from kinetics.crosscheck.report.figure_lines import (
    LARGEST_RELATIVE_ERROR,
    Results,
    figure,
    level,
    over_restitution,
    particles,
    readable,
    restitutions,
)
from kinetics.crosscheck.report.figures import Data, axis, series
from kinetics.crosscheck.report.observables import last_vdf, middles

BEYOND_LAST = 10.0
"""Lines of the equation go on to so many times the last time of the particles."""
LARGEST_SLOPE_ERROR = 0.2
"""Standard error of (1/v0 - 1/v0(0))/((1-e) d rho0 t) above which a point is left out."""
APPROACH_ENDS = 1e5
"""Last time, in d/U, of the figure of the approach to the scaling state."""
TIME = axis("time $t$", "d/U", "log")
RESTITUTION = axis("restitution $e$", limits=(0.0, 1.0))


def _slowing(speed: Array, scale: Array | float) -> Array:
    """(1/v0 - 1/v0(0)) over a scale: the paper's J for 1 - e."""
    return (1 / speed - 1 / sonine.THERMAL_SPEED_START) / scale


def _slowing_of(run: ParticleRun, scale: Array | float) -> Measured:
    v, dv = run.thermal_speed.value, run.thermal_speed.error
    return Measured(_slowing(v, scale), dv / v**2 / scale)


def v0re(results: Results) -> Data:
    """J = (1/v0(t) - 1/v0(0))/(1-e) over t (Fig. 2), and its straight line."""
    lines, cases = [], results.cooling
    for case in cases:
        e = case.restitution
        shown = case.late.times <= BEYOND_LAST * case.times[-1]
        j = _slowing(case.late.thermal_speed[shown], 1 - e)
        lines.append(series("kinetic equation", case.late.times[shown], j, None, e))
        points = [_slowing_of(run, 1 - e) for run in case.runs]
        lines += particles(case, case.times, points, readable)
    ends = np.array(
        [min(case.times[0] for case in cases), max(case.times[-1] for case in cases) * BEYOND_LAST]
    )
    slope = float(sonine.beta(0.0, results.settings.number_density))
    lines.append(series("paper's fit", ends, slope * ends))
    y = axis("$J(t, e)$", "1/U", "log")
    return figure("v0re", TIME, y, lines, slope=slope, largest=LARGEST_RELATIVE_ERROR)


def inverse_speed(results: Results) -> Data:
    """The paper's J over its abscissa d rho0 t, which shows what the logarithms of v0re hide."""
    lines, cases = [], results.cooling
    for case in cases:
        e = case.restitution
        scale = (1 - e) * results.settings.number_density * case.times
        j = _slowing(case.kinetic.thermal_speed, scale)
        lines.append(series("kinetic equation", case.times, j, None, e))
        limit = case.scaling_state[0].cooling_rate / (1 - e)
        lines.append(level("exact limit", case.times, limit, e))
        points = [_slowing_of(run, scale) for run in case.runs]
        lines += particles(case, case.times, points, lambda j: j.error < LARGEST_SLOPE_ERROR)
    ends = [min(case.times[0] for case in cases), max(case.times[-1] for case in cases)]
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
    lines = [
        *over_restitution(
            results.cooling,
            lambda e, state: state.cooling_rate / scale(e),
            lambda e, run: run.cooling_rate / scale(e),
        ),
        series("Sonine", e, sonine.cooling_rate(e) / scale(e)),
        series("paper's fit", e, sonine.cooling_rate_fitted(e) / scale(e)),
    ]
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
    results: Results,
    name: str,
    label: str,
    of: Callable[[Any, Any], Any],
    slope: float,
) -> Data:
    """A quantity linear in a2 (`slope`), for every a2: exact, solved, measured, printed."""
    e = restitutions()
    lines = [
        level("zero", [0.0, 1.0], 0.0),
        *over_restitution(
            results.cooling,
            lambda e, state: float(of(e, state.a2)),
            lambda e, run: Measured(of(e, run.a2.value[-1]), slope * run.a2.error[-1]),
        ),
        series("Sonine", e, of(e, sonine.a2(e))),
        series("Sonine, unstable root", e, of(e, sonine.a2(e, "unstable"))),
    ]
    return figure(name, RESTITUTION, axis(label), lines)


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
    edges = results.cases[0].speed_edges
    c = np.linspace(0.02, edges[-1], 150)
    lines = _vdf_lines(results, c)
    far = c[c > edges[-1] * 0.5]
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
        inside = at <= c[-1]
        lines += particles(case, at[inside], [run.vdf[inside] for run in case.runs], readable)
    return lines
