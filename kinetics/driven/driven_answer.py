"""Scenes with driven tracers, or a restitution that depends on the impact speed, over time.

`DrivenAnswer` implements :class:`kinetics.answer.Answer`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from kinetics.drive import Drive
from kinetics.driven.answer_over_time import AnswerOverTime
from kinetics.driven.averages import COLUMNS
from kinetics.driven.driven_evolution import DrivenEvolution, DrivenProblem, axis_scale
from kinetics.driven.harmonics import sum_over_harmonics
from kinetics.driven.march import SHORTEST_TIME
from kinetics.driven.over_time import (
    MarchesOverTime,
    OutputsOverTime,
    needed_averages,
    needs_density,
    over_moving,
    solve_in_groups,
)
from kinetics.driven.resolution import ChebyshevResolution
from kinetics.driven.speed_range import TAIL_OVER_TOLERANCE, top_speed
from kinetics.driven.steady_solution import (
    COMPARED_SPEEDS,
    MIN_RATIO_IF_STICKING,
    SLOW_ERROR_FACTOR,
)
from kinetics.numerics import FloatArray, one_blas_thread
from kinetics.numerics.refinement import RefinementRules, refine_until_converged
from kinetics.outputs import AVERAGES, DENSITIES

#: A guess of the highest speed of the start, in U (the standard deviation of a velocity component
#: at the start). It only groups the times and sets the first resolution: a solution begins from
#: the highest speed that its start has. Six standard deviations, chosen.
USUAL_FASTEST_START = 6.0
#: Each refinement divides the rtol of its steps by 5. From the fourth one on, where it is 5^-4 and
#: less of the first one, a solution takes the steps of two refinements before: what is left then is
#: mostly of the speeds, and ever shorter steps would be lost in rounding (commit 431e06f0).
#: Derived: a number between 5^-4 and 5^-3.
LONGER_STEPS_BELOW = 0.005
#: The rtol of the steps two refinements before, over that of the resolution. Derived: 5^2.
LONGER_STEPS_FACTOR = 25.0
#: Least maximum of a density by which differences are divided, so that 0 is none. Chosen: far below
#: any density.
MIN_MAXIMUM_OF_DENSITY = 1e-300
#: The error of a solution is taken to be at least this fraction of the difference between the two
#: coarser ones. Chosen: where the density has a kink at v = 0, differences that fell 23 and 48
#: times in one refinement hid errors of 3 times the tolerance (commit 316ac4dd).
MIN_RATIO_OVER_TIME = 0.3
#: Fewest harmonics M over time: averages of second order need m = 2.
MIN_HARMONICS_OVER_TIME = 2
#: Outputs that see the directions of the start also without a field.
OUTPUTS_WITH_DIRECTIONS = {
    "mean_displacement",
    "mean_velocity",
    "velocity_tensor",
    "displacement_tensor",
    "velocity_density",
}


@dataclass(frozen=True, eq=False)
class DrivenAnswer(AnswerOverTime[DrivenEvolution]):
    """The answer to a scene with any drive; it is solved when it is needed.

    Errors are relative. The solver counts speeds in U, the standard deviation of a velocity
    component at the start, lengths in mean free paths l and times in l/U.

    Parameters
    ----------
    scene : with a drive, or a restitution that depends on the impact speed
    rtol : relative accuracy; of densities max(rtol, 1e-4)
    """

    @property
    def _speed_unit(self) -> float:
        """Marches count speeds in U."""
        return 1.0

    @cached_property
    def _drive(self) -> Drive:
        """Bath, noise, drag or field of the scene, with the mean free path as unit of length."""
        return self.scene.drive.per_path(self.scene.mean_free_path)

    # -- solving ----------------------------------------------------------------------------------

    @cached_property
    @one_blas_thread
    def _solution(self) -> MarchesOverTime[DrivenEvolution]:
        """The best solution of each group of times, with its errors."""
        times = np.asarray(self.scene.times) / self.scene.mean_free_path
        return solve_in_groups(times, self._top_speed_at, self._solve_up_to)

    def _top_speed_at(self, time: float) -> float:
        """Return about the highest speed up to a time."""
        share_above = TAIL_OVER_TOLERANCE * self.rtol
        return top_speed(self._drive, share_above, max(time, SHORTEST_TIME), USUAL_FASTEST_START)

    def _solve_up_to(self, times: FloatArray) -> tuple[DrivenEvolution, dict[str, float]]:
        """Return the best solution for times that are solved together, and its errors by name."""
        first_resolution = self._first_resolution(float(times[-1]))
        averages = needed_averages(self.scene)
        if self._drive.capture_speed:
            averages |= {"1"}
        problem = DrivenProblem(
            drive=self._drive,
            state=self.scene.state,
            times=times,
            names=averages,
            keeps_density=needs_density(self.scene),
            is_isotropic=self._is_isotropic,
        )

        def solve(resolution: ChebyshevResolution) -> DrivenEvolution:
            is_fine = resolution.rtol < LONGER_STEPS_BELOW * first_resolution.rtol
            if is_fine:
                resolution = replace(resolution, rtol=LONGER_STEPS_FACTOR * resolution.rtol)
            return DrivenEvolution(problem, resolution)

        min_ratio = MIN_RATIO_OVER_TIME
        if self._drive.sticks_sharply:
            min_ratio = MIN_RATIO_IF_STICKING
        return refine_until_converged(
            solve=solve,
            resolution=first_resolution,
            difference=self._difference,
            tolerance=self._tolerance,
            rules=RefinementRules(min_ratio_to_previous=min_ratio),
        )

    def _first_resolution(self, last_time: float) -> ChebyshevResolution:
        """Return a resolution that is often enough up to a time.

        Nodes are needed for each unit of the span of the axis: v = scale sinh(x), see
        `chebyshev_axis`, is the highest speed at x = asinh(highest/scale).
        """
        scale = axis_scale(self._drive, max(last_time, SHORTEST_TIME))
        span = math.asinh(self._top_speed_at(last_time) / scale)
        harmonics = max(MIN_HARMONICS_OVER_TIME, self.scene.state.highest_harmonic or 0)
        return ChebyshevResolution.first(self._drive, self.rtol, span, harmonics)

    @property
    def _is_isotropic(self) -> bool:
        """Whether only speeds matter: outputs without a direction do not see that of the start."""
        has_directions = not OUTPUTS_WITH_DIRECTIONS.isdisjoint(self.scene.outputs)
        is_isotropic_start = self.scene.state.highest_harmonic == 0
        return not self._drive.field and (is_isotropic_start or not has_directions)

    def _difference(self, fine: DrivenEvolution, coarse: DrivenEvolution) -> dict[str, float]:
        """Return the differences of two solutions; a larger one where errors fall slowly."""
        difference = fine.difference(coarse)
        if self._drive.sticks_sharply:
            difference *= SLOW_ERROR_FACTOR
        differences = {AVERAGES: max(difference, fine.error_of_collisions)}
        if DENSITIES in self._tolerance:
            differences[DENSITIES] = difference_of_speed_densities(fine, coarse)
        return differences

    # -- averages ---------------------------------------------------------------------------------

    @property
    def _outputs(self) -> OutputsOverTime:
        """The outputs, of the tracers that still move where some stick."""
        averages = self._solution.columns
        if self._drive.capture_speed:
            averages = over_moving(averages)
        return OutputsOverTime(averages, self.scene, self._speed_unit)

    @property
    def captured(self) -> FloatArray:
        """The share of tracers that stick, (n_times,)."""
        return 1.0 - self._solution.columns["1"]

    # -- densities --------------------------------------------------------------------------------

    @property
    def uncollided(self) -> FloatArray:
        """Share of tracers missing in the densities, (n_times,): 0, as they hold every tracer."""
        return np.zeros(np.shape(self.scene.times))

    def speed_density(self, v: FloatArray) -> FloatArray:
        """Density of the speed in 1/U at speeds v (n_v,), shape (n_times, n_v)."""
        return np.array([march.speed_density(i, v) for march, i in self._solution.at_times])

    def velocity_density(self, v: FloatArray, phi: FloatArray) -> FloatArray:
        """Density of the velocity in U^-d, in d dimensions, shape (n_times, n_v, n_phi).

        v (n_v,) are speeds in U, phi (n_phi,) the angles from the x axis in radians.
        """
        dimension = self.scene.dimension
        densities = []
        for march, i in self._solution.at_times:
            harmonics = march.density(i, v, march.harmonics + 1)
            densities.append(sum_over_harmonics(harmonics, phi, dimension))
        return np.array(densities)


def difference_of_speed_densities(fine: DrivenEvolution, coarse: DrivenEvolution) -> float:
    """Return the largest difference of the speed densities, relative to their maximum."""
    largest = 0.0
    for time, mean_square in enumerate(fine.values[:, COLUMNS["v^2"]]):
        v = math.sqrt(max(mean_square, 0.0)) * COMPARED_SPEEDS
        fine_density = fine.speed_density(time, v)
        coarse_density = coarse.speed_density(time, v)
        maximum = max(np.abs(fine_density).max(), MIN_MAXIMUM_OF_DENSITY)
        difference = float(np.abs(fine_density - coarse_density).max() / maximum)
        if not math.isfinite(difference):
            return math.inf
        largest = max(largest, difference)
    return largest
