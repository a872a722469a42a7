"""Results beyond the paper as they are stated, apart from their derivation.

They play the part that the printed formulas play for the paper's labels: each is held against
what :mod:`derivations.derived` derives, and a changed coefficient here must be noticed.
"""

from __future__ import annotations

import sympy as sp

from .. import symbols as s
from ..formal import Avg, Int, Lam, Partial, eq
from .equation import PrintedEquation

_half = sp.Rational(1, 2)
_b = sp.sqrt(1 - s.e**2)

_STATED: dict[str, tuple[str, sp.Basic]] = {
    "beyond:angular-average": (
        "an isotropic VDF: one average over the impact parameter",
        eq(Partial(Avg(s.v**s.p), s.t), -2 * s.d * s.rho0 * s.lam(s.p) * Avg(s.v ** (s.p + 1))),
    ),
    "beyond:mass": (
        "the collision operator keeps mass",
        eq(Int(Lam(s.X(s.bv)), s.bv), sp.Integer(0)),
    ),
    "beyond:loss-p": (
        "loss of |v|^p per collision, any real p",
        eq(s.lam(s.p), 1 - sp.hyper((1, -s.p / 2), (sp.Rational(3, 2),), 1 - s.e**2)),
    ),
    "beyond:loss-even": (
        "loss of |v|^p per collision, symbolic even p = 2 q",
        eq(
            s.lam(2 * s.q),
            1
            - sp.Sum(
                sp.binomial(s.q, s.k)
                * s.e ** (2 * (s.q - s.k))
                * (1 - s.e**2) ** s.k
                / (2 * s.k + 1),
                (s.k, 0, s.q),
            ),
        ),
    ),
    "beyond:loss-1": ("loss of |v|", eq(s.lam(1), (1 - s.e**2 * sp.atanh(_b) / _b) / 2)),
    "beyond:loss-2": ("loss of energy", eq(s.lam(2), sp.Rational(2, 3) * (1 - s.e**2))),
    "beyond:log-loss": ("mean log loss kappa", eq(s.klog, 1 - s.e * sp.acos(s.e) / _b)),
    "beyond:cosine": (
        "mean cosine of the deflection",
        eq(
            s.cos_chi, -s.e * sp.atanh(_b) / _b + (1 - s.e**2 * sp.atanh(_b) / _b) / (2 * (1 - s.e))
        ),
    ),
    "beyond:collision-moment": (
        "M_p of the Sonine form for any real p",
        eq(s.Mp, 2 * s.lam(s.p) * sp.gamma((s.p + 3) / 2) * (1 + s.a2 * (s.p**2 - 1) / 8)),
    ),
    "beyond:sonine-n": (
        "Sonine polynomial of order N",
        eq(
            s.S(s.N, s.x),
            sp.Sum(
                (-1) ** s.k * sp.binomial(s.N, s.k) * s.x**s.k / sp.factorial(s.k), (s.k, 0, s.N)
            ),
        ),
    ),
    "beyond:moments": (
        "moments of the scaling solution",
        sp.Tuple(eq(s.MY(1), 1 / s.klog), eq(s.MY(s.p + 1), s.p * s.MY(s.p) / s.lam(s.p))),
    ),
    "beyond:cooling-rate": ("exact cooling rate", eq(s.h, 2 * sp.sqrt(s.klog * s.lam(1)))),
    "beyond:a2": ("exact a_2", eq(s.a2, 3 * s.klog * s.lam(1) / (s.lam(2) * s.lam(3)) - 1)),
    "beyond:cooling-small-e": (
        "h(e) as e -> 0, to order e^2",
        eq(
            s.h,
            sp.sqrt(2)
            * (
                1
                - sp.pi * s.e / 4
                + s.e**2 * (_half - sp.pi**2 / 32 - sp.log(2) / 2 + sp.log(s.e) / 2)
            ),
        ),
    ),
    "beyond:cooling-near-1": (
        "h(e)/(1 - e) as e -> 1, to second order in delta = 1 - e",
        eq(s.h / s.gap, sp.Rational(4, 3) + 2 * s.gap / 15 + 2 * s.gap**2 / 175),
    ),
    "beyond:a2-limits": (
        "exact a_2 at e = 0 and as e -> 1",
        sp.Tuple(eq(s.a2, sp.Integer(2)), eq(s.a2, -_half)),
    ),
    "beyond:tail": (
        "tail of F: c^power exp(-rate c)",
        sp.Tuple(eq(s.power, 1 / (1 - s.e**2) - 2), eq(s.rate, 2 / s.h)),
    ),
    "beyond:ring": ("relative variance of the speed as e -> 1", eq(s.width2, (1 - s.e**2) / 5)),
    "beyond:e-zero": (
        "the scaling solution at e = 0",
        sp.Tuple(
            eq(s.F(s.bc), sp.exp(-sp.sqrt(2) * s.c) / (sp.sqrt(2) * sp.pi * s.c)),
            eq(s.M2 / 2, sp.sqrt(2)),
        ),
    ),
    "beyond:slope": (
        "slope of <r^2> in ln t, over l^2",
        eq(s.slope, 2 / (s.klog * (1 - s.cos_chi))),
    ),
    "beyond:bessel": (
        "the paper's G(R) in closed form, its integral and second moment",
        sp.Tuple(
            eq(s.G(s.R), 2 * s.R / s.eta * sp.besselk(0, s.R * sp.sqrt(2 / s.eta))),
            eq(s.norm, sp.Integer(1)),
            eq(Avg(s.R**2), 2 * s.eta),
        ),
    ),
    "beyond:position": (
        "flatness <R^4>/<R^2>^2 of the position as t -> oo",
        eq(s.flatness, sp.Integer(2)),
    ),
}

EQUATIONS = {
    label: PrintedEquation(label, title, "Beyond the paper", formula=formula)
    for label, (title, formula) in _STATED.items()
}
