"""One collision and its averages over the impact parameter.

Premises: the normal component of the velocity is reversed and multiplied by the coefficient of
restitution e, the tangential one is multiplied by e_t (by 1 in the paper), and the flux of
scatterers towards the tracer is uniform over the cross section. Everything else here follows from
these. In the plane the impact parameter y is then uniform on [-1, 1]: all chords of the exclusion
circle are equally likely. In space y^2 is uniform on [0, 1].
"""

from __future__ import annotations

from functools import cache

import sympy as sp

from . import symbols as s


def collision_matrix(tangential: sp.Expr = sp.S.One) -> sp.Matrix:
    """The collision as a linear map of the (normal, tangential) components: v = A v*."""
    return sp.ImmutableMatrix([[-s.e, 0], [0, tangential]])


@cache
def velocity_after() -> sp.Matrix:
    """(across, along) of v'/|v|, v at the angle theta to the normal; both lie in one plane."""
    normal, before = sp.Matrix([sp.sin(s.theta), sp.cos(s.theta)]), sp.Matrix([0, 1])
    matrix = collision_matrix(s.et)
    along = before.dot(normal) * normal
    return matrix[1, 1] * (before - along) + matrix[0, 0] * along


@cache
def one_collision() -> tuple[sp.Expr, sp.Expr]:
    """(s^2, s cos(chi)) as polynomials in y = sin(theta), in the plane and in space."""
    after, sine, cosine = velocity_after(), sp.sin(s.theta), sp.cos(s.theta)
    square, along = (
        sp.expand(sp.rem(sp.expand(part), cosine**2 + sine**2 - 1, cosine))
        for part in (after.dot(after), after[1])
    )
    return square.subs(sine, s.y), along.subs(sine, s.y)


def speed_ratio_squared() -> sp.Expr:
    """|v'|^2/|v|^2 of a smooth collision (e_t = 1) as a polynomial in y."""
    return one_collision()[0].subs(s.et, 1)


def parallel_component() -> sp.Expr:
    """v'.v/|v|^2 of a smooth collision as a polynomial in y."""
    return one_collision()[1].subs(s.et, 1)


def flux_per_angle(dimension: int) -> sp.Expr:
    """Collisions per unit time and unit of theta, over rho0 d^(D-1) |v|: flux times area.

    -pi/2 < theta < pi/2 in the plane; a ring with 0 < theta < pi/2 in space.
    """
    return sp.cos(s.theta) * (1 if dimension == 2 else 2 * sp.pi * sp.sin(s.theta))


def _least_impact(dimension: int) -> int:
    return -1 if dimension == 2 else 0


@cache
def cross_section(dimension: int) -> sp.Expr:
    """Collisions per unit time over rho0 d^(D-1) |v|."""
    ends = (_least_impact(dimension) * sp.pi / 2, sp.pi / 2)
    return sp.integrate(flux_per_angle(dimension), (s.theta, *ends))


def mean_free_path(dimension: int) -> sp.Expr:
    """|v| over the rate of collisions."""
    return 1 / (s.rho0 * s.d ** (dimension - 1) * cross_section(dimension))


@cache
def impact_density(dimension: int) -> sp.Expr:
    """The probability density of y: on [-1, 1] in the plane, on [0, 1] in space."""
    per_impact = sp.cancel(flux_per_angle(dimension) / sp.diff(sp.sin(s.theta), s.theta))
    return per_impact.subs(sp.sin(s.theta), s.y) / cross_section(dimension)


def over_impact(weight: sp.Expr, dimension: int = 2) -> sp.Expr:
    """The average over a collision of a function of y."""
    weighted = sp.expand(weight) * impact_density(dimension)
    return sp.integrate(weighted, (s.y, _least_impact(dimension), 1))


@cache
def loss(order: int) -> sp.Expr:
    """lambda(p) = E[1 - s^p] for an even order p: the mean relative loss of |v|^p per collision."""
    return sp.factor(over_impact(1 - speed_ratio_squared() ** (order // 2)))


@cache
def space_average(weight: sp.Expr, least: sp.Expr = s.e) -> sp.Expr:
    """The average over a collision in space of a function of s and y^2, with e_t != e.

    s^2 is uniform between e^2 and e_t^2; ``least`` is the least s, |e|.
    """
    square, _ = one_collision()
    in_ratio = sp.cancel((s.s**2 - square.coeff(s.y, 0)) / square.coeff(s.y, 2))  # y^2
    per_ratio = impact_density(3) / (2 * s.y) * sp.diff(in_ratio, s.s)
    integrand = sp.expand(sp.cancel(per_ratio) * weight.subs(s.y, sp.sqrt(in_ratio)))
    return sum(sp.integrate(term, (s.s, least, s.et)) for term in sp.Add.make_args(integrand))


@cache
def isotropy() -> sp.Expr:
    """The factor in <v_i v_j b(v)> = factor <v^2 b(v)> delta_ij: <cos^2> over the directions."""
    return sp.integrate(sp.cos(s.theta) ** 2, (s.theta, 0, 2 * sp.pi)) / (2 * sp.pi)


@cache
def free_path(order: int) -> sp.Expr:
    """<L^n> of the free paths, which are exponential whatever the speed, with mean 1."""
    return sp.integrate(s.r**order * sp.exp(-s.r), (s.r, 0, sp.oo))


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
