"""A density known at equidistant nodes of ln v, read off at any speed."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.densities.harmonic import LOWEST_SPEED
from kinetics.numerics import FloatArray
from kinetics.numerics.chebyshev import barycentric_weights, interpolation_rows
from kinetics.numerics.log_grid import LogGrid
from kinetics.results import Value

_MOST_TERMS = 1_000_000  # of a Fourier sum, or of densities, at once: 16 megabytes
_STEEP = 1e4  # slope of ln f below a step of f, where f is zero
_STEP = 1e3  # the density of ln v falls by more than this at a node: it has a step there
_POLYNOMIAL = np.array(
    [1.0, 2.0, 4.0, 8.0, 16.0]
)  # speeds from which f is continued to lower ones at e = 0


@dataclass(frozen=True)
class GridDensity(Value):
    """g = v f, the density of ln v, at equidistant nodes of x = ln v + shift.

    Attributes
    ----------
    grid : the nodes of x
    values : g at the nodes, shape (n_times, n_nodes)
    shift : x - ln v, shape (n_times,)
    start, end : lowest and highest x where something is left; the nodes may reach further
    resolved : share of its maximum down to which g is right
    filled : share of the thermal speed below which f is a polynomial (e = 0); 0 elsewhere
    at_rest : f at v = 0 in 1/U, that of the start, where the density of the speed ratio vanishes at
        s = 0: bounces then add nothing to it; None where it is not known
    """

    grid: LogGrid
    values: NDArray[Any]
    shift: FloatArray
    start: float
    end: float
    resolved: float
    filled: float = 0.0
    at_rest: float | None = None

    def at(self, i: int, v: FloatArray) -> NDArray[Any]:
        """f in 1/U at the i-th time and speeds v in U, shape (n_v,)."""
        out = np.zeros(v.shape, dtype=self.values.dtype)
        shift = self.shift[i]
        with np.errstate(divide="ignore"):
            x = np.log(v) + shift
        floor, slope = self._low_end(i)
        inside = (x <= self.end) & (v > 0.0)
        # below what is resolved, the slope of ln f that f = g/v has there goes on
        at = np.clip(x[inside], floor, self.end)
        with np.errstate(under="ignore"):
            # by the root twice: 1/v alone may be larger than the largest number
            root = np.exp(0.5 * (slope * (x[inside] - at) - (at - shift)))
            out[inside] = self._interpolate(i, at) * root * root
            if self.filled:
                # from speeds where the error of g, divided by v, is still small
                edge = math.log(self.filled * self._width(i))
                low = (x < edge) & (v > 0.0)
                out[low] = self._from_above(i, edge, np.exp(x[low] - edge))
        return out

    @cached_property
    def lowest_promised(self) -> FloatArray:
        """The lowest x at which f keeps its accuracy relative to its maximum, shape (n_times,)."""
        squares = np.exp(2.0 * self.grid.x)
        second = [size @ squares / size.sum(axis=1) for size in self._sizes()]
        return math.log(LOWEST_SPEED) + 0.5 * np.log(np.concatenate([*second, []]))

    def error_at_low_speeds(self, rounding: float) -> float:
        """Largest error of f relative to its maximum, for so much rounding of g.

        f = g/v has most of it at the lowest speed at which it is promised, or where g is no
        longer resolved and f goes on by its slope: there f itself bounds the error.
        """
        x, worst, done = self.grid.x, 0.0, 0
        per_speed = np.exp(-x)
        for size in self._sizes():
            part = slice(done, done + len(size))
            done += len(size)
            top, first = self._resolved[0][part], self._resolved[1][part]
            cut = x[first]
            low = np.maximum(self.lowest_promised[part], cut)
            share = np.where(cut < low, rounding / top, np.maximum(rounding / top, self.resolved))
            with np.errstate(under="ignore"):
                most = np.where(x >= low[:, None], size * per_speed, 0.0).max(axis=1)
            worst = max(worst, float(np.max(share * top * np.exp(-low) / most)))
        return worst

    @cached_property
    def _resolved(self) -> tuple[FloatArray, NDArray[np.intp]]:
        """The maximum of |g|, and the lowest node at which g is resolved, (n_times,).

        Above it g may be weak again, where it changes its sign or between two of its maxima. Below
        ``start`` there is what the end of the grid leaves, of about the size that is resolved.
        """
        tops, firsts = [np.zeros(0)], [np.zeros(0, dtype=int)]
        within = self.grid.x >= self.start
        for size in self._sizes():
            top = size.max(axis=1)
            tops.append(top)
            firsts.append((within & (size >= self.resolved * top[:, None])).argmax(axis=1))
        return np.concatenate(tops), np.concatenate(firsts)

    def _sizes(self) -> Iterator[FloatArray]:
        """The sizes of g for some times after another, so that memory stays flat."""
        step = max(1, _MOST_TERMS // self.grid.nodes)
        for first in range(0, len(self.values), step):
            yield np.abs(self.values[first : first + step])

    def _width(self, i: int) -> float:
        """Maximum of g over that of g/v, in units of exp(x)."""
        size = np.abs(self.values[i])
        per_speed = size * np.exp(-self.grid.x)
        if self.at_rest is not None:
            # farther down f vanishes, and g/v may be the rounding of g over v
            per_speed = per_speed[self.grid.x >= self.lowest_promised[i]]
        return float(size.max() / per_speed.max())

    def _from_above(self, i: int, edge: float, u: FloatArray) -> NDArray[Any]:
        """g/v at exp(x - edge) = u < 1: the polynomial in v through five values at u >= 1.

        Also through that at rest, where it is known.
        """
        at = edge + np.log(_POLYNOMIAL)
        rows = interpolation_rows(u[:, None] - _POLYNOMIAL, barycentric_weights(_POLYNOMIAL))
        values = self._interpolate(i, at) * np.exp(self.shift[i] - at)
        if self.at_rest is None:
            return np.asarray(rows @ values)
        return np.asarray(self.at_rest + u * (rows @ ((values - self.at_rest) / _POLYNOMIAL)))

    def _low_end(self, i: int) -> tuple[float, float]:
        """Lowest x at which g is resolved, and the slope of ln(g/v) there, not below 0."""
        g, top, first = self.values[i], self._resolved[0][i], int(self._resolved[1][i])
        lowest = float(abs(g[first]))
        if first and lowest > _STEP * self.resolved * top:
            return float(self.grid.x[first]), _STEEP
        # one e-fold further up, for the slope
        step = max(1, round(1.0 / self.grid.spacing))
        second = min(first + step, g.size - 1)
        if second == first:
            return float(self.grid.x[first]), 0.0
        rise = math.log(max(float(abs(g[second])), 1e-300) / max(lowest, 1e-300))
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
