"""The speed axis: Gauss-Legendre nodes on panels of any length, joined by one-sided values.

Functions are polynomials on each panel, and need not be continuous from one to the next. The field
makes a derivative of even harmonics act on odd ones, and the reverse. As tracers gain and lose
speed, each panel needs values from both neighbours: the derivative of an even harmonic takes the
value at the upper end of a panel from the panel above, that of an odd harmonic the value at the
lower end from the panel below. Polynomials alone are regular at rest, where nothing is imposed.

Integrals by parts with the volume v^(d-1) dv hold exactly for the sums over the nodes. Without
collisions the integral of the square of a function is then conserved, as it is for tracers that
fall freely, and no error grows over time.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from kinetics.numerics import FloatArray
from kinetics.numerics.chebyshev import barycentric_weights, interpolation_rows
from kinetics.numerics.gauss import gauss_legendre


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

    @cached_property
    def parts(self) -> list[slice]:
        """Where the nodes of each panel are."""
        ends = np.cumsum([0, *self.counts]).tolist()
        return [slice(a, b) for a, b in pairwise(ends)]

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
        return np.concatenate([a + (b - a) * gauss_legendre(n)[0] for a, b, n in panels])

    @cached_property
    def weights(self) -> FloatArray:
        """Of the integral over the speed, shape (size,)."""
        panels = zip(self.edges[:-1], self.edges[1:], self.counts, strict=True)
        return np.concatenate([(b - a) * gauss_legendre(n)[1] for a, b, n in panels])

    def panel_of(self, v: FloatArray) -> NDArray[np.intp]:
        """The panel in which each speed lies; the last one above all, shape of v."""
        return np.clip(np.searchsorted(self.edges, v, side="left") - 1, 0, len(self.counts) - 1)

    def rows(self, panel: int, difference: FloatArray) -> FloatArray:
        """Interpolation in a panel: ``difference`` is the speed less each node, (n, nodes)."""
        return interpolation_rows(difference, self._barycentric[panel])

    @cached_property
    def _barycentric(self) -> list[FloatArray]:
        # in a variable that runs over 4 the weights are of the order of 1
        return [barycentric_weights(4.0 * gauss_legendre(n)[0]) for n in self.counts]

    def interpolation(self, v: FloatArray) -> FloatArray:
        """Rows that take values at the nodes to those at speeds v (n,): shape (n, size)."""
        out = np.zeros((v.size, self.size))
        panel = self.panel_of(v)
        for p in np.unique(panel):
            at, part = np.nonzero(panel == p)[0], self.parts[p]
            out[at, part] = self.rows(p, v[at, None] - self.speeds[part])
        return out

    def slopes(self, even: bool, vanishing: bool, dimension: int) -> FloatArray:
        """v d/dv of an even or an odd harmonic at the nodes, shape (size, size).

        Even harmonics are 0 at the highest speed if ``vanishing``; else nothing is imposed there.
        Source: the strong form of the discontinuous Galerkin method; Hesthaven and Warburton,
        Nodal Discontinuous Galerkin Methods, section 3.2.
        """
        out = np.zeros((self.size, self.size))
        last = len(self.counts) - 1
        sign = 1.0 if even else -1.0
        for p, part in enumerate(self.parts):
            nodes, width = self.speeds[part], self.edges[p + 1] - self.edges[p]
            out[part, part] = _derivative(nodes, width)
            neighbour = p + 1 if even else p - 1
            end = self.edges[p + 1] if even else self.edges[p]
            if end == 0.0 or (even and p == last and not vanishing):
                continue
            own = self.rows(p, (end - nodes)[None])[0]
            jump = sign * own * (end / nodes) ** (dimension - 1) / self.weights[part]
            out[part, part] -= np.outer(jump, own)
            if neighbour <= last:
                other = self.parts[neighbour]
                row = self.rows(neighbour, (end - self.speeds[other])[None])
                out[part, other] += np.outer(jump, row)
        return np.asarray(self.speeds[:, None] * out)


def _derivative(nodes: FloatArray, width: float) -> FloatArray:
    """d/dv at nodes that lie in an interval of this width, shape (n, n)."""
    weights = barycentric_weights(nodes * (4.0 / width))
    difference = nodes[:, None] - nodes
    np.fill_diagonal(difference, 1.0)
    matrix = weights / weights[:, None] / difference
    np.fill_diagonal(matrix, 0.0)
    np.fill_diagonal(matrix, -matrix.sum(axis=1))
    return np.asarray(matrix)
