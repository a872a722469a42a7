"""`solve_steady` and its answer: the steady state of a driven tracer."""

from __future__ import annotations

import math
import threading
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from kinetics.drive import DRIVES, Drive
from kinetics.driven.harmonics import sum_over_harmonics
from kinetics.driven.heated import HeatedDensity, log_moment
from kinetics.driven.over_time import MIN_ERROR_OF_DENSITY
from kinetics.driven.resolution import ChebyshevResolution
from kinetics.driven.speed_range import takes_energy
from kinetics.driven.steady_solution import (
    MIN_RATIO_OF_STEADY_STATE,
    SteadySolution,
    solve_steady_until_converged,
)
from kinetics.driven.steady_state import SteadyState
from kinetics.errors import InputError, warn_missed
from kinetics.numerics import FloatArray, one_blas_thread
from kinetics.numerics.refinement import RefinementRules, refine_until_converged
from kinetics.results.record import stored_class
from kinetics.validation import check_rtol, finite_line, real_number, refuse, speeds, whole_number

#: Most relaxation rates that are given: higher ones are less accurate.
MAX_RATES = 20
#: A rate is of a disturbance that decays alone if it is below the lowest rate of collisions by this
#: fraction, where the continuous spectrum begins. Measured on eight drives: at half and at twice
#: the same rates are found.
SPECTRUM_MARGIN = 1e-3


class SolutionsOfDrive:
    """The solutions of one drive, by their resolution; safe on threads.

    There is one for each finer resolution: nodes grow by a fifth, up to `MAX_AXIS_NODES`, so that
    there are a dozen at most.
    """

    def __init__(self, solution: SteadySolution) -> None:
        self._drive = solution.drive
        self._solutions = {solution.resolution: solution}
        self._lock = threading.Lock()

    def at(self, resolution: ChebyshevResolution) -> SteadySolution:
        """Return the solution at a resolution; it is solved at first use."""
        with self._lock:
            if resolution not in self._solutions:
                self._solutions[resolution] = SteadySolution(self._drive, resolution)
            return self._solutions[resolution]


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
    # Speeds have no unit.
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
    _units = ("1", "1")

    @property
    def mean_square_speed(self) -> float:
        """<v^2>."""
        return self.thermal_speed**2

    @property
    def _thermal_speed(self) -> float:
        return math.sqrt(self.mean_square_speed)

    @property
    def diffusion_coefficient(self) -> float:
        """D, half the growth rate of the variance in one direction, averaged over directions."""
        d = self.dimension
        return (self.diffusion_parallel + (d - 1.0) * self.diffusion_perpendicular) / d

    @property
    def drive(self) -> Drive:
        """What drives the tracer."""
        return Drive.checked(**self._arguments)

    # -- moments ----------------------------------------------------------------------------------

    def moment(self, p: float, m: int = 0) -> float:
        """Return <v^p cos(m phi)>, phi the angle to the field; in space <v^p P_m(cos phi)>.

        p is real, above -d and up to 20. The error is about ``error_estimate`` for whole p from 0
        to 4, up to 1e-4 for others of 0 or more, and below 0 as that of the density. In a bath
        powers that bend at rest (an odd p for m = 0) are refined until two solutions agree within
        ``rtol``, or a ToleranceWarning says that they do not. Raises InputError for p or m out of
        range.
        """
        p, m = self._check_order(p, m)
        law = self.drive.law
        if m == 0 and law is not None and self.drive.only_heats:
            return float(self._noise_speed**p * np.exp(log_moment(law, np.array([p]))[0].real))
        if p < 0.0:
            return self._solution_with_density("moment").average(p, m)
        if self._solution.is_resolved(p, m):
            return self._solution.average(p, m)
        return self._refined_moment(p, m)

    @property
    def _noise_speed(self) -> float:
        """(D_v l)^(1/3), the unit of speed where noise alone drives."""
        return float(self.heating ** (1.0 / 3.0))

    def _refined_moment(self, p: float, m: int) -> float:
        """Return a moment of a power that bends at rest, from as fine a solution as it needs."""

        def difference(fine: SteadySolution, coarse: SteadySolution) -> dict[str, float]:
            return {"moment": fine.moment_difference(coarse, p, m)}

        tolerance = max(self.rtol, self.error_estimate)
        solution, errors = refine_until_converged(
            solve=self._solutions.at,
            resolution=self._solution.resolution,
            difference=difference,
            tolerance={"moment": tolerance},
            rules=RefinementRules(min_ratio_to_previous=MIN_RATIO_OF_STEADY_STATE),
        )
        if errors["moment"] > tolerance:
            warn_missed("moment", errors["moment"], tolerance)
        return solution.average(p, m)

    @cached_property
    def _solutions(self) -> SolutionsOfDrive:
        """Solutions for moments that need a finer one."""
        return SolutionsOfDrive(self._solution)

    # -- the density ------------------------------------------------------------------------------

    def vdf(self, v: ArrayLike, angle: ArrayLike | None = None) -> FloatArray:
        """Return the density of the velocity, its integral is 1.

        v : speeds; angle : to the field, in radians, for the shape (n_v, n_angle); without one the
        density is that along the field, if there is one, in the shape of v. Raises InputError for
        others. If noise alone
        drives, it is a closed form, to some 1e-12 of itself. Else its error is below rtol, or 1e-4,
        of the maximum, or a ToleranceWarning says so; but in space it is up to 1e-2 below a tenth
        of the thermal speed, and without noise or bath more in the direction of the field.
        """
        return super().vdf(v, angle)

    def _density_at(self, v: ArrayLike, angle: ArrayLike) -> FloatArray:
        """Return the density of the velocity, shape (n_v, n_angle)."""
        v_ = speeds(v)
        phi = finite_line("angle", angle)
        if self._heated_density is not None:
            unit = self._noise_speed
            density = self._heated_density.at(v_ / unit) / unit**self.dimension
            return np.repeat(density[:, None], phi.size, axis=1)
        solution = self._solution_with_density("vdf")
        harmonics = solution.axis.density(solution.sums, v_, self.dimension)
        return sum_over_harmonics(harmonics, phi, self.dimension)

    @cached_property
    def _heated_density(self) -> HeatedDensity | None:
        """The density in closed form; None unless noise alone drives."""
        law = self.drive.law
        if law is None or not self.drive.only_heats:
            return None
        return HeatedDensity(law)

    def _solution_with_density(self, name: str) -> SteadySolution:
        """Return a solution whose density has its accuracy, or the best; then it warns each time.

        name : of what is asked for, in the warning
        """
        solution, error = self._density_solution
        tolerance = max(self.rtol, MIN_ERROR_OF_DENSITY)
        if error > tolerance:
            warn_missed(name, error, tolerance)
        return solution

    @cached_property
    def _density_solution(self) -> tuple[SteadySolution, float]:
        """A solution whose density has its accuracy, and the error of that."""
        tolerance = max(self.rtol, MIN_ERROR_OF_DENSITY)
        solution, error = solve_steady_until_converged(
            self.drive, tolerance, SteadySolution.difference_of_densities
        )
        if solution.resolution.nodes <= self._solution.resolution.nodes:
            solution = self._solution
        if self.field and self.bath_speed:
            error = max(error, solution.difference_over_angles())
        return solution, error

    # -- sticking and relaxation ------------------------------------------------------------------

    def capture_from(self, speed: float = 0.0) -> tuple[float, float, float]:
        """Return mean distance along the field, time and collisions until such tracers stick.

        They start with this speed, in all directions alike. Raises InputError where nothing sticks.
        """
        if not self.capture_speed:
            refuse("capture_speed", self.capture_speed, "it must be above 0: no impact sticks")
        speed = real_number("speed", speed, 0.0)
        solution = self._solution
        start = np.zeros_like(solution.sums)
        start[0] = solution.axis.interpolation(np.array([speed]))[0]
        spent = solution.spent(start)
        distance = float(spent[1] @ solution.axis.speeds)
        collisions = float(spent[0] @ solution.generator.rate)
        return distance, float(spent[0].sum()), collisions

    def relaxation_rates(self, n: int = 1, m: int = 0) -> FloatArray:
        """Return the n lowest rates with which disturbances of harmonic m decay, rising, (n,).

        m = 0 is the energy, m = 1 the momentum. In a bath there are few below the lowest collision
        rate, where the continuous spectrum begins: the others are NaN. Raises InputError for a
        state in a field.
        """
        if self.field:
            refuse("field", self.field, "relaxation rates are available without a field")
        n = whole_number("n", n, 1, MAX_RATES)
        m = whole_number("m", m, 0, self._solution.resolution.harmonics)
        generator = self._solution.generator
        rates = np.sort(-np.linalg.eigvals(generator.matrices[m]).real)
        has_steady_state = m == 0 and not self.capture_speed
        if has_steady_state:
            rates = rates[1:]
        if not self.heating:
            rates = rates[rates < (1.0 - SPECTRUM_MARGIN) * generator.rate.min()]
        lowest = np.full(n, math.nan)
        lowest[: rates[:n].size] = rates[:n]
        return lowest


@one_blas_thread
def solve_steady(
    restitution: Any,
    dimension: int = 2,
    bath_speed: float = 0.0,
    mass_ratio: float = math.inf,
    heating: float = 0.0,
    drag: float = 0.0,
    field: float = 0.0,
    capture_speed: float = 0.0,
    rtol: float = 1e-10,
) -> DrivenState:
    """Return the steady state of a tracer that a bath, noise or a field keeps moving.

    The density of scatterers is low.

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
    solution, error = solve_steady_until_converged(drive, rtol)
    sticks = bool(drive.capture_speed)
    return DrivenState._of(
        solution,
        error,
        rtol,
        **asdict(solution.figures),
        **{name: getattr(drive, name) for name in DrivenState._asked},
        capture_time=1.0 / solution.decay if sticks else math.inf,
        capture_depth=solution.depth if sticks and field else math.inf,
    )
