"""Directed states against the moment hierarchy in many digits, an integral, a small Monte Carlo."""

from typing import Any

import numpy as np
import pytest
from cooling import gaussian_moment
from example_values import gaussian_speeds
from moment_hierarchy import TIMES, rates, scene, series

from kinetics import AngularHarmonics, Beam, Gaussian, PolarGrid, VelocitySamples, solve


@pytest.mark.parametrize("m", [1, 2, 5])
@pytest.mark.parametrize("e", [0.0, 0.2, 1.0])
def test_harmonics_of_a_beam(e: float, m: int) -> None:
    """Error relative to <v^p>: what part of the tracers' motion is missed.

    Where e = 0 even m keep their sign at s = 0, where chi = pi/2, and odd m vanish.
    """
    for p in (-0.99, -0.5) if e == 0.0 else (0, 1, 2):
        exact = np.array([series(e, m, p, t) for t in TIMES])
        for rtol in (1e-6, 1e-10):
            solution = solve(scene(e, Beam()), rtol)
            error = np.abs(solution.harmonic(p, m) - exact) / solution.moment(p)
            assert np.max(error) <= rtol, (p, error)


@pytest.mark.parametrize("e", [0.2, 1.0])
def test_a_turned_beam_is_the_beam_turned(e: float) -> None:
    outputs = ("mean_velocity", "velocity_tensor")
    beam, turned = (solve(scene(e, Beam(angle), outputs=outputs)) for angle in (0.0, 2.2))
    turn = np.array([[np.cos(2.2), -np.sin(2.2)], [np.sin(2.2), np.cos(2.2)]])
    square = np.trace(beam.velocity_tensor, axis1=1, axis2=2)[:, None]
    apart = turned.mean_velocity - beam.mean_velocity @ turn.T
    assert np.max(np.abs(apart) / np.sqrt(square)) < 1e-13
    apart = turned.velocity_tensor - turn @ beam.velocity_tensor @ turn.T
    assert np.max(np.abs(apart) / square[:, :, None]) < 1e-13


@pytest.mark.parametrize(("sx", "sy"), [(1.3, 0.4), (0.5, 1.1)])
def test_two_temperature_gaussian_at_the_start(sx: float, sy: float) -> None:
    outputs = ("mean_velocity", "velocity_tensor", "velocity_density")
    solution = solve(scene(0.5, Gaussian(sx, sy), [0.0], outputs=outputs, harmonics=60), rtol=1e-6)
    assert np.allclose(solution.velocity_tensor[0], np.diag([sx**2, sy**2]), rtol=1e-6, atol=1e-12)
    assert np.allclose(solution.mean_velocity, 0.0, atol=1e-14)
    v, phi = np.linspace(0.05, 3.0, 30), np.linspace(-3.0, 3.0, 25)
    found = solution.velocity_density(v, phi)[0]
    x, y = v[:, None] * np.cos(phi), v[:, None] * np.sin(phi)
    exact = np.exp(-0.5 * ((x / sx) ** 2 + (y / sy) ** 2)) / (2 * np.pi * sx * sy)
    # densities are per dv: the error of f in the plane is larger by 1/v
    error = np.abs(found - exact) * v[:, None]
    assert np.max(error) < 1e-5 * np.max(exact * v[:, None])
    far = Gaussian(1e4, 1.0).profile(0)(np.array([8e4]))[0]  # half of a Gaussian line
    assert abs(far / (np.sqrt(2 / np.pi) * np.exp(-32.0) * 1e-4) - 1) < 1e-8


def test_angular_harmonics() -> None:
    """f = g(v) (1 + 0.6 cos(phi) + 0.5 sin(2 phi))/(2 pi v), g the speed density of a Gaussian."""
    g = gaussian_speeds
    terms = {0: g, 1: lambda v: 0.3 * g(v), 2: lambda v: -0.25j * g(v)}
    times = [0.0, 0.5, 2.0]
    outputs = ("velocity_density", "mean_velocity", "velocity_tensor")
    solution = solve(scene(0.7, AngularHarmonics(terms), times, outputs=outputs), rtol=1e-8)
    for m, factor in ((0, 1.0), (1, 0.3), (2, -0.25j), (3, 0.0)):
        exact = [factor * series(0.7, m, 2, t, gaussian_moment) for t in times]
        assert np.max(np.abs(solution.harmonic(2, m) - exact)) < 1e-8
    assert abs(solution.mean_velocity[0, 0] - 0.3 * np.sqrt(np.pi / 2)) < 1e-8
    assert abs(solution.velocity_tensor[0, 0, 1] - 0.25) < 1e-8  # <v^2> <sin 2 phi>/2
    v, phi = np.linspace(0.1, 3.0, 8), np.linspace(0.0, 6.0, 9)
    exact = (
        g(v)[:, None] * (1 + 0.6 * np.cos(phi) + 0.5 * np.sin(2 * phi)) / (2 * np.pi * v[:, None])
    )
    assert np.max(np.abs(solution.velocity_density(v, phi)[0] - exact)) < 1e-7 * exact.max()


def test_polar_grid_is_the_function_it_samples() -> None:
    """A shifted Gaussian: f > 0 everywhere, all harmonics present."""
    v = np.linspace(0.0, 7.0, 1401)
    phi = 2 * np.pi * np.arange(32) / 32

    def f(v: Any, phi: Any) -> Any:
        x, y = v * np.cos(phi) - 0.5, v * np.sin(phi) - 0.2
        return np.exp(-0.5 * (x * x + y * y)) / (2 * np.pi)

    values = f(v[:, None], phi)
    # what the linear interpolation of v f integrates to is part of the definition
    values /= np.trapezoid(values.mean(axis=1) * v, v) * 2 * np.pi
    state = PolarGrid(v, values)
    outputs = ("mean_velocity", "velocity_tensor", "velocity_density")
    solution = solve(scene(0.6, state, [0.0], outputs=outputs), rtol=1e-4)
    # linear interpolation on cells of 0.005 errs by 0.005^2/12
    assert np.allclose(solution.mean_velocity[0], [0.5, 0.2], atol=1e-5)
    exact = np.eye(2) + np.outer([0.5, 0.2], [0.5, 0.2])
    assert np.allclose(solution.velocity_tensor[0], exact, atol=1e-5)
    for m in (1, 3, 8):
        turned = values * np.exp(-1j * m * phi)
        direct = np.trapezoid(turned.mean(axis=1) * 2 * np.pi * v**2, v)
        assert abs(solution.harmonic(1, m)[0] - direct) < 1e-5
    at, angle = np.array([0.5, 1.0, 2.0]), np.array([0.3, 2.0, 4.0])
    found = solution.velocity_density(at, angle)[0]
    assert np.max(np.abs(found - f(at[:, None], angle))) < 1e-3 * 0.16


@pytest.mark.parametrize("n_phi", [3, 4, 5, 6])
def test_a_polar_grid_has_every_harmonic_below_half_of_its_angles(n_phi: int) -> None:
    """f = g(v)/(2 pi v) (1 + sum of a_m cos(m phi)), m < n_phi/2: <v cos(m phi)> is a_m <v>/2."""
    v = np.linspace(0.0, 2.0, 3)
    phi = 2.0 * np.pi * np.arange(n_phi) / n_phi
    size_of_harmonic = {m: 0.3 / m for m in range(1, (n_phi + 1) // 2)}
    angular = np.ones(n_phi)
    for m, size in size_of_harmonic.items():
        angular = angular - size * np.cos(m * phi)
    # v f is linear between 0, 1 and 2: a triangle, of integral 1 and mean 1
    values = np.outer([0.0, 1.0, 0.0], angular) / (2.0 * np.pi)
    solution = solve(scene(0.7, PolarGrid(v, values), [0.0], outputs="mean_velocity"))
    assert solution.mean_velocity[0, 0] == pytest.approx(-0.15, rel=1e-9)
    for m, size in size_of_harmonic.items():
        assert solution.harmonic(1, m)[0] == pytest.approx(-size / 2.0, rel=1e-9)


@pytest.mark.parametrize("n", [7, 20_000])  # kept as they are, and gathered on a grid
def test_samples_of_velocities(n: int) -> None:
    v = np.random.default_rng(5).normal([0.7, -0.2], [1.0, 0.5], (n, 2))
    outputs = ("thermal_speed", "mean_velocity", "velocity_tensor")
    solution = solve(scene(0.4, VelocitySamples(v), [0.0, 0.4], outputs=outputs))
    assert np.allclose(solution.mean_velocity[0], v.mean(axis=0), rtol=1e-11)
    assert np.allclose(solution.velocity_tensor[0], v.T @ v / n, rtol=1e-11)
    speed, phi = np.hypot(*v.T), np.arctan2(v[:, 1], v[:, 0])
    assert np.isclose(solution.thermal_speed[0] ** 2, np.mean(speed**2), rtol=1e-12)
    for m in (1, 2, 5):
        turn = np.exp(-1j * m * phi)
        known = [complex(np.mean(speed**q * turn)) for q in range(62)]
        nu = rates(0.4, m)
        factor, exact = 1.0, 0.0j
        for k in range(60):
            exact += factor * known[1 + k]
            factor *= -0.4 * float(nu[1 + k]) / (k + 1)
        assert abs(solution.harmonic(1, m)[1] - exact) < 1e-9


def test_elastic_densities() -> None:
    """f = g(v)/(2 pi v) (1 + 0.8 cos(2 (phi - 0.3)) exp(-nu_2 v t/l)): each speed for itself."""
    g = gaussian_speeds
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
