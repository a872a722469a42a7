"""F on intervals of wave numbers, upwards, until nothing that matters is left.

How far to go, and how exactly, follows from what F does to G(R): F that is missing or wrong around
the wave number k changes G(R) by about k sigma times as much, sigma = sqrt(<r^2>).
"""

from __future__ import annotations

import math

import numpy as np

from kinetics.numerics import FloatArray
from kinetics.numerics.chebyshev import FirstKind
from kinetics.position.front_tail import FAINT, FrontTail, fit_fronts
from kinetics.position.intermediate_scattering import Scattering, points_of
from kinetics.position.once_collided import OnceCollided
from kinetics.position.sampling import Sampling
from kinetics.position.tail import PowerTail, fit_tail
from kinetics.position.wave_panel import WavePanel, nodes_between

# The work allowed: F that does not end before is solved for up to this K for sharp speeds, and up
# to this K and K T for densities.
_LARGEST_OF_PEAKS, _LARGEST = 8.0, 60.0
# Starts of one speed: F up to K T = _LARGEST_TURNS at most. The end is fitted where K R is above
# _FIRST_TURNS, R the T of the tracers but not above _FIRST_RADIUS, and where less than _HOPELESS of
# G is missed; the range of K T grows by _LONGEST_TURN, and later by _LONGEST_OF_FRONTS of itself.
_LARGEST_TURNS, _FIRST_TURNS, _FIRST_RADIUS, _LONGEST_TURN = 250.0, 30.0, 6.0, 25.0
_HOPELESS, _LONGEST_OF_FRONTS = 100.0, 0.3
# Where every bounce takes more than _STOPPING e-folds of the speed, tracers nearly rest after a few
# flights. From K = 1 to the reciprocal of the path that they still fly, F falls as 1/K, which no
# power of `tail` fits: the error at small R is estimated as if there were no tail.
_STOPPING = 2.0
# The sweep ends with the error that it has after a second or two where it may not end at all: for
# those, for sharp speeds, and for samples that throw tracers straight back. Others after about ten.
_MOST_WORK_OF_PEAKS, _MOST_WORK_OF_ENDLESS, _MOST_WORK = 5e6, 3.5e6, 1.2e9
_OF_FRONTS = 0.3  # part of the error of G that F may have up to its end, where there are fronts
# F is done where less is missed than this times rtol, which is 0.4 of what was asked for; times 1
# from sharp speeds without fits of the end of F, which leaves waves at all radii.
_ENOUGH = 2.2
_HALVINGS = 7  # of an interval of wave numbers, at most
FEW = 0.01  # collided tracers below this share of rtol are left out
# Up to K = _CHEAP, where few harmonics are needed, F is solved to _CHEAPER of what G needs, but not
# beyond _BEST: rounding of F allows no more.
_CHEAP, _CHEAPER, _BEST = 2.0, 1e-4, 3e-12
# Chebyshev points of an interval: some, and so many for each digit; more of them where it begins
# at 0. Where F falls as a power fewer do, but more of them at small K: see `sampling`.
_POINTS, _FOR_DIGIT, _FOR_DIGIT_AT_ZERO = 4.0, 1.0, 1.6
_FIRST = 4.0  # K sqrt(<r^2>)/l where the first interval ends, but not beyond K = 1
_POINTS_OF_POWERS, _FOR_DIGIT_LATE, _EARLIER = 4.0, 0.75, 0.35
_POINTS_OF_PANEL, _FOR_DIGIT_OF_PANEL = 8.0, 1.0
_FOR_DIGIT_OF_FRONTS = 1.7
_MOST_ALLOWED = 5.0  # error allowed to the waves, over that of F; more spoils the fit of its end
# From the end of one interval to that of the next: twice, and this where the end of F is fitted.
_STEP, _LONGEST_STEP = 1.25, 1.6
# K, as in the next line, for tracers that a collision may have stopped, or left below _NEARLY of
# their speed: before, F changes its sign, or goes over from one power to the next.
_POWERS_OF_STOPPED, _NEARLY = 5.0, 0.1
# Measured again by tests/kinetics/measurements/position.py, but those of returns and of fronts.
_POWERS = 2.2  # K, in units of where the powers of 1/K begin, from which they are looked for
_FITTED = 0.3  # share of K, from above, to which they are fitted ...
_BETTER = 0.3  # ... and part of the last F that they may miss to be used
_BEYOND = 2.0  # error of F beyond the panels, over what `fit_tail` says of it ...
_RETURNED = 4.0  # ... and among scatterers that are met again
_BEYOND_OF_FRONTS = 3.0  # and over what `fit_fronts` says of it: it may fall more slowly than 1/K
_FALL = 0.125  # what powers miss falls as K^-8 at least


class Sweep:
    """F on one interval of wave numbers after another, at some of the times.

    Attributes
    ----------
    panels, tails : F there, and for each time its powers of 1/K beyond, or None
    active : indices of the times for which F has not ended
    missed : what all this leaves of G(R), absolute, for each time
    """

    def __init__(
        self,
        system: Scattering,
        once: OnceCollided,
        width: FloatArray,
        which: list[int],
        rtol: float,
    ) -> None:
        """width : sqrt(<r^2>)/l, shape (n_times,); which : indices of the times to solve for."""
        self.system, self.once, self.width, self.rtol = system, once, width, rtol
        # early, the share of tracers that have collided is about the width, and they would need K
        # up to its reciprocal
        few = width <= FEW * rtol
        here = np.isin(np.arange(width.size), which)
        self.active = np.nonzero(here & ~few)[0]
        self.missed = np.where(here & few, width, 0.0)
        self._widest = float(width[self.active].max(initial=0.0))
        self.panels: list[WavePanel] = []
        self.tails: list[PowerTail | FrontTail | None] = [None] * width.size
        self.fronts = once.has_front(which[0], FEW * rtol)
        self.sharp = self.fronts or any(system.flying(i) > FEW * rtol for i in which)
        self.enough = rtol if self.sharp and not self.fronts else _ENOUGH * rtol
        self._solved_error = np.zeros(width.size)
        # the least that was missed of each time, its tail then, and the number of panels
        self._best: dict[int, tuple[float, PowerTail | FrontTail | None, int]] = {}
        self._allowed = 1.0  # error of the waves over that of F
        self._at_origin = None
        if system.law.returns(0)[0] and not self.sharp:
            self._at_origin = system.mean_at_origin()
        profile = system.state.profile(0)
        self._slow = profile is not None and bool(profile(np.zeros(1))[0] != 0.0)
        speeds = points_of(system.state, 1.0, 1e-3)
        typical = math.exp(0.5 * speeds.log_second_moment()) / system.mean_free_path
        with np.errstate(over="ignore"):
            self._flights = system.times * typical  # T of a typical tracer
        law = system.law  # samples that throw tracers straight back, or that stop them
        self._straight = law.restitution is None and bool(
            np.any(law.quadrature.weight[law.quadrature.cosine < -1.0 + 1e-9] > 0.0)
        )

    def run(self) -> None:
        """Go on until nothing that matters is left, or the work is too much."""
        low, size, high = 0.0, 1.0, 0.0
        if self.active.size:
            far = 1.0 if self.sharp else max(1.0, min(_FIRST, self._widest))
            high = far / self._widest
        largest = _LARGEST_OF_PEAKS if self.sharp else _LARGEST
        turns = _LARGEST_TURNS if self.fronts else _LARGEST
        peaks = self.system.state.peaks is not None
        endless = self._straight or self.system.law.least_loss > _STOPPING
        slow = peaks or endless
        most = (_MOST_WORK_OF_ENDLESS if endless else _MOST_WORK_OF_PEAKS) if slow else _MOST_WORK
        begin = done = self._work(slow)
        while self.active.size:
            if low >= largest:
                self.active = self.active[low * self._flights[self.active] <= turns]
                if self.active.size == 0:
                    break
            new, error = self._interval(low, high, self._tolerance(high), size)
            self.panels += new
            size = max(float(np.abs(panel.values).max()) for panel in new)
            if not self.sharp:  # F falls
                size = float(np.abs(new[-1].values[:, -(new[-1].nodes.size // 4) :]).max())
            low, high = high, self._judge(high, error)
            last, done = self._work(slow) - done, self._work(slow)
            # the next interval is more work than the last one
            if done - begin + 2.0 * last > most:
                break
        self._take_best()

    def _take_best(self) -> None:
        """Where more wave numbers left more of G(R) unknown, go back to those that left least."""
        for i, (missed, tail, count) in self._best.items():
            if missed < self.missed[i]:
                self.missed[i], self.tails[i] = missed, tail
                later = [panel.without(i) for panel in self.panels[count:]]
                self.panels[count:] = [panel for panel in later if panel.which.size]

    def _work(self, slow: bool) -> float:
        """Done so far, in the units of what is allowed."""
        return self.system.work_of_small if slow else self.system.work

    def cut(self) -> FloatArray:
        """K from which F is tapered where the work was too much, else infinite, (n_times,)."""
        cut = np.full(self.width.shape, np.inf)
        for i in np.nonzero(self.missed > self.enough)[0]:
            last = [panel.high for panel in self.panels if panel.of(int(i)) is not None]
            if self.tails[i] is None and last:
                cut[i] = 0.5 * last[-1]
        return cut

    def _tolerance(self, high: float) -> float:
        """Of F up to K = high."""
        sharp = max(self._share(int(i), high, not self.fronts) for i in self.active)
        part = _OF_FRONTS * self.rtol if self.fronts else self.rtol
        return min(part / sharp, max(_BEST, _CHEAPER * self.rtol) if high < _CHEAP else 1.0)

    def _share(self, time: int, high: float, inner: bool) -> float:
        """What an error of F at K = high is in G(R); inner : also beside a front below R = T."""
        share = max(1.0, self.width[time] * high)
        if not inner or not self.once.kept_apart(time):
            return share
        *slower, _ = self.once.scatterer.singular_radii(float(self.once.flights[time]))
        return share * _together(high * min(FAINT, max(slower)), self.once.dimension)

    def _judge(self, high: float, error: float) -> float:
        """Which times F has ended for at K = high, and where the next interval ends.

        error : of F on the interval that has just been solved
        """
        reached = high
        for i in self.active:
            self.tails[i], left = self._rest(int(i), high)
            share = max(1.0, self.width[i] * high)
            solved = error * self._share(int(i), high, not self.fronts)
            self._solved_error[i] = max(self._solved_error[i], solved)
            self.missed[i] = left * share + self._solved_error[i]
            if self.missed[i] < self._best.get(int(i), (math.inf,))[0]:
                self._best[int(i)] = float(self.missed[i]), self.tails[i], len(self.panels)
            if self.missed[i] > self.enough:
                enough = 2.0 * high
                if self.fronts:
                    longest = max(_LONGEST_TURN / self._flights[i], _LONGEST_OF_FRONTS * high)
                    enough = min(enough, high + longest)
                elif self.sharp:
                    enough = _end(self.panels[-1], int(i), self.rtol / share)
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
        nodes, each = _POINTS, _FOR_DIGIT_OF_FRONTS if self.fronts else _FOR_DIGIT
        early = _FIRST / (high * self._widest)  # F falls as a power where it is small
        power = 0 if self.sharp or early > 0.99 else self.system.law.dimension + 1
        if power:
            nodes, each = _POINTS_OF_POWERS, _FOR_DIGIT_LATE + _EARLIER * min(1.0, 2.0 * early)
        if low == 0.0:
            power, each = 0, max(each, _FOR_DIGIT_AT_ZERO)
        count = math.ceil(nodes + each * digits + self._turns(low, high, tolerance))
        if self.fronts and self.panels:
            least = tolerance / _together(high * min(FAINT, self._flights[self.active].max()), 2)
            count = min(count, math.ceil(_POINTS + self._seen(low, high, least)))
        sampling = Sampling(low, high, count, power)
        values, error = self._solved(sampling.places, tolerance)
        values -= [self.once.scattering(int(i), sampling.places) for i in self.active]
        missed = sampling.missed(values)
        if missed > tolerance and halvings < _HALVINGS:
            middle = 0.5 * (low + high)
            left, first = self._interval(low, middle, tolerance, size, halvings + 1)
            right, second = self._interval(middle, high, tolerance, size, halvings + 1)
            return left + right, max(first, second)
        if low == 0.0 or power:
            count = math.ceil(_POINTS_OF_PANEL + _FOR_DIGIT_OF_PANEL * digits + 0.5 * count)
        return [sampling.panel(self.active, values, count)], missed + error

    def _solved(self, places: FloatArray, tolerance: float) -> tuple[FloatArray, float]:
        """F at K = places, shape (n_active, n_k), and its error.

        That of the waves is estimated with care, and speeds at which it is large may be few: as
        much more is allowed as the last time has shown.
        """
        while True:
            asked = tolerance * self._allowed
            found, error = self.system.collided(places, self.active, asked)
            if error <= tolerance or self._allowed == 1.0:
                break
            self._allowed = 1.0
        change = 0.3 * tolerance / max(error, 1e-3 * tolerance)
        exact = self.sharp or self.system.law.least_ratio < _NEARLY
        most = 1.0 if exact else _MOST_ALLOWED
        self._allowed = min(max(1.0, self._allowed * min(change, 10.0)), most)
        return found, error

    def _seen(self, low: float, high: float, tolerance: float) -> float:
        """Points for what F still turns, as often as on the panel before."""
        panel = self.panels[-1]
        size = FirstKind(panel.values.shape[1]).coefficient_sizes(panel.values)
        last = int(np.flatnonzero(size.max(axis=0) > tolerance).max(initial=0)) + 1
        return last * (high - low) / (panel.high - panel.low)

    def _turns(self, low: float, high: float, tolerance: float) -> float:
        """Points for cos(K T), with which tracers of one speed turn F until they have collided."""
        if not self.sharp:
            return 0.0
        flights = self._flights[self.active]
        flying = flights[np.exp(-flights) > tolerance]
        if self.fronts:  # and with cos(K e T) those that collided head-on at once
            slower = [R for R in self.once.scatterer.singular_radii(1.0) if R < 1.0]
            flying = np.append(flying, max(slower) * flights)
        return 0.5 * (high - low) * float(flying.max(initial=0.0))

    def _rest(self, time: int, high: float) -> tuple[PowerTail | FrontTail | None, float]:
        """How F goes on beyond K = high, and how much of it is not known there."""
        last = _last(self.panels, time)
        largest = float(np.abs(last).max())
        ended = float(np.abs(last[-(last.size // 4) - 1 :]).max()) if self.sharp else largest
        if self.once.kept_apart(time):
            T = float(self.once.flights[time])
            share = max(1.0, high * self.width[time])
            ended *= _together(high * min(T, FAINT), self.once.dimension)
            few = high * min(T, _FIRST_RADIUS) < _FIRST_TURNS
            if ended * share < self.rtol or ended * share > _HOPELESS or few:
                return None, ended
            front, left = fit_fronts(self.panels, time, T, self.once.scatterer)
            left *= _BEYOND_OF_FRONTS
            if self.system.law.least_loss > _STOPPING:  # they leave 1/K, up to where they still fly
                left = max(left, largest)
            return (front, left) if left < ended else (None, ended)
        if self.sharp:
            return None, ended
        tail, left = self._powers(time, high)
        return (tail, left) if left < _BETTER * largest else (None, largest)

    def _powers(self, time: int, high: float) -> tuple[PowerTail | None, float]:
        """The powers of 1/K in which F ends, and what they miss; infinite where there are none."""
        law, begin = self.system.law, max(1.0, 1.0 / self.width[time])
        stopped = law.restitution == 0.0
        if high < (_POWERS_OF_STOPPED if law.least_ratio < _NEARLY else _POWERS) * begin:
            return None, math.inf
        returned = 2.0 * float(self._at_origin[time]) if self._at_origin is not None else 0.0
        first = 0 if stopped or returned or self._slow else 1
        if self._straight:
            first = 1 - law.dimension
        k, f = nodes_between(self.panels, time, _FITTED * high)
        tail, left = fit_tail(k, f, begin, law.dimension, first, returned)
        return tail, left * (_RETURNED if returned else _BEYOND)


def _together(turns: float, dimension: int) -> float:
    """To how much the waves of all K add up beside a front R, at 1/K from it; turns = K R."""
    return float(max(1.0, 2.0 / math.pi * turns) ** (0.5 * (dimension - 1.0)))


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
