"""A tracer in a uniform field, at low density: harmonics, moments and limits; beyond the paper.

Lengths in l and accelerations in that of the field, which is along z. With x the cosine of the
angle between v and the field, d/dv_z = x d/dv + (1 - x^2)/v d/dx on functions of v and x, in the
plane and in space.
"""

from __future__ import annotations

from functools import cache, partial

import sympy as sp

from .. import symbols as s
from ..formal import Avg, eq
from ..premises import over_impact, parallel_component, space_average, speed_ratio_squared
from .any_dimension import COSINE, harmonic, share
from .record import Derived, derives, result
from .scaling_state import plane_average

_COS = sp.cos(s.theta_z)
_ROWS, _PARTS = (s.row0, s.row1, s.row2), (s.f0, s.f1, s.f2, s.f3)


@cache
def _share(dimension: int, k: int, m: int) -> tuple[sp.Expr, sp.Expr]:
    """Harmonic m of d/dv_z acting on harmonic k: the factors of f_k' and of f_k/v."""
    of = harmonic(k, dimension)
    along = share(COSINE * of, m, dimension)
    return along, share((1 - COSINE**2) * sp.diff(of, COSINE), m, dimension)


@cache
def field_row(dimension: int, m: int) -> sp.Expr:
    """Harmonic m of the derivative by v_z, in the harmonics next to it."""
    found = sp.Integer(0)
    for k, part in enumerate(_PARTS):
        first, second = _share(dimension, k, m)
        found += first * sp.diff(part(s.v), s.v) + second * part(s.v) / s.v
    return sp.expand(found)


def _rows(dimension: int) -> Derived:
    rows = [field_row(dimension, m) for m in range(3)]
    return result(
        sp.Tuple(*(eq(row(s.v), found) for row, found in zip(_ROWS, rows, strict=True))),
        "d/dv_z = x d/dv + (1 - x^2)/v d/dx acts on f_k(v) and its polynomial in x",
        note="The steady state has row_m = v (gain_m - f_m), the gain being E[s^-(d+1) P_m(cos "
        "chi) f_m(v/s)].",
    )


derives("beyond:field-plane")(partial(_rows, 2))
derives("beyond:field-space")(partial(_rows, 3))


def _mean(dimension: int, p: sp.Expr, m: int) -> sp.Expr:
    """The average of v^p times harmonic m of the angle to the field."""
    angle = sp.cos(m * s.theta_z) if dimension == 2 else sp.legendre(m, _COS)
    return Avg(s.v**p * angle)


@cache
def moment_row(dimension: int, m: int) -> sp.Expr:
    """What the field adds to the mean of v^p times harmonic m per time, by parts.

    The derivative by v_z of v^p times the harmonic itself: the boundary vanishes.
    """
    weight = s.v**s.p * harmonic(m, dimension)
    change = COSINE * sp.diff(weight, s.v) + (1 - COSINE**2) / s.v * sp.diff(weight, COSINE)
    over = sp.expand(sp.powsimp(sp.expand(change / s.v ** (s.p - 1))))
    return sum(
        sp.factor(share(over, k, dimension)) * _mean(dimension, s.p - 1, k) for k in range(m + 2)
    )


@derives("beyond:field-moments")
def _moments() -> Derived:
    """Field: moments of the steady state, harmonics 0 and 1: in the plane, in space."""
    (zeroth,) = {moment_row(dimension, 0) for dimension in (2, 3)}  # the same in both
    first = {dimension: moment_row(dimension, 1) for dimension in (2, 3)}
    return result(
        sp.Tuple(
            eq(s.lam(s.p) * _mean(2, s.p + 1, 0), zeroth),
            *(eq(s.lam1(s.p) * _mean(d, s.p + 1, 1), first[d]) for d in (2, 3)),
        ),
        "the loss by collisions is lambda_m(p) times the mean of v^(p+1), at the rate v/l",
    )


@derives("beyond:field-exact")
def _exact() -> Derived:
    """Field: exact relations of the steady state."""
    speed, cos = moment_row(2, 0), _COS
    one = {Avg(sp.Integer(1)): sp.Integer(1)}
    (first,) = {moment_row(dimension, 1).subs(s.p, 1).subs(one) for dimension in (2, 3)}

    def of_power(p: int) -> sp.Expr:
        return sp.powsimp(speed.subs(s.p, p)).subs(one)

    # p -> 0: lambda(p)/p tends to kappa; p = -1: lambda(-1) = 1 - E[1/s]
    inverse = sp.cancel(of_power(-1) / Avg(cos / s.v**2))
    return result(
        sp.Tuple(
            eq(Avg(s.v**2 * cos), first / s.lam1(1)),
            eq(Avg(s.v * cos), s.lam(2) * Avg(s.v**3) / sp.cancel(of_power(2) / Avg(s.v * cos))),
            eq(Avg(s.v**4), of_power(3) / s.lam(3)),
            eq(Avg(cos), s.lam(1) * Avg(s.v**2) / sp.cancel(of_power(1) / Avg(cos))),
            eq(Avg(cos / s.v), s.klog * Avg(s.v)),
            eq(Avg(cos / s.v**2), (1 - Avg(1 / s.s)) / inverse),
        ),
        "row 1 with p = 1, row 0 with p = 2, 3, 1; p -> 0, where lambda(p)/p -> kappa; and p = -1",
        note="In the plane and in space, for every law. The last needs E[1/s] to exist.",
    )


@derives("beyond:field-closed")
def _closed() -> Derived:
    """Field: <v v_z> and <cos/v^2> among smooth disks, and among smooth spheres."""
    inverse = plane_average(1 / s.s), sp.factor(space_average(1 / s.s).subs(s.et, 1))  # E[1/s]
    rows = []
    for dimension in (2, 3):
        rate = over_impact(1 - parallel_component(), dimension)
        rows.append(eq(Avg(s.v**2 * _COS), sp.factor(1 / rate)))
        rows.append(eq(Avg(_COS / s.v**2), inverse[dimension - 2] - 1))
    return result(sp.Tuple(*rows))


@cache
def _near_elastic(dimension: int) -> tuple[sp.Expr, sp.Expr]:
    """(kappa, lambda_1(0)) to leading order in 1 - e^2."""
    lost = over_impact(1 - speed_ratio_squared(), dimension) / 2  # -ln s = (1 - s^2)/2 + ...
    kappa = lost.subs(s.e, sp.sqrt(1 - s.deficit))
    return sp.simplify(kappa), over_impact(1 - parallel_component(), dimension).subs(s.e, 1)


@cache
def _slow_steady_state(dimension: int) -> tuple[sp.Expr, sp.Expr, sp.Expr]:
    """(f_0 over f_0(0), drift, D_perp) as e -> 1.

    Row 1 is f_0' = -lambda_1 v f_1. Row 0 says that what the field brings up, f_1 v^(d-1)/d, is
    what the loss dv/dt = -kappa v^2 takes down.
    """
    kappa, rate = _near_elastic(dimension)
    field_share = _share(dimension, 1, 0)[0]
    first = kappa * s.v**2 / field_share  # f_1/f_0
    exponent = sp.integrate(-rate * s.v * first, (s.v, 0, s.v))
    shape = sp.exp(sp.expand(exponent))
    volume = s.v ** (dimension - 1)

    def mean(weight: sp.Expr) -> sp.Expr:
        whole = sp.integrate(volume * shape, (s.v, 0, sp.oo))
        return sp.integrate(sp.expand(weight * volume) * shape, (s.v, 0, sp.oo)) / whole

    # <v_z> is the mean of v f_1/f_0 times the mean of cos^2; v_x f_0 = lambda_1 v h
    drift = mean(s.v * first) * field_share
    across = mean(s.v) / rate * field_share
    return shape, sp.simplify(drift), sp.simplify(across)


@derives("beyond:field-nearly-elastic")
def _nearly_elastic() -> Derived:
    """Field: f_0 over f_0(0), drift and D_perp as e -> 1: in the plane, in space."""
    rows = []
    for dimension in (2, 3):
        shape, drift, across = _slow_steady_state(dimension)
        rows += [eq(s.f0(s.v), shape), eq(s.drift, drift), eq(s.Dperp, across)]
    return result(
        sp.Tuple(*rows),
        "f_0' = -lambda_1 v f_1 and f_1/d = kappa v^2 f_0",
        note="Slow collisions spread the directions before the speed changes.",
    )


@cache
def _self_similar(dimension: int) -> sp.Expr:
    """t^-a exp(-b v^3/t), which d_t f_0 + row_0 = 0 with f_1 = -f_0'/(lambda_1 v) fixes."""
    _, rate = _near_elastic(dimension)
    a, b = sp.symbols("a b", positive=True)
    shape = s.t**-a * sp.exp(-b * s.v**3 / s.t)
    first = -sp.diff(shape, s.v) / (rate * s.v)
    row = field_row(dimension, 0).subs(s.f1(s.v), first).doit()
    left = sp.Poly(sp.simplify((sp.diff(shape, s.t) + row) / shape * s.t**2), s.v)
    (found,) = sp.solve(left.coeffs(), (a, b), dict=True)
    return shape.subs(found)


@derives("beyond:field-elastic")
def _elastic() -> Derived:
    """Field at e = 1: f_0 at late times over its factor, in the plane and in space; from rest
    <v^3> at all times.
    """
    rows = []
    for dimension in (2, 3):
        _, rate = _near_elastic(dimension)
        # d<v_z>/dt = 1 - lambda_1 <v v_z>, and d<v^3>/dt = 3 <v^2 cos> since lambda(3) = 0
        growth = moment_row(dimension, 0).subs(s.p, 3).coeff(Avg(s.v**2 * _COS))
        cube = growth / rate * (s.t - Avg(s.v * _COS))
        rows += [eq(s.f0(s.v), _self_similar(dimension)), eq(Avg(s.v**3), cube)]
    return result(
        sp.Tuple(*rows),
        "late: f_1 = -f_0'/(lambda_1 v), and d_t f_0 = -row_0",
        "d<v_z>/dt = 1 - lambda_1 <v v_z>: <v v_z> is known over time from <v_z>",
        note="No steady state: the energy is that of the fall, v^2 = 2 z.",
    )
