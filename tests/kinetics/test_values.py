"""Results are values: read-only, compared by contents, hashed, pickled, and short to print."""

import concurrent.futures
import dataclasses
import importlib.metadata
import multiprocessing
import pickle
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from example_values import TIMES, VALUES, solved, with_densities

import kinetics
from kinetics import (
    Gaussian,
    ScalingSolution,
    Scene,
    SpeedSamples,
    load,
    solve,
    solve_scaled,
)
from kinetics.frozen import FrozenDict, contents, read_only
from kinetics.numerics.log_grid import LogGrid
from kinetics.status import PlanStep
from kinetics.storage import HOMES
from kinetics.values import Value


@pytest.mark.parametrize("name", VALUES)
def test_equal_hashed_and_pickled(name: str) -> None:
    value, again = VALUES[name](), VALUES[name]()
    copy = pickle.loads(pickle.dumps(value))
    assert value == again == copy
    assert hash(value) == hash(again) == hash(copy)
    assert len({value, again, copy}) == 1
    assert value != object()


@pytest.mark.parametrize("name", VALUES)
def test_arrays_stay_read_only_after_pickling(name: str) -> None:
    value = VALUES[name]()
    for thing in (value, pickle.loads(pickle.dumps(value))):
        for f in dataclasses.fields(thing):
            array = getattr(thing, f.name)
            if isinstance(array, np.ndarray):
                with pytest.raises(ValueError, match="read-only"):
                    array[...] = 0.0


def arrays_in(thing: Any) -> list[np.ndarray]:
    """All arrays in the fields of a value, and in those of its parts."""
    if isinstance(thing, np.ndarray):
        return [thing]
    if isinstance(thing, tuple | list):
        return [array for item in thing for array in arrays_in(item)]
    if isinstance(thing, Mapping):
        return [array for item in thing.values() for array in arrays_in(item)]
    if isinstance(thing, Value):
        fields = dataclasses.fields(thing)  # type: ignore[arg-type]
        return [array for f in fields for array in arrays_in(getattr(thing, f.name))]
    assert type(thing) in (LogGrid, PlanStep) or not dataclasses.is_dataclass(thing)
    return []


def test_the_parts_of_a_solution_are_values_too() -> None:
    """Those of the position and of the densities: read-only also after pickling, and in files."""
    for solution in (with_densities(), solved("gaussian", outputs=("position_density",))):
        for thing in (solution, pickle.loads(pickle.dumps(solution))):
            found = arrays_in(thing)
            assert len(found) > 10
            assert not any(array.flags.writeable for array in found)
        displacement = solution._displacement
        assert displacement is not None
        for part in (displacement, displacement.uncollided, *displacement.panels):
            assert isinstance(part, Value)
            assert HOMES[type(part).__name__] == type(part).__module__


def test_different_questions_give_different_values() -> None:
    scene = Scene(0.7, times=TIMES)
    others = [
        Scene(0.6, times=TIMES),
        Scene(0.7, times=[0.0, 1.0, 100.5]),
        Scene(0.7, times=TIMES, outputs="msd"),
        Scene(0.7, times=TIMES, initial="monoenergetic"),
        Scene(0.7, 0.05, times=TIMES),
        Scene(0.7, times=TIMES, harmonics=3),
    ]
    assert len({scene, *others}) == 7
    assert scene == Scene(0.7, times=np.array(TIMES), initial=Gaussian())
    assert solve(scene) != solve(others[0])
    assert solve(scene) != solve(scene, rtol=1e-3)
    assert solve_scaled(0.7) != solve_scaled(0.7, 1e-8)
    assert ScalingSolution(0.7) != ScalingSolution(0.8)


def test_nothing_in_a_solution_can_be_changed() -> None:
    solution = with_densities()
    with pytest.raises(ValueError, match="read-only"):
        solution.msd[0] = 99.0
    with pytest.raises(ValueError, match="read-only"):
        solution.values["msd"][0] = 99.0
    with pytest.raises(ValueError, match="read-only"):
        solution.times[0] = 99.0
    sharp = solved("monoenergetic", outputs=("speed_density", "position_density"))
    for array in (*sharp.ballistic_front, sharp.uncollided):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0
    for mapping in (solution.values, solution.stats, solution.stats["systems"]):
        with pytest.raises(TypeError):
            mapping["msd"] = 1  # type: ignore[index]
        with pytest.raises(AttributeError):
            mapping._items = {}  # type: ignore[attr-defined]
    with pytest.raises(dataclasses.FrozenInstanceError):
        solution.rtol = 1.0  # type: ignore[misc]


def test_the_arrays_of_the_caller_stay_his() -> None:
    """Neither frozen by a scene, nor seen by it when they change later."""
    times, speed = np.array(TIMES), np.array([0.5, 1.0])
    scene = Scene(0.7, times=times, initial=SpeedSamples(speed))
    times[0], speed[0] = 0.5, 0.7
    assert scene.times[0] == 0.0
    assert scene.state.speed[0] == 0.5
    array = np.ones(3)
    view = read_only(array[:2])
    array[0] = 7.0
    assert view[0] == 1.0


def test_contents() -> None:
    assert contents(np.array([np.nan, 0.0])) == contents(np.array([np.nan, -0.0]))
    assert contents(math_nan := float("nan")) == contents(math_nan * 1.0)
    assert contents(np.zeros(2)) != contents(np.zeros((2, 1)))
    assert contents(np.zeros(2)) != contents(np.zeros(2, dtype=int))
    assert contents({"a": np.ones(2)}) == contents(FrozenDict({"a": np.ones(2)}))
    assert FrozenDict({"a": 1, "b": [2]}) == {"b": [2], "a": 1}
    assert hash(FrozenDict({"a": 1, "b": 2})) == hash(FrozenDict({"b": 2, "a": 1}))
    assert list(FrozenDict({"b": 1, "a": 2})) == ["b", "a"]


def test_a_class_of_ones_own_is_a_value_too() -> None:
    @dataclasses.dataclass(frozen=True)
    class Result(Value):
        array: Any
        note: str = dataclasses.field(default="", compare=False)

    assert Result(np.arange(3), "a") == Result(np.arange(3), "b")
    assert hash(Result(np.arange(3))) == hash(Result(np.arange(3), "b"))
    assert Result(np.arange(3)) != Result(np.arange(4))


# -- another process ------------------------------------------------------------------------------


def test_solutions_come_back_from_a_process_pool() -> None:
    scenes = [Scene(e, times=TIMES, outputs=("msd", "speed_density")) for e in (0.5, 0.7)]
    context = multiprocessing.get_context("spawn")
    with concurrent.futures.ProcessPoolExecutor(1, mp_context=context) as pool:
        found = list(pool.map(solve, scenes, [1e-4, 1e-4]))
    for scene, solution in zip(scenes, found, strict=True):
        assert solution == solve(scene, 1e-4)
        assert np.array_equal(solution.speed_density([1.0]), solve(scene, 1e-4).speed_density([1]))
        assert solution.moment(3.0).shape == (3,)


def test_a_pickled_solution_answers_everything() -> None:
    solution = with_densities()
    copy = pickle.loads(pickle.dumps(solution))
    v = [0.1, 1.0]
    for ask in (
        lambda s: s.moment(3.0),
        lambda s: s.harmonic(1.0, 1),
        lambda s: s.speed_density(v),
        lambda s: s.velocity_component_density(v),
        lambda s: s.velocity_density(v, v),
        lambda s: s.position_density(v),
        lambda s: s.position_fraction([0.0, 1.0, 5.0]),
        lambda s: s.intermediate_scattering(v, 0.3),
        lambda s: s.uncollided,
        lambda s: s.ballistic_front[0],
    ):
        assert np.array_equal(ask(copy), ask(solution))


# -- what a reader sees ---------------------------------------------------------------------------


@pytest.mark.parametrize("name", VALUES)
def test_short_to_print(name: str) -> None:
    value = VALUES[name]()
    lines = repr(value).splitlines()
    assert len(lines) <= 10
    assert max(map(len, lines)) < 500
    assert "0.7" in lines[0] or "1.0" in lines[0]


def test_what_a_solution_prints() -> None:
    solution = solve(Scene(0.7, times=TIMES, outputs=("thermal_speed", "msd", "speed_density")))
    text, page = repr(solution), solution._repr_html_()
    for part in ("thermal_speed (3,) in U", "msd (3,) in d^2", "speed_density (3, n_v) in 1/U"):
        assert part in text
    assert "rtol = 1e-10, converged" in text
    assert page.count("<tr>") == 4
    for part in ("<td>msd</td><td>(3,)</td><td>d^2</td>", "n_v", "converged", "gaussian"):
        assert part in page
    assert "<td>msd</td>" not in solve(Scene(0.7, times=TIMES))._repr_html_()
    assert "mean square displacement" in Scene(0.7, times=TIMES, outputs="msd")._repr_html_()
    assert "0.412181911126" in repr(solve_scaled(0.7))
    assert "0.412181911126" in solve_scaled(0.7)._repr_html_()


def test_completion_shows_the_outputs() -> None:
    solution = solve(Scene(0.7, times=TIMES, outputs=("msd", "diffusion_coefficient")))
    names = dir(solution)
    assert {"msd", "diffusion_coefficient", "msd_slope", "moment", "save"} <= set(names)
    assert "a2" not in names
    assert names == sorted(names)


def test_the_package_shows_its_names() -> None:
    assert dir(kinetics) == sorted(kinetics.__all__)
    assert {"solve", "load", "sonine", "__version__"} <= set(dir(kinetics))
    assert kinetics.sonine.a2(1.0) == pytest.approx(-0.5, abs=0.5)
    assert load is kinetics.load


@pytest.mark.parametrize("installed", [True, False])
def test_version(monkeypatch: pytest.MonkeyPatch, installed: bool) -> None:
    def version(name: str) -> str:
        assert name == "inelastic-lorentz"
        if not installed:
            raise importlib.metadata.PackageNotFoundError
        return "1.2.3"

    monkeypatch.setattr(importlib.metadata, "version", version)
    monkeypatch.delitem(vars(kinetics), "__version__", raising=False)
    assert kinetics.__version__ == ("1.2.3" if installed else "0+unknown")
    monkeypatch.delitem(vars(kinetics), "__version__")
