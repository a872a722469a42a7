r"""The equation without its collisions: any time at the cost of two Fourier transforms.

With the Mellin transform f^(z) of a harmonic the inelastic Lorentz equation (paper, label
``inelaslorentz2``) reads d f^(z)/dt = -lambda(z) f^(z+1)/l. With the gain G, G(z+1) = lambda(z)
G(z), u^ = G f^ obeys d u^(z)/dt = -u^(z+1)/l, so that u(v, t) = exp(-v t/l) u(v, 0): tracers that
are lost where they collide. In x = ln v the gain multiplies the Fourier modes, z = -i k.
For m = 0 it has a pole at z = 0, u tends to a constant at low speeds, and what is transformed is
w = -du/dx, w(t) = exp(-v t/l) (w(0) + (v t/l) u(0)). With a tilt, where v^tilt times the density is
transformed, z = tilt - i k and there is no pole.

Near e = 1 the gain falls steeply with k, and dividing by it raises the rounding. On the axis
x - i angle the mode k > 0 of everything is larger by e^(k angle), which makes up for that.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.numerics import FOLDS, ROUNDING, ComplexArray, FloatArray
from kinetics.numerics.gauss import gauss_legendre
from kinetics.numerics.log_grid import LogGrid
from kinetics.numerics.recurrence import log_growth, taylor_of_log

# At this real part, with this many Taylor coefficients, the Euler-Maclaurin formula leaves
# 2 * 8!/((2 pi)^10 24^9) = 3e-16 (see `log_growth`).
_TOP, _ORDERS = 24, 8
SHARE = 0.005  # of what is aimed at, for each of many small parts of the error
_TOGETHER = 20_000  # numbers of a piece of a table that stay in the cache; it changes no result
_KEPT = 24.0 * ROUNDING  # of the largest mode of a state: a smaller one is not kept


def log_gain(law: CollisionLaw, k: FloatArray, m: int = 0, tilt: float = 0.0) -> ComplexArray:
    """ln of G(z)/G(tilt) at z = tilt - i k; for m = 0 without tilt of z G(z), over its limit at 0.

    k : equidistant from 0 on, shape (n,), spaced by less than 0.5 for an error of 1e-13; the law
    loses energy. Branches are not followed: only exp of the result has a meaning.
    """
    if m == 0 and law.uniform_power == 1.0:
        # lambda = z/(1 + z), G = 1/z
        return -np.log(1.0 - 1j * k / tilt) if tilt else np.zeros(k.size, dtype=complex)
    q = law.quadrature_for(float(k[-1]), m)
    kept = q.weight > math.exp(-FOLDS) * q.weight.max()
    xi, weight, turned = q.log_loss[kept], q.weight[kept], 1.0 - q.harmonic_loss(m)[kept]
    steps = tilt + np.arange(_TOP + 1.0)
    powers = np.exp(-np.multiply.outer(xi, steps))
    # Between two wave numbers, h < 0.5 apart, three Gauss points leave (3!)^4/(7 (6!)^3) h^7 = 4e-9
    # of the sixth derivative of ln lambda, which is about 5!/24^6 = 6e-7. At z + d
    # 1 - s^(z + d) = (1 - s^z) s^d + 1 - s^d
    node, between = gauss_legendre(3)
    step = k[1] - k[0]
    onward = powers[:, -1:] * np.exp(1j * np.multiply.outer(xi, step * node))
    orders = np.arange(1.0, _ORDERS)
    taylor = powers[:, -1:] * np.cumprod(-xi[:, None] / orders, axis=1)
    factors = (weight * turned)[:, None] * np.hstack([powers, onward.real, onward.imag, taylor])
    rate, real, imag, slopes = np.split(
        _averages(k, xi, factors), np.cumsum([steps.size, node.size, node.size]), axis=1
    )
    # lambda on the real axis, each relative to itself
    on_axis = -weight @ np.expm1(-np.multiply.outer(xi, steps))
    if m:
        on_axis = on_axis + (1.0 - turned) @ (weight[:, None] * powers)
    rate = rate + on_axis
    below_top = law.met_again(steps - 1j * k[:, None], rate, m)
    if m == 0 and not tilt:
        lowest = np.ones(k.size, dtype=complex)
        lowest[1:] = -1j * k[1:] * law.mean_log_loss / below_top[1:, 0]
    else:
        lowest = below_top[0, 0] / below_top[:, 0]
    below = lowest * np.prod(below_top[0, 1:-1] / below_top[:, 1:-1], axis=1)
    # the integral of ln lambda from N up to N + z, and corrections at its end
    half = np.multiply.outer(xi, 0.5 * step * node)
    short = 2.0 * np.sin(half) * (np.sin(half) - 1j * np.cos(half))  # 1 - s^d
    along = (real + 1j * imag)[:-1] + (weight * turned * powers[:, -1]) @ short + on_axis[-1]
    along = law.met_again(steps[-1] - 1j * (k[:-1, None] + step * node), along, m)
    integral = np.zeros(k.size, dtype=complex)
    integral[1:] = -1j * step * np.cumsum(np.log(along) @ between)
    # lambda' = -E[s^z (-xi)], and so on, s^z = 1 - (1 - s^z)
    slopes = slopes - factors[:, -orders.size :].sum(axis=0)
    end = taylor_of_log(law.taylor_met_again(steps[-1] - 1j * k, [rate[:, -1], *slopes.T], m))
    return np.asarray(log_growth(integral, [c[0] for c in end], end) + np.log(below))


def _averages(k: FloatArray, xi: FloatArray, factors: FloatArray) -> ComplexArray:
    """Sums of (1 - s^z) times factors (points, columns), shape (n, columns)."""
    # half angles, where it keeps its digits, are sums of two from short tables: half of the time
    stride = math.ceil(math.sqrt(k.size))
    far = np.multiply.outer(0.5 * k[::stride], xi)[:, None]
    near = np.multiply.outer(0.5 * k[:stride], xi)
    sin_near, cos_near = np.sin(near), np.cos(near)
    out = np.empty((far.shape[0] * stride, factors.shape[1]), dtype=complex)
    piece = max(1, _TOGETHER // (stride * xi.size))
    for first in range(0, far.shape[0], piece):
        sin_far, cos_far = np.sin(far[first : first + piece]), np.cos(far[first : first + piece])
        sine = (sin_far * cos_near + cos_far * sin_near).reshape(-1, xi.size)
        cosine = (cos_far * cos_near - sin_far * sin_near).reshape(-1, xi.size)
        rows = slice(first * stride, first * stride + sine.shape[0])
        out.real[rows] = (2.0 * sine * sine) @ factors
        out.imag[rows] = (-2.0 * sine * cosine) @ factors
    return out[: k.size]


# Angles that are tried. Near pi/2 exp(-v t/l) falls as cos(angle): there they are closer.
_ANGLES = (*np.arange(0.0, 1.4, 0.05).tolist(), 1.43, 1.46, 1.48, 1.5, 1.52, 1.54)
# Width in ln v over which a state on a turned axis is brought to zero at both ends of the window,
# by an error function that stops at this argument; and its value there, with a margin for g over v.
TAPER, _STEEPEST, _ENDS = 3.0, 4.0, 1e-4


def modes_of(rows: FloatArray) -> ComplexArray:
    """The Fourier modes of a state, rows (n, nodes), without those that are rounding."""
    modes = np.fft.rfft(rows)
    size = np.abs(modes).max(axis=0)
    weak = np.nonzero(size < _KEPT * size.max())[0]
    # the gain would amplify the rounding of higher modes
    modes[:, weak[0] if weak.size else size.size :] = 0.0
    return np.asarray(modes)


def choose_angle(
    gain_at: Callable[[FloatArray], ComplexArray], grid: LogGrid, rows: FloatArray, spacing: float,
    rtol: float,
) -> tuple[float, float]:  # fmt: skip
    """The angle of the axis for a state on a grid, and ln of the largest 1/gain.

    The angle is the smallest that leaves next to nothing of rtol to rounding, or the best one: what
    rounding leaves of f at the lowest speeds is guessed, with a margin, for the choice only.
    gain_at : ln of the gain at wave numbers
    spacing : of the nodes that are to be used
    """
    nyquist = math.pi / spacing
    # the gain is a smooth function: wave numbers four apart do for sizes
    k = np.linspace(0.0, nyquist, max(64, math.ceil(0.25 * nyquist)) + 1)
    size = np.abs(modes_of(rows)).max(axis=0) / grid.nodes
    log_size = np.interp(k, grid.wave_numbers, np.log(np.maximum(size, 1e-300)), right=-690.0)
    angles = np.array(_ANGLES)
    height = gain_at(k).real + np.multiply.outer(angles, k)
    raised = -height.min(axis=1)
    lost = raised + (log_size + height).max(axis=1) + math.log(4.0 * _KEPT)
    # the rounding of the highest modes that are kept fills the window up to its ends
    jump = height[:, log_size > -690.0].max(axis=1) + log_size.max()
    lost = np.maximum(lost, jump + math.log(_KEPT * _ENDS))
    good = lost < max(float(lost.min()), math.log(SHARE * rtol))
    best = int(good.argmax()) if good.any() else int(lost.argmin())
    return float(angles[best]), float(raised[best])


@dataclass(frozen=True)
class Intertwined:
    """A harmonic of a state, without collisions."""

    grid: LogGrid  # nodes of x = ln v at t = 0
    angle: float  # of the turned axis
    # w and u where the gain has a pole, else u, at x - i angle, shape (fields, rows, nodes); rows
    # are real and imaginary part of the state
    fields: NDArray[Any]
    floor: FloatArray  # u below the grid, shape (rows,)
    back: ComplexArray  # 1/(G e^(k angle)), shape (nodes/2 + 1,)

    def at(self, stretch: FloatArray, stride: int) -> tuple[FloatArray, FloatArray]:
        """The density g of x where v t/l is expm1(stretch) at x = 0; stretch (n_times,).

        Returns by how many nodes the grid has moved down, multiples of ``stride``, (n_times,), and
        g at the moved nodes, (n_times, rows, nodes).
        """
        nodes, spacing = self.grid.nodes, self.grid.spacing
        stretch = np.maximum(stretch, 0.0)
        moved = stride * np.floor(stretch / (stride * spacing))
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
            values[part] = np.fft.irfft(transform(now)[..., : nodes // 2 + 1] * self.back, nodes)
        return moved, values


def intertwine(
    grid: LogGrid, rows: FloatArray, gain: ComplexArray, angle: float, pole: bool
) -> Intertwined:
    """The state at the nodes, rows (n, nodes), with ln of its gain at the modes.

    pole : whether that is of z G, at z = -i k
    """
    half = grid.nodes // 2
    k = grid.wave_numbers
    modes = modes_of(rows)
    back = np.exp(-gain - angle * k)
    back[-1] = 0.0
    gain = np.where(np.any(modes != 0.0, axis=0), gain, -angle * k)  # others may overflow
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

    low = np.ones(grid.nodes)
    if angle:  # factors that fall to zero at the lower and, turned round, at the upper end
        from scipy.special import erfc

        low = 0.5 * erfc(_STEEPEST * (1.0 - 2.0 / TAPER * (grid.x - grid.x[0])))
    high = low[::-1]
    w = inverse(whole) * (low * high)
    if not pole:
        return Intertwined(grid, angle, w[None], np.zeros(rows.shape[0]), back)
    # u is the integral of w from x upwards: of its mean, and of its other modes
    mean = whole[:, :1].real / grid.nodes
    whole[:, 0] = 0.0
    whole[:, 1:] *= 1j / k[1:]
    u = inverse(whole) - mean * grid.spacing * np.arange(grid.nodes)
    floor = mean[:, 0] * grid.spacing * grid.nodes
    if angle:
        # u is 0 where the upper taper falls; one node there would have the rounding of high modes
        falling = high * (1.0 - high)
        u -= (u @ falling / falling.sum())[:, None]
        u = high * (floor[:, None] + low * (u - floor[:, None]))
    else:
        u -= u[:, -1:]
    return Intertwined(grid, angle, np.stack([w, u]), floor, back)
