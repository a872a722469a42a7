"""Section 3.3: the Chapman-Enskog expansion, diffuse1 ... diffuse22."""

from __future__ import annotations

import sympy as sp

from .. import symbols as s
from ..formal import Dt, Int, Lam, Partial, dot, eq
from .equation import Section

SECTION = Section("Section 3: Chapman-Enskog")
_add = SECTION.add
_p, _p0, _p1 = s.pd(s.br, s.bv, s.t), s.p0(s.br, s.bv, s.t), s.p1(s.br, s.bv, s.t)
_n = s.nd(s.br, s.t)
_B = s.Bv(s.bv, s.T(s.t))

_add(
    "diffuse1",
    "kinetic equation",
    r"\frac{\partial p({\bf r},{\bf v},t)}{\partial t}+{\bf v}\cdot\nabla p({\bf r},{\bf "
    r"v},t)=\Lambda p({\bf r},{\bf v},t)",
    eq(sp.Derivative(_p, s.t) + dot(s.bv, s.nabla) * _p, Lam(_p)),
)
_add(
    "diffuse1.5",
    "collision operator",
    r"\Lambda p({\bf r},{\bf v},t)=d \rho_{0}\int_{{\bf v} \cdot {\bf \hat{\sigma}}>0} "
    r"({\bf v} \cdot {\bf \hat{\sigma}}) [\frac{p({\bf r},{\bf v}^{*},t)}{e^{2}}-p({\bf r}"
    r",{\bf v},t)] \mathrm{d}{\bf \hat{\sigma}}",
    eq(
        Lam(_p),
        s.d
        * s.rho0
        * Int(dot(s.bv, s.sigma) * (s.pd(s.br, s.bvs, s.t) / s.e**2 - _p), s.sigma, s.hemi),
    ),
)
_add(
    "diffuse2",
    "continuity",
    r"\frac{\partial n({\bf r},t)}{\partial t}+\nabla \cdot {\bf J}({\bf r},t)=0",
    eq(sp.Derivative(_n, s.t) + dot(s.nabla, s.J(s.br, s.t)), sp.Integer(0)),
)
_add(
    "diffuse3",
    "density of the tracer",
    r"n({\bf r},t)=\int \mathrm{d}{\bf v} \mathit{p}({\bf r},{\bf v},t)",
    eq(_n, Int(_p, s.bv)),
)
_add(
    "diffuse4",
    "flux of the tracer",
    r"{\bf J}({\bf r},t)=\int \mathrm{d}{\bf v} {\bf v} \mathit{p}({\bf r},{\bf v},t)",
    eq(s.J(s.br, s.t), Int(s.bv * _p, s.bv)),
)
_add(
    "diffuse5",
    "expansion of the distribution",
    r"p({\bf r},{\bf v},t)=p^{(0)}({\bf r},{\bf v},t)+\epsilon p^{(1)}({\bf r},{\bf v},t)"
    r"+\epsilon^{2}p^{(2)}({\bf r},{\bf v},t)+\cdots",
    eq(_p, _p0 + s.eps * _p1 + s.eps**2 * s.p2(s.br, s.bv, s.t)),
)
_add(
    "diffuse6",
    "expansion of the time derivative of the density",
    r"\frac{\partial n({\bf r},t)}{\partial t}=\sum_{j=0}^{\infty}\epsilon^{j+1}"
    r"\partial_{t}^{(j)}n({\bf r},t)",
    eq(sp.Derivative(_n, s.t), sp.Sum(s.eps ** (s.j + 1) * Dt(s.j, _n), (s.j, 0, sp.oo))),
)
_add(
    "diffuse7",
    "its orders",
    r"\partial_{t}^{(j)} n({\bf r},t)=-\nabla^{(0)} \cdot {\bf J}^{(j)}({\bf r},t)",
    eq(Dt(s.j, _n), -dot(s.nabla0, s.Jj(s.br, s.t))),
)
_add(
    "diffuse8",
    "flux of order j",
    r"{\bf J}^{(j)}({\bf r},t)=\int \mathrm{d}{\bf v} {\bf v} \mathit{p}^{(j)}({\bf r}"
    r",{\bf v},t)",
    eq(s.Jj(s.br, s.t), Int(s.bv * s.pj(s.br, s.bv, s.t), s.bv)),
)
_add(
    "diffuse9",
    "expansion of the gradient",
    r"\nabla =\epsilon\nabla^{(0)}+\epsilon^{2}\nabla^{(1)}+\cdots",
    eq(s.nabla, s.eps * s.nabla0 + s.eps**2 * s.nabla1),
)
_add(
    "diffuse10",
    "zeroth order",
    r"\frac{\partial T(t)}{\partial t}\frac{\partial p^{(0)}({\bf r},{\bf v},t)}{\partial "
    r"T(t)}=\Lambda p^{(0)}({\bf r},{\bf v},t)",
    eq(sp.Derivative(s.T(s.t), s.t) * Partial(_p0, s.T(s.t)), Lam(_p0)),
)
_add(
    "diffuse11",
    "its solution",
    r"p^{(0)}({\bf r},{\bf v},t)=\frac{n({\bf r},t)}{n}f({\bf v},t)",
    eq(_p0, _n / s.n * s.f(s.bv, s.t)),
)
_add(
    "diffuse12",
    "first order",
    r"(\partial_{t}^{(0)} n({\bf r},t))\frac{\partial p^{(0)}({\bf r},{\bf v},t)}"
    r"{\partial n({\bf r},t)}+\frac{\partial T(t)}{\partial t}\frac{\partial p^{(1)}({\bf "
    r"r},{\bf v},t)}{\partial T(t)} +({\bf v}\cdot\nabla^{(0)}n({\bf r},t))\frac{\partial "
    r"p^{(0)}({\bf r},{\bf v},t)}{\partial n({\bf r},t)} =\Lambda p^{(1)}({\bf r},{\bf v}"
    r",t)",
    eq(
        Dt(0, _n) * Partial(_p0, _n)
        + sp.Derivative(s.T(s.t), s.t) * Partial(_p1, s.T(s.t))
        + dot(s.bv, s.nabla0) * _n * Partial(_p0, _n),
        Lam(_p1),
    ),
)
_add(
    "diffuse13",
    "first order with the zeroth inserted",
    r"(\xi(t)T(t)\frac{\partial }{\partial T(t)}+\Lambda) p^{(1)}({\bf r},{\bf v},t)"
    r"=\frac{({\bf v}\cdot\nabla^{(0)}n({\bf r},t))}{n}f({\bf v},t)",
    eq(
        s.xi(s.t) * s.T(s.t) * Partial(_p1, s.T(s.t)) + Lam(_p1),
        dot(s.bv, s.nabla0) * _n / s.n * s.f(s.bv, s.t),
    ),
)
_add(
    "diffuse14",
    "form of the first-order solution",
    r"p^{(1)}({\bf r},{\bf v},t)={\bf B}({\bf v},T(t))\cdot\nabla^{(0)}n({\bf r},t)",
    eq(_p1, dot(_B, s.nabla0) * _n),
)
_add(
    "diffuse15",
    "equation for B",
    r"(\xi(t)T(t)\frac{\partial }{\partial T(t)}+\Lambda){\bf B}({\bf v},T(t))=\frac{{\bf "
    r"v}}{n}f({\bf v},t)",
    eq(s.xi(s.t) * s.T(s.t) * Partial(_B, s.T(s.t)) + Lam(_B), s.bv / s.n * s.f(s.bv, s.t)),
)
_add(
    "diffuse16",
    "first-order flux",
    r"{\bf J}^{(1)}({\bf r},t)=-D_{e}(t)\nabla^{(0)}n({\bf r},t)",
    eq(s.J1(s.br, s.t), -s.De(s.t) * s.nabla0 * _n),
)
_add(
    "diffuse17",
    "diffusion coefficient as an integral",
    r"D_{e}(t)\equiv -\frac{1}{2}\int \mathrm{d}{\bf v} {\bf v}\cdot {\bf B}({\bf v}"
    r",\mathit{T}(t))",
    eq(s.De(s.t), -sp.Rational(1, 2) * Int(dot(s.bv, _B), s.bv)),
)
_add(
    "diffuse18",
    "equation for the diffusion coefficient",
    r"(\xi(t)T(t)\frac{\partial }{\partial T(t)}-\nu_{D})D_{e}(t)=-\frac{T}{m}",
    eq(s.xi(s.t) * s.T(s.t) * Partial(s.De(s.t), s.T(s.t)) - s.nuD * s.De(s.t), -s.T(s.t) / s.m),
)
_add(
    "diffuse19",
    "relaxation rate of the flux",
    r"\nu_{D}\equiv-\frac{\int (\Lambda{\bf B})\cdot {\bf v}\mathrm{d}{\bf v}}{\int {\bf "
    r"B}\cdot{\bf v}\mathrm{d}{\bf v}}",
    eq(s.nuD, -Int(dot(Lam(_B), s.bv), s.bv) / Int(dot(_B, s.bv), s.bv)),
)
_add(
    "diffuse20",
    "temperature dependence of the diffusion coefficient",
    r"\frac{\partial D_{e}(t)}{\partial T(t)}=\frac{D_{e}(t)}{2T(t)}",
    eq(Partial(s.De(s.t), s.T(s.t)), s.De(s.t) / (2 * s.T(s.t))),
)
_add(
    "diffuse21",
    "diffusion coefficient",
    r"D_{e}(t)=\frac{T(t)}{m}(\nu_{D}-\frac{\xi(t)}{2})^{-1}",
    eq(s.De(s.t), s.T(s.t) / s.m / (s.nuD - s.xi(s.t) / 2)),
)
_add(
    "diffuse22",
    "diffusion equation",
    r"\partial_{t}^{(1)} n({\bf r},t)=D_{e}(t){\nabla^{(0)}}^{2}n({\bf r},t)",
    eq(Dt(1, _n), s.De(s.t) * s.nabla0**2 * _n),
)
