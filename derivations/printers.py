"""Formulas and checks for readers: text, LaTeX and presentation MathML; data for JSON.

A browser shows the MathML as it is: neither a script nor a font has to be loaded. Checks are those
of :mod:`derivations.checks`, which imports this.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

import sympy as sp
from sympy.core.function import AppliedUndef
from sympy.printing.mathml import MathMLPresentationPrinter

from .symbols import LATEX, table

LETTERS = {
    "v_vec": "𝐯", "v_vec_pre": "𝐯__*", "v_vec_post": "𝐯__′", "v_hat": "𝐯̂", "|v_hat|": "|𝐯̂|",
    "c_vec": "𝐜", "c_vec_pre": "𝐜__*", "r_vec": "𝐫", "l_vec": "𝐥", "sigma_hat": "σ̂",
    "nabla": "∇", "nabla_0": "∇__(0)", "nabla_1": "∇__(1)", "v.sigma > 0": "𝐯·σ̂ > 0",
    "c.sigma > 0": "𝐜·σ̂ > 0", "dt": "δt", "t'": "t__′", "v_pre": "v__*", "c'": "c__′", "p'": "p__′",
    "p_0": "p__(0)", "p_1": "p__(1)", "p_2": "p__(2)", "p_j": "p__(j)", "f_a2": "f_a₂",
    "a2_bar": "ā_2", "delta_a2": "δa_2", "pm": "±", "J_vec": "𝐉", "J_vec_0": "𝐉__(0)",
    "J_vec_1": "𝐉__(1)", "J_vec_j": "𝐉__(j)", "B_vec": "𝐁", "msd_e": "⟨r²⟩_e", "msd": "⟨r²⟩",
    "Gamma_loss": "Γ_−", "Gamma_gain": "Γ_+", "V_bar": "V̄", "V_saddle": "V__*", "g_e_tilde": "g̃_e",
    "G_tilde": "G̃", "cos_chi": "⟨cos χ⟩", "kappa_ln": "κ_ln", "w2": "w__2", "msd_N": "⟨r²⟩_N",
    "rho_4_tilde": "ρ̃_4", "F_hat": "F̂",
}  # fmt: skip
"""MathML letters where they differ from the name; ``__`` precedes a superscript."""


def plain(formula: sp.Basic | None) -> str:
    """A formula as sympy's text, with ``=`` for an equation; empty for None."""
    if formula is None:
        return ""
    if isinstance(formula, sp.Tuple):
        return "; ".join(plain(part) for part in formula)
    if isinstance(formula, sp.Eq):
        return f"{sp.sstr(formula.lhs)} = {sp.sstr(formula.rhs)}"
    return sp.sstr(formula)


def latex(formula: sp.Basic | None) -> str:
    """LaTeX of a formula without delimiters; empty for None.

    The members of a ``Tuple`` are joined by a ``\\quad``.
    """
    if formula is None:
        return ""
    if isinstance(formula, sp.Tuple):
        return r",\quad ".join(latex(part) for part in formula)
    names = {
        symbol: LATEX[symbol.name] for symbol in formula.atoms(sp.Symbol) if symbol.name in LATEX
    }
    for function in {applied.func for applied in formula.atoms(AppliedUndef)}:
        if function.__name__ in LATEX:
            formula = formula.replace(function, sp.Function(LATEX[function.__name__]))
    return sp.latex(formula, symbol_names=names).replace(r"+ \pm", r"\pm")


def mathml(formula: sp.Basic | None, order: str | None = None) -> str:
    """MathML of a formula: one ``<math>`` element, several for a ``Tuple``; empty for None.

    ``order`` of the terms of a sum is sympy's: "rev-lex" writes 1 - e^2 for -e^2 + 1.
    """
    if formula is None:
        return ""
    parts = formula if isinstance(formula, sp.Tuple) else (formula,)
    printer = _Printer({"ln_notation": True, "order": order})
    return "".join(f"<math>{printer.doprint(part)}</math>" for part in parts)


_BETWEEN_NUMBERS = re.compile(r"</mn><mo>&InvisibleTimes;</mo>(?=(?:<msup>)?<mn>)")


class _Printer(MathMLPresentationPrinter):
    """sympy's printer with the letters of this package and the formal pieces of equations."""

    def doprint(self, expr: sp.Basic) -> str:
        # sympy writes the d of a derivative as an entity that only HTML knows, and 2 times 3^x as
        # if it were 23^x
        found = super().doprint(expr).replace("&dd;", "d").replace("<mo>-<", "<mo>−<")
        return _BETWEEN_NUMBERS.sub("</mn><mo>·</mo>", found)

    def _element(self, tag: str, *parts: Any) -> Any:
        """An element around signs (given as strings), formulas and other elements."""
        element = self.dom.createElement(tag)
        for part in parts:
            if isinstance(part, str):
                sign = self.dom.createElement("mo")
                sign.appendChild(self.dom.createTextNode(part))
                element.appendChild(sign)
            else:
                element.appendChild(self._print(part) if isinstance(part, sp.Basic) else part)
        return element

    def _print_Symbol(self, symbol: sp.Symbol, style: str = "plain") -> Any:
        return super()._print_Symbol(sp.Symbol(LETTERS.get(symbol.name, symbol.name)), style)

    def _print_AppliedUndef(self, applied: AppliedUndef) -> Any:
        """T(t) with its own letter: sympy's printer would make it t(t)."""
        arguments = [part for argument in applied.args for part in (",", argument)][1:]
        return self._element("mrow", sp.Symbol(applied.func.__name__), "(", *arguments, ")")

    def _print_Int(self, integral: sp.Expr) -> Any:
        integrand, variable, *domain = integral.args
        sign = self._element("munder", "∫", *domain) if domain else "∫"
        inside = ("[", integrand, "]") if isinstance(integrand, sp.Add) else (integrand,)
        return self._element("mrow", sign, *inside, "d", variable)

    def _print_Second(self, derivative: sp.Expr) -> Any:
        function, variable, value = derivative.args
        square = self._element("msup", "∂", sp.Integer(2))
        below = self._element("mrow", "∂", variable**2)
        fraction = self._element("mfrac", self._element("mrow", square, function), below)
        at = self._element("msub", "|", sp.Eq(variable, value, evaluate=False))
        return self._element("mrow", fraction, at)

    def _print_Partial(self, derivative: sp.Expr) -> Any:
        return self._element("mfrac", *(self._element("mrow", "∂", x) for x in derivative.args))

    def _print_Dt(self, derivative: sp.Expr) -> Any:
        order = self._element("mrow", "(", derivative.args[0], ")")
        sign = self._element("msubsup", "∂", sp.Symbol("t"), order)
        return self._element("mrow", sign, derivative.args[1])

    def _print_Dot(self, product: sp.Expr) -> Any:
        return self._element("mrow", product.args[0], "·", product.args[1])

    def _print_Lam(self, applied: sp.Expr) -> Any:
        return self._element("mrow", sp.Symbol("Lambda"), *applied.args)

    def _print_Avg(self, average: sp.Expr) -> Any:
        return self._element("mrow", "⟨", *average.args, "⟩")

    def _print_Measure(self, measure: sp.Expr) -> Any:
        return self._element("mrow", "d", *measure.args)


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
_ESCAPES = str.maketrans(
    {character: f"\\{character}" for character in "{}_#%&$"}
    | {character: f"${character}$" for character in "<>|"}
    | {"\\": r"\textbackslash{}", "^": r"\^{}", "~": r"\~{}"}
)


def to_latex_document(checks: Iterable[Any]) -> str:
    """A complete LaTeX document (pdflatex; amsmath only) with every check and its steps."""
    rows = tuple(checks)
    found = {name: str(count) for name, count in counts(rows).items() if count}
    parts, section = [_PREAMBLE, _rows_of("tabular", "{lr}", found)], None
    for check in rows:
        if check.section != section:
            section = check.section
            parts.append(rf"\section*{{{section.translate(_ESCAPES)}}}")
        parts += _paragraph(check)
    meanings = {f"${latex(sp.Symbol(name))}$": meaning for name, meaning in table()}
    parts += [r"\section*{Symbols}", _rows_of("longtable", r"{lp{0.75\textwidth}}", meanings)]
    return "\n".join([*parts, r"\end{document}"]) + "\n"


def _rows_of(kind: str, columns: str, rows: dict[str, str]) -> str:
    """A table of two columns; what is in dollar signs stands as it is."""
    lines = [
        rf"{name if name[0] == '$' else name.translate(_ESCAPES)} & {value.translate(_ESCAPES)} \\"
        for name, value in rows.items()
    ]
    return "\n".join([rf"\begin{{{kind}}}{columns}", *lines, rf"\end{{{kind}}}"])


def _display(formula: sp.Basic) -> str:
    parts = formula if isinstance(formula, sp.Tuple) else (formula,)
    lines = " \\\\\n".join(f"& {latex(part)}" for part in parts)
    return "{\\small\\begin{align*}\n" + lines + "\n\\end{align*}}"


def _paragraph(check: Any) -> list[str]:
    holds = {None: "", True: ", holds", False: ", does not hold"}[check.holds]
    label, title, note = (
        text.translate(_ESCAPES) for text in (check.label, check.title, check.note)
    )
    proof = f" ({check.proof.translate(_ESCAPES)})" if check.proof else ""
    lines = [
        rf"\paragraph{{\texttt{{{label}}}: {title}}} \emph{{{check.status}{holds}}}{proof}\par"
    ]
    for name, formula in (("Printed:", check.printed), ("Derived:", check.derived)):
        if formula is not None:
            lines += [name, _display(formula)]
    if check.steps:
        lines.append(r"\begin{enumerate}")
        for step in check.steps:
            lines.append(rf"\item {step.text.translate(_ESCAPES)}")
            if step.formula is not None:
                lines.append(_display(step.formula))
        lines.append(r"\end{enumerate}")
    if check.numbers:
        values = {number.name: f"{number.value:.7g}" for number in check.numbers}
        lines.append(_rows_of("tabular", "{lr}", values) + r"\par")
    return lines + ([note + r"\par"] if note else [])
