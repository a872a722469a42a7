"""Densities of the velocity over time in a field: against averages, closed forms and limits."""

import math
from typing import Any

import numpy as np
import pytest
from marking import slow_but

from kinetics import (
    Beam,
    CollisionLaw,
    InputError,
    Scene,
    ToleranceWarning,
    solve,
    solve_field,
)
from kinetics.field.grid import SpeedPanels, loss_matrices
from kinetics.numerics.gauss import panels_between

PATH = 12.5  # l at number_density 0.04
BOTH = ("thermal_speed", "mean_velocity", "speed_density", "velocity_density")
UNIT = math.sqrt(0.08 * PATH)


def scene(times: Any, field: float = 0.08, **arguments: Any) -> Scene:
    """Times in sqrt(l/g)."""
    given = {"restitution": 0.7, "initial": "gaussian", "outputs": BOTH, **arguments}
    path = PATH if given.get("dimension", 2) == 2 else 1.0 / (math.pi * 0.04)
    return Scene(times=np.asarray(times) * math.sqrt(path / field), field=field, **given)


@pytest.mark.parametrize(("dimension", "times"), [(2, [0.0, 1.0]), (3, [1.0])])
def test_moments_are_those_of_the_averages(dimension: int, times: list[float]) -> None:
    """1, <v^2> and <v_x> of the densities."""
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


def test_late_densities_are_those_of_the_steady_state() -> None:
    """On the ray along the field too, on which harmonics of the steady state converge slowly."""
    found = solve(scene([16.0], outputs=("velocity_density",)), rtol=1e-5)
    v, angle = np.array([0.3, 1.0, 2.0]), np.array([0.0, 0.02, 0.7, 2.0, 3.0, -2.0])
    expected = solve_field(0.7, rtol=1e-8).vdf(v / UNIT, angle) / UNIT**2
    assert found.velocity_density(v, angle)[0] == pytest.approx(expected, abs=1e-5)


def test_elastic_tracers_reach_the_self_similar_state() -> None:
    """f ~ exp(-8 v^3/(27 t)), up to the drift, which is a small part of the speed late."""
    found = solve(scene([300.0], restitution=1.0, outputs=("speed_density",)), rtol=1e-3)
    v = np.array([2.0, 5.0, 8.0, 11.0])
    a = 8.0 / (27.0 * 300.0)
    expected = 3.0 * a ** (2.0 / 3.0) / math.gamma(2.0 / 3.0) * v * np.exp(-a * v**3)
    density = found.speed_density(v * UNIT)[0] * UNIT
    assert density == pytest.approx(expected, abs=5e-3 * expected.max())


@pytest.mark.parametrize("et", slow_but([1.0], [1.0, 0.5]))
def test_from_rest_the_uncollided_are_apart(et: float) -> None:
    """Those that have collided once have fronts: the status says that they are missed."""
    asked = scene([0.5, 1.5, 12.0], initial="rest", tangential_restitution=et)
    with pytest.warns(ToleranceWarning, match="densities"):
        solution = solve(asked, rtol=1e-3)
    t = np.array([0.5, 1.5, 12.0])
    assert solution.uncollided == pytest.approx(np.exp(-0.5 * t * t), rel=1e-12)
    v, w = panels_between(np.array([0.0, 0.35, 0.5, 1.05, 1.5, 3.0, 4.5, 8.0]), 8)
    f = solution.speed_density(v * UNIT) * UNIT
    assert f @ w + solution.uncollided == pytest.approx(1.0, abs=3e-3)
    assert f.min() < -1e-3  # densities are no better than that there
    steady = solve_field(0.7, 2, et, rtol=1e-4).vdf(v, [0.5, 2.0])
    late = solution.velocity_density(v * UNIT, [0.5, 2.0])[2] * UNIT**2
    with pytest.raises(InputError, match="velocity_density"):
        solution.velocity_component_density([0.1])
    assert late == pytest.approx(steady, abs=0.01 * steady.max())


def test_the_collision_term_keeps_mass_and_is_that_of_smooth_densities() -> None:
    """Its balance of v^p is the decay rate of the law, and its gain the average over a bounce."""
    law, panels = CollisionLaw(0.7), SpeedPanels.rising(6.0, 0.3, 16)
    lost = loss_matrices(panels, law, 3)
    v, f = panels.speeds, np.exp(-(panels.speeds**2))
    for p in (0.0, 1.0, 2.0, 4.0):
        weight = v ** (p + 1.0) * panels.weights
        expected = float(law.decay_rate(p)) * (weight * v)
        assert weight @ lost[0] == pytest.approx(expected, abs=1e-11 * weight.max())
    q = law.quadrature_for(40.0, 3)
    for m in range(4):
        before = v[:, None] / q.ratio
        gain = v * (np.exp(-(before**2)) @ (q.weight * q.ratio**-3.0 * (1.0 - q.harmonic_loss(m))))
        assert v * f - lost[m] @ f == pytest.approx(gain, abs=1e-6)


def test_a_start_that_is_not_symmetric() -> None:
    """A beam across the field: both directions across it differ, and the total is 1."""
    asked = scene([1.0], 1.0 / PATH, initial=Beam(1.2))
    with pytest.warns(ToleranceWarning, match="densities"):
        found = solve(asked, rtol=1e-3)
    up, down = found.velocity_density([0.54], [1.19, -1.19])[0, 0]
    assert abs(up - down) > 0.02
    v, w = panels_between(np.linspace(0.0, 7.0, 25), 4)
    total = found.speed_density(v)[0] @ w
    assert total + found.uncollided[0] == pytest.approx(1.0, abs=5e-3)
