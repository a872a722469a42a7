"""Appendix A: the kinetic equation from gain and loss."""

from __future__ import annotations

import sympy as sp

from .. import symbols as s
from ..formal import Int, Measure, chain, dot, eq
from .equation import Section

SECTION = Section("Appendix A: kinetic equation")
_add = SECTION.add
_p, _ps = s.pd(s.br, s.bv, s.t), s.pd(s.br, s.bvs, s.t)
_streaming = sp.Derivative(_p, s.t) + dot(s.bv, s.nabla) * _p

_add(
    "dtchange",
    "balance",
    r"[p({\bf r},{\bf v},t+\delta t)-p({\bf r},{\bf v},t)]\mathrm{d}{\bf r}\mathrm{d}{\bf "
    r"v}= -\Gamma_{-}+\Gamma_{+}+\Gamma_{\mathit{flow}}",
    eq(
        (s.pd(s.br, s.bv, s.t + s.dt) - _p) * Measure(s.br) * Measure(s.bv),
        -s.Gamma_minus + s.Gamma_plus + s.Gamma_flow,
    ),
)
_add(
    "gammaflow",
    "streaming",
    r"\Gamma_{\mathit{flow}}=-\mathrm{d} {\bf r} \mathrm{d} {\bf v} \delta \mathit{t} "
    r"({\bf v}\cdot \nabla)p({\bf r},{\bf v},t)",
    eq(s.Gamma_flow, -Measure(s.br) * Measure(s.bv) * s.dt * dot(s.bv, s.nabla) * _p),
)
_add(
    "gamma-",
    "loss",
    r"\Gamma_{-}=\int p({\bf r},{\bf v},t) \mathrm{d}{\bf r}\mathrm{d}{\bf v} \rho_{0} "
    r"|{\bf v}| \delta \mathit{t} \mathrm{d}\mathit{b}",
    eq(s.Gamma_minus, Int(_p * Measure(s.br) * Measure(s.bv) * s.rho0 * s.v * s.dt, s.b)),
)
_add(
    "gamma+",
    "gain",
    r"\Gamma_{+}=\int p({\bf r},{\bf v}^{*},t) \mathrm{d}{\bf r} \mathrm{d}{\bf v}^{*} "
    r"\rho_{0} |{\bf v}^{*}| \delta \mathit{t} \mathrm{d}\mathit{b}=\int p({\bf r},{\bf v}"
    r"^{*},t) \mathrm{d}{\bf r} \frac {\mathrm{d}{\bf v}}{\mathit{e}} \rho_{0} |{\bf v}"
    r"^{*}| \delta \mathit{t} \mathrm{d}\mathit{b}",
    chain(
        s.Gamma_plus,
        Int(_ps * Measure(s.br) * Measure(s.bvs) * s.rho0 * s.vs * s.dt, s.b),
        Int(_ps * Measure(s.br) * Measure(s.bv) / s.e * s.rho0 * s.vs * s.dt, s.b),
    ),
)
_add(
    "ftdiff",
    "kinetic equation over the impact parameter",
    r"\frac{\partial p({\bf r},{\bf v},t)}{\partial t}+({\bf v}\cdot \nabla)p({\bf r}"
    r",{\bf v},t)= \rho_{0}\int [|{\bf v}^{*}|\frac{p({\bf r},{\bf v}^{*},t)}{e}-|{\bf v}"
    r"|p({\bf r},{\bf v},t)] \mathrm{d}\mathit{b}",
    eq(_streaming, s.rho0 * Int(s.vs * _ps / s.e - s.v * _p, s.b)),
)
_add(
    "rewrite",
    "impact parameter to unit vector",
    r"|{\bf v}|\mathrm{d}\mathit{b} = B(|{\bf v}|,{\bf \hat{\sigma}})\mathrm{d}{\bf "
    r"\hat{\sigma}}",
    eq(s.v * Measure(s.b), s.Brate(s.v, s.sigma) * Measure(s.sigma)),
)
_add(
    "bexpress",
    "its Jacobian, loss",
    r"B(|{\bf v}|,{\bf \hat{\sigma}})=|{\bf v}|d \cos(\pi-\psi) =d ({\bf v} \cdot {\bf "
    r"\hat{\sigma}})",
    chain(s.Brate(s.v, s.sigma), s.v * s.d * sp.cos(sp.pi - s.psi), s.d * dot(s.bv, s.sigma)),
)
_add(
    "bexpress2",
    "its Jacobian, gain",
    r"B(|{\bf v}^{*}|,{\bf \hat{\sigma}})=|{\bf v}^{*}|d \cos(\pi-\psi) =-d ({\bf v}^{*} "
    r"\cdot {\bf \hat{\sigma}})=d \frac{({\bf v} \cdot {\bf \hat{\sigma}})}{e}",
    chain(
        s.Brate(s.vs, s.sigma),
        s.vs * s.d * sp.cos(sp.pi - s.psi),
        -s.d * dot(s.bvs, s.sigma),
        s.d * dot(s.bv, s.sigma) / s.e,
    ),
)
_add(
    "inelaslorentz",
    "the inelastic Lorentz equation",
    r"\frac{\partial p({\bf r},{\bf v},t)}{\partial t}+({\bf v}\cdot \nabla)p({\bf r}"
    r",{\bf v},t)=d \rho_{0}\int_{{\bf v} \cdot {\bf \hat{\sigma}}>0} ({\bf v} \cdot {\bf "
    r"\hat{\sigma}}) [\frac{p({\bf r},{\bf v}^{*},t)}{e^{2}}-p({\bf r},{\bf v},t)] "
    r"\mathrm{d}{\bf \hat{\sigma}}",
    eq(_streaming, s.d * s.rho0 * Int(dot(s.bv, s.sigma) * (_ps / s.e**2 - _p), s.sigma, s.hemi)),
)
