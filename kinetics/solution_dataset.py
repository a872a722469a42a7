"""A solution as a dataset of xarray: averages over time, and functions at points."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from kinetics.numerics import FloatArray
from kinetics.outputs import AXES, OUTPUTS, Axis, described
from kinetics.results.frame import COMPONENTS, Variable, dataset, variable
from kinetics.scene import Scene
from kinetics.validation import finite_line

if TYPE_CHECKING:
    import xarray

#: By default speeds go from this fraction of the least typical speed ...
LOWEST_SPEED = 1e-2
#: ... to so many times the largest.
HIGHEST_SPEED = 5.0
#: By default radii go to so many times the largest sqrt(<r^2>).
LARGEST_RADIUS = 5.0
#: By default wave numbers times the largest sqrt(<r^2>) are between these.
WAVE_NUMBER_RANGE = (1e-2, 10.0)
#: Least sqrt(<r^2>) in d that sets the scale of radii: at time 0 it is zero.
MIN_DISTANCE = 1e-12
#: So many points each.
N_SPEEDS = 200
N_ANGLES = 73
N_RADII = 121
N_SCALED_RADII = 101
N_WAVE_NUMBERS = 61
#: What a share beside a speed density is, in words.
UNCOLLIDED = "share of tracers of a start of one speed that have not collided (or e = 1)"


class Solved(Protocol):
    """What a dataset needs of a solution; functions of `OUTPUTS` are its methods, too."""

    @property
    def scene(self) -> Scene:
        """The question."""

    @property
    def values(self) -> Mapping[str, FloatArray]:
        """The averages over time, by name."""

    @property
    def times(self) -> FloatArray:
        """Output times in d/U, shape (n_times,)."""

    @property
    def typical_speed(self) -> FloatArray:
        """A speed of the order of the thermal one in U, shape (n_times,)."""

    @property
    def root_mean_square_displacement(self) -> FloatArray:
        """sqrt(<r^2>) in d, shape (n_times,)."""

    @property
    def uncollided(self) -> FloatArray:
        """The share of tracers that a speed density leaves out, shape (n_times,)."""


def solution_dataset(
    solution: Solved,
    functions: Sequence[str],
    only: Collection[str] | None,
    points: Mapping[str, Any],
) -> xarray.Dataset:
    """Return the averages of a solution, and its functions at points.

    Parameters
    ----------
    solution : of which the dataset is
    functions : outputs that are functions of more than the time
    only : the functions that are wanted; None for all
    points : where functions are evaluated, by the names of `outputs.AXES`, and the direction of k;
        by default where the distributions are
    """
    scene = solution.scene
    variables = {}
    for name, array in solution.values.items():
        dimensions = ("time", *COMPONENTS[: array.ndim - 1])
        variables[name] = variable(dimensions, array, *described(name, scene.dimension))
    axes = {"time": variable(("time",), solution.times, "d/U", "time since the start", "t")}
    for component in COMPONENTS:
        letters = list("xyz"[: scene.dimension])
        axes[component] = variable((component,), letters, "1", "component")
    for name, shape in _function_shapes(functions).items():
        is_beside = name == "speed_density" and only is not None and "uncollided" in only
        if only is None or name in only or is_beside:
            function = _FunctionAtPoints(solution, name, shape, points)
            axes |= function.axes()
            variables |= function.variables()
    title = f"Solution of the inelastic Lorentz equation: {scene}"
    return dataset(solution, title, scene, variables, axes)


def _function_shapes(functions: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """Return the axes, beside time, of functions, by name; with g comes G."""
    shapes = {name: OUTPUTS[name].shape[1:] for name in functions}
    if "position_density" in shapes:
        shapes["scaled_position_density"] = ("n_R",)
    return shapes


class _FunctionAtPoints:
    """One function of a solution at points of its axes."""

    def __init__(
        self, solution: Solved, name: str, shape: tuple[str, ...], points: Mapping[str, Any]
    ) -> None:
        self.solution = solution
        self.name = name
        self.points: dict[Axis, FloatArray] = {}
        for key in shape:
            axis = AXES[key]
            if points.get(axis.points) is None:
                self.points[axis] = _default_points(axis, solution)
            else:
                self.points[axis] = finite_line(axis.points, points[axis.points])
        self.arguments: list[Any] = list(self.points.values())
        if name == "intermediate_scattering" and "direction" in points:
            self.arguments.append(points["direction"])

    def axes(self) -> dict[str, Variable]:
        """Return the coordinates, by name."""
        return {
            axis.name: variable((axis.name,), x, axis.unit, axis.description)
            for axis, x in self.points.items()
        }

    def variables(self) -> dict[str, Variable]:
        """Return the values, by name; beside a speed density the share that it leaves out."""
        evaluate = getattr(self.solution, self.name)
        values = evaluate(*self.arguments)
        unit, words, symbol = described(self.name, self.solution.scene.dimension)
        dimensions = ("time", *(axis.name for axis in self.points))
        made = {}
        if np.iscomplexobj(values):
            real, imaginary = f"{self.name}_real", f"{self.name}_imag"
            made[real] = variable(dimensions, values.real, unit, words, f"Re {symbol}")
            made[imaginary] = variable(dimensions, values.imag, unit, words, f"Im {symbol}")
        else:
            made[self.name] = variable(dimensions, values, unit, words, symbol)
        if self.name == "speed_density":
            made["uncollided"] = variable(("time",), self.solution.uncollided, "1", UNCOLLIDED)
        return made


def _default_points(axis: Axis, solution: Solved) -> FloatArray:
    """Return points of an axis where the distributions are."""
    if axis.points == "speeds":
        typical = solution.typical_speed
        moving = typical[typical > 0.0] if typical.any() else np.ones(1)
        lowest = LOWEST_SPEED * moving.min()
        return np.geomspace(lowest, HIGHEST_SPEED * moving.max(), N_SPEEDS)
    if axis.points == "angles":
        full_range = 2.0 * np.pi / (solution.scene.dimension - 1.0)
        return np.linspace(0.0, full_range, N_ANGLES)
    if axis.points == "scaled_radii":
        return np.linspace(0.0, LARGEST_RADIUS, N_SCALED_RADII)
    distance = max(float(solution.root_mean_square_displacement.max()), MIN_DISTANCE)
    if axis.points == "radii":
        return np.linspace(0.0, LARGEST_RADIUS * distance, N_RADII)
    lowest, highest = WAVE_NUMBER_RANGE
    return np.geomspace(lowest, highest, N_WAVE_NUMBERS) / distance
