"""Scenes with a field: averages and densities of the velocity over time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.errors import InputError, PlanStep, SolverStatus, judged, short
from kinetics.field.density import VelocityDensity
from kinetics.field.evolution import ALL, Evolution
from kinetics.field.grid import Resolution
from kinetics.field.starts import Start
from kinetics.numerics import FloatArray, one_blas_thread
from kinetics.states.state import State

DENSITIES = "densities"
_BEST_DENSITY, _LEAST_NEGATIVE = 1e-4, 1e-5
_MOST_HARMONICS = 40  # seconds, and 200 MB of memory
_AT_REST = 0.1  # starts slower than this, times rtol and the first time, are at rest
MADE_OF = {
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
    negative = 0.0  # by so much of its maximum a density is below zero

    def __post_init__(self) -> None:
        self._speed, self._time = (
            math.sqrt(self.field * self.path),
            math.sqrt(self.path / self.field),
        )
        with np.errstate(over="ignore"):
            self._scaled = self.times / self._time
        if not (1e-100 < self._speed < 1e100 and self._scaled[-1] < 1e15):
            raise InputError(
                f"field: got {short(self.field)}; sqrt(field x mean free path) and the times in "
                "sqrt(mean free path/field) are out of range"
            )
        self.allowed = {"averages": self.rtol}
        if set(self.outputs) & _FUNCTIONS:
            self.allowed[DENSITIES] = max(self.rtol, _BEST_DENSITY)
        self._solve()
        if self.densities is not None and self.densities.is_sharp:
            self.negative = self.densities.negative()
            self.errors[DENSITIES] = max(self.errors[DENSITIES], self.negative)

    @one_blas_thread
    def _solve(self) -> None:
        """Ever more finely resolved until two solutions agree."""
        fine, worst = self._evolution(Resolution.over_time(self.rtol)), math.inf
        while True:
            coarse, fine = fine, self._evolution(fine.resolution.finer())
            errors = {"averages": fine.difference(coarse)}
            densities = None
            if DENSITIES in self.allowed:
                densities = VelocityDensity(fine, self.state, self._speed)
                errors[DENSITIES] = densities.difference(
                    VelocityDensity(coarse, self.state, self._speed)
                )
            missed = max(errors[part] / self.allowed[part] for part in errors)
            if worst < math.inf and not missed < worst:
                break
            self.evolution, self.errors, self.densities, worst = fine, errors, densities, missed
            # densities of sharp velocities have fronts, which finer solutions hardly mend
            sharp = densities is not None and densities.is_sharp
            if max(errors["averages"] / self.rtol, 0.0 if sharp else missed) <= 1.0:
                break
            if fine.resolution.finer().harmonics > _MOST_HARMONICS:
                break

    def _evolution(self, resolution: Resolution) -> Evolution:
        start = Start.of(
            self.state, 0.1 * self.rtol, 1.0 / self._speed, resolution.harmonics, self.law.dimension
        )
        # isotropic starts change averages by the square of their velocities
        isotropic = self.state.highest_harmonic == 0
        small = math.sqrt(self.rtol) if isotropic else self.rtol
        if start.highest < _AT_REST * small * min(1.0, float(self._scaled[0])):
            start = Start.rest(self.law.dimension)
        asked = frozenset({"v^2"}.union(*(MADE_OF.get(name, set()) for name in self.outputs)))
        state = self.state if DENSITIES in self.allowed else None
        return Evolution(self.law, start, self._scaled, resolution, asked, state)

    @property
    def verdict(self) -> tuple[SolverStatus, str]:
        """The status, and the message."""
        status, message = judged(self.errors, self.allowed)
        if self.negative > _LEAST_NEGATIVE:
            message += f"; densities are negative, by up to {self.negative:.0e} of their maximum"
        return status, message

    @property
    def plan(self) -> tuple[PlanStep, PlanStep]:
        """What was solved, and how."""
        one, error = self.evolution, self.errors.get(DENSITIES)
        velocities, start = one.start.velocities, "its harmonics"
        if velocities is not None:
            start = f"{velocities.along.size} velocities, in closed form until they collide"
        how = (
            f"forward equation for {', '.join(self.outputs)}: harmonics 0 to "
            f"{one.resolution.harmonics}, {one.panels.size} speeds up to {one.panels.highest:.3g} "
            f"sqrt(g l), {one.steps} steps of time, the start by {start}; a solution with fewer "
            f"differs by {self.errors['averages']:.1e}"
        )
        density = "not asked for"
        if error is not None:
            density = "an integral over the last free flight, and what has not collided in closed "
            density += f"form; the coarser solution differs by {error:.1e} of the maximum"
        return (
            PlanStep("averages in a field", True, how),
            PlanStep(DENSITIES, error is not None, density),
        )

    @property
    def stats(self) -> dict[str, Any]:
        """Numbers about the work."""
        panels = self.evolution.panels
        return {
            "harmonics": self.evolution.resolution.harmonics,
            "panels": len(panels.counts),
            "nodes": panels.size,
            "steps": self.evolution.steps,
        }

    # -- averages ---------------------------------------------------------------------------------

    @cached_property
    def _of(self) -> dict[str, FloatArray]:
        return dict(zip(ALL, self.evolution.values.T, strict=True))

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
        squares = self._tensor(of["x^2"], of["x y"], of["y^2"])
        with np.errstate(divide="ignore", invalid="ignore"):
            excess = d / (d + 2.0) * of["v^4"] / second**2 - 1.0
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
            "displacement_tensor": path**2
            * (squares - displacement[:, :, None] * displacement[:, None, :]),
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
        out = np.zeros((xx.size, d, d))
        out[:, 0, 0] = xx
        for i in range(1, d):
            out[:, i, i] = yy
        if d == 2:
            out[:, 0, 1] = out[:, 1, 0] = xy
        return out

    # -- densities --------------------------------------------------------------------------------

    @property
    def uncollided(self) -> FloatArray:
        """See `VelocityDensity`."""
        assert self.densities is not None
        return self.densities.uncollided

    def speed_density(self, v: FloatArray) -> FloatArray:
        """In 1/U at all times, shape (n_times, n_v)."""
        assert self.densities is not None
        one = self.densities.by_speed
        return np.array([one(i, v / self._speed) for i in range(self.times.size)]) / self._speed

    def component_density(self, v_x: FloatArray) -> FloatArray:
        """Not available."""
        raise InputError(
            "velocity_component_density: it is not available in a field, nor of driven tracers; "
            "integrate velocity_density"
        )

    def velocity_density(self, v: FloatArray, phi: FloatArray) -> FloatArray:
        """In U^-d at all times, shape (n_times, n_v, n_phi)."""
        assert self.densities is not None
        along = np.outer(v / self._speed, np.cos(phi)).ravel()
        across = np.outer(v / self._speed, np.sin(phi)).ravel()
        found = [self.densities.at(i, along, across) for i in range(self.times.size)]
        return np.reshape(found, (self.times.size, v.size, phi.size)) / (
            self._speed**self.law.dimension
        )
