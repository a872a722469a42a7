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

from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import panels_between

# Gauss panels in ln of the other component, in units of a typical speed. Below e^-20 of it, where
# the density is constant, the other component is taken in one piece; above e^4.5 = 90 of it nothing
# is left of an exponential tail. tests/kinetics/measurements/densities.py measures the error.
_LOWEST, _HIGHEST, _PANEL, _POINTS = -20.0, 4.5, 0.5, 10


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
