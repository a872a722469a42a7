"""Averages of f(x - shift) over many shifts, for a function on equal panels.

With f at the Chebyshev nodes of the panels, the average at the nodes of a panel is a few small
matrices times f there and on the panels below. They are the same for every panel, because the
panels are equal. Begin with `PanelShifts.kernel`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinetics.numerics import FloatArray
from kinetics.numerics.chebyshev import Chebyshev, interpolation_rows

#: Matrices for panels below are left out when they stay smaller than this. Chosen: rounding beside
#: 1.
NEGLIGIBLE_MATRIX = 1e-17
#: Most panels below that returns may need. Origin not recorded: a series that converges ends long
#: before.
MAX_PANELS_OF_RETURNS = 300


class PanelShifts:
    """Where the nodes of a panel go when they are shifted down, and the interpolation there.

    Parameters
    ----------
    rule : the nodes of a panel
    shift : in x, not negative, shape (n_shifts,)

    Attributes
    ----------
    below : by how many panels each shifted node lies below, shape (nodes, n_shifts)
    rows : its interpolation from the nodes of that panel, shape (nodes, n_shifts, nodes)
    """

    def __init__(self, rule: Chebyshev, shift: FloatArray) -> None:
        local = rule.local
        panels_down = shift / rule.width
        self.rule = rule
        self.below = np.maximum(np.ceil(panels_down - local[:, None]), 0.0).astype(int)
        # in this order, a node and itself shifted are apart by the shift exactly: where the shift
        # is small, the weights of the other nodes keep all their digits
        between_nodes = local[:, None] - local
        difference = between_nodes[:, None, :] + (self.below - panels_down)[:, :, None]
        self.rows = interpolation_rows(difference, rule.weights)

    def kernel(
        self,
        weight: FloatArray,
        factor: FloatArray,
        lost: FloatArray,
        reach_of: NDArray[np.intp] | None = None,
    ) -> tuple[FloatArray, FloatArray]:
        """Return the terms of f(x) - sum_k weight_k factor_k f(x - shift_k), for several factors.

        Parameters
        ----------
        weight : sums to 1, shape (n_shifts,)
        factor, lost : factor, and 1 - factor where that has more digits, shape (n_m, n_shifts)
        reach_of : how many panels below matter for each factor, not rising, (n_m,); None: all

        Returns
        -------
        loss, gain : what a panel loses, by itself, shape (n_m, nodes, nodes), and what it gains
            from the panels below it, farthest first, shape (n_m, nodes, reach * nodes)
        """
        nodes = self.rule.nodes
        n_m = factor.shape[0]
        reach = int(self.below.max(initial=0))
        gain = np.zeros((n_m, nodes, reach, nodes))
        for distance in range(1, reach + 1):
            shifts, weight_there = self._shifts_to(distance, weight)
            n_reaching = n_m
            if reach_of is not None:
                n_reaching = int(np.count_nonzero(reach_of >= distance))
            gain[:n_reaching, :, reach - distance] = _average(
                factor[:n_reaching, shifts], weight_there, self.rows[:, shifts]
            )
        return self._loss(weight, factor, lost), gain.reshape(n_m, nodes, reach * nodes)

    def _loss(self, weight: FloatArray, factor: FloatArray, lost: FloatArray) -> FloatArray:
        """Return 1 - (gain from the panel itself), without cancellation where shifts are small.

        Rows sum to 1, so that the diagonal is made of the other nodes, of what is lost and of what
        comes from panels below.
        """
        nodes = self.rule.nodes
        shifts, weight_inside = self._shifts_to(0, weight)
        is_same_node = np.eye(nodes, dtype=bool)[:, None, :]
        other_nodes = np.where(is_same_node, 0.0, self.rows[:, shifts])
        loss = -_average(factor[:, shifts], weight_inside, other_nodes)
        diagonal = np.einsum("mk,ik->mi", lost[:, shifts], weight_inside)
        weight_of_others = weight_inside * other_nodes.sum(axis=2)
        diagonal += np.einsum("mk,ik->mi", factor[:, shifts], weight_of_others)
        diagonal += np.where(self.below > 0, weight, 0.0).sum(axis=1)
        loss[:, np.arange(nodes), np.arange(nodes)] = diagonal
        return loss

    def _shifts_to(self, distance: int, weight: FloatArray) -> tuple[NDArray[np.intp], FloatArray]:
        """Return the shifts that end so many panels below for any node, (n_used,).

        And their weights, shape (nodes, n_used); 0 for the nodes for which they end elsewhere.
        """
        ends_there = self.below == distance
        shifts = np.nonzero(ends_there.any(axis=0))[0]
        return shifts, np.where(ends_there[:, shifts], weight[shifts], 0.0)


def _average(factor: FloatArray, weight: FloatArray, rows: FloatArray) -> FloatArray:
    """Return the sum over k of factor (m, k) weight (i, k) rows (i, k, j): shape (m, i, j)."""
    return np.tensordot(factor, weight[:, :, None] * rows, axes=(1, 1))


def with_returns(
    rule: Chebyshev, loss: FloatArray, gain: FloatArray, factor: FloatArray, shift: float
) -> tuple[FloatArray, FloatArray]:
    """Return loss and gain of (K - 1)/(1 - factor S (K - 1)), S f(x) = f(x - shift).

    The operator G = (K - 1)(1 + factor S G) is found panel by panel, from the nearest panel down.

    Parameters
    ----------
    rule : the nodes of a panel
    loss, gain : of K, as :meth:`PanelShifts.kernel` returns them
    factor : shape (n_m,)
    shift : in x, not negative
    """
    nodes = rule.nodes
    n_m = loss.shape[0]
    # K - 1 by distance, the panel itself first, (reach + 1, n_m, nodes, nodes)
    from_below = np.moveaxis(gain.reshape(n_m, nodes, -1, nodes), 2, 0)[::-1]
    collisions = np.concatenate([-loss[None], from_below])
    # (K - 1) factor S by distance
    shifts = PanelShifts(rule, np.array([shift]))
    nearest = int(shifts.below.min())
    farthest = int(shifts.below.max())
    again = np.zeros((len(collisions) + farthest, n_m, nodes, nodes))
    for distance in range(nearest, farthest + 1):
        shift_rows = (shifts.below == distance) * shifts.rows[:, 0]
        terms = factor[:, None, None] * (collisions @ shift_rows)
        again[distance : distance + len(collisions)] += terms
    # what is on the panel itself is solved for at once
    inverse = np.linalg.inv(np.eye(nodes) - again[0])
    collisions = inverse @ collisions
    again_from_below = inverse @ again[1:]
    result: list[FloatArray] = []
    n_negligible = 0
    while n_negligible < len(again) and len(result) < MAX_PANELS_OF_RETURNS:
        distance = len(result)
        matrix = np.zeros_like(collisions[0])
        if distance < len(collisions):
            matrix = collisions[distance]
        for j in range(1, min(distance, len(again_from_below)) + 1):
            matrix = matrix + again_from_below[j - 1] @ result[distance - j]
        result.append(matrix)
        is_negligible = np.abs(matrix).max() < NEGLIGIBLE_MATRIX
        n_negligible = n_negligible + 1 if is_negligible else 0
    farthest_first = result[len(result) - 1 - n_negligible : 0 : -1]
    if not farthest_first:
        farthest_first = [np.zeros_like(collisions[0])]
    new_gain = np.moveaxis(np.stack(farthest_first), 0, 2).reshape(n_m, nodes, -1)
    return -result[0], new_gain
