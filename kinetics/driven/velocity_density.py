"""Densities of the velocity over time in a field, for one initial state.

f is the sum of the tracers that have not collided, in closed form (of sharp velocities only their
share is given), and of an integral over the last free flight of all others (`last_flights`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from kinetics.driven.averages import COLUMNS
from kinetics.driven.field_evolution import FieldEvolution
from kinetics.driven.free_fall import Velocities, free_path
from kinetics.driven.harmonics import angular, norms
from kinetics.driven.last_flights import POINTS_PER_INTERVAL, LastFlights
from kinetics.driven.starts import MAX_FOLLOWED
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import panels_between
from kinetics.states.kinds import Beam, VelocitySamples
from kinetics.states.state import State

#: Intervals of the angle to the field for the mean over directions: of tracers after a collision,
#: whose density is steep next to the field, ...
ANGLES_AFTER_COLLISION = np.array([0.0, 0.05, 0.25, 0.8, 1.8, math.pi])
#: ... and of those without one, which turn to the field.
ANGLES_WITHOUT_COLLISION = np.concatenate([[0.0], math.pi * 0.5 ** np.arange(8.0, -1.0, -1.0)])
#: Speeds over the usual one at which two solutions are compared.
COMPARED_SPEEDS_IN_FIELD = np.array(
    [0.01, 0.02, 0.04, 0.07, 0.1, 0.2, 0.3, 0.45, 0.6, 0.9, 1.2, 1.6, 2.0]
)
#: Angles at which two solutions are compared, on both sides of the field.
COMPARED_ANGLES = np.array([0.05, -0.5, 1.3, -2.2, 3.0])
#: Speeds over the usual one at which a density may not be below zero.
CHECKED_SPEEDS = np.linspace(0.1, 2.5, 17)
#: Least speed over U at which a profile is taken: directions are defined there.
MIN_SPEED_OF_PROFILE = 1e-12

#: A density at a time, and components of velocities along and across the field (n,), (n,).
DensityAt = Callable[[float, FloatArray, FloatArray], FloatArray]


def is_sharp(state: State) -> bool:
    """Return whether tracers start with sharp velocities; densities leave out who keeps them."""
    return isinstance(state, Beam) or state.peaks is not None or state.profile(0) is None


@dataclass(frozen=True)
class ComparedVelocities:
    """Velocities at which densities are compared, at one time.

    Parameters
    ----------
    time : its index
    speeds : (n_speeds,)
    along, across : the velocities, (n_angles * n_speeds,)
    """

    time: int
    speeds: FloatArray
    along: FloatArray
    across: FloatArray


class VelocityDensity:
    """The densities of one start over time, in units of sqrt(g l).

    Parameters
    ----------
    evolution : the solution, with its density
    unit : sqrt(g l) in U
    """

    def __init__(self, evolution: FieldEvolution, unit: float) -> None:
        self._evolution = evolution
        self._state = evolution.problem.state
        self._speed = 1.0 / unit  # U in sqrt(g l)
        self._dimension = evolution.problem.law.dimension
        self._flights = LastFlights(evolution.axis, self._dimension, evolution.gains)
        self._is_sharp = is_sharp(self._state)

    def at(self, i: int, along: FloatArray, across: FloatArray) -> FloatArray:
        """Return f at the i-th time and velocities (n,); without sharp velocities."""
        time = float(self._evolution.times[i])
        return self._flights.density(time, along, across) + self._smooth(time, along, across)

    def by_speed(self, i: int, v: FloatArray) -> FloatArray:
        """Return the density of the speed at the i-th time and speeds (n,)."""
        time = float(self._evolution.times[i])
        after_collision = self._over_directions(
            time, v, ANGLES_AFTER_COLLISION, self._flights.density
        )
        without_collision = self._over_directions(time, v, ANGLES_WITHOUT_COLLISION, self._smooth)
        density = after_collision + without_collision
        return np.asarray(density * v ** (self._dimension - 1))

    def _over_directions(
        self, time: float, v: FloatArray, edges: FloatArray, density: DensityAt
    ) -> FloatArray:
        """Return the integral of a density over the directions, at speeds v (n,).

        edges : intervals of the angle to the field
        """
        angle, weight = panels_between(edges, POINTS_PER_INTERVAL)
        measure = 2.0 * weight
        if self._dimension == 3:
            measure = 2.0 * math.pi * weight * np.sin(angle)
        along = np.outer(v, np.cos(angle))
        across = np.outer(v, np.sin(angle))
        sides = [across, -across][: self._evolution.families]
        by_side = [density(time, along.ravel(), side.ravel()) for side in sides]
        return np.asarray(np.mean(by_side, axis=0).reshape(along.shape) @ measure)

    def _smooth(self, time: float, along: FloatArray, across: FloatArray) -> FloatArray:
        """Return the density of tracers of smooth starts without a collision, (n,)."""
        density = np.zeros(along.shape)
        if self._is_sharp:
            return density
        u = along - time
        v = np.maximum(np.hypot(u, across), MIN_SPEED_OF_PROFILE * self._speed)
        last = self._evolution.harmonics
        if self._state.highest_harmonic is not None:
            last = min(self._state.highest_harmonic, last)
        even, odd = angular(u / v, across / v, max(last, 1) + 1, self._dimension)
        norm = norms(last + 1, self._dimension)[0, :, 0] * self._speed
        for m in range(last + 1):
            profile = self._state.profile(m)
            if profile is not None:
                value = np.asarray(profile(v / self._speed)) / norm[m]
                # the harmonics have the factor exp(-i m phi)
                density += np.real(value) * even[m] - np.imag(value) * odd[m]
        path = free_path(u, across, np.full(u.shape, time))
        return density / v ** (self._dimension - 1) * np.exp(-path)

    @property
    def uncollided(self) -> FloatArray:
        """Share of the tracers that keep a sharp velocity, (n_times,); 0 for smooth starts."""
        times = self._evolution.times
        if not self._is_sharp:
            return np.zeros(times.shape)
        velocities = self._sharp_velocities()
        return np.array([velocities.uncollided(float(time)).sum() for time in times])

    def _sharp_velocities(self) -> Velocities:
        """Return the velocities of a sharp start."""
        start = self._evolution.problem.start
        if start.velocities is not None:
            return start.velocities
        if self._state.highest_harmonic == 0:
            return Velocities.isotropic(start.speeds, self._speed, MAX_FOLLOWED, self._dimension)
        assert isinstance(self._state, VelocitySamples)
        return Velocities.samples(self._speed * np.asarray(self._state.velocity))

    # -- comparisons ------------------------------------------------------------------------------

    def _velocities(self, speeds: FloatArray, angles: FloatArray) -> Iterator[ComparedVelocities]:
        """Yield velocities for each time: speeds are over the usual one then."""
        for time, mean_square in enumerate(self._evolution.values[:, COLUMNS["v^2"]]):
            v = math.sqrt(abs(mean_square)) * speeds
            along = np.outer(np.cos(angles), v).ravel()
            across = np.outer(np.sin(angles), v).ravel()
            yield ComparedVelocities(time, v, along, across)

    def negative(self) -> float:
        """Return how far densities are below zero, over the largest of each time; 0 if not."""
        largest = 0.0
        for velocities in self._velocities(CHECKED_SPEEDS, np.append(0.0, COMPARED_ANGLES)):
            densities = (
                self.at(velocities.time, velocities.along, velocities.across),
                self.by_speed(velocities.time, velocities.speeds),
            )
            for density in densities:
                largest = max(largest, float(-density.min() / max(density.max(), 1e-300)))
        return largest

    def difference(self, other: VelocityDensity) -> float:
        """Return the largest difference of densities, of velocity and speed, over the largest."""
        largest = 0.0
        for velocities in self._velocities(COMPARED_SPEEDS_IN_FIELD, COMPARED_ANGLES):
            v = velocities.speeds
            shape = (COMPARED_ANGLES.size, v.size)
            own = self.at(velocities.time, velocities.along, velocities.across).reshape(shape)
            others = other.at(velocities.time, velocities.along, velocities.across).reshape(shape)
            for measure in (np.ones(v.size), v ** (self._dimension - 1)):
                scale = max(np.abs(own * measure).mean(axis=0).max(), 1e-300)
                difference = np.abs(own * measure - others * measure).max()
                largest = max(largest, float(difference / scale))
        return largest if math.isfinite(largest) else math.inf
