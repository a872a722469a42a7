"""`solve_steady` and its answer: the steady state of a driven tracer."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import astuple, dataclass, field
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from kinetics.drive import DRIVES, Drive
from kinetics.driven.field_answer import BEST_DENSITY
from kinetics.driven.generator import Resolution, Steady, solved
from kinetics.driven.harmonics import angular, norms
from kinetics.driven.heated import Line, density, log_moment
from kinetics.driven.speed_range import takes_energy
from kinetics.errors import InputError, PlanStep, SolverStatus, judge_errors, warn_missed
from kinetics.numerics import FloatArray, one_blas_thread
from kinetics.numerics.refinement import RefinementRules, refine_until_converged
from kinetics.results.frame import dataset, variable
from kinetics.results.record import stored_class
from kinetics.results.result import Result
from kinetics.validation import check_rtol, finite_line, real_number, refuse, speeds, whole_number


@dataclass(frozen=True, eq=False, repr=False)
class SteadyState(Result):
    """What the answers of `solve_steady` and `kinetics.solve_field` share.

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
    _resolution: tuple[int, int, int, float]

    _points, _on_demand = ("speeds", "angles"), ("vdf",)
    _about: ClassVar[Mapping[str, tuple[str, str]]]  # figures -> unit, and words
    _asked: ClassVar[tuple[str, ...]]
    _units: ClassVar[tuple[str, str]]  # of a speed, and of the density

    @classmethod
    def _of(cls: Any, fine: Steady, error: float, rtol: float, figures: Any, **asked: Any) -> Any:
        """From a solution and its error."""
        status, message = judge_errors({"averages": error}, {"averages": rtol})
        one, top = fine.resolution, fine.axis.highest
        plan = (
            PlanStep("angular harmonics", True, f"0 to {one.harmonics}"),
            PlanStep("speeds", True, f"{one.nodes} points up to {top:.3g}"),
            PlanStep("dispersion", not fine.decay, "the linear response to the velocity"),
        )
        stats = {"harmonics": one.harmonics, "nodes": one.nodes, "highest_speed": top}
        state = cls(
            **asked, **dict(zip(cls._about, figures, strict=True)), rtol=rtol, error_estimate=error,
            status=status, message=message, plan=plan, stats=stats, _resolution=astuple(one),
        )  # fmt: skip
        state.__dict__["_fine"] = fine  # as if asked for
        return state

    @cached_property
    def _fine(self: Any) -> Steady:
        """Where it was not kept, as in a loaded or pickled state, it is solved again."""
        return Steady(self.drive, Resolution(*self._resolution))

    def _order(self, p: float, m: int, below: float = 0.0) -> tuple[float, int]:
        """The arguments of `moment`, checked; below : how far below -d p may be where m > 0."""
        m = whole_number("m", m, 0, self._fine.resolution.harmonics)
        lowest = -self.dimension - (below if m else 0.0)
        allowed = f"for m = {m} it must be above {lowest:g}, and at most 20"
        return real_number("p", p, math.nextafter(lowest, 0.0), 20.0, allowed), m

    def _dataset(self: Any, only: Collection[str] | None = None, **points: Any) -> Any:
        """Points: speeds, and angles to the field in radians."""
        scale = math.sqrt(self.mean_square_speed)
        v = finite_line("speeds", points.get("speeds", np.linspace(0.025, 4.0, 160) * scale))
        some = np.array([0.0, 0.5, 1.0]) * np.pi if self.drive.field else 0.0
        phi = finite_line("angles", points.get("angles", some))
        shown = {n: variable((), getattr(self, n), *about) for n, about in self._about.items()}
        if only is None or "vdf" in only:
            f, words = self.vdf(v, phi).T, "density of the velocity"
            shown["vdf"] = variable(("angle", "v"), f, self._units[1], words, "f")
        axes = {"v": variable(("v",), v, self._units[0], "speed")}
        axes |= {"angle": variable(("angle",), phi, "rad", "angle to the field")}
        asked = {name: str(getattr(self, name)) for name in self._asked}
        return dataset(self, repr(self).split("\n")[0], asked, shown, axes)

    def __repr__(self: Any) -> str:
        asked = {name: getattr(self, name) for name in self._asked}
        given = {n: v for n, v in asked.items() if n == "restitution" or v not in (0.0, math.inf)}
        shown = ", ".join(f"{n}={v!r}" for n, v in given.items())
        figures = ", ".join(f"{name} = {getattr(self, name):.10g}" for name in self._about)
        return f"{type(self).__name__}({shown}), unit of length l\n  {figures}\n  {self.message}"


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class DrivenState(SteadyState):
    """The steady state of a driven tracer, in the limit of low density; made by `solve_steady`.

    Lengths are in the mean free path l; the unit of speed is that of the arguments, and times are
    in l over it. Where slow impacts stick, averages are over the tracers that still move, after a
    long time.

    Attributes
    ----------
    restitution, dimension, bath_speed, mass_ratio, heating, drag, field, capture_speed, rtol : what
        was asked for
    thermal_speed : sqrt(<v^2>)
    a2 : d <v^4>/((d + 2) <v^2>^2) - 1
    drift : <v_x>, along the field
    mean_square_along : <v_x^2>
    collision_rate : collisions in a unit of time
    diffusion_parallel, diffusion_perpendicular : half the growth rate of the variance along the
        field and across it, the same without a field; NaN where tracers stick
    mobility : what a small further field adds to the drift, over that field; NaN where they stick
    capture_time, capture_depth : of tracers that stick, the time T and, in a field, the distance Z
        in which the number of those that still move falls by a factor e; else infinite
    error_estimate, status, message, plan, stats : see :class:`SteadyState`
    """

    bath_speed: float
    heating: float
    drag: float
    field: float
    capture_speed: float
    thermal_speed: float
    a2: float
    collision_rate: float
    mobility: float
    capture_time: float
    capture_depth: float
    # speeds have no unit
    _about: ClassVar[Mapping[str, tuple[str, str]]] = {
        "thermal_speed": ("1", "sqrt(<v^2>)"),
        "a2": ("1", "d <v^4>/((d + 2) <v^2>^2) - 1"),
        "drift": ("1", "<v_x>, along the field"),
        "mean_square_along": ("1", "<v_x^2>"),
        "collision_rate": ("1/l", "collisions in a unit of time"),
        "diffusion_parallel": ("l", "half the growth of the variance along the field"),
        "diffusion_perpendicular": ("l", "the same in one direction across the field"),
        "mobility": ("l", "what a small further field adds to the drift, over that field"),
    }
    _asked = (*DRIVES, "field", "restitution", "dimension", "mass_ratio")
    _units = "1", "1"

    @property
    def mean_square_speed(self) -> float:
        """<v^2>."""
        return self.thermal_speed**2

    @property
    def diffusion_coefficient(self) -> float:
        """D, half the growth rate of the variance in one direction, averaged over directions."""
        d = self.dimension
        return (self.diffusion_parallel + (d - 1.0) * self.diffusion_perpendicular) / d

    @property
    def drive(self) -> Drive:
        """What drives the tracer."""
        return Drive.checked(**{name: getattr(self, name) for name in self._asked})

    def moment(self, p: float, m: int = 0) -> float:
        """<v^p cos(m phi)>, phi the angle to the field; in space <v^p P_m(cos phi)>.

        p is real, above -d and up to 20. The error is about ``error_estimate`` for whole p from 0
        to 4, up to 1e-4 for others of 0 or more, and below 0 as that of the density. In a bath
        powers that bend at rest (an odd p for m = 0) are refined until two solutions agree within
        ``rtol``, or a ToleranceWarning says that they do not. Raises InputError for p or m out of
        range.
        """
        p, m = self._order(p, m)
        law = self.drive.law
        if m == 0 and law is not None and self.drive.only_heats:
            unit = self.heating ** (1.0 / 3.0)
            return float(unit**p * np.exp(log_moment(law, np.array([p]))[0].real))
        if p < 0.0:
            return self._with_density("moment").average(p, m)
        if self._fine.is_resolved(p, m):
            return self._fine.average(p, m)
        return self._refined_moment(p, m)

    def _refined_moment(self, p: float, m: int) -> float:
        """A moment of a power that bends at rest, from as fine a solution as it needs."""

        def solve(resolution: Resolution) -> Steady:
            if resolution not in self._finer:
                self._finer[resolution] = Steady(self.drive, resolution)
            return self._finer[resolution]

        def difference(fine: Steady, coarse: Steady) -> dict[str, float]:
            return {"moment": fine.moment_difference(coarse, p, m)}

        first = self._fine.resolution
        tolerance = max(self.rtol, self.error_estimate)
        rules = RefinementRules(min_ratio_to_previous=0.01)
        solution, errors = refine_until_converged(
            solve, first, difference, {"moment": tolerance}, rules
        )
        if errors["moment"] > tolerance:
            warn_missed("moment", errors["moment"], tolerance)
        return solution.average(p, m)

    @cached_property
    def _finer(self) -> dict[Resolution, Steady]:
        """Solutions by their resolution, for moments that need a finer one."""
        return {self._fine.resolution: self._fine}

    def vdf(self, v: ArrayLike, angle: ArrayLike = 0.0) -> FloatArray:
        """The density of the velocity, shape (n_v, n_angle); its integral is 1.

        v : speeds; angle : to the field, in radians. Raises InputError for others. If noise alone
        drives, it is a closed form, to some 1e-12 of itself. Else its error is below rtol, or 1e-4,
        of the maximum, or a ToleranceWarning says so; but in space it is up to 1e-2 below a tenth
        of the thermal speed, and without noise or bath more in the direction of the field.
        """
        v_, phi = speeds(v), finite_line("angle", angle)
        law, d = self.drive.law, self.dimension
        if law is not None and self.drive.only_heats:
            unit = self.heating ** (1.0 / 3.0)
            f = density(law, v_ / unit, self._lines) / unit**d
            return np.repeat(f[:, None], phi.size, axis=1)
        one = self._with_density("vdf")
        return angular_sum(one.axis.density(one.sums, v_, d), phi, d)

    def _with_density(self, what: str) -> Steady:
        """A solution whose density has its accuracy, or the best; then it warns, every time."""
        one, error = self._dense
        if error > (most := max(self.rtol, BEST_DENSITY)):
            warn_missed(what, error, most)
        return one

    @cached_property
    def _dense(self) -> tuple[Steady, float]:
        most = max(self.rtol, BEST_DENSITY)
        one, error = solved(self.drive, most, Steady.densities_apart)
        return max(self._fine, one, key=lambda each: each.resolution.nodes), error

    @cached_property
    def _lines(self) -> list[Line]:
        return []

    def capture_from(self, speed: float = 0.0) -> tuple[float, float, float]:
        """Mean distance along the field, time and collisions until tracers of this speed stick.

        They start in all directions alike. Raises InputError where nothing sticks.
        """
        if not self.capture_speed:
            refuse("capture_speed", self.capture_speed, "it must be above 0: no impact sticks")
        speed = real_number("speed", speed, 0.0)
        one = self._fine
        start = np.zeros_like(one.sums)
        start[0] = one.axis.interpolation(np.array([speed]))[0]
        spent = one.solver.solve(start)
        depth = float(spent[1] @ one.axis.speeds)
        return depth, float(spent[0].sum()), float(spent[0] @ one.generator.rate)

    def relaxation_rates(self, n: int = 1, m: int = 0) -> FloatArray:
        """The n lowest rates with which disturbances of harmonic m decay, rising, shape (n,).

        m = 0 is the energy, m = 1 the momentum. In a bath there are few below the lowest collision
        rate, where the continuous spectrum begins: the others are NaN. Raises InputError for a
        state in a field.
        """
        if self.field:
            refuse("field", self.field, "relaxation rates are available without a field")
        n = whole_number("n", n, 1, 20)
        m = whole_number("m", m, 0, self._fine.resolution.harmonics)
        one = self._fine.generator
        found = np.sort(-np.linalg.eigvals(one.matrices[m]).real)
        found = found[1:] if m == 0 and not self.capture_speed else found
        if not self.heating:
            found = found[found < (1.0 - 1e-3) * one.rate.min()]
        out = np.full(n, math.nan)
        out[: found[:n].size] = found[:n]
        return out


def angular_sum(f: FloatArray, angle: FloatArray, dimension: int) -> FloatArray:
    """The density at angles, (n_v, n_angle), of harmonics (M + 1, n_v) as averages have them."""
    tables = angular(np.cos(angle), np.sin(angle), max(len(f), 2), dimension, 1)[0][: len(f)]
    return np.asarray(f.T @ (tables / norms(len(f), dimension)[0]))


@one_blas_thread
def solve_steady(
    restitution: Any, dimension: int = 2, bath_speed: float = 0.0, mass_ratio: float = math.inf,
    heating: float = 0.0, drag: float = 0.0, field: float = 0.0, capture_speed: float = 0.0,
    rtol: float = 1e-10,
) -> DrivenState:  # fmt: skip
    """The steady state of a tracer that a bath, noise or a field keeps moving, at low density.

    Parameters
    ----------
    restitution : e in [0, 1]; or a function of the normal impact speed: `kinetics.Viscoelastic`, a
        Python function of an array, or a table (impact speeds, values)
    dimension : 2 (disks) or 3 (spheres); smooth ones
    bath_speed : w, the standard deviation of each component of the scatterers' velocities
    mass_ratio : of a scatterer over the tracer; inf for infinitely heavy ones
    heating : D_v of white noise, <dv_i dv_j> = 2 D_v delta_ij dt
    drag : gamma, in dv/dt = -gamma v
    field : a uniform acceleration along x
    capture_speed : v_c; impacts whose normal speed is below it stick
    rtol : relative accuracy asked of the figures, 1e-14 to 0.1; 1e-12 is the best that there is

    Lengths are in the mean free path l; speeds in any unit, times in l over it.

    Returns
    -------
    DrivenState : moments, density, diffusion, mobility and relaxation

    Raises
    ------
    InputError (a ValueError) : an argument out of range, or a system without a steady state, as
        nothing gives it energy, or nothing takes it

    >>> state = solve_steady(restitution=0.5, bath_speed=1.0)  # <v_x^2> = w^2 (1 + e)/(1 - e)
    >>> round(state.mean_square_along, 9), state.status.name
    (3.0, 'CONVERGED')
    """
    rtol = check_rtol(rtol)
    drive = Drive.checked(
        restitution=restitution,
        dimension=dimension,
        mass_ratio=mass_ratio,
        bath_speed=bath_speed,
        heating=heating,
        drag=drag,
        field=field,
        capture_speed=capture_speed,
    ).per_path(1.0)
    if not drive.is_driven:
        raise InputError(
            "bath_speed: got 0; without bath_speed, heating or field tracers cool for ever, and "
            "reach no steady state: see solve_scaled"
        )
    if not takes_energy(drive):
        allowed = "collisions take no energy, and drag is 0: no steady state is reached"
        refuse("restitution", restitution, allowed)
    fine, error = solved(drive, rtol)
    sticks = bool(drive.capture_speed)
    return DrivenState._of(
        fine, error, rtol, fine.figures.tolist(),
        **{name: getattr(drive, name) for name in DrivenState._asked},
        capture_time=1.0 / fine.decay if sticks else math.inf,
        capture_depth=fine.depth if sticks and field else math.inf,
    )  # fmt: skip
