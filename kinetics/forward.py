r"""The speed density in time: the forward equation on a logarithmic speed axis.

With Y = v (t + t0)/l, x = ln Y and tau = ln(t + t0) the inelastic Lorentz equation (paper, label
``inelaslorentz2``) has constant coefficients in tau: for the density g of x,

    dg/dtau = -dg/dx - Lambda (e^x g),     Lambda : symbol lambda(-i k),

on a periodic window, by Fourier collocation: spectrally accurate for smooth states, and mass is
kept to rounding, because lambda(0) = 0. The window and the spacing follow from the scaling state that is approached; once it is reached to rounding, the
stationary solution takes over and later times cost nothing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.generator import decay_symbol
from kinetics.grid import LogGrid
from kinetics.scaled import ScaledVDF, solve_scaled
from kinetics.tilt import band_of, window_of

FloatArray = NDArray[np.float64]

_MAX_NODES = 16384


@dataclass(frozen=True)
class ForwardDensity:
    """The speed density of a Gaussian start at given times.

    Attributes
    ----------
    grid : nodes in x = ln(v (t + t0)/l)
    values : g at the nodes, shape (n_early, nodes), for the times before the scaling
        state is reached
    log_shift : ln((t + t0)/l) per time, shape (n_times,)
    early : how many times are in ``values``
    scaled : the stationary solution that serves the later ones
    """

    grid: LogGrid
    values: FloatArray
    log_shift: FloatArray
    early: int
    scaled: ScaledVDF | None

    def __call__(self, v: FloatArray) -> FloatArray:
        """Density of the speed at v, shape (n_times, n_v); 0 below the window."""
        out = np.zeros((self.log_shift.size, v.size))
        positive = v > 0.0
        log_v = np.log(v[positive])
        for i, shift in enumerate(self.log_shift):
            x = log_v + shift
            density = np.zeros_like(x)
            if i < self.early:
                inside = (x >= self.grid.start) & (x <= self.grid.end)
                values = self.grid.interpolate(self.values[i], x[inside])
                density[inside] = values * np.exp(-log_v[inside])
            else:
                assert self.scaled is not None
                # v0 (t + t0)/l = 2/h in the scaling state
                log_thermal = math.log(2.0 / self.scaled.cooling_rate) - shift
                c = np.exp(log_v - log_thermal)
                density = 2.0 * math.pi * c * self.scaled.vdf(c) * math.exp(-log_thermal)
            out[i, positive] = density
        return out


def solve_gaussian_density(
    law: CollisionLaw, mean_free_path: float, times: FloatArray, rtol: float
) -> ForwardDensity:
    """The speed density from the Gaussian start, e < 1; times (n_times,) in d/U."""
    from scipy.integrate import solve_ivp

    # t0 = l/U: then x = ln(v/U) at t = 0
    log_shift = np.log(times / mean_free_path + 1.0)
    depth = math.log(1.0 / rtol) + 6.0
    _, right, deviation = window_of(law, 0.0, depth)
    right -= math.log(law.mean_log_loss)
    right = max(right, 0.5 * math.log(2.0 * depth + 20.0))
    # the density of ln v falls as v^2 at the start; at e = 0 bounces fill it up to v^1
    left = -depth / (1.0 if law.restitution < 0.3 else 2.0)
    band = max(band_of(law, 0.0, depth, deviation), 4.0 / math.pi * depth)
    nodes = int((right - left) * band / math.pi) + 2
    nodes = min(_MAX_NODES, nodes + nodes % 2)
    grid = LogGrid(left, (right - left) / nodes, nodes)
    z = -1j * grid.wave_numbers
    loss = decay_symbol(law, z)
    # the highest mode of a real transform has no partner: its odd part is left out
    z[-1] = 0.0
    loss[-1] = loss[-1].real
    rate = np.exp(grid.x)

    def derivative(_: float, values: FloatArray) -> FloatArray:
        spectrum = z * np.fft.rfft(values) - loss * np.fft.rfft(rate * values)
        return np.asarray(np.fft.irfft(spectrum, nodes))

    start = np.exp(2.0 * grid.x - 0.5 * np.exp(2.0 * grid.x))
    # the slowest transient falls as e^-tau
    saturated = -math.log(law.mean_log_loss) + math.log(1.0 / rtol) + 4.0
    early = int(np.searchsorted(log_shift, saturated))
    values = np.empty((early, nodes))
    if early:
        result = solve_ivp(
            derivative,
            (0.0, max(float(log_shift[early - 1]), 1e-12)),
            start,
            method="DOP853",
            t_eval=log_shift[:early],
            rtol=max(0.01 * rtol, 3e-14),
            atol=0.01 * rtol * float(start.max()),
        )
        if not result.success:
            raise RuntimeError(f"the forward equation was not integrated: {result.message}")
        values = np.asarray(result.y.T)
    scaled = solve_scaled(law.restitution, max(rtol, 1e-13)) if early < times.size else None
    return ForwardDensity(grid, values, log_shift, early, scaled)
