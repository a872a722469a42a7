"""One initial state over time under any drive, on an axis of one smooth variable.

In units of the mean free path l and of U. The equation is that of `kinetics.driven.generator`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp

from kinetics.drive import Drive
from kinetics.driven import radau
from kinetics.driven.averages import AVERAGE_ROWS, COLUMNS, Component
from kinetics.driven.chebyshev_axis import FADING_POWER, ChebyshevSpeedAxis
from kinetics.driven.generator import Generator
from kinetics.driven.march import Step, StepEquation, TimeMarch
from kinetics.driven.resolution import ChebyshevResolution
from kinetics.driven.speed_range import TAIL_OVER_TOLERANCE, collision_rate, top_speed
from kinetics.driven.starts import DrivenStart, measures_of_start
from kinetics.errors import InputError
from kinetics.numerics import FloatArray
from kinetics.states.state import LogMeasure, State

#: Most steps that are tried. Measured: at most 146 in 113 solutions.
MAX_TRIES_DRIVEN = 2000
#: The power p of the axis where nothing drives: one polynomial then holds ten decades of speeds.
UNDRIVEN_AXIS_POWER = 10.0
#: The scale of that axis over its top speed. Measured at rtol 1e-6: at half and at twice <v^2>
#: moves by 6e-8.
UNDRIVEN_SCALE_OVER_TOP = 8.0
#: Averages of the start that are known at time 0, beside those that are 0.
AVERAGES_KNOWN_AT_START = ("v_x", "v^2", "v^4", "v^2 cos 2")


def axis_scale(drive: Drive, time: float) -> float:
    """Return the scale of the axis up to a time: below 1/t no tracer has collided."""
    return max(drive.scale, math.sqrt(drive.field), 0.5 / time)


@dataclass(frozen=True)
class DrivenProblem:
    """What is solved over time.

    Parameters
    ----------
    drive : in units of l and U
    state : the initial state
    times : in l/U, rising, (n_times,)
    names : of the averages that must be right
    keeps_density : whether the density is needed
    is_isotropic : whether only the speeds of the start count
    """

    drive: Drive
    state: State
    times: FloatArray
    names: frozenset[str]
    keeps_density: bool
    is_isotropic: bool

    def start(self, resolution: ChebyshevResolution) -> DrivenStart:
        """Return the start by its harmonics; InputError unless it is symmetric about x."""
        last = 0 if self.is_isotropic else resolution.harmonics
        measures = measures_of_start(self.state, resolution.rtol, last)
        start = DrivenStart(tuple(measures), 1.0)
        if not start.is_symmetric:
            raise InputError(
                "initial: of a driven tracer, in a field, and for outputs with a direction, it "
                "must be symmetric about the x axis"
            )
        return start


class DrivenEvolution(TimeMarch):
    """One start over time.

    Attributes
    ----------
    problem, resolution : what is solved, and how finely
    axis : of the speeds
    sums : distributions at the times, averages of the polynomials of the axis, (n_times, M + 1,
        size); only those at the start, unless the density is needed
    error_of_collisions : what the rate of collisions at the start is off, as a relative error of
        the number of collisions; 0 if that is not needed
    finer : the next finer resolution; None where there is none
    """

    axis: ChebyshevSpeedAxis

    def __init__(self, problem: DrivenProblem, resolution: ChebyshevResolution) -> None:
        super().__init__(problem.times, problem.names, resolution.rtol, MAX_TRIES_DRIVEN)
        self.problem = problem
        self.resolution = resolution
        self.harmonics = resolution.harmonics
        start = problem.start(resolution)
        fastest = self._fastest(start)
        self.axis = self._make_axis(fastest)
        generator = Generator(problem.drive, self.axis, resolution)
        components = [Component("1", 0), Component("x", 0), Component("y", 1)]
        if problem.is_isotropic:  # y f is as x f
            components = components[:2]
        equation = StepEquation(generator.chain, components, self.axis.speeds, generator.rate)
        count = resolution.harmonics + 1
        state = problem.state if problem.keeps_density else None
        f = np.zeros((len(components), count, self.axis.size))
        f[:1] = start.projected(self.axis, count, 1, state)
        self.sums = np.repeat(f[:1], self.times.size, axis=0)
        if self.times[-1] > 0.0:
            self.run(equation, f, fastest)
        self.error_of_collisions = self._error_of_collisions(start, float(f[0, 0] @ generator.rate))
        self._set_values_at_start(start)
        self.finer = generator.finer if self.tries < MAX_TRIES_DRIVEN else None

    def _fastest(self, start: DrivenStart) -> float:
        """Return the highest speed at the start that counts.

        What fades towards the top changes averages of the start by less than the tail does.
        """
        if not self.problem.drive.is_driven:
            return start.highest
        speeds = start.speeds
        log_power_average = logsumexp(FADING_POWER * speeds.x, b=abs(speeds.weight))
        log_tail = math.log(TAIL_OVER_TOLERANCE * self.resolution.rtol)
        return max(start.highest, math.exp((log_power_average - log_tail) / FADING_POWER))

    def _make_axis(self, fastest: float) -> ChebyshevSpeedAxis:
        """Return the axis of speeds up to the highest one at the last time."""
        drive = self.problem.drive
        tail = TAIL_OVER_TOLERANCE * self.resolution.rtol
        top = top_speed(drive, tail, self.last_time, fastest)
        if drive.is_driven:
            power = 1.0
            scale = min(axis_scale(drive, self.last_time), top)
        else:
            power = UNDRIVEN_AXIS_POWER
            scale = UNDRIVEN_SCALE_OVER_TOP * top
        is_smooth = drive.is_smooth_at_rest
        return ChebyshevSpeedAxis(top, scale, self.resolution.nodes, power, is_smooth)

    def _error_of_collisions(self, start: DrivenStart, projected_rate: float) -> float:
        """Return what the rate of collisions at the start is off, over the collisions since then.

        The rate of the start, which bends at rest, is known; what it is off lasts a collision.
        """
        if "collisions" not in self.names:
            return 0.0
        speeds = start.speeds
        v = np.exp(speeds.x)
        rate = float(speeds.weight.real @ collision_rate(self.problem.drive, v))
        mean_free_time = 1.0 / max(rate, 1e-300)
        off = abs(projected_rate - rate) * np.minimum(self.times, mean_free_time)
        collisions = self.values[:, COLUMNS["collisions"]]
        counts = (self.times > 0.0) & (collisions > 0.0)
        return float(np.max(off[counts] / collisions[counts], initial=0.0))

    def _set_values_at_start(self, start: DrivenStart) -> None:
        """Set the averages at time 0, which are known from the start."""
        values = np.zeros(len(COLUMNS))
        values[COLUMNS["1"]] = 1.0
        for average in AVERAGE_ROWS:
            if average.name not in AVERAGES_KNOWN_AT_START:
                continue
            term = average.terms[0]
            measure = _measure(start, term.harmonic)
            if measure is not None and term.power is not None:
                powers = np.exp(term.power * measure.x)
                values[COLUMNS[average.name]] = float(measure.weight.real @ powers)
        self.values[self.times == 0.0] = values

    def keep(self, step: Step, density: FloatArray) -> None:
        """Store the distributions at the times in a step."""
        if not self.problem.keeps_density:
            return
        inside = self.inside(step)
        rows = radau.interpolation_rows(step.local(self.times[inside]))
        self.sums[inside] = np.tensordot(rows, density[:, 0], axes=1)

    def density(self, time: int, v: FloatArray, harmonics: int) -> FloatArray:
        """Return the first harmonics of f at speeds v (n,) and the time of this index.

        Returns
        -------
        Shape (harmonics, n), as averages over f have them
        """
        dimension = self.problem.drive.dimension
        return self.axis.density(self.sums[time, :harmonics], v, dimension)

    def speed_density(self, time: int, v: FloatArray) -> FloatArray:
        """Return the density of the speed at speeds v (n,) and the time of this index."""
        surface = v ** (self.problem.drive.dimension - 1.0)
        return np.asarray(self.density(time, v, 1)[0] * surface)


def _measure(start: DrivenStart, harmonic: int) -> LogMeasure | None:
    """Return the measure of a harmonic of the start; None if it has none."""
    if harmonic >= len(start.measures):
        return None
    return start.measures[harmonic]
