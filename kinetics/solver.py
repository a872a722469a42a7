"""solve(scene): picks the parts that the scene needs, and no other."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.densities.harmonic import Profile
from kinetics.errors import InputError, check_rtol, short, warn_missed
from kinetics.moments import displacement as position
from kinetics.moments.backward import MEAN_COLLISIONS, Observable, speed_power
from kinetics.moments.velocity import Averages
from kinetics.position.density import Displacement
from kinetics.position.intermediate_scattering import scattering_function
from kinetics.position.solve_density import solve_displacement
from kinetics.scaling.scaled_vdf import SolverStatus
from kinetics.scene import Scene
from kinetics.solution import PlanStep, Solution

FloatArray = NDArray[np.float64]

METHODS = ("spectral", "conservative")
_FEWEST_NODES, _MOST_NODES = 8, 8192
_BEST_DENSITY = 1e-8  # of G(R): more takes wave numbers that cost minutes
_ROUNDING = 1e-13  # what sums over the initial state and up the panels may leave
_LOWEST_AT_ZERO = -0.25  # bounces to s < e^-40, of weight s^(1 + p), are left out
Parts = tuple[tuple[float, Observable], ...]
# what each average is made of, and how often the relative error of that enters its own
_OF_VELOCITY: dict[str, Parts] = {
    "thermal_speed": ((0.5, speed_power(2.0)),),
    "temperature": ((1.0, speed_power(2.0)),),
    "a2": ((2.0, speed_power(2.0)), (1.0, speed_power(4.0))),
    "mean_velocity": ((1.0, speed_power(1.0, 1)),),
    "velocity_tensor": ((1.0, speed_power(2.0)), (1.0, speed_power(2.0, 2))),
}
_PARTS: dict[str, Parts] = {
    **_OF_VELOCITY,
    "collisions": ((1.0, MEAN_COLLISIONS),),
    **position.OBSERVABLES,
}
_DENSITIES = {"speed_density", "velocity_density"}


def solve(
    scene: Scene, rtol: float = 1e-10, method: str | None = None, nodes: int | None = None
) -> Solution:
    """Solve the inelastic Lorentz equation for what the scene asks.

    Parameters
    ----------
    scene : system, initial state, times and outputs
    rtol : relative accuracy of every average (of 1 + a2 for a2; of <v^p> for its harmonics), and of
        the densities relative to their maximum, for speeds above 1e-2 of the thermal one; below it
        is the density of ln v that keeps it. 1e-14 to 0.1. The scaled position density G(R) is
        solved to max(rtol, 1e-8), absolute
    method : how densities are made: "spectral" (for smooth states), "conservative" (mass and
        positivity exact, second order, for rough ones), or None for the solver's choice. Averages
        need no density, and are the same for either.
    nodes : of the speed axis of the densities, 8 to 8192, for convergence studies

    Returns
    -------
    Solution : frozen; arrays with time as the first axis, under the names of the outputs

    Raises
    ------
    InputError (a ValueError) : an argument out of range, a density that is negative, not
        normalised or without second moment, or a method that cannot do the scene

    >>> from kinetics import Scene
    >>> solution = solve(Scene(restitution=0.7, times=[0.0, 1e3, 1e6]))
    >>> bool(abs(solution.thermal_speed[0] - 2**0.5) < 1e-10)
    True
    """
    rtol = check_rtol(rtol)
    if not isinstance(scene, Scene):
        raise InputError(f"scene: got {short(scene)}; it must be a Scene")
    if method is not None and method not in METHODS:
        raise InputError(f"method: got {short(method)}; it must be one of {', '.join(METHODS)}")
    nodes = _check_nodes(nodes)
    law = CollisionLaw(scene.restitution)
    wanted = set(scene.outputs)
    pairs = sorted(
        {(y.degree, y.harmonic) for name in wanted for _, y in _OF_VELOCITY.get(name, ())}
    )
    degree = max([2.0, *(p for p, _ in pairs)])
    averages = _averages(scene, law, rtol, degree)
    parts = _parts(averages, wanted)
    averages = _accurate(averages, parts)
    powers = {pair: averages.power(*pair) for pair in pairs}
    with np.errstate(over="ignore", invalid="ignore"):
        values = _means(averages, wanted, powers)
    for name, value in values.items():
        _in_range(name, value)
    profiles = _profiles(scene, law, rtol, method, nodes)
    displacement = _displacement(averages, wanted)
    error = max([_error(averages, parts), *(p.error_estimate for p in profiles.values())])
    good = error <= rtol * (1.0 + 1e-9)
    if displacement is not None:
        good &= displacement.error_estimate <= max(rtol, _BEST_DENSITY)
        error = max(error, displacement.error_estimate)

    def harmonic(p: float, m: int) -> NDArray[Any]:
        """<v^p exp(-i m phi)>, solved when it is asked for."""
        return _any_power(scene, law, p, m, rtol)

    def scattering(wave_numbers: FloatArray, direction: float | None) -> NDArray[Any]:
        """F(k, t), solved when it is asked for."""
        return scattering_function(averages, wave_numbers, direction)

    return Solution(
        scene=scene,
        rtol=rtol,
        values=values,
        status=SolverStatus.CONVERGED if good else SolverStatus.TOLERANCE_NOT_REACHED,
        error_estimate=error,
        plan=_plan(averages, wanted, pairs, profiles, displacement),
        stats=_stats(averages, profiles, displacement),
        _profiles=profiles,
        _harmonic=harmonic,
        _displacement=displacement,
        _scattering=scattering if "intermediate_scattering" in wanted else None,
        _typical=np.exp(averages.log_reference),
    )


def _displacement(averages: Averages, wanted: set[str]) -> Displacement | None:
    """The distribution of the displacement, if it is asked for."""
    if "position_density" not in wanted:
        return None
    root = position.root_mean_square(averages)
    path, rtol = averages.mean_free_path, max(averages.rtol, _BEST_DENSITY)
    return solve_displacement(
        averages.law, path, averages.state, averages.times, _in_range("msd", root), 0.4 * rtol
    )


def _check_nodes(nodes: Any) -> int | None:
    if nodes is None:
        return None
    whole = isinstance(nodes, int | np.integer) and not isinstance(nodes, bool)
    if not whole or not _FEWEST_NODES <= nodes <= _MOST_NODES:
        raise InputError(
            f"nodes: got {short(nodes)}; it must be a whole number "
            f"from {_FEWEST_NODES} to {_MOST_NODES}"
        )
    return int(nodes)


def _averages(
    scene: Scene, law: CollisionLaw, rtol: float, degree: float, lowest: float = 0.0
) -> Averages:
    times = np.asarray(scene.times)
    return Averages(law, scene.mean_free_path, scene.state, times, rtol, degree, lowest)


def _parts(averages: Averages, wanted: set[str]) -> list[Parts]:
    """What must be solved for each average that is asked for; not where the start makes it 0."""
    return [
        tuple(
            (factor, y)
            for factor, y in _PARTS[name]
            if name == "velocity_autocorrelation" or averages.measure(y.harmonic) is not None
        )
        for name in sorted(wanted & set(_PARTS))
    ]


def _accurate(averages: Averages, parts: Sequence[Parts]) -> Averages:
    """The averages with as many nodes as the outputs need, by their estimates."""
    if averages.elastic:
        return averages
    rtol = averages.rtol
    guesses = [averages.nodes_for(y, rtol / factor) for part in parts for factor, y in part]
    if not guesses:
        return averages
    nodes = max(guesses)
    for more in range(4):
        averages = averages.with_nodes(nodes + more)
        if _error(averages, parts) <= averages.rtol:
            break
    return averages


def _error(averages: Averages, parts: Sequence[Parts]) -> float:
    """The largest relative error of the outputs that are made of these parts."""
    if averages.elastic:
        return 1e-15
    solved = averages.equation.error_estimate
    return max([_ROUNDING, *(sum(factor * solved(y) for factor, y in part) for part in parts)])


def _means(
    averages: Averages, wanted: set[str], powers: dict[tuple[float, int], NDArray[Any]]
) -> dict[str, FloatArray]:
    """Every output that is an average."""
    values: dict[str, FloatArray] = {}
    reference = np.exp(averages.log_reference)
    if "thermal_speed" in wanted:
        values["thermal_speed"] = reference * np.sqrt(powers[2.0, 0])
    if "temperature" in wanted:
        values["temperature"] = 0.5 * reference**2 * powers[2.0, 0]
    if "a2" in wanted:
        values["a2"] = 0.5 * powers[4.0, 0] / powers[2.0, 0] ** 2 - 1.0
    if "mean_velocity" in wanted:
        along = reference * powers[1.0, 1]
        values["mean_velocity"] = np.stack([along.real, -along.imag], axis=-1)
    if "velocity_tensor" in wanted:
        trace, second = reference**2 * powers[2.0, 0], reference**2 * powers[2.0, 2]
        xx, yy = 0.5 * (trace + second.real), 0.5 * (trace - second.real)
        xy = -0.5 * second.imag
        values["velocity_tensor"] = np.stack([xx, xy, xy, yy], axis=-1).reshape(-1, 2, 2)
    if "collisions" in wanted:
        values["collisions"] = _collisions(averages)
    if "msd" in wanted:
        values["msd"] = position.mean_square_displacement(averages)
    if "kurtosis" in wanted:
        values["kurtosis"] = position.kurtosis(averages)
    if "velocity_autocorrelation" in wanted:
        values["velocity_autocorrelation"] = position.velocity_autocorrelation(averages)
    if "diffusion_coefficient" in wanted:
        found = position.diffusion_coefficient(averages)
        values["diffusion_coefficient"], values["msd_slope"] = found
    if "mean_displacement" in wanted:
        values["mean_displacement"] = position.mean_displacement(averages)
    return values


def _in_range(name: str, value: NDArray[Any]) -> NDArray[Any]:
    """The value; InputError where it is beyond the largest number."""
    if not np.all(np.isfinite(value)):
        raise InputError(
            f"times: {name} overflows double precision there; ask for other times, speeds or powers"
        )
    return value


def _collisions(averages: Averages) -> FloatArray:
    if averages.elastic:
        speed = np.exp(averages.log_reference) * averages.power(1.0)
        # speed times time, or over length, may leave the range of doubles when all three do not
        root = np.sqrt(averages.times) / math.sqrt(averages.mean_free_path)
        with np.errstate(over="ignore", under="ignore"):
            return np.asarray(speed * root * root)
    return averages.average(MEAN_COLLISIONS)


def _profiles(
    scene: Scene, law: CollisionLaw, rtol: float, method: str | None, nodes: int | None
) -> dict[int, Profile]:
    """The harmonics of the velocity distribution that the outputs need."""
    if not _DENSITIES & set(scene.outputs):
        return {}
    highest = 0
    if "velocity_density" in scene.outputs:
        there = scene.state.highest_harmonic
        highest = scene.harmonics if there is None else min(there, scene.harmonics)
    found = {m: _profile(scene, law, m, rtol, method, nodes) for m in range(highest + 1)}
    return {m: profile for m, profile in found.items() if profile is not None}


def _profile(
    scene: Scene, law: CollisionLaw, m: int, rtol: float, method: str | None, nodes: int | None
) -> Profile | None:
    state, times, path = scene.state, np.asarray(scene.times), scene.mean_free_path
    if state.harmonic(m, rtol) is None:
        return None
    if law.restitution == 1.0:
        from kinetics.densities.elastic import elastic_profile

        return elastic_profile(law, path, state, m, times)
    if method != "conservative" and (state.smooth or method == "spectral"):
        from kinetics.densities.spectral import solve_spectral

        profile = solve_spectral(law, path, state, m, times, rtol, nodes)
        if profile is not None:
            return profile
        if method == "spectral":
            raise InputError(
                "method: got 'spectral'; this initial state is too rough for it, "
                "use method='conservative'"
            )
    from kinetics.densities.conservative import solve_conservative

    return solve_conservative(law, path, state, m, times, rtol, nodes)


def _any_power(scene: Scene, law: CollisionLaw, p: float, m: int, rtol: float) -> NDArray[Any]:
    try:
        p = float(p)
    except (TypeError, ValueError):
        p = math.nan
    if not abs(p) <= 40.0:
        raise InputError(f"p: got {short(p)}; it must be a real number of size up to 40")
    if isinstance(m, bool) or not isinstance(m, int | np.integer) or not 0 <= m <= 256:
        raise InputError(f"m: got {short(m)}; it must be a whole number from 0 to 256")
    lowest = max(scene.state.lowest_moment, -1.0 if law.restitution == 0.0 else -math.inf)
    if p <= lowest:
        raise InputError(f"p: got {p!r}; moments of this scene exist for p > {lowest:g} only")
    if law.restitution == 0.0 and p < _LOWEST_AT_ZERO:
        raise InputError(f"p: got {p!r}; at restitution 0 they are solved for p >= -0.25")
    averages = _averages(scene, law, rtol, p, p)
    if averages.measure(int(m)) is not None:
        parts: list[Parts] = [((1.0, speed_power(p, int(m))),)]
        averages = _accurate(averages, parts)
        error = _error(averages, parts)
        if error > rtol * (1.0 + 1e-9):
            warn_missed(f"<v^{p:g}>", error, rtol)
    with np.errstate(under="ignore", over="ignore", invalid="ignore"):
        found = averages.power(p, int(m)) * np.exp(p * averages.log_reference)
    return _in_range(f"<v^{p:g}>", found)


def _plan(
    averages: Averages,
    wanted: set[str],
    pairs: list[tuple[float, int]],
    profiles: dict[int, Profile],
    displacement: Displacement | None,
) -> tuple[PlanStep, ...]:
    """What was solved, what was skipped, and why."""
    cools = not averages.elastic
    moments = ", ".join(f"v^{p:g}" + (f" (m = {m})" if m else "") for p, m in pairs)
    if not pairs:
        why = "no output needs them"
    elif cools:
        why = f"backward equation for {moments}"
    else:
        why = "elastic: speeds are kept, harmonics relax at their own rates"
    count = averages.speeds.x.size
    solved = sorted({m for _, m in pairs} | set(profiles))
    most = averages.state.highest_harmonic
    others = "the start is isotropic" if most == 0 else "no output needs more"
    kinds = sorted({p.method for p in profiles.values()})
    waves = "not asked for" if displacement is None else f"{displacement.wave_numbers} wave numbers"
    return (
        PlanStep("moments of the velocity", bool(pairs) and cools, why),
        PlanStep("initial state", True, f"{count} weighted speeds stand for it"),
        PlanStep("collision number", "collisions" in wanted, _asked("collisions", wanted)),
        PlanStep("displacement", *_displacement_plan(averages, wanted)),
        PlanStep("position density", displacement is not None, waves),
        PlanStep("angular harmonics", bool(solved), f"m = {solved or 'none'}: {others}"),
        PlanStep(
            "densities",
            bool(profiles),
            f"{len(profiles)} harmonics, {', '.join(kinds)}" if profiles else "not asked for",
        ),
    )


def _displacement_plan(averages: Averages, wanted: set[str]) -> tuple[bool, str]:
    names = [name for name in position.OBSERVABLES if name in wanted]
    if not names:
        return False, "not asked for"
    count = len({y for name in names for _, y in position.OBSERVABLES[name]})
    how = "closed forms" if averages.elastic else f"{count} scalar equations and what drives them"
    return True, f"{', '.join(names)}: {how}"


def _asked(name: str, wanted: set[str]) -> str:
    return "asked for" if name in wanted else "not asked for"


def _stats(
    averages: Averages, profiles: dict[int, Profile], displacement: Displacement | None
) -> dict[str, Any]:
    stats: dict[str, Any] = {"initial_points": int(averages.speeds.x.size)}
    if not averages.elastic:
        stats["panels"] = averages.equation.count
        stats["nodes_per_panel"] = averages.equation.nodes
    for m, profile in profiles.items():
        stats[f"density_nodes_m{m}"] = profile.nodes
    if displacement is not None:
        stats["wave_numbers"] = displacement.wave_numbers
        stats["position_density_error"] = displacement.error_estimate
        # how many systems of so many equations were solved for F(k)
        stats["systems"] = {str(size): count for size, count in displacement.systems.items()}
    return stats
