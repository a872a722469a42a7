"""The position of a tracer that keeps its speed and scatters isotropically; beyond the paper.

Elastic spheres scatter so; in the plane it is the law of a uniform deflection. With l = 1,
zeta = v t and K = k l, w = <exp(i k.r)> obeys dw/dzeta = i K cos w + <w> - w, with <w> the average
over the direction of the velocity, and cos that of its angle to k.
"""

from __future__ import annotations

from functools import cache

import sympy as sp

from .. import symbols as s
from ..formal import eq
from .any_dimension import elastic_transform
from .record import Derived, Step, derives, result

_DECAY = sp.Symbol("decay", positive=True)
"""1 + z: the rate at which a flight ends, in Laplace space."""
_W = sp.Symbol("w", positive=True)


@cache
def first_flight(dimension: int) -> sp.Expr:
    """<1/(1 + z - i K cos)> over directions: the transform of a tracer that has not collided.

    The odd part in the cosine has no average. In 1 + z and K.
    """
    if dimension == 3:  # the cosine is uniform
        cosine = sp.Symbol("cosine", real=True)
        return sp.integrate(_DECAY / (_DECAY**2 + s.wave**2 * cosine**2), (cosine, 0, 1))
    # a quarter of the circle with the tangent as variable: cos^2 = 1/(1 + tan^2)
    tangent, a, b = sp.symbols("tangent a b", positive=True)
    inverse = (_DECAY + s.wave**2 / (1 + tangent**2) / _DECAY) * (1 + tangent**2)
    quadratic = sp.Poly(sp.cancel(inverse), tangent)
    product = quadratic.coeff_monomial(1) * quadratic.coeff_monomial(tangent**2)
    quarter = sp.integrate(1 / (a + b * tangent**2), (tangent, 0, sp.oo))
    return quarter.subs(b, sp.expand(product) / a) / (sp.pi / 2)


@cache
def transform(dimension: int) -> sp.Expr:
    """<w> in Laplace space: (z + 1 - i K cos) w = 1 + <w>, averaged over directions."""
    return _all_flights(first_flight(dimension)).subs(_DECAY, 1 + s.laplace)


def _all_flights(first: sp.Expr) -> sp.Expr:
    """<w> from the transform of the first flight."""
    unknown = sp.Symbol("unknown")
    balance = sp.expand(first * (1 + unknown) - unknown)
    return balance.coeff(unknown, 0) / -balance.coeff(unknown, 1)


@cache
def fourth_order(dimension: int) -> sp.Expr:
    """The Laplace transform of <r^4> by the order K^4, less that of the chain with nu_m = 1."""
    series = sp.series(first_flight(dimension), s.wave, 0, 6).removeO()
    zero, second, fourth = (series.coeff(s.wave, order) for order in (0, 2, 4))
    flight = sp.Symbol("first", positive=True)
    slope, bend = (sp.diff(_all_flights(flight), flight, n).subs(flight, zero) for n in (1, 2))
    found = (slope * fourth + bend * second**2 / 2).subs(_DECAY, 1 + s.laplace)
    square = {2: sp.Rational(3, 8), 3: sp.Rational(1, 5)}[dimension]  # <cos^4>
    chain = elastic_transform(dimension).subs({s.nu1: 1, s.nu2: 1})
    return sp.cancel(found * sp.factorial(4) / square - chain)


def _checked(dimension: int) -> sp.Expr:
    difference = fourth_order(dimension)
    if difference != 0:
        raise ArithmeticError(f"the order K^4 and the chain of <r^4> differ by {difference}")
    return difference


@derives("beyond:isotropic-space")
def _space() -> Derived:
    return result(
        eq(s.Fhat(s.wave, s.laplace), transform(3)),
        Step("w = <exp(i k.r)>: dw/dzeta = i K cos w + <w> - w, K = k l, zeta = v t/l"),
        Step("first flight, <1/(1 + z - i K cos)>, with decay = 1 + z", first_flight(3)),
        Step("all flights, (z + 1 - i K cos) w = 1 + <w>", transform(3)),
        Step("<r^4> of its order K^4 less that of beyond:quartic-elastic", _checked(3)),
        note="Elastic spheres scatter isotropically (beyond:space-isotropic).",
    )


@cache
def ring_transform(order: int) -> tuple[sp.Expr, sp.Expr]:
    """A lemma, at one order in K^2: (a ring over zeta, transformed; exp(-w Q)/Q).

    A ring of radius sqrt(zeta^2 - w^2), zeta > w, has the Fourier transform J_0(K radius); times
    exp(-zeta) its Laplace transform is exp(-w Q)/Q with Q the root of (1 + z)^2 + K^2.
    """
    later = sp.Symbol("later", positive=True)  # zeta - w
    bessel = sp.Rational((-1) ** order, 4**order * sp.factorial(order) ** 2)
    radius_power = sp.Poly(sp.expand((later**2 + 2 * later * _W) ** order), later)
    ring = sum(
        coefficient * sp.factorial(power) / _DECAY ** (power + 1)
        for (power,), coefficient in radius_power.terms()
    )
    square = sp.Symbol("square")  # K^2
    root = sp.sqrt(_DECAY**2 + square)
    shape = sp.diff(sp.exp(-_W * root) / root, square, order).subs(square, 0)
    return bessel * ring, sp.expand(sp.simplify(shape * sp.exp(_W * _DECAY)) / sp.factorial(order))


@derives("beyond:isotropic-plane")
def _plane() -> Derived:
    for order in range(4):
        ring, expected = ring_transform(order)
        if sp.expand(ring - expected) != 0:
            raise ArithmeticError(f"the transform of a ring fails at order {order} in K^2")
    # 1/(Q - 1) = 1/Q + the integral over w of exp(w) exp(-w Q)/Q: rings of all radii
    root = sp.Symbol("Q", positive=True)
    excess = sp.Symbol("excess", positive=True)  # Q - 1
    rings = sp.integrate(sp.exp(-_W * excess), (_W, 0, sp.oo)).subs(excess, root - 1) / root
    if sp.cancel(1 / root + rings - _all_flights(1 / root)) != 0:
        raise ArithmeticError("the rings do not add up to the transform")
    height = sp.sqrt(s.zeta**2 - s.r**2)  # the w whose ring has the radius r
    spread = -sp.diff(height, s.r) * sp.exp(height - s.zeta)
    mass = sp.integrate(sp.exp(_W - s.zeta), (_W, 0, s.zeta)) + sp.exp(-s.zeta)
    if sp.expand(mass) != 1:
        raise ArithmeticError("the density of position is not normalised")
    return result(
        sp.Tuple(
            eq(s.Fhat(s.wave, s.laplace), sp.simplify(transform(2))),
            eq(s.g(s.r, s.zeta), sp.exp(-s.zeta) * s.delta(s.r - s.zeta) + spread),
        ),
        Step("first flight, <1/(1 + z - i K cos)>, with decay = 1 + z", first_flight(2)),
        Step("all flights, (z + 1 - i K cos) w = 1 + <w>", transform(2)),
        Step("<r^4> of its order K^4 less that of beyond:quartic-elastic", _checked(2)),
        Step("1/(Q - 1) = 1/Q + the integral over w > 0 of exp(w) exp(-w Q)/Q"),
        Step("exp(-w Q)/Q is exp(-zeta) on a ring of radius sqrt(zeta^2 - w^2): to order K^6"),
        Step("the ring of radius r has w", height),
        Step("integral of the density over r", sp.expand(mass)),
        note="Paasschens' closed form; the second term for r < zeta, with r in units of l. "
        "Isotropic scattering in the plane is not that of disks, whose mean cosine is -1/3.",
    )
