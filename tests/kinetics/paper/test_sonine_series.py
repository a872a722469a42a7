"""Sonine of any order against moments in mpmath, the exact state and the printed first order."""

import math
from typing import Any

import mpmath as mp
import numpy as np
import pytest

from kinetics import sonine
from kinetics.paper.series import SeriesStatus


def moment_equations(e: float, order: int) -> tuple[mp.matrix, mp.matrix]:
    """j h m_(2j) = lambda(2j) m_(2j+1), j = 1 ... order + 1, in monomials and many digits.

    m_(2j)/j! = sum_k (-1)^k C(j, k) a_k, m_(2j+1) with C(j + 1/2, k) and Gamma(j + 3/2): nothing
    of the module's basis or quadrature.
    """
    squared = mp.mpf(e) ** 2
    kept = [0, *range(2, order + 2)]
    left, right = mp.matrix(order + 1), mp.matrix(order + 1)
    for row, j in enumerate(range(1, order + 2)):
        rate = 1 - mp.fsum(
            mp.binomial(j, i) * squared ** (j - i) * (1 - squared) ** i / (2 * i + 1)
            for i in range(j + 1)
        )
        odd = rate * mp.gamma(j + mp.mpf(3) / 2) / mp.factorial(j)
        for column, k in enumerate(kept):
            left[row, column] = odd * (-1) ** k * mp.binomial(j + mp.mpf(1) / 2, k)
            right[row, column] = j * (-1) ** k * mp.binomial(j, k)
    return left, right


def polished(e: float, order: int, h: float, a: np.ndarray) -> tuple[Any, list[Any]]:
    """Newton's iteration on the moment equations from h and a."""
    left, right = moment_equations(e, order)
    x = mp.matrix([a[0], *a[2:]])
    h = mp.mpf(h)
    for _ in range(8):
        bent = left - h * right
        slope, fall = bent.copy(), right * x
        for row in range(order + 1):
            slope[row, 0] = -fall[row]
        step = mp.lu_solve(slope, -(bent * x))
        h += step[0]
        for k in range(1, order + 1):
            x[k] += step[k]
        if abs(step[0]) < mp.mpf(10) ** -30:
            return h, list(x)
    raise ArithmeticError("Newton's iteration did not settle")


@pytest.mark.parametrize(
    ("e", "order", "digits"),
    [(0.0, 2, 1e-13), (0.4, 8, 1e-13), (0.4, 20, 1e-12), (0.9, 20, 1e-13), (0.4, 32, 1e-8)],
)
def test_a_real_root_is_that_of_the_moment_equations(e: float, order: int, digits: float) -> None:
    state = sonine.scaled_state(e, order)
    with mp.workdps(60):
        h, a = polished(e, order, state.cooling_rate, state.coefficients)
        error = float(abs(state.cooling_rate / h - 1))
        assert error < digits
        assert float(abs(state.a2 - a[1])) < 10 * digits


@pytest.mark.parametrize("e", [0.6, 0.7, 0.9, 0.999])
def test_the_first_order_is_the_printed_one(e: float) -> None:
    state = sonine.scaled_state(e, 1)
    assert state.a2 == pytest.approx(float(sonine.a2(e)), rel=1e-12)
    assert state.cooling_rate == pytest.approx(float(sonine.cooling_rate(e)), rel=1e-12)
    c = np.linspace(0.0, 3.0, 7)
    np.testing.assert_allclose(state.vdf(c), sonine.vdf(c, state.a2), rtol=1e-12)
    roots = np.sort(state.roots.real)
    printed = [sonine.m2(e, sonine.a2(e, root)) / 2 for root in ("stable", "unstable")]
    np.testing.assert_allclose(roots, printed, rtol=1e-12)


@pytest.mark.parametrize(("order", "edge"), [(1, 0.5815), (3, 0.632), (5, 0.663), (9, 0.70)])
def test_odd_orders_lose_their_real_root_where_they_are_said_to(order: int, edge: float) -> None:
    assert sonine.scaled_state(edge + 0.01, order).status is SeriesStatus.REAL
    lost = sonine.scaled_state(edge - 0.01, order)
    assert lost.status is SeriesStatus.NO_REAL_SOLUTION
    assert math.isnan(lost.cooling_rate)
    assert math.isnan(lost.a2)
    assert np.any(lost.roots.imag > 1e-3)


@pytest.mark.parametrize("order", [2, 4, 10, 20])
def test_even_orders_have_a_real_root_at_every_restitution(order: int) -> None:
    for e in np.linspace(0.0, 0.99, 12):
        assert sonine.scaled_state(float(e), order).status is SeriesStatus.REAL
