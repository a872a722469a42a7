"""The gain G of the collisions: G(z+1) = lambda(z) G(z), lambda(z) = 1 - E[s^z cos(m chi)].

It takes the collisions out of the equation (:mod:`kinetics.intertwining`). G is the principal
solution of its ladder, the one that grows least: from Re z = _TOP on by the Euler-Maclaurin
formula, and down from there by products.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw, gauss_legendre

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

_TOP = 24
# B_2j/(2j)! times (2j-1)!, j = 1 ... 4: for Taylor coefficients instead of derivatives
_BERNOULLI = (1 / 12, -1 / 120, 1 / 252, -1 / 240)
_BETWEEN = 3  # Gauss points between two wave numbers
_NEGLIGIBLE = 1e-19  # weight of bounces that are left out

Average = Callable[[FloatArray], ComplexArray]


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
    # 1 - s^z with its digits where it is small: half angles of k xi
    half = np.sin(np.multiply.outer(0.5 * k, xi))
    lost = np.concatenate([2.0 * half * half, -2.0 * half * np.cos(np.multiply.outer(0.5 * k, xi))])

    def average(factor: FloatArray) -> ComplexArray:
        """E[(1 - s^z) cos(m chi) factor], shape (n, columns)."""
        both = lost @ ((weight * turned)[:, None] * factor)
        return np.asarray(both[: k.size] + 1j * both[k.size :])

    rungs = np.arange(_TOP + 1.0)
    powers = np.exp(-np.multiply.outer(xi, rungs))
    real = (1.0 - turned) @ (weight[:, None] * powers) if m else np.zeros(rungs.size)
    real = real - weight @ np.expm1(-np.multiply.outer(xi, rungs))
    rate = average(powers) + real  # lambda(z + n), each relative to itself
    lowest = np.ones(k.size, dtype=complex)
    if m == 0:
        lowest[1:] = -1j * k[1:] * law.mean_log_loss / rate[1:, 0]
    else:
        lowest = rate[0, 0] / rate[:, 0]
    below = lowest * np.prod(rate[0, 1:-1] / rate[:, 1:-1], axis=1)
    top = powers[:, -1]
    value = _integral(average, k[1] - k[0], xi, weight * turned, top, real[-1])
    end = _taylor_of_log(rate[:, -1], average, xi, weight * turned, top)
    value -= 0.5 * (end[0] - end[0][0])
    for bernoulli, coefficient in zip(_BERNOULLI, end[1::2], strict=True):
        value += bernoulli * (coefficient - coefficient[0])
    return np.asarray(value + np.log(below))


def _integral(
    average: Average, step: float, xi: FloatArray, weight: FloatArray, top: FloatArray, real: float
) -> ComplexArray:
    """Of ln lambda from N up to N + z, shape (n,)."""
    node, w = gauss_legendre(_BETWEEN)
    angle = np.multiply.outer(xi, step * node)
    # between two wave numbers s^(z + d) = s^z s^d, 1 - s^(z + d) = (1 - s^z) s^d + 1 - s^d
    onward = top[:, None] * np.concatenate([np.cos(angle), np.sin(angle)], axis=1)
    parts = average(onward)
    along = parts[:-1, :_BETWEEN] + 1j * parts[:-1, _BETWEEN:]
    half = np.sin(0.5 * angle)
    along += (weight * top) @ (2.0 * half * (half - 1j * np.cos(0.5 * angle))) + real
    out = np.zeros(parts.shape[0], dtype=complex)
    out[1:] = -1j * step * np.cumsum(np.log(along) @ w)
    return out


def _taylor_of_log(
    rate: ComplexArray, average: Average, xi: FloatArray, weight: FloatArray, top: FloatArray
) -> list[NDArray[Any]]:
    """Taylor coefficients of ln lambda at N + z, orders 0 to 7, each (n,)."""
    orders = np.arange(1.0, 2 * len(_BERNOULLI))
    factor = top[:, None] * np.cumprod(-xi[:, None] / orders, axis=1)
    # lambda' = -E[s^z (-xi)], and so on, s^z = 1 - (1 - s^z)
    c = [rate, *(average(factor) - weight @ factor).T]
    d: list[NDArray[Any]] = [np.log(rate)]
    for n in range(1, len(c)):
        total = n * c[n]
        for i in range(1, n):
            total = total - i * d[i] * c[n - i]
        d.append(total / (n * rate))
    return d
