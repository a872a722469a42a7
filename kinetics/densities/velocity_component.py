"""The density of one Cartesian component of the velocity, from the density g of the speed.

v is the speed, v_x the component, and w the rest of the velocity: v^2 = v_x^2 + w^2. The density of
v_x is the integral of g/(pi v) over w > 0 in the plane, and of g w/(2 v^2) in space, where all v_x
between -v and v are equally likely. Where g does not vanish at rest, as at e = 0 in the plane, it
grows towards v_x = 0 as a logarithm, and is infinite there. Begin with :func:`component_densities`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from kinetics.densities.harmonic import Profile
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import panels_between

#: Edges of the panels in ln of w, in units of a typical speed, from e^-20, below which the density
#: does not depend on w, to e^4.5 = 90. Chosen: with `PANEL_POINTS` the error is 1e-8
#: for smooth densities.
LOG_EDGES = np.arange(-20.0, 4.75, 0.5)
#: Width of these panels in ln w.
PANEL_WIDTH = 0.5
#: Largest |v_x|, in typical speeds, for which panels of its own begin at e^-20 of it: next to rest
#: the density may depend on w below e^-20 of a typical speed. Derived: above, that changes the
#: density by less than e^-18, 2e-8.
OWN_PANELS_BELOW = math.exp(-9.0)
#: How much two values of g at rest, e^20 apart, may differ if g does not vanish there. Chosen: a
#: smooth g that does vanishes as v, that is by e^-20 in between.
CONSTANT_WITHIN = 0.1
#: Gauss points of a panel. Chosen: with 5 smooth densities move by 1e-5 of their
#: largest, with 20 by 2e-10 (e = 0.4 and 0.95).
PANEL_POINTS = 10
#: Largest |v_x| that is distinguished, in typical speeds. Chosen: the square of larger ones
#: overflows.
MAX_COMPONENT = 1e100
#: Stands for 0 in a denominator that is not used: close to the smallest number.
TINY = 1e-300


@dataclass(frozen=True)
class _SpeedDensityAt:
    """The density g of the speed at one time: a function of speeds in U, in 1/U.

    Parameters
    ----------
    profile : harmonic 0 of the velocity density
    i : index of the time
    """

    profile: Profile
    i: int

    def __call__(self, v: FloatArray) -> FloatArray:
        """Return g at speeds v, shape (n,), without delta peaks."""
        return self.profile.at(self.i, v).real


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
    The density in 1/U, shape (n_times, n); infinite at x = 0 where g does not vanish at rest.
    """
    densities = np.empty((typical_speed.size, x.size))
    for i, unit in enumerate(typical_speed.tolist()):
        g = _SpeedDensityAt(profile, i)
        densities[i] = _smooth_density(g, x, unit, LOG_EDGES, dimension)
        for j in np.flatnonzero((x > 0.0) & (x < OWN_PANELS_BELOW * unit)):
            densities[i, j] = _density_next_to_rest(g, float(x[j]), unit, dimension)
        if np.any(x == 0.0) and not _vanishes_at_rest(g, unit):
            densities[i, x == 0.0] = math.inf
    if profile.peak_speed is not None and profile.peak_weight is not None:
        density_of_peak = _component_density_of_one_speed(x, profile.peak_speed, dimension)
        densities += profile.peak_weight.real[:, None] * density_of_peak
    return densities


def _smooth_density(
    g: _SpeedDensityAt, x: FloatArray, unit: float, log_edges: FloatArray, dimension: int
) -> FloatArray:
    """Return the density of v_x at |v_x| = x in 1/U, without delta peaks, shape of x.

    Parameters
    ----------
    g : the density of the speed
    x : in U, shape (n,)
    unit : a speed of the order of the thermal one in U
    log_edges : of the panels in ln(w/unit)
    dimension : 2 or 3
    """
    log_w, weight = panels_between(log_edges, PANEL_POINTS)
    w = unit * np.exp(log_w)
    speed = np.hypot(np.minimum(x, MAX_COMPONENT * unit)[:, None], w)
    g_at_points = g(speed.ravel()).reshape(speed.shape)
    # dw = w d(ln w), to which the weights belong
    if dimension == 3:
        return np.asarray((g_at_points * (0.5 * (w / speed) ** 2)) @ weight)
    integrand = g_at_points * (w / speed) / np.pi
    below_first_panel = integrand[:, 0] * math.exp(log_edges[0]) * unit / w[0]
    return np.asarray(integrand @ weight + below_first_panel)


def _density_next_to_rest(g: _SpeedDensityAt, x: float, unit: float, dimension: int) -> float:
    """Return the density of v_x at one |v_x| = x far below a typical speed, above 0, in 1/U.

    The arguments are those of `_smooth_density`.
    """
    lowest = math.log(x) - math.log(unit) + LOG_EDGES[0]
    n_panels = math.ceil((LOG_EDGES[-1] - lowest) / PANEL_WIDTH)
    log_edges = LOG_EDGES[-1] + PANEL_WIDTH * np.arange(-float(n_panels), 1.0)
    return float(_smooth_density(g, np.array([x]), unit, log_edges, dimension)[0])


def _vanishes_at_rest(g: _SpeedDensityAt, unit: float) -> bool:
    """Return whether g goes to 0 at rest; unit is a speed of the order of the thermal one in U."""
    slow, slower = g(unit * np.exp(LOG_EDGES[0] * np.array([1.0, 2.0])))
    return not (slower > 0.0 and abs(slow - slower) < CONSTANT_WITHIN * slower)


def _component_density_of_one_speed(x: FloatArray, speed: float, dimension: int) -> FloatArray:
    """Return the density of v_x at |v_x| = x for one speed and any direction, shape of x."""
    if dimension == 3:
        return np.where(x < speed, 0.5 / speed, 0.0)
    w_squared = speed**2 - np.minimum(x, 2.0 * speed) ** 2
    density = 1.0 / (np.pi * np.sqrt(np.maximum(w_squared, TINY)))
    return np.where(w_squared > 0.0, density, 0.0)
