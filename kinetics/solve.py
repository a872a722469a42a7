"""solve(scene): picks the parts that the scene needs, and no other."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.backward import MEAN_COLLISIONS, SQUARED_DISPLACEMENT, speed_power
from kinetics.collision import CollisionLaw
from kinetics.errors import InputError, check_rtol, short
from kinetics.evolve import Averages
from kinetics.initial import measure
from kinetics.position import mean_square_displacement
from kinetics.scaled import SolverStatus
from kinetics.scene import Scene
from kinetics.solution import PlanStep, Solution

FloatArray = NDArray[np.float64]

_POWERS = {"thermal_speed": (2.0,), "temperature": (2.0,), "a2": (2.0, 4.0)}


def solve(scene: Scene, rtol: float = 1e-10) -> Solution:
    """Solve the inelastic Lorentz equation for what the scene asks.

    Parameters
    ----------
    scene : system, initial state, times and outputs
    rtol : relative accuracy of every output (of 1 + a2 for a2), 1e-14 to 0.1

    Returns
    -------
    Solution : frozen; arrays of shape (n_times,) under the names of the outputs

    Raises
    ------
    InputError (a ValueError) : rtol out of range, or outputs that the scene cannot have

    >>> from kinetics import Scene
    >>> solution = solve(Scene(restitution=0.7, times=[0.0, 1e3, 1e6]))
    >>> solution.thermal_speed.round(9)
    array([1.414213562e+00, 5.8061e-02, 6.0700e-05])
    """
    rtol = check_rtol(rtol)
    if not isinstance(scene, Scene):
        raise InputError(f"scene: got {short(scene)}; it must be a Scene")
    law = CollisionLaw(scene.restitution)
    times = np.asarray(scene.times)
    wanted = set(scene.outputs)
    if "speed_density" in wanted and scene.initial != "gaussian":
        raise InputError(
            "outputs: 'speed_density' is there for the gaussian start only; "
            "ask for the other outputs, or for initial='gaussian'"
        )
    powers = sorted({p for name in wanted for p in _POWERS.get(name, ())})
    state = measure(scene.initial, rtol)
    averages = Averages(law, scene.mean_free_path, state, times, rtol, max([2.0, *powers]))
    values: dict[str, FloatArray] = {}
    moments = {p: _power(averages, p) for p in powers}
    reference = np.exp(averages.log_reference)
    if "thermal_speed" in wanted:
        values["thermal_speed"] = reference * np.sqrt(moments[2.0])
    if "temperature" in wanted:
        values["temperature"] = 0.5 * reference**2 * moments[2.0]
    if "a2" in wanted:
        values["a2"] = 0.5 * moments[4.0] / moments[2.0] ** 2 - 1.0
    if "collisions" in wanted:
        values["collisions"] = _collisions(averages)
    if "msd" in wanted:
        values["msd"] = mean_square_displacement(averages)
    density = _density(scene, law, rtol) if "speed_density" in wanted else None

    error = _error(averages, wanted, powers)
    status = SolverStatus.CONVERGED if error <= rtol else SolverStatus.TOLERANCE_NOT_REACHED
    ordered = {name: values[name] for name in scene.outputs if name in values}

    def moment(p: float) -> FloatArray:
        """<v^p>(t), solved when it is asked for."""
        return _any_moment(scene, law, p, rtol)

    return Solution(
        scene=scene,
        rtol=rtol,
        values=ordered,
        status=status,
        error_estimate=error,
        plan=_plan(scene, averages, wanted, powers),
        stats=_stats(averages),
        _density=density,
        _moment=moment,
    )


def _power(averages: Averages, p: float) -> FloatArray:
    """<(v/v_ref)^p>, shape (n_times,)."""
    return averages.initial_power(p) if averages.elastic else averages.power(p)


def _collisions(averages: Averages) -> FloatArray:
    if averages.elastic:
        speed = np.exp(averages.log_reference) * averages.initial_power(1.0)
        return speed * averages.times / averages.mean_free_path
    return averages.average(MEAN_COLLISIONS)


def _density(scene: Scene, law: CollisionLaw, rtol: float) -> Any:
    times = np.asarray(scene.times)
    if law.restitution == 1.0:

        def kept(v: FloatArray) -> FloatArray:
            with np.errstate(under="ignore"):
                return np.tile(v * np.exp(-0.5 * v * v), (times.size, 1))

        return kept
    from kinetics.forward import solve_gaussian_density

    return solve_gaussian_density(law, scene.mean_free_path, times, rtol)


def _any_moment(scene: Scene, law: CollisionLaw, p: float, rtol: float) -> FloatArray:
    try:
        p = float(p)
    except (TypeError, ValueError):
        p = math.nan
    if not abs(p) <= 40.0:
        raise InputError(f"p: got {short(p)}; it must be a real number of size up to 40")
    if scene.initial == "gaussian" and p <= -2.0:
        raise InputError(f"p: got {p!r}; moments of the gaussian start exist for p > -2 only")
    if law.restitution == 0.0 and p <= -1.0:
        raise InputError(f"p: got {p!r}; at restitution 0 moments exist for p > -1 only")
    state = measure(scene.initial, rtol, p)
    averages = Averages(law, scene.mean_free_path, state, np.asarray(scene.times), rtol, p)
    with np.errstate(under="ignore"):
        return _power(averages, p) * np.exp(p * averages.log_reference)


def _error(averages: Averages, wanted: set[str], powers: list[float]) -> float:
    if averages.elastic:
        return 1e-15
    asked = [speed_power(p) for p in powers]
    asked += [MEAN_COLLISIONS] if "collisions" in wanted else []
    asked += [SQUARED_DISPLACEMENT] if "msd" in wanted else []
    return max([1e-15, *(averages.equation.error_estimate(y) for y in asked)])


def _plan(
    scene: Scene, averages: Averages, wanted: set[str], powers: list[float]
) -> tuple[PlanStep, ...]:
    """What was solved, what was skipped, and why."""
    cools = not averages.elastic
    names = ", ".join(f"v^{p:g}" for p in powers)
    start = "one speed" if averages.state.x.size == 1 else f"{averages.state.x.size} speeds"
    return (
        PlanStep(
            "speed moments",
            bool(powers) and cools,
            f"backward equation for {names}"
            if powers and cools
            else "elastic: speeds are kept"
            if powers
            else "no output needs them",
        ),
        PlanStep("average over the start", True, f"{start} represent the initial state"),
        PlanStep(
            "collision number",
            "collisions" in wanted and cools,
            "asked for" if "collisions" in wanted else "not asked for",
        ),
        PlanStep(
            "displacement",
            "msd" in wanted and cools,
            "two scalar equations, harmonics 1 and 0" if "msd" in wanted else "not asked for",
        ),
        PlanStep("other harmonics", False, "the start is isotropic"),
        PlanStep(
            "speed density",
            "speed_density" in wanted and cools,
            "forward equation" if "speed_density" in wanted else "not asked for: no profile built",
        ),
    )


def _stats(averages: Averages) -> dict[str, Any]:
    stats: dict[str, Any] = {"initial_points": int(averages.state.x.size)}
    if not averages.elastic:
        stats["panels"] = averages.equation.count
        stats["nodes_per_panel"] = averages.equation.nodes
    return stats
