r"""The Sonine expansion to any order, as a method among others. For comparison.

F(c) = exp(-c^2)/pi (1 + sum_k a_k S_k(c^2)), k = 2 ... n + 1 at order n, where S_k are the Laguerre
polynomials (paper, label ``sonine1``; its own approximation is order 1, a_2 alone). The moments are

    m_(2j)/j! = sum_k (-1)^k C(j, k) a_k           =: (P a)_j,      P P = 1,
    m_(2j+1)/j! = Gamma(j + 3/2)/j! sum_k (-1)^k C(j + 1/2, k) a_k =: (Q a)_j,

and d<v^(2j)>/dt = -lambda(2j) <v^(2j+1)>/l for j = 1 ... n + 1 closes the expansion. Independent of
the solvers of the package: lambda(2j) comes from the binomial expansion of s^2 = e^2 + (1-e^2) y^2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def even_decay_rates(restitution: float, count: int) -> FloatArray:
    """lambda(2j) = 1 - E[s^(2j)], j = 0 ... count."""
    e2 = restitution * restitution
    rates = [
        1.0 - math.fsum(math.comb(j, i) * e2 ** (j - i) * (1 - e2) ** i / (2 * i + 1)
                        for i in range(j + 1))
        for j in range(count + 1)
    ]  # fmt: skip
    return np.array(rates)


@lru_cache(maxsize=32)
def moment_matrices(order: int) -> tuple[FloatArray, FloatArray]:
    """P and P Q, shape (order + 2, order + 2); exact sums, rounded once."""
    from fractions import Fraction

    size = order + 2
    signed = [[(-1) ** k * math.comb(j, k) for k in range(size)] for j in range(size)]
    # Gamma(j + 3/2)/(j! Gamma(3/2)), and the generalised binomials, are fractions
    ratio, odd = Fraction(1), []
    for j in range(size):
        if j:
            ratio *= Fraction(2 * j + 1, 2 * j)
        row, term = [], ratio
        for k in range(size):
            row.append(term)
            term *= -(Fraction(2 * j + 1, 2) - k) / (k + 1)
        odd.append(row)
    return (
        np.array(signed, dtype=float),
        np.array([[float(x) for x in row] for row in odd]) * (0.5 * math.sqrt(math.pi)),
    )


@dataclass(frozen=True)
class SonineState:
    """Coefficients a_0 = 1, a_1 = 0, a_2, ... and the cooling rate that goes with them."""

    coefficients: FloatArray
    cooling_rate: float

    @property
    def a2(self) -> float:
        """a_2."""
        return float(self.coefficients[2])

    def vdf(self, c: FloatArray) -> FloatArray:
        """F(c)."""
        x = np.asarray(c) ** 2
        series = np.polynomial.laguerre.lagval(x, self.coefficients)
        return np.asarray(np.exp(-x) / math.pi * series)


def solve_scaled(restitution: float, order: int) -> SonineState:
    """The scaled equation at this order; ValueError where it has no real solution.

    j h m_(2j) = lambda(2j) m_(2j+1), j = 1 ... order + 1, is an eigenvalue problem for h.
    Of several real solutions the one of the smallest coefficients is taken: at order 1 the paper's
    stable one.
    """
    from scipy.linalg import eig

    even, odd = moment_matrices(order)
    kept = [0, *range(2, order + 2)]
    rows = np.arange(1, order + 2)
    rates = even_decay_rates(restitution, order + 1)
    left = rates[rows, None] * odd[np.ix_(rows, kept)]
    right = rows[:, None] * even[np.ix_(rows, kept)]
    found = None
    values, vectors = eig(left, right)
    for h, vector in zip(values, vectors.T, strict=True):
        if not (np.isfinite(h) and abs(h.imag) < 1e-9 * abs(h) and h.real > 0 and vector[0]):
            continue
        a = np.insert((vector / vector[0]).real, 1, 0.0)
        if found is None or np.abs(a).sum() < np.abs(found.coefficients).sum():
            found = SonineState(a, float(h.real))
    if found is None:
        raise ValueError(f"order = {order}: no real solution at restitution {restitution:g}")
    return found


def solve_cooling(
    restitution: float,
    mean_free_path: float,
    initial: str,
    times: FloatArray,
    order: int,
    rtol: float,
) -> tuple[FloatArray, FloatArray]:
    """v0(t) in U and a2(t), from a "gaussian" or a "monoenergetic" start; ValueError on failure.

    In s, ds = v0 dt/l: da/ds = P (2 j alpha m_(2j)/j! - lambda(2j) m_(2j+1)/j!), with alpha =
    -d ln v0/ds = lambda(2) m_3/2.
    """
    from scipy.integrate import solve_ivp

    even, odd = moment_matrices(order)
    rates = even_decay_rates(restitution, order + 1)
    twice = 2.0 * np.arange(order + 2.0)
    gain, loss = even @ (twice[:, None] * even), even @ (rates[:, None] * odd)
    a = np.zeros(order + 2)
    a[0] = 1.0
    speed = math.sqrt(2.0) if initial == "gaussian" else 1.0
    if initial != "gaussian":
        # delta(c - 1): a_k = L_k(1)
        a = np.array([np.polynomial.laguerre.lagval(1.0, row) for row in np.eye(order + 2)])
        a[1] = 0.0

    def derivative(_: float, state: FloatArray) -> FloatArray:
        a, slowness = state[:-1], math.exp(-state[-1])
        alpha = 0.5 * rates[1] * float(odd[1] @ a)
        change = alpha * (gain @ a) - loss @ a
        change[:2] = 0.0
        # the clock is ln(1 + t/t0), t0 = l/v0(0); state[-1] = ln(v0 (t + t0)/l), all autonomous
        return np.append(change / slowness, 1.0 - alpha / slowness)

    unit = mean_free_path / speed
    result = solve_ivp(
        derivative,
        (0.0, float(np.log1p(times[-1] / unit))),
        np.append(a, 0.0),
        method="LSODA",
        t_eval=np.log1p(times / unit),
        rtol=rtol,
        atol=1e-2 * rtol,
    )
    if not result.success:
        raise ValueError(f"order = {order}: {result.message}")
    if not np.all(np.isfinite(result.y)):
        raise ValueError(f"order = {order}: the coefficients grow beyond all bounds")
    return np.exp(result.y[-1]) * mean_free_path / (times + unit), result.y[2]
