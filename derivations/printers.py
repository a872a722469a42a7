"""Formulas and checks for readers: text, LaTeX and presentation MathML; data for JSON.

A browser shows the MathML as it is: neither a script nor a font has to be loaded. Checks are those
of :mod:`derivations.checks`, which imports this.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import sympy as sp
from sympy.core.function import AppliedUndef

from .symbols import LATEX, table

NAMESPACE = "http://www.w3.org/1998/Math/MathML"


def members(formula: sp.Basic | None) -> tuple[sp.Basic, ...]:
    """The equations of a ``Tuple``, or the formula alone; nothing for None."""
    if formula is None:
        return ()
    if isinstance(formula, sp.Tuple):
        return formula.args
    return (formula,)


def plain(formula: sp.Basic | None) -> str:
    """A formula as sympy's text, with ``=`` for an equation; empty for None."""
    return "; ".join(_plain_member(member) for member in members(formula))


def _plain_member(formula: sp.Basic) -> str:
    if isinstance(formula, sp.Eq):
        return f"{sp.sstr(formula.lhs)} = {sp.sstr(formula.rhs)}"
    return sp.sstr(formula)


def latex(formula: sp.Basic | None, **settings: Any) -> str:
    """LaTeX of a formula without delimiters; empty for None.

    The members of a ``Tuple`` are joined by a ``\\quad``; ``settings`` are those of sympy.latex.
    """
    return r",\quad ".join(_latex_member(member, settings) for member in members(formula))


def _latex_member(formula: sp.Basic, settings: dict[str, Any]) -> str:
    symbols = formula.atoms(sp.Symbol)
    names = {symbol: LATEX[symbol.name] for symbol in symbols if symbol.name in LATEX}
    functions = {applied.func for applied in formula.atoms(AppliedUndef)}
    for function in functions:
        if function.__name__ in LATEX:
            formula = formula.replace(function, sp.Function(LATEX[function.__name__]))
    text = sp.latex(formula, symbol_names=names, **settings)
    return text.replace(r"+ \pm", r"\pm")


def mathml(formula: sp.Basic | None, order: str | None = None, display: str = "inline") -> str:
    """MathML of a formula: one ``<math>`` element, several for a ``Tuple``; empty for None.

    ``order`` of the terms of a sum is sympy's: "rev-lex" writes 1 - e^2 for -e^2 + 1;
    ``display`` is "inline" or "block".
    """
    from latex2mathml.converter import convert

    elements = []
    for member in members(formula):
        text = latex(member, order=order, ln_notation=True)
        element = convert(text, display=display)
        # an HTML page knows the namespace
        elements.append(element.replace(f' xmlns="{NAMESPACE}"', "", 1))
    return "".join(elements)


def symbol_meanings(formulas: Iterable[sp.Basic | None]) -> list[tuple[str, str]]:
    """Name and meaning of every symbol and function in some formulas, sorted by name."""
    names: set[str] = set()
    for formula in formulas:
        if formula is not None:
            names |= {symbol.name for symbol in formula.atoms(sp.Symbol)}
            names |= {applied.func.__name__ for applied in formula.atoms(AppliedUndef)}
    return [(name, meaning) for name, meaning in table() if name in names]


def counts(checks: Iterable[Any]) -> dict[str, int]:
    """How many rows have each status, in the order of :class:`Status`; absent ones are zero."""
    from .derived.record import Status

    statuses = [check.status for check in checks]
    return {status.value: statuses.count(status) for status in Status}


def to_json(checks: Iterable[Any]) -> dict[str, Any]:
    """The checks as data that ``json.dumps`` takes: ``{"counts": {status: n}, "checks": [...]}``.

    Formulas come twice: as sympy text (``printed``, ``derived``) and as LaTeX.
    """
    rows = tuple(checks)
    return {"counts": counts(rows), "checks": [_row(row) for row in rows]}


def _row(check: Any) -> dict[str, Any]:
    numbers = [{"name": number.name, "value": number.value} for number in check.numbers]
    return {
        "label": check.label,
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


def _step(step: Any) -> dict[str, str]:
    return {"text": step.text, "formula": plain(step.formula), "latex": latex(step.formula)}


def to_text(check: Any) -> str:
    """One check with its steps, as plain text for a terminal."""
    lines = [f"{check.label}: {check.title} ({check.section})", f"status: {check.status}"]
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


def _step_text(step: Any) -> str:
    if step.formula is None:
        return step.text
    return f"{step.text}: {plain(step.formula)}"


_ESCAPES = str.maketrans(
    {character: f"\\{character}" for character in "{}_#%&$"}
    | {character: f"${character}$" for character in "<>|"}
    | {"\\": r"\textbackslash{}", "^": r"\^{}", "~": r"\~{}"}
)


def to_latex_document(checks: Iterable[Any]) -> str:
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
