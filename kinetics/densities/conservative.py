r"""The speed density in time, conservatively: for steps, delta peaks and noisy tables.

The state is a set of masses at equidistant x = ln v. A bounce takes a mass at v to s v, which is
shared between the two nodes around it so that mass and energy are exactly those of the bounce; the
shares are not negative. Nodes lose mass at the rate v/l. What results is a linear system with a
matrix of non-negative off-diagonal entries, whose exponential is summed by uniformisation, from
non-negative terms only: no mass is ever below 0, the sum of the masses is kept to rounding, and the
energy obeys d<v^2>/dt = -lambda(2) <v^3>/l with the exact lambda(2). Second order in the spacing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.collision.memory import common_loss
from kinetics.densities.conservative_errors import (
    COARSEST,
    guessed_error,
    moment_error,
    remembered_error,
    sharing_error,
)
from kinetics.densities.harmonic import HarmonicProblem, Profile, count_before_scaling, then_scaling
from kinetics.densities.node_masses import NodeMasses, bounce_kernel, deposit
from kinetics.errors import InputError
from kinetics.moments.velocity import Averages
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import panels_between
from kinetics.states.quadrature import LogMeasure
from kinetics.states.state import State

# The axis ends this far below the slowest speed that matters, l/t: e^-12 of its tracers collide.
_DEPTH = 12.0
_LOWEST = 700.0  # e-folds below the fastest tracers: there the range of doubles ends
# Sweeps for each e-fold of time in which tracers cool: tests/kinetics/measurements/densities.py
_SWEEPS = 80.0
_DIRECTLY = 500_000  # products of a convolution that cost less than its transforms
_FINEST = 2e-3  # spacing that the solver chooses by itself; the widest is COARSEST
_BEST_START = 1e-6  # the start need not be better known than that
_EMPTY = 1e-25  # of all mass: a node with less is left out at the top of the axis
# Collisions of the fastest tracers in one step: so few that the top of the axis empties on the way,
# so many that the tail of the Poisson distribution, 40 + 12 sqrt(64) sweeps at most, costs little.
_STEP = 64.0
_DEEPEST = 40.0  # -ln s of the deepest bounce in the estimate of the work
# Returns to the scatterer before reach far down: the products that a transform costs for each node.
_TRANSFORMED = 300.0
_MOST_WORK = 1e11  # sweeps times nodes times nodes that a bounce reaches: about a minute


def _start_masses(state: State, start: LogMeasure, m: int, nodes: _Nodes) -> NDArray[Any]:
    """The state on the nodes: from its density cell by cell, or point by point without one."""
    profile = state.profile(m)
    if profile is None:
        return deposit(start, nodes.first, nodes.spacing, nodes.count)
    x, w = panels_between(nodes.x, 4)
    v = np.exp(x)
    weight = w * v * profile(v)
    found = deposit(LogMeasure(x, weight), nodes.first, nodes.spacing, nodes.count)
    if m:
        return found
    total, expected = float(found.sum()), float(start.weight.sum())
    if total < 0.5 * expected:
        # the density lies between the Gauss points
        return deposit(start, nodes.first, nodes.spacing, nodes.count)
    # scaled to the mass of the start: some lies beyond the axis, or between the Gauss points
    return found * (expected / total)


class _Axis:
    """The masses as they move: node 0 is the fastest, so that bounces raise the index.

    With ``peak``, node 0 holds the tracers of one speed that have not collided, and node 2 has the
    same speed: bounces from node 0 start at node 2, and nothing returns.
    """

    def __init__(
        self, speed: FloatArray, kernel: FloatArray, mass: NDArray[Any], peak: bool
    ) -> None:
        self.speed, self.kernel, self.mass, self.peak = speed, kernel, mass, peak
        self.first = 0  # nodes above it are empty
        self._transformed: tuple[int, NDArray[Any]] | None = None  # the kernel, and its length
        self.total = float(np.abs(mass).sum())
        # masses of harmonics m > 0 may have any sign
        self.positive = bool(kernel.min() >= 0.0 and not np.iscomplexobj(mass) and mass.min() >= 0)

    def advance(self, duration: float) -> None:
        """By this many l/U."""
        left = duration
        while left > 1e-15 * duration:
            live = np.nonzero(np.abs(self.mass) > _EMPTY * self.total)[0]
            first = int(live[0]) if live.size else self.first
            # the nodes above hold next to nothing: it is added to the first node that is kept
            self.mass[first] += self.mass[self.first : first].sum()
            self.mass[self.first : first] = 0.0
            self.first = first
            fastest = float(self.speed[self.first])
            # short enough for the top to empty on the way, long enough for few steps
            step = min(left, _STEP / fastest)
            self._uniformised(step, fastest)
            left -= step

    def _uniformised(self, step: float, fastest: float) -> None:
        """exp(A step) as a Poisson average of powers of 1 + A/fastest."""
        apart = 1 if self.peak and self.first == 0 else 0
        speed = self.speed[self.first :] / fastest
        current = self.mass[self.first :].copy()
        mean = fastest * step
        weight = math.exp(-mean)
        out = weight * current
        summed, n = weight, 0
        # beyond 12 standard deviations of the Poisson distribution the weights are e^-72
        while 1.0 - summed > 1e-16 and n < mean + 40.0 + 12.0 * math.sqrt(mean):
            moving = speed * current
            current -= moving
            if apart:
                moving[2] += moving[0]  # node 1 is the empty one above
            arriving = self._arriving(moving[apart:])
            room = current.size - apart
            current[apart:] += arriving[:room]
            current[-1] += arriving[room:].sum()  # the slowest node keeps what falls below
            n += 1
            weight *= mean / n
            summed += weight
            out += weight * current
        # the truncated Poisson weights are made to sum to 1: mass is kept to rounding
        self.mass[self.first :] = out / summed

    def _arriving(self, moving: NDArray[Any]) -> NDArray[Any]:
        """Bounces of the moving masses, past the axis's end; by transforms where that is shorter.

        They leave a rounding of the largest mass everywhere: what is above all that can have come
        from faster tracers is cut off, or the axis's empty top would never stay empty.
        """
        full = moving.size + self.kernel.size - 1
        if moving.size * self.kernel.size < _DIRECTLY or np.iscomplexobj(moving):
            # what np.convolve does, without its checks
            return np.correlate(moving, self.kernel[::-1], "full")
        if self._transformed is None or self._transformed[0] < full:
            from scipy.fft import next_fast_len

            size = int(next_fast_len(full, real=True))
            self._transformed = size, np.fft.rfft(self.kernel, size)
        size, kernel = self._transformed
        found = np.fft.irfft(np.fft.rfft(moving, size) * kernel, size)[:full]
        most = np.full(full, float(np.abs(self.kernel).max()))
        above = np.cumsum(np.abs(moving))
        most[: moving.size] *= above
        most[moving.size :] *= above[-1]
        return np.clip(found, 0.0 if self.positive else -most, most)


@dataclass(frozen=True)
class _Nodes:
    """The nodes of an axis: x = ln v = first + spacing * (0 ... count - 1)."""

    first: float
    spacing: float
    count: int

    @property
    def x(self) -> FloatArray:
        return self.first + self.spacing * np.arange(self.count, dtype=float)


def _choose_nodes(
    law: CollisionLaw,
    start: LogMeasure,
    path: float,
    peaks: bool,
    rtol: float,
    nodes: int | None,
) -> tuple[_Nodes, float]:
    """An axis from above the fastest tracers down to those that hardly move, and its work.

    path : of a tracer of speed U until the last time, in l
    peaks : whether the start is one of delta peaks

    The work is in products of masses with shares of bounces.
    """
    top = float(start.x.max())
    lowest = min(float(start.x.min()), top, -math.log(max(path, 1e-300))) - _DEPTH
    span = min(top - lowest, _LOWEST)
    coefficient = guessed_error(law, 1.0, path * math.exp(min(top, 300.0)), peaks)
    wanted = max(_FINEST, math.sqrt(rtol / coefficient))
    spacing = span / nodes if nodes else min(COARSEST, wanted)
    common = common_loss(law, math.pi / spacing)
    if common is not None:
        # whole numbers of nodes in every bounce: no share of it is lost to neighbours
        spacing = common / math.ceil(common / spacing)
    count = math.ceil(span / spacing) + 3
    cooling = _SWEEPS * (1.0 + math.log1p(path * math.exp(top))) / law.mean_log_loss
    sweeps = min(cooling, path * math.exp(min(top, 700.0 - math.log(max(path, 1.0)))))
    deepest = min(float(law.quadrature.log_loss.max()), _DEEPEST)
    reach = deepest / spacing + 2.0
    if law.returns(0)[0]:
        reach = max(reach, _TRANSFORMED)
    work = sweeps * min(count, _DEEPEST / spacing) * min(reach, count)
    # one empty node above the fastest tracers
    return _Nodes(top - spacing * (count - 2), spacing, count), work


def solve_conservative(asked: HarmonicProblem) -> Profile:
    """The harmonic at the times, of a start of any kind, e < 1.

    Raises InputError where following the state would take too long, or its harmonic m is zero.
    """
    law, state, m, times, rtol = asked.law, asked.state, asked.m, asked.times, asked.rtol
    mean_free_path, start_rtol = asked.mean_free_path, min(rtol, _BEST_START)
    start, speeds = state.harmonic(m, start_rtol), state.harmonic(0, start_rtol)
    if start is None or speeds is None:
        raise InputError(f"initial: harmonic {m} of this state is zero")
    log_unit = 0.5 * speeds.log_second_moment()
    shift = np.log(times / mean_free_path + math.exp(-log_unit))
    early = times.size if m else count_before_scaling(asked, speeds, shift + log_unit)
    paths = times[:early] / mean_free_path
    path, peaks = float(paths[-1]) if early else 0.0, state.profile(0) is None
    if peaks and (law.has_atoms or law.returns(0)[0]):
        raise InputError(
            "initial: from sharp speeds, bounces that take single shares of the speed (samples, "
            "et = e, or straight back to the scatterer before, at a finite density) make delta "
            "peaks and no density; give a SpeedTable, or ask for averages"
        )
    axis, work = _choose_nodes(law, start, path, peaks, rtol, asked.nodes)
    if work > _MOST_WORK:
        raise InputError(
            f"times: got up to {times[early - 1]:g} at {law.described}; the "
            f"conservative method would need {work:.1e} products on {axis.count} nodes, ask for "
            "earlier times, a larger rtol, or averages only"
        )
    kernel, mass = bounce_kernel(law, axis.spacing, m), _start_masses(state, start, m, axis)
    uncollided = start.weight if start.x.size == 1 else None
    found = NodeMasses(axis.x, axis.spacing, _follow(axis, mass, kernel, paths, uncollided))
    error = sharing_error(law, found, paths, state)
    error = max(error, remembered_error(asked, speeds, axis.spacing, paths))
    peak_speed, peak_weight = None, None
    if uncollided is not None:
        peak_speed = math.exp(float(start.x[0]))
        with np.errstate(over="ignore", under="ignore"):
            peak_weight = uncollided[0] * np.exp(-peak_speed * times / mean_free_path)
    averages = Averages(law, mean_free_path, state, times[:early], start_rtol, 2.0)
    profile = Profile(found, early, "conservative", axis.count, 0.0, peak_speed, peak_weight)
    return replace(
        profile,
        density=then_scaling(law, found, early, shift[early:], rtol),
        count=times.size,
        # harmonics m > 0 have no moments of one sign to compare
        error_estimate=error if m else max(error, moment_error(averages, profile)),
    )


def _follow(
    nodes: _Nodes,
    mass: NDArray[Any],
    kernel: FloatArray,
    paths: FloatArray,
    uncollided: NDArray[Any] | None,
) -> NDArray[Any]:
    """The masses at times in l/U, (n_times,): shape (n_times, n_nodes).

    mass : at the start, shape (n_nodes,)
    uncollided : weight of the start, shape (1,), where all its tracers have one speed
    """
    speed, moving = np.exp(nodes.x)[::-1], mass[::-1].copy()
    if uncollided is not None:
        # the tracers that have not collided stay apart, in one more node of their speed
        moving = np.concatenate([uncollided, np.zeros(nodes.count, dtype=mass.dtype)])
        speed = np.concatenate([speed[1:2], speed])
    axis = _Axis(speed, kernel, moving, uncollided is not None)
    out = np.empty((paths.size, nodes.count), dtype=mass.dtype)
    now = 0.0
    for i, path in enumerate(map(float, paths)):
        axis.advance(path - now)
        now = path
        out[i] = axis.mass[-nodes.count :][::-1]
    out.flags.writeable = False
    return out
