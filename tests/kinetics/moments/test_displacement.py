"""Moments of the displacement: against Mellin-Barnes and series references, limits, identities."""

import itertools
import math
from typing import Any

import numpy as np
import pytest

from kinetics import Beam, CollisionLaw, ScalingSolution, Scene, SolverStatus, SpeedTable, solve
from kinetics.outputs import OUTPUTS

NAMES = ("msd", "kurtosis")
LENGTH = 12.5  # mean free path at the default density, in d


@pytest.fixture(scope="module")
def table(numbers: Any) -> Any:
    """<r^2> and <r^4> at 113 times, in mpmath."""
    return numbers["displacement"]


def run(e: float, outputs: tuple[str, ...], times: Any, initial: Any = "gaussian", **more: Any):
    return solve(Scene(e, initial=initial, times=times, outputs=outputs), **more)


@pytest.mark.parametrize("initial", ["gaussian", "monoenergetic"])
@pytest.mark.parametrize("e", [0.0, 0.05, 0.4, 0.7, 0.9, 0.99])
def test_the_references_at_113_times(table: Any, e: float, initial: str) -> None:
    times = np.asarray(table["T"]) * LENGTH
    found = run(e, NAMES, times, initial)
    assert found.status is SolverStatus.CONVERGED
    reference = table[str(e)][initial]
    square, fourth = (np.asarray(reference[key]) for key in ("square", "fourth"))
    assert np.abs(found.msd / LENGTH**2 / square - 1.0).max() < 1e-10
    quartic = found.kurtosis * (found.msd / LENGTH**2) ** 2
    assert np.abs(quartic / fourth - 1.0).max() < 1e-9


@pytest.mark.parametrize("rtol", [1e-4, 1e-7, 1e-13])
def test_the_accuracy_asked_for_is_met(table: Any, rtol: float) -> None:
    reference = table["0.4"]["gaussian"]
    found = run(0.4, NAMES, np.asarray(table["T"]) * LENGTH, rtol=rtol)
    assert found.status is SolverStatus.CONVERGED
    ratio = np.asarray(reference["fourth"]) / np.asarray(reference["square"]) ** 2
    assert np.abs(found.msd / LENGTH**2 / np.asarray(reference["square"]) - 1.0).max() < rtol
    assert np.abs(found.kurtosis / ratio - 1.0).max() < 2.0 * rtol


def test_elastic_moments_are_those_of_the_hierarchy() -> None:
    """d<v^p z^a conj(z)^b>/dt at one speed is a linear system of constant coefficients."""
    from scipy.linalg import expm

    law = CollisionLaw(1.0)
    a, b = law.harmonic_decay_rate(0.0, 1), law.harmonic_decay_rate(0.0, 2)
    assert abs(a - 4.0 / 3.0) < 1e-14
    assert abs(b - 16.0 / 15.0) < 1e-14
    # (1, M10, M20, M11, M21, M22) of tests/references/displacement.py
    m = np.zeros((6, 6))
    m[1, 0], m[1, 1] = 1.0, -a
    m[2, 1], m[2, 2] = 2.0, -b
    m[3, 1] = 2.0
    m[4, 3], m[4, 2], m[4, 4] = 2.0, 1.0, -a
    m[5, 4] = 4.0
    times = np.array([0.01, 0.3, 0.99, 1.01, 3.0, 20.0, 200.0])
    found = run(1.0, NAMES, times * LENGTH, "monoenergetic")
    for t, square, kurtosis in zip(times, found.msd, found.kurtosis, strict=True):
        state = expm(m * t) @ np.eye(6)[0]
        assert abs(square / LENGTH**2 / state[3] - 1.0) < 1e-11
        assert abs(kurtosis * state[3] ** 2 / state[5] - 1.0) < 1e-11


@pytest.mark.parametrize("e", [0.0, 1e-8, 0.2, 0.5, 0.9, 0.999])
def test_the_slope_over_ln_t_has_its_limit(e: float) -> None:
    times = [1e14, 1e20, 1e100, 1e300]
    found = run(e, ("diffusion_coefficient",), times, rtol=1e-12)
    limit = ScalingSolution(e).diffusion_slope * LENGTH**2
    assert abs(found.msd_slope[0] / limit - 1.0) < 1e-8
    assert np.abs(found.msd_slope[1:] / limit - 1.0).max() < 1e-11
    # the same in closed form
    law = CollisionLaw(e)
    assert abs(limit * law.mean_log_loss * (1.0 - law.mean_cosine) / (2 * LENGTH**2) - 1) < 1e-12


@pytest.mark.parametrize(
    ("initial", "mean_speed"), [("monoenergetic", 1.0), ("gaussian", math.sqrt(math.pi / 2))]
)
def test_the_elastic_diffusion_coefficient(initial: str, mean_speed: float) -> None:
    found = run(1.0, ("diffusion_coefficient",), [0.0, 1e14, 1e300], initial, rtol=1e-13)
    assert found.diffusion_coefficient[0] == 0.0
    exact = 3.0 / 8.0 * LENGTH * mean_speed
    assert np.abs(found.diffusion_coefficient[1:] / exact - 1.0).max() < 1e-12


@pytest.mark.parametrize("initial", ["gaussian", "monoenergetic"])
@pytest.mark.parametrize("e", [0.0, 0.4, 0.9, 1.0])
def test_the_slope_is_that_of_the_mean_square(e: float, initial: str) -> None:
    middle = np.array([0.1, 3.0, 40.0, 1e4])
    step = 1e-3
    # the fourth-order difference of <r^2> over ln t
    levels = np.exp(step * np.array([-2.0, -1.0, 1.0, 2.0]))
    times = np.sort(np.outer(middle, levels).ravel())
    msd = run(e, ("msd",), times, initial, rtol=1e-14).msd.reshape(-1, 4)
    slope = msd @ np.array([1.0, -8.0, 8.0, -1.0]) / (12.0 * step)
    found = run(e, ("diffusion_coefficient",), middle, initial)
    assert np.abs(found.msd_slope / slope - 1.0).max() < 1e-9
    assert np.allclose(found.diffusion_coefficient * 4.0 * middle, found.msd_slope, rtol=1e-13)


@pytest.mark.parametrize("e", [0.3, 1.0])
def test_the_autocorrelation_drives_the_displacement_along_the_start(e: float) -> None:
    """d<v(0).r>/dt = <v(0).v(t)>: for a beam of speed U, d<x>/dt is the autocorrelation."""
    middle = np.array([0.5, 6.0, 30.0])
    step = 1e-3
    levels = 1.0 + step * np.array([-2.0, -1.0, 1.0, 2.0])
    times = np.sort(np.outer(middle, levels).ravel())
    x = run(e, ("mean_displacement",), times, Beam(), rtol=1e-14).mean_displacement[:, 0]
    change = x.reshape(-1, 4) @ np.array([1.0, -8.0, 8.0, -1.0]) / (12.0 * step * middle)
    found = run(e, ("velocity_autocorrelation", "mean_velocity"), middle, Beam())
    assert np.abs(found.velocity_autocorrelation - change).max() < 1e-9
    # and for a beam it is U times the mean velocity, which another part solves
    assert np.abs(found.velocity_autocorrelation - found.mean_velocity[:, 0]).max() < 1e-10


@pytest.mark.parametrize("rtol", [1e-3, 1e-6, 1e-10])
@pytest.mark.parametrize("e", [0.83, 1.0])
def test_the_error_of_the_autocorrelation_is_relative_to_the_speeds(e: float, rtol: float) -> None:
    """To v_rms(0) v_rms(t): the autocorrelation itself passes through 0, or falls much faster."""
    times = np.concatenate([[0.0], np.geomspace(0.1, 1e5, 60)])
    names = ("velocity_autocorrelation", "temperature")
    found = run(e, names, times, "monoenergetic", rtol=rtol)
    exact = run(e, names, times, "monoenergetic", rtol=1e-13)
    expected = exact.velocity_autocorrelation
    if e == 1.0:
        with np.errstate(under="ignore"):
            expected = np.exp(-4.0 / 3.0 * times / LENGTH)
    scale = np.sqrt(2.0 * exact.temperature)  # v_rms(0) = 1
    assert found.status is SolverStatus.CONVERGED
    assert np.abs((found.velocity_autocorrelation - expected) / scale).max() <= rtol
    assert "relative to v_rms(0) v_rms(t)" in OUTPUTS["velocity_autocorrelation"].description


def test_the_autocorrelation_does_not_depend_on_the_direction() -> None:
    times = [0.0, 1.0, 50.0]
    name = ("velocity_autocorrelation",)
    straight = run(0.6, name, times, Beam(speeds="gaussian"), rtol=1e-13)
    all_ways = run(0.6, name, times, rtol=1e-13)
    assert np.allclose(
        straight.velocity_autocorrelation, all_ways.velocity_autocorrelation, rtol=1e-12
    )
    assert abs(all_ways.velocity_autocorrelation[0] - 2.0) < 1e-12


def test_short_times_are_ballistic() -> None:
    times = [0.0, 1e-200, 1e-5]
    for initial, second, fourth in (("gaussian", 2.0, 8.0), ("monoenergetic", 1.0, 1.0)):
        for e in (0.0, 0.5, 1.0):
            names = ("kurtosis", "mean_displacement", "diffusion_coefficient")
            found = run(e, names, times, initial, rtol=1e-13)
            assert np.abs(found.kurtosis / (fourth / second**2) - 1.0).max() < 1e-5
            assert abs(found.diffusion_coefficient[1] / (0.5 * second * 1e-200) - 1.0) < 1e-12
            assert not found.mean_displacement.any()


def test_late_kurtosis_tends_to_that_of_a_gaussian_like_1_over_ln_t() -> None:
    times = np.array([1e50, 1e100, 1e200, 1e300])
    for e in (0.0, 0.4, 0.9):
        above = run(e, ("kurtosis",), times).kurtosis - 2.0
        # <r^4> and <r^2> are polynomials in ln t: the excess times ln t has a limit
        scaled = above * np.log(times)
        assert np.all(above > 0.0)
        assert abs(scaled[-1] / scaled[-2] - 1.0) < 0.05


def test_a_table_of_speeds_gives_what_its_speeds_give() -> None:
    speed = np.linspace(0.0, 2.0, 9)
    density = np.array([0.0, 1.0, 2.0, 2.0, 1.5, 1.0, 0.4, 0.1, 0.0])
    density /= np.trapezoid(density, speed)
    times = [0.3, 10.0, 400.0]
    state = SpeedTable(speed, density)
    found = run(0.5, NAMES, times, state)
    x, w = np.polynomial.legendre.leggauss(30)
    squares = np.zeros(3)
    for low, high in itertools.pairwise(speed):
        v = 0.5 * (low + high) + 0.5 * (high - low) * x
        weight = 0.5 * (high - low) * w * np.interp(v, speed, density)
        for speed_, share in zip(v, weight, strict=True):
            squares += share * run(0.5, ("msd",), np.asarray(times) * speed_, "monoenergetic").msd
    assert np.abs(found.msd / squares - 1.0).max() < 1e-8


@pytest.mark.parametrize(
    ("e", "times"), [(0.3, [1e-300, 1e-100, 1.0, 1e300]), (1.0, [1e-300, 1.0, 1e150])]
)
def test_extreme_times_stay_finite(e: float, times: list[float]) -> None:
    outputs = ("kurtosis", "velocity_autocorrelation", "diffusion_coefficient", "mean_displacement")
    found = run(e, outputs, times, Beam(speeds="gaussian"))
    assert found.status is SolverStatus.CONVERGED
    for value in found.values.values():
        assert np.all(np.isfinite(value))
