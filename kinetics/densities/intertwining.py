r"""The equation without its collisions: any time at the cost of two Fourier transforms.

v is the speed, l the mean free path. With the Mellin transform f^(z), the integral of v^z f_m(v)
over v, of a harmonic f_m, and lambda(z) = 1 - E[s^z cos(m chi)] of the collision law, the inelastic
Lorentz equation (paper, label ``inelaslorentz2``) reads d f^(z)/dt = -lambda(z) f^(z+1)/l. With the
gain G, G(z+1) = lambda(z) G(z) (`gain`), u^ = G f^ obeys d u^(z)/dt = -u^(z+1)/l, so that u(v, t) =
exp(-v t/l) u(v, 0): tracers that are lost where they collide. In x = ln v the gain multiplies the
Fourier modes, z = -i k. With a tilt, where v^tilt times the density is transformed, z = tilt - i k.

For m = 0 without tilt, G has a pole at z = 0, u tends to a constant at low speeds, and what is
transformed is w = -du/dx, w(t) = exp(-v t/l) (w(0) + (v t/l) u(0)).

The axis may be turned, x - i angle (`turned_axis`). Begin with :func:`intertwine`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from kinetics.densities.gain import NUMBERS_IN_CACHE
from kinetics.densities.harmonic import HarmonicArray
from kinetics.densities.turned_axis import significant_modes, taper
from kinetics.numerics import ComplexArray, FloatArray
from kinetics.numerics.log_grid import LogGrid


@dataclass(frozen=True)
class Intertwined:
    """A harmonic of a state without collisions, at t = 0.

    Rows, shape (n_rows,), are the real and the imaginary part of the state, or the real one alone.

    Parameters
    ----------
    grid : nodes of x = ln v, in the unit of speed for which the state was taken
    angle : angle of the turned axis in radians; fields are real at 0
    transformed : w if the gain has a pole, else u, at x - i angle, shape (n_rows, nodes)
    u : u itself if the gain has a pole, same shape; else None
    u_below : the constant that u is below the grid, shape (n_rows,)
    inverse_gain : 1/(G e^(k angle)) at the modes, shape (nodes/2 + 1,)
    """

    grid: LogGrid
    angle: float
    transformed: HarmonicArray
    u: HarmonicArray | None
    u_below: FloatArray
    inverse_gain: ComplexArray

    def at(self, stretch: FloatArray, stride: int) -> tuple[FloatArray, FloatArray]:
        """Evaluate the density g of x at times; the grid follows the tracers as they slow down.

        Parameters
        ----------
        stretch : ln(1 + v t/l), v the unit of speed, shape (n_times,)
        stride : the grid moves by multiples of so many nodes

        Returns
        -------
        By how many nodes the grid has moved down, (n_times,), and g there, (n_times, n_rows,
        nodes).
        """
        nodes = self.grid.nodes
        spacing = self.grid.spacing
        stretch = np.maximum(stretch, 0.0)
        n_moved = stride * np.floor(stretch / (stride * spacing))
        # v t/l at the node x = 0 of the moved grid
        path_at_unit_speed = -np.expm1(-stretch) * np.exp(stretch - n_moved * spacing)
        speed = np.exp(self.grid.x)
        if self.angle:
            speed = speed * np.exp(-1j * self.angle)
        # farther down than the whole grid it stays the same
        n_below = np.minimum(n_moved, nodes).astype(int)
        transformed = _MovedField.of(self.transformed, n_below, np.zeros(self.u_below.size))
        u = None if self.u is None else _MovedField.of(self.u, n_below, self.u_below)
        densities = np.empty((stretch.size, self.u_below.size, nodes))
        n_at_once = max(1, NUMBERS_IN_CACHE // nodes)
        for begin in range(0, stretch.size, n_at_once):
            times = slice(begin, begin + n_at_once)
            path = np.multiply.outer(path_at_unit_speed[times], speed)[:, None, :]
            field = transformed.at(times)
            if u is not None:
                field = field + path * u.at(times)
            with np.errstate(under="ignore"):
                field = np.exp(-path) * field
            densities[times] = self._with_collisions(field)
        return n_moved, densities

    def _with_collisions(self, field: HarmonicArray) -> FloatArray:
        """Return g from w or u on the turned axis, nodes on the last axis."""
        nodes = self.grid.nodes
        modes = np.fft.fft(field) if self.angle else np.fft.rfft(field)
        half = modes[..., : nodes // 2 + 1]
        return np.fft.irfft(half * self.inverse_gain, nodes)


@dataclass(frozen=True)
class _MovedField:
    """A field on grids that have moved down, beyond whose lower end it is constant.

    Parameters
    ----------
    windows : the field on a grid that has moved down by 0 ... ``longest`` nodes, the farthest
        first, a view of shape (n_rows, longest + 1, nodes)
    n_below : by how many nodes the grid has moved down, shape (n_times,)
    longest : the largest of these
    """

    windows: HarmonicArray
    n_below: NDArray[np.intp]
    longest: int

    @classmethod
    def of(
        cls, field: HarmonicArray, n_below: NDArray[np.intp], value_below: FloatArray
    ) -> _MovedField:
        """Continue a field (n_rows, nodes) by its value below the grid, (n_rows,)."""
        longest = int(n_below.max(initial=0))
        below = np.repeat(value_below[:, None], longest, axis=1)
        continued = np.concatenate([below, field], axis=1)
        windows = sliding_window_view(continued, field.shape[1], axis=1)
        return cls(windows, n_below, longest)

    def at(self, times: slice) -> HarmonicArray:
        """Return the field at some of the times, shape (n, n_rows, nodes)."""
        moved = self.windows[:, self.longest - self.n_below[times]]
        return np.moveaxis(moved, 1, 0)


def intertwine(
    grid: LogGrid, rows: FloatArray, gain: ComplexArray, angle: float, has_pole: bool
) -> Intertwined:
    """Take the collisions out of a state.

    Parameters
    ----------
    grid : nodes of x = ln v
    rows : g at the nodes, real and imaginary part, shape (n_rows, nodes)
    gain : ln of the gain at the modes, shape (nodes/2 + 1,)
    angle : angle of the turned axis
    has_pole : whether that is the gain of z G, at z = -i k
    """
    k = grid.wave_numbers
    modes = significant_modes(rows)
    inverse_gain = np.exp(-gain - angle * k)
    inverse_gain[-1] = 0.0
    is_significant = np.any(modes != 0.0, axis=0)
    gain = np.where(is_significant, gain, -angle * k)  # others may overflow
    all_modes, all_k = _modes_on_turned_axis(modes, gain, k, angle)
    low_taper = taper(grid) if angle else np.ones(grid.nodes)
    high_taper = low_taper[::-1]
    transformed = _from_modes(all_modes, grid.nodes, angle) * (low_taper * high_taper)
    if not has_pole:
        nothing = np.zeros(rows.shape[0])
        return Intertwined(grid, angle, transformed, None, nothing, inverse_gain)
    # u is the integral of w from x upwards: of its mean, and of its other modes
    mean = all_modes[:, :1].real / grid.nodes
    all_modes[:, 0] = 0.0
    all_modes[:, 1:] *= 1j / all_k[1:]
    integral_of_mean = mean * grid.spacing * np.arange(grid.nodes)
    u = _from_modes(all_modes, grid.nodes, angle) - integral_of_mean
    u_below = mean[:, 0] * grid.spacing * grid.nodes
    if angle:
        # u is 0 where the upper taper falls; one node there would have the rounding of high modes
        falling = high_taper * (1.0 - high_taper)
        u -= (u @ falling / falling.sum())[:, None]
        u = high_taper * (u_below[:, None] + low_taper * (u - u_below[:, None]))
    else:
        u -= u[:, -1:]
    return Intertwined(grid, angle, transformed, u, u_below, inverse_gain)


def _modes_on_turned_axis(
    modes: ComplexArray, gain: ComplexArray, k: FloatArray, angle: float
) -> tuple[ComplexArray, FloatArray]:
    """Return G times the modes of a state on the turned axis, and their wave numbers.

    On the real axis the modes k >= 0 are all; else -k follow, which the angle makes small.
    """
    if not angle:
        return modes * np.exp(gain), k
    half = k.size - 1
    all_modes = np.zeros((modes.shape[0], 2 * half), dtype=complex)
    all_modes[:, :half] = (modes * np.exp(gain + angle * k))[:, :half]
    negative_modes = (modes * np.exp(gain - angle * k)).conj()
    all_modes[:, half + 1 :] = negative_modes[:, half - 1 : 0 : -1]
    return all_modes, np.concatenate([k[:half], -k[half:0:-1]])


def _from_modes(modes: ComplexArray, nodes: int, angle: float) -> HarmonicArray:
    """Return a field at the nodes from its modes on the turned axis, (n_rows, nodes)."""
    if angle:
        return np.asarray(np.fft.ifft(modes))
    return np.asarray(np.fft.irfft(modes, nodes))
