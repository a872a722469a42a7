"""Results beyond the paper for a uniform field along z, as they are stated.

Times in sqrt(l/g) and speeds in sqrt(g l), g the acceleration. ``f0_v`` is f_0(v), and so on.
"""

from __future__ import annotations

import sympy as sp
from sympy import Rational as Q
from sympy import cos, exp, pi, sqrt

from ..formal import Avg, eq
from ..symbols import (
    Dperp,
    deficit,
    drift,
    e,
    f0,
    f1,
    f2,
    f3,
    klog,
    lam,
    lam1,
    p,
    row0,
    row1,
    row2,
    s,
    t,
    theta_z,
    v,
)
from .rows import Result

half = Q(1, 2)
b = sqrt(1 - e**2)
cosine = cos(theta_z)
f0_v = f0(v)
f1_v = f1(v)
f2_v = f2(v)
f3_v = f3(v)
# rates of exp(-rate v^4) as e -> 1
plane_decay = Q(2, 9) * deficit
space_decay = Q(3, 16) * deficit

UNIFORM_FIELD: tuple[Result, ...] = (
    Result(
        label="beyond:field-plane",
        title="field: harmonics cos(m phi) of the derivative by v_z, in the plane",
        formulas=(
            eq(row0(v), half * (sp.diff(f1_v, v) + f1_v / v)),
            eq(row1(v), half * (sp.diff(f2_v, v) + 2 * f2_v / v) + sp.diff(f0_v, v)),
            eq(
                row2(v),
                half * (sp.diff(f3_v, v) + 3 * f3_v / v) + half * (sp.diff(f1_v, v) - f1_v / v),
            ),
        ),
    ),
    Result(
        label="beyond:field-space",
        title="field: harmonics P_m(cos theta) of the derivative by v_z, in space",
        formulas=(
            eq(row0(v), (sp.diff(f1_v, v) + 2 * f1_v / v) / 3),
            eq(row1(v), Q(2, 5) * (sp.diff(f2_v, v) + 3 * f2_v / v) + sp.diff(f0_v, v)),
            eq(
                row2(v),
                Q(3, 7) * (sp.diff(f3_v, v) + 4 * f3_v / v)
                + Q(2, 3) * (sp.diff(f1_v, v) - f1_v / v),
            ),
        ),
    ),
    Result(
        label="beyond:field-moments",
        title="field: moments of the steady state, harmonics 0 and 1: in the plane, in space",
        formulas=(
            eq(lam(p) * Avg(v ** (p + 1)), p * Avg(v ** (p - 1) * cosine)),
            eq(
                lam1(p) * Avg(v ** (p + 1) * cosine),
                half * (p + 1) * Avg(v ** (p - 1))
                + half * (p - 1) * Avg(v ** (p - 1) * cos(2 * theta_z)),
            ),
            eq(
                lam1(p) * Avg(v ** (p + 1) * cosine),
                Q(1, 3) * (p + 2) * Avg(v ** (p - 1))
                + Q(2, 3) * (p - 1) * Avg(v ** (p - 1) * sp.legendre(2, cosine)),
            ),
        ),
    ),
    Result(
        label="beyond:field-exact",
        title="field: exact relations of the steady state",
        formulas=(
            eq(Avg(v**2 * cosine), 1 / lam1(1)),
            eq(Avg(v * cosine), lam(2) * Avg(v**3) / 2),
            eq(Avg(v**4), 3 * Avg(v**2 * cosine) / lam(3)),
            eq(Avg(cosine), lam(1) * Avg(v**2)),
            eq(Avg(cosine / v), klog * Avg(v)),
            eq(Avg(cosine / v**2), Avg(1 / s) - 1),
        ),
    ),
    Result(
        label="beyond:field-closed",
        title="field: <v v_z> and <cos/v^2> among smooth disks, and among smooth spheres",
        formulas=(
            eq(Avg(v**2 * cosine), 3 / (2 * (1 + e))),
            eq(Avg(cosine / v**2), sp.asinh(b / e) / b - 1),
            eq(Avg(v**2 * cosine), 2 / (1 + e)),
            eq(Avg(cosine / v**2), (1 - e) / (1 + e)),
        ),
    ),
    Result(
        label="beyond:field-nearly-elastic",
        title="field: f_0 over f_0(0), drift and D_perp as e -> 1: in the plane, in space",
        formulas=(
            eq(f0(v), exp(-plane_decay * v**4)),
            eq(drift, deficit / 3 * plane_decay ** (-Q(3, 4)) * sp.gamma(Q(5, 4)) / sqrt(pi)),
            eq(Dperp, Q(3, 8) * plane_decay ** (-Q(1, 4)) * sp.gamma(Q(3, 4)) / sqrt(pi)),
            eq(f0(v), exp(-space_decay * v**4)),
            eq(drift, deficit / 4 * space_decay ** (-Q(3, 4)) * sqrt(pi) / 2 / sp.gamma(Q(3, 4))),
            eq(Dperp, space_decay ** (-Q(1, 4)) / (3 * sp.gamma(Q(3, 4)))),
        ),
    ),
    Result(
        label="beyond:field-elastic",
        title=(
            "field at e = 1: f_0 at late times over its factor, in the plane and in "
            "space; from rest <v^3> at all times"
        ),
        formulas=(
            eq(f0(v), t ** (-Q(2, 3)) * exp(-8 * v**3 / (27 * t))),
            eq(Avg(v**3), Q(9, 4) * (t - Avg(v * cosine))),
            eq(f0(v), exp(-(v**3) / (3 * t)) / t),
            eq(Avg(v**3), 3 * (t - Avg(v * cosine))),
        ),
    ),
)
"""A tracer in a uniform field along z."""
