"""Appendix A: from one collision to the kinetic equation, and its weak form.

The Jacobian, the impact parameter and the change of variables of the gain are computed here from
the collision rule; the operator equation is assembled from them.
"""

from __future__ import annotations

from functools import cache

import sympy as sp

from ..formal import Avg, Dot, Int, Lam, Measure, Partial, chain, dot, eq, linear
from ..premises import collision_matrix
from ..symbols import (
    Brate,
    F,
    Gamma_flow,
    Gamma_plus,
    Mp,
    X,
    Y,
    b,
    bc,
    br,
    bv,
    bvp,
    bvs,
    c,
    cp,
    d,
    dt,
    f,
    hemi,
    hemi_c,
    lam,
    nabla,
    p,
    pd,
    psi,
    rho0,
    sigma,
    t,
    theta,
    v,
    vs,
)
from .record import Derived, Status, Step, definition
from .registry import derives


@cache
def normal_factor() -> sp.Expr:
    """(v.sigma)/(v*.sigma): what a collision does to the normal component."""
    return collision_matrix()[0, 0]


@cache
def volume_ratio() -> sp.Expr:
    """dv*/dv at fixed sigma: one over the modulus of the Jacobian."""
    return 1 / sp.Abs(collision_matrix().det())


def bounce(before: sp.Symbol) -> sp.Expr:
    """The postcollision velocity of ``before``: its normal part times a factor, the rest kept."""
    normal = dot(before, sigma) * sigma
    return sp.collect(sp.expand((before - normal) + normal_factor() * normal), normal)


@derives("vchange")
def _vchange() -> Derived:
    return Derived(
        eq(bv, bounce(bvs)),
        (
            Step("normal part of v*", dot(bvs, sigma) * sigma),
            Step("the collision in (normal, tangential) components", collision_matrix()),
            Step("tangential part kept, normal part times -e", bounce(bvs)),
        ),
    )


@derives("ad2")
def _ad2() -> Derived:
    return Derived(eq(bvp, bounce(bv)), (Step("the collision rule with v before", bounce(bv)),))


@derives("dtchange")
def _dtchange() -> Derived:
    return definition("The balance that defines gain, loss and streaming.")


@cache
def _streaming_change() -> sp.Expr:
    """What free flight does to p dr dv in a short time, to first order in that time."""
    shifted = sp.exp(-dt * dot(bv, nabla))
    return dt * sp.diff(shifted, dt).subs(dt, 0) * pd(br, bv, t) * Measure(br) * Measure(bv)


@derives("gammaflow")
def _gammaflow() -> Derived:
    return Derived(
        eq(Gamma_flow, _streaming_change()),
        (
            Step("free flight: p(r, v, t + dt) = p(r - v dt, v, t)", sp.exp(-dt * dot(bv, nabla))),
            Step("first order in dt", _streaming_change()),
        ),
    )


@derives("gamma-")
def _gamma_minus() -> Derived:
    return Derived(
        None,
        (
            Step(
                "scatterers in the strip of width db and length |v| dt, all b from -d to d",
                eq(sp.Integral(rho0 * v * dt, (b, -d, d)), 2 * d * rho0 * v * dt),
            ),
        ),
        "Counts the scatterers in the strip that the tracer sweeps: uncorrelated scatterers. Its "
        "rate 2 d rho_0 |v| makes the mean free path 1/(2 d rho_0).",
        Status.DEFINITION,
    )


@derives("gamma+")
def _gamma_plus() -> Derived:
    before = pd(br, bvs, t) * Measure(br) * rho0 * vs * dt
    return Derived(
        chain(
            Gamma_plus,
            Int(before * Measure(bvs), b),
            Int(before * volume_ratio() * Measure(bv), b),
        ),
        (
            Step("Jacobian matrix of the collision at fixed sigma", collision_matrix()),
            Step("dv*/dv", volume_ratio()),
        ),
        "Holds at fixed sigma, where the Jacobian is 1/e. At fixed impact parameter it is 1/s^2 "
        "with s the speed ratio: the second integral is to be read over sigma, as the paper then "
        "does.",
    )


@derives("ftdiff")
def _ftdiff() -> Derived:
    volume = Measure(br) * Measure(bv) * dt
    gain = Int(pd(br, bvs, t) * Measure(br) * volume_ratio() * Measure(bv) * rho0 * vs * dt, b)
    loss = Int(pd(br, bv, t) * Measure(br) * Measure(bv) * rho0 * v * dt, b)
    right = sp.expand(linear((gain - loss) / volume))
    flow = sp.cancel(_streaming_change() / volume)
    return Derived(
        eq(sp.Derivative(pd(br, bv, t), t) - flow, right),
        (Step("gain less loss, per dr dv dt", right), Step("streaming, per dr dv dt", flow)),
    )


@derives("rewrite")
def _rewrite() -> Derived:
    return definition("Defines B(|v|, sigma).")


def _rate(speed: sp.Symbol) -> sp.Expr:
    """|v| db/dsigma with b = d sin(angle) and sigma at that angle, angle = pi - psi."""
    angle = sp.Symbol("angle", real=True)
    return speed * sp.diff(d * sp.sin(angle), angle).subs(angle, sp.pi - psi)


@cache
def loss_rate() -> sp.Expr:
    """B(|v|, sigma) after sigma -> -sigma: the angle of v and sigma is then pi - psi."""
    return _rate(v) / (v * sp.cos(sp.pi - psi)) * dot(bv, sigma)


@cache
def gain_rate() -> tuple[sp.Expr, sp.Expr]:
    """B(|v*|, sigma) in terms of v*.sigma and of v.sigma; psi is the angle of v* and sigma."""
    before = _rate(vs) / (vs * sp.cos(psi)) * dot(bvs, sigma)
    return before, before.subs(dot(bvs, sigma), dot(bv, sigma) / normal_factor())


@derives("bexpress")
def _bexpress() -> Derived:
    return Derived(
        chain(Brate(v, sigma), _rate(v), loss_rate()),
        (Step("b = d sin(pi - psi), differentiated", _rate(v)),),
        "The second equality takes sigma -> -sigma in the loss, where the tracer approaches.",
    )


@derives("bexpress2")
def _bexpress2() -> Derived:
    return Derived(
        chain(Brate(vs, sigma), _rate(vs), *gain_rate()),
        (
            Step("b = d sin(pi - psi), differentiated", _rate(vs)),
            Step("v*.sigma = |v*| cos(psi)", gain_rate()[0]),
            Step("v.sigma over v*.sigma", normal_factor()),
        ),
    )


@cache
def collision_term() -> sp.Expr:
    """The collision operator on p(r, v, t), over sigma."""
    gain = gain_rate()[1] * volume_ratio() * pd(br, bvs, t)
    return rho0 * Int(gain - loss_rate() * pd(br, bv, t), sigma, hemi)


@derives("inelaslorentz")
def _inelaslorentz() -> Derived:
    left = sp.Derivative(pd(br, bv, t), t) + dot(bv, nabla) * pd(br, bv, t)
    return Derived(
        eq(left, collision_term()),
        (
            Step("gain: rate times Jacobian", gain_rate()[1] * volume_ratio()),
            Step("loss: rate", loss_rate()),
            Step("mass: the weak form (ad1) with Y = 1 vanishes", weak_form(sp.Integer(1), 1)),
        ),
    )


@derives("inelaslorentz2")
def _inelaslorentz2() -> Derived:
    uniform = collision_term().subs({pd(br, bvs, t): f(bvs, t), pd(br, bv, t): f(bv, t)})
    return Derived(
        eq(sp.Derivative(f(bv, t), t), uniform),
        (Step("integral over r: the streaming term is a surface term", uniform),),
    )


@derives("diffuse1")
def _diffuse1() -> Derived:
    left = sp.Derivative(pd(br, bv, t), t) + dot(bv, nabla) * pd(br, bv, t)
    return Derived(
        eq(left, Lam(pd(br, bv, t))),
        (Step("the inelastic Lorentz equation, its right-hand side named", collision_term()),),
    )


@derives("diffuse1.5")
def _diffuse1_5() -> Derived:
    return Derived(
        eq(Lam(pd(br, bv, t)), collision_term()),
        (Step("right-hand side of the inelastic Lorentz equation", collision_term()),),
    )


def weak_form(after: sp.Expr, before: sp.Expr) -> sp.Expr:
    """The integral of Y Lambda X over v; ``after`` and ``before`` stand for Y(v') and Y(v).

    In the gain, v* becomes the variable v and v its postcollision velocity v'; then dv = dv*/ratio
    and v.sigma = factor (v*.sigma), with sigma -> -sigma since the factor is negative.
    """
    # the coefficient of (v.sigma) p* in the operator, in the new variables
    weight = gain_rate()[1] / dot(bv, sigma) * volume_ratio()
    changed = weight / d * (-normal_factor()) / volume_ratio()
    inner = dot(bv, sigma) * X(bv) * (sp.simplify(changed) * after - before)
    return d * rho0 * Int(Int(inner, sigma, hemi), bv)


@derives("ad1")
def _ad1() -> Derived:
    return Derived(
        eq(Int(Y(bv) * Lam(X(bv)), bv), weak_form(Y(bvp), Y(bv))),
        (
            Step("volume element dv*/dv", volume_ratio()),
            Step("v.sigma over v*.sigma", normal_factor()),
            Step("weight of the gain before the change", gain_rate()[1] * volume_ratio()),
            Step("both changes together leave the weight (v.sigma)", weak_form(Y(bvp), Y(bv))),
        ),
        "With Y = 1 it vanishes: the operator keeps mass.",
    )


@derives("beyond:mass")
def _mass() -> Derived:
    inner = weak_form(sp.Integer(1), sp.Integer(1))
    kept = inner.replace(Int, lambda *args: sp.Integer(0) if args[0] == 0 else Int(*args))
    return Derived(eq(Int(Lam(X(bv)), bv), kept), (Step("weak form (ad1) with Y = 1", inner),))


@derives("beyond:angular-average")
def _angular_average() -> Derived:
    # v.sigma dsigma = v cos(theta) dtheta = v dy with y = sin(theta), -1 < y < 1
    if sp.diff(sp.sin(theta), theta) != sp.cos(theta):
        raise ArithmeticError("dy is not cos(theta) dtheta")
    total = sp.integrate(sp.cos(theta), (theta, -sp.pi / 2, sp.pi / 2))
    # |v'|^p - |v|^p averages to -lambda(p) |v|^p; the rate brings one more power of |v|
    return Derived(
        eq(Partial(Avg(v**p), t), -d * rho0 * total * lam(p) * Avg(v**p * v)),
        (
            Step("weak form with Y = |v|^p", weak_form(vs**p, v**p)),
            Step("weight of all angles: the integral of cos(theta)", total),
            Step("hence y = sin(theta) is uniform, and E[s^p] = 1 - lambda(p)", None),
        ),
        "The deflection drops out for an isotropic VDF: only the speed ratio s is left.",
    )


@derives("sonine8")
def _sonine8() -> Derived:
    weak = -weak_form(cp**p, c**p) / (d * rho0)
    scaled = weak.subs({X(bv): F(bc), hemi: hemi_c}).subs(bv, bc).replace(Dot, dot)
    return Derived(
        eq(Mp, scaled),
        (Step("weak form with X = F and Y = c^p, divided by d rho0", scaled),),
        "Holds for every p for which <c^(p+1)> exists, with no Sonine expansion.",
    )
