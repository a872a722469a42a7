"""The scaled velocity distribution from the discretised solver: F(c), h, a2 and moments.

:class:`ScaledVDF` puts its questions to a :class:`kinetics.scaling.log_density.SpeedAxis`, which
solves the parts of the speed axis that they need and holds ln g, accurate relative to g.
"""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kinetics.collision import CollisionLaw
from kinetics.errors import InputError, check_restitution, check_rtol, short
from kinetics.scaling.log_density import SpeedAxis
from kinetics.scaling.tilted import MAX_NODES, SMALLEST_NODES

_LOWEST_TAIL = -1e5  # ln g down to which the tail amplitude may look
_TAIL_POINTS = 9


class SolverStatus(enum.Enum):
    """How a solve ended; the text says what to change."""

    CONVERGED = "the error estimate meets rtol"
    TOLERANCE_NOT_REACHED = "the error estimate exceeds rtol: ask for a larger rtol or more nodes"


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

    @cached_property
    def law(self) -> CollisionLaw:
        """The collision law of this restitution."""
        return CollisionLaw(self.restitution)

    @cached_property
    def _axis(self) -> SpeedAxis:
        return SpeedAxis(self.law, self.rtol, self.requested_nodes)

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

        The error is relative to F(c) itself, in both tails; where F < 1e-299 it is 0. (Where
        F < 1e-80 and e is close to 1 it may be three times what was asked.) At e = 0, F is
        infinite at c = 0.
        """
        c_ = np.asarray(c, dtype=float)
        if not np.all(np.isfinite(c_)) or np.any(c_ < 0.0):
            raise InputError(f"c: got {short(c)}; a scaled speed must be finite and not negative")
        flat = c_.ravel()
        out = np.full(flat.shape, math.inf if self.restitution == 0.0 else 0.0)
        inside = flat > 0.0
        log_c = np.log(flat[inside])
        log_second, log_norm = self._unit()
        refined = self._axis.refined
        log_g = self._axis.log_density(log_c + 0.5 * log_second) - log_norm
        if self._axis.refined != refined:
            log_second, log_norm = self._unit()
            log_g = self._axis.log_density(log_c + 0.5 * log_second) - log_norm
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
        self._axis.cover_above(float(x.max()), floor=_LOWEST_TAIL)
        rest = self._axis.log_density(x) - self._log_norm - b * np.log(y) + y
        at_zero = np.array([np.prod(inverse[k != j] / (inverse[k != j] - inverse[j])) for j in k])
        log_y = float(at_zero @ rest)
        stretch = 0.5 * self._log_second - math.log(self.law.mean_log_loss)  # ln sqrt(E[Y^2])
        return log_y + b * stretch - math.log(2.0 * math.pi)

    @property
    def nodes(self) -> int:
        """Nodes of the speed axis, over all that was solved so far."""
        return sum(t.grid.nodes for t in self._axis.tilts)

    @property
    def error_estimate(self) -> float:
        """Relative error of the results, over all that was solved so far.

        The largest of each tilt's defect, window ends and highest modes, of the disagreement of
        neighbours about the shape of F where they meet, and of what moments lose to noise.
        """
        return self._axis.error_estimate

    @property
    def status(self) -> SolverStatus:
        """Whether :attr:`error_estimate` meets rtol."""
        if self.error_estimate <= self.rtol:
            return SolverStatus.CONVERGED
        return SolverStatus.TOLERANCE_NOT_REACHED

    @cached_property
    def _log_second(self) -> float:
        """Log of A(2) = kappa^2 <(v t/l)^2>: p/2 of its error gets into <c^p>."""
        log_second = self._axis.log_sum(2.0, share=0.25) - self._log_norm
        if abs(log_second) < 50.0:  # A(2) is between 1 and 2
            return log_second
        self._axis.unresolved = True
        return 0.0

    @cached_property
    def _log_norm(self) -> float:
        """What A(0) comes to before the norm A(0) = 1 is imposed."""
        return self._axis.log_sum(0.0)

    def _unit(self) -> tuple[float, float]:
        """Log A(2) and the norm, from what is solved by now."""
        if not self._axis.refined:
            return self._log_second, self._log_norm
        log_norm = self._axis.log_sum(0.0)
        return self._axis.log_sum(2.0) - log_norm, log_norm

    def _log_moment(self, p: float) -> float:
        """Log A(p), A(p) = E[(kappa v t/l)^p]."""
        return self._axis.log_sum(p) - self._log_norm


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
    solution._axis  # noqa: B018
    return solution
