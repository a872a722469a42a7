"""Solves for g(r, t): F on intervals of wave numbers, upwards, until nothing that matters is left.

How far to go, and how exactly, follows from what F does to G(R): F that is missing or wrong around
the wave number k changes G(R) by about k sigma times as much, sigma = sqrt(<r^2>). There is a
budget of work; within it the best result is kept, and what is left unknown is the error estimate.
"""

from __future__ import annotations

import math

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.numerics import FOLDS, FloatArray, one_blas_thread
from kinetics.position.density import Displacement, Uncollided
from kinetics.position.intermediate_scattering import HALVINGS, Scattering, points_of
from kinetics.position.scattering import NEGLIGIBLE
from kinetics.position.wave_numbers import (
    PowerTail,
    WavePanel,
    fit_tail,
    points_beyond,
    wave_numbers_between,
)
from kinetics.states.state import State

# The work of all times, in products of numbers, a few seconds: of _ALIKE and above, and so many
# times as much for each digit more, so that one gets as far.
# From sharp speeds F is solved up to this K, or K T.
_MOST_WORK, _ALIKE, _OF_DIGIT, _LARGEST_OF_PEAKS, _FURTHEST = 1.5e10, 1e-5, 1.5, 8.0, 60.0
# F is done where less is missed than this times rtol, which is 0.4 of what was asked for.
_ENOUGH = 2.2
# Error of F over what G needs up to K = _CHEAP, where few harmonics are needed: it decides the norm
# and the moments.
_SOLVED_CHEAPLY, _CHEAP = 3e-3, 2.0
_POINTS, _FOR_DIGIT = 6.0, 1.4  # Chebyshev points of an interval: some, and so many for each digit
_FIRST = 4.0  # K sqrt(<r^2>)/l where the first interval ends, but not beyond K = 1
# From the end of one interval to that of the next: before its powers of 1/K are found, after that,
# and for sharp speeds, where the best of many ends is taken.
_STEP, _STEP_KNOWN, _STEP_OF_PEAKS = 2.0, 1.3, 1.25
_POWERS, _POWERS_OF_FEW = 2.2, 5.0  # K over where the powers of 1/K begin, to look for them
_KNOWN = 0.3  # part of the last F that its end may miss
# Error of F beyond over that of the fit, where F goes on by steps not seen there: where head-on
# bounces leave less than _SLOWED of the speed, few; where all lose e^-_LOSSY, many. Starts with a
# higher power of v than _NO_POWER near 0 have none.
_BY_FEW_STEPS, _BY_STEPS, _LOSSY, _SLOWED, _NO_POWER = 2.0, 20.0, 0.5, math.exp(-1.0), 8.0
_TAPERED = 1e-2  # what is missed of G where F is tapered towards its last K
_FAINT = 12.0  # flights after which so few have not collided, or once, that fronts do not count


@one_blas_thread
def solve_displacement(
    law: CollisionLaw, mean_free_path: float, state: State, times: FloatArray,
    root_mean_square: FloatArray, rtol: float,
) -> Displacement:  # fmt: skip
    """g(r, t) at the times, such that G(R) is right to about rtol, absolute, or as well as it can.

    times : in d/U, shape (n_times,); root_mean_square : sqrt(<r^2>) in d, shape (n_times,)
    """
    system = Scattering(law, mean_free_path, state, times)
    most = _MOST_WORK * _OF_DIGIT ** max(0.0, math.log10(_ALIKE / rtol))
    uncollided = Uncollided(state, mean_free_path, times)
    with np.errstate(over="ignore"):
        # no tracer outruns its initial speed, and G falls as exp(-2 R) or faster
        reach = np.minimum(times * uncollided.fastest(0.1 * rtol), FOLDS * root_mean_square)
    sweep = _Sweep(system, root_mean_square / mean_free_path, rtol)
    groups = sweep.groups()
    for left, group in zip(range(len(groups), 0, -1), groups, strict=True):
        sweep.run(group, (most - system.work) / left)
    found = Displacement(
        uncollided, root_mean_square, panels=tuple(sweep.panels), tails=tuple(sweep.tails),
        cut=sweep.cut, reach=reach, error_estimate=float(sweep.missed.max()),
        systems=dict(system.systems), dimension=law.dimension,
    )  # fmt: skip
    # with work left over, a looser one may leave less: to ask for more is to leave no less
    if found.error_estimate > 10.0 * _ENOUGH * rtol and system.work < most:
        args = law, mean_free_path, state, times, root_mean_square, 10.0 * rtol
        found = min(found, solve_displacement(*args), key=lambda one: one.error_estimate)
    return found


class _Sweep:
    """F on one interval of wave numbers after another, for one group of times after another."""

    def __init__(self, system: Scattering, width: FloatArray, rtol: float) -> None:
        """width : sqrt(<r^2>)/l, shape (n_times,)."""
        self.system, self.width, self.rtol = system, width, rtol
        # early, the share of tracers that have collided is about the width, and they would need K
        # up to its reciprocal
        self._few = width <= NEGLIGIBLE * rtol
        self.missed = np.where(self._few, width, 0.0)
        self.panels: list[WavePanel] = []
        self.tails: list[PowerTail | None] = [None] * width.size
        self.cut = np.full(width.shape, np.inf)  # K from which F is tapered where G is hardly known
        self._solved_error = np.zeros(width.size)
        # the least that was missed of each time, its tail then, and the number of panels
        self._best: dict[int, tuple[float, PowerTail | None, int]] = {}
        speeds = points_of(system.state, 0, 1.0, 1e-3)
        assert speeds is not None
        typical = math.exp(0.5 * speeds.log_second_moment()) / system.mean_free_path
        with np.errstate(over="ignore"):
            self._flights = system.times * typical  # T of a typical tracer
        self._first, self._order = self._powers()

    def groups(self) -> list[list[int]]:
        """The times in groups that need about the same wave numbers, those that need most last."""
        groups: dict[tuple[bool, int], list[int]] = {}
        for i, size in enumerate(self.width):
            level = math.ceil(max(0.0, -math.log(max(float(size), 1e-300)) / math.log(3.0)))
            groups.setdefault((self._is_sharp(i), level), []).append(i)
        return list(groups.values())[::-1]

    def _is_sharp(self, time: int) -> bool:
        """Whether tracers of sharp speeds have not collided."""
        return self.system.flying(time) > NEGLIGIBLE * self.rtol

    def run(self, group: list[int], most_work: float) -> None:
        """Go on until nothing that matters is left, or the work is too much."""
        self.active = np.array([i for i in group if not self._few[i]], dtype=int)
        if self.active.size == 0:
            return
        self.sharp = self._is_sharp(group[0])
        self.enough = self.rtol if self.sharp else _ENOUGH * self.rtol
        self._widest = float(self.width[self.active].max())
        low, size = 0.0, 1.0
        high = (1.0 if self.sharp else max(1.0, min(_FIRST, self._widest))) / self._widest
        begin = done = self.system.work
        while self.active.size:
            # rounding of F allows no more than 3e-12
            share = max(1.0, float(np.max(self.width[self.active])) * high)
            # beyond, the same for all large rtol, which then see the same
            needed = min(self.rtol, _ALIKE) if high > _CHEAP else self.rtol * _SOLVED_CHEAPLY
            new, error = self._interval(low, high, max(3e-12, needed / share), size)
            self.panels += new
            last = self.panels[-1].values
            # F of densities falls; that of sharp speeds turns
            size = float(np.abs(last if self.sharp else last[:, -(last.shape[1] // 4) :]).max())
            self._judge(high, error)
            step = _STEP_OF_PEAKS if self.sharp else _STEP
            if not self.sharp and all(self.tails[i] is not None for i in self.active):
                step = _STEP_KNOWN
            low, high = high, high * step
            if self.sharp and low >= _LARGEST_OF_PEAKS:
                self.active = self.active[low * self._flights[self.active] <= _FURTHEST]
            work, done = self.system.work - done, self.system.work
            if done - begin + step**2 * work > most_work:
                break
        # where more wave numbers left more of G(R) unknown, go back to those that left least; but
        # beside a front all of them are better
        for i in group:
            missed, tail, count = self._best.get(i, (math.inf, None, 0))
            if missed < self.missed[i] and not (self.sharp and missed > _TAPERED):
                self.missed[i], self.tails[i] = missed, tail
                later = [panel.without(i) for panel in self.panels[count:]]
                self.panels[count:] = [panel for panel in later if panel.which.size]
            ends = [panel.high for panel in self.panels if panel.of(i) is not None]
            if self.missed[i] > max(self.enough, _TAPERED) and self.tails[i] is None and ends:
                self.cut[i] = 0.5 * ends[-1]

    def _judge(self, high: float, error: float) -> None:
        """For which times F has ended at K = high; error: on the last interval."""
        for i in map(int, self.active):
            self.tails[i], left = self._rest(i, high)
            share = max(1.0, self.width[i] * high)
            self._solved_error[i] = max(self._solved_error[i], error * share)
            self.missed[i] = left * share + self._solved_error[i]
            if self.missed[i] < self._best.get(i, (math.inf,))[0]:
                self._best[i] = float(self.missed[i]), self.tails[i], len(self.panels)
        self.active = self.active[self.missed[self.active] > self.enough]

    def _interval(
        self, low: float, high: float, needed: float, size: float, halvings: int = 0
    ) -> tuple[list[WavePanel], float]:
        """F on an interval of K, halved until its Chebyshev coefficients end; and its error."""
        falls = not self.sharp and low > 0.0 and high * self._widest > _FIRST
        power = self.system.law.dimension + 1 if falls else 0
        digits = math.log10(max(10.0, size / needed))
        # and for cos(K T), with which tracers of one speed turn F until they have collided
        flights = self._flights[self.active]
        flying = flights[np.exp(-flights) > needed] if self.sharp else np.zeros(0)
        turns = 0.5 * (high - low) * float(flying.max(initial=0.0))
        count = math.ceil(_POINTS + _FOR_DIGIT * digits + turns)
        k = wave_numbers_between(low, high, power, count)
        values, error = self.system.average(k, self.active, needed, collided=True)
        panel = WavePanel(low, high, power, self.active, values)
        if panel.missed > needed and halvings < HALVINGS:
            middle = 0.5 * (low + high)
            left, first = self._interval(low, middle, needed, size, halvings + 1)
            right, second = self._interval(middle, high, needed, size, halvings + 1)
            return left + right, max(first, second)
        return [panel], panel.missed + error

    def _powers(self) -> tuple[int, float]:
        """The first of `PowerTail`, and the power of v, near 0, of the density of the start."""
        law, profile = self.system.law, self.system.state.profile(0)
        f = np.zeros(2) if profile is None else np.asarray(profile(np.array([1e-4, 2e-4])).real)
        order = math.log2(f[1] / f[0]) if f.min() > 0.0 else math.inf
        if law.throws_back or law.returns(0)[0]:  # tracers cross the origin
            return 1 - law.dimension, order
        slow = 0 if 0.0 in law.disk_restitutions else 1
        return math.floor(min(slow, order + 2.01 - law.dimension)), order

    def _rest(self, time: int, high: float) -> tuple[PowerTail | None, float]:
        """How F goes on beyond K = high, and how much of it is not known there."""
        last = self.panels[-1].of(time)
        assert last is not None  # only times that are active are asked for
        if self.sharp:
            # F turns with K T: its size is seen over a whole turn only
            turn = 2.0 * math.pi / max(float(self._flights[time]), 1e-300)
            _, f = points_beyond(self.panels, time, max(0.5 * high, high - turn))
            # the waves of all K add up beside the front of tracers of a sharp speed
            turns = max(1.0, high * min(float(self._flights[time]), _FAINT))
            return None, float(np.abs(f).max()) * turns ** (0.5 * (self.system.law.dimension - 1.0))
        law, begin = self.system.law, max(1.0, 1.0 / self.width[time])
        # in space the waves of the edges of a table of speeds add up beside fronts
        edges = law.dimension == 3 and self.system.state.kinks.size > 0
        largest = float(np.abs(last).max()) * (_BY_STEPS if edges else 1.0)
        # no power of v near 0 is as slow as that of a log-normal start
        few = 0.0 < law.least_ratio < _SLOWED or self._order > _NO_POWER
        if high < (_POWERS_OF_FEW if few else _POWERS) * begin:
            return None, largest
        tail, left = fit_tail(self.panels, time, high, begin, law.dimension, self._first)
        if few or law.returns(0)[0]:
            left *= _BY_FEW_STEPS if high * law.least_ratio > 1.0 else _BY_FEW_STEPS**2
        left *= _BY_STEPS if edges or law.least_loss > _LOSSY else 1.0
        return (tail, left) if left < _KNOWN * largest else (None, largest)
