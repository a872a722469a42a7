"""The steady state in a field, and the dispersion about its drift.

Harmonics of f obey (field + collisions) f = 0 with mass 1; the dispersion follows from the linear
response h to the velocity itself,

    (field + collisions) h = (v_z - u) f,  D_parallel = integral of v_z h,  integral of h = 0

with the drift u, and with v_x f on the right for the direction across.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import roots_jacobi

from kinetics.collision import CollisionLaw
from kinetics.field.density import LastFlights
from kinetics.field.elimination import Chain, Elimination, continuation
from kinetics.field.grid import Resolution, SpeedPanels, highest_speed, loss_matrices
from kinetics.numerics import FloatArray

_MOST_HARMONICS = 150  # as many as 2 GB of memory hold
_LOWEST = 0.03  # of the first panel of laws whose bounces may nearly stop a tracer
_FLOOR = 1e-12  # below it two solutions may agree by chance: ten times what rounding makes


@dataclass
class SteadyState:
    """The steady state on given panels and harmonics.

    law : the collision law, not elastic
    resolution : panels and harmonics
    """

    law: CollisionLaw
    resolution: Resolution

    def __post_init__(self) -> None:
        law, one = self.law, self.resolution
        highest = highest_speed(law, one.rtol)
        least = math.exp(-law.largest_loss)  # speed ratio, below which f varies as (v/least)^2 ln v
        lowest = one.lowest * (min(1.0, max(3.0 * least, _LOWEST)) if least else 1.0)
        self.panels = SpeedPanels.rising(highest, lowest, one.nodes, tail=True)
        v, d = self.panels.speeds, law.dimension
        self._loss = loss_matrices(self.panels, law, one.harmonics)
        self._volume = law.unit_surface * v ** (d - 1.0) * self.panels.weights
        # f_m falls as m^-3 in the end, but as 1/m where a bounce may nearly stop a tracer, up to m
        # of about the inverse of the smallest speed ratio
        nearly_stops = least * one.harmonics < 1.0
        self._powers = (1.0, 3.0) if nearly_stops else (2.0, 4.0)
        # a source anywhere, for the border: its factor comes out as 0
        border = self._volume, v**2 * np.exp(-v)
        self._along = self._elimination(Chain(self.panels, d), border)
        self.harmonics = self._along.solve(np.zeros((one.harmonics + 1, v.size)), 1.0)

    def _elimination(
        self, chain: Chain, border: tuple[FloatArray, FloatArray] | None
    ) -> Elimination:
        lost = self.panels.speeds[:, None] * self._loss
        return Elimination(chain, lost, self._powers, border=border)

    def moment(self, p: float, m: int) -> float:
        """<v^p cos(m phi)>, for p > -d; for p > -d - 1 where m > 0 and f_m is 0 at rest."""
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
        rows = self.panels.rows(0, 0.5 * top * (x[:, None] + 1.0) - at)
        return float((0.5 * top) ** (power + 1.0) * (w @ (rows @ f)))

    @cached_property
    def figures(self) -> FloatArray:
        """Drift, <v^2>, <v_z^2>, <v>, and diffusion along and across the field, shape (6,)."""
        f, d, v = self.harmonics, self.law.dimension, self.panels.speeds
        drift, second, turned = self.moment(1.0, 1), self.moment(2.0, 0), self.moment(2.0, 2)
        chain = self._along.chain
        last, before = continuation(self.resolution.harmonics, self._powers)
        further = np.vstack([f, last * f[-1] + before * f[-2]])
        along = self._along.solve((chain.along(further)[:-1] - drift * f) * v)[1]
        aside = self._elimination(Chain(self.panels, d, 1), None)
        across = aside.solve((chain.across(further) * v)[1 : aside.highest + 1])[0]
        square = (second + (d - 1.0) * turned) / d
        diffusion = [(self._volume * v) @ h / d for h in (along, across)]
        return np.array([drift, second, square, self.moment(1.0, 0), *diffusion])

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


Pair = tuple[SteadyState, SteadyState]


def find(law: CollisionLaw, first: Resolution, rtol: float) -> tuple[Pair, float]:
    """Two solutions, the second the finer, that agree to rtol; and the error of the finer one.

    Or the pair that agrees best.
    """
    coarse, fine = SteadyState(law, first), SteadyState(law, first.finer())
    best, least = (coarse, fine), _error(coarse, fine)
    while least > rtol and fine.resolution.finer().harmonics < _MOST_HARMONICS:
        coarse, fine = fine, SteadyState(law, fine.resolution.finer())
        error = _error(coarse, fine)
        if not error < least:
            break
        best, least = (coarse, fine), error
    return best, least


def _error(coarse: SteadyState, fine: SteadyState) -> float:
    """The largest difference of the figures, relative to each; at least 1e-12."""
    apart = float(np.max(np.abs(coarse.figures / fine.figures - 1.0)))
    return max(apart, _FLOOR) if math.isfinite(apart) else math.inf
