r"""The gain G of the collisions, which takes them out of the equation of a harmonic.

It is the principal solution of G(z+1) = lambda_m(z) G(z), where lambda_m(z) = 1 - E[s^z cos(m chi)]
is the decay rate of the power z of the speed (m the angular harmonic, s the speed ratio and chi the
deflection of a collision), needed along a vertical line, z = tilt - i k, k the wave number of ln v.
Far to the right, at z + N, Euler and Maclaurin give ln G (:mod:`kinetics.numerics.recurrence`);
from there N steps of the recurrence, a ladder, lead down to z. Begin with :func:`log_gain`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.numerics import FOLDS, ComplexArray, FloatArray
from kinetics.numerics.gauss import gauss_legendre
from kinetics.numerics.recurrence import log_growth, taylor_of_log

#: N, the number of steps of the ladder. Derived: with `ORDERS` Taylor coefficients the
#: Euler-Maclaurin formula leaves 2 * 8!/((2 pi)^10 24^9) = 3e-16 (see `log_growth`).
STEPS_OF_LADDER = 24
#: Number of Taylor coefficients of ln lambda at the top of the ladder, from order 0 on. Derived
#: with `STEPS_OF_LADDER`.
ORDERS = 8
#: Gauss points between two wave numbers. Derived: h < 0.5 apart, three leave
#: (3!)^4/(7 (6!)^3) h^7 = 4e-9 of the sixth derivative of ln lambda, about 5!/24^6 = 6e-7.
POINTS_BETWEEN = 3
#: Numbers of a piece of a table that stay in the cache of the processor. Origin not recorded; it
#: changes no result.
NUMBERS_IN_CACHE = 20_000


def log_gain(law: CollisionLaw, k: FloatArray, m: int = 0, tilt: float = 0.0) -> ComplexArray:
    """Return ln of the gain along z = tilt - i k, normalised at z = tilt.

    Parameters
    ----------
    law : a law that loses energy
    k : wave numbers, equidistant from 0 on, shape (n,), less than 0.5 apart for an error of 1e-13
    m : number of the harmonic
    tilt : real part of z, 0 or more

    Returns
    -------
    ln of G(z)/G(tilt); for m = 0 without tilt, where G has a pole at z = 0, of z G(z) over its
    limit at 0. Branches are not followed: only exp of the result has a meaning. Shape (n,).
    """
    if m == 0 and law.uniform_power == 1.0:
        return _log_gain_of_uniform_ratios(k, tilt)
    real_parts = tilt + np.arange(STEPS_OF_LADDER + 1.0)
    rates = _LadderRates.of(_Bounces.of(law, float(k[-1]), m), k, real_parts)
    on_ladder = law.met_again(real_parts - 1j * k[:, None], rates.on_ladder, m)
    if m == 0 and not tilt:
        # z/lambda(z), with its limit at z = 0
        lowest_step = np.ones(k.size, dtype=complex)
        lowest_step[1:] = -1j * k[1:] * law.mean_log_loss / on_ladder[1:, 0]
    else:
        lowest_step = on_ladder[0, 0] / on_ladder[:, 0]
    higher_steps = np.prod(on_ladder[0, 1:-1] / on_ladder[:, 1:-1], axis=1)
    ladder = lowest_step * higher_steps
    # from the top of the real axis along the top of the ladder
    top = real_parts[-1]
    node, between_weight = gauss_legendre(POINTS_BETWEEN)
    step = k[1] - k[0]
    z_between = top - 1j * (k[:-1, None] + step * node)
    rate_between = law.met_again(z_between, rates.between, m)
    integral = np.zeros(k.size, dtype=complex)
    integral[1:] = -1j * step * np.cumsum(np.log(rate_between) @ between_weight)
    taylor_of_rate = [rates.on_ladder[:, -1], *rates.taylor.T]
    taylor = taylor_of_log(law.taylor_met_again(top - 1j * k, taylor_of_rate, m))
    taylor_at_axis = [coefficient[0] for coefficient in taylor]
    return np.asarray(log_growth(integral, taylor_at_axis, taylor) + np.log(ladder))


def _log_gain_of_uniform_ratios(k: FloatArray, tilt: float) -> ComplexArray:
    """Return the same where all ratios s are equally likely: lambda = z/(1 + z), G = 1/z."""
    if tilt:
        return -np.log(1.0 - 1j * k / tilt)
    return np.zeros(k.size, dtype=complex)


@dataclass(frozen=True)
class _Bounces:
    """The collisions as weighted losses, shape (n_points,) each.

    Parameters
    ----------
    log_loss : -ln s
    weight : sums to 1
    cosine : cos(m chi)
    """

    log_loss: FloatArray
    weight: FloatArray
    cosine: FloatArray

    @classmethod
    def of(cls, law: CollisionLaw, largest_wave_number: float, m: int) -> _Bounces:
        """Return as many points as resolve s^(-i k), without those of negligible weight."""
        points = law.quadrature_for(largest_wave_number, m)
        counts = points.weight > math.exp(-FOLDS) * points.weight.max()
        cosine = 1.0 - points.harmonic_loss(m)[counts]
        return cls(points.log_loss[counts], points.weight[counts], cosine)

    def decay_rates(self, real_parts: FloatArray, powers: FloatArray) -> FloatArray:
        """Return lambda on the real axis, each one right relative to itself.

        Parameters
        ----------
        real_parts : z, shape (n_z,)
        powers : s^z, shape (n_points, n_z)
        """
        rates = -self.weight @ np.expm1(-np.multiply.outer(self.log_loss, real_parts))
        if np.any(self.cosine != 1.0):
            rates = rates + (1.0 - self.cosine) @ (self.weight[:, None] * powers)
        return np.asarray(rates)


@dataclass(frozen=True)
class _LadderRates:
    """lambda where the formula of Euler and Maclaurin needs it, without returns in a medium.

    Parameters
    ----------
    on_ladder : at all steps of the ladder, for all wave numbers, shape (n_k, n_steps)
    between : at the top, at Gauss points between neighbouring wave numbers, (n_k - 1, n_points)
    taylor : Taylor coefficients at the top, from order 1 on, shape (n_k, ORDERS - 1)
    """

    on_ladder: ComplexArray
    between: ComplexArray
    taylor: ComplexArray

    @classmethod
    def of(cls, bounces: _Bounces, k: FloatArray, real_parts: FloatArray) -> _LadderRates:
        """Average over the bounces, for z = real_parts - i k."""
        log_loss = bounces.log_loss
        powers = np.exp(-np.multiply.outer(log_loss, real_parts))
        top_power = powers[:, -1:]
        node, _ = gauss_legendre(POINTS_BETWEEN)
        step = k[1] - k[0]
        # s^d on the way to the next wave number, z + d
        onward = top_power * np.exp(1j * np.multiply.outer(log_loss, step * node))
        orders = np.arange(1.0, ORDERS)
        taylor = top_power * np.cumprod(-log_loss[:, None] / orders, axis=1)
        columns = np.hstack([powers, onward.real, onward.imag, taylor])
        turned_weight = bounces.weight * bounces.cosine
        factors = turned_weight[:, None] * columns
        ends = np.cumsum([real_parts.size, node.size, node.size])
        sums = _oscillating_sums(k, log_loss, factors)
        sums_of_powers, sums_real, sums_imag, sums_of_taylor = np.split(sums, ends, axis=1)
        rates_on_axis = bounces.decay_rates(real_parts, powers)
        # 1 - s^(z + d) = (1 - s^z) s^d + 1 - s^d, the last with the digits of a sine
        half_angle = np.multiply.outer(log_loss, 0.5 * step * node)
        one_less_onward = 2.0 * np.sin(half_angle) * (np.sin(half_angle) - 1j * np.cos(half_angle))
        towards_next = (turned_weight * powers[:, -1]) @ one_less_onward
        return cls(
            on_ladder=sums_of_powers + rates_on_axis,
            between=(sums_real + 1j * sums_imag)[:-1] + towards_next + rates_on_axis[-1],
            # lambda' = -E[s^z (-xi)], and so on, s^z = 1 - (1 - s^z)
            taylor=sums_of_taylor - factors[:, -orders.size :].sum(axis=0),
        )


def _oscillating_sums(k: FloatArray, log_loss: FloatArray, factors: FloatArray) -> ComplexArray:
    """Return the sums over bounces of (1 - s^(-i k)) times factors.

    Half angles, where 1 - s^(-i k) keeps its digits, are sums of two from short tables: without
    these, densities took 1.1 to 1.3 of the time (commit 05ee8442).

    Parameters
    ----------
    k : wave numbers, equidistant from 0 on, shape (n_k,)
    log_loss : -ln s, shape (n_points,)
    factors : shape (n_points, n_columns)

    Returns
    -------
    The sums, shape (n_k, n_columns).
    """
    stride = math.ceil(math.sqrt(k.size))
    coarse_angle = np.multiply.outer(0.5 * k[::stride], log_loss)[:, None]
    fine_angle = np.multiply.outer(0.5 * k[:stride], log_loss)
    fine_sine = np.sin(fine_angle)
    fine_cosine = np.cos(fine_angle)
    n_coarse = coarse_angle.shape[0]
    sums = np.empty((n_coarse * stride, factors.shape[1]), dtype=complex)
    n_at_once = max(1, NUMBERS_IN_CACHE // (stride * log_loss.size))
    for begin in range(0, n_coarse, n_at_once):
        angle = coarse_angle[begin : begin + n_at_once]
        coarse_sine = np.sin(angle)
        coarse_cosine = np.cos(angle)
        sine = coarse_sine * fine_cosine + coarse_cosine * fine_sine
        cosine = coarse_cosine * fine_cosine - coarse_sine * fine_sine
        sine = sine.reshape(-1, log_loss.size)
        cosine = cosine.reshape(-1, log_loss.size)
        rows = slice(begin * stride, begin * stride + sine.shape[0])
        sums.real[rows] = (2.0 * sine * sine) @ factors
        sums.imag[rows] = (-2.0 * sine * cosine) @ factors
    return sums[: k.size]
