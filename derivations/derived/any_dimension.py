"""Moments of velocity and displacement in any dimension, and the chain of <r^4> in two and three.

They use of a collision only its averages E[s^p], kappa = E[-ln s] and E[s^p P_m(cos chi)]; in the
plane cos(m chi) stands for the Legendre polynomial P_m(cos chi). At the end a tracer that keeps its
speed and scatters isotropically, as elastic spheres do: with l = 1, zeta = v t and K = k l,
w = <exp(i k.r)> obeys dw/dzeta = i K cos w + <w> - w, with <w> the average over the direction of
the velocity, and cos that of its angle to k.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import sympy as sp
from sympy.core.function import UndefinedFunction

from .. import symbols as s
from ..formal import Avg, Partial, eq
from ..premises import free_path
from .record import Derived, derives, result, row


@derives("beyond:any-average")
def _any_average() -> Derived:
    """Moments of the speed in any dimension."""
    # E[(s v)^p] - v^p times the rate v/l: the mean free path is all that knows the dimension
    change = sp.powsimp(s.v / s.l * s.v**s.p * (s.s**s.p - 1)).subs(s.s**s.p, 1 - s.lam(s.p))
    factor = sp.cancel(change / s.v ** (s.p + 1))
    return result(
        eq(Partial(Avg(s.v**s.p), s.t), factor * Avg(s.v ** (s.p + 1))),
        "change of |v|^p per unit time: rate v/l, and |v'| = s |v|",
        note="The rate of collisions is v/l with l = 1/(2 d rho0) in the plane and 1/(pi d^2 rho0) "
        "in space. The directions drop out: no isotropy is needed.",
    )


@cache
def following_moment() -> sp.Expr:
    """<c^(p+1)> of the scaling solution from <c^p>: -lambda(p) <c^(p+1)> = (h/2)(-p) <c^p>.

    -p is the moment of D F + c F' in D dimensions, over <c^p>: by parts.
    """
    shape = sp.Function("F")(s.c)
    weight = s.c ** (s.p + s.dim - 1)  # c^p in the volume element
    boundary_term = sp.diff(weight * s.c * shape, s.c)
    weighted = s.dim * shape * weight + s.c * sp.diff(shape, s.c) * weight
    by_parts = sp.simplify((weighted - boundary_term) / (weight * shape))  # -p
    return -s.h / 2 * by_parts * Avg(s.c**s.p) / s.lam(s.p)


@cache
def mean_scaled_speed() -> sp.Expr:
    """<c>, from p -> 0: p/lambda(p) -> 1/kappa, since d(1 - s^p)/dp = -ln s there; <c^0> = 1."""
    limit = following_moment() * s.lam(s.p) / s.p / s.klog
    return limit.subs(Avg(s.c**s.p), 1)


@cache
def cooling_rate() -> sp.Expr:
    """h in kappa and lambda(1), from <c^2> = 1."""
    second = following_moment().subs(s.p, 1).subs(Avg(s.c), mean_scaled_speed())
    (rate,) = sp.solve(second - 1, s.h)
    return rate


# scaled moments and cooling rate in any dimension
row(
    "beyond:any-moments",
    lambda: sp.Tuple(
        eq(Avg(s.c), mean_scaled_speed()),
        eq(Avg(s.c ** (s.p + 1)), following_moment()),
        eq(s.h, cooling_rate()),
    ),
    "f(v, t) = F(v/v0)/v0^D with dv0/dt = -h v0^2/(2 l): df/dt is (h/2)(D F + c F')",
    note="In any dimension, with v0 the root mean square speed.",
)


@derives("beyond:any-slope")
def _any_slope() -> Derived:
    """Displacement after N collisions and over time, in any dimension."""
    # the displacement r of N flights, and u the next direction. With r' = r + L u: <r'^2> = <r^2> +
    # 2 <L> <r.u> + <L^2> and <r'.u'> = c (<r.u> + <L>), since E[u'] = c u
    c = s.cos_chi
    a, b, g = sp.symbols("a b g")
    mean_path = free_path(1) * s.l  # free_path(n) = <L^n>/l^n = n!
    mean_square_path = free_path(2) * s.l**2
    power = sp.Symbol("power")  # c^N

    # <r.u> after N collisions, which starts from 0
    along = a * (1 - power)
    balance = along.subs(power, c * power) - c * (along + mean_path)
    along = along.subs(sp.solve(sp.Poly(balance, power).coeffs(), a))

    # <r^2> after N collisions, which starts from 0
    square = b * s.N + g * (1 - power)
    growth = b + g * power * (1 - c)
    balance = growth - 2 * mean_path * along - mean_square_path
    constants = sp.solve(sp.Poly(sp.expand(balance), power).coeffs(), (b, g))
    after_collisions = square.subs(constants).subs(power, c**s.N)

    # dN/d ln t = t <v>/l = t v0 <c>/l, with v0 = 2 l/(h t) from dv0/dt = -h v0^2/(2 l)
    flights_per_log_time = 2 / s.h * mean_scaled_speed()
    per_flight = sp.limit(after_collisions.subs(s.cos_chi**s.N, 0) / s.N, s.N, sp.oo)
    slope = sp.simplify(per_flight * flights_per_log_time)
    return result(
        sp.Tuple(
            eq(s.msdN(s.N), after_collisions),
            eq(Partial(s.msd(s.t), sp.log(s.t)), slope),
        ),
        "one flight more: <r'^2> = <r^2> + 2 <L> <r.u> + <L^2>, <r'.u'> = c (<r.u> + <L>)",
        note="Only E[u'] = <cos chi> u is used, which holds in any dimension by symmetry about u. "
        "Free paths are exponential with mean l whatever the speed.",
    )


@derives("beyond:collision-number")
def _collision_number() -> Derived:
    """Variances of collisions and path, per ln t at late times."""
    # E[z^N v^p] ~ t^(theta-p) in d/dt E[z^N v^p] = -(1 - z phi(p)) E[z^N v^(p+1)]/l, where
    # phi(p) = E[s^p]: at p = theta the left side is 0, and so 1 - z phi(theta) = 0
    u, theta_1, theta_2 = sp.symbols("u theta_1 theta_2")
    theta = theta_1 * u + theta_2 * u**2 / 2
    square = Avg(sp.log(s.s) ** 2)
    phi = 1 - s.klog * theta + square * theta**2 / 2

    def variance(z: sp.Expr) -> sp.Expr:
        condition = sp.series(1 - z * phi, u, 0, 3).removeO().expand()
        (mean,) = sp.solve(condition.coeff(u, 1), theta_1)
        (second_cumulant,) = sp.solve(condition.coeff(u, 2).subs(theta_1, mean), theta_2)
        return sp.factor(second_cumulant)

    of_collisions = variance(sp.exp(u))  # z = exp(u) counts collisions
    of_path = variance(1 / (1 - u))  # E[exp(u X/l)] over a flight
    return result(
        sp.Tuple(eq(s.VarN, of_collisions), eq(s.VarX, s.l**2 * of_path)),
        ("phi(theta) = E[s^theta], up to the second order", phi),
        note="E[exp(u N)] grows as t^theta(u), phi(theta) = exp(-u), and E[exp(u X/l)] with "
        "phi(theta) = 1 - u: derivatives of theta at u = 0 are the cumulants per ln t.",
    )


# -- the chain of <r^4> ---------------------------------------------------------------------------

#: The cosine of the angle between the velocity and a fixed direction.
COSINE = sp.Symbol("cosine", real=True)


class Member(NamedTuple):
    """A function of the chain: a coefficient of the expansion of <exp(i k.r)> at one velocity."""

    order: int  # of the power of k
    m: int  # of the harmonic in the angle between the velocity and k


#: The order 0 of <exp(i k.r)>, which is 1: it drives the chain.
_ONE = Member(order=0, m=0)
#: The member that is chi_1(zeta) = <r.u>/l, u the direction at the start.
_CHI1 = Member(order=1, m=1)
#: The member that is rho_2(zeta), <r^2>/l^2 of tracers that start with one speed.
_RHO2 = Member(order=2, m=0)
#: The member that is S_2(zeta): <x^2 - y^2>/(8 l^2) in the plane, <x^2 - y^2>/(3 l^2) in space, x
#: along the direction at the start and y across.
_S2 = Member(order=2, m=2)
#: The member that is W_1(zeta), which drives rho_4: -<x r^2>/(16 l^3) in the plane and
#: <x r^2>/(10 l^3) in space, x along the direction at the start.
_W1 = Member(order=3, m=1)
#: The member that is rho_4(zeta), <r^4>/l^4 of tracers that start with one speed.
_RHO4 = Member(order=4, m=0)
#: The functions of the chain, each after those that drive it.
MEMBERS: dict[Member, UndefinedFunction] = {
    _CHI1: s.chi1,
    _RHO2: s.rho2,
    _S2: s.S2,
    _W1: s.W1,
    _RHO4: s.rho4,
}


@cache
def harmonic(m: int, dimension: int) -> sp.Expr:
    """cos(m angle) in the plane, P_m in space: a polynomial in `COSINE`."""
    if dimension == 2:
        return sp.chebyshevt(m, COSINE)
    return sp.legendre(m, COSINE)


def over_directions(weight: sp.Expr, dimension: int) -> sp.Expr:
    """The average over all directions of the velocity of a polynomial in `COSINE`."""
    if dimension == 2:
        in_angle = sp.expand(weight).subs(COSINE, sp.cos(s.theta))
        return sp.integrate(sp.expand(in_angle), (s.theta, 0, sp.pi)) / sp.pi
    return sp.integrate(sp.expand(weight), (COSINE, -1, 1)) / 2


def share(weight: sp.Expr, m: int, dimension: int) -> sp.Expr:
    """The coefficient of harmonic m in a polynomial in `COSINE`."""
    target = harmonic(m, dimension)
    return over_directions(weight * target, dimension) / over_directions(target**2, dimension)


def kernel(m: int, dimension: int) -> sp.Expr:
    """The factor by which a deflection chi multiplies harmonic m: the addition theorem."""
    if dimension == 2:
        return sp.cos(m * s.chi)
    return sp.legendre(m, sp.cos(s.chi))


@cache
def scale(member: Member, dimension: int) -> sp.Expr:
    """The coefficient of a harmonic in <(k.r)^n>/n!, over the function of the chain that it is.

    <r^n> stands in the mean over directions: <(k.r)^n> = k^n <r^n> times the mean of cos^n. In
    the plane S_2 and W_1 are coefficients of i^m exp(i m phi), and i^n stands before <(k.r)^n>/n!;
    chi_1 = <r.u>/l is the coefficient of the cosine itself.
    """
    order, m = member
    if m == 0:
        return over_directions(COSINE**order, dimension) / sp.factorial(order)
    if member == _CHI1 or dimension == 3:
        return sp.Integer(1)
    return 2 * sp.Integer(-1) ** ((order - m) // 2)  # exp(i m phi) + exp(-i m phi)


@cache
def sources(dimension: int) -> dict[Member, dict[Member, sp.Expr]]:
    """For every member of the chain the members that drive it, each with its factor.

    In orders of i k, with l = 1 and zeta = v t: dw_n/dzeta = cos w_(n-1) + (collisions).
    """
    chain: dict[Member, dict[Member, sp.Expr]] = {}
    for member in MEMBERS:
        order, m = member
        chain[member] = {}
        for source in (_ONE, *MEMBERS):
            source_order, source_m = source
            if source_order != order - 1:
                continue
            factor = share(COSINE * harmonic(source_m, dimension), m, dimension)
            factor *= scale(source, dimension) / scale(member, dimension)
            if factor:
                chain[member][source] = factor
    return chain


def chain_equation(member: Member, dimension: int) -> sp.Eq:
    """The equation of one member of the chain.

    It is a backward equation, in zeta = v t/l of the speed v at the start: the first collision
    multiplies v, and so zeta, by s.
    """
    unknown = MEMBERS[member]
    _, m = member
    after_collision = Avg(kernel(m, dimension) * unknown(s.s * s.zeta))
    drive = sp.Integer(0)
    for source, factor in sources(dimension)[member].items():
        drive += factor * (1 if source == _ONE else MEMBERS[source](s.zeta))
    rate = after_collision - unknown(s.zeta) + drive
    return eq(sp.Derivative(unknown(s.zeta), s.zeta), rate)


@cache
def late_flatness(dimension: int) -> sp.Expr:
    """<r^4>/<r^2>^2 as t -> oo, e < 1, from the leading logarithms of the chain.

    In X = ln zeta a collision shifts X by ln s, and the derivatives by zeta fall as 1/zeta: chi_1
    and S_2 tend to constants, rho_2 grows as X, W_1 as X and rho_4 as X^2.
    """
    drive = sources(dimension)
    x = sp.Symbol("X")
    log_ratio = sp.Symbol("ln_s", real=True)  # its average is -kappa
    mean_cosine = kernel(1, dimension).subs(sp.cos(s.chi), s.cos_chi)  # E[cos(chi)]
    along = 1 / (1 - mean_cosine)

    def shift(power: int) -> sp.Expr:
        """The average of (X + ln s)^power - X^power, to the leading order in X."""
        change = sp.Poly(sp.expand((x + log_ratio) ** power - x**power), x)
        monomial, coefficient = change.LT()
        return (coefficient * monomial.as_expr()).subs(log_ratio, -s.klog)

    square = -drive[_RHO2][_CHI1] * along / shift(1)  # rho_2 over X
    third_order = drive[_W1][_RHO2] * square * x / (1 - mean_cosine)  # W_1
    fourth_power = -drive[_RHO4][_W1] * third_order / shift(2)  # rho_4 over X^2
    return sp.cancel(fourth_power / square**2)


def _quartic(dimension: int) -> sp.Tuple:
    equations = [chain_equation(member, dimension) for member in MEMBERS]
    return sp.Tuple(*equations, eq(s.flatness, late_flatness(dimension)))


# the chain of <r^4> in the plane, harmonics i^m exp(i m phi)
row("beyond:quartic-plane", lambda: _quartic(2))
# the chain of <r^4> in space, Legendre polynomials
row("beyond:quartic-space", lambda: _quartic(3))


@cache
def elastic_transform(dimension: int) -> sp.Expr:
    """The Laplace transform of <r^4> in zeta at one speed, for elastic smooth bounces (s = 1)."""
    rates = {0: sp.Integer(0), 1: s.nu1, 2: s.nu2}
    transforms: dict[Member, sp.Expr] = {_ONE: 1 / s.laplace}
    for member, drive in sources(dimension).items():
        _, m = member
        total = sum(factor * transforms[source] for source, factor in drive.items())
        transforms[member] = total / (s.laplace + rates[m])
    return sp.factor(transforms[_RHO4])


# elastic <r^4> as a Laplace transform: in the plane, in space
row(
    "beyond:quartic-elastic",
    lambda: sp.Tuple(*(eq(s.rho4z(s.laplace), elastic_transform(d)) for d in (2, 3))),
    "the chain with s = 1, E[P_m(cos(chi))] - 1 = -nu_m",
    note="By partial fractions it is <r^4>(t) at each speed. nu_1 = 4/3, nu_2 = 16/15 for disks, "
    "nu_1 = nu_2 = 1 for spheres.",
)


@cache
def transform(dimension: int) -> sp.Expr:
    """<w> in Laplace space: (z + 1 - i K cos) w = 1 + <w>, averaged over directions.

    The odd part of 1/(1 + z - i K cos), the first flight, has no average.
    """
    decay, tangent, a = sp.symbols("decay tangent a", positive=True)  # decay = 1 + z
    if dimension == 3:  # the cosine is uniform
        flight = sp.integrate(decay / (decay**2 + s.wave**2 * COSINE**2), (COSINE, 0, 1))
    else:  # a quarter of the circle with the tangent as variable: cos^2 = 1/(1 + tan^2)
        quarter = sp.integrate(decay / (a + decay**2 * tangent**2), (tangent, 0, sp.oo))
        flight = quarter.subs(a, decay**2 + s.wave**2) / (sp.pi / 2)
    return (flight / (1 - flight)).subs(decay, 1 + s.laplace)


# isotropic scattering at one speed in space
row(
    "beyond:isotropic-space",
    lambda: eq(s.Fhat(s.wave, s.laplace), transform(3)),
    "w = <exp(i k.r)>: dw/dzeta = i K cos w + <w> - w, K = k l, zeta = v t/l",
    note="Elastic spheres scatter isotropically (beyond:space-isotropic).",
)


@derives("beyond:isotropic-plane")
def _plane() -> Derived:
    """Isotropic scattering at one speed in the plane, and its density of position.

    g(r, zeta) is the density of the distance r, per unit r: its integral over r is 1.
    """
    height = sp.sqrt(s.zeta**2 - s.r**2)  # the w whose ring has the radius r
    spread = -sp.diff(height, s.r) * sp.exp(height - s.zeta)
    return result(
        sp.Tuple(
            eq(s.Fhat(s.wave, s.laplace), sp.simplify(transform(2))),
            eq(s.g(s.r, s.zeta), sp.exp(-s.zeta) * s.delta(s.r - s.zeta) + spread),
        ),
        "1/(Q - 1) = 1/Q + the integral over w > 0 of exp(w) exp(-w Q)/Q",
        "exp(-w Q)/Q is exp(-zeta) on a ring of radius sqrt(zeta^2 - w^2)",
        note="Paasschens' closed form; the second term for r < zeta, with r in units of l. "
        "Isotropic scattering in the plane is not that of disks, whose mean cosine is -1/3.",
    )
