"""Appendices A to D as printed: kinetic equation, Sonine expansion, diffusion coefficient.

One row a formula, in the paper's order, to be read beside the paper. A piece that appears often has
a name that shows its arguments: ``p_rvt`` is p(r, v, t), and ``p_before`` is p(r, v*, t).
"""

from __future__ import annotations

import sympy as sp
from sympy import Derivative, Integral, Sum, cos, exp, log, oo, pi, sqrt
from sympy import Rational as Q

from ..formal import Avg, Dt, Int, Lam, Measure, Partial, chain, dot, eq
from ..symbols import (
    I_,
    J0,
    J1,
    M2,
    M4,
    Brate,
    Bv,
    De,
    F,
    Gamma_flow,
    Gamma_minus,
    Gamma_plus,
    H,
    J,
    Jj,
    Mp,
    S,
    T,
    V,
    X,
    Y,
    a,
    a1,
    a2,
    a2bar,
    a2t,
    alpha,
    b,
    bc,
    beta,
    br,
    bv,
    bvh,
    bvp,
    bvs,
    c,
    cp,
    d,
    da2,
    delta,
    dt,
    e,
    eps,
    f,
    fa2,
    h,
    hemi,
    hemi_c,
    j,
    kappa_d,
    l,
    m,
    mn,
    msd,
    n,
    nabla,
    nabla0,
    nd,
    nuD,
    p,
    p0,
    p1,
    pd,
    phi,
    pj,
    pm,
    pprime,
    psi,
    rho0,
    sigma,
    t,
    t1,
    v,
    v0,
    vh,
    vs,
    x,
)
from .rows import Transcription

# pieces that appear often, named by the function and its arguments
half = Q(1, 2)
T_t = T(t)
v0_t = v0(t)
f_vt = f(bv, t)
F_c = F(bc)
v_sigma = dot(bv, sigma)
p_rvt = pd(br, bv, t)
p_before = pd(br, bvs, t)
p0_rvt = p0(br, bv, t)
p1_rvt = p1(br, bv, t)
streaming = Derivative(p_rvt, t) + dot(bv, nabla) * p_rvt
dT_dt = Derivative(T_t, t)
n_rvt = nd(br, v, t)
J_rvt = J(br, v, t)
dn_dt = Derivative(n_rvt, t)
D_t = De(t)
D_v = De(v, t)
B_v = Bv(bv, T_t)
B_along = Bv(v * bvh, T_t)
unit_circle = delta(vh - 1)
cooling = v0_t / l * h * T_t
sqrt_of_quartic = sqrt(-383 + 828 * e**2 + 900 * e**4)

EQUATIONS: tuple[Transcription, ...] = (
    # A: the kinetic equation from gain and loss
    Transcription(
        number="A1",
        label="dtchange",
        formula=eq(
            (pd(br, bv, t + dt) - p_rvt) * Measure(br) * Measure(bv),
            -Gamma_minus + Gamma_plus + Gamma_flow,
        ),
    ),
    Transcription(
        number="A2",
        label="gammaflow",
        formula=eq(Gamma_flow, -Measure(br) * Measure(bv) * dt * dot(bv, nabla) * p_rvt),
    ),
    Transcription(
        number="A3",
        label="gamma-",
        formula=eq(Gamma_minus, Int(p_rvt * Measure(br) * Measure(bv) * rho0 * v * dt, b)),
    ),
    Transcription(
        number="A4",
        label="gamma+",
        formula=chain(
            Gamma_plus,
            Int(p_before * Measure(br) * Measure(bvs) * rho0 * vs * dt, b),
            Int(p_before * Measure(br) * Measure(bv) / e * rho0 * vs * dt, b),
        ),
    ),
    Transcription(
        number="A5",
        label="ftdiff",
        formula=eq(streaming, rho0 * Int(vs * p_before / e - v * p_rvt, b)),
    ),
    Transcription(
        number="A6",
        label="rewrite",
        formula=eq(v * Measure(b), Brate(v, sigma) * Measure(sigma)),
    ),
    Transcription(
        number="A7",
        label="bexpress",
        formula=chain(Brate(v, sigma), v * d * cos(pi - psi), d * v_sigma),
    ),
    Transcription(
        number="A8",
        label="bexpress2",
        formula=chain(
            Brate(vs, sigma), vs * d * cos(pi - psi), -d * dot(bvs, sigma), d * v_sigma / e
        ),
    ),
    Transcription(
        number="A9",
        label="inelaslorentz",
        formula=eq(streaming, d * rho0 * Int(v_sigma * (p_before / e**2 - p_rvt), sigma, hemi)),
    ),
    # B: the scaled equation and its Sonine expansion
    Transcription(
        number="B1",
        label="rearramu2",
        formula=eq(Derivative(v0_t, t), -rho0 * d * M2 * v0_t**2 / 2),
    ),
    Transcription(
        number="B2",
        label="ifmu2",
        formula=eq(I_(F_c), M2 / 2 * (2 * F_c + dot(bc, Partial(F_c, bc)))),
    ),
    Transcription(
        number="B3",
        label="mueq",
        formula=eq(Mp, M2 / 2 * p * Avg(c**p)),
    ),
    Transcription(
        number="B4",
        label="sonine1",
        formula=eq(F_c, phi(bc) * (1 + Sum(a(p) * S(p, c**2), (p, 1, oo)))),
    ),
    Transcription(
        number="B6",
        label="sonine1.5",
        formula=sp.Tuple(eq(S(0, x), 1), eq(S(1, x), -x + 1)),
    ),
    Transcription(
        number="B7",
        label="sonine2",
        formula=eq(S(2, x), half * x**2 - 2 * x + 1),
    ),
    Transcription(
        number="B8",
        label="sonine3",
        formula=eq(Int(phi(bc) * S(p, c**2) * S(pprime, c**2), bc), sp.KroneckerDelta(p, pprime)),
    ),
    Transcription(
        number="B9",
        label="sonine4",
        formula=chain(a(p), Int(S(p, c**2) * F_c, bc), Avg(S(p, c**2))),
    ),
    Transcription(
        number="B10",
        label="sonine4.5",
        formula=chain(a1, -Avg(c**2) + 1, 0),
    ),
    Transcription(
        number="B11",
        label="sonine5",
        formula=chain(a2, Avg(c**4) / 2 - 2 * Avg(c**2) + 1, Avg(c**4) / 2 - 1),
    ),
    Transcription(
        number="B12",
        label="sonine6",
        formula=eq(M4, 2 * M2 * Avg(c**4)),
    ),
    Transcription(
        number="B13",
        label="sonine7",
        formula=eq(4 * M2 * (a2 + 1) - M4, 0),
    ),
    Transcription(
        number="B14",
        label="sonine8",
        formula=eq(Mp, Int(Int(dot(bc, sigma) * F_c * (c**p - cp**p), sigma, hemi_c), bc)),
    ),
    Transcription(
        number="B15",
        label="sonine9",
        formula=eq(M2, sqrt(pi) * (1 - e**2) * (1 + Q(3, 8) * a2)),
    ),
    Transcription(
        number="B16",
        label="sonine10",
        formula=eq(M4, sqrt(pi) * (1 - e**2) * (3 + 2 * e**2) * (1 + Q(15, 8) * a2)),
    ),
    Transcription(
        number="B17",
        label="sonine11",
        formula=eq(a2, Q(1, 24) * (1 + 30 * e**2 + pm * sqrt_of_quartic)),
    ),
    Transcription(
        number="B18",
        label="sonine12",
        formula=eq(a2, Q(1, 24) * (1 + 30 * e**2 - sqrt_of_quartic)),
    ),
    # B: time dependence and stability of a_2
    Transcription(
        number="B19",
        label="ac1",
        formula=eq(f_vt, n / v0_t**2 * F(bc, t)),
    ),
    Transcription(
        number="B20",
        label="ac2",
        formula=eq(1 / (d * rho0 * v0_t) * Partial(Avg(c**p), t) - M2 / 2 * p * Avg(c**p) + Mp, 0),
    ),
    Transcription(
        number="B21",
        label="ac3",
        formula=eq(Derivative(a2t(t), t), d * rho0 * v0_t / 2 * (4 * M2 * (a2t(t) + 1) - M4)),
    ),
    Transcription(
        number="B22",
        label="ac4",
        formula=eq(a2t(t), a2bar + da2(t)),
    ),
    Transcription(
        number="B23",
        label="ac5",
        formula=eq(Derivative(da2(t), t), d * rho0 / 2 * sqrt(pi) * (1 - e**2) * H * v0_t * da2(t)),
    ),
    Transcription(
        number="B24",
        label="ac6",
        formula=eq(
            da2(t),
            da2(0) * exp(d * rho0 / 2 * sqrt(pi) * (1 - e**2) * H * Integral(v0_t, (t, 0, t))),
        ),
    ),
    Transcription(
        number="B25",
        label="ac7",
        formula=eq(H, 3 * a2bar - (Q(15, 4) * e**2 + Q(1, 8))),
    ),
    Transcription(
        number="B26",
        label="compare1",
        formula=sp.Le(sqrt(-Q(23, 50) + 16 * sqrt(14) / 75), e, evaluate=False),
    ),
    Transcription(
        number="B27",
        label="compare3#2",
        formula=eq(
            M2, sqrt(pi) * (1 - e**2) * (Q(65, 64) + Q(15, 32) * e**2 - Q(1, 64) * sqrt_of_quartic)
        ),
    ),
    # C: the diffusion coefficient in the first Sonine approximation
    Transcription(
        number="C1",
        label="ad1",
        formula=eq(
            Int(Y(bv) * Lam(X(bv)), bv),
            d * rho0 * Int(Int(v_sigma * X(bv) * (Y(bvp) - Y(bv)), sigma, hemi), bv),
        ),
    ),
    Transcription(
        number="C2",
        label="ad2",
        formula=eq(bvp, bv - (1 + e) * v_sigma * sigma),
    ),
    Transcription(
        number="C3",
        label="ad3",
        formula=eq(B_v, bv * fa2(bv, t)),
    ),
    Transcription(
        number="C4",
        label="ad4",
        formula=eq(f_vt, fa2(bv, t)),
    ),
    Transcription(
        number="C5",
        label="ad5",
        formula=eq(
            fa2(bv, t),
            m
            / (2 * pi * T_t)
            * exp(-m / (2 * T_t) * v**2)
            * (1 + a2 * (1 - m / T_t * v**2 + m**2 / (8 * T_t**2) * v**4)),
        ),
    ),
    Transcription(
        number="C6",
        label="ad6",
        formula=eq(nuD, d * rho0 * (1 + e) / 2 * sqrt(2 * pi * T_t / m) * (2 + Q(3, 4) * a2)),
    ),
    Transcription(
        number="C7",
        label="ad7",
        formula=eq(
            D_t, sqrt(2 * T_t / (pi * m)) / (d * rho0) / ((e + 1) ** 2 * (1 + Q(3, 8) * a2))
        ),
    ),
    Transcription(
        number="C8",
        label="ad8",
        formula=eq(msd(t), 4 * Integral(D_t, (t1, 0, t))),
    ),
    Transcription(
        number="C9",
        label="ad8#2",
        formula=eq(
            msd(t),
            8
            / (pi * d**2 * rho0**2)
            / ((1 + e) ** 2 * (1 - e**2) * (1 + Q(3, 8) * a2) ** 2)
            * log(1 + sqrt(pi / 2) * d * rho0 * (1 - e**2) * (1 + Q(3, 8) * a2) * t),
        ),
    ),
    # D: the diffusion coefficient at one speed
    Transcription(
        number="D1",
        label="ap1",
        formula=eq(Int(2 * pi * v * (dn_dt + dot(nabla, J_rvt)), v), 0),
    ),
    Transcription(
        number="D2",
        label="ap2",
        formula=eq(n_rvt, Int(pd(br, v * bvh, t) * unit_circle, bvh)),
    ),
    Transcription(
        number="D3",
        label="ap3",
        formula=eq(J_rvt, Int(v * bvh * pd(br, v * bvh, t) * unit_circle, bvh)),
    ),
    Transcription(
        number="D4",
        label="ap4",
        formula=eq(dn_dt + dot(nabla, J_rvt), 0),
    ),
    Transcription(
        number="D5",
        label="ap6",
        formula=eq(dn_dt, Sum(eps ** (j + 1) * Dt(j, n_rvt), (j, 0, oo))),
    ),
    Transcription(
        number="D6",
        label="ap7",
        formula=eq(Dt(j, n_rvt), -dot(nabla0, Jj(br, v, t))),
    ),
    Transcription(
        number="D7",
        label="ap8",
        formula=eq(Jj(br, v, t), Int(v * bvh * pj(br, v * bvh, t) * unit_circle, bvh)),
    ),
    Transcription(
        number="D8",
        label="ap11",
        formula=eq(p0_rvt, n_rvt / mn(v, t) * f_vt),
    ),
    Transcription(
        number="D9",
        label="ap11.5",
        formula=eq(mn(v, t), Int(f(v * bvh, t) * unit_circle, bvh)),
    ),
    Transcription(
        number="D10",
        label="ap11.6",
        formula=chain(
            J0(br, v, t), v * n_rvt / mn(v, t) * Int(bvh * f(v * bvh, t) * unit_circle, bvh), 0
        ),
    ),
    Transcription(
        number="D11",
        label="ap12",
        formula=eq(
            Dt(0, n_rvt) * Partial(p0_rvt, n_rvt)
            + dT_dt * Partial(p1_rvt, T_t)
            + dot(bv, nabla0) * n_rvt * Partial(p0_rvt, n_rvt),
            Lam(p1_rvt),
        ),
    ),
    Transcription(
        number="D12",
        label="ap12.5",
        formula=eq(dT_dt, -v0_t / l * h * T_t),
    ),
    Transcription(
        number="D13",
        label="ap13",
        formula=eq(
            cooling * Partial(p1_rvt, T_t) + Lam(p1_rvt), dot(bv, nabla0) * n_rvt * f_vt / mn(v, t)
        ),
    ),
    Transcription(
        number="D14",
        label="ap14",
        formula=eq(p1_rvt, dot(B_v, nabla0) * n_rvt),
    ),
    Transcription(
        number="D15",
        label="ap15",
        formula=eq(cooling * Partial(B_v, T_t) + Lam(B_v), bv * f_vt / mn(v, t)),
    ),
    Transcription(
        number="D16",
        label="ap16",
        formula=eq(J1(br, v, t), -D_v * nabla0 * n_rvt),
    ),
    Transcription(
        number="D17",
        label="ap17",
        formula=eq(D_v, -v / 2 * Int(dot(bvh, B_along) * unit_circle, bvh)),
    ),
    Transcription(
        number="D18",
        label="ap18",
        formula=eq(cooling * Partial(D_v, T_t) - nuD * D_v, -(v**2) / 2),
    ),
    Transcription(
        number="D19",
        label="ap19",
        formula=eq(
            nuD,
            -Int(v * dot(Lam(B_along), bvh) * unit_circle, bvh)
            / Int(v * dot(bvh, B_along) * unit_circle, bvh),
        ),
    ),
    Transcription(
        number="D20",
        label="ap20",
        formula=eq(Partial(D_v, T_t), -D_v / (2 * T_t)),
    ),
    Transcription(
        number="D21",
        label="ap21",
        formula=chain(D_v, v**2 / 2 / (h * v0_t / (2 * l) + nuD), v**2 * l / v0_t),
    ),
    Transcription(
        number="D22",
        label="ap21.5",
        formula=eq(De(V, t), kappa_d * V**2 * l / (alpha + beta * t)),
    ),
)
