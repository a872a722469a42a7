r"""The distribution of the displacement: g(r, t), and what the scaled G(R) is made of.

With F(k, t), the average of exp(i k.r) over the start and the paths, in the plane and in space

    g(r, t) = r integral of k J_0(k r) F(k, t) dk,
    g(r, t) = (2/pi) r^2 integral of k^2 sin(k r)/(k r) F(k, t) dk

(paper, section on the position distribution). Tracers that have not collided are kept apart. Those
of one sharp speed that have collided once or twice leave a front too: before some ten mean free
times G(R) is right to about 1e-2 beside it, and the error estimate says so.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import panels_of
from kinetics.position.directions import element, mean_phase, surface
from kinetics.position.wave_numbers import PowerTail, WavePanel
from kinetics.results import Value
from kinetics.states.state import State

# Edges of the panels that shares are summed on, in sqrt(<r^2>).
_EDGES = np.concatenate([np.geomspace(1e-3, 0.1, 8), np.linspace(0.2, 6.0, 30), [7, 8, 10, 15, 50]])


@dataclass(frozen=True)
class Uncollided(Value):
    """Tracers that have not collided, from a start with the density f of the speed: f(r/t)
    exp(-r/l)/t; from sharp speeds they are on fronts, and the density is 0.

    mean_free_path in d, times (n_times,) in d/U
    """

    state: State
    mean_free_path: float
    times: FloatArray

    @property
    def fronts(self) -> tuple[FloatArray, FloatArray]:
        """Radius in d, and share of all tracers, of each sharp speed, (n_times, n_speeds) each."""
        speed, share = self.state.peaks or (np.zeros(0), np.zeros(0))
        with np.errstate(over="ignore", under="ignore"):
            radius = np.outer(self.times, speed)
            return radius, share * np.exp(-radius / self.mean_free_path)

    def fastest(self, rtol: float) -> float:
        """The largest of sharp speeds; for densities, one that all but about rtol keep below."""
        if self.state.peaks is not None:
            return float(np.max(self.state.peaks[0]))
        found = self.state.harmonic(0, rtol)
        assert found is not None  # harmonic 0 is never zero
        return float(np.exp(found.x.max()))

    def at(self, time: int, r: FloatArray) -> FloatArray:
        """Density in 1/d at radii r in d, shape (n_r,)."""
        profile, t = self.state.profile(0), self.times[time]
        if profile is None or t == 0.0:
            return np.zeros(r.shape)
        with np.errstate(under="ignore", over="ignore"):
            left = np.exp(-r / self.mean_free_path)
            # where none is left, the speed is not asked for: it may be larger than any number
            f = np.asarray(profile(np.where(left > 0.0, r / t, 0.0)).real)
            # a speed density is not negative: what is below zero is rounding
            return np.where(left > 0.0, np.maximum(f, 0.0) * left / t, 0.0)


@dataclass(frozen=True)
class Displacement(Value):
    """g(r, t) at the times of a scene. Numbers and arrays only; the methods compute from them.

    panels, tails : F of the collided on intervals of k l, and beyond for each time, None if nothing
    cut : k l from which F is tapered, for each time; infinite where it ends by itself
    reach : radius beyond which there is nothing, in d, shape (n_times,)
    error_estimate : absolute, of G(R)
    systems : how many systems of so many equations were solved, by their size
    """

    uncollided: Uncollided
    root_mean_square: FloatArray
    panels: tuple[WavePanel, ...]
    tails: tuple[PowerTail | None, ...]
    cut: FloatArray
    reach: FloatArray
    error_estimate: float
    systems: Mapping[int, int]
    dimension: int = 2

    @property
    def mean_free_path(self) -> float:
        """l in d."""
        return self.uncollided.mean_free_path

    @property
    def wave_numbers(self) -> int:
        """How many were solved for."""
        return sum(panel.wave_numbers.size for panel in self.panels)

    def density(self, time: int, r: FloatArray) -> FloatArray:
        """g(r, t) without delta peaks, in 1/d, shape (n_r,)."""
        path, near = self.mean_free_path, np.minimum(r, self.reach[time])
        collided = element(near / path, self.dimension) * (self._transform(time, r) / path)
        return np.asarray(collided + self.uncollided.at(time, r))

    def within(self, time: int, r: FloatArray) -> FloatArray:
        """Share of all tracers within r, the uncollided among them, shape (n_r,)."""
        near = np.minimum(r, self.reach[time])
        with np.errstate(over="ignore"):
            kinks = self.uncollided.state.kinks * self.uncollided.times[time]
        inner = np.concatenate([[0.0], kinks, self.root_mean_square[time] * _EDGES])
        edges = np.unique(np.append(near, inner[inner <= self.reach[time]]))
        x, weight = panels_of(np.stack([edges[:-1], edges[1:]], axis=1), 8)
        shares = (weight * self.density(time, x.ravel()).reshape(x.shape)).sum(axis=1)
        sums = np.append(0.0, np.cumsum(shares))
        radius, weight = (part[time] for part in self.uncollided.fronts)
        front = weight @ (radius[:, None] <= r)
        return np.asarray(sums[np.searchsorted(edges, near)] + front)

    def collided_in_place(self, time: int, r: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Density of the collided in the plane, or in space, and its slope, (n_r,) each.

        In 1/d^2 and 1/d^3 in the plane, in 1/d^3 and 1/d^4 in space.
        """
        step = 1e-3 * r
        at = r + step * np.array([-2.0, -1.0, 1.0, 2.0, 0.0])[:, None]
        values = self._transform(time, at.ravel()).reshape(at.shape)
        for _ in range(self.dimension):  # the power of l may overflow
            values = values / self.mean_free_path
        values = values / surface(self.dimension)
        with np.errstate(divide="ignore", invalid="ignore"):
            slope = np.array([1.0, -8.0, 8.0, -1.0]) @ values[:4] / (12.0 * step)
        return values[4], slope

    def _transform(self, time: int, r: FloatArray) -> FloatArray:
        """The radial density of the collided over r^(d-1), l = 1; 0 out of reach."""
        out = np.zeros(r.shape)
        inside = r <= self.reach[time]
        rho = r[inside] / self.mean_free_path
        if rho.size == 0:
            return out
        tail = self.tails[time]
        total = np.zeros(rho.shape) if tail is None else tail.transform(rho)
        for panel in self.panels:
            f = panel.of(time)
            if f is None:
                continue
            # points for a polynomial through the nodes times J_0 over twice `half`
            half = 0.5 * (float(rho.max()) * (panel.high - panel.low))
            points = 8.0 + 0.5 * (2 * f.size + 8 + half) + 2.5 * half ** (1.0 / 3.0)
            k, weight, values = panel.gauss(f, 8 * math.ceil(points / 8.0))
            if tail is None and panel.high > self.cut[time]:
                # tapered over a factor of two: a sharp end would leave oscillations everywhere
                level = np.clip(k / self.cut[time] - 1.0, 0.0, 1.0)
                values = values * np.cos(0.5 * math.pi * level) ** 2
            factor = k if self.dimension == 2 else 2.0 / math.pi * k**2
            total += mean_phase(np.outer(rho, k), self.dimension) @ (weight * values * factor)
        out[inside] = total
        return out
