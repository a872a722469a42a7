"""The density at a velocity, by the integral over the last free flight that ends there.

Tracers that leave a collision with the velocity w are accelerated, and arrive at v after the time s
with w = v - s along the field, if they do not collide before. So with G(w, t) the density that
collisions make per unit time,

    f(v, t) = f of those without a collision + integral over s of exp(-way) G(v - s, t - s).

G is smooth where f is not: on the ray along the field, on which tracers have come by rest.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from kinetics.field.first_collision import angular, free_way
from kinetics.field.panels import SpeedPanels
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import gauss_legendre

_POINTS, _STEADY_POINTS = 8, 12  # Gauss points of an interval of the flight
_NEAR = np.array([-16.0, -4.0, -1.0, 1.0, 4.0, 16.0])  # intervals about the slowest point
_EQUAL = 5  # intervals of equal lengths
_PIECE, _STEADY_PIECE = 4000, 500  # velocities at once
_TOGETHER = 4000  # points of flights, so few that their harmonics stay in the cache
_HALVINGS = 40
_CLOSER = 4.0 ** np.arange(3.0, 30.0)  # further intervals, up to the end of the first panel


class LastFlights:
    """Keeps what collisions make in each step of time, and integrates over it.

    Parameters
    ----------
    panels, dimension : on which the density is solved
    longest : flights longer than so many mean free paths are left out
    rows : the interpolation in a step of time, as `RadauRule.rows`; None for a steady state
    """

    def __init__(
        self,
        panels: SpeedPanels,
        dimension: int,
        longest: float,
        rows: Callable[[FloatArray], FloatArray] | None = None,
    ) -> None:
        self._panels, self._dimension, self._longest, self._rows = panels, dimension, longest, rows
        self._starts: list[float] = []
        self._lengths: list[float] = []
        self._gains: list[list[FloatArray]] = []
        self._shape = (0, 0)

    def keep(self, now: float, h: float, made: FloatArray) -> None:
        """v times what collisions make in a step, (points in time, families, M + 1, size)."""
        self._shape = families, count = made.shape[1], made.shape[2]
        by_node = np.moveaxis(made, -1, 1)
        flat = [by_node[:, p].reshape(-1, families * count) for p in self._panels.parts]
        self._starts.append(now)
        self._lengths.append(h)
        self._gains.append(flat)

    def density(self, time: float, along: FloatArray, across: FloatArray) -> FloatArray:
        """f at the velocities (n,) of tracers after a collision, in units of sqrt(g l)."""
        if time <= 0.0:
            return np.zeros(along.shape)
        pieces = max(1, along.size // (_PIECE if self._rows else _STEADY_PIECE))
        split = zip(np.array_split(along, pieces), np.array_split(across, pieces), strict=True)
        return np.concatenate([self._piece(time, *both) for both in split])

    def _piece(self, time: float, along: FloatArray, across: FloatArray) -> FloatArray:
        """The same, of a few velocities."""
        back = -along  # a flight backwards is one from -v
        last = self._last(time, back, across)
        near = self._breaks(along, np.abs(across))
        equal = last[:, None] * (np.arange(_EQUAL + 1.0) / _EQUAL)
        ends = np.sort(np.concatenate([np.clip(near, 0.0, last[:, None]), equal], axis=1), axis=1)
        width = np.diff(ends, axis=1)
        which, interval = np.nonzero(width > 1e-13 * last[:, None])
        x, w = gauss_legendre(_POINTS if self._rows else _STEADY_POINTS)
        length = width[which, interval][:, None]
        s = (ends[which, interval][:, None] + length * x).ravel()
        at = np.repeat(which, x.size)
        chance = np.exp(-free_way(back[at], across[at], s)) * (length * w).ravel()
        made = self._made(along[at] - s, across[at], time - s)
        return np.asarray(np.bincount(at, chance * made, along.size), dtype=float)

    def _breaks(self, along: FloatArray, across: FloatArray) -> FloatArray:
        """Times of flight between which G is smooth: about the slowest point, (n, n_breaks)."""
        edges = self._panels.edges
        around = across[:, None] * _NEAR
        if self._rows is None:
            closer = np.minimum(across[:, None] * _CLOSER, edges[1])
            panels = np.sqrt(np.maximum(np.array(edges[1:]) ** 2 - across[:, None] ** 2, 0.0))
            around = np.concatenate([around, closer, -closer, panels, -panels], axis=1)
        return along[:, None] + around

    def _last(self, time: float, along: FloatArray, across: FloatArray) -> FloatArray:
        """Where the integral over the time of flight may end, (n,)."""
        low, high = np.zeros(along.size), np.full(along.size, time)
        high = np.minimum(high, np.sqrt(2.0 * self._longest) + 2.0 * np.maximum(-along, 0.0))
        whole = free_way(along, across, high) < self._longest
        low = np.where(whole, high, low)
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            short = free_way(along, across, middle) < self._longest
            low, high = np.where(short, middle, low), np.where(short, high, middle)
        return high

    def _made(self, along: FloatArray, across: FloatArray, time: FloatArray) -> FloatArray:
        """G at velocities and times, (n,)."""
        panels, (families, count) = self._panels, self._shape
        v = np.hypot(along, across)
        inside = (v < panels.highest) & (v > 0.0)
        safe = np.where(v > 0.0, v, 1.0)
        cosine, sine = np.where(v > 0.0, along / safe, 1.0), across / safe
        v = np.minimum(v, panels.highest)
        starts = np.array(self._starts)
        step = np.clip(np.searchsorted(starts, time, side="right") - 1, 0, None)
        key = step * len(panels.counts) + panels.panel_of(v)
        order = np.argsort(key, kind="stable")
        out = np.zeros(v.size)
        changes = np.nonzero(np.diff(key[order]))[0] + 1
        for group in np.split(order, np.union1d(changes, np.arange(0, v.size, _TOGETHER))):
            if group.size == 0:
                continue
            s, p = divmod(int(key[group[0]]), len(panels.counts))
            both = panels.rows(p, v[group, None] - panels.speeds[panels.parts[p]])
            if self._rows is not None:
                in_time = self._rows((time[group] - starts[s]) / self._lengths[s])
                both = (in_time[:, :, None] * both[:, None, :]).reshape(group.size, -1)
            found = both @ self._gains[s][p]
            tables = angular(cosine[group], sine[group], count, self._dimension, families)
            for family in range(families):
                part = found[:, family * count : (family + 1) * count]
                out[group] += np.einsum("nm,mn->n", part, tables[family])
        return np.where(inside, out / safe, 0.0)
