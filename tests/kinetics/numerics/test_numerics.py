"""Fourier sums are exact for what the nodes resolve; small losses count; one thread."""

import math

import mpmath as mp
import numpy as np
import pytest
import threadpoolctl
from collision import integer_moment

from kinetics import Scene, solve
from kinetics.numerics import one_blas_thread
from kinetics.numerics.log_grid import LogGrid


@pytest.mark.parametrize("nodes", [50, 51])
def test_trigonometric_interpolation_of_even_and_odd_nodes(nodes: int) -> None:
    grid = LogGrid(-3.0, 6.0 / nodes, nodes)
    x = np.linspace(-2.9, 2.8, 40)

    def wave(at: np.ndarray) -> np.ndarray:
        turn = 2.0 * math.pi * (at - grid.start) / 6.0
        return np.asarray(0.3 + np.cos(3.0 * turn) - 2.0 * np.sin(((nodes - 1) // 2) * turn))

    np.testing.assert_allclose(grid.interpolate(wave(grid.x), x), wave(x), atol=1e-13)


@pytest.mark.parametrize("gap", [1e-6, 1e-8])
def test_the_cooling_rate_of_nearly_elastic_tracers(gap: float) -> None:
    """v0 t -> 2 l/h: the small losses at each bounce decide it, and must not be rounded."""
    e, t = 1.0 - gap, 1e30
    found = solve(Scene(e, times=[t], outputs=("thermal_speed",)), rtol=1e-12)
    with mp.workdps(50):
        h = float(2 / mp.sqrt(integer_moment(e, 2)))
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
