"""Chapman-Enskog expansion in the density gradient, order by order (diffuse1 ... diffuse22).

The expansion is made with the formal parameter epsilon; the collision operator enters only as a
linear operator, the gradient as a symbol that commutes with functions of the velocity.
"""

from __future__ import annotations

from functools import cache

import sympy as sp

from ..formal import Dt, Int, Lam, Partial, dot, eq
from ..symbols import (
    J0,
    J1,
    Bv,
    De,
    J,
    Jj,
    T,
    br,
    bv,
    d,
    eps,
    f,
    h,
    j,
    m,
    n,
    nabla,
    nabla0,
    nabla1,
    nd,
    nuD,
    p0,
    p1,
    p2,
    pj,
    rho0,
    t,
    v0,
    xi,
)
from .record import Derived, Number, Status, Step, definition
from .registry import derives

_N = nd(br, t)
_P0, _P1, _P2 = (order(br, bv, t) for order in (p0, p1, p2))
_B = Bv(bv, T(t))


@derives("diffuse2")
def _diffuse2() -> Derived:
    from .kinetic_equation import weak_form

    loss = weak_form(sp.Integer(1), sp.Integer(1))
    return Derived(
        eq(sp.Derivative(_N, t) + dot(nabla, J(br, t)), _zero(loss)),
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
    fluxes = [sp.Function(f"J_vec_{order}")(br, t) for order in range(3)]
    total = sp.expand(
        sum(
            eps ** (order + 1 + step) * dot(gradient, flux)
            for step, gradient in enumerate((nabla0, nabla1))
            for order, flux in enumerate(fluxes)
        )
    )
    return {order: -total.coeff(eps, order + 1) for order in range(3)}


def density_series(density: sp.Expr) -> sp.Expr:
    """The time derivative of a density in orders of epsilon, from the lowest that -div J has."""
    lowest = min(order + 1 for order, part in _flux_orders().items() if part != 0)
    return sp.Sum(eps ** (j + lowest) * Dt(j, density), (j, 0, sp.oo))


@derives("diffuse6")
def _diffuse6() -> Derived:
    return Derived(
        eq(sp.Derivative(_N, t), density_series(_N)),
        (
            Step("order epsilon of -div J", _flux_orders()[0]),
            Step("order epsilon^2 of -div J", _flux_orders()[1]),
        ),
        "Each order of the gradient carries at least one factor of epsilon.",
    )


@derives("diffuse7")
def _diffuse7() -> Derived:
    return continuity_order(Jj(br, t), _N)


def continuity_order(flux: sp.Expr, density: sp.Expr) -> Derived:
    """Order j of continuity: with the gradient expanded, lower fluxes meet its higher orders."""
    index = sp.Symbol("i", integer=True, nonnegative=True)
    gradient = sp.Function("nabla")(index)
    lower = sp.Function("J_vec")(j - index, *flux.args)
    general = -sp.Sum(dot(gradient, lower), (index, 0, j))
    return Derived(
        eq(Dt(j, density), general),
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
    series = sum(eps**order * part for order, part in enumerate((_P0, _P1, _P2)))
    terms = [sp.expand(bv * series).coeff(eps, order) for order in range(3)]
    factor = {sp.cancel(term / part) for term, part in zip(terms, (_P0, _P1, _P2), strict=True)}
    (weight,) = factor
    return Derived(
        eq(Jj(br, t), Int(weight * pj(br, bv, t), bv)),
        (Step("order epsilon^j of v p, over p^(j)", weight),),
    )


@derives("diffuse9")
def _diffuse9() -> Derived:
    return definition("Counts gradients.")


@cache
def orders() -> tuple[sp.Eq, sp.Eq]:
    """Orders 0 and 1 of the kinetic equation; p^(j) depends on time through n and T."""
    rate_of_n = eps * Dt(0, _N) + eps**2 * Dt(1, _N)
    left = sp.expand(
        sum(
            eps**order
            * (rate_of_n * Partial(part, _N) + sp.Derivative(T(t), t) * Partial(part, T(t)))
            for order, part in enumerate((_P0, _P1))
        )
        # the gradient acts through n, and on p^(0) alone at this order
        + eps * dot(bv, nabla0) * _N * Partial(_P0, _N)
    )
    right = sp.expand(sum(eps**order * Lam(part) for order, part in enumerate((_P0, _P1))))
    zeroth, first = (eq(left.coeff(eps, k), right.coeff(eps, k)) for k in (0, 1))
    return zeroth, first


@derives("diffuse10")
def _diffuse10() -> Derived:
    return Derived(orders()[0], (Step("order epsilon^0 of the kinetic equation", orders()[0]),))


@derives("diffuse11")
def _diffuse11() -> Derived:
    amplitude = sp.Symbol("A")
    # the integral of A f over v is n(r, t), that of f is n
    (solution,) = sp.solve(amplitude * n - _N, amplitude)
    return Derived(
        eq(_P0, solution * f(bv, t)),
        (
            Step("f solves the zeroth order: so does any multiple A of it", amplitude * f(bv, t)),
            Step("normalisation to n(r, t)", solution),
        ),
    )


@derives("diffuse12")
def _diffuse12() -> Derived:
    return Derived(orders()[1], (Step("order epsilon^1 of the kinetic equation", orders()[1]),))


@cache
def _first_order() -> sp.Eq:
    """diffuse13: the first order with the zeroth inserted."""
    slope = sp.diff(sp.Symbol("n_r") / n * f(bv, t), sp.Symbol("n_r"))
    cooled = {
        Dt(0, _N): sp.Integer(0),  # the flux of order 0 vanishes: f is even
        sp.Derivative(T(t), t): -xi(t) * T(t),
        Partial(_P0, _N): slope,
    }
    residual = (orders()[1].lhs - orders()[1].rhs).subs(cooled)
    source = residual.subs({Lam(_P1): 0, Partial(_P1, T(t)): 0})
    return eq(sp.expand(source - residual), source)


@derives("diffuse13")
def _diffuse13() -> Derived:
    return Derived(
        _first_order(),
        (
            Step("flux of order 0: v f is odd", eq(J0(br, t), sp.Integer(0))),
            Step("cooling", eq(sp.Derivative(T(t), t), -xi(t) * T(t))),
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
        Lam(_P1): dot(Lam(_B), nabla0) * _N,
        Partial(_P1, T(t)): dot(Partial(_B, T(t)), nabla0) * _N,
    }
    both = [side.subs(inserted) / _N for side in _first_order().args]
    strip = [_strip(sp.expand(side)) for side in both]
    return eq(*strip)


def _strip(expression: sp.Expr) -> sp.Expr:
    """X.grad -> X: the gradient is arbitrary."""

    def other(one: sp.Expr, two: sp.Expr) -> sp.Expr:
        if nabla0 not in (one, two):
            raise ValueError(f"{one}.{two} holds no gradient")
        return two if one == nabla0 else one

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
    integral = Int(dot(bv, _B), bv)
    flux = isotropy() * integral * nabla0 * _N
    coefficient = flux.subs(integral, De(t) / (-sp.Rational(1, 2)))
    return Derived(
        eq(J1(br, t), coefficient),
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
    flux = De(t) / half
    named = {
        Partial(_B, T(t)): Partial(De(t), T(t)) / half,
        Lam(_B): -nuD * flux,
        bv * f(bv, t): n * 2 * T(t) / m,
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
    (root,) = sp.solve(sp.Eq(T(t), m * speed**2 / 2), speed)
    return root


@cache
def temperature_exponent() -> sp.Expr:
    """q in D_e ~ T^q: D_e is a number times l v0, the only length and speed at hand."""
    heat = sp.Symbol("heat", positive=True)
    speed = thermal_speed().subs(T(t), heat)
    return sp.simplify(heat * sp.diff(speed, heat) / speed)


@derives("diffuse20")
def _diffuse20() -> Derived:
    return Derived(
        eq(Partial(De(t), T(t)), temperature_exponent() * De(t) / T(t)),
        (
            Step("v0 as a function of the temperature", thermal_speed()),
            Step("D_e = number l v0: exponent of T", temperature_exponent()),
        ),
        "Exact in the scaling state, where D_e/(l v0) is a number.",
    )


@derives("diffuse21")
def _diffuse21() -> Derived:
    unknown = sp.Symbol("D", positive=True)
    inserted = {Partial(De(t), T(t)): temperature_exponent() * unknown / T(t), De(t): unknown}
    equation = (_d_equation().lhs - _d_equation().rhs).subs(inserted)
    (solution,) = sp.solve(equation, unknown)
    return Derived(
        eq(De(t), sp.factor(solution)),
        (
            Step("the equation for D_e with T dD/dT = D/2", eq(equation, sp.Integer(0))),
            Step("solved for D_e", solution),
            Step("xi = 2 d rho0 v0 h", eq(xi(t), 2 * d * rho0 * v0(t) * h)),
        ),
    )


@derives("diffuse22")
def _diffuse22() -> Derived:
    flux = -De(t) * nabla0 * _N
    # order 1 of continuity with J^(0) = 0; the gradient is a symbol, its square the Laplacian
    right = sp.expand(-nabla0 * flux)
    return Derived(
        eq(Dt(1, _N), right),
        (
            Step("order 1 of continuity", eq(Dt(1, _N), _flux_orders()[1])),
            Step("with J^(0) = 0 and the flux of order 1", right),
        ),
    )
