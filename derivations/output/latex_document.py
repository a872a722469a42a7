"""Checks as a LaTeX document."""

from __future__ import annotations

from collections.abc import Iterable

import sympy as sp

from ..symbols import table
from ..typesetting import latex
from ..verdicts import Check
from .text import counts

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
