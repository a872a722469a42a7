"""Scenes with driven tracers, or a restitution that depends on the impact speed, over time."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.special import logsumexp

from kinetics.drive import Drive
from kinetics.driven import radau
from kinetics.driven.axis import FADING, SpeedAxis
from kinetics.driven.driven_state import angular_sum
from kinetics.driven.field_answer import DENSITIES, FieldScene
from kinetics.driven.generator import SLOWLY, TRIED, Generator, Resolution
from kinetics.driven.march import ALL, INTEGRALS, SHORTEST_TIME, Equation, March
from kinetics.driven.speed_range import TAIL_OVER_TOLERANCE, collision_rate, top_speed
from kinetics.driven.starts import Start
from kinetics.errors import InputError
from kinetics.numerics import FloatArray
from kinetics.numerics.refinement import RefinementRules, refine_until_converged
from kinetics.states.state import State

_DIRECTED = {"mean_displacement", "mean_velocity", "velocity_tensor", "displacement_tensor"}


def _scale(drive: Drive, time: float, top: float) -> float:
    """The scale of the axis up to a time: below 1/t no tracer has collided."""
    return min(max(drive.scale, math.sqrt(drive.field), 0.5 / time), top)


class _Evolution(March):
    """One start over time, in units of l and U; as in a field, on the axis of driven tracers."""

    most_steps = 2000

    def __init__(
        self, drive: Drive, state: State, times: FloatArray, asked: frozenset[str],
        densities: bool, isotropic: bool, resolution: Resolution,
    ) -> None:  # fmt: skip
        """isotropic : only the speeds of the start count."""
        self.times, self.resolution, self.asked = times, resolution, asked
        self._densities, last = densities, max(float(times[-1]), SHORTEST_TIME)
        measures = [
            state.harmonic(m, 0.1 * resolution.rtol, 0.0, 4.0)
            for m in range(1 if isotropic else resolution.harmonics + 1)
        ]
        start = Start(tuple(measures), 1.0)
        if not start.is_symmetric:
            text = "in a field, and for outputs with a direction, it must be symmetric"
            raise InputError(f"initial: of a driven tracer, {text} about the x axis")
        driven, tail, fastest = (
            drive.is_driven,
            TAIL_OVER_TOLERANCE * resolution.rtol,
            start.highest,
        )
        speeds: Any = measures[0]  # never None
        if driven:
            # what fades towards the top changes averages of the start by less than the tail does
            share = logsumexp(FADING * speeds.x, b=abs(speeds.weight)) - math.log(tail)
            fastest = max(fastest, math.exp(share / FADING))
        top = top_speed(drive, tail, last, fastest)
        power, scale = (1.0, _scale(drive, last, top)) if driven else (10.0, 8.0 * top)
        axis = SpeedAxis(top, scale, resolution.nodes, power, drive.bath_speed > 0.0)
        self.axis = axis
        one, fields = Generator(drive, axis, resolution), [("f", 0), ("x", 0), ("y", 1)]
        self._finer = one.finer
        if isotropic:  # y f is as x f
            fields = fields[:2]
        equation = Equation(one.chain, fields, axis.speeds, one.rate)
        begin = np.zeros((len(fields), resolution.harmonics + 1, axis.size))
        begin[:1] = start.projected(axis, begin.shape[1], 1, state if densities else None)
        self.sums = np.repeat(begin[:1], times.size, axis=0)
        self.values = np.zeros((times.size, len(ALL)))
        if times[-1] > 0.0:
            self._run(equation, begin, fastest)
        # the rate of the start, which bends at rest, is known; what it is off lasts a collision
        rate = float(speeds.weight.real @ collision_rate(drive, np.exp(speeds.x)))
        off = abs(begin[0, 0] @ one.rate - rate) * np.minimum(times, 1.0 / max(rate, 1e-300))
        counted = self.values[:, ALL.index("collisions")]
        there = (times > 0.0) & (counted > 0.0) & ("collisions" in asked)
        self.missed = float(np.max(off[there] / counted[there], initial=0.0))
        # at time 0 all is known from the start
        known = dict.fromkeys(ALL, 0.0) | {"1": 1.0}
        for name, power, m in (("v_x", 1, 1), ("v^2", 2, 0), ("v^4", 4, 0), ("v^2 cos 2", 2, 2)):
            if m < len(measures) and (points := measures[m]) is not None:
                known[name] = float(points.weight.real @ np.exp(power * points.x))
        self.values[times == 0.0] = list(known.values())

    @property
    def finer(self) -> Resolution | None:
        """A finer resolution; None where there is none."""
        return self._finer if self.tries < self.most_steps else None

    def _keep(self, now: float, h: float, stages: FloatArray) -> None:
        if self._densities:
            inside = self._inside(now, h)
            rows = radau.rows((self.times[inside] - now) / h)
            self.sums[inside] = np.tensordot(rows, stages[:, 0], axes=1)


@dataclass
class DrivenScene(FieldScene):
    """What a scene with driven tracers asks, and its answer; system : in units of l."""

    drive: Drive = field(default_factory=lambda: Drive(restitution=1.0))

    def _units(self) -> tuple[float, FloatArray]:
        return 1.0, self.times / self.path

    def _top(self, i: int) -> float:
        return top_speed(
            self.drive,
            TAIL_OVER_TOLERANCE * self.rtol,
            max(float(self._scaled[i]), SHORTEST_TIME),
            6.0,
        )

    def _refined(self, times: FloatArray) -> tuple[_Evolution, dict[str, float]]:
        """The best solution up to some times, and its errors."""
        last = max(float(times[-1]), SHORTEST_TIME)
        top = top_speed(self.drive, TAIL_OVER_TOLERANCE * self.rtol, last, 6.0)
        span = math.asinh(top / _scale(self.drive, last, math.inf))
        there = self.state.highest_harmonic
        first = Resolution.first(self.drive, self.rtol, span, max(2, there or 0))
        # without a field what has no direction forgets those of the start
        directed = (_DIRECTED | {"velocity_density"}) & set(self.outputs)
        alike = not self.drive.field and (there == 0 or not directed)
        names = self._asked | ({"1"} if self.drive.capture_speed else set())
        asked = names, DENSITIES in self.allowed, alike

        def solve(one: Resolution) -> _Evolution:
            # in the end two lengths of steps in turn: ever shorter ones would be lost in rounding
            rtol = one.rtol * (25.0 if one.rtol < 0.005 * first.rtol else 1.0)
            return _Evolution(self.drive, self.state, times, *asked, replace(one, rtol=rtol))

        earlier = 1.0 if self.drive.sticks_sharply else 0.3  # of starts that bend at rest
        rules = RefinementRules(min_ratio_to_previous=earlier)
        return refine_until_converged(solve, first, self._apart, self.allowed, rules)

    def _apart(self, one: Any, two: Any) -> dict[str, float]:
        """Two solutions; their errors fall more slowly where averages bend."""
        errors = super()._apart(one, two)
        apart = errors["averages"] * (SLOWLY if self.drive.sticks_sharply else 1.0)
        return errors | {"averages": max(apart, one.missed)}

    def _densities_apart(self, one: Any, two: Any) -> float:
        """Of the speed, over their maximum."""
        worst = 0.0
        for i, square in enumerate(one.values[:, ALL.index("v^2")]):
            v = math.sqrt(max(square, 0.0)) * TRIED
            f, other = (self._speed_density(e, i, v) for e in (one, two))
            apart = float(np.abs(f - other).max() / max(np.abs(f).max(), 1e-300))
            worst = max(worst, apart if math.isfinite(apart) else math.inf)
        return worst

    @cached_property
    def _of(self) -> dict[str, FloatArray]:
        """If some stick: of the velocity over those that move, of the place over all."""
        found, kept = super()._of, {"1", *INTEGRALS} if self.drive.capture_speed else set(ALL)
        left = np.where(found["1"] > 0.0, found["1"], np.nan)  # none may be left
        return {name: x if name in kept else x / left for name, x in found.items()}

    @property
    def captured(self) -> FloatArray:
        """The share of tracers that stick, (n_times,)."""
        return 1.0 - self._of["1"]

    @property
    def values(self) -> dict[str, Any]:
        """The arrays of the outputs, in U and d."""
        found, d = super().values, self.law.dimension
        if "diffusion_coefficient" in self.outputs:
            slope = self._of["1"] * (self._of["v_x x"] + (d - 1.0) * self._of["v_y y"])
            found["diffusion_coefficient"] = self.path * slope / d
            found["msd_slope"] = 2.0 * self.path * slope * self.times
        return found

    # -- densities --------------------------------------------------------------------------------

    @property
    def uncollided(self) -> FloatArray:
        """0: nothing is left out."""
        return np.zeros(self.times.shape)

    def speed_density(self, v: FloatArray) -> FloatArray:
        """In 1/U at all times, shape (n_times, n_v)."""
        parts = ((one, i) for one in self._parts for i in range(one.times.size))
        return np.array([self._speed_density(one, i, v) for one, i in parts])

    def _speed_density(self, one: _Evolution, i: int, v: FloatArray) -> FloatArray:
        d = self.law.dimension
        return one.axis.density(one.sums[i, :1], v, d)[0] * v ** (d - 1.0)

    def velocity_density(self, v: FloatArray, phi: FloatArray) -> FloatArray:
        """In U^-d at all times, shape (n_times, n_v, n_phi)."""
        d, parts = self.law.dimension, ((one.axis, f) for one in self._parts for f in one.sums)
        return np.array([angular_sum(axis.density(f, v, d), phi, d) for axis, f in parts])
