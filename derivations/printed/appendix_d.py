"""Appendix D: the diffusion coefficient at one speed."""

from __future__ import annotations

import sympy as sp

from .. import symbols as s
from ..formal import Dt, Int, Lam, Partial, chain, dot, eq

_T = s.T(s.t)
_V0 = s.v0(s.t)
_F = s.f(s.bv, s.t)
_D_AT_V = s.De(s.v, s.t)

_p0, _p1 = s.p0(s.br, s.bv, s.t), s.p1(s.br, s.bv, s.t)
_n = s.nd(s.br, s.v, s.t)
_B = s.Bv(s.bv, _T)
_Bh = s.Bv(s.v * s.bvh, _T)
_shell = s.delta(s.vh - 1)
_cooling = _V0 / s.l * s.h * _T

FORMULAS: dict[str, sp.Basic] = {
    "ap1": eq(
        Int(2 * sp.pi * s.v * (sp.Derivative(_n, s.t) + dot(s.nabla, s.J(s.br, s.v, s.t))), s.v),
        sp.Integer(0),
    ),
    "ap2": eq(_n, Int(s.pd(s.br, s.v * s.bvh, s.t) * _shell, s.bvh)),
    "ap3": eq(s.J(s.br, s.v, s.t), Int(s.v * s.bvh * s.pd(s.br, s.v * s.bvh, s.t) * _shell, s.bvh)),
    "ap4": eq(sp.Derivative(_n, s.t) + dot(s.nabla, s.J(s.br, s.v, s.t)), sp.Integer(0)),
    "ap6": eq(sp.Derivative(_n, s.t), sp.Sum(s.eps ** (s.j + 1) * Dt(s.j, _n), (s.j, 0, sp.oo))),
    "ap7": eq(Dt(s.j, _n), -dot(s.nabla0, s.Jj(s.br, s.v, s.t))),
    "ap8": eq(
        s.Jj(s.br, s.v, s.t), Int(s.v * s.bvh * s.pj(s.br, s.v * s.bvh, s.t) * _shell, s.bvh)
    ),
    "ap11": eq(_p0, _n / s.mn(s.v, s.t) * _F),
    "ap11.5": eq(s.mn(s.v, s.t), Int(s.f(s.v * s.bvh, s.t) * _shell, s.bvh)),
    "ap11.6": chain(
        s.J0(s.br, s.v, s.t),
        s.v * _n / s.mn(s.v, s.t) * Int(s.bvh * s.f(s.v * s.bvh, s.t) * _shell, s.bvh),
        sp.Integer(0),
    ),
    "ap12": eq(
        Dt(0, _n) * Partial(_p0, _n)
        + sp.Derivative(_T, s.t) * Partial(_p1, _T)
        + dot(s.bv, s.nabla0) * _n * Partial(_p0, _n),
        Lam(_p1),
    ),
    "ap12.5": eq(sp.Derivative(_T, s.t), -_V0 / s.l * s.h * _T),
    "ap13": eq(
        _cooling * Partial(_p1, _T) + Lam(_p1), dot(s.bv, s.nabla0) * _n * _F / s.mn(s.v, s.t)
    ),
    "ap14": eq(_p1, dot(_B, s.nabla0) * _n),
    "ap15": eq(_cooling * Partial(_B, _T) + Lam(_B), s.bv * _F / s.mn(s.v, s.t)),
    "ap16": eq(s.J1(s.br, s.v, s.t), -_D_AT_V * s.nabla0 * _n),
    "ap17": eq(_D_AT_V, -s.v / 2 * Int(dot(s.bvh, _Bh) * _shell, s.bvh)),
    "ap18": eq(_cooling * Partial(_D_AT_V, _T) - s.nuD * _D_AT_V, -(s.v**2) / 2),
    "ap19": eq(
        s.nuD,
        -Int(s.v * dot(Lam(_Bh), s.bvh) * _shell, s.bvh)
        / Int(s.v * dot(s.bvh, _Bh) * _shell, s.bvh),
    ),
    "ap20": eq(Partial(_D_AT_V, _T), -_D_AT_V / (2 * _T)),
    "ap21": chain(_D_AT_V, s.v**2 / 2 / (s.h * _V0 / (2 * s.l) + s.nuD), s.v**2 * s.l / _V0),
    "ap21.5": eq(s.De(s.V, s.t), s.kappa_d * s.V**2 * s.l / (s.alpha + s.beta * s.t)),
}
