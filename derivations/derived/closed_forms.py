"""Closed forms of the exact theory, integrated from one collision; beyond the paper.

E is the average over the impact parameter y, uniform on [0, 1]; s^2 = e^2 + b^2 y^2 with
b^2 = 1 - e^2. Every function returns a sympy expression in e (and p).
"""

from __future__ import annotations

from functools import cache

import sympy as sp

from .. import symbols as s
from ..formal import eq
from ..premises import loss, parallel_component, speed_ratio_squared
from .record import Derived, Step, derives, result

B = sp.Symbol("b", positive=True)
"""sqrt(1 - e^2), kept as a symbol while an integral is done."""


@cache
def _square() -> sp.Expr:
    """s^2 with b in place of e where it multiplies y^2."""
    square = s.e**2 + B**2 * s.y**2
    if sp.expand(square.subs(B, sp.sqrt(1 - s.e**2)) - speed_ratio_squared()) != 0:
        raise ArithmeticError("b^2 is not 1 - e^2")
    return square


def _finish(integral: sp.Expr) -> sp.Expr:
    """b put back; asinh(b/e) and atan(b/e) in terms of b and e alone."""
    root = sp.sqrt(1 - s.e**2)
    # one to one on the range of the argument: equal if their tanh (their cosine) are equal
    if sp.simplify(sp.tanh(sp.asinh(root / s.e)) - root) != 0:
        raise ArithmeticError("asinh(b/e) is not atanh(b)")
    if sp.simplify(sp.cos(sp.atan(root / s.e)) - s.e) != 0:
        raise ArithmeticError("atan(b/e) is not acos(e)")
    plain = integral.subs({sp.asinh(B / s.e): sp.atanh(B), sp.atan(B / s.e): sp.acos(s.e)})
    return sp.simplify(plain.subs(B, root))


@cache
def mean_ratio() -> sp.Expr:
    """E[s]."""
    return _finish(sp.integrate(sp.sqrt(_square()), (s.y, 0, 1)))


@cache
def loss_one() -> sp.Expr:
    """lambda(1) = 1 - E[s]."""
    return 1 - mean_ratio()


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
    if sp.expand(1 - (1 - s.e**2) * (1 - s.y**2) - speed_ratio_squared()) != 0:
        raise ArithmeticError("s^2 is not 1 - (1 - e^2)(1 - y^2)")
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
    if sp.simplify(numerator.LC() / denominator.LC()) != 1:
        raise ArithmeticError("the argument of the series is not 1 - e^2")
    upper = [-root for root in sp.roots(numerator)]
    lower = [-root for root in sp.roots(denominator)]
    # the ratio of a 2F1 has k + 1 below; where it has cancelled, 1 is an upper parameter
    if sp.Integer(1) in lower:
        lower.remove(sp.Integer(1))
    else:
        upper.append(sp.Integer(1))
    return sp.hyper(sorted(upper, key=sp.default_sort_key), lower, 1 - s.e**2)


@cache
def cooling_rate() -> sp.Expr:
    """h(e) = 2 sqrt(kappa lambda(1))."""
    return 2 * sp.sqrt(mean_log_loss() * loss_one())


@cache
def diffusion_slope() -> sp.Expr:
    """d<r^2>/d ln t in units of l^2."""
    return 2 / (mean_log_loss() * (1 - mean_cosine()))


@derives("beyond:loss-p")
def _loss_p() -> Derived:
    return result(
        eq(s.lam(s.p), 1 - mean_ratio_power()),
        Step("s^2 in powers of 1 - e^2", 1 - (1 - s.e**2) * (1 - s.y**2)),
        Step("coefficient k + 1 over coefficient k of E[s^p]", coefficient_ratio()),
        Step("the series with that ratio and first coefficient 1", mean_ratio_power()),
        note="Converges for 0 < e <= 1. By Pfaff's transformation it is "
        "1 - e^p 2F1(-p/2, 1/2; 3/2; -(1 - e^2)/e^2).",
    )


@derives("beyond:loss-even")
def _loss_even() -> Derived:
    # (e^2 + (1 - e^2) y^2)^q by the binomial theorem; y^(2k) averages to 1/(2k + 1)
    average = sp.integrate(s.y ** (2 * s.k), (s.y, 0, 1), conds="none")
    term = (
        sp.binomial(s.q, s.k)
        * s.e ** (2 * (s.q - s.k))
        * (1 - s.e**2) ** s.k
        * sp.simplify(average)
    )
    for order in range(1, 5):
        total = sum(term.subs({s.q: order, s.k: index}) for index in range(order + 1))
        if sp.expand(1 - total - loss(2 * order)) != 0:
            raise ArithmeticError(f"the sum misses lambda({2 * order})")
    return result(
        eq(s.lam(2 * s.q), 1 - sp.Sum(term, (s.k, 0, s.q))),
        Step("average of y^(2k) over the impact parameter", average),
        note="For q = 1 ... 4 it is also compared with the integrated polynomial.",
    )


@derives("beyond:loss-1")
def _loss_1() -> Derived:
    return result(
        eq(s.lam(1), loss_one()),
        Step("E[s] by its antiderivative; asinh(b/e) = artanh(b)", loss_one()),
    )


@derives("beyond:loss-2")
def _loss_2() -> Derived:
    return result(eq(s.lam(2), loss_two()), Step("E[1 - s^2]", loss_two()))


@derives("beyond:log-loss")
def _log_loss() -> Derived:
    return result(
        eq(s.klog, mean_log_loss()),
        Step("E[-ln s] by its antiderivative; arctan(b/e) = arccos(e)", mean_log_loss()),
    )


@derives("beyond:cosine")
def _cosine() -> Derived:
    return result(
        eq(s.cos_chi, mean_cosine()),
        Step("E[(-e + (1 + e) y^2)/s] by its antiderivative", mean_cosine()),
    )
