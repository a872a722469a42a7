r"""The speed density in time: the forward equation on a logarithmic speed axis, spectrally.

On equidistant nodes of x = ln v a smooth density is resolved to rounding by some hundred of them.
Its collisions are taken out of the equation (:mod:`kinetics.densities.intertwining`), so that any
time follows at once; where rounding does not allow that, the equation is followed in steps of
logarithmic time (:mod:`kinetics.densities.stepping`). Where the scaling state is reached to
rounding, the stationary solution takes over and later times cost nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.densities.gain import log_gain
from kinetics.densities.harmonic import Profile, count_before_scaling, then_scaling
from kinetics.densities.intertwining import choose_turn, intertwine, resolved
from kinetics.densities.stepping import stepped
from kinetics.errors import InputError
from kinetics.numerics.log_grid import LogGrid
from kinetics.scaling.tilted import band_of, window_of
from kinetics.states.quadrature import LogMeasure
from kinetics.states.state import State

FloatArray = NDArray[np.float64]

_MAX_NODES = 8192
_MOST_NODES = 32768  # where there are no steps
_MOST_VALUES = 3e7  # at nodes and times: a quarter of a gigabyte
_STEEP = 1e4
_MOST_WORK = 1e8  # turns of the highest mode times nodes: half a minute of steps
_MOST_TERMS = 2_000_000  # of a Fourier sum: nodes times points
_SHARE = 0.005  # of rtol that each part of the error may have
_FILLED = 1e-3  # of the thermal speed, about: below, the density at e = 0 is a polynomial
_BEST = 4e-13  # of f relative to its maximum, where g is right to rounding (measured)
_READ = 5e-15  # rounding of g, relative to its maximum, where it is divided by a low speed
_BEST_STEPPED = 1e-10  # what steps reach
_SEEN = 1e-6  # share of the maximum of g down to which two solutions are compared,
_SAMPLES = 200  # at so many speeds or a few more
_LEAST_MAXIMUM = 0.3  # of the isotropic density of ln v, at any time: its width is of order 1


@dataclass(frozen=True)
class _Collocated:
    """g at the nodes, read off at any speed."""

    grid: LogGrid
    values: NDArray[Any]  # (n_times, nodes)
    shift: FloatArray  # x - ln v, (n_times,)
    end: float  # highest x where something is left
    resolved: float  # share of its maximum down to which g is right
    filled: float = 0.0  # share of the thermal speed below which f is a parabola (e = 0)

    def __call__(self, i: int, v: FloatArray) -> NDArray[Any]:
        out = np.zeros(v.shape, dtype=self.values.dtype)
        shift = self.shift[i]
        with np.errstate(divide="ignore"):
            x = np.log(v) + shift
        floor, slope = self._low_end(i)
        inside = (x <= self.end) & (v > 0.0)
        # g is right to a share of its maximum: below that, and f = g/v with it, the slope of ln f
        # that it has there goes on
        at = np.clip(x[inside], floor, self.end)
        with np.errstate(under="ignore"):
            fall = np.exp(slope * (x[inside] - at) - (at - shift))
            out[inside] = self._interpolate(i, at) * fall
            if self.filled:
                # where the error of g, over v, is small still
                edge = math.log(self.filled * self._width(i))
                low = (x < edge) & (v > 0.0)
                out[low] = self._from_above(i, edge, np.exp(x[low] - edge))
        return out

    def _width(self, i: int) -> float:
        """Maximum of g over that of g/v, in units of exp(x)."""
        size = np.abs(self.values[i])
        return float(size.max() / (size * np.exp(-self.grid.x)).max())

    def _from_above(self, i: int, edge: float, u: FloatArray) -> NDArray[Any]:
        """g/v at exp(x - edge) = u < 1: the polynomial in v through those at u = 1, 2, 4, 8, 16."""
        node = 2.0 ** np.arange(5)
        at = edge + np.log(node)
        out = np.zeros(u.shape, dtype=self.values.dtype)
        for k, value in enumerate(self._interpolate(i, at) * np.exp(self.shift[i] - at)):
            others = np.delete(node, k)
            out += value * np.prod((u[:, None] - others) / (node[k] - others), axis=1)
        return out

    def _low_end(self, i: int) -> tuple[float, float]:
        """Lowest x at which g(t_i) is resolved, and the slope of ln(g/v) there, not below 0."""
        size = np.abs(self.values[i])
        top = int(size.argmax())
        weak = np.nonzero(size[: top + 1] < self.resolved * size[top])[0]
        first = int(weak[-1]) + 1 if weak.size else 0
        if weak.size and size[first] > 1e3 * self.resolved * size[top]:
            return float(self.grid.x[first]), _STEEP  # a step: nothing below it
        # one e-fold further up, for the slope
        step = max(1, round(1.0 / self.grid.spacing))
        second = min(first + step, size.size - 1)
        rise = math.log(max(float(size[second]), 1e-300) / max(float(size[first]), 1e-300))
        slope = rise / ((second - first) * self.grid.spacing) - 1.0
        return float(self.grid.x[first]), max(0.0, slope)

    def _interpolate(self, i: int, x: FloatArray) -> NDArray[Any]:
        """In pieces of x, so that memory stays flat."""
        values = self.values[i]
        pieces = np.array_split(x, 1 + x.size * self.grid.nodes // _MOST_TERMS)
        real = np.concatenate([self.grid.interpolate(values.real, piece) for piece in pieces])
        if not np.iscomplexobj(values):
            return real
        imag = [self.grid.interpolate(values.imag, piece) for piece in pieces]
        return np.asarray(real + 1j * np.concatenate(imag))


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
    # too early for the ring of nearly elastic tracers to narrow
    formed = kept > -math.log(law.mean_log_loss) - 1.0
    band = _scaling_band(law, depth, deviation) if formed else 8.0
    if law.restitution < 0.3:
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


def solve_spectral(
    law: CollisionLaw,
    mean_free_path: float,
    state: State,
    m: int,
    times: FloatArray,
    rtol: float,
    nodes: int | None = None,
    checked: bool = True,
) -> Profile | None:
    """Harmonic m at the times, e < 1; None where the state is too rough for this method.

    Nodes that are given may be too few: unless told not to, what twice as many give is the check.
    """
    start = state.harmonic(0, 1e-3 * rtol)
    profile = state.profile(m)
    if start is None or profile is None:
        return None
    depth = math.log(1.0 / rtol) + 8.0
    log_unit = 0.5 * start.log_second_moment()
    shift = np.log(times / mean_free_path + math.exp(-log_unit))
    tau = shift + log_unit
    early = count_before_scaling(law, tau, rtol) if m == 0 else tau.size
    duration = float(tau[early - 1]) if early else 0.0
    left, right, band = _window(law, start, depth, duration)
    wanted = nodes or (right - left) * band / math.pi
    if wanted > _MOST_NODES:
        raise _too_much(law, times, wanted)

    def at_nodes(grid: LogGrid) -> FloatArray:
        """Real and imaginary part of g on a grid of ln v, in units of the thermal speed."""
        v = np.exp(grid.x + log_unit)
        g = np.asarray(profile(v) * v)
        if m == 0:
            g = g / (float(g.sum()) * grid.spacing)  # what lies beyond the window is not missed
        return np.stack([g.real, g.imag]) if np.iscomplexobj(g) else g[None]

    grid, rows, rough = _resolve(at_nodes, left, right, band, rtol, nodes)
    if rough > rtol and nodes is None:
        return None
    found = _at_once(law, at_nodes, grid, rows, m, tau[:early], rtol, nodes)
    if found is None:
        # the drift and the losses turn the highest mode this often
        turns = math.pi / grid.spacing * (1.0 + law.mean_log_loss * math.exp(right))
        if wanted > _MAX_NODES or turns * duration * grid.nodes > _MOST_WORK:
            raise _too_much(law, times, wanted)
        values, highest = stepped(law, grid, rows, m, tau[:early], rtol)
        found = _Found(grid, values, tau[:early], highest, max(0.3 * rtol, _BEST_STEPPED))
    joined = found.values[:, 0]
    if rows.shape[0] == 2:
        joined = joined + 1j * found.values[:, 1]
    # what a parabola leaves goes as the cube
    filled = (
        min(_FILLED, (0.05 * rtol) ** (1.0 / 3.0)) if m == 0 and law.restitution == 0.0 else 0.0
    )
    collocated = _Collocated(
        found.grid,
        joined,
        found.moved - log_unit,
        right + found.grid.spacing,
        max(_SHARE * rtol, 3.0 * found.rounding),
        filled,
    )
    # a harmonic that dies away matters beside the isotropic part
    least = 0.0 if m == 0 else _LEAST_MAXIMUM
    missed = float(np.max(found.highest * found.grid.spacing, initial=_ends(joined, least)))
    if filled:
        missed = max(missed, _READ / filled)
    if nodes is not None and checked and early:
        others = 2 * nodes if 2 * nodes <= _MOST_NODES else nodes // 2
        again = (law, mean_free_path, state, m, times[:early], rtol)
        try:
            other = solve_spectral(*again, others, checked=False)
        except InputError:  # too much work
            other = solve_spectral(*again, nodes // 2, checked=False)
        assert other is not None
        missed = max(missed, _apart(collocated, other))
    return Profile(
        at=then_scaling(law, collocated, early, shift[early:], rtol),
        count=times.size,
        method="spectral",
        nodes=found.grid.nodes,
        error_estimate=max(0.1 * rtol, _BEST, found.rounding, rough, missed),
    )


def _apart(found: _Collocated, other: Profile) -> float:
    """The largest difference of two solutions where there is anything, relative to the maximum."""
    worst = 0.0
    for i, values in enumerate(found.values):
        size = np.abs(values)
        there = np.nonzero(size > _SEEN * size.max())[0]
        x = found.grid.x[there[:: max(1, there.size // _SAMPLES)]]
        v = np.exp(x - found.shift[i])
        first, second = found(i, v), other.at(i, v)
        top = max(float(np.abs(second).max(initial=0.0)), 1e-300)
        worst = max(worst, float(np.abs(first - second).max(initial=0.0)) / top)
    return worst


@dataclass(frozen=True)
class _Found:
    """g at the times, however it was found."""

    grid: LogGrid
    values: FloatArray  # (n_times, rows, nodes)
    moved: FloatArray  # ln v at the nodes is x - moved, (n_times,)
    highest: FloatArray  # size of the highest modes, (n_times,)
    rounding: float  # what it may have left, relative to the maximum


def _too_much(law: CollisionLaw, times: FloatArray, wanted: float) -> InputError:
    return InputError(
        f"times: got up to {times[-1]:g} at restitution {law.restitution!r}; the density "
        f"would need {wanted:.1e} nodes, ask for other times, a larger rtol, or averages only"
    )


def _at_once(
    law: CollisionLaw,
    at_nodes: Callable[[LogGrid], FloatArray],
    grid: LogGrid,
    rows: FloatArray,
    m: int,
    tau: FloatArray,
    rtol: float,
    nodes: int | None,
) -> _Found | None:
    """Every time from the start, without its collisions; None where rounding is too large.

    The window is that of g and more: u reaches further down, as v, and further up, as
    exp(-v t/l).
    """
    modes = np.fft.rfft(rows)
    kept = resolved(modes) / grid.nodes * 2.0 * math.pi / grid.spacing
    spacing = grid.spacing
    turn = choose_turn(law, kept, math.pi / spacing, m, rtol)
    while turn.error > 0.3 * rtol and nodes is None:
        # more modes allow a larger angle
        other = choose_turn(law, kept, math.pi / (0.6 * spacing), m, rtol)
        if other.error > 0.3 * turn.error:
            break
        turn, spacing = other, 0.6 * spacing
    # more modes than these are left empty: dividing by their gain would raise the rounding
    highest = math.pi / spacing
    size = np.abs(modes).max(axis=0)
    least = float(grid.wave_numbers[np.nonzero(size > _SHARE * rtol * size.max())[0][-1]])
    while turn.error > 0.3 * rtol and nodes is not None and 0.8 * highest > least:
        highest *= 0.8
        other = choose_turn(law, min(kept, highest), highest, m, rtol, math.pi / spacing)
        turn = min(turn, other, key=lambda t: t.error)
    if turn.error > max(0.3 * rtol, _BEST_STEPPED):
        return None
    tail = math.log(_SHARE * rtol) - turn.raised
    left = min(grid.start, tail + math.log(law.mean_log_loss) if m == 0 else tail)
    right = max(grid.end, math.log((7.0 - math.log(rtol) + turn.raised) / math.cos(turn.angle)))
    if nodes is None:
        count = _good_count(math.ceil((right - left) / spacing))
        if count > _MOST_NODES or count * tau.size > _MOST_VALUES:
            return None
        wide = LogGrid(right - spacing * count, spacing, count)
    else:
        wide = LogGrid(left, (right - left) / grid.nodes, grid.nodes)
    gain = log_gain(law, wide.wave_numbers, m)
    hidden = intertwine(wide, at_nodes(wide), gain, turn, m)
    moved, values, last = hidden.at(tau)
    return _Found(wide, values, moved * wide.spacing, last, turn.error)


def _good_count(least: int) -> int:
    """An even number of nodes, not below the least, of small prime factors."""
    from scipy.fft import next_fast_len

    return 2 * int(next_fast_len((least + 1) // 2, real=True))


def _resolve(
    at_nodes: Callable[[LogGrid], FloatArray],
    left: float,
    right: float,
    band: float,
    rtol: float,
    nodes: int | None,
) -> tuple[LogGrid, FloatArray, float]:
    """A grid that resolves the start and the scaling state, g on it, and its highest modes."""
    count = nodes or int((right - left) * band / math.pi) + 2
    while True:
        count += count % 2
        grid = LogGrid(left, (right - left) / count, count)
        rows = at_nodes(grid)
        spectrum = np.abs(np.fft.rfft(rows)).max(axis=0)
        rough = float(spectrum[-3:].max() / max(float(spectrum.max()), 1e-300))
        if nodes is not None or rough <= _SHARE * rtol or 2 * count > _MAX_NODES:
            return grid, rows, rough
        count = int(1.4 * count)


def _ends(values: NDArray[Any], least: float) -> float:
    """Largest value at the ends of the window relative to the maximum, or to the least of it."""
    if values.shape[0] == 0:
        return 0.0
    top = np.abs(values).max(axis=1)
    ends = np.abs(values[:, [0, 1, -2, -1]]).max(axis=1)
    return float(np.max(ends / np.maximum(top, max(least, 1e-300))))
