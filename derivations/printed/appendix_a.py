"""Appendix A: the kinetic equation from gain and loss."""

from __future__ import annotations

import sympy as sp

from ..formal import Int, Measure, chain, dot, eq
from ..symbols import (
    Brate,
    Gamma_flow,
    Gamma_minus,
    Gamma_plus,
    b,
    br,
    bv,
    bvs,
    d,
    dt,
    e,
    hemi,
    nabla,
    pd,
    psi,
    rho0,
    sigma,
    t,
    v,
    vs,
)
from .entry import Section

SECTION = Section("Appendix A: kinetic equation")
_add = SECTION.add
_p, _ps = pd(br, bv, t), pd(br, bvs, t)
_streaming = sp.Derivative(_p, t) + dot(bv, nabla) * _p

_add(
    "dtchange",
    "balance",
    r"[p({\bf r},{\bf v},t+\delta t)-p({\bf r},{\bf v},t)]\mathrm{d}{\bf r}\mathrm{d}{\bf "
    r"v}= -\Gamma_{-}+\Gamma_{+}+\Gamma_{\mathit{flow}}",
    eq(
        (pd(br, bv, t + dt) - _p) * Measure(br) * Measure(bv),
        -Gamma_minus + Gamma_plus + Gamma_flow,
    ),
)
_add(
    "gammaflow",
    "streaming",
    r"\Gamma_{\mathit{flow}}=-\mathrm{d} {\bf r} \mathrm{d} {\bf v} \delta \mathit{t} "
    r"({\bf v}\cdot \nabla)p({\bf r},{\bf v},t)",
    eq(Gamma_flow, -Measure(br) * Measure(bv) * dt * dot(bv, nabla) * _p),
)
_add(
    "gamma-",
    "loss",
    r"\Gamma_{-}=\int p({\bf r},{\bf v},t) \mathrm{d}{\bf r}\mathrm{d}{\bf v} \rho_{0} "
    r"|{\bf v}| \delta \mathit{t} \mathrm{d}\mathit{b}",
    eq(Gamma_minus, Int(_p * Measure(br) * Measure(bv) * rho0 * v * dt, b)),
)
_add(
    "gamma+",
    "gain",
    r"\Gamma_{+}=\int p({\bf r},{\bf v}^{*},t) \mathrm{d}{\bf r} \mathrm{d}{\bf v}^{*} "
    r"\rho_{0} |{\bf v}^{*}| \delta \mathit{t} \mathrm{d}\mathit{b}=\int p({\bf r},{\bf v}"
    r"^{*},t) \mathrm{d}{\bf r} \frac {\mathrm{d}{\bf v}}{\mathit{e}} \rho_{0} |{\bf v}"
    r"^{*}| \delta \mathit{t} \mathrm{d}\mathit{b}",
    chain(
        Gamma_plus,
        Int(_ps * Measure(br) * Measure(bvs) * rho0 * vs * dt, b),
        Int(_ps * Measure(br) * Measure(bv) / e * rho0 * vs * dt, b),
    ),
)
_add(
    "ftdiff",
    "kinetic equation over the impact parameter",
    r"\frac{\partial p({\bf r},{\bf v},t)}{\partial t}+({\bf v}\cdot \nabla)p({\bf r}"
    r",{\bf v},t)= \rho_{0}\int [|{\bf v}^{*}|\frac{p({\bf r},{\bf v}^{*},t)}{e}-|{\bf v}"
    r"|p({\bf r},{\bf v},t)] \mathrm{d}\mathit{b}",
    eq(_streaming, rho0 * Int(vs * _ps / e - v * _p, b)),
)
_add(
    "rewrite",
    "impact parameter to unit vector",
    r"|{\bf v}|\mathrm{d}\mathit{b} = B(|{\bf v}|,{\bf \hat{\sigma}})\mathrm{d}{\bf "
    r"\hat{\sigma}}",
    eq(v * Measure(b), Brate(v, sigma) * Measure(sigma)),
)
_add(
    "bexpress",
    "its Jacobian, loss",
    r"B(|{\bf v}|,{\bf \hat{\sigma}})=|{\bf v}|d \cos(\pi-\psi) =d ({\bf v} \cdot {\bf "
    r"\hat{\sigma}})",
    chain(Brate(v, sigma), v * d * sp.cos(sp.pi - psi), d * dot(bv, sigma)),
)
_add(
    "bexpress2",
    "its Jacobian, gain",
    r"B(|{\bf v}^{*}|,{\bf \hat{\sigma}})=|{\bf v}^{*}|d \cos(\pi-\psi) =-d ({\bf v}^{*} "
    r"\cdot {\bf \hat{\sigma}})=d \frac{({\bf v} \cdot {\bf \hat{\sigma}})}{e}",
    chain(
        Brate(vs, sigma),
        vs * d * sp.cos(sp.pi - psi),
        -d * dot(bvs, sigma),
        d * dot(bv, sigma) / e,
    ),
)
_add(
    "inelaslorentz",
    "the inelastic Lorentz equation",
    r"\frac{\partial p({\bf r},{\bf v},t)}{\partial t}+({\bf v}\cdot \nabla)p({\bf r}"
    r",{\bf v},t)=d \rho_{0}\int_{{\bf v} \cdot {\bf \hat{\sigma}}>0} ({\bf v} \cdot {\bf "
    r"\hat{\sigma}}) [\frac{p({\bf r},{\bf v}^{*},t)}{e^{2}}-p({\bf r},{\bf v},t)] "
    r"\mathrm{d}{\bf \hat{\sigma}}",
    eq(_streaming, d * rho0 * Int(dot(bv, sigma) * (_ps / e**2 - _p), sigma, hemi)),
)
