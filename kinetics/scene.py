"""Scene: the system, its initial state, the times and the outputs. No numerics."""

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
from kinetics.collision.impact import impact_restitution
from kinetics.collision.medium import word_for_scatterers
from kinetics.drive import (
    DRIVES,
    MAX_STRENGTH,
    MIN_STRENGTH,
    STRENGTHS_ALLOWED,
    Drive,
    check_strengths,
)
from kinetics.errors import short, suggestion
from kinetics.numerics import FloatArray
from kinetics.outputs import ALIASES, DRIVEN_OUTPUTS, FIELD_OUTPUTS, OUTPUTS, Output
from kinetics.results.labels import system_items
from kinetics.results.record import stored_class
from kinetics.results.result import Storable
from kinetics.results.table import Table, number_text
from kinetics.states.kinds import Rest, as_state
from kinetics.states.state import State
from kinetics.validation import (
    MAX_HARMONICS,
    check_positive,
    finite_line,
    real_number,
    refuse,
    whole_number,
)

#: Larger whole numbers are not exact in double precision.
MAX_COLLISION_NUMBER = 2.0**53


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class Scene(Storable):
    """One question to the solver: a value, which can be compared, hashed, pickled and saved.

    Parameters
    ----------
    restitution : e in [0, 1], or a :class:`kinetics.CollisionLaw`; or a function, see below
    number_density : rho_0, scatterers per d^2; the mean free path is 1/(2 diameter rho_0) where
        they are dilute
    diameter : d, the distance of the centres of tracer and scatterer at a collision: the diameter
        of both, or half the sum of both where they differ
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
    scatterers : "dilute" (the paper's equation, in which no scatterer is met again), "overlapping
        disks" (placed independently) or "hard disks": the equation to the first order in the
        density, up to number_density * diameter^2 = 0.3, among smooth disks. "hard disks" are as
        large as the tracer: of other sizes there is the dilute theory alone
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

    With a bath, heating, drag or sticking, or with a restitution that depends on the normal impact
    speed (in U: a `kinetics.Viscoelastic`, a Python function of an array, or a tuple (impact
    speeds, values)), the outputs are fewer; in a field, and for outputs with a direction, starts
    are symmetric about x.

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
        law = self._law
        drive = self.drive
        number_density = check_positive("number_density", self.number_density)
        diameter = check_positive("diameter", self.diameter)
        _check_mean_free_path(law, number_density, diameter)
        collision_numbers = _check_collision_numbers(self.collision_numbers)
        needs_no_times = collision_numbers.size > 0 and np.size(self.times) == 0
        times = _check_times([0.0] if needs_no_times else self.times)
        self._check_combinations(law, drive, collision_numbers)
        arguments = law.arguments
        if self._is_driven:
            self._check_driven(law, drive, times)
            strengths = {name: getattr(drive, name) for name in DRIVES}
            arguments |= {"restitution": drive.restitution, **strengths}
        self.store(
            **arguments,
            scatterers=word_for_scatterers(self.scatterers),
            number_density=number_density,
            diameter=diameter,
            field=drive.field,
            state=_start(self.initial, law.dimension, drive.is_driven),
            collision_numbers=collision_numbers,
            times=times,
            outputs=_check_outputs(self.outputs, self._known_outputs),
            harmonics=whole_number("harmonics", self.harmonics, 0, MAX_HARMONICS),
        )

    @property
    def mean_free_path(self) -> float:
        """l = 1/(2 d rho_0), in space 1/(pi d^2 rho_0), in d; or that at this density."""
        return self._law.mean_free_path(self.number_density, self.diameter)

    @property
    def law(self) -> CollisionLaw:
        """The collision law of these restitutions, in this dimension, among these scatterers.

        Raises InputError where the restitution depends on the impact speed: there is none.
        """
        if self._depends_on_impact_speed:
            refuse("restitution", self.restitution, "a CollisionLaw needs a number")
        return self._law

    def _table(self) -> Table:
        """Return what a notebook shows: the arguments that matter, with their units."""
        times = np.asarray(self.times)
        rows = [
            ("system", ", ".join(self.system), ""),
            ("mean free path", number_text(self.mean_free_path), "d"),
            ("initial", short(self.initial), ""),
            ("times", f"{times.size}, from {times[0]:.6g} to {times[-1]:.6g}", "d/U"),
            ("outputs", ", ".join(self.outputs), ""),
        ]
        return Table("Scene", ("", "value", "unit"), rows)

    @property
    def density_in_diameters(self) -> float:
        """Scatterers in d^2, or d^3 in space; infinite where that is no number."""
        return self.number_density * math.prod([self.diameter] * self.dimension)

    @property
    def system(self) -> tuple[str, ...]:
        """The system as a title of a figure has it: "e = 0.7", "n = 0.04 d⁻²", "dilute"."""
        names = [field.name for field in dataclasses.fields(self) if field.name != "state"]
        arguments = {name: getattr(self, name) for name in names}
        arguments["number_density"] = self.density_in_diameters
        return system_items(arguments, self.scatterers, self.dimension)

    @property
    def _depends_on_impact_speed(self) -> bool:
        """Whether the restitution is a function of the impact speed."""
        return impact_restitution(self.restitution) is not None

    @cached_property
    def drive(self) -> Drive:
        """The collisions of the tracer, and what acts on it, in U and d."""
        strengths = check_strengths(**{name: getattr(self, name) for name in DRIVES})
        allowed = "it must be a finite number, 0 or more: the field is along +x"
        field = real_number("field", self.field, 0.0, allowed=allowed)
        if not self._depends_on_impact_speed and not any(strengths.values()):
            law = self._law
            return Drive(
                restitution=law, dimension=law.dimension, mass_ratio=law.mass_ratio, field=field
            )
        return Drive.checked(
            restitution=self.restitution,
            dimension=self.dimension,
            mass_ratio=self.mass_ratio,
            field=field,
            **strengths,
        )

    @property
    def _is_driven(self) -> bool:
        """Whether there is more than collisions that scale with the speed, and a field."""
        return not (self.drive.only_collides or self.drive.only_falls)

    @cached_property
    def _law(self) -> CollisionLaw:
        """The law; where the restitution depends on the impact speed, one of the same geometry."""
        e = 1.0 if self._depends_on_impact_speed else self.restitution
        law = law_of(e, self.tangential_restitution, self.dimension, self.mass_ratio)
        return law_in_medium(
            law, self.scatterers, self.number_density, self.diameter, self.density_order
        )

    @property
    def problem(self) -> tuple[CollisionLaw, float, State, FloatArray]:
        """What every solver needs: law, mean free path in d, initial state, times in d/U."""
        return self._law, self.mean_free_path, self.state, np.asarray(self.times)

    @property
    def _known_outputs(self) -> Mapping[str, Output]:
        """The outputs that a solver has for these drives."""
        if self._is_driven:
            return DRIVEN_OUTPUTS
        if self.drive.field:
            return FIELD_OUTPUTS
        return OUTPUTS

    def _check_combinations(
        self, law: CollisionLaw, drive: Drive, collision_numbers: FloatArray
    ) -> None:
        """Raise InputError for what only dilute scatterers, or undriven tracers, have."""
        is_dilute = law.medium is None
        if drive.field and not is_dilute:
            refuse("field", drive.field, "it is available for scatterers='dilute' only")
        is_plain = drive.only_collides and is_dilute
        if collision_numbers.size and not is_plain:
            allowed = "they are available without field or drive and for scatterers='dilute' only"
            refuse("collision_numbers", collision_numbers, allowed)

    def _check_driven(self, law: CollisionLaw, drive: Drive, times: FloatArray) -> None:
        """Raise InputError for what solvers of driven tracers do not do."""
        allowed = "driven tracers are solved among smooth dilute scatterers only"
        if law.medium is not None:
            refuse("scatterers", self.scatterers, allowed)
        if law.tangential_restitution != 1.0:
            refuse("tangential_restitution", self.tangential_restitution, allowed)
        path = self.mean_free_path
        drive.per_path(path)
        is_too_short = times < MIN_STRENGTH * path
        is_too_long = times > MAX_STRENGTH * path
        if np.any((times > 0.0) & (is_too_short | is_too_long)):
            refuse("times", self.times, STRENGTHS_ALLOWED)


def _check_mean_free_path(law: CollisionLaw, number_density: float, diameter: float) -> None:
    """Raise InputError where the mean free path is out of the range of numbers."""
    path = law.mean_free_path(number_density, diameter)
    if not 0.0 < path < math.inf:
        allowed = f"at diameter {diameter:g} the mean free path must be a finite number above 0"
        refuse("number_density", number_density, allowed)


def _check_collision_numbers(collision_numbers: ArrayLike) -> FloatArray:
    """Return N, shape (n,); InputError unless they are whole and not negative."""
    allowed = "collision numbers must be whole, not negative, up to 2^53"
    numbers = finite_line("collision_numbers", collision_numbers, allowed, 0.0)
    is_whole = (numbers <= MAX_COLLISION_NUMBER) & (numbers == np.floor(numbers))
    if not np.all(is_whole):
        refuse("collision_numbers", collision_numbers, allowed)
    return numbers


def _check_times(times: ArrayLike) -> FloatArray:
    """Return the times, shape (n_times,); InputError if there are none, or they fall."""
    allowed = "times must be real, finite, not negative and not falling, at least one"
    checked = finite_line("times", times, allowed, 0.0)
    if checked.size == 0 or np.any(np.diff(checked) < 0.0):
        refuse("times", times, allowed)
    return checked


def _start(initial: Any, dimension: int, is_driven: bool) -> State:
    """Return the initial state in this dimension."""
    state = as_state(initial)
    if isinstance(state, Rest) and not is_driven:
        allowed = "tracers at rest stay there: give a field, bath_speed or heating as well"
        refuse("initial", initial, allowed)
    if dimension == 2:
        return state
    in_space = state.in_space()
    if in_space is None:
        allowed = "with dimension 3 it must be isotropic, a Beam along x, or AngularHarmonics"
        refuse("initial", initial, allowed)
    return in_space


def _check_outputs(outputs: Any, known: Mapping[str, Output]) -> tuple[str, ...]:
    """Return the names without repetitions; InputError for an unknown one."""
    is_scalar_array = getattr(outputs, "ndim", 1) == 0  # which only seems to be iterable
    is_several = isinstance(outputs, Iterable) and not isinstance(outputs, str | bytes)
    names = list(outputs) if is_several and not is_scalar_array else [outputs]
    if not names:
        refuse("outputs", outputs, f"name at least one of {', '.join(known)}")
    for name in names:
        if not isinstance(name, str) or name not in known:
            kind = "without a field or drive" if known is OUTPUTS else "with a field or a drive"
            near = suggestion(name, known, ALIASES)
            refuse("outputs", name, f"known {kind} are {', '.join(known)}{near}")
    return tuple(dict.fromkeys(names))
