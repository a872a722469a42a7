"""The scaled velocity distribution from the discretised solver: F(c), h, a2 and moments.

:class:`ScaledVDF` puts its questions to a :class:`kinetics.scaling.log_density.SpeedAxis`, which
solves the parts of the speed axis that they need and holds ln g, accurate relative to g.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kinetics.collision import CollisionLaw
from kinetics.numerics.chebyshev import FirstKind
from kinetics.scaling.log_density import SpeedAxis
from kinetics.scaling.tilted import MAX_NODES, SMALLEST_NODES
from kinetics.status import SolverStatus, explain, status_of
from kinetics.validation import (
    check_restitution,
    check_rtol,
    exponent,
    not_negative,
    refuse,
    whole_number,
)
from kinetics.values import Value

_LOWEST_TAIL = -1e5  # ln g down to which the tail amplitude may look
_TAIL_POINTS = 9
_LARGEST_POWER = 300.0
_LARGEST_LOG = 709.0  # ln of the largest number of double precision
_LEAST_RESTITUTION = 1e-100  # above 0: at 1e-120 <c^-2> is wrong, at 1e-250 nothing is solved


@dataclass(frozen=True)
class ScaledVDF(Value):
    """The scaled velocity distribution as the discretised solver finds it.

    Normalised as the paper's F: integral of 2 pi c F(c) dc = 1 and <c^2> = 1. Built by
    :func:`solve_scaled`; only the part of the speed axis that a question needs is solved.

    A value: equal to another one if it was asked for with the same arguments. A file that
    :meth:`save` writes holds these arguments, h and a2; what else is asked of the loaded one is
    solved again, and ``nodes`` and ``error_estimate`` are of what was solved since.

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
        number = exponent("p", p, _LARGEST_POWER)
        if self.restitution == 0.0 and number <= -1.0:
            refuse("p", p, "at restitution 0 moments exist for p > -1 only")
        log_moment = self._log_moment(number) - 0.5 * number * self._log_second
        if log_moment > _LARGEST_LOG:
            refuse("p", p, "<c^p> overflows double precision there")
        return math.exp(log_moment)

    def vdf(self, c: ArrayLike) -> Any:
        """F(c), same shape as c; InputError for c negative or not finite.

        The error is relative to F(c) itself, in both tails; where F < 1e-299 it is 0. The
        rounding of c alone moves F by 2e-16 times |d ln F/d ln c|, which :attr:`error_estimate`
        counts. At e = 0, F is infinite at c = 0.
        """
        c_ = not_negative("c", c)
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
        log_f = log_g - 2.0 * log_c
        if np.any(log_f > _LARGEST_LOG):  # nodes that were given are far too few
            self._axis.unresolved = True
        with np.errstate(under="ignore"):
            out[inside] = np.exp(np.minimum(log_f, _LARGEST_LOG)) / (2.0 * math.pi)
        return out.reshape(c_.shape)[()]

    @cached_property
    def log_tail_amplitude(self) -> float:
        """ln A in F(c) ~ A c^(1/(1-e^2) - 2) exp(-2 c/h), from F between e^-100 and e^-700 or so.

        Absolute error about 1e-8, for e up to 0.95: InputError above, where the asymptotic form
        starts beyond the smallest numbers.
        """
        if self.restitution > 0.95:
            allowed = "the solver finds the amplitude up to 0.95, ScalingSolution everywhere"
            refuse("restitution", self.restitution, allowed)
        b = 1.0 / ((1.0 - self.restitution) * (1.0 + self.restitution))
        # the rest is a series in 1/Y, Y = v t/l: a polynomial through Chebyshev points in 1/Y,
        # from 1/highest to 5/highest, continued to 0
        highest = 100.0 + 40.0 * b * b
        rule = FirstKind(_TAIL_POINTS)
        y = highest / (1.0 + 4.0 * rule.local)
        x = np.log(y) + math.log(self.law.mean_log_loss)
        self._axis.cover_above(float(x.max()), floor=_LOWEST_TAIL)
        rest = self._axis.log_density(x) - self._log_norm - b * np.log(y) + y
        log_y = float((rule.rows(np.array([-0.25])) @ rest)[0])
        stretch = 0.5 * self._log_second - math.log(self.law.mean_log_loss)  # ln sqrt(E[Y^2])
        return log_y + b * stretch - math.log(2.0 * math.pi)

    @property
    def nodes(self) -> int:
        """Nodes of the speed axis, over all that was solved so far."""
        return sum(t.grid.nodes for t in self._axis.tilts)

    @property
    def error_estimate(self) -> float:
        """Relative error of the results, over all that was solved so far.

        The largest of each tilt's defect, window ends and highest modes, and of what moments lose
        to noise; with the disagreement of neighbours about the shape of F where they meet, and
        with what the error of the unit of speed makes of F(c) where F is steep.
        """
        return self._axis.error_estimate

    @property
    def status(self) -> SolverStatus:
        """Whether :attr:`error_estimate` meets rtol."""
        return status_of(*self._errors)

    @property
    def message(self) -> str:
        """The status in words: by how much the tolerance is missed, and what to change."""
        return explain(*self._errors, self.requested_nodes)

    @property
    def _errors(self) -> tuple[dict[str, float], dict[str, float]]:
        return {"F(c)": self.error_estimate}, {"F(c)": self.rtol}

    def __repr__(self) -> str:
        nodes = "" if self.requested_nodes is None else f", nodes={self.requested_nodes}"
        return (
            f"ScaledVDF(restitution={self.restitution!r}, rtol={self.rtol!r}{nodes}): "
            f"h = {self.cooling_rate:.12g}, a2 = {self.a2:.12g}, "
            f"{self.status.name.lower()}, error estimate {self.error_estimate:.1e}"
        )

    def _repr_html_(self) -> str:
        figures = {
            "restitution": self.restitution,
            "cooling rate h": f"{self.cooling_rate:.12g}",
            "a2": f"{self.a2:.12g}",
            "status": self.status.name.lower(),
            "error estimate": f"{self.error_estimate:.1e}",
        }
        rows = "".join(f"<tr><td>{name}</td><td>{v}</td></tr>" for name, v in figures.items())
        return f"<table>{rows}</table>"

    def __getstate__(self) -> dict[str, Any]:
        # with what has been solved: a copy in another process need not solve it again
        return dict(self.__dict__)

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)

    def _to_storage(self) -> dict[str, Any]:
        arguments = {
            "restitution": self.restitution,
            "rtol": self.rtol,
            "requested_nodes": self.requested_nodes,
        }
        return arguments | {"cooling_rate": self.cooling_rate, "a2": self.a2}

    @classmethod
    def _from_storage(cls, parts: dict[str, Any]) -> ScaledVDF:
        known = {name: parts.pop(name) for name in ("cooling_rate", "a2")}
        found = cls(**parts)
        found.__dict__.update(known)  # as if they had been asked for
        return found

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
    InputError (a ValueError) : restitution not 0 and not from 1e-100 to below 1; rtol or nodes out
        of range

    >>> vdf = solve_scaled(restitution=0.7)
    >>> round(vdf.cooling_rate, 12), vdf.status.name
    (0.412181911126, 'CONVERGED')
    """
    e = check_restitution(restitution)
    if e == 1.0:
        allowed = "elastic tracers approach no scaling state, it must be below 1"
        refuse("restitution", restitution, allowed)
    if 0.0 < e < _LEAST_RESTITUTION:
        allowed = f"the solver takes 0, or {_LEAST_RESTITUTION:g} at least; ScalingSolution all"
        refuse("restitution", restitution, allowed)
    if nodes is not None:
        nodes = whole_number("nodes", nodes, SMALLEST_NODES, MAX_NODES)
    solution = ScaledVDF(e, check_rtol(rtol), nodes)
    solution._axis  # noqa: B018  (an error of the arguments must be raised here)
    return solution
