"""Gauss panels of ln v, which can be cut where an integrand has a kink.

A sum over the nodes of all panels is an integral over ln v. An integrand that is zero below a speed
and smooth above it is not smooth on the panel around that speed: there the integral is that of the
polynomial through the nodes of the panel, over the piece above. Begin with :class:`LogPanels`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kinetics.numerics import FloatArray
from kinetics.numerics.chebyshev import barycentric_weights, interpolation_rows
from kinetics.numerics.gauss import gauss_legendre, panels_between


@dataclass(frozen=True)
class PanelPieces:
    """The pieces of some panels above a speed in each: quadratures by what the panels' nodes have.

    Parameters
    ----------
    nodes : the indices of the nodes of each panel, shape (n, points)
    speeds : the Gauss points of the pieces, shape (n, points)
    rows : the integral over a piece takes ``rows[i, j, k]`` times the product of an integrand at
        its point j and what the whole panel's quadrature has at its node k, (n, points, points)
    """

    nodes: NDArray[np.intp]
    speeds: FloatArray
    rows: FloatArray


@dataclass(frozen=True, eq=False)
class LogPanels:
    """Panels of ln v with the same number of Gauss points on each.

    Parameters
    ----------
    log_edges : ln of the speeds between the panels and at both ends, rising, shape (n_panels + 1,)
    points : Gauss points of a panel
    """

    log_edges: FloatArray
    points: int

    @cached_property
    def _nodes(self) -> tuple[FloatArray, FloatArray]:
        return panels_between(self.log_edges, self.points)

    @property
    def log_speeds(self) -> FloatArray:
        """ln v of all nodes, rising, shape (n_panels * points,)."""
        return self._nodes[0]

    @property
    def weights(self) -> FloatArray:
        """Weights of the nodes in an integral over ln v, shape (n_panels * points,)."""
        return self._nodes[1]

    def panel_of(self, log_speeds: FloatArray) -> NDArray[np.intp]:
        """Return the index of the panel around each speed; -1 below all, n_panels above all."""
        return np.searchsorted(self.log_edges, log_speeds, side="right") - 1

    def pieces_above(self, log_speeds: FloatArray) -> PanelPieces:
        """Return the piece above each speed of the panel around it; it must be in a panel."""
        node, weight = gauss_legendre(self.points)
        panel = self.panel_of(log_speeds)
        begin = self.log_edges[panel]
        width = self.log_edges[panel + 1] - begin
        share_below = (log_speeds - begin) / width
        local = share_below[:, None] + (1.0 - share_below[:, None]) * node
        interpolation = interpolation_rows(local[:, :, None] - node, barycentric_weights(node))
        piece_weight = (1.0 - share_below)[:, None] * weight
        return PanelPieces(
            nodes=panel[:, None] * self.points + np.arange(self.points),
            speeds=np.exp(begin[:, None] + width[:, None] * local),
            rows=piece_weight[:, :, None] * interpolation / weight,
        )
