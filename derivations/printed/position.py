"""Section 3.3: the scaled position distribution G(R)."""

from __future__ import annotations

import sympy as sp

from .. import symbols as s
from ..formal import Second, chain, eq

_D_integral = sp.Integral(s.De(s.V, s.t1), (s.t1, 0, s.t))
_curvature = Second(s.pd(s.V, s.R), s.V, s.Vs)

FORMULAS: dict[str, sp.Basic] = {
    "normg": eq(
        s.gt(s.r, s.t), 1 / (4 * _D_integral) * s.r * sp.exp(-(s.r**2) / (8 * _D_integral))
    ),
    "ddif": eq(s.De(s.V, s.t1), s.kappa_d * s.V**2 * s.l / (s.alpha + s.beta * s.t1)),
    "L": eq(s.V, sp.Abs(s.bl / s.tau1 / s.v0(s.t1))),
    "eta": eq(s.eta, 4 * _D_integral / (s.V**2 * s.msd(s.t))),
    "etadif": eq(s.eta, 4 * s.kappa_d * sp.log(1 + s.l * s.beta) / (s.l * s.beta)),
    "posivel": eq(
        s.Gt(s.R, s.V), 1 / (s.eta * s.V**2) * s.R * sp.exp(-(s.R**2) / (2 * s.eta * s.V**2))
    ),
    "gdefi": chain(
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
    "pdefi": eq(s.pd(s.V, s.R), sp.log(s.V) / s.R**2 + s.V**2 / s.R**2 + 1 / (2 * s.eta * s.V**2)),
    "csolu": eq(
        s.Vs, sp.sqrt(-sp.Rational(1, 4) + sp.sqrt(s.eta + 8 * s.R**2) / (4 * sp.sqrt(s.eta)))
    ),
    "tailg": chain(
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
    "semig": eq(
        s.G(s.R),
        sp.sqrt(sp.pi * s.R / (2 * sp.sqrt(2) * s.eta ** sp.Rational(3, 2)))
        * sp.exp(-sp.sqrt(2 / s.eta) * s.R),
    ),
    "gammatailg": eq(
        s.G(s.R),
        2 * s.gamma / s.eta * sp.sqrt(sp.pi / (2 * _curvature)) * sp.exp(-s.pd(s.Vs, s.R) * s.R**2),
    ),
    "peakg": eq(
        s.G(s.R), 1 / (s.eta * s.Vbar**2) * s.R * sp.exp(-(s.R**2) / (2 * s.eta * s.Vbar**2))
    ),
}
