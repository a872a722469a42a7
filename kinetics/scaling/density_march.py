r"""ln w on the axis x = ln(kappa v t/l), solved panel by panel from the top down.

v is the speed, t the time, l the mean free path, s the speed ratio of a collision, and kappa the
mean of -ln s; F is the scaled density of the velocity, and g the density of x. g drifts upwards,
and the flux that passes x is what collisions have brought below x from above (the scaled equation,
paper label ``ifmu2``, integrated once):

    kappa g(x) = int_0^inf P(xi > u) w(x + u) du,     xi = -ln s,

with w = e^x g the rate of collisions: w at x needs w above x only. On Chebyshev panels of one
width, from the top down, each panel is a small linear system for w over a guess of it, from which
ln w follows: the error is relative to w itself, over hundreds of orders of magnitude. What is
assumed above the top is forgotten as F grows. Next to rest, where bounces lead there, g ends as a
power of v t/l. Begin with :meth:`DensityMarch.add_panel`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.numerics import FOLDS, FloatArray
from kinetics.numerics.chebyshev import Chebyshev, barycentric_weights, interpolation_rows
from kinetics.numerics.gauss import gauss_legendre
from kinetics.results.value import Value
from kinetics.scaling.log_moments import small_deviation
from kinetics.scaling.panel_losses import PanelLosses

# At half and at twice each of the numbers below that are chosen, the largest error of
# F and of moments over rtol stays between 0.1 and 0.3 (e from 0 to 0.99, rtol 1e-6 and 1e-12).

#: Width of a panel, in deviations of g where g is narrow; 1 at most. Chosen: at half the time is a
#: quarter longer.
MAX_WIDTH_IN_DEVIATIONS = 5.0
#: Share of rtol that is allowed for each of five small parts of the error: ends of the axis, sweeps
#: and the power law near rest. Chosen: together they are a twentieth of rtol.
SHARE_OF_TOLERANCE = 0.01
#: How much further out than the smallest F that is asked for a march begins, in ln F less ln rtol:
#: what is assumed above its top is forgotten there. Measured: at half and at twice F moves by
#: 9e-15.
FORGOTTEN_WITHIN = 15.0
#: e-folds of w over the losses, or over 1, that the usual quadrature of the losses resolves.
#: Chosen: at twice the error is 0.1 rtol in place of 0.26.
RESOLVED_FOLDS = 15.0
#: Largest steepness of g near e = 1, over 1/deviation. Derived: g is e^-(60^2/2) of its peak there.
MAX_STEEPNESS = 60.0
#: Gauss points of a panel in a moment. Measured: with 20 and with 80 moments move by 4e-15.
MOMENT_POINTS = 40
#: Slopes of ln g at which the start of a march is looked for, their number. Measured: with 60 and
#: with 240 F moves by 1e-14.
N_START_SLOPES = 120
#: Averages by few points are a percent off far out: so often the slope at the start is improved.
#: Measured: with 2 and with 10 F moves by 1e-14; with 10 the time is a fifth longer.
START_SWEEPS = 5
#: Newton steps of a panel, at most. Chosen: one to four are taken.
MAX_SWEEPS = 30
#: Smallest factor by which a Newton step changes w, in place of 0 or less. Chosen: it only keeps w
#: positive; at half and at twice nothing moves.
MIN_CHANGE = 0.05


@dataclass(frozen=True, eq=False, repr=False)
class MarchProblem(Value):
    """What a march down the axis of speeds solves, and on which panels.

    Parameters
    ----------
    law : the collision law
    rtol : relative accuracy of g
    nodes : of each panel
    """

    law: CollisionLaw
    rtol: float
    nodes: int

    @cached_property
    def rule(self) -> Chebyshev:
        """The nodes of a panel, local from 0 to 1."""
        return Chebyshev(self.nodes)

    @cached_property
    def rows_at_moment_points(self) -> FloatArray:
        """Interpolation from the nodes to the Gauss points of a moment, (n_nodes, n_points)."""
        node, _ = gauss_legendre(MOMENT_POINTS)
        return self.rule.rows(node).T

    @cached_property
    def flank(self) -> float:
        """The steepness of ln g beside its peak, 1/deviation."""
        return 1.0 / small_deviation(self.law)

    @cached_property
    def width(self) -> float:
        """The width of a panel in x."""
        return min(1.0, MAX_WIDTH_IN_DEVIATIONS * small_deviation(self.law))

    @cached_property
    def mean_loss_if_any(self) -> float:
        """The mean of -ln s over those bounces that lose speed: the others change nothing."""
        q = self.law.quadrature
        return self.law.mean_log_loss / float(q.weight[q.log_loss > 0.0].sum())

    @property
    def resolved_steepness(self) -> float:
        """The steepness of ln w that the usual quadrature of the losses resolves."""
        of_losses = RESOLVED_FOLDS / min(1.0, self.law.largest_loss)
        return min(of_losses, MAX_STEEPNESS * self.flank)

    @cached_property
    def usual_losses(self) -> PanelLosses:
        """The losses as most panels need them."""
        return PanelLosses(self.law, self.rule, self.width, self.resolved_steepness, math.inf)

    def losses_at(self, x: float, slope: float) -> PanelLosses:
        """Return the losses as a panel needs them.

        Parameters
        ----------
        x : the lower end of the panel
        slope : of -ln w above it
        """
        halvings = math.ceil(math.log2(max(slope, 1.0) / self.resolved_steepness))
        if halvings <= 0:
            return self.usual_losses
        # far up only small losses count
        reach = math.log1p(FOLDS * self.mean_loss_if_any * math.exp(-x))
        rate = self.resolved_steepness * 2.0**halvings
        return PanelLosses(self.law, self.rule, self.width, rate, reach)


@dataclass(frozen=True, eq=False, repr=False)
class MarchStart(Value):
    """What is assumed of w above the top: exp(-e^x/kappa) times a power of the speed, nearly.

    Parameters
    ----------
    x : where it begins
    log_g : ln g there, nearly
    power, bend : first and second derivative of ln w + e^x/kappa in x
    """

    x: float
    log_g: float
    power: float
    bend: float


class DensityMarch:
    """ln w, and with it ln g, on all panels so far, from the top down; g is not normalised.

    Parameters
    ----------
    problem : law, accuracy and panels
    depth : in ln F: the top is where F is e^-depth of its bulk, nearly

    Attributes
    ----------
    top : x of the upper end of the first panel
    log_w : ln w at the nodes of each panel, from the top down
    last_coefficients : the size of the last Chebyshev coefficients of each of them but the first
    """

    def __init__(self, problem: MarchProblem, depth: float) -> None:
        self.problem = problem
        self.depth = depth
        start = self._find_start()
        self.top = start.x + problem.width
        # one panel of a guess. The next one is polluted by it, and lies above all that is asked
        # for as well
        self.log_w = [self._guess_above(start)]
        self.last_coefficients: list[float] = []
        while self.bottom > -MAX_WIDTH_IN_DEVIATIONS / problem.flank and self.add_panel():
            pass

    # -- the top ----------------------------------------------------------------------------------

    def _find_start(self) -> MarchStart:
        """Return where to begin: ln g by the method of steepest descent falls with the slope z."""
        law = self.problem.law
        flank = self.problem.flank
        depth = self.depth + FORGOTTEN_WITHIN - math.log(self.problem.rtol)
        z = np.geomspace(0.02 * flank, MAX_STEEPNESS * flank + 4.0 * depth, N_START_SLOPES)
        q = law.quadrature
        decay_rate = -np.expm1(-np.multiply.outer(z, q.log_loss)) @ q.weight
        x = np.log(law.mean_log_loss * z / decay_rate)  # where the slope of -ln g is z
        log_g = -np.cumsum(z * np.diff(x, prepend=0.0))
        # a panel above where F is that small
        start = float(x[np.argmax(log_g - law.dimension * x < -depth)]) + self.problem.width
        step = 0.01 * self.problem.width
        points = np.array([start, start + step])
        slope = np.interp(points, x, z)
        for _ in range(START_SWEEPS):
            slope = np.exp(points) / law.mean_log_loss * law.decay_symbol(slope)
        power = np.exp(points) / self.problem.mean_loss_if_any + 1.0 - slope
        bend = float(power[1] - power[0]) / step
        return MarchStart(start, float(np.interp(start, x, log_g)), float(power[0]), bend)

    def _guess_above(self, start: MarchStart) -> FloatArray:
        """Return ln w on a panel above the start, shape (n_nodes,)."""
        up = self.problem.width * self.problem.rule.local
        rate = math.exp(start.x) / self.problem.mean_loss_if_any
        smooth = (start.power + 0.5 * start.bend * up) * up
        return start.log_g + start.x + smooth - rate * np.expm1(up)

    # -- one panel further down -------------------------------------------------------------------

    @property
    def bottom(self) -> float:
        """x of the lower end of the last panel."""
        return self.top - len(self.log_w) * self.problem.width

    @np.errstate(over="ignore", invalid="ignore")  # of too few nodes
    def add_panel(self) -> bool:
        """Solve one panel further down; False where too few nodes leave no solution.

        The unknown is w over a guess of it, at all nodes but the top one, which is known. Newton's
        method on ln w takes the solution as the next guess.
        """
        problem = self.problem
        rule = problem.rule
        x = self.bottom - problem.width * (1.0 - rule.local)
        slope = -float(rule.derivative[0] @ self.log_w[-1]) / problem.width
        losses = problem.losses_at(x[0], slope)
        per_flux = np.exp(x[:-1]) / problem.law.mean_log_loss
        log_w = self._guess_below()
        first_guess = log_w[:-1]
        from_above = per_flux * self._flux_from_above(losses, first_guess)
        for _ in range(MAX_SWEEPS):
            of_panel, of_top = self._panel_equations(losses, x[:-1], per_flux, log_w)
            above = from_above * np.exp(first_guess - log_w[:-1])
            try:
                ratio = np.linalg.solve(of_panel, -above - of_top)
            except np.linalg.LinAlgError:
                return False
            if not np.all(np.isfinite(ratio)):
                return False
            change = np.log(np.maximum(ratio, MIN_CHANGE))
            log_w = log_w + np.append(change, 0.0)
            # Newton's method: the next change would be the square of this one
            if float(np.abs(change).max()) < math.sqrt(SHARE_OF_TOLERANCE * problem.rtol):
                break
        self.log_w.append(log_w)
        self.last_coefficients.append(float(np.max(rule.last_coefficients(log_w))))
        return True

    def _guess_below(self) -> FloatArray:
        """Return ln w of the next panel: ln w + e^x/kappa goes on as a parabola."""
        problem = self.problem
        local = problem.rule.local
        up = problem.width * local
        log_w = self.log_w[-1]
        fitted = [0, local.size // 2, local.size - 1]
        rate = math.exp(self.bottom) / problem.mean_loss_if_any
        smooth = log_w[fitted] + rate * np.expm1(up[fitted])
        ahead = local[:, None] - 1.0 - local[fitted]
        guess = interpolation_rows(ahead, barycentric_weights(local[fitted])) @ smooth
        guess -= rate * np.expm1(up - problem.width)
        return np.asarray(guess + (log_w[0] - guess[-1]))

    def _flux_from_above(self, losses: PanelLosses, log_w: FloatArray) -> FloatArray:
        """Return what flux brings from the panels above, over w, at the nodes, (n_nodes - 1,)."""
        flux = np.zeros(log_w.size)
        from_above = losses.from_above(len(self.log_w))
        for upper, of_panel in zip(reversed(self.log_w), from_above, strict=False):
            w_ratio = np.exp(of_panel.rows @ upper - log_w[of_panel.node])
            flux += np.bincount(of_panel.node, of_panel.flux * w_ratio, log_w.size)
        return flux

    def _panel_equations(
        self, losses: PanelLosses, x: FloatArray, per_flux: FloatArray, log_w: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return the linear equations for the ratio of w to a guess of it.

        Parameters
        ----------
        losses : the quadrature of the flux
        x, per_flux : nodes of the panel but the top one, and e^x/kappa there, (n_nodes - 1,)
        log_w : the guess at all nodes, (n_nodes,)

        Returns
        -------
        The matrix, (n_nodes - 1, n_nodes - 1), and what multiplies the known w at the top node,
        whose ratio is 1, (n_nodes - 1,)
        """
        flux = per_flux[:, None] * losses.flux
        rise = (losses.rows @ (log_w - log_w[:-1, None])[:, :, None])[:, :, 0]
        matrix = np.matmul((flux * np.exp(rise))[:, None, :], losses.rows)[:, 0, :]
        # the diagonal is made of small terms: what leaves the panel, and what w changes within it
        leaving = np.expm1(x) - per_flux * losses.flux_beyond_panel
        own = leaving + (flux * np.expm1(rise)).sum(axis=1) - matrix.sum(axis=1)
        nodes = np.arange(x.size)
        matrix[nodes, nodes] += own
        return matrix[:, :-1], matrix[:, -1]

    # -- the solution -----------------------------------------------------------------------------

    @property
    def is_power_below(self) -> bool:
        """Whether g is a power of v t/l below the bottom."""
        law = self.problem.law
        power_law_below = math.log(SHARE_OF_TOLERANCE * self.problem.rtol * law.mean_log_loss)
        return law.reaches_rest and self.bottom < power_law_below

    @property
    def log_g_at_nodes(self) -> FloatArray:
        """ln g at the nodes of all panels, shape (n_panels, n_nodes)."""
        width = self.problem.width
        lower_ends = self.top - width * np.arange(1.0, len(self.log_w) + 1)
        return np.array(self.log_w) - lower_ends[:, None] - width * self.problem.rule.local

    def log_g(self, x: FloatArray) -> FloatArray:
        """Return ln g at x (n,), below the top."""
        level = (self.top - np.maximum(x, self.bottom)) / self.problem.width
        panel = np.minimum(level.astype(int), len(self.log_w) - 1)
        rows = self.problem.rule.rows(panel + 1.0 - level)
        log_g = np.sum(rows * self.log_g_at_nodes[panel], axis=1)
        if self.is_power_below:
            log_g -= self.problem.law.lowest_power * np.minimum(x - self.bottom, 0.0)
        return np.asarray(log_g)
