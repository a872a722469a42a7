"""F(k, t) and G(R) of starts whose speed density has steps, or a narrow peak."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from marking import slow_but

from kinetics import Beam, Monoenergetic, Scene, SolverStatus, SpeedDensity, solve
from kinetics.numerics import FloatArray


@dataclass(frozen=True, eq=False)
class KinkAtItsBeginning(SpeedDensity):
    """A density that names the step at its lowest speed, and goes on beyond it."""

    @property
    def kinks(self) -> FloatArray:  # type: ignore[override]
        """The speed of the step."""
        return np.array([0.5])


def cut_gaussian(v: FloatArray) -> FloatArray:
    return np.where(v > 0.5, v * np.exp((0.25 - v**2) / 2.0), 0.0)


def test_a_density_may_go_on_beyond_its_last_kink() -> None:
    """The mean square of r is that of the averages, within the tolerance of G(R)."""
    scene = Scene(
        0.7,
        0.04,
        times=[100.0],
        initial=KinkAtItsBeginning(cut_gaussian),
        outputs=("position_density", "msd"),
    )
    solution = solve(scene, rtol=1e-2)
    fractions = solution.position_fraction([0.0, 1e4])
    assert fractions[0, 0] == pytest.approx(1.0, abs=1e-2)


WAVE_NUMBERS = np.array([0.5, 2.0])


def scattering(initial: object, rtol: float, direction: float | None = None) -> FloatArray:
    """F(k, t = 3) at e = 0.6 for a mean free path of 1; errors and warnings fail."""
    scene = Scene(0.6, 0.5, initial=initial, times=[3.0], outputs=("intermediate_scattering",))
    solution = solve(scene, rtol)
    assert solution.status is SolverStatus.CONVERGED
    return np.asarray(solution.intermediate_scattering(WAVE_NUMBERS, direction=direction)[0])


def levels(*pieces: tuple[float, float, float]) -> Callable[[FloatArray], FloatArray]:
    """A density that is constant between two speeds; a piece is these, and its share."""

    def density(v: FloatArray) -> FloatArray:
        total = np.zeros(v.shape)
        for low, high, share in pieces:
            total += np.where((v >= low) & (v < high), share / (high - low), 0.0)
        return total

    return density


@pytest.mark.parametrize("rtol", [1e-4, 1e-9])
@pytest.mark.parametrize(
    "pieces",
    [
        [(1.0, 1.7, 1.0)],
        [(0.5, 1.0, 1.0)],
        [(1.0, 1.003, 1.0)],
        [(0.31, 0.77, 0.2), (0.77, 1.9, 0.8)],
    ],
    ids=str,
)
def test_scattering_by_steps_is_the_mean_over_their_speeds(
    pieces: list[tuple[float, float, float]], rtol: float
) -> None:
    """A step at the edge of a panel, as at v = 1, was cut off by a percent of a panel."""
    nodes, weights = np.polynomial.legendre.leggauss(8)
    expected = np.zeros(WAVE_NUMBERS.size)
    for low, high, share in pieces:
        speeds = 0.5 * (low + high) + 0.5 * (high - low) * nodes
        for speed, weight in zip(speeds, weights, strict=True):
            expected += 0.5 * weight * share * scattering(Monoenergetic(float(speed)), 1e-11)
    np.testing.assert_allclose(scattering(levels(*pieces), rtol), expected, rtol=0.0, atol=rtol)


@pytest.mark.parametrize("width", [1e-3, 1e-4])
@pytest.mark.parametrize("direction", [None, 0.3])
def test_scattering_by_a_narrow_peak_is_that_of_its_speed(
    width: float, direction: float | None
) -> None:
    def peak(v: FloatArray) -> FloatArray:
        distance = np.minimum(np.abs(v - 1.0) / width, 100.0)
        return np.asarray(np.exp(-0.5 * distance**2) / (width * math.sqrt(2.0 * math.pi)))

    found = scattering(Beam(0.1, peak), 1e-6, direction)
    expected = scattering(Beam(0.1), 1e-9, direction)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-6 + width**2)


def test_a_norm_of_seven_digits_is_taken_as_one() -> None:
    speeds = levels((1.0, 1.7, 1.0))
    exact = scattering(speeds, 1e-9)
    np.testing.assert_allclose(
        scattering(lambda v: (1.0 + 1e-7) * speeds(v), 1e-9), exact, rtol=0.0, atol=1e-9
    )


@pytest.mark.parametrize(("low", "high"), slow_but([(1.0, 1.7)], [(1.0, 1.7), (0.5, 1.0)]))
def test_the_mean_square_of_g_is_that_of_the_averages(low: float, high: float) -> None:
    scene = Scene(
        0.6,
        0.5,
        initial=levels((low, high, 1.0)),
        times=[10.0],
        outputs=("position_density", "msd"),
    )
    solution = solve(scene, 1e-4)
    nodes, weights = np.polynomial.legendre.leggauss(2000)
    radius = 5.0 * high * (nodes + 1.0)
    density = solution.position_density(radius)[0]
    mean_square = float(5.0 * high * weights @ (density * radius**2))
    assert mean_square == pytest.approx(float(solution.msd[0]), rel=3e-4)
