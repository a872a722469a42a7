"""Tracers in a bath, in noise with a drag, and tracers that stick; beyond the paper.

Lengths in l. A bath: the velocities V of the scatterers are Gaussian, w_V in each component. Only
the part q of v - V along the normal counts: a collision takes (1 + e*) q from the tracer's velocity
along it, e* being the restitution of ``any_law``.
"""

from __future__ import annotations

from functools import cache

import sympy as sp

from .. import symbols as s
from ..formal import Avg, Partial, eq
from ..premises import impact_density, over_impact
from .any_law import effective_restitution
from .record import Derived, derives, result

# -- a bath ---------------------------------------------------------------------------------------


@cache
def tracer_temperature() -> sp.Expr:
    """tau^2 with which every collision and its reverse are equally frequent."""
    v, q = sp.symbols("v_n q", real=True)
    v_after = v - (1 + s.effective) * q
    scatterer = v - q
    reverse_scatterer = q + v_after  # its normal is turned round: q = V - v' again
    of_tracer = (v**2 - v_after**2) / s.hot**2
    of_scatterer = (scatterer**2 - reverse_scatterer**2) / s.bath**2
    coefficients = sp.Poly(sp.expand(of_tracer + of_scatterer), v, q).coeffs()
    conditions = [coefficient for coefficient in coefficients if coefficient.has(s.hot)]
    (temperature,) = {sp.factor(sp.solve(condition, s.hot**2)[0]) for condition in conditions}
    return temperature


@derives("beyond:bath-temperature")
def _temperature() -> Derived:
    """Bath: the steady Maxwellian of the tracer, with its mass ratio if it were elastic."""
    # an elastic collision of the masses 1 and A takes 2 A/(1 + A) q from the tracer
    elastic = (1 + effective_restitution()).subs(s.relative, 1)
    (mass,) = sp.solve(elastic - 1 - s.effective, s.masses)
    ratio = sp.factor((tracer_temperature() / s.bath**2).subs(s.effective, effective_restitution()))
    return result(
        sp.Tuple(
            eq(s.hot**2, tracer_temperature()),
            eq(s.masses, sp.factor(mass)),
            eq(s.hot**2 / s.bath**2, ratio),
        ),
        "the rate q exp(-V_n^2/2 w^2), V_n = v_n - q, times exp(-v_n^2/2 tau^2) is that of the "
        "reverse, which has the same q",
        note="alpha and A give e*: the last formula, after Martin and Piasecki. Below e* = 1 the "
        "steady state is this Maxwellian, with any mass and inelasticity.",
    )


@cache
def cubed_relative_speed(dimension: int) -> sp.Expr:
    """<|g|^3> over the bath, g = v - V, in its rate nu and B = <|g| g.v>.

    |g|^3 = |g| g.(v - V), and V exp(-V^2/2 w^2) is -w^2 times a gradient: by parts it is the
    divergence of |g| g by V.
    """
    components = sp.symbols(f"g:{dimension}", real=True)
    length = sp.sqrt(sum(g_i**2 for g_i in components))
    divergence = -sum(sp.diff(length * g_i, g_i) for g_i in components)  # by V = v - g
    divergence_over_length = sp.simplify(divergence / length)
    return s.bath_pull(s.v) - s.bath**2 * divergence_over_length * s.bath_rate(s.v)


@cache
def bath_rates(dimension: int) -> tuple[sp.Expr, sp.Expr]:
    """L v over v, and L v^2, by collisions; with l = 1 at the rate |g|, g = v - V.

    The mean of (g.n) n over the normals of one collision is c g, and that of (g.n)^2 is c g^2.
    """
    share = over_impact(1 - s.y**2, dimension)  # c = E[cos^2 theta]
    kick = 1 + s.effective
    pull = s.bath_pull(s.v)
    along = kick * pull / s.v**2 * -share  # of <|g| g>, its component along v
    square = kick**2 * cubed_relative_speed(dimension) - 2 * kick * pull
    square_over_kick = sp.collect(sp.cancel(square / kick).expand(), pull)
    return along, kick * share * square_over_kick


@derives("beyond:bath-moments")
def _moments() -> Derived:
    """Bath: what collisions do to v and to v^2, in the plane, in space."""
    equations = []
    for dimension in (2, 3):
        along, square = bath_rates(dimension)
        equations += [eq(s.collided(s.bv), s.bv * along), eq(s.collided(s.v**2), square)]
    return result(
        sp.Tuple(*equations),
        "v' = v - (1 + e*) (g.n) n, v'^2 - v^2 = (1 + e*)^2 (g.n)^2 - 2 (1 + e*) (g.n) (v.n)",
        ("<|g|^3> by parts, in the plane", cubed_relative_speed(2)),
        note="In a field g these give two relations of the steady state: <L v_z> = -g and "
        "<L v^2> = -2 g u. They test the solver, which does not use them.",
    )


@derives("beyond:bath-from-rest")
def _from_rest() -> Derived:
    """Bath: growth of <v^2> of a tracer at rest, in the plane, in space."""
    equations = []
    for dimension in (2, 3):
        gaussian = sp.exp(-(s.v**2) / (2 * s.bath**2)) * s.v ** (dimension - 1)
        norm = sp.integrate(gaussian, (s.v, 0, sp.oo))
        mean_speed = sp.integrate(s.v * gaussian, (s.v, 0, sp.oo)) / norm
        at_rest = {s.bath_rate(s.v): sp.simplify(mean_speed), s.bath_pull(s.v): 0}
        _, square = bath_rates(dimension)
        equations.append(eq(s.collided(s.v**2), square.subs(at_rest)))
    return result(sp.Tuple(*equations), "v = 0: the rate is <|V|>, and B is 0")


@derives("beyond:bath-einstein")
def _einstein() -> Derived:
    """Bath: Einstein's relation of a weak field."""
    v_z = sp.Symbol("v_z", real=True)
    steady = sp.exp(-(v_z**2) / (2 * s.hot**2))
    # f = steady (1 + g phi): the field adds -d steady/dv_z, and the balance makes L (phi steady)
    # steady L phi: L phi = -driven, and phi is driven/v_z times H with L H = -v_z
    driven = sp.cancel(-sp.diff(steady, v_z) / steady)
    return result(
        eq(s.mobility, sp.cancel(driven / v_z) * s.diffusivity),
        ("the field on the Maxwellian, -d f/dv_z over f", driven),
        "detailed balance: the response is H/tau^2, L H = -v_z, and D = <v_z H>",
        note="For every e* below 1. White noise and fixed scatterers are not in detailed balance: "
        "there D/(mu tau^2) is not 1.",
    )


# -- noise and drag -------------------------------------------------------------------------------


@cache
def heated_moment() -> sp.Expr:
    """d<v^p>/dt, from the generator of noise and drag on v^p; its boundary at v = 0 vanishes."""
    power = s.v**s.p
    radial = sp.diff(power, s.v, 2) + (s.dim - 1) / s.v * sp.diff(power, s.v)
    spread = sp.factor(sp.simplify(radial / s.v ** (s.p - 2)))
    slowed = sp.simplify(s.v * sp.diff(power, s.v) / power)
    return (
        s.heat * spread * Avg(s.v ** (s.p - 2))
        - s.drag * slowed * Avg(power)
        - s.lam(s.p) * Avg(s.v ** (s.p + 1))
    )


@derives("beyond:heated-moments")
def _heated_moments() -> Derived:
    """Noise and drag: moments over time; steady ones in steps of three, and the energy."""
    steady = heated_moment().subs(s.drag, 0).subs(s.p, s.p + 2)
    lost = s.lam(s.p + 2) * Avg(s.v ** (s.p + 3))
    energy = heated_moment().subs(s.p, 2).subs(Avg(sp.Integer(1)), 1)
    energy_lost = s.lam(2) * Avg(s.v**3) + 2 * s.drag * Avg(s.v**2)
    return result(
        sp.Tuple(
            eq(Partial(Avg(s.v**s.p), s.t), heated_moment()),
            eq(lost, steady + lost),
            eq(energy_lost, energy + energy_lost),
        ),
        "the Laplacian of v^p is p (p + D - 2) v^(p-2)",
        note="<v^0> = 1 gives <v^3>, <v^6>, ... in closed form, in the plane and in space.",
    )


@cache
def plastic_equation(drag: int) -> tuple[sp.Expr, sp.Expr]:
    """(f, the kinetic equation at e = 0 and D_v = 1), of which f'' is the highest derivative.

    A tracer of speed u leaves with u |y|: the gain is (D - 1)/v times the integral of u f over
    u > v. Where f'' = v f - gamma (v f)', that integral is -(f' + gamma v f), and D drops out.
    """
    shape = sp.Function("unknown")(s.v)
    slope = sp.diff(shape, s.v)
    spread = sp.diff(slope, s.v) + (s.dim - 1) / s.v * slope
    gain = -(s.dim - 1) / s.v * (slope + drag * s.v * shape)
    slowed = drag * (s.dim * shape + s.v * slope)
    return shape, sp.expand(spread + slowed + gain - s.v * shape)


@derives("beyond:heated-e-zero")
def _plastic() -> Derived:
    """Noise and drag at e = 0, in the plane and in space: f over a factor, D_v = 1, without drag
    and at gamma_v = 1.
    """
    shape, equation = plastic_equation(0)
    decaying, growing = sp.symbols("C1 C2")  # the constants of sympy's general solution
    airy = sp.dsolve(equation, shape).rhs.subs({decaying: 1, growing: 0})

    shape, equation = plastic_equation(1)
    a, b = sp.symbols("a b", positive=True)
    gaussian = sp.exp(-b * s.v - s.v**2 / 2)
    ansatz = (s.v + a) * gaussian
    residual = equation.subs(shape, ansatz).doit()
    polynomial = sp.Poly(sp.cancel(sp.expand(residual / gaussian)), s.v)
    (constants,) = sp.solve(polynomial.coeffs(), (a, b), dict=True)
    return result(
        sp.Tuple(eq(s.f0(s.v), airy), eq(s.f0(s.v), ansatz.subs(constants))),
        "D_v f'' + gamma (v f)' = v f, in any dimension",
        note="With other drags f is a parabolic cylinder function.",
    )


# -- sticking -------------------------------------------------------------------------------------


@derives("beyond:stick-depth")
def _depth() -> Derived:
    """Rare sticking in a field: depth of capture, in the plane, in space."""
    ratio = sp.Symbol("ratio", positive=True)  # v_c/v
    sticks_above = sp.sqrt(1 - ratio**2)  # the |y| above which v_n = v sqrt(1 - y^2) is below v_c
    equations = []
    for dimension in (2, 3):
        lower_end = -sticks_above if dimension == 2 else 0
        chance = 1 - sp.integrate(impact_density(dimension), (s.y, lower_end, sticks_above))
        coefficient = sp.simplify(sp.series(chance, ratio, 0, 4).removeO() / ratio**2)
        capture_rate = coefficient * s.capture**2 * Avg(1 / s.v)
        equations.append(eq(s.depth, s.drift / capture_rate))
    return result(
        sp.Tuple(*equations),
        "captures per unit time: the mean of v times the chance, to the lowest order in v_c",
        note="Means and drift are those of the steady state without sticking.",
    )
