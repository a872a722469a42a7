"""The contract of answers, and which solver answers which scene.

`Answer` is what :class:`kinetics.Solution` needs of a solver; `answer_to` picks the solver. There
are four:

- tracers that only collide: :class:`kinetics.undriven.UndrivenAnswer`
- drag, and collisions that scale with the speed: :class:`kinetics.undriven.SlowedAnswer`
- a uniform field alone: :class:`kinetics.driven.field_answer.FieldAnswer`
- everything else (baths, noise, laws of the impact speed, sticking, and what combines these):
  :class:`kinetics.driven.driven_answer.DrivenAnswer`
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

from kinetics.errors import PlanStep, SolverStatus
from kinetics.numerics import FloatArray
from kinetics.scene import Scene
from kinetics.undriven import SlowedAnswer, UndrivenAnswer


class Answer(Protocol):
    """What answers a scene: its outputs, their errors, and how they were made.

    Time is the first axis of every array. Velocities are in U, lengths in d, d is the dimension of
    space. Densities of the velocity raise InputError where the solver has none.
    """

    @property
    def values(self) -> Mapping[str, FloatArray]:
        """The outputs that are arrays, by name, in the order of the table of outputs.

        Raises InputError where a number is beyond double precision.
        """

    @property
    def errors(self) -> Mapping[str, float]:
        """Error estimates, by part of the result ("averages", "densities", "position density").

        Relative; those of densities are relative to their maximum at each time.
        """

    @property
    def verdict(self) -> tuple[SolverStatus, str]:
        """The status; and the message, which says which part misses its tolerance, if any does."""

    @property
    def plan(self) -> tuple[PlanStep, ...]:
        """What was solved, what was skipped, and why."""

    @property
    def stats(self) -> Mapping[str, Any]:
        """Numbers about the work, by name."""

    @property
    def typical_speed(self) -> FloatArray:
        """A speed of the order of the thermal one in U, shape (n_times,)."""

    @property
    def uncollided(self) -> FloatArray:
        """The share of tracers in delta peaks, which densities leave out, shape (n_times,)."""

    @property
    def captured(self) -> FloatArray:
        """The share of tracers that stick to scatterers, shape (n_times,)."""

    def speed_density(self, v: FloatArray) -> FloatArray:
        """Density of the speed in 1/U at speeds v (n_v,), shape (n_times, n_v)."""

    def component_density(self, v_x: FloatArray) -> FloatArray:
        """Density of one component of the velocity in 1/U, shape (n_times, n)."""

    def velocity_density(self, v: FloatArray, phi: FloatArray) -> FloatArray:
        """Density of the velocity in U^-d, shape (n_times, n_v, n_phi).

        phi : angle to the x axis, in radians
        """


def answer_to(scene: Scene, rtol: float, method: str | None, nodes: int | None) -> Answer:
    """Return what answers a scene; the arguments are those of :func:`kinetics.solve`.

    Solvers of driven tracers are imported at first use.
    """
    drive = scene.drive
    if drive.only_collides:
        return UndrivenAnswer(scene, rtol, method, nodes)
    if drive.only_falls:
        from kinetics.driven.field_answer import FieldAnswer

        return FieldAnswer(scene, rtol)
    if drive.only_slows and "displacement_tensor" not in scene.outputs:
        return SlowedAnswer.of(scene, rtol, method, nodes)
    from kinetics.driven.driven_answer import DrivenAnswer

    return DrivenAnswer(scene, rtol)
