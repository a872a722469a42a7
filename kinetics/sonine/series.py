r"""The Sonine expansion of the scaled state to any order.

F(c) = exp(-c^2)/pi (1 + sum_k a_k S_k(c^2)), k = 2 ... n + 1 at order n. S_k are the Laguerre
polynomials (paper, label ``sonine1``); the paper's own approximation is order 1, a_2 alone. The
scaled equation (label ``ifmu2``), projected on S_1 ... S_(n+1), is linear except for the cooling
rate:

    h (j a_j - j a_(j-1)) = sum_k (I - T)_ji H_ik a_k,        a_0 = 1, a_1 = 0,
    T_ji = E[C(j, i) s^(2i) (1 - s^2)^(j-i)],  H_ik = integral of x^(1/2) e^-x S_i S_k dx,

a generalised eigenvalue problem for h. T is a matrix of probabilities, S_j(s^2 x) in terms of
S_i(x), and each element of H is a sum whose terms but one have the same sign: both are accurate to
rounding at every order.

What the series does. (h and a_2 of order 1 ... 60 were compared with the exact ones. The roots are
the same in 40 to 50 digits: the series diverges, it does not lose digits.)

- The expansion itself diverges for every e < 1. F falls as exp(-2c/h), so that F^2 exp(c^2) has no
  integral, and the exact a_k (:func:`exact_coefficients`) grow in the end, each by the factor
  k h^2. It is an asymptotic series. Its smallest coefficient is at k = 2 for e <= 0.6, 10 for
  e = 0.7, 29 for e = 0.8, beyond 40 for e >= 0.85.
- The truncated equations do not approach F either. For e < 0.75 h_n falls towards 0 and a_2 towards
  -1 (e = 0.4: h = 0.742, 0.520, 0.394, 0.289 at order 2, 10, 20, 40; exact 0.847). Even orders have
  a real root at every e; odd orders have none below e = 0.582 (order 1, eq. compare1), 0.63 (3),
  0.66 (5), 0.70 (9), 0.76 (19), 0.79 (29).
- For e >= 0.8 they oscillate about the exact values and come close before they diverge. e = 0.8: h
  is within 2.2 % at orders 6 ... 20, 0.13 % off at 30, 6 % at 40. e = 0.9: 7 % at 10, 1.4 % at 20,
  1e-4 at 40, 4e-4 at 100. As e -> 1 the oscillation decays ever more slowly: 13 % at 10, 6 % at 40
  for e = 0.99, where there are several real roots.
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
from kinetics.validation import (
    check_positive,
    check_restitution,
    check_rtol,
    not_negative,
    one_of,
    refuse,
    whole_number,
)

HIGHEST_ORDER = 100
"""Orders beyond this are refused."""

ROUNDING_LIMIT = 1e-4
"""A root whose rounding error may be larger than this, relative to h, is not reported."""

_REAL = 1e-9  # imaginary part over modulus of a root that counts as real
_BOUND = 1e8  # coefficients that pass it in time do not come back


class SeriesStatus(enum.Enum):
    """How a Sonine truncation ended."""

    REAL = "a real solution"
    NO_REAL_SOLUTION = "no real solution with a positive cooling rate: try another order"
    ILL_CONDITIONED = "rounding spoils the numbers of this order: try a lower one"
    INTEGRATION_FAILED = "the coefficients could not be followed to the last time: lower the order"


# -- matrices ------------------------------------------------------------------------------------


def laguerre_products(size: int, alpha: int) -> FloatArray:
    """Integrals of x^(alpha + 1/2) e^-x S_i S_k, S of parameter alpha, shape (size, size).

    From S_i = sum_m (-1/2)_m/m! S'_(i-m), S' the polynomials of parameter alpha + 1/2, whose
    integrals are diagonal: Gamma(k + alpha + 3/2)/k!.
    """
    index = np.arange(1.0, size)
    change = np.cumprod(np.append(1.0, (index - 1.5) / index))
    norm = math.gamma(alpha + 1.5) * np.cumprod(np.append(1.0, (index + alpha + 0.5) / index))
    lower = np.zeros((size, size))
    for i in range(size):
        lower[i, : i + 1] = change[: i + 1][::-1]
    return np.asarray((lower * norm) @ lower.T)


def speed_loss_matrix(law: CollisionLaw, size: int) -> FloatArray:
    """(I - T)_ji of the module's docstring, shape (size, size); its rows sum to 0."""
    q = law.quadrature_for(2.0 * size)
    kept, lost = np.exp(-2.0 * q.log_loss), -np.expm1(-2.0 * q.log_loss)
    out = np.zeros((size, size))
    for j in range(1, size):
        for i in range(j):
            out[j, i] = -math.comb(j, i) * float(q.weight @ (kept**i * lost ** (j - i)))
        # 1 - E[s^(2j)] from the same numbers: what is lost goes to the lower polynomials
        out[j, j] = -out[j, :j].sum()
    return out


@lru_cache(maxsize=64)
def _matrices(restitution: float, size: int) -> tuple[FloatArray, FloatArray]:
    """(I - T) H and the matrix of j a_j - j a_(j-1), both read-only."""
    law = CollisionLaw(restitution)
    collide = speed_loss_matrix(law, size) @ laguerre_products(size, 0)
    j = np.arange(float(size))
    scale = np.diag(j) - np.diag(j[1:], -1)
    collide.flags.writeable = scale.flags.writeable = False
    return collide, scale


# -- the scaled state ----------------------------------------------------------------------------


@dataclass(frozen=True)
class SonineState:
    """The scaled state at one order.

    Attributes
    ----------
    restitution, order : as asked
    coefficients : a_0 = 1, a_1 = 0, a_2 ... a_(order+1); NaN without a real solution
    cooling_rate : h, dimensionless; NaN without a real solution
    roots : every h of this order with a_0 = 1, complex, shape (n_roots,), by modulus
    rounding : bound on the relative rounding error of h, some 100 times what it is: at e = 0.4 the
        errors are 4e-14, 6e-11, 9e-9 at order 20, 30, 40. NaN without a real solution
    status : SeriesStatus
    """

    restitution: float
    order: int
    coefficients: FloatArray
    cooling_rate: float
    roots: NDArray[np.complex128]
    rounding: float
    status: SeriesStatus

    @property
    def a2(self) -> float:
        """a_2."""
        return float(self.coefficients[2])

    def vdf(self, c: ArrayLike) -> FloatArray:
        """F(c), a density in the plane; negative where the truncation makes it so."""
        x = np.square(not_negative("c", c))
        with np.errstate(under="ignore"):
            series = np.polynomial.laguerre.lagval(x, self.coefficients)
            return np.asarray(np.exp(-x) / math.pi * series)


def _inelastic(restitution: float) -> float:
    e = check_restitution(restitution)
    if e == 1.0:
        refuse("restitution", e, "the scaled state exists for 0 <= e < 1 only")
    return e


def scaled_state(restitution: float, order: int) -> SonineState:
    """The scaled state for 0 <= e < 1 with a_2 ... a_(order+1), order from 1 to 100.

    Of several real solutions the one of the smallest coefficients (sum of |a_k|) is taken: at order
    1 the paper's stable one. Without one the status says so and the numbers are NaN. InputError for
    bad arguments; at e = 1 there is no scaled state.
    """
    from scipy.linalg import eig

    e, n = _inelastic(restitution), whole_number("order", order, 1, HIGHEST_ORDER)
    collide, scale = _matrices(e, n + 2)
    kept = [0, *range(2, n + 2)]
    left, right = collide[1:, kept], scale[1:, kept]
    values, dual, vectors = eig(left, right, left=True)
    weight = np.abs(vectors).sum(axis=0)
    proper = np.isfinite(values) & (np.abs(vectors[0]) > 1e-14 * weight)
    values, vectors, dual = values[proper], vectors[:, proper], dual[:, proper]
    roots = values[np.argsort(np.abs(values))]
    real = (np.abs(values.imag) < _REAL * np.abs(values)) & (values.real > 0.0)
    nothing = np.full(n + 2, np.nan)
    if not np.any(real):
        status = SeriesStatus.NO_REAL_SOLUTION
        return SonineState(e, n, nothing, math.nan, roots, math.nan, status)
    size = np.where(real, weight[proper] / np.abs(vectors[0]), np.inf)
    best = int(np.argmin(size))
    h, x, y = float(values[best].real), vectors[:, best], dual[:, best]
    # backward error of the QZ algorithm times the condition number of a simple eigenvalue
    change = np.linalg.norm(left) + h * np.linalg.norm(right)
    change *= np.linalg.norm(x) * np.linalg.norm(y) / abs(np.vdot(y, right @ x))
    rounding = float(np.finfo(float).eps * change / h)
    if not rounding < ROUNDING_LIMIT:
        status = SeriesStatus.ILL_CONDITIONED
        return SonineState(e, n, nothing, math.nan, roots, rounding, status)
    a = np.insert((x / x[0]).real, 1, 0.0)
    return SonineState(e, n, a, h, roots, rounding, SeriesStatus.REAL)


def exact_coefficients(restitution: float, count: int) -> FloatArray:
    """a_0 ... a_(count-1) of the exact F: a_k = sum_j (-1)^j C(k, j) <c^(2j)>/j!.

    count from 1 to 60, 0 <= e < 1. <c^(2j)> is known in closed form, so these are the numbers that
    a Sonine expansion would have to find. The sum cancels; its error is some 1e-15 of its largest
    term. InputError for bad arguments.
    """
    e, n = _inelastic(restitution), whole_number("count", count, 1, 60)
    law = CollisionLaw(e)
    # E[Y^(p+1)] = p E[Y^p]/lambda(p), two steps at a time, in units of E[Y^2]
    rates = law.decay_rate(np.arange(1.0, 2.0 * n + 1.0))
    square = 1.0 / (law.mean_log_loss * rates[0])
    moments = [1.0, 1.0]
    for j in range(1, n):
        p = 2 * j
        moments.append(moments[-1] * p * (p + 1) / (rates[p - 1] * rates[p]) / square)
    scaled = [moment / math.factorial(j) for j, moment in enumerate(moments)]
    return np.array(
        [math.fsum((-1) ** j * math.comb(k, j) * scaled[j] for j in range(k + 1)) for k in range(n)]
    )


# -- cooling in time -----------------------------------------------------------------------------


@dataclass(frozen=True)
class SonineCooling:
    """v0(t) and the coefficients at one order.

    Attributes
    ----------
    times : in d/U, shape (n_times,)
    thermal_speed : v0(t) in U, shape (n_times,); NaN where the status is not REAL
    coefficients : a_0 ... a_(order+1), shape (n_times, order + 2)
    status : SeriesStatus
    """

    times: FloatArray
    thermal_speed: FloatArray
    coefficients: FloatArray
    status: SeriesStatus

    @property
    def a2(self) -> FloatArray:
        """a_2(t), shape (n_times,)."""
        return np.asarray(self.coefficients[:, 2])


def cooling(
    restitution: float,
    times: ArrayLike,
    order: int,
    mean_free_path: float = 12.5,
    initial: str = "gaussian",
    rtol: float = 1e-8,
) -> SonineCooling:
    """v0(t) and a_k(t) at this order, from a "gaussian" or a "monoenergetic" start.

    With ds = v0 dt/l: da_j/ds = 2 alpha j (a_j - a_(j-1)) - sum_k ((I - T) H)_jk a_k, where
    alpha = -d ln v0/ds is what keeps a_1 = 0. Times in d/U, rising; the mean free path in d.
    """
    from scipy.integrate import solve_ivp

    e, n = check_restitution(restitution), whole_number("order", order, 1, HIGHEST_ORDER)
    path, rtol = check_positive("mean_free_path", mean_free_path), check_rtol(rtol)
    t = np.atleast_1d(not_negative("times", times))
    if t.ndim != 1 or t.size == 0 or np.any(np.diff(t) < 0.0):
        refuse("times", times, "they must not fall, at least one")
    one_of("initial", initial, ("gaussian", "monoenergetic"))
    collide, scale = _matrices(e, n + 2)
    a = np.zeros(n + 2)
    a[0] = 1.0
    speed = math.sqrt(2.0) if initial == "gaussian" else 1.0
    if initial != "gaussian":
        # delta(c - 1): a_k = S_k(1)
        a = np.array([np.polynomial.laguerre.lagval(1.0, row) for row in np.eye(n + 2)])
        a[1] = 0.0

    def derivative(_: float, state: FloatArray) -> FloatArray:
        a, slowness = state[:-1], math.exp(-state[-1])
        loss = collide @ a
        alpha = -0.5 * loss[1]
        change = 2.0 * alpha * (scale @ a) - loss
        change[:2] = 0.0
        # the clock is ln(1 + t/t0), t0 = l/v0(0); state[-1] = ln(v0 (t + t0)/l), all autonomous
        return np.append(change / slowness, 1.0 - alpha / slowness)

    unit = path / speed
    clock = np.log1p(t / unit)
    with np.errstate(over="ignore", invalid="ignore"):
        found = solve_ivp(
            derivative,
            (0.0, float(clock[-1]) or 1.0),
            np.append(a, 0.0),
            method="LSODA",
            t_eval=clock,
            rtol=rtol,
            atol=1e-2 * rtol,
            events=_runaway,
        )
    if not (found.status == 0 and np.all(np.isfinite(found.y))):
        nothing = np.full((t.size, n + 2), np.nan)
        return SonineCooling(t, nothing[:, 0], nothing, SeriesStatus.INTEGRATION_FAILED)
    v0 = np.exp(found.y[-1]) * path / (t + unit)
    return SonineCooling(t, v0, np.asarray(found.y[:-1].T), SeriesStatus.REAL)


def _runaway(_: float, state: FloatArray) -> float:
    """Below 0 once the coefficients grow beyond all bounds."""
    return float(_BOUND - np.abs(state[:-1]).max())


_runaway.terminal = True  # type: ignore[attr-defined]
