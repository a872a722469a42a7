"""The diffusion coefficient at one speed (Appendix D), and where its argument breaks."""

from __future__ import annotations

from functools import cache

import sympy as sp

from .. import symbols as s
from ..formal import Dt, Int, Lam, Partial, chain, dot, eq
from ..premises import over_angle, parallel_component, speed_ratio_squared
from .chapman_enskog import continuity_order, density_series, isotropy
from .record import Derived, Number, Status, Step, definition
from .registry import derives

_N = s.nd(s.br, s.v, s.t)
_P0, _P1 = s.p0(s.br, s.bv, s.t), s.p1(s.br, s.bv, s.t)
_B = s.Bv(s.bv, s.T(s.t))
_SHELL = s.delta(s.vh - 1)
_COOLING = s.v0(s.t) / s.l * s.h


@derives("ap1")
def _ap1() -> Derived:
    # dv = v dv dphi: the sum over directions is n(r, v, t), that over speeds carries the factor v
    density = s.v * (sp.Derivative(_N, s.t) + dot(s.nabla, s.J(s.br, s.v, s.t)))
    return Derived(
        eq(Int(density, s.v), sp.Integer(0)),
        (
            Step("integral of the kinetic equation over v in polar form", Int(density, s.v)),
            Step("the collision operator keeps mass", sp.Integer(0)),
        ),
        "Harmless: the printed factor 2 pi does not belong with ap2, whose n(r, v, t) is already "
        "summed over directions; since the other side is zero it changes nothing.",
        numbers=(Number("factor printed over derived", float(2 * sp.pi)),),
    )


@derives("ap2")
def _ap2() -> Derived:
    return definition("Summed over directions, not averaged: 2 pi p for an isotropic p.")


@derives("ap3")
def _ap3() -> Derived:
    return definition("The flux at one speed.")


@derives("ap4")
def _ap4() -> Derived:
    leak = Int(Lam(s.pd(s.br, s.v * s.bvh, s.t)) * _SHELL, s.bvh)
    loss = over_angle(1 - speed_ratio_squared()) / 2
    return Derived(
        eq(sp.Derivative(_N, s.t) + dot(s.nabla, s.J(s.br, s.v, s.t)), leak),
        (
            Step("the kinetic equation at one speed, summed over directions", leak),
            Step("collisions change the speed: E[1 - s^2]", loss),
        ),
        "That the integral over v vanishes does not make the integrand vanish. Collisions move "
        "tracers from one speed to another; the right-hand side is zero only at e = 1. With it "
        "the speed-resolved expansion of this appendix loses its ground for e < 1.",
        numbers=(
            Number("energy exchanged per collision at e = 0.9", float(loss.subs(s.e, 0.9))),
            Number("energy exchanged per collision at e = 0.4", float(loss.subs(s.e, 0.4))),
        ),
    )


@derives("ap6")
def _ap6() -> Derived:
    return Derived(
        eq(sp.Derivative(_N, s.t), density_series(_N)),
        (Step("each order of the gradient carries at least one factor of epsilon", None),),
        "Rests on ap4.",
    )


@derives("ap7")
def _ap7() -> Derived:
    return continuity_order(s.Jj(s.br, s.v, s.t), _N)


@derives("ap8")
def _ap8() -> Derived:
    velocity = s.v * s.bvh
    return Derived(
        eq(s.Jj(s.br, s.v, s.t), Int(velocity * s.pj(s.br, velocity, s.t) * _SHELL, s.bvh)),
        (Step("order epsilon^j of ap3, v = |v| times its direction", velocity),),
    )


@derives("ap11")
def _ap11() -> Derived:
    return Derived(
        None,
        note="The factor n(r, v, t)/m(v, t) depends on the speed. The collision operator mixes "
        "speeds, so that its product with f solves the zeroth order only at e = 1, or where the "
        "factor does not depend on the speed (which is diffuse11 again).",
        status=Status.ASSUMPTION,
        holds=False,
    )


@derives("ap11.5")
def _ap11_5() -> Derived:
    return definition("f summed over directions.")


@derives("ap11.6")
def _ap11_6() -> Derived:
    angle = sp.Symbol("angle", real=True)
    mean = sp.integrate(sp.cos(angle), (angle, 0, 2 * sp.pi))
    ratio = _N / s.mn(s.v, s.t)
    return Derived(
        chain(
            s.J0(s.br, s.v, s.t),
            s.v * ratio * Int(s.bvh * s.f(s.v * s.bvh, s.t) * _SHELL, s.bvh),
            mean,
        ),
        (
            Step(
                "ap8 with p^(0) = n f/m",
                s.v * ratio * Int(s.bvh * s.f(s.v * s.bvh, s.t) * _SHELL, s.bvh),
            ),
            Step("sum of the direction over the circle, f being isotropic", mean),
        ),
    )


@cache
def _orders_at_one_speed() -> sp.Eq:
    """Order 1 of the kinetic equation with n(r, v, t)."""
    rate = s.eps * Dt(0, _N)
    left = sp.expand(
        sum(
            s.eps**order
            * (rate * Partial(q, _N) + sp.Derivative(s.T(s.t), s.t) * Partial(q, s.T(s.t)))
            for order, q in enumerate((_P0, _P1))
        )
        + s.eps * dot(s.bv, s.nabla0) * _N * Partial(_P0, _N)
    )
    return eq(left.coeff(s.eps, 1), Lam(_P1))


@derives("ap12")
def _ap12() -> Derived:
    return Derived(
        _orders_at_one_speed(),
        (Step("order epsilon^1 of the kinetic equation", _orders_at_one_speed()),),
        "Formally right, given ap4 and ap11.",
    )


@derives("ap12.5")
def _ap12_5() -> Derived:
    path = sp.Symbol("path", positive=True)
    (density,) = sp.solve(path - 1 / (2 * s.d * s.rho0), s.rho0)
    rate = (-2 * s.d * s.v0(s.t) * s.rho0 * s.h * s.T(s.t)).subs(s.rho0, density).subs(path, s.l)
    return Derived(
        eq(sp.Derivative(s.T(s.t), s.t), rate),
        (Step("l = 1/(2 d rho0) in tdiff", rate),),
    )


@cache
def _first_order() -> sp.Eq:
    slope = s.f(s.bv, s.t) / s.mn(s.v, s.t)
    known = {
        Dt(0, _N): sp.Integer(0),
        sp.Derivative(s.T(s.t), s.t): -_COOLING * s.T(s.t),
        Partial(_P0, _N): slope,
    }
    residual = (_orders_at_one_speed().lhs - _orders_at_one_speed().rhs).subs(known)
    source = residual.subs({Lam(_P1): 0, Partial(_P1, s.T(s.t)): 0})
    return eq(sp.expand(source - residual), source)


@derives("ap13")
def _ap13() -> Derived:
    return Derived(
        _first_order(),
        (Step("zeroth order and cooling inserted", _first_order()),),
        "Formally right, given ap4 and ap11.",
    )


@derives("ap14")
def _ap14() -> Derived:
    return Derived(
        None,
        note="At e = 1 it holds. For e < 1 the source at one speed drives p^(1) at lower speeds, "
        "and p^(1)(v) depends on the gradient of n at other speeds too.",
        status=Status.ASSUMPTION,
        holds=False,
    )


@cache
def _b_equation() -> sp.Eq:
    left = _COOLING * s.T(s.t) * Partial(_B, s.T(s.t)) + Lam(_B)
    inserted = _first_order().lhs.subs(
        {Lam(_P1): Lam(_B) * _N, Partial(_P1, s.T(s.t)): Partial(_B, s.T(s.t)) * _N}
    )
    if sp.expand(inserted / _N - left) != 0:
        raise ArithmeticError("p^(1) = B.grad n does not give the equation for B")
    source = sp.cancel(_first_order().rhs / (dot(s.bv, s.nabla0) * _N)) * s.bv
    return eq(sp.expand(inserted / _N), source)


@derives("ap15")
def _ap15() -> Derived:
    return Derived(
        _b_equation(),
        (Step("p^(1) = B.grad n inserted, the gradient divided out", _b_equation()),),
        "Formally right, given ap14.",
    )


@derives("ap16")
def _ap16() -> Derived:
    integral = sp.Symbol("integral")  # int vhat.B delta(|vhat| - 1) dvhat
    flux = s.v * isotropy() * integral * s.nabla0 * _N
    (value,) = sp.solve(s.De(s.v, s.t) + s.v / 2 * integral, integral)
    return Derived(
        eq(s.J1(s.br, s.v, s.t), flux.subs(integral, value)),
        (
            Step("mean of the squared cosine over directions", isotropy()),
            Step("flux with D_e as defined in ap17", flux.subs(integral, value)),
        ),
    )


@derives("ap17")
def _ap17() -> Derived:
    return definition("The diffusion coefficient at one speed as an integral of B.")


@cache
def _d_equation() -> sp.Eq:
    """-(1/2) of v.(equation for B), summed over directions."""
    half = -sp.Rational(1, 2)
    named = {
        Partial(_B, s.T(s.t)): Partial(s.De(s.v, s.t), s.T(s.t)) / half,
        Lam(_B): -s.nuD * s.De(s.v, s.t) / half,
        s.bv * s.f(s.bv, s.t): s.v**2 * s.mn(s.v, s.t),
    }
    left, right = _b_equation().args
    return eq(sp.expand(half * left.subs(named)), sp.expand(half * right).subs(named))


@derives("ap18")
def _ap18() -> Derived:
    return Derived(
        _d_equation(),
        (
            Step("the equation for B", _b_equation()),
            Step("times -v/2, summed over directions, nu_D and D_e named", _d_equation()),
        ),
        "Here nu_D is a function of the speed.",
    )


@derives("ap19")
def _ap19() -> Derived:
    return definition(
        "The relaxation rate at one speed. A parenthesis is missing in the numerator. At e = 1 it "
        "is (4/3) v/l, proportional to the speed, not to the thermal velocity."
    )


@cache
def elastic_coefficient() -> tuple[sp.Expr, sp.Expr]:
    """(nu_D, D_e(v)) at e = 1, where B = b(v) v solves the equation at each speed exactly."""
    decay = -over_angle(parallel_component() - 1).subs(s.e, 1) / 2 * s.v / s.l
    return decay, s.v**2 / 2 / decay


@derives("ap20")
def _ap20() -> Derived:
    decay, exact = elastic_coefficient()
    numbers = tuple(
        Number(f"exact D_e over (3/8) v^2 l/v0, elastic, at v = {speed} v0", 1 / speed)
        for speed in (0.5, 1.0, 2.0)
    )
    return Derived(
        eq(Partial(s.De(s.v, s.t), s.T(s.t)), sp.diff(exact, s.T(s.t))),
        (
            Step("dimensions allow D_e = v l g(v/v0) with any function g", None),
            Step("nu_D at e = 1: speeds do not mix", decay),
            Step("D_e(v) at e = 1, exactly", exact),
        ),
        "The dimensional argument does not determine the power: v is a second speed beside v0, "
        "and D_e = v l g(v/v0) for any g. At e = 1 the equation can be solved: g = 3/8, D_e does "
        "not depend on the temperature at all, and nu_D is (4/3) v/l, not a number times v0/l.",
        Status.ASSUMPTION,
        holds=False,
        numbers=numbers,
    )


@derives("ap21")
def _ap21() -> Derived:
    unknown = sp.Symbol("D", positive=True)
    known = {Partial(s.De(s.v, s.t), s.T(s.t)): -unknown / (2 * s.T(s.t)), s.De(s.v, s.t): unknown}
    equation = (_d_equation().lhs - _d_equation().rhs).subs(known)
    (solution,) = sp.solve(equation, unknown)
    number = sp.cancel(solution.subs(s.nuD, s.v0(s.t) / s.l) / (s.v**2 * s.l / s.v0(s.t)))
    return Derived(
        chain(s.De(s.v, s.t), solution, s.v**2 * s.l / s.v0(s.t)),
        (
            Step("the equation for D_e with ap20", equation),
            Step("solved for D_e", solution),
            Step("with nu_D = v0/l: number in front of v^2 l/v0", number),
            Step("exact at e = 1", elastic_coefficient()[1]),
        ),
        "The first equality follows from ap18 and ap20, the second (up to a number) from "
        "nu_D ~ v0/l. Both premises fail: the exact elastic result is (3/8) v l.",
        Status.ASSUMPTION,
        holds=False,
    )


@derives("ap21.5")
def _ap21_5() -> Derived:
    hopping = s.kappa_d * s.v**2 * s.l / s.v0(s.t)
    derived = hopping.subs(s.v, s.V * s.v0(s.t)).subs(s.v0(s.t), 1 / (s.alpha + s.beta * s.t))
    return Derived(
        eq(s.De(s.V, s.t), sp.simplify(derived)),
        (Step("v = V v0 and v0 = 1/(alpha + beta t) in v^2 l/v0", derived),),
        "Follows from the last form of ap21, and falls with it: the exact elastic result is "
        "(3/8) V l/(alpha + beta t).",
    )
