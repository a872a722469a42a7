"""The report: runs the methods, compares what they give, and writes it down.

`make_report` gives the document, one tree of plain data that JSON can hold; `write_report` writes
it as `report.json` and, drawn and set, as `report.html`. Nothing is in the page that the document
lacks.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from kinetics import sonine
from kinetics.crosscheck.report.algebra import algebra_process, printed_rows
from kinetics.crosscheck.report.all_figures import all_figures
from kinetics.crosscheck.report.case import Case, Scans
from kinetics.crosscheck.report.case_rows import rows_of_case
from kinetics.crosscheck.report.causes import Causes, causes
from kinetics.crosscheck.report.citations import number_of
from kinetics.crosscheck.report.claims import claims
from kinetics.crosscheck.report.density_part import add_density_part, gather_density_part
from kinetics.crosscheck.report.dimensions import both_dimensions
from kinetics.crosscheck.report.figure_lines import Results
from kinetics.crosscheck.report.frame import Document, frame, write_files
from kinetics.crosscheck.report.headline import headline
from kinetics.crosscheck.report.observables import contact_value
from kinetics.crosscheck.report.page import render
from kinetics.crosscheck.report.picture import picture
from kinetics.crosscheck.report.questions import all_answers
from kinetics.crosscheck.report.row import (
    OBSERVABLES,
    OVER_TIME,
    RESCALED,
    Row,
    relative_error,
)
from kinetics.crosscheck.report.run_methods import PAPER_CAP, gather_case
from kinetics.crosscheck.report.scan_figures import RATIO_NAMES
from kinetics.crosscheck.report.scans import gather_scans
from kinetics.crosscheck.report.settings import ReportSettings
from kinetics.crosscheck.report.templates import paragraphs
from kinetics.crosscheck.strict_json import plain
from kinetics.crosscheck.verdicts import WORDS

SCHEMA = "inelastic-lorentz/report/1"

Checks = Sequence[Mapping[str, Any]]
Progress = Callable[[str], None]


def make_report(settings: ReportSettings, progress: Progress | None = None) -> Document:
    """Run the three methods on the settings and compare them; returns the document.

    `progress` is called with the name of each stage when it begins (`stages` counts them).
    ValueError for what cannot be simulated; RuntimeError if the derivations fail.
    """
    tell = progress or (lambda stage: None)
    with algebra_process(settings) as algebra:
        cases = []
        for e, last in zip(settings.restitutions, settings.final_times, strict=True):
            cases.append(gather_case(e, last, settings, tell))
        scans, density, dimensions = None, None, []
        if settings.is_papers_law:
            scans = gather_scans(cases, settings, tell)
            tell("finite density")
            density = gather_density_part(cases, scans, settings)
        else:
            dimensions = both_dimensions(cases, settings, tell)
        tell("comparing")
        rows = [row for case in cases for row in rows_of_case(case, settings)]
        tell("derivations")
        checks = printed_rows(algebra)
    document = build_document(settings, cases, scans, rows, checks)
    document = add_density_part(document, density, cases)
    document["picture"] = picture(settings)
    return document | plain({"dimensions": dimensions}) if dimensions else document


def stages(settings: ReportSettings) -> int:
    """How often `make_report` and `write_report` together report progress."""
    each = 3 if settings.is_papers_law else 4
    return each * len(settings.restitutions) + (6 if settings.is_papers_law else 3)


def write_report(
    document: Document,
    folder: Path,
    progress: Progress | None = None,
    formats: Sequence[str] = (),
) -> list[Path]:
    """Write report.html, report.json and figures in these formats; see `frame.write_files`."""
    if progress is not None:
        progress("writing")
    return write_files(document, "report", render(document), folder, formats)


def build_document(
    settings: ReportSettings,
    cases: Sequence[Case],
    scans: Scans | None,
    rows: Sequence[Row],
    checks: Checks,
) -> Document:
    """The tree of plain data that both files are made from."""
    results = Results(cases, settings)
    steps = causes(results)
    document: Document = plain(
        {
            "schema": SCHEMA,
            **frame(rows),
            "title": _sentences("title"),
            "summary": _summary(settings, rows, checks),
            "headline": headline(results, rows, steps, checks),
            "claims": claims(results),
            "causes": [asdict(step) for step in steps],
            "answers": all_answers(cases, rows, settings),
            "units": _sentences("units", spheres=settings.dimension == 3),
            "settings": settings.described(),
            "findings": _findings(results, scans, rows, steps),
            "rows": [asdict(row) for row in rows],
            "algebra": list(checks),
            "cases": [_case(case) for case in cases],
            "scans": None if scans is None else asdict(scans),
            "figures": all_figures(cases, scans, settings),
        }
    )
    return document


def _sentences(block: str, **values: Any) -> str:
    (text,) = paragraphs("report.txt.j2", block, **values)
    return text


def _case(case: Case) -> dict[str, Any]:
    scaled = None
    if case.exact is not None:
        exact, solver = case.scaling_state
        both = {
            name: {"exact": getattr(exact, name), "solver": getattr(solver, name)}
            for name in ("cooling_rate", "a2")
        }
        scaled = both | {name: getattr(exact, name) for name in ("diffusion_slope", "tail_rate")}
    return {
        "restitution": case.restitution,
        "times": case.times,
        "scaled": scaled,
        "kinetic": {name: getattr(case.kinetic, name) for name in OVER_TIME},
        "rescaled": {name: getattr(case.rescaled, name) for name in OVER_TIME},
        "speed_edges": case.speed_edges,
        "position_edges": case.position_edges,
        "particles": [asdict(run) for run in case.runs],
    }


def _summary(settings: ReportSettings, rows: Sequence[Row], checks: Checks) -> str:
    return _sentences(
        "summary",
        settings=settings,
        checks=checks,
        strict=[r for r in rows if r.kind == "statistical" and r.source == "Boltzmann-Grad"],
        solver=[r for r in rows if r.kind == "numerical"],
        errata=[
            number_of(check["label"]) or check["title"]
            for check in checks
            if check["status"] == "erratum"
        ],
    )


def _findings(
    results: Results, scans: Scans | None, rows: Sequence[Row], steps: Sequence[Causes]
) -> list[str]:
    """What explains the differences, one paragraph each, with numbers and errors."""
    settings, cases = results.settings, results.cases
    dilute = 1 / (2 * settings.half_rate)
    dense = dilute / contact_value(settings.number_density, dimension=settings.dimension)
    runs = [run for case in cases for run in case.runs]
    remaining: dict[float, list[dict[str, Any]]] = {case.restitution: [] for case in cases}
    for row in rows:
        if row.against == RESCALED and row.observable != "scaled_vdf":
            remaining[row.restitution].append(asdict(row))
    return paragraphs(
        "report.txt.j2", "findings", cases=cases,
        cooling=[case for case in cases if case.exact is not None],
        scans=scans, dilute=dilute, dense=dense, settings=settings,
        remaining=remaining, relative_error=relative_error, ratio_names=RATIO_NAMES, cap=PAPER_CAP,
        most=max(run.most_collisions for run in runs),
        capped=max(run.above_cap for run in runs),
        trapped=any(case.hard.statuses["trapped"] for case in cases),
        fit=sonine.FITTED_COOLING_FACTOR, words=WORDS,
        same_times={step.restitution: step.same_times for step in steps},
        shorts={name: names.short for name, names in OBSERVABLES.items()},
    )  # fmt: skip
