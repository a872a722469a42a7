"""Figures of the report in a uniform field, as the plain lists that the JSON file holds."""

import numpy as np

from kinetics.crosscheck.report.case import Array
from kinetics.crosscheck.report.field_drawing import ACROSS, label, panel
from kinetics.crosscheck.report.field_limits import (
    dispersion_near_elastic,
    drift_constant,
    drift_near_elastic,
)
from kinetics.crosscheck.report.field_runs import ApproachCase, SteadyCase, SteadyLine
from kinetics.crosscheck.report.field_settings import SCATTERERS
from kinetics.crosscheck.report.figures import Data, axis, series
from kinetics.crosscheck.report.templates import paragraphs

_RESTITUTION = axis("restitution $e$", limits=(-0.02, 1.0))
_TIME = axis("time $t$ / √(l/g)", scale="log", limits=(0.1, 100.0))
_FINE = np.sqrt(1.0 - np.geomspace(1.0, 1e-6, 200))  # e, ever closer to 1
_FAR = 0.15  # how far the level of e = 0 is drawn


def field_figures(
    steady: list[SteadyCase], lines: list[SteadyLine], approach: list[ApproachCase]
) -> dict[str, Data]:
    """The data of every figure, by name; the main one comes first."""
    figures = {"drift": drift(steady, lines), "dispersion": dispersion(steady, lines)}
    if approach:
        velocity, square = "$⟨v_z⟩$ / √(gl)", "$⟨v^2⟩$ / gl"
        figures["velocity-from-rest"] = from_rest(approach, "velocity_from_rest", velocity)
        figures["square-from-rest"] = from_rest(approach, "square_from_rest", square)
    return figures


def _figure(name: str, panels: list[Data]) -> Data:
    """A figure; its title and its description stand in the template."""
    title, description = paragraphs("field_figures.txt.j2", name)
    return {"title": title, "description": description, "panels": panels}


def drift(steady: list[SteadyCase], lines: list[SteadyLine]) -> Data:
    """The drift over the restitution with both limits, and particles over solver below."""
    above, below, labels = [], [series("zero", [0.0, 1.0], [0.0, 0.0])], []
    for line in lines:
        name, d = SCATTERERS[line.dimension], line.dimension
        above.append(series("limit", _FINE, drift_near_elastic(_FINE, d), group=name))
        if line.restitutions[0] == 0.0:
            above.append(series("limit", [0.0, _FAR], [line.drift[0]] * 2, group=name))
        above.append(series("solver", line.restitutions, line.drift, group=name))
        constant, side = drift_constant(d), 2 * d - 5  # of spheres above the line, of disks below
        words = rf"${constant:.4f}\,(1-e^2)^{{1/4}}$"
        labels.append(label(words, 0.02, constant + 0.05 * side, name))
        labels.append(label(name, 0.34, _at(line, line.drift, 0.34) + 0.045, name))
    for d, at, cases in _by_dimension(steady):
        name = SCATTERERS[d]
        value, error = _measured(cases, "drift")
        above.append(series("particles", at, value, error, group=name))
        solved = np.array([case.state.drift for case in cases])
        shift = 0.004 * (2 * d - 5)  # so that both are seen
        ratio = 100 * (value / solved - 1)
        below.append(series("particles", at + shift, ratio, 100 * error / solved, group=name))
    largest = 1.3 * max(
        abs(y) + error for s in below[1:] for y, error in zip(s["y"], s["error"], strict=True)
    )
    y = axis("drift $u$ / √(gl)", limits=(0.0, 1.25))
    deviation = axis("deviation [%]", limits=(-largest, largest))
    what = label("particles / solver − 1", 0.02, 0.8 * largest, "")
    panels = [panel(_RESTITUTION, y, above, labels)]
    panels.append(panel(_RESTITUTION, deviation, below, [what], 0.42))
    return _figure("drift", panels)


def dispersion(steady: list[SteadyCase], lines: list[SteadyLine]) -> Data:
    """Both diffusion coefficients over the restitution, in a panel for each dimension."""
    panels = []
    for line in lines:
        name, d = SCATTERERS[line.dimension], line.dimension
        laws = dispersion_near_elastic(_FINE, d)
        drawn = [series("limit", _FINE, law, group=name) for law in laws]
        drawn.append(series("solver", line.restitutions, line.parallel, group=name))
        drawn.append(series(f"solver{ACROSS}", line.restitutions, line.perpendicular, group=name))
        for dimension, at, cases in _by_dimension(steady):
            if dimension == d:
                value, error = _measured(cases, "diffusion_parallel")
                drawn.append(series("particles", at, value, error, group=name))
                value, error = _measured(cases, "diffusion_perpendicular")
                drawn.append(series(f"particles{ACROSS}", at, value, error, group=name))
        highest = float(dispersion_near_elastic(0.62, d)[1])
        labels = [
            label(name, 0.02, 0.95, name),
            label("$D_⊥$, across the field", 0.62, highest + 0.07, name, "right"),
            label("$D_∥$, along the field", 0.62, _at(line, line.parallel, 0.5) - 0.07, name,
                  "right"),
        ]  # fmt: skip
        y = axis("$D$ / √(gl³)", limits=(0.0, 1.05))
        panels.append(panel(_RESTITUTION, y, drawn, labels, 0.72))
    return _figure("dispersion", panels)


def from_rest(approach: list[ApproachCase], which: str, head: str) -> Data:
    """Mean velocity or mean square speed over time, from rest."""
    lines, labels = [], []
    for case in approach:
        name, is_drift = SCATTERERS[case.dimension], which == "velocity_from_rest"
        solved = case.drift if is_drift else case.square
        measured = case.measured_drift if is_drift else case.measured_square
        steady = case.state.drift if is_drift else case.state.mean_square_speed
        lines.append(series("limit", [8.0, 100.0], [steady] * 2, group=name))
        lines.append(series("solver", case.times, solved, group=name))
        points = measured[::2]
        lines.append(series("particles", case.times[::2], points.value, points.error, group=name))
        labels.append(label(f"{name}, e = {case.restitution:g}", 95.0, steady, name, "right"))
    top = 1.15 * max(y for line in lines for y in line["y"])
    for text in labels:
        text["y"] += 0.03 * top
    return _figure(which, [panel(_TIME, axis(head, limits=(0.0, top)), lines, labels)])


def _at(line: SteadyLine, values: Array, e: float) -> float:
    """A quantity of the line at another restitution."""
    return float(np.interp(e, line.restitutions, values))


def _by_dimension(steady: list[SteadyCase]) -> list[tuple[int, Array, list[SteadyCase]]]:
    """The dimension, the restitutions and the cases of each dimension."""
    found = []
    for d in sorted({case.dimension for case in steady}):
        cases = [case for case in steady if case.dimension == d]
        found.append((d, np.array([case.restitution for case in cases]), cases))
    return found


def _measured(cases: list[SteadyCase], name: str) -> tuple[Array, Array]:
    """What the particles of all cases say, and its standard error."""
    return np.array([c.values[name].value for c in cases]), np.array(
        [c.values[name].error for c in cases]
    )
