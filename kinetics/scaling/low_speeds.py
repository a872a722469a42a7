r"""The scaled VDF below its bulk, by positive recursion downwards in speed.

What drifts up past x was all lost past x from above:

    g(x) = e^x/kappa E[ (s^2 - e^2)/s^3 g(x + xi) ],     xi = -ln s,

every term of one sign, and e^x small: g below is got from g above to rounding relative to itself,
through hundreds of orders of magnitude. (The weight is the derivative of the flux: s^2 - e^2 over
s^2 turns the average over the impact parameter into the integral of P(xi > u) over u.)
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.numerics.barycentric import interpolation_rows

FloatArray = NDArray[np.float64]

_WIDTH = 1.0  # of a panel in x; ln g is nearly quadratic over it
_LEAST_NODES, _MOST_NODES = 6, 16  # 2 digits less than nodes (measured)
_SWEEPS = 20
_STEEPEST = 60.0  # slopes of ln g that the averages resolve: reached near ln g = -700 at e = 0.5


class LowSpeeds:
    """Log g(x) for x below ``top``, on Chebyshev panels made downwards as they are asked for.

    Parameters
    ----------
    law : the collision law, 0 <= e < 1
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
        # the error left by Newton's method is the square of its last step
        self._last_step = 0.1 * math.sqrt(rtol)
        nodes = 2 + math.ceil(-math.log10(rtol))
        self._nodes = min(_MOST_NODES, max(_LEAST_NODES, nodes))
        quadrature = law.quadrature_for(_STEEPEST)
        self._xi = quadrature.log_loss
        weight = quadrature.weight * (quadrature.ratio**2 - law.restitution**2)
        with np.errstate(divide="ignore"):
            log_weight = np.log(np.maximum(weight, 0.0)) - 3.0 * np.log(quadrature.ratio)
        self._log_weight = log_weight - math.log(law.mean_log_loss)
        theta = (np.arange(self._nodes) + 0.5) * math.pi / self._nodes
        self._local = 0.5 * (1.0 - np.cos(theta))  # rising in (0, 1)
        self._barycentric: FloatArray = np.asarray(
            (-1.0) ** np.arange(self._nodes) * np.sin(theta), float
        )
        reach = float(self._xi.max())
        # panel k covers [top - (k+1) width, top - k width]; negative k is above top
        self._above = max(3, math.ceil(reach / _WIDTH) + 1)
        x = top + (np.arange(self._above)[:, None] + self._local) * _WIDTH
        self._panels = list(known(x.ravel()).reshape(x.shape)[::-1])
        self._prepare()

    def _interpolation(self, local: FloatArray) -> FloatArray:
        """Rows of barycentric interpolation at local coordinates (n,): (n, nodes)."""
        return interpolation_rows(local[:, None] - self._local, self._barycentric)

    def _prepare(self) -> None:
        """Where each point x_i + xi_k of a panel falls: the same for every panel."""
        local = (self._local[:, None] + self._xi / _WIDTH).ravel()
        panel = np.floor(local).astype(int)
        rows = self._interpolation(local - panel)
        self._inside = panel == 0
        self._rows_inside = rows[self._inside]
        self._rows_newton = np.where(self._inside[:, None], rows, 0.0).reshape(
            self._nodes, -1, self._nodes
        )
        self._outside = [(m, panel == m) for m in range(1, int(panel.max()) + 1)]
        self._rows_outside = [rows[mask] for _, mask in self._outside]

    def _add_panel(self) -> None:
        """One panel further down."""
        x = self.bottom - _WIDTH + self._local * _WIDTH
        terms = np.empty(self._nodes * self._xi.size)
        for (m, mask), rows in zip(self._outside, self._rows_outside, strict=True):
            terms[mask] = rows @ self._panels[-m]
        # what lies in the panel itself is not known yet, and weighs e^x: continue from above
        third, second, first = self._panels[-3:]
        values = 3.0 * (first - second) + third
        for _ in range(_SWEEPS):
            terms[self._inside] = self._rows_inside @ values
            log_terms = terms.reshape(self._nodes, -1) + self._log_weight
            largest = log_terms.max(axis=1, keepdims=True)
            share = np.exp(log_terms - largest)
            total = share.sum(axis=1, keepdims=True)
            residual = x + (largest + np.log(total))[:, 0] - values
            # Newton: the shares of the terms are the derivatives by what they are made of
            share /= total
            slope = (share[:, None, :] @ self._rows_newton)[:, 0, :]
            step = np.linalg.solve(np.eye(self._nodes) - slope, residual)
            values = values + step
            if float(np.abs(step).max()) < self._last_step:
                break
        self._panels.append(values)

    @property
    def bottom(self) -> float:
        """Lowest x reached so far."""
        return self.top - (len(self._panels) - self._above) * _WIDTH

    @property
    def log_at_bottom(self) -> float:
        """Log g at the lowest node."""
        return float(self._panels[-1][0])

    def extend(self, x: float) -> None:
        """Make panels down to x."""
        while self.bottom > x:
            self._add_panel()

    def log_density(self, x: FloatArray) -> FloatArray:
        """Log g(x), x (n,) with bottom <= x <= top."""
        level = (self.top - x) / _WIDTH
        index = np.minimum(np.floor(level).astype(int), len(self._panels) - self._above - 1)
        index = np.maximum(index, 0)
        local = index + 1 - level
        table = np.array(self._panels)[self._above + index]
        return np.asarray(np.sum(self._interpolation(local) * table, axis=1))
