"""Solution: what `solve` returns, a value with units, a status and the distributions on demand."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics.answer import Answer, answer_to
from kinetics.between_frames import mean_square_between_frames
from kinetics.densities.flights import Flights
from kinetics.densities.fronts import speed_fronts
from kinetics.densities.harmonic import Profile
from kinetics.densities.spectral_grid import TooManyNodesError
from kinetics.errors import (
    InputError,
    PlanStep,
    SolverStatus,
    ToleranceWarning,
    suggestion,
    warn_missed,
)
from kinetics.model_error import model_errors, summary
from kinetics.moments.by_collision import ByCollision
from kinetics.moments.outputs import collisions, root_mean_square_displacement
from kinetics.numerics import FloatArray
from kinetics.outputs import ALIASES, ALL_OUTPUTS, AXES, OUTPUTS, described
from kinetics.position.density import Displacement
from kinetics.position.directions import radial_measure, unit_surface
from kinetics.position.intermediate_scattering import scattering_function
from kinetics.results.record import stored_class
from kinetics.results.result import Result
from kinetics.results.table import Table, number_text, wrapped
from kinetics.results.value import frozen
from kinetics.scene import Scene
from kinetics.solution_dataset import radii_of_plot, solution_dataset
from kinetics.undriven import UndrivenAnswer
from kinetics.validation import (
    finite_line,
    not_negative_line,
    real_number,
    refuse,
    rising_from_zero,
    speeds,
)

if TYPE_CHECKING:
    import xarray

#: R above which G is zero in double precision; r itself may overflow there.
MAX_SCALED_RADIUS = 1e6
#: Below this R, p(R) is compared with its error as at this R, since G has a factor R.
MIN_RADIUS_OF_ERROR = 0.1
#: Free flights: least and largest rtol of the speed densities that they are made of.
MIN_RTOL_OF_FLIGHTS = 1e-6
#: The least one from rough starts.
MIN_RTOL_OF_FLIGHTS_ROUGH = 1e-4
#: The largest one.
MAX_RTOL_OF_FLIGHTS = 1e-3
#: Nodes of the speed axis for free flights from rough starts at the largest rtol. Measured: shares
#: within 0.06 % in a tenth of the time that the solver's own choice takes.
NODES_OF_ROUGH_FLIGHTS = 4000
#: A warning is given if the number of flights is off by more than so many times their rtol.
FLIGHTS_SAFETY = 10.0
#: Accuracy of the initial speeds from which the fronts of a density are read off.
RTOL_OF_FRONTS = 1e-6
#: Least error of the density of driven tracers, over its maximum, that a solver aims at; it is that
#: of `kinetics.driven.over_time`.
MIN_ERROR_OF_DRIVEN_DENSITY = 1e-4


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class Solution(Result):
    """What :func:`kinetics.solve` found. Time is the first axis of every array.

    A value: its arrays and dictionaries are read-only, it can be compared, hashed and pickled, and
    :meth:`save` writes it to a file from which :func:`kinetics.load` makes an equal one. Methods
    raise InputError for arguments out of range, and where their output was not asked for.

    Attributes
    ----------
    scene : Scene
        The question.
    rtol, method, nodes
        As they were given to `kinetics.solve`.
    values : mapping
        Output name -> array whose first axis is time; also as attributes, ``solution.msd``.
    status : SolverStatus
        Its text says what to change.
    message : str
        Which part misses its tolerance, by how much, and what to change.
    error_estimate : float
        Largest relative error that the solver saw.
    plan : tuple of PlanStep
        What was solved and what was skipped, and why.
    stats : mapping
        Numbers about the work (nodes, panels, points of the initial state).
    """

    scene: Scene
    rtol: float
    values: Mapping[str, FloatArray]
    status: SolverStatus
    message: str
    error_estimate: float
    plan: tuple[PlanStep, ...]
    stats: Mapping[str, Any]
    method: str | None = None
    nodes: int | None = None
    _solved: Answer | None = field(default=None, init=False, compare=False, repr=False)

    @classmethod
    def of(cls, scene: Scene, rtol: float, method: str | None, nodes: int | None) -> Solution:
        """Solve a scene; the arguments, of `kinetics.solve`, are checked already."""
        answer = answer_to(scene, rtol, method, nodes)
        values = answer.values  # what overflows is refused before densities are solved
        status, message = answer.verdict
        solution = cls(
            scene=scene,
            rtol=rtol,
            values=values,
            status=status,
            message=message,
            error_estimate=max(answer.errors.values()),
            plan=answer.plan,
            stats=answer.stats,
            method=method,
            nodes=nodes,
        )
        solution.store(_solved=answer)
        return solution

    @property
    def _answer(self) -> Answer:
        """What was solved; in a solution from a file, or a copy, it is solved again if needed."""
        if self._solved is None:
            self.store(_solved=answer_to(self.scene, self.rtol, self.method, self.nodes))
        answer = self._solved
        assert answer is not None
        return answer

    def __getstate__(self) -> dict[str, Any]:
        state = super().__getstate__()
        if not isinstance(self._solved, UndrivenAnswer):
            state["_solved"] = None  # other answers hold what cannot be pickled
        return state

    @property
    def times(self) -> FloatArray:
        """Output times in d/U, shape (n_times,)."""
        return np.asarray(self.scene.times)

    def __getattr__(self, name: str) -> FloatArray:
        values = self.__dict__.get("values", {})
        if name in values:
            return np.asarray(values[name])
        known = ", ".join(values) or "no arrays"
        arrays = {array for output in ALL_OUTPUTS for array in output.names}
        if name in arrays:
            raise AttributeError(
                f"{name!r} was not asked for: name it in the outputs of the scene; this solution "
                f"has {known}"
            )
        if name.startswith("__"):
            raise AttributeError(name)
        near = self._near(name, [*arrays, *dir(type(self))])
        raise AttributeError(f"a Solution has no {name!r}{near}; this one has {known}")

    def __getitem__(self, name: str) -> FloatArray:
        """An output that is an array, as the attribute of the same name."""
        if name not in self.values:
            known = f"this solution has {', '.join(self.values) or 'no arrays'}"
            raise KeyError(f"{name!r}: {known}{self._near(name, [*self.values])}")
        return np.asarray(self.values[name])

    def _near(self, name: str, names: list[str]) -> str:
        """Return what a name that this solution does not have may stand for, or where that is."""
        if name == "vdf":
            return (
                "; F(c) of late times is ScalingSolution.vdf; of these times there are the outputs "
                "speed_density and velocity_density"
            )
        if name in self._on_demand:
            return f"; it is a function: solution.{name}(...)"
        if name in {array for output in ALL_OUTPUTS for array in output.names}:
            return f"; {name} was not asked for: name it in the outputs of the scene"
        return suggestion(name, names, ALIASES)

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *self.__dict__.get("values", {})})

    def __repr__(self) -> str:
        shapes = {name: str(array.shape) for name, array in self.values.items()}
        for name in self._on_demand:
            shapes[name] = f"({', '.join(OUTPUTS[name].shape)})"
        outputs = []
        for name, shape in shapes.items():
            unit, _, _ = described(name, self.scene.dimension)
            outputs.append(f"{name} {shape}" if unit == "1" else f"{name} {shape} in {unit}")
        return "\n  ".join(
            [
                wrapped(f"Solution of {self.scene}", "    "),
                wrapped(f"rtol = {self.rtol:g}, {self._status_in_words}", "    "),
                f"error estimate {self.error_estimate:.1e}",
                *self._model_error_lines,
                wrapped(", ".join(outputs), "    "),
            ]
        )

    @property
    def _status_in_words(self) -> str:
        """The status and the message."""
        return f"{self.status.name.lower()}: {self.message}"

    def _table(self) -> Table:
        """Return what a notebook shows: averages at the first and the last time, and the status."""
        times = self.times
        heads = ("", f"t = {times[0]:.6g} d/U", f"t = {times[-1]:.6g} d/U", "unit")
        rows = []
        for name in self.values:
            unit, _, _ = described(name, self.scene.dimension)
            rows.append((name, self._cell(name, 0), self._cell(name, -1), unit))
        for name in self._on_demand:
            unit, _, _ = described(name, self.scene.dimension)
            rows.append((name, "a function", "a function", unit))
        lines = (
            self._status_in_words,
            f"rtol = {self.rtol:g}, error estimate {self.error_estimate:.1e}",
            *self._model_error_lines,
        )
        return Table(f"Solution: {', '.join(self._system)}", heads, rows, lines)

    def _cell(self, name: str, time: int) -> str:
        """Return an average at a time, by index, with the digits that its error has."""
        components = np.ravel(self.values[name][time])
        scale = float(np.max(np.abs(components), initial=0.0))
        if name == "a2":  # whose error is relative to 1 + a2
            scale = 1.0
        if name == "velocity_autocorrelation":  # whose error is relative to v_rms(0) v_rms(t)
            scale = float(self.typical_speed.max() * self.typical_speed[time])
        error = max(self.rtol, self.error_estimate) * scale
        return ", ".join(number_text(float(component), error) for component in components)

    @property
    def _model_error_lines(self) -> list[str]:
        """The lines of the repr on the error of the equation itself."""
        if self.scene.scatterers == "dilute":
            return []
        text = f"error of the equation itself up to: {summary(self.model_error)}"
        return [wrapped(text, "    ")]

    # -- the error of the equation itself ---------------------------------------------------------

    @property
    def model_error(self) -> Mapping[str, FloatArray]:
        """The stated error of the equation itself: name of an output -> array of shape (n_times,).

        Relative, as rtol is: of 1 + a2 for a2, of v_rms(t) for mean_velocity and of sqrt(<r^2>) for
        mean_displacement. For functions it is absolute: of the share of tracers slower than v, or
        nearer than r, at the worst v or r, and of F(k, t) at the worst k.

        At a finite density it is the largest deviation that simulations of disks saw near these e,
        n and t from Gaussian starts, with two standard errors of theirs; it is no standard
        deviation, and it comes on top of `error_estimate`, which is the solver's. 0 for dilute
        scatterers, for which the equation is exact. NaN where it was not measured: for another
        `density_order` than "second", and for `velocity_tensor` of a start that is not isotropic.
        """
        errors = model_errors(self.scene, (*self.values, *self._on_demand))
        return MappingProxyType({name: frozen(error) for name, error in errors.items()})

    # -- as a dataset -----------------------------------------------------------------------------

    _points = (*(axis.points for axis in AXES.values()), "direction")

    @property
    def _on_demand(self) -> tuple[str, ...]:  # type: ignore[override]
        """The outputs that are functions of more than the time."""
        known = (name for name in self.scene.outputs if name in OUTPUTS)
        return tuple(name for name in known if OUTPUTS[name].is_function)

    def _dataset(self, only: Collection[str] | None = None, **points: Any) -> xarray.Dataset:
        """Averages, and functions at points, by default where the distributions are."""
        return solution_dataset(self, self._on_demand, only, points)

    @property
    def _system(self) -> tuple[str, ...]:
        """What the title of a figure says."""
        return self.scene.system

    @property
    def _density_bottom(self) -> float:
        """The least density in a figure, over the largest; where drives act, its error."""
        if self.scene.drive.only_collides:
            return super()._density_bottom
        return max(self.rtol, MIN_ERROR_OF_DRIVEN_DENSITY)

    def _points_of_plot(self, name: str | None, points: Mapping[str, Any]) -> dict[str, Any]:
        """Return radii at equal ratios for a density of the displacement, as speeds are."""
        is_named = isinstance(name, str) and name == "position_density"
        is_drawn = (name is None or is_named) and "position_density" in self._on_demand
        if is_drawn and points.get("radii") is None:
            distances = self.root_mean_square_displacement
            moved = distances[distances > 0.0]
            if moved.size:
                return {**points, "radii": radii_of_plot(moved)}
        return dict(points)

    @property
    def typical_speed(self) -> FloatArray:
        """A speed of the order of the thermal one in U, shape (n_times,)."""
        return self._answer.typical_speed

    @property
    def root_mean_square_displacement(self) -> FloatArray:
        """sqrt(<r^2>) in d of tracers without field or drive, shape (n_times,)."""
        return root_mean_square_displacement(self._undriven().averages)

    # -- what was solved ---------------------------------------------------------------------------

    def _require(self, *outputs: str) -> Answer:
        """Return the answer; InputError unless one of these outputs was asked for."""
        if not set(outputs) & set(self.scene.outputs):
            raise InputError(f"outputs: {outputs[0]!r} was not asked for; name it in the scene")
        return self._answer

    def _undriven(self) -> UndrivenAnswer:
        """Return the answer; InputError for a scene with a field or driven tracers."""
        if self.scene.field:
            raise InputError(f"field: got {self.scene.field!r}; other moments need a field of 0")
        answer = self._answer
        if not isinstance(answer, UndrivenAnswer):
            raise InputError("outputs: of driven tracers there is no more than what was asked for")
        return answer

    def _displacement(self) -> Displacement:
        """Return the distribution of the displacement; InputError unless it was asked for."""
        self._require("position_density")
        displacement = self._undriven().displacement
        assert displacement is not None  # it was asked for
        return displacement

    # -- moments ----------------------------------------------------------------------------------

    def moment(self, p: float) -> FloatArray:
        """<v^p>(t) in U^p for real p, shape (n_times,), where it exists."""
        return np.asarray(self._undriven().power(p, 0).real)

    def harmonic(self, p: float, m: int) -> NDArray[Any]:
        """<v^p exp(-i m phi)>(t) in U^p, complex for m > 0, shape (n_times,)."""
        return np.asarray(self._undriven().power(p, m))

    @property
    def by_collision(self) -> ByCollision:
        """The averages after N collisions, N the ``collision_numbers`` of the scene."""
        numbers = np.asarray(self.scene.collision_numbers)
        if numbers.size == 0:
            raise InputError("collision_numbers: the scene has none; give Scene some")
        law, path, state, _ = self.scene.problem
        return ByCollision(law, path, state, numbers, self.rtol)

    # -- velocity ---------------------------------------------------------------------------------

    def speed_density(self, v: ArrayLike) -> FloatArray:
        """Density of the speed at v (in U), shape (n_times, n_v), in 1/U; integral over v is 1.

        Without the tracers of :attr:`uncollided`. From smooth starts the error is at most rtol of
        the maximum for v above 1e-2 of the thermal speed, below it that of the density of ln v.
        From rough ones (sharp speeds, steps, noise: the plan says "conservative") its integral up
        to v, with :attr:`uncollided`, is right to rtol; f itself is not at its steps
        (:attr:`speed_fronts`).
        """
        answer = self._require("speed_density", "velocity_density")
        return np.asarray(answer.speed_density(speeds(v)))

    @property
    def speed_fronts(self) -> FloatArray:
        """Speeds in U, rising, at which :meth:`speed_density` may step or be infinite.

        Of a start of sharp speeds (empty for others): those speeds, and the ends of what one and
        two collisions make of them.
        """
        scene = self.scene
        has_density = scene.state.profile(0) is not None
        if has_density or not scene.drive.only_collides:
            return np.zeros(0)
        sharp_speeds = scene.state.harmonic(0, RTOL_OF_FRONTS)
        if sharp_speeds is None:
            return np.zeros(0)
        return speed_fronts(scene.law, sharp_speeds)

    @property
    def uncollided(self) -> FloatArray:
        """Share of the tracers of a start of one speed that have not collided, (n_times,).

        All at e = 1. With a field, of any start of sharp velocities (rest, a Beam, samples).
        """
        answer = self._require("speed_density", "velocity_density")
        return np.asarray(frozen(answer.uncollided))

    @property
    def captured(self) -> FloatArray:
        """The share of tracers that stick, (n_times,); InputError unless impacts may stick."""
        if not self.scene.capture_speed:
            refuse("capture_speed", self.scene.capture_speed, "it must be above 0: nothing sticks")
        return np.asarray(frozen(self._answer.captured))

    def velocity_component_density(self, v_x: ArrayLike) -> FloatArray:
        """Density of one velocity component (isotropic part), shape (n_times, n), in 1/U.

        With c_x = v_x/v0 it is F(c_x) of the paper's figure ``scalev``. The error is 1e-8 of the
        maximum, a percent near steps. It is infinite at 0 where the speed density does not vanish
        at rest, as at e = 0 in the plane (but finite by the conservative method, which has no
        speeds below some). Not with a field, nor of driven tracers.
        """
        answer = self._require("speed_density", "velocity_density")
        return np.asarray(answer.component_density(finite_line("v_x", v_x)))

    def velocity_density(self, v: ArrayLike, phi: ArrayLike) -> FloatArray:
        """f(v, phi), the density in the velocity plane, shape (n_times, n_v, n_phi), in 1/U^2.

        The sum of the harmonics up to ``scene.harmonics``, with a field of all; integral of f v dv
        dphi is 1. In space phi is the angle to the x axis, the density is in 1/U^3, and the
        integral of 2 pi f v^2 sin(phi) dv dphi is 1. Delta peaks are left out; v must be above 0.
        """
        v_checked = speeds(v, zero_allowed=False)
        phi_checked = finite_line("phi", phi)
        answer = self._require("velocity_density")
        return np.asarray(answer.velocity_density(v_checked, phi_checked))

    # -- position ---------------------------------------------------------------------------------

    @property
    def ballistic_front(self) -> tuple[FloatArray, FloatArray]:
        """Radius in d, and share, of tracers of sharp speeds that have not collided.

        Shape (n_times, n_speeds) each: delta peaks, which :meth:`position_density` leaves out.
        """
        radius, share = self._displacement().uncollided.fronts
        return frozen(radius), frozen(share)

    def position_density(self, r: ArrayLike) -> FloatArray:
        """g(r, t), the radial density of the displacement (paper, fig. ``inelasticposi``), in 1/d.

        Shape (n_times, n_r). The integral over r is 1, less what :attr:`ballistic_front` holds. Its
        absolute error is max(rtol, 1e-8) over sqrt(<r^2>).
        """
        displacement = self._displacement()
        radii = not_negative_line("r", r)
        return np.array([displacement.density(time, radii) for time in range(self.times.size)])

    def scaled_position_density(self, scaled_radii: ArrayLike) -> FloatArray:
        """G(R) = sqrt(<r^2>) g(r, t) at R = r/sqrt(<r^2>), shape (n_times, n_R); NaN at t = 0.

        <r^2> is that of g itself: at a finite density :attr:`msd` knows that returns take time.
        """
        displacement = self._displacement()
        scaled = not_negative_line("scaled_radii", scaled_radii)
        density = np.full((self.times.size, scaled.size), np.nan)
        for time, root_mean_square in enumerate(displacement.root_mean_square):
            if root_mean_square > 0.0:
                radii = np.minimum(scaled, MAX_SCALED_RADIUS) * root_mean_square
                density[time] = root_mean_square * displacement.density(time, radii)
        return density

    def position_fraction(self, edges: ArrayLike) -> FloatArray:
        """Share of all tracers with r between rising edges, in d: (n_times, n_edges - 1).

        The ballistic front is in it, in (low, high].
        """
        displacement = self._displacement()
        radii = rising_from_zero("edges", edges)
        within = [displacement.within(time, radii) for time in range(self.times.size)]
        return np.diff(np.array(within), axis=1)

    def position_tail(self, scaled_radii: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """How the density p = G(R)/(2 pi R), in space G(R)/(4 pi R^2), falls: exponent and rate.

        Shapes (n_times, n_R), for R > 0. The exponent is d ln(ln(p(0)/p(R)))/d ln R, n where
        p ~ exp(-(R/b)^n), and the rate -d ln p/dR; without tracers that have not collided, NaN
        where p is below its error. Not at a finite density.
        """
        displacement = self._displacement()
        scaled = not_negative_line("scaled_radii", scaled_radii)
        if self.scene.law.returns(0)[0]:
            refuse("scatterers", self.scene.scatterers, "p(0) is infinite: some come straight back")
        exponent = np.full((self.times.size, scaled.size), np.nan)
        rate = np.full((self.times.size, scaled.size), np.nan)
        dimension = displacement.dimension
        measure = unit_surface(dimension) * radial_measure(
            np.maximum(scaled, MIN_RADIUS_OF_ERROR), dimension
        )
        for time, root_mean_square in enumerate(displacement.root_mean_square):
            if root_mean_square == 0.0:
                continue
            radii = np.minimum(scaled, MAX_SCALED_RADIUS) * root_mean_square
            p, slope = displacement.collided_in_place(time, radii)
            p_at_start, _ = displacement.collided_in_place(time, np.zeros(1))
            error_of_p = displacement.error_estimate / (measure * root_mean_square**dimension)
            is_known = (p > error_of_p) & (scaled > 0.0)
            with np.errstate(divide="ignore", invalid="ignore"):
                rate[time] = np.where(is_known, -root_mean_square * slope / p, np.nan)
                log_fall = np.log(p_at_start / p)
                exponent[time] = np.where(is_known, scaled * rate[time] / log_fall, np.nan)
        return exponent, rate

    def intermediate_scattering(
        self, wave_numbers: ArrayLike, direction: float | None = None
    ) -> NDArray[Any]:
        """F(k, t) = <exp(i k.r)> for k in 1/d, shape (n_times, n_k), to max(rtol, 1e-12) absolute.

        ``direction`` is the angle of k to the x axis, in radians, for directed starts, where F is
        complex; by default F is the mean over the directions of k, and real.
        """
        self._require("intermediate_scattering")
        k = not_negative_line("wave_numbers", wave_numbers)
        if direction is not None:
            direction = real_number("direction", direction, allowed="it must be a finite angle")
        return scattering_function(self._undriven().averages, k, direction)

    def displacement_between_frames(self) -> FloatArray:
        """M(s, t) = <|r(t) - r(s)|^2> in d^2 between all pairs of times, as a camera sees it.

        Shape (n_times, n_times), symmetric, zero on the diagonal. From time 0 it is <r^2>; later it
        is less, as tracers have cooled. Not with a field, nor for driven tracers, and only for
        dilute scatterers, among which a tracer forgets its place and its direction. Warns where it
        differs from <r^2>, at a first time of 0, by more than max(rtol, 1e-6), 1e-4 for rough
        starts.
        """
        answer = self._undriven()
        if self.scene.scatterers != "dilute":
            refuse("scatterers", self.scene.scatterers, "it is available for dilute ones only")
        law, path, state, _ = self.scene.problem
        rtol = max(self.rtol, self._min_rtol_of_speed_shares)
        solve = self._speed_profiles(rtol, None)
        squares = mean_square_between_frames(solve, law, state, self.times, path, rtol)
        if self.times[0] == 0.0 and self.times[-1] > 0.0:
            expected = root_mean_square_displacement(answer.averages) ** 2
            later = expected > 0.0
            error = float(np.abs(squares[0, later] / expected[later] - 1.0).max(initial=0.0))
            if error > rtol:
                warn_missed("M(s, t)", error, rtol)
        return np.asarray(frozen(squares))

    @property
    def _min_rtol_of_speed_shares(self) -> float:
        """The accuracy of averages over speeds, of smooth or of rough starts."""
        is_smooth = self.scene.state.smooth
        return MIN_RTOL_OF_FLIGHTS if is_smooth else MIN_RTOL_OF_FLIGHTS_ROUGH

    def _speed_profiles(self, rtol: float, nodes: int | None) -> Callable[[FloatArray], Profile]:
        """Return what maps times in d/U to the speed density then."""

        def speed_profile(times: FloatArray) -> Profile:
            # whether it converges does not matter: averages that are known say how good it is
            scene = replace(self.scene, times=times, outputs=("speed_density",))
            try:
                return UndrivenAnswer(scene, rtol, None, nodes).profiles[0]
            except TooManyNodesError:
                return UndrivenAnswer(scene, rtol, "conservative", nodes).profiles[0]

        return speed_profile

    # -- free flights -----------------------------------------------------------------------------

    @cached_property
    def _flights(self) -> Flights:
        """The free flights; warns where the densities give another number of collisions."""
        answer = self._undriven()
        if self.scene.scatterers != "dilute":
            refuse("scatterers", self.scene.scatterers, "free flights are of dilute ones only")
        law, path, state, _ = self.scene.problem
        rtol = min(max(self.rtol, self._min_rtol_of_speed_shares), MAX_RTOL_OF_FLIGHTS)
        nodes = None
        if not state.smooth and rtol == MAX_RTOL_OF_FLIGHTS:
            nodes = NODES_OF_ROUGH_FLIGHTS
        solve = self._speed_profiles(rtol, nodes)
        flights = Flights.of(solve, law, state, self.times, path)
        expected = collisions(answer.averages)[-1]
        number = float(flights.longer_in_time(np.zeros(1))[-1, 0])
        error = abs(number / max(expected, 1e-300) - 1.0)
        allowed = FLIGHTS_SAFETY * rtol
        if error > allowed:
            text = f"free flights: their number is off by {error:.1e}, against {allowed:.1e}"
            warnings.warn(text, ToleranceWarning, stacklevel=5)
        return flights

    def free_time_fraction(self, edges: ArrayLike) -> FloatArray:
        """Share of the completed flights whose duration in d/U is between the edges.

        Shape (n_times, n_edges - 1). A flight is completed if a collision ends it up to the time;
        the first one of a tracer begins at time 0. Each counts once, so that fast tracers count
        more than slow ones: a histogram of all flights (free_time_histogram of `particles`). NaN at
        time 0. Divided by the widths of the bins it is their mean density. Warns where the speed
        densities give another number of collisions by ten times their tolerance: rtol, 1e-6 at
        least, 1e-4 for rough starts. Raises InputError for edges that are negative or do not rise,
        with a field, for driven tracers and for scatterers that are not dilute.
        """
        return self._flight_fraction(edges, Flights.longer_in_time)

    def free_path_fraction(self, edges: ArrayLike) -> FloatArray:
        """Share of the same flights whose length in d is between the edges, as above.

        Lengths tend to exp(-x/l), l the mean free path: as 1/t for e = 1, as 1/ln t below.
        """
        return self._flight_fraction(edges, Flights.longer_in_length)

    def _flight_fraction(
        self, edges: ArrayLike, count_longer: Callable[[Flights, FloatArray], FloatArray]
    ) -> FloatArray:
        """Return the share of flights between edges of their duration, or of their length.

        count_longer : counts the flights that are longer than edges, in l/U or l
        """
        checked = rising_from_zero("edges", edges)
        if self.times[-1] == 0.0:
            return np.full((self.times.size, checked.size - 1), np.nan)
        longer = count_longer(self._flights, np.append(0.0, checked) / self.scene.mean_free_path)
        total = longer[:, :1]
        with np.errstate(invalid="ignore"):
            fraction = np.asarray(-np.diff(longer[:, 1:]) / total)
        fraction[self.times == 0.0] = np.nan  # no flight is completed: rounding over rounding
        return fraction
