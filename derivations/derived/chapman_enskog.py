"""Chapman-Enskog expansion in the density gradient, order by order (diffuse1 ... diffuse22).

The expansion is made with the formal parameter epsilon; the collision operator enters only as a
linear operator, the gradient as a symbol that commutes with functions of the velocity.
"""

from __future__ import annotations

from functools import cache

import sympy as sp

from .. import symbols as s
from ..formal import Dt, Int, Lam, Partial, dot, eq
from .record import Derived, Number, Status, Step, definition
from .registry import derives

_N = s.nd(s.br, s.t)
_P0, _P1, _P2 = (order(s.br, s.bv, s.t) for order in (s.p0, s.p1, s.p2))
_B = s.Bv(s.bv, s.T(s.t))


@derives("diffuse2")
def _diffuse2() -> Derived:
    from .kinetic_equation import weak_form

    loss = weak_form(sp.Integer(1), sp.Integer(1))
    return Derived(
        eq(sp.Derivative(_N, s.t) + dot(s.nabla, s.J(s.br, s.t)), _zero(loss)),
        (
            Step("integral of the kinetic equation over v: density and flux", None),
            Step("the collision operator keeps mass: its weak form with Y = 1", loss),
        ),
    )


def _zero(integral: sp.Expr) -> sp.Expr:
    """The value of a formal integral whose integrand vanishes."""
    return sp.sympify(integral.replace(Int, lambda *args: 0 if args[0] == 0 else Int(*args)))


@derives("diffuse3")
def _diffuse3() -> Derived:
    return definition("The zeroth moment in velocity.")


@derives("diffuse4")
def _diffuse4() -> Derived:
    return definition("The first moment in velocity.")


@derives("diffuse5")
def _diffuse5() -> Derived:
    return Derived(
        None,
        note="A formal series; that it orders the distribution holds for gradients that are small "
        "over the distance which a tracer covers while its speed falls by a fixed factor.",
        status=Status.ASSUMPTION,
        holds=True,
    )


@cache
def _flux_orders() -> dict[int, sp.Expr]:
    """Orders of -div J with both the gradient and the flux expanded."""
    fluxes = [sp.Function(f"J_vec_{order}")(s.br, s.t) for order in range(3)]
    total = sp.expand(
        sum(
            s.eps ** (order + 1 + step) * dot(gradient, flux)
            for step, gradient in enumerate((s.nabla0, s.nabla1))
            for order, flux in enumerate(fluxes)
        )
    )
    return {order: -total.coeff(s.eps, order + 1) for order in range(3)}


def density_series(density: sp.Expr) -> sp.Expr:
    """The time derivative of a density in orders of epsilon, from the lowest that -div J has."""
    lowest = min(order + 1 for order, part in _flux_orders().items() if part != 0)
    return sp.Sum(s.eps ** (s.j + lowest) * Dt(s.j, density), (s.j, 0, sp.oo))


@derives("diffuse6")
def _diffuse6() -> Derived:
    return Derived(
        eq(sp.Derivative(_N, s.t), density_series(_N)),
        (
            Step("order epsilon of -div J", _flux_orders()[0]),
            Step("order epsilon^2 of -div J", _flux_orders()[1]),
        ),
        "Each order of the gradient carries at least one factor of epsilon.",
    )


@derives("diffuse7")
def _diffuse7() -> Derived:
    return continuity_order(s.Jj(s.br, s.t), _N)


def continuity_order(flux: sp.Expr, density: sp.Expr) -> Derived:
    """Order j of continuity: with the gradient expanded, lower fluxes meet its higher orders."""
    index = sp.Symbol("i", integer=True, nonnegative=True)
    gradient = sp.Function("nabla")(index)
    lower = sp.Function("J_vec")(s.j - index, *flux.args)
    general = -sp.Sum(dot(gradient, lower), (index, 0, s.j))
    return Derived(
        eq(Dt(s.j, density), general),
        (
            Step("order epsilon", eq(Dt(0, density), _flux_orders()[0])),
            Step("order epsilon^2", eq(Dt(1, density), _flux_orders()[1])),
            Step("order epsilon^3", eq(Dt(2, density), _flux_orders()[2])),
        ),
        "With the gradient expanded as in diffuse9, order j also holds the flux of order j - i "
        "under the gradient of order i. The printed form drops these. At the orders that the "
        "paper uses nothing changes, since the flux of order 0 vanishes; from order 2 on it does.",
        numbers=(Number("change of the diffusion equation (order 1)", 0.0),),
    )


@derives("diffuse8")
def _diffuse8() -> Derived:
    series = sum(s.eps**order * part for order, part in enumerate((_P0, _P1, _P2)))
    terms = [sp.expand(s.bv * series).coeff(s.eps, order) for order in range(3)]
    factor = {sp.cancel(term / part) for term, part in zip(terms, (_P0, _P1, _P2), strict=True)}
    (weight,) = factor
    return Derived(
        eq(s.Jj(s.br, s.t), Int(weight * s.pj(s.br, s.bv, s.t), s.bv)),
        (Step("order epsilon^j of v p, over p^(j)", weight),),
    )


@derives("diffuse9")
def _diffuse9() -> Derived:
    return definition("Counts gradients.")


@cache
def orders() -> tuple[sp.Eq, sp.Eq]:
    """Orders 0 and 1 of the kinetic equation; p^(j) depends on time through n and T."""
    rate_of_n = s.eps * Dt(0, _N) + s.eps**2 * Dt(1, _N)
    left = sp.expand(
        sum(
            s.eps**order
            * (
                rate_of_n * Partial(part, _N)
                + sp.Derivative(s.T(s.t), s.t) * Partial(part, s.T(s.t))
            )
            for order, part in enumerate((_P0, _P1))
        )
        # the gradient acts through n, and on p^(0) alone at this order
        + s.eps * dot(s.bv, s.nabla0) * _N * Partial(_P0, _N)
    )
    right = sp.expand(sum(s.eps**order * Lam(part) for order, part in enumerate((_P0, _P1))))
    zeroth, first = (eq(left.coeff(s.eps, k), right.coeff(s.eps, k)) for k in (0, 1))
    return zeroth, first


@derives("diffuse10")
def _diffuse10() -> Derived:
    return Derived(orders()[0], (Step("order epsilon^0 of the kinetic equation", orders()[0]),))


@derives("diffuse11")
def _diffuse11() -> Derived:
    amplitude = sp.Symbol("A")
    # the integral of A f over v is n(r, t), that of f is n
    (solution,) = sp.solve(amplitude * s.n - _N, amplitude)
    return Derived(
        eq(_P0, solution * s.f(s.bv, s.t)),
        (
            Step(
                "f solves the zeroth order: so does any multiple A of it",
                amplitude * s.f(s.bv, s.t),
            ),
            Step("normalisation to n(r, t)", solution),
        ),
    )


@derives("diffuse12")
def _diffuse12() -> Derived:
    return Derived(orders()[1], (Step("order epsilon^1 of the kinetic equation", orders()[1]),))


@cache
def _first_order() -> sp.Eq:
    """diffuse13: the first order with the zeroth inserted."""
    slope = sp.diff(sp.Symbol("n_r") / s.n * s.f(s.bv, s.t), sp.Symbol("n_r"))
    cooled = {
        Dt(0, _N): sp.Integer(0),  # the flux of order 0 vanishes: f is even
        sp.Derivative(s.T(s.t), s.t): -s.xi(s.t) * s.T(s.t),
        Partial(_P0, _N): slope,
    }
    residual = (orders()[1].lhs - orders()[1].rhs).subs(cooled)
    source = residual.subs({Lam(_P1): 0, Partial(_P1, s.T(s.t)): 0})
    return eq(sp.expand(source - residual), source)


@derives("diffuse13")
def _diffuse13() -> Derived:
    return Derived(
        _first_order(),
        (
            Step("flux of order 0: v f is odd", eq(s.J0(s.br, s.t), sp.Integer(0))),
            Step("cooling", eq(sp.Derivative(s.T(s.t), s.t), -s.xi(s.t) * s.T(s.t))),
            Step("the first order", _first_order()),
        ),
    )


@derives("diffuse14")
def _diffuse14() -> Derived:
    return Derived(
        None,
        note="Holds: the equation is linear with a source proportional to the gradient of n, and "
        "the operator commutes with rotations.",
        status=Status.ASSUMPTION,
        holds=True,
    )


@cache
def b_equation() -> sp.Eq:
    """diffuse15: p^(1) = B.grad n inserted and the arbitrary gradient divided out."""
    inserted = {
        Lam(_P1): dot(Lam(_B), s.nabla0) * _N,
        Partial(_P1, s.T(s.t)): dot(Partial(_B, s.T(s.t)), s.nabla0) * _N,
    }
    both = [side.subs(inserted) / _N for side in _first_order().args]
    strip = [_strip(sp.expand(side)) for side in both]
    return eq(*strip)


def _strip(expression: sp.Expr) -> sp.Expr:
    """X.grad -> X: the gradient is arbitrary."""

    def other(one: sp.Expr, two: sp.Expr) -> sp.Expr:
        if s.nabla0 not in (one, two):
            raise ValueError(f"{one}.{two} holds no gradient")
        return two if one == s.nabla0 else one

    from ..formal import Dot

    return expression.replace(Dot, other)


@derives("diffuse15")
def _diffuse15() -> Derived:
    return Derived(
        b_equation(),
        (Step("p^(1) = B.grad n inserted, the gradient divided out", b_equation()),),
    )


@cache
def isotropy() -> sp.Expr:
    """The factor in <v_i v_j b(v)> = factor <v^2 b(v)> delta_ij: an average over the direction."""
    angle = sp.Symbol("angle", real=True)
    cross = sp.integrate(sp.cos(angle) * sp.sin(angle), (angle, 0, 2 * sp.pi))
    if cross != 0:
        raise ArithmeticError("the off-diagonal element does not vanish")
    return sp.integrate(sp.cos(angle) ** 2, (angle, 0, 2 * sp.pi)) / (2 * sp.pi)


@derives("diffuse16")
def _diffuse16() -> Derived:
    integral = Int(dot(s.bv, _B), s.bv)
    flux = isotropy() * integral * s.nabla0 * _N
    coefficient = flux.subs(integral, s.De(s.t) / (-sp.Rational(1, 2)))
    return Derived(
        eq(s.J1(s.br, s.t), coefficient),
        (
            Step("mean of the squared cosine over directions", isotropy()),
            Step("flux of order 1: v times B.grad n, integrated", flux),
            Step("with D_e = -(1/2) int v.B dv", coefficient),
        ),
    )


@derives("diffuse17")
def _diffuse17() -> Derived:
    return definition("The diffusion coefficient as an integral of B.")


@derives("diffuse18")
def _diffuse18() -> Derived:
    return Derived(
        _d_equation(),
        (
            Step("the equation for B", b_equation()),
            Step("its product with -v/2, integrated over v", _d_equation()),
        ),
        "The paper cites diffuse17 where it means diffuse15.",
    )


@cache
def _d_equation() -> sp.Eq:
    """-(1/2) int v.(equation for B) dv, with D_e, nu_D and <v^2> = v0^2 = 2T/m named."""
    half = -sp.Rational(1, 2)
    flux = s.De(s.t) / half
    named = {
        Partial(_B, s.T(s.t)): Partial(s.De(s.t), s.T(s.t)) / half,
        Lam(_B): -s.nuD * flux,
        s.bv * s.f(s.bv, s.t): s.n * 2 * s.T(s.t) / s.m,
    }
    left, right = b_equation().args
    return eq(sp.expand(half * left.subs(named)), sp.expand(half * right).subs(named))


@derives("diffuse19")
def _diffuse19() -> Derived:
    return definition("The relaxation rate of the flux; it depends on the shape of B.")


@cache
def thermal_speed() -> sp.Expr:
    """v0 as a function of the temperature, from T = m v0^2/2."""
    speed = sp.Symbol("speed", positive=True)
    (root,) = sp.solve(sp.Eq(s.T(s.t), s.m * speed**2 / 2), speed)
    return root


@cache
def temperature_exponent() -> sp.Expr:
    """q in D_e ~ T^q: D_e is a number times l v0, the only length and speed at hand."""
    heat = sp.Symbol("heat", positive=True)
    speed = thermal_speed().subs(s.T(s.t), heat)
    return sp.simplify(heat * sp.diff(speed, heat) / speed)


@derives("diffuse20")
def _diffuse20() -> Derived:
    return Derived(
        eq(Partial(s.De(s.t), s.T(s.t)), temperature_exponent() * s.De(s.t) / s.T(s.t)),
        (
            Step("v0 as a function of the temperature", thermal_speed()),
            Step("D_e = number l v0: exponent of T", temperature_exponent()),
        ),
        "Exact in the scaling state, where D_e/(l v0) is a number.",
    )


@derives("diffuse21")
def _diffuse21() -> Derived:
    unknown = sp.Symbol("D", positive=True)
    inserted = {
        Partial(s.De(s.t), s.T(s.t)): temperature_exponent() * unknown / s.T(s.t),
        s.De(s.t): unknown,
    }
    equation = (_d_equation().lhs - _d_equation().rhs).subs(inserted)
    (solution,) = sp.solve(equation, unknown)
    return Derived(
        eq(s.De(s.t), sp.factor(solution)),
        (
            Step("the equation for D_e with T dD/dT = D/2", eq(equation, sp.Integer(0))),
            Step("solved for D_e", solution),
            Step("xi = 2 d rho0 v0 h", eq(s.xi(s.t), 2 * s.d * s.rho0 * s.v0(s.t) * s.h)),
        ),
    )


@derives("diffuse22")
def _diffuse22() -> Derived:
    flux = -s.De(s.t) * s.nabla0 * _N
    # order 1 of continuity with J^(0) = 0; the gradient is a symbol, its square the Laplacian
    right = sp.expand(-s.nabla0 * flux)
    return Derived(
        eq(Dt(1, _N), right),
        (
            Step("order 1 of continuity", eq(Dt(1, _N), _flux_orders()[1])),
            Step("with J^(0) = 0 and the flux of order 1", right),
        ),
    )
