"""F(k, t): against the moments of the displacement, more accurate solutions, and itself."""

import math
import warnings
from typing import Any

import numpy as np
import pytest

from kinetics import Beam, CollisionLaw, Gaussian, Scene, ToleranceWarning, solve
from kinetics.position import scattering
from kinetics.position.scattering import solve_waves


def test_a_directed_start_gives_the_mean_displacement() -> None:
    outputs = ("mean_displacement", "intermediate_scattering", "msd")
    found = solve(Scene(0.5, initial=Beam(0.7), times=[2.0, 80.0], outputs=outputs))
    k = 1e-4
    for angle in (0.0, 0.7, 2.0):
        f = found.intermediate_scattering([k], direction=angle)[:, 0]
        along = found.mean_displacement @ np.array([math.cos(angle), math.sin(angle)])
        assert np.abs(f.imag / k - along).max() < 1e-5 * np.abs(found.mean_displacement).max()
    # the mean over the directions of k is what no direction gives
    angles = 2.0 * math.pi * np.arange(24) / 24
    mean = np.mean([found.intermediate_scattering([0.05], direction=a) for a in angles], axis=0)
    assert np.abs(mean - found.intermediate_scattering([0.05])).max() < 1e-10


@pytest.mark.parametrize(
    ("e", "t", "initial", "k"),
    [
        (0.6, 100.0, Beam(0.7), 0.5),
        (0.9, 20.0, Gaussian(2.0, 1.0), 0.4),
        (0.3, 3.0, Beam(0.2, speeds="gaussian"), 1.0),
    ],
)
def test_directed_starts_meet_the_accuracy_asked_for(
    e: float, t: float, initial: Any, k: float
) -> None:
    """Every harmonic of the start counts there, and each has to be resolved in speed and angle."""
    scene = Scene(e, initial=initial, times=[t], outputs=("intermediate_scattering",))
    wave_numbers = k * np.array([0.1, 0.6, 1.0])
    with warnings.catch_warnings():
        # it misses 1e-12 in one of the cases, with an estimate of 8e-11, and says so
        warnings.simplefilter("ignore", ToleranceWarning)
        best = solve(scene, rtol=1e-12).intermediate_scattering(wave_numbers, direction=0.3)
    for rtol in (1e-3, 1e-6, 1e-9):
        found = solve(scene, rtol=rtol).intermediate_scattering(wave_numbers, direction=0.3)
        assert np.abs(found - best).max() < rtol


def test_a_scattering_function_that_misses_its_tolerance_says_so(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """With too few harmonics, as once where free flights reach many of them at once."""
    scene = Scene(1.0, initial=Beam(), times=[150.0], outputs=("intermediate_scattering",))
    solution = solve(scene, rtol=1e-9)
    right = solution.intermediate_scattering([1.5], direction=0.3)
    monkeypatch.setattr(scattering, "_harmonics", lambda *arguments: 60)
    with pytest.warns(ToleranceWarning, match=r"F\(k, t\): the error estimate"):
        found = solution.intermediate_scattering([1.5], direction=0.3)
    assert np.abs(found - right).max() > 1e-9


@pytest.mark.parametrize(
    ("e", "initial", "t", "k"),
    [
        (0.7, Beam(), 1e3, 2.0),
        pytest.param(0.7, Beam(), 1e300, 2.0, marks=pytest.mark.slow),
        (1.0, Gaussian(), 1e300, 1e-3),
        (1.0, Gaussian(), 1e300, 1e-150),
        (1.0, Beam(), 1.0, 2.0),
        (1.0, Beam(), 150.0, 1.5),
    ],
    ids=repr,
)
def test_a_scattering_function_that_meets_its_tolerance_does_not_warn(
    e: float, initial: Any, t: float, k: float
) -> None:
    """The error is that at the time asked for, not the largest of all times before."""
    scene = Scene(e, initial=initial, times=[t], outputs=("intermediate_scattering",))
    f = solve(scene, rtol=1e-9).intermediate_scattering([k], direction=0.3)
    best = solve(scene, rtol=1e-11).intermediate_scattering([k], direction=0.3)
    assert np.abs(f - best).max() < 1e-9


def test_waves_meet_the_accuracy_asked_for() -> None:
    """Against many more nodes and harmonics, over what a density uses."""
    x = np.linspace(-3.0, 6.0, 120)
    for e in (0.0, 0.5, 1.0):
        law = CollisionLaw(e)
        for k in (0.3, 2.0, 6.0):
            best = solve_waves(law, np.array([k]), 6.0, 1e-12)(x)
            for tolerance in (1e-4, 1e-7):
                found = solve_waves(law, np.array([k]), 6.0, tolerance)
                assert np.abs(found(x) - best).max() < tolerance
                assert found.errors[-1] < 10.0 * tolerance
