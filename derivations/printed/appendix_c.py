"""Appendix C: the diffusion coefficient in the first Sonine approximation."""

from __future__ import annotations

import sympy as sp

from ..formal import Int, Lam, dot, eq
from ..symbols import (
    Bv,
    De,
    T,
    X,
    Y,
    a2,
    bv,
    bvp,
    d,
    e,
    f,
    fa2,
    hemi,
    m,
    msd,
    nuD,
    rho0,
    sigma,
    t,
    t1,
    v,
)
from .entry import Section

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
        Int(Y(bv) * Lam(X(bv)), bv),
        d * rho0 * Int(Int(dot(bv, sigma) * X(bv) * (Y(bvp) - Y(bv)), sigma, hemi), bv),
    ),
)
_add(
    "ad2",
    "postcollision velocity",
    r"{\bf v}^{\prime}={\bf v}-(1+e)({\bf v} \cdot {\bf \hat{\sigma}}){\bf \hat{\sigma}}",
    eq(bvp, bv - (1 + e) * dot(bv, sigma) * sigma),
)
_add(
    "ad3",
    "first Sonine approximation of B",
    r"{\bf B}({\bf v},T(t))\sim {\bf v} f_{a_{2}}({\bf v},t)",
    eq(Bv(bv, T(t)), bv * fa2(bv, t)),
)
_add(
    "ad4",
    "first Sonine approximation of f",
    r"f({\bf v},t) \simeq f_{a_{2}}({\bf v},t)",
    eq(f(bv, t), fa2(bv, t)),
)
_add(
    "ad5",
    "the Sonine VDF in terms of the temperature",
    r"f_{a_{2}}({\bf v},t) \equiv \frac{m}{2\pi T(t)} \exp[{-\frac{m}{2T(t)}{\bf v}^{2}}"
    r"]\{1+a_{2}(1-\frac{m}{T(t)}{\bf v}^{2}+\frac{m^{2}}{8T^{2}(t)}{\bf v}^{4})\}",
    eq(
        fa2(bv, t),
        m
        / (2 * sp.pi * T(t))
        * sp.exp(-m / (2 * T(t)) * v**2)
        * (1 + a2 * (1 - m / T(t) * v**2 + m**2 / (8 * T(t) ** 2) * v**4)),
    ),
)
_add(
    "ad6",
    "relaxation rate of the flux",
    r"\nu_{D}= \frac{d\rho_{0}(1+e)}{2}\sqrt{\frac{2\pi T(t)}{m}}(2+\frac{3}{4}a_{2})",
    eq(
        nuD,
        d * rho0 * (1 + e) / 2 * sp.sqrt(2 * sp.pi * T(t) / m) * (2 + sp.Rational(3, 4) * a2),
    ),
)
_add(
    "ad7",
    "diffusion coefficient, first Sonine approximation",
    r"D_{e}(t)=\sqrt{\frac{2T(t)}{\pi m}}\frac{1}{d\rho_{0}}\frac{1}{(e+1)^{2}(1+\frac{3}"
    r"{8}a_{2})}",
    eq(
        De(t),
        sp.sqrt(2 * T(t) / (sp.pi * m))
        / (d * rho0)
        / ((e + 1) ** 2 * (1 + sp.Rational(3, 8) * a2)),
    ),
)
_add(
    "ad8",
    "mean square displacement from the diffusion coefficient",
    r"\langle{\bf r}^{2}(t)\rangle_{e}=4\int^{t}_{0}D_{e}(t) \mathrm{d}\mathit{t}^{\prime}",
    eq(msd(t), 4 * sp.Integral(De(t), (t1, 0, t))),
)
_add(
    "ad8#2",
    "mean square displacement, first Sonine approximation",
    r"\langle{\bf r}^{2}(t)\rangle_{e}=\frac{8}{\pi d^{2}\rho_{0}^{2}}\frac{1}{(1+e)^{2}"
    r"(1-e^{2})(1+\frac{3}{8}a_{2})^{2}}\ln[1+\sqrt{\frac{\pi}{2}}d \rho_{0}(1-e^{2})"
    r"(1+\frac{3}{8}a_{2})t]",
    eq(
        msd(t),
        8
        / (sp.pi * d**2 * rho0**2)
        / ((1 + e) ** 2 * (1 - e**2) * (1 + sp.Rational(3, 8) * a2) ** 2)
        * sp.log(1 + sp.sqrt(sp.pi / 2) * d * rho0 * (1 - e**2) * (1 + sp.Rational(3, 8) * a2) * t),
    ),
)
