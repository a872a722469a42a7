"""Section 3.3: the Chapman-Enskog expansion, diffuse1 ... diffuse22."""

from __future__ import annotations

import sympy as sp

from .. import symbols as s
from ..formal import Dt, Int, Lam, Partial, dot, eq

_D = s.De(s.t)
_F = s.f(s.bv, s.t)

_p, _p0, _p1 = s.pd(s.br, s.bv, s.t), s.p0(s.br, s.bv, s.t), s.p1(s.br, s.bv, s.t)
_n = s.nd(s.br, s.t)
_B = s.Bv(s.bv, s.T(s.t))

FORMULAS: dict[str, sp.Basic] = {
    "diffuse1": eq(sp.Derivative(_p, s.t) + dot(s.bv, s.nabla) * _p, Lam(_p)),
    "diffuse1.5": eq(
        Lam(_p),
        s.d
        * s.rho0
        * Int(dot(s.bv, s.sigma) * (s.pd(s.br, s.bvs, s.t) / s.e**2 - _p), s.sigma, s.hemi),
    ),
    "diffuse2": eq(sp.Derivative(_n, s.t) + dot(s.nabla, s.J(s.br, s.t)), sp.Integer(0)),
    "diffuse3": eq(_n, Int(_p, s.bv)),
    "diffuse4": eq(s.J(s.br, s.t), Int(s.bv * _p, s.bv)),
    "diffuse5": eq(_p, _p0 + s.eps * _p1 + s.eps**2 * s.p2(s.br, s.bv, s.t)),
    "diffuse6": eq(
        sp.Derivative(_n, s.t), sp.Sum(s.eps ** (s.j + 1) * Dt(s.j, _n), (s.j, 0, sp.oo))
    ),
    "diffuse7": eq(Dt(s.j, _n), -dot(s.nabla0, s.Jj(s.br, s.t))),
    "diffuse8": eq(s.Jj(s.br, s.t), Int(s.bv * s.pj(s.br, s.bv, s.t), s.bv)),
    "diffuse9": eq(s.nabla, s.eps * s.nabla0 + s.eps**2 * s.nabla1),
    "diffuse10": eq(sp.Derivative(s.T(s.t), s.t) * Partial(_p0, s.T(s.t)), Lam(_p0)),
    "diffuse11": eq(_p0, _n / s.n * _F),
    "diffuse12": eq(
        Dt(0, _n) * Partial(_p0, _n)
        + sp.Derivative(s.T(s.t), s.t) * Partial(_p1, s.T(s.t))
        + dot(s.bv, s.nabla0) * _n * Partial(_p0, _n),
        Lam(_p1),
    ),
    "diffuse13": eq(
        s.xi(s.t) * s.T(s.t) * Partial(_p1, s.T(s.t)) + Lam(_p1),
        dot(s.bv, s.nabla0) * _n / s.n * _F,
    ),
    "diffuse14": eq(_p1, dot(_B, s.nabla0) * _n),
    "diffuse15": eq(s.xi(s.t) * s.T(s.t) * Partial(_B, s.T(s.t)) + Lam(_B), s.bv / s.n * _F),
    "diffuse16": eq(s.J1(s.br, s.t), -_D * s.nabla0 * _n),
    "diffuse17": eq(_D, -sp.Rational(1, 2) * Int(dot(s.bv, _B), s.bv)),
    "diffuse18": eq(s.xi(s.t) * s.T(s.t) * Partial(_D, s.T(s.t)) - s.nuD * _D, -s.T(s.t) / s.m),
    "diffuse19": eq(s.nuD, -Int(dot(Lam(_B), s.bv), s.bv) / Int(dot(_B, s.bv), s.bv)),
    "diffuse20": eq(Partial(_D, s.T(s.t)), _D / (2 * s.T(s.t))),
    "diffuse21": eq(_D, s.T(s.t) / s.m / (s.nuD - s.xi(s.t) / 2)),
    "diffuse22": eq(Dt(1, _n), _D * s.nabla0**2 * _n),
}
