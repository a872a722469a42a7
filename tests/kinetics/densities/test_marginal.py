"""The density of one velocity component against closed forms and quadrature of the speed density.

For an isotropic velocity F(v_x) = (1/pi) integral over v > |v_x| of f(v)/sqrt(v^2 - v_x^2).
"""

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

from kinetics import Beam, Monoenergetic, Scene, solve


def scene(e: float, times: Any, initial: Any = "gaussian", dimension: int = 2) -> Scene:
    """With l = 1."""
    return Scene(
        e, 0.5 if dimension == 2 else 1.0 / np.pi, dimension=dimension, initial=initial,
        times=times, outputs=("speed_density", "thermal_speed"),
    )  # fmt: skip


@pytest.mark.parametrize(("e", "t"), [(0.2, 1.0), (0.6, 5.0), (0.9, 20.0)])
def test_against_quadrature_of_the_speed_density(e: float, t: float) -> None:
    """With v = v_x cosh(u) the integrand is f(v_x cosh u)/pi."""
    solution = solve(scene(e, [t]), rtol=1e-8)
    v0 = solution.thermal_speed[0]
    for v_x in np.array([0.1, 0.6, 1.3]) * v0:
        top = np.arccosh(9.0 * v0 / v_x)
        exact = quad(
            lambda u, a=v_x: solution.speed_density([a * np.cosh(u)])[0, 0] / np.pi,
            0.0,
            top,
            epsabs=1e-9,
        )[0]
        assert np.isclose(solution.velocity_component_density([v_x])[0, 0], exact, rtol=1e-6)


@pytest.mark.parametrize("initial", [Monoenergetic(2.0), Beam(0.3, Monoenergetic(2.0))])
@pytest.mark.parametrize("e", [0.5, 1.0])
def test_one_speed_at_the_start(e: float, initial: Any) -> None:
    """1/(pi sqrt(u^2 - v_x^2)): the ring."""
    v_x = np.array([-1.9, -1.0, 0.0, 0.5, 1.99, 2.5])
    found = solve(scene(e, [0.0], initial), rtol=1e-3).velocity_component_density(v_x)[0]
    with np.errstate(invalid="ignore"):
        exact = np.where(np.abs(v_x) < 2.0, 1.0 / (np.pi * np.sqrt(4.0 - v_x**2)), 0.0)
    assert np.allclose(found, exact, rtol=1e-9)


def test_random_scission_in_space() -> None:
    """e = 0: f = v K'', K = exp(-v t) erfc(v/sqrt 2), so that F = -K'(v_x)/2."""
    t, v_x = 2.0, np.array([0.0, 0.01, 0.3, 1.0])
    found = solve(scene(0.0, [t], dimension=3), rtol=1e-10).velocity_component_density(v_x)[0]
    rest = np.array([math.erfc(x / math.sqrt(2.0)) for x in v_x])
    slope = math.sqrt(2.0 / math.pi) * np.exp(-0.5 * v_x * v_x)
    exact = 0.5 * np.exp(-v_x * t) * (t * rest + slope)
    assert np.max(np.abs(found - exact)) < 1e-8 * exact.max()
