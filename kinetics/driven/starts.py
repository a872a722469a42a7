"""Initial states in a field: by their harmonics, or as velocities from which tracers fall freely.

Over harmonics, averages converge fast where the start has few of them and is not slow. Rest, beams,
a few samples and slow isotropic starts are velocities instead: of each what has not collided is in
closed form, and collisions spread directions.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kinetics.driven.harmonics import angular
from kinetics.driven.panels import SpeedPanels
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import gauss_legendre
from kinetics.states.kinds import Beam, Rest, VelocitySamples
from kinetics.states.state import LogMeasure, State

if TYPE_CHECKING:
    from kinetics.driven.axis import SpeedAxis

TOGETHER = 1000  # velocities, so few that what belongs to them stays in the cache
FEW = 64  # so many samples, or directions, are followed each
_STRAIGHT = 4.0 * np.finfo(float).eps  # components across a velocity that are rounding


def free_way(a: FloatArray, q: FloatArray, time: FloatArray) -> FloatArray:
    """Integral over the time of the speed |(a + time, q)|, without cancellation."""
    u = a + time
    first, last = np.hypot(a, q), np.hypot(u, q)
    is_straight = np.abs(q) <= _STRAIGHT * np.abs(a)
    with np.errstate(divide="ignore", invalid="ignore"):
        gained = np.where(first + last > 0.0, time * (u + a) / (first + last), 0.0)
        nearest = np.where(a > 0.0, first + a, q * q / (first - a))
        turned = q * q * np.log1p(np.maximum(time + gained, 0.0) / nearest)
    turned = np.where(is_straight | (q == 0.0), 0.0, turned)
    straight = np.where(is_straight & (a < 0.0), 0.5 * (u * np.abs(u) - a * np.abs(a)), 0.0)
    bent = 0.5 * (time * last + a * gained + turned)
    return np.where(is_straight & (a < 0.0), straight, bent)


@dataclass(frozen=True)
class Velocities:
    """Components of the velocity in sqrt(g l), each with its share of the tracers, (n,).

    symmetric : whether each stands for all that differ by a turn, or a reflection, about the field
    """

    along: FloatArray
    across: FloatArray
    weight: FloatArray
    symmetric: bool
    dimension: int

    @classmethod
    def isotropic(
        cls, speeds: LogMeasure, unit: float, directions: int, dimension: int
    ) -> Velocities:
        """All directions alike; U is the unit of the speed."""
        v, w = unit * np.exp(speeds.x), speeds.weight.real
        if dimension == 2:
            cosine = np.cos((np.arange(directions) + 0.5) * (math.pi / directions))
            share = np.full(directions, 1.0 / directions)
        else:
            x, share = gauss_legendre(directions)
            cosine = 2.0 * x - 1.0
        along, across = np.outer(v, cosine), np.outer(v, np.sqrt(1.0 - cosine**2))
        return cls(along.ravel(), across.ravel(), np.outer(w, share).ravel(), True, dimension)

    @classmethod
    def samples(cls, velocity: FloatArray) -> Velocities:
        """Velocities (n, 2) in the plane, each with the same share."""
        share = np.full(len(velocity), 1.0 / len(velocity))
        return cls(velocity[:, 0], velocity[:, 1], share, False, 2)

    def uncollided(self, time: float) -> FloatArray:
        """The share of the tracers that each has, of those that have not collided, (n,)."""
        way = free_way(self.along, self.across, np.full(self.along.size, time))
        return np.asarray(self.weight * np.exp(-way))

    def averages(self, time: float) -> FloatArray:
        """What tracers without a collision add to the averages `march.AVERAGES`."""
        u, q = self.along + time, self.across
        x, y = (self.along + 0.5 * time) * time, q * time
        half, odd = 1.0 / (self.dimension - 1.0), 0.0 if self.symmetric else 1.0
        square, zero = u * u + q * q, np.zeros(u.size)
        every = [u, odd * q, square, u * u - half * q * q, odd * u * q, square**2, np.sqrt(square)]
        every += [u * x, half * q * y, odd * (u * y + q * x), zero + 1.0]
        return np.asarray((np.array(every) + zero) @ self.uncollided(time))

    def projected(
        self, times: FloatArray, panels: SpeedPanels, count: int, fields: list[tuple[str, int]]
    ) -> FloatArray:
        """Sums over tracers without a collision of harmonics and polynomials on the panels.

        fields : name and family of what is summed, as in `march`: 1, x or y.
            Shape (n_times, n_fields, count, size)
        """
        out = np.zeros((times.size, len(fields), count, panels.size))
        for part in np.array_split(np.arange(self.along.size), 1 + self.along.size // TOGETHER):
            a, q, t = np.broadcast_arrays(self.along[part], self.across[part], times[:, None])
            v = np.maximum(np.hypot(a + t, q), 1e-300)
            cosine, sine = (a + t) / v, q / v
            flat = angular(cosine.ravel(), sine.ravel(), count, self.dimension)
            tables = [table.reshape(count, *a.shape).swapaxes(0, 1) for table in flat]
            rows = panels.interpolation(np.minimum(v, panels.highest).ravel())
            left = self.weight[part] * np.exp(-free_way(a, q, t))
            y = left * q * t / (self.dimension - 1.0)  # the mean over turns about the field
            share = {"f": left, "x": left * (a + 0.5 * t) * t, "y": y}
            for k, (name, family) in enumerate(fields):
                weighed = tables[family] * share[name][:, None]
                out[:, k] += weighed @ rows.reshape(*a.shape, panels.size)
        return out

    def collided(
        self,
        times: FloatArray,
        panels: SpeedPanels,
        count: int,
        fields: list[tuple[str, int]],
        kept: FloatArray,
        ratio: FloatArray,
    ) -> FloatArray:
        """What first collisions make per unit time, as `projected` has it.

        Each bounce is followed, so that a velocity is never interpolated: what bounces make of it
        is spread over the speeds, and polynomials on panels have its averages to more digits.

        Parameters
        ----------
        kept : the share of each harmonic that a bounce keeps, times its weight, (count, n_bounces)
        ratio : of the speeds after and before it, (n_bounces,)
        """
        sums = np.zeros((times.size, len(fields), count, panels.size))
        for along, across, weight in zip(self.along, self.across, self.weight, strict=True):
            u = along + times
            q = np.full(times.size, across)
            v = np.maximum(np.hypot(u, q), 1e-300)
            harmonics = angular(u / v, q / v, count, self.dimension)
            after = np.minimum(v, panels.highest)[:, None] * ratio
            rows = panels.interpolation(after.ravel()).reshape(*after.shape, panels.size)
            scattered = np.matmul(kept, rows)
            rate = weight * v * np.exp(-free_way(np.full(times.size, along), q, times))
            moved_across = q * times / (self.dimension - 1.0)  # the mean over turns
            moved = {"f": np.ones(times.size), "x": (along + 0.5 * times) * times}
            moved["y"] = moved_across
            for k, (name, family) in enumerate(fields):
                factor = harmonics[family].T * (rate * moved[name])[:, None]
                sums[:, k] += factor[:, :, None] * scattered
        return sums


@dataclass(frozen=True)
class Start:
    """An initial state in units of sqrt(g l).

    measures : weighted points of ln(v/U) of each harmonic, or None
    speed : U in sqrt(g l)
    velocities : if there are any, they are used, and not the harmonics
    """

    measures: tuple[LogMeasure | None, ...]
    speed: float
    velocities: Velocities | None = None

    @classmethod
    def rest(cls, dimension: int) -> Start:
        """All tracers are at rest."""
        return cls((), 1.0, Velocities(np.zeros(1), np.zeros(1), np.ones(1), True, dimension))

    @classmethod
    def of(cls, state: State, rtol: float, speed: float, harmonics: int, dimension: int) -> Start:
        """With harmonics up to the highest that is solved, and averages of v^0 to v^4."""
        if isinstance(state, Rest):
            return cls.rest(dimension)
        speeds = state.harmonic(0, rtol, 0.0, 4.0)
        assert speeds is not None  # every state has its speeds
        v, w = speed * np.exp(speeds.x), speeds.weight.real
        if isinstance(state, Beam):
            along, across = v * math.cos(state.direction), v * math.sin(state.direction)
            straight = math.sin(state.direction) == 0.0
            return cls((speeds,), speed, Velocities(along, across, w, straight, dimension))
        if isinstance(state, VelocitySamples) and np.shape(state.velocity)[0] <= FEW:
            return cls((speeds,), speed, Velocities.samples(speed * np.asarray(state.velocity)))
        there = state.highest_harmonic
        if there == 0 and v.max() < 1.0:  # sqrt(g l)
            found = Velocities.isotropic(speeds, speed, (harmonics + 1) // 2, dimension)
            return cls((speeds,), speed, found)
        last = harmonics if there is None else min(there, harmonics)
        every = (state.harmonic(m, rtol, 0.0, 4.0) for m in range(last + 1))
        return cls(tuple(every), speed)

    @property
    def is_symmetric(self) -> bool:
        """Whether the state is symmetric about the field."""
        if self.velocities is not None:
            return self.velocities.symmetric
        return not any(np.any(np.abs(np.imag(m.weight)) > 1e-9) for m in self.measures if m)

    @property
    def highest(self) -> float:
        """The largest speed at the start."""
        if self.velocities is not None:
            return float(np.max(np.hypot(self.velocities.along, self.velocities.across)))
        return max(self.speed * float(np.exp(m.x.max())) for m in self.measures if m)

    @property
    def mean_speed(self) -> float:
        """The average speed at the start; 0 of rest, which has no measure."""
        found = self.measures[0] if self.measures else None
        return self.speed * float(found.weight.real @ np.exp(found.x)) if found else 0.0

    def projected(
        self,
        axis: SpeedPanels | SpeedAxis,
        count: int,
        families: int,
        state: State | None,
        tolerance: float = math.inf,
    ) -> FloatArray:
        """Sums over the start of harmonics and polynomials of an axis, (families, count, size).

        A few points of a measure give averages of smooth functions, but a polynomial on a panel is
        smooth on its panel only: where the state has a profile, that is integrated instead.

        Parameters
        ----------
        axis : the axis of speeds
        count, families : of the harmonics
        state : whose profiles are integrated; None to take the points of the measures
        tolerance : by so much integrals of v^0 ... v^4 over a profile may differ from those over
            the measure, relative to those of harmonic 0; beyond, the quadrature has missed
            something, such as a narrow peak, and the points of the measure are taken
        """
        sums = np.zeros((families, count, axis.size))
        for m, measure in enumerate(self.measures[:count]):
            if measure is None:
                continue
            averages = None if state is None else self._profile_averages(axis, m, state)
            if averages is None or not self._has_same_moments(axis, m, averages, tolerance):
                averages = self._point_averages(axis, m, measure)
            # the weights have the factor exp(-i m phi)
            sums[:, m] = np.stack([np.real(averages), -np.imag(averages)])[:families]
        return sums

    def _profile_averages(
        self, axis: SpeedPanels | SpeedAxis, m: int, state: State
    ) -> NDArray[Any] | None:
        """Averages of the polynomials of an axis over the profile of harmonic m, if it has one."""
        profile = state.profile(m)
        if profile is None:
            return None

        def density(v: FloatArray) -> NDArray[Any]:
            return np.asarray(profile(v / self.speed) / self.speed)

        kinks = self.speed * np.asarray(state.kinks)
        return np.asarray(axis.averaged(density, m % 2, kinks))

    def _point_averages(
        self, axis: SpeedPanels | SpeedAxis, m: int, measure: LogMeasure
    ) -> NDArray[Any]:
        """Averages of the polynomials of an axis over the points of a measure, (size,)."""
        v = self.speed * np.exp(measure.x)
        averages: NDArray[Any] = np.zeros(axis.size, dtype=measure.weight.dtype)
        for batch in np.array_split(np.arange(v.size), 1 + v.size // TOGETHER):
            averages += measure.weight[batch] @ axis.interpolation(v[batch], m % 2)
        return averages

    def _has_same_moments(
        self, axis: SpeedPanels | SpeedAxis, m: int, averages: NDArray[Any], tolerance: float
    ) -> bool:
        """Whether v^0 ... v^4 have the averages that the measure of harmonic m gives them."""
        if math.isinf(tolerance):
            return True
        measure = self.measures[m]
        speeds = self.measures[0]
        assert measure is not None
        assert speeds is not None
        for power in range(5):
            moment = axis.speeds**power @ averages
            expected = measure.weight @ (self.speed * np.exp(measure.x)) ** power
            scale = speeds.weight.real @ (self.speed * np.exp(speeds.x)) ** power
            if not abs(moment - expected) <= tolerance * scale:
                return False
        return True
