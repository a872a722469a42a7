"""The density at a velocity, by the integral over the last free flight that ends there.

Tracers that leave a collision with the velocity w are accelerated, and arrive at v after the time s
with w = v - s along the field, if they do not collide before. So with G(w, t) the density that
collisions make per unit time,

    f(v, t) = f of those without a collision + integral over s of exp(-way) G(v - s, t - s).

G is smooth where f is not: on the ray along the field, on which tracers have come by rest.
"""

from __future__ import annotations

import numpy as np

from kinetics.field import radau
from kinetics.field.grid import SpeedPanels
from kinetics.field.starts import angular, free_way
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import gauss_legendre

_LONGEST = 28.0  # mean free paths of a last flight: the chance of a longer one is 1e-12
_INTERVALS, _POINTS = 5, 10  # before and after the turning point: 1e-7 of the peak is missed
_NEGLIGIBLE = 1e-12  # share of those that arrive
_TOGETHER = 4000  # points of flights, so few that their harmonics stay in the cache


class LastFlights:
    """Integrates over what collisions make.

    Parameters
    ----------
    panels, dimension : on which the density is solved
    steps : beginning, length, and v times what collisions make at the points of each step of time,
        (n_points, families, M + 1, size); of a steady state one step with one point
    slowest : G varies on the scale of the speed; what varies below this one counts little
    """

    def __init__(
        self,
        panels: SpeedPanels,
        dimension: int,
        steps: list[tuple[float, float, FloatArray]],
        slowest: float = 1e-2,
    ) -> None:
        self._panels, self._dimension, self._slowest = panels, dimension, slowest
        self._starts = np.array([now for now, _, _ in steps])
        self._lengths = np.array([h for _, h, _ in steps])
        self._points, self._families, self._count = steps[0][2].shape[:3]
        self._made = []
        for _, _, made in steps:
            by_node = np.moveaxis(made, -1, 1)
            flat = [by_node[:, p].reshape(-1, self._families * self._count) for p in panels.parts]
            self._made.append(flat)

    def density(self, time: float, along: FloatArray, across: FloatArray) -> FloatArray:
        """f at the velocities (n,) of tracers after a collision, in units of sqrt(g l)."""
        if time <= 0.0:
            return np.zeros(along.shape)
        pieces = np.array_split(np.arange(along.size), max(1, along.size // 500))
        return np.concatenate([self._piece(time, along[k], across[k]) for k in pieces])

    def _piece(self, time: float, along: FloatArray, across: FloatArray) -> FloatArray:
        """The same, of a few velocities."""
        square = along**2 + across**2
        straight = 2.0 * _LONGEST / np.sqrt(np.maximum(square, 4.0 * _LONGEST))
        turned = np.maximum(along, 0.0) + np.sqrt(2.0 * _LONGEST)
        last = np.minimum(time, np.where(square > 4.0 * _LONGEST, straight, turned))
        unit = np.maximum(np.abs(across), self._slowest)
        low, high = np.arcsinh((along - last) / unit), np.arcsinh(along / unit)
        turn = np.clip(0.0, low, high)
        share = np.arange(_INTERVALS + 1.0) / _INTERVALS
        before = low[:, None] + (turn - low)[:, None] * share
        after = turn[:, None] + (high - turn)[:, None] * share[1:]
        ends = np.concatenate([before, after], axis=1)
        x, w = gauss_legendre(_POINTS)
        width = np.diff(ends, axis=1)[:, :, None]
        u = ends[:, :-1, None] + width * x
        came = unit[:, None, None] * np.sinh(u)
        s = np.clip(along[:, None, None] - came, 0.0, last[:, None, None])
        back, side = (np.broadcast_to(part[:, None, None], s.shape) for part in (-along, across))
        chance = np.exp(-free_way(back, side, s)) * width * w * unit[:, None, None] * np.cosh(u)
        at, i, k = np.nonzero(chance > _NEGLIGIBLE)
        found = self._gained(came[at, i, k], across[at], time - s[at, i, k])
        return np.asarray(np.bincount(at, chance[at, i, k] * found, along.size), dtype=float)

    def _gained(self, along: FloatArray, across: FloatArray, time: FloatArray) -> FloatArray:
        """G at velocities and times, (n,)."""
        panels, count = self._panels, self._count
        v = np.hypot(along, across)
        inside = (v < panels.highest) & (v > 0.0)
        safe = np.where(v > 0.0, v, 1.0)
        cosine, sine, v = along / safe, across / safe, np.minimum(v, panels.highest)
        step = np.clip(np.searchsorted(self._starts, time, side="right") - 1, 0, None)
        key = step * len(panels.counts) + panels.panel_of(v)
        order = np.argsort(key, kind="stable")
        out = np.zeros(v.size)
        changes = np.nonzero(np.diff(key[order]))[0] + 1
        for group in np.split(order, np.union1d(changes, np.arange(0, v.size, _TOGETHER))):
            if group.size == 0:
                continue
            s, p = divmod(int(key[group[0]]), len(panels.counts))
            both = panels.rows(p, v[group, None] - panels.speeds[panels.parts[p]])
            if self._points > 1:
                in_time = radau.rows((time[group] - self._starts[s]) / self._lengths[s])
                both = (in_time[:, :, None] * both[:, None, :]).reshape(group.size, -1)
            found = both @ self._made[s][p]
            tables = angular(cosine[group], sine[group], count, self._dimension, self._families)
            for k, table in enumerate(tables):
                part = found[:, k * count : (k + 1) * count]
                out[group] += np.einsum("nm,mn->n", part, table)
        return np.where(inside, out / safe, 0.0)
