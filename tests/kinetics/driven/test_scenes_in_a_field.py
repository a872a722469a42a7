"""Scenes in a field: from rest, to the steady state, as the field vanishes; averages, densities."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from marking import slow_but

from kinetics import (
    AngularHarmonics,
    Beam,
    InputError,
    Scene,
    ToleranceWarning,
    VelocitySamples,
    solve,
    solve_field,
)
from kinetics.collision import CollisionLaw
from kinetics.driven.field_evolution import FieldEvolution, FieldProblem
from kinetics.driven.resolution import PanelResolution
from kinetics.driven.starts import DrivenStart
from kinetics.driven.velocity_density import VelocityDensity
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import panels_between
from kinetics.states.kinds import as_state

PATH = 12.5  # l at number_density 0.04
UNIT = math.sqrt(0.08 * PATH)
BOTH = ("thermal_speed", "mean_velocity", "speed_density", "velocity_density")
MANY = VelocitySamples(np.random.default_rng(1).normal(size=(100, 2)) * 0.004 + [0.06, 0.18])
OUTPUTS = ("mean_velocity", "mean_displacement", "thermal_speed", "displacement_tensor", "msd")


def scene(times: Any, field: float = 0.01, **arguments: Any) -> Scene:
    """Times in sqrt(l/g)."""
    given = {"restitution": 0.7, "initial": "rest", "outputs": OUTPUTS, **arguments}
    path = PATH if given.get("dimension", 2) == 2 else 1.0 / (math.pi * 0.04)
    return Scene(times=np.asarray(times) * math.sqrt(path / field), field=field, **given)


def smooth(times: Any, **arguments: Any) -> Scene:
    return scene(times, 0.08, **{"initial": "gaussian", "outputs": BOTH, **arguments})


def test_from_rest() -> None:
    """Against a program of its own; t = 0 is rest."""
    solution = solve(scene([0.0, 0.1, 0.5, 2.0, 5.0]))
    assert solution.rtol == 1e-6
    assert solution.status.name == "CONVERGED"
    velocity = np.array([0.09962311, 0.45545144, 0.62108221, 0.50135393]) * math.sqrt(0.01 * PATH)
    way = np.array([0.004990570, 0.119322259, 1.11237376, 2.66810824])
    assert solution.mean_velocity[1:, 0] == pytest.approx(velocity, rel=1e-6)
    assert solution.mean_displacement[1:, 0] == pytest.approx(way * PATH, rel=1e-6)
    assert np.all(solution.mean_velocity[:, 1] == 0.0)
    for name in OUTPUTS:
        assert np.all(getattr(solution, name)[0] == 0.0)
    tensor, mean = solution.displacement_tensor, solution.mean_displacement[:, 0]
    total = tensor[:, 0, 0] + tensor[:, 1, 1] + mean**2
    assert solution.msd == pytest.approx(total, rel=1e-12)


@pytest.mark.parametrize("last", slow_but([4.0], [4.0, 20.0]))
@pytest.mark.parametrize("dimension", [2, 3])
def test_the_energy_of_elastic_tracers_from_rest(dimension: int, last: float) -> None:
    """<v^2> = 2 g <x> where no energy is lost."""
    asked = scene([0.2, 1.0, last], restitution=1.0, dimension=dimension,
                  outputs=("thermal_speed", "mean_displacement"))  # fmt: skip
    found = solve(asked, rtol=1e-6)
    assert found.thermal_speed**2 == pytest.approx(0.02 * found.mean_displacement[:, 0], rel=2e-6)


@pytest.mark.parametrize(("e", "et", "dimension"), [(0.7, 1.0, 3), (0.4, 0.4, 2)])
def test_late_times_reach_the_steady_state(e: float, et: float, dimension: int) -> None:
    state = solve_field(e, dimension, et, rtol=1e-7)
    path = PATH if dimension == 2 else 1.0 / (math.pi * 0.04)
    asked = scene([40.0, 50.0], 0.08, restitution=e, tangential_restitution=et,
                  dimension=dimension, initial="gaussian")  # fmt: skip
    found, speed = solve(asked, rtol=1e-5), math.sqrt(0.08 * path)
    assert found.mean_velocity[:, 0] == pytest.approx(np.full(2, state.drift * speed), rel=1e-5)
    square = math.sqrt(state.mean_square_speed) * speed
    assert found.thermal_speed[1] == pytest.approx(square, rel=1e-5)
    growth = np.diff(found.displacement_tensor, axis=0)[0] / np.diff(found.times)[0] / 2.0
    assert growth[0, 0] == pytest.approx(state.diffusion_parallel * speed * path, rel=1e-3)
    assert growth[1, 1] == pytest.approx(state.diffusion_perpendicular * speed * path, rel=1e-3)


@pytest.mark.parametrize(
    ("initial", "dimension", "last"),
    slow_but(
        [(Beam(0.8), 2, 100.0), ("gaussian", 3, 30.0)],
        [(Beam(0.8), 2, 100.0), ("gaussian", 3, 30.0), ("gaussian", 3, 100.0)],
    ),
)
def test_a_vanishing_field_is_none(initial: Any, dimension: int, last: float) -> None:
    """Against the equation without a field, in all outputs."""
    names = {*OUTPUTS, "collisions", "velocity_tensor", "a2"} - {"displacement_tensor"}
    arguments: dict[str, Any] = {"initial": initial, "dimension": dimension, "outputs": names}
    arguments |= {"restitution": 0.7, "times": [1e-7, 10.0, last]}  # first, none has collided
    without = solve(Scene(**arguments), rtol=1e-8)
    found = solve(Scene(field=1e-13, **arguments), rtol=1e-5)
    scales = {"mean_velocity": without.thermal_speed, "mean_displacement": np.sqrt(without.msd)}
    for name in names:
        expected, value = getattr(without, name), getattr(found, name)
        scale = scales.get(name, np.abs(expected).reshape(3, -1).max(axis=1))
        apart = np.abs(value - expected).reshape(3, -1).max(axis=1)
        assert np.all(apart <= 2e-5 * np.maximum(scale, 1.0 * (name == "a2")))


def test_the_displacement_turns_with_the_start() -> None:
    """Where the field has no effect yet: all its components, also xy."""
    one, other = (
        solve(
            Scene(0.7, initial=Beam(angle, "monoenergetic"), field=1e-13, times=[10.0, 50.0],
                  outputs=("displacement_tensor",)), rtol=1e-4,
        ).displacement_tensor
        for angle in (0.0, 0.8)
    )  # fmt: skip
    turn = np.array([[math.cos(0.8), -math.sin(0.8)], [math.sin(0.8), math.cos(0.8)]])
    expected = turn @ one @ turn.T
    assert np.all(abs(other - expected) < 1e-3 * abs(expected))


@pytest.mark.parametrize(
    ("initial", "field", "times", "rtol"),
    [
        ("rest", 0.01, np.geomspace(0.003, 99.0, 12), 1e-4),
        ("gaussian", 0.08, [0.3, 1.0, 3.0, 10.0], 1e-4),
        ("gaussian", 1e12, [0.3, 1.0, 10.0], 1e-4),  # at rest
        ("gaussian", 1e-4, [2e-4, 5e-4], 1e-2),  # the error of the start counts, 1e-4
        pytest.param(Beam(2.0), 0.08, [0.1, 1.0, 30.0], 1e-3, marks=pytest.mark.slow),
        ("monoenergetic", 3.0, [0.1, 1.0, 30.0], 1e-4),  # slow, of all directions
        # slow tracers of many directions, whose first steps of time were too long
        pytest.param(MANY, 0.08, [0.1, 1.0, 5.0], 1e-4, marks=pytest.mark.slow),
    ],
)
def test_rtol_is_met(initial: Any, field: float, times: Any, rtol: float) -> None:
    """At loose tolerances, from early times on, and for starts far from the steady state."""
    asked = scene(times, field, initial=initial)
    fine, coarse = solve(asked, rtol=0.1 * rtol), solve(asked, rtol=rtol)
    assert coarse.status.name == fine.status.name == "CONVERGED"
    estimate = 2.0 * (coarse.error_estimate + fine.error_estimate)
    assert coarse.thermal_speed == pytest.approx(fine.thermal_speed, rel=min(rtol, estimate))
    moved = np.abs(coarse.mean_velocity - fine.mean_velocity)
    assert np.all(moved <= rtol * fine.thermal_speed[:, None])
    way = np.abs(coarse.mean_displacement - fine.mean_displacement)
    assert np.all(way <= rtol * np.sqrt(fine.msd)[:, None])
    assert coarse.msd == pytest.approx(fine.msd, rel=rtol)


@pytest.mark.parametrize(("dimension", "kept"), [(2, (1 / 3, 1 / 5)), (3, (1 / 2, 1 / 3))])
@pytest.mark.parametrize("rtol", [1e-2, 1.4e-3, 1e-4])
def test_the_first_collisions_from_rest(dimension: int, kept: Any, rtol: float) -> None:
    """e = 0: a collision at the time s leaves <v^2> = t^2 - n (2 s t - s^2), n = 1 - b^2.

    kept : the averages of b^2 and b^4. Two of a thousand have collided; and at a late time as well.
    """
    t, b2, b4 = 0.07, *kept
    n, n2 = 1.0 - b2, 1.0 - 2.0 * b2 + b4
    square = t**2 - n * (2 / 3 - 1 / 4) * t**4  # the rate of collisions is s
    fourth = t**4 - 2.0 * n * (2 / 3 - 1 / 4) * t**6 + n2 * (1 - 4 / 5 + 1 / 6) * t**6
    for times in ([t], [t, 5.0]):
        asked = scene(times, 1.0, restitution=0.0, dimension=dimension, outputs=("a2",))
        found = solve(asked, rtol)
        assert found.status.name == "CONVERGED"
        expected = dimension / (dimension + 2) * fourth / square**2
        assert 1.0 + found.a2[0] == pytest.approx(expected, rel=1e-6)  # t^4 more is 3e-7


@pytest.mark.parametrize(("e", "et", "t", "g"), [(0.001, 0.8, 0.7, 0.002), (0.07, 1.0, 9.0, 0.01)])
def test_speeds_that_none_has_add_no_rounding(e: float, et: float, t: float, g: float) -> None:
    """A Gaussian as a function reaches 33 of its widths: <v^4> was 1 to 20 %, later 1e-3, off."""
    f = lambda v: math.sqrt(2 / math.pi) * v**2 * np.exp(-0.5 * v**2)  # noqa: E731
    start = AngularHarmonics({0: f, 1: lambda v: 0.2 * v * f(v) / (1.0 + v * v)})
    asked = scene([t], g, restitution=e, tangential_restitution=et, initial=start, dimension=3,
                  outputs=("a2",))  # fmt: skip
    one, other = solve(asked, rtol=1e-4), solve(asked, rtol=1e-6)
    assert one.status.name == other.status.name == "CONVERGED"
    assert 1.0 + one.a2 == pytest.approx(1.0 + other.a2, rel=1e-4)


@pytest.mark.parametrize(
    ("e", "et", "dimension", "rtol"),
    slow_but(
        [(0.124, 0.035, 3, 1e-3), (0.1, 0.1, 2, 1e-2), (0.0, 1.0, 2, 1e-3)],
        [
            (*system, rtol)
            for system in ((0.124, 0.035, 3), (0.1, 0.1, 2), (0.0, 1.0, 2))
            for rtol in (1e-2, 1e-3)
        ],
    ),
)
def test_a_weak_field_leaves_what_collisions_make_slow(
    e: float, et: float, dimension: int, rtol: float
) -> None:
    """Against the equation without a field: starts far from slow, whose collisions take nearly all.

    Densities from 1/100 of the thermal speed on, and the fourth moment.
    """
    start = lambda v: v**1.93 * np.exp(-v) / math.gamma(2.93)  # noqa: E731
    asked = Scene(
        e, 0.5, initial=start, times=[0.02, 0.3], outputs=("thermal_speed", "speed_density"),
        dimension=dimension, tangential_restitution=et,
    )  # fmt: skip
    without = solve(asked, 1e-6)
    found = solve(replace(asked, field=1e-6), rtol)
    assert found.status.name == "CONVERGED"
    for i, thermal in enumerate(without.thermal_speed):
        v = thermal * np.append(np.geomspace(0.01, 0.1, 20), np.linspace(0.12, 3.0, 40))
        f = without.speed_density(v)[i]
        assert np.abs(found.speed_density(v)[i] - f).max() <= rtol * f.max()
    fourth = solve(replace(asked, field=1e-6, outputs=("a2",)), rtol)
    assert fourth.status.name == "CONVERGED"
    exact = solve(replace(asked, outputs=("a2",)), 1e-8).a2
    assert 1.0 + fourth.a2 == pytest.approx(1.0 + exact, rel=rtol)


def test_a_miss_is_warned_of() -> None:
    with pytest.warns(ToleranceWarning, match="averages"):
        found = solve(scene([0.5], outputs=("mean_velocity",)), rtol=1e-12)
    assert found.status.name == "TOLERANCE_NOT_REACHED"
    assert found.error_estimate > 1e-12


# -- densities ----------------------------------------------------------------------------------


@pytest.mark.parametrize(("dimension", "times"), [(2, [0.0, 1.0]), (3, [1.0])])
def test_moments_are_those_of_the_averages(dimension: int, times: list[float]) -> None:
    """1, <v^2> and <v_x> of the densities."""
    found = solve(smooth(times, dimension=dimension), rtol=1e-4)
    assert found.status.name == "CONVERGED"
    v, w = panels_between(np.linspace(0.0, 8.0, 9), 6)
    f = found.speed_density(v)
    assert f @ w == pytest.approx(1.0, abs=2e-5)
    assert f @ (w * v * v) == pytest.approx(found.thermal_speed**2, rel=1e-4)
    angle, share = panels_between(np.array([0.0, 0.3, 1.5, math.pi]), 6)
    v, w = panels_between(np.linspace(0.0, 8.0, 5), 8)
    share *= np.cos(angle) * (2.0 if dimension == 2 else 2.0 * math.pi * np.sin(angle))
    mean = found.velocity_density(v, angle) @ share @ (w * v**dimension)
    error = np.abs(mean - found.mean_velocity[:, 0])
    assert np.all(error <= 1e-4 * found.thermal_speed)


def test_late_densities_are_those_of_the_steady_state() -> None:
    """On the ray along the field too, on which harmonics of the steady state converge slowly."""
    found = solve(smooth([16.0], outputs=("velocity_density",)), rtol=1e-5)
    v, angle = np.array([0.3, 1.0, 2.0]), np.array([0.0, 0.02, 0.7, 2.0, 3.0, -2.0])
    expected = solve_field(0.7, rtol=1e-8).vdf(v / UNIT, angle) / UNIT**2
    assert found.velocity_density(v, angle)[0] == pytest.approx(expected, abs=1e-5)


def test_elastic_tracers_reach_the_self_similar_state() -> None:
    """f ~ exp(-8 v^3/(27 t)), up to the drift, which is a small part of the speed late."""
    found = solve(smooth([300.0], restitution=1.0, outputs=("speed_density",)), rtol=1e-3)
    v, a = np.array([2.0, 5.0, 8.0, 11.0]), 8.0 / (27.0 * 300.0)
    expected = 3.0 * a ** (2.0 / 3.0) / math.gamma(2.0 / 3.0) * v * np.exp(-a * v**3)
    density = found.speed_density(v * UNIT)[0] * UNIT
    assert density == pytest.approx(expected, abs=5e-3 * expected.max())


@pytest.mark.parametrize("et", slow_but([1.0], [1.0, 0.5]))
def test_from_rest_the_uncollided_are_apart(et: float) -> None:
    """Those that have collided once have fronts: the status says that they are missed."""
    asked = smooth([0.5, 1.5, 12.0], initial="rest", tangential_restitution=et)
    with pytest.warns(ToleranceWarning, match="densities"):
        solution = solve(asked, rtol=1e-3)
    t = np.array([0.5, 1.5, 12.0])
    assert solution.uncollided == pytest.approx(np.exp(-0.5 * t * t), rel=1e-12)
    v, w = panels_between(np.array([0.0, 0.35, 0.5, 1.05, 1.5, 3.0, 4.5, 8.0]), 8)
    f = solution.speed_density(v * UNIT) * UNIT
    assert f @ w + solution.uncollided == pytest.approx(1.0, abs=6e-3)
    assert f.min() < -1e-3  # densities are no better than that there
    steady = solve_field(0.7, 2, et, rtol=1e-4).vdf(v, [0.5, 2.0])
    late = solution.velocity_density(v * UNIT, [0.5, 2.0])[2] * UNIT**2
    with pytest.raises(InputError, match="velocity_density"):
        solution.velocity_component_density([0.1])
    assert late == pytest.approx(steady, abs=0.01 * steady.max())


def test_a_start_that_is_not_symmetric() -> None:
    """A beam across the field: both directions across it differ, and the total is 1."""
    asked = scene([1.0], 1.0 / PATH, initial=Beam(1.2), outputs=BOTH)
    with pytest.warns(ToleranceWarning, match="densities"):
        found = solve(asked, rtol=1e-3)
    up, down = found.velocity_density([0.8], [1.0, -1.0])[0, 0]
    assert down > up + 0.05
    v, w = panels_between(np.linspace(0.0, 7.0, 25), 4)
    total = found.speed_density(v)[0] @ w
    assert total + found.uncollided[0] == pytest.approx(1.0, abs=5e-3)


def test_the_estimate_holds_at_the_tightest_tolerance() -> None:
    """4.2e-8 off with an estimate of 6.6e-9 when the start was a few points of its density."""
    asked = {"times": [1.0, 10.0], "field": 1.0, "outputs": ("mean_velocity", "temperature")}
    found = solve(Scene(0.7, 0.5, **asked), rtol=1e-7)
    expected = 0.4407943498  # of the solver of drives, with a drag of 1e-19
    off = abs(found.mean_velocity[0, 0] - expected) / math.sqrt(2.0 * found.temperature[0])
    assert off < found.error_estimate <= 1e-7
    assert off < 5e-9


@pytest.mark.slow
def test_the_estimate_holds_from_rest_at_the_tightest_tolerance() -> None:
    """8.3e-8 off with an estimate of 2.1e-8, when few nodes held what first collisions make."""
    asked = {"times": [1.0, 3.0, 10.0], "field": 1.0, "initial": "rest"}
    found = solve(Scene(0.7, 0.5, outputs=("mean_velocity", "temperature"), **asked), rtol=1e-8)
    expected = np.array(
        [0.6984735507, 0.51042611, 0.5019264514]
    )  # of nodes, steps and harmonics far beyond what is refined to
    off = np.abs(found.mean_velocity[:, 0] - expected) / np.sqrt(2.0 * found.temperature)
    assert found.status.name == "CONVERGED"
    assert np.max(off) < found.error_estimate


class WithoutANumber(VelocityDensity):
    """A density that is not a number at the first of the velocities."""

    def at(self, i: int, along: FloatArray, across: FloatArray) -> FloatArray:
        density = super().at(i, along, across)
        density[0] = math.nan
        return density


def coarse_evolution() -> FieldEvolution:
    """A solution for a Gaussian start, at a low resolution, with its density."""
    law = CollisionLaw(0.7)
    state = as_state("gaussian")
    problem = FieldProblem(
        law=law,
        state=state,
        start=DrivenStart.of(state, 1e-3, 1.0, 6, law.dimension),
        times=np.array([0.5]),
        names=frozenset({"v^2"}),
        keeps_density=True,
    )
    return FieldEvolution(problem, PanelResolution.over_time(1e-2))


def test_a_density_that_is_not_a_number_agrees_with_no_other() -> None:
    evolution = coarse_evolution()
    density = VelocityDensity(evolution, 1.0)
    broken = WithoutANumber(evolution, 1.0)
    assert density.difference(VelocityDensity(evolution, 1.0)) == 0.0
    assert density.difference(broken) == math.inf
    assert broken.difference(density) == math.inf


def test_a_density_that_is_not_a_number_is_infinitely_far_below_zero() -> None:
    assert WithoutANumber(coarse_evolution(), 1.0).negative() == math.inf
