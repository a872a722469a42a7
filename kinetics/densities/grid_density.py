"""A smooth harmonic at equidistant nodes of ln v that move with the tracers.

Between the nodes it is a Fourier sum. Below the lowest speed at which it is resolved it goes on as
a power of v, or, where bounces lead to any speed, as a polynomial. Begin with
:class:`GridDensity`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetics.densities.harmonic import HarmonicArray
from kinetics.numerics import FloatArray
from kinetics.numerics.chebyshev import barycentric_weights, interpolation_rows
from kinetics.numerics.log_grid import LogGrid
from kinetics.results.value import Value

#: Where bounces lead to any speed: the speeds from which f is continued down, over the lowest of
#: them. Chosen: five, in octaves, for a polynomial.
CONTINUED_FROM = np.array([1.0, 2.0, 4.0, 8.0, 16.0])
#: Terms of Fourier sums at once: 16 megabytes. It changes no result.
TERMS_AT_ONCE = 1_000_000
#: Stands for 0 in a logarithm.
TINY = 1e-300


def to_rows(values: HarmonicArray) -> FloatArray:
    """Return the real and the imaginary part, or the real one alone, as rows, (1 or 2, n)."""
    if np.iscomplexobj(values):
        return np.stack([values.real, values.imag])
    return values[None]


def from_rows(rows: FloatArray) -> HarmonicArray:
    """Return values whose parts `to_rows` made rows, which are on the last axis but one."""
    if rows.shape[-2] == 1:
        return rows[..., 0, :]
    return np.asarray(rows[..., 0, :] + 1j * rows[..., 1, :])


@dataclass(frozen=True, eq=False, repr=False)
class GridDensity(Value):
    """g = v f, the density of ln v, at equidistant nodes of x = ln v + shift.

    Parameters
    ----------
    grid : the nodes of x, periodic
    values : g at the nodes, shape (n_times, n_nodes)
    shift : x - ln v, v in U, shape (n_times,)
    start, end : lowest and highest x where something is left; the nodes may reach further
    resolved : fraction of its maximum down to which g is right
    filled : ln v below which f is a polynomial in v, (n_times,); None where it is not
    """

    grid: LogGrid
    values: HarmonicArray
    shift: FloatArray
    start: float
    end: float
    resolved: float
    filled: FloatArray | None = None

    def at(self, i: int, v: FloatArray) -> HarmonicArray:
        """Evaluate f in 1/U at the i-th time and speeds v in U, shape (n_v,)."""
        density = np.zeros(v.shape, dtype=self.values.dtype)
        shift = self.shift[i]
        with np.errstate(divide="ignore"):
            x = np.log(v) + shift
        is_inside = (x <= self.end) & (v > 0.0)
        lowest, slope = self._low_end(i)
        resolved_x = np.clip(x[is_inside], lowest, self.end)
        with np.errstate(under="ignore"):
            log_f_over_g = slope * (x[is_inside] - resolved_x) - (resolved_x - shift)
            # by the root twice: 1/v alone may be larger than the largest number
            root = np.exp(0.5 * log_f_over_g)
            density[is_inside] = self._interpolate(i, resolved_x) * root * root
            if self.filled is not None:
                log_lowest_speed = float(self.filled[i])
                is_low = (x < log_lowest_speed + shift) & (v > 0.0)
                log_v = x[is_low] - shift
                density[is_low] = self._continue_to_rest(i, log_v, log_lowest_speed)
        return density

    def _low_end(self, i: int) -> tuple[float, float]:
        """Return the lowest x where g is resolved, and the slope of ln(g/v) there, not below 0."""
        size = np.abs(self.values[i])
        x = self.grid.x
        is_resolved = (x >= self.start) & (size >= self.resolved * size.max())
        first = int(is_resolved.argmax())
        # one e-fold further up, for the slope
        second = min(first + max(1, round(1.0 / self.grid.spacing)), size.size - 1)
        log_first, log_second = np.log(np.maximum(size[[first, second]], TINY))
        distance = max(x[second] - x[first], self.grid.spacing)
        slope_of_g = float((log_second - log_first) / distance)
        return float(x[first]), max(0.0, slope_of_g - 1.0)

    def _continue_to_rest(self, i: int, log_v: FloatArray, log_lowest: float) -> HarmonicArray:
        """Return f at lower speeds, by the polynomial in v through five higher ones.

        f is g over v, with the rounding of g over v, which is worse the lower v is.

        Parameters
        ----------
        i : index of the time
        log_v : ln v, shape (n,)
        log_lowest : ln of the lowest speed of the five
        """
        log_node = log_lowest + np.log(CONTINUED_FROM)
        f_at_nodes = self._interpolate(i, log_node + self.shift[i]) * np.exp(-log_node)
        differences = np.exp(log_v - log_lowest)[:, None] - CONTINUED_FROM
        return interpolation_rows(differences, barycentric_weights(CONTINUED_FROM)) @ f_at_nodes

    def _interpolate(self, i: int, x: FloatArray) -> HarmonicArray:
        """Evaluate g at the i-th time and x in the window, in pieces, so that memory stays flat."""
        rows = to_rows(self.values[i])
        n_pieces = 1 + x.size * self.grid.nodes // TERMS_AT_ONCE
        pieces = [self.grid.interpolate(rows, piece) for piece in np.array_split(x, n_pieces)]
        return from_rows(np.hstack(pieces))
