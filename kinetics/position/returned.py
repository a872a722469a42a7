r"""Tracers that bounces straight back have led to the origin again, at a finite density.

At a finite density (`kinetics.collision.medium`) collisions change a_m by

    psi = (K - 1)/(1 - eps S (K - 1)) a,      S f(X) = f(X + ln e),

K one collision and eps with the sign (-1)^m of a bounce straight back. Tracers that are only thrown
straight back stay on a line through the origin, so that F falls as 1/k.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.numerics import FloatArray

# Talbot's inversion of Laplace transforms (Weideman, SIAM J. Numer. Anal. 44 (2006) 2342): so many
# points leave 1e-10 of functions that fall. Chains of more bounces back weigh less than that.
_TALBOT, _MOST_BACK, _LEAST_BACK = 20, 20, 1e-11
_FALLEN = 60.0  # 2 e T/(1 + e) beyond which the density is below e^-60


def density_at_origin(law: CollisionLaw, path: FloatArray) -> FloatArray:
    """Of tracers on the line of their first flight that were only thrown straight back, at 0.

    path : T = v t/l, shape (n,). Per unit of l on the line, with the signs of the operator, so that
    F(k) tends to 2/K times it; without the tracers that have not collided. Shape (n,).

    After j bounces back a tracer has the speed e^j, and the operator leads from j to j + n at the
    rate -(-eps)^n e^j. In the Laplace transform over T this is a triangular matrix N - i k over the
    velocities; the integral over k makes half its matrix sign of it.
    """
    eps, e = abs(law.returns(3)[0]), float(np.exp(-law.returns(3)[1]))
    out = np.zeros(path.shape)
    near = (path > 0.0) & (2.0 * e * path < _FALLEN * (1.0 + e))
    if eps == 0.0 or not near.any():
        return out
    count = 2 + min(_MOST_BACK, int(np.log(_LEAST_BACK) / np.log(eps)))
    theta = (2.0 * np.arange(_TALBOT) + 1.0) * np.pi / _TALBOT - np.pi
    a, b, c = 0.5017, 0.6407, 0.2645  # of the contour, see the source
    scaled = a * theta / np.tan(b * theta) - 0.6122 + 1j * c * theta
    slope = a / np.tan(b * theta) - a * b * theta / np.sin(b * theta) ** 2 + 1j * c
    rate = _TALBOT * scaled / path[near][:, None]
    value = 0.5 * _column_of_sign(rate, e, eps, count) * np.exp(rate * path[near][:, None])
    out[near] = ((value * slope).sum(axis=1) / (1j * path[near])).real
    return out


def _column_of_sign(rate: NDArray[Any], e: float, eps: float, count: int) -> NDArray[Any]:
    """Sum over j > 0 of the first column of the sign of N, (-1)^j on its diagonal; shape of rate.

    Column by column from S N = N S and S S = 1 (Higham, Functions of Matrices, section 5.2).
    """
    j = np.arange(count)
    sign, speed = (-1.0) ** j, e**j
    down = np.maximum(np.subtract.outer(j, j), 0)
    below = np.where(down > 0, (-eps) ** down * speed / (sign * speed)[:, None], 0.0)
    found: dict[tuple[int, int], Any] = {(i, i): sign[i] for i in j.tolist()}
    pairs = [(low, low + apart) for apart in range(1, count) for low in range(count - apart)]
    for low, i in pairs:
        between = range(low + 1, i)
        if sign[i] == sign[low]:
            product = sum(found[i, k] * found[k, low] for k in between)
            found[i, low] = -product / (2.0 * sign[i])
            continue
        rest = below[i, low] * (sign[i] - sign[low])
        for k in between:
            rest = rest + found[i, k] * below[k, low] - below[i, k] * found[k, low]
        diagonal = sign[i] * (1.0 + rate / speed[i]) - sign[low] * (1.0 + rate / speed[low])
        found[i, low] = rest / diagonal
    return np.asarray(sum(found[i, 0] for i in range(1, count)))
