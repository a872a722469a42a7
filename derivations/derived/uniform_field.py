"""A tracer in a uniform field, at low density: harmonics, moments and limits; beyond the paper.

Lengths in l and accelerations in that of the field, which is along z. With x the cosine of the
angle between v and the field, d/dv_z = x d/dv + (1 - x^2)/v d/dx on functions of v and x, in the
plane and in space.
"""

from __future__ import annotations

from functools import cache

import sympy as sp

from .. import symbols as s
from ..formal import Avg, eq
from ..premises import over_impact, parallel_component, space_average, speed_ratio_squared
from .any_dimension import COSINE, harmonic, share
from .record import Derived, derives, result
from .scaling_state import plane_average

_COSINE_TO_FIELD = sp.cos(s.theta_z)
_ROWS = (s.row0, s.row1, s.row2)
_HARMONICS = (s.f0, s.f1, s.f2, s.f3)
_NORMALISED = {Avg(sp.Integer(1)): sp.Integer(1)}
"""The average of 1, which is 1."""


def _derivative_along_field(weight: sp.Expr) -> sp.Expr:
    """d/dv_z of a function of v and x: x d/dv + (1 - x^2)/v d/dx."""
    return COSINE * sp.diff(weight, s.v) + (1 - COSINE**2) / s.v * sp.diff(weight, COSINE)


# -- the derivative by v_z, harmonic by harmonic --------------------------------------------------


@cache
def _share_of_slope(dimension: int, k: int, m: int) -> sp.Expr:
    """The factor of f_k' in harmonic m of d/dv_z acting on harmonic k."""
    return share(COSINE * harmonic(k, dimension), m, dimension)


@cache
def _share_of_value(dimension: int, k: int, m: int) -> sp.Expr:
    """The factor of f_k/v in harmonic m of d/dv_z acting on harmonic k."""
    slope = sp.diff(harmonic(k, dimension), COSINE)
    return share((1 - COSINE**2) * slope, m, dimension)


@cache
def field_row(dimension: int, m: int) -> sp.Expr:
    """Harmonic m of the derivative by v_z, in the harmonics next to it."""
    total = sp.Integer(0)
    for k, f_k in enumerate(_HARMONICS):
        total += _share_of_slope(dimension, k, m) * sp.diff(f_k(s.v), s.v)
        total += _share_of_value(dimension, k, m) * f_k(s.v) / s.v
    return sp.expand(total)


def _derive_rows(dimension: int) -> Derived:
    equations = [eq(name(s.v), field_row(dimension, m)) for m, name in enumerate(_ROWS)]
    return result(
        sp.Tuple(*equations),
        "d/dv_z = x d/dv + (1 - x^2)/v d/dx acts on f_k(v) and its polynomial in x",
        note="The steady state has row_m = v (gain_m - f_m), the gain being E[s^-(d+1) P_m(cos "
        "chi) f_m(v/s)].",
    )


@derives("beyond:field-plane")
def _rows_in_the_plane() -> Derived:
    """Harmonics cos(m phi) of the derivative by v_z, in the plane."""
    return _derive_rows(2)


@derives("beyond:field-space")
def _rows_in_space() -> Derived:
    """Harmonics P_m(cos theta) of the derivative by v_z, in space."""
    return _derive_rows(3)


# -- moments of the steady state ------------------------------------------------------------------


def _mean(dimension: int, p: sp.Expr, m: int) -> sp.Expr:
    """The average of v^p times harmonic m of the angle to the field."""
    if dimension == 2:
        angle = sp.cos(m * s.theta_z)
    else:
        angle = sp.legendre(m, _COSINE_TO_FIELD)
    return Avg(s.v**p * angle)


@cache
def moment_row(dimension: int, m: int) -> sp.Expr:
    """What the field adds to the mean of v^p times harmonic m per time, by parts.

    The derivative by v_z of v^p times the harmonic itself: the boundary vanishes.
    """
    weight = s.v**s.p * harmonic(m, dimension)
    change = _derivative_along_field(weight)
    polynomial = sp.expand(sp.powsimp(sp.expand(change / s.v ** (s.p - 1))))
    total = sp.Integer(0)
    for k in range(m + 2):
        factor = sp.factor(share(polynomial, k, dimension))
        total += factor * _mean(dimension, s.p - 1, k)
    return total


@derives("beyond:field-moments")
def _moments() -> Derived:
    """Moments of the steady state, harmonics 0 and 1: in the plane, in space."""
    (zeroth,) = {moment_row(dimension, 0) for dimension in (2, 3)}  # the same in both
    equations = [eq(s.lam(s.p) * _mean(2, s.p + 1, 0), zeroth)]
    for dimension in (2, 3):
        loss = s.lam1(s.p) * _mean(dimension, s.p + 1, 1)
        equations.append(eq(loss, moment_row(dimension, 1)))
    return result(
        sp.Tuple(*equations),
        "the loss by collisions is lambda_m(p) times the mean of v^(p+1), at the rate v/l",
    )


@derives("beyond:field-exact")
def _exact() -> Derived:
    """Exact relations of the steady state."""
    cosine = _COSINE_TO_FIELD
    rows_at_one = {moment_row(dimension, 1).subs(s.p, 1) for dimension in (2, 3)}
    (row_1,) = {row.subs(_NORMALISED) for row in rows_at_one}

    def row_0(p: int) -> sp.Expr:
        return sp.powsimp(moment_row(2, 0).subs(s.p, p)).subs(_NORMALISED)

    mean_of_vz = sp.cancel(row_0(2) / Avg(s.v * cosine))
    mean_of_cosine = sp.cancel(row_0(1) / Avg(cosine))
    # p = -1: lambda(-1) = 1 - E[1/s]
    mean_of_inverse = sp.cancel(row_0(-1) / Avg(cosine / s.v**2))
    return result(
        sp.Tuple(
            eq(Avg(s.v**2 * cosine), row_1 / s.lam1(1)),
            eq(Avg(s.v * cosine), s.lam(2) * Avg(s.v**3) / mean_of_vz),
            eq(Avg(s.v**4), row_0(3) / s.lam(3)),
            eq(Avg(cosine), s.lam(1) * Avg(s.v**2) / mean_of_cosine),
            # p -> 0: lambda(p)/p tends to kappa
            eq(Avg(cosine / s.v), s.klog * Avg(s.v)),
            eq(Avg(cosine / s.v**2), (1 - Avg(1 / s.s)) / mean_of_inverse),
        ),
        "row 1 with p = 1, row 0 with p = 2, 3, 1; p -> 0, where lambda(p)/p -> kappa; and p = -1",
        note="In the plane and in space, for every law. The last needs E[1/s] to exist.",
    )


@derives("beyond:field-closed")
def _closed() -> Derived:
    """<v v_z> and <cos/v^2> among smooth disks, and among smooth spheres."""
    mean_inverse_ratio = {  # E[1/s]
        2: plane_average(1 / s.s),
        3: sp.factor(space_average(1 / s.s).subs(s.et, 1)),
    }
    equations = []
    for dimension in (2, 3):
        decay = over_impact(1 - parallel_component(), dimension)
        equations.append(eq(Avg(s.v**2 * _COSINE_TO_FIELD), sp.factor(1 / decay)))
        inverse = mean_inverse_ratio[dimension] - 1
        equations.append(eq(Avg(_COSINE_TO_FIELD / s.v**2), inverse))
    return result(sp.Tuple(*equations))


# -- limits ---------------------------------------------------------------------------------------


@cache
def _log_loss_near_elastic(dimension: int) -> sp.Expr:
    """kappa to leading order in 1 - e^2, where -ln s = (1 - s^2)/2 + ..."""
    energy_loss = over_impact(1 - speed_ratio_squared(), dimension) / 2
    return sp.simplify(energy_loss.subs(s.e, sp.sqrt(1 - s.deficit)))


@cache
def _elastic_decay(dimension: int) -> sp.Expr:
    """lambda_1(0) at e = 1: the loss of direction per collision."""
    return over_impact(1 - parallel_component(), dimension).subs(s.e, 1)


@cache
def _slow_steady_state(dimension: int) -> tuple[sp.Expr, sp.Expr, sp.Expr]:
    """(f_0 over f_0(0), drift, D_perp) as e -> 1.

    Row 1 is f_0' = -lambda_1 v f_1. Row 0 says that what the field brings up, f_1 v^(d-1)/d, is
    what the loss dv/dt = -kappa v^2 takes down.
    """
    log_loss = _log_loss_near_elastic(dimension)
    decay = _elastic_decay(dimension)
    cosine_square = _share_of_slope(dimension, 1, 0)  # the mean of cos^2
    f1_over_f0 = log_loss * s.v**2 / cosine_square
    exponent = sp.integrate(-decay * s.v * f1_over_f0, (s.v, 0, s.v))
    shape = sp.exp(sp.expand(exponent))
    volume = s.v ** (dimension - 1)

    def mean(weight: sp.Expr) -> sp.Expr:
        norm = sp.integrate(volume * shape, (s.v, 0, sp.oo))
        return sp.integrate(sp.expand(weight * volume) * shape, (s.v, 0, sp.oo)) / norm

    # <v_z> is the mean of v f_1/f_0 times the mean of cos^2; v_x f_0 = lambda_1 v h
    drift = mean(s.v * f1_over_f0) * cosine_square
    diffusion = mean(s.v) / decay * cosine_square
    return shape, sp.simplify(drift), sp.simplify(diffusion)


@derives("beyond:field-nearly-elastic")
def _nearly_elastic() -> Derived:
    """f_0 over f_0(0), drift and D_perp as e -> 1: in the plane, in space."""
    equations = []
    for dimension in (2, 3):
        shape, drift, diffusion = _slow_steady_state(dimension)
        equations += [eq(s.f0(s.v), shape), eq(s.drift, drift), eq(s.Dperp, diffusion)]
    return result(
        sp.Tuple(*equations),
        "f_0' = -lambda_1 v f_1 and f_1/d = kappa v^2 f_0",
        note="Slow collisions spread the directions before the speed changes.",
    )


@cache
def _self_similar(dimension: int) -> sp.Expr:
    """t^-a exp(-b v^3/t), which d_t f_0 + row_0 = 0 with f_1 = -f_0'/(lambda_1 v) fixes."""
    a, b = sp.symbols("a b", positive=True)
    shape = s.t**-a * sp.exp(-b * s.v**3 / s.t)
    f_1 = -sp.diff(shape, s.v) / (_elastic_decay(dimension) * s.v)
    row_0 = field_row(dimension, 0).subs(s.f1(s.v), f_1).doit()
    balance = sp.simplify((sp.diff(shape, s.t) + row_0) / shape * s.t**2)
    (exponents,) = sp.solve(sp.Poly(balance, s.v).coeffs(), (a, b), dict=True)
    return shape.subs(exponents)


@derives("beyond:field-elastic")
def _elastic() -> Derived:
    """The field at e = 1: f_0 at late times over its factor; from rest <v^3> at all times."""
    equations = []
    for dimension in (2, 3):
        # d<v_z>/dt = 1 - lambda_1 <v v_z>, and d<v^3>/dt = 3 <v^2 cos> since lambda(3) = 0
        growth = moment_row(dimension, 0).subs(s.p, 3).coeff(Avg(s.v**2 * _COSINE_TO_FIELD))
        fallen = s.t - Avg(s.v * _COSINE_TO_FIELD)
        cube = growth / _elastic_decay(dimension) * fallen
        equations.append(eq(s.f0(s.v), _self_similar(dimension)))
        equations.append(eq(Avg(s.v**3), cube))
    return result(
        sp.Tuple(*equations),
        "late: f_1 = -f_0'/(lambda_1 v), and d_t f_0 = -row_0",
        "d<v_z>/dt = 1 - lambda_1 <v v_z>: <v v_z> is known over time from <v_z>",
        note="No steady state: the energy is that of the fall, v^2 = 2 z.",
    )
