"""Appendices A to D as printed."""

from __future__ import annotations

import sympy as sp

from .. import symbols as s
from ..formal import Avg, Dt, Int, Lam, Measure, Partial, chain, dot, eq

Q = sp.Rational
_half = Q(1, 2)
_p, _ps = (s.pd(s.br, s.bv, s.t), s.pd(s.br, s.bvs, s.t))
_streaming = sp.Derivative(_p, s.t) + dot(s.bv, s.nabla) * _p
_F_SCALED = s.F(s.bc)
_root = sp.sqrt(-383 + 828 * s.e**2 + 900 * s.e**4)
_V0 = s.v0(s.t)
_T = s.T(s.t)
_F = s.f(s.bv, s.t)
_D_AT_V = s.De(s.v, s.t)
_p0, _p1 = (s.p0(s.br, s.bv, s.t), s.p1(s.br, s.bv, s.t))
_n = s.nd(s.br, s.v, s.t)
_B = s.Bv(s.bv, _T)
_Bh = s.Bv(s.v * s.bvh, _T)
_shell = s.delta(s.vh - 1)
_cooling = _V0 / s.l * s.h * _T

FORMULAS: dict[str, sp.Basic] = {
    # A: the kinetic equation from gain and loss
    "dtchange": eq((s.pd(s.br, s.bv, s.t + s.dt) - _p) * Measure(s.br) * Measure(s.bv),
        -s.Gamma_minus + s.Gamma_plus + s.Gamma_flow),
    "gammaflow": eq(s.Gamma_flow, -Measure(s.br) * Measure(s.bv) * s.dt * dot(s.bv, s.nabla) * _p),
    "gamma-": eq(s.Gamma_minus, Int(_p * Measure(s.br) * Measure(s.bv) * s.rho0 * s.v * s.dt, s.b)),
    "gamma+": chain(s.Gamma_plus, Int(_ps * Measure(s.br) * Measure(s.bvs) * s.rho0 * s.vs * s.dt,
        s.b), Int(_ps * Measure(s.br) * Measure(s.bv) / s.e * s.rho0 * s.vs * s.dt, s.b)),
    "ftdiff": eq(_streaming, s.rho0 * Int(s.vs * _ps / s.e - s.v * _p, s.b)),
    "rewrite": eq(s.v * Measure(s.b), s.Brate(s.v, s.sigma) * Measure(s.sigma)),
    "bexpress": chain(s.Brate(s.v, s.sigma), s.v * s.d * sp.cos(sp.pi - s.psi),
        s.d * dot(s.bv, s.sigma)),
    "bexpress2": chain(s.Brate(s.vs, s.sigma), s.vs * s.d * sp.cos(sp.pi - s.psi),
        -s.d * dot(s.bvs, s.sigma), s.d * dot(s.bv, s.sigma) / s.e),
    "inelaslorentz": eq(_streaming, s.d * s.rho0
        * Int(dot(s.bv, s.sigma) * (_ps / s.e**2 - _p), s.sigma, s.hemi)),
    # B: the scaled equation and its Sonine expansion
    "rearramu2": eq(sp.Derivative(s.v0(s.t), s.t), -s.rho0 * s.d * s.M2 * s.v0(s.t)**2 / 2),
    "ifmu2": eq(s.I_(_F_SCALED), s.M2 / 2 * (2 * _F_SCALED + dot(s.bc, Partial(_F_SCALED, s.bc)))),
    "mueq": eq(s.Mp, s.M2 / 2 * s.p * Avg(s.c**s.p)),
    "sonine1": eq(_F_SCALED, s.phi(s.bc) * (1 + sp.Sum(s.a(s.p) * s.S(s.p, s.c**2),
        (s.p, 1, sp.oo)))),
    "sonine1.5": sp.Tuple(eq(s.S(0, s.x), 1), eq(s.S(1, s.x), -s.x + 1)),
    "sonine2": eq(s.S(2, s.x), _half * s.x**2 - 2 * s.x + 1),
    "sonine3": eq(Int(s.phi(s.bc) * s.S(s.p, s.c**2) * s.S(s.pprime, s.c**2), s.bc),
        sp.KroneckerDelta(s.p, s.pprime)),
    "sonine4": chain(s.a(s.p), Int(s.S(s.p, s.c**2) * _F_SCALED, s.bc), Avg(s.S(s.p, s.c**2))),
    "sonine4.5": chain(s.a1, -Avg(s.c**2) + 1, 0),
    "sonine5": chain(s.a2, Avg(s.c**4) / 2 - 2 * Avg(s.c**2) + 1, Avg(s.c**4) / 2 - 1),
    "sonine6": eq(s.M4, 2 * s.M2 * Avg(s.c**4)),
    "sonine7": eq(4 * s.M2 * (s.a2 + 1) - s.M4, 0),
    "sonine8": eq(s.Mp, Int(Int(dot(s.bc, s.sigma) * _F_SCALED * (s.c**s.p - s.cp**s.p), s.sigma,
        s.hemi_c), s.bc)),
    "sonine9": eq(s.M2, sp.sqrt(sp.pi) * (1 - s.e**2) * (1 + Q(3, 8) * s.a2)),
    "sonine10": eq(s.M4, sp.sqrt(sp.pi) * (1 - s.e**2) * (3 + 2 * s.e**2) * (1 + Q(15, 8) * s.a2)),
    "sonine11": eq(s.a2, Q(1, 24) * (1 + 30 * s.e**2 + s.pm * _root)),
    "sonine12": eq(s.a2, Q(1, 24) * (1 + 30 * s.e**2 - _root)),
    # B: time dependence and stability of a_2
    "ac1": eq(s.f(s.bv, s.t), s.n / _V0**2 * s.F(s.bc, s.t)),
    "ac2": eq(1 / (s.d * s.rho0 * _V0) * Partial(Avg(s.c**s.p), s.t) - s.M2 / 2 * s.p
        * Avg(s.c**s.p) + s.Mp, 0),
    "ac3": eq(sp.Derivative(s.a2t(s.t), s.t), s.d * s.rho0 * _V0 / 2
        * (4 * s.M2 * (s.a2t(s.t) + 1) - s.M4)),
    "ac4": eq(s.a2t(s.t), s.a2bar + s.da2(s.t)),
    "ac5": eq(sp.Derivative(s.da2(s.t), s.t), s.d * s.rho0 / 2 * sp.sqrt(sp.pi) * (1 - s.e**2) * s.H
        * _V0 * s.da2(s.t)),
    "ac6": eq(s.da2(s.t), s.da2(0) * sp.exp(s.d * s.rho0 / 2 * sp.sqrt(sp.pi) * (1 - s.e**2) * s.H
        * sp.Integral(_V0, (s.t, 0, s.t)))),
    "ac7": eq(s.H, 3 * s.a2bar - (Q(15, 4) * s.e**2 + Q(1, 8))),
    "compare1": sp.Le(sp.sqrt(-Q(23, 50) + 16 * sp.sqrt(14) / 75), s.e, evaluate=False),
    "compare3#2": eq(s.M2, sp.sqrt(sp.pi) * (1 - s.e**2)
        * (Q(65, 64) + Q(15, 32) * s.e**2 - Q(1, 64)
        * sp.sqrt(-383 + 828 * s.e**2 + 900 * s.e**4))),
    # C: the diffusion coefficient in the first Sonine approximation
    "ad1": eq(Int(s.Y(s.bv) * Lam(s.X(s.bv)), s.bv),
        s.d * s.rho0 * Int(Int(dot(s.bv, s.sigma) * s.X(s.bv) * (s.Y(s.bvp) - s.Y(s.bv)), s.sigma,
        s.hemi), s.bv)),
    "ad2": eq(s.bvp, s.bv - (1 + s.e) * dot(s.bv, s.sigma) * s.sigma),
    "ad3": eq(s.Bv(s.bv, _T), s.bv * s.fa2(s.bv, s.t)),
    "ad4": eq(s.f(s.bv, s.t), s.fa2(s.bv, s.t)),
    "ad5": eq(s.fa2(s.bv, s.t), s.m / (2 * sp.pi * _T) * sp.exp(-s.m / (2 * _T) * s.v**2)
        * (1 + s.a2 * (1 - s.m / _T * s.v**2 + s.m**2 / (8 * _T**2) * s.v**4))),
    "ad6": eq(s.nuD, s.d * s.rho0 * (1 + s.e) / 2 * sp.sqrt(2 * sp.pi * _T / s.m)
        * (2 + Q(3, 4) * s.a2)),
    "ad7": eq(s.De(s.t), sp.sqrt(2 * _T / (sp.pi * s.m)) / (s.d * s.rho0)
        / ((s.e + 1)**2 * (1 + Q(3, 8) * s.a2))),
    "ad8": eq(s.msd(s.t), 4 * sp.Integral(s.De(s.t), (s.t1, 0, s.t))),
    "ad8#2": eq(s.msd(s.t), 8 / (sp.pi * s.d**2 * s.rho0**2)
        / ((1 + s.e)**2 * (1 - s.e**2) * (1 + Q(3, 8) * s.a2)**2)
        * sp.log(1 + sp.sqrt(sp.pi / 2) * s.d * s.rho0 * (1 - s.e**2) * (1 + Q(3, 8) * s.a2)
        * s.t)),
    # D: the diffusion coefficient at one speed
    "ap1": eq(Int(2 * sp.pi * s.v * (sp.Derivative(_n, s.t) + dot(s.nabla, s.J(s.br, s.v, s.t))),
        s.v), 0),
    "ap2": eq(_n, Int(s.pd(s.br, s.v * s.bvh, s.t) * _shell, s.bvh)),
    "ap3": eq(s.J(s.br, s.v, s.t), Int(s.v * s.bvh * s.pd(s.br, s.v * s.bvh, s.t) * _shell, s.bvh)),
    "ap4": eq(sp.Derivative(_n, s.t) + dot(s.nabla, s.J(s.br, s.v, s.t)), 0),
    "ap6": eq(sp.Derivative(_n, s.t), sp.Sum(s.eps**(s.j + 1) * Dt(s.j, _n), (s.j, 0, sp.oo))),
    "ap7": eq(Dt(s.j, _n), -dot(s.nabla0, s.Jj(s.br, s.v, s.t))),
    "ap8": eq(s.Jj(s.br, s.v, s.t), Int(s.v * s.bvh * s.pj(s.br, s.v * s.bvh, s.t) * _shell,
        s.bvh)),
    "ap11": eq(_p0, _n / s.mn(s.v, s.t) * _F),
    "ap11.5": eq(s.mn(s.v, s.t), Int(s.f(s.v * s.bvh, s.t) * _shell, s.bvh)),
    "ap11.6": chain(s.J0(s.br, s.v, s.t), s.v * _n / s.mn(s.v, s.t)
        * Int(s.bvh * s.f(s.v * s.bvh, s.t) * _shell, s.bvh), 0),
    "ap12": eq(Dt(0, _n) * Partial(_p0, _n) + sp.Derivative(_T, s.t) * Partial(_p1, _T)
        + dot(s.bv, s.nabla0) * _n * Partial(_p0, _n), Lam(_p1)),
    "ap12.5": eq(sp.Derivative(_T, s.t), -_V0 / s.l * s.h * _T),
    "ap13": eq(_cooling * Partial(_p1, _T) + Lam(_p1),
        dot(s.bv, s.nabla0) * _n * _F / s.mn(s.v, s.t)),
    "ap14": eq(_p1, dot(_B, s.nabla0) * _n),
    "ap15": eq(_cooling * Partial(_B, _T) + Lam(_B), s.bv * _F / s.mn(s.v, s.t)),
    "ap16": eq(s.J1(s.br, s.v, s.t), -_D_AT_V * s.nabla0 * _n),
    "ap17": eq(_D_AT_V, -s.v / 2 * Int(dot(s.bvh, _Bh) * _shell, s.bvh)),
    "ap18": eq(_cooling * Partial(_D_AT_V, _T) - s.nuD * _D_AT_V, -s.v**2 / 2),
    "ap19": eq(s.nuD, -Int(s.v * dot(Lam(_Bh), s.bvh) * _shell, s.bvh)
        / Int(s.v * dot(s.bvh, _Bh) * _shell, s.bvh)),
    "ap20": eq(Partial(_D_AT_V, _T), -_D_AT_V / (2 * _T)),
    "ap21": chain(_D_AT_V, s.v**2 / 2 / (s.h * _V0 / (2 * s.l) + s.nuD), s.v**2 * s.l / _V0),
    "ap21.5": eq(s.De(s.V, s.t), s.kappa_d * s.V**2 * s.l / (s.alpha + s.beta * s.t)),
}  # fmt: skip
