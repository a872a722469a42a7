"""Scenes with a field: averages and densities of the velocity over time."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from kinetics.errors import InputError, short
from kinetics.field.backward import ALL, needed_for
from kinetics.field.evolution import Evolution, scales
from kinetics.field.resolution import TimeResolution
from kinetics.field.scene_densities import SceneDensities
from kinetics.field.starts import Start
from kinetics.numerics import FloatArray
from kinetics.numerics.threads import one_blas_thread
from kinetics.outputs import DENSITIES
from kinetics.scene import Scene
from kinetics.solution import Solution
from kinetics.status import PlanStep, explain, status_of

_ATTEMPTS = 5
_ALWAYS = 3  # so many attempts, and more as long as they have at most _MOST harmonics
_MOST = 65
_FAR = 0.1  # two solutions so far apart: finer ones, which take ever longer, do not reach rtol
# A start is at rest if its velocities are below this, times rtol and the first time. Of isotropic
# starts below the root of rtol: they change averages by the square of their velocities.
_AT_REST = 0.1
_DENSITIES = {"speed_density", "velocity_density"}
_MADE_OF = {
    "thermal_speed": ("v^2",),
    "temperature": ("v^2",),
    "a2": ("v^2", "v^4"),
    "collisions": ("collisions",),
    "msd": ("x^2", "y^2"),
    "mean_displacement": ("x", "y"),
    "mean_velocity": ("v_x", "v_y"),
    "velocity_tensor": ("v^2", "v^2 cos 2", "v_x v_y"),
    "displacement_tensor": ("x", "y", "x^2", "y^2", "x y"),
}


@one_blas_thread
def solve_in_field(scene: Scene, rtol: float) -> Solution:
    """What :func:`kinetics.solve` does for a scene with a field.

    Errors are relative to the root mean square for velocities and displacements, to <v^2> and
    <r^2> for the tensors. They are estimated from a second solution with fewer speeds and
    harmonics.
    """
    path, g = scene.mean_free_path, scene.field
    speed, time = math.sqrt(g) * math.sqrt(path), math.sqrt(path) / math.sqrt(g)
    with np.errstate(over="ignore"):
        times = np.asarray(scene.times) / time
    if not (1e-100 < speed < 1e100 and times[-1] < 1e15):
        raise InputError(
            f"field: got {short(g)}; sqrt(field x mean free path) and the times in "
            "sqrt(mean free path/field) are out of range"
        )
    fine, error = _solved(scene, rtol, speed, times)
    errors, allowed = {"averages": error}, {"averages": rtol}
    densities = None
    if set(scene.outputs) & _DENSITIES:
        densities = SceneDensities(
            scene.law, scene.state, np.asarray(scene.times), (speed, time), rtol
        )
        errors[DENSITIES], allowed[DENSITIES] = densities.error_estimate, rtol
    resolution, values = fine.resolution, _outputs(fine.values, scene, speed, path)
    panels = fine.equation.panels
    solution = Solution(
        scene=scene,
        rtol=rtol,
        values=values,
        status=status_of(errors, allowed),
        message=explain(errors, allowed),
        error_estimate=max(errors.values()),
        plan=(
            PlanStep(
                "averages in a field",
                True,
                f"backward equation for {', '.join(scene.outputs)}: harmonics 0 to "
                f"{resolution.harmonics}, {panels.size} speeds up to {panels.highest:.3g} "
                f"sqrt(g l), {fine.steps} steps of time; the start {_followed(fine.start)}; "
                f"a solution with fewer of each differs so little that the error is {error:.1e}",
            ),
            _densities_step(densities),
        ),
        stats={
            "harmonics": resolution.harmonics,
            "panels": len(panels.counts),
            "nodes": panels.size,
            "steps": fine.steps,
        },
        _typical_speed=speed * np.sqrt(fine.values[:, ALL.index("v^2")]),
    )
    if densities is not None:
        solution.keep(_in_field=densities)
    return solution


def _densities_step(found: SceneDensities | None) -> PlanStep:
    """How the densities were solved."""
    if found is None:
        return PlanStep(DENSITIES, False, "not asked for")
    one = found.densities
    panels = one.equation.panels
    apart = "tracers that have not collided are in closed form"
    if one.is_sharp:
        apart = "tracers that have not collided are left out"
    if one.rays is not None:
        apart += ", those that have collided once in closed form"
    return PlanStep(
        DENSITIES,
        True,
        f"harmonics 0 to {one.equation.highest}, {panels.size} speeds up to {panels.highest:.3g} "
        f"sqrt(g l), {one.steps} steps of time, and an integral over the last free flight; "
        f"{apart}; from a solution with fewer of each the error is "
        f"{found.error_estimate:.1e} of the maximum",
    )


def _followed(start: Start) -> str:
    """How the start enters, and why."""
    if start.rays is not None:
        return (
            f"is {start.rays.along.size} velocities, each with an integral over its first "
            "collision, because it is slow or has few directions, on which harmonics converge "
            "slowly"
        )
    return f"has harmonics 0 to {len(start.measures) - 1}"


def _solved(scene: Scene, rtol: float, speed: float, times: FloatArray) -> tuple[Evolution, float]:
    """The averages, ever more finely resolved until two solutions agree; and their error."""
    resolution = TimeResolution.of(rtol)
    coarse = _evolution(scene, rtol, resolution, speed, times)
    best, least = coarse, math.inf
    for attempt in range(_ATTEMPTS):
        resolution = resolution.finer()
        if attempt >= _ALWAYS and resolution.harmonics > _MOST:
            break
        fine = _evolution(scene, rtol, resolution, speed, times)
        error = _difference(fine.values, coarse.values)
        if error >= least or not error < 1.0:
            break  # steps of many harmonics may be unstable: the solution before is better
        best, least = fine, error
        if error <= rtol or error > _FAR:
            break
        coarse = fine
    if best.values[:, ALL.index("v^2")].min() < 0.0:
        raise InputError(
            f"initial: speeds up to {best.start.highest:.1e} sqrt(field x mean free path) are lost "
            "in rounding to <v^2> below 0; give a slower start, or a stronger field"
        )
    return best, least


def _evolution(
    scene: Scene, rtol: float, resolution: TimeResolution, speed: float, times: FloatArray
) -> Evolution:
    # U in sqrt(g l) is 1/speed
    start = Start.of(scene.state, 0.1 * rtol, 1.0 / speed, resolution, scene.dimension)
    # rays of all directions cost more than one
    small = math.sqrt(rtol) if scene.state.highest_harmonic == 0 else rtol
    if start.highest < _AT_REST * small * min(1.0, float(times[0])):
        start = Start.rest()
    asked = [name for output in scene.outputs for name in _MADE_OF.get(output, ())]
    return Evolution(scene.law, start, times, resolution, needed_for(asked, start.is_symmetric))


def _difference(fine: FloatArray, coarse: FloatArray) -> float:
    """The largest difference of two solutions, each average relative to its scale."""
    scale = scales(fine)
    used = scale > 0.0
    found = float(np.max(np.abs(fine - coarse)[used] / scale[used], initial=0.0))
    return found if math.isfinite(found) else math.inf


def _outputs(values: FloatArray, scene: Scene, speed: float, path: float) -> dict[str, Any]:
    """The arrays of the outputs, in U and d."""
    d = scene.dimension
    of = {name: values[:, i] for i, name in enumerate(ALL)}
    velocity, displacement = _vector(of["v_x"], of["v_y"], d), _vector(of["x"], of["y"], d)
    second = of["v^2"]
    along = (second + (d - 1.0) * of["v^2 cos 2"]) / d
    squares = _tensor(of["x^2"], of["x y"], of["y^2"], d)
    with np.errstate(divide="ignore", invalid="ignore"):
        excess = d / (d + 2.0) * of["v^4"] / second**2 - 1.0
    found = {
        "thermal_speed": speed * np.sqrt(second),
        "temperature": speed**2 * second / d,
        "a2": excess,
        "collisions": of["collisions"],
        "msd": path**2 * (of["x^2"] + (d - 1.0) * of["y^2"]),
        "mean_displacement": path * displacement,
        "mean_velocity": speed * velocity,
        "velocity_tensor": speed**2
        * _tensor(along, of["v_x v_y"], (second - along) / (d - 1.0), d),
        "displacement_tensor": path**2
        * (squares - displacement[:, :, None] * displacement[:, None, :]),
    }
    return {name: found[name] for name in found if name in scene.outputs}


def _vector(x: FloatArray, y: FloatArray, dimension: int) -> FloatArray:
    """Shape (n_times, d); in space the state is symmetric about x."""
    if dimension == 2:
        return np.stack([x, y], axis=-1)
    return np.stack([x, 0.0 * x, 0.0 * x], axis=-1)


def _tensor(xx: FloatArray, xy: FloatArray, yy: FloatArray, dimension: int) -> FloatArray:
    """Shape (n_times, d, d); in space the state is symmetric about x."""
    out = np.zeros((xx.size, dimension, dimension))
    out[:, 0, 0] = xx
    for i in range(1, dimension):
        out[:, i, i] = yy
    if dimension == 2:
        out[:, 0, 1] = out[:, 1, 0] = xy
    return out
