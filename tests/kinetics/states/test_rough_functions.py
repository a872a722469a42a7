"""Speed densities given by functions: with steps, infinities, waves, or rare fast tracers.

Every average is right to what its error estimate says, or the status says that it is not.
"""

import math
import warnings
from collections.abc import Callable
from typing import Any

import mpmath as mp
import numpy as np
import pytest

from kinetics import Scene, Solution, SolverStatus, SpeedTable, ToleranceWarning, solve
from kinetics.outputs import OUTPUTS


def box(low: float, high: float) -> Callable[[Any], Any]:
    """The density of speeds that are uniform between two values."""
    return lambda v: np.where((v > low) & (v < high), 1.0 / (high - low), 0.0)


def box_moment(p: float, low: float, high: float) -> float:
    return (high ** (p + 1.0) - low ** (p + 1.0)) / ((p + 1.0) * (high - low))


def at_start(density: Callable[[Any], Any], rtol: float | None = None) -> Solution:
    scene = Scene(0.5, initial=density, times=[0.0], outputs=("thermal_speed", "a2"))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ToleranceWarning)
        return solve(scene, rtol=rtol)


def errors_of(solution: Solution, second: float, fourth: float) -> list[float]:
    """Relative errors of v0 and of 1 + a2 in the plane, from the exact <v^2> and <v^4>."""
    speed = float(solution.thermal_speed[0]) / math.sqrt(second) - 1.0
    excess = (1.0 + float(solution.a2[0])) / (0.5 * fourth / second**2) - 1.0
    return [abs(speed), abs(excess)]


def test_a_step_near_the_end_of_a_panel_is_seen() -> None:
    low, high = 0.2785038767353962, 1.1747316169237125
    solution = at_start(box(low, high))
    assert solution.thermal_speed[0] == pytest.approx(0.7713032457, rel=1e-9)


def test_random_boxes_are_taken_and_right_to_rtol() -> None:
    rng = np.random.default_rng(5)
    for _ in range(100):
        low = rng.uniform(0.01, 1.0)
        high = low + rng.uniform(0.02, 2.0)
        solution = at_start(box(low, high))
        assert solution.status is SolverStatus.CONVERGED
        errors = errors_of(solution, box_moment(2, low, high), box_moment(4, low, high))
        assert max(errors) < 2e-12, (low, high)  # a few times the error estimate, 3.5e-13


def test_an_infinite_density_has_an_honest_error() -> None:
    """Of (1 - v)^(-1/2)/2, 1e-8 of the mass lies where doubles do not resolve 1 - v."""

    def density(v: Any) -> Any:
        return np.where(v < 1.0, 0.5 / np.sqrt(np.where(v < 1.0, 1.0 - v, 1.0)), 0.0)

    second, fourth = (float(0.5 * mp.beta(p + 1, 0.5)) for p in (2, 4))
    strict = at_start(density)
    assert strict.status is SolverStatus.TOLERANCE_NOT_REACHED
    assert max(errors_of(strict, second, fourth)) < strict.error_estimate < 1e-6
    assert at_start(density, 1e-6).status is SolverStatus.CONVERGED


@pytest.mark.parametrize("waves", [50.0, 200.0, 1000.0])
def test_fast_waves_are_resolved(waves: float) -> None:
    norm = 1.0 + math.sin(waves) / waves
    solution = at_start(lambda v: np.where(v < 1.0, (1.0 + np.cos(waves * v)) / norm, 0.0))
    ends = mp.linspace(0, 1, 101)
    waves_of = [mp.quad(lambda v, p=p: v**p * mp.cos(waves * v), ends) for p in (2, 4)]
    second = float((mp.mpf(1) / 3 + waves_of[0]) / norm)
    fourth = float((mp.mpf(1) / 5 + waves_of[1]) / norm)
    assert solution.status is SolverStatus.CONVERGED
    assert max(errors_of(solution, second, fourth)) < 1e-11


@pytest.mark.parametrize("width", [1.0, 10.0, 100.0])
@pytest.mark.parametrize("rtol", [1e-6, 1e-10])
def test_few_fast_tracers_count_in_high_powers(width: float, rtol: float) -> None:
    """1e-7 of the tracers, at v = 1000, make nearly all of <v^4>."""
    share, low, high = 1e-7, 1000.0, 1000.0 + width

    def density(v: Any) -> Any:
        slow = v * np.exp(-0.5 * np.minimum(v, 1e3) ** 2)
        return (1.0 - share) * slow + share * box(low, high)(v)

    second = (1.0 - share) * 2.0 + share * box_moment(2, low, high)
    fourth = (1.0 - share) * 8.0 + share * box_moment(4, low, high)
    solution = at_start(density, rtol)
    assert solution.status is SolverStatus.CONVERGED
    assert max(errors_of(solution, second, fourth)) < rtol


@pytest.mark.parametrize("density", [[2.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
@pytest.mark.parametrize("output", OUTPUTS)
def test_a_table_from_rest_gives_no_warning(output: str, density: list[float]) -> None:
    f = np.asarray(density) / np.trapezoid(density, [0.0, 1.0, 2.0])
    scene = Scene(0.7, initial=SpeedTable([0.0, 1.0, 2.0], f), times=[0.0, 1.0, 30.0],
                  outputs=(output,))  # fmt: skip
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        solve(scene, rtol=1e-2)


@pytest.mark.parametrize("width", [1e-3, 1e-4, 1e-5])
@pytest.mark.parametrize("share", [5e-7, 1e-7])
@pytest.mark.parametrize("rtol", [1e-3, 1e-10])
def test_few_fast_tracers_of_nearly_one_speed_are_seen(
    width: float, share: float, rtol: float
) -> None:
    """Without a share of the tracers the norm is 1 to a millionth, and <v^2> is percents off."""
    fastest = 1000.0
    deviation = width * fastest
    height = share / (deviation * math.sqrt(2.0 * math.pi))

    def density(v: Any) -> Any:
        slow = v * np.exp(-0.5 * np.minimum(v, 1e3) ** 2)
        distance = np.minimum(np.abs(v - fastest) / deviation, 1e2)
        return (1.0 - share) * slow + height * np.exp(-0.5 * distance**2)

    second = (1.0 - share) * 2.0 + share * (fastest**2 + deviation**2)
    scene = Scene(0.5, initial=density, times=[0.0], outputs=("thermal_speed",))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ToleranceWarning)
        solution = solve(scene, rtol)
    error = abs(float(solution.thermal_speed[0]) / math.sqrt(second) - 1.0)
    assert error <= max(rtol, solution.error_estimate)


@pytest.mark.parametrize("width", [1e-3, 1e-4, 1e-5])
def test_a_narrow_peak_is_taken(width: float) -> None:
    low, high = 0.9, 0.9 * (1.0 + width)
    solution = at_start(box(low, high))
    errors = errors_of(solution, box_moment(2, low, high), box_moment(4, low, high))
    assert max(errors) <= solution.error_estimate
