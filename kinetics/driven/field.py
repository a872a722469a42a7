"""solve_field and its answer: the steady state of a tracer in a uniform field."""

from __future__ import annotations

import math
import warnings
from collections.abc import Collection, Mapping
from dataclasses import astuple, dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kinetics.collision import CollisionLaw, law_of
from kinetics.driven.generator import Resolution
from kinetics.driven.steady import Steady, refined, velocity_dataset
from kinetics.driven.system import System
from kinetics.errors import PlanStep, SolverStatus, ToleranceWarning, judged
from kinetics.field.steady import SteadyDensity, densities
from kinetics.numerics import FloatArray, one_blas_thread
from kinetics.results import Result, Value
from kinetics.validation import (
    check_positive,
    check_rtol,
    finite_line,
    real_number,
    refuse,
    speeds,
    whole_number,
)

_HIGHEST_POWER = 20.0
_BEST_DENSITY, _WORST_DENSITY = 1e-6, 1e-2
_DENSITY_RATIO = 300.0  # a resolution that is enough for averages leaves more of the density
_LOOKED_AT = 60  # velocities of which the error of the density is found, and as many again
_SPEEDS = np.linspace(0.0, 4.0, 161)[1:]
_ANGLES = np.array([0.0, 0.5, 1.0]) * np.pi
_FIGURES = {
    "drift": ("sqrt(g l)", "<v_x>, the percolation velocity"),
    "mean_square_speed": ("g l", "<v^2>"),
    "mean_square_along": ("g l", "<v_x^2>"),
    "mean_speed": ("sqrt(g l)", "<v>"),
    "diffusion_parallel": ("sqrt(g l^3)", "half the growth of the variance along the field"),
    "diffusion_perpendicular": ("sqrt(g l^3)", "the same in one direction across the field"),
}
"""Figures -> unit and words."""


@dataclass(frozen=True)
class FieldState(Result):
    """The steady state in a uniform field, in the limit of low density; made by `solve_field`.

    Lengths in the mean free path l, accelerations in that of the field, g: so speeds are in
    sqrt(g l), times in sqrt(l/g), and diffusion coefficients in sqrt(g l^3). The field is along x.
    :meth:`in_units` gives the figures in one's own units.

    Attributes
    ----------
    restitution, tangential_restitution, dimension, rtol, mass_ratio : what was asked for
    drift : <v_x>, the percolation velocity, in sqrt(g l)
    mean_square_speed : <v^2> in g l
    mean_square_along : <v_x^2> in g l
    mean_speed : <v> in sqrt(g l): the number of collisions in a time sqrt(l/g)
    diffusion_parallel : half the growth rate of the variance along the field, in sqrt(g l^3)
    diffusion_perpendicular : the same for one direction across the field
    error_estimate : relative error of these figures
    status : SolverStatus
    message : the status in words: what misses its tolerance, by how much, and what to change
    plan : harmonics and panels that were used, and why
    stats : numbers about the work
    """

    restitution: Any
    tangential_restitution: float | None
    dimension: int
    rtol: float
    drift: float
    mean_square_speed: float
    mean_square_along: float
    mean_speed: float
    diffusion_parallel: float
    diffusion_perpendicular: float
    error_estimate: float
    status: SolverStatus
    message: str
    plan: tuple[PlanStep, ...]
    stats: Mapping[str, Any]
    _resolution: tuple[int, int, int, float] = field(repr=False)
    mass_ratio: float = math.inf

    @cached_property
    def law(self) -> CollisionLaw:
        """The collision law."""
        et = self.tangential_restitution
        return law_of(self.restitution, et, self.dimension, self.mass_ratio)

    # -- averages ---------------------------------------------------------------------------------

    def moment(self, p: float, m: int = 0) -> float:
        """<v^p cos(m phi)> in (g l)^(p/2), phi the angle to the field; in space <v^p P_m(cos phi)>.

        p is real, above -d and up to 20; above -d - 1 where m > 0 and no bounce stops the tracer.
        The error is about ``error_estimate`` for p from 0 to 4 and m up to 2. Raises InputError.
        """
        m = whole_number("m", m, 0, self._fine.resolution.harmonics)
        lowest = -float(self.dimension)
        if m > 0 and math.isinf(self.law.lowest_power):
            lowest -= 1.0
        allowed = f"for m = {m} it must be above {lowest:g}, and at most {_HIGHEST_POWER:g}"
        p = real_number("p", p, math.nextafter(lowest, 0.0), _HIGHEST_POWER, allowed)
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
        order = np.argsort(np.abs(across))  # the closest to the ray, and some of all others
        seen = np.union1d(order[:_LOOKED_AT], order[:: 1 + order.size // _LOOKED_AT])
        with np.errstate(invalid="ignore"):
            unsure = np.abs(found[seen] - coarse.density(along[seen], across[seen]))
        allowed = min(max(_DENSITY_RATIO * self.rtol, _BEST_DENSITY), _WORST_DENSITY)
        missed = float(np.nanmax(unsure, initial=0.0) / fine.harmonics[0].max())
        if missed > allowed:
            text = f"vdf: the error estimate {missed:.1e} exceeds {allowed:.1e}, at low speeds or"
            warnings.warn(f"{text} close to the ray along the field", ToleranceWarning, 3)
        return found.reshape(v_.size, phi.size)

    @cached_property
    def _fine(self) -> Steady:
        """Where it was not kept, as in a loaded or pickled state, it is solved again."""
        return Steady(_system(self.law), Resolution(*self._resolution))

    @cached_property
    def _densities(self) -> tuple[SteadyDensity, SteadyDensity]:
        """A coarser solution for the density, and a finer one."""
        return densities(self.law, self.rtol, self._resolution[2])

    # -- one's own units --------------------------------------------------------------------------

    def in_units(self, acceleration: float, diameter: float, number_density: float) -> FieldUnits:
        """The figures for a field g, grains and scatterers of diameter d, and their density.

        In any consistent units: with m/s^2, m and 1/m^3 (1/m^2 for disks) the results are in m and
        s. Raises InputError unless all are finite numbers above 0.
        """
        g = check_positive("acceleration", acceleration)
        d = check_positive("diameter", diameter)
        rho = check_positive("number_density", number_density)
        path = self.law.mean_free_path(rho, d)
        speed, time = math.sqrt(g * path), math.sqrt(path / g)
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

    # -- how it shows itself ----------------------------------------------------------------------

    _points, _on_demand = ("speeds", "angles"), ("vdf",)

    def _dataset(self, only: Collection[str] | None = None, **points: Any) -> Any:
        """Points: speeds in sqrt(g l), angles to the field in radians."""
        asked = ("restitution", "tangential_restitution", "dimension")
        about = {"law": self.law.described, **{name: getattr(self, name) for name in asked}}
        title = f"Steady state in a uniform field: {self.law.described}; units l = g = 1"
        units = "sqrt(g l)", "1/(g l)" if self.dimension == 2 else "(g l)^(-3/2)"
        points = {"speeds": _SPEEDS, "angles": _ANGLES} | points
        return velocity_dataset(self, title, about, _FIGURES, only, **points, units=units)

    def __repr__(self) -> str:
        return (
            f"FieldState({self.law.described}, rtol={self.rtol:g}), speeds in sqrt(g l)\n"
            f"  drift = {self.drift:.12g}, <v^2> = {self.mean_square_speed:.12g}, "
            f"<v_x^2> = {self.mean_square_along:.12g}, <v> = {self.mean_speed:.12g}\n"
            f"  error estimate {self.error_estimate:.1e}, {self.status.name.lower()}: "
            f"{self.message}"
        )


@dataclass(frozen=True)
class FieldUnits(Value):
    """The steady state in one's own units of length and time; made by `FieldState.in_units`.

    Attributes
    ----------
    mean_free_path : l
    time : sqrt(l/g), in which the drift is reached
    drift : the percolation velocity, along the field
    root_mean_square_speed : sqrt(<v^2>)
    collision_rate : collisions in the unit of time
    diffusion_parallel, diffusion_perpendicular : about the drift, length^2/time
    """

    mean_free_path: float
    time: float
    drift: float
    root_mean_square_speed: float
    collision_rate: float
    diffusion_parallel: float
    diffusion_perpendicular: float


@one_blas_thread
def solve_field(
    restitution: float | CollisionLaw,
    dimension: int = 2,
    tangential_restitution: float = 1.0,
    rtol: float = 1e-10,
    mass_ratio: float = math.inf,
) -> FieldState:
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
        allowed = (
            "it must be below 1: elastic tracers keep the energy that the field gives them, and "
            "reach no steady state"
        )
        refuse("restitution", restitution, allowed)
    fine, error = refined(_system(law), rtol)
    status, message = judged({"averages": error}, {"averages": rtol})
    one, top = fine.resolution, fine.axis.top
    figures: Any = np.insert(fine.figures[2:7], 1, fine.average(2.0, 0))
    state = FieldState(
        **law.arguments,
        rtol=rtol,
        **dict(zip(_FIGURES, figures.tolist(), strict=True)),
        error_estimate=error,
        status=status,
        message=message,
        plan=(
            PlanStep("angular harmonics", True, f"0 to {one.harmonics}"),
            PlanStep("speeds", True, f"{one.nodes} points up to {top:.3g} sqrt(g l)"),
            PlanStep("dispersion", True, "the linear response to the velocity"),
        ),
        stats={"harmonics": one.harmonics, "nodes": one.nodes, "highest_speed": top},
        _resolution=astuple(one),
    )
    state.__dict__["_fine"] = fine  # as if asked for
    return state


def _system(law: CollisionLaw) -> System:
    return System(law, law.dimension, field=1.0)
