"""The diffusion coefficient at one speed (Appendix D), and where its argument breaks."""

from __future__ import annotations

from functools import cache

import sympy as sp

from .. import symbols as s
from ..formal import Int, Lam, Partial, chain, dot, eq
from ..premises import over_angle, parallel_component, speed_ratio_squared
from .chapman_enskog import (
    b_equation,
    coefficient_equation,
    continuity_order,
    density_series,
    first_order,
    isotropy,
    orders,
)
from .record import Derived, Number, Step, defines, derives, numbers_at, result

_T = s.T(s.t)
_V0 = s.v0(s.t)
_D_AT_V = s.De(s.v, s.t)

_N = s.nd(s.br, s.v, s.t)
_SHELL = s.delta(s.vh - 1)
_COOLING = _V0 / s.l * s.h


@derives("ap1")
def _ap1() -> Derived:
    # dv = v dv dphi: the sum over directions is n(r, v, t), that over speeds carries the factor v
    density = s.v * (sp.Derivative(_N, s.t) + dot(s.nabla, s.J(s.br, s.v, s.t)))
    return result(
        eq(Int(density, s.v), sp.Integer(0)),
        Step("integral of the kinetic equation over v in polar form", Int(density, s.v)),
        Step("the collision operator keeps mass", sp.Integer(0)),
        note="Harmless: the printed factor 2 pi does not belong with ap2, whose n(r, v, t) is "
        "already summed over directions; since the other side is zero it changes nothing.",
        numbers=(Number("factor printed over derived", float(2 * sp.pi)),),
    )


defines(
    {
        "ap2": "Summed over directions, not averaged: 2 pi p for an isotropic p.",
        "ap3": "The flux at one speed.",
        "ap11.5": "f summed over directions.",
        "ap17": "The diffusion coefficient at one speed as an integral of B.",
        "ap19": "The relaxation rate at one speed. A parenthesis is missing in the numerator. "
        "At e = 1 it is (4/3) v/l, proportional to the speed, not to the thermal velocity.",
    }
)


@derives("ap4")
def _ap4() -> Derived:
    leak = Int(Lam(s.pd(s.br, s.v * s.bvh, s.t)) * _SHELL, s.bvh)
    loss = over_angle(1 - speed_ratio_squared()) / 2
    return result(
        eq(sp.Derivative(_N, s.t) + dot(s.nabla, s.J(s.br, s.v, s.t)), leak),
        Step("the kinetic equation at one speed, summed over directions", leak),
        Step("collisions change the speed: E[1 - s^2]", loss),
        note="That the integral over v vanishes does not make the integrand vanish. Collisions "
        "move tracers from one speed to another; the right-hand side is zero only at e = 1. With "
        "it the speed-resolved expansion of this appendix loses its ground for e < 1.",
        numbers=numbers_at(
            (0.9, 0.4),
            {"energy exchanged per collision at e = {e}": lambda e: float(loss.subs(s.e, e))},
        ),
    )


@derives("ap6")
def _ap6() -> Derived:
    return result(
        eq(sp.Derivative(_N, s.t), density_series(_N)),
        Step("each order of the gradient carries at least one factor of epsilon"),
        note="Rests on ap4.",
    )


@derives("ap7")
def _ap7() -> Derived:
    return continuity_order(s.Jj(s.br, s.v, s.t), _N)


@derives("ap8")
def _ap8() -> Derived:
    velocity = s.v * s.bvh
    return result(
        eq(s.Jj(s.br, s.v, s.t), Int(velocity * s.pj(s.br, velocity, s.t) * _SHELL, s.bvh)),
        Step("order epsilon^j of ap3, v = |v| times its direction", velocity),
    )


@derives("ap11")
def _ap11() -> Derived:
    return result(
        None,
        note="The factor n(r, v, t)/m(v, t) depends on the speed. The collision operator mixes "
        "speeds, so that its product with f solves the zeroth order only at e = 1, or where the "
        "factor does not depend on the speed (which is diffuse11 again).",
        holds=False,
    )


@derives("ap11.6")
def _ap11_6() -> Derived:
    angle = sp.Symbol("angle", real=True)
    mean = sp.integrate(sp.cos(angle), (angle, 0, 2 * sp.pi))
    ratio = _N / s.mn(s.v, s.t)
    flux = s.v * ratio * Int(s.bvh * s.f(s.v * s.bvh, s.t) * _SHELL, s.bvh)
    return result(
        chain(s.J0(s.br, s.v, s.t), flux, mean),
        Step("ap8 with p^(0) = n f/m", flux),
        Step("sum of the direction over the circle, f being isotropic", mean),
    )


@derives("ap12")
def _ap12() -> Derived:
    return result(
        orders(_N)[1],
        Step("order epsilon^1 of the kinetic equation", orders(_N)[1]),
        note="Formally right, given ap4 and ap11.",
    )


@derives("ap12.5")
def _ap12_5() -> Derived:
    path = sp.Symbol("path", positive=True)
    (density,) = sp.solve(path - 1 / (2 * s.d * s.rho0), s.rho0)
    rate = (-2 * s.d * _V0 * s.rho0 * s.h * _T).subs(s.rho0, density).subs(path, s.l)
    return result(eq(sp.Derivative(_T, s.t), rate), Step("l = 1/(2 d rho0) in tdiff", rate))


@cache
def _first_order() -> sp.Eq:
    slope = s.f(s.bv, s.t) / s.mn(s.v, s.t)
    return first_order(_N, slope, -_COOLING * _T)


@derives("ap13")
def _ap13() -> Derived:
    return result(
        _first_order(),
        Step("zeroth order and cooling inserted", _first_order()),
        note="Formally right, given ap4 and ap11.",
    )


@derives("ap14")
def _ap14() -> Derived:
    return result(
        None,
        note="At e = 1 it holds. For e < 1 the source at one speed drives p^(1) at lower speeds, "
        "and p^(1)(v) depends on the gradient of n at other speeds too.",
        holds=False,
    )


@cache
def _b_equation() -> sp.Eq:
    return b_equation(_first_order(), _N)


@derives("ap15")
def _ap15() -> Derived:
    return result(
        _b_equation(),
        Step("p^(1) = B.grad n inserted, the gradient divided out", _b_equation()),
        note="Formally right, given ap14.",
    )


@derives("ap16")
def _ap16() -> Derived:
    integral = sp.Symbol("integral")  # int vhat.B delta(|vhat| - 1) dvhat
    flux = s.v * isotropy() * integral * s.nabla0 * _N
    (value,) = sp.solve(_D_AT_V + s.v / 2 * integral, integral)
    return result(
        eq(s.J1(s.br, s.v, s.t), flux.subs(integral, value)),
        Step("mean of the squared cosine over directions", isotropy()),
        Step("flux with D_e as defined in ap17", flux.subs(integral, value)),
    )


@cache
def _d_equation() -> sp.Eq:
    """ap18: the sum over directions of v.v f is v^2 m(v, t)."""
    source = s.v**2 * s.mn(s.v, s.t)
    return coefficient_equation(_b_equation(), _D_AT_V, source)


@derives("ap18")
def _ap18() -> Derived:
    return result(
        _d_equation(),
        Step("the equation for B", _b_equation()),
        Step("times -v/2, summed over directions, nu_D and D_e named", _d_equation()),
        note="Here nu_D is a function of the speed.",
    )


@cache
def elastic_coefficient() -> tuple[sp.Expr, sp.Expr]:
    """(nu_D, D_e(v)) at e = 1, where B = b(v) v solves the equation at each speed exactly."""
    decay = -over_angle(parallel_component() - 1).subs(s.e, 1) / 2 * s.v / s.l
    return decay, s.v**2 / 2 / decay


@derives("ap20")
def _ap20() -> Derived:
    decay, exact = elastic_coefficient()
    return result(
        eq(Partial(_D_AT_V, _T), sp.diff(exact, _T)),
        Step("dimensions allow D_e = v l g(v/v0) with any function g"),
        Step("nu_D at e = 1: speeds do not mix", decay),
        Step("D_e(v) at e = 1, exactly", exact),
        note="The dimensional argument does not determine the power: v is a second speed beside "
        "v0, and D_e = v l g(v/v0) for any g. At e = 1 the equation can be solved: g = 3/8, D_e "
        "does not depend on the temperature at all, and nu_D is (4/3) v/l, not a number times "
        "v0/l.",
        holds=False,
        numbers=[
            Number(f"exact D_e over (3/8) v^2 l/v0, elastic, at v = {speed} v0", 1 / speed)
            for speed in (0.5, 1.0, 2.0)
        ],
    )


@derives("ap21")
def _ap21() -> Derived:
    unknown = sp.Symbol("D", positive=True)
    known = {Partial(_D_AT_V, _T): -unknown / (2 * _T), _D_AT_V: unknown}
    equation = (_d_equation().lhs - _d_equation().rhs).subs(known)
    (solution,) = sp.solve(equation, unknown)
    number = sp.cancel(solution.subs(s.nuD, _V0 / s.l) / (s.v**2 * s.l / _V0))
    return result(
        chain(_D_AT_V, solution, s.v**2 * s.l / _V0),
        Step("the equation for D_e with ap20", equation),
        Step("solved for D_e", solution),
        Step("with nu_D = v0/l: number in front of v^2 l/v0", number),
        Step("exact at e = 1", elastic_coefficient()[1]),
        note="The first equality follows from ap18 and ap20, the second (up to a number) from "
        "nu_D ~ v0/l. Both premises fail: the exact elastic result is (3/8) v l.",
        holds=False,
    )


@derives("ap21.5")
def _ap21_5() -> Derived:
    hopping = s.kappa_d * s.v**2 * s.l / _V0
    derived = hopping.subs(s.v, s.V * _V0).subs(_V0, 1 / (s.alpha + s.beta * s.t))
    return result(
        eq(s.De(s.V, s.t), sp.simplify(derived)),
        Step("v = V v0 and v0 = 1/(alpha + beta t) in v^2 l/v0", derived),
        note="Follows from the last form of ap21, and falls with it: the exact elastic result is "
        "(3/8) V l/(alpha + beta t).",
    )
