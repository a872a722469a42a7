"""Appendix C: the diffusion coefficient in the first Sonine approximation."""

from __future__ import annotations

import sympy as sp

from .. import symbols as s
from ..formal import Int, Lam, dot, eq

_T = s.T(s.t)

FORMULAS: dict[str, sp.Basic] = {
    "ad1": eq(
        Int(s.Y(s.bv) * Lam(s.X(s.bv)), s.bv),
        s.d
        * s.rho0
        * Int(
            Int(dot(s.bv, s.sigma) * s.X(s.bv) * (s.Y(s.bvp) - s.Y(s.bv)), s.sigma, s.hemi), s.bv
        ),
    ),
    "ad2": eq(s.bvp, s.bv - (1 + s.e) * dot(s.bv, s.sigma) * s.sigma),
    "ad3": eq(s.Bv(s.bv, _T), s.bv * s.fa2(s.bv, s.t)),
    "ad4": eq(s.f(s.bv, s.t), s.fa2(s.bv, s.t)),
    "ad5": eq(
        s.fa2(s.bv, s.t),
        s.m
        / (2 * sp.pi * _T)
        * sp.exp(-s.m / (2 * _T) * s.v**2)
        * (1 + s.a2 * (1 - s.m / _T * s.v**2 + s.m**2 / (8 * _T**2) * s.v**4)),
    ),
    "ad6": eq(
        s.nuD,
        s.d
        * s.rho0
        * (1 + s.e)
        / 2
        * sp.sqrt(2 * sp.pi * _T / s.m)
        * (2 + sp.Rational(3, 4) * s.a2),
    ),
    "ad7": eq(
        s.De(s.t),
        sp.sqrt(2 * _T / (sp.pi * s.m))
        / (s.d * s.rho0)
        / ((s.e + 1) ** 2 * (1 + sp.Rational(3, 8) * s.a2)),
    ),
    "ad8": eq(s.msd(s.t), 4 * sp.Integral(s.De(s.t), (s.t1, 0, s.t))),
    "ad8#2": eq(
        s.msd(s.t),
        8
        / (sp.pi * s.d**2 * s.rho0**2)
        / ((1 + s.e) ** 2 * (1 - s.e**2) * (1 + sp.Rational(3, 8) * s.a2) ** 2)
        * sp.log(
            1
            + sp.sqrt(sp.pi / 2)
            * s.d
            * s.rho0
            * (1 - s.e**2)
            * (1 + sp.Rational(3, 8) * s.a2)
            * s.t
        ),
    ),
}
