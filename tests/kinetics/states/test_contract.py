"""Every rule of the contract in kinetics/states/state.py, for every initial state."""

import copy
import itertools
import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from example_values import (
    HEIGHTS,
    SPEEDS,
    STATES,
    VELOCITIES,
    gamma_speeds,
    half_of_it,
    polar_values,
)

from kinetics import (
    AngularHarmonics,
    Monoenergetic,
    PolarGrid,
    Scene,
    SolverStatus,
    SpeedTable,
    ToleranceWarning,
    VelocitySamples,
    solve,
)
from kinetics.states.state import Points


@pytest.mark.parametrize("name", STATES)
def test_states_are_values(name: str) -> None:
    """As their scenes are: tests/kinetics/test_results.py."""
    state, same = STATES[name](), STATES[name]()
    assert state == same == copy.deepcopy(state)
    assert len({state, *(make() for make in STATES.values()), "gaussian"}) == len(STATES) + 1
    assert VelocitySamples(VELOCITIES) != VelocitySamples(VELOCITIES[::-1])
    assert SpeedTable(SPEEDS, HEIGHTS) != SpeedTable(SPEEDS + 0.1, HEIGHTS)
    planar = ("two temperatures", "beam", "velocities", "polar grid")
    assert (state.in_space() is None) == (name in planar)


@pytest.mark.parametrize("name", STATES)
def test_points_and_profiles_are_of_one_density(name: str) -> None:
    state = STATES[name]()
    found = state.harmonic(0, 1e-10)
    assert found is not None
    assert found.weight.sum() == pytest.approx(1.0, abs=1e-9)
    x = np.linspace(-25.0, 5.0, 60_001)
    for m in range(3):
        points, profile = state.harmonic(m, 1e-10), state.profile(m)
        if points is None:
            assert profile is None or not np.any(profile(np.exp(x)))
            continue
        assert state.highest_harmonic is None or m <= state.highest_harmonic
        if profile is None:
            continue
        for p in (0.0, 1.5):
            direct = np.trapezoid(np.exp((1.0 + p) * x) * profile(np.exp(x)), x)
            assert points.weight @ np.exp(p * points.x) == pytest.approx(direct, abs=1e-6)


def gaussian_power(p: float, sx: float, sy: float) -> Any:
    """<v^p>: the speed by hand, the angle by quadrature."""

    def shape(a: Any) -> Any:
        return ((mp.cos(a) / sx) ** 2 + (mp.sin(a) / sy) ** 2) ** (-(p + 2) / 2)

    angle = mp.quad(shape, [0, mp.pi / 4, mp.pi / 2]) * 2 / mp.pi
    return angle * mp.mpf(2) ** (mp.mpf(p) / 2) * mp.gamma(1 + mp.mpf(p) / 2) / (sx * sy)


def table_power(p: float, speeds: Any = SPEEDS, heights: Any = HEIGHTS) -> Any:
    """<v^p> of the linear pieces by the power rule."""
    total, q = mp.mpf(0), mp.mpf(p)
    for (a, fa), (b, fb) in itertools.pairwise(zip(speeds, heights, strict=True)):
        slope = (mp.mpf(fb) - mp.mpf(fa)) / (mp.mpf(b) - mp.mpf(a))
        offset = mp.mpf(fa) - slope * mp.mpf(a)
        for c, k in ((offset, q + 1), (slope, q + 2)):
            if c == 0:
                continue
            upper = mp.mpf(b) ** k / k if k else mp.log(b)
            total += c * (upper - (mp.mpf(a) ** k / k if k else mp.log(a)))
    return total


@pytest.mark.parametrize("p", [-40.0, -20.0, 8.0, 20.0, 40.0])
def test_high_powers_over_a_coarse_table_reach_the_tolerance(p: float) -> None:
    # 1e-12: rounding of ln v, p times
    speeds = np.array([0.5, 1.0, 2.0])
    heights = np.array([0.0, 4.0 / 3.0, 0.0])
    points = SpeedTable(speeds, heights).harmonic(0, 1e-13, min(p, 0.0), max(p, 2.0))
    assert points is not None
    average = points.weight @ np.exp(p * points.x)
    assert average == pytest.approx(float(table_power(p, speeds, heights)), rel=1e-12)


def samples_power(p: float) -> float:
    return float(np.mean(np.hypot(*VELOCITIES.T) ** p))


def gamma_power(p: float) -> Any:
    return mp.gamma(3 + mp.mpf(p)) / 2


NEGATIVE: dict[str, Callable[[float], Any]] = {
    "gaussian": lambda p: gaussian_power(p, 1.0, 1.0),
    "two temperatures": lambda p: gaussian_power(p, 1.5, 0.75), "one speed": lambda p: 1.3**p,
    "table": table_power, "speeds": samples_power, "function": gamma_power,
    "beam": lambda p: gaussian_power(p, 1.0, 1.0), "velocities": samples_power,
    "harmonics": gamma_power, "polar grid": table_power,
}  # fmt: skip


@pytest.mark.parametrize("p", [-0.25, -1.0, -1.9])
@pytest.mark.parametrize("name", STATES)
def test_negative_powers(name: str, p: float) -> None:
    """<v^-1.9> of a polar grid was once 13 % off, with the status CONVERGED."""
    solution = solve(Scene(0.5, initial=STATES[name](), times=[0.0]))
    assert solution.status is SolverStatus.CONVERGED
    assert solution.moment(p)[0] == pytest.approx(float(NEGATIVE[name](p)), rel=1e-9)


@pytest.mark.parametrize(
    ("speed", "density"),
    [
        ([1.0, 2.0], [1.0, 1.0]), ([0.0, 1.0], [2.0, 0.0]), ([0.0, 1.0, 2.0], [0.0, 1.0, 0.0]),
        ([0.5, 0.5 + 1e-7, 1.0, 5.0], [0.0, 2.0, 1.0, 0.0]),
        (np.geomspace(1e-3, 1e3, 40), 1.0 / (1.0 + np.geomspace(1e-3, 1e3, 40) ** 5)),
    ],
)  # fmt: skip
def test_tables_of_narrow_and_of_wide_pieces(speed: Any, density: Any) -> None:
    v, f = np.asarray(speed), np.asarray(density) / np.trapezoid(density, speed)
    solution = solve(Scene(0.5, initial=SpeedTable(v, f), times=[0.0]))
    for p in (-0.5, 0.5, 1.0, 2.0, 3.0, 4.0):
        assert solution.moment(p)[0] == pytest.approx(
            float(table_power(p, v, f)), rel=1e-10 if p > 0.0 else 1e-8
        )


def test_a_state_keeps_its_own_copy() -> None:
    v, w = SPEEDS.copy(), VELOCITIES.copy()
    table, samples = SpeedTable(v, HEIGHTS.copy()), VelocitySamples(w)
    v[1], w[0, 0] = 0.5, 99.0
    assert table == STATES["table"]()
    assert samples == STATES["velocities"]()
    terms = {0: gamma_speeds, 1: half_of_it}
    state = AngularHarmonics(terms)
    terms[1] = gamma_speeds
    assert state == STATES["harmonics"]()


def test_isotropic_states_written_as_directed_ones() -> None:
    """Their other harmonics are zero: once a division by zero, or a false error."""
    outputs = ("thermal_speed", "mean_velocity", "velocity_density")
    isotropic = PolarGrid(SPEEDS, np.tile(polar_values(np.full(1, np.pi / 2)), 16))
    zero = AngularHarmonics({0: gamma_speeds, 1: lambda v: 0.0 * v})
    for state in (isotropic, zero):
        assert state.harmonic(1, 1e-6) is None
        found = solve(Scene(0.6, initial=state, times=[0.0, 20.0], outputs=outputs), rtol=1e-5)
        assert not np.any(found.mean_velocity)
        f = found.velocity_density([0.3, 1.0], [0.0, 2.0])
        assert np.array_equal(f[:, :, 0], f[:, :, 1])


class WithoutAnError(Monoenergetic):
    """A state that cannot say how well its points represent it."""

    def harmonic(self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0) -> Points:
        points = super().harmonic(m, rtol, lowest, highest)
        return points if points is None else replace(points, error=math.nan)


@pytest.mark.parametrize("drive", [{}, {"heating": 0.1}])
def test_an_error_that_is_not_a_number_has_not_converged(drive: dict[str, float]) -> None:
    scene = Scene(0.7, initial=WithoutAnError(), times=[1.0], outputs="thermal_speed", **drive)
    with pytest.warns(ToleranceWarning, match="initial state"):
        solution = solve(scene, rtol=1e-4)
    assert solution.status is SolverStatus.TOLERANCE_NOT_REACHED
