"""Sonine polynomials, the equation for a_2, its roots, their stability (Appendix B)."""

from __future__ import annotations

from functools import cache

import sympy as sp

from .. import symbols as s
from ..formal import Avg, Int, Partial, chain, eq
from ..premises import free_path, gaussian_average, gaussian_moment, loss, speed_ratio_squared
from .cooling import speed_equation_by_moment
from .record import Derived, Verdict, defines, derives, result, row, zero
from .scaling_state import a2_value


@cache
def polynomial(order: int) -> sp.Expr:
    """S_N(x), orthogonal for the weight exp(-x) on x > 0 (the plane's), S_N(0) = 1.

    Built by Gram-Schmidt from 1, x, x^2, ...; nothing is typed in.
    """

    def inner(p: sp.Expr, q: sp.Expr) -> sp.Expr:
        # the integral of x^i exp(-x) is that of free paths
        terms = sp.Poly(sp.expand(p * q), s.x).terms()
        return sp.Add(*(k * free_path(i) for (i,), k in terms))

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
def _sonine_series() -> Derived:
    """(B4): Sonine expansion."""
    rate, reach = sp.symbols("rate reach", positive=True)
    weighted = sp.exp(-2 * rate * reach) * sp.exp(reach**2)
    return result(
        None,
        ("F^2/phi for an exponential tail", weighted),
        note="The coefficients a_p = <S_p> exist, but the series does not converge to F for any e "
        "in [0, 1): the exact tail is exp(-2 c/h), so that F^2/phi is not integrable. As e -> 1 "
        "the VDF tends to a ring, not to the Gaussian that the series starts from.",
        verdict=Verdict.FAILS,
    )


# (B6): Sonine polynomials of order 0 and 1
row("sonine1.5", lambda: sp.Tuple(*(eq(s.S(order, s.x), polynomial(order)) for order in (0, 1))))
# (B7): Sonine polynomial of order 2
row("sonine2", lambda: eq(s.S(2, s.x), polynomial(2)))


@cache
def squared_norm() -> sp.Expr:
    """int S_p^2 exp(-x) dx for every p: the coefficient of (u w)^p.

    The integral of two generating functions, of u and w, against exp(-x) depends on z = u w alone:
    the S_p are orthogonal.
    """
    u, z = sp.symbols("u z", positive=True)
    w = z / u
    product = 1 / ((1 - u) * (1 - w) * (1 + u / (1 - u) + w / (1 - w)))
    return sp.simplify(product * (1 - z))  # 1/(1 - z) = 1 + z + z^2 + ...


@derives("sonine3")
def _orthogonality() -> Derived:
    """(B8): orthogonality."""
    u = sp.Symbol("u", positive=True)
    single = sp.exp(-s.x * u / (1 - u)) / (1 - u)
    series = sp.series(single, u, 0, 4).removeO()
    for order in range(4):
        zero(series.coeff(u, order) - polynomial(order), f"not S_{order}")
    return result(
        eq(
            Int(s.phi(s.bc) * s.S(s.p, s.c**2) * s.S(s.pprime, s.c**2), s.bc),
            squared_norm() * sp.KroneckerDelta(s.p, s.pprime),
        ),
        ("phi dc is exp(-x) dx with x = c^2", sp.exp(-s.x)),
        ("generating function", single),
        note="For all orders at once, by the generating function. The norm is 1 in the plane.",
    )


@derives("sonine4")
def _sonine_coefficients() -> Derived:
    """(B9): Sonine coefficients as averages."""
    # int S_p phi sum_q a_q S_q = a_p norm
    norm = squared_norm()
    return result(
        chain(
            s.a(s.p), Int(s.S(s.p, s.c**2) * s.F(s.bc), s.bc) / norm, Avg(s.S(s.p, s.c**2)) / norm
        ),
        ("squared norm of S_p", norm),
    )


def _coefficient(order: int, symbol: sp.Symbol) -> sp.Tuple:
    average = sp.Integer(0)
    for (power,), coefficient in sp.Poly(polynomial(order), s.x).terms():
        moment = Avg(s.c ** (2 * power)) if power else 1
        average += coefficient * moment
    return chain(symbol, average, average.subs(Avg(s.c**2), 1))


# (B10): first Sonine coefficient
row("sonine4.5", lambda: _coefficient(1, s.a1), "<c^2> = 1 by the definition of v0")
# (B11): second Sonine coefficient
row("sonine5", lambda: _coefficient(2, s.a2), "<c^2> = 1 by the definition of v0")


# (B12): fourth moment by the second
row("sonine6", lambda: eq(s.M4, (s.M2 / 2 * s.p * Avg(s.c**s.p)).subs(s.p, 4)))


def tidy(expression: sp.Expr) -> sp.Expr:
    """Factored, with e - 1 written as the paper does: through 1 - e^2."""
    for exponent in (1, -1):
        cofactor = sp.factor(sp.cancel(expression / (1 - s.e**2) ** exponent))
        if not cofactor.has(s.e - 1):
            return (1 - s.e**2) ** exponent * cofactor
    return sp.factor(expression)


def _moment(order: int, symbol: sp.Symbol) -> tuple:
    """The collision moment as an equation, and the steps that give it."""
    return (
        eq(symbol, tidy(collision_moment(order))),
        ("speed ratio of one collision, squared", speed_ratio_squared()),
        (
            f"1 - s^{order} over the impact parameter, both halves",
            eq(sp.Symbol("I_y"), 2 * loss(order)),
        ),
        (f"<c^{order + 1}> over the Gaussian times 1 + a_2 S_2(c^2)", sonine_average(order + 1)),
    )


# (B15): second moment of the collision integral
row("sonine9", lambda: _moment(2, s.M2), note="Exact in a_2; a_3 would add to it.")
# (B16): fourth moment of the collision integral
row("sonine10", lambda: _moment(4, s.M4))


@cache
def stationarity() -> sp.Expr:
    """4 M_2 (1 + a_2) - M_4, from M_4 = 2 M_2 <c^4> and <c^4> of the Sonine form."""
    fourth = sonine_average(4)
    return sp.expand(2 * s.M2 * fourth - s.M4)


# (B13): the equation for a_2
row("sonine7", lambda: eq(stationarity(), sp.Integer(0)))


@cache
def quadratic() -> sp.Expr:
    """The equation for a_2, divided by its factor sqrt(pi) (1 - e^2), which vanishes at e = 1."""
    inserted = stationarity().subs({s.M2: collision_moment(2), s.M4: collision_moment(4)})
    return sp.expand(sp.cancel(inserted / (sp.sqrt(sp.pi) * (1 - s.e**2))))


@cache
def roots() -> tuple[sp.Expr, sp.Expr]:
    """(lower, upper) root of the equation for a_2."""
    a, b, c = sp.Poly(quadratic(), s.a2).all_coeffs()
    root = sp.sqrt(sp.expand(64 * (b**2 - 4 * a * c)))
    lower = (-8 * b - root) / (16 * a)
    upper = (-8 * b + root) / (16 * a)
    return lower, upper


def at_restitution(expression: sp.Expr, value: float) -> float:
    """A function of e at one restitution."""
    return float(expression.subs(s.e, sp.Rational(str(value))))


@derives("sonine11")
def _roots_of_a2() -> Derived:
    """(B17): both roots for a_2."""
    lower, upper = roots()
    mean = sp.expand((lower + upper) / 2)
    half_distance = sp.expand((upper - lower) / 2)
    return result(
        eq(s.a2, mean + s.pm * half_distance),
        ("the equation for a_2, less its factor sqrt(pi)(1 - e^2)", eq(quadratic(), 0)),
        ("lower root", lower),
        note="At e = 1 every a_2 solves the equation; the roots do not tend to the Gaussian's 0 "
        "there.",
        numbers={
            "lower root at e = 0.9": at_restitution(lower, 0.9),
            "lower root as e -> 1": at_restitution(lower, 1),
            "upper root at e = 0.9": at_restitution(upper, 0.9),
        },
    )


SONINE_AND_EXACT = {
    "Sonine a_2 at e = {e}": lambda e: at_restitution(roots()[0], e),
    "exact a_2 at e = {e}": a2_value,
}
"""Numbers beside a row, by restitution."""


@cache
def growth(root: sp.Expr | None = None) -> sp.Expr:
    """d/da_2 of the right-hand side of the a_2 equation, at a root (or at a symbol)."""
    if root is None:
        root = s.a2bar
    slope = sp.diff(quadratic(), s.a2)
    return sp.expand(slope.subs(s.a2, root))


@derives("sonine12")
def _stable_root() -> Derived:
    """(B18): the root adopted for a_2."""
    lower, upper = roots()
    # over the root of the discriminant growth is a number: its sign holds wherever that is real
    signs = {root: sp.simplify(growth(root) / (upper - lower)) for root in roots()}
    (stable_root,) = (root for root, sign in signs.items() if sign < 0)
    return result(
        eq(s.a2, stable_root),
        ("growth rate H at the lower root", growth(lower)),
        ("growth rate H at the upper root", growth(upper)),
        note="The stable root of the truncated equation, but far from the exact a_2, which exists "
        "for every e, is 2 at e = 0, 0 at e = 0.5929352 and tends to -1/2 as e -> 1.",
        numbers=SONINE_AND_EXACT,
        restitutions=(0.9, 0.6),
    )


@cache
def sonine_cooling_rate() -> sp.Expr:
    """M_2/2 with symbolic a_2: the cooling rate of the first Sonine approximation."""
    return sp.factor(collision_moment(2) / 2)


@derives("beyond:collision-moment")
def _collision_moment() -> Derived:
    """M_p of the Sonine form for any real p."""
    z = sp.Symbol("z", positive=True)  # (p + 3)/2, so that <c^(p+1)> of the Gaussian is Gamma(z)
    weight = sp.Poly(sp.expand((1 + s.a2 * polynomial(2)).subs(s.x, s.c**2)), s.c)
    average = sp.Integer(0)
    for (order,), coefficient in weight.terms():
        average += coefficient * gaussian_moment().subs(s.p, 2 * z - 2 + order)
    ratio = sp.expand(sp.expand_func(average) / sp.gamma(z)).subs(z, (s.p + 3) / 2)
    return result(
        eq(s.Mp, 2 * s.lam(s.p) * sp.gamma((s.p + 3) / 2) * sp.collect(sp.expand(ratio), s.a2)),
        ("weak form: twice lambda(p) <c^(p+1)>", 2 * s.lam(s.p) * Avg(s.c ** (s.p + 1))),
        ("<c^(p+1)> of the Sonine form over Gamma((p + 3)/2)", ratio),
        note="p = 2 and p = 4 are sonine9 and sonine10.",
    )


@derives("beyond:sonine-n")
def _sonine_n() -> Derived:
    """Sonine polynomial of order N."""
    # exp(-x u/(1-u))/(1-u) = sum_k (-x u)^k/k! (1-u)^(-k-1); coefficient of u^(N-k) of the power
    term = (-1) ** s.k * s.x**s.k / sp.factorial(s.k) * sp.binomial(s.N, s.k)
    for order in range(7):
        total = sum(term.subs({s.N: order, s.k: i}) for i in range(order + 1))
        zero(total - polynomial(order), f"not S_{order} by Gram-Schmidt")
    return result(eq(s.S(s.N, s.x), sp.Sum(term, (s.k, 0, s.N))))


# -- time dependence and stability --

_V0 = s.v0(s.t)

defines(
    {
        "ac1": "General: any f can be written so, with <c^2> = 1 at all times.",
        "ac4": "Defines the perturbation.",
    }
)


def _moment_balance(order: sp.Expr, moment: sp.Expr, rate: sp.Expr, loss: sp.Expr) -> sp.Expr:
    """d<v^p>/dt + loss, with <v^p> = v0^p <c^p>, over d rho0 v0^(p+1)."""
    slope = speed_equation_by_moment()
    product = _V0**order * rate + order * _V0 ** (order - 1) * slope * moment
    return sp.expand(sp.simplify(product / (s.d * s.rho0 * _V0 ** (order + 1)))) + loss


# (B20): evolution of its moments
row(
    "ac2",
    lambda: (
        eq(_moment_balance(s.p, Avg(s.c**s.p), Partial(Avg(s.c**s.p), s.t), s.Mp), sp.Integer(0)),
        ("rate of v0", speed_equation_by_moment()),
    ),
)


@derives("ac3")
def _rate_of_a2() -> Derived:
    """(B21): evolution of a_2."""
    rate = sp.Symbol("adot")
    fourth = sonine_average(4)
    balance = _moment_balance(
        sp.Integer(4), fourth.subs(s.a2, s.a2t(s.t)), sp.diff(fourth, s.a2) * rate, s.M4
    )
    (solution,) = sp.solve(balance, rate)
    return result(
        eq(sp.Derivative(s.a2t(s.t), s.t), sp.factor(solution)),
        ("moment equation of the time-dependent scaled VDF, p = 4", eq(balance, 0)),
        note="M_2 and M_4 stand for their values at a_2(t).",
    )


@derives("ac5")
def _linear_perturbation() -> Derived:
    """(B23): linearised evolution of a_2."""
    prefactor = s.d * s.rho0 * _V0 / 2
    right = prefactor * sp.sqrt(sp.pi) * (1 - s.e**2) * quadratic()
    linear = sp.diff(right, s.a2).subs(s.a2, s.a2bar)
    scale = linear / (_V0 * growth())
    return result(eq(sp.Derivative(s.da2(s.t), s.t), tidy(scale) * s.H * _V0 * s.da2(s.t)))


@derives("ac7")
def _growth_rate() -> Derived:
    """(B25): growth rate H(e) of a perturbation of a_2."""
    at_lower_root, at_upper_root = map(growth, roots())
    return result(
        eq(s.H, growth()),
        ("at the lower root", at_lower_root),
        ("at the upper root", at_upper_root),
        note="At the two roots H is minus and plus sqrt(-383 + 828 e^2 + 900 e^4)/8: the lower "
        "root is stable and the upper one unstable for every e above the threshold, where both "
        "meet.",
        numbers={
            "H at the lower root, e = 0.9": at_restitution(at_lower_root, 0.9),
            "H at the upper root, e = 0.9": at_restitution(at_upper_root, 0.9),
        },
    )


@derives("ac6")
def _perturbation_over_time() -> Derived:
    """(B24): solution of the linearised evolution of a_2."""
    rate = s.d * s.rho0 / 2 * sp.sqrt(sp.pi) * (1 - s.e**2) * s.H
    # d(delta)/delta = rate v0 dt: the logarithm is rate times the integral of v0
    return result(
        eq(s.da2(s.t), s.da2(0) * sp.exp(rate * sp.Integral(_V0, (s.t, 0, s.t)))),
        "ac5 divided by the perturbation and integrated",
        note="With v0 = 1/(alpha + beta t) it is a power of time: exponent sqrt(pi)(1 - e^2) H/(2 "
        "h). The integration variable is printed as t.",
    )


@derives("compare1")
def _threshold() -> Derived:
    """(B26): restitution below which the Sonine a_2 is not real."""
    discriminant = sp.expand(sp.discriminant(8 * quadratic(), s.a2))
    square = sp.Symbol("e2", positive=True)
    (positive,) = sp.solve(discriminant.subs(s.e, sp.sqrt(square)), square)
    threshold = sp.sqrt(positive)
    return result(
        sp.Le(threshold, s.e, evaluate=False),
        ("discriminant of the a_2 equation", discriminant),
        ("its only positive zero in e^2", positive),
        note="A failure of the truncation, not of the gas: the exact a_2 exists for every e in [0, "
        "1).",
        numbers={"threshold restitution": threshold, "exact a_2 at e = 0.4": a2_value(0.4)},
    )


@derives("compare3", "compare3#2")
def _second_moment_of_e() -> Derived:
    """(15) and (B27): M_2 as a function of e, Sonine."""
    lower, _ = roots()
    inserted = sp.expand(sp.cancel(collision_moment(2) / (1 - s.e**2)).subs(s.a2, lower))

    def ratio(e: float) -> float:
        return at_restitution(inserted * (1 + s.e) / 2, e)

    return result(
        eq(s.M2, (1 - s.e**2) * inserted),
        ("M_2 at symbolic a_2", collision_moment(2)),
        ("the stable root", eq(s.a2, lower)),
        note="Real only above the threshold of compare1. Half of it is the Sonine cooling rate.",
        numbers={"M_2/2 over (1 - e) at e = {e}": ratio},
        restitutions=(0.6, 0.7, 0.9),
    )
