"""Section 3.3: the scaled position distribution G(R)."""

from __future__ import annotations

import sympy as sp

from .. import symbols as s
from ..formal import Second, chain, eq
from .equation import Section

SECTION = Section("Section 3: position distribution")
_add = SECTION.add
_D_integral = sp.Integral(s.De(s.V, s.t1), (s.t1, 0, s.t))
_curvature = Second(s.pd(s.V, s.R), s.V, s.Vs)

_add(
    "normg",
    "position distribution at one hopping velocity",
    r"\tilde{g}_{e}(r,t)\simeq \frac{1}{4\int^{t}_{0}D_{e}(V,t^{\prime})\mathrm{d}"
    r"\mathit{t}^{\prime}} r \exp[-\frac{r^{2}}{8\int^{t}_{0}D_{e}(V,t^{\prime})\mathrm{d}"
    r"\mathit{t}^{\prime}}]",
    eq(s.gt(s.r, s.t), 1 / (4 * _D_integral) * s.r * sp.exp(-(s.r**2) / (8 * _D_integral))),
)
_add(
    "ddif",
    "diffusion coefficient at one hopping velocity",
    r"D_{e}(V,t^{\prime})\equiv\frac{\kappa V^{2} l}{\alpha+\beta t^{\prime}}",
    eq(s.De(s.V, s.t1), s.kappa_d * s.V**2 * s.l / (s.alpha + s.beta * s.t1)),
)
_add(
    "L",
    "scaled hopping velocity",
    r"V\equiv \Bigl|\frac{{\bf l}/\tau}{v_{0}(t^{\prime})}\Bigr|",
    eq(s.V, sp.Abs(s.bl / s.tau1 / s.v0(s.t1))),
)
_add(
    "eta",
    "definition of eta",
    r"\eta\equiv\frac{4\int^{t}_{0}D_{e}(V,t^{\prime})\mathrm{d}\mathit{t}^{\prime}}{V^{2}"
    r"\langle{\bf r}^{2}(t)\rangle_{e}}",
    eq(s.eta, 4 * _D_integral / (s.V**2 * s.msd(s.t))),
)
_add(
    "etadif",
    "eta from the random walk",
    r"\eta = \frac {4\kappa\ln(1+l\beta)}{l\beta}",
    eq(s.eta, 4 * s.kappa_d * sp.log(1 + s.l * s.beta) / (s.l * s.beta)),
)
_add(
    "posivel",
    "scaled position distribution at one hopping velocity",
    r"\tilde{G}(R,V)= \frac{1}{\eta V^{2}}R\mathrm{e}^{-\frac{\mathit{R}^{\mathrm{2}}}"
    r"{2\eta \mathit{V}^{\mathrm{2}}}}",
    eq(s.Gt(s.R, s.V), 1 / (s.eta * s.V**2) * s.R * sp.exp(-(s.R**2) / (2 * s.eta * s.V**2))),
)
_add(
    "gdefi",
    "scaled position distribution",
    r"G(R) = \int^{\infty}_{0}\frac{\mathrm{e}^{{-\mathit{V}^{\mathrm{2}}}}}{\pi}\frac{1}"
    r"{\eta \mathit{V}^{\mathrm{2}}}\mathit{R} \mathrm{e}^{-\frac{\mathit{R}^{\mathrm{2}}}"
    r"{2\eta \mathit{V}^{\mathrm{2}}}}2\pi \mathit{V} \mathrm{d}\mathit{V} = \frac{2}"
    r"{\eta}R\int_{0}^{\infty}\mathrm{e}^{-\mathit{p}(V,R)R^{\mathrm{2}}}\mathrm{d}"
    r"\mathit{V}",
    chain(
        s.G(s.R),
        sp.Integral(
            sp.exp(-(s.V**2))
            / sp.pi
            / (s.eta * s.V**2)
            * s.R
            * sp.exp(-(s.R**2) / (2 * s.eta * s.V**2))
            * 2
            * sp.pi
            * s.V,
            (s.V, 0, sp.oo),
        ),
        2 / s.eta * s.R * sp.Integral(sp.exp(-s.pd(s.V, s.R) * s.R**2), (s.V, 0, sp.oo)),
    ),
)
_add(
    "pdefi",
    "exponent of the integrand",
    r"p(V,R)\equiv\frac{\ln V}{R^2}+\frac{V^{2}}{R^2}+\frac{1}{2\eta V^{2}}",
    eq(s.pd(s.V, s.R), sp.log(s.V) / s.R**2 + s.V**2 / s.R**2 + 1 / (2 * s.eta * s.V**2)),
)
_add(
    "csolu",
    "its saddle",
    r"V^{*}(R)=\sqrt{-\frac{1}{4}+\frac{\sqrt{\eta+8R^2}}{4\sqrt{\eta}}}",
    eq(s.Vs, sp.sqrt(-sp.Rational(1, 4) + sp.sqrt(s.eta + 8 * s.R**2) / (4 * sp.sqrt(s.eta)))),
)
_add(
    "tailg",
    "steepest descent",
    r"G(R) \simeq \frac{2}{\eta}R\int_{0}^{\infty}\exp\left[ -p(V^{*},R)R^{2}"
    r"-\frac{(V-V^{*})^{2}}{2}\frac{\partial^{2} p(V,R)}{\partial V^{2}}\big|_{V=V^{*}} "
    r"R^{2}\right]\mathrm{d}\mathit{V} = \frac{2}{\eta}\sqrt{\frac{\pi}"
    r"{2\frac{\partial^{2} p(V,R)}{\partial V^{2} }|_{V=V^{*}}}}\mathrm{e}^{-\mathit{p}"
    r"(V^{*},R)R^{\mathrm{2}}}",
    chain(
        s.G(s.R),
        2
        / s.eta
        * s.R
        * sp.Integral(
            sp.exp(-s.pd(s.Vs, s.R) * s.R**2 - (s.V - s.Vs) ** 2 / 2 * _curvature * s.R**2),
            (s.V, 0, sp.oo),
        ),
        2 / s.eta * sp.sqrt(sp.pi / (2 * _curvature)) * sp.exp(-s.pd(s.Vs, s.R) * s.R**2),
    ),
)
_add(
    "semig",
    "tail of the scaled position distribution",
    r"G(R)\simeq \sqrt{\frac{{\pi R}}{2\sqrt{2}\eta^{\frac{3}{2}}}}\mathrm{e}"
    r"^{-\sqrt{\frac{2}{\eta}}\mathit{R}}",
    eq(
        s.G(s.R),
        sp.sqrt(sp.pi * s.R / (2 * sp.sqrt(2) * s.eta ** sp.Rational(3, 2)))
        * sp.exp(-sp.sqrt(2 / s.eta) * s.R),
    ),
)
_add(
    "gammatailg",
    "steepest descent with a fitted prefactor",
    r"G(R)= \frac{2\gamma}{\eta}\sqrt{\frac{\pi}{2\frac{\partial^{2} p(V,R)}{\partial "
    r"V^{2} }|_{V=V^{*}}}}\mathrm{e}^{-\mathit{p}(V^{*},R)R^{\mathrm{2}}}",
    eq(
        s.G(s.R),
        2 * s.gamma / s.eta * sp.sqrt(sp.pi / (2 * _curvature)) * sp.exp(-s.pd(s.Vs, s.R) * s.R**2),
    ),
)
_add(
    "peakg",
    "peak of the scaled position distribution",
    r"G(R) \simeq \frac{1}{\eta \bar{V}^{2}}R\mathrm{e}^{-\frac{\mathit{R}^{\mathrm{2}}}"
    r"{2\eta\bar{\mathit{V}}^{\mathrm{2}}}}",
    eq(s.G(s.R), 1 / (s.eta * s.Vbar**2) * s.R * sp.exp(-(s.R**2) / (2 * s.eta * s.Vbar**2))),
)
