"""Time dependence and stability of the Sonine a_2 (Appendix B, second part)."""

from __future__ import annotations

import sympy as sp

from .. import symbols as s
from ..formal import Avg, Partial, eq
from .cooling import speed_equation_by_moment
from .quadrature_values import a2_value
from .record import Derived, Number, Step, defines, derives, numbers_at, result
from .sonine import at_restitution, collision_moment, growth, quadratic, roots, sonine_average, tidy

_V0 = s.v0(s.t)

defines(
    {
        "ac1": "General: any f can be written so, with <c^2> = 1 at all times.",
        "ac4": "Defines the perturbation.",
    }
)


def _moment_balance(order: sp.Expr, moment: sp.Expr, rate: sp.Expr, loss: sp.Expr) -> sp.Expr:
    """d<v^p>/dt + loss, with <v^p> = v0^p <c^p>, over d rho0 v0^(p+1)."""
    slope = speed_equation_by_moment()
    product = _V0**order * rate + order * _V0 ** (order - 1) * slope * moment
    return sp.expand(sp.simplify(product / (s.d * s.rho0 * _V0 ** (order + 1)))) + loss


@derives("ac2")
def _ac2() -> Derived:
    balance = _moment_balance(s.p, Avg(s.c**s.p), Partial(Avg(s.c**s.p), s.t), s.Mp)
    return result(
        eq(balance, sp.Integer(0)),
        Step("rate of v0", speed_equation_by_moment()),
        Step("d<v^p>/dt with <v^p> = v0^p <c^p>, over d rho0 v0^(p+1)", balance),
    )


@derives("ac3")
def _ac3() -> Derived:
    rate = sp.Symbol("adot")
    fourth = sonine_average(4)
    balance = _moment_balance(
        sp.Integer(4), fourth.subs(s.a2, s.a2t(s.t)), sp.diff(fourth, s.a2) * rate, s.M4
    )
    (solution,) = sp.solve(balance, rate)
    return result(
        eq(sp.Derivative(s.a2t(s.t), s.t), sp.factor(solution)),
        Step("moment equation of the time-dependent scaled VDF, p = 4", eq(balance, 0)),
        Step("solved for the derivative of a_2", solution),
        note="M_2 and M_4 stand for their values at a_2(t).",
    )


@derives("ac5")
def _ac5() -> Derived:
    prefactor = s.d * s.rho0 * _V0 / 2
    right = prefactor * sp.sqrt(sp.pi) * (1 - s.e**2) * quadratic()
    linear = sp.diff(right, s.a2).subs(s.a2, s.a2bar)
    scale = linear / (_V0 * growth())
    return result(
        eq(sp.Derivative(s.da2(s.t), s.t), tidy(scale) * s.H * _V0 * s.da2(s.t)),
        Step("right-hand side of the equation for a_2 with M_2 and M_4 inserted", right),
        Step("its derivative at the stationary a_2", sp.factor(linear)),
        Step("H(e) collects the bracket", eq(s.H, growth())),
    )


@derives("ac7")
def _ac7() -> Derived:
    lower, upper = (sp.expand(growth(root)) for root in roots())
    return result(
        eq(s.H, growth()),
        Step("derivative of the a_2 equation", eq(s.H, growth())),
        Step("at the lower root", lower),
        Step("at the upper root", upper),
        note="At the two roots H is minus and plus sqrt(-383 + 828 e^2 + 900 e^4)/8: the lower "
        "root is stable and the upper one unstable for every e above the threshold, where both "
        "meet.",
        numbers=(
            Number("H at the lower root, e = 0.9", at_restitution(lower, 0.9)),
            Number("H at the upper root, e = 0.9", at_restitution(upper, 0.9)),
        ),
    )


@derives("ac6")
def _ac6() -> Derived:
    rate = s.d * s.rho0 / 2 * sp.sqrt(sp.pi) * (1 - s.e**2) * s.H
    # d(delta)/delta = rate v0 dt: the logarithm is rate times the integral of v0
    grown = s.da2(0) * sp.exp(rate * sp.Integral(_V0, (s.t, 0, s.t)))
    path = sp.Function("path")
    form = grown.subs(sp.Integral(_V0, (s.t, 0, s.t)), path(s.t))
    residual = sp.diff(form, s.t).subs(sp.Derivative(path(s.t), s.t), _V0) - rate * _V0 * form
    if sp.simplify(residual) != 0:
        raise ArithmeticError("the exponential does not solve the linear equation")
    return result(
        eq(s.da2(s.t), grown),
        Step("ac5 divided by the perturbation and integrated", grown),
        note="With v0 = 1/(alpha + beta t) it is a power of time: exponent sqrt(pi)(1 - e^2) H/(2 "
        "h). The integration variable is printed as t.",
    )


@derives("compare1")
def _compare1() -> Derived:
    discriminant = sp.expand(sp.discriminant(8 * quadratic(), s.a2))
    square = sp.Symbol("e2", positive=True)
    (positive,) = sp.solve(discriminant.subs(s.e, sp.sqrt(square)), square)
    if discriminant.subs(s.e, 1) <= 0:
        raise ArithmeticError("the roots are not real above the threshold")
    threshold = sp.sqrt(positive)
    return result(
        sp.Le(threshold, s.e, evaluate=False),
        Step("discriminant of the a_2 equation", discriminant),
        Step("its only positive zero in e^2", positive),
        note="A failure of the truncation, not of the gas: the exact a_2 exists for every e in [0, "
        "1).",
        numbers=(
            Number("threshold restitution", float(threshold)),
            Number("exact a_2 at e = 0.4", float(a2_value(0.4))),
        ),
    )


@derives("compare3", "compare3#2")
def _compare3() -> Derived:
    lower, _ = roots()
    inserted = sp.expand(sp.cancel(collision_moment(2) / (1 - s.e**2)).subs(s.a2, lower))

    def ratio(e: float) -> float:
        return at_restitution(inserted * (1 + s.e) / 2, e)

    return result(
        eq(s.M2, (1 - s.e**2) * inserted),
        Step("M_2 at symbolic a_2", collision_moment(2)),
        Step("the stable root", eq(s.a2, lower)),
        note="Real only above the threshold of compare1. Half of it is the Sonine cooling rate.",
        numbers=numbers_at((0.6, 0.7, 0.9), {"M_2/2 over (1 - e) at e = {e}": ratio}),
    )
