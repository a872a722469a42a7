"""Results beyond the paper for any law of collisions, as they are stated.

Disks and spheres with any restitutions, disks that spin, and scatterers that have a mass. ``P1`` is
the Legendre polynomial of order 1 of cos(chi); ``chi1_z`` is chi_1(zeta) with zeta = v t/l.
"""

from __future__ import annotations

import sympy as sp
from sympy import Derivative, cos, exp, log, pi, sqrt
from sympy import Rational as Q

from ..formal import Avg, Int, Partial, dot, eq
from ..symbols import (
    S2,
    W1,
    F,
    Fhat,
    N,
    VarN,
    VarX,
    bc,
    bv,
    bvp,
    c,
    chance,
    chi,
    chi1,
    cos_chi,
    d,
    delta,
    e,
    effective,
    et,
    flatness,
    g,
    h,
    inertia,
    klog,
    l,
    lam,
    laplace,
    least_share,
    lethargy,
    masses,
    msd,
    msdN,
    nu1,
    nu2,
    p,
    r,
    relative,
    rho0,
    rho2,
    rho4,
    rho4z,
    rolling,
    s,
    sigma,
    speed_after,
    spin,
    spin_after,
    t,
    v,
    wave,
    y,
    zeta,
)
from .rows import Result

half = Q(1, 2)
cosine = cos(chi)
P1 = sp.legendre(1, cosine)
P2 = sp.legendre(2, cosine)
P3 = sp.legendre(3, cosine)
P4 = sp.legendre(4, cosine)

# the chain of <r^4>: a collision that multiplies the speed by s multiplies zeta = v t/l as well
zeta_after = s * zeta
chi1_z = chi1(zeta)
rho2_z = rho2(zeta)
S2_z = S2(zeta)
W1_z = W1(zeta)
rho4_z = rho4(zeta)

# the transform of the first flight
first_flight = sp.atan(wave / (1 + laplace)) / wave

# the share of the velocity of the rim that a collision takes
rub = (1 + rolling) * inertia / (1 + inertia)

# mass of a scatterer over that of the tracer
A = masses


def rate_of(function: sp.Expr) -> sp.Expr:
    """Return the derivative of a member of the chain by zeta."""
    return Derivative(function, zeta)


def elastic_quartic(first: sp.Expr | int, second: sp.Expr | int) -> sp.Eq:
    """Return the transform of the elastic <r^4> with the weights of its two decaying terms."""
    decaying = first / laplace + second / (laplace + nu2)
    return eq(rho4z(laplace), decaying / (laplace**2 * (laplace + nu1) ** 2))


ANY_LAW: tuple[Result, ...] = (
    Result(
        label="beyond:rule",
        title="the collision rule with tangential restitution",
        formulas=(eq(bvp, et * bv - (e + et) * dot(bv, sigma) * sigma),),
    ),
    Result(
        label="beyond:one-collision",
        title="speed ratio s and deflection chi of one collision, in the plane and in space",
        formulas=(
            eq(s**2, e**2 + (et**2 - e**2) * y**2),
            eq(s * cos(chi), -e + (e + et) * y**2),
        ),
    ),
    Result(
        label="beyond:measure-plane",
        title="impact parameter and mean free path in the plane",
        formulas=(
            eq(chance(y), half),
            eq(l, 1 / (2 * d * rho0)),
        ),
    ),
    Result(
        label="beyond:measure-space",
        title="impact parameter and mean free path in space",
        formulas=(
            eq(chance(y), 2 * y),
            eq(chance(y**2), 1),
            eq(l, 1 / (pi * d**2 * rho0)),
        ),
    ),
    Result(
        label="beyond:plane-equal",
        title="the plane with e_t = e",
        formulas=(
            eq(Avg(s**p), e**p),
            eq(klog, -log(e)),
            eq(cos_chi, -Q(1, 3)),
        ),
    ),
    Result(
        label="beyond:space-power",
        title="mean power of the speed ratio in space",
        formulas=(eq(Avg(s**p), 2 * (et ** (p + 2) - e ** (p + 2)) / ((p + 2) * (et**2 - e**2))),),
    ),
    Result(
        label="beyond:space-log",
        title="mean log loss kappa in space; the second with e_t = 1",
        formulas=(
            eq(klog, half + (e**2 * log(e) - et**2 * log(et)) / (et**2 - e**2)),
            eq(klog, half + e**2 * log(e) / (1 - e**2)),
        ),
    ),
    Result(
        label="beyond:space-cosine",
        title="mean cosine of the deflection in space",
        formulas=(eq(cos_chi, 2 * (et - e) / (3 * (et + e))),),
    ),
    Result(
        label="beyond:space-isotropic",
        title="in space with e_t = e (elastic spheres) the scattering is isotropic",
        formulas=(
            eq(chance(cos(chi)), half),
            *(eq(Avg(mode), 0) for mode in (P1, P2, P3, P4)),
        ),
    ),
    Result(
        label="beyond:space-cooling",
        title="exact cooling rate of smooth spheres (e_t = 1)",
        formulas=(
            eq(
                h,
                2
                * sqrt(half + e**2 * log(e) / (1 - e**2))
                * sqrt((1 - e) * (1 + 2 * e) / (1 + e) / 3),
            ),
        ),
    ),
    Result(
        label="beyond:space-e-zero",
        title="the scaling solution of smooth spheres at e = 0",
        formulas=(
            eq(lam(p), p / (p + 2)),
            eq(F(bc), 3 * exp(-sqrt(6) * c) / (2 * pi * c)),
            eq(Int(F(bc), bc), 1),
            eq(Avg(c**2), 1),
            eq(h, sqrt(6) / 3),
        ),
    ),
    Result(
        label="beyond:any-average",
        title="moments of the speed in any dimension",
        formulas=(eq(Partial(Avg(v**p), t), -lam(p) * Avg(v ** (p + 1)) / l),),
    ),
    Result(
        label="beyond:any-moments",
        title="scaled moments and cooling rate in any dimension",
        formulas=(
            eq(Avg(c), h / (2 * klog)),
            eq(Avg(c ** (p + 1)), p * h * Avg(c**p) / (2 * lam(p))),
            eq(h, 2 * sqrt(klog * lam(1))),
        ),
    ),
    Result(
        label="beyond:any-slope",
        title="displacement after N collisions and over time, in any dimension",
        formulas=(
            eq(
                msdN(N),
                2 * l**2 * (N / (1 - cos_chi) - cos_chi * (1 - cos_chi**N) / (1 - cos_chi) ** 2),
            ),
            eq(Partial(msd(t), log(t)), 2 * l**2 / (klog * (1 - cos_chi))),
        ),
    ),
    Result(
        label="beyond:collision-number",
        title="variances of collisions and path, per ln t at late times",
        formulas=(
            eq(VarN, (Avg(log(s) ** 2) - klog**2) / klog**3),
            eq(VarX, l**2 * Avg(log(s) ** 2) / klog**3),
        ),
    ),
    Result(
        label="beyond:spin-moments",
        title="disks that spin: <v^2> and <u^2> after a collision, u that of the rim",
        formulas=(
            eq(
                Avg(speed_after**2),
                (2 * e**2 + (1 - rub) ** 2) * Avg(v**2) / 3 + rub**2 * Avg(spin**2),
            ),
            eq(
                Avg(spin_after**2),
                rub**2 * Avg(v**2) / (3 * inertia**2) + (1 - rub / inertia) ** 2 * Avg(spin**2),
            ),
        ),
    ),
    Result(
        label="beyond:quartic-plane",
        title="the chain of <r^4> in the plane, harmonics i^m exp(i m phi)",
        formulas=(
            eq(rate_of(chi1_z), Avg(cos(chi) * chi1(zeta_after)) - chi1_z + 1),
            eq(rate_of(rho2_z), Avg(rho2(zeta_after)) - rho2_z + 2 * chi1_z),
            eq(rate_of(S2_z), Avg(cos(2 * chi) * S2(zeta_after)) - S2_z + chi1_z / 4),
            eq(rate_of(W1_z), Avg(cos(chi) * W1(zeta_after)) - W1_z - rho2_z / 8 - S2_z / 2),
            eq(rate_of(rho4_z), Avg(rho4(zeta_after)) - rho4_z - 64 * W1_z),
            eq(flatness, 2),
        ),
    ),
    Result(
        label="beyond:quartic-space",
        title="the chain of <r^4> in space, Legendre polynomials",
        formulas=(
            eq(rate_of(chi1_z), Avg(P1 * chi1(zeta_after)) - chi1_z + 1),
            eq(rate_of(rho2_z), Avg(rho2(zeta_after)) - rho2_z + 2 * chi1_z),
            eq(rate_of(S2_z), Avg(P2 * S2(zeta_after)) - S2_z + Q(2, 3) * chi1_z),
            eq(rate_of(W1_z), Avg(P1 * W1(zeta_after)) - W1_z + rho2_z / 6 + Q(2, 5) * S2_z),
            eq(rate_of(rho4_z), Avg(rho4(zeta_after)) - rho4_z + 40 * W1_z),
            eq(flatness, Q(5, 3)),
        ),
    ),
    Result(
        label="beyond:isotropic-plane",
        title="isotropic scattering at one speed in the plane, and its density of position",
        formulas=(
            eq(Fhat(wave, laplace), 1 / (sqrt((1 + laplace) ** 2 + wave**2) - 1)),
            eq(
                g(r, zeta),
                exp(-zeta) * delta(r - zeta)
                + r * exp(sqrt(zeta**2 - r**2) - zeta) / sqrt(zeta**2 - r**2),
            ),
        ),
    ),
    Result(
        label="beyond:isotropic-space",
        title="isotropic scattering at one speed in space",
        formulas=(eq(Fhat(wave, laplace), first_flight / (1 - first_flight)),),
    ),
    Result(
        label="beyond:quartic-elastic",
        title="elastic <r^4> as a Laplace transform: in the plane, in space",
        formulas=(
            elastic_quartic(16, 8),
            elastic_quartic(Q(40, 3), Q(32, 3)),
        ),
    ),
)
"""Tangential restitution, space, spin, and a chain of moments for any law."""

MASS_RATIO: tuple[Result, ...] = (
    Result(
        label="beyond:mass-map",
        title="the restitution of a fixed scatterer that has the effect of a mass A m",
        formulas=(eq(effective, (1 + relative) * A / (1 + A) - 1),),
    ),
    Result(
        label="beyond:mass-log-loss",
        title="mean log loss in space, alpha = 1: neutrons' xi, and its a",
        formulas=(
            eq(2 * klog, 1 + least_share * log(least_share) / (1 - least_share)),
            eq(least_share, ((A - 1) / (A + 1)) ** 2),
        ),
    ),
    Result(
        label="beyond:mass-cosine",
        title="mean cosine in space, alpha = 1: A >= 1, and A <= 1",
        formulas=(
            eq(cos_chi, Q(2, 3) / A),
            eq(cos_chi, 1 - A**2 / 3),
        ),
    ),
    Result(
        label="beyond:mass-age",
        title="the displacement in the mean log loss xi of the energy: Fermi's age",
        formulas=(eq(Partial(msd(t), log(t)) / l**2, 4 / (lethargy * (1 - cos_chi))),),
    ),
)
"""Scatterers at rest that have a mass."""
