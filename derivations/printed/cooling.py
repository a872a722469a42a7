"""Sections 2 and 3.2: the collision rule, cooling, the scaling form."""

from __future__ import annotations

import sympy as sp

from .. import symbols as s
from ..formal import Int, dot, eq

_T = s.T(s.t)
_V0 = s.v0(s.t)
_F = s.f(s.bv, s.t)
_F_SCALED = s.F(s.bc)

FORMULAS: dict[str, sp.Basic] = {
    "vchange": eq(s.bv, s.bvs - (1 + s.e) * dot(s.bvs, s.sigma) * s.sigma),
    "gtilde": eq(s.g(s.r, s.t), 1 / sp.sqrt(s.msd1(s.t)) * s.G(s.R)),
    "v0defi": eq(_V0, sp.sqrt(1 / s.n * Int(s.v**2 * _F, s.bv))),
    "thermo": eq(_T, sp.Rational(1, 2) * s.m * _V0**2),
    "tdiff": eq(sp.Derivative(_T, s.t), -2 * s.d * _V0 * s.rho0 * s.h * _T),
    "vdiff": eq(sp.Derivative(_V0, s.t), -s.d * s.rho0 * s.h * _V0**2),
    "veq": eq(_V0, 1 / (1 / s.v0(0) + s.d * s.rho0 * s.h * s.t)),
    "hsimu": eq(s.h, sp.Rational("1.45") * (1 - s.e)),
    "inelaslorentz2": eq(
        sp.Derivative(_F, s.t),
        s.d * s.rho0 * Int(dot(s.bv, s.sigma) * (s.f(s.bvs, s.t) / s.e**2 - _F), s.sigma, s.hemi),
    ),
    "tdepend": eq(_F, s.n / _V0**2 * _F_SCALED),
    "if": eq(
        s.I_(_F_SCALED),
        Int(dot(s.bc, s.sigma) * (s.F(s.bcs) / s.e**2 - _F_SCALED), s.sigma, s.hemi_c),
    ),
    "mup": eq(s.Mp, -Int(s.c**s.p * s.I_(_F_SCALED), s.bc)),
    "tdiff2": eq(sp.Derivative(_T, s.t), -s.d * _V0 * s.rho0 * s.M2 * _T),
    "compare2": eq(s.h, s.M2 / 2),
    "compare3": eq(
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
