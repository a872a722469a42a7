"""Checks as plain text for a terminal, and as data that ``json.dumps`` takes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import Any

from ..derived.record import Status
from ..typesetting import latex, plain
from ..verdicts import Check


def to_json(checks: Iterable[Check]) -> dict[str, Any]:
    """The checks as data that ``json.dumps`` takes: ``{"counts": {status: n}, "checks": [...]}``.

    Formulas come twice: as sympy text (``printed``, ``derived``) and as LaTeX.
    """
    rows = tuple(checks)
    return {"counts": counts(rows), "checks": [_row(row) for row in rows]}


def counts(checks: Iterable[Check]) -> dict[str, int]:
    """How many rows have each status, in the order of :class:`Status`; absent ones are zero."""
    found = Counter(check.status for check in checks)
    return {status.value: found[status] for status in Status}


def _row(check: Check) -> dict[str, Any]:
    return {
        "label": check.label,
        "title": check.title,
        "section": check.section,
        "status": check.status.value,
        "proof": check.proof,
        "holds": check.holds,
        "note": check.note,
        "printed": plain(check.printed),
        "derived": plain(check.derived),
        "printed_latex": check.printed_latex,
        "derived_latex": check.derived_latex,
        "source_latex": check.source,
        "numbers": [{"name": number.name, "value": number.value} for number in check.numbers],
        "steps": [
            {"text": step.text, "formula": plain(step.formula), "latex": latex(step.formula)}
            for step in check.steps
        ],
    }


def to_text(check: Check) -> str:
    """One check with its steps, as plain text for a terminal."""
    lines = [f"{check.label}: {check.title} ({check.section})", f"status: {check.status}"]
    if check.proof:
        lines.append(f"proof: {check.proof}")
    if check.holds is not None:
        lines.append(f"holds in the exact theory: {'yes' if check.holds else 'no'}")
    for name, formula in (("printed", check.printed), ("derived", check.derived)):
        if formula is not None:
            lines.append(f"{name}: {plain(formula)}")
    for index, step in enumerate(check.steps, 1):
        formula = "" if step.formula is None else f": {plain(step.formula)}"
        lines.append(f"  {index}. {step.text}{formula}")
    lines += [f"  {number.name} = {number.value:.7g}" for number in check.numbers]
    if check.note:
        lines.append(f"note: {check.note}")
    return "\n".join(lines)
