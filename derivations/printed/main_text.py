"""Sections 2 and 3 as printed: cooling, random walk, transport, position.

One row a formula, in the paper's order, to be read beside the paper. A piece that appears often has
a name that shows its arguments: ``p_rvt`` is p(r, v, t).
"""

from __future__ import annotations

import sympy as sp
from sympy import Derivative, Integral, Sum, exp, log, oo, pi, sqrt
from sympy import Rational as Q

from ..formal import Dt, Int, Lam, Partial, Second, chain, dot, eq
from ..symbols import (
    I_,
    J1,
    M2,
    Bv,
    De,
    F,
    G,
    Gt,
    J,
    Jj,
    Mp,
    N,
    R,
    T,
    V,
    Vbar,
    Vs,
    alpha,
    bc,
    bcs,
    beta,
    bl,
    br,
    bv,
    bvs,
    c,
    d,
    e,
    eps,
    eta,
    f,
    g,
    gamma,
    ge,
    gt,
    h,
    hemi,
    hemi_c,
    j,
    k,
    kappa_d,
    l,
    m,
    msd,
    msd1,
    n,
    nabla,
    nabla0,
    nabla1,
    nd,
    nuD,
    p,
    p0,
    p1,
    p2,
    pd,
    pj,
    r,
    rho0,
    sigma,
    t,
    t1,
    tau,
    tau1,
    tc,
    v,
    v0,
    xi,
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
dT_dt = Derivative(T_t, t)
D_t = De(t)
n_rt = nd(br, t)
dn_dt = Derivative(n_rt, t)
B_v = Bv(bv, T_t)
xi_t = xi(t)
msd_t = msd(t)
G_R = G(R)
t_N = tc(N)
integral_of_D = Integral(De(V, t1), (t1, 0, t))
curvature = Second(pd(V, R), V, Vs)
sqrt_of_quartic = sqrt(-383 + 828 * e**2 + 900 * e**4)

EQUATIONS: tuple[Transcription, ...] = (
    # Sections 2 and 3.2: the collision rule, cooling, the scaling form
    Transcription(
        number="1",
        label="vchange",
        formula=eq(bv, bvs - (1 + e) * dot(bvs, sigma) * sigma),
    ),
    Transcription(
        number="2",
        label="gtilde",
        formula=eq(g(r, t), 1 / sqrt(msd1(t)) * G_R),
    ),
    Transcription(
        number="3",
        label="v0defi",
        formula=eq(v0_t, sqrt(1 / n * Int(v**2 * f_vt, bv))),
    ),
    Transcription(
        number="4",
        label="thermo",
        formula=eq(T_t, half * m * v0_t**2),
    ),
    Transcription(
        number="5",
        label="tdiff",
        formula=eq(dT_dt, -2 * d * v0_t * rho0 * h * T_t),
    ),
    Transcription(
        number="6",
        label="vdiff",
        formula=eq(Derivative(v0_t, t), -d * rho0 * h * v0_t**2),
    ),
    Transcription(
        number="7",
        label="veq",
        formula=eq(v0_t, 1 / (1 / v0(0) + d * rho0 * h * t)),
    ),
    Transcription(
        number="8",
        label="hsimu",
        formula=eq(h, Q("1.45") * (1 - e)),
    ),
    Transcription(
        number="9",
        label="inelaslorentz2",
        formula=eq(
            Derivative(f_vt, t), d * rho0 * Int(v_sigma * (f(bvs, t) / e**2 - f_vt), sigma, hemi)
        ),
    ),
    Transcription(
        number="10",
        label="tdepend",
        formula=eq(f_vt, n / v0_t**2 * F_c),
    ),
    Transcription(
        number="11",
        label="if",
        formula=eq(I_(F_c), Int(dot(bc, sigma) * (F(bcs) / e**2 - F_c), sigma, hemi_c)),
    ),
    Transcription(
        number="12",
        label="mup",
        formula=eq(Mp, -Int(c**p * I_(F_c), bc)),
    ),
    Transcription(
        number="13",
        label="tdiff2",
        formula=eq(dT_dt, -d * v0_t * rho0 * M2 * T_t),
    ),
    Transcription(
        number="14",
        label="compare2",
        formula=eq(h, M2 / 2),
    ),
    Transcription(
        number="15",
        label="compare3",
        formula=eq(
            M2, sqrt(pi) * (1 - e**2) * (Q(65, 64) + Q(15, 32) * e**2 - Q(1, 64) * sqrt_of_quartic)
        ),
    ),
    # Section 3.2: the random walk and its mean square displacement
    Transcription(
        number="16",
        label="ab",
        formula=sp.Tuple(eq(alpha, 1 / v0(0)), eq(beta, d * rho0 * h)),
    ),
    Transcription(
        number="17",
        label="taun",
        formula=chain(tau(N), l / v0(tc(N - 1)), l * (alpha + beta * tc(N - 1))),
    ),
    Transcription(
        number="18",
        label="taun#2",
        formula=eq(tau(N), l * alpha * (1 + l * beta) ** (N - 1)),
    ),
    Transcription(
        number="19",
        label="tn",
        formula=chain(t_N, Sum(tau(k), (k, 1, N)), alpha / beta * ((1 + l * beta) ** N - 1)),
    ),
    Transcription(
        number="20",
        label="N",
        formula=eq(N, log(beta / alpha * t_N + 1) / log(1 + l * beta)),
    ),
    Transcription(
        number="22",
        label="msd",
        formula=chain(msd_t, l**2 * N, l**2 * log(beta / alpha * t + 1) / log(1 + l * beta)),
    ),
    Transcription(
        number="23",
        label="scaledposi",
        formula=eq(G_R, sqrt(msd_t) * ge(r, t)),
    ),
    # Section 3.3: the Chapman-Enskog expansion
    Transcription(
        number="24",
        label="diffuse1",
        formula=eq(Derivative(p_rvt, t) + dot(bv, nabla) * p_rvt, Lam(p_rvt)),
    ),
    Transcription(
        number="25",
        label="diffuse1.5",
        formula=eq(Lam(p_rvt), d * rho0 * Int(v_sigma * (p_before / e**2 - p_rvt), sigma, hemi)),
    ),
    Transcription(
        number="26",
        label="diffuse2",
        formula=eq(dn_dt + dot(nabla, J(br, t)), 0),
    ),
    Transcription(
        number="27",
        label="diffuse3",
        formula=eq(n_rt, Int(p_rvt, bv)),
    ),
    Transcription(
        number="28",
        label="diffuse4",
        formula=eq(J(br, t), Int(bv * p_rvt, bv)),
    ),
    Transcription(
        number="29",
        label="diffuse5",
        formula=eq(p_rvt, p0_rvt + eps * p1_rvt + eps**2 * p2(br, bv, t)),
    ),
    Transcription(
        number="30",
        label="diffuse6",
        formula=eq(dn_dt, Sum(eps ** (j + 1) * Dt(j, n_rt), (j, 0, oo))),
    ),
    Transcription(
        number="31",
        label="diffuse7",
        formula=eq(Dt(j, n_rt), -dot(nabla0, Jj(br, t))),
    ),
    Transcription(
        number="32",
        label="diffuse8",
        formula=eq(Jj(br, t), Int(bv * pj(br, bv, t), bv)),
    ),
    Transcription(
        number="33",
        label="diffuse9",
        formula=eq(nabla, eps * nabla0 + eps**2 * nabla1),
    ),
    Transcription(
        number="34",
        label="diffuse10",
        formula=eq(dT_dt * Partial(p0_rvt, T_t), Lam(p0_rvt)),
    ),
    Transcription(
        number="35",
        label="diffuse11",
        formula=eq(p0_rvt, n_rt / n * f_vt),
    ),
    Transcription(
        number="36",
        label="diffuse12",
        formula=eq(
            Dt(0, n_rt) * Partial(p0_rvt, n_rt)
            + dT_dt * Partial(p1_rvt, T_t)
            + dot(bv, nabla0) * n_rt * Partial(p0_rvt, n_rt),
            Lam(p1_rvt),
        ),
    ),
    Transcription(
        number="37",
        label="diffuse13",
        formula=eq(
            xi_t * T_t * Partial(p1_rvt, T_t) + Lam(p1_rvt), dot(bv, nabla0) * n_rt / n * f_vt
        ),
    ),
    Transcription(
        number="38",
        label="diffuse14",
        formula=eq(p1_rvt, dot(B_v, nabla0) * n_rt),
    ),
    Transcription(
        number="39",
        label="diffuse15",
        formula=eq(xi_t * T_t * Partial(B_v, T_t) + Lam(B_v), bv / n * f_vt),
    ),
    Transcription(
        number="40",
        label="diffuse16",
        formula=eq(J1(br, t), -D_t * nabla0 * n_rt),
    ),
    Transcription(
        number="41",
        label="diffuse17",
        formula=eq(D_t, -half * Int(dot(bv, B_v), bv)),
    ),
    Transcription(
        number="42",
        label="diffuse18",
        formula=eq(xi_t * T_t * Partial(D_t, T_t) - nuD * D_t, -T_t / m),
    ),
    Transcription(
        number="43",
        label="diffuse19",
        formula=eq(nuD, -Int(dot(Lam(B_v), bv), bv) / Int(dot(B_v, bv), bv)),
    ),
    Transcription(
        number="44",
        label="diffuse20",
        formula=eq(Partial(D_t, T_t), D_t / (2 * T_t)),
    ),
    Transcription(
        number="45",
        label="diffuse21",
        formula=eq(D_t, T_t / m / (nuD - xi_t / 2)),
    ),
    Transcription(
        number="46",
        label="diffuse22",
        formula=eq(Dt(1, n_rt), D_t * nabla0**2 * n_rt),
    ),
    # Section 3.3: the scaled position distribution
    Transcription(
        number="47",
        label="normg",
        formula=eq(gt(r, t), 1 / (4 * integral_of_D) * r * exp(-(r**2) / (8 * integral_of_D))),
    ),
    Transcription(
        number="48",
        label="ddif",
        formula=eq(De(V, t1), kappa_d * V**2 * l / (alpha + beta * t1)),
    ),
    Transcription(
        number="49",
        label="L",
        formula=eq(V, sp.Abs(bl / tau1 / v0(t1))),
    ),
    Transcription(
        number="50",
        label="eta",
        formula=eq(eta, 4 * integral_of_D / (V**2 * msd_t)),
    ),
    Transcription(
        number="51",
        label="etadif",
        formula=eq(eta, 4 * kappa_d * log(1 + l * beta) / (l * beta)),
    ),
    Transcription(
        number="52",
        label="posivel",
        formula=eq(Gt(R, V), 1 / (eta * V**2) * R * exp(-(R**2) / (2 * eta * V**2))),
    ),
    Transcription(
        number="53",
        label="gdefi",
        formula=chain(
            G_R,
            Integral(
                exp(-(V**2)) / pi / (eta * V**2) * R * exp(-(R**2) / (2 * eta * V**2)) * 2 * pi * V,
                (V, 0, oo),
            ),
            2 / eta * R * Integral(exp(-pd(V, R) * R**2), (V, 0, oo)),
        ),
    ),
    Transcription(
        number="54",
        label="pdefi",
        formula=eq(pd(V, R), log(V) / R**2 + V**2 / R**2 + 1 / (2 * eta * V**2)),
    ),
    Transcription(
        number="55",
        label="csolu",
        formula=eq(Vs, sqrt(-Q(1, 4) + sqrt(eta + 8 * R**2) / (4 * sqrt(eta)))),
    ),
    Transcription(
        number="56",
        label="tailg",
        formula=chain(
            G_R,
            2
            / eta
            * R
            * Integral(exp(-pd(Vs, R) * R**2 - (V - Vs) ** 2 / 2 * curvature * R**2), (V, 0, oo)),
            2 / eta * sqrt(pi / (2 * curvature)) * exp(-pd(Vs, R) * R**2),
        ),
    ),
    Transcription(
        number="57",
        label="semig",
        formula=eq(G_R, sqrt(pi * R / (2 * sqrt(2) * eta ** Q(3, 2))) * exp(-sqrt(2 / eta) * R)),
    ),
    Transcription(
        number="58",
        label="gammatailg",
        formula=eq(G_R, 2 * gamma / eta * sqrt(pi / (2 * curvature)) * exp(-pd(Vs, R) * R**2)),
    ),
    Transcription(
        number="59",
        label="peakg",
        formula=eq(G_R, 1 / (eta * Vbar**2) * R * exp(-(R**2) / (2 * eta * Vbar**2))),
    ),
)
