"""Checks for readers: a LaTeX document, JSON data, plain text."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import Any

import sympy as sp

from ..derived.record import Check, Status, latex
from ..symbols import table


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
        "printed": _text(check.printed),
        "derived": _text(check.derived),
        "printed_latex": check.printed_latex,
        "derived_latex": check.derived_latex,
        "source_latex": check.source,
        "numbers": [{"name": number.name, "value": number.value} for number in check.numbers],
        "steps": [
            {"text": step.text, "formula": _text(step.formula), "latex": latex(step.formula)}
            for step in check.steps
        ],
    }


def _text(formula: sp.Basic | None) -> str:
    return "" if formula is None else _plain(formula)


def _plain(formula: sp.Basic) -> str:
    if isinstance(formula, sp.Tuple):
        return "; ".join(_plain(part) for part in formula)
    if isinstance(formula, sp.Eq):
        return f"{sp.sstr(formula.lhs)} = {sp.sstr(formula.rhs)}"
    return sp.sstr(formula)


def to_text(check: Check) -> str:
    """One check with its steps, as plain text for a terminal."""
    lines = [f"{check.label}: {check.title} ({check.section})", f"status: {check.status}"]
    if check.proof:
        lines.append(f"proof: {check.proof}")
    if check.holds is not None:
        lines.append(f"holds in the exact theory: {'yes' if check.holds else 'no'}")
    for name, formula in (("printed", check.printed), ("derived", check.derived)):
        if formula is not None:
            lines.append(f"{name}: {_plain(formula)}")
    for index, step in enumerate(check.steps, 1):
        formula = "" if step.formula is None else f": {_plain(step.formula)}"
        lines.append(f"  {index}. {step.text}{formula}")
    lines += [f"  {number.name} = {number.value:.7g}" for number in check.numbers]
    if check.note:
        lines.append(f"note: {check.note}")
    return "\n".join(lines)


_PREAMBLE = r"""\documentclass[a4paper,10pt]{article}
\usepackage[margin=22mm]{geometry}
\usepackage{amsmath,amssymb,longtable}
\allowdisplaybreaks
\setlength{\parindent}{0pt}
\begin{document}
\title{The inelastic Lorentz gas: printed and derived}
\author{}
\date{}
\maketitle
"""
_ESCAPES = {
    "\\": r"\textbackslash{}",
    "{": r"\{",
    "}": r"\}",
    "_": r"\_",
    "^": r"\^{}",
    "#": r"\#",
    "%": r"\%",
    "&": r"\&",
    "$": r"\$",
    "~": r"\~{}",
    "<": r"$<$",
    ">": r"$>$",
    "|": r"$|$",
}


def _escape(text: str) -> str:
    return "".join(_ESCAPES.get(character, character) for character in text)


def to_latex_document(checks: Iterable[Check]) -> str:
    """A complete LaTeX document (pdflatex; amsmath only) with every check and its steps."""
    rows = tuple(checks)
    parts = [_PREAMBLE, _summary(rows)]
    section = None
    for check in rows:
        if check.section != section:
            section = check.section
            parts.append(rf"\section*{{{_escape(section)}}}")
        parts.append(_paragraph(check))
    parts += [_symbol_table(), r"\end{document}"]
    return "\n".join(parts) + "\n"


def _summary(checks: tuple[Check, ...]) -> str:
    rows = [rf"{_escape(name)} & {count} \\" for name, count in counts(checks).items() if count]
    return "\n".join([r"\begin{tabular}{lr}", *rows, r"\end{tabular}"])


def _symbol_table() -> str:
    rows = [rf"${latex(sp.Symbol(name))}$ & {_escape(meaning)} \\" for name, meaning in table()]
    head = [r"\section*{Symbols}", r"\begin{longtable}{lp{0.75\textwidth}}"]
    return "\n".join([*head, *rows, r"\end{longtable}"])


def _display(formula: sp.Basic) -> str:
    parts = formula if isinstance(formula, sp.Tuple) else (formula,)
    lines = " \\\\\n".join(f"& {latex(part)}" for part in parts)
    return "{\\small\\begin{align*}\n" + lines + "\n\\end{align*}}"


def _paragraph(check: Check) -> str:
    holds = {None: "", True: ", holds", False: ", does not hold"}[check.holds]
    lines = [
        rf"\paragraph{{\texttt{{{_escape(check.label)}}}: {_escape(check.title)}}}"
        rf" \emph{{{_escape(check.status.value)}{holds}}}"
        + (f" ({_escape(check.proof)})" if check.proof else "")
        + r"\par"
    ]
    for name, formula in (("Printed:", check.printed), ("Derived:", check.derived)):
        if formula is not None:
            lines += [name, _display(formula)]
    if check.steps:
        lines.append(r"\begin{enumerate}")
        for step in check.steps:
            lines.append(rf"\item {_escape(step.text)}")
            if step.formula is not None:
                lines.append(_display(step.formula))
        lines.append(r"\end{enumerate}")
    if check.numbers:
        lines.append(r"\begin{tabular}{lr}")
        lines += [rf"{_escape(n.name)} & {n.value:.7g} \\" for n in check.numbers]
        lines.append(r"\end{tabular}\par")
    if check.note:
        lines.append(_escape(check.note) + r"\par")
    return "\n".join(lines)
