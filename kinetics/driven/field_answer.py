"""Scenes with a field: averages and densities of the velocity over time."""

from __future__ import annotations

import bisect
import math
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, NoReturn

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.drive import Drive
from kinetics.driven.last_flights import VelocityDensity, is_sharp
from kinetics.driven.march import ALL, SHORTEST_TIME, Evolution
from kinetics.driven.panels import Resolution
from kinetics.driven.speed_range import TAIL_OVER_TOLERANCE, top_speed
from kinetics.driven.starts import Start
from kinetics.errors import InputError, PlanStep, SolverStatus, judge_errors, short
from kinetics.numerics import FloatArray, one_blas_thread
from kinetics.numerics.refinement import refine_until_converged
from kinetics.states.state import State

DENSITIES = "densities"
START = "initial state"
BEST_DENSITY = 1e-4
_RANGE = 6.0  # of the highest speeds at times solved together: slow ones need finer panels
_MADE_OF = {
    "a2": {"v^4"},
    "collisions": {"collisions"},
    "msd": {"x^2", "y^2"},
    "mean_displacement": {"x", "y", "x^2", "y^2"},  # relative to the root mean square
    "mean_velocity": {"v_x", "v_y"},
    "velocity_tensor": {"v^2 cos 2", "v_x v_y"},
    "displacement_tensor": {"x", "y", "x^2", "y^2", "x y"},
}
_FUNCTIONS = {"speed_density", "velocity_density"}


@dataclass
class FieldScene:
    """What a scene with a field asks, and its answer.

    Errors are relative to the root mean square for velocities and displacements, to <v^2> and
    <r^2> for the tensors, and to the largest density at each time. They are the difference from a
    solution with fewer speeds, harmonics and steps.

    law, path : the collision law, and the mean free path in d
    state : the initial state
    times : in d/U, shape (n_times,)
    field : the acceleration in U^2/d
    outputs : their names
    rtol : relative accuracy; of densities max(rtol, 1e-4)
    """

    law: CollisionLaw
    path: float
    state: State
    times: FloatArray
    field: float
    outputs: tuple[str, ...]
    rtol: float

    def __post_init__(self) -> None:
        self._speed, self._scaled = self._units()
        self.allowed = {"averages": self.rtol}
        if set(self.outputs) & _FUNCTIONS:
            self.allowed[DENSITIES] = max(self.rtol, BEST_DENSITY)
        made_of = [_MADE_OF.get(name, set()) for name in self.outputs]
        self._asked = frozenset({"v^2"}.union(*made_of))
        self._parts, self.errors = self._solved()
        self.allowed[START] = self.rtol
        self.errors[START] = self._start_error()

    def _start_error(self) -> float:
        """Relative error of averages over the start, of a density that is not resolved."""
        highest = self.state.highest_harmonic or 0
        measures = [self.state.harmonic(m, 0.1 * self.rtol, 0.0, 4.0) for m in range(highest + 1)]
        return max((measure.error for measure in measures if measure is not None), default=0.0)

    def _units(self) -> tuple[float, FloatArray]:
        """The unit of speed of the solution in U, and the times in the mean free path over it."""
        speed = math.sqrt(self.field * self.path)
        with np.errstate(over="ignore", invalid="ignore"):  # sqrt(field/path) may be infinite
            scaled = self.times * (math.sqrt(self.field) / math.sqrt(self.path))
        known = bool(np.all((scaled == 0.0) | (scaled > 1e-150) & (scaled < 1e15)))
        if not (known and 1e-100 < speed < 1e100 and 1e-150 < self.path < 1e150):
            self._refuse()
        return speed, scaled

    def _refuse(self) -> NoReturn:
        raise InputError(
            f"field: got {short(self.field)}; sqrt(field x mean free path) and the times in "
            "sqrt(mean free path/field) are out of range"
        )

    @one_blas_thread
    def _solved(self) -> tuple[list[Any], dict[str, float]]:
        """Times at which tracers are about as fast are solved together; and the largest errors."""
        parts: list[Any] = []
        worst, end = dict.fromkeys(self.allowed, 0.0), self._scaled.size
        while end > 0:
            far = self._top(end - 1) / _RANGE
            begin = bisect.bisect_left(range(end - 1), True, key=lambda i: self._top(i) >= far)
            part, errors = self._refined(self._scaled[begin:end])
            parts.insert(0, part)
            worst = {name: max(errors[name], x) for name, x in worst.items()}
            end = begin
        return parts, worst

    @cached_property
    def _fastest(self) -> float:
        """Of the start."""
        return self._start_from(1, self.rtol).highest

    def _top(self, i: int) -> float:
        """The highest speed up to the i-th time."""
        time = max(float(self._scaled[i]), SHORTEST_TIME)
        drive = Drive(restitution=self.law, dimension=self.law.dimension, field=1.0)
        return top_speed(drive, TAIL_OVER_TOLERANCE * self.rtol, time, self._fastest)

    def _refined(self, times: FloatArray) -> tuple[Any, dict[str, float]]:
        """The best solution up to some times, and its errors."""
        sharp, allowed = is_sharp(self.state), dict(self.allowed)
        if sharp:  # densities have fronts, which finer solutions hardly mend
            allowed.pop(DENSITIES, None)
        first = Resolution.over_time(self.rtol)
        found, errors = refine_until_converged(
            partial(self._evolution, times), first, self._apart, allowed
        )
        if sharp and DENSITIES in self.allowed:
            negative = self._densities(found).negative()
            errors[DENSITIES] = max(errors.get(DENSITIES, math.inf), negative)
        return found, errors

    def _densities(self, one: Evolution) -> VelocityDensity:
        return VelocityDensity(one, self.state, self._speed)

    def _apart(self, one: Any, two: Any) -> dict[str, float]:
        """How far two solutions are apart."""
        errors = {"averages": one.difference(two)}
        if DENSITIES in self.allowed:
            errors[DENSITIES] = self._densities_apart(one, two)
        return errors

    def _densities_apart(self, one: Any, two: Any) -> float:
        return self._densities(one).difference(self._densities(two))

    def _start_from(self, harmonics: int, rtol: float) -> Start:
        unit, d = 1.0 / self._speed, self.law.dimension
        return Start.of(self.state, 0.1 * rtol, unit, harmonics, d)

    def _evolution(self, times: FloatArray, resolution: Resolution) -> Evolution:
        start = self._start_from(resolution.harmonics, resolution.rtol)
        # <v^4> of such speeds overflows; flights that change them by less than 1e-12 lose digits
        if start.highest > (1e6 if DENSITIES in self.allowed else 1e40):
            self._refuse()
        # starts that change averages by less are at rest; isotropic ones by the square of theirs
        isotropic = self.state.highest_harmonic == 0
        small = math.sqrt(self.rtol) if isotropic else self.rtol
        if start.highest < 0.1 * small * min(1.0, float(times[0])):
            start = Start.rest(self.law.dimension)
        keeps_density = DENSITIES in self.allowed
        return Evolution(self.law, start, times, resolution, self._asked, self.state, keeps_density)

    @property
    def verdict(self) -> tuple[SolverStatus, str]:
        """The status, and the message."""
        return judge_errors(self.errors, self.allowed)

    @property
    def plan(self) -> tuple[PlanStep, PlanStep]:
        """What was solved, and how."""
        one, asked = self._parts[-1], DENSITIES in self.errors
        how = (
            f"{', '.join(self.outputs)}: harmonics 0 to {one.resolution.harmonics}, "
            f"{one.axis.size} speeds up to {one.axis.highest * self._speed:.3g} U, {one.steps} "
            f"steps of time; a solution with fewer differs by {self.errors['averages']:.1e}"
        )
        words = "of the maximum they differ by {densities:.1e}" if asked else "not asked for"
        density = PlanStep(DENSITIES, asked, words.format(**self.errors))
        return PlanStep("averages", True, how), density

    @property
    def stats(self) -> dict[str, Any]:
        """Numbers about the work."""
        parts, most = self._parts, max(one.resolution.harmonics for one in self._parts)
        nodes = max(one.axis.size for one in parts)
        return {"harmonics": most, "nodes": nodes, "steps": sum(one.steps for one in parts)}

    # -- averages ---------------------------------------------------------------------------------

    @cached_property
    def _of(self) -> dict[str, FloatArray]:
        rows = np.vstack([one.values for one in self._parts])
        return dict(zip(ALL, rows.T, strict=True))

    @property
    def typical_speed(self) -> FloatArray:
        """The root mean square speed in U, (n_times,)."""
        return np.asarray(self._speed * np.sqrt(np.maximum(self._of["v^2"], 0.0)))

    @property
    def values(self) -> dict[str, Any]:
        """The arrays of the outputs, in U and d."""
        of, d, speed, path = self._of, self.law.dimension, self._speed, self.path
        velocity, displacement = self._vector("v_x", "v_y"), self._vector("x", "y")
        second = np.maximum(of["v^2"], 0.0)  # where nothing is resolved it may be below
        along = (second + (d - 1.0) * of["v^2 cos 2"]) / d
        variances = self._tensor(of["x^2"], of["x y"], of["y^2"])
        variances -= displacement[:, :, None] * displacement[:, None, :]
        with np.errstate(divide="ignore", invalid="ignore"):
            excess = d / (d + 2.0) * of["v^4"] / np.where(second > 0.0, second, np.nan) ** 2 - 1.0
        velocities = self._tensor(along, of["v_x v_y"], (second - along) / (d - 1.0))
        found = {
            "thermal_speed": speed * np.sqrt(second),
            "temperature": speed**2 * second / d,
            "a2": excess,
            "collisions": of["collisions"],
            "msd": path**2 * (of["x^2"] + (d - 1.0) * of["y^2"]),
            "mean_displacement": path * displacement,
            "mean_velocity": speed * velocity,
            "velocity_tensor": speed**2 * velocities,
            "displacement_tensor": path**2 * variances,
        }
        return {name: found[name] for name in found if name in self.outputs}

    def _vector(self, *names: str) -> FloatArray:
        """Shape (n_times, d); in space the state is symmetric about x, and the others are 0."""
        out = np.zeros((self.times.size, self.law.dimension))
        out[:, :2] = np.stack([self._of[name] for name in names], axis=-1)
        return out

    def _tensor(self, xx: FloatArray, xy: FloatArray, yy: FloatArray) -> FloatArray:
        """Shape (n_times, d, d); in space the state is symmetric about x."""
        d = self.law.dimension
        out = yy[:, None, None] * np.eye(d)
        out[:, 0, 0] = xx
        if d == 2:
            out[:, 0, 1] = out[:, 1, 0] = xy
        return out

    # -- densities --------------------------------------------------------------------------------

    @cached_property
    def _at_times(self) -> list[tuple[VelocityDensity, int]]:
        """Of each time its solution, and its place there."""
        solved = [(self._densities(one), one.times.size) for one in self._parts]
        return [(one, i) for one, count in solved for i in range(count)]

    @property
    def uncollided(self) -> FloatArray:
        """See `VelocityDensity`."""
        return np.concatenate([one.uncollided for one, i in self._at_times if i == 0])

    @property
    def captured(self) -> FloatArray:
        """No tracer sticks: zeros, (n_times,)."""
        return np.zeros(self.times.shape)

    def speed_density(self, v: FloatArray) -> FloatArray:
        """In 1/U at all times, shape (n_times, n_v)."""
        v = v / self._speed
        return np.array([one.by_speed(i, v) for one, i in self._at_times]) / self._speed

    def component_density(self, v_x: FloatArray) -> FloatArray:
        """Not available."""
        raise InputError(
            "velocity_component_density: it is not available in a field, nor of driven tracers; "
            "integrate velocity_density"
        )

    def velocity_density(self, v: FloatArray, phi: FloatArray) -> FloatArray:
        """In U^-d at all times, shape (n_times, n_v, n_phi)."""
        along = np.outer(v / self._speed, np.cos(phi)).ravel()
        across = np.outer(v / self._speed, np.sin(phi)).ravel()
        found = [one.at(i, along, across) for one, i in self._at_times]
        shape = self.times.size, v.size, phi.size
        return np.reshape(found, shape) / self._speed**self.law.dimension
