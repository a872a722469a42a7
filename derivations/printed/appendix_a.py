"""Appendix A: the kinetic equation from gain and loss."""

from __future__ import annotations

import sympy as sp

from .. import symbols as s
from ..formal import Int, Measure, chain, dot, eq

_p, _ps = s.pd(s.br, s.bv, s.t), s.pd(s.br, s.bvs, s.t)
_streaming = sp.Derivative(_p, s.t) + dot(s.bv, s.nabla) * _p

FORMULAS: dict[str, sp.Basic] = {
    "dtchange": eq(
        (s.pd(s.br, s.bv, s.t + s.dt) - _p) * Measure(s.br) * Measure(s.bv),
        -s.Gamma_minus + s.Gamma_plus + s.Gamma_flow,
    ),
    "gammaflow": eq(s.Gamma_flow, -Measure(s.br) * Measure(s.bv) * s.dt * dot(s.bv, s.nabla) * _p),
    "gamma-": eq(s.Gamma_minus, Int(_p * Measure(s.br) * Measure(s.bv) * s.rho0 * s.v * s.dt, s.b)),
    "gamma+": chain(
        s.Gamma_plus,
        Int(_ps * Measure(s.br) * Measure(s.bvs) * s.rho0 * s.vs * s.dt, s.b),
        Int(_ps * Measure(s.br) * Measure(s.bv) / s.e * s.rho0 * s.vs * s.dt, s.b),
    ),
    "ftdiff": eq(_streaming, s.rho0 * Int(s.vs * _ps / s.e - s.v * _p, s.b)),
    "rewrite": eq(s.v * Measure(s.b), s.Brate(s.v, s.sigma) * Measure(s.sigma)),
    "bexpress": chain(
        s.Brate(s.v, s.sigma), s.v * s.d * sp.cos(sp.pi - s.psi), s.d * dot(s.bv, s.sigma)
    ),
    "bexpress2": chain(
        s.Brate(s.vs, s.sigma),
        s.vs * s.d * sp.cos(sp.pi - s.psi),
        -s.d * dot(s.bvs, s.sigma),
        s.d * dot(s.bv, s.sigma) / s.e,
    ),
    "inelaslorentz": eq(
        _streaming, s.d * s.rho0 * Int(dot(s.bv, s.sigma) * (_ps / s.e**2 - _p), s.sigma, s.hemi)
    ),
}
