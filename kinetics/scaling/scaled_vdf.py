"""The scaled velocity distribution from the discretised solver: F(c), h, a2 and moments.

:class:`ScaledVDF` puts its questions to a :class:`kinetics.scaling.axis.SpeedAxis`, which
marches down the speed axis as far as they need and holds ln g, accurate relative to g.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kinetics.collision import CollisionLaw
from kinetics.errors import SolverStatus, judged
from kinetics.numerics import LARGEST_LOG, FloatArray
from kinetics.results.record import stored_class
from kinetics.scaling.axis import DEEPEST, FEWEST_NODES, MOST_NODES, SpeedAxis
from kinetics.scaling.scaled_state import ScaledState
from kinetics.validation import check_rtol, not_negative, refuse, whole_number


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class ScaledVDF(ScaledState):
    """The scaled velocity distribution as the discretised solver finds it.

    Built by :func:`solve_scaled`; only the part of the speed axis that a question needs is solved.
    A value: equal to another one if it was asked for with the same arguments. A file that
    :meth:`save` writes holds these arguments, h and a2; what else is asked of the loaded one is
    solved again.

    rtol : the relative accuracy asked for
    requested_nodes : nodes of each panel of the axis, or None for the solver's own choice
    """

    rtol: float = 1e-12
    requested_nodes: int | None = None

    @cached_property
    def _axis(self) -> SpeedAxis:
        return SpeedAxis(self.law, self.rtol, self.requested_nodes)

    @cached_property
    def cooling_rate(self) -> float:
        """h(e) = M2/2 (paper, label ``compare2``), from v0 = 2 l/(h t) in the scaling state."""
        return 2.0 * self.law.mean_log_loss * math.exp(-0.5 * self._log_second)

    @cached_property
    def a2(self) -> float:
        """<c^4> d/(d+2) - 1 (paper, label ``sonine5``)."""
        return self.dimension / (self.dimension + 2.0) * self.moment(4.0) - 1.0

    def moment(self, p: float) -> float:
        """<c^p> for real p above ``law.lowest_power``; InputError elsewhere or on overflow."""
        number = self._checked_power(p)
        return self._moment_from_log(
            p, self._axis.log_moment(number) - 0.5 * number * self._log_second
        )

    def vdf(self, c: ArrayLike) -> Any:
        """F(c), same shape as c, accurate relative to F(c) itself in both tails.

        F(0) is 0 unless bounces come as near to rest as one likes; at e = 0 it is infinite. Raises
        InputError for c negative or not finite, and where F is below 1e-100 of that of the bulk:
        :class:`kinetics.ScalingSolution` has it there.
        """
        c_ = not_negative("c", c)
        found = self.reached_vdf(c_)
        beyond = (found == 0.0) & (c_ > 0.0)
        if np.any(beyond):
            far = "F is below 1e-100 of its largest there, which only ScalingSolution gives"
            refuse("c", float(c_[beyond].flat[0]), far)
        return found[()]

    def reached_vdf(self, c: FloatArray) -> FloatArray:
        """The same for speeds that are known to be good; 0 where the solver does not reach."""
        flat, out = self._speeds_from_rest(c.ravel())
        inside = flat > 0.0
        log_c = np.log(flat[inside])
        log_g = self._axis.log_density(log_c + 0.5 * self._log_second)
        log_f = log_g - self.dimension * log_c
        with np.errstate(under="ignore"):
            # more than the largest number only if nodes that were given are far too few
            out[inside] = np.exp(np.minimum(log_f, LARGEST_LOG)) / self.law.unit_surface
        return out.reshape(c.shape)

    def _tabulated_vdf(self, c: FloatArray) -> FloatArray:
        return self.reached_vdf(c)

    @property
    def nodes(self) -> int:
        """Nodes of the speed axis, over all that was solved so far."""
        return self._axis.nodes

    @property
    def error_estimate(self) -> float:
        """Relative error of the results, over all that was solved so far.

        From the last Chebyshev coefficients of the density on each panel, from A(1) = A(0), and
        from what the error of the unit of speed makes of F(c) where F is steep, with a floor for
        rounding: 1.4e-14 times the larger of p for <c^p> and |d ln F/d ln c| for F(c).
        """
        return self._axis.error_estimate

    @property
    def status(self) -> SolverStatus:
        """Whether :attr:`error_estimate` meets rtol."""
        return self._verdict[0]

    @property
    def message(self) -> str:
        """The status in words: by how much the tolerance is missed, and what to change."""
        return self._verdict[1]

    @property
    def _verdict(self) -> tuple[SolverStatus, str]:
        return judged({"F(c)": self.error_estimate}, {"F(c)": self.rtol}, self.requested_nodes)

    def __repr__(self) -> str:
        return (
            f"ScaledVDF({self.law.described}, rtol={self.rtol!r}): h = {self.cooling_rate:.12g}, "
            f"a2 = {self.a2:.12g}, {self.status.name.lower()}, error estimate "
            f"{self.error_estimate:.1e}"
        )

    def _figures(self) -> dict[str, str]:
        about = {"status": self.status.name.lower(), "error": f"{self.error_estimate:.1e}"}
        return super()._figures() | about

    def _to_storage(self) -> dict[str, Any]:
        return super()._to_storage() | {"cooling_rate": self.cooling_rate, "a2": self.a2}

    @classmethod
    def _from_storage(cls, parts: dict[str, Any]) -> ScaledVDF:
        known = {name: parts.pop(name) for name in ("cooling_rate", "a2")}
        found = cls(**parts)
        found.__dict__.update(known)  # as if they had been asked for
        return found

    @cached_property
    def _log_second(self) -> float:
        """Log of A(2) = kappa^2 <(v t/l)^2>: p/2 of its error gets into <c^p>."""
        log_second = self._axis.log_moment(2.0)
        if abs(log_second) < 50.0:  # A(2) is between 1 and 2
            return log_second
        self._axis.unresolved = True
        return 0.0


def solve_scaled(
    restitution: float | CollisionLaw, rtol: float = 1e-12, nodes: int | None = None,
    tangential_restitution: float = 1.0, dimension: int = 2, scatterers: str = "dilute",
    number_density: float | None = None, diameter: float = 1.0, density_order: str = "second",
    mass_ratio: float = math.inf,
) -> ScaledVDF:  # fmt: skip
    """Solve the scaled inelastic Lorentz equation (paper, label ``ifmu2``).

    restitution : e, 0 <= e < 1 for smooth scatterers; or a :class:`kinetics.CollisionLaw`
    rtol : relative accuracy asked of h, a2, the moments and F(c), 1e-14 to 0.1; below 1.4e-14 times
        the steepness |d ln F/d ln c| nothing is promised, and the status says so
    nodes : nodes of each panel of the axis, 8 to 256, for convergence studies
    tangential_restitution, dimension, mass_ratio, scatterers ... : as in
        :class:`kinetics.ScalingSolution`, but dilute scatterers only

    Returns a ScaledVDF: the names of :class:`kinetics.ScalingSolution`, and ``nodes``,
    ``error_estimate``, ``status``. Raises InputError (a ValueError) for a law that is elastic or
    may leave less than 1e-100 of a speed (but 0), and for an argument out of range.

    >>> vdf = solve_scaled(restitution=0.7)
    >>> round(vdf.cooling_rate, 12), vdf.status.name
    (0.412181911126, 'CONVERGED')
    """
    solution = ScaledVDF(
        restitution, tangential_restitution, dimension, scatterers, number_density, diameter,
        density_order, mass_ratio, check_rtol(rtol),
        None if nodes is None else whole_number("nodes", nodes, FEWEST_NODES, MOST_NODES),
    )  # fmt: skip
    law = solution.law
    if law.medium is not None:
        allowed = "the solver takes 'dilute'; ScalingSolution has the others"
        refuse("scatterers", scatterers, allowed)
    if law.is_elastic:
        allowed = "elastic tracers approach no scaling state, it must be below 1"
        refuse("restitution", restitution, allowed)
    if DEEPEST < law.largest_loss < math.inf:  # at e = 1e-120 <c^-2> is wrong, at 1e-250 all
        allowed = "the solver takes 0, or speed ratios of 1e-100 at least; ScalingSolution all"
        refuse("restitution", restitution, allowed)
    solution._axis  # noqa: B018  (an error of the arguments must be raised here)
    return solution
