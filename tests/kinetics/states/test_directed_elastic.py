"""Directed states at e = 1, where speeds are kept and there is nothing to discretise."""

from typing import Any

import mpmath as mp
import numpy as np
import pytest
from moment_hierarchy import rates, scene, velocities

from kinetics import AngularHarmonics, Beam, InputError, Monoenergetic, VelocitySamples, solve


@pytest.mark.parametrize("m", range(1, 9))
def test_elastic_rates(m: int) -> None:
    """nu_m = 1 - E[cos(m chi)], cos(chi) = 2 y^2 - 1; by hand 4 m^2/(4 m^2 - 1)."""
    nu = rates(1.0, m)[0]
    assert abs(nu - mp.mpf(4 * m * m) / (4 * m * m - 1)) < 1e-15
    times = np.array([0.0, 0.1, 1.0, 20.0, 600.0])
    solution = solve(scene(1.0, Beam(0.5, Monoenergetic(1.5)), times))
    with np.errstate(under="ignore"):
        exact = 1.5**3 * np.exp(-1j * m * 0.5) * np.exp(-float(nu) * 1.5 * times)
    assert np.allclose(solution.harmonic(3, m), exact, rtol=1e-12, atol=1e-300)


def test_elastic_densities() -> None:
    """f = g(v)/(2 pi v) (1 + 0.8 cos(2 (phi - 0.3)) exp(-nu_2 v t/l)): each speed for itself."""

    def g(v: Any) -> Any:
        return v * np.exp(-0.5 * v * v)

    terms = {0: g, 2: lambda v: 0.4 * np.exp(-0.6j) * g(v)}
    times = [0.0, 0.5, 10.0, 1e12]
    outputs = ("speed_density", "velocity_density", "thermal_speed", "a2")
    solution = solve(scene(1.0, AngularHarmonics(terms), times, outputs=outputs))
    v, phi = np.linspace(0.2, 4.0, 12), np.linspace(-3.0, 3.0, 11)
    assert np.allclose(solution.speed_density(v), g(v), rtol=1e-14)
    assert np.allclose(solution.thermal_speed, np.sqrt(2.0), rtol=1e-10)
    assert np.allclose(solution.a2, 0.0, atol=1e-9)
    for t, found in zip(times, solution.velocity_density(v, phi), strict=True):
        with np.errstate(under="ignore"):
            kept = np.exp(-16.0 / 15.0 * v * t)[:, None]
        turn = 1.0 + 0.8 * np.cos(2.0 * (phi - 0.3)) * kept
        assert np.allclose(found, (g(v) / (2 * np.pi * v))[:, None] * turn, rtol=1e-12)


def test_elastic_samples_have_no_density() -> None:
    with pytest.raises(InputError, match=r"^initial: samples have no density"):
        solve(scene(1.0, VelocitySamples(velocities(5)), [1.0], outputs=("velocity_density",)))


@pytest.mark.parametrize("e", [0.0, 0.6, 1.0])
def test_elastic_or_not_isotropic_starts_have_no_direction(e: float) -> None:
    outputs = ("mean_velocity", "velocity_tensor", "temperature")
    solution = solve(scene(e, "gaussian", outputs=outputs))
    assert np.all(solution.mean_velocity == 0.0)
    exact = solution.temperature[:, None, None] * np.eye(2)
    assert np.allclose(solution.velocity_tensor, exact, rtol=1e-13, atol=0)
