"""Sections 2 and 3.2: the collision rule, cooling, the scaling form."""

from __future__ import annotations

import sympy as sp

from .. import symbols as s
from ..formal import Int, dot, eq

FORMULAS: dict[str, sp.Basic] = {
    "vchange": eq(s.bv, s.bvs - (1 + s.e) * dot(s.bvs, s.sigma) * s.sigma),
    "gtilde": eq(s.g(s.r, s.t), 1 / sp.sqrt(s.msd1(s.t)) * s.G(s.R)),
    "v0defi": eq(s.v0(s.t), sp.sqrt(1 / s.n * Int(s.v**2 * s.f(s.bv, s.t), s.bv))),
    "thermo": eq(s.T(s.t), sp.Rational(1, 2) * s.m * s.v0(s.t) ** 2),
    "tdiff": eq(sp.Derivative(s.T(s.t), s.t), -2 * s.d * s.v0(s.t) * s.rho0 * s.h * s.T(s.t)),
    "vdiff": eq(sp.Derivative(s.v0(s.t), s.t), -s.d * s.rho0 * s.h * s.v0(s.t) ** 2),
    "veq": eq(s.v0(s.t), 1 / (1 / s.v0(0) + s.d * s.rho0 * s.h * s.t)),
    "hsimu": eq(s.h, sp.Rational("1.45") * (1 - s.e)),
    "inelaslorentz2": eq(
        sp.Derivative(s.f(s.bv, s.t), s.t),
        s.d
        * s.rho0
        * Int(dot(s.bv, s.sigma) * (s.f(s.bvs, s.t) / s.e**2 - s.f(s.bv, s.t)), s.sigma, s.hemi),
    ),
    "tdepend": eq(s.f(s.bv, s.t), s.n / s.v0(s.t) ** 2 * s.F(s.bc)),
    "if": eq(
        s.I_(s.F(s.bc)),
        Int(dot(s.bc, s.sigma) * (s.F(s.bcs) / s.e**2 - s.F(s.bc)), s.sigma, s.hemi_c),
    ),
    "mup": eq(s.Mp, -Int(s.c**s.p * s.I_(s.F(s.bc)), s.bc)),
    "tdiff2": eq(sp.Derivative(s.T(s.t), s.t), -s.d * s.v0(s.t) * s.rho0 * s.M2 * s.T(s.t)),
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
