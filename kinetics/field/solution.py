"""solve_field and its answer: the steady state of a tracer in a uniform field."""

from __future__ import annotations

import math
import warnings
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kinetics.collision import CollisionLaw, law_of
from kinetics.errors import ToleranceWarning, warn_missed
from kinetics.field.resolution import Resolution
from kinetics.field.steady import Dispersion, SteadyState, find_dispersion, find_steady_state
from kinetics.field.steady_density import SteadyDensity
from kinetics.numerics import FloatArray
from kinetics.numerics.threads import one_blas_thread
from kinetics.results import Result, Value, dataset, variable
from kinetics.status import PlanStep, SolverStatus, explain, status_of
from kinetics.validation import (
    check_positive,
    check_rtol,
    finite_line,
    real_number,
    refuse,
    speeds,
    whole_number,
)

_BEST_DIFFUSION = 1e-8
_HIGHEST_POWER = 20.0
_BEST_DENSITY, _WORST_DENSITY = 1e-6, 1e-2
_SPEEDS = np.linspace(0.0, 4.0, 161)[1:]
_ANGLES = np.array([0.0, 0.5, 1.0]) * np.pi
_FIGURES = {
    "drift": ("sqrt(g l)", "<v_x>, the percolation velocity", False),
    "mean_square_speed": ("g l", "<v^2>", False),
    "mean_square_along": ("g l", "<v_x^2>", False),
    "mean_speed": ("sqrt(g l)", "<v>", False),
    "diffusion_parallel": ("sqrt(g l^3)", "half the growth of the variance along the field", True),
    "diffusion_perpendicular": ("sqrt(g l^3)", "the same in one direction across the field", True),
}
"""Figures -> unit, words, and whether they are solved when they are asked for."""
_DENSITY_RATIO = 300.0  # harmonics that are enough for averages leave more


@dataclass(frozen=True)
class FieldState(Result):
    """The steady state in a uniform field, in the limit of low density; made by `solve_field`.

    Lengths in the mean free path l, accelerations in that of the field, g: so speeds are in
    sqrt(g l), times in sqrt(l/g), and diffusion coefficients in sqrt(g l^3). The field is along x.
    :meth:`in_units` gives the figures in one's own units.

    Attributes
    ----------
    restitution, tangential_restitution, dimension, rtol : what was asked for
    drift : <v_x>, the percolation velocity, in sqrt(g l)
    mean_square_speed : <v^2> in g l
    mean_square_along : <v_x^2> in g l
    mean_speed : <v> in sqrt(g l): the number of collisions in a time sqrt(l/g)
    error_estimate : relative error of drift, mean_square_speed, mean_square_along and mean_speed
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
    error_estimate: float
    status: SolverStatus
    message: str
    plan: tuple[PlanStep, ...]
    stats: Mapping[str, Any]
    _resolution: tuple[float, int] = field(repr=False)

    @cached_property
    def law(self) -> CollisionLaw:
        """The collision law."""
        return law_of(self.restitution, self.tangential_restitution, self.dimension)

    # -- averages ---------------------------------------------------------------------------------

    def moment(self, p: float, m: int = 0) -> float:
        """<v^p cos(m phi)> in (g l)^(p/2), phi the angle to the field; in space <v^p P_m(cos phi)>.

        p is real, above -d and up to 20; above -d - 1 where m > 0 and no bounce stops the tracer.
        The error is about ``error_estimate`` for p from 0 to 4 and m up to 2. Raises InputError.
        """
        m = whole_number("m", m, 0, self._steady.averages.harmonics.shape[0] - 1)
        lowest = -float(self.dimension)
        if m > 0 and math.isinf(self.law.lowest_power):
            lowest -= 1.0
        allowed = f"for m = {m} it must be above {lowest:g}, and at most {_HIGHEST_POWER:g}"
        p = real_number("p", p, math.nextafter(lowest, 0.0), _HIGHEST_POWER, allowed)
        return self._steady.averages.moment(p, m)

    def vdf(self, v: ArrayLike, angle: ArrayLike) -> FloatArray:
        """The density of the velocity, shape (n_v, n_angle), in (g l)^(-d/2); its integral is 1.

        v : speeds in sqrt(g l), above 0; angle : to the field, in radians. InputError for others.

        What tracers bring along their last free flight. Its error, relative to the largest mean
        over directions, is below 300 rtol, but never asked to be below 1e-6 nor allowed above 1e-2;
        else a ToleranceWarning says so. At e = 0 the density grows as a logarithm towards the ray
        along the field, and is infinite on it.
        """
        v_, phi = speeds(v, zero_allowed=False), finite_line("angle", angle)
        along, across = np.outer(v_, np.cos(phi)), np.outer(v_, np.sin(phi))
        found, unsure = self._density(along.ravel(), across.ravel())
        allowed = min(max(_DENSITY_RATIO * self.rtol, _BEST_DENSITY), _WORST_DENSITY)
        missed = unsure / float(self._steady.averages.harmonics[0].max())
        if missed > allowed:
            text = f"vdf: the error estimate {missed:.1e} exceeds {allowed:.1e}, at low speeds or"
            warnings.warn(f"{text} close to the ray along the field", ToleranceWarning, 2)
        return found.reshape(along.shape)

    @cached_property
    def _density(self) -> SteadyDensity:
        return SteadyDensity(self._steady, self._steady.averages.harmonics)

    # -- dispersion -------------------------------------------------------------------------------

    @property
    def diffusion_parallel(self) -> float:
        """Half the growth rate of the variance along the field, in sqrt(g l^3); solved when asked.

        Its error is at most max(rtol, 1e-8), else a ToleranceWarning says so.
        """
        self._warn()
        return self._dispersion.parallel

    @property
    def diffusion_perpendicular(self) -> float:
        """The same for one direction across the field."""
        self._warn()
        return self._dispersion.perpendicular

    @cached_property
    def _dispersion(self) -> Dispersion:
        return find_dispersion(self._steady, max(self.rtol, _BEST_DIFFUSION))

    def _warn(self) -> None:
        allowed = max(self.rtol, _BEST_DIFFUSION)
        if self._dispersion.error > allowed:
            warn_missed("diffusion coefficients", self._dispersion.error, allowed)

    @cached_property
    def _steady(self) -> SteadyState:
        """Where it was not kept, as in a loaded or pickled state, it is solved again."""
        return SteadyState(self.law, Resolution(*self._resolution))

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

    _points, _on_demand = ("speeds", "angles"), (*_FIGURES, "vdf")

    def _dataset(self, only: Collection[str] | None = None, **points: Any) -> Any:
        """Points: speeds in sqrt(g l), angles to the field in radians."""
        found: dict[str, Any] = {}
        for name, (units, words, on_demand) in _FIGURES.items():
            if only is None or name in only or not on_demand:
                found[name] = variable((), getattr(self, name), units, words)
        v = finite_line("speeds", points.get("speeds", _SPEEDS))
        phi = finite_line("angles", points.get("angles", _ANGLES))
        if only is None or "vdf" in only:
            units = "1/(g l)" if self.dimension == 2 else "(g l)^(-3/2)"
            f = self.vdf(v, phi).T
            found["vdf"] = variable(("angle", "v"), f, units, "density of the velocity", "f")
        asked = ("restitution", "tangential_restitution", "dimension")
        return dataset(
            f"Steady state in a uniform field: {self.law.described}; units l = g = 1",
            {"law": self.law.described, **{name: getattr(self, name) for name in asked}},
            found,
            {
                "v": variable(("v",), v, "sqrt(g l)", "speed"),
                "angle": variable(("angle",), phi, "rad", "angle to the field"),
            },
            status=self.status.name.lower(),
            message=self.message,
            tolerance_asked=self.rtol,
            tolerance_reached=self.error_estimate,
        )

    def _figures(self) -> dict[str, str]:
        found = {n: f"{getattr(self, n):.12g} {u}" for n, (u, _, on_demand) in _FIGURES.items()
                 if not on_demand}  # fmt: skip
        return found | {"status": f"{self.status.name.lower()}: {self.message}"}

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
) -> FieldState:
    """The steady state of a tracer among fixed scatterers in a uniform field, at low density.

    Parameters
    ----------
    restitution : e, 0 <= e < 1; or a :class:`kinetics.CollisionLaw`
    dimension : 2 (disks) or 3 (spheres)
    tangential_restitution : et in [0, 1]; 1 for smooth scatterers
    rtol : relative accuracy asked of drift, <v^2>, <v_x^2> and <v>, 1e-14 to 0.1

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
    law = law_of(restitution, tangential_restitution, dimension)
    if law.is_elastic:
        allowed = (
            "it must be below 1: elastic tracers keep the energy that the field gives them, and "
            "reach no steady state"
        )
        refuse("restitution", restitution, allowed)
    found = find_steady_state(law, rtol)
    errors = {"speeds": found.speed_error, "angular harmonics": found.harmonic_error}
    allowed_errors = dict.fromkeys(errors, rtol)
    resolution = found.resolution
    state = FieldState(
        **law.arguments,
        rtol=rtol,
        **dict(zip(_FIGURES, found.averages.figures.tolist(), strict=False)),
        error_estimate=found.error,
        status=status_of(errors, allowed_errors),
        message=explain(errors, allowed_errors),
        plan=_plan(found),
        stats=_stats(found),
        _resolution=(resolution.speed, resolution.harmonics),
    )
    state.__dict__["_steady"] = found  # as if it had been asked for
    return state


def _plan(found: SteadyState) -> tuple[PlanStep, ...]:
    """Which harmonics and panels were used, and why."""
    panels, powers = found.panels, found.powers
    why = "a bounce may nearly stop a tracer" if powers[0] == 1.0 else "rays through rest"
    return (
        PlanStep(
            "angular harmonics",
            True,
            f"0 to {found.highest}, continued by m^-{powers[0]:g} and m^-{powers[1]:g} ({why}); "
            f"another continuation changes the averages by {found.harmonic_error:.1e}",
        ),
        PlanStep(
            "speeds",
            True,
            f"{len(panels.counts)} panels from rest to {panels.highest:.3g} sqrt(g l), the first "
            f"to {panels.edges[1]:.2g} (what it holds is negligible), {panels.size} nodes; "
            f"exact relations between averages are missed by {found.speed_error:.1e}",
        ),
        PlanStep("dispersion", False, "solved when it is asked for"),
    )


def _stats(found: SteadyState) -> dict[str, Any]:
    return {
        "harmonics": found.highest,
        "panels": len(found.panels.counts),
        "nodes": found.panels.size,
        "highest_speed": found.panels.highest,
        "speed_error": found.speed_error,
        "harmonic_error": found.harmonic_error,
    }
