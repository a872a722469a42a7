"""Gauss-Legendre quadrature: exact for polynomials up to degree 2 n - 1."""

import numpy as np
import pytest

from kinetics.numerics.gauss import equal_panels, gauss_legendre, panels_between, panels_of


@pytest.mark.parametrize("points", [1, 2, 5, 12])
def test_polynomials_up_to_twice_the_points(points: int) -> None:
    x, w = gauss_legendre(points)
    for degree in range(2 * points):
        assert w @ x**degree == pytest.approx(1.0 / (degree + 1), rel=1e-13)
    assert abs(w @ x ** (2 * points) - 1.0 / (2 * points + 1)) > 1e-16


def test_equal_panels_are_no_longer_than_allowed() -> None:
    x, w = equal_panels(7.3, 8, longest=0.5)
    assert x.size == 15 * 8
    assert np.all(np.diff(x) > 0.0)
    assert w.sum() == pytest.approx(7.3, rel=1e-14)
    assert w @ np.exp(-x) == pytest.approx(-np.expm1(-7.3), rel=1e-12)


def test_panels_of_any_length() -> None:
    edges = np.array([-1.0, 0.5, 0.6, 3.0])
    x, w = panels_between(edges, 6)
    assert w @ x**5 == pytest.approx((3.0**6 - 1.0) / 6.0, rel=1e-13)
    apart, weight = panels_of(np.array([[2.0, 1.0]]), 3)  # backwards: a negative integral
    assert float((weight * apart**2).sum()) == pytest.approx(-7.0 / 3.0, rel=1e-14)
