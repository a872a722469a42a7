"""What is asked: the system, its initial state, the times and the outputs. No numerics."""

from __future__ import annotations

import dataclasses
import difflib
import html
import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kinetics.collision import CollisionLaw, law_in_medium, law_of
from kinetics.errors import InputError, short
from kinetics.numerics import FloatArray
from kinetics.outputs import FIELD_OUTPUTS, OUTPUTS
from kinetics.results import Value
from kinetics.states.isotropic import Rest, as_state
from kinetics.states.state import State
from kinetics.validation import check_positive, finite_line, real_number, refuse, whole_number

MOST_HARMONICS = 256


@dataclass(frozen=True)
class Scene(Value):
    """One question to the solver: a value, which can be compared, hashed, pickled and saved.

    Parameters
    ----------
    restitution : e in [0, 1], or a :class:`kinetics.CollisionLaw`
    number_density : rho_0, scatterers per d^2; the mean free path is 1/(2 diameter rho_0) where
        they are dilute
    diameter : of tracer and scatterers, in d
    initial : "gaussian" (each component of the velocity has standard deviation U),
        "monoenergetic" (all speeds are U), a speed density as a function of v/U, or a state:
        SpeedTable, SpeedSamples, Gaussian, Beam, VelocitySamples, AngularHarmonics, PolarGrid
    times : in d/U, shape (n_times,), not falling, not negative; where collision_numbers are given
        it may be left out, and is 0
    outputs : names from `kinetics.outputs.OUTPUTS`
    harmonics : highest angular harmonic m that "velocity_density" solves, if the state has it; in
        space that of the Legendre polynomials of the angle to the x axis
    tangential_restitution : et in [0, 1]; 1 for smooth scatterers
    dimension : 2 (disks in the plane) or 3 (spheres; the initial state is then symmetric about the
        x axis)
    collision_numbers : N, whole numbers from 0, of the averages after N collisions that
        ``Solution.by_collision`` gives, shape (n_collisions,)
    scatterers : "dilute" (the paper's equation, in which no scatterer is met again), "overlapping"
        (placed independently) or "hard disks": the equation to the first order in the density, up
        to number_density * diameter^2 = 0.3, among smooth disks
    density_order : of the theory for those two: "leading" (n ln n, n = number_density diameter^2),
        "first" (n) or "second" (with a fitted term (n ln n)^2); see `kinetics.collision.medium`
    field : a uniform acceleration along +x, in U^2/d, 0 or more. With a field ``initial`` may be
        "rest" (U is then any unit of speed), and the outputs are those of
        `kinetics.outputs.FIELD_OUTPUTS`
    mass_ratio : of a scatterer, at rest, over the tracer, for dilute smooth scatterers; inf: fixed

    Raises
    ------
    InputError (a ValueError) : one line that names the argument, its value and what is allowed

    A scene whose initial state is a Python function can neither be saved to a file nor, if the
    function is a lambda, be pickled: give the density as a SpeedTable where that is needed. Two
    scenes are equal if their systems, initial states, times and outputs are.
    """

    restitution: Any
    number_density: float = 0.04
    diameter: float = 1.0
    initial: Any = dataclasses.field(default="gaussian", compare=False)
    times: ArrayLike = ()
    outputs: tuple[str, ...] = ("thermal_speed",)
    harmonics: int = 8
    tangential_restitution: float | None = 1.0
    dimension: int = 2
    collision_numbers: ArrayLike = ()
    scatterers: str = "dilute"
    density_order: str = "second"
    field: float = 0.0
    mass_ratio: float = math.inf
    state: State = dataclasses.field(init=False)

    def __post_init__(self) -> None:
        law = self.law
        checked: dict[str, Any] = {
            **law.arguments,
            "number_density": check_positive("number_density", self.number_density),
            "diameter": check_positive("diameter", self.diameter),
        }
        if not 0.0 < law.mean_free_path(checked["number_density"], checked["diameter"]) < math.inf:
            formula = "2 diameter" if law.dimension == 2 else "pi diameter^2"
            raise InputError(
                f"number_density: got {short(self.number_density)} at diameter "
                f"{short(self.diameter)}; the mean free path 1/({formula} number_density) must be "
                "a finite number above 0"
            )
        allowed = "it must be a finite number, 0 or more: the field is along +x"
        checked["field"] = real_number("field", self.field, 0.0, allowed=allowed)
        with_field = checked["field"] > 0.0
        checked["state"] = _start(self.initial, law.dimension, with_field)
        checked["collision_numbers"] = _check_numbers(self.collision_numbers)
        only_collisions = checked["collision_numbers"].size > 0 and np.size(self.times) == 0
        checked["times"] = _check_times([0.0] if only_collisions else self.times)
        checked["outputs"] = _check_outputs(self.outputs, with_field)
        _check_together(checked, law)
        checked["harmonics"] = whole_number("harmonics", self.harmonics, 0, MOST_HARMONICS)
        self.store(**checked)

    @property
    def mean_free_path(self) -> float:
        """l = 1/(2 d rho_0), in space 1/(pi d^2 rho_0), in d; or that at this density."""
        return self.law.mean_free_path(self.number_density, self.diameter)

    @cached_property
    def law(self) -> CollisionLaw:
        """The collision law of these restitutions, in this dimension, among these scatterers."""
        law = law_of(
            self.restitution, self.tangential_restitution, self.dimension, self.mass_ratio
        )  # fmt: skip
        system = (self.scatterers, self.number_density, self.diameter)
        return law_in_medium(law, *system, self.density_order)

    def _system(self) -> str:
        """The arguments without the outputs, for texts."""
        initial = self.initial if isinstance(self.initial, str) else self.state
        return (
            f"{self.law.described}, number_density={self.number_density!r}, "
            f"diameter={self.diameter!r}, initial={short(initial)}, times={_span(self.times)}"
            + (f", field={self.field!r}" if self.field else "")
        )

    def __repr__(self) -> str:
        numbers = ""
        if np.size(self.collision_numbers):
            numbers = f", collision_numbers={_span(self.collision_numbers, 'numbers')}"
        rest = f"outputs={self.outputs!r}, harmonics={self.harmonics}{numbers}"
        return f"Scene({self._system()}, {rest})"

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td>{row.name}</td><td>{row.unit_in(self.dimension)}</td>"
            f"<td>{html.escape(row.description)}</td></tr>"
            for row in ((FIELD_OUTPUTS if self.field else OUTPUTS)[name] for name in self.outputs)
        )
        return (
            f"<p>Scene: {html.escape(self._system())}</p>"
            f"<table><tr><th>output</th><th>unit</th><th>what it is</th></tr>{rows}</table>"
        )

    @classmethod
    def _from_storage(cls, parts: dict[str, Any]) -> Scene:
        return cls(**parts)


def _span(times: ArrayLike, name: str = "times") -> str:
    """How many times there are, or what the name says, and the first and the last."""
    array = np.asarray(times)
    if array.size == 1:
        return f"[{array[0]:g}]"
    return f"[{array[0]:g} ... {array[-1]:g}, {array.size} {name}]"


def _start(initial: Any, dimension: int, with_field: bool) -> State:
    """The initial state in this dimension."""
    state = Rest() if isinstance(initial, str) and initial == "rest" else as_state(initial)
    if isinstance(state, Rest) and not with_field:
        refuse("initial", initial, "tracers at rest stay there, give a field as well")
    if dimension == 2:
        return state
    found = state.in_space()
    if found is None:
        allowed = "with dimension 3 it must be isotropic, a Beam along x, or AngularHarmonics"
        refuse("initial", initial, allowed)
    return found


def _check_together(checked: dict[str, Any], law: CollisionLaw) -> None:
    """Finite densities have no averages after N collisions, and no field."""
    at_a_density, numbers = law.medium is not None, checked["collision_numbers"]
    if at_a_density and checked["field"]:
        refuse("field", checked["field"], "it is available for scatterers='dilute' only")
    if numbers.size and checked["field"]:
        refuse("collision_numbers", numbers, "they are available without a field only")
    if numbers.size and at_a_density:
        refuse("collision_numbers", numbers, "they are available for scatterers='dilute' only")


def _check_times(times: Any) -> FloatArray:
    """The times as a read-only array; InputError if they cannot be used."""
    allowed = "times must be real, finite, not negative and not falling, at least one"
    array = finite_line("times", times, allowed)
    if array.size == 0 or array[0] < 0.0 or np.any(array[1:] < array[:-1]):
        refuse("times", times, allowed)
    return array


def _check_numbers(numbers: Any) -> FloatArray:
    """The collision numbers as a read-only array; InputError if they cannot be used."""
    allowed = "collision numbers must be whole, not negative, up to 2^53"
    array = finite_line("collision_numbers", numbers, allowed)
    if np.any((array < 0.0) | (array > 2.0**53) | (array != np.floor(array))):
        refuse("collision_numbers", numbers, allowed)
    return array


def _check_outputs(outputs: Any, with_field: bool) -> tuple[str, ...]:
    """The names without repetitions; InputError, with the nearest name, for an unknown one."""
    try:
        names = [outputs] if isinstance(outputs, str) else list(outputs)
    except TypeError:
        names = [outputs]
    table = FIELD_OUTPUTS if with_field else OUTPUTS
    known = ", ".join(table)
    if not names:
        refuse("outputs", outputs, f"name at least one of {known}")
    for name in names:
        if not isinstance(name, str) or name not in table:
            near = difflib.get_close_matches(name, table, n=1) if isinstance(name, str) else []
            hint = f"did you mean {near[0]!r}? " if near else ""
            if name in (*OUTPUTS, *FIELD_OUTPUTS):
                hint = f"not available {'with' if with_field else 'without'} a field; "
            refuse("outputs", name, f"{hint}known are {known}")
    return tuple(str(name) for name in dict.fromkeys(names))
