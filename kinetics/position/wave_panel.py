"""F(k, t) on an interval of wave numbers, as a polynomial through Chebyshev points."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.numerics.barycentric import interpolation_rows
from kinetics.numerics.gauss import gauss_legendre

FloatArray = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass(frozen=True)
class WavePanel:
    """F of the collided on an interval of K = k l, at Chebyshev points.

    Attributes
    ----------
    low, high : its ends
    which : indices of the times at which it is not negligible, shape (n_which,)
    values : shape (n_which, nodes)
    """

    low: float
    high: float
    which: Indices
    values: FloatArray

    @property
    def nodes(self) -> FloatArray:
        """K at the points, shape (nodes,)."""
        local, _ = chebyshev_points(self.values.shape[1])
        return self.low + (self.high - self.low) * local

    def of(self, time: int) -> FloatArray | None:
        """F at the nodes at one of the times; None where it is negligible."""
        place = np.nonzero(self.which == time)[0]
        return None if place.size == 0 else np.asarray(self.values[place[0]])

    def gauss(self, f: FloatArray, points: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Gauss nodes and weights in K, and F there."""
        node, weight = gauss_legendre(points)
        local, barycentric = chebyshev_points(f.size)
        rows = interpolation_rows(node[:, None] - local, barycentric)
        width = self.high - self.low
        return self.low + width * node, width * weight, rows @ f


def chebyshev_points(nodes: int) -> tuple[FloatArray, FloatArray]:
    """Chebyshev points of the first kind on [0, 1], rising, and their barycentric weights."""
    angle = (np.arange(nodes)[::-1] + 0.5) * math.pi / nodes
    weights = np.asarray((-1.0) ** np.arange(nodes) * np.sin(angle), dtype=float)
    return np.asarray(0.5 * (1.0 + np.cos(angle))), weights


def last_coefficients(values: NDArray[Any]) -> float:
    """Size of the last two Chebyshev coefficients of values at those points, (n, nodes)."""
    nodes = values.shape[1]
    angle = (np.arange(nodes)[::-1] + 0.5) * math.pi / nodes
    order = np.array([nodes - 2, nodes - 1])
    coefficients = values @ np.cos(np.outer(angle, order)) * (2.0 / nodes)
    return float(np.abs(coefficients).max())
