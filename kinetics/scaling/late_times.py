r"""How many collisions a cooling tracer has had at late times, and how far it has flown.

s is the speed ratio of a collision. With phi(p) = E[s^p], from the speed v = 1 and with the mean
free path l = 1, the number N of collisions obeys

    d/dt E[z^N v^p] = -(1 - z phi(p)) E[z^N v^(p+1)],

and E[z^N(t)] = sum_k (-t)^k/k! c(k), c the principal solution of c(p+1) = (1 - z phi(p)) c(p) with
c(0) = 1 (:mod:`kinetics.numerics.recurrence`). This is the Mellin transform Gamma(p) c(-p), whose
first pole on the right is at -p = theta, phi(theta) = 1/z: hence

    E[z^N(t)] ~ C t^theta,     C = Gamma(-theta) c(1 + theta)/(-z phi'(theta)).

E[exp(-q X)] of the path X is the same with z = 1/(1 + q). Begin with :func:`power_of_time`.
"""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.numerics import FOLDS, LARGEST_LOG, FloatArray
from kinetics.numerics.recurrence import MOST_ORDERS, log_growth, taylor_of_log
from kinetics.scaling.log_moments import SMOOTH_FROM, integrate_log_ratio

#: Largest |theta| that is looked for. Chosen: t^theta is beyond double precision at any t.
MAX_POWER_OF_TIME = 1000.0
#: Distance from an integer j below which (phi(theta) - phi(j))/(j - theta) is summed, not
#: subtracted: otherwise digits cancel. Chosen: at this distance subtraction loses a digit or two.
SUMMED_WITHIN = 0.05
#: Imaginary step of the derivative of phi. Chosen: its square is nothing beside 1.
IMAGINARY_STEP = 1e-20
#: Points of the circle on which lambda is sampled for its Taylor coefficients. It has half the
#: radius of convergence: of the 12 coefficients the first that is aliased is 2^-64 as large, by
#: which it is derived.
POINTS_ON_CIRCLE = 64


def power_of_time(law: CollisionLaw, z: float) -> float | None:
    """Return theta with phi(theta) = 1/z.

    It is None beyond +-`MAX_POWER_OF_TIME`, and where phi is 1/z nowhere.
    """
    from scipy.optimize import brentq

    decay_rate = (z - 1.0) / z  # lambda(theta)

    def excess(p: float) -> float:
        """Return lambda(p) - lambda(theta), which rises with p."""
        return float(law.decay_rate(p)) - decay_rate

    low = 0.0
    high = 1.0
    if z < 1.0:
        low = _lowest_power_of_time(law)
        high = 0.0
    while z > 1.0 and excess(high) < 0.0 and high < MAX_POWER_OF_TIME:
        low = high
        high = min(2.0 * high, MAX_POWER_OF_TIME)
    if excess(low) > 0.0 or excess(high) < 0.0:
        return None
    return float(brentq(excess, low, high, xtol=1e-300, rtol=1e-15, maxiter=500))


def _lowest_power_of_time(law: CollisionLaw) -> float:
    """Return the smallest p at which E[s^p] exists and does not overflow, -1000 at least."""
    deepest_loss = float(law.quadrature.log_loss.max())
    overflows_below = (FOLDS - LARGEST_LOG) / deepest_loss
    just_above_lowest = law.lowest_power * (1.0 - 1e-12)
    return max(-MAX_POWER_OF_TIME, overflows_below, just_above_lowest)


def log_amplitude(law: CollisionLaw, z: float, theta: float) -> float:
    """Return ln C of E[z^N(t)] ~ C t^theta.

    The product that leads from c(0) to c(1 + theta) is taken factor by factor: every factor is
    positive, as the poles of Gamma(-theta) cancel with zeros of 1 - z phi.
    """
    n_steps = math.ceil(SMOOTH_FROM + max(theta, 0.0))
    powers = np.arange(float(n_steps))
    slopes = _slopes_of_ratio(law, theta, powers)
    numerator = np.log(z * slopes).sum() + math.lgamma(n_steps - theta)
    denominator = _log_kept(law, z, powers + 1.0 + theta).sum()
    begin = np.array([float(n_steps)])
    end = np.array([n_steps + 1.0 + theta])
    integral = integrate_log_ratio(partial(_log_kept, law, z), law, float(n_steps), end)
    growth = log_growth(
        integral, _taylor_of_log_kept(law, z, begin), _taylor_of_log_kept(law, z, end)
    )
    # the derivative along the imaginary axis, without cancellation: -phi'(theta) = lambda'(theta)
    beside = law.decay_symbol(np.array([theta + 1j * IMAGINARY_STEP]))
    slope_at_theta = float(beside[0].imag) / IMAGINARY_STEP
    return float(numerator - denominator + float(growth[0]) - math.log(z * slope_at_theta))


def _slopes_of_ratio(law: CollisionLaw, theta: float, powers: FloatArray) -> FloatArray:
    """Return (phi(theta) - phi(j))/(j - theta) for the powers j = 0, 1, ..., shape (n,)."""
    rate = law.decay_rate(np.append(powers, theta))
    is_near = np.abs(powers - theta) < SUMMED_WITHIN
    distance = np.where(is_near, 1.0, powers - theta)
    slopes = (rate[:-1] - rate[-1]) / distance
    if np.any(is_near):
        q = law.quadrature_for(powers.size)
        step = float((powers - theta)[is_near][0])
        change = -np.expm1(-step * q.log_loss) / step if step else q.log_loss
        slopes[is_near] = (q.weight * np.exp(-theta * q.log_loss)) @ change
    return np.asarray(slopes)


def _log_kept(law: CollisionLaw, z: float, p: FloatArray) -> FloatArray:
    """Return ln(1 - z phi(p)), shape of p."""
    return np.asarray(np.log((1.0 - z) + z * law.decay_rate(p)))


def _taylor_of_log_kept(law: CollisionLaw, z: float, p: FloatArray) -> list[FloatArray]:
    """Return the Taylor coefficients of ln(1 - z phi) at p (n,), each of shape (n,)."""
    rate, *higher = law.decay_taylor(p, MOST_ORDERS)
    of_log = taylor_of_log([(1.0 - z) + z * rate, *(z * c for c in higher)])
    return [np.asarray(c, dtype=float) for c in of_log]


# -- cumulants -------------------------------------------------------------------------------------


def path_cumulants(law: CollisionLaw, n: int) -> FloatArray:
    """Return the first n cumulants of the path X in l, per ln t, shape (n,).

    E[exp(u X)] ~ t^theta with lambda(theta) = u.
    """
    return _cumulants(_taylor_of_rate_at_zero(law, n + 1))


def collision_cumulants(law: CollisionLaw, n: int) -> FloatArray:
    """Return the first n cumulants of the number N of collisions, per ln t, shape (n,).

    E[exp(u N)] ~ t^theta with -ln(1 - lambda(theta)) = u.
    """
    rate = _taylor_of_rate_at_zero(law, n + 1)
    of_log_ratio = taylor_of_log([np.ones(1), *(-c for c in rate[1:])])
    return _cumulants([-np.asarray(c, dtype=float) for c in of_log_ratio])


def _cumulants(u_of_theta: list[FloatArray]) -> FloatArray:
    """Return k! times the coefficients of the series of theta in u, k = 1 ... n, shape (n,).

    Parameters
    ----------
    u_of_theta : Taylor coefficients of u in theta, of the orders 0 (which is 0) to n, each (1,)

    Notes
    -----
    The series is reverted by Lagrange's formula: its k-th coefficient is that of theta^(k-1) in
    (theta/u)^k, over k.
    """
    n = len(u_of_theta) - 1
    ratio = np.array([float(c[0]) for c in u_of_theta[1:]])  # u/theta
    inverse = np.zeros(n)  # theta/u
    inverse[0] = 1.0 / ratio[0]
    for k in range(1, n):
        inverse[k] = -(ratio[1 : k + 1] @ inverse[k - 1 :: -1]) / ratio[0]
    power = np.eye(1, n)[0]
    cumulants = np.zeros(n)
    for k in range(1, n + 1):
        power = np.convolve(power, inverse)[:n]
        cumulants[k - 1] = math.factorial(k - 1) * power[k - 1]
    return cumulants


def _taylor_of_rate_at_zero(law: CollisionLaw, n_orders: int) -> list[FloatArray]:
    """Return the Taylor coefficients of lambda at 0, orders 0 to n_orders - 1, each (1,)."""
    q = law.uniform_power
    if q is not None:  # lambda = z/(z + q)
        higher = [np.array([-((-1.0 / q) ** k)]) for k in range(1, n_orders)]
        return [np.zeros(1), *higher]
    if not law.reaches_rest:
        return law.decay_taylor(np.zeros(1), n_orders)
    # high powers of ln s see bounces beyond all points: from a circle, which encloses no pole
    radius = -0.5 * law.lowest_power
    circle = np.exp(2j * math.pi * np.arange(POINTS_ON_CIRCLE) / POINTS_ON_CIRCLE)
    coefficients = np.fft.fft(law.decay_symbol(radius * circle)).real / POINTS_ON_CIRCLE
    return [np.array([coefficients[k] / radius**k]) for k in range(n_orders)]
