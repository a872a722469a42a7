"""The Sonine expansion at orders 1 to 20, beside the exact cooling rate and a2.

python examples/sonine_convergence.py

F(c) = exp(-c^2)/pi (1 + sum_k a_k S_k(c^2)), k = 2 ... n + 1 at order n, S_k Laguerre polynomials
(paper, label sonine1); the paper's own approximation is order 1, a_2 alone. The scaled equation
(label ifmu2), projected on S_1 ... S_(n+1), is a generalised eigenvalue problem for h:

    h (j a_j - j a_(j-1)) = sum_k (I - T)_ji H_ik a_k,        a_0 = 1, a_1 = 0,
    T_ji = E[C(j, i) s^(2i) (1 - s^2)^(j-i)],  H_ik = integral of x^(1/2) e^-x S_i S_k dx

It diverges for every e < 1, because F falls as exp(-2c/h). For e < 0.75 higher orders lead away
from the exact values (odd ones have no real solution there); closer to 1 they oscillate about the
exact values and approach them.
"""

import math
from typing import Any

import numpy as np
from scipy.linalg import eig, toeplitz

from kinetics import CollisionLaw, ScalingSolution

RESTITUTIONS = (0.4, 0.7, 0.8, 0.9, 0.99)
ORDERS = tuple(range(1, 21))
SHOWN = (1, 2, 3, 4, 5, 6, 8, 10, 12, 14, 16, 18, 20)


def laguerre_products(size: int) -> np.ndarray:
    """H, by the polynomials of parameter 1/2, whose products are diagonal."""
    index = np.arange(1.0, size)
    change = np.cumprod(np.append(1.0, (index - 1.5) / index))
    norm = math.gamma(1.5) * np.cumprod(np.append(1.0, (index + 0.5) / index))
    lower = toeplitz(change, np.zeros(size))
    return (lower * norm) @ lower.T


def loss_matrix(law: CollisionLaw, size: int) -> np.ndarray:
    """I - T: what a collision takes from the average of S_j, in terms of S_i."""
    q = law.quadrature_for(2.0 * size + 1.0)
    kept, lost = np.exp(-2.0 * q.log_loss), -np.expm1(-2.0 * q.log_loss)
    out = np.zeros((size, size))
    for j in range(size):
        for i in range(j):
            out[j, i] = -math.comb(j, i) * (q.weight @ (kept**i * lost ** (j - i)))
        out[j, j] = -out[j, :j].sum()  # what is lost goes to lower polynomials
    return out


def scaled_state(e: float, order: int) -> tuple[float, np.ndarray]:
    """h and a_0 ... a_(order+1): the real root of the smallest coefficients; NaN without one."""
    size = order + 2
    j, kept = np.arange(float(size)), [0, *range(2, size)]
    scale = np.diag(j) - np.diag(j[1:], -1)
    collide = loss_matrix(CollisionLaw(e), size) @ laguerre_products(size)
    values, vectors = eig(collide[1:, kept], scale[1:, kept])
    spread = np.abs(vectors).sum(axis=0) / np.maximum(np.abs(vectors[0]), 1e-300)
    real = np.isfinite(values) & (np.abs(values.imag) < 1e-9 * np.abs(values)) & (spread < 1e14)
    real &= values.real > 0.0
    if not real.any():
        return math.nan, np.full(size, math.nan)
    best = int(np.argmin(np.where(real, spread, np.inf)))
    return float(values[best].real), np.insert((vectors[:, best] / vectors[0, best]).real, 1, 0.0)


EXACT = {e: (ScalingSolution(e).cooling_rate, ScalingSolution(e).a2) for e in RESTITUTIONS}
SERIES = {
    (e, n): (h, float(a[2])) for e in RESTITUTIONS for n in ORDERS for h, a in [scaled_state(e, n)]
}


def show(row: Any) -> str:
    """One row of the table; a dash where there is no real solution."""
    return "  ".join(f"{x:8.4f}" if x == x else "       -" for x in row)


if __name__ == "__main__":
    for number, title in ((0, "h"), (1, "a2")):
        heads = [f"e = {e:g}" for e in RESTITUTIONS]
        print(f"{title:10s}", "  ".join(f"{head:>8s}" for head in heads))
        for n in SHOWN:
            print(f"  n = {n:<5d}", show(SERIES[e, n][number] for e in RESTITUTIONS))
        print("  exact    ", show(EXACT[e][number] for e in RESTITUTIONS))
