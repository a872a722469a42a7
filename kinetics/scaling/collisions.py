r"""How many collisions a cooling tracer has had at late times, and how far it has flown.

With phi(p) = E[s^p], from v = 1 and l = 1, d/dt E[z^N v^p] = -(1 - z phi(p)) E[z^N v^(p+1)], and
E[z^N(t)] = sum_k (-t)^k/k! c(k), c the principal solution of c(p+1) = (1 - z phi(p)) c(p), c(0) 1.
This is the Mellin transform Gamma(p) c(-p), whose first pole on the right is at -p = theta,
phi(theta) = 1/z: hence C t^theta, C = Gamma(-theta) c(1 + theta)/(-z phi'(theta)). E[exp(-q X)] of
the path X is the same with z = 1/(1 + q).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import equal_panels
from kinetics.numerics.recurrence import MOST_ORDERS, log_growth, taylor_of_log

_FAR = 16  # Euler-Maclaurin is used so far beyond theta, where 1 - z phi vanishes; as in `mellin`
_CLOSE = 0.05  # of j and theta: their difference of phi is then summed, not subtracted
_LARGEST = 1000.0  # of |theta|
_LARGEST_LOG = 600.0  # of phi


def power_of(law: CollisionLaw, z: float) -> float | None:
    """theta with phi(theta) = 1/z; None beyond +-1000, and where phi is 1/z nowhere."""
    from scipy.optimize import brentq

    share = (z - 1.0) / z  # lambda(theta)

    def missed(p: float) -> float:
        return float(law.decay_rate(p)) - share

    deepest = float(law.quadrature.log_loss.max())
    lowest = max(-_LARGEST, -_LARGEST_LOG / deepest, law.lowest_power * (1.0 - 1e-12))
    low, high = (lowest, 0.0) if z < 1.0 else (0.0, 1.0)
    while z > 1.0 and missed(high) < 0.0 and high < _LARGEST:
        low, high = high, min(2.0 * high, _LARGEST)
    if missed(low) > 0.0 or missed(high) < 0.0:
        return None
    return float(brentq(missed, low, high, xtol=1e-300, rtol=1e-15, maxiter=500))


def log_amplitude(law: CollisionLaw, z: float, theta: float) -> float:
    """ln C; every factor is positive: the poles of Gamma(-theta) cancel with zeros of 1 - z phi."""
    n = math.ceil(_FAR + max(theta, 0.0))
    j = np.arange(float(n))
    rate = law.decay_rate(np.append(j, theta))
    near = np.abs(j - theta) < _CLOSE
    apart = np.where(near, 1.0, j - theta)
    slope = (rate[:-1] - rate[-1]) / apart  # (phi(theta) - phi(j))/(j - theta)
    if np.any(near):
        q = law.quadrature_for(n)
        step = float((j - theta)[near][0])
        ratio = -np.expm1(-step * q.log_loss) / step if step else q.log_loss
        slope[near] = (q.weight * np.exp(-theta * q.log_loss)) @ ratio
    numerator = np.log(z * slope).sum() + math.lgamma(n - theta)
    denominator = np.log(_left(law, z, j + 1.0 + theta)).sum()
    nodes, weights = equal_panels(abs(1.0 + theta), 24, 4.0)
    sign = math.copysign(1.0, 1.0 + theta)
    integral = sign * float(np.log(_left(law, z, n + sign * nodes)) @ weights)
    begin, end = (_taylor(law, z, np.array([p])) for p in (float(n), n + 1.0 + theta))
    far = float(log_growth(np.array([integral]), begin, end)[0])
    # the derivative along the imaginary axis, without cancellation: -phi'(theta) = lambda'(theta)
    falling = float(law.decay_symbol(np.array([theta + 1e-20j]))[0].imag) / 1e-20
    return float(numerator - denominator + far - math.log(z * falling))


def _left(law: CollisionLaw, z: float, p: FloatArray) -> FloatArray:
    """1 - z phi(p)."""
    return np.asarray((1.0 - z) + z * law.decay_rate(p))


def _taylor(law: CollisionLaw, z: float, p: FloatArray) -> list[NDArray[Any]]:
    """Taylor coefficients of ln(1 - z phi) at p (n,)."""
    rate = [z * c for c in law.decay_taylor(p, MOST_ORDERS)]
    return taylor_of_log([(1.0 - z) + rate[0], *rate[1:]])


def cumulants(law: CollisionLaw, n: int, of_path: bool) -> FloatArray:
    """The first n cumulants of N, or of X in l, per ln t, shape (n,).

    E[exp(u N)] ~ t^theta with -ln(1 - lambda(theta)) = u; E[exp(u X)] with lambda(theta) = u. The
    series of theta in u is Lagrange's reversion, and its coefficients times k! are the cumulants.
    """
    c = _taylor_at_zero(law, n + 1)
    if not of_path:
        c = [-one for one in taylor_of_log([np.ones(1), *(-one for one in c[1:])])]
    f = np.array([float(one[0]) for one in c[1:]])  # u/theta
    inverse = np.zeros(n)
    inverse[0] = 1.0 / f[0]
    for k in range(1, n):
        inverse[k] = -(f[1 : k + 1] @ inverse[k - 1 :: -1]) / f[0]
    power, out = np.eye(1, n)[0], np.zeros(n)
    for k in range(1, n + 1):
        power = np.convolve(power, inverse)[:n]
        out[k - 1] = math.factorial(k - 1) * power[k - 1]
    return out


def _taylor_at_zero(law: CollisionLaw, orders: int) -> list[NDArray[Any]]:
    """Taylor coefficients of lambda at 0, from order 0 to orders - 1, each (1,)."""
    if q := law.uniform_power:  # lambda = z/(z + q)
        return [np.array([-((-1.0 / q) ** k) if k else 0.0]) for k in range(orders)]
    if not law.reaches_rest:
        return law.decay_taylor(np.zeros(1), orders)
    # high powers of ln s see bounces beyond all points: from a circle, which encloses no pole
    turn = np.exp(2j * math.pi * np.arange(64) / 64)
    found = np.fft.fft(law.decay_symbol(-0.5 * law.lowest_power * turn)).real / 64
    return [np.array([found[k] / (-0.5 * law.lowest_power) ** k]) for k in range(orders)]
