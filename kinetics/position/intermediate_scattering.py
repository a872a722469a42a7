"""F(k, t): the scattering function of one tracer, averaged over the initial state."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.errors import InputError, warn_missed
from kinetics.moments.averages import Averages
from kinetics.numerics import FOLDS, FloatArray, one_blas_thread
from kinetics.numerics.gauss import panels_between
from kinetics.position.directions import mean_phase, share_of_harmonic
from kinetics.position.scattering import Waves
from kinetics.position.wave_numbers import Indices
from kinetics.states.state import LogMeasure, State

HALVINGS = 6  # of panels that do not resolve what is on them, at most
# K, or K T, that can be asked for: some hundred harmonics on a hundred panels; and K at all, whose
# 40th power is a double
_LARGEST, _LARGEST_AT_ALL = 200.0, 1e6
_LARGEST_DELAYED = 20.0  # the same where returns take time: each panel looks back at all others
_BEST = 1e-12  # of F: rounding of the sums over harmonics and speeds allows no more
_ONCE_MORE = 0.03  # where the tolerance was missed, F is solved once more for this share of it
_MOST_WORK = 3e10  # products of numbers that one wave number may need: some 5 s, and 2 GB
_AT_ONCE = 1000.0  # wave numbers times 1 + K: some hundred megabytes


def points_of(state: State, m: int, spacing: float, rtol: float) -> LogMeasure | None:
    """Harmonic m of a start as points that resolve functions varying over ``spacing`` in ln v.

    Peaks and samples are points already; densities get Gauss panels, with an edge at each kink.
    None where the harmonic is zero.
    """
    profile, harmonic = state.profile(0), state.profile(m)
    found = state.harmonic(0, rtol)
    if profile is None or harmonic is None or found is None:
        return state.harmonic(m, rtol)
    low, high = float(found.x.min()), float(found.x.max())
    kinks = np.log(state.kinks[state.kinks > 0.0])
    if kinks.size:
        # the points of a table stop short of its ends
        low, high = min(low, float(kinks[0])) if state.kinks[0] > 0.0 else low, float(kinks[-1])
    kinks = kinks[(kinks > low) & (kinks < high)]
    for halving in range(HALVINGS + 1):
        count = math.ceil((high - low) / spacing * 2**halving) + 1
        x, w = panels_between(np.union1d(np.linspace(low, high, max(2, count)), kinks), 10)
        v = np.exp(x)
        norm = float(profile(v).real @ (v * w))
        if abs(norm - 1.0) < rtol:
            break
    values = np.asarray(harmonic(v) * v * w) / norm
    return LogMeasure(x, values if m else values.real)


@dataclass
class Scattering:
    """Solves for F(k, t) of one system and start, as a scene has them; see `Scene.problem`.

    systems : how many systems of so many equations have been solved, by their size
    work, most_work : of all `Waves` so far, and what one may need
    """

    law: CollisionLaw
    mean_free_path: float
    state: State
    times: FloatArray
    systems: Counter[int] = field(default_factory=Counter)
    work: float = 0.0
    most_work: float = math.inf

    def flying(self, time: int) -> float:
        """exp(-T) of the slowest tracers of a start of sharp speeds at a time; 0 for densities."""
        if self.state.peaks is None:
            return 0.0
        with np.errstate(over="ignore", under="ignore"):
            path = self.times[time] * float(np.min(self.state.peaks[0])) / self.mean_free_path
            return math.exp(-path)

    def average(
        self, wave_numbers: FloatArray, which: Indices, tolerance: float,
        direction: float | None = None, collided: bool = False,
    ) -> tuple[NDArray[Any], float]:  # fmt: skip
        """F at K = k l and some of the times, (n_which, n_k), and its error, absolute.

        direction : angle of k to the x axis; None for the mean over the directions: F is real then
        collided : whether tracers that have not collided are left out
        """
        most, dimension = self.state.highest_harmonic, self.law.dimension
        kept = 0 if direction is None else 10**6 if most is None else most
        stretch = np.log(self.times[which]) - math.log(self.mean_free_path)
        speeds = points_of(self.state, 0, 1.0, tolerance)
        assert speeds is not None  # harmonic 0 is never zero
        highest = float(speeds.x.max() + stretch.max())
        # where directions count, each harmonic that is kept adds its own error
        least = (0.1 if kept else 0.3) * tolerance
        try:
            waves = Waves(self.law, wave_numbers, highest, least, kept, self.most_work)
        except OverflowError as error:
            k, most = np.array([wave_numbers.max(), error.args[0]]) / self.mean_free_path
            said = f"got up to {k:.4g}; for this law and these times some {most:.2g} per d can be"
            raise InputError(f"wave_numbers: {said} had") from None
        self.systems[waves.rule.nodes - 1] += waves.systems
        self.work += waves.work
        out = np.zeros((which.size, wave_numbers.size), dtype=complex if kept else float)
        errors = [0.0]
        for m in range(waves.values.shape[1]):
            start = points_of(self.state, m, waves.rule.width, tolerance)
            if start is None:
                continue
            for i, x in enumerate(start.x + stretch[:, None]):
                values = waves(x, m)
                if m == 0:
                    errors.append(float(start.weight @ waves.error_at(x)))
                if collided:
                    near = x < math.log(FOLDS)
                    path = np.exp(x[near])
                    free = mean_phase(np.outer(path, wave_numbers), dimension)
                    values[near] -= np.exp(-path)[:, None] * free
                mean = start.weight @ values
                out[i] += share_of_harmonic(m, mean, direction or 0.0, dimension)
        return out, max(errors)


@one_blas_thread
def scattering_function(
    averages: Averages, wave_numbers: FloatArray, direction: float | None
) -> NDArray[Any]:
    """F (n_times, n_k) at wave numbers in 1/d (n_k,); InputError where they are too large.

    Warns (ToleranceWarning) where the error estimate exceeds max(rtol, 1e-12).
    """
    path, times = averages.mean_free_path, averages.times
    with np.errstate(over="ignore"):
        scaled = wave_numbers * path
    typical = math.exp(0.5 * averages.speeds.log_second_moment()) / path
    most = _LARGEST_DELAYED if averages.law.returns(0)[0] else _LARGEST
    limit = most * max(1.0, 1.0 / max(float(times[-1]) * typical, most / _LARGEST_AT_ALL))
    if float(scaled.max()) > limit:
        raise InputError(
            f"wave_numbers: got up to {wave_numbers.max():.4g}; for these times they may reach "
            f"{limit / path:.4g} per d"
        )
    if averages.state.highest_harmonic == 0:
        direction = None
    out = np.ones((times.size, scaled.size), dtype=float if direction is None else complex)
    late = times > 0.0
    every = np.arange(np.count_nonzero(late))
    system = Scattering(averages.law, path, averages.state, times[late], most_work=_MOST_WORK)
    left = (scaled > 0.0) & bool(late.any())
    tolerance, worst = max(averages.rtol, _BEST), 0.0
    while left.any():
        # those within a factor of two share their panels, which get no narrower below K = 1/2;
        # large ones take much memory each
        largest = float(scaled[left].max())
        group = left & (scaled > largest * (0.5 if largest > 0.5 else 0.2))
        group &= np.cumsum(group) <= max(1.0, _AT_ONCE / (1.0 + largest))
        found, error = system.average(scaled[group], every, tolerance, direction)
        if error > tolerance:  # once more, with more nodes and harmonics
            asked = _ONCE_MORE * tolerance
            found, error = system.average(scaled[group], every, asked, direction)
        worst = max(worst, error)
        out[np.ix_(late, group)] = found
        left &= ~group
    if worst > tolerance:
        warn_missed("F(k, t)", worst, tolerance)
    return out
