"""One collision with a tangential restitution, or with a mass; beyond the paper.

In the plane y is uniform on [-1, 1]; in space y^2 is uniform on [0, 1], so that s^2 is uniform
between e^2 and e_t^2: every average in space is an elementary integral over s.
"""

from __future__ import annotations

from functools import cache

import sympy as sp

from .. import symbols as s
from ..formal import Avg, Int, Partial, dot, eq
from ..premises import (
    collision_matrix,
    flux_per_angle,
    impact_density,
    mean_free_path,
    one_collision,
    over_impact,
    space_average,
    velocity_after,
)
from .any_dimension import cooling_rate
from .record import Derived, derives, result, row, zero


def _rule() -> sp.Eq:
    matrix = collision_matrix(s.et)
    normal = dot(s.bv, s.sigma) * s.sigma
    tangential = s.bv - normal
    v_after = matrix[1, 1] * tangential + matrix[0, 0] * normal
    return eq(s.bvp, sp.collect(sp.expand(v_after), normal))


# the collision rule with tangential restitution
row("beyond:rule", _rule)
# speed ratio s and deflection chi of one collision, in the plane and in space
row(
    "beyond:one-collision",
    lambda: (
        sp.Tuple(eq(s.s**2, one_collision()[0]), eq(s.s * sp.cos(s.chi), one_collision()[1])),
        ("v'/|v|, v along the last axis", sp.Tuple(*velocity_after())),
    ),
    note="But for a factor both depend on e/e_t alone: s(e, e_t) = e_t s(e/e_t, 1), and the "
    "deflection is that of the restitution e/e_t with e_t = 1.",
)
# impact parameter and mean free path in the plane
row(
    "beyond:measure-plane",
    lambda: sp.Tuple(eq(s.chance(s.y), impact_density(2)), eq(s.l, mean_free_path(2))),
    "collisions per angle: flux through the circle, over d rho0 |v|",
)
# impact parameter and mean free path in space
row(
    "beyond:measure-space",
    lambda: (
        sp.Tuple(
            eq(s.chance(s.y), impact_density(3)),
            eq(s.chance(s.y**2), impact_density(3) / sp.diff(s.y**2, s.y)),
            eq(s.l, mean_free_path(3)),
        ),
        ("collisions per angle: flux through the sphere, over d^2 rho0 |v|", flux_per_angle(3)),
    ),
    note="Here y runs from 0 to 1; the azimuth about v is uniform.",
)


@derives("beyond:plane-equal")
def _plane_equal() -> Derived:
    """The plane with e_t = e."""
    square, along = (component.subs(s.et, s.e) for component in one_collision())
    ratio = sp.sqrt(square)
    return result(
        sp.Tuple(
            eq(Avg(s.s**s.p), over_impact(ratio**s.p)),
            eq(s.klog, over_impact(-sp.log(ratio))),
            eq(s.cos_chi, over_impact(sp.cancel(along / ratio))),
        ),
        note="Every collision multiplies the speed by e and deflects as an elastic one.",
    )


@cache
def space_power() -> sp.Expr:
    """E[s^p] in space, in e and e_t."""
    return sp.powsimp(sp.factor(space_average(s.s**s.p)))


# mean power of the speed ratio in space
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
    without_logarithms = total.subs(dict.fromkeys(logarithms, 0))
    log_loss = sp.cancel(without_logarithms)
    for logarithm in logarithms:
        log_loss += sp.factor(total.coeff(logarithm)) * logarithm
    return log_loss


# mean log loss kappa in space; the second with e_t = 1
row(
    "beyond:space-log",
    lambda: sp.Tuple(eq(s.klog, space_log_loss()), eq(s.klog, space_log_loss().subs(s.et, 1))),
)


@cache
def space_cosine(lowest_ratio: sp.Expr = s.e) -> sp.Expr:
    """The mean cosine of the deflection in space, in e and e_t; ``lowest_ratio`` is |e|."""
    _, along = one_collision()
    return sp.factor(space_average(along / s.s, lowest_ratio))


# mean cosine of the deflection in space
row(
    "beyond:space-cosine",
    lambda: eq(s.cos_chi, space_cosine()),
    note="Zero for elastic spheres, which scatter isotropically; 2/3 at e = 0.",
)


@derives("beyond:space-isotropic")
def _space_isotropic() -> Derived:
    """In space with e_t = e (elastic spheres) the scattering is isotropic."""
    square, along = (component.subs(s.et, s.e) for component in one_collision())
    cosine = sp.cancel(along / sp.sqrt(square))  # from -1 at y = 0 to 1 at y = 1
    density = sp.cancel(impact_density(3) / sp.diff(cosine, s.y))
    equations = [eq(s.chance(sp.cos(s.chi)), density)]
    for order in (1, 2, 3, 4):
        mode = sp.legendre(order, sp.cos(s.chi))
        mean = over_impact(mode.subs(sp.cos(s.chi), cosine), 3)
        equations.append(eq(Avg(mode), mean))
    return result(
        sp.Tuple(*equations),
        ("cos(chi) with e_t = e", cosine),
        note="Uniform on [-1, 1] means that every Legendre polynomial of order 1 and more averages "
        "to zero. It holds for every e_t = e, at e = 1 for elastic spheres.",
    )


@cache
def space_cooling_rate() -> sp.Expr:
    """h(e) of smooth spheres, e_t = 1."""
    loss_one = sp.factor(1 - space_power().subs(s.p, 1).subs(s.et, 1))
    return cooling_rate().subs({s.klog: space_log_loss().subs(s.et, 1), s.lam(1): loss_one})


# exact cooling rate of smooth spheres (e_t = 1)
row(
    "beyond:space-cooling",
    lambda: eq(s.h, space_cooling_rate()),
    note="With v0 the root mean square speed, as in the plane: dv0/dt = -h v0^2/(2 l).",
    numbers={
        "h at e = {e}": lambda e: space_cooling_rate().subs(s.e, sp.Rational(str(e))).evalf(20)
    },
    restitutions=(0.4, 0.7, 0.9),
)


# -- the scaling solution at e = 0, where s = |y| -------------------------------------------------


def _loss_at_e_zero(dimension: int) -> sp.Expr:
    """lambda(p) of smooth scatterers at e = 0."""
    density = impact_density(dimension)
    if dimension == 2:
        density = 2 * density  # of |y|: both signs of y
    return sp.factor(1 - sp.integrate(s.y**s.p * density, (s.y, 0, 1)))


def _shell(dimension: int) -> sp.Expr:
    return 2 * (dimension - 1) * sp.pi * s.c ** (dimension - 1)


@cache
def e_zero_solution(dimension: int) -> sp.Expr:
    """F(c) of smooth scatterers at e = 0.

    E[Y^(p+1)]/E[Y^p] = p/lambda(p) (beyond:moments) is p + 1 in the plane and p + 2 in space: Y has
    the density y^(k-1) exp(-y), k = 1 and 2, over its integral.
    """
    shape = sp.cancel(s.p / _loss_at_e_zero(dimension)) - s.p
    density = s.x ** (shape - 1) * sp.exp(-s.x) / sp.gamma(shape)
    scale = sp.sqrt(shape * (shape + 1))  # c = Y/sqrt(E[Y^2])
    return scale * density.subs(s.x, scale * s.c) / _shell(dimension)


@cache
def _speed_moment(order: int, dimension: int) -> sp.Expr:
    """<c^order> of that."""
    weight = _shell(dimension) * s.c**order
    return sp.integrate(weight * e_zero_solution(dimension), (s.c, 0, sp.oo))


def _rate_at_e_zero(dimension: int) -> sp.Expr:
    """h = lambda(2) <c^3>."""
    return _loss_at_e_zero(dimension).subs(s.p, 2) * _speed_moment(3, dimension)


# the scaling solution at e = 0
row(
    "beyond:e-zero",
    lambda: sp.Tuple(eq(s.F(s.bc), e_zero_solution(2)), eq(s.M2 / 2, _rate_at_e_zero(2))),
    "Y is exponential; h = lambda(2) <c^3>",
)
# the scaling solution of smooth spheres at e = 0
row(
    "beyond:space-e-zero",
    lambda: sp.Tuple(
        eq(s.lam(s.p), _loss_at_e_zero(3)),
        eq(s.F(s.bc), e_zero_solution(3)),
        eq(Int(s.F(s.bc), s.bc), _speed_moment(0, 3)),
        eq(Avg(s.c**2), _speed_moment(2, 3)),
        eq(s.h, _rate_at_e_zero(3)),
    ),
    "Y has the density y exp(-y); h = lambda(2) <c^3>",
    numbers={"h at e = 0": lambda: _rate_at_e_zero(3)},
)


@derives("beyond:spin-moments")
def _spin_moments() -> Derived:
    """Disks that spin: <v^2> and <u^2> after a collision, u that of the rim."""
    # the impulse on the rim, over m, adds to v_t, and 1/k of it to u; v_t + u becomes -beta of it
    v_n, v_t, impulse = sp.symbols("v_n v_t J", real=True)
    rim = v_t + s.spin
    rim_after = rim + impulse * (1 + 1 / s.inertia)
    (impulse,) = sp.solve(rim_after + s.rolling * rim, impulse)

    def mean(square: sp.Expr) -> sp.Expr:
        # an impact to the left is as likely as one to the right: v_t u is 0 on average
        in_y = sp.expand(square).subs(v_n**2, (1 - s.y**2) * s.v**2)
        in_y = in_y.subs(v_t**2, s.y**2 * s.v**2).subs(v_t, 0)
        average = sp.expand(over_impact(in_y))
        of_speed = sp.factor(average.coeff(s.v, 2)) * Avg(s.v**2)
        of_spin = sp.factor(average.coeff(s.spin, 2)) * Avg(s.spin**2)
        return of_speed + of_spin

    speed_square = mean((s.e * v_n) ** 2 + (v_t + impulse) ** 2)
    spin_square = mean((s.spin + impulse / s.inertia) ** 2)
    energy_after = (speed_square + s.inertia * spin_square).subs({s.e: 1, s.rolling: 1})
    zero(energy_after - Avg(s.v**2) - s.inertia * Avg(s.spin**2), "energy is not kept")
    return result(
        sp.Tuple(eq(Avg(s.speed_after**2), speed_square), eq(Avg(s.spin_after**2), spin_square)),
        "second route: at e = 1 and beta = 1, v^2 + k u^2 is kept",
        note="The spin changes neither the path nor the rate of collisions: second moments after N "
        "collisions are powers of a matrix of two rows. beta = -1 is a smooth disk.",
    )


# -- scatterers at rest that a collision sets in motion --------------------------------------------
#
# A tracer of mass m strikes a smooth one of mass M = A m. Its own velocity changes as by a bounce
# off a fixed scatterer of another restitution e*, which may be negative: every average over a
# collision is the one known, with e* for e. In space and without loss (alpha = 1) these are the
# figures of neutrons that slow down.


@cache
def effective_restitution() -> sp.Expr:
    """e* in alpha and A, from the momentum and the relative velocity along the normal."""
    v_n, v_n_after, scatterer_after = sp.symbols("v_n w_n V_n", real=True)
    momentum = v_n - v_n_after - s.masses * scatterer_after  # over m; the scatterer was at rest
    relative_velocity = v_n_after - scatterer_after + s.relative * v_n
    unknowns = [v_n_after, scatterer_after]
    (velocities,) = sp.solve([momentum, relative_velocity], unknowns, dict=True)
    return sp.factor(-velocities[v_n_after] / v_n)


# the restitution of a fixed scatterer that has the effect of a mass A m
row(
    "beyond:mass-map",
    lambda: eq(s.effective, sp.factor(1 + effective_restitution()) - 1),
    "m v_n = m v'_n + M V'_n and v'_n - V'_n = -alpha v_n give v'_n = -e* v_n",
    note="e* lies between -1 and 1: alpha for A -> oo, 0 at A = 1/alpha, and below 0 for "
    "lighter scatterers, behind which the tracer goes on. The tangential part is kept.",
)


@cache
def mean_lethargy() -> sp.Expr:
    """xi = E[-ln s^2] of smooth spheres, in the least share a = e*^2 of the energy that is left."""
    return 2 * space_log_loss().subs({s.et: 1, s.e: sp.sqrt(s.least_share)})


@cache
def least_share() -> sp.Expr:
    """a in A, with alpha = 1."""
    return sp.factor(effective_restitution().subs(s.relative, 1) ** 2)


@derives("beyond:mass-log-loss")
def _log_loss() -> Derived:
    """Mean log loss in space, alpha = 1: neutrons' xi, and its a."""
    xi = mean_lethargy()
    equal = sp.limit(xi, s.least_share, 0)
    return result(
        sp.Tuple(eq(2 * s.klog, xi), eq(s.least_share, least_share())),
        note=f"xi = 2 kappa of neutron physics: {equal} at A = 1, 2/A + ... for heavy scatterers.",
        numbers={
            f"xi at A = {a}": xi.subs(s.least_share, least_share().subs(s.masses, a))
            for a in (2, 12)
        }
        | {"xi at A = 1": equal},
    )


@cache
def mean_cosine(heavier: bool) -> sp.Expr:
    """E[cos(chi)] in A with alpha = 1, for scatterers heavier than the tracer, or lighter."""
    lowest_ratio = s.e if heavier else -s.e
    cosine = space_cosine(lowest_ratio).subs(s.et, 1)
    restitution = effective_restitution().subs(s.relative, 1)
    return sp.expand(sp.cancel(cosine.subs(s.e, restitution)))


# mean cosine in space, alpha = 1: A >= 1, and A <= 1
row(
    "beyond:mass-cosine",
    lambda: sp.Tuple(eq(s.cos_chi, mean_cosine(True)), eq(s.cos_chi, mean_cosine(False))),
    "s runs from |e*| to 1, and e* changes its sign at A = 1: A >= 1, then A <= 1",
    note="The angle of the tracer in the laboratory. 2/(3 A) holds for A >= 1 only: at A = 1 "
    "both are 2/3, and light scatterers leave the direction, cos(chi) -> 1, as A -> 0.",
)


@derives("beyond:mass-age")
def _age() -> Derived:
    """The displacement in the mean log loss xi of the energy: Fermi's age."""
    slope = 2 / (s.klog * (1 - s.cos_chi))  # beyond:any-slope, over l^2
    in_lethargy = sp.cancel(slope.subs(s.klog, s.lethargy / 2))

    def of_mass(mass: int) -> sp.Expr:
        xi = sp.limit(mean_lethargy(), s.least_share, least_share().subs(s.masses, mass))
        cosine = mean_cosine(True).subs(s.masses, mass)
        return in_lethargy.subs({s.lethargy: xi, s.cos_chi: cosine}).evalf(20)

    return result(
        eq(Partial(s.msd(s.t), sp.log(s.t)) / s.l**2, in_lethargy),
        note="Per lethargy ln(E_0/E), which is 2 ln t, it is half as large; a sixth of that is "
        "Fermi's age, l^2/(3 xi (1 - <cos chi>)).",
        numbers={f"slope at A = {mass}": of_mass(mass) for mass in (1, 2, 12, 238)},
    )
