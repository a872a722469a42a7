"""Averages over time in a field, for one initial state.

Steps of time grow as long as the averages stay smooth in time. Where the start has few directions,
on which harmonics converge slowly, the first collision is integrated over: after it the directions
are spread.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import count

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.field.backward import ALL, SQUARES, BackwardField, backward_panels
from kinetics.field.first_collision import FirstCollisions
from kinetics.field.resolution import TimeResolution, highest_speed
from kinetics.field.starts import Start
from kinetics.numerics import FloatArray

_SMOOTH = 64.0  # by which a step may be smoother than is asked before it is doubled
_STEPS_MISS = 30.0  # rough steps miss less at their ends, by more than this
_EARLY = 5.0  # see `Evolution._first_step`
_EARLIEST = 1e-12  # stands for the time 0
# A resolution that is too coarse may never be smooth: then steps double to the end, and the other
# solution, which is compared, says that this one is wrong.
_MOST_STEPS = 300
_SHORTEST = 1e-9  # of the first step: below it a step is not halved


@dataclass
class Evolution:
    """The averages of one start at given times, in units of sqrt(g l) and sqrt(l/g).

    Parameters
    ----------
    law : the collision law
    start : the initial state
    times : rising, shape (n_times,)
    resolution : panels, harmonics and steps
    names : the observables that are solved, from `backward.needed_for`

    Attributes
    ----------
    values : averages of the observables of `backward.ALL`, shape (n_times, n_observables); those
        that are not solved are 0
    steps : the number of steps of time
    """

    law: CollisionLaw
    start: Start
    times: FloatArray
    resolution: TimeResolution
    names: frozenset[str] = frozenset(ALL)
    values: FloatArray = field(init=False)
    steps: int = field(init=False, default=0)

    def __post_init__(self) -> None:
        last = max(float(self.times[-1]), _EARLIEST)
        reach = reached_speed(self.law, last, self.resolution.rtol)
        highest = math.hypot(self.start.highest, reach)
        # below 1/t, no tracer has collided by the time t
        lowest = min(self.resolution.lowest * max(1.0, 1.0 / last), 0.1 * highest)
        panels = backward_panels(highest, lowest, self.resolution.nodes)
        self.equation = BackwardField(self.law, panels, self.resolution.harmonics, self.names)
        self._first: FirstCollisions | None = None
        if self.start.rays is None:
            self._weights = self.start.functional(panels, self.resolution.harmonics)
        else:
            self._first = FirstCollisions(self.start.rays, self.equation)
            self._weights = self._first.weights(last)
        self.values = np.empty((self.times.size, len(ALL)))
        self._run(last)

    def _run(self, last: float) -> None:
        """Step after step, up to the last time."""
        y = self.equation.start
        now, h = 0.0, self._first_step(last)
        least, allowed = _SHORTEST * h, _STEPS_MISS * self.resolution.rtol
        for tried in count():
            stages = self.equation.step(y, h)
            averages = self._averages(stages)
            rough = self._roughness(averages) if tried < _MOST_STEPS else 0.0
            if rough > allowed and h > least:
                h *= 0.5
                continue
            self.steps += 1
            self._keep(now, h, stages, averages)
            now, y = now + h, stages[-1]
            if now >= last:
                break
            if rough * _SMOOTH < allowed:
                h *= 2.0
                self.equation.forget(h)
        if self._first is not None:
            self.values = self._first.averages(self.times)

    def _first_step(self, last: float) -> float:
        """Short against the free flights of all tracers; a power of 2 times the last time.

        At the first of the times, averages may be as small as t^4, of which the sixth order in the
        step must be a small part: the chance of a collision before it is t^2/2 from rest.
        """
        wanted = 0.5 / (1.0 + self.start.highest)
        first = min(float(t) for t in (*self.times[self.times > 0.0], last))
        early = _EARLY * (first / wanted) ** (1.0 / 3.0) * self.resolution.rtol ** (1.0 / 6.0)
        wanted *= min(1.0, early)
        return last if last <= wanted else last * 2.0 ** math.floor(math.log2(wanted / last))

    def _averages(self, stages: FloatArray) -> FloatArray:
        """Averages over the start at the points of a step, (stages + 1, n_observables).

        Along rays: over the first collision, which is what the steps must resolve.
        """
        return np.asarray(np.einsum("smik,mik->sk", stages, self._weights))

    def _roughness(self, averages: FloatArray) -> float:
        """What the polynomial in time of a step leaves out, relative to the scale of each."""
        left = self.equation.rule.roughness(averages)
        scale = scales(averages[-1:])[0]
        used = scale > 0.0
        return float(np.max(left[used] / scale[used], initial=0.0))

    def _keep(self, now: float, h: float, stages: FloatArray, averages: FloatArray) -> None:
        """Interpolate the averages to the times within a step."""
        inside = (self.times >= now) & (self.times <= now + h)
        rows = self.equation.rule.rows((self.times[inside] - now) / h)
        self.values[inside] = rows @ averages
        if self._first is not None:
            self._first.keep(now, h, stages)


def reached_speed(law: CollisionLaw, time: float, accuracy: float) -> float:
    """A speed that tracers from rest do not reach in this time, in sqrt(g l).

    A free fall may be sqrt(2 x 30) long. Nearly elastic tracers reach more: f falls as
    exp(-a v^3/t), a = 8/27 for disks (and 1/3 for spheres), up to the speeds of the steady state.
    """
    fall = math.log(1.0 / accuracy) + 6.0
    free = math.sqrt(2.0 * fall)
    growing = (27.0 / 8.0 * fall * time) ** (1.0 / 3.0)
    if not law.is_elastic:
        growing = min(growing, highest_speed(law, accuracy))
    return max(free, growing)


def scales(values: FloatArray) -> FloatArray:
    """What errors of the averages are relative to, shape of values (n_times, n_observables).

    The root mean square for velocities and displacements, <v^2> and <r^2> for the tensors.
    """
    speed = np.abs(values[:, ALL.index("v^2")])  # what is resolved too coarsely may be negative
    square = np.abs(sum(values[:, ALL.index(name)] for name in SQUARES))
    out = np.empty_like(values)
    for name, scale in (
        *((name, np.sqrt(speed)) for name in ("v_x", "v_y")),
        *((name, speed) for name in ("v^2", "v^2 cos 2", "v_x v_y")),
        *((name, np.sqrt(square)) for name in ("x", "y")),
        *((name, square) for name in (*SQUARES, "x y")),
        *((name, np.abs(values[:, ALL.index(name)])) for name in ("v^3", "v^4", "collisions")),
    ):
        out[:, ALL.index(name)] = scale
    return out
