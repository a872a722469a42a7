r"""The scaled VDF below its bulk, by positive recursion downwards in speed.

The density g of x = ln(kappa v t/l) drifts upwards; the flux that passes x is what collisions have
brought below x from above:

    g(x) = e^x/kappa int_0^inf P(xi > u) e^u g(x + u) du,     xi = -ln s,

All terms are positive and e^x is small, so that g below follows from g above with a rounding error
relative to g itself, over hundreds of orders of magnitude. Where s comes as near to 0 as one likes
and E[s^p] exists for p > -q only, g becomes e^(q x), with corrections of the order of e^x.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.numerics import FloatArray
from kinetics.numerics.chebyshev import FirstKind

_MORE_NODES = 3  # than digits
_SWEEPS = 20  # of Newton's method, whose error is squared by each: never reached
_DEEPEST = 300.0  # -ln g, further than the axis goes
_ROUNDING = 1e-17


class LowSpeeds:
    """ln g(x) for x below ``top``, on Chebyshev panels of length 1, made downwards when needed.

    Parameters
    ----------
    law : the collision law
    top : where the recursion starts; e^top/kappa must be well below 1
    known : ln g above top, x (n,) -> (n,)
    rtol : accuracy relative to g
    """

    def __init__(
        self,
        law: CollisionLaw,
        top: float,
        known: Callable[[FloatArray], FloatArray],
        rtol: float,
    ) -> None:
        self.law = law
        self.top = top
        # below it g is e^(q x) to rounding, where bounces come as near to rest as one likes
        self._straight = -math.inf
        if math.isfinite(law.lowest_power):
            self._straight = math.log(_ROUNDING * law.mean_log_loss)
        # the error left by Newton's method is the square of its last step
        self._last_step = 0.1 * math.sqrt(rtol)
        self._rule = FirstKind(_MORE_NODES + math.ceil(-math.log10(rtol)))
        # ln g falls as -x^2/2 over the largest loss: its slope is at most that at its end, and g
        # rises as e^x
        steepest = 1.0 + math.sqrt(2.0 * _DEEPEST / law.largest_loss)
        survival = law.survival_for(steepest)
        self._xi = survival.log_loss
        self._log_weight = survival.log_weight - math.log(law.mean_log_loss)
        reach = float(self._xi.max())
        # panel k covers [top - k - 1, top - k]; negative k is above top
        self._above = max(3, math.ceil(reach) + 1)
        x = top + np.arange(self._above)[:, None] + self._rule.local
        self._panels = list(known(x.ravel()).reshape(x.shape)[::-1])
        self._prepare()

    def _prepare(self) -> None:
        """Where each point x_i + xi_k of a panel falls: the same for every panel."""
        local = (self._rule.local[:, None] + self._xi).ravel()
        panel = np.floor(local).astype(int)
        rows = self._rule.rows(local - panel)
        self._inside = panel == 0
        self._rows_inside = rows[self._inside]
        self._rows_newton = np.where(self._inside[:, None], rows, 0.0).reshape(
            self._rule.nodes, -1, self._rule.nodes
        )
        self._outside = [(m, panel == m) for m in range(1, int(panel.max()) + 1)]
        self._rows_outside = [rows[mask] for _, mask in self._outside]

    def _add_panel(self) -> None:
        """One panel further down."""
        x = self.bottom - 1.0 + self._rule.local
        terms = np.empty(self._rule.nodes * self._xi.size)
        for (m, mask), rows in zip(self._outside, self._rows_outside, strict=True):
            terms[mask] = rows @ self._panels[-m]
        # what lies in the panel itself is not known yet, and weighs e^x: continue from above
        third, second, first = self._panels[-3:]
        values = 3.0 * (first - second) + third
        for _ in range(_SWEEPS):
            terms[self._inside] = self._rows_inside @ values
            log_terms = terms.reshape(self._rule.nodes, -1) + self._log_weight
            largest = log_terms.max(axis=1, keepdims=True)
            share = np.exp(log_terms - largest)
            total = share.sum(axis=1, keepdims=True)
            residual = x + (largest + np.log(total))[:, 0] - values
            # Newton: the shares of the terms are the derivatives by what they are made of
            share /= total
            slope = (share[:, None, :] @ self._rows_newton)[:, 0, :]
            step = np.linalg.solve(np.eye(self._rule.nodes) - slope, residual)
            values = values + step
            if float(np.abs(step).max()) < self._last_step:
                break
        self._panels.append(values)

    @property
    def bottom(self) -> float:
        """Lowest x reached so far."""
        return self.top - (len(self._panels) - self._above)

    @property
    def lowest_node(self) -> float:
        """The lowest node, a little above the bottom."""
        return self.bottom + float(self._rule.local[0])

    @property
    def log_at_bottom(self) -> float:
        """ln g at the lowest node."""
        return float(self._panels[-1][0])

    def extend(self, x: float) -> None:
        """Make panels down to x, or to where g is a power."""
        while self.bottom > max(x, self._straight):
            self._add_panel()

    def log_density(self, x: FloatArray) -> FloatArray:
        """ln g(x), x (n,) with bottom <= x <= top."""
        level = self.top - x
        index = np.minimum(np.floor(level).astype(int), len(self._panels) - self._above - 1)
        index = np.maximum(index, 0)
        local = index + 1 - level
        table = np.array(self._panels)[self._above + index]
        return np.asarray(np.sum(self._rule.rows(local) * table, axis=1))
