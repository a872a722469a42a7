"""Sonine polynomials, the equation for a_2, its roots, and their stability (Appendix B)."""

from __future__ import annotations

from functools import cache

import sympy as sp

from .collision_integrals import (
    collision_moment,
    over_angle,
    sonine_average,
    speed_ratio_squared,
)
from .record import Derived, Number, Step
from .registry import derives
from .symbols import M2, M4, H, a2, a2bar, a2t, d, da2, e, p, pm, rho0, t, v0


@cache
def polynomial(order: int, x: sp.Symbol) -> sp.Expr:
    """S_N(x): orthonormal for the weight exp(-x) on x > 0 (the plane's), S_N(0) = 1.

    Built by Gram-Schmidt from 1, x, x^2, ...; nothing is typed in.
    """
    if order < 0:
        raise ValueError(f"order = {order}: a Sonine polynomial has order >= 0")

    def inner(one: sp.Expr, other: sp.Expr) -> sp.Expr:
        product = sp.Poly(sp.expand(one * other), x)
        return sum(
            (k * sp.integrate(x**i * sp.exp(-x), (x, 0, sp.oo)) for (i,), k in product.terms()),
            sp.Integer(0),
        )

    result = x**order
    for lower in range(order):
        basis = polynomial(lower, x)
        result -= inner(x**order, basis) / inner(basis, basis) * basis
    result = sp.expand(result)
    return sp.expand(result / result.subs(x, 0))


def eq(left: sp.Expr, right: sp.Expr) -> sp.Eq:
    """An equation that sympy does not try to decide."""
    return sp.Eq(left, right, evaluate=False)


def tidy(expression: sp.Expr) -> sp.Expr:
    """Factored, with e - 1 written as the paper does: through 1 - e^2."""
    for exponent in (1, -1):
        rest = sp.factor(sp.cancel(expression / (1 - e**2) ** exponent))
        if not rest.has(e - 1):
            return (1 - e**2) ** exponent * rest
    return sp.factor(expression)


def _moment_steps(order: int, symbol: sp.Symbol) -> tuple[Step, ...]:
    return (
        Step("speed ratio of one collision, squared", speed_ratio_squared()),
        Step(
            f"average of 1 - s^{order} over the impact parameter, both halves",
            eq(sp.Symbol("I_y"), over_angle(1 - speed_ratio_squared() ** (order // 2))),
        ),
        Step(
            f"average of c^{order + 1} over the Gaussian times 1 + a_2 S_2(c^2)",
            sonine_average(order + 1),
        ),
        Step("their product", eq(symbol, tidy(collision_moment(order)))),
    )


@derives("sonine9")
def _sonine9() -> Derived:
    return Derived(
        eq(M2, tidy(collision_moment(2))),
        _moment_steps(2, M2),
        "Exact in a_2; the next coefficient a_3 would add to it.",
    )


@derives("sonine10")
def _sonine10() -> Derived:
    return Derived(eq(M4, tidy(collision_moment(4))), _moment_steps(4, M4))


@cache
def stationarity() -> sp.Expr:
    """4 M_2 (1 + a_2) - M_4, from M_4 = 2 M_2 <c^4> and <c^4> of the Sonine form."""
    fourth = sonine_average(4)
    return sp.expand(2 * M2 * fourth - M4)


@derives("sonine7")
def _sonine7() -> Derived:
    return Derived(
        eq(stationarity(), sp.Integer(0)),
        (
            Step("M_4 = (M_2/2) 4 <c^4> from the moments of the scaled equation", None),
            Step("<c^4> over the Gaussian times 1 + a_2 S_2", sonine_average(4)),
        ),
    )


@cache
def quadratic() -> sp.Expr:
    """The equation for a_2, divided by its factor sqrt(pi) (1 - e^2), which vanishes at e = 1."""
    inserted = stationarity().subs({M2: collision_moment(2), M4: collision_moment(4)})
    return sp.expand(sp.cancel(inserted / (sp.sqrt(sp.pi) * (1 - e**2))))


@cache
def roots() -> tuple[sp.Expr, sp.Expr]:
    """(lower, upper) root of the equation for a_2."""
    second, first, zeroth = sp.Poly(quadratic(), a2).all_coeffs()
    square = sp.sqrt(sp.expand(64 * (first**2 - 4 * second * zeroth)))
    lower, upper = ((-8 * first + sign * square) / (16 * second) for sign in (-1, 1))
    for root in (lower, upper):
        if sp.expand(quadratic().subs(a2, root)) != 0:
            raise ArithmeticError("the quadratic formula missed the root of the a_2 equation")
    return lower, upper


def _at(expression: sp.Expr, value: float) -> float:
    return float(expression.subs(e, sp.Rational(str(value))))


@derives("sonine11")
def _sonine11() -> Derived:
    lower, upper = roots()
    mean, half = sp.expand((lower + upper) / 2), sp.expand((upper - lower) / 2)
    return Derived(
        eq(a2, mean + pm * half),
        (
            Step("the equation for a_2, less its factor sqrt(pi)(1 - e^2)", eq(quadratic(), 0)),
            Step("lower root", lower),
            Step("upper root", upper),
        ),
        "At e = 1 every a_2 solves the equation; the roots do not tend to the Gaussian's 0 there.",
        numbers=(
            Number("lower root at e = 0.9", _at(lower, 0.9)),
            Number("lower root as e -> 1", _at(lower, 1)),
            Number("upper root at e = 0.9", _at(upper, 0.9)),
        ),
    )


@cache
def growth(root: sp.Expr | None = None) -> sp.Expr:
    """d/da_2 of the right-hand side of the a_2 equation, at a root (or at a symbol)."""
    slope = sp.diff(quadratic(), a2)
    return sp.expand(slope.subs(a2, a2bar if root is None else root))


@derives("sonine12")
def _sonine12() -> Derived:
    growths = [growth(root) for root in roots()]
    stable = [
        root
        for root, rate in zip(roots(), growths, strict=True)
        if rate.subs(e, sp.Rational(9, 10)) < 0
    ]
    (chosen,) = stable
    return Derived(
        eq(a2, chosen),
        (
            Step("growth rate H at the lower root", growths[0]),
            Step("growth rate H at the upper root", growths[1]),
            Step("the root with H < 0 is the stable one", chosen),
        ),
        "The stable root of the truncated equation, but far from the exact a_2, which exists for "
        "every e, is 2 at e = 0, 0 at e = 0.5929352 and tends to -1/2 as e -> 1.",
        numbers=(
            Number("Sonine a_2 at e = 0.9", _at(chosen, 0.9)),
            Number("exact a_2 at e = 0.9", exact_a2(0.9)),
            Number("Sonine a_2 at e = 0.6", _at(chosen, 0.6)),
            Number("exact a_2 at e = 0.6", exact_a2(0.6)),
        ),
    )


def exact_a2(value: float) -> float:
    """The exact a_2 of the scaling solution at one restitution."""
    from .scaling import a2_value

    return float(a2_value(value))


@derives("ac3")
def _ac3() -> Derived:
    # (1/(d rho0 v0)) d<c^p>/dt = (p/2) M_2 <c^p> - M_p, with p = 4 and <c^4> = 2 (1 + a_2)
    rate = sp.Symbol("adot")
    fourth = sonine_average(4)
    balance = sp.diff(fourth, a2) * rate / (d * rho0 * v0(t)) - (
        p / 2 * M2 * fourth.subs(a2, a2t(t)) - M4
    ).subs(p, 4)
    (solution,) = sp.solve(balance, rate)
    return Derived(
        eq(sp.Derivative(a2t(t), t), sp.factor(solution)),
        (
            Step("moment equation of the time-dependent scaled VDF, p = 4", eq(balance, 0)),
            Step("solved for the derivative of a_2", solution),
        ),
        "M_2 and M_4 stand for their values at a_2(t).",
    )


@derives("ac5")
def _ac5() -> Derived:
    prefactor = d * rho0 * v0(t) / 2
    right = prefactor * sp.sqrt(sp.pi) * (1 - e**2) * quadratic()
    linear = sp.diff(right, a2).subs(a2, a2bar)
    scale = linear / (v0(t) * growth())
    return Derived(
        eq(sp.Derivative(da2(t), t), tidy(scale) * H * v0(t) * da2(t)),
        (
            Step("right-hand side of the equation for a_2 with M_2 and M_4 inserted", right),
            Step("its derivative at the stationary a_2", sp.factor(linear)),
            Step("H(e) collects the bracket", eq(H, growth())),
        ),
    )


@derives("ac7")
def _ac7() -> Derived:
    lower, upper = (sp.expand(growth(root)) for root in roots())
    return Derived(
        eq(H, growth()),
        (
            Step("derivative of the a_2 equation", eq(H, growth())),
            Step("at the lower root", lower),
            Step("at the upper root", upper),
        ),
        "At the two roots H is minus and plus sqrt(-383 + 828 e^2 + 900 e^4)/8: the lower root is "
        "stable and the upper one unstable for every e above the threshold, where both meet.",
        numbers=(
            Number("H at the lower root, e = 0.9", _at(lower, 0.9)),
            Number("H at the upper root, e = 0.9", _at(upper, 0.9)),
        ),
    )


@derives("compare1")
def _compare1() -> Derived:
    discriminant = sp.expand(sp.discriminant(8 * quadratic(), a2))
    square = sp.Symbol("e2", positive=True)
    (positive,) = sp.solve(discriminant.subs(e, sp.sqrt(square)), square)
    threshold = sp.sqrt(positive)
    return Derived(
        sp.Le(threshold, e, evaluate=False),
        (
            Step("discriminant of the a_2 equation", discriminant),
            Step("its only positive zero in e^2", positive),
        ),
        "A failure of the truncation, not of the gas: the exact a_2 exists for every e in [0, 1).",
        numbers=(
            Number("threshold restitution", float(threshold)),
            Number("exact a_2 at e = 0.4", exact_a2(0.4)),
        ),
    )


@derives("compare3", "compare3#2")
def _compare3() -> Derived:
    lower, _ = roots()
    inserted = sp.expand(sp.cancel(collision_moment(2) / (1 - e**2)).subs(a2, lower))
    return Derived(
        eq(M2, (1 - e**2) * inserted),
        (
            Step("M_2 at symbolic a_2", collision_moment(2)),
            Step("the stable root", eq(a2, lower)),
        ),
        "Real only above the threshold of compare1. Half of it is the Sonine cooling rate.",
        numbers=tuple(
            Number(f"M_2/2 over (1 - e) at e = {value}", _at(inserted * (1 + e) / 2, value))
            for value in (0.6, 0.7, 0.9)
        ),
    )


@cache
def sonine_cooling_rate() -> sp.Expr:
    """M_2/2 with symbolic a_2: the cooling rate of the first Sonine approximation."""
    return sp.factor(collision_moment(2) / 2)
