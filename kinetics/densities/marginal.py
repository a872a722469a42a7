"""One Cartesian component of an isotropic velocity: the marginal F(c_x) of the paper's scalev.

In the plane it is an integral of f(|v|) over the other component, in space one over the speed: on a
sphere of radius v one component is uniform from -v to v.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from kinetics.densities.harmonic import Profile
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import panels_between

# Gauss panels in ln of the other component, in units of a typical speed. Below e^-20 of it, where
# the density is constant, the other component is taken in one piece; above e^4.5 = 90 of it nothing
# is left of an exponential tail. The error is 1e-8 of the maximum for smooth densities.
_LOWEST, _HIGHEST, _PANEL, _POINTS = -20.0, 4.5, 0.5, 10
_FASTEST = 1e100  # in typical speeds: no tracer is as fast


def component_densities(
    profile: Profile, x: FloatArray, unit: FloatArray, dimension: int
) -> FloatArray:
    """Density of one velocity component at |v_x| = x (n,) in U, shape (n_times, n), in 1/U.

    profile : harmonic 0 of the velocity density
    unit : speeds of the order of the thermal one, shape (n_times,)
    """
    # with v^2 = x^2 + w^2, of the density g of the speed: g/(pi v) dw, in space g w/(2 v^2) dw
    y, weight = panels_between(np.arange(_LOWEST, _HIGHEST + 0.5 * _PANEL, _PANEL), _POINTS)
    out = np.empty((unit.size, x.size))
    for i, one in enumerate(unit.tolist()):
        other = one * np.exp(y)
        speed = np.hypot(np.minimum(x, _FASTEST * one)[:, None], other)
        g = profile.at(i, speed.ravel()).real.reshape(speed.shape)
        if dimension == 3:
            out[i] = (g * (0.5 * (other / speed) ** 2)) @ weight
            continue
        g = g * (other / speed) / np.pi
        # below the first panel the density is that of its first point
        out[i] = g @ weight + g[:, 0] * math.exp(_LOWEST) * one / other[0]
    if profile.peak_speed is not None and profile.peak_weight is not None:
        shape = _component_of_one_speed(x, profile.peak_speed, dimension)
        out += profile.peak_weight.real[:, None] * shape
    return out


def _component_of_one_speed(x: FloatArray, speed: float, dimension: int) -> NDArray[np.float64]:
    """Density at |v_x| = x of velocities of one speed and any direction, in 1/U, shape of x."""
    if dimension == 3:
        return np.where(x < speed, 0.5 / speed, 0.0)
    room = speed**2 - np.minimum(x, 2.0 * speed) ** 2
    return np.where(room > 0.0, 1.0 / (np.pi * np.sqrt(np.where(room > 0, room, 1.0))), 0)
