"""What is refused, each in one line that names the argument: tables of argument, call, values."""

import math
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

from kinetics import (
    AngularHarmonics,
    Beam,
    CollisionLaw,
    Gaussian,
    InputError,
    Monoenergetic,
    PolarGrid,
    ScalingSolution,
    Scene,
    SpeedDensity,
    SpeedSamples,
    SpeedTable,
    VelocitySamples,
    Viscoelastic,
    solve,
    solve_field,
    solve_scaled,
)

NAN, INF, AN_EXP = math.nan, math.inf, np.exp
V, ONES = np.linspace(0.0, 1.0, 11), np.ones(11)
GRID, FLAT = np.linspace(0.0, 1.0, 5), np.ones((5, 8))
DISKS, DENSE = CollisionLaw(0.5), dict(scatterers="hard disks")
AMONG = Scene(0.5, 0.02, times=[1.0], scatterers="overlapping").law
MIXED = CollisionLaw.mixture([0.5, 0.5], [CollisionLaw(1.0), DISKS])
MEDIUM: dict[str, Any] = dict(scatterers="overlapping", number_density=0.1)


def scene(**changes: Any) -> Scene:
    return Scene(**dict(restitution=0.5, times=[1.0]) | changes)


def solved(**changes: Any) -> Any:
    return solve(scene(**changes), 1e-2)


@cache
def placed() -> Any:
    return solved(times=[100.0], outputs=("position_density", "intermediate_scattering"))


def light(**changes: Any) -> dict[str, Any]:
    return dict(restitution=1.0, mass_ratio=2.0) | changes


def sampled(w: Any, s: Any, c: Any) -> CollisionLaw:
    return CollisionLaw.from_samples(w, s, c)


HALVES = [0.5, 0.5]
LAW: list[tuple[str, Callable[..., Any], list[Any]]] = [
    ("restitution", CollisionLaw, [-0.1, 1.0000001, NAN, "x", 1j]),
    ("tangential_restitution", lambda et: CollisionLaw(0.5, et), [1.5, "x"]),
    # a bounce that stops every tracer
    ("tangential_restitution", lambda e: CollisionLaw(e, 5e-9), [0.0, 5e-324, 9e-9]),
    ("dimension", lambda d: CollisionLaw(0.5, dimension=d), [4, 2.0]),
    ("mass_ratio", lambda m: CollisionLaw(1.0, mass_ratio=m), [0.0, -INF, "1"]),
    ("p", CollisionLaw(0.01).decay_rate, [NAN, INF, "x", None, [1.0, NAN], -400.0]),
    ("p", CollisionLaw(0.01).mean_speed_ratio_power, [NAN, -400.0]),  # above 1e308
    ("p", CollisionLaw(0.0).decay_rate, [-1.0, -2.0, np.array([0.0, -1.5]), -1.0 + 2j]),
    ("p", CollisionLaw(0.0, dimension=3).decay_rate, [-2.0]),
    ("p", lambda p: CollisionLaw(0.0).harmonic_decay_rate(p, 2), [-1.0]),
    ("m", lambda m: DISKS.harmonic_decay_rate(1.0, m), [0.5, True, "1", None, NAN]),
    ("weight", lambda w: sampled(w, [0.5, 0.9], [0.0, 0.0]), [[-0.1, 1.1], [0.5, 0.4], []]),
    ("ratio", lambda s: sampled(HALVES, s, [0.0, 0.0]), [[0.0, 0.9], [0.5], [NAN, 0.5]]),
    ("cosine", lambda c: sampled(HALVES, HALVES, c), [[0.0, 1.1], ["x", 0.0]]),
    ("laws", lambda laws: CollisionLaw.mixture([1, 1], laws),
     [[DISKS, CollisionLaw(0.5, dimension=3)], [0.5], [], DISKS, [AMONG, DISKS]]),
    ("weights", lambda w: CollisionLaw.mixture(w, [DISKS] * 2), [[1, 0], [1], [1, NAN]]),
]  # fmt: skip
SYSTEM: list[tuple[str, Callable[..., Any], list[Any]]] = [
    ("restitution", lambda e: scene(restitution=e), [-0.01, NAN, INF, "half", None, 0.5j, True]),
    ("number_density", lambda n: scene(number_density=n), [0.0, -0.04, NAN, INF, "x", None]),
    # a mean free path that is no number
    ("number_density", lambda n: scene(number_density=n, diameter=n), [1e200, 1e-200, 1e-310]),
    ("number_density", lambda n: scene(number_density=n, dimension=3), [1e-320]),
    ("number_density", lambda n: scene(number_density=n, **DENSE), [0.31]),
    ("diameter", lambda d: scene(diameter=d), [0.0, -0.04, NAN, INF, "x", None]),
    ("times", lambda t: scene(times=t), [[], (), [1.0, 0.5], [-1.0], [0.0, NAN], [INF], [1j],
                                         "soon", None, [[1.0], [2.0]], [10**400]]),
    ("outputs", lambda o: scene(outputs=o), [(), [], 7, None, [None], "v", np.array(0.5)]),
    ("harmonics", lambda m: scene(harmonics=m), [-1, 257, 2.0, True, "8", None]),
    ("collision_numbers", lambda n: scene(collision_numbers=n),
     [[0.5], [-1], [1e300], [NAN], "many", [[1, 2]], None, [1j]]),
    ("scatterers", lambda s: scene(scatterers=s), ["spheres"]),
    ("initial|scatterers|outputs",
     lambda s: solve(scene(initial=s, outputs="speed_density", **DENSE)), ["monoenergetic"]),
    ("scatterers", lambda more: scene(**MEDIUM, **more),
     [dict(dimension=3), dict(tangential_restitution=0.9)]),
    ("collision_numbers", lambda n: scene(**MEDIUM, collision_numbers=n), [[1]]),
    ("scatterers", lambda law: Scene(law, times=[1.0], **DENSE), [MIXED]),
    ("field", lambda g, d, t: solved(field=g, diameter=d, times=[t], initial="rest", dimension=3),
     [(1e150, 1e150, 1.0), (1e-150, 1e-150, 1.0), (1.0, 1.0, 1e-300)]),
    ("density_order", lambda o: scene(**DENSE, density_order=o), ["third"]),
    ("mass_ratio", lambda more: scene(**light(**more)), [dict(tangential_restitution=0.5), DENSE]),
    ("mass_ratio", lambda more: ScalingSolution(**light(**more)), [dict(mass_ratio=0.0), MEDIUM]),
    ("mass_ratio", lambda more: solve_scaled(**light(**more)), [dict(mass_ratio="1"), MEDIUM]),
    ("mass_ratio", lambda more: solve_field(**light(**more)), [dict(tangential_restitution=0.5)]),
    ("bath_speed", lambda w: scene(bath_speed=w), [-1.0]),
    # of which powers are no numbers, or whose collided tracers would be lost
    ("bath_speed|heating|drag|times", lambda more: scene(**dict(capture_speed=1.0) | more),
     [{k: x} for k in ("bath_speed", "heating", "drag", "times") for x in (1e-150, 1e300)]),
    ("field", lambda g: solved(field=g, outputs="velocity_density"), [1e-13, 1e-36]),
    ("scatterers", lambda w: scene(bath_speed=w, **DENSE), [1.0]),
    ("tangential_restitution", lambda et: scene(drag=1.0, tangential_restitution=et), [0.5]),
    ("outputs", lambda o: scene(bath_speed=1.0, outputs=o), ["kurtosis"]),
    ("collision_numbers", lambda n: scene(bath_speed=1.0, collision_numbers=n), [[1]]),
    ("restitution", lambda law: Scene(law, times=[1.0]),
     [lambda v: 2.0 + v, [[2.0, 1.0], [0.5, 0.5]], lambda v: 1 / 0, lambda v: {}["e"]]),
    ("impact_speed", Viscoelastic(0.3), ["", "x", -1.0, None, 1j]),
    ("impact_speed", scene(restitution=([0.0, 1.0], [1.0, 0.5])).restitution, ["", -1.0]),
    ("mass_ratio", lambda m: Scene(CollisionLaw(1.0, mass_ratio=2.0), times=[1.0], mass_ratio=m),
     [3.0]),
    ("rtol", lambda rtol: solve(scene(), rtol), [0.0, 1e-15, 0.5, NAN, "x"]),
    ("scene", solve, [{"restitution": 0.5}]),
    ("method", lambda name: solve(scene(), method=name), ["fast"]),
    ("method", lambda start: solve(scene(initial=start, outputs="speed_density"),
                                   method="spectral"), ["monoenergetic", SpeedSamples([0.3, 1.0])]),
    ("nodes", lambda n: solve(scene(), nodes=n), [7, 10_000, 64.0, True]),
]  # fmt: skip
STATES: list[tuple[str, Callable[..., Any], list[Any]]] = [
    ("density", lambda f: SpeedTable(V, f), [2 * V - 0.5, NAN * ONES, INF * ONES, 2 * ONES,
                                             0 * ONES, ONES[1:], ONES[:, None], "flat", V * 1j]),
    ("speed", lambda v: SpeedTable(v, np.ones(len(v))),
     [V[::-1], V - 0.5, [1.0], [0.0, 0.5, 0.5, 1.0], [0.0, NAN, 1.0], "fast"]),
    ("speed", SpeedSamples, [[], [1.0, 0.0], [1.0, -1.0], [1.0, NAN], [[1.0, 2.0]], "slow", [1j]]),
    ("speed", Monoenergetic, [0.0, -1.0, NAN, "one", 1j, [1.0, 2.0]]),
    ("deviation_x", lambda x: Gaussian(x, 1.0), [0.0, -1.0, "a"]),
    ("deviation_y", lambda y: Gaussian(1.0, y), [INF]),
    ("velocity", VelocitySamples, [[1.0, 2.0], [[1.0, 2.0, 3.0]], [[1.0, NAN]], [[0.0, 0.0]], [],
                                   "north", [[1.0, 1.0j]]]),
    ("direction", Beam, [NAN, "up"]),
    ("speeds", lambda s: Beam(0.0, s), [Gaussian(1.0, 2.0), "warm"]),
    ("terms", AngularHarmonics, [{1: AN_EXP}, {0: AN_EXP, -1: AN_EXP}, {0: AN_EXP, 0.5: AN_EXP},
                                 {0: AN_EXP, "a": AN_EXP}, {0: 1.0}, 3.0]),
    ("values", lambda f: PolarGrid(GRID, f), [FLAT[1:], np.ones(5), NAN * FLAT, "flat", FLAT[:, :0],
                                              -FLAT / np.pi, FLAT]),
    ("speed", lambda v: PolarGrid(v, FLAT), [GRID[::-1]]),
    ("initial", lambda start: scene(initial=start, dimension=3), [Gaussian(1.0, 2.0), Beam(0.5)]),
    ("initial", lambda start: scene(initial=start), [3.0, None, [1.0, 2.0], "maxwell"]),
    ("initial|density", lambda f: solve(scene(initial=f)), [
        lambda v: v * np.exp(-0.5 * v * v) - 0.1 * np.exp(-v),  # negative
        lambda v: 2 * v * np.exp(-0.5 * v * v),  # not normalised
        np.zeros_like, lambda v: v * NAN, lambda v: np.where(v > 1.0, NAN, v),
        lambda v: 2.0 * v / (1.0 + v * v) ** 2,  # tail v^-3: <v^2> diverges
        lambda v: 1.0 / (1.0 + v),  # does not normalise at all
        lambda v: np.ones(3), lambda v: "much", lambda v: None, lambda: 1.0,
        lambda v: v * np.exp(-0.5 * v * v) * (1.0 + 1.0j),
        lambda v: 1.0 if v > 1 else 0.0,  # not made for arrays
        lambda v: 1 / 0,
        SpeedDensity(lambda v: -v), SpeedDensity(3.0),
    ]),
]  # fmt: skip
RESULTS: list[tuple[str, Callable[..., Any], list[Any]]] = [
    ("p", lambda p: solved().moment(p), [-2.0, NAN, 41.0, "x", None]),
    ("p", lambda p: solved(restitution=0.0).moment(p), [-1.0]),
    ("p", lambda p: solved(initial=Beam()).harmonic(p, 1), ["x", NAN, 50]),
    ("m", lambda m: solved(initial=Beam()).harmonic(1, m), [-1, 300, 0.5]),
    ("collision_numbers", lambda m: solved().by_collision, [0]),
    ("p", lambda p: solved(restitution=0.0, collision_numbers=[3]).by_collision.moment(p), [-1.0]),
    ("collision_numbers",  # <1/v> does not exist
     lambda e: solved(restitution=e, collision_numbers=[3]).by_collision.mean_time, [0.0]),
    ("collision_numbers",  # it overflows
     lambda e: solved(restitution=e, collision_numbers=[10**6]).by_collision.a2, [0.1]),
    ("name", lambda name: solved().plot(name), ["speed"]),
    ("name", lambda name: solved().to_dataframe(name), ["speed"]),
    ("name", lambda name: solved().plot(name), [np.array(["a2", "msd"])]),
    ("name", lambda name: solve_scaled(0.5, 1e-3).to_dataframe(name), [np.array(["a2", "vdf"])]),
    ("name", lambda name: solve_field(0.5, rtol=1e-2).plot(name), [np.array(["a2", "vdf"])]),
    ("c", lambda c: ScalingSolution(0.5).to_xarray(c=c), ["a", [-1.0], [NAN], [[1.0, 2.0]]]),
    ("r", lambda r: placed().position_density(r), [[-1.0], [], ["a"]]),
    ("scaled_radii", lambda x: placed().scaled_position_density(x), [[NAN]]),
    ("scaled_radii", lambda x: placed().position_tail(x), [[-0.5]]),
    ("edges", lambda r: placed().position_fraction(r), [[1.0], [2.0, 1.0]]),
    ("wave_numbers", lambda k: placed().intermediate_scattering(k), [[], [-1.0], [1e9], [1e308]]),
    ("wave_numbers", lambda k: solved(
        times=[1e-9], outputs="intermediate_scattering").intermediate_scattering(k), [[1e8]]),
    ("wave_numbers", lambda k: solve(  # 44 s, and 6 GB
        scene(restitution=0.0, times=[12.5], outputs="intermediate_scattering"), 1e-6
        ).intermediate_scattering(k), [[15.9]]),
    ("direction", lambda way: placed().intermediate_scattering([1.0], way), [INF]),
    ("p", lambda f, p: solved(initial=SpeedTable([0.0, 1.0], f)).moment(p),
     [([2.0, 0.0], -1.0), ([0.0, 2.0], -2.0)]),
    ("p|m", lambda e, p, m: solve_field(e, rtol=1e-6).moment(p, m),
     [(0.5, -2.0, 0), (0.5, -3.0, 1), (0.5, 21.0, 0), (0.5, NAN, 0), (0.5, 1.0, -1),
      (0.5, 1.0, 1000), (0.0, -2.0, 1), (0.5, 1.0, np.ma.masked)]),
    ("number_density", lambda *units: solve_field(0.7, rtol=1e-6).in_units(*units),
     [(1e300, 1e-300, 1.0)]),
    ("rtol", lambda rtol: solve_scaled(0.5, rtol), [0.0, 1e-15, 0.2, NAN, "x", None]),
    ("restitution", solve_scaled, [1.0, "x"]),
    ("restitution", lambda s: solve_scaled(sampled(HALVES, s, [0.0, 0.0])), [[0.5, 1.5]]),
    ("nodes", lambda n: solve_scaled(0.5, nodes=n), [7]),
    ("p", lambda e, p: solve_scaled(e).moment(p), [(0.5, 301.0), (0.0, -1.0), (0.1, 300.0)]),
    ("c", lambda c: solve_scaled(0.5).vdf(c), [-1.0]),
    ("p", lambda e, p: ScalingSolution(e).moment(p), [(0.5, NAN), (0.0, -1.0), (0.1, 300.0)]),
    ("c", lambda c: ScalingSolution(0.5).vdf(c), [[0.1, INF]]),
    ("restitution", ScalingSolution(1.0).path_cumulants, [2]),
    ("restitution", ScalingSolution(1.0).vdf, [0.5]),
    ("restitution", ScalingSolution(1.0).scaled_speed_moment, [1.0]),
    ("p", lambda p: solve_scaled(0.0, dimension=3).moment(p), [-2.0]),
    ("number_density", lambda s: ScalingSolution(0.7, scatterers=s).a2, ["overlapping"]),
    ("number_density", lambda s: solve_scaled(0.7, scatterers=s), ["overlapping"]),
    ("p", ScalingSolution(0.7, **MEDIUM).moment, [-3.0]),
    ("scatterers", ScalingSolution(0.5, **MEDIUM).collision_power, [0.5]),
    ("z", ScalingSolution(0.5).collision_power, [0.0, -1.0, INF, NAN, 1e300, 1e-300]),
    ("z", ScalingSolution(MIXED).collision_power, [2.0]),  # half of the bounces lose nothing
    ("n", ScalingSolution(0.5).collision_cumulants, [0, 13]),
]  # fmt: skip


@pytest.mark.parametrize(
    ("name", "call", "value"),
    [(name, call, value) for name, call, values in LAW + SYSTEM + STATES + RESULTS
     for value in values],
)  # fmt: skip
def test_one_line_names_the_argument(name: str, call: Callable[..., Any], value: Any) -> None:
    with pytest.raises(InputError, match=rf"^({name}): [^\n]*$") as refused:
        call(*value) if isinstance(value, tuple) and value else call(value)
    assert len(str(refused.value)) < 400


@pytest.mark.skipif(np.finfo(np.longdouble).max <= 1e308, reason="long doubles are doubles here")
def test_a_long_double_beyond_the_doubles_is_refused() -> None:
    solution = solve(Scene(0.7, times=[1.0], outputs="intermediate_scattering"))
    for k in (np.longdouble("1e4000"), [np.longdouble("1e4000")]):
        with pytest.raises(InputError, match="wave_numbers"):
            solution.intermediate_scattering(k)


def test_outputs_that_were_not_asked_for_say_so() -> None:
    solution = solved(outputs="msd")
    for name in ("position_density", "scaled_position_density", "intermediate_scattering"):
        with pytest.raises(InputError, match="was not asked for"):
            getattr(solution, name)([1.0])
    with pytest.raises(InputError, match="was not asked for"):
        _ = solution.ballistic_front
    with pytest.raises(AttributeError, match=r"'a2' was not asked for.* has msd"):
        _ = solution.a2


def test_a_peak_too_narrow_to_find() -> None:
    """One part in 10^8 wide: a function cannot be searched for it, a table can give it."""

    def peak(v: Any) -> Any:
        with np.errstate(under="ignore"):
            return np.exp(-0.5 * ((v - 2.0) / 2e-8) ** 2) / (2e-8 * np.sqrt(2 * np.pi))

    with pytest.raises(InputError, match=r"SpeedTable$"):
        solve(scene(initial=peak))
    v = 2.0 + 2e-8 * np.linspace(-8.0, 8.0, 401)
    table = SpeedTable(v, peak(v) / np.trapezoid(peak(v), v))
    found = solve(scene(initial=table, times=[0.0])).thermal_speed[0]
    assert np.isclose(found, 2.0, rtol=1e-9)


@pytest.mark.parametrize(("name", "meant"), [
    ("thermal_sped", "thermal_speed"), ("MSD", "msd"), ("mean_square_displacement", "msd"),
    ("speed density", "speed_density"),
])  # fmt: skip
def test_an_output_that_is_nearly_right_is_suggested(name: str, meant: str) -> None:
    with pytest.raises(InputError, match=f"did you mean '{meant}'"):
        Scene(0.7, times=[1.0], outputs=name)


def test_what_a_solution_has_not_is_not_said_to_be_not_asked_for() -> None:
    solution = solve(Scene(0.7, times=[1.0, 2.0], outputs=("thermal_speed",)))
    with pytest.raises(AttributeError, match="no 'thermal_sped'; did you mean 'thermal_speed'"):
        _ = solution.thermal_sped
    with pytest.raises(AttributeError, match="ScalingSolution"):
        _ = solution.vdf
    np.testing.assert_array_equal(solution["thermal_speed"], solution.thermal_speed)
    with pytest.raises(KeyError, match="thermal_speed"):
        _ = solution["msd"]


def test_several_restitutions_lead_to_sweep() -> None:
    with pytest.raises(InputError, match="sweep"):
        Scene([0.5, 0.7], times=[1.0])
