"""Averages of tracers that start with given velocities, by the integral over the first collision.

A tracer falls freely for a time tau, with the chance exp(-way) that it has not collided, ``way``
the length of its path in mean free paths; then it collides, and the averages from there on are
those of the backward equation. Collisions spread directions, so what is averaged converges fast
over harmonics, where the averages as functions of the first velocity do not: from rest, for beams,
and for starts that are slow against sqrt(g l).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinetics.field.backward import ALL, IS_EVEN, BackwardField
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import gauss_legendre, panels_between
from kinetics.states.quadrature import LogMeasure

_LONGEST_WAY = 40.0  # one in e^40 flies farther without a collision
_STRAIGHT = 1e-15  # components across a velocity that are rounding
_POINTS = 12  # Gauss points of an interval of the time of the first collision
_LONGEST = 1.5  # interval of that time, in units of the longest flight over 9
_INDEX = {name: i for i, name in enumerate(ALL)}


@dataclass(frozen=True)
class Rays:
    """Velocities at the start, each with its share of the tracers.

    Parameters
    ----------
    along, across : components of the velocity in sqrt(g l), shape (n_rays,)
    weight : shape (n_rays,), with the sum 1
    symmetric : whether each ray stands for all that differ by a turn, or a reflection, about the
        field
    """

    along: FloatArray
    across: FloatArray
    weight: FloatArray
    symmetric: bool

    @classmethod
    def beam(cls, speeds: LogMeasure, unit: float, direction: float, points: int) -> Rays:
        """One direction, with at most so many speeds; U is the unit of the speed."""
        v, w = _fewer(unit * np.exp(speeds.x), speeds.weight.real, points)
        straight = math.sin(direction) == 0.0
        return cls(v * math.cos(direction), v * math.sin(direction), w, straight)

    @classmethod
    def isotropic(
        cls, speeds: LogMeasure, unit: float, points: int, directions: int, dimension: int
    ) -> Rays:
        """All directions alike."""
        v, w = _fewer(unit * np.exp(speeds.x), speeds.weight.real, points)
        if dimension == 2:
            cosine = np.cos((np.arange(directions) + 0.5) * (math.pi / directions))
            share = np.full(directions, 1.0 / directions)
        else:
            x, share = gauss_legendre(directions)
            cosine = 2.0 * x - 1.0
        sine = np.sqrt(1.0 - cosine**2)
        return cls(
            np.outer(v, cosine).ravel(), np.outer(v, sine).ravel(), np.outer(w, share).ravel(), True
        )

    def way(self, time: FloatArray) -> FloatArray:
        """Length of the free path after these times, shape of time, (n_rays,) or (n_rays, n)."""
        extra = (1,) * (np.ndim(time) - 1)
        a, q = self.along.reshape(-1, *extra), self.across.reshape(-1, *extra)
        return free_way(a, q, time)

    @property
    def longest(self) -> FloatArray:
        """The time after which hardly a tracer is left without a collision, shape (n_rays,)."""
        low, high = np.zeros(self.along.size), 9.0 + 2.0 * np.maximum(-self.along, 0.0)
        for _ in range(60):
            middle = 0.5 * (low + high)
            short = self.way(middle) < _LONGEST_WAY
            low, high = np.where(short, middle, low), np.where(short, high, middle)
        return high


def free_way(a: FloatArray, q: FloatArray, time: FloatArray) -> FloatArray:
    """Integral over the time of the speed |(a + time, q)|, without cancellation."""
    u = a + time
    first, last = np.hypot(a, q), np.hypot(u, q)
    is_straight = np.abs(q) <= _STRAIGHT * np.abs(a)
    with np.errstate(divide="ignore", invalid="ignore"):
        gained = np.where(first + last > 0.0, time * (u + a) / (first + last), 0.0)
        nearest = np.where(a > 0.0, first + a, q * q / (first - a))
        turned = q * q * np.log1p((time + gained) / nearest)
    turned = np.where(is_straight | (q == 0.0), 0.0, turned)
    straight = np.where(is_straight & (a < 0.0), 0.5 * (u * np.abs(u) - a * np.abs(a)), 0.0)
    bent = 0.5 * (time * last + a * gained + turned)
    return np.where(is_straight & (a < 0.0), straight, bent)


def _fewer(v: FloatArray, w: FloatArray, points: int) -> tuple[FloatArray, FloatArray]:
    """The Gauss rule of a distribution of speeds, if that has fewer points.

    By the Lanczos method for the powers of the speed; Golub and Welsch, Math. Comp. 23 (1969) 221.
    """
    if v.size <= points or np.any(w < 0.0):
        return v, w
    scale, mass = float(v.max()), float(w.sum())
    x = v / scale
    basis = [np.sqrt(w / mass)]
    diagonal, beside = [], []
    for k in range(points):
        r = x * basis[-1]
        diagonal.append(float(r @ basis[-1]))
        for _ in range(2):
            r = r - np.array(basis).T @ (np.array(basis) @ r)
        size = float(np.linalg.norm(r))
        if k + 1 == points or size < 1e-14:
            break
        beside.append(size)
        basis.append(r / size)
    nodes, vectors = np.linalg.eigh(np.diag(diagonal) + np.diag(beside, 1) + np.diag(beside, -1))
    return scale * nodes, mass * vectors[0] ** 2


class FirstCollisions:
    """Integrates over the first collision of rays.

    Parameters
    ----------
    rays : the start
    equation : the averages after a collision, as functions of the velocity
    """

    def __init__(self, rays: Rays, equation: BackwardField) -> None:
        self.rays, self.equation = rays, equation
        self._longest = rays.longest
        self._columns = [i for i, name in enumerate(ALL) if name in equation.names]
        self._steps: list[tuple[float, float, list[FloatArray]]] = []

    def keep(self, now: float, h: float, stages: FloatArray) -> None:
        """What a step of the backward equation found, (stages + 1, M + 1, size, n_observables)."""
        found = self.equation.scattered(stages[..., self._columns])
        parts = self.equation.panels.parts
        # one matrix for each panel, whose rows are stages and nodes
        by_panel = [np.moveaxis(found[:, :, part], 1, 2) for part in parts]
        flat = [np.ascontiguousarray(g).reshape(-1, g.shape[2] * g.shape[3]) for g in by_panel]
        self._steps.append((now, h, flat))

    def weights(self, last: float) -> FloatArray:
        """The average over the first collision as weights (M + 1, size, n_observables).

        They stand for what the averages over the rays take from the backward equation, which its
        steps of time must resolve.
        """
        top, panels = self.equation.highest, self.equation.panels
        out = np.zeros((top + 1, panels.size, len(ALL)))
        for ray in range(self.rays.along.size):
            tau, chance = self._times(ray, last, np.zeros(0))
            v, cosine, sine = self._falling(np.full(tau.size, ray), tau)
            even, odd = angular(cosine, sine, top + 1, self.equation.law.dimension)
            rows = panels.interpolation(np.minimum(v, panels.highest))
            for table, columns in ((even, IS_EVEN), (odd, ~IS_EVEN)):
                out[:, :, columns] += ((table * chance) @ rows)[:, :, None]
        return self.equation.scattered(out, transposed=True)

    def averages(self, times: FloatArray) -> FloatArray:
        """At these times, shape (n_times, n_observables)."""
        out = self._uncollided(times)
        edges = np.array([now for now, _, _ in self._steps])
        parts = []
        for i, t in enumerate(times):
            for ray in range(self.rays.along.size):
                tau, chance = self._times(ray, float(t), t - edges)
                parts.append((np.full(tau.size, i), np.full(tau.size, ray), tau, chance))
        at, rays, tau, chance = (np.concatenate(part) for part in zip(*parts, strict=True))
        left = times[at] - tau
        step = np.clip(np.searchsorted(edges, left, side="right") - 1, 0, None)
        v, cosine, sine = self._falling(rays, tau)
        panels = self.equation.panels
        v = np.minimum(v, panels.highest)
        key = step * len(panels.counts) + panels.panel_of(v)
        order = np.argsort(key, kind="stable")
        for group in np.split(order, np.nonzero(np.diff(key[order]))[0] + 1):
            if group.size == 0:  # only the time 0 is asked for
                continue
            s, p = divmod(int(key[group[0]]), len(panels.counts))
            now, h, flat = self._steps[s]
            in_time = self.equation.rule.rows((left[group] - now) / h)
            in_speed = panels.rows(p, v[group, None] - panels.speeds[panels.parts[p]])
            both = (in_time[:, :, None] * in_speed[:, None, :]).reshape(group.size, -1)
            after = self._summed(both @ flat[p], cosine[group], sine[group])
            after[:, _INDEX["collisions"]] += 1.0
            moved = self._moved(*self._flown(rays[group], tau[group]), after)
            np.add.at(out, at[group], chance[group, None] * moved)
        if self.rays.symmetric:
            out[:, ~IS_EVEN] = 0.0
        return out * np.isin(ALL, list(self.equation.names))

    def _uncollided(self, times: FloatArray) -> FloatArray:
        """What tracers without a collision add to the averages, (n_times, n_observables)."""
        rays = np.arange(self.rays.along.size)
        out = np.zeros((times.size, len(ALL)))
        for i, t in enumerate(times):
            time = np.full(rays.size, t)
            left = self.rays.weight * np.exp(-self.rays.way(time))
            out[i] = left @ self._moved(*self._flown(rays, time), self._observables(rays, t))
        return out

    def _times(self, ray: int, last: float, breaks: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Times of the first collision of a ray before ``last``, and the chances of them."""
        a, q = float(self.rays.along[ray]), float(self.rays.across[ray])
        longest = min(last, float(self._longest[ray]))
        if longest <= 0.0:
            return np.zeros(0), np.zeros(0)
        edges = np.array(self.equation.panels.edges)
        root = np.sqrt(np.maximum(edges**2 - q * q, 0.0))
        near = abs(q) * np.array([-4.0, -1.0, 1.0, 4.0])
        equal = np.arange(1.0, 7.0) * (_LONGEST * float(self._longest[ray]) / 9.0)
        inside = np.concatenate([breaks, root - a, -root - a, near - a, equal])
        inside = np.unique(inside[(inside > 1e-14 * longest) & (inside < longest)])
        tau, w = panels_between(np.concatenate([[0.0], inside, [longest]]), _POINTS)
        rate = np.hypot(a + tau, q)
        return tau, self.rays.weight[ray] * w * rate * np.exp(
            -free_way(np.array(a), np.array(q), tau)
        )

    def _falling(self, ray: NDArray[np.intp], tau: FloatArray) -> tuple[FloatArray, ...]:
        """Speed, cosine and sine of the angle to the field after free falls."""
        u, q = self.rays.along[ray] + tau, self.rays.across[ray]
        v = np.hypot(u, q)
        safe = np.where(v > 0.0, v, 1.0)
        return v, np.where(v > 0.0, u / safe, 1.0), q / safe

    def _flown(self, ray: NDArray[np.intp], tau: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Displacement along and across the field in free falls."""
        return (self.rays.along[ray] + 0.5 * tau) * tau, self.rays.across[ray] * tau

    def _observables(self, ray: NDArray[np.intp], t: float) -> FloatArray:
        """The observables after a free fall, but for the displacement, (n, n_observables)."""
        u, q = self.rays.along[ray] + t, self.rays.across[ray]
        square = u * u + q * q
        d = self.equation.law.dimension
        # cos 2 phi in the plane, P_2 in space
        turned = u * u - q * q if d == 2 else u * u - 0.5 * q * q
        out = np.zeros((ray.size, len(ALL)))
        for name, value in (
            ("v_x", u),
            ("v_y", q),
            ("v_x v_y", u * q),
            ("v^2", square),
            ("v^2 cos 2", turned),
            ("v^3", square**1.5),
            ("v^4", square**2),
        ):
            out[:, _INDEX[name]] = value
        return out

    def _summed(self, product: FloatArray, cosine: FloatArray, sine: FloatArray) -> FloatArray:
        """Sum of harmonics (n, (M + 1) n_columns) at an angle: (n, n_observables)."""
        count = self.equation.highest + 1
        by_harmonic = product.reshape(cosine.size, count, -1)
        out = np.zeros((cosine.size, len(ALL)))
        tables = angular(cosine, sine, count, self.equation.law.dimension)
        for k, column in enumerate(self._columns):
            table = tables[0] if IS_EVEN[column] else tables[1]
            out[:, column] = np.einsum("nm,mn->n", by_harmonic[:, :, k], table)
        return out

    def _moved(self, x: FloatArray, y: FloatArray, after: FloatArray) -> FloatArray:
        """Averages after a displacement (x, y) and what comes after it, (n, n_observables).

        In space after the average over the azimuth.
        """
        out = after.copy()
        of = {name: after[:, i] for name, i in _INDEX.items()}
        half = 1.0 if self.equation.law.dimension == 2 else 0.5
        out[:, _INDEX["x"]] += x
        out[:, _INDEX["y"]] += y
        out[:, _INDEX["x^2"]] += x * x + 2.0 * x * of["x"]
        out[:, _INDEX["y^2"]] += half * (y * y + 2.0 * y * of["y"])
        out[:, _INDEX["x y"]] += x * y + x * of["y"] + y * of["x"]
        return out


def angular(
    cosine: FloatArray, sine: FloatArray, count: int, dimension: int, families: int = 2
) -> tuple[FloatArray, ...]:
    """Harmonics m = 0 ... count - 1 at an angle, even and odd across the field, (count, n) each.

    cos(m phi) and sin(m phi) in the plane, P_m(cos) and P_m^1(cos) in space; one family: the even.
    """
    zero, one = np.zeros((2, cosine.size))
    one += 1.0
    found = []
    for odd, (first, second) in enumerate(((one, cosine), (zero, sine))[:families]):
        table = np.empty((count, cosine.size))
        table[0], table[1] = first, second
        for m in range(2, count):
            np.multiply(cosine, table[m - 1], out=table[m])
            if dimension == 2:
                table[m] *= 2.0
                table[m] -= table[m - 2]
            else:
                table[m] *= (2 * m - 1) / (m - odd)
                table[m] -= (m - 1 + odd) / (m - odd) * table[m - 2]
        found.append(table)
    return tuple(found)
