"""Densities of the velocity of spheres, rough scatterers and laws of samples, by other routes."""

import math
from functools import partial
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from example_values import DENSITY, gaussian_speeds
from marking import slow_but
from moment_hierarchy import chance_of_bounces
from scipy.integrate import quad
from scipy.special import eval_legendre

from kinetics import (
    AngularHarmonics,
    Beam,
    CollisionLaw,
    Monoenergetic,
    ScalingSolution,
    Scene,
    Solution,
    SolverStatus,
    solve,
)

OUTPUTS = ("speed_density", "thermal_speed")
LAWS: dict[str, CollisionLaw] = {
    **{f"disks, {e}": CollisionLaw(e) for e in (0.0, 0.05, 0.4, 0.8, 0.95)},
    "spheres, 0": CollisionLaw(0.0, dimension=3),
    "spheres, 0.7": CollisionLaw(0.7, dimension=3),
    "rough disks": CollisionLaw(0.7, 0.8),
    "rough spheres": CollisionLaw(0.8, 0.3, 3),
    "no slip": CollisionLaw(0.5, 0.0, 3),
    "two kinds of disk": CollisionLaw.from_samples([0.5, 0.5], [0.9, 0.4], [0.0, 0.3]),
    "some elastic": CollisionLaw.from_samples([0.5, 0.5], [1.0, 0.4], [0.0, 0.3], 3),
}
# At those of a few ratios v t/l oscillates for long; the closed form of "no slip" takes seconds.
SMOOTH = tuple(LAWS)[:9]
SOME = ("disks, 0.05", "disks, 0.95", "rough spheres", "two kinds of disk")


def solved(law: CollisionLaw, paths: Any, rtol: float, **options: Any) -> Solution:
    """The scene with l = 1, at times in l/U."""
    asked = {"outputs": OUTPUTS, "initial": "gaussian", **options}
    return solve(Scene(law, number_density=DENSITY[law.dimension], times=paths, **asked), rtol)


@pytest.mark.parametrize("name", slow_but(SOME, LAWS))
def test_mass_moments_and_sign(name: str) -> None:
    """Against the backward equation, which has no density in it."""
    law, rtol = LAWS[name], 2e-10  # at 1e-10 it hangs on the processor
    solution = solved(law, [0.0, 0.04, 0.5, 10.0, 300.0, 1e5, 1e9], rtol)
    assert solution.status is SolverStatus.CONVERGED
    for i, thermal in enumerate(solution.thermal_speed):
        x = np.linspace(math.log(1e-13 * thermal), math.log(60.0 * thermal), 2000)
        v = np.exp(x)
        f = solution.speed_density(v)[i]
        assert (v * f).min() >= -rtol * (v * f).max()
        weight = (x[1] - x[0]) * v * f
        assert weight.sum() == pytest.approx(1.0, abs=rtol)
        for p in (1.0, 2.0, 4.0):
            exact = float(solution.moment(p)[i])
            assert weight @ v**p == pytest.approx(exact, rel=1e-6 if p == 4.0 else 2e-8, abs=0.0)


@pytest.mark.parametrize("name", SMOOTH)
def test_late_times_are_the_scaling_solution(name: str) -> None:
    law, c = LAWS[name], np.array([0.02, 0.3, 0.7, 1.0, 1.4, 2.5])
    solution, exact = solved(law, [1e8, 1e13], 1e-10), ScalingSolution(law)
    for i, thermal in enumerate(solution.thermal_speed):
        found = solution.speed_density(c * thermal)[i] * thermal
        shape = law.unit_surface * c ** (law.dimension - 1) * exact.vdf(c)
        # transients fall as t0/t
        assert np.max(np.abs(found - shape)) <= (2e-6 if i == 0 else 2e-8) * shape.max()


def by_collisions(e: float, t: float, v: float) -> float:
    """f(v, t) of a Gaussian start where every bounce leaves e of the speed, l = 1.

    Tracers with n bounces began with u = v/e^n, at the n + 1 rates u, u e, ...
    """
    with mp.workdps(100):
        total, e_ = mp.mpf(0), mp.mpf(e)
        for n in range(60):
            u = mp.mpf(v) / e_**n
            start = u * mp.exp(-u * u / 2)
            if n > 3 and start < mp.mpf(10) ** -25:
                break
            total += start / e_**n * chance_of_bounces([u * e_**j for j in range(n + 1)], t)
        return float(total)


@pytest.mark.parametrize("rtol", [1e-4, 1e-9])
@pytest.mark.parametrize("e", [0.2, 0.7])
def test_one_ratio_collision_by_collision(e: float, rtol: float) -> None:
    law, times = CollisionLaw(e, e), [0.5, 5.0, 100.0]
    solution = solved(law, times, rtol)
    assert solution.status is SolverStatus.CONVERGED
    for i, t in enumerate(times):
        v = np.array([1e-2, 0.1, 0.5, 1.0, 2.0]) * solution.thermal_speed[i]
        exact = [by_collisions(e, t, x) for x in v]
        found = solution.speed_density(v)[i]
        assert np.max(np.abs(found - exact)) < rtol * max(exact)


def test_random_scission_in_space() -> None:
    """e = 0: s^2 is uniform. K(v), the integral of (w - v) f(w)/w above v, dies as exp(-v t/l).

    f = v K''; for a Maxwell start K(v) = erfc(v/sqrt 2) at t = 0.
    """
    v, times = np.geomspace(1e-3, 5.0, 50), np.array([0.0, 0.4, 3.0, 50.0])
    found = solved(LAWS["spheres, 0"], times, 1e-11).speed_density(v)
    t, slope = times[:, None], math.sqrt(2.0 / math.pi) * np.exp(-0.5 * v * v)
    rest = np.array([math.erfc(x / math.sqrt(2.0)) for x in v])
    exact = v * np.exp(-v * t) * (t * t * rest + 2.0 * t * slope + v * slope)
    assert np.max(np.abs(found - exact) / exact.max(axis=1, keepdims=True)) < 1e-11


def test_elastic_spheres_scatter_in_all_directions_alike() -> None:
    """Harmonic m > 0 dies as exp(-v t/l), whatever m is; speeds are kept."""
    maxwell = partial(gaussian_speeds, dimension=3)
    start = AngularHarmonics(
        {0: maxwell, 1: lambda v: 0.5 * maxwell(v), 3: lambda v: 0.2 * maxwell(v)}
    )
    solution = solved(
        CollisionLaw(1.0, dimension=3), [0.0, 2.0], 1e-10, initial=start,
        outputs=("velocity_density",),
    )  # fmt: skip
    v, angle = np.array([0.3, 1.0, 2.5]), np.array([0.0, 1.0, 2.0])
    for i, t in enumerate((0.0, 2.0)):
        turn = 1.5 * np.cos(angle) + 1.4 * eval_legendre(3, np.cos(angle))
        exact = 1.0 + np.exp(-v * t)[:, None] * turn
        exact *= (maxwell(v) / (4.0 * np.pi * v**2))[:, None]
        np.testing.assert_allclose(solution.velocity_density(v, angle)[i], exact, rtol=1e-13)


@pytest.mark.parametrize(
    ("law", "rtol"), [(CollisionLaw(1.0, 0.0), 1e-4), (CollisionLaw(0.0, 0.8, 3), 1e-6)], ids=repr
)
def test_the_density_at_rest_is_that_of_the_start(law: CollisionLaw, rtol: float) -> None:
    """No bounce leads to v = 0: f, continued to low speeds, was once below 0 by 40 rtol there."""
    found = solved(law, [0.0, 1e-300, 0.04, 2.4, 80.0], rtol)
    for i, thermal in enumerate(found.thermal_speed):
        v = thermal * np.append(0.0, np.geomspace(1e-300, 1.0, 3000))
        f = found.speed_density(v)[i]
        assert f.min() > -0.1 * rtol * f.max()
        low = v < 1e-8 * thermal
        assert np.abs(f[low]).max() < rtol * f.max()


@pytest.mark.parametrize(("e", "t"), [(0.2, 1.0), (0.6, 5.0), (0.9, 20.0)])
def test_one_component_against_quadrature_of_the_speed_density(e: float, t: float) -> None:
    """With v = v_x cosh(u) the integrand is f(v_x cosh u)/pi."""
    solution = solved(CollisionLaw(e), [t], 1e-8)
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
def test_one_component_of_one_speed(e: float, initial: Any) -> None:
    """1/(pi sqrt(u^2 - v_x^2)): the ring."""
    v_x = np.array([-1.9, -1.0, 0.0, 0.5, 1.99, 2.5])
    solution = solved(CollisionLaw(e), [0.0], 1e-3, initial=initial)
    found = solution.velocity_component_density(v_x)[0]
    with np.errstate(invalid="ignore"):
        exact = np.where(np.abs(v_x) < 2.0, 1.0 / (np.pi * np.sqrt(4.0 - v_x**2)), 0.0)
    assert np.allclose(found, exact, rtol=1e-9)


def test_one_component_grows_as_a_logarithm_where_the_speed_density_is_finite_at_rest() -> None:
    """At e = 0 the speed density is g at rest, and adds (g/pi) ln(1/v_x)."""
    solution = solve(Scene(0.0, times=[1.0, 30.0], outputs=("speed_density",)), rtol=1e-8)
    slow = solution.velocity_component_density([1e-12, -1e-9, 0.0])
    at_rest = solution.speed_density([1e-12])[:, 0]
    expected = at_rest / np.pi * np.log(1e3)
    assert slow[:, 0] - slow[:, 1] == pytest.approx(expected, rel=1e-6)
    assert np.all(np.isposinf(slow[:, 2]))


def test_one_component_is_finite_at_rest_where_the_speed_density_vanishes() -> None:
    scenes = (Scene(0.4, times=[1.0], outputs=("speed_density",)),
              Scene(0.0, dimension=3, times=[1.0], outputs=("speed_density",)))  # fmt: skip
    for scene in scenes:
        at_rest, slow = solve(scene, rtol=1e-8).velocity_component_density([0.0, 1e-10])[0]
        assert at_rest == pytest.approx(slow, rel=1e-7)
