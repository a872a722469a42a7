"""Averages over weighted initial speeds, at a few times or at many.

The average at time t is a sum over the points x_k = ln v_k, with the weights w_k, of w_k y(x_k +
ln(t/l)); y is a function of X = ln(v t/l) on equal panels (`backward`), l the mean free path.
Speeds are in U, lengths in d, times in d/U. Where times are many, they are gathered in panels of ln
t, too, as wide as those in X. Relative to where such a panel begins, the points then fall on the
same places of the panels in X in all of them: the average at its nodes is one small matrix, made
once, times the values of y on the panels in X. Between its nodes averages are interpolated.

Begin with `PointAverage.average`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.moments.backward import BackwardEquation
from kinetics.moments.observables import Observable
from kinetics.numerics import FloatArray, NumberArray
from kinetics.numerics.chebyshev import Chebyshev, chebyshev_panels
from kinetics.states.state import LogMeasure

#: Points at once, so that memory stays flat and interpolation weights stay in the cache of the
#: processor. Measured: from 2500 to 40,000 it takes the same time.
POINTS_AT_ONCE = 5000
#: Nodes of a panel in ln t beyond those of a panel in X. Derived: a node is about a digit, so that
#: interpolation in time adds a hundredth of rtol.
ADDED_NODES_OF_TIME = 2


@dataclass(frozen=True)
class ReferenceSpeed:
    """A speed of the order of the thermal one: as the unit of averages it keeps them in range.

    It is that of the start, and late that of Haff's law, l/(t E[-ln s]).

    Parameters
    ----------
    law : the collision law
    log_initial : ln of the root mean square of the initial speeds in U
    """

    law: CollisionLaw
    log_initial: float

    def log_at(self, log_stretch: FloatArray) -> FloatArray:
        """Return ln of it in U, at ln(t/l); of the same shape."""
        if self.law.is_elastic:
            return np.full(log_stretch.shape, self.log_initial)
        late = -log_stretch - math.log(self.law.mean_log_loss)
        return np.asarray(np.minimum(self.log_initial, late))


@dataclass(frozen=True, eq=False)
class TimePanels:
    """Panels in ln t, for which the fastest point begins a panel in X where a panel begins.

    Parameters
    ----------
    rule : the nodes of a panel
    log_stretch : ln(t/l) of the times after t = 0, shape (n_late,)
    fastest : the largest x of the points
    coordinate : X of the fastest point at these times, in panels of X, shape (n_late,)
    panel_of_time : the panel that this is in, shape (n_late,)
    first_panel, n_panels : the first of these panels, and how many there are
    stretch_begins : ln(t/l) where they begin, shape (n_panels,)
    reach : the number of panels in X over which the points are spread at a panel in ln t
    x_begins : X where the panels in X begin that points reach, shape (n_panels + reach - 1,)
    """

    rule: Chebyshev
    log_stretch: FloatArray
    fastest: float
    coordinate: FloatArray
    panel_of_time: NDArray[np.intp]
    first_panel: int
    n_panels: int
    stretch_begins: FloatArray
    reach: int
    x_begins: FloatArray

    @classmethod
    def of(
        cls, equation: BackwardEquation, points: LogMeasure, log_stretch: FloatArray
    ) -> TimePanels:
        """Return the panels for some points and times, ln(t/l) rising, perhaps from -inf."""
        width = equation.width
        late_stretch = log_stretch[np.isfinite(log_stretch)]
        fastest = float(points.x.max())
        coordinate = (late_stretch + fastest - equation.start) / width
        panel_of_time = np.ceil(coordinate).astype(int) - 1
        first_panel = 0
        n_panels = 0
        if late_stretch.size:
            first_panel = int(panel_of_time[0])
            n_panels = int(panel_of_time[-1]) - first_panel + 1
        reach = 2 + int((fastest - float(points.x.min())) / width)
        x_panels = first_panel + 1 - reach + np.arange(n_panels + reach - 1)
        x_begins = np.asarray(equation.start + width * x_panels, dtype=float)
        return cls(
            rule=chebyshev_panels(equation.nodes + ADDED_NODES_OF_TIME, width),
            log_stretch=late_stretch,
            fastest=fastest,
            coordinate=coordinate,
            panel_of_time=panel_of_time,
            first_panel=first_panel,
            n_panels=n_panels,
            stretch_begins=x_begins[reach - 1 :] - fastest,
            reach=reach,
            x_begins=x_begins,
        )


@dataclass(frozen=True, eq=False)
class PointAverage:
    """Averages of observables over weighted points, at given times.

    Parameters
    ----------
    equation : has the observables as functions of X = ln(v t/l)
    points : ln v and weights
    log_stretch : ln(t/l), rising, -inf at t = 0, shape (n_times,)
    reference : the speed whose powers are the units of averages
    """

    equation: BackwardEquation
    points: LogMeasure
    log_stretch: FloatArray
    reference: ReferenceSpeed

    def average(self, y: Observable, leading: int) -> NumberArray:
        """Return <y T^-n (v/v_ref)^n>, n = y.degree + leading, at all times: (n_times,).

        The first `leading` terms of the power series of y must vanish.
        """
        if self._is_direct_cheaper:
            return self._average_directly(y, leading, self.log_stretch)
        is_late = np.isfinite(self.log_stretch)
        result = np.empty(self.log_stretch.shape, dtype=self.points.weight.dtype)
        result[is_late] = self._interpolate(y, leading)
        result[~is_late] = self._average_directly(y, leading, self.log_stretch[~is_late])
        return result

    def _average_directly(
        self, y: Observable, leading: int, log_stretch: FloatArray
    ) -> NumberArray:
        """Sum over the points at each of these times, shape (n,)."""
        x = self.points.x
        power = y.degree + leading
        result = np.empty(log_stretch.shape, dtype=self.points.weight.dtype)
        n_times_at_once = max(1, POINTS_AT_ONCE // x.size)
        for begin in range(0, log_stretch.size, n_times_at_once):
            times = slice(begin, begin + n_times_at_once)
            stretch = log_stretch[times, None]
            values, is_early = self.equation.at(y, x + stretch, leading)
            # early, y T^-n is there and v^n is missing; later, y is and T^-n v^n = (l/t)^n
            with np.errstate(under="ignore", over="ignore", invalid="ignore"):
                log_unit = np.where(is_early, x, -stretch) - self.reference.log_at(stretch)
                result[times] = (values * np.exp(power * log_unit)) @ self.points.weight
        return result

    # -- many times -------------------------------------------------------------------------------

    @cached_property
    def _panels(self) -> TimePanels:
        """The panels in ln t."""
        return TimePanels.of(self.equation, self.points, self.log_stretch)

    @property
    def _is_direct_cheaper(self) -> bool:
        """Whether the points at all times are fewer than what panels need."""
        if self.log_stretch.size <= self.equation.nodes:
            return True  # one panel would have more nodes
        panels = self._panels
        n_points = self.points.x.size
        n_for_panels = panels.rule.nodes * (n_points + panels.n_panels * panels.reach)
        return n_for_panels >= n_points * panels.log_stretch.size

    def _interpolate(self, y: Observable, leading: int) -> NumberArray:
        """Average at the nodes of panels in ln t, and interpolate; times after t = 0 only."""
        power = y.degree + leading
        panels = self._panels
        # (v_ref t/l)^n where panels in ln t begin is the unit at their nodes: v_ref has a kink
        log_units = panels.stretch_begins + self.reference.log_at(panels.stretch_begins)
        at_nodes = self._average_at_nodes(y, leading, log_units)
        index = panels.panel_of_time - panels.first_panel
        rows = panels.rule.rows(panels.coordinate - panels.panel_of_time)
        stretch = panels.log_stretch
        log_change = log_units[index] - stretch - self.reference.log_at(stretch)
        return np.einsum("ij,ij->i", rows, at_nodes[index]) * np.exp(power * log_change)

    def _average_at_nodes(self, y: Observable, leading: int, log_units: FloatArray) -> NumberArray:
        """Average at the nodes of panels in ln t, in units of exp(n log_units), (n_panels,).

        Shape (n_panels, time nodes).
        """
        power = y.degree + leading
        panels = self._panels
        x = panels.x_begins[:, None] + self.equation.width * self.equation.rule.local
        values, is_early = self.equation.at(y, x, leading)
        # y itself, but below X = `start` in units of T^n where a panel begins: T^n may overflow
        is_below = panels.x_begins < self.equation.start
        log_scales = np.where(is_below, panels.x_begins, 0.0)
        window = np.arange(panels.n_panels)[:, None] + np.arange(panels.reach)
        with np.errstate(under="ignore", over="ignore", invalid="ignore"):
            values *= np.exp(power * (np.where(is_early, x, 0.0) - log_scales[:, None]))
            scale = np.exp(power * (log_scales[window] - log_units[:, None]))
        in_units = values[window] * scale[:, :, None]
        return in_units.reshape(panels.n_panels, -1) @ self._matrix

    @cached_property
    def _matrix(self) -> NumberArray:
        """Averages at the nodes of a panel in ln t from y on the panels in X that its points reach.

        Shape (reach * nodes, time nodes).
        """
        panels = self._panels
        time_nodes = panels.rule.nodes
        rule = self.equation.rule
        x = self.points.x
        matrix = np.zeros((time_nodes * panels.reach, rule.nodes), dtype=self.points.weight.dtype)
        rising = np.argsort(x)
        # rows of the matrix for the panel in which the fastest point is
        own_rows = np.arange(1, time_nodes + 1)[:, None] * panels.reach - 1
        for piece in np.array_split(rising, 1 + rising.size * time_nodes // POINTS_AT_ONCE):
            panels_behind = (x[piece] - panels.fastest) / self.equation.width
            coordinate = panels.rule.local[:, None] + panels_behind
            panel = np.minimum(np.floor(coordinate), 0.0)
            shares = rule.shares((coordinate - panel).ravel())
            weight = np.tile(self.points.weight[piece], time_nodes) / np.einsum("ij->i", shares)
            row_of_point = own_rows + panel.astype(int)
            rows, first_points = np.unique(row_of_point, return_index=True)  # they rise
            matrix[rows] += np.add.reduceat(weight[:, None] * shares, first_points, axis=0)
        return matrix.reshape(time_nodes, -1).T
