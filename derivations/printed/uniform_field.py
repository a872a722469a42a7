"""A uniform field, beyond the paper: what is stated. Speeds in sqrt(g l), times in sqrt(l/g)."""

from __future__ import annotations

import sympy as sp

from .. import symbols as s
from ..formal import Avg, eq
from .equation import PrintedEquation

_half, _v, _cos = sp.Rational(1, 2), s.v, sp.cos(s.theta_z)
_F0, _F1, _F2, _F3 = (f(s.v) for f in (s.f0, s.f1, s.f2, s.f3))
_b = sp.sqrt(1 - s.e**2)
_ratio = sp.Rational

_STATED: dict[str, tuple[str, sp.Basic]] = {
    "beyond:field-plane": (
        "field: harmonics cos(m phi) of the derivative by v_z, in the plane",
        sp.Tuple(
            eq(s.row0(_v), _half * (sp.diff(_F1, _v) + _F1 / _v)),
            eq(s.row1(_v), _half * (sp.diff(_F2, _v) + 2 * _F2 / _v) + sp.diff(_F0, _v)),
            eq(
                s.row2(_v),
                _half * (sp.diff(_F3, _v) + 3 * _F3 / _v) + _half * (sp.diff(_F1, _v) - _F1 / _v),
            ),
        ),
    ),
    "beyond:field-space": (
        "field: harmonics P_m(cos theta) of the derivative by v_z, in space",
        sp.Tuple(
            eq(s.row0(_v), (sp.diff(_F1, _v) + 2 * _F1 / _v) / 3),
            eq(s.row1(_v), _ratio(2, 5) * (sp.diff(_F2, _v) + 3 * _F2 / _v) + sp.diff(_F0, _v)),
            eq(
                s.row2(_v),
                _ratio(3, 7) * (sp.diff(_F3, _v) + 4 * _F3 / _v)
                + _ratio(2, 3) * (sp.diff(_F1, _v) - _F1 / _v),
            ),
        ),
    ),
    "beyond:field-moments": (
        "field: moments of the steady state, harmonics 0 and 1: in the plane, in space",
        sp.Tuple(
            eq(s.lam(s.p) * Avg(_v ** (s.p + 1)), s.p * Avg(_v ** (s.p - 1) * _cos)),
            eq(
                s.lam1(s.p) * Avg(_v ** (s.p + 1) * _cos),
                _half * (s.p + 1) * Avg(_v ** (s.p - 1))
                + _half * (s.p - 1) * Avg(_v ** (s.p - 1) * sp.cos(2 * s.theta_z)),
            ),
            eq(
                s.lam1(s.p) * Avg(_v ** (s.p + 1) * _cos),
                _ratio(1, 3) * (s.p + 2) * Avg(_v ** (s.p - 1))
                + _ratio(2, 3) * (s.p - 1) * Avg(_v ** (s.p - 1) * sp.legendre(2, _cos)),
            ),
        ),
    ),
    "beyond:field-exact": (
        "field: exact relations of the steady state",
        sp.Tuple(
            eq(Avg(_v**2 * _cos), 1 / s.lam1(1)),
            eq(Avg(_v * _cos), s.lam(2) * Avg(_v**3) / 2),
            eq(Avg(_v**4), 3 * Avg(_v**2 * _cos) / s.lam(3)),
            eq(Avg(_cos), s.lam(1) * Avg(_v**2)),
            eq(Avg(_cos / _v), s.klog * Avg(_v)),
            eq(Avg(_cos / _v**2), Avg(1 / s.s) - 1),
        ),
    ),
    "beyond:field-closed": (
        "field: <v v_z> and <cos/v^2> among smooth disks, and among smooth spheres",
        sp.Tuple(
            eq(Avg(_v**2 * _cos), 3 / (2 * (1 + s.e))),
            eq(Avg(_cos / _v**2), sp.asinh(_b / s.e) / _b - 1),
            eq(Avg(_v**2 * _cos), 2 / (1 + s.e)),
            eq(Avg(_cos / _v**2), (1 - s.e) / (1 + s.e)),
        ),
    ),
    "beyond:field-nearly-elastic": (
        "field: f_0 over f_0(0), drift and D_perp as e -> 1: in the plane, in space",
        sp.Tuple(
            eq(s.f0(_v), sp.exp(-_ratio(2, 9) * s.deficit * _v**4)),
            eq(
                s.drift,
                s.deficit
                / 3
                * (_ratio(2, 9) * s.deficit) ** -_ratio(3, 4)
                * sp.gamma(_ratio(5, 4))
                / sp.sqrt(sp.pi),
            ),
            eq(
                s.Dperp,
                _ratio(3, 8)
                * (_ratio(2, 9) * s.deficit) ** -_ratio(1, 4)
                * sp.gamma(_ratio(3, 4))
                / sp.sqrt(sp.pi),
            ),
            eq(s.f0(_v), sp.exp(-_ratio(3, 16) * s.deficit * _v**4)),
            eq(
                s.drift,
                s.deficit
                / 4
                * (_ratio(3, 16) * s.deficit) ** -_ratio(3, 4)
                * sp.sqrt(sp.pi)
                / 2
                / sp.gamma(_ratio(3, 4)),
            ),
            eq(
                s.Dperp,
                (_ratio(3, 16) * s.deficit) ** -_ratio(1, 4) / (3 * sp.gamma(_ratio(3, 4))),
            ),
        ),
    ),
    "beyond:field-elastic": (
        "field at e = 1: f_0 at late times over its factor, in the plane and in space; from rest "
        "<v^3> at all times",
        sp.Tuple(
            eq(s.f0(_v), s.t ** -_ratio(2, 3) * sp.exp(-8 * _v**3 / (27 * s.t))),
            eq(Avg(_v**3), _ratio(9, 4) * (s.t - Avg(_v * _cos))),
            eq(s.f0(_v), sp.exp(-(_v**3) / (3 * s.t)) / s.t),
            eq(Avg(_v**3), 3 * (s.t - Avg(_v * _cos))),
        ),
    ),
}

EQUATIONS = {
    label: PrintedEquation(label, title, "Beyond the paper: a uniform field", formula=formula)
    for label, (title, formula) in _STATED.items()
}
