"""The densities of a scene in a field, as finely resolved as its rtol needs."""

from __future__ import annotations

import math

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.field.densities import FieldDensities
from kinetics.field.resolution import TimeResolution
from kinetics.numerics import FloatArray
from kinetics.states.state import State

_TRIED_SPEEDS = np.array([0.1, 0.3, 0.6, 0.9, 1.2, 1.6, 2.0])
_TRIED_ANGLES = np.array([0.05, 0.5, 1.3, 2.2, 3.0])
_ATTEMPTS = 3


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

    def component_density(self, v_x: FloatArray) -> FloatArray:
        """Of the velocity along the field in 1/U at all times, shape (n_times, n)."""
        count, one = self.densities.times.size, self.densities.by_component
        return np.array([one(i, v_x / self.unit) for i in range(count)]) / self.unit

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
