"""solve_field and its answer: the steady state of a tracer in a uniform field."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from kinetics.collision import CollisionLaw, law_of
from kinetics.drive import Drive
from kinetics.driven.field_evolution import drive_of_unit_field
from kinetics.driven.resolution import PanelResolution
from kinetics.driven.steady_density import SteadyDensity
from kinetics.driven.steady_solution import solve_steady_until_converged
from kinetics.driven.steady_state import SteadyState
from kinetics.errors import ToleranceWarning
from kinetics.numerics import FloatArray, one_blas_thread
from kinetics.results.record import stored_class
from kinetics.results.result import Storable
from kinetics.validation import check_positive, check_rtol, finite_line, refuse, speeds

#: The error that the density may have over rtol. Chosen: a density needs more panels than averages
#: do; at half and at twice nothing moves at the default rtol, where `MIN_DENSITY_ERROR` holds.
DENSITY_ERROR_OVER_RTOL = 300.0
#: The least error that is asked of the density, over its largest mean over directions. Chosen.
MIN_DENSITY_ERROR = 1e-6
#: The largest error that passes without a warning. Chosen.
MAX_DENSITY_ERROR = 1e-2
#: So many velocities, those closest to the ray along the field, and about as many of all, are
#: compared with a coarser solution.
COMPARED_VELOCITIES = 60


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class FieldState(SteadyState):
    """The steady state in a uniform field, in the limit of low density; made by `solve_field`.

    Lengths in the mean free path l, accelerations in that of the field, g: so speeds are in
    sqrt(g l), times in sqrt(l/g), and diffusion coefficients in sqrt(g l^3). The field is along x.
    :meth:`in_units` gives the figures in one's own units.

    Attributes
    ----------
    restitution, tangential_restitution, dimension, rtol, mass_ratio : what was asked for
    drift : <v_x>, the percolation velocity, in sqrt(g l)
    mean_square_speed, mean_square_along : <v^2> and <v_x^2> in g l
    mean_speed : <v> in sqrt(g l): the number of collisions in a time sqrt(l/g)
    diffusion_parallel, diffusion_perpendicular : half the growth rate of the variance along the
        field, and in one direction across it, in sqrt(g l^3)
    error_estimate, status, message, plan, stats : see :class:`SteadyState`
    """

    tangential_restitution: float | None
    mean_square_speed: float
    mean_speed: float
    _about: ClassVar[Mapping[str, tuple[str, str]]] = {
        "drift": ("sqrt(g l)", "<v_x>, the percolation velocity"),
        "mean_square_speed": ("g l", "<v^2>"),
        "mean_square_along": ("g l", "<v_x^2>"),
        "mean_speed": ("sqrt(g l)", "<v>"),
        "diffusion_parallel": ("sqrt(g l^3)", "half the growth of the variance along the field"),
        "diffusion_perpendicular": ("sqrt(g l^3)", "the same in one direction across the field"),
    }
    _asked = ("restitution", "tangential_restitution", "dimension", "mass_ratio")
    _units = ("sqrt(g l)", "(g l)^(-d/2)")

    @cached_property
    def law(self) -> CollisionLaw:
        """The collision law."""
        return law_of(
            self.restitution, self.tangential_restitution, self.dimension, self.mass_ratio
        )

    @property
    def drive(self) -> Drive:
        """What drives the tracer."""
        return drive_of_unit_field(self.law)

    @property
    def _thermal_speed(self) -> float:
        return math.sqrt(self.mean_square_speed)

    def moment(self, p: float, m: int = 0) -> float:
        """Return <v^p cos(m phi)> in (g l)^(p/2), phi the angle to the field.

        In space it is <v^p P_m(cos phi)>.

        p is real, above -d and up to 20; above -d - 1 where m > 0 and no bounce stops the tracer.
        The error is about ``error_estimate`` for p from 0 to 4 and m up to 2. Raises InputError.
        """
        stops = math.isfinite(self.law.lowest_power)
        p, m = self._check_order(p, m, 0.0 if stops else 1.0)
        if p >= 0.0:
            return self._solution.average(p, m)
        if m == 1 and p > -2.0:  # row 0 of the equation, for v^(p + 1), is exact
            if p == -1.0:
                rate = self.law.mean_log_loss
            else:
                rate = float(self.law.decay_rate(p + 1.0)) / (p + 1.0)
            return rate * self._solution.average(p + 2.0, 0)
        return self._fine_density.moment(p, m)

    def vdf(self, v: ArrayLike, angle: ArrayLike | None = None) -> FloatArray:
        """Return the density of the velocity in (g l)^(-d/2), (n_v, n_angle) or that of v; its
        integral is 1.

        v : speeds in sqrt(g l), above 0; angle : to the field, in radians; without one the density
        is that along the field, in the shape of v. InputError for others.

        What tracers bring along their last free flight. Its error, relative to the largest mean
        over directions, is below 300 rtol, but never asked to be below 1e-6 nor allowed above 1e-2;
        else a ToleranceWarning says so. At e = 0 the density grows as a logarithm towards the ray
        along the field, and is infinite on it.
        """
        return super().vdf(v, angle)

    @one_blas_thread
    def _density_at(self, v: ArrayLike, angle: ArrayLike) -> FloatArray:
        """Return the density of the velocity, shape (n_v, n_angle)."""
        v_ = speeds(v, zero_allowed=False)
        phi = finite_line("angle", angle)
        along = np.outer(v_, np.cos(phi)).ravel()
        across = np.outer(v_, np.sin(phi)).ravel()
        density = self._fine_density.density(along, across)
        error = self._density_error(along, across, density)
        allowed = DENSITY_ERROR_OVER_RTOL * self.rtol
        allowed = float(np.clip(allowed, MIN_DENSITY_ERROR, MAX_DENSITY_ERROR))
        if error > allowed:
            warnings.warn(
                f"vdf: the error estimate {error:.1e} exceeds {allowed:.1e}, at low speeds or "
                "close to the ray along the field",
                ToleranceWarning,
                stacklevel=3,
            )
        return density.reshape(v_.size, phi.size)

    def _density_error(self, along: FloatArray, across: FloatArray, density: FloatArray) -> float:
        """Return the error of a density at velocities (n,), over the largest mean over directions.

        Some velocities are compared, those close to the ray along the field among them. Densities
        that are both infinite agree; what is not a number agrees with nothing.
        """
        by_distance = np.argsort(np.abs(across))
        closest = by_distance[:COMPARED_VELOCITIES]
        spread = by_distance[:: 1 + by_distance.size // COMPARED_VELOCITIES]
        compared = np.union1d(closest, spread)
        with np.errstate(invalid="ignore"):
            coarse = self._coarse_density.density(along[compared], across[compared])
            fine = density[compared]
            difference = np.where(fine == coarse, 0.0, np.abs(fine - coarse))
        largest = float(np.max(difference, initial=0.0))
        if math.isnan(largest):
            return math.inf
        return float(largest / self._fine_density.harmonics[0].max())

    @property
    def _density_resolution(self) -> PanelResolution:
        """The resolution of the coarse density."""
        return PanelResolution.steady(self.rtol, self._solution.resolution.harmonics)

    @cached_property
    def _coarse_density(self) -> SteadyDensity:
        """A solution for the density, to compare with."""
        return SteadyDensity(self.law, self._density_resolution)

    @cached_property
    def _fine_density(self) -> SteadyDensity:
        """The solution for the density."""
        return SteadyDensity(self.law, self._density_resolution.finer)

    def in_units(self, acceleration: float, diameter: float, number_density: float) -> FieldUnits:
        """Return the figures for a field g, grains and scatterers of diameter d, and their density.

        In any consistent units: with m/s^2, m and 1/m^3 (1/m^2 for disks) the results are in m and
        s. Raises InputError unless all are finite numbers above 0.
        """
        g = check_positive("acceleration", acceleration)
        d = check_positive("diameter", diameter)
        rho = check_positive("number_density", number_density)
        path = self.law.mean_free_path(rho, d)
        speed = math.sqrt(g * path)
        time = math.sqrt(path / g)
        if not 0.0 < speed * path < math.inf:
            refuse("number_density", rho, "with this diameter it is out of range")
        return FieldUnits(
            mean_free_path=path,
            time=time,
            drift=self.drift * speed,
            root_mean_square_speed=math.sqrt(self.mean_square_speed) * speed,
            collision_rate=self.mean_speed / time,
            diffusion_parallel=self.diffusion_parallel * speed * path,
            diffusion_perpendicular=self.diffusion_perpendicular * speed * path,
        )


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class FieldUnits(Storable):
    """The steady state in one's own units of length and time; made by `FieldState.in_units`."""

    mean_free_path: float
    time: float  # sqrt(l/g), in which the drift is reached
    drift: float  # the percolation velocity, along the field
    root_mean_square_speed: float
    collision_rate: float
    diffusion_parallel: float  # about the drift, length^2/time
    diffusion_perpendicular: float


@one_blas_thread
def solve_field(
    restitution: float | CollisionLaw,
    dimension: int = 2,
    tangential_restitution: float = 1.0,
    rtol: float = 1e-10,
    mass_ratio: float = math.inf,
) -> FieldState:
    """Return the steady state of a tracer among fixed scatterers in a uniform field.

    The density of scatterers is low.

    Parameters
    ----------
    restitution : e, 0 <= e < 1; or a :class:`kinetics.CollisionLaw`
    dimension : 2 (disks) or 3 (spheres)
    tangential_restitution : et in [0, 1]; 1 for smooth scatterers
    rtol : relative accuracy asked of the figures, 1e-14 to 0.1; 1e-12 is the best that there is
    mass_ratio : of a scatterer, at rest, over the tracer; inf for fixed scatterers

    Returns
    -------
    FieldState : drift, moments, density and dispersion, in units of g and the mean free path l

    Raises
    ------
    InputError (a ValueError) : an argument out of range, an elastic law, one that gains energy

    >>> state = solve_field(restitution=0.7)
    >>> round(state.drift, 9), state.status.name
    (0.50192612, 'CONVERGED')
    """
    rtol = check_rtol(rtol)
    law = law_of(restitution, tangential_restitution, dimension, mass_ratio)
    if law.is_elastic:
        allowed = "it must be below 1: elastic tracers keep their energy, and reach no steady state"
        refuse("restitution", restitution, allowed)
    solution, error = solve_steady_until_converged(drive_of_unit_field(law), rtol)
    figures = solution.figures
    return FieldState._of(
        solution,
        error,
        rtol,
        drift=figures.drift,
        mean_square_speed=solution.average(2.0, 0),
        mean_square_along=figures.mean_square_along,
        mean_speed=figures.collision_rate,  # in a unit of time, as the mean free path is 1
        diffusion_parallel=figures.diffusion_parallel,
        diffusion_perpendicular=figures.diffusion_perpendicular,
        **law.arguments,
    )
