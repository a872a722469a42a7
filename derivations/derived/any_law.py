"""One collision with a tangential restitution, in the plane and in space; beyond the paper.

The rule is taken from the vectors, the measure of the impact parameter y from a uniform flux.
In the plane y is uniform on [-1, 1]; in space y^2 is uniform on [0, 1], so that s^2 is uniform
between e^2 and e_t^2: every average in space is an elementary integral over s.
"""

from __future__ import annotations

from functools import cache

import sympy as sp

from .. import symbols as s
from ..formal import Avg, Int, dot, eq
from ..premises import (
    collision_matrix,
    contact,
    cross_section,
    flux_per_angle,
    flux_per_impact,
    in_sines,
    mean_free_path,
)
from .any_dimension import cooling_rate
from .record import Derived, derives, must, result, row, zero


@derives("beyond:rule")
def _rule() -> Derived:
    matrix = collision_matrix(s.et)
    normal = dot(s.bv, s.sigma) * s.sigma
    after = matrix[1, 1] * (s.bv - normal) + matrix[0, 0] * normal
    return result(eq(s.bvp, sp.collect(sp.expand(after), normal)))


@cache
def velocity_after(dimension: int) -> sp.Matrix:
    """v'/|v| for a velocity along the last axis, in the angles of the contact."""
    normal, _ = contact(dimension)
    before = sp.Matrix([0] * (dimension - 1) + [1])
    matrix = collision_matrix(s.et)
    along = before.dot(normal) * normal
    return matrix[1, 1] * (before - along) + matrix[0, 0] * along


@cache
def one_collision(dimension: int) -> tuple[sp.Expr, sp.Expr]:
    """(s^2, s cos(chi)) as polynomials in y = sin(theta)."""
    after = velocity_after(dimension)

    def in_impact_parameter(expression: sp.Expr) -> sp.Expr:
        return in_sines(expression, *contact(dimension)[1]).subs(sp.sin(s.theta), s.y)

    return in_impact_parameter(after.dot(after)), in_impact_parameter(after[-1])


@cache
def _polynomials() -> tuple[sp.Expr, sp.Expr]:
    """(s^2, s cos(chi)) in y, the same in the plane and in space."""
    must(one_collision(2) == one_collision(3), "space is not the plane of v and sigma")
    return one_collision(2)


@derives("beyond:one-collision")
def _one_collision() -> Derived:
    square, along = _polynomials()
    smooth = {s.e: s.e / s.et, s.et: 1}
    smooth_square, smooth_along = (part.subs(smooth, simultaneous=True) for part in (square, along))
    scaled = (sp.expand(square - s.et**2 * smooth_square), sp.expand(along - s.et * smooth_along))
    must(scaled == (0, 0), "e_t is not a scale of the speed alone")
    return result(
        sp.Tuple(eq(s.s**2, square), eq(s.s * sp.cos(s.chi), along)),
        ("v'/|v| in the plane, v along the last axis", sp.Tuple(*velocity_after(2))),
        note="But for a factor both depend on e/e_t alone: s(e, e_t) = e_t s(e/e_t, 1), and the "
        "deflection is that of the restitution e/e_t with e_t = 1.",
    )


@cache
def impact_density(dimension: int) -> sp.Expr:
    """The probability density of y: on [-1, 1] in the plane, on [0, 1] in space."""
    normal, angles = contact(dimension)
    across = normal[: dimension - 1, 0]  # the part of the normal across the velocity
    element = in_sines(across.jacobian(angles).det(), *angles[1:])
    zero(flux_per_angle(dimension) - element, "the flux is not uniform over the cross section")
    return flux_per_impact(dimension) / cross_section(dimension)


row(
    "beyond:measure-plane",
    lambda: sp.Tuple(eq(s.chance(s.y), impact_density(2)), eq(s.l, mean_free_path(2))),
    "collisions per angle: flux through the circle, over d rho0 |v|",
)


@derives("beyond:measure-space")
def _measure_space() -> Derived:
    squared = impact_density(3) / sp.diff(s.y**2, s.y)  # per unit of y^2
    return result(
        sp.Tuple(
            eq(s.chance(s.y), impact_density(3)),
            eq(s.chance(s.y**2), squared),
            eq(s.l, mean_free_path(3)),
        ),
        ("collisions per angle: flux through the sphere, over d^2 rho0 |v|", flux_per_angle(3)),
        note="Here y runs from 0 to 1; the azimuth about v is uniform.",
    )


@cache
def plane_average(weight: sp.Expr) -> sp.Expr:
    """The average over a collision in the plane of a function of y."""
    return sp.integrate(sp.expand(weight) * impact_density(2), (s.y, -1, 1))


@cache
def space_average(weight: sp.Expr) -> sp.Expr:
    """The average over a collision in space of a function of s and y, with e_t != e."""
    square, _ = _polynomials()
    in_ratio = sp.cancel((s.s**2 - square.coeff(s.y, 0)) / square.coeff(s.y, 2))  # y^2
    per_ratio = impact_density(3) / (2 * s.y) * sp.diff(in_ratio, s.s)
    integrand = sp.expand(sp.cancel(per_ratio) * weight.subs(s.y, sp.sqrt(in_ratio)))
    return sum(sp.integrate(term, (s.s, s.e, s.et)) for term in sp.Add.make_args(integrand))


@derives("beyond:plane-equal")
def _plane_equal() -> Derived:
    square, along = (part.subs(s.et, s.e) for part in _polynomials())
    ratio = sp.sqrt(square)
    cosine = sp.cancel(along / ratio)
    return result(
        sp.Tuple(
            eq(Avg(s.s**s.p), plane_average(ratio**s.p)),
            eq(s.klog, plane_average(-sp.log(ratio))),
            eq(s.cos_chi, plane_average(cosine)),
        ),
        ("s with e_t = e does not depend on y", ratio),
        note="Every collision multiplies the speed by e and deflects as an elastic one.",
    )


@cache
def space_power() -> sp.Expr:
    """E[s^p] in space, in e and e_t."""
    return sp.powsimp(sp.factor(space_average(s.s**s.p)))


row(
    "beyond:space-power",
    lambda: eq(Avg(s.s**s.p), space_power()),
    "y^2 is uniform on [0, 1], so s^2 is uniform from e^2 to e_t^2",
    note="As e_t -> e it tends to e^p. lambda(p) = 1 - E[s^p].",
)


@cache
def space_log_loss() -> sp.Expr:
    """kappa = E[-ln s] in space, in e and e_t."""
    total = sp.expand(space_average(-sp.log(s.s)))
    logarithms = [sp.log(s.e), sp.log(s.et)]
    parts = [sp.factor(total.coeff(part)) * part for part in logarithms]
    rest = total.subs(dict.fromkeys(logarithms, 0))
    return sp.cancel(rest) + sum(parts)


@derives("beyond:space-log")
def _space_log() -> Derived:
    smooth = space_log_loss().subs(s.et, 1)
    zero(-sp.diff(space_power(), s.p).subs(s.p, 0) - space_log_loss(), "kappa is not lambda'(0)")
    return result(sp.Tuple(eq(s.klog, space_log_loss()), eq(s.klog, smooth)))


@cache
def space_cosine() -> sp.Expr:
    """The mean cosine of the deflection in space, in e and e_t."""
    return sp.factor(space_average(_polynomials()[1] / s.s))


row(
    "beyond:space-cosine",
    lambda: eq(s.cos_chi, space_cosine()),
    note="Zero for elastic spheres, which scatter isotropically; 2/3 at e = 0.",
)


@derives("beyond:space-isotropic")
def _space_isotropic() -> Derived:
    square, along = (part.subs(s.et, s.e) for part in _polynomials())
    cosine = sp.cancel(along / sp.sqrt(square))
    density = sp.cancel(impact_density(3) / sp.diff(cosine, s.y))
    ends = cosine.subs(s.y, 0), cosine.subs(s.y, 1)
    must(ends == (-1, 1), "cos(chi) does not run from -1 to 1")
    modes = [sp.legendre(order, sp.cos(s.chi)) for order in (1, 2, 3, 4)]
    means = [
        sp.integrate(sp.expand(mode.subs(sp.cos(s.chi), cosine)) * impact_density(3), (s.y, 0, 1))
        for mode in modes
    ]
    return result(
        sp.Tuple(
            eq(s.chance(sp.cos(s.chi)), density),
            *(eq(Avg(mode), mean) for mode, mean in zip(modes, means, strict=True)),
        ),
        ("cos(chi) with e_t = e", cosine),
        note="Uniform on [-1, 1] means that every Legendre polynomial of order 1 and more averages "
        "to zero. It holds for every e_t = e, at e = 1 for elastic spheres.",
    )


@cache
def space_cooling_rate() -> sp.Expr:
    """h(e) of smooth spheres, e_t = 1."""
    smooth = {s.klog: space_log_loss().subs(s.et, 1), s.lam(1): _smooth_loss_one()}
    return cooling_rate().subs(smooth)


def _smooth_loss_one() -> sp.Expr:
    """lambda(1) of smooth spheres."""
    return sp.factor(1 - space_power().subs(s.p, 1).subs(s.et, 1))


@derives("beyond:space-cooling")
def _space_cooling() -> Derived:
    def rate(e: float) -> sp.Expr:
        return space_cooling_rate().subs(s.e, sp.Rational(str(e))).evalf(20)

    return result(
        eq(s.h, space_cooling_rate()),
        ("kappa with e_t = 1", space_log_loss().subs(s.et, 1)),
        note="With v0 the root mean square speed, as in the plane: dv0/dt = -h v0^2/(2 l).",
        numbers={"h at e = {e}": rate},
        at=(0.4, 0.7, 0.9),
    )


def _loss_at_e_zero(dimension: int) -> sp.Expr:
    """lambda(p) of smooth scatterers at e = 0, where s = |y|."""
    return sp.factor(1 - sp.integrate(s.y**s.p * speed_at_e_zero(dimension), (s.y, 0, 1)))


def speed_at_e_zero(dimension: int) -> sp.Expr:
    """The density of s = |y| at e = 0."""
    must(_polynomials()[0].subs({s.e: 0, s.et: 1}) == s.y**2, "s is not |y|")
    return impact_density(dimension) * (2 if dimension == 2 else 1)  # both signs of y


@cache
def e_zero_solution(dimension: int) -> sp.Expr:
    """F(c) of smooth scatterers at e = 0, where Y has the density y^(D-2) exp(-y)."""
    order, loss = sp.Symbol("order", positive=True), _loss_at_e_zero(dimension)
    found = sp.gamma(order + dimension - 1)  # the integral of y^order y^(D-2) exp(-y)
    ratio = sp.gammasimp(found.subs(order, order + 1) / found)
    # E[Y^(n+1)] = n E[Y^n]/lambda(n), and E[Y] = 1/kappa (beyond:moments)
    zero(ratio - order / loss.subs(s.p, order), "not the moments of Y")
    must(found.subs(order, 1) * sp.diff(loss, s.p).subs(s.p, 0) == 1, "not the mean of Y")
    scale = sp.sqrt(found.subs(order, 2))  # c = Y/sqrt(E[Y^2])
    density = scale * (s.x ** (dimension - 2) * sp.exp(-s.x)).subs(s.x, scale * s.c)
    return density / _shell(s.c, dimension)


def _shell(radius: sp.Expr, dimension: int) -> sp.Expr:
    return 2 * (dimension - 1) * sp.pi * radius ** (dimension - 1)


@cache
def e_zero_residual(dimension: int) -> tuple[sp.Expr, sp.Expr, sp.Expr, sp.Expr]:
    """(gain, loss, h, residual) of the scaled equation at e = 0 with that F inserted.

    A tracer of speed u leaves a collision with speed u |y|; all per unit of volume of velocity,
    with the rate of collisions u (l = 1).
    """
    u, shape = sp.Symbol("u", positive=True), e_zero_solution(dimension)
    after = speed_at_e_zero(dimension).subs(s.y, s.c / u) / u
    arriving = _shell(u, dimension) * shape.subs(s.c, u) * u * after
    gain = sp.integrate(arriving, (u, s.c, sp.oo)) / _shell(s.c, dimension)
    third = sp.integrate(_shell(s.c, dimension) * s.c**3 * shape, (s.c, 0, sp.oo))
    rate = _loss_at_e_zero(dimension).subs(s.p, 2) * third
    right = rate / 2 * (dimension * shape + s.c * sp.diff(shape, s.c))
    return gain, s.c * shape, rate, sp.simplify(gain - s.c * shape - right)


def _e_zero(dimension: int) -> tuple[sp.Eq, sp.Expr]:
    _, _, rate, residual = e_zero_residual(dimension)
    must(residual == 0, f"the scaled equation at e = 0 leaves {residual}")
    return eq(s.F(s.bc), e_zero_solution(dimension)), rate


@derives("beyond:e-zero")
def _plane_e_zero() -> Derived:
    shape, rate = _e_zero(2)
    return result(sp.Tuple(shape, eq(s.M2 / 2, rate)), "Y is exponential; h = lambda(2) <c^3>")


@derives("beyond:space-e-zero")
def _space_e_zero() -> Derived:
    shape, rate = _e_zero(3)
    norm, second = (
        sp.integrate(_shell(s.c, 3) * s.c**order * shape.rhs, (s.c, 0, sp.oo)) for order in (0, 2)
    )
    return result(
        sp.Tuple(
            eq(s.lam(s.p), _loss_at_e_zero(3)),
            shape,
            eq(Int(s.F(s.bc), s.bc), norm),
            eq(Avg(s.c**2), second),
            eq(s.h, rate),
        ),
        "Y has the density y exp(-y); h = lambda(2) <c^3>",
        numbers={"h at e = 0": rate},
    )


@derives("beyond:spin-moments")
def _spin_moments() -> Derived:
    # the impulse on the rim, over m, adds to v_t, and 1/k of it to u; v_t + u becomes -beta of it
    normal, along, push = sp.symbols("v_n v_t J", real=True)
    rim = along + s.spin
    (push_,) = sp.solve(rim + push * (1 + 1 / s.inertia) + s.rolling * rim, push)
    after = (s.e * normal) ** 2 + (along + push_) ** 2, (s.spin + push_ / s.inertia) ** 2
    means = []
    for square in after:
        # an impact to the left is as likely as one to the right: v_t u is 0 on average
        part = sp.expand(square).subs(normal**2, (1 - s.y**2) * s.v**2)
        part = part.subs(along**2, s.y**2 * s.v**2).subs(along, 0)
        mean = sp.expand(sp.integrate(part * impact_density(2), (s.y, -1, 1)))
        by = [mean.coeff(one, 2) * Avg(one**2) for one in (s.v, s.spin)]
        means.append(sum(sp.factor(one) for one in by))
    elastic = [mean.subs({s.e: 1, s.rolling: 1}) for mean in means]
    energy = sp.simplify(elastic[0] + s.inertia * elastic[1])
    zero(sp.expand(energy - Avg(s.v**2) - s.inertia * Avg(s.spin**2)), "energy is not kept")
    return result(
        sp.Tuple(eq(Avg(s.speed_after**2), means[0]), eq(Avg(s.spin_after**2), means[1])),
        "second route: at e = 1 and beta = 1, v^2 + k u^2 is kept",
        note="The spin changes neither the path nor the rate of collisions: second moments after N "
        "collisions are powers of a matrix of two rows. beta = -1 is a smooth disk.",
    )
