"""Chapman-Enskog expansion in the density gradient, order by order: (24) to (46).

The expansion is made with the formal parameter epsilon; the collision operator enters only as a
linear operator, the gradient as a symbol that commutes with functions of the velocity.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import sympy as sp

from .. import symbols as s
from ..formal import Dot, Dt, Int, Lam, Partial, dot, eq
from ..premises import isotropy
from .kinetic_equation import mass_change
from .record import Derived, Verdict, defines, derives, result, row

_T = s.T(s.t)
_D = s.De(s.t)
_F = s.f(s.bv, s.t)

_N = s.nd(s.br, s.t)
_P0 = s.p0(s.br, s.bv, s.t)
_P1 = s.p1(s.br, s.bv, s.t)
_P2 = s.p2(s.br, s.bv, s.t)
_B = s.Bv(s.bv, _T)


# (26): continuity
row("diffuse2", lambda: eq(sp.Derivative(_N, s.t) + dot(s.nabla, s.J(s.br, s.t)), mass_change()))
defines(
    {
        "diffuse3": "The zeroth moment in velocity.",
        "diffuse4": "The first moment in velocity.",
        "diffuse9": "The power of epsilon counts the gradients.",
        "diffuse17": "The diffusion coefficient as an integral of B.",
        "diffuse19": "The relaxation rate of the flux; it depends on the shape of B.",
    }
)
# (29): expansion of the distribution
row(
    "diffuse5",
    note="A formal series; that it orders the distribution holds for gradients that are small over "
    "the distance which a tracer covers while its speed falls by a fixed factor.",
    verdict=Verdict.HOLDS,
)


@cache
def _flux_orders() -> dict[int, sp.Expr]:
    """Orders of -div J with both the gradient and the flux expanded."""
    divergence = sp.Integer(0)
    for order in range(3):
        flux = sp.Function(f"J_vec_{order}")(s.br, s.t)
        divergence += s.eps ** (order + 1) * dot(s.nabla0, flux)
        divergence += s.eps ** (order + 2) * dot(s.nabla1, flux)
    divergence = sp.expand(divergence)
    return {order: -divergence.coeff(s.eps, order + 1) for order in range(3)}


def density_series(density: sp.Expr) -> sp.Expr:
    """The time derivative of a density in orders of epsilon, from the lowest that -div J has."""
    lowest = min(order + 1 for order, term in _flux_orders().items() if term != 0)
    return sp.Sum(s.eps ** (s.j + lowest) * Dt(s.j, density), (s.j, 0, sp.oo))


# (30): expansion of the time derivative of the density
row(
    "diffuse6",
    lambda: eq(sp.Derivative(_N, s.t), density_series(_N)),
    note="Each order of the gradient carries at least one factor of epsilon.",
)


def continuity_order(flux: sp.Expr, density: sp.Expr) -> Derived:
    """Order j of continuity: with the gradient expanded, lower fluxes meet its higher orders."""
    index = sp.Symbol("i", integer=True, nonnegative=True)
    gradient = sp.Function("nabla")(index)
    lower = sp.Function("J_vec")(s.j - index, *flux.args)
    general = -sp.Sum(dot(gradient, lower), (index, 0, s.j))
    return result(
        eq(Dt(s.j, density), general),
        ("order epsilon", eq(Dt(0, density), _flux_orders()[0])),
        ("order epsilon^2", eq(Dt(1, density), _flux_orders()[1])),
        note="With the gradient expanded as in diffuse9, order j also holds the flux of order j - "
        "i under the gradient of order i. The printed form drops these. At the orders that the "
        "paper uses nothing changes, since the flux of order 0 vanishes; from order 2 on it does.",
        numbers={"change of the diffusion equation (order 1)": 0.0},
    )


@derives("diffuse7")
def _continuity_order_by_order() -> Derived:
    """(31): orders of the time derivative of the density."""
    return continuity_order(s.Jj(s.br, s.t), _N)


@derives("diffuse8")
def _flux_of_order_j() -> Derived:
    """(32): flux of order j."""
    distributions = (_P0, _P1, _P2)
    series = sum(s.eps**order * p_j for order, p_j in enumerate(distributions))
    integrand = sp.expand(s.bv * series)
    # each order of v p over the same order of p
    (weight,) = {
        sp.cancel(integrand.coeff(s.eps, order) / p_j) for order, p_j in enumerate(distributions)
    }
    return result(eq(s.Jj(s.br, s.t), Int(weight * s.pj(s.br, s.bv, s.t), s.bv)))


@cache
def orders(density: sp.Expr = _N) -> tuple[sp.Eq, sp.Eq]:
    """Orders 0 and 1 of the kinetic equation; p^(j) depends on time through the density and T."""
    change = s.eps * Dt(0, density) + s.eps**2 * Dt(1, density)
    cooling = sp.Derivative(_T, s.t)
    # the gradient acts through the density, and on p^(0) alone at this order
    transport = s.eps * dot(s.bv, s.nabla0) * density * Partial(_P0, density)
    collisions = sp.Integer(0)
    for order, p_j in enumerate((_P0, _P1)):
        rate = change * Partial(p_j, density) + cooling * Partial(p_j, _T)
        transport += s.eps**order * rate
        collisions += s.eps**order * Lam(p_j)
    transport = sp.expand(transport)
    collisions = sp.expand(collisions)
    order_0 = eq(transport.coeff(s.eps, 0), collisions.coeff(s.eps, 0))
    order_1 = eq(transport.coeff(s.eps, 1), collisions.coeff(s.eps, 1))
    return order_0, order_1


# (34): zeroth order
row("diffuse10", lambda: orders()[0], "order epsilon^0 of the kinetic equation")


@derives("diffuse11")
def _zeroth_order() -> Derived:
    """(35): solution of the zeroth order."""
    amplitude = sp.Symbol("A")
    # the integral of A f over v is n(r, t), that of f is n
    (solution,) = sp.solve(amplitude * s.n - _N, amplitude)
    return result(eq(_P0, solution * _F))


# (36): first order
row("diffuse12", lambda: orders()[1], "order epsilon^1 of the kinetic equation")


class Expansion(NamedTuple):
    """The first order, the equation for B and that for the diffusion coefficient."""

    first_order: sp.Eq
    of_b: sp.Eq
    of_coefficient: sp.Eq


def expand(
    density: sp.Expr, slope: sp.Expr, cooling: sp.Expr, coefficient: sp.Expr, source: sp.Expr
) -> Expansion:
    """The expansion for one density and its diffusion coefficient.

    ``slope`` is dp^(0)/d(density), ``cooling`` is dT/dt; ``source``, the integral of v.v f, stands
    for v f on the right.
    """
    first_order = _insert_zeroth_order(density, slope, cooling)
    of_b = _divide_by_gradient(first_order, density)
    of_coefficient = _integrate_over_velocity(of_b, coefficient, source)
    return Expansion(first_order, of_b, of_coefficient)


def _insert_zeroth_order(density: sp.Expr, slope: sp.Expr, cooling: sp.Expr) -> sp.Eq:
    """The first order with p^(0) and the cooling inserted; what drives it stands on the right."""
    _, order_1 = orders(density)
    # the flux of order 0 vanishes: f is even
    inserted = {Dt(0, density): 0, sp.Derivative(_T, s.t): cooling, Partial(_P0, density): slope}
    residual = (order_1.lhs - order_1.rhs).subs(inserted)
    driven = residual.subs({Lam(_P1): 0, Partial(_P1, _T): 0})
    return eq(sp.expand(driven - residual), driven)


def _divide_by_gradient(first_order: sp.Eq, density: sp.Expr) -> sp.Eq:
    """The equation for B: p^(1) = B.grad n inserted, the gradient, which is any, divided out."""
    inserted = {
        Lam(_P1): dot(Lam(_B), s.nabla0) * density,
        Partial(_P1, _T): dot(Partial(_B, _T), s.nabla0) * density,
    }
    lhs, rhs = (sp.expand(side.subs(inserted) / density) for side in first_order.args)
    return eq(lhs.replace(Dot, _without_gradient), rhs.replace(Dot, _without_gradient))


def _integrate_over_velocity(of_b: sp.Eq, coefficient: sp.Expr, source: sp.Expr) -> sp.Eq:
    """The equation for B times -v/2, integrated over v, with D_e and nu_D named."""
    half = -sp.Rational(1, 2)
    named = {
        Partial(_B, _T): Partial(coefficient, _T) / half,
        Lam(_B): -s.nuD * coefficient / half,
        s.bv * _F: source,
    }
    lhs, rhs = (sp.expand(half * side).subs(named) for side in of_b.args)
    return eq(sp.expand(lhs), rhs)


def _without_gradient(vector: sp.Expr, factor: sp.Expr) -> sp.Expr:
    """The vector in a scalar product with the gradient."""
    if vector == s.nabla0:
        return factor
    return vector


@cache
def _expansion() -> Expansion:
    """(37), (39) and (42); the integral of v.v f is n <v^2> = n v0^2 = 2 n T/m."""
    return expand(_N, _F / s.n, -s.xi(s.t) * _T, _D, s.n * 2 * _T / s.m)


# (37): first order with the zeroth inserted
row(
    "diffuse13",
    lambda: (
        _expansion().first_order,
        ("flux of order 0: v f is odd", eq(s.J0(s.br, s.t), sp.Integer(0))),
        ("cooling", eq(sp.Derivative(_T, s.t), -s.xi(s.t) * _T)),
    ),
)
# (38): form of the first-order solution
row(
    "diffuse14",
    note="Holds: the equation is linear with a source proportional to the gradient of n, and the "
    "operator commutes with rotations.",
    verdict=Verdict.HOLDS,
)
# (39): equation for B
row("diffuse15", lambda: _expansion().of_b, "p^(1) = B.grad n inserted, the gradient divided out")


@derives("diffuse16")
def _first_order_flux() -> Derived:
    """(40): first-order flux."""
    integral = Int(dot(s.bv, _B), s.bv)
    flux = isotropy() * integral * s.nabla0 * _N
    coefficient = flux.subs(integral, _D / (-sp.Rational(1, 2)))
    return result(eq(s.J1(s.br, s.t), coefficient))


# (42): equation for the diffusion coefficient
row(
    "diffuse18",
    lambda: _expansion().of_coefficient,
    "the equation for B",
    note="The paper cites diffuse17 where it means diffuse15.",
)


@cache
def thermal_speed() -> sp.Expr:
    """v0 as a function of the temperature, from T = m v0^2/2."""
    speed = sp.Symbol("speed", positive=True)
    (root,) = sp.solve(sp.Eq(_T, s.m * speed**2 / 2), speed)
    return root


@cache
def temperature_exponent() -> sp.Expr:
    """q in D_e ~ T^q: D_e is a number times l v0, the only length and speed at hand."""
    heat = sp.Symbol("heat", positive=True)
    speed = thermal_speed().subs(_T, heat)
    return sp.simplify(heat * sp.diff(speed, heat) / speed)


# (44): temperature dependence of the diffusion coefficient
row(
    "diffuse20",
    lambda: eq(Partial(_D, _T), temperature_exponent() * _D / _T),
    "D_e = number l v0: exponent of T",
    note="Exact in the scaling state, where D_e/(l v0) is a number.",
)


def solved(equation: sp.Eq, coefficient: sp.Expr, exponent: sp.Expr) -> sp.Expr:
    """The diffusion coefficient where it goes as this power of T."""
    unknown = sp.Symbol("D", positive=True)
    inserted = {Partial(coefficient, _T): exponent * unknown / _T, coefficient: unknown}
    (solution,) = sp.solve((equation.lhs - equation.rhs).subs(inserted), unknown)
    return solution


# (45): diffusion coefficient
row(
    "diffuse21",
    lambda: eq(_D, sp.factor(solved(_expansion().of_coefficient, _D, temperature_exponent()))),
    "the equation for D_e with T dD/dT = D/2; xi = 2 d rho0 v0 h",
)


@derives("diffuse22")
def _diffusion_equation() -> Derived:
    """(46): diffusion equation."""
    flux = -_D * s.nabla0 * _N
    # order 1 of continuity with J^(0) = 0; the gradient is a symbol, its square the Laplacian
    divergence = sp.expand(s.nabla0 * flux)
    return result(
        eq(Dt(1, _N), -divergence), ("order 1 of continuity", eq(Dt(1, _N), _flux_orders()[1]))
    )
