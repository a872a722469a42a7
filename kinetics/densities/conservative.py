r"""The speed density in time, conservatively: for steps, delta peaks and noisy tables.

The state is a set of masses at equidistant x = ln v. A bounce takes a mass at v to s v, which is
shared between the two nodes around it so that mass and energy are exactly those of the bounce.
Nodes lose mass at the rate v/l. The exponential of this linear system is summed by uniformisation,
from non-negative terms only: no mass is ever below 0, their sum is kept to rounding, and the energy
obeys d<v^2>/dt = -lambda(2) <v^3>/l with the exact lambda(2). Second order in the spacing.

Near steps and infinities of f no nodes give f itself. What is kept to rtol is the share of the
tracers that are slower than v, for every v. Its error is the difference of two spacings, times a
stated factor.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.densities.harmonic import HarmonicProblem, Profile
from kinetics.errors import InputError
from kinetics.numerics import FOLDS, LARGEST_LOG, ROUNDING, FloatArray
from kinetics.numerics.gauss import panels_between
from kinetics.results.value import Value
from kinetics.states.state import LogMeasure, State

# Of the spacing: the first one tried, and the finest; each next one is half of the one before.
_COARSEST = 0.128
_FINEST = _COARSEST / 2**8
# The error over the difference of two spacings. The first bounces from sharp speeds make inverse
# square roots, whose distribution function converges as sqrt(h): 1/(sqrt(2) - 1) = 2.4, and more
# where the front lies badly between the nodes. Steps and kinks converge as h at least: 1.
_SHARP, _ROUGH = 4.0, 2.0
_MOST_WORK = 1e10  # products of masses with shares of bounces: a second or two
_TRANSFORMED = 300  # shares of bounces from which on transforms are quicker, and what they cost
_DEPTH = 12.0  # the axis ends e^-12 below the slowest speed that matters, l/t
_EMPTY = 1e-25  # of all mass: a node with less is left out at the top of the axis
# Collisions of the fastest tracers in one step: so few that the top of the axis empties on the way,
# so many that the tail of the Poisson distribution, 40 + 12 sqrt(64) sweeps at most, costs little.
_STEP = 64.0
_NODES_OF_A_CELL = 16.0  # radians of s^z on one cell, so that losses lie a tenth of it apart


@dataclass(frozen=True, eq=False, repr=False)
class NodeMasses(Value):
    """Masses at nodes in ln v: the density of ln v is linear between them.

    x : ln v at the nodes, equidistant, shape (n_nodes,)
    spacing : of the nodes
    mass : shape (n_times, n_nodes)
    sharp : share of ``mass`` that tracers of sharp speeds have which have not collided, the same
        shape; None without sharp speeds
    """

    x: FloatArray
    spacing: float
    mass: NDArray[Any]
    sharp: NDArray[Any] | None = None

    def at(self, i: int, v: FloatArray) -> NDArray[Any]:
        """In 1/U at the i-th time and speeds v in U, shape (n_v,)."""
        out = np.zeros(v.shape, dtype=self.mass.dtype)
        positive = v > 0.0
        log_v = np.log(v[positive])
        # by the root twice: 1/v alone may be larger than the largest number
        root = np.exp(-0.5 * log_v)
        out[positive] = self.of_log(i, log_v) * root * root
        return out

    def of_log(self, i: int, x: FloatArray) -> NDArray[Any]:
        """The density of ln v at the i-th time and ln v = x, shape of x (n,)."""
        return np.interp(x, self.x, self.mass[i], left=0.0, right=0.0) / self.spacing


def deposit(points: LogMeasure, x: FloatArray, spacing: float) -> NDArray[Any]:
    """Masses of weighted points on the nodes x, mass and energy kept."""
    mass = np.zeros(x.size, dtype=points.weight.dtype)
    level = (points.x - x[0]) / spacing
    low = np.clip(np.floor(level).astype(int), 0, x.size - 2)
    part = np.clip(level - low, 0.0, 1.0)
    up = np.expm1(2.0 * spacing * part) / math.expm1(2.0 * spacing)
    np.add.at(mass, low, points.weight * (1.0 - up))
    np.add.at(mass, low + 1, points.weight * up)
    return mass


def _start_masses(
    state: State, start: LogMeasure, m: int, nodes: FloatArray, spacing: float
) -> NDArray[Any]:
    """The state on the nodes: from its density cell by cell, or point by point without one."""
    profile = state.profile(m)
    if profile is None:
        return deposit(start, nodes, spacing)
    # eight pieces of a cell, for the steps of a density
    x, w = panels_between(np.linspace(nodes[0], nodes[-1], 8 * nodes.size - 7), 4)
    v = np.exp(x)
    found = deposit(LogMeasure(x, w * v * profile(v)), nodes, spacing)
    if m:
        return found
    total, expected = float(found.sum()), float(start.weight.sum())
    if total < 0.5 * expected:  # the density lies between the Gauss points
        return deposit(start, nodes, spacing)
    # scaled to the mass of the start: some lies beyond the axis, or between the Gauss points
    return found * (expected / total)


class _Axis:
    """The masses as they move: node 0 is the fastest, so that bounces raise the index."""

    def __init__(self, speed: FloatArray, kernel: FloatArray, mass: NDArray[Any]) -> None:
        self.speed, self.kernel, self.mass = speed, kernel, mass
        self.first = 0  # nodes above it are empty
        self.total = float(np.abs(mass).sum())
        self.work = 0.0  # products so far
        # masses of harmonics m > 0 may have any sign
        self.positive = bool(kernel.min() >= 0.0 and not np.iscomplexobj(mass) and mass.min() >= 0)

    def advance(self, duration: float) -> None:
        """By this many l/U."""
        left = duration
        while left > 1e-15 * duration and self.work <= _MOST_WORK:
            live = np.nonzero(np.abs(self.mass) > _EMPTY * self.total)[0]
            first = int(live[0]) if live.size else self.first
            # the nodes above hold next to nothing: it is added to the first node that is kept
            self.mass[first] += self.mass[self.first : first].sum()
            self.mass[self.first : first] = 0.0
            self.first = first
            fastest = float(self.speed[first])
            step = min(left, _STEP / fastest)
            self._uniformised(step, fastest)
            left -= step

    def _uniformised(self, step: float, fastest: float) -> None:
        """exp(A step) as a Poisson average of powers of 1 + A/fastest."""
        speed = self.speed[self.first :] / fastest
        current = self.mass[self.first :].copy()
        mean = fastest * step
        weight = math.exp(-mean)
        out, summed, n = weight * current, weight, 0
        # beyond 12 standard deviations of the Poisson distribution the weights are e^-72
        while 1.0 - summed > 1e-16 and n < mean + 40.0 + 12.0 * math.sqrt(mean):
            moving = speed * current
            current -= moving
            arriving = self._arriving(moving)
            current += arriving[: current.size]
            current[-1] += arriving[current.size :].sum()  # the slowest node keeps what falls below
            n += 1
            weight *= mean / n
            summed += weight
            out += weight * current
        # the truncated Poisson weights are made to sum to 1: mass is kept to rounding
        self.mass[self.first :] = out / summed

    def _arriving(self, moving: NDArray[Any]) -> NDArray[Any]:
        """Bounces of the moving masses, past the end of the axis; by transforms where shorter."""
        self.work += 1e4 + moving.size * min(self.kernel.size, _TRANSFORMED)  # 1e4: of each sweep
        if self.kernel.size < _TRANSFORMED:
            # what np.convolve does, without its checks
            return np.correlate(moving, self.kernel[::-1], "full")
        from scipy.signal import fftconvolve

        found = np.asarray(fftconvolve(moving, self.kernel))
        size = np.abs(found)
        found[size < 4.0 * ROUNDING * size.max()] = 0.0  # else the top of the axis never empties
        return np.maximum(found, 0.0) if self.positive else found


def solve_conservative(asked: HarmonicProblem) -> Profile:
    """The harmonic at the times, of a start of any kind, e < 1.

    Raises InputError where following the state would take too long.
    """
    law, state, times = asked.law, asked.state, asked.times
    start = state.harmonic(asked.m, min(asked.rtol, 1e-6))  # it need not be better known
    assert start is not None  # harmonics that are zero are not asked for
    if law.returns(0)[0]:
        raise InputError("initial: at a finite density, speed densities need a smooth start")
    if state.profile(0) is None and law.has_atoms:
        raise InputError(
            "initial: from sharp speeds, bounces that take single shares of the speed (samples, "
            "et = e) make delta peaks and no density; give a SpeedTable, or ask for averages"
        )
    paths = times / asked.mean_free_path
    top = float(start.x.max())
    lowest = min(float(start.x.min()), top, -math.log(max(float(paths[-1]), 1e-300))) - _DEPTH
    span = min(top - lowest, LARGEST_LOG)
    spacing, finest = _COARSEST, _FINEST
    if asked.nodes:
        spacing, finest = 2.0 * span / asked.nodes, span / asked.nodes
    safe = _SHARP if state.profile(0) is None else _ROUGH
    # of the tracers that have left a single speed, or a billionth of all
    left = -np.expm1(-math.exp(top) * paths) if start.x.size == 1 else np.ones(paths.size)
    held = np.maximum(left, 1e-9)
    found, error = _solve(asked, start, paths, span, spacing), math.inf
    while found is not None and error > asked.rtol and spacing > 1.01 * finest:
        before, spacing = found, 0.5 * spacing
        finer = _solve(asked, start, paths, span, spacing)
        if finer is None:
            break
        found = finer
        error = safe * float(np.max(_apart(before, found) / held))
    if found is None or error == math.inf:
        raise InputError(
            f"times: got up to {asked.times[-1]:g} at {asked.law.described}; the conservative "
            "method would take too long, ask for earlier times, fewer nodes, or averages only"
        )
    peak_speed, peak_weight = None, None
    if start.x.size == 1:
        peak_speed = math.exp(top)
        with np.errstate(over="ignore", under="ignore"):
            peak_weight = start.weight[0] * np.exp(-peak_speed * paths)
    return Profile(found, times.size, "conservative", found.x.size, error, peak_speed, peak_weight)


def _solve(
    asked: HarmonicProblem, start: LogMeasure, paths: FloatArray, span: float, spacing: float
) -> NodeMasses | None:
    """The masses at times in l/U with this spacing; None where it would take too long."""
    count = math.ceil(span / spacing) + 3
    # one empty node above the fastest tracers; a density may go on beyond its last Gauss point,
    # by less than that is from the one before
    top = float(start.x.max())
    if asked.state.profile(0) is not None:
        top += spacing + float(np.diff(np.sort(start.x)[-2:]).sum())
    x = top + spacing * np.arange(2 - count, 2, dtype=float)
    mass = _start_masses(asked.state, start, asked.m, x, spacing)
    # share of a node's bounces that arrive k nodes below, k = 0 ... K, times cos(m chi)
    q = asked.law.quadrature_for(_NODES_OF_A_CELL / spacing)
    below = np.minimum(q.log_loss, FOLDS)
    last = math.ceil(float(below.max()) / spacing) + 1
    points = LogMeasure(-below, q.weight * (1.0 - q.harmonic_loss(asked.m)))
    kernel = deposit(points, spacing * np.arange(-last, 1.0), spacing)[::-1]
    axis = _Axis(np.exp(x)[::-1], kernel, mass[::-1].copy())
    out = np.empty((paths.size, count), dtype=mass.dtype)
    for i, duration in enumerate(map(float, np.diff(paths, prepend=0.0))):
        axis.advance(duration)
        if axis.work > _MOST_WORK:
            return None
        out[i] = axis.mass[::-1]
    if start.x.size == 1:  # those that have not collided are known, and left out
        with np.errstate(under="ignore"):
            out[:, -2] -= start.weight[0] * np.exp(-math.exp(top) * paths)
        if axis.positive:
            out[:, -2] = np.maximum(out[:, -2], 0.0)  # what is below is rounding
    out.flags.writeable = False
    sharp = None
    if start.x.size > 1 and asked.state.profile(0) is None:
        with np.errstate(under="ignore"):
            sharp = mass * np.exp(-np.outer(paths, np.exp(x)))
    return NodeMasses(x, spacing, out, sharp)


def _apart(coarse: NodeMasses, fine: NodeMasses) -> FloatArray:
    """The largest difference of two distribution functions, over all speeds, (n_times,)."""
    both = enumerate(fine.mass)
    change = np.array([coarse.of_log(i, fine.x) * fine.spacing - mass for i, mass in both])
    summed = np.cumsum(0.5 * (change[:, 1:] + change[:, :-1]), axis=1)
    return np.asarray(np.abs(summed).max(axis=1))
