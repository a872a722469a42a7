"""Densities of the velocity over time in a field, for one initial state.

Units are those of the solver in a field of the acceleration g, with l the mean free path: speeds in
sqrt(g l), times in sqrt(l/g). U is the unit of the speeds of the initial state, and d the
dimension. A tracer that starts with (a, q), along and across the field, has (a + t, q) until it
collides.

The density f of the velocity is the sum of two terms:

- tracers that have collided: an integral over their last free flight (`last_flights`);
- tracers that have not: the density of the start at (a, q), times exp(-path of the flight), in
  closed form. Where the start is sharp (a delta peak of the speed, of the direction, or of both)
  they have no density. They are left out of f, and `VelocityDensity.uncollided` is their share.

Begin with `VelocityDensity.at`. The error is estimated by `VelocityDensity.difference` and
`VelocityDensity.negative`.
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

#: Edges in radians of the intervals of the angle to the field over which f of tracers that have
#: collided is averaged: it is steep next to the field. Chosen: with intervals half
#: or twice as wide the density of the speed moves by 8e-7 of its largest where the start is smooth
#: (e = 0.5 to 0.9), and by 1e-2 where it is sharp, as no interval resolves its fronts.
ANGLES_AFTER_COLLISION = np.array([0.0, 0.05, 0.25, 0.8, 1.8, math.pi])
#: The same in radians for tracers that have not collided, which turn to the field with time: each
#: interval is half as wide as the next. Chosen: with intervals half or twice
#: as wide the density of the speed moves by 2e-11 of its largest.
ANGLES_WITHOUT_COLLISION = np.concatenate([[0.0], math.pi * 0.5 ** np.arange(8.0, -1.0, -1.0)])
#: Speeds at which two solutions are compared, over sqrt(<v^2>) at that time; more of them are
#: at low speeds, where f is steep. Chosen: with half or twice as many the difference
#: is 0.6 to 1.2 times as large.
COMPARED_SPEEDS_IN_FIELD = np.array(
    [0.01, 0.02, 0.04, 0.07, 0.1, 0.2, 0.3, 0.45, 0.6, 0.9, 1.2, 1.6, 2.0]
)
#: Angles to the field in radians at which two solutions are compared: one next to the field, and
#: others on both sides, because f of a start that is not symmetric differs there. On the ray along
#: the field f may be infinite. Chosen: with half or twice as many the difference is
#: 0.8 to 1.1 times as large.
COMPARED_ANGLES = np.array([0.05, -0.5, 1.3, -2.2, 3.0])
#: Speeds over sqrt(<v^2>) at that time at which a density may not be below zero, evenly spread over
#: the bulk, where fronts of a sharp start pass. Chosen: with half or twice as many
#: `VelocityDensity.negative` is 0.6 to 1 times as large for tracers of one speed, and from rest up
#: to 3e-2 in place of 6e-4, which is less than the difference of two solutions there, 0.2.
CHECKED_SPEEDS = np.linspace(0.1, 2.5, 17)
#: Angles to the field in radians at which a density may not be below zero: the ray along the field
#: and those that are compared. Origin not recorded.
CHECKED_ANGLES = np.append(0.0, COMPARED_ANGLES)
#: Least speed over U at which the density of the start is evaluated, so that its direction is
#: defined. Any speed that is far below all others will do.
MIN_SPEED_OF_PROFILE = 1e-12
#: Stands for 0 where a difference is divided by the largest density: close to the smallest number.
LEAST_SCALE = 1e-300

#: A function of a time, and of velocities along and across the field, (n,) each, that returns a
#: density of the velocity, (n,).
DensityAt = Callable[[float, FloatArray, FloatArray], FloatArray]


def is_sharp(state: State) -> bool:
    """Return whether tracers start with delta peaks, so that f leaves out those that still fly.

    True for beams, for starts of sharp speeds and for samples. A start is sharp or smooth as a
    whole: no state is partly sharp.
    """
    return isinstance(state, Beam) or state.peaks is not None or state.profile(0) is None


@dataclass(frozen=True)
class ComparedVelocities:
    """A grid of velocities at one time, at which densities are compared.

    Parameters
    ----------
    time : index of the time
    speeds : in sqrt(g l), shape (n_speeds,)
    along, across : components along and across the field of all pairs of an angle and a speed, in
        sqrt(g l), shape (n_angles * n_speeds,): all speeds of the first angle come first
    """

    time: int
    speeds: FloatArray
    along: FloatArray
    across: FloatArray


class VelocityDensity:
    """The densities of the velocity and of the speed for one start, at the times of a solution.

    Parameters
    ----------
    evolution : the solution over time, with what collisions made in each step (``gains``)
    unit : sqrt(g l) in U, by which speeds of the start are turned into those of the solver
    """

    def __init__(self, evolution: FieldEvolution, unit: float) -> None:
        self._evolution = evolution
        self._state = evolution.problem.state
        self._speed = 1.0 / unit  # U in sqrt(g l)
        self._dimension = evolution.problem.law.dimension
        self._flights = LastFlights(evolution.axis, self._dimension, evolution.gains)
        self._is_sharp = is_sharp(self._state)

    def at(self, i: int, along: FloatArray, across: FloatArray) -> FloatArray:
        """Return f at the i-th time, in (g l)^(-d/2), without tracers of sharp velocities.

        Parameters
        ----------
        i : index of the time
        along, across : components of the velocities along and across the field in sqrt(g l), (n,)
        """
        time = float(self._evolution.times[i])
        return self._flights.density(time, along, across) + self._smooth(time, along, across)

    def by_speed(self, i: int, v: FloatArray) -> FloatArray:
        """Return the density of the speed at the i-th time, in 1/sqrt(g l), shape (n,).

        It is v^(d-1) times the integral of f over the directions; v in sqrt(g l), shape (n,).
        """
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
        """Return the integral of a density over all directions, at speeds v, shape (n,).

        Of the two sides of the field one is enough where the start is symmetric (one family of
        harmonics); in the plane the density may differ between them, and their mean counts twice.
        In space all starts are symmetric.

        Parameters
        ----------
        time : in sqrt(l/g)
        v : speeds in sqrt(g l), shape (n,)
        edges : of the intervals of the angle to the field in radians, from 0 to pi
        density : of the velocity
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
        """Return f of the tracers of a smooth start that have not collided, shape (n,).

        Harmonic m of the start, p_m, is the integral over the directions phi of exp(-i m phi) times
        the density of the speed and the direction. So this density is the sum over m of
        Re(p_m exp(i m phi)) over the norm of harmonic m, with exp(i m phi) = even + i odd.
        """
        density = np.zeros(along.shape)
        if self._is_sharp:
            return density
        u = along - time  # the component along the field at the start
        v = np.maximum(np.hypot(u, across), MIN_SPEED_OF_PROFILE * self._speed)
        last = self._evolution.harmonics
        if self._state.highest_harmonic is not None:
            last = min(self._state.highest_harmonic, last)
        count = max(last, 1) + 1  # `angular` makes two harmonics at least
        even, odd = angular(u / v, across / v, count, self._dimension)
        norm = norms(last + 1, self._dimension)[:, 0] * self._speed  # the profiles are in 1/U
        for m in range(last + 1):
            profile = self._state.profile(m)
            if profile is not None:
                value = np.asarray(profile(v / self._speed)) / norm[m]
                density += np.real(value) * even[m] - np.imag(value) * odd[m]
        path = free_path(u, across, np.full(u.shape, time))
        return density / v ** (self._dimension - 1) * np.exp(-path)

    @property
    def uncollided(self) -> FloatArray:
        """The share of tracers of a sharp start that have not collided; 0 for smooth starts.

        Shape (n_times,). It is what f lacks.
        """
        times = self._evolution.times
        if not self._is_sharp:
            return np.zeros(times.shape)
        velocities = self._sharp_velocities()
        return np.array([velocities.uncollided(float(time)).sum() for time in times])

    def _sharp_velocities(self) -> Velocities:
        """Return the velocities of a sharp start with their shares.

        Isotropic starts of sharp speeds are spread over MAX_FOLLOWED directions for each speed.
        """
        start = self._evolution.problem.start
        if start.velocities is not None:
            return start.velocities
        if self._state.highest_harmonic == 0:
            return Velocities.isotropic(start.speeds, self._speed, MAX_FOLLOWED, self._dimension)
        assert isinstance(self._state, VelocitySamples)
        return Velocities.samples(self._speed * np.asarray(self._state.velocity))

    # -- comparisons ------------------------------------------------------------------------------

    def _velocities(self, speeds: FloatArray, angles: FloatArray) -> Iterator[ComparedVelocities]:
        """Yield for each time the velocities of all angles and speeds.

        Parameters
        ----------
        speeds : over sqrt(<v^2>) at that time
        angles : to the field in radians
        """
        for time, mean_square in enumerate(self._evolution.values[:, COLUMNS["v^2"]]):
            v = math.sqrt(abs(mean_square)) * speeds
            along = np.outer(np.cos(angles), v).ravel()
            across = np.outer(np.sin(angles), v).ravel()
            yield ComparedVelocities(time, v, along, across)

    def negative(self) -> float:
        """Return how far f and the density of the speed are below zero, relative to their largest.

        It is the largest of all times; 0 if they are nowhere below zero, and infinite if one of
        them is not a number at the velocities that are checked.
        """
        largest = 0.0
        for velocities in self._velocities(CHECKED_SPEEDS, CHECKED_ANGLES):
            densities = (
                self.at(velocities.time, velocities.along, velocities.across),
                self.by_speed(velocities.time, velocities.speeds),
            )
            for density in densities:
                scale = np.maximum(density.max(), LEAST_SCALE)
                largest = np.maximum(largest, -density.min() / scale)  # keeps what is no number
        return _infinite_if_unknown(largest)

    def difference(self, other: VelocityDensity) -> float:
        """Return the largest difference of f, and of v^(d-1) f, between two solutions.

        Both are compared at COMPARED_SPEEDS_IN_FIELD and COMPARED_ANGLES. Each is relative to the
        largest mean over these angles, of this solution at the same time. It is infinite if a
        density is not finite at one of them.
        """
        largest = 0.0
        for velocities in self._velocities(COMPARED_SPEEDS_IN_FIELD, COMPARED_ANGLES):
            v = velocities.speeds
            shape = (COMPARED_ANGLES.size, v.size)
            own = self.at(velocities.time, velocities.along, velocities.across).reshape(shape)
            others = other.at(velocities.time, velocities.along, velocities.across).reshape(shape)
            for measure in (np.ones(v.size), v ** (self._dimension - 1)):
                scale = np.maximum(np.abs(own * measure).mean(axis=0).max(), LEAST_SCALE)
                difference = np.abs(own * measure - others * measure).max()
                largest = np.maximum(largest, difference / scale)  # keeps what is no number
        return _infinite_if_unknown(largest)


def _infinite_if_unknown(error: float) -> float:
    """Return an error; infinity where it is not a number."""
    return math.inf if math.isnan(error) else float(error)
