"""Gauss-Legendre quadrature on one interval, on equal panels, and on panels of any length."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from kinetics.numerics import FloatArray


@lru_cache(maxsize=64)
def gauss_legendre(points: int) -> tuple[FloatArray, FloatArray]:
    """Return nodes and weights on [0, 1], shape (points,) each."""
    x, w = np.polynomial.legendre.leggauss(points)
    return 0.5 * (x + 1.0), 0.5 * w


def equal_panels(length: float, points: int, longest: float = 1.0) -> tuple[FloatArray, FloatArray]:
    """Return nodes and weights on [0, length], in equal panels no longer than ``longest``.

    Shape (n_panels * points,) each.
    """
    n_panels = max(1, math.ceil(length / longest))
    return panels_between(np.linspace(0.0, length, n_panels + 1), points)


def panels_between(edges: FloatArray, points: int) -> tuple[FloatArray, FloatArray]:
    """Return nodes and weights on each interval between neighbouring edges.

    Shape ((edges.size - 1) * points,) each.
    """
    x, w = panels_of(np.stack([edges[:-1], edges[1:]], axis=1), points)
    return x.ravel(), w.ravel()


def panels_of(ends: FloatArray, points: int) -> tuple[FloatArray, FloatArray]:
    """Return nodes and weights on intervals ``ends``, shape (n, 2): two arrays (n, points)."""
    node, weight = gauss_legendre(points)
    width = (ends[:, 1] - ends[:, 0])[:, None]
    return ends[:, :1] + width * node, width * weight
