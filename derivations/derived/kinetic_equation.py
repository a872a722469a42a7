"""Appendix A: from one collision to the kinetic equation, and its weak form.

The Jacobian, the impact parameter and the change of variables of the gain are computed here from
the collision rule; the operator equation is assembled from them.
"""

from __future__ import annotations

from functools import cache

import sympy as sp

from .. import symbols as s
from ..formal import Avg, Dot, Int, Lam, Measure, Partial, chain, dot, eq, linear
from ..premises import collision_matrix
from .record import Derived, Status, defines, derives, result, row

_P = s.pd(s.br, s.bv, s.t)
_P_PRE = s.pd(s.br, s.bvs, s.t)
_GAIN = _P_PRE * Measure(s.br) * s.rho0 * s.vs * s.dt  # per db and dv*


@cache
def normal_factor() -> sp.Expr:
    """(v.sigma)/(v*.sigma): what a collision does to the normal component."""
    return collision_matrix()[0, 0]


@cache
def volume_ratio() -> sp.Expr:
    """dv*/dv at fixed sigma: one over the modulus of the Jacobian."""
    return 1 / sp.Abs(collision_matrix().det())


def bounce(velocity: sp.Symbol) -> sp.Expr:
    """The velocity after a collision: the normal component is multiplied by its factor."""
    normal = dot(velocity, s.sigma) * s.sigma
    tangential = velocity - normal
    return sp.collect(sp.expand(tangential + normal_factor() * normal), normal)


# (1): the collision rule
row("vchange", lambda: eq(s.bv, bounce(s.bvs)), "the collision in (normal, tangential) components")
# (C2): postcollision velocity
row("ad2", lambda: eq(s.bvp, bounce(s.bv)), "the collision rule with v before")
defines(
    {
        "dtchange": "The balance that defines gain, loss and streaming.",
        "rewrite": "Defines B(|v|, sigma).",
    }
)


@cache
def _streaming_change() -> sp.Expr:
    """What free flight does to p dr dv in a short time, to first order in that time."""
    shift = sp.exp(-s.dt * dot(s.bv, s.nabla))
    rate = sp.diff(shift, s.dt).subs(s.dt, 0)
    return s.dt * rate * _P * Measure(s.br) * Measure(s.bv)


# (A2): streaming
row("gammaflow", lambda: eq(s.Gamma_flow, _streaming_change()))
# (A3): loss
row(
    "gamma-",
    lambda: (
        None,
        (
            "scatterers in the strip of width db and length |v| dt, all b from -d to d",
            eq(sp.Integral(s.rho0 * s.v * s.dt, (s.b, -s.d, s.d)), 2 * s.d * s.rho0 * s.v * s.dt),
        ),
    ),
    note="Counts the scatterers in the strip that the tracer sweeps: uncorrelated scatterers. Its "
    "rate 2 d rho_0 |v| makes the mean free path 1/(2 d rho_0).",
    status=Status.DEFINITION,
)


@derives("gamma+")
def _gamma_plus() -> Derived:
    """(A4): gain."""
    return result(
        chain(
            s.Gamma_plus,
            Int(_GAIN * Measure(s.bvs), s.b),
            Int(_GAIN * volume_ratio() * Measure(s.bv), s.b),
        ),
        ("Jacobian matrix of the collision at fixed sigma", collision_matrix()),
        ("dv*/dv", volume_ratio()),
        note="Holds at fixed sigma, where the Jacobian is 1/e. At fixed impact parameter it is "
        "1/s^2 with s the speed ratio: the second integral is to be read over sigma, as the paper "
        "then does.",
    )


@derives("ftdiff")
def _ftdiff() -> Derived:
    """(A5): kinetic equation over the impact parameter."""
    volume = Measure(s.br) * Measure(s.bv) * s.dt
    gain = Int(_GAIN * volume_ratio() * Measure(s.bv), s.b)
    loss = Int(_P * Measure(s.br) * Measure(s.bv) * s.rho0 * s.v * s.dt, s.b)
    right = sp.expand(linear((gain - loss) / volume))
    flow = sp.cancel(_streaming_change() / volume)
    return result(eq(sp.Derivative(_P, s.t) - flow, right), ("streaming, per dr dv dt", flow))


def _rate(speed: sp.Symbol) -> sp.Expr:
    """|v| db/dsigma with b = d sin(angle) and sigma at that angle, angle = pi - psi."""
    angle = sp.Symbol("angle", real=True)
    return speed * sp.diff(s.d * sp.sin(angle), angle).subs(angle, sp.pi - s.psi)


@cache
def loss_rate() -> sp.Expr:
    """B(|v|, sigma) after sigma -> -sigma: the angle of v and sigma is then pi - psi."""
    return _rate(s.v) / (s.v * sp.cos(sp.pi - s.psi)) * dot(s.bv, s.sigma)


@cache
def gain_rate() -> tuple[sp.Expr, sp.Expr]:
    """B(|v*|, sigma) in terms of v*.sigma and of v.sigma; psi is the angle of v* and sigma."""
    normal_before = dot(s.bvs, s.sigma)
    normal_after = dot(s.bv, s.sigma)
    rate = _rate(s.vs) / (s.vs * sp.cos(s.psi)) * normal_before
    return rate, rate.subs(normal_before, normal_after / normal_factor())


# (A7): Jacobian from impact parameter to unit vector, loss
row(
    "bexpress",
    lambda: chain(s.Brate(s.v, s.sigma), _rate(s.v), loss_rate()),
    "b = d sin(pi - psi), differentiated",
    note="The second equality takes sigma -> -sigma in the loss, where the tracer approaches.",
)
# (A8): Jacobian from impact parameter to unit vector, gain
row("bexpress2", lambda: chain(s.Brate(s.vs, s.sigma), _rate(s.vs), *gain_rate()))


@cache
def collision_term() -> sp.Expr:
    """The collision operator on p(r, v, t), over sigma."""
    gain = gain_rate()[1] * volume_ratio() * _P_PRE
    return s.rho0 * Int(gain - loss_rate() * _P, s.sigma, s.hemi)


# (A9): the inelastic Lorentz equation
row("inelaslorentz", lambda: eq(sp.Derivative(_P, s.t) + dot(s.bv, s.nabla) * _P, collision_term()))
# (9): kinetic equation of a uniform tracer
row(
    "inelaslorentz2",
    lambda: eq(
        sp.Derivative(s.f(s.bv, s.t), s.t),
        collision_term().subs({_P_PRE: s.f(s.bvs, s.t), _P: s.f(s.bv, s.t)}),
    ),
    "integral over r: the streaming term is a surface term",
)
# (24): kinetic equation
row("diffuse1", lambda: eq(sp.Derivative(_P, s.t) + dot(s.bv, s.nabla) * _P, Lam(_P)))
# (25): collision operator
row("diffuse1.5", lambda: eq(Lam(_P), collision_term()))


def weak_form(y_after: sp.Expr | int, y_before: sp.Expr | int) -> sp.Expr:
    """The integral of Y Lambda X over v; ``y_after`` and ``y_before`` stand for Y(v') and Y(v).

    In the gain, v* becomes the variable v and v its postcollision velocity v'; then dv = dv*/ratio
    and v.sigma = factor (v*.sigma), with sigma -> -sigma since the factor is negative.
    """
    # the coefficient of (v.sigma) p* in the operator, in the new variables
    weight = gain_rate()[1] / dot(s.bv, s.sigma) * volume_ratio()
    gain_weight = sp.simplify(weight / s.d * (-normal_factor()) / volume_ratio())
    change = gain_weight * y_after - y_before
    integrand = dot(s.bv, s.sigma) * s.X(s.bv) * change
    return s.d * s.rho0 * Int(Int(integrand, s.sigma, s.hemi), s.bv)


# (C1): collision operator between two functions
row(
    "ad1",
    lambda: eq(Int(s.Y(s.bv) * Lam(s.X(s.bv)), s.bv), weak_form(s.Y(s.bvp), s.Y(s.bv))),
    note="With Y = 1 it vanishes: the operator keeps mass.",
)


@cache
def mass_change() -> sp.Expr:
    """The integral of the collision operator over v: its weak form with Y = 1, which vanishes."""

    def integral(integrand: sp.Expr, *variables: sp.Expr) -> sp.Expr:
        if integrand == 0:
            return integrand
        return Int(integrand, *variables)

    return weak_form(1, 1).replace(Int, integral)


# the collision operator keeps mass
row("beyond:mass", lambda: eq(Int(Lam(s.X(s.bv)), s.bv), mass_change()))


@derives("beyond:angular-average")
def _angular_average() -> Derived:
    """An isotropic VDF: one average over the impact parameter."""
    # v.sigma dsigma = v cos(theta) dtheta = v dy with y = sin(theta), -1 < y < 1
    total = sp.integrate(sp.cos(s.theta), (s.theta, -sp.pi / 2, sp.pi / 2))
    # |v'|^p - |v|^p averages to -lambda(p) |v|^p; the rate brings one more power of |v|
    return result(
        eq(Partial(Avg(s.v**s.p), s.t), -s.d * s.rho0 * total * s.lam(s.p) * Avg(s.v**s.p * s.v)),
        ("weak form with Y = |v|^p", weak_form(s.vs**s.p, s.v**s.p)),
        ("weight of all angles: the integral of cos(theta)", total),
        note="The deflection drops out for an isotropic VDF: only the speed ratio s is left.",
    )


def _collision_moment() -> sp.Expr:
    """M_p from the weak form in units of the thermal velocity."""
    scaled = -weak_form(s.cp**s.p, s.c**s.p) / (s.d * s.rho0)
    scaled = scaled.subs({s.X(s.bv): s.F(s.bc), s.hemi: s.hemi_c})
    return scaled.subs(s.bv, s.bc).replace(Dot, dot)


# (B14): moments of the collision integral
row(
    "sonine8",
    lambda: eq(s.Mp, _collision_moment()),
    "weak form with X = F and Y = c^p, divided by d rho0",
    note="Holds for every p for which <c^(p+1)> exists, with no Sonine expansion.",
)
