"""Results beyond the paper as they are stated, apart from their derivation.

They play the part that the printed formulas play for the paper's labels: each is held against
what :mod:`derivations.beyond` derives, and a changed coefficient here must be noticed.
"""

from __future__ import annotations

import sympy as sp

from ..formal import Avg, Int, Lam, Partial, eq
from ..symbols import (
    M2,
    MY,
    F,
    G,
    Mp,
    N,
    R,
    S,
    X,
    a2,
    bc,
    bv,
    c,
    cos_chi,
    d,
    e,
    eta,
    flatness,
    gap,
    h,
    k,
    klog,
    lam,
    norm,
    p,
    power,
    q,
    rate,
    rho0,
    slope,
    t,
    v,
    width2,
    x,
)
from .entry import Section

SECTION = Section("Beyond the paper")
_half = sp.Rational(1, 2)
_b = sp.sqrt(1 - e**2)


def _add(label: str, title: str, formula: sp.Basic) -> None:
    SECTION.add(f"beyond:{label}", title, "", formula)


_add(
    "angular-average",
    "an isotropic VDF: one average over the impact parameter",
    eq(Partial(Avg(v**p), t), -2 * d * rho0 * lam(p) * Avg(v ** (p + 1))),
)
_add(
    "mass",
    "the collision operator keeps mass",
    eq(Int(Lam(X(bv)), bv), sp.Integer(0)),
)
_add(
    "loss-p",
    "loss of |v|^p per collision, any real p",
    eq(lam(p), 1 - sp.hyper((1, -p / 2), (sp.Rational(3, 2),), 1 - e**2)),
)
_add(
    "loss-even",
    "loss of |v|^p per collision, symbolic even p = 2 q",
    eq(
        lam(2 * q),
        1
        - sp.Sum(sp.binomial(q, k) * e ** (2 * (q - k)) * (1 - e**2) ** k / (2 * k + 1), (k, 0, q)),
    ),
)
_add("loss-1", "loss of |v|", eq(lam(1), (1 - e**2 * sp.atanh(_b) / _b) / 2))
_add("loss-2", "loss of energy", eq(lam(2), sp.Rational(2, 3) * (1 - e**2)))
_add("log-loss", "mean log loss kappa", eq(klog, 1 - e * sp.acos(e) / _b))
_add(
    "cosine",
    "mean cosine of the deflection",
    eq(
        cos_chi,
        -e * sp.atanh(_b) / _b + (1 - e**2 * sp.atanh(_b) / _b) / (2 * (1 - e)),
    ),
)
_add(
    "collision-moment",
    "M_p of the Sonine form for any real p",
    eq(Mp, 2 * lam(p) * sp.gamma((p + 3) / 2) * (1 + a2 * (p**2 - 1) / 8)),
)
_add(
    "sonine-n",
    "Sonine polynomial of order N",
    eq(S(N, x), sp.Sum((-1) ** k * sp.binomial(N, k) * x**k / sp.factorial(k), (k, 0, N))),
)
_add(
    "moments",
    "moments of the scaling solution",
    sp.Tuple(eq(MY(1), 1 / klog), eq(MY(p + 1), p * MY(p) / lam(p))),
)
_add("cooling-rate", "exact cooling rate", eq(h, 2 * sp.sqrt(klog * lam(1))))
_add("a2", "exact a_2", eq(a2, 3 * klog * lam(1) / (lam(2) * lam(3)) - 1))
_add(
    "cooling-small-e",
    "h(e) as e -> 0, to order e^2",
    eq(
        h,
        sp.sqrt(2)
        * (1 - sp.pi * e / 4 + e**2 * (_half - sp.pi**2 / 32 - sp.log(2) / 2 + sp.log(e) / 2)),
    ),
)
_add(
    "cooling-near-1",
    "h(e)/(1 - e) as e -> 1, to second order in delta = 1 - e",
    eq(h / gap, sp.Rational(4, 3) + 2 * gap / 15 + 2 * gap**2 / 175),
)
_add(
    "a2-limits",
    "exact a_2 at e = 0 and as e -> 1",
    sp.Tuple(eq(a2, sp.Integer(2)), eq(a2, -_half)),
)
_add(
    "tail",
    "tail of F: c^power exp(-rate c)",
    sp.Tuple(eq(power, 1 / (1 - e**2) - 2), eq(rate, 2 / h)),
)
_add("ring", "relative variance of the speed as e -> 1", eq(width2, (1 - e**2) / 5))
_add(
    "e-zero",
    "the scaling solution at e = 0",
    sp.Tuple(eq(F(bc), sp.exp(-sp.sqrt(2) * c) / (sp.sqrt(2) * sp.pi * c)), eq(M2 / 2, sp.sqrt(2))),
)
_add("slope", "slope of <r^2> in ln t, over l^2", eq(slope, 2 / (klog * (1 - cos_chi))))
_add(
    "bessel",
    "the paper's G(R) in closed form, its integral and second moment",
    sp.Tuple(
        eq(G(R), 2 * R / eta * sp.besselk(0, R * sp.sqrt(2 / eta))),
        eq(norm, sp.Integer(1)),
        eq(Avg(R**2), 2 * eta),
    ),
)
_add(
    "position",
    "flatness <R^4>/<R^2>^2 of the position as t -> oo",
    eq(flatness, sp.Integer(2)),
)
