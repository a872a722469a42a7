"""Appendix C: the diffusion coefficient in the first Sonine approximation."""

from __future__ import annotations

import sympy as sp

from .. import symbols as s
from ..formal import Int, Lam, dot, eq
from .equation import Section

SECTION = Section("Appendix C: diffusion coefficient")
_add = SECTION.add

_add(
    "ad1",
    "collision operator between two functions",
    r"\int \mathrm{d}{\bf v} \mathit{Y}({\bf v}) \Lambda X({\bf v}) = d \rho_{0}\int "
    r"\mathrm{d}{\bf v} \int_{{\bf v} \cdot {\bf \hat{\sigma}}>0} \mathrm{d}{\bf "
    r"\hat{\sigma}} ({\bf v} \cdot {\bf \hat{\sigma}}) \mathit{X}({\bf v}) [Y({\bf v}"
    r"^{\prime})-Y({\bf v})]",
    eq(
        Int(s.Y(s.bv) * Lam(s.X(s.bv)), s.bv),
        s.d
        * s.rho0
        * Int(
            Int(dot(s.bv, s.sigma) * s.X(s.bv) * (s.Y(s.bvp) - s.Y(s.bv)), s.sigma, s.hemi), s.bv
        ),
    ),
)
_add(
    "ad2",
    "postcollision velocity",
    r"{\bf v}^{\prime}={\bf v}-(1+e)({\bf v} \cdot {\bf \hat{\sigma}}){\bf \hat{\sigma}}",
    eq(s.bvp, s.bv - (1 + s.e) * dot(s.bv, s.sigma) * s.sigma),
)
_add(
    "ad3",
    "first Sonine approximation of B",
    r"{\bf B}({\bf v},T(t))\sim {\bf v} f_{a_{2}}({\bf v},t)",
    eq(s.Bv(s.bv, s.T(s.t)), s.bv * s.fa2(s.bv, s.t)),
)
_add(
    "ad4",
    "first Sonine approximation of f",
    r"f({\bf v},t) \simeq f_{a_{2}}({\bf v},t)",
    eq(s.f(s.bv, s.t), s.fa2(s.bv, s.t)),
)
_add(
    "ad5",
    "the Sonine VDF in terms of the temperature",
    r"f_{a_{2}}({\bf v},t) \equiv \frac{m}{2\pi T(t)} \exp[{-\frac{m}{2T(t)}{\bf v}^{2}}"
    r"]\{1+a_{2}(1-\frac{m}{T(t)}{\bf v}^{2}+\frac{m^{2}}{8T^{2}(t)}{\bf v}^{4})\}",
    eq(
        s.fa2(s.bv, s.t),
        s.m
        / (2 * sp.pi * s.T(s.t))
        * sp.exp(-s.m / (2 * s.T(s.t)) * s.v**2)
        * (1 + s.a2 * (1 - s.m / s.T(s.t) * s.v**2 + s.m**2 / (8 * s.T(s.t) ** 2) * s.v**4)),
    ),
)
_add(
    "ad6",
    "relaxation rate of the flux",
    r"\nu_{D}= \frac{d\rho_{0}(1+e)}{2}\sqrt{\frac{2\pi T(t)}{m}}(2+\frac{3}{4}a_{2})",
    eq(
        s.nuD,
        s.d
        * s.rho0
        * (1 + s.e)
        / 2
        * sp.sqrt(2 * sp.pi * s.T(s.t) / s.m)
        * (2 + sp.Rational(3, 4) * s.a2),
    ),
)
_add(
    "ad7",
    "diffusion coefficient, first Sonine approximation",
    r"D_{e}(t)=\sqrt{\frac{2T(t)}{\pi m}}\frac{1}{d\rho_{0}}\frac{1}{(e+1)^{2}(1+\frac{3}"
    r"{8}a_{2})}",
    eq(
        s.De(s.t),
        sp.sqrt(2 * s.T(s.t) / (sp.pi * s.m))
        / (s.d * s.rho0)
        / ((s.e + 1) ** 2 * (1 + sp.Rational(3, 8) * s.a2)),
    ),
)
_add(
    "ad8",
    "mean square displacement from the diffusion coefficient",
    r"\langle{\bf r}^{2}(t)\rangle_{e}=4\int^{t}_{0}D_{e}(t) \mathrm{d}\mathit{t}^{\prime}",
    eq(s.msd(s.t), 4 * sp.Integral(s.De(s.t), (s.t1, 0, s.t))),
)
_add(
    "ad8#2",
    "mean square displacement, first Sonine approximation",
    r"\langle{\bf r}^{2}(t)\rangle_{e}=\frac{8}{\pi d^{2}\rho_{0}^{2}}\frac{1}{(1+e)^{2}"
    r"(1-e^{2})(1+\frac{3}{8}a_{2})^{2}}\ln[1+\sqrt{\frac{\pi}{2}}d \rho_{0}(1-e^{2})"
    r"(1+\frac{3}{8}a_{2})t]",
    eq(
        s.msd(s.t),
        8
        / (sp.pi * s.d**2 * s.rho0**2)
        / ((1 + s.e) ** 2 * (1 - s.e**2) * (1 + sp.Rational(3, 8) * s.a2) ** 2)
        * sp.log(
            1
            + sp.sqrt(sp.pi / 2)
            * s.d
            * s.rho0
            * (1 - s.e**2)
            * (1 + sp.Rational(3, 8) * s.a2)
            * s.t
        ),
    ),
)
