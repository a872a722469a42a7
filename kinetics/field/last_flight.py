"""The density at a velocity, by the integral over the last free flight that ends there.

Tracers that leave a collision with the velocity w are accelerated, and arrive at v after the time s
with w = v - s along the field, if they do not collide before. So with G(w, t) the density that
collisions make per unit time,

    f(v, t) = f of those without a collision + integral over s of exp(-way) G(v - s, t - s).

G is smooth where f is not: on the ray along the field, on which tracers have come by rest.
"""

from __future__ import annotations

import numpy as np

from kinetics.field.first_collision import angular, free_way
from kinetics.field.forward import ForwardField
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import gauss_legendre

_POINTS = 8  # Gauss points of an interval of the flight
_NEAR = np.array([-16.0, -4.0, -1.0, 1.0, 4.0, 16.0])  # intervals about the slowest point
_EQUAL = 5  # intervals of equal lengths
_PIECE = 4000  # velocities at once
_HALVINGS = 40


class LastFlights:
    """Keeps what collisions make in each step, and integrates over it.

    Parameters
    ----------
    equation : the density on speed panels
    longest : flights longer than so many mean free paths are left out
    """

    def __init__(self, equation: ForwardField, longest: float) -> None:
        self.equation, self._longest = equation, longest
        self._starts: list[float] = []
        self._lengths: list[float] = []
        self._gains: list[list[FloatArray]] = []

    def keep(self, now: float, h: float, stages: FloatArray) -> None:
        """What collisions make in a step, from the densities times (-1)^m."""
        made = np.einsum("mij,sfmj->sifm", self.equation.gain, stages * self.equation.signs)
        parts = self.equation.panels.parts
        flat = [
            np.ascontiguousarray(made[:, p]).reshape(-1, made.shape[2] * made.shape[3])
            for p in parts
        ]
        self._starts.append(now)
        self._lengths.append(h)
        self._gains.append(flat)

    def density(self, time: float, along: FloatArray, across: FloatArray) -> FloatArray:
        """f at the velocities (n,) of tracers after a collision, in units of sqrt(g l)."""
        if time <= 0.0:
            return np.zeros(along.shape)
        pieces = max(1, along.size // _PIECE)
        split = zip(np.array_split(along, pieces), np.array_split(across, pieces), strict=True)
        return np.concatenate([self._piece(time, *both) for both in split])

    def _piece(self, time: float, along: FloatArray, across: FloatArray) -> FloatArray:
        """The same, of a few velocities."""
        back = -along  # a flight backwards is one from -v
        last = self._last(time, back, across)
        near = along[:, None] + np.abs(across)[:, None] * _NEAR
        equal = last[:, None] * (np.arange(_EQUAL + 1.0) / _EQUAL)
        ends = np.sort(np.concatenate([np.clip(near, 0.0, last[:, None]), equal], axis=1), axis=1)
        width = np.diff(ends, axis=1)
        which, interval = np.nonzero(width > 1e-13 * last[:, None])
        x, w = gauss_legendre(_POINTS)
        length = width[which, interval][:, None]
        s = (ends[which, interval][:, None] + length * x).ravel()
        at = np.repeat(which, _POINTS)
        chance = np.exp(-free_way(back[at], across[at], s)) * (length * w).ravel()
        made = self._made(along[at] - s, across[at], time - s)
        return np.asarray(np.bincount(at, chance * made, along.size), dtype=float)

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
        equation, panels = self.equation, self.equation.panels
        v = np.hypot(along, across)
        inside = v < panels.highest
        safe = np.where(v > 0.0, v, 1.0)
        cosine, sine = np.where(v > 0.0, along / safe, 1.0), across / safe
        v = np.minimum(v, panels.highest)
        starts = np.array(self._starts)
        step = np.clip(np.searchsorted(starts, time, side="right") - 1, 0, None)
        key = step * len(panels.counts) + panels.panel_of(v)
        order = np.argsort(key, kind="stable")
        out = np.zeros(v.size)
        count = equation.highest + 1
        for group in np.split(order, np.nonzero(np.diff(key[order]))[0] + 1):
            if group.size == 0:
                continue
            s, p = divmod(int(key[group[0]]), len(panels.counts))
            in_time = equation.rule.rows((time[group] - starts[s]) / self._lengths[s])
            in_speed = panels.rows(p, v[group, None] - panels.speeds[panels.parts[p]])
            both = (in_time[:, :, None] * in_speed[:, None, :]).reshape(group.size, -1)
            found = both @ self._gains[s][p]
            tables = angular(cosine[group], sine[group], count, equation.law.dimension)
            for family in range(equation.families):
                part = found[:, family * count : (family + 1) * count]
                out[group] += np.einsum("nm,mn->n", part, tables[family])
        return out * inside
