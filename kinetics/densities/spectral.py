r"""The speed density in time: the forward equation on a logarithmic speed axis, spectrally.

On equidistant nodes of x = ln v a smooth density is resolved to rounding by some hundred of them.
Its collisions are taken out of the equation (:mod:`kinetics.densities.intertwining`), so that any
time follows at once. The error is the difference of two such solutions, on nodes of which some
coincide.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.densities.gain import log_gain
from kinetics.densities.harmonic import HarmonicProblem, Profile
from kinetics.densities.intertwining import intertwine
from kinetics.densities.turned_axis import SHARE_OF_SMALL_ERROR as SHARE
from kinetics.densities.turned_axis import TAPER_WIDTH as TAPER
from kinetics.densities.turned_axis import choose_angle
from kinetics.errors import InputError
from kinetics.numerics import FOLDS, ROUNDING, ComplexArray, FloatArray
from kinetics.numerics.chebyshev import barycentric_weights, interpolation_rows
from kinetics.numerics.log_grid import LogGrid
from kinetics.results.value import Value
from kinetics.scaling.mellin import extent_of
from kinetics.states.state import LogMeasure, SpeedFunction

# Limits of the work: nodes, and values at nodes and times (a quarter of a gigabyte).
_MOST_NODES, _MOST_VALUES = 40_000, 3e7
# The solution has 5 nodes where the one that it is compared with has 4, and that one's window ends
# by so many e-folds of the speed higher up.
_FINE, _COARSE, _HIGHER = 5, 4, 2.0
# Where so many are too few, less is aimed at, up to this: the other method has no such digits.
_EASIEST = 1e-4
_BELOW_AIM = 6.0  # e-folds below what is aimed at, where the window ends
# What is aimed at, of rtol, and the tilt. Where v t/l goes on oscillating, or tracers forwards, u
# oscillates at low speeds, or stays, for long: with a tilt it falls, but rounding grows as t^tilt.
_AIMS = ((1.0, 0.0), (0.03, 0.25))
# The least error that is claimed: for the rounding that two solutions may have in common (2e-13 was
# seen), and of what is aimed at, below which the low end is cut off. One with which all is lost.
_FLOOR, _CUT, _LOST = 5e-13, 0.1, 0.1
# Of the root mean square speed: above it a density keeps its accuracy relative to its maximum, and
# below it the density of ln v does.
_LOWEST_SPEED = 1e-2
# Harmonics m > 0 die away: their errors are relative to a density of ln v with this maximum; the
# isotropic one has a larger.
_LEAST_MAXIMUM = 0.3
# Where s may fall below the first, bounces fill the low speeds up to v^1 in the density of ln v,
# and harmonics m > 0, without their collisions, fall at low speeds as v^0.6 at the slowest.
_SMALL_RATIO, _SLOWEST = 0.3, 0.6
# Where bounces lead to any speed: those from which f is continued down, over the lowest of them.
_SPEEDS = np.array([1.0, 2.0, 4.0, 8.0, 16.0])


@dataclass(frozen=True, eq=False, repr=False)
class GridDensity(Value):
    """g = v f, the density of ln v, at equidistant nodes of x = ln v + shift.

    grid : the nodes of x
    values : g at the nodes, shape (n_times, n_nodes)
    shift : x - ln v, shape (n_times,)
    start, end : lowest and highest x where something is left; the nodes may reach further
    resolved : share of its maximum down to which g is right
    filled : ln v below which f is a polynomial in v, (n_times,); None where it is not
    """

    grid: LogGrid
    values: NDArray[Any]
    shift: FloatArray
    start: float
    end: float
    resolved: float
    filled: FloatArray | None = None

    def at(self, i: int, v: FloatArray) -> NDArray[Any]:
        """f in 1/U at the i-th time and speeds v in U, shape (n_v,)."""
        out = np.zeros(v.shape, dtype=self.values.dtype)
        shift = self.shift[i]
        with np.errstate(divide="ignore"):
            x = np.log(v) + shift
        inside = (x <= self.end) & (v > 0.0)
        floor, slope = self._low_end(i)
        at = np.clip(x[inside], floor, self.end)
        with np.errstate(under="ignore"):
            # by the root twice: 1/v alone may be larger than the largest number
            root = np.exp(0.5 * (slope * (x[inside] - at) - (at - shift)))
            out[inside] = self._interpolate(i, at) * root * root
            if self.filled is not None:
                # g has f with its rounding over v: five values higher up have more of it
                first = float(self.filled[i])
                low = (x < first + shift) & (v > 0.0)
                known = first + np.log(_SPEEDS)
                rows = interpolation_rows(
                    np.exp(x[low] - shift - first)[:, None] - _SPEEDS, barycentric_weights(_SPEEDS)
                )
                out[low] = rows @ (self._interpolate(i, known + shift) * np.exp(-known))
        return out

    def _low_end(self, i: int) -> tuple[float, float]:
        """Lowest x at which g is resolved, and the slope of ln(g/v) there, not below 0."""
        size, x = np.abs(self.values[i]), self.grid.x
        first = int(((x >= self.start) & (size >= self.resolved * size.max())).argmax())
        # one e-fold further up, for the slope
        second = min(first + max(1, round(1.0 / self.grid.spacing)), size.size - 1)
        low, high = np.log(np.maximum(size[[first, second]], 1e-300))
        rise = (high - low) / max(x[second] - x[first], self.grid.spacing)
        return float(x[first]), max(0.0, float(rise) - 1.0)

    def _interpolate(self, i: int, x: FloatArray, terms: int = 1_000_000) -> NDArray[Any]:
        """In pieces of x with so many terms of the Fourier sum, so that memory stays flat."""
        both = _rows(self.values[i])
        pieces = np.array_split(x, 1 + x.size * self.grid.nodes // terms)
        return _whole(np.hstack([self.grid.interpolate(both, piece) for piece in pieces]))


def _rows(values: NDArray[Any]) -> FloatArray:
    """Real and imaginary part, or the real one alone, as rows."""
    return np.stack([values.real, values.imag]) if np.iscomplexobj(values) else values[None]


def _whole(rows: FloatArray) -> NDArray[Any]:
    """The opposite, for rows on the last axis but one."""
    if rows.shape[-2] == 1:
        return rows[..., 0, :]
    return np.asarray(rows[..., 0, :] + 1j * rows[..., 1, :])


@dataclass(frozen=True)
class _Problem:
    """What is asked, and the start as this method takes it."""

    asked: HarmonicProblem
    aim: float  # the accuracy that is aimed at
    tilt: float  # v^tilt f is what is solved for
    start: SpeedFunction  # f_m as a function of v in U
    speeds: LogMeasure  # the initial ones
    log_unit: float  # ln of the root mean square of those, here the unit of speed
    tau: FloatArray  # ln(1 + v_rms t/l), (n_times,)

    def gain(self, k: FloatArray) -> ComplexArray:
        """ln of the gain at wave numbers."""
        return log_gain(self.asked.law, k, self.asked.m, self.tilt)

    def on(self, grid: LogGrid) -> FloatArray:
        """v^tilt g at the nodes of ln v in that unit, shape (1 or 2, nodes)."""
        v = np.exp(grid.x + self.log_unit)
        g = np.asarray(self.start(v) * v)
        if self.asked.m == 0:
            g = g / (float(g.sum()) * grid.spacing)  # some of the mass lies beyond the window
        return _rows(g) * np.exp(self.tilt * grid.x)


def solve_spectral(asked: HarmonicProblem) -> Profile | None:
    """The harmonic at the times, e < 1; None where the state is too rough for this method.

    Nodes that are given count as the next multiple of ten. Raises InputError where it would take
    too many nodes.
    """
    law, m, rtol = asked.law, asked.m, asked.rtol
    speeds, start = asked.state.harmonic(0, 1e-3 * rtol), asked.state.profile(m)
    if speeds is None or start is None:
        return None
    log_unit = 0.5 * speeds.log_second_moment()
    tau = np.log(asked.times / asked.mean_free_path + math.exp(-log_unit)) + log_unit
    late = asked.nodes is not None or float(tau[-1]) > FOLDS
    problem = _Problem(asked, rtol, 0.0, start, speeds, log_unit, tau)
    easier = [10.0**n * rtol for n in range(2, 15, 2) if 10.0**n * rtol <= _EASIEST]
    best: Profile | None = None
    for aim, tilt in _AIMS[:1] if late else _AIMS:
        found, refused = None, None
        for one in (rtol, *easier) if best is None and asked.nodes is None else (rtol,):
            aimed = max(aim * one, 50.0 * ROUNDING)
            try:
                found, refused = _solve(replace(problem, aim=aimed, tilt=tilt)), None
            except InputError as error:  # too many nodes
                refused = error
            if found is not None:
                break
        if best is None and refused is not None:
            raise refused
        if found is None:
            break
        if best is None or found.error_estimate < best.error_estimate:
            best = found
        if best.error_estimate <= rtol:
            break
    other = asked.nodes is None and law.medium is None  # there is another method
    return None if other and best is not None and best.error_estimate > _LOST else best


def _solve(problem: _Problem) -> Profile | None:
    """Its solution; None where the start is too rough, InputError where nodes are too many."""
    asked, law, m, tau = problem.asked, problem.asked.law, problem.asked.m, problem.tau
    aim, tilt = problem.aim, problem.tilt
    low, high, band = _window(law, problem.speeds, aim, float(tau[-1]))
    narrow = _resolve(problem, low, high, band)
    if narrow is None:
        return None
    grid, angle = _choose_grid(problem, narrow)
    gain, pole = problem.gain(grid.wave_numbers), m == 0 and not tilt
    moved, rows = intertwine(grid, problem.on(grid), gain, angle, pole).at(tau, _FINE)
    down = moved * grid.spacing
    # the other solution: the same wave numbers, but fewer of them, and a window higher up
    few = np.unique(np.linspace(0, tau.size - 1, min(tau.size, 6)).astype(int))
    unit = _FINE * grid.spacing  # both grids move by multiples of it
    skipped, nodes = math.ceil(_HIGHER / unit), grid.nodes // _FINE * _COARSE
    other = LogGrid(grid.start + skipped * unit, unit / _COARSE, nodes)
    hidden = intertwine(other, problem.on(other), gain[: nodes // 2 + 1], angle, pole)
    g, h = _whole(rows), _whole(hidden.at(tau[few], _COARSE)[1])
    bounded = m == 0 or law.least_ratio >= _SMALL_RATIO or tilt > 0.0
    first = low if bounded else grid.start
    if tilt:
        g = g * np.exp(-tilt * (grid.x - down[:, None])) * (grid.x >= first)
        h = h * np.exp(-tilt * (other.x - down[few, None])) * (other.x >= first)
    common = slice(_FINE * skipped, None, _FINE)
    apart = np.abs(g[few, common] - h[:, : nodes - _COARSE * skipped : _COARSE])
    # per speed, but below the lowest one, ln v = lowest, per its logarithm: speeds cool nearly as
    # 1/(1 + h t/2); the least maximum is where most are
    rate = math.sqrt(law.mean_log_loss * float(law.decay_rate(1.0)))
    lowest = math.log(_LOWEST_SPEED) - np.log1p(rate * np.expm1(tau))
    floor = (lowest + down)[few, None]
    least = 0.0 if m == 0 else _LEAST_MAXIMUM
    per_speed = np.exp(-np.maximum(grid.x, floor))
    top = (np.abs(g[few]) * per_speed).max(axis=1)
    top = np.maximum(top, least * _LOWEST_SPEED * np.exp(-floor[:, 0]))
    wrong = (apart * per_speed[:, common]).max(axis=1) / top
    if m == 0 and law.medium is None:  # raised rounding that both have is negative somewhere
        wrong = np.maximum(wrong, -(g[few] * per_speed).min(axis=1) / top)
    of_g = apart.max(axis=1) / np.maximum(np.abs(g[few]).max(axis=1), max(least, 1e-300))
    error = max(float(wrong.max()), _FLOOR, _CUT * aim)
    if asked.nodes is not None:  # few nodes may agree, and say nothing of what is between
        error = max(error, _unresolved(_rows(g)))
    filled = lowest + problem.log_unit - math.log(10.0) if m == 0 and law.reaches_rest else None
    resolved = max(SHARE * aim, float(of_g.max()))
    where = down - problem.log_unit, first, high + grid.spacing
    density = GridDensity(grid, g, *where, resolved, filled)
    return Profile(density, tau.size, "spectral", grid.nodes, error)


def _unresolved(rows: FloatArray) -> float:
    """The highest modes of rows (1 or 2, ..., nodes) over the largest of both, at the worst."""
    modes = np.abs(np.fft.rfft(rows)).max(axis=0)
    last, top = modes[..., -3:].max(axis=-1), modes.max(axis=-1)
    return float(np.max(last / np.maximum(top, 1e-300)))


def _resolve(problem: _Problem, low: float, high: float, band: float) -> LogGrid | None:
    """A grid that resolves the start and the scaling state; None where the start is too rough."""
    given, aim = problem.asked.nodes, problem.aim
    count = given or int((high - low) * band / math.pi) + 2
    _check_work(problem, count)
    while True:
        count += count % 2
        grid = LogGrid(low, (high - low) / count, count)
        rough = _unresolved(problem.on(grid))
        if given is not None or rough <= SHARE * aim:
            return grid
        if 2 * count > _MOST_NODES // _FINE:
            return grid if rough <= aim else None
        count = int(1.4 * count)


def _choose_grid(problem: _Problem, narrow: LogGrid) -> tuple[LogGrid, float]:
    """The nodes and the angle of the axis, from nodes that resolve the start."""
    from scipy.fft import next_fast_len

    given, rows, spacing = problem.asked.nodes, problem.on(narrow), narrow.spacing
    for _ in range(1 if given is None else 2):
        angle, raised = choose_angle(problem.gain, narrow, rows, spacing, problem.aim)
        left, right = _wide(problem, narrow, angle, raised)
        if given is None:
            spacing *= _COARSE / _FINE
            count = next_fast_len(math.ceil((right - left) / spacing / (2 * _FINE)))
        else:
            count = math.ceil(given / (2 * _FINE))
            spacing = (right - left) / (2 * _FINE * count)
    _check_work(problem, 2 * _FINE * count)
    # both ends at multiples of the nodes that two solutions have in common
    first = math.floor(left / (_FINE * spacing))
    return LogGrid(_FINE * spacing * first, spacing, 2 * _FINE * count), angle


def _wide(problem: _Problem, narrow: LogGrid, angle: float, raised: float) -> tuple[float, float]:
    """Both ends of the window of u: further down than that of g, and further up as exp(-v t/l)."""
    law, aim = problem.asked.law, problem.aim
    tail = math.log(SHARE * aim) - raised - _HIGHER
    if problem.tilt:
        tail = tail / problem.tilt - float(problem.tau[-1])
    elif problem.asked.m == 0:
        tail += math.log(law.mean_log_loss)
    elif law.least_ratio < _SMALL_RATIO:
        tail /= _SLOWEST
    # there exp(-v t/l) is e^-7 of the aim
    right = max(narrow.end, math.log((7.0 - math.log(aim) + raised) / math.cos(angle)))
    ends = TAPER if angle else 0.0
    # wave numbers less than 1/2 apart, for the gain
    return min(min(narrow.start, tail) - ends, right + ends - 4.0 * math.pi), right + ends


def _check_work(problem: _Problem, count: int) -> None:
    """InputError where so many nodes are too many."""
    if count > _MOST_NODES or count * problem.tau.size > _MOST_VALUES:
        latest, law = problem.asked.times[-1], problem.asked.law
        raise InputError(
            f"times: got up to {latest:g} at {law.described}; the density would need"
            f" {count:.1e} nodes, ask for other times, a larger rtol, or averages only"
        )


def _window(
    law: CollisionLaw, start: LogMeasure, aim: float, duration: float
) -> tuple[float, float, float]:
    """Both ends of x = ln(v (t + t0)/l), t0 = l/v_rms, up to tau = duration; wave number needed."""
    depth = math.log(1.0 / aim) + _BELOW_AIM
    order = np.argsort(start.x)
    x = start.x[order] - 0.5 * start.log_second_moment()
    below = np.cumsum(np.abs(start.weight[order]))
    share = math.exp(-depth) * below[-1]
    # of bounces that lose L at rates e^x a share exp(-(y^2 - x^2)/2 L) comes from x down to y
    loss = min(law.largest_loss, -math.log(_SMALL_RATIO))
    depths = np.minimum(x, 0.0) ** 2 + 2.0 * loss * np.log(np.maximum(below / share, 1.0))
    low = -math.sqrt(float(depths[below >= share].max()))
    last = int(np.searchsorted(below - below[-1], -share))
    high = float(x[min(last + 1, x.size - 1)])
    scaled, band = extent_of(law, depth)
    # before that the ring of nearly elastic tracers is still as wide as the start
    if high + duration <= -math.log(law.mean_log_loss) - 1.0:
        band = 8.0
    if law.least_ratio < _SMALL_RATIO:
        low = min(low, -depth)
    return low - 0.5, max(high, min(scaled, high + duration)) + 0.5, band
