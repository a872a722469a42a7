"""The derived closed forms as mpmath functions, at the working precision of mpmath.

Each takes the restitution e, 0 <= e < 1 unless it says otherwise, and stands for one formula that
a numerical code may use; lengths are in mean free paths. They come from
:mod:`derivations.closed_forms` by ``lambdify``: nothing is typed in twice. Near e = 1 the closed
forms lose digits by cancellation: raise ``mpmath.mp.dps`` accordingly.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import mpmath as mp
import sympy as sp

from .. import symbols as s
from . import closed_forms


@cache
def _function(name: str) -> Callable[..., mp.mpf]:
    expression = getattr(closed_forms, name)()
    arguments = (s.p, s.e) if expression.has(s.p) else (s.e,)
    return sp.lambdify(arguments, expression, "mpmath")


def mean_speed_ratio_power(order: mp.mpf, restitution: mp.mpf) -> mp.mpf:
    """E[s^p] for real p, 0 <= e <= 1 (p > -1 at e = 0)."""
    return _function("mean_ratio_power")(mp.mpf(order), mp.mpf(restitution))


def decay_rate(order: mp.mpf, restitution: mp.mpf) -> mp.mpf:
    """lambda(p) = 1 - E[s^p]."""
    return 1 - mean_speed_ratio_power(order, restitution)


def mean_log_loss(restitution: mp.mpf) -> mp.mpf:
    """The mean log loss kappa = E[-ln s]."""
    return _function("mean_log_loss")(mp.mpf(restitution))


def mean_cosine(restitution: mp.mpf) -> mp.mpf:
    """<cos chi>, 0 < e < 1 (0 < e: the closed form has e^2 artanh b; its limit at 0 is 1/2)."""
    return _function("mean_cosine")(mp.mpf(restitution))


def cooling_rate(restitution: mp.mpf) -> mp.mpf:
    """h(e), 0 < e < 1."""
    return _function("cooling_rate")(mp.mpf(restitution))


@cache
def largest_cooling_ratio() -> tuple[float, float]:
    """(e, h/(1 - e)) where h/(1 - e) is largest: it rises from sqrt(2) before it falls to 4/3."""
    with mp.workdps(30):

        def ratio(value: mp.mpf) -> mp.mpf:
            return cooling_rate(value) / (1 - value)

        place = mp.findroot(lambda value: mp.diff(ratio, value), 0.15)
        return float(place), float(ratio(place))


def diffusion_slope(restitution: mp.mpf) -> mp.mpf:
    """d<r^2>/d ln t in units of l^2, 0 < e < 1."""
    return _function("diffusion_slope")(mp.mpf(restitution))


def a2(restitution: mp.mpf) -> mp.mpf:
    """The exact a_2 = 3 kappa lambda(1)/(lambda(2) lambda(3)) - 1."""
    first, second, third = (decay_rate(n, restitution) for n in (1, 2, 3))
    return 3 * mean_log_loss(restitution) * first / (second * third) - 1


def moment(order: mp.mpf, restitution: mp.mpf) -> mp.mpf:
    """<c^p> of the scaling solution for real p (p > -1 at e = 0), to about 25 digits."""
    exponent = mp.mpf(order)
    scale = log_speed_moment(mp.mpf(2), restitution) / 2
    return mp.exp(log_speed_moment(exponent, restitution) - exponent * scale)


_FAR = 60
_HALF_WIDTH = 20


@cache
def _log_ladder(restitution: mp.mpf, last: int, digits: int) -> tuple[mp.mpf, ...]:
    """ln E[Y^n] - ln Gamma(n) for n = 1 ... last, by the recursion."""
    del digits  # part of the key of the cache
    logs = [-mp.log(mean_log_loss(restitution))]
    for n in range(1, last):
        logs.append(logs[-1] - mp.log(decay_rate(n, restitution)))
    return tuple(logs)


def log_speed_moment(order: mp.mpf, restitution: mp.mpf) -> mp.mpf:
    """ln E[Y^p] for real p, Y the limit of v t.

    M(p + 1) = p M(p)/lambda(p) with M(1) = 1/kappa gives the integer orders. For the others
    ln M(p) - ln Gamma(p) is interpolated between the integers about p + 60, where it is as smooth
    as a multiple of ln p, and the recursion leads back to p.
    """
    target = mp.mpf(order)
    if target == 0:
        return mp.mpf(0)
    shift = _FAR + max(0, int(mp.ceil(-target)))
    far = target + shift
    first = int(mp.floor(far)) - _HALF_WIDTH + 1
    ladder = _log_ladder(mp.mpf(restitution), first + 2 * _HALF_WIDTH - 1, mp.mp.dps)
    nodes = [(mp.mpf(n), ladder[n - 1]) for n in range(first, first + 2 * _HALF_WIDTH)]
    value = _interpolate(nodes, far) + mp.loggamma(far)
    for step in range(shift):
        at = target + step
        # lambda(p)/p tends to kappa at p = 0
        ratio = decay_rate(at, restitution) / at if at else mean_log_loss(restitution)
        value += mp.log(ratio)
    return value


def _interpolate(points: list[tuple[mp.mpf, mp.mpf]], target: mp.mpf) -> mp.mpf:
    """The polynomial through the points, at the target (Lagrange)."""
    total = mp.mpf(0)
    for index, (x, value) in enumerate(points):
        weight = value
        for other, (z, _) in enumerate(points):
            if other != index:
                weight *= (target - z) / (x - z)
        total += weight
    return total


def log_tail_amplitude(restitution: mp.mpf) -> mp.mpf:
    """ln A in F(c) ~ A c^(b - 2) exp(-2 c/h), b = 1/(1 - e^2), to about 15 digits for e < 0.95.

    The density of Y is A' y^(b-1) exp(-y) far out, so that E[Y^n]/Gamma(n + b) tends to A', and
    A' = 2 pi A (h/2)^b. The limit is extrapolated as a polynomial in 1/n, from n >> b^2.
    """
    value = mp.mpf(restitution)
    power = 1 / (1 - value**2)
    first = 60 + int(10 * power**2)
    nodes = range(first, 4 * first + 1, first // 5)
    ladder = _log_ladder(value, nodes[-1], mp.mp.dps)
    points = [
        (1 / mp.mpf(n), ladder[n - 1] + mp.loggamma(n) - mp.loggamma(n + power)) for n in nodes
    ]
    limit = _interpolate(points, mp.mpf(0))
    # h from the same two losses as the ladder: defined at e = 0 too
    half_h = mp.sqrt(mean_log_loss(value) * decay_rate(1, value))
    return limit - mp.log(2 * mp.pi) - power * mp.log(half_h)
