"""Formulas for readers: text, LaTeX and presentation MathML, and what their symbols mean.

A browser shows the MathML as it is: neither a script nor a font has to be loaded.
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
