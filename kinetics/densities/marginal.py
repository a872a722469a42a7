"""One Cartesian component of an isotropic velocity: the marginal F(c_x) of the paper's scalev."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.numerics.gauss import panels_between

FloatArray = NDArray[np.float64]

# Panels in ln of the other component, in units of a typical speed: below e^-18 it adds 1e-8 of
# the sum relative to the density there, quadratically less where the density is flat.
_LOWEST, _HIGHEST, _PANEL, _POINTS = -20.0, 4.5, 0.5, 10


def component_density(
    plane_density: Callable[[FloatArray], NDArray[Any]], component: FloatArray, typical: float
) -> NDArray[Any]:
    """Integral over v_y of a density f(|v|) in the plane, at v_x = component (n,).

    plane_density : |v| (k,) -> (..., k); the answer has shape (..., n).
    """
    edges = np.arange(_LOWEST, _HIGHEST + 0.5 * _PANEL, _PANEL)
    y, w = panels_between(edges, _POINTS)
    other = typical * np.exp(y)
    speed = np.hypot(component[:, None], other)
    values = plane_density(speed.ravel())
    values = values.reshape(*values.shape[:-1], component.size, other.size)
    # twice: both signs of v_y; the part below the first panel has constant density
    inner = math.exp(_LOWEST) * typical * values[..., 0]
    return np.asarray(2.0 * (values @ (w * other) + inner))
