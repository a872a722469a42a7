"""Densities of the velocity in a field, as integrals over the last free flight.

With G(w, t) the density that collisions make per unit time, the tracers after a collision have

    f(v, t) = integral over s of exp(-path) G(v - s, t - s),

s along the field, path that of the flight. G is smooth where f is not: on the ray along the field,
on which tracers have come by rest. In units of sqrt(g l) for speeds. Begin with
`LastFlights.density`; `velocity_density` and `steady_density` use it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.polynomial.chebyshev import chebder, chebval
from numpy.polynomial.legendre import legval

from kinetics.driven import radau
from kinetics.driven.field_evolution import CollisionGain
from kinetics.driven.free_fall import BATCH_SIZE, free_path
from kinetics.driven.panels import SpeedPanels
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import gauss_legendre

#: The chance of a last flight that is longer than those that count, as -ln of it: 1e-12.
MAX_FLIGHT_PATH = -math.log(1e-12)
#: Harmonics that stay below this fraction of the largest are left out of G.
NEGLIGIBLE_HARMONIC = 1e-9
#: Points of an interval of the integral: with `FOLDS_PER_INTERVAL` 1e-8 is missed.
POINTS_PER_INTERVAL = 8
#: The chance of the flight falls by exp(-9), or the speed changes by e, on an interval.
FOLDS_PER_INTERVAL = 9.0
#: G varies little below this fraction of the first panel. Measured: at half and at twice densities
#: over time move by 2e-6 of their maximum at rtol 1e-4, those of the steady state by nothing.
SMOOTH_BELOW = 1e-3


@dataclass(frozen=True)
class FlightPoints:
    """Points of the integrals over last flights, (n,) each.

    Parameters
    ----------
    velocity : index of the velocity of which the point is
    along, across : the velocity after the collision
    duration : since then
    weight : of the integral, with the chance of the flight
    """

    velocity: np.ndarray
    along: FloatArray
    across: FloatArray
    duration: FloatArray
    weight: FloatArray


class LastFlights:
    """Integrals over what collisions make.

    Parameters
    ----------
    panels : of speeds
    dimension : d
    gains : what collisions make in each step of time; of a steady state one step with one point
    """

    def __init__(self, panels: SpeedPanels, dimension: int, gains: list[CollisionGain]) -> None:
        self._panels = panels
        self._dimension = dimension
        self._begins = np.array([gain.begin for gain in gains])
        self._lengths = np.array([gain.length for gain in gains])
        self._is_steady = len(gains[0].speed_times_density) == 1
        largest = max(np.abs(gain.speed_times_density).max() for gain in gains)
        least = NEGLIGIBLE_HARMONIC * largest
        #: For each step, then each panel: the coefficients of G for each family.
        self._coefficients = [
            self._coefficients_on(panel, gain.speed_times_density, least)
            for gain in gains
            for panel in range(len(panels.counts))
        ]

    def _coefficients_on(self, panel: int, density: FloatArray, least: float) -> list[FloatArray]:
        """Return coefficients, in the speed and the angle, of v G on a panel, by family.

        Those of family 1, which only occurs in the plane, are of slopes of the polynomials of
        family 0, times the sine.

        Parameters
        ----------
        panel : its index
        density : v G, (n_points, families, M + 1, size)
        least : smaller harmonics are left out

        Returns
        -------
        Shape (harmonics, n_points * nodes) for each family
        """
        on_panel = density[..., self._panels.parts[panel]]
        in_speed = on_panel @ self._panels.to_coefficients[panel].T
        by_family = np.moveaxis(in_speed, 0, 2)  # (families, harmonics, n_points, nodes)
        is_large = np.abs(by_family).max(axis=(0, 2, 3)) > least
        last = np.nonzero(is_large)[0].max(initial=1)
        flat = by_family[:, : last + 1].reshape(len(by_family), last + 1, -1)
        if len(flat) == 1:
            return [flat[0]]
        m = np.maximum(np.arange(last + 1), 1)[:, None]  # family 1 has no m = 0
        return [flat[0], chebder(flat[1] / m)]

    def density(self, time: float, along: FloatArray, across: FloatArray) -> FloatArray:
        """Return f at velocities (n,) of tracers after a collision, in units of sqrt(g l).

        Parameters
        ----------
        time : in sqrt(l/g); infinite in a steady state
        along, across : components along the field and across it, (n,)
        """
        if time <= 0.0:
            return np.zeros(along.shape)
        batches = np.array_split(np.arange(along.size), 1 + along.size // BATCH_SIZE)
        densities = [self._density(time, along[batch], across[batch]) for batch in batches]
        return np.concatenate(densities)

    def _density(self, time: float, along: FloatArray, across: FloatArray) -> FloatArray:
        """Return the same at a few velocities."""
        flights = self._flights(time, along, across)
        gained = self._gained(flights.along, flights.across, time - flights.duration)
        of_points = (flights.weight * gained).reshape(-1, POINTS_PER_INTERVAL)
        of_intervals = of_points.sum(axis=1)
        velocity = flights.velocity[::POINTS_PER_INTERVAL]
        return np.asarray(np.bincount(velocity, of_intervals, along.size), dtype=float)

    def _earliest(self, time: float, along: FloatArray, side: FloatArray) -> FloatArray:
        """Return the lowest component along the field with which a last flight may begin, (n,).

        The path is never shorter than that along, or across, the field alone.
        """
        with np.errstate(over="ignore", divide="ignore"):
            signed_square = along * np.abs(along) - 2.0 * MAX_FLIGHT_PATH
            lowest = along - np.minimum(time, MAX_FLIGHT_PATH / side)
        by_path_along = np.sign(signed_square) * np.sqrt(np.abs(signed_square))
        return np.maximum(lowest, by_path_along)

    def _flights(self, time: float, along: FloatArray, across: FloatArray) -> FlightPoints:
        """Return the quadrature over last flights that lead to velocities (n,).

        The component u along the field, with which a flight begins, is unit sinh(z); intervals of z
        end at the turning point, u = 0.
        """
        highest = self._panels.highest
        side = np.minimum(np.abs(across), highest)
        with np.errstate(over="ignore", divide="ignore"):
            reach = np.sqrt(np.maximum(highest**2 - side**2, 0.0))
        # G varies on the scale of the speed, but little in the first panel
        unit = np.maximum(side, SMOOTH_BELOW * self._panels.edges[1])
        first = np.clip(self._earliest(time, along, side), -reach, reach)
        last = np.clip(along, -reach, reach)
        turn = np.clip(0.0, first, last)
        end = np.append(turn, last)
        folds = (end**2 + np.tile(side, 2) ** 2) / FOLDS_PER_INTERVAL
        z_begin = np.arcsinh(np.append(first, turn) / np.tile(unit, 2))
        z_end = np.arcsinh(end / np.tile(unit, 2))
        # Each part, before and after the turning point, is cut into equal intervals.
        count = np.ceil((z_end - z_begin) * np.maximum(folds, 1.0)).astype(int)
        part = np.repeat(np.arange(count.size), count)
        place = np.arange(part.size) - np.repeat(np.cumsum(count) - count, count)
        width = ((z_end - z_begin)[part] / count[part])[:, None]
        x, x_weight = gauss_legendre(POINTS_PER_INTERVAL)
        z = (z_begin[part, None] + width * (place[:, None] + x)).ravel()
        velocity = np.repeat(part % along.size, POINTS_PER_INTERVAL)
        started_along = unit[velocity] * np.sinh(z)
        duration = np.maximum(along[velocity] - started_along, 0.0)
        path = free_path(-along[velocity], across[velocity], duration)
        weight = np.exp(-path) * (width * x_weight).ravel()
        return FlightPoints(
            velocity=velocity,
            along=started_along,
            across=across[velocity],
            duration=duration,
            weight=weight * np.hypot(started_along, unit[velocity]),
        )

    def _gained(self, along: FloatArray, across: FloatArray, time: FloatArray) -> FloatArray:
        """Return G at velocities, none of them 0, and times, (n,)."""
        v = np.hypot(along, across)
        cosine = along / v
        sine = across / v
        step = np.clip(np.searchsorted(self._begins, time, side="right") - 1, 0, None)
        n_panels = len(self._panels.counts)
        key = step * n_panels + self._panels.panel_of(v)
        order = np.argsort(key, kind="stable")
        gained = np.empty(v.size)
        for group in np.split(order, np.nonzero(np.diff(key[order]))[0] + 1):
            if group.size == 0:
                continue
            group_key = int(key[group[0]])
            rows = self._panels.polynomials(group_key % n_panels, v[group])
            if not self._is_steady:
                rows = self._rows_in_time(group_key // n_panels, time[group], rows)
            by_family = [
                self._sum_over_angles(cosine[group], coefficients @ rows.T)
                for coefficients in self._coefficients[group_key]
            ]
            gained[group] = by_family[0]
            if len(by_family) == 2:
                gained[group] += sine[group] * by_family[1]
        return gained / v

    def _rows_in_time(self, step: int, time: FloatArray, rows: FloatArray) -> FloatArray:
        """Return rows of polynomials in the speed, times those in time, (n, n_points * nodes)."""
        local = (time - self._begins[step]) / self._lengths[step]
        in_time = radau.interpolation_rows(local)
        return (in_time[:, :, None] * rows[:, None, :]).reshape(time.size, -1)

    def _sum_over_angles(self, cosine: FloatArray, coefficients: FloatArray) -> FloatArray:
        """Return series in the cosine of the angle, coefficients (harmonics, n), at (n,)."""
        if self._dimension == 2:
            return np.asarray(chebval(cosine, coefficients, tensor=False))
        return np.asarray(legval(cosine, coefficients, tensor=False))
