"""Exact results that the paper does not have: closed forms, moments, cooling rate, tail, limits.

E is the average over the impact parameter y, uniform on [0, 1]; s^2 = e^2 + b^2 y^2 with
b^2 = 1 - e^2. In the scaling state v t/l tends in law to Y; kappa = E[-ln s] and
lambda(p) = E[1 - s^p]. The closed forms are sympy expressions in e (and p).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import mpmath as mp
import sympy as sp

from .. import symbols as s
from ..formal import eq
from ..premises import free_path, loss, parallel_component, speed_ratio_squared
from .record import Derived, derives, result, row, zero


@cache
def plane_average(weight: sp.Expr) -> sp.Expr:
    """E of a function of s and y among smooth disks, term by term."""
    b = sp.Symbol("b", positive=True)
    terms = sp.Add.make_args(sp.expand(weight.subs(s.s, sp.sqrt(s.e**2 + b**2 * s.y**2))))
    total = sum(sp.integrate(term, (s.y, 0, 1)) for term in terms)
    return total.subs(b, sp.sqrt(1 - s.e**2))


def _finish(integral: sp.Expr) -> sp.Expr:
    """asinh(b/e) and atan(b/e) in terms of b and e alone."""
    b = sp.sqrt(1 - s.e**2)
    in_b = integral.subs({sp.asinh(b / s.e): sp.atanh(b), sp.atan(b / s.e): sp.acos(s.e)})
    return sp.simplify(in_b)


@cache
def loss_one() -> sp.Expr:
    """lambda(1) = 1 - E[s]."""
    return 1 - _finish(plane_average(s.s))


@cache
def mean_log_loss() -> sp.Expr:
    """The mean log loss kappa = E[-ln s]."""
    return _finish(plane_average(-sp.log(s.s**2) / 2))


@cache
def mean_cosine() -> sp.Expr:
    """<cos chi> = E[(v'.v/v^2)/s]."""
    return _finish(sp.expand(plane_average(parallel_component() / s.s)))


@cache
def mean_ratio_power() -> sp.Expr:
    """E[s^p] for every real p, 0 < e <= 1 (p > -1 at e = 0), as a 2F1.

    With x = 1 - y^2 it is the integral of (1 - x)^(-1/2) (1 - (1 - e^2) x)^(p/2)/2 over x from 0
    to 1: Euler's integral, of x^(b-1) (1 - x)^(c-b-1) (1 - z x)^(-a), with b = 1 and c = 3/2.
    """
    argument = -sp.diff(speed_ratio_squared().subs(s.y, sp.sqrt(1 - s.x)), s.x)
    return sp.hyper((1, -s.p / 2), (sp.Rational(3, 2),), sp.expand(argument))


@cache
def exact_function(formula: sp.Expr) -> Callable[[mp.mpf], mp.mpf]:
    """A formula in e, kappa, <cos chi> and the lambda(p) as a function of e."""
    closed_forms = {s.klog: mean_log_loss(), s.cos_chi: mean_cosine()}
    for loss_of_order in formula.atoms(s.lam):
        (order,) = loss_of_order.args
        closed_forms[loss_of_order] = 1 - mean_ratio_power().subs(s.p, order)
    return sp.lambdify(s.e, formula.subs(closed_forms), "mpmath")


def exact_value(formula: sp.Expr, restitution: float) -> mp.mpf:
    """Such a formula at one restitution, to 30 digits."""
    with mp.workdps(30):
        return exact_function(formula)(mp.mpf(restitution))


def values_of(formula: Callable[[], sp.Expr]) -> Callable[[float], mp.mpf]:
    """Such a formula, which is derived when it is first asked for, as a function of e."""
    return lambda restitution: exact_value(formula(), restitution)


# loss of |v|^p per collision, any real p
row(
    "beyond:loss-p",
    lambda: eq(s.lam(s.p), 1 - mean_ratio_power()),
    "Euler's integral in x = 1 - y^2, where s^2 = 1 - (1 - e^2) x",
    note="Converges for 0 < e <= 1. By Pfaff's transformation it is 1 - e^p 2F1(-p/2, 1/2; 3/2; "
    "-(1 - e^2)/e^2).",
)


@derives("beyond:loss-even")
def _loss_even() -> Derived:
    """Loss of |v|^p per collision, symbolic even p = 2 q."""
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


# loss of |v|
row("beyond:loss-1", lambda: eq(s.lam(1), loss_one()))
# loss of energy
row("beyond:loss-2", lambda: eq(s.lam(2), loss(2)), "E[1 - s^2]")
# mean log loss kappa
row("beyond:log-loss", lambda: eq(s.klog, mean_log_loss()))
# mean cosine of the deflection
row("beyond:cosine", lambda: eq(s.cos_chi, mean_cosine()))


@derives("beyond:moments")
def _moments() -> Derived:
    """Moments of the scaling solution."""
    scaled = s.MY(s.p) * s.t ** (-s.p)
    loss_term = -s.lam(s.p) * s.MY(s.p + 1) * s.t ** (-(s.p + 1))
    (following,) = sp.solve(sp.diff(scaled, s.t) - loss_term, s.MY(s.p + 1))
    # as p -> 0, lambda(p)/p tends to E[-ln s]
    log_loss = sp.limit((1 - s.s**s.p) / s.p, s.p, 0).subs(-sp.log(s.s), s.klog)
    return result(
        sp.Tuple(eq(s.MY(1), 1 / log_loss), eq(s.MY(s.p + 1), sp.simplify(following))),
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


@cache
def cooling_rate() -> sp.Expr:
    """h = M_2/2 = lambda(2) <c^3>."""
    return sp.simplify(s.lam(2) * moment(3) / moment(2) ** sp.Rational(3, 2))


cooling_rate_value = values_of(cooling_rate)
# exact cooling rate
row("beyond:cooling-rate", lambda: eq(s.h, cooling_rate()), "h = M_2/2 = lambda(2) <c^3>")


@cache
def largest_cooling_ratio() -> tuple[float, float]:
    """(e, h/(1 - e)) where h/(1 - e) is largest: it rises from sqrt(2) before it falls to 4/3."""
    ratio = exact_function(cooling_rate() / (1 - s.e))
    with mp.workdps(30):
        place = mp.findroot(lambda value: mp.diff(ratio, value), 0.15)
        return float(place), float(ratio(place))


@cache
def a2() -> sp.Expr:
    """<c^4>/2 - 1."""
    return sp.simplify(moment(4) / moment(2) ** 2 / 2 - 1)


a2_value = values_of(a2)


def _restitution_of_no_a2() -> float:
    with mp.workdps(20):
        return float(mp.findroot(exact_function(a2()), 0.59))


# exact a_2
row(
    "beyond:a2",
    lambda: eq(s.a2, a2()),
    "<c^4> = E[Y^4]/E[Y^2]^2",
    note="Exists for every e in [0, 1).",
    numbers={"restitution at which a_2 = 0": _restitution_of_no_a2},
)


@cache
def _series_near_one(order: int) -> tuple[sp.Expr, sp.Expr]:
    """(kappa, lambda(1)) in powers of w = 1 - e^2, expanded under the integral."""
    w = sp.Symbol("w", positive=True)
    averages = [sp.integrate((1 - s.y**2) ** i, (s.y, 0, 1)) for i in range(order)]
    half = sp.Rational(1, 2)
    log_loss = sp.Integer(0)
    speed_loss = sp.Integer(0)
    for i in range(1, order):
        log_loss += w**i / (2 * i) * averages[i]
        speed_loss -= sp.binomial(half, i) * (-w) ** i * averages[i]
    return sp.expand(log_loss), sp.expand(speed_loss)


@derives("beyond:cooling-near-1")
def _cooling_near_1() -> Derived:
    """h(e)/(1 - e) as e -> 1, to second order in delta = 1 - e."""
    w = sp.Symbol("w", positive=True)
    log_loss, speed_loss = _series_near_one(4)
    product = (log_loss * speed_loss).subs(w, 1 - (1 - s.gap) ** 2)
    product = sp.expand(product / s.gap**2)
    truncated = sum(product.coeff(s.gap, order) * s.gap**order for order in range(3))
    series = sp.series(2 * sp.sqrt(truncated), s.gap, 0, 3).removeO()
    return result(
        eq(s.h / s.gap, sp.expand(series)),
        ("kappa in powers of w = 1 - e^2", log_loss),
        note="With sqrt(2) at e = 0 it makes h nearly, not exactly, linear in 1 - e.",
    )


@derives("beyond:cooling-small-e")
def _cooling_small_e() -> Derived:
    """h(e) as e -> 0, to order e^2."""
    logarithm = sp.Symbol("L", real=True)  # ln e, kept apart so that the rest is a power series
    b = sp.sqrt(1 - s.e**2)
    log_loss = sp.series(mean_log_loss(), s.e, 0, 3).removeO()
    speed_loss = loss_one().subs(sp.atanh(b), sp.log(1 + b) - logarithm)
    speed_loss = sp.series(speed_loss, s.e, 0, 3).removeO()
    root = sp.series(sp.sqrt(sp.expand(4 * log_loss * speed_loss)), s.e, 0, 3).removeO()
    return result(
        eq(s.h, sp.expand(root).subs(logarithm, sp.log(s.e))),
        ("kappa to order e^2", log_loss),
        note="Not analytic at e = 0: the second order holds e^2 ln e. Since pi/4 < 1, h/(1 - e) "
        "rises with e at first: it is not monotonic.",
    )


@derives("beyond:a2-limits")
def _a2_limits() -> Derived:
    """Exact a_2 at e = 0 and as e -> 1."""
    w = sp.Symbol("w", positive=True)
    # e = 0: s = y and E[y^p] = 1/(p + 1)
    losses = {s.lam(i): sp.Rational(i, i + 1) for i in (1, 2, 3)}
    losses[s.klog] = -sp.integrate(sp.log(s.y), (s.y, 0, 1))
    at_zero = a2().subs(losses)

    # e -> 1: s^2 = 1 - w (1 - y^2), and lambda(3) = E[1 - (1 - w (1 - y^2))^(3/2)]
    log_loss, speed_loss = _series_near_one(3)
    mean_square = sp.integrate(1 - s.y**2, (s.y, 0, 1))
    losses = {
        s.klog: log_loss,
        s.lam(1): speed_loss,
        s.lam(2): w * mean_square,
        s.lam(3): sp.Rational(3, 2) * w * mean_square,
    }
    near_one = sp.limit(a2().subs(losses), w, 0)
    return result(sp.Tuple(eq(s.a2, at_zero), eq(s.a2, near_one)))


@derives("beyond:tail")
def _tail() -> Derived:
    """Tail of F: c^power exp(-rate c)."""
    order, shift = sp.symbols("order shift", positive=True)
    # E[s^p] for large p comes from y near 1, where -ln s = steepness (1 - y)
    steepness = sp.simplify(sp.diff(sp.log(speed_ratio_squared()) / 2, s.y).subs(s.y, 1))
    decay = sp.Symbol("decay", positive=True)
    laplace = sp.integrate(sp.exp(-decay * s.x), (s.x, 0, sp.oo))  # x = 1 - y
    ratio_power = laplace.subs(decay, order * steepness)  # E[s^p]
    excess = sp.limit(order * ratio_power / (1 - ratio_power), order, sp.oo)
    # y^(shift - 1) exp(-y): its moments have ratio p + shift
    moment_ratio = sp.gammasimp(sp.gamma(order + 1 + shift) / sp.gamma(order + shift))
    (exponent,) = sp.solve(moment_ratio - order - excess, shift)
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
    """Relative variance of the speed as e -> 1."""
    w = sp.Symbol("w", positive=True)
    variance = moment(2) / moment(1) ** 2 - 1
    log_loss, speed_loss = _series_near_one(4)
    in_w = variance.subs({s.klog: log_loss, s.lam(1): speed_loss})
    leading = sp.series(in_w, w, 0, 2).removeO()
    return result(
        eq(s.width2, leading.subs(w, 1 - s.e**2)),
        ("E[Y^2]/E[Y]^2 - 1", variance),
        note="F tends to the ring delta(c - 1)/(2 pi), of relative width sqrt((1 - e^2)/5), not to "
        "a Gaussian: fixed scatterers never thermalise a speed.",
    )


@cache
def slope() -> sp.Expr:
    """d<r^2>/d ln t over l^2, from the flux.

    d<v^p v.r>/dt = <v^(p+2)> - nu(p) <v^(p+1) v.r>, <v^p v.r> = A(p) t^(-p-1), at p = -1.
    """
    flux = sp.Symbol("A_0")
    (solution,) = sp.solve(moment(1) - (1 - s.cos_chi) * flux, flux)
    return 2 * solution


slope_value = values_of(slope)


@derives("beyond:slope")
def _slope() -> Derived:
    """Slope of <r^2> in ln t, over l^2."""
    # random flights, with c/(1 - c) the sum of c^n over n >= 1; d N/d ln t = <v> t/l
    per_flight = free_path(2) + 2 * free_path(1) ** 2 * s.cos_chi / (1 - s.cos_chi)
    zero(per_flight * moment(1) - slope(), "the flux hierarchy and the random flights disagree")
    return result(
        eq(s.slope, slope()),
        ("second route: <r^2> per free flight, with persistence", per_flight),
        numbers={"slope at e = {e}": slope_value},
        restitutions=(0.2, 0.5, 0.9),
    )
