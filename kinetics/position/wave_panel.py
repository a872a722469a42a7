"""F(k, t) on an interval of wave numbers, as a polynomial through Chebyshev points."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from kinetics.numerics import FloatArray
from kinetics.numerics.chebyshev import FirstKind
from kinetics.numerics.gauss import gauss_legendre
from kinetics.results import Value

Indices = NDArray[np.intp]


@dataclass(frozen=True)
class WavePanel(Value):
    """F of the collided on an interval of K = k l, at Chebyshev points of the first kind.

    Attributes
    ----------
    low, high : its ends
    which : indices of the times at which it is not negligible, rising, shape (n_which,)
    values : shape (n_which, nodes)
    """

    low: float
    high: float
    which: Indices
    values: FloatArray

    @property
    def nodes(self) -> FloatArray:
        """K at the points, shape (nodes,)."""
        return points_between(self.low, self.high, self.values.shape[1])

    def of(self, time: int) -> FloatArray | None:
        """F at the nodes at one of the times; None where it is negligible."""
        place = np.nonzero(self.which == time)[0]
        return None if place.size == 0 else np.asarray(self.values[place[0]])

    def without(self, time: int) -> WavePanel:
        """The same for the other times."""
        others = self.which != time
        return replace(self, which=self.which[others], values=self.values[others])

    def gauss(self, f: FloatArray, points: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Gauss nodes and weights in K, shape (points,) each, and the polynomial f there."""
        node, weight = gauss_legendre(points)
        width = self.high - self.low
        return self.low + width * node, width * weight, _rows_to_gauss(f.size, points) @ f

    def at_zero(self, f: FloatArray) -> float:
        """The polynomial f at K = 0, for a panel that begins there."""
        return float((FirstKind(f.size).rows(np.zeros(1)) @ f)[0])


def nodes_between(
    panels: list[WavePanel], time: int, low: float, high: float = math.inf
) -> tuple[FloatArray, FloatArray]:
    """K > low and F there, (n,) each, on those panels of a time that begin below ``high``."""
    k, f = [np.empty(0)], [np.empty(0)]
    for panel in panels:
        values = panel.of(time)
        if values is not None and panel.high > low and panel.low < high:
            k.append(panel.nodes)
            f.append(values)
    all_k, all_f = np.concatenate(k), np.concatenate(f)
    return all_k[all_k > low], all_f[all_k > low]


def points_between(low: float, high: float, nodes: int) -> FloatArray:
    """The Chebyshev points of the first kind in an interval, shape (nodes,)."""
    return low + (high - low) * FirstKind(nodes).local


@lru_cache(maxsize=64)  # panels and times have few different sizes
def _rows_to_gauss(nodes: int, points: int) -> FloatArray:
    """Interpolation from the Chebyshev to the Gauss points, shape (points, nodes)."""
    return FirstKind(nodes).rows(gauss_legendre(points)[0])
