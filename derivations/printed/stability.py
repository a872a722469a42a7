"""Appendix B, second part: time dependence and stability of a_2."""

from __future__ import annotations

import sympy as sp

from .. import symbols as s
from ..formal import Avg, Partial, eq

_V0 = s.v0(s.t)

FORMULAS: dict[str, sp.Basic] = {
    "ac1": eq(s.f(s.bv, s.t), s.n / _V0**2 * s.F(s.bc, s.t)),
    "ac2": eq(
        1 / (s.d * s.rho0 * _V0) * Partial(Avg(s.c**s.p), s.t)
        - s.M2 / 2 * s.p * Avg(s.c**s.p)
        + s.Mp,
        sp.Integer(0),
    ),
    "ac3": eq(
        sp.Derivative(s.a2t(s.t), s.t),
        s.d * s.rho0 * _V0 / 2 * (4 * s.M2 * (s.a2t(s.t) + 1) - s.M4),
    ),
    "ac4": eq(s.a2t(s.t), s.a2bar + s.da2(s.t)),
    "ac5": eq(
        sp.Derivative(s.da2(s.t), s.t),
        s.d * s.rho0 / 2 * sp.sqrt(sp.pi) * (1 - s.e**2) * s.H * _V0 * s.da2(s.t),
    ),
    "ac6": eq(
        s.da2(s.t),
        s.da2(0)
        * sp.exp(
            s.d * s.rho0 / 2 * sp.sqrt(sp.pi) * (1 - s.e**2) * s.H * sp.Integral(_V0, (s.t, 0, s.t))
        ),
    ),
    "ac7": eq(s.H, 3 * s.a2bar - (sp.Rational(15, 4) * s.e**2 + sp.Rational(1, 8))),
    "compare1": sp.Le(sp.sqrt(-sp.Rational(23, 50) + 16 * sp.sqrt(14) / 75), s.e, evaluate=False),
    "compare3#2": eq(
        s.M2,
        sp.sqrt(sp.pi)
        * (1 - s.e**2)
        * (
            sp.Rational(65, 64)
            + sp.Rational(15, 32) * s.e**2
            - sp.Rational(1, 64) * sp.sqrt(-383 + 828 * s.e**2 + 900 * s.e**4)
        ),
    ),
}
