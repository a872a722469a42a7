"""One collision and its averages over the impact parameter.

Premises: the normal component of the velocity is reversed and multiplied by the coefficient of
restitution e, the tangential one is multiplied by e_t (by 1 in the paper), and the flux of
scatterers towards the tracer is uniform over the cross section. Everything else here follows from
these. In the plane the impact parameter is then uniform: all chords of the exclusion circle are
equally likely.
"""

from __future__ import annotations

from functools import cache

import sympy as sp

from . import symbols as s


@cache
def collision_matrix(tangential: sp.Expr = sp.S.One) -> sp.Matrix:
    """The collision as a linear map of the (normal, tangential) components: v = A v*.

    ``tangential`` is the coefficient of tangential restitution.
    """
    before = sp.symbols("v_n v_t", real=True)
    after = sp.symbols("w_n w_t", real=True)
    rule = sp.solve([after[0] + s.e * before[0], after[1] - tangential * before[1]], after)
    return sp.ImmutableMatrix([rule[w] for w in after]).jacobian(before)


@cache
def _before_and_after() -> tuple[sp.Matrix, sp.Matrix]:
    """(normal, tangential) components of v/|v| at angle theta to the normal, and of v'/|v|."""
    before = sp.Matrix([sp.cos(s.theta), sp.sin(s.theta)])
    return before, collision_matrix() * before


@cache
def speed_ratio_squared() -> sp.Expr:
    """|v'|^2/|v|^2 as a polynomial in y = sin(theta), the impact parameter in units of d."""
    _, after = _before_and_after()
    return in_sines(after.dot(after), s.theta).subs(sp.sin(s.theta), s.y)


@cache
def parallel_component() -> sp.Expr:
    """v'.v/|v|^2 as a polynomial in y."""
    before, after = _before_and_after()
    return in_sines(after.dot(before), s.theta).subs(sp.sin(s.theta), s.y)


def contact(dimension: int) -> tuple[sp.Matrix, tuple[sp.Symbol, ...]]:
    """The normal of a contact, a unit vector at angle theta to the velocity, and its angles.

    The velocity is along the last axis; -pi/2 < theta < pi/2 in the plane (2 dimensions), and
    0 < theta < pi/2 with an azimuth from 0 to 2 pi in space (3 dimensions).
    """
    if dimension == 2:
        return sp.Matrix([sp.sin(s.theta), sp.cos(s.theta)]), (s.theta,)
    across = [sp.sin(s.theta) * sp.cos(s.azimuth), sp.sin(s.theta) * sp.sin(s.azimuth)]
    return sp.Matrix([*across, sp.cos(s.theta)]), (s.theta, s.azimuth)


def in_sines(expression: sp.Expr, *angles: sp.Symbol) -> sp.Expr:
    """A polynomial in sines and cosines with every squared cosine as 1 - sine^2."""
    for angle in angles:
        sine, cosine = sp.sin(angle), sp.cos(angle)
        expression = sp.expand(sp.rem(sp.expand(expression), cosine**2 + sine**2 - 1, cosine))
    return expression


@cache
def flux_per_angle(dimension: int) -> sp.Expr:
    """Collisions per unit time and unit of the angles, over rho0 d^(D-1) |v|: flux times area."""
    normal, angles = contact(dimension)
    tangents = normal.jacobian(angles)
    element = sp.sqrt(in_sines((tangents.T * tangents).det(), *angles))
    return normal[-1] * element.replace(sp.Abs, lambda sine: sine)  # theta > 0 in space


@cache
def flux_per_impact(dimension: int) -> sp.Expr:
    """Collisions per unit time and unit of y, over rho0 d^(D-1) |v|; y = sin(theta).

    All y from -1 to 1 in the plane, from 0 to 1 in space.
    """
    flux = flux_per_angle(dimension)
    if dimension == 3:
        flux = sp.integrate(flux, (s.azimuth, 0, 2 * sp.pi))
    return sp.cancel(flux / sp.diff(sp.sin(s.theta), s.theta)).subs(sp.sin(s.theta), s.y)


@cache
def cross_section(dimension: int) -> sp.Expr:
    """Collisions per unit time over rho0 d^(D-1) |v|: the flux, integrated over y."""
    return sp.integrate(flux_per_impact(dimension), (s.y, -1 if dimension == 2 else 0, 1))


def mean_free_path(dimension: int) -> sp.Expr:
    """|v| over the rate of collisions."""
    return 1 / (s.rho0 * s.d ** (dimension - 1) * cross_section(dimension))


@cache
def isotropy() -> sp.Expr:
    """The factor in <v_i v_j b(v)> = factor <v^2 b(v)> delta_ij: an average over the direction."""
    direction = sp.Matrix([sp.cos(s.theta), sp.sin(s.theta)])
    mean = (direction * direction.T).integrate((s.theta, 0, 2 * sp.pi)) / (2 * sp.pi)
    if mean != mean[0, 0] * sp.eye(2):
        raise ArithmeticError("the average over directions is not isotropic")
    return mean[0, 0]


@cache
def free_path(order: int) -> sp.Expr:
    """<L^n> of the free paths, which are exponential whatever the speed, with mean 1."""
    return sp.integrate(s.r**order * sp.exp(-s.r), (s.r, 0, sp.oo))


def over_angle(weight: sp.Expr) -> sp.Expr:
    """The integral of cos(theta) weight over |theta| < pi/2, with y = sin(theta): weight(y)."""
    return sp.factor(sp.integrate(sp.expand(weight), (s.y, -1, 1)))


@cache
def loss(order: int) -> sp.Expr:
    """lambda(p) = E[1 - s^p] for an even order p: the mean relative loss of |v|^p per collision."""
    return sp.factor(over_angle(1 - speed_ratio_squared() ** (order // 2)) / 2)


@cache
def gaussian_moment() -> sp.Expr:
    """<c^p> over exp(-c^2)/pi in the plane, for p > 0: Gamma(1 + p/2)."""
    return sp.integrate(2 * s.c ** (s.p + 1) * sp.exp(-(s.c**2)), (s.c, 0, sp.oo))


def gaussian_average(polynomial: sp.Expr) -> sp.Expr:
    """The average of a polynomial in c over exp(-c^2)/pi in the plane, term by term."""
    terms = sp.Poly(polynomial, s.c).terms()
    return sp.Add(
        *(k * (gaussian_moment().subs(s.p, order) if order else 1) for (order,), k in terms)
    )
