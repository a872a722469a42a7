r"""What collisions bring down the axis of speeds: int_0^inf P(xi > u) w(x + u) du, xi = -ln s.

It is the flux of tracers past x = ln(kappa v t/l) at the nodes x of a Chebyshev panel, of ln w on
that panel and on those above. All panels are of one width, so that its quadrature points have the
same places on any of them. Begin with :class:`PanelLosses`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.numerics import FloatArray
from kinetics.numerics.chebyshev import Chebyshev, interpolation_rows


@dataclass(frozen=True, eq=False)
class LossesFromAbove:
    """Those quadrature points of the flux that lie on one panel further up.

    Parameters
    ----------
    node : the node of the lower panel to which each point belongs, shape (n_points,)
    flux : the weight of each point, shape (n_points,)
    rows : its interpolation from the nodes of the upper panel, shape (n_points, n_nodes)
    """

    node: NDArray[np.intp]
    flux: FloatArray
    rows: FloatArray


class PanelLosses:
    """The quadrature of the flux at the nodes of any panel, except at its top one.

    Parameters
    ----------
    law : the collision law
    rule : the nodes of a panel
    width : of a panel in x
    rate : steepness of ln w that the quadrature resolves
    reach : largest loss u that matters

    Attributes
    ----------
    flux : weights of the points that lie on the panel itself, shape (n_nodes - 1, n_points)
    rows : their interpolation from the nodes of the panel without the node itself, so that they
        act on differences, shape (n_nodes - 1, n_points, n_nodes)
    flux_beyond_panel : what is left of the mean loss kappa, shape (n_nodes - 1,)
    """

    def __init__(
        self, law: CollisionLaw, rule: Chebyshev, width: float, rate: float, reach: float
    ) -> None:
        loss, flux = law.survival_for(rate)
        order = np.argsort(loss)
        order = order[loss[order] < reach]
        loss = loss[order]
        flux = flux[order]
        local = rule.local[:-1]
        place = local[:, None] + loss / width  # in panels, from the lower end of this one
        is_on_panel = place <= 1.0
        flux_on_panel = np.where(is_on_panel, flux, 0.0)
        n_on_panel = int(np.count_nonzero(is_on_panel.any(axis=0)))
        self.flux = flux_on_panel[:, :n_on_panel]
        self.rows = _rows_on_panel(rule, loss[:n_on_panel] / width, is_on_panel[:, :n_on_panel])
        self.flux_beyond_panel = law.mean_log_loss - flux_on_panel.sum(axis=1)
        self._rule = rule
        self._place = place
        self._all_flux = flux
        self._panels_up = np.maximum(np.ceil(place).astype(int) - 1, 0)
        self._furthest = int(self._panels_up.max(initial=0))
        self._above: list[LossesFromAbove] = []

    def from_above(self, n_panels: int) -> list[LossesFromAbove]:
        """Return the points on the next panels further up, nearest first; they are kept.

        Parameters
        ----------
        n_panels : how many panels there are; fewer are returned if losses do not lead so far
        """
        for m in range(len(self._above) + 1, min(n_panels, self._furthest) + 1):
            node, point = np.nonzero(self._panels_up == m)
            rows = self._rule.rows(self._place[node, point] - m)
            self._above.append(LossesFromAbove(node, self._all_flux[point], rows))
        return self._above[:n_panels]


def _rows_on_panel(rule: Chebyshev, loss: FloatArray, is_on_panel: NDArray[np.bool_]) -> FloatArray:
    """Return the interpolation at node + loss, without the share of the node itself.

    Parameters
    ----------
    rule : the nodes of a panel
    loss : in panels, shape (n_points,)
    is_on_panel : whether node + loss is on the panel, shape (n_nodes - 1, n_points); rows of others
        are 0
    """
    local = rule.local[:-1]
    # where the loss is small, the weights of the other nodes keep all their digits in this order
    difference = (local[:, None] - rule.local)[:, None, :] + loss[:, None]
    difference[~is_on_panel] = rule.local[0] - rule.local  # some place
    rows = interpolation_rows(difference, rule.weights)
    rows[~is_on_panel] = 0.0
    nodes = np.arange(local.size)
    rows[nodes, :, nodes] = 0.0
    return rows
