r"""The Sonine expansion of the scaled state to any order.

F(c) = exp(-c^2)/pi (1 + sum_k a_k S_k(c^2)), k = 2 ... n + 1 at order n, S_k Laguerre polynomials
(paper, label ``sonine1``); the paper's own approximation is order 1, a_2 alone. The scaled equation
(label ``ifmu2``), projected on S_1 ... S_(n+1), is a generalised eigenvalue problem for h:

    h (j a_j - j a_(j-1)) = sum_k (I - T)_ji H_ik a_k,        a_0 = 1, a_1 = 0,
    T_ji = E[C(j, i) s^(2i) (1 - s^2)^(j-i)],  H_ik = integral of x^(1/2) e^-x S_i S_k dx

The expansion diverges for every e < 1, because F falls as exp(-2c/h): it comes nearest the exact h
at order 2 for e <= 0.6, about 30 for e = 0.8, and leaves it again. Odd orders have no real root
below e = 0.582 (order 1, eq. compare1), 0.63 (3), 0.66 (5), 0.70 (9).
"""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics.collision import CollisionLaw
from kinetics.numerics import FloatArray
from kinetics.paper.printed import numbers
from kinetics.validation import real_number, whole_number

HIGHEST_ORDER = 32  # at which rounding leaves 8 digits
_REAL = 1e-9  # imaginary part over modulus of a root that counts as real


class SeriesStatus(enum.Enum):
    """How a Sonine truncation ended."""

    REAL = "a real solution"
    NO_REAL_SOLUTION = "no real solution with a positive cooling rate: try another order"


def _laguerre_products(size: int) -> FloatArray:
    """Integrals of x^(1/2) e^-x S_i S_k, shape (size, size).

    From S_i = sum_m (-1/2)_m/m! S'_(i-m), S' the polynomials of parameter 1/2, whose integrals are
    diagonal: Gamma(k + 3/2)/k!.
    """
    from scipy.linalg import toeplitz

    index = np.arange(1.0, size)
    change = np.cumprod(np.append(1.0, (index - 1.5) / index))
    norm = math.gamma(1.5) * np.cumprod(np.append(1.0, (index + 0.5) / index))
    lower = toeplitz(change, np.zeros(size))
    return np.asarray((lower * norm) @ lower.T)


def _loss_matrix(law: CollisionLaw, size: int) -> FloatArray:
    """What a collision takes from the average of S_j, in terms of S_i, shape (size, size)."""
    q = law.quadrature_for(2.0 * size + 1.0)
    kept, lost = np.exp(-2.0 * q.log_loss), -np.expm1(-2.0 * q.log_loss)
    out = np.zeros((size, size))
    for j in range(size):
        for i in range(j):
            out[j, i] = -math.comb(j, i) * float(q.weight @ (kept**i * lost ** (j - i)))
        # 1 - E[s^(2j)] from the same numbers: what is lost goes to lower polynomials
        out[j, j] = -out[j, :j].sum()
    return out


@lru_cache(maxsize=64)
def _matrices(restitution: float, size: int) -> tuple[FloatArray, FloatArray]:
    """(I - T) H and the matrix of j a_j - j a_(j-1), both read-only."""
    collide = _loss_matrix(CollisionLaw(restitution), size) @ _laguerre_products(size)
    j = np.arange(float(size))
    scale = np.diag(j) - np.diag(j[1:], -1)
    collide.flags.writeable = scale.flags.writeable = False
    return collide, scale


@dataclass(frozen=True)
class SonineState:
    """The scaled state at one order.

    coefficients : a_0 = 1, a_1 = 0, a_2 ... a_(order+1); NaN without a real solution
    cooling_rate : h, dimensionless; NaN without a real solution
    roots : every h of this order with a_0 = 1, complex, shape (n_roots,), by modulus
    """

    restitution: float
    order: int
    coefficients: FloatArray
    cooling_rate: float
    roots: NDArray[np.complex128]
    status: SeriesStatus

    @property
    def a2(self) -> float:
        """a_2."""
        return float(self.coefficients[2])

    def vdf(self, c: ArrayLike) -> FloatArray:
        """F(c), a density in the plane; negative where the truncation makes it so."""
        x = np.square(numbers(c))
        with np.errstate(under="ignore"):
            series = np.polynomial.laguerre.lagval(x, self.coefficients)
            return np.asarray(np.exp(-x) / math.pi * series)


def scaled_state(restitution: float, order: int) -> SonineState:
    """The scaled state for 0 <= e < 1 with a_2 ... a_(order+1), order from 1 to 32.

    Of several real solutions the one of the smallest coefficients (sum of |a_k|) is taken: at order
    1 the paper's stable one. Without one the status says so and the numbers are NaN. InputError for
    bad arguments; at e = 1 there is no scaled state.
    """
    from scipy.linalg import eig

    e = real_number("restitution", restitution, 0.0, math.nextafter(1.0, 0.0))
    n = whole_number("order", order, 1, HIGHEST_ORDER)
    collide, scale = _matrices(e, n + 2)
    kept = [0, *range(2, n + 2)]
    values, vectors = eig(collide[1:, kept], scale[1:, kept])
    weight = np.abs(vectors).sum(axis=0)
    proper = np.isfinite(values) & (np.abs(vectors[0]) > 1e-14 * weight)
    values, vectors, weight = values[proper], vectors[:, proper], weight[proper]
    roots = values[np.argsort(np.abs(values))]
    real = (np.abs(values.imag) < _REAL * np.abs(values)) & (values.real > 0.0)
    if not np.any(real):
        nothing = np.full(n + 2, np.nan)
        return SonineState(e, n, nothing, math.nan, roots, SeriesStatus.NO_REAL_SOLUTION)
    best = int(np.argmin(np.where(real, weight / np.abs(vectors[0]), np.inf)))
    a = np.insert((vectors[:, best] / vectors[0, best]).real, 1, 0.0)
    return SonineState(e, n, a, float(values[best].real), roots, SeriesStatus.REAL)
