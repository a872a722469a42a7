"""Checks for readers: plain text, data for JSON, and a LaTeX document.

Begin reading with ``to_text``. Formulas are printed by :mod:`derivations.printers`.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import sympy as sp

from .checks import Check
from .derived.record import Status, Step
from .printers import latex, members, plain, symbol_meanings


def counts(checks: Iterable[Check]) -> dict[str, int]:
    """How many rows have each status, in the order of :class:`Status`; absent ones are zero."""
    statuses = [check.status for check in checks]
    return {status.value: statuses.count(status) for status in Status}


def to_json(checks: Iterable[Check]) -> dict[str, Any]:
    """The checks as data that ``json.dumps`` takes: ``{"counts": {status: n}, "checks": [...]}``.

    Formulas come twice: as sympy text (``printed``, ``derived``) and as LaTeX.
    """
    rows = tuple(checks)
    return {"counts": counts(rows), "checks": [_row(row) for row in rows]}


def _row(check: Check) -> dict[str, Any]:
    numbers = [{"name": number.name, "value": number.value} for number in check.numbers]
    return {
        "label": check.label,
        "number": check.number,
        "title": check.title,
        "section": check.section,
        "status": check.status.value,
        "proof": check.proof,
        "holds": check.holds,
        "verdict": None if check.verdict is None else check.verdict.value,
        "note": check.note,
        "printed": plain(check.printed),
        "derived": plain(check.derived),
        "printed_latex": check.printed_latex,
        "derived_latex": check.derived_latex,
        "source_latex": check.source,
        "numbers": numbers,
        "steps": [_step(step) for step in check.steps],
    }


def _step(step: Step) -> dict[str, str]:
    return {"text": step.text, "formula": plain(step.formula), "latex": latex(step.formula)}


def to_text(check: Check) -> str:
    """One check with its steps, as plain text for a terminal."""
    name = f"eq. ({check.number}) {check.label}" if check.number else check.label
    lines = [f"{name}: {check.title} ({check.section})", f"status: {check.status}"]
    if check.proof:
        lines.append(f"proof: {check.proof}")
    if check.verdict is not None:
        lines.append(f"verdict of the exact theory: {check.verdict}")
    if check.printed is not None:
        lines.append(f"printed: {plain(check.printed)}")
    if check.derived is not None:
        lines.append(f"derived: {plain(check.derived)}")
    for index, step in enumerate(check.steps, 1):
        lines.append(f"  {index}. {_step_text(step)}")
    for number in check.numbers:
        lines.append(f"  {number.name} = {number.value:.7g}")
    if check.note:
        lines.append(f"note: {check.note}")
    return "\n".join(lines)


def _step_text(step: Step) -> str:
    if step.formula is None:
        return step.text
    return f"{step.text}: {plain(step.formula)}"


_ESCAPES = str.maketrans(
    {character: f"\\{character}" for character in "{}_#%&$"}
    | {character: f"${character}$" for character in "<>|"}
    | {"\\": r"\textbackslash{}", "^": r"\^{}", "~": r"\~{}"}
)


def to_latex_document(checks: Iterable[Check]) -> str:
    """A complete LaTeX document (pdflatex; amsmath only) with every check and its steps.

    It ends with the symbols that these checks and their steps contain, and no others.
    """
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("derivations"),
        undefined=StrictUndefined,
        trim_blocks=True,
        block_start_string="<%",
        block_end_string="%>",
        variable_start_string="<<",
        variable_end_string=">>",
        comment_start_string="<#",
        comment_end_string="#>",
    )
    environment.filters["latex"] = latex
    environment.filters["escaped"] = _escape
    environment.filters["members"] = members
    rows = tuple(checks)
    formulas: list[sp.Basic | None] = []
    for check in rows:
        formulas += [check.printed, check.derived]
        formulas += [step.formula for step in check.steps]
    symbols = [(sp.Symbol(name), meaning) for name, meaning in symbol_meanings(formulas)]
    template = environment.get_template("checks.tex.j2")
    return template.render(checks=rows, counts=counts(rows), symbols=symbols)


def _escape(text: str) -> str:
    return text.translate(_ESCAPES)
