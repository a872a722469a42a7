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
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw, impact_cells
from kinetics.densities.harmonic import Profile, count_before_scaling, then_scaling
from kinetics.errors import InputError
from kinetics.moments.velocity import Averages
from kinetics.numerics.gauss import panels_between
from kinetics.states.quadrature import LogMeasure
from kinetics.states.state import State

FloatArray = NDArray[np.float64]

_DEPTH = 12.0  # e-folds below the slowest relevant speed l/t that the axis reaches
_EMPTY = 1e-25  # of all mass: a node with less is left out at the top of the axis
_MOST_WORK = 1e11  # sweeps times nodes times nodes that a bounce reaches: about a minute
_DIRECTLY = 500_000  # products of a convolution that cost less than its transforms (measured)
_FINEST = 2e-3  # default spacing: the method is of second order


@dataclass(frozen=True)
class _Masses:
    """Masses at nodes, for output; piecewise linear in ln v between them."""

    x: FloatArray
    spacing: float
    mass: NDArray[Any]  # (n_times, nodes)

    def __call__(self, i: int, v: FloatArray) -> NDArray[Any]:
        out = np.zeros(v.shape, dtype=self.mass.dtype)
        positive = v > 0.0
        log_v, mass = np.log(v[positive]), self.mass[i]
        value: NDArray[Any] = np.interp(log_v, self.x, mass.real, left=0.0, right=0.0)
        if np.iscomplexobj(mass):
            value = value + 1j * np.interp(log_v, self.x, mass.imag, left=0.0, right=0.0)
        out[positive] = value * np.exp(-log_v) / self.spacing
        return out


def bounce_kernel(law: CollisionLaw, spacing: float, m: int) -> FloatArray:
    """Share of a node's bounces that arrive k nodes below, k = 0 ... K, times cos(m chi)."""
    q, low = impact_cells(law.restitution, spacing)
    # shares linear in v^2 between node low (upper speed) and low + 1 (lower speed)
    down = np.expm1(-2.0 * (q.log_loss - spacing * low)) / math.expm1(-2.0 * spacing)
    down = np.clip(down, 0.0, 1.0)
    weight = q.weight * q.harmonic(m)
    kernel = np.zeros(int(low.max()) + 2)
    np.add.at(kernel, low, weight * (1.0 - down))
    np.add.at(kernel, low + 1, weight * down)
    return kernel


def deposit(start: LogMeasure, x0: float, spacing: float, nodes: int) -> NDArray[Any]:
    """Masses of weighted points on the nodes, mass and energy kept."""
    mass = np.zeros(nodes, dtype=start.weight.dtype)
    level = (start.x - x0) / spacing
    low = np.clip(np.floor(level).astype(int), 0, nodes - 2)
    part = np.clip(level - low, 0.0, 1.0)
    up = np.expm1(2.0 * spacing * part) / math.expm1(2.0 * spacing)
    np.add.at(mass, low, start.weight * (1.0 - up))
    np.add.at(mass, low + 1, start.weight * up)
    return mass


def _start_masses(
    state: State, start: LogMeasure, m: int, x0: float, spacing: float, nodes: int
) -> NDArray[Any]:
    """The state on the nodes: from its density cell by cell, or point by point without one."""
    profile = state.profile(m)
    if profile is None:
        return deposit(start, x0, spacing, nodes)
    x, w = panels_between(x0 + spacing * np.arange(nodes, dtype=float), 4)
    v = np.exp(x)
    weight = w * v * profile(v)
    found = deposit(LogMeasure(x, weight), x0, spacing, nodes)
    # what lies beyond the axis, or between the points of a rough density, is not missed
    total, expected = found.sum(), start.weight.sum()
    return found * (expected / total) if m == 0 else found


class _Axis:
    """The masses on their way: nodes from the top downwards in index, so that bounces go right.

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
            # what is left behind above moves down with the rest: mass is kept
            self.mass[first] += self.mass[self.first : first].sum()
            self.mass[self.first : first] = 0.0
            self.first = first
            fastest = float(self.speed[self.first])
            # short enough for the top to empty on the way, long enough for few steps
            step = min(left, 64.0 / fastest)
            self._uniformised(step, fastest)
            left -= step

    def _uniformised(self, step: float, fastest: float) -> None:
        """exp(A step) as a Poisson average of powers of 1 + A/fastest."""
        apart = 1 if self.peak and self.first == 0 else 0
        speed = self.speed[self.first :] / fastest
        current = self.mass[self.first :]
        mean = fastest * step
        weight = math.exp(-mean)
        out = weight * current
        summed, n = weight, 0
        while 1.0 - summed > 1e-16 and n < mean + 40.0 + 12.0 * math.sqrt(mean):
            moving = speed * current
            current = current - moving
            if apart:
                moving[2] += moving[0]  # node 1 is the empty one above
            arriving = self._arriving(moving[apart:])
            room = current.size - apart
            current[apart:] += arriving[:room]
            current[-1] += arriving[room:].sum()  # the slowest node keeps what falls below
            n += 1
            weight *= mean / n
            summed += weight
            out = out + weight * current
        # the truncated Poisson weights are made to sum to 1: mass is kept to rounding
        self.mass[self.first :] = out / summed

    def _arriving(self, moving: NDArray[Any]) -> NDArray[Any]:
        """Bounces of the moving masses, past the axis's end; by transforms where that is shorter.

        They leave a rounding of the largest mass everywhere: what is above all that can have come
        from faster tracers is cut off, or the axis's empty top would never stay empty.
        """
        full = moving.size + self.kernel.size - 1
        if moving.size * self.kernel.size < _DIRECTLY or np.iscomplexobj(moving):
            return np.convolve(moving, self.kernel)
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


def solve_conservative(
    law: CollisionLaw,
    mean_free_path: float,
    state: State,
    m: int,
    times: FloatArray,
    rtol: float,
    nodes: int | None = None,
) -> Profile:
    """Harmonic m at the times, e < 1; InputError where a state is too nearly elastic for it."""
    start = state.harmonic(m, min(rtol, 1e-6))
    state_speeds = state.harmonic(0, min(rtol, 1e-6))
    if start is None or state_speeds is None:
        raise InputError(f"initial: harmonic {m} of this state is zero")
    monoenergetic = start.x.size == 1
    top = float(start.x.max())
    log_unit = 0.5 * state_speeds.log_second_moment()
    shift = np.log(times / mean_free_path + math.exp(-log_unit))
    early = count_before_scaling(law, shift + log_unit, rtol) if m == 0 else times.size
    latest = float(times[early - 1]) / mean_free_path if early else 0.0
    slowest = min(float(start.x.min()), top, -math.log(max(latest, 1e-300))) - _DEPTH
    slowest = max(slowest, top - 700.0)
    span = top - slowest
    # measured: the error is this times spacing^2. Near e = 1 the shares of a bounce spread the ring
    # of speeds, of variance (1-e^2)/5, by spacing^2 each
    coefficient = 1.6 + 0.2 / (1.0 - law.restitution) ** 2
    spacing = span / nodes if nodes else min(0.1, max(_FINEST, math.sqrt(rtol / coefficient)))
    count = math.ceil(span / spacing) + 3
    x0 = top - spacing * (count - 2)  # one empty node above the fastest tracers
    x = x0 + spacing * np.arange(count, dtype=float)
    speed = np.exp(x)[::-1]
    # the fastest tracers collide 80 times for each e-fold of time once they cool
    cooling = 80.0 * (1.0 + math.log1p(latest * math.exp(top))) / law.mean_log_loss
    sweeps = min(cooling, latest * math.exp(min(top, 700.0 - math.log(max(latest, 1.0)))))
    reach = min(float(law.quadrature.log_loss.max()), _DEPTH + 28.0) / spacing + 2.0
    if sweeps * min(count, 40.0 / spacing) * min(reach, count) > _MOST_WORK:
        raise InputError(
            f"times: got up to {times[early - 1]:g} at restitution {law.restitution!r}; the "
            f"conservative method would need {sweeps:.1e} sweeps of {count} nodes, ask for "
            "earlier times, a larger rtol, or averages only"
        )
    kernel = bounce_kernel(law, spacing, m)
    mass = _start_masses(state, start, m, x0, spacing, count)[::-1].copy()
    peak = None
    if monoenergetic:
        # the tracers that have not collided stay apart, in one more node
        mass = np.concatenate([start.weight, np.zeros(count, dtype=mass.dtype)])
        speed = np.concatenate([speed[1:2], speed])
        with np.errstate(over="ignore", under="ignore"):
            peak = start.weight[0] * np.exp(-math.exp(top) * times / mean_free_path)
    axis = _Axis(speed, kernel, mass, monoenergetic)
    out = np.empty((early, count), dtype=mass.dtype)
    now = 0.0
    for i, t in enumerate(times[:early]):
        axis.advance((t - now) / mean_free_path)
        now = t
        out[i] = axis.mass[-count:][::-1]
    averages = Averages(law, mean_free_path, state, times[:early], min(rtol, 1e-6), 2.0)
    return Profile(
        at=then_scaling(law, _Masses(x, spacing, out), early, shift[early:], rtol),
        count=times.size,
        method="conservative",
        nodes=count,
        error_estimate=max(coefficient * spacing**2, _moment_error(averages, x, out, peak, top)),
        peak_speed=math.exp(top) if monoenergetic else None,
        peak_weight=peak,
    )


def _moment_error(
    averages: Averages, x: FloatArray, mass: NDArray[Any], peak: NDArray[Any] | None, top: float
) -> float:
    """Largest relative error of <v> and <v^2> of the masses, against the backward equation.

    Only for the isotropic part; 0 for the harmonics, which share its spacing.
    """
    if np.iscomplexobj(mass) or mass.shape[0] == 0:
        return 0.0
    worst = 0.0
    for p in (1.0, 2.0):
        reference = averages.power(p)
        for i, log_v in enumerate(averages.log_reference):
            with np.errstate(under="ignore"):
                found = float(mass[i] @ np.exp(p * np.minimum(x - log_v, 170.0)))
                if peak is not None:
                    found += float(peak[i].real) * math.exp(p * min(top - float(log_v), 170.0))
            worst = max(worst, abs(found / float(reference[i].real) - 1.0))
    return worst
