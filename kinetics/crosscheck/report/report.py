"""The report: asks the witnesses, compares what they say, and writes it down.

`make_report` gives the document, one tree of plain data that JSON can hold; `write_report` writes
it as `report.json` and, drawn and set, as `report.html`. Nothing is in the page that the document
lacks.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, fields
from importlib.metadata import version
from pathlib import Path
from typing import Any

from kinetics.crosscheck.files import write_together
from kinetics.crosscheck.plain import dumps, plain
from kinetics.crosscheck.report.algebra import AlgebraProcess
from kinetics.crosscheck.report.all_figures import all_figures
from kinetics.crosscheck.report.case import Case, Measured, ParticleEvidence, Scans
from kinetics.crosscheck.report.case_rows import compare_case
from kinetics.crosscheck.report.displacement_figures import RATIO_NAMES
from kinetics.crosscheck.report.figures import figure_file
from kinetics.crosscheck.report.page import number, render
from kinetics.crosscheck.report.questions import all_answers
from kinetics.crosscheck.report.row import (
    RESCALED,
    Row,
    contact_value,
    counts,
    judged,
    scale_of,
)
from kinetics.crosscheck.report.run_methods import PAPER_CAP, gather_case
from kinetics.crosscheck.report.scans import gather_scans
from kinetics.crosscheck.report.settings import ReportSettings
from kinetics.crosscheck.verdicts import AGREES_BELOW, DIFFERS_ABOVE, MEANING, chance
from kinetics.sonine import FITTED_COOLING_FACTOR

SCHEMA = "inelastic-lorentz/report/1"
UNITS = (
    "Lengths in d, the diameter of a scatterer and of the tracer; speeds in U, the standard "
    "deviation of one component of the initial velocity, so that v₀(0) = √2 U; times in d/U. "
    "F(c) is a density in the plane (integral 1, ⟨c²⟩ = 1), G(R) one over R (integral 1)."
)

OVER_TIME = ("thermal_speed", "a2", "msd", "kurtosis")

Document = dict[str, Any]
Progress = Callable[[str], None]


def make_report(settings: ReportSettings, progress: Progress | None = None) -> Document:
    """Run the three witnesses on the settings and compare them; returns the document.

    `progress` is called with the name of each stage when it begins (`stages` lists them).
    ValueError for what cannot be simulated; RuntimeError if the derivations fail.
    """
    tell = progress or (lambda stage: None)
    with AlgebraProcess() as algebra:
        cases = []
        for e, last in zip(settings.restitutions, settings.final_times, strict=True):
            cases.append(gather_case(e, last, settings, tell))
        scans = gather_scans(cases, settings, tell)
        tell(COMPARISON)
        rows = judged(row for case in cases for row in compare_case(case, settings))
        tell(ALGEBRA)
        checks = algebra.rows()
    return build_document(settings, cases, scans, rows, checks)


COMPARISON, ALGEBRA, WRITING = "comparing", "derivations", "writing"


def stages(settings: ReportSettings) -> int:
    """How often `make_report` and `write_report` together report progress."""
    return 3 * len(settings.restitutions) + 5


def write_report(
    document: Document,
    folder: Path,
    progress: Progress | None = None,
    formats: Sequence[str] = (),
) -> list[Path]:
    """Write report.html and report.json into the folder, all or nothing; returns the paths.

    `formats` (of "svg", "pdf", "png") adds each figure as a file report-NAME.FORMAT.
    """
    if progress is not None:
        progress(WRITING)
    files: dict[str, str | bytes] = {
        "report.json": dumps(document),
        "report.html": render(document),
    }
    for name, data in document["figures"].items():
        for kind in dict.fromkeys(formats):
            files[f"report-{name}.{kind}"] = figure_file(name, data, kind)
    return write_together(folder, files)


def build_document(
    settings: ReportSettings,
    cases: Sequence[Case],
    scans: Scans | None,
    rows: Sequence[Row],
    checks: Sequence[Mapping[str, Any]],
) -> Document:
    """The tree of plain data that both files are made from."""
    statistical = [row for row in rows if row.kind == "statistical"]
    document: Document = plain(
        {
            "schema": SCHEMA,
            "title": "The inelastic Lorentz gas: three witnesses compared",
            "summary": _summary(settings, rows, checks),
            "answers": all_answers(cases, rows),
            "units": UNITS,
            "software": _versions(),
            "settings": asdict(settings),
            "verdicts": {word.value: text for word, text in MEANING.items()},
            "verdict_counts": counts(rows),
            "multiple_comparisons": (
                f"{len(statistical)} rows are statistical; each shows the worst of its times or "
                "bins. Its two-sided p-value (Student's, errors being jackknifed over independent "
                "groups) is multiplied by the number of its times or bins (Bonferroni) and turned "
                "back into the corrected sigmas, at which the verdict looks: agrees below "
                f"{AGREES_BELOW}, differs from {DIFFERS_ABOVE} on. Were every theory true, at most "
                f"{len(statistical) * chance(AGREES_BELOW):.2g} of the rows would be expected not "
                f"to agree by chance, and {len(statistical) * chance(DIFFERS_ABOVE):.1g} to differ."
            ),
            "findings": _findings(settings, cases, scans, rows),
            "rows": [asdict(row) for row in rows],
            "algebra": list(checks),
            "cases": [_case(case) for case in cases],
            "scans": None if scans is None else asdict(scans),
            "figures": all_figures(cases, scans, settings),
        }
    )
    return document


def _versions() -> dict[str, str]:
    names = ("inelastic-lorentz", "numpy", "scipy", "numba", "sympy", "matplotlib")
    return {name: version(name) for name in names}


def _case(case: Case) -> dict[str, Any]:
    scaled = None
    if case.exact is not None and case.scaled is not None:
        scaled = {
            "cooling_rate": {"exact": case.exact.cooling_rate, "solver": case.scaled.cooling_rate},
            "a2": {"exact": case.exact.a2, "solver": case.scaled.a2},
            "diffusion_slope": case.exact.diffusion_slope,
            "tail_rate": case.exact.tail_rate,
        }
    return {
        "restitution": case.restitution,
        "times": case.times,
        "scaled": scaled,
        "kinetic": {name: getattr(case.kinetic, name) for name in OVER_TIME},
        "rescaled": {name: getattr(case.rescaled, name) for name in OVER_TIME},
        "speed_edges": case.speed_edges,
        "position_edges": case.position_edges,
        "particles": [_particles(run) for run in (case.free, case.disks)],
    }


def _particles(run: ParticleEvidence) -> dict[str, Any]:
    out: dict[str, Any] = {}
    for field in fields(run):
        value = getattr(run, field.name)
        if isinstance(value, Measured):
            value = {"value": value.value, "error": value.error}
        out[field.name] = value
    return out


def _summary(
    settings: ReportSettings, rows: Sequence[Row], checks: Sequence[Mapping[str, Any]]
) -> str:
    strict = [row for row in rows if row.kind == "statistical" and row.source == "Boltzmann-Grad"]
    agree = sum(row.verdict == "agrees" for row in strict)
    solver = [row for row in rows if row.kind == "numerical"]
    errata = [check["label"] for check in checks if check["status"] == "erratum"]
    text = (
        f"Restitution {', '.join(f'{e:g}' for e in settings.restitutions)}; "
        f"{settings.count} scatterers at number density {settings.number_density:g} per d²; "
        f"a Gaussian start; {settings.media * settings.tracers} hard-disk and "
        f"{settings.free_tracers} Boltzmann-Grad samples for each restitution. "
        f"Boltzmann-Grad particles, which sample the kinetic equation itself, agree with its "
        f"solution in {agree} of {len(strict)} comparisons"
    )
    if solver:
        right = sum(row.verdict == "agrees" for row in solver)
        text += f"; the solver meets the closed forms in {right} of {len(solver)}"
    text += f". {len(checks)} printed formulas were re-derived; "
    return text + (
        f"these do not follow as printed: {', '.join(errata)}." if errata else "all hold."
    )


def _findings(
    settings: ReportSettings, cases: Sequence[Case], scans: Scans | None, rows: Sequence[Row]
) -> list[str]:
    """What explains the differences, one sentence each, with numbers and errors."""
    out = []
    dilute = 1 / (2 * settings.number_density)
    g = contact_value(settings.number_density)
    for case in cases:
        path = case.disks.free_path
        value, error = float(path.value), float(path.error)
        out.append(
            f"e = {case.restitution:g}: hard disks have the mean free path {value:.3f} ± "
            f"{error:.3f} d, {100 * (value / dilute - 1):+.1f} ± {100 * error / dilute:.1f} % from "
            f"1/(2dρ₀) = {dilute:.4g} d (1/(2dρ₀g) = {dilute / g:.4g} d). " + _remaining(case, rows)
        )
    if scans is not None:
        limits = ", ".join(
            f"{RATIO_NAMES[name]} {number(float(limit.value), float(limit.error))}"
            for name, limit in scans.density.limits.items()
        )
        out.append(
            f"Hard disks at e = {scans.density.restitution:g} over the kinetic equation, "
            f"extrapolated to ρ₀d² = 0 from densities {scans.density.densities[0]:g} to "
            f"{scans.density.densities[-1]:g}: {limits}; 1 if the density explains all."
        )
    capped = max(max(case.free.above_cap, case.disks.above_cap) for case in cases)
    most = max(max(case.free.most_collisions, case.disks.most_collisions) for case in cases)
    out.append(
        f"Tracers are followed until the last time, without the paper's cap of {PAPER_CAP} "
        f"collisions. The most that any had is {most}; "
        + (
            f"up to {capped:.2%} had more than {PAPER_CAP}, which the cap would have cut."
            if capped
            else "the cap would have cut none."
        )
    )
    trapped = [case.disks.statuses["trapped"] for case in cases]
    if any(trapped):
        out.append(
            "Trapped in corners between two or more disks, and counted as at rest there: "
            + ", ".join(
                f"{n} of {case.disks.samples} at e = {case.restitution:g}"
                for n, case in zip(trapped, cases, strict=True)
            )
            + ". The many bounces in corners slow tracers down, and shorten the measured free path."
        )
    cooling = [case for case in cases if case.exact is not None]
    if cooling:
        out.append(
            f"The paper's h = {FITTED_COOLING_FACTOR} (1 - e): hard disks, read with l = "
            f"{dilute:.4g} d as the paper reads them, give h/(1 - e) = "
            + ", ".join(_per_inelasticity(case, case.disks.cooling_rate) for case in cooling)
            + "; Boltzmann-Grad particles, at the same times, "
            + ", ".join(_per_inelasticity(case, case.free.cooling_rate) for case in cooling)
            + "; the exact scaling state has "
            + ", ".join(
                f"{case.exact.cooling_rate / (1 - case.restitution):.4f}"
                for case in cooling
                if case.exact is not None
            )
            + "."
        )
    return out


def _per_inelasticity(case: Case, rate: Measured) -> str:
    scale = 1 - case.restitution
    return f"{float(rate.value) / scale:.3f} ± {float(rate.error) / scale:.3f}"


def _remaining(case: Case, rows: Sequence[Row]) -> str:
    """What the free path does not explain, from the rows that have it put in."""
    left = [
        row
        for row in rows
        if row.restitution == case.restitution
        and row.against == RESCALED
        and row.observable != "scaled_vdf"
    ]
    parts = [
        f"{row.observable.replace('_', ' ')} {100 * row.deviation:+.1f} ± "
        f"{100 * (row.error or 0) / scale_of(row.observable, row.theory):.1f} % ({row.verdict})"
        for row in left
    ]
    return (
        "With it put into the kinetic equation there remains, at the worst time: "
        + ", ".join(parts)
        + "."
    )
