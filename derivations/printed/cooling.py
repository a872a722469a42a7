"""Sections 2 and 3.2: the collision rule, cooling, the scaling form."""

from __future__ import annotations

import sympy as sp

from .. import symbols as s
from ..formal import Int, dot, eq
from .equation import Section

SECTION = Section("Sections 2 and 3: cooling")
_add = SECTION.add

_add(
    "vchange",
    "the collision rule",
    r"{\bf v}={\bf v}^{*}-(1+e)({\bf v}^{*} \cdot {\bf \hat{\sigma}}){\bf \hat{\sigma}}",
    eq(s.bv, s.bvs - (1 + s.e) * dot(s.bvs, s.sigma) * s.sigma),
)
_add(
    "gtilde",
    "scaling of the position distribution, elastic",
    r"g(r,t) = \frac{1}{\sqrt{\langle{\bf r}^{2}(t)\rangle}} G(R)",
    eq(s.g(s.r, s.t), 1 / sp.sqrt(s.msd1(s.t)) * s.G(s.R)),
)
_add(
    "v0defi",
    "thermal velocity",
    r"v_{0}( t) \equiv \sqrt{\frac{1}{n} \int {\bf v}^{2}f({\bf v},t)\mathrm{d}{\bf v}}",
    eq(s.v0(s.t), sp.sqrt(1 / s.n * Int(s.v**2 * s.f(s.bv, s.t), s.bv))),
)
_add(
    "thermo",
    "temperature",
    r"T( t)=\frac{1}{2}mv_{0}^{2}( t)",
    eq(s.T(s.t), sp.Rational(1, 2) * s.m * s.v0(s.t) ** 2),
)
_add(
    "tdiff",
    "energy loss",
    r"\frac{\mathrm{d}\mathit{T}( t)}{\mathrm{d}\mathit{t}}=-2dv_{0}( t)\rho_{0}h( e) T( "
    r"t)",
    eq(sp.Derivative(s.T(s.t), s.t), -2 * s.d * s.v0(s.t) * s.rho0 * s.h * s.T(s.t)),
)
_add(
    "vdiff",
    "equation for the thermal velocity",
    r"\frac{\mathrm{d}\mathit{v}_{\mathrm{0}}\mathit{( t)}}{\mathrm{d}\mathit{t}}"
    r"=-d\rho_{0}h( e) v_{0}^{2}( t)",
    eq(sp.Derivative(s.v0(s.t), s.t), -s.d * s.rho0 * s.h * s.v0(s.t) ** 2),
)
_add(
    "veq",
    "thermal velocity over time",
    r"v_{0}( t)=\frac{1}{\frac{1}{v_{0}(0)}+d\rho_{0}h( e) t}",
    eq(s.v0(s.t), 1 / (1 / s.v0(0) + s.d * s.rho0 * s.h * s.t)),
)
_add(
    "hsimu",
    "cooling rate, fitted to the simulation",
    r"h( e)\simeq 1.45 \times (1-e)",
    eq(s.h, sp.Rational("1.45") * (1 - s.e)),
)
_add(
    "inelaslorentz2",
    "kinetic equation of a uniform tracer",
    r"\frac{\partial f({\bf v},t)}{\partial t}= d \rho_{0}\int_{{\bf v} \cdot {\bf "
    r"\hat{\sigma}}>0} ({\bf v} \cdot {\bf \hat{\sigma}}) [\frac{f({\bf v}^{*},t)}{e^{2}}"
    r"-f({\bf v},t)] \mathrm{d}{\bf \hat{\sigma}}",
    eq(
        sp.Derivative(s.f(s.bv, s.t), s.t),
        s.d
        * s.rho0
        * Int(dot(s.bv, s.sigma) * (s.f(s.bvs, s.t) / s.e**2 - s.f(s.bv, s.t)), s.sigma, s.hemi),
    ),
)
_add(
    "tdepend",
    "scaling form of the velocity distribution",
    r"f({\bf v},t)=\frac{n}{v_{0}^{2}( t)} F({\bf c})",
    eq(s.f(s.bv, s.t), s.n / s.v0(s.t) ** 2 * s.F(s.bc)),
)
_add(
    "if",
    "dimensionless collision integral",
    r"I(F)\equiv \int_{{\bf c} \cdot {\bf \hat{\sigma}}>0} ({\bf c} \cdot {\bf "
    r"\hat{\sigma}}) [\frac{F({\bf c}^{*})}{e^{2}}-F({\bf c})] \mathrm{d}{\bf \hat{\sigma}"
    r"}",
    eq(
        s.I_(s.F(s.bc)),
        Int(dot(s.bc, s.sigma) * (s.F(s.bcs) / s.e**2 - s.F(s.bc)), s.sigma, s.hemi_c),
    ),
)
_add(
    "mup",
    "its moments",
    r"M_{p} \equiv - \int c^{p} I(F) \mathrm{d}{\bf c}",
    eq(s.Mp, -Int(s.c**s.p * s.I_(s.F(s.bc)), s.bc)),
)
_add(
    "tdiff2",
    "energy loss by the second moment",
    r"\frac{\mathrm{d}\mathit{T}( t)}{\mathrm{d}\mathit{t}}=- d v_{0}( t) \rho_{0} M_{2} "
    r"T( t)",
    eq(sp.Derivative(s.T(s.t), s.t), -s.d * s.v0(s.t) * s.rho0 * s.M2 * s.T(s.t)),
)
_add("compare2", "cooling rate by the second moment", r"h(e)=\frac{M_{2}}{2}", eq(s.h, s.M2 / 2))
_add(
    "compare3",
    "M_2 as a function of e, Sonine",
    r"M_{2}=\sqrt{\pi}(1-e^{2})(\frac{65}{64}+\frac{15}{32}e^{2}-\frac{1}{64}"
    r"\sqrt{-383+828e^{2}+900e^{4}})",
    eq(
        s.M2,
        sp.sqrt(sp.pi)
        * (1 - s.e**2)
        * (
            sp.Rational(65, 64)
            + sp.Rational(15, 32) * s.e**2
            - sp.Rational(1, 64) * sp.sqrt(-383 + 828 * s.e**2 + 900 * s.e**4)
        ),
    ),
)
