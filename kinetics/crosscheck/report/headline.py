"""What a reader should know after ten seconds: what was compared, and four or five findings.

The sentences stand in `../templates/headline.txt.j2`.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from kinetics.crosscheck.report.causes import Causes
from kinetics.crosscheck.report.claims import walk_of
from kinetics.crosscheck.report.figure_lines import Results, exact_states, restitutions
from kinetics.crosscheck.report.row import KINETIC, Row
from kinetics.crosscheck.report.templates import paragraphs
from kinetics.crosscheck.verdicts import Verdict

HEAD_FIGURES = ("cooling-rate", "msd-ratio")
"""The figures beside the findings, as far as a report has them."""


def headline(
    results: Results, rows: Sequence[Row], steps: Sequence[Causes],
    checks: Sequence[Mapping[str, Any]],
) -> dict[str, Any]:  # fmt: skip
    """What was "compared", the "findings" as sentences, and a "line" for the terminal."""
    settings = results.settings
    strict = [r for r in rows if r.kind == "statistical" and r.source == "Boltzmann-Grad"]
    solver = [r for r in rows if r.kind == "numerical"]
    values: dict[str, Any] = {
        "settings": settings,
        "results": results,
        "checks": checks,
        "errata": [check["label"] for check in checks if check["status"] == "erratum"],
        "strict": strict,
        "same": [r for r in strict if r.verdict is Verdict.AGREES],
        "met": [r for r in solver if r.verdict is Verdict.AGREES],
        "solver": solver,
        "within": {name: _widest(strict, name) for name in ("thermal_speed", "msd")},
        "steps": steps,
        "walks": [walk_of(case) for case in results.cooling] if steps else [],
        "highest": _highest() if steps else 0.0,
        "exact": [case.scaling_state[0].cooling_rate for case in results.cooling],
        "disks": _last(results),
        "dense": _last(results, corrected=True),
        "gaussian": [case.scaling_state[0].a2 for case in results.cooling],
        "differs": [
            r for r in rows
            if r.source == results.cases[0].hard.name and r.against == KINETIC
            and r.verdict is Verdict.DIFFERS
        ],
    }  # fmt: skip
    (compared,) = paragraphs("headline.txt.j2", "compared", **values)
    (line,) = paragraphs("headline.txt.j2", "line", **values)
    return {
        "compared": compared,
        "findings": paragraphs("headline.txt.j2", "findings", **values),
        "line": line,
    }


def _highest() -> float:
    """The largest h/(1 - e) of smooth disks."""
    return max(
        state.cooling_rate / (1 - e)
        for state, e in zip(exact_states(), restitutions().tolist(), strict=True)
    )


def _widest(rows: Sequence[Row], observable: str) -> float | None:
    """The relative difference that would have been seen at every time and restitution."""
    found = [r.within for r in rows if r.observable == observable and r.within is not None]
    return max(found, default=None)


def _last(results: Results, corrected: bool = False) -> list[float]:
    """<r^2> of hard scatterers over the equation at the last time, less 1, for each case."""
    ratios = []
    for case in results.dense_cases if corrected else results.cases:
        theory = case.dense if corrected else case.kinetic
        assert theory is not None
        ratios.append(float(case.hard.msd.value[-1] / theory.msd[-1]) - 1)
    return ratios
