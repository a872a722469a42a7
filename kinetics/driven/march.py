"""Averages over time, for one initial state, by steps of time.

Distributions, and x f and y f integrated over the place, go from step to step by the rule of
`radau`:

    d_t (x f) = (field + collisions) (x f) + v_x f, and the same for y.

Steps grow as the averages become smooth. `TimeMarch` is what a field and all other drives share;
`kinetics.driven.field_evolution` and `kinetics.driven.driven_evolution` say what differs. Begin
with `TimeMarch.run`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.driven import radau
from kinetics.driven.averages import (
    COLUMNS,
    INTEGRAL_ROWS,
    RATE_COLUMNS,
    RATE_FACTORS,
    Component,
    average_rows,
    largest_relative,
)
from kinetics.driven.axis import VelocityAxis
from kinetics.driven.harmonics import Chain, across, along
from kinetics.numerics import FloatArray
from kinetics.numerics.blocks import BlockElimination

#: A step is doubled if its roughness is so many times below what is allowed. Twice the step makes
#: the coefficient of degree 5 32 times as large, and of integrals 64 times.
SMOOTH_FACTOR = 64.0
#: The roughness of a step over what its end misses, at least. Measured in a field over time: at
#: half and at twice results move by 2e-6 at rtol 1e-4, and the time is the same.
ROUGHNESS_OVER_ERROR = 30.0
#: Shortest step over the last time: below it nothing becomes smoother. Chosen: far below any step
#: that was needed.
MIN_STEP = 1e-10
#: Times whose ratio differs from 1 by less are the same; and the shortest last time, as a number.
SHORTEST_TIME = 1e-12
#: Rounding of averages, relative to the sum of the absolute terms: shorter steps do not mend it.
ROUNDING_OF_SUMS = 1e-14
#: First step over the time of flight of the fastest, 1/(1 + v). Chosen: a step that is too long is
#: halved, one that is too short doubled.
FIRST_STEP = 0.5
#: A step is not doubled if the first time is ahead by less than so many doubled steps.
NEXT_STEP_REACH = 1.99


@dataclass(frozen=True)
class FactorizedModes:
    """The equations of the modes of steps of one length, by mode, then by family."""

    length: float
    eliminations: list[dict[int, BlockElimination]]


class StepEquation:
    """Takes distributions over one step of time after another.

    Parameters
    ----------
    chain : what changes the sums of each harmonic at some speeds
    components : what is solved: f, and x f and y f, of which f is the source; without y f of family
        1 it is as x f
    speeds : (size,); averages are sums over them
    rate : of collisions, (size,)
    """

    def __init__(
        self, chain: Chain, components: list[Component], speeds: FloatArray, rate: FloatArray
    ) -> None:
        self.chain = chain
        self.components = components
        self.speeds = speeds
        self.rate = rate
        self._factorized = FactorizedModes(0.0, [])

    def averages(self, f: FloatArray) -> FloatArray:
        """Return averages of distributions (n, n_components, M + 1, size), (n, n_averages)."""
        return average_rows(f, self.components, self.speeds, self.rate)

    def step(self, f: FloatArray, length: float, source: FloatArray | None) -> FloatArray:
        """Return the distributions at all points of a step, shape (STAGES + 1, *f.shape).

        Parameters
        ----------
        f : at its beginning, (n_components, M + 1, size)
        length : of the step
        source : at the stages, (STAGES, *f.shape); None for none
        """
        stages = np.zeros((radau.STAGES + 1, *f.shape))
        stages[0] = f
        for mode, eliminations in zip(radau.MODES, self._eliminations(length), strict=True):
            right = mode.constant_share / (length * mode.eigenvalue) * f
            if source is not None:
                right = right + np.tensordot(mode.source_shares, source, axes=1)
            solution = self._solve_mode(eliminations, right)
            stages[1:] += (mode.stages[:, None, None, None] * solution).real
        return stages

    def _eliminations(self, length: float) -> list[dict[int, BlockElimination]]:
        """Return the factorized equations of each mode; those of the last length are kept."""
        if length != self._factorized.length:
            families = {component.family for component in self.components}
            eliminations = []
            for mode in radau.MODES:
                shift = mode.shift(length)
                by_family = {family: self.chain.elimination(family, shift) for family in families}
                eliminations.append(by_family)
            self._factorized = FactorizedModes(length, eliminations)
        return self._factorized.eliminations

    def _solve_mode(
        self, eliminations: dict[int, BlockElimination], right: NDArray[Any]
    ) -> NDArray[Any]:
        """Return what one mode has of each component; f comes before x f and y f."""
        dimension = self.chain.dimension
        solution: NDArray[np.complexfloating] = np.zeros(right.shape, dtype=complex)
        for k, component in enumerate(self.components):
            family = component.family
            elimination = eliminations[family]
            source = right[k]
            if component.weight == "x":
                source = source + self.speeds * along(solution[family], family, dimension)
            elif component.weight == "y":
                other = 1 - family
                source = source + self.speeds * across(solution[other], other, dimension)
            solved = slice(elimination.first, elimination.last + 1)
            solution[k, solved] = elimination.solve(source[solved])
        return solution


@dataclass(frozen=True)
class Source:
    """Tracers in closed form, those that have not collided, during a step.

    Parameters
    ----------
    density : at the points of the step, (STAGES + 1, n_components, M + 1, size)
    collided : what their collisions make per unit time at the stages, (STAGES, ...)
    """

    density: FloatArray
    collided: FloatArray


@dataclass(frozen=True)
class Step:
    """Averages over one step of time.

    Parameters
    ----------
    begin, length : of the step
    stages : the distributions that are solved at its points, (STAGES + 1, n_components, M + 1,
        size)
    averages : over these, (STAGES + 1, n_averages)
    all_averages : over these and the tracers in closed form
    integrals : at its beginning, (n_integrals,)
    """

    begin: float
    length: float
    stages: FloatArray
    averages: FloatArray
    all_averages: FloatArray
    integrals: FloatArray

    @property
    def end(self) -> float:
        """The time at its end."""
        return self.begin + self.length

    def local(self, times: FloatArray) -> FloatArray:
        """Return times in units of the step, 0 at its beginning."""
        return (times - self.begin) / self.length

    def integrals_at(self, local: FloatArray) -> FloatArray:
        """Return the integrals from time 0 to local times (n,), shape (n, n_integrals)."""
        rates = self.all_averages[:, RATE_COLUMNS]
        gained = self.length * (radau.integral_rows(local) @ rates) * RATE_FACTORS
        return np.asarray(self.integrals + gained)

    def values_at_end(self) -> FloatArray:
        """Return all columns at the end of the step, (1, n_columns)."""
        return np.hstack([self.all_averages, self.integrals_at(radau.POINTS)])[-1:]

    def roughness(self) -> FloatArray:
        """Return the size of the highest polynomial in each column, (1, n_columns)."""
        of_averages = radau.roughness(self.averages)
        of_rates = radau.roughness(self.all_averages)[RATE_COLUMNS]
        return np.append(of_averages, self.length * of_rates * RATE_FACTORS)[None]


class TimeMarch:
    """One initial state over time, step after step: the base of evolutions.

    A subclass has an axis of speeds, solves harmonics 0 ... M, and calls `run`. It may override the
    hooks `uncollided_averages`, `source`, `keep` and `equation_after`, which are for what it does
    not solve by steps, or what it stores of them.

    Parameters
    ----------
    times : rising, shape (n_times,)
    names : of the columns that steps must resolve; others may be less accurate, or 0
    rtol : what a step may miss, relative
    max_tries : steps that are tried before they are taken as they are: another resolution says that
        this one fails
    """

    axis: VelocityAxis
    harmonics: int

    def __init__(
        self, times: FloatArray, names: frozenset[str], rtol: float, max_tries: int
    ) -> None:
        self.times = times
        self.names = names
        self.step_rtol = rtol
        self.max_tries = max_tries
        #: All columns of `averages.COLUMNS`, shape (n_times, n_columns).
        self.values = np.zeros((times.size, len(COLUMNS)))
        #: The number of steps.
        self.steps = 0
        #: The number of steps, and of those that were too long.
        self.tries = 0

    # -- hooks ------------------------------------------------------------------------------------

    def uncollided_averages(self, times: FloatArray) -> FloatArray | float:
        """Return what tracers in closed form add to the averages, (n, n_averages)."""
        return 0.0

    def source(self, begin: float, length: float) -> Source | None:
        """Return the tracers in closed form during a step; None if there are none."""
        return None

    def keep(self, step: Step, density: FloatArray) -> None:
        """Store what densities need of an accepted step.

        density : of all tracers at its points, (STAGES + 1, n_components, M + 1, size)
        """

    def equation_after(
        self, step: Step, equation: StepEquation, values: FloatArray
    ) -> tuple[StepEquation, FloatArray]:
        """Return the equation after a step, and the distributions with which it begins.

        values : of all columns at the end of the step, (1, n_columns)
        """
        return equation, step.stages[-1]

    # -- the march --------------------------------------------------------------------------------

    @property
    def last_time(self) -> float:
        """The last time, or a little above 0."""
        return max(float(self.times[-1]), SHORTEST_TIME)

    @property
    def first_time(self) -> float:
        """The first time above 0."""
        return float(np.min(self.times[self.times > 0.0], initial=self.last_time))

    def inside(self, step: Step) -> NDArray[np.bool_]:
        """Return which times are in a step, (n_times,): also one at its end, but for rounding."""
        end = step.begin + step.length * (1.0 + SHORTEST_TIME)
        return (self.times >= step.begin) & (self.times <= end)

    def difference(self, coarse: TimeMarch) -> float:
        """Return the largest difference from another solution, relative to each scale."""
        return largest_relative(self.values - coarse.values, self.values, self.names)

    def run(
        self, equation: StepEquation, f: FloatArray, fastest: float, first_step_divisor: int = 1
    ) -> None:
        """March from distributions at time 0 up to the last time.

        Parameters
        ----------
        equation : of the first steps
        f : (n_components, M + 1, size)
        fastest : the highest speed in f
        first_step_divisor : so many times shorter is the first step: solutions whose differences
            count should have others
        """
        first_time = self.first_time
        last_time = self.last_time
        time = 0.0
        integrals = np.zeros(len(INTEGRAL_ROWS))
        # At the first of the times averages may be small, as its fourth power: a step ends there.
        length = min(FIRST_STEP / (1.0 + fastest), first_time) / first_step_divisor
        while last_time - time > SHORTEST_TIME * last_time:
            self.tries += 1
            length = min(length, last_time - time)
            source = self.source(time, length)
            step = self._take_step(equation, f, time, length, integrals, source)
            values = step.values_at_end()
            rough = largest_relative(step.roughness(), values, self.names)
            allowed = self._allowed_roughness(equation, step, values)
            may_be_shorter = self.tries < self.max_tries and length > MIN_STEP * last_time
            if rough > allowed and may_be_shorter:
                length *= 0.5
                continue
            self._record(step)
            self.keep(step, step.stages if source is None else step.stages + source.density)
            self.steps += 1
            time = step.end
            integrals = values[0, -len(INTEGRAL_ROWS) :]
            equation, f = self.equation_after(step, equation, values)
            is_smooth = rough * SMOOTH_FACTOR < allowed or self.tries >= self.max_tries
            is_first_time_near = time < first_time < time + NEXT_STEP_REACH * length
            if is_smooth and not is_first_time_near:
                length *= 2.0

    def _take_step(
        self,
        equation: StepEquation,
        f: FloatArray,
        begin: float,
        length: float,
        integrals: FloatArray,
        source: Source | None,
    ) -> Step:
        """Return a step of this length, whether or not it is short enough."""
        stages = equation.step(f, length, None if source is None else source.collided)
        averages = equation.averages(stages)
        uncollided = self.uncollided_averages(begin + length * radau.POINTS)
        return Step(begin, length, stages, averages, averages + uncollided, integrals)

    def _allowed_roughness(self, equation: StepEquation, step: Step, values: FloatArray) -> float:
        """Return how rough a step may be, relative."""
        lost = ROUNDING_OF_SUMS * equation.averages(np.abs(step.stages[-1:]))
        lost = np.pad(lost, ((0, 0), (0, len(INTEGRAL_ROWS))))
        rounding = largest_relative(lost, values, self.names)
        # Inside a step averages miss all that is rough, not only what its end misses.
        end = step.end * (1.0 - SHORTEST_TIME)
        is_interpolated = bool(np.any((self.times > step.begin) & (self.times < end)))
        if is_interpolated:
            return max(self.step_rtol, rounding)
        return max(ROUGHNESS_OVER_ERROR * self.step_rtol, rounding)

    def _record(self, step: Step) -> None:
        """Interpolate all columns to the times in a step."""
        inside = self.inside(step)
        times = self.times[inside]
        local = step.local(times)
        solved = radau.interpolation_rows(local) @ step.averages
        averages = solved + self.uncollided_averages(times)
        self.values[inside] = np.hstack([averages, step.integrals_at(local)])
