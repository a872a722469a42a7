r"""The diffusion coefficient of the Chapman-Enskog equation to any Sonine order.

With B = (l/v0^2) b(c) the equation for B (paper, label ``diffuse15``) is, in scaled variables,

    -(h/2) div_c (c b) + L b = c F,      D_e = -(l v0/2) integral of c.b dc,

the divergence component by component and L the collision operator for l = v0 = 1. The paper's
ansatz B ~ v f_a2 (label ``ad3``) is order 1 of b = c F_n(c) sum_k d_k S_k(c^2), k = 0 ... n - 1,
S_k the Sonine polynomials of a vector (parameter 1), F_n the scaled state of order n. Projected on
c S_j(c^2), j = 0 ... n - 1, it gives n linear equations, and D_e of order 1 is eq. ad7.

The exact solution needs no expansion: projected on c/|c| the equation is closed,
D_e = l v0 <c>/(2 (1 - <cos chi>)), for every F; (3/8) l <|v|> at e = 1.

What the series does, D_n/D with D exact:

- e = 1, Gaussian: 0.849, 0.934, 0.961, ..., 0.9850 (n = 6), 0.9974 (n = 20), 0.99907 (n = 40): it
  converges from below, with an error that falls as n^(-3/2), because b is c/|c| times a Gaussian,
  which no polynomial in c^2 meets at c = 0.
- e < 1: it inherits the divergence of F_n (see :mod:`kinetics.sonine.series`). e = 0.9: 0.893,
  0.941 (n = 3), 1.003 (5), 1.073 (10), 0.987 (20). e = 0.4: 1.30 (n = 2), 0.75 (4), 1.51 (6), 1.80
  (10), 2.35 (20).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.sonine.series import (
    ROUNDING_LIMIT,
    FloatArray,
    SeriesStatus,
    laguerre_products,
    scaled_state,
)
from kinetics.validation import check_restitution, whole_number


@dataclass(frozen=True)
class SonineDiffusion:
    """The diffusion coefficient at one order.

    Attributes
    ----------
    restitution, order : as asked
    coefficient : D_e/(l v0(t)), dimensionless; NaN without a real scaled state
    slope : d<r^2>/d ln t in units of l^2, 8 D_e/(l v0 h); infinite at e = 1
    expansion : b_i in b(c) = c exp(-c^2)/pi sum_i b_i S_i(c^2)
    rounding : estimate of the relative rounding error of the coefficient: 1e-11 at order 10, some
        1e-6 at order 20; NaN without a real scaled state
    status : SeriesStatus: that of the scaled state, or ILL_CONDITIONED
    """

    restitution: float
    order: int
    coefficient: float
    slope: float
    expansion: FloatArray
    rounding: float
    status: SeriesStatus


def diffusion_of_order(restitution: float, order: int) -> SonineDiffusion:
    """D_e at this order (1 to 40), 0 <= e <= 1; the Gaussian is the state at e = 1.

    InputError for bad arguments. Where the scaled state has no real solution, neither has D_e, and
    the status says so.
    """
    e, n = check_restitution(restitution), whole_number("order", order, 1, 40)
    if e == 1.0:
        rate, a, status = 0.0, np.array([1.0]), SeriesStatus.REAL
    else:
        state = scaled_state(e, n)
        rate, a, status = state.cooling_rate, state.coefficients, state.status
    b, rounding = np.full(n + len(a), np.nan), math.nan
    if status is SeriesStatus.REAL:
        b, rounding = _solve(CollisionLaw(e), n, rate, a)
        if not rounding < ROUNDING_LIMIT:
            b, status = np.full(n + len(a), np.nan), SeriesStatus.ILL_CONDITIONED
    # the integral of c.b is that of x e^-x times the polynomial: its coefficient of S_0
    coefficient = -0.5 * float(b[0])
    slope = math.inf if e == 1.0 else 8.0 * coefficient / rate
    return SonineDiffusion(e, n, coefficient, slope, b, rounding, status)


def _solve(law: CollisionLaw, n: int, rate: float, a: FloatArray) -> tuple[FloatArray, float]:
    """b_i, shape (n + len(a),), and the rounding error to expect."""
    trial = _trial_functions(n, a)
    size = len(trial)
    collide = vector_loss_matrix(law, size) @ laguerre_products(size, 1)
    j = np.arange(float(size))
    # c.grad of c S_j: (1 + 2j) S_j - 2 (j + 1) S_(j-1), the norm of S_j being j + 1
    scale = np.diag((1.0 + 2.0 * j) * (j + 1.0)) - np.diag(2.0 * (j[1:] + 1.0) * j[1:], -1)
    left = (0.5 * rate * scale - collide)[:n] @ trial
    # S_k of the scalar state is S_k - S_(k-1) of the vector
    padded = np.zeros(n + 1)
    padded[: min(n + 1, len(a))] = a[: n + 1]
    right = (j[:n] + 1.0) * (padded[:-1] - padded[1:])
    size_of_rows = np.linalg.norm(left, axis=1)
    left, right = left / size_of_rows[:, None], right / size_of_rows
    rounding = float(np.finfo(float).eps * np.linalg.cond(left))
    return np.asarray(trial @ np.linalg.solve(left, right)), rounding


def vector_loss_matrix(law: CollisionLaw, size: int) -> FloatArray:
    """delta_ji - E[s cos(chi) C(j+1, j-i) s^(2i) (1 - s^2)^(j-i)], shape (size, size).

    What a collision takes from the average of c S_j(c^2), in terms of c S_i(c^2).
    """
    q = law.quadrature_for(2.0 * size + 1.0)
    kept, lost = np.exp(-2.0 * q.log_loss), -np.expm1(-2.0 * q.log_loss)
    out = np.eye(size)
    for j in range(size):
        for i in range(j + 1):
            mean = q.weight @ (q.parallel * kept**i * lost ** (j - i))
            out[j, i] -= math.comb(j + 1, j - i) * float(mean)
    return out


def _trial_functions(n: int, a: FloatArray) -> FloatArray:
    """n functions that span F_n/phi times S_0 ... S_(n-1), in terms of S_i: (n + len(a), n).

    F_n/phi times 1, x, x^2, ... made orthogonal one after the other (Arnoldi): the products with
    S_k themselves are all but dependent where F_n changes sign.
    """
    from scipy.special import eval_genlaguerre, roots_genlaguerre

    size = n + len(a)
    x, w = roots_genlaguerre(size + n, 1.0)
    root = np.sqrt(w)
    basis = root * np.array([eval_genlaguerre(i, 1.0, x) for i in range(size)])
    trial = np.zeros((n, x.size))
    vector = root * np.polynomial.laguerre.lagval(x, a)
    for k in range(n):
        for _ in range(2):
            vector = vector - trial[:k].T @ (trial[:k] @ vector)
        trial[k] = vector / np.linalg.norm(vector)
        vector = x * trial[k]
    return np.asarray(basis @ trial.T / np.arange(1.0, size + 1.0)[:, None])
