"""One collision and its averages over the impact parameter.

Premises: the tangential component of the velocity is kept, the normal one is reversed and reduced
by the coefficient of restitution e, and the impact parameter is uniform: all chords of the
exclusion circle are equally likely. Everything else here is integrated from these.
"""

from __future__ import annotations

from functools import cache

import sympy as sp

from . import symbols as s


@cache
def collision_matrix() -> sp.Matrix:
    """The collision as a linear map of the (normal, tangential) components: v = A v*."""
    before = sp.symbols("v_n v_t", real=True)
    after = sp.symbols("w_n w_t", real=True)
    rule = sp.solve([after[0] + s.e * before[0], after[1] - before[1]], after)
    return sp.ImmutableMatrix([rule[w] for w in after]).jacobian(before)


@cache
def postcollision() -> tuple[sp.Expr, sp.Expr]:
    """(normal, tangential) components of v'/|v| for an approach at angle theta to the normal.

    theta = 0 is head-on.
    """
    normal, tangential = collision_matrix() * sp.Matrix([sp.cos(s.theta), sp.sin(s.theta)])
    return normal, tangential


@cache
def speed_ratio_squared() -> sp.Expr:
    """|v'|^2/|v|^2 as a polynomial in y = sin(theta), the impact parameter in units of d."""
    normal, tangential = postcollision()
    return sp.expand(_in_impact_parameter(normal**2 + tangential**2))


@cache
def parallel_component() -> sp.Expr:
    """v'.v/|v|^2 as a polynomial in y."""
    normal, tangential = postcollision()
    return sp.expand(_in_impact_parameter(normal * sp.cos(s.theta) + tangential * sp.sin(s.theta)))


def _in_impact_parameter(weight: sp.Expr) -> sp.Expr:
    return sp.expand(weight).subs(sp.cos(s.theta) ** 2, 1 - s.y**2).subs(sp.sin(s.theta), s.y)


def over_angle(weight: sp.Expr) -> sp.Expr:
    """The integral of cos(theta) weight over |theta| < pi/2, with y = sin(theta): weight(y)."""
    return sp.factor(sp.integrate(sp.expand(weight), (s.y, -1, 1)))


@cache
def loss(order: int) -> sp.Expr:
    """lambda(p) = E[1 - s^p] for an even order p: the mean relative loss of |v|^p per collision."""
    if order % 2 or order < 0:
        raise ValueError(f"order = {order}: an even order >= 0 is needed for a polynomial")
    return sp.factor(over_angle(1 - speed_ratio_squared() ** (order // 2)) / 2)


@cache
def gaussian_moment() -> sp.Expr:
    """<c^p> over exp(-c^2)/pi in the plane, for p > 0: Gamma(1 + p/2)."""
    return sp.integrate(2 * s.c ** (s.p + 1) * sp.exp(-(s.c**2)), (s.c, 0, sp.oo))


def gaussian_average(polynomial: sp.Expr) -> sp.Expr:
    """The average of a polynomial in c over exp(-c^2)/pi in the plane, term by term."""
    total = sp.Integer(0)
    for (order,), coefficient in sp.Poly(polynomial, s.c).terms():
        moment = gaussian_moment().subs(s.p, order) if order else sp.Integer(1)
        total += coefficient * moment
    return total
