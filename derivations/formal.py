"""Formal pieces of equations: integrals, operators and averages that are not evaluated.

They let an operator equation be a sympy object whose every coefficient can be compared.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import sympy as sp


class Formal(sp.Function):
    """A formal function; ``template`` is the LaTeX of it, with its arguments in braces."""

    template = ""

    def _latex(self, printer: Any, exp: str | None = None) -> str:
        text = self._written(*(printer._print(arg) for arg in self.args))
        return text if exp is None else rf"\left({text}\right)^{{{exp}}}"

    def _written(self, *args: str) -> str:
        return self.template.format(*args)


class Int(Formal):
    """Int(f, x): the integral of f over all x; Int(f, x, D): over the domain D."""

    nargs = (2, 3)

    def _written(self, *args: str) -> str:
        integrand, variable, *domain = args
        if isinstance(self.args[0], sp.Add):
            integrand = rf"\left[{integrand}\right]"
        subscript = f"_{{{domain[0]}}}" if domain else ""
        return rf"\int{subscript} {integrand} \, \mathrm{{d}}{variable}"


def _formal(name: str, nargs: int, template: str, meaning: str) -> Any:
    metaclass: Any = type(Formal)
    attributes = {"nargs": nargs, "template": template, "__doc__": meaning}
    return metaclass(name, (Formal,), attributes)


Dot = _formal(
    "Dot",
    nargs=2,
    template=r"{0} \cdot {1}",
    meaning="The scalar product of two vectors: build it with `dot`.",
)
Partial = _formal(
    "Partial",
    nargs=2,
    template=r"\frac{{\partial {0}}}{{\partial {1}}}",
    meaning="The derivative of X by T.",
)
Lam = _formal(
    "Lam",
    nargs=1,
    template=r"\Lambda {0}",
    meaning="The collision operator Lambda applied to X.",
)
Dt = _formal(
    "Dt",
    nargs=2,
    template=r"\partial_t^{{({0})}} {1}",
    meaning="The j-th order part of the rate of change of X.",
)
Avg = _formal(
    "Avg",
    nargs=1,
    template=r"\left\langle {0} \right\rangle",
    meaning="The average of X over the scaled VDF, or over the impact parameter.",
)
Measure = _formal(
    "Measure",
    nargs=1,
    template=r"\mathrm{{d}}{0}",
    meaning="The volume element dx, where it is a factor.",
)
Second = _formal(
    "Second",
    nargs=3,
    template=r"\left.\frac{{\partial^2 {0}}}{{\partial {1}^2}}\right|_{{{1}={2}}}",
    meaning="The second derivative of X with respect to x at x = x0.",
)


def dot(vector: sp.Expr, factor: sp.Expr) -> sp.Expr:
    """The scalar product with its vectors in a fixed order, since it is symmetric.

    The gradient comes first before a flux (a divergence) and last elsewhere.
    """
    return Dot(*sorted((vector, factor), key=_vector_order))


def _vector_order(vector: sp.Expr) -> tuple[int, str]:
    name = str(vector)
    if name.startswith("nabla"):
        return (2, name)
    if name.startswith("J_vec"):
        return (3, name)
    return (1, name)


def eq(lhs: sp.Expr | int, rhs: sp.Expr | int) -> sp.Eq:
    """An equation that sympy does not try to decide."""
    return sp.Eq(lhs, rhs, evaluate=False)


def chain(*sides: sp.Expr | int) -> sp.Tuple:
    """``a = b = c`` as the equations (a = b, b = c)."""
    return sp.Tuple(*(eq(a, b) for a, b in pairwise(sides)))


def linear(expression: sp.Basic) -> sp.Basic:
    """Every ``Int`` as the sum of its terms, with its constant factors pulled out."""
    return expression.replace(lambda node: isinstance(node, Int), _expand_integral)


def _expand_integral(integral: sp.Expr) -> sp.Expr:
    integrand, variable, *_ = integral.args
    total = sp.Integer(0)
    for term in sp.Add.make_args(sp.expand(integrand)):
        constants: list[sp.Expr] = []
        varying: list[sp.Expr] = []
        for factor in sp.Mul.make_args(term):
            group = varying if _varies(factor, variable) else constants
            group.append(factor)
        total += sp.Mul(*constants) * Int(sp.Mul(*varying), *integral.args[1:])
    return total


def _varies(factor: sp.Expr, variable: sp.Symbol) -> bool:
    """Whether a factor may depend on the variable: all vectors and speeds of one collision may."""
    if isinstance(factor, Measure):
        return factor.args[0] == variable
    symbols = factor.free_symbols
    if variable in symbols:
        return True
    return any(symbol.is_real is None or symbol.name in DEPENDENT for symbol in symbols)


DEPENDENT = frozenset({"v_pre", "c'"})
"""The speeds that depend on the angles of a collision, by name; its vectors have no assumption."""
