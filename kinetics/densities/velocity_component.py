"""The density of one Cartesian component of the velocity, from the density g of the speed.

v is the speed, v_x the component, and w the rest of the velocity: v^2 = v_x^2 + w^2. The density of
v_x is the integral of g/(pi v) over w > 0 in the plane, and of g w/(2 v^2) in space, where all v_x
between -v and v are equally likely. Begin with :func:`component_densities`.
"""

from __future__ import annotations

import math

import numpy as np

from kinetics.densities.harmonic import Profile
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import panels_between

#: Edges of the panels in ln of w, in units of a typical speed, from e^-20, below which the density
#: does not depend on w, to e^4.5 = 90. Origin not recorded. With `PANEL_POINTS` the error is 1e-8
#: for smooth densities.
LOG_EDGES = np.arange(-20.0, 4.75, 0.5)
#: Gauss points of a panel. Origin not recorded. With 5 smooth densities move by 1e-5 of their
#: largest, with 20 by 2e-10 (e = 0.4 and 0.95).
PANEL_POINTS = 10
#: Largest |v_x| that is distinguished, in typical speeds. Chosen: the square of larger ones
#: overflows.
MAX_COMPONENT = 1e100
#: Stands for 0 in a denominator that is not used: close to the smallest number.
TINY = 1e-300


def component_densities(
    profile: Profile, x: FloatArray, typical_speed: FloatArray, dimension: int
) -> FloatArray:
    """Return the density of one velocity component, by an integral over the other ones.

    Parameters
    ----------
    profile : harmonic 0 of the velocity density
    x : |v_x| in U, shape (n,)
    typical_speed : speeds of the order of the thermal one in U, shape (n_times,)
    dimension : 2 or 3

    Returns
    -------
    The density in 1/U, shape (n_times, n).
    """
    log_w, weight = panels_between(LOG_EDGES, PANEL_POINTS)
    densities = np.empty((typical_speed.size, x.size))
    for i, unit in enumerate(typical_speed.tolist()):
        w = unit * np.exp(log_w)
        speed = np.hypot(np.minimum(x, MAX_COMPONENT * unit)[:, None], w)
        g = profile.at(i, speed.ravel()).real.reshape(speed.shape)
        # dw = w d(ln w), to which the weights belong
        if dimension == 3:
            densities[i] = (g * (0.5 * (w / speed) ** 2)) @ weight
        else:
            integrand = g * (w / speed) / np.pi
            below_first_panel = integrand[:, 0] * math.exp(LOG_EDGES[0]) * unit / w[0]
            densities[i] = integrand @ weight + below_first_panel
    if profile.peak_speed is not None and profile.peak_weight is not None:
        density_of_peak = _component_density_of_one_speed(x, profile.peak_speed, dimension)
        densities += profile.peak_weight.real[:, None] * density_of_peak
    return densities


def _component_density_of_one_speed(x: FloatArray, speed: float, dimension: int) -> FloatArray:
    """Return the density of v_x at |v_x| = x for one speed and any direction, shape of x."""
    if dimension == 3:
        return np.where(x < speed, 0.5 / speed, 0.0)
    w_squared = speed**2 - np.minimum(x, 2.0 * speed) ** 2
    density = 1.0 / (np.pi * np.sqrt(np.maximum(w_squared, TINY)))
    return np.where(w_squared > 0.0, density, 0.0)
