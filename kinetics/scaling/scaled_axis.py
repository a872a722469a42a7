r"""ln g on the axis x = ln(kappa v t/l) and its moments, as far as they are asked for.

v is the speed, t the time, l the mean free path, kappa = E[-ln s], and g the density of x. It is
solved from the top down (:mod:`kinetics.scaling.density_march`). The march begins not far above the
moments, and once more at 1e-100 of the bulk if a question reaches beyond; it goes down as far as a
question needs. Begin with :meth:`ScaledSpeedAxis.log_moment`.
"""

from __future__ import annotations

import math
from threading import RLock

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.numerics import LARGEST_LOG, ROUNDING, FloatArray
from kinetics.numerics.gauss import gauss_legendre
from kinetics.scaling.density_march import (
    FORGOTTEN_WITHIN,
    MOMENT_POINTS,
    SHARE_OF_TOLERANCE,
    DensityMarch,
    MarchProblem,
)

#: Depth in ln F of the longest march. Chosen: below 1e-100 of its bulk F is not given.
MAX_DEPTH = 100.0 * math.log(10.0)
#: Fewest nodes of a panel that can be asked for. Chosen: about one for each digit, and fewer than
#: eight digits say little.
MIN_NODES = 8
#: Most nodes of a panel. Chosen: it bounds the work.
MAX_NODES = 256
#: Nodes of a panel beyond one for each digit of rtol. Chosen: at half and at twice the error of F
#: stays below 0.3 rtol, and at twice the time is a quarter longer.
NODES_BEYOND_DIGITS = 6

#: Error of F over the last coefficients of ln w, at most. Measured against the closed form for 6 to
#: 18 nodes, e from 0 to 0.99, rough disks and two ratios.
DENSITY_ERROR_FACTOR = 0.15
#: The same for moments. Origin not recorded.
MOMENT_ERROR_FACTOR = 1e-3
#: Relative error (1.4e-14) below which no accuracy is promised: rounding moves the axis by it, and
#: F by that times its steepness. Measured: ten times the largest that was found for e from 0.9 to
#: 1 - 1e-10, on three processors.
ROUNDING_FLOOR = 64 * ROUNDING
#: Largest |ln| of an integrand that is trusted: beyond, too few nodes have gone wild. Chosen.
MAX_LOG_INTEGRAND = 1e6
#: Step, in deviations, of the differences that give the steepness of ln g. Chosen: at half and at
#: twice nothing changes.
STEEPNESS_STEP = 0.1


class ScaledSpeedAxis:
    """ln g(x), x = ln(kappa v t/l), as far down as it was asked for; safe on threads.

    Parameters
    ----------
    law : the collision law
    rtol : relative accuracy of g and of its moments
    nodes : of each panel, or None for as many as rtol takes

    Attributes
    ----------
    is_unresolved : whether nothing is known, because too few nodes were asked for
    """

    def __init__(self, law: CollisionLaw, rtol: float, nodes: int | None = None) -> None:
        self.is_unresolved = False
        self._law = law
        self._rtol = rtol
        self._chooses_nodes = nodes is None
        self._lock = RLock()
        # what enters the error estimate, by what was asked for so far
        self._error_factor = MOMENT_ERROR_FACTOR
        self._rounding = ROUNDING_FLOOR
        self._steepness = 0.0
        if nodes is None:
            nodes = NODES_BEYOND_DIGITS + math.ceil(-math.log10(rtol))
        self._problem = MarchProblem(law, rtol, nodes)
        self._start_march(min(FORGOTTEN_WITHIN - math.log(rtol), MAX_DEPTH))

    # -- the march --------------------------------------------------------------------------------

    def _start_march(self, depth: float) -> None:
        """March from where F is e^-depth of its bulk down to its bulk."""
        self._march = DensityMarch(self._problem, depth)
        while self._needs_more_nodes():
            # a narrow part of g beside a wide one, as of mixtures
            self._problem = MarchProblem(self._law, self._rtol, 2 * self._problem.nodes)
            self._march = DensityMarch(self._problem, depth)
        self._log_norm: float | None = None
        self._log_bulk = float(self._march.log_g(np.zeros(1))[0])  # ln F, up to a constant

    def _needs_more_nodes(self) -> bool:
        """Return whether twice as many nodes are allowed, and needed for F at rtol."""
        if not self._chooses_nodes or 2 * self._problem.nodes > MAX_NODES:
            return False
        last = max(self._march.last_coefficients[1:], default=1.0)
        return DENSITY_ERROR_FACTOR * last > max(self._rtol, ROUNDING_FLOOR)

    def _march_from_further_up(self) -> bool:
        """March again, from as far out as F is given; return False if that has been done."""
        if self._march.depth == MAX_DEPTH:
            return False
        self._start_march(MAX_DEPTH)
        return True

    def _extend(self) -> bool:
        """Add a panel below; return False where that is not needed, or has no solution."""
        if self._march.is_power_below:
            return False
        if self._march.bottom < -2.0 * LARGEST_LOG or not self._march.add_panel():
            self.is_unresolved = True
            return False
        return True

    # -- moments ----------------------------------------------------------------------------------

    def log_moment(self, p: float) -> float:
        """Return ln A(p), the average of e^(p x)."""
        with self._lock:
            log_integral = self._log_integral(p)  # which may begin the march again
            return log_integral - self._log_of_norm()

    def _log_of_norm(self) -> float:
        """Return ln of the integral of g."""
        if self._log_norm is None:
            self._log_norm = self._log_integral(0.0)
        return self._log_norm

    def _log_integral(self, p: float) -> float:
        """Return ln of the integral of e^(p x) g over the whole axis."""
        self._rounding = max(self._rounding, abs(p) * ROUNDING_FLOOR)
        negligible = math.log(SHARE_OF_TOLERANCE * self._rtol)
        while True:
            log_integrand = self._log_integrand(p)
            largest = float(log_integrand.max())
            if not abs(largest) < MAX_LOG_INTEGRAND:
                self.is_unresolved = True
                return 0.0
            if float(log_integrand[:2].max()) > largest + negligible:
                if self._march_from_further_up():
                    continue
                self.is_unresolved = True
            if float(log_integrand[-1].max()) < largest + negligible:
                break
            if largest - self._log_bulk > 2.0 * LARGEST_LOG or not self._extend():
                break
        return self._log_sum(p, log_integrand, largest)

    def _log_integrand(self, p: float) -> FloatArray:
        """Return ln of e^(p x) g at the Gauss points of all panels, (n_panels, n_points)."""
        march = self._march
        width = self._problem.width
        node, _ = gauss_legendre(MOMENT_POINTS)
        lower_ends = march.top - width * np.arange(1.0, len(march.log_w) + 1)
        x = lower_ends[:, None] + width * node
        return p * x + march.log_g_at_nodes @ self._problem.rows_at_moment_points

    def _log_sum(self, p: float, log_integrand: FloatArray, largest: float) -> float:
        """Return ln of the integral from its integrand, of which the largest is given."""
        _, weight = gauss_legendre(MOMENT_POINTS)
        of_points = np.exp(log_integrand - largest).sum(axis=0) @ weight
        total = self._problem.width * float(of_points)
        march = self._march
        if march.is_power_below:
            log_at_bottom = p * march.bottom + float(march.log_g_at_nodes[-1, 0]) - largest
            total += math.exp(log_at_bottom) / (p - self._law.lowest_power)
        if not total > 0.0:
            self.is_unresolved = True
            return 0.0
        return largest + math.log(total)

    # -- the density ------------------------------------------------------------------------------

    def log_density(self, x: FloatArray) -> FloatArray:
        """Return ln g at x, shape (n,), g of integral 1.

        It is -inf where F is below that of the bulk by e^-230.
        """
        if x.size == 0:
            return np.zeros(0)
        with self._lock:
            self._extend_to(float(x.min()))
            log_g = self._solved_log_g(x)
            with np.errstate(invalid="ignore"):
                log_f = log_g - self._law.dimension * x
                is_above_start = (log_f < self._log_bulk - self._march.depth) & (x > 0.0)
            if np.any(is_above_start) and self._march_from_further_up():
                return self.log_density(x)
            with np.errstate(invalid="ignore"):
                log_g[log_f < self._log_bulk - MAX_DEPTH] = -math.inf
            self._note_steepness(x[np.isfinite(log_g)])
            return log_g - self._log_of_norm()

    def _extend_to(self, lowest: float) -> None:
        """Add panels down to the lowest x, or to where F is not given."""
        while self._march.bottom > lowest:
            highest_log_w = float(self._march.log_w[-1].max())
            log_f = highest_log_w - (self._law.dimension + 1) * self._march.bottom
            is_below_depth = log_f < self._log_bulk - MAX_DEPTH
            if (is_below_depth and not self._law.reaches_rest) or not self._extend():
                break

    def _solved_log_g(self, x: FloatArray) -> FloatArray:
        """Return ln g at x, not normalised; -inf beyond what has been solved."""
        march = self._march
        log_g = np.full(x.shape, -math.inf)
        is_solved = x < march.top - 2.0 * self._problem.width
        is_solved &= (x >= march.bottom) | march.is_power_below
        log_g[is_solved] = march.log_g(x[is_solved])
        return log_g

    def _note_steepness(self, x: FloatArray) -> None:
        """Take into the error estimate how steep ln g is at the ends of x, where it is finite."""
        self._error_factor = DENSITY_ERROR_FACTOR
        if x.size == 0:
            return
        flank = self._problem.flank
        step = STEEPNESS_STEP / flank
        ends = np.array([x.min(), x.min() + step, x.max() - step, x.max()])
        slopes = np.abs(np.diff(self._march.log_g(ends))[::2]) / step
        self._steepness = max(self._steepness, float(np.max(slopes)))
        # a narrow density has rounding of its own, as large as on its flanks
        floor = (self._steepness + flank) * ROUNDING_FLOOR
        self._rounding = max(self._rounding, floor)

    # -- how well it is known ---------------------------------------------------------------------

    @property
    def nodes(self) -> int:
        """Nodes of all panels so far."""
        return len(self._march.log_w) * self._problem.nodes

    @property
    def error_estimate(self) -> float:
        """From the last Chebyshev coefficients of ln w, A(1) = A(0), and the rounding floor."""
        with self._lock:
            last = max(self._march.last_coefficients[1:], default=0.0)
            with np.errstate(over="ignore"):
                log_first = min(self.log_moment(1.0), 1.0)
            of_unit = MOMENT_ERROR_FACTOR * last + abs(math.expm1(log_first))
            error = 5.0 * SHARE_OF_TOLERANCE * self._rtol + self._error_factor * last
            error += self._rounding
            error += of_unit * (1.0 + 0.5 * self._steepness)
            return max(error, 1.0) if self.is_unresolved else error
