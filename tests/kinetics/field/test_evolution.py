"""Averages over time in a field: from rest, towards the steady state, and as the field vanishes."""

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from marking import slow_but

from kinetics import (
    Beam,
    CollisionLaw,
    InputError,
    Scene,
    VelocitySamples,
    in_field,
    load,
    solve,
    solve_field,
)
from kinetics.field.backward import ALL, BackwardField, backward_panels, needed_for
from kinetics.field.evolution import Evolution, scales
from kinetics.field.first_collision import Rays
from kinetics.field.ladder import Chain
from kinetics.field.radau import RadauRule
from kinetics.field.resolution import TimeResolution
from kinetics.field.starts import Start
from kinetics.numerics.gauss import gauss_legendre
from kinetics.states.quadrature import LogMeasure

PATH = 12.5  # l at number_density 0.04
MANY = VelocitySamples(np.random.default_rng(1).normal(size=(100, 2)) * 0.004 + [0.06, 0.18])
OUTPUTS = ("mean_velocity", "mean_displacement", "thermal_speed", "displacement_tensor", "msd")


def scene(times: Any, field: float = 0.01, **arguments: Any) -> Scene:
    """Times in sqrt(l/g)."""
    given = {"restitution": 0.7, "initial": "rest", "outputs": OUTPUTS, **arguments}
    return Scene(times=np.asarray(times) * math.sqrt(PATH / field), field=field, **given)


def test_from_rest() -> None:
    """Against a program of its own; t = 0 is rest."""
    solution = solve(scene([0.0, 0.1, 0.5, 2.0, 5.0]), rtol=1e-6)
    speed = math.sqrt(0.01 * PATH)
    velocity = np.array([0.09962311, 0.45545144, 0.62108221, 0.50135393])
    way = np.array([0.004990570, 0.119322259, 1.11237376, 2.66810824])
    assert solution.mean_velocity[1:, 0] == pytest.approx(velocity * speed, rel=1e-6)
    assert solution.mean_displacement[1:, 0] == pytest.approx(way * PATH, rel=1e-6)
    assert np.all(solution.mean_velocity[:, 1] == 0.0)
    for name in OUTPUTS:
        assert np.all(getattr(solution, name)[0] == 0.0)
    tensor, mean = solution.displacement_tensor, solution.mean_displacement[:, 0]
    total = tensor[:, 0, 0] + tensor[:, 1, 1] + mean**2
    assert solution.msd == pytest.approx(total, rel=1e-12)


@pytest.mark.parametrize(("dimension", "factor"), slow_but([(3, 3.0)], [(2, 9.0 / 4.0), (3, 3.0)]))
def test_elastic_relation_from_rest(dimension: int, factor: float) -> None:
    """<v^3> = (9/4)(t - <v_x>), 3 (t - <v_x>) in space; and <v^2> = 2 <x>, the energy."""
    times = np.array([0.2, 1.0, 4.0, 20.0])
    resolution = TimeResolution.of(1e-6).finer()
    law = CollisionLaw(1.0, dimension=dimension)
    values = Evolution(law, Start.rest(), times, resolution).values
    cube, velocity = values[:, ALL.index("v^3")], values[:, ALL.index("v_x")]
    assert cube == pytest.approx(factor * (times - velocity), rel=2e-6)
    assert values[:, ALL.index("v^2")] == pytest.approx(2.0 * values[:, ALL.index("x")], rel=1e-6)


@pytest.mark.parametrize("dimension", slow_but([2], [2, 3]))
def test_late_times_reach_the_steady_state(dimension: int) -> None:
    state = solve_field(0.7, dimension, rtol=1e-7)
    arguments = {"dimension": dimension, "initial": "gaussian"}
    path = PATH if dimension == 2 else 1.0 / (math.pi * 0.04)
    times = np.array([60.0, 80.0]) * math.sqrt(path / PATH)
    found = solve(scene(times, 0.08, **arguments), rtol=1e-5)
    speed = math.sqrt(0.08 * path)
    assert found.mean_velocity[:, 0] == pytest.approx(np.full(2, state.drift * speed), rel=1e-5)
    assert found.thermal_speed[1] == pytest.approx(
        math.sqrt(state.mean_square_speed) * speed, rel=1e-5
    )
    growth = np.diff(found.displacement_tensor, axis=0)[0] / np.diff(found.times)[0] / 2.0
    unit = speed * path
    assert growth[0, 0] == pytest.approx(state.diffusion_parallel * unit, rel=1e-3)
    assert growth[1, 1] == pytest.approx(state.diffusion_perpendicular * unit, rel=1e-3)


@pytest.mark.parametrize(
    ("initial", "dimension"), [(Beam(0.8, "monoenergetic"), 2), (Beam(0.0, "monoenergetic"), 3)]
)
def test_a_vanishing_field_is_none(initial: Any, dimension: int) -> None:
    outputs = (
        "thermal_speed",
        "collisions",
        "msd",
        "mean_velocity",
        "velocity_tensor",
        "mean_displacement",
        "a2",
    )
    arguments: dict[str, Any] = {
        "restitution": 0.7,
        "initial": initial,
        "times": [1.0, 10.0, 100.0],
        "dimension": dimension,
    }
    without = solve(Scene(outputs=outputs, **arguments), rtol=1e-8)
    found = solve(Scene(field=1e-13, outputs=outputs, **arguments), rtol=1e-5)
    for name in outputs:
        expected, value = getattr(without, name), getattr(found, name)
        scale = np.abs(expected).max(axis=tuple(range(1, expected.ndim)), keepdims=True)
        if name == "mean_velocity":  # its errors are relative to the thermal speed
            scale = without.thermal_speed[:, None]
        assert np.all(np.abs(value - expected) <= 2e-5 * np.maximum(scale, 1.0 * (name == "a2")))


@pytest.mark.parametrize("initial", ["rest", pytest.param("gaussian", marks=pytest.mark.slow)])
def test_rtol_is_met(initial: str) -> None:
    times = [0.3, 1.0, 3.0, 10.0]
    fine = solve(scene(times, 0.08, initial=initial), rtol=1e-6)
    coarse = solve(scene(times, 0.08, initial=initial), rtol=1e-4)
    assert coarse.status.name == fine.status.name == "CONVERGED"
    speed, root = fine.thermal_speed[:, None], np.sqrt(fine.msd)[:, None]
    moved = np.abs(coarse.mean_displacement - fine.mean_displacement)
    assert np.all(np.abs(coarse.mean_velocity - fine.mean_velocity) <= 1e-4 * speed)
    assert np.all(moved <= 1e-4 * root)
    assert coarse.msd == pytest.approx(fine.msd, rel=1e-4)


@pytest.mark.parametrize(
    ("initial", "field", "times", "rtol"),
    [
        ("rest", 0.01, np.geomspace(0.003, 99.0, 12), 1e-4),
        ("gaussian", 1e12, [0.3, 1.0, 10.0], 1e-4),  # nearly at rest
        # at 1e6 of the speeds that the field makes
        pytest.param("gaussian", 1e-12, [1e-6, 1e-3], 1e-4, marks=pytest.mark.slow),
        (Beam(2.0, "monoenergetic"), 0.08, [0.1, 1.0, 30.0], 1e-3),
        # slow tracers of many directions, whose first steps of time were too long
        pytest.param(MANY, 0.08, [0.1, 1.0, 5.0], 5e-5, marks=pytest.mark.slow),
    ],
)
def test_what_is_asked_is_reached(initial: Any, field: float, times: Any, rtol: float) -> None:
    """At loose tolerances, from early times on, and for starts far from the steady state."""
    outputs = ("mean_velocity", "thermal_speed", "mean_displacement")
    asked = scene(times, field, initial=initial, outputs=outputs)
    fine, coarse = solve(asked, rtol=0.1 * rtol), solve(asked, rtol=rtol)
    assert coarse.status.name == fine.status.name == "CONVERGED"
    assert coarse.thermal_speed == pytest.approx(fine.thermal_speed, rel=rtol)
    moved = np.abs(coarse.mean_velocity - fine.mean_velocity)
    assert np.all(moved <= rtol * fine.thermal_speed[:, None])


def test_early_times_from_rest_are_free_fall() -> None:
    """<r^2> = t^4/4 and <v^4> = <v^2>^2, up to the few that have collided."""
    times = [0.003, 1.0, 90.0]
    found = solve(scene(times, initial="rest", outputs=("msd", "a2")), rtol=1e-4)
    assert found.status.name == "CONVERGED"
    assert found.msd[0] == pytest.approx(PATH**2 * 0.003**4 / 4.0, rel=1e-4)
    assert found.a2[0] == pytest.approx(-0.5, abs=1e-4)


def test_a_start_close_to_rest_is_rest() -> None:
    cold = solve(scene([0.5, 3.0], 1e12, initial="gaussian", outputs=("mean_velocity",)), 1e-4)
    rest = solve(scene([0.5, 3.0], 1e12, initial="rest", outputs=("mean_velocity",)), 1e-4)
    assert np.all(cold.mean_velocity == rest.mean_velocity)


@pytest.mark.parametrize(
    "initial",
    ["rest", *(pytest.param(s, marks=pytest.mark.slow) for s in ("gaussian", Beam(2.0)))],
)
def test_outputs_do_not_depend_on_what_else_is_asked(initial: Any) -> None:
    """Averages that nobody asks for are not solved."""
    times = [0.1, 1.0, 3.0]
    everything = solve(scene(times, 0.08, initial=initial), rtol=1e-3)
    for name in OUTPUTS:
        alone = getattr(solve(scene(times, 0.08, initial=initial, outputs=(name,)), 1e-3), name)
        expected = getattr(everything, name)
        scale = everything.thermal_speed if "velocity" in name else expected.max()
        assert np.all(np.abs(alone - expected) <= 2e-3 * np.max(scale))


def test_odd_averages_are_solved_where_they_are_needed() -> None:
    assert needed_for(["v_x", "v_y"], symmetric=True) == {"v^2", "v_x"}
    assert needed_for(["y"], symmetric=False) == {"v^2", "x", "y", "x^2", "y^2"}
    assert needed_for(["y^2"], symmetric=True) == {"v^2", "y", "y^2"}


def test_gaussian_start_begins_as_free_fall() -> None:
    """To first order in t: <v_x> = g t (1 - ...), and the variance of x is t^2."""
    found = solve(scene([1e-3], 0.08, initial="gaussian"), rtol=1e-5)
    t = found.times[0]
    assert found.mean_velocity[0, 0] == pytest.approx(0.08 * t, rel=2e-3)
    assert found.displacement_tensor[0, 1, 1] == pytest.approx(t * t, rel=2e-3)


def test_a_scene_with_a_field_is_a_value(tmp_path: Path) -> None:
    solution = solve(scene([0.5]), rtol=1e-3)
    assert solution.status.name == "CONVERGED"
    solution.save(tmp_path / "field.h5")
    again = load(tmp_path / "field.h5")
    assert again == solution
    assert again.scene.field == 0.01
    assert "field=0.01" in repr(solution)
    assert "displacement_tensor" in solution._repr_html_()
    assert "displacement_tensor" in solution.scene._repr_html_()
    assert solution.plan[0].part == "averages in a field"
    for question in (lambda: solution.moment(2.0), lambda: solution.harmonic(1.0, 1)):
        with pytest.raises(InputError, match="field"):
            question()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"field": -1.0}, "field"),
        ({"field": math.nan}, "field"),
        ({"field": 0.0, "initial": "rest"}, "give a field"),
        ({"field": 1.0, "outputs": ("kurtosis",)}, "not available with a field"),
        ({"field": 1.0, "outputs": ("position_density",)}, "not available with a field"),
        ({"outputs": ("displacement_tensor",)}, "not available without a field"),
        ({"field": 1.0, "initial": "fast"}, "initial"),
    ],
)
def test_refusals(arguments: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words) as caught:
        Scene(0.7, times=[1.0], **arguments)
    assert "\n" not in str(caught.value)


def test_extreme_fields_are_refused_in_one_line() -> None:
    with pytest.raises(InputError, match="out of range"):
        solve(Scene(0.7, times=[1.0], field=1e300, outputs=("mean_velocity",)))


@pytest.mark.parametrize(("dimension", "family"), [(2, 0), (2, 1), (3, 0), (3, 1)])
def test_no_error_grows_over_time(dimension: int, family: int) -> None:
    """No solution of the equation on panels grows, down to low speeds: it had rates of 300."""
    panels, top = backward_panels(6.0, 0.01, 7), 11 - family
    chain, n = Chain(panels, dimension, family, False), panels.size
    lost = BackwardField(CollisionLaw(0.7, dimension=dimension), panels, 11).collisions
    count = top + 1 - family
    rates = np.zeros((count, n, count, n))
    for i, m in enumerate(range(family, top + 1)):
        rates[i, :, i] = -lost[m]
        if m < top:
            rates[i, :, i + 1] = chain.from_above(m)
        else:
            rates[i, :, i] += chain.beyond(m)
        if i > 0:
            rates[i, :, i - 1] = chain.from_below(m)
    rates /= panels.speeds[:, None, None]
    fastest = np.linalg.eigvals(rates.reshape(count * n, count * n)).real.max()
    assert fastest <= 1e-9


@pytest.mark.parametrize("speed", [0.5, 1e-4])
def test_a_beam_converges(speed: float) -> None:
    """With few harmonics, whatever its speed; early it falls freely."""
    start = Start(
        (), 1.0, Rays(np.array([0.6]) * -speed, np.array([0.8]) * speed, np.ones(1), False)
    )
    law, times = CollisionLaw(0.7), np.array([1e-3, 0.3, 1.0, 4.0])
    names = needed_for(["v_x", "v_y", "collisions"], symmetric=False)
    coarse, fine = (
        Evolution(law, start, times, resolution, names).values
        for resolution in (TimeResolution.of(1e-4).finer(), TimeResolution(10, 17, 0.06, 1e-6))
    )
    scale = scales(fine)
    used = scale > 0.0
    assert np.max(np.abs(fine - coarse)[used] / scale[used]) <= 2e-5
    early = fine[0]
    assert early[ALL.index("v_y")] == pytest.approx(0.8 * speed, rel=1e-3)
    assert early[ALL.index("v_x")] == pytest.approx(1e-3 - 0.6 * speed, rel=1e-3)


def test_rays_against_harmonics() -> None:
    """A beam across the field, with all averages; harmonics of a beam converge slowly."""
    law, times, resolution = CollisionLaw(0.7), np.array([0.5, 3.0]), TimeResolution.of(1e-4)
    state = Scene(0.7, times=[1.0], initial=Beam(2.0), outputs=("a2",)).state
    found = Start.of(state, 1e-4, 0.5, resolution, 2)
    measures = tuple(state.harmonic(m, 1e-4, 0.0, 4.0) for m in range(resolution.harmonics + 1))
    along_rays = Evolution(law, found, times, resolution).values
    values = Evolution(law, Start(measures, 0.5), times, resolution).values
    assert found.rays is not None
    assert np.all(np.abs(along_rays - values) <= 3e-3 * scales(values))


def test_the_free_way_in_a_field() -> None:
    """Against quadrature: to and from the turning point, and at 1e6 of the terminal speed."""
    along = np.array([-0.5, 0.3, -1e6, 1e6, 0.0, -1.0, -1.0])
    across = np.array([0.2, 0.0, 1e6, 1.0, 0.0, 0.0, 1e-9])
    rays = Rays(along, across, np.ones(7), False)
    time = np.array([1.5, 2.0, 1e-6, 1e-7, 3.0, 2.5, 2.5])
    node, weight = gauss_legendre(60)
    edges = np.clip(np.stack([0.0 * time, -along, time], axis=1), 0.0, time[:, None])
    expected = sum(
        (b - a) * (weight @ np.hypot(along + a + np.outer(node, b - a), across))
        for a, b in zip(edges.T[:-1], edges.T[1:], strict=True)
    )
    assert rays.way(time) == pytest.approx(expected, rel=1e-12)


def test_rays_with_fewer_speeds_keep_the_moments() -> None:
    x = np.linspace(-3.0, 1.0, 80)
    measure = LogMeasure(x, np.exp(-(x**2)) / np.exp(-(x**2)).sum())
    rays = Rays.isotropic(measure, 0.1, 4, 5, 3)
    assert rays.along.size == 20
    speeds = np.hypot(rays.along, rays.across)
    for p in range(8):
        expected = measure.weight @ (0.1 * np.exp(x)) ** p
        assert rays.weight @ speeds**p == pytest.approx(expected, rel=1e-12)
    assert rays.weight @ rays.along**2 == pytest.approx(rays.weight @ speeds**2 / 3.0, rel=1e-12)


def test_radau_rule() -> None:
    """Exact for polynomials; the rational function that it makes of exp(z) has the order 9."""
    rule = RadauRule(5)
    z = -0.7
    end = sum((stages[-1] * share / (1.0 - value * z)).real for value, share, stages in rule.modes)
    assert end == pytest.approx(math.exp(z), rel=1e-10)
    local = np.linspace(0.0, 1.0, 7)
    assert rule.rows(local) @ rule.points**5 == pytest.approx(local**5, abs=1e-13)
    assert rule.roughness(rule.points**4) == pytest.approx(0.0, abs=1e-13)


def test_a_start_of_which_nothing_is_left_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    lost = SimpleNamespace(
        values=-np.ones((1, len(ALL))),
        start=SimpleNamespace(highest=1e6, measures=[0.0], rays=None),
    )
    monkeypatch.setattr(in_field, "_evolution", lambda *_: lost)
    scene = Scene(0.0, times=[1.0], outputs=("mean_velocity", "thermal_speed"), field=0.01)
    with pytest.raises(InputError, match=r"^initial: speeds up to 1.0e\+06 .* give a slower start"):
        solve(scene)
