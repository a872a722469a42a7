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


def plain(formula: sp.Basic | None) -> str:
    """A formula as sympy's text, with ``=`` for an equation; empty for None."""
    if formula is None:
        return ""
    if isinstance(formula, sp.Tuple):
        return "; ".join(plain(part) for part in formula)
    if isinstance(formula, sp.Eq):
        return f"{sp.sstr(formula.lhs)} = {sp.sstr(formula.rhs)}"
    return sp.sstr(formula)


def latex(formula: sp.Basic | None, **settings: Any) -> str:
    """LaTeX of a formula without delimiters; empty for None.

    The members of a ``Tuple`` are joined by a ``\\quad``; ``settings`` are those of sympy.latex.
    """
    if formula is None:
        return ""
    if isinstance(formula, sp.Tuple):
        return r",\quad ".join(latex(part, **settings) for part in formula)
    names = {
        symbol: LATEX[symbol.name] for symbol in formula.atoms(sp.Symbol) if symbol.name in LATEX
    }
    for function in {applied.func for applied in formula.atoms(AppliedUndef)}:
        if function.__name__ in LATEX:
            formula = formula.replace(function, sp.Function(LATEX[function.__name__]))
    return sp.latex(formula, symbol_names=names, **settings).replace(r"+ \pm", r"\pm")


def mathml(formula: sp.Basic | None, order: str | None = None, display: str = "inline") -> str:
    """MathML of a formula: one ``<math>`` element, several for a ``Tuple``; empty for None.

    ``order`` of the terms of a sum is sympy's: "rev-lex" writes 1 - e^2 for -e^2 + 1;
    ``display`` is "inline" or "block".
    """
    from latex2mathml.converter import convert

    parts = formula if isinstance(formula, sp.Tuple) else (() if formula is None else (formula,))
    texts = (latex(part, order=order, ln_notation=True) for part in parts)
    # an HTML page knows the namespace
    return "".join(
        convert(text, display=display).replace(f' xmlns="{NAMESPACE}"', "", 1) for text in texts
    )


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
    return {
        "label": check.label, "title": check.title, "section": check.section,
        "status": check.status.value, "proof": check.proof, "holds": check.holds,
        "note": check.note,
        "printed": plain(check.printed), "derived": plain(check.derived),
        "printed_latex": check.printed_latex, "derived_latex": check.derived_latex,
        "source_latex": check.source,
        "numbers": [{"name": number.name, "value": number.value} for number in check.numbers],
        "steps": [
            {"text": step.text, "formula": plain(step.formula), "latex": latex(step.formula)}
            for step in check.steps
        ],
    }  # fmt: skip


def to_text(check: Any) -> str:
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


_ESCAPES = str.maketrans(
    {character: f"\\{character}" for character in "{}_#%&$"}
    | {character: f"${character}$" for character in "<>|"}
    | {"\\": r"\textbackslash{}", "^": r"\^{}", "~": r"\~{}"}
)


def to_latex_document(checks: Iterable[Any]) -> str:
    """A complete LaTeX document (pdflatex; amsmath only) with every check and its steps."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    made = Environment(
        loader=PackageLoader("derivations"), undefined=StrictUndefined, trim_blocks=True,
        block_start_string="<%", block_end_string="%>", variable_start_string="<<",
        variable_end_string=">>", comment_start_string="<#", comment_end_string="#>",
    )  # fmt: skip
    made.filters |= {
        "latex": latex,
        "escaped": lambda text: text.translate(_ESCAPES),
        "parts": lambda formula: formula if isinstance(formula, sp.Tuple) else (formula,),
    }
    rows = tuple(checks)
    symbols = [(sp.Symbol(name), meaning) for name, meaning in table()]
    return made.get_template("checks.tex.j2").render(
        checks=rows, counts=counts(rows), symbols=symbols
    )
