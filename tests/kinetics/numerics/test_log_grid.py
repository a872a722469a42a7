"""Fourier sums on equidistant nodes: exact for the waves that the nodes resolve."""

import math
from fractions import Fraction

import numpy as np
import pytest

from kinetics.numerics.log_grid import LogGrid


@pytest.mark.parametrize("nodes", [50, 51])
def test_trigonometric_interpolation_of_even_and_odd_nodes(nodes: int) -> None:
    grid = LogGrid(-3.0, 6.0 / nodes, nodes)
    x = np.linspace(-2.9, 2.8, 40)

    def wave(at: np.ndarray) -> np.ndarray:
        turn = 2.0 * math.pi * (at - grid.start) / 6.0
        return np.asarray(0.3 + np.cos(3.0 * turn) - 2.0 * np.sin(((nodes - 1) // 2) * turn))

    np.testing.assert_allclose(grid.interpolate(wave(grid.x), x), wave(x), atol=1e-13)


@pytest.mark.parametrize("start", [-45.3, -43.0, 17.9])
def test_nodes_near_zero_keep_their_digits(start: float) -> None:
    """Steps between nodes there are exact to their own rounding, not to that of the far end.

    The densities of nearly elastic tracers lost two digits by it: v t/l is of order 1 near x = 0.
    """
    grid = LogGrid(start, 0.057, 1600 if start < 0 else 8)
    if start > 0.0:
        assert abs(float(grid.x[0]) - start) <= 4e-15
        return
    near = np.nonzero(np.abs(grid.x) < 1.0)[0]
    exact = [Fraction(grid.spacing) * int(j - near[0]) for j in near]
    apart = [Fraction(float(grid.x[j])) - Fraction(float(grid.x[near[0]])) for j in near]
    assert max(abs(float(a - b)) for a, b in zip(apart, exact, strict=True)) < 4e-16
    assert abs(float(grid.x[0]) - start) <= 1.5e-14
