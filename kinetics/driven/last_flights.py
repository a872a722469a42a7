"""Densities of the velocity over time in a field, for one initial state.

f is the sum of the tracers that have not collided, in closed form (of sharp velocities only their
share is given), and of an integral over the last free flight of all others. With G(w, t) the
density that collisions make per unit time,

    f(v, t) = f of those without a collision + integral over s of exp(-way) G(v - s, t - s),

s along the field. G is smooth where f is not: on the ray along the field, on which tracers have
come by rest.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.polynomial.chebyshev import chebder, chebval
from numpy.polynomial.legendre import legder, legval
from scipy.special import roots_jacobi

from kinetics.collision import CollisionLaw
from kinetics.drive import Drive
from kinetics.driven import radau
from kinetics.driven.harmonics import Chain, angular, norms
from kinetics.driven.march import ALL, Evolution
from kinetics.driven.panels import Resolution, SpeedPanels, loss_matrices
from kinetics.driven.speed_range import TAIL_OVER_TOLERANCE, top_speed
from kinetics.driven.starts import FEW, TOGETHER, Velocities, free_way
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import gauss_legendre, panels_between
from kinetics.states.kinds import Beam
from kinetics.states.state import State

_NEGLIGIBLE = 1e-12  # the chance of a last flight that is longer
_LEFT_OUT = 1e-9  # of the largest harmonic of what collisions make: those that stay below it
_POINTS, _FALL = 8, 9.0  # while the speed changes by e, or the chance by e^-9: 1e-8 is missed


class LastFlights:
    """Integrates over what collisions make.

    steps : beginning, length, and v times what collisions make at the points of each step of time,
        (n_points, families, M + 1, size); of a steady state one step with one point
    """

    def __init__(
        self, panels: SpeedPanels, dimension: int, steps: list[tuple[float, float, FloatArray]]
    ) -> None:
        self._panels = panels
        self._starts = np.array([now for now, _, _ in steps])
        self._lengths = np.array([h for _, h, _ in steps])
        self._points = len(steps[0][2])
        least = _LEFT_OUT * max(np.abs(made).max() for _, _, made in steps)
        polynomial, slope = (chebval, chebder) if dimension == 2 else (legval, legder)
        self._sum = partial(polynomial, tensor=False)
        self._made = []
        for _, _, made in steps:
            for p, part in enumerate(panels.parts):
                # of polynomials in the speed, (families, harmonics, n_points, nodes)
                found = np.moveaxis(made[..., part] @ panels.to_coefficients[p].T, 0, 2)
                there = np.nonzero(np.abs(found).max(axis=(0, 2, 3)) > least)[0]
                found = found[:, : there.max(initial=1) + 1]
                flat: Any = found.reshape(*found.shape[:2], -1)
                if len(flat) == 2:  # the harmonics of family 1 are sine times slopes of the others
                    m = np.maximum(np.arange(flat.shape[1]), 1)[:, None] ** (3 - dimension)
                    flat = [flat[0], slope(flat[1] / m)]
                self._made.append(flat)

    def density(self, time: float, along: FloatArray, across: FloatArray) -> FloatArray:
        """f at the velocities (n,) of tracers after a collision, in units of sqrt(g l)."""
        if time <= 0.0:
            return np.zeros(along.shape)
        pieces = np.array_split(np.arange(along.size), 1 + along.size // TOGETHER)
        return np.concatenate([self._piece(time, along[k], across[k]) for k in pieces])

    def _piece(self, time: float, along: FloatArray, across: FloatArray) -> FloatArray:
        """The same, of a few velocities."""
        longest, side = -math.log(_NEGLIGIBLE), np.minimum(np.abs(across), self._panels.highest)
        with np.errstate(over="ignore", divide="ignore"):
            # the way that a tracer falls is never shorter than along, or across, the field alone
            square = along * np.abs(along) - 2.0 * longest
            reach = np.sqrt(np.maximum(self._panels.highest**2 - side**2, 0.0))
            first = along - np.minimum(time, longest / side)
        first = np.maximum(first, np.sign(square) * np.sqrt(np.abs(square)))
        # G varies on the scale of the speed, but little in the first panel
        unit = np.maximum(side, 1e-3 * self._panels.edges[1])
        first, last = (np.clip(u, -reach, reach) for u in (first, along))
        turn = np.clip(0.0, first, last)  # intervals end at the turning point
        begin, end = np.append(first, turn), np.append(turn, last)
        falls = (end**2 + np.tile(side, 2) ** 2) / _FALL
        begin, end = (np.arcsinh(u / np.tile(unit, 2)) for u in (begin, end))
        count = np.ceil((end - begin) * np.maximum(falls, 1.0)).astype(int)
        of = np.repeat(np.arange(begin.size), count)
        which = np.arange(of.size) - np.repeat(np.cumsum(count) - count, count)
        width = ((end - begin)[of] / count[of])[:, None]
        x, w = gauss_legendre(_POINTS)
        u = begin[of, None] + width * (which[:, None] + x)
        of %= along.size
        back, side, scale = (np.repeat(a[of], _POINTS) for a in (-along, across, unit))
        came = scale * np.sinh(u.ravel())
        s = np.maximum(-back - came, 0.0)
        chance = np.exp(-free_way(back, side, s)) * (width * w).ravel() * np.hypot(came, scale)
        found = chance * self._gained(came, side, time - s)
        of_each = found.reshape(u.shape).sum(axis=1)
        return np.asarray(np.bincount(of, of_each, along.size), dtype=float)

    def _gained(self, along: FloatArray, across: FloatArray, time: FloatArray) -> FloatArray:
        """G at velocities, none of them 0, and times, (n,)."""
        panels, v = self._panels, np.hypot(along, across)
        cosine, sine = along / v, across / v
        step = np.clip(np.searchsorted(self._starts, time, side="right") - 1, 0, None)
        key = step * len(panels.counts) + panels.panel_of(v)
        order = np.argsort(key, kind="stable")
        out = np.empty(v.size)
        for group in np.split(order, np.nonzero(np.diff(key[order]))[0] + 1):
            if group.size == 0:
                continue
            s, p = divmod(int(key[group[0]]), len(panels.counts))
            rows = panels.polynomials(p, v[group])
            if self._points > 1:
                in_time = radau.rows((time[group] - self._starts[s]) / self._lengths[s])
                rows = (in_time[:, :, None] * rows[:, None, :]).reshape(group.size, -1)
            found = [self._sum(cosine[group], one @ rows.T) for one in self._made[key[group[0]]]]
            out[group] = found[0] if len(found) == 1 else found[0] + sine[group] * found[1]
        return out / v


_ANGLES = np.array([0.0, 0.05, 0.25, 0.8, 1.8, math.pi])  # intervals for the mean over directions
_CLOSE = np.concatenate([[0.0], math.pi * 0.5 ** np.arange(8.0, -1.0, -1.0)])
# velocities at which two solutions are compared, in units of the usual speed
_TRIED_SPEEDS = np.array([0.01, 0.02, 0.04, 0.07, 0.1, 0.2, 0.3, 0.45, 0.6, 0.9, 1.2, 1.6, 2.0])
_LOOKED_AT = np.linspace(0.1, 2.5, 17)  # speeds at which a density may not be below zero
_TRIED_ANGLES = np.array([0.05, -0.5, 1.3, -2.2, 3.0])  # on both sides of the field


def is_sharp(state: State) -> bool:
    """Whether tracers start with sharp velocities; densities leave out those that keep them."""
    return isinstance(state, Beam) or state.peaks is not None or state.profile(0) is None


class VelocityDensity:
    """The densities of one start over time, in units of sqrt(g l), which is ``unit`` U."""

    def __init__(self, evolution: Evolution, state: State, unit: float) -> None:
        self._evolution, self._state, self._speed = evolution, state, 1.0 / unit
        self._dimension, self._families = evolution.law.dimension, evolution.families
        self._flights = LastFlights(evolution.axis, self._dimension, evolution.made)
        self._is_sharp = is_sharp(state)

    def at(self, i: int, along: FloatArray, across: FloatArray) -> FloatArray:
        """f at the i-th time and velocities (n,), in sqrt(g l); without sharp velocities."""
        time = float(self._evolution.times[i])
        return self._flights.density(time, along, across) + self._smooth(time, along, across)

    def by_speed(self, i: int, v: FloatArray) -> FloatArray:
        """The density of the speed at the i-th time and speeds (n,)."""
        d, time = self._dimension, float(self._evolution.times[i])
        out = np.zeros(v.shape)
        for edges, one in ((_ANGLES, self._flights.density), (_CLOSE, self._smooth)):
            angle, w = panels_between(edges, _POINTS)
            share = 2.0 * w if d == 2 else 2.0 * math.pi * w * np.sin(angle)
            along, across = np.outer(v, np.cos(angle)), np.outer(v, np.sin(angle))
            sides = [across, -across][: self._families]
            both = np.mean([one(time, along.ravel(), side.ravel()) for side in sides], axis=0)
            out += both.reshape(along.shape) @ share
        return np.asarray(out * v ** (d - 1))

    def _tried(self, speeds: FloatArray, angles: FloatArray) -> Iterator[tuple[Any, ...]]:
        """For each time its index, speeds in units of the usual one, and velocities of these."""
        for i, square in enumerate(self._evolution.values[:, ALL.index("v^2")]):
            v = math.sqrt(abs(square)) * speeds
            along, across = np.outer(np.cos(angles), v), np.outer(np.sin(angles), v)
            yield i, v, along.ravel(), across.ravel()

    def negative(self) -> float:
        """How far densities are below zero, over the largest of each time; 0 where they are not."""
        worst = 0.0
        for i, v, along, across in self._tried(_LOOKED_AT, np.append(0.0, _TRIED_ANGLES)):
            for f in (self.at(i, along, across), self.by_speed(i, v)):
                worst = max(worst, float(-f.min() / max(f.max(), 1e-300)))
        return worst

    def difference(self, other: VelocityDensity) -> float:
        """The largest difference of densities, of velocity and of speed, over the largest there."""
        worst = 0.0
        for i, v, along, across in self._tried(_TRIED_SPEEDS, _TRIED_ANGLES):
            f = np.reshape([x.at(i, along, across) for x in (self, other)], (2, -1, v.size))
            for one, two in (f, f * v ** (self._dimension - 1)):
                largest = max(np.abs(one).mean(axis=0).max(), 1e-300)
                worst = max(worst, float(np.abs(one - two).max() / largest))
        return worst if math.isfinite(worst) else math.inf

    @property
    def uncollided(self) -> FloatArray:
        """Share of the tracers that keep a sharp velocity, (n_times,); 0 for smooth starts."""
        start, times = self._evolution.start, self._evolution.times
        velocities = start.velocities
        if not self._is_sharp:
            return np.zeros(times.shape)
        if velocities is None and self._state.highest_harmonic == 0:
            speeds = start.measures[0]
            assert speeds is not None
            velocities = Velocities.isotropic(speeds, self._speed, FEW, self._dimension)
        elif velocities is None:  # samples
            velocity = self._speed * np.asarray(self._state.velocity)  # type: ignore[attr-defined]
            velocities = Velocities.samples(velocity)
        return np.array([velocities.uncollided(float(t)).sum() for t in times])

    def _smooth(self, time: float, along: FloatArray, across: FloatArray) -> FloatArray:
        """The density of tracers of smooth starts without a collision, (n,)."""
        out = np.zeros(along.shape)
        if self._is_sharp:
            return out
        u, d = along - time, self._dimension
        v = np.maximum(np.hypot(u, across), 1e-12 * self._speed)
        there, top = self._state.highest_harmonic, self._evolution.resolution.harmonics
        last = top if there is None else min(there, top)
        even, odd = angular(u / v, across / v, max(last, 1) + 1, d)
        of = norms(last + 1, d)[0, :, 0] * self._speed
        for m in range(last + 1):
            profile = self._state.profile(m)
            if profile is not None:
                value = np.asarray(profile(v / self._speed)) / of[m]
                # the harmonics have the factor exp(-i m phi)
                out += np.real(value) * even[m] - np.imag(value) * odd[m]
        return out / v ** (d - 1) * np.exp(-free_way(u, across, np.full(u.shape, time)))


class SteadyDensity:
    """Harmonics of f on given panels; (field + collisions) f = 0, with mass 1.

    law : the collision law, not elastic
    one : panels and harmonics
    """

    def __init__(self, law: CollisionLaw, one: Resolution) -> None:
        self.law = law
        highest = top_speed(
            Drive(restitution=law, dimension=law.dimension, field=1.0),
            TAIL_OVER_TOLERANCE * one.rtol,
        )
        least = law.least_ratio  # below it f varies as (v/least)^2 ln v
        lowest = one.lowest * (min(1.0, max(3.0 * least, 0.03)) if least else 1.0)
        self.panels = SpeedPanels.rising(highest, lowest, one.nodes, tail=True)
        v, d, count = self.panels.speeds, law.dimension, one.harmonics + 1
        self._loss = loss_matrices(self.panels, law, one.harmonics)
        chain = Chain(d, self._loss, self.panels.slopes(d), 1.0 / v)
        # a source anywhere, for the border: its factor comes out as 0
        border = np.ones(v.size), v * np.exp(-v)
        solver = chain.elimination(border=border)
        self._sums = solver.solve(np.zeros((count, v.size)), 1.0)
        self._volumes = norms(count, d)[0] * self.panels.volumes(d)
        self.harmonics = self._sums / self._volumes

    def moment(self, p: float, m: int) -> float:
        """<v^p cos(m phi)>, for p > -d; for p > -d - 1 where m > 0 and f_m is 0 at rest."""
        v, d = self.panels.speeds, self.law.dimension
        f, first = self._sums[m], self.panels.parts[0]
        rest = slice(first.stop, None)
        above = v[rest] ** p @ f[rest]
        # on the first panel f, or f/v, is a polynomial
        f, half = f[first] / self.panels.volumes(d)[first], 0.5 * self.panels.edges[1]
        power = p + d - 1.0
        if power <= -1.0:
            f, power = f / v[first], power + 1.0
        x, w = roots_jacobi(f.size, 0.0, power)
        below = half ** (power + 1.0) * (w @ (self.panels.rows(0, half * (x + 1.0)) @ f))
        return float(above + below)

    @cached_property
    def _flights(self) -> LastFlights:
        f, v = self._sums, self.panels.speeds
        made = v * (v * f - np.einsum("mij,mj->mi", self._loss, f)) / self._volumes
        return LastFlights(self.panels, self.law.dimension, [(0.0, 1.0, made[None, None])])

    def density(self, along: FloatArray, across: FloatArray) -> FloatArray:
        """f at velocities (n,) in sqrt(g l)."""
        found = self._flights.density(math.inf, along, across)
        if math.isinf(self.law.largest_loss):  # the logarithm of the angle
            found[(across == 0.0) & (along >= 0.0)] = math.inf
        return found
