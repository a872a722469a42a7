"""Averages over weighted initial speeds, at a few times or at many.

The average at time t is a sum over the points x_k = ln v_k of w_k y(x_k + ln(t/l)), y as function
of X on equal panels (`backward`). Where times are many, they are gathered in panels of ln t, too,
as wide as those in X. Relative to where such a panel begins, the points then fall on the same
places of the panels in X in all of them: the average at its nodes is one small matrix, made once,
times the values of y on the panels in X. Between its nodes averages are interpolated.

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
from kinetics.numerics.chebyshev import Chebyshev, panel_rule
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
    first, count : the first of these panels, and how many there are
    reach : the number of panels in X over which the points are spread at a panel in ln t
    """

    rule: Chebyshev
    log_stretch: FloatArray
    fastest: float
    coordinate: FloatArray
    panel_of_time: NDArray[np.intp]
    first: int
    count: int
    reach: int

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
        first = 0
        count = 0
        if late_stretch.size:
            first = int(panel_of_time[0])
            count = int(panel_of_time[-1]) - first + 1
        return cls(
            rule=panel_rule(equation.nodes + ADDED_NODES_OF_TIME, width),
            log_stretch=late_stretch,
            fastest=fastest,
            coordinate=coordinate,
            panel_of_time=panel_of_time,
            first=first,
            count=count,
            reach=2 + int((fastest - float(points.x.min())) / width),
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
        for first in range(0, log_stretch.size, n_times_at_once):
            times = slice(first, first + n_times_at_once)
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
        panels = self._panels
        n_points = self.points.x.size
        n_for_panels = panels.rule.nodes * (n_points + panels.count * panels.reach)
        return n_for_panels >= n_points * panels.log_stretch.size

    def _interpolate(self, y: Observable, leading: int) -> NumberArray:
        """Average at the nodes of panels in ln t, and interpolate; times after t = 0 only."""
        power = y.degree + leading
        panels = self._panels
        reach = panels.reach
        width = self.equation.width
        # the panels in X that the points reach, and y on them; below X = `start` in units of T^n
        # where a panel begins, as T^n itself may overflow
        x_panels = panels.first + 1 - reach + np.arange(panels.count + reach - 1)
        begins = self.equation.start + width * x_panels
        x = begins[:, None] + width * self.equation.rule.local
        values, is_early = self.equation.at(y, x, leading)
        log_units = np.where(x_panels < 0, begins, 0.0)
        # ln(v_ref t/l) where panels in ln t begin is their unit: v_ref has a kink in ln t
        stretch_begins = np.asarray(begins[reach - 1 :] - panels.fastest)
        log_flown = stretch_begins + self.reference.log_at(stretch_begins)
        window = np.arange(panels.count)[:, None] + np.arange(reach)
        with np.errstate(under="ignore", over="ignore", invalid="ignore"):
            values *= np.exp(power * (np.where(is_early, x, 0.0) - log_units[:, None]))
            scale = np.exp(power * (log_units[window] - log_flown[:, None]))
        in_units = (values[window] * scale[:, :, None]).reshape(panels.count, -1)
        at_nodes = in_units @ self._matrix
        index = panels.panel_of_time - panels.first
        stretch = panels.log_stretch
        log_change = log_flown[index] - stretch - self.reference.log_at(stretch)
        rows = panels.rule.rows(panels.coordinate - panels.panel_of_time)
        return np.einsum("ij,ij->i", rows, at_nodes[index]) * np.exp(power * log_change)

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
        for some in np.array_split(rising, 1 + rising.size * time_nodes // POINTS_AT_ONCE):
            panels_behind = (x[some] - panels.fastest) / self.equation.width
            coordinate = panels.rule.local[:, None] + panels_behind
            panel = np.minimum(np.floor(coordinate), 0.0)
            shares = rule.shares((coordinate - panel).ravel())
            weight = np.tile(self.points.weight[some], time_nodes) / np.einsum("ij->i", shares)
            row_of_point = own_rows + panel.astype(int)
            rows, first_points = np.unique(row_of_point, return_index=True)  # they rise
            matrix[rows] += np.add.reduceat(weight[:, None] * shares, first_points, axis=0)
        return matrix.reshape(time_nodes, -1).T
