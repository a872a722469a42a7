"""Tracers as masses at equidistant nodes of x = ln v, and how points are shared between nodes.

v is the speed in U, and a mass a share of all tracers (of a harmonic m > 0 its weight, see
:class:`kinetics.states.state.LogMeasure`). A point at v between two nodes gives each such a share
of its mass that mass and energy, the mean of v^2, stay as they are. Begin with :class:`NodeMasses`;
:func:`deposit` makes them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from kinetics.densities.harmonic import HarmonicArray
from kinetics.numerics import FloatArray
from kinetics.results.value import Value
from kinetics.states.state import LogMeasure


@dataclass(frozen=True, eq=False, repr=False)
class NodeMasses(Value):
    """Masses at nodes of ln v at the output times; the density of ln v is linear between them.

    Parameters
    ----------
    x : ln v at the nodes, v in U, equidistant and rising, shape (n_nodes,)
    spacing : distance of the nodes in ln v
    mass : share of all tracers at each node, shape (n_times, n_nodes)
    uncollided : what of ``mass`` belongs to tracers of several sharp speeds that have not collided,
        same shape; None for other starts (of one sharp speed these are not in ``mass``)
    """

    x: FloatArray
    spacing: float
    mass: HarmonicArray
    uncollided: HarmonicArray | None = None

    def at(self, i: int, v: FloatArray) -> HarmonicArray:
        """Evaluate f_m in 1/U at the i-th time and speeds v in U, shape (n_v,)."""
        density = np.zeros(v.shape, dtype=self.mass.dtype)
        is_moving = v > 0.0
        log_v = np.log(v[is_moving])
        # by the root twice: 1/v alone may be larger than the largest number
        inverse_root = np.exp(-0.5 * log_v)
        density[is_moving] = self.per_log_speed(i, log_v) * inverse_root * inverse_root
        return density

    def per_log_speed(self, i: int, x: FloatArray) -> HarmonicArray:
        """Evaluate the density of ln v at the i-th time and ln v = x, shape of x (n,)."""
        return np.interp(x, self.x, self.mass[i], left=0.0, right=0.0) / self.spacing


def deposit(points: LogMeasure, x: FloatArray, spacing: float) -> HarmonicArray:
    """Share weighted points between the nodes around them, so that mass and energy are kept.

    Parameters
    ----------
    points : weights at values of ln v; those beyond the nodes go to the last node on that side
    x : nodes of ln v, equidistant and rising, shape (n_nodes,)
    spacing : distance of the nodes

    Returns
    -------
    The masses of the nodes, shape (n_nodes,).
    """
    mass = np.zeros(x.size, dtype=points.weight.dtype)
    level = (points.x - x[0]) / spacing
    lower_node = np.clip(np.floor(level).astype(int), 0, x.size - 2)
    fraction = np.clip(level - lower_node, 0.0, 1.0)
    # linear in v^2 between the nodes
    upper_share = np.expm1(2.0 * spacing * fraction) / math.expm1(2.0 * spacing)
    np.add.at(mass, lower_node, points.weight * (1.0 - upper_share))
    np.add.at(mass, lower_node + 1, points.weight * upper_share)
    return mass
