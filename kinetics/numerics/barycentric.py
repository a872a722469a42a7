"""Barycentric interpolation by polynomials (Berrut, Trefethen, SIAM Review 46, 501 (2004))."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def interpolation_rows(difference: FloatArray, weights: FloatArray) -> FloatArray:
    """Rows that take values at the nodes to values at the points.

    difference : point minus node, shape (n_points, n_nodes), exactly 0 where they coincide
    weights : barycentric weights of the nodes, shape (n_nodes,)
    """
    exact = difference == 0.0
    rows = weights / np.where(exact, 1.0, difference)
    rows /= rows.sum(axis=1, keepdims=True)
    hit = exact.any(axis=1)
    rows[hit] = exact[hit]
    return np.asarray(rows)
