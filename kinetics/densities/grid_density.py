"""A smooth harmonic at equidistant nodes of ln v that move with the tracers.

f is one angular harmonic f_m of the velocity density (see :mod:`kinetics.densities.harmonic`), real
or complex, in 1/U; v is the speed and U its unit. g = v f is the density of ln v, which is known at
nodes of x = ln v + shift(t): tracers cool, and the shift follows them.

Between the nodes g is a Fourier sum. Below the lowest speed at which g is resolved, f goes on as a
power of v or, where bounces lead to any speed, however low, as a polynomial. Begin with
:meth:`GridDensity.at`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetics.densities.harmonic import HarmonicArray
from kinetics.numerics import FloatArray
from kinetics.numerics.chebyshev import barycentric_weights, interpolation_rows
from kinetics.numerics.log_grid import LogGrid
from kinetics.results.value import Value

#: The speeds, over the lowest of them, through whose f the polynomial goes by which f is continued
#: to rest: five points make the fourth degree. Chosen: with half or twice these
#: speeds, or one point more or less, f moves by 2e-11 of its largest; three points would move it by
#: 2e-8 (e = 0, rtol 1e-8).
CONTINUED_FROM = np.array([1.0, 2.0, 4.0, 8.0, 16.0])
#: Terms of Fourier sums (nodes times points) at once: 16 megabytes of complex numbers. Chosen:
#: it changes no result.
TERMS_AT_ONCE = 1_000_000
#: Stands for 0 in a logarithm of g: close to the smallest number.
TINY = 1e-300


def to_rows(values: HarmonicArray) -> FloatArray:
    """Return values, shape (n,), as real rows: one for real values, two for complex ones.

    They are the real part and, if there is one, the imaginary part: shape (1 or 2, n).
    """
    if np.iscomplexobj(values):
        return np.stack([values.real, values.imag])
    return values[None]


def from_rows(rows: FloatArray) -> HarmonicArray:
    """Return the values of real rows, shape (..., 1 or 2, n): the opposite of `to_rows`.

    Shape (..., n), real for one row and complex for two.
    """
    if rows.shape[-2] == 1:
        return rows[..., 0, :]
    return np.asarray(rows[..., 0, :] + 1j * rows[..., 1, :])


@dataclass(frozen=True, eq=False, repr=False)
class GridDensity(Value):
    """A harmonic by g = v f, the density of ln v, at equidistant nodes of x = ln v + shift.

    Parameters
    ----------
    grid : the nodes of x, a periodic window
    values : g at the nodes, shape (n_times, n_nodes)
    shift : x - ln v, v in U, shape (n_times,)
    start : lowest x where g may be more than rounding; the window may begin below it
    end : highest x where g may be more than that; above it f is 0. The window may go on beyond it,
        so that its two ends do not meet
    resolved : fraction of its maximum, at the same time, down to which g is right
    filled : ln v, v in U, below which f is a polynomial in v, shape (n_times,); None where f goes
        on as a power of v
    """

    grid: LogGrid
    values: HarmonicArray
    shift: FloatArray
    start: float
    end: float
    resolved: float
    filled: FloatArray | None = None

    def at(self, i: int, v: FloatArray) -> HarmonicArray:
        """Evaluate f in 1/U at the i-th time and speeds v in U, shape (n_v,).

        f is 0 at v = 0 and above `end`. From there down to the lowest x where g is resolved it is
        g/v by interpolation, below it a power of v. Where `filled` is not None, all speeds below
        that one take the polynomial instead.
        """
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
        """Return the lowest x where g is resolved, and the slope of ln f over ln v there.

        The slope is that of ln g on the e-fold above, less 1, and not below 0. f goes on with it.
        """
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
        """Return f at low speeds, by the polynomial in v through f at five higher speeds.

        g has an absolute error (rounding). In f = g/v that error grows as 1/v, so that near rest f
        is better continued from higher speeds than taken from g.

        Parameters
        ----------
        i : index of the time
        log_v : ln v, v in U, shape (n,)
        log_lowest : ln of the lowest of the five speeds in U; `CONTINUED_FROM` has all
        """
        log_node = log_lowest + np.log(CONTINUED_FROM)
        f_at_nodes = self._interpolate(i, log_node + self.shift[i]) * np.exp(-log_node)
        differences = np.exp(log_v - log_lowest)[:, None] - CONTINUED_FROM
        return interpolation_rows(differences, barycentric_weights(CONTINUED_FROM)) @ f_at_nodes

    def _interpolate(self, i: int, x: FloatArray) -> HarmonicArray:
        """Evaluate g at the i-th time and at x in the window, shape (n_x,), as x.

        This is done in pieces of `TERMS_AT_ONCE`, so that memory stays flat.
        """
        rows = to_rows(self.values[i])
        n_pieces = 1 + x.size * self.grid.nodes // TERMS_AT_ONCE
        pieces = [self.grid.interpolate(rows, piece) for piece in np.array_split(x, n_pieces)]
        return from_rows(np.hstack(pieces))
