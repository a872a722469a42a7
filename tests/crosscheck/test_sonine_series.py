"""The example of the Sonine expansion against moments in mpmath and the printed first order."""

import math
import runpy
from pathlib import Path
from typing import Any

import mpmath as mp
import numpy as np
import pytest

from kinetics import sonine

EXAMPLE = Path(__file__).parents[2] / "examples" / "sonine_convergence.py"


@pytest.fixture(scope="module")
def scaled_state() -> Any:
    return runpy.run_path(str(EXAMPLE))["scaled_state"]


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
def test_a_real_root_is_that_of_the_moment_equations(
    scaled_state: Any, e: float, order: int, digits: float
) -> None:
    rate, coefficients = scaled_state(e, order)
    with mp.workdps(60):
        h, a = polished(e, order, rate, coefficients)
        assert float(abs(rate / h - 1)) < digits
        assert float(abs(coefficients[2] - a[1])) < 10 * digits


@pytest.mark.parametrize("e", [0.6, 0.7, 0.9, 0.999])
def test_the_first_order_is_the_printed_one(scaled_state: Any, e: float) -> None:
    rate, coefficients = scaled_state(e, 1)
    assert coefficients[2] == pytest.approx(float(sonine.a2(e)), rel=1e-12)
    assert rate == pytest.approx(float(sonine.cooling_rate(e)), rel=1e-12)


def test_odd_orders_lose_their_real_root(scaled_state: Any) -> None:
    for order, edge in ((1, 0.5815), (3, 0.632), (5, 0.663), (9, 0.70)):
        assert scaled_state(edge + 0.01, order)[0] > 0.0
        assert math.isnan(scaled_state(edge - 0.01, order)[0])
