"""Appendix D: the diffusion coefficient at one speed."""

from __future__ import annotations

import sympy as sp

from .. import symbols as s
from ..formal import Dt, Int, Lam, Partial, chain, dot, eq
from .equation import Section

SECTION = Section("Appendix D: diffusion at one speed")
_add = SECTION.add
_p0, _p1 = s.p0(s.br, s.bv, s.t), s.p1(s.br, s.bv, s.t)
_n = s.nd(s.br, s.v, s.t)
_B = s.Bv(s.bv, s.T(s.t))
_Bh = s.Bv(s.v * s.bvh, s.T(s.t))
_shell = s.delta(s.vh - 1)
_cooling = s.v0(s.t) / s.l * s.h * s.T(s.t)

_add(
    "ap1",
    "continuity over all speeds",
    r"\int2\pi v [\frac{\partial n({\bf r},v,t)}{\partial t}+\nabla \cdot {\bf J}({\bf r}"
    r",v,t)]\mathrm{d}\mathit{v}=\mathrm{0}",
    eq(
        Int(2 * sp.pi * s.v * (sp.Derivative(_n, s.t) + dot(s.nabla, s.J(s.br, s.v, s.t))), s.v),
        sp.Integer(0),
    ),
)
_add(
    "ap2",
    "density at one speed",
    r"n({\bf r},v,t)\equiv\int p({\bf r},v{\bf \hat{v}},t) \delta(|{\bf \hat{v}}|-1)"
    r"\mathrm{d}{\bf \hat{v}}",
    eq(_n, Int(s.pd(s.br, s.v * s.bvh, s.t) * _shell, s.bvh)),
)
_add(
    "ap3",
    "flux at one speed",
    r"{\bf J}({\bf r},v,t)\equiv\int v{\bf \hat{v}} p({\bf r},v{\bf \hat{v}},t)"
    r"\delta(|{\bf \hat{v}}|-1)\mathrm{d}{\bf \hat{v}}",
    eq(s.J(s.br, s.v, s.t), Int(s.v * s.bvh * s.pd(s.br, s.v * s.bvh, s.t) * _shell, s.bvh)),
)
_add(
    "ap4",
    "continuity at one speed",
    r"\frac{\partial n({\bf r},v,t)}{\partial t}+\nabla \cdot {\bf J}({\bf r},v,t)=0",
    eq(sp.Derivative(_n, s.t) + dot(s.nabla, s.J(s.br, s.v, s.t)), sp.Integer(0)),
)
_add(
    "ap6",
    "expansion of the time derivative of the density",
    r"\frac{\partial n({\bf r},v,t)}{\partial t}=\sum_{j=0}^{\infty}\epsilon^{j+1}"
    r"\partial_{t}^{(j)}n({\bf r},v,t)",
    eq(sp.Derivative(_n, s.t), sp.Sum(s.eps ** (s.j + 1) * Dt(s.j, _n), (s.j, 0, sp.oo))),
)
_add(
    "ap7",
    "its orders",
    r"\partial_{t}^{(j)} n({\bf r},v,t)=-\nabla^{(0)} \cdot {\bf J}^{(j)}({\bf r},v,t)",
    eq(Dt(s.j, _n), -dot(s.nabla0, s.Jj(s.br, s.v, s.t))),
)
_add(
    "ap8",
    "flux of order j",
    r"{\bf J}^{(j)}({\bf r},v,t)=\int v{\bf \hat{v}} p^{(j)}({\bf r},v{\bf \hat{v}},t)"
    r"\delta(|{\bf \hat{v}}|-1)\mathrm{d}{\bf \hat{v}}",
    eq(s.Jj(s.br, s.v, s.t), Int(s.v * s.bvh * s.pj(s.br, s.v * s.bvh, s.t) * _shell, s.bvh)),
)
_add(
    "ap11",
    "zeroth order",
    r"p^{(0)}({\bf r},{\bf v},t)=\frac{n({\bf r},v,t)}{m(v,t)}f({\bf v},t)",
    eq(_p0, _n / s.mn(s.v, s.t) * s.f(s.bv, s.t)),
)
_add(
    "ap11.5",
    "f summed over directions",
    r"m(v,t)\equiv\int f(v{\bf \hat{v}},t) \delta(|{\bf \hat{v}}|-1)\mathrm{d}{\bf \hat{v}"
    r"}",
    eq(s.mn(s.v, s.t), Int(s.f(s.v * s.bvh, s.t) * _shell, s.bvh)),
)
_add(
    "ap11.6",
    "flux of zeroth order",
    r"{\bf J}^{(0)}({\bf r},v,t)=v\frac{n({\bf r},v,t)}{m(v,t)}\int {\bf \hat{v}} f(v{\bf "
    r"\hat{v}},t)\delta(|{\bf \hat{v}}|-1)\mathrm{d}{\bf \hat{v}}=0",
    chain(
        s.J0(s.br, s.v, s.t),
        s.v * _n / s.mn(s.v, s.t) * Int(s.bvh * s.f(s.v * s.bvh, s.t) * _shell, s.bvh),
        sp.Integer(0),
    ),
)
_add(
    "ap12",
    "first order",
    r"(\partial_{t}^{(0)} n({\bf r},v,t))\frac{\partial p^{(0)}({\bf r},{\bf v},t)}"
    r"{\partial n({\bf r},v,t)}+\frac{\partial T(t)}{\partial t}\frac{\partial p^{(1)}"
    r"({\bf r},{\bf v},t)}{\partial T(t)} +({\bf v}\cdot\nabla^{(0)}n({\bf r},v,t))"
    r"\frac{\partial p^{(0)}({\bf r},{\bf v},t)}{\partial n({\bf r},v,t)} =\Lambda p^{(1)}"
    r"({\bf r},{\bf v},t)",
    eq(
        Dt(0, _n) * Partial(_p0, _n)
        + sp.Derivative(s.T(s.t), s.t) * Partial(_p1, s.T(s.t))
        + dot(s.bv, s.nabla0) * _n * Partial(_p0, _n),
        Lam(_p1),
    ),
)
_add(
    "ap12.5",
    "energy loss by the mean free path",
    r"\frac{dT( t)}{dt}=-\frac{v_{0}( t)}{l}h( e) T( t)",
    eq(sp.Derivative(s.T(s.t), s.t), -s.v0(s.t) / s.l * s.h * s.T(s.t)),
)
_add(
    "ap13",
    "first order with the zeroth inserted",
    r"(\frac{v_{0}( t)}{l}h( e)T(t)\frac{\partial }{\partial T(t)}+\Lambda) p^{(1)}({\bf "
    r"r},{\bf v},t)=({\bf v}\cdot\nabla^{(0)}n({\bf r},v,t))\frac{f({\bf v},t)}{m(v,t)}",
    eq(
        _cooling * Partial(_p1, s.T(s.t)) + Lam(_p1),
        dot(s.bv, s.nabla0) * _n * s.f(s.bv, s.t) / s.mn(s.v, s.t),
    ),
)
_add(
    "ap14",
    "form of the first-order solution",
    r"p^{(1)}({\bf r},{\bf v},t)={\bf B}({\bf v},T(t))\cdot\nabla^{(0)}n({\bf r},v,t)",
    eq(_p1, dot(_B, s.nabla0) * _n),
)
_add(
    "ap15",
    "equation for B",
    r"(\frac{v_{0}( t)}{l}h( e)T(t)\frac{\partial }{\partial T(t)}+\Lambda){\bf B}({\bf v}"
    r",T(t))={\bf v}\frac{f({\bf v},t)}{m(v,t)}",
    eq(_cooling * Partial(_B, s.T(s.t)) + Lam(_B), s.bv * s.f(s.bv, s.t) / s.mn(s.v, s.t)),
)
_add(
    "ap16",
    "first-order flux",
    r"{\bf J}^{(1)}({\bf r},v,t)=-D_{e}(v,t)\nabla^{(0)}n({\bf r},v,t)",
    eq(s.J1(s.br, s.v, s.t), -s.De(s.v, s.t) * s.nabla0 * _n),
)
_add(
    "ap17",
    "diffusion coefficient at one speed",
    r"D_{e}(v,t)\equiv -\frac{v}{2}\int {\bf \hat{v}}\cdot{\bf B}(v{\bf \hat{v}},T(t))"
    r"\delta(|{\bf \hat{v}}|-1)\mathrm{d}{\bf \hat{v}}",
    eq(s.De(s.v, s.t), -s.v / 2 * Int(dot(s.bvh, _Bh) * _shell, s.bvh)),
)
_add(
    "ap18",
    "equation for the diffusion coefficient",
    r"(\frac{v_{0}( t)}{l}h( e)T(t)\frac{\partial }{\partial T(t)}-\nu_{D})D_{e}(v,t) "
    r"=-\frac{v^{2}}{2}",
    eq(_cooling * Partial(s.De(s.v, s.t), s.T(s.t)) - s.nuD * s.De(s.v, s.t), -(s.v**2) / 2),
)
_add(
    "ap19",
    "relaxation rate of the flux",
    r"\nu_{D}\equiv-\frac{\int (\Lambda{\bf B}(v{\bf \hat{v}},T(t))\cdot v{\bf \hat{v}}"
    r"\delta(|{\bf \hat{v}}|-1)\mathrm{d}{\bf \hat{v}}}{\int \mathit{v}{\bf \hat{v}}"
    r"\cdot{\bf B}(v{\bf \hat{v}},T(t))\delta(|{\bf \hat{v}}|-\mathrm{1})\mathrm{d}{\bf "
    r"\hat{v}} }",
    eq(
        s.nuD,
        -Int(s.v * dot(Lam(_Bh), s.bvh) * _shell, s.bvh)
        / Int(s.v * dot(s.bvh, _Bh) * _shell, s.bvh),
    ),
)
_add(
    "ap20",
    "temperature dependence of the diffusion coefficient",
    r"\frac{\partial D_{e}(v,t)}{\partial T(t)}=-\frac{D_{e}(v,t)}{2T(t)}",
    eq(Partial(s.De(s.v, s.t), s.T(s.t)), -s.De(s.v, s.t) / (2 * s.T(s.t))),
)
_add(
    "ap21",
    "diffusion coefficient at one speed",
    r"D_{e}(v,t)=\frac{v^{2}}{2}(\frac{h( e)v_{0}( t)}{2l}+\nu_{D})^{-1}\sim \frac{v^{2}l}"
    r"{v_{0}(t)}",
    chain(
        s.De(s.v, s.t),
        s.v**2 / 2 / (s.h * s.v0(s.t) / (2 * s.l) + s.nuD),
        s.v**2 * s.l / s.v0(s.t),
    ),
)
_add(
    "ap21.5",
    "the same by the scaled hopping velocity",
    r"D_{e}(V,t)= \kappa\frac{V^{2} l}{\alpha+\beta t}",
    eq(s.De(s.V, s.t), s.kappa_d * s.V**2 * s.l / (s.alpha + s.beta * s.t)),
)
