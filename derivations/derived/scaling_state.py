"""Exact results that the paper does not have: closed forms, moments, cooling rate, tail, limits.

E is the average over the impact parameter y, uniform on [0, 1]; s^2 = e^2 + b^2 y^2 with
b^2 = 1 - e^2. In the scaling state v t/l tends in law to Y; kappa = E[-ln s] and
lambda(p) = E[1 - s^p]. The closed forms are sympy expressions in e (and p).
"""

from __future__ import annotations

from functools import cache

import mpmath as mp
import sympy as sp

from .. import symbols as s
from ..formal import eq
from ..premises import free_path, loss, parallel_component, speed_ratio_squared
from .record import Derived, derives, must, result, row, zero
from .values import a2_value, diffusion_slope_value

B = sp.Symbol("b", positive=True)
"""sqrt(1 - e^2), kept as a symbol while an integral is done."""


@cache
def _square() -> sp.Expr:
    """s^2 with b in place of e where it multiplies y^2."""
    square = s.e**2 + B**2 * s.y**2
    zero(square.subs(B, sp.sqrt(1 - s.e**2)) - speed_ratio_squared(), "b^2 is not 1 - e^2")
    return square


def _finish(integral: sp.Expr) -> sp.Expr:
    """b put back; asinh(b/e) and atan(b/e) in terms of b and e alone."""
    root = sp.sqrt(1 - s.e**2)
    # one to one on the range of the argument: equal if their tanh (their cosine) are equal
    zero(sp.tanh(sp.asinh(root / s.e)) - root, "asinh(b/e) is not atanh(b)")
    zero(sp.cos(sp.atan(root / s.e)) - s.e, "atan(b/e) is not acos(e)")
    plain = integral.subs({sp.asinh(B / s.e): sp.atanh(B), sp.atan(B / s.e): sp.acos(s.e)})
    return sp.simplify(plain.subs(B, root))


@cache
def loss_one() -> sp.Expr:
    """lambda(1) = 1 - E[s]."""
    return 1 - _finish(sp.integrate(sp.sqrt(_square()), (s.y, 0, 1)))


@cache
def loss_two() -> sp.Expr:
    """lambda(2) = 1 - E[s^2]."""
    return sp.factor(1 - sp.integrate(speed_ratio_squared(), (s.y, 0, 1)))


@cache
def mean_log_loss() -> sp.Expr:
    """The mean log loss kappa = E[-ln s]."""
    return _finish(-sp.integrate(sp.log(_square()), (s.y, 0, 1)) / 2)


@cache
def mean_cosine() -> sp.Expr:
    """<cos chi> = E[(v'.v/v^2)/s]."""
    parallel = sp.Poly(parallel_component(), s.y)
    total = sum(
        coefficient * sp.integrate(s.y**power / sp.sqrt(_square()), (s.y, 0, 1))
        for (power,), coefficient in parallel.terms()
    )
    return _finish(sp.expand(total))


@cache
def coefficient_ratio() -> sp.Expr:
    """Coefficient k + 1 over coefficient k of E[s^p] as a series in 1 - e^2.

    s^2 = 1 - (1 - e^2)(1 - y^2): the binomial series gives (p/2 - k)/(k + 1), with a minus sign,
    and I_k = E[(1 - y^2)^k] obeys I_(k+1) = 2 (k + 1)(I_k - I_(k+1)) by parts.
    """
    zero(1 - (1 - s.e**2) * (1 - s.y**2) - speed_ratio_squared(), "another s^2")
    binomial = sp.combsimp(sp.binomial(s.p / 2, s.k + 1) / sp.binomial(s.p / 2, s.k))
    ratio = sp.Symbol("ratio")
    # boundary terms vanish; the remainder is y times the derivative of the power
    derivative = sp.cancel(-s.y * sp.diff((1 - s.y**2) ** (s.k + 1), s.y) / (1 - s.y**2) ** s.k)
    factor = sp.cancel(derivative / s.y**2)  # of y^2 (1 - y^2)^k, with y^2 = 1 - (1 - y^2)
    (angle,) = sp.solve(ratio - factor * (1 - ratio), ratio)
    return sp.factor(sp.simplify(-binomial * angle))


@cache
def mean_ratio_power() -> sp.Expr:
    """E[s^p] for every real p, 0 < e <= 1 (p > -1 at e = 0), as a 2F1.

    Zeros and poles in k of the ratio of its coefficients are the parameters: no table is used.
    The coefficient of order 0 is 1, and every series with that ratio is this function.
    """
    numerator, denominator = (sp.Poly(part, s.k) for part in sp.fraction(coefficient_ratio()))
    must(sp.simplify(numerator.LC() / denominator.LC()) == 1, "not in 1 - e^2")
    upper = [-root for root in sp.roots(numerator)]
    lower = [-root for root in sp.roots(denominator)]
    # the ratio of a 2F1 has k + 1 below; where it has cancelled, 1 is an upper parameter
    if sp.Integer(1) in lower:
        lower.remove(sp.Integer(1))
    else:
        upper.append(sp.Integer(1))
    return sp.hyper(sorted(upper, key=sp.default_sort_key), lower, 1 - s.e**2)


row(
    "beyond:loss-p",
    lambda: eq(s.lam(s.p), 1 - mean_ratio_power()),
    "s^2 in powers of 1 - e^2",
    note="Converges for 0 < e <= 1. By Pfaff's transformation it is 1 - e^p 2F1(-p/2, 1/2; 3/2; "
    "-(1 - e^2)/e^2).",
)


@derives("beyond:loss-even")
def _loss_even() -> Derived:
    # (e^2 + (1 - e^2) y^2)^q by the binomial theorem; y^(2k) averages to 1/(2k + 1)
    average = sp.integrate(s.y ** (2 * s.k), (s.y, 0, 1), conds="none")
    power = s.e ** (2 * (s.q - s.k)) * (1 - s.e**2) ** s.k
    term = sp.binomial(s.q, s.k) * power * sp.simplify(average)
    for order in range(1, 5):
        total = sum(term.subs({s.q: order, s.k: index}) for index in range(order + 1))
        zero(1 - total - loss(2 * order), f"the sum is not lambda({2 * order})")
    return result(
        eq(s.lam(2 * s.q), 1 - sp.Sum(term, (s.k, 0, s.q))),
        ("average of y^(2k) over the impact parameter", average),
        note="For q = 1 ... 4 it is also compared with the integrated polynomial.",
    )


row("beyond:loss-1", lambda: eq(s.lam(1), loss_one()))
row("beyond:loss-2", lambda: eq(s.lam(2), loss_two()), "E[1 - s^2]")
row("beyond:log-loss", lambda: eq(s.klog, mean_log_loss()))
row("beyond:cosine", lambda: eq(s.cos_chi, mean_cosine()))


@derives("beyond:moments")
def _moments() -> Derived:
    scaled = s.MY(s.p) * s.t ** (-s.p)
    loss_term = -s.lam(s.p) * s.MY(s.p + 1) * s.t ** (-(s.p + 1))
    (following,) = sp.solve(sp.diff(scaled, s.t) - loss_term, s.MY(s.p + 1))
    # p -> 0: p/lambda(p) -> 1/E[-ln s], since d(1 - s^p)/dp = -ln s there
    first = sp.diff(1 - s.s**s.p, s.p).subs(s.p, 0)
    start = 1 / s.klog if first == -sp.log(s.s) else sp.nan
    return result(
        sp.Tuple(eq(s.MY(1), start), eq(s.MY(s.p + 1), sp.simplify(following))),
        "weak form of an isotropic VDF with l = 1: d<v^p>/dt = -lambda(p) <v^(p+1)>",
        note="Hence E[Y^n] = (n-1)!/(kappa lambda(1) ... lambda(n-1)): all moments exist for e < "
        "1.",
    )


@cache
def moment(order: int) -> sp.Expr:
    """E[Y^n] in kappa, lambda(1), lambda(2), ..."""
    value = 1 / s.klog
    for index in range(1, order):
        value *= index / s.lam(index)
    return value


row(
    "beyond:cooling-rate",
    lambda: eq(s.h, sp.simplify(s.lam(2) * (moment(3) / moment(2) ** sp.Rational(3, 2)))),
    "h = M_2/2 = lambda(2) <c^3>",
)


@cache
def largest_cooling_ratio() -> tuple[float, float]:
    """(e, h/(1 - e)) where h/(1 - e) is largest: it rises from sqrt(2) before it falls to 4/3."""
    rate = 2 * sp.sqrt(mean_log_loss() * loss_one()) / (1 - s.e)
    ratio = sp.lambdify(s.e, rate, "mpmath")
    with mp.workdps(30):
        place = mp.findroot(lambda value: mp.diff(ratio, value), 0.15)
        return float(place), float(ratio(place))


@derives("beyond:a2")
def _a2() -> Derived:
    fourth = moment(4) / moment(2) ** 2
    with mp.workdps(20):
        place = mp.findroot(lambda z: a2_value(str(z)), (0.55, 0.65), solver="secant", tol=1e-14)
    return result(
        eq(s.a2, sp.simplify(fourth / 2 - 1)),
        ("<c^4> = E[Y^4]/E[Y^2]^2", fourth),
        note="Exists for every e in [0, 1).",
        numbers={"restitution at which a_2 = 0": place},
    )


@cache
def _series_near_one(order: int) -> tuple[sp.Expr, sp.Expr]:
    """(kappa, lambda(1)) in powers of w = 1 - e^2, expanded under the integral."""
    w = sp.Symbol("w", positive=True)
    averages = [sp.integrate((1 - s.y**2) ** i, (s.y, 0, 1)) for i in range(order)]
    log_loss = sum(w**i / (2 * i) * averages[i] for i in range(1, order))
    half = sp.Rational(1, 2)
    loss_ = -sum(sp.binomial(half, i) * (-w) ** i * averages[i] for i in range(1, order))
    return sp.expand(log_loss), sp.expand(loss_)


@derives("beyond:cooling-near-1")
def _cooling_near_1() -> Derived:
    w = sp.Symbol("w", positive=True)
    product = sp.expand(sp.Mul(*_series_near_one(4)).subs(w, 1 - (1 - s.gap) ** 2) / s.gap**2)
    kept = sum(product.coeff(s.gap, order) * s.gap**order for order in range(3))
    series = sp.series(2 * sp.sqrt(kept), s.gap, 0, 3).removeO()
    return result(
        eq(s.h / s.gap, sp.expand(series)),
        ("kappa in powers of w = 1 - e^2", _series_near_one(4)[0]),
        note="With sqrt(2) at e = 0 it makes h nearly, not exactly, linear in 1 - e.",
    )


@derives("beyond:cooling-small-e")
def _cooling_small_e() -> Derived:
    logarithm = sp.Symbol("L", real=True)  # ln e, kept apart so that the rest is a power series
    b = sp.sqrt(1 - s.e**2)
    first = loss_one().subs(sp.atanh(b), sp.log(1 + b) - logarithm)
    log_loss = sp.series(mean_log_loss(), s.e, 0, 3).removeO()
    first = sp.series(first, s.e, 0, 3).removeO()
    root = sp.series(sp.sqrt(sp.expand(4 * log_loss * first)), s.e, 0, 3).removeO()
    return result(
        eq(s.h, sp.expand(root).subs(logarithm, sp.log(s.e))),
        ("kappa to order e^2", log_loss),
        note="Not analytic at e = 0: the second order holds e^2 ln e. Since pi/4 < 1, h/(1 - e) "
        "rises with e at first: it is not monotonic.",
    )


@derives("beyond:a2-limits")
def _a2_limits() -> Derived:
    w = sp.Symbol("w", positive=True)
    exact = 3 * s.klog * s.lam(1) / (s.lam(2) * s.lam(3)) - 1
    dead = {s.lam(i): sp.Rational(i, i + 1) for i in (1, 2, 3)}  # e = 0: s = y, E[y^p] = 1/(p + 1)
    at_zero = exact.subs(dead).subs(s.klog, -sp.integrate(sp.log(s.y), (s.y, 0, 1)))
    log_loss, first = _series_near_one(3)
    cubic = sp.Rational(3, 2) * w * sp.integrate(1 - s.y**2, (s.y, 0, 1))  # 1 - (1 - w(..))^(3/2)
    second = w * sp.integrate(1 - s.y**2, (s.y, 0, 1))
    near_one = exact.subs({s.klog: log_loss, s.lam(1): first, s.lam(2): second, s.lam(3): cubic})
    return result(sp.Tuple(eq(s.a2, at_zero), eq(s.a2, sp.limit(near_one, w, 0))))


@derives("beyond:tail")
def _tail() -> Derived:
    order, shift = sp.symbols("order shift", positive=True)
    # E[s^p] for large p comes from y near 1, where -ln s = steepness (1 - y)
    steepness = sp.simplify(sp.diff(sp.log(speed_ratio_squared()) / 2, s.y).subs(s.y, 1))
    decay = sp.Symbol("decay", positive=True)
    laplace = sp.integrate(sp.exp(-decay * s.x), (s.x, 0, sp.oo))  # x = 1 - y
    large = laplace.subs(decay, order * steepness)
    extra = sp.limit(order * large / (1 - large), order, sp.oo)
    # y^(shift - 1) exp(-y): its moments have ratio p + shift
    ratio = sp.gammasimp(sp.gamma(order + 1 + shift) / sp.gamma(order + shift)) - order
    (exponent,) = sp.solve(ratio - extra, shift)
    scale = sp.sqrt(moment(2))  # c = Y/sqrt(E[Y^2])
    by_h = scale.subs(s.klog, s.h**2 / 4 / s.lam(1))
    return result(
        sp.Tuple(eq(s.power, exponent - 2), eq(s.rate, sp.simplify(by_h))),
        ("-d ln s/dy at grazing incidence, with opposite sign", steepness),
        note="Leading behaviour of the moments; F ~ c^power exp(-rate c) is exactly exponential in "
        "c.",
    )


@derives("beyond:ring")
def _ring() -> Derived:
    w = sp.Symbol("w", positive=True)
    variance = moment(2) / moment(1) ** 2 - 1
    log_loss, first = _series_near_one(4)
    near = sp.series(variance.subs({s.klog: log_loss, s.lam(1): first}), w, 0, 2).removeO()
    return result(
        eq(s.width2, near.subs(w, 1 - s.e**2)),
        ("E[Y^2]/E[Y]^2 - 1", variance),
        note="F tends to the ring delta(c - 1)/(2 pi), of relative width sqrt((1 - e^2)/5), not to "
        "a Gaussian: fixed scatterers never thermalise a speed.",
    )


@derives("beyond:slope")
def _slope() -> Derived:
    # d<v^p v.r>/dt = <v^(p+2)> - nu(p) <v^(p+1) v.r>, <v^p v.r> = A(p) t^(-p-1), at p = -1:
    flux = sp.Symbol("A_0")
    (solution,) = sp.solve(moment(1) - (1 - s.cos_chi) * flux, flux)
    # random flights, with c/(1 - c) the sum of c^n over n >= 1
    first, second = free_path(1), free_path(2)
    per_flight = second + 2 * first**2 * s.cos_chi / (1 - s.cos_chi)
    flights = moment(1)  # d N/d ln t = <v> t/l
    zero(per_flight * flights - 2 * solution, "the flux hierarchy and the random flights disagree")
    return result(
        eq(s.slope, 2 * solution),
        ("second route: <r^2> per free flight, with persistence", per_flight),
        numbers={"slope at e = {e}": diffusion_slope_value},
        at=(0.2, 0.5, 0.9),
    )
