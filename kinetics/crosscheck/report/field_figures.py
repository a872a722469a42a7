"""Figures of the report in a uniform field, as the plain lists that the JSON file holds.

The first are of the dilute limit, those whose names begin with "density" of hard disks.
"""

import numpy as np
from numpy.typing import ArrayLike

from kinetics.crosscheck.report.case import Array, Measured
from kinetics.crosscheck.report.field_density import DensityCase
from kinetics.crosscheck.report.field_limits import dispersion_near_elastic, drift_near_elastic
from kinetics.crosscheck.report.field_runs import ApproachCase, SteadyCase, SteadyLine
from kinetics.crosscheck.report.field_settings import SCATTERERS
from kinetics.crosscheck.report.figures import Data, axis, figure, series
from kinetics.crosscheck.report.observables import contact_value

_RESTITUTION = axis("restitution $e$", limits=(-0.02, 1.0))
_TIME = axis("time $t$ / √(l/g)", scale="log")
_DENSITY = "number density $ρ_0 d^2$"
_FINE = np.sqrt(1.0 - np.geomspace(1.0, 1e-6, 200))  # e, ever closer to 1
_FAR = 0.15  # how far the level of e = 0 is drawn
_SHOWN = (0.02, 0.04, 0.08)  # densities of which the share of trapped tracers is drawn
_SENTENCES = "field_figures.txt.j2"
LIMIT = "limiting law"


def field_figures(
    steady: list[SteadyCase],
    lines: list[SteadyLine],
    approach: list[ApproachCase],
    dense: list[DensityCase],
) -> dict[str, Data]:
    """The data of every figure, by name; the main one comes first."""
    figures = {"drift": drift(steady, lines)}
    for line in lines:
        name = SCATTERERS[line.dimension]
        figures[f"dispersion-{name}"] = dispersion(line, _of(steady, line.dimension), name)
    if approach:
        figures["velocity-from-rest"] = from_rest(approach, is_drift=True)
        figures["square-from-rest"] = from_rest(approach, is_drift=False)
    if dense:
        figures["density-drift"] = drift_over_density(dense)
        figures["density-trapped"] = trapped_over_time(dense)
        figures["density-captures"] = captures_over_density(dense)
    return figures


def drift(steady: list[SteadyCase], lines: list[SteadyLine]) -> Data:
    """The drift over the restitution with both limits, and particles over the equation below."""
    above, below = [], [series("zero", [0.0, 1.0], [1.0, 1.0])]
    for line in lines:
        name, d = SCATTERERS[line.dimension], line.dimension
        above.append(series(LIMIT, _FINE, drift_near_elastic(_FINE, d), group=name))
        if line.restitutions[0] == 0.0:
            above.append(series(LIMIT, [0.0, _FAR], [line.drift[0]] * 2, group=name))
        above.append(series("kinetic equation", line.restitutions, line.drift, group=name))
        cases = _of(steady, d)
        at, measured = _measured(cases, "drift")
        above.append(points(at, measured, name))
        solved = np.array([case.state.drift for case in cases])
        shift = 0.004 * (2 * d - 5)  # so that disks and spheres are both seen
        below.append(points(at + shift, measured / solved, name))
    y = axis("drift $u$ / √(gl)", limits=(0.0, 1.25))
    made = figure("drift", _RESTITUTION, y, above, _SENTENCES)
    return made | {"ratio": {"y": axis("over the equation"), "series": below}}


def dispersion(line: SteadyLine, cases: list[SteadyCase], scatterers: str) -> Data:
    """Both diffusion coefficients of one dimension over the restitution."""
    drawn = []
    laws = dispersion_near_elastic(_FINE, line.dimension)
    for law, name in zip(laws, ("parallel", "perpendicular"), strict=True):
        group = {"parallel": "$D_∥$, along", "perpendicular": "$D_⊥$, across"}[name]
        drawn.append(series(LIMIT, _FINE, law, group=group))
        solved = getattr(line, name)
        drawn.append(series("kinetic equation", line.restitutions, solved, group=group))
        drawn.append(points(*_measured(cases, f"diffusion_{name}"), group))
    y = axis("$D$ / √(gl³)", limits=(0.0, 1.05))
    return figure("dispersion", _RESTITUTION, y, drawn, _SENTENCES, scatterers=scatterers)


def from_rest(approach: list[ApproachCase], is_drift: bool) -> Data:
    """Mean velocity or mean square speed over time, from rest."""
    lines = []
    for case in approach:
        name = f"{SCATTERERS[case.dimension]}, e = {case.restitution:g}"
        solved = case.drift if is_drift else case.square
        measured = case.measured_drift if is_drift else case.measured_square
        steady = case.state.drift if is_drift else case.state.mean_square_speed
        lines.append(series(LIMIT, case.times[[0, -1]], [steady] * 2, group=name))
        lines.append(series("kinetic equation", case.times, solved, group=name))
        lines.append(points(case.times[::2], measured[::2], name))
    y = axis("$⟨v_z⟩$ / √(gl)" if is_drift else "$⟨v^2⟩$ / gl")
    block = "velocity_from_rest" if is_drift else "square_from_rest"
    return figure(block, _TIME, y, lines, _SENTENCES)


def drift_over_density(cases: list[DensityCase]) -> Data:
    """The drift of tracers while they move, over that of the dilute equation."""
    last = max(float(case.densities[-1]) for case in cases)
    fine = np.linspace(0.0, last, 60)
    alone = [contact_value(float(rho)) ** -0.5 for rho in fine]
    lines = [series("zero", [0.0, last], [1.0, 1.0]), series("free path alone", fine, alone)]
    lines += [_of_restitution(case, case.drift) for case in cases]
    x, y = axis(_DENSITY), axis("$u$ / $u$ of the equation")
    return figure("density_drift", x, y, lines, _SENTENCES)


def trapped_over_time(cases: list[DensityCase]) -> Data:
    """The share of trapped tracers, at the middle one of the restitutions."""
    case = cases[len(cases) // 2]
    lines = [
        points(case.times, case.trapped[k], f"ρ₀d² = {rho:g}")
        for k, rho in enumerate(case.densities)
        if np.any(np.isclose(rho, _SHOWN))
    ]
    y = axis("share of trapped tracers")
    return figure("density_trapped", _TIME, y, lines, _SENTENCES, restitution=case.restitution)


def captures_over_density(cases: list[DensityCase]) -> Data:
    """How often tracers are trapped, over the density, on logarithmic axes."""
    lines = [
        _of_restitution(case, case.captures, case.captures.value > 2 * case.captures.error)
        for case in cases
    ]
    x, y = axis(_DENSITY, scale="log"), axis("captures per mean free path", scale="log")
    return figure("density_captures", x, y, lines, _SENTENCES)


def _of_restitution(case: DensityCase, measured: Measured, seen: ArrayLike = True) -> Data:
    """Points over the density, with the colour and the marker of their restitution."""
    at = np.flatnonzero(np.broadcast_to(seen, case.densities.shape))
    value, error = measured.value[at], measured.error[at]
    return series("particles", case.densities[at], value, error, case.restitution)


def points(x: Array, measured: Measured, group: str) -> Data:
    """What particles say, in the colour of a group."""
    return series("particles", x, measured.value, measured.error, group=group)


def _of(steady: list[SteadyCase], dimension: int) -> list[SteadyCase]:
    return [case for case in steady if case.dimension == dimension]


def _measured(cases: list[SteadyCase], name: str) -> tuple[Array, Measured]:
    """The restitutions of some cases, and what their particles say."""
    e = np.array([case.restitution for case in cases])
    return e, Measured.joined(case.values[name] for case in cases)
