"""Printed against derived: is the difference an exact symbolic zero?"""

from __future__ import annotations

import sympy as sp

from .formal import Formal, linear
from .symbols import pm


def residuals(formula: sp.Basic) -> list[sp.Expr]:
    """The expressions that a formula states to be zero (for an inequality: its two sides apart)."""
    if isinstance(formula, sp.Tuple):
        return [part for member in formula for part in residuals(member)]
    if isinstance(formula, sp.Eq):
        return [formula.lhs - formula.rhs]
    if isinstance(formula, sp.core.relational.Relational):
        return [formula.lhs, formula.rhs]
    return [formula]


def is_zero(expression: sp.Expr) -> bool:
    """Whether a difference is exactly zero; tries the cheap simplifications first."""
    if expression == 0:
        return True
    if pm in expression.free_symbols:
        return all(is_zero(expression.subs(pm, branch)) for branch in (1, -1))
    expanded = sp.expand(linear(expression))
    if expanded == 0:
        return True
    if _clearly_nonzero(expanded):
        return False
    for simplification in (sp.cancel, sp.radsimp, sp.simplify):
        if simplification(expanded) == 0:
            return True
    return False


def _clearly_nonzero(expression: sp.Expr) -> bool:
    """A value that is far from zero at a generic point spares the slow simplifications."""
    opaque = expression.atoms(
        sp.Symbol, sp.Derivative, sp.Integral, sp.Sum, Formal, sp.core.function.AppliedUndef
    )
    outer = sorted(opaque, key=lambda a: (-a.count_ops(), sp.default_sort_key(a)))
    value = expression
    for index, atom in enumerate(outer):
        value = value.xreplace({atom: sp.Rational(7 * index + 11, 5 * index + 17)})
    try:
        number = complex(value.evalf(30))
    except (TypeError, ValueError):
        return False
    return abs(number) > 1e-15


def agree(printed: sp.Basic, derived: sp.Basic) -> bool:
    """Whether the two state the same: same kind, and every pair of residuals differs by zero."""
    if isinstance(printed, sp.core.relational.Relational) and printed.func is not derived.func:
        return False
    ours, theirs = residuals(derived), residuals(printed)
    return len(ours) == len(theirs) and all(
        is_zero(one - other) for one, other in zip(ours, theirs, strict=True)
    )
