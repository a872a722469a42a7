"""Averages over time in a field, for one initial state; steps grow as they become smooth."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, ClassVar, Protocol

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.field import radau
from kinetics.field.forward import AVERAGES, ForwardEquation
from kinetics.field.grid import Resolution, SpeedPanels, reached_speed
from kinetics.field.starts import Start
from kinetics.numerics import FloatArray
from kinetics.states.state import State

INTEGRALS = {"x": (0, 1.0), "y": (1, 1.0), "collisions": (6, 1.0)}
INTEGRALS |= {"x^2": (7, 2.0), "y^2": (8, 2.0), "x y": (9, 1.0)}
"""What grows over time -> the average that it grows with, and a factor."""
ALL = (*AVERAGES, *INTEGRALS)
SQUARES = frozenset({"x^2", "y^2", "x y"})
_SMOOTH = 64.0  # by which a step may be smoother than is asked before it is doubled
_STEPS_MISS = 30.0  # rough steps miss less at their ends, by more than this
_SHORTEST = 1e-10  # step, of the last time: below it nothing becomes smoother
SHORTEST_TIME = 1e-12
_FIRST = 0.5  # of the first step, in free flights of the fastest


class Equation(Protocol):
    """What takes distributions over a step of time."""

    def averages(self, f: FloatArray) -> FloatArray:
        """`AVERAGES` of distributions (n, *shape), shape (n, n_averages)."""

    def step(self, f: FloatArray, h: float, source: FloatArray | None) -> FloatArray:
        """The distribution at all points of a step, (STAGES + 1, *shape)."""


class March:
    """One start over time, step after step.

    times : rising, shape (n_times,)
    resolution : with the ``rtol`` of the steps
    asked : names of `ALL` that steps must resolve; others may be less accurate, or 0
    values : `ALL`, shape (n_times, n_averages)
    steps : their number
    """

    # then steps are taken as they are: another resolution says that this one fails
    most_steps: ClassVar[int] = 300

    times: FloatArray
    resolution: Any
    asked: frozenset[str]
    values: FloatArray
    steps: int

    def _uncollided(self, times: FloatArray) -> FloatArray | float:
        """What tracers in closed form add to the averages, (n, n_averages)."""
        return 0.0

    def _early(self, now: float, h: float) -> tuple[FloatArray, FloatArray] | None:
        """Their distribution at the points of a step, and what they are a source of."""
        return None

    def _keep(self, now: float, h: float, stages: FloatArray) -> None:
        """What densities need of an accepted step that begins now and is h long."""

    def _run(self, equation: Equation, f: FloatArray, fastest: float) -> None:
        """From f on, up to the last time or beyond it; fastest : the highest speed in f."""
        self.values, self.steps = np.zeros((self.times.size, len(ALL))), 0
        now, last = 0.0, max(float(self.times[-1]), SHORTEST_TIME)
        # at the first of the times averages may be small, as the fourth power of the time
        h = min(_FIRST / (1.0 + fastest), *self.times[self.times > 0.0][:1], last)
        totals, allowed = np.zeros(len(INTEGRALS)), _STEPS_MISS * self.resolution.rtol
        grows = [one for one, _ in INTEGRALS.values()]
        factor = np.array([factor for _, factor in INTEGRALS.values()])
        tried = 0
        while now < last or tried == 0:
            tried += 1
            early, source = self._early(now, h) or (0.0, None)
            stages = equation.step(f, h, source)
            averages = equation.averages(stages)
            total = averages + self._uncollided(now + h * radau.POINTS)
            grown = totals + h * (radau.integral_rows(radau.POINTS) @ total[:, grows]) * factor
            left = radau.roughness(averages)
            left = np.append(left, h * radau.roughness(total)[grows] * factor)
            rough = self._relative(left[None], np.hstack([total, grown])[-1:])
            if rough > allowed and tried < self.most_steps and h > _SHORTEST * last:
                h *= 0.5
                continue
            inside = (self.times >= now) & (self.times <= now + h)
            local = (self.times[inside] - now) / h
            found = radau.rows(local) @ averages + self._uncollided(self.times[inside])
            made = totals + h * (radau.integral_rows(local) @ total[:, grows]) * factor
            self.values[inside] = np.hstack([found, made])
            self._keep(now, h, stages + early)
            self.steps += 1
            now, f, totals = now + h, stages[-1], grown[-1]
            if rough * _SMOOTH < allowed or tried >= self.most_steps:
                h *= 2.0

    def _relative(self, missed: FloatArray, values: FloatArray) -> float:
        """The largest of what values (n, n_averages) miss, relative to the scale of each."""
        of = {name: np.abs(values[:, i]) for i, name in enumerate(ALL)}
        speed, square = of["v^2"], of["x^2"] + of["y^2"]
        scale = of | dict.fromkeys(("v_x", "v_y"), np.sqrt(speed))
        scale |= dict.fromkeys(("v^2 cos 2", "v_x v_y"), speed)
        scale |= dict.fromkeys(("x", "y"), np.sqrt(square)) | dict.fromkeys(SQUARES, square)
        used = [ALL.index(name) for name in self.asked]
        sizes = np.stack([scale[ALL[i]] for i in used], axis=1)
        found = np.abs(missed[:, used])[sizes > 0.0] / sizes[sizes > 0.0]
        worst = float(np.max(found, initial=0.0))
        return worst if math.isfinite(worst) else math.inf

    def difference(self, coarse: March) -> float:
        """The largest difference from another solution, relative to the scale of each average."""
        return self._relative(self.values - coarse.values, self.values)


@dataclass
class Evolution(March):
    """One start over time, in units of sqrt(g l) and sqrt(l/g).

    law, start : the collision law, and the initial state
    times, resolution, asked : as of a March; panels, harmonics and steps
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
        self.panels = SpeedPanels.rising(highest, lowest, one.nodes)
        symmetric = self.start.is_symmetric
        moving = bool(self.asked & SQUARES)
        self.equation = ForwardEquation(self.law, self.panels, one.harmonics, symmetric, moving)
        self._run(self.equation, self._begin(), self.start.highest)

    def _begin(self) -> FloatArray:
        equation = self.equation
        f = np.zeros((len(equation.fields), equation.highest + 1, self.panels.size))
        if self.start.velocities is None:
            count, families = equation.highest + 1, equation.families
            sums = self.start.projected(self.panels, count, families)
            if self.state is not None:
                sums = self.start.smooth(self.state, self.panels, sums, self.resolution.rtol)
            f[:families] = equation.density(sums)
        return f

    def _uncollided(self, times: FloatArray) -> FloatArray | float:
        velocities = self.start.velocities
        if velocities is None or not times.size:
            return 0.0
        return np.array([velocities.averages(float(t)) for t in times])

    def _early(self, now: float, h: float) -> tuple[FloatArray, FloatArray] | None:
        velocities, equation = self.start.velocities, self.equation
        if velocities is None:
            return None
        count, fine = equation.highest + 1, now + h * radau.FINE
        sums = velocities.projected(fine, self.panels, count, equation.fields)
        early = radau.projected(equation.density(sums))
        return early, equation.gained(early[1:])

    def _keep(self, now: float, h: float, stages: FloatArray) -> None:
        if self.state is not None:
            made = self.equation.gained(stages[:, : self.equation.families]) * self.panels.speeds
            self.made.append((now, h, made))
