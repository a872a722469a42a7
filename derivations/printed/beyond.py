"""Results beyond the paper as they are stated: of any collision law, of media, of what drives.

They play the part that the printed formulas play for the paper's labels: each is held against
what :mod:`derivations.derived` derives, and a changed coefficient here must be noticed. A row is
its title and the equations that it states.
"""

from __future__ import annotations

from typing import Any

import sympy as sp

from .. import symbols as s
from ..formal import Avg, Int, Lam, Partial, dot, eq

Q = sp.Rational
_half = Q(1, 2)
_b = sp.sqrt(1 - s.e**2)

PAPERS_LAW: dict[str, tuple[Any, ...]] = {
    "beyond:angular-average": ("an isotropic VDF: one average over the impact parameter",
        eq(Partial(Avg(s.v**s.p), s.t), -2 * s.d * s.rho0 * s.lam(s.p) * Avg(s.v**(s.p + 1)))),
    "beyond:mass": ("the collision operator keeps mass", eq(Int(Lam(s.X(s.bv)), s.bv), 0)),
    "beyond:loss-p": ("loss of |v|^p per collision, any real p",
        eq(s.lam(s.p), 1 - sp.hyper((1, -s.p / 2), (Q(3, 2),), 1 - s.e**2))),
    "beyond:loss-even": ("loss of |v|^p per collision, symbolic even p = 2 q",
        eq(s.lam(2 * s.q), 1 - sp.Sum(sp.binomial(s.q, s.k) * s.e**(2 * (s.q - s.k))
            * (1 - s.e**2)**s.k / (2 * s.k + 1), (s.k, 0, s.q)))),
    "beyond:loss-1": ("loss of |v|", eq(s.lam(1), (1 - s.e**2 * sp.atanh(_b) / _b) / 2)),
    "beyond:loss-2": ("loss of energy", eq(s.lam(2), Q(2, 3) * (1 - s.e**2))),
    "beyond:log-loss": ("mean log loss kappa", eq(s.klog, 1 - s.e * sp.acos(s.e) / _b)),
    "beyond:cosine": ("mean cosine of the deflection",
        eq(s.cos_chi, -s.e * sp.atanh(_b) / _b + (1 - s.e**2 * sp.atanh(_b) / _b)
            / (2 * (1 - s.e)))),
    "beyond:collision-moment": ("M_p of the Sonine form for any real p",
        eq(s.Mp, 2 * s.lam(s.p) * sp.gamma((s.p + 3) / 2) * (1 + s.a2 * (s.p**2 - 1) / 8))),
    "beyond:sonine-n": ("Sonine polynomial of order N",
        eq(s.S(s.N, s.x), sp.Sum((-1)**s.k * sp.binomial(s.N, s.k) * s.x**s.k / sp.factorial(s.k),
            (s.k, 0, s.N)))),
    "beyond:moments": ("moments of the scaling solution",
        eq(s.MY(1), 1 / s.klog),
        eq(s.MY(s.p + 1), s.p * s.MY(s.p) / s.lam(s.p))),
    "beyond:cooling-rate": ("exact cooling rate", eq(s.h, 2 * sp.sqrt(s.klog * s.lam(1)))),
    "beyond:a2": ("exact a_2", eq(s.a2, 3 * s.klog * s.lam(1) / (s.lam(2) * s.lam(3)) - 1)),
    "beyond:cooling-small-e": ("h(e) as e -> 0, to order e^2",
        eq(s.h, sp.sqrt(2) * (1 - sp.pi * s.e / 4 + s.e**2
            * (_half - sp.pi**2 / 32 - sp.log(2) / 2 + sp.log(s.e) / 2)))),
    "beyond:cooling-near-1": ("h(e)/(1 - e) as e -> 1, to second order in delta = 1 - e",
        eq(s.h / s.gap, Q(4, 3) + 2 * s.gap / 15 + 2 * s.gap**2 / 175)),
    "beyond:a2-limits": ("exact a_2 at e = 0 and as e -> 1",
        eq(s.a2, 2),
        eq(s.a2, -_half)),
    "beyond:tail": ("tail of F: c^power exp(-rate c)",
        eq(s.power, 1 / (1 - s.e**2) - 2),
        eq(s.rate, 2 / s.h)),
    "beyond:ring": ("relative variance of the speed as e -> 1", eq(s.width2, (1 - s.e**2) / 5)),
    "beyond:e-zero": ("the scaling solution at e = 0",
        eq(s.F(s.bc), sp.exp(-sp.sqrt(2) * s.c) / (sp.sqrt(2) * sp.pi * s.c)),
        eq(s.M2 / 2, sp.sqrt(2))),
    "beyond:slope": ("slope of <r^2> in ln t, over l^2",
        eq(s.slope, 2 / (s.klog * (1 - s.cos_chi)))),
    "beyond:bessel": ("the paper's G(R) in closed form, its integral and second moment",
        eq(s.G(s.R), 2 * s.R / s.eta * sp.besselk(0, s.R * sp.sqrt(2 / s.eta))),
        eq(s.norm, 1),
        eq(Avg(s.R**2), 2 * s.eta)),
    "beyond:position": ("flatness <R^4>/<R^2>^2 of the position as t -> oo", eq(s.flatness, 2)),
}  # fmt: skip

_first, _second, _third, _fourth = (sp.legendre(order, sp.cos(s.chi)) for order in (1, 2, 3, 4))
_later = s.s * s.zeta  # v t/l after a collision that multiplies the speed by s
_chi1, _rho2, _S2, _W1, _rho4 = (f(s.zeta) for f in (s.chi1, s.rho2, s.S2, s.W1, s.rho4))
_first_flight = sp.atan(s.wave / (1 + s.laplace)) / s.wave
_rub = (1 + s.rolling) * s.inertia / (1 + s.inertia)  # the share of the rim's velocity taken


def _grows(function: sp.Expr) -> sp.Expr:
    return sp.Derivative(function, s.zeta)


ANY_LAW: dict[str, tuple[Any, ...]] = {
    "beyond:rule": ("the collision rule with tangential restitution",
        eq(s.bvp, s.et * s.bv - (s.e + s.et) * dot(s.bv, s.sigma) * s.sigma)),
    "beyond:one-collision": ("speed ratio s and deflection chi of one collision, in the plane "
        "and in space",
        eq(s.s**2, s.e**2 + (s.et**2 - s.e**2) * s.y**2),
        eq(s.s * sp.cos(s.chi), -s.e + (s.e + s.et) * s.y**2)),
    "beyond:measure-plane": ("impact parameter and mean free path in the plane",
        eq(s.chance(s.y), _half),
        eq(s.l, 1 / (2 * s.d * s.rho0))),
    "beyond:measure-space": ("impact parameter and mean free path in space",
        eq(s.chance(s.y), 2 * s.y),
        eq(s.chance(s.y**2), 1),
        eq(s.l, 1 / (sp.pi * s.d**2 * s.rho0))),
    "beyond:plane-equal": ("the plane with e_t = e",
        eq(Avg(s.s**s.p), s.e**s.p),
        eq(s.klog, -sp.log(s.e)),
        eq(s.cos_chi, -Q(1, 3))),
    "beyond:space-power": ("mean power of the speed ratio in space",
        eq(Avg(s.s**s.p), 2 * (s.et**(s.p + 2) - s.e**(s.p + 2))
            / ((s.p + 2) * (s.et**2 - s.e**2)))),
    "beyond:space-log": ("mean log loss kappa in space; the second with e_t = 1",
        eq(s.klog, _half + (s.e**2 * sp.log(s.e) - s.et**2 * sp.log(s.et)) / (s.et**2 - s.e**2)),
        eq(s.klog, _half + s.e**2 * sp.log(s.e) / (1 - s.e**2))),
    "beyond:space-cosine": ("mean cosine of the deflection in space",
        eq(s.cos_chi, 2 * (s.et - s.e) / (3 * (s.et + s.e)))),
    "beyond:space-isotropic": ("in space with e_t = e (elastic spheres) the scattering is "
        "isotropic",
        eq(s.chance(sp.cos(s.chi)), _half),
        *(eq(Avg(mode), 0) for mode in (_first, _second, _third, _fourth))),
    "beyond:space-cooling": ("exact cooling rate of smooth spheres (e_t = 1)",
        eq(s.h, 2 * sp.sqrt(_half + s.e**2 * sp.log(s.e) / (1 - s.e**2))
            * sp.sqrt((1 - s.e) * (1 + 2 * s.e) / (1 + s.e) / 3))),
    "beyond:space-e-zero": ("the scaling solution of smooth spheres at e = 0",
        eq(s.lam(s.p), s.p / (s.p + 2)),
        eq(s.F(s.bc), 3 * sp.exp(-sp.sqrt(6) * s.c) / (2 * sp.pi * s.c)),
        eq(Int(s.F(s.bc), s.bc), 1),
        eq(Avg(s.c**2), 1),
        eq(s.h, sp.sqrt(6) / 3)),
    "beyond:any-average": ("moments of the speed in any dimension",
        eq(Partial(Avg(s.v**s.p), s.t), -s.lam(s.p) * Avg(s.v**(s.p + 1)) / s.l)),
    "beyond:any-moments": ("scaled moments and cooling rate in any dimension",
        eq(Avg(s.c), s.h / (2 * s.klog)),
        eq(Avg(s.c**(s.p + 1)), s.p * s.h * Avg(s.c**s.p) / (2 * s.lam(s.p))),
        eq(s.h, 2 * sp.sqrt(s.klog * s.lam(1)))),
    "beyond:any-slope": ("displacement after N collisions and over time, in any dimension",
        eq(s.msdN(s.N), 2 * s.l**2 * (s.N / (1 - s.cos_chi) - s.cos_chi * (1 - s.cos_chi**s.N)
            / (1 - s.cos_chi)**2)),
        eq(Partial(s.msd(s.t), sp.log(s.t)), 2 * s.l**2 / (s.klog * (1 - s.cos_chi)))),
    "beyond:collision-number": ("variances of collisions and path, per ln t at late times",
        eq(s.VarN, (Avg(sp.log(s.s)**2) - s.klog**2) / s.klog**3),
        eq(s.VarX, s.l**2 * Avg(sp.log(s.s)**2) / s.klog**3)),
    "beyond:spin-moments": ("disks that spin: <v^2> and <u^2> after a collision, u that of the rim",
        eq(Avg(s.speed_after**2), (2 * s.e**2 + (1 - _rub)**2) * Avg(s.v**2) / 3
            + _rub**2 * Avg(s.spin**2)),
        eq(Avg(s.spin_after**2), _rub**2 * Avg(s.v**2) / (3 * s.inertia**2)
            + (1 - _rub / s.inertia)**2 * Avg(s.spin**2))),
    "beyond:quartic-plane": ("the chain of <r^4> in the plane, harmonics i^m exp(i m phi)",
        eq(_grows(_chi1), Avg(sp.cos(s.chi) * s.chi1(_later)) - _chi1 + 1),
        eq(_grows(_rho2), Avg(s.rho2(_later)) - _rho2 + 2 * _chi1),
        eq(_grows(_S2), Avg(sp.cos(2 * s.chi) * s.S2(_later)) - _S2 + _chi1 / 4),
        eq(_grows(_W1), Avg(sp.cos(s.chi) * s.W1(_later)) - _W1 - _rho2 / 8 - _S2 / 2),
        eq(_grows(_rho4), Avg(s.rho4(_later)) - _rho4 - 64 * _W1),
        eq(s.flatness, 2)),
    "beyond:quartic-space": ("the chain of <r^4> in space, Legendre polynomials",
        eq(_grows(_chi1), Avg(_first * s.chi1(_later)) - _chi1 + 1),
        eq(_grows(_rho2), Avg(s.rho2(_later)) - _rho2 + 2 * _chi1),
        eq(_grows(_S2), Avg(_second * s.S2(_later)) - _S2 + Q(2, 3) * _chi1),
        eq(_grows(_W1), Avg(_first * s.W1(_later)) - _W1 + _rho2 / 6 + Q(2, 5) * _S2),
        eq(_grows(_rho4), Avg(s.rho4(_later)) - _rho4 + 40 * _W1),
        eq(s.flatness, Q(5, 3))),
    "beyond:isotropic-plane": ("isotropic scattering at one speed in the plane, and its density "
        "of position",
        eq(s.Fhat(s.wave, s.laplace), 1 / (sp.sqrt((1 + s.laplace)**2 + s.wave**2) - 1)),
        eq(s.g(s.r, s.zeta), sp.exp(-s.zeta) * s.delta(s.r - s.zeta) + s.r
            * sp.exp(sp.sqrt(s.zeta**2 - s.r**2) - s.zeta) / sp.sqrt(s.zeta**2 - s.r**2))),
    "beyond:isotropic-space": ("isotropic scattering at one speed in space",
        eq(s.Fhat(s.wave, s.laplace), _first_flight / (1 - _first_flight))),
    "beyond:quartic-elastic": ("elastic <r^4> as a Laplace transform: in the plane, in space",
        *(eq(s.rho4z(s.laplace), (first / s.laplace + second / (s.laplace + s.nu2))
            / (s.laplace**2 * (s.laplace + s.nu1)**2)) for first,
            second in ((16, 8), (Q(40, 3), Q(32, 3))))),
}  # fmt: skip

_A = s.masses

MASS_RATIO: dict[str, tuple[Any, ...]] = {
    "beyond:mass-map": ("the restitution of a fixed scatterer that has the effect of a mass A m",
        eq(s.effective, (1 + s.relative) * _A / (1 + _A) - 1)),
    "beyond:mass-log-loss": ("mean log loss in space, alpha = 1: neutrons' xi, and its a",
        eq(2 * s.klog, 1 + s.least_share * sp.log(s.least_share) / (1 - s.least_share)),
        eq(s.least_share, ((_A - 1) / (_A + 1))**2)),
    "beyond:mass-cosine": ("mean cosine in space, alpha = 1: A >= 1, and A <= 1",
        eq(s.cos_chi, Q(2, 3) / _A),
        eq(s.cos_chi, 1 - _A**2 / 3)),
    "beyond:mass-age": ("the displacement in the mean log loss xi of the energy: Fermi's age",
        eq(Partial(s.msd(s.t), sp.log(s.t)) / s.l**2, 4 / (s.lethargy * (1 - s.cos_chi)))),
}  # fmt: skip

# -- scatterers met again; a field, in sqrt(g l) and sqrt(l/g); what drives a tracer, in l --

_n = s.rho0 * s.d**2
_sign = (-1) ** s.harm
_next = s.harm + 1
_before = s.harm - 1

FINITE_DENSITY: dict[str, tuple[Any, ...]] = {
    "beyond:straight-back": ("density of the deflections straight back",
        eq(s.back, s.e / (2 * (1 + s.e)))),
    "beyond:return-chance": ("chance to be thrown back to the scatterer before",
        eq(s.retR(s.dist), 2 * s.e * _n / ((1 + s.e) * s.dist)),
        eq(s.ret, 2 * s.e * _n * sp.log(s.l / s.d) / (1 + s.e))),
    "beyond:return-operator": ("the operator of returns on v^p exp(i m phi): to first order, and "
        "summed",
        eq(s.lamd, s.lamm - s.ret * _sign * s.e**s.p * s.lamm**2),
        eq(s.lamd, s.lamm / (1 + s.ret * _sign * s.e**s.p * s.lamm))),
    "beyond:return-slope": ("what returns do to the displacement, and to elastic diffusion",
        eq(s.coefA(s.e), 2 * s.e * (1 - s.cos_chi) / (1 + s.e)),
        eq(s.coefA(1), Q(4, 3))),
    "beyond:enskog-path": ("mean free path among hard disks, to first order in their density",
        eq(s.ln, s.l * (1 - (2 * sp.pi / 3 - sp.sqrt(3) / 2) * _n))),
    "beyond:two-disks": ("returns of an impact parameter y on the second of two distant disks",
        eq(s.offset, (1 + s.e) * s.y * s.dist / (s.e * s.d)),
        eq(s.retR(s.dist), 2 * s.e * _n / ((1 + s.e) * s.dist))),
    "beyond:corridor": ("the way back runs in the corridor of the way out",
        eq(s.damp, 1 + s.offset / 4),
        eq(s.Lnest, sp.log((1 + s.offset / 4) / 2))),
    "beyond:return-delay": ("near pairs of scatterers when a return takes its path: at any path, "
        "summed to n ln(1/n) over all paths, and at none",
        eq(s.retz(s.pathz), -2 * s.e * _n / (1 + s.e) * sp.exp(s.loop0 * s.pathz)
            * sp.Ei(-s.loop0 * (s.lost + s.pathz))),
        eq(s.coefA(s.e), 2 * s.e / (1 + s.e)),
        eq(s.retz(sp.oo), 0)),
    "beyond:free-flight": ("one free flight in Fourier space, harmonic by harmonic",
        eq(s.free(s.harm), (-sp.I * (sp.sqrt(1 + s.wave**2) - 1) / s.wave)**s.harm
            / sp.sqrt(1 + s.wave**2))),
    "beyond:loops": ("the propagator in Fourier space as continued fractions, upwards and "
        "downwards",
        eq(s.tail(s.k), 1 / (s.lamj(s.k) + s.wave**2 * s.tail(s.k + 1) / 4)),
        eq(s.prop, 1 / (s.lamm + s.wave**2 * (s.tail(_next) + s.tail(_before)) / 4))),
}  # fmt: skip

_v, _cos = s.v, sp.cos(s.theta_z)
_F0, _F1, _F2, _F3 = (f(s.v) for f in (s.f0, s.f1, s.f2, s.f3))

UNIFORM_FIELD: dict[str, tuple[Any, ...]] = {
    "beyond:field-plane": ("field: harmonics cos(m phi) of the derivative by v_z, in the plane",
        eq(s.row0(_v), _half * (sp.diff(_F1, _v) + _F1 / _v)),
        eq(s.row1(_v), _half * (sp.diff(_F2, _v) + 2 * _F2 / _v) + sp.diff(_F0, _v)),
        eq(s.row2(_v), _half * (sp.diff(_F3, _v) + 3 * _F3 / _v) + _half
            * (sp.diff(_F1, _v) - _F1 / _v))),
    "beyond:field-space": ("field: harmonics P_m(cos theta) of the derivative by v_z, in space",
        eq(s.row0(_v), (sp.diff(_F1, _v) + 2 * _F1 / _v) / 3),
        eq(s.row1(_v), Q(2, 5) * (sp.diff(_F2, _v) + 3 * _F2 / _v) + sp.diff(_F0, _v)),
        eq(s.row2(_v), Q(3, 7) * (sp.diff(_F3, _v) + 4 * _F3 / _v) + Q(2, 3)
            * (sp.diff(_F1, _v) - _F1 / _v))),
    "beyond:field-moments": ("field: moments of the steady state, harmonics 0 and 1: in the "
        "plane, in space",
        eq(s.lam(s.p) * Avg(_v**(s.p + 1)), s.p * Avg(_v**(s.p - 1) * _cos)),
        eq(s.lam1(s.p) * Avg(_v**(s.p + 1) * _cos),
            _half * (s.p + 1) * Avg(_v**(s.p - 1)) + _half * (s.p - 1)
            * Avg(_v**(s.p - 1) * sp.cos(2 * s.theta_z))),
        eq(s.lam1(s.p) * Avg(_v**(s.p + 1) * _cos),
            Q(1, 3) * (s.p + 2) * Avg(_v**(s.p - 1)) + Q(2, 3) * (s.p - 1)
            * Avg(_v**(s.p - 1) * sp.legendre(2, _cos)))),
    "beyond:field-exact": ("field: exact relations of the steady state",
        eq(Avg(_v**2 * _cos), 1 / s.lam1(1)),
        eq(Avg(_v * _cos), s.lam(2) * Avg(_v**3) / 2),
        eq(Avg(_v**4), 3 * Avg(_v**2 * _cos) / s.lam(3)),
        eq(Avg(_cos), s.lam(1) * Avg(_v**2)),
        eq(Avg(_cos / _v), s.klog * Avg(_v)),
        eq(Avg(_cos / _v**2), Avg(1 / s.s) - 1)),
    "beyond:field-closed": ("field: <v v_z> and <cos/v^2> among smooth disks, and among smooth "
        "spheres",
        eq(Avg(_v**2 * _cos), 3 / (2 * (1 + s.e))),
        eq(Avg(_cos / _v**2), sp.asinh(_b / s.e) / _b - 1),
        eq(Avg(_v**2 * _cos), 2 / (1 + s.e)),
        eq(Avg(_cos / _v**2), (1 - s.e) / (1 + s.e))),
    "beyond:field-nearly-elastic": ("field: f_0 over f_0(0), drift and D_perp as e -> 1: in the "
        "plane, in space",
        eq(s.f0(_v), sp.exp(-Q(2, 9) * s.deficit * _v**4)),
        eq(s.drift, s.deficit / 3 * (Q(2, 9) * s.deficit)**(-Q(3, 4)) * sp.gamma(Q(5, 4))
            / sp.sqrt(sp.pi)),
        eq(s.Dperp, Q(3, 8) * (Q(2, 9) * s.deficit)**(-Q(1, 4)) * sp.gamma(Q(3, 4))
            / sp.sqrt(sp.pi)),
        eq(s.f0(_v), sp.exp(-Q(3, 16) * s.deficit * _v**4)),
        eq(s.drift, s.deficit / 4 * (Q(3, 16) * s.deficit)**(-Q(3, 4)) * sp.sqrt(sp.pi) / 2
            / sp.gamma(Q(3, 4))),
        eq(s.Dperp, (Q(3, 16) * s.deficit)**(-Q(1, 4)) / (3 * sp.gamma(Q(3, 4))))),
    "beyond:field-elastic": ("field at e = 1: f_0 at late times over its factor, in the plane "
        "and in space; from rest <v^3> at all times",
        eq(s.f0(_v), s.t**(-Q(2, 3)) * sp.exp(-8 * _v**3 / (27 * s.t))),
        eq(Avg(_v**3), Q(9, 4) * (s.t - Avg(_v * _cos))),
        eq(s.f0(_v), sp.exp(-_v**3 / (3 * s.t)) / s.t),
        eq(Avg(_v**3), 3 * (s.t - Avg(_v * _cos)))),
}  # fmt: skip

_kick = 1 + s.effective
_rate, _pull = s.bath_rate(_v), s.bath_pull(_v)


def _of_bath(share: sp.Expr, dimension: int) -> tuple[sp.Eq, sp.Eq]:
    """What a bath does to v and v^2; share: E[cos^2] of the angle to the normal."""
    gained = _kick * s.bath**2 * _rate * (dimension + 1) - (1 - s.effective) * _pull
    return (
        eq(s.collided(s.bv), -share * (_kick * _pull / _v**2 * s.bv)),
        eq(s.collided(_v**2), share * (_kick * gained)),
    )


DRIVEN: dict[str, tuple[Any, ...]] = {
    "beyond:bath-temperature": ("bath: the steady Maxwellian of the tracer, with its mass ratio if "
        "it were elastic",
        eq(s.hot**2, s.bath**2 * _kick / (1 - s.effective)),
        eq(s.masses, _kick / (1 - s.effective)),
        eq(s.hot**2 / s.bath**2, (1 + s.relative) * s.masses / (2 + (1 - s.relative) * s.masses))),
    "beyond:bath-moments": ("bath: what collisions do to v and to v^2, in the plane, in space",
        *_of_bath(Q(2, 3), 2),
        *_of_bath(_half, 3)),
    "beyond:bath-from-rest": ("bath: growth of <v^2> of a tracer at rest, in the plane, in space",
        eq(s.collided(_v**2), _kick**2 * s.bath**3 * sp.sqrt(2 * sp.pi)),
        eq(s.collided(_v**2), 4 * _kick**2 * s.bath**3 * sp.sqrt(2 / sp.pi))),
    "beyond:bath-einstein": ("bath: Einstein's relation of a weak field",
        eq(s.mobility, s.diffusivity / s.hot**2)),
    "beyond:heated-moments": ("noise and drag: moments over time; steady ones in steps of three, "
        "and the energy",
        eq(Partial(Avg(_v**s.p), s.t), s.p * (s.p + s.dim - 2) * s.heat * Avg(_v**(s.p - 2))
            - s.p * s.drag * Avg(_v**s.p) - s.lam(s.p) * Avg(_v**(s.p + 1))),
        eq(s.lam(s.p + 2) * Avg(_v**(s.p + 3)), (s.p + 2) * (s.p + s.dim) * s.heat * Avg(_v**s.p)),
        eq(s.lam(2) * Avg(_v**3) + 2 * s.drag * Avg(_v**2), 2 * s.dim * s.heat)),
    "beyond:heated-e-zero": ("noise and drag at e = 0, in the plane and in space: f over a "
        "factor, D_v = 1, without drag and at gamma_v = 1",
        eq(s.f0(_v), sp.airyai(_v)),
        eq(s.f0(_v), (_v + 2) * sp.exp(-_v - _v**2 / 2))),
    "beyond:stick-depth": ("rare sticking in a field: depth of capture, in the plane, in space",
        eq(s.depth, 2 * s.drift / (s.capture**2 * Avg(1 / _v))),
        eq(s.depth, s.drift / (s.capture**2 * Avg(1 / _v)))),
}  # fmt: skip
