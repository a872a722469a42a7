"""Collocation on equal panels in X = ln(v t/l): what the backward equations share.

A bounce takes X to X - xi, xi = -ln s >= 0, whatever X is: on equal panels the collision term is
the same few small matrices everywhere, from a panel on itself and from those below it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw, ImpactQuadrature
from kinetics.numerics.barycentric import interpolation_rows

FloatArray = NDArray[np.float64]

_TINY = 1e-290
_CLOSE = 1e-3  # shifts, in panels, below which interpolation would lose digits


@dataclass(frozen=True)
class PanelRule:
    """Chebyshev collocation on a panel.

    Parameters
    ----------
    nodes : Chebyshev points of the second kind, both ends included
    width : of a panel in X
    """

    nodes: int
    width: float = 1.0
    _shifted: dict[int, tuple[ImpactQuadrature, NDArray[np.intp], FloatArray]] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )

    @cached_property
    def local(self) -> FloatArray:
        """The nodes on [0, 1], shape (nodes,)."""
        return np.asarray(0.5 * (1.0 - np.cos(np.arange(self.nodes) * math.pi / (self.nodes - 1))))

    @cached_property
    def weights(self) -> FloatArray:
        """Barycentric weights, shape (nodes,)."""
        w = (-1.0) ** np.arange(self.nodes)
        w[[0, -1]] *= 0.5
        return np.asarray(w)

    def shares(self, local: FloatArray) -> FloatArray:
        """Rows of `rows` before their sums are divided by, (n, nodes): one pass less."""
        distance = local[:, None] - self.local
        # on a node, that node alone
        distance[distance == 0.0] = _TINY
        return np.asarray(np.divide(self.weights, distance, out=distance))

    def rows(self, local: FloatArray) -> FloatArray:
        """Interpolation from the nodes to local (n,), in panels: (n, nodes)."""
        return interpolation_rows(local[:, None] - self.local, self.weights)

    @cached_property
    def derivative(self) -> FloatArray:
        """d/dX at the nodes, shape (nodes, nodes)."""
        difference = self.local[:, None] - self.local
        np.fill_diagonal(difference, 1.0)
        matrix = self.weights / self.weights[:, None] / difference
        np.fill_diagonal(matrix, 0.0)
        np.fill_diagonal(matrix, -matrix.sum(axis=1))
        return np.asarray(matrix / self.width)

    def last_coefficients(self, values: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Sizes of the last Chebyshev coefficient and the one before; last axis is the nodes'."""
        n = self.nodes
        k = np.arange(n)
        halves = np.where((k == 0) | (k == n - 1), 0.5, 1.0)
        last = np.abs(values @ (halves * np.cos(math.pi * k) / (n - 1)))
        before = np.abs(values @ (halves * np.cos(math.pi * k * (n - 2) / (n - 1)) * 2 / (n - 1)))
        return last, before

    def kernel(
        self, law: CollisionLaw, harmonics: list[int], rate: float | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """The collision term of each harmonic m: (1 - E[cos(m chi) .(X - xi)]) on a panel.

        Returns the loss of a panel on itself, (n_m, nodes, nodes), and the gain from the panels
        below it, farthest first, (n_m, nodes, reach * nodes). ``rate`` is how fast functions vary
        in X, the number of nodes by default.
        """
        q = law.quadrature_for(float(self.nodes) if rate is None else rate, max(harmonics))
        n = self.nodes
        shift = q.log_loss / self.width
        local = self.local[:, None] - shift
        below, rows = self._shift(q)
        cosine = np.stack([q.harmonic(m) for m in harmonics])
        reach = int(below.max())
        gain = np.zeros((len(harmonics), n, reach, n))
        for k in range(1, reach + 1):
            used = np.nonzero((below == k).any(axis=0))[0]
            weight = np.where(below[:, used] == k, q.weight[used], 0.0)
            gain[:, :, reach - k] = self._mean(cosine[:, used], weight, rows[:, used])
        # 1 - (gain from the panel itself) without cancellation, for e near 1: the off-diagonal
        # entries are accurate relative to themselves, and rows of the interpolation sum to 1
        near = np.nonzero((below == 0).any(axis=0))[0]
        inside = np.where(below[:, near] == 0, q.weight[near], 0.0)
        own = np.eye(n, dtype=bool)[:, None, :]
        close = self._close_rows(shift[near], local[:, near], rows[:, near])
        off = np.where(own, 0.0, close)
        loss = -self._mean(cosine[:, near], inside, off)
        half = np.stack([np.sin(0.5 * m * np.arccos(q.cosine[near])) for m in harmonics])
        diagonal = np.einsum("mk,ik->mi", 2.0 * half**2, inside)
        diagonal += np.einsum("mk,ik->mi", cosine[:, near], inside * off.sum(axis=2))
        diagonal += np.where(below > 0, q.weight, 0.0).sum(axis=1)
        loss[:, np.arange(n), np.arange(n)] = diagonal
        return loss, gain.reshape(len(harmonics), n, reach * n)

    def _shift(self, q: ImpactQuadrature) -> tuple[NDArray[np.intp], FloatArray]:
        """Panels below in which each bounce ends, (nodes, n_q), and its interpolation there.

        The second is (nodes, n_q, nodes); kept, because it is the same for all harmonics.
        """
        if id(q) not in self._shifted:
            local = self.local[:, None] - q.log_loss / self.width
            below = np.maximum(np.ceil(-local), 0.0).astype(int)
            rows = self.rows((local + below).ravel()).reshape(self.nodes, -1, self.nodes)
            self._shifted[id(q)] = q, below, rows
        return self._shifted[id(q)][1:]

    @staticmethod
    def _mean(cosine: FloatArray, weight: FloatArray, rows: FloatArray) -> FloatArray:
        """Sum over k of cosine (m, k) weight (i, k) rows (i, k, j): (m, i, j)."""
        return np.tensordot(cosine, weight[:, :, None] * rows, axes=(1, 1))

    def _close_rows(self, shift: FloatArray, local: FloatArray, rows: FloatArray) -> FloatArray:
        """Off-diagonal interpolation weights, accurate where a point is close to its own node."""
        if float(shift.min()) > _CLOSE:
            return rows
        n = self.nodes
        distance = local[:, :, None] - self.local
        own = np.eye(n, dtype=bool)[:, None, :]
        with np.errstate(divide="ignore", invalid="ignore"):
            terms = np.where(own, 0.0, self.weights / np.where(own, 1.0, distance))
            # -shift/(own weight) times the usual barycentric quotient
            scaled = -shift[None, :, None] * terms
            total = self.weights[:, None, None] + scaled.sum(axis=2, keepdims=True)
            accurate = scaled / total
        use = np.isfinite(accurate) & (shift < _CLOSE)[None, :, None]
        return np.where(use, accurate, rows)
