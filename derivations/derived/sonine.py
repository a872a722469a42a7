"""Sonine polynomials, the equation for a_2, its roots, and their stability (Appendix B)."""

from __future__ import annotations

from functools import cache

import sympy as sp

from .. import symbols as s
from ..formal import Avg, Int, chain, eq
from ..premises import gaussian_average, gaussian_moment, loss, over_angle, speed_ratio_squared
from .quadrature_values import a2_value
from .record import Derived, Number, Step, derives, result


@cache
def power_average() -> sp.Expr:
    """The integral of x^p exp(-x) over x > 0."""
    return sp.integrate(s.x**s.p * sp.exp(-s.x), (s.x, 0, sp.oo))


@cache
def polynomial(order: int) -> sp.Expr:
    """S_N(x), orthogonal for the weight exp(-x) on x > 0 (the plane's), S_N(0) = 1.

    Built by Gram-Schmidt from 1, x, x^2, ...; nothing is typed in.
    """
    if order < 0:
        raise ValueError(f"order = {order}: a Sonine polynomial has order >= 0")

    def inner(one: sp.Expr, other: sp.Expr) -> sp.Expr:
        terms = sp.Poly(sp.expand(one * other), s.x).terms()
        return sum((k * power_average().subs(s.p, i) for (i,), k in terms), sp.Integer(0))

    monic = s.x**order
    for lower in range(order):
        basis = polynomial(lower)
        monic -= inner(s.x**order, basis) / inner(basis, basis) * basis
    return sp.expand(sp.expand(monic) / monic.subs(s.x, 0))


@cache
def sonine_average(order: int) -> sp.Expr:
    """<c^order> over exp(-c^2)/pi (1 + a2 S_2(c^2)) in the plane."""
    weight = 1 + s.a2 * polynomial(2).subs(s.x, s.c**2)
    return sp.collect(sp.expand(gaussian_average(sp.expand(s.c**order * weight))), s.a2, sp.factor)


@cache
def collision_moment(order: int) -> sp.Expr:
    """M_p for an even order p in the lowest Sonine approximation, as a function of e and a2."""
    return sp.factor(2 * loss(order) * sonine_average(order + 1))


@derives("sonine1")
def _sonine1() -> Derived:
    rate, reach = sp.symbols("rate reach", positive=True)
    weighted = sp.exp(-2 * rate * reach) * sp.exp(reach**2)
    return result(
        None,
        Step("F^2/phi for an exponential tail", weighted),
        note="The coefficients a_p = <S_p> exist, but the series does not converge to F for any e "
        "in [0, 1): the exact tail is exp(-2 c/h), so that F^2/phi is not integrable. As e -> 1 "
        "the VDF tends to a ring, not to the Gaussian that the series starts from.",
        holds=False,
    )


@derives("sonine1.5")
def _sonine1_5() -> Derived:
    return result(
        sp.Tuple(*(eq(s.S(order, s.x), polynomial(order)) for order in (0, 1))),
        Step("Gram-Schmidt for the weight exp(-x), with S(0) = 1", polynomial(1)),
    )


@derives("sonine2")
def _sonine2() -> Derived:
    return result(
        eq(s.S(2, s.x), polynomial(2)),
        Step("Gram-Schmidt for the weight exp(-x), with S(0) = 1", polynomial(2)),
    )


@cache
def generating_function() -> tuple[sp.Expr, sp.Expr]:
    """(generating function of the S_p, integral of a product of two against exp(-x)).

    The integral depends on u w alone: the polynomials are orthogonal, with the coefficients of
    its series as norms.
    """
    u, w = sp.symbols("u w", positive=True)
    single = sp.exp(-s.x * u / (1 - u)) / (1 - u)
    decay = sp.together(1 + u / (1 - u) + w / (1 - w))
    product = sp.simplify(1 / ((1 - u) * (1 - w) * decay))
    return single, product


@cache
def squared_norm() -> sp.Expr:
    """int S_p^2 exp(-x) dx for every p: the coefficient of (u w)^p."""
    u, w, z = sp.symbols("u w z", positive=True)
    in_product = sp.simplify(generating_function()[1].subs(w, z / u))
    ratio = sp.simplify(sp.diff(in_product, z) / in_product**2)
    if in_product.has(u) or ratio != 1 or in_product.subs(z, 0) != 1:
        raise ArithmeticError("the product of generating functions is not 1/(1 - u w)")
    return sp.Integer(1)  # 1/(1 - z) = 1 + z + z^2 + ...


@derives("sonine3")
def _sonine3() -> Derived:
    single, product = generating_function()
    u = sp.Symbol("u", positive=True)
    series = sp.series(single, u, 0, 4).removeO()
    for order in range(4):
        if sp.expand(series.coeff(u, order) - polynomial(order)) != 0:
            raise ArithmeticError(f"the generating function misses S_{order}")
    return result(
        eq(
            Int(s.phi(s.bc) * s.S(s.p, s.c**2) * s.S(s.pprime, s.c**2), s.bc),
            squared_norm() * sp.KroneckerDelta(s.p, s.pprime),
        ),
        Step("phi dc is exp(-x) dx with x = c^2", sp.exp(-s.x)),
        Step("generating function", single),
        Step("product of two of them, integrated: a function of u w alone", product),
        note="For all orders at once, by the generating function. The norm is 1 in the plane.",
    )


@derives("sonine4")
def _sonine4() -> Derived:
    # int S_p phi sum_q a_q S_q = a_p norm
    norm = squared_norm()
    return result(
        chain(
            s.a(s.p), Int(s.S(s.p, s.c**2) * s.F(s.bc), s.bc) / norm, Avg(s.S(s.p, s.c**2)) / norm
        ),
        Step("squared norm of S_p", norm),
    )


def _averaged(order: int) -> sp.Expr:
    """<S_order(c^2)> in the moments <c^2>, <c^4>."""
    terms = sp.Poly(polynomial(order), s.x).terms()
    return sum(
        (k * (Avg(s.c ** (2 * power)) if power else 1) for (power,), k in terms), sp.Integer(0)
    )


@derives("sonine4.5")
def _sonine4_5() -> Derived:
    first = _averaged(1)
    return result(
        chain(s.a1, first, first.subs(Avg(s.c**2), 1)),
        Step("<S_1>", first),
        Step("<c^2> = 1 by the definition of v0"),
    )


@derives("sonine5")
def _sonine5() -> Derived:
    second = _averaged(2)
    return result(
        chain(s.a2, second, second.subs(Avg(s.c**2), 1)),
        Step("<S_2>", second),
        Step("<c^2> = 1 by the definition of v0"),
    )


@derives("sonine6")
def _sonine6() -> Derived:
    general = s.M2 / 2 * s.p * Avg(s.c**s.p)
    return result(
        eq(s.M4, general.subs(s.p, 4)), Step("moments of the scaled equation (mueq)", general)
    )


def tidy(expression: sp.Expr) -> sp.Expr:
    """Factored, with e - 1 written as the paper does: through 1 - e^2."""
    for exponent in (1, -1):
        rest = sp.factor(sp.cancel(expression / (1 - s.e**2) ** exponent))
        if not rest.has(s.e - 1):
            return (1 - s.e**2) ** exponent * rest
    return sp.factor(expression)


def _moment_steps(order: int, symbol: sp.Symbol) -> tuple[Step, ...]:
    return (
        Step("speed ratio of one collision, squared", speed_ratio_squared()),
        Step(
            f"average of 1 - s^{order} over the impact parameter, both halves",
            eq(sp.Symbol("I_y"), over_angle(1 - speed_ratio_squared() ** (order // 2))),
        ),
        Step(
            f"average of c^{order + 1} over the Gaussian times 1 + a_2 S_2(c^2)",
            sonine_average(order + 1),
        ),
        Step("their product", eq(symbol, tidy(collision_moment(order)))),
    )


@derives("sonine9")
def _sonine9() -> Derived:
    return result(
        eq(s.M2, tidy(collision_moment(2))),
        *_moment_steps(2, s.M2),
        note="Exact in a_2; the next coefficient a_3 would add to it.",
    )


@derives("sonine10")
def _sonine10() -> Derived:
    return result(eq(s.M4, tidy(collision_moment(4))), *_moment_steps(4, s.M4))


@cache
def stationarity() -> sp.Expr:
    """4 M_2 (1 + a_2) - M_4, from M_4 = 2 M_2 <c^4> and <c^4> of the Sonine form."""
    fourth = sonine_average(4)
    return sp.expand(2 * s.M2 * fourth - s.M4)


@derives("sonine7")
def _sonine7() -> Derived:
    return result(
        eq(stationarity(), sp.Integer(0)),
        Step("M_4 = (M_2/2) 4 <c^4> from the moments of the scaled equation"),
        Step("<c^4> over the Gaussian times 1 + a_2 S_2", sonine_average(4)),
    )


@cache
def quadratic() -> sp.Expr:
    """The equation for a_2, divided by its factor sqrt(pi) (1 - e^2), which vanishes at e = 1."""
    inserted = stationarity().subs({s.M2: collision_moment(2), s.M4: collision_moment(4)})
    return sp.expand(sp.cancel(inserted / (sp.sqrt(sp.pi) * (1 - s.e**2))))


@cache
def roots() -> tuple[sp.Expr, sp.Expr]:
    """(lower, upper) root of the equation for a_2."""
    second, first, zeroth = sp.Poly(quadratic(), s.a2).all_coeffs()
    square = sp.sqrt(sp.expand(64 * (first**2 - 4 * second * zeroth)))
    lower, upper = ((-8 * first + sign * square) / (16 * second) for sign in (-1, 1))
    for root in (lower, upper):
        if sp.expand(quadratic().subs(s.a2, root)) != 0:
            raise ArithmeticError("the quadratic formula missed the root of the a_2 equation")
    return lower, upper


def at_restitution(expression: sp.Expr, value: float) -> float:
    """A function of e at one restitution."""
    return float(expression.subs(s.e, sp.Rational(str(value))))


@derives("sonine11")
def _sonine11() -> Derived:
    lower, upper = roots()
    mean, half = sp.expand((lower + upper) / 2), sp.expand((upper - lower) / 2)
    return result(
        eq(s.a2, mean + s.pm * half),
        Step("the equation for a_2, less its factor sqrt(pi)(1 - e^2)", eq(quadratic(), 0)),
        Step("lower root", lower),
        Step("upper root", upper),
        note="At e = 1 every a_2 solves the equation; the roots do not tend to the Gaussian's 0 "
        "there.",
        numbers=(
            Number("lower root at e = 0.9", at_restitution(lower, 0.9)),
            Number("lower root as e -> 1", at_restitution(lower, 1)),
            Number("upper root at e = 0.9", at_restitution(upper, 0.9)),
        ),
    )


@cache
def growth(root: sp.Expr | None = None) -> sp.Expr:
    """d/da_2 of the right-hand side of the a_2 equation, at a root (or at a symbol)."""
    slope = sp.diff(quadratic(), s.a2)
    return sp.expand(slope.subs(s.a2, s.a2bar if root is None else root))


@derives("sonine12")
def _sonine12() -> Derived:
    growths = [growth(root) for root in roots()]
    # over the root of the discriminant both are numbers: the signs hold wherever it is real
    spread = roots()[1] - roots()[0]
    signs = [sp.simplify(rate / spread) for rate in growths]
    (chosen,) = (root for root, sign in zip(roots(), signs, strict=True) if sign < 0)
    return result(
        eq(s.a2, chosen),
        Step("growth rate H at the lower root", growths[0]),
        Step("growth rate H at the upper root", growths[1]),
        Step("H over the distance of the roots: lower, upper", sp.Tuple(*signs)),
        Step("the root with H < 0 is the stable one", chosen),
        note="The stable root of the truncated equation, but far from the exact a_2, which exists "
        "for every e, is 2 at e = 0, 0 at e = 0.5929352 and tends to -1/2 as e -> 1.",
        numbers=(
            Number("Sonine a_2 at e = 0.9", at_restitution(chosen, 0.9)),
            Number("exact a_2 at e = 0.9", float(a2_value(0.9))),
            Number("Sonine a_2 at e = 0.6", at_restitution(chosen, 0.6)),
            Number("exact a_2 at e = 0.6", float(a2_value(0.6))),
        ),
    )


@cache
def sonine_cooling_rate() -> sp.Expr:
    """M_2/2 with symbolic a_2: the cooling rate of the first Sonine approximation."""
    return sp.factor(collision_moment(2) / 2)


@derives("beyond:collision-moment")
def _collision_moment() -> Derived:
    z = sp.Symbol("z", positive=True)  # (p + 3)/2, so that <c^(p+1)> of the Gaussian is Gamma(z)
    weight = sp.Poly(sp.expand((1 + s.a2 * polynomial(2)).subs(s.x, s.c**2)), s.c)
    average = sum(
        (
            factor * gaussian_moment().subs(s.p, 2 * z - 2 + order)
            for (order,), factor in weight.terms()
        ),
        sp.Integer(0),
    )
    ratio = sp.expand(sp.expand_func(average) / sp.gamma(z)).subs(z, (s.p + 3) / 2)
    return result(
        eq(s.Mp, 2 * s.lam(s.p) * sp.gamma((s.p + 3) / 2) * sp.collect(sp.expand(ratio), s.a2)),
        Step("weak form: twice lambda(p) <c^(p+1)>", 2 * s.lam(s.p) * Avg(s.c ** (s.p + 1))),
        Step("<c^(p+1)> of the Sonine form over Gamma((p + 3)/2)", ratio),
        note="p = 2 and p = 4 are sonine9 and sonine10.",
    )


@derives("beyond:sonine-n")
def _sonine_n() -> Derived:
    # exp(-x u/(1-u))/(1-u) = sum_k (-x u)^k/k! (1-u)^(-k-1); coefficient of u^(N-k) of the power
    inner = sp.binomial(s.N, s.N - s.k)
    if sp.gammasimp((inner / sp.binomial(s.N, s.k)).rewrite(sp.gamma)) != 1:
        raise ArithmeticError("the binomial coefficient is not symmetric")
    term = (-1) ** s.k * s.x**s.k / sp.factorial(s.k) * sp.binomial(s.N, s.k)
    for order in range(7):
        total = sum(
            (
                (-s.x) ** i / sp.factorial(i) * sp.binomial(order, order - i)
                for i in range(order + 1)
            ),
            sp.Integer(0),
        )
        if sp.expand(total - polynomial(order)) != 0:
            raise ArithmeticError(f"the coefficients miss S_{order} of Gram-Schmidt")
    return result(
        eq(s.S(s.N, s.x), sp.Sum(term, (s.k, 0, s.N))),
        Step("generating function of orthogonal polynomials", generating_function()[0]),
        Step("coefficient of u^(N-k) in (1 - u)^(-k-1)", inner),
        Step("Gram-Schmidt agrees with it for N = 0 ... 6", polynomial(6)),
    )
