"""Sections 2 and 3 as printed: cooling, random walk, transport, position."""

from __future__ import annotations

import sympy as sp

from .. import symbols as s
from ..formal import Dt, Int, Lam, Partial, Second, chain, dot, eq

Q = sp.Rational
_half = Q(1, 2)
_T = s.T(s.t)
_V0 = s.v0(s.t)
_F = s.f(s.bv, s.t)
_F_SCALED = s.F(s.bc)
_D = s.De(s.t)
_p, _p0, _p1 = (s.pd(s.br, s.bv, s.t), s.p0(s.br, s.bv, s.t), s.p1(s.br, s.bv, s.t))
_n = s.nd(s.br, s.t)
_B = s.Bv(s.bv, s.T(s.t))
_D_integral = sp.Integral(s.De(s.V, s.t1), (s.t1, 0, s.t))
_curvature = Second(s.pd(s.V, s.R), s.V, s.Vs)

FORMULAS: dict[str, sp.Basic] = {
    # Sections 2 and 3.2: the collision rule, cooling, the scaling form
    "vchange": eq(s.bv, s.bvs - (1 + s.e) * dot(s.bvs, s.sigma) * s.sigma),
    "gtilde": eq(s.g(s.r, s.t), 1 / sp.sqrt(s.msd1(s.t)) * s.G(s.R)),
    "v0defi": eq(_V0, sp.sqrt(1 / s.n * Int(s.v**2 * _F, s.bv))),
    "thermo": eq(_T, _half * s.m * _V0**2),
    "tdiff": eq(sp.Derivative(_T, s.t), -2 * s.d * _V0 * s.rho0 * s.h * _T),
    "vdiff": eq(sp.Derivative(_V0, s.t), -s.d * s.rho0 * s.h * _V0**2),
    "veq": eq(_V0, 1 / (1 / s.v0(0) + s.d * s.rho0 * s.h * s.t)),
    "hsimu": eq(s.h, Q("1.45") * (1 - s.e)),
    "inelaslorentz2": eq(sp.Derivative(_F, s.t),
        s.d * s.rho0 * Int(dot(s.bv, s.sigma) * (s.f(s.bvs, s.t) / s.e**2 - _F), s.sigma, s.hemi)),
    "tdepend": eq(_F, s.n / _V0**2 * _F_SCALED),
    "if": eq(s.I_(_F_SCALED), Int(dot(s.bc, s.sigma) * (s.F(s.bcs) / s.e**2 - _F_SCALED), s.sigma,
        s.hemi_c)),
    "mup": eq(s.Mp, -Int(s.c**s.p * s.I_(_F_SCALED), s.bc)),
    "tdiff2": eq(sp.Derivative(_T, s.t), -s.d * _V0 * s.rho0 * s.M2 * _T),
    "compare2": eq(s.h, s.M2 / 2),
    "compare3": eq(s.M2, sp.sqrt(sp.pi) * (1 - s.e**2)
        * (Q(65, 64) + Q(15, 32) * s.e**2 - Q(1, 64)
        * sp.sqrt(-383 + 828 * s.e**2 + 900 * s.e**4))),
    # Section 3.2: the random walk and its mean square displacement
    "ab": sp.Tuple(eq(s.alpha, 1 / s.v0(0)), eq(s.beta, s.d * s.rho0 * s.h)),
    "taun": chain(s.tau(s.N), s.l / s.v0(s.tc(s.N - 1)), s.l * (s.alpha + s.beta * s.tc(s.N - 1))),
    "taun#2": eq(s.tau(s.N), s.l * s.alpha * (1 + s.l * s.beta)**(s.N - 1)),
    "tn": chain(s.tc(s.N), sp.Sum(s.tau(s.k), (s.k, 1, s.N)),
        s.alpha / s.beta * ((1 + s.l * s.beta)**s.N - 1)),
    "N": eq(s.N, sp.log(s.beta / s.alpha * s.tc(s.N) + 1) / sp.log(1 + s.l * s.beta)),
    "msd": chain(s.msd(s.t), s.l**2 * s.N, s.l**2 * sp.log(s.beta / s.alpha * s.t + 1)
        / sp.log(1 + s.l * s.beta)),
    "scaledposi": eq(s.G(s.R), sp.sqrt(s.msd(s.t)) * s.ge(s.r, s.t)),
    # Section 3.3: the Chapman-Enskog expansion
    "diffuse1": eq(sp.Derivative(_p, s.t) + dot(s.bv, s.nabla) * _p, Lam(_p)),
    "diffuse1.5": eq(Lam(_p), s.d * s.rho0 * Int(dot(s.bv, s.sigma)
        * (s.pd(s.br, s.bvs, s.t) / s.e**2 - _p), s.sigma, s.hemi)),
    "diffuse2": eq(sp.Derivative(_n, s.t) + dot(s.nabla, s.J(s.br, s.t)), 0),
    "diffuse3": eq(_n, Int(_p, s.bv)),
    "diffuse4": eq(s.J(s.br, s.t), Int(s.bv * _p, s.bv)),
    "diffuse5": eq(_p, _p0 + s.eps * _p1 + s.eps**2 * s.p2(s.br, s.bv, s.t)),
    "diffuse6": eq(sp.Derivative(_n, s.t), sp.Sum(s.eps**(s.j + 1) * Dt(s.j, _n), (s.j, 0, sp.oo))),
    "diffuse7": eq(Dt(s.j, _n), -dot(s.nabla0, s.Jj(s.br, s.t))),
    "diffuse8": eq(s.Jj(s.br, s.t), Int(s.bv * s.pj(s.br, s.bv, s.t), s.bv)),
    "diffuse9": eq(s.nabla, s.eps * s.nabla0 + s.eps**2 * s.nabla1),
    "diffuse10": eq(sp.Derivative(s.T(s.t), s.t) * Partial(_p0, s.T(s.t)), Lam(_p0)),
    "diffuse11": eq(_p0, _n / s.n * _F),
    "diffuse12": eq(Dt(0, _n) * Partial(_p0, _n) + sp.Derivative(s.T(s.t), s.t)
        * Partial(_p1, s.T(s.t)) + dot(s.bv, s.nabla0) * _n * Partial(_p0, _n), Lam(_p1)),
    "diffuse13": eq(s.xi(s.t) * s.T(s.t) * Partial(_p1, s.T(s.t)) + Lam(_p1),
        dot(s.bv, s.nabla0) * _n / s.n * _F),
    "diffuse14": eq(_p1, dot(_B, s.nabla0) * _n),
    "diffuse15": eq(s.xi(s.t) * s.T(s.t) * Partial(_B, s.T(s.t)) + Lam(_B), s.bv / s.n * _F),
    "diffuse16": eq(s.J1(s.br, s.t), -_D * s.nabla0 * _n),
    "diffuse17": eq(_D, -_half * Int(dot(s.bv, _B), s.bv)),
    "diffuse18": eq(s.xi(s.t) * s.T(s.t) * Partial(_D, s.T(s.t)) - s.nuD * _D, -s.T(s.t) / s.m),
    "diffuse19": eq(s.nuD, -Int(dot(Lam(_B), s.bv), s.bv) / Int(dot(_B, s.bv), s.bv)),
    "diffuse20": eq(Partial(_D, s.T(s.t)), _D / (2 * s.T(s.t))),
    "diffuse21": eq(_D, s.T(s.t) / s.m / (s.nuD - s.xi(s.t) / 2)),
    "diffuse22": eq(Dt(1, _n), _D * s.nabla0**2 * _n),
    # Section 3.3: the scaled position distribution
    "normg": eq(s.gt(s.r, s.t), 1 / (4 * _D_integral) * s.r * sp.exp(-s.r**2 / (8 * _D_integral))),
    "ddif": eq(s.De(s.V, s.t1), s.kappa_d * s.V**2 * s.l / (s.alpha + s.beta * s.t1)),
    "L": eq(s.V, sp.Abs(s.bl / s.tau1 / s.v0(s.t1))),
    "eta": eq(s.eta, 4 * _D_integral / (s.V**2 * s.msd(s.t))),
    "etadif": eq(s.eta, 4 * s.kappa_d * sp.log(1 + s.l * s.beta) / (s.l * s.beta)),
    "posivel": eq(s.Gt(s.R, s.V), 1 / (s.eta * s.V**2) * s.R
        * sp.exp(-s.R**2 / (2 * s.eta * s.V**2))),
    "gdefi": chain(s.G(s.R), sp.Integral(sp.exp(-s.V**2) / sp.pi / (s.eta * s.V**2) * s.R
        * sp.exp(-s.R**2 / (2 * s.eta * s.V**2)) * 2 * sp.pi * s.V, (s.V, 0, sp.oo)),
        2 / s.eta * s.R * sp.Integral(sp.exp(-s.pd(s.V, s.R) * s.R**2), (s.V, 0, sp.oo))),
    "pdefi": eq(s.pd(s.V, s.R), sp.log(s.V) / s.R**2 + s.V**2 / s.R**2 + 1 / (2 * s.eta * s.V**2)),
    "csolu": eq(s.Vs, sp.sqrt(-Q(1, 4) + sp.sqrt(s.eta + 8 * s.R**2) / (4 * sp.sqrt(s.eta)))),
    "tailg": chain(s.G(s.R), 2 / s.eta * s.R * sp.Integral(sp.exp(-s.pd(s.Vs, s.R) * s.R**2
        - (s.V - s.Vs)**2 / 2 * _curvature * s.R**2), (s.V, 0, sp.oo)),
        2 / s.eta * sp.sqrt(sp.pi / (2 * _curvature)) * sp.exp(-s.pd(s.Vs, s.R) * s.R**2)),
    "semig": eq(s.G(s.R), sp.sqrt(sp.pi * s.R / (2 * sp.sqrt(2) * s.eta**Q(3, 2)))
        * sp.exp(-sp.sqrt(2 / s.eta) * s.R)),
    "gammatailg": eq(s.G(s.R), 2 * s.gamma / s.eta * sp.sqrt(sp.pi / (2 * _curvature))
        * sp.exp(-s.pd(s.Vs, s.R) * s.R**2)),
    "peakg": eq(s.G(s.R), 1 / (s.eta * s.Vbar**2) * s.R
        * sp.exp(-s.R**2 / (2 * s.eta * s.Vbar**2))),
}  # fmt: skip
