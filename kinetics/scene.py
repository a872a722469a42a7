"""What is asked: the system, its initial state, the times and the outputs. No numerics."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kinetics.collision import CollisionLaw, law_in_medium, law_of
from kinetics.field.restitution import impact_restitution
from kinetics.field.system import DRIVES, LEAST, MOST, SIZES, System, checked_drives
from kinetics.numerics import FloatArray
from kinetics.outputs import DRIVEN_OUTPUTS, FIELD_OUTPUTS, OUTPUTS
from kinetics.results.record import stored_class
from kinetics.results.result import Storable
from kinetics.states.kinds import Rest, as_state
from kinetics.states.state import State
from kinetics.validation import (
    MOST_HARMONICS,
    check_positive,
    finite_line,
    real_number,
    refuse,
    whole_number,
)


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class Scene(Storable):
    """One question to the solver: a value, which can be compared, hashed, pickled and saved.

    Parameters
    ----------
    restitution : e in [0, 1], or a :class:`kinetics.CollisionLaw`; or a function, see below
    number_density : rho_0, scatterers per d^2; the mean free path is 1/(2 diameter rho_0) where
        they are dilute
    diameter : of tracer and scatterers, in d
    initial : "gaussian" (each component of the velocity has standard deviation U),
        "monoenergetic" (all speeds are U), a speed density as a function of v/U, or a state:
        SpeedTable, SpeedSamples, Gaussian, Beam, VelocitySamples, AngularHarmonics, PolarGrid
    times : in d/U, shape (n_times,), not falling, not negative; 0 where collision_numbers are given
    outputs : names out of the table of outputs in the reference
    harmonics : highest angular harmonic m that "velocity_density" solves, if the state has it; in
        space that of the Legendre polynomials of the angle to the x axis
    tangential_restitution : et in [0, 1]; 1 for smooth scatterers
    dimension : 2 (disks in the plane) or 3 (spheres; the initial state is then symmetric about the
        x axis)
    collision_numbers : N, whole, of the averages after N collisions, ``Solution.by_collision``
    scatterers : "dilute" (the paper's equation, in which no scatterer is met again), "overlapping"
        (placed independently) or "hard disks": the equation to the first order in the density, up
        to number_density * diameter^2 = 0.3, among smooth disks
    density_order : of the theory for those two: "leading" (n ln n, n = number_density diameter^2),
        "first" (n) or "second" (with a fitted term (n ln n)^2)
    field : a uniform acceleration along +x, in U^2/d, 0 or more. With a field ``initial`` may be
        "rest" (U is then any unit of speed); which outputs there are a refused one says
    mass_ratio : of a scatterer, at rest, over the tracer, for dilute smooth scatterers; inf: fixed
    bath_speed : w in U: dilute smooth scatterers move, each component of their velocities is
        Gaussian with this standard deviation
    heating : D_v in U^3/d, of white noise on the velocity, <dv_i dv_j> = 2 D_v delta_ij dt
    drag : gamma in U/d, in dv/dt = -gamma v
    capture_speed : v_c in U: impacts whose normal speed is below it stick. Averages of the velocity
        are over the tracers that still move, of place and collisions over all;
        ``Solution.captured`` is the share that sticks

    With any of the last four, or a restitution that depends on the normal impact speed (in U: a
    `kinetics.Viscoelastic`, a Python function of an array, or a tuple (impact speeds, values)), the
    outputs are fewer; in a field, and for outputs with a direction, starts are symmetric about x.

    Raises InputError (a ValueError), one line that names the argument, its value and what is
    allowed. A scene whose initial state is a Python function cannot be saved to a file: give the
    density as a SpeedTable where that is needed.
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
    bath_speed: float = 0.0
    heating: float = 0.0
    drag: float = 0.0
    capture_speed: float = 0.0
    state: State = dataclasses.field(init=False, repr=False)

    def __post_init__(self) -> None:
        law, system = self._any_law, self.system
        rho = check_positive("number_density", self.number_density)
        diameter = check_positive("diameter", self.diameter)
        path = law.mean_free_path(rho, diameter)
        if not 0.0 < path < math.inf:
            allowed = f"at diameter {diameter:g} the mean free path must be a finite number above 0"
            refuse("number_density", self.number_density, allowed)
        allowed = "it must be a finite number, 0 or more: the field is along +x"
        field = real_number("field", self.field, 0.0, allowed=allowed)
        allowed = "collision numbers must be whole, not negative, up to 2^53"
        numbers = finite_line("collision_numbers", self.collision_numbers, allowed, 0.0)
        if np.any((numbers > 2.0**53) | (numbers != np.floor(numbers))):
            refuse("collision_numbers", self.collision_numbers, allowed)
        allowed = "times must be real, finite, not negative and not falling, at least one"
        only_collisions = numbers.size > 0 and np.size(self.times) == 0
        times = finite_line("times", [0.0] if only_collisions else self.times, allowed, 0.0)
        if times.size == 0 or np.any(times[1:] < times[:-1]):
            refuse("times", self.times, allowed)
        at_a_density = law.medium is not None
        if field and at_a_density:
            refuse("field", field, "it is available for scatterers='dilute' only")
        if numbers.size and (field or at_a_density or system):
            allowed = "they are available without field or drive and for scatterers='dilute' only"
            refuse("collision_numbers", numbers, allowed)
        arguments = law.arguments
        if system is not None:
            if at_a_density or law.tangential_restitution != 1.0:
                name = "scatterers" if at_a_density else "tangential_restitution"
                allowed = "driven tracers are solved among smooth dilute scatterers only"
                refuse(name, getattr(self, name), allowed)
            system.scaled(path)
            if np.any((times > 0.0) & ((times < LEAST * path) | (times > MOST * path))):
                refuse("times", self.times, SIZES)
            arguments |= {name: getattr(system, name) for name in ("restitution", *DRIVES)}
        table = DRIVEN_OUTPUTS if system else FIELD_OUTPUTS if field else OUTPUTS
        gains = field > 0.0 or (system is not None and system.is_driven)
        self.store(
            **arguments, number_density=rho, diameter=diameter, field=field,
            state=_start(self.initial, law.dimension, gains), collision_numbers=numbers,
            times=times, outputs=_check_outputs(self.outputs, table),
            harmonics=whole_number("harmonics", self.harmonics, 0, MOST_HARMONICS),
        )  # fmt: skip

    @property
    def mean_free_path(self) -> float:
        """l = 1/(2 d rho_0), in space 1/(pi d^2 rho_0), in d; or that at this density."""
        return self._any_law.mean_free_path(self.number_density, self.diameter)

    @property
    def law(self) -> CollisionLaw:
        """The collision law of these restitutions, in this dimension, among these scatterers.

        Raises InputError where the restitution depends on the impact speed: there is none.
        """
        if self._varies:
            refuse("restitution", self.restitution, "a CollisionLaw needs a number")
        return self._any_law

    @property
    def _varies(self) -> bool:
        """Whether the restitution depends on the impact speed."""
        return impact_restitution(self.restitution) is not None

    @cached_property
    def system(self) -> System | None:
        """What drives the tracer, or makes its restitution vary, in U and d; None for neither."""
        drives = checked_drives(**{name: getattr(self, name) for name in (*DRIVES, "field")})
        if not self._varies and not any(drives[name] for name in DRIVES):
            return None
        return System.checked(self.restitution, self.dimension, self.mass_ratio, **drives)

    @cached_property
    def _any_law(self) -> CollisionLaw:
        """The law; where the restitution depends on the impact speed one of the same geometry."""
        e = 1.0 if self._varies else self.restitution
        law = law_of(e, self.tangential_restitution, self.dimension, self.mass_ratio)
        medium = self.scatterers, self.number_density, self.diameter, self.density_order
        return law_in_medium(law, *medium)

    @property
    def problem(self) -> tuple[CollisionLaw, float, State, FloatArray]:
        """What every solver needs: law, mean free path in d, initial state, times in d/U."""
        return self._any_law, self.mean_free_path, self.state, np.asarray(self.times)


def _start(initial: Any, dimension: int, with_field: bool) -> State:
    """The initial state in this dimension."""
    state = as_state(initial)
    if isinstance(state, Rest) and not with_field:
        allowed = "tracers at rest stay there: give a field, bath_speed or heating as well"
        refuse("initial", initial, allowed)
    found = state if dimension == 2 else state.in_space()
    if found is None:
        allowed = "with dimension 3 it must be isotropic, a Beam along x, or AngularHarmonics"
        refuse("initial", initial, allowed)
    return found


def _check_outputs(outputs: Any, table: Mapping[str, Any]) -> tuple[str, ...]:
    """The names without repetitions; InputError for an unknown one."""
    several = isinstance(outputs, Iterable) and not isinstance(outputs, str)
    several &= getattr(outputs, "ndim", 1) > 0  # an array of none only seems to be iterable
    names = list(outputs) if several else [outputs]
    known = ", ".join(table)
    if not names:
        refuse("outputs", outputs, f"name at least one of {known}")
    for name in names:
        if not isinstance(name, str) or name not in table:
            kind = "without a field or drive" if table is OUTPUTS else "with a field or a drive"
            refuse("outputs", name, f"known {kind} are {known}")
    return tuple(dict.fromkeys(names))
