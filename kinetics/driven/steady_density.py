"""The density of the velocity of the steady state in a field, on panels of speeds."""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np
from scipy.special import roots_jacobi

from kinetics.collision import CollisionLaw
from kinetics.driven.field_evolution import CollisionGain, drive_of_unit_field
from kinetics.driven.harmonics import Border, Chain, norms
from kinetics.driven.last_flights import LastFlights
from kinetics.driven.panel_collisions import loss_matrices
from kinetics.driven.panels import SpeedPanels
from kinetics.driven.resolution import PanelResolution
from kinetics.driven.speed_range import TAIL_OVER_TOLERANCE, top_speed
from kinetics.numerics import FloatArray

#: The first panel over the least ratio of speeds in a collision, where that is above 0: below it f
#: varies as (v/ratio)^2 ln v. Measured at e = 0.3: at half and at twice f moves by 4e-9 of its
#: maximum.
FIRST_PANEL_OVER_RATIO = 3.0
#: The shortest that the first panel may become by that. Chosen: shorter ones cost panels; at half
#: and at twice nothing moves for e = 0, 0.3 and 0.7.
MIN_FIRST_PANEL = 0.03


class SteadyDensity:
    """Harmonics of f on given panels; (field + collisions) f = 0, with mass 1.

    Parameters
    ----------
    law : the collision law, not elastic
    resolution : of panels and harmonics

    Attributes
    ----------
    harmonics : f_m at the nodes, in units of sqrt(g l), (M + 1, size)
    """

    def __init__(self, law: CollisionLaw, resolution: PanelResolution) -> None:
        self.law = law
        self.panels = _make_panels(law, resolution)
        v = self.panels.speeds
        dimension = law.dimension
        count = resolution.harmonics + 1
        self._loss = loss_matrices(self.panels, law, resolution.harmonics)
        chain = Chain(dimension, self._loss, self.panels.slopes(dimension), 1.0 / v)
        solver = chain.elimination(border=Border(mass=np.ones(v.size), source=v * np.exp(-v)))
        self._sums = solver.solve(np.zeros((count, v.size)), 1.0)
        self._volumes = norms(count, dimension) * self.panels.volumes(dimension)
        self.harmonics = self._sums / self._volumes

    def moment(self, p: float, m: int) -> float:
        """Return <v^p cos(m phi)>, p > -d; p > -d - 1 where m > 0 and f_m is 0 at rest."""
        first = self.panels.parts[0]
        above = slice(first.stop, None)
        return float(
            self.panels.speeds[above] ** p @ self._sums[m][above] + self._first_panel_moment(p, m)
        )

    def _first_panel_moment(self, p: float, m: int) -> float:
        """Return what the first panel adds to a moment: f there, or f/v, is a polynomial."""
        d = self.law.dimension
        first = self.panels.parts[0]
        f = self._sums[m][first] / self.panels.volumes(d)[first]
        power = p + d - 1.0
        if power <= -1.0:
            f = f / self.panels.speeds[first]
            power += 1.0
        half = 0.5 * self.panels.edges[1]
        x, weight = roots_jacobi(f.size, 0.0, power)
        at_x = self.panels.rows(0, half * (x + 1.0)) @ f
        return float(half ** (power + 1.0) * (weight @ at_x))

    @cached_property
    def _flights(self) -> LastFlights:
        """The integrals over last flights, of one step of time that has one point."""
        f = self._sums
        v = self.panels.speeds
        gained = v * (v * f - np.einsum("mij,mj->mi", self._loss, f)) / self._volumes
        gain = CollisionGain(0.0, 1.0, gained[None, None])
        return LastFlights(self.panels, self.law.dimension, [gain])

    def density(self, along: FloatArray, across: FloatArray) -> FloatArray:
        """Return f at velocities (n,) in sqrt(g l)."""
        density = self._flights.density(math.inf, along, across)
        if math.isinf(self.law.largest_loss):  # the logarithm of the angle
            density[(across == 0.0) & (along >= 0.0)] = math.inf
        return density


def _make_panels(law: CollisionLaw, resolution: PanelResolution) -> SpeedPanels:
    """Return the panels of the steady state."""
    tail = TAIL_OVER_TOLERANCE * resolution.rtol
    highest = top_speed(drive_of_unit_field(law), tail)
    lowest = resolution.lowest
    if law.least_ratio:
        lowest *= min(1.0, max(FIRST_PANEL_OVER_RATIO * law.least_ratio, MIN_FIRST_PANEL))
    return SpeedPanels.rising(highest, lowest, resolution.nodes, tail=True)
