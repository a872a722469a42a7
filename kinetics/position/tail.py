"""How F(k, t) ends: the powers of 1/k that the slowest tracers leave.

Initial speeds near 0, of density ~ v, put a cusp on the density of the displacement at r = 0, of
weight (l/U t)^2, and F falls as k^-3 there. The end of F is fitted by terms whose Hankel
transforms are known, so that the transform needs no large k.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from kinetics.numerics import FloatArray
from kinetics.values import Value

TERMS = 8  # of the sum: with more, errors of F are raised instead of fitted


@dataclass(frozen=True)
class PowerTail(Value):
    """sum_j c_j (q^2 + 1)^(-nu - 1), nu = (1 + j)/2, q = K/scale, K = k l.

        integral of q J_0(q x) (q^2 + 1)^(-nu - 1) dq = (x/2)^nu K_nu(x)/Gamma(nu + 1)

    (DLMF 10.22.46).

    Attributes
    ----------
    coefficients : c_j, shape (n_terms,)
    scale : K where the powers begin
    """

    coefficients: FloatArray
    scale: float

    def at(self, k: FloatArray) -> FloatArray:
        """The tail at K = k, shape (n_k,)."""
        return np.asarray(origin_terms(k / self.scale, self.coefficients.size) @ self.coefficients)

    def transform(self, rho: FloatArray, kind: int) -> FloatArray:
        """Integral over all K of K J_0, J_1 or K^2 J_1 (kind 0, 1, 2) times it, at r = rho l."""
        parts = origin_transforms(self.scale * rho, self.coefficients.size, kind)
        return np.asarray(self.coefficients @ parts) * self.scale ** (2, 1, 3)[kind]


def origin_terms(q: FloatArray, count: int) -> FloatArray:
    """(q^2 + 1)^(-nu - 1), nu = (1 + j)/2, for j < count: q (n,) gives (n, count)."""
    return np.asarray((1.0 + q[:, None] ** 2) ** (-0.5 * (3.0 + np.arange(count))))


def origin_transforms(x: FloatArray, count: int, kind: int) -> FloatArray:
    """Integral over q of q J_0(q x), J_1 or q^2 J_1 (kind 0, 1, 2) times each term, (count, n)."""
    near = np.clip(x, 1e-12, 700.0)  # K_nu(x) is in range there, and negligible above
    macdonald = _macdonald(near, count + 2)
    out = np.zeros((count, x.size))
    for j in range(count):
        nu = 0.5 * (1 + j)
        part = 1.0 / (2.0**nu * math.gamma(nu + 1.0))
        if kind == 0:
            out[j] = part * macdonald[j + 2]
        elif kind == 1:
            out[j] = (1.0 - part * macdonald[j + 4]) / np.maximum(x, near)
        else:
            out[j] = part * near * macdonald[j]
    return out


def _macdonald(x: FloatArray, highest: int) -> list[FloatArray]:
    """x^nu K_nu(x) for nu = -1/2, 0, 1/2, ... highest/2, at x > 0 (n,)."""
    from scipy.special import k0, k1

    with np.errstate(under="ignore"):
        half = math.sqrt(0.5 * math.pi) * np.exp(-x)
        found = [half / x, k0(x), half, x * k1(x)]
        for twice in range(3, highest + 1):
            # K_(nu+1) = K_(nu-1) + (2 nu/x) K_nu, nu = twice/2 - 1
            found.append(x * x * found[-4] + (twice - 2) * found[-2])
    return found


def fit_tail(k: FloatArray, f: FloatArray, scale: float) -> tuple[PowerTail, float]:
    """The tail of F through f at K = k, shape (n_k,) each, and its error, absolute.

    ``scale`` is where the powers begin. The error is seen in the upper part of the range, after a
    fit to the lower 60 %; it is infinite where there are too few points.
    """
    below = k < k.min() + 0.6 * (k.max() - k.min())
    if np.count_nonzero(below) < TERMS + 1:
        return PowerTail(np.zeros(0), scale), np.inf
    # the error of one number of terms may vanish by accident: a mean over three of them
    missed = [
        float(np.abs(_fit(k[below], f[below], scale, terms).at(k) - f).max())
        for terms in (TERMS - 2, TERMS - 1, TERMS)
    ]
    left = math.sqrt(max(missed[:2])) * math.sqrt(max(missed[1:]))
    return _fit(k, f, scale, TERMS), left


def _fit(k: FloatArray, f: FloatArray, scale: float, terms: int) -> PowerTail:
    """Least squares of the errors relative to K^-3."""
    weight = k**3
    found = np.linalg.lstsq(
        origin_terms(k / scale, terms) * weight[:, None], f * weight, rcond=1e-13
    )
    return PowerTail(np.asarray(found[0]), scale)
