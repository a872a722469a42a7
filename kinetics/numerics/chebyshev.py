"""Polynomials through Chebyshev points on [0, 1] and on panels, and barycentric interpolation.

Source of the formulas: Berrut and Trefethen, SIAM Review 46, 501 (2004). The average of f(x -
shift) over many shifts is the same few small matrices on every panel, from the panel itself and
from those below it, because the panels are equal.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
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
    """Extrema of a Chebyshev polynomial: on one interval, or on each of many equal panels.

    nodes : their number, 3 at least; both ends are among them
    width : of a panel in x
    local : the points in panels, from 0 to 1, rising, shape (nodes,)
    weights : their barycentric weights, shape (nodes,)
    last_two : columns that give the last Chebyshev coefficient and the one before, (nodes, 2)
    """

    nodes: int
    width: float = 1.0
    local: FloatArray = field(init=False, repr=False, compare=False)
    weights: FloatArray = field(init=False, repr=False, compare=False)
    last_two: FloatArray = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        made, last = vars(self), self.nodes - 1  # past the lock of a frozen dataclass
        angle, halves = np.linspace(0.0, math.pi, self.nodes), np.ones(self.nodes)
        halves[[0, -1]] = 0.5
        made["local"] = 0.5 * (1.0 - np.cos(angle))
        made["weights"] = (-1.0) ** np.arange(self.nodes) * halves
        cosines = np.cos(np.outer(angle, np.array([last, last - 1])))
        # the last coefficient has half the weight of the others
        made["last_two"] = halves[:, None] * cosines * [1.0, 2.0] / last

    def rows(self, local: FloatArray) -> FloatArray:
        """Interpolation from the points to local (n,), in panels: shape (n, nodes)."""
        return interpolation_rows(local[:, None] - self.local, self.weights)

    def shares(self, local: FloatArray) -> FloatArray:
        """`rows` before each row is divided by its sum."""
        distance = local[:, None] - self.local
        distance += 1e-290  # in place of 0: the reciprocal is finite, and outweighs all others
        return np.asarray(np.divide(self.weights, distance, out=distance))

    def last_coefficients(self, values: NDArray[Any]) -> NDArray[Any]:
        """Sizes of the last Chebyshev coefficient and of the one before, of values (..., nodes)."""
        return np.moveaxis(np.abs(values @ self.last_two), -1, 0)

    @cached_property
    def derivative(self) -> FloatArray:
        """d/dx at the points, shape (nodes, nodes)."""
        return derivative_matrix(self.local, self.weights) / self.width


panel_rule = lru_cache(maxsize=64)(Chebyshev)
"""The same rule again: its matrices are not made twice."""


class PanelShifts:
    """Where the nodes of a panel go when they are shifted down, and the interpolation there.

    shift : in x, not negative, shape (n_shifts,)
    below : by how many panels each shifted node lies below, shape (nodes, n_shifts)
    rows : its interpolation from the nodes of that panel, shape (nodes, n_shifts, nodes)
    """

    def __init__(self, rule: Chebyshev, shift: FloatArray) -> None:
        local, down = rule.local, shift / rule.width
        self.rule = rule
        self.below = np.maximum(np.ceil(down - local[:, None]), 0.0).astype(int)
        # in this order, a node and itself shifted are apart by the shift exactly: where the shift
        # is small, the weights of the other nodes keep all their digits
        between = local[:, None] - local
        difference = between[:, None, :] + (self.below - down)[:, :, None]
        self.rows = interpolation_rows(difference, rule.weights)

    def kernel(
        self, weight: FloatArray, factor: FloatArray, lost: FloatArray,
        reach_of: NDArray[np.intp] | None = None,
    ) -> tuple[FloatArray, FloatArray]:  # fmt: skip
        """The terms of f(x) - sum_k weight_k factor_k f(x - shift_k), for several factors at once.

        weight : sums to 1, shape (n_shifts,)
        factor, lost : factor, and 1 - factor where that has more digits, shape (n_m, n_shifts)
        reach_of : how many panels below matter for each factor, not rising, (n_m,); None: all

        What a panel loses, by itself, (n_m, nodes, nodes), and what it gains from the panels below
        it, farthest first, (n_m, nodes, reach * nodes).
        """
        n, count = self.rule.nodes, factor.shape[0]
        reach = int(self.below.max(initial=0))
        gain = np.zeros((count, n, reach, n))
        for k in range(1, reach + 1):
            used, inside = self._ending(k, weight)
            some = count if reach_of is None else int(np.count_nonzero(reach_of >= k))
            gain[:some, :, reach - k] = _average(factor[:some, used], inside, self.rows[:, used])
        # 1 - (gain from the panel itself) without cancellation where the shifts are small: rows
        # sum to 1, so that the diagonal is made of the other nodes, of what is lost and of what
        # comes from panels below
        used, inside = self._ending(0, weight)
        others = np.where(np.eye(n, dtype=bool)[:, None, :], 0.0, self.rows[:, used])
        loss = -_average(factor[:, used], inside, others)
        diagonal = np.einsum("mk,ik->mi", lost[:, used], inside)
        diagonal += np.einsum("mk,ik->mi", factor[:, used], inside * others.sum(axis=2))
        diagonal += np.where(self.below > 0, weight, 0.0).sum(axis=1)
        loss[:, np.arange(n), np.arange(n)] = diagonal
        return loss, gain.reshape(count, n, reach * n)

    def _ending(self, panel: int, weight: FloatArray) -> tuple[NDArray[np.intp], FloatArray]:
        """Which shifts end in a panel below, and the weights of those that do, (nodes, n_used)."""
        used = np.nonzero((self.below == panel).any(axis=0))[0]
        return used, np.where(self.below[:, used] == panel, weight[used], 0.0)


def _average(factor: FloatArray, weight: FloatArray, rows: FloatArray) -> FloatArray:
    """Sum over k of factor (m, k) weight (i, k) rows (i, k, j): (m, i, j)."""
    return np.tensordot(factor, weight[:, :, None] * rows, axes=(1, 1))


def with_returns(
    rule: Chebyshev, loss: FloatArray, gain: FloatArray, factor: FloatArray, shift: float
) -> tuple[FloatArray, FloatArray]:
    """Loss and gain of (K - 1)/(1 - factor S (K - 1)), with S f(x) = f(x - shift), from those of K.

    Both as :meth:`PanelShifts.kernel` has them, factor (n_m,).
    """
    n, count = rule.nodes, loss.shape[0]
    # K - 1 panel by panel, the nearest one first, (reach + 1, n_m, n, n)
    old = np.moveaxis(gain.reshape(count, n, -1, n), 2, 0)[::-1]
    old = np.concatenate([-loss[None], old])
    shifts = PanelShifts(rule, np.array([shift]))
    span = range(int(shifts.below.min()), int(shifts.below.max()) + 1)
    # g = (K - 1)(f + factor S g)
    again = np.zeros((len(old) + span[-1], count, n, n))
    for j in span:
        moved = (shifts.below == j) * shifts.rows[:, 0]
        again[j : j + len(old)] += factor[:, None, None] * (old @ moved)
    inside = np.linalg.inv(np.eye(n) - again[0])
    old, further = inside @ old, inside @ again[1:]
    new: list[FloatArray] = []
    small = 0
    while small < len(again) and len(new) < 300:  # which is never reached
        k = len(new)
        block = old[k] if k < len(old) else np.zeros_like(old[0])
        for j in range(1, min(k, len(further)) + 1):
            block = block + further[j - 1] @ new[k - j]
        new.append(block)
        small = small + 1 if np.abs(block).max() < 1e-17 else 0
    below = np.stack(new[len(new) - 1 - small : 0 : -1] or [np.zeros_like(old[0])])
    return -new[0], np.moveaxis(below, 0, 2).reshape(count, n, -1)
