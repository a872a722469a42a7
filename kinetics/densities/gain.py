"""The gain G of the collisions: G(z+1) = lambda(z) G(z), lambda(z) = 1 - E[s^z cos(m chi)].

It takes the collisions out of the equation (:mod:`kinetics.densities.intertwining`). G is the
principal solution of its ladder, the one that grows least: from Re z = _TOP on by the
Euler-Maclaurin formula, and down from there by products.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.numerics.gauss import gauss_legendre

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

_TOP = 24
# B_2j/(2j)! times (2j-1)!, j = 1 ... 4: for Taylor coefficients instead of derivatives
_BERNOULLI = (1 / 12, -1 / 120, 1 / 252, -1 / 240)
_BETWEEN = 3  # Gauss points between two wave numbers
_NEGLIGIBLE = 1e-19  # weight of bounces that are left out

_TOGETHER = 256  # wave numbers of a piece: what the caches hold


def log_gain(law: CollisionLaw, k: FloatArray, m: int = 0) -> ComplexArray:
    """ln of z G(z), up to its limit at z = 0, for m = 0 and of G(z)/G(0) for others, at z = -i k.

    k equidistant from 0 on, shape (n,), spaced by less than 0.5 for an error of 1e-13. Branches
    are not followed: only exp of the result has a meaning. For e < 1.
    """
    if m == 0 and law.restitution == 0.0:
        return np.zeros(k.size, dtype=complex)  # lambda = z/(1 + z), G = 1/z
    q = law.quadrature_for(float(k[-1]), m)
    kept = q.weight > _NEGLIGIBLE * q.weight.max()
    xi, weight, turned = q.log_loss[kept], q.weight[kept], q.harmonic(m)[kept]
    rungs = np.arange(_TOP + 1.0)
    powers = np.exp(-np.multiply.outer(xi, rungs))
    # between two wave numbers, z + d: 1 - s^(z + d) = (1 - s^z) s^d + 1 - s^d
    node, between = gauss_legendre(_BETWEEN)
    step = k[1] - k[0]
    onward = powers[:, -1:] * np.exp(1j * np.multiply.outer(xi, step * node))
    orders = np.arange(1.0, 2 * len(_BERNOULLI))
    taylor = powers[:, -1:] * np.cumprod(-xi[:, None] / orders, axis=1)
    factors = (weight * turned)[:, None] * np.hstack([powers, onward.real, onward.imag, taylor])
    rate, real, imag, slopes = np.split(
        _averages(k, xi, factors), np.cumsum([rungs.size, _BETWEEN, _BETWEEN]), axis=1
    )
    # lambda on the real axis, each relative to itself
    on_axis = -weight @ np.expm1(-np.multiply.outer(xi, rungs))
    if m:
        on_axis = on_axis + (1.0 - turned) @ (weight[:, None] * powers)
    rate = rate + on_axis
    if m == 0:
        lowest = np.ones(k.size, dtype=complex)
        lowest[1:] = -1j * k[1:] * law.mean_log_loss / rate[1:, 0]
    else:
        lowest = rate[0, 0] / rate[:, 0]
    below = lowest * np.prod(rate[0, 1:-1] / rate[:, 1:-1], axis=1)
    # the integral of ln lambda from N up to N + z, and corrections at its end
    half = np.multiply.outer(xi, 0.5 * step * node)
    short = 2.0 * np.sin(half) * (np.sin(half) - 1j * np.cos(half))  # 1 - s^d
    along = (real + 1j * imag)[:-1] + (weight * turned * powers[:, -1]) @ short + on_axis[-1]
    value = np.zeros(k.size, dtype=complex)
    value[1:] = -1j * step * np.cumsum(np.log(along) @ between)
    # lambda' = -E[s^z (-xi)], and so on, s^z = 1 - (1 - s^z)
    slopes = slopes - factors[:, -orders.size :].sum(axis=0)
    end = _taylor_of_log([rate[:, -1], *slopes.T])
    value -= 0.5 * (end[0] - end[0][0])
    for bernoulli, coefficient in zip(_BERNOULLI, end[1::2], strict=True):
        value += bernoulli * (coefficient - coefficient[0])
    return np.asarray(value + np.log(below))


def _averages(k: FloatArray, xi: FloatArray, factors: FloatArray) -> ComplexArray:
    """Sums of (1 - s^z) times factors (points, columns), shape (n, columns).

    1 - s^z has its digits where it is small: from half angles k xi/2, and those as sums of two
    from short tables, which cost a tenth of a sine.
    """
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


def _taylor_of_log(c: list[ComplexArray]) -> list[ComplexArray]:
    """Taylor coefficients of the logarithm of a function with the coefficients c, each (n,)."""
    d = [np.log(c[0])]
    for n in range(1, len(c)):
        total = n * c[n]
        for i in range(1, n):
            total = total - i * d[i] * c[n - i]
        d.append(total / (n * c[0]))
    return d
