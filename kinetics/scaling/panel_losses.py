r"""What collisions bring down the axis of speeds: int_0^inf P(xi > u) w(x + u) du.

x = ln(kappa v t/l) is the axis of speeds v at the time t, l the mean free path. A collision
multiplies the speed by s; xi = -ln s is the loss of one collision, P(xi > u) the chance that it is
larger than u, and kappa the mean of xi, which is the integral of P(xi > u) over u. w(x) is the rate
of collisions of tracers at x. So the integral is the flux of tracers that collisions bring down
past x. All of these are numbers without a unit.

:class:`PanelLosses` is the quadrature of this integral at the nodes x of a Chebyshev panel of ln w.
A point x + u is on that panel or on one further up, and ln w is interpolated there from the nodes
of that panel; who uses the rows takes the exponential (:mod:`kinetics.scaling.density_march`). All
panels are of one width, so that the points have the same places on any of them. Begin with
:class:`PanelLosses`.
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
    """Those quadrature points of the flux at the nodes of a panel that lie on one panel further up.

    Parameters
    ----------
    node : index of the node of the lower panel to whose flux each point belongs, shape (n_points,)
    flux : the weight of each point, P(xi > u) du, shape (n_points,)
    rows : interpolate ln w at the points from the nodes of the upper panel, shape (n_points,
        n_nodes)
    """

    node: NDArray[np.intp]
    flux: FloatArray
    rows: FloatArray


class PanelLosses:
    """The quadrature of the flux at the nodes of any panel, except at its top one.

    w at the top node is known: it is the lowest node of the panel above, which is solved before.

    Parameters
    ----------
    law : the collision law
    rule : the nodes of a panel, rising, `rule.local` from 0 to 1
    width : of a panel in x
    rate : steepness of ln w in x that the quadrature resolves
    reach : losses u of this and more are left out, because w is too small there

    Attributes
    ----------
    flux : weights P(xi > u) du of the points that lie on the panel itself, shape (n_nodes - 1,
        n_points); 0 for points that only lie on it from other nodes
    rows : interpolate ln w at these points, less ln w at the node, from the differences of ln w at
        the nodes from that at the node; shape (n_nodes - 1, n_points, n_nodes). The weight of the
        node itself is 0
    flux_beyond_panel : kappa less the sum of `flux`, that is the integral of P(xi > u) over all
        losses that lead here from beyond the panel, those that `reach` leaves out too; shape
        (n_nodes - 1,)
    """

    def __init__(
        self, law: CollisionLaw, rule: Chebyshev, width: float, rate: float, reach: float
    ) -> None:
        loss, flux = law.survival_for(rate)  # points u, and weights P(xi > u) du
        order = np.argsort(loss)
        order = order[loss[order] < reach]
        loss = loss[order]
        flux = flux[order]
        local = rule.local[:-1]
        place = local[:, None] + loss / width  # in panels, from the lower end of this one
        # the only place that decides on which panel a point is: 0 is this one
        panels_up = np.maximum(np.ceil(place).astype(int) - 1, 0)
        is_on_panel = panels_up == 0
        flux_on_panel = np.where(is_on_panel, flux, 0.0)
        n_on_panel = int(np.count_nonzero(is_on_panel.any(axis=0)))
        self.flux = flux_on_panel[:, :n_on_panel]
        self.rows = _rows_on_panel(rule, loss[:n_on_panel] / width, is_on_panel[:, :n_on_panel])
        self.flux_beyond_panel = law.mean_log_loss - flux_on_panel.sum(axis=1)
        self._rule = rule
        self._place = place
        self._all_flux = flux
        self._panels_up = panels_up
        self._furthest = int(panels_up.max(initial=0))
        self._above: list[LossesFromAbove] = []  # index 0 is the next panel up

    def from_above(self, n_panels: int) -> list[LossesFromAbove]:
        """Return the points on the next panels further up, the nearest panel first.

        What was made in an earlier call is kept, as all panels use the same.

        Parameters
        ----------
        n_panels : number of panels above this one; fewer are returned if losses do not lead so far
        """
        for m in range(len(self._above) + 1, min(n_panels, self._furthest) + 1):
            node, point = np.nonzero(self._panels_up == m)
            rows = self._rule.rows(self._place[node, point] - m)
            self._above.append(LossesFromAbove(node, self._all_flux[point], rows))
        return self._above[:n_panels]


def _rows_on_panel(rule: Chebyshev, loss: FloatArray, is_on_panel: NDArray[np.bool_]) -> FloatArray:
    """Return rows that interpolate differences from a node at the point node + loss of its panel.

    Parameters
    ----------
    rule : the nodes of a panel
    loss : in widths of a panel, shape (n_points,)
    is_on_panel : whether node + loss is on the panel, shape (n_nodes - 1, n_points); rows of others
        are 0

    Returns
    -------
    Shape (n_nodes - 1, n_points, n_nodes). A row of weights that interpolate a function sums to 1,
    so that without the weight of the node itself it does so for differences from that node
    """
    local = rule.local[:-1]
    # where the loss is small, the weights of the other nodes keep all their digits in this order
    difference = (local[:, None] - rule.local)[:, None, :] + loss[:, None]
    difference[~is_on_panel] = rule.local[0] - rule.local  # any place on the panel
    rows = interpolation_rows(difference, rule.weights)
    rows[~is_on_panel] = 0.0
    nodes = np.arange(local.size)
    rows[nodes, :, nodes] = 0.0
    return rows
