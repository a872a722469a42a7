r"""Directions in the plane and in space: what depends on the dimension in `kinetics.position`.

psi, the average of exp(i k.r) for a tracer that starts at angle theta to k, has harmonics

    in the plane   psi = sum over all m of i^|m| a_|m| exp(i m theta),
    in space       psi = sum_m (2m + 1) i^m a_m P_m(cos(theta)),

so that free flights over T have a_m = J_m(K T) in the plane and the spherical Bessel functions
j_m(K T) in space, and obey, with a_(-1) = a_1 in the first,

    da_m/dT = (K/2) (a_(m-1) - a_(m+1)),    da_m/dT = K (m a_(m-1) - (m+1) a_(m+1))/(2m + 1).

The second looks like the first in other units, b_m = g_m a_m:

    db_m/dT = (K/2) c_m (b_(m-1) - b_(m+1)),    b_(-1) = -b_1,
    g_m = sqrt(pi) Gamma(m/2 + 1)/Gamma((m + 1)/2),
    c_m = (2m/(2m + 1)) g_m/g_(m-1),    c_0 = 2/pi

(g_(m+1)/g_(m-1) = (m + 1)/m, and c_m tends to 1). In the plane g_m = c_m = 1.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.numerics import FloatArray


def _units(top: int) -> FloatArray:
    """g_m in space for m up to ``top``, shape (top + 1,)."""
    g = np.ones(top + 2)
    g[1] = 0.5 * math.pi
    for m in range(1, top + 1):
        g[m + 1] = g[m - 1] * (m + 1) / m
    return g[: top + 1]


def coupling(top: int, dimension: int) -> FloatArray:
    """c_m for m up to ``top``, shape (top + 1,)."""
    if dimension == 2:
        return np.ones(top + 1)
    g, m = _units(top), np.arange(1, top + 1)
    return np.append(2.0 / math.pi, 2.0 * m / (2.0 * m + 1.0) * g[1:] / g[:-1])


def share_of_harmonic(m: int, mean: NDArray[Any], angle: float, dimension: int) -> NDArray[Any]:
    """What harmonic m adds to F(k, t), in the plane together with -m; shape of ``mean``.

    mean : average of b_m with the weights of harmonic m of the initial state (in space that of
        P_m(cos theta), theta the angle to the x axis)
    angle : of k to the x axis
    """
    if m == 0:
        return np.asarray(mean.real)
    if dimension == 2:
        return np.asarray(2.0 * 1j**m * (np.exp(1j * m * angle) * mean).real)
    from scipy.special import eval_legendre

    factor = (2 * m + 1) / _units(m)[m] * float(eval_legendre(m, math.cos(angle)))
    return np.asarray(1j**m * factor * mean.real)


def mean_phase(x: FloatArray, dimension: int) -> FloatArray:
    """The mean of exp(i k.r) over the directions, x = k r: J_0(x), in space sin(x)/x."""
    if dimension == 2:
        from scipy.special import j0

        return np.asarray(j0(x))
    near = np.where(x == 0.0, 1.0, x)
    return np.asarray(np.where(x == 0.0, 1.0, np.sin(x) / near))


def element(r: FloatArray, dimension: int) -> FloatArray:
    """r^(d-1): the circle or sphere of radius r, over the unit one."""
    return r if dimension == 2 else r * r


def surface(dimension: int) -> float:
    """Of the unit circle or sphere."""
    return 2.0 * math.pi * (dimension - 1.0)


def radial_waves(x: FloatArray, kind: int, dimension: int) -> FloatArray:
    """Of x = K R: what stands beside F in an integral over K, for a density at R; shape of x.

    With `radial_measure`, the integral is for each kind

    - 0: the radial density over R^(d-1), so that over the surface of the unit circle, or sphere,
      it is the density in the plane, or in space
    - 1: the share of the tracers within R, over R^(d-1)
    - 2: minus the slope of kind 0
    """
    if kind == 0:
        return mean_phase(x, dimension)
    from scipy.special import j1, spherical_jn

    return np.asarray(j1(x) if dimension == 2 else spherical_jn(1, x))


def radial_measure(k: FloatArray, kind: int, dimension: int) -> FloatArray:
    """K, 1, K^2 in the plane and 2/pi times K^2, K, K^3 in space, for kinds 0, 1, 2; (n_k,)."""
    if dimension == 2:
        return np.asarray(k ** (1, 0, 2)[kind])
    return np.asarray(2.0 / math.pi * k ** (2, 1, 3)[kind])
