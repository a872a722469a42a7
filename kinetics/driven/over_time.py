"""What answers to scenes with a field, or any other drive, share: from marches to outputs.

Averages of a march are in units of the solver; a scene has U and d. Begin with `OutputsOverTime`,
which makes the outputs, and `solve_in_groups`, which solves all times of a scene.
"""

from __future__ import annotations

import bisect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Generic, TypeVar

import numpy as np

from kinetics.driven.averages import COLUMNS, INTEGRAL_ROWS
from kinetics.driven.march import TimeMarch
from kinetics.errors import PlanStep
from kinetics.numerics import FloatArray
from kinetics.outputs import ALL_OUTPUTS, AVERAGES, DENSITIES
from kinetics.scene import Scene

#: Least error of a density that is aimed at, over its maximum. Chosen, as figures show no more; the
#: documentation says so.
MIN_ERROR_OF_DENSITY = 1e-4
#: Largest ratio of the highest speeds at times that are solved together: slow tracers need finer
#: panels. Measured in a field: at half and at twice averages move by 7e-8 at rtol 1e-4, in the same
#: time.
MAX_TOP_RATIO = 6.0

#: The averages of a march that must be right for an output. All need "v^2". A mean displacement
#: counts relative to its root mean square.
AVERAGES_OF_OUTPUT: Mapping[str, set[str]] = {
    "a2": {"v^4"},
    "collisions": {"collisions"},
    "msd": {"x^2", "y^2"},
    "diffusion_coefficient": {"v_x x", "v_y y"},
    "mean_displacement": {"x", "y", "x^2", "y^2"},
    "mean_velocity": {"v_x", "v_y"},
    "velocity_tensor": {"v^2 cos 2", "v_x v_y"},
    "displacement_tensor": {"x", "y", "x^2", "y^2", "x y"},
}

#: The kind of march: in a field, or under any drive.
March = TypeVar("March", bound=TimeMarch)


def needed_averages(scene: Scene) -> frozenset[str]:
    """Return the names of the averages that must be right for the outputs of a scene."""
    names = {"v^2"}
    for output in scene.outputs:
        names |= AVERAGES_OF_OUTPUT.get(output, set())
    return frozenset(names)


def needs_density(scene: Scene) -> bool:
    """Return whether an output of a scene is a density of the velocity."""
    return any(output.step == DENSITIES for output in ALL_OUTPUTS if output.name in scene.outputs)


@dataclass(frozen=True)
class MarchesOverTime(Generic[March]):
    """The solutions of all times of a scene.

    Parameters
    ----------
    marches : each for times that follow each other
    errors : the largest, by part of the result
    """

    marches: tuple[March, ...]
    errors: Mapping[str, float]

    @cached_property
    def columns(self) -> dict[str, FloatArray]:
        """All averages by name, (n_times,) each, in units of the solver."""
        rows = np.vstack([march.values for march in self.marches])
        return {name: rows[:, column] for name, column in COLUMNS.items()}

    @property
    def at_times(self) -> list[tuple[March, int]]:
        """For each time its solution, and its index there."""
        return [(march, i) for march in self.marches for i in range(march.times.size)]

    @property
    def stats(self) -> dict[str, int]:
        """Numbers about the work."""
        return {
            "harmonics": max(march.harmonics for march in self.marches),
            "nodes": max(march.axis.size for march in self.marches),
            "steps": sum(march.steps for march in self.marches),
        }

    def plan(self, scene: Scene, speed_unit: float) -> tuple[PlanStep, PlanStep]:
        """Return what was solved, and how; `speed_unit` is that of the solver in U."""
        last = self.marches[-1]
        averages = (
            f"{', '.join(scene.outputs)}: harmonics 0 to {last.harmonics}, "
            f"{last.axis.size} speeds up to {last.axis.highest * speed_unit:.3g} U, {last.steps} "
            f"steps of time; a solution with fewer differs by {self.errors[AVERAGES]:.1e}"
        )
        has_density = DENSITIES in self.errors
        densities = "not asked for"
        if has_density:
            densities = f"of the maximum they differ by {self.errors[DENSITIES]:.1e}"
        return PlanStep(AVERAGES, True, averages), PlanStep(DENSITIES, has_density, densities)


def solve_in_groups(
    times: FloatArray,
    top_speed_at: Callable[[float], float],
    solve: Callable[[FloatArray], tuple[March, dict[str, float]]],
) -> MarchesOverTime[March]:
    """Solve times at which tracers are about as fast together.

    Parameters
    ----------
    times : rising, (n_times,)
    top_speed_at : the highest speed up to a time, rising with it
    solve : maps times that are solved together to a solution and its errors
    """
    marches: list[March] = []
    largest: dict[str, float] = {}
    end = times.size
    while end > 0:
        lowest_top = top_speed_at(float(times[end - 1])) / MAX_TOP_RATIO
        begin = bisect.bisect_left(
            times[: end - 1], lowest_top, key=lambda time: top_speed_at(float(time))
        )
        march, errors = solve(times[begin:end])
        marches.insert(0, march)
        largest = {name: max(error, largest.get(name, 0.0)) for name, error in errors.items()}
        end = begin
    return MarchesOverTime(tuple(marches), largest)


def over_moving(columns: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    """Return averages of the velocity over the tracers that still move; NaN where none is left.

    Those of the place, and collisions, are over all.
    """
    over_all = {"1", *(integral.name for integral in INTEGRAL_ROWS)}
    moving = np.where(columns["1"] > 0.0, columns["1"], np.nan)
    return {
        name: column if name in over_all else column / moving for name, column in columns.items()
    }


@dataclass(frozen=True)
class OutputsOverTime:
    """The outputs of a scene, made of averages.

    Parameters
    ----------
    averages : by the names of `averages.COLUMNS`, (n_times,) each, in units of the solver
    scene : what is asked for
    speed_unit : of the solver, in U; its unit of length is the mean free path
    """

    averages: Mapping[str, FloatArray]
    scene: Scene
    speed_unit: float

    @property
    def typical_speed(self) -> FloatArray:
        """The root mean square speed in U, (n_times,)."""
        return np.asarray(self.speed_unit * np.sqrt(self._mean_square_speed))

    @property
    def _mean_square_speed(self) -> FloatArray:
        """<v^2>, (n_times,); where nothing is resolved it may be below 0."""
        return np.maximum(self.averages["v^2"], 0.0)

    @property
    def arrays(self) -> dict[str, FloatArray]:
        """The requested arrays in U and d, in the order of the table of outputs."""
        arrays: dict[str, FloatArray] = {}
        for output in ALL_OUTPUTS:
            if output.name in self.scene.outputs and not output.is_function:
                arrays |= zip(output.names, self._make(output.name), strict=True)
        return arrays

    def _make(self, name: str) -> tuple[FloatArray, ...]:
        """Return the arrays of one output."""
        d = self.scene.dimension
        speed = self.speed_unit
        path = self.scene.mean_free_path
        averages = self.averages
        mean_square = self._mean_square_speed
        match name:
            case "thermal_speed":
                return (speed * np.sqrt(mean_square),)
            case "temperature":
                return (speed**2 * mean_square / d,)
            case "a2":
                with np.errstate(divide="ignore", invalid="ignore"):
                    squared = np.where(mean_square > 0.0, mean_square, np.nan) ** 2
                    return (d / (d + 2.0) * averages["v^4"] / squared - 1.0,)
            case "collisions":
                return (averages["collisions"],)
            case "msd":
                return (path**2 * (averages["x^2"] + (d - 1.0) * averages["y^2"]),)
            case "diffusion_coefficient":
                return self._diffusion()
            case "mean_displacement":
                return (path * self._vector("x", "y"),)
            case "mean_velocity":
                return (speed * self._vector("v_x", "v_y"),)
            case "velocity_tensor":
                along = (mean_square + (d - 1.0) * averages["v^2 cos 2"]) / d
                across = (mean_square - along) / (d - 1.0)
                return (speed**2 * self._tensor(along, averages["v_x v_y"], across),)
            case "displacement_tensor":
                mean = self._vector("x", "y")
                tensor = self._tensor(averages["x^2"], averages["x y"], averages["y^2"])
                tensor -= mean[:, :, None] * mean[:, None, :]
                return (path**2 * tensor,)
        raise AssertionError(name)

    def _diffusion(self) -> tuple[FloatArray, FloatArray]:
        """Return D, half the growth rate of <r^2>/d over all tracers, and d<r^2>/d ln t."""
        d = self.scene.dimension
        path = self.scene.mean_free_path
        moving = self.averages["1"]
        slope = moving * (self.averages["v_x x"] + (d - 1.0) * self.averages["v_y y"])
        times = np.asarray(self.scene.times)
        return path * slope / d, 2.0 * path * slope * times

    def _vector(self, x: str, y: str) -> FloatArray:
        """Return a vector, (n_times, d); in space the state is symmetric about x."""
        vector = np.zeros((self._mean_square_speed.size, self.scene.dimension))
        vector[:, 0] = self.averages[x]
        vector[:, 1] = self.averages[y]
        return vector

    def _tensor(self, xx: FloatArray, xy: FloatArray, yy: FloatArray) -> FloatArray:
        """Return a tensor, (n_times, d, d); in space the state is symmetric about x."""
        d = self.scene.dimension
        tensor = yy[:, None, None] * np.eye(d)
        tensor[:, 0, 0] = xx
        if d == 2:
            tensor[:, 0, 1] = xy
            tensor[:, 1, 0] = xy
        return tensor
