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
        below = f"_{{{domain[0]}}}" if domain else ""
        return rf"\int{below} {integrand} \, \mathrm{{d}}{variable}"


def _formal(name: str, nargs: int, template: str, meaning: str) -> Any:
    kind: Any = type(Formal)
    return kind(name, (Formal,), dict(nargs=nargs, template=template, __doc__=meaning))


Dot = _formal("Dot", 2, r"{0} \cdot {1}", "The scalar product of two vectors: build it with `dot`.")
Partial = _formal(
    "Partial", 2, r"\frac{{\partial {0}}}{{\partial {1}}}", "The derivative of X by T."
)
Lam = _formal("Lam", 1, r"\Lambda {0}", "The collision operator Lambda applied to X.")
Dt = _formal(
    "Dt", 2, r"\partial_t^{{({0})}} {1}", "The j-th order part of the rate of change of X."
)
Avg = _formal("Avg", 1, r"\left\langle {0} \right\rangle",
    "The average of X over the scaled VDF, or over the impact parameter.")  # fmt: skip
Measure = _formal("Measure", 1, r"\mathrm{{d}}{0}", "The volume element dx, where it is a factor.")
Second = _formal("Second", 3, r"\left.\frac{{\partial^2 {0}}}{{\partial {1}^2}}\right|_{{{1}={2}}}",
    "The second derivative of X with respect to x at x = x0.")  # fmt: skip


def dot(one: sp.Expr, other: sp.Expr) -> sp.Expr:
    """The scalar product with its vectors in a fixed order, since it is symmetric.

    The gradient comes first before a flux (a divergence) and last elsewhere.
    """
    return Dot(*sorted((one, other), key=_vector_order))


def _vector_order(vector: sp.Expr) -> tuple[int, str]:
    name = str(vector)
    return (2 if name.startswith("nabla") else 3 if name.startswith("J_vec") else 1, name)


def eq(left: sp.Expr | int, right: sp.Expr | int) -> sp.Eq:
    """An equation that sympy does not try to decide."""
    return sp.Eq(left, right, evaluate=False)


def chain(*sides: sp.Expr | int) -> sp.Tuple:
    """``a = b = c`` as the equations (a = b, b = c)."""
    return sp.Tuple(*(eq(a, b) for a, b in pairwise(sides)))


def linear(expression: sp.Basic) -> sp.Basic:
    """Every ``Int`` as the sum of its terms, with its constant factors pulled out."""
    return expression.replace(lambda node: isinstance(node, Int), _expand_integral)


def _expand_integral(integral: sp.Expr) -> sp.Expr:
    variable = integral.args[1]
    total = sp.Integer(0)
    for term in sp.Add.make_args(sp.expand(integral.args[0])):
        inside = [factor for factor in sp.Mul.make_args(term) if _varies(factor, variable)]
        outside = [factor for factor in sp.Mul.make_args(term) if not _varies(factor, variable)]
        total += sp.Mul(*outside) * Int(sp.Mul(*inside), *integral.args[1:])
    return total


def _varies(factor: sp.Expr, variable: sp.Symbol) -> bool:
    """Whether a factor may depend on the variable: all vectors and speeds of one collision may."""
    if isinstance(factor, Measure):
        return factor.args[0] == variable
    symbols = factor.free_symbols
    return variable in symbols or any(
        symbol.is_real is None or symbol.name in DEPENDENT for symbol in symbols
    )


DEPENDENT = frozenset({"v_pre", "c'"})
