r"""ln g on the axis x = ln(kappa v t/l), marched down from where F is nothing.

The density g of x drifts upwards, and the flux that passes x is what collisions have brought below
x from above (the scaled equation, paper label ``ifmu2``, integrated once):

    kappa g(x) = int_0^inf P(xi > u) w(x + u) du,     xi = -ln s,

with w = e^x g the rate of collisions: w at x needs w above x only. On Chebyshev panels of one
width, from the top down, each panel is a small linear system for w over a guess of it, from which
ln w follows: the error is relative to w itself, over hundreds of orders of magnitude. What is
assumed above the top is forgotten as F grows. The march begins not far above the moments, and once
more at 1e-100 of the bulk if a question reaches beyond. Next to rest, where bounces lead there, g
ends as a power of v t/l.
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.numerics import FOLDS, LARGEST_LOG, ROUNDING, FloatArray
from kinetics.numerics.chebyshev import Chebyshev, barycentric_weights, interpolation_rows
from kinetics.numerics.gauss import gauss_legendre
from kinetics.scaling.log_moments import small_deviation

DEEPEST = 100.0 * math.log(10.0)  # in ln F: below 1e-100 of its bulk F is not given
FEWEST_NODES, MOST_NODES = 8, 256  # of a panel
_MORE_NODES = 6  # of a panel, than digits
_DEVIATIONS = 5.0  # of g, on a panel
# In ln F, less ln rtol: how far the first march reaches, and what is assumed above its top is
# forgotten. F or a moment from further out begins another one at DEEPEST.
_SHALLOW = 15.0
_SHARE = 0.01  # of rtol, for each of five small parts of the error: ends, sweeps, near rest
_RESOLVED = 15.0  # e-folds of w over the losses, or over 1, that their first quadrature resolves
_STEEPEST = 60.0  # g near e = 1, over its deviation: where it is e^-(60^2/2) of its peak
# Errors of F and of moments over the last coefficients of ln w, at most: measured against the
# closed form for 6 to 18 nodes, e from 0 to .99, rough disks and two ratios.
_DENSITY, _MOMENT = 0.15, 1e-3
# Below this floor no accuracy is promised: rounding moves the axis by it, and F by that times its
# steepness. Ten times the largest that was found for e from .9 to 1 - 1e-10, on three processors.
ROUNDING_FLOOR = 64 * ROUNDING  # 1.4e-14


class _Losses:
    """int P(xi > u) w(x + u) du at the nodes of any panel but its top one."""

    def __init__(
        self, law: CollisionLaw, rule: Chebyshev, width: float, rate: float, reach: float
    ) -> None:
        u, flux = law.survival_for(rate)
        order = np.argsort(u)
        order = order[u[order] < reach]
        u, flux = u[order], flux[order]
        local = rule.local[:-1]
        place = local[:, None] + u / width
        inside = place <= 1.0
        near = int(np.count_nonzero(inside.any(axis=0)))
        # where u is small, the weights of the other nodes keep all their digits in this order
        between = (local[:, None] - rule.local)[:, None, :] + (u[:near] / width)[:, None]
        between[~inside[:, :near]] = rule.local[0] - rule.local  # some place
        self.rows = interpolation_rows(between, rule.weights)
        self.rows[~inside[:, :near]] = 0.0
        nodes = np.arange(local.size)
        self.rows[nodes, :, nodes] = 0.0
        self.flux = np.where(inside, flux, 0.0)
        self.flux_out = law.mean_log_loss - self.flux.sum(axis=1)  # beyond reach there is no w
        self.flux = self.flux[:, :near]
        self._rule, self._flux, self._place = rule, flux, place
        self._up = np.maximum(np.ceil(place).astype(int) - 1, 0)
        self.furthest = int(self._up.max(initial=0))  # how many panels up losses lead
        self._groups: dict[int, tuple[NDArray[np.intp], FloatArray, FloatArray]] = {}

    def outside(self, m: int) -> tuple[NDArray[np.intp], FloatArray, FloatArray]:
        """Of losses to the panel m panels up: their nodes, fluxes and rows there, (n_points,)."""
        if m not in self._groups:
            node, k = np.nonzero(self._up == m)
            rows = self._rule.rows(self._place[node, k] - m)
            self._groups[m] = node, self._flux[k], rows
        return self._groups[m]


class SpeedAxis:
    """ln g(x), x = ln(kappa v t/l), as far down as it was asked for; up to its norm.

    rtol : relative accuracy of g and of its moments; nodes : of each panel, or None for as many as
    that takes; unresolved : whether nothing is known, because too few were asked for
    """

    def __init__(self, law: CollisionLaw, rtol: float, nodes: int | None = None) -> None:
        self.law, self.rtol, self.unresolved = law, rtol, False
        self._rule = Chebyshev(nodes or _MORE_NODES + math.ceil(-math.log10(rtol)))
        self._own_nodes = nodes is None
        deviation = small_deviation(law)
        self._flank = 1.0 / deviation  # steepness of g beside its peak
        self._width = min(1.0, _DEVIATIONS * deviation)
        self._losses: dict[float, _Losses] = {}
        self._coefficient = _MOMENT
        self._rounding = ROUNDING_FLOOR
        self._steepest = 0.0
        q = law.quadrature  # bounces that keep the speed change nothing
        self._kappa = law.mean_log_loss / float(q.weight[q.log_loss > 0.0].sum())
        self._march(min(_SHALLOW - math.log(rtol), DEEPEST))

    def _march(self, depth: float) -> None:
        """The axis from where F is e^-depth of its bulk down to its bulk."""
        # one panel of a guess: exp(-e^x/kappa) times a power of the speed, nearly. The next one is
        # polluted by it, and lies above all that is asked for as well
        self._depth = depth
        self._norm: float | None = None
        start, log_g, power, bend = self._beginning()
        self._top = start + self._width
        up = self._width * self._rule.local
        rate = math.exp(start) / self._kappa
        guess = log_g + start + (power + 0.5 * bend * up) * up - rate * np.expm1(up)
        self._panels = [guess]  # ln w of each, (nodes,), from the top down
        self._last: list[float] = []  # their last coefficients
        while self._bottom > -_DEVIATIONS / self._flank and self._add_panel():
            pass
        last = max(self._last[1:], default=1.0)
        nodes = 2 * self._rule.nodes
        missed = _DENSITY * last > max(self.rtol, ROUNDING_FLOOR)
        if self._own_nodes and missed and nodes <= MOST_NODES:
            # a narrow part of g beside a wide one, as of mixtures
            self._rule, self._losses = Chebyshev(nodes), {}
            self.__dict__.pop("_gauss", None)
            self._march(depth)
            return
        self._bulk = float(self._log_g(np.zeros(1))[0])  # ln F there, up to a constant

    def _deepened(self) -> bool:
        """Marched again, from as far out as F is given; False if that has been done."""
        if self._depth == DEEPEST:
            return False
        self._march(DEEPEST)
        return True

    def _beginning(self) -> tuple[float, float, float, float]:
        """Where the march begins: x, ln g nearly, and two derivatives of ln w + e^x/kappa."""
        law, q = self.law, self.law.quadrature
        depth = self._depth + _SHALLOW - math.log(self.rtol)
        z = np.geomspace(0.02 * self._flank, _STEEPEST * self._flank + 4.0 * depth, 120)
        rate = -np.expm1(-np.multiply.outer(z, q.log_loss)) @ q.weight
        x = np.log(law.mean_log_loss * z / rate)
        log_g = -np.cumsum(z * np.diff(x, prepend=0.0))
        # a panel above where F is that small
        start = float(x[np.argmax(log_g - law.dimension * x < -depth)]) + self._width
        step = 0.01 * self._width
        two = np.array([start, start + step])
        slope = np.interp(two, x, z)
        for _ in range(5):  # averages by few points are a percent off there
            slope = np.exp(two) / law.mean_log_loss * law.decay_symbol(slope)
        power = np.exp(two) / self._kappa + 1.0 - slope
        bend = float(power[1] - power[0]) / step
        return start, float(np.interp(start, x, log_g)), float(power[0]), bend

    # -- what is asked for --------------------------------------------------------------------

    @property
    def nodes(self) -> int:
        """Nodes of all panels so far."""
        return len(self._panels) * self._rule.nodes

    @property
    def error_estimate(self) -> float:
        """From the last Chebyshev coefficients of ln w, A(1) = A(0), and the rounding floor."""
        last = max(self._last[1:], default=0.0)
        with np.errstate(over="ignore"):
            unit = _MOMENT * last + abs(math.expm1(min(self.log_moment(1.0), 1.0)))
        found = 5.0 * _SHARE * self.rtol + self._coefficient * last + self._rounding
        found += unit * (1.0 + 0.5 * self._steepest)
        return max(found, 1.0) if self.unresolved else found

    def log_moment(self, p: float) -> float:
        """ln A(p), the average of e^(p x)."""
        found = self._log_sum(p)  # which may begin the march again
        if self._norm is None:
            self._norm = self._log_sum(0.0)
        return found - self._norm

    def _log_sum(self, p: float) -> float:
        """ln of the integral of e^(p x) g, the whole axis."""
        self._rounding = max(self._rounding, abs(p) * ROUNDING_FLOOR)
        lacks = math.log(_SHARE * self.rtol)
        node, weight, rows = self._gauss
        while True:
            left = self._top - self._width * np.arange(1.0, len(self._panels) + 1)
            x = left[:, None] + self._width * node
            size = p * x + self._log_g_at_nodes @ rows
            largest = float(size.max())
            if not abs(largest) < 1e6:
                self.unresolved = True
                return 0.0
            if float(size[:2].max()) > largest + lacks:
                if self._deepened():
                    continue
                self.unresolved = True
            done = float(size[-1].max()) < largest + lacks
            if done or largest - self._bulk > 2.0 * LARGEST_LOG or not self._extend():
                break
        total = self._width * float(np.exp(size - largest).sum(axis=0) @ weight)
        if self._is_power:
            log_share = p * self._bottom + float(self._log_g_at_nodes[-1, 0]) - largest
            total += math.exp(log_share) / (p - self.law.lowest_power)
        if not total > 0.0:
            self.unresolved = True
            return 0.0
        return largest + math.log(total)

    def log_density(self, x: FloatArray) -> FloatArray:
        """ln g at x, shape (n,), g of integral 1.

        -inf where F is below that of the bulk by e^-230.
        """
        if x.size == 0:
            return np.zeros(0)
        d, lowest = self.law.dimension, float(x.min())
        while self._bottom > lowest:
            log_f = float(self._panels[-1].max()) - (d + 1) * self._bottom
            if (log_f < self._bulk - DEEPEST and not self.law.reaches_rest) or not self._extend():
                break
        out = np.full(x.shape, -math.inf)
        inside = x < self._top - 2.0 * self._width
        inside &= (x >= self._bottom) | self._is_power
        out[inside] = self._log_g(x[inside])
        with np.errstate(invalid="ignore"):
            far = out - d * x < self._bulk - self._depth
        if np.any(far & (x > 0.0)) and self._deepened():
            return self.log_density(x)
        out[far & (out - d * x < self._bulk - DEEPEST)] = -math.inf
        self._coefficient = _DENSITY
        there = x[np.isfinite(out)]
        if there.size:
            step = 0.1 / self._flank
            ends = np.array([there.min(), there.min() + step, there.max() - step, there.max()])
            slopes = np.abs(np.diff(self._log_g(ends))[::2]) / step
            self._steepest = max(self._steepest, float(np.max(slopes)))
            # a narrow density has rounding of its own, as large as on its flanks
            floor = (self._steepest + self._flank) * ROUNDING_FLOOR
            self._rounding = max(self._rounding, floor)
        return out - (self._log_sum(0.0) if self._norm is None else self._norm)

    @cached_property
    def _gauss(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Points and weights of a panel in a moment, and the way there, (nodes, points)."""
        node, weight = gauss_legendre(40)
        return node, weight, self._rule.rows(node).T

    @property
    def _log_g_at_nodes(self) -> FloatArray:
        """ln g of all panels, (n_panels, nodes)."""
        begin = self._top - self._width * np.arange(1.0, len(self._panels) + 1)
        return np.array(self._panels) - begin[:, None] - self._width * self._rule.local

    def _log_g(self, x: FloatArray) -> FloatArray:
        """ln g at x (n,), below the top."""
        level = (self._top - np.maximum(x, self._bottom)) / self._width
        i = np.minimum(level.astype(int), len(self._panels) - 1)
        log_g = np.sum(self._rule.rows(i + 1.0 - level) * self._log_g_at_nodes[i], axis=1)
        if self._is_power:
            log_g -= self.law.lowest_power * np.minimum(x - self._bottom, 0.0)
        return np.asarray(log_g)

    @property
    def _is_power(self) -> bool:
        """Whether g is a power of v t/l below the bottom."""
        limit = math.log(_SHARE * self.rtol * self.law.mean_log_loss)
        return self.law.reaches_rest and self._bottom < limit

    def _extend(self) -> bool:
        """One panel further down; False where that is not needed, or does not go."""
        if self._is_power:
            return False
        if self._bottom < -2.0 * LARGEST_LOG or not self._add_panel():
            self.unresolved = True
            return False
        return True

    # -- the march ----------------------------------------------------------------------------

    @property
    def _bottom(self) -> float:
        return self._top - len(self._panels) * self._width

    @np.errstate(over="ignore", invalid="ignore")  # of too few nodes
    def _add_panel(self) -> bool:
        """One panel further down; False where the equations of too few nodes have no solution."""
        n, law, last = self._rule.nodes - 1, self.law, self._panels[-1]
        x = self._bottom - self._width * (1.0 - self._rule.local)
        log_w = self._guess(last)
        losses = self._losses_of(x, -float(self._rule.derivative[0] @ last) / self._width)
        per_flux = np.exp(x[:n]) / law.mean_log_loss
        flux = per_flux[:, None] * losses.flux
        lost = np.expm1(x[:n]) - per_flux * losses.flux_out
        guess = log_w[:n]
        from_above = np.zeros(n)  # what flux brings from panels above, over e^guess
        for m in range(1, min(losses.furthest, len(self._panels)) + 1):
            node, flux_in, rows = losses.outside(m)
            w = np.exp(rows @ self._panels[-m] - guess[node])
            from_above += np.bincount(node, flux_in * w, n)
        from_above *= per_flux
        for _ in range(30):  # one to four are taken
            above = from_above * np.exp(guess - log_w[:n])
            rise = (losses.rows @ (log_w - log_w[:-1, None])[:, :, None])[:, :, 0]
            matrix = np.matmul((flux * np.exp(rise))[:, None, :], losses.rows)[:, 0, :]
            own = lost + (flux * np.expm1(rise)).sum(axis=1) - matrix.sum(axis=1)
            matrix[np.arange(n), np.arange(n)] += own
            try:  # w over the guess, which is 1 at the highest node
                q = np.linalg.solve(matrix[:, :n], -above - matrix[:, n])
            except np.linalg.LinAlgError:
                return False
            if not np.all(np.isfinite(q)):
                return False
            change = np.log(np.maximum(q, 0.05))  # where nothing is found, or less
            log_w = log_w + np.append(change, 0.0)
            # the sweeps are Newton's method: the next change would be the square of this one
            if float(np.abs(change).max()) < math.sqrt(_SHARE * self.rtol):
                break
        self._panels.append(log_w)
        self._last.append(float(np.max(self._rule.last_coefficients(log_w))))
        return True

    def _guess(self, last: FloatArray) -> FloatArray:
        """ln w of the next panel, from the last one: ln w + e^x/kappa goes on as a parabola."""
        up = self._width * self._rule.local
        three = [0, up.size // 2, up.size - 1]
        at = self._rule.local[three]
        rate = math.exp(self._bottom) / self._kappa
        smooth = last[three] + rate * np.expm1(up[three])
        ahead = self._rule.local[:, None] - 1.0 - at
        log_w = interpolation_rows(ahead, barycentric_weights(at)) @ smooth
        log_w -= rate * np.expm1(up - self._width)
        return np.asarray(log_w + (last[0] - log_w[-1]))

    def _losses_of(self, x: FloatArray, slope: float) -> _Losses:
        """The losses, resolved as a panel at x (nodes,) needs them; of most panels the same."""
        law = self.law
        unit = min(_RESOLVED / min(1.0, law.largest_loss), _STEEPEST * self._flank)
        finer = max(0, math.ceil(math.log2(max(slope, 1.0) / unit)))
        # far up only small losses count
        key, reach = 0.0, math.inf
        if finer:
            key, reach = x[0], math.log1p(FOLDS * self._kappa * math.exp(-x[0]))
        if key not in self._losses:
            rate = unit * 2.0**finer
            self._losses[key] = _Losses(law, self._rule, self._width, rate, reach)
        return self._losses[key]
