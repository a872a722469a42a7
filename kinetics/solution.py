"""Solution: the answer to a Scene, a value with units and a status."""

from __future__ import annotations

import textwrap
import warnings
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics.answer import Answer, answer_to
from kinetics.densities.flights import Flights
from kinetics.densities.harmonic import speed_fronts
from kinetics.errors import InputError, ToleranceWarning
from kinetics.moments import velocity
from kinetics.moments.by_collision import ByCollision
from kinetics.moments.displacement import root_mean_square
from kinetics.numerics import FloatArray
from kinetics.outputs import AXES, OUTPUTS, Output, described
from kinetics.position.density import Displacement
from kinetics.position.directions import element, surface
from kinetics.position.intermediate_scattering import scattering_function
from kinetics.results import COMPONENTS, Result, dataset, frozen, variable
from kinetics.scene import Scene
from kinetics.status import PlanStep, SolverStatus
from kinetics.validation import finite_line, not_negative_line, real_number, refuse, speeds

if TYPE_CHECKING:
    from kinetics.field.scene import FieldScene

_BESIDE = {
    "speed_density": {"uncollided"},
    "position_density": {"front_radius", "front_weight"},
}
"""Function -> what comes with it in a dataset."""
_FLIGHT_NODES = 4000  # of rough starts at 1e-3: shares within .06 % in a tenth of the time
_BEYOND = 1e6  # R from which G is zero in double precision; r itself may overflow there


@dataclass(frozen=True)
class Solution(Result):
    """What :func:`kinetics.solve` found. Time is the first axis of every array.

    A value: its arrays and dictionaries are read-only, it can be compared, hashed and pickled, and
    :meth:`save` writes it to a file from which :func:`kinetics.load` makes an equal one.

    Attributes
    ----------
    scene : the question
    rtol : the relative accuracy asked for
    values : output name -> array whose first axis is time; also as attributes, ``solution.msd``
    status : SolverStatus; its text says what to change
    message : the status of this solution in words: which part misses its tolerance, by how much,
        and what to change
    error_estimate : largest relative error that the solver saw
    plan : what was solved and what was skipped, and why
    stats : numbers about the work (nodes, panels, points of the initial state)
    method, nodes : as they were given to `kinetics.solve`
    """

    scene: Scene
    rtol: float
    values: Mapping[str, FloatArray]
    status: SolverStatus
    message: str
    error_estimate: float
    plan: tuple[PlanStep, ...]
    stats: Mapping[str, Any]
    _typical_speed: FloatArray = field(repr=False)  # of the order of the thermal one, (n_times,)
    method: str | None = None
    nodes: int | None = None

    @classmethod
    def of(
        cls,
        answer: Answer | FieldScene,
        scene: Scene,
        rtol: float,
        method: str | None,
        nodes: int | None,
    ) -> Solution:
        """The solution that an answer makes."""
        values = answer.values  # what overflows is refused before densities are solved
        status, message = answer.verdict
        found = cls(
            scene=scene,
            rtol=rtol,
            values=values,
            status=status,
            message=message,
            error_estimate=max(answer.errors.values()),
            plan=answer.plan,
            stats=answer.stats,
            _typical_speed=answer.typical_speed,
            method=method,
            nodes=nodes,
        )
        vars(found)["_answer"] = answer
        return found

    @property
    def times(self) -> FloatArray:
        """Output times in d/U, shape (n_times,)."""
        return np.asarray(self.scene.times)

    # -- how it shows itself ------------------------------------------------------------------

    def __getattr__(self, name: str) -> FloatArray:
        values = self.__dict__.get("values", {})
        if name in values:
            return np.asarray(values[name])
        if name.startswith("_"):
            raise AttributeError(name)
        raise AttributeError(
            f"{name!r} was not asked for; this solution has {', '.join(values) or 'no arrays'}"
        )

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *self.__dict__.get("values", {})})

    def __repr__(self) -> str:
        status = f"rtol = {self.rtol:g}, {self.status.name.lower()}: {self.message}"
        shown = ", ".join(f"{name} {about}" for name, about in self._outputs().items())
        lines = [f"Solution of {self.scene}", status]
        lines += [f"error estimate {self.error_estimate:.1e}", *textwrap.wrap(shown, 96)]
        return "\n  ".join(lines)

    def _outputs(self) -> dict[str, str]:
        """Shape and unit of every array, and of every output that is a function."""
        shapes = {name: str(array.shape) for name, array in self.values.items()}
        shapes |= {name: f"({', '.join(OUTPUTS[name].shape)})" for name in self._on_demand}
        units = {name: described(name, self.scene.dimension)[0] for name in shapes}
        return {n: shapes[n] + ("" if u == "1" else f" in {u}") for n, u in units.items()}

    def _figures(self) -> dict[str, str]:
        found = {"status": self.message, "error estimate": f"{self.error_estimate:.1e}"}
        return found | self._outputs()

    # -- as a dataset -------------------------------------------------------------------------

    _points = (*(axis.points for axis in AXES.values()), "direction")

    @property
    def _on_demand(self) -> tuple[str, ...]:  # type: ignore[override]
        """The outputs that are functions of more than the time."""
        names = (name for name in self.scene.outputs if name in OUTPUTS)
        return tuple(name for name in names if set(OUTPUTS[name].shape) & set(AXES))

    def _dataset(self, only: Collection[str] | None = None, **points: Any) -> Any:
        """Averages, and functions at the points: speeds in U, angles and direction in radians,
        radii in d, scaled_radii, wave_numbers in 1/d; by default where the distributions are.
        """
        d = self.scene.dimension
        found = {
            name: variable(("time", *COMPONENTS[: a.ndim - 1]), a, *described(name, d))
            for name, a in self.values.items()
        }
        axes = {"time": variable(("time",), self.times, "d/U", "time since the start", "t")}
        axes |= {c: variable((c,), list("xyz"[:d]), "1", "component") for c in COMPONENTS}
        for output in self._on_demand:
            names = {*OUTPUTS[output].names, *_BESIDE.get(output, ())}
            if only is None or names & set(only):
                self._add(OUTPUTS[output], points, found, axes)
        return dataset(
            f"Solution of the inelastic Lorentz equation: {self.scene}",
            self.scene,
            found,
            axes,
            status=self.status.name.lower(),
            message=self.message,
            tolerance_asked=self.rtol,
            tolerance_reached=self.error_estimate,
        )

    def _add(
        self, row: Output, points: Mapping[str, Any], found: dict[str, Any], axes: dict[str, Any]
    ) -> None:
        """A function, and what comes with it, at the points."""
        turned = row.name == "intermediate_scattering" and "direction" in points
        more = {"direction": points["direction"]} if turned else {}
        for name in row.names:
            along = [AXES[n] for n in (row.shape[1:] if name == row.name else ("n_R",))]
            at = [self._points_on(axis.points, points) for axis in along]
            values = getattr(self, name)(*at, **more)
            for axis, x in zip(along, at, strict=True):
                axes[axis.name] = variable((axis.name,), x, axis.unit, axis.description)
            unit, words, symbol = described(name, self.scene.dimension)
            parts = [(name, values, symbol)]
            if np.iscomplexobj(values):
                sides = (("real", "Re"), ("imag", "Im"))
                parts = [(f"{name}_{p}", getattr(values, p), f"{s} {symbol}") for p, s in sides]
            for part, array, sign in parts:
                dims = ("time", *(axis.name for axis in along))
                found[part] = variable(dims, array, unit, words, sign)
        if row.name == "speed_density":
            words = "share of tracers of a start of one speed that have not collided (or e = 1)"
            found["uncollided"] = variable(("time",), self.uncollided, "1", words)
        if row.name == "position_density" and (fronts := self.ballistic_front)[0].shape[1]:
            numbers, dims = np.arange(fronts[0].shape[1]), ("time", "front")
            axes["front"] = variable(("front",), numbers, "1", "number of a sharp speed")
            words = "radius of tracers that have not collided"
            found["front_radius"] = variable(dims, fronts[0], "d", words)
            found["front_weight"] = variable(dims, fronts[1], "1", "share of these tracers")

    def _points_on(self, points: str, given: Mapping[str, Any]) -> FloatArray:
        """What was given, or else points where the distributions are."""
        if given.get(points) is not None:
            return finite_line(points, given[points])
        if points == "speeds":
            usual = self._typical_speed[self._typical_speed > 0.0]  # at rest it is 0
            low, high = (usual.min(), usual.max()) if usual.size else (1.0, 1.0)
            return np.geomspace(1e-2 * low, 5.0 * high, 200)
        if points == "angles":
            return np.linspace(0.0, np.pi if self.scene.dimension == 3 else 2.0 * np.pi, 73)
        if points == "scaled_radii":
            return np.linspace(0.0, 5.0, 101)
        far = max(float(root_mean_square(self._answer.averages).max()), 1e-12)
        waves = np.geomspace(1e-2, 10.0, 61) / far
        return np.linspace(0.0, 5.0 * far, 121) if points == "radii" else waves

    def _to_storage(self) -> dict[str, Any]:
        parts = super()._to_storage()
        return parts | {"values": {name: {"variable": name} for name in self.values}}

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

    def _without_field(self) -> Answer:
        """The answer; InputError for a scene with a field or driven tracers: it has the outputs."""
        if self.scene.field:
            raise InputError(f"field: got {self.scene.field!r}; other moments need a field of 0")
        if self.scene.system is not None:
            raise InputError("outputs: of driven tracers there is no more than what was asked for")
        return self._answer

    def _velocities(self) -> Any:
        return self._asked("speed_density", "velocity_density")

    def _moved(self) -> Displacement:
        return self._asked("position_density").displacement

    # -- moments ------------------------------------------------------------------------------

    def moment(self, p: float) -> FloatArray:
        """<v^p>(t) in U^p for real p, shape (n_times,); InputError where it does not exist."""
        return np.asarray(self._without_field().power(p, 0).real)

    def harmonic(self, p: float, m: int) -> NDArray[Any]:
        """<v^p exp(-i m phi)>(t) in U^p, complex for m > 0, shape (n_times,); solved when asked.

        Raises InputError for p or m out of range.
        """
        return self._without_field().power(p, m)

    @property
    def by_collision(self) -> ByCollision:
        """The averages after N collisions, N the ``collision_numbers`` of the scene: closed forms.

        Raises InputError if the scene has no collision_numbers.
        """
        numbers = np.asarray(self.scene.collision_numbers)
        if numbers.size == 0:
            raise InputError("collision_numbers: the scene has none; give Scene some")
        law, path, state, _ = self.scene.problem
        return ByCollision(law, path, state, numbers, self.rtol)

    def at(self, times: ArrayLike) -> Solution:
        """The averages at other times up to the last of the scene, without solving it again.

        ``times`` in d/U, not falling, shape (n,). The averages are those of a Solution of a scene
        with these times and the same last one, to the bit; `error_estimate` and `status` are of all
        times. Raises InputError where the scene asked for densities only, for one with a field, and
        for times out of range.
        """
        answer = self._without_field()
        outputs = tuple(name for name in self.scene.outputs if OUTPUTS[name].values is not None)
        if not outputs:
            raise InputError("outputs: none of this scene's is an average over the tracers")
        scene = replace(self.scene, times=times, outputs=outputs)
        if np.asarray(scene.times)[-1] > (last := float(self.times[-1])):
            refuse("times", times, f"this scene was solved up to its last time, {last:g} d/U")
        return Solution.of(answer.at(scene), scene, self.rtol, self.method, self.nodes)

    # -- velocity -----------------------------------------------------------------------------

    def speed_density(self, v: ArrayLike) -> FloatArray:
        """Density of the speed at v (in U), shape (n_times, n_v), in 1/U; integral over v is 1.

        Without the tracers of :attr:`uncollided`. From smooth starts the error is at most rtol of
        the maximum for v above 1e-2 of the thermal speed, below it that of the density of ln v.
        From rough ones (sharp speeds, steps, noise: the plan says "conservative") the share of
        tracers slower than v, the integral of this density with :attr:`uncollided`, is right to
        rtol; f itself is not at its steps (:attr:`speed_fronts`). Raises InputError for v negative
        or not finite, or if "speed_density" was not among the outputs.
        """
        return self._velocities().speed_density(speeds(v))

    @property
    def uncollided(self) -> FloatArray:
        """Share of tracers in the delta peak of a monoenergetic start, shape (n_times,).

        Those that have not collided (at e = 1 all); zero for other starts. With a field, of any
        start of sharp velocities (rest, one speed, a Beam, samples).
        """
        return frozen(self._velocities().uncollided)

    @property
    def captured(self) -> FloatArray:
        """The share of tracers that stick, (n_times,); InputError unless impacts may stick."""
        if not self.scene.capture_speed:
            refuse("capture_speed", self.scene.capture_speed, "it must be above 0: nothing sticks")
        return frozen(self._answer.captured)

    @property
    def speed_fronts(self) -> FloatArray:
        """Speeds in U, rising, at which :meth:`speed_density` may step or be infinite.

        Of a start of sharp speeds (empty for others): those speeds, and the ends of what one and
        two collisions make of them.
        """
        scene = self.scene
        sharp = scene.state.profile(0) is None and not scene.field and scene.system is None
        start = scene.state.harmonic(0, 1e-6) if sharp else None
        return frozen(speed_fronts(scene.law, start) if sharp else np.empty(0))

    def velocity_component_density(self, v_x: ArrayLike) -> FloatArray:
        """Density of one velocity component (isotropic part), shape (n_times, n), in 1/U.

        Its integral is 1; with c_x = v_x/v0 it is F(c_x) of the paper's figure ``scalev``. The
        error is 1e-8 of the maximum, a percent near steps. With a field it is the component along
        it, and sharp starts are refused. Raises InputError as :meth:`speed_density` does.
        """
        return self._velocities().component_density(finite_line("v_x", v_x))

    def velocity_density(self, v: ArrayLike, phi: ArrayLike) -> FloatArray:
        """f(v, phi), the density in the velocity plane, shape (n_times, n_v, n_phi), in 1/U^2.

        The sum of the harmonics up to ``scene.harmonics``, with a field of all; integral of
        f v dv dphi is 1. In space phi is the angle to the x axis, about which f is symmetric: the
        density is in 1/U^3, and the integral of 2 pi f v^2 sin(phi) dv dphi is 1. Delta peaks are
        left out; v must be above 0. Raises InputError for bad v or phi, or if "velocity_density"
        was not among the outputs.
        """
        v_, phi_ = speeds(v, zero_allowed=False), finite_line("phi", phi)
        return self._asked("velocity_density").velocity_density(v_, phi_)

    # -- position -----------------------------------------------------------------------------

    @property
    def ballistic_front(self) -> tuple[FloatArray, FloatArray]:
        """Where tracers of sharp speeds are that have not collided, and how many of all they are.

        Radius in d and share, shape (n_times, n_speeds) each: delta peaks, which
        :meth:`position_density` leaves out. n_speeds is 0 for a start with a speed density.
        """
        found = self._moved()
        return frozen(found.front_radius), frozen(found.front_weight)

    def position_density(self, r: ArrayLike) -> FloatArray:
        """g(r, t), the radial density of the displacement (paper, fig. ``inelasticposi``), in 1/d.

        Shape (n_times, n_r). The integral over r is 1, less what :attr:`ballistic_front` holds. Its
        absolute error is max(rtol, 1e-8) over sqrt(<r^2>). Raises InputError for negative radii,
        or if "position_density" was not among the outputs.
        """
        found, r_ = self._moved(), not_negative_line("r", r)
        return np.array([found.density(i, r_) for i in range(self.times.size)])

    def scaled_position_density(self, scaled_radii: ArrayLike) -> FloatArray:
        """G(R) = sqrt(<r^2>) g(r, t) at R = r/sqrt(<r^2>), shape (n_times, n_R).

        <r^2> is that of g itself: at a finite density :attr:`msd` knows that returns take time.
        NaN at t = 0, where all tracers are at the origin. Raises InputError for negative R.
        """
        found, x = self._moved(), not_negative_line("scaled_radii", scaled_radii)
        out = np.full((self.times.size, x.size), np.nan)
        for i, root in enumerate(found.root_mean_square):
            if root > 0.0:
                out[i] = root * found.density(i, np.minimum(x, _BEYOND) * root)
        return out

    def position_fraction(self, edges: ArrayLike) -> FloatArray:
        """Share of all tracers with r between the edges, in d: shape (n_times, n_edges - 1).

        For histograms: the ballistic front is in it, in (low, high]. Raises InputError for edges
        that are negative or do not rise.
        """
        found, r = self._moved(), not_negative_line("edges", edges)
        if r.size < 2 or np.any(np.diff(r) <= 0.0):
            refuse("edges", edges, "they must rise, two at least")
        return np.array([np.diff(found.within(i, r)) for i in range(self.times.size)])

    # -- free flights -------------------------------------------------------------------------

    @cached_property
    def _flights(self) -> Flights:
        answer = self._without_field()
        if self.scene.scatterers != "dilute":
            refuse("scatterers", self.scene.scatterers, "free flights are of dilute ones only")
        smooth = self.scene.state.smooth
        rtol = min(max(self.rtol, 1e-6 if smooth else 1e-4), 1e-3)
        nodes = None if smooth or rtol < 1e-3 else _FLIGHT_NODES

        def solved(times: FloatArray) -> Solution:
            scene = replace(self.scene, times=times, outputs=("speed_density",))
            with warnings.catch_warnings():  # the number of collisions says how good it is
                warnings.simplefilter("ignore", ToleranceWarning)
                return Solution.of(answer_to(scene, rtol, None, nodes), scene, rtol, None, nodes)

        found = Flights.of(solved, self.times, self.scene.mean_free_path)
        known = velocity.collisions(answer.averages)[-1]
        off = abs(float(found.longer_in_time(np.zeros(1))[-1, 0]) / max(known, 1e-300) - 1.0)
        if off > 10.0 * rtol:
            words = f"free flights: their number is off by {off:.1e}, against {10 * rtol:.1e}"
            warnings.warn(words, ToleranceWarning, stacklevel=5)
        return found

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
        x = not_negative_line("edges", edges)
        if x.size < 2 or np.any(np.diff(x) <= 0.0):
            refuse("edges", edges, "they must rise, two at least")
        if self.times[-1] == 0.0:
            return np.full((self.times.size, x.size - 1), np.nan)
        number = getattr(self._flights, kind)(np.append(0.0, x) / self.scene.mean_free_path)
        with np.errstate(invalid="ignore"):
            return np.asarray(-np.diff(number[:, 1:]) / number[:, :1])

    def position_tail(self, scaled_radii: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """How the density p = G(R)/(2 pi R) in the plane falls at R: its exponent and its rate.

        In space p = G(R)/(4 pi R^2). Shapes (n_times, n_R), for R > 0. The exponent is
        d ln(ln(p(0)/p(R)))/d ln R, n where p ~ exp(-(R/b)^n), and the rate -d ln p/dR; without
        tracers that have not collided, NaN where p is below its error. Raises InputError as
        :meth:`scaled_position_density` does, and at a finite density.
        """
        found, x = self._moved(), not_negative_line("scaled_radii", scaled_radii)
        if self.scene.law.returns(0)[0]:
            refuse("scatterers", self.scene.scatterers, "p(0) is infinite: some come straight back")
        exponent, rate = np.full((2, self.times.size, x.size), np.nan)
        for i, root in enumerate(found.root_mean_square):
            if root == 0.0:
                continue
            p, slope = found.collided_in_place(i, np.minimum(x, _BEYOND) * root)
            center, _ = found.collided_in_place(i, np.zeros(1))
            d = found.dimension
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
        complex (in space the start is symmetric about this axis); by default F is the mean over the
        directions of k, and real. Raises InputError for wave numbers that are none, negative, not
        finite or larger than can be solved for, or if "intermediate_scattering" was not among the
        outputs.
        """
        answer = self._asked("intermediate_scattering")
        k = not_negative_line("wave_numbers", wave_numbers)
        if direction is not None:
            direction = real_number("direction", direction, allowed="it must be a finite angle")
        return scattering_function(answer.averages, k, direction)
