r"""ln A(z), A(z) = kappa^z E[Y^z], of the scaled speed Y = v t/l for any real or complex power z.

v is the speed, t the time, l the mean free path, s the speed ratio of a collision and kappa = E[-ln
s]. With the decay rate lambda(z) = 1 - E[s^z] of the law,

    ln A(z+1) = ln A(z) + rho(z),     rho(z) = ln(kappa z/lambda(z)),     A(0) = A(1) = 1,

of which ln A is the principal solution (:mod:`kinetics.numerics.recurrence`): far to the right,
where rho is smooth, the formula of Euler and Maclaurin gives it, and the recurrence itself leads
back to z. Begin with :func:`log_moment`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.numerics import ROUNDING, ComplexArray, FloatArray
from kinetics.numerics.gauss import gauss_legendre, panels_between
from kinetics.numerics.recurrence import MOST_ORDERS, log_growth, taylor_of_log

#: Re z from which on the formula of Euler and Maclaurin is used, and its distance from the zeros of
#: lambda. Derived: with 12 Taylor coefficients it leaves 2 * 12!/((2 pi)^14 16^13) = 1e-18.
SMOOTH_FROM = 16
#: Smallest |z| at which rho is computed; below, it is 0. Derived: kappa z would underflow.
MIN_POWER = 1e-290
#: Gauss points for the integral of rho over one step of a vertical line. Chosen: at half and at
#: twice as many F moves by 7e-15 (e from 0 to 0.99).
POINTS_ON_STEP = 10
#: Gauss points for the integral of ln r over a panel of half the distance to its singularities.
#: Derived: they lie on a Bernstein ellipse of 8 or more, which leaves 8^-24 = 2e-22.
POINTS_ON_PANEL = 12

Numbers = TypeVar("Numbers", FloatArray, ComplexArray)


def small_deviation(law: CollisionLaw) -> float:
    """Return the root of E[xi^2]/(2 kappa), xi = -ln s.

    It is the standard deviation of x = ln(kappa v t/l) where that is small.
    """
    q = law.quadrature
    return math.sqrt(float(q.weight @ q.log_loss**2) / (2.0 * law.mean_log_loss))


def log_second_moment(law: CollisionLaw) -> float:
    """Return ln A(2) = ln(kappa/lambda(1)) < ln 2: nearly the variance of x where that is small."""
    kappa = law.mean_log_loss
    if law.energy_loss < math.sqrt(ROUNDING):
        # kappa - lambda(1) = E[xi^2]/2 + what returns add, xi = -ln s: else only rounding is left
        q = law.quadrature
        of_returns = law.returns(0)[0] * kappa
        return float(q.weight @ q.log_loss**2) / (2.0 * kappa) + of_returns
    return math.log(kappa / float(law.decay_rate(1.0)))


def log_moment(law: CollisionLaw, z: FloatArray) -> FloatArray:
    """Return ln A(z) for real z, shape (n,)."""
    is_far_left = z < -SMOOTH_FROM
    if np.any(is_far_left) and not np.all(is_far_left):
        # they may need fewer steps of the recurrence
        log_a = np.empty(z.shape)
        log_a[is_far_left] = log_moment(law, z[is_far_left])
        log_a[~is_far_left] = log_moment(law, z[~is_far_left])
        return log_a
    n_steps = _steps_to_smooth(law, float(z.min()))
    # the recurrence leads from 0 up to n_steps, and from z + n_steps down to z
    starts = np.append(0.0, z)
    steps = _log_ratio(law, starts[:, None] + np.arange(float(n_steps))).sum(axis=1)
    ends = starts + n_steps
    taylor = _taylor_of_log_ratio(law, ends, law.decay_taylor(ends, MOST_ORDERS))
    integral = integrate_log_ratio(partial(_log_ratio, law), law, float(n_steps), ends[1:])
    growth = log_growth(integral, [c[:1] for c in taylor], [c[1:] for c in taylor])
    return np.asarray(steps[0] + growth - steps[1:])


def log_moment_along_line(
    law: CollisionLaw, begin: complex, step: float, count: int
) -> ComplexArray:
    """Return ln of A(begin + i n step)/A(begin), n = 0 ... count - 1, shape (count,)."""
    z = np.array(begin + 1j * step * np.arange(count), dtype=np.complex128)
    n_steps = _steps_to_smooth(law, begin.real, float(z[-1].imag))
    node, weight = gauss_legendre(POINTS_ON_STEP)
    # of each z: the steps of the recurrence, Gauss points up to the next z at its end, the end
    offsets = np.concatenate([np.arange(n_steps), n_steps + 1j * step * node, [n_steps]])
    rates, taylor_of_rate = law.decay_rates(z, offsets, MOST_ORDERS)
    log_ratio = np.log(law.mean_log_loss * (z[1:, None] + offsets) / rates[1:])
    # at the beginning itself, sums of powers might lose their digits next to z = 0
    log_ratio = np.concatenate([_log_ratio(law, begin + offsets)[None], log_ratio])
    integrals = 1j * step * np.cumsum(log_ratio[:-1, n_steps:-1] @ weight)
    taylor = _taylor_of_log_ratio(law, z + n_steps, taylor_of_rate)
    growth = log_growth(np.append(0.0, integrals), [c[0] for c in taylor], taylor)
    steps = log_ratio[:, :n_steps].sum(axis=1)
    return np.asarray(growth - steps + steps[0])


def integrate_log_ratio(
    log_ratio: Callable[[FloatArray], FloatArray], law: CollisionLaw, low: float, high: FloatArray
) -> FloatArray:
    """Return integrals of ln r along the real axis, where it is smooth, from low to each high.

    Parameters
    ----------
    log_ratio : ln r, which is singular where lambda of this law has zeros, or nowhere nearer
    high : shape (n,), as the integrals
    """
    # ln r is analytic within about SMOOTH_FROM of the path, or 2 pi over the largest loss if that
    # is further and the lowest power as well: panels are half as long
    first = min(low, float(high.min()))
    last = max(low, float(high.max()))
    edges = [first]
    while edges[-1] < last:
        to_lowest_power = edges[-1] - law.lowest_power
        distance = max(SMOOTH_FROM, min(2.0 / law.largest_loss, to_lowest_power))
        edges.append(min(edges[-1] + 0.5 * distance, last))
    ends = np.unique(np.concatenate([edges, [low], high]))
    nodes, weights = panels_between(ends, POINTS_ON_PANEL)
    of_panels = (weights * log_ratio(nodes)).reshape(-1, POINTS_ON_PANEL).sum(axis=1)
    sums = np.cumsum(np.append(0.0, of_panels))
    return np.asarray(sums[np.searchsorted(ends, high)] - sums[np.searchsorted(ends, low)])


def _log_ratio(law: CollisionLaw, z: Numbers) -> Numbers:
    """Return rho(z) = ln(kappa z/lambda(z)), shape of z; 0 at z = 0."""
    is_zero = np.abs(z) < MIN_POWER
    safe = np.where(is_zero, 1.0, z)
    ratio = law.mean_log_loss * safe / law.decay_rate(safe)
    return np.asarray(np.where(is_zero, 0.0, np.log(ratio)))


def _taylor_of_log_ratio(law: CollisionLaw, z: Numbers, rate: list[NDArray[Any]]) -> list[Numbers]:
    """Return the Taylor coefficients of rho at z, up to order 11, each of shape (n,).

    Parameters
    ----------
    z : shape (n,)
    rate : the Taylor coefficients of lambda at z
    """
    q = law.uniform_power
    if q is not None:  # rho = ln(1 + z/q)
        coefficients = [np.log1p(z / q)]
        for n in range(1, MOST_ORDERS):
            coefficients.append(-((-1.0 / (q + z)) ** n) / n)
        return coefficients
    log_of_rate = taylor_of_log([c / rate[0] for c in rate])  # lambda < 0 for z < 0
    powers = np.cumprod(np.broadcast_to(-1.0 / z, (MOST_ORDERS - 1, z.size)), axis=0)
    coefficients = [np.log(law.mean_log_loss * z / rate[0])]
    for n in range(1, MOST_ORDERS):
        coefficients.append(-powers[n - 1] / n - log_of_rate[n])
    return coefficients


def _steps_to_smooth(law: CollisionLaw, a: float, height: float = 0.0) -> int:
    """Return how many steps of the recurrence lead from Re z = a to where rho is smooth.

    Parameters
    ----------
    a : the real part of z
    height : its largest imaginary part
    """
    is_small_loss = law.largest_loss < math.log(2.0)
    is_far_left = a < -SMOOTH_FROM and a - law.lowest_power > 2.0 * SMOOTH_FROM
    if not (is_small_loss and is_far_left):
        return max(SMOOTH_FROM, math.ceil(SMOOTH_FROM - a))
    # the zeros of lambda nearest to the line are about 2 pi/largest loss above the real axis
    distance = 2.0 * math.pi / law.largest_loss - height
    return 1 if distance > SMOOTH_FROM + 1.0 else math.ceil(SMOOTH_FROM - a)
