"""Section 3 (compare3) and Appendix B: the Sonine expansion of the scaled VDF."""

from __future__ import annotations

import sympy as sp

from ..symbols import M2, M4, H, a2, a2bar, a2t, d, da2, e, pm, rho0, t, v0
from .entry import Section, eq

SECTION = Section("Appendix B: cooling rate")
_add = SECTION.add
_root = sp.sqrt(-383 + 828 * e**2 + 900 * e**4)

_add(
    "sonine7",
    "the equation for a_2",
    r"4 M_{2}(a_{2}+1)-M_{4}=0",
    eq(4 * M2 * (a2 + 1) - M4, sp.Integer(0)),
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
    r"a_{2}=\frac{1}{24}(1+30e^{2}\pm\sqrt{-383+828e^{2}+900e^{4}})"
    r" \quad \mathrm{if} \quad  \mathit{e} \mathrm{\ne 1}",
    eq(a2, sp.Rational(1, 24) * (1 + 30 * e**2 + pm * _root)),
)
_add(
    "sonine12",
    "the root adopted for a_2",
    r"a_{2}=\frac{1}{24}(1+30e^{2}-\sqrt{-383+828e^{2}+900e^{4}})",
    eq(a2, sp.Rational(1, 24) * (1 + 30 * e**2 - _root)),
)
_add(
    "ac3",
    "evolution of a_2",
    r"\frac{\partial a_{2}(t)}{\partial t}=\frac{d \rho_{0}v_{0}(t)}{2}"
    r"\{4M_{2}(a_{2}(t)+1)-M_{4}\}",
    eq(sp.Derivative(a2t(t), t), d * rho0 * v0(t) / 2 * (4 * M2 * (a2t(t) + 1) - M4)),
)
_add(
    "ac5",
    "linearised evolution of a_2",
    r"\frac{\partial \delta a_{2}(t)}{\partial t}=\frac{d \rho_{0}}{2}\sqrt{\pi}(1-e^{2})H(e)"
    r"v_{0}(t)\delta a_{2}(t)",
    eq(
        sp.Derivative(da2(t), t),
        d * rho0 / 2 * sp.sqrt(sp.pi) * (1 - e**2) * H * v0(t) * da2(t),
    ),
)
_add(
    "ac7",
    "growth rate H(e) of a perturbation of a_2",
    r"H(e)\equiv 3\bar{a}_{2}-(\frac{15}{4}e^{2}+\frac{1}{8})",
    eq(H, 3 * a2bar - (sp.Rational(15, 4) * e**2 + sp.Rational(1, 8))),
)
_add(
    "compare1",
    "restitution below which the Sonine a_2 is not real",
    r"\sqrt{-\frac{23}{50}+\frac{16 \sqrt{14}}{75}}\leq e \quad( < 1)",
    sp.Le(sp.sqrt(-sp.Rational(23, 50) + 16 * sp.sqrt(14) / 75), e, evaluate=False),
)
_M2_source = (
    r"M_{2}=\sqrt{\pi}(1-e^{2})(\frac{65}{64}+\frac{15}{32}e^{2}-\frac{1}{64}"
    r"\sqrt{-383+828e^{2}+900e^{4}})"
)
for _label in ("compare3", "compare3#2"):
    _add(
        _label,
        "M_2 as a function of e, Sonine",
        _M2_source,
        eq(
            M2,
            sp.sqrt(sp.pi)
            * (1 - e**2)
            * (sp.Rational(65, 64) + sp.Rational(15, 32) * e**2 - sp.Rational(1, 64) * _root),
        ),
    )
