"""The speed axis of a field: Gauss-Legendre nodes on panels, joined by one-sided values.

Functions are polynomials on each panel, and need not be continuous. Tracers gain and lose speed, so
a panel needs values from both neighbours: the derivative of an even harmonic, which acts on odd
ones, takes that at its upper end from the panel above; that of an odd one takes that at the lower
end from the panel below. At rest nothing is imposed. Integrals by parts with the volume v^(d-1) dv
hold exactly for the sums over the nodes: without collisions the integral of the square of a
function is conserved, as it is for tracers that fall freely, and no error grows over time.

`SpeedPanels` implements `kinetics.driven.axis.VelocityAxis`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.polynomial.chebyshev import chebder, chebvander
from numpy.typing import NDArray

from kinetics.driven.resolution import MIN_PANEL_NODES
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import gauss_legendre, panels_between

#: Largest ratio of the ends of a panel. Measured in a field over time: with 2 the time is twice as
#: long, with 6 it is half as long again, and densities move by 6e-6 of their maximum.
MAX_END_RATIO = 3.0


@dataclass(frozen=True)
class SpeedPanels:
    """Panels from rest to the largest speed.

    Parameters
    ----------
    edges : ends of the panels, rising from 0, n_panels + 1 of them
    counts : nodes of each panel, n_panels of them
    """

    edges: tuple[float, ...]
    counts: tuple[int, ...]

    @classmethod
    def rising(cls, highest: float, lowest: float, nodes: int, tail: bool = False) -> SpeedPanels:
        """Return panels up to a speed, the first one to ``lowest`` if that is below it.

        Above the speed 1 each has ``nodes`` nodes, and fewer below, where averages vary less.

        tail : whether the last one is cut in two, so that the density is resolved that falls there
        """
        lowest = min(lowest, highest / MAX_END_RATIO)
        count = math.ceil(math.log(highest / lowest) / math.log(MAX_END_RATIO))
        edges = np.geomspace(lowest, highest, count + 1).tolist()
        fewest = max(MIN_PANEL_NODES, nodes // 2)
        rising_count = max(1, math.ceil(-math.log(lowest) / math.log(MAX_END_RATIO)))
        share = np.minimum(1.0, np.arange(1, count + 1) / rising_count)
        counts = np.ceil(fewest + (nodes - fewest) * share).astype(int).tolist()
        if tail:
            edges.insert(-1, 0.5 * (edges[-2] + highest))
            counts.append(nodes)
        return cls((0.0, *edges), (fewest, *counts))

    @property
    def below_last_panel(self) -> SpeedPanels:
        """The same without the highest panel."""
        return SpeedPanels(self.edges[:-1], self.counts[:-1])

    @cached_property
    def parts(self) -> list[slice]:
        """Where the nodes of each panel are."""
        ends = np.cumsum([0, *self.counts]).tolist()
        return [slice(begin, end) for begin, end in pairwise(ends)]

    @property
    def size(self) -> int:
        """The number of nodes."""
        return sum(self.counts)

    @property
    def highest(self) -> float:
        """The largest speed."""
        return self.edges[-1]

    @cached_property
    def speeds(self) -> FloatArray:
        """The nodes, shape (size,)."""
        panels = zip(self.edges[:-1], self.edges[1:], self.counts, strict=True)
        nodes = [low + (high - low) * gauss_legendre(count)[0] for low, high, count in panels]
        return np.concatenate(nodes)

    @cached_property
    def weights(self) -> FloatArray:
        """The weights of the integral over the speed, shape (size,)."""
        panels = zip(self.edges[:-1], self.edges[1:], self.counts, strict=True)
        return np.concatenate([(high - low) * gauss_legendre(n)[1] for low, high, n in panels])

    def volumes(self, dimension: int) -> FloatArray:
        """Return by what f at a node is a sum, whose total is the integral of f over v, (size,)."""
        return np.asarray(self.speeds ** (dimension - 1.0) * self.weights)

    def panel_of(self, v: FloatArray) -> NDArray[np.intp]:
        """Return the panel in which each speed lies; the last one above all, shape of v."""
        return np.clip(np.searchsorted(self.edges, v, side="left") - 1, 0, len(self.counts) - 1)

    def polynomials(self, panel: int, v: FloatArray) -> FloatArray:
        """Return Chebyshev polynomials of a panel at speeds in it, (*v.shape, nodes)."""
        low = self.edges[panel]
        high = self.edges[panel + 1]
        return np.asarray(chebvander(2.0 * (v - low) / (high - low) - 1.0, self.counts[panel] - 1))

    @cached_property
    def to_coefficients(self) -> list[FloatArray]:
        """Matrices from values at the nodes of a panel to coefficients, (nodes, nodes) each."""
        matrices = []
        for panel, part in enumerate(self.parts):
            at_nodes = self.polynomials(panel, self.speeds[part])
            matrices.append(np.asarray(np.linalg.inv(at_nodes), dtype=float))
        return matrices

    def rows(self, panel: int, v: FloatArray) -> FloatArray:
        """Return the interpolation in a panel to speeds in it, (*v.shape, nodes)."""
        return self.polynomials(panel, v) @ self.to_coefficients[panel]

    def derivative(self, panel: int) -> FloatArray:
        """Return d/dv of polynomials at the nodes of a panel, shape (nodes, nodes)."""
        length = self.edges[panel + 1] - self.edges[panel]
        values = self.polynomials(panel, self.speeds[self.parts[panel]])[:, :-1]
        return values @ chebder(self.to_coefficients[panel], scl=2.0 / length)

    def interpolation(self, v: FloatArray, parity: int = 0) -> FloatArray:
        """Return the rows that take values at the nodes to those at speeds v (n,), (n, size).

        parity : makes no difference, as all functions are polynomials
        """
        rows = np.zeros((v.size, self.size))
        panel_of_speed = self.panel_of(v)
        for panel in np.unique(panel_of_speed):
            inside = np.nonzero(panel_of_speed == panel)[0]
            rows[inside, self.parts[panel]] = self.rows(panel, v[inside])
        return rows

    def averaged(
        self, density: Callable[[FloatArray], NDArray[Any]], parity: int, kinks: FloatArray
    ) -> NDArray[Any]:
        """Return averages of the polynomial of each node over a density of the speed, (size,)."""
        edges = np.union1d(self.edges, kinks)
        v, weight = panels_between(edges[edges <= self.highest], max(self.counts) + 2)
        return np.asarray((weight * density(v)) @ self.interpolation(v, parity))

    def slopes(self, dimension: int) -> tuple[FloatArray, FloatArray]:
        """Return d/dv of even and of odd harmonics, from sums to sums, shape (size, size) each.

        Both are 0 beyond the highest speed.

        Source: the strong form of the discontinuous Galerkin method; Hesthaven and Warburton,
        Nodal Discontinuous Galerkin Methods, section 3.2.
        """
        volumes = self.volumes(dimension)
        even = self._slope(dimension, is_even=True) * (volumes[:, None] / volumes)
        odd = self._slope(dimension, is_even=False) * (volumes[:, None] / volumes)
        return even, odd

    def _slope(self, dimension: int, is_even: bool) -> FloatArray:
        """Return d/dv of even or odd harmonics, from values to values, (size, size)."""
        slope = np.zeros((self.size, self.size))
        last = len(self.counts) - 1
        for panel, part in enumerate(self.parts):
            slope[part, part] = self.derivative(panel)
            if is_even or panel == last:
                self._join(slope, panel, panel + 1, dimension)
            if not is_even and panel > 0:
                self._join(slope, panel, panel - 1, dimension)
        return slope

    def _join(self, slope: FloatArray, panel: int, neighbour: int, dimension: int) -> None:
        """Add to d/dv in a panel what it takes from a neighbour; 0 beyond the highest speed."""
        sign = neighbour - panel
        end = self.edges[max(panel, neighbour)]
        part = self.parts[panel]
        own = self.rows(panel, np.array([end]))[0]
        jump = sign * own * (end / self.speeds[part]) ** (dimension - 1) / self.weights[part]
        slope[part, part] -= np.outer(jump, own)
        if neighbour < len(self.counts):
            row = self.rows(neighbour, np.array([end]))
            slope[part, self.parts[neighbour]] += np.outer(jump, row)
