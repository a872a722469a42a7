"""The base class of steady states: what answers of `solve_steady` and `solve_field` share.

A steady state is that of a driven tracer after a long time: figures (averages and diffusion
coefficients), moments, and the density of its velocity. A subclass chooses the units, and says
which figures there are: `kinetics.driven.field_state.FieldState`, in a field alone, and
`kinetics.driven.driven_state.DrivenState`, for all drives. l is the mean free path, d the
dimension, v the speed.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import astuple, dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from kinetics.drive import Drive
from kinetics.driven.over_time import MIN_ERROR_OF_DENSITY
from kinetics.driven.resolution import ChebyshevResolution
from kinetics.driven.steady_solution import SteadySolution
from kinetics.errors import PlanStep, SolverStatus, judge_errors
from kinetics.numerics import FloatArray
from kinetics.outputs import AVERAGES
from kinetics.results.frame import dataset, variable
from kinetics.results.labels import system_items
from kinetics.results.result import Result
from kinetics.results.table import Table, number_text, wrapped
from kinetics.validation import finite_line, real_number, whole_number

if TYPE_CHECKING:
    import xarray

#: Highest power of the speed of a moment that may be requested. Origin not recorded.
MAX_POWER = 20.0
#: Least relative error with which a figure is shown: averages are sums over nodes, and rounding
#: alone is larger than what two resolutions differ by. Chosen.
LEAST_ERROR_SHOWN = 1e-11
#: Speeds of a dataset over the thermal one, sqrt(<v^2>), unless others are specified: up
#: to where a Gaussian in the plane is 1e-7 of its largest. Chosen: no other number
#: depends on them.
SPEEDS_SHOWN = np.linspace(0.025, 4.0, 160)
#: Angles to the field of a dataset, in units of pi, unless others are specified: along the
#: field, across it and against it.
ANGLES_SHOWN = np.array([0.0, 0.5, 1.0])


@dataclass(frozen=True, eq=False, repr=False)
class SteadyState(Result):
    """What the answers of `solve_steady` and `kinetics.solve_field` share.

    A subclass declares its figures in ``_about``, the arguments of its question in ``_asked`` and
    its units in ``_units``, and implements `drive`, `_density_at` and ``_thermal_speed``. The
    units of each figure are in ``_about``.

    Attributes
    ----------
    restitution : e, or what else a collision law is made of (see `kinetics.Scene`)
    dimension : d, 2 or 3
    mass_ratio : mass of a scatterer over that of the tracer; infinite for fixed scatterers
    rtol : relative error that was requested
    drift : <v_x>, along the field
    mean_square_along : <v_x^2>, with the square of the drift
    diffusion_parallel, diffusion_perpendicular : half the growth rate of the variance of the
        position along the field, and in one direction across it
    error_estimate : relative error of the figures, the difference of two resolutions
    status, message : SolverStatus, and in words what misses its tolerance and what to change
    plan, stats : what was solved, and numbers about the work
    """

    restitution: Any
    dimension: int
    mass_ratio: float = field(default=math.inf, kw_only=True)
    rtol: float
    drift: float
    mean_square_along: float
    diffusion_parallel: float
    diffusion_perpendicular: float
    error_estimate: float
    status: SolverStatus
    message: str
    plan: tuple[PlanStep, ...]
    stats: Mapping[str, Any]
    #: The fields of the `ChebyshevResolution`.
    _resolution: tuple[int, int, int, float]
    #: The solution; None in a loaded or pickled state, until it is needed.
    _kept: SteadySolution | None = field(default=None, init=False, compare=False, repr=False)

    #: What a user may specify for a dataset, see `Result`: speeds, and angles to the field.
    _points = ("speeds", "angles")
    #: What a dataset has only where it is requested, see `Result`; figures it always has.
    _on_demand = ("vdf",)
    #: The figures: the name of an attribute, and its unit and meaning in words.
    _about: ClassVar[Mapping[str, tuple[str, str]]]
    #: The names of the attributes that are arguments of the question.
    _asked: ClassVar[tuple[str, ...]]
    #: The unit of a speed, and the unit of the density of the velocity.
    _units: ClassVar[tuple[str, str]]

    @classmethod
    def _of(cls, solution: SteadySolution, error: float, rtol: float, **parts: Any) -> Self:
        """Return the state of a solution, with its status, message, plan and stats.

        Parameters
        ----------
        solution : the finest solution; it is kept until the state is pickled or saved
        error : estimated relative error of the figures
        rtol : relative error that was requested
        parts : the other fields of the subclass, by name
        """
        status, message = judge_errors({AVERAGES: error}, {AVERAGES: rtol})
        resolution = solution.resolution
        highest = solution.axis.highest
        state = cls(
            **parts,
            rtol=rtol,
            error_estimate=error,
            status=status,
            message=message + solution.drive.limits,
            plan=(
                PlanStep("angular harmonics", True, f"0 to {resolution.harmonics}"),
                PlanStep("speeds", True, f"{resolution.nodes} points up to {highest:.3g}"),
                # diffusion is that of tracers for all time: where they stick, there is none
                PlanStep("dispersion", not solution.decay, "the linear response to the velocity"),
            ),
            stats={
                "harmonics": resolution.harmonics,
                "nodes": resolution.nodes,
                "highest_speed": highest,
            },
            _resolution=astuple(resolution),
        )
        state.store(_kept=solution)
        return state

    @property
    def drive(self) -> Drive:
        """What drives the tracer: fields, baths and drag, with the collision law."""
        raise NotImplementedError

    @property
    def _thermal_speed(self) -> float:
        """sqrt(<v^2>) in the unit of speeds, ``_units[0]``."""
        raise NotImplementedError

    def vdf(self, v: ArrayLike, angle: ArrayLike | None = None) -> FloatArray:
        """Return the density of the velocity in ``_units[1]``; its integral is 1.

        Parameters
        ----------
        v : speeds in ``_units[0]``, shape (n_v,)
        angle : to the field in radians, shape (n_angle,); None for along it, or without a field for
            any, as the density is the same at all

        Returns
        -------
        Shape (n_v, n_angle); without an angle the shape of v
        """
        if angle is None:
            return self._density_at(v, 0.0)[:, 0].reshape(np.shape(v))
        return self._density_at(v, angle)

    def _density_at(self, v: ArrayLike, angle: ArrayLike) -> FloatArray:
        """Return the density of the velocity, shape (n_v, n_angle)."""
        raise NotImplementedError

    @property
    def _solution(self) -> SteadySolution:
        """The solution; a loaded or unpickled state solves it again, at the same resolution."""
        if self._kept is None:
            resolution = ChebyshevResolution(*self._resolution)
            self.store(_kept=SteadySolution(self.drive, resolution))
        solution = self._kept
        assert solution is not None
        return solution

    def __getstate__(self) -> dict[str, Any]:
        """Return what pickle stores: all but the solution, which is large."""
        return super().__getstate__() | {"_kept": None}

    def _check_order(self, p: float, m: int, below: float = 0.0) -> tuple[float, int]:
        """Return the arguments of `moment`, <v^p cos(m phi)>, as numbers.

        Parameters
        ----------
        p : power of the speed; it must be above -d, where the integral at v = 0 exists
        m : angular harmonic, up to the highest that was solved for
        below : how far below -d a power p may be where m > 0

        Raises
        ------
        InputError
            p or m is out of range.
        """
        m = whole_number("m", m, 0, self._solution.resolution.harmonics)
        lowest = -self.dimension - (below if m else 0.0)
        allowed = f"for m = {m} it must be above {lowest:g}, and at most {MAX_POWER:g}"
        least = math.nextafter(lowest, 0.0)  # `lowest` itself is excluded
        return real_number("p", p, least, MAX_POWER, allowed), m

    @property
    def _arguments(self) -> dict[str, Any]:
        """The arguments of the question, by name: the attributes in ``_asked``."""
        return {name: getattr(self, name) for name in self._asked}

    @property
    def _figures(self) -> dict[str, float]:
        """The figures, by name: the attributes in ``_about``."""
        return {name: getattr(self, name) for name in self._about}

    def _dataset(self, only: Collection[str] | None = None, **points: Any) -> xarray.Dataset:
        """Return a dataset of all figures, and of the density of the velocity.

        Parameters
        ----------
        only : the density is left out unless it is None or names "vdf"; figures never are
        points : "speeds", in the unit of speeds, and "angles" to the field in radians, at which the
            density is evaluated. By default, or if None, `SPEEDS_SHOWN` and `ANGLES_SHOWN`; without
            a field one angle, as the density is the same at all
        """
        v = finite_line("speeds", self._speeds_shown(points.get("speeds")))
        phi = finite_line("angles", self._angles_shown(points.get("angles")))
        variables = {
            name: variable((), figure, *self._about[name]) for name, figure in self._figures.items()
        }
        unit_of_speed, unit_of_density = self._units
        if only is None or "vdf" in only:
            density = self.vdf(v, phi).T
            words = "density of the velocity"
            variables["vdf"] = variable(("angle", "v"), density, unit_of_density, words, "f")
        axes = {
            "v": variable(("v",), v, unit_of_speed, "speed"),
            "angle": variable(("angle",), phi, "rad", "angle to the field"),
        }
        arguments = {name: str(argument) for name, argument in self._arguments.items()}
        return dataset(self, self._title, arguments, variables, axes)

    def _speeds_shown(self, speeds: ArrayLike | None) -> ArrayLike:
        """Return the speeds of a dataset: those specified, or the usual ones."""
        if speeds is None:
            return SPEEDS_SHOWN * self._thermal_speed
        return speeds

    def _angles_shown(self, angles: ArrayLike | None) -> ArrayLike:
        """Return the angles of a dataset in radians: those specified, or the usual ones."""
        if angles is not None:
            return angles
        if self.drive.field:
            return ANGLES_SHOWN * np.pi
        return 0.0

    @property
    def _system(self) -> tuple[str, ...]:
        """What the title of a figure says: dilute scatterers are the only ones."""
        return system_items(self._arguments, "dilute", self.dimension)

    @property
    def _density_bottom(self) -> float:
        """The error of the density, over its largest value."""
        return max(self.rtol, MIN_ERROR_OF_DENSITY)

    @property
    def _title(self) -> str:
        """The class and the arguments that are not 0 or infinite, which are the defaults."""
        arguments = ", ".join(
            f"{name}={argument!r}"
            for name, argument in self._arguments.items()
            if name == "restitution" or argument not in (0.0, math.inf)
        )
        return f"{type(self).__name__}({arguments}), unit of length l"

    def __repr__(self) -> str:
        """Return three lines: the title, the figures and the message."""
        texts = self._texts_of_figures()
        figures = ", ".join(f"{name} = {text}" for name, text in texts.items())
        parts = (self._title, figures, f"{self.status.name.lower()}: {self.message}")
        return "\n  ".join(wrapped(part, "    ") for part in parts)

    def _texts_of_figures(self) -> dict[str, str]:
        """Return the figures as text, with the digits that their errors have.

        Those that may vanish have an error relative to what they are a part of.
        """
        scales = {"a2": 1.0, "drift": self._thermal_speed}
        texts = {}
        for name, figure in self._figures.items():
            scale = max(abs(figure), scales.get(name, 0.0))
            error = max(self.error_estimate, LEAST_ERROR_SHOWN) * scale
            texts[name] = number_text(figure, error)
        return texts

    def _table(self) -> Table:
        """Return what a notebook shows: the figures, with their units, and the status."""
        rows = [
            (name, text, self._about[name][0], self._about[name][1])
            for name, text in self._texts_of_figures().items()
        ]
        lines = (
            f"{self.status.name.lower()}: {self.message}",
            f"rtol = {self.rtol:g}, error estimate {self.error_estimate:.1e}",
        )
        title = f"{type(self).__name__}: {', '.join(self._system)}, unit of length l"
        return Table(title, ("", "value", "unit", "meaning"), rows, lines)
