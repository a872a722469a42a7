"""Solves for g(r, t): F on intervals of wave numbers, upwards, until nothing that matters is left.

How far to go, and how exactly, follows from what F does to G(R): F that is missing or wrong around
the wave number k changes G(R) by about k sigma times as much, sigma = sqrt(<r^2>).
"""

from __future__ import annotations

import math

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.numerics import FloatArray
from kinetics.numerics.threads import one_blas_thread
from kinetics.position.ballistic_front import fastest_speed, fronts, uncollided_density
from kinetics.position.density import Displacement
from kinetics.position.intermediate_scattering import Scattering, points_of
from kinetics.position.tail import PowerTail, fit_tail
from kinetics.position.wave_panel import Sampling, WavePanel, nodes_between
from kinetics.states.state import State

# The work of one sweep, in squares of the sizes of the systems, some five seconds: what is left
# then is the error estimate. F is solved up to this K, or K T for densities, at most.
_MOST_WORK, _LARGEST_OF_PEAKS, _LARGEST = 1.2e8, 8.0, 60.0
# F is done where less is missed than this times rtol, which is 0.4 of what was asked for.
_ENOUGH = 2.2
_FEW = 0.01  # collided tracers below this share of rtol are left out
_FAR = 50.0  # R beyond which G is below e^-100: it falls as exp(-2 R) or faster
_ALIKE = 3.0  # of the widths of times that share their wave numbers
_HALVINGS = 7  # of an interval of wave numbers, at most
# Up to K = _CHEAP, where few harmonics are needed, F is solved to _CHEAPER of what G needs, but not
# beyond _BEST: rounding of F allows no more.
_CHEAP, _CHEAPER, _BEST = 2.0, 1e-4, 3e-12
# Chebyshev points of an interval: some, and so many for each digit; more of them where it begins
# at 0, fewer where F falls as a power of K.
_POINTS, _FOR_DIGIT, _FOR_DIGIT_AT_ZERO, _FOR_DIGIT_LATE = 4.0, 1.0, 1.6, 0.75
_POINTS_OF_PANEL = 8.0
_FIRST = 4.0  # K sqrt(<r^2>)/l where the first interval ends, but not beyond K = 1
_STEP, _LONGEST_STEP = 1.25, 1.6  # from the end of one interval to that of the next
_POWERS = 2.2  # K, in units of where the powers of 1/K begin, from which they are looked for ...
_NEARLY, _POWERS_OF_STOPPED = 0.1, 5.0  # ... and where a collision may leave so little of a speed
_FITTED = 0.3  # share of K, from above, to which they are fitted ...
_BETTER = 0.3  # ... and part of the last F that they may miss to be used
_BEYOND, _RETURNED = 2.0, 4.0  # error of F beyond over that of the fit; where tracers return
_TAPERED = 1e-2  # what is missed of G where F is tapered towards its last K
_FAINT = 12.0  # flights after which so few have not collided, or once, that fronts do not count
_FALL = 0.125  # what powers miss falls as K^-8 at least


@one_blas_thread
def solve_displacement(
    law: CollisionLaw,
    mean_free_path: float,
    state: State,
    times: FloatArray,
    root_mean_square: FloatArray,
    rtol: float,
) -> Displacement:
    """g(r, t) at the times, such that G(R) is right to about rtol, absolute.

    times : in d/U, shape (n_times,); root_mean_square : sqrt(<r^2>) in d, shape (n_times,)
    """
    fastest = fastest_speed(state, 0.1 * rtol)
    radius, weight = fronts(state, mean_free_path, times)
    with np.errstate(over="ignore"):
        # no tracer outruns its initial speed
        reach = np.minimum(times * fastest, _FAR * root_mean_square)
    system = Scattering(law, mean_free_path, state, times)
    width = root_mean_square / mean_free_path
    sweeps = [Sweep(system, width, which, rtol) for which in _groups(system, width, rtol)]
    for sweep in sweeps:
        sweep.run()
    return Displacement(
        mean_free_path=mean_free_path,
        times=times,
        root_mean_square=root_mean_square,
        panels=tuple(panel for sweep in sweeps for panel in sweep.panels),
        tails=tuple(
            next((s.tails[i] for s in sweeps if s.tails[i] is not None), None)
            for i in range(times.size)
        ),
        cut=np.minimum.reduce([sweep.cut() for sweep in sweeps]),
        uncollided=uncollided_density(state, mean_free_path, times, fastest),
        front_radius=radius,
        front_weight=weight,
        reach=reach,
        error_estimate=float(np.max([sweep.missed for sweep in sweeps])),
        systems=dict(system.systems),
        dimension=law.dimension,
    )


def _groups(system: Scattering, width: FloatArray, rtol: float) -> list[list[int]]:
    """The times in groups that need about the same wave numbers.

    Up to the reciprocal of the width; from 1 on all need the same. Those at which tracers of a
    sharp speed still fly freely stand apart.
    """
    groups: dict[tuple[bool, int], list[int]] = {}
    for i, size in enumerate(width):
        level = math.ceil(max(0.0, -math.log(max(float(size), 1e-300)) / math.log(_ALIKE)))
        groups.setdefault((system.flying(i) > _FEW * rtol, level), []).append(i)
    return list(groups.values())


class Sweep:
    """F on one interval of wave numbers after another, at some of the times.

    Attributes
    ----------
    panels, tails : F there, and for each time its powers of 1/K beyond, or None
    active : indices of the times for which F has not ended
    missed : what all this leaves of G(R), absolute, for each time
    """

    def __init__(
        self, system: Scattering, width: FloatArray, which: list[int], rtol: float
    ) -> None:
        """width : sqrt(<r^2>)/l, shape (n_times,); which : indices of the times to solve for."""
        self.system, self.width, self.rtol = system, width, rtol
        # early, the share of tracers that have collided is about the width, and they would need K
        # up to its reciprocal
        few = width <= _FEW * rtol
        here = np.isin(np.arange(width.size), which)
        self.active = np.nonzero(here & ~few)[0]
        self.missed = np.where(here & few, width, 0.0)
        self._widest = float(width[self.active].max(initial=0.0))
        self.panels: list[WavePanel] = []
        self.tails: list[PowerTail | None] = [None] * width.size
        self.sharp = any(system.flying(i) > _FEW * rtol for i in which)
        self.enough = rtol if self.sharp else _ENOUGH * rtol
        self._solved_error = np.zeros(width.size)
        # the least that was missed of each time, its tail then, and the number of panels
        self._best: dict[int, tuple[float, PowerTail | None, int]] = {}
        law = system.law
        self._at_origin = None
        if law.returns(0)[0] and not self.sharp:
            self._at_origin = system.mean_at_origin()
        profile = system.state.profile(0)
        self._slow = profile is not None and bool(profile(np.zeros(1))[0] != 0.0)
        speeds = points_of(system.state, 1.0, 1e-3)
        typical = math.exp(0.5 * speeds.log_second_moment()) / system.mean_free_path
        with np.errstate(over="ignore"):
            self._flights = system.times * typical  # T of a typical tracer
        # samples that throw tracers straight back
        self._straight = law.restitution is None and bool(
            np.any(law.quadrature.weight[law.quadrature.cosine < -1.0 + 1e-9] > 0.0)
        )

    def run(self) -> None:
        """Go on until nothing that matters is left, or the work is too much."""
        low, size, high = 0.0, 1.0, 0.0
        if self.active.size:
            far = 1.0 if self.sharp else max(1.0, min(_FIRST, self._widest))
            high = far / self._widest
        begin = done = self.system.work
        while self.active.size:
            if low >= (_LARGEST_OF_PEAKS if self.sharp else _LARGEST):
                self.active = self.active[low * self._flights[self.active] <= _LARGEST]
                if self.active.size == 0:
                    break
            new, error = self._interval(low, high, self._tolerance(high), size)
            self.panels += new
            size = max(float(np.abs(panel.values).max()) for panel in new)
            if not self.sharp:  # F falls
                size = float(np.abs(new[-1].values[:, -(new[-1].nodes.size // 4) :]).max())
            low, high = high, self._judge(high, error)
            last, done = self.system.work - done, self.system.work
            if done - begin + 2.0 * last > _MOST_WORK:  # the next interval is more than the last
                break
        # where more wave numbers left more of G(R) unknown, go back to those that left least
        for i, (missed, tail, count) in self._best.items():
            if missed < self.missed[i]:
                self.missed[i], self.tails[i] = missed, tail
                later = [panel.without(i) for panel in self.panels[count:]]
                self.panels[count:] = [panel for panel in later if panel.which.size]

    def cut(self) -> FloatArray:
        """K from which F is tapered where G is hardly known, else infinite, (n_times,).

        A sharp end would be seen as waves at all radii there.
        """
        cut = np.full(self.width.shape, np.inf)
        for i in np.nonzero(self.missed > max(self.enough, _TAPERED))[0]:
            last = [panel.high for panel in self.panels if panel.of(int(i)) is not None]
            if self.tails[i] is None and last:
                cut[i] = 0.5 * last[-1]
        return cut

    def _tolerance(self, high: float) -> float:
        """Of F up to K = high."""
        share = max(1.0, float(np.max(self.width[self.active])) * high)
        return min(self.rtol / share, max(_BEST, _CHEAPER * self.rtol) if high < _CHEAP else 1.0)

    def _judge(self, high: float, error: float) -> float:
        """Which times F has ended for at K = high, and where the next interval ends.

        error : of F on the interval that has just been solved
        """
        reached = high
        for i in map(int, self.active):
            self.tails[i], left = self._rest(i, high)
            share = max(1.0, self.width[i] * high)
            self._solved_error[i] = max(self._solved_error[i], error * share)
            self.missed[i] = left * share + self._solved_error[i]
            if self.missed[i] < self._best.get(i, (math.inf,))[0]:
                self._best[i] = float(self.missed[i]), self.tails[i], len(self.panels)
            if self.missed[i] > self.enough:
                enough = 2.0 * high
                if self.sharp:
                    enough = _end(self.panels[-1], i, self.rtol / share)
                elif self.tails[i] is not None:
                    more = (left * share / self.rtol) ** _FALL
                    enough = high * min(_LONGEST_STEP, max(_STEP, more))
                reached = max(reached, enough)
        self.active = self.active[self.missed[self.active] > self.enough]
        return reached

    def _interval(
        self, low: float, high: float, tolerance: float, size: float, halvings: int = 0
    ) -> tuple[list[WavePanel], float]:
        """F on an interval of K, halved until its Chebyshev coefficients end; and its error.

        tolerance : of F; size : about the largest value there, at its lower end for densities
        """
        digits = math.log10(max(10.0, size / tolerance))
        early = _FIRST / (high * self._widest)  # F falls as a power where it is small
        power = 0 if self.sharp or low == 0.0 or early > 0.99 else self.system.law.dimension + 1
        each = _FOR_DIGIT_AT_ZERO if low == 0.0 else _FOR_DIGIT
        if power:
            each = _FOR_DIGIT_LATE + 0.7 * min(0.5, early)
        count = math.ceil(_POINTS + each * digits + self._turns(low, high, tolerance))
        sampling = Sampling(low, high, count, power)
        values, error = self.system.collided(sampling.places, self.active, tolerance)
        missed = sampling.missed(values)
        if missed > tolerance and halvings < _HALVINGS:
            middle = 0.5 * (low + high)
            left, first = self._interval(low, middle, tolerance, size, halvings + 1)
            right, second = self._interval(middle, high, tolerance, size, halvings + 1)
            return left + right, max(first, second)
        if low == 0.0 or power:
            count = math.ceil(_POINTS_OF_PANEL + digits + 0.5 * count)
        return [sampling.panel(self.active, values, count)], missed + error

    def _turns(self, low: float, high: float, tolerance: float) -> float:
        """Points for cos(K T), with which tracers of one speed turn F until they have collided."""
        flights = self._flights[self.active]
        flying = flights[np.exp(-flights) > tolerance] if self.sharp else np.zeros(0)
        return 0.5 * (high - low) * float(flying.max(initial=0.0))

    def _rest(self, time: int, high: float) -> tuple[PowerTail | None, float]:
        """How F goes on beyond K = high, and how much of it is not known there."""
        last = _last(self.panels, time)
        if self.sharp:
            ended = float(np.abs(last[-(last.size // 4) - 1 :]).max())
            return None, ended * self._together(time, high)
        largest = float(np.abs(last).max())
        tail, left = self._powers(time, high)
        return (tail, left) if left < _BETTER * largest else (None, largest)

    def _together(self, time: int, high: float) -> float:
        """To how much the waves of all K add up beside the front of tracers of a sharp speed."""
        turns = high * min(float(self._flights[time]), _FAINT)
        return max(1.0, 2.0 / math.pi * turns) ** (0.5 * (self.system.law.dimension - 1.0))

    def _powers(self, time: int, high: float) -> tuple[PowerTail | None, float]:
        """The powers of 1/K in which F ends, and what they miss; infinite where there are none."""
        law, begin = self.system.law, max(1.0, 1.0 / self.width[time])
        if high < (_POWERS_OF_STOPPED if law.least_ratio < _NEARLY else _POWERS) * begin:
            return None, math.inf
        returned = 2.0 * float(self._at_origin[time]) if self._at_origin is not None else 0.0
        first = 0 if law.restitution == 0.0 or returned or self._slow else 1
        if self._straight:
            first = 1 - law.dimension
        k, f = nodes_between(self.panels, time, _FITTED * high)
        tail, left = fit_tail(k, f, begin, law.dimension, first, returned)
        return tail, left * (_RETURNED if returned else _BEYOND)


def _end(panel: WavePanel, time: int, least: float) -> float:
    """K where F is below ``least`` if it falls on as in the panel; twice the panel's end at most.

    Where F falls as exp(-K^2) it is below sooner.
    """
    f = _last([panel], time)
    quarter = max(1, f.size // 4)
    last, before = (float(np.abs(x).max()) for x in (f[-quarter:], f[-2 * quarter : -quarter]))
    if not 0.0 < last < before:
        return 2.0 * panel.high
    fall = math.log(before / last) / (panel.nodes[-1] - panel.nodes[-1 - quarter])
    more = math.log(max(1.0, last / least)) / fall
    return min(2.0 * panel.high, max(_STEP * panel.high, panel.high + more))


def _last(panels: list[WavePanel], time: int) -> FloatArray:
    """F on the last panel."""
    f = panels[-1].of(time)
    assert f is not None  # only times that are active are asked for
    return f
