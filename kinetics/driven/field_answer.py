"""Scenes with a field alone: averages and densities of the velocity over time.

`FieldAnswer` implements :class:`kinetics.answer.Answer`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NoReturn

import numpy as np

from kinetics.driven.answer_over_time import AnswerOverTime
from kinetics.driven.field_evolution import FieldEvolution, FieldProblem, drive_of_unit_field
from kinetics.driven.march import SHORTEST_TIME
from kinetics.driven.over_time import (
    MarchesOverTime,
    needed_averages,
    needs_density,
    solve_in_groups,
)
from kinetics.driven.resolution import PanelResolution
from kinetics.driven.speed_range import TAIL_OVER_TOLERANCE, top_speed
from kinetics.driven.starts import START_SHARE_OF_TOLERANCE, DrivenStart
from kinetics.driven.velocity_density import VelocityDensity, is_sharp
from kinetics.errors import InputError, short
from kinetics.numerics import FloatArray, one_blas_thread
from kinetics.numerics.refinement import refine_until_converged
from kinetics.outputs import AVERAGES, DENSITIES

# Ranges in which powers of speeds and times are within double precision. Chosen: far outside of
# any system, and far inside of 1e-308 to 1e308.
#: Least time above 0, in sqrt(l/g).
MIN_TIME_IN_FIELD = 1e-150
#: Largest time, in sqrt(l/g).
MAX_TIME_IN_FIELD = 1e15
#: Least sqrt(g l) in U.
MIN_SPEED_UNIT = 1e-100
#: Largest sqrt(g l) in U.
MAX_SPEED_UNIT = 1e100
#: Least l in d.
MIN_MEAN_FREE_PATH = 1e-150
#: Largest l in d.
MAX_MEAN_FREE_PATH = 1e150
#: Largest speed of a start in sqrt(g l) where densities are needed: flights that change faster ones
#: by less than 1e-12 lose digits.
MAX_START_WITH_DENSITY = 1e6
#: The same elsewhere: <v^4> of faster ones overflows.
MAX_START = 1e40
#: A start is at rest if its speed, over that of the first flight, changes averages by less than
#: this fraction of the tolerance. Chosen: a tenth adds little to the error.
REST_OVER_TOLERANCE = 0.1


@dataclass(frozen=True, eq=False)
class FieldAnswer(AnswerOverTime[FieldEvolution]):
    """The answer to a scene with a field alone; it is solved when it is needed.

    Errors are relative to the root mean square for velocities and displacements, to <v^2> and
    <r^2> for the tensors, and to the largest density at each time. They are the difference from a
    solution with fewer speeds, harmonics and steps.

    Parameters
    ----------
    scene : with a field, and no other drive
    rtol : relative accuracy; of densities max(rtol, 1e-4)
    """

    # -- units ------------------------------------------------------------------------------------

    @cached_property
    def _speed_unit(self) -> float:
        """sqrt(g l) in U; InputError where it is out of range."""
        unit = math.sqrt(self.scene.field * self.scene.mean_free_path)
        is_path_in_range = MIN_MEAN_FREE_PATH < self.scene.mean_free_path < MAX_MEAN_FREE_PATH
        if not (MIN_SPEED_UNIT < unit < MAX_SPEED_UNIT and is_path_in_range):
            self._refuse_field()
        return unit

    @cached_property
    def _times(self) -> FloatArray:
        """The times in sqrt(l/g), (n_times,); InputError where one is out of range."""
        with np.errstate(over="ignore", invalid="ignore"):  # sqrt(field/path) may be infinite
            per_time = math.sqrt(self.scene.field) / math.sqrt(self.scene.mean_free_path)
            times = np.asarray(self.scene.times) * per_time
        is_in_range = (times == 0.0) | (times > MIN_TIME_IN_FIELD) & (times < MAX_TIME_IN_FIELD)
        if not np.all(is_in_range):
            self._refuse_field()
        return times

    def _refuse_field(self) -> NoReturn:
        raise InputError(
            f"field: got {short(self.scene.field)}; sqrt(field x mean free path) and the times in "
            "sqrt(mean free path/field) are out of range"
        )

    # -- solving ----------------------------------------------------------------------------------

    @cached_property
    @one_blas_thread
    def _solution(self) -> MarchesOverTime[FieldEvolution]:
        """The solutions of all times."""
        drive = drive_of_unit_field(self.scene.law)
        fastest = self._start(1, self.rtol).highest

        def top_speed_at(time: float) -> float:
            tail = TAIL_OVER_TOLERANCE * self.rtol
            return top_speed(drive, tail, max(time, SHORTEST_TIME), fastest)

        return solve_in_groups(self._times, top_speed_at, self._solve_up_to)

    def _solve_up_to(self, times: FloatArray) -> tuple[FieldEvolution, dict[str, float]]:
        """Return the best solution for times that are solved together, and its errors by name."""
        has_fronts = is_sharp(self.scene.state)
        tolerance = dict(self._tolerance)
        if has_fronts:
            # Finer solutions hardly mend the fronts of a density: it does not decide.
            tolerance.pop(DENSITIES, None)

        def solve(resolution: PanelResolution) -> FieldEvolution:
            return self._evolution(times, resolution)

        solution, errors = refine_until_converged(
            solve=solve,
            resolution=PanelResolution.over_time(self.rtol),
            difference=self._difference,
            tolerance=tolerance,
        )
        if has_fronts and DENSITIES in self._tolerance:
            negative = self._density_of(solution).negative()
            errors[DENSITIES] = max(errors.get(DENSITIES, math.inf), negative)
        return solution, errors

    def _difference(self, fine: FieldEvolution, coarse: FieldEvolution) -> dict[str, float]:
        """Return the differences of two solutions, relative to the scale of each output."""
        differences = {AVERAGES: fine.difference(coarse)}
        if DENSITIES in self._tolerance:
            fine_density = self._density_of(fine)
            differences[DENSITIES] = fine_density.difference(self._density_of(coarse))
        return differences

    def _start(self, harmonics: int, rtol: float) -> DrivenStart:
        """Return the start in units of sqrt(g l)."""
        tolerance = START_SHARE_OF_TOLERANCE * rtol
        unit = 1.0 / self._speed_unit
        return DrivenStart.of(self.scene.state, tolerance, unit, harmonics, self.scene.dimension)

    def _evolution(self, times: FloatArray, resolution: PanelResolution) -> FieldEvolution:
        """Return the solution for some times at one resolution."""
        keeps_density = needs_density(self.scene)
        start = self._start(resolution.harmonics, resolution.rtol)
        if start.highest > (MAX_START_WITH_DENSITY if keeps_density else MAX_START):
            self._refuse_field()
        # isotropic starts change averages by the square of their speed
        is_isotropic = self.scene.state.highest_harmonic == 0
        small = math.sqrt(self.rtol) if is_isotropic else self.rtol
        if start.highest < REST_OVER_TOLERANCE * small * min(1.0, float(times[0])):
            start = DrivenStart.rest(self.scene.dimension)
        problem = FieldProblem(
            law=self.scene.law,
            state=self.scene.state,
            start=start,
            times=times,
            names=needed_averages(self.scene),
            keeps_density=keeps_density,
        )
        return FieldEvolution(problem, resolution)

    def _density_of(self, solution: FieldEvolution) -> VelocityDensity:
        """Return the densities of a solution."""
        return VelocityDensity(solution, self._speed_unit)

    # -- densities --------------------------------------------------------------------------------

    @cached_property
    def _densities(self) -> list[VelocityDensity]:
        """The densities of each solution."""
        return [self._density_of(march) for march in self._solution.marches]

    @property
    def _density_at_times(self) -> list[tuple[VelocityDensity, int]]:
        """For each time its density, and its index there."""
        at_times = []
        for density, march in zip(self._densities, self._solution.marches, strict=True):
            at_times += [(density, i) for i in range(march.times.size)]
        return at_times

    @property
    def uncollided(self) -> FloatArray:
        """The share of tracers that keep a sharp velocity, (n_times,)."""
        return np.concatenate([density.uncollided for density in self._densities])

    @property
    def captured(self) -> FloatArray:
        """No tracer sticks: zeros, (n_times,)."""
        return np.zeros(self._times.shape)

    def speed_density(self, v: FloatArray) -> FloatArray:
        """Density of the speed in 1/U at speeds v (n_v,), shape (n_times, n_v)."""
        v = v / self._speed_unit
        densities = [density.by_speed(i, v) for density, i in self._density_at_times]
        return np.array(densities) / self._speed_unit

    def velocity_density(self, v: FloatArray, phi: FloatArray) -> FloatArray:
        """Density of the velocity in U^-d, shape (n_times, n_v, n_phi)."""
        along = np.outer(v / self._speed_unit, np.cos(phi)).ravel()
        across = np.outer(v / self._speed_unit, np.sin(phi)).ravel()
        densities = [density.at(i, along, across) for density, i in self._density_at_times]
        shape = (self._times.size, v.size, phi.size)
        return np.reshape(densities, shape) / self._speed_unit**self.scene.dimension
