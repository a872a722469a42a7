"""The scaled velocity distribution from the discretised solver: F(c), h, a2 and moments.

The solver needs no closed form: it integrates the paper's scaled equation (label ``ifmu2``) down
the axis of speeds, x = ln(kappa v t/l). :class:`ScaledVDF` puts its questions to a
:class:`kinetics.scaling.scaled_axis.ScaledSpeedAxis`, which goes down as far as they need and holds
ln g, accurate relative to g. Begin with :func:`solve_scaled`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kinetics.collision import CollisionLaw
from kinetics.errors import SolverStatus, judge_errors
from kinetics.numerics import LARGEST_LOG, FloatArray
from kinetics.results.record import stored_class
from kinetics.scaling.scaled_axis import MAX_DEPTH, MAX_NODES, MIN_NODES, ScaledSpeedAxis
from kinetics.scaling.scaled_state import ScaledState
from kinetics.validation import check_rtol, not_negative, refuse, whole_number

#: Largest |ln A(2)| that is trusted: beyond, too few nodes have gone wild. Chosen: A(2) itself is
#: between 1 and 2.
MAX_LOG_SECOND_MOMENT = 50.0


@dataclass(frozen=True)
class SavedFigures:
    """The figures that a file holds, so that they are not solved again by what reads it."""

    cooling_rate: float
    a2: float


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class ScaledVDF(ScaledState):
    """The scaled velocity distribution as the discretised solver finds it.

    Built by :func:`solve_scaled`; only those speeds that a question needs are solved. A value: two
    of them are equal if they were asked for with the same arguments. A file that :meth:`save`
    writes holds these arguments, h and a2; what else is asked of the loaded one is solved again.

    Parameters
    ----------
    restitution ... mass_ratio : as of :func:`solve_scaled`
    rtol : the relative accuracy asked for
    requested_nodes : nodes of each panel of the axis, or None for the solver's own choice
    """

    rtol: float = 1e-12
    requested_nodes: int | None = None
    _saved: SavedFigures | None = field(default=None, init=False, repr=False, compare=False)

    @cached_property
    def _axis(self) -> ScaledSpeedAxis:
        """The axis of speeds, as far as it has been solved."""
        return ScaledSpeedAxis(self.law, self.rtol, self.requested_nodes)

    # -- averages ---------------------------------------------------------------------------------

    @cached_property
    def cooling_rate(self) -> float:
        """h(e) = M2/2 (paper, label ``compare2``), from v0 = 2 l/(h t) in the scaling state."""
        if self._saved is not None:
            return self._saved.cooling_rate
        return 2.0 * self.law.mean_log_loss * math.exp(-0.5 * self._log_second_moment)

    @cached_property
    def a2(self) -> float:
        """<c^4> d/(d+2) - 1 (paper, label ``sonine5``)."""
        if self._saved is not None:
            return self._saved.a2
        return self.dimension / (self.dimension + 2.0) * self.moment(4.0) - 1.0

    def moment(self, p: float) -> float:
        """Return <c^p> for real p, |p| <= 300.

        Raises
        ------
        InputError
            p is not above ``law.lowest_power``, or the moment overflows.
        """
        power = self._checked_power(p)
        log_moment = self._axis.log_moment(power) - 0.5 * power * self._log_second_moment
        return self._moment_from_log(p, log_moment)

    @cached_property
    def _log_second_moment(self) -> float:
        """ln A(2), A(2) = kappa^2 <(v t/l)^2>: p/2 of its error gets into <c^p>."""
        log_second_moment = self._axis.log_moment(2.0)
        if abs(log_second_moment) < MAX_LOG_SECOND_MOMENT:
            return log_second_moment
        self._axis.is_unresolved = True
        return 0.0

    # -- the distribution -------------------------------------------------------------------------

    def vdf(self, c: ArrayLike) -> Any:
        """Return F(c), same shape as c, accurate relative to F(c) itself in both tails.

        F(0) is 0 unless bounces come as near to rest as one likes; at e = 0 it is infinite.

        Raises
        ------
        InputError
            A speed is negative or not finite; or F is below 1e-100 of that of the bulk there, where
            only :class:`kinetics.ScalingSolution` has it.
        """
        speeds = not_negative("c", c)
        density = self.reached_vdf(speeds)
        is_beyond = (density == 0.0) & (speeds > 0.0)
        if np.any(is_beyond):
            allowed = "F is below 1e-100 of its largest there, which only ScalingSolution gives"
            refuse("c", float(speeds[is_beyond].flat[0]), allowed)
        return density[()]

    def reached_vdf(self, c: FloatArray) -> FloatArray:
        """Return F(c) at speeds that are known to be good; 0 where the solver does not reach."""
        speeds, density = self._speeds_from_rest(c.ravel())
        is_moving = speeds > 0.0
        log_c = np.log(speeds[is_moving])
        log_g = self._axis.log_density(log_c + 0.5 * self._log_second_moment)
        log_f = log_g - self.dimension * log_c
        with np.errstate(under="ignore"):
            # more than the largest number only if nodes that were given are far too few
            density[is_moving] = np.exp(np.minimum(log_f, LARGEST_LOG)) / self.law.unit_surface
        return density.reshape(c.shape)

    def _tabulated_vdf(self, c: FloatArray) -> FloatArray:
        """Return F(c) for a dataset, shape of c."""
        return self.reached_vdf(c)

    # -- how well it is known ---------------------------------------------------------------------

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
        status, _ = self._judge()
        return status

    @property
    def message(self) -> str:
        """The status in words: by how much the tolerance is missed, and what to change."""
        _, message = self._judge()
        return message

    def _judge(self) -> tuple[SolverStatus, str]:
        """Return the status and the message."""
        errors = {"F(c)": self.error_estimate}
        return judge_errors(errors, {"F(c)": self.rtol}, self.requested_nodes)

    @property
    def _arguments_shown(self) -> str:
        """The arguments that are not as by default, and rtol."""
        return f"{self.law.described}, rtol={self.rtol!r}"

    @property
    def _accuracy(self) -> str:
        """The status and the error, in words."""
        return f"{self.status.name.lower()}, error estimate {self.error_estimate:.1e}"

    # -- files ------------------------------------------------------------------------------------

    def _to_storage(self) -> dict[str, Any]:
        """Return the arguments, h and a2."""
        return super()._to_storage() | {"cooling_rate": self.cooling_rate, "a2": self.a2}

    @classmethod
    def _from_storage(cls, parts: dict[str, Any]) -> ScaledVDF:
        """Build the value of its arguments, with h and a2 as they were saved."""
        saved = SavedFigures(parts.pop("cooling_rate"), parts.pop("a2"))
        vdf = cls(**parts)
        vdf.store(_saved=saved)
        return vdf


def solve_scaled(
    restitution: float | CollisionLaw,
    rtol: float = 1e-12,
    nodes: int | None = None,
    tangential_restitution: float = 1.0,
    dimension: int = 2,
    scatterers: str = "dilute",
    number_density: float | None = None,
    diameter: float = 1.0,
    density_order: str = "second",
    mass_ratio: float = math.inf,
) -> ScaledVDF:
    """Solve the scaled inelastic Lorentz equation (paper, label ``ifmu2``).

    Parameters
    ----------
    restitution : e, 0 <= e < 1 for smooth scatterers; or a :class:`kinetics.CollisionLaw`
    rtol : relative accuracy asked of h, a2, the moments and F(c), 1e-14 to 0.1; below 1.4e-14 times
        the steepness |d ln F/d ln c| nothing is promised, and the status says so
    nodes : nodes of each panel of the axis, 8 to 256, for convergence studies
    tangential_restitution, dimension, mass_ratio, scatterers ... : as in
        :class:`kinetics.ScalingSolution`, but dilute scatterers only

    Returns
    -------
    ScaledVDF
        The names of :class:`kinetics.ScalingSolution`, and ``nodes``, ``error_estimate``,
        ``status``.

    Raises
    ------
    InputError
        (A ValueError.) The law is elastic or may leave less than 1e-100 of a speed (but 0), or an
        argument is out of range.

    Examples
    --------
    >>> vdf = solve_scaled(restitution=0.7)
    >>> round(vdf.cooling_rate, 12), vdf.status.name
    (0.412181911126, 'CONVERGED')
    """
    requested_nodes = None
    if nodes is not None:
        requested_nodes = whole_number("nodes", nodes, MIN_NODES, MAX_NODES)
    vdf = ScaledVDF(
        restitution,
        tangential_restitution,
        dimension,
        scatterers,
        number_density,
        diameter,
        density_order,
        mass_ratio,
        check_rtol(rtol),
        requested_nodes,
    )
    law = vdf.law
    if law.medium is not None:
        allowed = "the solver takes 'dilute'; ScalingSolution has the others"
        refuse("scatterers", scatterers, allowed)
    if law.is_elastic:
        allowed = "elastic tracers approach no scaling state, it must be below 1"
        refuse("restitution", restitution, allowed)
    if MAX_DEPTH < law.largest_loss < math.inf:  # at e = 1e-120 <c^-2> is wrong, at 1e-250 all
        allowed = "the solver takes 0, or speed ratios of 1e-100 at least; ScalingSolution all"
        refuse("restitution", restitution, allowed)
    vdf._axis  # noqa: B018  (an error of the arguments must be raised here)
    return vdf
