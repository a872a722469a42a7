"""Densities of the velocity over time in a field, for one initial state.

f is the sum of the tracers that have not collided, in closed form, and of an integral over the last
free flight of all others. Starts of sharp velocities leave out the first: their uncollided tracers
have the velocities v0 + g t, and a share that is given; those that have collided once are in closed
form as well.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import count

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.errors import InputError
from kinetics.field.backward import ALL
from kinetics.field.collided_once import (
    once_collided,
    once_collided_by_speed,
    once_collided_isotropic,
)
from kinetics.field.evolution import reached_speed
from kinetics.field.first_collision import Rays, angular, free_way
from kinetics.field.forward import ForwardField
from kinetics.field.last_flight import LastFlights
from kinetics.field.panels import SpeedPanels
from kinetics.field.resolution import TimeResolution
from kinetics.field.starts import Start
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import panels_between
from kinetics.states.directed import Beam
from kinetics.states.isotropic import Rest
from kinetics.states.state import SpeedFunction, State

_Density = Callable[[FloatArray, FloatArray], FloatArray]
_RATIO = 4.0  # of the ends of a panel, up to an eighth of the highest speed
_TOP = 8.0
_ROUGH = 10.0  # what steps may miss of the mass of a panel, in units of their accuracy
_SMOOTH = 64.0  # see `evolution`
_SHORTEST, _SHARP = 1.0 / 32.0, 1e-4  # a step, and what it may miss, of starts rough in time
_MOST_STEPS = 400
_FIRST = 0.25  # of the first step, in flights of the fastest
_FLIGHT = 6.0  # mean free paths of a last flight, beyond ln(1/rtol)
_ANGLES = np.array([0.0, 0.05, 0.25, 0.8, 1.8, math.pi])  # intervals for the mean over directions
_ANGLE_POINTS = 6
_CLOSE_ANGLES = np.concatenate([[0.0], math.pi * 0.5 ** np.arange(8.0, -1.0, -1.0)])
_TRIED_SPEEDS = np.array([0.1, 0.3, 0.6, 0.9, 1.2, 1.6, 2.0])
_TRIED_ANGLES = np.array([0.05, 0.5, 1.3, 2.2, 3.0])
_ATTEMPTS = 3


def density_panels(highest: float, lowest: float, nodes: int) -> SpeedPanels:
    """Panels that grow by a factor, and above an eighth of the highest speed two long ones."""
    low = highest / _TOP
    rising = max(1, math.ceil(math.log(low / lowest) / math.log(_RATIO)))
    edges = [low * _RATIO ** (j - rising) for j in range(rising + 1)]
    top = [0.5 * (low + highest), highest]
    return SpeedPanels((0.0, *edges, *top), (nodes - 3, *[nodes] * rising, *[2 * nodes] * 2))


@dataclass
class FieldDensities:
    """The densities of one start at given times, in units of sqrt(g l) and sqrt(l/g).

    Parameters
    ----------
    law : the collision law
    state : the initial state
    speed : U in sqrt(g l)
    times : rising, shape (n_times,)
    resolution : panels, harmonics and steps
    """

    law: CollisionLaw
    state: State
    speed: float
    times: FloatArray
    resolution: TimeResolution

    def __post_init__(self) -> None:
        d, top = self.law.dimension, self.resolution.harmonics
        self.start = Start.of(
            self.state, 0.01 * self.resolution.rtol, self.speed, self.resolution, d
        )
        self.rays = self.start.rays
        peaks = self.state.peaks
        self.is_sharp = peaks is not None or (self.rays is not None and not self._is_smooth)
        if self.is_sharp and self.rays is None and self.state.highest_harmonic == 0:
            speeds = self.start.measures[0]
            assert speeds is not None
            points = max(3, self.resolution.nodes // 2)
            self.rays = Rays.isotropic(speeds, self.speed, points, top + 1, d)
        if self.rays is not None and not self._law_is_smooth:
            raise InputError(
                "outputs: densities in a field from sharp velocities are available for smooth "
                "scatterers only (tangential_restitution=1)"
            )
        families = 1 if self.start.is_symmetric else 2
        last = float(self.times[-1])
        reach = math.hypot(self.start.highest, reached_speed(self.law, last, self.resolution.rtol))
        lowest = min(self.resolution.lowest, 0.01 * reach)
        panels = density_panels(reach, lowest, self.resolution.nodes)
        self.equation = ForwardField(self.law, panels, top, families)
        flight = math.log(1.0 / self.resolution.rtol) + _FLIGHT
        self.flights = LastFlights(panels, d, flight, self.equation.rule.rows)
        self.steps = 0
        self._run(last)

    @property
    def _is_smooth(self) -> bool:
        """Whether tracers without a collision have a density that is known."""
        return self.state.profile(0) is not None and not isinstance(self.state, Beam)

    @property
    def _highest(self) -> int:
        """The highest harmonic of the start, or the highest that is solved."""
        top, there = self.resolution.harmonics, self.state.highest_harmonic
        return top if there is None else min(there, top)

    @property
    def _law_is_smooth(self) -> bool:
        return self.law.arguments["tangential_restitution"] == 1.0

    def _initial(self) -> FloatArray:
        """The density at the start, times (-1)^m: (families, M + 1, size)."""
        equation = self.equation
        out = np.zeros((equation.families, equation.highest + 1, equation.panels.size))
        if self.rays is not None:
            return out
        weights = self.start.functional(equation.panels, equation.highest)
        columns = (ALL.index("v_x"), ALL.index("v_y"))
        for family in range(equation.families):
            out[family] = weights[:, :, columns[family]] / equation.volume
        for m in range(self._highest + 1):
            profile = self.state.profile(m) if self._is_smooth else None
            if profile is not None:
                out[:, m] = self._profile(profile, m)[: equation.families]
        return out * equation.signs

    def _run(self, last: float) -> None:
        """Step after step, up to the last time."""
        f, now = self._initial(), 0.0
        wanted = _FIRST / (1.0 + self.start.highest)
        h = last if last <= wanted else last * 2.0 ** math.floor(math.log2(wanted / last))
        shortest = _SHORTEST if self.rays is not None else 1e-3 * h
        allowed = _ROUGH * self.resolution.rtol
        if self.rays is not None:
            allowed = max(allowed, _SHARP)
        for tried in count():
            if now >= last:
                break
            source = None
            if self.rays is not None:
                source = self.equation.first_collided(self.rays, now, h)
            stages = self.equation.step(f, h, source)
            rough = self.equation.roughness(stages) if tried < _MOST_STEPS else 0.0
            if rough > allowed and h > shortest:
                h *= 0.5
                continue
            self.steps += 1
            self.flights.keep(now, h, self.equation.made(stages))
            now, f = now + h, stages[-1]
            if rough * _SMOOTH < allowed:
                h *= 2.0

    @property
    def usual(self) -> float:
        """The root mean square speed of the start."""
        if self.rays is not None:
            square = self.rays.weight @ (self.rays.along**2 + self.rays.across**2)
            return math.sqrt(float(square))
        speeds = self.start.measures[0]
        assert speeds is not None
        return self.speed * math.exp(0.5 * speeds.log_second_moment())

    # -- densities --------------------------------------------------------------------------------

    def at(self, i: int, along: FloatArray, across: FloatArray) -> FloatArray:
        """f at the i-th time and velocities (n,), in sqrt(g l); without sharp velocities."""
        time = float(self.times[i])
        found = self.flights.density(time, along, across) + self._uncollided_at(time, along, across)
        if self.rays is None:
            return found
        if self._rings is None:
            return found + once_collided(
                self.rays, self._e, self.law.dimension, time, along, across
            )
        for speed, weight in zip(*self._rings, strict=True):
            found += weight * once_collided_isotropic(speed, self._e, time, along, across)
        return found

    @cached_property
    def _rings(self) -> tuple[FloatArray, FloatArray] | None:
        """Speeds of rays of all directions in the plane, and their shares; None for others."""
        if self.rays is None or self.law.dimension == 3 or self.state.highest_harmonic != 0:
            return None
        if isinstance(self.state, Rest):
            return None
        speed = np.round(np.hypot(self.rays.along, self.rays.across), 12)
        speeds, which = np.unique(speed, return_inverse=True)
        shares = np.bincount(which, self.rays.weight)
        return np.asarray(speeds, dtype=float), np.asarray(shares, dtype=float)

    def by_speed(self, i: int, v: FloatArray) -> FloatArray:
        """The density of the speed at the i-th time and speeds (n,)."""
        time, d = float(self.times[i]), self.law.dimension
        angle, w = panels_between(_ANGLES, _ANGLE_POINTS)
        out = self._mean(v, angle, w, lambda *at: self.flights.density(time, *at))
        if not self.is_sharp:
            angle, w = panels_between(_CLOSE_ANGLES, 2 * _ANGLE_POINTS)
            out += self._mean(v, angle, w, lambda *at: self._uncollided_at(time, *at))
        if self.rays is not None and time > 0.0:
            out += once_collided_by_speed(self.rays, self._e, d, time, v)
        return out

    def _mean(
        self, v: FloatArray, angle: FloatArray, w: FloatArray, density: _Density
    ) -> FloatArray:
        """Integral of a density over all directions, times v^(d-1)."""
        d = self.law.dimension
        share = 2.0 * w if d == 2 else 2.0 * math.pi * w * np.sin(angle)
        along, across = np.outer(v, np.cos(angle)).ravel(), np.outer(v, np.sin(angle)).ravel()
        found = density(along, across)
        if self.equation.families == 2:
            found = 0.5 * (found + density(along, -across))
        return np.asarray(found.reshape(v.size, -1) @ share * v ** (d - 1))

    @property
    def _e(self) -> float:
        return float(self.law.arguments["restitution"])

    @cached_property
    def uncollided(self) -> FloatArray:
        """Share of the tracers that keep a sharp velocity, (n_times,); 0 for smooth starts."""
        if not self.is_sharp:
            return np.zeros(self.times.shape)
        rays = self.rays
        if rays is None:  # samples
            velocity = self.speed * np.asarray(self.state.velocity)  # type: ignore[attr-defined]
            share = np.full(velocity.shape[0], 1.0 / velocity.shape[0])
            rays = Rays(velocity[:, 0], velocity[:, 1], share, False)
        ways = [rays.way(np.full(rays.along.size, t)) for t in self.times]
        return np.array([float(rays.weight @ np.exp(-way)) for way in ways])

    def _uncollided_at(self, time: float, along: FloatArray, across: FloatArray) -> FloatArray:
        """The density of tracers without a collision, (n,)."""
        if self.is_sharp:
            return np.zeros(along.shape)
        u = along - time
        v = np.maximum(np.hypot(u, across), 1e-12 * self.speed)
        cosine, sine = u / v, across / v
        top = self._highest
        even, odd = angular(cosine, sine, max(top, 1) + 1, self.law.dimension)
        out = np.zeros(along.shape)
        for m in range(top + 1):
            profile = self.state.profile(m)
            if profile is not None:
                cos_part, sin_part = self._values(profile, m, v)
                out += cos_part * even[m] + sin_part * odd[m]
        return out * np.exp(-free_way(u, across, np.full(u.shape, time)))

    def _values(
        self, profile: SpeedFunction, m: int, v: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """f_m of cos(m phi) and of sin(m phi), or of P_m, at speeds in sqrt(g l)."""
        d = self.law.dimension
        found = np.asarray(profile(v / self.speed)) / self.speed
        share = (1.0 if m == 0 else 2.0) if d == 2 else 2.0 * m + 1.0
        found = share * found / (self.law.unit_surface * v ** (d - 1))
        return np.real(found), -np.imag(found)

    def _profile(self, profile: SpeedFunction, m: int) -> FloatArray:
        """The same on the polynomials of the panels, (2, size): projected, with its kinks."""
        panels, d = self.equation.panels, self.law.dimension
        kinks = self.speed * np.asarray(self.state.kinks)
        out = np.zeros((2, panels.size))
        for p, part in enumerate(panels.parts):
            low, high = panels.edges[p], panels.edges[p + 1]
            inside = kinks[(kinks > low) & (kinks < high)]
            edges = np.unique(np.concatenate([[low], inside, [high]]))
            v, w = panels_between(edges, panels.counts[p] + 2)
            rows = panels.rows(p, v[:, None] - panels.speeds[part])
            weight = (w * v ** (d - 1))[:, None] * rows
            every = np.array(self._values(profile, m, v)) @ weight
            out[:, part] = every / (panels.weights[part] * panels.speeds[part] ** (d - 1))
        return out


def solve_densities(
    law: CollisionLaw, state: State, speed: float, times: FloatArray, rtol: float
) -> tuple[FieldDensities, float]:
    """The densities, ever more finely resolved until two solutions agree; and their error.

    The error is the difference of two solutions, the largest of all times and of velocities of all
    directions, relative to the largest density of each time. For smooth starts it is multiplied by
    the fifth power of the ratio of their harmonics: the gain falls as m^-5, because f_m falls as
    m^-3 and collisions spread directions. For sharp starts the difference itself is the error.
    """
    resolution = TimeResolution.for_densities(rtol)
    best = FieldDensities(law, state, speed, times, resolution)
    values, least = _tried(best), math.inf
    for _ in range(_ATTEMPTS):
        resolution = resolution.finer()
        fine = FieldDensities(law, state, speed, times, resolution)
        found = _tried(fine)
        peak = np.maximum(np.abs(found).max(axis=1), 1e-300)[:, None]
        error = float(np.max(np.abs(found - values) / peak))
        if not fine.is_sharp and fine.rays is None:
            error *= (best.resolution.harmonics / resolution.harmonics) ** 5
        if not error < least:
            break
        best, values, least = fine, found, error
        if error <= rtol or fine.rays is not None:
            break
    return best, least


def _tried(densities: FieldDensities) -> FloatArray:
    """f at a few velocities of each time, shape (n_times, n)."""
    out = []
    for i, t in enumerate(densities.times):
        fall = min(float(t), 1.0)  # of the size of the speeds that the field makes
        scale = math.hypot(densities.usual, fall)
        v, angle = np.meshgrid(scale * _TRIED_SPEEDS, _TRIED_ANGLES)
        sign = np.where(
            np.arange(angle.size) % 2, 1.0, -1.0 if densities.equation.families == 2 else 1.0
        )
        along, across = (v * np.cos(angle)).ravel(), (v * np.sin(angle)).ravel() * sign
        out.append(densities.at(i, along, across))
    return np.array(out)


class SceneDensities:
    """The densities of a scene with a field, at speeds in U.

    Parameters
    ----------
    law, state, rtol : as in `solve_densities`
    times : in d/U, shape (n_times,)
    units : sqrt(g l) in U and sqrt(l/g) in d/U
    """

    def __init__(
        self,
        law: CollisionLaw,
        state: State,
        times: FloatArray,
        units: tuple[float, float],
        rtol: float,
    ) -> None:
        self.unit, time = units
        found = solve_densities(law, state, 1.0 / self.unit, times / time, rtol)
        self.densities, self.error_estimate = found

    @property
    def uncollided(self) -> FloatArray:
        """See `FieldDensities`."""
        return self.densities.uncollided

    def speed_density(self, v: FloatArray) -> FloatArray:
        """In 1/U at all times, shape (n_times, n_v)."""
        count, one = self.densities.times.size, self.densities.by_speed
        return np.array([one(i, v / self.unit) for i in range(count)]) / self.unit

    def velocity_density(self, v: FloatArray, phi: FloatArray) -> FloatArray:
        """In U^-d at all times, shape (n_times, n_v, n_phi)."""
        count, d = self.densities.times.size, self.densities.law.dimension
        # each angle to the field once, of both signs if f is not symmetric about it
        turned = np.arctan2(np.sin(phi), np.cos(phi))
        if self.densities.equation.families == 1:
            turned = np.abs(turned)
        angle, where = np.unique(np.round(turned, 14), return_inverse=True)
        along = np.outer(v / self.unit, np.cos(angle)).ravel()
        across = np.outer(v / self.unit, np.sin(angle)).ravel()
        found = np.array([self.densities.at(i, along, across) for i in range(count)])
        return found.reshape(count, v.size, angle.size)[:, :, where] / self.unit**d
