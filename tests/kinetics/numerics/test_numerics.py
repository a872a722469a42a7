"""Fourier sums and shifts are exact for what the nodes resolve; small matrices take one thread."""

import math
from fractions import Fraction
from types import ModuleType

import mpmath as mp
import numpy as np
import pytest
import threadpoolctl

from kinetics import Scene, solve
from kinetics.numerics import one_blas_thread
from kinetics.numerics.chebyshev import Chebyshev, PanelShifts
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


def test_small_shifts_keep_their_digits() -> None:
    """f(x) - f(x - shift) relative to itself, where it is 1e-9 of f. (A difference of rounded
    points would leave 1e-7.)
    """
    rule, shift = Chebyshev(8), np.array([3.7e-9])
    loss, gain = PanelShifts(rule, shift).kernel(np.ones(1), np.ones((1, 1)), np.zeros((1, 1)))
    with mp.workdps(40):
        exact = [
            float(mp.exp(x) - mp.exp(mp.mpf(x) - mp.mpf(shift[0]))) for x in map(float, rule.local)
        ]
    # the panel below is reached from the first node only
    below = gain[0, 1:] @ np.exp(rule.local - 1.0)
    assert np.abs(below).max() == 0.0
    found = (loss[0] @ np.exp(rule.local))[1:]
    np.testing.assert_allclose(found, exact[1:], rtol=1e-7)  # of a polynomial of degree 7
    squares = (loss[0] @ rule.local**2)[1:]
    x, s = rule.local[1:], shift[0]
    np.testing.assert_allclose(squares, s * (2.0 * x - s), rtol=1e-12)


@pytest.mark.parametrize("gap", [1e-6, 1e-8])
def test_the_cooling_rate_of_nearly_elastic_tracers(gap: float, formulas: ModuleType) -> None:
    """v0 t -> 2 l/h: the small losses at each bounce decide it, and must not be rounded."""
    e, t = 1.0 - gap, 1e30
    found = solve(Scene(e, times=[t], outputs=("thermal_speed",)), rtol=1e-12)
    with mp.workdps(50):
        h = float(2 / mp.sqrt(formulas.integer_moment(e, 2)))
    assert 2.0 * 12.5 / (found.thermal_speed[0] * t) == pytest.approx(h, rel=2e-12, abs=0.0)


def used() -> list[int]:
    return [
        library["num_threads"]
        for library in threadpoolctl.threadpool_info()
        if library["user_api"] == "blas"
    ]


def test_one_thread_meanwhile_and_as_many_as_before_after_an_error() -> None:
    @one_blas_thread
    def fails() -> None:
        assert used()
        assert all(count == 1 for count in used())
        raise KeyError

    with threadpoolctl.threadpool_limits(limits=2, user_api="blas"):
        before = used()
        with pytest.raises(KeyError):
            fails()
        assert used() == before
