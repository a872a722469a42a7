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
from numpy.typing import ArrayLike, NDArray

from kinetics.collision import CollisionLaw
from kinetics.densities.gain import log_gain
from kinetics.densities.harmonic import LOWEST_SPEED
from kinetics.numerics import ComplexArray, FloatArray
from kinetics.numerics.log_grid import LogGrid

_EPSILON = 1.1e-16  # of doubles: the largest relative rounding error of one operation
_KEPT = 40.0  # epsilon of the largest mode: a smaller one is rounding, and is not kept
# Angles that are tried. Near pi/2 exp(-v t/l) falls as cos(angle): there they are closer.
_ANGLES = (*np.arange(0.0, 1.4, 0.05).tolist(), 1.43, 1.46, 1.48, 1.5, 1.52, 1.54)
_ENOUGH = 0.005  # of rtol: with less rounding than that no larger angle is tried
_FOLDED = 1e-3  # of rtol that modes folded onto those in use may leave
# Width in ln v over which a state is brought to zero at both ends of the window, by an error
# function that stops at this argument, and its value there.
TAPER, _STEEPEST = 3.0, 4.0
_LEFT = 0.5 * math.erfc(_STEEPEST)
_UNTAPERED = 1e-6  # of rtol: rounding of the highest modes that needs no such end
_AT_ENDS = 4  # nodes at which the rounding of the highest modes is looked at
_TOGETHER = 20_000  # numbers of a piece of the time axis that stay in the cache


@dataclass(frozen=True)
class Turn:
    """How far the axis of ln v is turned into the complex plane, and the rounding that remains.

    Near e = 1 the gain falls steeply with k, and dividing by it raises the rounding. On the axis
    x - i angle the mode k > 0 of everything is larger by e^(k angle), which makes up for that.

    Attributes
    ----------
    angle : 0 to pi/2; 0 where the gain is flat enough
    error : rounding that is expected in f, relative to its maximum
    raised : ln of the most by which what is small is raised
    highest : wave number up to which modes are used
    tapered : whether the window ends softly, because high modes raise their rounding above all else
    uncertain : size of that rounding
    """

    angle: float
    error: float
    raised: float
    highest: float
    tapered: bool = False
    uncertain: float = 0.0


@dataclass(frozen=True)
class Spectrum:
    """Sizes of the Fourier modes of a state.

    Attributes
    ----------
    step : between two wave numbers
    size : of the modes k = 0, step, 2 step ..., over the number of nodes
    """

    step: float
    size: FloatArray

    @property
    def kept(self) -> float:
        """The highest wave number of a mode above rounding."""
        return self.step * float(np.nonzero(self.size)[0][-1])

    @classmethod
    def of(cls, grid: LogGrid, rows: FloatArray) -> Spectrum:
        """The spectrum of the state with these values at the nodes, shape (n, nodes)."""
        modes = np.fft.rfft(rows)
        size = np.abs(modes).max(axis=0) / grid.nodes
        size[resolved(modes) :] = 0.0
        return cls(float(grid.wave_numbers[1]), size)

    def at(self, k: FloatArray) -> FloatArray:
        """ln of the size at the wave numbers k, -690 where there is nothing; shape of k."""
        known = self.step * np.arange(self.size.size)
        log_size = np.log(np.maximum(self.size, 1e-300))
        return np.asarray(np.interp(k, known, log_size, right=log_size[-1]))


def rounding_noise(raised: ArrayLike, nodes: int) -> Any:
    """Standard deviation of the rounding in a density g of ln v; it is the same at all nodes.

    A Fourier transform of n values leaves white noise of epsilon sqrt(log2 n) times their root
    mean square. Each mode of that of the field is multiplied by `back`, and the last transform
    adds its own; g is of order 1.

    raised : root mean square of the field times that of `back`, of any shape, which is returned
    """
    return _EPSILON * math.sqrt(math.log2(nodes)) * np.hypot(1.0, raised)


def error_of_noise(noise: Any) -> Any:
    """Rounding of f = g/v relative to its maximum, from the standard deviation of that of g.

    Three standard deviations, at the lowest speed at which f is promised; shape of `noise`.
    """
    return 3.0 * noise / LOWEST_SPEED


def choose_turn(
    law: CollisionLaw,
    m: int,
    spectrum: Spectrum,
    rtol: float,
    spacing: float,
    highest: float | None = None,
) -> Turn:
    """The smallest angle that leaves little rounding, or the best one where none does.

    spacing : of the nodes of ln v
    highest : wave number up to which modes are used, if not all are
    """
    nyquist = math.pi / spacing
    highest = highest or nyquist
    k = np.linspace(0.0, highest, max(32, math.ceil(0.5 * highest)) + 1)
    gain, log_size = log_gain(law, k, m).real, spectrum.at(k)
    angles = np.array(_ANGLES)
    height = gain + np.multiply.outer(angles, k)
    raised = -height.min(axis=1)
    # modes from there on would fold onto those that are used
    folding = (math.pi - 2.0 * angles) * (2.0 * nyquist - highest)
    folded = folding < raised - math.log(_FOLDED * rtol)
    folded[0] = False
    last = int(np.argmax(folded)) or angles.size
    height, raised = height[:last], raised[:last]
    # sums over the modes k and -k; exponents that would overflow belong to useless angles
    with np.errstate(under="ignore"):
        sizes = np.exp(2.0 * np.minimum(log_size + height, 300.0)).sum(axis=1)
        inverses = np.exp(-2.0 * np.maximum(height, -300.0)).sum(axis=1)
    field_and_back = np.sqrt(2.0 * k[1] / spectrum.step * sizes) * np.sqrt(
        k[1] / nyquist * inverses
    )
    noise = rounding_noise(field_and_back, round(2.0 * nyquist / spectrum.step))
    # size of the rounding of the highest modes that are kept
    uncertain = np.exp(np.minimum(height[:, k <= spectrum.kept].max(axis=1), 300.0))
    uncertain = _KEPT * _EPSILON * float(spectrum.size.max()) * uncertain
    error = error_of_noise(noise + _LEFT * uncertain)
    good = np.nonzero(error < _ENOUGH * rtol)[0]
    best = int(good[0]) if good.size else int(error.argmin())
    return Turn(
        angle=float(angles[best]),
        error=float(error[best]),
        raised=float(raised[best]),
        highest=highest,
        tapered=bool(uncertain[best] > _UNTAPERED * rtol),
        uncertain=float(uncertain[best]),
    )


def resolved(modes: ComplexArray) -> int:
    """How many modes of a state, (rows, n), stand above the rounding of the largest."""
    size = np.abs(modes).max(axis=0)
    weak = np.nonzero(size < _KEPT * _EPSILON * size.max())[0]
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
    noise : standard deviation of the rounding that is left in g
    lowest : size of w (m = 0) or u at the lower end of the grid, where it should be 0
    """

    grid: LogGrid
    angle: float
    fields: NDArray[Any]
    floor: FloatArray
    back: ComplexArray
    noise: float
    lowest: float

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


def _taper(grid: LogGrid) -> tuple[FloatArray, FloatArray]:
    """Factors that fall to zero at the lower and at the upper end of the window, (nodes,) each.

    The highest modes that are kept may be raised, and with them their rounding. They fill the
    window; a jump of theirs from one end to the other would have modes of all wave numbers.
    """
    from scipy.special import erfc

    low = 0.5 * erfc(_STEEPEST * (1.0 - 2.0 / TAPER * (grid.x - grid.x[0])))
    return low, low[::-1]


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
    field = math.sqrt(float(np.mean(np.abs(fields) ** 2, axis=1).max()))
    amplified = math.sqrt(2.0 / grid.nodes * float(np.sum(np.abs(back) ** 2)))
    noise = float(rounding_noise(field * amplified, grid.nodes))
    lowest = float(np.abs(fields[:, :_AT_ENDS]).max())
    if turn.tapered:
        ends = np.abs(fields[:, [*range(_AT_ENDS), *range(-_AT_ENDS, 0)]])
        noise += _LEFT * float(ends.max())
        low, high = _taper(grid)
        fields *= low * high
    if m:
        return Intertwined(grid, angle, fields[None], np.zeros(rows.shape[0]), back, noise, lowest)
    # u is the integral of w from x upwards: of its mean, and of its other modes
    mean = whole[:, :1].real / grid.nodes
    whole[:, 0] = 0.0
    whole[:, 1:] *= 1j / k[1:]
    u = inverse(whole) - mean * grid.spacing * np.arange(grid.nodes)
    floor = mean[:, 0] * grid.spacing * grid.nodes
    if not turn.tapered:
        u -= u[:, -1:]
    else:
        # u is 0 where the upper taper falls; one node there would have the rounding of high modes
        falling = high * (1.0 - high)
        u -= (u @ falling / falling.sum())[:, None]
        u = high * (floor[:, None] + low * (u - floor[:, None]))
    return Intertwined(grid, angle, np.stack([fields, u]), floor, back, noise, lowest)
