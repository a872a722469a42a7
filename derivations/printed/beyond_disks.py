"""Results beyond the paper, for its own gas of smooth disks, as they are stated.

Notation: b^2 = 1 - e^2, with e the coefficient of restitution.
"""

from __future__ import annotations

import sympy as sp
from sympy import Rational as Q
from sympy import Sum, exp, log, pi, sqrt

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
from .rows import Result

half = Q(1, 2)
b = sqrt(1 - e**2)

SMOOTH_DISKS: tuple[Result, ...] = (
    Result(
        label="beyond:angular-average",
        title="an isotropic VDF: one average over the impact parameter",
        formulas=(eq(Partial(Avg(v**p), t), -2 * d * rho0 * lam(p) * Avg(v ** (p + 1))),),
    ),
    Result(
        label="beyond:mass",
        title="the collision operator keeps mass",
        formulas=(eq(Int(Lam(X(bv)), bv), 0),),
    ),
    Result(
        label="beyond:loss-p",
        title="loss of |v|^p per collision, any real p",
        formulas=(eq(lam(p), 1 - sp.hyper((1, -p / 2), (Q(3, 2),), 1 - e**2)),),
    ),
    Result(
        label="beyond:loss-even",
        title="loss of |v|^p per collision, symbolic even p = 2 q",
        formulas=(
            eq(
                lam(2 * q),
                1
                - Sum(
                    sp.binomial(q, k) * e ** (2 * (q - k)) * (1 - e**2) ** k / (2 * k + 1),
                    (k, 0, q),
                ),
            ),
        ),
    ),
    Result(
        label="beyond:loss-1",
        title="loss of |v|",
        formulas=(eq(lam(1), (1 - e**2 * sp.atanh(b) / b) / 2),),
    ),
    Result(
        label="beyond:loss-2",
        title="loss of energy",
        formulas=(eq(lam(2), Q(2, 3) * (1 - e**2)),),
    ),
    Result(
        label="beyond:log-loss",
        title="mean log loss kappa",
        formulas=(eq(klog, 1 - e * sp.acos(e) / b),),
    ),
    Result(
        label="beyond:cosine",
        title="mean cosine of the deflection",
        formulas=(
            eq(cos_chi, -e * sp.atanh(b) / b + (1 - e**2 * sp.atanh(b) / b) / (2 * (1 - e))),
        ),
    ),
    Result(
        label="beyond:collision-moment",
        title="M_p of the Sonine form for any real p",
        formulas=(eq(Mp, 2 * lam(p) * sp.gamma((p + 3) / 2) * (1 + a2 * (p**2 - 1) / 8)),),
    ),
    Result(
        label="beyond:sonine-n",
        title="Sonine polynomial of order N",
        formulas=(
            eq(S(N, x), Sum((-1) ** k * sp.binomial(N, k) * x**k / sp.factorial(k), (k, 0, N))),
        ),
    ),
    Result(
        label="beyond:moments",
        title="moments of the scaling solution",
        formulas=(
            eq(MY(1), 1 / klog),
            eq(MY(p + 1), p * MY(p) / lam(p)),
        ),
    ),
    Result(
        label="beyond:cooling-rate",
        title="exact cooling rate",
        formulas=(eq(h, 2 * sqrt(klog * lam(1))),),
    ),
    Result(
        label="beyond:a2",
        title="exact a_2",
        formulas=(eq(a2, 3 * klog * lam(1) / (lam(2) * lam(3)) - 1),),
    ),
    Result(
        label="beyond:cooling-small-e",
        title="h(e) as e -> 0, to order e^2",
        formulas=(
            eq(
                h, sqrt(2) * (1 - pi * e / 4 + e**2 * (half - pi**2 / 32 - log(2) / 2 + log(e) / 2))
            ),
        ),
    ),
    Result(
        label="beyond:cooling-near-1",
        title="h(e)/(1 - e) as e -> 1, to second order in delta = 1 - e",
        formulas=(eq(h / gap, Q(4, 3) + 2 * gap / 15 + 2 * gap**2 / 175),),
    ),
    Result(
        label="beyond:a2-limits",
        title="exact a_2 at e = 0 and as e -> 1",
        formulas=(
            eq(a2, 2),
            eq(a2, -half),
        ),
    ),
    Result(
        label="beyond:tail",
        title="tail of F: c^power exp(-rate c)",
        formulas=(
            eq(power, 1 / (1 - e**2) - 2),
            eq(rate, 2 / h),
        ),
    ),
    Result(
        label="beyond:ring",
        title="relative variance of the speed as e -> 1",
        formulas=(eq(width2, (1 - e**2) / 5),),
    ),
    Result(
        label="beyond:e-zero",
        title="the scaling solution at e = 0",
        formulas=(
            eq(F(bc), exp(-sqrt(2) * c) / (sqrt(2) * pi * c)),
            eq(M2 / 2, sqrt(2)),
        ),
    ),
    Result(
        label="beyond:slope",
        title="slope of <r^2> in ln t, over l^2",
        formulas=(eq(slope, 2 / (klog * (1 - cos_chi))),),
    ),
    Result(
        label="beyond:bessel",
        title="the paper's G(R) in closed form, its integral and second moment",
        formulas=(
            eq(G(R), 2 * R / eta * sp.besselk(0, R * sqrt(2 / eta))),
            eq(norm, 1),
            eq(Avg(R**2), 2 * eta),
        ),
    ),
    Result(
        label="beyond:position",
        title="flatness <R^4>/<R^2>^2 of the position as t -> oo",
        formulas=(eq(flatness, 2),),
    ),
)
"""The paper's gas: smooth disks, at low density."""
