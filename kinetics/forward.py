r"""The speed density in time: the forward equation on a logarithmic speed axis, spectrally.

With Y = v (t + t0)/l, x = ln Y and tau = ln(t + t0) the inelastic Lorentz equation (paper, label
``inelaslorentz2``) has constant coefficients in tau: for the density g of x in harmonic m,

    dg/dtau = -dg/dx - Lambda (e^x g),     Lambda : symbol 1 - E[s^(-i k) cos(m chi)],

on a periodic window, by Fourier collocation: spectrally accurate for smooth states, and mass is
kept to rounding, because the symbol of m = 0 vanishes at k = 0. Where the scaling state is reached
to rounding, the stationary solution takes over and later times cost nothing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.errors import InputError
from kinetics.generator import decay_symbol, harmonic_symbol
from kinetics.grid import LogGrid
from kinetics.initial import State
from kinetics.measure import LogMeasure
from kinetics.profile import Profile, count_before_scaling, then_scaling
from kinetics.tilt import band_of, window_of

FloatArray = NDArray[np.float64]

_MAX_NODES = 8192
_STEEP = 1e4
_MOST_WORK = 1e8  # turns of the highest mode times nodes: half a minute


@dataclass(frozen=True)
class _Collocated:
    """g at the nodes, read off at any speed."""

    grid: LogGrid
    values: NDArray[Any]  # (n_times, nodes)
    shift: FloatArray  # ln((t + t0)/l), (n_times,)
    resolved: float  # share of its maximum down to which g is right

    def __call__(self, i: int, v: FloatArray) -> NDArray[Any]:
        out = np.zeros(v.shape, dtype=self.values.dtype)
        shift = self.shift[i]
        with np.errstate(divide="ignore"):
            x = np.log(v) + shift
        floor, slope = self._low_end(i)
        inside = (x <= self.grid.end) & (v > 0.0)
        # g is right to a share of its maximum: below that, and f = g/v with it, the slope of ln f
        # that it has there goes on
        at = np.clip(x[inside], floor, self.grid.end)
        with np.errstate(under="ignore"):
            fall = np.exp(slope * (x[inside] - at) - (at - shift))
            out[inside] = self._interpolate(i, at) * fall
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
        values = self.values[i]
        if not np.iscomplexobj(values):
            return self.grid.interpolate(values, x)
        real = self.grid.interpolate(values.real, x)
        return np.asarray(real + 1j * self.grid.interpolate(values.imag, x))


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
    _, scaled, deviation = window_of(law, 0.0, depth)
    scaled -= math.log(law.mean_log_loss)
    kept = high + duration
    right = max(high, min(scaled, kept))
    # too early for the ring of nearly elastic tracers to narrow
    formed = kept > -math.log(law.mean_log_loss) - 1.0
    band = band_of(law, 0.0, depth, deviation) if formed else 8.0
    if law.restitution < 0.3:
        low = min(low, -depth)
    return low - 0.5, right + 0.5, band


def solve_spectral(
    law: CollisionLaw,
    mean_free_path: float,
    state: State,
    m: int,
    times: FloatArray,
    rtol: float,
    nodes: int | None = None,
) -> Profile | None:
    """Harmonic m at the times, e < 1; None where the state is too rough for this method."""
    from scipy.integrate import solve_ivp

    start = state.harmonic(0, 1e-3 * rtol)
    profile = state.profile(m)
    if start is None or profile is None:
        return None
    depth = math.log(1.0 / rtol) + 6.0
    log_unit = 0.5 * start.log_second_moment()
    shift = np.log(times / mean_free_path + math.exp(-log_unit))
    tau = shift + log_unit
    early = count_before_scaling(law, tau, rtol) if m == 0 else tau.size
    duration = float(tau[early - 1]) if early else 0.0
    left, right, band = _window(law, start, depth, duration)
    # the drift and the losses turn the highest mode this often
    wanted = nodes or (right - left) * band / math.pi
    turns = wanted * math.pi / (right - left) * (1.0 + law.mean_log_loss * math.exp(right))
    if wanted > _MAX_NODES or turns * duration * wanted > _MOST_WORK:
        raise InputError(
            f"times: got up to {times[-1]:g} at restitution {law.restitution!r}; the density "
            f"would need {wanted:.1e} nodes, ask for other times, a larger rtol, or averages only"
        )
    grid, initial, rough = _resolve(profile, left, right, band, log_unit, rtol, nodes, m == 0)
    if rough > rtol and nodes is None:
        return None
    z = -1j * grid.wave_numbers
    loss = decay_symbol(law, z) if m == 0 else harmonic_symbol(law, z, m)
    # the highest mode of a real transform has no partner: its odd part is left out
    z[-1] = 0.0
    loss[-1] = loss[-1].real
    rate = np.exp(grid.x)
    rows = np.stack([initial.real, initial.imag]) if np.iscomplexobj(initial) else initial[None]

    def derivative(_: float, flat: FloatArray) -> FloatArray:
        g = flat.reshape(rows.shape)
        spectrum = z * np.fft.rfft(g) - loss * np.fft.rfft(rate * g)
        return np.asarray(np.fft.irfft(spectrum, grid.nodes).ravel())

    values = np.empty((early, *rows.shape))
    scale = float(np.abs(rows).max())
    now, g = 0.0, rows.ravel()
    # from one output time to the next: the dense output of the method is of lower order
    for i in range(early):
        if tau[i] > now:
            result = solve_ivp(
                derivative,
                (now, float(tau[i])),
                g,
                method="DOP853",
                t_eval=[float(tau[i])],
                rtol=max(0.01 * rtol, 3e-14),
                atol=max(0.01 * rtol, 1e-15) * scale,
                first_step=min(float(tau[i]) - now, 1.0 / float(rate[-1])),
            )
            if not result.success:
                raise RuntimeError(f"the forward equation was not integrated: {result.message}")
            g, now = result.y[:, -1], float(tau[i])
        values[i] = g.reshape(rows.shape)
    joined = values[:, 0] + 1j * values[:, 1] if rows.shape[0] == 2 else values[:, 0]
    collocated = _Collocated(grid, joined, shift[:early], rtol)
    return Profile(
        at=then_scaling(law, collocated, early, shift[early:], rtol),
        count=times.size,
        method="spectral",
        nodes=grid.nodes,
        error_estimate=max(0.1 * rtol, rough, _ends(joined), _highest_modes(joined)),
    )


def _resolve(
    profile: Any,
    left: float,
    right: float,
    band: float,
    log_unit: float,
    rtol: float,
    nodes: int | None,
    normalised: bool,
) -> tuple[LogGrid, NDArray[Any], float]:
    """A grid that resolves the start and the scaling state, g on it, and its highest modes."""
    count = nodes or int((right - left) * band / math.pi) + 2
    while True:
        count += count % 2
        grid = LogGrid(left, (right - left) / count, count)
        v = np.exp(grid.x + log_unit)
        g = np.asarray(profile(v) * v)
        if normalised:
            g = g / (float(g.sum()) * grid.spacing)  # what lies beyond the window is not missed
        spectrum = np.abs(np.fft.fft(g))
        half = count // 2
        rough = float(spectrum[half - 2 : half + 3].max() / max(float(spectrum.max()), 1e-300))
        if nodes is not None or rough <= rtol or 2 * count > _MAX_NODES:
            return grid, g, rough
        count = int(1.4 * count)


def _ends(values: NDArray[Any]) -> float:
    """Largest value at the ends of the window relative to the maximum."""
    if values.shape[0] == 0:
        return 0.0
    top = np.abs(values).max(axis=1)
    ends = np.abs(values[:, [0, 1, -2, -1]]).max(axis=1)
    return float(np.max(ends / np.maximum(top, 1e-300)))


def _highest_modes(values: NDArray[Any]) -> float:
    """Largest of the highest modes at any of the times, relative to the largest mode."""
    if values.shape[0] == 0:
        return 0.0
    spectrum = np.abs(np.fft.fft(values, axis=1))
    half = values.shape[1] // 2
    high = spectrum[:, half - 2 : half + 3].max(axis=1)
    return float(np.max(high / np.maximum(spectrum.max(axis=1), 1e-300)))
