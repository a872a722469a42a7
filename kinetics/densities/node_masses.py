"""Masses at equidistant nodes of ln v, and the shares that a bounce between nodes is given in."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.numerics import FloatArray
from kinetics.states.quadrature import LogMeasure, interpolate
from kinetics.values import Value


@dataclass(frozen=True)
class NodeMasses(Value):
    """Masses at nodes in ln v: the density of ln v is linear between them.

    Attributes
    ----------
    x : ln v at the nodes, equidistant, shape (n_nodes,)
    spacing : of the nodes
    mass : shape (n_times, n_nodes)
    """

    x: FloatArray
    spacing: float
    mass: NDArray[Any]

    def at(self, i: int, v: FloatArray) -> NDArray[Any]:
        """In 1/U at the i-th time and speeds v in U, shape (n_v,)."""
        out = np.zeros(v.shape, dtype=self.mass.dtype)
        positive = v > 0.0
        log_v = np.log(v[positive])
        out[positive] = interpolate(log_v, self.x, self.mass[i]) * np.exp(-log_v) / self.spacing
        return out


def bounce_kernel(law: CollisionLaw, spacing: float, m: int) -> FloatArray:
    """Share of a node's bounces that arrive k nodes below, k = 0 ... K, times cos(m chi)."""
    q, low = law.cells(spacing)
    # shares linear in v^2 between node low (upper speed) and low + 1 (lower speed)
    down = np.expm1(-2.0 * (q.log_loss - spacing * low)) / math.expm1(-2.0 * spacing)
    down = np.clip(down, 0.0, 1.0)
    weight = q.weight * q.harmonic(m)
    kernel = np.zeros(int(low.max()) + 2)
    np.add.at(kernel, low, weight * (1.0 - down))
    np.add.at(kernel, low + 1, weight * down)
    return kernel


def deposit(start: LogMeasure, x0: float, spacing: float, nodes: int) -> NDArray[Any]:
    """Masses of weighted points on the nodes, mass and energy kept."""
    mass = np.zeros(nodes, dtype=start.weight.dtype)
    level = (start.x - x0) / spacing
    low = np.clip(np.floor(level).astype(int), 0, nodes - 2)
    part = np.clip(level - low, 0.0, 1.0)
    up = np.expm1(2.0 * spacing * part) / math.expm1(2.0 * spacing)
    np.add.at(mass, low, start.weight * (1.0 - up))
    np.add.at(mass, low + 1, start.weight * up)
    return mass
