"""Polynomials through Chebyshev points: exact for polynomials, against closed forms for others."""

import numpy as np
import pytest
from numpy.polynomial.chebyshev import Chebyshev

from kinetics.numerics.chebyshev import FirstKind, SecondKind, interpolation_rows

KINDS = [FirstKind, SecondKind]


def polynomial(count: int) -> Chebyshev:
    """Of degree count - 1 on [0, 1], with coefficients 1, 1/2, 1/3, ... in Chebyshev's basis."""
    return Chebyshev(1.0 / (1.0 + np.arange(count)), domain=[0.0, 1.0])


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("nodes", [3, 8, 33])
def test_polynomials_are_reproduced(kind: type[FirstKind | SecondKind], nodes: int) -> None:
    rule, f = kind(nodes), polynomial(nodes)
    assert np.all(np.diff(rule.local) > 0.0)
    x = np.linspace(0.0, 1.0, 57)
    np.testing.assert_allclose(rule.rows(x) @ f(rule.local), f(x), atol=1e-11, rtol=0)
    np.testing.assert_allclose(rule.rows(x).sum(axis=1), 1.0, rtol=1e-12)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("nodes", [3, 5, 16])
def test_the_last_coefficients(kind: type[FirstKind | SecondKind], nodes: int) -> None:
    rule, f = kind(nodes), polynomial(nodes)
    values = np.stack([f(rule.local), -2.0 * f(rule.local)])
    last, before = rule.last_coefficients(values)
    np.testing.assert_allclose(last, np.array([1.0, 2.0]) * f.coef[-1], rtol=1e-13)
    np.testing.assert_allclose(before, np.array([1.0, 2.0]) * f.coef[-2], rtol=1e-13)


def test_slopes() -> None:
    rule, f = SecondKind(12), polynomial(12)
    np.testing.assert_allclose(rule.slopes @ f(rule.local), f.deriv()(rule.local), rtol=1e-11)
    # constants have no slope, to rounding of single entries
    assert np.abs(rule.slopes.sum(axis=1)).max() < 1e-13 * np.abs(rule.slopes).max()


def test_rows_for_nodes_of_any_kind() -> None:
    """Equidistant nodes with binomial weights: a cubic through four of them."""
    nodes, weights = np.arange(4.0), np.array([1.0, -3.0, 3.0, -1.0])
    x = np.array([[0.5, 2.0], [3.1, -1.0]])
    rows = interpolation_rows(x[..., None] - nodes, weights)
    np.testing.assert_allclose(rows @ nodes**3, x**3, rtol=1e-14)
    assert np.array_equal(rows[0, 1], [0.0, 0.0, 1.0, 0.0])
