"""The gain G of the collisions: G(z+1) = lambda(z) G(z), lambda(z) = 1 - E[s^z cos(m chi)].

In space P_m(cos chi) stands for cos(m chi).

It takes the collisions out of the equation (:mod:`kinetics.densities.intertwining`). G is the
principal solution of its recurrence (:mod:`kinetics.numerics.recurrence`): on the line
Re z = _TOP by the Euler-Maclaurin formula, and from there down by products.
"""

from __future__ import annotations

import math

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.numerics import ComplexArray, FloatArray
from kinetics.numerics.gauss import gauss_legendre
from kinetics.numerics.recurrence import log_growth, taylor_of_log

# At this real part, with this many Taylor coefficients, the Euler-Maclaurin formula leaves
# 2 * 8!/((2 pi)^10 24^9) = 3e-16 (see `log_growth`).
_TOP, _ORDERS = 24, 8
# Gauss points between two wave numbers, h < 0.5 apart: they leave (3!)^4/(7 (6!)^3) h^7 = 4e-9 of
# the sixth derivative of ln lambda, which is about 5!/24^6 = 6e-7.
_BETWEEN = 3
_NEGLIGIBLE = 1e-19  # bounces of less weight than this are left out: it is below rounding
_TOGETHER = 256  # wave numbers whose tables fit into the cache; it changes no result


def log_gain(law: CollisionLaw, k: FloatArray, m: int = 0, tilt: float = 0.0) -> ComplexArray:
    """ln of G(z)/G(tilt) at z = tilt - i k; for m = 0 without tilt of z G(z), over its limit at 0.

    k : equidistant from 0 on, shape (n,), spaced by less than 0.5 for an error of 1e-13
    law : one that loses energy

    Shape (n,). Branches are not followed: only exp of the result has a meaning.
    """
    if m == 0 and law.uniform_power == 1.0:
        # lambda = z/(1 + z), G = 1/z
        return -np.log(1.0 - 1j * k / tilt) if tilt else np.zeros(k.size, dtype=complex)
    q = law.quadrature_for(float(k[-1]), m)
    kept = q.weight > _NEGLIGIBLE * q.weight.max()
    xi, weight, turned = q.log_loss[kept], q.weight[kept], q.harmonic(m)[kept]
    steps = tilt + np.arange(_TOP + 1.0)
    powers = np.exp(-np.multiply.outer(xi, steps))
    # between two wave numbers, z + d: 1 - s^(z + d) = (1 - s^z) s^d + 1 - s^d
    node, between = gauss_legendre(_BETWEEN)
    step = k[1] - k[0]
    onward = powers[:, -1:] * np.exp(1j * np.multiply.outer(xi, step * node))
    orders = np.arange(1.0, _ORDERS)
    taylor = powers[:, -1:] * np.cumprod(-xi[:, None] / orders, axis=1)
    factors = (weight * turned)[:, None] * np.hstack([powers, onward.real, onward.imag, taylor])
    rate, real, imag, slopes = np.split(
        _averages(k, xi, factors), np.cumsum([steps.size, _BETWEEN, _BETWEEN]), axis=1
    )
    # lambda on the real axis, each relative to itself
    on_axis = -weight @ np.expm1(-np.multiply.outer(xi, steps))
    if m:
        on_axis = on_axis + (1.0 - turned) @ (weight[:, None] * powers)
    rate = rate + on_axis
    below_top = law.met_again(steps - 1j * k[:, None], rate, m)
    if m == 0 and not tilt:
        lowest = np.ones(k.size, dtype=complex)
        lowest[1:] = -1j * k[1:] * law.mean_log_loss / below_top[1:, 0]
    else:
        lowest = below_top[0, 0] / below_top[:, 0]
    below = lowest * np.prod(below_top[0, 1:-1] / below_top[:, 1:-1], axis=1)
    # the integral of ln lambda from N up to N + z, and corrections at its end
    half = np.multiply.outer(xi, 0.5 * step * node)
    short = 2.0 * np.sin(half) * (np.sin(half) - 1j * np.cos(half))  # 1 - s^d
    along = (real + 1j * imag)[:-1] + (weight * turned * powers[:, -1]) @ short + on_axis[-1]
    along = law.met_again(steps[-1] - 1j * (k[:-1, None] + step * node), along, m)
    integral = np.zeros(k.size, dtype=complex)
    integral[1:] = -1j * step * np.cumsum(np.log(along) @ between)
    # lambda' = -E[s^z (-xi)], and so on, s^z = 1 - (1 - s^z)
    slopes = slopes - factors[:, -orders.size :].sum(axis=0)
    end = taylor_of_log(law.taylor_met_again(steps[-1] - 1j * k, [rate[:, -1], *slopes.T], m))
    return np.asarray(log_growth(integral, [c[0] for c in end], end) + np.log(below))


def _averages(k: FloatArray, xi: FloatArray, factors: FloatArray) -> ComplexArray:
    """Sums of (1 - s^z) times factors (points, columns), shape (n, columns)."""
    stride = math.ceil(math.sqrt(k.size))
    far = np.multiply.outer(0.5 * k[::stride], xi)[:, None]
    near = np.multiply.outer(0.5 * k[:stride], xi)
    sin_near, cos_near = np.sin(near), np.cos(near)
    out = np.empty((far.shape[0] * stride, factors.shape[1]), dtype=complex)
    piece = max(1, _TOGETHER // stride)
    for first in range(0, far.shape[0], piece):
        sin_far, cos_far = np.sin(far[first : first + piece]), np.cos(far[first : first + piece])
        sine = (sin_far * cos_near + cos_far * sin_near).reshape(-1, xi.size)
        cosine = (cos_far * cos_near - sin_far * sin_near).reshape(-1, xi.size)
        rows = slice(first * stride, first * stride + sine.shape[0])
        out.real[rows] = (2.0 * sine * sine) @ factors
        out.imag[rows] = (-2.0 * sine * cosine) @ factors
    return out[: k.size]
