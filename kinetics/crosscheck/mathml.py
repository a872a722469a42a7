"""Presentation MathML of the derivations' formulas, with the names that their symbols stand for."""

from typing import Any

from sympy import Symbol, Tuple
from sympy.core.function import AppliedUndef
from sympy.printing.mathml import MathMLPresentationPrinter

NAMES = {
    r"\bar{a}_2": "ā_2",
    r"\delta a_2": "δa_2",
    r"\langle r^{2}\rangle_{e}": "⟨r²⟩_e",
    "pm": "±",
}
"""What symbols whose name is LaTeX, or a word, are printed as."""


class _Printer(MathMLPresentationPrinter):
    def _print_Symbol(self, symbol: Symbol, style: str = "plain") -> Any:
        return super()._print_Symbol(Symbol(NAMES.get(symbol.name, symbol.name)), style)

    def _print_AppliedUndef(self, applied: AppliedUndef) -> Any:
        """T(t) with its own letter: sympy's printer would make it t(t)."""
        row = self.dom.createElement("mrow")
        row.appendChild(self._print(Symbol(applied.func.__name__)))
        for i, argument in enumerate(applied.args):
            row.appendChild(self._sign("," if i else "("))
            row.appendChild(self._print(argument))
        row.appendChild(self._sign(")"))
        return row

    def _sign(self, text: str) -> Any:
        sign = self.dom.createElement("mo")
        sign.appendChild(self.dom.createTextNode(text))
        return sign


def mathml(formula: Any) -> str:
    """One `<math>` element per formula (a Tuple holds several), "" for None."""
    if formula is None:
        return ""
    parts = list(formula) if isinstance(formula, Tuple) else [formula]
    return "".join(f"<math>{_Printer().doprint(part)}</math>" for part in parts)
