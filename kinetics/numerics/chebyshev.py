"""Polynomials through Chebyshev points on [0, 1], and barycentric interpolation through any.

Source of the formulas: Berrut and Trefethen, SIAM Review 46, 501 (2004).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.numerics import FloatArray


def barycentric_weights(nodes: FloatArray) -> FloatArray:
    """Barycentric weights of a few nodes, wherever they are, shape (n_nodes,)."""
    difference = nodes[:, None] - nodes
    np.fill_diagonal(difference, 1.0)
    return np.asarray(1.0 / difference.prod(axis=1))


def interpolation_rows(difference: FloatArray, weights: FloatArray) -> FloatArray:
    """Rows that take values at any nodes to the values of their polynomial at some points.

    difference : point minus node, shape (..., n_nodes), exactly 0 where they coincide
    weights : barycentric weights of the nodes, shape (n_nodes,)
    """
    exact = difference == 0.0
    rows = weights / np.where(exact, 1.0, difference)
    rows /= rows.sum(axis=-1, keepdims=True)
    hit = exact.any(axis=-1)
    rows[hit] = exact[hit]
    return np.asarray(rows)


def derivative_matrix(nodes: FloatArray, weights: FloatArray) -> FloatArray:
    """d/dx of polynomials at the nodes, shape (n_nodes, n_nodes), from their weights."""
    difference = nodes[:, None] - nodes
    np.fill_diagonal(difference, 1.0)
    matrix = weights / weights[:, None] / difference
    np.fill_diagonal(matrix, 0.0)
    np.fill_diagonal(matrix, -matrix.sum(axis=1))
    return np.asarray(matrix)


@dataclass(frozen=True)
class Chebyshev:
    """The extrema of a Chebyshev polynomial: both ends of the interval are among them.

    ``nodes`` is their number, 3 at least.
    """

    nodes: int

    @cached_property
    def local(self) -> FloatArray:
        """The points on [0, 1], rising, shape (nodes,)."""
        return np.asarray(0.5 * (1.0 - np.cos(self._angle)))

    @property
    def _angle(self) -> FloatArray:
        return np.asarray(np.arange(self.nodes) * math.pi / (self.nodes - 1))

    @property
    def _halves(self) -> FloatArray:
        return np.where(np.isin(np.arange(self.nodes), (0, self.nodes - 1)), 0.5, 1.0)

    @cached_property
    def weights(self) -> FloatArray:
        """Barycentric weights, shape (nodes,)."""
        return (-1.0) ** np.arange(self.nodes) * self._halves

    @cached_property
    def _last_two(self) -> FloatArray:
        """Columns that give the last Chebyshev coefficient and the one before, (nodes, 2)."""
        last = self.nodes - 1
        cosines = np.cos(np.outer(self._angle, np.array([last, last - 1])))
        # the last coefficient has half the weight of the others
        return np.asarray(self._halves[:, None] * cosines * [1.0, 2.0] / last)

    def rows(self, local: FloatArray) -> FloatArray:
        """Interpolation from the points to local (n,) in [0, 1]: shape (n, nodes)."""
        return interpolation_rows(local[:, None] - self.local, self.weights)

    def last_coefficients(self, values: NDArray[Any]) -> tuple[FloatArray, FloatArray]:
        """Sizes of the last Chebyshev coefficient and of the one before it.

        values : at the points, shape (..., nodes); the results have the shape (...).
        """
        return np.abs(values @ self._last_two[:, 0]), np.abs(values @ self._last_two[:, 1])

    @cached_property
    def slopes(self) -> FloatArray:
        """Derivative on [0, 1] at the points, shape (nodes, nodes)."""
        return derivative_matrix(self.local, self.weights)
