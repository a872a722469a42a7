r"""Returns to a scatterer that take time: what loops bring to the panels of an equation.

u is the speed of a tracer at the beginning, l the mean free path, y the path of a loop in l, r the
fraction of the speed that is left after it, and m the angular harmonic (see `loops`). In the clock
T = u t/l a loop takes y c, c = (1 + 1/r)/2, and of the time left the tracer keeps r (T - y c). K is
the average over one collision, Y the average that is wanted, U what collisions act on, V what has
returned, W what collisions make, and k(y) the density of loops in 1/l. For an observable of degree
0 (powers of the speed have T^degree besides),

    dY/dT = (K - 1) U + sources,    U = Y + V,    W = (K - 1) U,
    V(T) = (-1)^m int dy k(y) W(r (T - y c)).

k is a sum of exponentials w exp(-s y), s their rates in 1/l, so that V is one of modes Z, V =
(-1)^m sum w Z, with

    c dZ/dT = W(r T) - s Z.

On panels in X = ln T collocation makes small matrices of that: `Loops` has them, and `Returns`
takes them through the panels. Both are made for the equations of `delayed_equation` (averages) and
of :mod:`kinetics.position.waves` (exp(i k.r)). A symbol has the same meaning in all of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from kinetics.moments.loops import LoopSpectrum
from kinetics.numerics import ROUNDING, ComplexArray, FloatArray
from kinetics.numerics.chebyshev import Chebyshev, chebyshev_panels
from kinetics.numerics.panel_shifts import PanelShifts

#: Relative accuracy of the matrices by default, well below that of a panel. Measured: at a tenth
#: and at ten times averages of disks at a finite density do not move.
DEFAULT_RTOL = 1.5e-11
#: Fraction of rtol that rounding of an eigenbasis may take; else matrices are inverted one by one,
#: which takes a third longer. Measured: at half averages move by 1e-11 and some estimates are half
#: as large, at twice nothing moves.
ROUNDING_SHARE = 0.2


class Loops:
    """What loops bring to panels in X = ln T, as powers T^degree of the time that is left.

    On a panel, f = W(r T) at its nodes, and z are the modes where it begins.

    Parameters
    ----------
    spectrum : the loops
    rule : the collocation of a panel
    start : X where the panels begin, not above `loops.series_end`
    n_panels : how many panels there are, at most
    degree : all is over T^degree
    rtol : relative accuracy of all this, at least

    Attributes
    ----------
    shares : of the kinds of loops, shape (n_m, n_kinds)
    weights : of the modes in the kinds, shape (n_kinds, n_modes)
    returning_of_f, returning_of_modes : V of each kind, before its share, at the nodes is the
        former @ f plus the latter @ z: shapes (n_panels, n_kinds, nodes, nodes) and (n_panels,
        n_kinds, nodes, n_modes)
    mode_gain, mode_decay : the modes where a panel ends are the former @ f plus the latter times z:
        shapes (n_panels, n_ratios, n_modes, nodes) and (n_panels, n_modes)
    reach : how many panels below matter for f
    from_below, from_panel : f is the former @ W on the panels below, plus the latter @ W on the
        panel: shapes (n_ratios, nodes, reach * nodes) and (n_ratios, nodes, nodes)
    """

    def __init__(
        self,
        spectrum: LoopSpectrum,
        rule: Chebyshev,
        start: float,
        n_panels: int,
        degree: float = 0.0,
        rtol: float = DEFAULT_RTOL,
    ) -> None:
        self.rule = rule
        self.start = start
        self.n_panels = n_panels
        self.degree = degree
        self.shares = spectrum.shares
        self.weights = spectrum.weights
        self._paces = spectrum.mode_paces
        self._ratios = spectrum.mode_ratios
        self._rates = spectrum.rates / self._paces
        self._collocate_modes(spectrum.has_ratio, rtol)
        self._interpolate_shifts(spectrum.speed_ratios)

    def _collocate_modes(self, has_ratio: FloatArray, rtol: float) -> None:
        """Solve c dZ/dT = f - s Z on every panel, for all f at its nodes and all initial z.

        With x from where a panel begins and T_0 = T there, exp(-x) dZ/dx + (T_0 s/c) Z = (T_0/c) f.
        The operator on the left is inverted by `_respond`. All is over T^degree: in its units f at
        one node counts at another as the ratio of these powers.
        """
        n = self.rule.nodes
        n_kinds, n_modes = self.weights.shape
        width = self.rule.width
        path = np.exp(self.start + width * np.arange(self.n_panels))  # T where a panel begins
        power = np.exp(self.degree * width * self.rule.local)
        weight_over_pace = self.weights / self._paces
        response = _respond(self.rule, path[:, None] * self._rates, weight_over_pace, rtol)

        power_ratios = power[1:, None] / power[1:]
        later_nodes = path[:, None, None, None] * response.summed * power_ratios
        self.returning_of_f = np.zeros((self.n_panels, n_kinds, n, n))
        self.returning_of_f[:, :, 1:, 1:] = later_nodes
        decay_at_nodes = np.ones((self.n_panels, n, n_modes))
        decay_at_nodes[:, 1:] = np.swapaxes(response.decay, 1, 2)
        self.returning_of_modes = self.weights[:, None] * decay_at_nodes[:, None] * power[:, None]

        self.mode_decay = power[-1] * response.decay[:, :, -1]
        path_over_pace = (path[:, None] / self._paces)[:, :, None]
        gain = path_over_pace * response.last_rows * (power[-1] / power[1:])
        self.mode_gain = np.zeros((self.n_panels, len(has_ratio), n_modes, n))
        self.mode_gain[..., 1:] = gain[:, None] * has_ratio[:, :, None]

    def _interpolate_shifts(self, speed_ratios: FloatArray) -> None:
        """Interpolate W(r T) at the nodes of a panel, for each r, from the nodes of panels."""
        n = self.rule.nodes
        n_ratios = len(speed_ratios)
        shift = PanelShifts(self.rule, -np.log(speed_ratios))
        self.reach = int(shift.below.max())
        rows = np.zeros((n_ratios, n, self.reach + 1, n))
        for i in range(n_ratios):
            rows[i, np.arange(n), self.reach - shift.below[:, i]] = shift.rows[:, i]
        self.from_below = rows[:, :, :-1].reshape(n_ratios, n, -1)
        self.from_panel = rows[:, :, -1]

    def term(self, k: int, modes: FloatArray, collided: FloatArray | float) -> FloatArray:
        """Return term k of the power series of the modes, shape (n_modes, ...).

        Parameters
        ----------
        k : the order in T
        modes : term k - 1 of the modes, shape (n_modes, ...)
        collided : term k - 1 of W, shape (...)
        """
        gain = np.multiply.outer(self._ratios ** (self.degree + k - 1) / self._paces, collided)
        return np.asarray((gain - (self._rates * modes.T).T) / k)


class Returns:
    """Returns that take time, panel by panel: V, of which collisions act on U = Y + V.

    For each panel call `begin`, solve for Y, and call `end`.

    Parameters
    ----------
    loops : what they bring to the panels
    collided : power series of W below all panels, over T^degree, of the harmonics that are not zero
        there: shape (n_terms, n_series, n_k)
    modes : the same of the modes, shape (n_terms, n_modes, n_series, n_k)
    """

    def __init__(self, loops: Loops, collided: FloatArray, modes: FloatArray) -> None:
        self._loops = loops
        nodes = loops.rule.nodes
        n_terms, n_series, n_k = collided.shape
        n_m = len(loops.shares)
        panels_below = np.arange(-loops.reach, 0)[:, None]
        x = loops.rule.width * (panels_below + loops.rule.local)
        x = np.append(loops.start + x.ravel(), loops.start)
        with np.errstate(under="ignore"):
            power = np.exp(x)[:, None] ** np.arange(n_terms)
            power *= np.exp(loops.degree * x)[:, None]
        #: the modes where the next panel begins
        self._modes = np.zeros((modes.shape[1], n_m, n_k))
        self._modes[:, :n_series] = np.tensordot(power[-1], modes, axes=1)
        #: W at the nodes of the panels below the first, and of all that were solved
        self._collided = np.zeros(((loops.reach + loops.n_panels) * nodes, n_m, n_k))
        self._collided[: x.size - 1, :n_series] = np.tensordot(power[:-1], collided, axes=1)

    def begin(
        self, panel: int, loss: FloatArray, gain: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return loss and gain that act on Y, with what loops bring to a panel.

        Parameters
        ----------
        panel : its number
        loss : of U by collisions, shape (n_used, nodes, nodes), for the first harmonics
        gain : by collisions from panels below, shape (n_used, nodes, n_k)
        """
        loops = self._loops
        n_used, nodes, n_k = gain.shape
        shares = loops.shares[:n_used]
        of_f = loops.returning_of_f[panel]
        of_modes = loops.returning_of_modes[panel]
        collided = self._collided[panel * nodes : (panel + loops.reach) * nodes, :n_used]
        self._f_from_below = np.tensordot(loops.from_below, collided, axes=1)
        returning = of_f @ self._f_from_below.reshape(-1, nodes, n_used * n_k)
        returning += of_modes @ self._modes[:, :n_used].reshape(-1, n_used * n_k)
        returning = returning.reshape(-1, nodes, n_used, n_k)
        returning = np.einsum("mk,kimq->miq", shares, returning)
        # V = returning + from_panel W, W = gain - loss U, U = Y + V
        from_panel = np.tensordot(shares, of_f @ loops.from_panel, axes=1)
        self._inverse = np.linalg.inv(np.eye(nodes) + from_panel @ loss)
        self._offset = self._inverse @ (from_panel @ gain + returning)
        self._loss = loss
        self._gain = gain
        return loss @ self._inverse, gain - loss @ self._offset

    def end(self, panel: int, y: FloatArray) -> FloatArray:
        """Return U on a panel, where Y was found, both (n_used, nodes, n_k)."""
        loops = self._loops
        n_used, nodes, _ = y.shape
        colliding = self._inverse @ y + self._offset
        collided = np.moveaxis(self._gain - self._loss @ colliding, 0, 1)
        begin = (loops.reach + panel) * nodes
        self._collided[begin : begin + nodes, :n_used] = collided
        f = self._f_from_below + np.tensordot(loops.from_panel, collided, axes=1)
        self._modes *= loops.mode_decay[panel][:, None, None]
        self._modes[:, :n_used] += np.tensordot(loops.mode_gain[panel], f, axes=([0, 2], [0, 1]))
        self._modes[:, n_used:] = 0.0
        return np.asarray(colliding)


@dataclass(frozen=True)
class _ModeResponse:
    """R = (exp(-x) d/dx + pull)^-1 on a panel, 0 at its first node, for each panel and mode.

    summed : weighted sums of R over modes, shape (n_panels, n_kinds, nodes - 1, nodes - 1)
    decay : what is left of 1 at the first node, at the others: (n_panels, n_modes, nodes - 1)
    last_rows : the last rows of R, (n_panels, n_modes, nodes - 1)
    """

    summed: FloatArray
    decay: FloatArray
    last_rows: FloatArray


def _respond(rule: Chebyshev, pull: FloatArray, weights: FloatArray, rtol: float) -> _ModeResponse:
    """Invert for every pull, (n_panels, n_modes), with weights of the modes (n_kinds, n_modes)."""
    basis = _eigenbasis(rule.nodes, rule.width)
    if basis.rounding > ROUNDING_SHARE * rtol:
        identity = np.eye(rule.nodes - 1)
        matrices = basis.slopes[:, 1:] + pull[:, :, None, None] * identity
        inverses: FloatArray = np.asarray(np.linalg.inv(matrices), dtype=float)
        summed = np.moveaxis(np.tensordot(weights, inverses, axes=(1, 1)), 0, 1)
        decay = np.asarray(-inverses @ basis.slopes[:, 0])
        return _ModeResponse(summed, decay, inverses[:, :, -1])
    inverse_values = 1.0 / (basis.values + pull[:, :, None])
    first_column = basis.inverse_vectors @ basis.slopes[:, 0]
    decay = -((inverse_values * first_column) @ basis.vectors.T).real
    weighted = (weights @ inverse_values)[:, :, None]
    summed = ((basis.vectors * weighted) @ basis.inverse_vectors).real
    last_rows = ((inverse_values * basis.vectors[-1]) @ basis.inverse_vectors).real
    return _ModeResponse(summed, decay, last_rows)


@dataclass(frozen=True)
class _Eigenbasis:
    """exp(-x) d/dx on a panel, in the basis of its eigenvectors.

    slopes : its matrix without the row of the first node, shape (nodes - 1, nodes)
    values : eigenvalues of `slopes` without the column of the first node, shape (nodes - 1,)
    vectors : the eigenvectors, one a column
    inverse_vectors : the inverse of that
    rounding : relative rounding of functions of the matrix in this basis
    """

    slopes: FloatArray
    values: ComplexArray
    vectors: ComplexArray
    inverse_vectors: ComplexArray
    rounding: float


@lru_cache(maxsize=16)
def _eigenbasis(nodes: int, width: float) -> _Eigenbasis:
    """Return the eigenvectors for panels of so many nodes, and of this width."""
    rule = chebyshev_panels(nodes, width)
    slopes = np.exp(-width * rule.local)[1:, None] * rule.derivative[1:]
    values, vectors = np.linalg.eig(slopes[:, 1:])
    rounding = ROUNDING * float(np.linalg.cond(vectors))
    return _Eigenbasis(slopes, values, vectors, np.linalg.inv(vectors), rounding)
