"""What the answers to a scene with a field, and to one with any other drive, have in common.

Both solve the velocity over time by marches (:class:`kinetics.driven.over_time.MarchesOverTime`),
of which the outputs, the errors and the account of the work are made alike. Begin with
:class:`AnswerOverTime`.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import Generic

import numpy as np

from kinetics.driven.over_time import (
    MIN_ERROR_OF_DENSITY,
    March,
    MarchesOverTime,
    OutputsOverTime,
    needs_density,
)
from kinetics.driven.starts import measures_of_start
from kinetics.errors import InputError, PlanStep, SolverStatus, judge_errors
from kinetics.numerics import FloatArray
from kinetics.outputs import AVERAGES, DENSITIES, INITIAL_STATE
from kinetics.scene import Scene


@dataclass(frozen=True, eq=False)
class AnswerOverTime(ABC, Generic[March]):
    """The answer to a scene that is solved by marches over time, when it is needed.

    A subclass says how the marches are made, in which unit of speed, and what their densities are;
    it then implements :class:`kinetics.answer.Answer`.

    Parameters
    ----------
    scene : with a field, or another drive
    rtol : relative accuracy; of densities max(rtol, 1e-4)
    """

    scene: Scene
    rtol: float

    @property
    @abstractmethod
    def _solution(self) -> MarchesOverTime[March]:
        """The best solution of each group of times, with its errors."""

    @property
    @abstractmethod
    def _speed_unit(self) -> float:
        """The unit of speed of the marches, in U; that of length is the mean free path."""

    # -- how it was done --------------------------------------------------------------------------

    @cached_property
    def _tolerance(self) -> dict[str, float]:
        """How large the error of each part of the result that is solved may be."""
        tolerance = {AVERAGES: self.rtol}
        if needs_density(self.scene):
            tolerance[DENSITIES] = max(self.rtol, MIN_ERROR_OF_DENSITY)
        return tolerance

    @cached_property
    def errors(self) -> dict[str, float]:
        """Error estimates, by part of the result."""
        return {**self._solution.errors, INITIAL_STATE: self._error_of_start()}

    def _error_of_start(self) -> float:
        """Return the relative error of averages over the start, of a density not resolved.

        It is infinite where the error of a harmonic is not a number.
        """
        state = self.scene.state
        measures = measures_of_start(state, self.rtol, state.highest_harmonic or 0)
        errors = [measure.error for measure in measures if measure is not None]
        largest = float(np.max(errors, initial=0.0))
        return math.inf if math.isnan(largest) else largest

    @property
    def verdict(self) -> tuple[SolverStatus, str]:
        """The status of the whole answer, and a message that names the parts that missed."""
        tolerance = {**self._tolerance, INITIAL_STATE: self.rtol}
        status, message = judge_errors(self.errors, tolerance)
        return status, message + self.scene.drive.limits

    @property
    def plan(self) -> tuple[PlanStep, PlanStep]:
        """How the averages and the densities were solved: resolutions and differences."""
        return self._solution.plan(self.scene, self._speed_unit)

    @property
    def stats(self) -> dict[str, int]:
        """Harmonics and speeds of the largest solution, and the steps of all, by name."""
        return self._solution.stats

    # -- outputs ----------------------------------------------------------------------------------

    @property
    def _outputs(self) -> OutputsOverTime:
        """The outputs, made of the averages of the marches."""
        return OutputsOverTime(self._solution.columns, self.scene, self._speed_unit)

    @property
    def typical_speed(self) -> FloatArray:
        """The root mean square speed in U, (n_times,)."""
        return self._outputs.typical_speed

    @property
    def values(self) -> dict[str, FloatArray]:
        """The arrays of the outputs, in U and the diameter d."""
        return self._outputs.arrays

    def component_density(self, v_x: FloatArray) -> FloatArray:
        """Raise InputError: the marches give no density of one component of the velocity."""
        raise InputError(
            "velocity_component_density: it is not available in a field, nor of driven tracers; "
            "integrate velocity_density"
        )
