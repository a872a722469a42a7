"""Tracers that fall freely from sharp velocities in a unit field, until they first collide.

In units of sqrt(g l) for speeds and sqrt(l/g) for times, a tracer that starts with (a, q), along
and across the field, has the velocity (a + t, q) at time t. It has not collided with the
probability exp(-s), s the integral of its speed (`free_path`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from kinetics.driven.averages import AVERAGE_ROWS, Component
from kinetics.driven.axis import VelocityAxis
from kinetics.driven.harmonics import angular
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import gauss_legendre
from kinetics.states.state import LogMeasure

#: Velocities that are treated together: so few that what belongs to them stays in the cache.
BATCH_SIZE = 1000
#: Components across a velocity, relative to it, that are rounding.
STRAIGHT_BELOW = 4.0 * np.finfo(float).eps
#: Least speed, so that directions are defined. Chosen: far below any other.
MIN_SPEED = 1e-300


def free_path(a: FloatArray, q: FloatArray, time: FloatArray) -> FloatArray:
    """Return the integral over the time of the speed |(a + time, q)|, without cancellation.

    The antiderivative of sqrt(u^2 + q^2) is (u sqrt(u^2 + q^2) + q^2 ln(u + sqrt(u^2 + q^2)))/2;
    its differences are written so that no digits cancel.
    """
    u = a + time
    first_speed = np.hypot(a, q)
    last_speed = np.hypot(u, q)
    is_straight = np.abs(q) <= STRAIGHT_BELOW * np.abs(a)
    is_straight_up = is_straight & (a < 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        speed_sum = first_speed + last_speed
        gained_speed = np.where(speed_sum > 0.0, time * (u + a) / speed_sum, 0.0)
        nearest = np.where(a > 0.0, first_speed + a, q * q / (first_speed - a))
        logarithm = q * q * np.log1p(np.maximum(time + gained_speed, 0.0) / nearest)
    logarithm = np.where(is_straight | (q == 0.0), 0.0, logarithm)
    straight = np.where(is_straight_up, 0.5 * (u * np.abs(u) - a * np.abs(a)), 0.0)
    bent = 0.5 * (time * last_speed + a * gained_speed + logarithm)
    return np.where(is_straight_up, straight, bent)


@dataclass(frozen=True)
class Bounces:
    """The outcomes of a collision, if it scales with the speed.

    Parameters
    ----------
    kept : the share of each harmonic that a bounce keeps, times its weight, (count, n_bounces)
    ratio : of the speeds after and before it, (n_bounces,)
    """

    kept: FloatArray
    ratio: FloatArray


@dataclass(frozen=True)
class Velocities:
    """Velocities at the start in sqrt(g l), each with its share of the tracers.

    Parameters
    ----------
    along, across : components along the field and across it, (n,)
    weight : the shares, (n,)
    symmetric : whether each stands for all that differ by a turn, or a reflection, about the field
    dimension : d
    """

    along: FloatArray
    across: FloatArray
    weight: FloatArray
    symmetric: bool
    dimension: int

    @classmethod
    def rest(cls, dimension: int) -> Velocities:
        """Return the velocity 0 of tracers at rest."""
        return cls(np.zeros(1), np.zeros(1), np.ones(1), True, dimension)

    @classmethod
    def isotropic(
        cls, speeds: LogMeasure, unit: float, directions: int, dimension: int
    ) -> Velocities:
        """Return velocities in so many directions, all alike; `unit` is U in sqrt(g l)."""
        v = unit * np.exp(speeds.x)
        if dimension == 2:
            cosine = np.cos((np.arange(directions) + 0.5) * (math.pi / directions))
            share = np.full(directions, 1.0 / directions)
        else:
            x, share = gauss_legendre(directions)
            cosine = 2.0 * x - 1.0
        along = np.outer(v, cosine)
        across = np.outer(v, np.sqrt(1.0 - cosine**2))
        weight = np.outer(speeds.weight.real, share)
        return cls(along.ravel(), across.ravel(), weight.ravel(), True, dimension)

    @classmethod
    def samples(cls, velocity: FloatArray) -> Velocities:
        """Return velocities (n, 2) in the plane, each with the same share."""
        share = np.full(len(velocity), 1.0 / len(velocity))
        return cls(velocity[:, 0], velocity[:, 1], share, False, 2)

    @property
    def highest(self) -> float:
        """The largest speed."""
        return float(np.max(np.hypot(self.along, self.across)))

    def uncollided(self, time: float) -> FloatArray:
        """Return the share of tracers with each velocity that have not collided, (n,)."""
        path = free_path(self.along, self.across, np.full(self.along.size, time))
        return np.asarray(self.weight * np.exp(-path))

    def averages(self, time: float) -> FloatArray:
        """Return what tracers without a collision add to `averages.AVERAGE_ROWS`, (n_averages,)."""
        u = self.along + time
        q = self.across
        x = (self.along + 0.5 * time) * time
        y = q * time
        v_squared = u * u + q * q
        # Means over turns about the field: of q^2 in one direction, and of odd powers of q.
        even = 1.0 / (self.dimension - 1.0)
        odd = 0.0 if self.symmetric else 1.0
        of_each_velocity = {
            "v_x": u,
            "v_y": odd * q,
            "v^2": v_squared,
            "v^2 cos 2": u * u - even * q * q,
            "v_x v_y": odd * u * q,
            "v^4": v_squared**2,
            "collision rate": np.sqrt(v_squared),
            "v_x x": u * x,
            "v_y y": even * q * y,
            "v_x y + v_y x": odd * (u * y + q * x),
            "1": np.ones(u.size),
        }
        rows = np.array([of_each_velocity[average.name] for average in AVERAGE_ROWS])
        return np.asarray(rows @ self.uncollided(time))

    def project(
        self, times: FloatArray, axis: VelocityAxis, count: int, components: list[Component]
    ) -> FloatArray:
        """Return sums over tracers without a collision of harmonics and polynomials of an axis.

        Returns
        -------
        Shape (n_times, n_components, count, size)
        """
        sums = np.zeros((times.size, len(components), count, axis.size))
        for batch in np.array_split(np.arange(self.along.size), 1 + self.along.size // BATCH_SIZE):
            a, q, t = np.broadcast_arrays(self.along[batch], self.across[batch], times[:, None])
            v = np.maximum(np.hypot(a + t, q), MIN_SPEED)
            cosine = ((a + t) / v).ravel()
            sine = (q / v).ravel()
            by_family = [
                harmonics.reshape(count, *a.shape).swapaxes(0, 1)
                for harmonics in angular(cosine, sine, count, self.dimension)
            ]
            polynomials = axis.interpolation(np.minimum(v, axis.highest).ravel())
            polynomials = polynomials.reshape(*a.shape, axis.size)
            share = self.weight[batch] * np.exp(-free_path(a, q, t))
            weights = {
                "1": share,
                "x": share * (a + 0.5 * t) * t,
                "y": share * q * t / (self.dimension - 1.0),  # the mean over turns
            }
            for k, component in enumerate(components):
                weighted = by_family[component.family] * weights[component.weight][:, None]
                sums[:, k] += weighted @ polynomials
        return sums

    def project_collided(
        self,
        times: FloatArray,
        axis: VelocityAxis,
        components: list[Component],
        bounces: Bounces,
    ) -> FloatArray:
        """Return what first collisions make per unit time, in the shape of `project`.

        Each bounce is followed, so that a velocity is never interpolated: what bounces make of it
        is spread over the speeds, and polynomials on panels have its averages to more digits.
        """
        count = len(bounces.kept)
        sums = np.zeros((times.size, len(components), count, axis.size))
        for along, across, weight in zip(self.along, self.across, self.weight, strict=True):
            u = along + times
            q = np.full(times.size, across)
            v = np.maximum(np.hypot(u, q), MIN_SPEED)
            by_family = angular(u / v, q / v, count, self.dimension)
            after = np.minimum(v, axis.highest)[:, None] * bounces.ratio
            rows = axis.interpolation(after.ravel()).reshape(*after.shape, axis.size)
            scattered = np.matmul(bounces.kept, rows)
            rate = weight * v * np.exp(-free_path(np.full(times.size, along), q, times))
            weights = {
                "1": np.ones(times.size),
                "x": (along + 0.5 * times) * times,
                "y": q * times / (self.dimension - 1.0),  # the mean over turns
            }
            for k, component in enumerate(components):
                weighted_rate = rate * weights[component.weight]
                factor = by_family[component.family].T * weighted_rate[:, None]
                sums[:, k] += factor[:, :, None] * scattered
        return sums
