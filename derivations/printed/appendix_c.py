"""Appendix C: the diffusion coefficient in the first Sonine approximation."""

from __future__ import annotations

import sympy as sp

from ..symbols import De, T, a2, d, e, m, msd, nuD, rho0, t, t1
from .entry import Section, eq

SECTION = Section("Appendix C: diffusion coefficient")
_add = SECTION.add

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
    r"D_{e}(t)=\sqrt{\frac{2T(t)}{\pi m}}\frac{1}{d\rho_{0}}"
    r"\frac{1}{(e+1)^{2}(1+\frac{3}{8}a_{2})}",
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
    r"\langle{\bf r}^{2}(t)\rangle_{e}=\frac{8}{\pi d^{2}\rho_{0}^{2}}"
    r"\frac{1}{(1+e)^{2}(1-e^{2})(1+\frac{3}{8}a_{2})^{2}}"
    r"\ln[1+\sqrt{\frac{\pi}{2}}d \rho_{0}(1-e^{2})(1+\frac{3}{8}a_{2})t]",
    eq(
        msd(t),
        8
        / (sp.pi * d**2 * rho0**2)
        / ((1 + e) ** 2 * (1 - e**2) * (1 + sp.Rational(3, 8) * a2) ** 2)
        * sp.log(1 + sp.sqrt(sp.pi / 2) * d * rho0 * (1 - e**2) * (1 + sp.Rational(3, 8) * a2) * t),
    ),
)
