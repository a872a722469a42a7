"""The density over time in a field, with its first moments of the place, for one initial state.

With x f and y f, integrated over the place, d_t (x f) = (field + collisions) (x f) + v_x f and the
same for y, all averages of the velocity and the displacement up to second order follow. Of a start
that is a few velocities, those that have not collided are in closed form (`starts`), and are the
source of the others: so averages over smooth functions are right, however rough the density is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.field import radau
from kinetics.field.grid import Resolution, SpeedPanels, loss_matrices, reached_speed
from kinetics.field.harmonics import Chain, norms
from kinetics.field.march import SHORTEST_TIME, SQUARES, Equation, March
from kinetics.field.starts import Start
from kinetics.numerics import FloatArray
from kinetics.states.state import State

_MOST_HARMONICS = 40  # seconds, and 200 MB of memory


@dataclass
class Evolution(March):
    """One start over time, in units of sqrt(g l) and sqrt(l/g).

    state : of which the start is made, if its density is asked for point by point
    made : beginning, length, and v times what collisions make at the points, of each step; if the
        density is asked for
    """

    law: CollisionLaw
    start: Start
    times: FloatArray
    resolution: Resolution
    asked: frozenset[str]
    state: State | None = None
    made: list[tuple[float, float, FloatArray]] = field(init=False, default_factory=list)

    def __post_init__(self) -> None:
        one, last = self.resolution, max(float(self.times[-1]), SHORTEST_TIME)
        highest = math.hypot(self.start.highest, reached_speed(self.law, last, one.rtol))
        # below 1/t, no tracer has collided by the time t
        lowest = min(one.lowest * max(1.0, 1.0 / last), 0.1 * highest)
        self.axis = SpeedPanels.rising(highest, lowest, one.nodes)
        self.families = 1 if self.start.is_symmetric else 2
        of = ("f", "x", "y") if self.asked & SQUARES else ("f",)
        fields = [(name, abs(k - (name == "y"))) for name in of for k in range(self.families)]
        speeds, self._loss = self.axis.speeds, loss_matrices(self.axis, self.law, one.harmonics)
        d = self.law.dimension
        chain = Chain(d, self._loss, self.axis.slopes(d), 1.0 / speeds)
        self._volume = speeds ** (d - 1.0) * self.axis.weights
        self.equation = Equation(chain, fields, speeds, self._volume, speeds)
        self._run(self.equation, self._begin(), self.start.highest)

    @property
    def finer(self) -> Resolution | None:
        """A finer resolution; None where there is none."""
        more = self.resolution.finer()
        return more if more.harmonics <= _MOST_HARMONICS else None

    def _begin(self) -> FloatArray:
        count, families = self.resolution.harmonics + 1, self.families
        f = np.zeros((len(self.equation.fields), count, self.axis.size))
        if self.start.velocities is None:
            sums = self.start.projected(self.axis, count, families, self.state)
            f[:families] = sums / self._volume
        return f

    def _uncollided(self, times: FloatArray) -> FloatArray | float:
        velocities = self.start.velocities
        if velocities is None or not times.size:
            return 0.0
        return np.array([velocities.averages(float(t)) for t in times])

    def _early(self, now: float, h: float) -> tuple[FloatArray, FloatArray] | None:
        velocities = self.start.velocities
        if velocities is None:
            return None
        count, fine = self.resolution.harmonics + 1, now + h * radau.FINE
        sums = velocities.projected(fine, self.axis, count, self.equation.fields)
        early = radau.projected(sums / self._volume)
        return early, self._gained(early[1:])

    def _keep(self, now: float, h: float, stages: FloatArray) -> None:
        if self.state is not None:
            families, of = self.families, norms(stages.shape[2], self.law.dimension)
            made = self._gained(stages[:, :families] / of[:families])
            self.made.append((now, h, made * self.axis.speeds))

    def _gained(self, f: FloatArray) -> FloatArray:
        """What sums (..., M + 1, size) gain by collisions per unit time."""
        return self.axis.speeds * f - np.einsum("mij,...mj->...mi", self._loss, f)
