"""The averages of a scene, with as many nodes as the accuracy asked for takes.

Between the questions (`kinetics.scene`, `kinetics.outputs`) and the backward equation
(`kinetics.moments`); the solver and the methods of a Solution start here.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.errors import InputError, warn_missed
from kinetics.moments.backward import speed_power
from kinetics.moments.formulas import moment_arguments
from kinetics.moments.velocity import Averages
from kinetics.numerics import FloatArray
from kinetics.outputs import OUTPUTS, Part, parts, powers_of
from kinetics.scene import Scene

ROUNDING = 1e-13  # relative: what sums over the initial state and up the panels may leave
SLACK = 1.0 + 1e-9  # on rtol: error estimates that meet it exactly are not missed by rounding
_TRIES, _MOST_NODES = 4, 48  # solutions with more nodes; still more only add rounding

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
    for _ in range(_TRIES):
        missing = error_of(averages, asked) / averages.rtol
        if not 1.0 < missing < math.inf:
            break
        nodes = averages.equation.nodes + 1 + math.ceil(math.log10(missing))
        averages = averages.with_nodes(min(nodes, _MOST_NODES))
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
