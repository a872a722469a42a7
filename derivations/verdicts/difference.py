"""Printed against derived: is the difference an exact symbolic zero?

A difference that sympy cannot simplify to zero is not held against the paper for that: it counts
as different only where it has a value that is not zero, and as zero, with the reason stated, where
it vanishes at 50 digits at 20 random points. What cannot be decided is called that.
"""

from __future__ import annotations

import random
from collections.abc import Iterable
from enum import Enum
from functools import lru_cache

import sympy as sp
from sympy.core.function import AppliedUndef
from sympy.core.relational import Relational

from .. import symbols as s
from ..formal import Formal, linear

POINTS, DIGITS = 20, 50
OPAQUE = (sp.Symbol, sp.Derivative, sp.Integral, sp.Sum, sp.KroneckerDelta, Formal, AppliedUndef)


class Difference(Enum):
    """How two formulas differ; the order is that of the worst member of several."""

    NONE = 0
    NONE_NUMERICALLY = 1
    UNDECIDED = 2
    PRESENT = 3


def residuals(formula: sp.Basic) -> list[sp.Expr]:
    """The expressions that a formula states to be zero (for an inequality: its two sides apart)."""
    if isinstance(formula, sp.Tuple):
        return [part for member in formula for part in residuals(member)]
    if isinstance(formula, sp.Eq):
        return [formula.lhs - formula.rhs]
    if isinstance(formula, Relational):
        return [formula.lhs, formula.rhs]
    return [formula]


def judge(expression: sp.Expr) -> Difference:
    """Whether an expression is zero; the cheap simplifications come first."""
    if expression == 0:
        return Difference.NONE
    if s.pm in expression.free_symbols:
        return _worst(judge(expression.subs(s.pm, branch)) for branch in (1, -1))
    expanded = sp.expand(linear(expression))
    if expanded == 0:
        return Difference.NONE
    # a value far from zero at one generic point spares the slow simplifications
    if any(_large(value, 1e-15) for value in _values(expanded, points=1, digits=30)):
        return Difference.PRESENT
    for simplification in (sp.cancel, sp.radsimp, sp.simplify):
        if simplification(expanded) == 0:
            return Difference.NONE
    values = _values(expanded, POINTS, DIGITS + 10)
    if len(values) < POINTS:
        return Difference.UNDECIDED
    limit = sp.Float(10, DIGITS) ** -DIGITS
    different = any(_large(value, limit) for value in values)
    return Difference.PRESENT if different else Difference.NONE_NUMERICALLY


def _large(value: sp.Expr, limit: float | sp.Float) -> bool:
    return value.is_infinite or bool(abs(value) > limit)


def is_zero(expression: sp.Expr) -> bool:
    """Whether an expression is exactly zero."""
    return judge(expression) is Difference.NONE


def _values(expression: sp.Expr, points: int, digits: int) -> list[sp.Expr]:
    """The expression at random points; its formal parts count as independent variables.

    Infinite where it diverges; fewer values where it has none. Kronecker's delta, which vanishes
    almost everywhere, counts as a formal part.
    """
    opaque = expression.atoms(*OPAQUE)
    outer = sorted(opaque, key=lambda part: (-part.count_ops(), sp.default_sort_key(part)))
    stream = random.Random(20240607)
    values = []
    for _ in range(points):
        value = expression
        for part in outer:
            value = value.xreplace({part: sp.Rational(stream.randint(100, 899), 1000)})
        number = value.evalf(digits)
        digits_found = all(part.is_Float or part.is_Integer for part in number.as_real_imag())
        if number.is_infinite or digits_found:
            values.append(number)
    return values


@lru_cache(maxsize=512)
def compare(printed: sp.Basic, derived: sp.Basic) -> Difference:
    """How far two formulas state the same: same kind, and zero difference of every residual."""
    if isinstance(printed, Relational) and printed.func is not derived.func:
        return Difference.PRESENT
    ours, theirs = residuals(derived), residuals(printed)
    if len(ours) != len(theirs):
        return Difference.PRESENT
    return _worst(judge(one - other) for one, other in zip(ours, theirs, strict=True))


def _worst(differences: Iterable[Difference]) -> Difference:
    return max(differences, key=lambda difference: difference.value)
