"""Results beyond the paper for what drives a tracer, or holds it, as they are stated."""

from __future__ import annotations

import sympy as sp
from sympy import Rational as Q
from sympy import exp, pi, sqrt

from ..formal import Avg, Partial, eq
from ..symbols import (
    bath,
    bath_pull,
    bath_rate,
    bv,
    capture,
    collided,
    depth,
    diffusivity,
    dim,
    drag,
    drift,
    effective,
    f0,
    heat,
    hot,
    lam,
    masses,
    mobility,
    p,
    relative,
    t,
    v,
)
from .rows import Result

half = Q(1, 2)
kick = 1 + effective
bath_rate_v = bath_rate(v)
bath_pull_v = bath_pull(v)


def bath_moments(share: sp.Expr, dimension: int) -> tuple[sp.Eq, sp.Eq]:
    """Return what a bath does to v and to v^2; share: E[cos^2] of the angle to the normal."""
    heating = kick * bath**2 * bath_rate_v * (dimension + 1)
    cooling = (1 - effective) * bath_pull_v
    return (
        eq(collided(bv), -share * (kick * bath_pull_v / v**2 * bv)),
        eq(collided(v**2), share * (kick * (heating - cooling))),
    )


DRIVEN: tuple[Result, ...] = (
    Result(
        label="beyond:bath-temperature",
        title=("bath: the steady Maxwellian of the tracer, with its mass ratio if it were elastic"),
        formulas=(
            eq(hot**2, bath**2 * kick / (1 - effective)),
            eq(masses, kick / (1 - effective)),
            eq(hot**2 / bath**2, (1 + relative) * masses / (2 + (1 - relative) * masses)),
        ),
    ),
    Result(
        label="beyond:bath-moments",
        title="bath: what collisions do to v and to v^2, in the plane, in space",
        formulas=(
            *bath_moments(Q(2, 3), 2),
            *bath_moments(half, 3),
        ),
    ),
    Result(
        label="beyond:bath-from-rest",
        title="bath: growth of <v^2> of a tracer at rest, in the plane, in space",
        formulas=(
            eq(collided(v**2), kick**2 * bath**3 * sqrt(2 * pi)),
            eq(collided(v**2), 4 * kick**2 * bath**3 * sqrt(2 / pi)),
        ),
    ),
    Result(
        label="beyond:bath-einstein",
        title="bath: Einstein's relation of a weak field",
        formulas=(eq(mobility, diffusivity / hot**2),),
    ),
    Result(
        label="beyond:heated-moments",
        title=("noise and drag: moments over time; steady ones in steps of three, and the energy"),
        formulas=(
            eq(
                Partial(Avg(v**p), t),
                p * (p + dim - 2) * heat * Avg(v ** (p - 2))
                - p * drag * Avg(v**p)
                - lam(p) * Avg(v ** (p + 1)),
            ),
            eq(lam(p + 2) * Avg(v ** (p + 3)), (p + 2) * (p + dim) * heat * Avg(v**p)),
            eq(lam(2) * Avg(v**3) + 2 * drag * Avg(v**2), 2 * dim * heat),
        ),
    ),
    Result(
        label="beyond:heated-e-zero",
        title=(
            "noise and drag at e = 0, in the plane and in space: f over a factor, D_v = "
            "1, without drag and at gamma_v = 1"
        ),
        formulas=(
            eq(f0(v), sp.airyai(v)),
            eq(f0(v), (v + 2) * exp(-v - v**2 / 2)),
        ),
    ),
    Result(
        label="beyond:stick-depth",
        title="rare sticking in a field: depth of capture, in the plane, in space",
        formulas=(
            eq(depth, 2 * drift / (capture**2 * Avg(1 / v))),
            eq(depth, drift / (capture**2 * Avg(1 / v))),
        ),
    ),
)
"""A bath, noise with drag, and sticking; lengths in l."""
