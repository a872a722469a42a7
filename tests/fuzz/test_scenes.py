"""Scenes, initial states and what a Solution is asked: right with an honest status, or refused."""

import math
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from fuzzing import (
    broken,
    examples,
    extremes,
    fuzz,
    geometric,
    mostly,
    restitutions,
    result_or_refusal,
)
from hypothesis import strategies as st

from kinetics import (
    AngularHarmonics,
    Beam,
    Gaussian,
    Monoenergetic,
    PolarGrid,
    Scene,
    Solution,
    SolverStatus,
    SpeedDensity,
    SpeedSamples,
    SpeedTable,
    VelocitySamples,
    load,
    solve,
)
from kinetics.collision.medium import SCATTERERS
from kinetics.outputs import OUTPUTS

# -- initial states


def _gauss(v: Any) -> Any:
    with np.errstate(all="ignore"):
        return np.minimum(v, 1e100) * np.exp(-0.5 * np.minimum(v, 1e100) ** 2)


def _grid(rows: int, columns: int) -> PolarGrid:
    speed = np.linspace(0.0, 2.0, rows + 2)
    values = np.full((rows + 2, columns), 0.25 / math.pi * 2.0)
    values = values / (2.0 * np.trapezoid(speed, speed) * values[0, 0] * math.pi)
    return PolarGrid(speed, values)


FUNCTIONS: list[Any] = [
    _gauss,
    lambda v: 2.0 * _gauss(v),
    lambda v: -_gauss(v),
    lambda v: 0.0 * v,
    lambda v: v * math.nan,
    lambda v: 1.0 / (1.0 + v),
    lambda v: 1.0,
    lambda v: None,
    lambda v: v[:1],
    lambda v: _gauss(v) * (1.0 + 1.0j),
    lambda: 1.0,
]
"""Speed densities, most of which are none."""

_number = mostly(geometric(0.1, 10.0), extremes() | broken())
_table = st.lists(st.floats(0.0, 1.0), min_size=3, max_size=5)


@st.composite
def states(draw: Any) -> tuple[Any, tuple[Any, ...]]:
    """A state's class and its arguments."""
    kind = draw(st.sampled_from(sorted(_STATES)))
    return _CLASSES[kind], draw(_STATES[kind])


def _speed_table(values: list[float]) -> tuple[Any, Any]:
    """A table that is normalised, unless all its values are zero."""
    speed, density = np.arange(len(values)) * 0.7, np.asarray(values)
    total = np.trapezoid(density, speed)
    return speed, density / total if total > 0.0 else density


_CLASSES = {
    "Gaussian": Gaussian,
    "Monoenergetic": Monoenergetic,
    "SpeedTable": SpeedTable,
    "SpeedSamples": SpeedSamples,
    "SpeedDensity": SpeedDensity,
    "Beam": Beam,
    "VelocitySamples": VelocitySamples,
    "AngularHarmonics": AngularHarmonics,
    "PolarGrid": PolarGrid,
}
_STATES = {
    "Gaussian": st.tuples(_number, _number),
    "Monoenergetic": st.tuples(_number),
    "SpeedTable": mostly(_table.map(_speed_table), st.tuples(broken(), broken())),
    "SpeedSamples": st.tuples(mostly(st.lists(geometric(0.1, 10.0), max_size=5))),
    "SpeedDensity": st.tuples(mostly(st.just(_gauss), st.sampled_from(FUNCTIONS) | broken())),
    "Beam": st.tuples(
        mostly(st.floats(-4.0, 4.0), extremes() | broken()),
        mostly(st.sampled_from(["gaussian", "monoenergetic", SpeedSamples([1.0, 2.0])])),
    ),
    "VelocitySamples": st.tuples(
        mostly(st.lists(st.tuples(st.floats(-3, 3), st.floats(-3, 3)), max_size=4))
    ),
    "AngularHarmonics": st.tuples(
        mostly(
            st.sampled_from(
                [
                    {0: _gauss},
                    {0: _gauss, 1: lambda v: 0.0 * v},
                    {0: _gauss, 2: lambda v: 0.5 * _gauss(v)},
                ]
            ),
            st.dictionaries(st.integers(-1, 3) | st.text(), st.sampled_from(FUNCTIONS)) | broken(),
        )
    ),
    "PolarGrid": mostly(
        st.tuples(st.integers(1, 4), st.sampled_from([1, 2, 3, 16])).map(
            lambda size: (_grid(*size).speed, _grid(*size).values)
        ),
        st.tuples(broken(), broken()),
    ),
}

# -- scenes

CHEAP = [name for name, row in OUTPUTS.items() if row.values is not None]
LATE = {"position_density", "intermediate_scattering"}  # early ones take seconds
DENSE = [name for name in OUTPUTS if name not in CHEAP and name not in LATE]
_time = mostly(geometric(1e-2, 1e4), st.sampled_from([0.0, 5e-324, 1e-300, 1e100, 1e300, 1e308]))


def scenes(outputs: Any) -> Any:
    """Arguments of a scene, and of its solution."""
    return st.fixed_dictionaries(
        {
            "restitution": mostly(restitutions()),
            "number_density": mostly(st.just(0.04), extremes() | broken()),
            "diameter": mostly(st.just(1.0), extremes() | broken()),
            "tangential_restitution": mostly(st.just(1.0) | restitutions()),
            "dimension": mostly(st.just(2) | st.sampled_from([2, 3])),
            "scatterers": mostly(st.just("dilute") | st.sampled_from(SCATTERERS)),
            "initial": st.sampled_from(["gaussian", "monoenergetic"]) | mostly(states()),
            "times": mostly(st.lists(_time, min_size=1, max_size=3).map(sorted)),
            "outputs": mostly(outputs),
            "harmonics": mostly(st.integers(0, 3)),
            "rtol": mostly(st.sampled_from([1e-2, 1e-4, 1e-8, 1e-10, 1e-12])),
            "method": mostly(st.none(), st.sampled_from(["spectral", "conservative"]) | broken()),
            "nodes": mostly(st.none(), st.integers(8, 64) | broken()),
            "power": mostly(st.floats(-1.5, 6.0), extremes() | broken()),
            "order": mostly(st.integers(0, 3), st.integers() | broken()),
            "also": st.sampled_from(["nothing", "methods", "methods", "file"]),
            "points": mostly(
                st.lists(geometric(1e-3, 1e2), min_size=1, max_size=3).map(sorted),
                st.lists(extremes()) | broken(),
            ),
        }
    )


AVERAGES = scenes(st.lists(st.sampled_from(CHEAP), min_size=1, max_size=4))
DENSITIES = scenes(st.lists(st.sampled_from(DENSE), min_size=1, max_size=1))
POSITIONS = scenes(st.sampled_from(sorted(LATE)))


@examples(40)
def test_averages(tries: int) -> None:
    fuzz(check_scene, AVERAGES, tries)


@examples(10)
def test_densities(tries: int) -> None:
    fuzz(check_scene, DENSITIES.map(_loose), tries)


@examples(2)
def test_positions(tries: int) -> None:
    fuzz(check_scene, POSITIONS.map(_late), tries)


def _late(asked: dict[str, Any]) -> dict[str, Any]:
    """The scene at a time after many collisions, where the displacement costs no seconds."""
    asked["times"] = [1e3 * time for time in [1.0, 7.0]]
    return _loose(asked)


def _loose(asked: dict[str, Any]) -> dict[str, Any]:
    """The scene with a tolerance that costs no seconds."""
    if isinstance(asked["rtol"], float) and asked["rtol"] > 0.0:
        asked["rtol"] = max(asked["rtol"], 1e-3)
    return asked


def solved(asked: dict[str, Any]) -> Solution | None:
    """The solution, or None where an argument was refused."""
    system = {name: asked[name] for name in _SYSTEM}
    if isinstance(system["initial"], tuple) and len(system["initial"]) == 2:
        kind, arguments = system["initial"]
        state = result_or_refusal(kind, *arguments)
        if state is None:
            return None
        system["initial"] = state
    scene = result_or_refusal(Scene, **system)
    if scene is None:
        return None
    hash(scene)
    repr(scene)
    settings = {name: asked[name] for name in ("rtol", "method", "nodes")}
    found: Solution | None = result_or_refusal(solve, scene, **settings)
    return found


_SYSTEM = (
    "restitution",
    "number_density",
    "diameter",
    "tangential_restitution",
    "dimension",
    "scatterers",
    "initial",
    "times",
    "outputs",
    "harmonics",
)


def check_scene(asked: dict[str, Any]) -> None:
    solution = solved(asked)
    if solution is None:
        return
    for name, array in solution.values.items():
        assert np.all(np.isfinite(array)), name
    assert solution.message
    repr(solution)
    _check_start(solution)
    if solution.status is SolverStatus.CONVERGED:
        assert solution.error_estimate <= 1.1 * max(solution.rtol, 1e-8)
        _check_against_tighter(solution)
    if asked["also"] == "methods":
        _check_methods(solution, asked)
    if asked["also"] == "file":
        _check_saved(solution)


def _check_start(solution: Solution) -> None:
    """Averages at time 0 are those of the start; they never grow, or never fall."""
    values, times = solution.values, np.asarray(solution.times)
    rtol = 4.0 * max(solution.rtol, solution.error_estimate)
    for name in ("thermal_speed", "temperature"):
        if name in values:
            assert np.all(np.diff(values[name]) <= rtol * values[name][:-1]), name
    for name in ("collisions", "msd"):
        if name in values:
            assert np.all(np.diff(values[name]) >= -rtol * values[name][1:]), name
            assert np.all(values[name][times == 0.0] == 0.0), name
    if solution.scene.initial == "gaussian" and "thermal_speed" in values:
        assert np.allclose(values["thermal_speed"][times == 0.0], math.sqrt(2.0), rtol=rtol)


def _check_against_tighter(solution: Solution) -> None:
    """What is called converged is within rtol of the same at the best accuracy."""
    if not solution.values:
        return
    scene = solution.scene
    parts = {name: getattr(scene, name) for name in _SYSTEM} | {"initial": scene.state}
    names = dict.fromkeys(("thermal_speed", *solution.values))
    names.pop("msd_slope", None)  # comes with the diffusion coefficient
    fine = solve(Scene(**parts | {"outputs": tuple(names)}), 1e-13)
    allowed = solution.rtol + fine.error_estimate
    speed = fine.thermal_speed
    start = solve(Scene(**parts | {"outputs": "thermal_speed", "times": 0.0})).thermal_speed
    with np.errstate(over="ignore"):
        sizes = {
            "velocity_autocorrelation": start * speed,
            "mean_velocity": speed[:, None],
            "velocity_tensor": (speed**2)[:, None, None],
        }
    for name, array in solution.values.items():
        exact = fine.values[name]
        size = 1.0 + exact if name == "a2" else sizes.get(name, np.abs(exact))
        if name == "mean_displacement":
            size = np.linalg.norm(exact, axis=1, keepdims=True)
        excess = np.abs(array - exact) - 1.5 * allowed * np.abs(size)
        assert np.all(excess <= 1e-300), (name, array, exact)


def _check_methods(solution: Solution, asked: dict[str, Any]) -> None:
    power, order, points = asked["power"], asked["order"], asked["points"]
    moment = result_or_refusal(solution.moment, power)
    harmonic = result_or_refusal(solution.harmonic, power, order)
    for found in (moment, harmonic):
        assert found is None or np.all(np.isfinite(found))
    outputs = solution.scene.outputs
    densities: list[Any] = []
    if "speed_density" in outputs:
        densities = [solution.speed_density, solution.velocity_component_density]
        shares = result_or_refusal(lambda: solution.uncollided)
        assert np.all((shares >= 0.0) & (shares <= 1.0 + 1e-12))
        _check_speeds(solution, shares)
    if "velocity_density" in outputs:
        densities = [lambda v: solution.velocity_density(v, v)]
    if "position_density" in outputs:
        densities = [solution.position_density, solution.position_fraction]
        scaled = result_or_refusal(solution.scaled_position_density, points)
        if scaled is not None:
            assert np.all(np.isfinite(scaled[np.asarray(solution.times) > 0.0]))
        result_or_refusal(solution.position_tail, points)
    if "intermediate_scattering" in outputs:
        densities = [solution.intermediate_scattering]
    for density in densities:
        found = result_or_refusal(density, points)
        assert found is None or np.all(np.isfinite(found)), found


def _check_speeds(solution: Solution, uncollided: Any) -> None:
    """The density of the speed is not negative, and its integral is 1, within its error."""
    error = max(solution.rtol, solution.error_estimate)
    # from 1e-6 to 30 typical speeds, as a density of ln v
    x = np.linspace(math.log(1e-6), math.log(30.0), 2000)
    for k, unit in enumerate(solution._typical_speed):
        values = np.exp(x) * unit * solution.speed_density(np.exp(x) * unit)[k]
        assert np.all(values >= -1.5 * error * values.max()), (values.min(), values.max(), error)
        mass = np.trapezoid(values, x) + uncollided[k]
        if not isinstance(solution.scene.state, (SpeedSamples, VelocitySamples)):  # no steps
            assert abs(mass - 1.0) <= 0.01 + 10.0 * error, (mass, error)


def _check_saved(solution: Solution) -> None:
    """A file gives an equal solution, or the start is a function, which no file holds."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "solution.h5")
        result_or_refusal(solution.save, path)
        assert path.exists() or isinstance(solution.scene.state, (SpeedDensity, AngularHarmonics))
        assert len(list(Path(folder).iterdir())) == path.exists()
        if path.exists():
            assert load(path) == solution
