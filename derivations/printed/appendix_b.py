"""Appendix B, first part: the scaled equation and its Sonine expansion."""

from __future__ import annotations

import sympy as sp

from ..formal import Avg, Int, Partial, chain, dot, eq
from ..symbols import (
    I_,
    M2,
    M4,
    F,
    Mp,
    S,
    a,
    a1,
    a2,
    bc,
    c,
    cp,
    d,
    e,
    hemi_c,
    p,
    phi,
    pm,
    pprime,
    rho0,
    sigma,
    t,
    v0,
    x,
)
from .entry import Section

SECTION = Section("Appendix B: cooling rate")
_add = SECTION.add
_root = sp.sqrt(-383 + 828 * e**2 + 900 * e**4)

_add(
    "rearramu2",
    "thermal velocity by the second moment",
    r"\frac{\mathrm{d}\mathit{v_{\mathrm{0}}( t)}}{\mathrm{d}\mathit{t}}=-\frac{\rho_{0}d "
    r"\mathit{M}_{\mathrm{2}} \mathit{v}_{\mathrm{0}}^{\mathrm{2}}(\mathit{t}) }"
    r"{\mathrm{2}}",
    eq(sp.Derivative(v0(t), t), -rho0 * d * M2 * v0(t) ** 2 / 2),
)
_add(
    "ifmu2",
    "scaled equation",
    r"I(F)=\frac{ M_{2}}{2}( 2+{\bf c} \cdot \frac{\partial}{\partial {\bf c}}) F({\bf c})",
    eq(I_(F(bc)), M2 / 2 * (2 * F(bc) + dot(bc, Partial(F(bc), bc)))),
)
_add(
    "mueq",
    "its moments",
    r"M_{p}=\frac{M_{2}}{2}p\langle c^{p}\rangle",
    eq(Mp, M2 / 2 * p * Avg(c**p)),
)
_add(
    "sonine1",
    "Sonine expansion",
    r"F({\bf c})=\phi({\bf c})\{1+\sum_{p=1}^{\infty}a_{p}S_{p}({\bf c}^{2})\}",
    eq(F(bc), phi(bc) * (1 + sp.Sum(a(p) * S(p, c**2), (p, 1, sp.oo)))),
)
_add(
    "sonine1.5",
    "Sonine polynomials of order 0 and 1",
    r"S_{0}(x)=1 ,\quad S_{1}(x)=-x+1",
    sp.Tuple(eq(S(0, x), sp.Integer(1)), eq(S(1, x), -x + 1)),
)
_add(
    "sonine2",
    "Sonine polynomial of order 2",
    r"S_{2}(x)=\frac{1}{2}x^{2}-2x+1",
    eq(S(2, x), sp.Rational(1, 2) * x**2 - 2 * x + 1),
)
_add(
    "sonine3",
    "orthogonality",
    r"\int \mathrm{d}{\bf c} \phi({\bf c}) \mathit{S_{p}}({\bf c}^{\mathrm{2}})\mathit{S}"
    r"_{p^{\prime}}({\bf c}^{\mathrm{2}})=\delta_{pp^{\prime}}",
    eq(
        Int(phi(bc) * S(p, c**2) * S(pprime, c**2), bc),
        sp.KroneckerDelta(p, pprime),
    ),
)
_add(
    "sonine4",
    "Sonine coefficients as averages",
    r"a_{p}=\int \mathrm{d}{\bf c} \mathit{S_{\mathit{p}}}({\bf c}^{\mathrm{2}})\mathit{F}"
    r"({\bf c})=\langle S_{p}({\bf c}^{\mathrm{2}})\rangle",
    chain(a(p), Int(S(p, c**2) * F(bc), bc), Avg(S(p, c**2))),
)
_add(
    "sonine4.5",
    "first Sonine coefficient",
    r"a_{1}=-\langle{\bf c}^{2}\rangle+1=0",
    chain(a1, -Avg(c**2) + 1, sp.Integer(0)),
)
_add(
    "sonine5",
    "second Sonine coefficient",
    r"a_{2}=\frac{\langle{\bf c}^{4}\rangle}{2}-2\langle{\bf c}^{2}"
    r"\rangle+1=\frac{\langle{\bf c}^{4}\rangle}{2}-1",
    chain(a2, Avg(c**4) / 2 - 2 * Avg(c**2) + 1, Avg(c**4) / 2 - 1),
)
_add(
    "sonine6",
    "fourth moment by the second",
    r"M_{4}=2 M_{2}\langle{\bf c}^{4}\rangle",
    eq(M4, 2 * M2 * Avg(c**4)),
)
_add(
    "sonine7",
    "the equation for a_2",
    r"4 M_{2}(a_{2}+1)-M_{4}=0",
    eq(4 * M2 * (a2 + 1) - M4, sp.Integer(0)),
)
_add(
    "sonine8",
    "moments of the collision integral",
    r"M_{p} = \int \mathrm{d}{\bf c} \int_{{\bf c} \cdot {\bf \hat{\sigma}}>0} \mathrm{d}"
    r"{\bf \hat{\sigma}} ({\bf c} \cdot {\bf \hat{\sigma}}) \mathit{F}({\bf c}) (c^{p}"
    r"-c^{\prime p})",
    eq(Mp, Int(Int(dot(bc, sigma) * F(bc) * (c**p - cp**p), sigma, hemi_c), bc)),
)
_add(
    "sonine9",
    "second moment of the collision integral",
    r"M_{2} = \sqrt{\pi}(1-e^{2})(1+\frac{3}{8}a_{2})",
    eq(M2, sp.sqrt(sp.pi) * (1 - e**2) * (1 + sp.Rational(3, 8) * a2)),
)
_add(
    "sonine10",
    "fourth moment of the collision integral",
    r"M_{4}=\sqrt{\pi}(1-e^{2})(3+2e^{2})(1+\frac{15}{8}a_{2})",
    eq(M4, sp.sqrt(sp.pi) * (1 - e**2) * (3 + 2 * e**2) * (1 + sp.Rational(15, 8) * a2)),
)
_add(
    "sonine11",
    "both roots for a_2",
    r"a_{2}=\frac{1}{24}(1+30e^{2}\pm\sqrt{-383+828e^{2}+900e^{4}}) \quad \mathrm{if} "
    r"\quad \mathit{e} \mathrm{\ne 1}",
    eq(a2, sp.Rational(1, 24) * (1 + 30 * e**2 + pm * _root)),
)
_add(
    "sonine12",
    "the root adopted for a_2",
    r"a_{2}=\frac{1}{24}(1+30e^{2}-\sqrt{-383+828e^{2}+900e^{4}})",
    eq(a2, sp.Rational(1, 24) * (1 + 30 * e**2 - _root)),
)
