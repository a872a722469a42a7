"""Appendix B, first part: the scaled equation and its Sonine expansion."""

from __future__ import annotations

import sympy as sp

from .. import symbols as s
from ..formal import Avg, Int, Partial, chain, dot, eq

_F_SCALED = s.F(s.bc)

_root = sp.sqrt(-383 + 828 * s.e**2 + 900 * s.e**4)

FORMULAS: dict[str, sp.Basic] = {
    "rearramu2": eq(sp.Derivative(s.v0(s.t), s.t), -s.rho0 * s.d * s.M2 * s.v0(s.t) ** 2 / 2),
    "ifmu2": eq(s.I_(_F_SCALED), s.M2 / 2 * (2 * _F_SCALED + dot(s.bc, Partial(_F_SCALED, s.bc)))),
    "mueq": eq(s.Mp, s.M2 / 2 * s.p * Avg(s.c**s.p)),
    "sonine1": eq(
        _F_SCALED, s.phi(s.bc) * (1 + sp.Sum(s.a(s.p) * s.S(s.p, s.c**2), (s.p, 1, sp.oo)))
    ),
    "sonine1.5": sp.Tuple(eq(s.S(0, s.x), sp.Integer(1)), eq(s.S(1, s.x), -s.x + 1)),
    "sonine2": eq(s.S(2, s.x), sp.Rational(1, 2) * s.x**2 - 2 * s.x + 1),
    "sonine3": eq(
        Int(s.phi(s.bc) * s.S(s.p, s.c**2) * s.S(s.pprime, s.c**2), s.bc),
        sp.KroneckerDelta(s.p, s.pprime),
    ),
    "sonine4": chain(s.a(s.p), Int(s.S(s.p, s.c**2) * _F_SCALED, s.bc), Avg(s.S(s.p, s.c**2))),
    "sonine4.5": chain(s.a1, -Avg(s.c**2) + 1, sp.Integer(0)),
    "sonine5": chain(s.a2, Avg(s.c**4) / 2 - 2 * Avg(s.c**2) + 1, Avg(s.c**4) / 2 - 1),
    "sonine6": eq(s.M4, 2 * s.M2 * Avg(s.c**4)),
    "sonine7": eq(4 * s.M2 * (s.a2 + 1) - s.M4, sp.Integer(0)),
    "sonine8": eq(
        s.Mp,
        Int(Int(dot(s.bc, s.sigma) * _F_SCALED * (s.c**s.p - s.cp**s.p), s.sigma, s.hemi_c), s.bc),
    ),
    "sonine9": eq(s.M2, sp.sqrt(sp.pi) * (1 - s.e**2) * (1 + sp.Rational(3, 8) * s.a2)),
    "sonine10": eq(
        s.M4, sp.sqrt(sp.pi) * (1 - s.e**2) * (3 + 2 * s.e**2) * (1 + sp.Rational(15, 8) * s.a2)
    ),
    "sonine11": eq(s.a2, sp.Rational(1, 24) * (1 + 30 * s.e**2 + s.pm * _root)),
    "sonine12": eq(s.a2, sp.Rational(1, 24) * (1 + 30 * s.e**2 - _root)),
}
