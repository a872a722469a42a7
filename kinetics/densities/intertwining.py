r"""The equation without its collisions: any time at the cost of two Fourier transforms.

With the Mellin transform f^(z) of a harmonic the inelastic Lorentz equation (paper, label
``inelaslorentz2``) reads d f^(z)/dt = -lambda(z) f^(z+1)/l. With the gain G(z+1) = lambda(z) G(z)
(:mod:`kinetics.densities.gain`) u^ = G f^ obeys d u^(z)/dt = -u^(z+1)/l, so that

    u(v, t) = exp(-v t/l) u(v, 0) :

tracers that are lost where they collide. In x = ln v the gain is a multiplication of the Fourier
modes, z = -i k. For m = 0 it has a pole at z = 0, u tends to a constant at low speeds, and what
is transformed is w = -du/dx, w(t) = exp(-v t/l) (w(0) + (v t/l) u(0)).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.densities.gain import log_gain
from kinetics.numerics import ComplexArray, FloatArray
from kinetics.numerics.log_grid import LogGrid

_ROUNDING = 2e-16  # of doubles, relative
# Times the rounding: what a turned axis leaves of it in f, relative to the maximum
# (tests/kinetics/measurements/densities.py), and modes of a state that are not kept.
_LOSS, _NOISE = 25.0, 20.0
# Angles that are tried. Near pi/2 exp(-v t/l) falls as cos(angle): there they are closer.
_ANGLES = (*np.arange(0.0, 1.4, 0.05).tolist(), 1.43, 1.46, 1.48, 1.5, 1.52, 1.54)
_ENOUGH = 0.005  # of rtol: with less rounding than that no larger angle is tried
_FOLDED = 1e-2  # of rtol that modes folded onto those in use may leave
_TOGETHER = 20_000  # numbers of a piece of the time axis that stay in the cache


@dataclass(frozen=True)
class Turn:
    """How far the axis of ln v is turned into the complex plane, and the rounding that remains.

    Near e = 1 the gain falls steeply with k, and dividing by it raises the rounding. On the axis
    x - i angle the mode k > 0 of everything is larger by e^(k angle), which makes up for that.

    Attributes
    ----------
    angle : 0 to pi/2; 0 where the gain is flat enough
    error : what rounding leaves, relative to the maximum
    raised : ln of the most by which what is small is raised
    highest : wave number up to which modes are used
    """

    angle: float
    error: float
    raised: float
    highest: float


def choose_turn(
    law: CollisionLaw,
    kept: float,
    highest: float,
    m: int,
    rtol: float,
    nyquist: float | None = None,
) -> Turn:
    """The smallest angle that leaves little rounding, or the best one where none does.

    kept : wave number up to which the state has modes
    highest : wave number up to which modes are used
    nyquist : highest wave number of the grid, if it is another one
    """
    k = np.linspace(0.0, highest, max(32, math.ceil(0.5 * highest)) + 1)
    gain = log_gain(law, k, m).real
    best = Turn(0.0, math.inf, 0.0, highest)
    folding = 2.0 * (nyquist or highest) - highest
    for angle in _ANGLES:
        height = gain + angle * k
        raised = -float(height.min())
        # modes from there on would fold onto those that are used
        if angle and (math.pi - 2.0 * angle) * folding < -math.log(_FOLDED * rtol) + raised:
            break
        lost = float(height[k <= kept].max()) + raised
        error = _LOSS * _ROUNDING * math.exp(min(lost, 600.0))  # no overflow
        if error < best.error:
            best = Turn(angle, error, raised, highest)
        if error < _ENOUGH * rtol:
            break
    return best


def resolved(modes: ComplexArray) -> int:
    """How many modes of a state, (rows, n), stand above the rounding of the largest."""
    size = np.abs(modes).max(axis=0)
    weak = np.nonzero(size < _NOISE * _ROUNDING * size.max())[0]
    return int(weak[0]) if weak.size else size.size


@dataclass(frozen=True)
class Intertwined:
    """A harmonic of a state, without collisions.

    Attributes
    ----------
    grid : nodes of x = ln v at t = 0
    angle : of the turned axis
    fields : w and u for m = 0, u for others, at x - i angle, shape (fields, rows, nodes); rows
        are real and imaginary part of the state
    floor : u below the grid, shape (rows,)
    back : 1/(G e^(k angle)), shape (nodes/2 + 1,)
    """

    grid: LogGrid
    angle: float
    fields: NDArray[Any]
    floor: FloatArray
    back: ComplexArray

    def at(self, stretch: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """The density g of x where v t/l is expm1(stretch) at x = 0; stretch (n_times,).

        Returns by how many nodes the grid has moved down, (n_times,), g at the moved nodes,
        (n_times, rows, nodes), and the size of its highest modes, (n_times,).
        """
        nodes, spacing = self.grid.nodes, self.grid.spacing
        stretch = np.maximum(stretch, 0.0)
        moved = np.floor(stretch / spacing)
        clock = -np.expm1(-stretch) * np.exp(stretch - moved * spacing)
        speed: NDArray[Any] = np.exp(self.grid.x)
        if self.angle:
            speed = speed * np.exp(-1j * self.angle)
        far = np.minimum(moved, nodes).astype(int)
        longest = int(far.max(initial=0))
        beyond = np.zeros((*self.fields.shape[:2], longest), dtype=self.fields.dtype)
        if len(self.fields) == 2:
            beyond[1] = self.floor[:, None]
        windows = sliding_window_view(np.concatenate([beyond, self.fields], axis=2), nodes, axis=2)
        values = np.empty((stretch.size, self.floor.size, nodes))
        highest = np.empty(stretch.size)
        piece = max(1, _TOGETHER // nodes)
        for first in range(0, stretch.size, piece):
            part = slice(first, first + piece)
            rate = np.multiply.outer(clock[part], speed)[:, None, :]
            # (fields, n_times, rows, nodes)
            held = np.moveaxis(windows[:, :, longest - far[part]], 2, 1)
            now = held[0] if len(held) == 1 else held[0] + rate * held[1]
            with np.errstate(under="ignore"):
                now = np.exp(-rate) * now
            transform = np.fft.fft if self.angle else np.fft.rfft
            spectrum = transform(now)[..., : nodes // 2 + 1] * self.back
            values[part] = np.fft.irfft(spectrum, nodes)
            highest[part] = np.abs(spectrum[..., -4:-1]).max(axis=(1, 2))
        return moved, values, highest


def intertwine(
    grid: LogGrid, rows: FloatArray, gain: ComplexArray, turn: Turn, m: int
) -> Intertwined:
    """The state of harmonic m at the nodes, rows (n, nodes), with ln of its gain at the modes."""
    half, angle = grid.nodes // 2, turn.angle
    k = grid.wave_numbers
    modes = np.fft.rfft(rows)
    # the gain would amplify the rounding of higher modes
    modes[:, resolved(modes) :] = 0.0
    back = np.exp(-gain - angle * k)
    back[-1] = 0.0
    back[k > turn.highest * (1.0 + 1e-9)] = 0.0
    if angle:
        whole = np.zeros((rows.shape[0], grid.nodes), dtype=complex)
        whole[:, :half] = (modes * np.exp(gain + angle * k))[:, :half]
        # the modes -k, which the angle makes small
        whole[:, half + 1 :] = (modes * np.exp(gain - angle * k)).conj()[:, half - 1 : 0 : -1]
        k = np.concatenate([k[:half], -k[half:0:-1]])
    else:
        whole = modes * np.exp(gain)

    def inverse(modes: ComplexArray) -> NDArray[Any]:
        return np.asarray(np.fft.ifft(modes) if angle else np.fft.irfft(modes, grid.nodes))

    fields = inverse(whole)
    if m:
        return Intertwined(grid, angle, fields[None], np.zeros(rows.shape[0]), back)
    # u is the integral of w from x upwards: of its mean, and of its other modes
    mean = whole[:, :1].real / grid.nodes
    whole[:, 0] = 0.0
    whole[:, 1:] *= 1j / k[1:]
    u = inverse(whole) - mean * grid.spacing * np.arange(grid.nodes)
    u -= u[:, -1:]
    floor = mean[:, 0] * grid.spacing * grid.nodes
    return Intertwined(grid, angle, np.stack([fields, u]), floor, back)
