"""The error estimates of the densities: neither below the error nor far above it."""

import math
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from kinetics import (
    Beam,
    CollisionLaw,
    Gaussian,
    Scene,
    SolverStatus,
    SpeedTable,
    solve,
)
from kinetics.densities import conservative
from kinetics.densities.harmonic import HarmonicProblem
from kinetics.densities.spectral import solve_spectral


@pytest.mark.parametrize("time", [0.1, 1.0, 10.0, 100.0])
@pytest.mark.parametrize("e", [0.0, 0.3, 0.6, 0.9, 0.99, 0.999])
def test_the_estimate_follows_the_error(e: float, time: float) -> None:
    """Of a smooth start, at each time: an estimate of 0.8 once stood for errors of 2e-4."""
    law, times, v = CollisionLaw(e), np.array([time]), np.geomspace(1e-3, 8.0, 2000)
    asked = HarmonicProblem(law, 1.0, Gaussian(), 0, times, 1e-8)
    exact = solve_spectral(asked)
    found = conservative.solve_conservative(replace(asked, nodes=1500))
    assert exact is not None
    assert isinstance(found.density, conservative.NodeMasses)
    f = exact.at(0, v)
    seen = v > 1e-2 * math.sqrt(np.sum(f * v**3) / np.sum(f * v))
    error = float(np.max(np.abs(found.at(0, v) - f)[seen]) / f.max())
    assert 0.9 * error < found.error_estimate < 5.0 * error


@pytest.mark.parametrize("initial", ["monoenergetic", "table"])
def test_no_false_alarm_before_the_first_collisions_and_in_the_scaling_state(initial: str) -> None:
    table = SpeedTable([0.5, 1.0, 2.0], [0.0, 4.0 / 3.0, 0.0])
    start = table if initial == "table" else initial
    scene = Scene(0.999, initial=start, times=[0.0, 1e-300, 1e150], outputs=("speed_density",))
    assert solve(scene, 1e-3, method="conservative").status is SolverStatus.CONVERGED


def test_bounces_that_the_nodes_do_not_resolve_are_said_so() -> None:
    """At e = 0.999 a bounce loses a thousandth of the speed, less than the finest spacing."""
    scene = Scene(0.999, initial="monoenergetic", times=[12.5], outputs=("speed_density",))
    assert solve(scene, 1e-3).error_estimate > 0.1


@pytest.mark.parametrize("m", [0, 4])
def test_memory_is_some_times_that_of_the_result(m: int) -> None:
    times = np.geomspace(0.1, 1e3, 2500)
    asked = HarmonicProblem(CollisionLaw(0.99), 1.0, Gaussian(1.0, 2.0), m, times, 1e-10)
    solve_spectral(replace(asked, times=times[:2]))  # what is kept for the next question
    tracemalloc.start()
    try:
        found = solve_spectral(asked)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert found is not None
    assert peak < 3.5 * 8 * times.size * found.nodes


@pytest.mark.parametrize("m", [1, 2, 4, 8])
@pytest.mark.parametrize("e", [0.0, 1e-4, 0.03, 0.93])
def test_harmonics_of_a_beam_fit_into_their_window(e: float, m: int) -> None:
    # they fall as v^0.6 at low speeds, and what the window cut off was 5 times what was asked
    times = np.array([0.0, 0.1, 1.0, 10.0])
    start = Beam(0.3, Gaussian())
    for rtol in (1e-8, 1e-11):
        found = solve_spectral(HarmonicProblem(CollisionLaw(e), 1.0, start, m, times, rtol))
        assert found is not None
        assert found.error_estimate <= rtol


@pytest.mark.parametrize("e", [0.0, 0.5, 0.7, 0.8, 0.85, 0.9, 0.95, 0.99])
def test_a_tight_tolerance_is_reached_and_claimed(e: float) -> None:
    scene = Scene(e, times=[1.0, 30.0, 300.0], outputs=("speed_density",))
    found, other = solve(scene, 1e-12), solve(scene, 1e-13)
    assert found.status is SolverStatus.CONVERGED
    v = np.geomspace(1e-2, 3.0, 100)
    f, best = found.speed_density(v), other.speed_density(v)
    assert np.all(np.abs(f - best) < 1e-12 * best.max(axis=1, keepdims=True))
