"""Fourier sums are exact for what the nodes resolve; small losses count; one thread."""

import math
from dataclasses import dataclass

import mpmath as mp
import numpy as np
import pytest
import threadpoolctl
from collision import integer_moment

from kinetics import Scene, solve
from kinetics.numerics import one_blas_thread
from kinetics.numerics.log_grid import LogGrid
from kinetics.numerics.refinement import refine_until_converged


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


@dataclass(frozen=True)
class Refined:
    """A solution that knows nothing but its resolution."""

    resolution: int

    @property
    def finer(self) -> int | None:
        return self.resolution + 1 if self.resolution < 4 else None


def test_refinement_goes_on_while_a_difference_is_not_a_number() -> None:
    def difference(fine: Refined, coarse: Refined) -> dict[str, float]:
        return {"first": 1e-9, "second": math.nan if fine.resolution == 1 else 1e-9}

    solution, errors = refine_until_converged(
        Refined, 0, difference, tolerance={"first": 1e-6, "second": 1e-6}
    )
    assert solution.resolution == 2
    assert errors["second"] <= 1e-6


def test_a_difference_that_is_never_a_number_is_an_infinite_error() -> None:
    def difference(fine: Refined, coarse: Refined) -> dict[str, float]:
        return {"first": 1e-9, "second": math.nan}

    _, errors = refine_until_converged(
        Refined, 0, difference, tolerance={"first": 1e-6, "second": 1e-6}
    )
    assert errors["second"] == math.inf
