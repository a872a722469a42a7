"""Sections 2 and 3.2: the collision rule, cooling, the scaling form."""

from __future__ import annotations

import sympy as sp

from ..formal import Int, dot, eq
from ..symbols import (
    I_,
    M2,
    F,
    G,
    Mp,
    R,
    T,
    bc,
    bcs,
    bv,
    bvs,
    c,
    d,
    e,
    f,
    g,
    h,
    hemi,
    hemi_c,
    m,
    msd1,
    n,
    p,
    r,
    rho0,
    sigma,
    t,
    v,
    v0,
)
from .entry import Section

SECTION = Section("Sections 2 and 3: cooling")
_add = SECTION.add

_add(
    "vchange",
    "the collision rule",
    r"{\bf v}={\bf v}^{*}-(1+e)({\bf v}^{*} \cdot {\bf \hat{\sigma}}){\bf \hat{\sigma}}",
    eq(bv, bvs - (1 + e) * dot(bvs, sigma) * sigma),
)
_add(
    "gtilde",
    "scaling of the position distribution, elastic",
    r"g(r,t) = \frac{1}{\sqrt{\langle{\bf r}^{2}(t)\rangle}} G(R)",
    eq(g(r, t), 1 / sp.sqrt(msd1(t)) * G(R)),
)
_add(
    "v0defi",
    "thermal velocity",
    r"v_{0}( t) \equiv \sqrt{\frac{1}{n} \int {\bf v}^{2}f({\bf v},t)\mathrm{d}{\bf v}}",
    eq(v0(t), sp.sqrt(1 / n * Int(v**2 * f(bv, t), bv))),
)
_add(
    "thermo",
    "temperature",
    r"T( t)=\frac{1}{2}mv_{0}^{2}( t)",
    eq(T(t), sp.Rational(1, 2) * m * v0(t) ** 2),
)
_add(
    "tdiff",
    "energy loss",
    r"\frac{\mathrm{d}\mathit{T}( t)}{\mathrm{d}\mathit{t}}=-2dv_{0}( t)\rho_{0}h( e) T( "
    r"t)",
    eq(sp.Derivative(T(t), t), -2 * d * v0(t) * rho0 * h * T(t)),
)
_add(
    "vdiff",
    "equation for the thermal velocity",
    r"\frac{\mathrm{d}\mathit{v}_{\mathrm{0}}\mathit{( t)}}{\mathrm{d}\mathit{t}}"
    r"=-d\rho_{0}h( e) v_{0}^{2}( t)",
    eq(sp.Derivative(v0(t), t), -d * rho0 * h * v0(t) ** 2),
)
_add(
    "veq",
    "thermal velocity over time",
    r"v_{0}( t)=\frac{1}{\frac{1}{v_{0}(0)}+d\rho_{0}h( e) t}",
    eq(v0(t), 1 / (1 / v0(0) + d * rho0 * h * t)),
)
_add(
    "hsimu",
    "cooling rate, fitted to the simulation",
    r"h( e)\simeq 1.45 \times (1-e)",
    eq(h, sp.Rational("1.45") * (1 - e)),
)
_add(
    "inelaslorentz2",
    "kinetic equation of a uniform tracer",
    r"\frac{\partial f({\bf v},t)}{\partial t}= d \rho_{0}\int_{{\bf v} \cdot {\bf "
    r"\hat{\sigma}}>0} ({\bf v} \cdot {\bf \hat{\sigma}}) [\frac{f({\bf v}^{*},t)}{e^{2}}"
    r"-f({\bf v},t)] \mathrm{d}{\bf \hat{\sigma}}",
    eq(
        sp.Derivative(f(bv, t), t),
        d * rho0 * Int(dot(bv, sigma) * (f(bvs, t) / e**2 - f(bv, t)), sigma, hemi),
    ),
)
_add(
    "tdepend",
    "scaling form of the velocity distribution",
    r"f({\bf v},t)=\frac{n}{v_{0}^{2}( t)} F({\bf c})",
    eq(f(bv, t), n / v0(t) ** 2 * F(bc)),
)
_add(
    "if",
    "dimensionless collision integral",
    r"I(F)\equiv \int_{{\bf c} \cdot {\bf \hat{\sigma}}>0} ({\bf c} \cdot {\bf "
    r"\hat{\sigma}}) [\frac{F({\bf c}^{*})}{e^{2}}-F({\bf c})] \mathrm{d}{\bf \hat{\sigma}"
    r"}",
    eq(I_(F(bc)), Int(dot(bc, sigma) * (F(bcs) / e**2 - F(bc)), sigma, hemi_c)),
)
_add(
    "mup",
    "its moments",
    r"M_{p} \equiv - \int c^{p} I(F) \mathrm{d}{\bf c}",
    eq(Mp, -Int(c**p * I_(F(bc)), bc)),
)
_add(
    "tdiff2",
    "energy loss by the second moment",
    r"\frac{\mathrm{d}\mathit{T}( t)}{\mathrm{d}\mathit{t}}=- d v_{0}( t) \rho_{0} M_{2} "
    r"T( t)",
    eq(sp.Derivative(T(t), t), -d * v0(t) * rho0 * M2 * T(t)),
)
_add("compare2", "cooling rate by the second moment", r"h(e)=\frac{M_{2}}{2}", eq(h, M2 / 2))
_add(
    "compare3",
    "M_2 as a function of e, Sonine",
    r"M_{2}=\sqrt{\pi}(1-e^{2})(\frac{65}{64}+\frac{15}{32}e^{2}-\frac{1}{64}"
    r"\sqrt{-383+828e^{2}+900e^{4}})",
    eq(
        M2,
        sp.sqrt(sp.pi)
        * (1 - e**2)
        * (
            sp.Rational(65, 64)
            + sp.Rational(15, 32) * e**2
            - sp.Rational(1, 64) * sp.sqrt(-383 + 828 * e**2 + 900 * e**4)
        ),
    ),
)
