"""The report in a uniform field: theory against particles, as a page and as JSON.

`make_report` gives the document, one tree of plain data; `write_report` writes it as `field.json`
and, drawn and set, as `field.html`.
"""

from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from kinetics.crosscheck.report.field_density import DensityCase, density_case, density_row
from kinetics.crosscheck.report.field_figures import field_figures
from kinetics.crosscheck.report.field_limits import drift_constant, drift_near_elastic
from kinetics.crosscheck.report.field_page import render_field
from kinetics.crosscheck.report.field_rows import (
    NEARLY_ELASTIC,
    OBSERVABLES,
    FieldRow,
    all_rows,
)
from kinetics.crosscheck.report.field_runs import (
    ApproachCase,
    SteadyCase,
    SteadyLine,
    approach_case,
    solver_line,
    steady_case,
)
from kinetics.crosscheck.report.field_settings import SCATTERERS, FieldSettings
from kinetics.crosscheck.report.frame import Document, frame, write_files
from kinetics.crosscheck.report.picture import picture_in_field
from kinetics.crosscheck.report.templates import paragraphs
from kinetics.crosscheck.strict_json import plain
from kinetics.crosscheck.verdicts import AGREES_BELOW, chance

SCHEMA = "inelastic-lorentz/field-report/1"
CLOSE = 0.01
"""The drift is reached when the mean velocity stays as close to it as this, relative to it."""

Progress = Callable[[str], None]


def make_report(settings: FieldSettings, tell: Progress) -> Document:
    """Run solver and particles on the settings and compare them; returns the document.

    `tell` is called with the name of each stage when it begins (`stages` counts them).
    """
    lines, steady, approach = [], [], []
    for d in settings.dimensions:
        tell(f"{SCATTERERS[d]}: solver")
        lines.append(solver_line(d, settings))
        for e in settings.restitutions:
            tell(f"{SCATTERERS[d]}, e = {e:g}")
            steady.append(steady_case(e, d, settings))
        for e in settings.followed:
            tell(f"{SCATTERERS[d]}, e = {e:g}: from rest")
            approach.append(approach_case(e, d, settings))
    dense = []
    for e in settings.dense if settings.has_disks else ():
        tell(f"hard disks, e = {e:g}")
        dense.append(density_case(e, settings))
    document = build_document(settings, lines, steady, approach, dense)
    return document | {"picture": picture_in_field(settings.seed) if dense else None}


def stages(settings: FieldSettings) -> int:
    """How often `make_report` and `write_report` together report progress."""
    each = 1 + len(settings.restitutions) + len(settings.followed)
    return 1 + len(settings.dimensions) * each + settings.has_disks * len(settings.dense)


def write_report(
    document: Document, folder: Path, tell: Progress, formats: Sequence[str] = ()
) -> list[Path]:
    """Write field.html, field.json and figures in these formats; see `frame.write_files`."""
    tell("writing")
    return write_files(document, "field", render_field(document), folder, formats)


def build_document(
    settings: FieldSettings,
    lines: list[SteadyLine],
    steady: list[SteadyCase],
    approach: list[ApproachCase],
    dense: list[DensityCase],
) -> Document:
    """The tree of plain data that both files are made from."""
    rows = all_rows(steady, approach) + [FieldRow(2, density_row(case)) for case in dense]
    document: Document = plain(
        {
            "schema": SCHEMA,
            **frame([item.row for item in rows]),
            "title": _sentences("title")[0],
            "findings": findings(lines, approach, dense, rows),
            "units": _sentences("units")[0],
            "settings": asdict(settings),
            "rows": [{"dimension": item.dimension, **asdict(item.row)} for item in rows],
            "lines": [asdict(line) for line in lines],
            "steady": [_steady(case) for case in steady],
            "approach": [_approach(case) for case in approach],
            "dense": [asdict(case) for case in dense],
            "figures": field_figures(steady, lines, approach, dense),
        }
    )
    return document


def _sentences(block: str, **values: Any) -> list[str]:
    return paragraphs("field.txt.j2", block, **values)


def _steady(case: SteadyCase) -> dict[str, Any]:
    state = case.state
    found = {
        name: getattr(case, name)
        for name in (
            "dimension", "restitution", "tracers", "groups", "measured_from", "measured_to"
        )
    }  # fmt: skip
    return found | {
        "status": state.status.name.lower(),
        "error_estimate": state.error_estimate,
        "plan": [asdict(step) for step in state.plan],
        "particles": case.values,
    }


def _approach(case: ApproachCase) -> dict[str, Any]:
    """All of it but the steady state, which is given by its drift and mean square speed."""
    found = {name: value for name, value in vars(case).items() if name != "state"}
    steady = {"drift": case.state.drift, "mean_square_speed": case.state.mean_square_speed}
    return found | {"steady": steady}


def findings(
    lines: list[SteadyLine],
    approach: list[ApproachCase],
    dense: list[DensityCase],
    rows: list[FieldRow],
) -> list[str]:
    """What was found, one paragraph each, with numbers."""
    compared = [item.row for item in rows if item.row.kind == "statistical"]
    solved = [item.row for item in rows if item.row.kind == "numerical"]
    drifts = [row for row in compared if row.observable == "drift"]
    return _sentences(
        "findings",
        names=SCATTERERS,
        lines=[_in_words(line) for line in lines],
        compared=len(compared),
        by_chance=len(compared) * chance(AGREES_BELOW),
        agreeing=sum(row.verdict == "agrees" for row in compared),
        others=[
            f"{OBSERVABLES[item.row.observable].short} among {SCATTERERS[item.dimension]} at "
            f"e = {item.row.restitution:g} ({item.row.corrected_sigmas:.1f} sigma)"
            for item in rows
            if item.row.kind == "statistical" and item.row.verdict != "agrees"
        ],
        relations=len(solved),
        met=sum(row.verdict == "agrees" for row in solved),
        drift_errors=[100 * float(row.error or 0) / row.theory for row in drifts],
        approach=[_overshoot(case) for case in approach],
        close=100 * CLOSE,
        dense=[_dense_in_words(case) for case in dense],
        densities=dense[0].densities.tolist() if dense else [],
    )


def _in_words(line: SteadyLine) -> dict[str, Any]:
    """The numbers of one line that a sentence names."""
    d = line.dimension
    ratio = line.perpendicular / line.parallel
    named = [0.0, 0.7, 0.99]
    drifts = [float(u) for u in np.interp(named, line.restitutions, line.drift)]
    nearly = float(np.interp(NEARLY_ELASTIC, line.restitutions, line.drift))
    return {
        "scatterers": SCATTERERS[d],
        "at": named,
        "drifts": drifts,
        "constant": drift_constant(d),
        "nearly_elastic": NEARLY_ELASTIC,
        "law_misses": 100 * abs(float(drift_near_elastic(NEARLY_ELASTIC, d)) / nearly - 1),
        "ratios": (float(ratio.min()), float(ratio.max())),
    }


def _dense_in_words(case: DensityCase) -> dict[str, Any]:
    """What a sentence says of the highest density, and how far from 1 the lowest still is."""
    trapped = case.trapped.value[-1]
    return {
        "restitution": case.restitution,
        "slower": 100 * (1 - float(case.drift.value[-1])),
        "alone": 100 * (1 - float(case.path_alone[-1])),
        "trapped": 100 * float(trapped[-1]),
        "until": float(case.times[-1]),
    }


def _overshoot(case: ApproachCase) -> dict[str, Any]:
    """The largest mean velocity over the drift, when, and from when on it is close to it."""
    ratio = case.drift / case.state.drift
    k = int(np.argmax(ratio))
    away = np.flatnonzero(abs(ratio - 1) > CLOSE)
    return {
        "scatterers": SCATTERERS[case.dimension],
        "restitution": case.restitution,
        "largest": 100 * float(ratio[k] - 1),
        "reached": float(case.times[min(away[-1] + 1, len(ratio) - 1)]) if away.size else 0.0,
    }
