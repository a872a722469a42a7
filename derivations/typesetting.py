"""A formula as text, as LaTeX and as presentation MathML, with the letters of its symbols.

A browser shows the MathML as it is: neither a script nor a font has to be loaded.
"""

from __future__ import annotations

import re
from typing import Any

import sympy as sp
from sympy.core.function import AppliedUndef
from sympy.printing.mathml import MathMLPresentationPrinter

from .symbols import LATEX

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

    def _print_Dot(self, product: sp.Expr) -> Any:
        return self._element("mrow", product.args[0], "·", product.args[1])

    def _print_Partial(self, derivative: sp.Expr) -> Any:
        above, below = (self._element("mrow", "∂", part) for part in derivative.args)
        return self._element("mfrac", above, below)

    def _print_Second(self, derivative: sp.Expr) -> Any:
        function, variable, value = derivative.args
        square = self._element("msup", "∂", sp.Integer(2))
        above = self._element("mrow", square, function)
        below = self._element("mrow", "∂", variable**2)
        at = self._element("msub", "|", sp.Eq(variable, value, evaluate=False))
        return self._element("mrow", self._element("mfrac", above, below), at)

    def _print_Dt(self, derivative: sp.Expr) -> Any:
        order = self._element("mrow", "(", derivative.args[0], ")")
        sign = self._element("msubsup", "∂", sp.Symbol("t"), order)
        return self._element("mrow", sign, derivative.args[1])

    def _print_Lam(self, applied: sp.Expr) -> Any:
        return self._element("mrow", sp.Symbol("Lambda"), *applied.args)

    def _print_Avg(self, average: sp.Expr) -> Any:
        return self._element("mrow", "⟨", *average.args, "⟩")

    def _print_Measure(self, measure: sp.Expr) -> Any:
        return self._element("mrow", "d", *measure.args)
