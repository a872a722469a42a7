"""Masses at equidistant nodes of ln v, and the shares that a bounce between nodes is given in."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.numerics import FloatArray
from kinetics.results import Value
from kinetics.states.quadrature import LogMeasure, interpolate

# Of returns to the scatterer before: the deepest -ln s that is kept apart, and shares of bounces
# that are rounding.
_DEEPEST, _NO_SHARE = 40.0, 1e-17


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
        # by the root twice: 1/v alone may be larger than the largest number
        root = np.exp(-0.5 * log_v)
        out[positive] = interpolate(log_v, self.x, self.mass[i]) * root * root / self.spacing
        return out


def bounce_kernel(law: CollisionLaw, spacing: float, m: int) -> FloatArray:
    """Share of a node's bounces that arrive k nodes below, k = 0 ... K, times cos(m chi).

    In a medium that of its operator, in which shares may be negative.
    """
    q, low = law.cells(spacing)
    kernel = _shared(q.log_loss, low, q.weight * q.harmonic(m), spacing)
    eps, loss = law.returns(m)
    return _with_returns(kernel, spacing, eps, loss) if eps else kernel


def _shared(loss: FloatArray, low: Any, weight: FloatArray, spacing: float) -> FloatArray:
    """Weights of these losses -ln s on the nodes ``low`` above them, and low + 1 below."""
    # shares linear in v^2 between node low (upper speed) and low + 1 (lower speed)
    down = np.expm1(-2.0 * (loss - spacing * low)) / math.expm1(-2.0 * spacing)
    down = np.clip(down, 0.0, 1.0)
    kernel = np.zeros(int(low.max()) + 2)
    np.add.at(kernel, low, weight * (1.0 - down))
    np.add.at(kernel, low + 1, weight * down)
    return kernel


def _with_returns(kernel: FloatArray, spacing: float, eps: float, loss: float) -> FloatArray:
    """The kernel of 1 + (K - 1)/(1 - eps S (K - 1)) from that of K, S a loss of ``loss``.

    Quotients of power series, of which the symbols of mass and energy are those of the operator.
    """
    from scipy.signal import lfilter

    moved = kernel.copy()  # K - 1
    moved[0] -= 1.0
    low = np.array([int(loss / spacing)])
    back = _shared(np.array([loss]), low, np.ones(1), spacing)
    below = -eps * np.convolve(back, moved)
    below[0] += 1.0
    impulse = np.zeros(math.ceil(_DEEPEST / spacing) + kernel.size)
    impulse[0] = 1.0
    found = np.asarray(lfilter(moved, below, impulse))
    left = np.cumsum(np.abs(found[::-1]))[::-1]
    found = found[: max(kernel.size, int(np.count_nonzero(left > _NO_SHARE)))]
    # what is farther down comes to the last node: without it the sum is moved.sum()/below.sum()
    found[-1] += moved.sum() / below.sum() - found.sum()
    found[0] += 1.0
    return found


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
