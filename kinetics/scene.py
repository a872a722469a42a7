"""What is asked: the system, its initial state, the times and the outputs. No numerics."""

from __future__ import annotations

import difflib
import html
import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kinetics.collision import CollisionLaw, law_of
from kinetics.errors import InputError, short
from kinetics.frozen import read_only
from kinetics.numerics import FloatArray
from kinetics.outputs import OUTPUTS
from kinetics.states.isotropic import as_state
from kinetics.states.state import State
from kinetics.validation import check_positive, finite_line, refuse, whole_number
from kinetics.values import Value

MOST_HARMONICS = 256


@dataclass(frozen=True)
class Scene(Value):
    """One question to the solver: a value, which can be compared, hashed, pickled and saved.

    Parameters
    ----------
    restitution : e in [0, 1], or a :class:`kinetics.CollisionLaw`
    number_density : rho_0, scatterers per d^2; the mean free path is 1/(2 diameter rho_0)
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
    initial: Any = field(default="gaussian", compare=False)
    times: ArrayLike = ()
    outputs: tuple[str, ...] = ("thermal_speed",)
    harmonics: int = 8
    tangential_restitution: float | None = 1.0
    dimension: int = 2
    collision_numbers: ArrayLike = ()
    state: State = field(init=False)

    def __post_init__(self) -> None:
        law = law_of(self.restitution, self.tangential_restitution, self.dimension)
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
        checked["state"] = _start(self.initial, law.dimension)
        checked["collision_numbers"] = _check_numbers(self.collision_numbers)
        only_collisions = checked["collision_numbers"].size > 0 and np.size(self.times) == 0
        checked["times"] = _check_times([0.0] if only_collisions else self.times)
        checked["outputs"] = _check_outputs(self.outputs)
        checked["harmonics"] = whole_number("harmonics", self.harmonics, 0, MOST_HARMONICS)
        self.store(**checked)
        self.__dict__["law"] = law  # the cached property below

    @property
    def mean_free_path(self) -> float:
        """l = 1/(2 d rho_0), in space 1/(pi d^2 rho_0), in d."""
        return self.law.mean_free_path(self.number_density, self.diameter)

    @cached_property
    def law(self) -> CollisionLaw:
        """The collision law of these restitutions, in this dimension."""
        return law_of(self.restitution, self.tangential_restitution, self.dimension)

    def _system(self) -> str:
        """The arguments without the outputs, for texts."""
        initial = self.initial if isinstance(self.initial, str) else self.state
        return (
            f"{self.law.described}, number_density={self.number_density!r}, "
            f"diameter={self.diameter!r}, initial={short(initial)}, times={_span(self.times)}"
        )

    def __repr__(self) -> str:
        return f"Scene({self._system()}, outputs={self.outputs!r}, harmonics={self.harmonics})"

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td>{name}</td><td>{unit}</td><td>{html.escape(OUTPUTS[name].description)}</td></tr>"
            for name, unit in ((n, OUTPUTS[n].unit_in(self.dimension)) for n in self.outputs)
        )
        return (
            f"<p>Scene: {html.escape(self._system())}</p>"
            f"<table><tr><th>output</th><th>unit</th><th>what it is</th></tr>{rows}</table>"
        )

    @classmethod
    def _from_storage(cls, parts: dict[str, Any]) -> Scene:
        return cls(**parts)


def _span(times: ArrayLike) -> str:
    """How many times there are, and the first and the last."""
    array = np.asarray(times)
    if array.size == 1:
        return f"[{array[0]:g}]"
    return f"[{array[0]:g} ... {array[-1]:g}, {array.size} times]"


def _start(initial: Any, dimension: int) -> State:
    """The initial state in this dimension."""
    state = as_state(initial)
    if dimension == 2:
        return state
    found = state.in_space()
    if found is None:
        allowed = "with dimension 3 it must be isotropic, a Beam along x, or AngularHarmonics"
        refuse("initial", initial, allowed)
    return found


def _check_times(times: Any) -> FloatArray:
    """The times as a read-only array; InputError if they cannot be used."""
    allowed = "times must be real, finite, not negative and not falling, at least one"
    array = finite_line("times", times, allowed)
    if array.size == 0 or array[0] < 0.0 or np.any(np.diff(array) < 0.0):
        refuse("times", times, allowed)
    return read_only(array)


def _check_numbers(numbers: Any) -> FloatArray:
    """The collision numbers as a read-only array; InputError if they cannot be used."""
    allowed = "collision numbers must be whole, not negative, up to 2^53"
    array = finite_line("collision_numbers", numbers, allowed)
    if np.any((array < 0.0) | (array > 2.0**53) | (array != np.floor(array))):
        refuse("collision_numbers", numbers, allowed)
    return read_only(array)


def _check_outputs(outputs: Any) -> tuple[str, ...]:
    """The names without repetitions; InputError, with the nearest name, for an unknown one."""
    try:
        names = [outputs] if isinstance(outputs, str) else list(outputs)
    except TypeError:
        names = [outputs]
    known = ", ".join(OUTPUTS)
    if not names:
        refuse("outputs", outputs, f"name at least one of {known}")
    for name in names:
        if not isinstance(name, str) or name not in OUTPUTS:
            near = difflib.get_close_matches(name, OUTPUTS, n=1) if isinstance(name, str) else []
            hint = f"did you mean {near[0]!r}? " if near else ""
            refuse("outputs", name, f"{hint}known are {known}")
    return tuple(str(name) for name in dict.fromkeys(names))
