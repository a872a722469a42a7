r"""The speed density in time: the forward equation on a logarithmic speed axis, spectrally.

On equidistant nodes of x = ln v a smooth density is resolved to rounding by some hundred of them.
Its collisions are taken out of the equation (:mod:`kinetics.densities.intertwining`), so that any
time follows at once; where rounding does not allow that, the equation is followed in steps of
logarithmic time (:mod:`kinetics.densities.stepping`). Where the scaling state is reached to
rounding, the stationary solution takes over and later times cost nothing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.densities.gain import log_gain
from kinetics.densities.grid_density import GridDensity
from kinetics.densities.harmonic import (
    LEAST_MAXIMUM,
    LOWEST_SPEED,
    HarmonicProblem,
    Profile,
    count_before_scaling,
    memory_of,
    then_scaling,
)
from kinetics.densities.intertwining import TAPER, Spectrum, choose_turn, intertwine
from kinetics.densities.stepping import stepped
from kinetics.errors import InputError
from kinetics.numerics import FloatArray
from kinetics.numerics.log_grid import LogGrid
from kinetics.scaling.tilted import band_of, window_of
from kinetics.states.quadrature import LogMeasure
from kinetics.states.state import SpeedFunction

# Limits of the work: nodes at once and in steps, values at nodes and times (a quarter of a
# gigabyte), and turns of the highest mode times nodes (half a minute of steps).
_MOST_NODES, _MOST_NODES_STEPPED = 32768, 8192
_MOST_VALUES, _MOST_WORK = 3e7, 1e8
# Shares of rtol: for each of many small parts of the error, and for what rounding or steps leave.
_SHARE, _LARGE_SHARE, _STEPPED_SHARE = 0.005, 0.3, 0.03
_BELOW_RTOL = 8.0  # e-folds below rtol at which the window ends
# Of f relative to its maximum, where nothing but rounding is left; the error above which steps are
# tried; and what they reach. The first and the last: tests/kinetics/measurements/densities.py
_BEST, _BEST_STEPPED, _LEAST_STEPPED = 4e-13, 1e-10, 1e-11
# At e = 0: below this share of the thermal speed f is continued as a polynomial, because there
# g = v f holds f with the rounding of g over v only.
_FILLED = 1e-3
# The rounding of the highest modes is up to 4 times its estimate at the ends of the window.
_ROUNDING_AT_END = 20.0
# What is wrong in f where an oscillation of this size is cut off: up to 34 times it, as measured.
_CUT_OFF = 40.0
# Two solutions are compared at about so many speeds, where g is above this share of its maximum.
_SAMPLES, _COMPARED = 200, 1e-6
# Steps of three searches, each a compromise between their number and the work of the last: for a
# finer grid whose error must fall by so much, for fewer modes, and for more nodes.
_FINER, _WORTH_IT, _FEWER, _MORE = 0.6, 0.3, 0.8, 1.4
# Where s may fall below this, bounces fill the low speeds up to v^1 in the density of ln v.
_SMALL_RATIO = 0.3
# There harmonics m > 0, without their collisions, fall at low speeds as v^0.6 at the slowest: a
# zero of 1 - E[s^z cos(m chi)] in z, tests/kinetics/measurements/densities.py
_SLOWEST = 0.6


@dataclass(frozen=True)
class _Problem:
    """What is asked, and the start as this method takes it.

    Attributes
    ----------
    asked : the question
    start : f_m as a function of v in U
    speeds : the initial speeds as weighted points
    tau : ln(1 + v_rms t/l) of the times before the scaling state, shape (n_times,)
    nodes : of the grid, or None
    """

    asked: HarmonicProblem
    start: SpeedFunction
    speeds: LogMeasure
    tau: FloatArray
    nodes: int | None

    @property
    def log_unit(self) -> float:
        """ln of the unit of speed, the root mean square of the initial speeds."""
        return 0.5 * self.speeds.log_second_moment()

    def on(self, grid: LogGrid) -> FloatArray:
        """Real and imaginary part of g at the nodes of ln v in that unit, shape (1 or 2, nodes)."""
        v = np.exp(grid.x + self.log_unit)
        g = np.asarray(self.start(v) * v)
        if self.asked.m == 0:
            g = g / (float(g.sum()) * grid.spacing)  # some of the mass lies beyond the window
        return np.stack([g.real, g.imag]) if np.iscomplexobj(g) else g[None]

    def too_much(self, wanted: float) -> InputError:
        """The error that says how many nodes this would need."""
        latest, law = self.asked.times[-1], self.asked.law
        return InputError(
            f"times: got up to {latest:g} at {law.described}; the density would need"
            f" {wanted:.1e} nodes, ask for other times, a larger rtol, or averages only"
        )


@dataclass(frozen=True)
class _Found:
    """g at the times, however it was found."""

    grid: LogGrid
    values: FloatArray  # (n_times, rows, nodes)
    moved: FloatArray  # ln v at the nodes is x - moved, (n_times,)
    highest: FloatArray  # size of the highest modes, (n_times,)
    rounding: float  # what it may have left of g
    cut_off: float = 0.0  # what lies below the window


def _window(
    law: CollisionLaw, start: LogMeasure, depth: float, duration: float
) -> tuple[float, float, float]:
    """Both ends of x = ln(v (t + t0)/l), t0 = l/v_rms, up to tau = duration; wave number needed.

    Above, the scaling state or the start, and no more than speeds that are kept would reach;
    below, the slow tail of the start, which drifts up. At e below 0.3 bounces fill the low speeds
    up to v^1 in the density of ln v.
    """
    x = start.x - 0.5 * start.log_second_moment()
    weight = np.abs(start.weight)
    order = np.argsort(x)
    below = np.cumsum(weight[order])
    share = math.exp(-depth) * below[-1]
    first = int(np.searchsorted(below, share))
    last = int(np.searchsorted(-(below[-1] - below), -share))
    low = float(x[order[max(first - 1, 0)]])
    high = float(x[order[min(last + 1, x.size - 1)]])
    scaled, deviation = _scaling_end(law, depth)
    kept = high + duration
    right = max(high, min(scaled, kept))
    # before that the ring of nearly elastic tracers is still as wide as the start
    formed = kept > -math.log(law.mean_log_loss) - 1.0
    band = _scaling_band(law, depth, deviation) if formed else 8.0
    if law.least_ratio < _SMALL_RATIO:
        low = min(low, -depth)
    return low - 0.5, right + 0.5, band


# all harmonics of a scene ask for the same
@lru_cache(maxsize=4)
def _scaling_end(law: CollisionLaw, depth: float) -> tuple[float, float]:
    """Right end of the scaling state in ln(v t/l), and its width."""
    _, right, deviation = window_of(law, 0.0, depth)
    return right - math.log(law.mean_log_loss), deviation


@lru_cache(maxsize=4)
def _scaling_band(law: CollisionLaw, depth: float, deviation: float) -> float:
    return band_of(law, 0.0, depth, deviation)


def solve_spectral(asked: HarmonicProblem) -> Profile | None:
    """The harmonic at the times, e < 1; None where the state is too rough for this method.

    Nodes that are given may be too few: what twice as many give is the check. Raises InputError
    where it would take too many nodes.
    """
    law, state, m, times, rtol = asked.law, asked.state, asked.m, asked.times, asked.rtol
    speeds, start = state.harmonic(0, 1e-3 * rtol), state.profile(m)
    if speeds is None or start is None:
        return None
    log_unit = 0.5 * speeds.log_second_moment()
    shift = np.log(times / asked.mean_free_path + math.exp(-log_unit))
    tau = shift + log_unit
    early = tau.size if m else count_before_scaling(asked, speeds, tau)
    problem = _Problem(asked, start, speeds, tau[:early], asked.nodes)
    found = _solve(problem)
    if found is None:
        return None
    density, error = found
    if asked.nodes is not None and early:
        error = max(error, _apart(density, _otherwise(problem, asked.nodes)))
    return Profile(
        density=then_scaling(law, density, early, shift[early:], rtol),
        count=times.size,
        method="spectral",
        nodes=density.grid.nodes,
        error_estimate=error,
    )


def _otherwise(problem: _Problem, nodes: int) -> GridDensity:
    """The same with twice as many nodes, or with half as many where that is too much work."""
    try:
        found = _solve(
            replace(problem, nodes=2 * nodes if 2 * nodes <= _MOST_NODES else nodes // 2)
        )
    except InputError:
        found = _solve(replace(problem, nodes=nodes // 2))
    assert found is not None
    return found[0]


def _solve(problem: _Problem) -> tuple[GridDensity, float] | None:
    """The density and its error relative to the maximum; None where the start is too rough."""
    law, m, rtol = problem.asked.law, problem.asked.m, problem.asked.rtol
    tau = problem.tau
    depth = math.log(1.0 / rtol) + _BELOW_RTOL
    duration = float(tau[-1]) if tau.size else 0.0
    left, right, band = _window(law, problem.speeds, depth, duration)
    wanted = problem.nodes or (right - left) * band / math.pi
    if wanted > _MOST_NODES:
        raise problem.too_much(wanted)
    grid, rows, rough = _resolve(problem, left, right, band)
    if rough > rtol and problem.nodes is None:
        return None
    best = None
    at_once = _at_once(problem, grid, rows)
    if at_once is not None:
        best = _judged(problem, at_once, (left, right), rough)
        # oscillations at low speeds, that of laws which lose by steps, do not fit into its window
        if problem.nodes is not None or best[1] <= max(rtol, _BEST_STEPPED):
            return best
    # the drift and the losses turn the highest mode this often
    turns = math.pi / grid.spacing * (1.0 + law.mean_log_loss * math.exp(right))
    if wanted > _MOST_NODES_STEPPED or turns * duration * grid.nodes > _MOST_WORK:
        if best is None:
            raise problem.too_much(wanted)
        return best
    values, highest = stepped(law, grid, rows, m, tau, rtol)
    rounding = LOWEST_SPEED * max(_STEPPED_SHARE * rtol, _LEAST_STEPPED)
    stepwise = _Found(grid, values, tau, highest, rounding)
    other = _judged(problem, stepwise, (left, right), rough)
    return other if best is None or other[1] < best[1] else best


def _judged(
    problem: _Problem, found: _Found, window: tuple[float, float], rough: float
) -> tuple[GridDensity, float]:
    """The density, of which nothing is left at speeds outside the window of x, and its error."""
    law, m, rtol = problem.asked.law, problem.asked.m, problem.asked.rtol
    # harmonics m > 0 that bounces fill at low speeds reach below the window
    bounded = m == 0 or law.least_ratio >= _SMALL_RATIO
    values = found.values[:, 0]
    if found.values.shape[1] == 2:
        values = values + 1j * found.values[:, 1]
    density = GridDensity(
        grid=found.grid,
        values=values,
        shift=found.moved - problem.log_unit,
        start=window[0] if bounded else found.grid.start,
        end=window[1] + found.grid.spacing,
        resolved=max(_SHARE * rtol, 3.0 * found.rounding / LEAST_MAXIMUM),
        filled=_FILLED if m == 0 and law.reaches_rest else 0.0,
        at_rest=_at_rest(problem) if m == 0 else None,
    )
    ends = max(_ends(values, 0.0 if m == 0 else LEAST_MAXIMUM), found.cut_off)
    missed = float(np.max(found.highest * found.grid.spacing, initial=ends))
    if m:
        missed = max(missed, found.rounding / LOWEST_SPEED)
    else:
        missed = max(missed, density.error_at_low_speeds(found.rounding))
    return density, max(0.1 * rtol, _BEST, rough, missed)


def _at_rest(problem: _Problem) -> float | None:
    """f at v = 0, in 1/U, where bounces add nothing to it: that of the start, if it is finite.

    Tracers come to v in proportion to the density of the speed ratio at s = 0, which vanishes where
    E[s^p] exists down to p = -2 (spheres, and et = 0).
    """
    law = problem.asked.law
    if not (law.reaches_rest and law.lowest_power < -1.0):
        return None
    with np.errstate(all="ignore"):
        found = float(np.real(problem.start(np.zeros(1)))[0])
    return found if math.isfinite(found) else None


def _apart(found: GridDensity, other: GridDensity) -> float:
    """The largest difference of two solutions where there is anything, relative to the maximum."""
    worst = 0.0
    for i, values in enumerate(found.values):
        size = np.abs(values)
        there = np.nonzero(size > _COMPARED * size.max())[0]
        x = found.grid.x[there[:: max(1, there.size // _SAMPLES)]]
        v = np.exp(x - found.shift[i])
        lowest = other.lowest_promised[i] - other.shift[i] + found.shift[i]
        promised = np.exp(np.minimum(0.0, x - lowest))
        first, second = promised * found.at(i, v), promised * other.at(i, v)
        top = max(float(np.abs(second).max(initial=0.0)), 1e-300)
        worst = max(worst, float(np.abs(first - second).max(initial=0.0)) / top)
    return worst


def _at_once(problem: _Problem, grid: LogGrid, rows: FloatArray) -> _Found | None:
    """Every time from the start, without its collisions; None where rounding is too large.

    The window is that of g and more: u reaches further down, as v, and further up, as
    exp(-v t/l).
    """
    law, m, rtol = problem.asked.law, problem.asked.m, problem.asked.rtol
    nodes = problem.nodes
    spectrum, spacing = Spectrum.of(grid, rows), grid.spacing
    turn = choose_turn(law, m, spectrum, rtol, spacing)
    while turn.error > _LARGE_SHARE * rtol and nodes is None:
        # more modes allow a larger angle, but cost in proportion
        other = choose_turn(law, m, spectrum, rtol, _FINER * spacing)
        if other.error > _WORTH_IT * turn.error:
            break
        turn, spacing = other, _FINER * spacing
    # more modes than these are left empty: dividing by their gain would raise the rounding
    highest, size = math.pi / spacing, spectrum.size
    least = spectrum.step * float(np.nonzero(size > _SHARE * rtol * size.max())[0][-1])
    while turn.error > _LARGE_SHARE * rtol and nodes is not None and _FEWER * highest > least:
        highest *= _FEWER
        other = choose_turn(law, m, spectrum, rtol, spacing, highest)
        turn = min(turn, other, key=lambda t: t.error)
    if turn.error > max(_LARGE_SHARE * rtol, _BEST_STEPPED):
        return None
    tail = math.log(_SHARE * rtol) - turn.raised
    if m == 0:
        tail += math.log(law.mean_log_loss)
    elif law.least_ratio < _SMALL_RATIO:
        tail /= _SLOWEST
    left = min(grid.start, tail)
    # there exp(-v t/l) is e^-7 rtol
    right = max(grid.end, math.log((7.0 - math.log(rtol) + turn.raised) / math.cos(turn.angle)))
    if turn.tapered:
        left, right = left - TAPER, right + TAPER
    if nodes is None:
        count = _good_count(math.ceil((right - left) / spacing))
        if count > _MOST_NODES or count * problem.tau.size > _MOST_VALUES:
            return None
        wide = LogGrid(right - spacing * count, spacing, count)
    else:
        wide = LogGrid(left, (right - left) / grid.nodes, grid.nodes)
    gain = log_gain(law, wide.wave_numbers, m)
    hidden = intertwine(wide, problem.on(wide), gain, turn, m)
    moved, values, last = hidden.at(problem.tau)
    # what is at the lower end goes on below, unless it is rounding
    allowed = _LARGE_SHARE * rtol + _BEST_STEPPED + _ROUNDING_AT_END * turn.uncertain
    cut_off = hidden.lowest if hidden.lowest > allowed else 0.0
    if m == 0 and memory_of(law, problem.asked.state, problem.speeds):
        # an oscillation that does not fall in the window, and that f = g/v raises at low speeds
        cut_off = _CUT_OFF * hidden.lowest
    return _Found(wide, values, moved * wide.spacing, last, 3.0 * hidden.noise, cut_off)


def _good_count(least: int) -> int:
    """An even number of nodes, not below the least, of small prime factors."""
    from scipy.fft import next_fast_len

    return 2 * int(next_fast_len((least + 1) // 2, real=True))


def _resolve(
    problem: _Problem, left: float, right: float, band: float
) -> tuple[LogGrid, FloatArray, float]:
    """A grid that resolves the start and the scaling state, g on it, and its highest modes."""
    count = problem.nodes or int((right - left) * band / math.pi) + 2
    while True:
        count += count % 2
        grid = LogGrid(left, (right - left) / count, count)
        rows = problem.on(grid)
        spectrum = np.abs(np.fft.rfft(rows)).max(axis=0)
        rough = float(spectrum[-3:].max() / max(float(spectrum.max()), 1e-300))
        enough = rough <= _SHARE * problem.asked.rtol or 2 * count > _MOST_NODES_STEPPED
        if problem.nodes is not None or enough:
            return grid, rows, rough
        count = int(_MORE * count)


def _ends(values: NDArray[Any], least: float) -> float:
    """Largest value at the ends of the window relative to the maximum, or to the least of it."""
    if values.shape[0] == 0:
        return 0.0
    top = np.array([np.abs(g).max() for g in values])
    ends = np.abs(values[:, [0, 1, -2, -1]]).max(axis=1)
    return float(np.max(ends / np.maximum(top, max(least, 1e-300))))
