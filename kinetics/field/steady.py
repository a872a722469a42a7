"""The density of the velocity in the steady state in a field.

Averages follow from the averages of polynomials (`kinetics.driven`); near rest, and on the ray
along the field, the density itself is solved on panels of speeds, of which the first are short.
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np
from scipy.special import roots_jacobi

from kinetics.collision import CollisionLaw
from kinetics.field.density import LastFlights
from kinetics.field.grid import Resolution, SpeedPanels, highest_speed, loss_matrices
from kinetics.field.harmonics import Chain, norms
from kinetics.numerics import FloatArray

_LOWEST = 0.03  # of the first panel of laws whose bounces may nearly stop a tracer


class SteadyDensity:
    """Harmonics of f on given panels; (field + collisions) f = 0, with mass 1.

    law : the collision law, not elastic
    one : panels and harmonics
    """

    def __init__(self, law: CollisionLaw, one: Resolution) -> None:
        self.law = law
        highest = highest_speed(law, one.rtol)
        least = law.least_ratio  # below it f varies as (v/least)^2 ln v
        lowest = one.lowest * (min(1.0, max(3.0 * least, _LOWEST)) if least else 1.0)
        self.panels = SpeedPanels.rising(highest, lowest, one.nodes, tail=True)
        v, d = self.panels.speeds, law.dimension
        self._loss = loss_matrices(self.panels, law, one.harmonics)
        chain = Chain(d, self._loss, self.panels.slopes(d), 1.0 / v)
        # a source anywhere, for the border: its factor comes out as 0
        border = v ** (d - 1.0) * self.panels.weights, v * np.exp(-v)
        solver = chain.elimination(border=border)
        self._sums = solver.solve(np.zeros((one.harmonics + 1, v.size)), 1.0)
        self.harmonics = self._sums / norms(one.harmonics + 1, d)[0]

    def moment(self, p: float, m: int) -> float:
        """<v^p cos(m phi)>, for p > -d; for p > -d - 1 where m > 0 and f_m is 0 at rest."""
        v, d = self.panels.speeds, self.law.dimension
        f, first = self._sums[m], self.panels.parts[0]
        rest = slice(first.stop, None)
        above = (v[rest] ** (p + d - 1.0) * f[rest]) @ self.panels.weights[rest]
        return float(above + self._first_panel(f[first], p + d - 1.0))

    def _first_panel(self, f: FloatArray, power: float) -> float:
        """Integral of v^power f over the first panel, with f or f/v a polynomial there."""
        at, top = self.panels.speeds[self.panels.parts[0]], self.panels.edges[1]
        if power <= -1.0:
            f, power = f / at, power + 1.0
        x, w = roots_jacobi(f.size, 0.0, power)
        rows = self.panels.rows(0, 0.5 * top * (x[:, None] + 1.0) - at)
        return float((0.5 * top) ** (power + 1.0) * (w @ (rows @ f)))

    @cached_property
    def _flights(self) -> LastFlights:
        f, v = self.harmonics, self.panels.speeds
        made = v * (v * f - np.einsum("mij,mj->mi", self._loss, f))
        return LastFlights(self.panels, self.law.dimension, [(0.0, 1.0, made[None, None])])

    def density(self, along: FloatArray, across: FloatArray) -> FloatArray:
        """f at velocities (n,) in sqrt(g l)."""
        found = self._flights.density(math.inf, along, across)
        if math.isinf(self.law.largest_loss):  # the logarithm of the angle
            found[(across == 0.0) & (along >= 0.0)] = math.inf
        return found
