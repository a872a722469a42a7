"""Figures of tracers in a field among hard disks at a finite density."""

import numpy as np

from kinetics.crosscheck.report.field_density import DensityCase, Trajectories
from kinetics.crosscheck.report.field_drawing import label, panel
from kinetics.crosscheck.report.figures import Data, axis, series
from kinetics.crosscheck.report.observables import contact_value
from kinetics.crosscheck.report.templates import paragraphs

_DENSITY = "number density $ρ_0 d^2$"
_SHOWN = (0.02, 0.04, 0.08)  # densities of which the share of trapped tracers is drawn


def density_figures(cases: list[DensityCase], picture: Trajectories) -> dict[str, Data]:
    """The data of every figure, by name."""
    return {
        "density-drift": drift_over_density(cases),
        "density-trapped": trapped_over_time(cases),
        "density-captures": captures_over_density(cases),
        "trajectories": drawn_trajectories(picture),
    }


def _figure(name: str, panels: list[Data], **values: object) -> Data:
    title, description = paragraphs("field_figures.txt.j2", name, **values)
    return {"title": title, "description": description, "panels": panels}


def drift_over_density(cases: list[DensityCase]) -> Data:
    """The drift of tracers while they move, over that of the dilute equation."""
    last = max(float(case.densities[-1]) for case in cases)
    fine = np.linspace(0.0, last, 60)
    alone = [contact_value(float(rho)) ** -0.5 for rho in fine]
    lines, labels = [series("limit", fine, alone)], []
    for case in cases:
        name = f"e = {case.restitution:g}"
        value, error = case.drift.value, case.drift.error
        lines.append(series("particles", case.densities, value, error, group=name))
        labels.append(label(name, 1.03 * last, float(value[-1]), name))
    labels.append(label("free path alone", 0.98 * last, alone[-1] + 0.03, "", "right"))
    lines.append(series("zero", [0.0, 1.2 * last], [1.0, 1.0]))
    lowest = min(y for line in lines for y in line["y"])
    x = axis(_DENSITY, limits=(0.0, 1.2 * last))
    y = axis("$u$ / $u$ of the equation", limits=(lowest - 0.04, 1.03))
    return _figure("density_drift", [panel(x, y, lines, labels)])


def trapped_over_time(cases: list[DensityCase]) -> Data:
    """The share of trapped tracers, at the middle one of the restitutions."""
    case = cases[len(cases) // 2]
    lines, labels = [], []
    for k, rho in enumerate(case.densities):
        if not np.any(np.isclose(rho, _SHOWN)):
            continue
        name, share = f"ρ₀d² = {rho:g}", case.trapped[k]
        lines.append(series("particles", case.times, share.value, share.error, group=name))
        labels.append(label(name, 1.1 * case.times[-1], float(share.value[-1]), name))
    top = 1.2 * max(y for line in lines for y in line["y"]) + 1e-3
    x = axis("time $t$ / √(l/g)", scale="log", limits=(0.9, 4.0 * float(case.times[-1])))
    y = axis("share of trapped tracers", limits=(-0.02 * top, top))
    panels = [panel(x, y, lines, labels)]
    return _figure("density_trapped", panels, restitution=case.restitution)


def captures_over_density(cases: list[DensityCase]) -> Data:
    """How often tracers are trapped, over the density, on logarithmic axes."""
    lines, labels = [], []
    for case in cases:
        name = f"e = {case.restitution:g}"
        seen = case.captures.value > 2 * case.captures.error
        value, error = case.captures.value[seen], case.captures.error[seen]
        if value.size:
            lines.append(series("particles", case.densities[seen], value, error, group=name))
            labels.append(label(name, 1.1 * case.densities[seen][-1], float(value[-1]), name))
    last = max(float(case.densities[-1]) for case in cases)
    x = axis(_DENSITY, scale="log", limits=(float(cases[0].densities[0]) / 1.2, 2.0 * last))
    y = axis("captures per mean free path", scale="log")
    return _figure("density_captures", [panel(x, y, lines, labels)])


def drawn_trajectories(picture: Trajectories) -> Data:
    """The paths among the disks, the field downwards."""
    side = float(np.max(picture.disks)) + 1.0
    lines = []
    for k, path in enumerate(np.moveaxis(picture.paths, 1, 0)):
        inside = (path[:, 0] < side) & (path[:, 1] > 0.0) & (path[:, 1] < side)
        end = int(np.argmin(inside)) if not inside.all() else len(path)
        name = f"tracer {k + 1}"
        lines.append(series("path", path[:end, 1], -path[:end, 0], group=name))
        if picture.trapped[k] and inside.all():
            lines.append(series("trapped", path[-1:, 1], -path[-1:, 0], group=name))
    x = axis("across the field / d", limits=(0.0, side))
    y = axis("along the field / d", limits=(-side, 0.0))
    drawn = panel(x, y, lines, [], 1.3)
    drawn["circles"] = [[float(b), float(-a)] for a, b in picture.disks]
    words = {"restitution": picture.restitution, "density": picture.number_density}
    return _figure("trajectories", [drawn], **words)
