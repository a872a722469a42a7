"""Averages over a steady state that is given by its harmonics on speed panels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import roots_jacobi

from kinetics.collision import CollisionLaw
from kinetics.field.panels import SpeedPanels
from kinetics.numerics import FloatArray
from kinetics.results import Value


@dataclass(frozen=True)
class SteadyAverages(Value):
    """Averages over harmonics f_m of a density: <v^p cos(m phi)>, in space <v^p P_m(cos theta)>.

    Parameters
    ----------
    law : the collision law
    panels : the speed axis
    harmonics : f_m at the nodes, shape (M + 1, size)
    """

    law: CollisionLaw
    panels: SpeedPanels
    harmonics: FloatArray

    def moment(self, p: float, m: int) -> float:
        """The average, for p > -d; for p > -d - 1 where m > 0 and f_m is 0 at rest."""
        v, d = self.panels.speeds, self.law.dimension
        surface = self.law.unit_surface / (1.0 if m == 0 else 2.0 if d == 2 else 2.0 * m + 1.0)
        f, first = self.harmonics[m], self.panels.parts[0]
        rest = slice(first.stop, None)
        above = (v[rest] ** (p + d - 1.0) * f[rest]) @ self.panels.weights[rest]
        return float(surface * (above + self._first_panel(f[first], p + d - 1.0)))

    def _first_panel(self, f: FloatArray, power: float) -> float:
        """Integral of v^power f over the first panel, with f or f/v a polynomial there."""
        at, top = self.panels.speeds[self.panels.parts[0]], self.panels.edges[1]
        if power <= -1.0:
            f, power = f / at, power + 1.0
        x, w = roots_jacobi(f.size, 0.0, power)
        v = 0.5 * top * (x + 1.0)
        rows = self.panels.rows(0, v[:, None] - at)
        return float((0.5 * top) ** (power + 1.0) * (w @ (rows @ f)))

    @property
    def figures(self) -> FloatArray:
        """Drift, <v^2>, <v_z^2> and <v>, shape (4,)."""
        second, turned, d = self.moment(2.0, 0), self.moment(2.0, 2), self.law.dimension
        along = (second + (d - 1.0) * turned) / d
        return np.array([self.moment(1.0, 1), second, along, self.moment(1.0, 0)])

    @property
    def defects(self) -> dict[str, float]:
        """By how much each exact relation between averages is missed, relative to itself.

        They are the moments of rows 0 and 1 of the equation: p <v^(p-1) cos> = lambda(p) <v^(p+1)>
        for p = -1, 0 (divided by p), 1, 2, 3, and <v v_z> lambda_1(1) = 1.
        """
        law, moment = self.law, self.moment
        found = {
            "<v^2 cos>, first harmonic": moment(2.0, 1) * float(law.harmonic_decay_rate(1.0, 1))
            - 1.0
        }
        for p in (3.0, 2.0, 1.0):
            right = float(law.decay_rate(p)) * moment(p + 1.0, 0)
            found[f"<v^{p - 1.0:g} cos>"] = p * moment(p - 1.0, 1) / right - 1.0
        right = law.mean_log_loss * moment(1.0, 0)
        found["<cos/v>"] = moment(-1.0, 1) / right - 1.0
        if law.lowest_power < -1.0:
            found["<cos/v^2>"] = moment(-2.0, 1) / -float(law.decay_rate(-1.0)) - 1.0
        return found
