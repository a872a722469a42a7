"""A solution as a dataset of xarray: averages at each time, and functions evaluated at points.

d is the contact distance of tracer and scatterer, U the unit of speed, r the displacement since the
start and <r^2> its mean square. Functions are those rows of `kinetics.outputs.OUTPUTS` that depend
on more than the time, such as the density of the speed; a solution has a method for each, of the
same name, which takes points of its axes (`kinetics.outputs.AXES`). Where a user specifies no
points, they are chosen where the distributions are. Begin with `solution_dataset`.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from kinetics.collision.measured_errors import SIZES
from kinetics.model_error import absolute_errors
from kinetics.numerics import FloatArray
from kinetics.outputs import AXES, OUTPUTS, Axis, described
from kinetics.results.frame import COMPONENTS, MODEL_ERROR, Variable, dataset, variable
from kinetics.scene import Scene
from kinetics.validation import finite_line

if TYPE_CHECKING:
    import xarray

# Points at which functions are evaluated by default. They are for tables and plots: half or twice
# of each of these numbers changes where a function is shown, and no other number. Why they were
# chosen so is not recorded; what follows from them is said.

#: The lowest speed, over the least typical speed above 0 of all times.
LOWEST_SPEED_OVER_TYPICAL = 1e-2
#: The highest speed, over the largest typical speed of all times: a Gaussian in the plane is 1e-11
#: of its largest there.
HIGHEST_SPEED_OVER_TYPICAL = 5.0
#: The largest radius, over the largest sqrt(<r^2>) of all times; and the largest scaled radius, as
#: that is r/sqrt(<r^2>). A Gaussian in the plane is 1e-11 of its largest there.
LARGEST_RADIUS_OVER_RMS = 5.0
#: The least radius of a figure, over the least sqrt(<r^2>) above 0 of all times: a Gaussian in the
#: plane is 1e-2 of its largest there.
LEAST_RADIUS_OVER_RMS = 1e-2
#: The least wave number times the largest sqrt(<r^2>) of all times: the intermediate scattering is
#: 1 there, to 5e-5.
LOWEST_WAVE_NUMBER_TIMES_RMS = 1e-2
#: The largest such product: a Gaussian in the plane is 1e-11 there.
HIGHEST_WAVE_NUMBER_TIMES_RMS = 10.0
#: Least sqrt(<r^2>) in d that sets the scale of radii and wave numbers, as it is 0 at time 0. Any
#: length far below d will do.
MIN_DISTANCE = 1e-12
#: Number of speeds, evenly spread in the logarithm.
N_SPEEDS = 200
#: Number of angles, with both ends: steps of 5 degrees over the circle in the plane, of 2.5 degrees
#: over half of it in space.
N_ANGLES = 73
#: Number of radii, from 0: steps of sqrt(<r^2>)/24.
N_RADII = 121
#: Number of scaled radii, from 0: steps of 0.05.
N_SCALED_RADII = 101
#: Number of wave numbers, evenly spread in the logarithm: 20 a decade.
N_WAVE_NUMBERS = 61
#: What "uncollided", beside a density of the speed, means: the description of that variable.
UNCOLLIDED = "share of tracers of a start of one speed that have not collided (or e = 1)"


class Solved(Protocol):
    """What a dataset needs of a solution.

    Beside these members it has a method for each function of `OUTPUTS`, of the same name: it takes
    arrays of points, one for each axis, and returns values of the shape (n_times, points of the
    first axis, ...).
    """

    @property
    def scene(self) -> Scene:
        """The scene that was solved: the arguments of the question."""

    @property
    def values(self) -> Mapping[str, FloatArray]:
        """Averages over the tracers at each time, by name; the time is the first axis."""

    @property
    def times(self) -> FloatArray:
        """Output times in d/U, shape (n_times,)."""

    @property
    def model_error(self) -> Mapping[str, FloatArray]:
        """The relative error of the equation itself, of averages and functions, (n_times,)."""

    def moment(self, p: float) -> FloatArray:
        """<v^p>(t) in U^p, shape (n_times,)."""

    @property
    def typical_speed(self) -> FloatArray:
        """A speed in U of the order of sqrt(<v^2>), which sets the scale of speeds, (n_times,)."""

    @property
    def root_mean_square_displacement(self) -> FloatArray:
        """sqrt(<r^2>) in d, shape (n_times,)."""

    @property
    def uncollided(self) -> FloatArray:
        """The share of tracers in delta peaks, which the density of the speed leaves out.

        Shape (n_times,); 0 for starts that are not of sharp speeds.
        """


def solution_dataset(
    solution: Solved,
    functions: Sequence[str],
    only: Collection[str] | None,
    points: Mapping[str, Any],
) -> xarray.Dataset:
    """Return the averages of a solution, and its functions at points.

    Averages are always there. "uncollided" comes with the density of the speed: who requests one
    of them gets both.

    Parameters
    ----------
    solution : the solution
    functions : names of the outputs of the solution that are functions of more than the time
    only : names of the functions that are requested; None for all
    points : where functions are evaluated, by `Axis.points`: "speeds" in U, "angles" in radians,
        "radii" in d, "scaled_radii", "wave_numbers" in 1/d; and "direction", the angle of the wave
        vector to the x axis in radians, which the solution checks. Points that are None or not
        there are chosen by `_default_points`
    """
    scene = solution.scene
    variables = {}
    for name, array in solution.values.items():
        dimensions = ("time", *COMPONENTS[: array.ndim - 1])
        variables[name] = variable(dimensions, array, *described(name, scene.dimension))
    if scene.scatterers != "dilute":
        variables |= _error_variables(solution)
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
            if scene.scatterers != "dilute" and name in solution.model_error:
                error = solution.model_error[name]
                words = f"largest error of the equation itself in {name}: of {SIZES[name]}"
                variables[name + MODEL_ERROR] = variable(("time",), error, "1", words)
    scene_in_a_line = " ".join(repr(scene).split())
    title = f"Solution of the inelastic Lorentz equation: {scene_in_a_line}"
    return dataset(solution, title, scene, variables, axes)


def _error_variables(solution: Solved) -> dict[str, Variable]:
    """Return the error of the equation itself of each average, in its unit, by name."""
    variables = {}
    for name, error in absolute_errors(solution).items():
        unit, _, symbol = described(name, solution.scene.dimension)
        words = f"largest error of the equation itself in {name}, from simulations"
        dimensions = ("time", *COMPONENTS[: error.ndim - 1])
        label = f"error of {symbol}"
        variables[name + MODEL_ERROR] = variable(dimensions, error, unit, words, label)
    return variables


def _function_shapes(functions: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """Return the axes of functions beside the time, as keys of `AXES`, by name of the function.

    With the position density g(r, t) comes the scaled one, G(R), R = r/sqrt(<r^2>), which is no
    output of its own.
    """
    shapes = {name: OUTPUTS[name].shape[1:] for name in functions}
    if "position_density" in shapes:
        shapes["scaled_position_density"] = ("n_R",)
    return shapes


class _FunctionAtPoints:
    """One function of a solution at points of its axes.

    Parameters
    ----------
    solution : the solution, whose method `name` is evaluated
    name : of the function
    shape : its axes beside the time, as keys of `AXES`
    points : the points that a user specified; see `solution_dataset`
    """

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
        #: Arguments of the method: points of each axis, and the direction if one is specified.
        self.arguments: list[Any] = list(self.points.values())
        if name == "intermediate_scattering" and "direction" in points:
            self.arguments.append(points["direction"])

    def axes(self) -> dict[str, Variable]:
        """Return the axes as coordinates of the dataset, by name."""
        return {
            axis.name: variable((axis.name,), x, axis.unit, axis.description)
            for axis, x in self.points.items()
        }

    def variables(self) -> dict[str, Variable]:
        """Return the values as variables of the dataset, by name.

        Complex values are two, with ``_real`` and ``_imag`` behind the name. Beside a density of
        the speed is "uncollided", the share that it leaves out.
        """
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


def radii_of_plot(distances: FloatArray) -> FloatArray:
    """Return radii at equal ratios where distributions with these sqrt(<r^2>) are, shape (n,)."""
    least = LEAST_RADIUS_OVER_RMS * float(distances.min())
    largest = LARGEST_RADIUS_OVER_RMS * float(distances.max())
    return np.geomspace(least, largest, N_RADII)


def _default_points(axis: Axis, solution: Solved) -> FloatArray:
    """Return points of an axis where the distributions are, the same for all times, shape (n,)."""
    if axis.points == "speeds":
        typical = solution.typical_speed
        # where all tracers are at rest at all times, any speeds will do
        moving = typical[typical > 0.0] if typical.any() else np.ones(1)
        lowest = LOWEST_SPEED_OVER_TYPICAL * moving.min()
        highest = HIGHEST_SPEED_OVER_TYPICAL * moving.max()
        return np.geomspace(lowest, highest, N_SPEEDS)
    if axis.points == "angles":
        # the circle in the plane, half of it in space
        full_range = 2.0 * np.pi / (solution.scene.dimension - 1.0)
        return np.linspace(0.0, full_range, N_ANGLES)
    if axis.points == "scaled_radii":
        return np.linspace(0.0, LARGEST_RADIUS_OVER_RMS, N_SCALED_RADII)
    largest = float(solution.root_mean_square_displacement.max())
    distance = max(largest, MIN_DISTANCE)
    if axis.points == "radii":
        return np.linspace(0.0, LARGEST_RADIUS_OVER_RMS * distance, N_RADII)
    if axis.points == "wave_numbers":
        scaled = np.geomspace(
            LOWEST_WAVE_NUMBER_TIMES_RMS, HIGHEST_WAVE_NUMBER_TIMES_RMS, N_WAVE_NUMBERS
        )
        return scaled / distance
    raise AssertionError(f"an axis without default points: {axis.points}")
