"""ln g on the whole axis: the tilts that a question needs, joined, and the recursion below them.

Each tilt (:mod:`kinetics.scaling.tilted`) resolves g around its own peak. Two neighbours are joined
where both of them resolve it, and the recursion of :mod:`kinetics.scaling.low_speeds` continues
below the lowest. ln g is then accurate relative to g, and moments are sums of positive terms.
"""

from __future__ import annotations

import math

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.numerics import FloatArray
from kinetics.scaling.low_speeds import LowSpeeds
from kinetics.scaling.tilted import Tilt, next_tilt, solve_tilt

# The first tilt. Not an integer: at integers the zero mode of the scheme reproduces
# lambda(p) E[Y^(p+1)] = p E[Y^p] whatever the resolution, and would hide an error. Just below 0: at
# small e the norm needs the long tail to low speeds, and the moments 0 to 4 need no other tilt.
_FIRST_TILT = -0.05
DEEPEST = 230.0  # e^-230 = 1e-100: F further below that of its bulk is not solved for
_PERIOD = np.array([1.0, 2.0, 2.0, 2.0, 1.0]) / 8.0  # trapezoid rule over two half periods
_BEYOND = 30.0  # e-folds further down, so that F ends and not the axis
_NEGLIGIBLE = 4.0  # e^-4 = 2 % of rtol: what lies beyond the speeds that are solved may weigh that
_NOISE = 0.3  # of a tilt at the ends of its window, relative to the error of its peak
# Below this floor no accuracy is promised. Rounding moves the axis by it, and F by that times its
# steepness; ln <c^p> by p times as much. Ten times the largest that was found, 6.5 epsilon for e
# from .9 to 1 - 1e-10, disks and spheres, OpenBLAS's kernels for SkylakeX, Haswell and Nehalem.
ROUNDING_FLOOR = 64 * float(np.finfo(float).eps)  # 1.4e-14


class SpeedAxis:
    """ln g(x), x = ln(kappa v t/l), as far as it was asked for; up to its norm.

    Parameters
    ----------
    law : the collision law; not elastic
    rtol : relative accuracy of g and of its moments
    nodes : of each tilt, or None for as many as rtol takes

    Attributes
    ----------
    tilts : those solved so far, upwards
    scales : what to add to the logarithm of each; 0 for the first one solved, that of the bulk
    unresolved : whether part of the axis is missing, because too few nodes were asked for
    """

    def __init__(self, law: CollisionLaw, rtol: float, nodes: int | None = None) -> None:
        self.law = law
        self.rtol = rtol
        self.requested_nodes = nodes
        self.tilts = [solve_tilt(law, _FIRST_TILT, rtol, nodes)]
        self.scales = [0.0]
        self._bulk = 0  # index of the first one solved
        self._seams: list[float] = []  # x where neighbours meet
        self._disagreements: list[float] = []  # relative difference of neighbours there
        self._low: LowSpeeds | None = None
        bulk = self.tilts[0]
        # ln F of the bulk, up to a constant
        self._bulk_log = bulk.landmarks[1] - law.dimension * bulk.centre
        self.unresolved = False
        self._moved = 0.0  # relative error of densities by that of the unit of speed
        self._rounding = ROUNDING_FLOOR  # of all that was asked for
        self._lost = 0.0  # relative error of moments that reach beyond all that can be solved
        self._sampled: tuple[FloatArray, FloatArray, float] | None = None

    @property
    def error_estimate(self) -> float:
        """Relative error of the results, over all that was solved so far."""
        estimates = [t.discretisation_error for t in self.tilts]
        estimates += [self._lost, 1.0 if self.unresolved else 0.0]
        # what two tilts disagree by at a seam has the rounding in it
        seams = max(sum(self._disagreements), self._rounding)
        return max(estimates) + seams + self._moved

    # -- moments ------------------------------------------------------------------------------

    def log_sum(self, p: float, share: float = 1.0) -> float:
        """ln of the integral of e^(p x) g, by the trapezoid rule, to ``share`` of the accuracy."""
        self._rounding = max(self._rounding, abs(p) * ROUNDING_FLOOR)
        self._extend_for_moment(p, share * self.rtol)
        x, log_g, spacing = self._samples()
        if self._reaches_rest:
            # there g ~ e^(q x): the grid goes on below until e^((q+p) x) is negligible
            depth = math.log(1.0 / self.rtol) + _NEGLIGIBLE
            more = math.ceil(depth / (p - self.law.lowest_power) / spacing)
            below = x[0] - spacing * np.arange(more, 0, -1)
            x = np.concatenate([below, x])
            log_g = np.concatenate([self._power_of_speed(below), log_g])
        terms = p * x + log_g
        largest = float(terms.max())
        if not math.isfinite(largest):
            self.unresolved = True
            return 0.0
        terms = np.exp(terms - largest)
        if self.law.returns(0)[0]:
            # among scatterers that are met again g changes sign below all that is trusted
            low = x < self._bottom
            unit = np.exp(p * x[low] + self.scales[0] - largest)
            terms[low] = self.tilts[0].density(x[low]) * unit
        return largest + math.log(float(terms.sum()) * spacing)

    @property
    def _reaches_rest(self) -> bool:
        """Whether bounces come as near to rest as one likes: g is a power of speed low down."""
        return self.law.reaches_rest

    def _extend_for_moment(self, p: float, accepted: float) -> None:
        """Solve further up and down until the noise of the last tilts is negligible."""
        if self._reaches_rest:
            while self._add_below():
                pass
        while True:
            high = self.tilts[-1]
            lost = self._lost_by(high, self.scales[-1], p, high.grid.end)
            if p <= high.theta or lost < accepted:
                break
            if not self._add_above():
                self._lost = max(self._lost, min(lost, 1.0))
                break
        while True:
            if self._low is not None and not self._reaches_rest:
                end = self._log_at_bottom() + p * self._bottom
                depth = math.log(1.0 / self.rtol) + _NEGLIGIBLE
                if end < self._peak(p) - depth or not self._add_below():
                    break
                continue
            low = self.tilts[0]
            if p >= low.theta or self._reaches_rest:
                break
            lost = self._lost_by(low, self.scales[0], p, low.grid.start)
            if lost < accepted or not self._add_below():
                break

    def _peak(self, p: float) -> float:
        """ln of the maximum of e^(p x) g, nearly."""
        return max(
            t.landmarks[1]
            + scale
            + p * t.centre
            + 0.5 * min(t.span, abs(p - t.theta) * t.deviation) ** 2
            for t, scale in zip(self.tilts, self.scales, strict=True)
        )

    def _lost_by(self, tilt: Tilt, scale: float, p: float, x: float) -> float:
        """What the noise of a tilt at x adds to moment p, relative to it."""
        peak = tilt.landmarks[1] + tilt.theta * tilt.centre + scale
        log_lost = peak + (p - tilt.theta) * x - self._peak(p)
        return _NOISE * tilt.noise * math.exp(min(log_lost, 600.0))

    def _samples(self) -> tuple[FloatArray, FloatArray, float]:
        """Equidistant x over all that is solved, ln g there, and the spacing."""
        if self._sampled is None:
            if len(self.tilts) == 1 and self._low is None and not self._reaches_rest:
                only = self.tilts[0]
                self._sampled = (only.grid.x, only.log_at_nodes, only.grid.spacing)
                return self._sampled
            bottom = self._bottom
            if self._low is None and not self._reaches_rest:
                bottom = self.tilts[0].grid.start
            top = float(self.tilts[-1].grid.x[-1])  # beyond, the window begins again
            if not top > bottom:  # too few nodes
                self.unresolved = True
                top = bottom + 1.0
            spacing = min(t.grid.spacing for t in self.tilts)
            x = np.linspace(bottom, top, math.ceil((top - bottom) / spacing) + 1)
            self._sampled = (x, self._joined(x), float(x[1] - x[0]))
        return self._sampled

    # -- the axis, piece by piece -------------------------------------------------------------

    @property
    def _bottom(self) -> float:
        return self.tilts[0].bottom if self._low is None else self._low.bottom

    def _log_at_bottom(self) -> float:
        if self._low is not None:
            return self._low.log_at_bottom
        return self.tilts[0].landmarks[0] + self.scales[0]

    def _join(self, low: Tilt, high: Tilt) -> tuple[float, float, float]:
        """Where two tilts meet, the difference of their logarithms there, and its error."""
        reach = low.span * low.deviation
        share = reach / (reach + high.span * high.deviation)
        x = low.centre + share * (high.centre - low.centre)
        # over a period of the highest modes, whose noise has no part in the average
        around = x + np.linspace(-0.5, 0.5, 5) * (low.grid.spacing + high.grid.spacing)
        with np.errstate(invalid="ignore"):
            gap = low.log_density(around) - high.log_density(around)
        if not np.all(np.isfinite(gap)):
            return x, math.nan, 1.0
        return x, float(_PERIOD @ gap), float(gap.max() - gap.min())

    def _add_above(self) -> bool:
        """The next tilt up; False where too few nodes were asked for to find it."""
        known = self.tilts[-1]
        theta = next_tilt(self.law, known, self.rtol, above=True)
        if theta is not None:
            tilt = solve_tilt(self.law, theta, self.rtol, self.requested_nodes)
            x, gap, spread = self._join(known, tilt)
            if math.isfinite(gap + sum(tilt.landmarks[1:])):
                self.tilts.append(tilt)
                self.scales.append(self.scales[-1] + gap)
                self._seams.append(x)
                self._disagreements.append(spread)
                self._sampled = None
                return True
        self.unresolved = True
        return False

    def _add_below(self) -> bool:
        """One piece further down; False where that is far enough, or F is not known there."""
        reached = self._log_at_bottom() - self.law.dimension * self._bottom
        if reached < self._bulk_log - DEEPEST - _BEYOND or self.law.uniform_power:
            return False  # with a uniform power of s it is known, see _power_of_speed
        if self.law.returns(0)[0]:
            return False  # what slow tracers do among scatterers that are met again is not known
        self._sampled = None
        if self._low is not None:
            bottom = self._bottom
            if self._low.top - bottom > 500.0:  # F has long ended: too few nodes made another
                self.unresolved = True
                return False
            self._low.extend(bottom - 4.0)
            return self._bottom < bottom
        known, theta = self.tilts[0], None
        if not self._reaches_rest:
            theta = next_tilt(self.law, known, self.rtol, above=False)
        if theta is None:
            # the sweeps of the recursion converge as e^top
            top = max(min(known.centre, -1.0), known.bottom)
            self._low = LowSpeeds(self.law, top, self._log_density_above, self.rtol)
            self._low.extend(known.bottom - 2.0)
            return True
        tilt = solve_tilt(self.law, theta, self.rtol, self.requested_nodes)
        x, gap, spread = self._join(tilt, known)
        if not math.isfinite(gap + sum(tilt.landmarks[:2])):
            self.unresolved = True
            return False
        self._bulk += 1
        self.tilts.insert(0, tilt)
        self.scales.insert(0, self.scales[0] - gap)
        self._seams.insert(0, x)
        self._disagreements.append(spread)
        return True

    def _cover_above(self, x: float, depth: float = DEEPEST + _BEYOND) -> None:
        """Solve upwards until x is reached, or F there is below that of the bulk by e^-depth."""
        while (top := self.tilts[-1].top) < x:
            log_f = self.tilts[-1].landmarks[1] + self.scales[-1] - self.law.dimension * top
            if log_f < self._bulk_log - depth or not self._add_above():
                return

    def _log_density_above(self, x: FloatArray) -> FloatArray:
        """ln g for the recursion: continued by e^(-e^x/kappa) where it does not matter."""
        self._cover_above(float(x.max()), _NEGLIGIBLE - math.log(self.rtol))
        top = self.tilts[-1].top
        above = np.exp(np.clip(x, top, 300.0)) - math.exp(top)
        out = self._joined(np.minimum(x, top)) - above / self.law.mean_log_loss
        if np.all(np.isfinite(out)):
            return np.asarray(out)
        self.unresolved = True
        return np.where(np.isfinite(out), out, -2.0 * DEEPEST)

    def log_density(self, x: FloatArray) -> FloatArray:
        """ln g at x, (n,), up to the norm; -inf beyond what is solved, NaN where not known."""
        if x.size == 0:
            return np.zeros(0)
        self._cover_above(float(x.max()))
        lowest = float(x.min())
        while self._bottom > lowest and self._add_below():
            pass
        out = self._joined(x)
        out[out - self.law.dimension * x < self._bulk_log - DEEPEST] = -math.inf
        steepest = self._steepest(x, out)
        self._moved = max(self._moved, steepest * self.unit_error)
        # a narrow density has rounding of its own: 1/deviation is the steepness of its flanks
        steepest += 1.0 / self.tilts[self._bulk].deviation
        self._rounding = max(self._rounding, steepest * ROUNDING_FLOOR)
        if self.law.returns(0)[0]:
            out[x < self._bottom] = math.nan
        return out

    def _steepest(self, x: FloatArray, log_g: FloatArray) -> float:
        """The largest |d ln g/dx| at x, (n,): at the lowest or the highest where g is not 0."""
        there = x[np.isfinite(log_g)]
        if there.size == 0:
            return 0.0
        low, high = float(there.min()), float(there.max())
        step = 0.1 * self.tilts[self._bulk].deviation
        ends = self._joined(np.array([low, low + step, high - step, high]))
        slopes = np.abs(np.diff(ends)[::2]) / step
        return float(np.max(slopes, initial=0.0, where=np.isfinite(slopes)))

    @property
    def unit_error(self) -> float:
        """Estimate of the error of ln sqrt(E[Y^2]), by which F(c) is moved along the axis."""
        bulk = self.tilts[self._bulk]
        # an error of the same size all over the window, of opposite sign on the two sides
        half = min(bulk.centre - bulk.grid.start, bulk.grid.end - bulk.centre)
        return _NOISE * bulk.noise * half**2 / (math.sqrt(2.0 * math.pi) * bulk.deviation)

    def _joined(self, x: FloatArray) -> FloatArray:
        """ln g at x, shape (n,), from what is solved so far; -inf elsewhere."""
        out = np.full(x.shape, -math.inf)
        chosen = np.searchsorted(self._seams, x)
        if self._low is not None:
            chosen[x < self._low.top] = -1
        elif self._reaches_rest:
            chosen[x < self.tilts[0].bottom] = -1
        for i, tilt in enumerate(self.tilts):
            mine = (chosen == i) & (x >= tilt.grid.start) & (x <= tilt.grid.x[-1])
            if np.any(mine):
                out[mine] = tilt.log_density(x[mine]) + self.scales[i]
        mine = chosen == -1
        if np.any(mine):
            if self._reaches_rest:
                below = mine & (x < self._bottom)
                out[below] = self._power_of_speed(x[below])
            if self._low is not None:
                mine &= x >= self._low.bottom
                out[mine] = self._low.log_density(x[mine])
        return out

    def _power_of_speed(self, x: FloatArray) -> FloatArray:
        """ln g below all that is solved, where bounces come as near to rest as one likes: q x.

        With the next factor, exp(-q e^x), where it is known in closed form: s^q uniform.
        """
        base = self._bottom if self._low is None else self._low.lowest_node
        q = -self.law.lowest_power
        out = self._log_at_bottom() + q * (x - base)
        if self.law.uniform_power:
            out = out - q * (np.exp(x) - math.exp(base))
        return np.asarray(out)
