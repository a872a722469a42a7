"""The scaled velocity distribution from the discretised solver: F(c), h, a2 and moments.

:class:`ScaledVDF` solves the tilts (:mod:`kinetics.tilt`) that a question needs, glues them where
two neighbours resolve g equally well, and continues below them by recursion
(:mod:`kinetics.low_speeds`). What it then holds is ln g, accurate relative to g on the whole axis;
moments are sums of positive terms.
"""

from __future__ import annotations

import enum
import itertools
import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics.collision import CollisionLaw
from kinetics.errors import InputError, check_restitution, check_rtol, short
from kinetics.low_speeds import LowSpeeds
from kinetics.tilt import MAX_NODES, SMALLEST_NODES, Tilt, next_tilt, solve_tilt

FloatArray = NDArray[np.float64]

# The first tilt. Not an integer: at integers the zero mode of the scheme reproduces
# lambda(p) E[Y^(p+1)] = p E[Y^p] whatever the resolution, and would hide an error.
_FIRST_TILT = 1.7
_LOWEST_LOG = -690.0  # F below e^-690 is 0
_LOWEST_TAIL = -1e5  # ln g down to which the tail amplitude may look
_TAIL_POINTS = 9
_NEGLIGIBLE = 38.0  # e^-38: the share of a moment that its ends may hold


class SolverStatus(enum.Enum):
    """How a solve ended; the text says what to change."""

    CONVERGED = "the error estimate meets rtol"
    TOLERANCE_NOT_REACHED = "the error estimate exceeds rtol: ask for a larger rtol or more nodes"


def _between(low: Tilt, high: Tilt) -> float:
    """The point as many deviations above one tilt's centre as below the other's."""
    share = low.deviation / (low.deviation + high.deviation)
    return low.centre + share * (high.centre - low.centre)


def _crossing(low: Tilt, high: Tilt) -> tuple[float, float]:
    """Where two tilts see g equally far below their peaks, and the offset of their scales there.

    Found from a first guess at the offset, which hardly matters.
    """
    x = _between(low, high)
    for _ in range(3):
        offset = _offset(low, high, x)
        gap = (high.peak + offset) - low.peak
        new = gap / (high.theta - low.theta)
        if not low.centre < new < high.centre:
            break
        x = new
    return x, _offset(low, high, x)


def _offset(low: Tilt, high: Tilt, x: float) -> float:
    """Difference of the logarithms that two tilts see at x; NaN where neither is resolved."""
    at = np.array([x])
    with np.errstate(invalid="ignore"):
        return float((low.log_density(at) - high.log_density(at))[0])


def _disagreement(low: Tilt, high: Tilt) -> float:
    """Relative difference of the shapes of g that two neighbours see between their centres."""
    middle, _ = _crossing(low, high)
    around = middle + np.array([-0.5, 0.5]) * min(low.deviation, high.deviation)
    seen = [t.log_density(around) for t in (low, high)]
    if not np.all(np.isfinite(seen)):
        return 1.0
    # both have a part in it
    return 0.5 * abs(float((seen[0][1] - seen[0][0]) - (seen[1][1] - seen[1][0])))


@dataclass(frozen=True)
class ScaledVDF:
    """The scaled velocity distribution as the discretised solver finds it.

    Normalised as the paper's F: integral of 2 pi c F(c) dc = 1 and <c^2> = 1. Built by
    :func:`solve_scaled`; only the part of the speed axis that a question needs is solved.

    Attributes
    ----------
    restitution : e, 0 <= e < 1
    rtol : the relative accuracy asked for
    requested_nodes : nodes of each tilt, or None for the solver's own choice
    """

    restitution: float
    rtol: float
    requested_nodes: int | None = None
    _tilts: list[Tilt] = field(default_factory=list, repr=False, compare=False)
    _scale: list[float] = field(default_factory=list, repr=False, compare=False)
    _low: list[LowSpeeds] = field(default_factory=list, repr=False, compare=False)
    _sampled: dict[str, Any] = field(default_factory=dict, repr=False, compare=False)

    @cached_property
    def law(self) -> CollisionLaw:
        """The collision law of this restitution."""
        return CollisionLaw(self.restitution)

    @cached_property
    def cooling_rate(self) -> float:
        """h(e) = M2/2 (paper, label ``compare2``), from v0 = 2 l/(h t) in the scaling state."""
        return 2.0 * self.law.mean_log_loss * math.exp(-0.5 * self._log_second)

    @cached_property
    def a2(self) -> float:
        """<c^4>/2 - 1 (paper, label ``sonine5``)."""
        return 0.5 * self.moment(4.0) - 1.0

    def moment(self, p: float) -> float:
        """<c^p> for real p (p > -1 at e = 0); InputError elsewhere or where it overflows."""
        try:
            number = float(p)
        except (TypeError, ValueError):
            number = math.nan
        if not abs(number) <= 300.0:
            raise InputError(f"p: got {short(p)}; it must be a real number of size up to 300")
        if self.restitution == 0.0 and number <= -1.0:
            raise InputError(f"p: got {short(p)}; at restitution 0 moments exist for p > -1 only")
        log_moment = self._log_moment(number) - 0.5 * number * self._log_second
        if log_moment > 709.0:
            raise InputError(f"p: got {short(p)}; <c^p> overflows double precision there")
        return math.exp(log_moment)

    def vdf(self, c: ArrayLike) -> Any:
        """F(c), same shape as c; InputError for c negative or not finite.

        The error is relative to F(c) itself, in both tails; where F < 1e-299 it is 0. At e = 0,
        F is infinite at c = 0.
        """
        c_ = np.asarray(c, dtype=float)
        if not np.all(np.isfinite(c_)) or np.any(c_ < 0.0):
            raise InputError(f"c: got {short(c)}; a scaled speed must be finite and not negative")
        flat = c_.ravel()
        out = np.full(flat.shape, math.inf if self.restitution == 0.0 else 0.0)
        inside = flat > 0.0
        log_c = np.log(flat[inside])
        log_g = self._log_density(log_c + 0.5 * self._log_second) - self._log_norm
        with np.errstate(under="ignore"):
            out[inside] = np.exp(log_g - 2.0 * log_c) / (2.0 * math.pi)
        return out.reshape(c_.shape)[()]

    @cached_property
    def log_tail_amplitude(self) -> float:
        """ln A in F(c) ~ A c^(1/(1-e^2) - 2) exp(-2 c/h), from F between e^-100 and e^-700 or so.

        Absolute error about 1e-8, for e up to 0.95: InputError above, where the asymptotic form
        starts beyond the smallest numbers.
        """
        if self.restitution > 0.95:
            raise InputError(
                f"restitution: got {self.restitution!r}; the solver finds the tail amplitude up "
                "to 0.95, ScalingSolution has it everywhere"
            )
        b = 1.0 / ((1.0 - self.restitution) * (1.0 + self.restitution))
        # the rest is a series in 1/Y, Y = v t/l: a polynomial through Chebyshev points in 1/Y
        highest = 100.0 + 40.0 * b * b
        k = np.arange(_TAIL_POINTS)
        inverse = (0.6 - 0.4 * np.cos((k + 0.5) * math.pi / _TAIL_POINTS)) / (0.2 * highest)
        y = 1.0 / inverse
        x = np.log(y) + math.log(self.law.mean_log_loss)
        self._cover_above(float(x.max()), floor=_LOWEST_TAIL)
        rest = self._log_density(x) - self._log_norm - b * np.log(y) + y
        at_zero = np.array([np.prod(inverse[k != j] / (inverse[k != j] - inverse[j])) for j in k])
        log_y = float(at_zero @ rest)
        stretch = 0.5 * self._log_second - math.log(self.law.mean_log_loss)  # ln sqrt(E[Y^2])
        return log_y + b * stretch - math.log(2.0 * math.pi)

    @property
    def nodes(self) -> int:
        """Nodes of the speed axis, over all that was solved so far."""
        return sum(t.grid.nodes for t in self._tilts)

    @property
    def error_estimate(self) -> float:
        """Relative error of the results, over all that was solved so far.

        The largest of each tilt's defect, window ends and highest modes, and of the disagreement
        of neighbours about the shape of F between their centres.
        """
        estimates = [t.error for t in self._tilts]
        if "unresolved" in self._sampled:
            estimates.append(1.0)  # too few nodes to go on: part of the axis is missing
        estimates += [_disagreement(a, b) for a, b in itertools.pairwise(self._tilts)]
        return max(estimates)

    @property
    def status(self) -> SolverStatus:
        """Whether :attr:`error_estimate` meets rtol."""
        if self.error_estimate <= self.rtol:
            return SolverStatus.CONVERGED
        return SolverStatus.TOLERANCE_NOT_REACHED

    # -- moments ------------------------------------------------------------------------------

    @cached_property
    def _log_second(self) -> float:
        """Log of A(2) = kappa^2 <(v t/l)^2>."""
        return self._log_moment(2.0)

    @cached_property
    def _log_norm(self) -> float:
        """What A(0) comes to before the norm A(0) = 1 is imposed."""
        return self._log_sum(0.0)

    def _log_moment(self, p: float) -> float:
        """Log A(p), A(p) = E[(kappa v t/l)^p]."""
        return self._log_sum(p) - self._log_norm

    def _log_sum(self, p: float) -> float:
        """Log of the integral of e^(p x) g, by the trapezoid rule on the whole axis."""
        self._extend_for_moment(p)
        x, log_g, spacing = self._samples()
        if self.restitution == 0.0:
            # there g ~ e^x: the grid goes on below what is solved until e^((1+p) x) is negligible
            more = math.ceil(_NEGLIGIBLE / (1.0 + p) / spacing)
            below = x[0] - spacing * np.arange(more, 0, -1)
            x = np.concatenate([below, x])
            log_g = np.concatenate([self._log_density(below), log_g])
        terms = p * x + log_g
        largest = float(terms.max())
        if not math.isfinite(largest):
            self._sampled["unresolved"] = True
            return 0.0
        return largest + math.log(float(np.exp(terms - largest).sum()) * spacing)

    def _extend_for_moment(self, p: float) -> None:
        """Solve further up and down until e^(p x) g has fallen to e^-38 at both ends."""
        while True:
            peak = max(
                t.landmarks[1] + a + p * t.centre
                for t, a in zip(self._tilts, self._scale, strict=True)
            )
            high = self._tilts[-1]
            fallen = high.landmarks[2] + self._scale[-1] + p * high.top < peak - _NEGLIGIBLE
            if fallen or not self._add_above():
                break
        while True:
            end = self._log_at_bottom() + p * self._bottom
            if end < peak - _NEGLIGIBLE or not self._add_below():
                break
            peak = max(peak, end)

    def _samples(self) -> tuple[FloatArray, FloatArray, float]:
        """Equidistant x over all that is solved, ln g there, and the spacing."""
        state = (len(self._tilts), self._bottom)
        if self._sampled.get("state") != state:
            # the trapezoid rule needs half the points that resolve the density
            spacing = min(t.grid.spacing for t in self._tilts)
            count = math.ceil((self._top - self._bottom) / spacing)
            x = np.linspace(self._bottom, self._top, count)
            self._sampled.update(state=state, value=(x, self._log_density(x), x[1] - x[0]))
        value: tuple[FloatArray, FloatArray, float] = self._sampled["value"]
        return value

    # -- the axis, piece by piece -------------------------------------------------------------

    def _solve(self, theta: float) -> Tilt:
        return solve_tilt(self.law, theta, self.rtol, self.requested_nodes)

    def _start(self) -> None:
        self._tilts.append(self._solve(_FIRST_TILT))
        self._scale.append(0.0)

    @property
    def _top(self) -> float:
        return self._tilts[-1].top

    @property
    def _bottom(self) -> float:
        return self._low[0].bottom if self._low else self._tilts[0].bottom

    def _log_at_bottom(self) -> float:
        if self._low:
            return self._low[0].log_at_bottom
        return self._tilts[0].landmarks[0] + self._scale[0]

    def _add_above(self) -> bool:
        """The next tilt up; False where too few nodes were asked for to find it."""
        theta = next_tilt(self.law, self._tilts[-1], above=True)
        tilt = None if theta is None else self._solve(theta)
        scale = math.nan
        if tilt is not None:
            scale = self._scale[-1] + _crossing(self._tilts[-1], tilt)[1]
        if tilt is None or not math.isfinite(scale + sum(tilt.landmarks[1:])):
            self._sampled["unresolved"] = True
            return False
        self._scale.append(scale)
        self._tilts.append(tilt)
        return True

    def _add_below(self) -> bool:
        """One piece further down; False where F = g/(2 pi c^2) is below e^-690."""
        if self._log_at_bottom() - 2.0 * self._bottom < _LOWEST_LOG - 50.0:
            return False
        if self._low:
            self._low[0].extend(self._bottom - 4.0)
            return True
        known = self._tilts[0]
        theta = next_tilt(self.law, known, above=False)
        if theta is not None:
            tilt = self._solve(theta)
            scale = self._scale[0] - _crossing(tilt, known)[1]
            if not math.isfinite(scale + sum(tilt.landmarks[:2])):
                self._sampled["unresolved"] = True
                return False
            self._tilts.insert(0, tilt)
            self._scale.insert(0, scale)
            return True
        if self.restitution == 0.0:
            return False  # integrated in closed form, see _log_density
        # the sweeps of the recursion converge as e^top
        top = max(min(known.centre, -1.0), known.bottom)
        self._low.append(LowSpeeds(self.law, top, self._log_density_above))
        self._low[0].extend(known.bottom - 2.0)
        return True

    def _cover_above(self, x: float, floor: float = _LOWEST_LOG) -> None:
        """Solve upwards until x is reached, or g there is below e^floor."""
        while self._top < x and self._tilts[-1].landmarks[1] + self._scale[-1] > floor:
            if not self._add_above():
                return

    def _log_density_above(self, x: FloatArray) -> FloatArray:
        """Log g for the recursion: solved down to e^-150, continued by e^(-e^x/kappa) beyond."""
        self._cover_above(float(x.max()), floor=-150.0)
        top = self._top
        out = self._log_density(np.minimum(x, top))
        above = np.exp(np.clip(x, top, 300.0)) - math.exp(top)
        out = out - above / self.law.mean_log_loss
        if not np.all(np.isfinite(out)):
            self._sampled["unresolved"] = True
        return np.asarray(
            np.nan_to_num(out, nan=_LOWEST_LOG, posinf=_LOWEST_LOG, neginf=_LOWEST_LOG)
        )

    def _cover_below(self, x: float) -> None:
        while self._bottom > x and self._add_below():
            pass

    def _log_density(self, x: FloatArray) -> FloatArray:
        """Log g at x = ln(kappa v t/l), shape (n,), up to the norm; -inf where it is negligible."""
        out = np.full(x.shape, -math.inf)
        if x.size == 0:
            return out
        self._cover_above(float(x.max()))
        if float(x.min()) < self._bottom:
            self._cover_below(float(x.min()))
        # the tilt that sees g at x nearest to its own peak
        theta = np.array([t.theta for t in self._tilts])
        peak = np.array([t.peak + a for t, a in zip(self._tilts, self._scale, strict=True)])
        chosen = (np.multiply.outer(x, theta) - peak).argmax(axis=1)
        if self._low:
            chosen[x < self._low[0].top] = -1
        for i, tilt in enumerate(self._tilts):
            mine = (chosen == i) & (x >= tilt.grid.start) & (x <= tilt.grid.end)
            if np.any(mine):
                out[mine] = tilt.log_density(x[mine]) + self._scale[i]
        if self._low:
            low = self._low[0]
            mine = (chosen == -1) & (x >= low.bottom)
            if np.any(mine):
                out[mine] = low.log_density(x[mine])
        if self.restitution == 0.0:
            # below the lowest tilt the flux equation is g = e^x (integral of g from x upwards)
            base = self._tilts[0]
            mine = x < base.bottom
            fall = np.exp(x[mine]) - math.exp(base.bottom)
            out[mine] = self._log_at_bottom() + (x[mine] - base.bottom) - fall
        return out


def solve_scaled(restitution: float, rtol: float = 1e-12, nodes: int | None = None) -> ScaledVDF:
    """Solve the scaled inelastic Lorentz equation (paper, label ``ifmu2``).

    Parameters
    ----------
    restitution : e, 0 <= e < 1
    rtol : relative accuracy asked of h, a2, the moments and F(c), 1e-14 to 0.1
    nodes : nodes of each tilt, for convergence studies; chosen from rtol by default

    Returns
    -------
    ScaledVDF : with the names of :class:`kinetics.ScalingSolution`, and ``nodes``,
        ``error_estimate``, ``status``

    Raises
    ------
    InputError (a ValueError) : restitution not in [0, 1), rtol or nodes out of range

    >>> vdf = solve_scaled(restitution=0.7)
    >>> round(vdf.cooling_rate, 12), vdf.status.name
    (0.412181911126, 'CONVERGED')
    """
    e = check_restitution(restitution)
    if e == 1.0:
        raise InputError(
            f"restitution: got {restitution!r}; elastic tracers approach no scaling state, "
            "it must be below 1"
        )
    if nodes is not None and (
        isinstance(nodes, bool)
        or not isinstance(nodes, int | np.integer)
        or not SMALLEST_NODES <= nodes <= MAX_NODES
    ):
        raise InputError(
            f"nodes: got {short(nodes)}; it must be an integer from {SMALLEST_NODES} to {MAX_NODES}"
        )
    solution = ScaledVDF(e, check_rtol(rtol), None if nodes is None else int(nodes))
    solution._start()
    return solution
