"""Appendix B, second part: time dependence and stability of a_2."""

from __future__ import annotations

import sympy as sp

from .. import symbols as s
from ..formal import Avg, Partial, eq
from .equation import Section

SECTION = Section("Appendix B: stability")
_add = SECTION.add

_add(
    "ac1",
    "time-dependent scaled VDF",
    r"f({\bf v},t)=\frac{n}{v_{0}^{2}(t)} F({\bf c}, t)",
    eq(s.f(s.bv, s.t), s.n / s.v0(s.t) ** 2 * s.F(s.bc, s.t)),
)
_add(
    "ac2",
    "evolution of its moments",
    r"\frac{1}{d\rho_{0}v_{0}(t)}\frac{\partial \langle{\bf c}^{p}\rangle}{\partial t}"
    r"-\frac{M_{2}}{2}p \langle{\bf c}^{p}\rangle+M_{p}=0",
    eq(
        1 / (s.d * s.rho0 * s.v0(s.t)) * Partial(Avg(s.c**s.p), s.t)
        - s.M2 / 2 * s.p * Avg(s.c**s.p)
        + s.Mp,
        sp.Integer(0),
    ),
)
_add(
    "ac3",
    "evolution of a_2",
    r"\frac{\partial a_{2}(t)}{\partial t}=\frac{d \rho_{0}v_{0}(t)}{2}\{4M_{2}(a_{2}(t)"
    r"+1)-M_{4}\}",
    eq(
        sp.Derivative(s.a2t(s.t), s.t),
        s.d * s.rho0 * s.v0(s.t) / 2 * (4 * s.M2 * (s.a2t(s.t) + 1) - s.M4),
    ),
)
_add(
    "ac4",
    "perturbation of a_2",
    r"a_{2}(t)=\bar{a}_{2}+\delta a_{2}(t)",
    eq(s.a2t(s.t), s.a2bar + s.da2(s.t)),
)
_add(
    "ac5",
    "linearised evolution of a_2",
    r"\frac{\partial \delta a_{2}(t)}{\partial t}=\frac{d \rho_{0}}{2}\sqrt{\pi}(1-e^{2})"
    r"H(e)v_{0}(t)\delta a_{2}(t)",
    eq(
        sp.Derivative(s.da2(s.t), s.t),
        s.d * s.rho0 / 2 * sp.sqrt(sp.pi) * (1 - s.e**2) * s.H * s.v0(s.t) * s.da2(s.t),
    ),
)
_add(
    "ac6",
    "its solution",
    r"\delta a_{2}(t)=\delta a_{2}(0)\exp[\frac{d \rho_{0}}{2}\sqrt{\pi}(1-e^{2})H(e)"
    r"\int^{t}_{0} v_{0}(t)\mathrm{d}\mathit{t}]",
    eq(
        s.da2(s.t),
        s.da2(0)
        * sp.exp(
            s.d
            * s.rho0
            / 2
            * sp.sqrt(sp.pi)
            * (1 - s.e**2)
            * s.H
            * sp.Integral(s.v0(s.t), (s.t, 0, s.t))
        ),
    ),
)
_add(
    "ac7",
    "growth rate H(e) of a perturbation of a_2",
    r"H(e)\equiv 3\bar{a}_{2}-(\frac{15}{4}e^{2}+\frac{1}{8})",
    eq(s.H, 3 * s.a2bar - (sp.Rational(15, 4) * s.e**2 + sp.Rational(1, 8))),
)
_add(
    "compare1",
    "restitution below which the Sonine a_2 is not real",
    r"\sqrt{-\frac{23}{50}+\frac{16 \sqrt{14}}{75}}\leq e \quad( < 1)",
    sp.Le(sp.sqrt(-sp.Rational(23, 50) + 16 * sp.sqrt(14) / 75), s.e, evaluate=False),
)
_add(
    "compare3#2",
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
