"""solve(scene), and the Solution that it returns: a value with units and a status."""

from __future__ import annotations

import textwrap
import warnings
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics.densities.flights import Flights, speed_fronts
from kinetics.densities.harmonic import Profile
from kinetics.errors import InputError, PlanStep, SolverStatus, ToleranceWarning
from kinetics.moments.averages import collisions, root_mean_square
from kinetics.moments.by_collision import ByCollision
from kinetics.numerics import FloatArray
from kinetics.outputs import AXES, OUTPUTS, described
from kinetics.position.directions import element, surface
from kinetics.position.intermediate_scattering import scattering_function
from kinetics.results import COMPONENTS, Result, dataset, frozen, variable
from kinetics.scene import Scene
from kinetics.solver import Answer, answer_to
from kinetics.validation import (
    check_rtol,
    finite_line,
    not_negative_line,
    one_of,
    real_number,
    refuse,
    rising_from_zero,
    speeds,
    whole_number,
)

METHODS = ("spectral", "conservative")
_FLIGHT_NODES = 4000  # of rough starts at 1e-3: shares within .06 % in a tenth of the time
_BEYOND = 1e6  # R from which G is zero in double precision; r itself may overflow there


def solve(
    scene: Scene, rtol: float | None = None, method: str | None = None, nodes: int | None = None
) -> Solution:
    """Solve the inelastic Lorentz equation for what the scene asks.

    Parameters
    ----------
    scene : system, initial state, times and outputs
    rtol : relative accuracy, 1e-14 to 0.1, of every average (of 1 + a2 for a2; of <v^p> for its
        harmonics; of v_rms(0) v_rms(t), v_rms = sqrt(<v^2>), for velocity_autocorrelation), and of
        the densities relative to their maximum, for speeds above 1e-2 of the thermal one; below it
        is the density of ln v that keeps it. The scaled position density G(R) is solved to
        max(rtol, 1e-8), absolute. By default 1e-10; 1e-8 for driven tracers, 1e-6 with a field, and
        densities of both are solved to max(rtol, 1e-4)
    method : how densities are made: "spectral" (for smooth states), "conservative" (mass and
        positivity exact, second order, for rough ones), or None for the solver's choice
    nodes : of the speed axis of the densities, 8 to 8192, for convergence studies

    Returns a Solution. Warns (ToleranceWarning) where its status is not CONVERGED. Raises
    InputError (a ValueError) for an argument out of range, a density that is negative, not
    normalised or without second moment, or a method that cannot do the scene.

    >>> from kinetics import Scene
    >>> solution = solve(Scene(restitution=0.7, times=[0.0, 1e3, 1e6]))
    >>> bool(abs(solution.thermal_speed[0] - 2**0.5) < 1e-10)
    True
    """
    if not isinstance(scene, Scene):
        refuse("scene", scene, "it must be a Scene")
    if rtol is None:
        rtol = 1e-6 if scene.field else 1e-8 if scene.system else 1e-10
    rtol = check_rtol(rtol)
    method = None if method is None else one_of("method", method, METHODS)
    nodes = None if nodes is None else whole_number("nodes", nodes, 8, 8192)
    answer = answer_to(scene, rtol, method, nodes)
    values = answer.values  # what overflows is refused before densities are solved
    status, message = answer.verdict
    error, work = max(answer.errors.values()), (answer.plan, answer.stats)
    solution = Solution(scene, rtol, values, status, message, error, *work, method, nodes)
    vars(solution)["_answer"] = answer
    if solution.status is not SolverStatus.CONVERGED:
        warnings.warn(solution.message, ToleranceWarning, stacklevel=2)
    return solution


def sweep(restitutions: ArrayLike, rtol: float | None = None, **scene: Any) -> Any:
    """Averages over time for several restitutions, as one `xarray.Dataset` with that dimension.

    restitutions : e, shape (n_restitutions,); scene : the other arguments of a Scene, with times
    and outputs. Variables have the shape (n_restitutions, n_times, ...), with units; "status" and
    "error_estimate" are (n_restitutions,). Warns and raises as :func:`solve` does.

    >>> found = sweep([0.5, 0.9], times=[0.0, 1e3], outputs="thermal_speed")
    >>> found.thermal_speed.dims, found.thermal_speed.sel(restitution=0.9).shape
    (('restitution', 'time'), (2,))
    """
    import xarray

    e = finite_line("restitutions", restitutions, low=0.0)
    if e.size == 0:
        refuse("restitutions", restitutions, "there must be one at least")
    each = [solve(Scene(x, **scene), rtol) for x in e.tolist()]
    along = xarray.Variable("restitution", e, {"long_name": "coefficient of restitution"})
    found = xarray.concat([one.to_xarray() for one in each], along, combine_attrs="drop_conflicts")
    found["status"] = "restitution", [one.status.name.lower() for one in each]
    found["error_estimate"] = "restitution", [one.error_estimate for one in each]
    return found


@dataclass(frozen=True)
class Solution(Result):
    """What :func:`kinetics.solve` found. Time is the first axis of every array.

    A value: its arrays and dictionaries are read-only, it can be compared, hashed and pickled, and
    :meth:`save` writes it to a file from which :func:`kinetics.load` makes an equal one. Methods
    raise InputError for arguments out of range, and where their output was not asked for.

    Attributes
    ----------
    scene : the question
    rtol, method, nodes : as they were given to `kinetics.solve`
    values : output name -> array whose first axis is time; also as attributes, ``solution.msd``
    status : SolverStatus; its text says what to change
    message : which part misses its tolerance, by how much, and what to change
    error_estimate : largest relative error that the solver saw
    plan : what was solved and what was skipped, and why
    stats : numbers about the work (nodes, panels, points of the initial state)
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

    @property
    def times(self) -> FloatArray:
        """Output times in d/U, shape (n_times,)."""
        return np.asarray(self.scene.times)

    def __getattr__(self, name: str) -> FloatArray:
        values = self.__dict__.get("values", {})
        if name in values:
            return np.asarray(values[name])
        known = ", ".join(values) or "no arrays"
        raise AttributeError(f"{name!r} was not asked for; this solution has {known}")

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *self.__dict__.get("values", {})})

    def __repr__(self) -> str:
        shapes = {name: str(array.shape) for name, array in self.values.items()}
        shapes |= {name: f"({', '.join(OUTPUTS[name].shape)})" for name in self._on_demand}
        units = {name: described(name, self.scene.dimension)[0] for name in shapes}
        shown = [f"{n} {shapes[n]}" + ("" if u == "1" else f" in {u}") for n, u in units.items()]
        status = f"rtol = {self.rtol:g}, {self.status.name.lower()}: {self.message}"
        lines = [f"Solution of {self.scene}", status, f"error estimate {self.error_estimate:.1e}"]
        return "\n  ".join([*lines, *textwrap.wrap(", ".join(shown), 96)])

    # -- as a dataset -------------------------------------------------------------------------

    _points = (*(axis.points for axis in AXES.values()), "direction")

    @property
    def _on_demand(self) -> tuple[str, ...]:  # type: ignore[override]
        """The outputs that are functions of more than the time."""
        names = (name for name in self.scene.outputs if name in OUTPUTS)
        return tuple(name for name in names if set(OUTPUTS[name].shape) & set(AXES))

    def _dataset(self, only: Collection[str] | None = None, **points: Any) -> Any:
        """Averages, and functions at the points, by default where the distributions are."""
        d = self.scene.dimension
        found = {
            name: variable(("time", *COMPONENTS[: a.ndim - 1]), a, *described(name, d))
            for name, a in self.values.items()
        }
        axes = {"time": variable(("time",), self.times, "d/U", "time since the start", "t")}
        axes |= {c: variable((c,), list("xyz"[:d]), "1", "component") for c in COMPONENTS}
        functions = {name: OUTPUTS[name].shape[1:] for name in self._on_demand}
        if "position_density" in functions:
            functions["scaled_position_density"] = ("n_R",)
        asked = functions if only is None else only
        for name, shape in functions.items():
            if name in asked or (name == "speed_density" and "uncollided" in asked):
                self._add(name, shape, points, found, axes)
        title = f"Solution of the inelastic Lorentz equation: {self.scene}"
        return dataset(self, title, self.scene, found, axes)

    def _add(self, name: str, shape: tuple[str, ...], given: Any, found: Any, axes: Any) -> None:
        """A function at the points, and the share of tracers that a speed density leaves out."""
        along = [AXES[n] for n in shape]
        at = [self._points_on(axis.points, given) for axis in along]
        if name == "intermediate_scattering" and "direction" in given:
            at.append(given["direction"])
        values = getattr(self, name)(*at)
        unit, words, symbol = described(name, self.scene.dimension)
        for axis, x in zip(along, at, strict=False):
            axes[axis.name] = variable((axis.name,), x, axis.unit, axis.description)
        dims = ("time", *(axis.name for axis in along))
        if np.iscomplexobj(values):
            found[f"{name}_real"] = variable(dims, values.real, unit, words, f"Re {symbol}")
            found[f"{name}_imag"] = variable(dims, values.imag, unit, words, f"Im {symbol}")
        else:
            found[name] = variable(dims, values, unit, words, symbol)
        if name == "speed_density":
            words = "share of tracers of a start of one speed that have not collided (or e = 1)"
            found["uncollided"] = variable(("time",), self.uncollided, "1", words)

    def _points_on(self, points: str, given: Mapping[str, Any]) -> FloatArray:
        """What was given, or else points where the distributions are."""
        if given.get(points) is not None:
            return finite_line(points, given[points])
        if points == "speeds":
            usual = self._answer.typical_speed
            moving = usual[usual > 0.0] if usual.any() else np.ones(1)
            return np.geomspace(1e-2 * moving.min(), 5.0 * moving.max(), 200)
        if points == "angles":
            return np.linspace(0.0, 2.0 * np.pi / (self.scene.dimension - 1.0), 73)
        if points == "scaled_radii":
            return np.linspace(0.0, 5.0, 101)
        far = max(float(root_mean_square(self._answer.averages).max()), 1e-12)
        waves = np.geomspace(1e-2, 10.0, 61) / far
        return np.linspace(0.0, 5.0 * far, 121) if points == "radii" else waves

    # -- what was solved: no part of the value, solved again where it is not there ------------

    @cached_property
    def _answer(self) -> Any:
        return answer_to(self.scene, self.rtol, self.method, self.nodes)

    def __getstate__(self) -> dict[str, Any]:
        kept = vars(self).get("_answer")  # a copy need not solve densities again
        return super().__getstate__() | ({"_answer": kept} if isinstance(kept, Answer) else {})

    def _asked(self, *outputs: str) -> Any:
        """The answer; InputError unless one of these outputs was asked for."""
        if not set(outputs) & set(self.scene.outputs):
            raise InputError(f"outputs: {outputs[0]!r} was not asked for; name it in the scene")
        return self._answer

    def _without_field(self) -> Any:
        """The answer; InputError for a scene with a field or driven tracers: it has the outputs."""
        if self.scene.field:
            raise InputError(f"field: got {self.scene.field!r}; other moments need a field of 0")
        if self.scene.system is not None:
            raise InputError("outputs: of driven tracers there is no more than what was asked for")
        return self._answer

    def _moved(self) -> Any:
        return self._asked("position_density").displacement

    # -- moments ------------------------------------------------------------------------------

    def moment(self, p: float) -> FloatArray:
        """<v^p>(t) in U^p for real p, shape (n_times,), where it exists."""
        return np.asarray(self._without_field().power(p, 0).real)

    def harmonic(self, p: float, m: int) -> NDArray[Any]:
        """<v^p exp(-i m phi)>(t) in U^p, complex for m > 0, shape (n_times,)."""
        return np.asarray(self._without_field().power(p, m))

    @property
    def by_collision(self) -> ByCollision:
        """The averages after N collisions, N the ``collision_numbers`` of the scene."""
        numbers = np.asarray(self.scene.collision_numbers)
        if numbers.size == 0:
            raise InputError("collision_numbers: the scene has none; give Scene some")
        law, path, state, _ = self.scene.problem
        return ByCollision(law, path, state, numbers, self.rtol)

    # -- velocity -----------------------------------------------------------------------------

    def speed_density(self, v: ArrayLike) -> FloatArray:
        """Density of the speed at v (in U), shape (n_times, n_v), in 1/U; integral over v is 1.

        Without the tracers of :attr:`uncollided`. From smooth starts the error is at most rtol of
        the maximum for v above 1e-2 of the thermal speed, below it that of the density of ln v.
        From rough ones (sharp speeds, steps, noise: the plan says "conservative") its integral up
        to v, with :attr:`uncollided`, is right to rtol; f itself is not at its steps
        (:attr:`speed_fronts`).
        """
        return np.asarray(self._asked("speed_density", "velocity_density").speed_density(speeds(v)))

    @property
    def speed_fronts(self) -> FloatArray:
        """Speeds in U, rising, at which :meth:`speed_density` may step or be infinite.

        Of a start of sharp speeds (empty for others): those speeds, and the ends of what one and
        two collisions make of them.
        """
        scene = self.scene
        sharp = scene.state.profile(0) is None and not scene.field and scene.system is None
        start = scene.state.harmonic(0, 1e-6) if sharp else None
        return np.zeros(0) if start is None else speed_fronts(scene.law, start)

    @property
    def uncollided(self) -> FloatArray:
        """Share of the tracers of a start of one speed that have not collided, (n_times,).

        All at e = 1. With a field, of any start of sharp velocities (rest, a Beam, samples).
        """
        return np.asarray(frozen(self._asked("speed_density", "velocity_density").uncollided))

    @property
    def captured(self) -> FloatArray:
        """The share of tracers that stick, (n_times,); InputError unless impacts may stick."""
        if not self.scene.capture_speed:
            refuse("capture_speed", self.scene.capture_speed, "it must be above 0: nothing sticks")
        return np.asarray(frozen(self._answer.captured))

    def velocity_component_density(self, v_x: ArrayLike) -> FloatArray:
        """Density of one velocity component (isotropic part), shape (n_times, n), in 1/U.

        With c_x = v_x/v0 it is F(c_x) of the paper's figure ``scalev``. The error is 1e-8 of the
        maximum, a percent near steps. Not with a field, nor of driven tracers.
        """
        answer = self._asked("speed_density", "velocity_density")
        return np.asarray(answer.component_density(finite_line("v_x", v_x)))

    def velocity_density(self, v: ArrayLike, phi: ArrayLike) -> FloatArray:
        """f(v, phi), the density in the velocity plane, shape (n_times, n_v, n_phi), in 1/U^2.

        The sum of the harmonics up to ``scene.harmonics``, with a field of all; integral of f v dv
        dphi is 1. In space phi is the angle to the x axis, the density is in 1/U^3, and the
        integral of 2 pi f v^2 sin(phi) dv dphi is 1. Delta peaks are left out; v must be above 0.
        """
        v_, phi_ = speeds(v, zero_allowed=False), finite_line("phi", phi)
        return np.asarray(self._asked("velocity_density").velocity_density(v_, phi_))

    # -- position -----------------------------------------------------------------------------

    @property
    def ballistic_front(self) -> tuple[FloatArray, FloatArray]:
        """Radius in d, and share, of tracers of sharp speeds that have not collided.

        Shape (n_times, n_speeds) each: delta peaks, which :meth:`position_density` leaves out.
        """
        radius, share = self._moved().uncollided.fronts
        return frozen(radius), frozen(share)

    def position_density(self, r: ArrayLike) -> FloatArray:
        """g(r, t), the radial density of the displacement (paper, fig. ``inelasticposi``), in 1/d.

        Shape (n_times, n_r). The integral over r is 1, less what :attr:`ballistic_front` holds. Its
        absolute error is max(rtol, 1e-8) over sqrt(<r^2>).
        """
        found, r_ = self._moved(), not_negative_line("r", r)
        return np.array([found.density(i, r_) for i in range(self.times.size)])

    def scaled_position_density(self, scaled_radii: ArrayLike) -> FloatArray:
        """G(R) = sqrt(<r^2>) g(r, t) at R = r/sqrt(<r^2>), shape (n_times, n_R); NaN at t = 0.

        <r^2> is that of g itself: at a finite density :attr:`msd` knows that returns take time.
        """
        found, x = self._moved(), not_negative_line("scaled_radii", scaled_radii)
        out = np.full((self.times.size, x.size), np.nan)
        for i, root in enumerate(found.root_mean_square):
            if root > 0.0:
                out[i] = root * found.density(i, np.minimum(x, _BEYOND) * root)
        return out

    def position_fraction(self, edges: ArrayLike) -> FloatArray:
        """Share of all tracers with r between rising edges, in d: (n_times, n_edges - 1).

        The ballistic front is in it, in (low, high].
        """
        found, r = self._moved(), rising_from_zero("edges", edges)
        return np.array([np.diff(found.within(i, r)) for i in range(self.times.size)])

    # -- free flights -------------------------------------------------------------------------

    @cached_property
    def _flights(self) -> Flights:
        answer = self._without_field()
        if self.scene.scatterers != "dilute":
            refuse("scatterers", self.scene.scatterers, "free flights are of dilute ones only")
        law, path, state, _ = self.scene.problem
        smooth = state.smooth
        rtol = min(max(self.rtol, 1e-6 if smooth else 1e-4), 1e-3)
        nodes = None if smooth or rtol < 1e-3 else _FLIGHT_NODES

        def speed_profile(times: FloatArray) -> Profile:
            # whether it converges does not matter: the number of collisions says how good it is
            scene = replace(self.scene, times=times, outputs=("speed_density",))
            return Answer(scene, rtol, None, nodes).profiles[0]

        flights = Flights.of(speed_profile, law, state, self.times, path)
        expected = collisions(answer.averages)[-1]
        number = float(flights.longer_in_time(np.zeros(1))[-1, 0])
        off = abs(number / max(expected, 1e-300) - 1.0)
        if off > 10.0 * rtol:
            words = f"free flights: their number is off by {off:.1e}, against {10 * rtol:.1e}"
            warnings.warn(words, ToleranceWarning, stacklevel=5)
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
        return self._flight_fraction(edges, "longer_in_time")

    def free_path_fraction(self, edges: ArrayLike) -> FloatArray:
        """Share of the same flights whose length in d is between the edges, as above.

        Lengths tend to exp(-x/l), l the mean free path: as 1/t for e = 1, as 1/ln t below.
        """
        return self._flight_fraction(edges, "longer_in_length")

    def _flight_fraction(self, edges: ArrayLike, kind: str) -> FloatArray:
        x = rising_from_zero("edges", edges)
        if self.times[-1] == 0.0:
            return np.full((self.times.size, x.size - 1), np.nan)
        number = getattr(self._flights, kind)(np.append(0.0, x) / self.scene.mean_free_path)
        with np.errstate(invalid="ignore"):
            return np.asarray(-np.diff(number[:, 1:]) / number[:, :1])

    def position_tail(self, scaled_radii: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """How the density p = G(R)/(2 pi R), in space G(R)/(4 pi R^2), falls: exponent and rate.

        Shapes (n_times, n_R), for R > 0. The exponent is d ln(ln(p(0)/p(R)))/d ln R, n where
        p ~ exp(-(R/b)^n), and the rate -d ln p/dR; without tracers that have not collided, NaN
        where p is below its error. Not at a finite density.
        """
        found, x = self._moved(), not_negative_line("scaled_radii", scaled_radii)
        if self.scene.law.returns(0)[0]:
            refuse("scatterers", self.scene.scatterers, "p(0) is infinite: some come straight back")
        exponent, rate = np.full((2, self.times.size, x.size), np.nan)
        d = found.dimension
        for i, root in enumerate(found.root_mean_square):
            if root == 0.0:
                continue
            p, slope = found.collided_in_place(i, np.minimum(x, _BEYOND) * root)
            center, _ = found.collided_in_place(i, np.zeros(1))
            floor = found.error_estimate / (surface(d) * element(np.maximum(x, 0.1), d) * root**d)
            with np.errstate(divide="ignore", invalid="ignore"):
                good = (p > floor) & (x > 0.0)
                rate[i] = np.where(good, -root * slope / p, np.nan)
                exponent[i] = np.where(good, x * rate[i] / np.log(center / p), np.nan)
        return exponent, rate

    def intermediate_scattering(
        self, wave_numbers: ArrayLike, direction: float | None = None
    ) -> NDArray[Any]:
        """F(k, t) = <exp(i k.r)> for k in 1/d, shape (n_times, n_k), to max(rtol, 1e-12) absolute.

        ``direction`` is the angle of k to the x axis, in radians, for directed starts, where F is
        complex; by default F is the mean over the directions of k, and real.
        """
        answer = self._asked("intermediate_scattering")
        k = not_negative_line("wave_numbers", wave_numbers)
        if direction is not None:
            direction = real_number("direction", direction, allowed="it must be a finite angle")
        return scattering_function(answer.averages, k, direction)
