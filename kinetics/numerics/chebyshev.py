"""Polynomials through Chebyshev points on [0, 1] and on panels, and barycentric interpolation.

Source of the formulas: Berrut and Trefethen, SIAM Review 46, 501 (2004). Begin with `Chebyshev`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from kinetics.numerics import FloatArray, NumberArray

#: Added to distances from nodes, in place of 0. Chosen: the reciprocal is finite, and outweighs all
#: others.
LEAST_DISTANCE = 1e-290


def barycentric_weights(nodes: FloatArray) -> FloatArray:
    """Return barycentric weights of a few nodes, wherever they are, shape (n_nodes,)."""
    difference = nodes[:, None] - nodes
    np.fill_diagonal(difference, 1.0)
    return np.asarray(1.0 / difference.prod(axis=1))


def interpolation_rows(difference: FloatArray, weights: FloatArray) -> FloatArray:
    """Return rows that take values at nodes to the values of their polynomial at some points.

    Parameters
    ----------
    difference : point minus node, shape (..., n_nodes), exactly 0 where they coincide
    weights : barycentric weights of the nodes, shape (n_nodes,)

    Returns
    -------
    One row for each point, shape (..., n_nodes).
    """
    coincides = difference == 0.0
    rows = weights / np.where(coincides, 1.0, difference)
    rows /= rows.sum(axis=-1, keepdims=True)
    is_node = coincides.any(axis=-1)
    rows[is_node] = coincides[is_node]
    return np.asarray(rows)


def derivative_matrix(nodes: FloatArray, weights: FloatArray) -> FloatArray:
    """Return d/dx of polynomials at the nodes, shape (n_nodes, n_nodes), from their weights."""
    difference = nodes[:, None] - nodes
    np.fill_diagonal(difference, 1.0)
    matrix = weights / weights[:, None] / difference
    np.fill_diagonal(matrix, 0.0)
    np.fill_diagonal(matrix, -matrix.sum(axis=1))
    return np.asarray(matrix)


@dataclass(frozen=True)
class Chebyshev:
    """Extrema of a Chebyshev polynomial: on one interval, or on each of many equal panels.

    Parameters
    ----------
    nodes : their number, 3 at least; both ends are among them
    width : of a panel in x
    """

    nodes: int
    width: float = 1.0

    @cached_property
    def local(self) -> FloatArray:
        """The points in panels, from 0 to 1, rising, shape (nodes,)."""
        return np.asarray(0.5 * (1.0 - np.cos(self._angles)))

    @cached_property
    def weights(self) -> FloatArray:
        """Their barycentric weights, shape (nodes,)."""
        return np.asarray((-1.0) ** np.arange(self.nodes) * self._end_factors)

    @cached_property
    def last_two(self) -> FloatArray:
        """Columns that give the last Chebyshev coefficient and the one before, (nodes, 2)."""
        degree = self.nodes - 1
        cosines = np.cos(np.outer(self._angles, np.array([degree, degree - 1])))
        # the last coefficient has half the weight of the others
        return np.asarray(self._end_factors[:, None] * cosines * [1.0, 2.0] / degree)

    @property
    def _angles(self) -> FloatArray:
        """Angles on the half circle over the points, (nodes,)."""
        return np.linspace(0.0, math.pi, self.nodes)

    @property
    def _end_factors(self) -> FloatArray:
        """1, but 1/2 at both ends, (nodes,)."""
        factors = np.ones(self.nodes)
        factors[[0, -1]] = 0.5
        return factors

    def rows(self, local: FloatArray) -> FloatArray:
        """Return rows that interpolate from the points to local (n,), in panels: (n, nodes)."""
        return interpolation_rows(local[:, None] - self.local, self.weights)

    def shares(self, local: FloatArray) -> FloatArray:
        """Return `rows` before each row is divided by its sum."""
        distance = local[:, None] - self.local
        distance += LEAST_DISTANCE
        return np.asarray(np.divide(self.weights, distance, out=distance))

    def last_coefficients(self, values: NumberArray) -> FloatArray:
        """Return sizes of the last Chebyshev coefficient and of the one before, (2, ...).

        The values have the shape (..., nodes).
        """
        return np.moveaxis(np.abs(values @ self.last_two), -1, 0)

    @cached_property
    def derivative(self) -> FloatArray:
        """d/dx at the points, shape (nodes, nodes)."""
        return derivative_matrix(self.local, self.weights) / self.width


@lru_cache(maxsize=64)
def chebyshev_panels(nodes: int, width: float = 1.0) -> Chebyshev:
    """Return the same rule again, so that its matrices are made once."""
    return Chebyshev(nodes, width)
