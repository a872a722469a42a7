"""Results beyond the paper as they are stated: of its law, and of any collision law.

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
