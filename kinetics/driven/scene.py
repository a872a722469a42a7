"""Scenes with driven tracers, or a restitution that depends on the impact speed, over time."""

from __future__ import annotations

import bisect
import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.driven.axis import SpeedAxis
from kinetics.driven.generator import Generator, Resolution
from kinetics.driven.steady import angular_sum
from kinetics.driven.system import System
from kinetics.errors import InputError, PlanStep
from kinetics.field import radau
from kinetics.field.evolution import ALL, INTEGRALS, SHORTEST_TIME, March
from kinetics.field.scene import DENSITIES, MADE_OF, FieldScene
from kinetics.numerics import FloatArray, one_blas_thread
from kinetics.numerics.blocks import BlockElimination
from kinetics.states.state import State

_MOST_NODES, _MOST_HARMONICS, _MOST_STEPS = 180, 50, 2000
_RANGE = 6.0  # of the highest speeds at times that are solved together
_DECADES = 10.0  # the power of the axis where nothing drives: v^(1/10) is smooth on it
_BEST_DENSITY = 1e-4
_DIRECTED = {"mean_displacement", "mean_velocity", "velocity_tensor", "displacement_tensor"}
_TAIL = 1e-3  # of the tolerance: the share of tracers above the top
_TRIED = np.linspace(0.05, 3.0, 60)  # speeds, over the thermal one, at which densities are compared


class _Equation:
    """The distribution, and its first moments of the place, over one step after another.

    Fields are f and x f of family 0 and y f of family 1; without a field, from an isotropic start,
    y f is as x f. Each is the averages of the polynomials of the axis, (M + 1, nodes).
    """

    def __init__(self, generator: Generator, along_only: bool) -> None:
        self.generator, self.families = generator, 1
        self.fields = [0, 0] if along_only else [0, 0, 1]
        self._modes = radau.modes()
        self._factors: tuple[float, list[dict[int, BlockElimination]]] = (0.0, [])

    def averages(self, f: FloatArray) -> FloatArray:
        """As `kinetics.field.forward.AVERAGES`, of (n, n_fields, M + 1, nodes)."""
        one, last = self.generator, f.shape[1] - 1
        v, none = one.axis.speeds, np.zeros(len(f))
        along, across = f[:, 1, 1] @ v, f[:, last, 1] @ v
        return np.stack(
            [
                *(f[:, 0, 1] @ v, none, f[:, 0, 0] @ v**2, f[:, 0, 2] @ v**2, none),
                *(f[:, 0, 0] @ v**4, f[:, 0, 0] @ one.rate, along, across, none),
                f[:, 0, 0].sum(axis=1),
            ],
            axis=1,
        )

    def step(self, f: FloatArray, h: float, source: FloatArray | None) -> FloatArray:
        """At all points of a step, (STAGES + 1, *f.shape)."""
        one = self.generator
        if h != self._factors[0]:
            shifts = [1.0 / (h * value) for value, *_ in self._modes]
            used = set(self.fields)
            self._factors = h, [{k: one.elimination(k, z) for k in used} for z in shifts]
        out = np.zeros((radau.STAGES + 1, *f.shape))
        out[0] = f
        for (value, share, _, stages), by_family in zip(self._modes, self._factors[1], strict=True):
            found: NDArray[Any] = np.zeros(f.shape, dtype=complex)
            for k, family in enumerate(self.fields):
                right = share / (h * value) * f[k]
                if k == 1:
                    right = right + one.along(found[0])
                elif k == 2:
                    right = right + one.across(found[0])
                found[k, family:] = by_family[family].solve(right[family:])
            out[1:] += (stages[:, None, None, None] * found).real
        return out


def _scale(system: System, time: float, top: float) -> float:
    """The scale of the axis up to a time: below 1/t no tracer has collided."""
    return min(max(system.scale, math.sqrt(system.field), 0.5 / time), top)


class _Evolution(March):
    """One start over time, in units of l and U; as in a field, on the axis of driven tracers."""

    most_steps = _MOST_STEPS

    def __init__(
        self, system: System, state: State, times: FloatArray, resolution: Resolution,
        asked: frozenset[str], densities: bool, isotropic: bool,
    ) -> None:  # fmt: skip
        """isotropic : only the speeds of the start count."""
        self.times, self.resolution, self.asked = times, resolution, asked
        self._densities, last = densities, max(float(times[-1]), SHORTEST_TIME)
        measures = [
            state.harmonic(m, 0.1 * resolution.rtol, 0.0, 4.0)
            for m in range(1 if isotropic else resolution.harmonics + 1)
        ]
        assert measures[0] is not None
        fastest = float(np.exp(measures[0].x.max()))
        driven = system.is_driven
        top = system.top(_TAIL * resolution.rtol, last, fastest)
        power, scale = (1.0, _scale(system, last, top)) if driven else (_DECADES, 8.0 * top)
        axis = SpeedAxis(top, scale, resolution.nodes, power, system.bath_speed > 0.0)
        self.axis = axis
        equation = _Equation(Generator(system, axis, resolution), isotropic)
        begin = np.zeros((len(equation.fields), resolution.harmonics + 1, axis.size))
        for m, measure in enumerate(measures):
            if measure is not None:
                if np.iscomplexobj(measure.weight) and np.abs(measure.weight.imag).max() > 1e-9:
                    text = "in a field, and for outputs with a direction, it must be symmetric"
                    raise InputError(f"initial: of a driven tracer, {text} about the x axis")
                profile = state.profile(m) if densities else None
                if profile is None:
                    begin[0, m] = measure.weight.real @ axis.rows(np.exp(measure.x), m % 2)
                else:
                    begin[0, m] = axis.averaged(lambda v, of=profile: np.real(of(v)), m % 2)  # type: ignore[misc]
        self.sums = np.zeros((times.size, *begin.shape[1:]))
        self._run(equation, begin, fastest)

    def _keep(self, now: float, h: float, stages: FloatArray) -> None:
        if self._densities:
            inside = (self.times >= now) & (self.times <= now + h)
            rows = radau.rows((self.times[inside] - now) / h)
            self.sums[inside] = np.tensordot(rows, stages[:, 0], axes=1)


@dataclass
class DrivenScene(FieldScene):
    """What a scene with driven tracers asks, and its answer; see FieldScene.

    Parameters
    ----------
    law : of which the dimension is used; the other arguments are as for FieldScene
    system : what drives the tracer, in units of l
    """

    system: System = field(default_factory=lambda: System(1.0))

    def __post_init__(self) -> None:
        self._speed, self._time = 1.0, self.path
        self._scaled = self.times / self.path
        self.allowed = {"averages": self.rtol}
        if {"speed_density", "velocity_density"} & set(self.outputs):
            self.allowed[DENSITIES] = max(self.rtol, _BEST_DENSITY)
        self._solve()

    @one_blas_thread
    def _solve(self) -> None:
        """Times at which tracers are about as fast are solved together."""
        self._parts: list[_Evolution] = []
        self.errors = dict.fromkeys(self.allowed, 0.0)
        end = self._scaled.size
        while end > 0:
            far = self._top(end - 1) / _RANGE
            begin = bisect.bisect_left(range(end - 1), True, key=lambda i: self._top(i) >= far)
            part, errors = self._refined(self._scaled[begin:end])
            self._parts.insert(0, part)
            self.errors = {name: max(errors[name], x) for name, x in self.errors.items()}
            end = begin

    def _top(self, i: int) -> float:
        return self.system.top(_TAIL * self.rtol, max(float(self._scaled[i]), SHORTEST_TIME), 6.0)

    def _refined(self, times: FloatArray) -> tuple[_Evolution, dict[str, float]]:
        """The best solution up to some times, and its errors."""
        last = max(float(times[-1]), SHORTEST_TIME)
        scale = _scale(self.system, last, math.inf)
        span = math.asinh(self.system.top(_TAIL * self.rtol, last, 6.0) / scale)
        there = self.state.highest_harmonic
        more = Resolution.first(self.system, self.rtol, span, max(2, 2 if there is None else there))
        asked = frozenset({"v^2"}.union(*(MADE_OF.get(name, set()) for name in self.outputs)))
        fixed = self.system, self.state, times
        # without a field what has no direction forgets those of the start
        directed = (_DIRECTED | {"velocity_density"}) & set(self.outputs)
        alike = not self.system.field and (there == 0 or not directed)
        rest = asked, DENSITIES in self.allowed, alike
        one = best = _Evolution(*fixed, more, *rest)
        least, worst = dict.fromkeys(self.allowed, math.inf), math.inf
        more = more.finer()
        while (
            worst > 1.0
            and more.nodes <= _MOST_NODES
            and more.harmonics <= _MOST_HARMONICS
            and one.steps < _MOST_STEPS
        ):
            before, one = one, _Evolution(*fixed, more, *rest)
            more = more.finer()
            errors = {"averages": one.difference(before)}
            if DENSITIES in self.allowed:
                errors[DENSITIES] = self._apart(one, before)
            missed = max(errors[part] / self.allowed[part] for part in errors)
            if missed < worst:
                best, least, worst = one, errors, missed
        return best, least

    def _apart(self, one: _Evolution, two: _Evolution) -> float:
        """The largest difference of two densities of the speed, over their maximum."""
        worst = 0.0
        for i, square in enumerate(one.values[:, ALL.index("v^2")]):
            v = math.sqrt(max(square, 0.0)) * _TRIED
            pair = [self._speed_density(e, i, v) for e in (one, two)]
            scale = max(float(np.abs(pair[0]).max()), 1e-300)
            worst = max(worst, float(np.abs(pair[0] - pair[1]).max()) / scale)
        return worst if math.isfinite(worst) else math.inf

    @property
    def plan(self) -> tuple[PlanStep, PlanStep]:
        """What was solved, and how."""
        one = self._parts[-1]
        how = (
            f"generator for {', '.join(self.outputs)}: harmonics 0 to {one.resolution.harmonics}, "
            f"{one.axis.size} speeds up to {one.axis.highest:.3g} U, {one.steps} steps of "
            f"time; a solution with fewer differs by {self.errors['averages']:.1e}"
        )
        asked = DENSITIES in self.errors
        words = "from the averages of polynomials" if asked else "not asked for"
        return PlanStep("averages", True, how), PlanStep(DENSITIES, asked, words)

    @property
    def stats(self) -> dict[str, Any]:
        """Numbers about the work."""
        parts = self._parts
        return {
            "harmonics": max(one.resolution.harmonics for one in parts),
            "nodes": max(one.axis.size for one in parts),
            "steps": sum(one.steps for one in parts),
        }

    # -- averages ---------------------------------------------------------------------------------

    @cached_property
    def _of(self) -> dict[str, FloatArray]:
        """If some stick: of the velocity over those that move, of the place over all."""
        rows = np.vstack([one.values for one in self._parts])
        found = dict(zip(ALL, rows.T, strict=True))
        kept = {"1", *INTEGRALS}
        return {name: x if name in kept else x / found["1"] for name, x in found.items()}

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
        return np.array(
            [self._speed_density(one, i, v) for one in self._parts for i in range(one.times.size)]
        )

    def _speed_density(self, one: _Evolution, i: int, v: FloatArray) -> FloatArray:
        d = self.law.dimension
        return one.axis.density(one.sums[i, :1], v, d)[0] * v ** (d - 1.0)

    def velocity_density(self, v: FloatArray, phi: FloatArray) -> FloatArray:
        """In U^-d at all times, shape (n_times, n_v, n_phi)."""
        d = self.law.dimension
        return np.array(
            [
                angular_sum(one.axis.density(f, v, d), phi, d)
                for one in self._parts
                for f in one.sums
            ]
        )
