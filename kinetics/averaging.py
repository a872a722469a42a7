"""What the outputs of a scene are made of: its averages, and its densities.

Between the questions (`kinetics.scene`, `kinetics.outputs`) and the rooms that solve; the solver
and the methods of a Solution start here.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.densities.harmonic import HarmonicProblem, Profile
from kinetics.errors import InputError, warn_missed
from kinetics.moments.backward import speed_power
from kinetics.moments.displacement import root_mean_square
from kinetics.moments.velocity import Averages, moment_arguments
from kinetics.numerics import FloatArray
from kinetics.outputs import DENSITIES, OUTPUTS, POSITION, Part, parts, powers_of
from kinetics.position.density import Displacement
from kinetics.position.sweep import solve_displacement
from kinetics.scene import Scene
from kinetics.validation import refuse

ROUNDING = 1e-13  # relative: what sums over the initial state and up the panels may leave
SLACK = 1.0 + 1e-9  # on rtol: error estimates that meet it exactly are not missed by rounding
BEST_DENSITY = 1e-8  # of G(R): more takes wave numbers that cost minutes

Asked = Sequence[tuple[Part, ...]]


def averages_of(scene: Scene, rtol: float, degree: float = 2.0, lowest: float = 0.0) -> Averages:
    """The averages of a scene, for powers of the speed from ``lowest`` to ``degree``."""
    times = np.asarray(scene.times)
    return Averages(scene.law, scene.mean_free_path, scene.state, times, rtol, degree, lowest)


def asked_for(averages: Averages, outputs: Sequence[str]) -> Asked:
    """What must be solved for each output; a part that the initial state makes zero is left out."""
    made_of = [OUTPUTS[name].made_of(averages.law.dimension) for name in sorted(outputs)]
    return [
        tuple(part for part in parts if averages.measure(part.start) is not None)
        for parts in made_of
    ]


def with_enough_nodes(averages: Averages, asked: Asked) -> Averages:
    """The averages with as many nodes of a panel as the outputs need, by their error estimates."""
    for _ in range(4):
        missing = error_of(averages, asked) / averages.rtol
        if not 1.0 < missing < math.inf:
            break
        nodes = averages.equation.nodes + 1 + math.ceil(math.log10(missing))
        averages = averages.with_nodes(min(nodes, 48))  # still more only add rounding
    return averages


def solved_averages(scene: Scene, rtol: float) -> Averages:
    """The averages for the outputs of a scene, with enough nodes for them."""
    degree = max([2.0, *(p for p, _ in powers_of(scene.outputs, scene.dimension))])
    averages = averages_of(scene, rtol, degree)
    return with_enough_nodes(averages, asked_for(averages, scene.outputs))


def arrays_of(averages: Averages, outputs: tuple[str, ...]) -> dict[str, FloatArray]:
    """Every output that is an array, in the order of the table; InputError where one overflows."""
    values: dict[str, FloatArray] = {}
    for row in OUTPUTS.values():
        if row.name in outputs and row.values is not None:
            with np.errstate(over="ignore", invalid="ignore"):
                made = row.values(averages)
            arrays = made if isinstance(made, tuple) else (made,)
            for name, array in zip(row.names, arrays, strict=True):
                values[name] = in_range(name, array)
    return values


def error_of(averages: Averages, asked: Asked) -> float:
    """The largest relative error estimate of the outputs that are made of these parts."""
    solved = averages.error_estimate
    return max([ROUNDING, *(sum(f * solved(y) for f, y, _ in needed) for needed in asked)])


def in_range(name: str, value: NDArray[Any]) -> NDArray[Any]:
    """The value; InputError where it is beyond the largest number of double precision."""
    if not np.all(np.isfinite(value)):
        raise InputError(
            f"times: {name} overflows double precision there; ask for other times, speeds or powers"
        )
    return value


def power_of_speed(scene: Scene, rtol: float, p: Any, m: Any) -> NDArray[Any]:
    """<v^p exp(-i m phi)> in U^p, shape (n_times,), complex for m > 0.

    Raises InputError for p or m out of range, or where the moment does not exist; warns
    (ToleranceWarning) where the error estimate exceeds rtol.
    """
    p, m = moment_arguments(scene.law, scene.state, p, m)
    averages = replace(averages_of(scene, rtol, p, p), harmonic=max(m, 2))
    if averages.measure(m) is not None:
        asked = [parts((1.0, speed_power(p, m)))]
        averages = with_enough_nodes(averages, asked)
        error = error_of(averages, asked)
        if error > rtol * SLACK:
            warn_missed(f"<v^{p:g}>", error, rtol)
    with np.errstate(under="ignore", over="ignore", invalid="ignore"):
        found = averages.power(p, m) * np.exp(p * averages.log_reference)
    return in_range(f"<v^{p:g}>", found)


# -- densities -----------------------------------------------------------------------------------


def displacement_of(averages: Averages, outputs: tuple[str, ...]) -> Displacement | None:
    """The distribution of the displacement, if an output needs it."""
    if not any(OUTPUTS[name].step == POSITION for name in outputs):
        return None
    # distributions take returns to be at once, and G(R) has the scale of its own distribution
    own = replace(averages, delayed=False) if averages.has_delays else averages
    root = in_range("msd", root_mean_square(own))
    rtol = 0.4 * max(averages.rtol, BEST_DENSITY)  # the rest is for its transform
    path = averages.mean_free_path
    return solve_displacement(averages.law, path, averages.state, averages.times, root, rtol)


def profiles_of(
    scene: Scene, rtol: float, method: str | None, nodes: int | None
) -> dict[int, Profile]:
    """The harmonics of the velocity distribution that the outputs need."""
    if not any(OUTPUTS[name].step == DENSITIES for name in scene.outputs):
        return {}
    highest = 0
    if "velocity_density" in scene.outputs:
        there = scene.state.highest_harmonic
        highest = scene.harmonics if there is None else min(there, scene.harmonics)
    found = {m: _profile(scene, m, rtol, method, nodes) for m in range(highest + 1)}
    return {m: profile for m, profile in found.items() if profile is not None}


def _profile(
    scene: Scene, m: int, rtol: float, method: str | None, nodes: int | None
) -> Profile | None:
    """Harmonic m by the method asked for, or the best one; None where the start makes it zero."""
    law, state = scene.law, scene.state
    path, times = scene.mean_free_path, np.asarray(scene.times)
    asked = HarmonicProblem(law, path, state, m, times, rtol, nodes)
    if state.harmonic(m, rtol) is None:
        return None
    if law.is_elastic:
        from kinetics.densities.harmonic import elastic_profile

        return elastic_profile(asked)
    if method != "conservative" and (state.smooth or method == "spectral"):
        from kinetics.densities.spectral import solve_spectral

        profile = solve_spectral(asked)
        if profile is not None:
            return profile
        if method == "spectral":
            refuse("method", method, "this initial state is too rough for it, use 'conservative'")
    from kinetics.densities.conservative import solve_conservative

    return solve_conservative(asked)
