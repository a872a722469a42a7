"""Isotropic initial states: their averages at the start, early in time, and what is refused."""

import math
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from cooling import power_law_speeds

from kinetics import Scene, SpeedDensity, SpeedSamples, VelocitySamples, solve

BASIC = ("thermal_speed", "temperature", "a2")


def at_start(initial: Any, rtol: float = 1e-10) -> Any:
    return solve(Scene(restitution=0.5, initial=initial, times=[0.0], outputs=BASIC), rtol=rtol)


def tail(v: Any) -> Any:
    """Tail v^-6: <v^p> for p < 5."""
    return 5.0 * v * (1.0 + v * v) ** -3.5


def step(v: Any) -> Any:
    """1/2 on [1, 3)."""
    return np.where((v >= 1.0) & (v < 3.0), 0.5, 0.0)


def step_moment(p: float) -> float:
    return 0.5 * (3.0 ** (p + 1) - 1.0) / (p + 1) if p != -1 else 0.5 * np.log(3.0)


def narrow(v: Any) -> Any:
    """A Gaussian peak of width 0.05 at v = 2."""
    with np.errstate(under="ignore"):
        return np.exp(-0.5 * ((v - 2.0) / 0.05) ** 2) / (0.05 * np.sqrt(2 * np.pi))


def narrow_moment(p: float) -> float:
    return float(mp.quad(lambda z: mp.npdf(z) * (2 + z / 20) ** p, [-12, 0, 12]))


def two_peaks(v: Any) -> Any:
    """Log-normal peaks at 1e-6 and 1, half the tracers each."""
    x = np.log(np.maximum(v, 1e-300))
    with np.errstate(under="ignore"):
        return sum(np.exp(-0.5 * ((x - m) / 0.3) ** 2) for m in (np.log(1e-6), 0.0)) / (
            2 * 0.3 * np.sqrt(2 * np.pi) * np.maximum(v, 1e-300)
        )


def two_peaks_moment(p: float) -> float:
    return 0.5 * (1e-6**p + 1.0) * float(np.exp(0.5 * (0.3 * p) ** 2))


FUNCTIONS = {
    "tail": (tail, lambda p: float(power_law_speeds(mp.mpf(-p))), (-1, 0.5, 1, 2, 3, 4)),
    "step": (step, step_moment, (-1, 0.5, 1, 2, 4, 8)),
    "narrow": (narrow, narrow_moment, (-1, 0.5, 1, 2, 4)),
    "two peaks": (two_peaks, two_peaks_moment, (0.5, 1, 2, 4)),
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_moments_of_functions(name: str) -> None:
    function, exact, powers = FUNCTIONS[name]
    for wrap in (function, SpeedDensity(function)):
        solution = at_start(wrap)
        for p in powers:
            tolerance = 1e-5 if (name, p) == ("tail", 4) else 1e-9
            assert abs(solution.moment(p)[0] / exact(p) - 1.0) < tolerance, (name, p)
        assert np.isclose(solution.thermal_speed[0], np.sqrt(exact(2)), rtol=1e-9)
        assert np.isclose(solution.temperature[0], 0.5 * exact(2), rtol=1e-9)


@pytest.mark.parametrize("n", [1, 5, 400, 401, 100_000])
def test_moments_of_samples(n: int) -> None:
    """Kept as they are up to 400; beyond that gathered, and averages stay the same."""
    speed = np.hypot(*np.random.default_rng(n).normal(size=(2, n)))
    solution = at_start(SpeedSamples(speed))
    for p in (-1, 0.5, 1, 2, 3, 4):
        assert np.isclose(solution.moment(p)[0], np.mean(speed**p), rtol=1e-11), p


@pytest.mark.parametrize("rtol", [1e-6, 1e-12])
@pytest.mark.parametrize("p", [-40.0, -8.0, 4.0, 12.0, 40.0])
def test_high_powers_of_many_samples(p: float, rtol: float) -> None:
    """Of nearly one speed: the points of a grid 1/16 apart gave <v^40> = -22."""
    speed = 1.0 + 0.01 * np.random.default_rng(1).standard_normal(2000)
    for state in (SpeedSamples(speed), VelocitySamples(np.outer(speed, [0.6, 0.8]))):
        found = solve(Scene(0.7, times=[0.0], initial=state), rtol).moment(p)[0]
        assert abs(found / np.mean(speed**p) - 1.0) <= rtol


@pytest.mark.parametrize("power", [2, 3, 7])
def test_a_density_whose_powers_overflow_far_out_is_taken(power: int) -> None:
    """v^3 exp(-v^2) is inf times 0 at speeds that no tracer has."""
    norm = 2.0 / math.gamma(0.5 * (power + 1))
    scene = Scene(0.7, initial=lambda v: norm * v**power * np.exp(-(v**2)), times=[0.0])
    assert solve(scene).thermal_speed[0] == pytest.approx(math.sqrt(0.5 * (power + 1)), rel=1e-9)
