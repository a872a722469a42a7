"""Densities of the velocity over time in a field: against averages, closed forms and limits."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from kinetics import Beam, CollisionLaw, InputError, Scene, load, solve, solve_field
from kinetics.field.backward import backward_panels
from kinetics.field.collided_once import (
    _of_one,
    once_collided,
    once_collided_by_speed,
    once_collided_isotropic,
)
from kinetics.field.collisions import collision_matrices, gain_matrices
from kinetics.field.densities import FieldDensities
from kinetics.field.first_collision import Rays
from kinetics.field.resolution import TimeResolution
from kinetics.numerics.gauss import panels_between
from kinetics.states.isotropic import Rest

PATH = 12.5  # l at number_density 0.04
BOTH = ("thermal_speed", "mean_velocity", "speed_density", "velocity_density")


def scene(times: Any, field: float = 0.08, **arguments: Any) -> Scene:
    """Times in sqrt(l/g)."""
    given = {"restitution": 0.7, "initial": "gaussian", "outputs": BOTH, **arguments}
    path = PATH if given.get("dimension", 2) == 2 else 1.0 / (math.pi * 0.04)
    return Scene(times=np.asarray(times) * math.sqrt(path / field), field=field, **given)


@pytest.mark.parametrize(("dimension", "times"), [(2, [0.0, 1.0]), (3, [1.0])])
def test_moments_are_those_of_the_averages(dimension: int, times: list[float]) -> None:
    """1, <v^2> and <v_x> of the densities; the backward equation shares no grid with them."""
    found = solve(scene(times, dimension=dimension), rtol=1e-4)
    assert found.status.name == "CONVERGED"
    v, w = panels_between(np.linspace(0.0, 8.0, 9), 6)
    f = found.speed_density(v)
    assert f @ w == pytest.approx(1.0, abs=2e-5)
    assert f @ (w * v * v) == pytest.approx(found.thermal_speed**2, rel=1e-4)
    angle, share = panels_between(np.array([0.0, 0.3, 1.5, math.pi]), 6)
    v, w = panels_between(np.linspace(0.0, 8.0, 5), 8)
    mean = np.einsum(
        "tva,v,a->t",
        found.velocity_density(v, angle),
        w * v**dimension,
        share * np.cos(angle) * (2.0 if dimension == 2 else 2.0 * math.pi * np.sin(angle)),
    )
    error = np.abs(mean - found.mean_velocity[:, 0])
    assert np.all(error <= 1e-4 * found.thermal_speed)


@pytest.mark.slow
def test_late_densities_are_those_of_the_steady_state() -> None:
    """On the ray along the field too, on which harmonics of the steady state converge slowly."""
    found = solve(scene([16.0], outputs=("velocity_density",)), rtol=1e-5)
    unit = math.sqrt(0.08 * PATH)
    v, angle = np.array([0.3, 1.0, 2.0]), np.array([0.0, 0.02, 0.7, 2.0, 3.0, -2.0])
    expected = solve_field(0.7, rtol=1e-8).vdf(v / unit, angle) / unit**2
    assert found.velocity_density(v, angle)[0] == pytest.approx(expected, abs=3e-6)


def test_elastic_tracers_reach_the_self_similar_state() -> None:
    """f ~ exp(-8 v^3/(27 t)), up to the drift, which is a small part of the speed late."""
    state = Scene(0.7, times=[1.0]).state
    resolution = TimeResolution.for_densities(1e-3)
    found = FieldDensities(CollisionLaw(1.0), state, 1.0, np.array([300.0]), resolution)
    v = np.array([2.0, 5.0, 8.0, 11.0])
    a = 8.0 / (27.0 * 300.0)
    expected = 3.0 * a ** (2.0 / 3.0) / math.gamma(2.0 / 3.0) * v * np.exp(-a * v**3)
    peak = expected.max()
    assert found.by_speed(0, v) == pytest.approx(expected, abs=5e-3 * peak)


def test_from_rest_the_uncollided_are_apart() -> None:
    solution = solve(scene([0.5, 1.5, 12.0], initial="rest"), rtol=0.1)
    t = np.array([0.5, 1.5, 12.0])
    assert solution.uncollided == pytest.approx(np.exp(-0.5 * t * t), rel=1e-12)
    v, w = panels_between(np.array([0.0, 0.35, 0.5, 1.05, 1.5, 3.0, 4.5, 8.0]), 8)
    total = solution.speed_density(v * math.sqrt(0.08 * PATH)) @ w * math.sqrt(0.08 * PATH)
    assert total + solution.uncollided == pytest.approx(1.0, abs=3e-3)
    state = solve_field(0.7, rtol=1e-4)
    steady = state.vdf(v, [0.5, 2.0])
    late = solution.velocity_density(v, [0.5, 2.0])[2]
    with pytest.raises(InputError, match="smooth starts"):
        solution.velocity_component_density([0.1])
    assert late == pytest.approx(steady, abs=0.01 * steady.max())


@pytest.mark.parametrize("dimension", [2, 3])
def test_those_that_have_collided_once(dimension: int) -> None:
    """Integral over the velocities: the chance of one collision, by another integral."""
    rays, time, e = Rays(np.array([0.4]), np.zeros(1), np.ones(1), True), 1.2, 0.6
    v, w = panels_between(np.linspace(0.0, 1.6, 81), 6)
    found = float(once_collided_by_speed(rays, e, dimension, time, v) @ w)
    law = CollisionLaw(e, dimension=dimension)
    q = law.quadrature_for(10.0, 4)
    tau, share = panels_between(np.linspace(0.0, time, 4), 8)
    first = 0.4 + tau
    after = first[:, None] * np.exp(-q.log_loss)
    angle = np.arccos(np.clip(q.harmonic(1), -1.0, 1.0))
    left = Rays((after * np.cos(angle)).ravel(), (after * np.sin(angle)).ravel(), w[:0], True)
    way = left.way(np.repeat(time - tau, q.log_loss.size)).reshape(after.shape)
    chance = share * first * np.exp(-rays.way(tau[None])[0])
    assert found == pytest.approx(float(chance @ (np.exp(-way) @ q.weight)), rel=2e-3)


def test_once_collided_from_all_directions() -> None:
    """Against sums over many directions: of the start in the plane, of turns in space."""
    velocity = np.array([0.3, -0.4, 1.0]), np.array([0.2, 0.1, 0.5])
    angle = (np.arange(800) + 0.5) * (2.0 * math.pi / 800)
    many = Rays(np.cos(angle), np.sin(angle), np.full(800, 1.0 / 800), False)
    expected = once_collided(many, 0.7, 2, 1.2, *velocity)
    found = once_collided_isotropic(1.0, 0.7, 1.2, *velocity)
    assert found == pytest.approx(expected, rel=1e-2)
    ring = Rays(np.array([0.4]), np.array([0.6]), np.ones(1), True)
    # a start turned about the field is a velocity turned: sqrt(p^2 + q^2 - 2 p q cos) apart
    start = 0.4, 0.6 * np.cos(angle[None]), 0.36
    turned = _of_one(start, 0.7, 3, 1.2, *velocity).mean(axis=1)
    assert once_collided(ring, 0.7, 3, 1.2, *velocity) == pytest.approx(turned, rel=1e-2)


def test_no_density_where_one_collision_does_not_take() -> None:
    """Nobody has gained more than the field gives, and those at the free fall are left out."""
    rays = Rays(np.zeros(1), np.zeros(1), np.ones(1), True)
    velocity = np.array([1.1, 0.0, 1.0, -0.9]), np.array([0.0, 1.2, 0.0, 0.0])
    assert np.all(once_collided(rays, 0.7, 2, 1.0, *velocity) == 0.0)


def test_gain_keeps_the_mass_and_is_that_of_smooth_densities() -> None:
    """Against collocation, for a density that polynomials resolve."""
    law, panels = CollisionLaw(0.7), backward_panels(6.0, 0.3, 16)
    gain = gain_matrices(panels, law, 3, 40.0)
    v, f = panels.speeds, np.exp(-(panels.speeds**2))
    mass = v * panels.weights
    assert mass @ gain[0] == pytest.approx(mass * v, rel=1e-11)
    lost = collision_matrices(panels, law, 3, True, 40.0)
    for m in range(4):
        expected = v * f - lost[m] @ f / v
        assert gain[m] @ f == pytest.approx(expected, abs=1e-6)


def test_a_start_that_is_not_symmetric() -> None:
    """A beam across the field: both directions across it differ, and the total is 1."""
    state = Scene(0.7, times=[1.0], initial=Beam(1.2)).state
    found = FieldDensities(
        CollisionLaw(0.7), state, 1.0, np.array([1.0]), TimeResolution(6, 7, 0.1, 1e-3)
    )
    up, down = found.at(0, np.array([0.2, 0.2]), np.array([0.5, -0.5]))
    assert abs(up - down) > 0.02
    v, w = panels_between(np.linspace(0.0, 2.4, 25), 4)
    assert found.by_speed(0, v) @ w + found.uncollided[0] == pytest.approx(1.0, abs=5e-3)


def test_densities_of_rough_scatterers_from_rest_are_refused() -> None:
    asked = scene([1.0], initial="rest", outputs=("speed_density",), tangential_restitution=0.5)
    with pytest.raises(InputError, match="smooth scatterers"):
        solve(asked, rtol=0.1)


def test_a_solution_with_densities_is_a_value(tmp_path: Path) -> None:
    solution = solve(scene([0.5], outputs=("speed_density", "mean_velocity")), rtol=0.1)
    solution.save(tmp_path / "field.h5")
    again = load(tmp_path / "field.h5")
    v = np.array([0.5, 1.0, 2.0])
    assert again == solution
    assert np.array_equal(again.speed_density(v), solution.speed_density(v))
    assert again.to_dataframe("speed_density", speeds=v).shape[0] == 3
    assert solution.plan[1].part == "densities"
    v, w = panels_between(np.linspace(-7.0, 7.0, 8), 6)
    f = solution.velocity_component_density(v)[0]
    assert f @ w == pytest.approx(1.0, abs=1e-3)
    assert f @ (w * v) == pytest.approx(solution.mean_velocity[0, 0], abs=1e-3)
    assert Rest() != solution.scene.state
