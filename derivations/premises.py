"""One collision and its averages over the impact parameter.

Premises: the normal component of the velocity is reversed and multiplied by the coefficient of
restitution e, the tangential one is multiplied by e_t (by 1 in the paper), and the flux of
scatterers towards the tracer is uniform over the cross section. Everything else here follows from
these. In the plane the impact parameter y is then uniform on [-1, 1]: all chords of the exclusion
circle are equally likely. In space y^2 is uniform on [0, 1].

Begin reading with ``collision_matrix``, ``one_collision`` and ``over_impact``.
"""

from __future__ import annotations

from functools import cache

import sympy as sp

from . import symbols as s

# -- one collision --------------------------------------------------------------------------------


def collision_matrix(tangential: sp.Expr = sp.S.One) -> sp.Matrix:
    """The collision as a linear map of the (normal, tangential) components: v = A v*."""
    return sp.ImmutableMatrix([[-s.e, 0], [0, tangential]])


@cache
def velocity_after() -> sp.Matrix:
    """(across, along) of v'/|v|, v at the angle theta to the normal; both lie in one plane."""
    normal = sp.Matrix([sp.sin(s.theta), sp.cos(s.theta)])
    incoming = sp.Matrix([0, 1])
    normal_component = incoming.dot(normal) * normal
    tangential_component = incoming - normal_component
    matrix = collision_matrix(s.et)
    return matrix[1, 1] * tangential_component + matrix[0, 0] * normal_component


@cache
def one_collision() -> tuple[sp.Expr, sp.Expr]:
    """(s^2, s cos(chi)) as polynomials in y = sin(theta), in the plane and in space."""
    velocity = velocity_after()
    square = _in_impact_parameter(velocity.dot(velocity))
    along = _in_impact_parameter(velocity[1])
    return square, along


def _in_impact_parameter(polynomial: sp.Expr) -> sp.Expr:
    """A polynomial in sin(theta) and cos(theta), even in the cosine, as one in y = sin(theta)."""
    sine = sp.sin(s.theta)
    cosine = sp.cos(s.theta)
    without_cosine = sp.rem(sp.expand(polynomial), cosine**2 + sine**2 - 1, cosine)
    return sp.expand(without_cosine).subs(sine, s.y)


def speed_ratio_squared() -> sp.Expr:
    """|v'|^2/|v|^2 of a smooth collision (e_t = 1) as a polynomial in y."""
    return one_collision()[0].subs(s.et, 1)


def parallel_component() -> sp.Expr:
    """v'.v/|v|^2 of a smooth collision as a polynomial in y."""
    return one_collision()[1].subs(s.et, 1)


# -- how often, and with which impact parameter ---------------------------------------------------


def flux_per_angle(dimension: int) -> sp.Expr:
    """Collisions per unit time and unit of theta, over rho0 d^(D-1) |v|: flux times area.

    -pi/2 < theta < pi/2 in the plane; a ring with 0 < theta < pi/2 in space.
    """
    flux = sp.cos(s.theta)
    if dimension == 2:
        return flux
    ring = 2 * sp.pi * sp.sin(s.theta)
    return flux * ring


def _lowest_impact(dimension: int) -> int:
    if dimension == 2:
        return -1
    return 0


@cache
def cross_section(dimension: int) -> sp.Expr:
    """Collisions per unit time over rho0 d^(D-1) |v|."""
    lowest_angle = _lowest_impact(dimension) * sp.pi / 2
    return sp.integrate(flux_per_angle(dimension), (s.theta, lowest_angle, sp.pi / 2))


def mean_free_path(dimension: int) -> sp.Expr:
    """|v| over the rate of collisions."""
    return 1 / (s.rho0 * s.d ** (dimension - 1) * cross_section(dimension))


@cache
def impact_density(dimension: int) -> sp.Expr:
    """The probability density of y: on [-1, 1] in the plane, on [0, 1] in space."""
    sine = sp.sin(s.theta)
    flux_per_impact = sp.cancel(flux_per_angle(dimension) / sp.diff(sine, s.theta))
    return flux_per_impact.subs(sine, s.y) / cross_section(dimension)


# -- averages -------------------------------------------------------------------------------------


def over_impact(weight: sp.Expr, dimension: int = 2) -> sp.Expr:
    """The average over a collision of a function of y."""
    weighted = sp.expand(weight) * impact_density(dimension)
    return sp.integrate(weighted, (s.y, _lowest_impact(dimension), 1))


@cache
def loss(order: int) -> sp.Expr:
    """lambda(p) = E[1 - s^p] for an even order p: the mean relative loss of |v|^p per collision."""
    return sp.factor(over_impact(1 - speed_ratio_squared() ** (order // 2)))


@cache
def space_average(weight: sp.Expr, lowest_ratio: sp.Expr = s.e) -> sp.Expr:
    """The average over a collision in space of a function of s and y^2, with e_t != e.

    s^2 is uniform between e^2 and e_t^2; ``lowest_ratio`` is the lowest s, |e|.
    """
    square, _ = one_collision()
    y_squared = sp.cancel((s.s**2 - square.coeff(s.y, 0)) / square.coeff(s.y, 2))
    density = sp.cancel(impact_density(3) / (2 * s.y) * sp.diff(y_squared, s.s))
    integrand = sp.expand(density * weight.subs(s.y, sp.sqrt(y_squared)))
    terms = sp.Add.make_args(integrand)
    return sum(sp.integrate(term, (s.s, lowest_ratio, s.et)) for term in terms)


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
    average = sp.Integer(0)
    for (order,), coefficient in sp.Poly(polynomial, s.c).terms():
        moment = gaussian_moment().subs(s.p, order) if order else 1
        average += coefficient * moment
    return average
