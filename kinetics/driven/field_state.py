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
from kinetics.driven.driven_state import SteadyState
from kinetics.driven.generator import solved
from kinetics.driven.last_flights import SteadyDensity
from kinetics.driven.panels import Resolution
from kinetics.errors import ToleranceWarning
from kinetics.numerics import FloatArray, one_blas_thread
from kinetics.results.record import stored_class
from kinetics.results.result import Storable
from kinetics.validation import check_positive, check_rtol, finite_line, refuse, speeds


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
    _units = "sqrt(g l)", "(g l)^(-d/2)"

    @cached_property
    def law(self) -> CollisionLaw:
        """The collision law."""
        et = self.tangential_restitution
        return law_of(self.restitution, et, self.dimension, self.mass_ratio)

    def moment(self, p: float, m: int = 0) -> float:
        """<v^p cos(m phi)> in (g l)^(p/2), phi the angle to the field; in space <v^p P_m(cos phi)>.

        p is real, above -d and up to 20; above -d - 1 where m > 0 and no bounce stops the tracer.
        The error is about ``error_estimate`` for p from 0 to 4 and m up to 2. Raises InputError.
        """
        stops = math.isfinite(self.law.lowest_power)
        p, m = self._order(p, m, 0.0 if stops else 1.0)
        if p >= 0.0:
            return self._fine.average(p, m)
        if m == 1 and p > -2.0:  # row 0 of the equation, for v^(p + 1), is exact
            rate = self.law.mean_log_loss if p == -1.0 else self.law.decay_rate(p + 1.0) / (p + 1.0)
            return float(rate) * self._fine.average(p + 2.0, 0)
        return self._densities[1].moment(p, m)

    @one_blas_thread
    def vdf(self, v: ArrayLike, angle: ArrayLike) -> FloatArray:
        """The density of the velocity, shape (n_v, n_angle), in (g l)^(-d/2); its integral is 1.

        v : speeds in sqrt(g l), above 0; angle : to the field, in radians. InputError for others.

        What tracers bring along their last free flight. Its error, relative to the largest mean
        over directions, is below 300 rtol, but never asked to be below 1e-6 nor allowed above 1e-2;
        else a ToleranceWarning says so. At e = 0 the density grows as a logarithm towards the ray
        along the field, and is infinite on it.
        """
        v_, phi = speeds(v, zero_allowed=False), finite_line("angle", angle)
        along = np.outer(v_, np.cos(phi)).ravel()
        across = np.outer(v_, np.sin(phi)).ravel()
        coarse, fine = self._densities
        found = fine.density(along, across)
        order, few = np.argsort(np.abs(across)), 60  # the closest to the ray, and some of all
        seen = np.union1d(order[:few], order[:: 1 + order.size // few])
        with np.errstate(invalid="ignore"):
            unsure = np.abs(found[seen] - coarse.density(along[seen], across[seen]))
        allowed = float(np.clip(300.0 * self.rtol, 1e-6, 1e-2))
        missed = float(np.nanmax(unsure, initial=0.0) / fine.harmonics[0].max())
        if missed > allowed:
            text = f"vdf: the error estimate {missed:.1e} exceeds {allowed:.1e}, at low speeds or"
            warnings.warn(f"{text} close to the ray along the field", ToleranceWarning, 3)
        return found.reshape(v_.size, phi.size)

    @property
    def drive(self) -> Drive:
        """What drives the tracer."""
        return Drive(restitution=self.law, dimension=self.dimension, field=1.0)

    @cached_property
    def _densities(self) -> tuple[SteadyDensity, SteadyDensity]:
        """A coarser solution for the density, and a finer one."""
        first = Resolution.steady(self.rtol, self._resolution[2])
        return SteadyDensity(self.law, first), SteadyDensity(self.law, first.finer())

    def in_units(self, acceleration: float, diameter: float, number_density: float) -> FieldUnits:
        """The figures for a field g, grains and scatterers of diameter d, and their density.

        In any consistent units: with m/s^2, m and 1/m^3 (1/m^2 for disks) the results are in m and
        s. Raises InputError unless all are finite numbers above 0.
        """
        g, d = check_positive("acceleration", acceleration), check_positive("diameter", diameter)
        rho = check_positive("number_density", number_density)
        path = self.law.mean_free_path(rho, d)
        speed, time = math.sqrt(g * path), math.sqrt(path / g)
        if not 0.0 < speed * path < math.inf:
            refuse("number_density", rho, "with this diameter it is out of range")
        drift, root = self.drift * speed, math.sqrt(self.mean_square_speed) * speed
        spread = self.diffusion_parallel * speed * path, self.diffusion_perpendicular * speed * path
        return FieldUnits(path, time, drift, root, self.mean_speed / time, *spread)


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
    restitution: float | CollisionLaw, dimension: int = 2, tangential_restitution: float = 1.0,
    rtol: float = 1e-10, mass_ratio: float = math.inf,
) -> FieldState:  # fmt: skip
    """The steady state of a tracer among fixed scatterers in a uniform field, at low density.

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
    fine, error = solved(Drive(restitution=law, dimension=law.dimension, field=1.0), rtol)
    figures = np.insert(fine.figures[2:7], 1, fine.average(2.0, 0)).tolist()
    return FieldState._of(fine, error, rtol, figures, **law.arguments)
