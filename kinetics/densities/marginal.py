"""One Cartesian component of an isotropic velocity: the marginal F(c_x) of the paper's scalev.

In the plane it is an integral of f(|v|) over the other component, in space one over the speed: on a
sphere of radius v one component is uniform from -v to v.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.densities.harmonic import Profile
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import panels_between

# Gauss panels in ln of the other component, in units of a typical speed. Below e^-20 of it, where
# the density is constant, the other component is taken in one piece; above e^4.5 = 90 of it nothing
# is left of an exponential tail. tests/kinetics/measurements/densities.py measures the error.
_LOWEST, _HIGHEST, _PANEL, _POINTS = -20.0, 4.5, 0.5, 10
_FASTEST = 1e100  # in typical speeds: no tracer is as fast


def component_density(
    plane_density: Callable[[FloatArray], NDArray[Any]], component: FloatArray, typical: float
) -> NDArray[Any]:
    """Integral over v_y of a density f(|v|) in the plane, at v_x = component.

    plane_density : takes speeds |v|, shape (k,), to the density there, shape (..., k)
    component : v_x, not negative, shape (n,), in the unit of the speeds
    typical : a speed of the order of the thermal one, in the same unit

    Shape (..., n).
    """
    other, w = _others(typical)
    speed = np.hypot(component[:, None], other)
    values = plane_density(speed.ravel())
    values = values.reshape(*values.shape[:-1], component.size, other.size)
    # twice, for both signs of v_y; below the first panel the density is that of its first point
    inner = math.exp(_LOWEST) * typical * values[..., 0]
    return np.asarray(2.0 * (values @ (w * other) + inner))


def component_density_in_space(
    speed_density: Callable[[FloatArray], NDArray[Any]], component: FloatArray, typical: float
) -> NDArray[Any]:
    """Integral of g(v)/(2 v) over speeds v above v_x = component, g the density of the speed.

    speed_density : takes speeds v, shape (k,), to g, shape (..., k)
    component, typical : as for :func:`component_density`

    Shape (..., n). With v^2 = v_x^2 + w^2 it is the integral of g w^2/(2 v^2) over ln w.
    """
    other, w = _others(typical)
    speed = np.hypot(component[:, None], other)
    values = speed_density(speed.ravel())
    values = values.reshape(*values.shape[:-1], component.size, other.size)
    return np.asarray((values * (0.5 * (other / speed) ** 2)) @ w)


def _others(typical: float) -> tuple[FloatArray, FloatArray]:
    """Gauss points of the size of the rest of the velocity, and their weights in its logarithm."""
    y, w = panels_between(np.arange(_LOWEST, _HIGHEST + 0.5 * _PANEL, _PANEL), _POINTS)
    return typical * np.exp(y), w


def component_densities(
    profile: Profile, x: FloatArray, unit: FloatArray, dimension: int
) -> FloatArray:
    """Density of one velocity component at |v_x| = x (n,) in U, shape (n_times, n), in 1/U.

    profile : harmonic 0 of the velocity density
    unit : speeds of the order of the thermal one, shape (n_times,)
    """
    out = np.empty((unit.size, x.size))
    for i, one in enumerate(unit.tolist()):
        near = np.minimum(x, _FASTEST * one)
        if dimension == 3:

            def in_space(v: FloatArray, i: int = i) -> FloatArray:
                return np.asarray(profile.at(i, v).real)

            out[i] = component_density_in_space(in_space, near, one)
            continue

        def plane(v: FloatArray, i: int = i, one: float = one) -> FloatArray:
            # times the square of a typical speed, or it overflows late
            return np.asarray(profile.at(i, v).real * one * (one / v) / (2.0 * np.pi))

        out[i] = component_density(plane, near, one) / one / one
    if profile.peak_speed is not None and profile.peak_weight is not None:
        shape = _component_of_one_speed(x, profile.peak_speed, dimension)
        out += profile.peak_weight.real[:, None] * shape
    return out


def _component_of_one_speed(x: FloatArray, speed: float, dimension: int) -> FloatArray:
    """Density at |v_x| = x of velocities of one speed and any direction, in 1/U, shape of x."""
    if dimension == 3:
        return np.where(x < speed, 0.5 / speed, 0.0)
    room = speed**2 - np.minimum(x, 2.0 * speed) ** 2
    return np.where(room > 0.0, 1.0 / (np.pi * np.sqrt(np.where(room > 0, room, 1.0))), 0)
