"""The principal solution of G(z+1) = r(z) G(z), for the recurrences of the gamma function."""

import math

import mpmath as mp
import numpy as np
import pytest

from kinetics.numerics.gauss import equal_panels
from kinetics.numerics.recurrence import MOST_ORDERS, log_growth, taylor_of_log


def taylor_of_log_z(z: complex, orders: int) -> list[np.ndarray]:
    """Of ln z: the recurrence r(z) = z of the gamma function."""
    powers = [-((-1.0 / z) ** n) / n for n in range(1, orders)]
    return [np.array([c]) for c in (np.log(z), *powers)]


@pytest.mark.parametrize("end", [17.0, 40.5, 24.0 + 30.0j, 24.0 - 7.5j])
@pytest.mark.parametrize(("orders", "limit"), [(8, 1e-12), (12, 1e-14)])
def test_the_gamma_function(end: complex, orders: int, limit: float) -> None:
    begin = 16.0
    x, w = equal_panels(1.0, 24, 0.25)
    integral = np.array([(np.log(begin + (end - begin) * x) @ w) * (end - begin)])
    found = log_growth(integral, taylor_of_log_z(begin, orders), taylor_of_log_z(end, orders))[0]
    with mp.workdps(30):
        exact = complex(mp.loggamma(end) - mp.loggamma(begin))
    assert abs(found - exact) <= limit * abs(exact)


def test_each_two_coefficients_gain_what_the_next_term_says() -> None:
    x, w = equal_panels(1.0, 24, 0.25)
    integral = np.array([np.log(2.0 + 60.0 * x) @ w * 60.0])
    exact = math.lgamma(62.0) - math.lgamma(2.0)
    ends = [[taylor_of_log_z(z, n) for z in (2.0, 62.0)] for n in (2, 4, 6)]
    errors = [abs(float(log_growth(integral, *two)[0]) - exact) for two in ends]
    for n, error in zip((2, 4, 6), errors, strict=True):
        claimed = 2.0 * math.factorial(n) / ((2.0 * math.pi) ** (n + 2) * 2.0 ** (n + 1))
        assert 0.3 * claimed < error < 1.5 * claimed


def test_no_more_than_six_bernoulli_numbers_are_used() -> None:
    assert MOST_ORDERS == 12


def test_the_taylor_series_of_a_logarithm() -> None:
    """ln(1/(1 - z)) = z + z^2/2 + ..., and at several points at once."""
    ones = [np.array([1.0, 1.0])] * 10
    found = taylor_of_log([c * 2.0 for c in ones])
    assert found[0] == pytest.approx(math.log(2.0))
    for n in range(1, 10):
        np.testing.assert_allclose(found[n], 1.0 / n, rtol=1e-14)
