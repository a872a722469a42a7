"""What the answers of `solve_steady` and `kinetics.solve_field` share."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import astuple, dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from kinetics.drive import Drive
from kinetics.driven.resolution import ChebyshevResolution
from kinetics.driven.steady_solution import SteadySolution
from kinetics.errors import PlanStep, SolverStatus, judge_errors
from kinetics.numerics import FloatArray
from kinetics.outputs import AVERAGES
from kinetics.results.frame import dataset, variable
from kinetics.results.result import Result
from kinetics.validation import finite_line, real_number, whole_number

if TYPE_CHECKING:
    import xarray

#: Highest power of the speed of a moment that may be asked for.
MAX_POWER = 20.0
#: Speeds of a dataset over the thermal one, unless others are given.
SPEEDS_SHOWN = np.linspace(0.025, 4.0, 160)
#: Angles to the field of a dataset, unless others are given, in pi.
ANGLES_SHOWN = np.array([0.0, 0.5, 1.0])


@dataclass(frozen=True, eq=False, repr=False)
class SteadyState(Result):
    """What the answers of `solve_steady` and `kinetics.solve_field` share.

    Attributes
    ----------
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

    _points = ("speeds", "angles")
    _on_demand = ("vdf",)
    #: The figures: name -> unit, and words.
    _about: ClassVar[Mapping[str, tuple[str, str]]]
    #: The names of the arguments of the question.
    _asked: ClassVar[tuple[str, ...]]
    #: The units of a speed, and of the density.
    _units: ClassVar[tuple[str, str]]

    @classmethod
    def _of(cls, solution: SteadySolution, error: float, rtol: float, **parts: Any) -> Self:
        """Return the state of a solution and its error; `parts` are its other fields."""
        status, message = judge_errors({AVERAGES: error}, {AVERAGES: rtol})
        resolution = solution.resolution
        highest = solution.axis.highest
        state = cls(
            **parts,
            rtol=rtol,
            error_estimate=error,
            status=status,
            message=message,
            plan=(
                PlanStep("angular harmonics", True, f"0 to {resolution.harmonics}"),
                PlanStep("speeds", True, f"{resolution.nodes} points up to {highest:.3g}"),
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
        """What drives the tracer."""
        raise NotImplementedError

    @property
    def _thermal_speed(self) -> float:
        """sqrt(<v^2>)."""
        raise NotImplementedError

    def vdf(self, v: ArrayLike, angle: ArrayLike) -> FloatArray:
        """Return the density of the velocity, shape (n_v, n_angle); its integral is 1."""
        raise NotImplementedError

    @property
    def _solution(self) -> SteadySolution:
        """The solution; where it was not kept, it is solved again."""
        if self._kept is None:
            resolution = ChebyshevResolution(*self._resolution)
            self.store(_kept=SteadySolution(self.drive, resolution))
        solution = self._kept
        assert solution is not None
        return solution

    def __getstate__(self) -> dict[str, Any]:
        return super().__getstate__() | {"_kept": None}

    def _check_order(self, p: float, m: int, below: float = 0.0) -> tuple[float, int]:
        """Return the arguments of `moment`, or raise InputError.

        below : how far below -d p may be where m > 0
        """
        m = whole_number("m", m, 0, self._solution.resolution.harmonics)
        lowest = -self.dimension - (below if m else 0.0)
        allowed = f"for m = {m} it must be above {lowest:g}, and at most {MAX_POWER:g}"
        return real_number("p", p, math.nextafter(lowest, 0.0), MAX_POWER, allowed), m

    @property
    def _arguments(self) -> dict[str, Any]:
        """The arguments of the question, by name."""
        return {name: getattr(self, name) for name in self._asked}

    @property
    def _figures(self) -> dict[str, float]:
        """The figures, by name."""
        return {name: getattr(self, name) for name in self._about}

    def _dataset(self, only: Collection[str] | None = None, **points: Any) -> xarray.Dataset:
        """Return a dataset; points are speeds, and angles to the field in radians."""
        v = finite_line("speeds", points.get("speeds", SPEEDS_SHOWN * self._thermal_speed))
        usual_angles = ANGLES_SHOWN * np.pi if self.drive.field else 0.0
        phi = finite_line("angles", points.get("angles", usual_angles))
        shown = {
            name: variable((), figure, *self._about[name]) for name, figure in self._figures.items()
        }
        unit_of_speed, unit_of_density = self._units
        if only is None or "vdf" in only:
            density = self.vdf(v, phi).T
            words = "density of the velocity"
            shown["vdf"] = variable(("angle", "v"), density, unit_of_density, words, "f")
        axes = {
            "v": variable(("v",), v, unit_of_speed, "speed"),
            "angle": variable(("angle",), phi, "rad", "angle to the field"),
        }
        arguments = {name: str(argument) for name, argument in self._arguments.items()}
        title = repr(self).split("\n")[0]
        return dataset(self, title, arguments, shown, axes)

    def __repr__(self) -> str:
        arguments = ", ".join(
            f"{name}={argument!r}"
            for name, argument in self._arguments.items()
            if name == "restitution" or argument not in (0.0, math.inf)
        )
        figures = ", ".join(f"{name} = {figure:.10g}" for name, figure in self._figures.items())
        head = f"{type(self).__name__}({arguments}), unit of length l"
        return f"{head}\n  {figures}\n  {self.message}"
