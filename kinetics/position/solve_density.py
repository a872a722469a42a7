"""Solves for g(r, t): F on intervals of wave numbers, upwards, until nothing that matters is left.

How far to go, and how exactly, follows from what F does to G(R): F that is missing or wrong around
the wave number k changes G(R) by about k sigma times as much, sigma = sqrt(<r^2>).
"""

from __future__ import annotations

import math

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.numerics import FloatArray
from kinetics.numerics.chebyshev import FirstKind
from kinetics.position.ballistic_front import fastest_speed, fronts, uncollided_density
from kinetics.position.density import Displacement
from kinetics.position.intermediate_scattering import Scattering, points_of
from kinetics.position.tail import PowerTail, fit_tail
from kinetics.position.wave_panel import WavePanel, points_between
from kinetics.states.state import State

# The work allowed: F that does not end before is solved for up to this K for sharp speeds, and up
# to this K and K T for densities.
_LARGEST_OF_PEAKS, _LARGEST = 8.0, 60.0
_HALVINGS = 7  # of an interval of wave numbers, at most
_FEW = 0.01  # collided tracers below this share of rtol are left out
_FAR = 50.0  # R beyond which G is below e^-100: it falls as exp(-2 R) or faster
# Up to K = _CHEAP, where few harmonics are needed, F is solved to _CHEAPER of what G needs, but not
# beyond _BEST: rounding of F allows no more.
_CHEAP, _CHEAPER, _BEST = 2.0, 1e-4, 3e-12
# Chebyshev points of an interval: some, and so many for each digit; more of them where the
# interval begins near 0, at which F varies fastest relative to it.
_POINTS, _FOR_DIGIT, _FOR_DIGIT_AT_ZERO = 4.0, 1.0, 1.3
_STEP = 1.25  # from the end of one interval to that of the next, at least; twice at most
# The four below are measured again by tests/kinetics/measurements/position.py.
_POWERS = 2.2  # K, in units of where the powers of 1/K begin, from which they are looked for
_FITTED = 0.3  # share of K, from above, to which they are fitted ...
_BETTER = 0.3  # ... and part of the last F that they may miss to be used
_BEYOND = 2.0  # what they miss beyond the panels, over what they miss in the last of them
_FALL = 0.25  # it falls as K^-4 at least


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
    system = Scattering(law, mean_free_path, state, times)
    sweep = _Sweep(system, root_mean_square / mean_free_path, rtol)
    sweep.run()
    radius, weight = fronts(state, mean_free_path, times)
    fastest = fastest_speed(state, 0.1 * rtol)
    with np.errstate(over="ignore"):
        # no tracer outruns its initial speed
        reach = np.minimum(times * fastest, _FAR * root_mean_square)
    return Displacement(
        mean_free_path=mean_free_path,
        times=times,
        root_mean_square=root_mean_square,
        panels=tuple(sweep.panels),
        tails=tuple(sweep.tails),
        cut=sweep.cut(),
        uncollided=uncollided_density(state, mean_free_path, times, fastest),
        front_radius=radius,
        front_weight=weight,
        reach=reach,
        error_estimate=float(sweep.missed.max(initial=0.0)),
        systems=dict(system.systems),
    )


class _Sweep:
    """F on one interval of wave numbers after another.

    Attributes
    ----------
    panels, tails : F there, and for each time its powers of 1/K beyond, or None
    active : indices of the times for which F has not ended
    missed : what all this leaves of G(R), absolute, for each time
    """

    def __init__(self, system: Scattering, width: FloatArray, rtol: float) -> None:
        """width : sqrt(<r^2>)/l, shape (n_times,)."""
        self.system, self.width, self.rtol = system, width, rtol
        # early, the share of tracers that have collided is about the width, and they would need K
        # up to its reciprocal
        few = width <= _FEW * rtol
        self.active = np.nonzero(~few)[0]
        self.missed = np.where(few, width, 0.0)
        self.panels: list[WavePanel] = []
        self.tails: list[PowerTail | None] = [None] * width.size
        self.sharp = system.state.peaks is not None
        self._solved_error = np.zeros(width.size)
        speeds = points_of(system.state, 1.0, 1e-3)
        typical = math.exp(0.5 * speeds.log_second_moment()) / system.mean_free_path
        with np.errstate(over="ignore"):
            self._flights = system.times * typical  # T of a typical tracer

    def run(self) -> None:
        """Go on until nothing that matters is left, or the work is too much."""
        low, size = 0.0, 1.0
        high = 1.0 / float(self.width.max()) if self.active.size else 0.0
        while self.active.size:
            longest = float(self._flights[self.active].max())
            largest = _LARGEST_OF_PEAKS if self.sharp else _LARGEST
            if low >= largest and low * longest > _LARGEST:
                break
            new, error = self._interval(low, high, self._tolerance(high), size)
            self.panels += new
            size = max(float(np.abs(panel.values).max()) for panel in new)
            low, high = high, self._judge(high, error)

    def cut(self) -> FloatArray:
        """K from which F is tapered where the work was too much, else infinite, (n_times,)."""
        cut = np.full(self.width.shape, np.inf)
        for i in self.active:
            if self.tails[i] is None:
                cut[i] = 0.5 * self.panels[-1].high
        return cut

    def _tolerance(self, high: float) -> float:
        """Of F up to K = high."""
        sharp = max(1.0, float(self.width[self.active].max()) * high)
        return min(self.rtol / sharp, max(_BEST, _CHEAPER * self.rtol) if high < _CHEAP else 1.0)

    def _judge(self, high: float, error: float) -> float:
        """Which times F has ended for at K = high, and where the next interval ends.

        error : of F on the interval that has just been solved
        """
        reached = high
        for i in self.active:
            begin = math.inf if self.sharp else max(1.0, 1.0 / self.width[i])
            self.tails[i], left = _rest(self.panels, int(i), begin)
            share = max(1.0, self.width[i] * high)
            self._solved_error[i] = max(self._solved_error[i], error * share)
            self.missed[i] = left * share + self._solved_error[i]
            if self.missed[i] > 2.0 * self.rtol:
                enough = 2.0 * high
                if self.sharp:
                    enough = _end(self.panels[-1], int(i), self.rtol / share)
                elif self.tails[i] is not None:
                    more = (left * share / self.rtol) ** _FALL
                    enough = high * min(2.0, max(_STEP, more))
                reached = max(reached, enough)
        self.active = self.active[self.missed[self.active] > 2.0 * self.rtol]
        return reached

    def _interval(
        self, low: float, high: float, tolerance: float, size: float, halvings: int = 0
    ) -> tuple[list[WavePanel], float]:
        """F on an interval of K, halved until its Chebyshev coefficients end; and its error.

        tolerance : of F; size : about the largest value there
        """
        digits = math.log10(max(10.0, size / tolerance))
        each = _FOR_DIGIT_AT_ZERO if high > 1.5 * low else _FOR_DIGIT
        nodes = math.ceil(_POINTS + each * digits + self._turns(low, high, tolerance))
        places = points_between(low, high, nodes)
        values, error = self.system.collided(places, self.active, tolerance)
        missed = float(np.max(FirstKind(nodes).last_coefficients(values)))
        if missed > tolerance and halvings < _HALVINGS:
            middle = 0.5 * (low + high)
            left, first = self._interval(low, middle, tolerance, size, halvings + 1)
            right, second = self._interval(middle, high, tolerance, size, halvings + 1)
            return left + right, max(first, second)
        return [WavePanel(low, high, self.active, values)], missed + error

    def _turns(self, low: float, high: float, tolerance: float) -> float:
        """Points for cos(K T), with which tracers of one speed turn F until they have collided."""
        if not self.sharp:
            return 0.0
        flights = self._flights[self.active]
        flying = flights[np.exp(-flights) > tolerance]
        return 0.5 * (high - low) * float(flying.max(initial=0.0))


def _end(panel: WavePanel, time: int, least: float) -> float:
    """K where F is below ``least`` if it falls on as in the panel; twice the panel's end at most.

    Where F falls as exp(-K^2) it is below sooner.
    """
    f = panel.of(time)
    assert f is not None  # only times that are active are asked for
    quarter = max(1, f.size // 4)
    last, before = (float(np.abs(x).max()) for x in (f[-quarter:], f[-2 * quarter : -quarter]))
    if not 0.0 < last < before:
        return 2.0 * panel.high
    fall = math.log(before / last) / (panel.nodes[-1] - panel.nodes[-1 - quarter])
    more = math.log(max(1.0, last / least)) / fall
    return min(2.0 * panel.high, max(_STEP * panel.high, panel.high + more))


def _rest(panels: list[WavePanel], time: int, scale: float) -> tuple[PowerTail | None, float]:
    """How F goes on beyond the panels, and how much of it is not known there.

    scale : K where its powers begin; infinite where it does not end in powers
    """
    high = panels[-1].high
    k, f = [], []
    for panel in panels:
        values = panel.of(time)
        if values is not None and panel.high > _FITTED * high:
            k.append(panel.nodes)
            f.append(values)
    last = float(np.abs(f[-1]).max())
    if math.isinf(scale):
        return None, float(np.abs(f[-1][-(f[-1].size // 4) - 1 :]).max())
    if high < _POWERS * scale:
        return None, last
    all_k, all_f = np.concatenate(k), np.concatenate(f)
    use = all_k > _FITTED * high
    tail, left = fit_tail(all_k[use], all_f[use], scale)
    return (tail, _BEYOND * left) if left < _BETTER * last else (None, last)
