"""Appendix B, first part: the scaled equation and its Sonine expansion."""

from __future__ import annotations

import sympy as sp

from .. import symbols as s
from ..formal import Avg, Int, Partial, chain, dot, eq
from .equation import Section

SECTION = Section("Appendix B: cooling rate")
_add = SECTION.add
_root = sp.sqrt(-383 + 828 * s.e**2 + 900 * s.e**4)

_add(
    "rearramu2",
    "thermal velocity by the second moment",
    r"\frac{\mathrm{d}\mathit{v_{\mathrm{0}}( t)}}{\mathrm{d}\mathit{t}}=-\frac{\rho_{0}d "
    r"\mathit{M}_{\mathrm{2}} \mathit{v}_{\mathrm{0}}^{\mathrm{2}}(\mathit{t}) }"
    r"{\mathrm{2}}",
    eq(sp.Derivative(s.v0(s.t), s.t), -s.rho0 * s.d * s.M2 * s.v0(s.t) ** 2 / 2),
)
_add(
    "ifmu2",
    "scaled equation",
    r"I(F)=\frac{ M_{2}}{2}( 2+{\bf c} \cdot \frac{\partial}{\partial {\bf c}}) F({\bf c})",
    eq(s.I_(s.F(s.bc)), s.M2 / 2 * (2 * s.F(s.bc) + dot(s.bc, Partial(s.F(s.bc), s.bc)))),
)
_add(
    "mueq",
    "its moments",
    r"M_{p}=\frac{M_{2}}{2}p\langle c^{p}\rangle",
    eq(s.Mp, s.M2 / 2 * s.p * Avg(s.c**s.p)),
)
_add(
    "sonine1",
    "Sonine expansion",
    r"F({\bf c})=\phi({\bf c})\{1+\sum_{p=1}^{\infty}a_{p}S_{p}({\bf c}^{2})\}",
    eq(s.F(s.bc), s.phi(s.bc) * (1 + sp.Sum(s.a(s.p) * s.S(s.p, s.c**2), (s.p, 1, sp.oo)))),
)
_add(
    "sonine1.5",
    "Sonine polynomials of order 0 and 1",
    r"S_{0}(x)=1 ,\quad S_{1}(x)=-x+1",
    sp.Tuple(eq(s.S(0, s.x), sp.Integer(1)), eq(s.S(1, s.x), -s.x + 1)),
)
_add(
    "sonine2",
    "Sonine polynomial of order 2",
    r"S_{2}(x)=\frac{1}{2}x^{2}-2x+1",
    eq(s.S(2, s.x), sp.Rational(1, 2) * s.x**2 - 2 * s.x + 1),
)
_add(
    "sonine3",
    "orthogonality",
    r"\int \mathrm{d}{\bf c} \phi({\bf c}) \mathit{S_{p}}({\bf c}^{\mathrm{2}})\mathit{S}"
    r"_{p^{\prime}}({\bf c}^{\mathrm{2}})=\delta_{pp^{\prime}}",
    eq(
        Int(s.phi(s.bc) * s.S(s.p, s.c**2) * s.S(s.pprime, s.c**2), s.bc),
        sp.KroneckerDelta(s.p, s.pprime),
    ),
)
_add(
    "sonine4",
    "Sonine coefficients as averages",
    r"a_{p}=\int \mathrm{d}{\bf c} \mathit{S_{\mathit{p}}}({\bf c}^{\mathrm{2}})\mathit{F}"
    r"({\bf c})=\langle S_{p}({\bf c}^{\mathrm{2}})\rangle",
    chain(s.a(s.p), Int(s.S(s.p, s.c**2) * s.F(s.bc), s.bc), Avg(s.S(s.p, s.c**2))),
)
_add(
    "sonine4.5",
    "first Sonine coefficient",
    r"a_{1}=-\langle{\bf c}^{2}\rangle+1=0",
    chain(s.a1, -Avg(s.c**2) + 1, sp.Integer(0)),
)
_add(
    "sonine5",
    "second Sonine coefficient",
    r"a_{2}=\frac{\langle{\bf c}^{4}\rangle}{2}-2\langle{\bf c}^{2}"
    r"\rangle+1=\frac{\langle{\bf c}^{4}\rangle}{2}-1",
    chain(s.a2, Avg(s.c**4) / 2 - 2 * Avg(s.c**2) + 1, Avg(s.c**4) / 2 - 1),
)
_add(
    "sonine6",
    "fourth moment by the second",
    r"M_{4}=2 M_{2}\langle{\bf c}^{4}\rangle",
    eq(s.M4, 2 * s.M2 * Avg(s.c**4)),
)
_add(
    "sonine7",
    "the equation for a_2",
    r"4 M_{2}(a_{2}+1)-M_{4}=0",
    eq(4 * s.M2 * (s.a2 + 1) - s.M4, sp.Integer(0)),
)
_add(
    "sonine8",
    "moments of the collision integral",
    r"M_{p} = \int \mathrm{d}{\bf c} \int_{{\bf c} \cdot {\bf \hat{\sigma}}>0} \mathrm{d}"
    r"{\bf \hat{\sigma}} ({\bf c} \cdot {\bf \hat{\sigma}}) \mathit{F}({\bf c}) (c^{p}"
    r"-c^{\prime p})",
    eq(
        s.Mp,
        Int(Int(dot(s.bc, s.sigma) * s.F(s.bc) * (s.c**s.p - s.cp**s.p), s.sigma, s.hemi_c), s.bc),
    ),
)
_add(
    "sonine9",
    "second moment of the collision integral",
    r"M_{2} = \sqrt{\pi}(1-e^{2})(1+\frac{3}{8}a_{2})",
    eq(s.M2, sp.sqrt(sp.pi) * (1 - s.e**2) * (1 + sp.Rational(3, 8) * s.a2)),
)
_add(
    "sonine10",
    "fourth moment of the collision integral",
    r"M_{4}=\sqrt{\pi}(1-e^{2})(3+2e^{2})(1+\frac{15}{8}a_{2})",
    eq(s.M4, sp.sqrt(sp.pi) * (1 - s.e**2) * (3 + 2 * s.e**2) * (1 + sp.Rational(15, 8) * s.a2)),
)
_add(
    "sonine11",
    "both roots for a_2",
    r"a_{2}=\frac{1}{24}(1+30e^{2}\pm\sqrt{-383+828e^{2}+900e^{4}}) \quad \mathrm{if} "
    r"\quad \mathit{e} \mathrm{\ne 1}",
    eq(s.a2, sp.Rational(1, 24) * (1 + 30 * s.e**2 + s.pm * _root)),
)
_add(
    "sonine12",
    "the root adopted for a_2",
    r"a_{2}=\frac{1}{24}(1+30e^{2}-\sqrt{-383+828e^{2}+900e^{4}})",
    eq(s.a2, sp.Rational(1, 24) * (1 + 30 * s.e**2 - _root)),
)
