"""One initial state over time in a field alone, on panels of speeds.

In units of sqrt(g l) for speeds and sqrt(l/g) for times, so that the field is 1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.drive import Drive
from kinetics.driven import radau
from kinetics.driven.averages import (
    INTEGRAL_ROWS,
    SECOND_ORDER_IN_PLACE,
    Component,
    largest_relative,
)
from kinetics.driven.free_fall import Bounces
from kinetics.driven.harmonics import Chain, norms
from kinetics.driven.march import Source, Step, StepEquation, TimeMarch
from kinetics.driven.panel_collisions import FASTEST_POWER, harmonic_bounces, loss_matrices
from kinetics.driven.panels import SpeedPanels
from kinetics.driven.resolution import PanelResolution
from kinetics.driven.speed_range import TAIL_OVER_TOLERANCE, top_speed
from kinetics.driven.starts import MAX_FOLLOWED, DrivenStart
from kinetics.numerics import FloatArray
from kinetics.states.state import State

#: Most steps that are tried. Measured: at most 35 in 29 solutions.
MAX_TRIES_IN_FIELD = 300
#: Speed over the mean one of the start, from which on densities are right. Chosen: at half and at
#: twice averages do not move.
SLOWEST_OF_DENSITY = 0.01
#: Most harmonics in a field: seconds, and 200 MB of memory.
MAX_PANEL_HARMONICS = 40


def drive_of_unit_field(law: CollisionLaw) -> Drive:
    """Return a field alone, in its own units."""
    return Drive(restitution=law, dimension=law.dimension, field=1.0)


@dataclass(frozen=True)
class FieldProblem:
    """What is solved over time in a field.

    Parameters
    ----------
    law : of the collisions
    state : the initial state, of which `start` is made
    start : in units of sqrt(g l)
    times : in sqrt(l/g), rising, (n_times,)
    names : of the averages that must be right
    keeps_density : whether the density is needed point by point
    """

    law: CollisionLaw
    state: State
    start: DrivenStart
    times: FloatArray
    names: frozenset[str]
    keeps_density: bool


@dataclass(frozen=True)
class CollisionGain:
    """What collisions make during a step of time.

    Parameters
    ----------
    begin, length : of the step
    speed_times_density : v G at its points, G the density that collisions make per unit time, by
        harmonic, (n_points, families, M + 1, size)
    """

    begin: float
    length: float
    speed_times_density: FloatArray


class FieldEvolution(TimeMarch):
    """One start over time in a field.

    Of a start that is a few velocities, those that have not collided are in closed form
    (`free_fall`), and are the source of the others: so averages over smooth functions are right,
    however rough the density is.

    Attributes
    ----------
    problem, resolution : what is solved, and how finely
    axis : all panels
    families : of harmonics; 1 if the start is symmetric about the field
    gains : what collisions make, in each step; only if the density is needed
    """

    axis: SpeedPanels

    def __init__(self, problem: FieldProblem, resolution: PanelResolution) -> None:
        super().__init__(problem.times, problem.names, resolution.rtol, MAX_TRIES_IN_FIELD)
        self.problem = problem
        self.resolution = resolution
        self.harmonics = resolution.harmonics
        self.gains: list[CollisionGain] = []
        self.families = 1 if problem.start.is_symmetric else 2
        drive = drive_of_unit_field(problem.law)
        self._tail = TAIL_OVER_TOLERANCE * resolution.rtol
        highest = top_speed(drive, self._tail, self.last_time, problem.start.highest)
        self._highest_at_end = top_speed(drive, self._tail, self.last_time)
        lowest = resolution.lowest * self._usual_low_speed()
        self.axis = SpeedPanels.rising(highest, lowest, resolution.nodes)
        # The panels that are left: no collision makes a tracer faster.
        self._panels = self.axis
        self._components = self._needed_components()
        self._loss = loss_matrices(self.axis, problem.law, resolution.harmonics)
        self.run(
            self._equation(),
            self._initial_distributions(),
            problem.start.highest,
            math.ceil(1.0 / resolution.step),
        )

    def _usual_low_speed(self) -> float:
        """Return the speed below which averages, or densities, vary little."""
        mean_speed = self.problem.start.mean_speed
        if self.problem.keeps_density:  # it varies where collisions leave few
            return min(1.0, max(SLOWEST_OF_DENSITY * mean_speed, self.first_time))
        # Below 1/t no tracer has collided by the time t, but most may be slower; from rest, before
        # the square root of rtol fewer than that have.
        uncollided_below = max(1.0, 1.0 / self.last_time)
        most_below = max(mean_speed, self.first_time, math.sqrt(self.resolution.rtol))
        return min(uncollided_below, most_below)

    def _needed_components(self) -> list[Component]:
        """Return f; and x f and y f if an average needs them."""
        families = range(self.families)
        components = [Component("1", family) for family in families]
        if self.names & SECOND_ORDER_IN_PLACE:
            components += [Component("x", family) for family in families]
            components += [Component("y", 1 - family) for family in families]
        return components

    def _initial_distributions(self) -> FloatArray:
        """Return the sums of the start, but not of velocities: these are a source."""
        count = self.resolution.harmonics + 1
        f = np.zeros((len(self._components), count, self.axis.size))
        start = self.problem.start
        if start.velocities is None:
            f[: self.families] = start.projected(
                self.axis, count, self.families, self.problem.state, self.resolution.rtol
            )
        return f

    def _equation(self) -> StepEquation:
        """Return the equation on the panels that are left."""
        v = self._panels.speeds
        n = v.size
        dimension = self.problem.law.dimension
        slopes = self._panels.slopes(dimension)
        chain = Chain(dimension, self._loss[:, :n, :n], slopes, 1.0 / v)
        return StepEquation(chain, self._components, v, v)

    @property
    def finer(self) -> PanelResolution | None:
        """The next finer resolution; None where there is none."""
        finer = self.resolution.finer
        return finer if finer.harmonics <= MAX_PANEL_HARMONICS else None

    # -- hooks of the march -----------------------------------------------------------------------

    def uncollided_averages(self, times: FloatArray) -> FloatArray | float:
        """Return what tracers that have not collided add to the averages, (n, n_averages)."""
        velocities = self.problem.start.velocities
        if velocities is None or not times.size:
            return 0.0
        return np.array([velocities.averages(float(time)) for time in times])

    def source(self, begin: float, length: float) -> Source | None:
        """Return the tracers that have not collided, if the start is a few velocities."""
        velocities = self.problem.start.velocities
        if velocities is None:
            return None
        times = begin + length * radau.FINE_TIMES
        count = self.resolution.harmonics + 1
        sums = velocities.project(times, self._panels, count, self._components)
        density = radau.project(sums)
        if velocities.along.size > MAX_FOLLOWED:
            return Source(density, self._gained(density[1:]))
        collided = velocities.project_collided(times, self._panels, self._components, self._bounces)
        return Source(density, radau.project(collided)[1:])

    def keep(self, step: Step, density: FloatArray) -> None:
        """Store what collisions make during a step."""
        if not self.problem.keeps_density:
            return
        dimension = self.problem.law.dimension
        volume = norms(density.shape[2], dimension) * self._panels.volumes(dimension)
        gained = self._gained(density[:, : self.families]) / volume
        on_all_panels = np.zeros((*gained.shape[:-1], self.axis.size))
        on_all_panels[..., : self._panels.size] = gained * self._panels.speeds
        self.gains.append(CollisionGain(step.begin, step.length, on_all_panels))

    def equation_after(
        self, step: Step, equation: StepEquation, values: FloatArray
    ) -> tuple[StepEquation, FloatArray]:
        """Leave out the highest panel once as few tracers are there as above the top at the end."""
        f = step.stages[-1]
        lower_edge = self._panels.edges[-2]
        if lower_edge < self._highest_at_end:
            return equation, f
        fast = f * (self._panels.speeds > lower_edge)
        missed = np.pad(equation.averages(fast[None]), ((0, 0), (0, len(INTEGRAL_ROWS))))
        velocities = self.problem.start.velocities
        uncollided = 0.0 if velocities is None else velocities.uncollided(step.end).sum()
        if max(largest_relative(missed, values, self.names), uncollided) > self._tail:
            return equation, f
        self._panels = self._panels.below_last_panel
        return self._equation(), f[..., : self._panels.size]

    # -- collisions -------------------------------------------------------------------------------

    @cached_property
    def _bounces(self) -> Bounces:
        """What each bounce keeps of the harmonics, and the ratio of the speeds."""
        bounces = harmonic_bounces(self.problem.law, FASTEST_POWER, self.resolution.harmonics)
        return Bounces(bounces.kept, np.exp(-bounces.log_loss))

    def _gained(self, f: FloatArray) -> FloatArray:
        """Return what sums (..., M + 1, size) gain by collisions per unit time."""
        n = self._panels.size
        lost = np.einsum("mij,...mj->...mi", self._loss[:, :n, :n], f)
        return self._panels.speeds * f - lost
