"""Results beyond the paper as they are stated: scatterers met again, a field, what drives a tracer.

In the field speeds are in sqrt(g l) and times in sqrt(l/g). Driven tracers: lengths in l.
"""

from __future__ import annotations

from typing import Any

import sympy as sp

from .. import symbols as s
from ..formal import Avg, Partial, eq

Q = sp.Rational
_half = Q(1, 2)
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
_b = sp.sqrt(1 - s.e**2)

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
